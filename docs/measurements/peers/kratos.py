"""A beam that bends far in Kratos Multiphysics, full order and reduced, and in a vademecum file: the same mesh and loads.

    kratos.py OUTPUT VADEMECUM     builds OUTPUT/beam.vdm with that program, writes OUTPUT/kratos.json and prints two tables

The body is a cantilever of linear tetrahedra, St. Venant-Kirchhoff, under an even traction over its free end, F sin^2(pi t / T)
in one direction. Kratos is trained with four loads of that family and asked for a fifth; the file is built for pushes anywhere and
for the two tractions, and is never shown any of them. Errors are relative L2 over all nodes and steps in the mass norm, against
Kratos' own full order at the same step, and against its full order with a sixteenth of the step.
"""

import contextlib
import csv
import json
import os
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import KratosMultiphysics as Kratos
import numpy as np
from block import Block, force
from KratosMultiphysics import RomApplication, StructuralMechanicsApplication  # noqa: F401
from KratosMultiphysics.RomApplication.calculate_rom_basis_output_process import CalculateRomBasisOutputProcess
from KratosMultiphysics.RomApplication.rom_analysis import CreateRomAnalysisInstance
from KratosMultiphysics.StructuralMechanicsApplication.structural_mechanics_analysis import StructuralMechanicsAnalysis

LENGTHS, CELLS = (1.0, 0.08, 0.1), (20, 4, 4)
YOUNG, POISSON, DENSITY = 1e7, 0.3, 1000.0
STEP, STEPS = 0.016, 200
# Force [N], its duration [s], its direction in the plane of the free end, from z [degrees].
TRAINING = [(40.0, 0.5, 0.0), (70.0, 0.7, 0.0), (40.0, 0.7, 30.0), (70.0, 0.5, 30.0)]
ASKED = (55.0, 0.6, 15.0)
# Modes of the reduced model, and by what tolerance its elements are chosen.
MODES, CUBATURE = (8, 16), (1e-6, 1e-4, 1e-3)
REFINED = (8, 16)
# Kratos steps once a step; with so many it is as fine as the file with as many sub-steps.
FINER = 4
COORDINATES, SUBSTEPS = 32, (1, FINER)


class Snapshots(CalculateRomBasisOutputProcess):
    """The basis of Kratos from displacements of several runs."""

    def write(self, snapshots, modes):
        # Kratos takes a tolerance; its own decomposition, cut at the number asked for.
        u, sigma = self._ComputeSVD(snapshots)
        self._PrintRomBasis(u[:, :modes], sigma[:modes])


