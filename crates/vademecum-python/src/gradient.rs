//! Marches that are kept, and by how much a scalar of their outputs changes with all that they depend on.

use std::sync::{Arc, Mutex, MutexGuard};

use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use self_cell::{MutBorrow, self_cell};
use vademecum_eval::{
    Body, BodyOptions, CheckpointedMarch, Field, MarchRows, Parametric, Place, Scene, SceneOptions,
    Simulation, StructureChoice, SurfacePoint, gradient_on_triangle,
};
use vademecum_format::{File, SectionKind};

use crate::arrays::owned;
use crate::content::{Content, Shared};
use crate::file::PyFile;
use crate::live::{UnitLoad, Values, model, values};
use crate::names::{Names, field};
use crate::refusal::{busy, of_adjoint, of_bind, of_load, of_output, of_parametric, of_simulation, unknown};

/// Parameters of a file without live regions, in the order of their gradients.
const UNIFORM: [&str; 5] = ["stiffness", "density", "alpha", "beta", "time_step"];

/// Modes of a scene in double precision, at these values of what is uniform.
fn scene_options(given: &Values) -> PyResult<SceneOptions> {
    let mut options = SceneOptions { structure: StructureChoice::Exact, ..SceneOptions::default() };
    for (name, value) in given {
        match name.as_str() {
            "stiffness" => options.stiffness = *value,
            "density" => options.density = *value,
            "alpha" => options.alpha = Some(*value),
            "beta" => options.beta = Some(*value),
            "time_step" => options.time_step = Some(*value),
            name => {
                let known = UNIFORM.map(String::from);
                return Err(unknown("a file without live regions", "parameter", name, &known));
            }
        }
    }
    Ok(options)
}

/// Source of the rows of outputs and loads.
enum Rows<'r> {
    Model(&'r Parametric<'r>),
    Scene(&'r Scene<'r, f64>),
}

impl Rows<'_> {
    fn width(&self) -> usize {
        match self {
            Self::Model(model) => model.n_basis(),
            Self::Scene(scene) => scene.n_modes(),
        }
    }

    fn probe(&self, probe: usize, out: &mut [f64]) -> PyResult<()> {
        match self {
            Self::Model(model) => model.probe_row(probe, out).map_err(of_parametric),
            Self::Scene(scene) => scene.probe_row_into(probe, out).map_err(of_output),
        }
    }

    fn pattern(&self, pattern: usize, out: &mut [f64]) -> PyResult<()> {
        match self {
            Self::Model(model) => model.pattern_row(pattern, out).map_err(of_parametric),
            Self::Scene(scene) => scene.pattern_row_into(pattern, out).map_err(of_load),
        }
    }

    fn node(&self, node: usize, force: [f64; 3], out: &mut [f64]) -> PyResult<()> {
        match self {
            Self::Model(model) => model.node_row(node, force, out).map_err(of_parametric),
            Self::Scene(scene) => scene.node_row_into(node, force, out).map_err(of_output),
        }
    }
}

/// A force at a place: what its gradient is made of.
struct Force {
    place: Place,
    force: [f64; 3],
    /// Rows of each component at each node of the place.
    rows: Vec<f64>,
    /// Positions of the nodes of a triangle.
    corners: Option<[[f64; 3]; 3]>,
}

/// Rows of the outputs and loads of a march.
struct Asked {
    outputs: Vec<f64>,
    fields: Vec<Field>,
    loads: Vec<f64>,
    forces: Vec<Option<Force>>,
}

