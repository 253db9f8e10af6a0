//! `vademecum verify`: the same scenario full order and through the file.

use std::path::{Path, PathBuf};

use serde::Serialize;
use vademecum_build::chapter::ChapterReport;
use vademecum_build::dynamics::FullOrder;
use vademecum_build::dynamics::TimedLoad;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::BuildError;
use vademecum_build::prepared::{Prepared, prepare};
use vademecum_build::progress::{Listener, Stopwatch};
use vademecum_build::response::reduced::spectral_radius;
use vademecum_eval::{Loads, Mapped, Scene, State};
use vademecum_format::{File, SectionKind};
use vademecum_rewrite::check;
use vademecum_study::StudyError;
use vademecum_study::compare::{CompareError, Comparison, Reduced, compare, coordinate_matrix};
use vademecum_study::scenario::Scenario;

use super::run::StructureArgument;
use super::{print_json, read_file, rewrite_failed, whole_file};
use crate::console::Console;
use crate::failure::{Cause, Failure};
use crate::player::{PlayOptions, Track, long_run, names, play};

/// Marches a scenario full order and through the file, and prints how far apart they are; or checks the file alone.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum verify body.vdm --problem body.toml --scenario push.toml --json
  vademecum verify body.vdm --file-only")]
pub struct Verify {
    /// The vademecum file.
    file: PathBuf,
    /// The problem it was built from.
    #[arg(long, required_unless_present = "file_only")]
    problem: Option<PathBuf>,
    /// The scenario file (TOML).
    #[arg(long, required_unless_present = "file_only")]
    scenario: Option<PathBuf>,
    /// Check the file alone: checksums, finite numbers, names and indices.
    #[arg(long, conflicts_with_all = ["problem", "scenario", "structure"])]
    file_only: bool,
    /// Structure of the step.
    #[arg(long, value_enum, default_value_t = StructureArgument::Auto)]
    structure: StructureArgument,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// What verification measured.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Steps marched.
    pub steps: usize,
    /// Free dofs.
    pub dofs: usize,
    /// Modes.
    pub modes: usize,
    /// Structure of the step.
    pub structure: &'static str,
    /// Relative L2 error over all dofs and steps, mass norm.
    pub trajectory_error: f64,
    /// The same of the projection of the full-order trajectory on the basis.
    pub projection_floor: f64,
    /// Error ÷ floor.
    pub floor_ratio: f64,
    /// Of the step as the evaluator marches it.
    pub spectral_radius: f64,
    /// Energy at the end over energy at release, less 1, through the file.
    pub energy_drift: f64,
    /// The same at full order: what the scheme itself takes.
    pub energy_drift_full_order: f64,
    /// Largest energy after release over the energy at release, through the file.
    pub energy_ratio: f64,
    /// Wall time of one full-order step \[s\].
    pub full_order_seconds_per_step: f64,
    /// Wall time of one step through the file \[s\].
    pub vademecum_seconds_per_step: f64,
}

/// A report and the series behind it.
pub struct Verified {
    /// The figures.
    pub report: Report,
    /// Step \[s\].
    pub time_step: f64,
    /// Names of the probes.
    pub probes: Vec<String>,
    /// Probe values, full order then file: shape (instants, probes), row-major.
    pub probe_series: [Vec<f64>; 2],
    /// Energies, full order then file.
    pub energy_series: [Vec<f64>; 2],
}

impl Verify {
    pub fn run(&self, console: &Console) -> Result<(), Failure> {
        match (&self.problem, &self.scenario) {
            (Some(problem), Some(scenario)) => self.march(problem, scenario, console),
            _ => self.check_file(),
        }
    }

    /// `--file-only`.
    fn check_file(&self) -> Result<(), Failure> {
        let checked = check(&read_file(&self.file)?).map_err(|error| rewrite_failed(&self.file, error))?;
        if self.json {
            print_json(&checked);
            return Ok(());
        }
        println!(
            "{}: sound; {} bytes, {} sections, {} numbers, all finite",
            self.file.display(),
            checked.bytes,
            checked.sections,
            checked.numbers
        );
        if checked.unknown_sections > 0 {
            println!(
                "{} section(s) of a kind this program does not know were skipped",
                checked.unknown_sections
            );
        }
        Ok(())
    }

    fn march(&self, problem: &Path, scenario: &Path, console: &Console) -> Result<(), Failure> {
        let problem = Problem::read(problem)?;
        let scenario = Scenario::read(scenario)?;
        let mapped = Mapped::open(&self.file).map_err(|error| Failure::file(&self.file, error))?;
        let mut memory = vec![];
        let file = whole_file(&self.file, &mapped, &mut memory)?;
        let options = self.structure.options();
        let mut watch = Stopwatch::new(console);
        let prepared = prepare(&problem, &mut watch, console)?;
        let verified = verify(&self.file, &file, &options, &problem, &prepared, &scenario, console)?;
        console.clear();
        if self.json {
            print_json(&verified.report);
        } else {
            verified.report.print();
        }
        Ok(())
    }
}

