//! The scenario file: which loads act when (normative: `formats/scenario-1.md`).
//!
//! A scenario knows nothing of meshes or modes, so the full-order solver and the evaluator march the same
//! one.

use std::path::Path;

use serde::{Deserialize, Serialize};

use vademecum_build::dynamics::Interval;
use vademecum_build::input::toml_file::{self, TomlError};

/// A scenario file that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct ScenarioError(#[from] pub TomlError);

/// Loads over time, from rest.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Length \[s\].
    pub duration: f64,
    /// Forces at points of the loadable surface.
    #[serde(rename = "contact", default)]
    pub contacts: Vec<ContactEntry>,
    /// Load patterns of the file.
    #[serde(rename = "pattern", default)]
    pub patterns: Vec<PatternUse>,
    /// What `run` writes.
    #[serde(default)]
    pub output: OutputPlan,
}

/// One force at one point for a while.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ContactEntry {
    /// Where; the nearest point of the loadable surface is taken.
    pub point: [f64; 3],
    /// Force \[N\].
    pub force: [f64; 3],
    /// First instant \[s\].
    #[serde(default)]
    pub start: f64,
    /// First instant without the load \[s\]; absent: to the end.
    #[serde(default = "forever")]
    pub end: f64,
    /// Time to full force \[s\].
    #[serde(default)]
    pub ramp: f64,
}

/// One load pattern for a while.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PatternUse {
    /// The pattern's name in the file.
    pub name: String,
    /// Factor on the pattern.
    #[serde(default = "one")]
    pub amplitude: f64,
    /// First instant \[s\].
    #[serde(default)]
    pub start: f64,
    /// First instant without the load \[s\]; absent: to the end.
    #[serde(default = "forever")]
    pub end: f64,
    /// Time to full force \[s\].
    #[serde(default)]
    pub ramp: f64,
}

/// What `run` writes and how often.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct OutputPlan {
    /// Probe rows every so many steps.
    #[serde(default = "one_step")]
    pub probes_every: usize,
    /// Fields every so many steps; 0: none.
    #[serde(default)]
    pub fields_every: usize,
    /// `"body"` or `"surface"`.
    #[serde(default)]
    pub fields: FieldChoice,
}

/// Which nodes a field shows.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum FieldChoice {
    /// Nodes and triangles of the surface.
    #[default]
    Surface,
    /// Every node.
    Body,
}

impl Default for OutputPlan {
    fn default() -> Self {
        Self { probes_every: 1, fields_every: 0, fields: FieldChoice::default() }
    }
}

fn one() -> f64 {
    1.0
}

fn one_step() -> usize {
    1
}

fn forever() -> f64 {
    f64::MAX
}

impl ContactEntry {
    /// When it acts.
    pub fn when(&self) -> Interval {
        Interval { start: self.start, end: self.end, ramp: self.ramp }
    }
}

impl PatternUse {
    /// When it acts.
    pub fn when(&self) -> Interval {
        Interval { start: self.start, end: self.end, ramp: self.ramp }
    }
}

impl Scenario {
    /// Reads and checks a scenario file.
    pub fn read(path: &Path) -> Result<Self, ScenarioError> {
        Self::parse(&toml_file::read(path)?, &path.display().to_string())
    }

    /// Reads and checks a scenario from its text; messages name `path`.
    pub fn parse(text: &str, path: &str) -> Result<Self, ScenarioError> {
        let scenario: Scenario = toml_file::parse(text, path)?;
        scenario.check(path, text)?;
        Ok(scenario)
    }

    /// Number of steps of `time_step`, at least one.
    pub fn steps(&self, time_step: f64) -> usize {
        ((self.duration / time_step).round() as usize).max(1)
    }

    fn check(&self, path: &str, text: &str) -> Result<(), ScenarioError> {
        let require = |holds: bool, key: &str, found: String, expected| -> Result<(), ScenarioError> {
            let path = toml_file::place(path, text, key);
            if holds {
                Ok(())
            } else {
                Err(TomlError::Impossible { path, key: key.into(), found, expected }.into())
            }
        };
        let acts = |key: &str, when: Interval| {
            let Interval { start, end, ramp } = when;
            let found = format!("start {start:?}, end {end:?}, ramp {ramp:?}");
            require(start >= 0.0 && end > start && ramp >= 0.0, key, found, "0 ≤ start < end and ramp ≥ 0")
        };
        let duration = self.duration > 0.0 && self.duration.is_finite();
        require(duration, "duration", self.duration.to_string(), "a positive time in seconds")?;
        require(self.output.probes_every > 0, "output.probes_every", "0".into(), "at least 1")?;
        for (i, contact) in self.contacts.iter().enumerate() {
            for (name, vector) in [("point", contact.point), ("force", contact.force)] {
                let finite = vector.iter().all(|v| v.is_finite());
                require(finite, &format!("contact[{i}].{name}"), format!("{vector:?}"), "finite numbers")?;
            }
            acts(&format!("contact[{i}]"), contact.when())?;
        }
        for (i, pattern) in self.patterns.iter().enumerate() {
            let (key, amplitude) = (format!("pattern[{i}].amplitude"), pattern.amplitude);
            require(amplitude.is_finite(), &key, amplitude.to_string(), "a finite number")?;
            acts(&format!("pattern[{i}]"), pattern.when())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_keys_and_empty_intervals_are_refused() {
        let unknown = "duration = 1.0\n[[contact]]\npoint=[0,0,0]\nforce=[0,0,1]\nstrat=1.0";
        assert!(Scenario::parse(unknown, "s.toml").is_err());
        let empty = "duration = 1.0\n[[contact]]\npoint=[0,0,0]\nforce=[0,0,1]\nstart=1.0\nend=1.0";
        assert!(matches!(Scenario::parse(empty, "s.toml"), Err(ScenarioError(TomlError::Impossible { .. }))));
    }
}
