//! Every way a command can fail: one exit code per cause, the chain of causes, and what to do.

mod machine;
#[cfg(test)]
mod tests;

use std::error::Error;
use std::fmt;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use vademecum_assembly::{AssemblyError, WorldRunError};
use vademecum_build::basis::BasisError;
use vademecum_build::dynamics::ModesError;
use vademecum_build::input::ProblemError;
use vademecum_build::input::toml_file::TomlError;
use vademecum_build::mesh::MeshError;
use vademecum_build::mesh_error::MeshErrorFailure;
use vademecum_build::pipeline::BuildError;
use vademecum_build::prepared::{BodyError, PrepareError};
use vademecum_build::printable::{printable, shortened};
use vademecum_build::progress::is_cancelled;
use vademecum_build::report::{MissedPart, ToleranceMissed};
use vademecum_build::store::OutputError as WriteError;
use vademecum_build::superelement::SuperelementError;
use vademecum_deck::DeckError;
use vademecum_eval::OutputError;
use vademecum_rewrite::RewriteError;
use vademecum_study::calibrate::CalibrateError;
use vademecum_study::scenario::ScenarioError;
use vademecum_study::state_space::StateSpaceError;
use vademecum_study::superelement::PortError;
use vademecum_study::table::TableFileError;
use vademecum_study::{FileError, StudyError};

use crate::looks::{Looks, look};

use machine::{Blame, MEMORY, blame};

/// Remedy for a mesh that was read and cannot be used.
const MESH: &str = "`vademecum mesh FILE` shows what the file holds and every problem found";

/// Remedy for a file that cannot be read.
pub(crate) const UNREAD: &str = "name a file that exists and that you may read";
/// Remedy for a path of another system.
const WINDOWS_PATH: &str =
    "write `/` for `\\` in the path, and a path of this system: `\\` is part of a name here";
/// Remedy for a failing disk.
const DISK: &str = "check that the folder exists, that you may write there, and that the disk has room";
/// Remedy for an inconsistent vademecum file.
pub(crate) const DAMAGED: &str =
    "the file was damaged after it was written, or not written by this program: copy or build it again";

/// Remedy for a file without a section.
const STRIPPED: &str = "either the file was stripped of it: use the one it was made of, or strip that one with `--keep \
                        surface`; or its problem does not give it, as `mesh.matrices` without `triangles`";

/// Remedy for a channel that the file does not have.
pub(crate) const CHANNEL: &str = "a channel is X,Y,Z,DIRECTION near the surface, such as 1,0.04,0.1,-z, or the name of a \
                                  probe, of an input also of a load pattern";

/// Reference of the keys of a problem file.
const PROBLEM_KEYS: &str = "`vademecum help problem` lists every key and its range";
/// Reference of the keys of a scenario file.
const SCENARIO_KEYS: &str = "`vademecum help scenario` lists every key and its range";

/// A failed command.
#[derive(Debug)]
pub struct Failure {
    cause: Cause,
    /// The vademecum file it is about.
    file: Option<PathBuf>,
    error: Box<dyn Error>,
    /// Results that were kept; empty without any.
    kept: String,
    /// Remedy; empty if the error names it.
    remedy: &'static str,
}

/// Cause of a failure: who can act.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The machine: disk, memory, permissions.
    Machine = 1,
    /// The arguments.
    Usage = 2,
    /// The problem or scenario file.
    Input = 3,
    /// The mesh.
    Mesh = 4,
    /// The model: a matrix that does not factorise, modes that do not converge.
    Numerics = 5,
    /// A tolerance is missed.
    Tolerance = 6,
    /// The vademecum file.
    File = 7,
    /// Ctrl-C.
    Stopped = 130,
}

impl Failure {
    /// A failure with its cause.
    pub fn new(cause: Cause, error: impl Into<Box<dyn Error>>) -> Self {
        Self { cause, file: None, error: error.into(), kept: String::new(), remedy: "" }
    }

    /// Says what to do.
    pub fn remedy(mut self, text: &'static str) -> Self {
        self.remedy = text;
        self
    }

    /// Names the vademecum file, if the failure is about one and does not name it yet.
    pub fn about(mut self, file: &Path) -> Self {
        if self.cause == Cause::File {
            self.file.get_or_insert_with(|| file.to_path_buf());
        }
        self
    }

