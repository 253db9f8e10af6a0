//! Times of the online work: binding, steps, fields.
//!
//! Steps are timed in bursts under loads at full height, so that nothing comes to rest; a sample is a burst's
//! time over its steps. Methods, full order included, take turns, round after round, so that what else the
//! machine does falls on all of them and a ratio can be taken within a round.

use std::hint::black_box;
use std::time::Instant;

use vademecum_build::Matrix;
use vademecum_build::dynamics::{self, FullOrder, INSTANTS, TimedLoad};
use vademecum_build::progress::Listener;
use vademecum_chapter::ChapterScene;
use vademecum_eval::{Body, Field, Scalar, SceneOptions};
use vademecum_format::{File, SectionKind};
use vademecum_study::parts::{median, stop_if_asked};
use vademecum_study::player::{ChapterBody, Playable, Track, elastic, elastic_with_fields, with_body};

use super::method::{Group, Method, Precision, Stepper};
use super::staged::{self, ReducedSolver};
use vademecum_study::StudyError;

/// Steps of one burst: enough for the clock to be a small part, few enough for the slow ones to show.
pub(super) const BURST: usize = 32;
/// Bursts of one method in one round.
const BURSTS: usize = 1000;
/// Full-order steps in one round, timed one by one.
const FULL_STEPS: usize = 16;
/// Times a scene is bound, and a field filled, in one round.
const REPEATS: usize = 5;

/// Samples of one method.
#[derive(Default)]
pub(super) struct Samples {
    /// Time of a step, one list of samples per round \[ns\].
    pub step_ns: Vec<Vec<f64>>,
    /// Time to bind \[µs\]; empty where nothing is bound.
    pub bind_us: Vec<f64>,
    /// Time to fill the displacement of the body \[ms\].
    pub reconstruct_ms: Vec<f64>,
}

