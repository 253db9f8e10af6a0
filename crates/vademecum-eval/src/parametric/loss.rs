//! Damping by the loss factors of live regions: the strain energy of each mode decides its ratio,
//!
//! ```text
//! ζ_k = ζ₀ + ½ Σ η_q E_qk / E_k = ζ₀ + x_kᵀ (Σ η_q κ_q k_q) x_k / (2 λ_k)        X normal in the mass
//! ```
//!
//! (Ungar and Kerwin 1962; Johnson and Kienholz 1982).

use crate::base::lend::Lender;
use crate::kernels::dense::{apply, dot};
use crate::parametric::model::{Parametric, Scales};
use crate::parametric::tuned::Tuned;
use vademecum_format::ParameterRole;

impl Parametric<'_> {
    /// True of a file whose regions have loss factors.
    #[must_use]
    pub const fn has_loss(&self) -> bool {
        !self.live.loss.is_empty()
    }

    /// Loss factor of live region `region`, counted from 1; 0 is what is not live.
    fn loss_of(&self, scales: &Scales<'_>, region: usize) -> f64 {
        let Some(place) = region.checked_sub(1) else { return 0.0 };
        let role = ParameterRole::LossFactor { region: place as u32 };
        let set = self.parameters().zip(scales.values).find(|own| own.0.role == role);
        let built = || self.live.loss.get(region).map_or(0.0, |number| f64::from_le_bytes(*number));
        set.map_or_else(built, |own| *own.1)
    }

    /// Numbers of work of [`Parametric::ratios_into`].
    pub(crate) const fn loss_work(&self) -> usize {
        let r = self.n_basis();
        if self.has_loss() { r * r + r } else { 0 }
    }

    /// Damping ratios of the stepped modes beside Rayleigh's damping; false, and nothing written, of a file
    /// without loss factors. `O(m r²)`.
    pub(crate) fn ratios_into(
        &self,
        tuned: &Tuned<'_>,
        scales: &Scales<'_>,
        out: &mut [f64],
        work: &mut [f64],
    ) -> bool {
        let Some((own, _)) = self.live.loss.split_first() else { return false };
        let (r, mut lender) = (self.n_basis(), Lender::new(work));
        let (Ok(matrix), Ok(image)) = (lender.take(r * r), lender.take(r)) else { return false };
        let scale = |region| self.loss_of(scales, region) * self.scale_of(scales, region, false);
        self.combine_by(scale, self.live.stiffness, matrix);
        let shapes = tuned.shapes.chunks_exact(r.max(1));
        for ((out, shape), lambda) in out.iter_mut().zip(shapes).zip(tuned.eigenvalues) {
            apply(matrix, shape, image);
            *out = f64::from_le_bytes(*own) + 0.5 * dot(image, shape) / lambda;
        }
        true
    }
}
