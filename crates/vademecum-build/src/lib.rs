//! The offline half: reads a mesh and a problem, and computes the bytes of a vademecum file.
//!
//! # Should I use this crate?
//!
//! Yes, if your own program makes vademecum files: a design sweep, a tool that meshes and builds in one go, a
//! study of the method. No, if you want to
//!
//! - make one file from a problem: that is the program `vademecum build`;
//! - step a file: that is the crate `vademecum-eval`, which is small and needs none of this;
//! - pack, strip or compare files: those are the crates `vademecum-rewrite` and `vademecum-study`.
//!
//! # The flow
//!
//! ```text
//! problem ──► prepare ──► find_basis ──► stage_responses ──────┐
//!   mesh       model        modes        separate_responses ───┤ over live parameters
//!                                                              ▼
//!                          certificate ◄── evaluator ◄──── encode ──► bytes
//! ```
//!
//! [`pipeline`] is this picture as a program, on one page. Each folder is a stage and hands a whole,
//! immutable value to the next; nothing flows back.
//!
//! # Three paths
//!
//! **From a problem to a file**: [`Problem::read`](input::Problem::read) or
//! [`parse`](input::Problem::parse), [`build`](pipeline::build), [`Outcome::kept`](pipeline::Outcome::kept),
//! [`write_atomic`](store::write_atomic).
//!
//! ```
//! use vademecum_build::input::Problem;
//! use vademecum_build::pipeline::{BuildOptions, build};
//! use vademecum_build::progress::Silent;
//!
//! let text = r#"
//! [mesh]
//! block = { lengths = [1.0, 0.1, 0.1], divisions = [8, 1, 1], order = "quadratic" }
//! [[material]]
//! young = 2.1e9
//! poisson = 0.3
//! density = 1200.0
//! [[support]]
//! on = { group = "x_min" }
//! [load]
//! surface = { group = "z_max" }
//! [time]
//! scheme.name = "bathe"
//! step = 1e-3
//! [basis]
//! modes = 4
//! "#;
//! let problem = Problem::parse(text, "beam.toml", std::path::PathBuf::new())?;
//! let built = build(&problem, &BuildOptions::default(), &Silent)?.kept()?;
//! // The first bending mode of a cantilever: 3.516/2π √(E I/ρ A)/l², here 21.4 Hz and a little less for shear.
//! assert!((built.report.mode_table[0].frequency_hz / 21.4 - 1.0).abs() < 0.02);
//! assert!(built.bytes.len() == built.report.file_bytes);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! **One stage by itself**: [`prepare`](prepared::prepare) gives the [`Prepared`](prepared::Prepared) model;
//! from there [`lowest_modes`](dynamics::lowest_modes) finds natural modes, and
//! [`full_order`](prepared::Prepared::full_order) with
//! [`march_full_order`](dynamics::march_full_order) marches loads.
//!
//! **What a file promises**: [`measure`](certificate::measure) marches unseen loads through the evaluator
//! against the full-order model, for any number of files at once.

pub mod basis;
pub mod certificate;
pub mod dynamics;
pub mod export;
pub mod fem;
pub mod field;
pub mod input;
pub mod large;
pub mod limits;
pub mod linalg;
pub mod measured;
pub mod mesh;
pub mod mesh_error;
pub mod parallel;
pub mod parametric;
pub mod pipeline;
pub mod prepared;
pub mod printable;
pub mod progress;
pub mod reaction;
pub mod report;
pub mod residual;
pub mod response;
pub mod separated;
pub mod store;
pub mod suggest;
pub mod superelement;

/// The dense matrix of the builder, column-major.
pub type Matrix = faer::Mat<f64>;

// The numbers worked out by hand on these pages are compiled and asserted by the documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/explanation/1-one-oscillator.md")]
struct OneOscillator;

#[cfg(doctest)]
#[doc = include_str!("../../../docs/explanation/5a-separation-by-hand.md")]
struct SeparationByHand;

#[cfg(doctest)]
#[doc = include_str!("../../../docs/explanation/7-exact-steps.md")]
struct ExactSteps;

#[cfg(doctest)]
#[doc = include_str!("../../../docs/explanation/large-displacements-reduced.md")]
struct LargeDisplacementsReduced;
