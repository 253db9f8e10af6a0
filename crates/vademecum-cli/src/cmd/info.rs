//! `vademecum info`: everything a file says about itself.

use std::path::{Path, PathBuf};

use serde::Serialize;
use vademecum_build::certificate::StructureReport;
use vademecum_build::dynamics::ModeRow;
use vademecum_build::input::Problem;
use vademecum_build::mesh_error::RefinedValue;
use vademecum_build::parametric::RadiusSample;
use vademecum_build::report::ChapterReport;
use vademecum_chapter::report_of_file;
use vademecum_eval::RigidBody;
use vademecum_format::{Axis, Chapter, File, Parameter, PortKind, PortRange, Section, SectionKind};
use vademecum_rewrite::{Loss, RewriteError, TermReduction, check_coordinates, fewest_terms, read_losses};
use vademecum_study::FileError;
use vademecum_study::contents::{
    Bound, bound, damping_ratios, figures, lines, mesh_errors, mode_table, numbers,
};
use vademecum_study::live_errors::{CloserErrors, LiveErrors, PointErrors};
use vademecum_study::separation::{Enrichment, enrichment_history, radius_samples, repairs};

use crate::accuracy::Accuracy;
use crate::arguments::{Limit, rounding};
use crate::failure::Failure;
use crate::files::{open, usable_bytes};
use crate::mesh_error;
use crate::print::{figure, json, print_chapter, print_json, symmetry};
use crate::sha256::sha256;

/// Prints what a vademecum file holds.
#[derive(clap::Args)]
#[command(after_help = "Example:
  vademecum info body.vdm --json
  vademecum info body.vdm --terms-for 1e-3")]
pub(crate) struct Info {
    /// The vademecum file.
    file: PathBuf,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Print how many terms of the separated solution keep its maps within this relative error, such as 1e-3
    /// (reads all load rows).
    #[arg(long, value_name = "TOLERANCE", value_parser = rounding)]
    terms_for: Option<f64>,
    #[command(flatten)]
    limit: Limit,
}

/// JSON output of `info --json` for the bytes of a file. `path` is its name, for messages.
///
/// # Errors
/// [`Failure`]: bytes that are no vademecum file, or a damaged one.
pub fn contents_json(path: &Path, bytes: &[u8], limit: Limit) -> Result<String, Failure> {
    let info = Info { file: path.to_path_buf(), json: true, terms_for: None, limit };
    info.read(bytes).map(|(contents, _)| json(&contents))
}

/// Everything a file says about itself.
#[derive(Serialize)]
struct Contents {
    file_bytes: usize,
    sha256: String,
    format: String,
    program: String,
    units: String,
    mesh_hash: String,
    nodes: u32,
    surface_nodes: u32,
    loadable_nodes: u32,
    triangles: u32,
    modes: u32,
    scheme: String,
    stages: u8,
    time_step: f64,
    alpha: f64,
    beta: f64,
    /// Of each mode beside Rayleigh's damping, without what couples modes; none in a file without them.
    damping_ratios: Vec<f64>,
    /// Rows of dashpots that couple modes.
    damping_rows: u64,
    /// A row for each mode; none in a file that was stripped of it.
    mode_table: Vec<ModeRow>,
    structures: Vec<&'static str>,
    terms: u32,
    axes: Vec<AxisReport>,
    canonical: Option<CanonicalAxes>,
    parameters: Vec<ParameterReport>,
    /// Points of their box at which a parametric model was measured.
    parameter_points: Vec<PointErrors>,
    /// Its centre and the worst of these points, measured closer.
    parameter_witnesses: Vec<CloserErrors>,
    load_patterns: Vec<String>,
    probes: Vec<String>,
    /// None of a body with supports.
    free_body: Option<FreeReport>,
    /// Supports whose reactions the file gives.
    supports: Vec<SupportReport>,
    /// Patches and frames by which an assembly joins the body to others.
    ports: Vec<PortReport>,
    /// None of a file that answers each contact by itself.
    contact_patch: Option<PatchReport>,
    certificate: Certificates,
    enrichment_history: Vec<Enrichment>,
    /// With `--terms-for`.
    #[serde(skip_serializing_if = "Option::is_none")]
    fewest_terms: Option<TermReduction>,
    radius_samples: Vec<RadiusSample>,
    sections: Vec<SectionReport>,
    problem: String,
    /// First lines on its certificate.
    #[serde(skip)]
    accuracy: Vec<String>,
}

