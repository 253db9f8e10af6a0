//! The scenario file: which loads act when (normative: `formats/scenario-1.md`).
//!
//! A scenario knows nothing of meshes or modes, so the full-order solver and the evaluator march the same
//! one.

use std::path::Path;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use vademecum_build::dynamics::{Course, History, Interval, LoadTable, Wave};
use vademecum_build::input::ProbeEntry;
use vademecum_build::input::toml_file::{self, TomlError};

use vademecum_format::{BASE_PATTERNS, BaseMotion};

use crate::error::StudyError;
use tables::{Columns, LARGEST, Tables};

mod tables;

pub use tables::Rows;

/// Most steps that a march can have: beyond, `n Δt` no longer tells one instant from the next.
pub const MOST_STEPS: u64 = 1 << 53;

/// Most steps that a file is marched unless it is asked for more: at about a microsecond for a step and its
/// row of probes a quarter of an hour, and a table of some 60 GB if every step writes a row.
pub const STEPS_OF_A_RUN: u64 = 1_000_000_000;

/// Most steps that are marched at full order unless more is asked for: at some milliseconds a step, an hour
/// or more. All of their reduced coordinates are kept until they are compared.
pub const STEPS_AT_FULL_ORDER: u64 = 1_000_000;

/// Most contacts, and most load patterns, of a scenario. Each contact is looked for on the whole surface,
/// which takes a fraction of a millisecond.
pub(crate) const MOST_LOADS: usize = 100_000;

/// Most probes of a scenario: each of them is a column of the table.
const MOST_PROBES: usize = 10_000;

/// Most periods of a sinusoid or a chirp in a step: it is stepped in 2222 parts a period.
const MOST_PERIODS: f64 = 16.0;

/// Highest frequency \[Hz\] and largest phase \[rad\] and mean of a sinusoid: beyond, none of its digits is
/// left after the first periods. Also the largest velocity, angular velocity and gravity of a free body.
const FASTEST: f64 = 1e9;

/// A scenario file that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct ScenarioError(#[from] pub TomlError);

/// Loads over time, from rest.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Length \[s\].
    pub duration: f64,
    /// Forces at points of the loadable surface.
    #[serde(rename = "contact", default)]
    pub contacts: Vec<ContactEntry>,
    /// Load patterns of the file; once read, the motions of the base behind them.
    #[serde(rename = "pattern", default)]
    pub patterns: Vec<PatternUse>,
    /// How a free body is thrown; absent: its elastic motion alone is played, in the body.
    pub free: Option<FreeEntry>,
    /// How the base moves.
    #[serde(skip_serializing_if = "is_among_patterns")]
    pub base: Option<BaseEntry>,
    /// What `run` writes.
    #[serde(default)]
    pub output: OutputPlan,
}

/// Once a scenario is read, the motions of its base are patterns, and need not be written twice.
fn is_among_patterns(_: &Option<BaseEntry>) -> bool {
    true
}

/// How a free body starts, and how gravity pulls it.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FreeEntry {
    /// Velocity of its centre \[m/s\].
    #[serde(default)]
    pub velocity: [f64; 3],
    /// Angular velocity \[rad/s\].
    #[serde(default)]
    pub spin: [f64; 3],
    /// Acceleration of gravity \[m/s²\].
    #[serde(default)]
    pub gravity: [f64; 3],
}

impl Scenario {
    /// Start and end of each load \[s\], within the scenario.
    #[must_use]
    pub fn acting(&self) -> Vec<[f64; 2]> {
        let contacts = self.contacts.iter().map(|load| [load.start, load.end]);
        let all = contacts.chain(self.patterns.iter().map(|load| [load.start, load.end]));
        all.map(|[start, end]| [start.min(self.duration), end.min(self.duration)]).collect()
    }
}

