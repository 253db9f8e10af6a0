"""What a call costs: `python cost.py FILE`. The loop of `step(100000)` is in Rust: that is the step itself."""

import sys
import timeit

import numpy as np

import vademecum

file = vademecum.open(sys.argv[1])
info = file.info
print(f"{info.modes} modes, {info.nodes} nodes, {info.surface_nodes} on the surface, {len(info.probes)} probes\n")
print(f"{'':44}{'float32':>12}{'float64':>12}")

rows: dict[str, list[float]] = {}
for dtype in (np.float32, np.float64):
    body = file.body(dtype=dtype)
    place = body.push(file.nodes[0], [0.0, 0.0, -1.0])
    body.step(1000)
    surface, nodes, probes = body.surface(), body.whole(), body.probes()
    name = body.probe_names[0]
    batch = file.batch(1000, dtype=dtype)
    for instance in range(1000):
        batch.push_pattern(instance, body.pattern_names[0])

    def reload() -> None:
        body.clear()
        body.push(place, [0.0, 0.0, -1.0])

    calls = [
        ("step(100000), for each step", lambda: body.step(100_000), 100_000),
        ("step()", body.step, 1),
        ("clear() and push(place, force)", reload, 1),
        ("probe(name)", lambda: body.probe(name), 1),
        ("probes(out=array)", lambda: body.probes(out=probes), 1),
        ("march(1000), for each step and its probes", lambda: body.march(1000), 1000),
        ("surface(out=array)", lambda: body.surface(out=surface), 1),
        ("surface()", body.surface, 1),
        ("whole(out=array)", lambda: body.whole(out=nodes), 1),
        ("save()", body.save, 1),
        ("Batch of 1000: step(), for each body", batch.step, 1000),
    ]
    for label, call, parts in calls:
        timer = timeit.Timer(call)
        number, _ = timer.autorange()
        rows.setdefault(label, []).append(min(timer.repeat(5, number // 8 or 1)) / (number // 8 or 1) / parts)

for label, times in rows.items():
    print(f"{label:44}" + "".join(f"{1e9 * seconds:9.0f} ns" for seconds in times))
