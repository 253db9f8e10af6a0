#!/usr/bin/env python3
"""How many modes, or nodes around a contact, would hold the static answer to a point force.

    vademecum export matrices BODY.toml --scenario ANY.toml --basis modes --modes 8 -o FOLDER
    tests/scripts/static-fields.py FOLDER

Wants NumPy and SciPy. At 40 surface nodes drawn with seed 0: what m natural modes leave of the static answer, relative,
mass norm, worst direction (median and largest); and the share of nodes that a patch keeps where what is dropped is 1 % of
the static answer in the worst direction (mass lumped by rows). Numbers of docs/explanation/why-these-defaults.md.
"""

import csv
import sys

import numpy as np
import scipy.io
import scipy.sparse.linalg

MODES = [32, 64, 128, 256]
DROPPED = 1e-2


def main(folder):
    mass, stiffness = (scipy.io.mmread(f"{folder}/{name}.mtx").tocsc() for name in ("mass", "stiffness"))
    with open(f"{folder}/dofs.csv", encoding="utf-8") as rows:
        owner = [int(row["node"]) for row in csv.DictReader(rows)]
    with open(f"{folder}/triangles.csv", encoding="utf-8") as rows:
        touched = {int(corner) for row in csv.DictReader(rows) for corner in row.values()}
    nodes, place = np.unique(owner, return_inverse=True)
    surface = sorted(touched.intersection(nodes.tolist()))
    factor = scipy.sparse.linalg.splu(stiffness)
    inverse = scipy.sparse.linalg.LinearOperator(stiffness.shape, matvec=factor.solve)
    values, vectors = scipy.sparse.linalg.eigsh(stiffness, MODES[-1], mass, sigma=0, OPinv=inverse)
    order = np.argsort(values)
    values, vectors = values[order], vectors[:, order]
    lumped = np.abs(np.asarray(mass.sum(axis=1)).ravel())
    print(f"{len(owner)} dofs, {len(nodes)} nodes, {len(surface)} on the surface")
    found = {m: [] for m in MODES}
    for node in np.random.default_rng(0).choice(surface, min(40, len(surface)), replace=False):
        dofs = np.flatnonzero(np.array(owner) == node)
        force = np.zeros((len(owner), len(dofs)))
        force[dofs, np.arange(len(dofs))] = 1
        answer = factor.solve(force)
        unit = np.linalg.inv(np.linalg.cholesky(answer.T @ (mass @ answer)))
        for m in MODES:
            rest = answer - vectors[:, :m] @ ((vectors[:, :m].T @ force) / values[:m, None])
            left = np.sqrt(np.linalg.eigvalsh(unit @ (rest.T @ (mass @ rest)) @ unit.T)[-1])
            weight = np.bincount(place, ((unit @ rest.T) ** 2).sum(0) * lumped)
            dropped = np.searchsorted(np.cumsum(np.sort(weight)), DROPPED**2)
            found[m].append((left, 1 - dropped / len(nodes)))
    for m, rows in found.items():
        left, kept = np.array(rows).T
        print(f"{m} modes leave {np.median(left):.2e}, at most {left.max():.2e}; a patch keeps {kept.mean():.2f}")


main(*sys.argv[1:])
