//! Refusals of calls, in words for the log of the master.

use vademecum_eval::{BindError, LoadError, OutputError, ParameterError, StepError};

use crate::variables::Variable;
use crate::words::{Say, Words, sentence};

/// Reason of a refused call; the instance is then as it was before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal {
    /// The file does not allow these parameters.
    Bind(BindError),
    /// A parameter outside of its range.
    Parameter(ParameterError),
    /// A force or an amplitude that cannot be applied.
    Load(LoadError),
    /// A step that was not taken.
    Step(StepError),
    /// A file that does not show what is asked for.
    Output(OutputError),
    /// A value reference that no variable has.
    NoReference {
        /// The reference.
        reference: u32,
    },
    /// No such variable.
    NoVariable,
    /// An output, or a number that stays what it is.
    NotSettable,
    /// A value that is not finite.
    NotFinite {
        /// The value.
        value: f64,
    },
    /// A scale that is not above 0, or a damping below it.
    TooSmall {
        /// The value.
        value: f64,
    },
    /// A null pointer.
    Null,
    /// Another number of values than the variables have.
    Values {
        /// Values that were given.
        found: usize,
        /// Values of the variables.
        expected: usize,
    },
    /// Another number of surface nodes than the FMU has.
    SurfaceNodes {
        /// The number that was asked for.
        found: u64,
        /// Those that there are.
        most: u32,
    },
    /// A communication step that is no multiple of the internal step.
    NoMultiple {
        /// The communication step \[s\].
        size: f64,
        /// The internal step \[s\].
        step: f64,
    },
    /// A communication step that is no time, where any other is taken.
    NoTime {
        /// The communication step \[s\].
        size: f64,
    },
    /// More internal steps than one call takes.
    TooManySteps {
        /// The communication step \[s\].
        size: f64,
        /// The internal step \[s\].
        step: f64,
        /// Internal steps that one call takes at most.
        most: u64,
    },
    /// A communication point at which the instance is not.
    OtherTime {
        /// The communication point \[s\].
        point: f64,
        /// Time of the instance \[s\].
        time: f64,
    },
    /// A step beyond the end of the experiment.
    BeyondStop {
        /// Time at which the step would end \[s\].
        end: f64,
        /// The end of the experiment \[s\].
        stop: f64,
    },
    /// Start or stop time of no experiment.
    BadExperiment {
        /// Start \[s\].
        start: f64,
        /// Stop \[s\].
        stop: f64,
    },
    /// The bytes are no saved state of this body.
    Saved(&'static str),
    /// The host has no memory left.
    Memory,
    /// A capability that this unit does not have.
    Unsupported(&'static str),
}

impl Say for Refusal {
    fn say(&self, words: &mut Words) {
        match *self {
            Self::Bind(error) => words.add(bind(&error)),
            Self::Parameter(ParameterError::OutsideRange { value, lower, upper, .. }) => {
                sentence!(words, value, " is outside of its range, ", lower, " to ", upper);
            }
            Self::Parameter(_) | Self::NoVariable => words.add("there is no such variable"),
            Self::Load(error) => words.add(load(&error)),
            Self::Step(error) => words.add(step(&error)),
            Self::Output(error) => words.add(output(&error)),
            Self::NoReference { reference } => {
                sentence!(words, "no variable of this type has the value reference ", u64::from(reference));
            }
            Self::NotSettable => words.add("it cannot be set; inputs and tunable parameters can"),
            Self::NotFinite { value } => sentence!(words, value, " is no finite number"),
            Self::TooSmall { value } => {
                sentence!(words, value, " is too small; scales are above 0, and damping is not below it");
            }
            Self::Null => words.add("a null pointer was given"),
            Self::Values { found, expected } => {
                let (found, expected) = (found as u64, expected as u64);
                sentence!(words, found, " values for variables that have ", expected);
            }
            Self::SurfaceNodes { found, most } => {
                sentence!(words, found, " surface nodes; expected 1 to ", u64::from(most));
            }
            Self::NoMultiple { size, step } => {
                sentence!(
                    words,
                    "the communication step, ",
                    size,
                    " s, is no multiple of the internal step, "
                );
                sentence!(words, step, " s; ask for a multiple");
            }
            Self::NoTime { size } => {
                sentence!(
                    words,
                    "the communication step, ",
                    size,
                    " s, is no time; ask for more than a millionth"
                );
                words.add(" of the internal step");
            }
            Self::TooManySteps { size, step, most } => {
                sentence!(words, "the communication step, ", size, " s, is more than ", most);
                sentence!(words, " times the internal step, ", step, " s; ask for less at a time");
            }
            Self::OtherTime { point, time } => {
                sentence!(
                    words,
                    "the communication point is ",
                    point,
                    " s, and the instance is at ",
                    time,
                    " s"
                );
            }
            Self::BeyondStop { end, stop } => {
                sentence!(words, "the step would end at ", end, " s, beyond the stop time, ", stop, " s");
            }
            Self::BadExperiment { start, stop } => {
                sentence!(words, "an experiment from ", start, " s to ", stop);
                words.add(" s; expected finite times in this order");
            }
            Self::Saved(what) => sentence!(words, "this is no saved state of this FMU: ", what),
            Self::Memory => words.add("the host has no memory left"),
            Self::Unsupported(what) => words.add(what),
        }
    }
}

/// Reason of refused parameters or a refused file. The exporter has said it with all numbers; what is left
/// here is what a master can bring about.
pub const fn bind(error: &BindError) -> &'static str {
    match error {
        BindError::Format(_) => "the file is refused; `vademecum info` of it says why",
        BindError::NotFinite => "the step is not finite at these parameters",
        BindError::LentMemory { .. } => "the memory of the instance is too short",
        BindError::OutsideAxis { .. } | BindError::Parameter(_) => {
            "the parameters are outside of what the file was built for"
        }
        _ => "the file cannot be stepped at these parameters; `vademecum info` of it shows its ranges",
    }
}

