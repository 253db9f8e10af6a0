//! Space compression: a few dozen vectors that hold solutions of one body, orthonormal in the energy.
//!
//! Solutions at many parameter points share most of what they are made of. The [`compress`]ed basis of a few
//! of them turns a problem over the whole mesh into a small dense one, and every stage after it costs the
//! same for a beam and for a liver. The basis is built column by column, so that tolerances near rounding are
//! met.

use super::error::{SeparatedError, check_len};
use super::linalg::{add_product, inner, product, thin_svd, transposed_product};
use faer::{Mat, MatRef};

/// The energy inner product: `M X` for a block `X`, `M` symmetric positive definite.
pub type Energy<'a> = dyn Fn(MatRef<'_, f64>) -> Mat<f64> + Sync + 'a;

/// `M`-orthonormal basis `(n, k)` of the blocks, to a relative `tolerance` in the energy norm, every block
/// counted relative to its own size. By orthogonalisation and a small decomposition, so tolerances near
/// rounding are met (a Gram matrix would lose half of the digits).
///
/// # Errors
/// [`SeparatedError::Shape`]; [`SeparatedError::NoConvergence`] when an entry is not finite.
pub(crate) fn compress(
    samples: &[Mat<f64>],
    energy: &Energy<'_>,
    tolerance: f64,
) -> Result<Mat<f64>, SeparatedError> {
    let mut basis = EnergyBasis::new(samples.first().map_or(0, |x| x.nrows()));
    for x in samples {
        check_len("rows of a sample", samples[0].nrows(), x.nrows())?;
        basis.append(x.as_ref(), energy, 1e-2 * tolerance);
    }
    basis.truncated(tolerance)
}

/// An orthonormal basis that grows, and the coordinates of everything it was grown from.
pub struct EnergyBasis {
    /// `(n, k)`.
    vectors: Mat<f64>,
    /// `M vectors`.
    images: Mat<f64>,
    /// Coordinates of each appended block, scaled to unit energy: `(k at that time, n_columns)`.
    coordinates: Vec<Mat<f64>>,
}

impl EnergyBasis {
    /// No vectors yet, of length `n`.
    pub fn new(n: usize) -> EnergyBasis {
        EnergyBasis { vectors: Mat::zeros(n, 0), images: Mat::zeros(n, 0), coordinates: Vec::new() }
    }

    /// Adds what a block has outside the basis, leaving out columns whose remainder is below `drop` of the
    /// block.
    pub fn append(&mut self, block: MatRef<'_, f64>, energy: &Energy<'_>, drop: f64) {
        let size = inner(block, energy(block).as_ref()).max(0.0).sqrt();
        if size == 0.0 {
            return;
        }
        let n = block.nrows();
        let mut rest = Mat::from_fn(n, block.ncols(), |i, j| block[(i, j)] / size);
        let mut coordinates = Mat::zeros(self.vectors.ncols() + block.ncols(), block.ncols());
        for j in 0..block.ncols() {
            let mut v = rest.as_mut().subcols_mut(j, 1).to_owned();
            // Twice is enough: the second pass removes what rounding left of the first.
            for _ in 0..2 {
                let c = transposed_product(self.images.as_ref(), v.as_ref());
                add_product(v.as_mut(), -1.0, self.vectors.as_ref(), c.as_ref());
                (0..c.nrows()).for_each(|i| coordinates[(i, j)] += c[(i, 0)]);
            }
            let image = energy(v.as_ref());
            let length = inner(v.as_ref(), image.as_ref()).max(0.0).sqrt();
            if length > drop.max(8.0 * f64::EPSILON) {
                coordinates[(self.vectors.ncols(), j)] = length;
                push_column(&mut self.vectors, &v, length);
                push_column(&mut self.images, &image, length);
            }
        }
        self.coordinates.push(coordinates);
    }

    /// The basis as it stands.
    pub fn into_vectors(self) -> Mat<f64> {
        self.vectors
    }

    /// The leading directions of all coordinates, to a relative `tolerance`.
    fn truncated(&self, tolerance: f64) -> Result<Mat<f64>, SeparatedError> {
        let k = self.vectors.ncols();
        let columns: usize = self.coordinates.iter().map(|c| c.ncols()).sum();
        let mut all = Mat::zeros(k, columns);
        let mut at = 0;
        for c in &self.coordinates {
            for j in 0..c.ncols() {
                (0..c.nrows().min(k)).for_each(|i| all[(i, at)] = c[(i, j)]);
                at += 1;
            }
        }
        let (u, s, _) = thin_svd(all.as_ref())?;
        let total: f64 = s.iter().map(|x| x * x).sum();
        let (mut kept, mut tail) = (s.len(), 0.0);
        while kept > 1 && tail + s[kept - 1].powi(2) <= tolerance * tolerance * total {
            tail += s[kept - 1].powi(2);
            kept -= 1;
        }
        Ok(product(self.vectors.as_ref(), u.as_ref().subcols(0, kept)))
    }
}

fn push_column(to: &mut Mat<f64>, v: &Mat<f64>, length: f64) {
    let j = to.ncols();
    to.resize_with(v.nrows(), j + 1, |i, _| v[(i, 0)] / length);
}
