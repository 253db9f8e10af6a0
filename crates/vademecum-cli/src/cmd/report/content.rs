//! Everything the page shows.

use std::path::Path;

use vademecum_build::certificate::FileFigures;
use vademecum_build::dynamics::ModeRow;
use vademecum_build::parametric::RadiusSample;
use vademecum_format::{File, SectionKind};
use vademecum_study::FileError;
use vademecum_study::contents::{is_si, lines, numbers};
use vademecum_study::free_run::FreeRun;
use vademecum_study::separation::Enrichment;
use vademecum_study::timings::Timings;
use vademecum_study::verify::AnyVerification;

use super::build_times::BuildTimes;
use crate::failure::Failure;

/// Everything the page shows.
pub(crate) struct Content<'a> {
    /// Title of the page.
    pub(crate) title: String,
    /// The command that wrote the page.
    pub(crate) command: String,
    /// The file.
    pub(crate) path: &'a Path,
    /// Its length.
    pub(crate) bytes: usize,
    /// The file.
    pub(crate) file: &'a File<'a>,
    /// The file as it is on the disk, packed or not.
    pub(crate) stored: &'a File<'a>,
    /// Its modes.
    pub(crate) modes: Vec<ModeRow>,
    /// Name of the structure that a scene takes.
    pub(crate) structure: &'static str,
    /// Times of the online work on this machine, if they were asked for.
    pub(crate) timings: Option<Timings>,
    /// A long free run.
    pub(crate) free: FreeRun,
    /// The full-order march beside it, if one was asked for.
    pub(crate) verified: Option<AnyVerification>,
    /// Error over the number of terms.
    pub(crate) history: Vec<Enrichment>,
    /// The spectral radius over the box of the parameters.
    pub(crate) radii: Vec<RadiusSample>,
    /// Figures of each structure beside its certificate.
    pub(crate) figures: FileFigures,
    /// Repairs.
    pub(crate) repairs: Vec<String>,
    /// Times of the build, if known.
    pub(crate) build: Option<BuildTimes>,
}

impl Content<'_> {
    /// Numbers of a section; none if the file does not have it.
    pub(crate) fn numbers(&self, kind: SectionKind) -> Result<Vec<f64>, Failure> {
        numbers(self.file, kind).map_err(|error| Failure::file(self.path, error))
    }

    /// Unit of lengths; empty of a file in units that are not known.
    pub(crate) fn length_unit(&self) -> &'static str {
        if is_si(self.file) { "m" } else { "" }
    }

    /// Names of probes or patterns, in one line.
    pub(crate) fn listed(&self, kind: SectionKind) -> Result<String, FileError> {
        let names = lines(self.file, kind)?;
        Ok(if names.is_empty() { "none".into() } else { names.join(", ") })
    }
}
