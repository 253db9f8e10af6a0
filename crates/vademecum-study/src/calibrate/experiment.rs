//! Measured numbers beside those that a file predicts.

use std::path::PathBuf;

use serde::Serialize;
use vademecum_build::input::OWN_COLUMNS;
use vademecum_build::progress::Silent;
use vademecum_build::suggest::did_you_mean;
use vademecum_eval::SceneOptions;
use vademecum_format::File;

use super::error::CalibrateError;
use crate::contents::numbers;
use crate::error::{FileError, StudyError};
use crate::frf::{Channel, Quantity, ResponseRequest, frequency_response};
use crate::player::PlayOptions;
use crate::run::{Moment, Run};
use crate::scenario::Scenario;
use crate::table::{Table, TableFileError};

/// A table of measured numbers and what they answer to.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// The table (CSV).
    pub path: PathBuf,
    /// The load on the body.
    pub source: Source,
}

/// Load on a body while it was measured.
#[derive(Clone, Debug)]
pub enum Source {
    /// A scenario: the table has histories, `time_s` first.
    Scenario(Box<Scenario>),
    /// A harmonic force: the table has a frequency response, `frequency_hz` first.
    Input(Channel),
    /// Nothing: the table has natural frequencies.
    Free,
}

/// Noise of the measured numbers.
#[derive(Clone, Copy, Debug)]
pub struct Noise {
    /// Standard deviation, as a share of the root of the mean square; of natural frequencies, of each.
    pub share: Option<f64>,
    /// True if the mean square is that over all columns of a unit in a table, false for that of each column.
    pub over_all: bool,
    /// Relative error of the model that is added; by default as much of that of the certificate as the
    /// differences need.
    pub model: Option<f64>,
}

/// Share of histories and responses that is noise, unless it is given.
const USUAL: f64 = 0.02;
/// The same of natural frequencies.
const USUAL_OF_FREQUENCIES: f64 = 1e-3;
/// Largest distance of a time from a step, in steps.
const OFF_STEP: f64 = 1e-3;

/// Measured numbers, row by row, with what predicts them.
pub(super) struct Experiment {
    pub name: String,
    pub labels: Vec<String>,
    /// The numbers of a row follow each other.
    measured: Vec<f64>,
    /// Those of each column, or of each number of natural frequencies.
    deviations: Vec<Deviation>,
    /// Relative error of the model in them.
    pub model_error: f64,
    kind: Kind,
}

/// Standard deviation of a number: that of the noise, and what the error of the model is a share of.
#[derive(Clone, Copy)]
struct Deviation {
    noise: f64,
    motion: f64,
}

impl Deviation {
    fn with(self, model_error: f64) -> f64 {
        self.noise.hypot(model_error * self.motion)
    }
}

enum Kind {
    /// The steps of the rows, and the columns of a run that are measured.
    History { scenario: Box<Scenario>, steps: Vec<usize>, columns: Vec<usize>, time_step: Option<f64> },
    /// For each column, the output, and true for its imaginary part.
    Response { request: Box<ResponseRequest>, columns: Vec<(usize, bool)> },
    /// Number of each mode, counted from 0.
    Frequencies { modes: Vec<usize> },
}

/// A measured column: its unit, empty if it is not known, and its group, which real and imaginary part of an
/// output share.
struct Column<'a> {
    name: &'a str,
    unit: &'a str,
    group: usize,
}

/// Settings with which experiments are read.
pub(super) struct Reading<'a> {
    /// A file at the values at the start.
    pub file: &'a File<'a>,
    pub noise: Noise,
    pub model_error: f64,
    pub time_step: Option<f64>,
    pub listener: &'a dyn vademecum_build::progress::Listener,
}

