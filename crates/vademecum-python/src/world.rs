//! Worlds: bodies that touch with friction, and joints that turn far.

use std::borrow::Cow;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use vademecum_assembly::{
    AssemblyError, AssemblyFile, JointEntry, JointKind, PartPoint, WorldEntry, WorldRunError, WorldSimulation,
};
use vademecum_eval::{Body, Field, JointState, Member, Pose, SurfacePoint, Touch};
use vademecum_format::SectionKind;
use vademecum_study::contents::lines;

use crate::arrays::{filled, owned};
use crate::content::Content;
use crate::file::PyFile;
use crate::motion::PyMotion;
use crate::names::field;
use crate::options::asked;
use crate::point::{Count, PyPoint, Target, Vector};
use crate::refusal::{Refusal, busy, of_load, of_locate, of_missing, of_output, unknown};
use crate::setup::{Own, Setup, Start};

/// Longest wait of Python's signals.
const PATIENCE: Duration = Duration::from_millis(50);

/// Bodies that move, touch with friction, and turn about joints. It belongs to one thread at a time.
///
/// `World.open(path)` reads an assembly file with `[world]`. `World(step=1e-3)` is empty: `add`, `add_box`,
/// `add_surface`, `touch` and `join` make it, until the first step or the first thing that is read. Parts go
/// by their names. Positions, velocities and forces are those of space; a place of a part is given in its own
/// coordinates. What is pushed acts in the coming step only.
///
/// Methods with `out` write into that array, as those of `Body` do.
#[pyclass(frozen, name = "World", module = "vademecum")]
pub struct PyWorld {
    stage: Mutex<Stage>,
}

enum Stage {
    Setup(Setup),
    Moving(Box<WorldSimulation>),
}

/// A world that this thread has, and that moves.
struct Locked<'a>(MutexGuard<'a, Stage>);

impl Locked<'_> {
    fn world(&mut self) -> PyResult<&mut WorldSimulation> {
        match &mut *self.0 {
            Stage::Moving(world) => Ok(world),
            Stage::Setup(_) => Err(PyValueError::new_err("the world has not begun")),
        }
    }

    /// Number of a part, and the world.
    fn part(&mut self, name: &str) -> PyResult<(usize, &mut WorldSimulation)> {
        let world = self.world()?;
        let parts = &world.file().parts;
        match parts.iter().position(|part| part.name == name) {
            Some(part) => Ok((part, world)),
            None => {
                let names: Vec<String> = parts.iter().map(|part| part.name.clone()).collect();
                Err(unknown_in_world("part", name, &names))
            }
        }
    }

    /// Number of a joint, and the world.
    fn joint(&mut self, name: &str) -> PyResult<(usize, &mut WorldSimulation)> {
        let world = self.world()?;
        let names = joint_names(world.file());
        match names.iter().position(|joint| joint == name) {
            Some(joint) => Ok((joint, world)),
            None => Err(unknown_in_world("joint", name, &names)),
        }
    }
}

fn unknown_in_world(kind: &str, name: &str, names: &[String]) -> PyErr {
    unknown("the world", kind, name, names)
}

fn joint_names(file: &AssemblyFile) -> Vec<String> {
    file.joints.iter().enumerate().map(|(i, joint)| joint.name(i)).collect()
}

/// Runs a call on the body of a part; refuses a rigid one.
fn on_body<R>(
    member: &mut Member<'_, '_, f64>,
    run: impl FnOnce(&mut Body<'_, f64>) -> PyResult<R>,
) -> PyResult<R> {
    match member {
        Member::Held(body, _) | Member::Free(body) => run(body),
        Member::Rigid(_) => Err(PyValueError::new_err("the part is a rigid body, which has no modes")),
    }
}

/// A place of a part: of a rigid body, three numbers in its coordinates.
fn point_of(member: &Member<'_, '_, f64>, place: &Target) -> PyResult<PartPoint> {
    match (member, place) {
        (Member::Held(body, _) | Member::Free(body), place) => {
            Ok(PartPoint::Place(place.on(|point| body.locate(point))?.place))
        }
        (Member::Rigid(_), Target::Space(point)) => Ok(PartPoint::Point(*point)),
        (Member::Rigid(_), Target::Found(_)) => {
            Err(PyTypeError::new_err("the part is a rigid body: expected three coordinates"))
        }
    }
}

fn failed(error: WorldRunError) -> PyErr {
    Refusal::from(error).into()
}

fn triple<'py>(
    (py, out): (Python<'py>, Option<&Bound<'py, PyAny>>),
    numbers: [f64; 3],
) -> PyResult<Bound<'py, PyAny>> {
    filled::<f64>(py, &[3], out, |slice| {
        slice.copy_from_slice(&numbers);
        Ok(())
    })
}