def analysis_of(block, load, step, rom):
    """An analysis that keeps displacements and counts the time of its steps."""

    class Beam(StructuralMechanicsAnalysis):
        def ApplyBoundaryConditions(self):
            super().ApplyBoundaryConditions()
            y, z = force(load, self.time)
            for condition, share in self.conditions:
                condition.SetValue(StructuralMechanicsApplication.POINT_LOAD, Kratos.Array3([0.0, share * y, share * z]))

        def RunSolutionLoop(self):
            self.seconds, self.displacements, self.times, self.iterations = 0.0, [], [], 0
            part = self._GetSolver().GetComputingModelPart().GetRootModelPart()
            while self.KeepAdvancingSolutionLoop():
                start = time.perf_counter()
                self.time = self._AdvanceTime()
                self.InitializeSolutionStep()
                self._GetSolver().Predict()
                if not self._GetSolver().SolveSolutionStep():
                    sys.exit(f"kratos: no convergence at {self.time} s")
                self.iterations += part.ProcessInfo[Kratos.NL_ITERATION_NUMBER]
                self.FinalizeSolutionStep()
                self.seconds += time.perf_counter() - start
                values = Kratos.VariableUtils().GetSolutionStepValuesVector(part.Nodes, Kratos.DISPLACEMENT, 0, 3)
                self.displacements.append(np.array(values).reshape(-1, 3))
                self.times.append(self.time)

    model = Kratos.Model()
    settings = Kratos.Parameters(json.dumps({
        "analysis_stage": "KratosMultiphysics.StructuralMechanicsApplication.structural_mechanics_analysis",
        "problem_data": {"problem_name": "beam", "parallel_type": "OpenMP", "echo_level": 0, "start_time": 0.0,
                         "end_time": STEPS * STEP - step / 2},
        "solver_settings": {
            "solver_type": "dynamic", "model_part_name": "Structure", "domain_size": 3, "echo_level": 0,
            "analysis_type": "non_linear", "time_integration_method": "implicit", "scheme_type": "bossak",
            "model_import_settings": {"input_type": "use_input_model_part"},
            "material_import_settings": {"materials_filename": ""},
            "time_stepping": {"time_step": step},
            # Of a reduced model the part of the residual that its basis does not see never vanishes.
            "convergence_criterion": "displacement_criterion" if rom else "residual_criterion",
            "residual_relative_tolerance": 1e-6, "residual_absolute_tolerance": 1e-9,
            "displacement_relative_tolerance": 1e-6, "displacement_absolute_tolerance": 1e-12, "max_iteration": 30,
            "linear_solver_settings": {"solver_type": "LinearSolversApplication.sparse_lu"},
        },
        "processes": {"constraints_process_list": [{
            "python_module": "assign_vector_variable_process", "kratos_module": "KratosMultiphysics",
            "Parameters": {"model_part_name": "Structure.held", "variable_name": "DISPLACEMENT",
                           "constrained": [True, True, True], "value": [0.0, 0.0, 0.0], "interval": [0.0, "End"]}}]},
        "output_processes": {},
    }))
    beam = CreateRomAnalysisInstance(Beam, model, settings) if rom else Beam(model, settings)
    part = model["Structure"]
    properties = part.CreateNewProperties(1)
    properties.SetValue(Kratos.YOUNG_MODULUS, YOUNG)
    properties.SetValue(Kratos.POISSON_RATIO, POISSON)
    properties.SetValue(Kratos.DENSITY, DENSITY)
    properties.SetValue(Kratos.CONSTITUTIVE_LAW, StructuralMechanicsApplication.LinearElastic3DLaw())
    for i, (x, y, z) in enumerate(block.nodes.tolist(), 1):
        part.CreateNewNode(i, x, y, z)
    for i, corners in enumerate((block.tetrahedra + 1).tolist(), 1):
        part.CreateNewElement("TotalLagrangianElement3D4N", i, corners, properties)
    beam.conditions = []
    for i, node in enumerate(np.flatnonzero(block.shares).tolist(), 1):
        beam.conditions.append((part.CreateNewCondition("PointLoadCondition3D1N", i, [node + 1], properties), block.shares[node]))
    held = part.CreateSubModelPart("held")
    held.AddNodes((np.flatnonzero(block.nodes[:, 0] < 1e-9) + 1).tolist())
    return beam


def run(block, load, step=STEP, rom=False):
    beam = analysis_of(block, load, step, rom)
    beam.Run()
    every = round(STEP / step)
    displacements = np.array(beam.displacements)[every - 1::every]
    if len(displacements) != STEPS:
        sys.exit(f"kratos: {len(displacements)} instants instead of {STEPS}")
    return displacements, beam.seconds / len(beam.displacements), beam.iterations / len(beam.displacements)


def change_rom(**changes):
    path = Path("rom_data/RomParameters.json")
    parameters = json.loads(path.read_text())
    for key, value in changes.items():
        parameters[key] = {**parameters[key], **value} if isinstance(value, dict) else value
    path.write_text(json.dumps(parameters))


def write_basis(block, displacements, modes):
    """Writes the basis of a reduced model where Kratos looks for it."""
    model = Kratos.Model()
    part = model.CreateModelPart("Structure")
    for i, (x, y, z) in enumerate(block.nodes.tolist(), 1):
        part.CreateNewNode(i, x, y, z)
    names = ["DISPLACEMENT_X", "DISPLACEMENT_Y", "DISPLACEMENT_Z"]
    output = Kratos.Parameters(json.dumps({"model_part_name": "Structure", "nodal_unknowns": names,
                                           "svd_truncation_tolerance": 1e-12}))
    Snapshots(model, output).write(displacements.reshape(len(displacements), -1).T, modes)