#[derive(Serialize)]
struct AxisReport {
    name: String,
    unit: String,
    role: String,
    kind: String,
    log: bool,
    lower: f64,
    upper: f64,
    points: u32,
}

#[derive(Serialize)]
struct ParameterReport {
    name: String,
    unit: String,
    role: String,
    log: bool,
    lower: f64,
    upper: f64,
    nominal: f64,
}

/// Live parameters: those of the metadata, and those of a parametric model.
fn parameters(file: &File<'_>) -> Vec<ParameterReport> {
    let live = file.live_parameters().ok().flatten();
    let of_model = live.iter().flat_map(|live| live.iter());
    let own = file.metadata().active_parameters().iter().copied();
    own.chain(of_model).map(|parameter| ParameterReport::from(&parameter)).collect()
}

impl From<&Axis<'_>> for AxisReport {
    fn from(axis: &Axis<'_>) -> Self {
        Self {
            name: axis.name.into(),
            unit: axis.unit.into(),
            role: axis.role.to_string(),
            kind: axis.kind.to_string(),
            log: axis.log,
            lower: axis.lower,
            upper: axis.upper,
            points: axis.n_points,
        }
    }
}

impl From<&Parameter<'_>> for ParameterReport {
    fn from(parameter: &Parameter<'_>) -> Self {
        Self {
            name: parameter.name.into(),
            unit: parameter.unit.into(),
            role: parameter.role.to_string(),
            log: parameter.log,
            lower: parameter.lower,
            upper: parameter.upper,
            nominal: parameter.nominal,
        }
    }
}

#[derive(Serialize)]
struct SupportReport {
    name: String,
    /// Reference point of its moment \[m\].
    point: [f64; 3],
}

#[derive(Serialize)]
struct Certificates {
    /// Worst values over the box of the parameters, of the block structure where there is one.
    terms: u32,
    map_error_rms: f64,
    map_error_max: f64,
    spectral_radius_max: f64,
    trajectory_error_max: f64,
    trajectory_floor_max: f64,
    energy_ratio_max: f64,
    /// Steps the tolerance of the problem is good for, an estimate: 0 where the march missed it or left its
    /// axes, `null` where nothing was seen beyond the floor, and of large displacements and live regions.
    good_for_steps: Option<f64>,
    /// Repairs by `build --repair`, in order; empty without any.
    repairs: Vec<String>,
    diagonal: Option<StructureReport>,
    block: Option<StructureReport>,
    canonical: Option<ChapterReport>,
    /// Truncation error of static responses; `null` if the file does not have it.
    bound: Option<Bound>,
    /// Discretisation error of the lowest frequencies; empty if the file does not have it.
    mesh_error: Vec<RefinedValue>,
}

impl Certificates {
    /// Certificates of a file; `strain` is true of a file of large displacements.
    fn read(file: &File<'_>, strain: bool) -> Result<Self, FileError> {
        let m = file.metadata();
        let figures = figures(file)?;
        let diagonal = StructureReport::new(&m.certificate.diagonal, &figures.diagonal);
        let block = StructureReport::new(&m.certificate.block, &figures.block);
        let canonical = report_of_file(file)?;
        let worst = match &canonical {
            Some(report) => &report.structure,
            None if m.block => &block,
            None => &diagonal,
        };
        let most_terms = canonical.iter().flat_map(|report| &report.stages).map(|stage| stage.terms).max();
        let is_parametric = file.section(SectionKind::LiveStiffness).is_some();
        let left_its_axes = canonical.as_ref().is_some_and(|report| report.left_at.is_some());
        Ok(Self {
            terms: most_terms.map_or(m.n_terms, |terms| terms as u32),
            map_error_rms: worst.map_error_rms,
            map_error_max: worst.map_error_max,
            spectral_radius_max: worst.spectral_radius,
            trajectory_error_max: worst.trajectory_error,
            trajectory_floor_max: worst.projection_floor,
            energy_ratio_max: worst.energy_ratio,
            // The estimate is of a linear motion.
            good_for_steps: match left_its_axes {
                // Neither do modes of a box come near their projection error.
                _ if strain || is_parametric => None,
                true => Some(0.0),
                false => good_for_steps(m.problem, worst),
            },
            repairs: repairs(file)?,
            diagonal: m.diagonal.then_some(diagonal),
            block: m.block.then_some(block),
            canonical,
            bound: bound(file)?,
            mesh_error: mesh_errors(file)?,
        })
    }

