//! Distance of other motions from the reference solution, in the mass norm.
//!
//! Distances are norms of differences: a motion is written over the vectors of the reference and, where it
//! leaves their span, over more vectors orthonormal to them. Nothing is the difference of two squares, so an
//! error of 1e-10 is measured as well as one of 1.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

use super::solution::{ReferenceSolution, ReferenceTrajectory, WINDOW, Windows};
use crate::dynamics::orthonormal::{BlockSplit, orthonormalise_here};
use crate::fem::SymmetricMatrix;

/// A part of a motion, `u(t) = Σ_j c_j a_j(t)`.
#[derive(Clone, Copy)]
pub struct MotionPart<'m> {
    /// `c_j` over the free dofs, shape (n, k); any columns.
    pub columns: MatRef<'m, f64>,
    /// `a_j` at each instant, the start included; shape (k, instants).
    pub amplitudes: MatRef<'m, f64>,
}

/// Relative L2 distances over all dofs and instants, mass norm.
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("floor", "projection error", "best-approximation error"))]
pub struct ReferenceDistance {
    /// Of the motion from the reference solution.
    pub error: f64,
    /// Projection error: of the reference solution from its projection on the columns of the first part of
    /// the motion.
    pub floor: f64,
}

/// Columns split into their part in the space of a reference solution and the orthogonal complement: the
/// comparison of many motions in these columns needs the split once.
pub struct Complement {
    /// The columns over the vectors of the reference, shape (m, k).
    onto_old: Mat<f64>,
    /// Their remainder, over further orthonormal vectors; shape (k', k).
    onto_new: Mat<f64>,
}

impl ReferenceSolution<'_> {
    /// Splits columns over the free dofs, shape (n, k). Costs 8 n k products for each vector of
    /// the space.
    pub fn complement(&self, columns: Mat<f64>) -> Complement {
        let BlockSplit { onto_old, onto_new, .. } =
            orthonormalise_here(self.pencil.mass(), self.space(), columns);
        Complement { onto_old, onto_new }
    }
}

impl Complement {
    /// Squares of the distance in the mass of the motion `Σ_j c_j a_j(t)` of the columns from a trajectory,
    /// at each instant. `coordinates` are those of the trajectory over the space, shape (m, instants), and
    /// `amplitudes` have shape (k, instants).
    ///
    /// # Panics
    /// If a shape does not fit.
    pub fn squares_apart(&self, coordinates: Mat<f64>, amplitudes: MatRef<'_, f64>) -> Vec<f64> {
        let instants = coordinates.ncols();
        let [inside, beyond] = self.apart(coordinates, amplitudes);
        (0..instants).map(|t| inside.col(t).squared_norm_l2() + beyond.col(t).squared_norm_l2()).collect()
    }

    /// Some instants of the reference less the columns with their amplitudes: what differs along its vectors
    /// and the part beyond them.
    fn apart(&self, window: Mat<f64>, amplitudes: MatRef<'_, f64>) -> [Mat<f64>; 2] {
        let mut apart = window;
        matmul(apart.as_mut(), Accum::Add, self.onto_old.as_ref(), amplitudes, -1.0, Par::Seq);
        let mut beyond = Mat::zeros(self.onto_new.nrows(), apart.ncols());
        matmul(beyond.as_mut(), Accum::Replace, self.onto_new.as_ref(), amplitudes, 1.0, Par::Seq);
        [apart, beyond]
    }
}

