"""Steps a vademecum file, from the part "The step" of `formats/vademecum-1.md`. Arithmetic is binary64."""

import math
from decimal import Decimal, localcontext

import numpy as np

from vademecum import Refused, need

EDGE = 16 * 2.0**-52
STAGE, INDEX, HAT = 0, 0, 1


class Values:
    """What the parameters may set: scales of body and regions, damping and step; else as built."""

    def __init__(self, meta, settings, scales):
        self.dt, self.alpha, self.beta = meta["time_step"], meta["alpha"], meta["beta"]
        self.stiffness, self.density = 1.0, 1.0
        self.kappa, self.rho = np.ones(meta["n_regions"]), np.ones(meta["n_regions"])
        for parameter in meta["parameters"]:
            value = settings.get(parameter["name"], parameter["nominal"])
            need(parameter["lower"] <= value <= parameter["upper"], "a parameter outside its range")
            self.set(parameter["role"], parameter["region"], value)
        unknown = set(settings) - {parameter["name"] for parameter in meta["parameters"]}
        need(not unknown, f"no such parameter: {unknown}")
        # The diagonal structure needs no parameter of the file for these.
        for name, value in scales.items():
            need(name in ("dt", "alpha", "beta", "stiffness", "density"), f"no such scale: {name}")
            setattr(self, name, value)

    def set(self, role, region, value):
        if role == 0:
            self.stiffness = value
        elif role == 1:
            self.kappa[region] = value
        elif role == 2:
            self.density = value
        elif role == 3:
            self.rho[region] = value
        elif role == 4:
            self.alpha = value
        elif role == 5:
            self.beta = value
        else:
            self.dt = value


def stage_numbers(stage, v):
    """`m̃`, `k̃` and `θ` of a stage, and the weights `a_j`, `b_j` of its history."""
    m = v.density * (stage["m"] + stage["d"] * v.dt * v.alpha)
    k = v.stiffness * (stage["k"] * v.dt**2 + stage["d"] * v.dt * v.beta)
    mass, damping, stiffness = stage["h"]
    a = v.density * (mass + v.dt * v.alpha * damping)
    b = v.stiffness * (v.dt**2 * stiffness + v.dt * v.beta * damping)
    return m, k, k / m, a, b


# --- The separated solution


def coordinate(axis, stage, theta, v):
    if axis["role"] == STAGE:
        return float(stage)
    powers = axis["exponents"]
    n = len(v.kappa)
    x = theta ** powers[0] * np.prod(v.kappa ** powers[1 : 1 + n]) * np.prod(v.rho ** powers[9 : 9 + n])
    for end, past in ((axis["lower"], x < axis["lower"]), (axis["upper"], x > axis["upper"])):
        if past:
            need(abs(x - end) <= EDGE * abs(end), f"outside the axis {axis['name']}")
            x = end
    return x


def factors_at(axis, points, factors, x):
    """The factor of every term at `x`; `factors` has a row per term."""
    if axis["kind"] == INDEX:
        return factors[:, int(x)]
    if axis["log"]:
        points, x = np.log(points), math.log(x)
    if axis["kind"] == HAT:
        return np.array([np.interp(x, points, row) for row in factors])
    weights = np.array([np.prod(points[i] - np.delete(points, i)) ** -1 for i in range(len(points))])
    if x in points:
        return factors[:, list(points).index(x)]
    shares = weights / (x - points)
    return factors @ shares / shares.sum()


def weights_of_terms(file, stage, theta, v):
    """`g_t`, the product over the axes."""
    n_terms = file.meta["n_terms"]
    points = file.section("AxisPoints").ravel()
    factors = file.section("Factors").ravel()
    g, at = np.ones(n_terms), 0
    for axis in file.meta["axes"]:
        n = axis["n_points"]
        table = factors[at * n_terms : (at + n) * n_terms].reshape(n_terms, n)
        g = g * factors_at(axis, points[at : at + n], table, coordinate(axis, stage, theta, v))
        at += n
    return g


