//! The tutorial and the gallery, as a reader goes through them.

use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;

use vademecum_build::input::Problem;
use vademecum_tests::program::{program, repository, vademecum};

/// Gmsh, installed once for both tests. Outside CI a machine without Python or without a registry skips; in
/// CI that is a failure.
fn gmsh() -> Option<String> {
    static GMSH: OnceLock<Option<String>> = OnceLock::new();
    GMSH.get_or_init(installed).clone()
}

fn installed() -> Option<String> {
    let output = Command::new("sh").arg(repository().join("tests/scripts/gmsh")).output().expect("a shell");
    if output.status.success() {
        return Some(String::from_utf8(output.stdout).expect("a path").trim().to_string());
    }
    let why = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(std::env::var_os("CI").is_none(), "no Gmsh: {why}");
    eprintln!("skipped: no Gmsh: {why}");
    None
}

fn copy_all(from: &Path, to: &Path) {
    for entry in std::fs::read_dir(from).expect("a folder") {
        let path = entry.expect("an entry").path();
        std::fs::copy(&path, to.join(path.file_name().expect("a name"))).expect("a copy");
    }
}

/// The blocks of shell commands on a page, in order.
fn commands(page: &str) -> Vec<String> {
    let blocks = page.split("```sh\n").skip(1);
    blocks.map(|block| block.split("```").next().expect("the end of a block").to_string()).collect()
}

#[test]
fn every_command_of_the_tutorial_runs_and_the_fork_has_its_pitch() {
    let Some(gmsh) = gmsh() else { return };
    let source = repository().join("docs/tutorials/tuning-fork");
    let folder = tempfile::tempdir().expect("a folder");
    copy_all(&source, folder.path());
    let page = std::fs::read_to_string(source.join("README.md")).expect("the page");
    let found = commands(&page);
    assert!(found.len() >= 8, "{} blocks of commands", found.len());

    let program = program().canonicalize().expect("the program");
    let folders = [program.parent(), Path::new(&gmsh).parent()].map(|folder| folder.expect("a folder"));
    let path = std::env::var("PATH").expect("a path");
    let path = format!("{}:{}:{path}", folders[0].display(), folders[1].display());
    let mut said = String::new();
    for block in &found {
        let mut shell = Command::new("sh");
        let ran =
            shell.args(["-euc", block]).current_dir(&folder).env("PATH", &path).output().expect("a shell");
        let error = String::from_utf8_lossy(&ran.stderr);
        assert!(ran.status.success(), "{block}\n{error}");
        said += &String::from_utf8_lossy(&ran.stdout);
    }

    let number = |fits: &dyn Fn(&str) -> bool, column: usize| -> f64 {
        let line =
            said.lines().find(|line| fits(line)).unwrap_or_else(|| panic!("a line is missing:\n{said}"));
        line.split_whitespace().nth(column).expect("a column").parse().expect("a number")
    };
    // The prongs pass through zero as often as the third mode of `modes` has them: the page says 440.0.
    let pitch = number(&|line| line.ends_with(" Hz") && line.split_whitespace().count() == 2, 0);
    let third = number(&|line| line.starts_with("   3 "), 1);
    assert!((pitch - third).abs() < 0.05 && (third - 440.0).abs() < 1.0, "{pitch} Hz, {third} Hz");
    let ratio = number(&|line| line.starts_with("ratio "), 1);
    assert!((ratio / 2.03e-4 - 1.0).abs() < 0.01, "{ratio}");
}

#[test]
fn the_gallery_builds_and_its_numbers_are_those_of_the_page() {
    let source = repository().join("docs/gallery");
    for entry in std::fs::read_dir(&source).expect("a folder") {
        let path = entry.expect("an entry").path();
        let scenario = ["touch.toml", "crossing.toml", "shelf.toml"].iter().any(|name| path.ends_with(name));
        if path.extension().is_some_and(|kind| kind == "toml") && !scenario {
            Problem::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    copy_all(&source, folder.path());
    let at = |name: &str| folder.path().join(name).display().to_string();
    let lowest = |body: &str, scenario: &str, probes: usize| -> Vec<f64> {
        let (problem, file, out) = (at(&format!("{body}.toml")), at(&format!("{body}.vdm")), at(body));
        let built = vademecum(&["build", &problem, "-o", &file]);
        assert_eq!(built.code, Some(0), "{}", built.stderr);
        let ran = vademecum(&["run", &file, "--scenario", &at(scenario), "-o", &out]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        let table = std::fs::read_to_string(Path::new(&out).join("probes.csv")).expect("a table");
        let rows = table.lines().skip(1).map(|row| row.split(',').map(|x| x.parse().expect("a number")));
        let rows: Vec<Vec<f64>> = rows.map(Iterator::collect).collect();
        (0..probes).map(|probe| rows.iter().map(|row| row[2 + probe]).fold(0.0, f64::min)).collect()
    };
    let [sunk] = lowest("bridge", "crossing.toml", 1)[..] else { panic!("one probe") };
    assert!((sunk + 3.7e-3).abs() < 0.1e-3, "{sunk} m");
    let Some(gmsh) = gmsh() else { return };
    let meshed =
        Command::new(gmsh).args(["-v", "2", "-3", &at("organ.geo"), "-o", &at("organ.msh")]).status();
    assert!(meshed.expect("Gmsh").success());
    let [over, beside] = lowest("organ", "touch.toml", 2)[..] else { panic!("two probes") };
    assert!((over + 3.0e-4).abs() < 0.2e-4 && (beside + 7.8e-4).abs() < 0.4e-4, "{over} m, {beside} m");
}
