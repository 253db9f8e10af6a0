"""Bodies: loads, steps, outputs, live parameters, state, threads."""

import pickle
import signal
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import vademecum

from conftest import BEAM, live

POINT, FORCE = [0.93, 0.031, 0.1], [3.0, -8.0, -20.0]


def pushed(file, steps=0, **options):
    body = file.body(**options)
    body.push(POINT, FORCE)
    body.step(steps)
    return body


def test_a_body_moves_where_it_is_pushed(beam):
    body = beam.body()
    assert not body.step(5), "nothing acts, nothing moves"
    place = body.push(POINT, [0.0, 0.0, -20.0])
    assert place.distance < 1e-12 and sum(place.weights) == pytest.approx(1.0)
    assert body.step(10)
    assert body.point(place)[2] < 0.0 and body.probe("tip") < 0.0 and body.energy > 0.0
    assert body.point(place, "velocity")[2] == pytest.approx(body.point(POINT, "velocity")[2])
    once = body.point(place)
    body.rest()
    body.push(place, [0.0, 0.0, -20.0])
    body.step(10)
    assert body.point(place) == pytest.approx(2 * once), "contacts add up"


def test_outputs_agree_with_each_other(beam):
    body = pushed(beam, 20, residual=False)
    surface, whole = body.surface(), body.whole()
    assert surface.shape == (beam.info.surface_nodes, 3) and whole.shape == (beam.info.nodes, 3)
    assert np.array_equal(surface, whole[: len(surface)])
    for node in (0, 7):
        assert body.node(node) == pytest.approx(surface[node], rel=1e-12, abs=1e-18)
    tip = np.argmin(np.linalg.norm(beam.nodes - [1.0, 0.05, 0.1], axis=1))
    assert body.probe("tip") == pytest.approx(whole[tip, 2], rel=1e-3)
    assert body.probes().tolist() == [body.probe("tip"), body.probe("side")]
    velocity = body.surface("velocity")
    assert velocity.shape == surface.shape and not np.array_equal(velocity, surface)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_results_are_written_into_the_callers_array(beam, dtype):
    body = pushed(beam, 20, dtype=dtype)
    frames = np.zeros((3, beam.info.surface_nodes, 3), dtype)
    given = body.surface(out=frames[1])
    assert np.shares_memory(given, frames) and np.array_equal(frames[1], body.surface())
    assert not frames[0].any() and not frames[2].any()
    assert given.dtype == body.dtype == dtype
    probes = np.empty(2)
    assert body.probes(out=probes) is probes and probes.tolist() == body.probes().tolist()


def test_an_array_that_does_not_fit_is_refused(beam):
    body = pushed(beam, 20)
    n = beam.info.surface_nodes
    fixed = np.zeros((n, 3))
    fixed.setflags(write=False)
    wrong = [
        (np.zeros((n, 3), np.float32), TypeError, "array of float64, found float32"),
        (np.zeros((n, 2)), ValueError, rf"expected the shape \({n}, 3\), found \({n}, 2\)"),
        (np.zeros((3, n)).T, ValueError, "not C-contiguous"),
        (fixed, ValueError, "cannot be written"),
        ([0.0], TypeError, "found <class 'list'>"),
    ]
    for out, error, words in wrong:
        with pytest.raises(error, match=words):
            body.surface(out=out)
    assert not fixed.any()


def test_a_march_gives_what_single_steps_give(beam):
    table = pushed(beam).march(60, every=3)
    body = pushed(beam)
    rows = []
    for _ in range(20):
        body.step(3)
        rows.append(body.probes())
    assert table.shape == (20, 2) and np.array_equal(table, rows) and table.any()
    with pytest.raises(ValueError, match="every is 0"):
        body.march(10, every=0)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_state_comes_back_bit_by_bit(beam, dtype):
    body = pushed(beam, 33, dtype=dtype)
    saved = pickle.loads(pickle.dumps(body.save()))
    assert isinstance(saved, bytes) and saved[:3] == b"VDS"
    energy, surface, first = body.energy, body.surface(), body.march(50)
    assert body.restore(saved)
    assert np.array_equal(body.march(50), first)
    other = beam.body(dtype=dtype)
    assert other.restore(bytearray(saved)) and other.energy == energy
    assert np.array_equal(other.surface(), surface), "residual flexibility comes back, too"


