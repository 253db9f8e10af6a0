//! The answer at full order to forces that swing: one complex solve for each frequency.
//!
//! `(K + iω(αM + βK) − ω²M) u = f` by a sparse LU factorisation of the complex matrix. It is slow and assumes
//! nothing of the modes, so it is what a frequency response from modes is compared with.

use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::{Mat, c64};
use rayon::prelude::*;

use super::Rayleigh;
use crate::fem::Pencil;
use crate::progress::{Cancelled, Listener};

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum HarmonicError {
    /// On request.
    #[error("the response to a harmonic force")]
    Cancelled(#[from] Cancelled),
    /// No memory to order the elimination.
    #[error("the complex matrix of the full order does not fit into memory")]
    Memory,
    /// The matrix does not factorise: an undamped body at one of its natural frequencies, or no memory.
    #[error(
        "the full order has no answer at {frequency} Hz: it swings freely there, or its factor does not fit"
    )]
    Factor {
        /// The frequency \[Hz\].
        frequency: f64,
    },
}

/// Complex amplitude of the displacement along each of `rows` under the force `force` of amplitude 1, at each
/// frequency \[Hz\]; shape (frequencies, rows). A row is a list of free dofs and weights. Of a body without
/// supports it is the elastic part: what accelerates the body as a whole is taken off the force.
///
/// # Errors
/// [`HarmonicError`].
pub fn harmonic(
    pencil: &Pencil,
    damping: Rayleigh,
    force: &[f64],
    rows: &[Vec<(u32, f64)>],
    frequencies: &[f64],
    listener: &dyn Listener,
) -> Result<Vec<Vec<c64>>, HarmonicError> {
    let (mass, stiffness) = (pencil.mass(), pencil.stiffness());
    let (pattern, n) = (mass.pattern(), pencil.n_dof());
    let starts: Vec<usize> =
        std::iter::once(0).chain((0..n).map(|column| pattern.range(column).end)).collect();
    let places = (0..n).flat_map(|column| pattern.rows_of(column).iter().map(|&row| row as usize)).collect();
    let symbolic = SymbolicSparseColMat::new_checked(n, n, starts, None, places);
    // The order of elimination is the same for all frequencies.
    let order = SymbolicLu::try_new(symbolic.as_ref()).map_err(|_| HarmonicError::Memory)?;
    let mut elastic = Mat::from_fn(n, 1, |row, _| force[row]);
    if let Some(rigid) = pencil.rigid() {
        rigid.relieve(elastic.as_mut());
    }
    let force = Mat::from_fn(n, 1, |row, _| c64::new(elastic[(row, 0)], 0.0));
    let done = std::sync::atomic::AtomicUsize::new(0);
    let at = |&frequency: &f64| -> Result<Vec<c64>, HarmonicError> {
        if listener.cancelled() {
            return Err(Cancelled.into());
        }
        let omega = std::f64::consts::TAU * frequency;
        let of_mass = c64::new(-omega * omega, omega * damping.alpha);
        let of_stiffness = c64::new(1.0, omega * damping.beta);
        let entries = mass.values().iter().zip(stiffness.values());
        let values = entries.map(|(&m, &k)| of_mass * m + of_stiffness * k).collect();
        let matrix = SparseColMat::new(symbolic.clone(), values);
        let failed = HarmonicError::Factor { frequency };
        let factor = Lu::try_new_with_symbolic(order.clone(), matrix.as_ref());
        let Ok(factor) = factor else { return Err(failed) };
        let answer = factor.solve(&force);
        let along = |row: &Vec<(u32, f64)>| {
            row.iter()
                .fold(c64::new(0.0, 0.0), |sum, &(dof, weight)| sum + answer[(dof as usize, 0)] * weight)
        };
        let found: Vec<c64> = rows.iter().map(along).collect();
        if !found.iter().all(|x| x.re.is_finite() && x.im.is_finite()) {
            return Err(failed);
        }
        listener.advance(1 + done.fetch_add(1, std::sync::atomic::Ordering::Relaxed), frequencies.len());
        Ok(found)
    };
    frequencies.par_iter().map(at).collect()
}
