//! Dashpots as rows over the free dofs.

use std::sync::Arc;

use faer::{Mat, MatRef};

use super::dofs::DofMap;
use crate::linalg::{NoConvergence, symmetric_eigen};
use crate::store::Inputs;

/// An eigenvalue of a damping block that is a smaller share of the largest is rounding.
const ROUNDING: f64 = 1e-14;

/// Most dashpots each of which is looked at by itself.
pub(crate) const FEW_DASHPOTS: usize = 12;

/// Damping over a few dofs, shape (k, k), symmetric and positive semidefinite.
#[derive(Clone, Debug)]
pub struct DampingBlock {
    /// Its dofs.
    pub dofs: Vec<u32>,
    /// Damping over them \[N s/m\].
    pub damping: Mat<f64>,
}

/// Dashpots of a body: their damping matrix is `Σ d dᵀ` over rows `d` of free dofs and weights.
#[derive(Clone, Debug, Default)]
pub struct Dampers(Arc<Vec<Vec<(u32, f64)>>>);

impl Dampers {
    /// The rows of blocks over the dofs of a body.
    ///
    /// # Errors
    /// [`NoConvergence`]: an entry that is not a finite number.
    pub(crate) fn of(blocks: &[DampingBlock], dofs: &DofMap) -> Result<Dampers, NoConvergence> {
        let mut rows = vec![];
        for block in blocks {
            let (values, vectors) = symmetric_eigen(block.damping.as_ref())?;
            let largest = values.last().copied().unwrap_or(0.0);
            for k in (0..values.len()).filter(|&k| values[k] > ROUNDING * largest) {
                let root = values[k].sqrt();
                let terms = block.dofs.iter().enumerate().flat_map(|(i, &dof)| {
                    let weight = root * vectors[(i, k)];
                    dofs.terms(dof as usize).map(move |(free, share)| (free, weight * share))
                });
                rows.push(terms.filter(|term| term.1 != 0.0).collect());
            }
        }
        Ok(Dampers(Arc::new(rows)))
    }

    /// These rows of free dofs and weights.
    #[cfg(test)]
    pub(crate) fn of_rows(rows: Vec<Vec<(u32, f64)>>) -> Dampers {
        Dampers(Arc::new(rows))
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Number of rows.
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// Directions at most with which a search for the motion of the body begins beside its loads.
    pub fn starts(&self) -> usize {
        self.0.len().min(FEW_DASHPOTS)
    }

    /// `D a` over `n` free dofs: the forces of the rows with amplitudes `a` of shape (rows, columns).
    pub(crate) fn forces(&self, n: usize, amplitudes: MatRef<'_, f64>) -> Mat<f64> {
        let mut forces = Mat::zeros(n, amplitudes.ncols());
        for (place, row) in self.0.iter().enumerate() {
            for &(dof, weight) in row {
                for column in 0..amplitudes.ncols() {
                    forces[(dof as usize, column)] += weight * amplitudes[(place, column)];
                }
            }
        }
        forces
    }

    /// The rows: free dofs and weights.
    pub(crate) fn rows(&self) -> &[Vec<(u32, f64)>] {
        &self.0
    }

    /// `DᵀV`, a row for each `d`: shape (rows, columns of `V`).
    pub(crate) fn along(&self, vectors: MatRef<'_, f64>) -> Mat<f64> {
        let entry = |row: usize, column: usize| {
            self.0[row].iter().map(|&(dof, weight)| weight * vectors[(dof as usize, column)]).sum()
        };
        Mat::from_fn(self.0.len(), vectors.ncols(), entry)
    }

    /// `VᵀCV` of the damping matrix `C`, shape (columns, columns).
    pub fn project(&self, vectors: MatRef<'_, f64>) -> Mat<f64> {
        let along = self.along(vectors);
        along.transpose() * &along
    }

    /// The rows as inputs of a stage.
    pub(crate) fn add_to(&self, inputs: Inputs) -> Inputs {
        self.0.iter().fold(inputs, |inputs, row| {
            let (indices, weights): (Vec<u32>, Vec<f64>) = row.iter().copied().unzip();
            inputs.indices(&indices).numbers(&weights)
        })
    }
}
