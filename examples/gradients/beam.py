"""The body of both programs: a cantilever of two regions of live stiffness, pushed at its tip."""

import numpy as np

import vademecum

STEPS = 300
#: A force of amplitude 1 at the tip.
LOADS = [([1.0, 0.05, 0.12], [0.0, 0.3, -1.0])]
NAMES = ["root", "outer", "beta"]
#: The ranges that the file is built for, and what a measured body was like.
LOWER, UPPER, TRUE = [0.5, 0.5, 1e-5], [2.0, 2.0, 2e-4], [0.82, 1.27, 7e-5]


def build():
    """The file: a beam with live stiffness of its halves, and live damping."""

    def live(name, kind, **more):
        place = NAMES.index(name)
        return {"name": name, "kind": kind, "range": [LOWER[place], UPPER[place]], "scale": "log", **more}

    return vademecum.build(
        {
            "representation": "parametric",
            "mesh": {
                "block": {"lengths": [1.0, 0.1, 0.12], "divisions": [6, 1, 1]},
                "region": [{"name": "tip", "on": {"fraction": {"axis": "x", "side": "max", "fraction": 0.5}}}],
            },
            "material": [{"young": 2e9, "poisson": 0.3, "density": 1200.0}],
            "damping": {"beta": 5e-5},
            "support": [{"on": {"group": "x_min"}}],
            "load": {"surface": {"group": "z_max"}},
            "time": {"step": 1e-3},
            "basis": {"modes": 16},
            "output": {
                "probe": [
                    {"name": "tip", "point": [1.0, 0.05, 0.12], "direction": [0, 0, 1]},
                    {"name": "side", "point": [0.5, 0.1, 0.06], "direction": [0, 1, 0]},
                ]
            },
            "parameter": [
                live("root", "stiffness", region="body"),
                live("outer", "stiffness", region="tip"),
                live("beta", "beta"),
            ],
        }
    )


def tap():
    """Amplitudes of a tap of 20 N, a row for each instant."""
    t = np.arange(STEPS + 1)
    return np.where(t < 12, 20.0 * np.sin(np.pi * t / 12) ** 2, 0.0)[:, None]


def measured(file):
    """Probes of the true body after each step, with 1 % noise, and the deviation of each."""
    clean = file.vjp(LOADS, tap(), parameters=dict(zip(NAMES, TRUE))).values
    deviation = 0.01 * np.sqrt((clean**2).mean(axis=0))
    return clean + deviation * np.random.default_rng(1).normal(size=clean.shape), deviation


def moved(file):
    """Goal of the control: the tip 1 mm down, and at rest there, in the last third."""
    target = np.zeros((STEPS, 2))
    target[2 * STEPS // 3 :, 0] = -1e-3
    return target


def report(what, found):
    """Prints estimates, and ends the program unless they are those of the true body."""
    print(f"{what}: " + ", ".join(f"{name} {value:.4g}" for name, value in zip(NAMES, found)))
    off = max(abs(value / true - 1.0) for value, true in zip(found, TRUE))
    # Noise of 1 % in 600 numbers.
    assert off < 0.02, f"{off:.1%} off"


def reached(what, values):
    """Prints how the tip moves in the last third, and ends the program unless it stays where it should."""
    tip = values[2 * STEPS // 3 :, 0]
    print(f"{what}: the tip stays between {1e3 * tip.min():.3f} mm and {1e3 * tip.max():.3f} mm")
    assert np.abs(tip + 1e-3).max() < 2e-5
