//! What a report measures itself: how long things take here, and what a free run does to the energy.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use vademecum_eval::{Contact, Field, Loads, Mapped, Scalar, Scene, SceneOptions, State, Structure};
use vademecum_format::{File, SectionKind};

use super::numbers;
use crate::cmd::bench::percentiles;
use crate::failure::Failure;

/// Wall times on this machine \[s\].
pub struct Timings {
    /// Mapping and opening the file.
    pub open: f64,
    /// Binding a scene in double precision.
    pub bind: f64,
    /// One step in single and in double precision: median, 99th percentile and largest of bursts of 32.
    pub step: [[f64; 3]; 2],
    /// Displacement of the whole surface in single precision.
    pub surface: f64,
    /// The structure that was stepped.
    pub structure: Structure,
}

/// Steps of a burst, so that the clock is a small part of it, and bursts measured.
const BURST: u32 = 32;
const BURSTS: usize = 2000;
/// Shortest time of a measurement \[s\]; shorter ones are repeated more often.
const LONG_ENOUGH: f64 = 0.05;

/// Seconds of one call of `work`, the mean over at least [`LONG_ENOUGH`].
fn seconds(mut work: impl FnMut() -> Result<(), Failure>) -> Result<f64, Failure> {
    work()?;
    let mut count = 1;
    loop {
        let start = Instant::now();
        for _ in 0..count {
            work()?;
        }
        let elapsed = start.elapsed().as_secs_f64();
        if elapsed >= LONG_ENOUGH {
            return Ok(elapsed / f64::from(count));
        }
        count *= 2;
    }
}

