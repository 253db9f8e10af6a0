"""A joined file against its parts: `joined.py ASSEMBLY.toml WHOLE.vdm`.

Made from `formats/assembly-1.md` and the section on ports of `formats/vademecum-1.md`: parts that are turned,
welds of patches whose nodes coincide, residual flexibility, rows of surface nodes. Rows are compared by what does
not depend on the sign of a mode: eigenvalues, and the flexibility of every loadable node at rest.
"""

import sys
import tomllib
from pathlib import Path

import numpy as np

import vademecum

TOLERANCE = 1e-9


def rotation(q):
    w, x, y, z = np.array(q) / np.linalg.norm(q)
    return np.array([
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ])


class Part:
    def __init__(self, entry, folder):
        self.file = file = vademecum.read(str(folder / entry["file"]))
        self.turn = rotation(entry.get("rotation", [1, 0, 0, 0]))
        position = np.array(entry.get("position", [0, 0, 0]), float)
        elastic = file.section("Eigenvalues").reshape(-1)
        places = file.section("NodeCoordinates").reshape(-1, 3)
        surface = file.section("SurfaceBasis").reshape(-1, 3, len(elastic))
        places = places[: len(surface)]
        names = bytes(file.section("PortNames").reshape(-1)).decode().split("\n")
        table = file.section("PortTable").reshape(-1, 7)
        nodes = file.section("PortNodes").reshape(-1)
        rows = file.section("PortRows").reshape(-1, len(elastic))
        motions = np.zeros((len(places), 3, 0))
        if "RigidBody" in file:
            mass, *rest = file.section("RigidBody").reshape(-1)
            centre, (xx, xy, xz, yy, yz, zz) = np.array(rest[:3]), rest[3:9]
            moments, axes = np.linalg.eigh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            shifts = np.broadcast_to(np.eye(3) / np.sqrt(mass), (len(places), 3, 3))
            turns = [np.cross(axis / np.sqrt(moment), places - centre) for axis, moment in zip(axes.T, moments)]
            motions = np.concatenate([shifts, np.stack(turns, axis=2)], axis=2)
        self.eigenvalues = np.concatenate([np.zeros(motions.shape[2]), elastic])
        # Along the axes of space.
        self.basis = np.einsum("ij,njk->nik", self.turn, np.concatenate([motions, surface], axis=2))
        self.places = places @ self.turn.T + position
        m = len(rows)
        residual = file.section("PortResidual").reshape(m, -1, 3)
        self.residual = np.einsum("ij,mnj->nim", self.turn, residual)
        self.ports, block = {}, np.zeros((m, m))
        own = np.zeros((m, motions.shape[2]))
        for name, (kind, row, count, first, number, *_) in zip(names, table):
            assert kind == 0 and count == 3 * number, "patches alone"
            chosen = nodes[first : first + number]
            self.ports[name] = (row, chosen)
            own[row : row + count] = motions[chosen].reshape(count, -1)
            for node in range(number):
                at = slice(row + 3 * node, row + 3 * node + 3)
                block[at, at] = self.turn
        # The same rows along the axes of space.
        self.rows = block @ np.concatenate([own, rows], axis=1)
        self.residual = self.residual @ block.T
        self.compliance = block @ file.section("PortCompliance").reshape(m, m) @ block.T
        self.inertia = block @ file.section("PortInertia").reshape(m, m) @ block.T


def main(assembly, whole):
    with open(assembly, "rb") as text:
        entries = tomllib.load(text)
    parts = [Part(entry, Path(assembly).parent) for entry in entries["part"]]
    names = [entry["name"] for entry in entries["part"]]
    weights = [[] for _ in parts]
    for joint in entries["joint"]:
        assert joint["kind"] == "weld"
        sides = [name.split(".", 1) for name in joint["between"]]
        first, second = [(names.index(part), *parts[names.index(part)].ports[port]) for part, port in sides]
        here, there = parts[first[0]].places[first[2]], parts[second[0]].places[second[2]]
        for node, place in enumerate(here):
            apart = np.linalg.norm(there - place, axis=1)
            other = int(np.argmin(apart))
            assert apart[other] < 1e-9, "nodes that coincide"
            for c in range(3):
                ends = [(first[0], first[1] + 3 * node + c, 1.0), (second[0], second[1] + 3 * other + c, -1.0)]
                for index, own in enumerate(weights):
                    row = np.zeros(len(parts[index].rows))
                    for part, at, sign in ends:
                        if part == index:
                            row[at] += sign
                    own.append(row)
    weights = [np.array(own) for own in weights]
    gamma = np.hstack([w @ p.rows for w, p in zip(weights, parts)])
    s = sum(w @ p.compliance @ w.T for w, p in zip(weights, parts))
    n = sum(w @ p.inertia @ w.T for w, p in zip(weights, parts))
    answers = np.linalg.solve(s, gamma)
    stiffness = np.diag(np.concatenate([p.eigenvalues for p in parts])) + gamma.T @ answers
    mass = np.eye(len(stiffness)) + answers.T @ n @ answers
    lower = np.linalg.inv(np.linalg.cholesky(mass))
    values, vectors = np.linalg.eigh(lower @ stiffness @ lower.T)
    shapes = lower.T @ vectors

    file = vademecum.read(whole)
    found = file.section("Eigenvalues").reshape(-1)
    worst = np.max(np.abs(found / values - 1))
    # The flexibility at rest of each loadable node with itself, of parts and of the joined file.
    at, expected, first = 0, [], 0
    for part, own in zip(parts, weights):
        count = part.file.meta["n_load_nodes"]
        packed = part.file.section("ContactResidual").reshape(-1, 6)
        r = part.basis.shape[2]
        for node in range(count):
            xx, xy, xz, yy, yz, zz = packed[node]
            block = part.turn @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ part.turn.T
            given = part.residual[node] @ own.T
            row = part.basis[node] @ shapes[first : first + r] - given @ answers @ shapes
            expected.append(row / values @ row.T + block - given @ np.linalg.solve(s, given.T))
        first += r
        at += count
    basis = file.section("SurfaceBasis").reshape(-1, 3, len(found))
    packed = file.section("ContactResidual").reshape(-1, 6)
    for node, block in enumerate(expected):
        xx, xy, xz, yy, yz, zz = packed[node]
        own = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) + basis[node] / found @ basis[node].T
        # A held node has no flexibility in either.
        worst = max(worst, np.max(np.abs(own - block)) / (np.max(np.abs(block)) or 1.0))
    # A comparison that nothing could fail would prove nothing: without inertia of the residual it fails.
    macneal = np.linalg.eigvalsh(stiffness)
    assert np.max(np.abs(found / macneal - 1)) > 1e3 * TOLERANCE, "nothing would be noticed"
    print(f"{len(found)} modes, {len(s)} rows of joints, {len(expected)} loadable nodes: {worst:.1e}")
    return 0 if worst <= TOLERANCE else f"the joined file is not that of its parts: {worst:.1e}"


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
