//! The discretisation error through the program: every command that prints it says the same.

use serde_json::Value;
use vademecum_tests::program::vademecum;

const BEAM: &str = r#"
[mesh]
block = { lengths = [1.0, 0.1, 0.1], divisions = [6, 1, 1], order = "quadratic" }
[[material]]
young = 1e9
poisson = 0.3
density = 1000.0
[[support]]
on = { group = "x_min" }
[time]
step = 1e-3
[basis]
modes = 8
[tolerance]
error = 1.0
"#;

const PUSH: &str = "duration = 0.05\n[[contact]]\npoint = [1.0, 0.1, 0.1]\nforce = [0.0, 0.0, 1.0]\n";

fn first(errors: &Value, key: &str) -> f64 {
    errors[0][key].as_f64().expect("a number")
}

#[test]
fn build_info_modes_and_verify_agree_on_the_error_of_the_mesh() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (problem, file, scenario) = (at("beam.toml"), at("beam.vdm"), at("push.toml"));
    std::fs::write(&problem, BEAM).expect("written");
    std::fs::write(&scenario, PUSH).expect("written");
    let built = vademecum(&["build", &problem, "-o", &file, "--json"]).json();
    let modes = vademecum(&["modes", &problem, "--mesh-error", "--json"]).json();
    let info = vademecum(&["info", &file, "--json"]).json();
    let verified =
        vademecum(&["verify", &file, "--problem", &problem, "--scenario", &scenario, "--mesh", "--json"])
            .json();
    let all = [
        &built["mesh_error"]["frequencies"],
        &modes["mesh_error"]["frequencies"],
        &info["certificate"]["mesh_error"],
        &verified["mesh_error"]["frequencies"],
    ];
    for errors in all {
        assert_eq!(errors.as_array().map(Vec::len), Some(6), "{errors}");
        // An Euler–Bernoulli beam, less what shear takes: 16.10 Hz.
        assert!((first(errors, "refined") / 16.10 - 1.0).abs() < 0.01, "{errors}");
        // The start blocks of the iteration differ in size.
        assert!((first(errors, "error") / first(all[0], "error") - 1.0).abs() < 0.02, "{errors}");
        assert!(first(errors, "bound") > first(errors, "error") && first(errors, "error") > 0.005);
    }
    let displacement = &modes["mesh_error"]["displacement"];
    assert!(displacement["error"].as_f64().is_some_and(|error| error < 0.0), "{displacement}");
    let words = vademecum(&["modes", &problem, "--mesh-error", "--disc", "0.05"]).stdout;
    assert!(
        words.contains("Hz on this mesh, about") && words.contains("disc of radius 5.0000e-2 m"),
        "{words}"
    );
    let words =
        vademecum(&["verify", &file, "--problem", &problem, "--scenario", &scenario, "--mesh"]).stdout;
    assert!(words.contains("errors: reduction ") && words.contains("mesh about "), "{words}");
    vademecum(&["modes", &problem, "--mesh-error", "--disc", "-1"]).fails(2, &["disc"]);
}

#[test]
fn a_support_without_area_is_named_as_the_reason() {
    let folder = tempfile::tempdir().expect("a folder");
    let problem = folder.path().join("line.toml").display().to_string();
    let line = "on = { box = { min = [-1.0, -1.0, -0.001], max = [0.001, 1.0, 0.001] } }\n[[support]]\n\
                on = { box = { min = [0.999, -1.0, -0.001], max = [1.001, 1.0, 0.001] } }";
    std::fs::write(&problem, BEAM.replace("on = { group = \"x_min\" }", line)).expect("written");
    let words = vademecum(&["modes", &problem, "--mesh-error"]).stdout;
    assert!(words.contains("mesh error: not estimated: 4 held nodes and no held face"), "{words}");
    let json = vademecum(&["modes", &problem, "--mesh-error", "--json"]).json();
    assert!(json["mesh_error"]["reason"].is_string(), "{json}");
}
