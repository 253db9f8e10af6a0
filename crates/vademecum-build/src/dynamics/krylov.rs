//! The Krylov space of `K⁻¹ M` that the search for modes grows, orthonormal in the mass.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par, Spec};

use super::modes::{Modes, ModesError};
use crate::fem::{Factor, Pencil, Solve, contiguous};
use crate::linalg::{NoConvergence, Random};

/// Width of the start block and of each probe: above the multiplicity of any mode of a solid (at most 3 by
/// symmetry), and a full group for the solver.
const BLOCK: usize = 8;

/// A vector that loses this fraction of its length to the basis is rounding.
const DEPENDENT: f64 = 1e-11;

/// A growing basis, orthonormal in the mass, with the projection of `K⁻¹ M` on it.
pub(super) struct Krylov<'a> {
    pencil: &'a Pencil,
    factor: &'a Factor,
    solve: Solve,
    /// Basis `V` and `M V`; the first `used` columns count.
    basis: Mat<f64>,
    mass_basis: Mat<f64>,
    used: usize,
    /// Columns whose image is known; the rest up to `used` is the frontier.
    expanded: usize,
    /// `projected[(i, j)] = v_iᵀ M K⁻¹ M v_j` for expanded `j`.
    projected: Mat<f64>,
    random: Random,
}

/// Rayleigh–Ritz pairs, `θ` descending.
pub(super) struct Ritz {
    pub values: Vec<f64>,
    /// Coordinates in the expanded basis.
    vectors: Mat<f64>,
    /// Relative to `θ`.
    pub residuals: Vec<f64>,
}

