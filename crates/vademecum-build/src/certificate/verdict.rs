//! What was measured of a structure, and whether it keeps a tolerance.

use vademecum_format::StructureCertificate;
use vademecum_format::policy::ABSOLUTE_ERROR;

use super::endurance::Measured;
use super::figures::{FIGURES, Figures, finite, larger};
use crate::dynamics::TrajectoryError;

/// Numbers of a certificate.
const CERTIFICATE: usize = 7;

/// What was measured of a structure: what the file keeps, and every run behind it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StructureMeasured {
    /// As the metadata of a file keep it: the largest error of any run, and the largest floor.
    pub certificate: StructureCertificate,
    /// What a section of the file keeps beside it.
    pub figures: Figures,
    /// Error and floor of each run.
    pub runs: Vec<TrajectoryError>,
}

impl StructureMeasured {
    /// The errors of runs of so many steps, and nothing else yet.
    pub fn of_runs(runs: Vec<TrajectoryError>, steps: usize) -> Self {
        let largest = |part: fn(&TrajectoryError) -> f64| {
            runs.iter().map(part).reduce(larger).expect("a certificate has runs")
        };
        let certificate = StructureCertificate {
            trajectory_error: largest(|run| run.error),
            projection_floor: largest(|run| run.floor),
            steps: steps as f64,
            ..StructureCertificate::default()
        };
        // A run so exact that rounding is its error has no ratio worth telling, unless all are.
        let told = runs
            .iter()
            .filter(|run| run.error.is_nan() || run.error > ABSOLUTE_ERROR)
            .map(TrajectoryError::ratio);
        let floor_ratio = told.reduce(larger).unwrap_or_else(|| largest(TrajectoryError::ratio));
        let figures = Figures { floor_ratio, ..Figures::default() };
        Self { certificate, figures, runs }
    }

    /// What a file may hold of the certificate: NaN where a march overflowed, which is no measurement.
    pub fn known(&self) -> StructureCertificate {
        StructureCertificate::from_numbers(self.certificate.numbers().map(finite))
    }

    /// One row of numbers, for the store.
    pub(crate) fn row(&self) -> Vec<f64> {
        let runs = self.runs.iter().flat_map(|run| [run.error, run.floor]);
        self.certificate.numbers().into_iter().chain(self.figures.numbers()).chain(runs).collect()
    }

    /// Back from [`StructureMeasured::row`]; nothing measured where a row is too short.
    pub(crate) fn from_row(row: &[f64]) -> Self {
        let Some((certificate, rest)) = row.split_first_chunk::<CERTIFICATE>() else {
            return Self::default();
        };
        let Some((figures, runs)) = rest.split_first_chunk::<FIGURES>() else { return Self::default() };
        Self {
            certificate: StructureCertificate::from_numbers(*certificate),
            figures: Figures::from_numbers(*figures),
            runs: runs.as_chunks().0.iter().map(|&[error, floor]| TrajectoryError { error, floor }).collect(),
        }
    }

    /// The worse of both in every figure, with the runs of both; over fewer steps of the two.
    pub(crate) fn worse(mut self, other: Self) -> Self {
        let (a, b) = (self.certificate.numbers(), other.certificate.numbers());
        let mut certificate = StructureCertificate::from_numbers(std::array::from_fn(|i| larger(a[i], b[i])));
        certificate.steps = self.certificate.steps.min(other.certificate.steps);
        self.runs.extend(other.runs);
        Self { certificate, figures: self.figures.worse(&other.figures), runs: self.runs }
    }
}

/// A structure's certificate as a report shows it.
#[derive(Clone, Debug, serde::Serialize)]
pub struct StructureReport {
    /// Relative L2 error over all dofs and steps, mass norm, of the run with the largest.
    pub trajectory_error: f64,
    /// The same of the projection of the full-order trajectory, of the run with the largest.
    pub projection_floor: f64,
    /// Error ÷ floor of the run with the largest; of the two figures above where a file does not keep it.
    pub floor_ratio: f64,
    /// Of the fused step.
    pub spectral_radius: f64,
    /// Largest energy of a free run over the energy at its start.
    pub energy_ratio: f64,
    /// Largest energy of free motions over the energy at their start, in a million steps; NaN where not
    /// measured.
    pub energy_growth: f64,
    /// Defect of reciprocity; NaN where not measured.
    pub reciprocity: f64,
    /// Relative error of the stage maps at fresh points, root mean square (of the solve alone at fixed
    /// parameters).
    pub map_error_rms: f64,
    /// The same at the worst point.
    pub map_error_max: f64,
    /// Steps of the march behind the errors.
    pub steps: f64,
    /// Error and floor of each run, where the build still knows them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub runs: Vec<TrajectoryError>,
}