/// One force at one point, which may move, for a while.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactEntry {
    /// Where; the nearest point of the loadable surface is taken. Absent where `path` says it.
    pub point: Option<[f64; 3]>,
    /// Where over time, instead of `point`: rows `time,x,y,z` from the start of the load on.
    pub path: Option<Rows>,
    /// Force \[N\]. Absent where a table has it.
    pub force: Option<[f64; 3]>,
    /// First instant \[s\].
    #[serde(default)]
    pub start: f64,
    /// First instant without the load \[s\]; absent: to the end.
    #[serde(default = "forever")]
    pub end: f64,
    /// Time to full force \[s\].
    #[serde(default)]
    pub ramp: f64,
    /// Rows `time,amplitude`, a factor on `force`, or `time,fx,fy,fz` from the start of the load on.
    pub table: Option<Rows>,
    /// A factor on `force`.
    pub sinusoid: Option<SinusoidEntry>,
    /// A factor on `force`.
    pub chirp: Option<ChirpEntry>,
    /// The path as it was read.
    #[serde(skip)]
    places: Option<Arc<LoadTable>>,
    /// The table as it was read.
    #[serde(skip)]
    rows: Option<Arc<LoadTable>>,
}

/// A motion of the base that was recorded.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BaseEntry {
    /// Rows `time,ax,ay,az` in m/s², or `time,ax,ay,az,wx,wy,wz,dwx,dwy,dwz` with angular velocities
    /// \[rad/s\] and angular accelerations \[rad/s²\], in the axes of the base.
    pub record: Rows,
    /// A factor on `ax`, `ay` and `az`.
    #[serde(default = "one")]
    pub amplitude: f64,
}

/// One load pattern for a while.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
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
    /// Rows `time,amplitude`, a factor on `amplitude`, from the start of the load on.
    pub table: Option<Rows>,
    /// A factor on `amplitude`.
    pub sinusoid: Option<SinusoidEntry>,
    /// A factor on `amplitude`.
    pub chirp: Option<ChirpEntry>,
    /// The table as it was read.
    #[serde(skip)]
    rows: Option<Arc<LoadTable>>,
}

/// `mean + sin(2π f t + phase)`, with `t` from the start of the load.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SinusoidEntry {
    /// `f` \[Hz\].
    pub frequency: f64,
    /// Phase at the start \[rad\].
    #[serde(default)]
    pub phase: f64,
    /// What is added.
    #[serde(default)]
    pub mean: f64,
}

/// A sinusoid whose frequency rises or falls linearly from the start of the load to its end.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChirpEntry {
    /// Frequency at the start \[Hz\].
    pub from: f64,
    /// Frequency at the end \[Hz\].
    pub to: f64,
    /// Phase at the start \[rad\].
    #[serde(default)]
    pub phase: f64,
}

/// What `run` writes and how often.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
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
    /// Named values beside those of the file.
    #[serde(rename = "probe", default)]
    pub probes: Vec<ProbeEntry>,
    /// Named stresses.
    #[serde(rename = "stress", default)]
    pub stresses: Vec<StressEntry>,
    /// The stress of every point of the file every so many steps; 0: never.
    #[serde(default)]
    pub stress_every: usize,
}

/// A stress at the node nearest to a point, of those whose stress the file has.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StressEntry {
    /// Its name.
    pub name: String,
    /// Where.
    pub point: [f64; 3],
    /// What of the stress.
    #[serde(default)]
    pub quantity: StressQuantity,
}

/// A number that is taken of a stress \[Pa\].
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StressQuantity {
    /// Von Mises' equivalent stress.
    #[default]
    VonMises,
    /// The principal stress of the largest size, with its sign.
    SignedMaximum,
    /// The largest principal stress.
    First,
    /// The middle principal stress.
    Second,
    /// The smallest principal stress.
    Third,
    /// A component.
    Xx,
    /// A component.
    Yy,
    /// A component.
    Zz,
    /// A component.
    Xy,
    /// A component.
    Yz,
    /// A component.
    Zx,
}