/// A pose of unit length.
fn pose(Vector(position): Vector, quaternion: [f64; 4]) -> PyResult<Pose> {
    let pose = Pose::new(position, quaternion);
    let said = "a number of the pose is not finite, or its quaternion has not length one";
    if pose.is_sound() { Ok(pose) } else { Err(PyValueError::new_err(said)) }
}

/// Rows of three numbers.
fn rows<T: numpy::Element + Copy>(given: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<[T; 3]>> {
    let asked =
        given.py().import("numpy")?.call_method1("ascontiguousarray", (given, T::get_dtype(given.py())))?;
    let array: PyReadonlyArrayDyn<'_, T> = asked.extract()?;
    if array.shape().get(1) != Some(&3) || array.shape().len() != 2 {
        let said = format!("{what}: expected the shape (n, 3), found {:?}", array.shape());
        return Err(PyValueError::new_err(said));
    }
    Ok(array.as_slice()?.as_chunks().0.to_vec())
}

impl PyWorld {
    fn lock(&self) -> PyResult<MutexGuard<'_, Stage>> {
        self.stage.try_lock().map_err(|_| busy("world"))
    }

    /// The world before it moves.
    fn setup<R>(&self, run: impl FnOnce(&mut Setup) -> PyResult<R>) -> PyResult<R> {
        match &mut *self.lock()? {
            Stage::Setup(setup) => run(setup),
            Stage::Moving(_) => Err(PyValueError::new_err(
                "the world has begun: add parts, pairs and joints before the first step and the first thing \
                 that is read",
            )),
        }
    }

    /// The world that moves; it begins here.
    fn moving(&self, py: Python<'_>) -> PyResult<Locked<'_>> {
        let mut stage = self.lock()?;
        if let Stage::Setup(setup) = &*stage {
            *stage = Stage::Moving(Box::new(setup.bind(py)?));
        }
        Ok(Locked(stage))
    }
}

#[pymethods]
impl PyWorld {
    #[new]
    #[pyo3(
        signature = (
            step=None, gravity=Vector::ZERO, *, reach=None, tolerance=None, sweeps=Count(200),
            contacts=Count(256),
        ),
        text_signature = "(step=None, gravity=(0.0, 0.0, 0.0), *, reach=None, tolerance=None, sweeps=200, \
                          contacts=256)"
    )]
    fn new(
        step: Option<f64>,
        gravity: Vector,
        reach: Option<f64>,
        tolerance: Option<f64>,
        sweeps: Count,
        contacts: Count,
    ) -> Self {
        let (Count(sweeps), Count(contacts), Vector(gravity)) = (sweeps, contacts, gravity);
        // It is stepped by hand, so the time to march does not matter.
        let world = WorldEntry { time: 1.0, step, gravity, reach, tolerance, sweeps, contacts };
        Self { stage: Mutex::new(Stage::Setup(Setup::new(world))) }
    }

    /// Reads a world from an assembly file with `[world]`, as `vademecum run` does.
    #[staticmethod]
    fn open(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let read = || {
            let file = AssemblyFile::read(&path).map_err(AssemblyError::from)?;
            WorldSimulation::open(file).map_err(Refusal::from)
        };
        let world = py.detach(read).map_err(|refusal| of_missing(refusal, &path))?;
        Ok(Self { stage: Mutex::new(Stage::Moving(Box::new(world))) })
    }

    /// Adds a body of a `File`, or of a path, and gives its name. `position` is the place of the origin of
    /// its coordinates and `quaternion` its rotation, the real part first. A body without supports moves
    /// freely, with a `velocity` of its centre in m/s and an angular velocity `spin` in rad/s. Options are
    /// those of `File.body`.
    #[pyo3(
        signature = (
            body, position=Vector::ZERO, quaternion=[1.0, 0.0, 0.0, 0.0], velocity=None, spin=None, *,
            name=None, **options,
        ),
        text_signature = "($self, body, position=(0.0, 0.0, 0.0), quaternion=(1.0, 0.0, 0.0, 0.0), \
                          velocity=None, spin=None, *, name=None, **options)"
    )]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn add(
        &self,
        py: Python<'_>,
        body: &Bound<'_, PyAny>,
        position: Vector,
        quaternion: [f64; 4],
        velocity: Option<Vector>,
        spin: Option<Vector>,
        name: Option<String>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<String> {
        let (content, path) = match body.getattr("_native") {
            Ok(native) => {
                let file = native.cast::<PyFile>()?.get();
                (Arc::clone(&file.content), file.path.clone())
            }
            Err(_) => {
                let path: PathBuf = body.extract().map_err(|_| {
                    PyTypeError::new_err("body: expected a File, or the path of a vademecum file")
                })?;
                let opened = py.detach(|| Content::open(&path, false));
                (Arc::new(opened.map_err(|refusal| of_missing(refusal, &path))?), path)
            }
        };
        for own in ["flight", "time_step", "contacts"] {
            if options.is_some_and(|options| options.contains(own).unwrap_or(false)) {
                let said = format!("`{own}` is that of the world: expected no option of this name");
                return Err(PyTypeError::new_err(said));
            }
        }
        let asked = asked(&content.file(&path)?, options)?;
        let (content, _) = content.at(&path, &asked)?;
        let start = start(position, quaternion, velocity, spin, None);
        self.setup(|setup| setup.add(name, Own::File(content, asked.scene), &start))
    }

    /// Adds a rigid box, from the origin of its coordinates on, of these lengths in m. With a `density` in
    /// kg/m3 it moves; without one it stands, and `lead` moves it.
    #[pyo3(
        signature = (
            lengths, position=Vector::ZERO, quaternion=[1.0, 0.0, 0.0, 0.0], velocity=None, spin=None, *,
            density=None, name=None,
        ),
        text_signature = "($self, lengths, position=(0.0, 0.0, 0.0), quaternion=(1.0, 0.0, 0.0, 0.0), \
                          velocity=None, spin=None, *, density=None, name=None)"
    )]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn add_box(
        &self,
        lengths: Vector,
        position: Vector,
        quaternion: [f64; 4],
        velocity: Option<Vector>,
        spin: Option<Vector>,
        density: Option<f64>,
        name: Option<String>,
    ) -> PyResult<String> {
        let start = start(position, quaternion, velocity, spin, density);
        self.setup(|setup| setup.add(name, Own::Block(lengths.0), &start))
    }

    /// Adds a rigid body within a surface: nodes in m, shape (n, 3), and triangles, shape (m, 3),
    /// counterclockwise from outside. With a `density` in kg/m3 the surface is closed and the body moves;
    /// without one it stands, and `lead` moves it.
    #[pyo3(
        signature = (
            nodes, triangles, position=Vector::ZERO, quaternion=[1.0, 0.0, 0.0, 0.0], velocity=None,
            spin=None, *, density=None, name=None,
        ),
        text_signature = "($self, nodes, triangles, position=(0.0, 0.0, 0.0), \
                          quaternion=(1.0, 0.0, 0.0, 0.0), velocity=None, spin=None, *, density=None, \
                          name=None)"
    )]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn add_surface(
        &self,
        nodes: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        position: Vector,
        quaternion: [f64; 4],
        velocity: Option<Vector>,
        spin: Option<Vector>,
        density: Option<f64>,
        name: Option<String>,
    ) -> PyResult<String> {
        let own = Own::Surface(rows(nodes, "nodes")?, rows(triangles, "triangles")?);
        let start = start(position, quaternion, velocity, spin, density);
        self.setup(|setup| setup.add(name, own, &start))
    }

    /// Lets two parts touch, with Coulomb friction and the restitution of an impact shorter than a step.
    /// `nodes` says whose nodes are held off the surface of the other: "both", "first" or "second".
    #[pyo3(signature = (first, second, friction=0.0, restitution=1.0, nodes="both"))]
    fn touch(
        &self,
        first: String,
        second: String,
        friction: f64,
        restitution: f64,
        nodes: &str,
    ) -> PyResult<()> {
        self.setup(|setup| setup.touch([first, second], friction, restitution, nodes))
    }

    /// Joins two parts by a "ball", "hinge", "slider" or "cable" and gives the name of the joint. A side is
    /// a port that is a frame, "part.port", a rigid body, "part", or, second, "ground". `at` is the point in
    /// space where a rigid body or the ground is held; `length` in m, and `stiffness` in N/m, are those of a
    /// cable; ports farther apart than `distance` in m are refused. A force above `breaks_at` in N breaks it.
    #[pyo3(signature = (
        kind, first, second, *, at=None, length=None, stiffness=None, distance=None, breaks_at=None,
        name=None,
    ))]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn join(
        &self,
        kind: &str,
        first: String,
        second: String,
        at: Option<Vector>,
        length: Option<f64>,
        stiffness: Option<f64>,
        distance: Option<f64>,
        breaks_at: Option<f64>,
        name: Option<String>,
    ) -> PyResult<String> {
        let entry = JointEntry {
            name,
            kind: JointKind::Ball,
            between: [first, second],
            stiffness: stiffness.map(|stiffness| vec![stiffness]),
            turns: true,
            length,
            at: at.map(|at| at.0),
            distance,
            breaks_at,
        };
        self.setup(|setup| setup.join(kind, entry))
    }

    /// Names of the parts.
    #[getter]
    fn part_names(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        let mut locked = self.moving(py)?;
        Ok(locked.world()?.file().parts.iter().map(|part| part.name.clone()).collect())
    }

    /// Names of the joints.
    #[getter]
    fn joint_names(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        Ok(joint_names(self.moving(py)?.world()?.file()))
    }

    /// Length of a step in s.
    #[getter]
    fn time_step(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.moving(py)?.world()?.time_step())
    }

    /// Time in s: that of the steps that were made.
    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.moving(py)?.world()?.time())
    }

    /// Moves on by so many steps, while other threads of Python run. What was pushed acts in the first.
    #[pyo3(signature = (steps=Count(1)), text_signature = "($self, steps=1)")]
    fn step<'py>(&self, py: Python<'py>, steps: Count) -> PyResult<Bound<'py, PyAny>> {
        let mut locked = self.moving(py)?;
        let world = locked.world()?;
        let (mut left, mut sum) = (steps.0, Sum::default());
        while left > 0 {
            let done = py.detach(|| {
                let started = Instant::now();
                while left > 0 && started.elapsed() < PATIENCE {
                    sum.add(&world.step()?);
                    left -= 1;
                }
                Ok(())
            });
            done.map_err(failed)?;
            py.check_signals()?;
        }
        sum.report(py)
    }

    /// Kinetic plus elastic energy in J, of parts, contacts and joints.
    #[getter]
    fn energy(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.moving(py)?.world()?.energy().map_err(failed)?[0])
    }

    /// Potential energy of gravity in J, of the parts that move freely.
    #[getter]
    fn potential(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.moving(py)?.world()?.energy().map_err(failed)?[1])
    }

    /// Positions in m of the `[[output]]` of the assembly file, by name.
    #[getter]
    fn outputs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let mut locked = self.moving(py)?;
        let world = locked.world()?;
        let (positions, dict) = (world.outputs().map_err(failed)?, PyDict::new(py));
        for (output, position) in world.file().outputs.iter().zip(positions) {
            dict.set_item(output.name(), owned(py, position.to_vec(), &[3])?)?;
        }
        Ok(dict)
    }

    /// Reads the positions in space of the nodes of the surface of a part in m, shape (nodes, 3).
    #[pyo3(signature = (part, out=None))]
    fn surface<'py>(
        &self,
        py: Python<'py>,
        part: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut locked = self.moving(py)?;
        let (part, world) = locked.part(part)?;
        let count = world.surface(part).map_or(0, |surface| surface.nodes.len());
        filled::<f64>(py, &[count, 3], out, |slice| {
            world.nodes_into(part, slice.as_chunks_mut().0).map_err(failed)
        })
    }

    /// Triangles of the surface of a part, shape (triangles, 3).
    fn triangles<'py>(&self, py: Python<'py>, part: &str) -> PyResult<Bound<'py, PyAny>> {
        let mut locked = self.moving(py)?;
        let (part, world) = locked.part(part)?;
        let triangles =
            world.surface(part).map_or(vec![], |surface| surface.triangles.as_flattened().to_vec());
        let count = triangles.len() / 3;
        owned(py, triangles, &[count, 3])
    }

    /// Reads the placement of a part: position of the origin of its coordinates in m, and its rotation, a
    /// quaternion, the real part first.
    fn pose<'py>(&self, py: Python<'py>, part: &str) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let mut locked = self.moving(py)?;
        let (part, world) = locked.part(part)?;
        let pose = world.pose(part).unwrap_or(Pose::IDENTITY);
        Ok((owned(py, pose.position().to_vec(), &[3])?, owned(py, pose.attitude().to_vec(), &[4])?))
    }

    /// Puts a held part elsewhere, or leads a rigid body without density there to the end of the coming step.
    #[pyo3(
        signature = (part, position, quaternion=[1.0, 0.0, 0.0, 0.0]),
        text_signature = "($self, part, position, quaternion=(1.0, 0.0, 0.0, 0.0))"
    )]
    fn lead(&self, py: Python<'_>, part: &str, position: Vector, quaternion: [f64; 4]) -> PyResult<()> {
        let pose = pose(position, quaternion)?;
        let mut locked = self.moving(py)?;
        let (part, world) = locked.part(part)?;
        let said = "the part moves freely; expected one with supports, or a rigid body without density";
        world.lead(part, pose).ok_or_else(|| PyValueError::new_err(said))
    }

    /// Reads the rigid motion of a part that moves freely.
    fn motion(&self, py: Python<'_>, part: &str) -> PyResult<PyMotion> {
        let mut locked = self.moving(py)?;
        let (part, world) = locked.part(part)?;
        let said = "the part does not move freely: `pose` gives where it is";
        world.motion(part).map(PyMotion).ok_or_else(|| PyValueError::new_err(said))
    }

    /// Puts a part that moves freely elsewhere, or lets it move otherwise. Its elastic motion stays; the
    /// world forgets its contacts.
    fn set_motion(&self, py: Python<'_>, part: &str, motion: &Bound<'_, PyMotion>) -> PyResult<()> {
        let mut locked = self.moving(py)?;
        let (part, world) = locked.part(part)?;
        let said = "the part does not move freely: `lead` puts it elsewhere";
        world.set_motion(part, motion.get().0).ok_or_else(|| PyValueError::new_err(said))
    }

    /// Finds the nearest point of the loadable surface of a part, in its coordinates and at rest.
    fn locate(&self, py: Python<'_>, part: &str, point: Vector) -> PyResult<PyPoint> {
        let found: SurfacePoint =
            self.member(py, part, |member| on_body(member, |body| body.locate(point.0).map_err(of_locate)))?;
        Ok(PyPoint(found))
    }

    /// Pushes a part at a place with a force in N of space, in the coming step.
    fn push(&self, py: Python<'_>, part: &str, place: Target, force: Vector) -> PyResult<()> {
        self.member(py, part, |member| {
            let at = point_of(member, &place)?;
            match (member, at) {
                (Member::Free(body), PartPoint::Place(place)) => body.push(&place, force.0).map_err(of_load),
                (Member::Held(body, stand), PartPoint::Place(place)) => {
                    body.push(&place, stand.turn_back(force.0)).map_err(of_load)
                }
                (Member::Rigid(shape), PartPoint::Point(point)) => {
                    let centre = shape.body().map_or([0.0; 3], |body| body.centre);
                    let arm = shape.motion().to_space(std::array::from_fn(|k| point[k] - centre[k]));
                    let at = std::array::from_fn(|k| shape.motion().position[k] + arm[k]);
                    shape.push(at, finite(force)?);
                    Ok(())
                }
                _ => Err(PyTypeError::new_err("the place is none of this part")),
            }
        })
    }

    /// Pulls a part that moves freely at its centre with a force in N of space, in the coming step.
    fn pull(&self, py: Python<'_>, part: &str, force: Vector) -> PyResult<()> {
        let force = finite(force)?;
        self.member(py, part, |member| match member {
            Member::Free(body) => body.pull(force).map_err(of_load),
            Member::Rigid(shape) if shape.body().is_some() => {
                shape.pull(force, [0.0; 3]);
                Ok(())
            }
            _ => Err(PyValueError::new_err("the part does not move freely")),
        })
    }

    /// Adds a load pattern of the file of a part, times an amplitude, in the coming step.
    #[pyo3(signature = (part, name, amplitude=1.0))]
    fn push_pattern(&self, py: Python<'_>, part: &str, name: &str, amplitude: f64) -> PyResult<()> {
        self.member(py, part, |member| {
            on_body(member, |body| {
                let names = lines(body.file(), SectionKind::PatternNames).map_err(Refusal::from)?;
                let index = names.iter().position(|known| known == name);
                let index = index.ok_or_else(|| unknown("the file", "load pattern", name, &names))?;
                body.push_pattern(index, amplitude).map_err(of_load)
            })
        })
    }

    /// Reads displacement in m or velocity in m/s of a place of a part in the axes of the part.
    #[pyo3(signature = (part, place, field="displacement", out=None))]
    fn point<'py>(
        &self,
        py: Python<'py>,
        part: &str,
        place: Target,
        field: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let field = self::field(field)?;
        let found = self.member(py, part, |member| {
            on_body(member, |body| {
                let at = place.on(|point| body.locate(point))?;
                body.point(&at, field).map_err(of_output)
            })
        })?;
        triple((py, out), found)
    }

    /// Reads position in m or velocity in m/s of a place of a part in space, deformed as it is. The velocity
    /// of a held part is that of its deformation.
    #[pyo3(signature = (part, place, field="displacement", out=None))]
    fn in_space<'py>(
        &self,
        py: Python<'py>,
        part: &str,
        place: Target,
        field: &str,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let field = self::field(field)?;
        let mut locked = self.moving(py)?;
        let (part, world) = locked.part(part)?;
        let at = world.with_member(part, |member| point_of(member, &place)).ok_or_else(no_part)??;
        let found = match field {
            Field::Displacement => world.position(part, &at),
            Field::Velocity => world.velocity(part, &at),
        };
        triple((py, out), found.map_err(failed)?)
    }

    /// Reads the reduced coordinates of a part and their velocity, one number per mode each.
    fn coordinates<'py>(
        &self,
        py: Python<'py>,
        part: &str,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (zeta, velocity) = self.member(py, part, |member| {
            on_body(member, |body| {
                let modes = body.scene().metadata().n_modes as usize;
                let (mut zeta, mut velocity) = (vec![0.0; modes], vec![0.0; modes]);
                body.coordinates_into(&mut zeta, &mut velocity).map_err(of_output)?;
                Ok((zeta, velocity))
            })
        })?;
        let modes = zeta.len();
        Ok((owned(py, zeta, &[modes])?, owned(py, velocity, &[modes])?))
    }

    /// Contacts of the last step, pairs of a node and a surface that were near each other.
    #[getter]
    fn contacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let mut locked = self.moving(py)?;
        let all: Vec<Touch> = locked.world()?.with_touches(<[Touch]>::to_vec);
        let count = all.len();
        let three = |of: fn(&Touch) -> [f64; 3]| owned(py, all.iter().flat_map(of).collect(), &[count, 3]);
        let one = |of: fn(&Touch) -> f64| owned(py, all.iter().map(of).collect(), &[count]);
        let parts = all.iter().flat_map(|touch| touch.members().map(|member| member as u32)).collect();
        let class = py.import("vademecum._data")?.getattr("Contacts")?;
        class.call1((
            owned::<u32>(py, parts, &[count, 2])?,
            three(Touch::position)?,
            three(Touch::normal)?,
            three(Touch::force)?,
            one(Touch::pressure)?,
            one(Touch::gap)?,
            three(Touch::slip)?,
        ))
    }

    /// Sums the contact forces in N that the second part exerted on the first in the last step.
    fn contact_force<'py>(&self, py: Python<'py>, first: &str, second: &str) -> PyResult<Bound<'py, PyAny>> {
        let mut locked = self.moving(py)?;
        let (first, _) = locked.part(first)?;
        let (second, world) = locked.part(second)?;
        let sum = world.with_touches(|touches| {
            let mut sum = [0.0; 3];
            for touch in touches {
                let sign = match touch.members() {
                    [a, b] if [a, b] == [first, second] => 1.0,
                    [a, b] if [b, a] == [first, second] => -1.0,
                    _ => continue,
                };
                sum.iter_mut().zip(touch.force()).for_each(|(sum, force)| *sum += sign * force);
            }
            sum
        });
        owned(py, sum.to_vec(), &[3])
    }

    /// Reads force in N and moment in N m that a joint exerted on its first part in the last step, about its
    /// anchor there and in space, six numbers.
    fn joint_force<'py>(&self, py: Python<'py>, joint: &str) -> PyResult<Bound<'py, PyAny>> {
        let state = self.joint_state(py, joint)?;
        owned(py, [state.force(), state.moment()].concat(), &[6])
    }

    /// True of a joint that was broken.
    fn is_broken(&self, py: Python<'_>, joint: &str) -> PyResult<bool> {
        Ok(self.joint_state(py, joint)?.is_broken())
    }

    /// Breaks a joint: it holds nothing any more.
    fn break_joint(&self, py: Python<'_>, joint: &str) -> PyResult<()> {
        let mut locked = self.moving(py)?;
        let (joint, world) = locked.joint(joint)?;
        world.with(|world, _| world.break_joint(joint)).ok_or_else(no_part)
    }

    /// Saves everything that a step changes, and the placements of the held parts. Loads are not part of it.
    fn save<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &self.moving(py)?.world()?.save()))
    }

    /// Takes back what `save` gave of a world of the same parts, pairs, joints and options. It goes on from
    /// there bit by bit. Nothing has changed where it is refused.
    fn restore(&self, py: Python<'_>, saved: &Bound<'_, PyAny>) -> PyResult<()> {
        let found = || PyTypeError::new_err(format!("expected bytes, found {}", saved.get_type()));
        let saved: Cow<'_, [u8]> = saved.extract().map_err(|_| found())?;
        let restored = self.moving(py)?.world()?.restore(&saved);
        restored.map_err(|error| PyValueError::new_err(error.to_string()))
    }

    fn __repr__(&self) -> PyResult<String> {
        Ok(match &*self.lock()? {
            Stage::Setup(setup) => format!("<World of {} parts that has not begun>", setup.n_parts()),
            Stage::Moving(world) => format!(
                "<World of {} parts and {} joints, {} s a step, at {} s>",
                world.file().parts.len(),
                world.file().joints.len(),
                world.time_step(),
                world.time()
            ),
        })
    }
}