impl StructureReport {
    /// From what the file holds.
    pub fn new(c: &StructureCertificate, figures: &Figures) -> Self {
        let of_largest = c.trajectory_error / c.projection_floor;
        Self {
            trajectory_error: c.trajectory_error,
            projection_floor: c.projection_floor,
            floor_ratio: if figures.floor_ratio.is_nan() { of_largest } else { figures.floor_ratio },
            spectral_radius: c.spectral_radius,
            energy_ratio: c.energy_ratio,
            energy_growth: figures.energy_growth,
            reciprocity: figures.reciprocity,
            map_error_rms: c.map_error_rms,
            map_error_max: c.map_error_max,
            steps: c.steps,
            runs: vec![],
        }
    }

    /// From what a build measured.
    pub fn measured(m: &StructureMeasured) -> Self {
        Self { runs: m.runs.clone(), ..Self::new(&m.certificate, &m.figures) }
    }

    /// Steps for which the trajectory keeps a tolerance, estimated from this one march, which is why it is no
    /// condition of a build: 0 where the march missed it, infinite where nothing was seen beyond the floor.
    ///
    /// The run farthest above its floor is judged, as if its floor were the largest: without the absolute
    /// part of the tolerance the estimate depends on the ratio alone, and with it a smaller floor keeps it
    /// longer.
    pub fn good_for_steps(&self, floor_ratio: f64, absolute: f64) -> f64 {
        let Self { steps, projection_floor: floor, .. } = *self;
        let error = self.trajectory_error.max(self.floor_ratio * floor);
        Measured { steps, error, floor, floor_ratio, absolute }.good_for_steps()
    }

    /// Whether the stage maps keep a tolerance; an error that is not a number does not.
    pub(crate) fn maps_keep(&self, tolerance: f64) -> bool {
        self.map_error_rms <= tolerance && self.map_error_max <= 10.0 * tolerance
    }

    /// Whether every run keeps `floor_ratio × its floor + absolute`; an error that is not a number does not.
    pub(crate) fn near_floor(&self, floor_ratio: f64, absolute: f64) -> bool {
        let worst = TrajectoryError { error: self.trajectory_error, floor: self.projection_floor };
        let near = |run: &TrajectoryError| run.error <= floor_ratio * run.floor + absolute;
        near(&worst) && self.runs.iter().all(near)
    }
}

/// Largest energy of a free run over the energy at its start. A stable step decays; between, the energy of
/// `Bζ` may swing a little where the full-order field is not quite `Bζ` (live regions).
pub const BOUNDED: f64 = 1.05;

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(runs: &[(f64, f64)]) -> StructureMeasured {
        let runs: Vec<_> = runs.iter().map(|&(error, floor)| TrajectoryError { error, floor }).collect();
        StructureMeasured::of_runs(runs, 100)
    }

    #[test]
    fn the_largest_error_and_the_largest_ratio_stand_side_by_side() {
        // The run farthest above its floor is not the run of the largest error.
        let report = StructureReport::measured(&measured(&[(2e-5, 1.9e-5), (7.9e-4, 7.9e-4)]));
        assert_eq!((report.trajectory_error, report.projection_floor), (7.9e-4, 7.9e-4));
        assert_eq!(report.floor_ratio, 2e-5 / 1.9e-5);
    }

    #[test]
    fn a_run_far_above_its_floor_is_not_hidden_by_one_of_larger_error() {
        let report = StructureReport::measured(&measured(&[(3e-5, 2e-5), (7.9e-4, 7.9e-4)]));
        assert!(!report.near_floor(1.1, 1e-6));
        assert!(report.near_floor(1.6, 1e-6));
        let unmeasured = StructureReport::measured(&measured(&[(f64::NAN, 1e-5), (1e-4, 1e-4)]));
        assert!(!unmeasured.near_floor(1.1, 1e-6), "a run that is not a number");
    }

    #[test]
    fn a_row_of_the_store_comes_back_whole() {
        let one = measured(&[(2e-5, 1.9e-5), (7.9e-4, 7.9e-4)]);
        let back = StructureMeasured::from_row(&one.row());
        // NaN stands for what was not measured, so bits are compared.
        let bits = |m: &StructureMeasured| m.row().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&one), bits(&back));
    }
}