impl Reading<'_> {
    pub fn read(&self, measurement: &Measurement) -> Result<Experiment, CalibrateError> {
        let table = Table::read(&measurement.path)?;
        let first = table.columns[0].0.as_str();
        let wrong = |reason: &str| {
            CalibrateError::from(TableFileError::Whole { path: table.path.clone(), reason: reason.into() })
        };
        match (first, &measurement.source) {
            ("time_s", Source::Scenario(scenario)) => self.history(&table, scenario),
            ("time_s", _) => Err(wrong("histories over `time_s` need the loads: give `--scenario FILE`")),
            ("frequency_hz", Source::Input(input)) if table.columns.len() > 1 => self.response(&table, input),
            ("frequency_hz", Source::Free) if table.columns.len() > 1 => {
                Err(wrong("a frequency response needs the place of its force: give `--in CHANNEL`"))
            }
            ("frequency_hz" | "mode", _) => self.frequencies(&table),
            _ => {
                let expected = "`time_s` as `run` writes it, `frequency_hz` as `frf` writes it, or `frequency_hz` alone or behind \
                     `mode`";
                Err(table.fault(table.head, format!("the first column is `{first}`"), expected))
            }
        }
    }

    fn history(&self, table: &Table, scenario: &Scenario) -> Result<Experiment, CalibrateError> {
        let mut scenario = scenario.clone();
        let plan = &mut scenario.output;
        (plan.probes_every, plan.fields_every, plan.stress_every) = (1, 0, 0);
        let options = options(self.time_step);
        let run = Run::bind(self.file, options, &scenario, self.listener)?;
        let known = run.columns();
        let mut columns = vec![];
        let mut places = vec![];
        for (place, (name, unit)) in table.columns.iter().enumerate().skip(1) {
            if name == "energy_J" {
                self.listener.note(&format!(
                    "{}: `energy_J` is left out: no sensor measures it",
                    table.path.display()
                ));
                continue;
            }
            let found = known.iter().position(|(own, _)| own == name);
            let Some(found) = found else {
                let names = known.iter().map(|(name, _)| name.as_str());
                let list = names.clone().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
                let list = if list.is_empty() { "none but time and energy".into() } else { list };
                let expected = format!("a column of this run: {list}{}", did_you_mean(name, names));
                return Err(table.fault(table.head, format!("unknown column `{name}`"), expected));
            };
            let own = known[found].1;
            if !unit.is_empty() && !own.is_empty() && unit != own {
                let found = format!("column `{name}` in {unit}");
                return Err(table.fault(table.head, found, format!("{own}, the unit of the file")));
            }
            columns.push(found);
            places.push(place);
        }
        if columns.is_empty() {
            let expected = format!("at least one measured column beside {}", OWN_COLUMNS.join(" and "));
            return Err(table.fault(table.head, "no measured column", expected));
        }
        let (steps, time_step) = (self.steps(table, &run)?, self.time_step);
        let labels: Vec<String> = places.iter().map(|&place| table.columns[place].0.clone()).collect();
        let measured: Vec<f64> =
            table.rows.iter().flat_map(|(_, row)| places.iter().map(|&place| row[place])).collect();
        let own = places.iter().enumerate().map(|(group, &place)| Column {
            name: &table.columns[place].0,
            unit: known[columns[group]].1,
            group,
        });
        let deviations = self.deviations(table, &measured, &own.collect::<Vec<_>>())?;
        drop(run);
        let kind = Kind::History { scenario: Box::new(scenario), steps, columns, time_step };
        Ok(self.experiment(table, labels, (measured, deviations), kind))
    }

    /// Steps of the rows: equal distances, each at a step of the file.
    fn steps(&self, table: &Table, run: &Run<'_>) -> Result<Vec<usize>, CalibrateError> {
        let h = run.time_step;
        let mut steps: Vec<usize> = vec![];
        for (line, row) in &table.rows {
            let (time, step) = (row[0], (row[0] / h).round());
            if (time / h - step).abs() > OFF_STEP * step.abs().max(1.0).sqrt() || time < -OFF_STEP * h {
                let expected = format!(
                    "a multiple of the step of {h} s: resample the table, or give another step with `--time-step`"
                );
                return Err(table.fault(*line, format!("time {time} s"), expected));
            }
            let step = step.max(0.0) as usize;
            if step > run.steps {
                let expected = format!("at most {} s, the end of the scenario", run.steps as f64 * h);
                return Err(table.fault(*line, format!("time {time} s"), expected));
            }
            if let [.., last] = steps[..] {
                let spacing = if let [first, second, ..] = steps[..] { second - first } else { 0 };
                if step <= last {
                    let expected = format!("a time after {} s", last as f64 * h);
                    return Err(table.fault(*line, format!("time {time} s"), expected));
                }
                if spacing > 0 && step - last != spacing {
                    let found = format!("time {time} s, {} s after the row before", (step - last) as f64 * h);
                    let expected = format!(
                        "{} s after it, as between the first rows: a gap; give its parts as tables of their own only \
                         if each starts from rest",
                        spacing as f64 * h
                    );
                    return Err(table.fault(*line, found, expected));
                }
            }
            steps.push(step);
        }
        Ok(steps)
    }

    /// Deviation of each column; columns of one group have one mean square. The error of the model is a share
    /// of the motion of the whole body, so that its mean square is that over all columns of the same unit.
    fn deviations(
        &self,
        table: &Table,
        measured: &[f64],
        columns: &[Column<'_>],
    ) -> Result<Vec<Deviation>, CalibrateError> {
        let rows = table.rows.len() as f64;
        let mut squares = vec![0.0; columns.len()];
        for row in measured.chunks_exact(columns.len()) {
            squares.iter_mut().zip(row).for_each(|(sum, x)| *sum += x * x);
        }
        let root = |is_of: &dyn Fn(&Column<'_>) -> bool| {
            let of: Vec<f64> = columns
                .iter()
                .zip(&squares)
                .filter(|(own, _)| is_of(own))
                .map(|(_, square)| *square)
                .collect();
            (of.iter().sum::<f64>() / (rows * of.len() as f64)).sqrt()
        };
        let share = self.noise.share.unwrap_or(USUAL);
        let mut deviations = vec![];
        for column in columns {
            let all = root(&|other| {
                if column.unit.is_empty() { other.group == column.group } else { other.unit == column.unit }
            });
            let own = root(&|other| other.group == column.group);
            let noise = share * if self.noise.over_all { all } else { own };
            if noise <= 0.0 || !noise.is_finite() {
                let name = column.name;
                let found = format!("column `{name}` has no noise: it is zero throughout, or too large");
                return Err(table.fault(table.head, found, "a column that moves, or `--noise-over all`"));
            }
            deviations.push(Deviation { noise, motion: all });
        }
        Ok(deviations)
    }

    fn response(&self, table: &Table, input: &Channel) -> Result<Experiment, CalibrateError> {
        let (mut outputs, mut columns, mut labels) = (vec![], vec![], vec![]);
        let mut quantity = None;
        for (name, unit) in &table.columns[1..] {
            let (part, output) = name.split_once(' ').unwrap_or((name, ""));
            let expected = "`re OUTPUT [unit]` or `im OUTPUT [unit]`, as `frf` writes them";
            let unknown = || -> CalibrateError {
                table.fault(table.head, format!("unknown column `{name}`"), expected)
            };
            let is_imaginary = match part {
                "re" => false,
                "im" => true,
                _ => return Err(unknown()),
            };
            let own = match unit.as_str() {
                "m/N" | "m" => Quantity::Displacement,
                "m/(N s)" | "m/s" => Quantity::Velocity,
                "m/(N s²)" | "m/s²" => Quantity::Acceleration,
                _ => {
                    let expected = "m/N, m/(N s) or m/(N s²), or of a load pattern m, m/s or m/s²";
                    return Err(table.fault(
                        table.head,
                        format!("unit `{unit}` of column `{name}`"),
                        expected,
                    ));
                }
            };
            if *quantity.get_or_insert(own) != own {
                let found = format!("column `{name}` in {unit}");
                return Err(table.fault(
                    table.head,
                    found,
                    "columns of one quantity; give one table for each",
                ));
            }
            let channel = channel(output).ok_or_else(unknown)?;
            let place = outputs.iter().position(|known| *known == channel).unwrap_or_else(|| {
                outputs.push(channel);
                outputs.len() - 1
            });
            columns.push((place, is_imaginary));
            labels.push(name.clone());
        }
        let frequencies: Vec<f64> = table.rows.iter().map(|(_, row)| row[0]).collect();
        for (pair, (line, _)) in frequencies.windows(2).zip(&table.rows[1..]) {
            if pair[1] <= pair[0] {
                return Err(table.fault(
                    *line,
                    format!("frequency {} Hz", pair[1]),
                    format!("more than {}", pair[0]),
                ));
            }
        }
        if frequencies[0] <= 0.0 {
            return Err(table.fault(
                table.rows[0].0,
                format!("frequency {} Hz", frequencies[0]),
                "more than 0",
            ));
        }
        let request = ResponseRequest {
            input: input.clone(),
            outputs,
            frequencies,
            quantity: quantity.unwrap_or(Quantity::Displacement),
        };
        // Names are looked up now, so that a fault is one of the table.
        frequency_response(self.file, &SceneOptions::default(), &request)?;
        let measured: Vec<f64> = table.rows.iter().flat_map(|(_, row)| row[1..].to_vec()).collect();
        let own = labels.iter().zip(&columns).map(|(name, (group, _))| Column {
            name,
            unit: "response",
            group: *group,
        });
        let deviations = self.deviations(table, &measured, &own.collect::<Vec<_>>())?;
        let kind = Kind::Response { request: Box::new(request), columns };
        Ok(self.experiment(table, labels, (measured, deviations), kind))
    }

    fn frequencies(&self, table: &Table) -> Result<Experiment, CalibrateError> {
        let names: Vec<&str> = table.columns.iter().map(|(name, _)| name.as_str()).collect();
        let numbered = match names[..] {
            ["frequency_hz"] => false,
            ["mode", "frequency_hz"] => true,
            _ => {
                let found = format!("columns {}", names.join(", "));
                return Err(table.fault(table.head, found, "`frequency_hz`, or `mode,frequency_hz`"));
            }
        };
        let count = self.file.metadata().n_modes as usize;
        let (mut modes, mut measured) = (vec![], vec![]);
        for (place, (line, row)) in table.rows.iter().enumerate() {
            let number = if numbered { row[0] } else { (place + 1) as f64 };
            if number.fract() != 0.0 || !(1.0..=count as f64).contains(&number) {
                let expected = format!("a mode from 1 to {count}, which the file steps");
                return Err(table.fault(*line, format!("mode {number}"), expected));
            }
            let frequency = row[names.len() - 1];
            if frequency <= 0.0 {
                return Err(table.fault(*line, format!("frequency {frequency} Hz"), "more than 0"));
            }
            modes.push(number as usize - 1);
            measured.push(frequency);
        }
        let share = self.noise.share.unwrap_or(USUAL_OF_FREQUENCIES);
        // A frequency that is off by a share turns the motion by at least as much within half a period.
        let deviations = measured.iter().map(|&f| Deviation { noise: share * f, motion: f }).collect();
        let labels = modes.iter().map(|mode| format!("mode {}", mode + 1)).collect();
        Ok(self.experiment(table, labels, (measured, deviations), Kind::Frequencies { modes }))
    }

    /// The experiment of a table.
    fn experiment(
        &self,
        table: &Table,
        labels: Vec<String>,
        (measured, deviations): (Vec<f64>, Vec<Deviation>),
        kind: Kind,
    ) -> Experiment {
        let name = table.path.display().to_string();
        Experiment { name, labels, measured, deviations, model_error: self.model_error, kind }
    }
}

