"""The part of the package that is written in Rust. A test keeps these texts the same as those of the module."""

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Optional, Union, final

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from . import File as _PublicFile
from ._data import BodyGradient, Contacts, FreeBody, Gradient, Quantity, StepReport

__all__ = [
    "__version__", "Batch", "Body", "File", "KeptMarch", "Motion", "SurfacePoint", "Tracker", "World", "build", "check",
    "frf", "init", "mesh", "modes", "program", "report", "run", "sensitivities", "state_space", "tangents", "tracker",
    "verify", "vjp",
]

__version__: str

_Vector = Union[Sequence[float], NDArray[np.floating[Any]], NDArray[np.integer[Any]]]
_Place = Union["SurfacePoint", _Vector]
_Values = Optional[dict[str, float]]
_Given = tuple[str, str, str]
_Load = Union[str, tuple[_Place, _Vector]]
_Pairs = Sequence[tuple[str, float]]
_Progress = Optional[Callable[[str, int, int], object]]

@final
class SurfacePoint:
    """A place on a body: up to 16 nodes, in the order of the file, their weights, which sum to 1, and a radius in
    m. Without weights the nodes have equal ones. Radius 0 is a point; this version takes points only."""

    def __new__(
        cls,
        nodes: Sequence[int],
        weights: Optional[Sequence[float]] = None,
        radius: float = 0.0,
        position: Optional[_Vector] = None,
        distance: float = 0.0,
    ) -> SurfacePoint: ...
    @property
    def nodes(self) -> tuple[int, ...]:
        """Its nodes, in the order of the file."""
    @property
    def weights(self) -> tuple[float, ...]:
        """The weight of each node."""
    @property
    def radius(self) -> float:
        """Radius in m, 0 of a point."""
    @property
    def position(self) -> tuple[float, float, float]:
        """Position at rest in m; of a picked point, position in the picture."""
    @property
    def distance(self) -> float:
        """Distance in m from the point that was asked for."""

