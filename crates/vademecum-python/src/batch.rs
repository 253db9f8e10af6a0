//! Many bodies of one file, stepped together.

use std::sync::{Mutex, MutexGuard};

use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use self_cell::{MutBorrow, self_cell};
use vademecum_eval::{
    Batch, BatchStatus, BindError, Contact, Field, LoadError, OutputError, Scene, Simulation, StepError,
    SurfacePoint,
};

use crate::arrays::filled;
use crate::body::{Body, Number, Out};
use crate::options::pairs;
use crate::point::{Place, PyPoint, contact, located};
use crate::refusal::{busy, of_bind, of_load, of_output, of_step};
use crate::scene::{change, field, index, values};

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
    fn of(scene: &Scene<'_, T>, n_instances: usize) -> Result<Self, BindError>;
    fn with<R>(&mut self, run: impl for<'m> FnOnce(&mut Batch<'m, T>) -> R) -> R;
}

macro_rules! cell {
    ($cell:ident, $number:ty) => {
        impl Cell<$number> for $cell {
            fn of(scene: &Scene<'_, $number>, n_instances: usize) -> Result<Self, BindError> {
                let memory = vec![0.0; Batch::len_for(scene, n_instances)];
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
    Contact(Contact),
    Pattern(usize, f64),
}

/// The instances, and a body of the same file through which each is loaded and read.
struct Instances<T: Number, C> {
    one: Simulation<T>,
    batch: C,
    applied: Vec<Vec<Applied>>,
}

impl<T: Number, C: Cell<T>> Instances<T, C> {
    fn load(&mut self, instance: usize) -> Result<(), LoadError> {
        let (batch, applied) = (&mut self.batch, &self.applied[instance]);
        self.one.with(|scene, _, loads| {
            loads.clear();
            for load in applied {
                match load {
                    Applied::Contact(contact) => loads.add_contact(scene, contact)?,
                    Applied::Pattern(pattern, amplitude) => loads.add_pattern(scene, *pattern, *amplitude)?,
                }
            }
            batch.with(|batch| batch.load(scene, instance, loads))
        })
    }
}

/// Instances whose precision is known at run time.
trait Bodies: Send {
    fn one(&mut self) -> &mut dyn Body;
    fn add(&mut self, instance: usize, load: Applied) -> Result<(), LoadError>;
    fn clear(&mut self);
    fn step(&mut self, steps: usize) -> Result<BatchStatus, StepError>;
    fn select(&mut self, instance: usize) -> Result<(), StepError>;
    fn select_loaded(&mut self, instance: usize) -> PyResult<()>;
    fn reload(&mut self) -> PyResult<()>;
}

impl<T: Number, C: Cell<T>> Bodies for Instances<T, C> {
    fn one(&mut self) -> &mut dyn Body {
        &mut self.one
    }

    fn add(&mut self, instance: usize, load: Applied) -> Result<(), LoadError> {
        self.applied[instance].push(load);
        let loaded = self.load(instance);
        if loaded.is_err() {
            self.applied[instance].pop();
        }
        loaded
    }

    fn clear(&mut self) {
        self.applied.iter_mut().for_each(Vec::clear);
        self.batch.with(|batch| batch.clear());
    }

    fn step(&mut self, steps: usize) -> Result<BatchStatus, StepError> {
        let (scene, mut status) = (self.one.scene(), BatchStatus::default());
        self.batch.with(|batch| {
            for _ in 0..steps {
                status = batch.step(scene)?;
            }
            Ok(status)
        })
    }

    fn select(&mut self, instance: usize) -> Result<(), StepError> {
        let batch = &mut self.batch;
        self.one.with(|_, state, _| batch.with(|batch| batch.get(instance, state)))
    }

    /// The state, and the loads of the instance as those of its last step.
    fn select_loaded(&mut self, instance: usize) -> PyResult<()> {
        self.load(instance).map_err(of_load)?;
        let batch = &mut self.batch;
        let done =
            self.one.with(|_, state, loads| batch.with(|batch| batch.get_under(instance, state, loads)));
        done.map_err(of_step)
    }

    fn reload(&mut self) -> PyResult<()> {
        let scene = self.one.scene();
        self.batch
            .with(|batch| {
                batch.clear();
                batch.carry(scene)
            })
            .map_err(of_step)?;
        let loaded: Vec<usize> = (0..self.applied.len()).filter(|&i| !self.applied[i].is_empty()).collect();
        loaded.into_iter().try_for_each(|instance| self.load(instance)).map_err(of_load)
    }
}

/// Many bodies of one file.
#[pyclass(frozen, name = "Batch", module = "vademecum")]
pub struct PyBatch {
    bodies: Mutex<Box<dyn Bodies>>,
    n_instances: usize,
    probes: Vec<String>,
    patterns: Vec<String>,
    supports: Vec<String>,
}

/// The instances of a batch in single precision.
pub fn single(one: Simulation<f32>, n: usize, names: [Vec<String>; 3]) -> PyResult<PyBatch> {
    PyBatch::new::<f32, SingleCell>(one, n, names)
}

/// The instances of a batch in double precision.
pub fn double(one: Simulation<f64>, n: usize, names: [Vec<String>; 3]) -> PyResult<PyBatch> {
    PyBatch::new::<f64, DoubleCell>(one, n, names)
}

impl PyBatch {
    fn new<T: Number, C: Cell<T> + 'static>(
        one: Simulation<T>,
        n_instances: usize,
        [probes, patterns, supports]: [Vec<String>; 3],
    ) -> PyResult<Self> {
        let batch = C::of(one.scene(), n_instances).map_err(of_bind)?;
        let bodies = Instances { one, batch, applied: vec![vec![]; n_instances] };
        Ok(Self { bodies: Mutex::new(Box::new(bodies)), n_instances, probes, patterns, supports })
    }

    fn bodies(&self) -> PyResult<MutexGuard<'_, Box<dyn Bodies>>> {
        self.bodies.try_lock().map_err(|_| busy("batch"))
    }

    fn check(&self, instance: usize) -> PyResult<()> {
        if instance < self.n_instances {
            return Ok(());
        }
        Err(PyIndexError::new_err(format!("instance {instance}; the batch has {}", self.n_instances)))
    }

    /// One number, or a few, of each instance.
    fn of_each<'py>(
        &self,
        shape: &[usize],
        (py, out): Out<'_, 'py>,
        read: impl Fn(&dyn Body, &mut [f64]) -> Result<(), OutputError>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (mut bodies, each) = (self.bodies()?, shape[1..].iter().product::<usize>());
        filled::<f64>(py, shape, out, |slice| {
            for (instance, row) in slice.chunks_exact_mut(each.max(1)).enumerate() {
                bodies.select(instance).map_err(of_step)?;
                read(&*bodies.one(), row).map_err(of_output)?;
            }
            Ok(())
        })
    }

    fn one_field<'py>(
        &self,
        instance: usize,
        show: impl FnOnce(&dyn Body, Field) -> PyResult<Bound<'py, PyAny>>,
        field: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.check(instance)?;
        let (field, mut bodies) = (self::field(field)?, self.bodies()?);
        bodies.select(instance).map_err(of_step)?;
        show(&*bodies.one(), field)
    }
}

