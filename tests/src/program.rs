//! The built program, as a user runs it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// The program's path; the first call has cargo build it, in the profile the tests were built in.
///
/// # Panics
/// If it does not build.
#[must_use]
pub fn program() -> PathBuf {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| build("vademecum-cli", "vademecum")).clone()
}

/// The laboratory's path, built as [`program`] is.
///
/// # Panics
/// If it does not build.
#[must_use]
pub fn lab() -> PathBuf {
    static LAB: OnceLock<PathBuf> = OnceLock::new();
    LAB.get_or_init(|| build("vademecum-lab", "vademecum-lab")).clone()
}

fn build(package: &str, name: &str) -> PathBuf {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["build", "--quiet", "--package", package]).current_dir(repository());
    if !cfg!(debug_assertions) {
        cargo.arg("--release");
    }
    assert!(cargo.status().expect("cargo").success(), "the program does not build");
    // A test lies in <target>/<profile>/deps, a record in …/examples or beside the program.
    let running = std::env::current_exe().expect("the test's own path");
    let inner = |folder: &Path| folder.ends_with("deps") || folder.ends_with("examples");
    let profile = running.ancestors().skip(1).find(|folder| !inner(folder)).expect("a profile folder");
    profile.join(format!("{name}{}", std::env::consts::EXE_SUFFIX))
}

/// The repository's folder.
#[must_use]
pub fn repository() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// Name and bytes of every file in a folder of `fixtures`, by name.
///
/// # Panics
/// If one cannot be read.
#[must_use]
pub fn fixtures(folder: &str) -> Vec<(String, Vec<u8>)> {
    let entries =
        std::fs::read_dir(repository().join("fixtures").join(folder)).expect("a folder of fixtures");
    let mut files: Vec<_> = entries
        .map(|entry| {
            let path = entry.expect("an entry").path();
            let name = path.file_name().expect("a name").to_string_lossy().into_owned();
            (name, std::fs::read(path).expect("readable"))
        })
        .collect();
    files.sort();
    files
}

/// What a run of the program gave.
pub struct Ran {
    /// Exit code; `None` after a signal.
    pub code: Option<i32>,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Ran {
    /// From what the system gave.
    #[must_use]
    pub fn new(output: &Output) -> Self {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        Self { code: output.status.code(), stdout: text(&output.stdout), stderr: text(&output.stderr) }
    }

    /// Standard output as JSON.
    ///
    /// # Panics
    /// If the run failed or printed something else.
    #[must_use]
    pub fn json(&self) -> serde_json::Value {
        assert_eq!(self.code, Some(0), "{}", self.stderr);
        serde_json::from_str(&self.stdout).expect("JSON on standard output")
    }

    /// Asserts the exit code and that the error names all of `parts`.
    ///
    /// # Panics
    /// If not.
    pub fn fails(&self, code: i32, parts: &[&str]) {
        assert_eq!(self.code, Some(code), "{}", self.stderr);
        for part in parts {
            assert!(self.stderr.contains(part), "`{part}` is not named in: {}", self.stderr);
        }
    }
}

/// Runs the program, quietly.
///
/// # Panics
/// If it cannot be started.
#[must_use]
pub fn vademecum<S: AsRef<std::ffi::OsStr>>(arguments: &[S]) -> Ran {
    Ran::new(&command(arguments).output().expect("the program starts"))
}

/// The program with these arguments, yet to be run; those of `bench` go to the laboratory.
#[must_use]
pub fn command<S: AsRef<std::ffi::OsStr>>(arguments: &[S]) -> Command {
    let is_bench = arguments.first().is_some_and(|first| first.as_ref() == "bench");
    let mut command = Command::new(if is_bench { lab() } else { program() });
    command.arg("--quiet").args(arguments);
    command
}
