"""Files, runs, builds: the package beside the program."""

import dataclasses
import html
import json
import os
import pickle
import re
import signal
import time
import warnings
from pathlib import Path

import numpy as np
import pytest
from conftest import BEAM, PUSH

import vademecum


def program_json(program, *arguments):
    return json.loads(program(*arguments, "--json"))


def test_a_run_has_the_numbers_of_the_program(beam, block_beam, program, tmp_path):
    scenario = tmp_path / "push.toml"
    scenario.write_text(
        'duration = 0.5\n[[contact]]\npoint = [0.93, 0.031, 0.1]\nforce = [3.0, -8.0, -20.0]\nend = 0.1\n'
        '[[pattern]]\nname = "gravity"\nstart = 0.2\n[output]\nfields_every = 100\n'
    )
    for file in (beam, block_beam):
        path = file.save(tmp_path / "body.vdm")
        program("run", path, "--scenario", scenario, "-o", tmp_path / "out")
        table = np.genfromtxt(tmp_path / "out/probes.csv", delimiter=",", names=True)
        played = file.run(scenario)
        assert len(played.time) == 501 and played.values.any()
        columns = {"time_s": played.time, "energy_J": played.energy, **{f"{name}_m": column for name, column in played.probes.items()}}
        assert tuple(columns) == table.dtype.names
        for name, column in columns.items():
            assert [float(f"{value:.9e}") for value in column] == table[name].tolist(), name
        # A mapping is a scenario, too, and so is an opened file.
        again = vademecum.run(path, {**PUSH, "output": {"fields_every": 100}})
        assert np.array_equal(again.values, played.values)
        assert played.displacement.shape == (6, file.info.surface_nodes, 3) and played.field_time[-1] == 0.5


def test_a_body_has_the_bits_of_a_run(beam, block_beam):
    for file in (beam, block_beam):
        held = {"duration": 0.3, "contact": [{"point": [0.93, 0.031, 0.1], "force": [3.0, -8.0, -20.0]}]}
        played = file.run(held)
        body = file.body()
        body.push([0.93, 0.031, 0.1], [3.0, -8.0, -20.0])
        assert np.array_equal(body.march(300), played.values[1:])
        assert body.energy == played.energy[-1]


def test_info_is_what_the_program_prints(live_beam, program, tmp_path):
    file = live_beam.save(tmp_path / "body.vdm")
    printed = json.loads(program("info", file, "--json"))
    info = json.loads(json.dumps(dataclasses.asdict(vademecum.open(file).info)))

    def same(ours, theirs, place):
        if isinstance(ours, dict):
            for key, value in ours.items():
                if value is not None or key in theirs:
                    same(value, theirs[key], f"{place}.{key}")
        elif isinstance(ours, list):
            assert len(ours) == len(theirs), place
            for index, (a, b) in enumerate(zip(ours, theirs)):
                same(a, b, f"{place}[{index}]")
        else:
            # What is counted is whole here, and any number in JSON.
            assert ours == (int(theirs) if isinstance(ours, int) and not isinstance(ours, bool) else theirs), place

    same(info, printed, "info")
    missing = {"canonical", "contact_patch", "enrichment_history", "mode_table", "parameter_points", "ports"}
    missing |= {"parameter_witnesses", "radius_samples", "sha256"}
    assert set(printed) - set(info) == missing
    assert [p.name for p in live_beam.info.parameters] == ["tip stiffness", "damping"]
    assert live_beam.info.parameter("damping").range == (1e-5, 1e-4)
    assert live_beam.info.certificate.diagonal.spectral_radius <= 1 + 1e-12
    assert live_beam.info.precision == "float64"
    with pytest.raises(KeyError, match="tip stiffness"):
        live_beam.info.parameter("x")
    certificate = live_beam.info.certificate
    assert isinstance(certificate.good_for_steps, int) and isinstance(certificate.diagonal.steps, int)
    summary = str(live_beam.info)
    assert len(summary) < 1500 and "tip stiffness: 0.5 to 2" in summary and "gravity" in summary
    table = live_beam.info._repr_html_()
    assert table.startswith("<table>") and "tip stiffness" in table and "<script" not in table


