"""Parametric models: sensitivities, histories with derivatives, and tracking."""

import numpy as np
import pytest

import vademecum

from conftest import BEAM

VALUES = {"root": 0.8, "outer": 1.3, "beta": 8e-5}
POINT, FORCE = [1.0, 0.05, 0.1], [0.0, 1.0, -2.0]


def pair(name, kind, low, high, **more):
    return {"name": name, "kind": kind, "range": [low, high], "scale": "log", **more}


@pytest.fixture(scope="module")
def file():
    return vademecum.build(
        {
            **BEAM,
            "representation": "parametric",
            "mesh": {
                "block": {"lengths": [1.0, 0.1, 0.12], "divisions": [6, 1, 1]},
                "region": [{"name": "tip", "on": {"fraction": {"axis": "x", "side": "max", "fraction": 0.5}}}],
            },
            "basis": {"modes": 16},
            "parameter": [
                pair("root", "stiffness", 0.5, 2.0, region="body"),
                pair("outer", "stiffness", 0.5, 2.0, region="tip"),
                pair("beta", "beta", 1e-5, 2e-4),
            ],
        }
    )


def difference(of, name, values=VALUES, change=1e-3):
    """Richardson's extrapolation of central differences."""

    def central(step):
        above, below = ({**values, name: values[name] * (1 + sign * step)} for sign in (1, -1))
        return (of(above) - of(below)) / (2 * step * values[name])

    return (4 * central(change / 2) - central(change)) / 3


def test_frequencies_have_their_derivatives(file):
    found = file.sensitivities(8, **VALUES)
    assert found.values.shape == (8,) and (np.diff(found.values) > 0.0).all()
    assert list(found.slopes) == ["root", "outer", "beta"] and not found.slopes["beta"].any()
    for name in ("root", "outer"):
        expected = difference(lambda values: file.sensitivities(8, **values).values, name)
        assert found.slopes[name] == pytest.approx(expected, rel=1e-6, abs=1e-6 * found.values[0])
    total = sum(VALUES[name] * found.slopes[name] for name in ("root", "outer"))
    assert total == pytest.approx(found.values / 2), "a frequency is the root of the stiffness"
    assert file.sensitivities().values[0] != found.values[0]


def test_histories_have_their_derivatives(file):
    amplitudes = np.sin(0.4 * np.arange(81))[:, None] * [3.0, 1.0]
    loads = [(POINT, FORCE), "gravity"]
    found = file.tangents(loads, amplitudes, parameters=VALUES, field="velocity")
    assert found.values.shape == (81, 2) and not found.values[0].any()
    for name in VALUES:
        expected = difference(
            lambda values: file.tangents(loads, amplitudes, parameters=values, field="velocity").values, name
        )
        assert np.abs(found.slopes[name] - expected).max() < 1e-6 * np.abs(expected).max(), name


def test_a_stiffness_is_tracked_from_noisy_sensors(file):
    random = np.random.default_rng(3)
    amplitudes = 10.0 * random.normal(size=(3001, 1))
    amplitudes[0] = 0.0
    loads = [(file.body().locate(POINT), FORCE)]
    truth = {**VALUES, "outer": 1.0, "root": 0.9}
    clean = file.tangents(loads, amplitudes, parameters=truth, field="velocity", modes=16).values
    noise = 0.02 * np.sqrt((clean**2).mean(axis=0))
    measured = clean + noise * random.normal(size=clean.shape)
    tracker = file.tracker(
        dict(zip(["tip", "side"], noise)),
        {"root": (0.2, 0.0), "outer": (0.2, 0.0)},
        loads,
        field="velocity",
        modes=16,
        parameters=VALUES,
    )
    assert tracker.estimates == {"root": 0.8, "outer": 1.3} and tracker.take_consistency() is None
    for amplitude, row in zip(amplitudes[1:], measured[1:]):
        tracker.step(amplitude, row)
    for name, value in tracker.estimates.items():
        assert value == pytest.approx(truth[name], rel=0.01), tracker.estimates
        assert 0.0 < tracker.deviations[name] < 0.01
    assert 0.9 < tracker.take_consistency() < 1.1
    assert repr(tracker) == "<Tracker of `root`, `outer` from 2 sensors and 1 loads>"
    before = tracker.estimates
    tracker.step([0.0], [np.nan, np.nan])
    assert tracker.estimates == before, "nothing was measured"


def test_what_cannot_be_used_is_refused(file, beam):
    sensors, tracked = {"tip": 1e-3}, {"root": (0.1, 0.0)}
    tracker = file.tracker(sensors, tracked)
    refused = [
        (lambda: file.sensitivities(rot=1.0), ValueError, "no live parameter `rot`.*`root`, `outer`, `beta`"),
        (lambda: file.sensitivities(root=9.0), vademecum.InputError, "`root` is 9; expected a value from 0.5 to 2"),
        (lambda: file.sensitivities(99), ValueError, "99 stepped modes; expected 1 to"),
        (lambda: beam.sensitivities(), vademecum.FileError, "parametric"),
        (lambda: file.tangents(["gravit"], [[0.0]]), ValueError, "no load pattern `gravit`"),
        (lambda: file.tangents(["gravity"], [[0.0, 1.0]]), ValueError, r"shape \(instants, 1\), found \(1, 2\)"),
        (lambda: file.tracker({"tap": 1.0}, tracked), ValueError, "no probe `tap`"),
        (lambda: file.tracker({"tip": -1.0}, tracked), ValueError, "expected a finite number from 0"),
        (lambda: file.tracker(sensors, {"rot": (0.1, 0.0)}), ValueError, "no live parameter `rot`"),
        (lambda: tracker.step([], [1.0, 2.0]), ValueError, "expected 1 measured numbers.*found 2"),
        (lambda: tracker.step([1.0], [1.0]), ValueError, "expected 0 amplitudes.*found 1"),
    ]
    for call, error, words in refused:
        with pytest.raises(error, match=words):
            call()
