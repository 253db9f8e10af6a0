//! Free-interface normal modes beside residual attachment modes: Rubin's and MacNeal's methods.
//!
//! With `X = R Eᵀ`, the answers of what the modes `Φ` leave out to unit forces along the coordinates, the
//! body moves as `v = X f + Φ η`. At the interface that is `q = F f + Φ_q η` with `F = E R Eᵀ`, so
//! `f = F⁻¹ (q − Φ_q η)`, and the coordinates are `(q, η)`. `X` is orthogonal to `Φ` in the mass and in the
//! stiffness, so `M` over `(f, η)` is `diag(H, I)` with `H = XᵀMX`, and `K` is `diag(F, Λ)`. Without `H` the
//! method is MacNeal's.

use faer::linalg::solvers::Solve as _;
use faer::{Mat, MatRef};

use super::error::SuperelementError;
use super::partition::{Partition, solved};
use super::reduced::{Reduced, gram, hertz};
use crate::dynamics::lowest_modes;
use crate::fem::Symbolic;
use crate::linalg::{symmetric_part, transposed_product};
use crate::progress::Listener;

/// Free-interface modes, rigid motions first, and residual attachment modes; `weighed` with their mass.
///
/// # Errors
/// [`SuperelementError`].
pub(super) fn rubin(
    partition: &Partition,
    modes: usize,
    weighed: bool,
    listener: &dyn Listener,
) -> Result<Reduced, SuperelementError> {
    if modes == 0 {
        return Err(SuperelementError::NoModes { method: if weighed { "rubin" } else { "macneal" } });
    }
    let (m, n) = (partition.coordinates.interface, partition.coordinates.count());
    let pencil = &partition.pencil;
    listener.stage("free-interface normal modes");
    let symbolic = Symbolic::analyze(pencil)?;
    let found = lowest_modes(pencil, &symbolic, modes)?;
    listener.stage("residual attachment modes");
    let factor = symbolic.factor_of(pencil.stiffness())?;
    let unit = Mat::from_fn(n, m, |i, k| f64::from(u8::from(i == k)));
    let answers = solved(&symbolic, &factor, unit, listener)?;
    let of_interface = found.vectors.as_ref().subrows(0, m);
    let shares = Mat::from_fn(modes, m, |k, i| of_interface[(i, k)] / found.eigenvalues[k]);
    let attachment = answers - &found.vectors * &shares;
    let [image, _] = partition.images(&attachment);
    let rigid = pencil.rigid().map_or_else(|| Mat::zeros(n, 0), |rigid| rigid.motions().to_owned());
    let first = rigid.ncols();
    let basis = Mat::from_fn(n, first + modes, |i, k| match k.checked_sub(first) {
        None => rigid[(i, k)],
        Some(mode) => found.vectors[(i, mode)],
    });
    let eigenvalues: Vec<f64> =
        std::iter::repeat_n(0.0, first).chain(found.eigenvalues.iter().copied()).collect();
    let inertia = gram(&attachment, &image);
    let at_interface = AtInterface {
        modes: basis.as_ref().subrows(0, m),
        eigenvalues: &eigenvalues,
        flexibility: attachment.as_ref().subrows(0, m),
        inertia: weighed.then_some(inertia.as_ref()),
    };
    let none = || SuperelementError::NoResidual { modes, coordinates: m };
    let ByForces { mass, stiffness, forces } = at_interface.reduced().ok_or_else(none)?;
    let moved = &attachment * &forces;
    let columns = Mat::from_fn(n, mass.ncols(), |i, k| {
        let of_mode = k.checked_sub(m).map_or(0.0, |mode| basis[(i, mode)]);
        // Coordinates of the interface are exactly what they are.
        if i < m { f64::from(u8::from(i == k)) } else { moved[(i, k)] + of_mode }
    });
    let frequencies_hz = hertz(&found.eigenvalues);
    Ok(Reduced { columns, frequencies_hz, mass, stiffness, natural: Some(eigenvalues) })
}

/// Input of the method: modes and residual flexibility at its interfaces.
#[derive(Clone, Copy, Debug)]
pub struct AtInterface<'a> {
    /// `Φ_q`, shape (m, modes), rigid motions among them.
    pub modes: MatRef<'a, f64>,
    /// `Λ` \[rad²/s²\], zero of rigid motions.
    pub eigenvalues: &'a [f64],
    /// `F` \[m/N\], shape (m, m).
    pub flexibility: MatRef<'a, f64>,
    /// `H` \[kg m²/N²\], shape (m, m); without it the method is MacNeal's.
    pub inertia: Option<MatRef<'a, f64>>,
}

/// Matrices over `(q, η)`, and the forces of the attachment modes.
#[derive(Clone, Debug)]
pub struct ByForces {
    /// Mass, shape (m + modes, m + modes).
    pub mass: Mat<f64>,
    /// Stiffness, of the same shape.
    pub stiffness: Mat<f64>,
    /// `W = F⁻¹ [I, −Φ_q]`, so that `f = W (q, η)`, shape (m, m + modes).
    pub forces: Mat<f64>,
}

impl AtInterface<'_> {
    /// The matrices over `(q, η)`; `None` if the flexibility is not positive definite.
    pub fn reduced(&self) -> Option<ByForces> {
        let m = self.modes.nrows();
        let r = m + self.modes.ncols();
        let factor = symmetric_part(self.flexibility).llt(faer::Side::Lower).ok()?;
        let right = Mat::from_fn(m, r, |i, k| match k.checked_sub(m) {
            None => f64::from(u8::from(i == k)),
            Some(mode) => -self.modes[(i, mode)],
        });
        let forces = factor.solve(&right);
        let own = |i: usize, k: usize, value: f64| if i == k && i >= m { value } else { 0.0 };
        let of_forces = symmetric_part(transposed_product(forces.as_ref(), right.as_ref()).as_ref());
        let stiffness = Mat::from_fn(r, r, |i, k| {
            of_forces[(i, k)] + own(i, k, i.checked_sub(m).map_or(0.0, |mode| self.eigenvalues[mode]))
        });
        let of_residual = match self.inertia {
            Some(inertia) => symmetric_part((forces.transpose() * inertia * &forces).as_ref()),
            None => Mat::zeros(r, r),
        };
        let mass = Mat::from_fn(r, r, |i, k| of_residual[(i, k)] + own(i, k, 1.0));
        Some(ByForces { mass, stiffness, forces })
    }
}
