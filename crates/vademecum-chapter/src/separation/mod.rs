//! The chapter's representation: state coordinates, load magnitude and load position as axes (eqs. 5.8–5.13).
//!
//! One stage of the scheme solves `A u = Σ_j x_j b_j + p f(s)`: every reduced coordinate `x_j` (ζ, ζ̇, and ζ̈
//! or ζ½) is an axis with hat functions, `b_j` is its column `(h_M M + h_K K) φ_j` (the chapter prints a ones
//! vector for φ_j), `p` and `s` are the load's magnitude and position, and the load's components are axes too
//! when asked for. The unknown is a sum of rank-one terms over all of them. `A = m M + k K` is one matrix,
//! and on the parameter axes only mass matrices appear, so every space solve of eq. (5.12) is with the same
//! factor, and every space function lies in the span of the `A⁻¹ b`: the engine runs in that span. Its
//! iterates are those of the full mesh up to rounding, at no cost in `n`.
//!
//! Note: the map is linear in the state, so one term per right-hand side is exact, and greedy does
//! not find them. The repairs of docs/explanation/5-vademecum.md are switches of [`ChapterOptions`] so that
//! the effect of each can be shown.

mod fresh;
mod inputs;
mod stage;

pub use stage::{ChapterStage, StageError, StateFamily};

use faer::Mat;
use fresh::Fresh;
use inputs::{Inputs, Span};
use vademecum_build::separated::Axis;
use vademecum_build::separated::Energy;
use vademecum_build::separated::Separated;
use vademecum_build::separated::Space;
use vademecum_build::separated::enrich;
use vademecum_build::separated::{EnrichmentOptions, EnrichmentReport};
use vademecum_build::separated::{SeparatedError, check_len};

/// Remedies for the chapter's weaknesses; with everything off it is the chapter.
#[derive(Clone, Debug, PartialEq)]
pub struct ChapterOptions {
    /// Axes in `(ζ, Δt ζ̇, Δt² ζ̈)`. Makes the numbers comparable for rounding and `f32`; a change of units
    /// alone does not change which terms are found.
    pub scaled_coordinates: bool,
    /// State and load separated apart, each to the tolerance relative to itself.
    pub separate_blocks: bool,
    /// Start from the one-axis terms, one per right-hand side with its own functions and its own space solve,
    /// the largest `max_terms` of them, and enrich from there. Nothing is left to find when there is room for
    /// all.
    pub one_axis_start: bool,
    /// Tolerance, limits and updates of the engine. `max_terms` counts both blocks together.
    pub enrichment: EnrichmentOptions,
}

/// Terms over some of the axes of a stage.
#[derive(Clone, Debug)]
pub struct SeparatedPart {
    /// Which axes of [`SeparatedStage::axes`].
    pub axes: std::ops::Range<usize>,
    /// The terms; blocks are coordinates in [`SeparatedStage::span`].
    pub solution: Separated,
}

/// A separated stage: the sum of its parts.
#[derive(Clone, Debug)]
pub struct SeparatedStage {
    /// Families in order, mode by mode; magnitude; components; position.
    pub axes: Vec<Axis>,
    /// All axes together, or state and load apart.
    pub parts: Vec<SeparatedPart>,
    /// `Q`, `(n_rows, k)`: what every space function is a combination of.
    pub span: Mat<f64>,
    /// Its error against the exact stage solve.
    pub error: StageError,
    /// Reports of the enrichments: one report, or state then load.
    pub reports: Vec<EnrichmentReport>,
}

/// Separates one stage. `space` has the one operator `A`; `energy` is the inner product errors are measured
/// in, the mass.
///
/// # Errors
/// As [`Axis::new`] for the ranges; [`SeparatedError::NotPositiveDefinite`] for `A`;
/// [`SeparatedError::Shape`].
pub fn separate<S: Space>(
    stage: &ChapterStage,
    space: &S,
    energy: &Energy<'_>,
    options: &ChapterOptions,
) -> Result<SeparatedStage, SeparatedError> {
    check_len("operators of a stage", 1, space.n_operators())?;
    let inputs = Inputs::new(stage, options.scaled_coordinates)?;
    let span = Span::new(space, &inputs.columns, energy)?;
    let fresh = Fresh::new(&inputs, &span, options.enrichment.seed);
    let parts = if options.separate_blocks {
        vec![inputs.state_part(), inputs.load_part()]
    } else {
        vec![inputs.all()]
    };
    let mut solution = Separated::zero(&inputs.axes, span.sources.nrows(), 1);
    let (mut found_parts, mut reports) = (Vec::new(), Vec::new());
    for (number, part) in parts.iter().enumerate() {
        let others: usize = parts.iter().skip(number + 1).map(|p| p.sources.len()).sum();
        let left = options.enrichment.max_terms.saturating_sub(solution.n_terms());
        let max_terms = left.saturating_sub(others).max(left.min(part.sources.len()));
        if max_terms == 0 || part.sources.is_empty() {
            continue;
        }
        let engine = EnrichmentOptions { max_terms, ..options.enrichment.clone() };
        let problem = part.problem(&inputs, &span)?;
        let points = fresh.of_part(part);
        let measure = |u: &Separated| points.error(u, &span);
        let start =
            if options.one_axis_start { Some(part.one_axis_terms(&inputs, &span, max_terms)?) } else { None };
        let (found, report) = enrich(&problem, &engine, start.as_ref(), Some(&measure))?;
        solution = solution.concatenate(&part.embed(&inputs, &found)?)?;
        found_parts.push(SeparatedPart { axes: part.axes.clone(), solution: found });
        reports.push(report);
    }
    let error = fresh.stage_error(&inputs, &span, &solution);
    Ok(SeparatedStage { axes: inputs.axes, parts: found_parts, span: span.basis, error, reports })
}

#[cfg(test)]
mod surrogate;
#[cfg(test)]
mod tests;