@final
class Body:
    """A body that moves, bound to live parameters, with its loads. It belongs to one thread at a time.

    A body without supports flies: `step` moves its frame, too. Its forces are those of space and act in the coming
    step only. On any other body, loads stay until `clear`.

    Methods with `out` write into that array, which has the right shape and type and is C-contiguous; a row of a
    larger array will do. Without `out` they make a new array. Nothing is copied either way. `field` is
    "displacement" in m or "velocity" in m/s.
    """

    @property
    def dtype(self) -> np.dtype[Any]:
        """Precision of the step."""
    @property
    def structure(self) -> str:
        """Structure of the step: "diagonal", "block", "exact" or "strain"."""
    @property
    def time_step(self) -> float:
        """Length of a step in s."""
    @property
    def modes(self) -> int:
        """Number of modes."""
    @property
    def probe_names(self) -> list[str]:
        """Names of the probes of the file."""
    @property
    def pattern_names(self) -> list[str]:
        """Names of the load patterns of the file."""
    @property
    def support_names(self) -> list[str]:
        """Names of the supports whose reactions the file gives."""
    @property
    def parameters(self) -> dict[str, float]:
        """Values of the live parameters, by name."""
    @property
    def quantities(self) -> dict[str, Quantity]:
        """Quantities that `read` gives of this body, by name."""
    def set_parameters(self, values: _Values = None, /, **parameters: float) -> None:
        """Sets live parameters while the body moves: displacement, velocity and loads stay. All of them are set,
        or none if one is refused. A parameter whose name is no keyword is given with `_` for every other sign,
        or in a mapping."""
    @property
    def carried(self) -> Optional[tuple[float, float, float]]:
        """Energies in J of the last change of live parameters of a file with live regions: kinetic and
        elastic energy that the stepped modes do not hold, and the work of the change; `None` of any other
        file."""
    def locate(self, point: _Vector) -> SurfacePoint:
        """Finds the nearest point of the loadable surface at rest. A point further away than the body is large is
        refused."""
    def pick(self, origin: _Vector, direction: _Vector, scale: float = 1.0) -> Optional[SurfacePoint]:
        """Finds the first point that a ray meets on the surface as it has moved, magnified by `scale`."""
    def push(self, place: _Place, force: _Vector) -> SurfacePoint:
        """Adds a force in N at a place, or at the point of the surface nearest to a point in space. Forces add up."""
    def push_pattern(self, name: str, amplitude: float = 1.0) -> None:
        """Adds a load pattern of the file, times an amplitude. On a body that flies it turns with the body."""
    def push_base(
        self,
        acceleration: _Vector = (0.0, 0.0, 0.0),
        angular_velocity: _Vector = (0.0, 0.0, 0.0),
        angular_acceleration: _Vector = (0.0, 0.0, 0.0),
    ) -> None:
        """Adds the inertia of a base that moves so, in its own axes: m/s2, rad/s and rad/s2."""
    def pull(self, force: _Vector) -> None:
        """Adds a force in N at the centre of a body that flies: gravity is the mass times its acceleration."""
    def clear(self) -> None:
        """Takes all loads away."""
    def rest(self) -> None:
        """Puts the body at rest where the file has it. Loads stay, and the next step is a first one."""
    def step(self, steps: int = 1) -> bool:
        """Moves on by so many steps, while other threads of Python run. Gives `False` once the body rests."""
    def march(self, steps: int, every: int = 1, field: str = "displacement") -> NDArray[np.float64]:
        """Steps, with a row of all probes after each `every` steps: shape (steps // every, probes)."""
    def read(self, quantity: str, index: Union[int, str, _Place, None] = None, field: str = "displacement") -> Any:
        """Reads any quantity of `quantities`: a number, or an array of float64. `index` counts from 0; probes and
        supports go by their names, too, and "point" by a place."""
    def probe(self, name: str, field: str = "displacement") -> float:
        """Reads a probe of the file by its name."""
    def probes(
        self, field: str = "displacement", out: Optional[NDArray[np.float64]] = None
    ) -> NDArray[np.float64]:
        """Reads all probes in the order of `probe_names`."""
    def point(
        self, place: _Place, field: str = "displacement", out: Optional[NDArray[np.float64]] = None
    ) -> NDArray[np.float64]:
        """Reads a place, three numbers in the axes of the body."""
    def node(
        self, node: int, field: str = "displacement", out: Optional[NDArray[np.float64]] = None
    ) -> NDArray[np.float64]:
        """Reads a node, three numbers in the axes of the body."""
    def surface(self, field: str = "displacement", out: Optional[NDArray[Any]] = None) -> NDArray[Any]:
        """Reads the nodes of the surface, shape (surface nodes, 3), in the precision of the body."""
    def whole(self, field: str = "displacement", out: Optional[NDArray[Any]] = None) -> NDArray[Any]:
        """Reads all nodes, shape (nodes, 3), in the precision of the body."""
    def reaction(self, name: str) -> NDArray[np.float64]:
        """Reads force in N and moment in N m that a support exerts on the body, six numbers."""
    @property
    def stress_points(self) -> NDArray[np.uint32]:
        """Points of the file that have a stress: node of the file and region of the mesh, shape (points, 2)."""
    def stress(self) -> NDArray[np.float64]:
        """Reads the stress in Pa at these points: xx, yy, zz, xy, yz, zx, shape (points, 6)."""
    def strain(self) -> NDArray[np.float64]:
        """Reads the strain at these points, with the shear strains of the tensor, shape (points, 6)."""
    def von_mises(self) -> NDArray[np.float64]:
        """Reads the von Mises equivalent stress in Pa at these points."""
    @property
    def energy(self) -> float:
        """Kinetic plus elastic energy in J."""
    def save(self) -> bytes:
        """Saves everything that a step changes, as bytes with a tag of the file. Loads are not part of it."""
    def restore(self, saved: Union[bytes, bytearray]) -> bool:
        """Takes back what `save` gave of a body of the same file and structure. Gives `True` if every bit is as it
        was saved, `False` if the state was carried over from other parameters or the other precision:
        displacement and velocity then stay."""
    def set(self, zeta: _Vector, velocity: Optional[_Vector] = None) -> None:
        """Sets the reduced coordinates and their velocity, one number per mode."""
    def coordinates(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Reads the reduced coordinates and their velocity, one number per mode each."""
    def compliance(self, places: Sequence[_Place]) -> NDArray[np.float64]:
        """Computes how places yield to forces held over the coming step, shape (3n, 3n) in m/N: number (3c + i, 3d
        + j) is the displacement of place c along i for each newton at place d along j."""
    def free_motion(self, places: Sequence[_Place]) -> NDArray[np.float64]:
        """Computes displacements of places at the end of the coming step under the loads as they are, shape (n, 3)
        in m."""
    def adjoint(
        self, cotangents: NDArray[np.float64], places: Sequence[_Place] = (), patterns: Sequence[str] = ()
    ) -> BodyGradient:
        """Computes the gradient of a scalar of a march that ends now, by its adjoint, which needs no states.
        `cotangents` are the derivatives of the scalar with respect to the probes after each step, shape (steps,
        probes), or (steps, 2, probes) for displacements and velocities. Gives that with respect to forces at these
        places, to amplitudes of these load patterns, and to the coordinates at the start. Loads of the march may be
        any; parameters are those of now."""
    @property
    def rigid_body(self) -> Optional[FreeBody]:
        """Mass, centre and moments of inertia of a body without supports, at its density; `None` of any other."""
    def throw(self, velocity: _Vector = (0.0, 0.0, 0.0), spin: _Vector = (0.0, 0.0, 0.0)) -> None:
        """Throws a body that flies from where the file has it, with a velocity of its centre in m/s and an angular
        velocity in rad/s. The elastic motion stays."""
    @property
    def motion(self) -> Motion:
        """Rigid motion of a body that flies; set it to put the body elsewhere."""
    @motion.setter
    def motion(self, motion: Motion) -> None: ...
    @property
    def ahead(self) -> Motion:
        """Rigid motion at the end of the coming step, under the forces so far."""
    def in_space(
        self, place: _Place, field: str = "displacement", out: Optional[NDArray[np.float64]] = None
    ) -> NDArray[np.float64]:
        """Reads position in m or velocity in m/s of a place of a body that flies, in space and deformed."""

@final
class KeptMarch:
    """A march that is kept, for its gradients. `File.vjp` makes one. It belongs to one thread at a time."""

    @property
    def values(self) -> NDArray[np.float64]:
        """The probes after each step, shape (steps, probes)."""
    def gradient(self, cotangents: NDArray[np.float64]) -> Gradient:
        """Computes the gradient of a scalar whose derivatives with respect to `values` are these cotangents, of the
        same shape."""

@final
class Motion:
    """The rigid motion of a body that flies: position of its centre, attitude, and momenta, in space."""

    def __new__(
        cls,
        position: _Vector,
        attitude: _Vector = (1.0, 0.0, 0.0, 0.0),
        momentum: _Vector = (0.0, 0.0, 0.0),
        angular_momentum: _Vector = (0.0, 0.0, 0.0),
    ) -> Motion: ...
    @property
    def position(self) -> tuple[float, float, float]:
        """Position of the centre in m."""
    @property
    def attitude(self) -> tuple[float, float, float, float]:
        """A quaternion of length one, the real part first, that turns directions of the body into those of space."""
    @property
    def momentum(self) -> tuple[float, float, float]:
        """Momentum in space in kg m/s."""
    @property
    def angular_momentum(self) -> tuple[float, float, float]:
        """Angular momentum about the centre, in space, in kg m2/s."""

@final
class Batch:
    """Many bodies of one file that are stepped together. Those of a file with live regions have parameters
    of their own, all others share them. `out` is as in `Body`.

    An instance has the bits that a `Body` with `residual=False` and `flight=False` has alone.
    """

    def __len__(self) -> int: ...
    @property
    def time_step(self) -> float:
        """Length of a step in s."""
    @property
    def probe_names(self) -> list[str]:
        """Names of the probes of the file."""
    @property
    def pattern_names(self) -> list[str]:
        """Names of the load patterns of the file."""
    @property
    def support_names(self) -> list[str]:
        """Names of the supports whose reactions the file gives."""
    @property
    def parameters(self) -> dict[str, Any]:
        """Values of the live parameters, by name; of a file with live regions an array of one for each
        instance."""
    @property
    def quantities(self) -> dict[str, Quantity]:
        """Quantities that `read` gives of each instance, by name."""
    def set_parameters(self, values: Optional[dict[str, Any]] = None, /, **parameters: Any) -> None:
        """Sets live parameters of all instances while they move. With live regions a value may be an array
        of one number for each instance. One that is refused changes nothing."""
    def locate(self, point: _Vector) -> SurfacePoint:
        """Finds the nearest point of the loadable surface at rest. A point further away than the body is large is
        refused."""
    def push(self, instance: int, place: _Place, force: _Vector) -> SurfacePoint:
        """Adds a force in N to one instance; it stays until `clear`."""
    def push_pattern(self, instance: int, name: str, amplitude: float = 1.0) -> None:
        """Adds a load pattern to one instance; it stays until `clear`."""
    def clear(self) -> None:
        """Takes the loads of all instances away."""
    def step(self, steps: int = 1) -> tuple[int, int, int]:
        """Moves all instances on, while other threads of Python run. Gives the numbers of instances that move,
        that rest, and that kept their state because the next would not be finite."""
    def read(
        self,
        quantity: str,
        index: Union[int, str, None] = None,
        field: str = "displacement",
        out: Optional[NDArray[np.float64]] = None,
    ) -> NDArray[np.float64]:
        """Reads a quantity of each instance as float64, shape (instances, …); of one number, shape (instances,)."""
    def probes(
        self, field: str = "displacement", out: Optional[NDArray[np.float64]] = None
    ) -> NDArray[np.float64]:
        """Reads all probes of each instance, shape (instances, probes)."""
    def energy(self, out: Optional[NDArray[np.float64]] = None) -> NDArray[np.float64]:
        """Reads the energy of each instance in J."""
    def reaction(self, name: str, out: Optional[NDArray[np.float64]] = None) -> NDArray[np.float64]:
        """Reads force in N and moment in N m that a support exerts on each body under its loads, shape (instances,
        6)."""
    def surface(
        self, instance: int, field: str = "displacement", out: Optional[NDArray[Any]] = None
    ) -> NDArray[Any]:
        """Reads the surface of one instance, shape (surface nodes, 3)."""
    def whole(
        self, instance: int, field: str = "displacement", out: Optional[NDArray[Any]] = None
    ) -> NDArray[Any]:
        """Reads all nodes of one instance, shape (nodes, 3)."""

@final
class World:
    """Bodies that move, touch with friction, and turn about joints. It belongs to one thread at a time.

    `World.open(path)` reads an assembly file with `[world]`. `World(step=1e-3)` is empty: `add`, `add_box`,
    `add_surface`, `touch` and `join` make it, until the first step or the first thing that is read. Parts go by
    their names. Positions, velocities and forces are those of space; a place of a part is given in its own
    coordinates. What is pushed acts in the coming step only.

    Methods with `out` write into that array, as those of `Body` do.
    """

    def __new__(
        cls,
        step: Optional[float] = None,
        gravity: _Vector = (0.0, 0.0, 0.0),
        *,
        reach: Optional[float] = None,
        tolerance: Optional[float] = None,
        sweeps: int = 200,
        contacts: int = 256,
    ) -> World: ...
    @staticmethod
    def open(path: Union[str, PathLike[str]]) -> World:
        """Reads a world from an assembly file with `[world]`, as `vademecum run` does."""
    def add(
        self,
        body: Union[_PublicFile, str, PathLike[str]],
        position: _Vector = (0.0, 0.0, 0.0),
        quaternion: _Vector = (1.0, 0.0, 0.0, 0.0),
        velocity: Optional[_Vector] = None,
        spin: Optional[_Vector] = None,
        *,
        name: Optional[str] = None,
        **options: Any,
    ) -> str:
        """Adds a body of a `File`, or of a path, and gives its name. `position` is the place of the origin of its
        coordinates and `quaternion` its rotation, the real part first. A body without supports moves freely, with
        a `velocity` of its centre in m/s and an angular velocity `spin` in rad/s. Options are those of
        `File.body`."""
    def add_box(
        self,
        lengths: _Vector,
        position: _Vector = (0.0, 0.0, 0.0),
        quaternion: _Vector = (1.0, 0.0, 0.0, 0.0),
        velocity: Optional[_Vector] = None,
        spin: Optional[_Vector] = None,
        *,
        density: Optional[float] = None,
        name: Optional[str] = None,
    ) -> str:
        """Adds a rigid box, from the origin of its coordinates on, of these lengths in m. With a `density` in kg/m3
        it moves; without one it stands, and `lead` moves it."""
    def add_surface(
        self,
        nodes: ArrayLike,
        triangles: ArrayLike,
        position: _Vector = (0.0, 0.0, 0.0),
        quaternion: _Vector = (1.0, 0.0, 0.0, 0.0),
        velocity: Optional[_Vector] = None,
        spin: Optional[_Vector] = None,
        *,
        density: Optional[float] = None,
        name: Optional[str] = None,
    ) -> str:
        """Adds a rigid body within a surface: nodes in m, shape (n, 3), and triangles, shape (m, 3),
        counterclockwise from outside. With a `density` in kg/m3 the surface is closed and the body moves; without
        one it stands, and `lead` moves it."""
    def touch(
        self, first: str, second: str, friction: float = 0.0, restitution: float = 1.0, nodes: str = "both"
    ) -> None:
        """Lets two parts touch, with Coulomb friction and the restitution of an impact shorter than a step. `nodes`
        says whose nodes are held off the surface of the other: "both", "first" or "second"."""
    def join(
        self,
        kind: str,
        first: str,
        second: str,
        *,
        at: Optional[_Vector] = None,
        length: Optional[float] = None,
        stiffness: Optional[float] = None,
        distance: Optional[float] = None,
        breaks_at: Optional[float] = None,
        name: Optional[str] = None,
    ) -> str:
        """Joins two parts by a "ball", "hinge", "slider" or "cable" and gives the name of the joint. A side is a
        port that is a frame, "part.port", a rigid body, "part", or, second, "ground". `at` is the point in space
        where a rigid body or the ground is held; `length` in m, and `stiffness` in N/m, are those of a cable;
        ports farther apart than `distance` in m are refused. A force above `breaks_at` in N breaks it."""
    @property
    def part_names(self) -> list[str]:
        """Names of the parts."""
    @property
    def joint_names(self) -> list[str]:
        """Names of the joints."""
    @property
    def time_step(self) -> float:
        """Length of a step in s."""
    @property
    def time(self) -> float:
        """Time in s: that of the steps that were made."""
    def step(self, steps: int = 1) -> StepReport:
        """Moves on by so many steps, while other threads of Python run. What was pushed acts in the first."""
    @property
    def energy(self) -> float:
        """Kinetic plus elastic energy in J, of parts, contacts and joints."""
    @property
    def potential(self) -> float:
        """Potential energy of gravity in J, of the parts that move freely."""
    @property
    def outputs(self) -> dict[str, NDArray[np.float64]]:
        """Positions in m of the `[[output]]` of the assembly file, by name."""
    def surface(self, part: str, out: Optional[NDArray[np.float64]] = None) -> NDArray[np.float64]:
        """Reads the positions in space of the nodes of the surface of a part in m, shape (nodes, 3)."""
    def triangles(self, part: str) -> NDArray[np.uint32]:
        """Triangles of the surface of a part, shape (triangles, 3)."""
    def pose(self, part: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Reads the placement of a part: position of the origin of its coordinates in m, and its rotation, a
        quaternion, the real part first."""
    def lead(self, part: str, position: _Vector, quaternion: _Vector = (1.0, 0.0, 0.0, 0.0)) -> None:
        """Puts a held part elsewhere, or leads a rigid body without density there to the end of the coming step."""
    def motion(self, part: str) -> Motion:
        """Reads the rigid motion of a part that moves freely."""
    def set_motion(self, part: str, motion: Motion) -> None:
        """Puts a part that moves freely elsewhere, or lets it move otherwise. Its elastic motion stays; the world
        forgets its contacts."""
    def locate(self, part: str, point: _Vector) -> SurfacePoint:
        """Finds the nearest point of the loadable surface of a part, in its coordinates and at rest."""
    def push(self, part: str, place: _Place, force: _Vector) -> None:
        """Pushes a part at a place with a force in N of space, in the coming step."""
    def pull(self, part: str, force: _Vector) -> None:
        """Pulls a part that moves freely at its centre with a force in N of space, in the coming step."""
    def push_pattern(self, part: str, name: str, amplitude: float = 1.0) -> None:
        """Adds a load pattern of the file of a part, times an amplitude, in the coming step."""
    def point(
        self, part: str, place: _Place, field: str = "displacement", out: Optional[NDArray[np.float64]] = None
    ) -> NDArray[np.float64]:
        """Reads displacement in m or velocity in m/s of a place of a part in the axes of the part."""
    def in_space(
        self, part: str, place: _Place, field: str = "displacement", out: Optional[NDArray[np.float64]] = None
    ) -> NDArray[np.float64]:
        """Reads position in m or velocity in m/s of a place of a part in space, deformed as it is. The velocity of a
        held part is that of its deformation."""
    def coordinates(self, part: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Reads the reduced coordinates of a part and their velocity, one number per mode each."""
    @property
    def contacts(self) -> Contacts:
        """Contacts of the last step, pairs of a node and a surface that were near each other."""
    def contact_force(self, first: str, second: str) -> NDArray[np.float64]:
        """Sums the contact forces in N that the second part exerted on the first in the last step."""
    def joint_force(self, joint: str) -> NDArray[np.float64]:
        """Reads force in N and moment in N m that a joint exerted on its first part in the last step, about its anchor
        there and in space, six numbers."""
    def is_broken(self, joint: str) -> bool:
        """True of a joint that was broken."""
    def break_joint(self, joint: str) -> None:
        """Breaks a joint: it holds nothing any more."""
    def save(self) -> bytes:
        """Saves everything that a step changes, and the placements of the held parts. Loads are not part of it."""
    def restore(self, saved: Union[bytes, bytearray]) -> None:
        """Takes back what `save` gave of a world of the same parts, pairs, joints and options. It goes on from there
        bit by bit. Nothing has changed where it is refused."""

@final
class Tracker:
    """Follows live parameters of a parametric model while it moves: an extended Kalman filter over the modal motion
    and the parameters. `File.tracker` makes one, at rest. It belongs to one thread at a time."""

    def step(self, amplitudes: _Vector, measured: _Vector) -> None:
        """Takes a step: the amplitudes of the loads at its end, to which they change linearly from those of the step
        before (0 at first), and the measured number of each sensor at its end. A number that is not finite is left
        out."""
    @property
    def estimates(self) -> dict[str, float]:
        """Estimates of the tracked parameters, by name."""
    @property
    def deviations(self) -> dict[str, float]:
        """Standard deviations of the estimates, by name: relative where the range of the parameter lies above 0, and
        else in its unit."""
    def take_consistency(self) -> Optional[float]:
        """Takes the mean square of the innovations over their variances since the last call: near 1 where model, noise
        and drift are what they are said to be; `None` before anything was measured."""

@final
class File:
    @property
    def path(self) -> Path: ...
    @staticmethod
    def open(path: str, map: bool) -> File: ...
    @staticmethod
    def from_bytes(bytes: bytes, name: str) -> File: ...
    def bytes(self) -> bytes: ...
    def info(self) -> str: ...
    def page(self) -> str: ...
    def geometry(self) -> tuple[NDArray[np.float64], NDArray[np.uint32]]: ...
    def embedded(self) -> Optional[tuple[NDArray[np.uint32], NDArray[np.float64], NDArray[np.uint32]]]: ...
    def body(self, dtype: DTypeLike, flight: bool, options: Optional[dict[str, Any]]) -> Body: ...
    def batch(self, instances: int, dtype: DTypeLike, options: Optional[dict[str, Any]]) -> Batch: ...

def build(problem: _Given, settings: Mapping[str, Any], progress: _Progress) -> tuple[File, str]: ...
def run(
    file: File, scenario: _Given, options: Optional[dict[str, Any]], long: bool, progress: _Progress
) -> tuple[list[list[str]], dict[str, NDArray[np.float64]]]: ...
def verify(
    file: File,
    problem: _Given,
    scenario: _Given,
    options: Optional[dict[str, Any]],
    long: bool,
    progress: _Progress,
) -> str: ...
def check(file: File) -> str: ...
def frf(
    file: File, force: str, outputs: Sequence[str], spacing: Mapping[str, Any], quantity: str, options: Optional[dict[str, Any]]
) -> tuple[NDArray[np.float64], NDArray[np.float64], str]: ...
def state_space(
    file: File, inputs: Sequence[str], outputs: Sequence[str], options: Optional[dict[str, Any]]
) -> tuple[dict[str, NDArray[np.float64]], str]: ...
def sensitivities(
    file: File, modes: Optional[int], given: _Pairs
) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]: ...
def tangents(
    file: File,
    loads: Sequence[_Load],
    amplitudes: NDArray[np.float64],
    field: str,
    modes: Optional[int],
    given: _Pairs,
) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]: ...
def vjp(
    file: File,
    loads: Sequence[_Load],
    amplitudes: NDArray[np.float64],
    settings: Mapping[str, Any],
    given: _Pairs,
) -> KeptMarch: ...
def tracker(
    file: File,
    sensors: _Pairs,
    tracked: Sequence[tuple[str, tuple[float, float]]],
    loads: Sequence[_Load],
    settings: Mapping[str, Any],
    given: _Pairs,
) -> Tracker: ...
def mesh(path: str) -> str: ...
def init(
    mesh: str,
    material: Optional[str],
    scale: Optional[float],
    cells: Optional[int],
    support: tuple[Optional[str], Optional[str]],
    progress: _Progress,
) -> str: ...
def report(file: str, output: str, compared: Optional[Sequence[str]], progress: _Progress) -> None: ...
def modes(
    problem: _Given, count: int, mesh_error: tuple[bool, Optional[float]], progress: _Progress
) -> str: ...
def program(arguments: Sequence[str]) -> int: ...
