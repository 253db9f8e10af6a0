//! The basis: proper orthogonal decomposition of streamed snapshots, and the Ritz vectors closed under the
//! dynamics.
//!
//! Snapshots arrive in batches and are merged into a truncated factor `U Σ`, so memory grows with the vectors
//! kept and not with the snapshots seen. No n × n matrix appears: the inner product enters through the k × k
//! Gram matrix of a Euclidean QR factor (`S = Q R`, `QᵀWQ = L Lᵀ`, then the SVD of `LᵀR`). The SVD route is
//! used instead of the Gram matrix of the snapshots because that halves the digits, and because faer's
//! symmetric eigensolver loses small matrices (a displacement in metres squared is small).
//!
//! Source: chapter 5, eq. (5.7); `docs/explanation/` for the Ritz step.

use faer::prelude::*;
use faer::{Mat, MatRef};

use crate::linalg::NoConvergence;

/// A symmetric positive (semi)definite operator `W`, applied to all columns at once: `(x, y)` sets `y = W x`.
pub(crate) type Apply<'a> = &'a dyn Fn(MatRef<'_, f64>, faer::MatMut<'_, f64>);

/// A symmetric matrix as an operator.
pub(crate) fn apply(
    matrix: &crate::fem::SymmetricMatrix,
) -> impl Fn(MatRef<'_, f64>, faer::MatMut<'_, f64>) + '_ {
    |x, y| matrix.mul_into(x, y)
}

/// Singular values below this fraction of the largest are rounding, not information: the merge keeps ε·√n at
/// best.
const RANK_TOLERANCE: f64 = 1e-12;

/// A proper orthogonal decomposition: the best subspace for the snapshots in one inner product.
#[derive(Clone, Debug)]
#[doc(alias("proper orthogonal decomposition", "SVD"))]
pub struct Pod {
    /// `V`, shape (n, k), `VᵀWV = I`, most energetic first.
    pub vectors: Mat<f64>,
    /// Singular values of the snapshot matrix in the inner product, length k.
    pub singular_values: Vec<f64>,
    /// Squared W-norm of all snapshots, those truncated included.
    pub(crate) total_energy: f64,
    /// Number of snapshots seen.
    pub n_snapshots: usize,
}

impl Pod {
    /// Vectors that hold this fraction of the snapshots' squared norm, at least one.
    pub(crate) fn count_for_energy(&self, fraction: f64) -> usize {
        let mut kept = 0.0;
        let enough = self.singular_values.iter().position(|s| {
            kept += s * s;
            kept >= fraction * self.total_energy
        });
        enough.map_or(self.singular_values.len(), |i| i + 1)
    }
}

/// A decomposition under way.
pub struct StreamingPod<'a> {
    inner_product: Apply<'a>,
    max_rank: usize,
    pod: Pod,
    buffer: Mat<f64>,
    filled: usize,
}

impl<'a> StreamingPod<'a> {
    /// Starts with nothing seen; keeps at most `max_rank` vectors of length `n`.
    ///
    /// Memory: `n × (2 max_rank + batch)` numbers, with a batch as large as `max_rank` and at least 64.
    pub fn new(inner_product: Apply<'a>, n: usize, max_rank: usize) -> Self {
        let pod =
            Pod { vectors: Mat::zeros(n, 0), singular_values: vec![], total_energy: 0.0, n_snapshots: 0 };
        let buffer = Mat::zeros(n, max_rank.max(64));
        Self { inner_product, max_rank, pod, buffer, filled: 0 }
    }

    /// Adds snapshots, one per column.
    ///
    /// # Errors
    /// [`NoConvergence`]: snapshots with entries that are not finite numbers.
    pub fn push(&mut self, snapshots: MatRef<'_, f64>) -> Result<(), NoConvergence> {
        for j in 0..snapshots.ncols() {
            if self.filled == self.buffer.ncols() {
                self.merge()?;
            }
            self.buffer.col_mut(self.filled).copy_from(snapshots.col(j));
            self.filled += 1;
        }
        Ok(())
    }

    /// Ends the stream.
    ///
    /// # Errors
    /// As [`StreamingPod::push`].
    pub fn finish(mut self) -> Result<Pod, NoConvergence> {
        self.merge()?;
        Ok(self.pod)
    }