# --- Scenes


class Residual:
    """What the modes leave out of static answers; zeros where the file has no section for it."""

    def __init__(self, file):
        self.file, self.nodes, self.pairs = file, file.meta["n_load_nodes"], {}
        self.there = "ContactResidual" in file
        if "ResidualPairs" in file:
            blocks = self.section("PairResidual", (-1, 3, 3))
            for (first, second), block in zip(file.section("ResidualPairs").reshape(-1, 2), blocks):
                self.pairs[int(first), int(second)] = block

    def section(self, name, shape):
        return self.file.section(name).reshape(shape)

    def between(self, shown, loaded):
        """`R` with the displacement of one loadable node and the force at another."""
        if shown == loaded:
            xx, xy, xz, yy, yz, zz = self.section("ContactResidual", (-1, 6))[shown]
            return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        if (shown, loaded) in self.pairs:
            return self.pairs[shown, loaded]
        if (loaded, shown) in self.pairs:
            return self.pairs[loaded, shown].T
        return np.zeros((3, 3))

    def node(self, node, forces, patterns):
        if not self.there or node >= self.nodes:
            return np.zeros(3)
        sum_ = sum((self.between(node, loaded) @ force for loaded, force in forces.items()), np.zeros(3))
        if "PatternResidual" in self.file:
            for index, amplitude in patterns.items():
                sum_ = sum_ + amplitude * self.section("PatternResidual", (-1, self.nodes, 3))[index, node]
        return sum_

    def probes(self, count, forces, patterns):
        sum_ = np.zeros(count)
        if count == 0:
            return sum_
        if self.there and "ProbeResidual" in self.file:
            table = self.section("ProbeResidual", (count, self.nodes, 3))
            for loaded, force in forces.items():
                sum_ = sum_ + table[:, loaded] @ force
        if "PatternProbeResidual" in self.file:
            for index, amplitude in patterns.items():
                sum_ = sum_ + amplitude * self.section("PatternProbeResidual", (-1, count))[index]
        return sum_

    def energy(self, forces):
        if not self.there:
            return 0.0
        work = (a @ self.between(m, n) @ b for m, a in forces.items() for n, b in forces.items())
        return 0.5 * float(sum(work))


def forces_of(pushes):
    """Forces at nodes, and amplitudes of patterns, of pairs of a load and its amplitude."""
    forces, patterns = {}, {}
    for push, amplitude in pushes:
        if "pattern" in push:
            patterns[push["pattern"]] = patterns.get(push["pattern"], 0.0) + amplitude
            continue
        for node, weight in zip(push["nodes"], push["weights"]):
            share = amplitude * weight * np.asarray(push["force"], dtype=np.float64)
            forces[int(node)] = forces.get(int(node), np.zeros(3)) + share
    return forces, patterns


