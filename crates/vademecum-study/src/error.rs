//! Errors of a study.
//!
//! No error here names the vademecum file it is about: a study is handed bytes and does not know where they
//! came from. The caller, who knows, puts the name in front of a [`FileError`].

use std::path::PathBuf;

use vademecum_build::basis::{BasisError, SnapshotError};
use vademecum_build::certificate::CertificateError;
use vademecum_build::dynamics::large::LargeError;
use vademecum_build::dynamics::{
    FullOrderError, HarmonicError, MarchError, ModesError, ReferenceError, SchemeError, TooMuchWork,
};
use vademecum_build::fem::{ElementError, FactorError, GreenError};
use vademecum_build::field::FieldError;
use vademecum_build::measured::NotMeasured;
use vademecum_build::mesh_error::MeshErrorFailure;
use vademecum_build::parametric::ParametricError;
use vademecum_build::pipeline::BuildError;
use vademecum_build::prepared::{BodyError, InterfaceError, PrepareError, TimeStepError};
use vademecum_build::progress::Cancelled;
use vademecum_build::response::ResponseError;
use vademecum_build::superelement::SuperelementError;
use vademecum_chapter::{ChapterBindError, ChapterError, ChapterLoadError, ChapterStepError};
use vademecum_eval::{BindError, LoadError, OpenError, OutputError, StepError};
use vademecum_format::scheme::TableError;
use vademecum_format::{FormatError, SectionKind};
use vademecum_rewrite::RewriteError;

use crate::sensors::SensorError;
use crate::superelement::PortError;
use crate::table::TableFileError;
use crate::uff::UffError;

/// Cause of numbers that grow without end, and what to do.
pub(crate) const LARGE_MOTION: &str = "the motion is so large that its square leaves the range of a double: lower the forces \
                                       of the scenario, or see in `info FILE` whether the step is stable";

