//! A march of modes that is kept by checkpoints, and what its adjoint sums up for parameters.
//!
//! Each mode steps by `(q, q̇) ← E (q, q̇, f₀, f₁)` with the loads along it at the start and at the end.
//! Going back, the sums over all steps are taken that every derivative is made of:
//!
//! ```text
//! G = Σ λ (q, q̇, f₀, f₁)ᵀ        2 × 4 of each mode, and of each pair of modes of nearly one frequency
//! ĉ = Σ c q, Σ c q̇               for each output, its cotangent with the motion that it reads
//! b̂ = Σ F₀ E₃ᵀλ + F₁ E₄ᵀλ        for each load, its amplitudes with the cotangents of the modes
//! ```
//!
//! States are computed again from checkpoints, `√N` of them for `N` steps, segment by segment and always
//! forwards: a damped mode that is stepped backwards grows.

use crate::adjoint::blocks::{
    Advance, Back, LANES, STEP, along, copy, forces, in_blocks, pairs, pairs_mut, part_of,
};
use crate::adjoint::error::AdjointError;
use crate::base::lend::{Lender, Short};
use crate::base::vectors::{Kernel, vectorised};
use crate::kernels::dense::{at, row, row_mut, set};
use crate::sections::rows::Field;

/// The outputs and the loads of a march, and its length.
#[derive(Clone, Copy, Debug)]
pub struct MarchRows<'r> {
    /// Rows of the outputs, one after the other: over the basis of a [`Parametric`](crate::Parametric) model,
    /// over the modes of a scene.
    pub outputs: &'r [f64],
    /// Displacement or velocity along each of these rows.
    pub fields: &'r [Field],
    /// Rows of the loads, alike.
    pub loads: &'r [f64],
    /// Number of steps.
    pub steps: usize,
}

/// Lengths of a march.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lengths {
    pub modes: usize,
    pub outputs: usize,
    pub loads: usize,
    pub steps: usize,
    /// True where pairs of modes count.
    pub pairs: bool,
}

impl Lengths {
    /// Modes with padding.
    pub const fn padded(&self) -> usize {
        self.modes.next_multiple_of(LANES)
    }

    /// Steps between two checkpoints, `√N`.
    pub fn segment(&self) -> usize {
        (libm::ceil(libm::sqrt(self.steps as f64)) as usize).max(1)
    }

    const fn pair_numbers(&self) -> usize {
        if self.pairs { STEP * self.modes * self.modes + 2 * self.modes } else { 0 }
    }

    /// Numbers of memory.
    pub fn memory(&self) -> usize {
        let rows = 2 * (self.outputs + self.loads);
        let states = self.steps.div_ceil(self.segment()).saturating_add(self.segment());
        let all = 2 * STEP + rows + 2 * states.saturating_add(5);
        self.padded().saturating_mul(all).saturating_add(self.pair_numbers())
    }
}

/// A march of modes and its sums, in lent memory. Its arrays of modes are in blocks.
#[derive(Debug)]
pub(crate) struct ModalMarch<'m> {
    pub lengths: Lengths,
    fields: &'m [Field],
    /// `E` of each mode.
    steps: &'m mut [f64],
    /// `G` of each mode.
    sums: &'m mut [f64],
    /// Rows of outputs and loads over the modes, and `ĉ` and `b̂`.
    outputs: &'m mut [f64],
    loads: &'m mut [f64],
    of_outputs: &'m mut [f64],
    of_loads: &'m mut [f64],
    /// `G` of pairs, and the modes near each.
    pairs: &'m mut [f64],
    near: &'m mut [f64],
    checkpoints: &'m mut [f64],
    segment: &'m mut [f64],
    state: &'m mut [f64],
    /// Loads along the modes at both ends of a step, and their cotangents.
    force: &'m mut [f64],
    of_force: &'m mut [f64],
    lambda: &'m mut [f64],
    next: &'m mut [f64],
    /// True once a march is kept.
    kept: bool,
    /// True after a march back over it.
    gone_back: bool,
}

