//! What somebody meets in the first hour with the program: what may be left out, what is said of a slip, and
//! where help is.

use std::path::{Path, PathBuf};
use std::process::Command;

use vademecum_tests::program::{Ran, program, repository, vademecum};

const BEAM: &str = r#"
[mesh]
block = { lengths = [1.0, 0.1, 0.1], divisions = [4, 2, 2] }
[[material]]
young = 2e9
poisson = 0.3
density = 1200.0
[[support]]
on = { group = "x_min" }
[basis]
modes = 4
"#;

/// A folder with files of these names and texts.
fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    files.iter().for_each(|(name, text)| {
        std::fs::write(folder.path().join(name), text).expect("written");
    });
    folder
}

/// A line of the program in a folder, with what it says of its progress.
fn said(folder: &Path, line: &str) -> Ran {
    let mut command = Command::new(program());
    command.args(line.split_whitespace()).current_dir(folder);
    Ran::new(&command.output().expect("the program starts"))
}

/// The same, which has to succeed.
fn done(folder: &Path, line: &str) -> Ran {
    let ran = said(folder, line);
    assert_eq!(ran.code, Some(0), "{line}: {}", ran.stderr);
    ran
}

fn refused(folder: &Path, line: &str, code: i32, parts: &[&str]) -> Ran {
    let ran = said(folder, line);
    ran.fails(code, parts);
    for rust in ["Some(", "None", "Error {", "Interval", "\\\"", "}:"] {
        assert!(!ran.stderr.contains(rust), "no `{rust}` in {}", ran.stderr);
    }
    ran
}

#[test]
fn a_problem_needs_neither_time_nor_load_and_its_step_is_proposed() {
    let written = BEAM.to_string() + "[load]\n[time]\nstep = 1e-3\n";
    let folder = folder(&[("open.toml", BEAM), ("written.toml", &written)]);
    let modes = done(folder.path(), "modes open.toml --count 2 --json");
    let modes: serde_json::Value = serde_json::from_str(&modes.stdout).expect("JSON");
    // 3.516/2π √(E I/ρ A)/l² of a beam 0.1 thick is 20.9 Hz; 1/(40 f) is 1.2e-3.
    assert_eq!((&modes["time_step"], &modes["proposed_time_step"]), (&1e-3.into(), &1e-3.into()));
    let open = done(folder.path(), "build open.toml -o open.vdm");
    assert!(open.stderr.contains("no `time.step` is given: 1e-3 s is taken"), "{}", open.stderr);
    done(folder.path(), "build written.toml -o written.vdm");
    let info = |name: &str| -> serde_json::Value {
        let ran = done(folder.path(), &format!("info {name} --json"));
        serde_json::from_str(&ran.stdout).expect("JSON")
    };
    let [open, written] = ["open.vdm", "written.vdm"].map(info);
    for key in ["time_step", "loadable_nodes", "certificate", "modes"] {
        assert_eq!(open[key], written[key], "{key}");
    }
}

#[test]
fn a_live_step_that_is_not_given_stands_in_the_middle_of_its_range() {
    let live = "[[parameter]]\nname = \"step\"\nkind = \"time-step\"\nrange = [1e-3, 3e-3]\n";
    let folder = folder(&[("live.toml", &format!("{BEAM}{live}"))]);
    done(folder.path(), "build live.toml -o live.vdm");
    let info = done(folder.path(), "info live.vdm --json");
    let info: serde_json::Value = serde_json::from_str(&info.stdout).expect("JSON");
    assert_eq!(info["time_step"], 2e-3);
}

/// A folder with a built beam, loadable on its top, and scenarios.
fn built(scenarios: &[(&str, &str)]) -> tempfile::TempDir {
    let problem = BEAM.to_string()
        + "[load]\nsurface = { group = \"z_max\" }\n[[load.pattern]]\nname = \"gravity\"\n"
        + "acceleration = [0.0, 0.0, -9.81]\n[time]\nstep = 1e-3\n";
    let folder = folder(&[("beam.toml", &problem)]);
    scenarios.iter().for_each(|(name, text)| {
        std::fs::write(folder.path().join(name), text).expect("written");
    });
    done(folder.path(), "build beam.toml -o beam.vdm");
    folder
}