const fn load(error: &LoadError) -> &'static str {
    match error {
        LoadError::NotFinite => "a force or an amplitude is too large to be applied",
        LoadError::Missing { .. } => "the file was stripped of what forces on points need",
        LoadError::NoPattern { .. } => "the file has no such load pattern",
        LoadError::NotLoadable { .. } => "the point is not on the loadable surface",
        _ => "the loads do not belong to this body",
    }
}

const fn step(error: &StepError) -> &'static str {
    match error {
        StepError::NotFinite => "the new state is not finite, the old one was kept: reduce the load",
        StepError::BadMass => "the mass of the regions is not positive definite; build the file again",
        _ => "the state does not belong to this body",
    }
}

const fn output(error: &OutputError) -> &'static str {
    match error {
        OutputError::Missing { .. } => "the file was stripped of what this output needs",
        _ => "the state does not belong to this body",
    }
}

/// A refusal, and the variable it is about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trouble {
    /// Reason.
    pub refusal: Refusal,
    /// The variable, if it is about one.
    pub variable: Option<Variable>,
}

impl From<Refusal> for Trouble {
    fn from(refusal: Refusal) -> Self {
        Self { refusal, variable: None }
    }
}

impl From<(Variable, Refusal)> for Trouble {
    fn from((variable, refusal): (Variable, Refusal)) -> Self {
        Self { refusal, variable: Some(variable) }
    }
}

impl From<BindError> for Refusal {
    fn from(error: BindError) -> Self {
        Self::Bind(error)
    }
}

impl From<ParameterError> for Refusal {
    fn from(error: ParameterError) -> Self {
        Self::Parameter(error)
    }
}

impl From<LoadError> for Refusal {
    fn from(error: LoadError) -> Self {
        Self::Load(error)
    }
}

impl From<StepError> for Refusal {
    fn from(error: StepError) -> Self {
        Self::Step(error)
    }
}

impl From<OutputError> for Refusal {
    fn from(error: OutputError) -> Self {
        Self::Output(error)
    }
}