impl<'m> ModalMarch<'m> {
    /// A march that has not begun; rows and steps are zeros.
    pub fn new(
        lengths: Lengths,
        fields: &'m [Field],
        lender: &mut Lender<&'m mut [f64]>,
    ) -> Result<Self, Short> {
        let Lengths { modes, outputs, loads, steps, .. } = lengths;
        let m = lengths.padded();
        let mut take = |n: usize| {
            let piece = lender.take(n)?;
            piece.fill(0.0);
            Ok(piece)
        };
        let pairs = lengths.pair_numbers();
        Ok(Self {
            lengths,
            fields,
            steps: take(STEP * m)?,
            sums: take(STEP * m)?,
            outputs: take(outputs * m)?,
            loads: take(loads * m)?,
            of_outputs: take(outputs * m)?,
            of_loads: take(loads * m)?,
            pairs: take(pairs.saturating_sub(2 * modes))?,
            near: take(if lengths.pairs { 2 * modes } else { 0 })?,
            checkpoints: take(2 * m * steps.div_ceil(lengths.segment()))?,
            segment: take(2 * m * lengths.segment())?,
            state: take(2 * m)?,
            force: take(2 * m)?,
            of_force: take(2 * m)?,
            lambda: take(2 * m)?,
            next: take(2 * m)?,
            kept: false,
            gone_back: false,
        })
    }

    /// Sets the step of a mode: two rows of four.
    pub fn set_step(&mut self, mode: usize, step: &[[f64; 4]; 2]) {
        for (place, value) in step.as_flattened().iter().enumerate() {
            set(self.steps, in_blocks(mode, place, STEP), *value);
        }
    }

    /// Rows of the outputs and of the loads over the modes, each padded.
    pub fn rows_mut(&mut self) -> [&mut [f64]; 2] {
        [self.outputs, self.loads]
    }

    /// Sets the modes that are near each, of ascending eigenvalues: those that differ by less than this
    /// share.
    pub fn find_near(&mut self, eigenvalues: &[f64], share: f64) {
        for (i, (&own, bounds)) in eigenvalues.iter().zip(self.near.as_chunks_mut::<2>().0).enumerate() {
            let is_near = |other: &&f64| (*other - own).abs() <= share * own.max(**other);
            let below = eigenvalues.iter().take(i).rev().take_while(is_near).count();
            let above = eigenvalues.iter().skip(i + 1).take_while(is_near).count();
            *bounds = [(i - below) as f64, (i + above + 1) as f64];
        }
    }

    /// True of two modes whose sums are kept as those of a pair.
    pub fn is_near(&self, i: usize, j: usize) -> bool {
        let bounds = self.near.as_chunks::<2>().0.get(i);
        bounds.is_some_and(|&[first, end]| (first..end).contains(&(j as f64)))
    }

    /// Refuses gradients before a march back over the march that was taken last.
    pub fn check_gone_back(&self) -> Result<(), AdjointError> {
        if self.gone_back { Ok(()) } else { Err(AdjointError::NoMarch) }
    }

    /// Sums `G` of a mode.
    pub fn sums(&self, mode: usize) -> [[f64; 4]; 2] {
        let number = |place| at(self.sums, in_blocks(mode, place, STEP));
        core::array::from_fn(|a| core::array::from_fn(|b| number(4 * a + b)))
    }

    /// Sums `G` of a pair of modes that are near each other.
    pub fn pair(&self, i: usize, j: usize) -> [[f64; 4]; 2] {
        let own = row(self.pairs, i * self.lengths.modes + j, STEP);
        core::array::from_fn(|a| core::array::from_fn(|b| at(own, 4 * a + b)))
    }

    /// `Σ_l b̂_i b_j` over the loads.
    pub fn load_sum(&self, i: usize, j: usize) -> f64 {
        self.over(self.of_loads, i, self.loads, j)
    }

    /// Derivative with a turn of mode `j` towards mode `i`: `Σ_o c_i ĉ_j + Σ_l b_i b̂_j − λ_i·y_j` at the
    /// start.
    pub fn turn_sum(&self, i: usize, j: usize) -> f64 {
        let outputs = self.over(self.outputs, i, self.of_outputs, j);
        let start = self.checkpoints.get(..self.state.len()).unwrap_or_default();
        let held: f64 =
            (0..2).map(|a| at(self.lambda, in_blocks(i, a, 2)) * at(start, in_blocks(j, a, 2))).sum();
        outputs + self.over(self.loads, i, self.of_loads, j) - held
    }

    fn over(&self, a: &[f64], i: usize, b: &[f64], j: usize) -> f64 {
        let m = self.lengths.padded().max(1);
        a.chunks_exact(m).zip(b.chunks_exact(m)).map(|(a, b)| at(a, i) * at(b, j)).sum()
    }

    /// `b̂` of a load and a mode.
    pub fn of_load(&self, load: usize, mode: usize) -> f64 {
        at(row(self.of_loads, load, self.lengths.padded()), mode)
    }

