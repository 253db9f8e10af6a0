//! Errors of the workspace as exceptions of the package.

use std::fmt;
use std::path::Path;

use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use vademecum_cli::{Cause, Failure};
use vademecum_eval::{
    AdjointError, BindError, LoadError, LocateError, OutputError, ParametricError, PlaceError, Quantity,
    SavedError, SimulationError, StepError,
};
use vademecum_study::{FileError, StudyError};

/// A failure that may go from one thread to another: who can act, and the program's words.
#[derive(Debug)]
pub struct Refusal {
    cause: Cause,
    words: String,
}

impl<E: Into<Failure>> From<E> for Refusal {
    fn from(error: E) -> Self {
        let failure: Failure = error.into();
        let words = failure.to_string();
        // What is a slip on a command line is an input here.
        let cause = match failure.cause() {
            Cause::Usage => Cause::Input,
            cause => cause,
        };
        Self { cause, words: words.strip_prefix("error: ").unwrap_or(&words).to_string() }
    }
}

impl Refusal {
    /// Wrong arguments.
    pub fn usage(words: impl Into<String>) -> Self {
        Self { cause: Cause::Usage, words: words.into() }
    }

    /// A file without what is asked for.
    pub fn file(words: impl Into<String>) -> Self {
        Self { cause: Cause::File, words: words.into() }
    }

    /// A resource that the machine does not give.
    pub fn machine(words: String) -> Self {
        Self { cause: Cause::Machine, words }
    }
}

impl From<Refusal> for PyErr {
    fn from(refusal: Refusal) -> Self {
        let name = match refusal.cause {
            Cause::Stopped => return PyKeyboardInterrupt::new_err(refusal.words),
            Cause::Usage => return PyValueError::new_err(refusal.words),
            Cause::Machine => "MachineError",
            Cause::Input => "InputError",
            Cause::Mesh => "MeshError",
            Cause::Numerics => "NumericsError",
            Cause::Tolerance => "ToleranceMissed",
            Cause::File => "FileError",
        };
        Python::attach(|py| exception(py, name, refusal.words).unwrap_or_else(|error| error))
    }
}

/// An exception of the package, which is written in Python.
fn exception(py: Python<'_>, name: &str, words: String) -> PyResult<PyErr> {
    let class = py.import("vademecum._errors")?.getattr(name)?;
    Ok(PyErr::from_value(class.call1((words,))?))
}

/// Nothing can be bound as it is asked for.
pub fn of_simulation(error: SimulationError) -> PyErr {
    let error = match error {
        SimulationError::Format(error) => FileError::from(error),
        SimulationError::Bind(error) => FileError::from(error),
        // Nothing is read from the disk where bytes are bound.
        other => return PyRuntimeError::new_err(other.to_string()),
    };
    Refusal::from(error).into()
}

/// A binding that was refused.
pub fn of_bind(error: BindError) -> PyErr {
    match error {
        // Of the arguments alone.
        BindError::Scheme(_)
        | BindError::Parameter(_)
        | BindError::BadScale { .. }
        | BindError::TooLarge { .. } => PyValueError::new_err(error.to_string()),
        error => Refusal::from(FileError::from(error)).into(),
    }
}

/// An output that cannot be given.
pub fn of_output(error: OutputError) -> PyErr {
    match error {
        OutputError::Missing { .. } => Refusal::from(FileError::from(error)).into(),
        other => PyValueError::new_err(other.to_string()),
    }
}

/// A load that was refused.
pub fn of_load(error: LoadError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A step that was refused.
pub fn of_step(error: StepError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A point without a place.
pub fn of_locate(error: LocateError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A place that was refused.
pub fn of_place(error: PlaceError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A state that was neither saved nor restored.
pub fn of_saved(error: SavedError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A file that was not opened: `FileNotFoundError`, too, where there is none.
pub fn of_missing(refusal: Refusal, path: &Path) -> PyErr {
    if path.try_exists().unwrap_or(true) {
        return refusal.into();
    }
    Python::attach(|py| exception(py, "MissingFile", refusal.words).unwrap_or_else(|error| error))
}

/// A study's error.
pub fn of_study(error: StudyError) -> PyErr {
    Refusal::from(error).into()
}

/// A parametric model that was refused.
pub fn of_parametric(error: ParametricError) -> PyErr {
    match error {
        ParametricError::Modes { .. } | ParametricError::Parameter(_) | ParametricError::Row { .. } => {
            PyValueError::new_err(error.to_string())
        }
        ParametricError::NotParametric => Refusal::file(error.to_string()).into(),
        error => of_study(StudyError::from(error)),
    }
}

/// A gradient that was refused.
pub fn of_adjoint(error: AdjointError) -> PyErr {
    match error {
        AdjointError::Output(error) => of_output(error),
        AdjointError::Load(error) => of_load(error),
        AdjointError::Bind(error) => of_bind(error),
        AdjointError::Parametric(error) => of_parametric(error),
        AdjointError::Structure { .. } | AdjointError::Flies | AdjointError::Coupled => {
            Refusal::file(error.to_string()).into()
        }
        error => PyValueError::new_err(error.to_string()),
    }
}

/// A value in use by another thread.
pub fn busy(what: &str) -> PyErr {
    PyRuntimeError::new_err(format!(
        "this {what} is in use by another thread; a {what} belongs to one thread at a time: make one for each"
    ))
}

/// A name that is not one of those known.
pub fn unknown(of: &str, what: &str, name: &str, known: &[String]) -> PyErr {
    let nearest = vademecum_build::suggest::did_you_mean(name, known.iter().map(String::as_str));
    let list = if known.is_empty() { "none".to_string() } else { Quoted(known).to_string() };
    PyValueError::new_err(format!("{of} has no {what} `{name}`; it has {list}{nearest}"))
}

/// A name that is not one of the table of quantities.
pub fn unknown_quantity(name: &str) -> PyErr {
    let all = Quantity::ALL.map(|quantity| quantity.name().to_string());
    let nearest = vademecum_build::suggest::did_you_mean(name, all.iter().map(String::as_str));
    PyValueError::new_err(format!("there is no quantity `{name}`; there are {}{nearest}", Quoted(&all)))
}

/// Names between quotes, with commas.
struct Quoted<'a>(&'a [String]);

impl fmt::Display for Quoted<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, name) in self.0.iter().enumerate() {
            let comma = if place > 0 { ", " } else { "" };
            write!(out, "{comma}`{name}`")?;
        }
        Ok(())
    }
}
