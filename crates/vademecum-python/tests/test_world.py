"""Worlds: parts that touch and turn, by hand and from an assembly file."""

import threading

import numpy as np
import pytest

import vademecum

RUBBER = {
    "material": [{"young": 1e6, "poisson": 0.3, "density": 1000.0}],
    "damping": {"ratio": 0.2},
    "time": {"step": 1e-3},
    "basis": {"modes": 12},
    "tolerance": {"error": 10.0},
}
CUBE = {**RUBBER, "mesh": {"block": {"lengths": [0.08, 0.08, 0.08], "divisions": [4, 4, 4], "order": "linear"}}}
BASE = {
    **RUBBER,
    "mesh": {"block": {"lengths": [0.16, 0.16, 0.08], "divisions": [6, 6, 3], "order": "linear"}},
    "support": [{"on": {"group": "z_min"}}],
    "load": {"pattern": [{"name": "gravity", "acceleration": [0, 0, -9.81]}]},
}
LINK = {
    "mesh": {"block": {"lengths": [0.2, 0.02, 0.02], "divisions": [10, 1, 1]}},
    "material": [{"young": 2e9, "poisson": 0.3, "density": 1200.0}],
    "port": [
        {"name": "start", "kind": "frame", "on": {"group": "x_min"}, "axes": [[1, 0, 0], [0, 0, 1]]},
        {"name": "end", "kind": "frame", "on": {"group": "x_max"}, "axes": [[1, 0, 0], [0, 0, 1]]},
    ],
    "basis": {"modes": 6},
    "tolerance": {"error": 1.0},
}
GRAVITY = [0.0, 0.0, -9.81]
WEIGHT = 0.08**3 * 1000.0 * 9.81

DROP = """
format = 1
[world]
time = 0.3
step = 1e-3
gravity = [0.0, 0.0, -9.81]
[[part]]
name = "cube"
file = "cube.vdm"
position = [0.04, 0.04, 0.085]
[[part]]
name = "base"
file = "base.vdm"
[[contact]]
between = ["cube", "base"]
friction = 0.5
restitution = 0.5
nodes = "first"
[[output]]
part = "cube"
"""


@pytest.fixture(scope="session")
def cube():
    return vademecum.build(CUBE, keep_missed=True)


@pytest.fixture(scope="session")
def base():
    return vademecum.build(BASE, keep_missed=True)


@pytest.fixture(scope="session")
def link():
    return vademecum.build(LINK, keep_missed=True)


def dropped(cube, base, **options):
    world = vademecum.World(step=1e-3, gravity=GRAVITY)
    assert world.add(cube, [0.04, 0.04, 0.085], name="cube", **options) == "cube"
    world.add(base, name="base")
    world.touch("cube", "base", friction=0.5, restitution=0.5, nodes="first")
    return world


def chain(link):
    world = vademecum.World(step=1e-3, gravity=GRAVITY)
    for number in range(3):
        world.add(link, [0.2 * number, 0.0, 0.0], name=f"link{number}")
    assert world.join("hinge", "link0.start", "ground") == "joint1"
    world.join("hinge", "link0.end", "link1.start", name="knee")
    world.join("ball", "link1.end", "link2.start", name="ball")
    return world