/// Which nodes a field shows.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq, JsonSchema)]
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
        Self {
            probes_every: 1,
            fields_every: 0,
            fields: FieldChoice::default(),
            probes: vec![],
            stresses: vec![],
            stress_every: 0,
        }
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
    /// A force at a point from time zero to `end` \[s\].
    pub fn push(point: [f64; 3], force: [f64; 3], end: f64) -> Self {
        Self { point: Some(point), force: Some(force), end, ..Self::default() }
    }

    /// Its forces of fixed direction, each with its history: one, or one for each component of a table.
    pub(crate) fn forces(&self, duration: f64) -> Vec<([f64; 3], History)> {
        let history = |course| History { during: self.varying().during(), share: None, course };
        match &self.rows {
            Some(table) if table.columns() == 3 => {
                let axis = |c: usize| std::array::from_fn(|i| if i == c { 1.0 } else { 0.0 });
                let acts = (0..3).filter(|&c| table.largest(c) > 0.0);
                acts.map(|c| (axis(c), history(Course::Table(Arc::clone(table), c)))).collect()
            }
            _ => vec![(self.force.unwrap_or_default(), self.varying().history(duration))],
        }
    }

    /// The places of its path, each with its instant; none if it stays where it is.
    pub(crate) fn path_rows(&self) -> Option<Vec<(f64, [f64; 3])>> {
        let places = self.places.as_ref()?;
        let [x, y, z] = [0, 1, 2].map(|c| places.rows(c));
        Some(x.zip(y).zip(z).map(|(([t, x], [_, y]), [_, z])| (self.start + t, [x, y, z])).collect())
    }

    fn varying(&self) -> Varying<'_> {
        let Self { start, end, ramp, sinusoid, chirp, ref table, ref rows, .. } = *self;
        let when = Interval { start, end, ramp };
        Varying { when, table: table.is_some(), rows: rows.as_ref(), sinusoid, chirp }
    }
}

impl BaseEntry {
    /// The patterns of the base that act, as tables: formed at the rows, and linear between them. The size of
    /// a number that is too large otherwise.
    fn motions(&self, table: &LoadTable) -> Result<Vec<PatternUse>, f64> {
        let columns: Vec<Vec<[f64; 2]>> = (0..table.columns()).map(|c| table.rows(c).collect()).collect();
        let times: Vec<f64> = columns[0].iter().map(|[time, _]| *time).collect();
        let three = |row: usize, first: usize| -> [f64; 3] {
            std::array::from_fn(|c| columns.get(first + c).map_or(0.0, |column| column[row][1]))
        };
        let amplitudes: Vec<[f64; 12]> = (0..times.len())
            .map(|row| {
                let motion = BaseMotion {
                    acceleration: three(row, 0).map(|a| self.amplitude * a),
                    angular_velocity: three(row, 3),
                    angular_acceleration: three(row, 6),
                };
                motion.amplitudes()
            })
            .collect();
        let mut found = vec![];
        for (motion, name) in BASE_PATTERNS.iter().enumerate() {
            let values: Vec<f64> = amplitudes.iter().map(|row| row[motion]).collect();
            let largest = values.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            match largest {
                0.0 => continue,
                x if x <= LARGEST => {}
                x => return Err(x),
            }
            let rows = times.iter().zip(&values).map(|(&t, &x)| vec![t, x]).collect();
            found.push(PatternUse {
                name: (*name).into(),
                amplitude: 1.0,
                start: 0.0,
                end: forever(),
                ramp: 0.0,
                table: Some(Rows::Here(rows)),
                sinusoid: None,
                chirp: None,
                rows: LoadTable::new(times.clone(), values).map(Arc::new),
            });
        }
        Ok(found)
    }
}

impl PatternUse {
    /// How it follows time.
    pub(crate) fn history(&self, duration: f64) -> History {
        self.varying().history(duration)
    }

    fn varying(&self) -> Varying<'_> {
        let Self { start, end, ramp, sinusoid, chirp, ref table, ref rows, .. } = *self;
        let when = Interval { start, end, ramp };
        Varying { when, table: table.is_some(), rows: rows.as_ref(), sinusoid, chirp }
    }
}