impl Asked {
    fn rows(&self, steps: usize) -> MarchRows<'_> {
        MarchRows { outputs: &self.outputs, fields: &self.fields, loads: &self.loads, steps }
    }

    fn of(file: &PyFile, rows: &Rows<'_>, names: &Names, loads: &[UnitLoad], field: Field) -> PyResult<Self> {
        let (width, probes) = (rows.width(), names.probes.len());
        let (outputs, fields) = (vec![0.0; width * probes], vec![field; probes]);
        let mut asked = Self { outputs, fields, loads: vec![], forces: vec![] };
        for (probe, row) in asked.outputs.chunks_exact_mut(width.max(1)).enumerate() {
            rows.probe(probe, row)?;
        }
        let mut body = None;
        for load in loads {
            let mut row = vec![0.0; width];
            let force = match load {
                UnitLoad::Pattern(name) => {
                    rows.pattern(names.pattern(name)?, &mut row)?;
                    None
                }
                UnitLoad::Force(place, force) => {
                    if body.is_none() {
                        let bytes = Shared(Arc::clone(&file.content));
                        let options = BodyOptions::default();
                        body = Some(Simulation::<f64>::with_options(bytes, &options).map_err(of_simulation)?);
                    }
                    let Some(body) = &body else { continue };
                    let at: SurfacePoint = place.on(|point| body.locate(point))?;
                    Some(Force::of(rows, body, at.place, force.0, &mut row)?)
                }
            };
            asked.loads.append(&mut row);
            asked.forces.push(force);
        }
        Ok(asked)
    }
}

impl Force {
    fn of(
        rows: &Rows<'_>,
        body: &Simulation<f64>,
        place: Place,
        force: [f64; 3],
        sum: &mut [f64],
    ) -> PyResult<Self> {
        let mut own = vec![];
        for (node, weight) in place.entries() {
            for component in 0..3 {
                let (mut row, mut unit) = (vec![0.0; sum.len()], [0.0; 3]);
                unit[component] = 1.0;
                rows.node(node as usize, unit, &mut row)?;
                sum.iter_mut().zip(&row).for_each(|(sum, x)| *sum += weight * force[component] * x);
                own.append(&mut row);
            }
        }
        let position = |node: &u32| body.body().position(&Place::node(*node)).ok();
        let corners: Option<Vec<_>> = place.nodes().iter().map(position).collect();
        let corners = corners.and_then(|corners| <[[f64; 3]; 3]>::try_from(corners).ok());
        Ok(Self { place, force, rows: own, corners })
    }

    /// Gradients with respect to the force, and to its place along the surface.
    fn gradient(&self, march: &CheckpointedMarch<'_, '_>, load: usize) -> PyResult<[[f64; 3]; 2]> {
        let width = self.rows.len() / (3 * self.place.nodes().len()).max(1);
        let mut rows = self.rows.chunks_exact(width.max(1));
        let (mut of_force, mut of_weights) = ([0.0; 3], vec![]);
        for (_, weight) in self.place.entries() {
            let mut of_weight = 0.0;
            for component in 0..3 {
                let row = rows.next().unwrap_or_default();
                let own = march.of_load_row(load, row).map_err(of_adjoint)?;
                of_force[component] += weight * own;
                of_weight += self.force[component] * own;
            }
            of_weights.push(of_weight);
        }
        let of_weights = <[f64; 3]>::try_from(of_weights).ok();
        let of_place = self.corners.zip(of_weights);
        // Elsewhere than on triangles a place has no gradient.
        let of_place = of_place.map_or([f64::NAN; 3], |(corners, own)| gradient_on_triangle(&corners, &own));
        Ok([of_force, of_place])
    }
}

/// Memory and rows that a kept march borrows.
struct Lent {
    content: Arc<Content>,
    asked: Asked,
    modes: MutBorrow<Vec<f64>>,
    memory: MutBorrow<Vec<f64>>,
}

type AnyMarch<'l> = CheckpointedMarch<'l, 'l>;

self_cell!(
    struct MarchCell {
        owner: Lent,
        #[not_covariant]
        dependent: AnyMarch,
    }
);

struct Kept {
    cell: MarchCell,
    /// Amplitudes, shape (steps, 2, loads).
    amplitudes: Vec<f64>,
    work: Vec<f64>,
}

/// A march that is kept, for its gradients. `File.vjp` makes one. It belongs to one thread at a time.
#[pyclass(frozen, name = "KeptMarch", module = "vademecum")]
pub struct PyKeptMarch {
    kept: Mutex<Kept>,
    values: Vec<f64>,
    parameters: Vec<String>,
    /// Steps, probes, loads, modes.
    shape: [usize; 4],
    /// Loads are held over each step.
    held: bool,
}

/// Settings of [`vjp`], by their names in Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct MarchSettings {
    field: String,
    held: bool,
    modes: Option<usize>,
    start: Option<(Vec<f64>, Vec<f64>)>,
}

