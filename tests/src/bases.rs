//! How far each basis and each structure of the step stays from the full-order march, on one body, side by
//! side.
//!
//! One POD of the problem's snapshots serves all bases, one full-order march of unseen loads all structures,
//! so that what differs between two rows is the basis and the structure and nothing else.

use vademecum_build::Matrix;
use vademecum_build::basis::{Basis, ritz_basis};
use vademecum_build::certificate::UnseenLoads;
use vademecum_build::dynamics::FullOrder;
use vademecum_build::dynamics::{TimedLoad, factors, march_full_order, stage_amplitudes};
use vademecum_build::fem::Pencil;
use vademecum_build::input::BasisKind;
use vademecum_build::prepared::Prepared;
use vademecum_build::progress::Listener;
use vademecum_build::response::StageResponse;
use vademecum_build::response::reduced::{BlockStep, DiagonalStep, FusedStep};
use vademecum_format::scheme::theta;
use vademecum_study::bench::Study;

/// A basis and a way to project the stages on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variant {
    /// The project's basis, diagonal structure (Galerkin stages).
    RitzDiagonal,
    /// The project's basis, block structure (full-order stages projected with `BᵀM`).
    RitzBlock,
    /// Ritz vectors of the oversampled POD itself, without its static response (docs/theory/4-basis.md),
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
    let unseen = UnseenLoads::draw(&study.prepared().body, study.runs(), steps).timed();
    let choices: Vec<(Variant, usize)> =
        modes.iter().flat_map(|&r| variants.iter().map(move |&v| (v, r))).collect();
    let bases: Vec<Basis> = choices.iter().map(|&(v, r)| basis(study, v, r)).collect();
    let responses: Vec<Vec<StageResponse>> =
        choices.iter().zip(&bases).map(|(&(variant, _), basis)| stages(study, variant, basis)).collect();
    let full = study.full_order(&study.prepared().scheme, study.time_step()).expect("a march").value;
    let mut marches: Vec<March<'_>> = choices
        .iter()
        .zip(bases.iter().zip(&responses))
        .map(|(&(variant, _), (basis, responses))| {
            March::new(basis, fuse(study, variant, basis, responses), &full, &unseen)
        })
        .collect();
    march_full_order(&full, &unseen, unseen.len(), steps, listener, |step, state| {
        if step > 0 {
            let displacement = state.displacement.as_ref();
            marches.iter_mut().for_each(|march| march.advance(step - 1, pencil(study), displacement));
        }
    })
    .expect("marched");
    choices.iter().zip(&marches).map(|(&(variant, modes), march)| march.row(variant, modes)).collect()
}

fn pencil(study: &Study) -> &Pencil {
    study.prepared().body.model.pencil()
}

/// Stage responses of a variant; none for the diagonal structure, which needs eigenvalues only.
fn stages(study: &Study, variant: Variant, basis: &Basis) -> Vec<StageResponse> {
    match variant {
        Variant::RitzDiagonal | Variant::PlainRitzDiagonal => vec![],
        Variant::PodGalerkin => {
            let Prepared { scheme, step, .. } = study.prepared();
            let stage = |i| {
                let theta = theta(scheme, step, i).expect("a sound scheme");
                StageResponse::galerkin(basis.vectors.as_ref(), basis.stiffness.as_ref(), theta)
            };
            (0..scheme.active().len()).map(stage).collect()
        }
        _ => study.responses(basis).expect("definite").value,
    }
}

fn fuse<'a>(
    study: &Study,
    variant: Variant,
    basis: &'a Basis,
    responses: &'a [StageResponse],
) -> Box<dyn FusedStep + 'a> {
    let (Prepared { scheme, step, .. }, vectors) = (study.prepared(), basis.vectors.as_ref());
    match variant {
        Variant::RitzDiagonal | Variant::PlainRitzDiagonal => {
            let eigenvalues = basis.eigenvalues.as_ref().expect("Ritz coordinates");
            Box::new(DiagonalStep::fuse(scheme, step, vectors, eigenvalues).expect("fused"))
        }
        _ => Box::new(BlockStep::fuse(scheme, step, vectors, responses).expect("fused")),
    }
}

