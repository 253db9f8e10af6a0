"""Elastic bodies that move in real time.

    import vademecum

    file = vademecum.open("body.vdm")
    body = file.body()
    finger = body.push([0.93, 0.03, 0.1], force=[0.0, 0.0, -20.0])
    body.step(1000)
    body.point(finger)           # displacement in m

Units are those of the file, SI unless `info.units` says otherwise.
"""

from __future__ import annotations

import functools
import html
import json
import os
import tempfile

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Optional, Union

import numpy as np
from numpy.typing import DTypeLike, NDArray

from . import _native
from ._arrays import blocks_of_meshio, write_mesh
from ._data import (
    Axis,
    BodyGradient,
    Bound,
    Certificate,
    Contacts,
    DiscDisplacement,
    DiscretisationEstimate,
    ElementCount,
    FreeBody,
    Gradient,
    Group,
    Info,
    MeshReport,
    NaturalModes,
    Parameter,
    ParameterValue,
    Peak,
    Quality,
    Quantity,
    RefinedValue,
    Region,
    Section,
    Soundness,
    Starter,
    StepReport,
    Structure,
    Support,
    Verification,
    read,
)
from ._errors import (
    Error,
    FileError,
    InputError,
    MachineError,
    MeshError,
    MissingFile,
    Note,
    NumericsError,
    ToleranceMissed,
)
from ._native import Batch, Body, KeptMarch, Motion, SurfacePoint, Tracker, World

__version__ = _native.__version__

__all__ = [
    "Axis", "Batch", "Body", "BodyGradient", "Bound", "Certificate", "Contacts", "DiscDisplacement",
    "DiscretisationEstimate", "ElementCount", "Error", "File", "FileError", "FreeBody", "FrequencyResponse",
    "Gradient", "Group", "Info", "InputError", "KeptMarch", "MachineError", "MeshError", "MeshReport",
    "MissingFile", "Motion",
    "NaturalModes", "Note", "NumericsError", "Page", "Parameter", "ParameterValue", "Peak", "Played",
    "Quality", "Quantity", "RefinedValue", "Region", "Section", "Slopes", "Soundness", "Starter",
    "StateSpace", "StepReport", "Structure", "Support", "SurfacePoint", "ToleranceMissed", "Tracker",
    "Verification", "World", "build", "frf", "from_bytes", "init", "mesh", "modes", "open",
    "problem_from_meshio", "report", "run", "verify", "write_mesh",
]


def __dir__() -> list[str]:
    return [*__all__, "__version__"]


PathLike = Union[str, "os.PathLike[str]"]
#: A path, or the keys of the file as a mapping: what `tomllib.load` would give; a problem also as `init` proposes it.
Input = Union[PathLike, Mapping[str, Any], Starter]
#: The name of a load pattern or a probe, a point and a direction ("-z", or three numbers), or their text "1,0.04,0.1,-z".
Channel = Union[str, tuple[Sequence[float], Union[str, Sequence[float]]]]
#: A channel, "velocity:CHANNEL", "acceleration:CHANNEL", "stress:X,Y,Z,xx", "reaction:SUPPORT" or "reaction:SUPPORT.fx".
OutputSignal = Channel
#: The name of a load pattern, or a place (or a point in space) and a force [N].
Load = Union[str, tuple[Union[SurfacePoint, Sequence[float]], Sequence[float]]]
#: Called with the name of the stage, how many of its pieces are done, and how many there are (0 if unknown).
Progress = Callable[[str, int, int], object]


class EmbeddedSurface(NamedTuple):
    """A surface that is drawn in place of that of the mesh: each vertex follows four nodes of the surface."""

    #: Nodes that each vertex follows, shape (vertices, 4).
    nodes: NDArray[np.uint32]
    #: Their weights, which sum to 1, shape (vertices, 4).
    weights: NDArray[np.float64]
    #: Vertices of each triangle, outward, shape (triangles, 3).
    triangles: NDArray[np.uint32]

    def interpolate(self, at_nodes: NDArray[np.float64]) -> NDArray[np.float64]:
        """Positions or displacements at the vertices, shape (vertices, 3), from those at the nodes of the surface."""
        found: NDArray[np.float64] = np.einsum("vk,vkc->vc", self.weights, np.asarray(at_nodes)[self.nodes])
        return found


