"""Reads the collection that `vademecum run` wrote, with meshio, and prints what it holds as JSON."""

import json
import pathlib
import sys
import xml.etree.ElementTree

import meshio

collection = pathlib.Path(sys.argv[1])
point = [float(x) for x in sys.argv[2:5]]
entries = []
for entry in xml.etree.ElementTree.parse(collection).iter("DataSet"):
    mesh = meshio.read(collection.parent / entry.get("file"))
    squared = ((mesh.points - point) ** 2).sum(axis=1)
    nearest = int(squared.argmin())
    entries.append(
        {
            "time": float(entry.get("timestep")),
            "points": len(mesh.points),
            "cells": {block.type: len(block.data) for block in mesh.cells},
            "distance": float(squared[nearest] ** 0.5),
            **{name: [float(x) for x in data[nearest]] for name, data in mesh.point_data.items()},
        }
    )
json.dump(entries, sys.stdout)
