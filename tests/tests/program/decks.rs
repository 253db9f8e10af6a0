//! Decks as their users have them, against the answers of their own programs (`shared/decks/README.md`).

use std::path::PathBuf;

use serde_json::Value;
use vademecum_tests::program::vademecum;
use vademecum_tests::shared::shared;

/// The path of a deck, where the folder is there.
fn deck(name: &str) -> Option<PathBuf> {
    shared(&format!("decks/{name}"))
}

/// JSON that a command prints of a deck.
fn answer(command: &str, name: &str) -> Option<Value> {
    let path = deck(name)?;
    let ran = vademecum(&[command, path.to_str().expect("a path in UTF-8"), "--json"]);
    assert_eq!(ran.code, Some(0), "{name}: {}", ran.stderr);
    Some(ran.json())
}

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().unwrap_or_else(|| panic!("no list in {value}"));
    list.iter().map(|number| number.as_f64().expect("a number")).collect()
}

/// Frequencies of a deck; the last digit of each expected one is printed.
fn check_modes(name: &str, units: Option<&str>, expected: &[f64], tolerance: f64) {
    let Some(found) = answer("modes", name) else { return };
    assert_eq!(found["units"].as_str(), units, "{name}");
    let frequencies = numbers(&found["frequencies_hz"]);
    assert!(frequencies.len() >= expected.len(), "{name}: {frequencies:?}");
    for (found, expected) in frequencies.iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < tolerance, "{name}: {frequencies:?}, not {expected} Hz");
    }
}

/// The largest displacement of the first static step.
fn check_static(name: &str, expected: f64, tolerance: f64) -> Option<Value> {
    let found = answer("static", name)?;
    let step = found["steps"][0].clone();
    let largest = step["largest_displacement"].as_f64().expect("a number");
    assert!((largest / expected - 1.0).abs() < tolerance, "{name}: {largest:e}, not {expected:e}");
    // What double precision leaves of a slender cantilever.
    assert!(step["residual"].as_f64().expect("a number") < 1e-7, "{name}: {step}");
    Some(step)
}

#[test]
fn frequencies_of_decks_are_those_of_their_programs() {
    // Six digits are printed.
    check_modes(
        "exudyn/blockC3D8.inp",
        Some("m-kg-N"),
        &[438.775, 438.775, 555.888, 967.040, 967.040, 1028.046],
        2e-6,
    );
    check_modes(
        "exudyn/blockC3D20.inp",
        Some("m-kg-N"),
        &[449.764, 449.764, 595.757, 1011.616, 1011.616, 1033.232],
        2e-6,
    );
    let beam = [12.6610, 35.5584, 50.4693, 112.858];
    check_modes("freecad/frequency_beamsimple.inp", Some("mm-t-N"), &beam, 5e-6);
    check_modes("calculix/mass2.inp", Some("mm-t-N"), &[197.640, 293.471, 2395.39], 4e-6);
    check_modes("precice/frequency.inp", Some("m-kg-N"), &[0.613501, 3.536717, 7.601942], 1e-6);
    check_modes("calculix/dloadlin20f.inp", Some("mm-t-N"), &[9.482967, 59.57710, 168.5564, 183.5669], 1e-6);
    let bar = [185.460, 185.460, 285.639, 434.315, 434.315];
    check_modes("ansys/HexBeam.cdb", Some("m-kg-N"), &bar, 3e-6);
    let plate = [13798.13, 19852.05, 81356.76, 88787.12, 109446.1, 163403.6];
    check_modes("calculix/beam8f.inp", Some("mm-t-N"), &plate, 1e-6);
}

