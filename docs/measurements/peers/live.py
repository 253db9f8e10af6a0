"""pyMOR's affine reduced basis on the matrices and at the points that `live_regions -o FOLDER` wrote.

    live.py FOLDER SIZE[,SIZE...]

Basis: POD of 16 natural modes at 65 points of the box (the centre and a Sobol sequence), divided by their
eigenvalues, in the mass product. A change is the projected operator at the values and the 32 lowest modes of
SciPy; errors are those of all modes of the basis beside all natural modes of the full matrices, in closed form.
"""

import sys
import time
from pathlib import Path

import numpy as np
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg
from scipy.stats import qmc

from pymor.algorithms.pod import pod
from pymor.algorithms.projection import project
from pymor.core.logger import set_log_levels
from pymor.operators.constructions import LincombOperator
from pymor.operators.numpy import NumpyMatrixOperator
from pymor.parameters.functionals import ProjectionParameterFunctional
from pymor.vectorarrays.numpy import NumpyVectorSpace

set_log_levels({"pymor": "ERROR"})
RANGE, BETA, SAMPLES, MODES, STEPPED, STEPS, PUSHED = 3.0, 1e-3, 65, 16, 32, 200, 40


def matrix(path):
    rows, columns, values = np.fromfile(path).reshape(-1, 3).T
    return scipy.sparse.coo_matrix((values, (rows.astype(int), columns.astype(int)))).tocsc()


def history(eigenvalues, force, step):
    """Modal displacements at all steps under a force that is held over the first PUSHED of them."""
    sigma = 0.5 * BETA * eigenvalues
    root = np.sqrt((sigma**2 - eigenvalues).astype(complex))
    first, second = -sigma + root, -sigma - root

    def after(times):
        held = np.outer(first, times), np.outer(second, times)
        swing = (second[:, None] * np.exp(held[0]) - first[:, None] * np.exp(held[1])) / (second - first)[:, None]
        return np.where(times > 0, (1.0 - swing).real, 0.0) * (force / eigenvalues)[:, None]

    times = step * np.arange(1, STEPS + 1)
    return after(times) - after(np.maximum(times - PUSHED * step, 0.0))


def median_time(work, count=51):
    times = []
    for k in range(count):
        start = time.perf_counter()
        work(k)
        times.append(time.perf_counter() - start)
    return sorted(times)[count // 2]


def main():
    folder, sizes = Path(sys.argv[1]), [int(size) for size in sys.argv[2].split(",")]
    mass = matrix(folder / "mass.bin")
    regions = [matrix(folder / f"stiffness-{q}.bin") for q in range(len(list(folder.glob("stiffness-*.bin"))))]
    dofs = np.loadtxt(folder / "dofs.txt")
    count, n = len(regions), mass.shape[0]

    def stiffness(values):
        return sum(value * own for value, own in zip(values, regions)).tocsc()

    start = time.perf_counter()
    sobol = qmc.Sobol(count, seed=1).random(SAMPLES - 1)
    samples = [np.ones(count), *(RANGE ** (2.0 * sobol - 1.0))]
    snapshots = []
    for values in samples:
        eigenvalues, vectors = scipy.sparse.linalg.eigsh(stiffness(values), MODES, mass, sigma=0.0)
        snapshots.append(vectors / eigenvalues)
    space = NumpyVectorSpace(n)
    pool = space.from_numpy(np.hstack(snapshots))
    product = NumpyMatrixOperator(mass)
    basis, _ = pod(pool, product=product, modes=max(sizes), rtol=0.0, atol=0.0, orth_tol=1e-12)
    offline = time.perf_counter() - start
    functionals = [ProjectionParameterFunctional("kappa", count, index=q) for q in range(count)]
    affine = LincombOperator([NumpyMatrixOperator(own) for own in regions], functionals)

    points = np.loadtxt(folder / "points.txt", ndmin=2)
    exact = []
    for row in points:
        values, step, place, direction = row[:count], row[count], row[count + 1 : count + 4], row[count + 4 :]
        near = np.abs(dofs[:, :3] - place).max(axis=1) < 1e-9
        force = np.where(near, direction[dofs[:, 3].astype(int)], 0.0)
        eigenvalues, vectors = scipy.linalg.eigh(stiffness(values).toarray(), mass.toarray())
        exact.append((values, step, force, vectors @ history(eigenvalues, vectors.T @ force, step)))

    print("| basis | offline \\[s\\] | set \\[µs\\] | a step \\[ns\\] | worst error, random points | corners |")
    print("|---|---|---|---|---|---|")
    for size in sizes:
        own = basis[: min(size, len(basis))]
        reduced = project(affine, own, own)
        vectors = own.to_numpy()
        vectors = vectors if vectors.shape[0] == n else vectors.T

        def modes(values, most=None):
            matrix = reduced.assemble(reduced.parameters.parse({"kappa": values})).matrix
            subset = None if most is None else [0, most - 1]
            return scipy.linalg.eigh(matrix, subset_by_index=subset)

        errors = []
        for values, step, force, motion in exact:
            eigenvalues, shapes = modes(values)
            shapes = vectors @ shapes
            difference = shapes @ history(eigenvalues, shapes.T @ force, step) - motion
            norm = [np.einsum("it,it->", x, mass @ x) for x in (difference, motion)]
            errors.append(np.sqrt(norm[0] / norm[1]))
        half = len(errors) // 2
        change = median_time(lambda k: modes(RANGE ** np.sin(k + np.arange(count)), STEPPED))
        step_map, push, state = np.ones((3, STEPPED)), np.ones((2, STEPPED)), np.zeros((2, STEPPED))

        def step_once(_):
            for _ in range(100):
                displacement, rate = state
                state[0] = step_map[0] * displacement + step_map[1] * rate + push[0]
                state[1] = step_map[1] * displacement + step_map[2] * rate + push[1]
            state[:] = 0.0

        step = median_time(step_once) / 100
        print(
            f"| {len(own)} | {offline:.1f} | {1e6 * change:.0f} | {1e9 * step:.0f} "
            f"| {max(errors[:half]):.1e} | {max(errors[half:]):.1e} |"
        )


if __name__ == "__main__":
    main()
