"""Plays a scenario file, from `formats/scenario-1.md`: `scenario.py FILE SCENARIO PROBES_CSV STRUCTURE`.

Compares the rows with those that `vademecum run` wrote, which have ten digits. A number that lies on the edge
between two last digits may be printed as either; a difference of 1 is what such a number may have.
"""

import csv
import math
import sys
import tomllib

import numpy as np

import agree
import step
import vademecum

LATE = 1 + 1e-9  # instants are compared after this factor


def closest_share(a, b, p):
    """Place along the segment from `a` to `b` that is nearest to `p`."""
    along = b - a
    length = along @ along
    return min(max((p - a) @ along / length, 0.0), 1.0) if length > 0 else 0.0


def nearest_in_triangle(corners, p):
    """Barycentric weights of the point of a triangle nearest to `p`, and its distance."""
    a, b, c = corners
    gram = np.array([[(b - a) @ (b - a), (b - a) @ (c - a)], [(b - a) @ (c - a), (c - a) @ (c - a)]])
    right = np.array([(b - a) @ (p - a), (c - a) @ (p - a)])
    candidates = []
    if np.linalg.det(gram) > 0:
        s, t = np.linalg.solve(gram, right)
        if s >= 0 and t >= 0 and s + t <= 1:
            candidates.append((1 - s - t, s, t))
    for i, j in ((0, 1), (1, 2), (2, 0)):
        share = closest_share(corners[i], corners[j], p)
        weights = [0.0, 0.0, 0.0]
        weights[i], weights[j] = 1 - share, share
        candidates.append(tuple(weights))
    distances = [np.linalg.norm(np.array(w) @ corners - p) for w in candidates]
    best = int(np.argmin(distances))
    return candidates[best], distances[best]


def locate(file, point):
    """Nodes and weights of the nearest point of the loadable surface; the first triangle of several."""
    coordinates = file.section("NodeCoordinates")[:, :, 0]
    triangles = file.section("Triangles")[: file.meta["n_load_triangles"], :, 0].astype(int)
    best = (math.inf, None, None)
    for nodes in triangles:
        weights, distance = nearest_in_triangle(coordinates[nodes], np.array(point))
        if distance < best[0]:
            best = (distance, nodes, weights)
    return list(best[1]), list(best[2])


def place(scene, point):
    """Nodes and weights of a contact; the canonical structure takes the nearest load position."""
    if not isinstance(scene, step.Canonical):
        return locate(scene.file, point)
    coordinates = scene.file.section("NodeCoordinates")[:, :, 0]
    distances = [np.linalg.norm(coordinates[node] - point) for node in scene.positions]
    return [scene.positions[int(np.argmin(distances))]], [1.0]


def factor(entry, t):
    """The factor of a load at an instant."""
    start, end, ramp = entry.get("start", 0.0), entry.get("end", math.inf), entry.get("ramp", 0.0)
    t = t * LATE
    if t < start or t >= end:
        return 0.0
    return 1.0 if ramp == 0.0 else min(1.0, (t - start) / ramp)


def factor_beside(entry, t, side):
    """The factor right after an instant (side 1) or right before it (side -1)."""
    start, end, ramp = entry.get("start", 0.0), entry.get("end", math.inf), entry.get("ramp", 0.0)
    meant = t * (1 + side * 1e-9)
    if meant < start or meant >= end:
        return 0.0
    return 1.0 if meant >= start + ramp else min(max((t - start) / ramp, 0.0), 1.0)


def is_inside(t, start, end):
    return start * (1 + 1e-9) < t < end * (1 - 1e-9)


def parts_of(loads, start, end):
    """Ends of the parts of a step, split where a load begins, is at full height or ends."""
    breaks = set()
    for _, when in loads:
        begin = when.get("start", 0.0)
        breaks |= {begin, begin + when.get("ramp", 0.0), when.get("end", math.inf)}
    ends = []
    for t in sorted(t for t in breaks if is_inside(t, start, end)):
        if is_inside(t, ends[-1] if ends else start, end):
            ends.append(t)
    return [start, *ends, end]


def exact_step(scene, y, loads, start, end):
    """A step of `loads`, pairs of a reduced load with its factor and when it acts, in its parts."""
    ends = parts_of(loads, start, end)
    whole = len(ends) == 2
    for a, b in zip(ends, ends[1:]):
        part = scene if whole else scene.part(b - a)
        factors = [[factor_beside(when, a, 1), factor_beside(when, b, -1)] for _, when in loads]
        acting = [(load, at) for (load, _), at in zip(loads, factors) if any(at)]
        y = scene.carry(part, part.step(part.carry(scene, y), acting))
    return y