def test_a_state_is_carried_over_or_refused(live_beam, block_beam):
    body = pushed(live_beam, 33)
    saved, surface = body.save(), body.surface("velocity")
    other = live_beam.body(tip_stiffness=1.5)
    assert not other.restore(saved), "carried over"
    assert other.surface("velocity") == pytest.approx(surface, rel=1e-12)
    assert not live_beam.body(dtype=np.float32).restore(saved)
    for wrong, words in ((saved[1:], "no saved state"), (saved[:-8], "bytes"), (saved + bytes(8), "bytes")):
        with pytest.raises(ValueError, match=words):
            body.restore(wrong)
    with pytest.raises(ValueError, match="another file"):
        block_beam.body().restore(saved)
    both = vademecum.build({**BEAM, "time": {"step": 1e-3, "scheme": {"name": "bathe"}}}, keep_missed=True)
    with pytest.raises(ValueError, match="another structure"):
        both.body(structure="diagonal").restore(both.body(structure="exact").save())
    with pytest.raises(ValueError, match="not finite"):
        body.restore(saved[:-8] + np.array([np.nan]).tobytes())
    with pytest.raises(TypeError, match="bytes"):
        body.restore(np.zeros(12))
    assert np.array_equal(body.surface("velocity"), surface), "nothing has changed"


def test_quantities_are_those_of_a_table(live_beam):
    body = pushed(live_beam, 20)
    table = body.quantities
    assert {"probe", "node", "point", "surface", "whole", "energy"} < set(table)
    assert "stress" not in table and "frame_position" not in table
    for name, quantity in table.items():
        assert quantity.name == name and quantity.count > 0 and quantity.text
        index = POINT if name == "point" else quantity.count - 1
        value = body.read(name, index)
        assert np.size(value) == quantity.length and isinstance(value, float) == quantity.is_scalar
        if quantity.velocity_unit is None:
            with pytest.raises(ValueError, match="velocity"):
                body.read(name, index, "velocity")
    parts = [body.read(name) for name in table if name.endswith("_energy")]
    assert len(parts) == 2 and min(parts) > 0.0 and sum(parts) == pytest.approx(body.energy, rel=1e-12)
    assert body.read("energy") == body.energy
    assert body.read("probe", "side") == body.read("probe", 1) == body.probe("side")
    assert np.array_equal(body.read("surface", field="velocity"), body.surface("velocity"))
    assert np.array_equal(body.read("whole"), body.whole())
    assert np.array_equal(body.read("point", POINT), body.point(POINT))
    with pytest.raises(ValueError, match="no quantity `enrgy`.*did you mean `energy`"):
        body.read("enrgy")
    for index, error in ((2, ValueError), (-1, TypeError), ("top", ValueError), ([0, 0, 0], TypeError)):
        with pytest.raises(error):
            body.read("probe", index)
    with pytest.raises(ValueError):
        body.read("point")


def test_a_place_has_up_to_sixteen_nodes_and_can_be_pickled(beam):
    body = beam.body()
    found = body.locate(POINT)
    middle = vademecum.SurfacePoint(found.nodes, (0.25, 0.25, 0.5))
    for place in (found, middle, vademecum.SurfacePoint(range(16))):
        again = pickle.loads(pickle.dumps(place))
        assert (again.nodes, again.weights, again.radius, again.distance) == (
            place.nodes, place.weights, place.radius, place.distance
        )
        assert again.position == pytest.approx(place.position, nan_ok=True)
    body.push(middle, FORCE)
    body.step(10)
    expected = sum(weight * body.node(node) for node, weight in zip(middle.nodes, middle.weights))
    assert body.point(middle) == pytest.approx(expected, rel=1e-9)
    wrong = [
        (([],), "without nodes"),
        ((range(17),), "17 nodes"),
        (([1, 2], [1.0]), "2 nodes and 1 weights"),
        (([1, 2], [0.5, 0.4]), "sum to 0.9"),
        (([1], [np.nan]), "not finite"),
        (([1], None, 0.01), "points only"),
        (([1], None, -1.0), "radius -1"),
    ]
    for arguments, words in wrong:
        with pytest.raises(ValueError, match=words):
            vademecum.SurfacePoint(*arguments)


