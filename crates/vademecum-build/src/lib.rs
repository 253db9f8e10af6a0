//! The offline stage: mesh → model → snapshots → basis → vademecum → bytes.
//!
//! Read [`pipeline`] first: it is the whole build on one page. Each folder is a stage and hands a whole,
//! immutable value to the next; nothing flows back.

pub mod basis;
pub mod certificate;
pub mod chapter;
pub mod dynamics;
pub mod export;
pub mod fem;
pub mod field;
pub mod input;
pub mod linalg;
pub mod mesh;
pub mod parametric;
pub mod pipeline;
pub mod prepared;
pub mod progress;
pub mod report;
pub mod response;
pub mod separated;
pub mod store;

/// The dense matrix of the builder, column-major.
pub type Matrix = faer::Mat<f64>;

// The numbers worked out by hand on these pages are compiled and asserted by the documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/theory/1-one-oscillator.md")]
struct OneOscillator;

#[cfg(doctest)]
#[doc = include_str!("../../../docs/theory/5a-separation-by-hand.md")]
struct SeparationByHand;