def factor_shown(scene, when, n):
    """The factor at the end of the step that leads to instant `n`, or at the start of the march."""
    if n == 0:
        return factor(when, 0.0)
    if isinstance(scene, step.Exact):
        return factor_beside(when, n * scene.v.dt, -1)
    return factor(when, (n - 1 + scene.instants[-1]) * scene.v.dt)


def loads_of(scene, scenario):
    """Reduced load, `BᵀF`, the load itself, and the entry that says when."""
    loads = []
    for contact in scenario.get("contact", []):
        push = *place(scene, contact["point"]), contact["force"]
        named = dict(zip(("nodes", "weights", "force"), push))
        loads.append((scene.load_of_contact(*push), scene.contact(*push), named, 1.0, contact))
    names = scene.file.lines("PatternNames")
    for pattern in scenario.get("pattern", []):
        index = names.index(pattern["name"])
        amplitude = pattern.get("amplitude", 1.0)
        reduced = scene.load_of_pattern(index), scene.pattern(index)
        loads.append((*reduced, {"pattern": index}, amplitude, pattern))
    return loads


def play(scene, scenario):
    """Rows of time, energy and probes."""
    dt = scene.v.dt
    every = scenario.get("output", {}).get("probes_every", 1)
    loads = loads_of(scene, scenario)
    exact = isinstance(scene, step.Exact)
    force = sum((p * factor(when, 0.0) * plain for _, plain, _, p, when in loads), np.zeros(scene.r))
    y = scene.start(np.zeros(scene.r), np.zeros(scene.r), force)
    steps = max(1, math.floor(scenario["duration"] / dt + 0.5))
    scene.farthest = 0.0
    for n in range(steps + 1):
        scene.farthest = max(scene.farthest, np.abs(y[0]).max())
        if n % every == 0:
            seen = [(push, p * factor_shown(scene, when, n)) for _, _, push, p, when in loads]
            yield [n * dt, scene.energy(y, seen), *scene.probes(y[0], seen)]
        if exact:
            scaled = [(p * load, when) for load, _, _, p, when in loads]
            y = exact_step(scene, y, scaled, n * dt, (n + 1) * dt)
            continue
        amplitudes = [[p * factor(when, (n + c) * dt) for c in scene.instants] for _, _, _, p, when in loads]
        y = scene.step(y, [(load[0], at) for load, at in zip(loads, amplitudes) if any(at)])


def printed(value):
    """As the program prints it: ten digits, and the exponent without zeros or plus."""
    digits, exponent = f"{value:.9e}".split("e")
    return f"{digits}e{int(exponent)}"


def main(file, scenario, table, structure):
    file = vademecum.read(file)
    with open(scenario, "rb") as text:
        scenario = tomllib.load(text)
    with open(table, encoding="utf-8", newline="") as rows:
        given = list(csv.reader(rows))
    names, given = given[0], given[1:]
    scene = step.STRUCTURES[structure](file)
    ours = list(play(scene, scenario))
    if names != ["time_s", "energy_J", *file.lines("ProbeNames")] or len(ours) != len(given):
        print(f"{table}: {len(given)} rows of {names}, and the reader has {len(ours)}")
        return False
    slack = agree.bound_of(structure, len(ours))
    if structure == "canonical":
        # There the bound is relative to the reach of the axes, which the motion does not fill.
        slack *= scene.reach(0) / scene.farthest
    same, largest = 0, 0.0
    scale = np.abs(ours).max(axis=0)
    for mine, theirs in zip(ours, given):
        for column, (a, b) in enumerate(zip(mine, theirs)):
            # The last number of a row may have zeros behind its digits.
            same += printed(a) == printed(float(b))
            # In units of what rounding to ten digits may change, and of what the marches may differ by.
            largest = max(largest, abs(a - float(b)) / (5e-10 * abs(a) + slack * scale[column] + 1e-300))
    total = sum(len(row) for row in given)
    print(f"{table}: {same} of {total} numbers the same to the digit; largest difference {largest:.2f}")
    return largest <= 1.001 and total > 0


if __name__ == "__main__":
    sys.exit(0 if main(*sys.argv[1:]) else 1)
