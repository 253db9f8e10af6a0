//! The program end to end, on a body of 324 dofs: what a user types and what comes back.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use serde_json::Value;
use vademecum_tests::program::{Ran, fixtures, repository, vademecum};

/// A path of the fixtures.
fn fixture(name: &str) -> PathBuf {
    repository().join("fixtures").join(name)
}

fn short_beam() -> PathBuf {
    fixture("problems/short-beam.toml")
}

fn run<const N: usize>(arguments: [&dyn AsRef<std::ffi::OsStr>; N]) -> Ran {
    vademecum(&arguments.map(|a| a.as_ref().to_os_string()))
}

/// The short beam's file, built once for all tests of this program.
fn built() -> &'static Path {
    static FILE: OnceLock<(tempfile::TempDir, PathBuf)> = OnceLock::new();
    let (_, path) = FILE.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("beam.vdm");
        let built = run([&"build", &short_beam(), &"-o", &path, &"--json"]).json();
        assert_eq!(built["dofs"], 324);
        (folder, path)
    });
    path
}

#[test]
fn an_engine_that_is_not_built_in_is_refused_by_name() {
    let ran = run([&"build", &short_beam(), &"--engine", &"petsc"]);
    assert_eq!(ran.code, Some(2), "{}", ran.stderr);
    assert!(ran.stderr.contains("built without PETSc"), "{}", ran.stderr);
    let ran = run([&"build", &short_beam(), &"--out-of-core", &"scratch"]);
    assert_eq!(ran.code, Some(2), "{}", ran.stderr);
    assert!(ran.stderr.contains("is for `--engine petsc`"), "{}", ran.stderr);
}

/// The short beam with `from` replaced, in a folder of its own.
fn changed(from: &str, to: &str) -> (tempfile::TempDir, PathBuf) {
    let text = std::fs::read_to_string(short_beam()).expect("the fixture");
    assert!(text.contains(from), "the fixture has no `{from}`");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("changed.toml");
    std::fs::write(&path, text.replace(from, to)).expect("written");
    (folder, path)
}

fn has_keys(value: &Value, keys: &[&str]) {
    for key in keys {
        assert!(value.get(key).is_some(), "no key `{key}` in {value}");
    }
}

#[test]
fn info_tells_what_a_file_holds() {
    let info = run([&"info", &built(), &"--json"]).json();
    let keys = ["mesh_hash", "structures", "axes", "certificate", "sections", "problem", "units", "program"];
    has_keys(&info, &keys);
    assert_eq!(info["nodes"], 117);
    assert_eq!(info["modes"], 4);
    assert_eq!(info["scheme"], "bathe");
    assert_eq!(info["probes"], serde_json::json!(["tip"]));
    assert_eq!(info["load_patterns"], serde_json::json!(["gravity"]));
    assert_eq!(info["problem"], std::fs::read_to_string(short_beam()).expect("the fixture"));
}

#[test]
fn a_file_without_parameters_has_no_box_to_sample() {
    let info = run([&"info", &built(), &"--json"]).json();
    assert_eq!(info["format"], "1.8", "the first version that keeps the discretisation error");
    assert_eq!(info["enrichment_history"].as_array().map(Vec::len), Some(0));
    assert_eq!(info["radius_samples"].as_array().map(Vec::len), Some(0));
}

