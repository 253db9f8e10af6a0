"""Scenes: loads, steps, outputs, live parameters, state, threads."""

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


def pushed(body, steps=0, **options):
    scene = body.scene(**options)
    scene.contact(POINT, FORCE)
    scene.step(steps)
    return scene


def test_a_body_moves_where_it_is_pushed(beam):
    scene = beam.scene()
    assert not scene.step(5), "nothing acts, nothing moves"
    place = scene.contact(POINT, [0.0, 0.0, -20.0])
    assert place.distance < 1e-12 and sum(place.weights) == pytest.approx(1.0)
    assert scene.step(10)
    assert scene.point(place)[2] < 0.0 and scene.probe("tip") < 0.0 and scene.energy > 0.0
    assert scene.point(place, "velocity")[2] == pytest.approx(scene.point(POINT, "velocity")[2])
    once = scene.point(place)
    scene.rest()
    scene.contact(place, [0.0, 0.0, -20.0])
    scene.step(10)
    assert scene.point(place) == pytest.approx(2 * once), "contacts add up"


def test_outputs_agree_with_each_other(beam):
    scene = pushed(beam, 20, residual=False)
    surface, body = scene.surface(), scene.body()
    assert surface.shape == (beam.info.surface_nodes, 3) and body.shape == (beam.info.nodes, 3)
    assert np.array_equal(surface, body[: len(surface)])
    for node in (0, 7):
        assert scene.node(node) == pytest.approx(surface[node], rel=1e-12, abs=1e-18)
    tip = np.argmin(np.linalg.norm(beam.nodes - [1.0, 0.05, 0.1], axis=1))
    assert scene.probe("tip") == pytest.approx(body[tip, 2], rel=1e-3)
    assert scene.probes().tolist() == [scene.probe("tip"), scene.probe("side")]
    velocity = scene.surface("velocity")
    assert velocity.shape == surface.shape and not np.array_equal(velocity, surface)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_results_are_written_into_the_callers_array(beam, dtype):
    scene = pushed(beam, 20, dtype=dtype)
    frames = np.zeros((3, beam.info.surface_nodes, 3), dtype)
    given = scene.surface(out=frames[1])
    assert np.shares_memory(given, frames) and np.array_equal(frames[1], scene.surface())
    assert not frames[0].any() and not frames[2].any()
    assert given.dtype == scene.dtype == dtype
    probes = np.empty(2)
    assert scene.probes(out=probes) is probes and probes.tolist() == scene.probes().tolist()
    state = np.empty_like(scene.save())
    assert scene.save(out=state) is state and np.array_equal(state, scene.save())


def test_an_array_that_does_not_fit_is_refused(beam):
    scene = pushed(beam, 20)
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
            scene.surface(out=out)
    assert not fixed.any()


def test_a_march_gives_what_single_steps_give(beam):
    table = pushed(beam).march(60, every=3)
    scene = pushed(beam)
    rows = []
    for _ in range(20):
        scene.step(3)
        rows.append(scene.probes())
    assert table.shape == (20, 2) and np.array_equal(table, rows) and table.any()
    with pytest.raises(ValueError, match="every is 0"):
        scene.march(10, every=0)


def test_a_state_comes_back_bit_by_bit(beam):
    scene = pushed(beam, 33)
    saved = pickle.loads(pickle.dumps(scene.save()))
    first = scene.march(50)
    scene.restore(saved)
    assert np.array_equal(scene.march(50), first)
    with pytest.raises(TypeError, match="float64"):
        scene.restore(saved.astype(np.float32))
    with pytest.raises(ValueError):
        scene.restore(saved[1:])
    with pytest.raises(ValueError):
        scene.restore(np.full_like(saved, np.nan))
    other = beam.scene()
    other.restore(saved)
    assert other.energy == pytest.approx(beam_energy(beam, saved))


def beam_energy(beam, saved):
    scene = beam.scene()
    scene.restore(saved)
    return scene.energy


