//! The callback of a master that watches steps from inside.
#![allow(unsafe_code)]

use core::ffi::c_void;

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
