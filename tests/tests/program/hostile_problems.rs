//! Problem files that ask for what cannot be: each ends with an exit code and a sentence that names the key,
//! in the time it takes to say so. A panic would be exit code 101, an abort a signal.

use std::path::Path;
use std::process::Command;

use vademecum_tests::program::{Ran, command, program, vademecum};

/// Exit codes of the program.
const MACHINE: i32 = 1;
const INPUT: i32 = 3;

const BEAM: &str = r#"
[mesh]
block = { lengths = [1.0, 0.1, 0.1], divisions = [4, 1, 1], order = "linear" }

[[material]]
young = 2e9
poisson = 0.3
density = 1200.0

[[support]]
on = { group = "x_min" }

[load]

[time]
scheme.name = "bathe"
step = 1e-3
"#;

/// The beam with `from` replaced and `more` at its end.
fn changed(from: &str, to: &str, more: &str) -> String {
    assert!(BEAM.contains(from), "the beam has no `{from}`");
    format!("{}{more}", BEAM.replacen(from, to, 1))
}

fn with(more: &str) -> String {
    format!("{BEAM}{more}")
}

/// Builds a problem with these arguments beside.
fn build(problem: &str, arguments: &[&str]) -> Ran {
    let folder = tempfile::tempdir().expect("a folder");
    let path = write(folder.path(), problem);
    let output = folder.path().join("beam.vdm");
    let mut all = vec!["build".as_ref(), path.as_os_str(), "-o".as_ref(), output.as_os_str()];
    all.extend(arguments.iter().map(std::ffi::OsStr::new));
    let ran = vademecum(&all);
    assert_eq!(ran.code == Some(0), output.exists(), "a file is written by a build that succeeds");
    ran
}

fn write(folder: &Path, problem: &str) -> std::path::PathBuf {
    let path = folder.join("beam.toml");
    std::fs::write(&path, problem).expect("written");
    path
}

fn refused(problem: &str, code: i32, parts: &[&str]) {
    build(problem, &[]).fails(code, parts);
}

#[test]
fn numbers_that_double_precision_cannot_multiply_are_named() {
    for value in ["1e-300", "1e-200", "1e308", "inf", "nan", "-1.0", "1e31"] {
        let problem = changed("young = 2e9", &format!("young = {value}"), "");
        refused(&problem, INPUT, &["beam.toml:6", "`material[0].young`"]);
    }
    for value in ["1e300", "1e-300", "1e200"] {
        refused(&changed("density = 1200.0", &format!("density = {value}"), ""), INPUT, &["density", "1e30"]);
        refused(&changed("step = 1e-3", &format!("step = {value}"), ""), INPUT, &["`time.step`", "1e-30"]);
        let hold = with(&format!("[snapshots]\nhold = {value}\n"));
        refused(&hold, INPUT, &["`snapshots.hold`", "1e30"]);
    }
    refused(&with("[damping]\nbeta = 1e300\n"), INPUT, &["`damping.beta`", "1e30"]);
    refused(&with("[snapshots]\ndirections = [[1e140, 0.0, 0.0]]\n"), INPUT, &["snapshots.directions"]);
    refused(
        &with("[[load.pattern]]\nname = \"g\"\nacceleration = [1e300, 0.0, 0.0]\n"),
        INPUT,
        &["`load.pattern[0]`", "1e30"],
    );
    let scale = changed("[mesh]", "[mesh]\nscale = 1e300", "");
    refused(&scale, INPUT, &["`mesh.scale`", "1e30"]);
}

