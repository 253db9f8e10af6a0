"""The part of the package that is written in Rust."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Optional, Union, final

import numpy as np
from numpy.typing import DTypeLike, NDArray

__all__ = [
    "__version__", "Batch", "File", "Flight", "Motion", "SurfacePoint", "Scene", "build", "check", "modes", "program", "run",
    "verify",
]

__version__: str

_Vector = Union[Sequence[float], NDArray[np.floating[Any]]]
_Place = Union["SurfacePoint", _Vector]
_Values = Optional[dict[str, float]]
_Given = tuple[str, str, str]
_Progress = Optional[Callable[[str, int, int], object]]

@final
class SurfacePoint:
    """A point of the surface: three nodes, in the order of the file, and their weights."""

    def __new__(
        cls,
        nodes: Sequence[int],
        weights: Sequence[float] = ...,
        position: Sequence[float] = ...,
        distance: float = 0.0,
    ) -> SurfacePoint: ...
    @property
    def nodes(self) -> tuple[int, int, int]: ...
    @property
    def weights(self) -> tuple[float, float, float]: ...
    @property
    def position(self) -> tuple[float, float, float]:
        """Where it is at rest [m]; of a picked point, where it is in the picture."""
    @property
    def distance(self) -> float:
        """Distance from the point that was asked for [m]."""

@final
class Scene:
    """A body that moves, bound to live parameters, with its loads. It belongs to one thread at a time.

    Methods with `out` write into that array, which has the right shape and type and is C-contiguous; a row of a
    larger array will do. Without `out` they make a new array. Nothing is copied either way. `field` is
    "displacement" [m] or "velocity" [m/s].
    """

    @property
    def dtype(self) -> np.dtype[Any]: ...
    @property
    def structure(self) -> str: ...
    @property
    def time_step(self) -> float:
        """Length of a step [s]."""
    @property
    def modes(self) -> int: ...
    @property
    def probe_names(self) -> list[str]: ...
    @property
    def pattern_names(self) -> list[str]: ...
    @property
    def support_names(self) -> list[str]:
        """Supports whose reactions the file gives."""
    @property
    def parameters(self) -> dict[str, float]:
        """Values of the live parameters, by name."""
    def set(self, values: _Values = None, /, **parameters: float) -> None:
        """Sets live parameters while the body moves: displacement, velocity and loads stay. All of them are set, or
        none if one is refused."""
    def locate(self, point: _Vector) -> SurfacePoint:
        """The nearest point of the loadable surface at rest."""
    def pick(self, origin: _Vector, direction: _Vector, scale: float = 1.0) -> Optional[SurfacePoint]:
        """What a ray meets first on the surface as it has moved, magnified by `scale`."""
    def contact(self, at: _Place, force: _Vector) -> SurfacePoint:
        """Adds a force [N] at a point of the surface, or at the nearest one to a point in space. It stays until
        `clear`. Contacts add up."""
    def pattern(self, name: str, amplitude: float = 1.0) -> None:
        """Adds a load pattern of the file, times an amplitude. It stays until `clear`."""
    def base(
        self,
        acceleration: _Vector = ...,
        angular_velocity: _Vector = ...,
        angular_acceleration: _Vector = ...,
    ) -> None:
        """Adds the inertia of a base that moves so, in its own axes. It stays until `clear`."""
    def clear(self) -> None:
        """Takes all loads away."""
    def rest(self) -> None:
        """Puts the body at rest. Loads stay, and the next step is a first one."""
    def step(self, steps: int = 1) -> bool:
        """Moves on by so many steps, while other threads of Python run. Whether the body still moves."""
    def march(self, steps: int, every: int = 1, field: str = "displacement") -> NDArray[np.float64]:
        """`step`, with a row of all probes after each `every` steps: shape (steps // every, probes)."""
    def probe(self, name: str, field: str = "displacement") -> float:
        """A probe of the file."""
    def probes(
        self, field: str = "displacement", out: Optional[NDArray[np.float64]] = None
    ) -> NDArray[np.float64]:
        """All probes in the order of `probe_names`."""
    def point(
        self, at: _Place, field: str = "displacement", out: Optional[NDArray[np.float64]] = None
    ) -> NDArray[np.float64]:
        """A point of the surface, three numbers."""
    def node(
        self, node: int, field: str = "displacement", out: Optional[NDArray[np.float64]] = None
    ) -> NDArray[np.float64]:
        """A node, three numbers."""
    def surface(self, field: str = "displacement", out: Optional[NDArray[Any]] = None) -> NDArray[Any]:
        """The nodes of the surface, shape (surface nodes, 3), in the precision of the scene."""
    def body(self, field: str = "displacement", out: Optional[NDArray[Any]] = None) -> NDArray[Any]:
        """All nodes, shape (nodes, 3), in the precision of the scene."""
    def reaction(self, name: str) -> NDArray[np.float64]:
        """Force [N] and moment [N m] that a support exerts on the body, six numbers."""
    @property
    def stress_points(self) -> NDArray[np.uint32]:
        """Where the file has a stress: node of the file and region of the mesh, shape (points, 2)."""
    def stress(self) -> NDArray[np.float64]:
        """Stress [Pa] at these points: xx, yy, zz, xy, yz, zx, shape (points, 6)."""
    def strain(self) -> NDArray[np.float64]:
        """Strain at these points, with the shear strains of the tensor, shape (points, 6)."""
    def von_mises(self) -> NDArray[np.float64]:
        """Von Mises' equivalent stress [Pa] at these points."""
    @property
    def energy(self) -> float:
        """Kinetic and elastic energy [J]."""
    def save(self, out: Optional[NDArray[Any]] = None) -> NDArray[Any]:
        """The state, to be kept: an array that can be pickled. Loads are not part of it."""
    def restore(self, saved: NDArray[Any]) -> None:
        """Takes back what `save` gave at the same time step, bit for bit."""
    def place(self, zeta: _Vector, velocity: Optional[_Vector] = None) -> None:
        """Sets reduced coordinates and their velocity, one number per mode."""
    def compliance(self, points: Sequence[_Place]) -> NDArray[np.float64]:
        """How the points yield to forces held over the coming step, shape (3n, 3n) [m/N]: number (3c + i, 3d + j) is
        the displacement of point c along i for each newton at point d along j."""
    def free_motion(self, points: Sequence[_Place]) -> NDArray[np.float64]:
        """Where the points will be at the end of the coming step under the loads as they are, shape (n, 3) [m]."""

@final
class Motion:
    """Where a free body is in space, how it is turned, and its momenta."""

    def __new__(
        cls,
        position: _Vector,
        attitude: _Vector = ...,
        momentum: _Vector = ...,
        angular_momentum: _Vector = ...,
    ) -> Motion: ...
    @property
    def position(self) -> tuple[float, float, float]:
        """Where the centre is [m]."""
    @property
    def attitude(self) -> tuple[float, float, float, float]:
        """A quaternion of length one, the real part first, that turns directions of the body into those of space."""
    @property
    def momentum(self) -> tuple[float, float, float]:
        """In space [kg m/s]."""
    @property
    def angular_momentum(self) -> tuple[float, float, float]:
        """About the centre, in space [kg m2/s]."""

@final
class Flight:
    """The rigid motion of a body without supports, beside the elastic one, which is that of `scene`.

    Forces and positions are those of space. Forces act in the coming step, which takes them away.
    """

    def __new__(cls, scene: Scene, velocity: _Vector = ..., spin: _Vector = ...) -> Flight:
        """The body where the file has it, thrown with a velocity of its centre [m/s] and an angular velocity
        [rad/s]."""
    @property
    def scene(self) -> Scene: ...
    @property
    def mass(self) -> float:
        """At the density of the scene [kg]."""
    @property
    def moments(self) -> tuple[float, float, float]:
        """Principal moments of inertia about the centre [kg m2]."""
    @property
    def axes(self) -> NDArray[np.float64]:
        """The principal axes in the coordinates of the file, one a row."""
    @property
    def motion(self) -> Motion:
        """The rigid motion; set it to put the body elsewhere. What pushes the body stays."""
    @motion.setter
    def motion(self, motion: Motion) -> None: ...
    @property
    def ahead(self) -> Motion:
        """The rigid motion at the end of the coming step, under what pushes so far."""
    def contact(self, at: _Place, force: _Vector) -> SurfacePoint:
        """Adds a force [N] at a point of the surface, which is given as the body is at rest."""
    def pattern(self, name: str, amplitude: float = 1.0) -> None:
        """Adds a load pattern of the file, which turns with the body."""
    def pull(self, force: _Vector) -> None:
        """Adds a force [N] at the centre: gravity is the mass times its acceleration."""
    def clear(self) -> None:
        """Takes all forces away, those of the scene too."""
    def step(self) -> bool:
        """One step of both motions. Whether the body still moves."""
    def point(self, at: _Place, out: Optional[NDArray[np.float64]] = None) -> NDArray[np.float64]:
        """Where a point of the surface is, deformed as it is [m]."""
    def velocity(self, at: _Place, out: Optional[NDArray[np.float64]] = None) -> NDArray[np.float64]:
        """Velocity of a point of the surface [m/s]."""

@final
class Batch:
    """Many bodies of one file that are stepped together, at the same live parameters. `out` is as in `Scene`.

    An instance has the bits that a `Scene` with `residual=False` has alone.
    """

    def __len__(self) -> int: ...
    @property
    def time_step(self) -> float: ...
    @property
    def probe_names(self) -> list[str]: ...
    @property
    def pattern_names(self) -> list[str]: ...
    @property
    def support_names(self) -> list[str]: ...
    def reaction(self, name: str, out: Optional[NDArray[np.float64]] = None) -> NDArray[np.float64]:
        """Force [N] and moment [N m] that a support exerts on each body under its loads, shape (instances, 6)."""
    @property
    def parameters(self) -> dict[str, float]: ...
    def set(self, values: _Values = None, /, **parameters: float) -> None:
        """Sets live parameters of all instances while they move."""
    def locate(self, point: _Vector) -> SurfacePoint: ...
    def contact(self, instance: int, at: _Place, force: _Vector) -> SurfacePoint:
        """Adds a force [N] to one instance; it stays until `clear`."""
    def pattern(self, instance: int, name: str, amplitude: float = 1.0) -> None:
        """Adds a load pattern to one instance; it stays until `clear`."""
    def clear(self) -> None:
        """Takes the loads of all instances away."""
    def step(self, steps: int = 1) -> tuple[int, int, int]:
        """Moves all instances on, while other threads of Python run. How many move, rest, and kept their state
        because the next would not be finite."""
    def probes(
        self, field: str = "displacement", out: Optional[NDArray[np.float64]] = None
    ) -> NDArray[np.float64]:
        """Shape (instances, probes)."""
    def energy(self, out: Optional[NDArray[np.float64]] = None) -> NDArray[np.float64]:
        """Of each instance [J]."""
    def surface(
        self, instance: int, field: str = "displacement", out: Optional[NDArray[Any]] = None
    ) -> NDArray[Any]:
        """The surface of one instance, shape (surface nodes, 3)."""
    def body(
        self, instance: int, field: str = "displacement", out: Optional[NDArray[Any]] = None
    ) -> NDArray[Any]:
        """All nodes of one instance, shape (nodes, 3)."""

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
    def scene(self, dtype: DTypeLike, options: Optional[dict[str, Any]]) -> Scene: ...
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
def modes(problem: _Given, count: int, progress: _Progress) -> str: ...
def program(arguments: Sequence[str]) -> int: ...