/// Amplitudes as those at the start and at the end of each step.
fn of_steps(given: &PyReadonlyArray2<'_, f64>, loads: usize, held: bool) -> PyResult<(usize, Vec<f64>)> {
    let (rows, width) = (given.shape()[0], given.shape()[1]);
    if width != loads || (rows == 0 && !held) {
        let what = if held { "steps" } else { "instants" };
        let words = format!("amplitudes: expected the shape ({what}, {loads}), found ({rows}, {width})");
        return Err(PyValueError::new_err(words));
    }
    let given = given.as_array();
    let steps = if held { rows } else { rows - 1 };
    let mut all = Vec::with_capacity(2 * steps * loads);
    for step in 0..steps {
        all.extend(given.row(step).iter());
        all.extend(given.row(if held { step } else { step + 1 }).iter());
    }
    Ok((steps, all))
}

/// The march of a file with live regions at values of its parameters, or of the modes of any other.
fn march_of<'l>(
    file: &File<'l>,
    lent: &'l Lent,
    (given, modes): (&Values, usize),
    steps: usize,
) -> PyResult<AnyMarch<'l>> {
    let rows = lent.asked.rows(steps);
    let memory = lent.memory.borrow_mut();
    if file.section(SectionKind::LiveParameters).is_some() {
        let model = model(file)?;
        let sizes = model.sizes(modes).map_err(of_parametric)?;
        let mut work = vec![0.0; sizes.work];
        let lent_modes = lent.modes.borrow_mut();
        lent_modes.resize(sizes.memory, 0.0);
        let values = values(&model, given.clone())?;
        let tuned = model.solve(&values, modes, lent_modes, &mut work).map_err(of_parametric)?;
        memory.resize(model.adjoint_sizes(modes, &rows).map_err(of_adjoint)?.memory, 0.0);
        return CheckpointedMarch::new(&model, tuned, &rows, memory).map_err(of_adjoint);
    }
    with_scene(file, given, |scene| {
        memory.resize(scene.march_sizes(&rows).map_err(of_adjoint)?.memory, 0.0);
        CheckpointedMarch::of_scene(scene, &rows, memory).map_err(of_adjoint)
    })
}

/// The scene of a body of a file in double precision.
fn with_scene<R>(
    file: &File<'_>,
    given: &Values,
    work: impl FnOnce(&Scene<'_, f64>) -> PyResult<R>,
) -> PyResult<R> {
    let options = BodyOptions { scene: scene_options(given)?, ..BodyOptions::default() };
    let mut memory = vec![0.0; Body::<f64>::len_for(file, &options).map_err(of_bind)?];
    work(Body::bind(file, &options, &mut memory).map_err(of_bind)?.scene())
}

/// A march that is kept.
#[pyfunction]
pub fn vjp(
    py: Python<'_>,
    file: &PyFile,
    loads: Vec<UnitLoad>,
    amplitudes: PyReadonlyArray2<'_, f64>,
    settings: MarchSettings,
    given: Values,
) -> PyResult<PyKeptMarch> {
    let MarchSettings { field, held, modes, start } = settings;
    let field = self::field(&field)?;
    let opened = file.content.file(&file.path)?;
    let names = Names::of(&opened)?;
    let (steps, amplitudes) = of_steps(&amplitudes, loads.len(), held)?;
    let probes = names.probes.len();
    let is_live = opened.section(SectionKind::LiveParameters).is_some();
    let (asked, modes, parameters, work) = if is_live {
        let model = model(&opened)?;
        let modes = modes.unwrap_or(model.n_basis());
        let asked = Asked::of(file, &Rows::Model(&model), &names, &loads, field)?;
        let parameters = model.parameters().map(|own| own.name.to_string()).collect();
        let sizes = model.adjoint_sizes(modes, &asked.rows(0)).map_err(of_adjoint)?;
        (asked, modes, parameters, sizes.work)
    } else {
        if modes.is_some() {
            return Err(PyValueError::new_err("modes are chosen of files with live regions alone"));
        }
        let asked =
            with_scene(&opened, &given, |scene| Asked::of(file, &Rows::Scene(scene), &names, &loads, field))?;
        let modes = opened.metadata().n_modes as usize;
        (asked, modes, UNIFORM.map(String::from).to_vec(), 0)
    };
    let lent = Lent {
        content: Arc::clone(&file.content),
        asked,
        modes: MutBorrow::new(vec![]),
        memory: MutBorrow::new(vec![]),
    };
    let mut cell = MarchCell::try_new(lent, |lent| {
        march_of(&lent.content.file(&file.path)?, lent, (&given, modes), steps)
    })?;
    let mut values = vec![0.0; steps * probes];
    let start = start.unwrap_or_default();
    py.detach(|| {
        cell.with_dependent_mut(|_, march| march.march([&start.0, &start.1], &amplitudes, &mut values))
    })
    .map_err(of_adjoint)?;
    let kept = Mutex::new(Kept { cell, amplitudes, work: vec![0.0; work] });
    Ok(PyKeptMarch { kept, values, parameters, shape: [steps, probes, loads.len(), modes], held })
}

impl PyKeptMarch {
    fn lock(&self) -> PyResult<MutexGuard<'_, Kept>> {
        self.kept.try_lock().map_err(|_| busy("march"))
    }
}

