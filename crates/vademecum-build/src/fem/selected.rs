//! Entries of an inverse, and of its derivative, where its factor has entries: selected inversion.
//!
//! Eliminating the columns `J` of a group leaves `D` on them and `G` below (`A_IJ = G D`). From the last
//! group to the first, with `I` the rows below (Takahashi, Fagan and Chin 1973; Erisman and Tinney 1975; by
//! groups as in Lin et al. 2011)
//!
//! ```text
//! Z_IJ = −Z_II G        Z_JJ = D⁻¹ − Gᵀ Z_IJ        Z = A⁻¹
//! ```
//!
//! needs `Z_II` only, which has the pattern of the factor. The derivative along `A + εW` follows in the same
//! way: first `Ḋ` and `Ġ`, from the first group to the last, then `Y = −Ż = A⁻¹WA⁻¹` downwards:
//!
//! ```text
//! Ȧ_II ← Ȧ_II − (V Gᵀ + G Vᵀ)                 V = Ȧ_IJ − ½ G Ḋ        Ḋ = Ȧ_JJ
//! Ġ = (Ȧ_IJ − G Ḋ) D⁻¹
//! Y_IJ = −Y_II G + Z_II Ġ        Y_JJ = D⁻¹ḊD⁻¹ + Ġᵀ Z_IJ − Gᵀ Y_IJ
//! ```
//!
//! Note: everything is computed in place, `Z` over the factor and `Y` over `Ȧ`. Dense products are
//! cut in rows of a fixed height, and threads share those, so the bits never depend on their number.

use std::sync::Arc;

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_inverse::invert_lower_triangular;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;

use super::factor::{Factor, Solve, Symbolic};
use super::rigid::RigidBody;
use super::sparse::SymmetricMatrix;
use super::supernodes::{Group, Run, Supernodes};
use crate::linalg::{SHARED, by_rows, symmetric_part};
use crate::progress::{Cancelled, Listener};

/// Rows and columns of a tile that is mirrored at a time: two fit the first cache.
const TILE: usize = 32;
/// Cost of moving a number between groups, in multiplications of a dense product.
const MOVE: f64 = 40.0;

/// Entries of `A⁻¹` and of `A⁻¹WA⁻¹` on the pattern of the factor of `A`.
#[derive(Clone, Debug)]
#[doc(alias("Takahashi", "selected inversion"))]
pub(crate) struct SelectedInverse {
    supernodes: Arc<Supernodes>,
    inverse: Vec<f64>,
    weighted: Vec<f64>,
    relief: Option<ReliefProjection>,
}

impl SelectedInverse {
    /// Entry of `A⁻¹`; `None` off the pattern. For the stiffness of a body without supports it is that of
    /// `K⁺`.
    pub(crate) fn inverse(&self, row: usize, column: usize) -> Option<f64> {
        let relief = self.relief.as_ref().map_or(0.0, |relief| relief.of_inverse(row, column));
        self.supernodes.position(row, column).map(|at| self.inverse[at] - relief)
    }

    /// Entry of `A⁻¹WA⁻¹`; `None` off the pattern. For the stiffness of a body without supports it is that of
    /// `K⁺MK⁺`.
    pub(crate) fn weighted(&self, row: usize, column: usize) -> Option<f64> {
        let relief = self.relief.as_ref().map_or(0.0, |relief| relief.of_weighted(row, column));
        self.supernodes.position(row, column).map(|at| self.weighted[at] - relief)
    }
}

/// Correction of the entries for `Kₛ` by inertia relief (see [`RigidBody`]). With `Z = Kₛ⁻¹`, `Y = ZMΦ`,
/// `S = ΦᵀMY`, `V = ZMY` and `T = ΦᵀMV`:
///
/// ```text
/// K⁺   = Z   − ΦAᵀ − AΦᵀ                   A = Y − ½ΦS
/// K⁺MK⁺ = ZMZ − ΦCᵀ − CΦᵀ − (Y − ΦS)(Y − ΦS)ᵀ   C = V − ½ΦT
/// ```
#[derive(Clone, Debug)]
struct ReliefProjection {
    motions: Mat<f64>,
    /// `A`, `C` and `Y − ΦS`, shape (n, 6).
    half: Mat<f64>,
    half_weighted: Mat<f64>,
    answers: Mat<f64>,
}

