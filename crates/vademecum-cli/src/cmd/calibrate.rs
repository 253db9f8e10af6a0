//! `vademecum calibrate`: live parameters of a file from measured numbers.

use std::path::PathBuf;

use vademecum_study::calibrate::{
    CalibrateOptions, Calibration, Direction, Estimate, Noise, calibrate, measurements,
};
use vademecum_study::frf::Channel;
use vademecum_study::live::at_values;
use vademecum_study::parameters::ParameterValue;
use vademecum_study::scenario::Scenario;

use crate::arguments::{Limit, OutputArguments, positive, setting};
use crate::console::Console;
use crate::failure::Failure;
use crate::files::{RewriteOutput, check_output, outputs, read_file, usable_bytes, write_file};
use crate::print::print_json;
use vademecum_build::store::Kind;

/// Fits live parameters of a parametric model to measured histories, frequency responses or natural
/// frequencies.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum calibrate body.vdm --data tap.csv --scenario tap.toml -o fitted.vdm
  vademecum calibrate body.vdm --data a.csv --scenario a.toml --data b.csv --scenario b.toml --noise 0.05
  vademecum calibrate body.vdm --data frf.csv --in 1,0.04,0.1,-z --fit \"tip stiffness\" --json
  vademecum calibrate body.vdm --data frequencies.csv -o fitted.vdm
Tables are CSV with names and units in the first line: `time_s` and columns of `run`, `frequency_hz` and
columns of `frf`, or `frequency_hz` alone, the lowest natural frequencies (or `mode,frequency_hz`).")]
pub(crate) struct Calibrate {
    /// The vademecum file, with a parametric model.
    file: PathBuf,
    /// Table of measured numbers (CSV); may be given several times.
    #[arg(long, required = true, value_name = "TABLE")]
    data: Vec<PathBuf>,
    /// Scenario (TOML) of a table with histories: one for each, in their order, or one for all.
    #[arg(long)]
    scenario: Vec<PathBuf>,
    /// Point and direction of the force of a table with a frequency response, a load pattern or a probe.
    #[arg(long = "in", value_name = "CHANNEL", allow_hyphen_values = true)]
    input: Vec<Channel>,
    /// Parameter that is fitted, by its name; may be given several times [default: all but the time step].
    #[arg(long, value_name = "NAME")]
    fit: Vec<String>,
    /// Value of a parameter: it stays there, or starts there if it is fitted.
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting)]
    set: Vec<ParameterValue>,
    /// Standard deviation of the noise, as a share of the root of the mean square [default: 0.02; of natural
    /// frequencies 0.001, as a share of each].
    #[arg(long, value_name = "SHARE", value_parser = positive, allow_negative_numbers = true)]
    noise: Option<f64>,
    /// Mean square that the noise is a share of.
    #[arg(long, value_enum, default_value_t = Over::Column)]
    noise_over: Over,
    /// Relative error of the model, added to the noise [default: as much of the median of the certificate as
    /// the differences need].
    #[arg(long, value_name = "SHARE", value_parser = share)]
    model_error: Option<f64>,
    /// Time step of histories in s; the file's if absent.
    #[arg(long, value_parser = positive, allow_negative_numbers = true)]
    time_step: Option<f64>,
    /// The file at the fitted values, an ordinary file; none is written without.
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    outputs: OutputArguments,
    #[command(flatten)]
    limit: Limit,
}

/// Mean square that noise is a share of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Over {
    /// That of each column.
    Column,
    /// That over all columns of the same unit in a table.
    All,
}

/// A number of at least 0.
fn share(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| (0.0..=1.0).contains(number));
    number.ok_or_else(|| format!("`{text}` is no share; expected a number from 0 to 1 such as 0.005"))
}

/// JSON output.
#[derive(serde::Serialize)]
struct CalibrateOutput<'a> {
    #[serde(flatten)]
    found: &'a Calibration,
    /// None without `--output`.
    written: Option<&'a RewriteOutput>,
}

