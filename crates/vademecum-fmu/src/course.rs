//! A communication step that is taken one internal step at a time: between them the master may read
//! variables, and end the step where it is.
//!
//! Nothing of the instance is borrowed while the master is called, since it calls back.
#![allow(unsafe_code)]

use core::ffi::c_void;

use crate::body::LastStep;
use crate::instance::{Instance, Mode};
use crate::memory::Block;
use crate::refusal::Trouble;

/// `fmi3IntermediateUpdateCallback`: environment, time, four flags (values may be set, values may be read,
/// the internal step has ended, the step may end here), and the answer of the master: end the step, and when.
pub type IntermediateUpdate = unsafe extern "C" fn(*mut c_void, f64, u8, u8, u8, u8, *mut u8, *mut f64);

/// Watch of a master over the steps of an instance.
#[derive(Clone, Copy, Debug)]
pub struct Watch {
    /// Its callback.
    pub update: Option<IntermediateUpdate>,
    /// First argument of the callback.
    pub environment: *mut c_void,
    /// True if a step may end early.
    pub early_return: bool,
}

impl Watch {
    /// No watch: steps are taken as a whole.
    pub const NONE: Self = Self { update: None, environment: core::ptr::null_mut(), early_return: false };

    /// Tells the master of the end of an internal step; the time at which it wants the step to end, if it
    /// does.
    ///
    /// # Safety
    /// The callback may be called with its environment.
    pub unsafe fn tell(&self, time: f64, is_last: bool) -> Option<f64> {
        let can_return = self.early_return && !is_last;
        let (mut requested, mut at) = (0, time);
        // SAFETY: as the caller promises; both places are there until it returns.
        unsafe {
            self.update?(
                self.environment,
                time,
                0,
                1,
                1,
                u8::from(can_return),
                &raw mut requested,
                &raw mut at,
            );
        }
        (can_return && requested != 0).then_some(at)
    }
}

/// Way through a communication step.
#[derive(Debug)]
pub struct Course {
    /// Communication point \[s\], and the end of the communication step.
    point: f64,
    end: f64,
    /// Internal steps, those taken, and the length of each \[s\].
    steps: u64,
    taken: u64,
    length: f64,
    /// Everything at the communication point, for a step that is refused later.
    start: Block,
    /// The first internal step.
    first: LastStep,
    /// True if the body was inside of its training.
    was_inside: bool,
    /// Time from which on the step ends \[s\].
    ends_at: f64,
}

impl Course {
    /// Time of the instance \[s\].
    #[must_use]
    pub fn time(&self) -> f64 {
        if self.is_done() { self.end } else { self.point + self.taken as f64 * self.length }
    }

    /// True at the end of the communication step.
    #[must_use]
    pub const fn is_done(&self) -> bool {
        self.taken >= self.steps
    }

    /// Ends the step at the first internal step from a time on.
    pub const fn end_at(&mut self, time: f64) {
        // A millionth of a step is no time.
        self.ends_at = time - 1e-6 * self.length;
    }

    /// True where the step ends before its end.
    #[must_use]
    pub fn ends_here(&self) -> bool {
        !self.is_done() && self.time() >= self.ends_at
    }
}

impl Instance {
    /// Begins a communication step that the master watches; `None` if nobody does.
    ///
    /// # Errors
    /// As [`Instance::advance`].
    pub fn depart(&mut self, point: f64, size: f64) -> Result<Option<Course>, Trouble> {
        let watch = self.watch();
        let has_limit = watch.early_return && self.body().can_leave_training();
        if watch.update.is_none() && !has_limit {
            return Ok(None);
        }
        let (steps, length, end) = self.plan(point, size)?;
        let (start, first) = (self.save()?, LastStep::default());
        let was_inside = !has_limit || self.body().is_inside_training();
        self.go(Mode::Intermediate);
        let ends_at = f64::INFINITY;
        Ok(Some(Course { point, end, steps, taken: 0, length, start, first, was_inside, ends_at }))
    }

    /// Takes one internal step.
    ///
    /// # Errors
    /// [`Trouble`]; the instance is then at the communication point again.
    pub fn proceed(&mut self, course: &mut Course) -> Result<(), Trouble> {
        if let Err(refusal) = self.body_mut().step(1, course.length) {
            self.restore(course.start.bytes())?;
            return Err(refusal.into());
        }
        if course.taken == 0 {
            course.first = self.body().last_step();
        }
        course.taken = course.taken.saturating_add(1);
        self.body_mut().join_steps(LastStep { steps: course.taken, ..course.first });
        self.arrive(course.time());
        if self.watch().early_return && self.body().can_leave_training() {
            let is_inside = self.body().is_inside_training();
            if course.was_inside && !is_inside {
                course.end_at(course.time());
            }
            course.was_inside = is_inside;
        }
        Ok(())
    }
}
