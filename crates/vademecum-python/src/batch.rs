//! Many bodies of one file, stepped together.

use std::sync::{Mutex, MutexGuard};

use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use self_cell::{MutBorrow, self_cell};
use vademecum_eval::{
    Batch, BatchStatus, BindError, Contact, Field, LoadError, ParameterError, Quantity, Scene, Simulation,
    Status, StepError,
};
use vademecum_study::parameters::{self, ParameterValue};

use crate::arrays::{filled, owned};
use crate::names::{Names, field};
use crate::options::{pairs, resolve};
use crate::point::{Count, PyPoint, Target, Vector};
use crate::refusal::{busy, of_bind, of_load, of_locate, of_output, of_simulation, of_step, of_study};
use crate::simulation::{
    AnySimulation, Number, Out, change, either, quantities, quantity, surface, values, whole,
};

type SingleBatch<'m> = Batch<'m, f32>;
type DoubleBatch<'m> = Batch<'m, f64>;

self_cell!(
    /// A batch and its memory.
    pub struct SingleCell {
        owner: MutBorrow<Vec<f32>>,
        #[covariant]
        dependent: SingleBatch,
    }
);
self_cell!(
    /// A batch and its memory.
    pub struct DoubleCell {
        owner: MutBorrow<Vec<f64>>,
        #[covariant]
        dependent: DoubleBatch,
    }
);

/// A batch that owns its memory.
pub trait Cell<T: Number>: Send + Sized {
    fn of(scene: &Scene<'_, T>, n_instances: usize, memory: Vec<T>) -> Result<Self, BindError>;
    fn with<R>(&mut self, run: impl for<'m> FnOnce(&mut Batch<'m, T>) -> R) -> R;
}

macro_rules! cell {
    ($cell:ident, $number:ty) => {
        impl Cell<$number> for $cell {
            fn of(
                scene: &Scene<'_, $number>,
                n_instances: usize,
                memory: Vec<$number>,
            ) -> Result<Self, BindError> {
                Self::try_new(MutBorrow::new(memory), |memory| {
                    Batch::new(scene, n_instances, memory.borrow_mut())
                })
            }

            fn with<R>(&mut self, run: impl for<'m> FnOnce(&mut Batch<'m, $number>) -> R) -> R {
                self.with_dependent_mut(|_, batch| run(batch))
            }
        }
    };
}
cell!(SingleCell, f32);
cell!(DoubleCell, f64);

/// A load of an instance.
#[derive(Clone, Copy)]
enum Applied {
    Push(Contact),
    Pattern(usize, f64),
}

/// A value for all instances, or one for each.
#[derive(FromPyObject)]
enum Value {
    All(f64),
    Each(Vec<f64>),
}

/// The instances.
enum Bodies<T: Number, C> {
    /// At the same parameters, stepped together, with the loads of each.
    Together(C, Vec<Vec<Applied>>),
    /// Of a parametric file, each at its own parameters.
    Apart(Vec<Simulation<T>>),
}

/// The instances, and a body of the same file through which those of one scene are loaded and read.
struct Instances<T: Number, C> {
    one: Simulation<T>,
    bodies: Bodies<T, C>,
}

impl<T: Number, C: Cell<T>> Instances<T, C> {
    fn new(one: Simulation<T>, n_instances: usize) -> PyResult<Self> {
        let too_many = || PyValueError::new_err(format!("{n_instances} instances do not fit into memory"));
        if one.carried().is_some() {
            let mut bodies = vec![];
            bodies.try_reserve_exact(n_instances).map_err(|_| too_many())?;
            for _ in 0..n_instances {
                bodies.push(one.another().map_err(of_simulation)?);
            }
            return Ok(Self { one, bodies: Bodies::Apart(bodies) });
        }
        // A batch takes no more than as many of one: its length does not overflow.
        Batch::len_for(one.scene(), 1).checked_mul(n_instances).ok_or_else(too_many)?;
        let (mut memory, mut applied): (Vec<T>, Vec<Vec<Applied>>) = (vec![], vec![]);
        let needed = Batch::len_for(one.scene(), n_instances);
        memory.try_reserve_exact(needed).map_err(|_| too_many())?;
        applied.try_reserve_exact(n_instances).map_err(|_| too_many())?;
        memory.resize(needed, T::default());
        applied.resize(n_instances, vec![]);
        let batch = C::of(one.scene(), n_instances, memory).map_err(of_bind)?;
        Ok(Self { one, bodies: Bodies::Together(batch, applied) })
    }