/// What contacts and patterns say alike of how they follow time.
struct Varying<'a> {
    when: Interval,
    table: bool,
    rows: Option<&'a Arc<LoadTable>>,
    sinusoid: Option<SinusoidEntry>,
    chirp: Option<ChirpEntry>,
}

impl Varying<'_> {
    fn during(&self) -> Interval {
        self.when
    }

    fn history(&self, duration: f64) -> History {
        let Interval { start, end, .. } = self.when;
        let course = if let Some(table) = self.rows {
            Course::Table(Arc::clone(table), 0)
        } else if let Some(SinusoidEntry { frequency, phase, mean }) = self.sinusoid {
            Course::Wave(Wave::sinusoid(frequency, phase, mean))
        } else if let Some(ChirpEntry { from, to, phase }) = self.chirp {
            // Without an end of its own it sweeps up to the end of the scenario.
            let end = if end < forever() { end } else { duration };
            let sweep = if end > start { end - start } else { 1.0 };
            Course::Wave(Wave { frequency: [from, to], sweep, phase, mean: 0.0 })
        } else {
            Course::Held
        };
        History { during: self.when, share: None, course }
    }

    fn highest_frequency(&self) -> f64 {
        let sweep = self.chirp.map_or(0.0, |chirp| chirp.from.max(chirp.to));
        self.sinusoid.map_or(sweep, |sinusoid| sinusoid.frequency)
    }

    /// The first value that cannot be; `key` is that of the load.
    fn fault(&self, key: &dyn Fn() -> String) -> Option<Fault> {
        let Interval { ramp, .. } = self.when;
        if let Some(fault) = interval_fault(key, self.when) {
            return Some(fault);
        }
        let fault = |name: &str, found: String, expected| {
            let key = if name.is_empty() { key() } else { format!("{}.{name}", key()) };
            Some(Fault { key, found, expected })
        };
        let kinds =
            [("table", self.table), ("sinusoid", self.sinusoid.is_some()), ("chirp", self.chirp.is_some())];
        let named: Vec<String> =
            kinds.iter().filter(|kind| kind.1).map(|kind| format!("`{}`", kind.0)).collect();
        if named.len() > 1 {
            return fault("", named.join(" beside "), "at most one of `table`, `sinusoid` and `chirp`");
        }
        if self.table && ramp > 0.0 {
            return fault("ramp", time(ramp), "none beside `table`, whose rows say how the load rises");
        }
        const FREQUENCY: &str = "a frequency from 0 to 1e9 Hz";
        const SMALL: &str = "a finite number of at most 1e9 in size";
        let frequency = |f: f64| (0.0..=FASTEST).contains(&f);
        let small = |x: f64| x.abs() <= FASTEST;
        if let Some(SinusoidEntry { frequency: f, phase, mean }) = self.sinusoid {
            if !frequency(f) {
                return fault("sinusoid.frequency", time(f), FREQUENCY);
            }
            for (name, value) in [("sinusoid.phase", phase), ("sinusoid.mean", mean)] {
                if !small(value) {
                    return fault(name, time(value), SMALL);
                }
            }
        }
        if let Some(ChirpEntry { from, to, phase }) = self.chirp {
            for (name, value) in [("chirp.from", from), ("chirp.to", to)] {
                if !frequency(value) {
                    return fault(name, time(value), FREQUENCY);
                }
            }
            if !small(phase) {
                return fault("chirp.phase", time(phase), SMALL);
            }
        }
        None
    }
}

impl Scenario {
    /// Reads and checks a scenario file.
    pub fn read(path: &Path) -> Result<Self, ScenarioError> {
        Self::parse(&toml_file::read(path)?, &path.display().to_string())
    }

    /// Reads and checks a scenario from its text; messages name `path`, and files of tables are looked for in
    /// its folder.
    pub fn parse(text: &str, path: &str) -> Result<Self, ScenarioError> {
        let mut scenario: Scenario = toml_file::parse(text, path)?;
        scenario.check(path, text)?;
        scenario.read_tables(path, text)?;
        Ok(scenario)
    }

