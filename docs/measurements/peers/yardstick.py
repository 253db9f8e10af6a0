"""Error against time of a step of many programs: the same body, material and push.

    yardstick.py OUTPUT VADEMECUM     prints two tables, writes OUTPUT/yardstick.json and OUTPUT/yardstick.svg
    yardstick.py OUTPUT VADEMECUM --quick     our file and NumPy on the tetrahedra alone, held to the errors of the page

A block of rubber is pushed at its free end for one period and rings for another. Each program is asked for steps of 4, 1 and
0.25 ms. What is compared is the mean displacement of the pushed face and that of a node half way, along y and z, at the same
instants: relative L2 errors over all of them against the converged motion of the same tetrahedra, and against that of quadratic
elements, which is the body's own. Times are processor times of the call that makes a step, in the median, one thread; reading
the clock is in them.
"""

import csv
import importlib
import json
import os
import subprocess
import sys
import time
import types
from pathlib import Path

import numpy as np
import scipy.io
import yardstick_modal
import yardstick_picture
import yardstick_task
from yardstick_task import (
    DENSITY, DIRECTION, DURATION, EVERY, LARGE, LENGTHS, POISSON, SMALL, STEPS, YOUNG, Task, amplitude, clock, errors,
)

import vademecum

PROBLEM = """{head}
[mesh]
file = "block.msh"
{order}
[[material]]
young = {young}
poisson = {poisson}
density = {density}
[[support]]
on = {{ box = {{ min = [-1e-6, -1.0, -1.0], max = [1e-6, 1.0, 1.0] }} }}
[[load.pattern]]
name = "push"
traction = [{traction}]
on = {{ box = {{ min = [{near}, -1.0, -1.0], max = [2.0, 1.0, 1.0] }} }}
[time]
step = {step}
[basis]
modes = {modes}
[tolerance]
error = 0.1
{tail}
"""
PUSH = "duration = 0.1\n[[pattern]]\nname = \"push\"\n"
COORDINATES, DISPLACEMENT = 32, 0.12


class Ours:
    """Problems, files and matrices of our program, in the folder where this runs."""

    def __init__(self, program, task):
        self.program, self.task, self.builds = program, task, []
        task.block.write_gmsh(Path("block.msh"))
        Path("push.toml").write_text(PUSH)

    def problem(self, name, step, modes=16, order="", head="", tail=""):
        traction = ", ".join(repr(float(part) / LENGTHS[1] / LENGTHS[2]) for part in DIRECTION)
        Path(f"{name}.toml").write_text(PROBLEM.format(
            head=head, tail=tail, order=order, young=YOUNG, poisson=POISSON, density=DENSITY, traction=traction,
            near=LENGTHS[0] - 1e-6, step=step, modes=modes))
        return f"{name}.toml"

    def run(self, *command):
        return subprocess.run([self.program, "--quiet", *command], check=True, stdout=subprocess.PIPE, text=True).stdout

    def build(self, *arguments, **keywords):
        path = self.problem(*arguments, **keywords)
        start = time.perf_counter()
        self.run("build", path, "-o", path.replace(".toml", ".vdm"), "--force", "--keep-missed")
        self.builds.append(f"{path.replace('.toml', '')} {time.perf_counter() - start:.0f} s")
        return vademecum.open(path.replace(".toml", ".vdm"))

    def matrices(self, name, order=""):
        """Mass and stiffness, the force of a push of 1 N, and the rows by which displacements are read."""
        problem = self.problem(name, EVERY, order=order)
        self.run("export", "matrices", problem, "--scenario", "push.toml", "--basis", "modes", "--modes", "1", "--steps", "1",
                 "-o", name, "--force")
        folder, model = Path(name), types.SimpleNamespace()
        model.mass = scipy.io.mmread(folder / "mass.mtx").tocsc()
        model.stiffness = scipy.io.mmread(folder / "stiffness.mtx").tocsc()
        model.load = np.load(folder / "loads.npy")[:, 0]
        with open(folder / "dofs.csv") as file:
            dofs = list(csv.DictReader(file))
        far = self.task.block.nodes[self.task.block.middle]
        model.read, model.weights = np.zeros((4, len(dofs))), {}
        for dof in dofs:
            row, axis = int(dof["row"]), "xyz".index(dof["component"])
            place = np.array([float(dof[key]) for key in "xyz"])
            if axis and model.load[row]:
                # The share of the node in the push, which is the same along all axes.
                share = model.load[row] / DIRECTION[axis]
                model.read[axis - 1, row] = share
                model.weights[tuple(np.round(place, 7))] = share
            if axis and np.linalg.norm(place - far) < 1e-9:
                model.read[axis + 1, row] = 1.0
        assert abs(model.read[:2].sum() - 2) < 1e-6 and model.read[2:].sum() == 2, "the push is 1 N, and one node is far away"
        return model


