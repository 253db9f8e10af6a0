//! The rigid motion of a body without supports.

use std::sync::{Mutex, MutexGuard};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use vademecum_eval::{Field, FreeBody, RigidMotion, Status};

use crate::arrays::{filled, owned};
use crate::body::{Body, Out};
use crate::point::{Place, PyPoint};
use crate::refusal::{busy, of_load, of_output, of_step};
use crate::scene::{PyScene, index};

/// Where a body is in space, how it is turned, and its momenta.
#[pyclass(frozen, name = "Motion", module = "vademecum")]
#[derive(Clone, Copy)]
pub struct PyMotion(RigidMotion);

#[pymethods]
impl PyMotion {
    #[new]
    #[pyo3(signature = (
        position,
        attitude=[1.0, 0.0, 0.0, 0.0],
        momentum=[0.0; 3],
        angular_momentum=[0.0; 3],
    ))]
    fn new(
        position: [f64; 3],
        attitude: [f64; 4],
        momentum: [f64; 3],
        angular_momentum: [f64; 3],
    ) -> PyResult<Self> {
        let motion = RigidMotion { position, attitude, momentum, angular_momentum };
        checked(motion).map(Self)
    }

    #[getter]
    fn position(&self) -> (f64, f64, f64) {
        self.0.position.into()
    }

    #[getter]
    fn attitude(&self) -> (f64, f64, f64, f64) {
        self.0.attitude.into()
    }

    #[getter]
    fn momentum(&self) -> (f64, f64, f64) {
        self.0.momentum.into()
    }

    #[getter]
    fn angular_momentum(&self) -> (f64, f64, f64) {
        self.0.angular_momentum.into()
    }

    fn __repr__(&self) -> String {
        let RigidMotion { position, attitude, momentum, angular_momentum } = self.0;
        format!(
            "Motion(position={position:?}, attitude={attitude:?}, momentum={momentum:?}, \
             angular_momentum={angular_momentum:?})"
        )
    }
}

/// A motion of finite numbers, with an attitude of length one.
fn checked(motion: RigidMotion) -> PyResult<RigidMotion> {
    let said = "a number of the motion is not finite, or its attitude is zero";
    motion.normalised().ok_or_else(|| PyValueError::new_err(said))
}

/// The flight of a body: its rigid motion beside its elastic one, which is that of the scene.
#[pyclass(frozen, name = "Flight", module = "vademecum")]
pub struct PyFlight {
    scene: Py<PyScene>,
    free: Mutex<FreeBody>,
}

impl PyFlight {
    /// Body and rigid motion, at the density that the scene has now.
    fn with<R>(&self, run: impl FnOnce(&mut dyn Body, &mut FreeBody) -> PyResult<R>) -> PyResult<R> {
        let mut body = self.scene.get().body()?;
        let mut free: MutexGuard<'_, FreeBody> = self.free.try_lock().map_err(|_| busy("flight"))?;
        body.follow(&mut free);
        run(&mut **body, &mut free)
    }

    fn in_space<'py>(
        &self,
        (py, out): Out<'_, 'py>,
        at: &Place,
        field: Field,
    ) -> PyResult<Bound<'py, PyAny>> {
        let found = self.with(|body, free| {
            let at = at.on(|point| body.locate(point))?;
            body.in_space(free, &at, field).map_err(of_output)
        })?;
        filled::<f64>(py, &[3], out, |slice| {
            slice.copy_from_slice(&found);
            Ok(())
        })
    }
}

#[pymethods]
impl PyFlight {
    #[new]
    #[pyo3(signature = (scene, velocity=[0.0; 3], spin=[0.0; 3]))]
    fn new(scene: Py<PyScene>, velocity: [f64; 3], spin: [f64; 3]) -> PyResult<Self> {
        let said = "the body has supports, so it has no rigid motion; build it without `support`";
        let mut free = scene.get().body()?.free_body().ok_or_else(|| PyValueError::new_err(said))?;
        free.set_motion(checked(RigidMotion::thrown(free.body(), velocity, spin))?);
        Ok(Self { scene, free: Mutex::new(free) })
    }

    #[getter]
    fn scene(&self, py: Python<'_>) -> Py<PyScene> {
        self.scene.clone_ref(py)
    }

    #[getter]
    fn mass(&self) -> PyResult<f64> {
        self.with(|_, free| Ok(free.body().mass))
    }

    #[getter]
    fn moments(&self) -> PyResult<(f64, f64, f64)> {
        self.with(|_, free| Ok(free.body().moments.into()))
    }

    #[getter]
    fn axes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let axes = self.with(|_, free| Ok(free.body().axes))?;
        owned(py, axes.as_flattened().to_vec(), &[3, 3])
    }

    #[getter]
    fn motion(&self) -> PyResult<PyMotion> {
        self.with(|_, free| Ok(PyMotion(*free.motion())))
    }

    #[setter]
    fn set_motion(&self, motion: &Bound<'_, PyMotion>) -> PyResult<()> {
        self.with(|_, free| {
            free.set_motion(motion.get().0);
            Ok(())
        })
    }

    #[getter]
    fn ahead(&self) -> PyResult<PyMotion> {
        self.with(|body, free| Ok(PyMotion(body.ahead(free))))
    }

    fn contact(&self, at: Place, force: [f64; 3]) -> PyResult<PyPoint> {
        self.with(|body, free| {
            let at = at.on(|point| body.locate(point))?;
            body.push_free(free, &at, force).map_err(of_load)?;
            Ok(PyPoint(at))
        })
    }

    #[pyo3(signature = (name, amplitude=1.0))]
    fn pattern(&self, name: &str, amplitude: f64) -> PyResult<()> {
        let index = index("load pattern", self.scene.get().patterns(), name)?;
        self.with(|body, free| body.push_free_pattern(free, index, amplitude).map_err(of_load))
    }

    fn pull(&self, force: [f64; 3]) -> PyResult<()> {
        self.with(|_, free| {
            free.pull(force);
            Ok(())
        })
    }

    fn clear(&self) -> PyResult<()> {
        self.with(|body, free| {
            body.clear_free(free);
            Ok(())
        })
    }

    fn step(&self) -> PyResult<bool> {
        self.with(|body, free| Ok(body.fly(free).map_err(of_step)? == Status::Moving))
    }

    #[pyo3(signature = (at, out=None))]
    fn point<'py>(
        &self,
        py: Python<'py>,
        at: Place,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.in_space((py, out), &at, Field::Displacement)
    }

    #[pyo3(signature = (at, out=None))]
    fn velocity<'py>(
        &self,
        py: Python<'py>,
        at: Place,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.in_space((py, out), &at, Field::Velocity)
    }

    fn __repr__(&self) -> PyResult<String> {
        self.with(|_, free| {
            let ([x, y, z], mass) = (free.motion().position, free.body().mass);
            Ok(format!("<Flight of {mass} kg at ({x}, {y}, {z})>"))
        })
    }
}
