//! The scenario file: which loads act when (normative: `formats/scenario-1.md`).
//!
//! A scenario knows nothing of meshes or modes, so the full-order solver and the evaluator march the same
//! one.

mod check;
mod courses;
mod entries;
mod tables;

use std::path::Path;

use vademecum_build::input::toml_file::{self, TomlError};

use crate::error::StudyError;
use tables::{Columns, LARGEST, Tables};

pub(crate) use check::MAX_LOADS;
pub use entries::{
    BaseEntry, ContactEntry, FieldChoice, FreeEntry, OutputPlan, OutputProbe, PatternUse, Scenario,
    SinusoidEntry, Total,
};
pub(crate) use entries::{ProbePlace, ProbeQuantity, StressEntry, StressQuantity};
pub use tables::Rows;

/// Most steps that a march can have: beyond, `n Δt` no longer tells one instant from the next.
pub(crate) const MAX_STEPS: u64 = 1 << 53;

/// Most steps that a file is marched unless it is asked for more: at about a microsecond for a step and its
/// row of probes a quarter of an hour, and a table of some 60 GB if every step writes a row.
pub(crate) const STEPS_OF_A_RUN: u64 = 1_000_000_000;

/// Most steps that are marched at full order unless more is asked for: at some milliseconds a step, an hour
/// or more. All of their reduced coordinates are kept until they are compared.
pub const STEPS_AT_FULL_ORDER: u64 = 1_000_000;

/// Most periods of a sinusoid or a chirp in a step: it is stepped in 2222 parts a period.
const MAX_PERIODS: f64 = 16.0;

/// A scenario file that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct ScenarioError(#[from] pub TomlError);

impl Scenario {
    /// Start and end of each load \[s\], within the scenario.
    #[must_use]
    pub(crate) fn acting(&self) -> Vec<[f64; 2]> {
        let contacts = self.contacts.iter().map(|load| [load.start, load.end]);
        let all = contacts.chain(self.patterns.iter().map(|load| [load.start, load.end]));
        all.map(|[start, end]| [start.min(self.duration), end.min(self.duration)]).collect()
    }

    /// Reads and checks a scenario file.
    pub fn read(path: &Path) -> Result<Self, ScenarioError> {
        Self::parse(&toml_file::read(path)?, &path.display().to_string())
    }

    /// Reads and checks a scenario from its text; messages name `path`, and files of tables are looked for in
    /// its folder.
    pub fn parse(text: &str, path: &str) -> Result<Self, ScenarioError> {
        let mut scenario: Scenario = toml_file::parse(text, path)?;
        scenario.check(path, text)?;
        scenario.drop_energy();
        scenario.read_tables(Path::new(path).parent().unwrap_or(Path::new("")), path, text)?;
        Ok(scenario)
    }

    /// Checks a scenario that another program has as a table; messages name `path` and the keys, and files of
    /// tables are looked for in `folder`.
    pub fn of_table(table: toml::Table, path: &str, folder: &Path) -> Result<Self, ScenarioError> {
        let mut scenario: Scenario = toml_file::of_table(table, path)?;
        scenario.check(path, "")?;
        scenario.drop_energy();
        scenario.read_tables(folder, path, "")?;
        Ok(scenario)
    }

    /// The energy is a column of every table of probes.
    fn drop_energy(&mut self) {
        self.output.quantities.retain(|total| total.0 != vademecum_eval::Quantity::Energy);
    }

    /// Number of steps of `time_step`, at least one.
    ///
    /// # Errors
    /// [`StudyError::TooManySteps`] beyond `MAX_STEPS`.
    pub fn steps(&self, time_step: f64) -> Result<usize, StudyError> {
        let (duration, steps) = (self.duration, (self.duration / time_step).round());
        let countable = steps <= MAX_STEPS as f64 && steps <= usize::MAX as f64;
        if countable {
            Ok((steps as usize).max(1))
        } else {
            Err(StudyError::TooManySteps { duration, time_step })
        }
    }