class Scene:
    """What every structure has in common: outputs, energy, the acceleration at the start.

    Outputs take the loads of a state as pairs of a load and its amplitude; only the diagonal structure shows
    what they leave, and has a residual.
    """

    residual = None
    filtered, largest = ({}, {}), [0.0, 0.0]

    def __init__(self, file, settings=None, scales=None):
        self.file, self.meta = file, file.meta
        self.settings, self.scales = settings or {}, scales or {}
        self.v = Values(file.meta, settings or {}, scales or {})
        self.r = file.meta["n_modes"]
        self.stages = file.meta["scheme"]["stages"]
        self.finish = file.meta["scheme"]["finish"]
        self.instants = [0.0] + [stage["c"] for stage in self.stages]
        self.numbers = [stage_numbers(stage, self.v) for stage in self.stages]
        self.reduced_matrices()

    def reduced_matrices(self):
        """`M_r` and `K_r`; their sums over regions are taken only where a region's scale is not 1."""
        file, r, v = self.file, self.r, self.v
        self.mass = np.eye(r)
        if any(v.rho != 1.0):
            self.mass = np.tensordot(v.rho, file.section("RegionMass"), 1)
        if any(v.kappa != 1.0):
            self.stiffness = np.tensordot(v.kappa, file.section("RegionStiffness"), 1)
        elif "ReducedStiffness" in file:
            self.stiffness = file.section("ReducedStiffness").reshape(r, r)
        else:
            self.stiffness = np.diag(file.section("Eigenvalues").ravel())

    def row(self, node, component):
        """The row of `B` of a dof."""
        surface = self.meta["n_surface_nodes"]
        if node < surface:
            return self.file.section("SurfaceBasis")[node, component]
        return self.file.section("InteriorBasis")[node - surface, component]

    def displacement(self, y, node, pushes=()):
        moved = np.array([self.row(node, c) @ y[0] for c in range(3)])
        if self.residual:
            moved = moved + self.residual.node(node, *self.shown(pushes)) / self.v.stiffness
        return moved

    def probes(self, zeta, pushes=None):
        """With loads the displacement; without, also a velocity."""
        if "ProbeRows" not in self.file:
            return np.zeros(0)
        values = self.file.section("ProbeRows").reshape(-1, self.r) @ zeta
        if self.residual and pushes is not None:
            values = values + self.residual.probes(len(values), *self.shown(pushes)) / self.v.stiffness
        return values

    def energy(self, y, pushes=()):
        """`½ s_ρ ζ̇ᵀM_rζ̇ + ½ s_K ζᵀK_rζ` in joules, and what the residual stores."""
        velocity = y[1] / self.v.dt
        kinetic = self.v.density * velocity @ self.mass @ velocity
        moving = 0.5 * (kinetic + self.v.stiffness * y[0] @ self.stiffness @ y[0])
        if self.residual:
            moving = moving + self.residual.energy(self.shown(pushes)[0]) / self.v.stiffness
        return moving

    def shown(self, pushes):
        """Forces and amplitudes that the residual answers: filtered under stiffness-proportional damping."""
        return self.filtered if self.residual and self.v.beta > 0 else forces_of(pushes)

    def settle(self, pushes):
        """The residual in equilibrium with loads."""
        self.filtered, self.largest = ({}, {}), [0.0, 0.0]
        self.add_filtered(forces_of(pushes))

    def follow(self, starts, ends):
        """A step of the filter `β ẏ + y = F`, under loads that are linear over it."""
        if not self.residual:
            return
        if not self.v.beta > 0:
            self.filtered = ({}, {})
            self.add_filtered(forces_of(ends))
            return
        x = self.v.dt / self.v.beta
        keep, gone = math.exp(-x), -math.expm1(-x)
        end = x * (1 / 2 - x * (1 / 6 - x * (1 / 24 - x / 120))) if x < 1e-2 else 1 - gone / x
        drive = [(push, (gone - end) * p) for push, p in starts] + [(push, end * p) for push, p in ends]
        self.filtered = tuple({key: keep * value for key, value in part.items()} for part in self.filtered)
        self.add_filtered(forces_of(drive))

    def add_filtered(self, added):
        """Adds to the filtered forces, and drops what is below 1e-12 of the largest there has been."""
        parts = []
        for kind, (part, more) in enumerate(zip(self.filtered, added)):
            sums = {key: part.get(key, 0.0) + more.get(key, 0.0) for key in part | more}
            sizes = {key: np.abs(value).max() for key, value in sums.items()}
            largest = max([self.largest[kind], *sizes.values()])
            self.largest = [largest if k == kind else old for k, old in enumerate(self.largest)]
            parts.append({key: value for key, value in sums.items() if sizes[key] > 1e-12 * largest})
        self.filtered = tuple(parts)

    def acceleration(self, y, pushes):
        """Of the modes, under the loads of the state."""
        return y[2] / self.v.dt**2

    def reactions(self, y, pushes):
        """Force and moment that each support exerts on the body, under the loads of the state."""
        if "ReactionBasis" not in self.file:
            return np.zeros((0, 6))
        basis = self.file.section("ReactionBasis").reshape(-1, 6, self.r)
        forces, patterns = forces_of(pushes)
        moving = self.acceleration(y, pushes) + self.v.alpha * y[1] / self.v.dt
        total = self.v.density * basis @ moving
        for node, force in forces.items():
            total = total + self.file.section("ReactionLoads").reshape(len(basis), -1, 6, 3)[:, node] @ force
        for index, amplitude in patterns.items():
            total = total + amplitude * self.file.section("PatternReaction").reshape(-1, len(basis), 6)[index]
        return total

    def tensors(self, zeta, pushes):
        """Stress and strain at each point, under the loads of the state; shape (points, 12)."""
        if "StressPoints" not in self.file:
            return np.zeros((0, 12))
        points = self.file.section("StressPoints").reshape(-1, 2)
        kappa = np.array([self.v.kappa[q] if q < len(self.v.kappa) else 1.0 for q in points[:, 1]])
        scale = self.v.stiffness * kappa[:, None]
        stress = scale * (self.file.section("StressBasis").reshape(-1, 6, self.r) @ zeta)
        if self.residual:
            forces, patterns = self.shown(pushes)
            if "StressResidual" in self.file:
                table = self.file.section("StressResidual").reshape(len(points), -1, 6, 3)
                for node, force in forces.items():
                    stress = stress + table[:, node] @ force
            if "PatternStress" in self.file:
                table = self.file.section("PatternStress").reshape(-1, len(points), 6)
                for index, amplitude in patterns.items():
                    stress = stress + amplitude * table[index]
        if "Compliance" in self.file:
            triangles = self.file.section("Compliance").reshape(-1, 21)
            rows, columns = np.triu_indices(6)
            compliance = np.zeros((len(triangles), 6, 6))
            compliance[:, rows, columns] = compliance[:, columns, rows] = triangles
            strain = np.einsum("pij,pj->pi", compliance[points[:, 1]], stress) / scale
            strain[:, 3:] /= 2
            return np.hstack([stress, strain])
        young, poisson = self.file.section("ElasticConstants").reshape(-1, 2)[points[:, 1]].T[:, :, None]
        trace = stress[:, :3].sum(axis=1, keepdims=True) * np.array([1, 1, 1, 0, 0, 0])
        strain = ((1 + poisson) * stress - poisson * trace) / (scale * young)
        return np.hstack([stress, strain])

    def start(self, zeta, velocity, force):
        """The state of displacement and velocity, with the acceleration that belongs to the force `BᵀF`."""
        v, mass, stiffness = self.v, self.mass, self.stiffness
        pull = v.stiffness * stiffness @ zeta
        damping = v.alpha * v.density * mass @ velocity + v.beta * v.stiffness * stiffness @ velocity
        acceleration = np.linalg.solve(v.density * mass, force - pull - damping)
        return np.array([zeta, v.dt * velocity, v.dt**2 * acceleration])

    def carry(self, before, y):
        """The state of the scene `before` at the parameters of this one."""
        ratio = self.v.dt / before.v.dt
        self.filtered, self.largest = before.filtered, before.largest
        return y * np.array([[1.0], [ratio], [ratio**2]])[: len(y)]

    def contact(self, nodes, weights, force):
        """`BᵀF` of a contact."""
        rows = [w * f * self.row(n, c) for n, w in zip(nodes, weights) for c, f in enumerate(force)]
        return np.sum(rows, axis=0)

    def pattern(self, index):
        return self.file.section("PatternBasis").reshape(-1, self.r)[index]


