//! Which loads act in a step, without looking at all of them (there may be a contact for every step, as a
//! recorded finger has), and the parts of a step over which all of them are linear in time.

use std::collections::{BTreeMap, BTreeSet};

use super::history::History;
use super::interval::Interval;
use super::march::INSTANTS;

/// One part in 1e9 of the time decides whether a load acts at an instant; loads this much before their start
/// and after their end are looked at, too.
const MARGIN: f64 = 1e-6;

/// Loads that act, by number, with their factors at the instants of a step or at the ends of a part of it.
pub(crate) type Acting = Vec<(usize, [f64; INSTANTS])>;

/// The loads that are looked at, as a march goes on.
pub struct Window {
    /// Time function of each load.
    loads: Vec<History>,
    instants: [f64; INSTANTS],
    time_step: f64,
    /// Loads whose start is yet to come; the next one last.
    waiting: Vec<usize>,
    /// Loads whose end is yet to come, in the order of the track, which is the order of their sum.
    active: BTreeSet<usize>,
}

/// A piece of a step in which no load jumps or has a kink.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Its ends \[s\].
    pub ends: [f64; 2],
    /// Equal parts over which every load is taken as linear in time.
    pub parts: usize,
    /// Length of a part \[s\]: of a whole step that is one part, the step to its last digit.
    pub length: f64,
    /// True if it is a whole step and one part.
    pub whole: bool,
}

impl Window {
    /// The start of a march under loads that act then.
    pub fn new(loads: Vec<History>, instants: [f64; INSTANTS], time_step: f64) -> Self {
        let mut waiting: Vec<usize> = (0..loads.len()).collect();
        waiting.sort_by(|&a, &b| loads[b].start().total_cmp(&loads[a].start()));
        Self { loads, instants, time_step, waiting, active: BTreeSet::new() }
    }

    /// Loads that act in a step, by number, and their factors at its instants.
    /// Steps are asked for in order.
    pub fn acting(&mut self, step: usize) -> Acting {
        self.look_at(step);
        let factors = |&index: &usize| {
            let factor = |c: f64| self.loads[index].factor((step as f64 + c) * self.time_step);
            (index, self.instants.map(factor))
        };
        self.active.iter().map(factors).filter(acts).collect()
    }

    /// Loads that act in a step that takes every load as linear, with their factors right after its start and
    /// right before its end: a jump between two steps is in neither. Steps are asked for in order.
    pub fn between_ends(&mut self, step: usize) -> Acting {
        let ends = [step as f64 * self.time_step, (step + 1) as f64 * self.time_step];
        self.look_at(step);
        self.over(&Span { ends, parts: 1, length: self.time_step, whole: true }, 0)
    }

    /// Looks for the loads of a step.
    fn look_at(&mut self, step: usize) {
        let Self { ref loads, instants, time_step, .. } = *self;
        let time = |c: f64| (step as f64 + c) * time_step;
        let first = time(instants.into_iter().fold(f64::INFINITY, f64::min)) * (1.0 - MARGIN);
        let last = time(instants.into_iter().fold(0.0, f64::max)) * (1.0 + MARGIN);
        while let Some(&index) = self.waiting.last().filter(|&&index| loads[index].start() <= last) {
            self.waiting.pop();
            self.active.insert(index);
        }
        self.active.retain(|&index| loads[index].end() > first);
    }

    /// A step in pieces without jumps and kinks, each in as many parts as its loads need to be linear in
    /// time. Steps are asked for in order, and have instants up to their ends.
    pub fn spans(&mut self, step: usize) -> Vec<Span> {
        self.look_at(step);
        let step_ends = [step as f64 * self.time_step, (step + 1) as f64 * self.time_step];
        let mut breaks = vec![];
        self.active.iter().for_each(|&index| self.loads[index].breaks_within(step_ends, &mut breaks));
        breaks.sort_by(f64::total_cmp);
        breaks.push(step_ends[1]);
        let mut start = step_ends[0];
        let mut spans = vec![];
        for end in breaks {
            if start > step_ends[0] && !Interval::is_inside(start, [step_ends[0], end]) {
                continue;
            }
            let ends = [start, end];
            let parts = self.active.iter().map(|&index| self.loads[index].parts(ends)).max().unwrap_or(1);
            let all = ends == step_ends;
            let length = if all { self.time_step } else { end - start };
            spans.push(Span { ends, parts, length: length / parts as f64, whole: all && parts == 1 });
            start = end;
        }
        spans
    }

    /// Loads that act in a part of a span of the step last asked for, with their factors right after its
    /// start and right before its end.
    pub fn over(&self, span: &Span, part: usize) -> Acting {
        let [start, end] = span.ends;
        let instant = |part: usize| match part {
            0 => start,
            part if part == span.parts => end,
            part => start + (end - start) * (part as f64 / span.parts as f64),
        };
        let (from, to) = (instant(part), instant(part + 1));
        let factors = |&index: &usize| {
            let mut factors = [0.0; INSTANTS];
            (factors[0], factors[1]) =
                (self.loads[index].just_after(from), self.loads[index].just_before(to));
            (index, factors)
        };
        self.active.iter().map(factors).filter(acts).collect()
    }

