//! What a report measures itself: how long things take here, and what a free run does to the energy.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use vademecum_eval::{Contact, Field, Loads, Mapped, Scalar, Scene, SceneOptions, State, Structure};
use vademecum_format::File;

use crate::failure::Failure;

/// Wall times on this machine \[s\].
pub struct Timings {
    /// Mapping and opening the file.
    pub open: f64,
    /// Binding a scene in double precision.
    pub bind: f64,
    /// One step in single and in double precision.
    pub step: [f64; 2],
    /// Displacement of the whole surface in single precision.
    pub surface: f64,
    /// The structure that was stepped.
    pub structure: Structure,
}

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
        with_scene::<f32, _>(path, file, |scene, state, loads| steps(path, scene, state, loads))?;
    let (double, _, structure) =
        with_scene::<f64, _>(path, file, |scene, state, loads| steps(path, scene, state, loads))?;
    Ok(Timings { open, bind, step: [single, double], surface, structure })
}

/// Seconds of a step under a held contact and of a surface read.
fn steps<T: Scalar>(
    path: &Path,
    scene: &Scene<'_, T>,
    state: &mut State<'_, T>,
    loads: &mut Loads<'_, T>,
) -> Result<(f64, f64, Structure), Failure> {
    if scene.metadata().n_load_nodes > 0 {
        let contact = Contact { nodes: [0; 3], weights: [1.0, 0.0, 0.0], force: [1e-3; 3] };
        loads.add_contact(scene, &contact).map_err(|error| Failure::file(path, error))?;
    } else {
        // Without a load a body at rest would not be stepped at all.
        let (zeta, rates) = (vec![1e-3; scene.n_modes()], vec![0.0; scene.n_modes()]);
        scene.set(state, &zeta, &rates, loads).map_err(|error| Failure::file(path, error))?;
    }
    let step = seconds(|| {
        for _ in 0..1000 {
            scene.step(state, loads).map_err(|error| Failure::file(path, error))?;
        }
        Ok(())
    })?;
    let mut field = vec![T::ZERO; 3 * scene.metadata().n_surface_nodes as usize];
    let surface = seconds(|| {
        let read = scene.surface_into(state, Field::Displacement, &mut field);
        black_box(&mut field);
        read.map_err(|error| Failure::file(path, error))
    })?;
    Ok((step / 1000.0, surface, scene.structure()))
}

/// Energy over an unloaded run, as a share of that at its start.
pub struct FreeRun {
    /// All modes start with the same energy: (time \[s\], share).
    pub all: Vec<(f64, f64)>,
    /// Only the lowest mode moves at first.
    pub lowest: Vec<(f64, f64)>,
    /// Periods of the lowest mode.
    pub periods: f64,
}

/// Most steps of a free run, and most points kept of it.
const STEPS: usize = 200_000;
const POINTS: usize = 1000;

/// Lets go of a body bent by `ζ_k = 1/√λ_k` (the same elastic energy ½ in each mode) and of one bent in its lowest mode.
pub fn free_run(path: &Path, file: &File<'_>, lambdas: &[f64]) -> Result<FreeRun, Failure> {
    let lowest = lambdas.iter().copied().filter(|&lambda| lambda > 0.0).fold(f64::INFINITY, f64::min);
    let period = std::f64::consts::TAU / lowest.sqrt();
    let time_step = file.metadata().time_step;
    let steps = ((50.0 * period / time_step).ceil() as usize).clamp(100, STEPS);
    let bent = |keep: &dyn Fn(f64) -> bool| -> Vec<f64> {
        let start = |&lambda: &f64| if lambda > 0.0 && keep(lambda) { lambda.sqrt().recip() } else { 0.0 };
        lambdas.iter().map(start).collect()
    };
    Ok(FreeRun {
        all: release(path, file, &bent(&|_| true), steps)?,
        lowest: release(path, file, &bent(&|lambda| lambda == lowest), steps)?,
        periods: steps as f64 * time_step / period,
    })
}

fn release(path: &Path, file: &File<'_>, zeta: &[f64], steps: usize) -> Result<Vec<(f64, f64)>, Failure> {
    with_scene::<f64, _>(path, file, |scene, state, loads| {
        let energy = |state: &State<'_, f64>| scene.energy(state).map_err(|error| Failure::file(path, error));
        scene.set(state, zeta, &vec![0.0; zeta.len()], loads).map_err(|error| Failure::file(path, error))?;
        let first = energy(state)?;
        let mut points = vec![(0.0, 1.0)];
        for step in 1..=steps {
            scene.step(state, loads).map_err(|error| Failure::file(path, error))?;
            if step % steps.div_ceil(POINTS) == 0 {
                points.push((step as f64 * scene.parameters().time_step, energy(state)? / first));
            }
        }
        Ok(points)
    })
}
