//! Static correction of the stress: `S R F`, with `S` the rows of the stress.

use super::basis::ResidualBasis;
use super::complement::ResidualOperator;
use super::error::ResidualError;
use super::sweep::answers;
use crate::fem::{COMPONENTS, StressRows};
use crate::progress::Listener;

/// Stress of `R`, where a file keeps it.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
#[doc(alias = "static correction of the stress")]
pub(crate) struct StressFlexibility {
    /// Per point and loadable node the stress under unit forces \[Pa/N\]: row the component of stress, column
    /// that of the force. Empty where it was not asked for.
    pub(crate) contacts: Vec<Vec<[f64; 3 * COMPONENTS]>>,
    /// Per pattern and point the stress of `R F_p` \[Pa\].
    pub(crate) patterns: Vec<Vec<[f64; COMPONENTS]>>,
}

impl StressFlexibility {
    /// Takes off the stress of a strain that makes none: that of each pattern at each point, if it has any.
    pub(crate) fn less(&mut self, free: &[Vec<[f64; COMPONENTS]>]) {
        for (own, free) in self.patterns.iter_mut().zip(free) {
            for (own, free) in own.iter_mut().zip(free) {
                own.iter_mut().zip(free).for_each(|(own, free)| *own -= free);
            }
        }
    }
}

/// The stress of `R` at points under each pattern and, if `contacts`, under forces at the given nodes.
///
/// One solve for each pattern and, `R` being symmetric, one for each component of each point.
///
/// # Errors
/// [`ResidualError`].
pub(crate) fn stress_residual(
    reduced: &ResidualBasis<'_>,
    rows: &StressRows,
    nodes: &[u32],
    contacts: bool,
    listener: &dyn Listener,
) -> Result<StressFlexibility, ResidualError> {
    let body = reduced.body;
    let complement = ResidualOperator::new(reduced)?;
    let copy = |place: usize, load: &mut [f64]| load.copy_from_slice(&body.patterns[place].1);
    let patterns = answers(&complement, body.patterns.len(), copy, listener, |column| {
        (0..rows.points.len()).map(|place| rows.stress(place, |node| complement.row(column, node))).collect()
    })?;
    if !contacts {
        return Ok(StressFlexibility { contacts: vec![], patterns });
    }
    let row = |place: usize, load: &mut [f64]| {
        for (node, block) in &rows.rows[place / COMPONENTS] {
            for (c, weight) in block[place % COMPONENTS].iter().enumerate() {
                for (free, share) in complement.terms(*node, c) {
                    load[free] += share * weight;
                }
            }
        }
    };
    let found = answers(&complement, COMPONENTS * rows.points.len(), row, listener, |column| {
        nodes.iter().map(|&node| complement.row(column, node)).collect::<Vec<[f64; 3]>>()
    })?;
    let of_point = |components: &[Vec<[f64; 3]>]| {
        let at = |node: usize| std::array::from_fn(|k| components[k / 3][node][k % 3]);
        (0..nodes.len()).map(at).collect()
    };
    Ok(StressFlexibility { contacts: found.chunks_exact(COMPONENTS).map(of_point).collect(), patterns })
}
