//! `vademecum init`: from a mesh to a problem file, and on to the moving body.

use std::path::{Path, PathBuf};

use vademecum_build::mesh::CELLS;
use vademecum_build::mesh_error::MeshEstimate;
use vademecum_build::store::Kind;
use vademecum_deck::{DeckError, FrequencyResponse, LeftOut, is_deck, read};
use vademecum_study::starter::{
    KnownParts, NamedMaterial, SMALLEST_PART, Starter, StarterError, StarterOptions, starter,
};

use crate::arguments::{DeckArguments, OutputArguments, positive};
use crate::console::Console;
use crate::failure::{Cause, Failure};
use crate::files::{check_output, outputs, write_bytes};
use crate::print::print_json;
use crate::words::{duration, hertz, percent, quantity};

/// Writes a problem file for a mesh or a surface: unit, support, material, time step and modes are proposed
/// and explained.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum init liver.vtu --material liver -o liver.toml
  vademecum init fork.msh --view                    build it and push it in the browser
  vademecum init part.stl --cells 40 --view         the surface is filled with tetrahedra
  vademecum init part.inp --scale 0.001             the mesh is in millimetres
  vademecum init frog.vtu --up z --hold bottom      it stands on its feet
Materials: steel, stainless, aluminium, titanium, brass, concrete, glass, wood, pla, abs, nylon, rubber,
silicone, foam, bone, liver. Keys of the problem file: `vademecum help problem`")]
pub(crate) struct Init {
    /// The mesh file, or a surface: STL, OBJ, PLY, OFF, GLB.
    mesh: PathBuf,
    /// The problem file to write [default: the mesh's name with `.toml`].
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Cells along the longest side of a surface, 4 to 400 [default: as many as its volume asks for].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(CELLS_ASKED))]
    cells: Option<u32>,
    /// Material of the body [default: steel, or rubber where no face is flat].
    #[arg(long, value_parser = NamedMaterial::find)]
    material: Option<NamedMaterial>,
    /// Metres in a unit of the mesh [default: 0.001 for a body of more than 20 units, else 1].
    #[arg(long, value_parser = positive, allow_negative_numbers = true)]
    scale: Option<f64>,
    /// Support: a group of the mesh, bottom, x_min, x_max, y_min, y_max, z_min, z_max, or none [default: a
    /// group that is named as a support, a flat face, or the bottom].
    #[arg(long, value_name = "PLACE")]
    hold: Option<String>,
    /// Axis that points up [default: guessed from the shape].
    #[arg(long)]
    up: Option<Axis>,
    /// Leave out parts that share no facet with the rest and have less than this share of the elements.
    #[arg(long, value_name = "SHARE", default_value_t = SMALLEST_PART, value_parser = share)]
    smallest_part: f64,
    /// Build the body and open it in the browser.
    #[arg(long)]
    view: bool,
    /// Print what was proposed as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    deck: DeckArguments,
    #[command(flatten)]
    outputs: OutputArguments,
}

/// The range of `--cells`, as clap takes it.
const CELLS_ASKED: std::ops::RangeInclusive<i64> = *CELLS.start() as i64..=*CELLS.end() as i64;

/// Parts of a deck that a problem file and a scenario take.
struct DeckParts {
    /// Metres in a unit of the deck.
    scale: f64,
    /// Scenario of its motion over time.
    scenario: Option<String>,
    frequency_response: Option<FrequencyResponse>,
    known: KnownParts,
}

/// A coordinate axis.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Axis {
    X,
    Y,
    Z,
}

/// A share of a whole.
fn share(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| (0.0..=1.0).contains(number));
    number.ok_or_else(|| format!("`{text}` is not a number from 0 to 1; expected one such as 0.01"))
}