impl ReliefProjection {
    fn new(factor: &Factor, rigid: &RigidBody, mass: &SymmetricMatrix) -> ReliefProjection {
        let held = factor.without_rigid();
        let mut solve = Solve::new(held.symbolic(), 6, false);
        let (motions, momenta) = (rigid.motions(), rigid.momenta());
        let mut answers = momenta.to_owned();
        solve.solve_in_place(&held, answers.as_mut());
        let mut second = Mat::zeros(answers.nrows(), 6);
        mass.mul_into(answers.as_ref(), second.as_mut());
        solve.solve_in_place(&held, second.as_mut());
        let shares = |columns: &Mat<f64>| motions * symmetric_part((momenta.transpose() * columns).as_ref());
        let (own, other) = (shares(&answers), shares(&second));
        ReliefProjection {
            motions: motions.to_owned(),
            half: &answers - faer::Scale(0.5) * &own,
            half_weighted: second - faer::Scale(0.5) * other,
            answers: answers - own,
        }
    }

    fn of_inverse(&self, i: usize, j: usize) -> f64 {
        let [b, a] = [&self.motions, &self.half];
        (0..6).map(|k| b[(i, k)] * a[(j, k)] + a[(i, k)] * b[(j, k)]).sum()
    }

    fn of_weighted(&self, i: usize, j: usize) -> f64 {
        let [b, c, y] = [&self.motions, &self.half_weighted, &self.answers];
        (0..6).map(|k| b[(i, k)] * c[(j, k)] + c[(i, k)] * b[(j, k)] + y[(i, k)] * y[(j, k)]).sum()
    }
}

impl Symbolic {
    /// Multiplications of [`Factor::select`], and what takes as long.
    pub(crate) fn select_work(&self) -> f64 {
        self.supernodes().groups.iter().map(work).sum()
    }

    /// Memory of [`Factor::select`] in addition to the factor \[bytes\].
    pub(crate) fn select_bytes(&self) -> usize {
        let supernodes = self.supernodes();
        let workspace = 2 * supernodes.tallest().pow(2) + 2 * supernodes.largest();
        self.factor_bytes().saturating_add(size_of::<f64>() * workspace)
    }
}

/// Multiplications for a group, and what takes as long.
fn work(group: &Group) -> f64 {
    let [j, i] = [group.columns as f64, group.below() as f64];
    4.0 * i * i * j + 7.0 * i * j * j + 5.0 * j.powi(3) + MOVE * i * i
}

impl Factor {
    /// Entries of `A⁻¹` and of `A⁻¹WA⁻¹` on the pattern of the factor, which is used up. All threads.
    ///
    /// Some ten times the multiplications of the factorisation, whatever the number of entries that are
    /// looked at. Memory: the factor once more, and two dense fronts.
    ///
    /// # Errors
    /// [`Cancelled`].
    ///
    /// # Panics
    /// If `weight` is on another pattern.
    ///
    /// For the stiffness of a body without supports `weight` is its mass.
    pub(crate) fn select(
        self,
        weight: &SymmetricMatrix,
        listener: &dyn Listener,
    ) -> Result<SelectedInverse, Cancelled> {
        let relief = self.rigid().map(|rigid| ReliefProjection::new(&self, rigid, weight));
        let (symbolic, mut inverse) = self.into_values();
        assert!(std::ptr::eq(symbolic.pattern(), &**weight.pattern()), "one pattern per symbolic analysis");
        let supernodes = symbolic.supernodes().clone();
        let mut weighted = supernodes.scatter(weight, None);
        let mut fronts = [(); 2].map(|()| vec![0.0; supernodes.tallest().pow(2)]);
        let mut spare = [(); 2].map(|()| vec![0.0; supernodes.largest()]);
        let total: f64 = supernodes.groups.iter().map(work).sum();
        let mut done = 0.0;
        // A third of the work is upwards.
        let mut advance = |group: &Group, share: f64| {
            done += share * work(group);
            listener.checkpoint((done / SHARED) as usize, (total / SHARED).ceil() as usize)
        };
        listener.checkpoint(0, (total / SHARED).ceil() as usize)?;
        for group in &supernodes.groups {
            upwards(&supernodes, group, [&mut inverse, &mut weighted], &mut fronts[0], &mut spare[0]);
            advance(group, 1.0 / 3.0)?;
        }
        for group in supernodes.groups.iter().rev() {
            downwards(&supernodes, group, [&mut inverse, &mut weighted], &mut fronts, &mut spare);
            advance(group, 2.0 / 3.0)?;
        }
        Ok(SelectedInverse { supernodes, inverse, weighted, relief })
    }
}

