//! Time functions of loads: the one description that the march at full order, the reference that is exact in
//! time, the certificate and the player of scenarios share.
//!
//! A history is a product of three functions of time: when the load acts ([`Interval`]), the share that falls
//! to this place of a moving contact, and its course. Between its breaks a history is smooth. Where only one
//! of the three changes, and changes linearly, it is linear; elsewhere it is taken as linear over a number of
//! equal parts that the chord is nowhere farther from it than [`CHORD`] of the course's amplitude.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::interval::{Interval, TIE};

/// Largest distance of a load from the chords it is stepped with, as a part of its amplitude.
pub(crate) const CHORD: f64 = 1e-6;

/// Most parts of a piece of time, whatever the load: 29 periods of a sinusoid.
const MAX_PARTS: f64 = 65_536.0;

/// Time function of a load.
#[derive(Clone, Debug, PartialEq)]
pub struct History {
    /// When it acts.
    pub during: Interval,
    /// The share of a place on the path of a moving contact: it rises linearly from 0 at the first instant to
    /// 1 at the second and falls to 0 at the third. Where two of them are the same, the share is 1 on that
    /// side. None: always 1.
    pub share: Option<[f64; 3]>,
    /// The factor on the load while it acts.
    pub course: Course,
}

/// The factor on a load while it acts. Times count from the start of its interval.
#[derive(Clone, Debug, PartialEq)]
pub enum Course {
    /// 1.
    Held,
    /// A column of a table.
    Table(Arc<LoadTable>, usize),
    /// A sinusoid or a chirp.
    Wave(Wave),
}

/// Numbers over time: linear between rows, with a jump where two rows have one time, and 0 before the first
/// row and from the last on.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadTable {
    times: Vec<f64>,
    /// Row by row.
    values: Vec<f64>,
    columns: usize,
    /// Largest size of each column.
    largest: Vec<f64>,
}

/// `mean + sin(phase + 2π (f₀ t + ½ (f₁ − f₀) t²/sweep))`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// Frequency at the start, and after the time `sweep` \[Hz\]: of a sinusoid the same.
    pub frequency: [f64; 2],
    /// Time from one frequency to the other \[s\].
    pub sweep: f64,
    /// Phase at the start \[rad\].
    pub phase: f64,
    /// The constant term.
    pub mean: f64,
}

/// Bounds of a function on a piece of time: its size, its slope and its curvature.
struct Bounds {
    size: f64,
    slope: f64,
    curvature: f64,
}

impl From<Interval> for History {
    fn from(during: Interval) -> Self {
        Self { during, share: None, course: Course::Held }
    }
}

impl History {
    /// Factor on the load at time `t`. Ties at its ends are decided as by [`Interval::factor`].
    pub fn factor(&self, t: f64) -> f64 {
        self.during.factor(t) * self.inner(t, t * (1.0 + TIE))
    }

    /// Factor on the load right after `t`. Beside a jump or a kink, one part in 1e9 of the time decides as in
    /// [`Interval::factor`].
    pub fn just_after(&self, t: f64) -> f64 {
        self.beside(t, t * (1.0 + TIE))
    }

    /// Factor on the load right before `t`.
    pub fn just_before(&self, t: f64) -> f64 {
        self.beside(t, t * (1.0 - TIE))
    }

    fn beside(&self, t: f64, side: f64) -> f64 {
        self.during.beside(t, side) * self.inner(t, side)
    }

    /// Share and course at `t`, on the side of jumps and kinks where `side` lies.
    fn inner(&self, t: f64, side: f64) -> f64 {
        let start = self.during.start;
        let course = match &self.course {
            Course::Held => 1.0,
            Course::Table(table, column) => table.value(*column, t - start, side - start),
            Course::Wave(wave) => wave.value(t - start),
        };
        self.share.map_or(course, |share| course * share_at(share, t, side))
    }

    /// First instant at which the factor may differ from 0.
    pub fn start(&self) -> f64 {
        let start = self.during.start;
        match self.share {
            Some([from, top, _]) if from < top => start.max(from),
            _ => start,
        }
    }

    /// First instant from which on the factor is 0.
    pub fn end(&self) -> f64 {
        let end = self.during.end;
        let end = match &self.course {
            Course::Table(table, _) => end.min(self.during.start + table.end()),
            _ => end,
        };
        match self.share {
            Some([_, top, to]) if top < to => end.min(to),
            _ => end,
        }
    }

