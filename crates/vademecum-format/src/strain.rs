//! The strain structure: a body whose strain is a quadratic map of its coordinates, for large displacements.
//!
//! Of the `r` coordinates the first `n` interact, the next `n₁` couple with them, and the others, the tail,
//! are linear. The file has `m` strain rows: `n + n₁` leading ones, one for each tail coordinate, and others
//! without linear part.

use crate::error::{FormatError, Quantity};
use crate::metadata::Metadata;
use crate::read::File;
use crate::section::{Codec, SectionKind};

/// Most strain rows of a file.
pub const MAX_STRAIN_ROWS: u32 = 65_536;

/// Most sub-steps of a step.
pub const MAX_SUBSTEPS: u32 = 1024;

/// How many coordinates and rows the strain structure has.
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

    /// The sizes a file announces; `None` for a file without the structure.
    ///
    /// # Errors
    /// Refusals 13 and 28.
    pub fn read(file: &File<'_>) -> Result<Option<Self>, FormatError> {
        let Some(section) = file.section(SectionKind::StrainSizes) else { return Ok(None) };
        let mut numbers = [0; 4];
        numbers.iter_mut().zip(section.u32s()?).for_each(|(out, &bytes)| *out = u32::from_le_bytes(bytes));
        Self::new(numbers, file.metadata()).map(Some)
    }

    fn new([n, coupled, rows, substeps]: [u32; 4], metadata: &Metadata<'_>) -> Result<Self, FormatError> {
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

    /// Refusals 13, 25 and 26 of a file; left for later where the sizes are compressed.
    pub(crate) fn check(file: &File<'_>) -> Result<(), FormatError> {
        use SectionKind as S;
        if file.section(S::StrainSizes).is_none_or(|section| section.codec() != Codec::Raw) {
            return Ok(());
        }
        let Some(sizes) = Self::read(file)? else { return Ok(()) };
        let (r, leading, tail) = (sizes.coordinates as u64, sizes.leading() as u64, sizes.tail() as u64);
        let shapes = [
            (S::StrainLinear, [r, leading, 1], true),
            (S::StrainTail, [tail, 1, 1], tail > 0),
            (S::StrainQuadratic, [sizes.rows as u64, sizes.pairs() as u64, 1], true),
        ];
        for (kind, expected, needed) in shapes {
            let Some(section) = file.section(kind) else {
                if needed {
                    return Err(FormatError::Missing { kind: kind.number() });
                }
                continue;
            };
            for (axis, (&found, expected)) in section.shape().iter().zip(expected).enumerate() {
                if found != expected {
                    let (kind, axis) = (kind.number(), axis as u8);
                    return Err(FormatError::Shape { kind, axis, found, expected });
                }
            }
        }
        Ok(())
    }
}