const PUSH: &str = "duration = 0.02\n[[contact]]\npoint = [1.0, 0.05, 0.1]\nforce = [0.0, 0.0, -10.0]\n";

#[test]
fn a_scenario_brings_probes_of_its_own() {
    let probe = |name: &str, x: f64| {
        format!(
            "[[output.probe]]\nname = \"{name}\"\npoint = [{x}, 0.05, 0.1]\ndirection = [0.0, 0.0, -2.0]\n"
        )
    };
    let probed = format!(
        "{PUSH}[output]\n{}{}",
        probe("tip", 1.0),
        probe("inside", 0.51).replace("0.1]\nd", "0.05]\nd")
    );
    let folder = built(&[("plain.toml", PUSH), ("probed.toml", &probed)]);
    let plain = done(folder.path(), "run beam.vdm --scenario plain.toml -o plain");
    assert!(plain.stderr.contains("time and energy only"), "{}", plain.stderr);
    let ran = done(folder.path(), "run beam.vdm --scenario probed.toml -o probed");
    assert!(!ran.stderr.contains("time and energy only"), "{}", ran.stderr);
    let expected = "probe `inside` looks at the nearest node, (0.500000, 0.050000, 0.050000), 1.000e-2 away";
    assert!(ran.stderr.contains(expected), "{}", ran.stderr);
    let table = std::fs::read_to_string(folder.path().join("probed/probes.csv")).expect("rows");
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("time_s,energy_J,tip [m],inside [m]"));
    let last: Vec<f64> =
        lines.last().expect("rows").split(',').map(|x| x.trim().parse().expect("a number")).collect();
    // Along −z, the way that the push goes; the tip further than the middle.
    assert!(last[2] > last[3] && last[3] > 0.0, "{last:?}");

    // The same node by a probe that the file was built with.
    let problem = std::fs::read_to_string(folder.path().join("beam.toml")).expect("the problem");
    std::fs::write(folder.path().join("own.toml"), problem + &probe("tip", 1.0)).expect("written");
    done(folder.path(), "build own.toml -o own.vdm");
    done(folder.path(), "run own.vdm --scenario plain.toml -o own");
    let own = std::fs::read_to_string(folder.path().join("own/probes.csv")).expect("rows");
    let column = |text: &str| -> Vec<f64> {
        let value = |line: &str| line.split(',').nth(2).expect("a column").trim().parse().expect("a number");
        text.lines().skip(1).map(value).collect()
    };
    for (a, b) in column(&own).into_iter().zip(column(&table)) {
        assert!((a - b).abs() <= 1e-12 * last[2], "{a} {b}");
    }
    refused(folder.path(), "run own.vdm --scenario probed.toml -o o", 3, &["probed.toml", "`tip` already"]);
}

#[test]
fn a_contact_that_misses_the_surface_is_told_or_refused() {
    let at = |point: &str| PUSH.replace("[1.0, 0.05, 0.1]", point);
    let folder = built(&[
        ("bottom.toml", &at("[0.5, 0.05, 0.0]")),
        ("millimetres.toml", &at("[500.0, 50.0, 100.0]")),
        ("long.toml", &format!("{PUSH}[output]\nfields_every = 1000\n")),
    ]);
    let bottom = done(folder.path(), "run beam.vdm --scenario bottom.toml -o o");
    for part in ["acts 1.000e-1 away", "(0.500000, 0.050000, 0.100000)", "`load.surface` of the problem"] {
        assert!(bottom.stderr.contains(part), "{part}: {}", bottom.stderr);
    }
    let parts =
        ["millimetres.toml", "`contact[0]` is", "(0.000000, 0.000000, 0.100000) to (1.000000", "unit"];
    refused(folder.path(), "run beam.vdm --scenario millimetres.toml -o o", 3, &parts);
    let long = done(folder.path(), "run beam.vdm --scenario long.toml -o o");
    assert!(
        long.stderr.contains("`output.fields_every` is 1000, and the run has 20 steps"),
        "{}",
        long.stderr
    );
}