def marched(task, file, weights, step, **options):
    """Readings of a file that is bound at this step, and the seconds of a step of its evaluator, called from Python."""
    body = file.body(time_step=step, **options)
    nodes = np.asarray(file.nodes)
    shares = np.array([weights.get(tuple(np.round(node, 7)), 0.0) for node in nodes])
    far = int(np.argmin(np.linalg.norm(nodes - task.block.nodes[task.block.middle], axis=1)))
    assert abs(shares.sum() - 1) < 1e-6, "all nodes of the face"
    timed = clock(body.step)

    def advance(t, dt):
        body.clear()
        body.push_pattern("push", amplitude(task.size, t + dt / 2))
        return timed()

    def show():
        u = body.whole()
        return np.array([shares @ u[:, 1:], u[far, 1:]])

    return task.march(step, advance, show)


def our_linear(ours, models):
    """Files of small displacements, of each (matrices, order of the elements, whether they are the tetrahedra)."""
    for model, order, own in models:
        file = ours.build("linear", EVERY, order=order)
        name = "linear" if own else "linear, quadratic elements"
        for step in STEPS:
            yield (name, "16 modes, exact", step, *marched(ours.task, file, model.weights, step), own)


def our_large(ours, same):
    """Files of large displacements, of one sub-step and of four."""
    file = ours.build("large", EVERY, COORDINATES, head='model = "large-displacement"',
                      tail=f"[large]\ndisplacement = {DISPLACEMENT}")
    for substeps in (1, 4):
        for step in STEPS:
            name = f"{COORDINATES} coordinates, {substeps} sub-step{'s' * (substeps > 1)}"
            yield ("large displacements", name, step, *marched(ours.task, file, same.weights, step, substeps=substeps), True)


class Rows:
    """What was measured of one task."""

    def __init__(self, reference, body):
        self.reference, self.body, self.rows = reference, body, []

    def take(self, program, found):
        for name, settings, step, readings, seconds, own in found:
            lost = readings is None
            self.rows.append({
                "program": program, "name": name, "settings": settings, "step": step, "seconds": seconds,
                "per_motion": seconds / step, "own": own,
                "same_mesh": None if lost or not own else errors(readings, self.reference),
                "body": None if lost or self.body is None else errors(readings, self.body)})
            print(f"{program} {name} {settings} {step}: {self.rows[-1]}", file=sys.stderr, flush=True)

    def table(self):
        pair = lambda found: "lost" if found is None else f"{found[0]:.1e}, {found[1]:.1e}"
        lines = ["| program | what | settings | step, ms | µs a step | s per s of motion | error, same tetrahedra | error, the body |",
                 "|---|---|---|---|---|---|---|---|"]
        for row in self.rows:
            cells = [row["program"], row["name"], row["settings"], f"{1e3 * row['step']:g}", f"{1e6 * row['seconds']:.3g}",
                     f"{row['per_motion']:.2g}", pair(row["same_mesh"]) if row["own"] else "",
                     "" if self.body is None else pair(row["body"])]
            lines.append("| " + " | ".join(cells) + " |")
        return "\n".join(lines) + "\n"


def peers(out):
    """The other programs that are installed: their name and their rows."""
    found = []
    for module in ("mujoco", "newton", "kratos"):
        try:
            peer = importlib.import_module(f"yardstick_{module}")
        except ImportError as error:
            print(f"{module} is not installed and left out ({error}).\n", file=out)
            continue
        found.append((peer.NAME, peer.rows))
    return found