def test_a_live_parameter_is_set_while_the_body_moves(live_beam):
    scene = pushed(live_beam, 40)
    before = scene.surface("velocity")
    scene.set(tip_stiffness=1.5, damping=2e-5)
    assert scene.parameters == {"tip stiffness": 1.5, "damping": 2e-5}
    assert np.allclose(scene.surface("velocity"), before, rtol=1e-12, atol=0), "the motion stays"
    # The loads stay, too: the body comes to rest where a stiffer one does.
    slow = live_beam.scene(**{"tip stiffness": 1.5, "damping": 1e-4})
    slow.contact(POINT, FORCE)
    slow.step(200_000)
    scene.set({"damping": 1e-4})
    scene.step(200_000)
    assert scene.probe("tip") == pytest.approx(slow.probe("tip"), rel=1e-9)
    soft = pushed(live_beam, 200_000, damping=1e-4)
    assert soft.probe("tip") == pytest.approx(1.5 * slow.probe("tip"), rel=1e-6)


def test_a_parameter_that_cannot_be_set_changes_nothing(live_beam):
    scene = live_beam.scene()
    with pytest.raises(vademecum.InputError, match="2.5.*0.5"):
        scene.set({"damping": 2e-5, "tip stiffness": 2.5})
    assert scene.parameters["damping"] == live_beam.info.parameter("damping").nominal
    with pytest.raises(vademecum.InputError, match="tip stiffness"):
        live_beam.scene(tip_stifness=1.0)
    with pytest.raises(ValueError, match="`auto`"):
        live_beam.scene(structure="dense")
    with pytest.raises(TypeError, match="float32 or float64"):
        live_beam.scene(dtype=np.int32)


def test_names_that_the_file_does_not_have(beam):
    scene = beam.scene()
    with pytest.raises(ValueError, match="no probe `tp`; it has `tip`, `side`"):
        scene.probe("tp")
    with pytest.raises(ValueError, match="no load pattern `gravit`"):
        scene.pattern("gravit")
    with pytest.raises(ValueError, match="`displacement` or `velocity`"):
        scene.surface("speed")
    with pytest.raises(ValueError, match="not finite"):
        scene.contact([np.nan, 0, 0], FORCE)
    with pytest.raises(ValueError, match="finite"):
        scene.contact(POINT, [np.inf, 0, 0])
    with pytest.raises(ValueError):
        scene.contact(vademecum.SurfacePoint([10**6] * 3), FORCE)
    with pytest.raises(ValueError):
        scene.node(10**9)


def test_compliance_says_what_a_step_does(beam):
    scene = beam.scene()
    scene.pattern("gravity")
    scene.step(7)
    points = [POINT, [0.4, 0.05, 0.1]]
    forces = np.array([[1.0, -2.0, -20.0], [0.0, 3.0, 5.0]])
    w, free = scene.compliance(points), scene.free_motion(points)
    assert w.shape == (6, 6) and free.shape == (2, 3) and np.array_equal(w, w.T)
    for point, force in zip(points, forces):
        scene.contact(point, force)
    scene.step()
    moved = np.array([scene.point(point) for point in points])
    said = free + (w @ forces.ravel()).reshape(2, 3)
    assert said == pytest.approx(moved, rel=1e-9, abs=1e-9 * abs(moved).max())


def test_what_a_ray_meets_on_the_moving_body(beam):
    scene = pushed(beam, 20)
    met = scene.pick([0.51, 0.043, 1.0], [0.0, 0.0, -1.0])
    assert met is not None and met.position == pytest.approx([0.51, 0.043, 0.1 + scene.point(met)[2]], abs=1e-6)
    assert scene.pick([0.51, 0.043, 1.0], [0.0, 0.0, 1.0]) is None


def test_reduced_coordinates_are_set(beam):
    scene = beam.scene()
    scene.place([1e-3] + [0.0] * (scene.modes - 1))
    assert scene.save()[: scene.modes].tolist() == [1e-3] + [0.0] * (scene.modes - 1)
    with pytest.raises(ValueError):
        scene.place([1.0])


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_an_instance_of_a_batch_has_the_bits_of_a_scene(live_beam, dtype):
    batch = live_beam.batch(20, dtype=dtype)
    assert len(batch) == 20
    batch.contact(3, POINT, FORCE)
    batch.pattern(7, "gravity", 0.5)
    assert batch.step(50) == (2, 18, 0)
    batch.set(tip_stiffness=1.7)
    batch.step(50)
    one = live_beam.scene(dtype=dtype, residual=False)
    one.contact(POINT, FORCE)
    one.step(50)
    one.set(tip_stiffness=1.7)
    one.step(50)
    probes, energy = batch.probes(), batch.energy()
    assert np.array_equal(probes[3], one.probes()) and energy[3] == one.energy and not probes[0].any()
    assert np.array_equal(batch.surface(3), one.surface()) and np.array_equal(batch.body(3), one.body())
    assert probes[7].any()
    batch.clear()
    with pytest.raises(IndexError, match="20"):
        batch.contact(20, POINT, FORCE)


