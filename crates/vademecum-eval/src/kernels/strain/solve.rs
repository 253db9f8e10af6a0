//! The solve of a sub-step: Gram matrix of the rows, its factor, and what is done where rounding has taken
//! too many of its digits.

use crate::base::scalar::Scalar;
use crate::kernels::kernel::{along, less, total};
use crate::kernels::strain::memory::{Digits, PANEL, Scratch, StrainMap};
use crate::kernels::strain::tail::substitute;
use crate::kernels::strain::wide;

/// The matrix of the step: the mass, and the Gram matrix of the rows; its upper half.
#[inline(always)]
fn gram<T: Scalar>(map: &StrainMap<'_, T>, scratch: &mut Scratch<'_, T>) {
    let n = map.shape.padded();
    let rows = map.shape.rows.max(1);
    for (i, first) in scratch.rows.chunks_exact(rows).enumerate() {
        for (j, second) in scratch.rows.chunks_exact(rows).enumerate().skip(i) {
            let mut lines = scratch.matrix.chunks_exact_mut(n.max(1)).skip(PANEL * i);
            // As many numbers at once as there are registers for.
            if size_of::<T>() > 4 {
                put_block(tile::<T, 0, 2>(first, second), j, &mut lines);
                put_block(tile::<T, 2, 2>(first, second), j, &mut lines);
                put_block(tile::<T, 4, 2>(first, second), j, &mut lines);
                put_block(tile::<T, 6, 2>(first, second), j, &mut lines);
            } else {
                put_block(tile::<T, 0, 4>(first, second), j, &mut lines);
                put_block(tile::<T, 4, 4>(first, second), j, &mut lines);
            }
        }
    }
    for (i, line) in scratch.matrix.chunks_exact_mut(n.max(1)).enumerate() {
        if let (Some(pivot), Some(&inertia)) = (line.get_mut(i), map.inertia.get(i)) {
            *pivot += map.mass * inertia;
        }
    }
}

/// Rows `FIRST` to `FIRST + HEIGHT` of the products of two panels.
#[inline(always)]
fn tile<T: Scalar, const FIRST: usize, const HEIGHT: usize>(
    first: &[[T; PANEL]],
    second: &[[T; PANEL]],
) -> [[T; PANEL]; HEIGHT] {
    let mut sums = [[T::ZERO; PANEL]; HEIGHT];
    for (a, b) in first.iter().zip(second) {
        for i in 0..HEIGHT {
            for j in 0..PANEL {
                sums[i][j] += a[(FIRST + i) % PANEL] * b[j];
            }
        }
    }
    sums
}

/// Writes lines of a block to panel `panel` of the next lines of the matrix.
#[inline(always)]
fn put_block<'a, T: Scalar + 'a, const HEIGHT: usize>(
    block: [[T; PANEL]; HEIGHT],
    panel: usize,
    lines: &mut impl Iterator<Item = &'a mut [T]>,
) {
    for (line, block) in lines.take(HEIGHT).zip(block) {
        if let Some(out) = line.as_chunks_mut::<PANEL>().0.get_mut(panel) {
            *out = block;
        }
    }
}

/// `A = Uᵀ D⁻¹ U` in place: `U` in the upper half, the inverses of its diagonal beside it. No pivot is below
/// the mass.
#[inline(always)]
fn factor<T: Scalar>(matrix: &mut [T], inverse: &mut [T]) {
    let n = inverse.len();
    let mut below = matrix;
    for (j, inverse) in inverse.iter_mut().enumerate() {
        let Some((line, rest)) = below.split_at_mut_checked(n) else { return };
        *inverse = T::from_f64(1.0 / line.get(j).map_or(1.0, |pivot| pivot.to_f64()));
        for (i, other) in (j + 1..n).zip(rest.chunks_exact_mut(n.max(1))) {
            let share = line.get(i).map_or(T::ZERO, |&entry| entry * *inverse);
            let start = i / PANEL;
            let from = line.as_chunks::<PANEL>().0.iter().skip(start);
            for (out, from) in other.as_chunks_mut::<PANEL>().0.iter_mut().skip(start).zip(from) {
                *out = less(*out, share, from);
            }
        }
        below = rest;
    }
}

