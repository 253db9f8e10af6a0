//! Operators on one axis.

use super::linalg::dot;
use faer::{Mat, MatRef};

/// A symmetric operator on one axis: diagonal, or tridiagonal as hat functions make them.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisOperator {
    lower: Vec<f64>,
    diagonal: Vec<f64>,
    upper: Vec<f64>,
}

impl AxisOperator {
    /// `diag(d)`.
    pub fn diagonal(diagonal: Vec<f64>) -> AxisOperator {
        AxisOperator { lower: Vec::new(), diagonal, upper: Vec::new() }
    }

    /// With `lower[j]` at `(j+1, j)` and `upper[j]` at `(j, j+1)`, each one shorter than the diagonal.
    pub(crate) fn tridiagonal(lower: Vec<f64>, diagonal: Vec<f64>, upper: Vec<f64>) -> AxisOperator {
        assert!(
            lower.len() + 1 == diagonal.len() && upper.len() + 1 == diagonal.len(),
            "lengths of the diagonals"
        );
        AxisOperator { lower, diagonal, upper }
    }

    /// Number of points.
    pub(super) fn len(&self) -> usize {
        self.diagonal.len()
    }

    /// `(lower, diagonal, upper)`; the outer two are empty for a diagonal operator.
    pub(crate) fn parts(&self) -> (&[f64], &[f64], &[f64]) {
        (&self.lower, &self.diagonal, &self.upper)
    }

    /// `A g`.
    pub fn apply(&self, g: &[f64]) -> Vec<f64> {
        let mut out: Vec<f64> = self.diagonal.iter().zip(g).map(|(d, x)| d * x).collect();
        for (j, (l, u)) in self.lower.iter().zip(&self.upper).enumerate() {
            out[j + 1] += l * g[j];
            out[j] += u * g[j + 1];
        }
        out
    }

    /// `A G`, column by column.
    pub(crate) fn apply_all(&self, g: MatRef<'_, f64>) -> Mat<f64> {
        let mut out = Mat::zeros(g.nrows(), g.ncols());
        for i in 0..g.ncols() {
            let column: Vec<f64> = (0..g.nrows()).map(|j| g[(j, i)]).collect();
            self.apply(&column).into_iter().enumerate().for_each(|(j, v)| out[(j, i)] = v);
        }
        out
    }

    /// `gᵀ A h`.
    pub(crate) fn bilinear(&self, g: &[f64], h: &[f64]) -> f64 {
        dot(g, &self.apply(h))
    }

    /// `A ← A + w B`.
    pub(crate) fn add(&mut self, w: f64, other: &AxisOperator) {
        if self.lower.is_empty() && !other.lower.is_empty() {
            self.lower = vec![0.0; other.lower.len()];
            self.upper = self.lower.clone();
        }
        let add = |to: &mut [f64], from: &[f64]| to.iter_mut().zip(from).for_each(|(t, f)| *t += w * f);
        add(&mut self.diagonal, &other.diagonal);
        add(&mut self.lower, &other.lower);
        add(&mut self.upper, &other.upper);
    }

    /// `A⁻¹ r` by elimination without pivoting, which positive definite operators do not need.
    pub(crate) fn solve(&self, mut r: Vec<f64>) -> Vec<f64> {
        let n = r.len();
        let mut pivot = self.diagonal.clone();
        if !self.lower.is_empty() {
            for j in 1..n {
                let l = self.lower[j - 1] / pivot[j - 1];
                pivot[j] -= l * self.upper[j - 1];
                r[j] -= l * r[j - 1];
            }
            r[n - 1] /= pivot[n - 1];
            for j in (0..n - 1).rev() {
                r[j] = (r[j] - self.upper[j] * r[j + 1]) / pivot[j];
            }
            return r;
        }
        r.iter_mut().zip(&pivot).for_each(|(r, p)| *r /= p);
        r
    }
}
