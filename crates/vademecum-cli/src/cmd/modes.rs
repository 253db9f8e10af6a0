//! `vademecum modes`: the lowest natural frequencies of a problem.

use std::path::{Path, PathBuf};

use vademecum_build::input::Problem;
use vademecum_build::mesh_error::DiscRequest;
use vademecum_build::progress::Listener;
use vademecum_build::store::Kind;
use vademecum_deck::{FullOrder, LeftOut, System, is_deck, read};
use vademecum_study::StudyError;
use vademecum_study::modes::{COUNT, NaturalModes, Shapes, natural_modes};
use vademecum_study::parameters::ParameterValue;
use vademecum_study::uff::{Matched, is_universal};

use crate::arguments::{DeckArguments, OutputArguments, positive, setting};
use crate::console::Console;
use crate::failure::{Cause, Failure};
use crate::files::{outputs, write_fields};
use crate::mesh_error;
use crate::print::{print_json, print_left_out};

/// Prints the lowest natural frequencies of a problem, the damping of each mode, and how much of the body
/// moves with it.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum modes beam.toml --count 12 --json
  vademecum modes beam.toml --mesh-error              frequencies without discretisation error, estimated
  vademecum modes beam.toml --shapes modes.vtu        every mode as a field, for ParaView
  vademecum modes beam.toml --assurance measured.npy  modal assurance against the modes of another program
  vademecum modes beam.toml --assurance measured.uff  the same against modes that were measured
  vademecum modes beam.toml --set \"tip stiffness=1.5\"   a live parameter at another value
  vademecum modes bracket.inp                         a deck as it is, in its own units
The effective mass of a mode is the share of the free mass that a shaken support feels in it, along x, y, z.")]
pub(crate) struct Modes {
    /// The problem file (TOML), or a deck of Abaqus, CalculiX, Nastran or Ansys.
    problem: PathBuf,
    #[command(flatten)]
    deck: DeckArguments,
    /// Number of modes [default: 12, or as many as there are].
    #[arg(long)]
    count: Option<usize>,
    /// Write the shapes here (VTU); the largest displacement of each is 1.
    #[arg(long, value_name = "FILE.vtu")]
    shapes: Option<PathBuf>,
    /// Modes to compare with: a universal file (UFF) with nodes and modes, or a NumPy matrix, three rows for
    /// each node of the mesh, a column for each mode.
    #[arg(long, value_name = "FILE")]
    assurance: Option<PathBuf>,
    /// Estimate the discretisation error: of the lowest six frequencies, and of the displacement under a
    /// traction on a disc.
    #[arg(long)]
    mesh_error: bool,
    /// Radius of that disc in m; three mean edges if absent. It lies at the loadable node of largest
    /// compliance.
    #[arg(long, value_name = "R", requires = "mesh_error", value_parser = positive, allow_negative_numbers = true)]
    disc: Option<f64>,
    /// Set a live parameter of the problem, by its name; may be given several times.
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting, conflicts_with = "mesh_error")]
    set: Vec<ParameterValue>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    outputs: OutputArguments,
}

/// JSON output.
#[derive(serde::Serialize)]
struct ModesOutput {
    #[serde(flatten)]
    modes: NaturalModes,
    /// Modal assurance, a row for each mode; none without `--assurance`.
    assurance: Option<Vec<Vec<f64>>>,
}

impl Modes {
    pub(crate) fn run(&self, console: &Console) -> Result<(), Failure> {
        if is_deck(&self.problem) {
            return self.run_deck(console);
        }
        if self.deck.given() {
            let error = "`--dialect` and `--units` belong to a deck; the problem file has its own keys";
            return Err(Failure::new(Cause::Usage, error));
        }
        let problem = Problem::read(&self.problem)?;
        let outputs =
            outputs(&self.outputs, &[Some(&self.problem), self.assurance.as_deref()], Some(&problem));
        let written = self.shapes.iter().map(|path| (path.clone(), Kind::Vtu));
        outputs.check(&written.collect::<Vec<_>>())?;
        let (modes, shapes) = natural_modes(
            &problem,
            self.count,
            self.mesh_error.then_some(DiscRequest::Radius(self.disc)),
            &self.set,
            console,
        )?;
        let compared = self.assurance.as_deref().map(|file| compared(file, &shapes)).transpose()?;
        let (assurance, measured) = compared.map_or((None, None), |(table, line)| (Some(table), line));
        if let Some(path) = &self.shapes {
            let names: Vec<String> = field_names(&modes.frequencies_hz);
            let fields = shapes.fields();
            write_fields(&outputs, path, shapes.mesh(), &names, &fields)?;
        }
        console.clear();
        if self.json {
            print_json(&ModesOutput { modes, assurance });
        } else {
            print(&modes);
            modes.mesh_error.iter().flat_map(mesh_error::lines).for_each(|line| println!("{line}"));
            assurance.iter().for_each(|table| print_assurance(table));
            measured.iter().for_each(|line| println!("{line}"));
            self.shapes.iter().for_each(|path| println!("wrote {}", path.display()));
        }
        Ok(())
    }
}

/// Modal assurance against a NumPy matrix or a universal file, and what was measured of the latter.
fn compared(path: &Path, shapes: &Shapes) -> Result<(Vec<Vec<f64>>, Option<String>), Failure> {
    if !is_universal(path) {
        return Ok((shapes.assurance(path)?, None));
    }
    let Matched { assurance, frequencies, nodes, distance } =
        Matched::new(path, shapes).map_err(StudyError::from)?;
    let listed: Vec<String> = frequencies.iter().map(|frequency| format!("{frequency:.3}")).collect();
    let line = format!(
        "{nodes} nodes with measured motion, at most {distance:.3e} m from their nodes of the mesh; measured modes: \
         {} Hz",
        listed.join(", ")
    );
    Ok((assurance, Some(line)))
}

