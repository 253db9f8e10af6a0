//! The lowest natural modes, `K φ = λ M φ`, by block Lanczos on `K⁻¹ M`.
//!
//! `K⁻¹ M` is self-adjoint in the inner product of the mass, its largest eigenvalues `θ = 1/λ` are the modes wanted, and
//! it needs only a factor of `K`. The basis is kept orthogonal against all of itself (no ghosts) and the Rayleigh–Ritz
//! problem is solved on all of it. A Krylov space can miss a mode its start does not see (or more copies of a multiple
//! one than the block is wide), so once everything has converged a fresh random block joins, and only if its expansion
//! changes nothing the answer stands (Parlett, *The Symmetric Eigenvalue Problem*, ch. 13).

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par, Spec};

use crate::fem::{Factor, FactorError, Pencil, Solve, Symbolic};

/// Width of the start block and of each probe: above the multiplicity of any mode of a solid (at most 3 by symmetry),
/// and a full group for the solver.
const BLOCK: usize = 8;

/// Ritz residual `‖K⁻¹M x − θ x‖ / θ`, in the mass norm, at which a mode counts as converged. It bounds the relative
/// error of its eigenvalue (whose true error is of the order of its square over the gap).
const TOLERANCE: f64 = 1e-9;

/// Expansions of a probe block before the answer stands.
const PROBES: usize = 2;

/// A vector that loses this fraction of its length to the basis is rounding.
const DEPENDENT: f64 = 1e-11;

/// Natural modes in ascending order.
#[derive(Clone, Debug)]
pub struct Modes {
    /// `λ = ω²`, 1/s².
    pub eigenvalues: Vec<f64>,
    /// `φ`, shape `(n, count)`, column-major, `φᵀ M φ = I`; the largest entry of each is positive.
    pub vectors: Mat<f64>,
    /// `‖K⁻¹M φ − φ/λ‖ λ` in the mass norm, one per mode: a bound on the relative error of its eigenvalue.
    pub residuals: Vec<f64>,
}

impl Modes {
    /// `√λ / 2π`, Hz.
    pub fn frequencies_hz(&self) -> Vec<f64> {
        self.eigenvalues
            .iter()
            .map(|l| l.sqrt() / std::f64::consts::TAU)
            .collect()
    }

    /// The largest residual: beyond 1e-8 the search ran out of room before all modes converged.
    pub fn worst_residual(&self) -> f64 {
        self.residuals.iter().copied().fold(0.0, f64::max)
    }
}

/// Why no modes were found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModesError {
    /// More modes asked for than the body has dofs, or none.
    #[error("{count} modes asked for; the body has {n} dofs")]
    Count {
        /// Modes asked for.
        count: usize,
        /// Free dofs.
        n: usize,
    },
    /// The stiffness does not factorise.
    #[error("stiffness matrix")]
    Factor(#[from] FactorError),
    /// Fewer modes than asked for have a finite frequency: the mass is singular.
    #[error("only {found} modes have a finite frequency: the mass matrix is singular")]
    SingularMass {
        /// Modes found.
        found: usize,
    },
}

/// The `count` lowest modes of a pencil, with `symbolic` the analysis of its pattern.
///
/// One factor of `K`, then some `2 count + 5 · 8` solves; memory for as many vectors twice over. Deterministic.
///
/// # Errors
/// [`ModesError`]. Modes that have not converged are no error: see [`Modes::residuals`].
pub fn lowest_modes(
    pencil: &Pencil,
    symbolic: &Symbolic,
    count: usize,
) -> Result<Modes, ModesError> {
    let n = pencil.n_dof();
    if count == 0 || count > n {
        return Err(ModesError::Count { count, n });
    }
    let factor = symbolic.factorize(pencil.stiffness().clone())?;
    let mut space = Krylov::new(pencil, &factor, count);
    let mut settled: Option<usize> = None; // expansions since convergence
    let ritz = loop {
        space.expand();
        let ritz = space.ritz();
        let converged =
            ritz.values.len() >= count && ritz.residuals[..count].iter().all(|&r| r <= TOLERANCE);
        settled = match settled {
            Some(since) if converged => Some(since + 1),
            _ => converged.then_some(0),
        };
        if settled.is_some_and(|since| since >= PROBES) || space.is_full() {
            break ritz;
        }
        if settled == Some(0) || space.frontier() == 0 {
            space.add_random_block();
            if space.frontier() == 0 {
                break ritz;
            }
        }
    };
    space.modes(&ritz, count)
}

/// A growing basis, orthonormal in the mass, with the projection of `K⁻¹ M` on it.
struct Krylov<'a> {
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
    random: SplitMix,
}

/// Rayleigh–Ritz pairs, `θ` descending.
struct Ritz {
    values: Vec<f64>,
    /// Coordinates in the expanded basis.
    vectors: Mat<f64>,
    /// Relative to `θ`.
    residuals: Vec<f64>,
}

