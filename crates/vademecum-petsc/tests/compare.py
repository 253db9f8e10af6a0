"""Compares a file built on ranks with one built in one process: frequencies and trajectories.

compare.py LOCAL.json LOCAL.csv RANKS.json RANKS.csv: what `info --json` prints, and `probes.csv` of a run.
"""

import csv
import json
import sys

FREQUENCIES = 1e-9
TRAJECTORIES = 1e-8


def frequencies(path):
    with open(path) as file:
        return [row["frequency_hz"] for row in json.load(file)["mode_table"]]


def columns(path):
    with open(path) as file:
        rows = list(csv.reader(file))
    return rows[0], [[float(x) for x in column] for column in zip(*rows[1:])]


local, ranks = frequencies(sys.argv[1]), frequencies(sys.argv[3])
assert local and len(local) == len(ranks), (len(local), len(ranks))
frequency = max(abs(a - b) / a for a, b in zip(local, ranks))
(names, local), (others, ranks) = columns(sys.argv[2]), columns(sys.argv[4])
assert names == others and len(names) > 1 and len(local[0]) > 100, (names, others)
trajectory = 0.0
for name, a, b in zip(names, local, ranks):
    assert len(a) == len(b), name
    size = max(abs(x) for x in a)
    assert size > 0.0, f"{name} does not move"
    trajectory = max(trajectory, max(abs(x - y) for x, y in zip(a, b)) / size)
print(f"frequencies {frequency:.1e} of {FREQUENCIES:.0e}, trajectories {trajectory:.1e} of {TRAJECTORIES:.0e}")
sys.exit(not (frequency <= FREQUENCIES and trajectory <= TRAJECTORIES))
