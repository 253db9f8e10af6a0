//! Separated solutions: a parametric field as a sum of products of one-dimensional functions.
//!
//! A solution over axes `μ_1 … μ_d` is kept as `u(μ) = Σ_i (Π_a g_ia(μ_a)) F_i`, with factors `g_ia` on one
//! axis each and blocks `F_i` of a few columns over space. Nothing is solved when it is looked up: a point
//! costs one basis evaluation per axis and one weighted sum. Everything here works on plain matrices; meshes
//! and finite elements stay outside.
//!
//! # From samples to terms
//!
//! A build with live parameters goes this way, because its problem in space is small once it is
//! compressed:
//!
//! 1. An [`Axis`] is one parameter with its unit, its range and the functions that live on it.
//! 2. [`SampledBlocks::collect`] calls a solver at points of the box that the axes span: at the whole grid
//!    when it is small, else at the points that belong to the lowest polynomial degrees.
//! 3. An [`Expansion`] is the polynomial through these samples, weighted so that errors are relative.
//! 4. [`fit()`] finds the terms of a [`Separated`] solution from the coefficients of the polynomial, by
//!    alternating least squares. It stops at a tolerance, at a number of terms, or when further terms do not
//!    help, and an [`EnrichmentReport`] says which.
//!
//! The other way needs no samples: [`enrich()`] solves a [`KroneckerProblem`] for its terms by alternating
//! directions (chapter eqs. 5.11–5.13), with an optional update of all factors after each term. The chapter's
//! own representation is built on it (the crate `vademecum-chapter`), and
//! docs/explanation/5a-separation-by-hand.md works it by hand.
//!
//! Note: every dense kernel runs sequentially, and threads only solve independent samples, so the
//! bytes that come out depend on the seed and not on the number of threads.
//!
//! # One oscillator, two parameters
//!
//! `(1 + θκ) x = −θκ` is the increment problem of a unit mass on a unit spring: `x = h − 1` with
//! `h = 1/(1 + θκ)`. As a function of `θ` and `κ` it is no product, but it is a short sum of products:
//!
//! ```
//! use faer::Mat;
//! use vademecum_build::separated::*;
//!
//! // Two axes of twelve Chebyshev points each, on ln θ and ln κ.
//! let log = |name: &str, low, high| Axis::new(name, "1", low, high, AxisKind::Chebyshev { points: 12 },
//! true); let axes = [log("theta", 0.1, 1.0)?, log("kappa", 0.5, 2.0)?];
//!
//! // The solver: a block of 1 × 1 for a point (θ, κ). The grid has 144 points, so all of them are samples.
//! let solve = |point: &[f64]| {
//!     let x = point[0] * point[1];
//!     Ok(Mat::from_fn(1, 1, |_, _| -x / (1.0 + x)))
//! };
//! let samples = SampledBlocks::collect(&axes, 1000, None, solve)?;
//! assert!(samples.is_whole_grid());
//!
//! // Terms until they agree with the polynomial to 1e-6.
//! let options = EnrichmentOptions { tolerance: 1e-6, ..Default::default() };
//! let (x, report) = fit::<SeparatedError>(&Expansion::new(&samples), &options, None)?;
//! assert_eq!(report.stop, StopReason::Tolerance);
//! assert!(x.n_terms() <= 6);
//!
//! let h = 1.0 + x.evaluate(&[0.3, 1.25])?[(0, 0)];
//! assert!((h - 1.0 / (1.0 + 0.3 * 1.25)).abs() < 1e-5);
//! assert!(x.evaluate(&[0.3, 2.5]).is_err()); // never clamped
//! # Ok::<(), SeparatedError>(())
//! ```

mod axis;
mod compress;
mod enrich;
mod error;
mod expansion;
mod fit;
mod greedy;
mod kronecker;
mod linalg;
mod lower_set;
mod operator;
mod regions;
mod solution;
mod space;
mod update;

pub(crate) use axis::chebyshev_points;
pub use axis::{Axis, AxisKind};
pub(crate) use compress::compress;
pub use compress::{Energy, EnergyBasis};
pub use enrich::enrich;
pub use error::{SeparatedError, check_len};
pub use expansion::{Expansion, SampledBlocks};
pub use fit::fit;
pub use greedy::{EnrichmentOptions, EnrichmentReport, StopReason};
pub use kronecker::{KroneckerProblem, Source};
pub use linalg::{product, transposed_product};
pub use operator::AxisOperator;
pub(crate) use regions::RegionAxes;
pub use solution::Separated;
pub use space::{DenseSpace, Space};

#[cfg(test)]
mod fit_tests;
#[cfg(test)]
mod surrogate;
#[cfg(test)]
mod tests;
