"""Soft pads on bodies of MuJoCo, coupled in both directions.

MuJoCo keeps its bodies, their joints, actuators and the contacts among them. A pad keeps its modes. Between the two
stand forces, one for each taxel that touches, which are solved for in each step: how a taxel yields under them is known
on both sides (by `Body.free_motion`, and the inverse of the inertia matrix of MuJoCo), and at the end of the step no
taxel is inside the other body, no force pulls, and none drags by more than friction allows. The same force, held over the
step, acts on both. Nothing is stiff, so nothing limits the step.
"""

import itertools
from dataclasses import dataclass

import mujoco
import numpy as np

from pad import AXES, taxels
from vademecum import SurfacePoint

#: Taxels this near to a geom at the end of a step, in m, take part in it.
REACH = 2e-4
#: Iterations for the forces at most, and the change in N at which they end.
ITERATIONS, DONE = 60, 1e-12


class Pad:
    """A pad: a file, and the site of MuJoCo that is the frame of its coordinates."""

    def __init__(self, file, site):
        self.site = site
        self.taxels = taxels(file.nodes)
        self.places = [SurfacePoint([int(node)]) for node in self.taxels]
        self.rest = np.asarray(file.nodes)[self.taxels]
        self.names = [[f"{taxel} {axis}" for axis in AXES] for taxel in range(len(self.taxels))]
        self.body = file.body()
        #: How taxels yield to forces held over a step, shape (n, 3, n, 3), m/N. It stays what it is.
        self.compliance = self._yields(self.body)
        # The part of it that the modes leave out, which answers at once.
        self.residual = self.compliance - self._yields(file.body(residual=False))
        #: Force on each taxel in the last step, in the axes of the pad, N: the reading of the sensor.
        self.forces = np.zeros((len(self.taxels), 3))
        #: Displacement of each taxel in the axes of the pad, m; and at the end of the coming step under these forces.
        self.moved, self.ahead = np.zeros((2, len(self.taxels), 3))

    def _yields(self, body):
        columns = []
        for name in itertools.chain(*self.names):
            body.clear()
            body.push_pattern(name)
            columns.append(body.free_motion(self.places))
        body.clear()
        n = len(self.taxels)
        return np.array(columns).reshape(n, 3, n, 3).transpose(2, 3, 0, 1).copy()

    def look_ahead(self):
        """Finds where the taxels are at the end of the coming step if the forces stay."""
        self.ahead = self.body.free_motion(self.places)

    def step(self, forces):
        """Moves on under these forces on the taxels."""
        self.moved = self.ahead + np.tensordot(self.compliance, forces - self.forces)
        self.forces = forces
        self.body.clear()
        for taxel in np.flatnonzero(forces.any(axis=1)):
            for name, force in zip(self.names[taxel], forces[taxel].tolist()):
                self.body.push_pattern(name, force)
        self.body.step()

    def energy(self):
        """Kinetic and elastic energy, J: of the modes, and of what answers at once."""
        return self.body.energy + 0.5 * np.vdot(self.forces, np.tensordot(self.residual, self.forces))


@dataclass
class Touches:
    """Places where a taxel of a pad may touch a geom in the coming step; all arrays have a row for each."""

    pad: np.ndarray
    taxel: np.ndarray
    geom: np.ndarray
    #: Normal, from the geom to the taxel, and two tangents: the rows of (n, 3, 3), in space.
    axes: np.ndarray
    #: Gap, and slide along both tangents, at the end of the step if no force acts: m.
    free: np.ndarray
    #: How the taxel moves against the geom with the velocities of MuJoCo, shape (n, 3, nv).
    jacobian: np.ndarray
    #: Force on the taxel in space, N.
    force: np.ndarray


