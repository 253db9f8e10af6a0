//! A body that moves.

use std::borrow::Cow;
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use vademecum_eval::{
    BaseMotion, Field, FreeBody, Quantity, Restored, Simulation, Status, StepError, Structure, SurfacePoint,
};

use crate::adjoint;
use crate::arrays::{filled, owned};
use crate::motion::PyMotion;
use crate::names::{Names, field};
use crate::options::pairs;
use crate::point::{Count, PyPoint, Target, Vector};
use crate::refusal::{busy, of_adjoint, of_load, of_locate, of_output, of_saved, of_step};
use crate::simulation::{
    AnySimulation, Number, Out, change, either, quantities, quantity, shown, surface, values, whole,
};

/// Longest wait of Python's signals.
const PATIENCE: Duration = Duration::from_millis(50);
/// Steps between two looks at the clock.
const BLOCK: usize = 64;

/// A body that moves, bound to live parameters, with its loads. It belongs to one thread at a time.
///
/// A body without supports flies: `step` moves its frame, too. Its forces are those of space and act in the
/// coming step only. On any other body, loads stay until `clear`.
///
/// Methods with `out` write into that array, which has the right shape and type and is C-contiguous; a row of
/// a larger array will do. Without `out` they make a new array. Nothing is copied either way. `field` is
/// "displacement" in m or "velocity" in m/s.
#[pyclass(frozen, name = "Body", module = "vademecum")]
pub struct PyBody {
    moving: Mutex<AnySimulation>,
    names: Names,
}

impl PyBody {
    pub fn new(moving: AnySimulation, names: Names) -> Self {
        Self { moving: Mutex::new(moving), names }
    }

