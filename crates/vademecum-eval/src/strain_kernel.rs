//! The inner loops of the strain structure: strain rows, their weighted Gram matrix, and a small solve.
//!
//! All of it works on arrays of fixed length, so that it vectorises without run-time lengths inside, and
//! every sum has one order, whatever the width of the machine's vectors: row products go column by column,
//! the Gram matrix row by row, and sums along a row in eight parts that are added in halves.
//! A machine with AVX2 therefore takes the same code with longer vectors (`docs/decisions/avx2.md`).
//!
//! The odd thing: rows come scaled by the roots of their weights (see [`crate::strain_map`]), so that the
//! matrix of a step is the inertia and the plain Gram matrix of the rows.

use crate::kernel::{columns_times, total};
use crate::lend::{Lender, Short};
use crate::scalar::Scalar;
use crate::strain_wide as wide;
use crate::vectors::{Kernel, vectorised};

/// Numbers of a row handled at once; rows are padded to multiples of it.
pub(crate) const PANEL: usize = 8;

/// The lengths of a strain structure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct StrainShape {
    /// `n`: coordinates that interact.
    pub interacting: usize,
    /// `n + n₁`: leading coordinates, all but the tail; and leading rows.
    pub leading: usize,
    /// Coordinates of the tail, and their rows.
    pub tail: usize,
    /// Rows in all.
    pub rows: usize,
}

impl StrainShape {
    /// Length of a padded row.
    pub const fn padded(&self) -> usize {
        self.leading.next_multiple_of(PANEL)
    }

    /// Numbers of a row whose products are formed together.
    pub const fn width(&self) -> usize {
        match self.padded() {
            n if n.is_multiple_of(24) => 24,
            n if n.is_multiple_of(16) => 16,
            _ => PANEL,
        }
    }

    /// Coordinates that meet the numbers of a row from `start` on: those of the coupled coordinates meet the
    /// interacting ones alone.
    pub const fn columns(&self, start: usize) -> usize {
        if start < self.interacting { self.leading } else { self.interacting }
    }

    /// Numbers of the quadratic part of a row.
    pub const fn row_len(&self) -> usize {
        let (mut sum, mut start) = (0, 0);
        while start < self.padded() {
            sum += self.columns(start) * self.width();
            start += self.width();
        }
        sum
    }

    /// Numbers of a row for all coordinates: as many as there are, or as a padded row has.
    pub const fn coordinates(&self) -> usize {
        let (all, padded) = (self.leading + self.tail, self.padded());
        if all > padded { all } else { padded }
    }

    /// Length of the map: linear part, quadratic part, numbers of rows, of tail coordinates, and of all
    /// coordinates.
    pub const fn map_len(&self) -> usize {
        self.rows * (self.padded() + self.row_len() + ROW) + self.tail * TAIL + 2 * self.coordinates()
    }

    /// Length of the memory a step works in.
    pub const fn scratch_len(&self) -> usize {
        let n = self.padded();
        self.rows * n + 2 * n * n + 7 * n + 2 * self.tail
    }
}

/// Numbers of a row beside its map: of the force, and of the dissipation.
pub(crate) const ROW: usize = 2;
/// Numbers of a tail coordinate: see [`StrainMap::tail`].
pub(crate) const TAIL: usize = 4;

/// The map of a bound scene. With `w` the weight of a row, all of a row is multiplied by `√w`.
#[derive(Clone, Copy)]
pub(crate) struct StrainMap<'s, T> {
    pub shape: StrainShape,
    /// `L̂`, `(rows, padded)`.
    pub linear: &'s [T],
    /// `Q̂`, row by row in blocks of [`StrainShape::width`] numbers, each block column by column.
    pub quadratic: &'s [T],
    /// `2/w` and `(W − 1)/w` of each row.
    pub rows: &'s [[T; ROW]],
    /// Of each tail coordinate `x √w`, `2 x/√w`, `W x/(a √w)` and `1/a`.
    pub tail: &'s [[T; TAIL]],
    /// Inertia `m` of each coordinate, 1 but for natural modes. Padding has some positive number.
    pub inertia: &'s [T],
    /// `√m`.
    pub roots: &'s [T],
    /// What the inertia has on the diagonal, `1 + k α/2`.
    pub mass: T,
    /// Whether anything takes energy.
    pub damped: bool,
}

