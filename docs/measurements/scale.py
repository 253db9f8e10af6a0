#!/usr/bin/env python3
"""Builds blocks of growing size and prints a table of time, memory and traffic, one row for each.

    docs/measurements/scale.py [--traffic] WORK CELLS[:RANKS[:SCRATCH]] ...

WORK is a folder for problems and files. CELLS are those of an edge of the cross-section; the block is four times as long. Without
RANKS the build is one process; with RANKS it is `mpirun` with the engine petsc, whose factor lies in SCRATCH if that is given. Wants
an idle machine, the program at target/release/vademecum (with the feature petsc for RANKS) and /usr/bin/time. With --traffic it
counts what ranks send, by an Open MPI with its monitoring component, which makes builds slower.
"""

import json
import os
import re
import subprocess
import sys

PROBLEM = """[mesh]
block = {{ lengths = [4.0, 1.0, 1.0], divisions = [{long}, {cells}, {cells}], order = "quadratic" }}
[[material]]
young = 2.1e9
poisson = 0.3
density = 1200.0
[damping]
ratio = 0.02
[[support]]
on = {{ group = "x_min" }}
[load]
surface = {{ box = {{ min = [{x0}, {y0}, 0.999], max = [{x1}, {y1}, 1.001] }} }}
[basis]
kind = "modes"
modes = 32
[time]
step = 1e-3
"""
# Half the loadable patch, in spacings of nodes, around a corner of cells: 17 by 13 nodes.
HALF_ALONG, HALF_ACROSS = 8.75, 6.75
STAGES = ["first natural mode", "snapshots and basis", "residual flexibility", "certificate"]


def problem(work, cells, long):
    """A file of the problem whose loadable patch lies near x = 3 on the upper side."""
    across, along = 0.5 / cells, 2.0 / long
    x, y = 3.0 - 3.0 % (2.0 * along), 0.5
    text = PROBLEM.format(
        long=long,
        cells=cells,
        x0=x - HALF_ALONG * along,
        x1=x + HALF_ALONG * along,
        y0=y - HALF_ACROSS * across,
        y1=y + HALF_ACROSS * across,
    )
    path = os.path.join(work, f"block-{cells}.toml")
    with open(path, "w") as file:
        file.write(text)
    return path


def traffic(prefix):
    """Bytes that all ranks sent, from the files of Open MPI's monitoring."""
    sent = 0
    for name in os.listdir(os.path.dirname(prefix)):
        if name.startswith(os.path.basename(prefix)):
            with open(os.path.join(os.path.dirname(prefix), name)) as file:
                for line in file:
                    # Messages of the user's and of the collective operations alike; "I" and "E" are parts of them.
                    found = re.match(r"[EI]\s+\d+\s+\d+\s+(\d+) bytes", line)
                    sent += int(found.group(1)) if found else 0
    return sent


def build(work, cells, ranks, scratch, counts):
    # Four times as long, of cells that are nearly cubes.
    long = {22: 86}.get(cells, 4 * cells)
    path, out = problem(work, cells, long), os.path.join(work, f"block-{cells}.vdm")
    command = ["target/release/vademecum", "--quiet", "build", path, "-o", out, "--json", "--fresh", "--keep-missed", "--long"]
    # Of every rank its own memory.
    command = ["/usr/bin/time", "-f", "RANK %M"] + command
    monitored = os.path.join(work, f"traffic-{cells}-{ranks}")
    environment = dict(os.environ)
    if ranks:
        environment.update(OPENBLAS_NUM_THREADS="1", OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
        monitor = {"enable": 1, "enable_output": 3, "filename": monitored}
        options = [word for key, value in monitor.items() for word in ("--mca", f"pml_monitoring_{key}", str(value)) if counts]
        # Ranks that share a core yield it while they wait, which costs time where they have one each.
        options += ["--oversubscribe"] if ranks > os.cpu_count() else []
        command = ["mpirun", "-n", str(ranks)] + options + command + ["--engine", "petsc"]
        command += ["--out-of-core", scratch] if scratch else []
    done = subprocess.run(["/usr/bin/time", "-f", "WALL %e"] + command, capture_output=True, text=True, env=environment)
    if done.returncode:
        sys.exit(f"{' '.join(command)}\n{done.stderr}")
    report = json.loads(done.stdout)
    seconds = {timing["stage"]: timing["seconds"] for timing in report["timings"]}
    memory = [int(rank) / 1e6 for rank in re.findall(r"RANK (\d+)", done.stderr)]
    wall = float(re.findall(r"WALL ([\d.]+)", done.stderr)[-1])
    cells_of_row = [
        f"{report['dofs']}",
        f"{ranks} ranks" + (", factor on disk" if scratch else "") if ranks else "one process",
        f"{wall:.0f}",
        *(f"{seconds.get(stage, 0.0):.1f}" for stage in STAGES),
        " + ".join(f"{rank:.2f}" for rank in memory),
        f"{os.path.getsize(out) / 1e6:.1f}",
        f"{traffic(monitored) / 1e9:.2f}" if ranks and counts else "",
    ]
    print("| " + " | ".join(cells_of_row) + " |", flush=True)


def main():
    counts = "--traffic" in sys.argv
    words = [word for word in sys.argv[1:] if word != "--traffic"]
    if len(words) < 2:
        sys.exit(__doc__)
    work = words[0]
    os.makedirs(work, exist_ok=True)
    names = ["dofs", "engine", "all, s", *(f"{stage}, s" for stage in STAGES), "memory, GB", "file, MB", "sent, GB"]
    print("| " + " | ".join(names) + " |\n|" + "---|" * len(names))
    for size in words[1:]:
        cells, ranks, scratch = (size.split(":") + ["", ""])[:3]
        build(work, int(cells), int(ranks or 0), scratch, counts)


main()
