"""State-space models: the march of a run, the response of the equation of motion, and files that others read."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import scipy.signal

import vademecum
from conftest import BEAM, live

PAGE = Path(__file__).parents[3] / "docs/how-to/state-space.md"
PLACE = [0.93, 0.031, 0.1]
MATRICES = ["A", "B", "C", "D", "Ad", "Bd_start", "Bd_end", "Bd_held", "Bd_linear", "Dd_linear"]
# A step and instants that are sums of powers of two: the march and the run have the same ones.
STEP = 2.0**-10


def problem(**damping):
    return {**BEAM, "time": {"step": STEP}, "damping": damping, "output": {**BEAM["output"], "static_fields": True}}


@pytest.fixture(scope="module")
def files():
    return {
        "beta": vademecum.build(problem(alpha=2.0, beta=5e-5)),
        "ratio": vademecum.build(problem(ratio=0.02)),
    }


@pytest.mark.parametrize("damping", ["beta", "ratio"])
def test_a_march_in_numpy_is_the_run(files, damping):
    file = files[damping]
    model = file.state_space([(PLACE, "-z"), "gravity"], ["tip", "side", (PLACE, "z"), "velocity:0.93,0.031,0.1,z"])
    probe = {"name": "pushed", "point": PLACE, "direction": [0, 0, 1], "at": "surface"}
    scenario = {
        "duration": 0.25,
        "contact": [{"point": PLACE, "force": [0, 0, -20.0], "ramp": 0.03125, "end": 0.125}],
        "pattern": [{"name": "gravity", "table": [[0.0, 0.0], [0.0625, 1.0], [0.0625, -0.5], [0.25, 0.5]]}],
        "output": {"probe": [probe, {**probe, "name": "rate", "quantity": "velocity"}]},
    }
    played = file.run(scenario)
    steps = len(played.time) - 1
    assert steps == 256
    x, rows = np.zeros(len(model.states)), []
    for step in range(steps):
        at, end = step * STEP, (step + 1) * STEP
        force = 20 * np.minimum(1, np.array([at, end]) / 0.03125) if at < 0.125 else np.zeros(2)
        gravity = np.array([at, end]) / 0.0625 if at < 0.0625 else -0.5 + (np.array([at, end]) - 0.0625) / 0.1875
        u = np.array([force, gravity])
        x = model.Ad @ x + model.Bd_start @ u[:, 0] + model.Bd_end @ u[:, 1]
        rows.append(model.C @ x + model.D @ u[:, 1])
    marched = np.array(rows)
    difference = np.abs(marched - played.values[1:]).max(axis=0) / np.abs(played.values).max(axis=0)
    assert (difference < 1e-12).all(), difference


@pytest.mark.parametrize("damping", ["beta", "ratio"])
def test_the_continuous_model_is_the_equation_of_motion(files, damping):
    file = files[damping]
    inputs, outputs = [(PLACE, "-z"), "gravity"], ["tip", (PLACE, "z")]
    model = file.state_space(inputs, outputs)
    frequencies = [1.0, 9.5, 40.0, 400.0]
    for column, given in enumerate(inputs):
        found = file.frf(given, outputs, frequencies=frequencies)
        values = np.array(list(found.values.values()))
        for place, frequency in enumerate(frequencies):
            pencil = 2j * np.pi * frequency * np.eye(len(model.A)) - model.A
            own = model.C @ np.linalg.solve(pencil, model.B[:, column]) + model.D[:, column]
            assert (np.abs(own - values[:, place]) < 1e-10 * np.abs(values).max(axis=1)).all()
    for method, theirs in [("zoh", model.held), ("foh", model.linear)]:
        discrete = scipy.signal.cont2discrete(model.continuous, model.time_step, method)
        for found, own in zip(discrete, theirs):
            assert np.allclose(found, own, rtol=0, atol=1e-10 * max(np.abs(own).max(), 1e-300)), method


def test_other_programs_read_the_files(files, program, tmp_path):
    path = files["beta"].save(tmp_path / "beam.vdm")
    signals = ["--in", "0.93,0.031,0.1,-z", "--in", "gravity", "--out", "tip", "--out", "acceleration:tip"]
    program("export", "state-space", path, *signals, "-o", tmp_path / "model")
    model = files["beta"].state_space(["0.93,0.031,0.1,-z", "gravity"], ["tip", "acceleration:tip"])
    folder = tmp_path / "model"
    arrays, matlab = np.load(folder / "state-space.npz"), scipy.io.loadmat(folder / "state-space.mat")
    for name in MATRICES:
        own = getattr(model, name)
        assert np.array_equal(arrays[name], own) and np.array_equal(matlab[name], own), name
        assert np.array_equal(scipy.io.mmread(folder / f"{name}.mtx"), own), name
    assert arrays["time_step"].item() == matlab["time_step"].item() == model.time_step == STEP
    for side in ["state", "input", "output"]:
        signals = getattr(model, side + "s")
        for what, own in [("names", list(signals)), ("units", list(signals.values()))]:
            cells = [cell.item() for cell in matlab[f"{side}_{what}"][:, 0]]
            assert arrays[f"{side}_{what}"].tolist() == cells == own
    assert model.outputs == {"tip": "m", "acceleration:tip": "m/s²"} and list(model.states)[-1] == "filtered gravity"
    described = json.loads((folder / "state-space.json").read_text(encoding="utf-8"))
    assert [row["name"] for row in described["matrices"]] == MATRICES


def test_what_a_file_does_not_have_is_refused(beam, live_beam, block_beam):
    assert repr(beam.state_space()) == "<StateSpace with 13 states, 1 inputs and 2 outputs>"
    softer = live_beam.state_space(tip_stiffness=0.5)
    assert softer.frequencies[0] < live_beam.state_space(tip_stiffness=2.0).frequencies[0]
    with pytest.raises(ValueError, match="did you mean `gravity`"):
        beam.state_space("gravty")
    with pytest.raises(ValueError, match="is no output"):
        beam.state_space("gravity", "stress:0,0,xx")
    with pytest.raises(ValueError, match="`tip` is given twice"):
        beam.state_space("gravity", ["tip", "tip"])
    with pytest.raises(TypeError, match="found 3"):
        beam.state_space(3)
    with pytest.raises(vademecum.FileError, match="time scheme"):
        block_beam.state_space()


def test_the_page_runs(program, tmp_path, monkeypatch, capsys):
    text = PAGE.read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    blocks = {kind: re.findall(rf"^```{kind}\n(.*?)^```", text, re.MULTILINE | re.DOTALL) for kind in ("toml", "python", "text")}
    for block in blocks["toml"]:
        Path(block.split("\n", 1)[0].removeprefix("# ")).write_text(block, encoding="utf-8")
    program("build", "arm.toml", "-o", "arm.vdm")
    names = {}
    for block in blocks["python"]:
        exec(compile(block, str(PAGE), "exec"), names)
    # The lines of the page; where a motion grows without bound, the digits are those of the machine.
    said, shown = capsys.readouterr().out.splitlines(), blocks["text"][-1].splitlines()
    assert [line.split(":")[0] for line in said] == [line.split(":")[0] for line in shown]
    assert said[:4] == shown[:4]