    fn print(&self, is_large: bool) {
        for (name, certificate) in [("diagonal", &self.diagonal), ("block", &self.block)] {
            let Some(c) = certificate else { continue };
            if is_large {
                println!(
                    "test runs, strain: largest error {:.3e}, projection error {:.3e} over {} steps",
                    c.trajectory_error, c.projection_floor, c.steps
                );
                continue;
            }
            // Files of early versions do not know all of them.
            println!(
                "test runs, {name}: largest error {}, projection error {}, ratio {} over {} steps; spectral radius {}; \
                 energy ratio {}{}",
                figure(c.trajectory_error, |x| format!("{x:.3e}")),
                figure(c.projection_floor, |x| format!("{x:.3e}")),
                figure(c.floor_ratio, |x| format!("{x:.3}")),
                figure(c.steps, |x| x.to_string()),
                figure(c.spectral_radius, |x| format!("1{:+.1e}", x - 1.0)),
                figure(c.energy_ratio, |x| format!("{x:.9}")),
                symmetry(c)
            );
        }
        if let Some(c) = &self.canonical {
            println!("test runs, canonical:");
            print_chapter(c);
        }
        if let Some(steps) = self.good_for_steps {
            println!("{}", endurance(steps));
        }
        if !self.mesh_error.is_empty() {
            println!("mesh error of the lowest frequencies, estimated:");
            mesh_error::frequency_lines(&self.mesh_error).iter().for_each(|line| println!("{line}"));
        }
        self.repairs.iter().for_each(|done| println!("repaired: {done}"));
    }
}

/// A port.
#[derive(serde::Serialize)]
struct PortReport {
    name: String,
    kind: &'static str,
    rows: usize,
    /// Nodes of a patch.
    nodes: usize,
    /// Origin of a frame, or the mean of the nodes of a patch.
    origin: [f64; 3],
}

/// Residual flexibility between contacts near each other.
#[derive(Serialize)]
struct PatchReport {
    /// Distance at which contacts have nothing but further modes between them.
    distance: f64,
    /// Further modes by which contacts answer statically.
    modes: usize,
    /// Pairs of loadable nodes.
    pairs: usize,
}

/// A body without supports.
#[derive(Serialize)]
struct FreeReport {
    mass: f64,
    centre: [f64; 3],
    principal_moments: [f64; 3],
    principal_axes: [[f64; 3]; 3],
}

impl FreeReport {
    fn of(file: &File<'_>) -> Option<Self> {
        let RigidBody { mass, centre, moments, axes, .. } = RigidBody::of(file)?;
        Some(Self { mass, centre, principal_moments: moments, principal_axes: axes })
    }
}

/// Axes of the canonical structure of one stage, and where its load can stand.
#[derive(Serialize)]
struct CanonicalAxes {
    axes: Vec<usize>,
    positions: usize,
    direction: Option<[f64; 3]>,
}

#[derive(Serialize)]
struct SectionReport {
    kind: String,
    element: String,
    codec: String,
    shape: [u64; 3],
    stored_bytes: usize,
    decoded_bytes: u64,
    /// Relative error that rounding brought; absent where nothing was rounded by `pack`.
    loss: Option<Loss>,
}

impl SectionReport {
    fn new(section: &Section<'_>, losses: &[(SectionKind, Loss)]) -> Self {
        Self {
            kind: section.kind().to_string(),
            element: section.element().to_string(),
            codec: section.codec().to_string(),
            shape: section.shape(),
            stored_bytes: section.stored().len(),
            decoded_bytes: section.decoded_length(),
            loss: losses.iter().find(|(kind, _)| *kind == section.kind()).map(|(_, loss)| *loss),
        }
    }
}