/// An output as `frf` names it in its table: a name, or `(x y z) along (u v w)`.
fn channel(text: &str) -> Option<Channel> {
    let Some((place, direction)) = text.split_once(" along ") else { return text.parse().ok() };
    let bare = |part: &str| -> Option<String> {
        let inner = part.trim().strip_prefix('(')?.strip_suffix(')')?;
        Some(inner.split_whitespace().collect::<Vec<_>>().join(","))
    };
    format!("{},{}", bare(place)?, bare(direction)?).parse().ok()
}

fn options(time_step: Option<f64>) -> PlayOptions {
    let mut options = PlayOptions::default();
    options.scene.time_step = time_step;
    options
}

impl Experiment {
    /// True of histories.
    pub fn is_history(&self) -> bool {
        matches!(self.kind, Kind::History { .. })
    }

    /// Number of measured numbers.
    pub fn len(&self) -> usize {
        self.measured.len()
    }

    /// Differences of a file from the measured numbers, each over its deviation; of histories the first
    /// `share` of the rows.
    pub fn differences(&self, file: &File<'_>, share: f64, out: &mut Vec<f64>) -> Result<(), StudyError> {
        let predicted = self.predict(file, share)?;
        for (place, (predicted, measured)) in predicted.iter().zip(&self.measured).enumerate() {
            out.push((predicted - measured) / self.deviation(place).with(self.model_error));
        }
        Ok(())
    }