#[test]
fn arguments_that_cannot_be_are_usage_errors() {
    let folder = built(&[("push.toml", PUSH)]);
    for argument in ["--time-step 0", "--time-step -1", "--time-step nan", "--terms x", "--limit many"] {
        refused(folder.path(), &format!("run beam.vdm --scenario push.toml -o o {argument}"), 2, &[]);
    }
    refused(folder.path(), "pack beam.vdm -o p.vdm --tolerance 2", 2, &["1e-12 to 0.1"]);
    refused(folder.path(), "strip beam.vdm -o p.vdm --terms-for 0", 2, &["1e-12 to 0.1"]);
    let ran = done(folder.path(), "run beam.vdm --scenario push.toml -o o --terms 3");
    assert!(ran.stderr.contains("`--terms` has no effect"), "{}", ran.stderr);
}

#[test]
fn a_file_that_is_absent_or_of_another_kind_is_said_and_what_to_do_fits() {
    let folder = built(&[("push.toml", PUSH), ("a.step", "ISO-10303-21;\nHEADER;\n")]);
    let mesh = std::fs::read(repository().join("fixtures/meshes/cube.msh")).expect("a fixture");
    std::fs::write(folder.path().join("cube.msh"), mesh).expect("written");
    for line in [
        "info none.vdm",
        "run none.vdm --scenario push.toml",
        "report none.vdm",
        "view none.vdm --export o.html",
        "verify none.vdm --file-only",
        "pack none.vdm -o o.vdm",
    ] {
        refused(folder.path(), line, 7, &["none.vdm: No such file", "name a file that exists"]);
    }
    for line in ["build none.toml", "modes none.toml", "run beam.vdm --scenario none.toml"] {
        let ran = refused(folder.path(), line, 3, &["none.toml", "No such file", "name a file that exists"]);
        assert!(!ran.stderr.contains("every key"), "{}", ran.stderr);
    }
    refused(folder.path(), "build cube.msh", 3, &["vademecum init MESH"]);
    refused(folder.path(), "build beam.vdm -o other.vdm", 3, &["built already"]);
    refused(folder.path(), "build push.toml", 3, &["--scenario"]);
    refused(folder.path(), "run beam.vdm --scenario beam.toml", 3, &["it is a problem"]);
    refused(folder.path(), "info cube.msh", 7, &["looks like a mesh", "vademecum init MESH"]);
    refused(folder.path(), "mesh a.step", 4, &["a STEP file", "gmsh -3 -order 2"]);
}