/// Solves with a factor of [`factor`], in place.
#[inline(always)]
fn solve<T: Scalar>(matrix: &[T], inverse: &[T], x: &mut [T]) {
    let n = inverse.len().max(1);
    for (j, (line, &inverse)) in matrix.chunks_exact(n).zip(inverse).enumerate() {
        let Some(known) = x.get(j).map(|&x| x * inverse) else { return };
        let start = j / PANEL;
        let parts = x.as_chunks_mut::<PANEL>().0.iter_mut().zip(line.as_chunks::<PANEL>().0);
        for (panel, (x, line)) in parts.enumerate().skip(start) {
            let mut own = *line;
            if panel == start {
                // What is known already stays.
                (0..=j % PANEL).for_each(|i| own[i] = T::ZERO);
            }
            *x = less(*x, known, &own);
        }
    }
    for (j, (line, &inverse)) in matrix.chunks_exact(n).zip(inverse).enumerate().rev() {
        // Entries before the diagonal are not those of the factor; what is known of `x` begins behind it.
        let (mut sums, start) = ([T::ZERO; PANEL], j / PANEL);
        let known = x.as_chunks::<PANEL>().0.iter().zip(line.as_chunks::<PANEL>().0).enumerate();
        for (panel, (x, line)) in known.skip(start) {
            let mut own = *line;
            if panel == start {
                (0..=j % PANEL).for_each(|i| own[i] = T::ZERO);
            }
            let mut sum = sums;
            for i in 0..PANEL {
                sum[i] += x[i] * own[i];
            }
            sums = sum;
        }
        if let Some(x) = x.get_mut(j) {
            *x = (*x - total(&sums)) * inverse;
        }
    }
}

/// The step's solve: matrix, factor, `d` of the leading coordinates from the right-hand side, and `d` of the
/// tail in place of its own.
#[inline(always)]
pub(crate) fn solve_step<T: Scalar>(map: &StrainMap<'_, T>, scratch: &mut Scratch<'_, T>) {
    decompose(map, scratch);
    scratch.solution.iter_mut().zip(&*scratch.leading).for_each(|(out, &right)| *out = right);
    solve(scratch.matrix, scratch.inverse, scratch.solution);
    finish(map, scratch);
}

/// The same with the factor that is there.
pub(crate) fn solve_prepared<T: Scalar>(map: &StrainMap<'_, T>, scratch: &mut Scratch<'_, T>) {
    scratch.solution.iter_mut().zip(&*scratch.leading).for_each(|(out, &right)| *out = right);
    solve_apart(scratch.matrix, scratch.inverse, scratch.solution);
    finish(map, scratch);
}

/// Matrix and factor.
#[inline(always)]
pub(crate) fn decompose<T: Scalar>(map: &StrainMap<'_, T>, scratch: &mut Scratch<'_, T>) {
    gram(map, scratch);
    factor(scratch.matrix, scratch.inverse);
    judge(map, scratch);
}

/// Judges a factor, and makes that of twice the digits if nothing is left of one in single precision.
#[inline(never)]
fn judge<T: Scalar>(map: &StrainMap<'_, T>, scratch: &mut Scratch<'_, T>) {
    let mass = map.mass.to_f64();
    // No pivot is below the inertia, which is 0.6 and more; nor is it a number if one before it was zero.
    let within = |least: f64| scratch.inverse.iter().all(|x| (least..2.0).contains(&(mass * x.to_f64())));
    // Where nothing takes energy, the rounding of single precision shows after many steps.
    scratch.digits = if (map.damped || !single::<T>()) && within(1.0 / worn::<T>()) {
        Digits::Enough
    } else if within(16.0 * T::EPSILON) {
        Digits::Worn
    } else {
        Digits::Lost
    };
    if single::<T>() && scratch.digits == Digits::Lost {
        let diagonal = |i: usize| mass * map.inertia.get(i).map_or(1.0, |m| m.to_f64());
        let [low, _] = &mut scratch.low;
        let rows = (&*scratch.rows, map.shape.rows.max(1));
        wide::factor(rows, diagonal, [&mut *scratch.matrix, low], map.shape.padded());
    }
}

