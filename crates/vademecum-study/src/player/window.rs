//! Which loads of a track act in a step, without looking at all of them: a track may have a contact for every
//! step, as a recorded finger has.

use std::collections::BTreeSet;

use vademecum_build::dynamics::{INSTANTS, Interval};

/// One part in 1e9 of the time decides whether a load acts at an instant; loads this much before their start
/// and after their end are looked at, too.
const MARGIN: f64 = 1e-6;

/// The loads that are looked at, as a march goes on.
pub(super) struct Window {
    /// When each load acts.
    intervals: Vec<Interval>,
    instants: [f64; INSTANTS],
    time_step: f64,
    /// Loads whose start is yet to come; the next one last.
    waiting: Vec<usize>,
    /// Loads whose end is yet to come, in the order of the track, which is the order of their sum.
    active: BTreeSet<usize>,
}

impl Window {
    /// The start of a march under loads that act then.
    pub fn new(intervals: Vec<Interval>, instants: [f64; INSTANTS], time_step: f64) -> Self {
        let mut waiting: Vec<usize> = (0..intervals.len()).collect();
        waiting.sort_by(|&a, &b| intervals[b].start.total_cmp(&intervals[a].start));
        Self { intervals, instants, time_step, waiting, active: BTreeSet::new() }
    }

    /// Loads that act in a step, by number, and their factors at its instants.
    /// Steps are asked for in order.
    pub fn acting(&mut self, step: usize) -> Vec<(usize, [f64; INSTANTS])> {
        let Self { ref intervals, instants, time_step, .. } = *self;
        let time = |c: f64| (step as f64 + c) * time_step;
        let first = time(instants.into_iter().fold(f64::INFINITY, f64::min)) * (1.0 - MARGIN);
        let last = time(instants.into_iter().fold(0.0, f64::max)) * (1.0 + MARGIN);
        while let Some(&index) = self.waiting.last().filter(|&&index| intervals[index].start <= last) {
            self.waiting.pop();
            self.active.insert(index);
        }
        self.active.retain(|&index| intervals[index].end > first);
        let factors = |&index: &usize| (index, instants.map(|c| intervals[index].factor(time(c))));
        let acts = |(_, factors): &(usize, [f64; INSTANTS])| factors.iter().any(|&f| f != 0.0);
        self.active.iter().map(factors).filter(acts).collect()
    }

    /// A step in pieces over which every load is linear in time: the length of each, and the factors of the
    /// loads at its start and at its end. Steps are asked for in order.
    pub fn pieces(&mut self, step: usize) -> Vec<Piece> {
        // Looks for the loads of this step.
        self.acting(step);
        let step_ends = [step as f64 * self.time_step, (step + 1) as f64 * self.time_step];
        let breaks = self.active.iter().flat_map(|&index| self.intervals[index].breaks());
        let mut ends: Vec<f64> = breaks.filter(|&t| Interval::is_inside(t, step_ends)).collect();
        ends.push(step_ends[1]);
        ends.sort_by(f64::total_cmp);
        let mut start = step_ends[0];
        let mut pieces = vec![];
        for end in ends {
            if start > step_ends[0] && !Interval::is_inside(start, [step_ends[0], end]) {
                continue;
            }
            let factors = |&index: &usize| {
                let when = &self.intervals[index];
                let mut factors = [0.0; INSTANTS];
                (factors[0], factors[1]) = (when.just_after(start), when.just_before(end));
                (index, factors)
            };
            let acts = |(_, factors): &(usize, [f64; INSTANTS])| factors.iter().any(|&f| f != 0.0);
            let acting = self.active.iter().map(factors).filter(acts).collect();
            pieces.push(Piece { length: end - start, acting });
            start = end;
        }
        pieces
    }
}

/// A part of a step over which every load is linear in time.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Piece {
    /// Its length \[s\].
    pub length: f64,
    /// Loads that act, by number, with their factors at its start and its end.
    pub acting: Vec<(usize, [f64; INSTANTS])>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_split_where_a_load_jumps_or_bends() {
        let of = |start, end, ramp| Interval { start, end, ramp };
        let intervals = vec![of(0.25, 1.0, 0.5), of(0.0, 0.75, 0.0), of(0.5, 2.0, 0.0)];
        let mut window = Window::new(intervals, [0.0, 1.0, 0.0, 0.0], 0.5);
        let at = |index: usize, start: f64, end: f64| (index, [start, end, 0.0, 0.0]);
        let piece = |length, acting: &[(usize, [f64; INSTANTS])]| Piece { length, acting: acting.to_vec() };
        // Starts in the middle of the first step; the second load ends where the first has come to full
        // height.
        assert_eq!(
            window.pieces(0),
            [piece(0.25, &[at(1, 1.0, 1.0)]), piece(0.25, &[at(0, 0.0, 0.5), at(1, 1.0, 1.0)])]
        );
        let before = piece(0.25, &[at(0, 0.5, 1.0), at(1, 1.0, 1.0), at(2, 1.0, 1.0)]);
        assert_eq!(window.pieces(1), [before, piece(0.25, &[at(0, 1.0, 1.0), at(2, 1.0, 1.0)])]);
        assert_eq!(window.pieces(2), [piece(0.5, &[at(2, 1.0, 1.0)])]);
    }

    #[test]
    fn the_loads_found_are_those_of_the_whole_track() {
        let dt = 1e-3;
        let of = |start, end, ramp| Interval { start, end, ramp };
        // One for every step; ends and starts on steps, between them and at stages; one that never ends.
        let mut intervals: Vec<Interval> =
            (0..200).map(|i| of(f64::from(i) * dt, (f64::from(i) + 1.0) * dt, 0.0)).collect();
        intervals.extend([of(0.1505, 0.151, 0.0), of(0.0, f64::MAX, 0.05), of(0.0302, 0.0304, 0.0)]);
        intervals.extend([of(0.1, 0.2, 1e-4), of(0.05, 0.050_000_1, 0.0)]);
        let mut instants = [0.0; INSTANTS];
        (instants[1], instants[2]) = (0.5, 1.0);
        let mut window = Window::new(intervals.clone(), instants, dt);
        for step in 0..250 {
            let factors = |when: &Interval| instants.map(|c| when.factor((step as f64 + c) * dt));
            let all = intervals.iter().map(factors).enumerate();
            let expected: Vec<_> = all.filter(|(_, f)| f.iter().any(|&f| f != 0.0)).collect();
            assert_eq!(window.acting(step), expected, "step {step}");
            assert!(window.active.len() < 10, "step {step} looks at {} loads", window.active.len());
        }
    }
}