impl<'t> ReferenceTrajectory<'t> {
    /// Distance of a motion from this one. The motion is the sum of its parts: a basis with its coordinates,
    /// and perhaps columns that follow the loads statically. The floor is that of the first part.
    ///
    /// # Panics
    /// If a part has another number of dofs or of instants.
    pub fn distance(&self, parts: &[MotionPart<'_>]) -> ReferenceDistance {
        let truth = self.truth;
        let count: usize = parts.iter().map(|part| part.columns.ncols()).sum();
        let mut columns = Mat::zeros(truth.space().nrows(), count);
        let mut at = 0;
        for part in parts {
            assert_eq!(
                part.amplitudes.ncols(),
                self.instants(),
                "instants of the motion and of the reference"
            );
            columns.subcols_mut(at, part.columns.ncols()).copy_from(part.columns);
            at += part.columns.ncols();
        }
        let complement = truth.complement(columns);
        let basis = parts.first().map_or(0, |part| part.columns.ncols());
        let floor = ProjectionError::new(
            complement.onto_old.subcols(0, basis),
            complement.onto_new.subcols(0, basis),
        );
        let mut sums = [0.0; 3];
        for (first, window) in self.windows() {
            let width = window.ncols();
            let mut amplitudes = Mat::zeros(count, width);
            let mut at = 0;
            for part in parts {
                let rows = part.columns.ncols();
                amplitudes.subrows_mut(at, rows).copy_from(part.amplitudes.subcols(first, width));
                at += rows;
            }
            sums[0] += window.squared_norm_l2();
            sums[1] += floor.squared(window.as_ref());
            let [inside, beyond] = complement.apart(window, amplitudes.as_ref());
            sums[2] += inside.squared_norm_l2() + beyond.squared_norm_l2();
        }
        let [norm, floor, error] = sums;
        ReferenceDistance { error: (error / norm).sqrt(), floor: (floor / norm).sqrt() }
    }

    /// A meter of the distance of a motion that is marched at full order.
    pub fn marched_apart(&self) -> MarchMeter<'t> {
        let n = self.truth.space().nrows();
        MarchMeter {
            mass: self.truth.pencil.mass(),
            space: self.truth.space(),
            windows: self.windows(),
            due: self.instants(),
            marched: Mat::zeros(n, WINDOW.min(self.instants())),
            filled: 0,
            sums: [0.0; 2],
        }
    }
}

/// Projection error of coordinates over the reference space for a basis.
struct ProjectionError {
    /// Orthonormal basis in those coordinates, its part beyond the space below; shape (m + k', r).
    basis: Mat<f64>,
}

impl ProjectionError {
    fn new(onto_old: MatRef<'_, f64>, onto_new: MatRef<'_, f64>) -> ProjectionError {
        let (m, beyond, r) = (onto_old.nrows(), onto_new.nrows(), onto_old.ncols());
        let mut columns = Mat::zeros(m + beyond, r);
        columns.subrows_mut(0, m).copy_from(onto_old);
        columns.subrows_mut(m, beyond).copy_from(onto_new);
        ProjectionError { basis: columns.qr().compute_thin_Q() }
    }

    fn squared(&self, window: MatRef<'_, f64>) -> f64 {
        let m = window.nrows();
        let (inside, beyond) = self.basis.split_at_row(m);
        let coordinates = inside.transpose() * window;
        let mut left = window.to_owned();
        matmul(left.as_mut(), Accum::Add, inside, coordinates.as_ref(), -1.0, Par::Seq);
        left.squared_norm_l2() + (beyond * coordinates).squared_norm_l2()
    }
}

/// Distance of a marched motion from the reference solution, collected instant by instant.
pub struct MarchMeter<'t> {
    mass: &'t SymmetricMatrix,
    space: MatRef<'t, f64>,
    windows: Windows<'t>,
    /// Instants that have not been added yet.
    due: usize,
    /// Displacements that wait for their window, shape (n, window).
    marched: Mat<f64>,
    filled: usize,
    /// Squares of the distance and of the reference.
    sums: [f64; 2],
}

impl MarchMeter<'_> {
    /// Adds the next instant, the start first; displacement over the free dofs.
    ///
    /// # Panics
    /// If there are more instants than the reference has, or another number of dofs.
    pub fn add(&mut self, displacement: &[f64]) {
        self.marched.col_as_slice_mut(self.filled).copy_from_slice(displacement);
        self.filled += 1;
        self.due -= 1;
        if self.filled == self.marched.ncols() || self.due == 0 {
            self.compare_window();
        }
    }

    fn compare_window(&mut self) {
        let (_, window) = self.windows.next().expect("a window for every instant of the truth");
        let mut apart = self.marched.subcols_mut(0, self.filled);
        matmul(apart.as_mut(), Accum::Add, self.space, window.as_ref(), -1.0, Par::Seq);
        let mut weighted = Mat::zeros(apart.nrows(), apart.ncols());
        self.mass.mul_into(apart.as_ref(), weighted.as_mut());
        for c in 0..apart.ncols() {
            self.sums[0] += apart.as_ref().col(c).transpose() * weighted.col(c);
        }
        self.sums[1] += window.squared_norm_l2();
        self.filled = 0;
    }

    /// Relative L2 distance over all dofs and the instants added, mass norm.
    pub fn error(&self) -> f64 {
        (self.sums[0].max(0.0) / self.sums[1]).sqrt()
    }
}
