"""An FMU of tests/beam.toml in FMPy: check.py FMU PROBES.CSV FREE.FMU FREE.CSV, with the table of `vademecum run` with
tests/push.toml; then the same beam without its support, and its table with tests/throw.toml."""

import csv
import ctypes
import math
import pathlib
import re
import sys

import fmpy
import numpy
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

STEP = 1e-3
archive, table, thrown, flown = sys.argv[1:]
description = read_model_description(archive)
two = description.fmiVersion == "2.0"
references = {variable.name: variable.valueReference for variable in description.modelVariables}
folder = extract(archive)
POINTS = ["tip", "'half way'"]


class Unit:
    """An instance that steps."""

    def __init__(self, token=description.guid):
        self.unit = (FMU2Slave if two else FMU3Slave)(
            guid=token,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="beam",
        )
        self.unit.instantiate()
        if two:
            self.unit.setupExperiment(startTime=0.0)
            self.unit.enterInitializationMode()
        else:
            self.unit.enterInitializationMode(startTime=0.0)
        self.unit.exitInitializationMode()
        self.time = 0.0

    def get(self, *names):
        numbers = [references[name] for name in names]
        return list((self.unit.getReal if two else self.unit.getFloat64)(numbers))

    def put(self, values):
        numbers = [references[name] for name in values]
        (self.unit.setReal if two else self.unit.setFloat64)(numbers, list(values.values()))

    def step(self, count=1):
        self.unit.doStep(currentCommunicationPoint=self.time, communicationStepSize=count * STEP)
        self.time += count * STEP

    def save(self):
        state = self.unit.getFMUState()
        saved = self.unit.serializeFMUState(state)
        self.unit.freeFMUState(state)
        return saved

    def take(self, saved):
        state = self.unit.deserializeFMUState(saved)
        self.unit.setFMUState(state)
        self.unit.freeFMUState(state)

    def everything(self):
        return self.get(*(name for name in references if name != "time"))

    def end(self):
        self.unit.terminate()
        self.unit.freeInstance()


def refused(call, what):
    try:
        call()
    except Exception as error:
        assert isinstance(error, (FMICallException, OSError)) or "instantiate" in str(error).lower(), error
        return
    raise AssertionError(f"not refused: {what}")


def last_digit(x):
    """One unit of the last of ten digits, which the table of the program has."""
    return 10.0 ** (math.floor(math.log10(abs(x))) - 9) if x else 0.0


def as_the_program_runs():
    with open(table) as file:
        head, *rows = csv.reader(file)
    head = [name.split(" [")[0] for name in head]
    rows = numpy.array(rows, dtype=float)
    names = [f"force.tip.{c}" for c in "xyz"] + ["pattern.gravity"]
    signal = numpy.zeros(len(rows), dtype=[("time", "f8")] + [(name, "f8") for name in names])
    signal["time"] = numpy.arange(len(rows)) * STEP
    for name, force in zip(names, [3.0, -8.0, -20.0]):
        signal[name] = numpy.where(numpy.arange(len(rows)) < 100, force, 0.0)
    signal["pattern.gravity"] = 0.5
    shown = {"energy": "energy_J", "probe.tip": "tip", "probe.strip": "strip", "von_mises.root": "root"}
    parts = [("force", "f"), ("moment", "m")]
    shown |= {f"reaction_{kind}.wall.{c}": f"reaction.wall.{letter}{c}" for kind, letter in parts for c in "xyz"}
    found = simulate_fmu(
        archive, stop_time=(len(rows) - 1) * STEP, step_size=STEP, output_interval=STEP, input=signal,
        output=list(shown), start_values={"force.'half way'.x": 0.0}, debug_logging=False,
    )
    assert len(found) == len(rows), (len(found), len(rows))
    worst = 0.0
    for name, column in shown.items():
        wanted = rows[:, head.index(column)]
        assert numpy.abs(wanted).max() > 0.0, column
        for x, y in zip(found[name], wanted):
            assert abs(x - y) <= last_digit(y), (name, x, y)
            worst = max(worst, abs(x - y) / abs(y) if y else 0.0)
    return worst