def test_a_keyword_that_is_an_option_and_a_parameter_is_refused():
    parameter = {"name": "rest below", "kind": "stiffness", "range": [0.5, 2.0], "scale": "log"}
    body = vademecum.build(live(parameter=[parameter]))
    with pytest.raises(ValueError, match='set\\({"rest below": value}\\)'):
        body.scene(rest_below=1.5)
    scene = body.scene()
    scene.set({"rest below": 1.5})
    assert scene.parameters == {"rest below": 1.5}


def test_many_scenes_move_in_threads(block_beam):
    def probes(force):
        scene = block_beam.scene()
        scene.contact(POINT, [0.0, 0.0, force])
        return scene.march(3000)

    forces = [-1.0 - k for k in range(8)]
    alone = [probes(force) for force in forces]
    with ThreadPoolExecutor(4) as threads:
        together = list(threads.map(probes, forces))
    assert all(np.array_equal(a, b) for a, b in zip(alone, together)) and alone[0].any()


def test_a_step_lets_other_threads_run_and_a_scene_belongs_to_one(block_beam):
    scene = pushed(block_beam)
    started = time.perf_counter()
    scene.step(20_000)
    steps = int(20_000 / (time.perf_counter() - started))  # about a second
    thread = threading.Thread(target=scene.step, args=(steps,))
    thread.start()
    ran, refused = 0, 0
    while thread.is_alive():
        ran += 1
        try:
            scene.energy
        except RuntimeError as error:
            assert "another thread" in str(error)
            refused += 1
    thread.join()
    assert ran > 1000 and refused > ran // 2
    assert scene.energy > 0.0


def test_ctrl_c_ends_a_long_march_and_the_scene_goes_on(block_beam):
    scene = pushed(block_beam)
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, 0.2)
    try:
        with pytest.raises(KeyboardInterrupt):
            scene.step(10**15)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert scene.step() and np.isfinite(scene.energy)


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
    scene = file.scene()
    assert scene.support_names == ["wall"]
    scene.pattern("gravity")
    scene.step(2000)
    # 12 kg, half a metre from the wall.
    held = scene.reaction("wall")
    assert held.shape == (6,) and held[2] == pytest.approx(12.0 * 9.81, rel=1e-6)
    assert held[4] == pytest.approx(-12.0 * 9.81 * 0.5, rel=1e-6)
    scene.base(acceleration=(0.0, 0.0, 9.81))
    scene.step(2000)
    assert scene.reaction("wall")[2] == pytest.approx(24.0 * 9.81, rel=1e-6)
    with pytest.raises(ValueError, match="did you mean `wall`"):
        scene.reaction("wal")

    # A run and a batch have the same numbers.
    played = file.run({"duration": 0.1, "pattern": [{"name": "gravity"}]})
    batch = file.batch(20)
    for instance in range(20):
        batch.pattern(instance, "gravity", instance)
    assert batch.support_names == ["wall"]
    steps = len(played.time) - 1
    batch.step(steps)
    held, ran = batch.reaction("wall"), played.reactions["wall"]
    assert held.shape == (20, 6) and ran.shape == (steps + 1, 6) and not played.flight
    assert held[1] == pytest.approx(ran[-1], rel=1e-9, abs=1e-9)
    assert held[7] == pytest.approx(7 * held[1], rel=1e-9, abs=1e-9)