impl Init {
    /// The command lines that follow.
    pub(crate) fn run(&self, console: &Console) -> Result<Vec<Vec<PathBuf>>, Failure> {
        let problem = self.output.clone().unwrap_or_else(|| self.mesh.with_extension("toml"));
        let outputs = outputs(&self.outputs, &[Some(&self.mesh)], None);
        let is_mesh = vademecum_build::store::is_same_place(&self.mesh, &problem);
        if problem.is_file() && !self.outputs.force && !is_mesh {
            return self.kept(problem);
        }
        check_output(&outputs, &problem, Kind::Own)?;
        let parts = if is_deck(&self.mesh) { self.parts_of_deck()? } else { None };
        let scale = parts.as_ref().map(|parts| parts.scale);
        let scenario = parts.as_ref().and_then(|parts| parts.scenario.clone());
        let response = parts.as_ref().and_then(|parts| parts.frequency_response.clone());
        let scenario = scenario.map(|text| (problem.with_extension("scenario.toml"), text));
        if let Some((path, _)) = &scenario {
            check_output(&outputs, path, Kind::Own)?;
        }
        let options = StarterOptions {
            material: self.material,
            scale: self.scale.or(scale),
            known: parts.map(|parts| parts.known),
            hold: self.hold.clone(),
            up: self.up.map(|axis| axis as usize),
            smallest_part: self.smallest_part,
            cells: self.cells,
            mesh_name: seen_from(&self.mesh, &problem).display().to_string(),
        };
        let proposed = starter(&self.mesh, &options, console)?;
        console.clear();
        write_bytes(&outputs, &problem, Kind::Own, proposed.text.as_bytes())?;
        if let Some((path, text)) = &scenario {
            write_bytes(&outputs, path, Kind::Own, text.as_bytes())?;
        }
        let lines = self.following(&problem);
        if self.json {
            print_json(&proposed);
        } else {
            let Starter { dofs, longest_side, support, frequency, time_step, modes, .. } = &proposed;
            let order = if proposed.raised { ", mid-side nodes added" } else { "" };
            let material = &proposed.material;
            println!(
                "body: {dofs} free dofs{order}, longest side {}, {material}",
                quantity(*longest_side, "m")
            );
            println!("support: {support}");
            println!(
                "first natural frequency {}; time step {}, {modes} modes",
                hertz(*frequency),
                duration(*time_step)
            );
            if let Some(estimate) = &proposed.linear_mesh_error {
                println!("{}", on_linear_elements(estimate, &proposed));
            }
            println!("wrote {}", problem.display());
            if let Some((path, _)) = &scenario {
                println!(
                    "wrote {}, the deck's motion over time: vademecum run {} --scenario {0}",
                    path.display(),
                    lines.1.display()
                );
            }
            if !self.view {
                println!("next: vademecum build {} -o {}", problem.display(), lines.1.display());
            }
            if let Some(FrequencyResponse { range: [first, last], pattern, probes }) = &response {
                let outs: String = probes.iter().map(|probe| format!(" --out {probe}")).collect();
                let outs = if outs.is_empty() { " --out POINT".into() } else { outs };
                println!(
                    "the deck's answer to harmonic loads: vademecum frf {} --in \"{pattern}\"{outs} --range \
                     {first},{last}",
                    lines.1.display()
                );
            }
            if proposed.doubtful_scale {
                println!("{longest_side:.1} m long? If the mesh is in millimetres, add --scale 0.001");
            }
        }
        Ok(if self.view { lines.0 } else { vec![] })
    }

