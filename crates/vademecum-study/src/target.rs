//! Sections that a scenario needs: a stripped file without them is refused before it is shipped.

use vademecum_format::{File, SectionKind};

use crate::contents::lines;
use crate::error::FileError;
use crate::scenario::{FieldChoice, Scenario};

/// Checks that `bytes` can play `scenario` and write its output.
///
/// # Errors
/// [`FileError::Needed`]: the first thing that is missing; [`FileError::Format`].
pub fn check_target(bytes: &[u8], scenario: &Scenario) -> Result<(), FileError> {
    use SectionKind as S;
    let file = File::parse(bytes)?;
    let metadata = file.metadata();
    let need = |kinds: &[SectionKind], what: &str| match kinds.iter().find(|&&k| file.section(k).is_none()) {
        None => Ok(()),
        Some(&kind) => Err(FileError::Needed { kind, what: what.to_string() }),
    };
    let surface = [S::NodeCoordinates, S::Triangles, S::SurfaceBasis];
    if !scenario.contacts.is_empty() {
        need(&surface, "a contact")?;
        if metadata.block {
            need(&[S::BlockLoad], "a contact in the block structure")?;
        }
    }
    for pattern in &scenario.patterns {
        let what = format!("load pattern `{}`", pattern.name);
        need(&[S::PatternBasis, S::PatternNames], &what)?;
        if metadata.block {
            need(&[S::PatternBlock], &what)?;
        }
        if !lines(&file, S::PatternNames)?.contains(&pattern.name) {
            return Err(FileError::Needed { kind: S::PatternNames, what });
        }
    }
    if scenario.output.fields_every > 0 {
        need(&surface, "a field on the surface")?;
        let inside = metadata.n_nodes > metadata.n_surface_nodes;
        if scenario.output.fields == FieldChoice::Body && inside {
            need(&[S::InteriorBasis], "a field inside the body")?;
        }
    }
    if !scenario.output.probes.is_empty() {
        need(&[S::NodeCoordinates, S::SurfaceBasis], "a probe of its own")?;
    }
    if metadata.n_probes > 0 {
        need(&[S::ProbeRows, S::ProbeNames], "a probe")?;
    }
    Ok(())
}
