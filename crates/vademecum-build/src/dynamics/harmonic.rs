//! Frequency response at full order: one solve for each frequency, the reference of responses from modes.
//!
//! `(K + iω(αM + βK) − ω²M) u = f` with the symmetric matrices `A = K − ω²M` and `B = ω(αM + βK)` is the real
//! symmetric indefinite system
//!
//! ```text
//! [ A  −B] [Re u]   [f]
//! [−B  −A] [Im u] = [0]
//! ```
//!
//! with the two rows of a dof side by side: one factorisation LBLᵀ under the elimination order of the
//! stiffness, pivots within the supernodes, and steps of iterative refinement until the correction is small.
//! It assumes nothing of the modes. Dashpots between dofs that share an element add to `B`; the others are
//! rows `D` outside of its pattern, and join by `(Z + iωDDᵀ)⁻¹ = Z⁻¹ − Z⁻¹D (1/(iω) + DᵀZ⁻¹D)⁻¹ DᵀZ⁻¹`
//! (Woodbury 1950).

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, Mat, MatMut, Par, Side, c64};

use super::Rayleigh;
use crate::fem::{Pencil, elimination_order};
use crate::linalg::{dot, solve_dense};
use crate::parallel;
use crate::progress::{Cancelled, Listener};

/// Largest last correction of an answer, over the answer.
const CORRECTION: f64 = 1e-9;
/// Steps of refinement.
const REFINEMENTS: usize = 8;

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
    let mut elastic = Mat::from_fn(pencil.n_dof(), 1, |row, _| force[row]);
    if let Some(rigid) = pencil.rigid() {
        rigid.relieve(elastic.as_mut());
    }
    let force: Vec<f64> = elastic.col(0).iter().flat_map(|&f| [f, 0.0]).collect();
    // The order of elimination is the same for all frequencies.
    let system = HarmonicSystem::new(pencil)?;
    let done = std::sync::atomic::AtomicUsize::new(0);
    let at = |place: usize| -> Result<Vec<c64>, HarmonicError> {
        let frequency = frequencies[place];
        if listener.cancelled() {
            return Err(Cancelled.into());
        }
        let omega = std::f64::consts::TAU * frequency;
        let Some(answer) = system.damped(omega, damping, &force) else {
            return Err(HarmonicError::Factor { frequency });
        };
        let along = |row: &Vec<(u32, f64)>| {
            let part = |part: usize| row.iter().map(|&(dof, w)| w * answer[2 * dof as usize + part]).sum();
            c64::new(part(0), part(1))
        };
        listener.advance(1 + done.fetch_add(1, std::sync::atomic::Ordering::Relaxed), frequencies.len());
        Ok(rows.iter().map(along).collect())
    };
    parallel::try_map(frequencies.len(), &at)
}

/// Free dofs and weights of a dashpot.
type DashpotRow<'a> = &'a [(u32, f64)];

/// The real symmetric system of a pencil, two rows for each dof.
struct HarmonicSystem<'a> {
    pencil: &'a Pencil,
    pattern: SymbolicSparseColMat<usize>,
    order: SymbolicCholesky<usize>,
    /// Damping by dashpots at the entries of the matrices.
    dashpots: Vec<f64>,
    /// Rows of the others, with entries that the matrices do not have.
    outside: Vec<DashpotRow<'a>>,
}

impl<'a> HarmonicSystem<'a> {
    fn new(pencil: &'a Pencil) -> Result<Self, HarmonicError> {
        let (of_dofs, n) = (pencil.mass().pattern(), pencil.n_dof());
        let mut starts = vec![0];
        let mut places = vec![];
        for column in 0..2 * n {
            let rows = of_dofs.rows_of(column / 2).iter().map(|&row| 2 * row as usize);
            places.extend(rows.flat_map(|row| [row, row + 1]));
            starts.push(places.len());
        }
        let pattern = SymbolicSparseColMat::new_checked(2 * n, 2 * n, starts, None, places);
        let doubled = |dofs: Vec<u32>| -> Vec<usize> {
            dofs.into_iter().flat_map(|dof| [2 * dof as usize, 2 * dof as usize + 1]).collect()
        };
        let order = elimination_order(pencil).map(|(old, new)| (doubled(old), doubled(new)));
        let order = order.as_ref().map(|(old, new)| PermRef::new_checked(old, new, 2 * n));
        let order = order.map_or(SymmetricOrdering::Amd, SymmetricOrdering::Custom);
        // Pivots are sought in supernodes only.
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let order = factorize_symbolic_cholesky(pattern.as_ref(), Side::Lower, order, params)
            .map_err(|_| HarmonicError::Memory)?;
        let (dashpots, outside) = dashpots(pencil);
        Ok(Self { pencil, pattern, order, dashpots, outside })
    }

