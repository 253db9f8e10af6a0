//! Parametric models: frequencies and histories with their derivatives, and tracking from sensors.

use std::sync::{Arc, Mutex, MutexGuard};

use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use self_cell::{MutBorrow, self_cell};
use vademecum_eval::{
    BodyOptions, Field, Parametric, ParametricError, Sensor, Simulation, Tangents, Tracked, Tracker,
    TrackerOptions, Tuned,
};
use vademecum_format::{File, Parameter};
use vademecum_study::StudyError;

use crate::arrays::owned;
use crate::content::{Content, Shared};
use crate::file::PyFile;
use crate::names::{Names, field};
use crate::options::keyword;
use crate::point::{Target, Vector, wrong};
use crate::refusal::{busy, of_parametric, of_simulation, of_study, unknown};

/// Values of parameters, by name.
pub type Values = Vec<(String, f64)>;
/// An array, and one for each parameter by its name.
type WithSlopes<'py> = (Bound<'py, PyAny>, Bound<'py, PyDict>);

/// The model of a file.
pub fn model<'a>(file: &File<'a>) -> PyResult<Parametric<'a>> {
    Parametric::new(file).map_err(of_parametric)
}

/// Number of the parameter that a name or a keyword means.
fn parameter(model: &Parametric<'_>, name: &str) -> PyResult<usize> {
    if let Some(index) = model.find(name) {
        return Ok(index);
    }
    let mut alike = model.parameters().enumerate().filter(|(_, own)| keyword(own.name) == name);
    match (alike.next(), alike.next()) {
        (Some((only, _)), None) => Ok(only),
        _ => {
            let known: Vec<String> = model.parameters().map(|own| own.name.to_string()).collect();
            Err(unknown("the file", "live parameter", name, &known))
        }
    }
}

/// Values of all parameters: those as built, and those given.
pub fn values(model: &Parametric<'_>, given: Values) -> PyResult<Vec<f64>> {
    let mut values = vec![0.0; model.n_parameters()];
    model.nominal_into(&mut values);
    for (name, value) in given {
        let index = parameter(model, &name)?;
        let set = model.set(&mut values, &[(index, value)]);
        if let (Err(_), Some(Parameter { name, lower, upper, .. })) = (set, model.parameters().nth(index)) {
            return Err(of_study(StudyError::OutsideRange { name: name.into(), value, lower, upper }));
        }
    }
    Ok(values)
}

/// Calls `work` with the modes at these values and with numbers of work.
fn tuned<R>(
    model: &Parametric<'_>,
    values: &[f64],
    modes: usize,
    work_len: usize,
    work: impl FnOnce(Tuned<'_>, &mut [f64]) -> Result<R, ParametricError>,
) -> Result<R, ParametricError> {
    let sizes = model.sizes(modes)?;
    let (mut memory, mut numbers) = (vec![0.0; sizes.memory], vec![0.0; sizes.work.max(work_len)]);
    let tuned = model.solve(values, modes, &mut memory, &mut numbers)?;
    work(tuned, &mut numbers)
}

fn by_name<'py>(
    py: Python<'py>,
    model: &Parametric<'_>,
    arrays: Vec<Vec<f64>>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    for (own, numbers) in model.parameters().zip(arrays) {
        all.set_item(own.name, owned(py, numbers, shape)?)?;
    }
    Ok(all)
}

/// Natural frequencies at values of the parameters, and their derivatives.
#[pyfunction]
pub fn sensitivities<'py>(
    py: Python<'py>,
    file: &PyFile,
    modes: Option<usize>,
    given: Values,
) -> PyResult<WithSlopes<'py>> {
    let opened = file.content.file(&file.path)?;
    let model = model(&opened)?;
    let (values, modes) = (values(&model, given)?, modes.unwrap_or(model.usual_modes()));
    let found = py.detach(|| {
        tuned(&model, &values, modes, model.slope_work(), |tuned, work| {
            let frequencies: Vec<f64> = (0..modes).map(|k| tuned.frequency(k)).collect();
            let slopes = |index| {
                let mut out = vec![0.0; modes];
                tuned.frequency_slopes(&model, index, &mut out, work).map(|()| out)
            };
            Ok((frequencies, (0..values.len()).map(slopes).collect::<Result<Vec<_>, _>>()?))
        })
    });
    let (frequencies, slopes) = found.map_err(of_parametric)?;
    Ok((owned(py, frequencies, &[modes])?, by_name(py, &model, slopes, &[modes])?))
}