#[pymethods]
impl PyKeptMarch {
    /// The probes after each step, shape (steps, probes).
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        owned(py, self.values.clone(), &self.shape[..2])
    }

    /// Computes the gradient of a scalar whose derivatives with respect to `values` are these cotangents, of
    /// the same shape.
    fn gradient<'py>(
        &self,
        py: Python<'py>,
        cotangents: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let [steps, probes, loads, modes] = self.shape;
        if cotangents.shape() != [steps, probes] {
            let (rows, columns) = (cotangents.shape()[0], cotangents.shape()[1]);
            let words =
                format!("cotangents: expected the shape ({steps}, {probes}), found ({rows}, {columns})");
            return Err(PyValueError::new_err(words));
        }
        let cotangents: Vec<f64> = cotangents.as_array().iter().copied().collect();
        let mut kept = self.lock()?;
        let Kept { cell, amplitudes, work } = &mut *kept;
        let mut of_amplitudes = vec![0.0; amplitudes.len()];
        let mut of_parameters = vec![0.0; self.parameters.len()];
        let (mut zeta, mut velocity) = (vec![0.0; modes], vec![0.0; modes]);
        py.detach(|| {
            cell.with_dependent_mut(|_, march| {
                march.back(amplitudes, &cotangents, &mut of_amplitudes)?;
                march.parameters_into(&mut of_parameters, work)?;
                march.initial_into(&mut zeta, &mut velocity)
            })
        })
        .map_err(of_adjoint)?;
        let (mut forces, mut places) = (vec![f64::NAN; 3 * loads], vec![f64::NAN; 3 * loads]);
        cell.with_dependent(|lent, march| {
            let outs = forces.chunks_exact_mut(3).zip(places.chunks_exact_mut(3));
            for (load, (force, (of_force, of_place))) in lent.asked.forces.iter().zip(outs).enumerate() {
                if let Some(force) = force {
                    let [own_force, own_place] = force.gradient(march, load)?;
                    of_force.copy_from_slice(&own_force);
                    of_place.copy_from_slice(&own_place);
                }
            }
            Ok::<(), PyErr>(())
        })?;
        let rows = if self.held { steps } else { steps + 1 };
        let mut summed = vec![0.0; rows * loads];
        for (place, value) in of_amplitudes.into_iter().enumerate() {
            let (step, at_end, load) = (place / (2 * loads), place / loads % 2 == 1, place % loads);
            summed[(step + usize::from(at_end && !self.held)) * loads + load] += value;
        }
        let parameters = PyDict::new(py);
        for (name, value) in self.parameters.iter().zip(of_parameters) {
            parameters.set_item(name, value)?;
        }
        let class = py.import("vademecum._data")?.getattr("Gradient")?;
        class.call1((
            owned(py, summed, &[rows, loads])?,
            parameters,
            owned(py, forces, &[loads, 3])?,
            owned(py, places, &[loads, 3])?,
            owned(py, zeta, &[modes])?,
            owned(py, velocity, &[modes])?,
        ))
    }

    fn __repr__(&self) -> String {
        let [steps, probes, loads, modes] = self.shape;
        format!("<KeptMarch of {steps} steps, {probes} probes, {loads} loads and {modes} modes>")
    }
}
