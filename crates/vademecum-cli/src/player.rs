//! Plays a scenario through the evaluator: the same for `run`, `verify` and `demo`.

use std::path::Path;
use std::time::Instant;

use vademecum_build::dynamics::Interval;
use vademecum_eval::{Contact, Loads, Scalar, Scene, SceneOptions, State, Surface, SurfacePoint};
use vademecum_format::{Chapter, File, SectionKind};
use vademecum_study::scenario::Scenario;

use crate::console::cancelled;
use crate::failure::{Cause, Failure};

/// A scenario bound to a file: contacts on its surface, patterns by number.
pub struct Track {
    /// Contact, where it lies, when it acts.
    pub contacts: Vec<(Contact, SurfacePoint, Interval)>,
    /// Pattern, amplitude, when it acts.
    pub patterns: Vec<(usize, f64, Interval)>,
}

impl Track {
    /// Finds each contact's triangle and each pattern's number.
    pub fn bind(path: &Path, file: &File<'_>, scenario: &Scenario) -> Result<Self, Failure> {
        let canonical = Chapter::read(file).map_err(|error| Failure::file(path, error))?;
        let contact = |entry: &vademecum_study::scenario::ContactEntry| {
            let surface = Surface::new(file).map_err(|error| Failure::file(path, error))?;
            let point = match &canonical {
                Some(canonical) => nearest_position(path, file, canonical, entry.point)?,
                None => surface.locate(entry.point).ok_or_else(|| no_surface(path))?,
            };
            let contact = Contact { nodes: point.nodes, weights: point.weights, force: entry.force };
            Ok((contact, point, entry.when()))
        };
        let names = names(path, file, SectionKind::PatternNames)?;
        let pattern = |entry: &vademecum_study::scenario::PatternUse| {
            let index = names.iter().position(|name| *name == entry.name).ok_or_else(|| {
                let known = if names.is_empty() { "none".into() } else { names.join(", ") };
                let text = format!("the file has no load pattern `{}`; it has {known}", entry.name);
                Failure::new(Cause::Input, text)
            })?;
            Ok((index, entry.amplitude, entry.when()))
        };
        Ok(Self {
            contacts: scenario.contacts.iter().map(contact).collect::<Result<_, Failure>>()?,
            patterns: scenario.patterns.iter().map(pattern).collect::<Result<_, Failure>>()?,
        })
    }

    /// When the last load ends \[s\]; 0 without loads.
    pub fn release(&self) -> f64 {
        let ends = self.contacts.iter().map(|c| c.2.end).chain(self.patterns.iter().map(|p| p.2.end));
        ends.fold(0.0, f64::max)
    }

    /// Factors of all loads at the given instants of a step.
    pub fn factors(&self, instants: &[f64], time_step: f64, step: usize) -> Vec<[f64; 4]> {
        let at = |when: &Interval| -> [f64; 4] {
            std::array::from_fn(|j| when.factor((step as f64 + instants[j]) * time_step))
        };
        self.contacts.iter().map(|c| at(&c.2)).chain(self.patterns.iter().map(|p| at(&p.2))).collect()
    }

    /// Puts the loads of a step into `loads`.
    pub fn apply<T: Scalar>(
        &self,
        scene: &Scene<'_, T>,
        factors: &[[f64; 4]],
        loads: &mut Loads<'_, T>,
    ) -> Result<(), Failure> {
        let failed = |error: vademecum_eval::LoadError| Failure::new(Cause::File, error);
        loads.clear();
        let (contacts, patterns) = factors.split_at(self.contacts.len());
        for ((contact, _, _), factors) in self.contacts.iter().zip(contacts) {
            if factors.iter().any(|&f| f != 0.0) {
                loads.add_contact_staged(scene, contact, factors).map_err(failed)?;
            }
        }
        for ((index, amplitude, _), factors) in self.patterns.iter().zip(patterns) {
            if factors.iter().any(|&f| f != 0.0) {
                loads.add_pattern_staged(scene, *index, &factors.map(|f| f * amplitude)).map_err(failed)?;
            }
        }
        Ok(())
    }
}

/// Names kept in a section; none if the file does not have it.
pub fn names(path: &Path, file: &File<'_>, kind: SectionKind) -> Result<Vec<String>, Failure> {
    let Some(section) = file.section(kind) else { return Ok(vec![]) };
    let text = section.text().map_err(|error| Failure::file(path, error))?;
    Ok(text.split('\n').map(str::to_string).collect())
}

/// Where a canonical file can take a load meant for `point`: the nearest of its positions.
fn nearest_position(
    path: &Path,
    file: &File<'_>,
    canonical: &Chapter<'_>,
    point: [f64; 3],
) -> Result<SurfacePoint, Failure> {
    let section = file.section(SectionKind::NodeCoordinates).ok_or_else(|| no_surface(path))?;
    let numbers = section.numbers().map_err(|error| Failure::file(path, error))?;
    let at = |node: u32| [0, 1, 2].map(|c| numbers.get(3 * node as usize + c).unwrap_or(f64::NAN));
    let distance = |x: [f64; 3]| (0..3).map(|c| (x[c] - point[c]).powi(2)).sum::<f64>().sqrt();
    let places = canonical.positions().map(|node| (node, at(node), distance(at(node))));
    let nearest = places.min_by(|a, b| a.2.total_cmp(&b.2));
    let (node, position, distance) = nearest.ok_or_else(|| no_surface(path))?;
    Ok(SurfacePoint { nodes: [node; 3], weights: [1.0, 0.0, 0.0], position, distance })
}

