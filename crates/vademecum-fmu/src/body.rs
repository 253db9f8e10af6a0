//! The body of an instance: a scene in double precision, one state, its loads, and the numbers that a master
//! has set.
//!
//! Loads are made of the inputs when a step needs them. What the modes leave out of a static answer belongs
//! to the inputs of the last step, so those are remembered beside the present ones: a saved body shows the
//! same outputs when it is taken back.
//!
//! Note: the body of a file with live regions is replaced where it is when one of them is set, and its file
//! with it. Names, counts and places are those of the file as it was given.
#![allow(unsafe_code)]

use vademecum_eval::format::{File, SectionKind};
use vademecum_eval::{BindError, LiveMemory, RigidMotion, SceneOptions, StepError};

use crate::acting::{Acting, next_force};
use crate::bytes::copy;
use crate::flight::Flight;
use crate::names::{Names, text};
use crate::parameters::{ask, has_live, parameter, set_whole};
use crate::points::Points;
use crate::refusal::Refusal;
use crate::room::{Lengths, body_options};
use crate::variables::{Counts, Elements, References, Variable};

/// Internal steps of one call at most: beyond that a caller has confused units, and would wait for hours.
pub const MAX_STEPS: u64 = 1_000_000_000;

/// A body that is stepped.
#[derive(Debug)]
pub struct Body {
    pub(crate) counts: Counts,
    references: References,
    pub(crate) points: Points<'static>,
    pub(crate) names: Names,
    /// Start and last step of the flight of a body without supports.
    pub(crate) flight: Option<Flight>,
    pub(crate) body: vademecum_eval::Body<'static, f64>,
    /// The file as it was given.
    pub(crate) file: File<'static>,
    /// Memory of a file with live regions.
    pub(crate) live: Option<LiveMemory<'static>>,
    /// Values of all parameters that are asked for.
    pub(crate) asked: &'static mut [f64],
    /// Those before a change that may fail.
    pub(crate) before: &'static mut [f64],
    /// Forces on the points, three numbers each, then amplitudes of the patterns, then the force on the
    /// centre of a free body.
    pub(crate) inputs: &'static mut [f64],
    /// The same of the last step.
    pub(crate) shown: &'static mut [f64],
    /// A state: the one before a step that may fail, or one on its way in or out. Zero behind its numbers.
    pub(crate) saved: &'static mut [f64],
    /// The state before one is taken back that may be refused.
    pub(crate) kept: &'static mut [f64],
    /// The loads are not those of the inputs.
    pub(crate) stale: bool,
    /// `Δt` \[s\] of the file; a communication step that is no multiple of it is cut otherwise.
    pub(crate) internal_step: f64,
    pub(crate) last: LastStep,
    /// Surface nodes in use.
    pub(crate) surface: u32,
}

/// Internal steps of the last communication step: what derivatives look back on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LastStep {
    /// Their number; 0 before the first one.
    pub steps: u64,
    /// True if it began from a state that had no acceleration yet.
    pub is_first: bool,
    /// True if parameters have changed since.
    pub is_stale: bool,
}

impl Body {
    /// Numbers to lend for a body with so many points.
    ///
    /// # Errors
    /// [`BindError`]: a file that cannot be stepped.
    pub fn len_for(file: &File<'_>, points: &Points<'_>) -> Result<usize, BindError> {
        Ok(Lengths::of(file, &body_options(file, points), points)?.sum())
    }

    /// A body at rest, at the parameters that the file was built for.
    ///
    /// # Errors
    /// [`BindError`]: a file that cannot be stepped, memory that is too short.
    pub fn new(
        file: &File<'static>,
        points: Points<'static>,
        memory: &'static mut [f64],
    ) -> Result<Self, BindError> {
        let options = body_options(file, &points);
        let lengths = Lengths::of(file, &options, &points)?;
        let short = BindError::LentMemory { found: memory.len(), needed: lengths.sum() };
        let Lengths { body, parameters, inputs, saved } = lengths;
        let (body, rest) = memory.split_at_mut_checked(body).ok_or(short)?;
        let (asked, rest) = rest.split_at_mut_checked(parameters).ok_or(short)?;
        let (before, rest) = rest.split_at_mut_checked(parameters).ok_or(short)?;
        let (own_inputs, rest) = rest.split_at_mut_checked(inputs).ok_or(short)?;
        let (shown, rest) = rest.split_at_mut_checked(inputs).ok_or(short)?;
        let (saved, rest) = rest.split_at_mut_checked(saved).ok_or(short)?;
        let kept = rest.get_mut(..saved.len()).ok_or(short)?;
        let (live, body) = if has_live(file) {
            let (live, body) = LiveMemory::bind(file, &options, body)?;
            (Some(live), body)
        } else {
            (None, vademecum_eval::Body::bind(file, &options, body)?)
        };
        saved.fill(0.0);
        let counts =
            Counts::of(file, points.named() as u32, points.stresses() as u32, points.surface() as u32);
        let names = Names {
            patterns: text(file, SectionKind::PatternNames),
            probes: text(file, SectionKind::ProbeNames),
            supports: text(file, SectionKind::SupportNames),
        };
        own_inputs.fill(0.0);
        shown.fill(0.0);
        let (flight, internal_step) = (body.flight().map(Flight::new), body.time_step());
        let (inputs, stale) = (own_inputs, false);
        Ok(Self {
            counts,
            references: counts.references(),
            points,
            names,
            flight,
            body,
            file: *file,
            live,
            asked,
            before,
            inputs,
            shown,
            saved,
            kept,
            stale,
            internal_step,
            last: LastStep::default(),
            surface: counts.surface,
        })
    }

