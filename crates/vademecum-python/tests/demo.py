"""The demo's file through the package and through the program: `python demo.py DEMO`, where DEMO is the folder that
`vademecum demo -o DEMO` has written. Needs NumPy and the wheel alone.
"""

import csv
import subprocess
import sys
from pathlib import Path

import numpy as np

import vademecum

demo = Path(sys.argv[1])
program = Path(sys.executable).with_name("vademecum")
path = demo / "demo.vdm"


def by_the_program(scenario: Path) -> dict[str, list[float]]:
    out = demo / scenario.stem
    subprocess.run([program, "--quiet", "run", path, "--scenario", scenario, "-o", out], check=True, stdout=subprocess.DEVNULL)
    with (out / "probes.csv").open() as table:
        rows = list(csv.reader(table))
    names = [name.split(" [")[0] for name in rows[0]]
    return {name: [float(row[column]) for row in rows[1:]] for column, name in enumerate(names)}


def printed(values: np.ndarray) -> list[float]:
    """As the program prints them."""
    return [float(f"{value:.9e}") for value in values]


file = vademecum.open(path)

# The demo's own scenario.
theirs = by_the_program(demo / "scenario.toml")
ours = file.run(demo / "scenario.toml")
assert len(ours.time) == 2001 and abs(ours.probes["tip"]).max() > 1e-4
assert printed(ours.time) == theirs["time_s"] and printed(ours.energy) == theirs["energy_J"]
assert printed(ours.probes["tip"]) == theirs["tip"]

# A finger that presses, lets go and presses elsewhere: step by step in a body.
taps = demo / "taps.toml"
taps.write_text(
    "duration = 0.6\n"
    "[[contact]]\npoint = [0.93, 0.031, 0.1]\nforce = [3.0, -8.0, -20.0]\nend = 0.2\n"
    "[[contact]]\npoint = [0.47, 0.06, 0.1]\nforce = [0.0, 5.0, -10.0]\nstart = 0.4\nend = 0.6\n"
    '[[pattern]]\nname = "gravity"\nstart = 0.0\n'
)
theirs = by_the_program(taps)
body = file.body()
stepped = []
for point, force in (([0.93, 0.031, 0.1], [3.0, -8.0, -20.0]), (None, None), ([0.47, 0.06, 0.1], [0.0, 5.0, -10.0])):
    body.clear()
    if point:
        body.push(point, force)
    body.push_pattern("gravity")
    for _ in range(200):
        body.step()
        stepped.append(body.probe("tip"))
assert printed(np.array(stepped)) == theirs["tip"][1:]

single = file.body(dtype=np.float32)
single.push([0.93, 0.031, 0.1], [3.0, -8.0, -20.0])
single.push_pattern("gravity")
near = single.march(200)[:, 0]
assert abs(near - stepped[:200]).max() < 1e-4 * abs(near).max()
print(f"2001 + 600 rows of {path} have the digits of `vademecum run`")