    /// Adds the instants inside of a piece of time at which the factor jumps or has a kink.
    pub(super) fn breaks_within(&self, piece: [f64; 2], breaks: &mut Vec<f64>) {
        breaks.extend(self.during.breaks().into_iter().filter(|&t| Interval::is_inside(t, piece)));
        let share = self.share.into_iter().flatten();
        breaks.extend(share.filter(|&t| Interval::is_inside(t, piece)));
        if let Course::Table(table, _) = &self.course {
            let start = self.during.start;
            let first = table.times.partition_point(|&t| start + t <= piece[0]);
            let rows = table.times[first..].iter().map(|t| start + t).take_while(|&t| t < piece[1]);
            breaks.extend(rows.filter(|&t| Interval::is_inside(t, piece)));
        }
    }

    /// Equal parts of a piece of time without breaks over which the factor may be taken as linear: the chords
    /// are within [`CHORD`] of the course's amplitude, or there are 65 536 parts.
    pub(super) fn parts(&self, [from, to]: [f64; 2]) -> usize {
        let middle = 0.5 * (from + to);
        let (Interval { start, end, ramp }, length) = (self.during, to - from);
        if middle < start || middle >= end {
            return 1;
        }
        let rise = if middle < start + ramp { 1.0 / ramp } else { 0.0 };
        let share = self.share.map_or(0.0, |share| share_slope(share, middle));
        let (course, amplitude) = match &self.course {
            Course::Held => (Bounds { size: 1.0, slope: 0.0, curvature: 0.0 }, 1.0),
            Course::Table(table, column) => (table.bounds(*column, middle - start), table.largest[*column]),
            Course::Wave(wave) => (wave.bounds([from - start, to - start]), 1.0),
        };
        // Of a product of functions, the first two of which are linear and at most 1.
        let Bounds { size, slope, curvature } = course;
        let curvature = curvature + 2.0 * (rise * share * size + (rise + share) * slope);
        if curvature <= 0.0 || amplitude <= 0.0 {
            return 1;
        }
        // A chord of length h is at most h²/8 of the curvature away.
        let parts = (length * (curvature / (8.0 * CHORD * amplitude)).sqrt()).ceil();
        parts.clamp(1.0, MAX_PARTS) as usize
    }
}

fn share_at([from, top, to]: [f64; 3], t: f64, side: f64) -> f64 {
    if side < top {
        if from < top { ((t - from) / (top - from)).clamp(0.0, 1.0) } else { 1.0 }
    } else if top < to {
        ((to - t) / (to - top)).clamp(0.0, 1.0)
    } else {
        1.0
    }
}

/// Size of the slope of a share at an instant that is none of its own.
fn share_slope([from, top, to]: [f64; 3], t: f64) -> f64 {
    if from < t && t < top {
        1.0 / (top - from)
    } else if top < t && t < to {
        1.0 / (to - top)
    } else {
        0.0
    }
}

impl LoadTable {
    /// A table from its times and its values, row by row. None unless there are two rows or more, all of the
    /// same number of finite values, at finite times that never fall and of which no three are the same.
    pub fn new(times: Vec<f64>, values: Vec<f64>) -> Option<Self> {
        let rows = times.len();
        if rows < 2 || values.is_empty() || !values.len().is_multiple_of(rows) {
            return None;
        }
        let finite = times.iter().chain(&values).all(|x| x.is_finite());
        let ascending = times.windows(2).all(|w| w[0] <= w[1]);
        if !finite || !ascending || times.windows(3).any(|w| w[0] == w[2]) {
            return None;
        }
        let columns = values.len() / rows;
        let column = |c: usize| values.iter().skip(c).step_by(columns).fold(0.0, |m: f64, x| m.max(x.abs()));
        let largest = (0..columns).map(column).collect();
        Some(Self { times, values, columns, largest })
    }

    /// Number of columns without the time.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Largest size of a number of a column.
    pub fn largest(&self, column: usize) -> f64 {
        self.largest[column]
    }

    /// Time of the last row.
    pub fn end(&self) -> f64 {
        self.times[self.times.len() - 1]
    }

    /// Time and value of each row of a column.
    pub fn rows(&self, column: usize) -> impl Iterator<Item = [f64; 2]> + '_ {
        let value = move |row: usize| self.values[row * self.columns + column];
        self.times.iter().enumerate().map(move |(row, &t)| [t, value(row)])
    }

    /// The rows around a time, if there is one on each side.
    fn around(&self, column: usize, side: f64) -> Option<[[f64; 2]; 2]> {
        let after = self.times.partition_point(|&t| t <= side);
        let row = |row: usize| [self.times[row], self.values[row * self.columns + column]];
        (after > 0 && after < self.times.len()).then(|| [row(after - 1), row(after)])
    }

    fn value(&self, column: usize, t: f64, side: f64) -> f64 {
        let Some([[t0, v0], [t1, v1]]) = self.around(column, side) else { return 0.0 };
        v0 + ((t - t0) / (t1 - t0)).clamp(0.0, 1.0) * (v1 - v0)
    }

    fn bounds(&self, column: usize, t: f64) -> Bounds {
        let [size, slope] = self
            .around(column, t)
            .map_or([0.0; 2], |[[t0, v0], [t1, v1]]| [v0.abs().max(v1.abs()), (v1 - v0).abs() / (t1 - t0)]);
        Bounds { size, slope, curvature: 0.0 }
    }
}

