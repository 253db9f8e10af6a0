"""Compares the reader with the evaluator: `agree.py TRAJECTORIES`, lines of JSON by `trajectory.rs`.

Prints the largest difference per file and structure, relative to the largest number of each kind over the
march, and fails above the bound.
"""

import json
import sys

import numpy as np

import step
import vademecum

# Both sides compute in binary64 (2^-53 = 1.1e-16) but in another order, and a march of 240 steps adds that
# up.
BOUND = 1e-12
# The state of the canonical structure is measured by the reach of its axes: a coordinate's place on its axis
# is rounded by a share of that, however small the coordinate is. Each step so receives a kick of velocity,
# and what n kicks move grows with n².
KICK = 2.0**-53


def bound_of(structure, steps):
    return max(BOUND, KICK * steps**2) if structure == "canonical" else BOUND


class Disagreement(Exception):
    """Not a number that is off, but another answer."""


def scenes_of(case, file):
    """The scene of the first half of the march, and that of the second half."""
    structure = step.STRUCTURES[case["structure"]]
    settings = [(setting.get("parameters"), setting.get("scales")) for setting in case["settings"]]
    return [structure(file, *setting) for setting in (settings[0], settings[-1])]


def need(condition, what):
    if not condition:
        raise Disagreement(f"the reader disagrees about the {what}")


def reduced(scene, load):
    """What the step takes of a load, and `BᵀF`."""
    if "pattern" in load:
        return scene.load_of_pattern(load["pattern"]), scene.pattern(load["pattern"])
    push = load["nodes"], load["weights"], load["force"]
    return scene.load_of_contact(*push), scene.contact(*push)


def march(case, scenes):
    """The states of the reader's own march."""
    half = case["steps"] // 2
    scene, loads = scenes[0], [reduced(scenes[0], load) for load in case["loads"]]
    need(scene.instants == case["instants"][: len(scene.instants)], "instants of the scheme")
    amplitudes = [load["amplitudes"] for load in case["loads"]]
    force = sum((p[0][0] * plain for (_, plain), p in zip(loads, amplitudes) if p[0]), np.zeros(scene.r))
    y = scene.start(*(np.array(part) for part in case["start"]), force)
    for index in range(case["steps"]):
        if index == half:
            y, scene = scenes[1].carry(scene, y), scenes[1]
            loads = [reduced(scene, load) for load in case["loads"]]
        acting = [(load, p[index]) for (load, _), p in zip(loads, amplitudes) if p[index]]
        try:
            y = scene.step(y, acting)
        except vademecum.Refused as refused:
            need(index == len(case["rows"]), f"step that is refused: {index}, {refused}")
            return
        yield y
    need(len(case["rows"]) == case["steps"], f"end of a march, after {len(case['rows'])} steps")


def acting_at_end(case, scene, index):
    """The loads of a step, each with its amplitude at the last instant of the step."""
    last = len(scene.instants) - 1
    acting = ((load, load["amplitudes"][index]) for load in case["loads"])
    return [(load, amplitudes[last]) for load, amplitudes in acting if amplitudes]


def acting_at_start(case, index):
    acting = ((load, load["amplitudes"][index]) for load in case["loads"])
    return [(load, amplitudes[0]) for load, amplitudes in acting if amplitudes]


def filters(case, scenes):
    """Filtered forces after each step, that the residual answers."""
    half, scene = case["steps"] // 2, scenes[0]
    if np.any(case["start"]):
        scene.settle(acting_at_end(case, scene, 0))
    for index in range(len(case["rows"])):
        if index == half and scenes[1] is not scene:
            scenes[1].carry(scene, np.zeros(1))
            scene = scenes[1]
        scene.follow(acting_at_start(case, index), acting_at_end(case, scene, index))
        yield scene.filtered


def outputs(case, scene, y, index, filtered):
    pushes, scene.filtered = acting_at_end(case, scene, index), filtered
    return {
        "probes": scene.probes(y[0], pushes),
        "probe velocity": scene.probes(y[1] / scene.v.dt),
        "nodes": [scene.displacement(y, node, pushes) for node in case["nodes"]],
        "energy": [scene.energy(y, pushes)],
        "reactions": scene.reactions(y, pushes),
        "stress": scene.tensors(y[0], pushes)[:, :6],
        "strain": scene.tensors(y[0], pushes)[:, 6:],
    }


def relative(ours, theirs, scale=None):
    """The largest difference, relative to the largest number."""
    need(ours.shape == theirs.shape, "number of values")
    largest = scale or np.abs(theirs).max()
    return np.abs(ours - theirs).max() / (largest or 1.0)


def differences(case, file):
    """The largest difference of each kind."""
    if "refused" in case["rows"]:
        name = file.meta["axes"][case["rows"]["refused"]]["name"]
        try:
            scenes_of(case, file)
        except vademecum.Refused as refused:
            need(str(refused) == f"outside the axis {name}", f"refusal of {case['settings']}: {refused}")
            return {"refusals": 0.0}
        need(False, f"refusal of {case['settings']}, outside the axis {name}")
    scenes, rows, half = scenes_of(case, file), case["rows"], case["steps"] // 2
    need(len(rows) > 0, "march: it has no step")
    states, given = np.array(list(march(case, scenes))), np.array([row["state"] for row in rows])
    found = {}
    for place, kind in enumerate(("zeta", "velocity", "acceleration")[: given.shape[1]]):
        scale = scenes[0].reach(place) if case["structure"] == "canonical" else None
        found[kind] = relative(states[:, place], given[:, place], scale)
    # Of the evaluator's own states, so that this is about the outputs alone.
    filtered = list(filters(case, scenes))
    read = [outputs(case, scenes[index >= half], y, index, filtered[index]) for index, y in enumerate(given)]
    told = [{"probes": row["probes"][0], "probe velocity": row["probes"][1], "nodes": row["nodes"],
             "energy": [row["energy"]], "reactions": row["reactions"], "stress": row["stress"],
             "strain": row["strain"]} for row in rows]
    for kind in read[0]:
        ours, theirs = (np.array([np.ravel(row[kind]) for row in side]) for side in (read, told))
        if theirs.size:
            found[kind] = relative(ours, theirs)
    return found


def compare(path):
    """Prints the largest difference per file and structure; whether all keep their bounds."""
    worst, marches, kept = {}, {}, True
    with open(path, encoding="utf-8") as lines:
        for line in lines:
            case = json.loads(line)
            key = case["file"], case["structure"]
            found = differences(case, vademecum.read(case["file"]))
            marches[key] = marches.get(key, 0) + 1
            kind = max(found, key=lambda kind: np.inf if np.isnan(found[kind]) else found[kind])
            if key not in worst or not found[kind] <= worst[key][0]:
                worst[key] = found[kind], kind
            # A number that is none keeps no bound.
            kept = kept and found[kind] <= bound_of(case["structure"], case["steps"])
    for (file, structure), (difference, kind) in worst.items():
        name = file.rsplit("/", 1)[-1]
        print(f"{name:34} {structure:10} {marches[file, structure]:3} marches  {difference:.1e}  {kind}")
    return kept and bool(worst)


if __name__ == "__main__":
    sys.exit(0 if compare(sys.argv[1]) else 1)
