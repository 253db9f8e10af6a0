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
//! Note: everything is computed in place, `Z` over the factor and `Y` over `Ȧ`. Threads share the elimination
//! tree as [`super::tree`] says, upwards with what each group takes off the rows below it, as in
//! [`super::multifrontal`], and downwards with the entries of the groups above. Children are added in one
//! order and dense products are cut in rows of a fixed height, so the bits never depend on the number of
//! threads.
//!
//! Entries are wanted at some rows only. Where no descendant of a group has such a row nothing is computed
//! downwards, and its places are freed on the way up.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, Mat, MatMut, MatRef, Par};

use super::factor::{Factor, Solve, Symbolic};
use super::multifrontal::{add, fresh_square};
use super::rigid::RigidBody;
use super::sparse::{SymmetricMatrix, contiguous_mut};
use super::supernodes::{Group, Run, Supernodes};
use crate::linalg::{HEIGHT, SHARED, by_rows, column_groups, symmetric_part};
use crate::parallel;
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
    /// Of each group; empty where none is wanted.
    inverse: Vec<Vec<f64>>,
    weighted: Vec<Vec<f64>>,
    relief: Option<ReliefProjection>,
}

impl SelectedInverse {
    /// Entry of `A⁻¹` between two wanted rows; `None` off the pattern. For the stiffness of a body without
    /// supports it is that of `K⁺`.
    pub(crate) fn inverse(&self, row: usize, column: usize) -> Option<f64> {
        let relief = self.relief.as_ref().map_or(0.0, |relief| relief.of_inverse(row, column));
        let (group, at) = self.supernodes.position(row, column)?;
        Some(self.inverse[group][at] - relief)
    }

    /// Entry of `A⁻¹WA⁻¹` between two wanted rows; `None` off the pattern. For the stiffness of a body
    /// without supports it is that of `K⁺MK⁺`.
    pub(crate) fn weighted(&self, row: usize, column: usize) -> Option<f64> {
        let relief = self.relief.as_ref().map_or(0.0, |relief| relief.of_weighted(row, column));
        let (group, at) = self.supernodes.position(row, column)?;
        Some(self.weighted[group][at] - relief)
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
    pub(crate) fn select_bytes(&self, rows: impl IntoIterator<Item = usize>) -> usize {
        let supernodes = self.supernodes();
        let wanted =
            supernodes.groups.iter().zip(supernodes.with_ancestors(rows)).filter(|(_, wanted)| *wanted);
        let kept: usize = wanted.map(|(group, _)| group.values.len()).sum();
        size_of::<f64>() * (kept + supernodes.tallest().pow(2) + 2 * supernodes.largest())
    }
}

/// Multiplications for a group, and what takes as long.
fn work(group: &Group) -> f64 {
    upward_work(group) + downward_work(group)
}

fn upward_work(group: &Group) -> f64 {
    let [j, i] = [group.columns as f64, group.below() as f64];
    i * i * j + 2.5 * i * j * j + 0.5 * MOVE * i * i
}

fn downward_work(group: &Group) -> f64 {
    let [j, i] = [group.columns as f64, group.below() as f64];
    3.0 * i * i * j + 3.0 * i * j * j + 5.0 * j.powi(3) + 0.5 * MOVE * i * i
}

impl Factor {
    /// Entries of `A⁻¹` and of `A⁻¹WA⁻¹` between the given rows on the pattern of the factor, which is used
    /// up. All threads.
    ///
    /// Some ten times the multiplications of the factorisation if all rows are wanted, and half of them at
    /// least. Memory: what is wanted of the factor once more, and a dense front.
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
        rows: impl IntoIterator<Item = usize>,
        listener: &dyn Listener,
    ) -> Result<SelectedInverse, Cancelled> {
        let relief = self.rigid().map(|rigid| ReliefProjection::new(&self, rigid, weight));
        let (symbolic, values) = self.into_values();
        assert!(std::ptr::eq(symbolic.pattern(), &**weight.pattern()), "one pattern per symbolic analysis");
        let supernodes = symbolic.supernodes().clone();
        let wanted = supernodes.with_ancestors(rows);
        let progress = SelectProgress::new(&supernodes, &wanted, listener);
        progress.advance(0.0)?;
        let mut inverse = supernodes.in_groups(values);
        let mut weighted = vec![vec![]; supernodes.groups.len()];

        let parts = inverse.iter_mut().zip(&mut weighted).collect();
        supernodes.tree.upwards(
            parts,
            |at, (values, kept): Places<'_>, children: Vec<(usize, Vec<f64>)>| {
                let group = &supernodes.groups[at];
                let mut slopes = supernodes.of_group(group, weight);
                let update = upwards(&supernodes, group, [values, &mut slopes], children, wanted[at]);
                if wanted[at] {
                    *kept = slopes;
                } else {
                    *values = vec![];
                }
                progress.advance(upward_work(group))?;
                Ok(update)
            },
        )?;

