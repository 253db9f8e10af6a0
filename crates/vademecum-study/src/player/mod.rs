//! Plays a scenario through the evaluator: the same for a run, a verification and a comparison of methods.
//!
//! A file has one of two kinds of body: the evaluator's [`Body`], and that of the chapter's structure.
//! [`Playable`] is what both can do.

mod body;
pub(crate) mod chapter;
mod path;

use std::time::Instant;

use vademecum_build::dynamics::{History, INSTANTS, Window};
use vademecum_build::progress::{Cancelled, Listener};
use vademecum_build::suggest::did_you_mean;
use vademecum_chapter::ChapterScene;
use vademecum_eval::{
    Body, BodyOptions, Contact, Scalar, SceneOptions, StepError, StructureChoice, Surface, SurfacePoint,
};
use vademecum_format::{Chapter, File, SectionKind};

pub use body::{Playable, structure_name};
pub use chapter::ChapterBody;
use chapter::{nearest_position, positions_of};

use crate::contents::lines;
use crate::error::{FileError, StudyError};
use crate::near::{reach, within};
use crate::scenario::{ContactEntry, FreeEntry, MAX_LOADS, PatternUse, Scenario};

/// A contact of a scenario on the surface of a file: the whole of it, a component of its force, or a place on
/// its path.
#[derive(Clone, Debug)]
pub struct PlacedContact {
    /// Its number in the scenario.
    pub entry: usize,
    /// The force and where it acts, as the evaluator takes it.
    pub contact: Contact,
    /// Where that is on the surface.
    pub point: SurfacePoint,
    /// How it follows time.
    pub when: History,
}

/// A place on the surface, and the instants of its share if the contact moves.
type Placed = (SurfacePoint, Option<[f64; 3]>);

/// A load pattern of a scenario in a file.
#[derive(Clone, Debug)]
pub struct PlacedPattern {
    /// Its number in the file.
    pub index: usize,
    /// Factor on it.
    pub(crate) amplitude: f64,
    /// How it follows time.
    pub when: History,
}

/// A scenario bound to a file: contacts on its surface, patterns by number.
#[derive(Clone, Debug, Default)]
pub struct Track {
    /// The contacts, those of one entry side by side.
    pub contacts: Vec<PlacedContact>,
    /// The load patterns.
    pub patterns: Vec<PlacedPattern>,
    /// Acceleration of gravity in space \[m/s²\] of a free body that is thrown.
    pub gravity: [f64; 3],
}

impl Track {
    /// Finds each contact's triangle and each pattern's number.
    ///
    /// # Errors
    /// [`StudyError::NoPattern`]; [`StudyError::FarPoint`]: further from the loadable surface than the body
    /// is large; [`StudyError::File`]: a file without a surface, or with one that cannot be read.
    pub fn bind(file: &File<'_>, scenario: &Scenario) -> Result<Self, StudyError> {
        let chapter = Chapter::read(file)?;
        if !scenario.contacts.is_empty() {
            // A surface that cannot be computed with is not one that is missing.
            vademecum_rewrite::check_coordinates(file)?;
        }
        let positions = chapter.as_ref().filter(|_| !scenario.contacts.is_empty());
        let positions = positions.map(|chapter| positions_of(file, chapter)).transpose()?;
        let size = if scenario.contacts.is_empty() { f64::INFINITY } else { reach(file)? };
        let locate = |contact: usize, point: [f64; 3]| -> Result<SurfacePoint, StudyError> {
            let found = match &positions {
                Some(positions) => nearest_position(positions, point)?,
                None => Surface::new(file)?.locate(point).ok_or(FileError::NoSurface)?,
            };
            within(file, size, found, || format!("`contact[{contact}]`"))
        };
        let moving = scenario.contacts.iter().any(|entry| entry.path.is_some());
        if moving && chapter.is_some() {
            return Err(FileError::NoPaths.into());
        }
        let edge = if moving { path::mean_edge(file)? } else { 0.0 };
        // Where a contact is, and the share that falls to the place.
        let places = |index: usize, entry: &ContactEntry| -> Result<Vec<Placed>, StudyError> {
            let Some(rows) = entry.path_rows() else {
                return Ok(vec![(locate(index, entry.point.unwrap_or_default())?, None)]);
            };
            let places = path::places(&rows, edge, index)?;
            places.iter().map(|place| Ok((locate(index, place.point)?, Some(place.share)))).collect()
        };
        let mut contacts = vec![];
        for (index, entry) in scenario.contacts.iter().enumerate() {
            let forces = entry.forces(scenario.duration);
            for (point, share) in places(index, entry)? {
                for (force, history) in &forces {
                    let contact = Contact::new(point.place, *force);
                    let when = History { share, ..history.clone() };
                    contacts.push(PlacedContact { entry: index, contact, point, when });
                }
            }
            // A scenario is held to as many contacts; those that move are more.
            if contacts.len() > 3 * MAX_LOADS {
                return Err(StudyError::TooManyPlaces { contact: index, edge, most: MAX_LOADS });
            }
        }
        let names = lines(file, SectionKind::PatternNames)?;
        let pattern = |entry: &PatternUse| -> Result<PlacedPattern, StudyError> {
            let index = names.iter().position(|name| *name == entry.name).ok_or_else(|| {
                let known = if names.is_empty() { "none".into() } else { names.join(", ") };
                let known = known + &did_you_mean(&entry.name, names.iter().map(String::as_str));
                StudyError::NoPattern { name: entry.name.clone(), known }
            })?;
            Ok(PlacedPattern { index, amplitude: entry.amplitude, when: entry.history(scenario.duration) })
        };
        let patterns = scenario.patterns.iter().map(pattern).collect::<Result<_, _>>()?;
        Ok(Self { contacts, patterns, gravity: scenario.free.unwrap_or_default().gravity })
    }