def test_a_cube_falls_and_rests_on_its_base(cube, base):
    world = dropped(cube, base)
    assert world.part_names == ["cube", "base"] and world.time_step == 1e-3 and world.joint_names == []
    assert len(world.contacts) == 0
    report = world.step(1500)
    assert report.steps == 1500 and world.time == pytest.approx(1.5)
    assert report.steps_not_converged == 0 and report.steps_without_room == 0
    assert 0 < report.pressed <= report.contacts and report.energy_given_away > 0.0
    assert report.sweeps >= report.steps - 200
    force = world.contact_force("cube", "base")
    assert force[2] == pytest.approx(WEIGHT, rel=1e-2), "the base carries the cube"
    assert np.array_equal(force, -world.contact_force("base", "cube"))
    contacts = world.contacts
    assert len(contacts) == report.contacts and contacts.force.sum(axis=0) == pytest.approx(force)
    assert (contacts.parts == [0, 1]).all() and (contacts.pressure >= 0.0).all()
    assert np.count_nonzero(contacts.pressure) == report.pressed
    assert contacts.position[:, 2] == pytest.approx(0.08, abs=1e-3)
    assert contacts.normal == pytest.approx(np.tile([0.0, 0.0, 1.0], (len(contacts), 1)), abs=0.05)
    assert (np.abs(contacts.gap) < 1e-3).all() and (np.abs(contacts.slip) < 1e-6).all()
    surface = world.surface("cube")
    assert surface.shape == (cube.info.surface_nodes, 3) and surface[:, 2].min() == pytest.approx(0.08, abs=1e-3)
    assert np.array_equal(world.triangles("cube"), cube.triangles)
    frames = np.zeros((2, *surface.shape))
    assert np.shares_memory(world.surface("cube", out=frames[1]), frames) and np.array_equal(frames[1], surface)
    assert world.potential == pytest.approx(WEIGHT * world.motion("cube").position[2])
    assert 0.0 < world.energy < 1e-2


def test_places_are_read_in_space_and_in_the_part(cube, base):
    world = dropped(cube, base)
    world.step(40)
    corner = world.locate("cube", [0.08, 0.08, 0.08])
    node = int(np.argmin(np.linalg.norm(cube.nodes[: cube.info.surface_nodes] - 0.08, axis=1)))
    assert world.in_space("cube", corner) == pytest.approx(world.surface("cube")[node], abs=1e-6)
    position, quaternion = world.pose("cube")
    assert np.linalg.norm(quaternion) == pytest.approx(1.0)
    moved = world.point("cube", corner)
    assert world.in_space("cube", corner) == pytest.approx(position + 0.08 + moved, abs=1e-4)
    assert world.in_space("cube", corner, "velocity")[2] < 0.0 or world.motion("cube").momentum[2] > 0.0
    zeta, velocity = world.coordinates("cube")
    assert zeta.shape == velocity.shape == (12,)
    assert world.pose("base")[0].tolist() == [0.0, 0.0, 0.0]


def test_an_assembly_file_and_the_same_by_hand_have_the_same_bits(cube, base, tmp_path, program):
    cube.save(tmp_path / "cube.vdm")
    base.save(tmp_path / "base.vdm")
    (tmp_path / "drop.toml").write_text(DROP)
    opened, made = vademecum.World.open(tmp_path / "drop.toml"), dropped(cube, base)
    assert opened.part_names == made.part_names
    program("run", tmp_path / "drop.toml", "-o", tmp_path / "drop.csv")
    table = np.genfromtxt(tmp_path / "drop.csv", delimiter=",", skip_header=1)
    assert len(table) == 301
    for row in table[1:]:
        opened.step()
        made.step()
        assert opened.outputs["cube"].tolist() == row[2:5].tolist()
        assert opened.energy + opened.potential == row[1]
    assert np.array_equal(opened.surface("cube"), made.surface("cube")) and made.outputs == {}