class Slopes(NamedTuple):
    """Numbers of a parametric model, and their derivatives with respect to its live parameters."""

    #: Natural frequencies [Hz], or probes at the instants, shape (instants, probes).
    values: NDArray[np.float64]
    #: Their derivatives by name of the parameter, of the same shape.
    slopes: dict[str, NDArray[np.float64]]


class File:
    """A vademecum file in memory. `open`, `from_bytes` and `build` make one."""

    def __init__(self, native: _native.File, report: Optional[dict[str, Any]] = None) -> None:
        self._native = native
        #: What the build said about itself, as `vademecum build --json` prints it; `None` for an opened file.
        self.report = report

    @functools.cached_property
    def info(self) -> Info:
        """Everything the file says about itself."""
        return read(Info, json.loads(self._native.info()))

    @functools.cached_property
    def _geometry(self) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
        nodes, triangles = self._native.geometry()
        nodes.setflags(write=False)
        triangles.setflags(write=False)
        return nodes, triangles

    @property
    def nodes(self) -> NDArray[np.float64]:
        """Positions of all nodes at rest, shape (nodes, 3); those of the surface come first. Read-only."""
        return self._geometry[0]

    @property
    def triangles(self) -> NDArray[np.uint32]:
        """Triangles of the surface, shape (triangles, 3); the loadable ones come first. Read-only."""
        return self._geometry[1]

    @functools.cached_property
    def embedded(self) -> Optional[EmbeddedSurface]:
        """The surface that is drawn in place of that of the mesh; `None` where the file has none."""
        found = self._native.embedded()
        return EmbeddedSurface(*found) if found else None

    def body(self, dtype: DTypeLike = np.float64, *, flight: bool = True, **options: Any) -> Body:
        """Binds a body, at rest and without loads.

        `dtype` is the precision of the step: `float64` gives the bits of `vademecum run`, `float32` is about twice
        as fast. A body without supports flies, unless `flight` is false: its frame then stays, and loads stay, too.

        Options are `structure` ("auto", "diagonal", "block", "exact", "strain"), `time_step`, `tolerance`, `terms`,
        `rest_below`, `residual`, `contacts` and
        `filtered_nodes`; `stiffness` and `density`, scales of the whole body, and its
        Rayleigh damping `alpha` and `beta`; of large displacements `substeps` and `viscosity`; and of a file
        with live regions `modes`, the number of stepped modes (32, or all of fewer).

        All other keywords are live parameters of the file. A parameter whose name is no keyword is given with `_`
        for every other sign, or as `**{"tip stiffness": 1.5}`. `stiffness`, `density`, `alpha` and `beta` set the
        live parameter where the file has one of that name. Any other keyword that is both, an option and a
        parameter, is refused: such a parameter is set by `Body.set_parameters`.
        """
        return self._native.body(dtype, flight, options)

    def batch(self, instances: int, dtype: DTypeLike = np.float64, **options: Any) -> Batch:
        """Binds many bodies that are stepped together, at rest and without loads.

        Bodies of a file with live regions have parameters of their own and share the bytes of the file; all
        others share their parameters too.
        """
        return self._native.batch(instances, dtype, options)

    def run(
        self, scenario: Input, *, long: bool = False, progress: Optional[Progress] = None, **options: Any
    ) -> Played:
        """Plays a scenario through the file, as `vademecum run` does: the same numbers, bit for bit.

        Options are those of `body`, with "chapter" (or "canonical", the older word) as one more structure.
        """
        (names, supports, flown), arrays = _native.run(self._native, _given(scenario), options, long, progress)
        columns, held, flight = arrays.pop("probes"), arrays.pop("reactions"), arrays.pop("flight")
        return Played(
            file=self,
            probes={name: columns[:, column] for column, name in enumerate(names)},
            values=columns,
            reactions={name: held[:, support] for support, name in enumerate(supports)},
            flight={name: flight[:, column] for column, name in enumerate(flown)},
            **arrays,
        )

    def verify(
        self,
        scenario: Input,
        problem: Optional[Input] = None,
        *,
        long: bool = False,
        progress: Optional[Progress] = None,
        **options: Any,
    ) -> Verification:
        """Marches a scenario full order and through the file, and says how far apart they are.

        Without `problem`, the one that the file keeps is taken, with its mesh looked for in the working folder.
        """
        given = ("toml", self.info.problem, os.getcwd()) if problem is None else _given(problem)
        found = _native.verify(self._native, given, _given(scenario), options, long, progress)
        return read(Verification, json.loads(found))

    def frf(
        self,
        force: Channel,
        outputs: Union[Channel, list[Channel]],
        range: Optional[tuple[float, float]] = None,
        *,
        frequencies: Optional[Sequence[float]] = None,
        points: int = 1000,
        log: bool = False,
        poles: Optional[bool] = None,
        quantity: str = "displacement",
        **options: Any,
    ) -> FrequencyResponse:
        """Gives the answer of outputs to a force that swings, in closed form, as `vademecum frf` does.

        `range` is the first and the last frequency in Hz of `points`, in equal steps or with `log` in equal ratios;
        `frequencies` are others of your own. With `poles` the natural frequencies and half-power points within are
        added, as they are to a range unless it is false. `quantity` is "displacement", "velocity" or "acceleration",
        for a force of 1 N or a load pattern of amplitude 1. Options are those of `body`.
        """
        several = outputs if isinstance(outputs, list) else [outputs]
        names = [_channel(output) for output in several]
        if (range is None) == (frequencies is None):
            raise TypeError("expected either `range` or `frequencies`")
        own = np.asarray([] if frequencies is None else frequencies, np.float64)
        wanted = own if range is None else np.asarray(range, np.float64)
        if wanted.ndim != 1 or not np.isfinite(wanted).all() or (np.diff(wanted) <= 0).any():
            raise ValueError("frequencies are numbers in ascending order")
        if range is not None and len(wanted) != 2:
            raise ValueError("a range is two frequencies")
        spacing = {
            "range": range if range is None else tuple(wanted),
            "frequencies": own.tolist(),
            "points": points,
            "log": log,
            "poles": range is not None if poles is None else poles,
        }
        grid, pairs, rest = _native.frf(self._native, _channel(force), names, spacing, quantity, options)
        keys, peaks, highest = json.loads(rest)
        values = pairs.view(np.complex128)[..., 0]
        return FrequencyResponse(
            frequencies=grid,
            values=dict(zip(keys, values)),
            peaks={key: read(Peak, peak) if peak else None for key, peak in zip(keys, peaks)},
            highest_mode_hz=highest,
        )

    def state_space(
        self,
        inputs: Union[None, Channel, list[Channel]] = None,
        outputs: Union[None, OutputSignal, list[OutputSignal]] = None,
        **options: Any,
    ) -> StateSpace:
        """Gives the state-space model of the file, as `vademecum export state-space` writes it.

        An input is a point and a direction, for a force of 1 N, or the name of a load pattern ("base.ax" of a base
        that moves), or of a probe at a loadable node; without any, all load patterns are inputs. An output is a
        channel, for its displacement, or the text "velocity:CHANNEL", "acceleration:CHANNEL", "stress:X,Y,Z,xx",
        "reaction:SUPPORT" or "reaction:SUPPORT.fx"; without any, all probes and reactions are outputs. Options are
        those of `body`.
        """
        asked = [[] if given is None else given if isinstance(given, list) else [given] for given in (inputs, outputs)]
        arrays, text = _native.state_space(
            self._native, [_channel(given) for given in asked[0]], [_channel(given) for given in asked[1]], options
        )
        described = json.loads(text)
        states, inputs_of, outputs_of = (
            {signal["name"]: signal["unit"] for signal in described[side]} for side in ("states", "inputs", "outputs")
        )
        frequencies = [mode["frequency_hz"] for mode in described["modes"]]
        ratios = [mode["damping_ratio"] for mode in described["modes"]]
        return StateSpace(
            states=states,
            inputs=inputs_of,
            outputs=outputs_of,
            time_step=described["time_step"],
            frequencies=np.array(frequencies),
            damping_ratios=np.array(ratios),
            **arrays,
        )

    def sensitivities(self, modes: Optional[int] = None, /, **parameters: float) -> Slopes:
        """Gives natural frequencies in Hz and their derivatives with respect to the live parameters, at these values
        or those as built, of a file with a parametric model.

        Names of parameters are given as `body` takes them. Of equal frequencies the derivatives are those along the
        shapes found.
        """
        return Slopes(*_native.sensitivities(self._native, modes, list(parameters.items())))

    def tangents(
        self,
        loads: Sequence[Load],
        amplitudes: Any,
        *,
        field: str = "displacement",
        modes: Optional[int] = None,
        parameters: Optional[Mapping[str, float]] = None,
    ) -> Slopes:
        """Steps a parametric model from rest and gives its probes with their exact derivatives.

        A load is the name of a load pattern, or a place (or a point in space) and a force in N. `amplitudes` has a
        row for each instant from the start on, shape (instants, loads); loads are linear between them. All modes of
        the basis are stepped unless `modes` are given: with fewer the derivatives leave out that their span turns.
        """
        given = list((parameters or {}).items())
        rows = np.ascontiguousarray(amplitudes, np.float64)
        return Slopes(*_native.tangents(self._native, list(loads), rows, field, modes, given))

    def vjp(
        self,
        loads: Sequence[Load],
        amplitudes: Any,
        *,
        held: bool = False,
        field: str = "displacement",
        modes: Optional[int] = None,
        start: Optional[tuple[Sequence[float], Sequence[float]]] = None,
        parameters: Optional[Mapping[str, float]] = None,
    ) -> KeptMarch:
        """Steps the modes, and keeps the march for the gradient of any scalar of its probes.

        Loads are those of `tangents`. `amplitudes` has a row for each instant from the start on, shape (steps + 1,
        loads), and is linear between them; with `held` a row for each step, shape (steps, loads). `start` are the
        coordinates of the modes and their velocity; at rest without. `parameters` are live ones, by name, of a file
        with live regions, of which all modes of the basis are stepped unless `modes` are given; of any other file
        stiffness, density, alpha, beta and time_step of the whole body. The march is that of the modes, in float64,
        without residual flexibility.
        """
        given = list((parameters or {}).items())
        rows = np.ascontiguousarray(amplitudes, np.float64)
        pair = None if start is None else tuple(np.asarray(part, np.float64).tolist() for part in start)
        settings = {"field": field, "held": held, "modes": modes, "start": pair}
        return _native.vjp(self._native, list(loads), rows, settings, given)

    def tracker(
        self,
        sensors: Mapping[str, float],
        tracked: Mapping[str, tuple[float, float]],
        loads: Sequence[Load] = (),
        *,
        field: str = "displacement",
        load_deviation: float = 0.0,
        resolve: float = 0.01,
        modes: Optional[int] = None,
        parameters: Optional[Mapping[str, float]] = None,
    ) -> Tracker:
        """Follows live parameters of a parametric model from measured numbers, step by step.

        `sensors` gives probes the standard deviation of their noise, in the order of the measured numbers. `tracked`
        gives parameters their standard deviation at the start and what they gain in a second as a random walk,
        relative where their range lies above 0. Loads are those of `tangents`; `load_deviation` is that of unknown
        loads along each mode in N/√kg. The modes are found again when an estimate has moved by the share `resolve`.
        """
        settings = {"field": field, "load_deviation": load_deviation, "resolve": resolve, "modes": modes}
        given = list((parameters or {}).items())
        return _native.tracker(
            self._native, list(sensors.items()), list(tracked.items()), list(loads), settings, given
        )

    def save_report(
        self,
        output: PathLike = "report.html",
        *,
        problem: Optional[PathLike] = None,
        scenario: Optional[PathLike] = None,
        progress: Optional[Progress] = None,
    ) -> Path:
        """Writes a page about the file, with its figures beside it, as `vademecum report` does.

        With `problem` and `scenario`, both paths, the full-order motion is computed and compared.
        """
        if (problem is None) != (scenario is None):
            raise TypeError("a comparison takes `problem` and `scenario`")
        compared = None if problem is None or scenario is None else [os.fspath(problem), os.fspath(scenario)]
        with tempfile.TemporaryDirectory() as folder:
            # What is in memory counts, whatever became of the file on the disk.
            path = self.save(Path(folder) / (Path(self._native.path).name or "body.vdm"))
            _native.report(os.fspath(path), os.fspath(output), compared, progress)
        return Path(output)

    def check(self) -> Soundness:
        """Checks the file alone: checksums, numbers, names, geometry, a stable step. `FileError` says what is wrong."""
        return read(Soundness, json.loads(_native.check(self._native)))

    def save(self, path: PathLike) -> Path:
        """Writes the bytes of the file; a file that is there already is replaced in one step."""
        path = Path(path)
        part = path.with_name(path.name + ".part")
        part.write_bytes(self.to_bytes())
        part.replace(path)
        return path

    def to_bytes(self) -> bytes:
        """The bytes of the file."""
        return self._native.bytes()

    def to_meshio(self, **point_data: Any) -> Any:
        """The surface as a mesh of `meshio` (a package of its own), with fields such as `displacement=body.surface()`."""
        import meshio

        count = self.info.surface_nodes
        return meshio.Mesh(self.nodes[:count], [("triangle", self.triangles)], point_data=point_data)

    def view(self, height: int = 640) -> Page:
        """The body to push and to look at, in a notebook: the page that `vademecum view --export` writes."""
        return Page(self._native.page(), height)

    def __reduce__(self) -> tuple[Callable[..., File], tuple[bytes, str]]:
        return from_bytes, (self.to_bytes(), os.fspath(self._native.path))

    def __repr__(self) -> str:
        return f"<File {os.fspath(self._native.path)}: {self.info.nodes} nodes, {self.info.modes} modes>"


