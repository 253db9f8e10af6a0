//! Modes moved exactly in time under loads that are linear between their jumps and kinks.

use faer::Mat;
use vademecum_format::exact::Propagator;

use crate::dynamics::Interval;

/// Part of a time that decides ties, as in [`Interval::factor`].
const TIE: f64 = 1e-9;

/// A load over time in steps: 0 up to `start`, then rising to 1 at `top`, then 1, and 0 from `end` on.
#[derive(Clone, Copy, Debug)]
struct Profile {
    start: f64,
    top: f64,
    end: f64,
}

impl Profile {
    fn new(when: &Interval, time_step: f64) -> Profile {
        let [start, top, end] =
            [when.start, when.start + when.ramp, when.end].map(|t| snapped(t / time_step));
        Profile { start, top, end }
    }

    /// Values at both ends of a piece of time in which nothing jumps and nothing has a kink.
    fn over(&self, from: f64, to: f64) -> [f64; 2] {
        let middle = 0.5 * (from + to);
        if middle < self.start || middle >= self.end {
            return [0.0; 2];
        }
        if middle >= self.top {
            return [1.0; 2];
        }
        [from, to].map(|t| ((t - self.start) / (self.top - self.start)).clamp(0.0, 1.0))
    }
}

/// A time in steps, on the instant beside it if only rounding lies between.
fn snapped(time: f64) -> f64 {
    let instant = time.round();
    if (time - instant).abs() <= TIE * time.abs() { instant } else { time }
}

/// Modes on their way from rest, instant by instant.
pub(super) struct Motion<'a> {
    modes: &'a [[f64; 2]],
    /// Share of each mode in each load, shape (modes, loads).
    shares: Mat<f64>,
    profiles: Vec<Profile>,
    /// Instants at which some load jumps or has a kink, in steps, ascending.
    kinks: Vec<f64>,
    time_step: f64,
    whole: Vec<Propagator>,
    /// `(q, Δt q̇)` of each mode.
    state: Vec<[f64; 2]>,
    /// Force on each mode at both ends of a piece of time.
    force: Vec<[f64; 2]>,
    /// Instant of the state.
    instant: usize,
    /// Kinks behind the state.
    behind: usize,
    /// Whether the state has been shown.
    shown: bool,
}

impl<'a> Motion<'a> {
    /// Modes of stiffness and decay `modes` at rest; `loads` says when each column of `shares` acts.
    pub fn new(modes: &'a [[f64; 2]], shares: Mat<f64>, loads: &[Interval], time_step: f64) -> Motion<'a> {
        let profiles: Vec<Profile> = loads.iter().map(|when| Profile::new(when, time_step)).collect();
        let mut kinks: Vec<f64> = profiles.iter().flat_map(|p| [p.start, p.top, p.end]).collect();
        kinks.retain(|t| t.is_finite() && *t > 0.0);
        kinks.sort_by(f64::total_cmp);
        kinks.dedup();
        let whole = modes.iter().map(|&[lambda, sigma]| Propagator::new(lambda, sigma, time_step)).collect();
        let zero = vec![[0.0; 2]; modes.len()];
        Motion {
            modes,
            shares,
            profiles,
            kinks,
            time_step,
            whole,
            state: zero.clone(),
            force: zero,
            instant: 0,
            behind: 0,
            shown: false,
        }
    }

    /// Displacements of the modes at the next `count` instants, the start first; shape (modes, count).
    pub fn next(&mut self, count: usize) -> Mat<f64> {
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
    pub fn next_energy(&mut self) -> f64 {
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

    /// To the next instant, piece by piece.
    fn step(&mut self) {
        let (mut from, next) = (self.instant as f64, (self.instant + 1) as f64);
        while self.kinks.get(self.behind).is_some_and(|&kink| kink <= from) {
            self.behind += 1;
        }
        while let Some(&kink) = self.kinks.get(self.behind).filter(|&&kink| kink < next) {
            self.piece(from, kink);
            from = kink;
            self.behind += 1;
        }
        self.piece(from, next);
        self.instant += 1;
    }

    /// Moves all modes from one time to another, in steps; no load jumps or has a kink in between.
    fn piece(&mut self, from: f64, to: f64) {
        self.force.fill([0.0; 2]);
        for (load, profile) in self.profiles.iter().enumerate() {
            let ends = profile.over(from, to);
            if ends != [0.0; 2] {
                let shares = self.shares.col(load);
                for (force, share) in self.force.iter_mut().zip(shares.iter()) {
                    force[0] += share * ends[0];
                    force[1] += share * ends[1];
                }
            }
        }
        let length = to - from;
        for (k, state) in self.state.iter_mut().enumerate() {
            if length == 1.0 {
                *state = moved(&self.whole[k], *state, self.force[k]);
                continue;
            }
            let [lambda, sigma] = self.modes[k];
            let part = Propagator::new(lambda, sigma, length * self.time_step);
            // The velocity is scaled by the length of what is stepped.
            let [q, v] = moved(&part, [state[0], state[1] * length], self.force[k]);
            *state = [q, v / length];
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_that_rounding_parts_from_an_instant_are_on_it_and_others_are_not() {
        assert_eq!(snapped(0.3 / 0.1), 3.0);
        assert_eq!(snapped(7.0 * (1.0 + 5e-10)), 7.0);
        assert_ne!(snapped(7.0 * (1.0 + 5e-9)), 7.0);
        assert_eq!(snapped(f64::INFINITY), f64::INFINITY);
    }

    #[test]
    fn a_ramp_is_cut_by_the_end_and_a_jump_has_no_width() {
        let cut = Profile::new(&Interval { start: 1.0, end: 2.0, ramp: 4.0 }, 0.5);
        assert_eq!(cut.over(2.0, 4.0), [0.0, 0.25]);
        assert_eq!(cut.over(4.0, 5.0), [0.0, 0.0]);
        let jump = Profile::new(&Interval { start: 1.0, end: f64::INFINITY, ramp: 0.0 }, 0.5);
        assert_eq!([jump.over(1.0, 2.0), jump.over(2.0, 3.0)], [[0.0; 2], [1.0; 2]]);
    }
}