/// Marches both and compares them.
pub fn verify(
    path: &Path,
    file: &File<'_>,
    options: &PlayOptions,
    problem: &Problem,
    prepared: &Prepared,
    scenario: &Scenario,
    console: &Console,
) -> Result<Verified, Failure> {
    let body = &prepared.body;
    let metadata = file.metadata();
    if metadata.mesh_hash != body.mesh_hash {
        let text = format!("{}: the file belongs to another mesh than {}", path.display(), problem.path);
        return Err(Failure::new(Cause::File, text).remedy("build the file again from this problem"));
    }
    let file_nodes = file_nodes(path, file, body)?;
    let track = Track::bind(path, file, scenario)?;
    let steps = scenario.steps(metadata.time_step);

    console.stage("step the file");
    let (mut coordinates, mut energy, mut probes) = (vec![], vec![], vec![]);
    let mut structure = "";
    let n_probes = metadata.n_probes as usize;
    play(path, file, options, &track, steps, |_, body| {
        let failed = |error| Failure::file(path, error);
        structure = body.structure();
        coordinates.extend_from_slice(body.zeta());
        energy.push(body.energy().map_err(failed)?);
        for probe in 0..n_probes {
            probes.push(body.probe(probe).map_err(failed)?);
        }
        Ok(())
    })?;
    let timing = long_run(path, file, options, &track, 100_000)?;
    let radius = step_radius(path, file, options)?;

    console.stage("march full order");
    let basis = free_basis(path, file, body, &file_nodes)?;
    let coordinates = coordinate_matrix(metadata.n_modes as usize, &coordinates);
    let pencil = body.model.pencil();
    let full =
        FullOrder::new(pencil, &prepared.symbolic, &prepared.scheme, metadata.time_step, prepared.rayleigh())
            .map_err(BuildError::from)?;
    let loads = full_order_loads(&track, body, &file_nodes, path, file)?;
    let rows = probe_rows(body);
    let reduced = Reduced { basis: basis.as_ref(), coordinates: coordinates.as_ref(), probes: &rows };
    let full = compare(body, &full, &loads, &reduced, console).map_err(|error| match error {
        CompareError::March(error) => Failure::from(StudyError::from(error)),
        dependent => Failure::file(path, dependent),
    })?;

    let release = ((track.release() / metadata.time_step).ceil() as usize).min(steps);
    let drift = |series: &[f64]| series[steps] / series[release] - 1.0;
    let largest = energy[release..].iter().copied().fold(0.0, f64::max);
    let report = Report {
        steps,
        dofs: body.n_dof(),
        modes: metadata.n_modes as usize,
        structure,
        trajectory_error: full.error.error,
        projection_floor: full.error.floor,
        floor_ratio: full.error.error / full.error.floor,
        spectral_radius: radius,
        energy_drift: drift(&energy),
        energy_drift_full_order: drift(&full.energy),
        energy_ratio: largest / energy[release],
        full_order_seconds_per_step: full.seconds_per_step,
        vademecum_seconds_per_step: timing.seconds_per_step,
    };
    let Comparison { energy: full_energy, probes: full_probes, .. } = full;
    Ok(Verified {
        report,
        time_step: metadata.time_step,
        probes: names(path, file, SectionKind::ProbeNames)?,
        probe_series: [full_probes, probes],
        energy_series: [full_energy, energy],
    })
}

/// Mesh node of each file node, by the ids in the file.
pub fn file_nodes(
    path: &Path,
    file: &File<'_>,
    body: &vademecum_build::prepared::Body,
) -> Result<Vec<u32>, Failure> {
    let mesh = body.model.mesh();
    let by_id: std::collections::HashMap<u64, u32> =
        mesh.node_ids.iter().enumerate().map(|(i, &id)| (id, i as u32)).collect();
    let section = file.section(SectionKind::NodeIds).ok_or_else(|| missing(path, SectionKind::NodeIds))?;
    let ids = section.u64s().map_err(|error| Failure::file(path, error))?;
    let node = |id: &[u8; 8]| {
        let id = u64::from_le_bytes(*id);
        let foreign =
            || Failure::new(Cause::File, format!("{}: node {id} is not in the mesh", path.display()));
        by_id.get(&id).copied().ok_or_else(foreign)
    };
    ids.iter().map(node).collect()
}

fn missing(path: &Path, kind: SectionKind) -> Failure {
    Failure::new(Cause::File, format!("{}: verification needs section {kind:?}", path.display()))
}

