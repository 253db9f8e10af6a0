//! Damping of the joined modes.

use crate::assembly::counts::{Counts, with_firsts};
use crate::assembly::error::AssemblyError;
use crate::assembly::part::Part;
use crate::assembly::synthesis::{Synthesis, add_congruence, joint_matrix, short};
use crate::base::lend::Lender;
use crate::kernels::dense::{add_scaled, apply, at, eliminate, row, row_mut, set, symmetrise};
use crate::kernels::eigen::{eigen_work, symmetric_eigen};

/// The change by the coupling of modes from which a file holds it.
const COUPLED: f64 = 1e-3;

/// Modes at whose frequencies the coupling is measured.
const MEASURED: usize = 64;

/// A mode whose damping is a smaller share of the largest is not damped.
const UNDAMPED: f64 = 1e-9;

/// An eigenvalue of a damping matrix that is a smaller share of the largest is rounding.
const ROUNDING: f64 = 1e-15;

/// Damping of the joined modes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Damping<'w> {
    /// Rayleigh's `α` and `β`.
    pub rayleigh: [f64; 2],
    /// A ratio of each mode beside Rayleigh's.
    pub ratios: &'w [f64],
    /// True if the ratios are written.
    pub has_ratios: bool,
    /// Rows of a damping matrix that couples modes; none where the ratios are all.
    pub rows: &'w [f64],
    /// Largest change of an answer at a natural frequency by the coupling of modes.
    pub coupling: f64,
}

