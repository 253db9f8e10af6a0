//! `vademecum modes`: the lowest natural frequencies of a problem.

use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_study::modes::{NaturalModes, natural_modes};

use crate::console::Console;
use crate::failure::Failure;
use crate::print::print_json;

/// Prints the lowest natural frequencies of a problem and the damping each mode receives.
#[derive(clap::Args)]
#[command(after_help = "Example:
  vademecum modes beam.toml --count 12 --json")]
pub struct Modes {
    /// The problem file (TOML).
    problem: PathBuf,
    /// How many modes.
    #[arg(long, default_value_t = 12)]
    count: usize,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

impl Modes {
    pub fn run(&self, console: &Console) -> Result<(), Failure> {
        let problem = Problem::read(&self.problem)?;
        let modes = natural_modes(&problem, self.count, console)?;
        console.clear();
        if self.json {
            print_json(&modes);
        } else {
            print(&modes);
        }
        Ok(())
    }
}

fn print(modes: &NaturalModes) {
    println!(
        "{} free dofs\n\nmode  frequency [Hz]  damping: material  scheme     period     residual",
        modes.dofs
    );
    for (k, frequency) in modes.frequencies_hz.iter().enumerate() {
        let scheme = modes.scheme_damping[k].map_or("over".into(), |d| format!("{d:.2e}"));
        let period = modes.period_elongation[k].map_or("-".into(), |p| format!("{p:+.2e}"));
        println!(
            "{:>4}  {frequency:>14.6}  {:>17.3e}  {scheme:>9}  {period:>9}  {:>9.1e}",
            k + 1,
            modes.material_damping[k],
            modes.residuals[k]
        );
    }
    let steps = 1.0 / (modes.time_step * modes.frequencies_hz[0]);
    println!(
        "\ntime step {:e} s: {steps:.1} steps in the first period; {:e} s would be {:.1}",
        modes.time_step,
        modes.proposed_time_step,
        1.0 / (modes.proposed_time_step * modes.frequencies_hz[0])
    );
}
