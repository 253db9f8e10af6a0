"""Bodies that the tests move; built once."""

import subprocess
import sys
from pathlib import Path

import pytest

import vademecum

BEAM = {
    "title": "a short beam",
    "mesh": {"block": {"lengths": [1.0, 0.1, 0.1], "divisions": [6, 1, 1]}},
    "material": [{"young": 2e9, "poisson": 0.3, "density": 1200.0}],
    "damping": {"beta": 5e-5},
    "support": [{"on": {"group": "x_min"}}],
    "load": {"surface": {"group": "z_max"}, "pattern": [{"name": "gravity", "acceleration": [0, 0, -9.81]}]},
    "time": {"step": 1e-3},
    "basis": {"modes": 6},
    "output": {
        "probe": [
            {"name": "tip", "point": [1.0, 0.05, 0.1], "direction": [0, 0, 1]},
            {"name": "side", "point": [0.5, 0.1, 0.05], "direction": [0, 1, 0]},
        ]
    },
}

PUSH = {
    "duration": 0.5,
    "contact": [{"point": [0.93, 0.031, 0.1], "force": [3.0, -8.0, -20.0], "end": 0.1}],
    "pattern": [{"name": "gravity", "start": 0.2}],
}


def live(**changes):
    """The beam with live stiffness and damping."""
    parameters = [
        {"name": "tip stiffness", "kind": "stiffness", "range": [0.5, 2.0], "scale": "log"},
        {"name": "damping", "kind": "beta", "range": [1e-5, 1e-4], "scale": "log"},
    ]
    return {**BEAM, "parameter": parameters, **changes}


@pytest.fixture(scope="session")
def beam():
    return vademecum.build(BEAM)


@pytest.fixture(scope="session")
def live_beam():
    return vademecum.build(live())


@pytest.fixture(scope="session")
def block_beam():
    """The beam with the block structure: a live stiffness of one of its two regions."""
    problem = live(
        time={"step": 1e-3, "scheme": {"name": "bathe"}},
        mesh={
            **BEAM["mesh"],
            "region": [{"name": "outer", "on": {"fraction": {"axis": "x", "side": "max", "fraction": 0.5}}}],
        },
        parameter=[{"name": "outer", "kind": "stiffness", "region": "outer", "range": [0.8, 1.25], "scale": "log"}],
        snapshots={"positions": 2, "directions": [[0.0, 0.0, 1.0]]},
        tolerance={"floor_ratio": 2.0, "absolute": 1e-4, "steps": 100, "map": 1e-4, "max_terms": 40},
    )
    return vademecum.build(problem, keep_missed=True)


@pytest.fixture(scope="session")
def program():
    """Runs the program that the wheel installs."""
    path = Path(sys.executable).with_name("vademecum")

    def run(*arguments):
        done = subprocess.run([path, *map(str, arguments)], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


@pytest.fixture(scope="session")
def regions():
    """A body of 3 vectors with two live regions: stiffness of both, density of one, and beta."""
    return vademecum.open(Path(__file__).parents[3] / "fixtures/golden/parametric.vdm")