/// Leaves `L_JJ` and `G`, `Ḋ` and `Ġ` in the places of a group, and takes what it does to later ones off
/// theirs.
fn upwards(
    supernodes: &Supernodes,
    group: &Group,
    [values, slopes]: [&mut [f64]; 2],
    front: &mut [f64],
    spare: &mut [f64],
) {
    let (columns, below) = (group.columns, group.below());
    let (lower, mut ratio) = parts(&mut values[group.values.clone()], group);
    let lower = lower.rb();
    by_rows(ratio.rb_mut(), columns, |_, rows| {
        solve_upper_triangular_in_place(lower.transpose(), rows.transpose_mut(), Par::Seq);
    });
    let ratio = ratio.rb();
    let (own, later) = slopes[group.values.start..].split_at_mut(group.values.len());
    let (mut pivot, mut slope) = parts(own, group);
    mirror(pivot.rb_mut());
    let pivot = pivot.rb();
    if below == 0 {
        return;
    }
    let mut half = MatMut::from_column_major_slice_mut(&mut spare[..below * columns], below, columns);
    half.copy_from(slope.rb());
    product(half.rb_mut(), Accum::Add, ratio, pivot, -0.5);
    let mut update = MatMut::from_column_major_slice_mut(&mut front[..below * below], below, below);
    let half = half.rb();
    by_rows(update.rb_mut(), 2 * columns, |first, rows| {
        let height = rows.nrows();
        // The lower triangle, and what stands beside it in these rows.
        let mut rows = rows.subcols_mut(0, first + height);
        let own = [half, ratio].map(|m| m.subrows(first, height));
        let upto = [half, ratio].map(|m| m.subrows(0, first + height).transpose());
        matmul(rows.rb_mut(), Accum::Replace, own[0], upto[1], 1.0, Par::Seq);
        matmul(rows, Accum::Add, own[1], upto[0], 1.0, Par::Seq);
    });
    for run in supernodes.runs(group) {
        let other = &supernodes.groups[run.owner];
        let height = other.columns + other.below();
        let base = other.values.start - group.values.end;
        for place in run.places.clone() {
            let column = run.local[place - run.places.start] as usize;
            let target = &mut later[base + column * height..][..height];
            let source = &front[place * below + place..(place + 1) * below];
            for (&local, &value) in run.local[place - run.places.start..].iter().zip(source) {
                target[local as usize] -= value;
            }
        }
    }
    by_rows(slope.rb_mut(), 3 * columns, |first, mut rows| {
        let own = ratio.subrows(first, rows.nrows());
        matmul(rows.rb_mut(), Accum::Add, own, pivot, -1.0, Par::Seq);
        solve_lower_triangular_in_place(lower, rows.rb_mut().transpose_mut(), Par::Seq);
        solve_upper_triangular_in_place(lower.transpose(), rows.transpose_mut(), Par::Seq);
    });
}

