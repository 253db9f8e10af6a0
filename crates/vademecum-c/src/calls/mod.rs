//! The calls beyond the shortest loop, by subject.

/// Runs lines with a body, or refuses a null handle.
macro_rules! with {
    ($body:ident => $lines:expr) => {
        // SAFETY: as the caller of the function promises.
        match unsafe { Body::of_mut($body) } {
            Some($body) => $lines,
            None => VdmStatus::VDM_ARGUMENT,
        }
    };
}

mod about;
mod batch;
mod fields;
mod flight;
mod loads;
mod modal;
mod states;

pub use about::*;
pub use batch::*;
pub use fields::*;
pub use flight::*;
pub use loads::*;
pub use modal::*;
pub use states::*;