    /// Names the file that it is about, whoever can act.
    pub(crate) fn within(mut self, file: &Path) -> Self {
        self.file.get_or_insert_with(|| file.to_path_buf());
        self
    }

    /// Says what was kept all the same.
    pub fn kept(mut self, text: String) -> Self {
        self.kept = text;
        self
    }

    /// A file that cannot be read or written.
    pub(crate) fn io(path: &Path, error: std::io::Error) -> Self {
        Self::new(Cause::Machine, format!("{}: {error}", path.display())).remedy(DISK)
    }

    /// A vademecum file that cannot be used.
    pub fn file(path: &Path, error: impl Into<FileError>) -> Self {
        Self::from(error.into()).about(path)
    }

    /// A study that failed, with the name of the vademecum file or of the scenario, whichever it is about.
    pub fn of_study(error: StudyError, file: &Path, scenario: &Path) -> Self {
        use StudyError as S;
        let of_scenario = matches!(
            error,
            S::NoPattern { .. }
                | S::ProbeTwice { .. }
                | S::ColumnTwice { .. }
                | S::NoStress
                | S::FarPoint { .. }
                | S::TooManySteps { .. }
                | S::Long { .. }
                | S::TooManyLoads { .. }
        );
        let mut failure = Self::from(error).about(file);
        if of_scenario {
            failure.file = Some(scenario.to_path_buf());
        }
        failure
    }

    /// A body that cannot be reduced to its interfaces.
    fn of_superelement(error: SuperelementError) -> Self {
        use SuperelementError as E;
        let cause = match &error {
            E::Shared { .. }
            | E::Dependent { .. }
            | E::Loose { .. }
            | E::NothingInside { .. }
            | E::NoResidual { .. }
            | E::NoModes { .. }
            | E::Modes(ModesError::Count { .. }) => Cause::Usage,
            E::Memory(_) => Cause::Machine,
            _ => Cause::Numerics,
        };
        Self::new(cause, error)
    }

    /// Tells it, and gives the process's exit code.
    pub fn tell(&self) -> u8 {
        eprintln!("{self}");
        self.exit_code()
    }

    /// Cause of a failure: who can act.
    pub fn cause(&self) -> Cause {
        self.cause
    }

    /// The process's exit code.
    pub(crate) fn exit_code(&self) -> u8 {
        self.cause as u8
    }
}

/// The error, its causes, the remedy. A cause whose text is part of its error's is left out: a stage within a
/// stage may name the same thing, as `the separated solution over the parameters` and
/// `the separated solution` do.
impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "error: ")?;
        if let Some(file) = &self.file {
            write!(f, "{}: ", file.display())?;
        }
        let mut source = self.error.source();
        let mut said = self.error.to_string();
        write!(f, "{}", printable(&shortened(&said)))?;
        while let Some(error) = source {
            let text = error.to_string();
            if !said.contains(&text) {
                write!(f, "\n  because: {}", printable(&shortened(&text)))?;
            }
            said = text;
            source = error.source();
        }
        if !self.kept.is_empty() {
            write!(f, "\n  kept: {}", self.kept)?;
        }
        if self.remedy.is_empty() { Ok(()) } else { write!(f, "\n  try: {}", self.remedy) }
    }
}

/// Tells in a sentence that the system refused memory or a thread, and ends the program.
///
/// The standard library's collections end the program by themselves then; matrices and threads panic.
pub(crate) fn end_where_memory_is_refused() {
    let others = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        let payload = info.payload();
        let owned = payload.downcast_ref::<String>().map(String::as_str);
        let words = owned.or_else(|| payload.downcast_ref::<&str>().copied()).unwrap_or_default();
        let allocation = words.split_once("AllocError { layout: Layout { size: ");
        let error = match allocation.and_then(|(_, layout)| layout.split(',').next()) {
            Some(bytes) => format!("the system refused a memory allocation of {bytes} bytes"),
            None if words.contains("ThreadPoolBuildError") => "the system refused to start a thread".into(),
            None => return others(info),
        };
        eprintln!("{}", Failure::new(Cause::Machine, error).remedy(MEMORY));
        std::process::exit(Cause::Machine as i32);
    }));
}

