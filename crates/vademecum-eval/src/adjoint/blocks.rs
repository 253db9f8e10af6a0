//! Modes in blocks: [`LANES`] of them side by side, so that a loop over a block has vectors of fixed length.
//! Those beyond the last are zeros. A step of all modes, and a step back with its sums.

use crate::base::vectors::Kernel;
use crate::sections::rows::Field;

/// Modes in a block.
pub(crate) const LANES: usize = 8;
/// Numbers of a step of a mode, and of its sums `G`.
pub(crate) const STEP: usize = 8;

pub(crate) type Lane = [f64; LANES];
/// Two numbers of each mode of a block: `q` and `q̇`, or loads at the start and at the end.
pub(crate) type Pair = [Lane; 2];

/// Place of number `place` of `count` of a mode.
pub(crate) const fn in_blocks(mode: usize, place: usize, count: usize) -> usize {
    (mode / LANES * count + place) * LANES + mode % LANES
}

pub(crate) const fn part_of(field: Field) -> usize {
    match field {
        Field::Displacement => 0,
        Field::Velocity => 1,
    }
}

pub(crate) fn pairs(numbers: &[f64]) -> &[Pair] {
    numbers.as_chunks().0.as_chunks().0
}

pub(crate) fn pairs_mut(numbers: &mut [f64]) -> &mut [Pair] {
    numbers.as_chunks_mut().0.as_chunks_mut().0
}

pub(crate) fn copy(from: &[f64], to: &mut [f64]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
}

/// Displacement or velocity along a row.
#[inline(always)]
pub(crate) fn along(row: &[f64], state: &[f64], field: Field) -> f64 {
    let (mut sums, part) = ([0.0; LANES], part_of(field));
    for (row, state) in row.as_chunks::<LANES>().0.iter().zip(pairs(state)) {
        for k in 0..LANES {
            sums[k] += row[k] * state[part][k];
        }
    }
    sums.iter().sum()
}

/// Loads along the modes at the start and at the end of a step.
#[inline(always)]
pub(crate) fn forces(rows: &[f64], amplitudes: &[f64], out: &mut [f64]) {
    out.fill(0.0);
    let (starts, ends) = amplitudes.split_at(amplitudes.len() / 2);
    let m = out.len() / 2;
    for (row, (&start, &end)) in rows.chunks_exact(m.max(1)).zip(starts.iter().zip(ends)) {
        for (row, out) in row.as_chunks::<LANES>().0.iter().zip(pairs_mut(out)) {
            for k in 0..LANES {
                out[0][k] += start * row[k];
                out[1][k] += end * row[k];
            }
        }
    }
}

/// A step of all modes.
pub(crate) struct Advance<'a> {
    pub steps: &'a [f64],
    pub state: &'a [f64],
    pub force: &'a [f64],
    pub out: &'a mut [f64],
}

impl Kernel for Advance<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let steps: &[[Lane; STEP]] = self.steps.as_chunks().0.as_chunks().0;
        let inputs = pairs(self.state).iter().zip(pairs(self.force));
        for ((e, (y, f)), out) in steps.iter().zip(inputs).zip(pairs_mut(self.out)) {
            for k in 0..LANES {
                out[0][k] = e[0][k] * y[0][k] + e[1][k] * y[1][k] + (e[2][k] * f[0][k] + e[3][k] * f[1][k]);
                out[1][k] = e[4][k] * y[0][k] + e[5][k] * y[1][k] + (e[6][k] * f[0][k] + e[7][k] * f[1][k]);
            }
        }
    }
}

/// A step back of all modes, with the sums of each.
pub(crate) struct Back<'a> {
    pub steps: &'a [f64],
    pub state: &'a [f64],
    pub force: &'a [f64],
    pub lambda: &'a mut [f64],
    pub sums: &'a mut [f64],
    pub of_force: &'a mut [f64],
}

impl Kernel for Back<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let steps: &[[Lane; STEP]] = self.steps.as_chunks().0.as_chunks().0;
        let sums: &mut [[Lane; STEP]] = self.sums.as_chunks_mut().0.as_chunks_mut().0;
        let inputs = pairs(self.state).iter().zip(pairs(self.force));
        let outputs = pairs_mut(self.lambda).iter_mut().zip(pairs_mut(self.of_force));
        for (((e, sums), (y, f)), (lambda, of_force)) in steps.iter().zip(sums).zip(inputs).zip(outputs) {
            for k in 0..LANES {
                let (a, b) = (lambda[0][k], lambda[1][k]);
                let pushed = [y[0][k], y[1][k], f[0][k], f[1][k]];
                for c in 0..4 {
                    sums[c][k] += a * pushed[c];
                    sums[4 + c][k] += b * pushed[c];
                }
                lambda[0][k] = e[0][k] * a + e[4][k] * b;
                lambda[1][k] = e[1][k] * a + e[5][k] * b;
                of_force[0][k] = e[2][k] * a + e[6][k] * b;
                of_force[1][k] = e[3][k] * a + e[7][k] * b;
            }
        }
    }
}
