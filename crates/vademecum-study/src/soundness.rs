//! Checks of a file without the problem it came from: its sections, and whether its
//! step is as stable as its certificate claims.

mod patch;

use serde::Serialize;
use vademecum_build::certificate::spectral_radius;
use vademecum_eval::{SceneOptions, StructureChoice};
use vademecum_format::policy::STABLE_RADIUS;
use vademecum_format::{Codec, File, Parameter, SectionKind, StructureCertificate};
use vademecum_rewrite::{CheckReport, check_limited, unpack_wanted};

pub use patch::PatchSoundness;

use crate::error::{FileError, StudyError};

/// Result of a check.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Soundness {
    /// CheckReport contents.
    #[serde(flatten)]
    pub checked: CheckReport,
    /// Settings of the parameters at which the spectral radius of a step was found, over all structures.
    pub settings: usize,
    /// Corners of the parameters' box that were left out: the axes of the file end before them, or there are
    /// too many.
    pub corners_left_out: usize,
    /// Contacts near each other; none of a file that answers each by itself.
    pub patch: Option<PatchSoundness>,
    /// The largest radius; absent where none was looked for (the chapter's structure, too many modes).
    pub spectral_radius: Option<f64>,
}

/// Operations the eigenvalues of one step may cost, and those of all settings together.
const MAX_NUMBERS: f64 = (1u64 << 38) as f64;
const MOST: f64 = (1u64 << 36) as f64;

/// Operations for the eigenvalues of a general matrix of size `n`, about (Golub and Van Loan, table 7.5.1).
fn operations(n: f64) -> f64 {
    10.0 * n.powi(3)
}

/// Checks the bytes of a file whose sections decode to `limit` bytes at most: first all that
/// [`check_limited`] checks, then the spectral radius of every structure's step at the values of the problem,
/// and of the block structure's at the corners of the parameters' box; and the matrix of contacts near each
/// other. Steps of more than about a thousand
/// modes are left out, as the eigenvalues cost `270 r³` operations.
///
/// # Errors
/// [`FileError::Rewrite`], [`FileError::Bind`], [`FileError::Unstable`]; [`StudyError::Radius`].
pub fn check_file(bytes: &[u8], limit: u64) -> Result<Soundness, StudyError> {
    let checked = check_limited(bytes, limit)?;
    let file = File::parse(bytes)?;
    let memory;
    let file = if file.sections().all(|section| section.codec() == Codec::Raw) {
        file
    } else {
        memory = unpack_wanted(&file, |kind| of_the_step(kind) || patch::is_needed(kind), limit)?;
        File::parse(&memory)?
    };
    let patch = patch::check(&file)?;
    let mut found = Soundness { checked, settings: 0, corners_left_out: 0, patch, spectral_radius: None };
    let metadata = file.metadata();
    let cost = operations(3.0 * f64::from(metadata.n_modes));
    if cost > MAX_NUMBERS {
        return Ok(found);
    }
    let own = &metadata.certificate;
    if metadata.diagonal {
        let exact = metadata.scheme.is_exact();
        let structure = if exact { StructureChoice::Exact } else { StructureChoice::Diagonal };
        let options = SceneOptions { structure, ..SceneOptions::default() };
        found.hold(&file, "diagonal", &own.diagonal, &options, String::new)?;
    }
    if metadata.block {
        let nominal = SceneOptions { structure: StructureChoice::Block, ..SceneOptions::default() };
        found.hold(&file, "block", &own.block, &nominal, String::new)?;
        let parameters = metadata.active_parameters();
        let corners = if parameters.is_empty() { 0 } else { 1usize << parameters.len() };
        let affordable = (MOST / cost) as usize;
        for corner in 0..corners.min(affordable) {
            let mut options = nominal;
            let place = || place(parameters, corner);
            let set = parameters.iter().enumerate().try_for_each(|(index, parameter)| {
                options.set(metadata, &[(index, value(parameter, corner, index))])
            });
            let beyond = match set {
                Ok(()) => match found.hold(&file, "block", &own.block, &options, place) {
                    Err(StudyError::Radius(_)) => true,
                    held => {
                        held?;
                        false
                    }
                },
                Err(_) => true,
            };
            found.corners_left_out += usize::from(beyond);
        }
        found.corners_left_out += corners.saturating_sub(affordable);
    }
    Ok(found)
}

impl Soundness {
    /// Holds the step at these options to what the certificate of its structure claims.
    fn hold(
        &mut self,
        file: &File<'_>,
        structure: &'static str,
        claimed: &StructureCertificate,
        options: &SceneOptions,
        place: impl Fn() -> String,
    ) -> Result<(), StudyError> {
        let radius = spectral_radius(file, options)?;
        let allowed = allowed_radius(claimed, file.metadata().n_modes);
        self.settings += 1;
        self.spectral_radius = Some(self.spectral_radius.unwrap_or(0.0).max(radius));
        if radius <= allowed {
            return Ok(());
        }
        Err(FileError::Unstable { structure, place: place(), radius, allowed }.into())
    }
}

/// Limit without a certified radius: a radius above 2 is never usable.
const UNMEASURED: f64 = 2.0;

/// A step may be as unstable as its certificate says, and no step need be more stable than the policy asks.
///
/// An eigenvalue that occurs twice moves by the root of what its matrix is off by: of `3r` roundings here, so
/// by `2⁻²⁶ √(3r)`.
fn allowed_radius(claimed: &StructureCertificate, n_modes: u32) -> f64 {
    if claimed.spectral_radius.is_nan() {
        return UNMEASURED;
    }
    STABLE_RADIUS.max(claimed.spectral_radius) + (3.0 * f64::from(n_modes) * f64::EPSILON).sqrt()
}

/// The end of a parameter's range at a corner, by the bits of its number.
fn value(parameter: &Parameter<'_>, corner: usize, index: usize) -> f64 {
    if corner >> index & 1 == 0 { parameter.lower } else { parameter.upper }
}

/// ` at soft = 5e-1, hard = 2e0`.
fn place(parameters: &[Parameter<'_>], corner: usize) -> String {
    let one = |(index, p): (usize, &Parameter<'_>)| format!("{} = {:e}", p.name, value(p, corner, index));
    let all: Vec<String> = parameters.iter().enumerate().map(one).collect();
    format!(" at {}", all.join(", "))
}

/// Sections that a scene is bound to.
fn of_the_step(kind: SectionKind) -> bool {
    use SectionKind as S;
    matches!(
        kind,
        S::ReducedStiffness
            | S::Eigenvalues
            | S::DampingRatios
            | S::DampingRows
            | S::BlockState
            | S::AxisPoints
            | S::Factors
            | S::RegionStiffness
            | S::RegionMass
    ) || kind.is_chapter()
        || kind.is_strain()
}