    /// Parts of a deck; none of one that is a mesh alone.
    fn parts_of_deck(&self) -> Result<Option<DeckParts>, Failure> {
        let deck = match read(&self.mesh, &self.deck.options()) {
            Err(DeckError::NoMaterial { .. }) => return Ok(None),
            // The mesh may do without what the deck has beside the solids.
            Err(DeckError::Structural(fault) | DeckError::Card(fault)) => {
                eprintln!("note: {fault}");
                eprintln!("note: the deck is taken as a mesh alone");
                return Ok(None);
            }
            other => other?,
        };
        let parts = deck.problem_parts(self.material.map(|material| material.density))?;
        let mut comments =
            vec![format!("From the deck: dialect of {}, units {}", deck.program, deck.units.words())];
        let left = deck
            .left_out
            .iter()
            // Dashpots do not act in answers at full order, and are tables here.
            .filter(|left| !left.in_problem)
            .map(|LeftOut { card, line, meaning, .. }| format!("not taken: line {line}, {card}: {meaning}"));
        comments.extend(left);
        comments.extend(parts.missing.iter().map(|words| format!("not in this file: {words}")));
        comments.iter().for_each(|line| eprintln!("note: {line}"));
        let (scale, scenario) = (parts.scale, parts.scenario);
        let frequency_response = parts.frequency_response;
        let known = KnownParts {
            own_units: parts.own_units,
            materials: parts.materials,
            attachments: parts.attachments,
            patterns: parts.patterns,
            damping: parts.damping,
            probes: parts.probes,
            time_step: parts.time_step,
            modes: parts.modes,
            material_words: parts.material_words,
            supports: parts.supports,
            support_words: parts.support_words,
            comments,
        };
        Ok(Some(DeckParts { scale, scenario, frequency_response, known }))
    }

    /// A problem file that exists may have been edited: it is never replaced unasked, and `--view` builds it.
    fn kept(&self, problem: PathBuf) -> Result<Vec<Vec<PathBuf>>, Failure> {
        // Faults of the mesh come first.
        vademecum_build::mesh::read_without(&self.mesh, self.smallest_part)?;
        let text = format!("{}: exists; kept, since you may have edited it", problem.display());
        if self.view {
            eprintln!("note: {text}; `--force` proposes it anew");
            return Ok(self.following(&problem).0);
        }
        let build =
            format!("{text}: `vademecum build {}`, or `--force` to propose it anew", problem.display());
        Err(Failure::new(Cause::Usage, build))
    }

    /// The command lines that build and show the body, and the file between them.
    fn following(&self, problem: &Path) -> (Vec<Vec<PathBuf>>, PathBuf) {
        let file = problem.with_extension("vdm");
        let build = vec!["vademecum".into(), "build".into(), problem.into(), "-o".into(), file.clone()];
        (vec![build, vec!["vademecum".into(), "view".into(), file.clone()]], file)
    }
}

/// The first frequency of linear elements beside that of quadratic ones, or its discretisation error, and
/// what the proposal does about it.
fn on_linear_elements(estimate: &MeshEstimate, proposed: &Starter) -> String {
    let known = match estimate {
        MeshEstimate::Known(error) => error.frequencies.first().ok_or("no frequency"),
        MeshEstimate::Unknown { reason } => Err(reason.as_str()),
    };
    match known {
        Ok(first) if proposed.raised => format!(
            "first frequency {} on linear elements, {} above that: `order = \"quadratic\"` was written",
            hertz(first.mesh),
            percent(first.mesh / proposed.frequency - 1.0)
        ),
        Ok(first) => format!(
            "first frequency {} on linear elements, about {} too high: `order = \"quadratic\"` in `[mesh]` takes \
             most of it out",
            hertz(first.mesh),
            percent(first.error)
        ),
        Err(reason) => format!("mesh error on linear elements: not estimated: {reason}"),
    }
}

/// A path as a file at `from` names it: relative where both lie in one folder, whole otherwise.
fn seen_from(path: &Path, from: &Path) -> PathBuf {
    let folder = |path: &Path| {
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
        std::fs::canonicalize(parent.unwrap_or(Path::new(".")))
    };
    match (folder(path), folder(from), path.file_name()) {
        (Ok(a), Ok(b), Some(name)) if a == b => name.into(),
        (Ok(a), _, Some(name)) => a.join(name),
        _ => path.to_path_buf(),
    }
}

impl From<StarterError> for Failure {
    fn from(error: StarterError) -> Self {
        match error {
            StarterError::Mesh(error) => error.into(),
            StarterError::Draft(error) => error.into(),
            StarterError::Study(error) => error.into(),
            StarterError::Hold(error) => Self::new(Cause::Usage, error),
            error @ StarterError::Parts { .. } => Self::new(Cause::Mesh, error).remedy(
                "merge the parts or keep one of them in the mesher; `--smallest-part SHARE` leaves out larger parts",
            ),
        }
    }
}