class Coupled:
    """A world of MuJoCo with pads, which steps all of it. `pads` touch `geoms`, spheres and capsules by name."""

    def __init__(self, model, pads, geoms, friction=0.8):
        self.model, self.data, self.pads, self.friction = model, mujoco.MjData(model), list(pads), friction
        if model.opt.integrator != mujoco.mjtIntegrator.mjINT_EULER:
            raise ValueError("expected the integrator Euler; set <option integrator=\"Euler\"/>")
        if model.dof_damping.any() or model.dof_dampingpoly.any():
            raise ValueError("a joint has damping, which Euler takes implicitly; give it to an actuator (kv) instead")
        self.sites = [model.site(pad.site).id for pad in self.pads]
        self.geoms = [model.geom(name).id for name in geoms]
        for geom in self.geoms:
            if mujoco.mjtGeom(model.geom_type[geom]) not in (mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_CAPSULE):
                raise ValueError(f"geom {model.geom(geom).name!r} is no sphere and no capsule, which are all that pads touch")
        for pad in self.pads:
            if abs(pad.body.time_step / model.opt.timestep - 1.0) > 1e-9:
                raise ValueError(f"a pad steps by {pad.body.time_step} s, MuJoCo by {model.opt.timestep} s; make them alike")
        #: What touched, or was near, in the last step.
        self.touches = None
        #: Work of the actuators, and of the contacts among the bodies of MuJoCo, so far: J.
        self.work = 0.0
        mujoco.mj_forward(model, self.data)

    def step(self):
        """Moves all on by a step of MuJoCo."""
        m, d, h = self.model, self.data, self.model.opt.timestep
        given, before = d.qfrc_applied.copy(), d.qvel.copy()
        mujoco.mj_step1(m, d)
        for part in (mujoco.mj_fwdActuation, mujoco.mj_fwdAcceleration, mujoco.mj_fwdConstraint):
            part(m, d)
        self.touches = touches = self._near(d.qvel + h * d.qacc)
        if len(touches.pad):
            local = solve(self._operator(), touches.free, self.friction, self._guess())
            touches.force = np.einsum("cij,ci->cj", touches.axes, local)
        for number, pad in enumerate(self.pads):
            own = touches.pad == number
            forces = np.zeros_like(pad.forces)
            np.add.at(forces, touches.taxel[own], touches.force[own] @ self._turned(number))
            pad.step(forces)
        d.qfrc_applied[:] = given + np.einsum("cij,ci->j", touches.jacobian, touches.force)
        mujoco.mj_step2(m, d)
        d.qfrc_applied[:] = given
        self.work += 0.5 * h * (d.qfrc_actuator + d.qfrc_constraint) @ (before + d.qvel)

    def energy(self):
        """Energy of the bodies of MuJoCo, with that of gravity, and of the pads: J."""
        m, d = self.model, self.data
        mujoco.mj_fwdPosition(m, d)
        mujoco.mj_energyPos(m, d)
        mujoco.mj_fwdVelocity(m, d)
        mujoco.mj_energyVel(m, d)
        return float(d.energy.sum()) + sum(pad.energy() for pad in self.pads)

    def _turned(self, number):
        """Axes of a pad, the columns, in space."""
        return self.data.site_xmat[self.sites[number]].reshape(3, 3)

    def _near(self, velocity):
        """What may touch in the coming step, at the end of which MuJoCo without pads has this velocity."""
        m, d, h = self.model, self.data, self.model.opt.timestep
        found = []
        for number, (pad, site) in enumerate(zip(self.pads, self.sites)):
            turned, origin = self._turned(number), d.site_xpos[site]
            linear, angular = np.zeros((2, 3, m.nv))
            mujoco.mj_jacSite(m, d, linear, angular, site)
            now = origin + (pad.rest + pad.moved) @ turned.T
            own = _of_points(linear, angular, now - origin)
            # The end of the step under the forces of the last one, which is near the end that will be, and what of it
            # is due to these forces.
            pad.look_ahead()
            end = now + (pad.ahead - pad.moved) @ turned.T + h * own @ velocity
            due = np.tensordot(pad.compliance, pad.forces) @ turned.T
            for geom in self.geoms:
                centre, axis = d.geom_xpos[geom], d.geom_xmat[geom].reshape(3, 3)[:, 2]
                radius, half = m.geom_size[geom, :2]
                if mujoco.mjtGeom(m.geom_type[geom]) == mujoco.mjtGeom.mjGEOM_SPHERE:
                    half = 0.0
                linear, angular = np.zeros((2, 3, m.nv))
                mujoco.mj_jacGeom(m, d, linear, angular, geom)
                # Where the taxels are at the end of the step for who moves with the geom.
                seen = end - h * _of_points(linear, angular, end - centre) @ velocity
                core = centre + np.clip((seen - centre) @ axis, -half, half)[:, None] * axis
                distance = np.linalg.norm(seen - core, axis=1)
                near = np.flatnonzero(distance < radius + REACH)
                normal = (seen[near] - core[near]) / distance[near, None]
                other = _of_points(linear, angular, core[near] + radius * normal - centre)
                axes = _axes(normal)
                gap = distance[near] - radius - np.einsum("ci,ci->c", axes[:, 0], due[near])
                slide = np.einsum("cti,ci->ct", axes[:, 1:], end[near] - due[near] - now[near] - h * other @ velocity)
                free = np.column_stack([gap, slide])
                found.append((np.full(len(near), number), near, np.full(len(near), geom), axes, free, own[near] - other))
        columns = [np.concatenate(column) for column in zip(*found)]
        return Touches(*columns, force=np.zeros((len(columns[0]), 3)))

    def _operator(self):
        """How taxels move against geoms at the end of the step for each newton, in the axes of the contacts, m/N."""
        m, d, touches = self.model, self.data, self.touches
        n = len(touches.pad)
        rows = (touches.axes @ touches.jacobian).reshape(3 * n, m.nv)
        moved = np.empty_like(rows)
        mujoco.mj_solveM(m, d, moved, rows)
        w = (m.opt.timestep**2 * rows @ moved.T).reshape(n, 3, n, 3)
        for number, pad in enumerate(self.pads):
            own = slice(*np.searchsorted(touches.pad, [number, number + 1]))
            taxels = touches.taxel[own]
            axes = touches.axes[own] @ self._turned(number)
            k = len(taxels)
            yields = pad.compliance[taxels[:, None], :, taxels].transpose(0, 2, 1, 3).reshape(k, 3, 3 * k)
            turned = (axes @ yields).reshape(3 * k, k, 3).transpose(1, 0, 2) @ axes.transpose(0, 2, 1)
            w[own, :, own] += turned.transpose(1, 0, 2).reshape(k, 3, k, 3)
        return w.reshape(3 * n, 3 * n)

    def _guess(self):
        """The forces of the last step on the same taxels, in the axes of the contacts of this one."""
        last = np.zeros((len(self.touches.pad), 3))
        for number, pad in enumerate(self.pads):
            own = self.touches.pad == number
            last[own] = pad.forces[self.touches.taxel[own]] @ self._turned(number).T
        return np.einsum("cij,cj->ci", self.touches.axes, last)


