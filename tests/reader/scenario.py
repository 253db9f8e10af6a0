"""Plays a scenario file, from `formats/scenario-1.md`: `scenario.py FILE SCENARIO PROBES_CSV STRUCTURE
[NAME=VALUE ...]`, with values of live regions at the end.

Compares the rows with those that `vademecum run` wrote, which have ten digits. A number that lies on the edge
between two last digits may be printed as either; a difference of 1 is what such a number may have.
"""

import csv
import math
import pathlib
import re
import sys
import tomllib

import numpy as np

import agree
import live
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


# Coordinates of the nodes of a quadrangle.
QUADRANGLE = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (0, -1), (1, 0), (0, 1), (-1, 0), (0, 0)], float)


def shape_functions(count, x, y):
    """Those of a quadrangle of so many nodes."""
    def line(a, x):
        return 1 - x * x if a == 0 else x * (x + a) / 2

    def share(a, b):
        if count == 9:
            return line(a, x) * line(b, y)
        if count == 4:
            return (1 + a * x) * (1 + b * y) / 4
        if a == 0:
            return (1 - x * x) * (1 + b * y) / 2
        if b == 0:
            return (1 + a * x) * (1 - y * y) / 2
        return (1 + a * x) * (1 + b * y) * (a * x + b * y - 1) / 4

    return [share(a, b) for a, b in QUADRANGLE[:count]]


def shared(file, triangle, nodes, weights):
    """Nodes and weights of a point of a loadable triangle: those of the facet that it is part of."""
    rows = file.section("Quadrangles")[:, :, 0].astype(np.int64) if "Quadrangles" in file else []
    for first, count, *own in rows:
        if first <= triangle < first + count:
            own = [int(node) for node in own if node != 0xFFFFFFFF]
            x, y = sum(w * QUADRANGLE[own.index(node)] for node, w in zip(nodes, weights))
            return own, shape_functions(len(own), x, y)
    return list(nodes), list(weights)


def locate(file, point):
    """Nodes and weights of the nearest point of the loadable surface; the first triangle of several."""
    coordinates = file.section("NodeCoordinates")[:, :, 0]
    triangles = file.section("Triangles")[: file.meta["n_load_triangles"], :, 0].astype(int)
    best = (math.inf, None, None, None)
    for triangle, nodes in enumerate(triangles):
        weights, distance = nearest_in_triangle(coordinates[nodes], np.array(point))
        if distance < best[0]:
            best = (distance, triangle, nodes, weights)
    return shared(file, *best[1:])


def place(scene, point):
    """Nodes and weights of a contact; the canonical structure takes the nearest load position."""
    if not isinstance(scene, step.Canonical):
        return locate(scene.file, point)
    coordinates = scene.file.section("NodeCoordinates")[:, :, 0]
    distances = [np.linalg.norm(coordinates[node] - point) for node in scene.positions]
    return [scene.positions[int(np.argmin(distances))]], [1.0]


def table_rows(table, folder):
    """Rows of a table, in the scenario or in a file beside it."""
    if not isinstance(table, str):
        return np.array(table, dtype=float)
    with open(folder / table, encoding="utf-8") as text:
        lines = [line.strip() for line in text]
    cells = [re.split(r"[,;\s]+", line) for line in lines if line and line[0] not in "#%"]
    header = not re.match(r"[-+.0-9]", cells[0][0])
    return np.array(cells[1:] if header else cells, dtype=float)


def history(entry, duration, column=None, share=None):
    """How a load follows time: `column` is the time and the values of a table, `share` its place on a path."""
    when = {name: entry.get(name, other) for name, other in (("start", 0.0), ("end", math.inf), ("ramp", 0.0))}
    when |= {"column": column, "share": share, "wave": None}
    if "sinusoid" in entry:
        wave = entry["sinusoid"]
        frequency = wave["frequency"]
        when["wave"] = (frequency, frequency, 1.0, wave.get("phase", 0.0), wave.get("mean", 0.0))
    if "chirp" in entry:
        wave, end = entry["chirp"], min(when["end"], math.inf if "end" in entry else duration)
        when["wave"] = (wave["from"], wave["to"], end - when["start"], wave.get("phase", 0.0), 0.0)
    return when