    /// Counts of the body.
    #[must_use]
    pub const fn counts(&self) -> &Counts {
        &self.counts
    }

    /// `Δt` \[s\] of the file.
    #[must_use]
    pub const fn internal_step(&self) -> f64 {
        self.internal_step
    }

    /// True where steps of any length are exact.
    #[must_use]
    pub const fn takes_any_step(&self) -> bool {
        self.counts.exact != 0
    }

    /// Modes of the basis.
    #[must_use]
    pub const fn n_modes(&self) -> usize {
        self.body.scene().n_modes()
    }

    /// Puts everything back as it was made.
    ///
    /// # Errors
    /// [`Refusal::Bind`] can only come from a file that has changed.
    pub fn reset(&mut self) -> Result<(), Refusal> {
        let options = body_options(&self.file, &self.points).scene;
        // Without loads and at rest, nothing is left of what was.
        self.body.clear();
        self.body.rest();
        let _ = self.body.rebind(&options)?;
        let nominal = self.file.parameters().map(|parameter| parameter.nominal);
        self.asked.iter_mut().zip(nominal).for_each(|(asked, nominal)| *asked = nominal);
        self.set_live()?;
        self.inputs.fill(0.0);
        self.shown.fill(0.0);
        self.flight = self.body.flight().map(Flight::new);
        self.stale = false;
        self.last = LastStep::default();
        self.surface = self.counts.surface;
        Ok(())
    }

    /// Memory of a force or an amplitude.
    pub(crate) const fn input(&self, variable: Variable) -> Option<usize> {
        match variable {
            Variable::Force(point, component) => Some(3 * point as usize + component as usize),
            Variable::Pattern(pattern) => Some(3 * self.points.len() + pattern as usize),
            Variable::BodyForce(c) => {
                Some(3 * self.points.len() + self.counts.patterns as usize + c as usize)
            }
            _ => None,
        }
    }

    /// Value of a parameter that an FMU offers.
    pub(crate) fn parameter(&self, index: u32) -> Option<f64> {
        let as_bound = parameter(self.body.scene().options(), &self.file, index)?;
        match &self.live {
            Some(live) => live.values().get(index as usize).copied(),
            None => Some(as_bound),
        }
    }

    /// Sets live regions, and what else a file with them has, to the values asked for; true if these are
    /// others.
    pub(crate) fn set_live(&mut self) -> Result<bool, BindError> {
        let changed = self.live.as_mut().filter(|live| live.values() != &*self.asked);
        let Some(live) = changed else { return Ok(false) };
        copy(live.values(), self.before);
        // SAFETY: the body is that of this memory, and nothing that a call keeps borrows from it: points,
        // names and places are those of the file as it was given.
        let _ = unsafe { live.set_all(self.asked, &mut self.body)? };
        Ok(true)
    }

    /// Asks for the values that there are.
    fn ask_live(&mut self) {
        copy(self.live.as_ref().map_or(&[][..], LiveMemory::values), self.asked);
    }

