//! A communication step that is taken one internal step at a time: between them the master may read
//! variables, and end the step where it is.
//!
//! Nothing of the instance is borrowed while the master is called, since it calls back.

use crate::body::LastStep;
use crate::instance::Instance;
use crate::memory::Block;
use crate::mode::Mode;
use crate::refusal::Trouble;

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
    /// True if the body was inside of its training before the last internal step.
    was_inside: bool,
    /// True if it left it in that step.
    leaves: bool,
    /// Time from which on the master wants the step to end \[s\].
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
        !self.is_done() && (self.leaves || self.time() >= self.ends_at)
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
        let (taken, leaves, ends_at) = (0, false, f64::INFINITY);
        Ok(Some(Course { point, end, steps, taken, length, start, first, was_inside, leaves, ends_at }))
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
            course.leaves = course.was_inside && !is_inside;
            course.was_inside = is_inside;
        }
        Ok(())
    }
}