#[test]
fn a_report_takes_the_times_of_its_own_build_and_of_no_other() {
    let folder = tempfile::tempdir().expect("a folder");
    let [times, page] = ["build.json", "report.html"].map(|name| folder.path().join(name));
    let length = std::fs::metadata(built()).expect("a file").len();
    let stage = r#"{ "stage": "a stage of two seconds", "seconds": 2.0, "peak_memory_bytes": null }"#;
    let said = |length: u64| format!(r#"{{ "file_bytes": {length}, "timings": [{stage}] }}"#);
    std::fs::write(&times, said(length)).expect("written");
    let report = || run([&"report", &built(), &"-o", &page, &"--build", &times]);
    assert_eq!(report().code, Some(0), "{}", report().stderr);
    let html = std::fs::read_to_string(&page).expect("a page");
    assert!(html.contains("The build took 2 s") && html.contains("a stage of two seconds"));
    assert!(folder.path().join("report-figures/build.svg").exists());
    std::fs::write(&times, said(length + 1)).expect("written");
    report().fails(3, &["build.json", &format!("a file of {} bytes, this one has {length}", length + 1)]);
    std::fs::write(&times, "no JSON").expect("written");
    report().fails(3, &["build.json"]);
}

#[test]
fn mesh_tells_what_a_mesh_file_holds() {
    let mesh = run([&"mesh", &fixture("meshes/cube.msh"), &"--json"]).json();
    assert_eq!(mesh["elements"], 5);
    assert_eq!(mesh["volume"], 1.0);
    assert_eq!(mesh["bounding_box"], serde_json::json!([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]));
    assert_eq!(mesh["problems"], serde_json::json!([]));
    has_keys(&mesh, &["quality", "groups", "regions", "notes"]);
}

#[test]
fn modes_are_those_of_a_beam() {
    let modes = run([&"modes", &short_beam(), &"--count", &"6", &"--json"]).json();
    let frequencies = modes["frequencies_hz"].as_array().expect("a list");
    assert_eq!(frequencies.len(), 6);
    // Euler–Bernoulli, h = 0.1: 0.5596 √(E/ρ h²/12)/L² = 20.85 Hz, twice; shear at L/h = 10 takes 1 to 2 %
    // from it and six quadratic elements along the beam give a few percent back.
    let euler: f64 = 0.5596 * (2e9 / 1200.0 * 0.01 / 12.0_f64).sqrt();
    for frequency in &frequencies[..2] {
        let frequency = frequency.as_f64().expect("a number");
        assert!((frequency / euler - 1.0).abs() < 0.05, "{frequency} Hz against {euler} Hz");
    }
}

#[test]
fn a_problem_finds_its_mesh_beside_itself() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("cube.vdm");
    let report = run([&"build", &fixture("problems/cube.toml"), &"-o", &path, &"--json"]).json();
    assert_eq!(report["dofs"], 12);
    assert_eq!(report["file_bytes"].as_u64(), std::fs::metadata(&path).ok().map(|m| m.len()));
}

#[test]
fn verify_compares_with_the_full_order_march() {
    let scenario = fixture("scenarios/short-push.toml");
    for structure in ["diagonal", "block"] {
        let arguments: [&dyn AsRef<std::ffi::OsStr>; 9] = [
            &"verify",
            &built(),
            &"--problem",
            &short_beam(),
            &"--scenario",
            &scenario,
            &"--structure",
            &structure,
            &"--json",
        ];
        let report = run(arguments).json();
        has_keys(
            &report,
            &["dofs", "modes", "bound", "full_order_seconds_per_step", "vademecum_seconds_per_step"],
        );
        let number = |key: &str| report[key].as_f64().expect(key);
        assert_eq!(report["steps"], 200);
        assert_eq!(report["structure"], structure);
        // The build's own promise, on loads it has not seen: floor_ratio and absolute of `[tolerance]`.
        assert!(number("trajectory_error") <= 1.1 * number("projection_floor") + 1e-6, "{report}");
        assert!(number("projection_floor") < 0.1, "four modes show most of a push: {report}");
        assert!(number("spectral_radius") <= 1.0 + 1e-12, "{report}");
        // Nothing acts after release, and the scheme takes energy away.
        assert!(number("energy_drift") <= 1e-12 && number("energy_ratio") <= 1.0 + 1e-12, "{report}");
        assert!(number("energy_drift_full_order") <= 1e-12, "{report}");
        // All 324 dofs are in the space of the truth, so nothing is missing but what was taken for rounding.
        assert!(number("truth_error") <= 1e-6, "{report}");
        // File − truth is what the coordinates add, the scheme's part in the basis, and what lies beyond it.
        // The rest is relative to the march, whose size is that of the truth within the time error.
        let [total, time, basis] = ["total_error", "time_error", "basis_error"].map(number);
        let parts = time + basis + (1.0 + time) * number("rest_error");
        assert!(basis <= total && total <= parts + number("truth_error"), "{report}");
        assert!(time > 1e-3, "a jump at 40 steps a period costs Bathe's scheme percents: {report}");
        assert!((1e-4..0.1).contains(&number("contact_error")), "{report}");
    }
}

