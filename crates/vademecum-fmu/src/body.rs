//! The body of an instance: a scene in double precision, one state, its loads, and the numbers that a master
//! has set.
//!
//! Loads are made of the inputs when a step needs them. What the modes leave out of a static answer belongs
//! to the inputs of the last step, so those are remembered beside the present ones: a saved body shows the
//! same outputs when it is taken back.

use vademecum_eval::format::{File, MAX_PARAMETERS, Metadata, ParameterRole, SectionKind};
use vademecum_eval::{
    BindError, Contact, Field, Loads, OutputError, Place, RigidMotion, Scene, SceneOptions, State,
    StructureChoice, SurfacePoint,
};

use crate::bytes::{Cursor, Pen};
use crate::flight::{self, Flight};
use crate::points::{Point, Points};
use crate::refusal::Refusal;
use crate::variables::{Counts, Variable};

/// A body that is stepped.
#[derive(Debug)]
pub struct Body {
    counts: Counts,
    points: Points<'static>,
    names: Names,
    /// Where the nodes are at rest.
    file: File<'static>,
    /// The rigid motion of a body without supports.
    flight: Option<Flight>,
    scene: Scene<'static, f64>,
    state: State<'static, f64>,
    loads: Loads<'static, f64>,
    /// Forces on the points, three numbers each, then amplitudes of the patterns, then the force on the
    /// centre of a free body.
    inputs: &'static mut [f64],
    /// The same of the last step.
    shown: &'static mut [f64],
    /// A state: the one before a step that may fail, or one on its way in or out.
    saved: &'static mut [f64],
    work: &'static mut [f64],
    /// The loads are not those of the inputs.
    stale: bool,
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
    scene: usize,
    state: usize,
    loads: usize,
    inputs: usize,
    saved: usize,
    work: usize,
}

impl Lengths {
    fn of(file: &File<'_>, options: &SceneOptions, points: usize) -> Result<Self, BindError> {
        let sizes = Scene::<f64>::sizes(file, options)?;
        let metadata = file.metadata();
        let inputs = points.saturating_mul(3).saturating_add(metadata.n_patterns as usize).saturating_add(3);
        let saved = 3 * metadata.n_modes as usize;
        Ok(Self {
            scene: sizes.scene,
            state: sizes.state,
            loads: sizes.loads,
            inputs,
            saved,
            work: sizes.work,
        })
    }

    fn sum(&self) -> usize {
        let Self { scene, state, loads, inputs, saved, work } = *self;
        [scene, state, loads, inputs, inputs, saved, work].into_iter().fold(0, usize::saturating_add)
    }
}

/// What a body of a file is bound to: the structure that `vademecum run` takes, except that a file with live
/// regions takes the one that knows them from the start.
#[must_use]
pub fn options(metadata: &Metadata<'_>, points: usize) -> SceneOptions {
    let of_region =
        |role| matches!(role, ParameterRole::RegionStiffness { .. } | ParameterRole::RegionDensity { .. });
    let regions = metadata.active_parameters().iter().any(|parameter| of_region(parameter.role));
    let structure = if regions && metadata.block { StructureChoice::Block } else { StructureChoice::Auto };
    // Room for every point, whether it is loaded or not; without any, reactions would not remember patterns.
    SceneOptions { structure, contacts: points.max(1), ..SceneOptions::default() }
}

