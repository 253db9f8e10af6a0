"""What a file, a run or a verification says, as data classes.

A number that is not finite, or that the file does not have, is `None`, as in the program's JSON.
"""

from __future__ import annotations

import dataclasses
import html
import os
import types
import typing
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Optional, TypeVar, Union

import numpy as np
from numpy.typing import NDArray

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
    # JSON has steps as numbers of any kind; what is counted is whole.
    return int(value) if kind is int else value


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
    steps: Optional[int] = None


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
    good_for_steps: Optional[int]
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


class Gradient(NamedTuple):
    """Derivatives of a scalar of a kept march with respect to all that the march depends on."""

    #: To the amplitudes of the loads, in the shape that they were given in.
    amplitudes: NDArray[np.float64]
    #: To the parameters, by name: live ones, or stiffness, density, alpha, beta and time_step of the whole body.
    parameters: dict[str, float]
    #: To the force of each load, shape (loads, 3); not a number for load patterns.
    forces: NDArray[np.float64]
    #: To the place of each load along its triangle [1/m], shape (loads, 3); not a number for load patterns, and for
    #: places that are no points of a triangle.
    places: NDArray[np.float64]
    #: To the coordinates of the modes at the start, and to their velocity.
    zeta: NDArray[np.float64]
    velocity: NDArray[np.float64]


class BodyGradient(NamedTuple):
    """Derivatives of a scalar of a march of a body, of which a load goes from its start to its end in each step."""

    #: To the force at each place, shape (steps, places, 2, 3): at the start and at the end of each step.
    forces: NDArray[np.float64]
    #: To the amplitude of each load pattern, shape (steps, patterns, 2), alike.
    patterns: NDArray[np.float64]
    #: To the reduced coordinates at the start, and to their velocity.
    zeta: NDArray[np.float64]
    velocity: NDArray[np.float64]


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


@dataclass(frozen=True, eq=False)
class Contacts:
    """Contacts of a step of a `World`: nodes of one part near the surface of another."""

    #: Numbers of the part of the node and of the part of the surface, shape (contacts, 2).
    parts: NDArray[np.uint32]
    #: Positions of the nodes in space [m], shape (contacts, 3).
    position: NDArray[np.float64]
    #: Outward normals of the surfaces, shape (contacts, 3).
    normal: NDArray[np.float64]
    #: Forces on the nodes [N], held over the step, shape (contacts, 3); on the surfaces act their opposites.
    force: NDArray[np.float64]
    #: Normal forces [N]; 0 of a node that is near and does not touch.
    pressure: NDArray[np.float64]
    #: Gaps at the end of the step [m]; below 0 where they overlap.
    gap: NDArray[np.float64]
    #: Slips over the step [m], shape (contacts, 3).
    slip: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.gap)


@dataclass(frozen=True)
class StepReport:
    """What `World.step` did."""

    #: Number of steps.
    steps: int
    #: Pairs of nodes and surfaces that were near each other in the last step.
    contacts: int
    #: Those that carry a force.
    pressed: int
    #: Sweeps of the solutions, in all steps.
    sweeps: int
    #: Steps in which there was no room for a contact.
    steps_without_room: int
    #: Steps whose solution was not within the tolerance.
    steps_not_converged: int
    #: Deepest overlap at the end of a step [m].
    worst_gap: float
    #: Energy that contacts took from the parts [J].
    energy_given_away: float


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
    damping_rows: int
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

    def _rows(self) -> list[tuple[str, str]]:
        """A summary: everything else is in the fields."""
        bound, made = self.certificate.bound, self.free_body
        ranges = [f"{p.name}: {p.lower:g} to {p.upper:g} {p.unit}".rstrip() for p in self.parameters]
        rows = [
            ("file", f"{self.file_bytes} bytes, {self.format}, made by {self.program}"),
            ("nodes", f"{self.nodes}, {self.surface_nodes} on the surface, {self.loadable_nodes} loadable"),
            ("modes", str(self.modes)),
            ("step", f"{self.time_step:g} s, {self.scheme}; structures: {', '.join(self.structures)}"),
            ("damping", f"alpha {self.alpha:g} 1/s, beta {self.beta:g} s, {len(self.damping_ratios)} ratios"),
            ("error bound", f"any point load: median {bound.median:.2g}, 95 % below {bound.p95:.2g}" if bound else ""),
            ("parameters", "; ".join(ranges)),
            ("load patterns", ", ".join(self.load_patterns)),
            ("probes", ", ".join(self.probes)),
            ("supports", ", ".join(support.name for support in self.supports)),
            ("free body", f"{made.mass:g} kg" if made else ""),
            ("units", self.units),
        ]
        return [(name, text) for name, text in rows if text]

    def __str__(self) -> str:
        return "\n".join(f"{name:<15}{text}" for name, text in self._rows())

    def _repr_html_(self) -> str:
        cell = "<tr><th style='text-align:left'>{}</th><td style='text-align:left'>{}</td></tr>"
        rows = (cell.format(html.escape(name), html.escape(text)) for name, text in self._rows())
        return f"<table>{''.join(rows)}</table>"


