//! Sensitivities of natural modes: derivatives of matrices, eigenvalues and shapes with respect to
//! parameters.
//!
//! With `A x_j = λ_j B x_j` and `XᵀBX = I`, a change `δA`, `δB` of the matrices couples the modes by
//!
//! ```text
//! N_ij = x_iᵀ (δA − λ_j δB) x_j        D_ij = x_iᵀ δB x_j
//! δλ_j = N_jj        δx_j = Σ_{i≠j} x_i N_ij / (λ_j − λ_i) − ½ D_jj x_j
//! ```
//!
//! Sources: Fox and Kapoor 1968; Nelson 1976.

use crate::base::error::ParameterError;
use crate::base::lend::Lender;
use crate::kernels::dense::{add_scaled, apply, at, dot, row, set};
use crate::parametric::error::ParametricError;
use crate::parametric::model::{Parametric, Scales};
use crate::parametric::tuned::Tuned;
use vademecum_format::ParameterRole;

/// Eigenvalues that differ by less than this share have no derivatives of their shapes.
const EQUAL: f64 = 1e-9;

impl Parametric<'_> {
    /// Derivative of the reduced stiffness (or mass) with respect to a parameter of this role, as a full
    /// matrix; false, and nothing written, where it is zero.
    pub(crate) fn matrix_slope(
        &self,
        scales: &Scales<'_>,
        role: ParameterRole,
        mass: bool,
        out: &mut [f64],
    ) -> bool {
        let r = self.n_basis();
        let whole = if mass { scales.density } else { scales.stiffness };
        let packed = if mass { self.live.mass } else { Some(self.live.stiffness) };
        match (role, mass, packed) {
            (ParameterRole::Stiffness, false, Some(packed))
            | (ParameterRole::Density, true, Some(packed)) => {
                self.combine(scales, packed, mass, out);
                out.iter_mut().for_each(|x| *x /= whole);
            }
            (ParameterRole::Density, true, None) => {
                out.fill(0.0);
                out.iter_mut().step_by(r + 1).for_each(|x| *x = 1.0);
            }
            (ParameterRole::RegionStiffness { region }, false, Some(packed))
            | (ParameterRole::RegionDensity { region }, true, Some(packed)) => {
                let mut triangles = packed.chunks_exact((r * (r + 1) / 2).max(1));
                let mut own = triangles.nth(region as usize + 1).unwrap_or_default().iter();
                for i in 0..r {
                    for j in 0..=i {
                        let value = whole * own.next().map_or(0.0, |bytes| f64::from_le_bytes(*bytes));
                        set(out, i * r + j, value);
                        set(out, j * r + i, value);
                    }
                }
            }
            _ => return false,
        }
        true
    }

    /// Role of a parameter.
    pub(crate) fn role(&self, parameter: usize) -> Result<ParameterRole, ParametricError> {
        let own = self.live.get(parameter).ok_or(ParameterError::Unknown { index: parameter })?;
        Ok(own.role)
    }

    /// Numbers of work for derivatives of eigenvalues and shapes.
    #[must_use]
    pub const fn slope_work(&self) -> usize {
        let r = self.n_basis();
        r * r + 2 * r
    }
}

