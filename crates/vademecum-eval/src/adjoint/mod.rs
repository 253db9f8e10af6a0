//! Gradients of a march: its adjoint, the same step by the transposed map, backwards in time.

pub(crate) mod batch;
#[cfg(feature = "parametric")]
pub(crate) mod blocks;
pub(crate) mod body;
pub(crate) mod cotangents;
pub(crate) mod error;
pub(crate) mod march;
#[cfg(feature = "parametric")]
pub(crate) mod modal;
#[cfg(feature = "parametric")]
pub(crate) mod parameters;
pub(crate) mod rows;
pub(crate) mod shown;
pub(crate) mod surface;
pub(crate) mod transposed;