impl Wave {
    /// A sinusoid.
    pub fn sinusoid(frequency: f64, phase: f64, mean: f64) -> Self {
        Self { frequency: [frequency; 2], sweep: 1.0, phase, mean }
    }

    /// Frequency at a time \[Hz\].
    fn frequency_at(&self, t: f64) -> f64 {
        let [from, to] = self.frequency;
        from + (to - from) * (t / self.sweep)
    }

    fn value(&self, t: f64) -> f64 {
        let [from, to] = self.frequency;
        // Whole periods are taken off one product after the other, while they are known to their digits.
        let periods = (from * t).fract() + (0.5 * (to - from) * (t / self.sweep) * t).fract();
        self.mean + (TAU * periods + self.phase).sin()
    }

    fn bounds(&self, [from, to]: [f64; 2]) -> Bounds {
        let slope = TAU * self.frequency_at(from).abs().max(self.frequency_at(to).abs());
        let turn = TAU * (self.frequency[1] - self.frequency[0]).abs() / self.sweep;
        Bounds { size: 1.0 + self.mean.abs(), slope, curvature: slope * slope + turn }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(rows: &[[f64; 2]]) -> Course {
        let times = rows.iter().map(|row| row[0]).collect();
        let table = LoadTable::new(times, rows.iter().map(|row| row[1]).collect());
        Course::Table(Arc::new(table.expect("a table")), 0)
    }

    const ALWAYS: Interval = Interval { start: 0.0, end: f64::MAX, ramp: 0.0 };

    #[test]
    fn a_jump_has_two_sides() {
        let when = History::from(Interval { start: 0.1, end: 0.3, ramp: 0.0 });
        let t = 3.0 * 0.1;
        assert_eq!([when.just_before(t), when.just_after(t)], [1.0, 0.0]);
        assert_eq!([when.just_before(0.1), when.just_after(0.1)], [0.0, 1.0]);
        let ramp = History::from(Interval { start: 0.0, end: 1.0, ramp: 0.5 });
        assert_eq!([ramp.just_after(0.0), ramp.just_before(0.25), ramp.just_after(0.25)], [0.0, 0.5, 0.5]);
        assert_eq!([ramp.just_before(0.5), ramp.just_after(0.5)], [1.0, 1.0]);
        assert!(Interval::is_inside(0.25, [0.2, 0.3]) && !Interval::is_inside(t, [0.2, 0.3]));
    }

    #[test]
    fn a_ramp_is_cut_by_the_end() {
        let cut = History::from(Interval { start: 1.0, end: 2.0, ramp: 4.0 });
        assert_eq!([cut.just_after(1.0), cut.just_before(2.0), cut.just_after(2.0)], [0.0, 0.25, 0.0]);
        assert_eq!(cut.parts([1.0, 2.0]), 1);
    }

    #[test]
    fn a_table_of_a_ramped_interval_has_its_bits_on_both_sides_of_every_instant() {
        let interval = History::from(Interval { start: 0.25, end: 1.0, ramp: 0.5 });
        let course = table(&[[0.25, 0.0], [0.75, 1.0], [1.0, 1.0]]);
        let table = History { during: ALWAYS, share: None, course };
        for n in 0..400 {
            let t = f64::from(n) * 0.003;
            assert_eq!(table.just_after(t), interval.just_after(t), "{t}");
            assert_eq!(table.just_before(t), interval.just_before(t), "{t}");
            // At an instant the interval looks one part in 1e9 ahead on its ramp, too.
            assert!((table.factor(t) - interval.factor(t)).abs() < 1e-8, "{t}");
        }
        let mut breaks = [vec![], vec![]];
        interval.breaks_within([0.0, 1.5], &mut breaks[0]);
        table.breaks_within([0.0, 1.5], &mut breaks[1]);
        assert_eq!(breaks[0], breaks[1]);
    }

    #[test]
    fn a_table_jumps_where_two_rows_have_one_time_and_counts_from_the_start() {
        let course = table(&[[0.0, 1.0], [0.5, 3.0], [0.5, -1.0], [1.0, -1.0]]);
        let during = Interval { start: 2.0, end: 2.9, ramp: 0.0 };
        let load = History { during, share: None, course };
        assert_eq!([load.just_before(2.0), load.just_after(2.0), load.just_after(2.25)], [0.0, 1.0, 2.0]);
        assert_eq!([load.just_before(2.5), load.just_after(2.5)], [3.0, -1.0]);
        assert_eq!([load.just_before(2.9), load.just_after(2.9)], [-1.0, 0.0]);
        let mut breaks = vec![];
        load.breaks_within([1.0, 9.0], &mut breaks);
        breaks.sort_by(f64::total_cmp);
        breaks.dedup();
        assert_eq!(breaks, [2.0, 2.5, 2.9, 3.0]);
    }

    #[test]
    fn tables_that_are_none_are_refused() {
        for (times, values) in [
            (vec![0.0], vec![1.0]),
            (vec![0.0, 1.0], vec![1.0, 2.0, 3.0]),
            (vec![1.0, 0.0], vec![1.0, 2.0]),
            (vec![0.0, 0.0, 0.0], vec![1.0; 3]),
            (vec![0.0, f64::NAN], vec![1.0; 2]),
            (vec![0.0, 1.0], vec![]),
        ] {
            assert_eq!(LoadTable::new(times, values), None);
        }
    }

    #[test]
    fn chords_of_waves_are_as_near_as_they_are_said_to_be() {
        let ramped = Interval { start: 0.0, end: f64::MAX, ramp: 0.4 };
        let chirp = Wave { frequency: [1.0, 60.0], sweep: 2.0, phase: 0.3, mean: 0.0 };
        for (during, wave) in [
            (ALWAYS, Wave::sinusoid(12.0, 0.5, 0.0)),
            (ALWAYS, chirp),
            (ramped, Wave::sinusoid(3.0, 0.0, 0.25)),
        ] {
            let load = History { during, share: Some([0.0, 0.7, 1.9]), course: Course::Wave(wave) };
            for [from, to] in [[0.3, 0.31], [0.1, 0.4], [0.5, 0.6], [0.8, 1.3]] {
                let parts = load.parts([from, to]);
                let h = (to - from) / parts as f64;
                let chord = |part: usize| {
                    let ends = [part, part + 1].map(|part| from + part as f64 * h);
                    let middle = load.factor(0.5 * (ends[0] + ends[1]));
                    (0.5 * (load.just_after(ends[0]) + load.just_before(ends[1])) - middle).abs()
                };
                let worst = (0..parts).map(chord).fold(0.0, f64::max);
                // The share and the mean make the bound a little wide; it is not idle either.
                assert!(worst < 1.001 * CHORD, "{worst:e}");
                assert!(worst > 0.05 * CHORD, "{worst:e} with {parts} parts from {from} to {to}");
            }
        }
    }

    #[test]
    fn a_sweep_has_its_frequencies_at_its_ends_and_keeps_its_phase_for_long() {
        let chirp = Wave { frequency: [2.0, 10.0], sweep: 4.0, phase: 0.0, mean: 0.0 };
        assert_eq!([chirp.frequency_at(0.0), chirp.frequency_at(4.0)], [2.0, 10.0]);
        // After 4 s it has gone through 24 periods.
        let slope = (chirp.value(4.0) - chirp.value(4.0 - 1e-6)) / 1e-6;
        assert!(chirp.value(4.0).abs() < 1e-12 && (slope / (TAU * 10.0) - 1.0).abs() < 1e-4);
        // A million periods later a sinusoid of 12 Hz is where it was: 1/12 s has no finite digits, 0.25 s
        // has.
        let wave = Wave::sinusoid(12.0, 0.4, 0.0);
        assert_eq!(wave.value(250_000.25), wave.value(0.25));
    }

    #[test]
    fn shares_of_neighbours_on_a_path_add_to_one() {
        let of = |share| History { during: ALWAYS, share: Some(share), course: Course::Held };
        let places = [of([0.0, 0.0, 0.3]), of([0.0, 0.3, 0.8]), of([0.3, 0.8, 0.8])];
        for n in 0..100 {
            let t = 0.011 * f64::from(n);
            let sum: f64 = places.iter().map(|place| place.just_after(t)).sum();
            assert!((sum - 1.0).abs() < 1e-15, "{t}: {sum}");
        }
        assert_eq!([places[1].start(), places[1].end()], [0.0, 0.8]);
        assert_eq!([places[2].start(), places[2].end()], [0.3, f64::MAX]);
        assert_eq!(places[1].parts([0.0, 0.3]), 1);
    }
}
