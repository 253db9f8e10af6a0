//! The reduced coordinates of a body and their rates, `y = (ζ, Δt ζ̇, Δt² ζ̈)`, the last only where a time
//! scheme wants it, twice in lent memory: as they are, and where a step writes the new ones. The states of
//! both kinds of scene are made of them.

use crate::base::error::StepError;
use crate::base::lend::{Lender, Short};
use crate::base::options::Status;
use crate::base::scalar::Scalar;

/// Layout of the three parts of `y`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Parts {
    /// Number of parts; 2 without an acceleration.
    pub count: usize,
    /// Length of each.
    pub r: usize,
    /// From the start of one to the start of the next; at least `r`.
    pub stride: usize,
    /// Length of all with the padding that a kernel wants; at least `count stride`.
    pub padded: usize,
}

impl Parts {
    /// `true` if a step starts from an acceleration.
    const fn has_acceleration(&self) -> bool {
        self.count > 2
    }
}

/// Old and new `y`.
#[derive(Debug)]
pub(crate) struct Coordinates<'m, T> {
    parts: Parts,
    /// `Δt` \[s\] the velocity and acceleration are scaled by.
    pub time_step: f64,
    pub now: &'m mut [T],
    pub next: &'m mut [T],
    pub at_rest: bool,
    /// Neither stepped nor set since it was put at rest (and therefore still there): a load that is there at
    /// the first step has acted from its start on, so that step begins with the acceleration it demands.
    pub unstarted: bool,
}

impl<'m, T: Scalar> Coordinates<'m, T> {
    /// A body at rest.
    pub fn new(parts: Parts, time_step: f64, memory: &mut Lender<&'m mut [T]>) -> Result<Self, Short> {
        let (now, next) = (memory.take(parts.padded)?, memory.take(parts.padded)?);
        if parts.r > parts.stride || parts.count * parts.stride > parts.padded {
            return Err(Short { found: parts.padded, needed: parts.count * parts.stride.max(parts.r) });
        }
        now.fill(T::ZERO);
        next.fill(T::ZERO);
        Ok(Self { parts, time_step, now, next, at_rest: true, unstarted: parts.has_acceleration() })
    }

    /// `true` if a step starts from an acceleration.
    pub const fn has_acceleration(&self) -> bool {
        self.parts.has_acceleration()
    }

    /// Puts the body at rest, as a new one is.
    pub fn rest(&mut self) {
        self.come_to_rest();
        self.unstarted = self.parts.has_acceleration();
    }

    /// Lets a body that was stepped or set rest.
    pub fn come_to_rest(&mut self) {
        self.now.fill(T::ZERO);
        self.at_rest = true;
        self.unstarted = false;
    }

    /// Writes the state scaled by another `Δt` beside the current one.
    pub fn scale_to(&mut self, time_step: f64) -> Result<(), StepError> {
        let ratio = time_step / self.time_step;
        self.next.iter_mut().zip(&*self.now).for_each(|(next, &now)| *next = now);
        let stride = self.parts.stride;
        let parts = self.next.chunks_exact_mut(stride.max(1)).take(self.parts.count).skip(1);
        for (part, factor) in parts.zip([ratio, ratio * ratio]) {
            part.iter_mut().for_each(|value| *value = T::from_f64(value.to_f64() * factor));
        }
        if self.next.iter().all(|value| value.in_range()) { Ok(()) } else { Err(StepError::NotFinite) }
    }

    /// Takes what was written beside the state, scaled by `time_step`.
    pub fn accept(&mut self, time_step: f64) {
        core::mem::swap(&mut self.now, &mut self.next);
        self.time_step = time_step;
    }

    /// Takes the new state written beside the old one, of the given `Σ|y|`; an unloaded one that is small
    /// enough rests.
    #[inline(always)]
    pub fn settle(&mut self, magnitude: T, loaded: bool, rest_below: T) -> Result<Status, StepError> {
        if !magnitude.in_range() {
            return Err(StepError::NotFinite);
        }
        core::mem::swap(&mut self.now, &mut self.next);
        (self.at_rest, self.unstarted) = (false, false);
        if !loaded && magnitude <= rest_below {
            self.come_to_rest();
            return Ok(Status::AtRest);
        }
        Ok(Status::Moving)
    }

    /// Part 0, 1 or 2 of `y`, length `r`; empty for a part that is not there.
    pub fn part(&self, place: usize) -> &[T] {
        if place >= self.parts.count {
            return &[];
        }
        let start = place * self.parts.stride;
        // `new` has seen that all of them fit.
        self.now.get(start..start + self.parts.r).unwrap_or(&[])
    }

    /// [`Coordinates::part`] to be written.
    pub fn part_mut(&mut self, place: usize) -> &mut [T] {
        if place >= self.parts.count {
            return &mut [];
        }
        let start = place * self.parts.stride;
        self.now.get_mut(start..start + self.parts.r).unwrap_or(&mut [])
    }

    /// Copies `y` to `out`, as long as all parts. The sign of the last number, a zero, tells a body that has
    /// not started yet.
    pub fn save_into(&self, out: &mut [T]) -> Result<(), StepError> {
        if out.len() != self.parts.count * self.parts.r {
            return Err(StepError::Mismatch);
        }
        for (place, out) in out.chunks_exact_mut(self.parts.r.max(1)).enumerate() {
            out.iter_mut().zip(self.part(place)).for_each(|(out, &value)| *out = value);
        }
        if let Some(last) = out.last_mut().filter(|_| self.unstarted) {
            *last = T::from_f64(-0.0);
        }
        Ok(())
    }

    /// Takes back what [`Coordinates::save_into`] wrote.
    pub fn restore(&mut self, saved: &[T]) -> Result<(), StepError> {
        let r = self.parts.r;
        if saved.len() != self.parts.count * r {
            return Err(StepError::Mismatch);
        }
        if !saved.iter().all(|value| value.in_range()) {
            return Err(StepError::NotFinite);
        }
        for (place, part) in saved.chunks_exact(r.max(1)).enumerate() {
            self.part_mut(place).iter_mut().zip(part).for_each(|(out, &value)| *out = value);
        }
        (self.at_rest, self.unstarted) = (false, false);
        if saved.iter().all(|&value| value == T::ZERO) {
            self.come_to_rest();
            self.unstarted = self.parts.has_acceleration();
            self.unstarted &= saved.last().is_some_and(|last| last.to_f64().is_sign_negative());
        }
        Ok(())
    }

    /// The first parts of the new `y`, each of length `r`.
    pub fn next_parts<const N: usize>(&mut self) -> Result<[&mut [T]; N], Short> {
        let Parts { count, r, stride, padded } = self.parts;
        if N > count {
            return Err(Short { found: padded, needed: N * stride });
        }
        let mut next = Lender::new(&mut *self.next);
        let mut parts = [const { None }; N];
        for part in &mut parts {
            *part = Some(Lender::new(next.take(stride)?).take(r)?);
        }
        Ok(parts.map(Option::unwrap_or_default))
    }
}
