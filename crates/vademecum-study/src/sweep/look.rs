//! Outcome of a job: its file is complete, and of this problem and this mesh, or not.

use std::collections::HashMap;
use std::error::Error;
use std::path::Path;

use serde::Serialize;
use vademecum_build::input::Problem;
use vademecum_build::mesh;
use vademecum_build::prepared::read_mesh;
use vademecum_format::{File, Metadata};

use crate::contents::mode_table;
use crate::error::FileError;

/// Outcome of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// The file is whole and belongs to the problem and its mesh.
    Done,
    /// There is no file.
    Missing,
    /// The file is not what was written.
    Damaged,
    /// The file was built from another problem.
    Foreign,
    /// The file was built from another mesh than the problem's file holds now, or that one cannot be read.
    Stale,
}

impl State {
    /// In a word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Missing => "missing",
            Self::Damaged => "damaged",
            Self::Foreign => "foreign",
            Self::Stale => "stale",
        }
    }
}

/// Figures of a finished file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// Length \[bytes\].
    pub file_bytes: usize,
    /// Modes.
    pub modes: u32,
    /// Step \[s\].
    pub time_step: f64,
    /// The lowest natural frequency \[Hz\]; none in a file without its table of modes.
    pub first_frequency_hz: Option<f64>,
    /// As certified: relative, over all dofs and steps, in the mass norm.
    pub trajectory_error: f64,
    /// Projection error.
    pub projection_floor: f64,
}

/// Hashes of the meshes of problems: a mesh that many jobs have is read once.
#[derive(Debug, Default)]
pub struct Meshes(HashMap<String, Result<[u8; 16], String>>);

impl Meshes {
    /// The hash of the mesh that files hold now, or why there is none; nothing where the text of the problem
    /// says the whole mesh, or matrices stand for it.
    fn hash(&mut self, problem: &Problem) -> Option<Result<[u8; 16], String>> {
        let source = &problem.mesh;
        if source.file.is_none() && source.tables.is_none() {
            return None;
        }
        let key = format!("{:?} {source:?}", problem.resolve(Path::new("")));
        let read = || match read_mesh(problem) {
            Ok(found) => Ok(mesh::hash(&found)),
            Err(error) => Err(with_causes(&error)),
        };
        Some(self.0.entry(key).or_insert_with(read).clone())
    }
}

/// Looks at the bytes of a job's file, if there are any, at the text of its problem file, which lies at
/// `path`, and at its mesh. The reason is empty where the state says all.
///
/// Takes as long as to read the mesh, where that is a file that was not read before.
pub fn look(
    bytes: Option<&[u8]>,
    text: &str,
    path: &Path,
    meshes: &mut Meshes,
) -> (State, String, Option<Outcome>) {
    let Some(bytes) = bytes else { return (State::Missing, String::new(), None) };
    match outcome(bytes, text, path, meshes) {
        Ok(Ok(outcome)) => (State::Done, String::new(), Some(outcome)),
        Ok(Err((state, reason))) => (state, reason, None),
        Err(error) => (State::Damaged, error.to_string(), None),
    }
}

/// Figures of a complete file of this problem, or the state of any other.
fn outcome(
    bytes: &[u8],
    text: &str,
    path: &Path,
    meshes: &mut Meshes,
) -> Result<Result<Outcome, (State, String)>, FileError> {
    let file = File::parse(bytes)?;
    file.verify_all()?;
    let metadata = file.metadata();
    if metadata.problem != text {
        return Ok(Err((State::Foreign, "it holds the text of another problem file".into())));
    }
    if let Err(reason) = is_of_mesh(metadata, path, meshes) {
        return Ok(Err((State::Stale, reason)));
    }
    let certificate = metadata.certificate;
    let (diagonal, block) = (certificate.diagonal, certificate.block);
    Ok(Ok(Outcome {
        file_bytes: bytes.len(),
        modes: metadata.n_modes,
        time_step: metadata.time_step,
        first_frequency_hz: mode_table(&file)?.first().map(|mode| mode.frequency_hz),
        // Not a number where a structure is not there.
        trajectory_error: diagonal.trajectory_error.max(block.trajectory_error),
        projection_floor: diagonal.projection_floor.max(block.projection_floor),
    }))
}

/// True if a file was built from the present mesh of its problem, which is at `path`; or the reason why not.
fn is_of_mesh(metadata: &Metadata<'_>, path: &Path, meshes: &mut Meshes) -> Result<(), String> {
    let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
    let problem = Problem::parse(metadata.problem, &path.display().to_string(), folder)
        .map_err(|error| with_causes(&error))?;
    match meshes.hash(&problem) {
        Some(Err(reason)) => Err(reason),
        Some(Ok(hash)) if hash != metadata.mesh_hash => Err("it was built from another mesh".into()),
        _ => Ok(()),
    }
}

/// An error and its causes in one line.
fn with_causes(error: &dyn Error) -> String {
    let mut words = error.to_string();
    let mut source = error.source();
    while let Some(cause) = source {
        words.push_str(&format!(": {cause}"));
        source = cause.source();
    }
    words
}
