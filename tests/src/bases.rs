//! How far each basis and each structure of the step stays from the full-order march, on one body, side by
//! side.
//!
//! One POD of the problem's snapshots serves all bases, one full-order march of unseen loads all structures,
//! so that what differs between two rows is the basis and the structure and nothing else.

use vademecum_build::basis::{Basis, ritz_basis};
use vademecum_build::certificate::{Candidate, Measured, UnseenLoads, measure};
use vademecum_build::dynamics::TrajectoryError;
use vademecum_build::export::NodeOrder;
use vademecum_build::fem::Pencil;
use vademecum_build::input::BasisKind;
use vademecum_build::prepared::Prepared;
use vademecum_build::progress::Listener;
use vademecum_build::response::StageResponse;
use vademecum_eval::{SceneOptions, StructureChoice};
use vademecum_format::policy::ABSOLUTE_ERROR;
use vademecum_format::scheme::theta;
use vademecum_study::parts::Study;

/// A basis and a way to project the stages on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variant {
    /// The project's basis, diagonal structure (Galerkin stages).
    RitzDiagonal,
    /// The project's basis, block structure (full-order stages projected with `BᵀM`).
    RitzBlock,
    /// Ritz vectors of the oversampled POD itself, without its static response (docs/explanation/4-basis.md),
    /// diagonal structure.
    PlainRitzDiagonal,
    /// The same, block structure.
    PlainRitzBlock,
    /// The leading POD vectors, Galerkin stages: what a reduced model usually is.
    PodGalerkin,
    /// The leading POD vectors, block structure.
    PodBlock,
}

/// All of them.
pub const VARIANTS: [Variant; 6] = [
    Variant::RitzDiagonal,
    Variant::RitzBlock,
    Variant::PlainRitzDiagonal,
    Variant::PlainRitzBlock,
    Variant::PodGalerkin,
    Variant::PodBlock,
];

/// What one variant with one number of modes reached.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The variant.
    pub variant: Variant,
    /// Modes r.
    pub modes: usize,
    /// Relative L2 error over all dofs and steps in the mass norm, the largest of the unseen loads.
    pub error: f64,
    /// The same of the projection of the full-order trajectory.
    pub floor: f64,
    /// Largest error ÷ floor of one load.
    pub ratio: f64,
    /// Largest (error − 1e-6) ÷ floor of one load: what `tolerance.floor_ratio` bounds.
    pub excess: f64,
    /// Of the fused step.
    pub spectral_radius: f64,
}

/// The basis of a variant.
///
/// # Panics
/// If the snapshots have fewer dimensions, or the stiffness does not factorise.
#[must_use]
pub fn basis(study: &Study, variant: Variant, modes: usize) -> Basis {
    let of_kind = |kind| study.basis(kind, modes).expect("a basis").value;
    match variant {
        Variant::RitzDiagonal | Variant::RitzBlock => of_kind(BasisKind::Ritz),
        Variant::PodGalerkin | Variant::PodBlock => of_kind(BasisKind::Pod),
        Variant::PlainRitzDiagonal | Variant::PlainRitzBlock => {
            let pencil = pencil(study);
            let mass = |x: MatRef<'_>, y: MatMut<'_>| pencil.mass().mul_into(x, y);
            let stiffness = |x: MatRef<'_>, y: MatMut<'_>| pencil.stiffness().mul_into(x, y);
            // The carrier [V, V] has the rank of V: Ritz vectors of the POD alone.
            let nothing_new = |x: MatRef<'_>, mut y: MatMut<'_>| y.copy_from(x);
            let oversampling = study.problem().basis.oversampling;
            ritz_basis(&mass, &stiffness, &nothing_new, study.pod(), modes, oversampling)
                .expect("finite snapshots")
        }
    }
}