/// JSON output of a deck.
#[derive(serde::Serialize)]
struct DeckModesOutput<'a> {
    program: &'a str,
    units: Option<&'static str>,
    dofs: usize,
    rigid_motions: usize,
    frequencies_hz: &'a [f64],
    residuals: &'a [f64],
    left_out: &'a [LeftOut],
    notes: &'a [String],
}

impl Modes {
    /// The natural frequencies of a deck as it is.
    fn run_deck(&self, console: &Console) -> Result<(), Failure> {
        if self.mesh_error || self.assurance.is_some() || !self.set.is_empty() {
            let error =
                "`--mesh-error`, `--assurance` and `--set` need a problem file; `vademecum init` writes one";
            return Err(Failure::new(Cause::Usage, error));
        }
        let outputs = outputs(&self.outputs, &[Some(&self.problem)], None);
        let written = self.shapes.iter().map(|path| (path.clone(), Kind::Vtu));
        outputs.check(&written.collect::<Vec<_>>())?;
        console.stage("read the deck");
        let deck = read(&self.problem, &self.deck.options())?;
        console.stage("natural modes");
        let modes = FullOrder::new(&deck).modes(self.count.unwrap_or(COUNT))?;
        if let Some(path) = &self.shapes {
            let mesh = &deck.mesh;
            let names: Vec<String> = field_names(&modes.frequencies_hz);
            let of_mesh = |shape: &Vec<[f64; 3]>| shape[..mesh.nodes.len()].as_flattened().to_vec();
            let fields: Vec<Vec<f64>> = modes.shapes.iter().map(of_mesh).collect();
            write_fields(&outputs, path, mesh, &names, &fields)?;
        }
        console.clear();
        if self.json {
            print_json(&DeckModesOutput {
                program: &deck.program,
                units: deck.units.system.map(|system| system.name()),
                dofs: modes.dofs,
                rigid_motions: modes.rigid_motions,
                frequencies_hz: &modes.frequencies_hz,
                residuals: &modes.residuals,
                left_out: &deck.left_out,
                notes: &deck.notes,
            });
            return Ok(());
        }
        print_left_out(&deck);
        if modes.rigid_motions > 0 {
            println!(
                "free body: {} rigid motions of no frequency, and these elastic modes",
                modes.rigid_motions
            );
        }
        let unit =
            if deck.units.system.is_some_and(|system| system != System::Own) { "Hz" } else { "1/time" };
        let heading = format!("frequency [{unit}]");
        println!("{} free dofs\n\nmode  {heading:>14}   residual", modes.dofs);
        for (k, (frequency, residual)) in modes.frequencies_hz.iter().zip(&modes.residuals).enumerate() {
            println!("{:>4}  {frequency:>14.6}  {residual:>9.1e}", k + 1);
        }
        self.shapes.iter().for_each(|path| println!("wrote {}", path.display()));
        Ok(())
    }
}

/// Names of the fields: number and frequency.
fn field_names(frequencies_hz: &[f64]) -> Vec<String> {
    let named = frequencies_hz.iter().enumerate();
    named.map(|(k, frequency)| format!("mode {} ({frequency:.4} Hz)", k + 1)).collect()
}

fn print_assurance(table: &[Vec<f64>]) {
    println!("\nmodal assurance; a row for each mode, a column for each mode of the other program");
    for (k, row) in table.iter().enumerate() {
        let row: Vec<String> = row.iter().map(|value| format!("{value:.3}")).collect();
        println!("{:>4}  {}", k + 1, row.join(" "));
    }
}

fn print(modes: &NaturalModes) {
    if modes.rigid_motions > 0 {
        println!("free body: {} rigid motions of no frequency, and these elastic modes", modes.rigid_motions);
    }
    // Exact steps neither damp a mode nor stretch its period.
    let said = |values: &[Option<f64>]| values.iter().any(|value| *value != Some(0.0));
    let scheme = said(&modes.scheme_damping) || said(&modes.period_elongation);
    let of_scheme = |text: String| if scheme { text } else { String::new() };
    println!(
        "{} free dofs\n\nmode  frequency [Hz]  damping ratio{}   residual  mass x, y, z [%]",
        modes.dofs,
        of_scheme(format!("  {:>9}  {:>9}", "scheme", "period"))
    );
    for (k, frequency) in modes.frequencies_hz.iter().enumerate() {
        let damping = modes.scheme_damping[k].map_or("over".into(), |d| format!("{d:.2e}"));
        let period = modes.period_elongation[k].map_or("-".into(), |p| format!("{p:+.2e}"));
        println!(
            "{:>4}  {frequency:>14.6}  {:>13.3e}{}  {:>9.1e}  {}",
            k + 1,
            modes.material_damping[k],
            of_scheme(format!("  {damping:>9}  {period:>9}")),
            modes.residuals[k],
            modes.effective_mass[k].map(|share| format!("{:5.1}", 100.0 * share)).join(" ")
        );
    }
    let total = |c: usize| 100.0 * modes.effective_mass.iter().map(|share| share[c]).sum::<f64>();
    let [x, y, z] = [total(0), total(1), total(2)];
    println!("\neffective mass of all these modes: {x:.1} % along x, {y:.1} % along y, {z:.1} % along z");
    let steps = 1.0 / (modes.time_step * modes.frequencies_hz[0]);
    print!("time step {:e} s: {steps:.1} steps in the first period", modes.time_step);
    if modes.proposed_time_step != modes.time_step {
        let proposed = 1.0 / (modes.proposed_time_step * modes.frequencies_hz[0]);
        print!("; {:e} s would be {proposed:.1}", modes.proposed_time_step);
    }
    println!();
}
