//! The body of an instance: a scene in double precision, one state, its loads, and the numbers that a master
//! has set.
//!
//! Loads are made of the inputs when a step needs them. What the modes leave out of a static answer belongs
//! to the inputs of the last step, so those are remembered beside the present ones: a saved body shows the
//! same outputs when it is taken back.

use vademecum_eval::format::{File, MAX_PARAMETERS, Metadata, ParameterRole, SectionKind};
use vademecum_eval::{
    BindError, Contact, Field, Loads, OutputError, Scene, SceneOptions, State, StructureChoice, SurfacePoint,
};

use crate::bytes::{Cursor, Pen};
use crate::points::{Point, Points};
use crate::refusal::Refusal;
use crate::variables::{Counts, Variable};

/// A body that is stepped.
#[derive(Debug)]
pub struct Body {
    counts: Counts,
    points: Points<'static>,
    names: Names,
    scene: Scene<'static, f64>,
    state: State<'static, f64>,
    loads: Loads<'static, f64>,
    /// Forces on the points, three numbers each, then amplitudes of the patterns.
    inputs: &'static mut [f64],
    /// The same of the last step.
    shown: &'static mut [f64],
    /// A state: the one before a step that may fail, or one on its way in or out.
    saved: &'static mut [f64],
    work: &'static mut [f64],
    /// The loads are not those of the inputs.
    stale: bool,
}

/// The motion of the point that was looked at last: its other components follow, most of the time.
#[derive(Debug, Default)]
pub struct Seen(Option<(u32, Field, [f64; 3])>);

/// One name a line, as the file has them.
#[derive(Clone, Copy, Debug)]
struct Names {
    patterns: &'static str,
    probes: &'static str,
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
        let inputs = points.saturating_mul(3).saturating_add(metadata.n_patterns as usize);
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
    // Room for every point, whether it is loaded or not.
    SceneOptions { structure, contacts: points, ..SceneOptions::default() }
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
        let metadata = file.metadata();
        let counts = Counts {
            points: points.len() as u32,
            patterns: metadata.n_patterns,
            probes: metadata.n_probes,
            parameters: metadata.n_parameters,
        };
        let names = Names {
            patterns: text(file, SectionKind::PatternNames),
            probes: text(file, SectionKind::ProbeNames),
        };
        inputs.fill(0.0);
        shown.fill(0.0);
        Ok(Self { counts, points, names, scene, state, loads, inputs, shown, saved, work, stale: false })
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
        self.stale = false;
        Ok(())
    }

    /// Where a force or an amplitude is kept.
    const fn input(&self, variable: Variable) -> Option<usize> {
        match variable {
            Variable::Force(point, component) => Some(3 * point as usize + component as usize),
            Variable::Pattern(pattern) => Some(3 * self.points.len() + pattern as usize),
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
            V::Force(..) | V::Pattern(_) => {
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
            V::Time => return Err(Refusal::NoVariable),
        })
    }

    fn at_point(&self, index: u32, component: u32, field: Field, seen: &mut Seen) -> Result<f64, Refusal> {
        let moved = match seen.0 {
            Some((point, of, moved)) if (point, of) == (index, field) => moved,
            _ => {
                let missing = OutputError::OutOfRange { index: index as usize, count: self.points.len() };
                let Point { nodes, weights, .. } = self.points.get(index as usize).ok_or(missing)?;
                let place = SurfacePoint { nodes, weights, position: [0.0; 3], distance: 0.0 };
                self.scene.point(&self.state, &place, field)?
            }
        };
        seen.0 = Some((index, field, moved));
        moved.get(component as usize).copied().ok_or(Refusal::NoVariable)
    }

    /// Sets forces, amplitudes and parameters, all of them or, if one is refused, none. `settings` gives each
    /// variable with its value, the same ones each time it is called.
    ///
    /// # Errors
    /// [`Refusal`], and the variable it is about.
    pub fn set<I: Iterator<Item = (Variable, f64)>>(
        &mut self,
        settings: impl Fn() -> I,
    ) -> Result<(), (Variable, Refusal)> {
        let mut options = *self.scene.options();
        let mut last = None;
        for (variable, value) in settings() {
            if !value.is_finite() {
                return Err((variable, Refusal::NotFinite { value }));
            }
            match variable {
                Variable::Force(..) | Variable::Pattern(_) => {}
                Variable::Parameter(index) => {
                    let metadata = self.scene.metadata();
                    if parameter(&options, metadata, index).is_none() {
                        return Err((variable, Refusal::NoVariable));
                    }
                    let done = options.set(metadata, index as usize, value);
                    done.map_err(|error| (variable, Refusal::Parameter(error)))?;
                    last = Some(variable);
                }
                _ => return Err((variable, Refusal::NotSettable)),
            }
        }
        if let Some(variable) = last {
            self.scene.rebind(&options, self.work).map_err(|error| (variable, Refusal::Bind(error)))?;
            self.stale = true;
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
        if self.stale {
            load(&mut self.loads, &self.scene, &self.points, self.inputs)?;
            self.stale = false;
        }
        self.state.save_into(self.saved)?;
        for taken in 0..steps {
            if let Err(error) = self.scene.step(&mut self.state, &self.loads) {
                if taken > 0 {
                    self.put_back()?;
                }
                return Err(error.into());
            }
        }
        if steps > 0 {
            self.shown.iter_mut().zip(&*self.inputs).for_each(|(shown, &input)| *shown = input);
        }
        Ok(())
    }

    /// Takes the saved state back, with the loads of the step that led to it.
    fn put_back(&mut self) -> Result<(), Refusal> {
        load(&mut self.loads, &self.scene, &self.points, self.shown)?;
        self.stale = true;
        self.state.restore_under(self.saved, &self.loads)?;
        Ok(())
    }

    /// Bytes that [`Body::save_into`] writes.
    #[must_use]
    pub const fn saved_len(&self) -> usize {
        8 * (MAX_PARAMETERS + 2 * self.inputs.len() + self.saved.len())
    }

    /// Writes everything that can change: parameters, inputs, inputs of the last step, state.
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
        let parts = [&parameters[..], self.inputs, self.shown, self.saved];
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
                options.set(self.scene.metadata(), index as usize, value)?;
            }
        }
        if options != before {
            self.scene.rebind(&options, self.work)?;
        }
        // Forces so large that they cannot be applied are found here, before anything else is changed.
        self.stale = true;
        let own = self.saved.iter_mut();
        own.zip(numbers(state)).for_each(|(place, number)| *place = number);
        let loads = &mut self.loads;
        let done = load_numbers(loads, &self.scene, &self.points, numbers(shown))
            .and_then(|()| Ok(self.state.restore_under(self.saved, loads)?));
        if let Err(refusal) = done {
            self.scene.rebind(&before, self.work)?;
            return Err(refusal);
        }
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
            V::Time | V::Step | V::Energy => "",
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