    /// The simulation, unless another thread has it. Waiting here could last for ever: this thread holds
    /// Python.
    fn lock(&self) -> PyResult<MutexGuard<'_, AnySimulation>> {
        self.moving.try_lock().map_err(|_| busy("body"))
    }

    /// A quantity at each point of the file that has a stress.
    fn at_stress_points<'py>(&self, py: Python<'py>, quantity: Quantity) -> PyResult<Bound<'py, PyAny>> {
        let (count, length, numbers) = either!(&*self.lock()?, AnySimulation, one => {
            let body = one.body();
            let (count, length) = (body.count(Quantity::Stress), body.length(quantity));
            let mut numbers = vec![0.0; count * length];
            for (point, out) in numbers.chunks_exact_mut(length).enumerate() {
                body.read(quantity, point, Field::Displacement, out).map_err(of_output)?;
            }
            (count, length, numbers)
        });
        let shape = [count, length];
        owned(py, numbers, if length == 1 { &shape[..1] } else { &shape })
    }

    /// Runs `work` for so many steps in pieces, without Python, and lets Python's signals in between.
    fn in_pieces(
        &self,
        py: Python<'_>,
        steps: usize,
        mut work: impl FnMut(&mut AnySimulation, usize) -> Result<Status, StepError> + Send,
    ) -> PyResult<Status> {
        let mut guard = self.lock()?;
        let moving: &mut AnySimulation = &mut guard;
        let (mut left, mut status) = (steps, Status::Moving);
        while left > 0 {
            let done = py.detach(|| {
                let (started, before) = (Instant::now(), left);
                while left > 0 {
                    let piece = left.min(BLOCK);
                    status = work(moving, piece)?;
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
}

/// The flight of a body.
fn flight<T: Number>(one: &Simulation<T>) -> PyResult<&FreeBody> {
    one.body().flight().ok_or_else(|| {
        PyValueError::new_err(if one.body().rigid_body().is_some() {
            "the body was bound with `flight=False`, so it has no rigid motion"
        } else {
            "the body has supports, so it has no rigid motion; build it without `support`"
        })
    })
}

/// The places that are meant.
fn places<T: Number>(one: &Simulation<T>, given: &[Target]) -> PyResult<Vec<SurfacePoint>> {
    given.iter().map(|place| place.on(|at| one.locate(at))).collect()
}

/// Three numbers as an array.
fn triple<'py>((py, out): Out<'_, 'py>, numbers: [f64; 3]) -> PyResult<Bound<'py, PyAny>> {
    filled::<f64>(py, &[3], out, |slice| {
        slice.copy_from_slice(&numbers);
        Ok(())
    })
}

#[pymethods]
impl PyBody {
    /// Precision of the step.
    #[getter]
    fn dtype<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let dtype = match &*self.lock()? {
            AnySimulation::Single(_) => numpy::dtype::<f32>(py),
            AnySimulation::Double(_) => numpy::dtype::<f64>(py),
        };
        Ok(dtype.into_any())
    }

    /// Structure of the step: "diagonal", "block", "exact" or "strain".
    #[getter]
    fn structure(&self) -> PyResult<&'static str> {
        Ok(match either!(&*self.lock()?, AnySimulation, one => one.body().structure()) {
            Structure::Diagonal => "diagonal",
            Structure::Block => "block",
            Structure::Exact => "exact",
            Structure::Strain => "strain",
        })
    }

    /// Length of a step in s.
    #[getter]
    fn time_step(&self) -> PyResult<f64> {
        Ok(either!(&*self.lock()?, AnySimulation, one => one.body().time_step()))
    }

    /// Number of modes.
    #[getter]
    fn modes(&self) -> PyResult<u32> {
        Ok(either!(&*self.lock()?, AnySimulation, one => one.file().metadata().n_modes))
    }

    /// Names of the probes of the file.
    #[getter]
    fn probe_names(&self) -> Vec<String> {
        self.names.probes.clone()
    }

    /// Names of the load patterns of the file.
    #[getter]
    fn pattern_names(&self) -> Vec<String> {
        self.names.patterns.clone()
    }

    /// Names of the supports whose reactions the file gives.
    #[getter]
    fn support_names(&self) -> Vec<String> {
        self.names.supports.clone()
    }

    /// Values of the live parameters, by name.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        either!(&*self.lock()?, AnySimulation, one => values(py, one))
    }

    /// Quantities that `read` gives of this body, by name.
    #[getter]
    fn quantities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        either!(&*self.lock()?, AnySimulation, one => quantities(py, one))
    }

    /// Sets live parameters while the body moves: displacement, velocity and loads stay. All of them are set,
    /// or none if one is refused. A parameter whose name is no keyword is given with `_` for every other
    /// sign, or in a mapping.
    #[pyo3(signature = (values=None, /, **parameters))]
    fn set_parameters(
        &self,
        values: Option<&Bound<'_, PyDict>>,
        parameters: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let given = pairs(values, parameters)?;
        either!(&mut *self.lock()?, AnySimulation, one => change(one, given))
    }

    /// Energies in J of the last change of live parameters of a file with live regions: kinetic and elastic
    /// energy that the stepped modes do not hold, and the work of the change; `None` of any other file.
    #[getter]
    fn carried(&self) -> PyResult<Option<(f64, f64, f64)>> {
        let carried = either!(&*self.lock()?, AnySimulation, one => one.carried());
        Ok(carried.map(|energies| (energies.lost_kinetic, energies.lost_elastic, energies.work)))
    }

    /// Finds the nearest point of the loadable surface at rest. A point further away than the body is large
    /// is refused.
    fn locate(&self, point: Vector) -> PyResult<PyPoint> {
        let moving = self.lock()?;
        either!(&*moving, AnySimulation, one => one.locate(point.0)).map(PyPoint).map_err(of_locate)
    }

    /// Finds the first point that a ray meets on the surface as it has moved, magnified by `scale`.
    #[pyo3(signature = (origin, direction, scale=1.0))]
    fn pick(&self, origin: Vector, direction: Vector, scale: f64) -> PyResult<Option<PyPoint>> {
        let mut moving = self.lock()?;
        Ok(either!(&mut *moving, AnySimulation, one => one.pick(origin.0, direction.0, scale)).map(PyPoint))
    }

    /// Adds a force in N at a place, or at the point of the surface nearest to a point in space. Forces add
    /// up.
    fn push(&self, place: Target, force: Vector) -> PyResult<PyPoint> {
        either!(&mut *self.lock()?, AnySimulation, one => {
            let at = place.on(|point| one.locate(point))?;
            one.push(&at, force.0).map_err(of_load)?;
            Ok(PyPoint(at))
        })
    }

    /// Adds a load pattern of the file, times an amplitude. On a body that flies it turns with the body.
    #[pyo3(signature = (name, amplitude=1.0))]
    fn push_pattern(&self, name: &str, amplitude: f64) -> PyResult<()> {
        let index = self.names.pattern(name)?;
        either!(&mut *self.lock()?, AnySimulation, one => one.push_pattern(index, amplitude)).map_err(of_load)
    }

    /// Adds the inertia of a base that moves so, in its own axes: m/s2, rad/s and rad/s2.
    #[pyo3(
        signature = (
            acceleration=Vector::ZERO,
            angular_velocity=Vector::ZERO,
            angular_acceleration=Vector::ZERO,
        ),
        text_signature = "($self, acceleration=(0.0, 0.0, 0.0), angular_velocity=(0.0, 0.0, 0.0), \
                          angular_acceleration=(0.0, 0.0, 0.0))"
    )]
    fn push_base(
        &self,
        acceleration: Vector,
        angular_velocity: Vector,
        angular_acceleration: Vector,
    ) -> PyResult<()> {
        let motion = BaseMotion {
            acceleration: acceleration.0,
            angular_velocity: angular_velocity.0,
            angular_acceleration: angular_acceleration.0,
        };
        either!(&mut *self.lock()?, AnySimulation, one => one.push_base(motion)).map_err(of_load)
    }

    /// Adds a force in N at the centre of a body that flies: gravity is the mass times its acceleration.
    fn pull(&self, force: Vector) -> PyResult<()> {
        either!(&mut *self.lock()?, AnySimulation, one => {
            flight(one)?;
            one.pull(force.0).map_err(of_load)
        })
    }

    /// Takes all loads away.
    fn clear(&self) -> PyResult<()> {
        either!(&mut *self.lock()?, AnySimulation, one => one.clear());
        Ok(())
    }

    /// Puts the body at rest where the file has it. Loads stay, and the next step is a first one.
    fn rest(&self) -> PyResult<()> {
        either!(&mut *self.lock()?, AnySimulation, one => one.rest());
        Ok(())
    }

    /// Moves on by so many steps, while other threads of Python run. Gives `False` once the body rests.
    #[pyo3(signature = (steps=Count(1)), text_signature = "($self, steps=1)")]
    fn step(&self, py: Python<'_>, steps: Count) -> PyResult<bool> {
        let step = |moving: &mut AnySimulation, piece| either!(moving, AnySimulation, one => one.step(piece));
        Ok(self.in_pieces(py, steps.0, step)? == Status::Moving)
    }

    /// Steps, with a row of all probes after each `every` steps: shape (steps // every, probes).
    #[pyo3(
        signature = (steps, every=Count(1), field="displacement"),
        text_signature = "($self, steps, every=1, field='displacement')"
    )]
    fn march<'py>(
        &self,
        py: Python<'py>,
        steps: Count,
        every: Count,
        field: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (Count(steps), Count(every)) = (steps, every);
        if every == 0 {
            return Err(PyValueError::new_err("every is 0; expected a number of steps from 1"));
        }
        let (field, n) = (self::field(field)?, self.names.probes.len());
        let rows = steps / every;
        let too_many = || PyValueError::new_err(format!("{rows} rows of {n} probes do not fit into memory"));
        let mut table: Vec<f64> = vec![];
        table.try_reserve_exact(rows.checked_mul(n).ok_or_else(too_many)?).map_err(|_| too_many())?;
        // Found before anything moves, so that a row can be read once a step is done.
        either!(&*self.lock()?, AnySimulation, one => {
            (0..n).try_for_each(|probe| one.probe(probe, field).map(drop))
        })
        .map_err(of_output)?;
        let mut done = 0;
        self.in_pieces(py, steps, |moving, piece| {
            either!(moving, AnySimulation, one => {
                let mut status = Status::Moving;
                for _ in 0..piece {
                    status = one.step(1)?;
                    done += 1;
                    if done % every == 0 {
                        table.extend((0..n).map(|probe| one.probe(probe, field).unwrap_or(f64::NAN)));
                    }
                }
                Ok(status)
            })
        })?;
        owned(py, table, &[rows, n])
    }

    /// Reads any quantity of `quantities`: a number, or an array of float64. `index` counts from 0; probes
    /// and supports go by their names, too, and "point" by a place.
    #[pyo3(signature = (quantity, index=None, field="displacement"))]
    fn read<'py>(
        &self,
        py: Python<'py>,
        quantity: &str,
        index: Option<&Bound<'py, PyAny>>,
        field: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (quantity, field) = (self::quantity(quantity)?, self::field(field)?);
        let numbers = either!(&*self.lock()?, AnySimulation, one => {
            let body = one.body();
            let mut numbers = vec![0.0; body.length(quantity)];
            match index {
                Some(place) if quantity == Quantity::Point => {
                    let place = place.extract::<Target>()?.on(|point| body.locate(point))?;
                    body.read(quantity, &place, field, &mut numbers)
                }
                _ => body.read(quantity, self.names.index(quantity, index)?, field, &mut numbers),
            }
            .map_err(of_output)?;
            numbers
        });
        shown(py, quantity, numbers)
    }

    /// Reads a probe of the file by its name.
    #[pyo3(signature = (name, field="displacement"))]
    fn probe(&self, name: &str, field: &str) -> PyResult<f64> {
        let (index, field) = (self.names.probe(name)?, self::field(field)?);
        either!(&*self.lock()?, AnySimulation, one => one.probe(index, field)).map_err(of_output)
    }

    /// Reads all probes in the order of `probe_names`.
    #[pyo3(signature = (field="displacement", out=None))]
    fn probes<'py>(
        &self,
        py: Python<'py>,
        field: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (field, moving) = (self::field(field)?, self.lock()?);
        filled::<f64>(py, &[self.names.probes.len()], out, |slice| {
            either!(&*moving, AnySimulation, one => {
                for (probe, value) in slice.iter_mut().enumerate() {
                    *value = one.probe(probe, field).map_err(of_output)?;
                }
            });
            Ok(())
        })
    }

    /// Reads a place, three numbers in the axes of the body.
    #[pyo3(signature = (place, field="displacement", out=None))]
    fn point<'py>(
        &self,
        py: Python<'py>,
        place: Target,
        field: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let field = self::field(field)?;
        let moved = either!(&*self.lock()?, AnySimulation, one => {
            one.point(&place.on(|point| one.locate(point))?, field).map_err(of_output)?
        });
        triple((py, out), moved)
    }

    /// Reads a node, three numbers in the axes of the body.
    #[pyo3(signature = (node, field="displacement", out=None))]
    fn node<'py>(
        &self,
        py: Python<'py>,
        node: usize,
        field: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let field = self::field(field)?;
        let moved = either!(&*self.lock()?, AnySimulation, one => one.body().node(node, field));
        triple((py, out), moved.map_err(of_output)?)
    }

    /// Reads the nodes of the surface, shape (surface nodes, 3), in the precision of the body.
    #[pyo3(signature = (field="displacement", out=None))]
    fn surface<'py>(
        &self,
        py: Python<'py>,
        field: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let field = self::field(field)?;
        either!(&*self.lock()?, AnySimulation, one => surface(one, field, (py, out)))
    }

    /// Reads all nodes, shape (nodes, 3), in the precision of the body.
    #[pyo3(signature = (field="displacement", out=None))]
    fn whole<'py>(
        &self,
        py: Python<'py>,
        field: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let field = self::field(field)?;
        either!(&*self.lock()?, AnySimulation, one => whole(one, field, (py, out)))
    }

    /// Reads force in N and moment in N m that a support exerts on the body, six numbers.
    fn reaction<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let index = self.names.support(name)?;
        let exerted =
            either!(&*self.lock()?, AnySimulation, one => one.reaction(index)).map_err(of_output)?;
        owned(py, exerted.total().to_vec(), &[6])
    }

    /// Points of the file that have a stress: node of the file and region of the mesh, shape (points, 2).
    #[getter]
    fn stress_points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let numbers: Vec<u32> = either!(&*self.lock()?, AnySimulation, one => {
            let scene = one.scene();
            let points = (0..scene.n_stress_points()).filter_map(|point| scene.stress_point(point));
            points.flat_map(|point| [point.node, point.region]).collect()
        });
        let count = numbers.len() / 2;
        owned(py, numbers, &[count, 2])
    }

    /// Reads the stress in Pa at these points: xx, yy, zz, xy, yz, zx, shape (points, 6).
    fn stress<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.at_stress_points(py, Quantity::Stress)
    }

    /// Reads the strain at these points, with the shear strains of the tensor, shape (points, 6).
    fn strain<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.at_stress_points(py, Quantity::Strain)
    }

    /// Reads the von Mises equivalent stress in Pa at these points.
    fn von_mises<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.at_stress_points(py, Quantity::VonMises)
    }

    /// Kinetic plus elastic energy in J.
    #[getter]
    fn energy(&self) -> PyResult<f64> {
        either!(&*self.lock()?, AnySimulation, one => one.energy()).map_err(of_output)
    }

    /// Saves everything that a step changes, as bytes with a tag of the file. Loads are not part of it.
    fn save<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        either!(&*self.lock()?, AnySimulation, one => {
            let mut bytes = vec![0; one.body().saved_len()];
            let written = one.body().save_into(&mut bytes).map_err(of_saved)?;
            Ok(PyBytes::new(py, &bytes[..written]))
        })
    }

    /// Takes back what `save` gave of a body of the same file and structure. Gives `True` if every bit is as
    /// it was saved, `False` if the state was carried over from other parameters or the other precision:
    /// displacement and velocity then stay.
    fn restore(&self, saved: &Bound<'_, PyAny>) -> PyResult<bool> {
        let found = || PyTypeError::new_err(format!("expected bytes, found {}", saved.get_type()));
        let saved: Cow<'_, [u8]> = saved.extract().map_err(|_| found())?;
        let restored = either!(&mut *self.lock()?, AnySimulation, one => {
            one.with_body(|body| body.restore(&saved))
        });
        Ok(restored.map_err(of_saved)? == Restored::AsSaved)
    }

    /// Sets the reduced coordinates and their velocity, one number per mode.
    #[pyo3(signature = (zeta, velocity=None))]
    fn set(&self, zeta: Vec<f64>, velocity: Option<Vec<f64>>) -> PyResult<()> {
        let velocity = velocity.unwrap_or_else(|| vec![0.0; zeta.len()]);
        either!(&mut *self.lock()?, AnySimulation, one => one.with_body(|body| body.set(&zeta, &velocity)))
            .map_err(of_step)
    }

    /// Reads the reduced coordinates and their velocity, one number per mode each.
    fn coordinates<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (zeta, velocity) = either!(&*self.lock()?, AnySimulation, one => {
            let n = one.scene().n_modes();
            let (mut zeta, mut velocity) = (vec![0.0; n], vec![0.0; n]);
            one.body().coordinates_into(&mut zeta, &mut velocity).map_err(of_output)?;
            (zeta, velocity)
        });
        let n = zeta.len();
        Ok((owned(py, zeta, &[n])?, owned(py, velocity, &[n])?))
    }

    /// Computes how places yield to forces held over the coming step, shape (3n, 3n) in m/N: number
    /// (3c + i, 3d + j) is the displacement of place c along i for each newton at place d along j.
    fn compliance<'py>(&self, py: Python<'py>, places: Vec<Target>) -> PyResult<Bound<'py, PyAny>> {
        let n = 3 * places.len();
        let w = either!(&*self.lock()?, AnySimulation, one => {
            let places = self::places(one, &places)?;
            let mut work = vec![Default::default(); one.scene().compliance_work(places.len())];
            let mut w = vec![0.0; n * n];
            one.scene().compliance_at(one.state(), &places, &mut w, &mut work).map_err(of_load)?;
            w
        });
        owned(py, w, &[n, n])
    }

    /// Computes displacements of places at the end of the coming step under the loads as they are, shape (n,
    /// 3) in m.
    fn free_motion<'py>(&self, py: Python<'py>, places: Vec<Target>) -> PyResult<Bound<'py, PyAny>> {
        let moved = either!(&*self.lock()?, AnySimulation, one => {
            let places = self::places(one, &places)?;
            let mut work = vec![Default::default(); one.scene().compliance_work(places.len())];
            let mut out = vec![[0.0; 3]; places.len()];
            one.scene().free_motion(one.state(), one.loads(), &places, &mut out, &mut work).map_err(of_step)?;
            out
        });
        owned(py, moved.into_flattened(), &[places.len(), 3])
    }

    /// Computes the gradient of a scalar of a march that ends now, by its adjoint, which needs no states.
    /// `cotangents` are the derivatives of the scalar with respect to the probes after each step, shape
    /// (steps, probes), or (steps, 2, probes) for displacements and velocities. Gives that with respect to
    /// forces at these places, to amplitudes of these load patterns, and to the coordinates at the start.
    /// Loads of the march may be any; parameters are those of now.
    #[pyo3(signature = (cotangents, places=vec![], patterns=vec![]))]
    #[pyo3(text_signature = "($self, cotangents, places=(), patterns=())")]
    fn adjoint<'py>(
        &self,
        py: Python<'py>,
        cotangents: &Bound<'py, PyAny>,
        places: Vec<Target>,
        patterns: Vec<String>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let indices: Vec<usize> =
            patterns.iter().map(|name| self.names.pattern(name)).collect::<PyResult<_>>()?;
        let cotangents = adjoint::of_probes(cotangents, self.names.probes.len())?;
        let steps = cotangents.len();
        let found = either!(&*self.lock()?, AnySimulation, one => {
            let places = self::places(one, &places)?;
            py.detach(|| adjoint::of_body(one, &cotangents, (&places, &indices))).map_err(of_adjoint)?
        });
        let modes = found.zeta.len();
        let class = py.import("vademecum._data")?.getattr("BodyGradient")?;
        class.call1((
            owned(py, found.forces, &[steps, places.len(), 2, 3])?,
            owned(py, found.patterns, &[steps, indices.len(), 2])?,
            owned(py, found.zeta, &[modes])?,
            owned(py, found.velocity, &[modes])?,
        ))
    }

    /// Mass, centre and moments of inertia of a body without supports, at its density; `None` of any other.
    #[getter]
    fn rigid_body<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let Some(rigid) = either!(&*self.lock()?, AnySimulation, one => one.body().rigid_body()) else {
            return Ok(None);
        };
        let class = py.import("vademecum._data")?.getattr("FreeBody")?;
        let triple = <(f64, f64, f64)>::from;
        let [a, b, c] = rigid.axes.map(triple);
        class.call1((rigid.mass, triple(rigid.centre), triple(rigid.moments), (a, b, c))).map(Some)
    }

    /// Throws a body that flies from where the file has it, with a velocity of its centre in m/s and an
    /// angular velocity in rad/s. The elastic motion stays.
    #[pyo3(
        signature = (velocity=Vector::ZERO, spin=Vector::ZERO),
        text_signature = "($self, velocity=(0.0, 0.0, 0.0), spin=(0.0, 0.0, 0.0))"
    )]
    fn throw(&self, velocity: Vector, spin: Vector) -> PyResult<()> {
        either!(&mut *self.lock()?, AnySimulation, one => {
            flight(one)?;
            let thrown = one.with_body(|body| body.throw(velocity.0, spin.0));
            thrown.ok_or_else(|| PyValueError::new_err("a velocity has a number that is not finite"))
        })
    }

    /// Rigid motion of a body that flies; set it to put the body elsewhere.
    #[getter]
    fn motion(&self) -> PyResult<PyMotion> {
        either!(&*self.lock()?, AnySimulation, one => Ok(PyMotion(*flight(one)?.motion())))
    }

    #[setter]
    fn set_motion(&self, motion: &Bound<'_, PyMotion>) -> PyResult<()> {
        either!(&mut *self.lock()?, AnySimulation, one => {
            flight(one)?;
            let set = one.with_body(|body| body.set_motion(motion.get().0));
            set.ok_or_else(|| PyValueError::new_err("the motion has a number that is not finite"))
        })
    }

    /// Rigid motion at the end of the coming step, under the forces so far.
    #[getter]
    fn ahead(&self) -> PyResult<PyMotion> {
        either!(&*self.lock()?, AnySimulation, one => Ok(PyMotion(flight(one)?.ahead(one.scene()))))
    }

    /// Reads position in m or velocity in m/s of a place of a body that flies, in space and deformed.
    #[pyo3(signature = (place, field="displacement", out=None))]
    fn in_space<'py>(
        &self,
        py: Python<'py>,
        place: Target,
        field: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let field = self::field(field)?;
        let found = either!(&*self.lock()?, AnySimulation, one => {
            flight(one)?;
            one.body().in_space(&place.on(|point| one.locate(point))?, field).map_err(of_output)?
        });
        triple((py, out), found)
    }

    fn __repr__(&self) -> PyResult<String> {
        let (structure, moving) = (self.structure()?, self.lock()?);
        let precision = match &*moving {
            AnySimulation::Single(_) => "float32",
            AnySimulation::Double(_) => "float64",
        };
        let (metadata, time_step) =
            either!(&*moving, AnySimulation, one => (one.file().metadata(), one.body().time_step()));
        let (modes, nodes) = (metadata.n_modes, metadata.n_nodes);
        Ok(format!(
            "<Body of {modes} modes and {nodes} nodes, {structure} structure, {precision}, {time_step} s a step>"
        ))
    }
}
