//! Constraint modes beside modes of the inside: Craig–Bampton's and Herting's methods.
//!
//! The columns `[I; Ψ]` with `Ψ = −K_xx⁻¹ K_xq` are orthogonal in the stiffness to whatever moves the inside
//! alone, so the stiffness of both methods has no block between them.

use faer::{Mat, MatRef};

use super::error::SuperelementError;
use super::partition::{Partition, solved};
use super::reduced::{Reduced, gram, hertz};
use crate::dynamics::lowest_modes;
use crate::fem::{Pencil, Symbolic};
use crate::linalg::{symmetric_eigen, transposed_product};
use crate::progress::Listener;

/// Inner motions that are a smaller share of the largest in the mass, squared, are no more than rounding.
const ROUNDING: f64 = 1e-12;

/// The body with its interfaces at rest, and its constraint modes `Ψ`, shape (inside, m).
struct Statics {
    inside: Pencil,
    symbolic: Symbolic,
    constraint: Mat<f64>,
}

impl Statics {
    fn new(partition: &Partition, listener: &dyn Listener) -> Result<Self, SuperelementError> {
        partition.check_fixed()?;
        listener.stage("constraint modes");
        let inside = partition.inside()?;
        let symbolic = Symbolic::analyze(&inside)?;
        let factor = symbolic.factor_of(inside.stiffness())?;
        let constraint = solved(&symbolic, &factor, partition.coupling(), listener)?;
        Ok(Self { inside, symbolic, constraint })
    }
}

/// Constraint modes and fixed-interface normal modes.
///
/// # Errors
/// [`SuperelementError`].
pub(super) fn craig_bampton(
    partition: &Partition,
    modes: usize,
    listener: &dyn Listener,
) -> Result<Reduced, SuperelementError> {
    let Statics { inside, symbolic, constraint } = Statics::new(partition, listener)?;
    listener.stage("fixed-interface normal modes");
    let (eigenvalues, vectors) = match modes {
        0 => (vec![], Mat::zeros(inside.n_dof(), 0)),
        _ => {
            let found = lowest_modes(&inside, &symbolic, modes)?;
            (found.eigenvalues, found.vectors)
        }
    };
    let frequencies_hz = hertz(&eigenvalues);
    Ok(joined(partition, &constraint, (&eigenvalues, vectors.as_ref()), frequencies_hz))
}

/// Constraint modes and free-interface normal modes less their static part, orthonormal in the mass and
/// orthogonal in the stiffness.
///
/// # Errors
/// [`SuperelementError`].
pub(super) fn herting(
    partition: &Partition,
    modes: usize,
    listener: &dyn Listener,
) -> Result<Reduced, SuperelementError> {
    if modes == 0 {
        return Err(SuperelementError::NoModes { method: "herting" });
    }
    let Statics { inside, constraint, .. } = Statics::new(partition, listener)?;
    listener.stage("free-interface normal modes");
    let pencil = &partition.pencil;
    let found = lowest_modes(pencil, &Symbolic::analyze(pencil)?, modes)?;
    let (m, n) = (partition.coordinates.interface, inside.n_dof());
    let vectors = found.vectors.as_ref();
    let of_interface = vectors.subrows(0, m);
    let moved = vectors.subrows(m, n).to_owned() - &constraint * of_interface;
    let times = |matrix: &crate::fem::SymmetricMatrix, columns: &Mat<f64>| {
        let mut image = Mat::zeros(columns.nrows(), columns.ncols());
        matrix.mul_into(columns.as_ref(), image.as_mut());
        image
    };
    // Orthonormal in the mass, without what is left of rounding; then along the principal axes of the
    // stiffness.
    let (values, axes) = symmetric_eigen(gram(&moved, &times(inside.mass(), &moved)).as_ref())?;
    let largest = values.last().copied().unwrap_or(0.0);
    let kept: Vec<usize> = (0..values.len()).filter(|&k| values[k] > ROUNDING * largest).collect();
    let scaled = Mat::from_fn(values.len(), kept.len(), |i, k| axes[(i, kept[k])] / values[kept[k]].sqrt());
    let moved = &moved * &scaled;
    let (eigenvalues, axes) = symmetric_eigen(gram(&moved, &times(inside.stiffness(), &moved)).as_ref())?;
    let moved = &moved * &axes;
    let frequencies_hz = found.frequencies_hz();
    Ok(joined(partition, &constraint, (&eigenvalues, moved.as_ref()), frequencies_hz))
}

/// Columns and matrices of constraint modes beside inner ones, which are orthonormal in the mass and
/// orthogonal in the stiffness.
fn joined(
    partition: &Partition,
    constraint: &Mat<f64>,
    (eigenvalues, inner): (&[f64], MatRef<'_, f64>),
    frequencies_hz: Vec<f64>,
) -> Reduced {
    let (m, n) = (partition.coordinates.interface, partition.coordinates.count());
    let r = m + inner.ncols();
    let columns = Mat::from_fn(n, r, |i, k| match (i.checked_sub(m), k.checked_sub(m)) {
        (None, None) => f64::from(u8::from(i == k)),
        (Some(i), None) => constraint[(i, k)],
        (None, Some(_)) => 0.0,
        (Some(i), Some(k)) => inner[(i, k)],
    });
    let statics = columns.as_ref().subcols(0, m).to_owned();
    let [weighed, forces] = partition.images(&statics);
    let (mass, stiffness) = (gram(&statics, &weighed), gram(&statics, &forces));
    let coupled = transposed_product(inner, weighed.as_ref().subrows(m, n - m));
    let entry = |i: usize, k: usize, statics: &Mat<f64>, own: &dyn Fn(usize) -> f64, coupled: f64| match (
        i.checked_sub(m),
        k.checked_sub(m),
    ) {
        (None, None) => statics[(i, k)],
        (Some(i), Some(k)) if i == k => own(i),
        (Some(_), Some(_)) => 0.0,
        _ => coupled,
    };
    let between = |i: usize, k: usize| match (i.checked_sub(m), k.checked_sub(m)) {
        (Some(i), None) => coupled[(i, k)],
        (None, Some(k)) => coupled[(k, i)],
        _ => 0.0,
    };
    Reduced {
        mass: Mat::from_fn(r, r, |i, k| entry(i, k, &mass, &|_| 1.0, between(i, k))),
        stiffness: Mat::from_fn(r, r, |i, k| entry(i, k, &stiffness, &|mode| eigenvalues[mode], 0.0)),
        columns,
        frequencies_hz,
        natural: None,
    }
}
