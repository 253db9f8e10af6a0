//! The equations that Newton's method solves: a stage of a time scheme (or rest, a stage without inertia),
//! and a step of the energy-momentum scheme.

use super::vectors::{add, dot, sum, times};
use crate::fem::{GreenStrain, SymmetricMatrix};

/// Equations in the increment `δ` of a displacement.
pub(super) trait Balance {
    /// `r ← r(δ)`, the force that is missing.
    fn residual(&mut self, increment: &[f64], r: &mut [f64]);

    /// The derivative at the last increment whose residual was asked for, or a symmetric matrix near it; with
    /// `pulled`, a positive definite one. The stress in it is that of [`predict`](Self::predict), if one was
    /// made.
    fn tangent(&self, pulled: bool) -> SymmetricMatrix;

    /// Sets the stress of the next tangent to what it is beyond the last increment by `p`, were it linear;
    /// `None` takes the true stress from now on.
    fn predict(&mut self, p: Option<&[f64]>);

    /// An energy that residual times increment is small against.
    fn scale(&self) -> f64;
}

/// `r = A δ − b + G(u)ᵀ (c z(u) + h)` with `u = u₀ + δ`: the gradient of a potential. With `midpoint`, `G` is
/// that at `u₀ + δ/2`, where it is not.
///
/// The derivative at the midpoint is not symmetric. With `D = 2 E₂(δ/2, ·)` it has `Gᵀ(G + D)`, whose
/// symmetric part is `(G + D/2)ᵀ(G + D/2) − DᵀD/4`, so it is `GᵀG` at `u₀ + ¾ δ` but for the square of the
/// increment. What is left out is of the first order in the rotation of one step.
pub(super) struct StageBalance<'a> {
    pub(crate) strain: &'a GreenStrain<'a>,
    pub(crate) start: &'a [f64],
    pub(crate) midpoint: bool,
    /// `A`, of mass and stiffness at rest; none at rest.
    pub(crate) linear: Option<SymmetricMatrix>,
    /// `b`.
    pub(crate) force: Vec<f64>,
    /// `c`.
    pub(crate) weight: f64,
    /// `h`; empty where there is none.
    pub(crate) history: Vec<f64>,
    /// Energy in addition to that of the strain, in the unit of `r δ`.
    pub(crate) energy: f64,
    pub(crate) last: LastPoint,
}

/// The point of the last residual.
#[derive(Default)]
pub(super) struct LastPoint {
    increment: Vec<f64>,
    /// `z(u)`.
    pub(crate) strain: Vec<f64>,
    /// `c z + h`.
    stress: Vec<f64>,
    /// The stress of the next tangent, where it is another.
    predicted: Option<Vec<f64>>,
    energy: f64,
}

impl StageBalance<'_> {
    /// `u` of the last residual.
    pub(crate) fn displacement(&self) -> Vec<f64> {
        sum(self.start, 1.0, &self.last.increment)
    }
}

impl Balance for StageBalance<'_> {
    fn residual(&mut self, increment: &[f64], r: &mut [f64]) {
        let last = &mut self.last;
        last.increment.clear();
        last.increment.extend_from_slice(increment);
        let displacement = sum(self.start, 1.0, increment);
        last.strain.resize(self.strain.n_rows(), 0.0);
        self.strain.strain(&displacement, &mut last.strain);
        last.stress = last.strain.iter().map(|z| self.weight * z).collect();
        add(&mut last.stress, 1.0, &self.history);
        if self.midpoint {
            self.strain.transpose(&sum(self.start, 0.5, increment), &last.stress, r);
        } else {
            self.strain.transpose(&displacement, &last.stress, r);
        }
        add(r, -1.0, &self.force);
        last.energy = 0.5 * self.weight * dot(&last.strain, &last.strain);
        if let Some(linear) = &self.linear {
            let inertia = times(linear, increment);
            add(r, 1.0, &inertia);
            last.energy += 0.5 * dot(increment, &inertia);
        }
    }

    fn tangent(&self, pulled: bool) -> SymmetricMatrix {
        let LastPoint { increment, stress, predicted, .. } = &self.last;
        let stress = predicted.as_ref().unwrap_or(stress);
        let elastic = if self.midpoint {
            let half: Vec<f64> = stress.iter().map(|z| 0.5 * z).collect();
            self.strain.weighted_tangent(&sum(self.start, 0.75, increment), self.weight, &half, pulled)
        } else {
            self.strain.weighted_tangent(&self.displacement(), self.weight, stress, pulled)
        };
        match &self.linear {
            Some(linear) => SymmetricMatrix::combine(&[(1.0, linear), (1.0, &elastic)]),
            None => elastic,
        }
    }

    fn predict(&mut self, p: Option<&[f64]>) {
        let Some(p) = p else {
            self.last.predicted = None;
            return;
        };
        let mut change = vec![0.0; self.strain.n_rows()];
        self.strain.rate(&self.displacement(), p, &mut change);
        self.last.predicted = Some(sum(&self.last.stress, self.weight, &change));
    }

    fn scale(&self) -> f64 {
        self.energy + self.last.energy
    }
}
