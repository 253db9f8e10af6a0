//! Separated solutions: a parametric field as a sum of products of one-dimensional functions.
//!
//! A solution over axes `μ_1 … μ_d` is kept as `u(μ) = Σ_i (Π_a g_ia(μ_a)) F_i`, with factors `g_ia` on one axis each and
//! blocks `F_i` of a few columns over space. Nothing is solved when it is looked up: a point costs one basis evaluation
//! per axis and one weighted sum. Everything here works on plain matrices; meshes and finite elements stay outside.
//!
//! Four ways lead to such a sum, and they share [`Separated`], [`EnrichmentOptions`] and [`EnrichmentReport`]:
//!
//! - [`enrich()`] solves a [`Problem`], a sum of Kronecker operators, by greedy alternating directions (chapter
//!   eqs. 5.11–5.13) with an optional Galerkin update of all factors after each term;
//! - [`fit()`] finds the terms of an [`Expansion`] of sampled solutions by alternating least squares, which is cheaper when
//!   the small problem can simply be solved at every sample;
//! - [`BlockProblem`] is the family `(Σ_t c_t(μ) S_t) X = Σ_s c_s(μ) B_s` of the block representation, reduced in space
//!   by [`reduce()`] before it is separated;
//! - [`canonical`] is the chapter's own representation, state coordinates and load as axes.
//!
//! The odd thing: every dense kernel runs sequentially, and threads only solve independent samples, so the bytes that
//! come out depend on the seed and not on the number of threads.
//!
//! # One oscillator, two parameters
//!
//! `(1 + θ κ) x = −θ κ` is the increment problem of a unit mass on a unit spring: `x = h − 1` with `h = 1/(1 + θ κ)`.
//! As a function of `θ` and `κ` it is no product, but a short sum of products:
//!
//! ```
//! use faer::Mat;
//! use vademecum_build::separated::*;
//!
//! let log = |name: &str, low, high| Axis::new(name, "1", low, high, AxisKind::Chebyshev { points: 12 }, true);
//! let axes = vec![log("theta", 0.1, 1.0)?, log("kappa", 0.5, 2.0)?];
//! let one = Mat::from_fn(1, 1, |_, _| 1.0);
//! let space = DenseSpace::new(vec![one.clone(), one.clone()])?; // M = 1, K = 1
//! // the mass has the exponents θ⁰κ⁰, the spring θ¹κ¹
//! let problem = BlockProblem::increment(axes, &[vec![0.0, 0.0]], &[vec![1.0, 1.0]], space, one.as_ref())?;
//!
//! let options = EnrichmentOptions { tolerance: 1e-6, ..Default::default() };
//! let (x, report) = problem.separate(1000, &options, None)?;
//! assert_eq!(report.stop, StopReason::Tolerance);
//! assert!(x.n_terms() <= 6);
//!
//! let h = 1.0 + x.evaluate(&[0.3, 1.25])?[(0, 0)];
//! assert!((h - 1.0 / (1.0 + 0.3 * 1.25)).abs() < 1e-5);
//! assert!(x.evaluate(&[0.3, 2.5]).is_err()); // never clamped
//! # Ok::<(), SeparatedError>(())
//! ```

pub(crate) mod axis;
mod block;
pub(crate) mod enrich;
pub(crate) mod error;
mod expansion;
mod fit;
pub(crate) mod linalg;
mod lower_set;
pub(crate) mod problem;
mod recompress;
pub(crate) mod reduce;
mod regions;
pub(crate) mod solution;
mod update;

pub(crate) use axis::chebyshev_points;
pub use axis::{Axis, AxisKind};
pub use block::{BlockProblem, BlockSource, FreshPoints};
pub use enrich::{EnrichmentOptions, EnrichmentReport, StopReason, enrich};
pub use error::SeparatedError;
pub use expansion::{Expansion, SampledBlocks};
pub use fit::{Measure, fit};
pub use problem::{AxisOperator, DenseSpace, Problem, Source, Space, SparseSpace};
pub use recompress::recompress;
pub use reduce::{Energy, Reduction, ReductionOptions, compress, reduce};
pub use regions::RegionAxes;
pub use solution::Separated;

#[cfg(test)]
mod block_tests;
#[cfg(test)]
pub(crate) mod surrogate;
#[cfg(test)]
mod tests;