def test_wrong_arguments_are_named(beam):
    body = beam.body()
    wrong = [
        (lambda: body.push([0, 0], FORCE), ValueError, r"expected a SurfacePoint or three coordinates, found \[0, 0\]"),
        (lambda: body.push("tip", FORCE), TypeError, "expected a SurfacePoint or three coordinates, found 'tip'\nwhile processing 'place'"),
        (lambda: body.push(POINT, 3.0), TypeError, "expected three numbers, found 3.0"),
        (lambda: body.compliance(POINT), TypeError, "expected a SurfacePoint or three coordinates, found 0.93"),
        (lambda: body.step(-1), ValueError, "a whole number from 0, found -1"),
        (lambda: body.step("x"), TypeError, "a whole number from 0, found 'x'"),
        (lambda: beam.body(structur="exact"), TypeError, "`structur`.*did you mean `structure`"),
        (lambda: beam.body(stifness=2.0), TypeError, "`stifness`.*did you mean `stiffness`"),
        (lambda: beam.body(nothing=2.0), ValueError, "nothing"),
        (lambda: beam.body(structure=3), TypeError, "the name of a structure for `structure`, found 3"),
        (lambda: beam.body(tolerance="x"), TypeError, "a number for `tolerance`, found 'x'"),
        (lambda: beam.body(contacts=-1), ValueError, "a whole number from 0 for `contacts`, found -1"),
        (lambda: beam.body(residual=0.5), TypeError, "True or False for `residual`"),
        (lambda: beam.body().push([100.0, 0.0, 0.0], FORCE), ValueError, "9.900e1 away from the loadable surface.*unit of the file"),
        (lambda: beam.body().locate([0.0, 0.0, -100.0]), ValueError, "away from the loadable surface"),
        (lambda: beam.batch(2).push(0, [100.0, 0.0, 0.0], FORCE), ValueError, "away from the loadable surface"),
    ]
    for call, error, words in wrong:
        with pytest.raises(error, match=words):
            call()


def test_scales_of_the_whole_body_are_options(beam, live_beam):
    soft, stiff = pushed(beam, 200_000, alpha=2.0), pushed(beam, 200_000, stiffness=2.0, alpha=2.0)
    assert soft.probe("tip") == pytest.approx(2.0 * stiff.probe("tip"), rel=1e-6)
    # Twice the density is half the acceleration of a first step.
    light, heavy = pushed(beam, 1, beta=0.0), pushed(beam, 1, density=2.0, beta=0.0)
    assert 1.8 < light.probe("tip", "velocity") / heavy.probe("tip", "velocity") < 2.2
    # A live parameter of that name keeps its range.
    file = vademecum.build(live(parameter=[{"name": "stiffness", "kind": "stiffness", "range": [0.5, 2.0]}]))
    assert file.body(stiffness=1.5).parameters == {"stiffness": 1.5}
    with pytest.raises(ValueError, match="stiffness"):
        file.body(stiffness=3.0)


def test_a_live_parameter_is_set_while_the_body_moves(live_beam):
    body = pushed(live_beam, 40)
    before = body.surface("velocity")
    body.set_parameters(tip_stiffness=1.5, damping=2e-5)
    assert body.parameters == {"tip stiffness": 1.5, "damping": 2e-5}
    assert np.allclose(body.surface("velocity"), before, rtol=1e-12, atol=0), "the motion stays"
    # The loads stay, too: the body comes to rest where a stiffer one does.
    slow = live_beam.body(**{"tip stiffness": 1.5, "damping": 1e-4})
    slow.push(POINT, FORCE)
    slow.step(200_000)
    body.set_parameters({"damping": 1e-4})
    body.step(200_000)
    assert body.probe("tip") == pytest.approx(slow.probe("tip"), rel=1e-9)
    soft = pushed(live_beam, 200_000, damping=1e-4)
    assert soft.probe("tip") == pytest.approx(1.5 * slow.probe("tip"), rel=1e-6)


def test_live_regions_are_set_while_the_body_moves(regions):
    tip = "stiffness of the tip"
    body = regions.body(modes=2, residual=False, **{tip: 2.0})
    assert body.modes == 2 and body.parameters[tip] == 2.0 and body.parameters["beta"] == 1e-6
    body.push_pattern("pull")
    body.step(20)
    before = body.energy
    body.set_parameters({tip: 3.0}, stiffness_of_the_root=0.5)
    assert body.parameters[tip] == 3.0 and body.parameters["stiffness of the root"] == 0.5
    kinetic, elastic, work = body.carried
    assert work != 0 and body.energy == pytest.approx(before + work - kinetic - elastic, rel=1e-9)
    # The loads stay: the body comes to rest where one does that was bound so.
    other = regions.body(modes=2, residual=False, **{tip: 3.0, "stiffness of the root": 0.5})
    other.push_pattern("pull")
    for one in (body, other):
        one.step(100_000)
    assert body.probe("x") == pytest.approx(other.probe("x"), rel=1e-9) and body.probe("x") != 0
    with pytest.raises(ValueError, match="5.*0.25.*4"):
        body.set_parameters({tip: 5.0, "beta": 1e-5})
    assert body.parameters == other.parameters
    with pytest.raises(ValueError, match="4"):
        regions.body(modes=4)