def quick(ours, same):
    """What holds of our file and of modal superposition, whatever is installed."""
    reference, _ = yardstick_task.linear_reference(same.mass, same.stiffness, same.load, same.read, SMALL, 1280)
    rows = Rows(reference, None)
    rows.take("vademecum", our_linear(ours, [(same, "", True)]))
    rows.take(yardstick_modal.NAME, yardstick_modal.rows(ours.task, [(same, "modal superposition", True)]))
    for row in rows.rows:
        limit = 2e-3 if row["program"] != "vademecum" else 1.5e-3 if row["step"] > 1e-3 else 5e-4
        if max(row["same_mesh"]) > limit:
            sys.exit(f"yardstick: {row} has an error above {limit}")
    return rows


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    # Programs print what they like; the tables alone are for the standard output.
    out = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    say = lambda words: print(words, file=out, flush=True)
    output, program = Path(sys.argv[1]).resolve(), str(Path(sys.argv[2]).resolve())
    work = output / "work"
    work.mkdir(parents=True, exist_ok=True)
    os.chdir(work)
    small, large = Task(SMALL), Task(LARGE)
    block = small.block
    ours = Ours(program, small)
    same = ours.matrices("same")
    nothing = clock(lambda: None)
    say(f"{len(block.nodes)} nodes, {len(block.tetrahedra)} tetrahedra, {same.mass.shape[0]} free dofs. Reading the clock takes "
        f"{1e6 * np.median([nothing() for _ in range(1000)]):.2f} µs of each step.\n")
    if "--quick" in sys.argv:
        say(quick(ours, same).table())
        return
    quadratic = ours.matrices("quadratic", 'order = "quadratic"')
    reference, known = yardstick_task.linear_reference(same.mass, same.stiffness, same.load, same.read, SMALL, 1280)
    body, body_known = yardstick_task.linear_reference(quadratic.mass, quadratic.stiffness, quadratic.load, quadratic.read, SMALL, 320)
    reaches = lambda readings: f"{1e3 * np.linalg.norm(readings[:, 0], axis=1).max():.2g} mm"
    installed = peers(out)
    say("## Small displacements\n")
    say(f"The push of {SMALL:g} N moves the face by {reaches(reference)}, and that of quadratic elements ({quadratic.mass.shape[0]} "
        f"free dofs) by {reaches(body)}. The converged motions are extrapolated from two marches; the finer one alone is "
        f"{known:.1e} and {body_known:.1e} from them. The tetrahedra alone are {errors(reference, body)[0]:.1e} from the body.\n")
    curved, _ = yardstick_task.large_reference(small, 160)
    say(f"By the law of large displacements the motion is {errors(curved, reference)[0]:.1e} and {errors(curved, reference)[1]:.1e} "
        "from it, under the push and half way.\n")
    first = Rows(reference, body)
    first.take("vademecum", our_linear(ours, [(same, "", True), (quadratic, 'order = "quadratic"', False)]))
    first.take(yardstick_modal.NAME, yardstick_modal.rows(
        small, [(same, "modal superposition", True), (quadratic, "the same, quadratic elements", False)]))
    try:
        import pymor

        first.take(f"pyMOR {pymor.__version__}", yardstick_modal.pymor_rows(small, same))
    except ImportError as error:
        say(f"pyMOR is not installed and left out ({error}).\n")
    for name, rows in installed:
        first.take(name, rows(small))
    say(first.table())

    say("## Large displacements\n")
    reference, known = yardstick_task.large_reference(large, 320)
    say(f"The push of {LARGE:g} N moves the face by {reaches(reference)}. The finer march alone is {known:.1e} from the converged "
        "motion, St. Venant–Kirchhoff on the same tetrahedra.\n")
    second = Rows(reference, None)
    ours.task = large
    second.take("vademecum", our_large(ours, same))
    for name, rows in installed:
        second.take(name, (row for row in rows(large) if row[-1]))
    say(second.table())
    say(f"Builds of our files took: {', '.join(ours.builds)}.")
    (output / "yardstick.json").write_text(json.dumps({"small": first.rows, "large": second.rows}, indent=1))
    (output / "yardstick.svg").write_text(yardstick_picture.picture(first.rows, second.rows))


if __name__ == "__main__":
    main()