impl<'s, T> StrainMap<'s, T> {
    /// Cuts the memory of a scene.
    pub fn new(shape: StrainShape, mass: T, damped: bool, memory: &'s [T]) -> Result<Self, Short> {
        let mut memory = Lender::new(memory);
        Ok(Self {
            shape,
            linear: memory.take(shape.rows * shape.padded())?,
            quadratic: memory.take(shape.rows * shape.row_len())?,
            rows: memory.take(shape.rows * ROW)?.as_chunks().0,
            tail: memory.take(shape.tail * TAIL)?.as_chunks().0,
            inertia: memory.take(shape.coordinates())?,
            roots: memory.take(shape.coordinates())?,
            mass,
            damped,
        })
    }

    /// `p = k ζ̇/√m` of a coordinate, from `k ζ̇`.
    ///
    /// It is divided, not multiplied by an inverse: there and back again a march of many steps would grow.
    pub fn p_of(&self, coordinate: usize, rate: f64) -> f64
    where
        T: Scalar,
    {
        self.roots.get(coordinate).map_or(rate, |root| rate / root.to_f64())
    }
}

/// The memory a step works in.
pub(crate) struct Scratch<'s, T> {
    /// `ĝ` in panels: the first [`PANEL`] numbers of every row, then the next.
    pub rows: &'s mut [[T; PANEL]],
    /// The matrix, `(padded, padded)`, of which the upper half is used, and its factor.
    pub matrix: &'s mut [T],
    /// What is left of its numbers below their rounding, and of those of `solution`, where the factor is
    /// [`wide`].
    pub low: [&'s mut [T]; 2],
    /// How good the factor is.
    pub digits: Digits,
    /// `1/pivot`.
    pub inverse: &'s mut [T],
    /// `q`, `(q − p)/2` and the mean displacement of the leading coordinates.
    pub place: [&'s mut [T]; 3],
    /// Right-hand side of the leading coordinates.
    pub leading: &'s mut [T],
    /// `d` of the leading coordinates.
    pub solution: &'s mut [T],
    /// Right-hand side of the tail coordinates, then `d`.
    pub tail: &'s mut [T],
    /// `ĝ·d` of the leading coordinates in each tail row.
    pub along: &'s mut [T],
}

impl<'s, T: Scalar> Scratch<'s, T> {
    /// Cuts lent memory.
    pub fn new(shape: StrainShape, memory: &'s mut [T]) -> Result<Self, Short> {
        let (n, mut memory) = (shape.padded(), Lender::new(memory));
        let rows = memory.take(shape.rows * n)?.as_chunks_mut().0;
        let matrix = memory.take(n * n)?;
        let inverse = memory.take(n)?;
        let place = [memory.take(n)?, memory.take(n)?, memory.take(n)?];
        let (leading, solution) = (memory.take(n)?, memory.take(n)?);
        let (tail, along) = (memory.take(shape.tail)?, memory.take(shape.tail)?);
        let low = [memory.take(n * n)?, memory.take(n)?];
        Ok(Self { rows, matrix, low, digits: Digits::Enough, inverse, place, leading, solution, tail, along })
    }
}

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
/// which hold `p + f`. `mean` is the displacement of the tail coordinates.
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
    let mut tail = map.tail.iter().zip(mean).zip(&mut *scratch.tail);
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
        let mut z = total(&sums);
        let mut push = force * z;
        if k >= shape.leading
            && let Some(((&[x, pull, share, _], &mean), right)) = tail.next()
        {
            z += x * mean;
            *right = *right - pull * z;
            push = force * z + share * *right;
        }
        let panels = scratch.rows.iter().skip(k).step_by(stride);
        for (out, g) in scratch.leading.as_chunks_mut::<PANEL>().0.iter_mut().zip(panels) {
            *out = less(*out, push, g);
        }
    }
    Ok(())
}

/// `x − share y`.
#[inline(always)]
fn less<T: Scalar>(mut x: [T; PANEL], share: T, y: &[T; PANEL]) -> [T; PANEL] {
    for i in 0..PANEL {
        x[i] = x[i] - share * y[i];
    }
    x
}