@dataclass(frozen=True, repr=False)
class Played:
    """What a run shows. Arrays are (instants,) or (instants, …)."""

    file: File
    #: Instants of the probes [s].
    time: NDArray[np.float64]
    #: Energy at them [J].
    energy: NDArray[np.float64]
    #: Displacement of each probe at them [m], by name: columns of `values`.
    probes: dict[str, NDArray[np.float64]]
    #: The same, shape (instants, probes).
    values: NDArray[np.float64]
    #: Force [N] and moment [N m] of each support at them, by name, shape (instants, 6).
    reactions: dict[str, NDArray[np.float64]]
    #: The columns of `vademecum run` for a free body that was thrown, by name; none of any other.
    flight: dict[str, NDArray[np.float64]]
    #: Instants of the fields [s]; none if the scenario asks for no fields.
    field_time: NDArray[np.float64]
    #: Displacement of the nodes at them [m], shape (instants, nodes, 3).
    displacement: NDArray[np.float64]
    #: Velocity [m/s], alike.
    velocity: NDArray[np.float64]

    def to_meshio(self, instant: int = -1) -> Any:
        """The surface at one of the instants of `field_time`, with its displacement and velocity."""
        count = self.file.info.surface_nodes
        fields = {"displacement": self.displacement[instant, :count], "velocity": self.velocity[instant, :count]}
        return self.file.to_meshio(**fields)

    def __repr__(self) -> str:
        return f"<Played: {len(self.time)} instants of {', '.join(self.probes) or 'no probes'}>"


