//! `vademecum frf`: the response of a body to a harmonic force.

use std::fmt::Write as _;
use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_build::progress::Listener;
use vademecum_build::store::Kind;
use vademecum_study::StudyError;
use vademecum_study::frf::{
    Channel, FrequencyResponse, Peak, Quantity, ResponseError, ResponseRequest, compare_response,
    frequencies, frequency_response, polar,
};
use vademecum_study::parameters;

use crate::arguments::{GridArguments, Limit, OutputArguments, QuantityArgument, SetArguments, range};
use crate::console::Console;
use crate::failure::{CHANNEL, Cause, Failure};
use crate::files::{at_values, chart_kind, is_stepped, to_step, usable_file, write_chart};
use crate::given::{Given, outputs_of};
use crate::pictures::{Series, response_chart};
use crate::print::print_json;

/// Frequency response function (FRF) of points and probes to a harmonic force, in closed form.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum frf beam.vdm --in 1,0.04,0.1,-z --out tip --range 1,500 -o tip.csv --plot tip.svg
  vademecum frf beam.vdm --in gravity --out tip --out 0.5,0.04,0.1,0,0,1 --range 1,500 --quantity acceleration
  vademecum frf beam.vdm --in 1,0.04,0.1,-z --out tip --range 1,500 --problem beam.toml --compare 50 --json
A channel is X,Y,Z,DIRECTION (m; x, -x, y, -y, z, -z, or three numbers), or a name: of a probe, or behind
`--in` of a load pattern, too. The table has the real and the imaginary part of each output, for an input of
amplitude 1 (N, or the pattern once).")]
pub(crate) struct Frf {
    /// The vademecum file, or an assembly file (TOML), which is joined in memory.
    file: PathBuf,
    /// Point and direction of the force, a load pattern, or a probe of the problem on the loadable surface.
    #[arg(long = "in", value_name = "CHANNEL", value_parser = str::parse::<Channel>, allow_hyphen_values = true)]
    input: Channel,
    /// Point and direction of an output, or a probe; may be given several times.
    #[arg(long = "out", value_name = "CHANNEL", value_parser = str::parse::<Channel>, required = true,
          allow_hyphen_values = true)]
    outputs: Vec<Channel>,
    /// First and last frequency in Hz.
    #[arg(long, value_name = "F0,F1", value_parser = range)]
    range: [f64; 2],
    #[command(flatten)]
    grid: GridArguments,
    /// Quantity of the outputs.
    #[arg(long, value_enum, default_value_t = QuantityArgument::Displacement)]
    quantity: QuantityArgument,
    #[command(flatten)]
    at: SetArguments,
    /// Write the table here (CSV).
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Draw amplitude and phase here (SVG, or PDF by its name).
    #[arg(long)]
    plot: Option<PathBuf>,
    /// The problem the file was built from, to compare with.
    #[arg(long, requires = "compare")]
    problem: Option<PathBuf>,
    /// Compare with complex full-order solves at this number of frequencies of the range.
    #[arg(long, value_name = "COUNT", requires = "problem",
          value_parser = clap::value_parser!(u32).range(2..=100_000))]
    compare: Option<u32>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    force: OutputArguments,
    #[command(flatten)]
    limit: Limit,
}

/// JSON output.
#[derive(serde::Serialize)]
struct ResponseOutput {
    outputs: Vec<String>,
    quantity: Quantity,
    frequencies_hz: Vec<f64>,
    /// Real and imaginary part, one list for each output.
    values: Vec<Vec<[f64; 2]>>,
    highest_mode_hz: f64,
    /// None where a mode without damping lies in the range.
    peaks: Vec<Option<Peak>>,
    by_modes_alone: Vec<usize>,
    /// None without `--compare`.
    compared: Option<ResponseError>,
}