impl Body {
    /// Numbers to lend for a body with so many points.
    ///
    /// # Errors
    /// [`BindError`]: a file that cannot be stepped.
    pub fn len_for(file: &File<'_>, points: usize) -> Result<usize, BindError> {
        Ok(Lengths::of(file, &options(file.metadata(), points), points)?.sum())
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
        let options = options(file.metadata(), points.len());
        let lengths = Lengths::of(file, &options, points.len())?;
        let (found, needed) = (memory.len(), lengths.sum());
        let mut rest = memory;
        let mut take = |length: usize| {
            let (taken, left) = core::mem::take(&mut rest).split_at_mut_checked(length)?;
            rest = left;
            Some(taken)
        };
        let Lengths { scene, state, loads, inputs, saved, work } = lengths;
        let pieces = [scene, state, loads, inputs, inputs, saved, work].map(&mut take);
        let [Some(scene), Some(state), Some(loads), Some(inputs), Some(shown), Some(saved), Some(work)] =
            pieces
        else {
            return Err(BindError::LentMemory { found, needed });
        };
        let scene = Scene::bind(file, &options, scene, work)?;
        let state = State::new(&scene, state)?;
        let loads = Loads::new(&scene, loads)?;
        let saved = saved.get_mut(..scene.state_numbers()).unwrap_or_default();
        let counts = Counts::of(file, points.len() as u32, points.stresses() as u32);
        let names = Names {
            patterns: text(file, SectionKind::PatternNames),
            probes: text(file, SectionKind::ProbeNames),
            supports: text(file, SectionKind::SupportNames),
        };
        inputs.fill(0.0);
        shown.fill(0.0);
        let (flight, file, stale) = (Flight::new(&scene), *file, false);
        Ok(Self {
            counts,
            points,
            names,
            file,
            flight,
            scene,
            state,
            loads,
            inputs,
            shown,
            saved,
            work,
            stale,
        })
    }

    /// What can be counted.
    #[must_use]
    pub const fn counts(&self) -> &Counts {
        &self.counts
    }

    /// `Δt` \[s\].
    #[must_use]
    pub const fn time_step(&self) -> f64 {
        self.scene.parameters().time_step
    }

    /// Modes of the basis.
    #[must_use]
    pub const fn n_modes(&self) -> usize {
        self.scene.n_modes()
    }

    /// Puts everything back as it was made.
    ///
    /// # Errors
    /// [`Refusal::Bind`] can only come from a file that has changed.
    pub fn reset(&mut self) -> Result<(), Refusal> {
        let options = options(self.scene.metadata(), self.points.len());
        self.scene.rebind(&options, self.work)?;
        self.state.rest();
        self.loads.clear();
        self.inputs.fill(0.0);
        self.shown.fill(0.0);
        self.flight = Flight::new(&self.scene);
        self.stale = false;
        Ok(())
    }

