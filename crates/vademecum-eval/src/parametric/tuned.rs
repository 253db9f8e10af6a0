//! A parametric model at values of its parameters: modes, and states carried over.

use crate::base::lend::Lender;
use crate::kernels::dense::{add_scaled, apply, at, dot};
use crate::parametric::error::ParametricError;

/// The lowest modes of a parametric model at values of its parameters.
#[derive(Clone, Copy, Debug)]
pub struct Tuned<'m> {
    pub(crate) values: &'m [f64],
    pub(crate) eigenvalues: &'m [f64],
    pub(crate) shapes: &'m [f64],
    /// Cholesky's factor of the reduced stiffness.
    pub(crate) lower: &'m [f64],
    /// The reduced mass, if a density is live.
    pub(crate) mass: &'m [f64],
    /// Factor on the density of the whole body.
    pub(crate) density: f64,
}

impl<'m> Tuned<'m> {
    /// Values of the parameters.
    #[must_use]
    pub const fn values(&self) -> &'m [f64] {
        self.values
    }

    /// Squares of the angular frequencies of the stepped modes \[rad²/s²\], ascending.
    #[must_use]
    pub const fn eigenvalues(&self) -> &'m [f64] {
        self.eigenvalues
    }

    /// Shapes of the stepped modes along the basis, a row of `r` numbers each, orthonormal in the mass.
    #[must_use]
    pub const fn shapes(&self) -> &'m [f64] {
        self.shapes
    }

    /// Carries modal coordinates (or their rates) from other values of the parameters to these, by the
    /// projection `q' = X'ᵀ M X q` with the mass of these values: of all motions that these modes have, the
    /// nearest in the mass. It never adds kinetic energy where densities stay. Lends `2 r` numbers of work.
    ///
    /// # Errors
    /// [`ParametricError::LentMemory`].
    pub fn carry(
        &self,
        from: &Tuned<'_>,
        coordinates: &[f64],
        out: &mut [f64],
        work: &mut [f64],
    ) -> Result<(), ParametricError> {
        let [_, weighted] = self.weighted(from, coordinates, work)?;
        let r = weighted.len();
        for (k, out) in out.iter_mut().enumerate() {
            let shape = self.shapes.get(k * r..(k + 1) * r).unwrap_or_default();
            *out = dot(shape, weighted);
        }
        Ok(())
    }

    /// A motion of other values along the basis, and the same times the mass of these values.
    fn weighted<'w>(
        &self,
        from: &Tuned<'_>,
        coordinates: &[f64],
        work: &'w mut [f64],
    ) -> Result<[&'w mut [f64]; 2], ParametricError> {
        let r = self.shapes.len().checked_div(self.eigenvalues.len()).unwrap_or(0);
        let found = work.len();
        let short = |_| ParametricError::LentMemory { what: "numbers of work", found, needed: 2 * r };
        let mut lender = Lender::new(work);
        let (along, weighted) = (lender.take(r).map_err(short)?, lender.take(r).map_err(short)?);
        along.fill(0.0);
        for (shape, &q) in from.shapes.chunks_exact(r.max(1)).zip(coordinates) {
            add_scaled(along, q, shape);
        }
        if self.mass.is_empty() {
            weighted.iter_mut().zip(&*along).for_each(|(to, from)| *to = self.density * from);
        } else {
            apply(self.mass, along, weighted);
        }
        Ok([along, weighted])
    }

    /// Kinetic and elastic energy \[J\] of coordinates and rates of other values, at the mass and the
    /// stiffness of these.
    pub(crate) fn energies_of(
        &self,
        from: &Tuned<'_>,
        (coordinates, rates): (&[f64], &[f64]),
        work: &mut [f64],
    ) -> Result<[f64; 2], ParametricError> {
        let [along, weighted] = self.weighted(from, rates, work)?;
        let kinetic = 0.5 * dot(along, weighted);
        let [along, half] = self.weighted(from, coordinates, work)?;
        half.fill(0.0);
        for (i, (row, &x)) in self.lower.chunks_exact(along.len().max(1)).zip(&*along).enumerate() {
            // Above the diagonal is no part of the factor.
            half.iter_mut().zip(row).take(i + 1).for_each(|(sum, l)| *sum += l * x);
        }
        Ok([kinetic, 0.5 * dot(half, half)])
    }

    /// Frequency of stepped mode `k` \[Hz\]; 0 of one that there is not.
    #[must_use]
    pub fn frequency(&self, k: usize) -> f64 {
        libm::sqrt(at(self.eigenvalues, k)) / core::f64::consts::TAU
    }
}
