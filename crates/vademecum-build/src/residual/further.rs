//! Natural modes that follow those of a basis.
//!
//! Modes of one frequency are any basis of their space, so that a second search for more modes may turn them.
//! Where the last mode of the basis is one of several, the further ones must be what is left of the space.

use faer::{Mat, MatRef};

use crate::dynamics::{Modes, ModesError};
use crate::fem::{Pencil, SymmetricMatrix};
use crate::linalg::{product, symmetric_eigen, symmetric_part, transposed_product};

/// Modes of `found` beside `known`: as many as it has more, orthonormal in the mass, and to `known`,
/// with the eigenvalues of the pencil on their space. Both are orthonormal in the mass.
///
/// # Errors
/// [`ModesError::NoConvergence`].
pub(super) fn modes_beside(
    pencil: &Pencil,
    known: MatRef<'_, f64>,
    found: &Modes,
) -> Result<(Mat<f64>, Vec<f64>), ModesError> {
    let (r, all) = (known.ncols(), found.vectors.ncols());
    let weighed = times(pencil.mass(), known);
    // Combinations of what was found that are orthogonal to all that is known: at least `all − r`.
    let shares = transposed_product(weighed.as_ref(), found.vectors.as_ref());
    let gram = symmetric_part((shares.transpose() * &shares).as_ref());
    let (_, combinations) = symmetric_eigen(gram.as_ref())?;
    let mut rest = product(found.vectors.as_ref(), combinations.subcols(0, all - r));
    // Once more, for what rounding has left.
    let left = transposed_product(weighed.as_ref(), rest.as_ref());
    rest -= product(known, left.as_ref());

    let mass = times(pencil.mass(), rest.as_ref());
    let gram = symmetric_part(transposed_product(rest.as_ref(), mass.as_ref()).as_ref());
    let (sizes, directions) = symmetric_eigen(gram.as_ref())?;
    let scaled =
        Mat::from_fn(all - r, all - r, |i, k| directions[(i, k)] / sizes[k].max(f64::MIN_POSITIVE).sqrt());
    let rest = product(rest.as_ref(), scaled.as_ref());
    let stiffness = times(pencil.stiffness(), rest.as_ref());
    let carried = symmetric_part(transposed_product(rest.as_ref(), stiffness.as_ref()).as_ref());
    let (eigenvalues, rotation) = symmetric_eigen(carried.as_ref())?;
    Ok((product(rest.as_ref(), rotation.as_ref()), eigenvalues))
}

/// `A X`.
fn times(matrix: &SymmetricMatrix, vectors: MatRef<'_, f64>) -> Mat<f64> {
    let mut image = Mat::zeros(vectors.nrows(), vectors.ncols());
    super::complement::columns_of(vectors, image.as_mut(), |group, image| matrix.mul_into(group, image));
    image
}