#[test]
fn static_steps_of_decks_are_those_of_their_programs() {
    check_static("freecad/constraint_tie.inp", 3.99314, 2e-6);
    check_static("freecad/constraint_selfweight_cantilever.inp", 577.864, 2e-6);
    check_static("freecad/ccx_cantilever_ele_hexa20.inp", 87.5477, 2e-6);
    check_static("freecad/constraint_transform_torque.inp", 3.33980e-2, 2e-6);
    if let Some(step) = check_static("nastran/solid_bending.bdf", 1.237627e-2, 1e-6) {
        assert_eq!(step["node"].as_u64(), Some(23), "{step}");
        let sum = numbers(&step["reaction_sum"]);
        assert!((sum[0] / -23000.0 - 1.0).abs() < 1e-9, "{step}");
        let at = numbers(&step["displacement"]);
        for (found, expected) in at.iter().zip([0.0121105, 1.5404e-4, 2.54622e-3]) {
            // Five digits are printed.
            assert!((found / expected - 1.0).abs() < 5e-5, "{step}");
        }
    }
    // CHEXA of another formulation: the largest displacement is the stretch of the bar, and agrees.
    if let Some(step) = check_static("nastran/rigid_rbe2.bdf", 3.939e-6, 2e-3) {
        let sum = numbers(&step["reaction_sum"]);
        // Theirs is a sum in single precision: its other components are 1e-2.
        assert!((sum[2] / 423.853 - 1.0).abs() < 1e-5, "{step}");
    }
}

/// Displacements of node 100 of `beamdy1`, along y, at multiples of 1e-5 s \[mm\].
const BEAMDY1: [f64; 10] = [
    -3.917054e-2,
    -1.046704e-1,
    -1.126540e-1,
    -5.263218e-2,
    -3.658394e-3,
    -3.037663e-2,
    -9.801968e-2,
    -1.200060e-1,
    -6.679581e-2,
    -8.781502e-3,
];

/// Displacements of node 2 of `dashpot1`, along x, at multiples of 1e-6 s \[mm\].
const DASHPOT1: [f64; 40] = [
    3.001669e-2,
    1.096747e-1,
    2.199702e-1,
    3.402373e-1,
    4.514270e-1,
    5.386276e-1,
    5.926487e-1,
    6.105243e-1,
    5.949968e-1,
    5.532753e-1,
    4.953267e-1,
    4.320339e-1,
    3.734374e-1,
    3.274079e-1,
    2.988115e-1,
    2.892393e-1,
    2.972706e-1,
    3.191314e-1,
    3.495775e-1,
    3.828843e-1,
    4.137616e-1,
    4.380551e-1,
    4.531894e-1,
    4.583130e-1,
    4.541605e-1,
    4.427099e-1,
    4.267141e-1,
    4.091867e-1,
    3.929154e-1,
    3.800930e-1,
    3.720828e-1,
    3.693409e-1,
    3.714871e-1,
    3.774857e-1,
    3.858895e-1,
    3.951129e-1,
    4.036870e-1,
    4.104544e-1,
    4.146936e-1,
    4.161607e-1,
];

#[test]
fn modal_dynamic_steps_are_built_and_run_as_by_their_program() {
    // Seven digits are printed.
    check_modal_dynamics("calculix/beamdy1.inp", "N100.y", &BEAMDY1, 5e-7);
    // Theirs integrates the dashpot step by step, and comes closer with smaller steps.
    check_modal_dynamics("calculix/dashpot1.inp", "N2.x", &DASHPOT1, 5e-4);
}

/// A probe of a deck that is built and run, at the printed instants \[mm\].
fn check_modal_dynamics(name: &str, probe: &str, expected: &[f64], tolerance: f64) {
    let Some(deck) = deck(name) else { return };
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (problem, file, scenario) = (at("beam.toml"), at("beam.vdm"), at("beam.scenario.toml"));
    let run = |arguments: &[&str]| {
        let ran = vademecum(arguments);
        assert_eq!(ran.code, Some(0), "{arguments:?}: {}", ran.stderr);
    };
    run(&["init", deck.to_str().unwrap(), "-o", &problem]);
    run(&["build", &problem, "-o", &file]);
    run(&["run", &file, "--scenario", &scenario, "-o", &at("out")]);
    let table = std::fs::read_to_string(at("out/probes.csv")).unwrap();
    let mut rows = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let names = rows.next().unwrap();
    let column = names.iter().position(|name| name.starts_with(probe)).expect("a probe at the node");
    let found: Vec<f64> = rows.map(|row| 1000.0 * row[column].parse::<f64>().unwrap()).collect();
    let every = (found.len() - 1) / expected.len();
    assert_eq!(found.len(), 1 + every * expected.len(), "{name}");
    for (found, expected) in found[every..].iter().step_by(every).zip(expected) {
        assert!((found / expected - 1.0).abs() < tolerance, "{name}: {found:e}, not {expected:e}");
    }
}