@dataclass(frozen=True, repr=False)
class FrequencyResponse:
    """The answer of outputs to a force that swings."""

    #: Frequencies [Hz].
    frequencies: NDArray[np.float64]
    #: Complex amplitudes at them, by the name of the output.
    values: dict[str, NDArray[np.complex128]]
    #: Largest amplitudes, refined between the frequencies.
    peaks: dict[str, Optional[Peak]]
    #: Highest natural frequency of the file [Hz]; the answer is good up to about half of it.
    highest_mode_hz: float

    def __repr__(self) -> str:
        return f"<FrequencyResponse of {', '.join(self.values)} at {len(self.frequencies)} frequencies>"


@dataclass(frozen=True, repr=False)
class StateSpace:
    """State-space model of a file: `x' = A x + B u`, `y = C x + D u`, and the exact map of a step.

    A step takes inputs as linear in time: `x+ = Ad x + Bd_start u + Bd_end u+`. Under held inputs that is
    `x+ = Ad x + Bd_held u`. The state `w = x - Bd_end u` needs no input of the future: `w+ = Ad w + Bd_linear u`,
    `y = C w + Dd_linear u`.
    """

    #: Units of the states by name: coordinates, velocities, filtered inputs.
    states: dict[str, str]
    #: Units of the inputs by name.
    inputs: dict[str, str]
    #: Units of the outputs by name.
    outputs: dict[str, str]
    #: Length of a step in s.
    time_step: float
    #: Natural frequencies [Hz].
    frequencies: NDArray[np.float64]
    #: Damping ratios of the modes.
    damping_ratios: NDArray[np.float64]
    #: The matrices by their names in files of `vademecum export state-space`.
    A: NDArray[np.float64]
    B: NDArray[np.float64]
    C: NDArray[np.float64]
    D: NDArray[np.float64]
    Ad: NDArray[np.float64]
    Bd_start: NDArray[np.float64]
    Bd_end: NDArray[np.float64]
    Bd_held: NDArray[np.float64]
    Bd_linear: NDArray[np.float64]
    Dd_linear: NDArray[np.float64]

    @property
    def continuous(self) -> tuple[NDArray[np.float64], ...]:
        """A, B, C, D, as `scipy.signal.StateSpace` and `control.ss` take them."""
        return (self.A, self.B, self.C, self.D)

    @property
    def held(self) -> tuple[NDArray[np.float64], ...]:
        """The four matrices of steps under held inputs, as `scipy.signal.dlti` and `control.ss` take them."""
        return (self.Ad, self.Bd_held, self.C, self.D)

    @property
    def linear(self) -> tuple[NDArray[np.float64], ...]:
        """The four matrices of steps under inputs that are linear between the instants."""
        return (self.Ad, self.Bd_linear, self.C, self.Dd_linear)

    def __repr__(self) -> str:
        sizes = (len(self.states), len(self.inputs), len(self.outputs))
        return "<StateSpace with {} states, {} inputs and {} outputs>".format(*sizes)