    /// Where a force or an amplitude is kept.
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
            V::Step => self.time_step(),
            V::Energy => self.scene.energy(&self.state)?,
            V::Force(..) | V::Pattern(_) | V::BodyForce(_) => {
                let place = self.input(variable).and_then(|at| self.inputs.get(at));
                *place.ok_or(Refusal::NoVariable)?
            }
            V::Displacement(point, component) => {
                self.at_point(point, component, Field::Displacement, seen)?
            }
            V::Velocity(point, component) => self.at_point(point, component, Field::Velocity, seen)?,
            V::Probe(probe) => self.scene.probe(&self.state, probe as usize, Field::Displacement)?,
            V::ProbeVelocity(probe) => self.scene.probe(&self.state, probe as usize, Field::Velocity)?,
            V::Parameter(index) => {
                parameter(self.scene.options(), self.scene.metadata(), index).ok_or(Refusal::NoVariable)?
            }
            V::VonMises(index) => self.von_mises(index)?,
            V::ReactionForce(support, c) => self.reaction(support, c, seen)?,
            V::ReactionMoment(support, c) => self.reaction(support, c.saturating_add(3), seen)?,
            V::BodyPosition(_) | V::BodyAttitude(_) | V::BodyVelocity(_) | V::BodySpin(_) => {
                self.flight.and_then(|flight| flight.value(variable)).ok_or(Refusal::NoVariable)?
            }
            V::Time => return Err(Refusal::NoVariable),
        })
    }

    /// The equivalent stress of a place; of a node between regions, the largest of its values.
    fn von_mises(&self, index: u32) -> Result<f64, Refusal> {
        let place = self.points.stress(index as usize).ok_or(Refusal::NoVariable)?;
        let mut most = 0.0f64;
        for point in 0..self.scene.n_stress_points() {
            if self.scene.stress_point(point).is_some_and(|point| point.node == place.node) {
                most = most.max(self.scene.stress(&self.state, point)?.von_mises());
            }
        }
        Ok(most)
    }

    /// A component of a reaction: force, then moment.
    fn reaction(&self, support: u32, component: u32, seen: &mut Seen) -> Result<f64, Refusal> {
        let exerted = match seen.support {
            Some((known, exerted)) if known == support => exerted,
            _ => self.scene.reaction(&self.state, support as usize)?.total(),
        };
        seen.support = Some((support, exerted));
        exerted.get(component as usize).copied().ok_or(Refusal::NoVariable)
    }

    fn at_point(&self, index: u32, component: u32, field: Field, seen: &mut Seen) -> Result<f64, Refusal> {
        let moved = match seen.point {
            Some((point, of, moved)) if (point, of) == (index, field) => moved,
            _ => {
                let missing = OutputError::OutOfRange { index: index as usize, count: self.points.len() };
                let place = placed(&self.file, &self.points.get(index as usize).ok_or(missing)?);
                match (&self.flight, field) {
                    (None, _) => self.scene.point(&self.state, &place, field)?,
                    // In space, the rigid motion included.
                    (Some(flight), Field::Displacement) => {
                        let at = flight.free.point(&self.scene, &self.state, &place)?;
                        let [x, y, z] = at;
                        let [a, b, c] = place.position;
                        [x - a, y - b, z - c]
                    }
                    (Some(flight), Field::Velocity) => {
                        flight.free.velocity(&self.scene, &self.state, &place)?
                    }
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
        let mut options = *self.scene.options();
        let mut last = None;
        let mut flight = self.flight;
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
                    let metadata = self.scene.metadata();
                    if parameter(&options, metadata, index).is_none() {
                        return Err((variable, Refusal::NoVariable));
                    }
                    let done = options.set(metadata, &[(index as usize, value)]);
                    done.map_err(|error| (variable, Refusal::Parameter(error)))?;
                    last = Some(variable);
                }
                _ => return Err((variable, Refusal::NotSettable)),
            }
        }
        if let (Some(variable), Some(flight)) = (thrown, &mut flight) {
            flight.begin().ok_or((variable, Refusal::Unsupported("an attitude of zero is none")))?;
        }
        if let Some(variable) = last {
            self.scene.rebind(&options, self.work).map_err(|error| (variable, Refusal::Bind(error)))?;
            self.stale = true;
        }
        self.flight = flight;
        if let Some(flight) = &mut self.flight {
            flight.free.follow(&self.scene);
        }
        for (variable, value) in settings() {
            if let Some(place) = self.input(variable).and_then(|at| self.inputs.get_mut(at)) {
                // The sign of a zero is no change.
                self.stale |= *place != value;
                *place = value;
            }
        }
        Ok(())
    }

    /// Takes so many steps under the inputs, which are held.
    ///
    /// # Errors
    /// [`Refusal`]; the body is then where it was.
    pub fn step(&mut self, steps: u64) -> Result<(), Refusal> {
        let before = self.flight;
        if self.stale && before.is_none() {
            self.load(false)?;
            self.stale = false;
        }
        self.state.save_into(self.saved)?;
        for taken in 0..steps {
            let done = match self.flight {
                Some(_) => self.fly(),
                None => self.scene.step(&mut self.state, &self.loads).map(drop).map_err(Refusal::from),
            };
            if let Err(refusal) = done {
                self.flight = before;
                if taken > 0 {
                    self.put_back()?;
                }
                return Err(refusal);
            }
        }
        if steps > 0 {
            self.shown.iter_mut().zip(&*self.inputs).for_each(|(shown, &input)| *shown = input);
        }
        Ok(())
    }

    /// A step of a free body, in the directions of space.
    fn fly(&mut self) -> Result<(), Refusal> {
        let Self { flight, scene, loads, points, inputs, state, file, counts, .. } = self;
        let Some(flight) = flight else { return Err(Refusal::NoVariable) };
        let mut inputs = inputs.iter().copied();
        let free = &mut flight.free;
        free.follow(scene);
        free.clear(loads);
        for index in 0..points.len() {
            let force = next_force(&mut inputs);
            let Some(point) = points.get(index).filter(|_| force != [0.0; 3]) else { continue };
            free.push(scene, loads, &placed(file, &point), force)?;
        }
        for (pattern, amplitude) in inputs.by_ref().take(counts.patterns as usize).enumerate() {
            if amplitude != 0.0 {
                free.push_pattern(scene, loads, pattern, amplitude)?;
            }
        }
        free.pull(next_force(&mut inputs));
        flight.turned = free.middle(scene);
        let spin = |motion: &RigidMotion| motion.spin(free.body());
        flight.spins = [spin(free.motion()), spin(&free.ahead(scene))];
        free.step(scene, state, loads)?;
        Ok(())
    }

    /// Makes the loads of the inputs, or of those of the last step.
    fn load(&mut self, shown: bool) -> Result<(), Refusal> {
        let inputs = if shown { &*self.shown } else { &*self.inputs };
        let acting = Acting {
            scene: &self.scene,
            points: &self.points,
            patterns: self.counts.patterns,
            flight: self.flight.as_ref(),
        };
        acting.load(&mut self.loads, inputs.iter().copied())
    }

    /// Takes the saved state back, with the loads of the step that led to it.
    fn put_back(&mut self) -> Result<(), Refusal> {
        self.load(true)?;
        self.stale = true;
        self.state.restore_under(self.saved, &self.loads)?;
        Ok(())
    }

    /// Bytes that [`Body::save_into`] writes.
    #[must_use]
    pub const fn saved_len(&self) -> usize {
        let flight = if self.flight.is_some() { flight::NUMBERS } else { 0 };
        8 * (MAX_PARAMETERS + flight + 2 * self.inputs.len() + self.saved.len())
    }

    /// Writes everything that can change: parameters, flight, inputs, inputs of the last step, state.
    ///
    /// # Errors
    /// [`Refusal::Saved`]: no room.
    pub fn save_into(&mut self, pen: &mut Pen<'_>) -> Result<(), Refusal> {
        let mut parameters = [0.0; MAX_PARAMETERS];
        for (index, place) in (0..).zip(&mut parameters) {
            let value = parameter(self.scene.options(), self.scene.metadata(), index);
            *place = value.unwrap_or_default();
        }
        self.state.save_into(self.saved)?;
        let flight = self.flight.map(|flight| flight.numbers());
        let flight = flight.as_ref().map_or(&[][..], |numbers| &numbers[..]);
        let parts = [&parameters[..], flight, self.inputs, self.shown, self.saved];
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
        let mut parameters = [0.0; MAX_PARAMETERS];
        cursor.numbers(&mut parameters).ok_or(SHORT)?;
        let mut flight = self.flight;
        if let Some(flight) = &mut flight {
            let mut numbers = [0.0; flight::NUMBERS];
            cursor.numbers(&mut numbers).ok_or(SHORT)?;
            *flight = flight.restored(&numbers).ok_or(Refusal::Saved("its flight is none"))?;
        }
        let inputs = cursor.take(8 * self.inputs.len()).ok_or(SHORT)?;
        let shown = cursor.take(8 * self.shown.len()).ok_or(SHORT)?;
        let state = cursor.take(8 * self.saved.len()).ok_or(SHORT)?;
        let numbers = |bytes| <[u8]>::as_chunks(bytes).0.iter().map(|&number| f64::from_le_bytes(number));
        if !numbers(inputs).chain(numbers(shown)).chain(numbers(state)).all(f64::is_finite) {
            return Err(Refusal::Saved("it has a number that is not finite"));
        }
        let before = *self.scene.options();
        let mut options = before;
        for (index, value) in (0..).zip(parameters) {
            if parameter(&options, self.scene.metadata(), index).is_some() {
                options.set(self.scene.metadata(), &[(index as usize, value)])?;
            }
        }
        if options != before {
            self.scene.rebind(&options, self.work)?;
        }
        // Forces so large that they cannot be applied are found here, before anything else is changed.
        self.stale = true;
        let own = self.saved.iter_mut();
        own.zip(numbers(state)).for_each(|(place, number)| *place = number);
        // The mass that belongs to the parameters, before the momenta that were kept beside them.
        if let (Some(kept), Some(own)) = (&mut flight, Flight::new(&self.scene)) {
            let motion = *kept.free.motion();
            kept.free = own.free;
            kept.free.set_motion(motion);
        }
        let loads = &mut self.loads;
        let (scene, points, patterns) = (&self.scene, &self.points, self.counts.patterns);
        let acting = Acting { scene, points, patterns, flight: flight.as_ref() };
        let done = acting
            .load(loads, numbers(shown))
            .and_then(|()| Ok(self.state.restore_under(self.saved, loads)?));
        if let Err(refusal) = done {
            self.scene.rebind(&before, self.work)?;
            return Err(refusal);
        }
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
                let parameter = self.scene.metadata().active_parameters().get(index as usize);
                parameter.map_or("", |parameter| parameter.name)
            }
            V::VonMises(index) => self.points.stress(index as usize).map_or("", |place| place.name),
            V::ReactionForce(support, _) | V::ReactionMoment(support, _) => {
                line(self.names.supports, support)
            }
            V::Time | V::Step | V::Energy => "",
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

