//! Modes that dashpots couple, moved exactly over a step, for loads that are linear in time over it.
//!
//! With `W = diag(λ) Δt²`, the damping matrix `G = C Δt` of the modes, symmetric and positive semidefinite,
//! and the state `y = (ζ, Δt ζ̇)` a step is that of one mode ([`crate::exact`]) with matrices for numbers:
//!
//! ```text
//! y ← y + D y + P₀ f(t_n) + P₁ (f(t_n+1) − f(t_n))
//!
//! D = [ −φ W   S         ]     P₀ = Δt² (φ, S)     P₁ = Δt² (ψ, φ)
//!     [ −S W  −S G − φ W ]
//! ```
//!
//! `S(τ)` is the displacement after unit velocities, `φ = ∫₀ S` and `ψ = ∫₀ φ` the answers to unit steps and
//! to unit ramps. The three matrices are symmetric, and all there is to find. For a short time they are power
//! series, and twice that time is
//!
//! ```text
//! S ← 2S − X − Xᵀ           X = S (Wφ + ½ G S)
//! φ ← 2φ − φ W φ + S²
//! ψ ← 2ψ + Y + Yᵀ           Y = φ (S + ½ G φ)
//! ```
//!
//! which is the scaling and squaring of the augmented matrix of Van Loan (1978) in the blocks that it has. No
//! identity is among the numbers, so slow modes keep their digits while fast ones ask for many doublings.

/// Largest `√w²` and `g` of the time from which doubling starts, in units of one over that time.
const SHORT: f64 = 0.5;

/// Terms of the series: with numbers below [`SHORT`] the first that is left out is below 1e-22.
const TERMS: u8 = 20;

/// Most doublings: past them hardly a digit of the phase of a fast mode is left.
const MAX_DOUBLINGS: u32 = 40;

/// The modes of a step: `W`, and `G = diag(g) + DᵀD`.
#[derive(Clone, Copy, Debug)]
pub struct CoupledModes<'a> {
    /// `w² = λ Δt²` of each mode, length r.
    pub stiffness: &'a [f64],
    /// `g`, the damping that is each mode's own, length r.
    pub own: &'a [f64],
    /// `D`, any number of rows of length r.
    pub rows: &'a [f64],
}

/// `S`, `φ` and `ψ` at the end of a step, shape (r, r) each, symmetric.
#[derive(Debug)]
pub struct CoupledResponses<'a> {
    /// `S`.
    pub impulse: &'a mut [f64],
    /// `φ`.
    pub step: &'a mut [f64],
    /// `ψ`.
    pub ramp: &'a mut [f64],
}