class Linear(Scene):
    """The diagonal or the block structure. A load is a list with `HᵢᵀF` for every stage."""

    def step(self, y, loads):
        """One step. `loads` holds pairs of a reduced load and its amplitudes at `instants`."""
        increments = []
        for i, (stage, (m, k, _, a, b)) in enumerate(zip(self.stages, self.numbers)):
            x = self.v.stiffness * self.v.dt**2 / k * self.times_e(i, y[0])
            history = [(1, y[1]), (2, y[2])] + [(3 + l, x_l) for l, x_l in enumerate(increments)]
            for j, z in history:
                x = x + a[j] / m * (z + self.times_e(i, z)) - b[j] / k * self.times_e(i, z)
            for reduced, amplitudes in loads:
                seen = sum(f * p for f, p in zip(stage["f"], amplitudes))
                x = x + self.v.dt**2 / m * seen * reduced[i]
            increments.append(x)
        z = np.array([y[1], y[2], *increments])
        new = self.finish[:, 1 : 1 + len(z)] @ z
        new[0] += y[0]
        return new


class Diagonal(Linear):
    def __init__(self, file, settings=None, scales=None):
        super().__init__(file, settings, scales)
        need(file.meta["diagonal"], "NoStructure")
        need(self.stages, "NoStructure")
        self.residual = Residual(file)
        self.lam = file.section("Eigenvalues").ravel()
        self.e = [-theta * self.lam / (1 + theta * self.lam) for _, _, theta, _, _ in self.numbers]

    def times_e(self, i, z):
        return self.e[i] * z

    def load_of_contact(self, nodes, weights, force):
        return [self.contact(nodes, weights, force) * (1 + e) for e in self.e]

    def load_of_pattern(self, index):
        return [self.pattern(index) * (1 + e) for e in self.e]