/// A load of amplitude 1: a load pattern, or a force at a place.
#[derive(FromPyObject)]
pub enum UnitLoad {
    #[pyo3(annotation = "the name of a load pattern")]
    Pattern(String),
    #[pyo3(annotation = "a place and a force")]
    Force(Target, Vector),
}

/// Loads as rows over the basis, one after the other.
fn load_rows(file: &PyFile, model: &Parametric<'_>, loads: &[UnitLoad]) -> PyResult<Vec<f64>> {
    let r = model.n_basis();
    let mut rows = vec![0.0; r * loads.len()];
    let (mut body, names) = (None, Names::of(model.file())?);
    for (load, row) in loads.iter().zip(rows.chunks_exact_mut(r)) {
        match load {
            UnitLoad::Pattern(name) => {
                model.pattern_row(names.pattern(name)?, row).map_err(of_parametric)?;
            }
            UnitLoad::Force(place, Vector(force)) => {
                if body.is_none() {
                    let bytes = Shared(Arc::clone(&file.content));
                    let options = BodyOptions::default();
                    body = Some(Simulation::<f64>::with_options(bytes, &options).map_err(of_simulation)?);
                }
                let Some(body) = &body else { continue };
                let at = place.on(|point| body.locate(point))?;
                let mut of_node = vec![0.0; r];
                for (node, weight) in at.place.entries() {
                    let force = force.map(|x| weight * x);
                    model.node_row(node as usize, force, &mut of_node).map_err(of_parametric)?;
                    row.iter_mut().zip(&of_node).for_each(|(sum, x)| *sum += x);
                }
            }
        }
    }
    Ok(rows)
}

/// The sum of loads of these amplitudes.
fn sum_into(rows: &[f64], amplitudes: impl Iterator<Item = f64>, out: &mut [f64]) {
    out.fill(0.0);
    for (row, amplitude) in rows.chunks_exact(out.len().max(1)).zip(amplitudes) {
        out.iter_mut().zip(row).for_each(|(sum, x)| *sum += amplitude * x);
    }
}

/// Histories of the probes from rest, and their derivatives, shape (instants, probes).
#[pyfunction]
pub fn tangents<'py>(
    py: Python<'py>,
    file: &PyFile,
    loads: Vec<UnitLoad>,
    amplitudes: PyReadonlyArray2<'py, f64>,
    field: &str,
    modes: Option<usize>,
    given: Values,
) -> PyResult<WithSlopes<'py>> {
    let field = self::field(field)?;
    let opened = file.content.file(&file.path)?;
    let model = model(&opened)?;
    let (values, modes) = (values(&model, given)?, modes.unwrap_or(model.n_basis()));
    let &[instants, width] = amplitudes.shape() else {
        return Err(PyTypeError::new_err("amplitudes: expected the shape (instants, loads)"));
    };
    if width != loads.len() || instants == 0 {
        let words = format!(
            "amplitudes: expected the shape (instants, {}), found ({instants}, {width})",
            loads.len()
        );
        return Err(PyValueError::new_err(words));
    }
    let (rows, amplitudes) = (load_rows(file, &model, &loads)?, amplitudes.as_array().to_owned());
    let (r, probes) = (model.n_basis(), Names::of(&opened)?.probes.len());
    let mut of_probes = vec![0.0; r * probes];
    for (probe, row) in of_probes.chunks_exact_mut(r).enumerate() {
        model.probe_row(probe, row).map_err(of_parametric)?;
    }
    let found = py.detach(|| {
        let lent = model.tangent_sizes(modes);
        tuned(&model, &values, modes, lent.work, |tuned, work| {
            let mut memory = vec![0.0; lent.memory];
            let mut march = Tangents::new(&model, tuned, &mut memory, work)?;
            let (mut start, mut end) = (vec![0.0; r], vec![0.0; r]);
            let (mut history, mut slopes) = (vec![0.0; probes], vec![vec![0.0; probes]; values.len()]);
            for (instant, row) in amplitudes.rows().into_iter().enumerate() {
                start.copy_from_slice(&end);
                sum_into(&rows, row.iter().copied(), &mut end);
                if instant == 0 {
                    continue;
                }
                march.step(&start, &end);
                history.extend(of_probes.chunks_exact(r).map(|row| march.value(row, field)));
                for (index, slopes) in slopes.iter_mut().enumerate() {
                    slopes.extend(of_probes.chunks_exact(r).map(|row| march.slope(row, field, index)));
                }
            }
            Ok((history, slopes))
        })
    });
    let (history, slopes) = found.map_err(of_parametric)?;
    let shape = [instants, probes];
    Ok((owned(py, history, &shape)?, by_name(py, &model, slopes, &shape)?))
}

