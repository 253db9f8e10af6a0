//! States that a stopped build finds again.

use faer::MatRef;

use super::prediction::Prediction;
use super::states::relaxed;
use crate::dynamics::large::LargeError;
use crate::fem::{Factor, GreenStrain, Symbolic};
use crate::store::Kept;

/// States that are kept together: what a stopped build loses at most.
const TOGETHER: usize = 64;

/// [`relaxed`], a few states at a time, each of which is kept.
///
/// # Errors
/// As [`relaxed`].
pub(super) fn kept_states(
    kept: &Kept<'_>,
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
