"""The body of this folder for Exudyn 1.13, as `vademecum export craig-bampton` has written it.

    from exudyn_body import feminterface, floating_body
    cms = floating_body()                                # an ObjectFFRFreducedOrderInterface
    body = cms.AddObjectFFRFreducedOrder(mbs, positionRef=[0, 0, 0], gravity=[0, 0, -9.81])
    marker = mbs.AddMarker(MarkerSuperElementRigid(bodyNumber=body['oFFRFreducedOrder'], **interface('pin')))

The floating frame of Exudyn moves as a rigid body and the modes move in it, so the six rigid motions of the
superelement have to leave its columns. `first` leaves out the coordinates of the first interface, which must be a
frame: it is at rest in the floating frame. `mean` takes what has no momentum: mean axes, for interfaces of any kind.
`none` keeps all columns, of which the program has to hold six (as with `HCBstaticModeSelection.allBoundaryNodes`).
"""

import json
from pathlib import Path

import numpy as np
from exudyn.FEM import FEMinterface, ObjectFFRFreducedOrderInterface
from scipy.sparse import csr_matrix

FOLDER = Path(__file__).resolve().parent


def arrays(folder=FOLDER):
    """The arrays of the superelement, by name."""
    with np.load(Path(folder) / "superelement.npz") as file:
        return {name: file[name] for name in file.files}


def description(folder=FOLDER):
    """The rows of its matrices, and what they belong to."""
    return json.loads((Path(folder) / "superelement.json").read_text())


def mode_basis(data, described, floating="auto"):
    """Columns without rigid motions, one row for each displacement of each node; `auto` takes `first` if it can."""
    if floating not in ("auto", "first", "mean", "none"):
        raise ValueError(f"floating is {floating!r}; expected 'auto', 'first', 'mean' or 'none'")
    motions, first = data["rigid_motions"], described["interfaces"][0]
    if floating == "auto":
        floating = "first" if first["count"] == 6 and described["method"] in ("craig-bampton", "herting") else "mean"
    if floating == "first":
        if first["count"] != 6:
            raise ValueError(f"the first interface, {first['name']}, has {first['count']} coordinates; expected a frame")
        return data["transformation"][:, 6:]
    if floating == "none":
        return data["transformation"]
    # The complement of the momenta of the rigid motions, by the QR factors of these.
    momenta = data["mass"] @ motions
    complement = np.linalg.qr(momenta, mode="complete")[0][:, 6:]
    return data["transformation"] @ complement


def feminterface(folder=FOLDER, floating="auto"):
    """Nodes, surface, mass, stiffness and mode basis as Exudyn has them."""
    data, described = arrays(folder), description(folder)
    count = 3 * len(data["nodes"])
    rows = data.get("full_dofs")
    if rows is None or len(rows) != count or "rigid_motions" not in data:
        raise ValueError("a floating frame needs a free body without attachments, written with `--format exudyn`")
    matrix = lambda name: csr_matrix(tuple(data[f"full_{name}_{part}"] for part in ("data", "indices", "indptr")))
    fem = FEMinterface()
    fem.metaData["source"] = "vademecum"
    fem.nodes = {"Position": data["nodes"]}
    fem.massMatrix, fem.stiffnessMatrix = matrix("mass"), matrix("stiffness")
    fem.surface = [{"Name": "surface", "Trigs": data["triangles"].astype(int)}]
    starts = data["interface_starts"]
    for place, one in enumerate(described["interfaces"]):
        own = slice(starts[place], starts[place + 1])
        weights = {"NodeNumbers": data["interface_nodes"][own].astype(int), "NodeWeights": data["interface_weights"][own]}
        fem.nodeSets.append({"Name": one["name"], **weights})
    fem.modeBasis = {"matrix": np.ascontiguousarray(mode_basis(data, described, floating)), "type": "HCBmodes"}
    fem.eigenValues = (2 * np.pi * data["frequencies_hz"]) ** 2
    return fem


def interface(name, folder=FOLDER):
    """The nodes of an interface and their weights, as arguments of a marker."""
    data, described = arrays(folder), description(folder)
    names = [one["name"] for one in described["interfaces"]]
    if name not in names:
        raise ValueError(f"no interface {name}; there are {', '.join(names)}")
    first, last = data["interface_starts"][names.index(name):][:2]
    nodes = data["interface_nodes"][first:last].tolist()
    return {"meshNodeNumbers": nodes, "weightingFactors": data["interface_weights"][first:last]}


def floating_body(folder=FOLDER, floating="auto"):
    """The body in a floating frame of reference."""
    return ObjectFFRFreducedOrderInterface(feminterface(folder, floating))