#[test]
fn numbers_of_other_unit_systems_are_taken() {
    // The same beam: SI; millimetres, newtons, tonnes; micrometres, micrograms, microseconds; kilometres.
    let beam = |length: f64, young: f64, density: f64, step: f64| {
        let edge = 0.1 * length;
        BEAM.replace("lengths = [1.0, 0.1, 0.1]", &format!("lengths = [{length:e}, {edge:e}, {edge:e}]"))
            .replace("young = 2e9", &format!("young = {young:e}"))
            .replace("density = 1200.0", &format!("density = {density:e}"))
            .replace("step = 1e-3", &format!("step = {step:e}"))
            + "[basis]\nmodes = 2\n[tolerance]\nsteps = 20\n"
    };
    for (length, young, density, step) in [
        (1.0, 2e9, 1200.0, 1e-3),
        (1e3, 2e3, 1.2e-9, 1e-3),
        (1e6, 2e3, 1.2e-9, 1.0),
        (1.0, 2e9 * 1e6, 1200.0 * 1e12, 1.0),
    ] {
        let ran = build(&beam(length, young, density, step), &["--keep-missed", "--json"]);
        let frequency = ran.json()["mode_table"][0]["frequency_hz"].as_f64().expect("a frequency");
        let steps = 1.0 / (frequency * step);
        assert!((10.0..1000.0).contains(&steps), "{steps} steps a period");
    }
}

#[test]
fn sizes_are_refused_before_anything_is_allocated() {
    for cells in ["1000000, 1000000, 1000000", "9223372036854775807, 1, 2", "1, 1, 50000001"] {
        let problem = changed("[4, 1, 1]", &format!("[{cells}]"), "");
        refused(&problem, INPUT, &["beam.toml:3", "`mesh.block.divisions`", "50 000 000"]);
    }
    for modes in ["4097", "1000000", "1000000000000000000"] {
        refused(&with(&format!("[basis]\nmodes = {modes}\n")), INPUT, &["`basis.modes`", modes, "4096"]);
    }
    refused(&with("[basis]\noversampling = 100000000\n"), INPUT, &["`basis.oversampling`", "1000"]);
    refused(&with("[snapshots]\npositions = 1000000000\n"), INPUT, &["`snapshots.positions`", "10 000"]);
    refused(&with("[tolerance]\nmax_terms = 1000000000\n"), INPUT, &["`tolerance.max_terms`", "65 536"]);
    let parameter = |i: usize| {
        format!(
            "[[parameter]]\nname = \"p{i}\"\nkind = \"stiffness\"\nregion = \"r{i}\"\nrange = [0.5, 2.0]\n"
        )
    };
    let many: String = (0..17).map(parameter).collect();
    refused(&with(&many), INPUT, &["`parameter`", "17", "16"]);
    let canonical = "representation = \"canonical\"\n".to_string() + BEAM;
    for (key, value) in [("max_terms", "100000000"), ("positions", "100000000"), ("points", "100000000")] {
        let problem = format!("{canonical}[canonical]\n{key} = {value}\n");
        refused(&problem, INPUT, &[&format!("`canonical.{key}`"), value]);
    }
}

#[test]
fn ranges_that_no_solution_spans_are_named() {
    for (kind, range) in
        [("stiffness", "[1e-300, 1e300]"), ("density", "[1e-4, 1e4]"), ("beta", "[1e-20, 1.0]")]
    {
        let parameter =
            format!("[[parameter]]\nname = \"p\"\nkind = \"{kind}\"\nrange = {range}\nscale = \"log\"\n");
        refused(&with(&parameter), INPUT, &["`parameter[0].range`"]);
    }
    // One by one they are fine; together they move θ over more than twelve decades.
    let wide = |kind: &str, range: &str| {
        format!("[[parameter]]\nname = \"{kind}\"\nkind = \"{kind}\"\nrange = {range}\nscale = \"log\"\n")
    };
    let all = wide("stiffness", "[1e-3, 1e3]")
        + &wide("density", "[1e-3, 1e3]")
        + &wide("time-step", "[1e-5, 1e-1]");
    let more = "[basis]\nmodes = 2\n[snapshots]\npositions = 1\nduration = 0.05\n".to_string();
    build(&with(&(more + &all)), &[]).fails(5, &["twelve decades", "time step"]);
}

