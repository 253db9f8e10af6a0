//! Long work: builds, runs, verifications, natural modes, and the program itself.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use vademecum_build::mesh::{CELLS, inspect, parse};
use vademecum_build::mesh_error::DiscRequest;
use vademecum_build::pipeline::BuildOptions;
use vademecum_build::prepared::prepare;
use vademecum_build::progress::Stopwatch;
use vademecum_build::store::Store;
use vademecum_cli::Failure;
use vademecum_eval::SceneOptions;
use vademecum_format::File;
use vademecum_rewrite::default_limit;
use vademecum_study::StudyError;
use vademecum_study::frf::{
    Channel, FREQUENCIES, POINTS, Quantity, ResponseRequest, frequencies, frequency_response, with_poles,
};
use vademecum_study::live::prepared_at;
use vademecum_study::modes::natural_modes;
use vademecum_study::player::PlayOptions;
use vademecum_study::run::{Moment, Run};
use vademecum_study::soundness::check_file;
use vademecum_study::starter::{NamedMaterial, SMALLEST_PART, StarterOptions, starter};
use vademecum_study::state_space::{OutputSignal, StateSpace, StateSpaceRequest};
use vademecum_study::verify::verify as verified;

use crate::arrays::owned;
use crate::content::Content;
use crate::file::PyFile;
use crate::options::{Asked, asked};
use crate::problem::Given;
use crate::refusal::Refusal;
use crate::watch::{Told, watched};

/// A value as a text in JSON, in which what is no number is `null`.
fn json(value: &impl serde::Serialize) -> Result<String, Refusal> {
    serde_json::to_string(value).map_err(|error| Refusal::usage(error.to_string()))
}

/// Settings of [`build`], by their names in Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Settings {
    work: Option<PathBuf>,
    fresh: bool,
    repair: bool,
    long: bool,
    keep_missed: bool,
    memory: Option<u64>,
}