@dataclass(frozen=True, repr=False)
class Page:
    """A page that a notebook shows in a frame."""

    html: str
    height: int

    def save(self, path: PathLike) -> Path:
        """Writes the page: it works from disk and without network."""
        path = Path(path)
        path.write_text(self.html, encoding="utf-8")
        return path

    def _repr_html_(self) -> str:
        style = f"width:100%;height:{self.height}px;border:0"
        return f'<iframe style="{style}" allow="fullscreen" srcdoc="{html.escape(self.html, quote=True)}"></iframe>'

    def __repr__(self) -> str:
        return f"<Page of {len(self.html)} characters>"


def open(path: PathLike, *, map: bool = False) -> File:
    """Opens a vademecum file. Its bytes are copied, so whatever becomes of the file on the disk, they stay.

    With `map=True` the file is mapped into memory, for files too large to copy. You promise that nobody, in this
    process or another, shortens or overwrites it meanwhile: that would end Python or give wrong numbers.
    """
    return File(_native.File.open(os.fspath(path), map))


def from_bytes(data: Union[bytes, bytearray, memoryview], name: PathLike = "body.vdm") -> File:
    """A vademecum file from its bytes, which are copied. `name` is for messages."""
    return File(_native.File.from_bytes(bytes(data), os.fspath(name)))


