//! Separated solutions: a parametric field as a sum of products of one-dimensional functions.
//!
//! A solution over axes `μ_1 … μ_d` is kept as `u(μ) = Σ_i (Π_a g_ia(μ_a)) F_i`, with factors `g_ia` on one axis each and
//! blocks `F_i` of a few columns over space. Nothing is solved when it is looked up: a point costs one basis evaluation
//! per axis and one weighted sum. Everything here works on plain matrices; meshes and finite elements stay outside.
//!
//! Four ways lead to such a sum, and they share [`Separated`], [`EnrichmentOptions`] and [`EnrichmentReport`]:
//!
//! - [`enrich`] solves a [`Problem`], a sum of Kronecker operators, by greedy alternating directions (chapter
//!   eqs. 5.11–5.13) with an optional Galerkin update of all factors after each term;
//! - [`fit`] finds the terms from sampled solutions by alternating least squares, which is cheaper when the small
//!   problem can simply be solved at every sample;
//! - [`BlockProblem`] is the family `(Σ_t c_t(μ) S_t) X = Σ_s c_s(μ) B_s` of the block representation, reduced in space
//!   by [`reduce`] before it is separated;
//! - [`canonical`] is the chapter's own representation, state coordinates and load as axes.
//!
//! The odd thing: every dense kernel runs sequentially, and threads only solve independent samples, so the bytes that
//! come out depend on the seed and not on the number of threads.

mod axis;
mod block;
pub mod canonical;
mod enrich;
mod error;
mod fit;
mod linalg;
mod problem;
mod recompress;
mod regions;
mod reduce;
mod solution;
mod update;

pub use axis::{Axis, AxisKind};
pub use block::{BlockProblem, BlockSource, FreshPoints};
pub use enrich::{EnrichmentOptions, EnrichmentReport, StopReason, enrich};
pub use error::SeparatedError;
pub use fit::{SampledBlocks, fit};
pub use linalg::Random;
pub use problem::{AxisOperator, DenseSpace, Problem, Source, Space, SparseSpace};
pub use recompress::recompress;
pub use regions::RegionAxes;
pub use reduce::{Energy, Reduction, ReductionOptions, compress, reduce};
pub use solution::Separated;

#[cfg(test)]
mod block_tests;
#[cfg(test)]
mod canonical_tests;
#[cfg(test)]
mod surrogate;
#[cfg(test)]
mod tests;
