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


def loads_of(scene, scenario):
    """Reduced load, `BᵀF`, amplitude, and the entry that says when."""
    loads = []
    for contact in scenario.get("contact", []):
        push = *place(scene, contact["point"]), contact["force"]
        loads.append((scene.load_of_contact(*push), scene.contact(*push), 1.0, contact))
    names = scene.file.lines("PatternNames")
    for pattern in scenario.get("pattern", []):
        index = names.index(pattern["name"])
        amplitude = pattern.get("amplitude", 1.0)
        loads.append((scene.load_of_pattern(index), scene.pattern(index), amplitude, pattern))
    return loads


def play(scene, scenario):
    """Rows of time, energy and probes."""
    dt = scene.v.dt
    every = scenario.get("output", {}).get("probes_every", 1)
    loads = loads_of(scene, scenario)
    force = sum((p * factor(when, 0.0) * plain for _, plain, p, when in loads), np.zeros(scene.r))
    y = scene.start(np.zeros(scene.r), np.zeros(scene.r), force)
    steps = max(1, math.floor(scenario["duration"] / dt + 0.5))
    scene.farthest = 0.0
    for n in range(steps + 1):
        scene.farthest = max(scene.farthest, np.abs(y[0]).max())
        if n % every == 0:
            yield [n * dt, scene.energy(y), *scene.probes(y[0])]
        amplitudes = [[p * factor(when, (n + c) * dt) for c in scene.instants] for _, _, p, when in loads]
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
