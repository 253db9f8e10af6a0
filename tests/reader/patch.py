"""Contacts near each other, made from the text of the format alone.

    patch.py FILE

Section 108 has the pairs that the text asks for. Further modes and section 109 together are the residual of a
single contact, sections 34 and 36. The flexibility between all loadable nodes as contacts is semidefinite.
"""

import sys

import numpy as np
import vademecum

TOLERANCE = 1e-9


def taper(t):
    return np.where(t < 1, (1 - t) ** 4 * (4 * t + 1), 0.0)


def reach(file, places):
    """The largest distance from each loadable node to a node of a loadable facet with it."""
    triangles = file.section("Triangles").reshape(-1, 3)[: file.meta["n_load_triangles"]]
    facets = {place: list(nodes) for place, nodes in enumerate(triangles)}
    if "Quadrangles" in file:
        for first, count, *nodes in file.section("Quadrangles")[:, :, 0]:
            for place in range(first, first + count):
                del facets[place]
            facets[int(first)] = [node for node in nodes if node != 2**32 - 1]
    found = np.zeros(len(places))
    for nodes in facets.values():
        for node in nodes:
            apart = np.linalg.norm(places[nodes] - places[node], axis=1)
            found[node] = max(found[node], apart.max())
    return found


def main(path):
    file = vademecum.read(path)
    n = file.meta["n_load_nodes"]
    places = file.section("NodeCoordinates").reshape(-1, 3)[:n]
    h = file.section("ContactPatch").item()
    pairs = file.section("PatchPairs").reshape(-1, 2)
    blocks = file.section("PatchResidual").reshape(-1, 3, 3)
    rows = file.section("ContactModes").reshape(3 * n, -1)

    apart = np.linalg.norm(places[:, None] - places[None], axis=2)
    gap = apart - np.add.outer(reach(file, places), reach(file, places))
    expected = [(a, b) for a in range(n) for b in range(a, n) if gap[a, b] <= h]
    assert expected == [tuple(int(node) for node in pair) for pair in pairs], "other pairs"

    rest = np.zeros((3 * n, 3 * n))
    for (a, b), block in zip(pairs.astype(int), blocks):
        rest[3 * a : 3 * a + 3, 3 * b : 3 * b + 3] = block
        rest[3 * b : 3 * b + 3, 3 * a : 3 * a + 3] = block.T
    fixed = rows @ rows.T
    worst, missed = 0.0, 0.0
    contact = file.section("ContactResidual").reshape(-1, 6)
    singles = {(node, node): xx[[0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(3, 3) for node, xx in enumerate(contact)}
    neighbours = file.section("ResidualPairs").reshape(-1, 2).astype(int)
    for (a, b), block in zip(neighbours, file.section("PairResidual").reshape(-1, 3, 3)):
        singles[a, b] = block
    size = np.abs(contact).max()
    for (a, b), block in singles.items():
        at = np.ix_(range(3 * a, 3 * a + 3), range(3 * b, 3 * b + 3))
        worst = max(worst, np.abs(fixed[at] + rest[at] - block).max() / size)
        missed = max(missed, np.abs(rest[at] - block).max() / size)
    # A comparison that nothing could fail would prove nothing: without the further modes it fails.
    assert missed > 1e3 * TOLERANCE, "nothing would be noticed"

    matrix = fixed + rest * np.kron(taper(apart / h), np.ones((3, 3)))
    values = np.linalg.eigvalsh(matrix)
    assert values[0] >= -1e-6 * values[-1], f"an eigenvalue of {values[0]:.1e} beside {values[-1]:.1e}"
    print(f"{n} loadable nodes, {len(pairs)} pairs, {rows.shape[1]} further modes: {worst:.1e}")
    return 0 if worst <= TOLERANCE else f"the patch is not the residual of a single contact: {worst:.1e}"


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
