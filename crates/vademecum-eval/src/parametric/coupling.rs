//! First-order change of an exact modal step when a change of the matrices couples two modes.
//!
//! Mode `j` moves as `y = (q, q̇, f, ḟ)` under a load that is linear over the step. A coupling pushes mode
//! `i` by `−(q_j + c q̇_j)`, so the state of mode `i` after a step `h` changes by
//!
//! ```text
//! L(h) = −∫₀ʰ e^{A_i(h−s)} S e^{Â_j s} ds        S = [0 0 0 0; 1 c 0 0]
//! L(2h) = e^{A_i h} L(h) + L(h) e^{Â_j h}
//! ```
//!
//! On a short step `L` is a power series, and it is doubled from there. Nothing divides by a difference of
//! eigenvalues: equal ones and critical damping are no special cases.

use crate::kernels::dense::{at, row, set};
use vademecum_format::exact::Propagator;

/// Numbers of a step of one mode, `(q, q̇)` after it from `(q, q̇, f, ḟ)` before it, two rows of four.
pub(crate) const STEP: usize = 8;
/// Most doublings.
const MOST: i32 = 48;
/// Terms of the power series, whose argument is at most [`SHORT`].
const TERMS: u32 = 16;
/// Largest product of a rate and a step on which the series is taken.
const SHORT: f64 = 0.25;

/// A mode: stiffness `λ` and damping rate `d` of `q̈ + d q̇ + λ q = f`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mode {
    pub lambda: f64,
    pub damping: f64,
}

type Step = [[f64; 4]; 2];

impl Mode {
    /// Exact step of this mode.
    fn step(self, h: f64) -> Step {
        let Propagator { d: [d0, d1, d2, d3], held: [p0, p1], rising: [s0, s1] } =
            Propagator::new(self.lambda, 0.5 * self.damping, h);
        [[1.0 + d0, d1 * h, p0, s0 * h], [d2 / h, 1.0 + d3, p1 / h, s1]]
    }
}

/// Number of doublings for modes of these rates over a step.
pub(crate) fn doublings(modes: impl Iterator<Item = Mode>, h: f64) -> i32 {
    let rate = modes.fold(0.0, |most: f64, mode| {
        let own = libm::sqrt(mode.lambda) + mode.damping;
        if own > most { own } else { most }
    });
    let mut count = 0;
    while count < MOST && libm::scalbn(rate * h, -count) > SHORT {
        count += 1;
    }
    count
}

/// Exact steps of a mode over `h / 2^k` for `k` from `doublings` to 0, one after the other.
pub(crate) fn steps_into(mode: Mode, h: f64, doublings: i32, out: &mut [f64]) {
    for (k, out) in (0..=doublings).rev().zip(out.chunks_exact_mut(STEP)) {
        let step = mode.step(libm::scalbn(h, -k));
        out.iter_mut().zip(step.as_flattened()).for_each(|(out, x)| *out = *x);
    }
}

/// A row of [`steps_into`].
fn step_at(steps: &[f64], place: usize) -> Step {
    let own = row(steps, place, STEP);
    core::array::from_fn(|i| core::array::from_fn(|j| at(own, 4 * i + j)))
}

/// `L` over `h`; `source` is `(1, c, 0, 0)`, steps those of [`steps_into`].
pub(crate) fn coupling(
    (i, steps_i): (Mode, &[f64]),
    (j, steps_j): (Mode, &[f64]),
    source: [f64; 2],
    h: f64,
    doublings: i32,
) -> Step {
    let mut h = libm::scalbn(h, -doublings);
    let mut l = series(i, j, source, h);
    for place in 0..doublings.max(0) as usize {
        let (e_i, e_j) = (step_at(steps_i, place), step_at(steps_j, place));
        l = doubled(&l, &e_i, &e_j, h);
        h *= 2.0;
    }
    l
}

/// The power series of `L`.
fn series(i: Mode, j: Mode, [of_q, of_rate]: [f64; 2], h: f64) -> Step {
    // Row `S Â_jⁿ`, and `T_n` with `T_{n+1} = A_i T_n + S Â_j^{n+1}`.
    let mut s = [of_q, of_rate, 0.0, 0.0];
    let mut t: Step = [[0.0; 4], s];
    let mut l: Step = [[0.0; 4]; 2];
    let mut weight = h;
    for n in 0..TERMS {
        for (l, t) in l.as_flattened_mut().iter_mut().zip(t.as_flattened()) {
            *l -= weight * t;
        }
        let [a, b, c, _] = s;
        s = [-j.lambda * b, a - j.damping * b, b, c];
        let [upper, lower] = t;
        let mut next = [lower, s];
        for ((next, upper), lower) in next[1].iter_mut().zip(upper).zip(lower) {
            *next -= i.lambda * upper + i.damping * lower;
        }
        t = next;
        weight *= h / f64::from(n + 2);
    }
    l
}

