"""The pad: its mesh, and its problem with a load pattern for each direction of each taxel.

    python pad.py FOLDER        writes pad.inp and pad.toml there, for `vademecum build`
"""

import itertools
import sys
from pathlib import Path

import numpy as np

import vademecum

#: Lengths in m, and cells along them.
LENGTHS = np.array([0.02, 0.02, 0.008])
CELLS = np.array([10, 10, 4])
AXES = "xyz"


def grid(points):
    """Where points are, in halves of cells."""
    return np.rint(2 * np.asarray(points) * CELLS / LENGTHS).astype(int)


def block():
    """Points, shape (n, 3), and tetrahedra of ten nodes in the order of meshio: six in each cell."""
    counts = 2 * CELLS + 1
    tetrahedra = []
    for cell in itertools.product(*map(range, CELLS)):
        for way in itertools.permutations(range(3)):
            # From one corner of the cell to the opposite one, along three edges.
            corners = [2 * np.array(cell)]
            for axis in way:
                corners.append(corners[-1] + 2 * np.eye(3, dtype=int)[axis])
            if np.linalg.det(np.diff(corners, axis=0)) < 0:
                corners[1], corners[2] = corners[2], corners[1]
            middles = [(corners[a] + corners[b]) // 2 for a, b in ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))]
            tetrahedra.append(corners + middles)
    numbers = np.ravel_multi_index(np.array(tetrahedra).transpose(2, 0, 1), counts)
    used, numbers = np.unique(numbers, return_inverse=True)
    return np.column_stack(np.unravel_index(used, counts)) * LENGTHS / (2 * CELLS), numbers.reshape(-1, 10)


def taxels(points):
    """The places that feel a touch, by their numbers among the points: corners of cells at the front, row by row."""
    at = grid(points)
    found = np.flatnonzero((at % 2 == 0).all(axis=1) & (at[:, 2] == 2 * CELLS[2]))
    return found[np.lexsort(at[found, 1::-1].T)]


def write(folder):
    """Writes mesh and problem."""
    points, tetrahedra = block()
    at = grid(points)
    groups = {
        "back": np.flatnonzero(at[:, 2] == 0),
        "front": np.flatnonzero(at[:, 2] == 2 * CELLS[2]),
        "layer": np.flatnonzero((at % 2 == 0).all(axis=1) & (at[:, 2] == 2)),
    }
    vademecum.write_mesh(folder / "pad.inp", points, {"tetra10": tetrahedra}, point_sets=groups)
    lines = [(Path(__file__).parent / "pad.toml").read_text()]
    for taxel, node in enumerate(taxels(points)):
        for axis, force in zip(AXES, np.eye(3).tolist()):
            lines += ["[[load.pattern]]", f'name = "{taxel} {axis}"', f"forces = [{[int(node) + 1, *force]}]"]
    (folder / "pad.toml").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    write(Path(sys.argv[1]))
