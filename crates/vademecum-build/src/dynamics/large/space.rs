//! The motions among which Newton's method looks for its corrections: all, or those of a basis.
//!
//! With the basis `V` a correction is `p = −V (VᵀKV)⁻¹ Vᵀr`, which is Galerkin's method: whatever begins in
//! the span of `V` stays there, and all else of the march is that of the full order.

use faer::linalg::solvers::{Llt, LltError, SolveCore};
use faer::{Conj, Mat, MatMut, MatRef, Side};

use super::error::LargeError;
use crate::dynamics::FullOrderError;
use crate::dynamics::initial::solve_mass;
use crate::fem::{Factor, FactorError, Pencil, Solve, Symbolic, SymmetricMatrix};
use crate::linalg::{project, transposed_product};

/// The motions among which a balance is sought.
#[derive(Clone, Copy)]
pub(super) enum MotionSpace<'a> {
    /// All of them, with the structure of their factor.
    Whole(&'a Symbolic),
    /// Those of a basis, shape (n, r), orthonormal in the mass.
    Span(MatRef<'a, f64>),
}

/// A factor of a tangent.
#[derive(Clone)]
// A few values for a march.
#[allow(clippy::large_enum_variant)]
pub(super) enum SpaceFactor {
    Whole(Factor),
    Span(Llt<f64>),
}

impl MotionSpace<'_> {
    pub(crate) fn factorise(self, tangent: SymmetricMatrix) -> Result<SpaceFactor, FactorError> {
        let basis = match self {
            MotionSpace::Whole(symbolic) => return Ok(SpaceFactor::Whole(symbolic.factorize(tangent)?)),
            MotionSpace::Span(basis) => basis,
        };
        let mut image = Mat::zeros(basis.nrows(), basis.ncols());
        tangent.mul_into(basis, image.as_mut());
        let factor = transposed_product(basis, image.as_ref()).llt(Side::Lower);
        factor.map(SpaceFactor::Span).map_err(|LltError::NonPositivePivot { index }| {
            FactorError::NotPositiveDefinite { pivot: index, n: basis.ncols() }
        })
    }

    /// `−K⁻¹r` among these motions; `memory` is kept from one to the next.
    pub(crate) fn correction(self, factor: &SpaceFactor, r: &[f64], memory: &mut Option<Solve>) -> Vec<f64> {
        let mut p: Vec<f64> = r.iter().map(|r| -r).collect();
        let column = MatMut::from_column_major_slice_mut(&mut p, r.len(), 1);
        match (self, factor) {
            (MotionSpace::Whole(symbolic), SpaceFactor::Whole(factor)) => {
                memory.get_or_insert_with(|| Solve::new(symbolic, 1, false)).solve_in_place(factor, column);
            }
            (MotionSpace::Span(basis), SpaceFactor::Span(factor)) => {
                let mut reduced = basis.transpose() * &column;
                factor.solve_in_place_with_conj(Conj::No, reduced.as_mut());
                p = (basis * reduced).col_as_slice(0).to_vec();
            }
            _ => unreachable!("a factor is used in the space in which it was made"),
        }
        p
    }

    /// `M⁻¹f` among these motions.
    pub(crate) fn acceleration(self, pencil: &Pencil, f: &[f64]) -> Result<Vec<f64>, LargeError> {
        let mut a = vec![0.0; f.len()];
        match self {
            MotionSpace::Whole(_) => {
                solve_mass(pencil, f, &mut a).ok_or(FullOrderError::SingularMass)?;
            }
            MotionSpace::Span(basis) => {
                let shares = project(basis, f);
                let column = MatRef::from_column_major_slice(&shares, shares.len(), 1);
                a.copy_from_slice((basis * column).col_as_slice(0));
            }
        }
        Ok(a)
    }
}
