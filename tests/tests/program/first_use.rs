//! Findings of new users: folders that are not there yet, loads that never end, places off the body, ranges
//! that mean nothing.

use vademecum_tests::program::{Ran, program, repository, vademecum};

const BEAM: &str = "[mesh]\nblock = { lengths = [1.0, 0.1, 0.1], divisions = [6, 1, 1] }\n[[material]]\nyoung = \
                    2e9\npoisson = 0.3\ndensity = 1200.0\n[damping]\nratio = 0.02\n[time]\nstep = 1e-3\n[basis]\nmodes = \
                    4\n[tolerance]\nerror = 1.0\n[[output.probe]]\nname = \"tip\"\npoint = [1.0, 0.1, 0.1]\ndirection = \
                    [0.0, 0.0, 1.0]\n";
const HELD: &str = "[[support]]\non = { group = \"x_min\" }\n";
const PUSH: &str = "duration = 0.05\n[[contact]]\npoint = [0.9, 0.05, 0.1]\nforce = [0.0, 0.0, -5.0]\n";

fn works(arguments: &[&str]) {
    let ran = vademecum(arguments);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new(files: &[(&str, &str)]) -> Self {
        let own = Self(tempfile::tempdir().expect("a folder"));
        files.iter().for_each(|(name, text)| std::fs::write(own.at(name), text).expect("written"));
        own
    }

    fn at(&self, name: &str) -> String {
        self.0.path().join(name).display().to_string()
    }

    fn built(files: &[(&str, &str)]) -> Self {
        let own = Self::new(files);
        std::fs::write(own.at("beam.toml"), format!("{BEAM}{HELD}")).expect("written");
        works(&["build", &own.at("beam.toml"), "-o", &own.at("beam.vdm")]);
        own
    }
}

#[test]
fn a_plot_may_lie_in_the_folder_that_the_run_makes() {
    let at = Folder::built(&[("push.toml", PUSH)]);
    let (file, scenario, plot) = (at.at("beam.vdm"), at.at("push.toml"), at.at("out/probes.svg"));
    let run = ["run", &file, "--scenario", &scenario, "-o", &at.at("out"), "--plot", &plot];
    works(&run);
    assert!(std::fs::read_to_string(&plot).expect("a plot").starts_with("<svg"));
    // A folder that nobody makes is refused, before a step is taken.
    let elsewhere =
        ["run", &file, "--scenario", &scenario, "-o", &at.at("new"), "--plot", &at.at("none/p.svg")];
    vademecum(&elsewhere).fails(1, &["no folder"]);
    assert!(!std::path::Path::new(&at.at("new")).exists());
}

#[test]
fn an_energy_asked_for_is_the_column_that_is_there_anyway() {
    let text = format!("{PUSH}[output]\nquantities = [\"energy\", \"strain_energy\"]\n");
    let at = Folder::built(&[("push.toml", &text)]);
    works(&["run", &at.at("beam.vdm"), "--scenario", &at.at("push.toml"), "-o", &at.at("out")]);
    let table = std::fs::read_to_string(at.at("out/probes.csv")).expect("a table");
    let names: Vec<&str> = table.lines().next().expect("names").split(',').collect();
    assert_eq!(names.iter().filter(|name| **name == "energy_J").count(), 1, "{names:?}");
    assert!(names.contains(&"strain_energy_J"), "{names:?}");
}

#[test]
fn what_follows_a_release_is_not_measured_where_a_load_acts_to_the_end() {
    let at = Folder::built(&[("push.toml", PUSH), ("tap.toml", &format!("{PUSH}end = 0.01\n"))]);
    let figures = |scenario: &str| {
        let (file, problem, scenario) = (at.at("beam.vdm"), at.at("beam.toml"), at.at(scenario));
        vademecum(&["verify", &file, "--problem", &problem, "--scenario", &scenario, "--json"]).json()
    };
    let (held, tapped) = (figures("push.toml"), figures("tap.toml"));
    for key in ["energy_drift", "energy_drift_full_order", "energy_ratio"] {
        assert!(held[key].is_null() && tapped[key].is_number(), "{key}: {} {}", held[key], tapped[key]);
    }
}

