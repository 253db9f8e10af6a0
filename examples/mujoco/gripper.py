"""Two soft pads on the fingers of a gripper in MuJoCo: they feel what they hold, at 1 kHz.

    python gripper.py pad.vdm [pad.inp]

Pressed on a ball that is held, and compared with the full order, which CalculiX solves with the mesh `pad.inp`; then a
ball is gripped, lifted, held and dropped. Each line that is printed is a check.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import mujoco
import numpy as np

import vademecum
from coupled import Coupled, Pad
from pad import CELLS, LENGTHS, block, grid

HERE = Path(__file__).parent
#: Radius of the ball, m; m/s2; how far the ball is lifted, m.
RADIUS, GRAVITY, LIFT = 0.015, 9.81, 0.05


def check(what, found, limit):
    """Prints what was found, and ends the program where it is above its limit."""
    print(f"  {what}: {found:.1e} (limit {limit:.0e})")
    if not found <= limit:
        sys.exit(f"{what}: found {found}, expected at most {limit}")


def press(file, inp):
    """A finger presses on a ball, and on a rod with round ends, until all is at rest."""
    scene = (HERE / "press.xml").read_text()
    rod = scene.replace('type="sphere" size="0.015"', 'type="capsule" size="0.015 0.006" zaxis="0 1 0.3"')
    for what, text, half, force in (("ball", scene, 0.0, 0.5), ("ball", scene, 0.0, 1.0), ("rod", rod, 0.006, 1.0)):
        model = mujoco.MjModel.from_xml_string(text)
        pad = Pad(file, "pad")
        coupled = Coupled(model, [pad], ["held"])
        coupled.data.ctrl[:] = force
        for _ in range(2500):
            coupled.step()
        felt, held = pad.forces.sum(axis=0), pad.body.reaction("back")
        pressed = pad.forces[:, 2] != 0.0
        print(f"pressed on a {what} with {force} N: {pressed.sum()} taxels touch, the finger moved by "
              f"{1e3 * coupled.data.qpos[0]:.4f} mm")
        check("force of all taxels against the motor, of it", abs(felt[2] / -force - 1.0), 1e-9)
        check("force on the back of the pad against that on its front, of it", np.abs(held[:3] + felt).max() / force, 1e-9)
        centre = (pad.rest[:, :2] * pad.forces[:, 2:]).sum(axis=0) / felt[2]
        # The axes of the pad are -z and y of the scene.
        place = model.geom("held").pos
        if what == "ball":
            check("centre of the pressure against that of the ball, m", np.abs(centre - 0.01 - [-place[2], place[1]]).max(), 2e-4)
        points = pad.body.stress_points[:, 0]
        stress = pad.body.stress()
        added = over(np.asarray(file.nodes)[points], stress[:, 2])
        check("stress across the layer, added up, against the force, of it", abs(added / -force - 1.0), 0.02)
        if inp is None:
            continue
        moved, tension = full_order(inp, file, pad)
        largest = np.abs(moved).max()
        off = np.abs(pad.body.surface()[pad.taxels] - moved[pad.taxels]).max()
        check("displacement of the taxels against the full order, of the largest", off / largest, 1e-5)
        data = coupled.data
        places = data.site_xpos[0] + (pad.rest + moved[pad.taxels])[pressed] @ data.site_xmat[0].reshape(3, 3).T - place
        axis = data.geom("held").xmat.reshape(3, 3)[:, 2]
        gap = np.linalg.norm(places - np.clip(places @ axis, -half, half)[:, None] * axis, axis=1) - RADIUS
        check("taxels of the full order off what they touch, of the largest displacement", np.abs(gap).max() / largest, 1e-5)
        off = np.abs(stress - tension[points]).max()
        check("stress of the layer against the full order, of the largest", off / np.abs(tension[points]).max(), 1e-4)


def over(layer, values):
    """The integral of values on the grid of the layer over its area, by the trapezoidal rule."""
    at = grid(layer)[:, :2]
    weights = np.where((at == 0) | (at == 2 * CELLS[:2]), 0.5, 1.0).prod(axis=1)
    return (weights * values).sum() * (LENGTHS[:2] / CELLS[:2]).prod()


def full_order(inp, file, pad):
    """Displacement and stress of all nodes under the forces that the pad feels, from CalculiX; in the file's order."""
    number = {tuple(place): i + 1 for i, place in enumerate(grid(block()[0]).tolist())}
    ids = [number[tuple(place)] for place in grid(file.nodes).tolist()]
    with tempfile.TemporaryDirectory() as folder:
        deck = [f"*INCLUDE, INPUT={Path(inp).resolve()}", "*MATERIAL, NAME=silicone", "*ELASTIC", "1.5e5, 0.45",
                "*SOLID SECTION, ELSET=body, MATERIAL=silicone", "*BOUNDARY", "back, 1, 3", "*STEP", "*STATIC", "*CLOAD"]
        deck += [f"{ids[node]}, {axis + 1}, {value:.12e}" for node, force in zip(pad.taxels, pad.forces)
                 for axis, value in enumerate(force.tolist()) if value]
        deck += ["*NODE FILE", "U", "*EL FILE", "S", "*END STEP", ""]
        (Path(folder) / "press.inp").write_text("\n".join(deck))
        said = subprocess.run(["ccx", "press"], cwd=folder, capture_output=True, text=True)
        fields, field = {}, None
        answer = Path(folder) / "press.frd"
        if not answer.exists():
            sys.exit(f"CalculiX gave no answer:\n{said.stdout}")
        for line in answer.read_text().splitlines():
            if line.startswith(" -4"):
                field = fields.setdefault(line.split()[1], {})
            elif line.startswith(" -1") and field is not None:
                field[int(line[3:13])] = [float(line[at:at + 12]) for at in range(13, len(line.rstrip()), 12)]
    moved, stress = (np.array([fields[name][i] for i in ids]) for name in ("DISP", "STRESS"))
    return moved[:, :3], stress


