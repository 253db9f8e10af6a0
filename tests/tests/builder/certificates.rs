//! What a certificate says is true of every run behind it, and a file that errs by much is not written.

use std::path::Path;

use serde_json::Value;
use vademecum_build::mesh::{Order, block};
use vademecum_tests::program::{Ran, vademecum};

/// A beam of quadratic tetrahedra that is built in a second; `mesh` and `more` are tables of the problem
/// file.
fn problem(mesh: &str, step: &str, more: &str) -> String {
    let scheme = if step.contains("scheme") { "" } else { "scheme.name = \"bathe\"\n" };
    format!(
        "{mesh}\n[[material]]\nyoung = 2e9\npoisson = 0.3\ndensity = 1200.0\n[[support]]\non = {{ plane = {{ axis = \
         \"x\", at = 0.0 }} }}\n[load]\n[time]\n{scheme}step = {step}\n[snapshots]\npositions = 4\n{more}"
    )
}

fn beam(step: &str, more: &str) -> String {
    problem("[mesh]\nblock = { lengths = [1.0, 0.1, 0.1], divisions = [6, 1, 1] }", step, more)
}

/// Builds a problem in a folder; JSON on standard output.
fn build(folder: &Path, text: &str) -> Ran {
    let [toml, vdm] = ["p.toml", "p.vdm"].map(|name| folder.join(name).display().to_string());
    std::fs::write(&toml, text).expect("written");
    vademecum(&["build", &*toml, "-o", &*vdm, "--json"])
}

fn certificate(text: &str) -> (Value, Value) {
    let folder = tempfile::tempdir().expect("a folder");
    let built = build(folder.path(), text).json();
    let file = folder.path().join("p.vdm").display().to_string();
    let info = vademecum(&["info", &*file, "--json"]).json();
    (built, info["certificate"].clone())
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is a number"))
}

#[test]
fn both_structures_of_a_basis_show_the_same_floor_and_the_largest_error_of_all_runs() {
    for modes in [4, 12] {
        let (built, info) = certificate(&beam("1e-3", &format!("[basis]\nmodes = {modes}\n")));
        for structure in ["diagonal", "block"] {
            let report = &built["certificate"][structure];
            let runs = report["runs"].as_array().expect("the runs");
            assert_eq!(runs.len(), 3);
            let largest = |key: &str| runs.iter().map(|run| number(&run[key])).fold(0.0, f64::max);
            let ratios = runs.iter().map(|run| number(&run["error"]) / number(&run["floor"]));
            let ratio = ratios.fold(0.0, f64::max);
            for shown in [report, &info[structure]] {
                assert_eq!(number(&shown["trajectory_error"]), largest("error"), "{modes} {structure}");
                assert_eq!(number(&shown["projection_floor"]), largest("floor"), "{modes} {structure}");
                assert_eq!(number(&shown["floor_ratio"]), ratio, "{modes} {structure}");
            }
        }
        // The floor is of the basis and of the full-order march alone.
        let floor = |structure: &str| number(&info[structure]["projection_floor"]);
        assert_eq!(floor("diagonal"), floor("block"));
    }
}

#[test]
fn a_file_that_errs_by_much_is_refused_however_close_to_its_floor() {
    // One mode shows one bending direction of the beam only.
    let folder = tempfile::tempdir().expect("a folder");
    let ran = build(folder.path(), &beam("1e-3", "[basis]\nmodes = 1\n"));
    ran.fails(6, &["error ≤ 5e-2", "ratio 1.00", "`tolerance.error`", "`basis.modes`"]);
    assert!(!folder.path().join("p.vdm").exists());
    let accepted = build(folder.path(), &beam("1e-3", "[basis]\nmodes = 1\n[tolerance]\nerror = 0.99\n"));
    let error = number(&accepted.json()["certificate"]["diagonal"]["trajectory_error"]);
    assert!((0.05..0.99).contains(&error), "{error}");
}

#[test]
fn where_nothing_is_marched_nobody_is_sent_to_snapshots() {
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = "[mesh]\nblock = { lengths = [1.0, 0.1, 0.1], divisions = [6, 1, 1] }\n[[material]]\n\
                young = 2e9\npoisson = 0.3\ndensity = 1200.0\n[basis]\nmodes = 1\n";
    for support in ["[[support]]\non = { group = \"x_min\" }\n", ""] {
        let ran = build(folder.path(), &format!("{mesh}{support}"));
        ran.fails(6, &["error ≤ 5e-2", "more `basis.modes`"]);
        assert!(!ran.stderr.contains("snapshots"), "{}", ran.stderr);
    }
}

#[test]
fn a_mesh_in_another_unit_than_its_material_does_not_pass_for_a_good_file() {
    // Millimetres beside pascals: the step is 1/47 000 of the first period, and the snapshots see 1 % of it.
    let mesh =
        "[mesh]\nblock = { lengths = [1000.0, 100.0, 100.0], divisions = [3, 1, 1], order = \"linear\" }";
    let folder = tempfile::tempdir().expect("a folder");
    let short = problem(mesh, "1e-3", "duration = 0.5\n[basis]\nmodes = 4\n[tolerance]\nsteps = 500\n");
    let ran = build(folder.path(), &short);
    assert_ne!(ran.code, Some(0));
    assert!(!folder.path().join("p.vdm").exists());
    assert!(ran.stderr.contains("`mesh.scale = 0.001`"), "{}", ran.stderr);
}