/// Binds the file as it was built and runs `work` on a body at rest.
fn with_scene<T: Scalar, R>(
    path: &Path,
    file: &File<'_>,
    work: impl FnOnce(&Scene<'_, T>, &mut State<'_, T>, &mut Loads<'_, T>) -> Result<R, Failure>,
) -> Result<R, Failure> {
    let bind = |error| Failure::file(path, error);
    let options = SceneOptions::default();
    let sizes = Scene::<T>::sizes(file, &options).map_err(bind)?;
    let (mut memory, mut scratch) = (vec![T::ZERO; sizes.scene], vec![0.0; sizes.work]);
    let (mut state, mut loads) = (vec![T::ZERO; sizes.state], vec![T::ZERO; sizes.loads]);
    let scene = Scene::bind(file, &options, &mut memory, &mut scratch).map_err(bind)?;
    let mut state = State::new(&scene, &mut state).map_err(bind)?;
    let mut loads = Loads::new(&scene, &mut loads).map_err(bind)?;
    work(&scene, &mut state, &mut loads)
}

/// Times opening, binding, stepping and reading the surface.
pub fn timings(path: &Path, file: &File<'_>) -> Result<Timings, Failure> {
    let open = seconds(|| {
        let mapped = Mapped::open(path).map_err(|error| Failure::file(path, error))?;
        black_box(mapped.file().map_err(|error| Failure::file(path, error))?.metadata().n_modes);
        Ok(())
    })?;
    let bind = seconds(|| with_scene::<f64, ()>(path, file, |_, _, _| Ok(())))?;
    let (single, surface, _) =
        with_scene::<f32, _>(path, file, |scene, state, loads| steps(path, file, scene, state, loads))?;
    let (double, _, structure) =
        with_scene::<f64, _>(path, file, |scene, state, loads| steps(path, file, scene, state, loads))?;
    Ok(Timings { open, bind, step: [single, double], surface, structure })
}

/// Seconds of a step under a held contact and of a surface read.
fn steps<T: Scalar>(
    path: &Path,
    file: &File<'_>,
    scene: &Scene<'_, T>,
    state: &mut State<'_, T>,
    loads: &mut Loads<'_, T>,
) -> Result<([f64; 3], f64, Structure), Failure> {
    if scene.metadata().n_load_nodes > 0 || scene.metadata().n_patterns > 0 {
        push(path, file, scene, loads)?;
    } else {
        // Without a load a body at rest would not be stepped at all.
        let (zeta, rates) = (vec![1e-3; scene.n_modes()], vec![0.0; scene.n_modes()]);
        scene.set(state, &zeta, &rates, loads).map_err(|error| Failure::file(path, error))?;
    }
    let mut bursts = Vec::with_capacity(BURSTS);
    for _ in 0..=BURSTS {
        let start = Instant::now();
        for _ in 0..BURST {
            scene.step(state, loads).map_err(|error| Failure::file(path, error))?;
        }
        bursts.push(start.elapsed().as_secs_f64() / f64::from(BURST));
    }
    // The first one warms up.
    let step = percentiles(bursts.split_off(1));
    let mut field = vec![T::ZERO; 3 * scene.metadata().n_surface_nodes as usize];
    let surface = seconds(|| {
        let read = scene.surface_into(state, Field::Displacement, &mut field);
        black_box(&mut field);
        read.map_err(|error| Failure::file(path, error))
    })?;
    Ok((step, surface, scene.structure()))
}

/// Energy over an unloaded run, as a share of that at its start.
pub struct FreeRun {
    /// After a push: (time \[s\], share); none for a file without loads.
    pub pushed: Option<Vec<(f64, f64)>>,
    /// Only the lowest mode is bent at first.
    pub lowest: Vec<(f64, f64)>,
    /// Periods of the lowest mode.
    pub periods: f64,
}

/// Most steps of a free run, and most points kept of it.
const STEPS: usize = 200_000;
const POINTS: usize = 1000;

/// Lets go of a body that was pushed, and of one bent in its lowest mode with the energy ½.
pub fn free_run(path: &Path, file: &File<'_>, lambdas: &[f64]) -> Result<FreeRun, Failure> {
    let lowest = lambdas.iter().copied().filter(|&lambda| lambda > 0.0).fold(f64::INFINITY, f64::min);
    let (period, time_step) = (std::f64::consts::TAU / lowest.sqrt(), file.metadata().time_step);
    let steps = ((50.0 * period / time_step).ceil() as usize).clamp(100, STEPS);
    let bend = |&lambda: &f64| if lambda == lowest { lambda.sqrt().recip() } else { 0.0 };
    let zeta: Vec<f64> = lambdas.iter().map(bend).collect();
    let loadable = file.metadata().n_load_nodes > 0 || file.metadata().n_patterns > 0;
    let held = ((0.5 * period / time_step).ceil() as usize).clamp(1, STEPS);
    let pushed = if loadable {
        Some(with_scene::<f64, _>(path, file, |scene, state, loads| {
            let failed = |error| Failure::file(path, error);
            push(path, file, scene, loads)?;
            (0..held).try_for_each(|_| scene.step(state, loads).map(|_| ()).map_err(failed))?;
            loads.clear();
            release(path, scene, state, loads, steps)
        })?)
    } else {
        None
    };
    let lowest = with_scene::<f64, _>(path, file, |scene, state, loads| {
        let at_rest = vec![0.0; zeta.len()];
        scene.set(state, &zeta, &at_rest, loads).map_err(|error| Failure::file(path, error))?;
        release(path, scene, state, loads, steps)
    })?;
    Ok(FreeRun { pushed, lowest, periods: steps as f64 * time_step / period })
}

/// A contact at the loadable node that the modes move most, or the first load pattern of a file without contacts.
fn push<T: Scalar>(
    path: &Path,
    file: &File<'_>,
    scene: &Scene<'_, T>,
    loads: &mut Loads<'_, T>,
) -> Result<(), Failure> {
    let pushed = match file.metadata().n_load_nodes as usize {
        0 => loads.add_pattern(scene, 0, 1e-3),
        n_load_nodes => {
            let basis = numbers(path, file, SectionKind::SurfaceBasis)?;
            let size = |row: &[f64]| row.iter().map(|x| x * x).sum::<f64>();
            let rows = basis.chunks_exact(3 * scene.n_modes()).map(size).take(n_load_nodes).enumerate();
            let node = rows.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |row| row.0 as u32);
            let contact = Contact { nodes: [node; 3], weights: [1.0, 0.0, 0.0], force: [1e-3; 3] };
            loads.add_contact(scene, &contact)
        }
    };
    pushed.map_err(|error| Failure::file(path, error))
}

/// Steps a body that nothing drives; its energy as a share of that at the start.
fn release(
    path: &Path,
    scene: &Scene<'_, f64>,
    state: &mut State<'_, f64>,
    loads: &mut Loads<'_, f64>,
    steps: usize,
) -> Result<Vec<(f64, f64)>, Failure> {
    let energy = |state: &State<'_, f64>| scene.energy(state).map_err(|error| Failure::file(path, error));
    let first = energy(state)?;
    let mut points = vec![(0.0, 1.0)];
    for step in 1..=steps {
        scene.step(state, loads).map_err(|error| Failure::file(path, error))?;
        if step % steps.div_ceil(POINTS) == 0 {
            points.push((step as f64 * scene.parameters().time_step, energy(state)? / first));
        }
    }
    Ok(points)
}

/// The processor, where the system tells, and what the program was compiled for.
pub fn machine() -> String {
    let (system, processor) = (std::env::consts::OS, std::env::consts::ARCH);
    let told = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = told.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    model.map_or(format!("{processor} {system}"), |(_, name)| {
        format!("{} ({processor} {system})", name.trim())
    })
}