    /// Gives an instance of one scene its loads, and the body too.
    fn load(&mut self, instance: usize) -> Result<(), LoadError> {
        let Bodies::Together(batch, applied) = &mut self.bodies else { return Ok(()) };
        self.one.with(|scene, _, loads| {
            loads.clear();
            for load in &applied[instance] {
                match load {
                    Applied::Push(contact) => loads.add_contact(scene, contact)?,
                    Applied::Pattern(pattern, amplitude) => loads.add_pattern(scene, *pattern, *amplitude)?,
                }
            }
            batch.with(|batch| batch.load(scene, instance, loads))
        })
    }

    fn add(&mut self, instance: usize, load: Applied) -> PyResult<()> {
        let loaded = match &mut self.bodies {
            Bodies::Apart(bodies) => match load {
                Applied::Push(contact) => bodies[instance].push(&contact.place, contact.force),
                Applied::Pattern(pattern, amplitude) => bodies[instance].push_pattern(pattern, amplitude),
            },
            Bodies::Together(_, applied) => {
                applied[instance].push(load);
                let loaded = self.load(instance);
                if let (Err(_), Bodies::Together(_, applied)) = (&loaded, &mut self.bodies) {
                    applied[instance].pop();
                }
                loaded
            }
        };
        loaded.map_err(of_load)
    }

    fn clear(&mut self) {
        match &mut self.bodies {
            Bodies::Apart(bodies) => bodies.iter_mut().for_each(Simulation::clear),
            Bodies::Together(batch, applied) => {
                applied.iter_mut().for_each(Vec::clear);
                batch.with(|batch| batch.clear());
            }
        }
    }

    fn step(&mut self, steps: usize) -> Result<BatchStatus, StepError> {
        let mut status = BatchStatus::default();
        match &mut self.bodies {
            Bodies::Apart(bodies) => {
                let stepped: Vec<_> = bodies.par_iter_mut().map(|body| body.step(steps)).collect();
                for one in stepped {
                    match one {
                        Ok(Status::AtRest) => status.at_rest += 1,
                        Ok(_) => status.moving += 1,
                        Err(_) => status.refused += 1,
                    }
                }
            }
            Bodies::Together(batch, _) => {
                let scene = self.one.scene();
                batch.with(|batch| {
                    for _ in 0..steps {
                        status = batch.step(scene)?;
                    }
                    Ok::<(), StepError>(())
                })?;
            }
        }
        Ok(status)
    }

    /// The body of an instance, or the one that has its state.
    fn select(&mut self, instance: usize) -> PyResult<&Simulation<T>> {
        match &mut self.bodies {
            Bodies::Apart(bodies) => Ok(&bodies[instance]),
            Bodies::Together(batch, _) => {
                let done = self.one.with(|_, state, _| batch.with(|batch| batch.get(instance, state)));
                done.map_err(of_step)?;
                Ok(&self.one)
            }
        }
    }

