//! The block structure of a file without parameters, against the stiffness it is made from.
//!
//! Stage `i` has `C = BᵀM(M + θK)⁻¹MB = I + E` with the mass the basis is normalised in. Whatever the basis,
//! `C` is symmetric, it takes nothing more than the identity does, and, an inverse being convex, at least as
//! much as the inverse of the projection: `(I + θBᵀKB)⁻¹ ≤ C ≤ I`. On the diagonal that is
//!
//! ```text
//! −θ K_kk / (1 + θ K_kk) ≤ E_kk ≤ 0
//! ```
//!
//! with equality on the left for a basis that is closed under the dynamics. What the build says its solves
//! are off by (`map error`) is allowed, and the tolerances of [`symmetric`](super::symmetric).

use vademecum_format::scheme::{StepParameters, theta};
use vademecum_format::{AxisRole, File, Metadata, SectionKind};

use super::super::error::{Fault, RewriteError};
use super::super::numbers::{reals_of, unsound};
use super::symmetric::{HALF, ROUNDING, negative_pivot, unsymmetric};

/// Largest size of a number in a map; those of a stable step are below 1.
const LARGEST: f64 = (1u64 << 40) as f64;

/// Sections 8 and 18, as far as the file has them.
pub(super) fn check(file: &File<'_>) -> Result<(), RewriteError> {
    use SectionKind as S;
    let metadata = file.metadata();
    let Some(states) = reals_of(file, S::BlockState)? else { return Ok(()) };
    let factors = reals_of(file, S::Factors)?.unwrap_or_default();
    for (kind, values) in [(S::BlockState, &states), (S::Factors, &factors)] {
        if let Some(place) = values.iter().position(|x| x.abs() > LARGEST) {
            let reason = format!("number {place} is {:e}; those of a step are near 1", values[place]);
            return Err(unsound(kind, Fault::Magnitude, reason));
        }
    }
    if !is_fixed(metadata, &factors) {
        return Ok(());
    }
    let Some(stiffness) = reals_of(file, S::ReducedStiffness)? else { return Ok(()) };
    let r = metadata.n_modes as usize;
    let step = StepParameters {
        time_step: metadata.time_step,
        alpha: metadata.alpha,
        beta: metadata.beta,
        density: 1.0,
        stiffness: 1.0,
    };
    for (stage, state) in states.chunks_exact(r * r).enumerate() {
        // A scheme that gives no θ is one the evaluator refuses by name.
        let Ok(theta) = theta(&metadata.scheme, &step, stage) else { return Ok(()) };
        bounds(stage, state, &stiffness, theta, metadata)?;
    }
    Ok(())
}

/// True if term `t` is stage `t`: the file has no parameters, and no term is gone.
fn is_fixed(metadata: &Metadata<'_>, factors: &[f64]) -> bool {
    let terms = metadata.n_terms as usize;
    let [axis] = metadata.active_axes() else { return false };
    let identity = || (0..terms * terms).map(|i| f64::from(u8::from(i / terms == i % terms)));
    metadata.n_parameters == 0
        && axis.role == AxisRole::Stage
        && terms == usize::from(metadata.scheme.n_stages)
        && factors.len() == terms * terms
        && identity().eq(factors.iter().copied())
}

fn bounds(
    stage: usize,
    state: &[f64],
    stiffness: &[f64],
    theta: f64,
    metadata: &Metadata<'_>,
) -> Result<(), RewriteError> {
    let r = metadata.n_modes as usize;
    let kind = SectionKind::BlockState;
    let measured = metadata.certificate.block.map_error_max;
    let largest = (0..r).fold(0.0, |m: f64, k| m.max(stiffness[k * r + k].abs()));
    // `θK/(1 + θK)`, with the error of `K`.
    let full = |k: usize| {
        let x = theta * ((1.0 + HALF) * stiffness[k * r + k].abs() + ROUNDING * largest);
        x / (1.0 + x)
    };
    // What the maps are off by is relative to them.
    let off = HALF + if measured.is_finite() { measured } else { 0.0 };
    let allowed = |k: usize, l: usize| off * (full(k) * full(l)).sqrt() + ROUNDING;
    for k in 0..r {
        let value = state[k * r + k];
        if value > allowed(k, k) || value < -full(k) - allowed(k, k) {
            let reason = format!(
                "stage {stage}, entry ({k}, {k}) is {value:e}; with the stiffness in the file it lies in \
                 {:e} … 0",
                -full(k)
            );
            return Err(unsound(kind, Fault::Disagrees, reason));
        }
    }
    if let Some([k, l]) = unsymmetric(state, r, allowed) {
        let (one, other) = (state[k * r + l], state[l * r + k]);
        let reason = format!(
            "stage {stage}: entry ({k}, {l}) is {one:e} and ({l}, {k}) is {other:e}; without parameters it is \
             symmetric"
        );
        return Err(unsound(kind, Fault::NotSymmetric, reason));
    }
    let mut negated: Vec<f64> = state.iter().map(|x| -x).collect();
    match negative_pivot(&mut negated, r, |k| allowed(k, k)) {
        None => Ok(()),
        Some(k) => {
            let reason =
                format!("stage {stage} adds to a combination of modes 0 to {k}; a stage only takes away");
            Err(unsound(kind, Fault::Negative, reason))
        }
    }
}
