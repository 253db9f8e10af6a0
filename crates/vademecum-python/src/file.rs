//! A vademecum file in memory.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use vademecum_cli::{Limit, contents_json, page};
use vademecum_eval::{EmbeddedSurface, Precision, Simulation};
use vademecum_study::contents::Geometry;

use crate::arrays::owned;
use crate::batch::PyBatch;
use crate::body::PyBody;
use crate::content::{Content, Shared};
use crate::names::Names;
use crate::options::{Asked, asked, precision};
use crate::point::Count;
use crate::refusal::{Refusal, of_missing, of_output, of_simulation};
use crate::simulation::{AnySimulation, Number, change};

/// A vademecum file in memory.
#[pyclass(frozen, name = "File", module = "vademecum._native")]
pub struct PyFile {
    pub content: Arc<Content>,
    pub path: PathBuf,
}

impl PyFile {
    /// A body at rest in the precision that `dtype` means.
    fn bind(&self, dtype: &Bound<'_, PyAny>, asked: Asked, flight: bool) -> PyResult<AnySimulation> {
        Ok(match precision(dtype)? {
            Precision::Single => AnySimulation::Single(self.bind_in(asked, flight)?),
            Precision::Double => AnySimulation::Double(self.bind_in(asked, flight)?),
        })
    }

    fn bind_in<T: Number>(&self, asked: Asked, flight: bool) -> PyResult<Simulation<T>> {
        let bytes = Shared(Arc::clone(&self.content));
        let mut one = Simulation::with_options(bytes, &asked.body(flight)).map_err(of_simulation)?;
        change(&mut one, asked.live.into_iter().map(|p| (p.name, p.value)).collect())?;
        Ok(one)
    }
}

#[pymethods]
impl PyFile {
    #[staticmethod]
    fn open(py: Python<'_>, path: PathBuf, map: bool) -> PyResult<Self> {
        let opened = py.detach(|| Content::open(&path, map));
        let content = Arc::new(opened.map_err(|refusal| of_missing(refusal, &path))?);
        Ok(Self { content, path })
    }

    #[staticmethod]
    fn from_bytes(py: Python<'_>, bytes: Vec<u8>, name: PathBuf) -> PyResult<Self> {
        let content = Arc::new(py.detach(|| Content::given(&name, bytes))?);
        Ok(Self { content, path: name })
    }

    #[getter]
    fn path(&self) -> PathBuf {
        self.path.clone()
    }

    fn bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, self.content.original())
    }

    fn info(&self, py: Python<'_>) -> PyResult<String> {
        Ok(py.detach(|| {
            contents_json(&self.path, self.content.original(), Limit::default()).map_err(Refusal::from)
        })?)
    }

    fn page(&self, py: Python<'_>) -> PyResult<String> {
        Ok(py.detach(|| {
            let file = self.content.file(&self.path)?;
            page(&self.path, &file).map_err(Refusal::from)
        })?)
    }

    fn geometry<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let geometry = Geometry::of(&self.content.file(&self.path)?).map_err(Refusal::from)?;
        let (nodes, triangles) = (geometry.nodes.len(), geometry.triangles.len());
        Ok((
            owned(py, geometry.nodes.into_flattened(), &[nodes, 3])?,
            owned(py, geometry.triangles.into_flattened(), &[triangles, 3])?,
        ))
    }

    /// Nodes, weights and triangles of the embedded surface; `None` where the file has none.
    #[expect(clippy::type_complexity, reason = "three arrays for Python")]
    fn embedded<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Option<(Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>)>> {
        let file = self.content.file(&self.path)?;
        let Some(surface) = EmbeddedSurface::new(&file).map_err(of_output)? else { return Ok(None) };
        let vertices: Vec<_> = (0..surface.n_vertices()).filter_map(|at| surface.vertex(at)).collect();
        let (nodes, weights): (Vec<_>, Vec<_>) = vertices.into_iter().unzip();
        let triangles: Vec<[u32; 3]> = surface.triangles().collect();
        let shapes = [[nodes.len(), 4], [triangles.len(), 3]];
        Ok(Some((
            owned(py, nodes.into_flattened(), &shapes[0])?,
            owned(py, weights.into_flattened(), &shapes[0])?,
            owned(py, triangles.into_flattened(), &shapes[1])?,
        )))
    }

    fn body(
        &self,
        dtype: &Bound<'_, PyAny>,
        flight: bool,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyBody> {
        let file = self.content.file(&self.path)?;
        let body = self.bind(dtype, asked(&file, options)?, flight)?;
        Ok(PyBody::new(body, Names::of(&file)?))
    }

    fn batch(
        &self,
        instances: Count,
        dtype: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyBatch> {
        let file = self.content.file(&self.path)?;
        // The state of an instance does not remember its forces.
        let mut asked = asked(&file, options)?;
        asked.scene.residual = false;
        let one = self.bind(dtype, asked, false)?;
        PyBatch::new(one, instances.0, Names::of(&file)?)
    }
}