    /// How each load follows time: contacts, then patterns.
    fn histories(&self) -> impl Iterator<Item = &History> {
        self.contacts.iter().map(|c| &c.when).chain(self.patterns.iter().map(|p| &p.when))
    }

    /// When the last load ends \[s\]; 0 without loads.
    pub fn release(&self) -> f64 {
        self.histories().map(History::end).fold(0.0, f64::max)
    }

    /// Factors of all loads at the given instants of a step: contacts, then patterns.
    pub fn factors(&self, instants: &[f64; INSTANTS], time_step: f64, step: usize) -> Vec<[f64; INSTANTS]> {
        let at = |when: &History| instants.map(|c| when.factor((step as f64 + c) * time_step));
        self.histories().map(at).collect()
    }

    /// Loads a body with loads by number, contacts first, and their amplitudes at the instants.
    pub(crate) fn apply_some(
        &self,
        acting: &[(usize, [f64; INSTANTS])],
        body: &mut impl Playable,
    ) -> Result<(), FileError> {
        body.clear();
        body.pull(self.gravity)?;
        for (index, factors) in acting {
            match index.checked_sub(self.contacts.len()) {
                None => body.push(&self.contacts[*index].contact, factors)?,
                Some(pattern) => {
                    let placed = &self.patterns[pattern];
                    body.push_pattern(placed.index, &factors.map(|f| f * placed.amplitude))?;
                }
            }
        }
        Ok(())
    }

    /// All loads at full height.
    pub fn full_height(&self) -> Vec<[f64; INSTANTS]> {
        vec![[1.0; INSTANTS]; self.contacts.len() + self.patterns.len()]
    }

    /// Loads a body with the loads of a step.
    ///
    /// # Errors
    /// [`FileError`]: a load that the evaluator refuses.
    pub fn apply(&self, factors: &[[f64; INSTANTS]], body: &mut impl Playable) -> Result<(), FileError> {
        let acts = |factors: &[f64; INSTANTS]| factors.iter().any(|&f| f != 0.0);
        let acting: Vec<_> =
            factors.iter().copied().enumerate().filter(|(_, factors)| acts(factors)).collect();
        self.apply_some(&acting, body)
    }
}

/// What a scenario is played through.
#[derive(Clone, Copy, Debug, Default)]
pub struct PlayOptions {
    /// Whether the chapter's structure is asked for by name.
    pub chapter: bool,
    /// What the scene is bound to.
    pub scene: SceneOptions,
    /// Whether more steps may be marched than a study takes unasked.
    pub long: bool,
}

impl PlayOptions {
    /// Whether the chapter's scene is meant: it is asked for, or nothing is and the file has no other.
    pub(crate) fn takes_chapter(&self, file: &File<'_>) -> bool {
        let strain = file.section(SectionKind::StrainSizes).is_some();
        let only = !file.metadata().diagonal && !file.metadata().block && !strain;
        self.chapter || (only && self.scene.structure == StructureChoice::Auto)
    }
}

/// Options of a body whose elastic motion alone is played, without room for its static answer.
#[must_use]
pub fn elastic(scene: &SceneOptions) -> BodyOptions {
    BodyOptions { scene: *scene, places: 0, flight: false, ..BodyOptions::default() }
}

/// The same with room for the static answer of the whole body, where the file has the factor of its
/// stiffness.
#[must_use]
pub fn elastic_with_fields(scene: &SceneOptions) -> BodyOptions {
    BodyOptions { static_field: true, ..elastic(scene) }
}

