//! A sub-step of the strain structure: its rows, what they push with, and where it ends.
//!
//! All of it works on arrays of fixed length, so that it vectorises without run-time lengths inside, and
//! every sum has one order, whatever the width of the machine's vectors: row products go column by column,
//! the Gram matrix row by row, and sums along a row in eight parts that are added in halves.
//! A machine with AVX2 therefore takes the same code with longer vectors
//! (`docs/developers/decisions/vectors.md`).
//!
//! Note: rows come scaled by the roots of their weights (see [`crate::strain_map`]), so that the
//! matrix of a step is the inertia and the plain Gram matrix of the rows.

use crate::base::lend::{Lender, Short};
use crate::base::scalar::Scalar;
use crate::base::vectors::{Kernel, vectorised};
use crate::kernels::kernel::{columns_times, less, total};
use crate::kernels::strain::memory::{PANEL, Scratch, StrainMap};
use crate::kernels::strain::solve::{decompose, solve_prepared, solve_step};
use crate::kernels::strain::tail;

/// Takes the mean displacement and `p` of a state, `(r)` each: where the rows are evaluated.
pub(crate) fn place<T: Scalar>(
    map: &StrainMap<'_, T>,
    mean: &[T],
    p: impl Iterator<Item = T>,
    scratch: &mut Scratch<'_, T>,
) {
    let (half, quarter) = (T::from_f32(0.5), T::from_f32(0.25));
    let [at, before, here] = &mut scratch.place;
    let out = at.iter_mut().zip(before.iter_mut()).zip(here.iter_mut());
    let leading = mean.iter().zip(p).take(map.shape.leading).map(|(&mean, p)| (mean, p));
    let padding = core::iter::repeat((T::ZERO, T::ZERO));
    for (((at, before), here), (mean, p)) in out.zip(leading.chain(padding)) {
        (*at, *before, *here) = (mean + half * p, half * mean - quarter * p, mean);
    }
}

/// All rows: `ĝ` into the panels, and what they push with off the right-hand sides `leading` and `tail`,
/// which hold `p + f`. `mean` is the displacement of all coordinates.
#[inline(always)]
pub(crate) fn rows<T: Scalar>(
    map: &StrainMap<'_, T>,
    mean: &[T],
    scratch: &mut Scratch<'_, T>,
) -> Result<(), Short> {
    match map.shape.width() {
        24 => products::<T, 24>(map, scratch)?,
        16 => products::<T, 16>(map, scratch)?,
        _ => products::<T, PANEL>(map, scratch)?,
    }
    push(map, mean, scratch)
}

/// `Q̂ q` of every row into the panels.
#[inline(always)]
fn products<T: Scalar, const W: usize>(
    map: &StrainMap<'_, T>,
    scratch: &mut Scratch<'_, T>,
) -> Result<(), Short> {
    let (shape, at) = (map.shape, &*scratch.place[0]);
    // Never zero, which the compiler cannot see.
    let stride = shape.rows.max(1);
    let mut quadratic = Lender::new(map.quadratic);
    for k in 0..shape.rows {
        let mut panels = scratch.rows.iter_mut().skip(k).step_by(stride);
        for start in (0..shape.padded()).step_by(W) {
            let block = quadratic.take(shape.columns(start) * W)?.as_chunks::<W>().0;
            let products = columns_times(block, at, [T::ZERO; W]);
            for products in products.as_chunks::<PANEL>().0 {
                if let Some(out) = panels.next() {
                    *out = *products;
                }
            }
        }
    }
    Ok(())
}