def test_stress_bends_with_the_weight_and_strains_follow_it():
    problem = {**BEAM, "output": {**BEAM["output"], "stress": {"group": "x_min"}}, "damping": {"ratio": 1.0}}
    scene = vademecum.build(problem).scene()
    points = scene.stress_points
    assert points.shape[1] == 2 and len(points) > 4 and not points[:, 1].any()
    scene.pattern("gravity")
    scene.step(2000)
    stress, strain, equivalent = scene.stress(), scene.strain(), scene.von_mises()
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
    body = vademecum.build(problem)
    scene = body.scene()
    centre = np.array(body.info.free_body.centre)
    flight = vademecum.Flight(scene, velocity=(0.0, 0.0, 3.0), spin=(0.0, 5.0, 0.0))
    assert flight.mass == pytest.approx(12.0) and flight.scene is scene
    assert sorted(flight.moments)[2] == pytest.approx(12.0 * (1.0 + 0.1**2) / 12.0, rel=1e-2)
    assert flight.axes @ flight.axes.T == pytest.approx(np.eye(3), abs=1e-12)
    thrown = flight.motion
    place = scene.locate(POINT)
    for _ in range(100):
        flight.pull((0.0, 0.0, -9.81 * flight.mass))
        ahead = flight.ahead
        assert flight.step()
        assert flight.motion.position == ahead.position
    time = 100 * scene.time_step
    assert flight.motion.position == pytest.approx(centre + [0.0, 0.0, 3.0 * time - 0.5 * 9.81 * time**2], abs=1e-12)
    assert flight.motion.angular_momentum == thrown.angular_momentum and scene.energy > 0.0
    # It has turned about y by 5 rad/s.
    half = 0.5 * 5.0 * time
    assert flight.motion.attitude == pytest.approx((np.cos(half), 0.0, np.sin(half), 0.0), abs=1e-6)
    before, velocity = flight.point(place), flight.velocity(place)
    assert flight.step()
    row = np.zeros((2, 3))
    flight.point(place, out=row[1])
    assert (row[1] - before) / scene.time_step == pytest.approx(velocity, abs=0.05)
    # A push at a point is the force and its moment, once.
    flight.motion = vademecum.Motion(centre)
    scene.rest()
    flight.contact(place, FORCE)
    flight.step()
    flight.step()
    assert flight.motion.momentum == pytest.approx(scene.time_step * np.array(FORCE))
    arm = np.array(place.position) - centre
    assert flight.motion.angular_momentum == pytest.approx(scene.time_step * np.cross(arm, FORCE), rel=1e-4)
    kept = flight.motion.momentum
    flight.contact(place, FORCE)
    flight.clear()
    flight.step()
    assert flight.motion.momentum == kept
    played = body.run({"duration": 0.1, "free": {"velocity": [0, 0, 3], "gravity": [0, 0, -9.81]}})
    fallen = centre[2] + 3.0 * played.time - 0.5 * 9.81 * played.time**2
    assert played.flight["centre z"] == pytest.approx(fallen, abs=1e-12) and not played.reactions
    flight.pattern("gravity")
    flight.step()
    assert flight.motion.momentum[2] == pytest.approx(kept[2] - 9.81 * 12.0 * scene.time_step)


def test_what_cannot_fly_is_refused(beam):
    with pytest.raises(ValueError, match="supports"):
        vademecum.Flight(beam.scene())
    with pytest.raises(ValueError, match="attitude is zero"):
        vademecum.Motion((0.0, 0.0, 0.0), attitude=(0.0, 0.0, 0.0, 0.0))


def test_large_displacements_are_stepped_by_their_own_structure():
    file = Path(__file__).parents[3] / "fixtures/golden/bent.vdm"
    scene = vademecum.open(file).scene()
    assert scene.structure == "strain"
    scene.pattern("pull", 1.0)
    assert scene.step(20) and scene.energy > 0.0
    with pytest.raises(vademecum.Error):
        vademecum.open(file).scene(structure="exact")
    # Sub-steps and viscosity are choices of the scene.
    energies = []
    for options in ({"substeps": 2}, {"substeps": 2, "viscosity": 0.0}, {"substeps": 2, "viscosity": 5.0}):
        other = vademecum.open(file).scene(**options)
        other.pattern("pull", 1.0)
        other.step(20)
        other.clear()
        other.step(200)
        energies.append(other.energy)
    finer, kept, lost = energies
    assert kept > finer > lost > 0.0
    with pytest.raises(vademecum.Error, match="sub-steps"):
        vademecum.open(file).scene(substeps=1025)
