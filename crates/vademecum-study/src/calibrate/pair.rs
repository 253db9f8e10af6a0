//! Tables of measured numbers, each with what its body was loaded with.

use std::path::PathBuf;

use super::error::CalibrateError;
use super::experiment::{Measurement, Source};
use crate::frf::Channel;
use crate::scenario::Scenario;
use crate::table::Table;

/// Takes scenarios to the tables with histories and inputs to those with frequency responses: one for each,
/// in their order, or one for all.
///
/// # Errors
/// [`CalibrateError`]: a table that cannot be read; as many scenarios or inputs as are for no table.
pub fn measurements(
    tables: &[PathBuf],
    scenarios: &[Scenario],
    inputs: &[Channel],
) -> Result<Vec<Measurement>, CalibrateError> {
    let (mut out, mut histories, mut responses) = (vec![], 0, 0);
    for path in tables {
        let table = Table::read(path)?;
        let first = table.columns[0].0.as_str();
        let source = match first {
            "time_s" => {
                histories += 1;
                let own = if scenarios.len() == 1 { 0 } else { histories - 1 };
                scenarios.get(own).map(|scenario| Source::Scenario(Box::new(scenario.clone())))
            }
            "frequency_hz" if table.columns.len() > 1 => {
                responses += 1;
                let own = if inputs.len() == 1 { 0 } else { responses - 1 };
                inputs.get(own).map(|input| Source::Input(input.clone()))
            }
            _ => None,
        };
        out.push(Measurement { path: path.clone(), source: source.unwrap_or(Source::Free) });
    }
    let pairs = [
        ("--scenario", scenarios.len(), histories, "histories over `time_s`"),
        ("--in", inputs.len(), responses, "a frequency response"),
    ];
    for (option, given, wanted, what) in pairs {
        if given > wanted || (given > 1 && given != wanted) {
            let reason = format!(
                "`{option}` is given {given} times for {wanted} tables with {what}; expected one for each table, in \
                 the order of `--data`, or one for all"
            );
            return Err(CalibrateError::Parameters { reason });
        }
    }
    Ok(out)
}
