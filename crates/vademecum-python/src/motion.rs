//! Rigid motions of bodies without supports.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use vademecum_eval::RigidMotion;

use crate::point::Vector;

/// The rigid motion of a body that flies: position of its centre, attitude, and momenta, in space.
#[pyclass(frozen, name = "Motion", module = "vademecum")]
#[derive(Clone, Copy)]
pub struct PyMotion(pub RigidMotion);

#[pymethods]
impl PyMotion {
    #[new]
    #[pyo3(
        signature = (
            position,
            attitude=[1.0, 0.0, 0.0, 0.0],
            momentum=Vector::ZERO,
            angular_momentum=Vector::ZERO,
        ),
        text_signature = "(position, attitude=(1.0, 0.0, 0.0, 0.0), momentum=(0.0, 0.0, 0.0), \
                          angular_momentum=(0.0, 0.0, 0.0))"
    )]
    fn new(
        position: Vector,
        attitude: [f64; 4],
        momentum: Vector,
        angular_momentum: Vector,
    ) -> PyResult<Self> {
        let (Vector(position), Vector(momentum)) = (position, momentum);
        let Vector(angular_momentum) = angular_momentum;
        let motion = RigidMotion { position, attitude, momentum, angular_momentum };
        let said = "a number of the motion is not finite, or its attitude is zero";
        motion.normalised().map(Self).ok_or_else(|| PyValueError::new_err(said))
    }

    /// Position of the centre in m.
    #[getter]
    fn position(&self) -> (f64, f64, f64) {
        self.0.position.into()
    }

    /// A quaternion of length one, the real part first, that turns directions of the body into those of
    /// space.
    #[getter]
    fn attitude(&self) -> (f64, f64, f64, f64) {
        self.0.attitude.into()
    }

    /// Momentum in space in kg m/s.
    #[getter]
    fn momentum(&self) -> (f64, f64, f64) {
        self.0.momentum.into()
    }

    /// Angular momentum about the centre, in space, in kg m2/s.
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