def responses(w2, s):
    """`S`, `φ` and `ψ` of a mode: their power series, with digits enough for what cancels in it."""
    w2, s = Decimal(float(w2)), Decimal(float(s))
    with localcontext() as context:
        # The terms grow to e^(w + 2s), and their sum is no smaller than e^(-2s) by far.
        context.prec = 50 + int(2 * w2.sqrt() + 4 * s)
        before, now, n = Decimal(0), Decimal(1), 1
        sums = [Decimal(0)] * 3
        while before or now:
            for place, by in enumerate((1, n + 1, (n + 1) * (n + 2))):
                sums[place] += now / by
            before, now, n = now, -(2 * s * n * now + w2 * before) / (n * (n + 1)), n + 1
            small = max(abs(before), abs(now)) < abs(sums[2]) * Decimal(10) ** -40
            if small and n > 2 * (w2.sqrt() + 2 * s):
                break
        return [float(x) for x in sums]


def unit(n):
    """The unit matrix of `Decimal`."""
    return np.array([[Decimal(int(i == j)) for j in range(n)] for i in range(n)])


def exponential(matrix):
    """Of a square array of `Decimal`, by its power series, with digits enough for what cancels in it."""
    norm = max(sum(abs(x) for x in row) for row in matrix)
    with localcontext() as context:
        context.prec = 50 + int(norm)
        term = total = unit(len(matrix))
        n = 1
        while n < 2 * norm or max(abs(x) for x in term.ravel()) > Decimal(10) ** -50:
            term = term.dot(matrix) / n
            total, n = total + term, n + 1
        return total


