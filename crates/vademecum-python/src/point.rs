//! Points of the surface.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use vademecum_eval::{Contact, SurfacePoint};

/// A point of the surface: three nodes and their weights.
#[pyclass(frozen, name = "SurfacePoint", module = "vademecum")]
#[derive(Clone, Copy)]
pub struct PyPoint(pub SurfacePoint);

#[pymethods]
impl PyPoint {
    #[new]
    #[pyo3(signature = (nodes, weights=[1.0, 0.0, 0.0], position=[f64::NAN; 3], distance=0.0))]
    fn new(nodes: [u32; 3], weights: [f64; 3], position: [f64; 3], distance: f64) -> Self {
        Self(SurfacePoint { place: vademecum_eval::Place::triangle(nodes, weights), position, distance })
    }

    #[getter]
    fn nodes(&self) -> (u32, u32, u32) {
        self.0.place.corners().unwrap_or_default().0.into()
    }

    #[getter]
    fn weights(&self) -> (f64, f64, f64) {
        self.0.place.corners().unwrap_or_default().1.into()
    }

    #[getter]
    fn position(&self) -> (f64, f64, f64) {
        self.0.position.into()
    }

    #[getter]
    fn distance(&self) -> f64 {
        self.0.distance
    }

    fn __repr__(&self) -> String {
        let SurfacePoint { position: [x, y, z], distance, .. } = self.0;
        let (a, b, c) = self.nodes();
        format!("<SurfacePoint at ({x}, {y}, {z}), nodes {a}, {b}, {c}, {distance} away>")
    }
}

/// A point of the surface, or a point in space whose nearest point of the loadable surface is meant.
#[derive(FromPyObject)]
pub enum Place {
    Found(Py<PyPoint>),
    Space([f64; 3]),
}

impl Place {
    /// The point of the surface that is meant.
    pub fn on(&self, locate: impl FnOnce([f64; 3]) -> Option<SurfacePoint>) -> PyResult<SurfacePoint> {
        match self {
            Self::Found(point) => Ok(point.get().0),
            Self::Space(point) => located(*point, locate),
        }
    }
}

/// The nearest point of the loadable surface.
pub fn located(
    point: [f64; 3],
    locate: impl FnOnce([f64; 3]) -> Option<SurfacePoint>,
) -> PyResult<SurfacePoint> {
    if !point.iter().all(|x| x.is_finite()) {
        return Err(PyValueError::new_err("the point has a number that is not finite"));
    }
    locate(point).ok_or_else(|| PyValueError::new_err("the file has no loadable surface to find a point on"))
}

/// A force at a point.
pub fn contact(at: &SurfacePoint, force: [f64; 3]) -> Contact {
    Contact::new(at.place, force)
}
