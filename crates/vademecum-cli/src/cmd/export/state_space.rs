//! `vademecum export state-space`: the matrices of a file for control and for identification.

use std::path::PathBuf;

use vademecum_build::field::dense_market_into;
use vademecum_build::progress::Listener;
use vademecum_build::store::Kind;
use vademecum_study::StudyError;
use vademecum_study::frf::Channel;
use vademecum_study::parameters;
use vademecum_study::state_space::{OutputSignal, Signal, StateSpace, StateSpaceError, StateSpaceRequest};

use crate::arguments::{Limit, OutputArguments, SetArguments, StructureArgument, positive};
use crate::console::Console;
use crate::failure::Failure;
use crate::files::{at_values, is_stepped, to_step, usable_file, write_bytes};
use crate::given::{Given, outputs_of};
use crate::print::{json, print_json};

/// Writes the state-space model of a file: A, B, C, D, and the exact map of a step, for control and for
/// identification.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum export state-space beam.vdm --in 1,0.04,0.1,-z --out tip --out velocity:tip -o model
  vademecum export state-space tower.vdm --in base.ax --out acceleration:top --out reaction:foot.fx -o model
  vademecum export state-space beam.vdm --set damping=1e-4 --time-step 5e-4 -o model
An input is X,Y,Z,DIRECTION (m; x, -x, y, -y, z, -z, or three numbers), a force of 1 N, or the name of a load
pattern, base.ax of a base that moves among them, or of a probe at a loadable node. An output is a channel,
X,Y,Z,DIRECTION or the name of a probe or gauge, for its displacement; velocity:CHANNEL, acceleration:CHANNEL;
stress:X,Y,Z,xx (yy, zz, xy, yz, zx); reaction:SUPPORT or reaction:SUPPORT.fx (fy, fz, mx, my, mz).
What the files hold: formats/state-space-1.md. A controller made of them: docs/how-to/state-space.md")]
pub(crate) struct StateSpaceArguments {
    /// The vademecum file, or an assembly file (TOML), which is joined in memory.
    file: PathBuf,
    /// Folder for the files; made if missing.
    #[arg(short, long)]
    output: PathBuf,
    /// An input; may be given several times [default: all load patterns].
    #[arg(long = "in", value_name = "CHANNEL", value_parser = str::parse::<Channel>, allow_hyphen_values = true)]
    inputs: Vec<Channel>,
    /// An output; may be given several times [default: all probes and reactions].
    #[arg(long = "out", value_name = "OUTPUT", value_parser = str::parse::<OutputSignal>,
          allow_hyphen_values = true)]
    outputs: Vec<OutputSignal>,
    /// Structure of the step: the exact one; `exact` takes it where the file has a time scheme.
    #[arg(long, value_enum, default_value_t = StructureArgument::Auto)]
    structure: StructureArgument,
    /// Time step of the discrete map in s; the file's if absent.
    #[arg(long, value_parser = positive, allow_negative_numbers = true)]
    time_step: Option<f64>,
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
struct StateSpaceOutput<'a> {
    folder: String,
    files: Vec<String>,
    time_step: f64,
    states: usize,
    inputs: &'a [Signal],
    outputs: &'a [Signal],
}

/// Matrices, each a file of its own.
const MATRICES: [&str; 10] =
    ["A", "B", "C", "D", "Ad", "Bd_start", "Bd_end", "Bd_held", "Bd_linear", "Dd_linear"];
const ARCHIVE: &str = "state-space.npz";
const MATLAB: &str = "state-space.mat";
const DESCRIPTION: &str = "state-space.json";

impl StateSpaceArguments {
    pub(crate) fn run(&self, console: &Console) -> Result<(), Failure> {
        let given = Given::look(&self.file)?;
        let outputs = outputs_of(&self.force, &given, &[Some(&self.file)]);
        let markets: Vec<String> = MATRICES.map(|name| format!("{name}.mtx")).into();
        let own = [(ARCHIVE, Kind::Npz), (MATLAB, Kind::Mat), (DESCRIPTION, Kind::Json)];
        let files: Vec<(&str, Kind)> =
            own.into_iter().chain(markets.iter().map(|name| (&**name, Kind::Market))).collect();
        outputs.check_in(&self.output, &files)?;
        let mapped = given.open(&self.file, false, console)?;
        let mut memory = vec![];
        let file = usable_file(&self.file, &mapped, is_stepped, self.limit, &mut memory)?;
        let about = |error: StudyError| Failure::from(error).about(&self.file);
        let set_body = at_values(&file, &self.at.set, self.at.modes).map_err(about)?;
        let (file, settings) = to_step(file, &self.at.set, set_body.as_ref()).map_err(about)?;
        let played = self.structure.options();
        let mut options = played.scene;
        options.time_step = self.time_step;
        parameters::set(&mut options, file.metadata(), settings).map_err(about)?;
        if played.chapter {
            return Err(Failure::from(StateSpaceError::Chapter).about(&self.file));
        }
        console.stage("state-space model");
        let request = StateSpaceRequest { inputs: self.inputs.clone(), outputs: self.outputs.clone() };
        let model = StateSpace::new(&file, &options, &request)
            .map_err(|error| Failure::from(error).about(&self.file))?;
        console.clear();
        model.notes.iter().for_each(|note| console.note(note));
        for &[output, input] in &model.by_modes_alone {
            console.note(&format!(
                "`{}` under `{}` is by the modes alone: the file does not have their static remainder between two \
                 points of the surface; name a probe there in the problem file, or build it with `static_fields = true`",
                model.outputs[output].name, model.inputs[input].name
            ));
        }
        let values = match &set_body {
            Some(body) => body.values.clone(),
            None => parameters::values(&options, file.metadata()),
        };
        let metadata = file.metadata();
        let description = model.description(metadata.units, &values);
        outputs.make_folder(&self.output)?;
        let at = |name: &str| self.output.join(name);
        outputs.write(&at(ARCHIVE), Kind::Npz, |out| model.npz_into(out))?;
        outputs.write(&at(MATLAB), Kind::Mat, |out| model.mat_into(out))?;
        for (name, matrix) in model.dense() {
            if MATRICES.contains(&name) {
                let path = at(&format!("{name}.mtx"));
                outputs.write(&path, Kind::Market, |out| dense_market_into(out, &matrix, false))?;
            }
        }
        write_bytes(&outputs, &at(DESCRIPTION), Kind::Json, json(&description).as_bytes())?;
        let exported = StateSpaceOutput {
            folder: self.output.display().to_string(),
            files: files.iter().map(|(name, _)| (*name).to_string()).collect(),
            time_step: model.time_step,
            states: model.states.len(),
            inputs: &model.inputs,
            outputs: &model.outputs,
        };
        if self.json {
            print_json(&exported);
        } else {
            exported.print();
        }
        Ok(())
    }
}

impl StateSpaceOutput<'_> {
    fn print(&self) {
        let Self { folder, time_step, states, inputs, outputs, .. } = self;
        println!("{folder}: {states} states, step {time_step} s");
        for (side, signals) in [("input", inputs), ("output", outputs)] {
            for (number, Signal { name, unit }) in signals.iter().enumerate() {
                let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
                println!("{side} {}: {name}{unit}", number + 1);
            }
        }
    }
}
