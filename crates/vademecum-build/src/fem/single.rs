//! Solves with a factor in single precision, which takes half the memory of one in double precision.
//!
//! The factorised matrix is `D A D`, with a diagonal `D` of powers of two that brings the diagonal near one;
//! and where its rounding makes it indefinite, `D A D + δ I` with the smallest sufficient δ of a few. The
//! factor is only a preconditioner: conjugate gradients in double precision solve `A x = b` with it (Hestenes
//! and Stiefel 1952). Few iterations do, because the factor differs from `A` by its rounding, and what that
//! spoils most is solved for apart ([`super::coarse`]). Iterative refinement would need more, and fail where
//! the condition of `D A D` times that rounding exceeds one.
//!
//! The reduction of the squared error in the energy norm by an iteration is known, and is nearly all of it.
//! It falls by much the same factor each time, so the last one is foretold and not waited for.

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Mat, MatMut};

use super::coarse::CoarseSpace;
use super::multifrontal::factorise;
use super::sparse::{AT_ONCE, SymmetricMatrix, contiguous, contiguous_mut};
use super::substitution::{gather, scatter, substitute_by_groups};
use super::supernodes::{Scaling, Supernodes};
use crate::linalg::column_groups;
use crate::parallel;

/// The error of a solution, relative to it in the energy norm, at which an iteration ends.
pub(super) const TOLERANCE: f64 = 1e-12;

/// δ, relative to a diagonal near one: from nothing to some thousand times the rounding of single precision.
const SHIFTS: [f64; 4] = [0.0, 1e-6, 1e-5, 1e-4];

/// By how much the next gain may exceed what is foretold of it.
const CAUTION: f64 = 10.0;

/// Iterations after which a solution is given up.
const MAX_ITERATIONS: usize = 200;

/// A factor in single precision.
#[derive(Clone, Debug)]
pub(super) struct SingleFactor {
    values: Vec<f32>,
    scaling: Scaling,
    /// Absent where none was found, which only costs iterations.
    coarse: Option<CoarseSpace>,
}

/// Memory of an iteration for some columns.
pub(super) struct Iteration {
    /// Columns in the order of elimination.
    image: Vec<f32>,
    residual: Mat<f64>,
    direction: Mat<f64>,
    /// The residual, the same under the preconditioner, then the direction under the matrix.
    turned: Mat<f64>,
}

impl Iteration {
    /// Memory for `columns` columns of `n` rows.
    pub(crate) fn new(n: usize, columns: usize) -> Self {
        let [residual, direction, turned] = [(); 3].map(|()| Mat::zeros(n, columns));
        Self { image: vec![0.0; n * columns], residual, direction, turned }
    }

    /// The same \[bytes\].
    pub(crate) fn bytes(n: usize, columns: usize) -> usize {
        n.saturating_mul(columns).saturating_mul(3 * size_of::<f64>() + size_of::<f32>())
    }
}

/// One column of an iteration.
struct Column<'a> {
    x: &'a mut [f64],
    residual: &'a mut [f64],
    direction: &'a mut [f64],
    turned: &'a mut [f64],
    state: &'a mut Convergence,
}

/// Progress of the iteration for one column.
#[derive(Clone, Copy, Default)]
struct Convergence {
    /// `rᵀ z` of the last iteration.
    product: f64,
    /// Reduction of the squared error by the last iteration.
    gain: f64,
    /// `xᵀ A x`, what the iterations have added up to.
    energy: f64,
    /// The square of the error that is left, as far as it is known.
    left: f64,
    done: bool,
}

impl Convergence {
    /// The error of the solution in the energy norm, relative to it.
    fn error(&self) -> f64 {
        let squared = if self.left == 0.0 { 0.0 } else { self.left / self.energy };
        // What is not a number is no small one.
        if squared >= 0.0 { squared.sqrt() } else { f64::INFINITY }
    }
}

impl SingleFactor {
    /// Factorises a matrix; `None` where no δ makes it definite.
    pub(crate) fn new(supernodes: &Supernodes, matrix: &SymmetricMatrix) -> Option<Self> {
        let root = |i| 0.5 * matrix.diagonal(i).max(f64::MIN_POSITIVE).log2();
        let scale: Vec<f64> = (0..matrix.n()).map(|i| (-root(i).round()).exp2()).collect();
        let mut scaling = Scaling { scale, shift: 0.0 };
        SHIFTS.into_iter().find_map(|shift| {
            scaling.shift = shift;
            let values = factorise(supernodes, matrix, Some(&scaling)).ok()?;
            let mut single = Self { values, scaling: scaling.clone(), coarse: None };
            let mut image = vec![0.0; supernodes.n() * AT_ONCE];
            single.coarse = CoarseSpace::find(matrix, |x| single.precondition(supernodes, &mut image, x));
            Some(single)
        })
    }

    /// Memory of one \[bytes\].
    pub(crate) fn bytes(supernodes: &Supernodes) -> usize {
        let values = supernodes.len().saturating_mul(size_of::<f32>());
        values.saturating_add(CoarseSpace::bytes(supernodes.n()))
    }

