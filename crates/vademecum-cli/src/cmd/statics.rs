//! `vademecum static`: the static steps of a deck at full order.

use std::path::PathBuf;

use vademecum_build::progress::Listener;
use vademecum_build::store::Kind;
use vademecum_deck::{Deck, FullOrder, LeftOut, StaticAnswer, read};

use crate::arguments::{DeckArguments, OutputArguments};
use crate::console::Console;
use crate::failure::Failure;
use crate::files::{outputs, write_fields};
use crate::print::{print_json, print_left_out};

/// Answers the static steps of a deck of Abaqus, CalculiX, Nastran or Ansys at full order: largest
/// displacement, reactions and strain energy, in the deck's own units.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum static bracket.inp
  vademecum static bracket.inp --json
  vademecum static bracket.inp --vtu bracket.vtu      displacements of every step, for ParaView
  vademecum static bracket.inp --dialect abaqus       C3D8 as Abaqus means it
Every card that is not taken is listed with its line and the consequence for the result.")]
pub(crate) struct Static {
    /// The deck.
    model: PathBuf,
    /// Write the displacements here (VTU), a field for each step.
    #[arg(long, value_name = "FILE.vtu")]
    vtu: Option<PathBuf>,
    #[command(flatten)]
    deck: DeckArguments,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    outputs: OutputArguments,
}

/// JSON output.
#[derive(serde::Serialize)]
struct StaticOutput<'a> {
    /// Program whose meaning the names of the deck have.
    program: &'a str,
    /// Units of the deck; none if nothing tells.
    units: Option<&'static str>,
    steps: Vec<StepOutput<'a>>,
    /// Cards that were not taken.
    left_out: &'a [LeftOut],
    /// Remarks on the mesh and the deck.
    notes: &'a [String],
}

/// A step.
#[derive(serde::Serialize)]
struct StepOutput<'a> {
    name: &'a str,
    /// Length of the largest displacement.
    largest_displacement: f64,
    /// Its node, as the deck numbers it.
    node: u64,
    /// Displacement there.
    displacement: [f64; 3],
    /// Sum of the forces of the supports.
    reaction_sum: [f64; 3],
    strain_energy: f64,
    /// Free dofs.
    dofs: usize,
    /// Forces that are not in balance, relative.
    residual: f64,
}

impl<'a> StepOutput<'a> {
    fn of(deck: &Deck, answer: &'a StaticAnswer) -> Self {
        let displacement = answer.displacement.get(answer.node as usize).copied().unwrap_or_default();
        Self {
            name: &answer.step,
            largest_displacement: answer.largest_displacement(),
            node: deck.id(answer.node),
            displacement,
            reaction_sum: answer.reaction_sum,
            strain_energy: answer.strain_energy,
            dofs: answer.dofs,
            residual: answer.residual,
        }
    }
}

impl Static {
    pub(crate) fn run(&self, console: &Console) -> Result<(), Failure> {
        let outputs = outputs(&self.outputs, &[Some(&self.model)], None);
        let written = self.vtu.iter().map(|path| (path.clone(), Kind::Vtu));
        outputs.check(&written.collect::<Vec<_>>())?;
        console.stage("read the deck");
        let deck = read(&self.model, &self.deck.options())?;
        console.stage("static steps");
        let answers = FullOrder::new(&deck).static_answers()?;
        if let Some(path) = &self.vtu {
            let mesh = &deck.mesh;
            let names: Vec<String> = answers.iter().map(|answer| format!("step {}", answer.step)).collect();
            let of_mesh =
                |answer: &'_ StaticAnswer| answer.displacement[..mesh.nodes.len()].as_flattened().to_vec();
            let fields: Vec<Vec<f64>> = answers.iter().map(of_mesh).collect();
            write_fields(&outputs, path, mesh, &names, &fields)?;
        }
        console.clear();
        let steps: Vec<StepOutput<'_>> = answers.iter().map(|answer| StepOutput::of(&deck, answer)).collect();
        if self.json {
            print_json(&StaticOutput {
                program: &deck.program,
                units: deck.units.system.map(|system| system.name()),
                steps,
                left_out: &deck.left_out,
                notes: &deck.notes,
            });
        } else {
            print(&deck, &steps);
            self.vtu.iter().for_each(|path| println!("wrote {}", path.display()));
        }
        Ok(())
    }
}

fn print(deck: &Deck, steps: &[StepOutput<'_>]) {
    print_left_out(deck);
    for step in steps {
        let [u, v, w] = step.displacement;
        let [x, y, z] = step.reaction_sum;
        println!("\nstep {}: {} free dofs, forces in balance to {:.0e}", step.name, step.dofs, step.residual);
        println!(
            "  largest displacement  {:.7e} at node {} ({u:.6e}, {v:.6e}, {w:.6e})",
            step.largest_displacement, step.node
        );
        println!("  sum of the reactions  ({x:.6e}, {y:.6e}, {z:.6e})");
        println!("  strain energy         {:.6e}", step.strain_energy);
    }
}
