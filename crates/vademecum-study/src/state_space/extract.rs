//! The matrices of a state-space model, from the equation of motion of a file and from a body of it.

use std::f64::consts::TAU;

use faer::Mat;
use vademecum_eval::{BindError, Body, Field, SceneOptions, StructureChoice};
use vademecum_format::exact::ForceFilter;
use vademecum_format::scheme::MAX_STAGES;
use vademecum_format::{File, SectionKind};

use super::error::StateSpaceError;
use super::model::{Signal, StateSpace, StateSpaceRequest};
use super::place::{PlacedOutput, PlacedSignals};
use crate::contents::is_si;
use crate::error::{FileError, StudyError};
use crate::frf::{Quantity, ResponsePoint, Side, add, lacks_residual, row};
use crate::modal::ModalModel;
use crate::player::{Playable, elastic_with_fields, with_body};

/// Remedy for a time scheme over modes.
const OF_SCHEME: &str = "the exact structure has one, of the steps that `run --structure exact` takes";
/// Remedy for a time scheme over another basis.
const OF_BASIS: &str = "leave `time.scheme` and `basis.kind` out of the problem and build it again";
/// Remedy for live regions over a time scheme.
const OF_REGIONS: &str = "build the problem without `representation = \"separated\"`: its live regions are then those \
                          of a parametric model, which is exported at any values of its parameters";

/// Outputs of a body, column by column.
struct Shown {
    /// Outputs in a unit of each coordinate, then of each velocity.
    states: Mat<f64>,
    /// Outputs at rest under a unit of each input.
    inputs: Mat<f64>,
    ad: Mat<f64>,
    start: Mat<f64>,
    end: Mat<f64>,
    filter: ForceFilter,
    beta: f64,
    time_step: f64,
    has_static_field: bool,
}

impl StateSpace {
    /// State-space model of a file at these options.
    ///
    /// # Errors
    /// [`StateSpaceError`].
    pub fn new(
        file: &File<'_>,
        options: &SceneOptions,
        request: &StateSpaceRequest,
    ) -> Result<Self, StateSpaceError> {
        check(file, options)?;
        let options = SceneOptions { structure: StructureChoice::Exact, ..*options };
        let placed = PlacedSignals::new(file, request)?;
        let bound = elastic_with_fields(&options);
        let shown = match with_body::<f64, _>(file, &bound, |body| Ok(Shown::of(body, &placed)?)) {
            Err(StudyError::File(FileError::Bind(BindError::NotDiagonal | BindError::NoStructure))) => {
                return Err(StateSpaceError::NotExact { structure: "block", remedy: OF_REGIONS });
            }
            shown => shown?,
        };
        let reduced = ModalModel::of(file, &options)?;
        let forces = placed.inputs.iter().map(|(_, at)| row(file, at, Side::Input));
        let forces: Vec<Vec<f64>> = forces.collect::<Result<_, _>>()?;
        Ok(assembled(file, placed, shown, &reduced, &forces))
    }
}

/// Refuses files whose step is no map of a state of its own.
fn check(file: &File<'_>, options: &SceneOptions) -> Result<(), StateSpaceError> {
    let metadata = file.metadata();
    if file.section(SectionKind::StrainSizes).is_some() {
        return Err(StateSpaceError::LargeDisplacements);
    }
    if file.section(SectionKind::CanonicalParts).is_some() || !(metadata.diagonal || metadata.block) {
        return Err(StateSpaceError::Chapter);
    }
    if !metadata.diagonal {
        let live = !metadata.active_parameters().is_empty();
        let remedy = if live { OF_REGIONS } else { OF_BASIS };
        return Err(StateSpaceError::NotExact { structure: "block", remedy });
    }
    let structure = match options.structure {
        StructureChoice::Exact => return Ok(()),
        StructureChoice::Auto if metadata.scheme.is_exact() => return Ok(()),
        StructureChoice::Block => "block",
        _ => "diagonal",
    };
    Err(StateSpaceError::NotExact { structure, remedy: OF_SCHEME })
}