def test_modes_are_those_of_the_program(program, tmp_path):
    problem = tmp_path / "beam.toml"
    problem.write_text(vademecum.build(BEAM).info.problem)
    ours = vademecum.modes(BEAM, 4)
    theirs = json.loads(program("modes", problem, "--count", 4, "--json"))
    assert list(ours.frequencies_hz) == theirs["frequencies_hz"] and ours.dofs == theirs["dofs"]
    assert vademecum.modes(problem, 4) == ours


def test_a_file_is_verified_against_its_own_problem(beam):
    found = beam.verify(PUSH)
    assert found.steps == 500 and found.trajectory_error < 0.05 and found.spectral_radius <= 1 + 1e-12
    assert found == dataclasses.replace(
        vademecum.verify(beam, PUSH, BEAM),
        full_order_seconds_per_step=found.full_order_seconds_per_step,
        vademecum_seconds_per_step=found.vademecum_seconds_per_step,
    )
    assert beam.check().sections == len(beam.info.sections)


def test_a_build_reports_and_stops(tmp_path):
    stages = []
    file = vademecum.build(BEAM, progress=lambda stage, done, total: stages.append(stage))
    assert file.report["modes"] == 6 and len(set(stages)) > 3
    assert file.to_bytes() == vademecum.build(BEAM, work=tmp_path / "work").to_bytes()
    assert any((tmp_path / "work").iterdir())

    class Enough(Exception):
        pass

    def refuse(*_):
        raise Enough

    with pytest.raises(Enough):
        vademecum.build(BEAM, progress=refuse)
    # A program that was started in the background ignores the signal unless it asks for it.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            vademecum.build(BEAM, progress=lambda *_: os.kill(os.getpid(), signal.SIGINT))
    finally:
        signal.signal(signal.SIGINT, before)


def test_failures_have_the_programs_words():
    def refused(error, words, **changes):
        with pytest.raises(error, match=words):
            vademecum.build({**BEAM, **changes})

    refused(vademecum.InputError, "(?s)materiel.*did you mean.*material", materiel=[])
    refused(vademecum.InputError, "poisson", material=[{"young": 2e9, "poisson": 0.7, "density": 1200.0}])
    refused(vademecum.MeshError, "nowhere.msh", mesh={"file": "nowhere.msh"})
    refused(vademecum.NumericsError, "try: check", support=[{"on": {"box": {"min": [-1, -1, -1], "max": [0.01, 0.01, 0.01]}}}])
    refused(vademecum.ToleranceMissed, "no structure keeps the tolerance", tolerance={"error": 1e-9, "floor_ratio": 1.0})
    refused(ValueError, "JSON compliant", time={"step": float("nan")})
    # A dict has no lines.
    for call in (
        lambda: vademecum.build({**BEAM, "materiel": []}),
        lambda: vademecum.build({**BEAM, "material": [{"young": 2e9, "poisson": 0.7, "density": 1200.0}]}),
        lambda: vademecum.build(BEAM).run({"duration": 0.1, "contacts": []}),
        lambda: vademecum.build(BEAM).run({"duration": -0.1}),
        lambda: vademecum.build({**BEAM, "support": [{"on": {"group": "nowhere"}}]}),
    ):
        with pytest.raises(vademecum.Error) as found:
            call()
        said = str(found.value)
        assert "dict" in said and "line" not in said and "TOML" not in said and not re.search(r"\w:\d", said), said
    with pytest.raises(vademecum.InputError, match="no load pattern `gravty`"):
        vademecum.build(BEAM).run({"duration": 0.1, "pattern": [{"name": "gravty"}]})