def as_the_program_throws():
    """A free beam: where it is, how it is turned, and its end in space, as the table of the program has them."""
    with open(flown) as file:
        head, *rows = csv.reader(file)
    head = [name.split(" [")[0] for name in head]
    rows = numpy.array(rows, dtype=float)
    start = {f"body_velocity.{c}": v for c, v in zip("xyz", [1.0, 0.0, 3.0])}
    start |= {f"body_angular_velocity.{c}": v for c, v in zip("xyz", [2.0, 20.0, 0.0])}
    start |= {f"force.tip.{c}": v for c, v in zip("xyz", [3.0, -8.0, -20.0])}
    names = {f"body_position.{c}": f"centre {c}" for c in "xyz"} | {f"body_attitude.{c}": f"q_{c}" for c in "wxyz"}
    names |= {"energy": "energy_J"} | {f"displacement.tip.{c}": f"end in space {c}" for c in "xyz"}
    found = simulate_fmu(
        thrown, stop_time=(len(rows) - 1) * STEP, step_size=STEP, output_interval=STEP, output=list(names),
        start_values=start,
    )
    assert len(found) == len(rows), (len(found), len(rows))
    rest = dict(zip("xyz", [1.0, 0.04, 0.1]))
    for name, column in names.items():
        wanted = rows[:, head.index(column)] - (rest[column[-1]] if "end" in column else 0.0)
        assert numpy.ptp(wanted) > 0.0, column
        size = numpy.abs(rows[:, head.index(column)]).max()
        assert numpy.abs(found[name] - wanted).max() <= 1e-9 * size, (name, numpy.abs(found[name] - wanted).max(), size)


def every_function_of_the_standard_is_there():
    """Of the headers that FMPy carries: all of FMI 3, and of FMI 2 all but those for model exchange."""
    platform = fmpy.platform if two else fmpy.platform_tuple
    name = description.coSimulation.modelIdentifier + fmpy.sharedLibraryExtension
    library = ctypes.CDLL(str(pathlib.Path(folder) / "binaries" / platform / name))
    header = f"fmi{2 if two else 3}FunctionTypes.h"
    text = (pathlib.Path(fmpy.__file__).parent / "c-code" / header).read_text()
    if two:
        before, after = text.split("Types for Functions for FMI2 for Model Exchange")
        text = before + after.split("Types for Functions for FMI2 for Co-Simulation")[1]
    names = re.findall(r"(fmi[23]\w+)TYPE\s*\(", text)
    assert len(names) == (34 if two else 75), names
    missing = [name for name in names if not hasattr(library, name)]
    assert not missing, missing
    return len(names)


def several_steps_are_one():
    many, one = Unit(), Unit()
    for unit in (many, one):
        unit.put({"force.tip.z": -20.0, "parameter.'stiffness scale'": 0.7, "parameter.beta": 5e-4})
    for turn in range(20):
        one.step(5)
        for _ in range(5):
            many.step()
        many.time = one.time
        assert many.everything() == one.everything(), turn
    assert one.get("displacement.tip.z")[0] < 0.0
    many.end(), one.end()


def any_step_will_do():
    """The beam has exact steps, so that a communication step may have any length, and its whole body scales."""
    assert description.coSimulation.canHandleVariableCommunicationStepSize
    assert float(description.defaultExperiment.stopTime) == 1.0, description.defaultExperiment.stopTime
    assert description.description == "beam of an FMU", description.description
    texts = [variable.description for variable in description.modelVariables]
    assert len(set(texts)) == len(texts), sorted(texts)
    one, other = Unit(), Unit()
    for unit in (one, other):
        unit.put({"force.tip.z": -20.0, "body_density": 2.0, "body_alpha": 5.0})
    for _ in range(60):
        one.step(1 / 0.06)
    for _ in range(1000):
        other.step()
    a, b = (unit.get("displacement.tip.z", "energy") for unit in (one, other))
    assert numpy.allclose(a, b, rtol=1e-8, atol=0.0), (a, b)
    refused(lambda: one.put({"body_density": 0.0}), "no density")
    one.end(), other.end()


def states_come_back():
    unit, other = Unit(), Unit()
    unit.put({"force.tip.z": -20.0, "force.'half way'.y": 3.0, "parameter.'stiffness scale'": 1.5})
    for _ in range(10):
        unit.step()
    saved, shown, time = unit.save(), unit.everything(), unit.time
    for _ in range(10):
        unit.step()
    after = unit.everything()
    assert after != shown
    for one in (unit, other):
        one.take(saved)
        one.time = time
        assert one.everything() == shown
        for _ in range(10):
            one.step()
        assert one.everything() == after
    for hostile in (saved[:-1], b"", saved[:50] + b"\xff" * 8 + saved[58:]):
        refused(lambda: unit.take(hostile), "a hostile state")
    assert unit.everything() == after
    unit.end(), other.end()
    return len(saved)


