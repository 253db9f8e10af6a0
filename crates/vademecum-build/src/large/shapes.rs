//! Shapes of least energy at coordinates of natural modes, which a stopped build finds again.

use std::sync::atomic::{AtomicUsize, Ordering};

use faer::MatRef;

use super::prediction::Prediction;
use crate::dynamics::large::{LargeError, Newton, Relaxation};
use crate::fem::{Factor, GreenStrain, SOFTENING, Symbolic};
use crate::parallel;
use crate::progress::Listener;
use crate::store::StageCache;

/// Maximum number of halvings of coordinates.
const HALVINGS: i32 = 5;
/// Tolerance of Newton's method: its last correction, which is still made, squares this.
const TOLERANCE: f64 = 1e-5;
/// States that are kept together: what a stopped build loses at most.
const TOGETHER: usize = 64;

/// [`relaxed`], a few states at a time, each of which is kept.
///
/// # Errors
/// As [`relaxed`].
pub(super) fn kept_states(
    kept: &StageCache<'_>,
    strain: &GreenStrain<'_>,
    (modes, eigenvalues): (MatRef<'_, f64>, &[f64]),
    (symbolic, factor): (&Symbolic, &Factor),
    drawn: MatRef<'_, f64>,
) -> Result<Vec<Vec<f64>>, LargeError> {
    let (mut states, mut prediction) = (vec![], None);
    for (part, first) in (0..drawn.ncols()).step_by(TOGETHER).enumerate() {
        let drawn = drawn.subcols(first, TOGETHER.min(drawn.ncols() - first));
        let name = format!("states-{}-{}", modes.ncols(), part + 1);
        let relax = || {
            let predict = || Prediction::new(strain, (modes, eigenvalues), (symbolic, factor));
            relaxed(prediction.get_or_insert_with(predict), symbolic, drawn, kept.listener)
        };
        states.extend(kept.stage(&name, |inputs| inputs.matrix(modes).matrix(drawn), relax)?);
    }
    Ok(states)
}

/// The static equilibria at prescribed coordinates of natural modes (one a column), as displacements over the
/// free dofs, each searched for from its prediction. Coordinates at which none is found, or in which some
/// element is compressed to less than [`SOFTENING`], are halved; after a few halvings the state is left out.
///
/// # Errors
/// [`LargeError`]: a body without supports, memory.
pub(crate) fn relaxed(
    prediction: &Prediction<'_>,
    symbolic: &Symbolic,
    drawn: MatRef<'_, f64>,
    listener: &dyn Listener,
) -> Result<Vec<Vec<f64>>, LargeError> {
    let (strain, modes) = (prediction.strain, prediction.modes);
    let done = AtomicUsize::new(0);
    let newton = Newton { tolerance: TOLERANCE, ..Newton::default() };
    let at_rest = Relaxation::new(strain, symbolic, modes, newton)?;
    let of = |s: usize| {
        let mut found = None;
        for halvings in 0..HALVINGS {
            let scale = 0.5_f64.powi(halvings);
            let q: Vec<f64> = drawn.col(s).iter().map(|q| scale * q).collect();
            let mut relaxation = at_rest.clone();
            match relaxation.relax(Some(prediction.at(&q)), &q) {
                Ok(shape) if strain.least_stretch(&shape.displacement) >= SOFTENING => {
                    found = Some(shape.displacement);
                    break;
                }
                Ok(_) | Err(LargeError::NoShape { .. }) => {}
                Err(error) => return Err(error),
            }
        }
        listener.checkpoint(1 + done.fetch_add(1, Ordering::Relaxed), drawn.ncols())?;
        Ok(found)
    };
    let found = parallel::try_map(drawn.ncols(), &of)?;
    Ok(found.into_iter().flatten().collect())
}