def around(column, tau):
    """The rows around a time; none outside of the table."""
    after = int(np.searchsorted(column[:, 0], tau, side="right"))
    return (column[after - 1], column[after]) if 0 < after < len(column) else None


def rest(when, t, meant):
    """Table, sinusoid or chirp, and the share of a path, on the side of `t` where `meant` lies."""
    value, tau = 1.0, t - when["start"]
    if when["column"] is not None:
        rows = around(when["column"], meant - when["start"])
        if rows is None:
            return 0.0
        (a, u), (b, v) = rows
        value = u + min(max((tau - a) / (b - a), 0.0), 1.0) * (v - u)
    if when["wave"]:
        first, last, length, phase, mean = when["wave"]
        value = mean + math.sin(2 * math.pi * (first * tau + 0.5 * (last - first) * tau * tau / length) + phase)
    if when["share"]:
        before, top, after = when["share"]
        if meant < top:
            value *= min(max((t - before) / (top - before), 0.0), 1.0) if before < top else 1.0
        elif top < after:
            value *= min(max((after - t) / (after - top), 0.0), 1.0)
    return value


def factor(when, t):
    """The factor of a load at an instant."""
    start, end, ramp = when["start"], when["end"], when["ramp"]
    late = t * LATE
    if late < start or late >= end:
        return 0.0
    return (1.0 if ramp == 0.0 else min(1.0, (late - start) / ramp)) * rest(when, t, late)


def factor_beside(when, t, side):
    """The factor right after an instant (side 1) or right before it (side -1)."""
    start, end, ramp = when["start"], when["end"], when["ramp"]
    meant = t * (1 + side * 1e-9)
    if meant < start or meant >= end:
        return 0.0
    gate = 1.0 if meant >= start + ramp else min(max((t - start) / ramp, 0.0), 1.0)
    return gate * rest(when, t, meant)


def is_inside(t, start, end):
    return start * (1 + 1e-9) < t < end * (1 - 1e-9)


def pieces_of(when, a, b):
    """Number of equal pieces in which a load is linear to a millionth, where it has no break."""
    middle, start = 0.5 * (a + b), when["start"]
    if not start <= middle < when["end"]:
        return 1
    p = 1 / when["ramp"] if middle < start + when["ramp"] else 0.0
    s = 0.0
    if when["share"]:
        before, top, after = when["share"]
        s = 1 / (top - before) if before < middle < top else 1 / (after - top) if top < middle < after else 0.0
    size, slope, bend, height = 1.0, 0.0, 0.0, 1.0
    if when["column"] is not None:
        height, rows = np.abs(when["column"][:, 1]).max(), around(when["column"], middle - start)
        size, slope = 0.0, 0.0
        if rows is not None:
            (t, u), (later, v) = rows
            size, slope = max(abs(u), abs(v)), abs(v - u) / (later - t)
    if when["wave"]:
        first, last, length, _, mean = when["wave"]
        fastest = max(abs(first + (last - first) * (t - start) / length) for t in (a, b))
        size, slope = 1 + abs(mean), 2 * math.pi * fastest
        bend = slope**2 + 2 * math.pi * abs(last - first) / length
    c = bend + 2 * (p * s * size + (p + s) * slope)
    if c <= 0 or height <= 0:
        return 1
    return min(max(math.ceil((b - a) * math.sqrt(c / (8e-6 * height))), 1), 65536)


