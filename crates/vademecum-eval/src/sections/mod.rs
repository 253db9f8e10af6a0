//! Sections of a file as views: rows of the basis, the surface, stress, supports, residual flexibility.

pub(crate) mod axes;
pub(crate) mod contact;
pub(crate) mod embedded;
pub(crate) mod factor;
pub(crate) mod filter;
#[cfg(feature = "mmap")]
pub(crate) mod mmap;
pub(crate) mod place;
pub(crate) mod quadrangle;
pub(crate) mod quantised;
pub(crate) mod reconstruct;
pub(crate) mod residual;
pub(crate) mod rows;
pub(crate) mod short_rows;
pub(crate) mod stress_rows;
pub(crate) mod supports;
pub(crate) mod surface;
