//! Inputs and outcome of a march of a method.

use vademecum_build::Matrix;
use vademecum_build::dynamics::TimedLoad;
use vademecum_study::player::Track;

/// A march in coordinates `(r, instants)`, or why there is none.
pub(super) type ChapterMarch = Result<Matrix, String>;

/// Inputs of a march of a method.
#[derive(Clone, Copy)]
pub(super) struct March<'a> {
    /// The scenario, as files take it.
    pub track: &'a Track,
    /// The scenario, as solvers without a file take it.
    pub loads: &'a [TimedLoad],
    /// Δt \[s\], for files only: a solver has its own.
    pub time_step: f64,
    /// Steps.
    pub steps: usize,
    /// Every so many instants are kept.
    pub stride: usize,
}
