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

#[test]
fn a_factor_in_single_precision_gives_the_same_file_to_rounding() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let text = std::fs::read_to_string(repository().join("fixtures/problems/short-beam.toml"));
    let text = text.expect("the fixture").replace("modes = 4", "kind = \"modes\"\nmodes = 4");
    std::fs::write(path("p.toml"), text).expect("written");
    let info = |solver: &str| -> serde_json::Value {
        let file = path(&format!("{solver}.vdm"));
        let built = vademecum(&["build", &path("p.toml"), "-o", &file, "--keep-missed", "--solver", solver]);
        assert_eq!(built.code, Some(0), "{}", built.stderr);
        let told = vademecum(&["info", &file, "--json"]);
        serde_json::from_str(&told.stdout).expect("JSON")
    };
    let [direct, single] = ["direct", "single"].map(info);
    let program = |told: &serde_json::Value| told["program"].as_str().expect("a program").to_string();
    assert!(program(&single).starts_with(&program(&direct)) && program(&single).contains("single precision"));
    let [exact, found] = [&direct, &single].map(|told| told["mode_table"].as_array().expect("modes"));
    assert_eq!((exact.len(), found.len()), (4, 4));
    for (a, b) in exact.iter().zip(found) {
        let [a, b] = [a, b].map(|row| row["frequency_hz"].as_f64().expect("a frequency"));
        assert!((a - b).abs() < 1e-9 * a, "{a} Hz and {b} Hz");
    }
    for (engine, solver) in [("local", "iterative"), ("petsc", "single")] {
        let arguments =
            ["build", &path("p.toml"), "-o", &path("no.vdm"), "--engine", engine, "--solver", solver];
        let refused = vademecum(&arguments);
        assert_eq!(refused.code, Some(2), "{}", refused.stderr);
        assert!(refused.stderr.contains("--engine"), "{}", refused.stderr);
    }
}
