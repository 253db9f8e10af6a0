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
        match self.toml("problem")? {
            None => Ok(Problem::read(Path::new(&self.1))?),
            Some(text) => Ok(Problem::parse(&text, "the problem", self.2.clone())?),
        }
    }

    /// The scenario that is meant.
    pub fn scenario(&self) -> Result<Scenario, Refusal> {
        match self.toml("scenario")? {
            None => Ok(Scenario::read(Path::new(&self.1))?),
            Some(text) => {
                // Files of tables are looked for beside the path that messages name.
                let name = self.2.join("the scenario");
                Ok(Scenario::parse(&text, &name.display().to_string())?)
            }
        }
    }

    /// The text, unless it is a path.
    fn toml(&self, what: &str) -> Result<Option<String>, Refusal> {
        match self.0.as_str() {
            "path" => Ok(None),
            "toml" => Ok(Some(self.1.clone())),
            _ => {
                let table: toml::Table = serde_json::from_str(&self.1)
                    .map_err(|error| Refusal::usage(format!("the {what}: {error}")))?;
                let text = toml::to_string(&table);
                Ok(Some(text.map_err(|error| Refusal::usage(format!("the {what}: {error}")))?))
            }
        }
    }
}
