//! The offline stage: mesh → model → snapshots → basis → vademecum → bytes.
//!
//! Read [`pipeline`] first: it is the whole build on one page. Each folder is a stage and hands a whole, immutable
//! value to the next; nothing flows back.

pub mod bench;
pub mod body;
pub mod canonical;
pub mod certificate;
pub mod compare;
pub mod dynamics;
pub mod export;
pub mod fem;
pub mod field;
pub mod march;
pub mod mesh;
pub mod parametric;
pub mod pipeline;
pub mod pod;
pub mod problem;
pub mod progress;
pub mod reduced;
pub mod report;
pub mod response;
pub mod resume;
pub mod rewrite;
pub mod scenario;
pub mod separated;
pub mod snapshots;
pub mod target;
pub mod toml_file;

/// The dense matrix of the builder, column-major.
pub type Matrix = faer::Mat<f64>;

// The numbers worked out by hand on these pages are compiled and asserted by the documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/theory/1-one-oscillator.md")]
struct OneOscillator;

#[cfg(doctest)]
#[doc = include_str!("../../../docs/theory/5a-separation-by-hand.md")]
struct SeparationByHand;
