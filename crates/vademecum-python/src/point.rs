//! Places and vectors, as Python gives them.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use vademecum_eval::{LocateError, Place, SurfacePoint};

use crate::refusal::{of_locate, of_place};

/// A place on a body: up to 16 nodes, in the order of the file, their weights, which sum to 1, and a radius
/// in m. Without weights the nodes have equal ones. Radius 0 is a point; this version takes points only.
#[pyclass(frozen, name = "SurfacePoint", module = "vademecum")]
#[derive(Clone, Copy)]
pub struct PyPoint(pub SurfacePoint);

#[pymethods]
impl PyPoint {
    #[new]
    #[pyo3(signature = (nodes, weights=None, radius=0.0, position=None, distance=0.0))]
    fn new(
        nodes: Vec<u32>,
        weights: Option<Vec<f64>>,
        radius: f64,
        position: Option<Vector>,
        distance: f64,
    ) -> PyResult<Self> {
        let weights = weights.unwrap_or_else(|| vec![1.0 / nodes.len() as f64; nodes.len()]);
        let place = Place::new(&nodes, &weights).map_err(of_place)?.with_radius(radius);
        place.check().map_err(of_place)?;
        let Vector(position) = position.unwrap_or(Vector([f64::NAN; 3]));
        Ok(Self(SurfacePoint { place, position, distance }))
    }

    /// Its nodes, in the order of the file.
    #[getter]
    fn nodes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.0.place.nodes())
    }

    /// The weight of each node.
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.0.place.weights())
    }

    /// Radius in m, 0 of a point.
    #[getter]
    fn radius(&self) -> f64 {
        self.0.place.radius()
    }

    /// Position at rest in m; of a picked point, position in the picture.
    #[getter]
    fn position(&self) -> (f64, f64, f64) {
        self.0.position.into()
    }

    /// Distance in m from the point that was asked for.
    #[getter]
    fn distance(&self) -> f64 {
        self.0.distance
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let parts = (self.nodes(py)?, self.weights(py)?, self.radius(), self.position(), self.distance());
        (py.get_type::<Self>(), parts).into_pyobject(py)
    }

    fn __repr__(&self) -> String {
        let SurfacePoint { place, position: [x, y, z], distance } = self.0;
        let nodes: Vec<String> = place.nodes().iter().map(u32::to_string).collect();
        format!("<SurfacePoint at ({x}, {y}, {z}), nodes {}, {distance} away>", nodes.join(", "))
    }
}

/// Three numbers: a force, a direction, a point in space.
#[derive(Clone, Copy)]
pub struct Vector(pub [f64; 3]);

impl Vector {
    pub const ZERO: Self = Self([0.0; 3]);
}

impl FromPyObject<'_, '_> for Vector {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        given.extract().map(Self).map_err(|error| wrong(&given, "three numbers", &error))
    }
}

/// A number of steps.
#[derive(Clone, Copy)]
pub struct Count(pub usize);

impl FromPyObject<'_, '_> for Count {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        given.extract().map(Self).map_err(|error| wrong(&given, "a whole number from 0", &error))
    }
}

/// A place, or a point in space whose nearest point of the loadable surface is meant.
pub enum Target {
    Found(Py<PyPoint>),
    Space([f64; 3]),
}

impl FromPyObject<'_, '_> for Target {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        if let Ok(point) = given.cast::<PyPoint>() {
            return Ok(Self::Found(point.to_owned().unbind()));
        }
        let expected = "a SurfacePoint or three coordinates";
        given.extract().map(Self::Space).map_err(|error| wrong(&given, expected, &error))
    }
}

impl Target {
    /// The place that is meant.
    pub fn on(
        &self,
        locate: impl FnOnce([f64; 3]) -> Result<SurfacePoint, LocateError>,
    ) -> PyResult<SurfacePoint> {
        match self {
            Self::Found(point) => Ok(point.get().0),
            Self::Space(point) => locate(*point).map_err(of_locate),
        }
    }
}

/// A refusal of an argument, as a `TypeError` where it has the wrong type.
pub fn wrong(given: &Borrowed<'_, '_, PyAny>, expected: &str, error: &PyErr) -> PyErr {
    let found: String =
        given.repr().map_or_else(|_| "?".into(), |text| text.to_string().chars().take(60).collect());
    let words = format!("expected {expected}, found {found}");
    if error.is_instance_of::<PyTypeError>(given.py()) {
        PyTypeError::new_err(words)
    } else {
        PyValueError::new_err(words)
    }
}
