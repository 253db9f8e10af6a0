//! `vademecum export uff`: modes and frequency responses for programs of modal testing.

use std::path::PathBuf;

use vademecum_build::progress::Listener;
use vademecum_build::store::Kind;
use vademecum_study::StudyError;
use vademecum_study::frf::Channel;
use vademecum_study::parameters;
use vademecum_study::uff::{UffExport, UffRequest};

use crate::arguments::{GridArguments, Limit, OutputArguments, QuantityArgument, SetArguments, range};
use crate::console::Console;
use crate::failure::{CHANNEL, Cause, Failure};
use crate::files::{at_values, check_output, is_stepped, refuse_chapter, to_step, usable_file, write_bytes};
use crate::given::{Given, outputs_of};
use crate::print::print_json;

/// Writes modes and frequency responses of a file as a universal file (UFF), for programs of modal testing.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum export uff beam.vdm -o beam.uff                     nodes, lines and modes
  vademecum export uff beam.vdm --in 1,0.04,0.1,-z --out tip --out 0.5,0.04,0.1,z --range 1,500 -o beam.uff
Datasets: 164 (SI units), 15 (nodes of the surface), 82 (its edges), 55 (a mode each, mass-normalised), 58 (a
frequency response each). Points are taken at the nearest node, along x, -x, y, -y, z or -z; a probe or a load
pattern has node 0.")]
pub(crate) struct Uff {
    /// The vademecum file, or an assembly file (TOML), which is joined in memory.
    file: PathBuf,
    /// The universal file.
    #[arg(short, long)]
    output: PathBuf,
    /// Point and direction of a force, or a load pattern; may be given several times.
    #[arg(long = "in", value_name = "CHANNEL", value_parser = str::parse::<Channel>, allow_hyphen_values = true,
          requires = "outputs", requires = "range")]
    inputs: Vec<Channel>,
    /// Point and direction of an output, or a probe; may be given several times.
    #[arg(long = "out", value_name = "CHANNEL", value_parser = str::parse::<Channel>, allow_hyphen_values = true,
          requires = "inputs")]
    outputs: Vec<Channel>,
    /// First and last frequency in Hz.
    #[arg(long, value_name = "F0,F1", value_parser = range, requires = "inputs")]
    range: Option<[f64; 2]>,
    #[command(flatten)]
    grid: GridArguments,
    /// Quantity of the outputs.
    #[arg(long, value_enum, default_value_t = QuantityArgument::Displacement)]
    quantity: QuantityArgument,
    #[command(flatten)]
    at: SetArguments,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    force: OutputArguments,
    #[command(flatten)]
    limit: Limit,
}

/// Report of the export.
#[derive(serde::Serialize)]
struct UffOutput {
    file: String,
    bytes: usize,
    nodes: usize,
    modes: usize,
    functions: usize,
}

impl Uff {
    pub(crate) fn run(&self, console: &Console) -> Result<(), Failure> {
        let given = Given::look(&self.file)?;
        let outputs = outputs_of(&self.force, &given, &[Some(&self.file)]);
        check_output(&outputs, &self.output, Kind::Text)?;
        let mapped = given.open(&self.file, false, console)?;
        let mut memory = vec![];
        let file = usable_file(&self.file, &mapped, is_stepped, self.limit, &mut memory)?;
        refuse_chapter(&self.file, &file, "a universal file")?;
        let about = |error| match error {
            // All are of the command line.
            error @ (StudyError::NoChannel { .. } | StudyError::FarPoint { .. }) => {
                Failure::new(Cause::Usage, error).remedy(CHANNEL)
            }
            error @ StudyError::Uff(_) => Failure::new(Cause::Usage, error),
            error => Failure::from(error).about(&self.file),
        };
        let set_body = at_values(&file, &self.at.set, self.at.modes).map_err(about)?;
        let (file, settings) = to_step(file, &self.at.set, set_body.as_ref()).map_err(about)?;
        let mut options = vademecum_eval::SceneOptions::default();
        parameters::set(&mut options, file.metadata(), settings).map_err(about)?;
        console.stage("modes and responses");
        let grid = self.grid.frequencies(self.range, &file, &options).map_err(about)?;
        let request = UffRequest {
            inputs: self.inputs.clone(),
            outputs: self.outputs.clone(),
            frequencies: grid,
            quantity: self.quantity.quantity(),
        };
        let export = UffExport::new(&file, &options, &request).map_err(about)?;
        console.clear();
        export.notes.iter().for_each(|note| console.note(note));
        write_bytes(&outputs, &self.output, Kind::Text, export.text.as_bytes())?;
        let UffExport { text, nodes, modes, functions, .. } = &export;
        let (nodes, modes, functions) = (*nodes, *modes, *functions);
        let file = self.output.display().to_string();
        let exported = UffOutput { file, bytes: text.len(), nodes, modes, functions };
        if self.json {
            print_json(&exported);
        } else {
            println!("{}: {nodes} nodes, {modes} modes, {functions} frequency responses", exported.file);
        }
        Ok(())
    }
}