    /// Loads that act in a step, each with the mean of its factor over the step at all instants: the impulse
    /// of a load that is held with it is that of the load itself, wherever it starts and ends.
    pub fn means(&mut self, step: usize) -> Acting {
        let mut means = BTreeMap::new();
        for span in self.spans(step) {
            for part in 0..span.parts {
                for (index, factors) in self.over(&span, part) {
                    let share = span.length / self.time_step;
                    *means.entry(index).or_insert(0.0) += 0.5 * share * (factors[0] + factors[1]);
                }
            }
        }
        means.into_iter().map(|(index, mean)| (index, [mean; INSTANTS])).filter(acts).collect()
    }
}

fn acts((_, factors): &(usize, [f64; INSTANTS])) -> bool {
    factors.iter().any(|&f| f != 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::{Course, Wave};

    #[test]
    fn a_step_is_split_where_a_load_jumps_or_bends() {
        let of = |start, end, ramp| History::from(Interval { start, end, ramp });
        let loads = vec![of(0.25, 1.0, 0.5), of(0.0, 0.75, 0.0), of(0.5, 2.0, 0.0)];
        let mut window = Window::new(loads, [0.0, 1.0, 0.0, 0.0], 0.5);
        let at = |index: usize, start: f64, end: f64| (index, [start, end, 0.0, 0.0]);
        let mut pieces = |step: usize| -> Vec<(f64, Acting)> {
            let spans = window.spans(step);
            spans.iter().map(|span| (span.length, window.over(span, 0))).collect()
        };
        // Starts in the middle of the first step; the second load ends where the first has come to full
        // height.
        assert_eq!(
            pieces(0),
            [(0.25, vec![at(1, 1.0, 1.0)]), (0.25, vec![at(0, 0.0, 0.5), at(1, 1.0, 1.0)])]
        );
        let before = (0.25, vec![at(0, 0.5, 1.0), at(1, 1.0, 1.0), at(2, 1.0, 1.0)]);
        assert_eq!(pieces(1), [before, (0.25, vec![at(0, 1.0, 1.0), at(2, 1.0, 1.0)])]);
        assert_eq!(pieces(2), [(0.5, vec![at(2, 1.0, 1.0)])]);
    }

    #[test]
    fn a_step_that_takes_its_ends_sees_no_jump_between_two_steps() {
        let load = History::from(Interval { start: 0.5, end: 1.0, ramp: 0.0 });
        let mut window = Window::new(vec![load], [0.0, 1.0, 0.0, 0.0], 0.5);
        let steps = [0, 1, 2].map(|step| window.between_ends(step));
        assert_eq!(steps, [vec![], vec![(0, [1.0, 1.0, 0.0, 0.0])], vec![]]);
    }

    #[test]
    fn parts_of_a_sinusoid_join_without_gaps_and_nothing_is_kept_of_them() {
        let during = Interval { start: 0.0, end: 1e6, ramp: 0.0 };
        let load = History { during, share: None, course: Course::Wave(Wave::sinusoid(2.0, 0.0, 0.0)) };
        let mut window = Window::new(vec![load.clone()], [0.0, 1.0, 0.0, 0.0], 0.1);
        let mut last = 0.0;
        for step in 0..7 {
            let spans = window.spans(step);
            let [span] = spans[..] else { panic!("one span") };
            // 2222 chords a period.
            assert_eq!((span.parts, span.whole), (445, false));
            assert_eq!(span.length, 0.1 / 445.0);
            for part in 0..span.parts {
                let acting = window.over(&span, part);
                let (from, to) = acting.first().map_or((0.0, 0.0), |(_, f)| (f[0], f[1]));
                assert!((from - last).abs() < 1e-14, "step {step}, part {part}: {from} after {last}");
                last = to;
            }
        }
        assert!((last - load.just_before(0.7)).abs() < 1e-14);
    }

    #[test]
    fn the_loads_found_are_those_of_the_whole_track() {
        let dt = 1e-3;
        let of = |start, end, ramp| History::from(Interval { start, end, ramp });
        // One for every step; ends and starts on steps, between them and at stages; one that never ends.
        let mut loads: Vec<History> =
            (0..200).map(|i| of(f64::from(i) * dt, (f64::from(i) + 1.0) * dt, 0.0)).collect();
        loads.extend([of(0.1505, 0.151, 0.0), of(0.0, f64::MAX, 0.05), of(0.0302, 0.0304, 0.0)]);
        loads.extend([of(0.1, 0.2, 1e-4), of(0.05, 0.050_000_1, 0.0)]);
        let mut instants = [0.0; INSTANTS];
        (instants[1], instants[2]) = (0.5, 1.0);
        let mut window = Window::new(loads.clone(), instants, dt);
        for step in 0..250 {
            let factors = |when: &History| instants.map(|c| when.factor((step as f64 + c) * dt));
            let all = loads.iter().map(factors).enumerate();
            let expected: Vec<_> = all.filter(|(_, f)| f.iter().any(|&f| f != 0.0)).collect();
            assert_eq!(window.acting(step), expected, "step {step}");
            assert!(window.active.len() < 10, "step {step} looks at {} loads", window.active.len());
        }
    }
}
