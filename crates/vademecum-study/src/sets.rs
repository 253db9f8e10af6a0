//! One scenario through many bodies of one file, each with its own values of the live parameters.

use std::path::Path;

use vademecum_build::input::OWN_COLUMNS;
use vademecum_build::progress::Listener;
use vademecum_build::suggest::did_you_mean;
use vademecum_format::File;

use crate::error::StudyError;
use crate::live::at_values;
use crate::parameters::{self, ParameterValue};
use crate::player::PlayOptions;
use crate::run::{Moment, Run};
use crate::scenario::Scenario;
use crate::table::Table;

/// Values of live parameters, a row for each body.
#[derive(Clone, Debug)]
pub struct Sets {
    table: Table,
}

impl Sets {
    /// Reads a table whose names are those of live parameters of the file.
    ///
    /// # Errors
    /// [`TableFileError`](crate::table::TableFileError): a table that cannot be read, a column that is no
    /// live parameter or is among those that are `given` for all bodies.
    pub fn read(path: &Path, file: &File<'_>, given: &[ParameterValue]) -> Result<Self, StudyError> {
        let table = Table::read(path)?;
        let known: Vec<&str> = file.parameters().map(|parameter| parameter.name).collect();
        for (name, _) in &table.columns {
            if given.iter().any(|parameter| parameter.name == *name) {
                let found = format!("column `{name}`, which `--set` gives to all bodies");
                return Err(table.fault(table.head, found, "each parameter once"));
            }
            if !known.contains(&name.as_str()) {
                let expected = match known.len() {
                    0 => "a file with live parameters".to_string(),
                    _ => {
                        let nearest = did_you_mean(name, known.iter().copied());
                        format!("live parameters of the file: `{}`{nearest}", known.join("`, `"))
                    }
                };
                return Err(table.fault(table.head, format!("column `{name}`"), expected));
            }
        }
        Ok(Self { table })
    }

    /// Names of the parameters, one for each column.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.table.columns.iter().map(|(name, _)| name.as_str())
    }

    /// Number of bodies.
    #[expect(clippy::len_without_is_empty, reason = "a table has at least one row")]
    pub fn len(&self) -> usize {
        self.table.rows.len()
    }

    /// Values of the parameters of body `row`.
    pub fn values(&self, row: usize) -> &[f64] {
        &self.table.rows[row].1
    }

    /// The line of body `row` with a fault that concerns it alone, such as a value outside of its range;
    /// `None` of an error that would meet every body.
    pub fn fault(&self, row: usize, error: &StudyError) -> Option<String> {
        let StudyError::OutsideRange { .. } = error else { return None };
        Some(format!("{}:{}: {error}", self.table.path.display(), self.table.rows[row].0))
    }

    /// Parameters of body `row`, behind those `given` for all.
    fn settings(&self, row: usize, given: &[ParameterValue]) -> Vec<ParameterValue> {
        let named = self.names().zip(self.values(row));
        let own = named.map(|(name, &value)| ParameterValue { name: name.into(), value });
        given.iter().cloned().chain(own).collect()
    }
}

/// Settings that all bodies have in common.
#[derive(Clone, Copy)]
pub struct SetRun<'a> {
    /// The file.
    pub file: &'a File<'a>,
    /// Parameters that are the same for all.
    pub given: &'a [ParameterValue],
    /// Modes that are stepped, 32 unless asked otherwise.
    pub modes: Option<usize>,
    /// Options of the step.
    pub options: PlayOptions,
    /// The scenario. Its fields and its table of stresses are not shown.
    pub scenario: &'a Scenario,
}

/// Passes cancellation on, and nothing else.
struct Unnoted<'a>(&'a dyn Listener);

impl Listener for Unnoted<'_> {
    fn stage(&self, _: &str) {}
    fn advance(&self, _: usize, _: usize) {}
    fn note(&self, _: &str) {}
    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

/// Values of a column of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// The smallest.
    pub least: f64,
    /// The largest.
    pub largest: f64,
    /// That of the last row.
    pub last: f64,
}

impl SetRun<'_> {
    /// Name and unit of each column that is summarised, from a run that is bound at the values as built. The
    /// listener hears what the scenario asks for in vain.
    ///
    /// # Errors
    /// As [`Run::bind`].
    pub fn columns(&self, listener: &dyn Listener) -> Result<Vec<(String, &'static str)>, StudyError> {
        self.with(self.given, listener, |run| {
            let own = OWN_COLUMNS.iter().skip(1).map(|name| ((*name).to_string(), ""));
            Ok(own.chain(run.columns()).collect())
        })
    }

    /// Steps body `row` through the scenario: the summary of each column. The listener hears no notes.
    ///
    /// # Errors
    /// [`StudyError::OutsideRange`], and as [`Run::bind`] and [`Run::play`].
    pub fn body(&self, sets: &Sets, row: usize, listener: &dyn Listener) -> Result<Vec<Summary>, StudyError> {
        let quiet = Unnoted(listener);
        self.with(&sets.settings(row, self.given), &quiet, |run| {
            let mut found: Vec<Summary> = vec![];
            run.play(&quiet, |moment: &Moment<'_>| {
                let Some(row) = moment.probes else { return Ok(()) };
                let parts = [row.values, row.reactions.as_flattened(), row.flight, row.quantities];
                let parts = parts.into_iter().chain([row.contacts.as_flattened()]);
                let values = [row.energy].into_iter().chain(parts.flatten().copied());
                for (place, value) in values.enumerate() {
                    match found.get_mut(place) {
                        None => found.push(Summary { least: value, largest: value, last: value }),
                        Some(known) => {
                            known.least = known.least.min(value);
                            known.largest = known.largest.max(value);
                            known.last = value;
                        }
                    }
                }
                Ok::<_, StudyError>(())
            })?;
            Ok(found)
        })
    }

    /// A run at values of the live parameters.
    fn with<T>(
        &self,
        settings: &[ParameterValue],
        listener: &dyn Listener,
        then: impl FnOnce(&Run<'_>) -> Result<T, StudyError>,
    ) -> Result<T, StudyError> {
        let body = at_values(self.file, settings, self.modes)?;
        let mut options = self.options;
        let set;
        let file = match &body {
            Some(body) => {
                set = File::parse(&body.bytes)?;
                &set
            }
            None => {
                parameters::set(&mut options.scene, self.file.metadata(), settings)?;
                self.file
            }
        };
        then(&Run::bind(file, options, self.scenario, listener)?)
    }
}