        let parts = inverse.iter_mut().zip(&mut weighted).collect();
        let done: Vec<OnceLock<[&[f64]; 2]>> = wanted.iter().map(|_| OnceLock::new()).collect();
        supernodes.tree.downwards(parts, |at, (values, slopes): Places<'_>, _| {
            let group = &supernodes.groups[at];
            // After a stop groups above may be missing.
            if wanted[at] && progress.advance(0.0).is_ok() {
                downwards(&supernodes, group, [values, slopes], &done);
                done[at].set([values, slopes]).expect("each group once");
                // A stop is noticed before the next group.
                let _ = progress.advance(downward_work(group));
            }
        });
        progress.advance(0.0)?;
        drop(done);
        Ok(SelectedInverse { supernodes, inverse, weighted, relief })
    }
}

/// Places of a group in both arrays.
type Places<'v> = (&'v mut Vec<f64>, &'v mut Vec<f64>);

/// Work of a selection that is done.
struct SelectProgress<'a> {
    listener: &'a dyn Listener,
    total: f64,
    /// Work done, and true once the listener wants to stop.
    done: Mutex<(f64, bool)>,
}

impl<'a> SelectProgress<'a> {
    fn new(supernodes: &Supernodes, wanted: &[bool], listener: &'a dyn Listener) -> Self {
        let of = |(group, &wanted): (&Group, &bool)| {
            upward_work(group) + if wanted { downward_work(group) } else { 0.0 }
        };
        let total = supernodes.groups.iter().zip(wanted).map(of).sum();
        Self { listener, total, done: Mutex::new((0.0, false)) }
    }

    fn advance(&self, work: f64) -> Result<(), Cancelled> {
        let mut done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
        done.0 += work;
        let [now, total] = [done.0.min(self.total), self.total].map(|work| (work / SHARED).ceil() as usize);
        done.1 |= self.listener.checkpoint(now, total).is_err();
        if done.1 { Err(Cancelled) } else { Ok(()) }
    }
}

/// Leaves `L_JJ` and `G`, `Ḋ` and, where they are `wanted`, `Ġ` in the places of a group. Returns what it and
/// its `children` add to the lower triangle of the rows below.
fn upwards(
    supernodes: &Supernodes,
    group: &Group,
    [values, slopes]: [&mut [f64]; 2],
    children: Vec<(usize, Vec<f64>)>,
    wanted: bool,
) -> Vec<f64> {
    let (columns, below) = (group.columns, group.below());
    let mut update = fresh_square(below);
    for (child, from) in children {
        add(supernodes, &supernodes.groups[child], &from, group, slopes, &mut update);
    }
    let (lower, mut ratio) = parts(values, group);
    let lower = lower.rb();
    by_rows(ratio.rb_mut(), columns, |_, rows| {
        solve_upper_triangular_in_place(lower.transpose(), rows.transpose_mut(), Par::Seq);
    });
    let ratio = ratio.rb();
    let (mut pivot, mut slope) = parts(slopes, group);
    mirror(pivot.rb_mut());
    let pivot = pivot.rb();
    if below == 0 {
        return update;
    }
    let mut half = slope.rb().to_owned();
    product(half.as_mut(), Accum::Add, ratio, pivot, -0.5);
    let half = half.as_ref();
    let rows = MatMut::from_column_major_slice_mut(&mut update, below, below);
    by_rows(rows, 2 * columns, |first, rows| {
        let height = rows.nrows();
        // The lower triangle, and what stands beside it in these rows.
        let mut rows = rows.subcols_mut(0, first + height);
        let own = [half, ratio].map(|m| m.subrows(first, height));
        let upto = [half, ratio].map(|m| m.subrows(0, first + height).transpose());
        matmul(rows.rb_mut(), Accum::Add, own[0], upto[1], -1.0, Par::Seq);
        matmul(rows, Accum::Add, own[1], upto[0], -1.0, Par::Seq);
    });
    if wanted {
        by_rows(slope.rb_mut(), 2 * columns, |first, mut rows| {
            // Ȧ − G Ḋ = 2 V − Ȧ.
            let half = half.subrows(first, rows.nrows());
            faer::zip!(&mut rows, half).for_each(|faer::unzip!(slope, half)| *slope = 2.0 * *half - *slope);
            solve_lower_triangular_in_place(lower, rows.rb_mut().transpose_mut(), Par::Seq);
            solve_upper_triangular_in_place(lower.transpose(), rows.transpose_mut(), Par::Seq);
        });
    }
    update
}