/// Measured solvers: full-order solvers, then the methods of all groups, in their order.
pub(super) struct Candidates<'a> {
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
pub(super) fn all(
    candidates: &Candidates<'_>,
    rounds: usize,
    listener: &dyn Listener,
) -> Result<Vec<Samples>, StudyError> {
    let Candidates { full, groups, track, loads } = candidates;
    let methods: Vec<_> = groups.iter().flat_map(|group| &group.methods).collect();
    let mut samples: Vec<Samples> = (0..full.len() + methods.len()).map(|_| Samples::default()).collect();
    for _ in 0..rounds {
        let (of_full, of_methods) = samples.split_at_mut(full.len());
        full.iter().zip(of_full).for_each(|(full, samples)| full_order(full, loads, samples));
        for (method, samples) in methods.iter().zip(of_methods) {
            match &method.stepper {
                Stepper::Solver(solver) => solve(solver.as_ref(), loads, samples),
                Stepper::File(bytes) => match method.precision {
                    Precision::Single => through_file::<f32>(method, bytes, track, samples)?,
                    Precision::Double => through_file::<f64>(method, bytes, track, samples)?,
                },
                Stepper::Chapter { bytes, tracks } => chapter(bytes, tracks, samples)?,
            }
            stop_if_asked(listener)?;
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
    let mut state = dynamics::State::rest(full.n_dof(), 1);
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
    samples.step_ns.push(bursts(BURSTS, || solver.step(&mut state, black_box(&held), &mut work)));
    let mut field = vec![0.0; solver.frame().basis.nrows()];
    samples.reconstruct_ms.extend(repeats(1e3, || {
        staged::reconstruct_into(solver.frame().basis.as_ref(), &state, &mut field);
        black_box(&mut field);
    }));
}

fn through_file<T: Scalar>(
    method: &Method,
    bytes: &[u8],
    track: &Track,
    samples: &mut Samples,
) -> Result<(), StudyError> {
    let file = File::parse(bytes)?;
    let options = method.options(None);
    for _ in 0..REPEATS {
        let start = Instant::now();
        with_body::<T, _>(&file, &elastic(&options), |_| {
            samples.bind_us.push(1e6 * start.elapsed().as_secs_f64());
            Ok(())
        })?;
    }
    with_body::<T, _>(&file, &elastic_with_fields(&options), |body| {
        samples.step_ns.push(held_steps(body, track, BURSTS)?);
        reconstruct(&file, body, samples)
    })
}

/// Times of a step \[ns\] under all loads at full height, one per burst.
pub(super) fn held_steps<T: Scalar>(
    body: &mut Body<'_, T>,
    track: &Track,
    count: usize,
) -> Result<Vec<f64>, StudyError> {
    track.apply(&track.full_height(), body)?;
    let mut failed = None;
    let times = bursts(count, || {
        if let Err(error) = black_box(&mut *body).step() {
            failed = Some(error);
        }
    });
    failed.map_or(Ok(times), |error| Err(error.into()))
}

/// A step of every march. One that leaves its ranges starts anew: a step costs the same wherever the state
/// is.
fn chapter(bytes: &[u8], tracks: &[Track], samples: &mut Samples) -> Result<(), StudyError> {
    let file = File::parse(bytes)?;
    for _ in 0..REPEATS {
        let start = Instant::now();
        let scene = ChapterScene::bind(&file, &SceneOptions::default())?;
        black_box(tracks.iter().map(|_| ChapterBody::new(&scene)).collect::<Vec<_>>());
        samples.bind_us.push(1e6 * start.elapsed().as_secs_f64());
    }
    let scene = ChapterScene::bind(&file, &SceneOptions::default())?;
    let mut bodies: Vec<_> = tracks.iter().map(|_| ChapterBody::new(&scene)).collect();
    for (track, body) in tracks.iter().zip(&mut bodies) {
        track.apply(&track.full_height(), body)?;
    }
    samples.step_ns.push(bursts(BURSTS, || {
        for body in &mut bodies {
            if scene.step(&mut body.state, black_box(&body.loads)).is_err() {
                body.state.rest();
            }
        }
    }));
    reconstruct(&file, &mut bodies[0], samples)
}

/// The whole body where the file holds it, the surface where not.
fn reconstruct<B: Playable>(file: &File<'_>, body: &mut B, samples: &mut Samples) -> Result<(), StudyError> {
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
    failed.map_or(Ok(()), |error| Err(error.into()))
}

/// Times of a step \[ns\], one per burst; the first burst warms up and is not counted.
fn bursts(count: usize, mut step: impl FnMut()) -> Vec<f64> {
    let burst = |_| {
        let start = Instant::now();
        (0..BURST).for_each(|_| step());
        1e9 * start.elapsed().as_secs_f64() / BURST as f64
    };
    (0..=count).map(burst).skip(1).collect()
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

/// Time of an empty burst per step \[ns\]: in every sample of a step, not taken off.
pub(super) fn clock() -> f64 {
    median(bursts(BURSTS, || {
        black_box(());
    }))
}

impl Samples {
    /// Median of each round \[ns\].
    pub fn round_medians(&self) -> Vec<f64> {
        self.step_ns.iter().map(|round| median(round.clone())).collect()
    }

    /// Spread of the medians of the rounds, relative to the lowest.
    pub fn spread(&self) -> f64 {
        let range =
            self.round_medians().into_iter().fold((f64::MAX, 0.0_f64), |(a, b), m| (a.min(m), b.max(m)));
        range.1 / range.0 - 1.0
    }

    /// Ratio of the times of a step of `other` and of this one: the median over the rounds of the ratio
    /// within a round.
    pub fn times_faster_than(&self, other: &Samples) -> f64 {
        let ratios = self.round_medians().into_iter().zip(other.round_medians());
        median(ratios.map(|(own, other)| other / own).collect())
    }
}

/// The median over all candidates of how far their rounds lie apart.
pub(super) fn noise<'a>(samples: impl IntoIterator<Item = &'a Samples>) -> f64 {
    median(samples.into_iter().map(Samples::spread).collect())
}
