"""The runtime of fmucontainer, which steps an FMU inside of another one: container.py CONTAINER.FMU FMU, of FMI 3, with arrays of a
fixed number of rows. What comes out of the container is what comes out of the FMU alone."""

import sys

import numpy
from fmpy import read_model_description, simulate_fmu

container, alone = sys.argv[1:]
nodes = {v.name: v for v in read_model_description(alone).modelVariables}["surface_force"].shape[0]
load = numpy.zeros(2, dtype=[("time", "f8"), ("surface_force", "f8", (nodes, 3))])
load["time"] = [0.0, 0.2]
load["surface_force"][:, :, 2] = -numpy.arange(1.0, nodes + 1.0)
shown = ["surface_displacement"]
# The description of the container writes start values of arrays in an element that the schema does not have.
options = dict(validate=False, input=load, stop_time=0.2, step_size=1e-3, output_interval=1e-3, output=shown)
inside, outside = (simulate_fmu(fmu, **options)[shown[0]] for fmu in (container, alone))
assert inside.shape == outside.shape == (201, nodes, 3), (inside.shape, outside.shape)
assert numpy.abs(outside).max() > 0.0 and numpy.array_equal(inside, outside), numpy.abs(inside - outside).max()
print(f"fmucontainer: 201 rows of {nodes} nodes as alone, bit for bit")
