//! The strain structure: a body whose strain is a quadratic map of its coordinates, for large displacements.
//!
//! Of the `r` coordinates the first `n` interact, the next `n₁` couple with them, and the others, the tail,
//! are linear. The file has `m` strain rows: `n + n₁` leading ones, one for each tail coordinate, and others
//! without linear part.

use crate::error::{FormatError, Quantity};
use crate::kind::SectionKind;
use crate::metadata::Metadata;

/// Most strain rows of a file.
pub const MAX_STRAIN_ROWS: u32 = 65_536;

/// Most sub-steps of a step.
pub const MAX_SUBSTEPS: u32 = 1024;

/// Numbers of coordinates and rows of the strain structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StrainSizes {
    /// `n`: coordinates that interact.
    pub interacting: usize,
    /// `n₁`: coordinates that couple with these.
    pub coupled: usize,
    /// `m`: strain rows.
    pub rows: usize,
    /// `r`: coordinates.
    pub coordinates: usize,
    /// Sub-steps of a step, as built.
    pub substeps: usize,
}

impl StrainSizes {
    /// `n + n₁`: the coordinates that are no tail, and the leading rows.
    #[must_use]
    pub const fn leading(&self) -> usize {
        self.interacting + self.coupled
    }

    /// Coordinates of the tail, and their rows.
    #[must_use]
    pub const fn tail(&self) -> usize {
        self.coordinates.saturating_sub(self.leading())
    }

    /// Products of coordinates in a row: `a ≤ b < n`, then `a < n ≤ b < n + n₁`.
    #[must_use]
    pub const fn pairs(&self) -> usize {
        let n = self.interacting;
        n * (n + 1) / 2 + n * self.coupled
    }

    /// The products in the order of section 63.
    pub fn pair_list(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (n, leading) = (self.interacting, self.leading());
        let among = (0..n).flat_map(move |a| (a..n).map(move |b| (a, b)));
        among.chain((0..n).flat_map(move |a| (n..leading).map(move |b| (a, b))))
    }

    /// From the numbers of section 60.
    pub(crate) fn new(
        [n, coupled, rows, substeps]: [u32; 4],
        metadata: &Metadata<'_>,
    ) -> Result<Self, FormatError> {
        let r = metadata.n_modes;
        let counts = [
            (Quantity::Interacting, n, 1, r),
            (Quantity::Coupled, coupled, 0, r.saturating_sub(n)),
            (Quantity::StrainRows, rows, r, MAX_STRAIN_ROWS),
            (Quantity::Substeps, substeps, 1, MAX_SUBSTEPS),
        ];
        for (what, found, lower, upper) in counts {
            if found < lower || found > upper {
                return Err(FormatError::Count { what, found, lower, upper });
            }
        }
        let [interacting, coupled, rows, coordinates, substeps] =
            [n, coupled, rows, r, substeps].map(|n| n as usize);
        Ok(Self { interacting, coupled, rows, coordinates, substeps })
    }

    /// The other sections of the structure: their shapes, and whether a file needs them.
    pub(crate) fn shapes(&self) -> [(SectionKind, [u64; 3], bool); 3] {
        use SectionKind as S;
        let (r, leading, tail) = (self.coordinates as u64, self.leading() as u64, self.tail() as u64);
        [
            (S::StrainLinear, [r, leading, 1], true),
            (S::StrainTail, [tail, 1, 1], tail > 0),
            (S::StrainQuadratic, [self.rows as u64, self.pairs() as u64, 1], true),
        ]
    }
}