impl From<WriteError> for Failure {
    fn from(error: WriteError) -> Self {
        let (cause, remedy) = match &error {
            WriteError::Io { .. } | WriteError::NoFolder { .. } => (Cause::Machine, DISK),
            WriteError::NoSpace { .. } => (
                Cause::Machine,
                "larger `probes_every`, `fields_every` and `stress_every` under `[output]` of the scenario, or \
                 another disk",
            ),
            WriteError::OtherKind { .. } | WriteError::ReadOnly { .. } => {
                (Cause::Usage, "write to another path, or add `--force` to replace it")
            }
            WriteError::NotAFile { .. }
            | WriteError::NotAFolder { .. }
            | WriteError::Input { .. }
            | WriteError::Twice { .. } => (Cause::Usage, "write to another path"),
        };
        Self::new(cause, error).remedy(remedy)
    }
}

impl From<ProblemError> for Failure {
    fn from(error: ProblemError) -> Self {
        let remedy = match &error {
            ProblemError::Toml(error) => remedy_of_text(error, PROBLEM_KEYS, |looks| match looks {
                Looks::Vademecum => Some("it is built already: `vademecum info`, `run` and `view` take it"),
                Looks::Mesh => Some("`vademecum init MESH` writes a problem file for a mesh"),
                Looks::Scenario => {
                    Some("it is a scenario: `vademecum run FILE --scenario SCENARIO` plays it")
                }
                Looks::Assembly => Some("it is an assembly: `run`, `frf`, `view` and `assemble` take it"),
                _ => None,
            }),
            _ => PROBLEM_KEYS,
        };
        Self::new(Cause::Input, error).remedy(remedy)
    }
}

impl From<CalibrateError> for Failure {
    fn from(error: CalibrateError) -> Self {
        use CalibrateError as E;
        let (cause, remedy) = match error {
            E::Study(error) => return Self::from(error),
            E::Table(TableFileError::Unreadable { .. }) => (Cause::Machine, UNREAD),
            E::Table(_) => (Cause::Input, "`vademecum calibrate --help` shows what tables may hold"),
            E::NotParametric => (Cause::File, ""),
            E::Parameters { .. } | E::TooFew { .. } => (Cause::Usage, ""),
            E::NotFinite { .. } => (Cause::Numerics, "a smaller range of the parameters, or other data"),
        };
        Self::new(cause, error).remedy(remedy)
    }
}

impl From<ScenarioError> for Failure {
    fn from(error: ScenarioError) -> Self {
        let remedy = remedy_of_text(&error.0, SCENARIO_KEYS, |looks| match looks {
            Looks::Vademecum => Some("give the vademecum file first, and the scenario with `--scenario`"),
            Looks::Problem => {
                Some("it is a problem: `vademecum build PROBLEM -o FILE` makes a vademecum of it")
            }
            _ => None,
        });
        Self::new(Cause::Input, error).remedy(remedy)
    }
}

/// Remedy for a file that should hold a problem or a scenario: the one that fits its actual kind,
/// or else where the keys are described.
fn remedy_of_text(
    error: &TomlError,
    keys: &'static str,
    instead: impl Fn(Looks) -> Option<&'static str>,
) -> &'static str {
    match error {
        TomlError::Unreadable { source, path } if source.kind() == ErrorKind::NotFound => unread(path),
        TomlError::Unreadable { path, .. } => instead(look(Path::new(path))).unwrap_or(""),
        TomlError::Malformed { path, .. } => instead(look(Path::new(path))).unwrap_or(keys),
        TomlError::TooLong { .. } | TomlError::Impossible { .. } => keys,
    }
}

impl From<MeshError> for Failure {
    fn from(error: MeshError) -> Self {
        let remedy = remedy_of_mesh(&error);
        Self::new(Cause::Mesh, error).remedy(remedy)
    }
}

