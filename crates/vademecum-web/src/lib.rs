//! The evaluator inside a web page: the exports (WebAssembly only) hand numbers and places in memory between
//! the page and a body of `vademecum-eval`, or a world of several (feature `world`, a module of its own).
//!
//! There is no glue code, and in the module of one body no allocator. The page grows the module's memory,
//! puts the file there, asks how much a body needs, grows again and lends it: the same contract as on a
//! machine without operating system. The mechanics stay in `vademecum-eval`, so a page shows the
//! evaluator's bits. What presses and pulls is solved for here: [`tool`] is a rigid sphere that cannot enter
//! the body, [`stage`] a world with the hands of a page on it.
//!
//! Note: on every other machine this crate is an ordinary library without exports, so that the
//! workspace builds and tests it with the rest.
#![cfg_attr(target_arch = "wasm32", no_std)]

#[cfg(feature = "world")]
extern crate alloc;

#[cfg(all(target_arch = "wasm32", not(feature = "world")))]
mod exports;
mod friction;
pub mod message;
#[cfg(feature = "world")]
pub mod pull;
pub mod refusal;
#[cfg(feature = "world")]
pub mod stage;
#[cfg(feature = "world")]
pub mod strikes;
pub mod tool;
mod vectors;
#[cfg(all(target_arch = "wasm32", feature = "world"))]
mod world_exports;