impl Shown {
    fn of(body: &mut Body<'_, f64>, placed: &PlacedSignals) -> Result<Self, FileError> {
        let (r, dt) = (body.scene().n_modes(), body.time_step());
        let (p, m) = (placed.outputs.len(), placed.inputs.len());
        let mut states = Mat::zeros(p, 2 * r);
        let read = |body: &Body<'_, f64>, whole: &[f64], out: &mut Mat<f64>, column: usize| {
            for (i, (_, output)) in placed.outputs.iter().enumerate() {
                out[(i, column)] = output.read(body, whole)?;
            }
            Ok::<(), FileError>(())
        };
        body.clear();
        for column in 0..2 * r {
            let mut unit = vec![0.0; 2 * r];
            unit[column] = 1.0;
            body.set(&unit[..r], &unit[r..])?;
            read(body, &[], &mut states, column)?;
        }
        let points = |(_, output): &(Signal, PlacedOutput)| {
            matches!(output, PlacedOutput::Motion(Quantity::Displacement, ResponsePoint::Point(..)))
        };
        let has_static_field = body.has_static_field();
        let n_whole = if has_static_field && placed.outputs.iter().any(points) {
            3 * body.file().metadata().n_nodes as usize
        } else {
            0
        };
        let (mut inputs, mut whole) = (Mat::zeros(p, m), vec![0.0; n_whole]);
        let rest = vec![0.0; body.scene().state_numbers()];
        let [mut start, mut end] = [(); 2].map(|()| Mat::zeros(2 * r, m));
        for (column, (_, input)) in placed.inputs.iter().enumerate() {
            body.clear();
            add(body, input)?;
            body.with(|parts| parts.state.restore_under(&rest, parts.loads))?;
            if !whole.is_empty() {
                Playable::body_into(body, Field::Displacement, &mut whole)?;
            }
            read(body, &whole, &mut inputs, column)?;
            for (instant, map) in [&mut start, &mut end].into_iter().enumerate() {
                let mut amplitudes = [0.0; 1 + MAX_STAGES];
                amplitudes[instant] = 1.0;
                body.rest();
                body.clear();
                match input {
                    ResponsePoint::Point(at, force) => body.push_staged(at, *force, &amplitudes)?,
                    ResponsePoint::Named(pattern) => body.push_pattern_staged(*pattern, &amplitudes)?,
                }
                body.step()?;
                let (mut zeta, mut rates) = (vec![0.0; r], vec![0.0; r]);
                body.coordinates_into(&mut zeta, &mut rates)?;
                zeta.iter().chain(&rates).enumerate().for_each(|(row, &x)| map[(row, column)] = x);
            }
        }
        let mut increment = vec![0.0; 4 * r * r];
        body.scene().increment_into(&mut increment)?;
        // The body steps Δt ζ̇.
        let scale = |row: usize, column: usize| match (row < r, column < r) {
            (true, false) => dt,
            (false, true) => 1.0 / dt,
            _ => 1.0,
        };
        let entry = |i: usize, j: usize| {
            let whole = if i == j { 1.0 } else { 0.0 };
            whole + scale(i, j) * increment[2 * r * j + i]
        };
        let ad = Mat::from_fn(2 * r, 2 * r, entry);
        let parameters = body.scene().parameters();
        let (filter, beta) = (ForceFilter::of(parameters), parameters.beta);
        Ok(Self { states, inputs, ad, start, end, filter, beta, time_step: dt, has_static_field })
    }
}

/// All of it as one model.
fn assembled(
    file: &File<'_>,
    placed: PlacedSignals,
    shown: Shown,
    reduced: &ModalModel,
    forces: &[Vec<f64>],
) -> StateSpace {
    let r = reduced.mass.nrows();
    let (p, m) = (placed.outputs.len(), placed.inputs.len());
    // Inputs with a residual that follows them behind the damping.
    let filters = |input: &usize| {
        let rest = |i: usize| placed.outputs[i].1.is_filtered() && shown.inputs[(i, *input)] != 0.0;
        shown.beta > 0.0 && (0..p).any(rest)
    };
    let filtered: Vec<usize> = (0..m).filter(filters).collect();
    let n = 2 * r + filtered.len();
    let per_mass = |matrix: &Mat<f64>, i: usize, j: usize| matrix[(i, j)] / reduced.mass[(i, i)];
    let a = Mat::from_fn(n, n, |i, j| match (i, j) {
        (i, j) if i < r => f64::from(u8::from(j == r + i)),
        (i, j) if i < 2 * r && j < r => -per_mass(&reduced.stiffness, i - r, j),
        (i, j) if i < 2 * r && j < 2 * r => -per_mass(&reduced.damping, i - r, j - r),
        (i, j) if i == j => -1.0 / shown.beta,
        _ => 0.0,
    });
    let b = Mat::from_fn(n, m, |i, j| match i {
        i if i < r => 0.0,
        i if i < 2 * r => forces[j][i - r] / reduced.mass[(i - r, i - r)],
        i if filtered[i - 2 * r] == j => 1.0 / shown.beta,
        _ => 0.0,
    });
    let mut c = Mat::from_fn(p, n, |i, j| match j {
        j if j < 2 * r => shown.states[(i, j)],
        j if placed.outputs[i].1.is_filtered() => shown.inputs[(i, filtered[j - 2 * r])],
        _ => 0.0,
    });
    let mut d = Mat::from_fn(p, m, |i, j| {
        let behind = shown.beta > 0.0 && placed.outputs[i].1.is_filtered();
        if behind { 0.0 } else { shown.inputs[(i, j)] }
    });
    for (i, (_, output)) in placed.outputs.iter().enumerate() {
        if matches!(output, PlacedOutput::Motion(Quantity::Acceleration, _)) {
            // b · ζ̈, with the displacement b · ζ that was read.
            let along: Vec<f64> = (0..r).map(|k| c[(i, k)]).collect();
            let times = |matrix: &Mat<f64>, j: usize| -> f64 {
                along.iter().enumerate().map(|(k, x)| x * matrix[(r + k, j)]).sum()
            };
            (0..n).for_each(|j| c[(i, j)] = times(&a, j));
            (0..m).for_each(|j| d[(i, j)] = times(&b, j));
        }
    }
    let ad = Mat::from_fn(n, n, |i, j| match (i < 2 * r, j < 2 * r) {
        (true, true) => shown.ad[(i, j)],
        (false, false) if i == j => shown.filter.keep,
        _ => 0.0,
    });
    let whole = |moved: &Mat<f64>, filter: f64| {
        Mat::from_fn(n, m, |i, j| match i {
            i if i < 2 * r => moved[(i, j)],
            i if filtered[i - 2 * r] == j => filter,
            _ => 0.0,
        })
    };
    let (start, end) = (whole(&shown.start, shown.filter.start), whole(&shown.end, shown.filter.end));
    let modes = reduced.modes().into_iter().map(|[omega, sigma]| [omega / TAU, sigma / omega]).collect();
    let by_modes_alone = if shown.has_static_field { vec![] } else { unknown(&placed) };
    let notes = notes(file, &placed, &c, &d);
    let states = states(file, r, filtered.iter().map(|&input| &placed.inputs[input].0));
    let inputs = placed.inputs.into_iter().map(|(signal, _)| signal).collect();
    let outputs = placed.outputs.into_iter().map(|(signal, _)| signal).collect();
    let time_step = shown.time_step;
    StateSpace {
        states,
        inputs,
        outputs,
        a,
        b,
        c,
        d,
        time_step,
        ad,
        start,
        end,
        modes,
        by_modes_alone,
        notes,
    }
}

