"""Universal files in another program: nodes, modes and frequency responses that pyuff reads."""

import json

import numpy as np
import pyuff

# A node: a point of dataset 58 is one.
PLACE = "0.5,0.05,0.1,-z"


def test_another_program_reads_a_universal_file(beam, program, tmp_path):
    path, written = beam.save(tmp_path / "beam.vdm"), tmp_path / "beam.uff"
    channels = ["--in", PLACE, "--out", "tip", "--out", PLACE, "--range", "1,100", "--points", "20"]
    program("export", "uff", path, *channels, "-o", written)
    sets = pyuff.UFF(str(written)).read_sets()
    kinds = [found["type"] for found in sets]
    assert kinds == [164, 15, 82] + [55] * 6 + [58] * 2
    units, nodes, lines = sets[:3]
    assert (units["units_code"], units["length"], units["force"]) == (1, 1.0, 1.0)
    surface = beam.nodes[: len(nodes["node_nums"])]
    assert np.allclose(np.transpose([nodes["x"], nodes["y"], nodes["z"]]), surface, atol=1e-5)
    assert len(nodes["node_nums"]) == beam.info.surface_nodes
    drawn = np.reshape(lines["nodes"], (-1, 3))
    assert set(drawn[:, :2].ravel()) <= set(nodes["node_nums"]) and not drawn[:, 2].any()
    model = beam.state_space("gravity", "tip")
    modes = sets[3:9]
    assert np.allclose([mode["freq"] for mode in modes], model.frequencies, rtol=1e-5)
    assert np.allclose([mode["modal_damp_vis"] for mode in modes], model.damping_ratios, rtol=1e-5)
    assert [mode["modal_m"] for mode in modes] == [1.0] * 6
    # The tip moves along z by its row of C.
    tip = np.flatnonzero(np.linalg.norm(surface - [1.0, 0.05, 0.1], axis=1) < 1e-9)
    own = [mode["r3"][tip[0]] for mode in modes]
    assert np.allclose(own, model.C[0, :6], rtol=1e-4, atol=1e-4 * np.abs(own).max())
    response = sets[9]
    theirs = json.loads(program("frf", path, *channels[:4], *channels[6:], "--json"))
    values = np.array(theirs["values"][0])
    assert np.allclose(response["x"], theirs["frequencies_hz"], rtol=1e-5)
    assert np.allclose(response["data"], values[:, 0] + 1j * values[:, 1], rtol=1e-11)
    assert (response["func_type"], response["rsp_dir"], response["ref_dir"]) == (4, 3, -3)
    assert (response["ordinate_spec_data_type"], response["orddenom_spec_data_type"]) == (8, 13)