def parts_of(loads, start, end):
    """Ends of the parts of a step, split where a load jumps or bends."""
    breaks = set()
    for _, when in loads:
        begin = when["start"]
        breaks |= {begin, begin + when["ramp"], when["end"], *(when["share"] or ())}
        if when["column"] is not None:
            breaks |= set(begin + when["column"][:, 0])
    ends = []
    for t in sorted(t for t in breaks if is_inside(t, start, end)):
        if is_inside(t, ends[-1] if ends else start, end):
            ends.append(t)
    return [start, *ends, end]


def mean_over(loads, when, start, end):
    """The mean of a load's factor over a step that all loads cut."""
    ends, total = parts_of(loads, start, end), 0.0
    for a, b in zip(ends, ends[1:]):
        pieces = max((pieces_of(other, a, b) for _, other in loads), default=1)
        for i in range(pieces):
            c, d = a + (b - a) * (i / pieces), b if i + 1 == pieces else a + (b - a) * ((i + 1) / pieces)
            both = factor_beside(when, c, 1) + factor_beside(when, d, -1)
            total += 0.5 * both * (b - a) / pieces / (end - start)
    return total


def exact_step(scene, y, loads, pushes, start, end):
    """A step of `loads`, pairs of a reduced load with its factor and how it follows time, in its parts.
    `pushes` are the loads themselves and their factors."""
    ends = parts_of(loads, start, end)
    for a, b in zip(ends, ends[1:]):
        pieces = max((pieces_of(when, a, b) for _, when in loads), default=1)
        whole = len(ends) == 2 and pieces == 1
        part = scene if whole else scene.part((b - a) / pieces)
        y = part.carry(scene, y)
        for i in range(pieces):
            c, d = a + (b - a) * (i / pieces), b if i + 1 == pieces else a + (b - a) * ((i + 1) / pieces)
            factors = [[factor_beside(when, c, 1), factor_beside(when, d, -1)] for _, when in loads]
            y = part.step(y, [(load, at) for (load, _), at in zip(loads, factors) if any(at)])
            ends_of = [[(push, p * at[k]) for (push, p), at in zip(pushes, factors)] for k in (0, 1)]
            part.follow(*ends_of)
        y = scene.carry(part, y)
    return y


def factor_shown(scene, when, n):
    """The factor at the end of the step that leads to instant `n`; at the start of the march that of then."""
    if n == 0:
        return 0.0 if isinstance(scene, step.Exact) else factor(when, 0.0)
    if isinstance(scene, step.Exact):
        return factor_beside(when, n * scene.v.dt, -1)
    return factor(when, (n - 1 + scene.instants[-1]) * scene.v.dt)


def places_of(file, entry, folder):
    """Points of a contact with the instants of their shares of the force."""
    if "path" not in entry:
        return [(entry["point"], None)]
    rows = table_rows(entry["path"], folder)
    corners = file.section("NodeCoordinates")[:, :, 0][
        file.section("Triangles")[: file.meta["n_load_triangles"], :, 0].astype(int)
    ]
    edge = np.mean(np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2))
    stops = [rows[0]]
    for a, b in zip(rows, rows[1:]):
        n = max(math.ceil(4 * np.linalg.norm(b[1:] - a[1:]) / edge), 1)
        stops += [a + i / n * (b - a) for i in range(1, n)] + [b]
    times = [entry.get("start", 0.0) + stop[0] for stop in stops]
    last = len(stops) - 1
    shares = [(times[max(j - 1, 0)], times[j], times[min(j + 1, last)]) for j in range(last + 1)]
    return [(stop[1:], share) for stop, share in zip(stops, shares)]


def forces_of(entry, folder):
    """Forces of fixed direction with the column of the table that each follows, if there is one."""
    if "table" not in entry:
        return [(entry["force"], None)]
    rows = table_rows(entry["table"], folder)
    if rows.shape[1] == 2:
        return [(entry["force"], rows)]
    return [(np.eye(3)[c], rows[:, [0, 1 + c]]) for c in range(3)]