class Exact(Scene):
    """The diagonal structure, each mode moved in closed form, or all of them together where dashpots couple
    them. The state is `(ζ, Δt ζ̇)`, a load `BᵀF`."""

    def __init__(self, file, settings=None, scales=None):
        super().__init__(file, settings, scales)
        need(file.meta["diagonal"], "NoStructure")
        self.residual, self.instants, v = Residual(file), [0.0, 1.0], self.v
        lam = v.stiffness * file.section("Eigenvalues").ravel() / v.density
        ratios = file.section("DampingRatios").ravel() if "DampingRatios" in file else np.zeros(self.r)
        sigma = 0.5 * (v.alpha + v.beta * lam) + ratios * np.sqrt(lam)
        w2, s, dt2 = lam * v.dt**2, sigma * v.dt, v.dt**2
        self.lam, self.sigma, r = lam, sigma, self.r
        self.rows = file.section("DampingRows").reshape(-1, r) if "DampingRows" in file else np.zeros((0, r))
        if len(self.rows):
            self.couple(w2, np.diag(2 * s) + v.dt / v.density * self.rows.T @ self.rows)
            return
        impulse, phi, psi = np.array([responses(*mode) for mode in zip(w2, s)]).T
        self.d = np.array([[-w2 * phi, impulse], [-w2 * impulse, -2 * s * impulse - w2 * phi]])
        self.held, self.rising = dt2 * np.array([phi, impulse]), dt2 * np.array([psi, phi])

    def couple(self, w2, g):
        """Coupled modes: the exponential of the state, a load that is 1, and one that rises to 1."""
        r, zero, one = self.r, np.zeros((self.r,) * 2), np.eye(self.r)
        motion = [[zero, one, zero, zero], [-np.diag(w2), -g, one, zero]]
        whole = np.block([*motion, [zero, zero, zero, one], [zero] * 4])
        moved = exponential(np.vectorize(lambda x: Decimal(float(x)), otypes=[object])(whole))
        less = moved - unit(4 * r)
        self.d, dt2 = less[: 2 * r, : 2 * r].astype(float).reshape(2, r, 2, r), self.v.dt**2
        self.held = dt2 * moved[: 2 * r, 2 * r : 3 * r].astype(float).reshape(2, r, r)
        self.rising = dt2 * moved[: 2 * r, 3 * r :].astype(float).reshape(2, r, r)

    def load_of_contact(self, nodes, weights, force):
        return self.contact(nodes, weights, force)

    def load_of_pattern(self, index):
        return self.pattern(index)

    def start(self, zeta, velocity, force):
        """No acceleration: the force at the start is met by the step."""
        return np.array([zeta, self.v.dt * velocity])

    def acceleration(self, y, pushes):
        """The one that the equation of motion demands."""
        forces, patterns = forces_of(pushes)
        nodes = [self.contact([node], [1.0], force) for node, force in forces.items()]
        all_ = [amplitude * self.pattern(index) for index, amplitude in patterns.items()] + nodes
        damped = 2 * self.sigma * y[1] + self.rows.T @ (self.rows @ y[1]) / self.v.density
        return sum(all_, np.zeros(self.r)) / self.v.density - damped / self.v.dt - self.lam * y[0]

    def part(self, length):
        """The scene of a part of a step."""
        return Exact(self.file, self.settings, {**self.scales, "dt": length})

    def step(self, y, loads):
        """One step. `loads` holds pairs of a reduced load and its amplitudes at start and end."""
        zero = np.zeros(self.r)
        first = sum((p[0] * load for load, p in loads), zero)
        change = sum(((p[1] - p[0]) * load for load, p in loads), zero)
        if len(self.rows):
            added = (self.held @ first + self.rising @ change) / self.v.density
            return y + np.einsum("iajb,jb->ia", self.d, y) + added
        added = (self.held * first + self.rising * change) / self.v.density
        return y + np.einsum("ijk,jk->ik", self.d, y) + added


