"""SciPy, NumPy and pyMOR on exported matrices: the same problem, scenario, scheme and error as `vademecum-lab bench`.

    peers.py OUTPUT     reads OUTPUT/matrices-R and OUTPUT/bench/bench.json, writes OUTPUT/peers.json and OUTPUT/peers.md

What a step is: the state before to the state after, loads known. Reduced steps are timed in bursts of 32, as ours are; every
method takes its turn in each round. Errors are relative L2 over all dofs and steps in the mass norm, against the full-order
march with the same scheme and step, as `trajectory_error` is.
"""

import json
import statistics
import sys
import time
from pathlib import Path

import numpy as np
import scipy.io
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg

BURST, BURSTS, ROUNDS, FULL_STEPS = 32, 200, 5, 16


class Model:
    """The exported files (formats/matrices-1.md)."""

    def __init__(self, folder):
        self.about = json.loads((folder / "model.json").read_text())
        if self.about["scheme"]["name"] != "bathe":
            sys.exit("peers: written for Bathe's scheme")
        self.mass = scipy.io.mmread(folder / "mass.mtx").tocsc()
        self.stiffness = scipy.io.mmread(folder / "stiffness.mtx").tocsc()
        self.basis = np.load(folder / "basis.npy")
        self.loads = np.load(folder / "loads.npy")
        self.dt, self.steps = self.about["time_step"], self.about["steps"]
        self.alpha, self.beta = self.about["alpha"], self.about["beta"]

    def factors(self, t):
        """f_j(t) of formats/scenario-1.md."""
        t *= 1 + 1e-9

        def factor(when):
            end = np.inf if when["end"] is None else when["end"]
            if t < when["start"] or t >= end:
                return 0.0
            return min((t - when["start"]) / when["ramp"], 1.0) if when["ramp"] > 0 else 1.0

        return np.array([factor(when) for when in self.about["loads"]])


class Bathe:
    """Bathe's two sub-steps (chapter eqs. 5.5, 5.6, with damping) on any M and K with `@`, `+` and a factor in front.

    `factorize` turns a stage's matrix into the function that solves with it.
    """

    def __init__(self, mass, stiffness, model, factorize):
        h, self.mass = model.dt, mass
        self.damped = model.alpha != 0 or model.beta != 0
        self.damping = model.alpha * mass + model.beta * stiffness
        self.h = h
        self.half = factorize((16 / h**2 + 4 / h * model.alpha) * mass + (1 + 4 / h * model.beta) * stiffness)
        self.end = factorize((9 / h**2 + 3 / h * model.alpha) * mass + (1 + 3 / h * model.beta) * stiffness)

    def step(self, state, force_half, force_end):
        u, v, a = state
        h = self.h
        right = force_half + self.mass @ (16 / h**2 * u + 8 / h * v + a)
        if self.damped:
            right = right + self.damping @ (4 / h * u + v)
        half = self.half(right)
        v_half = 4 / h * (half - u) - v
        right = force_end + self.mass @ (28 / h**2 * half - 19 / h**2 * u - 5 / h * v)
        if self.damped:
            right = right + self.damping @ (4 / h * half - 1 / h * u)
        end = self.end(right)
        v_end = 1 / h * (u - 4 * half + 3 * end)
        return end, v_end, 1 / h * (v - 4 * v_half + 3 * v_end)


def march(model, bathe, start_acceleration, reduce):
    """Displacement at every instant, one column each, and forces over the coordinates from `reduce`."""
    loads = reduce(model.loads)
    force = lambda t: loads @ model.factors(t)
    a = start_acceleration(force(0.0))
    state = (np.zeros_like(a), np.zeros_like(a), a)
    out = np.zeros((len(a), model.steps + 1))
    for n in range(model.steps):
        state = bathe.step(state, force((n + 0.5) * model.dt), force((n + 1) * model.dt))
        out[:, n + 1] = state[0]
    return out, state


