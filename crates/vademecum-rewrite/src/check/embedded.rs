//! Checks of the embedded surface: its three sections together, weights that sum to 1.

use vademecum_format::{File, SectionKind};

use super::super::error::{Fault, RewriteError};
use super::super::numbers::{reals_of, unsound};

/// Largest distance of the sum of four weights from 1, in the largest of them: single precision passes.
const TOLERANCE: f64 = 1e-6;

pub(super) fn check(file: &File<'_>) -> Result<(), RewriteError> {
    use SectionKind as S;
    let kinds = [S::EmbeddedNodes, S::EmbeddedWeights, S::EmbeddedTriangles];
    let Some(there) = kinds.into_iter().find(|kind| file.section(*kind).is_some()) else { return Ok(()) };
    if let Some(missing) = kinds.into_iter().find(|kind| file.section(*kind).is_none()) {
        let reason = format!("without section {} ({missing}) it draws nothing", missing.number());
        return Err(unsound(there, Fault::Disagrees, reason));
    }
    let rows = |kind| file.section(kind).map_or(0, |section| section.shape()[0]);
    let [vertices, weights] = [rows(S::EmbeddedNodes), rows(S::EmbeddedWeights)];
    if vertices != weights {
        let reason = format!("it has the weights of {weights} vertices; section 76 has {vertices}");
        return Err(unsound(S::EmbeddedWeights, Fault::Disagrees, reason));
    }
    let numbers = reals_of(file, S::EmbeddedWeights)?.unwrap_or_default();
    for (vertex, weights) in numbers.as_chunks::<4>().0.iter().enumerate() {
        let largest = weights.iter().fold(1.0, |largest: f64, weight| largest.max(weight.abs()));
        let sum: f64 = weights.iter().sum();
        if (sum - 1.0).abs() > TOLERANCE * largest {
            let reason = format!("the weights of vertex {vertex} sum to {sum}; expected 1");
            return Err(unsound(S::EmbeddedWeights, Fault::Disagrees, reason));
        }
    }
    Ok(())
}