/// Borrowed memory of a tracker.
struct Lent {
    content: Arc<Content>,
    tracked: Vec<Tracked>,
    sensors: Vec<Sensor>,
    memory: MutBorrow<Vec<f64>>,
}

type AnyTracker<'l> = Tracker<'l, 'l, 'l>;

self_cell!(
    struct TrackerCell {
        owner: Lent,
        #[covariant]
        dependent: AnyTracker,
    }
);

/// A tracker with the loads of its steps.
struct Tracking {
    cell: TrackerCell,
    /// Loads over the basis.
    rows: Vec<f64>,
    start: Vec<f64>,
    end: Vec<f64>,
}

/// Settings of [`tracker`], by their names in Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct TrackerSettings {
    field: String,
    load_deviation: f64,
    resolve: f64,
    modes: Option<usize>,
}

/// Follows live parameters of a parametric model while it moves: an extended Kalman filter over the modal
/// motion and the parameters. `File.tracker` makes one, at rest. It belongs to one thread at a time.
#[pyclass(frozen, name = "Tracker", module = "vademecum")]
pub struct PyTracker {
    tracking: Mutex<Tracking>,
    parameters: Vec<String>,
    /// Numbers of the tracked parameters.
    tracked: Vec<usize>,
    sensors: usize,
    loads: usize,
}

/// A tracker of a file.
#[pyfunction]
pub fn tracker(
    file: &PyFile,
    sensors: Values,
    tracked: Vec<(String, (f64, f64))>,
    loads: Vec<UnitLoad>,
    settings: TrackerSettings,
    given: Values,
) -> PyResult<PyTracker> {
    let TrackerSettings { field, load_deviation, resolve, modes } = settings;
    let field: Field = self::field(&field)?;
    let opened = file.content.file(&file.path)?;
    let (model, names) = (model(&opened)?, Names::of(&opened)?);
    let values = values(&model, given)?;
    let above = |what: &str, value: f64| {
        let words = || PyValueError::new_err(format!("{what} is {value}; expected a finite number from 0"));
        if value >= 0.0 && value.is_finite() { Ok(value) } else { Err(words()) }
    };
    let sensor = |(name, deviation): &(String, f64)| {
        let probe = names.probe(name)?;
        Ok(Sensor { probe, field, deviation: above("the deviation of a sensor", *deviation)? })
    };
    let sensors = sensors.iter().map(sensor).collect::<PyResult<Vec<_>>>()?;
    let tracked_one = |(name, (deviation, drift)): &(String, (f64, f64))| {
        Ok(Tracked {
            parameter: parameter(&model, name)?,
            deviation: above("a deviation", *deviation)?,
            drift: above("a drift", *drift)?,
        })
    };
    let tracked = tracked.iter().map(tracked_one).collect::<PyResult<Vec<_>>>()?;
    let modes = modes.unwrap_or(model.usual_modes());
    let (load_deviation, resolve) = (above("load_deviation", load_deviation)?, above("resolve", resolve)?);
    let options = TrackerOptions { modes, tracked: &tracked, sensors: &sensors, load_deviation, resolve };
    let memory = vec![0.0; model.tracker_len(&options).map_err(of_parametric)?];
    let (rows, r) = (load_rows(file, &model, &loads)?, model.n_basis());
    let (sensor_count, load_count) = (sensors.len(), loads.len());
    let parameters = model.parameters().map(|own| own.name.to_string()).collect();
    let indices = tracked.iter().map(|own| own.parameter).collect();
    let lent = Lent { content: Arc::clone(&file.content), tracked, sensors, memory: MutBorrow::new(memory) };
    let cell = TrackerCell::try_new(lent, |lent| {
        let opened = lent.content.file(&file.path)?;
        let (tracked, sensors) = (&lent.tracked, &lent.sensors);
        let options = TrackerOptions { modes, tracked, sensors, load_deviation, resolve };
        Tracker::new(&self::model(&opened)?, &options, &values, lent.memory.borrow_mut())
            .map_err(of_parametric)
    })?;
    let tracking = Tracking { cell, rows, start: vec![0.0; r], end: vec![0.0; r] };
    Ok(PyTracker {
        tracking: Mutex::new(tracking),
        parameters,
        tracked: indices,
        sensors: sensor_count,
        loads: load_count,
    })
}

