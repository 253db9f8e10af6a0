//! Newton's method in two forms.
//!
//! A correction is `p = −K⁻¹ r`; its energy `−p·r` says how far the point is from balance, whatever the units
//! and however slender the body.
//!
//! The first form takes the stress of the tangent for an unknown of its own (Magisano, Leonetti and
//! Garcea 2017): `K = c GᵀG + 2 E₂(·,·)ᵀ σ`, with `σ` the stress that the last correction would have given,
//! were strain linear along it. A correction that turns a slender body stretches it too; the stress of that
//! stretch is large and wrong, and the linear one is not. Corrections are made whole.
//!
//! The second form, where the first one fails, has the true stress and a line search: the step along `p` is
//! cut where the slope `p·r` changes its sign, until the slope is half of what it was.
//!
//! If a tangent is not positive definite, the first form stops; the second one leaves compression out of
//! it, so that `p` still goes downhill.

use super::balance::Balance;
use super::space::{MotionSpace, SpaceFactor};
use super::vectors::{dot, sum};
use crate::fem::FactorError;

/// When Newton's method ends, and when it factorises anew.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Newton {
    /// Energy of the last correction as a part of the energy, its root: the correction itself is still made.
    pub tolerance: f64,
    /// Most corrections.
    pub iterations: usize,
    /// A factor is used again while each correction is at most this part of the one before; with 0 only the
    /// first correction of a time step has an old one. At 0.1 a step of 8 000 dofs takes a quarter of the
    /// factorisations, two fifths more corrections, and half of the time.
    pub keep: f64,
}

impl Default for Newton {
    fn default() -> Self {
        Self { tolerance: 1e-8, iterations: 30, keep: 0.1 }
    }
}

/// Cost of a solution.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct NewtonWork {
    /// The relative size of each correction.
    pub(crate) corrections: Vec<f64>,
    pub(crate) factorisations: usize,
}

/// Newton's method stopped before its tolerance.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum NewtonStop {
    Unbalanced { residual: f64, iterations: usize },
    Factor(FactorError),
}

/// A correction of this size, as the root of the part of the energy, is nowhere near balance.
pub(super) const DIVERGED: f64 = 1e6;

/// A correction below this is rounding if the next one is no smaller.
pub(super) const ROUNDING: f64 = 1e-9;

impl Newton {
    /// Solves `r(δ) = 0` from the given `δ` by the first form, and if that fails and `search` is set by the
    /// second. `factor` is one to begin with, and afterwards the last one.
    pub(super) fn solve(
        &self,
        balance: &mut impl Balance,
        space: MotionSpace<'_>,
        factor: &mut Option<SpaceFactor>,
        increment: &mut Vec<f64>,
        search: bool,
    ) -> Result<NewtonWork, NewtonStop> {
        let start = increment.clone();
        let mut course = NewtonWork::default();
        match self.iterate(balance, space, factor, increment, true, &mut course) {
            Err(NewtonStop::Unbalanced { .. }) if search => {
                course.corrections.clear();
                *factor = None;
                *increment = start;
                self.iterate(balance, space, factor, increment, false, &mut course)?;
            }
            done => done?,
        }
        Ok(course)
    }

    /// One form: with a stress of its own, or with a line search.
    fn iterate(
        &self,
        balance: &mut impl Balance,
        space: MotionSpace<'_>,
        factor: &mut Option<SpaceFactor>,
        increment: &mut Vec<f64>,
        mixed: bool,
        course: &mut NewtonWork,
    ) -> Result<(), NewtonStop> {
        let n = increment.len();
        let mut memory = None;
        let mut r = vec![0.0; n];
        balance.predict(None);
        if mixed {
            balance.residual(&vec![0.0; n], &mut r);
            balance.predict(Some(increment));
        }
        balance.residual(increment, &mut r);
        let (mut first, mut previous) = (None, f64::INFINITY);
        for iteration in 0..self.iterations {
            let (p, size) = loop {
                let fresh = factor.is_none();
                let kept = match factor {
                    Some(kept) => kept,
                    None => {
                        course.factorisations += 1;
                        let made = factorise(balance, space, mixed).map_err(NewtonStop::Factor)?;
                        let Some(made) = made else {
                            return Err(NewtonStop::Unbalanced { residual: previous, iterations: iteration });
                        };
                        factor.insert(made)
                    }
                };
                let p = space.correction(kept, &r, &mut memory);
                let work = -dot(&p, &r);
                let reference = *first.get_or_insert(work) + balance.scale();
                let size = if work == 0.0 { 0.0 } else { (work / reference).sqrt() };
                // A factor of the step before is good for the first correction, and then as long as it pays.
                if fresh || iteration == 0 || size <= self.keep * previous || size <= self.tolerance {
                    break (p, size);
                }
                *factor = None;
            };
            course.corrections.push(size);
            if size.is_nan() || size > DIVERGED {
                return Err(NewtonStop::Unbalanced { residual: size, iterations: iteration + 1 });
            }
            let length = if mixed {
                balance.predict(Some(&p));
                increment.iter_mut().zip(&p).for_each(|(x, p)| *x += p);
                balance.residual(increment, &mut r);
                1.0
            } else {
                step(balance, increment, &p, &mut r)
            };
            if length == 1.0 && (size <= self.tolerance || size < ROUNDING && size >= 0.5 * previous) {
                return Ok(());
            }
            previous = size;
            if self.keep == 0.0 || length < 1.0 {
                *factor = None;
            }
        }
        Err(NewtonStop::Unbalanced { residual: previous, iterations: self.iterations })
    }
}

/// Goes along `p` and leaves `r` at the new point; the length of the step.
fn step(balance: &mut impl Balance, at: &mut Vec<f64>, p: &[f64], r: &mut [f64]) -> f64 {
    const TRIES: usize = 10;
    let start = dot(p, r);
    let from = at.clone();
    let (mut low, mut high) = ((0.0, start), (1.0, f64::NAN));
    let mut length = 1.0;
    for tried in 0..TRIES {
        *at = sum(&from, length, p);
        balance.residual(at, r);
        let slope = dot(p, r);
        // Downhill still, or nearly level: `start` is negative.
        if slope.abs() <= 0.5 * start.abs() || slope < 0.0 && length == 1.0 || tried + 1 == TRIES {
            break;
        }
        if slope < 0.0 {
            low = (length, slope);
        } else {
            high = (length, slope);
        }
        // Between the chord and the middle; a slope that is no number asks for a much shorter step.
        let chord = low.0 - low.1 * (high.0 - low.0) / (high.1 - low.1);
        length = if slope.is_finite() && chord.is_finite() {
            chord.clamp(low.0 + 0.1 * (high.0 - low.0), 0.5 * (low.0 + high.0))
        } else {
            high.0 = length;
            0.1 * length
        };
    }
    length
}

/// The factor of the tangent; without a line search `None` if it is not positive definite, with one that of a
/// tangent without compression.
fn factorise(
    balance: &impl Balance,
    space: MotionSpace<'_>,
    mixed: bool,
) -> Result<Option<SpaceFactor>, FactorError> {
    match space.factorise(balance.tangent(false)) {
        Err(FactorError::NotPositiveDefinite { .. }) if mixed => Ok(None),
        Err(FactorError::NotPositiveDefinite { .. }) => space.factorise(balance.tangent(true)).map(Some),
        done => done.map(Some),
    }
}
