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

use vademecum_eval::format::{File, Parameter, ParameterRole, SectionKind};
use vademecum_eval::{
    BindError, BodyOptions, BodyParts, Contact, Field, LiveMemory, OutputError, ParameterError, RigidMotion,
    SceneOptions, StepError, StructureChoice, SurfacePoint,
};

use crate::bytes::{Cursor, Pen};
use crate::flight::{self, Flight};
use crate::points::{Point, Points};
use crate::refusal::Refusal;
use crate::variables::{Counts, Variable, has_live_regions};

/// A body that is stepped.
#[derive(Debug)]
pub struct Body {
    counts: Counts,
    points: Points<'static>,
    names: Names,
    /// Start and last step of the flight of a body without supports.
    flight: Option<Flight>,
    body: vademecum_eval::Body<'static, f64>,
    /// The file as it was given.
    file: File<'static>,
    /// Memory of a file with live regions.
    live: Option<LiveMemory<'static>>,
    /// Values of all parameters that are asked for.
    asked: &'static mut [f64],
    /// Those before a change that may fail.
    before: &'static mut [f64],
    /// Forces on the points, three numbers each, then amplitudes of the patterns, then the force on the
    /// centre of a free body.
    inputs: &'static mut [f64],
    /// The same of the last step.
    shown: &'static mut [f64],
    /// A state: the one before a step that may fail, or one on its way in or out. Zero behind its numbers.
    saved: &'static mut [f64],
    /// The state before one is taken back that may be refused.
    kept: &'static mut [f64],
    /// The loads are not those of the inputs.
    stale: bool,
    /// `Δt` \[s\] of the file; a communication step that is no multiple of it is cut otherwise.
    internal_step: f64,
}

/// The motion of the point and the reaction of the support that were looked at last: their other components
/// follow, most of the time.
#[derive(Debug, Default)]
pub struct Seen {
    point: Option<(u32, Field, [f64; 3])>,
    support: Option<(u32, [f64; 6])>,
}

/// One name a line, as the file has them.
#[derive(Clone, Copy, Debug)]
struct Names {
    patterns: &'static str,
    probes: &'static str,
    supports: &'static str,
}

/// Numbers that a body wants.
struct Lengths {
    body: usize,
    parameters: usize,
    inputs: usize,
    saved: usize,
}

impl Lengths {
    fn of(file: &File<'_>, options: &BodyOptions, points: usize) -> Result<Self, BindError> {
        let (metadata, each) = (file.metadata(), 4 * file.contact_nodes());
        let inputs = points.saturating_mul(3).saturating_add(metadata.n_patterns as usize).saturating_add(3);
        // With the filtered forces of all points and patterns.
        let filtered = points.max(1).saturating_mul(each).saturating_add(metadata.n_patterns as usize);
        let saved = filtered.saturating_add(3 + 3 * metadata.n_modes as usize);
        let length =
            if has_live(file) { LiveMemory::len_for::<f64> } else { vademecum_eval::Body::<f64>::len_for };
        Ok(Self { body: length(file, options)?, parameters: parameters(file), inputs, saved })
    }

    fn sum(&self) -> usize {
        let Self { body, parameters, inputs, saved } = *self;
        let twice = [body, parameters, parameters, inputs, inputs, saved, saved];
        twice.into_iter().fold(0, usize::saturating_add)
    }
}

/// True of a file with live regions that are set.
fn has_live(file: &File<'_>) -> bool {
    file.section(SectionKind::LiveParameters).is_some()
}

/// Number of live parameters.
fn parameters(file: &File<'_>) -> usize {
    file.parameters().fold(0, |count, _| count + 1)
}

/// Options of the evaluator's body: no compliance is asked for.
fn body_options(file: &File<'_>, points: usize) -> BodyOptions {
    BodyOptions { scene: options(file, points), places: 0, ..BodyOptions::default() }
}