impl From<AssemblyError> for Failure {
    fn from(error: AssemblyError) -> Self {
        let (cause, remedy) = match &error {
            AssemblyError::File(_) => (Cause::Input, "`vademecum schema assembly` has every key"),
            AssemblyError::Redundant { .. } | AssemblyError::Free { .. } => (Cause::Input, ""),
            AssemblyError::Unreadable { .. } => (Cause::Machine, ""),
            AssemblyError::Part { .. }
            | AssemblyError::Fault { .. }
            | AssemblyError::Parameters { .. }
            | AssemblyError::Kind { .. }
            | AssemblyError::Missing { .. } => (Cause::File, ""),
            AssemblyError::NoConvergence | AssemblyError::Format(_) => (Cause::Numerics, ""),
        };
        Self::new(cause, error).remedy(remedy)
    }
}

impl From<WorldRunError> for Failure {
    fn from(error: WorldRunError) -> Self {
        let cause = match error {
            WorldRunError::Assembly(error) => return error.into(),
            WorldRunError::Cancelled(_) => return Self::new(Cause::Stopped, "stopped on request"),
            WorldRunError::Surface { .. } => Cause::Mesh,
            WorldRunError::Bind { .. } | WorldRunError::Output { .. } => Cause::File,
            WorldRunError::World { .. } => Cause::Input,
            WorldRunError::Step { .. } => Cause::Numerics,
        };
        Self::new(cause, error)
    }
}

impl From<DeckError> for Failure {
    fn from(error: DeckError) -> Self {
        let cause = match error {
            DeckError::Mesh(error) => return error.into(),
            DeckError::Card(_)
            | DeckError::NoMaterial { .. }
            | DeckError::Incomplete { .. }
            | DeckError::TurningAxes { .. }
            | DeckError::OwnRotations { .. }
            | DeckError::Contradiction(_)
            | DeckError::Load(_)
            | DeckError::UnknownUnits { .. }
            | DeckError::NoStaticStep { .. } => Cause::Input,
            DeckError::Structural(_) => Cause::Mesh,
            DeckError::Model(_)
            | DeckError::NotHeld { .. }
            | DeckError::Buckled { .. }
            | DeckError::Factor(_)
            | DeckError::Modes(_) => Cause::Numerics,
        };
        Self::new(cause, error)
    }
}

impl From<BuildError> for Failure {
    fn from(error: BuildError) -> Self {
        if is_cancelled(&error) {
            return Self::new(Cause::Stopped, "stopped on request; nothing was written");
        }
        match blame(&error) {
            Some(Blame::Machine(remedy)) => return Self::new(Cause::Machine, error).remedy(remedy),
            Some(Blame::Library) => return Self::new(Cause::Numerics, error),
            None => {}
        }
        let (cause, remedy) = match &error {
            BuildError::Memory(_) | BuildError::Prepare(PrepareError::Memory(_)) => (Cause::Machine, ""),
            BuildError::Work(_)
            | BuildError::TimeStep(_)
            | BuildError::PatchSize { .. }
            | BuildError::RatiosBeyond { .. }
            | BuildError::RatiosOfOneFrequency { .. } => (Cause::Input, ""),
            BuildError::Prepare(PrepareError::Body(BodyError::Mesh(error))) => {
                (Cause::Mesh, remedy_of_mesh(error))
            }
            BuildError::Prepare(PrepareError::Body(BodyError::Model { .. })) => (
                Cause::Numerics,
                "check `[[support]]` (all six rigid motions must be held) and `[[material]]`",
            ),
            BuildError::Modes(ModesError::LostInRounding { .. })
            | BuildError::Prepare(PrepareError::Modes(ModesError::LostInRounding { .. }))
            | BuildError::Basis(BasisError::Modes(ModesError::LostInRounding { .. })) => (
                Cause::Numerics,
                "hold every part of the body; thicken or refine what is a thousand times as long as thick",
            ),
            BuildError::Prepare(PrepareError::NotDefinite { .. }) => {
                (Cause::Numerics, "leave held dofs and dofs without mass out of the matrices")
            }
            BuildError::Prepare(
                PrepareError::Factor(_)
                | PrepareError::Modes(_)
                | PrepareError::Body(BodyError::Buckled { .. }),
            ) => (Cause::Numerics, ""),
            BuildError::Prepare(_) => (Cause::Input, PROBLEM_KEYS),
            BuildError::Basis(
                BasisError::Snapshots(_) | BasisError::TooManyModes { .. } | BasisError::BoundMissed { .. },
            ) => (Cause::Input, ""),
            BuildError::MeshError(MeshErrorFailure::Disc { .. }) => (Cause::Usage, ""),
            BuildError::Format(_) => (Cause::File, ""),
            _ => (Cause::Numerics, ""),
        };
        Self::new(cause, error).remedy(remedy)
    }
}