impl PyTracker {
    fn lock(&self) -> PyResult<MutexGuard<'_, Tracking>> {
        self.tracking.try_lock().map_err(|_| busy("tracker"))
    }

    /// A number of each tracked parameter, from its place and its number.
    fn of_tracked<'py>(
        &self,
        py: Python<'py>,
        number: impl Fn(&AnyTracker<'_>, usize, usize) -> f64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (tracking, all) = (self.lock()?, PyDict::new(py));
        let tracker = tracking.cell.borrow_dependent();
        for (place, &index) in self.tracked.iter().enumerate() {
            all.set_item(&self.parameters[index], number(tracker, place, index))?;
        }
        Ok(all)
    }
}

/// So many numbers.
fn numbers(given: &Bound<'_, PyAny>, what: &str, count: usize) -> PyResult<Vec<f64>> {
    let expected = format!("{count} {what}");
    let numbers: Vec<f64> =
        given.extract().map_err(|error| wrong(&given.as_borrowed(), &expected, &error))?;
    if numbers.len() != count {
        return Err(PyValueError::new_err(format!("expected {expected}, found {}", numbers.len())));
    }
    Ok(numbers)
}

#[pymethods]
impl PyTracker {
    /// Takes a step: the amplitudes of the loads at its end, to which they change linearly from those of the
    /// step before (0 at first), and the measured number of each sensor at its end. A number that is not
    /// finite is left out.
    fn step(
        &self,
        py: Python<'_>,
        amplitudes: &Bound<'_, PyAny>,
        measured: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let amplitudes = numbers(amplitudes, "amplitudes, one for each load", self.loads)?;
        let measured = numbers(measured, "measured numbers, one for each sensor", self.sensors)?;
        if !amplitudes.iter().all(|x| x.is_finite()) {
            return Err(PyValueError::new_err("an amplitude is not finite"));
        }
        let mut tracking = self.lock()?;
        let Tracking { cell, rows, start, end } = &mut *tracking;
        py.detach(|| {
            std::mem::swap(start, end);
            sum_into(rows, amplitudes.into_iter(), end);
            cell.with_dependent_mut(|_, tracker| tracker.step(start, end, &measured))
        })
        .map_err(of_parametric)
    }

    /// Estimates of the tracked parameters, by name.
    #[getter]
    fn estimates<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.of_tracked(py, |tracker, _, index| tracker.values().get(index).copied().unwrap_or(f64::NAN))
    }

    /// Standard deviations of the estimates, by name: relative where the range of the parameter lies above 0,
    /// and else in its unit.
    #[getter]
    fn deviations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.of_tracked(py, |tracker, place, _| tracker.deviation(place))
    }

    /// Takes the mean square of the innovations over their variances since the last call: near 1 where model,
    /// noise and drift are what they are said to be; `None` before anything was measured.
    fn take_consistency(&self) -> PyResult<Option<f64>> {
        Ok(self.lock()?.cell.with_dependent_mut(|_, tracker| tracker.take_consistency()))
    }

    fn __repr__(&self) -> String {
        let names = self.tracked.iter().map(|&index| format!("`{}`", self.parameters[index]));
        let names = names.collect::<Vec<_>>().join(", ");
        format!("<Tracker of {names} from {} sensors and {} loads>", self.sensors, self.loads)
    }
}