#[test]
fn two_builds_are_the_same_bytes_whatever_the_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    for threads in ["1", "2"] {
        let path = folder.path().join(threads);
        let mut command = vademecum_tests::program::command(&["build"]);
        command.arg(short_beam()).arg("-o").arg(&path).env("RAYON_NUM_THREADS", threads);
        assert!(command.output().expect("the program starts").status.success());
        assert!(
            std::fs::read(&path).expect("a file") == std::fs::read(built()).expect("a file"),
            "{threads} threads"
        );
    }
}

/// Everything in a folder, by name.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let entry = |entry: std::io::Result<std::fs::DirEntry>| {
        let entry = entry.expect("an entry");
        (entry.file_name().to_string_lossy().into_owned(), std::fs::read(entry.path()).expect("readable"))
    };
    let mut all: Vec<_> = std::fs::read_dir(folder).expect("a folder").map(entry).collect();
    all.sort();
    all
}

#[test]
fn two_runs_are_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let outputs = ["a", "b"].map(|name| folder.path().join(name));
    for output in &outputs {
        let scenario = fixture("scenarios/short-push.toml");
        let ran = run([&"run", &built(), &"--scenario", &scenario, &"-o", output]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    }
    let [a, b] = outputs.map(|output| contents(&output));
    // 200 steps, a field every 20 and at the start, the collection, the table and the list.
    assert_eq!(a.len(), 11 + 3);
    assert!(a == b);
}

#[test]
fn every_cause_has_its_exit_code_and_names_its_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("none.vdm");
    let build = |problem: &Path| run([&"build", &problem, &"-o", &output]);

    run([&"build"]).fails(2, &["PROBLEM", "Usage"]);
    build(Path::new("no-such.toml")).fails(3, &["no-such.toml"]);
    let (_kept, unknown) = changed("poisson = 0.3", "poison = 0.3");
    build(&unknown).fails(3, &["changed.toml", "line 9", "poison", "expected one of"]);
    let (_kept, impossible) = changed("poisson = 0.3", "poisson = 0.5");
    build(&impossible).fails(3, &["changed.toml", "`material[0].poisson` is 0.5", "below 0.5"]);
    let (_kept, group) = changed("x_min", "x_mim");
    build(&group).fails(3, &["changed.toml", "support[0].on", "no group `x_mim`", "`x_min`"]);

    let (kept, lost) =
        changed("block = { lengths = [1.0, 0.1, 0.1], divisions = [6, 1, 1] }", "file = \"cube.msh\"");
    build(&lost).fails(4, &["cube.msh"]);
    let mesh = std::fs::read_to_string(fixture("meshes/cube.msh")).expect("the fixture");
    std::fs::write(kept.path().join("cube.msh"), mesh.replace("7 1 1 1", "7 1 one 1")).expect("written");
    build(&lost).fails(4, &["cube.msh", "line 16", "one"]);
    run([&"mesh", &kept.path().join("cube.msh")]).fails(4, &["cube.msh", "line 16", "one"]);

    let (_kept, loose) = changed("group = \"x_min\" }", "group = \"x_min\" }\ncomponents = [\"x\"]");
    build(&loose).fails(5, &["support"]);
    let (_kept, hard) =
        changed("modes = 4", "kind = \"pod\"\nmodes = 6\n[tolerance]\nfloor_ratio = 1.0\nabsolute = 1e-13");
    build(&hard).fails(6, &["no structure keeps the tolerance", "projection error", "--keep-missed"]);
    assert!(!output.exists(), "a failed build writes nothing");
    let kept_missed = run([&"build", &hard, &"-o", &output, &"--keep-missed"]);
    assert_eq!(kept_missed.code, Some(0), "{}", kept_missed.stderr);
    let read_only = folder.path().join("no-folder/body.vdm");
    run([&"build", &short_beam(), &"-o", &read_only]).fails(1, &["body.vdm"]);
}

