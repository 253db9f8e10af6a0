//! Times of the online work: binding, steps, fields.
//!
//! Steps are timed in bursts under loads at full height, so that nothing comes to rest; a sample is a burst's time over its
//! steps. Methods, full order included, take turns, round after round, so that what else the machine does falls on all of
//! them and a ratio can be taken within a round.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use vademecum_build::Matrix;
use vademecum_build::dynamics::FullOrder;
use vademecum_build::dynamics::{INSTANTS, TimedLoad};
use vademecum_eval::{Field, Scalar, SceneOptions, StructureChoice};
use vademecum_format::{File, SectionKind};
use vademecum_study::bench::{ReducedSolver, staged};

use super::candidates::{Group, Stepper};
use super::canonical::with_marches;
use crate::console::cancelled;
use crate::failure::{Cause, Failure};
use crate::player::{Body, Playable, Track, with_scene};

/// Steps of one burst: enough for the clock to be a small part, few enough for the slow ones to show.
pub const BURST: usize = 32;
/// Bursts of one method in one round.
const BURSTS: usize = 1000;
/// Full-order steps in one round, timed one by one.
const FULL_STEPS: usize = 16;
/// Times a scene is bound, and a field filled, in one round.
const REPEATS: usize = 5;

/// What was measured of one method.
#[derive(Default)]
pub struct Samples {
    /// Time of a step, one list of samples per round \[ns\].
    pub step_ns: Vec<Vec<f64>>,
    /// Time to bind \[µs\]; empty where nothing is bound.
    pub bind_us: Vec<f64>,
    /// Time to fill the displacement of the body \[ms\].
    pub reconstruct_ms: Vec<f64>,
}

/// What is measured: full-order solvers, then the methods of all groups, in their order.
pub struct Candidates<'a> {
    /// Full-order solvers.
    pub full: &'a [&'a FullOrder<'a>],
    /// Reduced methods.
    pub groups: &'a [Group],
    /// The scenario, as files take it.
    pub track: &'a Track,
    /// The scenario, over the free dofs.
    pub loads: &'a [TimedLoad],
}

/// Measures all candidates; samples of the full-order solvers first.
pub fn all(name: &Path, candidates: &Candidates<'_>, rounds: usize) -> Result<Vec<Samples>, Failure> {
    let Candidates { full, groups, track, loads } = candidates;
    let methods: Vec<_> = groups.iter().flat_map(|group| &group.methods).collect();
    let mut samples: Vec<Samples> = (0..full.len() + methods.len()).map(|_| Samples::default()).collect();
    for _ in 0..rounds {
        let (of_full, of_methods) = samples.split_at_mut(full.len());
        full.iter().zip(of_full).for_each(|(full, samples)| full_order(full, loads, samples));
        for (method, samples) in methods.iter().zip(of_methods) {
            match &method.stepper {
                Stepper::Solver { solver, .. } => solve(solver.as_ref(), loads, samples),
                Stepper::File { bytes, structure, single: false } => {
                    through_file::<f64>(name, bytes, *structure, track, samples)?;
                }
                Stepper::File { bytes, structure, single: true } => {
                    through_file::<f32>(name, bytes, *structure, track, samples)?;
                }
                Stepper::Canonical { bytes, tracks } => canonical(name, bytes, tracks, samples)?,
            }
            if cancelled() {
                return Err(Failure::new(Cause::Stopped, "stopped on request"));
            }
        }
    }
    Ok(samples)
}

/// Steps of one full-order trajectory; the first one warms up and is not counted.
fn full_order(full: &FullOrder<'_>, loads: &[TimedLoad], samples: &mut Samples) {
    let mut force = Matrix::zeros(full.n_dof(), 1);
    for load in loads {
        let column = force.col_as_slice_mut(0);
        column.iter_mut().zip(&load.force).for_each(|(sum, f)| *sum += f);
    }
    let held: [_; INSTANTS] = std::array::from_fn(|_| Some(force.as_ref()));
    let mut state = vademecum_build::dynamics::State::rest(full.n_dof(), 1);
    let mut work = full.workspace(1, false);
    let step = |_| {
        let start = Instant::now();
        full.step(&mut state, &held, &mut work);
        1e9 * start.elapsed().as_secs_f64()
    };
    samples.step_ns.push((0..=FULL_STEPS).map(step).skip(1).collect());
}

fn solve(solver: &dyn ReducedSolver, loads: &[TimedLoad], samples: &mut Samples) {
    let loads = staged::reduce(solver, loads);
    let (held, mut state) = (staged::held(solver, &loads), staged::start(solver, &loads));
    let mut work = vec![0.0; solver.work_len()];
    samples.step_ns.push(bursts(|| solver.step(&mut state, black_box(&held), &mut work)));
    let mut field = vec![0.0; solver.frame().basis.nrows()];
    samples.reconstruct_ms.extend(repeats(1e3, || {
        staged::reconstruct_into(solver.frame().basis.as_ref(), &state, &mut field);
        black_box(&mut field);
    }));
}