/// Structure that a body of a file is bound with: that of `vademecum run`, except that a file with live
/// regions takes the one that knows them from the start.
#[must_use]
pub fn options(file: &File<'_>, points: usize) -> SceneOptions {
    let metadata = file.metadata();
    let structure = if has_live_regions(metadata) && metadata.block {
        StructureChoice::Block
    } else {
        StructureChoice::Auto
    };
    // Room for every point, whether it is loaded or not; without any, reactions would not remember patterns.
    let (contacts, filtered_nodes) = (points.max(1), Some(file.contact_nodes() * points.max(1)));
    SceneOptions { structure, contacts, filtered_nodes, ..SceneOptions::default() }
}

impl Body {
    /// Numbers to lend for a body with so many points.
    ///
    /// # Errors
    /// [`BindError`]: a file that cannot be stepped.
    pub fn len_for(file: &File<'_>, points: usize) -> Result<usize, BindError> {
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
        let options = body_options(file, points.len());
        let lengths = Lengths::of(file, &options, points.len())?;
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
        let counts = Counts::of(file, points.len() as u32, points.stresses() as u32);
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
        let options = options(&self.file, self.points.len());
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
        Ok(())
    }

    /// Memory of a force or an amplitude.
    const fn input(&self, variable: Variable) -> Option<usize> {
        match variable {
            Variable::Force(point, component) => Some(3 * point as usize + component as usize),
            Variable::Pattern(pattern) => Some(3 * self.points.len() + pattern as usize),
            Variable::BodyForce(c) => {
                Some(3 * self.points.len() + self.counts.patterns as usize + c as usize)
            }
            _ => None,
        }
    }

    /// Value of a variable other than the time. `seen` is what the same call has computed before.
    ///
    /// # Errors
    /// [`Refusal::Output`]: a file stripped of what shows it.
    pub fn value(&self, variable: Variable, seen: &mut Seen) -> Result<f64, Refusal> {
        use Variable as V;
        Ok(match variable {
            V::Step => self.internal_step,
            V::Energy => self.body.energy()?,
            V::Force(..) | V::Pattern(_) | V::BodyForce(_) => {
                let place = self.input(variable).and_then(|at| self.inputs.get(at));
                *place.ok_or(Refusal::NoVariable)?
            }
            V::Displacement(point, component) => {
                self.at_point(point, component, Field::Displacement, seen)?
            }
            V::Velocity(point, component) => self.at_point(point, component, Field::Velocity, seen)?,
            V::Probe(probe) => self.body.probe(probe as usize, Field::Displacement)?,
            V::ProbeVelocity(probe) => self.body.probe(probe as usize, Field::Velocity)?,
            V::Parameter(index) => self.parameter(index).ok_or(Refusal::NoVariable)?,
            V::Whole(index) => {
                whole(self.body.scene().options(), &self.file, index).ok_or(Refusal::NoVariable)?
            }
            V::VonMises(index) => self.von_mises(index)?,
            V::ReactionForce(support, c) => self.reaction(support, c, seen)?,
            V::ReactionMoment(support, c) => self.reaction(support, c.saturating_add(3), seen)?,
            V::BodyPosition(_) | V::BodyAttitude(_) | V::BodyVelocity(_) | V::BodySpin(_) => self
                .body
                .flight()
                .and_then(|free| flight::value(free, variable))
                .ok_or(Refusal::NoVariable)?,
            V::Total(index) => self.body.total(Variable::total(index).ok_or(Refusal::NoVariable)?)?,
            V::Time => return Err(Refusal::NoVariable),
        })
    }

    /// Value of a parameter that an FMU offers.
    fn parameter(&self, index: u32) -> Option<f64> {
        let as_bound = parameter(self.body.scene().options(), &self.file, index)?;
        match &self.live {
            Some(live) => live.values().get(index as usize).copied(),
            None => Some(as_bound),
        }
    }

