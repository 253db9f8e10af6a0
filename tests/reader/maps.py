"""What a builder puts into the terms: `maps.py FILE MATRICES`, the file of a problem and the folder that
`vademecum export matrices` made of the same problem.

Compares `E_i` and `H_i` of the block structure, as built and at the ends of every parameter but the regions'
own (whose matrices are not exported), with both maps of "The block structure" in `formats/vademecum-1.md`,
solved at full order. The map that the text names for the file has to be right, and the other one wrong.
"""

import csv
import sys

import numpy as np

import step
import vademecum


def read_matrix(path):
    """A symmetric Matrix Market file, as a full matrix."""
    with open(path, encoding="utf-8") as lines:
        rows = [line.split() for line in lines if not line.startswith("%")]
    n = int(rows[0][0])
    matrix = np.zeros((n, n))
    for i, j, value in rows[1:]:
        matrix[int(i) - 1, int(j) - 1] = matrix[int(j) - 1, int(i) - 1] = float(value)
    return matrix


def free_dofs(file, folder):
    """Node of the file and component of each row of the matrices."""
    node_of = {int(node): place for place, node in enumerate(file.section("NodeIds").ravel())}
    with open(f"{folder}/dofs.csv", encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(lines))
    return [(node_of[int(row["node"])], "xyz".index(row["component"])) for row in rows]


def solved_and_projected(m, k, b, theta):
    response = np.linalg.solve(m + theta * k, m @ b)
    return b.T @ m @ response - np.eye(b.shape[1]), response


def lifted(m, k, b, theta):
    g = np.linalg.solve(k, m)
    basis = g @ g @ b
    basis = basis @ np.linalg.inv(b.T @ m @ basis)
    mass, stiffness = basis.T @ m @ basis, basis.T @ k @ basis
    inverse = np.linalg.inv(mass + theta * stiffness)
    return -inverse @ (theta * stiffness), basis @ inverse


def settings_of(file):
    """As built, and both ends of each parameter of the whole body."""
    uniform = [p for p in file.meta["parameters"] if p["region"] is None]
    return [{}] + [{p["name"]: p[end]} for p in uniform for end in ("lower", "upper")]


def main(path, folder):
    file = vademecum.read(path)
    m, k = read_matrix(f"{folder}/mass.mtx"), read_matrix(f"{folder}/stiffness.mtx")
    dofs = free_dofs(file, folder)
    loadable = [i for i, (node, _) in enumerate(dofs) if node < file.meta["n_load_nodes"]]
    worst = {solved_and_projected: [0.0, 0.0], lifted: [0.0, 0.0]}
    for setting in settings_of(file):
        scene = step.Block(file, setting)
        b = np.array([scene.row(*dof) for dof in dofs])
        for i, (_, _, theta, _, _) in enumerate(scene.numbers):
            table = file.section("BlockLoad")
            rows = np.array([scene.g[i] @ table[dofs[d][0]] for d in loadable])
            ours = np.array([row.reshape(3, -1)[dofs[d][1]] for row, d in zip(rows, loadable)])
            for map_of, errors in worst.items():
                e, h = map_of(m, k, b, theta)
                increment = (h - b)[loadable]
                errors[0] = max(errors[0], np.abs(scene.e[i] - e).max() / np.abs(e).max())
                errors[1] = max(errors[1], np.abs(ours - increment).max() / np.abs(increment).max())
    # The file certifies the largest error at some places of the box; others may be a few times worse.
    # What is added is binary32, in which a file may hold its fields.
    allowed = 3 * float(file.meta["block_certificate"]["map_max"]) + 1e-7
    live = any(parameter["region"] is not None for parameter in file.meta["parameters"])
    right, wrong = (lifted, solved_and_projected) if live else (solved_and_projected, lifted)
    (e, h), (other_e, other_h) = worst[right], worst[wrong]
    print(f"{path.rsplit('/', 1)[-1]}: E and H of the text's map are off by {e:.1e}, {h:.1e}, those of the "
          f"other map by {other_e:.1e}, {other_h:.1e}; allowed {allowed:.1e}")
    return max(e, h) <= allowed < max(other_e, other_h)


if __name__ == "__main__":
    sys.exit(0 if main(*sys.argv[1:]) else 1)
