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
    /// Group that a live parameter scales, counted from 1, or 0.
    pub group: usize,
}

/// Dashpots of a body: their damping matrix is `Σ d dᵀ` over rows `d` of free dofs and weights.
#[derive(Clone, Debug, Default)]
pub struct Dampers {
    rows: Arc<Vec<Vec<(u32, f64)>>>,
    /// Group of each row.
    groups: Arc<Vec<usize>>,
}

impl Dampers {
    /// The rows of blocks over the dofs of a body.
    ///
    /// # Errors
    /// [`NoConvergence`]: an entry that is not a finite number.
    pub(crate) fn of(blocks: &[DampingBlock], dofs: &DofMap) -> Result<Dampers, NoConvergence> {
        let (mut rows, mut groups) = (vec![], vec![]);
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
                groups.push(block.group);
            }
        }
        Ok(Dampers { rows: Arc::new(rows), groups: Arc::new(groups) })
    }

    /// These rows of free dofs and weights.
    #[cfg(test)]
    pub(crate) fn of_rows(rows: Vec<Vec<(u32, f64)>>) -> Dampers {
        let groups = Arc::new(vec![0; rows.len()]);
        Dampers { rows: Arc::new(rows), groups }
    }

    /// The same with the damping of each group scaled; those of none stay.
    pub(crate) fn scaled(&self, factors: &[f64]) -> Dampers {
        let root = |group: usize| group.checked_sub(1).map_or(1.0, |place| factors[place].sqrt());
        let scaled = |(row, &group): (&Vec<(u32, f64)>, &usize)| {
            row.iter().map(|&(dof, weight)| (dof, root(group) * weight)).collect()
        };
        let rows = self.rows.iter().zip(&*self.groups).map(scaled).collect();
        Dampers { rows: Arc::new(rows), groups: self.groups.clone() }
    }

    /// The dashpots of one group, or of none.
    pub(crate) fn of_group(&self, group: usize) -> Dampers {
        let own = self.rows.iter().zip(&*self.groups).filter(|(_, own)| **own == group);
        let rows: Vec<_> = own.map(|(row, _)| row.clone()).collect();
        let groups = Arc::new(vec![group; rows.len()]);
        Dampers { rows: Arc::new(rows), groups }
    }

    /// Largest number of a group.
    pub(crate) fn n_groups(&self) -> usize {
        self.groups.iter().copied().max().unwrap_or(0)
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Number of rows.
    pub fn count(&self) -> usize {
        self.rows.len()
    }

    /// Directions at most with which a search for the motion of the body begins beside its loads.
    pub fn starts(&self) -> usize {
        self.rows.len().min(FEW_DASHPOTS)
    }

    /// `D a` over `n` free dofs: the forces of the rows with amplitudes `a` of shape (rows, columns).
    pub(crate) fn forces(&self, n: usize, amplitudes: MatRef<'_, f64>) -> Mat<f64> {
        let mut forces = Mat::zeros(n, amplitudes.ncols());
        for (place, row) in self.rows.iter().enumerate() {
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
        &self.rows
    }

    /// `DᵀV`, a row for each `d`: shape (rows, columns of `V`).
    pub(crate) fn along(&self, vectors: MatRef<'_, f64>) -> Mat<f64> {
        let entry = |row: usize, column: usize| {
            self.rows[row].iter().map(|&(dof, weight)| weight * vectors[(dof as usize, column)]).sum()
        };
        Mat::from_fn(self.rows.len(), vectors.ncols(), entry)
    }

    /// `VᵀCV` of the damping matrix `C`, shape (columns, columns).
    pub fn project(&self, vectors: MatRef<'_, f64>) -> Mat<f64> {
        let along = self.along(vectors);
        along.transpose() * &along
    }

    /// The rows as inputs of a stage.
    pub(crate) fn add_to(&self, inputs: Inputs) -> Inputs {
        self.rows.iter().fold(inputs, |inputs, row| {
            let (indices, weights): (Vec<u32>, Vec<f64>) = row.iter().copied().unzip();
            inputs.indices(&indices).numbers(&weights)
        })
    }
}
