//! `vademecum modes`: the lowest natural frequencies of a problem.

use std::path::PathBuf;

use serde::Serialize;
use vademecum_build::dynamics::{lowest_modes, numerical_damping};
use vademecum_build::input::Problem;
use vademecum_build::pipeline::BuildError;
use vademecum_build::prepared::prepare;
use vademecum_build::progress::{Listener, Stopwatch};

use super::print_json;
use crate::console::Console;
use crate::failure::Failure;

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

#[derive(Serialize)]
struct Report {
    dofs: usize,
    frequencies_hz: Vec<f64>,
    residuals: Vec<f64>,
    material_damping: Vec<f64>,
    scheme_damping: Vec<Option<f64>>,
    period_elongation: Vec<Option<f64>>,
}

impl Modes {
    pub fn run(&self, console: &Console) -> Result<(), Failure> {
        let problem = Problem::read(&self.problem)?;
        let mut watch = Stopwatch::new(console);
        let prepared = prepare(&problem, &mut watch, console)?;
        console.stage("natural modes");
        let pencil = prepared.body.model.pencil();
        let modes = lowest_modes(pencil, &prepared.symbolic, self.count).map_err(BuildError::from)?;
        console.clear();
        let frequencies_hz = modes.frequencies_hz();
        let material_damping: Vec<f64> =
            frequencies_hz.iter().map(|&f| prepared.rayleigh().ratio(f)).collect();
        let scheme = |(&value, &ratio): (&f64, &f64)| {
            numerical_damping(&prepared.scheme, value.sqrt() * problem.time.step, ratio)
        };
        let numerical: Vec<_> = modes.eigenvalues.iter().zip(&material_damping).map(scheme).collect();
        let report = Report {
            dofs: pencil.n_dof(),
            scheme_damping: numerical
                .iter()
                .zip(&material_damping)
                .map(|(n, m)| n.ratio.map(|r| r - m))
                .collect(),
            period_elongation: numerical.iter().map(|n| n.period_elongation).collect(),
            frequencies_hz,
            residuals: modes.residuals,
            material_damping,
        };
        if self.json {
            print_json(&report);
        } else {
            report.print();
        }
        Ok(())
    }
}

impl Report {
    fn print(&self) {
        println!(
            "{} free dofs\n\nmode  frequency [Hz]  damping: material  scheme     period     residual",
            self.dofs
        );
        for (k, frequency) in self.frequencies_hz.iter().enumerate() {
            let scheme = self.scheme_damping[k].map_or("over".into(), |d| format!("{d:.2e}"));
            let period = self.period_elongation[k].map_or("-".into(), |p| format!("{p:+.2e}"));
            println!(
                "{:>4}  {frequency:>14.6}  {:>17.3e}  {scheme:>9}  {period:>9}  {:>9.1e}",
                k + 1,
                self.material_damping[k],
                self.residuals[k]
            );
        }
    }
}