def kratos_rows(block, coarse, truth):
    """The reduced models of Kratos: name, seconds of training, seconds of a step, both errors, floor, elements."""
    start = time.perf_counter()
    trained = np.concatenate([run(block, load)[0] for load in TRAINING])
    sampling = time.perf_counter() - start
    for modes in MODES:
        start = time.perf_counter()
        write_basis(block, trained, modes)
        decomposing = time.perf_counter() - start
        basis = np.load("rom_data/RightBasisMatrix.npy")
        flat = coarse.reshape(len(coarse), -1).T
        shown = (basis @ np.linalg.lstsq(basis, flat, rcond=None)[0]).T.reshape(coarse.shape)
        floor = block.error(shown, coarse)
        name, seconds = f"POD-Galerkin, {modes} modes", sampling + decomposing
        yield (name, seconds, *reduced(block, coarse, truth), floor, len(block.tetrahedra))
        if modes != MODES[-1]:
            continue
        for tolerance in CUBATURE:
            start = time.perf_counter()
            training(block, tolerance)
            choosing = time.perf_counter() - start
            elements = len(np.load("rom_data/HROM_ElementIds.npy"))
            name = f"the same, elements by empirical cubature to {tolerance:.0e}"
            seconds = sampling + decomposing + choosing
            yield (name, seconds, *reduced(block, coarse, truth), floor, elements)
            if tolerance == CUBATURE[0]:
                yield (f"{name}, {FINER} steps in one", seconds, *reduced(block, coarse, truth, FINER), floor, elements)


def reduced(block, coarse, truth, finer=1):
    """Seconds of a step, and both errors, of the reduced model that Kratos has at hand."""
    u, seconds, _ = run(block, ASKED, STEP / finer, rom=True)
    return finer * seconds, block.error(u, coarse), block.error(u, truth)


def training(block, tolerance):
    """Chooses elements: residuals of one reduced run of each training load."""
    change_rom(train_hrom=True, run_hrom=False, rom_manager=True, hrom_settings={
        "element_selection_svd_truncation_tolerance": tolerance, "create_hrom_visualization_model_part": False, "echo_level": 0})
    residuals = []
    for load in TRAINING:
        beam = analysis_of(block, load, STEP, True)
        beam.Run()
        chooser = beam.GetHROM_utility()
        residuals += chooser.time_step_residual_matrix_container
    chooser.time_step_residual_matrix_container = residuals
    chooser.CalculateAndSaveHRomWeights()
    change_rom(train_hrom=False, run_hrom=True, rom_manager=False)


PROBLEM = """model = "large-displacement"
[mesh]
file = "beam.msh"
[[material]]
young = {young}
poisson = {poisson}
density = {density}
[[support]]
on = {{ box = {{ min = [-1e-6, -1.0, -1.0], max = [1e-6, 1.0, 1.0] }} }}
[[load.pattern]]
name = "y"
traction = [0.0, {traction}, 0.0]
on = {{ box = {{ min = [{near}, -1.0, -1.0], max = [2.0, 1.0, 1.0] }} }}
[[load.pattern]]
name = "z"
traction = [0.0, 0.0, {traction}]
on = {{ box = {{ min = [{near}, -1.0, -1.0], max = [2.0, 1.0, 1.0] }} }}
[time]
step = {step}
[basis]
modes = {coordinates}
[tolerance]
error = 0.1
[large]
displacement = 0.4
"""

SCENARIO = """duration = {duration}
[[pattern]]
name = "y"
table = "y.csv"
[[pattern]]
name = "z"
table = "z.csv"
[output]
fields_every = 1
fields = "body"
[[output.probe]]
name = "tip"
point = [1.0, 0.04, 0.05]
direction = [0.0, 0.0, 1.0]
"""