def build(
    problem: Input,
    *,
    work: Optional[PathLike] = None,
    fresh: bool = False,
    repair: bool = False,
    keep_missed: bool = False,
    long: bool = False,
    memory: Optional[int] = None,
    folder: Optional[PathLike] = None,
    progress: Optional[Progress] = None,
) -> File:
    """Computes a vademecum from a problem: the path of a problem file, or its keys as a mapping.

    `work` is a folder for finished stages: a build that was stopped goes on from there, and after a change only
    what depends on it is computed again. The other options are those of `vademecum build`. The paths of a mapping
    are looked for in `folder`, the working folder if it is absent. Ctrl-C ends the build, and so does an exception
    of `progress`.
    """
    settings = {
        "work": None if work is None else os.fspath(work),
        "fresh": fresh,
        "repair": repair,
        "long": long,
        "keep_missed": keep_missed,
        "memory": memory,
    }
    native, report = _native.build(_given(problem, folder), settings, progress)
    return File(native, json.loads(report))


def run(file: Union[File, PathLike], scenario: Input, **options: Any) -> Played:
    """Plays a scenario through a file: `File.run`."""
    return (file if isinstance(file, File) else open(file)).run(scenario, **options)


def verify(
    file: Union[File, PathLike], scenario: Input, problem: Optional[Input] = None, **options: Any
) -> Verification:
    """Compares a file with its problem at full order: `File.verify`."""
    return (file if isinstance(file, File) else open(file)).verify(scenario, problem, **options)