    /// The same with the loads of the instance as those of its last step.
    fn select_loaded(&mut self, instance: usize) -> PyResult<&Simulation<T>> {
        self.load(instance).map_err(of_load)?;
        match &mut self.bodies {
            Bodies::Apart(bodies) => Ok(&bodies[instance]),
            Bodies::Together(batch, _) => {
                let done = self
                    .one
                    .with(|_, state, loads| batch.with(|batch| batch.get_under(instance, state, loads)));
                done.map_err(of_step)?;
                Ok(&self.one)
            }
        }
    }

    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let Bodies::Apart(bodies) = &self.bodies else { return values(py, &self.one) };
        let dict = PyDict::new(py);
        for (index, parameter) in self.one.parameters().enumerate() {
            let each: Vec<f64> = bodies.iter().filter_map(|body| body.parameter(index)).collect();
            dict.set_item(parameter.name, owned(py, each, &[bodies.len()])?)?;
        }
        Ok(dict)
    }

    fn set_parameters(&mut self, given: Vec<(String, Value)>) -> PyResult<()> {
        match &mut self.bodies {
            Bodies::Apart(bodies) => {
                let settings = settings_of_each(&self.one, bodies.len(), given)?;
                for (body, settings) in bodies.iter_mut().zip(settings) {
                    body.set_parameters(&settings).map_err(of_bind)?;
                }
                Ok(())
            }
            Bodies::Together(batch, applied) => {
                let one = |(name, value)| match value {
                    Value::All(value) => Ok((name, value)),
                    Value::Each(_) => Err(PyValueError::new_err(format!(
                        "`{name}`: the bodies of this file share their parameters; give one number"
                    ))),
                };
                change(&mut self.one, given.into_iter().map(one).collect::<PyResult<_>>()?)?;
                let scene = self.one.scene();
                batch
                    .with(|batch| {
                        batch.clear();
                        batch.carry(scene)
                    })
                    .map_err(of_step)?;
                let loaded: Vec<usize> = (0..applied.len()).filter(|&i| !applied[i].is_empty()).collect();
                loaded.into_iter().try_for_each(|instance| self.load(instance)).map_err(of_load)
            }
        }
    }

    /// Reads quantities of each instance, side by side in its row of `out`.
    fn read(&mut self, what: &[(Quantity, usize)], field: Field, out: &mut [f64]) -> PyResult<()> {
        let width: usize = what.iter().map(|&(quantity, _)| self.one.body().length(quantity)).sum();
        let held = |quantity| matches!(quantity, Quantity::ReactionForce | Quantity::ReactionMoment);
        let under_loads = what.iter().any(|&(quantity, _)| held(quantity));
        for (instance, mut row) in out.chunks_exact_mut(width.max(1)).enumerate() {
            let one = if under_loads { self.select_loaded(instance)? } else { self.select(instance)? };
            for &(quantity, index) in what {
                let (numbers, rest) = row.split_at_mut(one.body().length(quantity));
                one.body().read(quantity, index, field, numbers).map_err(of_output)?;
                row = rest;
            }
        }
        Ok(())
    }
}

/// Parameters by number for each of so many bodies; all of them are in their ranges.
fn settings_of_each<T: Number>(
    one: &Simulation<T>,
    count: usize,
    given: Vec<(String, Value)>,
) -> PyResult<Vec<Vec<(usize, f64)>>> {
    let known: Vec<_> = one.parameters().collect();
    let mut settings = vec![vec![]; count];
    for (name, value) in given {
        let name = resolve(&known, name);
        let each = match value {
            Value::All(value) => vec![value; count],
            Value::Each(each) if each.len() == count => each,
            Value::Each(each) => {
                let said = format!("`{name}`: {} values; the batch has {count} bodies", each.len());
                return Err(PyValueError::new_err(said));
            }
        };
        let named: Vec<_> =
            each.into_iter().map(|value| ParameterValue { name: name.clone(), value }).collect();
        let resolved = parameters::resolve(&known, &named).map_err(of_study)?;
        for (settings, (index, value)) in settings.iter_mut().zip(resolved) {
            if settings.iter().any(|&(earlier, _)| earlier == index) {
                return Err(of_bind(ParameterError::Twice { parameter: index }.into()));
            }
            settings.push((index, value));
        }
    }
    Ok(settings)
}

/// Instances whose precision is known at run time.
enum AnyInstances {
    Single(Instances<f32, SingleCell>),
    Double(Instances<f64, DoubleCell>),
}

/// Many bodies of one file that are stepped together. Those of a file with live regions have parameters of
/// their own, all others share them. `out` is as in `Body`.
///
/// An instance has the bits that a `Body` with `residual=False` and `flight=False` has alone.
#[pyclass(frozen, name = "Batch", module = "vademecum")]
pub struct PyBatch {
    instances: Mutex<AnyInstances>,
    n_instances: usize,
    names: Names,
}