    /// [`Scenario::steps`], if they are not more than `limit`. With `long`, any number is.
    ///
    /// # Errors
    /// [`StudyError::TooManySteps`], [`StudyError::Long`]; [`StudyError::TooFast`]: a load of more than 16
    /// periods in a step.
    pub fn steps_within(&self, time_step: f64, limit: u64, long: bool) -> Result<usize, StudyError> {
        let (duration, steps) = (self.duration, self.steps(time_step)?);
        self.check_frequencies(time_step)?;
        if long || steps as u64 <= limit {
            return Ok(steps);
        }
        Err(StudyError::Long { duration, time_step, steps, limit })
    }

    fn check_frequencies(&self, time_step: f64) -> Result<(), StudyError> {
        let contacts = self.contacts.iter().map(|contact| contact.varying().highest_frequency());
        let patterns = self.patterns.iter().map(|pattern| pattern.varying().highest_frequency());
        let named = contacts.enumerate().map(|(i, f)| ("contact", i, f));
        for (kind, index, frequency) in named.chain(patterns.enumerate().map(|(i, f)| ("pattern", i, f))) {
            if frequency * time_step > MAX_PERIODS {
                let load = format!("{kind}[{index}]");
                return Err(StudyError::TooFast { load, frequency, time_step, most: MAX_PERIODS });
            }
        }
        Ok(())
    }

