"""What a call costs: `python cost.py FILE`. The loop of `step(100000)` is in Rust: that is the step itself."""

import sys
import timeit

import numpy as np

import vademecum

body = vademecum.open(sys.argv[1])
info = body.info
print(f"{info.modes} modes, {info.nodes} nodes, {info.surface_nodes} on the surface, {len(info.probes)} probes\n")
print(f"{'':44}{'float32':>12}{'float64':>12}")

rows: dict[str, list[float]] = {}
for dtype in (np.float32, np.float64):
    scene = body.scene(dtype=dtype)
    place = scene.contact(body.nodes[0], [0.0, 0.0, -1.0])
    scene.step(1000)
    surface, nodes, probes = scene.surface(), scene.body(), scene.probes()
    name = scene.probe_names[0]
    batch = body.batch(1000, dtype=dtype)
    for instance in range(1000):
        batch.pattern(instance, scene.pattern_names[0])

    def reload() -> None:
        scene.clear()
        scene.contact(place, [0.0, 0.0, -1.0])

    calls = [
        ("step(100000), for each step", lambda: scene.step(100_000), 100_000),
        ("step()", scene.step, 1),
        ("clear() and contact(place, force)", reload, 1),
        ("probe(name)", lambda: scene.probe(name), 1),
        ("probes(out=array)", lambda: scene.probes(out=probes), 1),
        ("march(1000), for each step and its probes", lambda: scene.march(1000), 1000),
        ("surface(out=array)", lambda: scene.surface(out=surface), 1),
        ("surface()", scene.surface, 1),
        ("body(out=array)", lambda: scene.body(out=nodes), 1),
        ("save(out=array)", lambda saved=scene.save(): scene.save(out=saved), 1),
        ("Batch of 1000: step(), for each body", batch.step, 1000),
    ]
    for label, call, parts in calls:
        timer = timeit.Timer(call)
        number, _ = timer.autorange()
        rows.setdefault(label, []).append(min(timer.repeat(5, number // 8 or 1)) / (number // 8 or 1) / parts)

for label, times in rows.items():
    print(f"{label:44}" + "".join(f"{1e9 * seconds:9.0f} ns" for seconds in times))