#[test]
fn a_certificate_covers_whole_periods_unless_told_otherwise() {
    // Some 420 steps in the first period: 500 steps, as before, would see little more than one.
    let step = "1.125e-4";
    let (built, info) = certificate(&beam(step, "[basis]\nmodes = 4\n[tolerance]\nerror = 0.9\n"));
    let period = number(&built["steps_per_first_period"]);
    assert!(period > 300.0, "{period}");
    assert_eq!(number(&info["diagonal"]["steps"]), (3.0 * period).ceil());
    let (_, short) = certificate(&beam(step, "[basis]\nmodes = 4\n[tolerance]\nerror = 0.9\nsteps = 450\n"));
    assert_eq!(number(&short["diagonal"]["steps"]), 450.0);
}

#[test]
fn every_corner_of_a_box_is_marched_for_a_whole_period_of_its_own() {
    // At a quarter of the stiffness and half the step the first period has four times as many steps.
    let live = "[basis]\nmodes = 6\n[tolerance]\nmap = 1e-5\n[[parameter]]\nname = \"stiffness\"\nkind = \
                \"stiffness\"\nrange = [0.25, 1.0]\nscale = \"log\"\n[[parameter]]\nname = \"step\"\nkind = \
                \"time-step\"\nrange = [1.25e-4, 2.5e-4]\nscale = \"log\"\n";
    let (built, info) = certificate(&beam("2.5e-4", live));
    let period = number(&built["steps_per_first_period"]);
    assert!(4.0 * period > 700.0, "{period}");
    let runs = built["certificate"]["block"]["runs"].as_array().expect("the runs");
    assert_eq!(runs.len(), 3 * 4, "three runs at each corner");
    // The fewest steps of any corner stand in the file; that of the longest period takes more.
    assert_eq!(number(&info["block"]["steps"]), (3.0 * period).ceil());
}

#[test]
fn a_file_tells_how_reciprocal_its_structures_are_and_how_far_their_energy_may_swing() {
    let (_, ritz) = certificate(&beam("1e-3", "[basis]\nmodes = 6\n"));
    assert!(number(&ritz["diagonal"]["reciprocity"]) < 1e-13, "Galerkin: reciprocal to rounding");
    let block = number(&ritz["block"]["reciprocity"]);
    assert!(block > 1e-12 && block < 1e-2, "{block}");
    // A plain POD is not closed under the motion, and the trapezoidal rule damps nothing.
    let trapezoidal = "1e-3\nscheme = { name = \"newmark\", beta = 0.25, gamma = 0.5 }";
    let pod = "[basis]\nkind = \"pod\"\nmodes = 6\n[tolerance]\nfloor_ratio = 1e3\nerror = 0.9\n";
    let (_, pod) = certificate(&beam(trapezoidal, pod));
    assert!(number(&pod["block"]["reciprocity"]) > 1e-5);
    let growth = number(&pod["block"]["energy_growth"]);
    assert!(growth > 1.0 + 1e-6, "{growth}");
    // Bathe's scheme in the diagonal structure loses energy only.
    assert_eq!(number(&ritz["diagonal"]["energy_growth"]), 1.0);
}

/// The same beam of 3 × 2 × 2 cells as two tables, every point moved by `turn`.
fn tables(folder: &Path, turn: fn([f64; 3]) -> [f64; 3]) {
    let mesh = block([0.9, 0.3, 0.3], [3, 2, 2], Order::Linear);
    let line = |numbers: &[f64]| numbers.iter().map(|x| format!("{x:?} ")).collect::<String>() + "\n";
    let nodes: String = mesh.nodes.iter().map(|&p| line(&turn(p))).collect();
    let tetrahedra = mesh.elements.chunks_exact(4);
    let elements: String =
        tetrahedra.map(|e| line(&e.iter().map(|&n| f64::from(n + 1)).collect::<Vec<_>>())).collect();
    std::fs::write(folder.join("nodes.txt"), nodes).expect("written");
    std::fs::write(folder.join("elements.txt"), elements.replace(".0", "")).expect("written");
}

#[test]
fn a_body_that_is_turned_gets_the_same_basis() {
    let frequencies = |turn: fn([f64; 3]) -> [f64; 3], axis: &str| -> Vec<f64> {
        let folder = tempfile::tempdir().expect("a folder");
        tables(folder.path(), turn);
        let mesh = "[mesh]\ntables = { coordinates = \"nodes.txt\", connectivity = \"elements.txt\" }";
        let text = problem(mesh, "1e-4", "[basis]\nmodes = 8\n[tolerance]\nerror = 0.9\n");
        let text = text.replace("axis = \"x\"", &format!("axis = \"{axis}\""));
        let built = build(folder.path(), &text).json();
        let modes = built["mode_table"].as_array().expect("the modes").clone();
        modes.iter().map(|mode| number(&mode["frequency_hz"])).collect()
    };
    let straight = frequencies(|p| p, "x");
    type Turn = fn([f64; 3]) -> [f64; 3];
    let turns: [(Turn, &str); 3] =
        [(|[x, y, z]| [-y, x, z], "y"), (|[x, y, z]| [z, x, y], "y"), (|[x, y, z]| [-z, y, x], "z")];
    for (turn, axis) in turns {
        let turned = frequencies(turn, axis);
        for (a, b) in straight.iter().zip(&turned) {
            // The POD of the same snapshots, turned: rounding grows with the spread of its singular values.
            assert!((a / b - 1.0).abs() < 1e-6, "{straight:?}\n{turned:?}");
        }
    }
}
