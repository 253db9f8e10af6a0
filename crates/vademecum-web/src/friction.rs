//! Forces between a body and what touches it at some places, solved for at the end of a step.
//!
//! At each place either the gap is closed and the force pushes, or the gap is open and there is no force; the
//! force across the normal holds the place or, if it would take more than μ times the push, slips with that.
//! The body answers through the operator `W` of all forces together
//! ([`vademecum_eval::AnyBody::compliance`]), so nothing depends on how stiff anything is. Solved place by
//! place, again and again, until no force changes (projected Gauss-Seidel, as in the example
//! `press_a_sphere`).

use crate::vectors::{Vector, along, dot, length, minus, plus, times};

/// Most places that are solved for at once.
pub const MOST: usize = 8;
/// Numbers of a row of `W` for so many places.
const WIDTH: usize = 3 * MOST;
/// Rounds after which the forces found so far are taken.
const ROUNDS: usize = 2_000;

/// A place where two bodies may touch.
#[derive(Clone, Copy, Debug, Default)]
pub struct ContactPoint {
    /// Unit vector into the body.
    pub normal: Vector,
    /// Gap along it at the end of the step if no force acts \[m\].
    pub gap: f64,
    /// Sliding of the body along the other in the step without forces \[m\].
    pub slide: Vector,
    /// The force on the body \[N\].
    pub force: Vector,
}

/// Delassus operator of all places: `W`, `(3 n, 3 n)`, row by row \[m/N\].
#[derive(Clone, Copy, Debug)]
pub struct Operator<'a> {
    /// The numbers.
    w: &'a [f64],
    /// `3 n`.
    width: usize,
}

impl<'a> Operator<'a> {
    /// Of `n` places, the numbers of [`vademecum_eval::AnyBody::compliance`].
    pub fn new(w: &'a [f64], n: usize) -> Self {
        Self { w, width: 3 * n }
    }

    fn row(&self, c: usize, i: usize) -> &'a [f64] {
        let start = (3 * c + i) * self.width;
        self.w.get(start..start + self.width).unwrap_or_default()
    }

    /// `W_cc`.
    fn own(&self, c: usize) -> [Vector; 3] {
        [0, 1, 2].map(|i| self.row(c, i).as_chunks::<3>().0.get(c).copied().unwrap_or_default())
    }

    /// True if a gap that is closed by more than `tolerance` is at a place that no force moves.
    pub fn is_stuck(&self, places: &[ContactPoint], tolerance: f64) -> bool {
        let held = |c: usize| self.own(c).as_flattened().iter().all(|&yields| yields == 0.0);
        places.iter().enumerate().any(|(c, place)| place.gap < -tolerance && held(c))
    }

    /// `Σ_d W_cd f_d`.
    #[inline(never)]
    fn moved(&self, c: usize, places: &[ContactPoint]) -> Vector {
        [0, 1, 2].map(|i| {
            let blocks = self.row(c, i).as_chunks::<3>().0;
            blocks.iter().zip(places).map(|(&block, place)| dot(block, place.force)).sum()
        })
    }
}

/// Finds the forces, up to gaps of `tolerance` \[m\]. Whether it did; otherwise the last round's stand.
#[inline(never)]
pub fn solve(operator: &Operator<'_>, friction: f64, tolerance: f64, places: &mut [ContactPoint]) -> bool {
    for _ in 0..ROUNDS {
        let mut changed = 0.0_f64;
        for c in 0..places.len() {
            changed = changed.max(push(operator, friction, c, places));
        }
        if changed <= tolerance {
            return true;
        }
    }
    false
}