/// Names of the states.
fn states<'s>(file: &File<'_>, r: usize, filtered: impl Iterator<Item = &'s Signal>) -> Vec<Signal> {
    let unit = |unit: &str| if is_si(file) { unit.to_string() } else { String::new() };
    let of = |letter: char, of_all: &str| -> Vec<Signal> {
        (1..=r).map(|k| Signal { name: format!("{letter}{k}"), unit: unit(of_all) }).collect()
    };
    let behind =
        filtered.map(|input| Signal { name: format!("filtered {}", input.name), unit: input.unit.clone() });
    of('q', "m kg^½").into_iter().chain(of('v', "m kg^½/s")).chain(behind).collect()
}

/// Displacements without residual flexibility: numbers of output and input.
fn unknown(placed: &PlacedSignals) -> Vec<[usize; 2]> {
    let mut unknown = vec![];
    for (i, (_, output)) in placed.outputs.iter().enumerate() {
        if let PlacedOutput::Motion(Quantity::Displacement, output) = output {
            let lacks = |(_, (_, input)): &(usize, &(Signal, ResponsePoint))| lacks_residual(input, output);
            unknown.extend(placed.inputs.iter().enumerate().filter(lacks).map(|(j, _)| [i, j]));
        }
    }
    unknown
}

fn notes(file: &File<'_>, placed: &PlacedSignals, c: &Mat<f64>, d: &Mat<f64>) -> Vec<String> {
    let mut notes = placed.notes.clone();
    for (i, (signal, _)) in placed.outputs.iter().enumerate() {
        let still = (0..c.ncols()).all(|j| c[(i, j)] == 0.0) && (0..d.ncols()).all(|j| d[(i, j)] == 0.0);
        if still {
            notes.push(format!("`{}` is held: no mode and no input moves it", signal.name));
        }
    }
    let stress = placed.outputs.iter().any(|(_, output)| matches!(output, PlacedOutput::Stress(..)));
    let of_input = |input: &ResponsePoint| match input {
        ResponsePoint::Point(..) => SectionKind::StressResidual,
        ResponsePoint::Named(_) => SectionKind::PatternStress,
    };
    if stress && placed.inputs.iter().any(|(_, input)| file.section(of_input(input)).is_none()) {
        notes.push(
            "stress is by the modes alone: the file has no stress of its residual flexibility; build it with \
             `stress_residual = true` under `[output]`"
                .into(),
        );
    }
    if file.section(SectionKind::RigidBody).is_some() {
        notes.push(
            "the file holds a free body: the state is its elastic motion alone, under forces that turn with the body"
                .into(),
        );
    }
    if !file.metadata().scheme.is_exact() {
        notes.push(
            "the discrete map is that of exact steps, `run --structure exact`; the time scheme of the file plays no part"
                .into(),
        );
    }
    notes
}