def test_bodies_of_a_batch_have_parameters_of_their_own(regions):
    tip = "stiffness of the tip"
    batch = regions.batch(3)
    for instance in range(3):
        batch.push_pattern(instance, "pull")
    batch.step(10)
    batch.set_parameters({tip: np.array([0.5, 1.0, 2.0])}, beta=1e-5)
    assert batch.parameters[tip].tolist() == [0.5, 1.0, 2.0]
    assert batch.parameters["beta"].tolist() == [1e-5] * 3
    assert batch.step(30) == (3, 0, 0)
    for instance, value in enumerate([0.5, 1.0, 2.0]):
        one = regions.body(residual=False)
        one.push_pattern("pull")
        one.step(10)
        one.set_parameters({tip: value, "beta": 1e-5})
        one.step(30)
        assert np.array_equal(batch.probes()[instance], one.probes())
        assert np.array_equal(batch.surface(instance), one.surface())
    with pytest.raises(ValueError, match="2 values; the batch has 3"):
        batch.set_parameters({tip: [1.0, 2.0]})
    with pytest.raises(ValueError, match="9"):
        batch.set_parameters({tip: [1.0, 2.0, 9.0]})
    assert batch.parameters[tip].tolist() == [0.5, 1.0, 2.0]


def test_a_scenario_runs_at_values_of_live_regions(regions):
    pull = {"duration": 0.02, "pattern": [{"name": "pull"}]}
    tip = {"stiffness of the tip": 3.0}
    played = regions.run(pull, **tip)
    body = regions.body(**tip)
    body.push_pattern("pull")
    body.step(20)
    assert played.probes["x"][-1] == pytest.approx(body.probe("x"), rel=1e-9)
    assert played.probes["x"][-1] != regions.run(pull).probes["x"][-1]


def test_a_parameter_that_cannot_be_set_changes_nothing(live_beam):
    body = live_beam.body()
    with pytest.raises(ValueError, match="2.5.*0.5"):
        body.set_parameters({"damping": 2e-5, "tip stiffness": 2.5})
    assert body.parameters["damping"] == live_beam.info.parameter("damping").nominal
    with pytest.raises(vademecum.InputError, match="tip stiffness"):
        live_beam.body(tip_stifness=1.0)
    with pytest.raises(ValueError, match="`auto`"):
        live_beam.body(structure="dense")
    with pytest.raises(TypeError, match="float32 or float64"):
        live_beam.body(dtype=np.int32)


def test_names_that_the_file_does_not_have(beam):
    body = beam.body()
    with pytest.raises(ValueError, match="no probe `tp`; it has `tip`, `side`"):
        body.probe("tp")
    with pytest.raises(ValueError, match="no load pattern `gravit`"):
        body.push_pattern("gravit")
    with pytest.raises(ValueError, match="`displacement` or `velocity`"):
        body.surface("speed")
    with pytest.raises(ValueError, match="not finite"):
        body.push([np.nan, 0, 0], FORCE)
    with pytest.raises(ValueError, match="finite"):
        body.push(POINT, [np.inf, 0, 0])
    with pytest.raises(ValueError):
        body.push(vademecum.SurfacePoint([10**6] * 3), FORCE)
    with pytest.raises(ValueError):
        body.node(10**9)


def test_compliance_says_what_a_step_does(beam):
    body = beam.body()
    body.push_pattern("gravity")
    body.step(7)
    points = [POINT, [0.4, 0.05, 0.1]]
    forces = np.array([[1.0, -2.0, -20.0], [0.0, 3.0, 5.0]])
    w, free = body.compliance(points), body.free_motion(points)
    assert w.shape == (6, 6) and free.shape == (2, 3) and np.array_equal(w, w.T)
    for point, force in zip(points, forces):
        body.push(point, force)
    body.step()
    moved = np.array([body.point(point) for point in points])
    said = free + (w @ forces.ravel()).reshape(2, 3)
    assert said == pytest.approx(moved, rel=1e-9, abs=1e-9 * abs(moved).max())