    /// Sets live regions, and what else a file with them has, to the values asked for; true if these are
    /// others.
    fn set_live(&mut self) -> Result<bool, BindError> {
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

    /// The equivalent stress of a place; of a node between regions, the largest of its values.
    fn von_mises(&self, index: u32) -> Result<f64, Refusal> {
        let place = self.points.stress(index as usize).ok_or(Refusal::NoVariable)?;
        let mut most = 0.0f64;
        let scene = self.body.scene();
        for point in 0..scene.n_stress_points() {
            if scene.stress_point(point).is_some_and(|point| point.node == place.node) {
                most = most.max(scene.stress(self.body.state(), point)?.von_mises());
            }
        }
        Ok(most)
    }

    /// A component of a reaction: force, then moment.
    fn reaction(&self, support: u32, component: u32, seen: &mut Seen) -> Result<f64, Refusal> {
        let exerted = match seen.support {
            Some((known, exerted)) if known == support => exerted,
            _ => self.body.scene().reaction(self.body.state(), support as usize)?.total(),
        };
        seen.support = Some((support, exerted));
        exerted.get(component as usize).copied().ok_or(Refusal::NoVariable)
    }

    fn at_point(&self, index: u32, component: u32, field: Field, seen: &mut Seen) -> Result<f64, Refusal> {
        let moved = match seen.point {
            Some((point, of, moved)) if (point, of) == (index, field) => moved,
            _ => {
                let missing = OutputError::OutOfRange { index: index as usize, count: self.points.len() };
                let place = placed(self.body.file(), &self.points.get(index as usize).ok_or(missing)?);
                let (scene, state) = (self.body.scene(), self.body.state());
                match (self.body.flight(), field) {
                    (None, _) => self.body.point(&place, field)?,
                    // In space, the rigid motion included.
                    (Some(free), Field::Displacement) => {
                        let [x, y, z] = free.point(scene, state, &place)?;
                        let [a, b, c] = place.position;
                        [x - a, y - b, z - c]
                    }
                    (Some(free), Field::Velocity) => free.velocity(scene, state, &place)?,
                }
            }
        };
        seen.point = Some((index, field, moved));
        moved.get(component as usize).copied().ok_or(Refusal::NoVariable)
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
            if let Err(error) = self.set_live() {
                let _ = self.body.rebind(&before).map_err(refused)?;
                return Err(refused(error));
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

    /// Takes so many steps of `time_step` \[s\] under the inputs, which are held.
    ///
    /// # Errors
    /// [`Refusal`]; the body is then where it was.
    pub fn step(&mut self, steps: u64, time_step: f64) -> Result<(), Refusal> {
        let before = (self.flight, self.body.flight().copied(), *self.body.scene().options());
        let is_other = time_step != self.body.time_step();
        self.save_state()?;
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
    fn save_state(&mut self) -> Result<(), Refusal> {
        self.saved.fill(0.0);
        let numbers = self.body.scene().state_numbers();
        let (state, rest) = self.saved.split_at_mut_checked(numbers).ok_or(StepError::Mismatch)?;
        let filter = rest.get_mut(..self.body.state().filter_numbers()).ok_or(StepError::Mismatch)?;
        self.body.state().save_into(state)?;
        self.body.state().save_filter_into(filter)?;
        Ok(())
    }

    /// Takes the saved state back, with the loads of the step that led to it.
    fn put_back(&mut self) -> Result<(), Refusal> {
        let Self { body, flight, points, counts, shown, saved, .. } = self;
        let acting = Acting { points, patterns: counts.patterns, flight: flight.as_ref() };
        body.with(|parts| acting.restore(parts, shown.iter().copied(), saved))?;
        self.stale = true;
        Ok(())
    }

    /// Bytes that [`Body::save_into`] writes.
    #[must_use]
    pub const fn saved_len(&self) -> usize {
        let flight = if self.flight.is_some() { flight::NUMBERS } else { 0 };
        8 * (self.asked.len() + WHOLE + 1 + flight + 2 * self.inputs.len() + self.saved.len())
    }

    /// Writes everything that can change: parameters, scales and damping of the whole body, length of the
    /// last step, flight, inputs, inputs of the last step, state.
    ///
    /// # Errors
    /// [`Refusal::Saved`]: no room.
    pub fn save_into(&mut self, pen: &mut Pen<'_>) -> Result<(), Refusal> {
        for index in 0..self.counts.parameters {
            let value = self.parameter(index).unwrap_or_default();
            self.asked.iter_mut().skip(index as usize).take(1).for_each(|place| *place = value);
        }
        let mut own = [self.body.time_step(); WHOLE + 1];
        for (index, place) in (0..WHOLE as u32).zip(&mut own) {
            *place = whole(self.body.scene().options(), &self.file, index).unwrap_or_default();
        }
        self.save_state()?;
        let flight = self.flight.zip(self.body.flight()).map(|(flight, free)| flight.numbers(free.motion()));
        let flight = flight.as_ref().map_or(&[][..], |numbers| &numbers[..]);
        let parts = [&*self.asked, &own, flight, self.inputs, self.shown, self.saved];
        for part in parts {
            pen.numbers(part).ok_or(Refusal::Saved("there is no room for it"))?;
        }
        Ok(())
    }

    /// Takes back what [`Body::save_into`] has written.
    ///
    /// # Errors
    /// [`Refusal`]; the body is then as it was.
    pub fn restore(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        const SHORT: Refusal = Refusal::Saved("it is too short");
        cursor.numbers(self.asked).ok_or(SHORT)?;
        let mut own = [0.0; WHOLE + 1];
        cursor.numbers(&mut own).ok_or(SHORT)?;
        let mut flight = None;
        if self.flight.is_some() {
            let mut numbers = [0.0; flight::NUMBERS];
            cursor.numbers(&mut numbers).ok_or(SHORT)?;
            flight = Some(Flight::restored(&numbers).ok_or(Refusal::Saved("its flight is none"))?);
        }
        let inputs = cursor.take(8 * self.inputs.len()).ok_or(SHORT)?;
        let shown = cursor.take(8 * self.shown.len()).ok_or(SHORT)?;
        let state = cursor.take(8 * self.saved.len()).ok_or(SHORT)?;
        let numbers = |bytes| <[u8]>::as_chunks(bytes).0.iter().map(|&number| f64::from_le_bytes(number));
        let all = own.into_iter().chain(numbers(inputs)).chain(numbers(shown)).chain(numbers(state));
        if !{ all }.all(f64::is_finite) {
            return Err(Refusal::Saved("it has a number that is not finite"));
        }
        let before = (*self.body.scene().options(), self.body.flight().copied());
        let mut options = before.0;
        for (index, asked) in (0..).zip(&mut *self.asked) {
            let value = *asked;
            match parameter(&options, &self.file, index) {
                Some(_) if self.live.is_some() => ask(asked, &self.file, index, value)?,
                Some(_) => options.set(self.file.metadata(), &[(index as usize, value)])?,
                // The step, which an FMU does not offer.
                None => *asked = self.file.parameters().nth(index as usize).map_or(value, |own| own.nominal),
            }
        }
        if self.takes_any_step() {
            let [scales @ .., time_step] = own;
            for (index, value) in (0..).zip(scales) {
                if whole(&options, &self.file, index).is_some() {
                    set_whole(&mut options, &self.file, index, value)?;
                }
            }
            if !(time_step > 0.0 && time_step <= self.internal_step) {
                return Err(Refusal::Saved("its last step has no length"));
            }
            options.time_step = Some(time_step);
        }
        self.save_state()?;
        copy(self.saved, self.kept);
        if options != before.0 {
            let _ = self.body.rebind(&options)?;
        }
        let is_changed = match self.set_live() {
            Ok(is_changed) => is_changed,
            Err(error) => {
                let _ = self.body.rebind(&before.0)?;
                return Err(error.into());
            }
        };
        // Forces so large that they cannot be applied are found here, before anything else is changed.
        self.stale = true;
        let own = self.saved.iter_mut();
        own.zip(numbers(state)).for_each(|(place, number)| *place = number);
        let Self { body, points, counts, saved, .. } = self;
        let motion = flight.map(|(_, motion)| motion);
        let flight = flight.map(|(flight, _)| flight);
        let acting = Acting { points, patterns: counts.patterns, flight: flight.as_ref() };
        if let Err(refusal) = body.with(|parts| acting.restore(parts, numbers(shown), saved)) {
            let _ = self.body.rebind(&before.0)?;
            if is_changed {
                // A change of live regions keeps no more of the motion than the stepped modes hold.
                copy(self.before, self.asked);
                self.set_live()?;
                copy(self.kept, self.saved);
                self.put_back()?;
            }
            self.body.with(|parts| *parts.flight = before.1);
            return Err(refusal);
        }
        // Every bit comes back: what was kept is not made of length one again.
        self.body.with(|parts| {
            if let (Some(free), Some(motion)) = (parts.flight, motion) {
                free.set_motion(motion);
            }
        });
        self.flight = flight;
        self.inputs.iter_mut().zip(numbers(inputs)).for_each(|(place, number)| *place = number);
        self.shown.iter_mut().zip(numbers(shown)).for_each(|(place, number)| *place = number);
        Ok(())
    }

    /// Name of the thing that a variable belongs to.
    #[must_use]
    pub fn name(&self, variable: Variable) -> &str {
        use Variable as V;
        match variable {
            V::Force(point, _) | V::Displacement(point, _) | V::Velocity(point, _) => {
                self.points.get(point as usize).map_or("", |point| point.name)
            }
            V::Pattern(pattern) => line(self.names.patterns, pattern),
            V::Probe(probe) | V::ProbeVelocity(probe) => line(self.names.probes, probe),
            V::Parameter(index) => {
                self.file.parameters().nth(index as usize).map_or("", |parameter| parameter.name)
            }
            V::VonMises(index) => self.points.stress(index as usize).map_or("", |place| place.name),
            V::ReactionForce(support, _) | V::ReactionMoment(support, _) => {
                line(self.names.supports, support)
            }
            V::Time | V::Step | V::Energy | V::Total(_) | V::Whole(_) => "",
            V::BodyForce(_) | V::BodyPosition(_) | V::BodyAttitude(_) => "",
            V::BodyVelocity(_) | V::BodySpin(_) => "",
        }
    }
}

/// One line of a text, counted from 0; empty behind the last. (`str::lines` leaves a panic that the linker
/// cannot rule out.)
fn line(text: &'static str, index: u32) -> &'static str {
    let ends = || text.bytes().enumerate().filter(|&(_, byte)| byte == b'\n').map(|(at, _)| at);
    let start = match (index as usize).checked_sub(1) {
        None => 0,
        Some(before) => ends().nth(before).map_or(text.len(), |end| end + 1),
    };
    let end = ends().nth(index as usize).unwrap_or(text.len());
    text.get(start..end).unwrap_or_default()
}

/// Lines of a text section; none where it is absent or compressed.
fn text(file: &File<'static>, kind: SectionKind) -> &'static str {
    file.section(kind).and_then(|section| section.text().ok()).unwrap_or_default()
}

/// Loads of a step that was taken, made again from its inputs.
struct Acting<'a> {
    points: &'a Points<'static>,
    patterns: u32,
    /// Of a free body, whose forces are those of space, as it was turned in that step.
    flight: Option<&'a Flight>,
}

impl Acting<'_> {
    /// Takes a state back under these inputs.
    fn restore(
        &self,
        parts: BodyParts<'_, 'static, f64>,
        mut inputs: impl Iterator<Item = f64>,
        state: &[f64],
    ) -> Result<(), Refusal> {
        let (scene, loads) = (parts.scene, parts.loads);
        loads.clear();
        for index in 0..self.points.len() {
            let force = next_force(&mut inputs);
            let Some(point) = self.points.get(index).filter(|_| force != [0.0; 3]) else { continue };
            let force = self.flight.map_or(force, |flight| flight.turned.to_body(force));
            loads.add_contact(scene, &Contact::new(point.place, force))?;
        }
        for (pattern, amplitude) in inputs.take(self.patterns as usize).enumerate() {
            if amplitude != 0.0 {
                loads.add_pattern(scene, pattern, amplitude)?;
            }
        }
        if let Some(Flight { spins: [before, after], .. }) = self.flight {
            loads.add_spin(scene, *before, *after)?;
        }
        let (state, rest) = state.split_at_checked(scene.state_numbers()).ok_or(StepError::Mismatch)?;
        let filter = rest.get(..parts.state.filter_numbers()).ok_or(StepError::Mismatch)?;
        parts.state.restore_under(state, loads)?;
        parts.state.restore_filter(filter)?;
        Ok(())
    }
}

/// Three numbers of the inputs.
fn next_force(inputs: &mut impl Iterator<Item = f64>) -> [f64; 3] {
    let mut force = [0.0; 3];
    for component in &mut force {
        *component = inputs.next().unwrap_or_default();
    }
    force
}

/// A named point, and where it is at rest in a file that says so.
fn placed(file: &File<'_>, point: &Point<'_>) -> SurfacePoint {
    let place = point.place;
    let mut position = [0.0; 3];
    let section = file.section(SectionKind::NodeCoordinates);
    if let Some(coordinates) = section.and_then(|section| section.numbers().ok()) {
        for (node, weight) in place.entries() {
            for (component, sum) in position.iter_mut().enumerate() {
                *sum += weight * coordinates.get(3 * node as usize + component).unwrap_or(0.0);
            }
        }
    }
    SurfacePoint { place, position, distance: 0.0 }
}

/// Writes numbers over others.
fn copy(from: &[f64], to: &mut [f64]) {
    to.iter_mut().zip(from).for_each(|(to, &from)| *to = from);
}

/// Asks for a value of a parameter of a file with live regions, in its range.
fn ask(asked: &mut f64, file: &File<'_>, index: u32, value: f64) -> Result<(), ParameterError> {
    let parameter = index as usize;
    let unknown = ParameterError::Unknown { index: parameter };
    let Parameter { lower, upper, .. } = file.parameters().nth(parameter).ok_or(unknown)?;
    if !(lower..=upper).contains(&value) {
        return Err(ParameterError::OutsideRange { parameter, value, lower, upper });
    }
    *asked = value;
    Ok(())
}

/// Value of a parameter at these options, as built of a file with live regions; `None` for one that an FMU
/// does not offer. The time step is one: the internal step of an FMU is fixed.
#[must_use]
pub fn parameter(options: &SceneOptions, file: &File<'_>, index: u32) -> Option<f64> {
    let found = file.parameters().nth(index as usize)?;
    if found.role == ParameterRole::TimeStep {
        return None;
    }
    if has_live(file) { Some(found.nominal) } else { options.value(file.metadata(), index as usize) }
}

/// Numbers of [`Variable::Whole`].
const WHOLE: usize = 4;

/// Value of a scale or a damping of the whole body; `None` where a live parameter of the file has it, and of
/// `β` in a file that was built without.
#[must_use]
pub fn whole(options: &SceneOptions, file: &File<'_>, index: u32) -> Option<f64> {
    let metadata = file.metadata();
    let (role, value) = match index {
        0 => (ParameterRole::Stiffness, options.stiffness),
        1 => (ParameterRole::Density, options.density),
        2 => (ParameterRole::Alpha, options.alpha.unwrap_or(metadata.alpha)),
        // A scene that was bound without β has no room for what the residual flexibility needs of it.
        3 if metadata.beta != 0.0 => (ParameterRole::Beta, options.beta.unwrap_or(metadata.beta)),
        _ => return None,
    };
    let is_live = file.parameters().any(|parameter| parameter.role == role);
    (!is_live).then_some(value)
}

/// Sets what [`whole`] gives.
fn set_whole(options: &mut SceneOptions, file: &File<'_>, index: u32, value: f64) -> Result<(), Refusal> {
    whole(options, file, index).ok_or(Refusal::NoVariable)?;
    if !(value > 0.0 || index > 1 && value == 0.0) {
        return Err(Refusal::TooSmall { value });
    }
    match index {
        0 => options.stiffness = value,
        1 => options.density = value,
        2 => options.alpha = Some(value),
        _ => options.beta = Some(value),
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::line;

    #[test]
    fn lines_are_counted_from_zero() {
        let text = "tip\n\nroot";
        assert_eq!([0, 1, 2, 3].map(|index| line(text, index)), ["tip", "", "root", ""]);
        assert_eq!([0, 1].map(|index| line("tip\n", index)), ["tip", ""]);
        assert_eq!(line("", 0), "");
    }
}