    /// Gradient with respect to `(q, q̇)` of a mode at the start.
    pub fn of_start(&self, mode: usize) -> [f64; 2] {
        [0, 1].map(|a| at(self.lambda, in_blocks(mode, a, 2)))
    }

    fn check(&self, loads: &[f64], outputs: &[f64]) -> Result<(), AdjointError> {
        let Lengths { steps, outputs: of_outputs, loads: of_loads, .. } = self.lengths;
        for (found, needed) in [(loads.len(), 2 * steps * of_loads), (outputs.len(), steps * of_outputs)] {
            if found != needed {
                return Err(AdjointError::Length { found, needed });
            }
        }
        Ok(())
    }

    /// Takes all steps from a start, with the amplitudes of the loads at the start and at the end of each,
    /// and writes the outputs after each.
    pub fn march(
        &mut self,
        start: impl Fn(usize) -> [f64; 2],
        loads: &[f64],
        outputs: &mut [f64],
    ) -> Result<(), AdjointError> {
        self.check(loads, outputs)?;
        (self.kept, self.gone_back) = (false, false);
        self.state.fill(0.0);
        for mode in 0..self.lengths.modes {
            for (a, value) in start(mode).into_iter().enumerate() {
                set(self.state, in_blocks(mode, a, 2), value);
            }
        }
        vectorised(Forwards { march: self, loads, outputs });
        self.kept = self.state.iter().all(|x| x.is_finite());
        if self.kept { Ok(()) } else { Err(AdjointError::NotFinite) }
    }

    /// Goes back over all steps with the cotangents of the outputs after each, and takes the sums. `of_loads`
    /// gets the gradient with respect to the amplitudes, as long as these, or has no numbers.
    pub fn back(
        &mut self,
        loads: &[f64],
        cotangents: &[f64],
        of_loads: &mut [f64],
    ) -> Result<(), AdjointError> {
        self.check(loads, cotangents)?;
        let (found, needed) = (of_loads.len(), loads.len());
        if found != needed && found != 0 {
            return Err(AdjointError::Length { found, needed });
        }
        if !self.kept {
            return Err(AdjointError::NoMarch);
        }
        self.gone_back = false;
        for sums in
            [&mut *self.sums, self.of_outputs, self.of_loads, self.pairs, self.lambda].map(|sums| &mut *sums)
        {
            sums.fill(0.0);
        }
        let (each, steps) = (self.lengths.segment(), self.lengths.steps);
        let mut last = steps;
        copy(self.state, self.next);
        while last > 0 {
            let first = (last - 1) / each * each;
            vectorised(Segment { march: self, loads, cotangents, of_loads, first, last });
            last = first;
        }
        self.gone_back = self.lambda.iter().chain(&*self.sums).all(|x| x.is_finite());
        if self.gone_back { Ok(()) } else { Err(AdjointError::NotFinite) }
    }

    /// Adds the cotangents of the outputs to `λ`, and takes `ĉ` with the state after the step: a place in the
    /// segment, or the state after it.
    #[inline(always)]
    fn take_outputs(&mut self, cotangents: &[f64], place: Option<usize>) {
        let m = self.lengths.padded().max(1);
        let after = place.map_or(&*self.next, |place| row(self.segment, place, 2 * m));
        let rows = self.outputs.chunks_exact(m).zip(self.of_outputs.chunks_exact_mut(m));
        for ((&own, field), (row, sums)) in cotangents.iter().zip(self.fields).zip(rows) {
            let part = part_of(*field);
            let blocks = row.as_chunks::<LANES>().0.iter().zip(sums.as_chunks_mut::<LANES>().0);
            for ((row, sums), (lambda, after)) in
                blocks.zip(pairs_mut(self.lambda).iter_mut().zip(pairs(after)))
            {
                for k in 0..LANES {
                    lambda[part][k] += own * row[k];
                    sums[k] += own * after[part][k];
                }
            }
        }
    }

    /// Gradient with respect to the amplitudes of a step, and `b̂`.
    #[inline(always)]
    fn take_loads(&mut self, amplitudes: &[f64], out: &mut [f64]) {
        let (m, n) = (self.lengths.padded().max(1), self.lengths.loads);
        let rows = self.loads.chunks_exact(m).zip(self.of_loads.chunks_exact_mut(m));
        for (l, (row, sums)) in rows.enumerate() {
            let (start, end) = (at(amplitudes, l), at(amplitudes, n + l));
            let mut gradient = [[0.0; LANES]; 2];
            let blocks = row.as_chunks::<LANES>().0.iter().zip(sums.as_chunks_mut::<LANES>().0);
            for ((row, sums), own) in blocks.zip(pairs(self.of_force)) {
                for k in 0..LANES {
                    sums[k] += start * own[0][k] + end * own[1][k];
                    gradient[0][k] += row[k] * own[0][k];
                    gradient[1][k] += row[k] * own[1][k];
                }
            }
            let [at_start, at_end] = gradient.map(|lanes| lanes.iter().sum::<f64>());
            set(out, l, at_start);
            set(out, n + l, at_end);
        }
    }

