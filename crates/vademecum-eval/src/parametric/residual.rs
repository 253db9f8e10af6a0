//! Residual flexibility at values of the parameters: the modes of the basis that are not stepped, exactly,
//! and the part outside of the basis, scaled.
//!
//! With the factor `A = L Lᵀ` of the reduced stiffness, rows `a`, `b` over the basis and `a'`, `b'` over the
//! stepped modes, the modes that are not stepped answer by `a (A⁻¹ − X Λ⁻¹ Xᵀ) bᵀ = (L⁻¹a)·(L⁻¹b) − a'Λ⁻¹b'`.
//! The part outside of the basis is that as built times `√(ρ_i ρ_j)` of both nodes, which is semidefinite as
//! that as built is (Schur).

use crate::kernels::dense::{dot, row, solve_lower};
use crate::parametric::model::{Parametric, Scales};
use crate::parametric::rows::{along, read_row};
use crate::parametric::tuned::Tuned;
use vademecum_format::Numbers;

/// Rows of the loads and outputs that residual flexibility is between, each over `L⁻¹` and over the modes.
pub(crate) struct Statics<'w> {
    rows: &'w [f64],
    r: usize,
    m: usize,
    /// 1/λ.
    compliance: &'w [f64],
}

impl<'w> Statics<'w> {
    /// Numbers for so many rows.
    pub const fn len(rows: usize, r: usize, m: usize) -> usize {
        rows.saturating_mul(r + m).saturating_add(m)
    }

    /// Rows of these sections, one after the other: the first so many of each.
    pub fn new(
        tuned: &Tuned<'_>,
        r: usize,
        sections: &[(Option<Numbers<'_>>, usize)],
        lent: &'w mut [f64],
    ) -> Self {
        let m = tuned.eigenvalues.len();
        let (compliance, rows) = lent.split_at_mut(m.min(lent.len()));
        compliance.iter_mut().zip(tuned.eigenvalues).for_each(|(own, value)| *own = 1.0 / value);
        let places =
            sections.iter().flat_map(|&(numbers, count)| (0..count).map(move |place| (numbers, place)));
        for ((numbers, place), own) in places.zip(rows.chunks_exact_mut((r + m).max(1))) {
            let (of_factor, of_modes) = own.split_at_mut(r.min(own.len()));
            if let Some(numbers) = numbers {
                read_row(&numbers, place, of_factor);
            }
            of_modes.iter_mut().zip(along(tuned.shapes, of_factor)).for_each(|(to, value)| *to = value);
            solve_lower(tuned.lower, r, of_factor);
        }
        Self { rows, r, m, compliance }
    }

    /// The answer of the modes that are not stepped between two rows.
    pub fn between(&self, a: usize, b: usize) -> f64 {
        let width = self.r + self.m;
        let [a, b] = [a, b].map(|place| row(self.rows, place, width));
        let split = |row: &'w [f64]| row.split_at(self.r.min(row.len()));
        let ((a, of_a), (b, of_b)) = (split(a), split(b));
        let stepped: f64 = of_a.iter().zip(of_b).zip(self.compliance).map(|((a, b), c)| a * b * c).sum();
        dot(a, b) - stepped
    }

    /// The same between a row, as it was solved for, and one that is not among these.
    pub fn with(&self, a: usize, (of_b, b): (&[f64], &[f64])) -> f64 {
        let own = row(self.rows, a, self.r + self.m);
        let (a, of_a) = own.split_at(self.r.min(own.len()));
        let stepped: f64 = of_a.iter().zip(of_b).zip(self.compliance).map(|((a, b), c)| a * b * c).sum();
        dot(a, b) - stepped
    }
}

impl Parametric<'_> {
    /// `√ρ` of each loadable node: how the part of the residual flexibility outside of the basis changes with
    /// the values. 1 at the values as built.
    pub(crate) fn roots_into(&self, scales: &Scales<'_>, roots: &mut [f64]) {
        let terms = self.live.residual;
        let whole = 1.0 / scales.stiffness;
        roots.fill(if terms.is_empty() { whole } else { 0.0 });
        let count = self.live.n_regions;
        let mean =
            (1..=count).map(|region| self.scale_of(scales, region, false)).sum::<f64>() / count.max(1) as f64;
        let scale = |region: f64| {
            let region = region as usize;
            if region > count { mean } else { self.scale_of(scales, region, false) }
        };
        for [node, first, second, share, weight] in terms {
            let [node, first, second, share, weight] =
                [node, first, second, share, weight].map(|bytes| f64::from_le_bytes(*bytes));
            if let Some(root) = roots.get_mut(node as usize) {
                *root += weight / ((1.0 - share) * scale(first) + share * scale(second));
            }
        }
        roots.iter_mut().for_each(|root| *root = libm::sqrt(root.max(0.0)));
    }
}

/// Solves a row for [`Statics::with`]: `of_modes` along the modes, `row` itself by the factor.
pub(crate) fn solved(tuned: &Tuned<'_>, row: &mut [f64], of_modes: &mut [f64]) {
    of_modes.iter_mut().zip(along(tuned.shapes, row)).for_each(|(to, value)| *to = value);
    let r = row.len();
    solve_lower(tuned.lower, r, row);
}
