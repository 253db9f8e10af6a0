"""What a file, a run or a verification says, as data classes.

A number that is not finite, or that the file does not have, is `None`, as in the program's JSON.
"""

from __future__ import annotations

import dataclasses
import types
import typing
from dataclasses import dataclass
from typing import Any, Optional, TypeVar, Union

T = TypeVar("T")


def read(kind: type[T], values: dict[str, Any]) -> T:
    """A data class from a mapping, with all that is nested in it. Keys that it does not have are left out."""
    hints = typing.get_type_hints(kind)
    known = {field.name for field in dataclasses.fields(kind)}  # type: ignore[arg-type]
    return kind(**{key: _value(hints[key], value) for key, value in values.items() if key in known})


def _value(kind: Any, value: Any) -> Any:
    if value is None:
        return None
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if origin in (Union, types.UnionType):
        return _value(next(a for a in arguments if a is not type(None)), value)
    if origin is tuple:
        kinds = [arguments[0]] * len(value) if arguments[-1] is Ellipsis else arguments
        return tuple(_value(k, v) for k, v in zip(kinds, value))
    if dataclasses.is_dataclass(kind):
        return read(typing.cast(type, kind), value)
    return value


@dataclass(frozen=True)
class Parameter:
    """A live parameter: a number that stays free until a body is bound, and while it moves."""

    name: str
    unit: str
    role: str
    log: bool
    lower: float
    upper: float
    nominal: float

    @property
    def range(self) -> tuple[float, float]:
        """Smallest and largest value, both allowed."""
        return (self.lower, self.upper)


@dataclass(frozen=True)
class Axis:
    """An axis of the separated solution."""

    name: str
    unit: str
    role: str
    kind: str
    log: bool
    lower: float
    upper: float
    points: int


@dataclass(frozen=True)
class Structure:
    """What the build measured of one structure of the step."""

    trajectory_error: Optional[float] = None
    projection_floor: Optional[float] = None
    floor_ratio: Optional[float] = None
    spectral_radius: Optional[float] = None
    energy_ratio: Optional[float] = None
    energy_growth: Optional[float] = None
    reciprocity: Optional[float] = None
    map_error_rms: Optional[float] = None
    map_error_max: Optional[float] = None
    steps: Optional[float] = None


@dataclass(frozen=True)
class Bound:
    """The share of a static answer that the modes leave out, over loadable nodes and directions."""

    worst: float
    median: float
    p95: float
    kind: str


@dataclass(frozen=True)
class Certificate:
    """What the build measured about the file, worst values over the box of the live parameters."""

    terms: int
    map_error_rms: Optional[float]
    map_error_max: Optional[float]
    spectral_radius_max: Optional[float]
    trajectory_error_max: Optional[float]
    trajectory_floor_max: Optional[float]
    energy_ratio_max: Optional[float]
    good_for_steps: Optional[float]
    repairs: tuple[str, ...]
    diagonal: Optional[Structure]
    block: Optional[Structure]
    bound: Optional[Bound]


@dataclass(frozen=True)
class Section:
    """A section of the file, and how it is stored."""

    kind: str
    element: str
    codec: str
    shape: tuple[int, int, int]
    stored_bytes: int
    decoded_bytes: int


@dataclass(frozen=True)
class FreeBody:
    """A body without supports, in the coordinates of the file: mass in kg, centre in m, moments of inertia in kg m²."""

    mass: float
    centre: tuple[float, float, float]
    principal_moments: tuple[float, float, float]
    principal_axes: tuple[tuple[float, float, float], ...]


@dataclass(frozen=True)
class Quantity:
    """A quantity that `Body.read` gives: how many there are, numbers of each, and units."""

    name: str
    text: str
    count: int
    length: int
    unit: str
    #: Unit of its velocity; `None` where it has none.
    velocity_unit: Optional[str]

    @property
    def is_scalar(self) -> bool:
        """Tells quantities of one number."""
        return self.length == 1


@dataclass(frozen=True)
class Support:
    """A support whose reaction a file gives; moments are about the point, in m."""

    name: str
    point: tuple[float, float, float]


@dataclass(frozen=True)
class Info:
    """Everything a file says about itself: what `vademecum info FILE --json` prints."""

    file_bytes: int
    format: str
    program: str
    units: str
    mesh_hash: str
    nodes: int
    surface_nodes: int
    loadable_nodes: int
    triangles: int
    modes: int
    scheme: str
    stages: int
    time_step: float
    alpha: float
    beta: float
    damping_ratios: tuple[float, ...]
    structures: tuple[str, ...]
    terms: int
    axes: tuple[Axis, ...]
    parameters: tuple[Parameter, ...]
    load_patterns: tuple[str, ...]
    probes: tuple[str, ...]
    supports: tuple[Support, ...]
    certificate: Certificate
    sections: tuple[Section, ...]
    problem: str
    free_body: Optional[FreeBody] = None

    @property
    def precision(self) -> str:
        """How the file stores the motion of its surface, as NumPy names it."""
        names = {"F32": "float32", "F64": "float64", "I16": "int16"}
        return next((names[s.element] for s in self.sections if s.kind == "SurfaceBasis"), "none")

    def parameter(self, name: str) -> Parameter:
        """The live parameter of this name."""
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        known = ", ".join(f"`{p.name}`" for p in self.parameters) or "none"
        raise KeyError(f"the file has no live parameter `{name}`; it has {known}")


@dataclass(frozen=True)
class NaturalModes:
    """The lowest natural modes of a problem, one number per mode in each tuple."""

    dofs: int
    time_step: float
    proposed_time_step: float
    frequencies_hz: tuple[float, ...]
    residuals: tuple[float, ...]
    material_damping: tuple[float, ...]
    scheme_damping: tuple[Optional[float], ...]
    period_elongation: tuple[Optional[float], ...]
    #: Mass of the nodes that are free along x, y and z [kg].
    free_mass: tuple[float, float, float]
    #: Participation factors along x, y and z [kg^½], for modes of modal mass 1.
    participation: tuple[tuple[float, float, float], ...]
    #: Effective modal masses along x, y and z, as shares of the free mass.
    effective_mass: tuple[tuple[float, float, float], ...]


@dataclass(frozen=True)
class ParameterValue:
    """A live parameter and its value."""

    name: str
    value: float


@dataclass(frozen=True)
class Verification:
    """A scenario at full order beside the same through the file: what `vademecum verify --json` prints."""

    steps: int
    dofs: int
    modes: int
    structure: str
    time_step: float
    parameters: tuple[ParameterValue, ...]
    trajectory_error: Optional[float]
    projection_floor: Optional[float]
    floor_ratio: Optional[float]
    total_error: Optional[float]
    time_error: Optional[float]
    basis_error: Optional[float]
    rest_error: Optional[float]
    contact_error: Optional[float]
    truth_error: Optional[float]
    truth_vectors: Optional[int]
    bound: Optional[Bound]
    spectral_radius: Optional[float]
    energy_drift: Optional[float]
    energy_drift_full_order: Optional[float]
    energy_ratio: Optional[float]
    full_order_seconds_per_step: float
    vademecum_seconds_per_step: float


@dataclass(frozen=True)
class Soundness:
    """What `vademecum verify FILE --file-only` finds of a sound file; an unsound one is a `FileError`."""

    bytes: int
    sections: int
    unknown_sections: int
    decoded_bytes: int
    numbers: int
    spectral_radius: Optional[float]
    settings: int
    corners_left_out: int