    /// Overwrites the columns of `x` by `A⁻¹ x`, and returns the largest error of them, relative in the
    /// energy norm, as it was estimated. `memory` is for as many columns or more.
    pub(crate) fn solve(
        &self,
        supernodes: &Supernodes,
        matrix: &SymmetricMatrix,
        mut x: MatMut<'_, f64>,
        memory: &mut Iteration,
    ) -> f64 {
        let (n, k) = (x.nrows(), x.ncols());
        let image = &mut memory.image[..n * k];
        let [mut residual, mut direction, mut turned] =
            [&mut memory.residual, &mut memory.direction, &mut memory.turned]
                .map(|block| block.as_mut().subcols_mut(0, k));
        residual.copy_from(x.rb());
        turned.copy_from(x.rb());
        x.fill(0.0);
        direction.fill(0.0);
        let mut states = vec![Convergence::default(); k];
        for _ in 0..MAX_ITERATIONS {
            self.precondition(supernodes, image, turned.rb_mut());
            each(&mut x, [&mut residual, &mut direction, &mut turned], &mut states, |column| column.turn());
            if states.iter().all(|state| state.done) {
                break;
            }
            matrix.mul_into(direction.rb(), turned.rb_mut());
            each(&mut x, [&mut residual, &mut direction, &mut turned], &mut states, |column| column.step());
            if states.iter().all(|state| state.done) {
                break;
            }
        }
        states.iter().map(Convergence::error).fold(0.0, f64::max)
    }

    /// Overwrites the columns of `z`, each taken at the size of one, by `D L⁻ᵀ L⁻¹ D z` plus the coarse
    /// space.
    fn precondition(&self, supernodes: &Supernodes, image: &mut [f32], mut z: MatMut<'_, f64>) {
        let shares = self.coarse.as_ref().map(|coarse| coarse.take_off(z.rb_mut()));
        let scale = &self.scaling.scale;
        let size = |column: usize| {
            let scaled = contiguous(z.rb(), column).iter().zip(scale).map(|(z, scale)| (z * scale).abs());
            let largest = scaled.fold(0.0, f64::max);
            if largest > 0.0 { largest } else { 1.0 }
        };
        let sizes = parallel::map(z.ncols(), &size);
        gather(supernodes, sizes.len(), image, |row, column| {
            (z[(row, column)] * scale[row] / sizes[column]) as f32
        });
        substitute_by_groups(supernodes, &self.values, image, sizes.len());
        scatter(supernodes, image, sizes.len(), z.rb_mut(), |z, row, column| {
            f64::from(z) * scale[row] * sizes[column]
        });
        if let Some((coarse, shares)) = self.coarse.as_ref().zip(shares) {
            coarse.put_back(shares, z);
        }
    }
}

/// Does the same with each column; all threads.
fn each(
    x: &mut MatMut<'_, f64>,
    blocks: [&mut MatMut<'_, f64>; 3],
    states: &mut [Convergence],
    task: impl Fn(&mut Column<'_>) + Sync,
) {
    let [residual, direction, turned] = blocks.map(|block| column_groups(block.rb_mut(), 1));
    let columns = column_groups(x.rb_mut(), 1).into_iter().zip(residual).zip(direction).zip(turned);
    parallel::for_each_of(columns.zip(states), &|_, ((((x, residual), direction), turned), state)| {
        if !state.done {
            let [x, residual, direction, turned] =
                [x, residual, direction, turned].map(|column| contiguous_mut(column, 0));
            task(&mut Column { x, residual, direction, turned, state });
        }
    });
}

impl Column<'_> {
    /// Takes the residual under the preconditioner, and turns the direction, unless the column is solved for.
    fn turn(&mut self) {
        let product = dot(self.residual, self.turned);
        let Convergence { product: before, energy, .. } = *self.state;
        self.state.product = product;
        // `z` is nearly the error. What is not a number does not go on.
        let goes_on = product > TOLERANCE * TOLERANCE * energy;
        if !goes_on {
            (self.state.left, self.state.done) = (product, true);
            return;
        }
        let share = if before > 0.0 { product / before } else { 0.0 };
        self.direction.iter_mut().zip(&*self.turned).for_each(|(p, z)| *p = z + share * *p);
    }

    /// Takes a step along the direction, whose product with the matrix is there, and leaves the residual.
    fn step(&mut self) {
        let length = self.state.product / dot(self.direction, self.turned);
        self.x.iter_mut().zip(&*self.direction).for_each(|(x, p)| *x += length * p);
        self.residual.iter_mut().zip(&mut *self.turned).for_each(|(r, q)| {
            *r -= length * *q;
            *q = *r;
        });
        let state = &mut *self.state;
        let gain = length * state.product;
        state.energy += gain;
        state.left = if state.gain > 0.0 { CAUTION * gain * (gain / state.gain) } else { gain };
        state.done = state.left <= TOLERANCE * TOLERANCE * state.energy;
        state.gain = gain;
    }
}

/// `aᵀb`, summed in one order.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