/// Solves for the force of one place while the others stay; how far that moves it \[m\].
#[inline(never)]
fn push(operator: &Operator<'_>, friction: f64, c: usize, places: &mut [ContactPoint]) -> f64 {
    let Some(&ContactPoint { normal, gap, slide, force: before }) = places.get(c) else { return 0.0 };
    let own = operator.own(c);
    let yields = dot(normal, own.map(|row| dot(row, normal)));
    let yields_along = own[0][0] + own[1][1] + own[2][2] - yields;
    if yields.is_nan() || yields <= 0.0 || yields_along.is_nan() {
        // Held by the supports: no force moves it.
        return 0.0;
    }
    let mut put = |force: Vector| {
        if let Some(place) = places.get_mut(c) {
            place.force = force;
        }
        operator.moved(c, places)
    };

    // The force along the normal that closes the gap, if it pushes.
    let moved = put(before);
    let pushed_before = dot(before, normal);
    let pushed = (pushed_before - (gap + dot(normal, moved)) / yields).max(0.0);
    let force = plus(before, times(pushed - pushed_before, normal));
    let slid = plus(slide, put(force));

    // Friction that stops the slide, or as much of it as the cone allows.
    let holds = if yields_along > 0.0 { times(1.0 / yields_along, along(slid, normal)) } else { [0.0; 3] };
    let wanted = along(minus(force, holds), normal);
    let (size, most) = (length(wanted), friction * pushed);
    let share = if size > most { most / size } else { 1.0 };
    let found = plus(times(pushed, normal), times(share, wanted));
    put(found);
    length(minus(found, before)) * yields.max(yields_along)
}

/// `W` of as many places as there may be, to be lent.
pub const fn room() -> [f64; WIDTH * WIDTH] {
    [0.0; WIDTH * WIDTH]
}

#[cfg(test)]
mod tests {
    use super::*;

    const UP: Vector = [0.0, 0.0, 1.0];

    /// Two places, 2 m/N each and 1 m/N of each other's push.
    fn two() -> Vec<f64> {
        let entry = |i: usize, j: usize| match (i % 3 == j % 3, i / 3 == j / 3) {
            (true, true) => 2.0,
            (true, false) if i % 3 == 2 => 1.0,
            _ => 0.0,
        };
        (0..36).map(|k| entry(k / 6, k % 6)).collect()
    }

    fn place(gap: f64, slide: Vector) -> ContactPoint {
        ContactPoint { normal: UP, gap, slide, force: [0.0; 3] }
    }

    #[test]
    fn two_gaps_close_and_an_open_one_is_left_alone() {
        let w = two();
        let operator = Operator::new(&w, 2);
        // 2 a + b = 3, a + 2 b = 3.
        let mut places = [place(-3.0, [0.0; 3]), place(-3.0, [0.0; 3])];
        assert!(solve(&operator, 0.0, 1e-14, &mut places));
        for place in places {
            assert!((place.force[2] - 1.0).abs() < 1e-13, "{:?}", place.force);
        }
        // The push on the first opens the second.
        let mut places = [place(-3.0, [0.0; 3]), place(-1.0, [0.0; 3])];
        assert!(solve(&operator, 0.0, 1e-14, &mut places));
        assert!((places[0].force[2] - 1.5).abs() < 1e-13 && places[1].force == [0.0; 3]);
    }

    #[test]
    fn friction_holds_what_it_can_and_slips_with_what_it_may() {
        let w = two();
        let operator = Operator::new(&w, 2);
        let solved = |slide| {
            let mut places = [place(-4.0, slide), place(100.0, [0.0; 3])];
            assert!(solve(&operator, 0.5, 1e-14, &mut places));
            places[0].force
        };
        // A push of 2 N holds up to 1 N across, which moves by 2 m.
        let [x, y, z] = solved([1.0, 0.0, 0.0]);
        assert!((x + 0.5).abs() < 1e-12 && y == 0.0 && (z - 2.0).abs() < 1e-13, "{x} {y} {z}");
        let [x, y, z] = solved([0.0, -7.0, 0.0]);
        assert!(x == 0.0 && (y - 1.0).abs() < 1e-12 && (z - 2.0).abs() < 1e-13, "{x} {y} {z}");
    }

    #[test]
    fn a_place_that_nothing_moves_is_not_pushed() {
        let w = [0.0; 9];
        let mut places = [place(-1.0, [0.0; 3])];
        assert!(solve(&Operator::new(&w, 1), 0.3, 1e-14, &mut places));
        assert_eq!(places[0].force, [0.0; 3]);
    }
}
