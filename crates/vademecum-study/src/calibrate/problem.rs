//! Differences of predictions and measured numbers over the coordinates of the box, and their derivatives.

use faer::Mat;
use vademecum_build::progress::Listener;
use vademecum_format::File;

use super::error::CalibrateError;
use super::experiment::Experiment;
use super::model::Model;
use crate::error::StudyError;

/// Change of a coordinate for its central difference, as a share of the range.
const CHANGE: f64 = 2e-4;

/// A point of the fit.
pub(super) struct Point {
    pub u: Vec<f64>,
    pub differences: Vec<f64>,
}

impl Point {
    /// `χ²`.
    pub fn chi(&self) -> f64 {
        self.differences.iter().map(|x| x * x).sum()
    }
}

/// The differences as a function of the coordinates.
pub(super) struct Problem<'a> {
    pub model: Model<'a>,
    pub experiments: Vec<Experiment>,
    pub listener: &'a dyn Listener,
}

impl Problem<'_> {
    /// Differences over their deviations, with this share of the histories.
    pub fn differences(&self, u: &[f64], share: f64) -> Result<Vec<f64>, CalibrateError> {
        let bytes = self.model.bytes(u)?;
        let file = File::parse(&bytes).map_err(StudyError::from)?;
        let mut out = vec![];
        for experiment in &self.experiments {
            experiment.differences(&file, share, &mut out)?;
        }
        if out.iter().all(|x| x.is_finite()) { Ok(out) } else { Err(self.not_finite(u)) }
    }

    /// The error of numbers that are not finite.
    pub fn not_finite(&self, u: &[f64]) -> CalibrateError {
        let values = self.model.values(u);
        let at = values.iter().map(|v| format!("`{}` = {}", v.name, v.value)).collect::<Vec<_>>().join(", ");
        CalibrateError::NotFinite { at }
    }

    /// Derivatives of the differences, a column for each coordinate.
    pub fn slopes(&self, u: &[f64], share: f64) -> Result<Mat<f64>, CalibrateError> {
        let mut columns = vec![];
        for place in 0..u.len() {
            self.listener.checkpoint(place, u.len()).map_err(StudyError::from)?;
            let at = |change: f64| {
                let mut moved = u.to_vec();
                moved[place] = (moved[place] + change).clamp(0.0, 1.0);
                moved
            };
            let (above, below) = (at(CHANGE), at(-CHANGE));
            let width = above[place] - below[place];
            let (above, below) = (self.differences(&above, share)?, self.differences(&below, share)?);
            columns.push(above.iter().zip(below).map(|(a, b)| (a - b) / width).collect::<Vec<f64>>());
        }
        let rows = columns.first().map_or(0, Vec::len);
        Ok(Mat::from_fn(rows, columns.len(), |i, j| columns[j][i]))
    }
}
