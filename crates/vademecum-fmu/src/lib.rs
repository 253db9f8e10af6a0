//! A vademecum file as a co-simulation unit: the entry points of FMI 2.0 and 3.0 over the evaluator.
//!
//! `vademecum export fmu` puts this library into an archive, beside a vademecum file (`resources/body.vdm`)
//! and a table of named points ([`points`]). A master instantiates it with the place of those resources. Both
//! versions of the interface ([`fmi2`], [`fmi3`]) are thin over one [`instance`]; which variable a value
//! reference means is the same list here and in the exporter ([`variables`]).
//!
//! # Notes
//!
//! The library of an archive is built without std (feature `bare`). It takes memory and files from the C
//! library that every host has, in the version of 2002 or any later one, and it links only if no panic can be
//! reached: the handler of panics calls a function that is defined nowhere. Built any other way, for another
//! platform or a test, a panic would be caught at the boundary.
#![cfg_attr(feature = "bare", no_std)]

mod acting;
mod body;
mod boundary;
mod bytes;
mod course;
mod flight;
pub mod fmi2;
pub mod fmi3;
pub mod instance;
pub mod location;
pub mod logger;
mod memory;
pub mod mode;
mod names;
mod outputs;
mod parameters;
pub mod points;
pub mod refusal;
mod room;
mod saved;
mod sensitivity;
pub mod token;
mod values;
pub mod variables;
pub mod watch;
pub mod words;

pub use parameters::{parameter, whole};
pub use room::options;

#[cfg(feature = "bare")]
mod bare {
    #![allow(unsafe_code)]

    unsafe extern "C" {
        /// Defined nowhere: left in the library exactly when a panic is reachable, and then it does not link.
        fn a_panic_is_reachable() -> !;
    }

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
        // SAFETY: never called; a library that could call it does not link.
        unsafe { a_panic_is_reachable() }
    }
}