#[test]
fn frequencies_places_and_discs_that_mean_nothing_are_refused() {
    let at = Folder::built(&[]);
    let (file, problem) = (at.at("beam.vdm"), at.at("beam.toml"));
    for range in ["1,1e300", "1e-300,1", "1e200,1e300"] {
        vademecum(&["frf", &file, "--in", "tip", "--out", "tip", "--range", range])
            .fails(2, &["from 1e-12 to 1e12 Hz"]);
    }
    // The probe is known on both sides.
    let unknown = ["frf", &file, "--in", "tipp", "--out", "tip", "--range", "1,100"];
    vademecum(&unknown).fails(2, &["did you mean `tip`"]);
    for radius in ["1e-9", "100"] {
        let ran = vademecum(&["modes", &problem, "--mesh-error", "--disc", radius]);
        ran.fails(2, &["a disc of radius", "expected"]);
    }
}

#[test]
fn a_support_between_nodes_is_told_beside_the_mesh_error() {
    let fraction = |share: &str| {
        let on = format!("on = {{ fraction = {{ axis = \"x\", side = \"min\", fraction = {share} }} }}\n");
        let at = Folder::new(&[("beam.toml", &format!("{BEAM}[[support]]\n{on}"))]);
        vademecum(&["modes", &at.at("beam.toml"), "--mesh-error", "--json"]).json()["mesh_error"].clone()
    };
    // The nodes along the beam are a twelfth apart.
    assert_eq!(fraction("0.1")["support_between_nodes"], true);
    assert_eq!(fraction("0.0")["support_between_nodes"], false);
    assert_eq!(fraction("0.16667")["support_between_nodes"], false);
}

#[test]
fn a_body_without_supports_is_no_model_for_schemes_by_stages() {
    let at = Folder::new(&[("free.toml", &BEAM.replace("ratio = 0.02", "alpha = 1.0"))]);
    let export = ["export", "matrices", &at.at("free.toml"), "-o", &at.at("matrices")];
    vademecum(&export).fails(3, &["without supports", "`[[support]]`"]);
}

#[test]
fn files_that_are_not_what_their_name_tells_are_named() {
    let at = Folder::new(&[("frf.k", "$ a deck\n*KEYWORD\n*NODE\n")]);
    for command in ["modes", "static", "init"] {
        vademecum(&[command, &at.at("frf.k")]).fails(4, &["an LS-DYNA keyword file"]);
    }
    // A binary STL file that was cut short.
    let mut bytes = vec![0; 84];
    bytes[80..84].copy_from_slice(&2u32.to_le_bytes());
    bytes.extend([0; 60]);
    std::fs::write(at.at("cut.stl"), bytes).expect("written");
    let ran = vademecum(&["mesh", &at.at("cut.stl")]);
    assert!(ran.code == Some(4) && !ran.stderr.contains("vertex x y z"), "{}", ran.stderr);
}

/// A file of large displacements that is pulled a million times as hard as it was trained with.
#[test]
fn motion_beyond_the_training_is_told() {
    let at = Folder::new(&[]);
    let file = repository().join("fixtures/golden/bent.vdm").display().to_string();
    let said = |scale: &str| {
        let text = format!("duration = 0.05\n[[pattern]]\nname = \"pull\"\namplitude = {scale}\n");
        std::fs::write(at.at("pull.toml"), text).expect("written");
        let mut run = std::process::Command::new(program());
        run.args(["run", &file, "--scenario", &at.at("pull.toml"), "-o", &at.at("out"), "--force"]);
        let ran = Ran::new(&run.output().expect("the program starts"));
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        ran.stderr
    };
    let (little, much) = (said("1e-9"), said("1e3"));
    assert!(!little.contains("trained with"), "{little}");
    assert!(much.contains("beyond what the file was trained with, up to "), "{much}");
}
