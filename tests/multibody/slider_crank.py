"""A slider-crank in Exudyn, whose connecting rod is reduced once by Exudyn and once by vademecum.

    python slider_crank.py FOLDER     the folder of `export craig-bampton --format exudyn`, frames at both ends

Compared: positions and deformation of three points over one second, and the frequencies of the assembled mechanism,
with each other and with the full order.
"""

import sys
from pathlib import Path

import exudyn as exu
import numpy as np
from exudyn.FEM import HCBstaticModeSelection, ObjectFFRFreducedOrderInterface
from exudyn.utilities import (
    GenericJoint, InertiaCuboid, LoadForceVector, MarkerBodyRigid, MarkerSuperElementRigid, ObjectGround, SensorSuperElement,
)
from scipy.linalg import eigh, null_space
from scipy.sparse import block_diag, csr_matrix

sys.path.insert(0, sys.argv[1])
import exudyn_body

CRANK, SPEED, SLIDER, FORCE = 0.1, 40.0, 0.4, 5.0
SECONDS, STEPS = 1.0, 2000
# Of the largest: the two bases span the same space, so rounding and the tolerance of Newton's iteration are left.
AGREEMENT = 1e-6
# Elastic frequencies by sixteen fixed-interface modes, of the full order.
REDUCTION = 1e-3


def own_reduction(data):
    """The matrices of vademecum, reduced by Exudyn: the same interfaces, as many modes."""
    fem = exudyn_body.feminterface()
    ends = [exudyn_body.interface(name) for name in ("x_min", "x_max")]
    kind = HCBstaticModeSelection.RBE2 if is_rigid() else HCBstaticModeSelection.RBE3
    fem.ComputeHurtyCraigBamptonModes(
        [one["meshNodeNumbers"] for one in ends], len(data["frequencies_hz"]), computationMode=kind,
        boundaryNodesWeights=[one["weightingFactors"] for one in ends],
    )
    return fem


def is_rigid():
    """True of rigid frames, false of averaging ones."""
    return exudyn_body.description()["interfaces"][0]["kind"] == "rigid"


def mechanism(fem, moving):
    """Crank, rod and slider in a line, at rest or with the crank turning; the number of the rod, sensors."""
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    ground = mbs.AddObject(ObjectGround())
    left, right = (exudyn_body.interface(name) for name in ("x_min", "x_max"))
    place = fem.GetNodePositionsAsArray()
    ends = [one["weightingFactors"] @ place[one["meshNodeNumbers"]] for one in (left, right)]
    length = ends[1][0] - ends[0][0]
    speed = SPEED if moving else 0.0
    turn = -speed * CRANK / length
    # The origin of the mesh is beside the pin at the crank.
    origin = np.array([CRANK, 0.0, 0.0]) - ends[0]
    velocity = np.array([0.0, speed * CRANK, 0.0]) + np.cross([0.0, 0.0, turn], -ends[0])
    crank_inertia = InertiaCuboid(density=7800.0, sideLengths=[CRANK, 0.03, 0.02])
    slider_inertia = InertiaCuboid(density=SLIDER / 0.05**3, sideLengths=[0.05] * 3)
    crank = mbs.CreateRigidBody(
        inertia=crank_inertia, referencePosition=[CRANK / 2, 0.0, 0.0],
        initialVelocity=[0.0, speed * CRANK / 2, 0.0], initialAngularVelocity=[0.0, 0.0, speed],
    )
    slider = mbs.CreateRigidBody(inertia=slider_inertia, referencePosition=[CRANK + length, 0.0, 0.0])
    cms = ObjectFFRFreducedOrderInterface(fem)
    rod = cms.AddObjectFFRFreducedOrder(
        mbs, positionRef=origin, initialVelocity=velocity, initialAngularVelocity=[0.0, 0.0, turn],
    )["oFFRFreducedOrder"]

    def rigid(body, at):
        return mbs.AddMarker(MarkerBodyRigid(bodyNumber=body, localPosition=at))

    def joint(one, other, axes):
        mbs.AddObject(GenericJoint(markerNumbers=[one, other], constrainedAxes=axes))

    pins = [mbs.AddMarker(MarkerSuperElementRigid(bodyNumber=rod, **one)) for one in (left, right)]
    joint(rigid(ground, [0.0] * 3), rigid(crank, [-CRANK / 2, 0.0, 0.0]), [1, 1, 1, 1, 1, 0])
    joint(rigid(crank, [CRANK / 2, 0.0, 0.0]), pins[0], [1, 1, 1, 1, 1, 0])
    joint(rigid(slider, [0.0] * 3), pins[1], [1, 1, 0, 0, 0, 0])
    joint(rigid(ground, [CRANK + length, 0.0, 0.0]), rigid(slider, [0.0] * 3), [0, 1, 1, 1, 1, 1])
    if moving:
        mbs.AddLoad(LoadForceVector(markerNumber=rigid(slider, [0.0] * 3), loadVector=[FORCE, 0.0, 0.0]))
    points = [fem.GetNodeAtPoint(point) for point in points_of(place)]
    sensors = [
        mbs.AddSensor(SensorSuperElement(
            bodyNumber=rod, meshNodeNumber=node, storeInternal=True, outputVariableType=kind, writeToFile=False,
        ))
        for kind in (exu.OutputVariableType.Displacement, exu.OutputVariableType.DisplacementLocal)
        for node in points
    ]
    mbs.Assemble()
    inertia = crank_inertia.Translated([CRANK / 2, 0.0, 0.0]).Inertia()[2, 2]
    return mbs, sensors, inertia


def points_of(place):
    """Corners of the two ends and a node half way, on top."""
    low, high = place.min(axis=0), place.max(axis=0)
    middle = 0.5 * (low + high)
    return [low, [middle[0], high[1], middle[2]], high]