#[test]
fn a_damaged_file_is_refused_wherever_the_damage_is() {
    let bytes = std::fs::read(built()).expect("a file");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("damaged.vdm");
    // Magic, directory, metadata, a number of some section, the last byte.
    for place in [0, 100, bytes.len() / 16, bytes.len() / 2, bytes.len() - 1] {
        let mut damaged = bytes.clone();
        damaged[place] ^= 0x10;
        std::fs::write(&path, &damaged).expect("written");
        run([&"info", &path]).fails(7, &["damaged.vdm"]);
        let scenario = fixture("scenarios/short-push.toml");
        run([&"run", &path, &"--scenario", &scenario, &"-o", &folder.path()]).fails(7, &["damaged.vdm"]);
    }
    std::fs::write(&path, &bytes[..bytes.len() - 1]).expect("written");
    run([&"info", &path]).fails(7, &["damaged.vdm"]);
    run([&"info", &folder.path().join("none.vdm")]).fails(7, &["none.vdm", "No such file"]);
}

#[test]
fn a_scenario_that_does_not_fit_is_refused_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scenario.toml");
    let refused = |text: &str, parts: &[&str]| {
        std::fs::write(&path, text).expect("written");
        run([&"run", &built(), &"--scenario", &path, &"-o", &folder.path().join("out")]).fails(3, parts);
    };
    refused("duration = 0.1\n[[pattern]]\nname = \"wind\"", &["wind", "gravity"]);
    refused("duration = -0.1", &["scenario.toml", "duration"]);
    refused("duration = 0.1\nlength = 2.0", &["scenario.toml", "line 2", "length"]);
}

#[test]
fn a_file_stripped_to_its_probes_still_runs_under_its_patterns() {
    let folder = tempfile::tempdir().expect("a folder");
    let [scenario, stripped] = ["scenario.toml", "probes.vdm"].map(|name| folder.path().join(name));
    std::fs::write(&scenario, "duration = 0.05\n[[pattern]]\nname = \"gravity\"").expect("written");
    let strip = run([&"strip", &built(), &"--keep", &"probes", &"--for", &scenario, &"-o", &stripped]);
    assert_eq!(strip.code, Some(0), "{}", strip.stderr);
    let probes = |file: &Path, name: &str| {
        let output = folder.path().join(name);
        let ran = run([&"run", &file, &"--scenario", &scenario, &"-o", &output]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        std::fs::read(output.join("probes.csv")).expect("a table")
    };
    assert!(probes(&stripped, "stripped") == probes(built(), "whole"));
    // Fields are drawn on a surface, which is gone.
    let fields = "duration = 0.05\n[output]\nfields_every = 10";
    std::fs::write(&scenario, fields).expect("written");
    let ran = run([&"run", &stripped, &"--scenario", &scenario, &"-o", &folder.path().join("fields")]);
    ran.fails(7, &["probes.vdm", "NodeCoordinates"]);
}

#[test]
fn verify_refuses_a_foreign_mesh() {
    let (_kept, other) = changed("[6, 1, 1]", "[7, 1, 1]");
    let scenario = fixture("scenarios/short-push.toml");
    let ran = run([&"verify", &built(), &"--problem", &other, &"--scenario", &scenario]);
    ran.fails(7, &["beam.vdm", "another mesh", "changed.toml"]);
}

#[cfg(unix)]
#[test]
fn a_reader_that_leaves_early_is_no_fault_and_a_full_disk_is_one() {
    use std::process::Stdio;
    let mut command = vademecum_tests::program::command(&["info", "--json"]);
    let mut child =
        command.arg(built()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    drop(child.stdout.take());
    let ran = Ran::new(&child.wait_with_output().expect("it ends"));
    assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""));
    if let Ok(full) = std::fs::File::options().write(true).open("/dev/full") {
        let mut command = vademecum_tests::program::command(&["info", "--json"]);
        let ran = Ran::new(&command.arg(built()).stdout(full).output().expect("it starts"));
        ran.fails(1, &["cannot be printed"]);
    }
}

