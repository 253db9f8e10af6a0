//! Damping of modes: Rayleigh's, and a ratio of each beside it that stays with its mode.

use crate::kernels::dense::at;
use crate::parametric::coupling::Mode;

/// Eigenvalues closer than this share are equal to a divided difference.
const CLOSE: f64 = 1e-6;

/// Modes with their damping.
#[derive(Clone, Copy)]
pub(crate) struct Damped<'d, R> {
    pub eigenvalues: &'d [f64],
    /// Damping ratio of a mode beside Rayleigh's damping.
    pub ratio: R,
    pub alpha: f64,
    pub beta: f64,
}

impl<R: Fn(usize) -> f64> Damped<'_, R> {
    fn omega(&self, k: usize) -> f64 {
        libm::sqrt(at(self.eigenvalues, k))
    }

    /// Mode `k`.
    pub fn mode(&self, k: usize) -> Mode {
        let (lambda, ratio) = (at(self.eigenvalues, k), (self.ratio)(k));
        Mode { lambda, damping: self.alpha + self.beta * lambda + 2.0 * ratio * self.omega(k) }
    }

    /// Divided difference of the damping rates over the eigenvalues of two modes; their derivative for equal
    /// ones.
    pub fn rate(&self, i: usize, j: usize) -> f64 {
        let (a, b) = (at(self.eigenvalues, i), at(self.eigenvalues, j));
        let [ratio_i, ratio_j] = [i, j].map(&self.ratio);
        let [omega_i, omega_j] = [i, j].map(|k| self.omega(k));
        if ratio_i == 0.0 && ratio_j == 0.0 {
            return self.beta;
        }
        let added = if (a - b).abs() <= CLOSE * a.max(b) {
            (ratio_i + ratio_j) / (omega_i + omega_j)
        } else {
            2.0 * (ratio_i * omega_i - ratio_j * omega_j) / (a - b)
        };
        self.beta + added
    }
}
