//! The C interface of the evaluator: opaque handles over lent memory.
//!
//! A caller asks how many bytes a body needs ([`vdm_measure`]), lends them ([`vdm_bind`]), and from then on
//! drives the body through its handle. Every call checks its pointers for null and its lengths; it answers
//! with a [`VdmStatus`], and [`vdm_message`] says in words what was wrong with the last call of a body.
//! Numbers cross the boundary as `double`, whatever the precision of the march. A handle is an
//! [`AnyBody`](vademecum_eval::AnyBody) and a message; the calls are those of the body.
//!
//! Note: a body holds references into memory that C owns. Their lifetime is written as `'static`
//! here, and the caller keeps the promise: file and memory stay where they are, unchanged, for as long as the
//! handle is used.
#![allow(unsafe_code)]
// Names are those of the header.
#![allow(non_camel_case_types)]
#![cfg_attr(not(feature = "std"), no_std)]

mod batch;
mod calls;
mod handle;
mod message;
mod refusal;
mod slices;
mod types;
#[cfg(feature = "world")]
mod world;
#[cfg(feature = "world")]
mod world_types;

pub use calls::*;
pub use types::*;
#[cfg(feature = "world")]
pub use world_types::*;

/// No panic is reachable from the calls. Without an operating system there must be a handler nevertheless,
/// and it stops.
#[cfg(not(any(feature = "std", test)))]
#[panic_handler]
fn stop(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
