"""Compares a file built on ranks with one built in one process: frequencies, the space of the modes, what unit forces at loadable
nodes do for ever, and trajectories.

compare.py READER LOCAL RANKS [no-static-answers | frequencies-alone]: the folder of the reader `vademecum.py`, and two paths without an ending, beside
which lie the files `.vdm`, what `info --json` prints in `.json`, and `probes.csv` of a run in the folder of that name. Files by stages
have no static answers, and have to be named; of bodies that are too thin for the rest, frequencies are compared alone.
"""

import csv
import json
import sys

import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, sys.argv[1])
import vademecum  # noqa: E402

ALLOWED = {"frequencies": 1e-9, "modes": 1e-6, "static answers": 1e-9, "trajectories": 1e-8}


def frequencies(path):
    with open(f"{path}.json") as file:
        return np.array([row["frequency_hz"] for row in json.load(file)["mode_table"]])


def columns(path):
    with open(f"{path}/probes.csv") as file:
        rows = list(csv.reader(file))
    return rows[0], np.array(rows[1:], dtype=float).T


def basis(file):
    """Rows of the modes, (dofs, r), nodes of the surface first."""
    names = [name for name in ("SurfaceBasis", "InteriorBasis") if name in file]
    rows = np.concatenate([file.section(name) for name in names])
    return rows.reshape(-1, rows.shape[-1])


def static_answers(file):
    """`K⁻¹` between each loadable node and itself: what the modes have of it and what they leave out."""
    loadable = file.meta["n_load_nodes"]
    rows = basis(file).reshape(-1, 3, file.meta["n_modes"])[:loadable]
    values = file.section("Eigenvalues").ravel()
    own = np.einsum("nik,njk->nij", rows / values, rows)
    xx, xy, xz, yy, yz, zz = file.section("ContactResidual").reshape(loadable, 6).T
    left_out = np.moveaxis(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), 2, 0)
    return own + left_out


def angle(a, b):
    """Sine of the largest angle between two spaces; one orthonormal base less its share of the other, so that small angles count."""
    a, b = np.linalg.qr(a)[0], np.linalg.qr(b)[0]
    return np.linalg.norm(b - a @ (a.T @ b), 2)


def relative(a, b):
    return np.abs(a - b).max() / np.abs(a).max()


_, _, local, ranks, *without = sys.argv
assert without in ([], ["no-static-answers"], ["frequencies-alone"]), without
files = [vademecum.read(f"{path}.vdm") for path in (local, ranks)]
ours, theirs = frequencies(local), frequencies(ranks)
assert len(ours) and ours.shape == theirs.shape, (ours.shape, theirs.shape)
(names, run), (other_names, other_run) = columns(local), columns(ranks)
assert names == other_names and len(names) > 1 and run.shape[1] > 100 and run.shape == other_run.shape, (names, run.shape)
assert np.isfinite([*run, *other_run]).all(), "not a number in a trajectory"
assert np.abs(run).max(axis=1).min() > 0.0, "something does not move"
assert all(file.section("SurfaceBasis").size for file in files), "no modes"
found = {
    "frequencies": np.abs(theirs / ours - 1.0).max(),
    "modes": angle(*(basis(file) for file in files)),
    "trajectories": np.max([relative(a, b) for a, b in zip(run, other_run)]),
}
stages = without == ["no-static-answers"]
assert all(("ContactResidual" in file) != stages for file in files), "static answers"
if not without:
    found["static answers"] = relative(*(static_answers(file) for file in files))
if without == ["frequencies-alone"]:
    found = {"frequencies": found["frequencies"]}
print(", ".join(f"{name} {off:.1e} of {ALLOWED[name]:.0e}" for name, off in found.items()))
# What is not a number is within nothing.
sys.exit(not all(np.isfinite(off) and off <= ALLOWED[name] for name, off in found.items()))
