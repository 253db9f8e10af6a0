//! A body that moves.

use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use vademecum_eval::{
    BaseMotion, Contact, Field, OutputError, SceneOptions, Status, StepError, Structure, SurfacePoint, Tensor,
};
use vademecum_study::parameters;

use crate::arrays::{filled, owned};
use crate::body::Body;
use crate::options::{pairs, set};
use crate::point::{Place, PyPoint, contact, located};
use crate::refusal::{busy, of_bind, of_load, of_output, of_step, unknown};

/// How long Python's signals wait at most.
const PATIENCE: Duration = Duration::from_millis(50);
/// Steps between two looks at the clock.
const BLOCK: usize = 64;

/// A body that moves, bound to parameters, with its loads.
#[pyclass(frozen, name = "Scene", module = "vademecum")]
pub struct PyScene {
    body: Mutex<Box<dyn Body>>,
    probes: Vec<String>,
    patterns: Vec<String>,
    supports: Vec<String>,
}

impl PyScene {
    pub fn new(
        body: Box<dyn Body>,
        probes: Vec<String>,
        patterns: Vec<String>,
        supports: Vec<String>,
    ) -> Self {
        Self { body: Mutex::new(body), probes, patterns, supports }
    }

    /// The body, unless another thread has it. Waiting here could wait for ever: this thread holds Python.
    pub fn body(&self) -> PyResult<MutexGuard<'_, Box<dyn Body>>> {
        self.body.try_lock().map_err(|_| busy("scene"))
    }

    pub fn patterns(&self) -> &[String] {
        &self.patterns
    }

    /// A stress or a strain at each point of the file, shape (points, 6).
    fn tensors<'py>(
        &self,
        py: Python<'py>,
        at: impl Fn(&dyn Body, usize) -> Result<Tensor, OutputError>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let body = self.body()?;
        let count = body.stress_points().len();
        let values = (0..count).map(|point| Ok(at(&**body, point)?.0));
        let values = values.collect::<Result<Vec<[f64; 6]>, _>>().map_err(of_output)?;
        owned(py, values.into_flattened(), &[count, 6])
    }

    /// Runs `work` for so many steps in pieces, without Python, and lets Python's signals in between.
    fn in_pieces(
        &self,
        py: Python<'_>,
        steps: usize,
        mut work: impl FnMut(&mut dyn Body, usize) -> Result<Status, StepError> + Send,
    ) -> PyResult<Status> {
        let mut guard = self.body()?;
        let body: &mut dyn Body = &mut **guard;
        let (mut left, mut status) = (steps, Status::Moving);
        while left > 0 {
            let done = py.detach(|| {
                let (started, before) = (Instant::now(), left);
                while left > 0 {
                    let piece = left.min(BLOCK);
                    status = work(body, piece)?;
                    left -= piece;
                    if before != left && started.elapsed() > PATIENCE {
                        break;
                    }
                }
                Ok(())
            });
            done.map_err(of_step)?;
            py.check_signals()?;
        }
        Ok(status)
    }

    fn places(&self, points: Vec<Place>) -> PyResult<Vec<Contact>> {
        let body = self.body()?;
        let place = |point: &Place| Ok(contact(&point.on(|at| body.locate(at))?, [0.0; 3]));
        points.iter().map(place).collect()
    }
}

/// A field by its name.
pub fn field(name: &str) -> PyResult<Field> {
    match name {
        "displacement" => Ok(Field::Displacement),
        "velocity" => Ok(Field::Velocity),
        _ => Err(PyValueError::new_err(format!("field is `{name}`; expected `displacement` or `velocity`"))),
    }
}

/// The number of a name.
pub fn index(what: &str, names: &[String], name: &str) -> PyResult<usize> {
    names.iter().position(|known| known == name).ok_or_else(|| unknown(what, name, names))
}

/// Values of live parameters by name.
pub fn values<'py>(py: Python<'py>, body: &dyn Body) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for parameter in parameters::values(&body.options(), body.metadata()) {
        dict.set_item(parameter.name, parameter.value)?;
    }
    Ok(dict)
}

/// Sets live parameters by name: all of them, or none if one is refused.
pub fn change(body: &mut dyn Body, given: Vec<(String, f64)>) -> PyResult<()> {
    let mut options: SceneOptions = body.options();
    // A time step that was set before is no second one.
    options.time_step = None;
    let values = set(&mut options, body.metadata(), given)?;
    for value in values {
        let index = SceneOptions::find(body.metadata(), &value.name);
        body.set(index.unwrap_or(usize::MAX), value.value).map_err(of_bind)?;
    }
    Ok(())
}

