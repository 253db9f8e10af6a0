//! Full-order trajectories kept whole, and distances between trajectories.
//!
//! All distances are L2 over all dofs and instants in the mass norm, `√Σ‖u − w‖²_M`.

use faer::{Mat, MatRef};

use vademecum_build::dynamics::{FullOrder, MarchError, TimedLoad, march_full_order};
use vademecum_build::fem::SymmetricMatrix;
use vademecum_build::progress::Listener;

/// Columns compared at once: enough for the product with `M` to be bound by the columns and not by `M`.
const AT_ONCE: usize = 32;

/// Displacement of a march from rest \[m\], `split` steps of `full` for each of the `steps` instants kept,
/// the start included; shape (n, steps + 1).
pub(super) fn march(
    full: &FullOrder<'_>,
    split: usize,
    loads: &[TimedLoad],
    steps: usize,
    listener: &dyn Listener,
) -> Result<Mat<f64>, MarchError> {
    let mut displacement = Mat::zeros(full.n_dof(), steps + 1);
    march_full_order(full, loads, 1, split * steps, listener, |step, state| {
        if step % split == 0 {
            displacement.col_mut(step / split).copy_from(state.displacement.col(0));
        }
    })?;
    Ok(displacement)
}

/// The same loads, each at half its height where it jumps: an instant of the march that falls on a jump takes
/// the mean of both sides, without which a scheme of second order is one of first order. `tie` \[s\] is short
/// against a step.
///
/// Each load becomes two of half its size, the second one `tie` later (but from the start if it acts at time
/// zero).
pub(super) fn mean_at_jumps(loads: &[TimedLoad], tie: f64) -> Vec<TimedLoad> {
    let halves = |load: &TimedLoad| {
        let force: Vec<f64> = load.force.iter().map(|f| 0.5 * f).collect();
        let mut late = load.when.clone();
        late.during.start += if late.during.start > 0.0 { tie } else { 0.0 };
        late.during.end += tie;
        [load.when.clone(), late].map(|when| TimedLoad { column: load.column, force: force.clone(), when })
    };
    loads.iter().flat_map(halves).collect()
}

/// A trajectory as errors are measured from it: the mass norm is known once.
pub(super) struct Reference {
    /// Displacement at each instant, shape (n, instants).
    pub displacement: Mat<f64>,
    /// `M u`, same shape.
    weighted: Mat<f64>,
    /// `√Σ‖u‖²_M`.
    pub norm: f64,
}

impl Reference {
    /// Measures a trajectory.
    pub fn new(mass: &SymmetricMatrix, displacement: Mat<f64>) -> Self {
        let mut weighted = Mat::zeros(displacement.nrows(), displacement.ncols());
        mass.mul_into(displacement.as_ref(), weighted.as_mut());
        let norm = (0..displacement.ncols()).map(|j| displacement.col(j).transpose() * weighted.col(j));
        let norm = norm.sum::<f64>().sqrt();
        Self { displacement, weighted, norm }
    }

    /// Its projection on a basis.
    pub fn project(&self, mass: &SymmetricMatrix, basis: MatRef<'_, f64>) -> Projection {
        let coordinates = basis.transpose() * &self.weighted;
        let floor = self.apart(mass, basis, &coordinates);
        Projection { coordinates, floor, norm: self.norm }
    }

    /// `‖u − Bζ‖ ÷ ‖u‖` for columns `B`, M-orthonormal or not.
    pub fn error(&self, mass: &SymmetricMatrix, basis: MatRef<'_, f64>, coordinates: &Mat<f64>) -> f64 {
        self.apart(mass, basis, coordinates) / self.norm
    }

    fn apart(&self, mass: &SymmetricMatrix, basis: MatRef<'_, f64>, coordinates: &Mat<f64>) -> f64 {
        norm(mass, self.displacement.ncols(), |start, count| {
            self.displacement.subcols(start, count) - basis * coordinates.subcols(start, count)
        })
    }
}

/// A trajectory projected on an M-orthonormal basis.
///
/// `u − Bζ = (u − BBᵀMu) + B(BᵀMu − ζ)` and the two are M-orthogonal, so the parts are summed apart: the
/// floor keeps its digits however small the rest is.
pub(super) struct Projection {
    /// `BᵀMu`, shape (r, instants).
    coordinates: Mat<f64>,
    floor: f64,
    norm: f64,
}

impl Projection {
    /// `‖u − BBᵀMu‖ ÷ ‖u‖`: the projection error.
    pub fn floor(&self) -> f64 {
        self.floor / self.norm
    }

    /// `‖u − Bζ‖ ÷ ‖u‖`.
    ///
    /// # Panics
    /// If the shapes differ.
    pub fn error(&self, coordinates: &Mat<f64>) -> f64 {
        self.floor.hypot((&self.coordinates - coordinates).norm_l2()) / self.norm
    }

    /// `‖BBᵀMu − Bζ‖ ÷ ‖u‖`: the error without the floor.
    ///
    /// # Panics
    /// If the shapes differ.
    pub fn beside_floor(&self, coordinates: &Mat<f64>) -> f64 {
        (&self.coordinates - coordinates).norm_l2() / self.norm
    }
}

/// `√Σ‖u − w‖²_M` of two trajectories, both (n, instants).
pub(super) fn distance(mass: &SymmetricMatrix, u: MatRef<'_, f64>, w: MatRef<'_, f64>) -> f64 {
    norm(mass, w.ncols(), |start, count| u.subcols(start, count) - w.subcols(start, count))
}

/// `√Σ‖Bζ − B'ζ'‖²_M` of two pairs of columns and coordinates over the same instants.
pub(super) fn distance_on_bases(
    mass: &SymmetricMatrix,
    [(basis, zeta), (other, other_zeta)]: [(&Mat<f64>, &Mat<f64>); 2],
) -> f64 {
    norm(mass, zeta.ncols(), |start, count| {
        basis * zeta.subcols(start, count) - other * other_zeta.subcols(start, count)
    })
}

/// `√Σ_j x_jᵀ M x_j` over the columns of a trajectory that is given some instants at a time: the first, how
/// many.
fn norm(mass: &SymmetricMatrix, instants: usize, columns: impl Fn(usize, usize) -> Mat<f64>) -> f64 {
    let squared = |start: usize| {
        let columns = columns(start, AT_ONCE.min(instants - start));
        let mut weighted = Mat::zeros(columns.nrows(), columns.ncols());
        mass.mul_into(columns.as_ref(), weighted.as_mut());
        (0..columns.ncols()).map(|j| columns.col(j).transpose() * weighted.col(j)).sum::<f64>()
    };
    (0..instants).step_by(AT_ONCE).map(squared).sum::<f64>().sqrt()
}

/// Every `stride`-th instant of a trajectory.
pub(super) fn thinned(trajectory: &Mat<f64>, stride: usize) -> Mat<f64> {
    let columns = trajectory.ncols().div_ceil(stride);
    let mut out = Mat::zeros(trajectory.nrows(), columns);
    (0..columns).for_each(|j| out.col_mut(j).copy_from(trajectory.col(stride * j)));
    out
}