impl From<PrepareError> for Failure {
    fn from(error: PrepareError) -> Self {
        BuildError::from(error).into()
    }
}

impl From<StudyError> for Failure {
    fn from(error: StudyError) -> Self {
        match error {
            StudyError::Build(error) => error.into(),
            StudyError::File(error) => error.into(),
            error if is_cancelled(&error) => Self::new(Cause::Stopped, "stopped on request"),
            StudyError::Interface(error) => Self::new(Cause::Usage, error),
            StudyError::Superelement(error) => Self::of_superelement(error),
            StudyError::Ports(error @ PortError::Fault(_)) => Self::new(Cause::File, error),
            StudyError::Ports(error) => Self::new(Cause::Usage, error),
            error @ StudyError::TableFile(TableFileError::Unreadable { .. }) => {
                Self::new(Cause::Machine, error).remedy(UNREAD)
            }
            error @ (StudyError::TableFile(_)
            | StudyError::NoPattern { .. }
            | StudyError::ForeignPattern { .. }
            | StudyError::ForeignProbe { .. }
            | StudyError::NoChannel { .. }
            | StudyError::Field(_)
            | StudyError::Uff(_)
            | StudyError::ModeRows { .. }
            | StudyError::ModalDamping
            | StudyError::ProbeTwice { .. }
            | StudyError::ColumnTwice { .. }
            | StudyError::NoStress
            | StudyError::FarPoint { .. }) => Self::new(Cause::Input, error),
            error @ StudyError::TooManySteps { .. } => {
                Self::new(Cause::Input, error).remedy("a shorter `duration`")
            }
            error @ StudyError::Long { .. } => Self::new(Cause::Input, error)
                .remedy("a shorter `duration`; or `--long` marches all of them (`export`: `--steps N`)"),
            error @ StudyError::TooManyLoads { .. } => Self::new(Cause::Input, error)
                .remedy("split the scenario: the full-order march keeps every load over all dofs"),
            // Given on the command line.
            error @ (StudyError::Sensors(_)
            | StudyError::NoParameter { .. }
            | StudyError::OutsideRange { .. }
            | StudyError::TimeStepTwice { .. }) => Self::new(Cause::Usage, error),
            error @ (StudyError::TooFast { .. }
            | StudyError::TooManyPlaces { .. }
            | StudyError::NoModalMarch
            | StudyError::FreeByStages
            | StudyError::LargeDisplacements) => Self::new(Cause::Input, error),
            error @ StudyError::Refused { .. } => Self::new(Cause::File, error),
            error @ StudyError::NothingToPush => {
                Self::new(Cause::Input, error).remedy("name a scenario of load patterns: `--scenario FILE`")
            }
            error @ StudyError::NoModes { .. } => {
                Self::new(Cause::Input, error).remedy("ask for fewer `--modes`, or add to `[snapshots]`")
            }
            error => Self::new(Cause::Numerics, error),
        }
    }
}

impl From<StateSpaceError> for Failure {
    fn from(error: StateSpaceError) -> Self {
        use StateSpaceError as E;
        match error {
            // Both are of the command line.
            E::Study(error @ (StudyError::NoChannel { .. } | StudyError::FarPoint { .. })) => {
                Self::new(Cause::Usage, error).remedy(CHANNEL)
            }
            E::Study(error) => error.into(),
            error @ (E::NoInputs
            | E::NoOutputs
            | E::Twice { .. }
            | E::BetweenRegions { .. }
            | E::NoSupport { .. }) => Self::new(Cause::Usage, error),
            error @ (E::LargeDisplacements | E::Chapter | E::NotExact { .. } | E::NoStress) => {
                Self::new(Cause::File, error)
            }
        }
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        let remedy = match &error {
            FileError::Rewrite(error) => remedy_of_rewriting(error),
            FileError::Needed { .. } => {
                "keep more: `--keep surface` or `--keep all`; or build it with what is missing"
            }
            FileError::Format(_) | FileError::Unstable { .. } => DAMAGED,
            FileError::ForeignMesh { .. } => "build the file again from this problem",
            FileError::Missing { .. }
            | FileError::NoSurface
            | FileError::Output(OutputError::Missing { .. }) => STRIPPED,
            _ => "",
        };
        let cause = match &error {
            FileError::Rewrite(RewriteError::Memory { .. }) => Cause::Machine,
            _ => Cause::File,
        };
        Self::new(cause, error).remedy(remedy)
    }
}

