"""MuJoCo's flexes in the task of the yardstick. Run by yardstick.py."""

import mujoco
import numpy as np
from yardstick_task import CELLS, DENSITY, LENGTHS, POISSON, STEPS, YOUNG, clock

NAME = f"MuJoCo {mujoco.__version__}"
MODEL = """<mujoco>
<option timestep="{step}" integrator="{integrator}" solver="Newton" iterations="100" tolerance="1e-10" gravity="0 0 0">
<flag contact="disable"/></option>
<worldbody><flexcomp name="block" type="direct" dim="3" dof="{dof}" cellcount="{cells}" mass="{mass}" radius="0.0005"
 point="{points}" element="{elements}"><elasticity young="{young}" poisson="{poisson}" damping="0"/>
<contact selfcollide="none" contype="0" conaffinity="0"/><pin id="{pins}"/></flexcomp></worldbody></mujoco>"""


def flex(task, dof, cells, integrator, step, substeps=1):
    """Readings of a flex and the seconds of a step, which is `substeps` steps of MuJoCo."""
    block = task.block
    order = {"full": 0, "trilinear": 1, "quadratic": 2}[dof]
    pins = block.held() if dof == "full" else np.arange((order * cells[1] + 1) * (order * cells[2] + 1))
    words = lambda values: " ".join(repr(value) for value in np.asarray(values).ravel().tolist())
    model = mujoco.MjModel.from_xml_string(MODEL.format(
        step=step / substeps, integrator=integrator, dof=dof, cells=words(cells), mass=DENSITY * np.prod(LENGTHS),
        points=words(block.nodes), elements=words(block.tetrahedra), young=YOUNG, poisson=POISSON, pins=words(pins)))
    if dof == "full":
        # A flexcomp has the same mass at all points; here each has that of its tetrahedra, as a lumped mass matrix does.
        moving = np.setdiff1d(np.arange(len(block.nodes)), pins)
        bodies = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, f"block_{i}") for i in moving]
        model.body_mass[bodies] = block.lumped()[moving]
        mujoco.mj_setConst(model, mujoco.MjData(model))
    data = mujoco.MjData(model)

    def vertices():
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_flex(model, data)
        return data.flexvert_xpos.copy()

    rest = vertices()
    # How the pushed face follows each slide joint, along z: the generalised force of a force of 1 N on the face.
    follows = np.zeros(model.nv)
    for joint in range(2, model.nv, 3):
        data.qpos[:] = 0
        data.qpos[joint] = 1e-3
        follows[joint - 2 : joint + 1] = block.shares @ (vertices() - rest)[:, 2] / 1e-3
    data.qpos[:] = 0
    mujoco.mj_forward(model, data)

    def many():
        for _ in range(substeps):
            mujoco.mj_step(model, data)

    timed = clock(many)

    def advance(t, dt):
        # The force in the middle of the step, held over it.
        y_and_z = task.force(t + dt / 2).sum(axis=0)
        data.qfrc_applied[:] = follows * np.tile(y_and_z, model.nv // 3)
        return timed()

    return task.march(step, advance, lambda: task.read(vertices() - rest))


def rows(task):
    """(name, settings, step, readings, seconds of a step, whether its mesh is that of the block)."""
    for step in STEPS:
        yield ("full", "Newton, `discrete`", step, *flex(task, "full", (1, 1, 1), "discrete", step), True)
    for step in STEPS:
        count = round(step / 0.000125)
        yield ("full", f"`Euler`, {count} sub-steps", step, *flex(task, "full", (1, 1, 1), "Euler", step, count), True)
    for dof, cells, longest in (("trilinear", CELLS, 0.000125), ("quadratic", (6, 1, 1), 0.00025)):
        name = f"{dof}, {cells[0]} × {cells[1]} × {cells[2]} cells"
        for step in STEPS:
            yield (name, "Newton, `discrete`", step, *flex(task, dof, cells, "discrete", step), False)
        for step in STEPS:
            count = round(step / longest)
            settings = f"`Euler`, {count} sub-steps" if count > 1 else "`Euler`"
            yield (name, settings, step, *flex(task, dof, cells, "Euler", step, count), False)