def our_rows(block, program, coarse, truth):
    """The file: name, seconds of its build, seconds of a step in both precisions, both errors."""
    import vademecum

    block.write_gmsh(Path("beam.msh"))
    area = LENGTHS[1] * LENGTHS[2]
    problem = PROBLEM.format(young=YOUNG, poisson=POISSON, density=DENSITY, near=LENGTHS[0] - 1e-6, traction=1 / area, step=STEP,
                             coordinates=COORDINATES)
    Path("beam.toml").write_text(problem)
    start = time.perf_counter()
    subprocess.run([program, "build", "beam.toml", "-o", "beam.vdm", "--force", "--quiet"], check=True)
    building = time.perf_counter() - start
    file = vademecum.open("beam.vdm")
    for axis, column in (("y", 0), ("z", 1)):
        with open(f"{axis}.csv", "w", newline="") as out:
            rows = csv.writer(out)
            rows.writerows([t, force(ASKED, t)[column]] for t in np.linspace(0, ASKED[1], 2001))
    place = {tuple(np.round(node, 6)): i for i, node in enumerate(file.nodes)}
    order = [place[tuple(np.round(node, 6))] for node in block.nodes]
    Path("push.toml").write_text(SCENARIO.format(duration=STEPS * STEP))
    for substeps in SUBSTEPS:
        u = file.run("push.toml", substeps=substeps).displacement[1:][:, order]
        seconds = {}
        for precision in (np.float64, np.float32):
            body = file.body(precision, substeps=substeps)
            body.push_pattern("z", ASKED[0])
            seconds[precision] = min(timed(body) for _ in range(5))
        name = f"vademecum, {COORDINATES} coordinates, {substeps} sub-step(s)"
        yield name, building, seconds[np.float64], seconds[np.float32], block.error(u, coarse), block.error(u, truth)


def timed(body, steps=2000):
    start = time.perf_counter()
    body.step(steps)
    return (time.perf_counter() - start) / steps


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    output, program = Path(sys.argv[1]), str(Path(sys.argv[2]).resolve())
    output.mkdir(parents=True, exist_ok=True)
    os.chdir(output)
    Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
    block = Block(LENGTHS, CELLS, DENSITY)
    coarse, seconds, iterations = run(block, ASKED)
    refined = [run(block, ASKED, STEP / by)[0] for by in REFINED]
    truth = refined[-1]
    finer, finer_seconds, _ = run(block, ASKED, STEP / FINER)
    result = {
        "kratos": Kratos.KratosGlobals.Kernel.Version(), "nodes": len(block.nodes), "elements": len(block.tetrahedra),
        "tip": float(abs(truth[:, block.tip]).max()), "newton": iterations,
        "full_order": [seconds, block.error(coarse, truth), FINER * finer_seconds, block.error(finer, truth)],
        "reference_itself": block.error(refined[0], truth),
    }
    print(f"{len(block.nodes)} nodes, {len(block.tetrahedra)} elements; the tip moves by {result['tip']:.2f} m; "
          f"{iterations:.1f} iterations of Newton's method a step.")
    print(f"The refined reference: {result['reference_itself']:.1e} between an eighth and a sixteenth of the step.\n")
    print("| Kratos | training, s | ms a step | error, same step | error, refined | floor | elements |\n" + "|---" * 7 + "|")
    print(f"| full order | | {1e3 * seconds:.1f} | | {result['full_order'][1]:.1e} | | {len(block.tetrahedra)} |")
    print(f"| full order, {FINER} steps in one | | {1e3 * FINER * finer_seconds:.1f} | | {result['full_order'][3]:.1e} | "
          f"| {len(block.tetrahedra)} |")
    with open("kratos.log", "w") as log, contextlib.redirect_stdout(log):
        result["reduced"] = list(kratos_rows(block, coarse, truth))
    for row in result["reduced"]:
        name, training_seconds, step, same, total, floor, elements = row
        print(f"| {name} | {training_seconds:.0f} | {1e3 * step:.2f} | {same:.1e} | {total:.1e} | {floor:.1e} "
              f"| {elements} |")
    print("\n| file | build, s | µs a step, binary64 | binary32 | error, same step | error, refined |\n" + "|---" * 6 + "|")
    result["ours"] = []
    for row in our_rows(block, program, coarse, truth):
        result["ours"].append(row)
        name, building, double, single, same, total = row
        print(f"| {name} | {building:.0f} | {1e6 * double:.1f} | {1e6 * single:.1f} | {same:.1e} | {total:.1e} |", flush=True)
    Path("kratos.json").write_text(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