class Strain(Scene):
    """The strain structure. The state is `(ζ, Δt ζ̇)`, a load `BᵀF`; the matrices are dense here."""

    def __init__(self, file, settings=None, scales=None):
        scales = dict(scales or {})
        self.viscosity = scales.pop("viscosity", 1 / 18)
        n, n1, self.m, substeps = (int(x) for x in file.section("StrainSizes").ravel())
        self.substeps = scales.pop("substeps", substeps)
        super().__init__(file, settings, scales)
        self.instants, v, r = [0.0, 1.0], self.v, self.r
        lead = n + n1
        need(1 <= n and lead <= r <= self.m, "Count")
        linear = np.zeros((self.m, r))
        linear[:r, :lead] = file.section("StrainLinear").reshape(r, lead)
        sigma = np.linalg.norm(linear, axis=1)
        for place in range(lead, r):
            omega = file.section("StrainTail").ravel()[place - lead]
            linear[place, place] = sigma[place] = omega
        pairs = [(a, b) for a in range(n) for b in range(a, n)]
        pairs += [(a, b) for a in range(n) for b in range(n, lead)]
        quadratic = np.zeros((self.m, r, r))
        for column, (a, b) in zip(file.section("StrainQuadratic").reshape(self.m, len(pairs)).T, pairs):
            quadratic[:, a, b] += 0.5 * column
            quadratic[:, b, a] += 0.5 * column
        self.k = v.dt / self.substeps
        scale = math.sqrt(v.stiffness / v.density)
        self.linear, self.quadratic = scale * linear, scale * quadratic
        squares = (0.5 * self.k * scale * sigma) ** 2
        self.weight = 1 + 2 * v.beta / self.k + self.viscosity * squares
        self.inertia = np.ones(r)
        if "StrainModes" in file.entries:
            half = 0.5 * self.k * scale * file.section("StrainModes").ravel()
            fitted = (0 < half) & (half <= math.pi / 4)
            self.inertia[fitted] = (half[fitted] / np.tan(half[fitted])) ** 2
        self.root = np.sqrt(self.inertia)

    def reduced_matrices(self):
        pass

    def load_of_contact(self, nodes, weights, force):
        return self.contact(nodes, weights, force)

    def load_of_pattern(self, index):
        return self.pattern(index)

    def start(self, zeta, velocity, force):
        return np.array([zeta, self.v.dt * velocity])

    def strain(self, q, p):
        """`z(q, p)`, which is the strain where both are the same."""
        return self.linear @ (q + p) / 2 + self.quadratic @ p @ q

    def sub_step(self, mean, p, force):
        late, early = mean + p / 2, mean - p / 2
        z, g = self.strain(late, early), self.linear + 2 * self.quadratic @ late
        push = self.k**2 / 2 * (force / self.v.density - g.T @ z)
        matrix = (1 + self.k * self.v.alpha / 2) * np.diag(self.inertia)
        matrix = matrix + self.k**2 / 4 * g.T @ (self.weight[:, None] * g)
        d = np.linalg.solve(matrix, self.inertia * p + push)
        return mean + d, 2 * d - p

    def step(self, y, loads):
        """One step. `loads` holds pairs of a reduced load and its amplitudes at start and end."""
        mean, p = y[0], y[1] / (self.substeps * self.root)
        for part in range(self.substeps):
            share = (part + 0.5) / self.substeps
            force = sum(((a[0] + share * (a[1] - a[0])) * load for load, a in loads), np.zeros(self.r))
            mean, p = self.sub_step(mean, p, force)
        return np.array([mean, p * self.substeps * self.root])

    def energy(self, y, pushes=()):
        p = y[1] / (self.substeps * self.root)
        z, velocity = self.strain(y[0] + p / 2, y[0] - p / 2), y[1] / self.v.dt
        return 0.5 * self.v.density * (velocity @ velocity + z @ z)


class Block(Linear):
    def __init__(self, file, settings=None, scales=None):
        super().__init__(file, settings, scales)
        need(file.meta["block"], "NoStructure")
        self.g = [weights_of_terms(file, i, n[2], self.v) for i, n in enumerate(self.numbers)]
        terms = file.section("BlockState")
        self.e = [np.tensordot(g, terms, 1) for g in self.g]

    def times_e(self, i, z):
        return self.e[i] @ z

    def load_of_contact(self, nodes, weights, force):
        plain = self.contact(nodes, weights, force)
        blocks = self.file.section("BlockLoad")
        reduced = []
        for g in self.g:
            rows = sum(w * g @ blocks[n] for n, w in zip(nodes, weights)).reshape(3, self.r)
            reduced.append(plain + np.asarray(force) @ rows)
        return reduced

    def load_of_pattern(self, index):
        blocks = self.file.section("PatternBlock")[index]
        return [self.pattern(index) + g @ blocks for g in self.g]