def run(fem):
    """Displacements of three points and their part by deformation, (steps, 3 points · 3), of each."""
    mbs, sensors, _ = mechanism(fem, True)
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime, settings.timeIntegration.numberOfSteps = SECONDS, STEPS
    settings.timeIntegration.newton.relativeTolerance = 1e-12
    settings.timeIntegration.newton.absoluteTolerance = 1e-12
    settings.timeIntegration.newton.useModifiedNewton = False
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = SECONDS / STEPS
    mbs.SolveDynamic(settings)
    found = [mbs.GetSensorStoredData(sensor)[:, 1:4] for sensor in sensors]
    return np.hstack(found[:3]), np.hstack(found[3:])


def assembled_frequencies(fem, count):
    """Frequencies [Hz] of the mechanism at rest, by Exudyn."""
    mbs, _, _ = mechanism(fem, False)
    values = mbs.ComputeODE2Eigenvalues(numberOfEigenvalues=0)[0]
    frequencies = np.sqrt(np.abs(values)) / (2 * np.pi)
    # The mechanism itself has no stiffness.
    return np.sort(frequencies)[1:][:count]


def full_frequencies(data, inertia, count):
    """The same by the matrices at full order: frames by multipliers, crank and slider as masses, joints held."""
    place = data["nodes"]
    matrix = lambda name: csr_matrix(tuple(data[f"full_{name}_{part}"] for part in ("data", "indices", "indptr")))
    n = 3 * len(place)
    # Displacements of the nodes, then the motions of both frames.
    mass, stiffness = (block_diag((matrix(name), csr_matrix((12, 12)))).tolil() for name in ("mass", "stiffness"))
    # The crank turns about the origin, and the pin moves along y; the slider moves along x.
    mass[n + 1, n + 1], mass[n + 6, n + 6] = inertia / CRANK**2, SLIDER
    rows = []
    for end, name in enumerate(("x_min", "x_max")):
        one = exudyn_body.interface(name)
        nodes, weights = one["meshNodeNumbers"], one["weightingFactors"]
        arms = place[nodes] - weights @ place[nodes]
        moved = np.vstack([np.hstack([np.eye(3), [[0, z, -y], [-z, 0, x], [y, -x, 0]]]) for x, y, z in arms])
        frame, dofs = n + 6 * end + np.arange(6), (3 * np.array(nodes)[:, None] + np.arange(3)).ravel()
        if is_rigid():
            own = [(dofs, np.eye(len(dofs))), (frame, -moved)]
        else:
            shares = moved.T * np.repeat(weights, 3)
            own = [(dofs, shares), (frame, -shares @ moved)]
        block = np.zeros((len(own[0][1]), n + 12))
        for columns, values in own:
            block[:, columns] = values
        rows.append(block)
    # The crank holds the left pin along x and z and about x and y, the guide the right one along y.
    held = np.zeros((5, n + 12))
    held[np.arange(5), n + np.array([0, 2, 3, 4, 7])] = 1.0
    free = csr_matrix(null_space(np.vstack([*rows, held])))
    mass, stiffness = free.T @ mass @ free, free.T @ stiffness @ free
    values = eigh(stiffness.toarray(), mass.toarray(), eigvals_only=True, subset_by_index=[0, count])
    return np.sqrt(np.abs(values))[1:] / (2 * np.pi)


def reduced_frequencies(data, inertia, count):
    """The same by the superelement."""
    mass, stiffness = data["mass"].copy(), data["stiffness"]
    mass[1, 1] += inertia / CRANK**2
    mass[6, 6] += SLIDER
    free = np.setdiff1d(np.arange(len(mass)), [0, 2, 3, 4, 7])
    values = eigh(stiffness[np.ix_(free, free)], mass[np.ix_(free, free)], eigvals_only=True)
    return np.sqrt(np.abs(values))[1:count + 1] / (2 * np.pi)


def largest(found, expected):
    """Largest difference, of the largest value."""
    return np.abs(found - expected).max() / np.abs(expected).max()


def main():
    data = exudyn_body.arrays()
    ours, theirs = exudyn_body.feminterface(), own_reduction(data)
    count = 6
    worst = {}
    (moved, bent), (other_moved, other_bent) = run(ours), run(theirs)
    worst["displacement"] = largest(moved, other_moved)
    worst["deformation"] = largest(bent, other_bent)
    print(f"three points over {SECONDS} s: displacement up to {np.abs(other_moved).max():.3e} m, differs by "
          f"{worst['displacement']:.1e} of it; deformation up to {np.abs(other_bent).max():.3e} m, by {worst['deformation']:.1e}")
    assert np.abs(other_bent).max() > 1e-6, "the rod deforms"
    assert worst["displacement"] <= AGREEMENT and worst["deformation"] <= AGREEMENT, worst
    _, _, inertia = mechanism(ours, False)
    full = full_frequencies(data, inertia, count)
    own, theirs_ = assembled_frequencies(ours, count), assembled_frequencies(theirs, count)
    reduced = reduced_frequencies(data, inertia, count)
    mean = assembled_frequencies(exudyn_body.feminterface(floating="mean"), count)
    print("assembled, full order:", ", ".join(f"{f:.3f}" for f in full), "Hz")
    found_by = {"ours in Exudyn": own, "ours, mean axes": mean, "Exudyn's": theirs_, "superelement": reduced}
    for name, found in found_by.items():
        print(f"{name}: within {np.abs(found / full - 1).max():.1e} of the full order")
        assert np.abs(found / full - 1).max() <= REDUCTION, (name, found, full)
    assert np.abs(own / theirs_ - 1).max() <= AGREEMENT, (own, theirs_)
    print("the rod that vademecum reduced and the one that Exudyn reduced agree")


main()