/// A file built from a problem, and the report of the build.
#[pyfunction]
pub fn build(
    py: Python<'_>,
    problem: Given,
    settings: Settings,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<(PyFile, String)> {
    let (content, report) = watched(py, Told { progress, warn: false }, |listener| {
        let problem = problem.problem()?;
        let store = settings.work.as_ref().map(|folder| Store::new(folder, settings.fresh));
        let Settings { repair, long, memory, .. } = settings;
        let options = BuildOptions { store: store.as_ref(), repair, long, memory, ..BuildOptions::default() };
        let outcome = vademecum_chapter::build(&problem, &options, listener)?;
        let built = if settings.keep_missed { outcome.either() } else { outcome.kept()? };
        Ok((Content::given(Path::new("built.vdm"), built.bytes)?, json(&built.report)?))
    })?;
    Ok((PyFile { content: Arc::new(content), path: "built.vdm".into() }, report))
}

/// Result of a run.
#[derive(Default)]
struct Shown {
    times: Vec<f64>,
    energy: Vec<f64>,
    probes: Vec<f64>,
    reactions: Vec<f64>,
    flight: Vec<f64>,
    field_times: Vec<f64>,
    displacement: Vec<f64>,
    velocity: Vec<f64>,
}

impl Shown {
    fn add(&mut self, moment: &Moment<'_>) {
        if let Some(probed) = &moment.probes {
            self.times.push(moment.time);
            self.energy.push(probed.energy);
            self.probes.extend_from_slice(probed.values);
            self.reactions.extend_from_slice(probed.reactions.as_flattened());
            self.flight.extend_from_slice(probed.flight);
        }
        if let Some(fields) = &moment.fields {
            self.field_times.push(moment.time);
            self.displacement.extend_from_slice(fields.displacement);
            self.velocity.extend_from_slice(fields.velocity);
        }
    }
}

/// A scenario through a file: names of the probes, the supports, and the columns of a flight, then a mapping
/// of arrays.
#[pyfunction]
pub fn run<'py>(
    py: Python<'py>,
    file: &PyFile,
    scenario: Given,
    options: Option<&Bound<'py, PyDict>>,
    long: bool,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<([Vec<String>; 3], Bound<'py, PyDict>)> {
    let (chapter, asked) = played(file, options)?;
    let (names, shown) = watched(py, Told { progress, warn: true }, |listener| {
        let scenario = scenario.scenario()?;
        let (content, _) = file.content.at(&file.path, &asked)?;
        let opened = content.file(&file.path)?;
        let about = |error: StudyError| Failure::of_study(error, &file.path, Path::new("the scenario"));
        let options = PlayOptions { chapter, scene: asked.scene, long };
        let run = Run::bind(&opened, options, &scenario, listener).map_err(about)?;
        let mut shown = Shown::default();
        let played = run.play(listener, |moment| {
            shown.add(moment);
            Ok::<(), StudyError>(())
        });
        played.map_err(about)?;
        Ok(([run.probes().to_vec(), run.supports().to_vec(), run.flight_columns()], shown))
    })?;
    let (rows, fields) = (shown.times.len(), shown.field_times.len());
    let nodes = shown.displacement.len() / (3 * fields.max(1));
    let arrays = PyDict::new(py);
    arrays.set_item("time", owned(py, shown.times, &[rows])?)?;
    arrays.set_item("energy", owned(py, shown.energy, &[rows])?)?;
    let [probes, supports, flown] = names.each_ref().map(Vec::len);
    arrays.set_item("probes", owned(py, shown.probes, &[rows, probes])?)?;
    arrays.set_item("reactions", owned(py, shown.reactions, &[rows, supports, 6])?)?;
    arrays.set_item("flight", owned(py, shown.flight, &[rows, flown])?)?;
    arrays.set_item("field_time", owned(py, shown.field_times, &[fields])?)?;
    arrays.set_item("displacement", owned(py, shown.displacement, &[fields, nodes, 3])?)?;
    arrays.set_item("velocity", owned(py, shown.velocity, &[fields, nodes, 3])?)?;
    Ok((names, arrays))
}

/// Options of a run, and true if they ask for the chapter's structure.
fn played(file: &PyFile, options: Option<&Bound<'_, PyDict>>) -> PyResult<(bool, Asked)> {
    let opened = file.content.file(&file.path)?;
    let structure = options.map(|all| all.get_item("structure")).transpose()?.flatten();
    let chapter = structure
        .is_some_and(|name| name.extract::<String>().is_ok_and(|n| ["chapter", "canonical"].contains(&&*n)));
    if let (true, Some(options)) = (chapter, options) {
        options.set_item("structure", "auto")?;
    }
    Ok((chapter, asked(&opened, options)?))
}

/// The same scenario full order and through the file, as a text in JSON.
#[pyfunction]
pub fn verify(
    py: Python<'_>,
    file: &PyFile,
    problem: Given,
    scenario: Given,
    options: Option<&Bound<'_, PyDict>>,
    long: bool,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<String> {
    let (chapter, asked) = played(file, options)?;
    watched(py, Told { progress, warn: false }, |listener| {
        let (problem, scenario) = (problem.problem()?, scenario.scenario()?);
        let (content, values) = file.content.at(&file.path, &asked)?;
        let opened = content.file(&file.path)?;
        let options = PlayOptions { chapter, scene: asked.scene, long };
        let mut prepared = prepare(&problem, &mut Stopwatch::new(listener), listener)?;
        if !values.is_empty() {
            prepared_at(&mut prepared, &values)?;
        }
        let found = verified(&opened, &options, &problem, &prepared, &scenario, listener);
        let about = |error: StudyError| Failure::of_study(error, &file.path, Path::new("the scenario"));
        json(&found.map_err(about)?.figures)
    })
}

/// Result of a check of the file alone, as a text in JSON.
#[pyfunction]
pub fn check(py: Python<'_>, file: &PyFile) -> PyResult<String> {
    watched(py, Told { progress: None, warn: false }, |_| {
        let bytes = file.content.original();
        let sound = check_file(bytes, default_limit(bytes.len()));
        json(&sound.map_err(|error| Failure::from(error).about(&file.path))?)
    })
}

/// The lowest natural modes of a problem, as a text in JSON.
#[pyfunction]
pub fn modes(
    py: Python<'_>,
    problem: Given,
    count: usize,
    mesh_error: (bool, Option<f64>),
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<String> {
    let (mesh_error, disc) = mesh_error;
    if disc.is_some_and(|radius| !(radius > 0.0 && radius.is_finite())) {
        return Err(Refusal::usage("disc is not a positive number; expected a radius [m]").into());
    }
    watched(py, Told { progress, warn: false }, |listener| {
        let problem = problem.problem()?;
        let mesh_error = mesh_error.then_some(DiscRequest::Radius(disc));
        json(&natural_modes(&problem, Some(count), mesh_error, &[], listener)?.0)
    })
}

/// Frequencies of a response, by their names in Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Spacing {
    /// First and last frequency; none where all are given.
    range: Option<[f64; 2]>,
    frequencies: Vec<f64>,
    points: usize,
    log: bool,
    poles: bool,
}

impl Spacing {
    /// Refuses frequencies, and numbers of them, that the program does not take.
    fn check(&self) -> Result<(), Refusal> {
        let asked = self.range.as_ref().map_or(&self.frequencies[..], |range| range);
        if !asked.iter().all(|frequency| FREQUENCIES.contains(frequency)) {
            let (first, last) = (FREQUENCIES.start(), FREQUENCIES.end());
            return Err(Refusal::usage(format!("frequencies are numbers from {first:e} to {last:e} Hz")));
        }
        let taken = u32::try_from(self.points).is_ok_and(|points| POINTS.contains(&points));
        if self.range.is_some() && !taken {
            let (least, most) = (POINTS.start(), POINTS.end());
            return Err(Refusal::usage(format!("a range has {least} to {most} points")));
        }
        Ok(())
    }

    fn grid(&self, file: &File<'_>, options: &SceneOptions) -> Result<Vec<f64>, StudyError> {
        let grid = self.range.map(|range| frequencies(range, self.points, self.log));
        let grid = grid.unwrap_or_else(|| self.frequencies.clone());
        if self.poles { with_poles(file, options, grid) } else { Ok(grid) }
    }
}

/// The answer of outputs to a force that swings: frequencies, complex amplitudes as pairs of numbers, shape
/// (outputs, frequencies, 2), and the rest as a text in JSON.
#[pyfunction]
pub fn frf<'py>(
    py: Python<'py>,
    file: &PyFile,
    force: String,
    outputs: Vec<String>,
    spacing: Spacing,
    quantity: &str,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>, String)> {
    spacing.check()?;
    let channel = |text: &String| text.parse::<Channel>().map_err(|error| Refusal::usage(error.to_string()));
    let quantity = match quantity {
        "displacement" => Quantity::Displacement,
        "velocity" => Quantity::Velocity,
        "acceleration" => Quantity::Acceleration,
        _ => {
            let words =
                format!("quantity is `{quantity}`; expected `displacement`, `velocity` or `acceleration`");
            return Err(Refusal::usage(words).into());
        }
    };
    let asked = asked(&file.content.file(&file.path)?, options)?;
    let (input, outputs) = (channel(&force)?, outputs.iter().map(channel).collect::<Result<Vec<_>, _>>()?);
    let names: Vec<String> = outputs.iter().map(Channel::to_string).collect();
    let (grid, found) = watched(py, Told { progress: None, warn: true }, |listener| {
        let (content, _) = file.content.at(&file.path, &asked)?;
        let (opened, scene) = (content.file(&file.path)?, asked.scene);
        let about = |error: StudyError| match error {
            // Both are arguments.
            StudyError::NoChannel { .. } | StudyError::FarPoint { .. } => Refusal::usage(error.to_string()),
            error => Failure::from(error).about(&file.path).into(),
        };
        let frequencies = spacing.grid(&opened, &scene).map_err(about)?;
        let request = ResponseRequest { input, outputs, frequencies, quantity };
        let found = frequency_response(&opened, &scene, &request).map_err(about)?;
        found.notes.iter().for_each(|note| listener.note(note));
        for &output in &found.by_modes_alone {
            listener.note(&format!(
                "`{}` is by the modes alone: name a probe there in the problem file, or build it with \
                 `static_fields = true`",
                names[output]
            ));
        }
        Ok((request.frequencies, found))
    })?;
    let shape = [found.values.len(), grid.len(), 2];
    let numbers: Vec<f64> = found.values.iter().flatten().flat_map(|x| [x.re, x.im]).collect();
    let rest = (names, &found.peaks, found.highest_mode_hz);
    Ok((owned(py, grid, &shape[1..2])?, owned(py, numbers, &shape)?, json(&rest)?))
}

/// The state-space model of a file: matrices by name, and their description as a text in JSON.
#[pyfunction]
pub fn state_space<'py>(
    py: Python<'py>,
    file: &PyFile,
    inputs: Vec<String>,
    outputs: Vec<String>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<(Bound<'py, PyDict>, String)> {
    let asked = asked(&file.content.file(&file.path)?, options)?;
    let inputs =
        inputs.iter().map(|text| text.parse().map_err(usage)).collect::<Result<Vec<Channel>, _>>()?;
    let outputs =
        outputs.iter().map(|text| text.parse().map_err(usage)).collect::<Result<Vec<OutputSignal>, _>>()?;
    let model = watched(py, Told { progress: None, warn: true }, |listener| {
        let (content, _) = file.content.at(&file.path, &asked)?;
        let opened = content.file(&file.path)?;
        let request = StateSpaceRequest { inputs, outputs };
        let model = StateSpace::new(&opened, &asked.scene, &request)
            .map_err(|error| Failure::from(error).about(&file.path))?;
        model.notes.iter().for_each(|note| listener.note(note));
        for &[output, input] in &model.by_modes_alone {
            listener.note(&format!(
                "`{}` under `{}` is by the modes alone: name a probe there in the problem file, or build it with \
                 `static_fields = true`",
                model.outputs[output].name, model.inputs[input].name
            ));
        }
        Ok(model)
    })?;
    let arrays = PyDict::new(py);
    for (name, matrix) in model.matrices() {
        let (rows, columns) = (matrix.nrows(), matrix.ncols());
        let numbers = (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
        let numbers: Vec<f64> = numbers.map(|at| matrix[at]).collect();
        arrays.set_item(name, owned(py, numbers, &[rows, columns])?)?;
    }
    Ok((arrays, json(&model.description("", &[]))?))
}

fn usage(error: impl std::fmt::Display) -> Refusal {
    Refusal::usage(error.to_string())
}

/// Contents and flaws of a mesh file, as a text in JSON.
#[pyfunction]
pub fn mesh(py: Python<'_>, path: PathBuf) -> PyResult<String> {
    watched(py, Told { progress: None, warn: false }, |_| json(&inspect(&parse(&path)?)))
}

/// A problem that is proposed for a mesh, as a text in JSON.
#[pyfunction]
pub fn init(
    py: Python<'_>,
    mesh: PathBuf,
    material: Option<&str>,
    scale: Option<f64>,
    cells: Option<u32>,
    support: (Option<String>, Option<String>),
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<String> {
    let (hold, up) = support;
    let material = material.map(NamedMaterial::find).transpose().map_err(Refusal::usage)?;
    let axis = |name: &String| {
        let axis = ["x", "y", "z"].iter().position(|known| known == name);
        axis.ok_or_else(|| Refusal::usage(format!("up is `{name}`; expected x, y or z")))
    };
    let up = up.as_ref().map(axis).transpose()?;
    if cells.is_some_and(|cells| !CELLS.contains(&cells)) {
        let (least, most) = (CELLS.start(), CELLS.end());
        let words = format!("cells is not from {least} to {most}; expected cells along the longest side");
        return Err(Refusal::usage(words).into());
    }
    if scale.is_some_and(|scale| !(scale > 0.0 && scale.is_finite())) {
        return Err(
            Refusal::usage("scale is not a positive number; expected metres in a unit of the mesh").into()
        );
    }
    watched(py, Told { progress, warn: false }, |listener| {
        let (mesh_name, smallest_part) = (mesh.display().to_string(), SMALLEST_PART);
        let options =
            StarterOptions { material, scale, hold, up, smallest_part, cells, mesh_name, known: None };
        json(&starter(&mesh, &options, listener)?)
    })
}

/// Writes the report of a file on the disk.
#[pyfunction]
pub fn report(
    py: Python<'_>,
    file: PathBuf,
    output: PathBuf,
    compared: Option<[PathBuf; 2]>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<()> {
    watched(py, Told { progress, warn: false }, |listener| {
        Ok(vademecum_cli::report(&file, &output, compared, listener)?)
    })
}

/// The program `vademecum` with these arguments; its exit code.
#[pyfunction]
pub fn program(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| vademecum_cli::program(arguments))
}