    /// Merges the buffer: SVD of `[U Σ | batch]` in the inner product.
    fn merge(&mut self) -> Result<(), NoConvergence> {
        if self.filled == 0 {
            return Ok(());
        }
        let n = self.buffer.nrows();
        let kept = self.pod.singular_values.len();
        let mut columns = Mat::zeros(n, kept + self.filled);
        for (j, &sigma) in self.pod.singular_values.iter().enumerate() {
            let target = columns.col_mut(j);
            zip!(target, self.pod.vectors.col(j)).for_each(|unzip!(t, v)| *t = sigma * v);
        }
        columns.subcols_mut(kept, self.filled).copy_from(self.buffer.subcols(0, self.filled));
        self.pod.n_snapshots += self.filled;
        let batch_energy = weighted_energy(self.inner_product, self.buffer.subcols(0, self.filled));
        self.pod.total_energy += batch_energy;
        self.filled = 0;
        let (vectors, mut singular_values) = weighted_svd(self.inner_product, columns.as_ref())?;
        let floor = RANK_TOLERANCE * singular_values.first().copied().unwrap_or(0.0);
        let rank = singular_values.iter().take_while(|&&s| s > floor).count().min(self.max_rank);
        singular_values.truncate(rank);
        self.pod.vectors = vectors.subcols(0, rank).to_owned();
        self.pod.singular_values = singular_values;
        Ok(())
    }
}

/// Sum of the squared W-norms of the columns.
fn weighted_energy(inner_product: Apply<'_>, columns: MatRef<'_, f64>) -> f64 {
    let mut weighted = Mat::zeros(columns.nrows(), columns.ncols());
    inner_product(columns, weighted.as_mut());
    let norms = (0..columns.ncols()).map(|j| columns.col(j).transpose() * weighted.col(j));
    norms.sum()
}

/// Left singular vectors and values of `columns` in the inner product `W`: `(V, σ)` with `VᵀWV = I`.
///
/// # Errors
/// [`NoConvergence`]: columns or an inner product that are not finite.
pub(super) fn weighted_svd(
    inner_product: Apply<'_>,
    columns: MatRef<'_, f64>,
) -> Result<(Mat<f64>, Vec<f64>), NoConvergence> {
    let scale = columns.norm_max();
    if scale == 0.0 {
        return Ok((Mat::zeros(columns.nrows(), 0), vec![]));
    }
    if !columns.is_all_finite() {
        return Err(NoConvergence { what: "the decomposition of the snapshots" });
    }
    // Unit size first: squares of micrometre displacements approach the underflow of the routines below.
    let scaled = columns * faer::Scale(1.0 / scale);
    let qr = scaled.qr();
    let q = qr.compute_thin_Q();
    let factor = lower_gram_factor(inner_product, q.as_ref())?;
    let small = factor.transpose() * qr.thin_R();
    let svd = match small.is_all_finite().then(|| small.thin_svd()) {
        Some(Ok(svd)) => svd,
        _ => return Err(NoConvergence { what: "the decomposition of the snapshots" }),
    };
    let mut rotation = svd.U().to_owned();
    factor.transpose().solve_upper_triangular_in_place(rotation.as_mut());
    let singular_values = svd.S().column_vector().iter().map(|s| s * scale).collect();
    Ok((q * rotation, singular_values))
}

/// `L` with `L Lᵀ = VᵀWV`.
///
/// A basis vector inside the null space of `W` has no length to normalise; the callers' operators are
/// definite on the free dofs, so the factorisation fails only on non-finite numbers and on columns that
/// depend on each other to rounding.
///
/// # Errors
/// [`NoConvergence`].
pub(super) fn lower_gram_factor(
    inner_product: Apply<'_>,
    vectors: MatRef<'_, f64>,
) -> Result<Mat<f64>, NoConvergence> {
    let gram = gram(inner_product, vectors, vectors);
    let factor = gram.llt(faer::Side::Lower);
    let factor = factor.map_err(|_| NoConvergence { what: "the lengths of the basis vectors" })?;
    Ok(factor.L().to_owned())
}

/// `AᵀWB`, symmetrised when `A` and `B` are the same columns.
pub(super) fn gram(inner_product: Apply<'_>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut weighted = Mat::zeros(b.nrows(), b.ncols());
    inner_product(b, weighted.as_mut());
    a.transpose() * weighted
}