#: `(a @ CROSS).reshape(3, 3) @ b` is the cross product of a and b.
CROSS = np.array([[0, 0, 0, 0, 0, -1, 0, 1, 0], [0, 0, 1, 0, 0, 0, -1, 0, 0], [0, -1, 0, 1, 0, 0, 0, 0, 0]], dtype=float)


def _of_points(linear, angular, arms):
    """Jacobians of points of a body, `arms` from the one whose Jacobians these are; shape (n, 3, nv)."""
    return linear - (arms @ CROSS).reshape(-1, 3, 3) @ angular


def _axes(normal):
    """Normals and two tangents of each, the rows of (n, 3, 3)."""
    turns = (normal @ CROSS).reshape(-1, 3, 3)
    first = turns[np.arange(len(normal)), :, np.abs(normal).argmin(axis=1)]
    first = first / np.sqrt((first**2).sum(axis=1))[:, None]
    return np.stack([normal, first, (turns @ first[:, :, None])[:, :, 0]], axis=1)


def solve(w, free, friction, guess):
    """Forces `f` of contacts whose gaps and slides are `u = free + w f`: `u_n >= 0`, `f_n >= 0`, one of them zero, and
    `|f_t| <= friction f_n`, equal to it and against the slide where there is one. Each of these is the fixed point of a
    projection of `f - r u`, by Newton's method on its kinks (Alart and Curnier). Shapes (3n, 3n) and (n, 3)."""
    n = len(free)
    diagonal = np.diag(w).reshape(n, 3)
    r = np.column_stack([1.0 / diagonal[:, 0]] + [2.0 / (diagonal[:, 1] + diagonal[:, 2])] * 2)
    step = np.eye(3 * n) - r.reshape(-1, 1) * w
    f = guess.copy()
    for _ in range(ITERATIONS):
        x = f - r * (free + (w @ f.ravel()).reshape(n, 3))
        push, drag = np.maximum(x[:, 0], 0.0), x[:, 1:]
        size, limit = np.linalg.norm(drag, axis=1), friction * push
        slips = (size > limit) & (push > 0.0)
        along = drag / np.where(size > 0.0, size, 1.0)[:, None]
        projected = np.column_stack([push, np.where((size > limit)[:, None], limit[:, None] * along, drag)])
        off = (f - projected).ravel()
        if np.abs(off).max() <= DONE:
            return projected
        # Derivative of the projection: nothing where open, all where it sticks, along the cone where it slips.
        p = np.eye(3) * (push > 0.0)[:, None, None]
        flat = np.eye(2) - along[:, :, None] * along[:, None]
        p[slips, 1:, 1:] = (limit / np.where(size > 0.0, size, 1.0))[slips, None, None] * flat[slips]
        p[slips, 1:, 0] = friction * along[slips]
        slope = np.eye(3 * n) - (p @ step.reshape(n, 3, 3 * n)).reshape(3 * n, 3 * n)
        f -= np.linalg.solve(slope, off).reshape(n, 3)
    raise RuntimeError(f"the forces of {n} contacts were not found in {ITERATIONS} iterations")