#[test]
fn long_texts_are_refused_when_the_problem_is_read() {
    let long = "a".repeat(2_000);
    refused(&format!("title = \"{long}\"\n{BEAM}"), INPUT, &["`title`", "2000 bytes", "1000 bytes"]);
    refused(&format!("units = \"{long}\"\n{BEAM}"), INPUT, &["`units`", "1000 bytes"]);
    let probe = format!(
        "[[output.probe]]\nname = \"{long}\"\npoint = [0.0, 0.0, 0.0]\ndirection = [0.0, 0.0, 1.0]\n"
    );
    refused(&with(&probe), INPUT, &["`output.probe[0].name`", "1000 bytes"]);
    refused(&format!("title = \"{}\"\n{BEAM}", "b".repeat(10_000_000)), INPUT, &["beam.toml: longer than"]);
}

#[test]
fn a_mesh_without_a_source_and_a_slender_body_are_said_in_words() {
    let none = changed(
        r#"block = { lengths = [1.0, 0.1, 0.1], divisions = [4, 1, 1], order = "linear" }"#,
        "scale = 1.0",
        "",
    );
    refused(&none, INPUT, &["`mesh` is a table with none of its main keys", "`block`"]);
    let both = changed("[mesh]", "[mesh]\nfile = \"beam.msh\"", "");
    refused(&both, INPUT, &["`mesh` is a table with `file` and `block`"]);
    let slender = changed("[1.0, 0.1, 0.1]", "[1e9, 0.1, 0.1]", "");
    refused(&slender, INPUT, &["`mesh.block.lengths`", "1e6 times the shortest"]);
}

#[test]
fn a_march_without_end_is_refused_before_it_starts() {
    for (problem, parts) in [
        (with("[snapshots]\nduration = 1e9\n"), ["full-order steps", "snapshots.duration"]),
        (with("[tolerance]\nsteps = 1000000000000\n"), ["full-order steps", "tolerance.steps"]),
        (with("[tolerance]\nsteps = 9223372036854775807\n"), ["full-order steps", "lifetime"]),
        (with("[snapshots]\nduration = 1e30\n"), ["full-order steps", "lifetime"]),
    ] {
        refused(&problem, INPUT, &parts);
    }
    let modes = "[basis]\nkind = \"modes\"\nmodes = 2\n[tolerance]\nsteps = 10000000000\n";
    refused(&with(modes), INPUT, &["3.0e10 full-order steps", "`--long`"]);
    // Asked for by name it is allowed, but not what no machine does.
    let endless = with("[tolerance]\nsteps = 9000000000000000000\n");
    build(&endless, &["--long"]).fails(INPUT, &["lifetime"]);
}

#[test]
fn a_time_step_that_does_not_fit_the_body_is_refused_the_right_way_round() {
    // The first period of the beam is 16 ms.
    for step in ["10.0", "1e6", "1.0"] {
        let problem = changed("step = 1e-3", &format!("step = {step}"), "");
        refused(
            &problem,
            INPUT,
            &["`time.step`", "first natural period", "write a shorter step, for instance"],
        );
    }
    for step in ["1e-12", "1e-9", "1e-20"] {
        let problem = changed("step = 1e-3", &format!("step = {step}"), "");
        refused(&problem, INPUT, &["`time.step`", "write a longer step, for instance"]);
    }
}

#[test]
fn a_short_and_a_long_step_are_noted_with_a_better_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let noted = |step: &str| {
        let more =
            "[basis]\nmodes = 2\n[snapshots]\npositions = 1\nduration = 0.01\n[tolerance]\nsteps = 10\n";
        let path = write(folder.path(), &changed("step = 1e-3", &format!("step = {step}"), more));
        let output = folder.path().join("beam.vdm");
        let arguments = ["build".as_ref(), path.as_os_str(), "-o".as_ref(), output.as_os_str()];
        let ran = Command::new(program()).args(arguments).arg("--keep-missed").output().expect("it starts");
        Ran::new(&ran).stderr
    };
    let (short, long, right) = (noted("1e-5"), noted("3e-3"), noted("2e-4"));
    assert!(
        short.contains("more than a motion of that period needs: a longer `time.step`, for instance"),
        "{short}"
    );
    assert!(!short.contains("% of the first mode"), "{short}");
    assert!(
        long.contains("the scheme distorts even the first mode; a shorter `time.step`, for instance"),
        "{long}"
    );
    assert!(!right.contains("for instance"), "{right}");
    for said in [short, long, right] {
        assert!(said.contains("note: estimate: ") && said.contains("full-order steps"), "{said}");
        assert!(!said.contains("NaN"), "{said}");
    }
}

