//! `vademecum assemble`: bodies that were built apart, joined to one file.

use std::path::{Path, PathBuf};

use vademecum_assembly::{AssemblyFile, AssemblyReport};
use vademecum_build::progress::Listener;
use vademecum_build::store::Kind;

use crate::arguments::OutputArguments;
use crate::console::Console;
use crate::failure::Failure;
use crate::files::{check_output, outputs, write_bytes};
use crate::given::join;
use crate::print::print_json;

/// Joins vademecum files at their ports, and writes the joined body as one ordinary vademecum file.
#[derive(clap::Args)]
#[command(after_help = "Example:
  vademecum assemble tower.toml -o tower.vdm
  vademecum view tower.vdm
tower.toml:
  format = 1
  [[part]]
  name = \"plate\"
  file = \"plate.vdm\"
  [[part]]
  name = \"post\"
  file = \"post.vdm\"
  position = [0.15, 0.15, 0.04]
  [[joint]]
  kind = \"weld\"
  between = [\"post.foot\", \"plate.top\"]
Ports are named by `[[port]]` in the problem files of the parts.")]
pub(crate) struct Assemble {
    /// The assembly file (TOML).
    assembly: PathBuf,
    /// The file of the joined body.
    #[arg(short, long)]
    output: PathBuf,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    outputs: OutputArguments,
}

/// JSON output.
#[derive(serde::Serialize)]
struct AssembleOutput {
    file: String,
    bytes: usize,
    #[serde(flatten)]
    report: AssemblyReport,
}

impl Assemble {
    pub(crate) fn run(&self, console: &Console) -> Result<(), Failure> {
        let file = AssemblyFile::read(&self.assembly).map_err(vademecum_assembly::AssemblyError::from)?;
        let parts = file.inputs();
        let mut inputs: Vec<Option<&Path>> = vec![Some(&self.assembly)];
        inputs.extend(parts.iter().map(|part| Some(part.as_path())));
        let outputs = outputs(&self.outputs, &inputs, None);
        check_output(&outputs, &self.output, Kind::Vademecum)?;
        let joined = join(&file, &self.assembly)?;
        joined.report.notes.iter().for_each(|note| console.note(note));
        write_bytes(&outputs, &self.output, Kind::Vademecum, &joined.bytes)?;
        let output = AssembleOutput {
            file: self.output.display().to_string(),
            bytes: joined.bytes.len(),
            report: joined.report,
        };
        if self.json {
            print_json(&output);
        } else {
            output.print();
        }
        Ok(())
    }
}

impl AssembleOutput {
    fn print(&self) {
        let report = &self.report;
        println!(
            "wrote {}: {} bytes, {} modes, synthesis of {}",
            self.file, self.bytes, report.modes, report.synthesis
        );
        for part in &report.parts {
            let free = if part.free { ", free by itself" } else { "" };
            println!("part `{}`: {}, {} modes{free}", part.name, part.file, part.modes);
        }
        for joint in &report.joints {
            println!(
                "joint `{}`: {} and {}, {} rows, {:.1e} m apart",
                joint.name, joint.between[0], joint.between[1], joint.rows, joint.distance
            );
        }
        let frequencies: Vec<String> = report.frequencies_hz.iter().map(|hz| format!("{hz:.4}")).collect();
        println!("natural frequencies [Hz]: {}", frequencies.join(" "));
        if report.damping_coupling > 0.0 {
            let holds = match report.damping_coupled {
                true => "the file holds it",
                false => "the file has ratios alone",
            };
            println!(
                "damping couples modes: answers at natural frequencies change by up to {:.2e}; {holds}",
                report.damping_coupling
            );
        }
    }
}
