//! Placement of the rows of a body's matrices: in this process, or distributed over the ranks of a cluster.
//!
//! The search for modes is written once, on [`PencilRows`]: what one rank does with its rows, and what all
//! ranks do together. A rank is one of the processes that work on one body. Every rank runs the same search;
//! what they decide by are sums over all rows, which have the same bits on each of them, so that they always
//! agree. With one process the rows are all rows, and nothing is sent.

use std::fmt::Debug;
use std::sync::Arc;

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Mat, MatMut, MatRef};

use super::factor_error::FactorError;
use super::model_error::ModelError;
use super::rigid::RigidBody;
use super::sparse::SymmetricMatrix;
use super::spread::{EngineError, SpreadMatrix};
use super::whole::AssemblyPlan;

/// The inner product of the mass over the rows of all ranks.
pub trait MassProduct {
    /// `y ← M x` for blocks of shape (own rows, columns).
    ///
    /// # Errors
    /// [`EngineError`]: a rank was lost.
    fn mul_mass(&mut self, x: MatRef<'_, f64>, y: MatMut<'_, f64>) -> Result<(), EngineError>;

    /// Adds the numbers of all ranks up; each rank gets the same bits.
    ///
    /// # Errors
    /// As [`MassProduct::mul_mass`].
    fn sum(&mut self, numbers: &mut [f64]) -> Result<(), EngineError>;
}

/// Rows of the mass and of a factorised stiffness that one rank holds, and what all ranks do together.
///
/// Blocks have the shape (own rows, columns) and contiguous columns. All ranks call every function that
/// returns a `Result`, in one order.
pub trait PencilRows: MassProduct {
    /// Rows of this rank.
    fn own(&self) -> usize;

    /// Rows of all ranks.
    fn total(&self) -> usize;

    /// Copies this rank's part of a column over all rows.
    fn part_into(&self, whole: &[f64], own: &mut [f64]);

    /// `y ← K x`.
    ///
    /// # Errors
    /// As [`MassProduct::mul_mass`].
    fn mul_stiffness(&mut self, x: MatRef<'_, f64>, y: MatMut<'_, f64>) -> Result<(), EngineError>;

    /// The same with each row summed in more than the working precision and rounded once: in a slow mode of a
    /// slender body nearly all of a row cancels. Column by column, and much slower.
    ///
    /// # Errors
    /// As [`MassProduct::mul_mass`].
    fn mul_stiffness_closely(&mut self, x: MatRef<'_, f64>, y: MatMut<'_, f64>) -> Result<(), EngineError>;

    /// `x ← K⁻¹ x` by the factor alone: always the same linear map. At most
    /// [`AT_ONCE`](super::AT_ONCE) columns.
    ///
    /// # Errors
    /// As [`MassProduct::mul_mass`].
    fn solve(&mut self, x: MatMut<'_, f64>) -> Result<(), EngineError>;

    /// Overwrites the numbers by those of the first rank.
    ///
    /// # Errors
    /// As [`MassProduct::mul_mass`].
    fn agree(&mut self, numbers: &mut [f64]) -> Result<(), EngineError>;

    /// Broadcasts the numbers of the first rank.
    ///
    /// # Errors
    /// As [`MassProduct::mul_mass`].
    fn agree_whether(&mut self, yes: bool) -> Result<bool, EngineError> {
        let mut numbers = [f64::from(u8::from(yes))];
        self.agree(&mut numbers)?;
        Ok(numbers != [0.0])
    }

    /// All rows of a block on the first rank; no rows at all on the others.
    ///
    /// # Errors
    /// As [`MassProduct::mul_mass`].
    fn gather(&mut self, x: Mat<f64>) -> Result<Mat<f64>, EngineError>;

    /// Hands every rank its rows of a block that the first one has whole.
    ///
    /// # Errors
    /// As [`MassProduct::mul_mass`].
    fn scatter(&mut self, whole: Option<&Mat<f64>>, own: MatMut<'_, f64>) -> Result<(), EngineError>;
}

/// Parameters of a search on all ranks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// Modes wanted.
    pub count: usize,
    /// Modes that there are.
    pub available: usize,
    /// Ritz residual at which a mode counts as converged.
    pub tolerance: f64,
    /// Expansions of a probe block before the result is accepted.
    pub probes: usize,
    /// A Rayleigh quotient near the largest \[1/s²\], by which rounding of the stiffness is judged.
    pub stiffest: f64,
}

/// Has other ranks do their share of the work on matrices.
pub trait Engine: Debug + Send + Sync {
    /// Name of the iterative solver, with the tolerance; none where it solves by a factor.
    fn solver(&self) -> Option<String> {
        None
    }

