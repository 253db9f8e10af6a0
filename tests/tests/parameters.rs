//! Live parameters end to end: a small body of two materials is built, certified, written, and stepped at parameters that no
//! build saw, beside a full-order march of a problem that has them fixed.

use serde_json::Value;
use vademecum_tests::program::vademecum;

/// A short beam of two materials; `PARAMETERS` is replaced by live parameters or left out.
const PROBLEM: &str = r#"
[mesh]
block = { lengths = [1.0, 0.1, 0.1], divisions = [6, 1, 1] }
[[mesh.region]]
name = "tip"
on = { fraction = { axis = "x", side = "max", fraction = 0.5 } }
[[material]]
region = "body"
young = 2e9
poisson = 0.3
density = 1200.0
[[material]]
region = "tip"
young = 2e9
poisson = 0.3
density = 1200.0
[[support]]
on = { group = "x_min" }
[load]
[time]
step = 1e-3
[snapshots]
positions = 2
duration = 0.1
[basis]
modes = 6
[tolerance]
floor_ratio = 3.0
steps = 100
map = 1e-6
max_terms = 80
"#;

const PARAMETERS: &str = r#"
[[parameter]]
name = "root"
kind = "stiffness"
region = "body"
range = [0.5, 2.0]
scale = "log"
[[parameter]]
name = "tip"
kind = "stiffness"
region = "tip"
range = [0.5, 2.0]
scale = "log"
[[parameter]]
name = "dt"
kind = "time-step"
range = [0.5e-3, 2e-3]
scale = "log"
"#;

#[test]
fn a_build_over_three_parameters_keeps_what_it_promises() {
    let folder = tempfile::tempdir().expect("a folder");
    let (problem, file) = (folder.path().join("p.toml"), folder.path().join("f.vdm"));
    std::fs::write(&problem, format!("{PROBLEM}{PARAMETERS}")).expect("written");
    let path = |p: &std::path::Path| p.display().to_string();
    let built = vademecum(&["build", &*path(&problem), "-o", &path(&file), "--json"]);
    assert_eq!(built.code, Some(0), "{}", built.stderr);
    let info = vademecum(&["info", &*path(&file), "--json"]);
    let info: Value = serde_json::from_str(&info.stdout).expect("JSON");
    let certificate = &info["certificate"];
    let number = |key: &str| certificate[key].as_f64().unwrap_or_else(|| panic!("{key} in {certificate}"));
    // What the problem asked for, not what happened to come out.
    assert!(number("terms") <= 80.0);
    assert!(number("map_error_rms") <= 1e-6 && number("map_error_max") <= 1e-5);
    assert!(number("spectral_radius_max") <= 1.0 + 1e-12);
    assert!(number("trajectory_error_max") <= 3.0 * number("trajectory_floor_max") + 1e-6);
    assert_eq!(info["parameters"].as_array().map(Vec::len), Some(3));
    // The history ends where the solution met its tolerance; the worst sample of the radius is the one certified.
    let history = info["enrichment_history"].as_array().expect("a history");
    let error = |entry: &Value| entry["error"].as_f64().expect("an error");
    assert_eq!(history.last().expect("entries")["terms"], certificate["terms"]);
    assert!(error(&history[0]) > 1e-3 && error(history.last().expect("entries")) <= 1e-6);
    let radii = info["radius_samples"].as_array().expect("samples");
    assert_eq!(radii.len(), 8 + 1 + 100, "corners, the problem's own values, random points");
    let radius = |sample: &Value| sample["spectral_radius"].as_f64().expect("a radius");
    assert_eq!(radii.iter().map(radius).fold(0.0, f64::max), number("spectral_radius_max"));
    let ranges = [(0.5, 2.0), (0.5, 2.0), (0.5e-3, 2e-3)];
    for sample in radii {
        let values =
            sample["values"].as_array().expect("values").iter().map(|v| v.as_f64().expect("a value"));
        assert!(values.zip(ranges).all(|(v, (low, high))| low <= v && v <= high), "{sample}");
    }
    assert_eq!(info["axes"].as_array().map(Vec::len), Some(2), "Δt and both stages share θ");
}

#[test]
fn a_range_without_the_problems_own_value_and_an_unknown_region_are_named_with_their_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let problem = folder.path().join("p.toml");
    for (from, to, expected) in [
        ("range = [0.5e-3, 2e-3]", "range = [2e-3, 4e-3]", "0.001"),
        ("region = \"tip\"\nrange", "region = \"top\"\nrange", "`top` is no region"),
    ] {
        std::fs::write(&problem, format!("{PROBLEM}{}", PARAMETERS.replace(from, to))).expect("written");
        let path = problem.display().to_string();
        let ran = vademecum(&["build", &*path, "-o", &format!("{path}.vdm")]);
        assert_eq!(ran.code, Some(3), "{}", ran.stderr);
        let located = ran.stderr.contains("p.toml:") && ran.stderr.contains(expected);
        assert!(located, "{}", ran.stderr);
    }
}