def test_a_world_comes_back_bit_by_bit(cube, base):
    world = dropped(cube, base)
    world.add_box([0.02, 0.02, 0.02], [0.0, 0.0, 0.105], [0.6, 0.0, 0.8, 0.0], spin=[1.0, 2.0, 3.0], density=500.0, name="die")
    world.add_box([1.0, 1.0, 0.1], [-0.5, -0.5, -0.1], name="floor")
    world.touch("die", "base", friction=0.3)
    world.lead("base", [0.001, 0.0, 0.0], [0.96, 0.28, 0.0, 0.0])
    world.lead("base", [0.0, 0.0, 0.0])
    world.step(60)
    saved = world.save()
    parts = ["cube", "base", "die"]

    def state():
        return [world.surface(part).tobytes() for part in parts], world.energy, world.contacts.force.tobytes(), world.time

    world.lead("base", [0.0, 0.0, 0.001], [0.8, 0.0, 0.0, 0.6])
    world.step(100)
    world.restore(bytearray(saved))
    assert world.save() == saved and world.time == pytest.approx(0.06)
    ends = []
    for _ in range(2):
        world.restore(saved)
        world.step(100)
        ends.append(state())
    assert ends[0] == ends[1]
    now = world.save()
    for wrong in (saved[1:], saved[:-8], saved + bytes(8), saved[:16] + bytes([9]) + saved[17:]):
        with pytest.raises(ValueError, match="no saved world|another world"):
            world.restore(wrong)
        assert world.save() == now, "nothing has changed"
    with pytest.raises(ValueError, match="another world"):
        dropped(cube, base).restore(saved)
    with pytest.raises(TypeError, match="expected bytes"):
        world.restore("saved")


def test_a_chain_swings_and_a_joint_breaks(link):
    world = chain(link)
    total = world.energy + world.potential
    world.step(300)
    assert world.energy + world.potential == pytest.approx(total, abs=2e-3 * abs(total))
    weight = 3 * 0.2 * 0.02**2 * 1200.0 * 9.81
    assert world.joint_force("joint1").shape == (6,) and np.linalg.norm(world.joint_force("joint1")[:3]) > 0.5 * weight
    ends = [world.in_space("link0", [0.2, 0.01, 0.01]), world.in_space("link1", [0.0, 0.01, 0.01])]
    assert ends[0] == pytest.approx(ends[1], abs=1e-4), "the knee holds"
    assert not world.is_broken("knee")
    world.break_joint("knee")
    assert world.is_broken("knee")
    lower = [np.array(world.motion(part).momentum) for part in ("link1", "link2")]
    world.step(10)
    assert not world.joint_force("knee").any()
    fallen = sum(np.array(world.motion(part).momentum) for part in ("link1", "link2")) - sum(lower)
    assert fallen == pytest.approx([0.0, 0.0, -2 / 3 * weight * 0.01], abs=1e-9), "two links fall together"
    with pytest.raises(ValueError, match="the world has no joint `kne`; it has `joint1`, `knee`, `ball`"):
        world.break_joint("kne")


def test_loads_act_in_space_for_one_step(cube, base):
    world = vademecum.World(step=1e-3)
    world.add(cube, [0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0], name="free")
    world.add(base, [0.0, 0.0, 2.0], [0.0, 1.0, 0.0, 0.0], name="held")
    world.add_box([0.1, 0.1, 0.1], density=1000.0, name="box")
    world.push("free", [0.04, 0.04, 0.08], [0.0, 0.0, 5.0])
    world.pull("free", [1.0, 0.0, 0.0])
    world.push("held", [0.08, 0.08, 0.08], [0.0, 0.0, -50.0])
    world.push("box", [0.05, 0.05, 0.0], [0.0, 2.0, 0.0])
    world.step(2)
    assert world.motion("free").momentum == pytest.approx((1e-3, 0.0, 5e-3), abs=1e-12)
    assert world.motion("box").momentum == pytest.approx((0.0, 2e-3, 0.0), abs=1e-15)
    assert world.motion("box").angular_momentum[0] == pytest.approx(2e-3 * 0.05)
    moved = world.point("held", [0.08, 0.08, 0.08])
    assert moved[2] > 0.0, "down in space is up in the part, which is upside down"
    assert world.in_space("held", [0.08, 0.08, 0.08])[2] < 2.0 - 0.08
    world.push_pattern("held", "gravity", 2.0)
    with pytest.raises(ValueError, match="the file has no load pattern `gravit`"):
        world.push_pattern("held", "gravit")
    world.set_motion("box", vademecum.Motion([0.0, 0.0, 3.0]))
    assert world.pose("box")[0] == pytest.approx([-0.05, -0.05, 2.95])
    assert world.in_space("box", [0.1, 0.1, 0.1]) == pytest.approx([0.05, 0.05, 3.05])
    assert world.in_space("box", [0.1, 0.1, 0.1], "velocity").tolist() == [0.0, 0.0, 0.0]