/// `ĝ`, and what every row pushes with.
#[inline(always)]
fn push<T: Scalar>(map: &StrainMap<'_, T>, mean: &[T], scratch: &mut Scratch<'_, T>) -> Result<(), Short> {
    let shape = map.shape;
    let (n, stride) = (shape.padded(), shape.rows.max(1));
    let [_, before, here] = &scratch.place;
    let (before, here) = (before.as_chunks::<PANEL>().0, here.as_chunks::<PANEL>().0);
    let mut linear = Lender::new(map.linear);
    for (k, &[force, _]) in map.rows.iter().enumerate() {
        let mut sums = [T::ZERO; PANEL];
        let panels = scratch.rows.iter_mut().skip(k).step_by(stride);
        let places = linear.take(n)?.as_chunks::<PANEL>().0.iter().zip(before).zip(here);
        for (out, ((linear, before), here)) in panels.zip(places) {
            // Apart from what they come from, so that they are vectors.
            let (mut g, mut sum) = (*out, sums);
            for i in 0..PANEL {
                sum[i] += g[i] * before[i] + linear[i] * here[i];
                g[i] += linear[i];
            }
            (*out, sums) = (g, sum);
        }
        let push = tail::push(map, k, (total(&sums), force), mean, scratch.tail);
        let panels = scratch.rows.iter().skip(k).step_by(stride);
        for (out, g) in scratch.leading.as_chunks_mut::<PANEL>().0.iter_mut().zip(panels) {
            *out = less(*out, push, g);
        }
    }
    Ok(())
}

/// The force of a sub-step on every coordinate, as it enters the right-hand side.
#[derive(Clone, Copy)]
pub(crate) struct Force<'s, T> {
    /// At the start of the step.
    pub start: &'s [T],
    /// Its growth over the step.
    pub rise: &'s [T],
    /// Middle of the sub-step, as a fraction of the step.
    pub fraction: T,
}

impl<'s, T: Scalar> Force<'s, T> {
    /// On each coordinate.
    pub fn values(&self) -> impl Iterator<Item = T> + use<'s, T> {
        let fraction = self.fraction;
        self.start.iter().zip(self.rise).map(move |(&start, &rise)| start + fraction * rise)
    }
}

/// One sub-step: the mean displacement and `p`, `(r)` each, to its end. `d` is left in the scratch.
#[inline(never)]
pub(crate) fn sub_step<T: Scalar>(
    map: &StrainMap<'_, T>,
    mean: &mut [T],
    p: &mut [T],
    force: Force<'_, T>,
    scratch: &mut Scratch<'_, T>,
) -> Result<(), Short> {
    vectorised(SubStep { map, mean, p, force, scratch })
}

/// A sub-step and what it works on.
struct SubStep<'a, 's, T> {
    map: &'a StrainMap<'a, T>,
    mean: &'a mut [T],
    p: &'a mut [T],
    force: Force<'a, T>,
    scratch: &'a mut Scratch<'s, T>,
}

impl<T: Scalar> Kernel for SubStep<'_, '_, T> {
    type Output = Result<(), Short>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { map, mean, p, force, scratch } = self;
        place(map, mean, p.iter().copied(), scratch);
        let leading = map.shape.leading;
        let right = p.iter().zip(map.inertia).zip(force.values()).map(|((&p, &m), force)| m * p + force);
        let mut out = scratch.leading.iter_mut().take(leading).chain(&mut *scratch.tail);
        right.zip(&mut out).for_each(|(right, out)| *out = right);
        scratch.leading.iter_mut().skip(leading).for_each(|out| *out = T::ZERO);
        rows(map, mean, scratch)?;
        solve_step(map, scratch);
        for ((mean, p), d) in mean.iter_mut().zip(p).zip(moved(map, scratch)) {
            *mean += d;
            *p = d + d - *p;
        }
        Ok(())
    }
}

/// `d` of every coordinate.
pub(crate) fn moved<'s, T: Scalar>(
    map: &StrainMap<'_, T>,
    scratch: &'s Scratch<'_, T>,
) -> impl Iterator<Item = T> + use<'s, T> {
    scratch.solution.iter().take(map.shape.leading).chain(&*scratch.tail).copied()
}