    /// Answer with all dashpots, as [`HarmonicSystem::solve`] gives it.
    fn damped(&self, omega: f64, damping: Rayleigh, force: &[f64]) -> Option<Vec<f64>> {
        let rows = self.outside.iter().map(|row| {
            let mut column = vec![0.0; force.len()];
            row.iter().for_each(|&(dof, weight)| column[2 * dof as usize] += weight);
            column
        });
        let forces: Vec<Vec<f64>> = std::iter::once(force.to_vec()).chain(rows).collect();
        let mut answers = self.solve(omega, damping, &forces)?;
        let columns = answers.split_off(1);
        let mut answer = answers.pop()?;
        let k = columns.len();
        if k == 0 {
            return Some(answer);
        }
        let along = |row: &[(u32, f64)], x: &[f64], part: usize| -> f64 {
            row.iter().map(|&(dof, weight)| weight * x[2 * dof as usize + part]).sum()
        };
        // Real part above imaginary part; 1/(iω) is −i/ω.
        let entry = |i: usize, j: usize| {
            let of = |part| along(self.outside[i % k], &columns[j % k], part);
            let own = if i % k == j % k { 1.0 / omega } else { 0.0 };
            match (i < k, j < k) {
                (true, true) | (false, false) => of(0),
                (true, false) => own - of(1),
                (false, true) => of(1) - own,
            }
        };
        let matrix = Mat::from_fn(2 * k, 2 * k, entry);
        let right = Mat::from_fn(2 * k, 1, |i, _| along(self.outside[i % k], &answer, usize::from(i >= k)));
        let forces = solve_dense(matrix.as_ref(), right.as_ref());
        for (j, column) in columns.iter().enumerate() {
            let (re, im) = (forces[(j, 0)], forces[(k + j, 0)]);
            for (out, x) in answer.as_chunks_mut::<2>().0.iter_mut().zip(column.as_chunks::<2>().0) {
                out[0] -= re * x[0] - im * x[1];
                out[1] -= re * x[1] + im * x[0];
            }
        }
        Some(answer)
    }

    /// Numbers of the matrix at `omega` \[rad/s\].
    fn values(&self, omega: f64, damping: Rayleigh) -> Vec<f64> {
        let (mass, stiffness) = (self.pencil.mass(), self.pencil.stiffness());
        let mut values = Vec::with_capacity(4 * mass.values().len());
        for column in 0..self.pencil.n_dof() {
            let own = mass.pattern().range(column);
            let entries =
                || own.clone().map(|at| (mass.values()[at], stiffness.values()[at], self.dashpots[at]));
            let conservative = |m: f64, k: f64| k - omega * omega * m;
            let dissipative = |m: f64, k: f64, c: f64| omega * (damping.alpha * m + damping.beta * k + c);
            values.extend(entries().flat_map(|(m, k, c)| [conservative(m, k), -dissipative(m, k, c)]));
            values.extend(entries().flat_map(|(m, k, c)| [-dissipative(m, k, c), -conservative(m, k)]));
        }
        values
    }

    /// Real and imaginary part of each dof in turn under each of some forces, without the dashpots outside of
    /// the pattern; `None` of a singular matrix or without memory.
    fn solve(&self, omega: f64, damping: Rayleigh, forces: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
        let (n, values) = (2 * self.pencil.n_dof(), self.values(omega, damping));
        let matrix = SparseColMatRef::new(self.pattern.as_ref(), &values);
        let (mut factor, numbers) = (vec![], self.order.len_val());
        factor.try_reserve_exact(numbers).ok()?;
        factor.resize(numbers, 0.0);
        let (mut beside, mut old, mut new) = (vec![0.0; n], vec![0; n], vec![0; n]);
        let scratch =
            self.order.factorize_numeric_intranode_lblt_scratch::<f64>(Par::Seq, Default::default());
        let scratch = scratch.or(self.order.solve_in_place_scratch::<f64>(1, Par::Seq));
        let mut memory = MemBuffer::try_new(scratch).ok()?;
        let stack = MemStack::new(&mut memory);
        let factor = self.order.factorize_numeric_intranode_lblt(
            &mut factor,
            &mut beside,
            &mut old,
            &mut new,
            matrix,
            Side::Lower,
            Par::Seq,
            stack,
            Default::default(),
        );
        let mut under = |force: &Vec<f64>| -> Option<Vec<f64>> {
            let (mut answer, mut residual) = (vec![0.0; n], force.clone());
            for _ in 0..REFINEMENTS {
                let step = MatMut::from_column_major_slice_mut(&mut residual, n, 1);
                factor.solve_in_place_with_conj(Conj::No, step, Par::Seq, stack);
                answer.iter_mut().zip(&residual).for_each(|(x, d)| *x += d);
                if norm(&residual) <= CORRECTION * norm(&answer) {
                    return Some(answer);
                }
                residual.copy_from_slice(force);
                for column in 0..n {
                    let rows = matrix.symbolic().row_idx_of_col_raw(column);
                    for (&row, value) in rows.iter().zip(matrix.val_of_col(column)) {
                        residual[row] -= value * answer[column];
                    }
                }
            }
            None
        };
        forces.iter().map(&mut under).collect()
    }
}

/// Damping by dashpots at the entries of the matrices of a pencil, and the rows that have other entries.
fn dashpots(pencil: &Pencil) -> (Vec<f64>, Vec<DashpotRow<'_>>) {
    let pattern = pencil.mass().pattern();
    let mut damping = vec![0.0; pencil.mass().values().len()];
    let place = |row: u32, column: u32| -> Option<usize> {
        let at = pattern.rows_of(column as usize).binary_search(&row).ok()?;
        Some(pattern.range(column as usize).start + at)
    };
    let mut outside = vec![];
    for row in pencil.dampers().rows() {
        let pairs = || row.iter().flat_map(|a| row.iter().map(move |b| (a, b)));
        if !pairs().all(|(a, b)| place(a.0, b.0).is_some()) {
            outside.push(row.as_slice());
            continue;
        }
        for (a, b) in pairs() {
            if let Some(at) = place(a.0, b.0) {
                damping[at] += a.1 * b.1;
            }
        }
    }
    (damping, outside)
}

fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}
