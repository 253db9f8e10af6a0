"""A file with live regions at values of its parameters, from "Parametric models" of `formats/vademecum-1.md`.

`set_to(file, values, modes)` changes a file that was read into the ordinary file of `modes` modes there.
"""

import numpy as np

# Roles of section 111.
STIFFNESS, REGION_STIFFNESS, DENSITY, REGION_DENSITY, ALPHA, BETA, TIME_STEP, LOSS, DAMPING = range(9)
# What is not part of a file at values.
GONE = ["ReducedStiffness", "StaticBound", "BoundMap", "FactorOrder", "FactorGroups", "FactorRows", "FactorValues",
        "PatternAnswer", "ContactModes"]


def full(packed, r):
    """The symmetric matrix of a lower triangle, row by row."""
    lower = np.zeros((r, r))
    lower[np.tril_indices(r)] = packed
    return lower + np.tril(lower, -1).T


class Values:
    """Scales of the matrices, and what stands in the metadata."""

    def __init__(self, file, given):
        rows = file.section("LiveParameters")[:, :, 0]
        regions = file.section("LiveStiffness").shape[0]
        self.stiffness, self.density = 1.0, 1.0
        self.kappa, self.rho = np.ones(regions), np.ones(regions)
        self.loss = file.section("LiveLoss").reshape(-1).copy() if "LiveLoss" in file else None
        groups = file.section("LiveDampers").reshape(-1).astype(int) if "LiveDampers" in file else np.zeros(0, int)
        self.dampers = np.ones(len(groups))
        for name, row in zip(file.lines("LiveNames"), rows):
            role, region = int(row[0]), int(row[1])
            value = given.pop(name, row[5])
            assert row[3] <= value <= row[4], name
            if role == STIFFNESS:
                self.stiffness = value
            elif role == REGION_STIFFNESS:
                self.kappa[1 + region] = value
            elif role == DENSITY:
                self.density = value
            elif role == REGION_DENSITY:
                self.rho[1 + region] = value
            elif role == LOSS:
                self.loss[1 + region] = value
            elif role == DAMPING:
                self.dampers[groups == 1 + region] = value
            else:
                file.meta[{ALPHA: "alpha", BETA: "beta", TIME_STEP: "time_step"}[role]] = value
        assert not given, f"unknown: {list(given)}"

    def rho_of_nodes(self, file):
        """`ρ` of each loadable node: how its residual flexibility outside of the basis is scaled."""
        nodes = file.meta["n_load_nodes"]
        if "LiveResidual" not in file:
            return np.full(nodes, 1 / self.stiffness)
        kappa = np.append(self.kappa, self.kappa[1:].mean())
        rho = np.zeros(nodes)
        for node, a, b, share, weight in file.section("LiveResidual")[:, :, 0]:
            mixed = (1 - share) * kappa[int(a)] + share * kappa[int(b)]
            rho[int(node)] += weight / (self.stiffness * mixed)
        return rho