#[pymethods]
impl PyBatch {
    fn __len__(&self) -> usize {
        self.n_instances
    }

    #[getter]
    fn time_step(&self) -> PyResult<f64> {
        Ok(self.bodies()?.one().time_step())
    }

    #[getter]
    fn probe_names(&self) -> Vec<String> {
        self.probes.clone()
    }

    #[getter]
    fn pattern_names(&self) -> Vec<String> {
        self.patterns.clone()
    }

    #[getter]
    fn support_names(&self) -> Vec<String> {
        self.supports.clone()
    }

    #[pyo3(signature = (name, out=None))]
    fn reaction<'py>(
        &self,
        py: Python<'py>,
        name: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let support = index("support", &self.supports, name)?;
        let mut bodies = self.bodies()?;
        filled::<f64>(py, &[self.n_instances, 6], out, |slice| {
            for (instance, row) in slice.as_chunks_mut::<6>().0.iter_mut().enumerate() {
                bodies.select_loaded(instance)?;
                *row = bodies.one().reaction(support).map_err(of_output)?;
            }
            Ok(())
        })
    }

    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        values(py, self.bodies()?.one())
    }

    #[pyo3(signature = (values=None, /, **parameters))]
    fn set(
        &self,
        values: Option<&Bound<'_, PyDict>>,
        parameters: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let (given, mut bodies) = (pairs(values, parameters)?, self.bodies()?);
        change(bodies.one(), given)?;
        bodies.reload()
    }

    fn locate(&self, point: [f64; 3]) -> PyResult<PyPoint> {
        let mut bodies = self.bodies()?;
        located(point, |at| bodies.one().locate(at)).map(PyPoint)
    }

    fn contact(&self, instance: usize, at: Place, force: [f64; 3]) -> PyResult<PyPoint> {
        self.check(instance)?;
        let mut bodies = self.bodies()?;
        let at: SurfacePoint = at.on(|point| bodies.one().locate(point))?;
        bodies.add(instance, Applied::Contact(contact(&at, force))).map_err(of_load)?;
        Ok(PyPoint(at))
    }

    #[pyo3(signature = (instance, name, amplitude=1.0))]
    fn pattern(&self, instance: usize, name: &str, amplitude: f64) -> PyResult<()> {
        self.check(instance)?;
        let index = index("load pattern", &self.patterns, name)?;
        self.bodies()?.add(instance, Applied::Pattern(index, amplitude)).map_err(of_load)
    }

    fn clear(&self) -> PyResult<()> {
        self.bodies()?.clear();
        Ok(())
    }

    #[pyo3(signature = (steps=1))]
    fn step(&self, py: Python<'_>, steps: usize) -> PyResult<(usize, usize, usize)> {
        let (mut bodies, mut status) = (self.bodies()?, BatchStatus::default());
        let bodies: &mut dyn Bodies = &mut **bodies;
        // A piece is short enough that Python's signals need not wait for long.
        let piece = (100_000 / self.n_instances.max(1)).max(1);
        let mut left = steps;
        while left > 0 {
            let now = left.min(piece);
            status = py.detach(|| bodies.step(now)).map_err(of_step)?;
            left -= now;
            py.check_signals()?;
        }
        Ok((status.moving, status.at_rest, status.refused))
    }

    #[pyo3(signature = (field="displacement", out=None))]
    fn probes<'py>(
        &self,
        py: Python<'py>,
        field: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let field = self::field(field)?;
        self.of_each(&[self.n_instances, self.probes.len()], (py, out), |body, row| {
            row.iter_mut().enumerate().try_for_each(|(probe, value)| {
                *value = body.probe(probe, field)?;
                Ok(())
            })
        })
    }

    #[pyo3(signature = (out=None))]
    fn energy<'py>(&self, py: Python<'py>, out: Option<&Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        self.of_each(&[self.n_instances], (py, out), |body, row| {
            row[0] = body.energy()?;
            Ok(())
        })
    }

    #[pyo3(signature = (instance, field="displacement", out=None))]
    fn surface<'py>(
        &self,
        py: Python<'py>,
        instance: usize,
        field: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.one_field(instance, |body, field| body.surface(field, (py, out)), field)
    }

    #[pyo3(signature = (instance, field="displacement", out=None))]
    fn body<'py>(
        &self,
        py: Python<'py>,
        instance: usize,
        field: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.one_field(instance, |body, field| body.body(field, (py, out)), field)
    }

    fn __repr__(&self) -> String {
        format!("<Batch of {}>", self.n_instances)
    }
}