/// `(μ − 1) Σ_j m_j d_j² + Σ_k (W_k − 1)(ĝ_k·d)²`: what the sub-step in the scratch took from the energy, in
/// the units of its right-hand side.
pub(crate) fn dissipated<T: Scalar>(map: &StrainMap<'_, T>, scratch: &Scratch<'_, T>) -> f64 {
    let squares = moved(map, scratch).zip(map.inertia).map(|(d, m)| m.to_f64() * d.to_f64() * d.to_f64());
    let of_mass: f64 = squares.sum();
    let mut sum = (map.mass.to_f64() - 1.0) * of_mass;
    for (k, &[_, drag]) in map.rows.iter().enumerate() {
        let panels = scratch.rows.iter().skip(k).step_by(map.shape.rows.max(1));
        let mut along = 0.0;
        for (g, d) in panels.zip(scratch.solution.as_chunks::<PANEL>().0) {
            along += g.iter().zip(d).map(|(g, d)| g.to_f64() * d.to_f64()).sum::<f64>();
        }
        along += tail::own(map, k, |l| scratch.tail.get(l).map_or(0.0, |d| d.to_f64()));
        sum += drag.to_f64() * along * along;
    }
    sum
}

/// `Σ_k ẑ_k²` of a state, with the mean displacement and `p` of each coordinate.
pub(crate) fn strain_square<T: Scalar>(map: &StrainMap<'_, T>, mean: &[T], p: impl Fn(usize) -> f64) -> f64 {
    let shape = map.shape;
    let (n, width) = (shape.padded(), shape.width());
    let mean_of = |i: usize| mean.get(i).map_or(0.0, |mean| mean.to_f64());
    let leading = |i: usize| if i < shape.leading { (mean_of(i), p(i)) } else { (0.0, 0.0) };
    let at = |i: usize| leading(i).0 + 0.5 * leading(i).1;
    let before = |i: usize| 0.5 * leading(i).0 - 0.25 * leading(i).1;
    let lines = map.linear.chunks_exact(n.max(1)).zip(map.quadratic.chunks_exact(shape.row_len().max(1)));
    let mut sum = 0.0;
    for ((k, (linear, quadratic)), &[force, _]) in lines.enumerate().zip(map.rows) {
        let mut z: f64 = linear.iter().enumerate().map(|(i, l)| l.to_f64() * leading(i).0).sum();
        let mut columns = quadratic.chunks_exact(width.max(1));
        for start in (0..n).step_by(width.max(1)) {
            for (b, column) in columns.by_ref().take(shape.columns(start)).enumerate() {
                let products = column.iter().enumerate().map(|(i, c)| c.to_f64() * before(start + i));
                z += at(b) * products.sum::<f64>();
            }
        }
        z += tail::own(map, k, |_| mean_of(k));
        // The weight is taken out again.
        sum += 0.5 * force.to_f64() * z * z;
    }
    sum
}

/// Rows, matrix and factor at a state, for [`answer`].
pub(crate) fn prepare<T: Scalar>(
    map: &StrainMap<'_, T>,
    mean: &[T],
    p: impl Iterator<Item = T>,
    scratch: &mut Scratch<'_, T>,
) -> Result<(), Short> {
    place(map, mean, p, scratch);
    scratch.tail.fill(T::ZERO);
    rows(map, mean, scratch)?;
    decompose(map, scratch);
    Ok(())
}

/// `A⁻¹ right` of a prepared scratch, `(r)`, into the scratch; see [`moved`].
pub(crate) fn answer<T: Scalar>(map: &StrainMap<'_, T>, right: &[T], scratch: &mut Scratch<'_, T>) {
    scratch.leading.fill(T::ZERO);
    let out = scratch.leading.iter_mut().take(map.shape.leading).chain(&mut *scratch.tail);
    right.iter().zip(out).for_each(|(&right, out)| *out = right);
    tail::reduce(map, scratch);
    solve_prepared(map, scratch);
}