def derivatives_are_those_of_a_step():
    """Along a force and a load pattern, of all outputs that are linear or quadratic in them, by central differences."""
    unit = Unit()
    inputs = ["force.tip.x", "force.tip.z", "pattern.gravity"]
    outputs = [v.name for v in description.modelVariables if v.causality == "output" and not v.name.startswith("von_mises")]
    held, seed = numpy.array([3.0, -20.0, 0.5]), numpy.array([1.0, 4.0, -0.3])
    unit.put(dict(zip(inputs, held)))
    unit.step(7)
    state, time = unit.unit.getFMUState(), unit.time

    def outputs_at(share):
        unit.unit.setFMUState(state)
        unit.time = time
        unit.put(dict(zip(inputs, held + share * seed)))
        unit.step(3)
        return numpy.array(unit.get(*outputs))

    above, below = outputs_at(0.5), outputs_at(-0.5)
    outputs_at(0.0)
    knowns, unknowns = ([references[name] for name in names] for names in (inputs, outputs))
    found = numpy.array(unit.unit.getDirectionalDerivative(unknowns, knowns, list(seed)))
    kinds = [name.split(".")[0] for name in outputs]
    for kind in set(kinds):
        chosen = numpy.array([other == kind for other in kinds])
        largest = numpy.abs(found[chosen]).max()
        apart = numpy.abs(found - (above - below))[chosen].max()
        assert largest > 0.0 and apart <= 1e-7 * largest, (kind, apart, largest)
    unit.unit.freeFMUState(state)
    unit.end()


def what_is_wrong_is_refused():
    unit = Unit()
    for size in (0.0, -1e-3, math.nan):
        refused(lambda: unit.unit.doStep(currentCommunicationPoint=0.0, communicationStepSize=size), size)
    refused(lambda: unit.unit.doStep(currentCommunicationPoint=1.0, communicationStepSize=STEP), "another time")
    for values in (
        {"parameter.'stiffness scale'": 2.1},
        {"parameter.beta": -1e-9},
        {"force.tip.z": math.inf},
        {"energy": 1.0},
        {"internal_step": 1.0},
    ):
        refused(lambda: unit.put(values), values)
    unit.step()
    unit.end()
    refused(lambda: Unit(token="{00000000-0000-0000-0000-000000000000}"), "another token")


def coupled():
    """Two beams whose tips a spring and a damper connect, in a master that steps both at once.

    The forces are those of the state before the step, half a step late on average, which alone would feed the
    motion with energy. What it feeds stays below what the damper and the beams take: nobody pushes after the
    start, so the energy of all three may never rise above what it was then.
    """
    stiffness, damping = 2000.0, 2.0
    beams = [Unit(), Unit()]
    moved = ["displacement.tip.z", "velocity.tip.z"]
    beams[0].put({"force.tip.z": -50.0})
    for beam in beams:
        for _ in range(200):
            beam.step()
    energies = []
    for turn in range(4000):
        (a, va), (b, vb) = (beam.get(*moved) for beam in beams)
        energies.append(sum(beam.get("energy")[0] for beam in beams) + 0.5 * stiffness * (b - a) ** 2)
        force = stiffness * (b - a) + damping * (vb - va)
        beams[0].put({"force.tip.z": force})
        beams[1].put({"force.tip.z": -force})
        for beam in beams:
            beam.step()
    for beam in beams:
        beam.end()
    assert energies[1] > 0.0 and all(map(math.isfinite, energies))
    return max(energies) / energies[0], energies[-1] / energies[0], max(energies[2000:]) / energies[0]


functions = every_function_of_the_standard_is_there()
worst = as_the_program_runs()
as_the_program_throws()
several_steps_are_one()
any_step_will_do()
size = states_come_back()
derivatives_are_those_of_a_step()
what_is_wrong_is_refused()
largest, final, late = coupled()
print(
    f"FMI {description.fmiVersion}: {functions} functions; 401 rows as `vademecum run`, to {worst:.1e}; a state has {size} bytes; "
    f"two coupled: energy at most {largest:.4f} of that at the start, {final:.1e} at the end"
)
assert largest <= 1.0 + 1e-9, largest
assert final < 1e-3, final