impl PyBatch {
    pub fn new(one: AnySimulation, n_instances: usize, names: Names) -> PyResult<Self> {
        let instances = match one {
            AnySimulation::Single(one) => AnyInstances::Single(Instances::new(one, n_instances)?),
            AnySimulation::Double(one) => AnyInstances::Double(Instances::new(one, n_instances)?),
        };
        Ok(Self { instances: Mutex::new(instances), n_instances, names })
    }

    fn lock(&self) -> PyResult<MutexGuard<'_, AnyInstances>> {
        self.instances.try_lock().map_err(|_| busy("batch"))
    }

    fn check(&self, instance: usize) -> PyResult<()> {
        if instance < self.n_instances {
            return Ok(());
        }
        Err(PyIndexError::new_err(format!("instance {instance}; the batch has {}", self.n_instances)))
    }

    /// Quantities of each instance, shape (instances, …).
    fn of_each<'py>(
        &self,
        (py, out): Out<'_, 'py>,
        shape: &[usize],
        what: &[(Quantity, usize)],
        field: Field,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut instances = self.lock()?;
        let shape: Vec<usize> = [self.n_instances].iter().chain(shape).copied().collect();
        filled::<f64>(
            py,
            &shape,
            out,
            |slice| either!(&mut *instances, AnyInstances, all => all.read(what, field, slice)),
        )
    }
}

#[pymethods]
impl PyBatch {
    fn __len__(&self) -> usize {
        self.n_instances
    }

    /// Length of a step in s.
    #[getter]
    fn time_step(&self) -> PyResult<f64> {
        Ok(either!(&*self.lock()?, AnyInstances, all => all.one.body().time_step()))
    }

    /// Names of the probes of the file.
    #[getter]
    fn probe_names(&self) -> Vec<String> {
        self.names.probes.clone()
    }

    /// Names of the load patterns of the file.
    #[getter]
    fn pattern_names(&self) -> Vec<String> {
        self.names.patterns.clone()
    }

    /// Names of the supports whose reactions the file gives.
    #[getter]
    fn support_names(&self) -> Vec<String> {
        self.names.supports.clone()
    }

