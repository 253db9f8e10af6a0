//! Names that a file gives to what is counted.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use vademecum_eval::{Field, Quantity};
use vademecum_format::{File, SectionKind};
use vademecum_study::contents::lines;

use crate::refusal::{Refusal, unknown};

/// Names of the probes, of the load patterns, and of the supports whose reactions a file gives.
pub struct Names {
    pub probes: Vec<String>,
    pub patterns: Vec<String>,
    pub supports: Vec<String>,
}

impl Names {
    pub fn of(file: &File<'_>) -> Result<Self, Refusal> {
        Ok(Self {
            probes: lines(file, SectionKind::ProbeNames)?,
            patterns: lines(file, SectionKind::PatternNames)?,
            supports: lines(file, SectionKind::SupportNames)?,
        })
    }

    pub fn probe(&self, name: &str) -> PyResult<usize> {
        number("probe", &self.probes, name)
    }

    pub fn pattern(&self, name: &str) -> PyResult<usize> {
        number("load pattern", &self.patterns, name)
    }

    pub fn support(&self, name: &str) -> PyResult<usize> {
        number("support", &self.supports, name)
    }

    /// The index of a quantity, given as a number, as a name where there are names, or not at all.
    pub fn index(&self, quantity: Quantity, given: Option<&Bound<'_, PyAny>>) -> PyResult<usize> {
        let Some(given) = given else { return Ok(0) };
        if let Ok(index) = given.extract() {
            return Ok(index);
        }
        match (quantity, given.extract::<String>()) {
            (Quantity::Probe, Ok(name)) => self.probe(&name),
            (Quantity::ReactionForce | Quantity::ReactionMoment, Ok(name)) => self.support(&name),
            _ => Err(PyTypeError::new_err(format!(
                "index is {given}; `{}` is read by a number from 0",
                quantity.name()
            ))),
        }
    }
}

fn number(kind: &str, names: &[String], name: &str) -> PyResult<usize> {
    names.iter().position(|known| known == name).ok_or_else(|| unknown("the file", kind, name, names))
}

/// A field by its name.
pub fn field(name: &str) -> PyResult<Field> {
    match name {
        "displacement" => Ok(Field::Displacement),
        "velocity" => Ok(Field::Velocity),
        _ => Err(PyValueError::new_err(format!("field is `{name}`; expected `displacement` or `velocity`"))),
    }
}
