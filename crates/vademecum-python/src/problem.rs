//! Problems and scenarios, from files or from Python's mappings.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use vademecum_build::input::Problem;
use vademecum_study::scenario::Scenario;

use crate::refusal::Refusal;

/// `path`, `json` or `toml`; the path or the text; the folder in which the files of a text are looked for.
#[derive(FromPyObject)]
pub struct Given(String, String, PathBuf);

impl Given {
    /// The problem that is meant.
    pub fn problem(&self) -> Result<Problem, Refusal> {
        let Self(kind, given, folder) = self;
        Ok(match kind.as_str() {
            "path" => Problem::read(Path::new(given))?,
            "toml" => Problem::parse(given, "the problem", folder.clone())?,
            _ => Problem::of_table(self.table()?, "the dict of the problem", folder.clone())?,
        })
    }

    /// The scenario that is meant.
    pub fn scenario(&self) -> Result<Scenario, Refusal> {
        let Self(kind, given, folder) = self;
        Ok(match kind.as_str() {
            "path" => Scenario::read(Path::new(given))?,
            _ => Scenario::of_table(self.table()?, "the dict of the scenario", folder)?,
        })
    }

    /// The keys of a mapping.
    fn table(&self) -> Result<toml::Table, Refusal> {
        serde_json::from_str(&self.1).map_err(|error| Refusal::usage(format!("the dict: {error}")))
    }
}
