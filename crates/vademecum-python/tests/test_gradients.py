"""Gradients of kept marches and of bodies, against differences of marches."""

import numpy as np
import pytest

import vademecum

from conftest import BEAM
from test_live import FORCE, POINT, VALUES, file  # noqa: F401

STEPS = 60
LOADS = [(POINT, FORCE), "gravity"]


def weights(shape, seed=3):
    return np.random.default_rng(seed).normal(size=shape)


def central(of, at, change):
    """Richardson's extrapolation of central differences."""
    near, far = ((of(at + h) - of(at - h)) / (2 * h) for h in (change / 2, change))
    return (4 * near - far) / 3


@pytest.mark.parametrize("field", ["displacement", "velocity"])
@pytest.mark.parametrize("held", [False, True])
def test_a_kept_march_of_live_regions_has_its_gradient(file, field, held):  # noqa: F811
    amplitudes = weights((STEPS + (not held), 2), 1)
    start = (1e-5 * weights(16, 4), 1e-3 * weights(16, 5))
    options = {"held": held, "field": field, "start": start}
    kept = file.vjp(LOADS, amplitudes, parameters=VALUES, **options)
    assert kept.values.shape == (STEPS, 2)
    own = weights(kept.values.shape)

    def scalar(amplitudes=amplitudes, parameters=VALUES, loads=LOADS, start=start):
        kept = file.vjp(loads, amplitudes, parameters=parameters, **{**options, "start": start})
        return (own * kept.values).sum()

    found = kept.gradient(own)
    assert found.amplitudes.shape == amplitudes.shape and list(found.parameters) == list(VALUES)
    for step, load in [(0, 0), (0, 1), (7, 1), (STEPS - 1, 0)]:
        changed = amplitudes.copy()
        changed[step, load] += 1.0
        assert found.amplitudes[step, load] == pytest.approx(scalar(changed) - scalar(), rel=1e-9)
    size = max(abs(slope * VALUES[name]) for name, slope in found.parameters.items())
    for name, slope in found.parameters.items():
        # Coordinates at the start are those of the modes at these values, so they start from rest.
        rest = file.vjp(LOADS, amplitudes, parameters=VALUES, held=held, field=field)
        slope = rest.gradient(own).parameters[name]
        expected = central(
            lambda value: scalar(parameters={**VALUES, name: value}, start=None), VALUES[name], 1e-3 * VALUES[name]
        )
        assert slope * VALUES[name] == pytest.approx(expected * VALUES[name], abs=1e-7 * size), name
    for axis in range(3):
        unit = np.eye(3)[axis]
        above, below = (scalar(loads=[(POINT, FORCE + sign * unit), "gravity"]) for sign in (1.0, -1.0))
        assert found.forces[0, axis] == pytest.approx((above - below) / 2, rel=1e-8, abs=1e-12 * abs(above))
    for mode in (0, 5):
        for part, slopes in enumerate((found.zeta, found.velocity)):
            moved = [start[0].copy(), start[1].copy()]
            moved[part][mode] += 1e-3
            assert slopes[mode] == pytest.approx((scalar(start=moved) - scalar()) / 1e-3, rel=1e-7)
    assert np.isnan(found.forces[1]).all() and np.isnan(found.places[1]).all()


def test_a_place_has_its_gradient(beam):
    at = beam.body().locate([0.62, 0.031, 0.1])
    amplitudes = weights((STEPS + 1, 1))
    own = weights((STEPS, 2))

    def scalar(point):
        kept = beam.vjp([(point, [3.0, -8.0, -20.0])], amplitudes)
        return (own * kept.values).sum(), kept

    found = scalar(at)[1].gradient(own)
    assert len(at.nodes) == 3
    for axis in (0, 1):
        move = 1e-5 * np.eye(3)[axis]
        above, below = (scalar(np.array(at.position) + sign * move)[0] for sign in (1.0, -1.0))
        assert found.places[0, axis] == pytest.approx((above - below) / 2e-5, rel=1e-7)