#[test]
fn help_is_plain_text() {
    let help = vademecum(&["--help"]).stdout;
    let list = help.split("Commands:").nth(1).and_then(|rest| rest.split("\n\n").next()).expect("a list");
    // The second line of a text is further in.
    let lines = list.lines().filter_map(|line| line.strip_prefix("  "));
    let commands: Vec<&str> =
        lines.filter_map(|line| line.split(' ').next()).filter(|s| !s.is_empty()).collect();
    assert!(commands.contains(&"frf") && commands.len() > 10, "{commands:?}");
    for name in commands {
        let ran = vademecum(&[name, "--help"]);
        assert_eq!(ran.code, Some(0), "{name}");
        // Marks of the documentation of Rust.
        let marks = ["\\[", "](", "[`"].into_iter().find(|mark| ran.stdout.contains(mark));
        assert_eq!(marks, None, "{name}");
    }
}

#[test]
fn info_and_report_have_units_and_no_columns_without_content() {
    let golden = fixture("golden/parameters.vdm");
    let text = run([&"info", &golden]).stdout;
    assert!(text.contains("parameter soft: 0.5 to 2, nominal 1 ("), "{text}");
    assert!(!text.contains(" , "), "{text}");
    let folder = tempfile::tempdir().expect("a folder");
    let [page, problem, file] = ["page.html", "exact.toml", "exact.vdm"].map(|name| folder.path().join(name));
    let body = |file: &Path| {
        assert_eq!(run([&"report", &file, &"-o", &page, &"--force"]).code, Some(0));
        let html = std::fs::read_to_string(&page).expect("a page");
        html.split("</style>").last().expect("a body").to_string()
    };
    let staged = body(built());
    assert!(staged.contains("1 × 0.1 × 0.1 m"));
    let of_stages = ["energy share", "damping ratio, scheme", "period elongation", "block structure"];
    assert!(of_stages.iter().all(|column| staged.contains(column)));
    let text = "[mesh]\nblock = { lengths = [1.0, 0.1, 0.1], divisions = [4, 1, 1] }\n[[material]]\n\
                young = 2e9\npoisson = 0.3\ndensity = 1200.0\n[[support]]\non = { group = \"x_min\" }\n\
                [time]\nstep = 1e-3\n[basis]\nmodes = 8\n[tolerance]\nerror = 1.0\n";
    std::fs::write(&problem, text).expect("written");
    let ran = run([&"build", &problem, &"-o", &file]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let exact = body(&file);
    for column in of_stages {
        assert!(!exact.contains(column), "{column}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn results_that_do_not_fit_on_the_disk_are_refused_before_the_first_step() {
    let folder = tempfile::tempdir().expect("a folder");
    let [scenario, out] = ["long.toml", "out"].map(|name| folder.path().join(name));
    std::fs::write(&scenario, "duration = 9e5\n[output]\nfields_every = 1\n").expect("written");
    let ran = run([&"run", &built(), &"--scenario", &scenario, &"-o", &out, &"--long"]);
    ran.fails(1, &["the results take at least", "and the disk has", "fields_every"]);
    assert!(!out.exists());
}

#[test]
fn two_reports_of_one_file_are_equal_unless_times_are_asked_for() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = built().display().to_string();
    let page = |more: &[&str]| {
        // The page shows its name.
        let path = folder.path().join("page.html");
        let ran = vademecum(&[&["report", &file, "-o", &path.display().to_string()], more].concat());
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        std::fs::read_to_string(path).expect("the page")
    };
    let plain = page(&[]);
    assert_eq!(plain, page(&[]));
    assert!(!plain.contains("on this machine"));
    assert!(page(&["--timings"]).contains("on this machine"));
}

#[cfg(target_os = "linux")]
#[test]
fn more_threads_than_cores_are_cut_with_a_note() {
    let mesh = repository().join("fixtures/problems/short-beam.toml");
    let mut command = std::process::Command::new(vademecum_tests::program::program());
    command.args(["modes", &mesh.display().to_string(), "--json"]).env("RAYON_NUM_THREADS", "100000");
    let ran = Ran::new(&command.output().expect("the program starts"));
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(ran.stderr.contains("RAYON_NUM_THREADS is 100000"), "{}", ran.stderr);
}

/// A name that would clear the terminal, and one that would fill it.
#[test]
fn foreign_names_are_printed_escaped_and_short() {
    let folder = tempfile::tempdir().expect("a folder");
    let problem =
        std::fs::read_to_string(repository().join("fixtures/problems/short-beam.toml")).expect("a problem");
    let evil = "\\u001b[2J\\u009bx";
    let path = folder.path().join("p.toml").display().to_string();
    std::fs::write(&path, problem.replace("\"tip\"", &format!("\"{evil}\""))).expect("written");
    let file = folder.path().join("a.vdm").display().to_string();
    let built = vademecum(&["build", &path, "-o", &file]);
    assert_eq!(built.code, Some(0), "{}", built.stderr);
    for arguments in [&["info", &file][..], &["info", &file, "--json"]] {
        let ran = vademecum(arguments);
        assert!(ran.stdout.contains("\\u001b[2J\\u009bx"), "{}", ran.stdout);
        assert!(!ran.stdout.contains(['\u{1b}', '\u{9b}']), "{:?}", ran.stdout);
    }
    let info = vademecum(&["info", &file, "--json"]).json();
    assert_eq!(info["probes"][0], "\u{1b}[2J\u{9b}x");
    assert_eq!(info["sha256"].as_str().map(str::len), Some(64));
    let long = "a".repeat(5000);
    let scenario = folder.path().join("s.toml").display().to_string();
    std::fs::write(&scenario, format!("duration = 0.01\n[[pattern]]\nname = \"{long}\"\n")).expect("written");
    let ran = vademecum(&[
        "run",
        &file,
        "--scenario",
        &scenario,
        "-o",
        &folder.path().join("o").display().to_string(),
    ]);
    ran.fails(3, &[&format!("`{}…`", &long[..64])]);
    assert!(ran.stderr.len() < 1000, "{} bytes", ran.stderr.len());
    std::fs::write(&scenario, format!("duration = 0.01\n{long} = 1\n")).expect("written");
    let ran = vademecum(&["run", &file, "--scenario", &scenario]);
    assert_eq!(ran.code, Some(3));
    assert!(ran.stderr.len() < 2000, "{} bytes", ran.stderr.len());
}

/// Figures that a file does not know are dashes in words and null in JSON.
#[test]
fn no_file_is_described_by_numbers_that_are_none() {
    for (name, _) in fixtures("golden") {
        let file = fixture("golden").join(&name);
        let words = run([&"info", &file]);
        assert_eq!(words.code, Some(0), "{name}: {}", words.stderr);
        assert!(!words.stdout.contains("NaN") && !words.stdout.contains(" inf"), "{name}: {}", words.stdout);
    }
}
