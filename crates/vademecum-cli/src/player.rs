//! Plays a scenario through the evaluator: the same for `run`, `verify` and `demo`.

mod body;

use std::path::Path;
use std::time::Instant;

use vademecum_build::dynamics::Interval;
use vademecum_eval::chapter::{ChapterLoads, ChapterScene, ChapterState};
use vademecum_eval::{
    Contact, Loads, Scalar, Scene, SceneOptions, State, StructureChoice, Surface, SurfacePoint,
};
use vademecum_format::{Chapter, File, SectionKind};
use vademecum_study::scenario::Scenario;

pub use self::body::{Body, Playable};

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
        let chapter = Chapter::read(file).map_err(|error| Failure::file(path, error))?;
        let contact = |entry: &vademecum_study::scenario::ContactEntry| {
            let surface = Surface::new(file).map_err(|error| Failure::file(path, error))?;
            let point = match &chapter {
                Some(chapter) => nearest_position(path, file, chapter, entry.point)?,
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

    /// Loads a body with the loads of a step.
    pub fn apply(&self, factors: &[[f64; 4]], body: &mut impl Playable) -> Result<(), Failure> {
        let failed = |error| Failure::new(Cause::File, error);
        body.clear_loads();
        let (contacts, patterns) = factors.split_at(self.contacts.len());
        for ((contact, _, _), factors) in self.contacts.iter().zip(contacts) {
            if factors.iter().any(|&f| f != 0.0) {
                body.add_contact(contact, factors).map_err(failed)?;
            }
        }
        for ((index, amplitude, _), factors) in self.patterns.iter().zip(patterns) {
            if factors.iter().any(|&f| f != 0.0) {
                body.add_pattern(*index, &factors.map(|f| f * amplitude)).map_err(failed)?;
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

/// Where a file of the chapter's structure can take a load meant for `point`: the nearest of its positions.
fn nearest_position(
    path: &Path,
    file: &File<'_>,
    chapter: &Chapter<'_>,
    point: [f64; 3],
) -> Result<SurfacePoint, Failure> {
    let section = file.section(SectionKind::NodeCoordinates).ok_or_else(|| no_surface(path))?;
    let numbers = section.numbers().map_err(|error| Failure::file(path, error))?;
    let at = |node: u32| [0, 1, 2].map(|c| numbers.get(3 * node as usize + c).unwrap_or(f64::NAN));
    let distance = |x: [f64; 3]| (0..3).map(|c| (x[c] - point[c]).powi(2)).sum::<f64>().sqrt();
    let places = chapter.positions().map(|node| (node, at(node), distance(at(node))));
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

/// Binds a scene of the chapter's structure in memory of its own and hands it over, at rest and unloaded.
pub fn with_chapter<T: Scalar, R>(
    path: &Path,
    file: &File<'_>,
    options: &SceneOptions,
    work: impl FnOnce(
        &ChapterScene<'_, T>,
        &mut ChapterState<'_, T>,
        &mut ChapterLoads<'_, T>,
    ) -> Result<R, Failure>,
) -> Result<R, Failure> {
    let bind = |error| Failure::file(path, error);
    let sizes = ChapterScene::<T>::sizes(file).map_err(bind)?;
    let mut memory = vec![T::ZERO; sizes.scene];
    let (mut state_memory, mut load_memory) = (vec![T::ZERO; sizes.state], vec![T::ZERO; sizes.loads]);
    let scene = ChapterScene::bind(file, options, &mut memory).map_err(bind)?;
    let mut state = ChapterState::new(&scene, &mut state_memory).map_err(bind)?;
    let mut loads = ChapterLoads::new(&scene, &mut load_memory).map_err(bind)?;
    work(&scene, &mut state, &mut loads)
}

/// What a scenario is played through.
#[derive(Clone, Copy, Debug, Default)]
pub struct PlayOptions {
    /// Whether the chapter's structure is asked for by name.
    pub chapter: bool,
    /// What the scene is bound to.
    pub scene: SceneOptions,
}

impl PlayOptions {
    /// Whether the chapter's scene is meant: it is asked for, or nothing is and the file has no other.
    pub fn takes_chapter(&self, file: &File<'_>) -> bool {
        let only = !file.metadata().diagonal && !file.metadata().block;
        self.chapter || (only && self.scene.structure == StructureChoice::Auto)
    }
}

/// Marches `steps` steps from rest and shows each state, the start included.
pub fn play(
    path: &Path,
    file: &File<'_>,
    options: &PlayOptions,
    track: &Track,
    steps: usize,
    mut observe: impl FnMut(usize, &dyn Playable<Number = f64>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    if !options.takes_chapter(file) {
        return play_in::<f64>(path, file, &options.scene, track, steps, observe);
    }
    with_chapter::<f64, _>(path, file, &options.scene, |scene, state, loads| {
        march(path, &mut Body { scene, state, loads }, track, steps, |step, body| observe(step, body))
    })
}

/// [`play`] through an ordinary scene, in the precision that `observe` takes.
pub fn play_in<T: Scalar>(
    path: &Path,
    file: &File<'_>,
    options: &SceneOptions,
    track: &Track,
    steps: usize,
    mut observe: impl FnMut(usize, &dyn Playable<Number = T>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    with_scene::<T, _>(path, file, options, |scene, state, loads| {
        march(path, &mut Body { scene, state, loads }, track, steps, |step, body| observe(step, body))
    })
}

fn march<B: Playable>(
    path: &Path,
    body: &mut B,
    track: &Track,
    steps: usize,
    mut observe: impl FnMut(usize, &B) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let (instants, time_step) = (body.instants(), body.time_step());
    let failed = |error| Failure::file(path, error);
    let mut factors = track.factors(&instants, time_step, 0);
    track.apply(&factors, body)?;
    body.start().map_err(failed)?;
    observe(0, body)?;
    for step in 0..steps {
        let next = track.factors(&instants, time_step, step);
        if next != factors {
            factors = next;
            track.apply(&factors, body)?;
        }
        body.step().map_err(failed)?;
        observe(step + 1, body)?;
        if cancelled() {
            return Err(Failure::new(Cause::Stopped, "stopped on request"));
        }
    }
    Ok(())
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
    options: &PlayOptions,
    track: &Track,
    steps: usize,
) -> Result<LongRun, Failure> {
    if options.takes_chapter(file) {
        return with_chapter::<f64, _>(path, file, &options.scene, |scene, state, loads| {
            long_march(path, &mut Body { scene, state, loads }, track, steps)
        });
    }
    with_scene::<f64, _>(path, file, &options.scene, |scene, state, loads| {
        long_march(path, &mut Body { scene, state, loads }, track, steps)
    })
}

fn long_march(
    path: &Path,
    body: &mut impl Playable,
    track: &Track,
    steps: usize,
) -> Result<LongRun, Failure> {
    let factors = track.factors(&body.instants(), body.time_step(), 0);
    track.apply(&factors, body)?;
    let failed = |error| Failure::file(path, error);

    let held = steps / 100;
    for _ in 0..held {
        body.step().map_err(failed)?;
    }
    body.clear_loads();
    // One free step first: the old acceleration still holds the force.
    body.step().map_err(failed)?;
    let release = body.energy().map_err(failed)?;
    let (mut largest, mut seconds, mut done) = (release, 0.0, held);
    // Energy is looked at between bursts, so that looking costs the timing nothing.
    const BURST: usize = 1000;
    while done < steps {
        let burst = BURST.min(steps - done);
        let start = Instant::now();
        for _ in 0..burst {
            body.step().map_err(failed)?;
        }
        seconds += start.elapsed().as_secs_f64();
        done += burst;
        largest = largest.max(body.energy().map_err(failed)?);
        if cancelled() {
            return Err(Failure::new(Cause::Stopped, "stopped on request"));
        }
    }
    let left = body.energy().map_err(failed)?;
    Ok(LongRun {
        steps,
        seconds_per_step: seconds / (steps - held) as f64,
        energy_ratio: largest / release,
        energy_left: left / release,
    })
}