const fn single<T>() -> bool {
    size_of::<T>() < 8
}

/// Pivots over the mass above which a solve is refined: rounding of the matrix would show in the energy.
const fn worn<T>() -> f64 {
    if single::<T>() { 1e3 } else { 1e4 }
}

/// The rest of a solve: `d` of the leading coordinates was found with the factor as it is.
#[inline(always)]
fn finish<T: Scalar>(map: &StrainMap<'_, T>, scratch: &mut Scratch<'_, T>) {
    if scratch.digits != Digits::Enough {
        mend(map, scratch);
    }
    substitute(map, scratch);
}

/// Refines `d` of the leading coordinates. Single precision, which loses its digits soon, then takes twice as
/// many; double precision has none to take.
#[inline(never)]
fn mend<T: Scalar>(map: &StrainMap<'_, T>, scratch: &mut Scratch<'_, T>) {
    if !single::<T>() && scratch.digits == Digits::Worn {
        return correct(map, scratch);
    }
    if single::<T>() && scratch.digits == Digits::Lost {
        let [low, x_low] = &mut scratch.low;
        let x = [&mut *scratch.solution, x_low];
        wide::solve::<T, PANEL>([&*scratch.matrix, low], scratch.leading, x);
    }
    balance(map, scratch);
}

/// Scales `d` so that `d·A d` is `d·b`, which is all that the identity of the energy needs: it then holds
/// however many digits the factor has lost, and with it the bound.
fn balance<T: Scalar>(map: &StrainMap<'_, T>, scratch: &mut Scratch<'_, T>) {
    let (mut given, mut taken) = (0.0, 0.0);
    for ((d, right), inertia) in scratch.solution.iter().zip(&*scratch.leading).zip(map.inertia) {
        let d = d.to_f64();
        given += d * right.to_f64();
        taken += map.mass.to_f64() * inertia.to_f64() * d * d;
    }
    let (stride, solution) = (map.shape.rows.max(1), scratch.solution.as_chunks::<PANEL>().0);
    for k in 0..map.shape.rows {
        let along = along(scratch.rows.iter().skip(k).step_by(stride), solution).to_f64();
        taken += along * along;
    }
    let more = (given - taken) / taken;
    if more.is_finite() {
        // Added, not multiplied: numbers just below 1 are twice as dense as those above it, and a march of
        // many steps would lose energy.
        let more = T::from_f64(more);
        scratch.solution.iter_mut().for_each(|d| *d += *d * more);
    }
}

/// [`solve`], once in a program: for what is not done in every step.
#[inline(never)]
fn solve_apart<T: Scalar>(matrix: &[T], inverse: &[T], x: &mut [T]) {
    solve(matrix, inverse, x);
}

/// Corrects `d` by what it leaves of the right-hand side, which it overwrites.
///
/// Entries of the matrix are rounded to those of stiff rows, beside which the mass is small. The rows
/// themselves are not squared: with `ĝ·d` first, rounding grows with the root of what it grew with.
#[inline(never)]
fn correct<T: Scalar>(map: &StrainMap<'_, T>, scratch: &mut Scratch<'_, T>) {
    let stride = map.shape.rows.max(1);
    let solution = scratch.solution.as_chunks::<PANEL>().0;
    let right = scratch.leading.as_chunks_mut::<PANEL>().0;
    for ((right, d), inertia) in right.iter_mut().zip(solution).zip(map.inertia.as_chunks::<PANEL>().0) {
        for i in 0..PANEL {
            right[i] = right[i] - map.mass * inertia[i] * d[i];
        }
    }
    for k in 0..map.shape.rows {
        let along = along(scratch.rows.iter().skip(k).step_by(stride), solution);
        for (right, g) in right.iter_mut().zip(scratch.rows.iter().skip(k).step_by(stride)) {
            *right = less(*right, along, g);
        }
    }
    solve_apart(scratch.matrix, scratch.inverse, scratch.leading);
    scratch.solution.iter_mut().zip(&*scratch.leading).for_each(|(d, &more)| *d += more);
}