/// Binds a body in memory of its own and hands it over, at rest and unloaded.
///
/// # Errors
/// [`StudyError::File`]: a file or options that the evaluator refuses; those of `work`.
pub fn with_body<T: Scalar, R>(
    file: &File<'_>,
    options: &BodyOptions,
    work: impl FnOnce(&mut Body<'_, T>) -> Result<R, StudyError>,
) -> Result<R, StudyError> {
    let mut memory = vec![0.0; Body::<T>::len_for(file, options)?];
    work(&mut Body::bind(file, options, &mut memory)?)
}

/// Marches `steps` steps from rest and shows the body after each, the start included.
///
/// # Errors
/// [`StudyError::File`]: a file, a load or a step that the evaluator refuses; [`StudyError::Cancelled`];
/// those of `observe`.
pub fn play(
    file: &File<'_>,
    options: &PlayOptions,
    track: &Track,
    steps: usize,
    listener: &dyn Listener,
    mut observe: impl FnMut(usize, &mut dyn Playable<Number = f64>) -> Result<(), StudyError>,
) -> Result<(), StudyError> {
    if !options.takes_chapter(file) {
        return play_in::<f64>(file, &options.scene, track, steps, listener, observe);
    }
    let scene = ChapterScene::bind(file, &options.scene)?;
    let mut body = ChapterBody::new(&scene);
    march(&mut body, track, steps, listener, Playable::step, |step, body| observe(step, body))
}

/// [`play`] through the evaluator's body, in the precision that `observe` takes.
///
/// # Errors
/// As [`play`].
pub fn play_in<T: Scalar>(
    file: &File<'_>,
    options: &SceneOptions,
    track: &Track,
    steps: usize,
    listener: &dyn Listener,
    mut observe: impl FnMut(usize, &mut dyn Playable<Number = T>) -> Result<(), StudyError>,
) -> Result<(), StudyError> {
    with_body::<T, _>(file, &elastic_with_fields(options), |body| {
        march(body, track, steps, listener, Playable::step, |step, body| observe(step, body))
    })
}

/// [`play`] with a free body that is thrown: forces are those of space, patterns turn with the body. A load
/// acts over each step with the mean of its factor over the step, so its impulse is exact.
///
/// # Errors
/// As [`play`]; [`FileError::NotFree`]: a body with supports.
pub(crate) fn play_free(
    file: &File<'_>,
    options: &PlayOptions,
    (track, entry): (&Track, &FreeEntry),
    steps: usize,
    listener: &dyn Listener,
    mut observe: impl FnMut(usize, &mut dyn Playable<Number = f64>) -> Result<(), StudyError>,
) -> Result<(), StudyError> {
    let options = BodyOptions { flight: true, ..elastic_with_fields(&options.scene) };
    with_body::<f64, _>(file, &options, |body| {
        body.throw(entry.velocity, entry.spin).ok_or(FileError::NotFree)?;
        march(body, track, steps, listener, Playable::step, |step, body| observe(step, body))
    })
}

/// [`play`] through the strain structure, whose energy is accounted for: the largest violation of its
/// identity in any step, over the largest energy.
///
/// # Errors
/// As [`play`]; a file without the strain structure.
pub(crate) fn play_metered(
    file: &File<'_>,
    options: &SceneOptions,
    track: &Track,
    steps: usize,
    listener: &dyn Listener,
    mut observe: impl FnMut(usize, &mut dyn Playable<Number = f64>) -> Result<(), StudyError>,
) -> Result<f64, StudyError> {
    with_body::<f64, _>(file, &elastic_with_fields(options), |body| {
        let (mut worst, mut largest) = (0.0_f64, f64::MIN_POSITIVE);
        let metered = |body: &mut Body<'_, f64>| {
            let (_, account) = body.with(|parts| parts.scene.step_metered(parts.state, parts.loads))?;
            worst = worst.max(account.violation().abs());
            largest = largest.max(account.after);
            Ok(())
        };
        march(body, track, steps, listener, metered, |step, body| observe(step, body))?;
        Ok(worst / largest)
    })
}