class Canonical(Scene):
    """The chapter's structure. A load is a position, a magnitude and a direction."""

    def __init__(self, file, settings=None, scales=None):
        super().__init__(file, settings, scales)
        need("CanonicalParts" in file, "NoStructure")
        self.positions = [int(n) for n in file.section("CanonicalPositions").ravel()]
        self.direction = file.section("CanonicalDirection").ravel() if "CanonicalDirection" in file else None
        axes = iter(file.section("CanonicalAxes").reshape(-1, 6))
        factors = file.section("CanonicalFactors").ravel()
        terms = file.section("CanonicalTerms").reshape(-1, self.r)
        self.parts = []
        for stage, n_axes, n_terms in file.section("CanonicalParts").reshape(-1, 3):
            part = {"stage": int(stage), "axes": [], "terms": terms[:n_terms]}
            terms = terms[n_terms:]
            for _ in range(n_axes):
                role, index, lower, upper, points, factor = next(axes)
                length = int(points) * int(n_terms)
                part["axes"].append({"role": int(role), "index": int(index), "lower": lower, "upper": upper,
                                     "factor": factor, "values": factors[:length].reshape(int(points), -1)})
                factors = factors[length:]
            roles = {axis["role"] for axis in part["axes"]}
            part["state"], part["load"] = min(roles) <= 5, max(roles) >= 6
            self.parts.append(part)

    def reach(self, place):
        """The farthest end of all axes of one place of the state."""
        axes = [axis for part in self.parts for axis in part["axes"] if axis["role"] == place]
        return max(max(abs(axis["lower"]), abs(axis["upper"])) / axis["factor"] for axis in axes)

    def load_of_contact(self, nodes, weights, force):
        """Position and magnitude of each node that has a share, and the direction."""
        force = np.asarray(force, dtype=np.float64)
        if self.direction is not None:
            magnitude, direction = float(force @ self.direction), self.direction
        else:
            magnitude = float(np.linalg.norm(force))
            direction = force / magnitude
        shares = [(n, w) for n, w in zip(nodes, weights) if w != 0.0]
        need(all(n in self.positions for n, _ in shares), "a node that is no load position")
        return [(self.positions.index(n), w * magnitude, direction) for n, w in shares]

    def value(self, part, z, load):
        position, magnitude, direction = load
        product = np.ones(len(part["terms"]))
        for axis in part["axes"]:
            role, index = axis["role"], axis["index"]
            if role <= 5:
                x = axis["factor"] * z[role][index]
            else:
                x = (magnitude, direction[index] if role == 7 else 0.0, float(position))[role - 6]
            need(axis["lower"] <= x <= axis["upper"], f"outside axis {role} {index}")
            product = product * self.factor(axis, x)
        return product @ part["terms"]

    @staticmethod
    def factor(axis, x):
        """The factors of all terms at `x`: piecewise linear over equidistant points, of which one may be all."""
        values = axis["values"]
        if len(values) == 1:
            return values[0]
        spot = (x - axis["lower"]) / (axis["upper"] - axis["lower"]) * (len(values) - 1)
        cell = min(int(spot), len(values) - 2)
        share = spot - cell
        return (1 - share) * values[cell] + share * values[cell + 1]

    def step(self, y, loads):
        z = list(y)
        none = (0, 0.0, np.zeros(3))
        for i, stage in enumerate(self.stages):
            seen = []
            for shares, amplitudes in loads:
                p = sum(f * q for f, q in zip(stage["f"], amplitudes))
                seen += [(position, p * magnitude, direction) for position, magnitude, direction in shares]
            zeta = np.zeros(self.r)
            for part in (part for part in self.parts if part["stage"] == i):
                if part["state"]:
                    need(not part["load"] or len(seen) <= 1, "one load at a time")
                    zeta = zeta + self.value(part, z, seen[0] if part["load"] and seen else none)
                else:
                    zeta = zeta + sum((self.value(part, z, load) for load in seen), np.zeros(self.r))
            z.append(zeta)
        return self.finish[:, : len(z)] @ np.array(z)


STRUCTURES = {
    "diagonal": Diagonal, "exact": Exact, "block": Block, "canonical": Canonical, "strain": Strain
}
__all__ = ["Block", "Canonical", "Diagonal", "Exact", "Refused", "STRUCTURES", "Strain"]