impl Tuned<'_> {
    /// `N_ij` and `D_ij` of a parameter, row by row; zeros of a parameter that changes no matrix. Lends
    /// [`Parametric::slope_work`].
    pub(crate) fn couplings_into(
        &self,
        model: &Parametric<'_>,
        parameter: usize,
        stiffness: &mut [f64],
        mass: &mut [f64],
        work: &mut [f64],
    ) -> Result<(), ParametricError> {
        let (r, m) = (model.n_basis(), self.eigenvalues.len());
        let (role, scales) = (model.role(parameter)?, model.scales(self.values));
        let (matrix, [image, _]) = lent(model, work)?;
        for (is_mass, out) in [(false, &mut *stiffness), (true, &mut *mass)] {
            out.fill(0.0);
            if !model.matrix_slope(&scales, role, is_mass, matrix) {
                continue;
            }
            for (i, out) in out.chunks_exact_mut(m.max(1)).enumerate() {
                apply(matrix, row(self.shapes, i, r), image);
                for (j, out) in out.iter_mut().enumerate() {
                    *out = dot(image, row(self.shapes, j, r));
                }
            }
        }
        for (own, of_mass) in stiffness.chunks_exact_mut(m.max(1)).zip(mass.chunks_exact(m.max(1))) {
            for ((own, of_mass), lambda) in own.iter_mut().zip(of_mass).zip(self.eigenvalues) {
                *own -= lambda * of_mass;
            }
        }
        Ok(())
    }

    /// Derivatives of the squares of the angular frequencies \[rad²/s²\] with respect to a parameter, of the
    /// first stepped modes, as many as `out` has numbers. Zeros of damping and step. Of eigenvalues that are
    /// equal the derivatives are those along the shapes found. Lends [`Parametric::slope_work`]. `O(m r²)`.
    ///
    /// # Errors
    /// [`ParametricError::Parameter`], [`ParametricError::LentMemory`].
    pub fn eigenvalue_slopes(
        &self,
        model: &Parametric<'_>,
        parameter: usize,
        out: &mut [f64],
        work: &mut [f64],
    ) -> Result<(), ParametricError> {
        let r = model.n_basis();
        let (role, scales) = (model.role(parameter)?, model.scales(self.values));
        let (matrix, [image, _]) = lent(model, work)?;
        out.fill(0.0);
        for mass in [false, true] {
            if !model.matrix_slope(&scales, role, mass, matrix) {
                continue;
            }
            let shapes = self.shapes.chunks_exact(r.max(1));
            for ((out, shape), lambda) in out.iter_mut().zip(shapes).zip(self.eigenvalues) {
                apply(matrix, shape, image);
                *out += if mass { -lambda } else { 1.0 } * dot(image, shape);
            }
        }
        Ok(())
    }

    /// Derivatives of the frequencies \[Hz\] with respect to a parameter, as
    /// [`eigenvalue_slopes`](Tuned::eigenvalue_slopes).
    ///
    /// # Errors
    /// As there.
    pub fn frequency_slopes(
        &self,
        model: &Parametric<'_>,
        parameter: usize,
        out: &mut [f64],
        work: &mut [f64],
    ) -> Result<(), ParametricError> {
        use core::f64::consts::TAU;
        self.eigenvalue_slopes(model, parameter, out, work)?;
        for (out, lambda) in out.iter_mut().zip(self.eigenvalues) {
            *out /= 2.0 * TAU * libm::sqrt(*lambda);
        }
        Ok(())
    }

    /// Derivative of the shape of stepped mode `mode`, along the basis, with respect to a parameter; that of
    /// [`shapes`](Tuned::shapes), whose sign it has. All modes of the basis must be stepped, since they span
    /// the derivative. Lends [`Parametric::slope_work`]. `O(r²)`.
    ///
    /// # Errors
    /// [`ParametricError::Modes`]: not all modes of the basis, or none of this number;
    /// [`ParametricError::EqualModes`]: a shape of an eigenvalue that is not simple;
    /// [`ParametricError::Parameter`], [`ParametricError::LentMemory`].
    pub fn shape_slope(
        &self,
        model: &Parametric<'_>,
        parameter: usize,
        mode: usize,
        out: &mut [f64],
        work: &mut [f64],
    ) -> Result<(), ParametricError> {
        let (r, m) = (model.n_basis(), self.eigenvalues.len());
        if m != r {
            return Err(ParametricError::NotAllModes { found: m, all: r });
        }
        if mode >= m {
            return Err(ParametricError::Modes { found: mode + 1, most: m });
        }
        let (role, scales) = (model.role(parameter)?, model.scales(self.values));
        if out.len() != r {
            return Err(ParametricError::LentMemory { what: "numbers", found: out.len(), needed: r });
        }
        let (matrix, [image, coupled]) = lent(model, work)?;
        let (shape, lambda) = (row(self.shapes, mode, r), at(self.eigenvalues, mode));
        coupled.fill(0.0);
        let mut own_mass = 0.0;
        if model.matrix_slope(&scales, role, false, matrix) {
            apply(matrix, shape, coupled);
        }
        if model.matrix_slope(&scales, role, true, matrix) {
            apply(matrix, shape, image);
            own_mass = dot(image, shape);
            add_scaled(coupled, -lambda, image);
        }
        out.fill(0.0);
        add_scaled(out, -0.5 * own_mass, shape);
        for (i, (other, &value)) in self.shapes.chunks_exact(r.max(1)).zip(self.eigenvalues).enumerate() {
            if i == mode {
                continue;
            }
            if (lambda - value).abs() <= EQUAL * lambda.max(value) {
                return Err(ParametricError::EqualModes { first: i.min(mode), second: i.max(mode) });
            }
            add_scaled(out, dot(other, coupled) / (lambda - value), other);
        }
        Ok(())
    }
}

/// Lent work: a matrix and two rows.
fn lent<'w>(
    model: &Parametric<'_>,
    work: &'w mut [f64],
) -> Result<(&'w mut [f64], [&'w mut [f64]; 2]), ParametricError> {
    let (r, found) = (model.n_basis(), work.len());
    let short =
        |_| ParametricError::LentMemory { what: "numbers of work", found, needed: model.slope_work() };
    let mut lender = Lender::new(work);
    let matrix = lender.take(r * r).map_err(short)?;
    Ok((matrix, [lender.take(r).map_err(short)?, lender.take(r).map_err(short)?]))
}
