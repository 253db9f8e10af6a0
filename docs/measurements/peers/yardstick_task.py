"""The task of the yardstick: a rubber block, a push, the instants at which all are compared, and the converged motions."""

import math
import time

import numpy as np
import scipy.sparse
import scipy.sparse.linalg
from block import Block

LENGTHS, CELLS = (0.2, 0.04, 0.05), (24, 4, 6)
YOUNG, POISSON, DENSITY = 1e6, 0.3, 1000.0
# The push: F sin^2(pi t / PERIOD) for one period, spread evenly over the free end; then the block rings for another one.
PERIOD, ANGLE = 0.16, 15.0
SMALL, LARGE = 0.2, 12.0
STEPS = (0.004, 0.001, 0.00025)
# All are compared at these instants.
EVERY = 0.004
DURATION = 2 * PERIOD
DIRECTION = np.array([0.0, math.sin(math.radians(ANGLE)), math.cos(math.radians(ANGLE))])


def amplitude(size, t):
    return size * math.sin(math.pi * t / PERIOD) ** 2 if t < PERIOD else 0.0


class Task:
    """The block, and what is read of its displacements: the mean of the pushed face and of the node in the middle, along y and z."""

    def __init__(self, size):
        self.size = size
        self.block = Block(LENGTHS, CELLS, DENSITY)

    def force(self, t):
        """Force at each node, shape (nodes, 3)."""
        return amplitude(self.size, t) * self.block.shares[:, None] * DIRECTION

    def read(self, displacements):
        """(under the push, far away), each along y and z, of displacements of all nodes."""
        return np.array([self.block.shares @ displacements[:, 1:], displacements[self.block.middle, 1:]])

    def march(self, step, advance, show):
        """Calls `advance(t, dt)` for each step, which sets the force and gives the seconds of the step alone, and `show()`.

        Gives the readings at all instants and the median of the seconds; stops where the motion is lost.
        """
        seconds, readings, every = [], [], round(EVERY / step)
        for n in range(round(DURATION / step)):
            seconds.append(advance(n * step, step))
            if (n + 1) % every == 0:
                readings.append(show())
                if not np.all(np.isfinite(readings[-1])) or np.abs(readings[-1]).max() > 10 * LENGTHS[0]:
                    return None, float(np.median(seconds))
        return np.array(readings), float(np.median(seconds))


def clock(call):
    """A function that calls `call` and gives the seconds of processor time it took, which other work on the machine leaves alone."""

    def timed(*arguments):
        start = time.process_time()
        call(*arguments)
        return time.process_time() - start

    return timed


def errors(readings, reference):
    """Relative L2 errors over all instants, under the push and far away."""
    return [float(np.linalg.norm((readings - reference)[:, i]) / np.linalg.norm(reference[:, i])) for i in range(2)]


def extrapolated(march, steps):
    """Richardson's extrapolation of a march of second order from steps h and h/2, and how far one of h/2 alone is from it."""
    coarse, fine = march(steps), march(2 * steps)
    best = fine + (fine - coarse) / 3
    return best, max(errors(fine, best))


def linear_reference(mass, stiffness, load, read, size, steps):
    """The motion of `M a + K u = amplitude(t) load` by the trapezoidal rule, extrapolated to small steps."""

    def march(count):
        h, every = DURATION / count, count // round(DURATION / EVERY)
        solve = scipy.sparse.linalg.splu((4 / h**2 * mass + stiffness).tocsc()).solve
        u = v = a = np.zeros(mass.shape[0])
        readings = []
        for n in range(1, count + 1):
            new = solve(amplitude(size, n * h) * load + mass @ (4 / h**2 * u + 4 / h * v + a))
            speed = 2 / h * (new - u) - v
            u, v, a = new, speed, 2 / h * (speed - v) - a
            if n % every == 0:
                readings.append(read @ u)
        return np.array(readings).reshape(-1, 2, 2)

    return extrapolated(march, steps)


