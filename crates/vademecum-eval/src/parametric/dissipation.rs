//! Damping that follows the parameters. By loss factors of live regions the strain energy of each mode
//! decides its ratio (Ungar and Kerwin 1962; Johnson and Kienholz 1982); dashpots are rows over the basis,
//! and so rows over the stepped modes:
//!
//! ```text
//! ζ_k = ζ₀ + ½ Σ η_q E_qk / E_k = ζ₀ + x_kᵀ (Σ η_q κ_q k_q) x_k / (2 λ_k)        X normal in the mass
//! D' = √c D X
//! ```

use crate::base::lend::Lender;
use crate::kernels::dense::{apply, at, dot, set};
use crate::parametric::error::ParametricError;
use crate::parametric::model::{Parametric, Scales};
use crate::parametric::rows::{Reals, along, read_row};
use crate::parametric::tuned::Tuned;
use vademecum_format::{Numbers, ParameterRole, SectionKind};

/// A pivot of a damping matrix that is a smaller share of the largest is rounding.
const ROUNDING: f64 = 1e-14;

impl Parametric<'_> {
    /// True of a file whose regions have loss factors.
    #[must_use]
    pub const fn has_loss(&self) -> bool {
        !self.live.loss.is_empty()
    }

    /// Refuses damping that has no derivatives.
    pub(crate) fn check_derivatives(&self) -> Result<(), ParametricError> {
        if self.has_loss() {
            return Err(ParametricError::LossFactors);
        }
        if self.file.section(SectionKind::DampingRows).is_some() {
            return Err(ParametricError::Dashpots);
        }
        Ok(())
    }

    /// Loss factor of live region `region`, counted from 1; 0 of the part without live parameters.
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

    /// Rows of dashpots over the basis, and as many as so many modes have.
    fn dashpot_rows(&self, modes: usize) -> [usize; 2] {
        let rows = self.file.section(SectionKind::DampingRows).map_or(0, |section| section.shape()[0]);
        let rows = usize::try_from(rows).unwrap_or(0);
        [rows, rows.min(modes)]
    }

    /// Numbers of work of [`Parametric::write_dashpots`].
    pub(crate) fn dashpot_work(&self, modes: usize) -> usize {
        let [rows, kept] = self.dashpot_rows(modes);
        if rows > kept { modes * modes + modes } else { 0 }
    }

    /// Writes the rows of the dashpots over the stepped modes: where there are more than modes, those of a
    /// Cholesky factor of their damping matrix. `O(rows r m + rows m²)`.
    pub(crate) fn write_dashpots(
        &self,
        tuned: &Tuned<'_>,
        scales: &Scales<'_>,
        numbers: &Numbers<'_>,
        (row, work, out): (&mut [f64], &mut [f64], &mut Reals<'_>),
    ) {
        let (r, m) = (self.n_basis(), tuned.eigenvalues.len());
        let [rows, kept] = self.dashpot_rows(m);
        let row = row.get_mut(..r).unwrap_or_default();
        let (matrix, own) = work.split_at_mut((m * m).min(work.len()));
        matrix.fill(0.0);
        for place in 0..rows {
            let group = self.live.dampers.get(place).map_or(0, |own| u32::from_le_bytes(*own));
            let role = ParameterRole::Damping { group: group.wrapping_sub(1) };
            let set = self.parameters().zip(scales.values).find(|own| own.0.role == role);
            let root = libm::sqrt(set.map_or(1.0, |own| *own.1));
            read_row(numbers, place, row);
            if rows == kept {
                along(tuned.shapes, row).for_each(|value| out.push(root * value));
                continue;
            }
            own.iter_mut().zip(along(tuned.shapes, row)).for_each(|(to, value)| *to = root * value);
            for (matrix, a) in matrix.chunks_exact_mut(m.max(1)).zip(&*own) {
                matrix.iter_mut().zip(&*own).for_each(|(sum, b)| *sum += a * b);
            }
        }
        if rows > kept {
            semidefinite_rows(matrix, m);
            matrix.iter().for_each(|value| out.push(*value));
        }
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

/// Overwrites a positive semidefinite matrix of `m` rows by the upper triangular `R` of `RᵀR`. A row whose
/// pivot is rounding is zero.
fn semidefinite_rows(matrix: &mut [f64], m: usize) {
    let largest = (0..m).map(|k| at(matrix, k * m + k)).fold(0.0, f64::max);
    for k in 0..m {
        let pivot = at(matrix, k * m + k);
        let root = if pivot > ROUNDING * largest { libm::sqrt(pivot) } else { 0.0 };
        for j in 0..m {
            let scaled = if j < k || root <= 0.0 { 0.0 } else { at(matrix, k * m + j) / root };
            set(matrix, k * m + j, scaled);
        }
        for i in k + 1..m {
            let factor = at(matrix, k * m + i);
            for j in i..m {
                let rest = at(matrix, i * m + j) - factor * at(matrix, k * m + j);
                set(matrix, i * m + j, rest);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::semidefinite_rows;

    #[test]
    fn rows_of_a_semidefinite_matrix_give_it_back() {
        let rows = [[1.0, 2.0, -1.0, 0.5], [0.0, 3.0, 1.0, 1.0]];
        let entry = |i: usize, j: usize| rows.iter().map(|row| row[i] * row[j]).sum::<f64>();
        let mut matrix: [f64; 16] = core::array::from_fn(|place| entry(place / 4, place % 4));
        semidefinite_rows(&mut matrix, 4);
        for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
            let found: f64 = (0..4).map(|k| matrix[4 * k + i] * matrix[4 * k + j]).sum();
            assert!((found - entry(i, j)).abs() < 1e-14, "{i} {j}: {found} beside {}", entry(i, j));
        }
    }
}