/// Leaves `Z` and `Y` in the places of a group, from those of later ones.
fn downwards(
    supernodes: &Supernodes,
    group: &Group,
    [values, slopes]: [&mut [f64]; 2],
    fronts: &mut [Vec<f64>; 2],
    spare: &mut [Vec<f64>; 2],
) {
    let (columns, below) = (group.columns, group.below());
    let (values, above) = values[group.values.start..].split_at_mut(group.values.len());
    let (slopes, slopes_above) = slopes[group.values.start..].split_at_mut(group.values.len());
    let (mut own, mut own_below) = parts(values, group);
    let (mut slope, mut slope_below) = parts(slopes, group);

    // D⁻¹ and D⁻¹ḊD⁻¹.
    let mut lower = Mat::zeros(columns, columns);
    invert_lower_triangular(lower.as_mut(), own.rb(), Par::Seq);
    let lower = lower.as_ref();
    let mut turned = Mat::zeros(columns, columns);
    let mut image = Mat::zeros(columns, columns);
    product(image.as_mut(), Accum::Replace, lower, slope.rb(), 1.0);
    product(turned.as_mut(), Accum::Replace, image.as_ref(), lower.transpose(), 1.0);
    product(image.as_mut(), Accum::Replace, lower.transpose(), turned.as_ref(), 1.0);
    product(slope.rb_mut(), Accum::Replace, image.as_ref(), lower, 1.0);
    product(own.rb_mut(), Accum::Replace, lower.transpose(), lower, 1.0);
    if below > 0 {
        let runs = supernodes.runs(group);
        let [front, front_slope] = fronts;
        gather(supernodes, group, &runs, above, front);
        gather(supernodes, group, &runs, slopes_above, front_slope);
        let [size, kept] = [below * below, below * columns];
        let [ratio, ratio_slope] = spare;
        for (memory, from) in [(&mut *ratio, own_below.rb()), (&mut *ratio_slope, slope_below.rb())] {
            MatMut::from_column_major_slice_mut(&mut memory[..kept], below, columns).copy_from(from);
        }
        let z = MatRef::from_column_major_slice(&front[..size], below, below);
        let y = MatRef::from_column_major_slice(&front_slope[..size], below, below);
        let g = MatRef::from_column_major_slice(&ratio[..kept], below, columns);
        let h = MatRef::from_column_major_slice(&ratio_slope[..kept], below, columns);
        product(own_below.rb_mut(), Accum::Replace, z, g, -1.0);
        product(slope_below.rb_mut(), Accum::Replace, y, g, -1.0);
        product(slope_below.rb_mut(), Accum::Add, z, h, 1.0);
        product(own.rb_mut(), Accum::Add, g.transpose(), own_below.rb(), -1.0);
        product(slope.rb_mut(), Accum::Add, h.transpose(), own_below.rb(), 1.0);
        product(slope.rb_mut(), Accum::Add, g.transpose(), slope_below.rb(), -1.0);
    }
    mirror(own);
    mirror(slope);
}

/// The square on the columns of a group, and the rows below it.
fn parts<'a>(values: &'a mut [f64], group: &Group) -> (MatMut<'a, f64>, MatMut<'a, f64>) {
    let height = group.columns + group.below();
    MatMut::from_column_major_slice_mut(values, height, group.columns).split_at_row_mut(group.columns)
}

/// The entries between all rows below a group, from the later groups that own them.
fn gather(supernodes: &Supernodes, group: &Group, runs: &[Run], later: &[f64], front: &mut [f64]) {
    let below = group.below();
    let front = &mut front[..below * below];
    let take = |(place, target): (usize, &mut [f64])| {
        let run = &runs[runs.partition_point(|run| run.places.end <= place)];
        let other = &supernodes.groups[run.owner];
        let height = other.columns + other.below();
        let local = &run.local[place - run.places.start..];
        let source = &later[other.values.start - group.values.end + local[0] as usize * height..][..height];
        for (value, &local) in target[place..].iter_mut().zip(local) {
            *value = source[local as usize];
        }
    };
    if (below * below) as f64 > SHARED {
        front.par_chunks_mut(below).enumerate().for_each(take);
    } else {
        front.chunks_mut(below).enumerate().for_each(take);
    }
    mirror(MatMut::from_column_major_slice_mut(front, below, below));
}

/// Writes the lower triangle over the upper one.
fn mirror(mut a: MatMut<'_, f64>) {
    let n = a.nrows();
    for first in (0..n).step_by(TILE) {
        let last = (first + TILE).min(n);
        for below in (first..n).step_by(TILE) {
            for column in first..last {
                for row in below.max(column + 1)..(below + TILE).min(n) {
                    a[(column, row)] = a[(row, column)];
                }
            }
        }
    }
}

/// `C ← scale A B`, or `C + scale A B`.
fn product(c: MatMut<'_, f64>, accum: Accum, a: MatRef<'_, f64>, b: MatRef<'_, f64>, scale: f64) {
    let inner = a.ncols();
    by_rows(c, inner, |first, rows| {
        let a = a.subrows(first, rows.nrows());
        matmul(rows, accum, a, b, scale, Par::Seq);
    });
}

#[cfg(test)]
mod tests;