/// Errors of a study.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// A build behind it failed.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The full-order march failed.
    #[error(transparent)]
    March(#[from] MarchError),
    /// The march at full order, at large displacements, failed.
    #[error("the march at full order, at large displacements")]
    LargeMarch(#[from] LargeError),
    /// There is no reference that is exact in time.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// The scheme refuses a parameter.
    #[error("`time.scheme`")]
    Table(#[from] TableError),
    /// The scheme's parameters are unusable.
    #[error("`time.scheme`")]
    Scheme(#[from] SchemeError),
    /// A vademecum file cannot be used for what is asked.
    #[error(transparent)]
    File(#[from] FileError),
    /// An interface of a superelement does not fit the body.
    #[error(transparent)]
    Interface(#[from] InterfaceError),
    /// A body that cannot be reduced to its interfaces.
    #[error(transparent)]
    Superelement(#[from] SuperelementError),
    /// A file gives no superelement at its ports.
    #[error(transparent)]
    Ports(#[from] PortError),
    /// An archive of arrays cannot be written.
    #[error("the archive of arrays")]
    Archive(#[from] zip::result::ZipError),
    /// Large displacements, where methods of linear motion are compared.
    #[error(
        "`model = \"large-displacement\"`: the methods that are compared here are those of linear motion; those of \
         large displacements are compared by `compare_large_methods`"
    )]
    LargeDisplacements,
    /// The scenario has a load pattern that the file does not have.
    #[error("the file has no load pattern `{name}`; known: {known}")]
    NoPattern {
        /// The pattern's name.
        name: String,
        /// Names of the patterns there are, or `none`.
        known: String,
    },
    /// The file has a load pattern that the problem does not have.
    #[error("the problem has no load pattern `{name}`, the file has")]
    ForeignPattern {
        /// The pattern's name.
        name: String,
    },
    /// The file has a probe that the problem does not have.
    #[error("the problem has no probe `{name}`, the file has")]
    ForeignProbe {
        /// The probe's name.
        name: String,
    },
    /// The file has no probe or load pattern of a name.
    #[error("the file has no {what} `{name}`; known: {known}")]
    NoChannel {
        /// The name.
        name: String,
        /// `probe` or `load pattern`.
        what: &'static str,
        /// Those the file has.
        known: String,
    },
    /// A field or matrix of another program cannot be read.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// A universal file cannot be used or written.
    #[error(transparent)]
    Uff(#[from] UffError),
    /// There are no places of sensors as they are asked for.
    #[error(transparent)]
    Sensors(#[from] SensorError),
    /// Modes of another program belong to another mesh.
    #[error("{}: {found} rows; expected {expected}, three for each node of the mesh", .file.display())]
    ModeRows {
        /// The file.
        file: PathBuf,
        /// Its rows.
        found: usize,
        /// Three times the number of nodes.
        expected: usize,
    },
    /// Damping ratios are no matrix of the full order.
    #[error(
        "the full order has no matrix for modal damping ratios; `--compare` needs a problem without them: dashpots \
         and Rayleigh damping (`alpha`, `beta`) are matrices"
    )]
    ModalDamping,
    /// Matrices whose rows are not dofs of nodes alone.
    #[error(
        "the matrices of a body with couplings, ties, masses or springs are not exported: their rows are not the \
         dofs of its nodes"
    )]
    AttachedMatrices,
    /// Schemes that march by stages take no body without supports.
    #[error(
        "a body without supports is not marched by stages, which matrices for other programs and comparisons of \
         schemes are made for: hold it by a `[[support]]`; `build`, `run`, `verify` and `frf` take it as it is"
    )]
    FreeByStages,
    /// The stress of an element cannot be taken.
    #[error("the stress of an element")]
    Stress(#[from] ElementError),
    /// The full order has no response to a harmonic force.
    #[error(transparent)]
    Harmonic(#[from] HarmonicError),
    /// The scenario has a probe of a name that the file has.
    #[error("`output.probe`: the file has a probe `{name}` already; give this one another name")]
    ProbeTwice {
        /// The name.
        name: String,
    },
    /// Two columns of the table of probes would have one name.
    #[error(
        "two columns of the table of probes have the name `{name}`: give the probe, stress or support of this \
         name another one, in the scenario or, where the file has it, in the problem file"
    )]
    ColumnTwice {
        /// The name.
        name: String,
    },
    /// The scenario asks for a stress that the file does not have.
    #[error(
        "`output.stress`: the file has no stress; add `[output] stress = \"surface\"` to the problem file and build it again"
    )]
    NoStress,
    /// A contact of a scenario or a point of a question is nowhere near the body.
    #[error(
        "{what} is {distance:.3e} away from the loadable surface, which reaches from {} to {}; \
         expected a point on it: is it in the unit of the file?",
        place(*low),
        place(*high)
    )]
    FarPoint {
        /// The contact or the point, as the message begins.
        what: String,
        /// Distance to the nearest point of the loadable surface.
        distance: f64,
        /// Lower corner of the box around the loadable surface.
        low: [f64; 3],
        /// Its upper corner.
        high: [f64; 3],
    },
    /// A scenario has more steps than can be counted.
    #[error(
        "`duration` is {duration:e} s, which is {:.3e} steps of {time_step:e} s; expected at most 2^53 \
         (9.0e15) steps, beyond which n Δt no longer tells one instant from the next",
        duration / time_step
    )]
    TooManySteps {
        /// Length \[s\].
        duration: f64,
        /// Step \[s\].
        time_step: f64,
    },
    /// A scenario has more steps than are marched unless it is asked for.
    #[error(
        "`duration` is {duration:e} s, which is {steps} steps of {time_step:e} s; more than {limit} steps \
         are marched on request only"
    )]
    Long {
        /// Length \[s\].
        duration: f64,
        /// Step \[s\].
        time_step: f64,
        /// Its steps.
        steps: usize,
        /// Most steps of a march that is not asked for.
        limit: u64,
    },
    /// Matrices and a march at full order have no damping ratios of modes.
    #[error(
        "the problem has `damping.modal`, `damping.ratio` or a `loss_factor`, which the full order cannot be marched with; \
         expected `alpha` and `beta`, or `ratios`"
    )]
    NoModalMarch,
    /// A load changes too fast for the step.
    #[error(
        "`{load}` has up to {frequency:e} Hz, which is {:.1} periods in a step of {time_step:e} s; expected at \
         most {most}: take a shorter step or a lower frequency",
        frequency * time_step
    )]
    TooFast {
        /// The load.
        load: String,
        /// Its highest frequency \[Hz\].
        frequency: f64,
        /// Step \[s\].
        time_step: f64,
        /// Most periods in a step.
        most: f64,
    },
    /// A path is too long for the triangles it runs over.
    #[error(
        "`contact[{contact}].path` takes more than {most} places, four on each mean edge of the loadable \
         triangles ({edge:e}); expected a path on the body: shorten it"
    )]
    TooManyPlaces {
        /// Number of the contact.
        contact: usize,
        /// Mean edge \[m\].
        edge: f64,
        /// Most places.
        most: usize,
    },
    /// All loads of a scenario at full order do not fit into memory.
    #[error(
        "{loads} loads of {dofs} dofs each take {:.1} GB at full order; expected at most {:.0} GB",
        *bytes as f64 / 1e9,
        *limit as f64 / 1e9
    )]
    TooManyLoads {
        /// Contacts and patterns.
        loads: usize,
        /// Free dofs.
        dofs: usize,
        /// Bytes of all of them.
        bytes: u64,
        /// Most bytes taken.
        limit: u64,
    },
    /// A figure of a comparison was not measured.
    #[error(transparent)]
    NotMeasured(#[from] NotMeasured),
    /// A result is not a finite number.
    #[error("at t = {time:e} s (step {step}) {what} is {value}; {cause}")]
    NotFinite {
        /// Time \[s\].
        time: f64,
        /// Step.
        step: usize,
        /// Name of the quantity.
        what: String,
        /// The value.
        value: f64,
        /// The likely cause, and what to do.
        cause: &'static str,
    },
    /// A step was refused.
    #[error("the step from t = {time:e} s (step {step}) cannot be taken")]
    Refused {
        /// Time \[s\] before the step.
        time: f64,
        /// Steps taken before.
        step: usize,
        /// Cause.
        source: FileError,
    },
    /// A parametric model that cannot be set.
    #[error(transparent)]
    Model(#[from] vademecum_eval::ParametricError),
    /// A table of numbers that cannot be used.
    #[error(transparent)]
    TableFile(#[from] TableFileError),
    /// The file has no live parameter of this name.
    #[error("the file has no live parameter `{name}`; known: {known}")]
    NoParameter {
        /// The name asked for.
        name: String,
        /// Names and ranges of the parameters there are, or `none`.
        known: String,
    },
    /// A value lies outside of the range a live parameter was built for.
    #[error("`{name}` is {value}; expected a value from {lower} to {upper}, for which the file was built")]
    OutsideRange {
        /// The parameter.
        name: String,
        /// The value.
        value: f64,
        /// Smallest value.
        lower: f64,
        /// Largest value.
        upper: f64,
    },
    /// The time step is given twice.
    #[error("the time step is given twice, as the parameter `{name}` and by itself; give it once")]
    TimeStepTwice {
        /// The parameter.
        name: String,
    },
    /// A push was asked for, and there is nothing to push.
    #[error("the body has no surface that a push could act on")]
    NothingToPush,
    /// Every number of modes asked for is more than the snapshots span.
    #[error("no number of modes is left to compare: the snapshots span {span} dimensions")]
    NoModes {
        /// Dimension of the snapshots.
        span: usize,
    },
    /// The spectral radius of the step was not found.
    #[error("the spectral radius of the step")]
    Radius(#[from] CertificateError),
    /// On request.
    #[error("stopped on request")]
    Cancelled(#[from] Cancelled),
}

/// A point as messages have it.
pub(crate) fn place([x, y, z]: [f64; 3]) -> String {
    format!("({x:.6}, {y:.6}, {z:.6})")
}

/// Errors of the use of a vademecum file.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// It cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// It is refused, or a section of it is.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// Its sections cannot be decoded or rewritten.
    #[error(transparent)]
    Rewrite(#[from] RewriteError),
    /// The evaluator does not bind it.
    #[error(transparent)]
    Bind(#[from] BindError),
    /// The evaluator refuses a load.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// The evaluator's step failed.
    #[error(transparent)]
    Step(#[from] StepError),
    /// The evaluator has no such output.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Its chapter's structure does not bind.
    #[error(transparent)]
    BindChapter(#[from] ChapterBindError),
    /// The chapter's structure refuses a load.
    #[error(transparent)]
    LoadChapter(#[from] ChapterLoadError),
    /// A step of the chapter's structure failed.
    #[error(transparent)]
    StepChapter(#[from] ChapterStepError),
    /// The chapter's structure takes no load patterns.
    #[error("the chapter's structure is built for loads at nodes and takes no load patterns")]
    NoPatterns,
    /// The chapter's structure knows only the sum of its energies.
    #[error(
        "the chapter's structure has none of `output.quantities`; `energy_J` of `probes.csv` is its energy"
    )]
    NoQuantities,
    /// A contact moves, and the maps have an axis for the node a load stands at.
    #[error(
        "the chapter's structure is built for loads at nodes, and a contact with a `path` stands at none"
    )]
    NoPaths,
    /// A scenario throws a body that is held.
    #[error("the scenario has `[free]`, and the file holds a body with supports; leave `[free]` out")]
    NotFree,
    /// It does not have a section.
    #[error("the file has no section {kind}")]
    Missing {
        /// The section.
        kind: SectionKind,
    },
    /// It has no surface that takes contacts.
    #[error("the file has no loadable surface, so contacts cannot act")]
    NoSurface,
    /// Its step is less stable than its certificate says and than the policy asks.
    #[error(
        "the step of the {structure} structure{place} has the spectral radius {radius:e}; its certificate \
         and the rules of stability allow {allowed:e}"
    )]
    Unstable {
        /// The structure.
        structure: &'static str,
        /// At which values of the parameters; empty for those of the problem.
        place: String,
        /// The radius.
        radius: f64,
        /// Limit.
        allowed: f64,
    },
    /// It was built on another mesh than the problem has.
    #[error("the file belongs to another mesh than {problem}")]
    ForeignMesh {
        /// The problem's file.
        problem: String,
    },
    /// It has a node that the mesh does not have.
    #[error("node {id} is not in the mesh")]
    ForeignNode {
        /// The node's id in the mesh file.
        id: u64,
    },
    /// `BᵀMB` is not positive definite.
    #[error("the columns of the basis are not independent")]
    DependentColumns,
    /// A scenario needs what the file does not have.
    #[error("the scenario has {what}, which needs section {kind}, and the new file does not have it")]
    Needed {
        /// The section.
        kind: SectionKind,
        /// Part of the scenario.
        what: String,
    },
}

/// Stages of a build that a study runs by itself fail as the build does.
macro_rules! as_build {
    ($($error:ty),*) => {
        $(impl From<$error> for StudyError {
            fn from(error: $error) -> Self {
                Self::Build(error.into())
            }
        })*
    };
}

as_build!(
    TooMuchWork,
    TimeStepError,
    PrepareError,
    BasisError,
    ModesError,
    MeshErrorFailure,
    FullOrderError,
    ResponseError,
    ParametricError,
    GreenError
);

impl From<ChapterError> for StudyError {
    fn from(error: ChapterError) -> Self {
        Self::Build(BuildError::Other(Box::new(error)))
    }
}

/// Errors of the evaluator and of rewriting are errors of the file.
macro_rules! as_file {
    ($($error:ty),*) => {
        $(impl From<$error> for StudyError {
            fn from(error: $error) -> Self {
                Self::File(error.into())
            }
        })*
    };
}

as_file!(
    FormatError,
    RewriteError,
    BindError,
    LoadError,
    StepError,
    OutputError,
    ChapterBindError,
    ChapterLoadError,
    ChapterStepError
);

impl From<BodyError> for StudyError {
    fn from(error: BodyError) -> Self {
        PrepareError::from(error).into()
    }
}

impl From<SnapshotError> for StudyError {
    fn from(error: SnapshotError) -> Self {
        BasisError::from(error).into()
    }
}

impl From<FactorError> for StudyError {
    fn from(error: FactorError) -> Self {
        BasisError::from(error).into()
    }
}

impl StudyError {
    /// The error of a step that the evaluator refuses, since the motion at its end is too large.
    pub(crate) fn too_large(step: usize, time_step: f64) -> Self {
        let (time, what) = (step as f64 * time_step, "the motion".to_string());
        Self::NotFinite { time, step, what, value: f64::INFINITY, cause: LARGE_MOTION }
    }
}