def test_a_body_without_live_regions_has_gradients_of_what_is_uniform(beam):
    given = {"stiffness": 1.3, "density": 0.8, "alpha": 2.0, "beta": 4e-5, "time_step": 1.2e-3}
    amplitudes = weights((STEPS + 1, 2))
    own = weights((STEPS, 2))

    def scalar(**changed):
        return (own * beam.vjp(LOADS, amplitudes, parameters={**given, **changed}).values).sum()

    found = beam.vjp(LOADS, amplitudes, parameters=given).gradient(own).parameters
    assert list(found) == list(given)
    size = max(abs(found[name] * value) for name, value in given.items())
    for name, value in given.items():
        expected = central(lambda x: scalar(**{name: x}), value, 1e-3 * value)
        assert found[name] * value == pytest.approx(expected * value, abs=1e-7 * size), name


def test_the_adjoint_of_a_body_is_the_difference_of_its_marches(beam):
    own = weights((STEPS, 2, 2))
    forces, amplitudes = weights((STEPS, 3), 1), weights(STEPS, 2)

    def scalar(forces=forces, amplitudes=amplitudes, zeta=np.zeros(6)):
        body = beam.body(dtype="float64", structure="exact")
        body.set(zeta)
        total = 0.0
        for step in range(STEPS):
            body.clear()
            body.push(POINT, forces[step])
            body.push_pattern("gravity", amplitudes[step])
            body.step()
            total += (own[step, 0] * body.probes()).sum() + (own[step, 1] * body.probes("velocity")).sum()
        return total, body

    value, body = scalar()
    found = body.adjoint(own, places=[POINT], patterns=["gravity"])
    assert found.forces.shape == (STEPS, 1, 2, 3) and found.patterns.shape == (STEPS, 1, 2)
    # The march is linear from rest, so the gradient gives the scalar back.
    held = (found.forces.sum(axis=2)[:, 0] * forces).sum() + (found.patterns.sum(axis=2)[:, 0] * amplitudes).sum()
    assert held == pytest.approx(value, rel=1e-10)
    zeta = 1e-4 * np.eye(6)[2]
    assert found.zeta[2] * 1e-4 == pytest.approx(scalar(zeta=zeta)[0] - value, rel=1e-7)
    assert beam.body().adjoint(own[:, 0]).zeta.shape == (6,), "single precision, displacements alone"


def test_what_has_no_gradient_is_refused_by_name(beam, file):  # noqa: F811
    free = vademecum.build({key: value for key, value in BEAM.items() if key != "support"})
    body = beam.body(structure="exact")
    kept = beam.vjp(LOADS, np.zeros((5, 2)))
    cases = [
        (lambda: beam.vjp(LOADS, np.zeros((5, 3))), ValueError, r"shape \(instants, 2\), found \(5, 3\)"),
        (lambda: beam.vjp(LOADS, np.zeros((5, 3)), held=True), ValueError, r"shape \(steps, 2\), found \(5, 3\)"),
        (lambda: beam.vjp(["gravit"], np.zeros((5, 1))), ValueError, "no load pattern `gravit`"),
        (lambda: beam.vjp(LOADS, np.zeros((5, 2)), parameters={"stif": 1.0}), ValueError, "`stif`"),
        (lambda: beam.vjp(LOADS, np.zeros((5, 2)), modes=3), ValueError, "live regions alone"),
        (lambda: file.vjp(LOADS, np.zeros((5, 2)), parameters={"root": 9.0}), vademecum.InputError, "root"),
        (lambda: kept.gradient(np.zeros((5, 2))), ValueError, r"shape \(4, 2\), found \(5, 2\)"),
        (lambda: body.adjoint(np.zeros((5, 3))), ValueError, r"\(steps, 2\) or \(steps, 2, 2\)"),
        (lambda: body.adjoint([[1.0]]), TypeError, "float64"),
        (lambda: free.body().adjoint(np.zeros((5, 2))), vademecum.FileError, "the body flies"),
    ]
    for call, error, words in cases:
        with pytest.raises(error, match=words):
            call()
    assert repr(kept) == "<KeptMarch of 4 steps, 2 probes, 2 loads and 6 modes>"