/// The matrix of the step: the mass, and the Gram matrix of the rows; its upper half.
#[inline(always)]
pub(crate) fn gram<T: Scalar>(map: &StrainMap<'_, T>, scratch: &mut Scratch<'_, T>) {
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
pub(crate) fn factor<T: Scalar>(matrix: &mut [T], inverse: &mut [T]) {
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
pub(crate) fn solve<T: Scalar>(matrix: &[T], inverse: &[T], x: &mut [T]) {
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

/// Matrix and factor.
#[inline(always)]
fn decompose<T: Scalar>(map: &StrainMap<'_, T>, scratch: &mut Scratch<'_, T>) {
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

/// What rounding left of a factor, in which the mass stands beside the largest pivot.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Digits {
    /// Rounding of the matrix does not show.
    Enough,
    /// It would show in the energy.
    Worn,
    /// It hides the mass: softer directions are noise.
    Lost,
}

const fn single<T>() -> bool {
    size_of::<T>() < 8
}

/// Pivots over the mass above which a solve is mended: rounding of the matrix would show in the energy.
const fn worn<T>() -> f64 {
    if single::<T>() { 1e3 } else { 1e4 }
}

/// The rest of a solve: `d` of the leading coordinates was found with the factor as it is.
#[inline(always)]
fn finish<T: Scalar>(map: &StrainMap<'_, T>, scratch: &mut Scratch<'_, T>) {
    if scratch.digits != Digits::Enough {
        mend(map, scratch);
    }
    eliminate(map, scratch);
}

/// Mends `d` of the leading coordinates. Single precision, which loses its digits soon, then takes twice as
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

/// `ĝ·d` of one row.
#[inline(always)]
fn along<'g, T: Scalar + 'g>(row: impl Iterator<Item = &'g [T; PANEL]>, d: &[[T; PANEL]]) -> T {
    let mut sums = [T::ZERO; PANEL];
    for (g, d) in row.zip(d) {
        for i in 0..PANEL {
            sums[i] += g[i] * d[i];
        }
    }
    total(&sums)
}

/// `d` of the tail coordinates from that of the leading ones.
#[inline(always)]
pub(crate) fn eliminate<T: Scalar>(map: &StrainMap<'_, T>, scratch: &mut Scratch<'_, T>) {
    let rows = map.shape.rows;
    let solution = scratch.solution.as_chunks::<PANEL>().0;
    let tail = map.tail.iter().zip(&mut *scratch.tail).zip(&mut *scratch.along);
    for (l, ((&[_, _, share, inverse], right), out)) in tail.enumerate() {
        let row = scratch.rows.iter().skip(map.shape.leading + l).step_by(rows.max(1));
        *out = along(row, solution);
        *right = *right * inverse - share * *out;
    }
}

/// The force of a sub-step on every coordinate, as it enters the right-hand side.
#[derive(Clone, Copy)]
pub(crate) struct Force<'s, T> {
    /// At the start of the step.
    pub start: &'s [T],
    /// How much it grows over the step.
    pub rise: &'s [T],
    /// Where in the step the sub-step has its middle.
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
        let (_, tail) = mean.split_at_checked(leading).ok_or(Short { found: mean.len(), needed: leading })?;
        rows(map, tail, scratch)?;
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
    let mut tail = map.tail.iter().zip(&*scratch.tail);
    for (k, &[_, drag]) in map.rows.iter().enumerate() {
        let panels = scratch.rows.iter().skip(k).step_by(map.shape.rows.max(1));
        let mut along = 0.0;
        for (g, d) in panels.zip(scratch.solution.as_chunks::<PANEL>().0) {
            along += g.iter().zip(d).map(|(g, d)| g.to_f64() * d.to_f64()).sum::<f64>();
        }
        if k >= map.shape.leading
            && let Some((&[x, ..], d)) = tail.next()
        {
            along += x.to_f64() * d.to_f64();
        }
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
    let mut tail = map.tail.iter().enumerate();
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
        if k >= shape.leading
            && let Some((l, &[x, ..])) = tail.next()
        {
            z += x.to_f64() * mean_of(shape.leading + l);
        }
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
    let needed = map.shape.leading;
    let (_, tail) = mean.split_at_checked(needed).ok_or(Short { found: mean.len(), needed })?;
    scratch.tail.fill(T::ZERO);
    rows(map, tail, scratch)?;
    decompose(map, scratch);
    Ok(())
}

/// `A⁻¹ right` of a prepared scratch, `(r)`, into the scratch; see [`moved`].
pub(crate) fn answer<T: Scalar>(map: &StrainMap<'_, T>, right: &[T], scratch: &mut Scratch<'_, T>) {
    let shape = map.shape;
    scratch.leading.fill(T::ZERO);
    let out = scratch.leading.iter_mut().take(shape.leading).chain(&mut *scratch.tail);
    right.iter().zip(out).for_each(|(&right, out)| *out = right);
    for (l, (&[_, _, share, _], &right)) in map.tail.iter().zip(&*scratch.tail).enumerate() {
        let panels = scratch.rows.iter().skip(shape.leading + l).step_by(shape.rows.max(1));
        for (out, g) in scratch.leading.as_chunks_mut::<PANEL>().0.iter_mut().zip(panels) {
            *out = less(*out, share * right, g);
        }
    }
    scratch.solution.iter_mut().zip(&*scratch.leading).for_each(|(out, &right)| *out = right);
    solve_apart(scratch.matrix, scratch.inverse, scratch.solution);
    finish(map, scratch);
}
