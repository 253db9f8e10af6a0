//! The folder of one iteration, and every command that ran in it.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::dice::Dice;
use super::invariant::{CODES, Held, ended_well, nothing_left};
use super::launch::{Ended, Launch};
use super::texts::{self, Problem};

/// One iteration's program, folder and choices.
pub struct Place<'a> {
    program: &'a Path,
    folder: PathBuf,
    /// A run that takes longer is a finding.
    pub limit: Duration,
    commands: RefCell<Vec<String>>,
}

impl<'a> Place<'a> {
    /// In a folder that is there.
    #[must_use]
    pub fn new(program: &'a Path, folder: &Path, limit: Duration) -> Self {
        Self { program, folder: folder.into(), limit, commands: RefCell::default() }
    }

    /// The folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// A path in the folder.
    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Every command so far, as it would be typed.
    #[must_use]
    pub fn commands(&self) -> Vec<String> {
        self.commands.borrow().clone()
    }

    /// The bytes of a file, none if it is not there.
    #[must_use]
    pub fn read(&self, name: &str) -> Option<Vec<u8>> {
        std::fs::read(self.path(name)).ok()
    }

    /// Writes a file.
    ///
    /// # Panics
    /// If it cannot be written.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), bytes).expect("a folder of ours");
    }

    /// Runs the program; arguments are separated by blanks, files are those of the folder.
    #[must_use]
    pub fn run(&self, line: &str) -> Ended {
        self.launch(&Launch::new(&line.split(' ').collect::<Vec<_>>(), self.limit))
    }

    /// The same, prepared.
    #[must_use]
    pub fn launch(&self, launch: &Launch) -> Ended {
        self.commands.borrow_mut().push(launch.line());
        launch.run(self.program, &self.folder)
    }

    /// A run that must end with one of these codes.
    ///
    /// # Errors
    /// [`super::invariant::Breach`].
    pub fn ends(&self, line: &str, codes: &[i32]) -> Result<Ended, super::invariant::Breach> {
        let ended = self.run(line);
        ended_well(&ended, codes)?;
        Ok(ended)
    }

    /// A random problem `p.toml` built to `a.vdm`; none if it was refused, as a random one may be.
    ///
    /// # Errors
    /// [`super::invariant::Breach`]: refused in another way than documented, or sound by its code and not by
    /// its file.
    pub fn build(&self, dice: &mut Dice) -> Result<Option<Built>, super::invariant::Breach> {
        let problem = texts::problem(dice);
        self.write("p.toml", &problem.text);
        let keep = if problem.canonical || dice.once_in(2) { " --keep-missed" } else { "" };
        let ended = self.ends(&format!("build p.toml -o a.vdm{keep}"), &CODES)?;
        let bytes = self.read("a.vdm");
        match (ended.code, bytes) {
            (Some(0), Some(bytes)) => {
                self.ends("verify a.vdm --file-only", &[0])?;
                self.left_nothing()?;
                Ok(Some(Built { problem, bytes, kept: keep.is_empty(), seconds: ended.seconds }))
            }
            (Some(0), None) => super::invariant::breach("old or new", "a build of code 0 wrote no file"),
            (_, Some(_)) => super::invariant::breach("old or new", "a build that failed wrote a file"),
            (_, None) => Ok(None),
        }
    }

    /// No temporary file is in the folder.
    ///
    /// # Errors
    /// [`super::invariant::Breach`].
    pub fn left_nothing(&self) -> Held {
        nothing_left(&self.folder)
    }
}

/// A file that the program built.
pub struct Built {
    /// Its problem.
    pub problem: Problem,
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// It keeps its tolerance: it was built without `--keep-missed`.
    pub kept: bool,
    /// How long it took.
    pub seconds: f64,
}
