//! Tail and coupled coordinates of the strain structure. The builder makes neither any more; files that have
//! them step as before.
//!
//! Row `leading + l` has, beside its linear and quadratic part in the leading coordinates, the term `x q_l`
//! of one tail coordinate. That coordinate is in no other row, so it is eliminated from the matrix of a
//! sub-step, and what is left is the weight `w` of its row: with `μ = 1 + kα/2` and `a = μ m + x² W` it is
//! `W μ m/a`, and `W` for all other rows.
//!
//! A coupled coordinate is multiplied by interacting coordinates alone, so its products have fewer columns.

use crate::base::scalar::Scalar;
use crate::kernels::kernel::{along, less};
use crate::kernels::strain::memory::{PANEL, Scratch, StrainMap, StrainShape};
use crate::kernels::strain::numbers::{RowNumbers, StrainSections, StrainStep};
use vademecum_format::StrainSizes;

impl StrainShape {
    /// Coordinates that the numbers of a row from `start` on are multiplied by.
    pub const fn columns(&self, start: usize) -> usize {
        if start < self.interacting { self.leading } else { self.interacting }
    }

    /// The sizes in a file; sub-steps are left at 1.
    pub const fn file_sizes(&self) -> StrainSizes {
        StrainSizes {
            interacting: self.interacting,
            coupled: self.leading - self.interacting,
            rows: self.rows,
            coordinates: self.leading + self.tail,
            substeps: 1,
        }
    }
}

/// The numbers of row `k` if it has a tail coordinate.
pub(crate) fn row_numbers(
    sections: &StrainSections<'_>,
    shape: StrainShape,
    step: &StrainStep,
    k: usize,
) -> Option<RowNumbers> {
    let &omega = sections.tail.get(k.checked_sub(shape.leading)?)?;
    let x = step.scale * f64::from_le_bytes(omega);
    let factor = step.factor(x);
    let root = step.root_of_inertia(sections, k);
    let mass = step.mass * root * root;
    let a = mass + x * x * factor;
    let weight = factor * mass / a;
    let root = libm::sqrt(weight);
    let tail = Some([x * root, 2.0 * x / root, factor * x / (a * root), 1.0 / a]);
    Some(RowNumbers { factor, weight, tail })
}

/// The push of row `k`, whose leading coordinates sum to `z`: `force z`, and for a row with a tail coordinate
/// the part that its elimination leaves. `mean` is the displacement of all coordinates, `rights` the
/// right-hand side of the tail.
#[inline(always)]
pub(crate) fn push<T: Scalar>(
    map: &StrainMap<'_, T>,
    k: usize,
    (z, force): (T, T),
    mean: &[T],
    rights: &mut [T],
) -> T {
    if k >= map.shape.leading {
        let l = k - map.shape.leading;
        if let (Some(&[x, pull, share, _]), Some(&mean), Some(right)) =
            (map.tail.get(l), mean.get(k), rights.get_mut(l))
        {
            let z = z + x * mean;
            *right = *right - pull * z;
            return force * z + share * *right;
        }
    }
    force * z
}

/// Eliminates given right-hand sides of the tail from those of the leading coordinates.
pub(crate) fn reduce<T: Scalar>(map: &StrainMap<'_, T>, scratch: &mut Scratch<'_, T>) {
    for (l, (&[_, _, share, _], &right)) in map.tail.iter().zip(&*scratch.tail).enumerate() {
        let panels = scratch.rows.iter().skip(map.shape.leading + l).step_by(map.shape.rows.max(1));
        for (out, g) in scratch.leading.as_chunks_mut::<PANEL>().0.iter_mut().zip(panels) {
            *out = less(*out, share * right, g);
        }
    }
}

/// `d` of the tail coordinates, in place of their right-hand sides, from that of the leading ones.
#[inline(always)]
pub(crate) fn substitute<T: Scalar>(map: &StrainMap<'_, T>, scratch: &mut Scratch<'_, T>) {
    let rows = map.shape.rows;
    let solution = scratch.solution.as_chunks::<PANEL>().0;
    let tail = map.tail.iter().zip(&mut *scratch.tail).zip(&mut *scratch.along);
    for (l, ((&[_, _, share, inverse], right), out)) in tail.enumerate() {
        let row = scratch.rows.iter().skip(map.shape.leading + l).step_by(rows.max(1));
        *out = along(row, solution);
        *right = *right * inverse - share * *out;
    }
}

/// `x q` of the tail coordinate `l` of row `k`, from `q(l)`; 0 for a row without one.
pub(crate) fn own<T: Scalar>(map: &StrainMap<'_, T>, k: usize, q: impl Fn(usize) -> f64) -> f64 {
    let l = k.checked_sub(map.shape.leading);
    l.and_then(|l| Some(map.tail.get(l)?[0].to_f64() * q(l))).unwrap_or(0.0)
}