/// Rows of `B` over the free dofs of the model, from the file.
pub fn free_basis(
    path: &Path,
    file: &File<'_>,
    body: &vademecum_build::prepared::Body,
    file_nodes: &[u32],
) -> Result<vademecum_build::Matrix, Failure> {
    let r = file.metadata().n_modes as usize;
    let mut rows = vec![];
    for kind in [SectionKind::SurfaceBasis, SectionKind::InteriorBasis] {
        match file.section(kind) {
            Some(section) => {
                rows.extend(section.numbers().map_err(|error| Failure::file(path, error))?.iter())
            }
            None if rows.len() == 3 * r * file_nodes.len() => {}
            None => return Err(missing(path, kind)),
        }
    }
    let mut basis = vademecum_build::Matrix::zeros(body.n_dof(), r);
    for (place, &node) in file_nodes.iter().enumerate() {
        for component in 0..3 {
            if let Some(free) = body.model.dofs().free(3 * node as usize + component) {
                (0..r).for_each(|k| basis[(free as usize, k)] = rows[(3 * place + component) * r + k]);
            }
        }
    }
    Ok(basis)
}

/// The loads of a track as forces over the free dofs.
pub fn full_order_loads(
    track: &Track,
    body: &vademecum_build::prepared::Body,
    file_nodes: &[u32],
    path: &Path,
    file: &File<'_>,
) -> Result<Vec<TimedLoad>, Failure> {
    let contact = |(contact, _, when): &(vademecum_eval::Contact, _, _)| {
        let mut force = vec![0.0; body.n_dof()];
        let nodes = contact.nodes.map(|node| file_nodes[node as usize]);
        body.model.add_point_force(&nodes, &contact.weights, contact.force, &mut force);
        TimedLoad { column: 0, force, when: *when }
    };
    let mut loads: Vec<TimedLoad> = track.contacts.iter().map(contact).collect();
    let known = names(path, file, SectionKind::PatternNames)?;
    for &(index, amplitude, when) in &track.patterns {
        let pattern = body.patterns.iter().find(|(name, _)| *name == known[index]);
        let foreign = || {
            let text = format!("the problem has no load pattern `{}`, the file has", known[index]);
            Failure::new(Cause::Input, text)
        };
        let (_, force) = pattern.ok_or_else(foreign)?;
        loads.push(TimedLoad { column: 0, force: force.iter().map(|f| amplitude * f).collect(), when });
    }
    Ok(loads)
}

/// Each probe as weights on free dofs.
fn probe_rows(body: &vademecum_build::prepared::Body) -> Vec<Vec<(u32, f64)>> {
    let row = |probe: &vademecum_build::prepared::Probe| {
        let component = |c: usize| {
            let free = body.model.dofs().free(3 * probe.node as usize + c)?;
            Some((free, probe.direction[c]))
        };
        (0..3).filter_map(component).collect()
    };
    body.probes.iter().map(row).collect()
}

/// Spectral radius of the step as the evaluator marches it: its columns are the steps of unit states.
fn step_radius(path: &Path, file: &File<'_>, options: &PlayOptions) -> Result<f64, Failure> {
    let bind = |error| Failure::file(path, error);
    let failed = |error| Failure::file(path, error);
    if options.takes_chapter(file) {
        // Unit states are far off its axes; the build has linearised the step.
        let report = ChapterReport::of_file(file).map_err(|error| Failure::file(path, error))?;
        return Ok(report.map_or(f64::NAN, |report| report.structure.spectral_radius));
    }
    let options = &options.scene;
    let sizes = Scene::<f64>::sizes(file, options).map_err(bind)?;
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let (mut state_memory, mut load_memory) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let scene = Scene::bind(file, options, &mut memory, &mut work).map_err(bind)?;
    let mut state = State::new(&scene, &mut state_memory).map_err(bind)?;
    let loads = Loads::new(&scene, &mut load_memory).map_err(bind)?;
    let n = 3 * scene.n_modes();
    let mut map = vec![0.0; n * n];
    for j in 0..n {
        let mut unit = vec![0.0; n];
        unit[j] = 1.0;
        state.restore(&unit).map_err(failed)?;
        scene.step(&mut state, &loads).map_err(failed)?;
        state.save_into(&mut map[j * n..(j + 1) * n]).map_err(failed)?;
    }
    Ok(spectral_radius(n, &map))
}

impl Report {
    /// Prints the figures for people.
    pub fn print(&self) {
        println!(
            "{} steps, {} free dofs, {} modes, {} structure",
            self.steps, self.dofs, self.modes, self.structure
        );
        println!(
            "trajectory error       {:.3e}  (relative L2, mass norm, all dofs and steps)",
            self.trajectory_error
        );
        println!(
            "projection floor       {:.3e}  (error ÷ floor {:.4})",
            self.projection_floor, self.floor_ratio
        );
        println!("spectral radius        1 {:+.2e}", self.spectral_radius - 1.0);
        println!(
            "energy after release   {:+.3e}  (full order {:+.3e}); largest ÷ at release {:.9}",
            self.energy_drift, self.energy_drift_full_order, self.energy_ratio
        );
        println!(
            "seconds per step       {:.3e}  (full order {:.3e}, {:.0} times as long)",
            self.vademecum_seconds_per_step,
            self.full_order_seconds_per_step,
            self.full_order_seconds_per_step / self.vademecum_seconds_per_step
        );
    }
}