def test_frequency_responses_are_those_of_the_program(beam, live_beam, program, tmp_path):
    path = live_beam.save(tmp_path / "body.vdm")
    channels = ["--in", "0.93,0.03,0.1,-z", "--out", "tip", "--range", "1,200", "--points", "50"]
    theirs = json.loads(program("frf", path, *channels, "--set", "tip stiffness=1.5", "--json"))
    found = live_beam.frf(([0.93, 0.03, 0.1], "-z"), "tip", (1, 200), points=50, tip_stiffness=1.5)
    assert found.frequencies.tolist() == theirs["frequencies_hz"] and len(found.frequencies) > 50
    assert [[x.real, x.imag] for x in found.values["tip"]] == theirs["values"][0]
    assert dataclasses.asdict(found.peaks["tip"]) == theirs["peaks"][0]
    assert found.highest_mode_hz == theirs["highest_mode_hz"]
    own = vademecum.frf(path, "gravity", ["tip", ([0.5, 0.05, 0.1], [0, 0, 1])], frequencies=[10.0, 20.0], quantity="velocity")
    assert own.frequencies.tolist() == [10.0, 20.0] and list(own.values) == ["tip", "(0.5 0.05 0.1) along (0 0 1)"]
    assert np.abs(own.values["tip"]).max() < own.peaks["tip"].amplitude * (1 + 1e-12)
    wrong = [
        (dict(force="gravty", outputs="tip", range=(1, 2)), ValueError, "did you mean `gravity`"),
        (dict(force=([99, 0, 0], "z"), outputs="tip", range=(1, 2)), ValueError, "away from the loadable surface"),
        (dict(force="1,2,3", outputs="tip", range=(1, 2)), ValueError, "no channel"),
        (dict(force=3, outputs="tip", range=(1, 2)), TypeError, "a point and a direction, found 3"),
        (dict(force="gravity", outputs="tip"), TypeError, "`range` or `frequencies`"),
        (dict(force="gravity", outputs="tip", range=(2, 1)), ValueError, "ascending"),
        (dict(force="gravity", outputs="tip", range=(1, 2), quantity="jerk"), ValueError, "`acceleration`"),
    ]
    for arguments, error, words in wrong:
        with pytest.raises(error, match=words):
            beam.frf(**arguments)


def test_from_a_mesh_to_a_body_and_its_report(program, tmp_path):
    mesh = Path(__file__).parents[3] / "fixtures/meshes/bar/gmsh41.msh"
    found = vademecum.mesh(mesh)
    assert json.loads(json.dumps(dataclasses.asdict(found))) == program_json(program, "mesh", mesh)
    assert found.nodes > 8 and not found.problems and found.quality.min > 0
    with pytest.raises(vademecum.MeshError, match="nowhere.msh"):
        vademecum.mesh("nowhere.msh")
    proposed = vademecum.init(mesh, material="aluminium")
    text = proposed.save(tmp_path / "fork.toml").read_text(encoding="utf-8")
    theirs = program_json(program, "init", mesh, "--material", "aluminium", "-o", tmp_path / "theirs.toml")
    assert proposed.frequency == theirs["frequency"] and proposed.modes == theirs["modes"] and "aluminium" in text
    on_linear = proposed.linear_mesh_error
    assert on_linear and on_linear.frequencies[0].mesh == theirs["linear_mesh_error"]["frequencies"][0]["mesh"]
    assert vademecum.modes(proposed, 2) == vademecum.modes(tmp_path / "fork.toml", 2)
    with pytest.raises(ValueError, match="did you mean `steel`"):
        vademecum.init(mesh, material="stel")
    with pytest.raises(ValueError, match="positive"):
        vademecum.init(mesh, scale=-1.0)


def test_a_report_is_a_page_with_figures(beam, tmp_path):
    page = beam.save_report(tmp_path / "report.html")
    assert "<svg" in page.read_text(encoding="utf-8") and (tmp_path / "report-figures/mesh.svg").exists()
    with pytest.raises(TypeError, match="`problem` and `scenario`"):
        beam.save_report(tmp_path / "other.html", problem="beam.toml")
    with pytest.raises(vademecum.Error, match="nowhere"):
        vademecum.report(tmp_path / "nowhere.vdm")


def test_a_forked_child_computes(beam):
    before = vademecum.modes(BEAM, 4)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child == 0:
        done = False
        try:
            body = beam.body()
            done = vademecum.modes(BEAM, 4) == before and vademecum.build(BEAM).to_bytes() == beam.to_bytes()
            done = done and not body.step(3) and len(beam.run(PUSH).time) == 501
        finally:
            os._exit(0 if done else 1)
    for _ in range(1200):
        process, status = os.waitpid(child, os.WNOHANG)
        if process:
            assert os.waitstatus_to_exitcode(status) == 0
            return
        time.sleep(0.1)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    pytest.fail("the child hangs")


def test_notes_are_warnings(beam):
    with pytest.warns(vademecum.Note, match="nearest node"):
        probe = {"name": "new", "point": [0.51, 0.05, 0.2], "direction": [0, 0, 1]}
        played = beam.run({**PUSH, "output": {"probe": [probe]}})
    assert list(played.probes) == ["tip", "side", "new"]