class Rise:
    """How far a number rises above the least that it was before."""

    def __init__(self, start):
        self.least, self.most = start, 0.0

    def take(self, value):
        self.most, self.least = max(self.most, value - self.least), min(self.least, value)


def grip(file):
    """The pads close on a ball on a table, lift it, hold it, and let it fall."""
    model = mujoco.MjModel.from_xml_path(str(HERE / "gripper.xml"))
    pads = [Pad(file, f"{side} pad") for side in ("left", "right")]
    coupled = Coupled(model, pads, ["ball"])
    data, step = coupled.data, model.opt.timestep
    ball, total = model.body("ball").mass[0], model.body_mass.sum()
    fingers = [model.body(f"{side} finger").mass[0] for side in ("left", "right")]
    # The spring of the lift gives way to the weight of the gripper.
    sag = GRAVITY * (total - ball) / model.actuator("lift").gainprm[0]

    def energy():
        # MuJoCo moves bodies with their velocities at the end of a step, so gravity is met in the middle of it.
        found = coupled.energy()
        mujoco.mj_subtreeVel(model, data)
        return found - 0.5 * step * total * GRAVITY * data.subtree_linvel[0][2]

    forces = np.zeros((2600, 2, len(pads[0].taxels), 3))
    stress = np.zeros((len(forces), 2, len(pads[0].body.stress_points), 6))
    times = np.zeros(len(forces))
    of_ball, of_fingers, deepest, weight = 0.0, 0.0, 0.0, 0.0
    whole = Rise(energy())
    apart, euler, most = Rise(whole.least), 0.0, 0.0
    for k in range(len(forces)):
        t = k * step
        close = min(t / 0.4, 1.0) if t < 1.8 else 0.0
        data.ctrl[:] = [0.0019 * close, -1.2 * close + 0.3 * (t > 1.8), sag + LIFT * np.clip((t - 0.6) / 0.6, 0.0, 1.0)]
        before, started = data.qvel.copy(), time.perf_counter()
        coupled.step()
        for number, pad in enumerate(pads):
            forces[k, number], stress[k, number] = pad.forces, pad.body.stress()
        times[k] = time.perf_counter() - started

        # What the taxels feel moves the bodies of MuJoCo.
        touches, gained = coupled.touches, (data.qvel - before) / step
        on_ball = -touches.force.sum(axis=0)
        if data.ncon == 0:
            of_ball = max(of_ball, np.abs(ball * (gained[3:6] + [0.0, 0.0, GRAVITY]) - on_ball).max())
        for number, mass in enumerate(fingers):
            on_finger = data.qfrc_actuator[1 + number] + touches.force[touches.pad == number, 0].sum()
            of_fingers = max(of_fingers, abs(mass * gained[1 + number] - on_finger))
        push = np.einsum("ci,ci->c", touches.force, touches.axes[:, 0])
        drag = np.linalg.norm(touches.force - push[:, None] * touches.axes[:, 0], axis=1)
        if (push < 0.0).any() or (drag > coupled.friction * push + 1e-9).any():
            sys.exit(f"at {t} s a force pulls, or drags by more than friction allows")
        # The gaps close with the velocities at the end of the step, and kinetic energy goes with the mean.
        of_step = -0.5 * step * np.einsum("civ,ci,v", touches.jacobian, touches.force, data.qvel - before)
        euler, most = euler + of_step, most + abs(of_step)
        net = energy() - coupled.work
        whole.take(net)
        apart.take(net - euler)
        for pad, site in zip(pads, coupled.sites):
            places = data.site_xpos[site] + (pad.rest + pad.moved) @ data.site_xmat[site].reshape(3, 3).T
            deepest = max(deepest, RADIUS - np.linalg.norm(places - data.body("ball").xpos, axis=1).min())
        if 1.5 < t < 1.8:
            weight = max(weight, abs(on_ball[2] / (ball * GRAVITY) - 1.0))
            height = data.body("ball").xpos[2] - RADIUS
    print(f"gripped, lifted, held and dropped: {forces.shape[0]} readings of {forces[0].size} forces and "
          f"{stress[0].size} stresses, {1e3 * np.median(times):.2f} ms each with its step, in the median")
    check("force on the ball from its motion in MuJoCo, against the taxels, N", of_ball, 1e-9)
    check("force on the fingers from their motion, against the taxels, N", of_fingers, 1e-9)
    check("shear of all taxels against the weight of the ball, of it", weight, 1e-3)
    check("height of the ball against that of the palm, m", abs(height - LIFT), 2e-3)
    check("taxels in the ball, m", deepest, 1e-5)
    check("rise of the energy over what was put in, J, against the first-order share of the steps", whole.most, most)
    check(f"rise of it beside that share, of {coupled.work:.2f} J", apart.most / coupled.work, 1e-6)


if __name__ == "__main__":
    pad_file = vademecum.open(sys.argv[1])
    press(pad_file, sys.argv[2] if len(sys.argv) > 2 else None)
    grip(pad_file)
