//! Reactions at values of the parameters: the static shapes of the supports, and their inertia.
//!
//! The shape of a support is `Φ + B y`: that as built, and its correction in the basis, which makes the
//! reduced elastic forces vanish, `K y = −Σ κ_q g_q` with `g_q = Bᵀ(K_q,ff Φ + K_q,fs T)`. The elastic force
//! that is left is that between two errors, of the shape and of the motion, so the error of a reaction is of
//! second order.

use crate::kernels::dense::{add_scaled, apply, dot, row, solve_lower, solve_upper};
use crate::parametric::model::{Parametric, Scales};
use crate::parametric::rows::{Reals, along, read_row};
use crate::parametric::tuned::Tuned;
use vademecum_format::{FormatError, Numbers, SectionKind as S};

/// Corrections `y` of the shapes of all supports, six rows of `r` numbers each.
pub(crate) struct SupportShapes<'w> {
    rows: &'w [f64],
    r: usize,
}

impl<'w> SupportShapes<'w> {
    /// Numbers of so many supports.
    pub const fn len(supports: usize, r: usize) -> usize {
        supports.saturating_mul(6 * r)
    }

    pub fn new(
        model: &Parametric<'_>,
        (tuned, scales): (&Tuned<'_>, &Scales<'_>),
        lent: &'w mut [f64],
    ) -> Result<Self, FormatError> {
        let r = model.n_basis();
        lent.fill(0.0);
        if let Some(section) = model.file.section(S::LiveReactionStiffness) {
            let numbers = section.f64s()?;
            for (place, own) in lent.chunks_exact_mut(r.max(1)).enumerate() {
                add_regions(model, scales, (numbers, place), false, own);
                solve_lower(tuned.lower, r, own);
                solve_upper(tuned.lower, r, own);
                own.iter_mut().for_each(|x| *x = -*x);
            }
        }
        Ok(Self { rows: lent, r })
    }

    /// Correction of a motion of a support; motions are counted through the supports.
    fn of(&self, place: usize) -> &[f64] {
        row(self.rows, place, self.r)
    }

    /// Inertia `Bᵀ(M_ff (Φ + B y) + M_fs T)` of each motion, along the modes.
    pub fn write_inertia(
        &self,
        model: &Parametric<'_>,
        (tuned, scales): (&Tuned<'_>, &Scales<'_>),
        numbers: &Numbers<'_>,
        (work, out): (&mut [f64], &mut Reals<'_>),
    ) -> Result<(), FormatError> {
        let section = model.file.section(S::LiveReactionMass);
        let of_regions = section.map(|section| section.f64s()).transpose()?;
        let (own, of_shape) = work.split_at_mut(self.r.min(work.len()));
        for place in 0..self.rows.len().checked_div(self.r).unwrap_or(0) {
            match of_regions {
                Some(of_regions) => {
                    own.fill(0.0);
                    add_regions(model, scales, (of_regions, place), true, own);
                    apply(tuned.mass, self.of(place), of_shape);
                    add_scaled(own, 1.0, of_shape);
                }
                None => {
                    read_row(numbers, place, own);
                    add_scaled(own, 1.0, self.of(place));
                    own.iter_mut().for_each(|x| *x *= tuned.density);
                }
            }
            along(tuned.shapes, own).for_each(|value| out.push(value));
        }
        Ok(())
    }

    /// Reactions under a unit force at each loadable node, or under patterns: less the work of that load
    /// along the shapes. `loads` are rows over the basis.
    pub fn write_loads(
        &self,
        numbers: &Numbers<'_>,
        (loads, of_nodes): (&Numbers<'_>, bool),
        (row, out): (&mut [f64], &mut Reals<'_>),
    ) {
        let supports = self.rows.len().checked_div(6 * self.r).unwrap_or(0).max(1);
        let row = row.get_mut(..self.r).unwrap_or_default();
        let mut built = numbers.iter();
        // A support and a node have 18 numbers, motion by motion; a pattern and a support have 6.
        let blocks = numbers.len() / if of_nodes { 18 } else { 6 };
        let nodes = blocks / supports;
        for block in 0..blocks {
            let (support, load) = if of_nodes {
                (block / nodes.max(1), block % nodes.max(1))
            } else {
                (block % supports, block / supports)
            };
            let mut values = [[0.0; 3]; 6];
            let components = if of_nodes { 3 } else { 1 };
            for component in 0..components {
                read_row(loads, components * load + component, row);
                for (motion, of_motion) in values.iter_mut().enumerate() {
                    if let Some(value) = of_motion.get_mut(component) {
                        *value = dot(row, self.of(6 * support + motion));
                    }
                }
            }
            for value in values.iter().flat_map(|of_motion| of_motion.iter().take(components)) {
                out.push(built.next().unwrap_or(0.0) - value);
            }
        }
    }
}

/// Adds `Σ scale_q` times row `place` of each region. Rows are those of a support's motions, first of what is
/// not live, then of each live region, and so on for each support.
fn add_regions(
    model: &Parametric<'_>,
    scales: &Scales<'_>,
    (numbers, place): (&[[u8; 8]], usize),
    density: bool,
    out: &mut [f64],
) {
    let (r, regions) = (out.len(), model.live.n_regions + 1);
    for region in 0..regions {
        let index = ((place / 6) * regions + region) * 6 + place % 6;
        let scale = model.scale_of(scales, region, density);
        let begin = index.saturating_mul(r);
        let own = numbers.get(begin..begin.saturating_add(r)).unwrap_or_default();
        out.iter_mut().zip(own).for_each(|(out, &own)| *out += scale * f64::from_le_bytes(own));
    }
}