#[pymethods]
impl PyScene {
    #[getter]
    fn dtype<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let single = self.body()?.is_single();
        let dtype = if single { numpy::dtype::<f32>(py) } else { numpy::dtype::<f64>(py) };
        Ok(dtype.into_any())
    }

    #[getter]
    fn structure(&self) -> PyResult<&'static str> {
        Ok(match self.body()?.structure() {
            Structure::Diagonal => "diagonal",
            Structure::Block => "block",
            Structure::Exact => "exact",
            Structure::Strain => "strain",
        })
    }

    #[getter]
    fn time_step(&self) -> PyResult<f64> {
        Ok(self.body()?.time_step())
    }

    #[getter]
    fn modes(&self) -> PyResult<u32> {
        Ok(self.body()?.metadata().n_modes)
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

    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        values(py, &**self.body()?)
    }

    #[pyo3(signature = (values=None, /, **parameters))]
    fn set(
        &self,
        values: Option<&Bound<'_, PyDict>>,
        parameters: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let given = pairs(values, parameters)?;
        change(&mut **self.body()?, given)
    }

    fn locate(&self, point: [f64; 3]) -> PyResult<PyPoint> {
        let body = self.body()?;
        located(point, |at| body.locate(at)).map(PyPoint)
    }

    #[pyo3(signature = (origin, direction, scale=1.0))]
    fn pick(&self, origin: [f64; 3], direction: [f64; 3], scale: f64) -> PyResult<Option<PyPoint>> {
        Ok(self.body()?.pick(origin, direction, scale).map(PyPoint))
    }

    fn contact(&self, at: Place, force: [f64; 3]) -> PyResult<PyPoint> {
        let mut body = self.body()?;
        let at: SurfacePoint = at.on(|point| body.locate(point))?;
        body.push(&at, force).map_err(of_load)?;
        Ok(PyPoint(at))
    }

    #[pyo3(signature = (name, amplitude=1.0))]
    fn pattern(&self, name: &str, amplitude: f64) -> PyResult<()> {
        let index = index("load pattern", &self.patterns, name)?;
        self.body()?.push_pattern(index, amplitude).map_err(of_load)
    }

    #[pyo3(signature = (acceleration=[0.0; 3], angular_velocity=[0.0; 3], angular_acceleration=[0.0; 3]))]
    fn base(
        &self,
        acceleration: [f64; 3],
        angular_velocity: [f64; 3],
        angular_acceleration: [f64; 3],
    ) -> PyResult<()> {
        let motion = BaseMotion { acceleration, angular_velocity, angular_acceleration };
        self.body()?.push_base(motion).map_err(of_load)
    }

    fn clear(&self) -> PyResult<()> {
        self.body()?.clear();
        Ok(())
    }

    fn rest(&self) -> PyResult<()> {
        self.body()?.rest();
        Ok(())
    }

    #[pyo3(signature = (steps=1))]
    fn step(&self, py: Python<'_>, steps: usize) -> PyResult<bool> {
        let status = self.in_pieces(py, steps, |body, steps| body.step(steps))?;
        Ok(status == Status::Moving)
    }

    #[pyo3(signature = (steps, every=1, field="displacement"))]
    fn march<'py>(
        &self,
        py: Python<'py>,
        steps: usize,
        every: usize,
        field: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        if every == 0 {
            return Err(PyValueError::new_err("every is 0; expected a number of steps from 1"));
        }
        let (field, n) = (self::field(field)?, self.probes.len());
        let rows = steps / every;
        let too_many = || PyValueError::new_err(format!("{rows} rows of {n} probes do not fit into memory"));
        let mut table: Vec<f64> = vec![];
        table.try_reserve_exact(rows.checked_mul(n).ok_or_else(too_many)?).map_err(|_| too_many())?;
        // Found before anything moves, so that a row can be read once a step is done.
        let body = self.body()?;
        (0..n).try_for_each(|probe| body.probe(probe, field).map(drop)).map_err(of_output)?;
        drop(body);
        let mut done = 0;
        self.in_pieces(py, steps, |body, piece| {
            let mut status = Status::Moving;
            for _ in 0..piece {
                status = body.step(1)?;
                done += 1;
                if done % every == 0 {
                    table.extend((0..n).map(|probe| body.probe(probe, field).unwrap_or(f64::NAN)));
                }
            }
            Ok(status)
        })?;
        owned(py, table, &[rows, n])
    }

    #[pyo3(signature = (name, field="displacement"))]
    fn probe(&self, name: &str, field: &str) -> PyResult<f64> {
        let (index, field) = (index("probe", &self.probes, name)?, self::field(field)?);
        self.body()?.probe(index, field).map_err(of_output)
    }

    #[pyo3(signature = (field="displacement", out=None))]
    fn probes<'py>(
        &self,
        py: Python<'py>,
        field: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (field, body) = (self::field(field)?, self.body()?);
        filled::<f64>(py, &[self.probes.len()], out, |slice| {
            for (probe, value) in slice.iter_mut().enumerate() {
                *value = body.probe(probe, field).map_err(of_output)?;
            }
            Ok(())
        })
    }

    #[pyo3(signature = (at, field="displacement", out=None))]
    fn point<'py>(
        &self,
        py: Python<'py>,
        at: Place,
        field: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (field, body) = (self::field(field)?, self.body()?);
        let at = at.on(|point| body.locate(point))?;
        let moved = body.point(&at, field).map_err(of_output)?;
        filled::<f64>(py, &[3], out, |slice| {
            slice.copy_from_slice(&moved);
            Ok(())
        })
    }

    #[pyo3(signature = (node, field="displacement", out=None))]
    fn node<'py>(
        &self,
        py: Python<'py>,
        node: usize,
        field: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let moved = self.body()?.node(node, self::field(field)?).map_err(of_output)?;
        filled::<f64>(py, &[3], out, |slice| {
            slice.copy_from_slice(&moved);
            Ok(())
        })
    }

    #[pyo3(signature = (field="displacement", out=None))]
    fn surface<'py>(
        &self,
        py: Python<'py>,
        field: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.body()?.surface(self::field(field)?, (py, out))
    }

    #[pyo3(name = "body", signature = (field="displacement", out=None))]
    fn whole_body<'py>(
        &self,
        py: Python<'py>,
        field: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.body()?.body(self::field(field)?, (py, out))
    }

    fn reaction<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let index = index("support", &self.supports, name)?;
        let exerted = self.body()?.reaction(index).map_err(of_output)?;
        owned(py, exerted.to_vec(), &[6])
    }

    #[getter]
    fn stress_points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let points = self.body()?.stress_points();
        let numbers: Vec<u32> = points.iter().flat_map(|point| [point.node, point.region]).collect();
        owned(py, numbers, &[points.len(), 2])
    }

    fn stress<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.tensors(py, |body, point| body.stress(point))
    }

    fn strain<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.tensors(py, |body, point| body.strain(point))
    }

    fn von_mises<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let body = self.body()?;
        let all = (0..body.stress_points().len()).map(|point| Ok(body.stress(point)?.von_mises()));
        let values = all.collect::<Result<Vec<f64>, _>>().map_err(of_output)?;
        let count = values.len();
        owned(py, values, &[count])
    }

    #[getter]
    fn energy(&self) -> PyResult<f64> {
        self.body()?.energy().map_err(of_output)
    }

    #[pyo3(signature = (out=None))]
    fn save<'py>(&self, py: Python<'py>, out: Option<&Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        self.body()?.save((py, out))
    }

    fn restore(&self, saved: &Bound<'_, PyAny>) -> PyResult<()> {
        self.body()?.restore(saved)
    }

    #[pyo3(signature = (zeta, velocity=None))]
    fn place(&self, zeta: Vec<f64>, velocity: Option<Vec<f64>>) -> PyResult<()> {
        let velocity = velocity.unwrap_or_else(|| vec![0.0; zeta.len()]);
        self.body()?.place(&zeta, &velocity).map_err(of_step)
    }

    fn compliance<'py>(&self, py: Python<'py>, points: Vec<Place>) -> PyResult<Bound<'py, PyAny>> {
        let contacts = self.places(points)?;
        let n = 3 * contacts.len();
        let w = self.body()?.compliance(&contacts).map_err(of_load)?;
        owned(py, w, &[n, n])
    }

    fn free_motion<'py>(&self, py: Python<'py>, points: Vec<Place>) -> PyResult<Bound<'py, PyAny>> {
        let contacts = self.places(points)?;
        let moved = self.body()?.free_motion(&contacts).map_err(of_step)?;
        owned(py, moved, &[contacts.len(), 3])
    }

    fn __repr__(&self) -> PyResult<String> {
        let (structure, body) = (self.structure()?, self.body()?);
        let precision = if body.is_single() { "float32" } else { "float64" };
        let metadata = body.metadata();
        Ok(format!(
            "<Scene of {} modes and {} nodes, {structure} structure, {precision}, {} s a step>",
            metadata.n_modes,
            metadata.n_nodes,
            body.time_step()
        ))
    }
}
