"""Linear reduced models of the exported matrices in the task of the yardstick: NumPy and pyMOR. Run by yardstick.py."""

import time

import numpy as np
import scipy.sparse.linalg
from yardstick_task import DURATION, EVERY, PERIOD, STEPS, amplitude, clock

NAME = "NumPy and SciPy"
MODES = 16


def modes(model):
    """Eigenvalues and vectors of the lowest natural modes by SciPy, computed once."""
    if not hasattr(model, "modes"):
        model.modes = scipy.sparse.linalg.eigsh(model.stiffness, MODES, model.mass, sigma=0.0)
    return model.modes


def modal(task, model, step):
    """Modal superposition in NumPy: each mode moves exactly under the force in the middle of the step, held over it."""
    values, vectors = modes(model)
    frequencies, load = np.sqrt(values), vectors.T @ model.load
    cosine, sine = np.cos(frequencies * step), np.sin(frequencies * step)
    state, force, read = np.zeros((2, MODES)), np.zeros(MODES), model.read @ vectors
    # (q, q' / w) turns about the static answer f / w².
    turn, kept = np.array([[cosine, sine], [-sine, cosine]]), [state]

    def once():
        static = force / values
        kept[0] = turn[:, 0] * (kept[0][0] - static) + turn[:, 1] * kept[0][1]
        kept[0][0] += static

    timed = clock(once)

    def advance(t, dt):
        force[:] = amplitude(task.size, t + dt / 2) * load
        return timed()

    return task.march(step, advance, lambda: (read @ kept[0][0]).reshape(2, 2))


def midpoint(task, model, step):
    """pyMOR: its second-order model projected on the same modes, by its implicit midpoint rule; the mean time of its steps."""
    from pymor.algorithms.timestepping import ImplicitMidpointTimeStepper
    from pymor.core.logger import set_log_levels
    from pymor.models.iosys import SecondOrderModel
    from pymor.reductors.basic import SOLTIPGReductor

    set_log_levels({"pymor": "ERROR"})
    _, vectors = modes(model)
    full = SecondOrderModel.from_matrices(model.mass, 0 * model.mass, model.stiffness, model.load[:, None], model.read)
    basis = full.M.source.from_numpy(vectors)
    count = round(DURATION / step)
    reduced = SOLTIPGReductor(full, basis, basis).reduce().to_lti()
    reduced = reduced.with_(T=DURATION, time_stepper=ImplicitMidpointTimeStepper(count))
    push = f"[{task.size} * sin(pi * t[0] / {PERIOD})**2 * (t[0] < {PERIOD})]"
    # The first run compiles the expression of the push; answers are not to be remembered.
    reduced.disable_caching()
    reduced.output(input=push)
    start = time.process_time()
    output = reduced.output(input=push)
    seconds = (time.process_time() - start) / count
    return output.T[:: round(EVERY / step)][1:].reshape(-1, 2, 2), seconds


def rows(task, models):
    for model, name, own in models:
        for step in STEPS:
            yield (name, f"{MODES} modes, exact", step, *modal(task, model, step), own)


def pymor_rows(task, same):
    for step in STEPS:
        yield ("modal projection", f"{MODES} modes, implicit midpoint", step, *midpoint(task, same, step), True)