impl Info {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let mapped = open(&self.file)?;
        let (contents, flaw) = self.read(mapped.bytes())?;
        if self.json {
            print_json(&contents);
        } else {
            contents.print();
        }
        if let Some(error) = flaw {
            eprintln!(
                "  note: {error}; `vademecum verify {} --file-only` checks the file",
                self.file.display()
            );
        }
        Ok(())
    }

    /// Contents of the file, and the fault of its coordinates, if any.
    fn read(&self, bytes: &[u8]) -> Result<(Contents, Option<RewriteError>), Failure> {
        let mut memory = vec![];
        let wanted = |kind| self.is_printed(kind);
        let read = usable_bytes(&self.file, bytes, wanted, self.limit, &mut memory)?;
        let listed = File::parse(bytes).map_err(FileError::from);
        let contents = listed.and_then(|listed| self.contents(&listed, &read));
        let contents = contents.map_err(|error| Failure::file(&self.file, error))?;
        Ok((contents, check_coordinates(&read).err()))
    }

    /// True of sections that are read, not only listed.
    fn is_printed(&self, kind: SectionKind) -> bool {
        use SectionKind as S;
        let printed = [
            S::ModeTable,
            S::PatternNames,
            S::ProbeNames,
            S::SupportNames,
            S::SupportPoints,
            S::EnrichmentHistory,
            S::MeshError,
            S::RadiusSamples,
            S::Losses,
            S::Repairs,
            S::StaticBound,
            S::RigidBody,
            S::NodeCoordinates,
            // Without these the file would not open.
            S::ReducedStiffness,
            S::Eigenvalues,
            S::AxisPoints,
            S::Factors,
            S::BlockState,
            S::RegionStiffness,
            S::RegionMass,
        ];
        // What other commands refuse is refused here too.
        let checked = printed.contains(&kind) || SectionKind::INDICES.contains(&kind);
        checked || kind.is_chapter() || (kind == S::BlockLoad && self.terms_for.is_some())
    }

    /// Contents of `listed`, the file as it is, and of `file`, its decoded sections.
    fn contents(&self, listed: &File<'_>, file: &File<'_>) -> Result<Contents, FileError> {
        let m = file.metadata();
        let canonical = Chapter::read(file)?;
        let strain = listed.section(SectionKind::StrainSizes).is_some();
        let present = [
            ("diagonal", m.diagonal),
            ("block", m.block),
            ("canonical", canonical.is_some()),
            ("strain", strain),
        ];
        let losses = read_losses(file)?;
        let section = |kind| listed.section(kind).map(|section| SectionReport::new(&section, &losses));
        let certificate = Certificates::read(file, strain)?;
        let live_errors = LiveErrors::of(file)?;
        Ok(Contents {
            file_bytes: listed.bytes().len(),
            sha256: sha256(listed.bytes()),
            format: format!("{}.{}", vademecum_format::MAJOR, listed.minor()),
            program: m.program.into(),
            units: m.units.into(),
            mesh_hash: m.mesh_hash.iter().map(|b| format!("{b:02x}")).collect(),
            nodes: m.n_nodes,
            surface_nodes: m.n_surface_nodes,
            loadable_nodes: m.n_load_nodes,
            triangles: m.n_triangles,
            modes: m.n_modes,
            scheme: m.scheme_name.into(),
            stages: m.scheme.n_stages,
            time_step: m.time_step,
            alpha: m.alpha,
            beta: m.beta,
            damping_ratios: damping_ratios(file)?,
            damping_rows: file.section(SectionKind::DampingRows).map_or(0, |section| section.shape()[0]),
            mode_table: mode_table(file)?,
            structures: present.iter().filter(|s| s.1).map(|s| s.0).collect(),
            terms: certificate.terms,
            canonical: canonical.as_ref().map(CanonicalAxes::new),
            axes: m.active_axes().iter().map(AxisReport::from).collect(),
            parameters: parameters(file),
            parameter_points: live_errors.points,
            parameter_witnesses: live_errors.closer,
            load_patterns: lines(file, SectionKind::PatternNames)?,
            probes: lines(file, SectionKind::ProbeNames)?,
            free_body: FreeReport::of(file),
            supports: supports(file)?,
            ports: ports(file)?,
            contact_patch: file.contact_patch()?.map(|patch| PatchReport {
                distance: patch.distance,
                modes: patch.n_modes,
                pairs: patch.pairs.len(),
            }),
            certificate,
            enrichment_history: enrichment_history(file)?,
            fewest_terms: self.terms_for.map(|t| fewest_terms(file.bytes(), t)).transpose()?,
            radius_samples: radius_samples(file)?,
            sections: SectionKind::ALL.iter().copied().filter_map(section).collect(),
            problem: m.problem.into(),
            accuracy: Accuracy::of(file)?.lines(),
        })
    }
}

