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