type MatRef<'a> = faer::MatRef<'a, f64>;
type MatMut<'a> = faer::MatMut<'a, f64>;

/// One variant under way: reduced states of all unseen loads and the sums of squares of its errors.
struct March<'a> {
    basis: &'a Basis,
    step: Box<dyn FusedStep + 'a>,
    full: &'a FullOrder<'a>,
    loads: &'a [TimedLoad],
    responses: Vec<Vec<Vec<f64>>>,
    states: Vec<Vec<f64>>,
    /// Per load: ‖u‖², ‖u − BBᵀMu‖², ‖BᵀMu − ζ‖², summed over the steps.
    sums: Vec<[f64; 3]>,
}

impl<'a> March<'a> {
    fn new(
        basis: &'a Basis,
        step: Box<dyn FusedStep + 'a>,
        full: &'a FullOrder<'a>,
        loads: &'a [TimedLoad],
    ) -> Self {
        let r = basis.n_modes();
        // From rest: ζ̈ = BᵀF at time zero.
        let state = |load: &TimedLoad| {
            let factor = load.when.factor(0.0) * full.dt() * full.dt();
            let force = |k: usize| {
                basis.vectors.col_as_slice(k).iter().zip(&load.force).map(|(b, f)| b * f).sum::<f64>()
            };
            let acceleration = (0..r).map(|k| factor * force(k));
            std::iter::repeat_n(0.0, 2 * r).chain(acceleration).collect()
        };
        let responses = loads.iter().map(|load| step.load_response(&load.force)).collect();
        let (states, sums) = (loads.iter().map(state).collect(), vec![[0.0; 3]; loads.len()]);
        Self { basis, step, full, loads, responses, states, sums }
    }

    /// Step number `step`, then the errors against the full-order displacement after it, shape (n, loads).
    fn advance(&mut self, step: usize, pencil: &Pencil, displacement: MatRef<'_>) {
        let (r, n) = (self.basis.n_modes(), displacement.nrows());
        let (mut load, mut work) = (vec![0.0; 3 * r], vec![0.0; 3 * r]);
        for ((timed, responses), state) in self.loads.iter().zip(&self.responses).zip(&mut self.states) {
            let at = factors(self.full.table(), self.full.dt(), step, &timed.when);
            load.fill(0.0);
            self.step.add_load(responses, &stage_amplitudes(self.full.table(), &at), &mut load);
            self.step.step(state, &load, &mut work);
        }
        let mut weighted = Matrix::zeros(n, displacement.ncols());
        pencil.mass().mul_into(displacement, weighted.as_mut());
        let projection = self.basis.vectors.transpose() * &weighted;
        let residual = displacement - &self.basis.vectors * &projection;
        let mut weighted_residual = Matrix::zeros(n, displacement.ncols());
        pencil.mass().mul_into(residual.as_ref(), weighted_residual.as_mut());
        for (j, sums) in self.sums.iter_mut().enumerate() {
            sums[0] += displacement.col(j).transpose() * weighted.col(j);
            sums[1] += residual.col(j).transpose() * weighted_residual.col(j);
            sums[2] += (0..r).map(|k| (projection[(k, j)] - self.states[j][k]).powi(2)).sum::<f64>();
        }
    }

    fn row(&self, variant: Variant, modes: usize) -> Row {
        // u − Bζ = (u − BBᵀMu) + B(BᵀMu − ζ), and the two are M-orthogonal.
        let error = |s: &[f64; 3]| ((s[1] + s[2]) / s[0]).sqrt();
        let floor = |s: &[f64; 3]| (s[1] / s[0]).sqrt();
        let largest = |value: &dyn Fn(&[f64; 3]) -> f64| self.sums.iter().map(value).fold(0.0, f64::max);
        Row {
            variant,
            modes,
            error: largest(&error),
            floor: largest(&floor),
            ratio: largest(&|s| error(s) / floor(s)),
            excess: largest(&|s| (error(s) - ABSOLUTE) / floor(s)),
            spectral_radius: self.step.spectral_radius(),
        }
    }
}

/// What a trajectory error may exceed its multiple of the floor by (`tolerance.absolute`'s default).
const ABSOLUTE: f64 = 1e-6;