    /// Sets forces, amplitudes and parameters, and before the first step where a flight starts: all of them
    /// or, if one is refused, none. `settings` gives each variable with its value, the same ones each time it
    /// is called.
    ///
    /// # Errors
    /// [`Refusal`], and the variable it is about.
    pub fn set<I: Iterator<Item = (Variable, f64)>>(
        &mut self,
        settings: impl Fn() -> I,
        starting: bool,
    ) -> Result<(), (Variable, Refusal)> {
        let before = *self.body.scene().options();
        let mut options = before;
        let mut last = None;
        let mut flight = self.flight;
        self.ask_live();
        let mut thrown = None;
        for (variable, value) in settings() {
            if !value.is_finite() {
                return Err((variable, Refusal::NotFinite { value }));
            }
            match variable {
                Variable::Force(..) | Variable::Pattern(_) | Variable::BodyForce(_) => {}
                _ if starting && Flight::is_start(variable) => {
                    let flight = flight.as_mut().ok_or((variable, Refusal::NoVariable))?;
                    flight.set(variable, value);
                    thrown = Some(variable);
                }
                Variable::Parameter(index) => {
                    if parameter(&options, &self.file, index).is_none() {
                        return Err((variable, Refusal::NoVariable));
                    }
                    let done = match self.asked.get_mut(index as usize).filter(|_| self.live.is_some()) {
                        Some(asked) => ask(asked, &self.file, index, value),
                        None => options.set(self.file.metadata(), &[(index as usize, value)]),
                    };
                    done.map_err(|error| (variable, Refusal::Parameter(error)))?;
                    last = Some(variable);
                }
                Variable::Whole(index) => {
                    set_whole(&mut options, &self.file, index, value)
                        .map_err(|refusal| (variable, refusal))?;
                    last = Some(variable);
                }
                _ => return Err((variable, Refusal::NotSettable)),
            }
        }
        let begin = |body: &Self, flight: &Option<Flight>| {
            let (flight, free) = (flight.as_ref()?, body.body.flight()?);
            flight.begin(free.body())
        };
        if let Some(variable) = thrown {
            let refusal = Refusal::Unsupported("an attitude of zero is none");
            begin(self, &flight).ok_or((variable, refusal))?;
        }
        if let Some(variable) = last {
            let refused = |error| (variable, Refusal::Bind(error));
            if self.live.is_none() || options != before {
                let _ = self.body.rebind(&options).map_err(refused)?;
            }
            match self.set_live() {
                Ok(is_changed) => {
                    let is_other = is_changed || options != before;
                    self.last.is_stale |= is_other && self.last.steps > 0;
                }
                Err(error) => {
                    let _ = self.body.rebind(&before).map_err(refused)?;
                    return Err(refused(error));
                }
            }
            self.stale = true;
        }
        if thrown.is_some() {
            // At the mass that belongs to the parameters.
            let motion = begin(self, &flight);
            let _ = motion.and_then(|motion| self.body.set_motion(motion));
        }
        self.flight = flight;
        for (variable, value) in settings() {
            if let Some(place) = self.input(variable).and_then(|at| self.inputs.get_mut(at)) {
                // The sign of a zero is no change.
                self.stale |= *place != value;
                *place = value;
            }
        }
        Ok(())
    }

    /// Meaning of each reference.
    #[must_use]
    pub const fn references(&self) -> &References {
        &self.references
    }