/// `E_i L + L Ê_j`.
fn doubled(l: &Step, e_i: &Step, e_j: &Step, h: f64) -> Step {
    let full: [[f64; 4]; 4] = [e_j[0], e_j[1], [0.0, 0.0, 1.0, h], [0.0, 0.0, 0.0, 1.0]];
    core::array::from_fn(|a| {
        core::array::from_fn(|b| {
            let first = e_i[a][0] * l[0][b] + e_i[a][1] * l[1][b];
            first + l[a].iter().zip(&full).map(|(l, e)| l * e[b]).sum::<f64>()
        })
    })
}

/// A step, or its change, from the load at the start and at the end in the place of `f` and `ḟ`.
pub(crate) fn of_ends(step: &Step, h: f64) -> Step {
    step.map(|[q, v, f, rate]| [q, v, f - rate / h, rate / h])
}

/// Writes a step.
pub(crate) fn store(step: &Step, out: &mut [f64]) {
    step.as_flattened().iter().enumerate().for_each(|(place, value)| set(out, place, *value));
}

/// Exact step of a mode from the loads at its ends.
pub(crate) fn step_of_ends(mode: Mode, h: f64) -> Step {
    of_ends(&mode.step(h), h)
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use std::vec;

    fn found(i: Mode, j: Mode, source: [f64; 2], h: f64) -> Step {
        let count = doublings([i, j].into_iter(), h);
        let mut steps = [vec![0.0; 8 * (count as usize + 1)], vec![0.0; 8 * (count as usize + 1)]];
        steps_into(i, h, count, &mut steps[0]);
        steps_into(j, h, count, &mut steps[1]);
        coupling((i, &steps[0]), (j, &steps[1]), source, h, count)
    }

    /// The integral by Gauss's rule of five points on many pieces, with closed forms inside.
    fn integral(i: Mode, j: Mode, [of_q, of_rate]: [f64; 2], h: f64) -> Step {
        const X: [f64; 3] = [0.0, 0.538_469_310_105_683_1, 0.906_179_845_938_664];
        const W: [f64; 3] = [0.568_888_888_888_888_9, 0.478_628_670_499_366_47, 0.236_926_885_056_189_08];
        let points = [(-X[2], W[2]), (-X[1], W[1]), (X[0], W[0]), (X[1], W[1]), (X[2], W[2])];
        let pieces = 4000;
        let width = h / f64::from(pieces);
        let mut sum = [[0.0; 4]; 2];
        for piece in 0..pieces {
            for (x, w) in points {
                let s = (f64::from(piece) + 0.5 + 0.5 * x) * width;
                let (after, before) = (i.step(h - s), j.step(s));
                for a in 0..2 {
                    for b in 0..4 {
                        let pushed = of_q * before[0][b] + of_rate * before[1][b];
                        sum[a][b] -= 0.5 * width * w * after[a][1] * pushed;
                    }
                }
            }
        }
        sum
    }

    #[test]
    fn the_coupling_is_its_integral_for_equal_eigenvalues_and_critical_damping_too() {
        let mode = |omega: f64, ratio: f64| Mode { lambda: omega * omega, damping: 2.0 * ratio * omega };
        let pairs = [
            (mode(3.0, 0.02), mode(7.0, 0.01)),
            (mode(5.0, 0.02), mode(5.0, 0.02)),
            (mode(5.0, 0.02), mode(5.0 + 1e-9, 0.02)),
            (mode(5.0, 1.0), mode(5.0, 1.0)),
            (mode(5.0, 1.0), mode(2.0, 1.0)),
            (mode(40.0, 3.0), mode(6.0, 0.1)),
            (mode(90.0, 0.0), mode(110.0, 0.4)),
        ];
        for (i, j) in pairs {
            for source in [[1.0, 0.0], [1.0, 0.03], [0.0, 1.0]] {
                let (found, expected) = (found(i, j, source, 0.4), integral(i, j, source, 0.4));
                for (a, (found, expected)) in found.iter().zip(&expected).enumerate() {
                    let size = expected.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
                    for (x, y) in found.iter().zip(expected) {
                        assert!((x - y).abs() < 1e-11 * size, "{i:?} {j:?} {source:?} {a}: {x} beside {y}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_coupling_of_a_mode_with_itself_is_the_derivative_of_its_step() {
        for (omega, ratio) in [(3.0, 0.05), (10.0, 1.0), (4.0, 2.5)] {
            let own = Mode { lambda: omega * omega, damping: 2.0 * ratio * omega };
            let (h, change) = (0.3, 1e-3 * own.lambda);
            let at = |s: f64| Mode { lambda: own.lambda + s * change, ..own }.step(h);
            let l = found(own, own, [1.0, 0.0], h);
            for a in 0..2 {
                for b in 0..4 {
                    let difference = |s: f64| (at(s)[a][b] - at(-s)[a][b]) / (2.0 * s * change);
                    // Richardson's extrapolation of central differences.
                    let expected = (4.0 * difference(0.5) - difference(1.0)) / 3.0;
                    let size = l[a].iter().fold(0.0, |m: f64, x| m.max(x.abs()));
                    assert!((l[a][b] - expected).abs() < 1e-9 * size, "{omega} {ratio} {a} {b}");
                }
            }
        }
    }
}