def test_what_a_ray_meets_on_the_moving_body(beam):
    body = pushed(beam, 20)
    met = body.pick([0.51, 0.043, 1.0], [0.0, 0.0, -1.0])
    assert met is not None and met.position == pytest.approx([0.51, 0.043, 0.1 + body.point(met)[2]], abs=1e-6)
    assert body.pick([0.51, 0.043, 1.0], [0.0, 0.0, 1.0]) is None


def test_reduced_coordinates_are_set(beam):
    body = beam.body()
    body.set([1e-3] + [0.0] * (body.modes - 1))
    zeta, velocity = body.coordinates()
    assert zeta.tolist() == [1e-3] + [0.0] * (body.modes - 1) and not velocity.any()
    with pytest.raises(ValueError):
        body.set([1.0])


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_an_instance_of_a_batch_has_the_bits_of_a_body(live_beam, dtype):
    batch = live_beam.batch(20, dtype=dtype)
    assert len(batch) == 20
    batch.push(3, POINT, FORCE)
    batch.push_pattern(7, "gravity", 0.5)
    assert batch.step(50) == (2, 18, 0)
    batch.set_parameters(tip_stiffness=1.7)
    batch.step(50)
    one = live_beam.body(dtype=dtype, residual=False)
    one.push(POINT, FORCE)
    one.step(50)
    one.set_parameters(tip_stiffness=1.7)
    one.step(50)
    probes, energy = batch.probes(), batch.energy()
    assert np.array_equal(probes[3], one.probes()) and energy[3] == one.energy and not probes[0].any()
    assert np.array_equal(batch.surface(3), one.surface()) and np.array_equal(batch.whole(3), one.whole())
    assert probes[7].any() and np.array_equal(batch.read("probe", "side"), probes[:, 1])
    assert np.array_equal(batch.read("energy"), energy) and list(batch.quantities) == list(one.quantities)
    assert np.array_equal(batch.read("surface")[3], batch.surface(3))
    batch.clear()
    with pytest.raises(IndexError, match="20"):
        batch.push(20, POINT, FORCE)


def test_a_keyword_that_is_an_option_and_a_parameter_is_refused():
    parameter = {"name": "rest below", "kind": "stiffness", "range": [0.5, 2.0], "scale": "log"}
    file = vademecum.build(live(parameter=[parameter]))
    with pytest.raises(ValueError, match='set_parameters\\({"rest below": value}\\)'):
        file.body(rest_below=1.5)
    body = file.body()
    body.set_parameters({"rest below": 1.5})
    assert body.parameters == {"rest below": 1.5}


def test_many_bodies_move_in_threads(block_beam):
    def probes(force):
        body = block_beam.body()
        body.push(POINT, [0.0, 0.0, force])
        return body.march(3000)

    forces = [-1.0 - k for k in range(8)]
    alone = [probes(force) for force in forces]
    with ThreadPoolExecutor(4) as threads:
        together = list(threads.map(probes, forces))
    assert all(np.array_equal(a, b) for a, b in zip(alone, together)) and alone[0].any()


def test_a_step_lets_other_threads_run_and_a_scene_belongs_to_one(block_beam):
    body = pushed(block_beam)
    started = time.perf_counter()
    body.step(20_000)
    steps = int(20_000 / (time.perf_counter() - started))  # about a second
    thread = threading.Thread(target=body.step, args=(steps,))
    thread.start()
    ran, refused = 0, 0
    while thread.is_alive():
        ran += 1
        try:
            body.energy
        except RuntimeError as error:
            assert "another thread" in str(error)
            refused += 1
    thread.join()
    assert ran > 1000 and refused > ran // 2
    assert body.energy > 0.0


def test_ctrl_c_ends_a_long_march_and_the_scene_goes_on(block_beam):
    body = pushed(block_beam)
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, 0.2)
    try:
        with pytest.raises(KeyboardInterrupt):
            body.step(10**15)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert body.step() and np.isfinite(body.energy)


