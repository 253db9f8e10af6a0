//! Measurements of the chapter's structure, as a report shows them.

use vademecum_build::certificate::{FileFigures, StructureReport};
use vademecum_build::report::{ChapterReport, StageReport};
use vademecum_format::{Chapter, File, FormatError, SectionKind, StructureCertificate};

use crate::certificate::ChapterCertificate;
use crate::separation::StageError;

/// The report of what a build measured.
pub fn report_of(c: &ChapterCertificate) -> ChapterReport {
    let stage = |(e, &terms): (&StageError, &usize)| StageReport {
        terms,
        error: e.total,
        state_error: e.state,
        load_error: e.load,
    };
    ChapterReport {
        structure: StructureReport::measured(&c.structure),
        left_at: c.left.map(|(step, _)| step),
        stages: c.stages.iter().zip(&c.terms).map(stage).collect(),
    }
}

/// The report of what a file holds; `None` if it does not have the structure.
///
/// # Errors
/// [`FormatError`] if a section is compressed or malformed.
pub fn report_of_file(file: &File<'_>) -> Result<Option<ChapterReport>, FormatError> {
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
    let terms = |stage| canonical.parts().filter(|part| part.stage == stage).map(|part| part.n_terms).sum();
    let stage = |(stage, e): (usize, &[f64; 3])| StageReport {
        terms: terms(stage),
        error: e[0],
        state_error: e[1],
        load_error: e[2],
    };
    Ok(Some(ChapterReport {
        structure: StructureReport::new(&structure, &figures),
        left_at: (*left >= 1.0).then_some(*left as usize),
        stages: stages.as_chunks().0.iter().enumerate().map(stage).collect(),
    }))
}
