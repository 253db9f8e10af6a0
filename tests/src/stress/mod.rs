//! The stress matrix: small bodies and scenes chosen to break a build or a march, each with the verdict it
//! must get.
//!
//! One table of cells (`cells.rs`) is read by the test `tests/stress.rs`, which runs the reduced form, and by
//! `records/stress.rs`, which runs all of it at full size and prints `docs/measurements/stability.md`. A cell
//! is green when every structure of its file is stable, one of them stays within its tolerance of the
//! full-order march, and single precision stays with double. Otherwise it is refused by a name, or meets a
//! limit that has one: both stand in the table, and both are explained in the record.

pub mod bodies;
mod build;
mod cells;
mod drive;
mod hostile;
mod live;
mod long;
mod record;
mod reference;
mod units;

pub use cells::cells;
pub use record::{markdown, row};

use vademecum_build::input::Problem;
use vademecum_build::pipeline::BuildError;

/// Spectral radius above which a step counts as unstable; as the build judges it (`report.rs`).
pub const STABLE: f64 = 1.0 + 1e-12;
/// Energy of a free run over that at its start above which it counts as growing; as the build judges it.
pub const BOUNDED: f64 = 1.05;
/// Largest distance of single from double precision: the project's bound after 2e5 steps.
pub const SINGLE: f64 = 2e-3;

/// How long a run may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Seconds in all: what continuous integration runs.
    Reduced,
    /// Everything at full length.
    Full,
}

impl Form {
    /// The first number in the reduced form, the second in the full one.
    #[must_use]
    pub fn pick<T>(self, reduced: T, full: T) -> T {
        match self {
            Form::Reduced => reduced,
            Form::Full => full,
        }
    }
}

/// What is done with a cell's problem.
pub type Scenario = fn(&Problem, Form) -> Outcome;

/// What a cell must come to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expected {
    /// Stable, accurate, and alike in both precisions.
    Green,
    /// Refused by this name.
    Refused(&'static str),
    /// Stable and bounded in double precision, but farther from the reference than allowed, or single
    /// precision from double, for a reason the record explains under this name.
    Limit(&'static str),
    /// Green, until a long march lets single precision drift away: the record explains it under this name.
    Late(&'static str),
}

/// One cell of the matrix.
pub struct Cell {
    /// What is stressed.
    pub group: &'static str,
    /// How far.
    pub name: String,
    /// The problem, or why there is none.
    pub problem: Box<dyn Fn() -> Result<Problem, BuildError>>,
    /// What is done with it.
    pub scenario: Scenario,
    /// What must come of it.
    pub expected: Expected,
}

/// What was measured of one structure; NaN where a scenario does not measure it.
#[derive(Clone, Debug)]
pub struct Measured {
    /// `diagonal`, `block`, or what else was compared.
    pub structure: &'static str,
    /// Of the fused step.
    pub spectral_radius: f64,
    /// Largest energy of a free run over that at its start.
    pub energy: f64,
    /// Relative L2 error against the full-order march (or the named reference), mass norm, all dofs and
    /// steps.
    pub error: f64,
    /// The same of the full-order march projected on the basis: the projection error.
    pub floor: f64,
    /// What `error` may be.
    pub allowed: f64,
    /// Distance of single from double precision.
    pub single: f64,
}

impl Measured {
    /// Nothing measured yet.
    #[must_use]
    pub fn of(structure: &'static str) -> Self {
        let nan = f64::NAN;
        Self {
            structure,
            spectral_radius: nan,
            energy: nan,
            error: nan,
            floor: nan,
            allowed: nan,
            single: nan,
        }
    }

    fn stable(&self) -> bool {
        !(self.spectral_radius > STABLE || self.energy > BOUNDED)
    }

    fn accurate(&self) -> bool {
        self.error.is_nan() || self.error <= self.allowed
    }

    /// Whether this is a march in single precision.
    fn is_single(&self) -> bool {
        self.structure.ends_with("f32")
    }
}

/// What came of a cell.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// It ran.
    Ran(Vec<Measured>),
    /// It was refused by this name, and nothing was changed or written; what had been measured by then.
    Refused(String, Vec<Measured>),
    /// It did what it must not: in words.
    Wrong(String),
}

/// How a cell ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// All measured numbers are inside their bounds.
    Green,
    /// Refused by this name.
    Refused(String),
    /// Stable, but no structure is close enough to the reference.
    Inaccurate,
    /// All that in double precision; single precision is too far from it, or grows.
    Single,
    /// Anything else.
    Red(String),
}

impl Cell {
    /// Runs the cell.
    #[must_use]
    pub fn run(&self, form: Form) -> Outcome {
        match (self.problem)() {
            Ok(problem) => (self.scenario)(&problem, form),
            Err(error) => build::refused(&error),
        }
    }
}

impl Outcome {
    /// The verdict over an outcome: every structure stable, one accurate.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        match self {
            Outcome::Wrong(words) => Verdict::Red(words.clone()),
            Outcome::Refused(name, _) => Verdict::Refused(name.clone()),
            Outcome::Ran(measured) => judge(measured),
        }
    }
}

fn judge(measured: &[Measured]) -> Verdict {
    let (single, double): (Vec<&Measured>, Vec<&Measured>) = measured.iter().partition(|m| m.is_single());
    if let Some(unstable) = double.iter().find(|m| !m.stable()) {
        return Verdict::Red(format!("{} unstable", unstable.structure));
    }
    let mut accurate = double.iter().filter(|m| m.accurate()).peekable();
    if accurate.peek().is_none() {
        return Verdict::Inaccurate;
    }
    let alike =
        accurate.any(|m| m.single.is_nan() || m.single <= SINGLE) && single.iter().all(|m| m.stable());
    if alike { Verdict::Green } else { Verdict::Single }
}

impl Verdict {
    /// Whether it is what the table expects.
    #[must_use]
    pub fn is(&self, expected: Expected) -> bool {
        match (self, expected) {
            (Verdict::Green, Expected::Green) => true,
            (Verdict::Refused(found), Expected::Refused(name)) => found == name,
            (Verdict::Inaccurate | Verdict::Single, Expected::Limit(_)) => true,
            (Verdict::Green | Verdict::Single, Expected::Late(_)) => true,
            _ => false,
        }
    }
}