def test_reactions_hold_the_weight_and_a_base_adds_to_it():
    problem = {
        **BEAM,
        "support": [{"name": "wall", "on": {"group": "x_min"}}],
        "base": {"moves": True},
        "output": {**BEAM["output"], "reactions": True},
        "damping": {"ratio": 1.0},
    }
    file = vademecum.build(problem)
    assert [support.name for support in file.info.supports] == ["wall"]
    assert file.info.supports[0].point == pytest.approx((0.0, 0.05, 0.05))
    body = file.body()
    assert body.support_names == ["wall"]
    body.push_pattern("gravity")
    body.step(2000)
    # 12 kg, half a metre from the wall.
    held = body.reaction("wall")
    assert held.shape == (6,) and held[2] == pytest.approx(12.0 * 9.81, rel=1e-6)
    assert held[4] == pytest.approx(-12.0 * 9.81 * 0.5, rel=1e-6)
    body.push_base(acceleration=(0.0, 0.0, 9.81))
    body.step(2000)
    assert body.reaction("wall")[2] == pytest.approx(24.0 * 9.81, rel=1e-6)
    with pytest.raises(ValueError, match="did you mean `wall`"):
        body.reaction("wal")

    # A run and a batch have the same numbers.
    played = file.run({"duration": 0.1, "pattern": [{"name": "gravity"}]})
    batch = file.batch(20)
    for instance in range(20):
        batch.push_pattern(instance, "gravity", instance)
    assert batch.support_names == ["wall"]
    steps = len(played.time) - 1
    batch.step(steps)
    held, ran = batch.reaction("wall"), played.reactions["wall"]
    assert held.shape == (20, 6) and ran.shape == (steps + 1, 6) and not played.flight
    assert held[1] == pytest.approx(ran[-1], rel=1e-9, abs=1e-9)
    assert held[7] == pytest.approx(7 * held[1], rel=1e-9, abs=1e-9)


def test_stress_bends_with_the_weight_and_strains_follow_it():
    problem = {**BEAM, "output": {**BEAM["output"], "stress": {"group": "x_min"}}, "damping": {"ratio": 1.0}}
    body = vademecum.build(problem).body()
    points = body.stress_points
    assert points.shape[1] == 2 and len(points) > 4 and not points[:, 1].any()
    body.push_pattern("gravity")
    body.step(2000)
    stress, strain, equivalent = body.stress(), body.strain(), body.von_mises()
    assert stress.shape == strain.shape == (len(points), 6) and equivalent.shape == (len(points),)
    # The weight pulls the upper side and presses the lower one.
    assert stress[:, 0].max() > 0 > stress[:, 0].min()
    xx, yy, zz, xy, yz, zx = stress.T
    squares = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2 + 6 * (xy**2 + yz**2 + zx**2)
    assert equivalent == pytest.approx(np.sqrt(squares / 2), rel=1e-12)
    material = problem["material"][0]
    young, poisson = material["young"], material["poisson"]
    assert strain[:, 0] == pytest.approx((xx - poisson * (yy + zz)) / young, rel=1e-9, abs=1e-15)
    assert strain[:, 3] == pytest.approx((1 + poisson) * xy / young, rel=1e-9, abs=1e-15)