    /// `G` of the pairs of modes that are near each other.
    fn sum_pairs(&mut self, place: usize) {
        let (m, width) = (self.lengths.modes, 2 * self.lengths.padded());
        let state = row(self.segment, place, width);
        for (i, &[first, end]) in self.near.as_chunks::<2>().0.iter().enumerate() {
            let (first, end) = (first as usize, end as usize);
            if end <= first + 1 {
                continue;
            }
            let own = [0, 1].map(|a| at(self.lambda, in_blocks(i, a, 2)));
            for j in (first..end).filter(|&j| j != i) {
                let pushed = [state, state, self.force, self.force].into_iter().zip([0, 1, 0, 1]);
                let sums = row_mut(self.pairs, i * m + j, STEP);
                for (b, (numbers, part)) in pushed.enumerate() {
                    let value = at(numbers, in_blocks(j, part, 2));
                    for (a, own) in own.iter().enumerate() {
                        if let Some(sum) = sums.get_mut(4 * a + b) {
                            *sum += own * value;
                        }
                    }
                }
            }
        }
    }
}

/// All steps of a march.
struct Forwards<'a, 'm> {
    march: &'a mut ModalMarch<'m>,
    loads: &'a [f64],
    outputs: &'a mut [f64],
}

impl Kernel for Forwards<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { march, loads, outputs } = self;
        let (width, each) = (march.lengths.outputs, march.lengths.segment());
        let (m, amplitudes) = (march.lengths.padded(), 2 * march.lengths.loads);
        for step in 0..march.lengths.steps {
            if step % each == 0 {
                copy(march.state, row_mut(march.checkpoints, step / each, 2 * m));
            }
            forces(march.loads, row(loads, step, amplitudes), march.force);
            let (steps, state, force) = (&*march.steps, &*march.state, &*march.force);
            Advance { steps, state, force, out: march.next }.run();
            core::mem::swap(&mut march.state, &mut march.next);
            let rows = march.outputs.chunks_exact(m.max(1)).zip(march.fields);
            for (out, (row, field)) in row_mut(outputs, step, width).iter_mut().zip(rows) {
                *out = along(row, march.state, *field);
            }
        }
    }
}

/// Steps of a march between two checkpoints, there and back.
struct Segment<'a, 'm> {
    march: &'a mut ModalMarch<'m>,
    loads: &'a [f64],
    cotangents: &'a [f64],
    of_loads: &'a mut [f64],
    first: usize,
    last: usize,
}

impl Kernel for Segment<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { march, loads, cotangents, of_loads, first, last } = self;
        let (width, amplitudes) = (2 * march.lengths.padded(), 2 * march.lengths.loads);
        let start = row(march.checkpoints, first / march.lengths.segment(), width);
        copy(start, row_mut(march.segment, 0, width));
        for place in 1..last - first {
            let (before, after) = march.segment.split_at_mut((place * width).min(march.segment.len()));
            forces(march.loads, row(loads, first + place - 1, amplitudes), march.force);
            let state = row(before, place - 1, width);
            let out = after.get_mut(..width).unwrap_or_default();
            Advance { steps: march.steps, state, force: march.force, out }.run();
        }
        for place in (0..last - first).rev() {
            let step = first + place;
            // The state after the last step of a segment is the first of the next, which is kept.
            let after = if step + 1 == last { None } else { Some(place + 1) };
            march.take_outputs(row(cotangents, step, march.lengths.outputs), after);
            let now = row(loads, step, amplitudes);
            forces(march.loads, now, march.force);
            march.sum_pairs(place);
            let (lambda, sums, of_force) = (&mut *march.lambda, &mut *march.sums, &mut *march.of_force);
            let state = row(march.segment, place, width);
            Back { steps: march.steps, state, force: march.force, lambda, sums, of_force }.run();
            march.take_loads(now, row_mut(of_loads, step, amplitudes));
        }
        copy(row(march.segment, 0, width), march.next);
    }
}
