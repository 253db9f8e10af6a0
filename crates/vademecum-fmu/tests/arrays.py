"""An FMU of FMI 3 with arrays, of tests/beam.toml, in FMPy: arrays.py FMU PROBES.CSV, with the table of `vademecum run` with
tests/push.toml. A force on a row of an array is the push of the scenario; the number of rows is a structural parameter; derivatives
are those of a step; a step returns early where the master asks for it; terminals are valid against the schema."""

import csv
import math
import pathlib
import sys

import fmpy
import numpy
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import FMU3Slave, fmi3IntermediateUpdateCallback
from lxml import etree

STEP = 1e-3
archive, table = sys.argv[1:]
description = read_model_description(archive)
variables = {variable.name: variable for variable in description.modelVariables}
references = {name: variable.valueReference for name, variable in variables.items()}
folder = extract(archive)
NODES = variables["surface_force"].shape[0]
TIP = [1.0, 0.04, 0.1]


class Unit:
    """An instance that steps, with so many rows in its arrays."""

    def __init__(self, nodes=NODES, update=None, early=False):
        self.unit = FMU3Slave(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="beam",
        )
        watched = [references["surface_displacement"]] if update else None
        self.unit.instantiate(intermediateUpdate=update, earlyReturnAllowed=early, requiredIntermediateVariables=watched)
        self.nodes, self.time = nodes, 0.0
        if nodes != NODES:
            self.unit.enterConfigurationMode()
            self.unit.setUInt64([references["surface_nodes"]], [nodes])
            self.unit.exitConfigurationMode()
        self.unit.enterInitializationMode(startTime=0.0)
        self.unit.exitInitializationMode()

    def get(self, name):
        count = 3 * self.nodes if variables[name].shape else 1
        return numpy.array(list(self.unit.getFloat64([references[name]], nValues=count)))

    def put(self, name, values):
        self.unit.setFloat64([references[name]], list(numpy.ravel(values)))

    def step(self, count=1):
        found = self.unit.doStep(currentCommunicationPoint=self.time, communicationStepSize=count * STEP)
        self.time = found[3]
        return found

    def end(self):
        self.unit.terminate()
        self.unit.freeInstance()


def refused(call, what):
    try:
        call()
    except FMICallException:
        return
    raise AssertionError(f"not refused: {what}")


def last_digit(x):
    """One unit of the last of ten digits, which the table of the program has."""
    return 10.0 ** (math.floor(math.log10(abs(x))) - 9) if x else 0.0


def row_of_the_tip():
    one = Unit()
    positions = one.get("surface_position").reshape(-1, 3)
    one.end()
    row = int(numpy.abs(positions - TIP).max(axis=1).argmin())
    assert numpy.abs(positions[row] - TIP).max() < 1e-12, positions[row]
    # Any first rows are spread: both ends, the middle, and what is between them.
    assert [round(x, 12) for x in sorted(positions[:5, 0])] == [0.0, 0.25, 0.5, 0.75, 1.0], positions[:5]
    return row


def as_the_program_runs(row):
    with open(table) as file:
        head, *rows = csv.reader(file)
    head = [name.split(" [")[0] for name in head]
    rows = numpy.array(rows, dtype=float)
    signal = numpy.zeros(len(rows), dtype=[("time", "f8"), ("surface_force", "f8", (NODES, 3))])
    signal["time"] = numpy.arange(len(rows)) * STEP
    signal["surface_force"][:100, row] = [3.0, -8.0, -20.0]
    found = simulate_fmu(
        archive, stop_time=(len(rows) - 1) * STEP, step_size=STEP, output_interval=STEP, input=signal,
        output=["energy", "surface_displacement", "surface_velocity"],
        # FMPy takes no arrays beside scalars in one table of inputs.
        start_values={"pattern.gravity": 0.5},
    )
    assert len(found) == len(rows) and found["surface_displacement"].shape == (len(rows), NODES, 3)
    shown = {"energy_J": found["energy"], "tip": found["surface_displacement"][:, row, 2]}
    for column, values in shown.items():
        wanted = rows[:, head.index(column)]
        assert numpy.abs(wanted).max() > 0.0, column
        for x, y in zip(values, wanted):
            assert abs(x - y) <= last_digit(y), (column, x, y)
    assert numpy.abs(found["surface_velocity"]).max() > 0.0
    return len(rows)


def fewer_rows_are_the_first_ones():
    few, all_ = Unit(nodes=5), Unit()
    force = numpy.zeros((NODES, 3))
    force[:5] = numpy.arange(15).reshape(5, 3)
    few.put("surface_force", force[:5])
    all_.put("surface_force", force)
    refused(lambda: few.put("surface_force", force), "rows that are not in use")
    for _ in range(20):
        few.step(), all_.step()
    a, b = few.get("surface_displacement"), all_.get("surface_displacement")
    assert a.shape == (15,) and numpy.abs(a).max() > 0.0 and numpy.array_equal(a, b[:15])
    assert numpy.array_equal(few.get("surface_position"), all_.get("surface_position")[:15])
    few.end(), all_.end()
    refused(lambda: Unit(nodes=NODES + 1), "more rows than there are")