#[test]
fn memory_that_is_not_there_is_refused_by_name() {
    let large = changed("divisions = [4, 1, 1]", "divisions = [200, 100, 100]", "");
    build(&large, &["--memory", "1G"])
        .fails(MACHINE, &["2000000 cells", "1.0 GB can be had", "--memory SIZE"]);
    let modes = with("[basis]\nmodes = 2000\noversampling = 1000\n");
    build(&modes, &["--memory", "200M"]).fails(MACHINE, &["basis", "200 MB can be had"]);
    let strided = with("[snapshots]\nduration = 100.0\nstride = 1\n");
    build(&strided, &["--memory", "60M"]).fails(MACHINE, &["snapshots", "60 MB can be had"]);
    let small = with("[basis]\nmodes = 2\n[tolerance]\nsteps = 20\n");
    let ran = build(&small, &["--memory", "1G", "--keep-missed", "--json"]).json();
    assert!(ran["plan"]["memory_bytes"].as_f64() > Some(0.0) && ran["plan"]["steps"].as_f64() > Some(60.0));
}

/// The shell's limit on the address space stands for a small machine.
#[cfg(target_os = "linux")]
#[test]
fn a_limit_on_the_process_ends_in_a_sentence_and_not_in_an_abort() {
    let folder = tempfile::tempdir().expect("a folder");
    for (order, cells) in [("linear", "[400, 400, 300]"), ("quadratic", "[400, 100, 100]")] {
        let text = BEAM.replace("\"linear\"", &format!("\"{order}\"")).replace("[4, 1, 1]", cells);
        let path = write(folder.path(), &text);
        for verb in ["build", "modes"] {
            let run = command(&[verb.as_ref(), path.as_os_str()]);
            let mut shell = Command::new("sh");
            shell.args(["-c", "ulimit -v 4000000; exec \"$@\"", "sh"]).current_dir(folder.path());
            shell.arg(run.get_program()).args(run.get_args());
            let ran = Ran::new(&shell.output().expect("a shell"));
            ran.fails(MACHINE, &["cells of `mesh.block.divisions` need about", "can be had"]);
        }
    }
}

/// However little memory there is, a build ends by its code and in words, or by an allocation of the standard
/// library that names its size; also where it heard that there is enough.
#[cfg(target_os = "linux")]
#[test]
fn memory_that_is_refused_anywhere_is_told_in_words() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = write(folder.path(), &BEAM.replace("[4, 1, 1]", "[24, 6, 6]"));
    let mut run = command(&["build".as_ref(), path.as_os_str(), "-o".as_ref(), "a.vdm".as_ref()]);
    run.args(["--fresh", "--memory", "1G"]);
    let mut refused = 0;
    // With one thread more limits meet a matrix, and fewer the stack of a thread.
    for (limit, threads) in (60..200).step_by(4).zip(["1", "2"].into_iter().cycle()) {
        let mut shell = Command::new("sh");
        shell.args(["-c", "ulimit -v \"$0\"; exec \"$@\"", &(limit << 10).to_string()]);
        shell.current_dir(folder.path()).env("RAYON_NUM_THREADS", threads);
        let ran = shell.arg(run.get_program()).args(run.get_args()).output().expect("a shell");
        let told = String::from_utf8_lossy(&ran.stderr);
        // The standard library panics by itself where a thread finds no memory for its stack.
        let own = |line: &str| line.contains("panicked") && !line.contains("library/std/src/sys/");
        assert!(!told.lines().any(own), "{limit} MiB: {told}");
        refused += usize::from(told.contains("the system refused a memory allocation of"));
    }
    assert!(refused > 0, "no limit met a matrix");
}