impl<'a> Krylov<'a> {
    pub fn new(pencil: &'a Pencil, factor: &'a Factor, count: usize) -> Krylov<'a> {
        let n = pencil.n_dof();
        // Blocks of 8 need two to three times the modes wanted; the rest is room for slow ones and for the
        // probe.
        let capacity = (3 * count + 16 * BLOCK).min(n);
        let mut space = Krylov {
            pencil,
            factor,
            // No refinement: it would trade the factor's fixed operator for one that differs in each solve.
            solve: Solve::new(factor.symbolic(), 3 * BLOCK, false),
            basis: Mat::zeros(n, capacity),
            mass_basis: Mat::zeros(n, capacity),
            used: 0,
            expanded: 0,
            projected: Mat::zeros(capacity, capacity),
            random: Random::new(1),
        };
        space.add_random_block();
        space
    }

    pub fn frontier(&self) -> usize {
        self.used - self.expanded
    }

    pub fn is_full(&self) -> bool {
        self.used == self.basis.ncols() && self.frontier() == 0
    }

    /// Adds random vectors to the frontier, as far as there is room. They are smoothed by one `K⁻¹ M`, so
    /// that their weight lies on low modes.
    pub fn add_random_block(&mut self) {
        let n = self.basis.nrows();
        let width = BLOCK.min(self.basis.ncols() - self.used);
        let noise = Mat::from_fn(n, width, |_, _| 2.0 * self.random.uniform() - 1.0);
        let mut smooth = Mat::zeros(n, width);
        self.pencil.mass().mul_into(noise.as_ref(), smooth.as_mut());
        self.solve.solve_in_place(self.factor, smooth.as_mut());
        self.append(smooth, None);
    }

    /// Applies `K⁻¹ M` to (a solver's share of) the frontier and appends what is new.
    pub fn expand(&mut self) {
        let n = self.basis.nrows();
        let width = self.frontier().min(3 * BLOCK);
        let first = self.expanded;
        let mut image = Mat::zeros(n, width);
        image.copy_from(self.mass_basis.subcols(first, width));
        self.solve.solve_in_place(self.factor, image.as_mut());
        self.expanded += width;
        self.append(image, Some(first));
    }

    /// Orthonormalises a block against the basis and appends what is left of it. With `images_of`, the block
    /// is the image of the basis columns from there on, and the coefficients taken off it are entries of the
    /// projection.
    fn append(&mut self, mut block: Mat<f64>, images_of: Option<usize>) {
        let old = self.used;
        let width = block.ncols();
        let lengths: Vec<f64> = {
            let mut product = Mat::zeros(block.nrows(), width);
            self.pencil.mass().mul_into(block.as_ref(), product.as_mut());
            (0..width).map(|c| dot(block.col_as_slice(c), product.col_as_slice(c)).sqrt()).collect()
        };
        // Twice is enough (Parlett): what the first pass leaves by cancellation the second removes.
        for _ in 0..2 {
            let (basis, mass_basis) = (self.basis.subcols(0, old), self.mass_basis.subcols(0, old));
            let mut coefficients = Mat::zeros(old, width);
            matmul(
                coefficients.as_mut(),
                Accum::Replace,
                mass_basis.transpose(),
                block.as_ref(),
                1.0,
                Par::Seq,
            );
            matmul(block.as_mut(), Accum::Add, basis, coefficients.as_ref(), -1.0, Par::Seq);
            if let Some(first) = images_of {
                for c in 0..width {
                    for i in 0..old {
                        self.projected[(i, first + c)] += coefficients[(i, c)];
                    }
                }
            }
        }
        for c in 0..width {
            self.append_column(block.col_as_slice_mut(c), c, old, lengths[c], images_of);
        }
    }

    /// Orthonormalises column `c` against those of its own block, which start at `old`, and appends it unless
    /// it depends on what is there.
    fn append_column(
        &mut self,
        column: &mut [f64],
        c: usize,
        old: usize,
        length: f64,
        images_of: Option<usize>,
    ) {
        let before = dot(column, column);
        self.take_off(column, c, old, images_of);
        self.take_off(column, c, old, images_of);
        if dot(column, column) < 1e-4 * before {
            // So much cancelled within the block that old directions, once rounding, show again.
            self.take_off(column, c, 0, images_of);
        }
        let n = column.len();
        let mut product = Mat::zeros(n, 1);
        self.pencil.mass().mul_into(MatRef::from_column_major_slice(column, n, 1), product.as_mut());
        let product = product.col_as_slice(0);
        let left = dot(column, product).max(0.0).sqrt();
        // `<=`: nothing is appended when all is zero.
        if left <= DEPENDENT * length || self.used == self.basis.ncols() {
            return;
        }
        let at = self.used;
        for r in 0..n {
            self.basis[(r, at)] = column[r] / left;
            self.mass_basis[(r, at)] = product[r] / left;
        }
        if let Some(first) = images_of {
            self.projected[(at, first + c)] = left;
        }
        self.used += 1;
    }

    /// Takes the components along the basis from column `from` on off a vector and books them in the
    /// projection.
    fn take_off(&mut self, column: &mut [f64], c: usize, from: usize, images_of: Option<usize>) {
        for i in from..self.used {
            let coefficient = dot(self.mass_basis.col_as_slice(i), column);
            for (x, v) in column.iter_mut().zip(self.basis.col_as_slice(i)) {
                *x -= coefficient * v;
            }
            if let Some(first) = images_of {
                self.projected[(i, first + c)] += coefficient;
            }
        }
    }

    /// Rayleigh–Ritz on the expanded part. The image of a Ritz vector leaves that part only into the
    /// frontier, so the frontier rows of the projection give its residual.
    ///
    /// # Errors
    /// [`NoConvergence`]: matrices with entries that are not numbers.
    pub fn ritz(&self) -> Result<Ritz, NoConvergence> {
        let m = self.expanded;
        let symmetric = Mat::from_fn(m, m, |i, j| 0.5 * (self.projected[(i, j)] + self.projected[(j, i)]));
        let (ascending, vectors) = symmetric_eigen(symmetric.as_ref())?;
        let vectors = vectors.as_ref().reverse_cols().to_owned();
        let frontier = self.projected.submatrix(m, 0, self.used - m, m) * &vectors;
        let values: Vec<f64> = ascending.into_iter().rev().collect();
        let residuals = (0..m).map(|j| frontier.col(j).norm_l2() / values[j].abs()).collect();
        Ok(Ritz { values, vectors, residuals })
    }

    /// Ritz vectors over the dofs, with their true residuals.
    pub fn modes(&self, ritz: &Ritz, count: usize) -> Result<Modes, ModesError> {
        let n = self.basis.nrows();
        // A singular mass shows as θ = 0, to rounding.
        let found = ritz.values.iter().take(count).filter(|&&t| t > 1e-15 * ritz.values[0]).count();
        if found < count {
            return Err(ModesError::SingularMass { found });
        }
        let mut vectors = Mat::zeros(n, count);
        let coordinates = ritz.vectors.subcols(0, count);
        let basis = self.basis.subcols(0, self.expanded);
        matmul(vectors.as_mut(), Accum::Replace, basis, coordinates, 1.0, Par::Seq);
        for j in 0..count {
            turn_positive(vectors.col_as_slice_mut(j));
        }
        let quotients = self.rayleigh_quotients(vectors.as_ref());
        // Close pairs may change places by rounding.
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|&i, &j| quotients[i].total_cmp(&quotients[j]));
        let eigenvalues: Vec<f64> = order.iter().map(|&j| quotients[j]).collect();
        let vectors = Mat::from_fn(n, count, |i, j| vectors[(i, order[j])]);
        let residuals = self.true_residuals(vectors.as_ref(), &eigenvalues);
        Ok(Modes { eigenvalues, vectors, residuals })
    }

    /// `xᵀKx / xᵀMx`: stationary at a mode, so a vector error counts by its square, and free of the factor's
    /// rounding, which on slender bodies shifts the lowest `1/θ` by some 1e-9.
    fn rayleigh_quotients(&self, vectors: MatRef<'_, f64>) -> Vec<f64> {
        let of = |x: &[f64]| self.pencil.stiffness().inner(x, x) / self.pencil.mass().inner(x, x);
        (0..vectors.ncols()).map(|j| of(contiguous(vectors, j))).collect()
    }

    /// `‖K⁻¹M x − x/λ‖_M λ` computed afresh with refined solves, not from the recurrence.
    fn true_residuals(&self, vectors: MatRef<'_, f64>, eigenvalues: &[f64]) -> Vec<f64> {
        let n = vectors.nrows();
        let mut solve = Solve::new(self.factor.symbolic(), 3 * BLOCK, true);
        let mut residuals = Vec::new();
        for first in (0..vectors.ncols()).step_by(3 * BLOCK) {
            let width = (3 * BLOCK).min(vectors.ncols() - first);
            let part = vectors.subcols(first, width);
            let mut image = Mat::zeros(n, width);
            self.pencil.mass().mul_into(part, image.as_mut());
            solve.solve_in_place(self.factor, image.as_mut());
            for j in 0..width {
                let theta = 1.0 / eigenvalues[first + j];
                let off: Vec<f64> = (0..n).map(|i| image[(i, j)] - theta * part[(i, j)]).collect();
                residuals.push(self.pencil.mass().inner(&off, &off).max(0.0).sqrt() / theta);
            }
        }
        residuals
    }
}