/// The bytes of a file with the project's basis in both structures; its certificate is empty.
///
/// # Panics
/// If a stage does not factorise, or the writer refuses it.
#[must_use]
pub fn file(study: &Study, modes: usize) -> Vec<u8> {
    let basis = basis(study, Variant::RitzBlock, modes);
    let responses = study.responses(&basis).expect("definite").value;
    study.file(&basis, Some(&responses)).expect("the writer takes it").value
}

/// Marches the unseen loads for `steps` steps beside every variant with every number of modes.
///
/// # Panics
/// If a march fails.
#[must_use]
pub fn compare(
    study: &Study,
    variants: &[Variant],
    modes: &[usize],
    steps: usize,
    listener: &dyn Listener,
) -> Vec<Row> {
    let prepared = study.prepared();
    let unseen = UnseenLoads::draw(&prepared.body, study.runs(), steps);
    let choices: Vec<(Variant, usize)> =
        modes.iter().flat_map(|&r| variants.iter().map(move |&v| (v, r))).collect();
    let bases: Vec<Basis> = choices.iter().map(|&(v, r)| basis(study, v, r)).collect();
    let made = |(&(variant, _), basis): (&(Variant, usize), &Basis)| {
        let stages = stages(study, variant, basis);
        study.file(basis, stages.as_deref()).expect("the writer takes it").value
    };
    let files: Vec<Vec<u8>> = choices.iter().zip(&bases).map(made).collect();
    let options: Vec<SceneOptions> = choices.iter().map(|&(variant, _)| variant.options()).collect();
    let parts = files.iter().zip(&bases).zip(&options);
    let candidates: Vec<Candidate<'_>> =
        parts.map(|((bytes, basis), options)| Candidate { bytes, basis, options }).collect();
    let full = study.full_order(&prepared.scheme, study.time_step()).expect("a march").value;
    let (order, mass) = (NodeOrder::new(&prepared.body), pencil(study).mass());
    let measured = measure(&candidates, &order, mass, &full, &unseen, listener).expect("marched");
    choices.iter().zip(&measured).map(|(&(variant, modes), measured)| row(variant, modes, measured)).collect()
}

fn pencil(study: &Study) -> &Pencil {
    study.prepared().body.model.pencil()
}

/// Stage responses of a variant; none for the diagonal structure, which needs eigenvalues only.
fn stages(study: &Study, variant: Variant, basis: &Basis) -> Option<Vec<StageResponse>> {
    match variant {
        Variant::RitzDiagonal | Variant::PlainRitzDiagonal => None,
        Variant::PodGalerkin => {
            let Prepared { scheme, step, .. } = study.prepared();
            let stage = |i| {
                let theta = theta(scheme, step, i).expect("a sound scheme");
                StageResponse::galerkin(basis.vectors.as_ref(), basis.stiffness.as_ref(), theta)
            };
            Some((0..scheme.active().len()).map(stage).collect())
        }
        _ => Some(study.responses(basis).expect("definite").value),
    }
}

impl Variant {
    /// What a scene of its file is bound to.
    fn options(self) -> SceneOptions {
        let structure = match self {
            Self::RitzDiagonal | Self::PlainRitzDiagonal => StructureChoice::Diagonal,
            _ => StructureChoice::Block,
        };
        SceneOptions { structure, ..SceneOptions::default() }
    }
}

type MatRef<'a> = faer::MatRef<'a, f64>;
type MatMut<'a> = faer::MatMut<'a, f64>;

fn row(variant: Variant, modes: usize, measured: &Measured) -> Row {
    let largest =
        |value: &dyn Fn(&TrajectoryError) -> f64| measured.errors.iter().map(value).fold(0.0, f64::max);
    Row {
        variant,
        modes,
        error: largest(&|e| e.error),
        floor: largest(&|e| e.floor),
        ratio: largest(&|e| e.error / e.floor),
        excess: largest(&|e| (e.error - ABSOLUTE_ERROR) / e.floor),
        spectral_radius: measured.spectral_radius,
    }
}