    /// Values of the live parameters, by name; of a file with live regions an array of one for each instance.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        either!(&*self.lock()?, AnyInstances, all => all.values(py))
    }

    /// Quantities that `read` gives of each instance, by name.
    #[getter]
    fn quantities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        either!(&*self.lock()?, AnyInstances, all => quantities(py, &all.one))
    }

    /// Sets live parameters of all instances while they move. With live regions a value may be an array of
    /// one number for each instance. One that is refused changes nothing.
    #[pyo3(signature = (values=None, /, **parameters))]
    fn set_parameters(
        &self,
        values: Option<&Bound<'_, PyDict>>,
        parameters: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let given = pairs(values, parameters)?;
        either!(&mut *self.lock()?, AnyInstances, all => all.set_parameters(given))
    }

    /// Finds the nearest point of the loadable surface at rest. A point further away than the body is large
    /// is refused.
    fn locate(&self, point: Vector) -> PyResult<PyPoint> {
        let instances = self.lock()?;
        either!(&*instances, AnyInstances, all => all.one.locate(point.0)).map(PyPoint).map_err(of_locate)
    }

    /// Adds a force in N to one instance; it stays until `clear`.
    fn push(&self, instance: usize, place: Target, force: Vector) -> PyResult<PyPoint> {
        self.check(instance)?;
        either!(&mut *self.lock()?, AnyInstances, all => {
            let at = place.on(|point| all.one.locate(point))?;
            all.add(instance, Applied::Push(Contact::new(at.place, force.0)))?;
            Ok(PyPoint(at))
        })
    }

    /// Adds a load pattern to one instance; it stays until `clear`.
    #[pyo3(signature = (instance, name, amplitude=1.0))]
    fn push_pattern(&self, instance: usize, name: &str, amplitude: f64) -> PyResult<()> {
        self.check(instance)?;
        let load = Applied::Pattern(self.names.pattern(name)?, amplitude);
        either!(&mut *self.lock()?, AnyInstances, all => all.add(instance, load))
    }

    /// Takes the loads of all instances away.
    fn clear(&self) -> PyResult<()> {
        either!(&mut *self.lock()?, AnyInstances, all => all.clear());
        Ok(())
    }

    /// Moves all instances on, while other threads of Python run. Gives the numbers of instances that move,
    /// that rest, and that kept their state because the next would not be finite.
    #[pyo3(signature = (steps=Count(1)), text_signature = "($self, steps=1)")]
    fn step(&self, py: Python<'_>, steps: Count) -> PyResult<(usize, usize, usize)> {
        let (mut guard, mut status) = (self.lock()?, BatchStatus::default());
        let instances: &mut AnyInstances = &mut guard;
        // A piece is short enough that Python's signals need not wait for long.
        let piece = (100_000 / self.n_instances.max(1)).max(1);
        let mut left = steps.0;
        while left > 0 {
            let now = left.min(piece);
            let stepped = py.detach(|| either!(&mut *instances, AnyInstances, all => all.step(now)));
            status = stepped.map_err(of_step)?;
            left -= now;
            py.check_signals()?;
        }
        Ok((status.moving, status.at_rest, status.refused))
    }

    /// Reads a quantity of each instance as float64, shape (instances, …); of one number, shape (instances,).
    #[pyo3(signature = (quantity, index=None, field="displacement", out=None))]
    fn read<'py>(
        &self,
        py: Python<'py>,
        quantity: &str,
        index: Option<&Bound<'py, PyAny>>,
        field: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (quantity, field) = (self::quantity(quantity)?, self::field(field)?);
        let index = self.names.index(quantity, index)?;
        let length = either!(&*self.lock()?, AnyInstances, all => all.one.body().length(quantity));
        let shape = match quantity {
            Quantity::Surface | Quantity::Whole => vec![length / 3, 3],
            _ if length == 1 => vec![],
            _ => vec![length],
        };
        self.of_each((py, out), &shape, &[(quantity, index)], field)
    }

    /// Reads all probes of each instance, shape (instances, probes).
    #[pyo3(signature = (field="displacement", out=None))]
    fn probes<'py>(
        &self,
        py: Python<'py>,
        field: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let n = self.names.probes.len();
        let all: Vec<_> = (0..n).map(|probe| (Quantity::Probe, probe)).collect();
        self.of_each((py, out), &[n], &all, self::field(field)?)
    }

    /// Reads the energy of each instance in J.
    #[pyo3(signature = (out=None))]
    fn energy<'py>(&self, py: Python<'py>, out: Option<&Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        self.of_each((py, out), &[], &[(Quantity::Energy, 0)], Field::Displacement)
    }

    /// Reads force in N and moment in N m that a support exerts on each body under its loads, shape
    /// (instances, 6).
    #[pyo3(signature = (name, out=None))]
    fn reaction<'py>(
        &self,
        py: Python<'py>,
        name: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let support = self.names.support(name)?;
        let both = [(Quantity::ReactionForce, support), (Quantity::ReactionMoment, support)];
        self.of_each((py, out), &[6], &both, Field::Displacement)
    }

    /// Reads the surface of one instance, shape (surface nodes, 3).
    #[pyo3(signature = (instance, field="displacement", out=None))]
    fn surface<'py>(
        &self,
        py: Python<'py>,
        instance: usize,
        field: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.check(instance)?;
        let field = self::field(field)?;
        either!(&mut *self.lock()?, AnyInstances, all => {
            surface(all.select(instance)?, field, (py, out))
        })
    }

    /// Reads all nodes of one instance, shape (nodes, 3).
    #[pyo3(signature = (instance, field="displacement", out=None))]
    fn whole<'py>(
        &self,
        py: Python<'py>,
        instance: usize,
        field: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.check(instance)?;
        let field = self::field(field)?;
        either!(&mut *self.lock()?, AnyInstances, all => {
            whole(all.select(instance)?, field, (py, out))
        })
    }

    fn __repr__(&self) -> String {
        format!("<Batch of {}>", self.n_instances)
    }
}
