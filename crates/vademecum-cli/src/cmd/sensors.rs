//! `vademecum sensors`: where a test should measure to tell the modes of a file apart.

use std::path::PathBuf;

use vademecum_build::progress::Listener;
use vademecum_study::StudyError;
use vademecum_study::parameters::{self, ParameterValue};
use vademecum_study::sensors::{Sensor, SensorPlan, SensorRequest, sensor_plan};

use crate::arguments::{Limit, setting};
use crate::console::Console;
use crate::failure::{Cause, Failure};
use crate::files::{at_values, is_stepped, refuse_chapter, to_step, usable_file};
use crate::given::Given;
use crate::print::print_json;

/// Proposes places of sensors that tell the lowest modes of a file apart, by effective independence.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum sensors beam.vdm --count 6 --modes 4
  vademecum sensors beam.vdm --count 6 --modes 3 --axis z --json
Candidates are the nodes of the surface along each axis. Effective independence is 1 for a sensor without
which a mode is lost, and near 0 for one whose reading follows from those of the others.")]
pub(crate) struct Sensors {
    /// The vademecum file, or an assembly file (TOML), which is joined in memory.
    file: PathBuf,
    /// Number of sensors, each along one axis; at least the number of modes.
    #[arg(long)]
    count: usize,
    /// Number of the lowest modes that are to be told apart.
    #[arg(long)]
    modes: usize,
    /// Axis that is measured; may be given several times [default: all three].
    #[arg(long, value_enum)]
    axis: Vec<AxisArgument>,
    /// Set a live parameter of the file, by its name; may be given several times.
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting)]
    set: Vec<ParameterValue>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    limit: Limit,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum AxisArgument {
    /// Along x.
    X,
    /// Along y.
    Y,
    /// Along z.
    Z,
}

impl Sensors {
    pub(crate) fn run(&self, console: &Console) -> Result<(), Failure> {
        let given = Given::look(&self.file)?;
        let mapped = given.open(&self.file, false, console)?;
        let mut memory = vec![];
        let file = usable_file(&self.file, &mapped, is_stepped, self.limit, &mut memory)?;
        refuse_chapter(&self.file, &file, "this command")?;
        let about = |error| match error {
            error @ StudyError::Sensors(_) => Failure::new(Cause::Usage, error),
            error => Failure::from(error).about(&self.file),
        };
        let set_body = at_values(&file, &self.set, None).map_err(about)?;
        let (file, settings) = to_step(file, &self.set, set_body.as_ref()).map_err(about)?;
        let mut options = vademecum_eval::SceneOptions::default();
        parameters::set(&mut options, file.metadata(), settings).map_err(about)?;
        let all = [AxisArgument::X, AxisArgument::Y, AxisArgument::Z];
        let asked = |axis: &AxisArgument| self.axis.is_empty() || self.axis.contains(axis);
        let axes = all.iter().enumerate().filter(|(_, axis)| asked(axis)).map(|(place, _)| place).collect();
        console.stage("effective independence");
        let request = SensorRequest { count: self.count, modes: self.modes, axes };
        let plan = sensor_plan(&file, &options, &request).map_err(about)?;
        console.clear();
        if self.json {
            print_json(&plan)
        } else {
            print(&plan)
        }
        Ok(())
    }
}

fn print(plan: &SensorPlan) {
    let SensorPlan { sensors, frequencies_hz, candidates, condition, largest_assurance } = plan;
    println!("      node  axis            x            y            z  independence");
    for Sensor { node, position: [x, y, z], axis, independence } in sensors {
        println!("{node:>10}  {axis:<4}  {x:>11.6}  {y:>11.6}  {z:>11.6}  {independence:>12.4}");
    }
    let listed: Vec<String> = frequencies_hz.iter().map(|frequency| format!("{frequency:.3}")).collect();
    println!("\nof {candidates} candidates, for the modes of {} Hz", listed.join(", "));
    println!(
        "at these places the modes have singular values in the ratio {condition:.3}, and a modal assurance of at most \
         {largest_assurance:.3} with each other"
    );
}
