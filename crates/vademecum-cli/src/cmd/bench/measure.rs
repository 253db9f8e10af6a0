//! Times of the online work: binding, steps, fields.
//!
//! Steps are timed in bursts under loads at full height, so that nothing comes to rest; a sample is a burst's time over its
//! steps. Methods take turns, round after round, so that what else the machine does falls on all of them.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use vademecum_build::bench::DenseGalerkin;
use vademecum_build::march::TimedLoad;
use vademecum_eval::{Field, Scalar, Scene, SceneOptions, State, StructureChoice};
use vademecum_format::{File, SectionKind};

use super::candidates::{Group, Stepper};
use crate::console::cancelled;
use crate::failure::{Cause, Failure};
use crate::player::{Track, with_scene};

/// Steps of one burst: enough for the clock to be a small part, few enough for the slow ones to show.
pub const BURST: usize = 32;
/// Bursts of one method in one round.
const BURSTS: usize = 1000;
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

/// Measures all methods of all groups, in their order.
pub fn all(
    name: &Path,
    groups: &[Group],
    track: &Track,
    loads: &[TimedLoad],
    rounds: usize,
) -> Result<Vec<Samples>, Failure> {
    let methods: Vec<_> = groups.iter().flat_map(|group| &group.methods).collect();
    let mut samples: Vec<Samples> = methods.iter().map(|_| Samples::default()).collect();
    for _ in 0..rounds {
        for (method, samples) in methods.iter().zip(&mut samples) {
            match &method.stepper {
                Stepper::Dense(model) => dense(model, loads, samples),
                Stepper::File { bytes, structure, single: false } => {
                    through_file::<f64>(name, bytes, *structure, track, samples)?;
                }
                Stepper::File { bytes, structure, single: true } => {
                    through_file::<f32>(name, bytes, *structure, track, samples)?;
                }
            }
            if cancelled() {
                return Err(Failure::new(Cause::Stopped, "stopped on request"));
            }
        }
    }
    Ok(samples)
}

fn dense(model: &DenseGalerkin, loads: &[TimedLoad], samples: &mut Samples) {
    let forces = model.held(&model.reduce(loads));
    let mut state = model.rest(&forces);
    samples.step_ns.push(bursts(|| model.step(&mut state, black_box(&forces))));
    let mut field = vec![0.0; model.n_dof()];
    samples.reconstruct_ms.extend(repeats(1e3, || {
        model.reconstruct_into(&state, &mut field);
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
        track.apply(scene, &full_height, loads)?;
        let mut failed = None;
        samples.step_ns.push(bursts(|| {
            if let Err(error) = scene.step(state, black_box(loads)) {
                failed = Some(error);
            }
        }));
        if let Some(error) = failed {
            return Err(Failure::file(name, error));
        }
        reconstruct(name, &file, scene, state, samples)
    })
}

/// The whole body where the file holds it, the surface where not.
fn reconstruct<T: Scalar>(
    name: &Path,
    file: &File<'_>,
    scene: &Scene<'_, T>,
    state: &State<'_, T>,
    samples: &mut Samples,
) -> Result<(), Failure> {
    let metadata = file.metadata();
    let surface_only =
        metadata.n_nodes > metadata.n_surface_nodes && file.section(SectionKind::InteriorBasis).is_none();
    let nodes = if surface_only { metadata.n_surface_nodes } else { metadata.n_nodes };
    let mut field = vec![T::ZERO; 3 * nodes as usize];
    let mut failed = None;
    samples.reconstruct_ms.extend(repeats(1e3, || {
        let result = if surface_only {
            scene.surface_into(state, Field::Displacement, &mut field)
        } else {
            scene.body_into(state, Field::Displacement, &mut field)
        };
        failed = failed.or(result.err());
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

/// How far the medians of one method's rounds lie apart, relative to the lowest: the median over all methods.
pub fn noise(samples: &[Samples]) -> f64 {
    let spread = |s: &Samples| {
        let medians = s.step_ns.iter().map(|round| median(round.clone()));
        let (low, high) = medians.fold((f64::MAX, 0.0_f64), |(a, b), m| (a.min(m), b.max(m)));
        high / low - 1.0
    };
    median(samples.iter().map(spread).collect())
}