impl Frf {
    pub(crate) fn run(&self, console: &Console) -> Result<(), Failure> {
        let given = Given::look(&self.file)?;
        let outputs = outputs_of(&self.force, &given, &[Some(&self.file), self.problem.as_deref()]);
        let tables = self.output.iter().map(|path| (path.clone(), Kind::Csv));
        let written = tables.chain(self.plot.iter().map(|path| (path.clone(), chart_kind(path))));
        outputs.check(&written.collect::<Vec<_>>())?;
        let problem = self.problem.as_ref().map(|path| Problem::read(path)).transpose()?;
        let mapped = given.open(&self.file, false, console)?;
        let mut memory = vec![];
        let file = usable_file(&self.file, &mapped, is_stepped, self.limit, &mut memory)?;
        let mut options = vademecum_eval::SceneOptions::default();
        let about = |error| match error {
            // Both are of the command line.
            error @ (StudyError::NoChannel { .. } | StudyError::FarPoint { .. }) => {
                Failure::new(Cause::Usage, error).remedy(CHANNEL)
            }
            error => Failure::from(error).about(&self.file),
        };
        let set_body = at_values(&file, &self.at.set, self.at.modes).map_err(about)?;
        let (file, settings) = to_step(file, &self.at.set, set_body.as_ref()).map_err(about)?;
        parameters::set(&mut options, file.metadata(), settings).map_err(about)?;
        let quantity = self.quantity.quantity();
        let grid = self.grid.frequencies(Some(self.range), &file, &options).map_err(about)?;
        let mut question = ResponseRequest {
            input: self.input.clone(),
            outputs: self.outputs.clone(),
            frequencies: grid,
            quantity,
        };
        let found = frequency_response(&file, &options, &question).map_err(about)?;
        let unit = self.quantity.unit(found.by_pattern);
        let names: Vec<String> = self.outputs.iter().map(Channel::to_string).collect();
        found.notes.iter().for_each(|note| console.note(note));
        for &output in &found.by_modes_alone {
            console.note(&format!(
                "`{}` is by the modes alone: the file does not have their static remainder between two points of \
                 the surface; name a probe there in the problem file, or build it with `static_fields = true`",
                names[output]
            ));
        }
        if let Some(path) = &self.output {
            let table = table(&question.frequencies, &names, &found, unit);
            outputs.write(path, Kind::Csv, |out| out.write_all(table.as_bytes()))?;
        }
        if let Some(path) = &self.plot {
            let line = |values: Vec<f64>| question.frequencies.iter().copied().zip(values).collect();
            let (mut amplitudes, mut phases) = (vec![], vec![]);
            for (name, values) in names.iter().zip(&found.values) {
                let (amplitude, phase) = polar(values).unzip();
                amplitudes.push(Series { name, points: line(amplitude) });
                phases.push(Series { name, points: line(phase) });
            }
            let title = match found.by_pattern {
                true => format!("Response to the load pattern {}", self.input),
                false => format!("Response to a force of 1 N at {}", self.input),
            };
            let chart =
                response_chart(&title, &format!("amplitude [{unit}]"), self.grid.log, amplitudes, phases);
            write_chart(&outputs, path, chart)?;
        }
        let grid = question.frequencies.clone();
        let values = set_body.as_ref().map_or(&[][..], |body| &body.values);
        let compared = match (&problem, self.compare) {
            (Some(problem), Some(count)) => {
                question.frequencies = frequencies(self.range, count as usize, self.grid.log);
                Some(
                    compare_response(&file, &options, &question, (problem, values), console)
                        .map_err(about)?,
                )
            }
            _ => None,
        };
        console.clear();
        if self.json {
            let values = found.values.iter().map(|row| row.iter().map(|x| [x.re, x.im]).collect()).collect();
            let FrequencyResponse { highest_mode_hz, peaks, by_modes_alone, .. } = found;
            print_json(&ResponseOutput {
                outputs: names,
                quantity,
                frequencies_hz: grid,
                values,
                highest_mode_hz,
                peaks,
                by_modes_alone,
                compared,
            });
        } else {
            self.print(&names, &found, compared);
        }
        Ok(())
    }
}

impl Frf {
    fn print(&self, names: &[String], found: &FrequencyResponse, compared: Option<ResponseError>) {
        let unit = self.quantity.unit(found.by_pattern);
        println!("output                        largest amplitude          at");
        for (name, peak) in names.iter().zip(&found.peaks) {
            match peak {
                Some(Peak { amplitude, frequency_hz }) => {
                    println!("{name:<28}  {amplitude:>13.6e} {unit:<8}  {frequency_hz:.4} Hz");
                }
                None => println!("{name:<28}  none: a mode without damping lies in the range"),
            }
        }
        println!("\nhighest mode of the file: {:.2} Hz; good up to about half of it", found.highest_mode_hz);
        if let Some(error) = compared {
            println!(
                "against complex solves of the full order at {} frequencies: {:.2e} (root of the mean square), {:.2e} at \
                 worst; by the modes alone {:.2e} and {:.2e}",
                error.frequencies, error.rms, error.worst, error.rms_by_modes, error.worst_by_modes
            );
        }
        for path in [&self.output, &self.plot].into_iter().flatten() {
            println!("wrote {}", path.display());
        }
    }
}

/// Frequency, then real and imaginary part of each output.
fn table(frequencies: &[f64], names: &[String], found: &FrequencyResponse, unit: &str) -> String {
    let mut out = String::from("frequency_hz");
    for name in names {
        let _ = write!(out, ",re {name} [{unit}],im {name} [{unit}]");
    }
    out.push('\n');
    for (i, frequency) in frequencies.iter().enumerate() {
        let _ = write!(out, "{frequency}");
        for values in &found.values {
            let _ = write!(out, ",{:e},{:e}", values[i].re, values[i].im);
        }
        out.push('\n');
    }
    out
}