fn load(
    loads: &mut Loads<'_, f64>,
    scene: &Scene<'_, f64>,
    points: &Points<'_>,
    inputs: &[f64],
) -> Result<(), Refusal> {
    load_numbers(loads, scene, points, inputs.iter().copied())
}

/// Makes the loads of these inputs. A point without force stays out, so that an unloaded body can rest.
fn load_numbers(
    loads: &mut Loads<'_, f64>,
    scene: &Scene<'_, f64>,
    points: &Points<'_>,
    mut inputs: impl Iterator<Item = f64>,
) -> Result<(), Refusal> {
    loads.clear();
    for index in 0..points.len() {
        let mut force = [0.0; 3];
        for component in &mut force {
            *component = inputs.next().unwrap_or_default();
        }
        let Some(point) = points.get(index).filter(|_| force != [0.0; 3]) else { continue };
        loads.add_contact(scene, &Contact { nodes: point.nodes, weights: point.weights, force })?;
    }
    for (pattern, amplitude) in inputs.enumerate().filter(|&(_, amplitude)| amplitude != 0.0) {
        loads.add_pattern(scene, pattern, amplitude)?;
    }
    Ok(())
}

/// Value of a parameter at these options; `None` for one that an FMU does not offer. The time step is one:
/// the internal step of an FMU is fixed.
#[must_use]
pub fn parameter(options: &SceneOptions, metadata: &Metadata<'_>, index: u32) -> Option<f64> {
    use ParameterRole as R;
    match metadata.active_parameters().get(index as usize)?.role {
        R::Stiffness => Some(options.stiffness),
        R::Density => Some(options.density),
        R::RegionStiffness { region } => options.region_stiffness.get(region as usize).copied(),
        R::RegionDensity { region } => options.region_density.get(region as usize).copied(),
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
