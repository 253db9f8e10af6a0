//! Damping over the coordinates of a superelement.

use faer::{Mat, MatRef};

use super::error::SuperelementError;
use super::reduced::Reduced;
use crate::linalg::{symmetric_eigen, symmetric_part};
use crate::prepared::Prepared;

/// An eigenvalue of the mass that is a smaller share of the largest has no mode.
const MASSLESS: f64 = 1e-14;

/// `α M + β K`, dashpots by `TᵀCT`, and modal ratios of the natural modes of the body, as far as the
/// coordinates have them: `Σ 2 ζ ω (Mφ)(Mφ)ᵀ`. `free` is `T` over the free dofs.
///
/// # Errors
/// [`SuperelementError::NoConvergence`].
pub(super) fn damping(
    prepared: &Prepared,
    reduced: &Reduced,
    free: MatRef<'_, f64>,
) -> Result<Mat<f64>, SuperelementError> {
    let r = reduced.columns.ncols();
    let rayleigh = prepared.rayleigh();
    let entry = |i: usize, k: usize| {
        rayleigh.alpha * reduced.mass[(i, k)] + rayleigh.beta * reduced.stiffness[(i, k)]
    };
    let mut damping = Mat::from_fn(r, r, entry);
    let dampers = prepared.body.model.pencil().dampers();
    if !dampers.is_empty() {
        damping += symmetric_part(dampers.project(free).as_ref());
    }
    let pencil = prepared.body.model.pencil();
    if prepared.ratios.is_empty() && !pencil.has_loss() {
        return Ok(damping);
    }
    match &reduced.natural {
        Some(eigenvalues) if !pencil.has_loss() => {
            let first = r - eigenvalues.len();
            let elastic = eigenvalues.iter().enumerate().filter(|(_, value)| **value > 0.0);
            for (mode, (place, value)) in elastic.enumerate() {
                let own = first + place;
                damping[(own, own)] += 2.0 * prepared.ratios.of(mode) * value.sqrt();
            }
        }
        _ => damping += of_ratios(prepared, reduced, free)?,
    }
    Ok(damping)
}

/// Damping by the ratios of the natural modes of the reduced body.
fn of_ratios(
    prepared: &Prepared,
    reduced: &Reduced,
    free: MatRef<'_, f64>,
) -> Result<Mat<f64>, SuperelementError> {
    let (values, axes) = symmetric_eigen(reduced.mass.as_ref())?;
    let largest = values.last().copied().unwrap_or(0.0);
    let kept: Vec<usize> = (0..values.len()).filter(|&k| values[k] > MASSLESS * largest).collect();
    let unit = Mat::from_fn(values.len(), kept.len(), |i, k| axes[(i, kept[k])] / values[kept[k]].sqrt());
    let stiffness = symmetric_part((unit.transpose() * &reduced.stiffness * &unit).as_ref());
    let (values, axes) = symmetric_eigen(stiffness.as_ref())?;
    let modes = &unit * &axes;
    let momenta = &reduced.mass * &modes;
    let pencil = prepared.body.model.pencil();
    let rigid = if pencil.rigid().is_some() { 6 } else { 0 };
    let elastic: Vec<usize> = (rigid..values.len()).collect();
    let shapes = free * modes.subcols(rigid, elastic.len());
    let ratios = prepared.modal_ratios(pencil, &values[rigid..], shapes.as_ref());
    let weighed = Mat::from_fn(momenta.nrows(), elastic.len(), |i, mode| {
        let place = elastic[mode];
        momenta[(i, place)] * (2.0 * ratios.of(mode) * values[place].sqrt()).sqrt()
    });
    Ok(symmetric_part((&weighed * weighed.transpose()).as_ref()))
}
