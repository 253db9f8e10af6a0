//! Bodies joined from vademecum files that were built apart.
//!
//! An [`AssemblyFile`] names parts and the joints between their ports; [`assemble`] reads the parts, joins
//! them by component mode synthesis with residual flexibility (`synthesis`), and gives the bytes of one
//! ordinary vademecum file. Ports are patches and frames that `[[port]]` of a problem file names.

mod error;
mod file;
mod joint;
mod part;
mod pose;
mod sections;
mod synthesis;

pub use error::AssemblyError;
pub use file::{AssemblyFile, JointEntry, JointKind, PartEntry};
pub use joint::JointReport;

use vademecum_build::dynamics::{ModalRatios, Rayleigh, mode_table, table_matrix};
use vademecum_build::export::Draft;
use vademecum_build::mesh::{Mesh, hash};
use vademecum_build::prepared::proposed_time_step;
use vademecum_build::store::read_regular;
use vademecum_format::scheme::SchemeTable;
use vademecum_format::{
    Axis, Certificate, File, MAX_AXES, MAX_MODES, MAX_PARAMETERS, Metadata, Parameter, SectionInput,
    SectionKind, encode_into, encoded_len,
};
use vademecum_rewrite::{check_limited, default_limit, unpack};

use joint::joint_rows;
use part::Part;
use pose::Pose;
use sections::Joined;
use synthesis::{Damped, Synthesis};

/// A joined body.
#[derive(Debug)]
pub struct Assembled {
    /// The bytes of its file.
    pub bytes: Vec<u8>,
    /// Its parts and joints.
    pub report: AssemblyReport,
}

/// Report of a joined body.
#[derive(Clone, Debug, serde::Serialize)]
pub struct AssemblyReport {
    /// Line for people of the assembly file.
    pub title: String,
    /// Parts.
    pub parts: Vec<PartReport>,
    /// Joints.
    pub joints: Vec<JointReport>,
    /// Number of modes.
    pub modes: usize,
    /// The lowest natural frequencies \[Hz\], ten at most.
    pub frequencies_hz: Vec<f64>,
    /// `Rubin`, or `MacNeal` where a part has no inertia of what its modes leave out.
    pub synthesis: &'static str,
    /// Largest change of an answer at a natural frequency by damping that couples modes; 0 where none does.
    pub damping_coupling: f64,
    /// True if the file holds the damping that couples modes.
    pub damping_coupled: bool,
    /// Step \[s\].
    pub time_step: f64,
    /// Losses of the joined file against its parts.
    pub notes: Vec<String>,
}

/// A part as a report names it.
#[derive(Clone, Debug, serde::Serialize)]
pub struct PartReport {
    /// Its name.
    pub name: String,
    /// Its file.
    pub file: String,
    /// Mesh hash of the file.
    pub hash: String,
    /// Number of its modes, the rigid motions of a free body among them.
    pub modes: usize,
    /// True of a body that nothing holds.
    pub free: bool,
}

/// Sections of parts that the joined file has not, and what is lost with them.
const LOST: [(SectionKind, &str); 7] = [
    (SectionKind::StressBasis, "stress of it"),
    (SectionKind::ReactionBasis, "reactions of its supports"),
    (SectionKind::InteriorBasis, "fields inside it"),
    (SectionKind::FactorValues, "factor of its stiffness, so no static fields inside it"),
    (SectionKind::EmbeddedTriangles, "embedded surface of it: that of the mesh is drawn"),
    (SectionKind::BaseFrame, "motion of its base"),
    (SectionKind::ContactPatch, "flexibility between contacts on it: each is answered by itself"),
];

/// Joins the parts of an assembly file.
///
/// # Errors
/// [`AssemblyError`]: files that cannot be read or joined, ports that do not meet, redundant joints, a body
/// that is not held.
pub fn assemble(file: &AssemblyFile) -> Result<Assembled, AssemblyError> {
    let mut raw = vec![];
    for entry in &file.parts {
        let path = file.resolve(entry);
        let unreadable =
            |source| AssemblyError::Unreadable { part: entry.name.clone(), path: path.clone(), source };
        let bytes = read_regular(&path).map_err(unreadable)?;
        let limit = default_limit(bytes.len());
        let opened = check_limited(&bytes, limit).and_then(|_| unpack(&bytes, limit));
        raw.push(opened.map_err(|source| AssemblyError::Part {
            part: entry.name.clone(),
            path: path.clone(),
            source,
        })?);
    }
    let mut parts = vec![];
    for (i, (entry, bytes)) in file.parts.iter().zip(&raw).enumerate() {
        let opened = File::parse(bytes)?;
        let found = hex(&opened.metadata().mesh_hash);
        if let Some(expected) = entry.hash.as_ref().filter(|expected| **expected != found) {
            let words = format!(
                "`{found}`, the hash of the mesh of this file: the part was built anew on another mesh"
            );
            return Err(file.refuse(&format!("part[{i}].hash"), format!("`{expected}`"), words).into());
        }
        parts.push(Part::new(&entry.name, Pose::new(entry.position, entry.rotation), opened)?);
    }
    let (rows, joints) = joint_rows(file, &parts)?;
    within(file, &parts)?;
    let synthesis = Synthesis::new(&parts, &rows, |joint| file.joints[joint].name(joint))?;
    write(file, &parts, joints, &synthesis)
}

