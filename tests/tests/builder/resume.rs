//! A build that was stopped goes on, a changed input rebuilds what depends on it and nothing else, and the
//! file is the same byte for byte whatever was used again.

use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::Mutex;
use std::time::Instant;

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::{Listener, Silent, is_cancelled};
use vademecum_build::store::Store;
use vademecum_tests::program::{Ran, command, program, repository, vademecum};
use vademecum_tests::synthetic::Random;

/// A short beam with two live parameters: two regions, so several parameter samples.
const PARAMETERS: &str = r#"
[[mesh.region]]
name = "tip"
on = { fraction = { axis = "x", side = "max", fraction = 0.5 } }

[[parameter]]
name = "tip stiffness"
kind = "stiffness"
region = "tip"
range = [0.8, 1.25]
scale = "log"

[[parameter]]
name = "step"
kind = "time-step"
range = [4e-4, 2e-3]
scale = "log"
"#;

struct Place {
    folder: tempfile::TempDir,
    text: String,
}

impl Place {
    fn new(more: &str) -> Self {
        let text = std::fs::read_to_string(repository().join("fixtures/problems/short-beam.toml"));
        let residual = "[output]\nresidual = true\n[[output.probe]]";
        let text = text.expect("the fixture").replacen("[[output.probe]]", residual, 1);
        assert!(text.contains(residual));
        Self { folder: tempfile::tempdir().expect("a folder"), text: text + more }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn problem(&self, from: &str, to: &str) -> PathBuf {
        let text = self.text.replace(from, to);
        assert!(from == to || text != self.text, "`{from}` is not in the problem");
        std::fs::write(self.path("p.toml"), text).expect("written");
        self.path("p.toml")
    }

    /// Builds with a work folder that stays, loud enough to hear what was used again.
    fn build(&self, problem: &Path, more: &[&str]) -> (Vec<u8>, Vec<String>) {
        let (output, work) = (self.path("out.vdm"), self.path("work"));
        let ran = std::process::Command::new(program())
            .args(["build".as_ref(), problem.as_os_str(), "-o".as_ref(), output.as_os_str()])
            .args(["--keep-missed".as_ref(), "--work".as_ref(), work.as_os_str()])
            .args(more)
            .output()
            .expect("the program");
        let ran = Ran::new(&ran);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        let outcome = |line: &str| {
            let (stage, what) = line.trim().strip_prefix("note: ")?.split_once(": ")?;
            let word =
                ["reused", "rebuilt", "computed again"].into_iter().find(|word| what.contains(word))?;
            Some(format!("{stage} {word}"))
        };
        (std::fs::read(output).expect("a file"), ran.stderr.lines().filter_map(outcome).collect())
    }

    /// Builds without anything kept.
    fn plain(&self, problem: &Path) -> Vec<u8> {
        let output = self.path("plain.vdm");
        let arguments = ["build".as_ref(), problem.as_os_str(), "-o".as_ref(), output.as_os_str()];
        let ran = vademecum(&[&arguments[..], &["--keep-missed".as_ref(), "--fresh".as_ref()]].concat());
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        std::fs::read(output).expect("a file")
    }
}

#[test]
fn a_changed_input_rebuilds_what_depends_on_it_and_nothing_else() {
    let place = Place::new("[tolerance]\nsteps = 200\n");
    let (first, said) = place.build(&place.problem("", ""), &[]);
    assert_eq!(said, [""; 0]);
    let check = |from: &str, to: &str, expected: &[&str]| {
        let problem = place.problem(from, to);
        let (bytes, said) = place.build(&problem, &[]);
        assert_eq!(said, expected, "{from} -> {to}");
        assert!(bytes == place.plain(&problem), "{from} -> {to}: another file than without what is kept");
        bytes
    };
    assert!(check("", "", &["basis reused", "residual reused", "certificate reused"]) == first);
    check("name = \"tip\"", "name = \"end\"", &["basis reused", "residual reused", "certificate reused"]);
    check("steps = 200", "steps = 250", &["basis reused", "residual reused", "certificate rebuilt"]);
    check("modes = 4", "modes = 3", &["basis rebuilt", "residual rebuilt", "certificate rebuilt"]);
    check("young = 2e9", "young = 3e9", &["basis rebuilt", "residual rebuilt", "certificate rebuilt"]);
    // Back to what was built first.
    check("", "", &["basis reused", "residual reused", "certificate reused"]);
    let (fresh, said) = place.build(&place.problem("", ""), &["--fresh"]);
    assert!(fresh == first && said.is_empty(), "{said:?}");
}

#[test]
fn a_changed_range_leaves_the_samples_it_does_not_move() {
    let place = Place::new(PARAMETERS);
    let (first, said) = place.build(&place.problem("", ""), &[]);
    assert_eq!(said, [""; 0]);
    let stages = |count: usize, name: &str, word: &str| -> Vec<String> {
        (1..=count).map(|i| format!("{name}-{i} {word}")).collect()
    };
    let sorted = |mut lines: Vec<String>| {
        lines.sort();
        lines
    };
    let reused =
        [stages(3, "sample", "reused"), vec!["separation reused".into()], stages(4, "certificate", "reused")];
    let (again, said) = place.build(&place.problem("", ""), &[]);
    assert!(again == first);
    assert_eq!(sorted(said), sorted(reused.concat()));
    // The step moves no sample of the basis; the solution and the corners follow it.
    let problem = place.problem("[4e-4, 2e-3]", "[5e-4, 2e-3]");
    let (bytes, said) = place.build(&problem, &[]);
    let expected = [
        stages(3, "sample", "reused"),
        vec!["separation rebuilt".into()],
        stages(4, "certificate", "rebuilt"),
    ];
    assert_eq!(sorted(said), sorted(expected.concat()));
    assert!(bytes == place.plain(&problem));
    // The upper end of the stiffness moves one sample, and all that follows.
    let (_, said) = place.build(&place.problem("[0.8, 1.25]", "[0.8, 1.2]"), &[]);
    let samples: Vec<&String> = said.iter().filter(|line| line.starts_with("sample")).collect();
    assert_eq!(samples, ["sample-1 reused", "sample-2 reused", "sample-3 rebuilt"]);
}

#[test]
fn a_damaged_stage_is_computed_again() {
    let place = Place::new("");
    let problem = place.problem("", "");
    let (first, _) = place.build(&problem, &[]);
    for entry in std::fs::read_dir(place.path("work")).expect("the work folder") {
        let path = entry.expect("an entry").path();
        let mut bytes = std::fs::read(&path).expect("a stage");
        let middle = bytes.len() / 2;
        bytes[middle] ^= 0x10;
        std::fs::write(&path, bytes).expect("written");
    }
    let (again, said) = place.build(&problem, &[]);
    assert!(again == first);
    assert_eq!(said, ["basis computed again", "residual computed again", "certificate computed again"]);
    // The good results took the place of the damaged ones.
    assert_eq!(place.build(&problem, &[]).1, ["basis reused", "residual reused", "certificate reused"]);
}

#[test]
fn killed_again_and_again_a_build_ends_with_the_same_file_and_leaves_nothing_else() {
    let place = Place::new("");
    let problem = place.problem("", "");
    let start = Instant::now();
    let expected = place.plain(&problem);
    let whole = start.elapsed();
    let output = place.path("out.vdm");
    let arguments = ["build".as_ref(), problem.as_os_str(), "-o".as_ref(), output.as_os_str()];
    let mut random = Random::new(2);
    let mut kept = 0;
    for _ in 0..8 {
        let mut running =
            command(&arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("a run");
        std::thread::sleep(whole.mul_f64((random.number() + 1.0) * 0.5));
        let _ = running.kill();
        let _ = running.wait();
        kept += usize::from(place.path("out.vdm.work").exists());
        assert!(!output.exists() || std::fs::read(&output).expect("a file") == expected);
    }
    assert!(kept > 0, "no run was killed between its first stage and its end");
    assert_eq!(vademecum(&arguments).code, Some(0));
    assert!(std::fs::read(&output).expect("a file") == expected);
    let mut left: Vec<_> =
        place.folder.path().read_dir().expect("a folder").map(|e| e.expect("an entry").file_name()).collect();
    left.retain(|name| !name.to_string_lossy().ends_with(".part"));
    left.sort();
    assert_eq!(left, ["out.vdm", "p.toml", "plain.vdm"]);
}

/// Stops a build as soon as it has kept some runs, and hears what is used again.
struct Impatient {
    work: PathBuf,
    patient: bool,
    notes: Mutex<Vec<String>>,
}

impl Impatient {
    /// Names of the kept runs.
    fn runs(&self) -> Vec<String> {
        let entries = self.work.read_dir().into_iter().flatten().flatten();
        let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
        names.filter(|name| name.starts_with("runs-") && name.ends_with(".stage")).collect()
    }
}

impl Listener for Impatient {
    fn stage(&self, _: &str) {}
    fn advance(&self, _: usize, _: usize) {}
    fn note(&self, text: &str) {
        self.notes.lock().expect("notes").push(text.to_string());
    }
    fn cancelled(&self) -> bool {
        !self.patient && !self.runs().is_empty()
    }
}

#[test]
fn a_build_that_is_stopped_while_it_marches_keeps_the_runs_that_are_done() {
    for (name, more) in [("basis", ""), ("samples", PARAMETERS)] {
        let place = Place::new(more);
        let path = place.problem("positions = 2", "positions = 24");
        let (problem, work) = (Problem::read(&path).expect("a problem"), place.path("kept"));
        let store = Store::new(&work, false);
        let options = BuildOptions { store: Some(&store), ..BuildOptions::default() };
        let mut listener = Impatient { work, patient: false, notes: Mutex::default() };
        let stopped = build(&problem, &options, &listener).err().expect("stopped");
        assert!(is_cancelled(&stopped), "{name}: {stopped}");
        let kept = listener.runs();
        assert!(!kept.is_empty(), "{name}");
        listener.patient = true;
        let again = build(&problem, &options, &listener).expect("built").either().bytes;
        let notes = listener.notes.lock().expect("notes");
        let used = notes.iter().filter(|note| note.starts_with("runs-") && note.ends_with(": reused"));
        assert_eq!(used.count(), kept.len(), "{name}: {notes:?}");
        let plain = build(&problem, &BuildOptions::default(), &Silent).expect("built").either().bytes;
        assert!(again == plain, "{name}");
        // The basis is kept, and with it nobody needs the runs any more.
        assert_eq!(listener.runs(), [""; 0], "{name}");
    }
}

#[test]
fn a_build_that_could_not_write_its_file_is_refused_before_it_begins() {
    let place = Place::new("");
    let (problem, output) = (place.problem("", ""), place.path("none/out.vdm"));
    let ran = vademecum(&["build".as_ref(), problem.as_os_str(), "-o".as_ref(), output.as_os_str()]);
    ran.fails(1, &["none/out.vdm", "folder exists"]);
    assert_eq!(place.folder.path().read_dir().expect("a folder").count(), 1);
}