class FullOrder:
    """SciPy: sparse LU (SuperLU) of both stage matrices, one solve per stage."""

    def __init__(self, model):
        factorize = lambda a: scipy.sparse.linalg.splu(a.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve
        start = time.perf_counter()
        self.bathe = Bathe(model.mass, model.stiffness, model, factorize)
        self.offline = time.perf_counter() - start
        mass = scipy.sparse.linalg.splu(model.mass)
        self.trajectory, self.state = march(model, self.bathe, mass.solve, lambda f: f)
        self.force = model.loads.sum(axis=1)

    def step(self):
        self.state = self.bathe.step(self.state, self.force, self.force)


class Reduced:
    """POD-Galerkin in NumPy: `factorize` says how a stage is solved."""

    def __init__(self, model, factorize):
        b = model.basis
        mass, stiffness = (b.T @ (a @ b) for a in (model.mass, model.stiffness))
        self.bathe = Bathe(mass, stiffness, model, factorize)
        reduce = lambda f: b.T @ f
        self.trajectory, self.state = march(model, self.bathe, lambda f: np.linalg.solve(mass, f), reduce)
        self.force = reduce(model.loads).sum(axis=1)

    def step(self):
        self.state = self.bathe.step(self.state, self.force, self.force)


def by_cholesky(a):
    factor = scipy.linalg.cho_factor(a)
    return lambda x: scipy.linalg.cho_solve(factor, x, check_finite=False)


def by_inverse(a):
    inverse = np.linalg.inv(a)
    return lambda x: inverse @ x


class Fused:
    """The best NumPy can do with our idea: one product with the fused map (Galerkin), found by stepping unit states."""

    def __init__(self, model):
        plain = Reduced(model, by_inverse)
        r = model.basis.shape[1]
        zero = np.zeros(r)
        columns = [plain.bathe.step(tuple(unit.reshape(3, r)), zero, zero) for unit in np.eye(3 * r)]
        self.map = np.array([np.concatenate(column) for column in columns]).T
        self.load = np.concatenate(plain.bathe.step((zero, zero, zero), plain.force, plain.force))
        self.trajectory, self.state = plain.trajectory, np.concatenate(plain.state)

    def step(self):
        self.state = self.map @ self.state + self.load


class PyMor:
    """pyMOR: projected operators, stages solved with `apply_inverse` on vector arrays."""

    def __init__(self, model):
        from pymor.algorithms.projection import project
        from pymor.core.logger import set_log_levels
        from pymor.operators.constructions import LincombOperator
        from pymor.operators.numpy import NumpyMatrixOperator

        set_log_levels({"pymor": "ERROR"})
        mass, stiffness = NumpyMatrixOperator(model.mass), NumpyMatrixOperator(model.stiffness)
        basis = mass.source.from_numpy(model.basis)
        assert len(basis) == model.basis.shape[1], "vectors are columns"
        mass, stiffness = project(mass, basis, basis), project(stiffness, basis, basis)
        self.space = mass.source

        class Applied:
            """An operator with the products `Bathe` writes down."""

            def __init__(self, operator):
                self.operator = operator

            def __rmul__(self, factor):
                return Applied(factor * self.operator)

            def __add__(self, other):
                return Applied(self.operator + other.operator)

            def __matmul__(self, x):
                return self.operator.apply(x)

        def factorize(applied):
            operator = applied.operator
            operator = operator.assemble() if isinstance(operator, LincombOperator) else operator
            return operator.apply_inverse

        self.bathe = Bathe(Applied(mass), Applied(stiffness), model, factorize)
        reduced = basis.inner(self.space_of(model.mass.shape[0]).from_numpy(model.loads))
        forces = self.space.from_numpy(reduced)
        combine = lambda t: forces.lincomb(model.factors(t)[:, None])
        a = mass.apply_inverse(combine(0.0))
        state = (self.space.zeros(1), self.space.zeros(1), a)
        self.trajectory = np.zeros((model.basis.shape[1], model.steps + 1))
        for n in range(model.steps):
            state = self.bathe.step(state, combine((n + 0.5) * model.dt), combine((n + 1) * model.dt))
            self.trajectory[:, n + 1] = state[0].to_numpy().ravel()
        self.state, self.force = state, forces.lincomb(np.ones((len(forces), 1)))

    @staticmethod
    def space_of(n):
        from pymor.vectorarrays.numpy import NumpyVectorSpace

        return NumpyVectorSpace(n)

    def step(self):
        self.state = self.bathe.step(self.state, self.force, self.force)


def errors(model, full, coordinates):
    """(‖u − Bζ‖, ‖u − BBᵀMu‖) ÷ ‖u‖ over all dofs and steps in the mass norm."""
    weighted = model.mass @ full
    norm = np.sqrt(np.vdot(full, weighted))
    projected = model.basis.T @ weighted
    rest = full - model.basis @ projected
    floor = np.sqrt(np.vdot(rest, model.mass @ rest))
    return np.hypot(floor, np.linalg.norm(projected - coordinates)) / norm, floor / norm


def bursts(step, size, count):
    """Nanoseconds per step of each burst, at least five and then for half a second at most; the first one warms up."""
    times, begin = [], time.perf_counter()
    while len(times) <= count and (len(times) < 6 or time.perf_counter() - begin < 0.5):
        start = time.perf_counter()
        for _ in range(size):
            step()
        times.append(1e9 * (time.perf_counter() - start) / size)
    return times[1:]


def timed(candidates):
    """Median step of each candidate and how far the medians of its rounds lie apart."""
    rounds = {name: [] for name in candidates}
    for _ in range(ROUNDS):
        for name, (step, full) in candidates.items():
            times = bursts(step, 1, FULL_STEPS) if full else bursts(step, BURST, BURSTS)
            rounds[name].append(statistics.median(times))
    return {name: (statistics.median(m), max(m) / min(m) - 1) for name, m in rounds.items()}


def row(name, modes, offline, time_and_spread, error, floor):
    ns, spread = time_and_spread
    return dict(
        name=name, modes=modes, offline_seconds=offline, step_ns_p50=ns, step_spread=spread,
        trajectory_error=error, projection_floor=floor,
    )


def peers(output, modes):
    rows, full = [], None
    for r in modes:
        model = Model(output / f"matrices-{r}")
        full = full or FullOrder(model)
        methods = {
            "NumPy POD-Galerkin, Cholesky solves": Reduced(model, by_cholesky),
            "NumPy POD-Galerkin, inverses made once": Reduced(model, by_inverse),
            "NumPy POD-Galerkin, fused map": Fused(model),
            "pyMOR POD-Galerkin, apply_inverse": PyMor(model),
        }
        candidates = {name: (method.step, False) for name, method in methods.items()}
        candidates["SciPy full order, splu"] = (full.step, True)
        times = timed(candidates)
        if not rows:
            rows.append(row("SciPy full order, splu", None, full.offline, times["SciPy full order, splu"], 0.0, 0.0))
        for name, method in methods.items():
            found = errors(model, full.trajectory, method.trajectory)
            rows.append(row(name, r, None, times[name], *found))
    return rows


def table(rows, ours, dt):
    """One Markdown table of peers and our comparable rows; ratios to our step with the default basis in f32."""
    wanted = ("full order", "pod-galerkin", "pod block", "ritz diagonal", "ritz block")
    at = [r for r in ours["methods"] if r["time_step"] == dt and r["name"].startswith(wanted)]
    fastest = {r["modes"]: r["step_ns_p50"] for r in at if r["name"] == "ritz diagonal f32"}
    some = next(iter(fastest.values()))
    lines = [
        "| by | name | modes | step ns p50 | spread | trajectory error | projection floor | times ritz diagonal f32 |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    both = [("vademecum", r) for r in at] + [("peer", r) for r in rows]
    for by, r in sorted(both, key=lambda pair: (pair[1]["modes"] or 0, pair[0], pair[1]["step_ns_p50"])):
        ns = r["step_ns_p50"]
        ratio = ns / fastest.get(r["modes"], some)
        cells = [by, r["name"], r["modes"] or "", f"{ns:.4g}", f"{r['step_spread']:.3f}",
                 f"{r['trajectory_error']:.3e}", f"{r['projection_floor']:.3e}", f"{ratio:.3g}"]
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join(lines) + "\n"


def goals(rows, ours):
    """What was asked for, with the numbers found."""
    fused = {r["modes"]: r for r in ours["methods"] if r["name"] == "ritz diagonal f32" and r["time_step"] == ours["time_step"]}
    lines = []
    for r, row in sorted(fused.items()):
        numpy = min(p["step_ns_p50"] for p in rows if p["modes"] == r and "fused" not in p["name"])
        ratio, floor = row["times_full_order"], row["trajectory_error"] / row["projection_floor"]
        lines.append(
            f"- {r} modes: the fused step (ritz diagonal f32) is {numpy / row['step_ns_p50']:.0f} times faster than the fastest "
            f"NumPy reduced step (goal 20), {ratio:.3g} times faster than our full-order step at {ours['dofs']} dofs (goal 1e4 at "
            f"30 000), at {floor:.3f} times the projection floor (goal 1.1)."
        )
    return "\n".join(lines) + "\n"


def main():
    output = Path(sys.argv[1])
    modes = sorted(int(p.name.rsplit("-", 1)[1]) for p in output.glob("matrices-*"))
    rows = peers(output, modes)
    ours = json.loads((output / "bench/bench.json").read_text())
    text = goals(rows, ours) + "\n" + table(rows, ours, ours["time_step"])
    (output / "peers.json").write_text(json.dumps(rows, indent=2))
    (output / "peers.md").write_text(text)
    print(text)


main()
