"""Meshes from arrays, as whatever Python reads them: a deck with the nodes, elements, regions and groups."""

from __future__ import annotations

import os

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Optional, TextIO, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: Kinds of solid elements by the names of meshio, with those of a deck. Nodes are in VTK's order in both, but for
#: `hexahedron27`.
_SOLIDS = {
    "tetra": ("C3D4", 4),
    "tetra10": ("C3D10", 10),
    "pyramid": ("C3D5", 5),
    "pyramid13": ("C3D13", 13),
    "wedge": ("C3D6", 6),
    "wedge15": ("C3D15", 15),
    "hexahedron": ("C3D8", 8),
    "hexahedron20": ("C3D20", 20),
    "hexahedron27": ("C3D27", 27),
}
#: The middle, then the faces of a deck's C3D27, in VTK's order.
_MIDDLES = [26, 24, 25, 22, 21, 23, 20]
#: Integers of cells that other programs keep regions in.
_REGIONS = ("gmsh:physical", "medit:ref", "cell_tags", "nastran:ref", "cell_ids", "region")


def write_mesh(
    path: Union[str, "os.PathLike[str]"],
    points: ArrayLike,
    cells: Union[Mapping[str, ArrayLike], Sequence[tuple[str, ArrayLike]]],
    *,
    cell_sets: Optional[Mapping[str, Sequence[Any]]] = None,
    point_sets: Optional[Mapping[str, ArrayLike]] = None,
) -> Path:
    """Writes a mesh to a file (`.inp`) that `mesh`, `init`, `build` and `vademecum` read.

    `points` are (n, 3). `cells` are blocks of a kind and node numbers from 0, (count, nodes), with the names and the
    orders of nodes of meshio: tetra, tetra10, pyramid, pyramid13, wedge, wedge15, hexahedron, hexahedron20,
    hexahedron27; other kinds are no elements, and name the nodes of their sets. `cell_sets` hold for each name one
    list of places per block, `point_sets` node numbers: sets of solids are regions, all others are groups.
    """
    nodes = np.asarray(points, dtype=float)
    if nodes.ndim != 2 or nodes.shape[1] != 3 or not np.isfinite(nodes).all():
        raise ValueError(f"expected finite points of shape (n, 3), found an array of shape {nodes.shape}")
    given = cells.items() if isinstance(cells, Mapping) else cells
    blocks = [(str(kind), _indices(block, len(nodes), f"a block of {kind}")) for kind, block in given]
    solids = [kind in _SOLIDS for kind, _ in blocks]
    if not any(solids):
        raise ValueError(f"expected blocks of {', '.join(_SOLIDS)}; found {', '.join(kind for kind, _ in blocks) or 'none'}")
    for kind, block in blocks:
        if kind in _SOLIDS and (block.ndim != 2 or block.shape[1] != _SOLIDS[kind][1]):
            raise ValueError(f"expected {_SOLIDS[kind][1]} nodes in each {kind}, found an array of shape {block.shape}")
    regions = [np.zeros(len(block), dtype=int) for _, block in blocks]
    names, groups = ["body"], {}
    for name, places in (cell_sets or {}).items():
        if len(places) != len(blocks):
            raise ValueError(f"cell set {name!r} has {len(places)} lists of places; expected one per block, {len(blocks)}")
        of_faces = []
        for which, (own, (_, block)) in enumerate(zip(places, blocks)):
            chosen = _indices([] if own is None else own, len(block), f"cell set {name!r}")
            if solids[which] and chosen.size:
                if name not in names:
                    names.append(str(name))
                regions[which][chosen] = names.index(str(name))
            else:
                of_faces.append(np.unique(block[chosen]))
        found = np.unique(np.concatenate([np.empty(0, dtype=int), *of_faces]))
        if found.size:
            groups[str(name)] = found
    for name, own in (point_sets or {}).items():
        groups[str(name)] = np.unique(_indices(own, len(nodes), f"point set {name!r}"))
    target = Path(os.fspath(path))
    with target.open("w", encoding="utf-8", newline="\n") as out:
        out.write("** Written by vademecum from arrays.\n*NODE\n")
        _rows(out, np.arange(1, len(nodes) + 1), nodes)
        first = 1
        for (kind, block), own in zip(blocks, regions):
            if kind not in _SOLIDS:
                continue
            rows = block if kind != "hexahedron27" else block[:, [*range(20), *_MIDDLES]]
            for region in np.unique(own):
                chosen = rows[own == region]
                out.write(f"*ELEMENT, TYPE={_SOLIDS[kind][0]}, ELSET={_plain(names[region])}\n")
                for number, element in enumerate((chosen + 1).tolist(), start=first):
                    out.write(",\n".join(_lines([number, *element])) + "\n")
                first += len(chosen)
        for name, found in groups.items():
            if found.size:
                out.write(f"*NSET, NSET={_plain(name)}\n" + ",\n".join(_lines((found + 1).tolist())) + "\n")
    return target


def blocks_of_meshio(mesh: Any) -> tuple[list[tuple[str, Any]], dict[str, list[Any]], dict[str, Any]]:
    """Blocks, sets of cells and sets of points of a mesh of meshio; integers of cells are sets where it has no others."""
    blocks = [(block.type, block.data) for block in mesh.cells]
    sets = {name: list(own) for name, own in getattr(mesh, "cell_sets", {}).items() if not name.startswith("gmsh:")}
    if not sets:
        key = next((key for key in _REGIONS if key in mesh.cell_data), None)
        columns = [np.asarray(column) for column in mesh.cell_data[key]] if key else []
        names = {int(data[0]): name for name, data in getattr(mesh, "field_data", {}).items() if np.size(data) == 2}
        for tag in sorted({int(tag) for column in columns for tag in np.unique(column)}):
            sets[names.get(tag, f"region {tag}")] = [np.flatnonzero(column == tag) for column in columns]
    return blocks, sets, dict(getattr(mesh, "point_sets", {}))


def _indices(given: ArrayLike, count: int, what: str) -> NDArray[np.int64]:
    found = np.asarray(given)
    if found.size and not np.issubdtype(found.dtype, np.integer):
        raise TypeError(f"expected whole numbers in {what}, found {found.dtype}")
    found = found.astype(np.int64)
    if found.size and (found.min() < 0 or found.max() >= count):
        raise ValueError(f"expected numbers from 0 to {count - 1} in {what}, found {found.min()} to {found.max()}")
    return found


def _rows(out: TextIO, numbers: NDArray[np.int64], points: NDArray[np.float64]) -> None:
    for number, (x, y, z) in zip(numbers.tolist(), points.tolist()):
        out.write(f"{number}, {x!r}, {y!r}, {z!r}\n")


def _lines(numbers: Iterable[int]) -> list[str]:
    row = [str(number) for number in numbers]
    return [", ".join(row[at : at + 16]) for at in range(0, len(row), 16)]


def _plain(name: str) -> str:
    """A name that a deck can have."""
    return "".join("_" if letter in ",\n\r\"'=*" else letter for letter in name.strip()) or "unnamed"