impl CoupledModes<'_> {
    /// Numbers of work that [`CoupledModes::respond`] wants for `r` modes.
    #[must_use]
    pub const fn work_len(r: usize) -> usize {
        r.saturating_mul(r).saturating_mul(3).saturating_add(r)
    }

    /// Finds the responses; `work` has [`CoupledModes::work_len`] numbers. `None` for lengths that do not fit
    /// and for steps that are too long for the fastest mode. Costs four products of r × r matrices for each
    /// doubling of the time, of which there is one for each power of two in the largest of `2w` and `2g`.
    ///
    /// ```
    /// use vademecum_format::coupled::{CoupledModes, CoupledResponses};
    /// use vademecum_format::exact::Propagator;
    ///
    /// // A damper between two modes that are alike brakes their sum, and their difference not at all.
    /// let (w2, d) = (9.0, 0.5_f64.sqrt());
    /// let modes = CoupledModes { stiffness: &[w2; 2], own: &[0.0; 2], rows: &[d, d] };
    /// let ([mut impulse, mut step, mut ramp], mut work) = ([[0.0; 4]; 3], [0.0; CoupledModes::work_len(2)]);
    /// let out = CoupledResponses { impulse: &mut impulse, step: &mut step, ramp: &mut ramp };
    /// modes.respond(out, &mut work).ok_or("lengths")?;
    /// let [sum, difference] = [0.5, 0.0].map(|sigma| Propagator::new(w2, sigma, 1.0).d[1]);
    /// assert!((impulse[0] - 0.5 * (sum + difference)).abs() < 1e-15);
    /// assert!((impulse[1] - 0.5 * (sum - difference)).abs() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn respond(&self, out: CoupledResponses<'_>, work: &mut [f64]) -> Option<()> {
        let r = self.stiffness.len();
        let CoupledResponses { impulse, step, ramp } = out;
        let (square, all) = (r.checked_mul(r)?, [impulse.len(), step.len(), ramp.len()]);
        let fits = r > 0 && self.own.len() == r && self.rows.len().is_multiple_of(r) && all == [square; 3];
        let work = work.get_mut(..Self::work_len(r)).filter(|_| fits)?;
        let (line, work) = work.split_at_mut_checked(r)?;
        let (a, work) = work.split_at_mut_checked(square)?;
        let (b, c) = work.split_at_mut_checked(square)?;
        let doublings = self.doublings()?;
        let mut short = 1.0;
        (0..doublings).for_each(|_| short *= 0.5);
        self.series(short, [&mut *impulse, &mut *step, &mut *ramp], [&mut *a, &mut *b, &mut *c], line);
        for _ in 0..doublings {
            // b = Y
            a.iter_mut().zip(&*impulse).for_each(|(a, &s)| *a = s);
            self.add_damping(0.5, step, a, line);
            product(r, 1.0, step, a, b);
            grow(r, 1.0, b, ramp);
            // b = S² − φWφ, c = X
            self.stiffened(step, a);
            product(r, 1.0, impulse, impulse, b);
            add_product(r, -1.0, step, a, b);
            self.add_damping(0.5, impulse, a, line);
            product(r, 1.0, impulse, a, c);
            grow(r, -1.0, c, impulse);
            step.iter_mut().zip(&*b).for_each(|(step, &b)| *step = 2.0 * *step + b);
            symmetrise(r, step);
        }
        Some(())
    }

    /// Doublings from a time that is short for the fastest mode and the strongest damper.
    fn doublings(&self) -> Option<u32> {
        let largest = |numbers: &[f64]| numbers.iter().fold(0.0, |most: f64, &x| most.max(x));
        let rows: f64 = self.rows.iter().map(|d| d * d).sum();
        let mut fastest = libm::sqrt(largest(self.stiffness)).max(largest(self.own) + rows);
        if fastest.is_nan() {
            return None;
        }
        for doublings in 0..=MAX_DOUBLINGS {
            if fastest <= SHORT {
                return Some(doublings);
            }
            fastest *= 0.5;
        }
        None
    }

    /// The three by their power series in `τ`: `c_{n+2} = −((n+1) G c_{n+1} + W c_n)/((n+1)(n+2))` are the
    /// coefficients of `S`.
    fn series(
        &self,
        time: f64,
        [impulse, step, ramp]: [&mut [f64]; 3],
        [before, now, next]: [&mut [f64]; 3],
        line: &mut [f64],
    ) {
        let r = self.stiffness.len();
        let (mut before, mut now, mut next) = (before, now, next);
        before.fill(0.0);
        identity(r, time, now);
        identity(r, time, impulse);
        identity(r, time * time / 2.0, step);
        identity(r, time * time * time / 6.0, ramp);
        for n in 1..TERMS {
            let n = f64::from(n);
            // Terms, not coefficients: with `τⁿ` in them they neither grow nor vanish.
            self.stiffened(before, next);
            next.iter_mut().for_each(|x| *x *= -time * time / (n * (n + 1.0)));
            self.add_damping(-time / (n + 1.0), now, next, line);
            core::mem::swap(&mut before, &mut now);
            core::mem::swap(&mut now, &mut next);
            let (by_step, by_ramp) = (time / (n + 2.0), time * time / ((n + 2.0) * (n + 3.0)));
            let sums = impulse.iter_mut().zip(step.iter_mut()).zip(ramp.iter_mut());
            for (((s, phi), psi), &term) in sums.zip(&*now) {
                *s += term;
                *phi += by_step * term;
                *psi += by_ramp * term;
            }
        }
        [impulse, step, ramp].into_iter().for_each(|matrix| symmetrise(r, matrix));
    }

    /// `out = W m`.
    fn stiffened(&self, m: &[f64], out: &mut [f64]) {
        let r = self.stiffness.len().max(1);
        for ((out, m), w2) in rows_of_mut(out, r).zip(rows_of(m, r)).zip(self.stiffness) {
            out.iter_mut().zip(m).for_each(|(out, m)| *out = w2 * m);
        }
    }

    /// `out += scale G m`; `line` is work.
    fn add_damping(&self, scale: f64, m: &[f64], out: &mut [f64], line: &mut [f64]) {
        let r = self.stiffness.len().max(1);
        for ((out, m), own) in rows_of_mut(out, r).zip(rows_of(m, r)).zip(self.own) {
            out.iter_mut().zip(m).for_each(|(out, m)| *out += scale * own * m);
        }
        for row in rows_of(self.rows, r) {
            line.fill(0.0);
            for (m, d) in rows_of(m, r).zip(row) {
                line.iter_mut().zip(m).for_each(|(line, m)| *line += d * m);
            }
            for (out, d) in rows_of_mut(out, r).zip(row) {
                out.iter_mut().zip(&*line).for_each(|(out, line)| *out += scale * d * line);
            }
        }
    }
}