def large_reference(task, steps):
    """The same of large displacements: St. Venant-Kirchhoff on the tetrahedra of the block, consistent mass, Newton's method."""
    block = task.block
    tets, nodes = block.tetrahedra, block.nodes
    gradients = np.zeros((len(tets), 4, 3))
    inverse = np.linalg.inv(nodes[tets[:, 1:]] - nodes[tets[:, :1]])
    gradients[:, 1:] = np.transpose(inverse, (0, 2, 1))
    gradients[:, 0] = -gradients[:, 1:].sum(axis=1)
    lame, shear = YOUNG * POISSON / (1 + POISSON) / (1 - 2 * POISSON), YOUNG / 2 / (1 + POISSON)
    dofs = (3 * tets[:, :, None] + np.arange(3)).reshape(len(tets), 12)
    rows, columns, count = np.repeat(dofs, 12, axis=1).ravel(), np.tile(dofs, (1, 12)).ravel(), 3 * len(nodes)
    free = np.setdiff1d(np.arange(count), (3 * block.held()[:, None] + np.arange(3)).ravel())

    def matrix(blocks):
        return scipy.sparse.csr_matrix((blocks.ravel(), (rows, columns)), (count, count))[free][:, free]

    share = np.einsum("e,ab->eab", DENSITY * block.volumes / 20, np.ones((4, 4)) + np.eye(4))
    mass = matrix(np.einsum("eab,ij->eaibj", share, np.eye(3)))

    def elastic(u, tangent):
        """Forces of the elements, and their tangent where it is asked for."""
        field = np.zeros(count)
        field[free] = u
        deformation = np.eye(3) + np.einsum("eai,eaj->eij", field.reshape(-1, 3)[tets], gradients)
        strain = 0.5 * (np.einsum("eki,ekj->eij", deformation, deformation) - np.eye(3))
        stress = lame * np.trace(strain, axis1=1, axis2=2)[:, None, None] * np.eye(3) + 2 * shear * strain
        # Gradients of the places, pushed by the deformation: d strain_jk = sym(F^T du grad).
        pushed = np.einsum("eij,eaj->eai", np.einsum("eij,ejk->eik", deformation, stress), gradients)
        forces = np.zeros(count)
        np.add.at(forces, dofs, (block.volumes[:, None, None] * pushed).reshape(len(tets), 12))
        if not tangent:
            return forces[free], None
        moved = np.einsum("eij,eaj->eai", deformation, gradients)
        across = np.einsum("eac,ebc->eab", gradients, gradients)
        metric = np.einsum("eik,ejk->eij", deformation, deformation)
        blocks = lame * np.einsum("eai,ebj->eaibj", moved, moved) + shear * np.einsum("ebi,eaj->eaibj", moved, moved)
        blocks += shear * np.einsum("eab,eij->eaibj", across, metric)
        blocks += np.einsum("eac,ecd,ebd,ij->eaibj", gradients, stress, gradients, np.eye(3), optimize=True)
        return forces[free], matrix(block.volumes[:, None, None, None, None] * blocks)

    def march(total):
        h, every = DURATION / total, total // round(DURATION / EVERY)
        u = v = a = np.zeros(len(free))
        readings = []
        for n in range(1, total + 1):
            load = task.force(n * h).ravel()[free]
            new = u + h * v + h**2 / 4 * a
            for iteration in range(40):
                # A tangent serves several iterations.
                inner, tangent = elastic(new, iteration % 8 == 0)
                if tangent is not None:
                    solve = scipy.sparse.linalg.splu((4 / h**2 * mass + tangent).tocsc()).solve
                change = solve(load - inner - mass @ (4 / h**2 * (new - u) - 4 / h * v - a))
                new = new + change
                if np.abs(change).max() < 1e-9:
                    break
            speed = 2 / h * (new - u) - v
            u, v, a = new, speed, 2 / h * (speed - v) - a
            if n % every == 0:
                field = np.zeros(count)
                field[free] = u
                readings.append(task.read(field.reshape(-1, 3)))
        return np.array(readings)

    return extrapolated(march, steps)
