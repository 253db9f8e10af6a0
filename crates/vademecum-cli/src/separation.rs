//! What a file keeps of the making of its separated solution, for people: sections 21, 22 and 31.

use std::path::Path;

use serde::Serialize;
use vademecum_build::parametric::RadiusSample;
use vademecum_format::{File, FormatError, SectionKind};
use vademecum_rewrite::{DECODED_LIMIT, decode};

use crate::failure::Failure;

/// What an enrichment reached.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Enrichment {
    /// Terms after it.
    pub terms: u32,
    /// Relative error they leave at fresh points.
    pub error: f64,
}

/// The enrichments of the separated solution, in order; none if the file does not keep them.
pub fn enrichment_history(path: &Path, file: &File<'_>) -> Result<Vec<Enrichment>, Failure> {
    let values = values(path, file, SectionKind::EnrichmentHistory)?;
    Ok(values.as_chunks().0.iter().map(|&[terms, error]| Enrichment { terms: terms as u32, error }).collect())
}

/// The spectral radius at points of the parameters' box; none if the file does not keep it.
pub fn radius_samples(path: &Path, file: &File<'_>) -> Result<Vec<RadiusSample>, Failure> {
    let n_parameters = file.metadata().active_parameters().len();
    let sample = |row: &[f64]| {
        let (values, radius) = row.split_at(n_parameters);
        RadiusSample { values: values.to_vec(), spectral_radius: radius[0] }
    };
    let rows = values(path, file, SectionKind::RadiusSamples)?;
    Ok(rows.chunks_exact(n_parameters + 1).map(sample).collect())
}

/// What the build did to make an unstable step stable, one repair a line; none if nothing had to be.
pub fn repairs(path: &Path, file: &File<'_>) -> Result<Vec<String>, Failure> {
    let Some(section) = file.section(SectionKind::Repairs) else { return Ok(vec![]) };
    let bytes = decode(&section, DECODED_LIMIT).map_err(|error| Failure::file(path, error))?;
    let unreadable = |_| Failure::file(path, FormatError::Text { kind: SectionKind::Repairs.number() });
    let text = String::from_utf8(bytes).map_err(unreadable)?;
    Ok(text.lines().map(str::to_string).collect())
}

/// Numbers of a section, compressed or not; none if the file does not have it.
fn values(path: &Path, file: &File<'_>, kind: SectionKind) -> Result<Vec<f64>, Failure> {
    let Some(section) = file.section(kind) else { return Ok(vec![]) };
    let bytes = decode(&section, DECODED_LIMIT).map_err(|error| Failure::file(path, error))?;
    Ok(bytes.as_chunks().0.iter().map(|&number| f64::from_le_bytes(number)).collect())
}