#[test]
fn slips_of_the_pen_are_answered_with_what_was_meant() {
    let problem =
        BEAM.to_string() + "[load]\n[[load.pattern]]\nname = \"gravity\"\nacceleration = [0, 0, -9.81]\n";
    let wrong = |from: &str, to: &str| {
        assert!(problem.contains(from), "{from}");
        problem.replacen(from, to, 1)
    };
    let live = "\n[[parameter]]\nname = \"stiffness\"\nkind = \"stiffness\"\nrange = [0.5, 2.0]\n";
    let folder = folder(&[("live.toml", &format!("{problem}{live}"))]);
    for (text, parts) in [
        (wrong("young", "yung"), ["line 5", "did you mean `young`?"]),
        (wrong("[basis]", "[baiss]"), ["line 10", "did you mean `basis`?"]),
        (wrong("\"x_min\"", "\"x_mni\""), ["slip.toml:9", "did you mean `x_min`?"]),
        (wrong("young", "region = \"bdoy\"\nyoung"), ["slip.toml:5", "did you mean `body`?"]),
        (wrong("[4, 2, 2]", "[4, 2, 2], order = \"lienar\""), ["line 3", "did you mean `linear`?"]),
        (wrong("2e9", "2,1e9"), ["line 5", "write 2.1 for 2,1"]),
        (wrong("block = ", "file = \"C:\\users\\me.msh\"\nx = "), ["line 3", "write `/` for"]),
        (wrong("[mesh]", "[[material]]"), ["line 3", "unknown field"]),
        (
            wrong("acceleration", "on = { group = \"z_max\" }\nacceleration"),
            ["slip.toml:13", "is an acceleration with `on`"],
        ),
    ] {
        std::fs::write(folder.path().join("slip.toml"), text).expect("written");
        refused(folder.path(), "modes slip.toml", 3, &parts);
    }
    std::fs::write(folder.path().join("slip.toml"), "title = \"none\"\n").expect("written");
    let none = refused(folder.path(), "modes slip.toml", 3, &["missing field `mesh`", "top level"]);
    assert!(!none.stderr.contains("title"), "the first line is not at fault: {}", none.stderr);

    done(folder.path(), "build live.toml -o live.vdm");
    let scenario = "duration = 0.01\n[[pattern]]\nname = \"gravty\"\n";
    std::fs::write(folder.path().join("s.toml"), scenario).expect("written");
    refused(folder.path(), "run live.vdm --scenario s.toml -o o", 3, &["s.toml", "did you mean `gravity`?"]);
    std::fs::write(folder.path().join("s.toml"), "duration = 0.01\n[[patern]]\n").expect("written");
    refused(folder.path(), "run live.vdm --scenario s.toml -o o", 3, &["s.toml", "did you mean `pattern`?"]);
    std::fs::write(folder.path().join("s.toml"), "duration = 0.01\n").expect("written");
    let set = "run live.vdm --scenario s.toml -o o --set stifness=1.5";
    refused(folder.path(), set, 2, &["did you mean `stiffness`?"]);
    refused(folder.path(), "init cube.msh --material aluminum", 2, &["did you mean `aluminium`?"]);
    refused(folder.path(), "biuld live.toml", 2, &["build"]);
    refused(folder.path(), "help problm", 2, &["did you mean `problem`?"]);
}

#[test]
fn help_has_every_key_of_both_files_and_hints_name_it() {
    for (page, keys) in [
        ("problem", ["mesh.region", "rho_infinity", "oversampling", "static_fields", "Refusals"]),
        ("scenario", ["probes_every", "sinusoid", "amplitude", "duration", "Refusals"]),
    ] {
        let ran = vademecum(&["help", page]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        keys.iter().for_each(|key| assert!(ran.stdout.contains(key), "{key}"));
        assert!(!ran.stdout.contains("|---"), "a table is no table of Markdown");
    }
    let basis = vademecum(&["help", "problem", "basis"]);
    assert!(basis.stdout.starts_with("[basis]\n") && basis.stdout.lines().count() < 60, "{}", basis.stdout);
    let export = vademecum(&["help", "export", "matrices"]);
    assert!(export.stdout.contains("--basis"), "{}", export.stdout);
    let all = vademecum(&["help"]);
    assert!(all.stdout.contains("every key of the problem file"), "{}", all.stdout);
    // What a message sends people to is in the program, not in a folder that they may not have.
    let sources: Vec<PathBuf> =
        ["crates/vademecum-cli/src/failure.rs", "crates/vademecum-cli/src/cmd/build.rs"]
            .map(|path| repository().join(path))
            .into();
    for path in sources {
        let text = std::fs::read_to_string(&path).expect("a source");
        assert!(!text.contains("formats/problem-1.md"), "{}", path.display());
    }
    assert!(vademecum(&["--version"]).stdout.starts_with("vademecum 0"), "the program's own name");
}