/// Leaves `Z` and `Y` in the places of a group, from those of the groups above, which are `done`.
fn downwards(
    supernodes: &Supernodes,
    group: &Group,
    [values, slopes]: [&mut [f64]; 2],
    done: &[OnceLock<[&[f64]; 2]>],
) {
    let (columns, below) = (group.columns, group.below());
    let (mut own, mut own_below) = parts(values, group);
    let (mut slope, mut slope_below) = parts(slopes, group);

    // D⁻¹ and D⁻¹ḊD⁻¹.
    let lower = inverse_of_lower(own.rb());
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
        let [ratio, ratio_slope] = [&own_below, &slope_below].map(|from| from.rb().to_owned());
        let [ratio, ratio_slope] = [ratio.as_ref(), ratio_slope.as_ref()];
        let front = gather(supernodes, below, &runs, |owner| {
            done[owner].get().expect("the groups above come first")[1]
        });
        product(slope_below.rb_mut(), Accum::Replace, front.as_ref(), ratio, -1.0);
        drop(front);
        let front = gather(supernodes, below, &runs, |owner| {
            done[owner].get().expect("the groups above come first")[0]
        });
        product(own_below.rb_mut(), Accum::Replace, front.as_ref(), ratio, -1.0);
        product(slope_below.rb_mut(), Accum::Add, front.as_ref(), ratio_slope, 1.0);
        drop(front);
        product(own.rb_mut(), Accum::Add, ratio.transpose(), own_below.rb(), -1.0);
        product(slope.rb_mut(), Accum::Add, ratio_slope.transpose(), own_below.rb(), 1.0);
        product(slope.rb_mut(), Accum::Add, ratio.transpose(), slope_below.rb(), -1.0);
    }
    mirror(own);
    mirror(slope);
}

/// The inverse of a lower triangle. Threads share its columns.
fn inverse_of_lower(lower: MatRef<'_, f64>) -> Mat<f64> {
    let n = lower.nrows();
    let mut inverse = Mat::zeros(n, n);
    parallel::for_each_of(column_groups(inverse.as_mut(), HEIGHT), &|at, columns| {
        let first = at * HEIGHT;
        let mut rows = columns.subrows_mut(first, n - first);
        rows.rb_mut().diagonal_mut().fill(1.0);
        solve_lower_triangular_in_place(lower.submatrix(first, first, n - first, n - first), rows, Par::Seq);
    });
    inverse
}

/// The square on the columns of a group, and the rows below it.
fn parts<'a>(values: &'a mut [f64], group: &Group) -> (MatMut<'a, f64>, MatMut<'a, f64>) {
    let height = group.columns + group.below();
    MatMut::from_column_major_slice_mut(values, height, group.columns).split_at_row_mut(group.columns)
}

/// The entries between all rows below a group, from those of the groups that own them.
fn gather<'v>(
    supernodes: &Supernodes,
    below: usize,
    runs: &[Run],
    values: impl Fn(usize) -> &'v [f64] + Sync,
) -> Mat<f64> {
    let mut front = Mat::zeros(below, below);
    let take = |place: usize, target: &mut [f64]| {
        let run = &runs[runs.partition_point(|run| run.places.end <= place)];
        let height = supernodes.groups[run.owner].height();
        let local = &run.local[place - run.places.start..];
        let source = &values(run.owner)[local[0] as usize * height..][..height];
        for (value, &local) in target[place..].iter_mut().zip(local) {
            *value = source[local as usize];
        }
    };
    if (below * below) as f64 > SHARED {
        parallel::for_each_of(column_groups(front.as_mut(), 1), &|place, column| {
            take(place, contiguous_mut(column, 0));
        });
    } else {
        (0..below).for_each(|place| take(place, front.col_as_slice_mut(place)));
    }
    mirror(front.as_mut());
    front
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
