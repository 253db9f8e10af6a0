//! The matrices over the coordinates of the interfaces and the dofs that are left, and the blocks of them.

use faer::Mat;

use super::coordinates::Coordinates;
use super::error::SuperelementError;
use crate::fem::{AT_ONCE, Factor, Model, Pencil, Solve, Symbolic, SymmetricMatrix, rigid_row};
use crate::linalg::symmetric_eigen;
use crate::linalg::vec3::{norm, sub};
use crate::prepared::{Interface, InterfaceRows};
use crate::progress::{Cancelled, Listener};

/// A rigid motion that the interfaces see less of than this, in the square, is none that they fix.
const UNSEEN: f64 = 1e-12;

/// A body over `v = (q, x)`.
pub(super) struct Partition<'a> {
    model: &'a Model,
    /// Places of the reference points.
    points: &'a [[f64; 3]],
    interfaces: &'a [Interface],
    /// `S`.
    pub(super) coordinates: Coordinates,
    /// `SᵀMS` and `SᵀKS`; with its rigid motions if the body is free.
    pub(super) pencil: Pencil,
}

impl<'a> Partition<'a> {
    /// The matrices over the coordinates.
    ///
    /// # Errors
    /// [`SuperelementError`]: interfaces that share a node, coordinates that depend on each other.
    pub(super) fn new(
        model: &'a Model,
        points: &'a [[f64; 3]],
        interfaces: &'a [Interface],
    ) -> Result<Self, SuperelementError> {
        let (own, mesh, dofs) = (model.pencil(), model.mesh(), model.dofs());
        let number = |free: u32| {
            let node = dofs.dof_of_free()[free as usize] as usize / 3;
            mesh.node_ids.get(node).copied().unwrap_or(0)
        };
        let coordinates = Coordinates::new(own.n_dof(), interfaces, number)?;
        let [mass, stiffness] = [own.mass(), own.stiffness()].map(|matrix| coordinates.transformed(matrix));
        let pencil = Pencil::from_triplets(coordinates.count(), &mass, &stiffness)?;
        let found = Self { model, points, interfaces, coordinates, pencil };
        if own.rigid().is_none() {
            return Ok(found);
        }
        let m = found.coordinates.interface;
        let is_node = |place: usize| match place.checked_sub(m) {
            Some(inside) => {
                (dofs.dof_of_free()[found.coordinates.inside[inside] as usize] as usize) < dofs.n_dof()
            }
            None => found.motion(place).is_some_and(|motion| motion < 3),
        };
        let pencil = found.pencil.clone().of_free_rows(|about| found.rigid_rows(about), is_node);
        Ok(Self { pencil, ..found })
    }

    /// Motion of a coordinate of the interfaces.
    fn motion(&self, place: usize) -> Option<usize> {
        self.interfaces.iter().flat_map(|interface| &interface.coordinates).nth(place).map(|one| one.motion)
    }

    /// True of a body that nothing holds.
    pub(super) fn is_free(&self) -> bool {
        self.model.pencil().rigid().is_some()
    }

    /// A free dof under three shifts along the axes of space and three turns about a point.
    fn rigid_of_free(&self, free: usize, about: [f64; 3]) -> [f64; 6] {
        let (nodes, dofs) = (&self.model.mesh().nodes, self.model.dofs());
        let dof = dofs.dof_of_free()[free] as usize;
        match dof.checked_sub(dofs.n_dof()) {
            None => rigid_row(sub(nodes[dof / 3], about), dof % 3),
            Some(own) if own % 6 < 3 => rigid_row(sub(self.points[own / 6], about), own % 6),
            Some(own) => std::array::from_fn(|k| f64::from(u8::from(k == own % 6))),
        }
    }

    /// All coordinates under three shifts along the axes of space and three turns about a point.
    pub(super) fn rigid_rows(&self, about: [f64; 3]) -> Vec<[f64; 6]> {
        let mut rows = Vec::with_capacity(self.coordinates.count());
        for interface in self.interfaces {
            match &interface.rows {
                InterfaceRows::Means(means) => rows.extend(means.iter().map(|row| {
                    let mut sum = [0.0; 6];
                    for &(free, weight) in row {
                        let own = self.rigid_of_free(free as usize, about);
                        sum.iter_mut().zip(own).for_each(|(sum, x)| *sum += weight * x);
                    }
                    sum
                })),
                InterfaceRows::Followers(_) => rows.extend((0..6).map(|motion| {
                    // A motion of the frame, in those of the body: displacements of its origin, or its turn.
                    let axis = interface.axes[motion % 3];
                    let of_space: [[f64; 6]; 3] = std::array::from_fn(|c| match motion < 3 {
                        true => rigid_row(sub(interface.origin, about), c),
                        false => std::array::from_fn(|k| f64::from(u8::from(k == 3 + c))),
                    });
                    std::array::from_fn(|k| (0..3).map(|c| axis[c] * of_space[c][k]).sum())
                })),
            }
        }
        let inside = self.coordinates.inside.iter();
        rows.extend(inside.map(|&free| self.rigid_of_free(free as usize, about)));
        rows
    }

