//! A vademecum file in memory.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use vademecum_cli::{Limit, contents_json, page};
use vademecum_eval::{SceneOptions, Simulation};
use vademecum_format::SectionKind;
use vademecum_study::contents::{Geometry, lines};

use crate::arrays::owned;
use crate::batch::{PyBatch, double, single};
use crate::body::{Body, Number};
use crate::content::{Content, Shared};
use crate::options::{Precision, scene_options};
use crate::refusal::{Refusal, of_simulation};
use crate::scene::PyScene;

/// A vademecum file in memory.
#[pyclass(frozen, name = "File", module = "vademecum._native")]
pub struct PyFile {
    pub content: Arc<Content>,
    pub path: PathBuf,
}

impl PyFile {
    /// Names of the probes, of the load patterns, and of the supports whose reactions the file gives.
    fn names(&self) -> Result<[Vec<String>; 3], Refusal> {
        let file = self.content.file(&self.path)?;
        let names = |kind| lines(&file, kind);
        let [probes, patterns, supports] =
            [SectionKind::ProbeNames, SectionKind::PatternNames, SectionKind::SupportNames].map(names);
        Ok([probes?, patterns?, supports?])
    }

    fn options(&self, given: Option<&Bound<'_, PyDict>>) -> PyResult<SceneOptions> {
        scene_options(self.content.file(&self.path)?.metadata(), given)
    }

    fn bind<T: Number>(&self, options: &SceneOptions) -> PyResult<Simulation<T>> {
        Simulation::new(Shared(Arc::clone(&self.content)), options).map_err(of_simulation)
    }
}

#[pymethods]
impl PyFile {
    #[staticmethod]
    fn open(py: Python<'_>, path: PathBuf, map: bool) -> PyResult<Self> {
        let content = Arc::new(py.detach(|| Content::open(&path, map))?);
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

    fn scene(&self, dtype: &Bound<'_, PyAny>, options: Option<&Bound<'_, PyDict>>) -> PyResult<PyScene> {
        let (precision, options) = (Precision::of(dtype)?, self.options(options)?);
        let [probes, patterns, supports] = self.names()?;
        let body: Box<dyn Body> = match precision {
            Precision::Single => Box::new(self.bind::<f32>(&options)?),
            Precision::Double => Box::new(self.bind::<f64>(&options)?),
        };
        Ok(PyScene::new(body, probes, patterns, supports))
    }

    fn batch(
        &self,
        instances: usize,
        dtype: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyBatch> {
        let precision = Precision::of(dtype)?;
        // The state of an instance does not remember its forces.
        let options = SceneOptions { residual: false, ..self.options(options)? };
        match precision {
            Precision::Single => single(self.bind(&options)?, instances, self.names()?),
            Precision::Double => double(self.bind(&options)?, instances, self.names()?),
        }
    }
}