def test_a_surface_of_arrays_is_a_rigid_body(cube):
    nodes = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    world = vademecum.World(step=1e-3, gravity=GRAVITY)
    world.add(cube)
    world.add_surface(nodes, triangles, [5.0, 0.0, 0.0], density=600.0, name="corner")
    world.step(10)
    assert world.motion("corner").momentum[2] == pytest.approx(-100.0 * 9.81 * 0.01)
    assert world.surface("corner").shape == (4, 3)
    with pytest.raises(ValueError, match="rigid body, which has no modes"):
        world.coordinates("corner")


def test_what_no_world_can_have_is_refused(cube, base, link, tmp_path):
    world = dropped(cube, base)
    refused = [
        (lambda: world.add(cube, name="cube"), vademecum.InputError, "a name .* that no other part has"),
        (lambda: world.add(cube, quaternion=[1, 1, 0, 0]), vademecum.InputError, "unit quaternion"),
        (lambda: world.touch("cube", "bas"), ValueError, "the world has no part `bas`; it has `cube`, `base`"),
        (lambda: world.touch("cube", "base"), vademecum.InputError, "a pair that is named once"),
        (lambda: world.touch("cube", "base", nodes="all"), ValueError, "expected `both`, `first` or `second`"),
        (lambda: world.join("weld", "cube.a", "base.b"), ValueError, "expected `ball`, `hinge`"),
        (lambda: world.add(cube, time_step=1e-3), TypeError, "that of the world"),
        (lambda: world.add(7), TypeError, "expected a File"),
        (lambda: world.add(tmp_path / "none.vdm"), FileNotFoundError, "none.vdm"),
        (lambda: world.add_box([1, 1, -1]), vademecum.InputError, "lengths above 0"),
        (lambda: vademecum.World.open(tmp_path / "none.toml"), vademecum.Error, "none.toml"),
        (lambda: vademecum.World(step=1e-3).step(), vademecum.InputError, "at least one"),
    ]
    for call, error, words in refused:
        with pytest.raises(error, match=words):
            call()
    assert "has not begun" in repr(world)
    world.step()
    assert "2 parts" in repr(world)
    for call, words in (
        (lambda: world.add(cube), "the world has begun"),
        (lambda: world.surface("cub"), "the world has no part `cub`"),
        (lambda: world.motion("base"), "does not move freely"),
        (lambda: world.lead("cube", [0, 0, 0]), "moves freely"),
        (lambda: world.lead("base", [0, 0, np.nan]), "not finite"),
        (lambda: world.push("cube", [0.04, 0.04, 0.08], [0, 0, np.inf]), "not finite"),
    ):
        with pytest.raises(ValueError, match=words):
            call()
    joined = vademecum.World()
    joined.add(link, name="link")
    joined.join("hinge", "link.middle", "ground")
    with pytest.raises(vademecum.InputError, match="a port, `part.port`, one of link.start, link.end"):
        joined.step()
    over = vademecum.World()
    over.add(cube, [0.04, 0.04, 0.07], name="cube")
    over.add(base, name="base")
    over.touch("cube", "base")
    with pytest.raises(vademecum.InputError, match="overlap by 1.000e-2 m at the start"):
        over.step()


def test_other_threads_run_while_a_world_steps(cube, base):
    world, turns = dropped(cube, base), []
    world.step()
    stepping = threading.Thread(target=lambda: world.step(3000))
    stepping.start()
    while stepping.is_alive():
        turns.append(1)
        try:
            world.time
        except RuntimeError as error:
            assert "in use by another thread" in str(error)
            turns.append("refused")
            break
    stepping.join()
    assert "refused" in turns and world.time == pytest.approx(3.001)