/// Makes the entry of largest magnitude positive: the sign of a mode is otherwise an accident.
fn turn_positive(vector: &mut [f64]) {
    let largest = vector.iter().fold(0.0_f64, |l, &x| if x.abs() > l.abs() { x } else { l });
    if largest < 0.0 {
        vector.iter_mut().for_each(|x| *x = -*x);
    }
}

/// What did not converge.
const EIGENVALUES: &str = "the eigenvalues of a symmetric matrix";

/// Eigenvalues, ascending, and orthonormal eigenvectors of a symmetric matrix; one thread.
///
/// The matrix is scaled to unit size first: faer's routine returns wrong results for small norms from n ≈ 130
/// on.
///
/// # Errors
/// [`NoConvergence`]: an entry that is not a finite number.
pub(crate) fn symmetric_eigen(matrix: MatRef<'_, f64>) -> Result<(Vec<f64>, Mat<f64>), NoConvergence> {
    let n = matrix.nrows();
    if n == 0 {
        return Ok((Vec::new(), Mat::new()));
    }
    let size = matrix.norm_max();
    // The largest of numbers and NaNs may be a number.
    let finite = (0..n).all(|j| (0..n).all(|i| matrix[(i, j)].is_finite()));
    if !finite {
        return Err(NoConvergence { what: EIGENVALUES });
    }
    let scale = if size > 0.0 { size } else { 1.0 };
    let scaled = Mat::from_fn(n, n, |i, j| matrix[(i, j)] / scale);
    let mut values = faer::Col::<f64>::zeros(n);
    let mut vectors = Mat::zeros(n, n);
    let request = self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, Par::Seq, Spec::default());
    let mut memory = MemBuffer::new(request);
    self_adjoint_evd(
        scaled.as_ref(),
        values.as_mut().as_diagonal_mut(),
        Some(vectors.as_mut()),
        Par::Seq,
        MemStack::new(&mut memory),
        Spec::default(),
    )
    .map_err(|_| NoConvergence { what: EIGENVALUES })?;
    Ok(((0..n).map(|i| scale * values[i]).collect(), vectors))
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
