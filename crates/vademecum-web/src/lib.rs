//! The evaluator inside a web page: the exports (WebAssembly only) hand numbers and places in memory between
//! the page and a body of `vademecum-eval`.
//!
//! There is no allocator and no glue code. The page grows the module's memory, puts the file there, asks how
//! much a body needs, grows again and lends it: the same contract as on a machine without operating
//! system. The body's mechanics stay in `vademecum-eval`, so a page shows the evaluator's bits. What presses
//! the body is solved for here: [`tool`] is a rigid sphere that cannot enter it.
//!
//! Note: on every other machine this crate is an ordinary library without exports, so that the
//! workspace builds and tests it with the rest.
#![cfg_attr(target_arch = "wasm32", no_std)]

#[cfg(target_arch = "wasm32")]
mod exports;
mod friction;
pub mod message;
pub mod refusal;
pub mod tool;
mod vectors;
