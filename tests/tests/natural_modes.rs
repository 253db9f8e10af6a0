//! A file whose basis are natural modes: it has no snapshots, so some columns of its table are unknown.

use vademecum_tests::program::{repository, vademecum};

#[test]
fn a_file_of_natural_modes_is_sound() {
    let folder = tempfile::tempdir().expect("a folder");
    let [problem, file] = ["p.toml", "p.vdm"].map(|name| folder.path().join(name).display().to_string());
    let text = std::fs::read_to_string(repository().join("fixtures/problems/short-beam.toml"));
    let text = text.expect("the fixture").replace("modes = 4", "kind = \"modes\"\nmodes = 4");
    std::fs::write(&problem, text).expect("written");
    let built = vademecum(&["build", &problem, "-o", &file, "--keep-missed"]);
    assert_eq!(built.code, Some(0), "{}", built.stderr);
    let checked = vademecum(&["verify", &file, "--file-only"]);
    assert_eq!(checked.code, Some(0), "{}", checked.stderr);
}

#[test]
fn a_file_tells_the_frequencies_of_its_modes() {
    let folder = tempfile::tempdir().expect("a folder");
    let [problem, file] = ["p.toml", "p.vdm"].map(|name| folder.path().join(name).display().to_string());
    let text = std::fs::read_to_string(repository().join("fixtures/problems/short-beam.toml"));
    let text = text.expect("the fixture").replace("modes = 4", "kind = \"modes\"\nmodes = 4");
    std::fs::write(&problem, text).expect("written");
    let frequencies = |arguments: &[&str], table: &str| -> Vec<f64> {
        let ran = vademecum(arguments);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        let printed: serde_json::Value = serde_json::from_str(&ran.stdout).expect("JSON");
        let rows = printed[table].as_array().unwrap_or_else(|| panic!("no `{table}`"));
        rows.iter().map(|row| row["frequency_hz"].as_f64().expect("a frequency")).collect()
    };
    let built = frequencies(&["build", &problem, "-o", &file, "--keep-missed", "--json"], "mode_table");
    assert_eq!(built.len(), 4);
    assert!(built.is_sorted() && built[0] > 0.0);
    assert_eq!(frequencies(&["info", &file, "--json"], "mode_table"), built);
    let packed = folder.path().join("packed.vdm").display().to_string();
    assert_eq!(vademecum(&["pack", &file, "-o", &packed]).code, Some(0));
    assert_eq!(frequencies(&["info", &packed, "--json"], "mode_table"), built);
}
