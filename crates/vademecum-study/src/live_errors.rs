//! Errors of a parametric file over the box of its parameters, as its build measured them.

use serde::Serialize;
use vademecum_format::{File, SectionKind};

use crate::contents::{Bound, numbers};
use crate::error::FileError;

/// A point of the box.
#[derive(Clone, Debug, Serialize)]
pub struct PointErrors {
    /// A value for each parameter.
    pub values: Vec<f64>,
    /// True if it trained the basis.
    pub trained: bool,
    /// Relative error of the trajectories under the worst load, mass norm over all dofs and steps.
    pub trajectory_error: f64,
}

/// A point of the box that was measured closer.
#[derive(Clone, Debug, Serialize)]
pub struct CloserErrors {
    /// A value for each parameter.
    pub values: Vec<f64>,
    /// As of [`PointErrors`].
    pub trajectory_error: f64,
    /// Relative distance of the reference of that error from a march at full order, same norm.
    pub reference_distance: f64,
    /// Truncation of the static answer to a point load; none without residual flexibility.
    pub bound: Option<Bound>,
}

/// Measured errors over the box.
#[derive(Clone, Debug, Default)]
pub struct LiveErrors {
    /// Points at which the build measured.
    pub points: Vec<PointErrors>,
    /// The centre of the box, and the worst of the points.
    pub closer: Vec<CloserErrors>,
}

impl LiveErrors {
    /// The errors of a file; nothing of one without live regions or stripped of them.
    ///
    /// # Errors
    /// As [`numbers`].
    pub fn of(file: &File<'_>) -> Result<Self, FileError> {
        let point = |row: &[f64]| {
            let (values, &[trained, error]) = row.split_last_chunk()?;
            Some(PointErrors { values: values.to_vec(), trained: trained != 0.0, trajectory_error: error })
        };
        let points = rows(file, SectionKind::LiveCertificate)?;
        let points: Vec<PointErrors> = points.iter().filter_map(|row| point(row)).collect();
        let count = points.first().map_or(0, |point| point.values.len());
        let closer = |row: &[f64]| {
            let (values, rest) = row.split_at_checked(count)?;
            let (&[error, reference], bound) = rest.split_first_chunk()?;
            let bound = bound.first_chunk().map(|&[median, p95, worst]| {
                // Its modes are those of a reduced model.
                Bound { worst, median, p95, kind: "estimate" }
            });
            let (values, trajectory_error) = (values.to_vec(), error);
            Some(CloserErrors { values, trajectory_error, reference_distance: reference, bound })
        };
        let closer = rows(file, SectionKind::LiveWitnesses)?.iter().filter_map(|row| closer(row)).collect();
        Ok(Self { points, closer })
    }

    /// Median, 95 % quantile and largest error of trajectories at points that trained nothing; none where
    /// there are no such points.
    #[must_use]
    pub fn quantiles(&self) -> Option<[f64; 3]> {
        let fresh = self.points.iter().filter(|point| !point.trained && point.trajectory_error.is_finite());
        let mut errors: Vec<f64> = fresh.map(|point| point.trajectory_error).collect();
        errors.sort_by(f64::total_cmp);
        let last = errors.len().checked_sub(1)?;
        Some([0.5, 0.95, 1.0].map(|share| errors[(share * last as f64).round() as usize]))
    }
}

/// Rows of a section of points.
fn rows(file: &File<'_>, kind: SectionKind) -> Result<Vec<Vec<f64>>, FileError> {
    let Some(section) = file.section(kind) else { return Ok(vec![]) };
    let width = usize::try_from(section.shape()[1]).unwrap_or(usize::MAX).max(1);
    Ok(numbers(file, kind)?.chunks_exact(width).map(<[f64]>::to_vec).collect())
}
