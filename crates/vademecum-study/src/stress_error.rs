//! The stress that a file shows beside that of the motion that is exact in time.

use vademecum_build::dynamics::ReferenceTrajectory;
use vademecum_build::fem::{COMPONENTS, StressPoint, StressRows};
use vademecum_build::prepared::{Body, Setting};
use vademecum_eval::Tensor;
use vademecum_format::File;

use crate::error::{FileError, StudyError};
use crate::player::Playable;
use crate::stress::stress_places;

/// Points whose stress is compared; of more, so many are taken at equal distances of their numbers.
const MAX_POINTS: usize = 256;

/// Points of the stress comparison, and their full-order rows.
pub(crate) struct StressCheck {
    points: Vec<usize>,
    rows: Vec<Vec<(u32, f64)>>,
}

impl StressCheck {
    /// The points of a file on the body it was built from; nothing of a file without stress, or with patterns
    /// that are temperatures.
    ///
    /// # Errors
    /// [`FileError`]; [`StudyError::Stress`].
    pub(crate) fn new(
        file: &File<'_>,
        body: &Body,
        file_nodes: &[u32],
        setting: &Setting,
    ) -> Result<Option<Self>, StudyError> {
        let places = stress_places(file)?;
        // The motion alone does not tell the stress of a temperature.
        if places.is_empty() || body.model.materials().is_empty() || !body.thermal.is_empty() {
            return Ok(None);
        }
        let every = places.len().div_ceil(MAX_POINTS);
        let points: Vec<usize> = (0..places.len()).step_by(every).collect();
        let of_mesh = |&point: &usize| StressPoint {
            node: file_nodes[places[point].node],
            region: places[point].region,
        };
        let rows = StressRows::new(&body.model, points.iter().map(of_mesh).collect())?;
        let rows = (0..COMPONENTS * points.len()).map(|row| {
            let (place, component) = (row / COMPONENTS, row % COMPONENTS);
            let region = setting.stiffness.get(rows.points[place].region as usize);
            let scale = setting.step.stiffness * region.unwrap_or(&1.0);
            let nodes = rows.rows[place].iter();
            let weights = nodes.flat_map(|&(node, block)| {
                let weight = move |c: usize| (3 * node as usize + c, scale * block[component][c]);
                (0..3).map(weight)
            });
            let free = |(dof, weight): (usize, f64)| {
                body.model.dofs().terms(dof).map(move |(free, share)| (free, share * weight))
            };
            weights.flat_map(free).collect()
        });
        Ok(Some(Self { rows: rows.collect(), points }))
    }

    /// Adds the stress that the file shows at an instant.
    pub(crate) fn take(
        &self,
        body: &dyn Playable<Number = f64>,
        shown: &mut Vec<Tensor>,
    ) -> Result<(), FileError> {
        for &point in &self.points {
            shown.push(body.stress(point)?);
        }
        Ok(())
    }

    /// The largest equivalent stress of the difference, over points and instants, as a share of the largest
    /// of the exact motion; nothing where that has none.
    pub(crate) fn error(&self, truth: &ReferenceTrajectory<'_>, shown: &[Tensor]) -> Option<f64> {
        let exact = truth.along(&self.rows);
        let (mut apart, mut largest) = (0.0_f64, 0.0_f64);
        for (instant, shown) in shown.chunks_exact(self.points.len()).enumerate() {
            for (point, shown) in shown.iter().enumerate() {
                let exact: [f64; COMPONENTS] =
                    std::array::from_fn(|k| exact[(COMPONENTS * point + k, instant)]);
                largest = largest.max(Tensor(exact).von_mises());
                apart = apart.max(Tensor(std::array::from_fn(|k| shown.0[k] - exact[k])).von_mises());
            }
        }
        (largest > 0.0).then(|| apart / largest)
    }
}