    /// Reads the tables that loads name, and checks what they are used for.
    fn read_tables(&mut self, folder: &Path, path: &str, text: &str) -> Result<(), ScenarioError> {
        let mut tables = Tables::of(folder);
        let place = |key: &str| toml_file::place(path, text, key);
        let too_large = |key: String, size: f64| {
            let expected = "rows and a force whose product is at most 1e75 in size";
            TomlError::Impossible {
                path: place(&key),
                key,
                found: format!("a table that makes products up to {size:e}"),
                expected: expected.into(),
            }
        };
        for (i, contact) in self.contacts.iter_mut().enumerate() {
            if let Some(rows) = &contact.path {
                let key = format!("contact[{i}].path");
                contact.places = Some(tables.table(rows, Columns::Place, &key, || place(&key))?);
            }
            let Some(rows) = &contact.table else { continue };
            let key = format!("contact[{i}].table");
            let table = tables.table(rows, Columns::Force, &key, || place(&key))?;
            let (components, force) = (table.columns() == 3, contact.force.is_some());
            if components == force {
                let (found, expected) = if force {
                    ("of forces, `time,fx,fy,fz`, beside `force`", "one of them")
                } else {
                    (
                        "of amplitudes, `time,amplitude`, without `force`",
                        "`force` beside it, or `time,fx,fy,fz`",
                    )
                };
                return Err(TomlError::Impossible {
                    path: place(&key),
                    key,
                    found: found.into(),
                    expected: expected.into(),
                }
                .into());
            }
            let force = contact.force.unwrap_or_default().iter().fold(0.0, |m: f64, f| m.max(f.abs()));
            if force * table.largest(0) > LARGEST {
                return Err(too_large(key, force * table.largest(0)).into());
            }
            contact.rows = Some(table);
        }
        for (i, pattern) in self.patterns.iter_mut().enumerate() {
            let Some(rows) = &pattern.table else { continue };
            let key = format!("pattern[{i}].table");
            let table = tables.table(rows, Columns::Amplitude, &key, || place(&key))?;
            let size = pattern.amplitude.abs() * table.largest(0);
            if size > LARGEST {
                return Err(too_large(key, size).into());
            }
            pattern.rows = Some(table);
        }
        let Some(base) = &self.base else { return Ok(()) };
        let key = "base.record";
        let table = tables.table(&base.record, Columns::Base, key, || place(key))?;
        let motions = base.motions(&table).map_err(|size| too_large(key.into(), size))?;
        self.patterns.extend(motions);
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

    #[test]
    fn an_unknown_quantity_is_refused_with_the_known_ones() {
        let text = |name: &str| format!("duration = 1.0\n[output]\nquantities = ['{name}']\n");
        for total in vademecum_eval::Quantity::totals() {
            let read = Scenario::parse(&text(total.name()), "s.toml").expect("a scalar of the whole body");
            // The energy is there anyway.
            let own = (total != vademecum_eval::Quantity::Energy).then_some(Total(total));
            assert_eq!(read.output.quantities, Vec::from_iter(own));
        }
        let twice = text("strain_energy").replace("']", "', 'strain_energy']");
        let said = Scenario::parse(&twice, "s.toml").expect_err("twice").to_string();
        assert!(said.contains("`output.quantities`") && said.contains("twice"), "{said}");
        let said = Scenario::parse(&text("energi"), "s.toml").expect_err("unknown").to_string();
        assert!(said.contains("unknown variant `energi`, expected one of `energy`, "), "{said}");
        assert!(said.contains("did you mean `energy`"), "{said}");
    }

    /// A march of finger tips, one contact a step: `count` contacts with a fault in the last one.
    fn many(count: usize, last: &str) -> String {
        let contact = |force: &str| format!("[[contact]]\npoint = [0, 0, 0]\nforce = [0, 0, {force}]\n");
        format!("duration = 1.0\n{}{}", contact("1").repeat(count - 1), contact(last))
    }

    #[test]
    fn a_fault_in_the_last_of_many_contacts_is_found_by_its_line() {
        let said = |text: &str| Scenario::parse(text, "s.toml").expect_err("a fault").to_string();
        let error = said(&many(4000, "inf"));
        assert!(error.contains("s.toml:12001: `contact[3999].force` is [0, 0, inf]"), "{error}");
    }

    #[test]
    fn checking_many_contacts_takes_no_longer_than_reading_them() {
        let (text, mut least) = (many(4000, "1"), [f64::INFINITY; 2]);
        for _ in 0..5 {
            let mut seconds = [0.0; 2];
            for (seconds, check) in seconds.iter_mut().zip([false, true]) {
                let start = std::time::Instant::now();
                let scenario: Scenario = toml_file::parse(&text, "s.toml").expect("sound");
                if check {
                    scenario.check("s.toml", &text).expect("sound");
                }
                *seconds = start.elapsed().as_secs_f64();
            }
            least = std::array::from_fn(|i| least[i].min(seconds[i]));
        }
        // To look for the line of each key would read the text 12 000 times again.
        let [read, checked] = least;
        assert!(checked < 10.0 * read, "{read} s to read 4000 contacts, {checked} s with the check");
    }

    #[test]
    fn more_contacts_than_the_bound_are_refused_by_name() {
        let error = Scenario::parse(&many(100_001, "1"), "s.toml").expect_err("too many").to_string();
        assert!(error.contains("`contact` is a list of 100001; expected at most 100 000"), "{error}");
        assert!(Scenario::parse(&many(100_000, "1"), "s.toml").is_ok());
    }

    #[test]
    fn numbers_whose_squares_overflow_are_refused_by_name() {
        for (text, key) in [
            ("[[contact]]\npoint = [0, 1e200, 0]\nforce = [0, 0, 1]", "`contact[0].point`"),
            ("[[contact]]\npoint = [0, 0, 0]\nforce = [0, 0, -1e200]", "`contact[0].force`"),
            ("[[pattern]]\nname = 'gravity'\namplitude = 1e200", "`pattern[0].amplitude`"),
            ("[[pattern]]\nname = 'gravity'\nramp = inf", "`pattern[0]`"),
        ] {
            let text = format!("duration = 1.0\n{text}\n");
            let error = Scenario::parse(&text, "s.toml").expect_err(key).to_string();
            assert!(error.contains(key), "{error}");
        }
    }

    #[test]
    fn steps_that_cannot_be_counted_are_refused_and_long_marches_unless_they_are_asked_for() {
        let lasting = |duration: f64| Scenario { duration, ..Scenario::default() };
        for duration in [1e300, 1e14, 2.0f64.powi(53) * 1e-3 * 1.001] {
            let refused = lasting(duration).steps_within(1e-3, STEPS_OF_A_RUN, true);
            assert!(matches!(refused, Err(StudyError::TooManySteps { .. })), "{duration}");
        }
        assert_eq!(lasting(1e12).steps(1e-3).expect("countable"), 1_000_000_000_000_000);
        let long = lasting(1e6 + 1.0);
        let refused = long.steps_within(1e-3, STEPS_OF_A_RUN, false);
        assert!(matches!(refused, Err(StudyError::Long { steps: 1_000_001_000, .. })));
        assert_eq!(long.steps_within(1e-3, STEPS_OF_A_RUN, true).expect("asked for"), 1_000_001_000);
        assert_eq!(lasting(1e-9).steps(1e-3).expect("one"), 1);
    }
}