    /// Ranks that share the work.
    fn ranks(&self) -> usize;

    /// Has each rank assemble its rows of mass and stiffness.
    ///
    /// # Errors
    /// [`ModelError::FoldedElement`], [`ModelError::TooLarge`], [`ModelError::Engine`].
    fn assemble(&self, body: &AssemblyPlan) -> Result<[Arc<dyn SpreadMatrix>; 2], ModelError>;

    /// Distributes the rows of a matrix. `order` gives the row of the matrix at each place of an elimination
    /// order: rows at near places are coupled.
    ///
    /// # Errors
    /// [`EngineError`].
    fn deal(&self, matrix: &SymmetricMatrix, order: &[u32]) -> Result<Arc<dyn SpreadMatrix>, EngineError>;

    /// Factorises a matrix whose rows lie on the ranks in this order, or sets up an iteration. `motions`,
    /// shape (n, 6), are the rigid motions of the body, three shifts first; an iteration needs them. The
    /// stiffness of a body without supports is held by springs at the dofs that its motions name.
    ///
    /// # Errors
    /// [`FactorError::NotPositiveDefinite`], [`FactorError::Engine`].
    fn factorize(
        &self,
        matrix: &dyn SpreadMatrix,
        order: &[u32],
        motions: Option<MatRef<'_, f64>>,
        rigid: Option<&Arc<RigidBody>>,
    ) -> Result<Arc<dyn SpreadFactor>, FactorError>;
}

/// A factor distributed over several ranks.
pub trait SpreadFactor: Debug + Send + Sync {
    /// Overwrites `rhs`, shape (n, columns) with all rows, by `A⁻¹ rhs`. A failure of the ranks ends the
    /// program with its cause.
    fn solve_in_place(&self, rhs: MatMut<'_, f64>);

    /// Has all other ranks begin this search with a mass distributed like the matrix; the caller is the first
    /// rank.
    ///
    /// # Errors
    /// [`EngineError`].
    fn begin<'a>(
        &'a self,
        mass: Arc<dyn SpreadMatrix>,
        search: &Search,
    ) -> Result<Box<dyn PencilRows + 'a>, EngineError>;
}

/// The mass of a body whose rows are all in this process.
pub(crate) struct LocalMass<'a>(pub &'a SymmetricMatrix);

impl MassProduct for LocalMass<'_> {
    fn mul_mass(&mut self, x: MatRef<'_, f64>, y: MatMut<'_, f64>) -> Result<(), EngineError> {
        self.0.mul_into(x, y);
        Ok(())
    }

    fn sum(&mut self, _: &mut [f64]) -> Result<(), EngineError> {
        Ok(())
    }
}

/// Adds the matrices of all ranks up.
pub(crate) fn sum_matrix(rows: &mut dyn MassProduct, matrix: &mut Mat<f64>) -> Result<(), EngineError> {
    each_number(matrix, |numbers| rows.sum(numbers))
}

/// Overwrites a matrix by that of the first rank.
pub(crate) fn agree_matrix(rows: &mut dyn PencilRows, matrix: &mut Mat<f64>) -> Result<(), EngineError> {
    each_number(matrix, |numbers| rows.agree(numbers))
}

/// Shows the entries of a matrix, column by column, to what may change them.
fn each_number(
    matrix: &mut Mat<f64>,
    change: impl FnOnce(&mut [f64]) -> Result<(), EngineError>,
) -> Result<(), EngineError> {
    let mut numbers: Vec<f64> = matrix.rb().col_iter().flat_map(|c| c.iter().copied()).collect();
    change(&mut numbers)?;
    let mut numbers = numbers.into_iter();
    for column in matrix.rb_mut().col_iter_mut() {
        column.iter_mut().zip(&mut numbers).for_each(|(entry, number)| *entry = number);
    }
    Ok(())
}