    /// Refuses a free body that its interfaces do not fix.
    ///
    /// # Errors
    /// [`SuperelementError::Loose`].
    pub(super) fn check_fixed(&self) -> Result<(), SuperelementError> {
        let Some(rigid) = self.pencil.rigid() else { return Ok(()) };
        let nodes = &self.model.mesh().nodes;
        let size = nodes.iter().map(|&node| norm(sub(node, rigid.centre))).fold(0.0, f64::max);
        let rows = self.rigid_rows(rigid.centre);
        let motions = self.interfaces.iter().flat_map(|interface| &interface.coordinates);
        let mut seen = Mat::zeros(6, 6);
        for (row, coordinate) in rows.iter().zip(motions) {
            // Turns of the body and rotations of frames are measured by what they move.
            let unit = if coordinate.motion < 3 { 1.0 } else { size };
            let scaled: [f64; 6] = std::array::from_fn(|k| unit * row[k] / if k < 3 { 1.0 } else { size });
            (0..6).for_each(|i| (0..6).for_each(|j| seen[(i, j)] += scaled[i] * scaled[j]));
        }
        let (values, _) = symmetric_eigen(seen.as_ref())?;
        match values.iter().filter(|&&value| value <= UNSEEN * values[5]).count() {
            0 => Ok(()),
            left => Err(SuperelementError::Loose { left }),
        }
    }

    /// The body with its interfaces at rest.
    ///
    /// # Errors
    /// [`SuperelementError::Pencil`].
    pub(super) fn inside(&self) -> Result<Pencil, SuperelementError> {
        let m = self.coordinates.interface;
        let [mass, stiffness] = [self.pencil.mass(), self.pencil.stiffness()].map(|matrix| {
            let mut entries = vec![];
            for column in m..matrix.n() {
                entries.extend(
                    entries_of(matrix, column)
                        .filter(|(row, _)| *row as usize >= m)
                        .map(|(row, value)| (row - m as u32, (column - m) as u32, value)),
                );
            }
            entries
        });
        let pencil = Pencil::from_triplets(self.coordinates.inside.len(), &mass, &stiffness)?;
        let nodes = self.model.pencil().dof_nodes().map(|nodes| {
            self.coordinates.inside.iter().map(|&free| nodes[free as usize]).collect::<Vec<u32>>()
        });
        Ok(match nodes {
            Some(nodes) => pencil.with_dof_nodes(nodes),
            None => pencil,
        })
    }

    /// `−K_xq`, shape (inside, m).
    pub(super) fn coupling(&self) -> Mat<f64> {
        let m = self.coordinates.interface;
        let mut coupling = Mat::zeros(self.coordinates.inside.len(), m);
        for column in 0..m {
            for (row, value) in entries_of(self.pencil.stiffness(), column) {
                if let Some(inside) = (row as usize).checked_sub(m) {
                    coupling[(inside, column)] = -value;
                }
            }
        }
        coupling
    }

    /// Images under mass and stiffness.
    pub(super) fn images(&self, columns: &Mat<f64>) -> [Mat<f64>; 2] {
        [self.pencil.mass(), self.pencil.stiffness()].map(|matrix| {
            let mut image = Mat::zeros(columns.nrows(), columns.ncols());
            matrix.mul_into(columns.as_ref(), image.as_mut());
            image
        })
    }
}

/// Rows and values of a column.
fn entries_of(matrix: &SymmetricMatrix, column: usize) -> impl Iterator<Item = (u32, f64)> + '_ {
    let pattern = matrix.pattern();
    pattern.rows_of(column).iter().copied().zip(matrix.values()[pattern.range(column)].iter().copied())
}

/// Solves with a factor for all columns, refined once.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn solved(
    symbolic: &Symbolic,
    factor: &Factor,
    mut columns: Mat<f64>,
    listener: &dyn Listener,
) -> Result<Mat<f64>, Cancelled> {
    let count = columns.ncols();
    let mut solve = Solve::new(symbolic, AT_ONCE.min(count.max(1)), true);
    for first in (0..count).step_by(AT_ONCE) {
        if listener.cancelled() {
            return Err(Cancelled);
        }
        listener.advance(first, count);
        let width = AT_ONCE.min(count - first);
        solve.solve_in_place(factor, columns.as_mut().subcols_mut(first, width));
    }
    Ok(columns)
}