    /// Deviation of a measured number.
    fn deviation(&self, place: usize) -> Deviation {
        let is_own = matches!(self.kind, Kind::Frequencies { .. });
        self.deviations[if is_own { place } else { place % self.deviations.len() }]
    }

    /// `χ²` of these differences if the error of the model were another.
    pub fn chi_with(&self, differences: &[f64], model_error: f64) -> f64 {
        let scaled = |(place, x): (usize, &f64)| {
            let own = self.deviation(place);
            let x = x * own.with(self.model_error) / own.with(model_error);
            x * x
        };
        differences.iter().enumerate().map(scaled).sum()
    }

    fn predict(&self, file: &File<'_>, share: f64) -> Result<Vec<f64>, StudyError> {
        match &self.kind {
            Kind::History { scenario, steps, columns, time_step } => {
                let count = ((steps.len() as f64 * share).ceil() as usize).clamp(1, steps.len());
                let mut scenario = scenario.clone();
                let h = time_step.unwrap_or(file.metadata().time_step);
                scenario.duration = scenario.duration.min((steps[count - 1].max(1) as f64) * h);
                play(file, &scenario, &steps[..count], columns, *time_step)
            }
            Kind::Response { request, columns } => {
                let found = frequency_response(file, &SceneOptions::default(), request)?;
                let row = |place: usize| {
                    let values = &found.values;
                    columns.iter().map(move |&(output, is_imaginary)| {
                        let value = values[output][place];
                        if is_imaginary { value.im } else { value.re }
                    })
                };
                Ok((0..request.frequencies.len()).flat_map(row).collect())
            }
            Kind::Frequencies { modes } => {
                let values = numbers(file, vademecum_format::SectionKind::Eigenvalues)?;
                let hertz = |mode: &usize| {
                    let value = values.get(*mode).copied();
                    let missing = FileError::Missing { kind: vademecum_format::SectionKind::Eigenvalues };
                    Ok(value.ok_or(missing)?.sqrt() / std::f64::consts::TAU)
                };
                modes.iter().map(hertz).collect()
            }
        }
    }