/// Marches a body by what `take` does for one step.
fn march<B: Playable>(
    body: &mut B,
    track: &Track,
    steps: usize,
    listener: &dyn Listener,
    mut take: impl FnMut(&mut B) -> Result<(), FileError>,
    mut observe: impl FnMut(usize, &mut B) -> Result<(), StudyError>,
) -> Result<(), StudyError> {
    let (instants, time_step) = (body.instants(), body.time_step());
    let mut window = Window::new(track.histories().cloned().collect(), instants, time_step);
    // The body starts under the loads of the first instant, and what the modes leave out of the answer to
    // them is shown with it: a ramp that begins there is still zero, whatever it is at the end of the step.
    // Modes that are moved exactly need no acceleration, and a load that begins with a jump has moved nothing
    // yet. What pushes a body that flies acts for one step.
    let flies = body.flight().is_some();
    if !body.is_exact() && !flies {
        let first = window.acting(0).into_iter().map(|(index, factors)| (index, [factors[0]; INSTANTS]));
        track.apply_some(&first.collect::<Vec<_>>(), body)?;
    }
    body.start()?;
    observe(0, body)?;
    let mut acting = None;
    for step in 0..steps {
        let refused = |source| match source {
            FileError::Step(StepError::NotFinite) => StudyError::too_large(step + 1, time_step),
            source => StudyError::Refused { time: step as f64 * time_step, step, source },
        };
        let spans = if body.is_exact() { window.spans(step) } else { vec![] };
        let whole = spans.first().filter(|span| span.whole);
        if !spans.is_empty() && whole.is_none() {
            for span in &spans {
                let apply = |part: usize, body: &mut B| track.apply_some(&window.over(span, part), body);
                body.step_parts(span.length, span.parts, apply).map_err(refused)?;
            }
            // What the body is loaded with is of an earlier step.
            acting = None;
        } else {
            let next = match whole {
                Some(span) => window.over(span, 0),
                None if flies => window.means(step),
                None if body.takes_ends() => window.between_ends(step),
                None => window.acting(step),
            };
            if flies || acting.as_ref() != Some(&next) {
                track.apply_some(&next, body)?;
                acting = Some(next);
            }
            take(body).map_err(refused)?;
        }
        observe(step + 1, body)?;
        stop_if_asked(listener)?;
    }
    Ok(())
}

/// An error if the listener wants to stop.
pub fn stop_if_asked(listener: &dyn Listener) -> Result<(), Cancelled> {
    if listener.cancelled() { Err(Cancelled) } else { Ok(()) }
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

/// Marches `steps` steps: the first hundredth under the loads of the track's first step that has any, the
/// rest free.
///
/// # Errors
/// As [`play`].
pub fn long_run(
    file: &File<'_>,
    options: &PlayOptions,
    track: &Track,
    steps: usize,
    listener: &dyn Listener,
) -> Result<LongRun, StudyError> {
    if options.takes_chapter(file) {
        let scene = ChapterScene::bind(file, &options.scene)?;
        return long_march(&mut ChapterBody::new(&scene), track, steps, listener);
    }
    with_body::<f64, _>(file, &elastic(&options.scene), |body| long_march(body, track, steps, listener))
}

/// The loads of the first step in which any acts: without one a body would rest, and its steps cost nothing.
fn first_loads(track: &Track, body: &impl Playable) -> Vec<[f64; INSTANTS]> {
    /// Steps that are looked at, for loads that begin with nothing.
    const FEW: usize = 1000;
    let (instants, time_step) = (body.instants(), body.time_step());
    let start = track.histories().map(History::start).fold(f64::INFINITY, f64::min);
    let first = (start / time_step) as usize;
    let mut steps = (first..first.saturating_add(FEW)).map(|step| track.factors(&instants, time_step, step));
    let acting = steps.find(|factors| factors.as_flattened().iter().any(|&factor| factor != 0.0));
    acting.unwrap_or_else(|| track.full_height())
}

fn long_march(
    body: &mut impl Playable,
    track: &Track,
    steps: usize,
    listener: &dyn Listener,
) -> Result<LongRun, StudyError> {
    track.apply(&first_loads(track, body), body)?;
    let held = steps / 100;
    for _ in 0..held {
        body.step()?;
    }
    body.clear();
    // One free step first: the old acceleration still holds the force.
    body.step()?;
    let release = body.energy()?;
    let (mut largest, mut seconds, mut done) = (release, 0.0, held);
    // Energy is looked at between bursts, so that looking costs the timing nothing.
    const BURST: usize = 1000;
    while done < steps {
        let burst = BURST.min(steps - done);
        let start = Instant::now();
        for _ in 0..burst {
            body.step()?;
        }
        seconds += start.elapsed().as_secs_f64();
        done += burst;
        largest = largest.max(body.energy()?);
        stop_if_asked(listener)?;
    }
    let left = body.energy()?;
    Ok(LongRun {
        steps,
        seconds_per_step: seconds / (steps - held) as f64,
        energy_ratio: largest / release,
        energy_left: left / release,
    })
}
