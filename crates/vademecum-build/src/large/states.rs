//! States that a strain map learns from: shapes of least energy at given coordinates.
//!
//! A force that begins at once, `F`, makes a linear body swing as `q_k(t) = φ_kᵀF/ω_k² (1 − cos ω_k t)`. The
//! states are drawn as such motions are at a random instant: a few forces at random places of the loadable
//! surface, every mode at a phase of its own, and all of it scaled to a displacement. The body is then
//! relaxed to static equilibrium with these coordinates prescribed: least energy under `VᵀM u = q`. So no
//! motion has to be marched, and what follows the coordinates without mass of its own is where it belongs.

use faer::{Mat, MatRef};

use crate::fem::GreenStrain;
use crate::linalg::{Random, transposed_product, unit};

/// Full-order training states with their coordinates.
#[derive(Clone, Debug)]
pub(crate) struct TrainingStates {
    /// `VᵀM u`, shape (R, states).
    pub(crate) coordinates: Mat<f64>,
    /// The full strains, shape (strains, states).
    pub(crate) strains: Mat<f64>,
    /// Their energies, `½|z|²`.
    pub(crate) energies: Vec<f64>,
}

/// Draws coordinates of natural modes: shape (modes, count). `moving` are the modes at the loadable nodes,
/// shape (3 × nodes, modes); the largest displacement there is uniform between a tenth of `largest` \[m\] and
/// all of it.
pub fn draw(moving: MatRef<'_, f64>, eigenvalues: &[f64], largest: f64, count: usize, seed: u64) -> Mat<f64> {
    const FORCES: usize = 3;
    let r = moving.ncols();
    let still = |node: usize| (0..3).all(|c| (0..r).all(|k| moving[(3 * node + c, k)] == 0.0));
    let nodes: Vec<usize> = (0..moving.nrows() / 3).filter(|&node| !still(node)).collect();
    let mut random = Random::new(seed);
    let mut drawn = Mat::zeros(r, count);
    for s in 0..count {
        let mut q = vec![0.0; r];
        for _ in 0..1 + random.below(FORCES) {
            let node = nodes[random.below(nodes.len())];
            let force = unit(std::array::from_fn(|_| random.uniform() - 0.5));
            for (k, q) in q.iter_mut().enumerate() {
                let push: f64 = (0..3).map(|c| moving[(3 * node + c, k)] * force[c]).sum();
                let phase = std::f64::consts::TAU * random.uniform();
                *q += push / eigenvalues[k] * (1.0 - phase.cos());
            }
        }
        let moved = |node: usize| -> f64 {
            let part = |c: usize| (0..r).map(|k| moving[(3 * node + c, k)] * q[k]).sum::<f64>();
            (0..3).map(|c| part(c).powi(2)).sum::<f64>().sqrt()
        };
        let most = nodes.iter().copied().map(moved).fold(f64::MIN_POSITIVE, f64::max);
        let scale = largest * (0.1 + 0.9 * random.uniform()) / most;
        (0..r).for_each(|k| drawn[(k, s)] = scale * q[k]);
    }
    drawn
}

impl TrainingStates {
    /// States as displacements, in the coordinates `VᵀM u` of a basis with momenta `MV`.
    pub(crate) fn new(
        strain: &GreenStrain<'_>,
        momenta: MatRef<'_, f64>,
        states: &[Vec<f64>],
    ) -> TrainingStates {
        let n = strain.n_dof();
        let displacements = Mat::from_fn(n, states.len(), |i, s| states[s][i]);
        let coordinates = transposed_product(momenta, displacements.as_ref());
        let mut strains = Mat::zeros(strain.n_rows(), states.len());
        for (s, u) in states.iter().enumerate() {
            strain.strain(u, strains.col_as_slice_mut(s));
        }
        let energy = |s: usize| 0.5 * strains.col_as_slice(s).iter().map(|z| z * z).sum::<f64>();
        let energies = (0..states.len()).map(energy).collect();
        TrainingStates { coordinates, strains, energies }
    }
}