def test_a_free_body_flies_turns_and_rings():
    problem = {key: value for key, value in BEAM.items() if key != "support"}
    file = vademecum.build(problem)
    body = file.body()
    centre = np.array(file.info.free_body.centre)
    body.throw(velocity=(0.0, 0.0, 3.0), spin=(0.0, 5.0, 0.0))
    rigid = body.rigid_body
    assert rigid == file.info.free_body and rigid.mass == pytest.approx(12.0)
    assert sorted(rigid.principal_moments)[2] == pytest.approx(12.0 * (1.0 + 0.1**2) / 12.0, rel=1e-2)
    axes = np.array(rigid.principal_axes)
    assert axes @ axes.T == pytest.approx(np.eye(3), abs=1e-12)
    thrown = body.motion
    place = body.locate(POINT)
    for _ in range(100):
        body.pull((0.0, 0.0, -9.81 * rigid.mass))
        ahead = body.ahead
        assert body.step()
        assert body.motion.position == ahead.position
    time = 100 * body.time_step
    assert body.motion.position == pytest.approx(centre + [0.0, 0.0, 3.0 * time - 0.5 * 9.81 * time**2], abs=1e-12)
    assert np.array_equal(body.read("frame_position"), body.motion.position)
    assert body.read("frame_spin") == pytest.approx([0.0, 5.0, 0.0], abs=1e-6)
    assert body.motion.angular_momentum == thrown.angular_momentum and body.energy > 0.0
    # It has turned about y by 5 rad/s.
    half = 0.5 * 5.0 * time
    assert body.motion.attitude == pytest.approx((np.cos(half), 0.0, np.sin(half), 0.0), abs=1e-6)
    before, velocity, saved = body.in_space(place), body.in_space(place, "velocity"), body.save()
    assert body.step()
    row = np.zeros((2, 3))
    body.in_space(place, out=row[1])
    assert (row[1] - before) / body.time_step == pytest.approx(velocity, abs=0.05)
    # The rigid motion is part of the state.
    other = file.body()
    assert other.restore(saved) and np.array_equal(other.in_space(place), before)
    # A push at a point is the force and its moment, once.
    body.rest()
    assert body.motion.position == file.info.free_body.centre
    body.push(place, FORCE)
    body.step(2)
    assert body.motion.momentum == pytest.approx(body.time_step * np.array(FORCE))
    arm = np.array(place.position) - centre
    assert body.motion.angular_momentum == pytest.approx(body.time_step * np.cross(arm, FORCE), rel=1e-4)
    kept = body.motion.momentum
    body.push(place, FORCE)
    body.clear()
    body.step()
    assert body.motion.momentum == kept
    played = file.run({"duration": 0.1, "free": {"velocity": [0, 0, 3], "gravity": [0, 0, -9.81]}})
    fallen = centre[2] + 3.0 * played.time - 0.5 * 9.81 * played.time**2
    assert played.flight["centre z"] == pytest.approx(fallen, abs=1e-12) and not played.reactions
    body.push_pattern("gravity")
    body.step()
    assert body.motion.momentum[2] == pytest.approx(kept[2] - 9.81 * 12.0 * body.time_step)
    body.motion = vademecum.Motion((1.0, 2.0, 3.0))
    assert body.motion.position == (1.0, 2.0, 3.0) and body.motion.momentum == (0.0, 0.0, 0.0)


def test_a_frame_that_the_host_moves_stays():
    body = vademecum.build({key: value for key, value in BEAM.items() if key != "support"}).body(flight=False)
    body.push(POINT, FORCE)
    body.step(10)
    assert body.energy > 0.0 and body.rigid_body is not None
    with pytest.raises(ValueError, match="flight=False"):
        body.throw((0.0, 0.0, 1.0))


def test_what_cannot_fly_is_refused(beam):
    body = beam.body()
    assert body.rigid_body is None
    for call in (body.throw, lambda: body.motion, lambda: body.ahead, lambda: body.pull(FORCE), lambda: body.in_space(POINT)):
        with pytest.raises(ValueError, match="supports"):
            call()
    with pytest.raises(ValueError, match="attitude is zero"):
        vademecum.Motion((0.0, 0.0, 0.0), attitude=(0.0, 0.0, 0.0, 0.0))


def test_large_displacements_are_stepped_by_their_own_structure():
    file = Path(__file__).parents[3] / "fixtures/golden/bent.vdm"
    body = vademecum.open(file).body()
    assert body.structure == "strain"
    body.push_pattern("pull", 1.0)
    assert body.step(20) and body.energy > 0.0
    with pytest.raises(vademecum.Error):
        vademecum.open(file).body(structure="exact")
    # Sub-steps and viscosity are choices of the body.
    energies = []
    for options in ({"substeps": 2}, {"substeps": 2, "viscosity": 0.0}, {"substeps": 2, "viscosity": 5.0}):
        other = vademecum.open(file).body(**options)
        other.push_pattern("pull", 1.0)
        other.step(20)
        other.clear()
        other.step(200)
        energies.append(other.energy)
    finer, kept, lost = energies
    assert kept > finer > lost > 0.0
    with pytest.raises(vademecum.Error, match="sub-steps"):
        vademecum.open(file).body(substeps=1025)


def test_sizes_that_no_memory_has_are_errors_of_the_argument(live_beam):
    for instances in (10**12, 10**19, -1):
        with pytest.raises((ValueError, TypeError)):
            live_beam.batch(instances)
    with pytest.raises(ValueError, match="points"):
        live_beam.frf("gravity", "tip", (1, 100), points=10**12)
    with pytest.raises(ValueError, match="stiffness scale"):
        live_beam.body(stiffness=-1.0)