    /// Number of steps of `time_step`, at least one.
    ///
    /// # Errors
    /// [`StudyError::TooManySteps`] beyond [`MOST_STEPS`].
    pub fn steps(&self, time_step: f64) -> Result<usize, StudyError> {
        let (duration, steps) = (self.duration, (self.duration / time_step).round());
        let countable = steps <= MOST_STEPS as f64 && steps <= usize::MAX as f64;
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
            if frequency * time_step > MOST_PERIODS {
                let load = format!("{kind}[{index}]");
                return Err(StudyError::TooFast { load, frequency, time_step, most: MOST_PERIODS });
            }
        }
        Ok(())
    }

    /// Reads the tables that loads name, and checks what they are used for.
    fn read_tables(&mut self, path: &str, text: &str) -> Result<(), ScenarioError> {
        let mut tables = Tables::beside(Path::new(path));
        let place = |key: &str| toml_file::place(path, text, key);
        let too_large = |key: String, size: f64| {
            let expected = "rows and a force whose product is at most 1e150 in size";
            TomlError::Impossible {
                path: place(&key),
                key,
                found: format!("a table that makes products up to {size:e}"),
                expected,
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
                return Err(
                    TomlError::Impossible { path: place(&key), key, found: found.into(), expected }.into()
                );
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

    fn check(&self, path: &str, text: &str) -> Result<(), ScenarioError> {
        // Where a key stands is looked for once, in the end: the whole text is read again for it.
        self.fault().map_or(Ok(()), |Fault { key, found, expected }| {
            let path = toml_file::place(path, text, &key);
            Err(TomlError::Impossible { path, key, found, expected }.into())
        })
    }

    /// The first value that cannot be.
    fn fault(&self) -> Option<Fault> {
        let fault = |key: &str, found: String, expected| Some(Fault { key: key.into(), found, expected });
        if !(self.duration > 0.0 && self.duration.is_finite()) {
            return fault("duration", self.duration.to_string(), "a positive time in seconds");
        }
        if self.output.probes_every == 0 {
            return fault("output.probes_every", "0".into(), "at least 1");
        }
        for (key, count) in [("contact", self.contacts.len()), ("pattern", self.patterns.len())] {
            if count > MOST_LOADS {
                return fault(key, format!("a list of {count}"), "at most 100 000 of them");
            }
        }
        if let Some(FreeEntry { velocity, spin, gravity }) = self.free {
            for (key, vector) in [("free.velocity", velocity), ("free.spin", spin), ("free.gravity", gravity)]
            {
                if !vector.iter().all(|x| x.abs() <= FASTEST) {
                    return fault(key, numbers(&vector), "finite numbers of at most 1e9 in size");
                }
            }
        }
        let probes = &self.output.probes;
        let stresses = &self.output.stresses;
        for (key, count) in [("output.probe", probes.len()), ("output.stress", stresses.len())] {
            if count > MOST_PROBES {
                return fault(key, format!("a list of {count}"), "at most 10 000 of them");
            }
        }
        if let Some(base) = self
            .base
            .as_ref()
            .filter(|base| base.amplitude.abs().min(f64::MAX) > LARGEST || base.amplitude.is_nan())
        {
            return fault(
                "base.amplitude",
                base.amplitude.to_string(),
                "a finite number of at most 1e150 in size",
            );
        }
        let contacts = self.contacts.iter().enumerate();
        let patterns = self.patterns.iter().enumerate();
        contacts
            .map(|(i, contact)| contact.fault(i))
            .chain(patterns.map(|(i, pattern)| pattern.fault(i)))
            .chain((0..probes.len()).map(|i| probe_fault(probes, i)))
            .chain((0..stresses.len()).map(|i| self.output.stress_fault(i)))
            .find_map(|fault| fault)
    }
}

/// A value that cannot be.
struct Fault {
    key: String,
    found: String,
    expected: &'static str,
}

impl ContactEntry {
    fn fault(&self, index: usize) -> Option<Fault> {
        let at = || format!("contact[{index}]");
        for (name, vector) in [("point", self.point), ("force", self.force)] {
            let Some(vector) = vector.filter(|vector| !vector.iter().all(|v| v.abs() <= LARGEST)) else {
                continue;
            };
            let expected = "finite numbers of at most 1e150 in size, whose squares are finite too";
            return Some(Fault { key: format!("{}.{name}", at()), found: numbers(&vector), expected });
        }
        if self.point.is_some() == self.path.is_some() {
            let found = if self.point.is_some() { "`point` beside `path`" } else { "without a place" };
            let expected = "`point` or `path`, one of them";
            return Some(Fault { key: at(), found: found.into(), expected });
        }
        if self.force.is_none() && self.table.is_none() {
            let expected = "`force`, or a `table` of `time,fx,fy,fz`";
            return Some(Fault { key: at(), found: "without a force".into(), expected });
        }
        self.varying().fault(&at)
    }
}

/// The first value of a probe that cannot be.
fn probe_fault(probes: &[ProbeEntry], index: usize) -> Option<Fault> {
    let ProbeEntry { name, point, direction } = &probes[index];
    let fault = |key: &str, found, expected| {
        Some(Fault { key: format!("output.probe[{index}].{key}"), found, expected })
    };
    let twice = probes[..index].iter().any(|other| other.name == *name);
    if name.is_empty() || name.contains(['\n', ',', '"']) || twice {
        return fault("name", format!("{name:?}"), "a name of one line that no other probe has");
    }
    if !point.iter().all(|x| x.abs() <= LARGEST) {
        return fault("point", numbers(point), "finite numbers of at most 1e150 in size");
    }
    let length: f64 = direction.iter().map(|x| x * x).sum();
    if !(length > 0.0 && length.is_finite()) {
        return fault("direction", numbers(direction), "a vector of some length");
    }
    None
}

impl OutputPlan {
    fn stress_fault(&self, index: usize) -> Option<Fault> {
        let StressEntry { name, point, .. } = &self.stresses[index];
        let fault = |key: &str, found, expected| {
            Some(Fault { key: format!("output.stress[{index}].{key}"), found, expected })
        };
        let probes = self.probes.iter().map(|probe| &probe.name);
        let mut others = probes.chain(self.stresses[..index].iter().map(|stress| &stress.name));
        if name.is_empty() || name.contains(['\n', ',', '"']) || others.any(|other| other == name) {
            return fault(
                "name",
                format!("{name:?}"),
                "a name of one line that no other probe or stress has",
            );
        }
        if !point.iter().all(|x| x.abs() <= LARGEST) {
            return fault("point", numbers(point), "finite numbers of at most 1e150 in size");
        }
        None
    }
}

impl PatternUse {
    fn fault(&self, index: usize) -> Option<Fault> {
        let at = || format!("pattern[{index}]");
        if self.amplitude.abs() <= LARGEST {
            return self.varying().fault(&at);
        }
        let expected = "a finite number of at most 1e150 in size, whose square is finite too";
        Some(Fault { key: format!("{}.amplitude", at()), found: self.amplitude.to_string(), expected })
    }
}

fn interval_fault(key: &dyn Fn() -> String, when: Interval) -> Option<Fault> {
    let Interval { start, end, ramp } = when;
    if start >= 0.0 && end > start && ramp >= 0.0 && ramp.is_finite() {
        return None;
    }
    let found = format!("start {}, end {}, ramp {}", time(start), time(end), time(ramp));
    Some(Fault { key: key(), found, expected: "0 ≤ start < end and a finite ramp ≥ 0" })
}

/// Numbers as a scenario has them.
fn numbers(vector: &[f64]) -> String {
    let numbers: Vec<String> = vector.iter().map(|&x| time(x)).collect();
    format!("[{}]", numbers.join(", "))
}

/// A number in as few digits as tell it; very large and very small ones with an exponent.
fn time(x: f64) -> String {
    let plain = x == 0.0 || !x.is_finite() || (1e-4..1e16).contains(&x.abs());
    if plain { x.to_string() } else { format!("{x:e}") }
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