@dataclass(frozen=True)
class RefinedValue:
    """A value of the mesh beside the one without discretisation error, as estimated."""

    mesh: float
    refined: float
    #: Relative error of the value on this mesh; positive is too high.
    error: float
    #: Magnitude that the error does not exceed in 95 %.
    bound: float


@dataclass(frozen=True)
class DiscDisplacement(RefinedValue):
    """The mean displacement [m] of a disc of the surface under one newton along its normal."""

    point: tuple[float, float, float]
    normal: tuple[float, float, float]
    radius: float


@dataclass(frozen=True)
class DiscretisationEstimate:
    """The discretisation error of a body, or the reason why it is not known."""

    #: The lowest natural frequencies [Hz].
    frequencies: tuple[RefinedValue, ...] = ()
    displacement: Optional[DiscDisplacement] = None
    #: A support ends inside a smooth face.
    smooth_rim: bool = False
    #: Held nodes in no held face.
    nodes_without_area: int = 0
    #: A support ends between nodes: another mesh holds another part of the body.
    support_between_nodes: bool = False
    reason: Optional[str] = None


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
    #: Where it was asked for.
    mesh_error: Optional[DiscretisationEstimate] = None


@dataclass(frozen=True)
class Peak:
    """The largest amplitude of an output, and its frequency in Hz."""

    amplitude: float
    frequency_hz: float


@dataclass(frozen=True)
class Region:
    """A region of a mesh."""

    tag: int
    name: str
    elements: int
    volume: float


@dataclass(frozen=True)
class Group:
    """A group of a mesh; one of nodes alone has no facets."""

    name: str
    nodes: int
    facets: int


@dataclass(frozen=True)
class ElementCount:
    """Elements of a kind in a mesh, such as `20-node hexahedron`."""

    kind: str
    elements: int


@dataclass(frozen=True)
class Quality:
    """Shape quality of elements, 1 of a regular one, and the corners of the worst as the mesh file numbers them."""

    min: float
    mean: float
    histogram: tuple[int, ...]
    worst: Optional[tuple[int, ...]]


@dataclass(frozen=True)
class MeshReport:
    """What a mesh file holds: what `vademecum mesh --json` prints. Lengths are in the unit of the mesh."""

    file: str
    format: str
    nodes: int
    elements: int
    #: 0 where elements of several kinds have several numbers.
    nodes_per_element: int
    kinds: tuple[ElementCount, ...]
    unused_nodes: int
    reoriented_elements: int
    bounding_box: tuple[tuple[float, float, float], tuple[float, float, float]]
    volume: float
    regions: tuple[Region, ...]
    groups: tuple[Group, ...]
    quality: Quality
    #: What keeps it from being built, in sentences; empty of a sound mesh.
    problems: tuple[str, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Starter:
    """A problem that `init` proposes for a mesh: `build` takes it, `save` writes it to be changed."""

    #: The text of a problem file, with comments.
    text: str
    #: Metres in a unit of the mesh.
    scale: float
    longest_side: float
    support: str
    #: Axis that points up.
    up: str
    material: str
    #: Linear tetrahedra get mid-side nodes.
    raised: bool
    #: Error of the frequencies on the linear elements of the file; `None` of a mesh of other elements than linear tetrahedra.
    linear_mesh_error: Optional[DiscretisationEstimate]
    #: First natural frequency in Hz.
    frequency: float
    time_step: float
    modes: int
    dofs: int

    def save(self, path: Union[str, os.PathLike[str]]) -> Path:
        """Writes the problem file; one that is there is replaced."""
        path = Path(path)
        path.write_text(self.text, encoding="utf-8")
        return path


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
    #: Under each contact, in the order of the scenario; `None` of one that moves nothing.
    contact_errors: tuple[Optional[float], ...]
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
