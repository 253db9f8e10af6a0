//! Dense helpers that every stage shares: one generator of numbers, symmetric parts, matrices under serde.

mod random;
pub(crate) mod stored;

pub(crate) use random::LoadDraw;
pub use random::Random;

use faer::{Mat, MatMut, MatRef};

/// A dense decomposition that met what it cannot decompose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{what} did not converge: a number left the range of double precision; are units, materials, `time.step` and \
     ranges of a sensible size beside each other?"
)]
pub struct NoConvergence {
    /// What was looked for.
    pub what: &'static str,
}

/// `½ (A + Aᵀ)`, shape (n, n): what rounding took from a product that is symmetric in exact arithmetic.
pub(crate) fn symmetric_part(a: MatRef<'_, f64>) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| 0.5 * (a[(i, j)] + a[(j, i)]))
}

/// `v / ‖v‖`; NaN for a zero vector.
pub(crate) fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / length)
}

/// `VᵀF`, length r: what a force over the rows of `V` does along its columns.
pub fn project(vectors: MatRef<'_, f64>, force: &[f64]) -> Vec<f64> {
    let dot = |k: usize| force.iter().enumerate().map(|(i, f)| f * vectors[(i, k)]).sum();
    (0..vectors.ncols()).map(dot).collect()
}

/// A matrix in groups of `width` columns, the last one of what is left: for threads that each write their
/// own.
pub(crate) fn column_groups(mut x: MatMut<'_, f64>, width: usize) -> Vec<MatMut<'_, f64>> {
    let mut groups = vec![];
    while x.ncols() > width {
        let (group, rest) = x.split_at_col_mut(width);
        groups.push(group);
        x = rest;
    }
    groups.push(x);
    groups
}

/// The same by rows, `height` at a time.
pub(crate) fn row_groups(mut x: MatMut<'_, f64>, height: usize) -> Vec<MatMut<'_, f64>> {
    let mut groups = vec![];
    while x.nrows() > height {
        let (group, rest) = x.split_at_row_mut(height);
        groups.push(group);
        x = rest;
    }
    groups.push(x);
    groups
}