fn through_file<T: Scalar>(
    name: &Path,
    bytes: &[u8],
    structure: StructureChoice,
    track: &Track,
    samples: &mut Samples,
) -> Result<(), Failure> {
    let file = File::parse(bytes).map_err(|error| Failure::file(name, error))?;
    let options = SceneOptions { structure, ..SceneOptions::default() };
    for _ in 0..REPEATS {
        let start = Instant::now();
        with_scene::<T, _>(name, &file, &options, |_, _, _| {
            samples.bind_us.push(1e6 * start.elapsed().as_secs_f64());
            Ok(())
        })?;
    }
    with_scene::<T, _>(name, &file, &options, |scene, state, loads| {
        let full_height = vec![[1.0; 4]; track.contacts.len() + track.patterns.len()];
        track.apply(&full_height, &mut Body { scene, state: &mut *state, loads: &mut *loads })?;
        let mut failed = None;
        samples.step_ns.push(bursts(|| {
            if let Err(error) = scene.step(state, black_box(loads)) {
                failed = Some(error);
            }
        }));
        if let Some(error) = failed {
            return Err(Failure::file(name, error));
        }
        reconstruct(name, &file, &Body { scene, state, loads }, samples)
    })
}

/// A step of every march. One that leaves its ranges starts anew: a step costs the same wherever the state is.
fn canonical(name: &Path, bytes: &[u8], tracks: &[Track], samples: &mut Samples) -> Result<(), Failure> {
    let file = File::parse(bytes).map_err(|error| Failure::file(name, error))?;
    for _ in 0..REPEATS {
        let start = Instant::now();
        with_marches(name, &file, None, tracks.len(), |_, _| {
            samples.bind_us.push(1e6 * start.elapsed().as_secs_f64());
            Ok(())
        })?;
    }
    with_marches(name, &file, None, tracks.len(), |scene, marches| {
        for (track, (state, loads)) in tracks.iter().zip(&mut *marches) {
            track.apply(&vec![[1.0; 4]; track.contacts.len()], &mut Body { scene, state, loads })?;
        }
        samples.step_ns.push(bursts(|| {
            for (state, loads) in &mut *marches {
                if scene.step(state, black_box(loads)).is_err() {
                    state.rest();
                }
            }
        }));
        let (state, loads) = &mut marches[0];
        reconstruct(name, &file, &Body { scene, state, loads }, samples)
    })
}

/// The whole body where the file holds it, the surface where not.
fn reconstruct<B: Playable>(
    name: &Path,
    file: &File<'_>,
    body: &B,
    samples: &mut Samples,
) -> Result<(), Failure> {
    let metadata = file.metadata();
    let surface_only =
        metadata.n_nodes > metadata.n_surface_nodes && file.section(SectionKind::InteriorBasis).is_none();
    let nodes = if surface_only { metadata.n_surface_nodes } else { metadata.n_nodes };
    let mut field = vec![B::Number::ZERO; 3 * nodes as usize];
    let mut failed = None;
    samples.reconstruct_ms.extend(repeats(1e3, || {
        let result = if surface_only {
            body.surface_into(Field::Displacement, &mut field)
        } else {
            body.body_into(Field::Displacement, &mut field)
        };
        failed = failed.take().or(result.err());
        black_box(&mut field);
    }));
    failed.map_or(Ok(()), |error| Err(Failure::file(name, error)))
}

/// Times of a step \[ns\], one per burst; the first burst warms up and is not counted.
fn bursts(mut step: impl FnMut()) -> Vec<f64> {
    let burst = |_| {
        let start = Instant::now();
        (0..BURST).for_each(|_| step());
        1e9 * start.elapsed().as_secs_f64() / BURST as f64
    };
    (0..=BURSTS).map(burst).skip(1).collect()
}

/// Times of some work done a few times, in parts of a second.
fn repeats(parts: f64, mut work: impl FnMut()) -> Vec<f64> {
    let once = |_| {
        let start = Instant::now();
        work();
        parts * start.elapsed().as_secs_f64()
    };
    (0..REPEATS).map(once).collect()
}

/// What an empty burst costs per step \[ns\]: in every sample of a step, not taken off.
pub fn clock() -> f64 {
    median(bursts(|| {
        black_box(());
    }))
}

/// Median, 99th percentile, largest.
pub fn percentiles(mut samples: Vec<f64>) -> [f64; 3] {
    samples.sort_by(f64::total_cmp);
    let at = |fraction: f64| samples[(fraction * (samples.len() - 1) as f64).round() as usize];
    [at(0.5), at(0.99), at(1.0)]
}

/// The middle of some samples.
pub fn median(samples: Vec<f64>) -> f64 {
    percentiles(samples)[0]
}

impl Samples {
    /// Median of each round \[ns\].
    pub fn round_medians(&self) -> Vec<f64> {
        self.step_ns.iter().map(|round| median(round.clone())).collect()
    }

    /// How far the medians of the rounds lie apart, relative to the lowest.
    pub fn spread(&self) -> f64 {
        let range =
            self.round_medians().into_iter().fold((f64::MAX, 0.0_f64), |(a, b), m| (a.min(m), b.max(m)));
        range.1 / range.0 - 1.0
    }

    /// How many times as long a step of `other` takes: the median over the rounds of the ratio within a round.
    pub fn times_faster_than(&self, other: &Samples) -> f64 {
        let ratios = self.round_medians().into_iter().zip(other.round_medians());
        median(ratios.map(|(own, other)| other / own).collect())
    }
}

/// The median over all candidates of how far their rounds lie apart.
pub fn noise(samples: &[Samples]) -> f64 {
    median(samples.iter().map(Samples::spread).collect())
}