/// Refuses a joined body of more modes than a file has.
fn within(file: &AssemblyFile, parts: &[Part<'_>]) -> Result<(), AssemblyError> {
    let modes: usize = parts.iter().map(Part::n_modes).sum();
    if modes > MAX_MODES as usize {
        let expected = format!("at most {MAX_MODES}, the most a file has: parts of fewer modes");
        return Err(file.refuse("part", format!("{modes} modes of all parts"), expected).into());
    }
    Ok(())
}

fn write(
    file: &AssemblyFile,
    parts: &[Part<'_>],
    joints: Vec<JointReport>,
    synthesis: &Synthesis,
) -> Result<Assembled, AssemblyError> {
    let first_period =
        synthesis.eigenvalues.first().map_or(1.0, |value| std::f64::consts::TAU / value.sqrt());
    let time_step = file.step.unwrap_or_else(|| proposed_time_step(first_period));
    let mut joined = Joined::new(parts, synthesis);
    let (rayleigh, ratios, coupling, coupled) = match &synthesis.damping {
        Damped::Alike { alpha, beta, ratio } => ((*alpha, *beta), vec![*ratio], 0.0, false),
        Damped::Ratios(ratios, change) => ((0.0, 0.0), ratios.clone(), *change, false),
        Damped::Rows(damping, change) => {
            let own = |(k, value): (usize, &f64)| {
                let sum: f64 = (0..damping.nrows()).map(|i| damping[(i, k)].powi(2)).sum();
                sum / (2.0 * value.sqrt())
            };
            ((0.0, 0.0), synthesis.eigenvalues.iter().enumerate().map(own).collect(), *change, true)
        }
    };
    let table = mode_table(
        &synthesis.eigenvalues,
        &[],
        &SchemeTable::EXACT,
        (&Rayleigh { alpha: rayleigh.0, beta: rayleigh.1 }, &ModalRatios(ratios)),
        time_step,
    );
    let mut own = joined.sections();
    let of_stiffness = |part: &Part<'_>| part.file.metadata().beta > 0.0;
    if rayleigh.1 == 0.0 && parts.iter().any(of_stiffness) {
        joined.notes.push(
            "parts with different damping: under contacts, what the modes leave out answers at once, without \
             the damping by the stiffness of its part"
                .into(),
        );
    }
    own.push(joined.mode_table(table_matrix(&table)));
    for (kind, lost) in LOST {
        for part in parts.iter().filter(|part| part.file.section(kind).is_some()) {
            joined.notes.push(format!("part `{}`: the joined file has no {lost}", part.name));
        }
    }
    let mut inputs: Vec<SectionInput<'_>> = own.iter().map(Draft::input).collect();
    inputs.sort_by_key(|input| input.kind.number());
    let (counts, first) = (joined.counts, parts[0].file.metadata());
    let program = concat!("vademecum ", env!("CARGO_PKG_VERSION"), ", assembled");
    let metadata = Metadata {
        program,
        problem: &file.text,
        units: first.units,
        // Of the nodes of all parts at their places: no mesh is that of the joined body.
        mesh_hash: hash(&Mesh::of_points(
            parts.iter().flat_map(|part| part.places.iter().copied()).collect(),
        )),
        n_nodes: counts.nodes as u32,
        n_surface_nodes: counts.nodes as u32,
        n_load_nodes: counts.load_nodes as u32,
        n_triangles: counts.triangles as u32,
        n_load_triangles: counts.load_triangles as u32,
        n_modes: synthesis.eigenvalues.len() as u32,
        n_patterns: counts.patterns as u32,
        n_probes: counts.probes as u32,
        scheme_name: first.scheme_name,
        scheme: SchemeTable::EXACT,
        time_step,
        alpha: rayleigh.0,
        beta: rayleigh.1,
        n_regions: 1,
        n_parameters: 0,
        parameters: [Parameter::UNUSED; MAX_PARAMETERS],
        axes: [Axis::UNUSED; MAX_AXES],
        n_axes: 0,
        n_terms: 0,
        diagonal: true,
        block: false,
        certificate: Certificate::default(),
    };
    let mut bytes = vec![0; encoded_len(&metadata, &inputs)?];
    encode_into(&metadata, &inputs, &mut bytes)?;
    let frequencies = synthesis.eigenvalues.iter().take(10).map(|value| value.sqrt() / std::f64::consts::TAU);
    let of_part = |(part, entry): (&Part<'_>, &PartEntry)| PartReport {
        name: part.name.clone(),
        file: entry.file.display().to_string(),
        hash: hex(&part.file.metadata().mesh_hash),
        modes: part.n_modes(),
        free: part.is_free(),
    };
    let report = AssemblyReport {
        title: file.title.clone(),
        parts: parts.iter().zip(&file.parts).map(of_part).collect(),
        joints,
        modes: synthesis.eigenvalues.len(),
        frequencies_hz: frequencies.collect(),
        synthesis: if synthesis.rubin { "Rubin" } else { "MacNeal" },
        damping_coupling: coupling,
        damping_coupled: coupled,
        time_step,
        notes: joined.notes,
    };
    Ok(Assembled { bytes, report })
}

/// Bytes in hexadecimal.
fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