    /// The variables of references, arrays row by row.
    pub fn elements<'r>(&self, references: &'r [u32]) -> Elements<'r> {
        self.references.elements(references, self.surface)
    }

    /// Internal steps of the last communication step.
    #[must_use]
    pub const fn last_step(&self) -> LastStep {
        self.last
    }

    /// Takes the last internal steps for one communication step.
    pub const fn join_steps(&mut self, last: LastStep) {
        self.last = last;
    }

    /// True of a body that bends far, whose file says how far it was trained.
    #[must_use]
    pub fn can_leave_training(&self) -> bool {
        self.body.scene().training(self.body.state()).is_ok()
    }

    /// True if its state is one that the training has seen.
    #[must_use]
    pub fn is_inside_training(&self) -> bool {
        let training = self.body.scene().training(self.body.state());
        training.is_ok_and(|training| training.is_inside())
    }

    /// Surface nodes in use.
    #[must_use]
    pub const fn surface(&self) -> u32 {
        self.surface
    }

    /// Uses so many surface nodes; no force acts on the others.
    ///
    /// # Errors
    /// [`Refusal::SurfaceNodes`]; the body is then as it was.
    pub fn set_surface(&mut self, nodes: u64) -> Result<(), Refusal> {
        let most = self.counts.surface;
        let refusal = Refusal::SurfaceNodes { found: nodes, most };
        let nodes = u32::try_from(nodes).ok().filter(|nodes| (1..=most).contains(nodes)).ok_or(refusal)?;
        let used = self.counts.points.saturating_add(nodes) as usize;
        let idle = most.saturating_sub(nodes) as usize;
        let forces = self.inputs.iter_mut().skip(used.saturating_mul(3)).take(idle.saturating_mul(3));
        forces.for_each(|force| *force = 0.0);
        (self.surface, self.stale) = (nodes, true);
        Ok(())
    }

    /// Takes so many steps of `time_step` \[s\] under the inputs, which are held.
    ///
    /// # Errors
    /// [`Refusal`]; the body is then where it was.
    pub fn step(&mut self, steps: u64, time_step: f64) -> Result<(), Refusal> {
        let before = (self.flight, self.body.flight().copied(), *self.body.scene().options());
        let is_other = time_step != self.body.time_step();
        self.save_state()?;
        let is_first = self.saved_is_first();
        let mut taken = 0;
        if let Err(refusal) = self.take(steps, time_step, &mut taken) {
            if is_other {
                let _ = self.body.rebind(&before.2)?;
            }
            self.flight = before.0;
            self.body.with(|parts| *parts.flight = before.1);
            if is_other || taken > 0 {
                self.put_back()?;
            }
            return Err(refusal);
        }
        if steps > 0 {
            self.last = LastStep { steps, is_first, is_stale: false };
            self.shown.iter_mut().zip(&*self.inputs).for_each(|(shown, &input)| *shown = input);
        }
        Ok(())
    }

    /// Takes steps and counts them, up to one that is refused.
    fn take(&mut self, steps: u64, time_step: f64, taken: &mut u64) -> Result<(), Refusal> {
        if time_step != self.body.time_step() {
            let options = SceneOptions { time_step: Some(time_step), ..*self.body.scene().options() };
            let _ = self.body.rebind(&options)?;
            self.stale = true;
        }
        if self.stale && self.flight.is_none() {
            self.load()?;
            self.stale = false;
        }
        while *taken < steps {
            match self.flight {
                Some(_) => self.fly()?,
                None => self.body.step().map(drop)?,
            }
            *taken += 1;
        }
        Ok(())
    }

    /// A step of a free body, in the directions of space.
    fn fly(&mut self) -> Result<(), Refusal> {
        let pull = self.load()?;
        self.body.pull(pull)?;
        let (Some(flight), Some(free)) = (&mut self.flight, self.body.flight()) else {
            return Err(Refusal::NoVariable);
        };
        flight.turned = free.middle(self.body.scene());
        let spin = |motion: &RigidMotion| motion.spin(free.body());
        flight.spins = [spin(free.motion()), spin(&free.ahead(self.body.scene()))];
        self.body.step()?;
        Ok(())
    }

    /// Makes the loads of the inputs; the force on the centre of a free body. A point without force stays
    /// out, so that an unloaded body can rest.
    fn load(&mut self) -> Result<[f64; 3], Refusal> {
        let Self { body, points, inputs, counts, .. } = self;
        let mut inputs = inputs.iter().copied();
        body.clear();
        for index in 0..points.len() {
            let force = next_force(&mut inputs);
            let Some(point) = points.get(index).filter(|_| force != [0.0; 3]) else { continue };
            body.push(&point.place, force)?;
        }
        for (pattern, amplitude) in inputs.by_ref().take(counts.patterns as usize).enumerate() {
            if amplitude != 0.0 {
                body.push_pattern(pattern, amplitude)?;
            }
        }
        Ok(next_force(&mut inputs))
    }

    /// Saves coordinates and filtered forces.
    pub(crate) fn save_state(&mut self) -> Result<(), Refusal> {
        self.saved.fill(0.0);
        let numbers = self.body.scene().state_numbers();
        let (state, rest) = self.saved.split_at_mut_checked(numbers).ok_or(StepError::Mismatch)?;
        let filter = rest.get_mut(..self.body.state().filter_numbers()).ok_or(StepError::Mismatch)?;
        self.body.state().save_into(state)?;
        self.body.state().save_filter_into(filter)?;
        Ok(())
    }

    /// True if the saved state has no acceleration yet: all zeros, the last one marked by its sign.
    fn saved_is_first(&self) -> bool {
        let state = self.saved.get(..self.body.scene().state_numbers()).unwrap_or_default();
        let is_marked = state.last().is_some_and(|last| last.is_sign_negative());
        is_marked && state.iter().all(|&number| number == 0.0)
    }

    /// Takes the saved state back, with the loads of the step that led to it.
    pub(crate) fn put_back(&mut self) -> Result<(), Refusal> {
        let Self { body, flight, points, counts, shown, saved, .. } = self;
        let acting = Acting { points, patterns: counts.patterns, flight: flight.as_ref() };
        body.with(|parts| acting.restore(parts, shown.iter().copied(), saved))?;
        self.stale = true;
        Ok(())
    }
}