/// Remedy for a file that is not there. A path of Windows is one long name elsewhere.
fn unread(path: &str) -> &'static str {
    if cfg!(not(windows)) && path.contains('\\') { WINDOWS_PATH } else { UNREAD }
}

/// Remedy for a mesh. A file that breaks its format's rules says so itself, and `vademecum mesh` would
/// say the same.
fn remedy_of_mesh(error: &MeshError) -> &'static str {
    match error {
        MeshError::Unsound { .. } => MESH,
        MeshError::Io { file, .. } => unread(&file.to_string_lossy()),
        MeshError::UnknownFormat { .. } => {
            "save the mesh in one of these formats; `.inp`, `.mesh`, `.node` and `.ele` go by their names"
        }
        _ => "",
    }
}

/// Remedy for a file that cannot be rewritten, or does not pass its check.
fn remedy_of_rewriting(error: &RewriteError) -> &'static str {
    match error {
        RewriteError::Unknown { .. } => "use the version of this program that wrote the file, or a later one",
        RewriteError::Absent { .. } => {
            "strip the file it was made from, or build it again with what is missing"
        }
        RewriteError::Tolerance { .. } => {
            "1e-4 is coarse enough to ship and fine enough to see no difference"
        }
        RewriteError::NoTerms { .. } => "use the file as it is, or allow a larger tolerance",
        RewriteError::NothingToStrip { .. } => "use the file as it is",
        RewriteError::TooLarge { .. } => {
            "if you trust the file, allow more with `--limit`, such as `--limit 4G`"
        }
        RewriteError::Memory { .. } => "end other programs, or use a machine with more memory",
        _ => DAMAGED,
    }
}

impl From<ToleranceMissed> for Failure {
    fn from(error: ToleranceMissed) -> Self {
        let remedy = match error.0.missed_part() {
            MissedPart::NotANumber => {
                "check units, materials, `time.step` and loads: a number left the range of double precision"
            }
            MissedPart::Stability => {
                "`basis.kind = \"ritz\"`, other `[snapshots]`, or `--keep-missed` to write it all the same"
            }
            MissedPart::StabilityOverParameters => {
                "`--repair`, which adds terms until the step is stable; a smaller `tolerance.map`; narrower ranges of \
                 the live parameters"
            }
            MissedPart::MapsTerms => {
                "a larger `tolerance.max_terms`, a larger `tolerance.map`, narrower ranges of the live parameters, or \
                 `--keep-missed` to write it all the same"
            }
            MissedPart::MapsStagnated => {
                "a larger `tolerance.map` (more `tolerance.max_terms` did not lower it), narrower ranges of the live \
                 parameters, or `--keep-missed` to write it all the same"
            }
            MissedPart::Energy => {
                "more `basis.modes`, `basis.kind = \"ritz\"`, or `--keep-missed` to write it all the same"
            }
            MissedPart::Trajectory => {
                "more `basis.modes` or `basis.oversampling`, more `snapshots.positions`, or `--keep-missed` to write \
                 it all the same"
            }
            MissedPart::Ceiling if error.0.snapshots == 0 => {
                "more `basis.modes`; a mesh in the unit of the materials (`mesh.scale = 0.001` if it is in millimetres \
                 and they are in SI); or a larger `tolerance.error` that says which error you accept"
            }
            MissedPart::Ceiling => {
                "more `basis.modes`; snapshots of whole periods (leave `snapshots.duration` out); a mesh in the unit \
                 of the materials (`mesh.scale = 0.001` if it is in millimetres and they are in SI); or a larger \
                 `tolerance.error` that says which error you accept"
            }
        };
        // A tolerance is missed by a number only.
        let cause = match error.0.missed_part() {
            MissedPart::NotANumber => Cause::Numerics,
            _ => Cause::Tolerance,
        };
        Self::new(cause, error).remedy(remedy)
    }
}
