//! Calibration: live parameters of a parametric model from measured histories, frequency responses and
//! natural frequencies.
//!
//! The measured numbers `d` and those of the file at parameters `θ` differ by `r(θ)`, each divided by the
//! deviation that noise and the error of the model explain. The estimate minimises `χ² = |r|²` over the box
//! by Gauss and Newton's method with Levenberg and Marquardt's damping; the derivatives are central
//! differences of files that are set anew. `(JᵀJ)⁻¹` is the covariance of the estimate, and the singular
//! values of `J` say what the data determine.
//!
//! Sources: Levenberg 1944; Marquardt 1963; Kelley 1999 (projection on bounds).

mod error;
mod experiment;
mod fit;
mod model;
mod pair;
mod problem;
mod report;

pub use error::CalibrateError;
pub use experiment::{Measurement, Noise, Source};
pub use fit::{CalibrateOptions, calibrate};
pub use pair::measurements;
pub use report::{Calibration, Direction, Estimate, Fit, Share};