impl PyWorld {
    /// Runs a call on a part.
    fn member<R>(
        &self,
        py: Python<'_>,
        part: &str,
        run: impl for<'w, 'm> FnOnce(&mut Member<'w, 'm, f64>) -> PyResult<R>,
    ) -> PyResult<R> {
        let mut locked = self.moving(py)?;
        let (part, world) = locked.part(part)?;
        world.with_member(part, run).ok_or_else(no_part)?
    }

    fn joint_state(&self, py: Python<'_>, joint: &str) -> PyResult<JointState> {
        let mut locked = self.moving(py)?;
        let (joint, world) = locked.joint(joint)?;
        world.with(|world, _| world.joints().get(joint).copied()).ok_or_else(no_part)
    }
}

/// The refusal of a part or joint that the world has not, though its name is there.
fn no_part() -> PyErr {
    PyValueError::new_err("the world has no such part or joint")
}

fn finite(Vector(numbers): Vector) -> PyResult<[f64; 3]> {
    let said = "a force has a number that is not finite";
    if numbers.iter().all(|x| x.is_finite()) { Ok(numbers) } else { Err(PyValueError::new_err(said)) }
}

fn start(
    Vector(position): Vector,
    quaternion: [f64; 4],
    velocity: Option<Vector>,
    spin: Option<Vector>,
    density: Option<f64>,
) -> Start {
    let numbers = |vector: Option<Vector>| vector.map(|vector| vector.0);
    Start { position, quaternion, velocity: numbers(velocity), spin: numbers(spin), density }
}

/// Reports of several steps.
#[derive(Default)]
struct Sum {
    steps: usize,
    last: vademecum_eval::WorldReport,
    sweeps: usize,
    without_room: usize,
    not_converged: usize,
    worst_gap: f64,
    energy_given_away: f64,
}

impl Sum {
    fn add(&mut self, report: &vademecum_eval::WorldReport) {
        self.steps += 1;
        self.last = *report;
        self.sweeps += report.sweeps;
        self.without_room += usize::from(report.left_out > 0);
        self.not_converged += usize::from(!report.converged);
        self.worst_gap = self.worst_gap.max(report.worst_gap);
        self.energy_given_away += report.energy_given_away;
    }

    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let class = py.import("vademecum._data")?.getattr("StepReport")?;
        class.call1((
            self.steps,
            self.last.contacts,
            self.last.pressed,
            self.sweeps,
            self.without_room,
            self.not_converged,
            self.worst_gap,
            self.energy_given_away,
        ))
    }
}