impl<'a> Krylov<'a> {
    fn new(pencil: &'a Pencil, factor: &'a Factor, count: usize) -> Krylov<'a> {
        let n = pencil.n_dof();
        // Lanczos needs about twice the modes wanted; the rest is room for slow ones and for the probe.
        let capacity = (2 * count + 16 * BLOCK).min(n);
        let mut space = Krylov {
            pencil,
            factor,
            solve: Solve::new(factor.symbolic(), 3 * BLOCK, true),
            basis: Mat::zeros(n, capacity),
            mass_basis: Mat::zeros(n, capacity),
            used: 0,
            expanded: 0,
            projected: Mat::zeros(capacity, capacity),
            random: SplitMix(1),
        };
        space.add_random_block();
        space
    }

    fn frontier(&self) -> usize {
        self.used - self.expanded
    }

    fn is_full(&self) -> bool {
        self.used == self.basis.ncols() && self.frontier() == 0
    }

    /// Adds random vectors to the frontier, as far as there is room. They are smoothed by one `K⁻¹ M`, so that their
    /// weight lies on low modes.
    fn add_random_block(&mut self) {
        let n = self.basis.nrows();
        let width = BLOCK.min(self.basis.ncols() - self.used);
        let noise = Mat::from_fn(n, width, |_, _| self.random.next());
        let mut smooth = Mat::zeros(n, width);
        self.pencil.mass().mul_into(noise.as_ref(), smooth.as_mut());
        self.solve.solve_in_place(self.factor, smooth.as_mut());
        self.append(smooth, None);
    }

    /// Applies `K⁻¹ M` to (a solver's share of) the frontier and appends what is new.
    fn expand(&mut self) {
        let n = self.basis.nrows();
        let width = self.frontier().min(3 * BLOCK);
        let first = self.expanded;
        let mut image = Mat::zeros(n, width);
        image.copy_from(self.mass_basis.subcols(first, width));
        self.solve.solve_in_place(self.factor, image.as_mut());
        self.expanded += width;
        self.append(image, Some(first));
    }

    /// Orthonormalises a block against the basis and appends what is left of it. With `images_of`, the block is the
    /// image of the basis columns from there on, and the coefficients taken off it are entries of the projection.
    fn append(&mut self, mut block: Mat<f64>, images_of: Option<usize>) {
        let old = self.used;
        let width = block.ncols();
        let lengths: Vec<f64> = {
            let mut product = Mat::zeros(block.nrows(), width);
            self.pencil
                .mass()
                .mul_into(block.as_ref(), product.as_mut());
            (0..width)
                .map(|c| dot(block.col_as_slice(c), product.col_as_slice(c)).sqrt())
                .collect()
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
            matmul(
                block.as_mut(),
                Accum::Add,
                basis,
                coefficients.as_ref(),
                -1.0,
                Par::Seq,
            );
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

    /// Orthonormalises column `c` against those of its own block, which start at `old`, and appends it unless it
    /// depends on what is there.
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
        self.pencil.mass().mul_into(
            MatRef::from_column_major_slice(column, n, 1),
            product.as_mut(),
        );
        let product = product.col_as_slice(0);
        let left = dot(column, product).max(0.0).sqrt();
        // Written so that nothing is appended when all is zero.
        if !(left > DEPENDENT * length) || self.used == self.basis.ncols() {
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

    /// Takes the components along the basis from column `from` on off a vector and books them in the projection.
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

    /// Rayleigh–Ritz on the expanded part. The image of a Ritz vector leaves that part only into the frontier, so the
    /// frontier rows of the projection give its residual.
    fn ritz(&self) -> Ritz {
        let m = self.expanded;
        let symmetric = Mat::from_fn(m, m, |i, j| {
            0.5 * (self.projected[(i, j)] + self.projected[(j, i)])
        });
        let (ascending, vectors) = symmetric_eigen(symmetric.as_ref());
        let vectors = vectors.as_ref().reverse_cols().to_owned();
        let frontier = self.projected.submatrix(m, 0, self.used - m, m) * &vectors;
        let values: Vec<f64> = ascending.into_iter().rev().collect();
        let residuals = (0..m)
            .map(|j| frontier.col(j).norm_l2() / values[j].abs())
            .collect();
        Ritz {
            values,
            vectors,
            residuals,
        }
    }

    /// Ritz vectors over the dofs, with their true residuals.
    fn modes(&mut self, ritz: &Ritz, count: usize) -> Result<Modes, ModesError> {
        let n = self.basis.nrows();
        // A singular mass shows as θ = 0, to rounding.
        let found = ritz
            .values
            .iter()
            .take(count)
            .filter(|&&t| t > 1e-15 * ritz.values[0])
            .count();
        if found < count {
            return Err(ModesError::SingularMass { found });
        }
        let mut vectors = Mat::zeros(n, count);
        let coordinates = ritz.vectors.subcols(0, count);
        let basis = self.basis.subcols(0, self.expanded);
        matmul(
            vectors.as_mut(),
            Accum::Replace,
            basis,
            coordinates,
            1.0,
            Par::Seq,
        );
        for j in 0..count {
            turn_positive(vectors.col_as_slice_mut(j));
        }
        let residuals = self.true_residuals(vectors.as_ref(), &ritz.values);
        Ok(Modes {
            eigenvalues: ritz.values[..count].iter().map(|t| 1.0 / t).collect(),
            vectors,
            residuals,
        })
    }

    /// `‖K⁻¹M x − θ x‖_M / θ` computed afresh, not from the recurrence.
    fn true_residuals(&mut self, vectors: MatRef<'_, f64>, values: &[f64]) -> Vec<f64> {
        let n = vectors.nrows();
        let mut residuals = Vec::new();
        for first in (0..vectors.ncols()).step_by(3 * BLOCK) {
            let width = (3 * BLOCK).min(vectors.ncols() - first);
            let part = vectors.subcols(first, width);
            let mut image = Mat::zeros(n, width);
            self.pencil.mass().mul_into(part, image.as_mut());
            self.solve.solve_in_place(self.factor, image.as_mut());
            for j in 0..width {
                let theta = values[first + j];
                let off: Vec<f64> = (0..n)
                    .map(|i| image[(i, j)] - theta * part[(i, j)])
                    .collect();
                residuals.push(self.pencil.mass().inner(&off, &off).max(0.0).sqrt() / theta);
            }
        }
        residuals
    }
}

/// Makes the entry of largest magnitude positive: the sign of a mode is otherwise an accident.
fn turn_positive(vector: &mut [f64]) {
    let largest = vector
        .iter()
        .fold(0.0_f64, |l, &x| if x.abs() > l.abs() { x } else { l });
    if largest < 0.0 {
        vector.iter_mut().for_each(|x| *x = -*x);
    }
}

/// Eigenvalues, ascending, and orthonormal eigenvectors of a symmetric matrix; one thread.
///
/// The matrix is scaled to unit size first: faer's routine returns wrong results for small norms from n ≈ 130 on.
pub(crate) fn symmetric_eigen(matrix: MatRef<'_, f64>) -> (Vec<f64>, Mat<f64>) {
    let n = matrix.nrows();
    if n == 0 {
        return (Vec::new(), Mat::new());
    }
    let size = matrix.norm_max();
    let scale = if size > 0.0 { size } else { 1.0 };
    let scaled = Mat::from_fn(n, n, |i, j| matrix[(i, j)] / scale);
    let mut values = faer::Col::<f64>::zeros(n);
    let mut vectors = Mat::zeros(n, n);
    let request =
        self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, Par::Seq, Spec::default());
    let mut memory = MemBuffer::new(request);
    self_adjoint_evd(
        scaled.as_ref(),
        values.as_mut().as_diagonal_mut(),
        Some(vectors.as_mut()),
        Par::Seq,
        MemStack::new(&mut memory),
        Spec::default(),
    )
    .expect("the eigenvalues of a finite symmetric matrix converge");
    ((0..n).map(|i| scale * values[i]).collect(), vectors)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// The generator of Steele, Lea and Flood (2014): the same numbers on every machine.
struct SplitMix(u64);

impl SplitMix {
    /// Uniform in [−1, 1).
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Model;
    use crate::fem::test_mesh::{block, hold};
    use crate::fem::{Material, ModelError};

    fn beam(cells: [usize; 3], size: [f64; 3]) -> Result<Model, ModelError> {
        let mesh = block(cells, size);
        let held = hold(&mesh, |p| p[0] == 0.0);
        Model::assemble(
            mesh,
            &[Material {
                young: 1e7,
                poisson: 0.3,
                density: 1000.0,
            }],
            &held,
        )
    }

    /// A chain of unit masses and springs held at one end: `λ_j = 4 sin²((2j−1)π/(4n+2))`.
    fn chain(n: usize) -> Pencil {
        let mass: Vec<_> = (0..n as u32).map(|i| (i, i, 1.0)).collect();
        let mut stiffness = Vec::new();
        for i in 0..n as u32 {
            stiffness.push((i, i, if i + 1 == n as u32 { 1.0 } else { 2.0 }));
            if i > 0 {
                stiffness.extend([(i, i - 1, -1.0), (i - 1, i, -1.0)]);
            }
        }
        Pencil::from_triplets(n, &mass, &stiffness).unwrap()
    }

    #[test]
    fn a_chain_has_its_textbook_frequencies() {
        for (n, count) in [(1, 1), (2, 2), (9, 9), (400, 30)] {
            let pencil = chain(n);
            let modes = lowest_modes(&pencil, &Symbolic::analyze(&pencil).unwrap(), count).unwrap();
            for (j, &found) in modes.eigenvalues.iter().enumerate() {
                let angle = (2 * j + 1) as f64 * std::f64::consts::PI / (4 * n + 2) as f64;
                let exact = 4.0 * angle.sin().powi(2);
                // What the module promises; the residual bounds it.
                assert!(
                    (found / exact - 1.0).abs() < 1e-8,
                    "n = {n}, mode {j}: {found} for {exact}"
                );
            }
        }
    }

    #[test]
    fn twelve_copies_of_one_mode_are_all_found() {
        // More copies than the start block is wide: only the probes can find the rest.
        let n = 300;
        let mass: Vec<_> = (0..n).map(|i| (i, i, 1.0)).collect();
        let stiffness: Vec<_> = (0..n)
            .map(|i| (i, i, if i < 12 { 1.0 } else { f64::from(i) }))
            .collect();
        let pencil = Pencil::from_triplets(n as usize, &mass, &stiffness).unwrap();
        let modes = lowest_modes(&pencil, &Symbolic::analyze(&pencil).unwrap(), 14).unwrap();
        for (j, &found) in modes.eigenvalues.iter().enumerate() {
            let exact = if j < 12 { 1.0 } else { j as f64 };
            assert!(
                (found / exact - 1.0).abs() < 1e-8,
                "mode {j}: {found} for {exact}"
            );
        }
    }

    #[test]
    fn modes_of_a_square_beam_solve_the_pencil() {
        let model = beam([24, 3, 3], [1.0, 0.1, 0.1]).unwrap();
        let pencil = model.pencil();
        let modes = lowest_modes(pencil, &Symbolic::analyze(pencil).unwrap(), 20).unwrap();
        assert!(modes.worst_residual() < 1e-8, "{:?}", modes.residuals);
        assert!(modes.eigenvalues.is_sorted());
        for i in 0..20 {
            for j in 0..20 {
                let (x, y) = (modes.vectors.col_as_slice(i), modes.vectors.col_as_slice(j));
                let expected = f64::from(i == j);
                // Orthonormal to the rounding of n products in a basis of unit vectors.
                assert!((pencil.mass().inner(x, y) - expected).abs() < 1e-12);
                // A Ritz value is stationary: its error is of second order in the residual.
                let rayleigh = pencil.stiffness().inner(x, y) / modes.eigenvalues[i.max(j)];
                assert!((rayleigh - expected).abs() < 1e-8);
            }
        }
        // Euler–Bernoulli: linear tetrahedra are too stiff, so above it, and within half of it on this mesh.
        let bending = 0.5596 * (1e7_f64 * 0.1_f64.powi(4) / 12.0 / (1000.0 * 0.01)).sqrt();
        let first = modes.frequencies_hz()[0];
        assert!(
            first > bending && first < 1.5 * bending,
            "{first} Hz against {bending} Hz"
        );
    }

    #[test]
    fn impossible_counts_and_singular_masses_are_named() {
        let pencil = chain(3);
        let symbolic = Symbolic::analyze(&pencil).unwrap();
        assert_eq!(
            lowest_modes(&pencil, &symbolic, 4).unwrap_err(),
            ModesError::Count { count: 4, n: 3 }
        );
        let stiffness: Vec<_> = (0..3).map(|i| (i, i, 1.0)).collect();
        let massless = Pencil::from_triplets(3, &[(0, 0, 1.0)], &stiffness).unwrap();
        let found = lowest_modes(&massless, &Symbolic::analyze(&massless).unwrap(), 2);
        assert_eq!(found.unwrap_err(), ModesError::SingularMass { found: 1 });
    }

    #[test]
    fn eigenvalues_of_tiny_matrices_are_right() {
        // A matrix with known eigenvalues 1…200 scaled to 1e-16: I − 2wwᵀ turns the diagonal.
        let n = 200;
        let w = (1.0 / n as f64).sqrt();
        let reflect = |i: usize, k: usize| f64::from(i == k) - 2.0 * w * w;
        let dense = Mat::from_fn(n, n, |i, j| {
            1e-16
                * (0..n)
                    .map(|k| reflect(i, k) * (k + 1) as f64 * reflect(k, j))
                    .sum::<f64>()
        });
        let (values, _) = symmetric_eigen(dense.as_ref());
        for (i, value) in values.iter().enumerate() {
            // Backward error of a symmetric eigensolver: a few n units in the last place of the norm.
            assert!((value * 1e16 - (i + 1) as f64).abs() < 200.0 * 200.0 * f64::EPSILON * 4.0);
        }
    }
}