def test_files_that_are_none(tmp_path):
    for kind in (vademecum.FileError, FileNotFoundError):
        with pytest.raises(kind, match="nowhere.vdm"):
            vademecum.open(tmp_path / "nowhere.vdm")
    with pytest.raises(vademecum.FileError, match="given.vdm"):
        vademecum.from_bytes(b"[mesh]", name="given.vdm")
    problem = tmp_path / "problem.toml"
    problem.write_text("[mesh]\n")
    with pytest.raises(vademecum.FileError, match="it looks like a problem file"):
        vademecum.open(problem)
    with pytest.raises(vademecum.FileError, match="folder|directory"):
        vademecum.open(tmp_path)
    fifo = tmp_path / "fifo.vdm"
    os.mkfifo(fifo)
    with pytest.raises(vademecum.FileError):
        vademecum.open(fifo)


def test_no_byte_of_a_file_can_end_python(beam):
    good, rng = beam.to_bytes(), np.random.default_rng(15)
    refused = 0
    for length in (0, 8, 100, len(good) // 2, len(good) - 1):
        with pytest.raises(vademecum.FileError):
            vademecum.from_bytes(good[:length])
    for place in rng.integers(0, len(good), 300):
        bad = bytearray(good)
        bad[place] ^= 1 << int(rng.integers(8))
        try:
            vademecum.from_bytes(bad).body().step(3)
        except vademecum.FileError:
            refused += 1
    assert refused > 280, "sections have checksums; only padding inside them is free"


def test_a_file_that_shrinks_on_the_disk_stays_in_memory(beam, tmp_path):
    path = beam.save(tmp_path / "body.vdm")
    file = vademecum.open(path)
    os.truncate(path, 10)
    body = file.body()
    body.push_pattern("gravity")
    body.step(10)
    assert body.whole().any() and file.to_bytes() == beam.to_bytes()


def test_a_map_gives_the_same(beam, tmp_path):
    file = vademecum.open(beam.save(tmp_path / "body.vdm"), map=True)
    body, other = file.body(), beam.body()
    for one in (body, other):
        one.push_pattern("gravity")
    assert np.array_equal(body.march(20), other.march(20))


def test_a_packed_file_is_unpacked(beam, program, tmp_path):
    file = beam.save(tmp_path / "body.vdm")
    program("pack", file, "-o", tmp_path / "small.vdm")
    small = vademecum.open(tmp_path / "small.vdm")
    assert len(small.to_bytes()) < len(beam.to_bytes())
    assert np.array_equal(small.run(PUSH).values, beam.run(PUSH).values)


def test_a_file_goes_to_another_process(beam):
    again = pickle.loads(pickle.dumps(beam))
    assert again.to_bytes() == beam.to_bytes() and again.info == beam.info


def test_geometry_and_meshio(beam, tmp_path):
    meshio = pytest.importorskip("meshio")
    assert beam.nodes.shape == (beam.info.nodes, 3) and beam.nodes.max(axis=0) == pytest.approx([1.0, 0.1, 0.1])
    assert beam.triangles.shape == (beam.info.triangles, 3) and beam.triangles.max() < beam.info.surface_nodes
    with pytest.raises(ValueError, match="read-only"):
        beam.nodes[0] = 0.0
    body = beam.body()
    body.push_pattern("gravity")
    body.step(50)
    beam.to_meshio(displacement=body.surface()).write(tmp_path / "moved.vtu")
    back = meshio.read(tmp_path / "moved.vtu")
    assert np.array_equal(back.point_data["displacement"], body.surface()) and body.surface().any()
    assert np.array_equal(back.cells_dict["triangle"], beam.triangles)
    played = beam.run({**PUSH, "output": {"fields_every": 250}})
    assert np.array_equal(played.to_meshio().point_data["velocity"], played.velocity[-1])


def cubes():
    """Two cubes: points, their bricks, the square at the end of the second."""
    points = [[x, y, z] for x in (0.0, 0.1, 0.2) for y in (0.0, 0.1) for z in (0.0, 0.1)]
    corners = [0, 4, 6, 2, 1, 5, 7, 3]
    return np.array(points), [[c + 4 * i for c in corners] for i in (0, 1)], [[8, 10, 11, 9]]


def test_a_mesh_of_meshio_becomes_a_body(tmp_path):
    meshio = pytest.importorskip("meshio")
    points, bricks, square = cubes()
    mesh = meshio.Mesh(
        points,
        [("hexahedron", bricks), ("quad", square)],
        cell_sets={"soft": [[1], []], "end": [[], [0]]},
        point_sets={"held": np.arange(4)},
    )
    problem = vademecum.problem_from_meshio(mesh, tmp_path / "cubes.inp", material="rubber", hold="held")
    assert "soft" in problem.text and 'group = "held"' in problem.text
    told = vademecum.mesh(tmp_path / "cubes.inp")
    assert {group.name for group in told.groups} >= {"held", "end"} and told.nodes == 12
    assert vademecum.build(problem).info.nodes == 12
    # Integers of cells are regions where there are no sets.
    marked = meshio.Mesh(points, [("hexahedron", bricks)], cell_data={"medit:ref": [np.array([1, 2])]})
    vademecum.problem_from_meshio(marked, tmp_path / "marked.inp", hold="x_min")
    assert [region.name for region in vademecum.mesh(tmp_path / "marked.inp").regions] == ["region 1", "region 2"]


def test_arrays_become_a_mesh_and_faulty_ones_are_named(tmp_path):
    points, bricks, _ = cubes()
    # The volume of curved elements tells the order of their nodes.
    corners = np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], float)
    edges = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
    faces = [(0, 3, 4, 7), (1, 2, 5, 6), (0, 1, 4, 5), (2, 3, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7), range(8)]
    whole = np.array([*corners, *(corners[list(e)].mean(axis=0) for e in edges), *(corners[list(f)].mean(axis=0) for f in faces)])
    x, y, z = whole.T
    bent = np.array([x + 0.1 * y * z, 1.3 * y - 0.07 * x * x, 0.8 * z + 0.09 * x * y]).T
    volumes = []
    for kind, count in (("hexahedron20", 20), ("hexahedron27", 27)):
        path = vademecum.write_mesh(tmp_path / f"{kind}.inp", bent[:count], {kind: [range(count)]})
        volumes.append(sum(region.volume for region in vademecum.mesh(path).regions))
    assert volumes[0] == pytest.approx(volumes[1], rel=0.02) and min(volumes) > 0.9
    for wrong, message in [
        (lambda: vademecum.write_mesh(tmp_path / "a.inp", points[:, :2], {"hexahedron": bricks}), "shape"),
        (lambda: vademecum.write_mesh(tmp_path / "a.inp", points, {"quad": [[0, 1, 2, 3]]}), "expected blocks"),
        (lambda: vademecum.write_mesh(tmp_path / "a.inp", points, {"tetra": bricks}), "4 nodes"),
        (lambda: vademecum.write_mesh(tmp_path / "a.inp", points[:5], {"hexahedron": bricks}), "0 to 4"),
    ]:
        with pytest.raises(ValueError, match=message):
            wrong()


def test_the_page_is_the_programs(beam, program, tmp_path):
    file = beam.save(tmp_path / "body.vdm")
    program("view", file, "--export", tmp_path / "theirs.html")
    page = vademecum.open(file).view(height=300)
    assert page.save(tmp_path / "ours.html").read_bytes() == (tmp_path / "theirs.html").read_bytes()
    frame = page._repr_html_()
    inside = frame.partition('srcdoc="')[2].removesuffix('"></iframe>')
    assert '"' not in inside and html.unescape(inside) == page.html and "height:300px" in frame


GOLDEN = Path(__file__).resolve().parents[3] / "fixtures/golden"


def test_an_embedded_surface_follows_the_nodes_of_the_surface():
    assert vademecum.open(GOLDEN / "fixed-f64.vdm").embedded is None
    file = vademecum.open(GOLDEN / "embedded.vdm")
    surface = file.embedded
    assert surface.nodes.shape == surface.weights.shape == (3, 4) and surface.triangles.tolist() == [[0, 1, 2]]
    expected = [sum(w * file.nodes[n] for n, w in zip(*vertex)) for vertex in zip(surface.nodes, surface.weights)]
    assert np.allclose(surface.interpolate(file.nodes), expected, rtol=0, atol=1e-15)