/// Supports whose reactions the file gives.
fn supports(file: &File<'_>) -> Result<Vec<SupportReport>, FileError> {
    let names = lines(file, SectionKind::SupportNames)?.into_iter();
    let points = numbers(file, SectionKind::SupportPoints)?;
    let points = points.as_chunks().0.iter().copied();
    Ok(names.zip(points).map(|(name, point)| SupportReport { name, point }).collect())
}

/// Ports of the file.
fn ports(file: &File<'_>) -> Result<Vec<PortReport>, FileError> {
    let names = lines(file, SectionKind::PortNames)?.into_iter();
    let ranges = file.port_table()?.iter().filter_map(PortRange::of);
    let frames = numbers(file, SectionKind::PortFrames)?;
    let of = |((name, range), frame): ((String, PortRange), &[f64; 12])| PortReport {
        name,
        kind: if range.kind == PortKind::Patch { "patch" } else { "frame" },
        rows: range.rows[1],
        nodes: range.nodes[1],
        origin: [frame[0], frame[1], frame[2]],
    };
    Ok(names.zip(ranges).zip(frames.as_chunks::<12>().0).map(of).collect())
}

impl Contents {
    /// True of a file of large displacements.
    fn is_large(&self) -> bool {
        self.structures.contains(&"strain")
    }

    fn print(&self) {
        println!(
            "vademecum file, format {}, written by {}; {} bytes",
            self.format, self.program, self.file_bytes
        );
        println!("SHA-256 {}", self.sha256);
        println!("units {}; mesh {}", self.units, self.mesh_hash);
        println!(
            "{} nodes ({} on the surface, {} loadable), {} triangles, {} modes",
            self.nodes, self.surface_nodes, self.loadable_nodes, self.triangles, self.modes
        );
        println!(
            "scheme {}, time step {} s, alpha {} 1/s, beta {} s",
            self.scheme, self.time_step, self.alpha, self.beta
        );
        self.print_body();
        println!(
            "structures: {}; probes: {}; load patterns: {}",
            self.structures.join(", "),
            list(&self.probes),
            list(&self.load_patterns)
        );
        self.print_axes();
        self.accuracy.iter().for_each(|line| println!("{line}"));
        self.certificate.print(self.is_large());
        self.print_separation();
        self.print_sections();
    }

    /// Supports, damping of the modes, rigid motions.
    fn print_body(&self) {
        if !self.supports.is_empty() {
            let names: Vec<String> = self.supports.iter().map(|support| support.name.clone()).collect();
            println!("reactions of supports: {}", list(&names));
        }
        match &self.damping_ratios[..] {
            [] => {}
            [first, rest @ ..] if rest.iter().all(|ratio| ratio == first) => {
                println!("damping ratio of every mode beside that: {first}");
            }
            ratios => {
                let ratios: Vec<String> = ratios.iter().map(f64::to_string).collect();
                println!("damping ratios of the modes beside that: {}", ratios.join(", "));
            }
        }
        for PortReport { name, kind, rows, nodes, .. } in &self.ports {
            let of = if *nodes > 0 { format!(", {nodes} nodes") } else { String::new() };
            println!("port `{name}`: a {kind}, {rows} rows{of}");
        }
        if let Some(PatchReport { distance, modes, pairs }) = &self.contact_patch {
            println!(
                "contacts nearer than {distance} m are answered together: {modes} further modes, {pairs} pairs of nodes"
            );
        }
        if self.damping_rows > 0 {
            println!(
                "dashpots couple the modes: {} rows; a step is one of all modes together",
                self.damping_rows
            );
        }
        if let Some(FreeReport { mass, centre: [x, y, z], principal_moments: [a, b, c], .. }) =
            &self.free_body
        {
            println!(
                "free body: mass {mass:.6e}, centre ({x:.6e}, {y:.6e}, {z:.6e}), principal moments of inertia {a:.6e}, \
                 {b:.6e}, {c:.6e}; six rigid motions beside the modes"
            );
        }
    }

