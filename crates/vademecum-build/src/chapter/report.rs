//! What was measured of the chapter's structure, as a report shows it.

use vademecum_format::{Chapter, File, FormatError, SectionKind, StructureCertificate};

use super::certificate::ChapterCertificate;
use super::separation::StageError;
use crate::certificate::{FileFigures, StructureReport};

/// The canonical structure's certificate as a report shows it.
#[derive(Clone, Debug, serde::Serialize)]
pub struct ChapterReport {
    /// As of the other structures, over the steps before `left_at`.
    #[serde(flatten)]
    pub structure: StructureReport,
    /// The step at which a trajectory left an axis.
    pub left_at: Option<usize>,
    /// Per stage: terms, and the relative error of its map over random points.
    pub stages: Vec<StageReport>,
}

/// One stage of the canonical structure.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct StageReport {
    /// Terms.
    pub terms: usize,
    /// Error of the map, root mean square relative to it.
    pub error: f64,
    /// Of its state part, relative to that.
    pub state_error: f64,
    /// Of its load part, relative to that.
    pub load_error: f64,
}

impl ChapterReport {
    /// From what a build measured.
    pub fn new(c: &ChapterCertificate) -> Self {
        let stage = |(e, &terms): (&StageError, &usize)| StageReport {
            terms,
            error: e.total,
            state_error: e.state,
            load_error: e.load,
        };
        Self {
            structure: StructureReport::measured(&c.structure),
            left_at: c.left.map(|(step, _)| step),
            stages: c.stages.iter().zip(&c.terms).map(stage).collect(),
        }
    }

    /// From what a file holds; `None` if it does not have the structure.
    ///
    /// # Errors
    /// [`FormatError`] if a section is compressed or malformed.
    pub fn of_file(file: &File<'_>) -> Result<Option<Self>, FormatError> {
        let (Some(canonical), Some(section)) =
            (Chapter::read(file)?, file.section(SectionKind::CanonicalCertificate))
        else {
            return Ok(None);
        };
        let numbers: Vec<f64> = section.numbers()?.iter().collect();
        let (structure, rest) = numbers.split_first_chunk().expect("the shape was checked on opening");
        let (left, stages) = rest.split_first().expect("the shape was checked on opening");
        let structure = StructureCertificate::from_numbers(*structure);
        let figures = FileFigures::of_file(file)?.chapter;
        let terms =
            |stage| canonical.parts().filter(|part| part.stage == stage).map(|part| part.n_terms).sum();
        let stage = |(stage, e): (usize, &[f64; 3])| StageReport {
            terms: terms(stage),
            error: e[0],
            state_error: e[1],
            load_error: e[2],
        };
        Ok(Some(Self {
            structure: StructureReport::new(&structure, &figures),
            left_at: (*left >= 1.0).then_some(*left as usize),
            stages: stages.as_chunks().0.iter().enumerate().map(stage).collect(),
        }))
    }
}