def derivatives_are_those_of_a_step():
    """Forces on ten rows, and all displacements: by the FMU, and by central differences of the same step."""
    one = Unit(nodes=10)
    inputs, outputs = ["surface_force", "pattern.gravity"], ["surface_displacement", "surface_velocity", "probe.tip"]
    knowns, unknowns = ([references[name] for name in names] for names in (inputs, outputs))
    one.put("surface_force", numpy.ones(30))
    one.step(10)
    generator = numpy.random.default_rng(1)
    seed = generator.standard_normal(31)
    saved = one.unit.getFMUState()
    start = one.time

    def outputs_at(share):
        one.unit.setFMUState(saved)
        one.time = start
        one.put("surface_force", numpy.ones(30) + share * seed[:30])
        one.put("pattern.gravity", share * seed[30])
        one.step(3)
        return numpy.concatenate([one.get(name) for name in outputs])

    above, below = outputs_at(0.5), outputs_at(-0.5)
    outputs_at(0.0)
    found = numpy.array(one.unit.getDirectionalDerivative(unknowns, knowns, list(seed), nSensitivity=61))
    worst = 0.0
    for part in (slice(0, 30), slice(30, 60), slice(60, 61)):
        largest = numpy.abs(found[part]).max()
        assert largest > 0.0
        worst = max(worst, numpy.abs(found[part] - (above - below)[part]).max() / largest)
    assert worst <= 1e-7, worst
    weights = generator.standard_normal(61)
    adjoint = numpy.array(one.unit.getAdjointDerivative(unknowns, knowns, list(weights), nSensitivity=31))
    assert abs(adjoint @ seed - weights @ found) <= 1e-10 * numpy.abs(weights * found).sum()
    refused(lambda: one.unit.getDirectionalDerivative(knowns, unknowns, list(found), nSensitivity=31), "outputs as knowns")
    one.unit.freeFMUState(saved)
    one.end()
    return worst


def a_step_returns_early(row):
    """The master watches the tip from inside of a long step, and stops where it has moved by a fifth of a millimetre."""
    seen = []

    def update(_environment, time, set_requested, get_allowed, finished, can_return, requested, at):
        assert get_allowed and finished and not set_requested
        moved = one.get("surface_displacement").reshape(-1, 3)[row, 2]
        seen.append((time, moved))
        if moved < -2e-4 and can_return:
            requested[0], at[0] = True, time

    one = Unit(update=fmi3IntermediateUpdateCallback(update), early=True)
    force = numpy.zeros((NODES, 3))
    force[row, 2] = -20.0
    one.put("surface_force", force)
    event, ended, early, time = one.step(100)
    assert early and not event and not ended and 0.0 < time < 100 * STEP, (event, ended, early, time)
    assert seen[-1][0] == time and seen[-1][1] < -2e-4 and all(moved >= -2e-4 for _, moved in seen[:-1])
    # It is where the same number of steps leads, and goes on from there.
    other = Unit()
    other.put("surface_force", force)
    for _ in seen:
        other.step()
    assert numpy.array_equal(one.get("surface_displacement"), other.get("surface_displacement"))
    assert not one.step()[2]
    one.end(), other.end()
    return len(seen)


def terminals_are_valid():
    schema = pathlib.Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
    text = etree.parse(str(pathlib.Path(folder) / "terminalsAndIcons" / "terminalsAndIcons.xml"))
    etree.XMLSchema(etree.parse(str(schema))).assertValid(text)
    terminals = {terminal.get("name"): terminal for terminal in text.iter("Terminal")}
    assert set(terminals) == {"point.tip", "surface"}, set(terminals)
    for terminal in terminals.values():
        assert terminal.get("matchingRule") == "plug"
        for member in terminal:
            causality = variables[member.get("variableName")].causality
            assert (member.get("variableKind") == "inflow") == (causality == "input"), member.attrib
    assert len(terminals["point.tip"]) == 9 and len(terminals["surface"]) == 3


tip = row_of_the_tip()
count = as_the_program_runs(tip)
fewer_rows_are_the_first_ones()
worst = derivatives_are_those_of_a_step()
steps = a_step_returns_early(tip)
terminals_are_valid()
print(
    f"FMI 3 arrays of {NODES} rows: {count} rows as `vademecum run`; derivatives and differences apart by {worst:.1e}; "
    f"a step of 100 returned early after {steps}"
)
