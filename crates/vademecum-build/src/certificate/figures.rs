//! What is measured of a structure beside its certificate: the run farthest above its floor, how far from
//! reciprocal the structure is, and how much energy a free motion can gain.
//!
//! The block structure projects the full-order step, `BᵀM (M + θK)⁻¹`. A force enters through the rows of
//! `BᵀM (M + θK)⁻¹` and a displacement leaves through those of `B`, which are another matrix unless the basis
//! is invariant (natural modes). So the displacement at one place under a force at another is not quite the
//! reverse (Maxwell and Betti), and the energy of `Bζ` is not quite the work done. The diagonal structure is
//! a Galerkin projection: it has neither fault.

use vademecum_format::{File, FormatError, SectionKind};

/// Numbers of one structure.
pub(crate) const FIGURES: usize = 3;

/// Figures of a structure that the metadata of a file have no place for; NaN where nothing was measured.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Figures {
    /// Largest error ÷ floor of any run; the largest error may be another run's.
    pub(crate) floor_ratio: f64,
    /// Defect of reciprocity: `‖h_ab − h_ba‖ ÷ ‖h_ab‖` over pairs of unseen loads and all steps, with `h_ab`
    /// the displacement along load `a` under load `b`.
    pub(crate) reciprocity: f64,
    /// Largest energy of the free motions that the unseen loads left, over the energy at their start, seen at
    /// 320 instants of a million steps.
    pub(crate) energy_growth: f64,
}

impl Default for Figures {
    /// Nothing measured.
    fn default() -> Self {
        Self::from_numbers([f64::NAN; FIGURES])
    }
}

impl Figures {
    /// In order.
    #[must_use]
    pub fn numbers(&self) -> [f64; FIGURES] {
        [self.floor_ratio, self.reciprocity, self.energy_growth]
    }

    /// From their order in the file.
    #[must_use]
    pub(crate) fn from_numbers([floor_ratio, reciprocity, energy_growth]: [f64; FIGURES]) -> Self {
        Self { floor_ratio, reciprocity, energy_growth }
    }

    /// The larger of each; not measured as soon as one was not.
    #[must_use]
    pub(crate) fn worse(&self, other: &Self) -> Self {
        let (a, b) = (self.numbers(), other.numbers());
        Self::from_numbers(std::array::from_fn(|i| larger(a[i], b[i])))
    }
}

/// A number, or NaN where it is infinite: what overflowed was not measured.
pub(super) fn finite(number: f64) -> f64 {
    if number.is_finite() { number } else { f64::NAN }
}

/// The larger of two numbers; NaN as soon as one is.
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

/// The figures of every structure of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FileFigures {
    /// Of the diagonal structure.
    pub diagonal: Figures,
    /// Of the block structure.
    pub block: Figures,
    /// Of the chapter's structure.
    pub chapter: Figures,
}

impl FileFigures {
    /// In the order of the file, shape (3, `FIGURES`).
    #[must_use]
    pub fn numbers(&self) -> Vec<f64> {
        [self.diagonal, self.block, self.chapter].iter().flat_map(Figures::numbers).map(finite).collect()
    }

    /// From their order in the file; nothing measured if they are too few.
    #[must_use]
    pub fn from_numbers(numbers: &[f64]) -> Self {
        let row =
            |row| numbers.as_chunks().0.get(row).map_or_else(Figures::default, |&r| Figures::from_numbers(r));
        Self { diagonal: row(0), block: row(1), chapter: row(2) }
    }

    /// Of a file; nothing measured if it was written before version 1.2, or without them.
    ///
    /// # Errors
    /// [`FormatError`]: a section that is compressed.
    pub fn of_file(file: &File<'_>) -> Result<Self, FormatError> {
        let Some(section) = file.section(SectionKind::StructureFigures) else { return Ok(Self::default()) };
        Ok(Self::from_numbers(&section.numbers()?.iter().collect::<Vec<_>>()))
    }
}