/// Rows of length `r`, at least 1. The chunks of a slice, zipped, divide by their length, and the compiler
/// cannot see that it is not zero.
fn rows_of(m: &[f64], r: usize) -> impl Iterator<Item = &[f64]> {
    let mut rest = m;
    core::iter::from_fn(move || {
        let (row, after) = rest.split_at_checked(r)?;
        rest = after;
        Some(row)
    })
}

/// [`rows_of`] a matrix that is written.
fn rows_of_mut(m: &mut [f64], r: usize) -> impl Iterator<Item = &mut [f64]> {
    let mut rest = m;
    core::iter::from_fn(move || {
        let (row, after) = core::mem::take(&mut rest).split_at_mut_checked(r)?;
        rest = after;
        Some(row)
    })
}

/// `value` times the identity.
fn identity(r: usize, value: f64, out: &mut [f64]) {
    out.fill(0.0);
    out.iter_mut().step_by(r.saturating_add(1).max(1)).for_each(|x| *x = value);
}

/// `out = scale a b`.
fn product(r: usize, scale: f64, a: &[f64], b: &[f64], out: &mut [f64]) {
    out.fill(0.0);
    add_product(r, scale, a, b, out);
}

/// `out += scale a b`, four rows of `b` at a time: the row of `out` is read and written a quarter as often.
fn add_product(r: usize, scale: f64, a: &[f64], b: &[f64], out: &mut [f64]) {
    let r = r.max(1);
    let four = r.saturating_mul(4).max(1);
    for (a, out) in rows_of(a, r).zip(rows_of_mut(out, r)) {
        let (fours, rest) = a.as_chunks::<4>();
        let mut blocks = b.chunks_exact(four);
        for (a, block) in fours.iter().zip(&mut blocks) {
            let [a0, a1, a2, a3] = a.map(|a| scale * a);
            let mut rows = rows_of(block, r);
            let mut row = || rows.next().unwrap_or(&[]);
            let (b0, b1, b2, b3) = (row(), row(), row(), row());
            for ((((out, b0), b1), b2), b3) in out.iter_mut().zip(b0).zip(b1).zip(b2).zip(b3) {
                *out += (a0 * b0 + a1 * b1) + (a2 * b2 + a3 * b3);
            }
        }
        for (a, b) in rest.iter().zip(rows_of(blocks.remainder(), r)) {
            out.iter_mut().zip(b).for_each(|(out, b)| *out += scale * a * b);
        }
    }
}

/// `m ← 2m ± (x + xᵀ)`; `x` becomes that sum.
fn grow(r: usize, sign: f64, x: &mut [f64], m: &mut [f64]) {
    for_each_pair(r, x, |above, below| {
        let sum = above + below;
        [sum, sum]
    });
    m.iter_mut().zip(&*x).for_each(|(m, x)| *m = 2.0 * *m + sign * x);
}

/// The mean of a matrix and its transpose.
fn symmetrise(r: usize, m: &mut [f64]) {
    for_each_pair(r, m, |above, below| [0.5 * (above + below); 2]);
}

/// Replaces the numbers at `(i, j)` and `(j, i)`, a number of the diagonal as one that is met by itself.
fn for_each_pair(r: usize, m: &mut [f64], with: impl Fn(f64, f64) -> [f64; 2]) {
    for i in 0..r {
        for j in i..r {
            let [above, below] = [i * r + j, j * r + i];
            let (Some(&a), Some(&b)) = (m.get(above), m.get(below)) else { return };
            let [a, b] = with(a, b);
            for (at, value) in [(above, a), (below, b)] {
                if let Some(place) = m.get_mut(at) {
                    *place = value;
                }
            }
        }
    }
}
