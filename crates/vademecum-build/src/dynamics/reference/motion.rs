//! Modes moved exactly in time under loads that are linear between their jumps and kinks.

use std::sync::Arc;

use faer::Mat;
use vademecum_format::exact::Propagator;

use super::coupled::{CoupledModes, CoupledStep, ModalState};
use crate::dynamics::{History, INSTANTS, Span, Window};

/// Modes that dashpots couple, and a whole step of them.
pub(super) struct Coupling<'a> {
    pub modes: CoupledModes<'a>,
    pub whole: Arc<CoupledStep>,
}

/// Coupled modes on their way.
struct Together<'a> {
    coupling: Coupling<'a>,
    state: ModalState,
    /// The step of the length of a part that was made last.
    part: Option<CoupledStep>,
}

/// Modes on their way from rest, instant by instant.
pub(super) struct Motion<'a> {
    modes: &'a [[f64; 2]],
    /// Share of each mode in each load, shape (modes, loads).
    shares: Mat<f64>,
    window: Window,
    time_step: f64,
    whole: Vec<Propagator>,
    /// Length of the part of a step that was last taken \[s\], and the propagators over it.
    part: (f64, Vec<Propagator>),
    /// `(q, Δt q̇)` of each mode.
    state: Vec<[f64; 2]>,
    /// Force on each mode at both ends of a piece of time.
    force: Vec<[f64; 2]>,
    /// Of modes that are moved together.
    together: Option<Together<'a>>,
    /// Instant of the state.
    instant: usize,
    /// True if the state has been shown.
    shown: bool,
}

impl<'a> Motion<'a> {
    /// Modes of stiffness and decay `modes` at rest, coupled or each by itself; `loads` says how each column
    /// of `shares` follows time.
    pub(crate) fn new(
        modes: &'a [[f64; 2]],
        coupling: Option<Coupling<'a>>,
        shares: Mat<f64>,
        loads: Vec<History>,
        time_step: f64,
    ) -> Motion<'a> {
        // A part of a step has two instants, its ends.
        let instants: [f64; INSTANTS] = std::array::from_fn(|j| if j == 1 { 1.0 } else { 0.0 });
        let window = Window::new(loads, instants, time_step);
        let alone = if coupling.is_some() { &[] } else { modes };
        let whole = alone.iter().map(|&[lambda, sigma]| Propagator::new(lambda, sigma, time_step)).collect();
        let rest = vec![0.0; modes.len()];
        let state = ModalState { displacement: rest.clone(), velocity: rest };
        let together = coupling.map(|coupling| Together { coupling, state, part: None });
        let zero = vec![[0.0; 2]; modes.len()];
        Motion {
            modes,
            shares,
            window,
            time_step,
            whole,
            part: (0.0, vec![]),
            state: zero.clone(),
            force: zero,
            together,
            instant: 0,
            shown: false,
        }
    }

    /// Displacements of the modes at the next `count` instants, the start first; shape (modes, count).
    pub(crate) fn next(&mut self, count: usize) -> Mat<f64> {
        let mut shown = Mat::zeros(self.modes.len(), count);
        for c in 0..count {
            if self.shown {
                self.step();
            }
            self.shown = true;
            shown.col_as_slice_mut(c).iter_mut().zip(&self.state).for_each(|(q, state)| *q = state[0]);
        }
        shown
    }

    /// Energy at the next instant, the start first.
    pub(crate) fn next_energy(&mut self) -> f64 {
        if self.shown {
            self.step();
        }
        self.shown = true;
        let of_mode = |([q, v], [lambda, _]): (&[f64; 2], &[f64; 2])| {
            let rate = v / self.time_step;
            0.5 * (rate * rate + lambda * q * q)
        };
        self.state.iter().zip(self.modes).map(of_mode).sum()
    }

    /// To the next instant, part by part.
    fn step(&mut self) {
        for span in self.window.spans(self.instant) {
            if self.together.is_none() && !span.whole && self.part.0 != span.length {
                let part = |&[lambda, sigma]: &[f64; 2]| Propagator::new(lambda, sigma, span.length);
                self.part = (span.length, self.modes.iter().map(part).collect());
            }
            (0..span.parts).for_each(|part| self.take(&span, part));
        }
        self.instant += 1;
    }

    /// Moves all modes over a part of a step; every load is linear in it.
    fn take(&mut self, span: &Span, part: usize) {
        self.force.fill([0.0; 2]);
        for (load, factors) in self.window.over(span, part) {
            let shares = self.shares.col(load);
            for (force, share) in self.force.iter_mut().zip(shares.iter()) {
                force[0] += share * factors[0];
                force[1] += share * factors[1];
            }
        }
        if let Some(together) = &mut self.together {
            together.take(span, &self.force);
            let state = &together.state;
            let moved = state.displacement.iter().zip(&state.velocity);
            self.state.iter_mut().zip(moved).for_each(|(state, (q, v))| *state = [*q, v * self.time_step]);
            return;
        }
        let modes = self.state.iter_mut().zip(&self.force);
        if span.whole {
            modes.zip(&self.whole).for_each(|((state, force), p)| *state = moved(p, *state, *force));
            return;
        }
        // The velocity is scaled by the length of what is stepped.
        let scale = span.length / self.time_step;
        for ((state, force), p) in modes.zip(&self.part.1) {
            let [q, v] = moved(p, [state[0], state[1] * scale], *force);
            *state = [q, v / scale];
        }
    }
}

impl Together<'_> {
    /// Moves all modes over a part of a step.
    fn take(&mut self, span: &Span, force: &[[f64; 2]]) {
        let [before, after] = [0, 1].map(|end| force.iter().map(|force| force[end]).collect::<Vec<f64>>());
        let (modes, force) = (&self.coupling.modes, [&before[..], &after[..]]);
        if span.whole {
            return self.coupling.whole.take(modes, &mut self.state, force);
        }
        let known = self.part.as_ref().is_some_and(|step| step.length() == span.length);
        if !known && modes.wants_step(span.length, span.parts) {
            self.part = Some(modes.step(span.length));
        }
        match self.part.as_ref().filter(|step| step.length() == span.length) {
            Some(step) => step.take(modes, &mut self.state, force),
            None => modes.moved(&mut self.state, force, span.length),
        }
    }
}

/// One mode over one piece, its force rising from `before` to `after`.
fn moved(p: &Propagator, [q, v]: [f64; 2], [before, after]: [f64; 2]) -> [f64; 2] {
    let rise = after - before;
    [
        q + (p.d[0] * q + p.d[1] * v + p.held[0] * before + p.rising[0] * rise),
        v + (p.d[2] * q + p.d[3] * v + p.held[1] * before + p.rising[1] * rise),
    ]
}