    /// Sum of the squares of the differences of each column (of each number, for natural frequencies) over
    /// its count.
    pub fn by_column(&self, differences: &[f64]) -> Vec<ColumnFit> {
        let columns = self.labels.len();
        let rows = (differences.len() / columns.max(1)).max(1) as f64;
        let column = |place: usize| {
            let own = differences.iter().skip(place).step_by(columns);
            let square = own.map(|x| x * x).sum::<f64>() / rows;
            ColumnFit { name: self.labels[place].clone(), chi_squared: square }
        };
        (0..columns).map(column).collect()
    }
}

/// Fit of a column.
#[derive(Clone, Debug, Serialize)]
pub struct ColumnFit {
    /// Its name.
    pub name: String,
    /// Mean square of its differences over their deviations.
    pub chi_squared: f64,
}

/// Numbers of a run at these steps, row by row.
fn play(
    file: &File<'_>,
    scenario: &Scenario,
    steps: &[usize],
    columns: &[usize],
    time_step: Option<f64>,
) -> Result<Vec<f64>, StudyError> {
    let run = Run::bind(file, options(time_step), scenario, &Silent)?;
    let (mut out, mut step, mut wanted) = (vec![], 0, steps.iter().peekable());
    run.play::<StudyError>(&Silent, |moment: &Moment<'_>| {
        if wanted.next_if(|&&next| next == step).is_some()
            && let Some(probed) = &moment.probes
        {
            let parts = [
                probed.values,
                probed.reactions.as_flattened(),
                probed.flight,
                probed.quantities,
                probed.contacts.as_flattened(),
            ];
            let all = parts.concat();
            out.extend(columns.iter().map(|&column| all[column]));
        }
        step += 1;
        Ok(())
    })?;
    Ok(out)
}
