"""A block of linear tetrahedra that is held at one end, and a push on the other: what the comparisons of this folder share."""

import itertools
import math

import numpy as np


class Block:
    """Nodes, six tetrahedra a cell, and the lumped share of each node of the free end in a unit force spread evenly over it."""

    def __init__(self, lengths, cells, density):
        self.lengths, self.cells, self.density = lengths, cells, density
        counts = [c + 1 for c in cells]
        grids = [np.linspace(0, length, count) for length, count in zip(lengths, counts)]
        self.nodes = np.array(list(itertools.product(*grids)))

        def index(i, j, k):
            return (i * counts[1] + j) * counts[2] + k

        tetrahedra = []
        for corner in itertools.product(*map(range, cells)):
            for axes in itertools.permutations(range(3)):
                path = [list(corner)]
                for axis in axes:
                    path.append(list(path[-1]))
                    path[-1][axis] += 1
                tetrahedra.append([index(*p) for p in path])
        self.tetrahedra = np.array(tetrahedra)
        edges = self.nodes[self.tetrahedra[:, 1:]] - self.nodes[self.tetrahedra[:, :1]]
        self.volumes = np.linalg.det(edges) / 6
        turned = self.volumes < 0
        self.tetrahedra[turned] = self.tetrahedra[turned][:, [1, 0, 2, 3]]
        self.volumes = abs(self.volumes)
        faces = self.tetrahedra[:, list(itertools.combinations(range(4), 3))].reshape(-1, 3)
        on_end = np.all(self.nodes[faces][:, :, 0] > lengths[0] - 1e-9, axis=1)
        self.end_faces = faces[on_end]
        corners = self.nodes[self.end_faces]
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
        self.shares = np.zeros(len(self.nodes))
        np.add.at(self.shares, self.end_faces.ravel(), np.repeat(areas / 3, 3) / areas.sum())
        self.tip = index(cells[0], cells[1] // 2, cells[2] // 2)
        self.middle = index(cells[0] // 2, cells[1] // 2, cells[2] // 2)

    def lumped(self):
        """Mass of each node, a quarter of that of its tetrahedra."""
        masses = np.zeros(len(self.nodes))
        np.add.at(masses, self.tetrahedra.ravel(), np.repeat(self.density * self.volumes / 4, 4))
        return masses

    def held(self):
        """The nodes of the clamped end."""
        return np.flatnonzero(self.nodes[:, 0] < 1e-9)

    def inner(self, u, v):
        """Sums of the mass-weighted products of displacements of shape (instants, nodes, 3)."""
        a, b = u[:, self.tetrahedra], v[:, self.tetrahedra]
        # The mass of a linear tetrahedron: rho V / 20 (1 + delta).
        products = np.einsum("teni,teni->te", a, b) + np.einsum("tei,tei->te", a.sum(axis=2), b.sum(axis=2))
        return float(self.density / 20 * (products @ self.volumes).sum())

    def error(self, u, reference):
        return math.sqrt(self.inner(u - reference, u - reference) / self.inner(reference, reference))

    def write_gmsh(self, path):
        lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str(len(self.nodes))]
        lines += [f"{i} {x!r} {y!r} {z!r}" for i, (x, y, z) in enumerate(self.nodes.tolist(), 1)]
        lines += ["$EndNodes", "$Elements", str(len(self.tetrahedra))]
        lines += [f"{i} 4 2 1 1 {a} {b} {c} {d}" for i, (a, b, c, d) in enumerate((self.tetrahedra + 1).tolist(), 1)]
        path.write_text("\n".join([*lines, "$EndElements", ""]))


def force(load, t):
    size, duration, angle = load
    amplitude = size * math.sin(math.pi * t / duration) ** 2 if t < duration else 0.0
    return amplitude * math.sin(math.radians(angle)), amplitude * math.cos(math.radians(angle))