def frf(file: Union[File, PathLike], *arguments: Any, **options: Any) -> FrequencyResponse:
    """The answer of a file to a force that swings: `File.frf`."""
    return (file if isinstance(file, File) else open(file)).frf(*arguments, **options)


def report(file: Union[File, PathLike], output: PathLike = "report.html", **options: Any) -> Path:
    """Writes a page about a file: `File.save_report`."""
    return (file if isinstance(file, File) else open(file)).save_report(output, **options)


def mesh(path: PathLike) -> MeshReport:
    """Reads a mesh file: counts, groups, bounding box, quality and every problem found. `MeshError`: no mesh at all."""
    return read(MeshReport, json.loads(_native.mesh(os.fspath(path))))


def init(
    mesh: PathLike,
    *,
    material: Optional[str] = None,
    scale: Optional[float] = None,
    cells: Optional[int] = None,
    hold: Optional[str] = None,
    up: Optional[str] = None,
    progress: Optional[Progress] = None,
) -> Starter:
    """Proposes a problem for a mesh or a surface, as `vademecum init` does: unit, support, material, time step and modes.

    `scale` is how many metres a unit of the mesh has; without it, it is guessed from the size of the body.
    `material` is steel by default, or rubber where no face is flat. `hold` is `bottom`, `x_min` to `z_max`,
    `none` or the name of a group, `up` the axis that points up; both are proposed without them.
    A surface (STL, OBJ, PLY, OFF, GLB) is filled with tetrahedra, `cells` of them along its longest side, 4 to
    400; without it, as many as its volume asks for.
    """
    path = os.path.abspath(os.fspath(mesh))
    return read(Starter, json.loads(_native.init(path, material, scale, cells, (hold, up), progress)))


def problem_from_meshio(
    mesh: Any,
    path: PathLike,
    *,
    material: Optional[str] = None,
    scale: Optional[float] = None,
    hold: Optional[str] = None,
    up: Optional[str] = None,
    progress: Optional[Progress] = None,
) -> Starter:
    """Proposes a problem for a mesh of `meshio`, from any format that it reads: MED, Exodus, CGNS, XDMF and others.

    Nodes, solid elements, cell sets (regions and groups) and point sets (groups) are written to `path`, a deck with
    the ending `.inp` that the problem refers to. The rest is as in `init`.
    """
    blocks, cell_sets, point_sets = blocks_of_meshio(mesh)
    deck = write_mesh(path, mesh.points, blocks, cell_sets=cell_sets, point_sets=point_sets)
    return init(deck, material=material, scale=scale, hold=hold, up=up, progress=progress)


def modes(
    problem: Input,
    count: int = 12,
    *,
    mesh_error: bool = False,
    disc: Optional[float] = None,
    folder: Optional[PathLike] = None,
    progress: Optional[Progress] = None,
) -> NaturalModes:
    """The lowest natural frequencies of a problem, and the damping that each mode receives.

    With `mesh_error` the discretisation error of the lowest six is estimated, and that of the displacement
    under one newton on a disc of radius `disc` [m] (three mean edges without it).
    """
    asked = (mesh_error or disc is not None, disc)
    return read(NaturalModes, json.loads(_native.modes(_given(problem, folder), count, asked, progress)))


def _given(source: Input, folder: Optional[PathLike] = None) -> tuple[str, str, str]:
    """How a problem or a scenario is handed over: kind, text, folder."""
    place = os.getcwd() if folder is None else os.path.abspath(os.fspath(folder))
    if isinstance(source, Starter):
        return ("toml", source.text, place)
    if isinstance(source, Mapping):
        return ("json", json.dumps(_plain(source), allow_nan=False), place)
    return ("path", os.fspath(source), place)


def _channel(given: Channel) -> str:
    """The text of a channel."""
    if isinstance(given, str):
        return given
    try:
        point, direction = given
        numbers = [repr(float(x)) for x in point]
        return ",".join([*numbers, direction] if isinstance(direction, str) else [*numbers, *(repr(float(x)) for x in direction)])
    except (TypeError, ValueError):
        raise TypeError(f"expected a name, or a point and a direction, found {given!r}") from None


def _plain(value: Any) -> Any:
    """Lists and numbers of Python for arrays and numbers of NumPy; keys without a value are left out."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items() if item is not None}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return os.fspath(value) if isinstance(value, os.PathLike) else value