impl<'w> Damping<'w> {
    /// Damping in the numbers `kept`.
    pub fn new(
        parts: &[Part<'_>],
        counts: &Counts,
        synthesis: &Synthesis<'_>,
        kept: &'w mut [f64],
        work: &mut [f64],
    ) -> Result<Self, AssemblyError> {
        let n = counts.n_modes();
        let mut kept = Lender::new(kept);
        let of_work = short("numbers of work");
        let ratios = kept.take(n).map_err(&of_work)?;
        if let Some(first) = parts.first().filter(|_| counts.alike) {
            let ratio = first.ratio().unwrap_or(0.0);
            ratios.fill(ratio);
            let (rayleigh, has_ratios) = (first.rayleigh(), ratio != 0.0);
            return Ok(Self { rayleigh, ratios, has_ratios, rows: &[], coupling: 0.0 });
        }
        let found = kept.take(n * n).map_err(&of_work)?;
        let mut work = Lender::new(work);
        let mut take = |n: usize| work.take(n).map_err(&of_work);
        let along = take(n * n)?;
        let r = counts.r;
        {
            let (whole, half) = (take(r * r)?, take(r)?);
            let (joint, pulled) = (take(counts.m * counts.m)?, take(counts.m * r)?);
            of_parts(parts, counts, synthesis, whole, (joint, pulled, half));
            let shapes = synthesis.shapes.get(counts.first_mode * r..).unwrap_or_default();
            for (k, shape) in shapes.chunks_exact(r.max(1)).enumerate() {
                apply(whole, shape, half);
                apply(shapes, half, row_mut(along, k, n));
            }
            symmetrise(along, n);
        }
        let values = synthesis.eigenvalues.get(counts.first_mode..).unwrap_or_default();
        let (matrix, answer) = (take(4 * n * n)?, take(2 * n)?);
        let coupling = coupling_error(values, along, matrix, answer)?;
        let own = |k: usize, damped: f64| damped / (2.0 * libm::sqrt(at(values, k)));
        for (k, ratio) in ratios.iter_mut().enumerate() {
            *ratio = own(k, at(along, k * n + k).max(0.0));
        }
        if coupling <= COUPLED {
            return Ok(Self { rayleigh: [0.0; 2], ratios, has_ratios: true, rows: &[], coupling });
        }
        let (sizes, vectors, eigen) = (take(n)?, take(n * n)?, take(eigen_work(n))?);
        symmetric_eigen(along, n, sizes, vectors, eigen).map_err(|_| AssemblyError::NoConvergence)?;
        let largest = sizes.last().copied().unwrap_or(0.0);
        let mut count = 0;
        for (i, &size) in sizes.iter().enumerate().filter(|(_, size)| **size > ROUNDING * largest) {
            let to = row_mut(found, count, n).iter_mut();
            to.zip(row(vectors, i, n)).for_each(|(to, v)| *to = libm::sqrt(size) * v);
            count += 1;
        }
        let rows: &[f64] = found;
        let rows = rows.get(..count * n).unwrap_or_default();
        for (k, ratio) in ratios.iter_mut().enumerate() {
            *ratio = own(k, rows.iter().skip(k).step_by(n).map(|d| d * d).sum());
        }
        Ok(Self { rayleigh: [0.0; 2], ratios, has_ratios: false, rows, coupling })
    }
}

/// The damping matrix over the coordinates of the parts, with the damping of what the parts leave out as
/// their Rayleigh damping has it.
fn of_parts(
    parts: &[Part<'_>],
    counts: &Counts,
    synthesis: &Synthesis<'_>,
    out: &mut [f64],
    (joint, pulled, scratch): (&mut [f64], &mut [f64], &mut [f64]),
) {
    let Counts { r, m, .. } = *counts;
    let of_rest = |part: &Part<'_>| {
        let [alpha, beta] = part.rayleigh();
        [beta, alpha]
    };
    out.fill(0.0);
    joint_matrix(parts, synthesis.rows, of_rest, joint);
    add_congruence(joint, (synthesis.answers, m, r), pulled, out);
    for (first, part) in with_firsts(parts) {
        let n = part.n_coordinates();
        for dashpot in 0..part.n_dashpots {
            let own = scratch.get_mut(..n).unwrap_or_default();
            part.dashpot(dashpot, own);
            for k in 0..n {
                let to = row_mut(out, first + k, r).get_mut(first..first + n).unwrap_or_default();
                add_scaled(to, at(own, k), own);
            }
        }
        for k in 0..n {
            let place = (first + k) * r + first + k;
            let own = at(out, place) + part.damping(k);
            set(out, place, own);
        }
    }
}

/// Largest change of the answer to a force on one mode at its natural frequency if the coupling is left out,
/// relative, in the norm of the energy. `damping` is the whole damping matrix along the modes \[1/s\].
fn coupling_error(
    eigenvalues: &[f64],
    damping: &[f64],
    matrix: &mut [f64],
    answer: &mut [f64],
) -> Result<f64, AssemblyError> {
    let n = eigenvalues.len();
    let largest = (0..n).map(|k| at(damping, k * n + k)).fold(0.0, f64::max);
    let mut worst: f64 = 0.0;
    for (k, &value) in eigenvalues.iter().enumerate().take(MEASURED) {
        let (omega, own) = (libm::sqrt(value), at(damping, k * n + k));
        if own <= UNDAMPED * largest || omega <= 0.0 {
            continue;
        }
        // (Λ − ω² + iωC) q = e, real and imaginary parts.
        matrix.fill(0.0);
        for (i, &other) in eigenvalues.iter().enumerate() {
            let damped = row(damping, i, n);
            let upper = row_mut(matrix, i, 2 * n);
            set(upper, i, other - value);
            add_scaled(upper.get_mut(n..).unwrap_or_default(), -omega, damped);
            let below = row_mut(matrix, n + i, 2 * n);
            add_scaled(below.get_mut(..n).unwrap_or_default(), omega, damped);
            set(below, n + i, other - value);
        }
        answer.fill(0.0);
        set(answer, k, 1.0);
        eliminate(matrix, 2 * n, answer).map_err(|_| AssemblyError::NoConvergence)?;
        let alone = -1.0 / (omega * own);
        let change = |(j, other): (usize, &f64)| {
            let im = at(answer, n + j) - if j == k { alone } else { 0.0 };
            (other + value) * (at(answer, j) * at(answer, j) + im * im)
        };
        let sum: f64 = eigenvalues.iter().enumerate().map(change).sum();
        worst = worst.max(libm::sqrt(sum / (2.0 * value * alone * alone)));
    }
    if worst.is_finite() { Ok(worst) } else { Err(AssemblyError::NoConvergence) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::dense::dot;

    #[test]
    fn the_coupling_of_two_modes_is_that_of_their_inverse() {
        let (values, c) = ([4.0, 9.0_f64], [0.2, 0.1, 0.1, 0.3]);
        // By Cramer's rule on (Λ − ω² + iωC).
        let of_mode = |k: usize| -> f64 {
            let (omega, other) = (values[k].sqrt(), 1 - k);
            let own = [0.0, omega * c[3 * k]];
            let second = [values[other] - values[k], omega * c[3 * other]];
            let cross = [0.0, omega * c[1]];
            let times = |a: [f64; 2], b: [f64; 2]| [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
            let over = |a: [f64; 2], b: [f64; 2]| {
                let size = b[0] * b[0] + b[1] * b[1];
                times(a, [b[0] / size, -b[1] / size])
            };
            let (product, square) = (times(own, second), times(cross, cross));
            let determinant = [product[0] - square[0], product[1] - square[1]];
            let (answer, leak) = (over(second, determinant), over(cross.map(|x| -x), determinant));
            let alone = over([1.0, 0.0], own);
            let norm = |a: [f64; 2]| dot(&a, &a);
            let change = [answer[0] - alone[0], answer[1] - alone[1]];
            let weight = |i: usize| values[i] + values[k];
            ((weight(k) * norm(change) + weight(other) * norm(leak)) / (weight(k) * norm(alone))).sqrt()
        };
        let expected = of_mode(0).max(of_mode(1));
        let found = coupling_error(&values, &c, &mut [0.0; 16], &mut [0.0; 4]).expect("regular");
        assert!((found / expected - 1.0).abs() < 1e-12 && found > 0.01, "{found} {expected}");
        let apart = coupling_error(&values, &[0.2, 0.0, 0.0, 0.3], &mut [0.0; 16], &mut [0.0; 4]);
        assert!(apart.expect("regular") < 1e-14);
    }
}