impl Calibrate {
    pub(crate) fn run(&self, console: &Console) -> Result<(), Failure> {
        let inputs: Vec<_> = [&self.file].into_iter().chain(&self.data).chain(&self.scenario).collect();
        let read: Vec<_> = inputs.iter().map(|path| Some(path.as_path())).collect();
        let outputs = outputs(&self.outputs, &read, None);
        if let Some(path) = &self.output {
            check_output(&outputs, path, Kind::Vademecum)?;
        }
        let scenarios =
            self.scenario.iter().map(|path| Scenario::read(path)).collect::<Result<Vec<_>, _>>()?;
        let bytes = read_file(&self.file)?;
        let mut memory = vec![];
        let file = usable_bytes(&self.file, &bytes, |_| true, self.limit, &mut memory)?;
        let about = |failure: Failure| failure.about(&self.file);
        let tables = measurements(&self.data, &scenarios, &self.input).map_err(Failure::from)?;
        let options = CalibrateOptions {
            fit: self.fit.clone(),
            settings: self.set.clone(),
            noise: Noise {
                share: self.noise,
                over_all: self.noise_over == Over::All,
                model: self.model_error,
            },
            time_step: self.time_step,
        };
        let found = calibrate(&file, &tables, &options, console).map_err(|error| about(error.into()))?;
        let fitted = at_values(&file, &found.values, None).map_err(|error| about(error.into()))?;
        console.clear();
        let mut written = None;
        if let (Some(path), Some(body)) = (&self.output, fitted) {
            written = Some(write_file(&outputs, path, &body.bytes, bytes.len())?);
        }
        if self.json {
            print_json(&CalibrateOutput { found: &found, written: written.as_ref() });
        } else {
            print(&found);
            if let Some(written) = written {
                written.print(false);
            }
        }
        Ok(())
    }
}

/// A number in six digits.
fn number(x: f64) -> String {
    if (1e-3..1e4).contains(&x.abs()) { format!("{x:.6}") } else { format!("{x:.5e}") }
}

fn print(found: &Calibration) {
    let width = found.estimates.iter().map(|own| own.name.chars().count()).max().unwrap_or(0).max(9);
    println!("{:<width$}      estimate  95 % interval               range", "parameter");
    for Estimate { name, unit, value, interval, range: [lower, upper], .. } in &found.estimates {
        let interval = match interval {
            Some([low, high]) => format!("{} to {}", number(*low), number(*high)),
            None => "at the bound of its range".into(),
        };
        let range = format!("{lower} to {upper} {unit}");
        println!("{name:<width$}  {:>12}  {interval:<26}  {}", number(*value), range.trim_end());
    }
    if found.estimates.len() > 1 {
        println!("\ncorrelation");
        for (own, row) in found.estimates.iter().zip(&found.correlation) {
            let row: Vec<String> = row.iter().map(|number| format!("{number:>6.2}")).collect();
            println!("{:<width$}  {}", own.name, row.join(" "));
        }
    }
    println!("\nchi-squared / N = {:.4}: {}", found.chi_squared, found.meaning);
    for fit in &found.fits {
        println!("  {:.4} of {} numbers in {}", fit.chi_squared, fit.numbers, fit.table);
    }
    if found.model_error > 0.0 {
        println!("model error in the weights: {:.1e} (relative)", found.model_error);
    }
    let values: Vec<String> = found.singular_values.iter().map(|value| format!("{value:.2e}")).collect();
    println!("singular values: {}", values.join(" "));
    if found.undetermined.is_empty() {
        println!("the data determine every parameter");
    }
    for Direction { deviation, parameters, .. } in &found.undetermined {
        let shares: Vec<String> =
            parameters.iter().map(|own| format!("{:+.2} {}", own.share, own.name)).collect();
        println!(
            "not determined: {} (deviation {deviation:.2} of the range); fix one with `--set` and name the others \
             with `--fit`, or measure more",
            shares.join(" ")
        );
    }
    if !found.converged {
        println!("not converged after {} iterations: start closer with `--set`", found.iterations);
    }
}
