"""Plays a scenario with a free body, from "A free body" of `formats/vademecum-1.md` and of `formats/scenario-1.md`:
`free.py FILE SCENARIO PROBES_CSV`. Compares the rows with those that `vademecum run` wrote, which have ten digits."""

import csv
import pathlib
import sys
import tomllib

import numpy as np

import agree
import scenario as plays
import step
import vademecum

PRODUCTS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
SHARES = ((0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5))


def times(a, b):
    """The product of two quaternions."""
    v, w = a[1:], b[1:]
    return np.array([a[0] * b[0] - v @ w, *(a[0] * w + b[0] * v + np.cross(v, w))])


def turned(q, d):
    return times(times(q, np.array([0.0, *d])), q * [1, -1, -1, -1])[1:]


class Rigid:
    """Section 59, and the rigid motion."""

    def __init__(self, scene, start):
        numbers = scene.file.section("RigidBody").ravel()
        rho = scene.v.density
        self.mass, self.centre, self.first = rho * numbers[0], numbers[1:4], int(numbers[10])
        xx, xy, xz, yy, yz, zz = rho * numbers[4:10]
        self.inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        self.moments, self.axes = np.linalg.eigh(self.inertia)
        self.wrenches = numbers[11:].reshape(-1, 6)
        self.x, self.q = self.centre.copy(), np.array([1.0, 0, 0, 0])
        self.p = self.mass * np.array(start.get("velocity", [0, 0, 0]), dtype=float)
        self.l = self.inertia @ np.array(start.get("spin", [0, 0, 0]), dtype=float)

    def back(self, d):
        return turned(self.q * [1, -1, -1, -1], d)

    def spin(self):
        return np.linalg.solve(self.inertia, self.back(self.l))

    def energy(self):
        return 0.5 * (self.p @ self.p / self.mass + self.spin() @ self.back(self.l))

    def drift(self, h):
        self.x = self.x + h / self.mass * self.p
        for k, share in SHARES:
            axis = self.axes[:, k]
            half = 0.5 * share * h * (turned(self.q, axis) @ self.l) / self.moments[k]
            self.q = times(self.q, np.array([np.cos(half), *(np.sin(half) * axis)]))
        self.q = self.q / np.linalg.norm(self.q)

    def place(self, point, moved):
        return self.x + turned(self.q, point - self.centre + moved)


def loads_of(scene, scenario, folder):
    """What acts, and how it follows time: contacts by point and force, patterns by number."""
    coordinates = scene.file.section("NodeCoordinates")[:, :, 0]
    duration = scenario["duration"]
    for contact in scenario.get("contact", []):
        nodes, weights = plays.locate(scene.file, contact["point"])
        point = np.array(weights) @ coordinates[nodes]
        for force, column in plays.forces_of(contact, folder):
            yield ("contact", nodes, weights, point, np.array(force)), plays.history(contact, duration, column)
    names = scene.file.lines("PatternNames")
    for pattern in scenario.get("pattern", []):
        index, amplitude = names.index(pattern["name"]), pattern.get("amplitude", 1.0)
        yield ("pattern", index, amplitude), plays.history(pattern, duration)


def advance(scene, rigid, y, loads, n, gravity):
    """A step of both motions; the state, and what it shows the residual flexibility of."""
    dt, before = scene.v.dt, rigid.spin()
    rigid.drift(0.5 * dt)
    force, moment = rigid.mass * gravity, np.zeros(3)
    acting, starts, shown = [], [], []
    all_histories = [(None, when) for _, when in loads]
    for load, when in loads:
        mean = plays.mean_over(all_histories, when, n * dt, (n + 1) * dt)
        if mean == 0.0:
            continue
        if load[0] == "contact":
            _, nodes, weights, point, push = load
            push = mean * push
            own = rigid.back(push)
            acting.append((scene.load_of_contact(nodes, weights, own), [1.0, 1.0]))
            shown.append(({"nodes": nodes, "weights": weights, "force": own}, 1.0))
            starts.append(shown[-1])
            force = force + push
            moment = moment + np.cross(turned(rigid.q, point - rigid.centre), push)
        else:
            _, index, amplitude = load
            acting.append((scene.load_of_pattern(index), [mean * amplitude] * 2))
            shown.append(({"pattern": index}, mean * amplitude))
            starts.append(shown[-1])
            wrench = mean * amplitude * rigid.wrenches[index]
            force, moment = force + turned(rigid.q, wrench[:3]), moment + turned(rigid.q, wrench[3:])
    rigid.p, rigid.l = rigid.p + dt * force, rigid.l + dt * moment
    rigid.drift(0.5 * dt)
    after = rigid.spin()
    for k, (i, j) in enumerate(PRODUCTS):
        at = [scene.v.density * w[i] * w[j] for w in (before, after)]
        acting.append((scene.load_of_pattern(rigid.first + k), at))
        shown.append(({"pattern": rigid.first + k}, at[1]))
        starts.append(({"pattern": rigid.first + k}, at[0]))
    scene.follow(starts, shown)
    return scene.step(y, acting), shown


def play(scene, scenario, folder):
    rigid = Rigid(scene, scenario["free"])
    loads = list(loads_of(scene, scenario, folder))
    coordinates = scene.file.section("NodeCoordinates")[:, :, 0]
    probes = []
    for probe in scenario["output"].get("probe", []):
        node = int(np.argmin(np.linalg.norm(coordinates - probe["point"], axis=1)))
        direction = np.array(probe["direction"], dtype=float)
        probes.append((node, direction / np.linalg.norm(direction)))
    gravity = np.array(scenario["free"].get("gravity", [0, 0, 0]), dtype=float)
    y, shown = scene.start(np.zeros(scene.r), np.zeros(scene.r), None), []
    for n in range(max(1, round(scenario["duration"] / scene.v.dt)) + 1):
        moved = [(coordinates[node], direction, scene.displacement(y, node, shown)) for node, direction in probes]
        own = [n * scene.v.dt, scene.energy(y, shown), *scene.probes(y[0], shown)]
        along = [direction @ u for _, direction, u in moved]
        space = np.array([rigid.place(point, u) for point, _, u in moved]).ravel()
        yield [*own, *along, rigid.energy(), *rigid.x, *rigid.q, *space]
        y, shown = advance(scene, rigid, y, loads, n, gravity)


def main(file, scenario, table):
    file, folder = vademecum.read(file), pathlib.Path(scenario).parent
    with open(scenario, "rb") as text:
        scenario = tomllib.load(text)
    with open(table, encoding="utf-8", newline="") as rows:
        names, *given = list(csv.reader(rows))
    given = np.array(given, dtype=float)
    ours = np.array(list(play(step.STRUCTURES["exact"](file), scenario, folder)))
    if ours.shape != given.shape or len(names) != ours.shape[1]:
        print(f"{table}: {given.shape} numbers, and the reader has {ours.shape}")
        return False
    # The axes are taken from the least moment to the greatest, as the evaluator finds them on this file.
    slack = agree.bound_of("exact", len(ours))
    off = np.abs(ours - given) / np.maximum(np.abs(ours).max(axis=0), 1e-300)
    worst = int(np.argmax(off.max(axis=0)))
    print(f"{table}: the largest difference is {off.max():.1e} of the column `{names[worst]}`, {len(given)} rows")
    still = [name for name, column in zip(names, ours.T) if not np.any(column)]
    return off.max() <= 1e-9 + slack and not still


if __name__ == "__main__":
    sys.exit(0 if main(*sys.argv[1:]) else 1)
