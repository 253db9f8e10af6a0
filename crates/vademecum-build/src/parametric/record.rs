//! What the separation over the parameters did, for the file and for the report.

use crate::separated::StopReason;

/// What the separation over the parameters did.
#[derive(Clone, Debug, serde::Serialize)]
pub struct SeparationRecord {
    /// Terms.
    pub terms: usize,
    /// Points of each axis.
    pub axis_points: Vec<usize>,
    /// Relative error after each enrichment, at fresh points of the reduced problem.
    pub(crate) history: Vec<f64>,
    /// Terms after each enrichment.
    pub(crate) history_terms: Vec<usize>,
    /// Why the enrichment ended.
    pub stop: StopReason,
    /// Vectors of the compressed space.
    pub reduced_size: usize,
    /// Full-order solves behind it.
    pub samples: usize,
    /// Names of the parameters whose values the next two list.
    pub parameters: Vec<String>,
    /// Parameter values at the corner of the worst trajectory.
    pub worst_trajectory_at: Vec<f64>,
    /// Parameter values at the largest spectral radius.
    pub worst_radius_at: Vec<f64>,
    /// Spectral radius of the fused step at every point of the box where it was computed.
    pub(crate) radius_samples: Vec<RadiusSample>,
    /// What `--repair` did, in order; empty without it.
    pub repairs: Vec<String>,
}

impl SeparationRecord {
    /// `name = value, …`, four digits of each.
    pub fn place(&self, values: &[f64]) -> String {
        let rounded = |value: &f64| format!("{value:.3e}").parse::<f64>().unwrap_or(*value);
        let one = |(name, value): (&String, &f64)| format!("{name} = {}", rounded(value));
        self.parameters.iter().zip(values).map(one).collect::<Vec<_>>().join(", ")
    }
}

/// The spectral radius of the fused step at a point of the box.
#[derive(Clone, Debug, serde::Serialize)]
pub struct RadiusSample {
    /// Parameter values, in the order of the problem file.
    pub values: Vec<f64>,
    /// Of the block structure's fused step.
    pub spectral_radius: f64,
}
