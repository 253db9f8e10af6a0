//! The Krylov space of `K⁻¹ M` that the search for modes grows, orthonormal in the mass.

use std::time::Instant;

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Mat, MatMut, MatRef};

use super::natural::{Modes, ModesError};
use super::orthonormal::orthonormalise;
use crate::fem::{AT_ONCE, EngineError, PencilRows, Search, agree_matrix, contiguous};
use crate::linalg::{Columns, Random, product, symmetric_eigen};
use crate::store::CachedSolves;

/// Width of the start block and of each probe: above the multiplicity of any mode of a solid (at most 3 by
/// symmetry). A wider block reads the factor less often, but needs more vectors: 32 modes of a body of
/// 105 840 dofs converge with 192 vectors of blocks of 8, with 228 of 12, and not with 264 of 24.
const BLOCK: usize = 8;

/// Share of a mode's stiffness that may be lost in the rounding of the stiffest dof before products with it
/// are summed closely: what is lost is some 1e-3 of that.
const CANCELS: f64 = 1e-7;

/// Vectors that the search for `count` modes takes at most: two to three times as many, and room for slow
/// ones and for the probe.
pub(crate) fn search_vectors(count: usize) -> usize {
    3 * count + 192
}

/// A growing basis, orthonormal in the mass, with the projection of `K⁻¹ M` on it.
pub(super) struct Krylov<'a> {
    rows: &'a mut dyn PencilRows,
    /// Basis `V`, this rank's rows of it.
    basis: Columns,
    /// Most columns of it.
    capacity: usize,
    /// Columns whose image is known; the rest is the frontier.
    expanded: usize,
    /// `projected[(i, j)] = v_iᵀ M K⁻¹ M v_j` for expanded `j`.
    projected: Mat<f64>,
    random: Random,
    /// A Rayleigh quotient near the largest.
    stiffest: f64,
    kept: Option<&'a CachedSolves<'a>>,
}

/// A space without the rows it grows on, which a search for more modes goes on from.
pub(crate) struct SearchSpace {
    basis: Columns,
    expanded: usize,
    projected: Mat<f64>,
    random: Random,
}

/// Rayleigh–Ritz pairs, `θ` descending.
pub(super) struct RitzPairs {
    pub(crate) values: Vec<f64>,
    /// Coordinates in the expanded basis.
    vectors: Mat<f64>,
    /// Relative to `θ`.
    pub(crate) residuals: Vec<f64>,
}