fn no_surface(path: &Path) -> Failure {
    let text = format!("{}: the file has no loadable surface, so contacts cannot act", path.display());
    Failure::new(Cause::File, text)
}

/// Binds a scene in memory of its own and hands it over, at rest and unloaded.
pub fn with_scene<T: Scalar, R>(
    path: &Path,
    file: &File<'_>,
    options: &SceneOptions,
    work: impl FnOnce(&Scene<'_, T>, &mut State<'_, T>, &mut Loads<'_, T>) -> Result<R, Failure>,
) -> Result<R, Failure> {
    let bind = |error| Failure::file(path, error);
    let sizes = Scene::<T>::sizes(file, options).map_err(bind)?;
    let (mut memory, mut bind_work) = (vec![T::ZERO; sizes.scene], vec![0.0; sizes.work]);
    let (mut state_memory, mut load_memory) = (vec![T::ZERO; sizes.state], vec![T::ZERO; sizes.loads]);
    let scene = Scene::bind(file, options, &mut memory, &mut bind_work).map_err(bind)?;
    let mut state = State::new(&scene, &mut state_memory).map_err(bind)?;
    let mut loads = Loads::new(&scene, &mut load_memory).map_err(bind)?;
    work(&scene, &mut state, &mut loads)
}

/// Marches `steps` steps from rest and shows each state, the start included.
pub fn play(
    path: &Path,
    file: &File<'_>,
    options: &SceneOptions,
    track: &Track,
    steps: usize,
    observe: impl FnMut(usize, &Scene<'_, f64>, &State<'_, f64>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    play_in(path, file, options, track, steps, observe)
}

/// [`play`] in the precision of the scene `observe` takes.
pub fn play_in<T: Scalar>(
    path: &Path,
    file: &File<'_>,
    options: &SceneOptions,
    track: &Track,
    steps: usize,
    mut observe: impl FnMut(usize, &Scene<'_, T>, &State<'_, T>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    with_scene(path, file, options, |scene, state, loads| {
        let (instants, time_step) = (scene.instants(), scene.parameters().time_step);
        let step_failed = |error| Failure::file(path, error);
        let mut factors = track.factors(&instants, time_step, 0);
        track.apply(scene, &factors, loads)?;
        let zero = vec![0.0; scene.n_modes()];
        scene.set(state, &zero, &zero, loads).map_err(step_failed)?;
        observe(0, scene, state)?;
        for step in 0..steps {
            let next = track.factors(&instants, time_step, step);
            if next != factors {
                factors = next;
                track.apply(scene, &factors, loads)?;
            }
            scene.step(state, loads).map_err(step_failed)?;
            observe(step + 1, scene, state)?;
            if cancelled() {
                return Err(Failure::new(Cause::Stopped, "stopped on request"));
            }
        }
        Ok(())
    })
}

/// A long march under one held contact and then free: what stepping costs, and whether it stays bounded.
#[derive(Clone, Debug, serde::Serialize)]
pub struct LongRun {
    /// Steps marched.
    pub steps: usize,
    /// Wall time of a step \[s\], the mean of all.
    pub seconds_per_step: f64,
    /// Largest energy after release over the energy at release.
    pub energy_ratio: f64,
    /// Energy at the end over the energy at release.
    pub energy_left: f64,
}

/// Marches `steps` steps: the first hundredth under the track's first loads, the rest free.
pub fn long_run(
    path: &Path,
    file: &File<'_>,
    options: &SceneOptions,
    track: &Track,
    steps: usize,
) -> Result<LongRun, Failure> {
    with_scene(path, file, options, |scene: &Scene<'_, f64>, state, loads| {
        let factors = track.factors(&scene.instants(), scene.parameters().time_step, 0);
        track.apply(scene, &factors, loads)?;
        let step_failed = |error| Failure::file(path, error);
        let energy_failed = |error| Failure::file(path, error);

        let held = steps / 100;
        for _ in 0..held {
            scene.step(state, loads).map_err(step_failed)?;
        }
        loads.clear();
        // One free step first: the old acceleration still holds the force.
        scene.step(state, loads).map_err(step_failed)?;
        let release = scene.energy(state).map_err(energy_failed)?;
        let (mut largest, mut seconds, mut done) = (release, 0.0, held);
        // Energy is looked at between bursts, so that looking costs the timing nothing.
        const BURST: usize = 1000;
        while done < steps {
            let burst = BURST.min(steps - done);
            let start = Instant::now();
            for _ in 0..burst {
                scene.step(state, loads).map_err(step_failed)?;
            }
            seconds += start.elapsed().as_secs_f64();
            done += burst;
            largest = largest.max(scene.energy(state).map_err(energy_failed)?);
            if cancelled() {
                return Err(Failure::new(Cause::Stopped, "stopped on request"));
            }
        }
        let left = scene.energy(state).map_err(energy_failed)?;
        Ok(LongRun {
            steps,
            seconds_per_step: seconds / (steps - held) as f64,
            energy_ratio: largest / release,
            energy_left: left / release,
        })
    })
}