def set_to(file, given, modes=32):
    r, load = file.meta["n_modes"], file.meta["n_load_nodes"]
    m = min(modes, r)
    v = Values(file, dict(given))

    def summed(name, scales):
        return sum(scale * full(packed, r) for scale, packed in zip(scales, file.section(name)[:, :, 0]))

    stiffness = v.stiffness * summed("LiveStiffness", v.kappa)
    mass = v.density * (summed("LiveMass", v.rho) if "LiveMass" in file else np.eye(r))
    factor = np.linalg.cholesky(mass)
    half = np.linalg.solve(factor, np.linalg.solve(factor, stiffness).T)
    lam, vectors = np.linalg.eigh((half + half.T) / 2)
    lam, shapes = lam[:m], np.linalg.solve(factor.T, vectors[:, :m])
    # What the modes that are not stepped answer.
    left = np.linalg.inv(stiffness) - shapes @ np.diag(1 / lam) @ shapes.T

    surface = file.section("SurfaceBasis")
    nodes = surface[:load].reshape(3 * load, r)
    probes = file.section("ProbeRows").reshape(-1, r) if "ProbeRows" in file else np.zeros((0, r))
    patterns = file.section("PatternBasis").reshape(-1, r) if "PatternBasis" in file else np.zeros((0, r))
    new = {"Eigenvalues": lam.reshape(-1, 1, 1)}
    for name, rows in [("PatternBasis", patterns), ("ProbeRows", probes)]:
        new[name] = (rows @ shapes).reshape(-1, m, 1)
    for name in ("SurfaceBasis", "InteriorBasis"):
        if name in file:
            new[name] = file.section(name) @ shapes
    if "DampingRatios" in file:
        new["DampingRatios"] = file.section("DampingRatios")[:m]
    if v.loss is not None:
        eta = np.append(0.0, v.loss[1:])
        lost = v.stiffness * summed("LiveStiffness", eta * v.kappa)
        energies = np.einsum("ik,ij,jk->k", shapes, lost, shapes)
        new["DampingRatios"] = (v.loss[0] + 0.5 * energies / lam).reshape(-1, 1, 1)
    if "DampingRows" in file:
        rows = file.section("DampingRows").reshape(-1, r)
        new["DampingRows"] = (np.sqrt(v.dampers)[:, None] * rows @ shapes).reshape(-1, m, 1)

    rho = v.rho_of_nodes(file)
    if "ContactResidual" in file:
        between = nodes @ left @ nodes.T
        own = file.section("ContactResidual").reshape(-1, 6).copy()
        places = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]
        for node in range(load):
            own[node] *= rho[node]
            own[node] += [between[3 * node + i, 3 * node + j] for i, j in places]
        new["ContactResidual"] = own.reshape(-1, 6, 1)
        blocks = file.section("PairResidual").reshape(-1, 3, 3).copy()
        for (a, b), block in zip(file.section("ResidualPairs").reshape(-1, 2).astype(int), blocks):
            block *= np.sqrt(rho[a] * rho[b])
            block += between[3 * a : 3 * a + 3, 3 * b : 3 * b + 3]
        new["PairResidual"] = blocks.reshape(-1, 9, 1)
        if "PatchResidual" in file:
            blocks = file.section("PatchResidual").reshape(-1, 3, 3).copy()
            for (a, b), block in zip(file.section("PatchPairs").reshape(-1, 2).astype(int), blocks):
                block *= np.sqrt(rho[a] * rho[b])
                block += between[3 * a : 3 * a + 3, 3 * b : 3 * b + 3]
            new["PatchResidual"] = blocks.reshape(-1, 9, 1)
        for name, rows in [("ProbeResidual", probes), ("PatternResidual", patterns)]:
            if name in file:
                built = file.section(name)
                scaled = built.reshape(len(rows), 3 * load) * np.repeat(rho, 3)
                new[name] = (scaled + rows @ left @ nodes.T).reshape(built.shape)
        if "PatternProbeResidual" in file:
            built = file.section("PatternProbeResidual")
            mean = rho.mean()
            new["PatternProbeResidual"] = mean * built + (patterns @ left @ probes.T).reshape(built.shape)

    if "ReactionBasis" in file:
        built = file.section("ReactionBasis").reshape(-1, 6, r)
        regions = len(v.kappa)

        def of_regions(name, scales):
            return np.tensordot(scales, file.section(name).reshape(len(built), regions, 6, r), (0, 1))

        y = np.zeros_like(built)
        if "LiveReactionStiffness" in file:
            force = v.stiffness * of_regions("LiveReactionStiffness", v.kappa)
            y = -np.linalg.solve(stiffness, force.reshape(-1, r).T).T.reshape(built.shape)
        if "LiveReactionMass" in file:
            inertia = v.density * of_regions("LiveReactionMass", v.rho) + y @ mass
        else:
            inertia = v.density * (built + y)
        new["ReactionBasis"] = inertia @ shapes
        if "ReactionLoads" in file:
            loads = file.section("ReactionLoads").reshape(len(built), load, 6, 3)
            work = np.einsum("ncr,smr->snmc", surface[:load], y)
            new["ReactionLoads"] = (loads - work).reshape(len(built), load, 18)
        if "PatternReaction" in file:
            work = np.einsum("pr,smr->psm", patterns, y)
            new["PatternReaction"] = file.section("PatternReaction") - work

    for name in [*GONE, *(name for name in file.entries if name.startswith("Live"))]:
        file.entries.pop(name, None)
    new = {name: numbers for name, numbers in new.items() if name in file}
    file.decoded |= new
    file.meta["n_modes"], file.meta["parameters"] = m, []
    return file