impl<'a> Krylov<'a> {
    /// A space for a search, of random vectors.
    pub(crate) fn new(
        rows: &'a mut dyn PencilRows,
        search: &Search,
        kept: Option<&'a CachedSolves<'a>>,
    ) -> Result<Krylov<'a>, EngineError> {
        let mut space = Self::empty(rows, search, kept);
        space.add_random_block()?;
        Ok(space)
    }

    fn empty(
        rows: &'a mut dyn PencilRows,
        &Search { count, available, stiffest, .. }: &Search,
        kept: Option<&'a CachedSolves<'a>>,
    ) -> Krylov<'a> {
        let own = rows.own();
        let capacity = search_vectors(count).min(available);
        Krylov {
            rows,
            basis: Columns::with_room(own, capacity),
            capacity,
            expanded: 0,
            projected: Mat::zeros(capacity, capacity),
            random: Random::new(1),
            stiffest,
            kept,
        }
    }

    /// A space for a search, from what an earlier one for fewer modes has grown.
    pub(crate) fn resume(
        rows: &'a mut dyn PencilRows,
        search: &Search,
        kept: Option<&'a CachedSolves<'a>>,
        grown: SearchSpace,
    ) -> Self {
        let mut space = Self::empty(rows, search, kept);
        space.basis.append(grown.basis.as_ref());
        (space.expanded, space.random) = (grown.expanded, grown.random);
        let (m, n) = (space.used(), space.expanded);
        space.projected.submatrix_mut(0, 0, m, n).copy_from(grown.projected.submatrix(0, 0, m, n));
        space
    }

    /// Starting space for a search for more modes; none where columns were left out for want of room.
    pub(crate) fn grown(self) -> Option<SearchSpace> {
        let whole = self.used() < self.capacity;
        let Self { basis, expanded, projected, random, .. } = self;
        whole.then_some(SearchSpace { basis, expanded, projected, random })
    }

    fn used(&self) -> usize {
        self.basis.as_ref().ncols()
    }

    pub(crate) fn frontier(&self) -> usize {
        self.used() - self.expanded
    }

    pub(crate) fn is_full(&self) -> bool {
        self.used() == self.capacity && self.frontier() == 0
    }

    /// Adds random vectors to the frontier, as far as there is room. They are smoothed by one `K⁻¹ M`, so
    /// that their weight lies on low modes.
    pub(crate) fn add_random_block(&mut self) -> Result<(), EngineError> {
        let own = self.basis.as_ref().nrows();
        let width = BLOCK.min(self.capacity - self.used());
        if width == 0 {
            return Ok(());
        }
        // Every rank draws all rows and takes its own: the start does not depend on how rows are spread.
        let mut whole = vec![0.0; self.rows.total()];
        let mut noise = Mat::zeros(own, width);
        for j in 0..width {
            whole.fill_with(|| 2.0 * self.random.uniform() - 1.0);
            self.rows.part_into(&whole, noise.col_as_slice_mut(j));
        }
        let mut smooth = Mat::zeros(own, width);
        self.rows.mul_mass(noise.as_ref(), smooth.as_mut())?;
        self.solve(smooth.as_mut())?;
        self.append(smooth, None)
    }

    /// Applies `K⁻¹ M` to (a solver's share of) the frontier and appends what is new.
    pub(crate) fn expand(&mut self) -> Result<(), EngineError> {
        let width = self.frontier().min(AT_ONCE);
        let first = self.expanded;
        let mut image = Mat::zeros(self.basis.as_ref().nrows(), width);
        self.rows.mul_mass(self.basis.as_ref().subcols(first, width), image.as_mut())?;
        self.solve(image.as_mut())?;
        self.expanded += width;
        self.append(image, Some(first))
    }

    /// `x ← K⁻¹ x`, or what that was before the search was stopped. The first rank knows for all.
    fn solve(&mut self, mut x: MatMut<'_, f64>) -> Result<(), EngineError> {
        let address = self.kept.map(|kept| (kept, kept.address(x.rb())));
        let found = address.and_then(|(kept, address)| kept.find(address));
        if self.rows.agree_whether(found.is_some())? {
            return self.rows.scatter(found.as_ref(), x);
        }
        let begun = Instant::now();
        self.rows.solve(x.rb_mut())?;
        let keeps = self.kept.is_some_and(|kept| kept.keeps(begun.elapsed()));
        if self.rows.agree_whether(keeps)? {
            let answers = self.rows.gather(x.rb().to_owned())?;
            if let Some((kept, address)) = address {
                kept.keep(address, answers);
            }
        }
        Ok(())
    }

    /// True if the user wants the search to stop.
    pub(crate) fn is_stopped(&mut self) -> Result<bool, EngineError> {
        self.rows.agree_whether(self.kept.is_some_and(CachedSolves::cancelled))
    }

    /// Orthonormalises a block against the basis and appends what is left of it, as far as there is room.
    /// With `images_of`, the block is the image of the basis columns from there on, and the coefficients
    /// taken off it are entries of the projection.
    fn append(&mut self, block: Mat<f64>, images_of: Option<usize>) -> Result<(), EngineError> {
        let (old, width) = (self.used(), block.ncols());
        let joined = orthonormalise(self.rows, self.basis.as_ref(), block)?;
        let new = joined.new.ncols().min(self.capacity - old);
        self.basis.append(joined.new.subcols(0, new));
        if let Some(first) = images_of {
            self.projected.submatrix_mut(0, first, old, width).copy_from(joined.onto_old);
            self.projected.submatrix_mut(old, first, new, width).copy_from(joined.onto_new.subrows(0, new));
        }
        Ok(())
    }

    /// Rayleigh–Ritz on the expanded part. The image of a Ritz vector leaves that part only into the
    /// frontier, so the frontier rows of the projection give its residual.
    ///
    /// The first rank decides for all: ranks on unlike processors need not round alike.
    ///
    /// # Errors
    /// [`ModesError`]: matrices with entries that are not numbers, a rank that was lost.
    pub(crate) fn ritz(&mut self) -> Result<RitzPairs, ModesError> {
        let m = self.expanded;
        let symmetric = Mat::from_fn(m, m, |i, j| 0.5 * (self.projected[(i, j)] + self.projected[(j, i)]));
        let (ascending, vectors) = symmetric_eigen(symmetric.as_ref())?;
        let mut vectors = vectors.as_ref().reverse_cols().to_owned();
        let frontier = self.projected.submatrix(m, 0, self.frontier(), m) * &vectors;
        let mut values: Vec<f64> = ascending.into_iter().rev().collect();
        let mut residuals: Vec<f64> = (0..m).map(|j| frontier.col(j).norm_l2() / values[j].abs()).collect();
        self.rows.agree(&mut values)?;
        self.rows.agree(&mut residuals)?;
        agree_matrix(self.rows, &mut vectors)?;
        Ok(RitzPairs { values, vectors, residuals })
    }

    /// Ritz vectors over the dofs, with their true residuals; without rows on other ranks than the first.
    pub(crate) fn modes(&mut self, ritz: &RitzPairs, count: usize) -> Result<Modes, ModesError> {
        let n = self.basis.as_ref().nrows();
        // A singular mass shows as θ = 0, to rounding.
        let found = ritz.values.iter().take(count).filter(|&&t| t > 1e-15 * ritz.values[0]).count();
        if found < count {
            return Err(ModesError::SingularMass { found });
        }
        let basis = self.basis.as_ref().subcols(0, self.expanded);
        let vectors = product(basis, ritz.vectors.subcols(0, count));
        let (quotients, residuals) = self.quotients_and_residuals(vectors.as_ref())?;
        // Close pairs may change places by rounding.
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|&i, &j| quotients[i].total_cmp(&quotients[j]));
        let [eigenvalues, residuals] =
            [quotients, residuals].map(|of| order.iter().map(|&j| of[j]).collect::<Vec<f64>>());
        let vectors = Mat::from_fn(n, count, |i, j| vectors[(i, order[j])]);
        let mut vectors = self.rows.gather(vectors)?;
        for j in 0..count {
            turn_positive(vectors.col_as_slice_mut(j));
        }
        Ok(Modes { eigenvalues, vectors, residuals })
    }

    /// `λ = xᵀKx / xᵀMx` and `‖K⁻¹M x − x/λ‖_M λ` of vectors `x` of length one, both from products with the
    /// matrices, not from the recurrence.
    ///
    /// The quotient is stationary at a mode, so a vector error counts by its square, and free of the factor's
    /// rounding, which on slender bodies shifts the lowest `1/θ` by some 1e-9. So does that of a plain
    /// product on still more slender ones. The residual is that of `K⁻¹ (λ M x − K x)`, of a small force,
    /// which the factor's rounding changes by as little.
    fn quotients_and_residuals(
        &mut self,
        vectors: MatRef<'_, f64>,
    ) -> Result<(Vec<f64>, Vec<f64>), EngineError> {
        let (mut quotients, mut residuals) = (vec![], vec![]);
        for first in (0..vectors.ncols()).step_by(AT_ONCE) {
            let width = AT_ONCE.min(vectors.ncols() - first);
            let vectors = vectors.subcols(first, width);
            let [mut forces, mut weighted] = [(); 2].map(|()| Mat::zeros(vectors.nrows(), width));
            self.rows.mul_stiffness(vectors, forces.as_mut())?;
            self.rows.mul_mass(vectors, weighted.as_mut())?;
            let [mut elastic, mut inert] = [&forces, &weighted].map(|image| squares(vectors, image.as_ref()));
            self.rows.sum(&mut elastic)?;
            self.rows.sum(&mut inert)?;
            for c in 0..width {
                if f64::EPSILON * self.stiffest * inert[c] > CANCELS * elastic[c] {
                    let (vector, mut force) = (vectors.subcols(c, 1), forces.as_mut().subcols_mut(c, 1));
                    self.rows.mul_stiffness_closely(vector, force.rb_mut())?;
                    let mut close = squares(vector, force.rb());
                    self.rows.sum(&mut close)?;
                    elastic[c] = close[0];
                }
                let quotient = elastic[c] / inert[c];
                let left = forces.col_as_slice_mut(c).iter_mut().zip(weighted.col_as_slice(c));
                left.for_each(|(force, weight)| *force = quotient * weight - *force);
                quotients.push(quotient);
            }
            self.rows.solve(forces.as_mut())?;
            self.rows.mul_mass(forces.as_ref(), weighted.as_mut())?;
            let mut left = squares(forces.as_ref(), weighted.as_ref());
            self.rows.sum(&mut left)?;
            residuals.extend(left.into_iter().map(|square| square.max(0.0).sqrt()));
        }
        Ok((quotients, residuals))
    }
}

/// Makes the entry of largest magnitude positive: the sign of a mode is otherwise an accident.
fn turn_positive(vector: &mut [f64]) {
    let largest = vector.iter().fold(0.0_f64, |l, &x| if x.abs() > l.abs() { x } else { l });
    if largest < 0.0 {
        vector.iter_mut().for_each(|x| *x = -*x);
    }
}

/// `aᵀb` of each pair of columns.
fn squares(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Vec<f64> {
    let of = |c| contiguous(a, c).iter().zip(contiguous(b, c)).map(|(x, y)| x * y).sum();
    (0..a.ncols()).map(of).collect()
}
