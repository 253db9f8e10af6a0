"""Soft bodies of Newton (newton-physics) on the CPU in the task of the yardstick. Run by yardstick.py."""

import logging
import warnings

import numpy as np
import warp
from yardstick_task import DENSITY, POISSON, STEPS, YOUNG, clock

warp.config.quiet = True
warnings.filterwarnings("ignore")
logging.disable(logging.WARNING)
import newton  # noqa: E402

NAME = f"Newton {newton.__version__}"


def model_of(task, shear, lame):
    block = task.block
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
    builder.add_soft_mesh(
        pos=warp.vec3(0.0, 0.0, 0.0), rot=warp.quat_identity(), scale=1.0, vel=warp.vec3(0.0, 0.0, 0.0),
        vertices=[warp.vec3(*place) for place in block.nodes], indices=block.tetrahedra.ravel().tolist(), density=DENSITY,
        k_mu=shear, k_lambda=lame, k_damp=0.0, particle_radius=1e-4, add_surface_mesh_edges=False)
    masses = block.lumped()
    masses[block.held()] = 0.0
    builder.particle_mass[:] = masses.tolist()
    builder.color()
    return builder.finalize()


def soft(task, solver, step, substeps=1, iterations=None):
    """Readings of a soft body and the seconds of a step, which is `substeps` steps of Newton."""
    lame, shear = YOUNG * POISSON / (1 + POISSON) / (1 - 2 * POISSON), YOUNG / 2 / (1 + POISSON)
    if solver == "semi-implicit":
        # Its energy is that of Smith and others, whose constants for small strains are these.
        model = model_of(task, 4 / 3 * shear, lame + 5 / 6 * shear)
        solver = newton.solvers.SolverSemiImplicit(model, enable_tri_contact=False)
    else:
        model = model_of(task, shear, lame)
        if solver == "VBD":
            solver = newton.solvers.SolverVBD(model, iterations=iterations, particle_enable_self_contact=False,
                                              particle_enable_tile_solve=False)
        else:
            solver = newton.solvers.SolverXPBD(model, iterations=iterations)
    states, control = [model.state(), model.state()], model.control()
    rest = states[0].particle_q.numpy().astype(float)
    forces = warp.zeros(len(rest), dtype=warp.vec3)

    def many(dt):
        for _ in range(substeps):
            states[0].clear_forces()
            warp.copy(states[0].particle_f, forces)
            solver.step(states[0], states[1], control, None, dt)
            states.reverse()

    timed = clock(many)

    def advance(t, dt):
        forces.assign(task.force(t + dt / 2).astype(np.float32))
        return timed(dt / substeps)

    return task.march(step, advance, lambda: task.read(states[0].particle_q.numpy() - rest))


def rows(task):
    for step in STEPS:
        yield ("VBD", "10 iterations", step, *soft(task, "VBD", step, 1, 10), True)
    for step in STEPS:
        count = round(step / 0.0001 - 0.1)
        yield ("VBD", f"{count} sub-steps of 5 iterations", step, *soft(task, "VBD", step, count, 5), True)
    for step in STEPS:
        count = round(step / 0.000125)
        yield ("semi-implicit", f"{count} sub-steps", step, *soft(task, "semi-implicit", step, count), True)
    for step in STEPS:
        yield ("XPBD", "10 iterations", step, *soft(task, "XPBD", step, 1, 10), True)