/// What makes loads of inputs.
struct Acting<'a> {
    scene: &'a Scene<'static, f64>,
    points: &'a Points<'static>,
    patterns: u32,
    /// Whose forces are those of space, as the body was turned in its last step.
    flight: Option<&'a Flight>,
}

impl Acting<'_> {
    /// Makes the loads of these inputs. A point without force stays out, so that an unloaded body can rest.
    fn load(&self, loads: &mut Loads<'_, f64>, mut inputs: impl Iterator<Item = f64>) -> Result<(), Refusal> {
        loads.clear();
        for index in 0..self.points.len() {
            let force = next_force(&mut inputs);
            let Some(point) = self.points.get(index).filter(|_| force != [0.0; 3]) else { continue };
            let force = self.flight.map_or(force, |flight| flight.turned.to_body(force));
            loads
                .add_contact(self.scene, &Contact::new(Place::triangle(point.nodes, point.weights), force))?;
        }
        for (pattern, amplitude) in inputs.take(self.patterns as usize).enumerate() {
            if amplitude != 0.0 {
                loads.add_pattern(self.scene, pattern, amplitude)?;
            }
        }
        if let Some(Flight { spins: [before, after], .. }) = self.flight {
            loads.add_spin(self.scene, *before, *after)?;
        }
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
fn placed(file: &File<'static>, point: &Point<'_>) -> SurfacePoint {
    let &Point { nodes, weights, .. } = point;
    let mut position = [0.0; 3];
    let section = file.section(SectionKind::NodeCoordinates);
    if let Some(coordinates) = section.and_then(|section| section.numbers().ok()) {
        for (node, weight) in nodes.into_iter().zip(weights) {
            for (component, sum) in position.iter_mut().enumerate() {
                *sum += weight * coordinates.get(3 * node as usize + component).unwrap_or(0.0);
            }
        }
    }
    SurfacePoint { place: Place::triangle(nodes, weights), position, distance: 0.0 }
}

/// Value of a parameter at these options; `None` for one that an FMU does not offer. The time step is one:
/// the internal step of an FMU is fixed.
#[must_use]
pub fn parameter(options: &SceneOptions, metadata: &Metadata<'_>, index: u32) -> Option<f64> {
    use ParameterRole as R;
    match metadata.active_parameters().get(index as usize)?.role {
        R::Stiffness => Some(options.stiffness),
        R::Density => Some(options.density),
        R::RegionStiffness { region } => options.regions.stiffness().get(region as usize).copied(),
        R::RegionDensity { region } => options.regions.density().get(region as usize).copied(),
        R::Alpha => Some(options.alpha.unwrap_or(metadata.alpha)),
        R::Beta => Some(options.beta.unwrap_or(metadata.beta)),
        _ => None,
    }
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
