//! Temperatures as load patterns, and the keys that they exclude.

use super::check::Words;
use super::{
    BasisKind, ExpansionEntry, ParameterEntry, ParameterKind, Problem, ProblemError, Representation,
};
use crate::dynamics::SchemeKind;

/// Largest coefficient of expansion \[1/K\].
const MOST: f64 = 1.0;

impl Problem {
    pub(super) fn check_temperatures(&self) -> Result<(), ProblemError> {
        for (i, material) in self.materials.iter().enumerate() {
            let along = material.expansion.map_or([0.0; 3], ExpansionEntry::along);
            let sound = along.iter().all(|coefficient| coefficient.abs() <= MOST);
            self.require(
                sound,
                &format!("material[{i}].expansion"),
                along,
                "coefficients from -1 to 1 per kelvin",
            )?;
        }
        let heated = |pattern: &super::PatternEntry| pattern.temperature.is_some();
        let Some(i) = self.load.patterns.iter().position(heated) else { return Ok(()) };
        let key = format!("load.pattern[{i}].temperature");
        let expands = self.materials.iter().any(|material| material.expansion.is_some());
        let expected = "`expansion` of a `[[material]]`: without it a temperature does nothing";
        self.require(expands, &key, Words("without it"), expected)?;
        let scaled = |p: &ParameterEntry| p.kind == ParameterKind::Stiffness && p.attachment.is_none();
        let found = if self.is_large() {
            "beside `model = \"large-displacement\"`, whose strain it is not"
        } else if self.representation == Some(Representation::Canonical) {
            "beside `representation = \"chapter\"`, which takes no load patterns"
        } else if self.parameters.iter().any(scaled) {
            "beside a live stiffness, which the force of a load pattern does not follow"
        } else if self.output.stress.is_some() && !self.shows_patterns() {
            "beside `output.stress` without the residual flexibility, which holds what a strain without stress takes off"
        } else {
            return Ok(());
        };
        let expected = "linear motion of a body of fixed stiffness, with the residual flexibility where a file has stress";
        self.require(false, &key, Words(found), expected)
    }

    /// True if the file has the stress of load patterns beside that of the modes.
    fn shows_patterns(&self) -> bool {
        let exact = self.scheme() == (SchemeKind::Exact {});
        let whole = !self.has_local_parameters();
        self.output.residual.unwrap_or(exact) && self.basis_kind() != BasisKind::Pod && whole
    }
}