def loads_of(scene, scenario, folder):
    """Reduced load, `BᵀF`, the load itself, and how it follows time."""
    loads, duration = [], scenario["duration"]
    for contact in scenario.get("contact", []):
        for point, share in places_of(scene.file, contact, folder):
            where = place(scene, point)
            for force, column in forces_of(contact, folder):
                push = *where, force
                named = dict(zip(("nodes", "weights", "force"), push))
                when = history(contact, duration, column, share)
                loads.append((scene.load_of_contact(*push), scene.contact(*push), named, 1.0, when))
    names = scene.file.lines("PatternNames")
    for pattern in scenario.get("pattern", []):
        index = names.index(pattern["name"])
        amplitude = pattern.get("amplitude", 1.0)
        reduced = scene.load_of_pattern(index), scene.pattern(index)
        column = table_rows(pattern["table"], folder) if "table" in pattern else None
        loads.append((*reduced, {"pattern": index}, amplitude, history(pattern, duration, column)))
    return loads


def play(scene, scenario, folder):
    """Rows of time, energy and probes."""
    dt = scene.v.dt
    every = scenario.get("output", {}).get("probes_every", 1)
    loads = loads_of(scene, scenario, folder)
    exact = isinstance(scene, step.Exact)
    force = sum((p * factor(when, 0.0) * plain for _, plain, _, p, when in loads), np.zeros(scene.r))
    y = scene.start(np.zeros(scene.r), np.zeros(scene.r), force)
    steps = max(1, math.floor(scenario["duration"] / dt + 0.5))
    scene.farthest = 0.0
    for n in range(steps + 1):
        scene.farthest = max(scene.farthest, np.abs(y[0]).max())
        if n % every == 0:
            seen = [(push, p * factor_shown(scene, when, n)) for _, _, push, p, when in loads]
            reactions = scene.reactions(y, seen).ravel()
            yield [n * dt, scene.energy(y, seen), *scene.probes(y[0], seen), *reactions]
        if exact:
            scaled = [(p * load, when) for load, _, _, p, when in loads]
            pushes = [(push, p) for _, _, push, p, _ in loads]
            y = exact_step(scene, y, scaled, pushes, n * dt, (n + 1) * dt)
            continue
        amplitudes = [[p * factor(when, (n + c) * dt) for c in scene.instants] for _, _, _, p, when in loads]
        y = scene.step(y, [(load[0], at) for load, at in zip(loads, amplitudes) if any(at)])
        scene.follow(*([(load[2], at[k]) for load, at in zip(loads, amplitudes)] for k in (0, -1)))


def printed(value):
    """As the program prints it: ten digits, and the exponent without zeros or plus."""
    digits, exponent = f"{value:.9e}".split("e")
    return f"{digits}e{int(exponent)}"


def main(file, scenario, table, structure, *values):
    file, folder = vademecum.read(file), pathlib.Path(scenario).parent
    if values:
        named = (value.rsplit("=", 1) for value in values)
        live.set_to(file, {name: float(number) for name, number in named})
    with open(scenario, "rb") as text:
        scenario = tomllib.load(text)
    with open(table, encoding="utf-8", newline="") as rows:
        given = list(csv.reader(rows))
    names, given = [name.split(" [")[0] for name in given[0]], given[1:]
    scene = step.STRUCTURES[structure](file)
    ours = list(play(scene, scenario, folder))
    supports = file.lines("SupportNames") if "SupportNames" in file else []
    parts = [f"reaction.{name}.{part}" for name in supports for part in ("fx", "fy", "fz", "mx", "my", "mz")]
    if names != ["time_s", "energy_J", *file.lines("ProbeNames"), *parts] or len(ours) != len(given):
        print(f"{table}: {len(given)} rows of {names}, and the reader has {len(ours)}")
        return False
    slack = agree.bound_of(structure, len(ours))
    if values:
        # The eigenproblem is solved in two ways, each to rounding in its largest eigenvalue.
        slack *= 10
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