    /// Live parameters and the axes of separated solutions.
    fn print_axes(&self) {
        if let Some(c) = &self.canonical {
            let direction = c.direction.map_or("components".into(), |[x, y, z]| format!("[{x}, {y}, {z}]"));
            println!("canonical: {:?} axes by stage; load at {} positions, {direction}", c.axes, c.positions);
        }
        for p in &self.parameters {
            let range = range(p.lower, p.upper, &p.unit);
            println!("parameter {}: {range}, nominal {} ({})", p.name, p.nominal, p.role);
        }
        for axis in &self.axes {
            let range = range(axis.lower, axis.upper, &axis.unit);
            println!("axis {}: {range}, {} points ({})", axis.name, axis.points, axis.kind);
        }
    }

    fn print_sections(&self) {
        println!(
            "\nsection               element  codec     shape                     bytes  rounded, relative"
        );
        for s in &self.sections {
            let shape = format!("{} × {} × {}", s.shape[0], s.shape[1], s.shape[2]);
            let loss = s.loss.map_or(String::new(), |loss| format!("  {:.1e}", loss.displacement));
            println!(
                "{:<20}  {:<7}  {:<8}  {shape:<20}  {:>9}{loss}",
                s.kind, s.element, s.codec, s.stored_bytes
            );
        }
    }
}

impl Contents {
    /// Enrichment history and stability over the parameters.
    fn print_separation(&self) {
        if let (Some(first), Some(last)) = (self.enrichment_history.first(), self.enrichment_history.last()) {
            println!(
                "enrichment: {} steps, error {:.1e} at {} terms to {:.1e} at {}",
                self.enrichment_history.len(),
                first.error,
                first.terms,
                last.error,
                last.terms
            );
        }
        if let Some(fewest) = &self.fewest_terms {
            println!(
                "the first {} of {} terms: error of the maps {:.1e} (rms), {:.1e} (largest)",
                fewest.left, fewest.before, fewest.error_rms, fewest.error_max
            );
        }
        let radii = self.radius_samples.iter().map(|sample| sample.spectral_radius);
        if !self.radius_samples.is_empty() {
            let (low, high) = radii.fold((f64::INFINITY, 0.0_f64), |(a, b), r| (a.min(r), b.max(r)));
            println!(
                "spectral radius at {} points of the parameter domain: 1{:+.1e} to 1{:+.1e}",
                self.radius_samples.len(),
                low - 1.0,
                high - 1.0
            );
        }
    }
}

impl CanonicalAxes {
    fn new(canonical: &Chapter<'_>) -> Self {
        let stages = canonical.parts().map(|part| part.stage).max().map_or(0, |last| last + 1);
        let of_stage = |stage| canonical.parts().filter(move |part| part.stage == stage);
        let axes = |stage| of_stage(stage).map(|part| part.axes().count()).sum();
        Self {
            axes: (0..stages).map(axes).collect(),
            positions: canonical.n_positions(),
            direction: canonical.direction(),
        }
    }
}

fn endurance(steps: f64) -> String {
    if steps == 0.0 {
        return "the tolerance was exceeded within the certified steps".into();
    }
    let count = if steps < 1e6 { format!("{steps:.0}") } else { format!("{steps:.1e}") };
    format!("tolerance verified for at least {count} steps (extrapolated from the drift)")
}

/// From the stored errors and the tolerance of the stored problem; absent without either, or when it is
/// without end.
fn good_for_steps(problem: &str, worst: &StructureReport) -> Option<f64> {
    let tolerance = Problem::parse(problem, "problem", PathBuf::new()).ok()?.tolerance;
    Some(worst.good_for_steps(tolerance.floor_ratio, tolerance.absolute)).filter(|steps| steps.is_finite())
}

/// A range with its unit; a ratio has none.
fn range(lower: f64, upper: f64, unit: &str) -> String {
    let unit = if unit == "1" { "" } else { unit };
    format!("{lower} to {upper} {unit}").trim_end().into()
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "none".into() } else { names.join(", ") }
}
