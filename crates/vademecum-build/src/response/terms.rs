//! The terms of the block structure: what the file keeps of the stage responses, separated or not.

use faer::Mat;
use vademecum_format::{Axis, AxisKind, AxisRole};

use super::stage::StageResponse;

/// The terms of the block structure: `E_t` and the load columns, and the factors on every axis.
pub struct BlockTerms<'a> {
    /// The axes.
    pub axes: Vec<AxisTable<'a>>,
    /// Space part of `C − I` of each term, shape (r, r).
    pub(crate) states: Vec<Mat<f64>>,
    /// Space part of `H − B` of each term over the free dofs, shape (n, r).
    pub loads: Vec<Mat<f64>>,
}

/// An axis with its points and factors.
pub struct AxisTable<'a> {
    /// As the file keeps it.
    pub(crate) axis: Axis<'a>,
    /// Its points.
    pub points: Vec<f64>,
    /// Factors, shape (terms, points).
    pub factors: Mat<f64>,
}

impl BlockTerms<'static> {
    /// At fixed parameters: one index axis, the stage, and one term per stage.
    pub fn fixed(responses: &[StageResponse]) -> Self {
        let stages = responses.len();
        let points = (0..stages).map(|i| i as f64).collect();
        Self {
            axes: vec![AxisTable {
                axis: stage_axis(stages as u32),
                points,
                factors: Mat::identity(stages, stages),
            }],
            states: responses.iter().map(|r| r.state.clone()).collect(),
            loads: responses.iter().map(|r| r.increment.clone()).collect(),
        }
    }
}

/// At fixed parameters the separated solution has one axis, the stage, and one term per stage.
fn stage_axis(n_stages: u32) -> Axis<'static> {
    Axis {
        name: "stage",
        unit: "",
        role: AxisRole::Stage,
        kind: AxisKind::Index,
        log: false,
        lower: 0.0,
        upper: f64::from(n_stages - 1),
        n_points: n_stages,
    }
}
