//! What a build says about itself: figures for people and for JSON, and whether they keep the tolerance.

use faer::Mat;
use vademecum_format::scheme::SchemeTable;
use vademecum_format::{Certificate, Chapter, File, FormatError, SectionKind, StructureCertificate};

use crate::canonical::CanonicalCertificate;
use crate::dynamics::{Rayleigh, numerical_damping};
use crate::endurance::Measured;
use crate::parametric::RadiusSample;
use crate::pod::Basis;
use crate::problem::Problem;
use crate::progress::StageTiming;
use crate::separated::canonical::StageError;

/// What a build did and measured.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Report {
    /// Title of the problem.
    pub title: String,
    /// Nodes of the mesh.
    pub nodes: usize,
    /// Elements of the mesh.
    pub elements: usize,
    /// Free dofs n.
    pub dofs: usize,
    /// Modes r.
    pub modes: usize,
    /// Steps in the first natural period.
    pub steps_per_first_period: f64,
    /// One entry per mode.
    pub mode_table: Vec<ModeRow>,
    /// Singular values of the snapshots.
    pub singular_values: Vec<f64>,
    /// Snapshots taken.
    pub snapshots: usize,
    /// What was measured, per structure.
    pub certificate: CertificateReport,
    /// What the separation over the parameters did; absent without parameters.
    pub separation: Option<SeparationReport>,
    /// Wall time and memory per stage.
    pub timings: Vec<StageTiming>,
    /// Length of the file \[bytes\].
    pub file_bytes: usize,
}

/// What the separation over the parameters did.
#[derive(Clone, Debug, serde::Serialize)]
pub struct SeparationReport {
    /// Terms.
    pub terms: usize,
    /// Points of each axis.
    pub axis_points: Vec<usize>,
    /// Relative error after each enrichment, at fresh points of the reduced problem.
    pub history: Vec<f64>,
    /// Terms after each enrichment.
    pub history_terms: Vec<usize>,
    /// Why the enrichment ended.
    pub stop: String,
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
    pub radius_samples: Vec<RadiusSample>,
    /// What `--repair` did, in order; empty without it.
    pub repairs: Vec<String>,
}

impl SeparationReport {
    /// `name = value, …`, four digits of each.
    pub fn place(&self, values: &[f64]) -> String {
        let rounded = |value: &f64| format!("{value:.3e}").parse::<f64>().unwrap_or(*value);
        let one = |(name, value): (&String, &f64)| format!("{name} = {}", rounded(value));
        self.parameters.iter().zip(values).map(one).collect::<Vec<_>>().join(", ")
    }
}

/// A mode as engineers ask for it.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct ModeRow {
    /// √(Rayleigh quotient)/2π \[Hz\].
    pub frequency_hz: f64,
    /// φᵀKφ ÷ φᵀMφ \[rad²/s²\].
    pub rayleigh_quotient: f64,
    /// Fraction of the snapshot energy; NaN for natural modes without snapshots.
    pub energy: f64,
    /// Damping ratio the material gives it.
    pub physical_damping: f64,
    /// Damping ratio the scheme adds at this step.
    pub numerical_damping: f64,
    /// Relative lengthening of its period by the scheme.
    pub period_elongation: f64,
}

/// The certificate as a report shows it.
#[derive(Clone, Debug, serde::Serialize)]
pub struct CertificateReport {
    /// Of the diagonal structure, if the file has it.
    pub diagonal: Option<StructureReport>,
    /// Of the block structure, if the file has it.
    pub block: Option<StructureReport>,
    /// Of the canonical structure, if the file has it.
    pub canonical: Option<CanonicalReport>,
    /// Allowed: floor_ratio × floor + absolute.
    pub floor_ratio: f64,
    /// See `floor_ratio`.
    pub absolute: f64,
    /// Allowed error of the stage maps over live parameters, root mean square; ten times that at the worst point.
    pub map: f64,
}

/// A structure's certificate as a report shows it.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct StructureReport {
    /// Relative L2 error over all dofs and steps, mass norm.
    pub trajectory_error: f64,
    /// The same of the projection of the full-order trajectory.
    pub projection_floor: f64,
    /// Error ÷ floor.
    pub floor_ratio: f64,
    /// Of the fused step.
    pub spectral_radius: f64,
    /// Largest energy of a free run over the energy at its start.
    pub energy_ratio: f64,
    /// Relative error of the stage maps at fresh points, root mean square (of the solve alone at fixed parameters).
    pub map_error_rms: f64,
    /// The same at the worst point.
    pub map_error_max: f64,
    /// Steps of the march behind the errors.
    pub steps: f64,
}

/// The canonical structure's certificate as a report shows it.
#[derive(Clone, Debug, serde::Serialize)]
pub struct CanonicalReport {
    /// As of the other structures, over the steps before `left_at`.
    #[serde(flatten)]
    pub structure: StructureReport,
    /// The step at which a trajectory left an axis.
    pub left_at: Option<usize>,
    /// Per stage: terms, and the relative error of its map over random points.
    pub stages: Vec<StageReport>,
}

/// One stage of the canonical structure.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct StageReport {
    /// Terms.
    pub terms: usize,
    /// Error of the map, root mean square relative to it.
    pub error: f64,
    /// Of its state part, relative to that.
    pub state_error: f64,
    /// Of its load part, relative to that.
    pub load_error: f64,
}

impl CanonicalReport {
    fn new(c: &CanonicalCertificate) -> Self {
        let stage = |(e, &terms): (&StageError, &usize)| StageReport {
            terms,
            error: e.total,
            state_error: e.state,
            load_error: e.load,
        };
        Self {
            structure: StructureReport::new(&c.structure),
            left_at: c.left.map(|(step, _)| step),
            stages: c.stages.iter().zip(&c.terms).map(stage).collect(),
        }
    }

    /// From what a file holds; `None` if it does not have the structure.
    ///
    /// # Errors
    /// [`FormatError`] if a section is compressed or malformed.
    pub fn of_file(file: &File<'_>) -> Result<Option<Self>, FormatError> {
        let (Some(canonical), Some(section)) =
            (Chapter::read(file)?, file.section(SectionKind::CanonicalCertificate))
        else {
            return Ok(None);
        };
        let numbers: Vec<f64> = section.numbers()?.iter().collect();
        let (structure, rest) = numbers.split_first_chunk().expect("the shape was checked on opening");
        let (left, stages) = rest.split_first().expect("the shape was checked on opening");
        let structure = StructureCertificate::from_numbers(*structure);
        let terms =
            |stage| canonical.parts().filter(|part| part.stage == stage).map(|part| part.n_terms).sum();
        let stage = |(stage, e): (usize, &[f64; 3])| StageReport {
            terms: terms(stage),
            error: e[0],
            state_error: e[1],
            load_error: e[2],
        };
        Ok(Some(Self {
            structure: StructureReport::new(&structure),
            left_at: (*left >= 1.0).then_some(*left as usize),
            stages: stages.as_chunks().0.iter().enumerate().map(stage).collect(),
        }))
    }
}

impl StructureReport {
    /// From what the file holds.
    pub fn new(c: &StructureCertificate) -> Self {
        Self {
            trajectory_error: c.trajectory_error,
            projection_floor: c.projection_floor,
            floor_ratio: c.trajectory_error / c.projection_floor,
            spectral_radius: c.spectral_radius,
            energy_ratio: c.energy_ratio,
            map_error_rms: c.map_error_rms,
            map_error_max: c.map_error_max,
            steps: c.steps,
        }
    }

    /// Steps for which the trajectory keeps a tolerance, estimated from this one march, which is why it is no condition of a build: 0 where
    /// the march missed it, infinite where nothing was seen beyond the floor.
    pub fn good_for_steps(&self, floor_ratio: f64, absolute: f64) -> f64 {
        let Self { steps, trajectory_error: error, projection_floor: floor, .. } = *self;
        Measured { steps, error, floor, floor_ratio, absolute }.good_for_steps()
    }

    /// Whether the stage maps keep a tolerance; an error that is not a number does not.
    fn maps_keep(&self, tolerance: f64) -> bool {
        self.map_error_rms <= tolerance && self.map_error_max <= 10.0 * tolerance
    }

    /// Whether the trajectories keep a tolerance and the step is stable.
    fn keeps(&self, floor_ratio: f64, absolute: f64) -> bool {
        let accurate = self.trajectory_error <= floor_ratio * self.projection_floor + absolute;
        accurate && self.spectral_radius <= STABLE && self.energy_ratio <= BOUNDED
    }
}

/// Largest spectral radius of a step that may be written: rounding of eigenvalues at 1 (docs/theory/5-vademecum.md).
pub(crate) const STABLE: f64 = 1.0 + 1e-12;
/// Largest energy of a free run over the energy at its start. A stable step decays; between, the energy of `Bζ` may swing a
/// little where the full-order field is not quite `Bζ` (live regions).
const BOUNDED: f64 = 1.05;

impl CertificateReport {
    /// Whether one of the structures keeps the tolerance.
    pub fn holds(&self) -> bool {
        let keeps = |s: &StructureReport| s.keeps(self.floor_ratio, self.absolute);
        // The diagonal structure is closed form in its parameters: it has no separated maps to measure.
        let diagonal = self.diagonal.as_ref().is_some_and(keeps);
        let canonical = self.canonical.as_ref().is_some_and(|c| c.left_at.is_none() && keeps(&c.structure));
        diagonal || canonical || self.block.as_ref().is_some_and(|s| keeps(s) && s.maps_keep(self.map))
    }

    /// Whether a larger basis could mend the block structure: its maps and its stability are sound.
    pub(crate) fn misses_trajectories_only(&self) -> bool {
        self.block.as_ref().is_some_and(|s| s.spectral_radius <= STABLE && s.maps_keep(self.map))
    }
}

impl Report {
    pub(crate) fn missed(&self) -> String {
        let line = |name: &str, s: &StructureReport| {
            format!(
                "\n  {name}: error {:.3e}, floor {:.3e} (ratio {:.2}), spectral radius 1{:+.1e}, energy ratio {:.6}, map error {:.1e} rms, {:.1e} worst",
                s.trajectory_error,
                s.projection_floor,
                s.floor_ratio,
                s.spectral_radius - 1.0,
                s.energy_ratio,
                s.map_error_rms,
                s.map_error_max
            )
        };
        let c = &self.certificate;
        let diagonal = c.diagonal.as_ref().map_or(String::new(), |s| line("diagonal", s));
        let block = c.block.as_ref().map_or(String::new(), |s| line("block", s));
        let canonical = c.canonical.as_ref().map_or(String::new(), |c| {
            let left = c.left_at.map_or(String::new(), |step| format!(", left its axes at step {step}"));
            line("canonical", &c.structure) + &left
        });
        let place = |s: &SeparationReport| {
            let unstable = c.block.as_ref().is_some_and(|b| b.spectral_radius > STABLE);
            let radius = format!(
                "\n  the step is unstable at {}: `--repair` adds terms until it is stable",
                s.place(&s.worst_radius_at)
            );
            let repairs: String = s.repairs.iter().map(|r| format!("\n  repaired: {r}")).collect();
            let worst = format!("\n  worst trajectory at {}", s.place(&s.worst_trajectory_at));
            if unstable { worst + &radius + &repairs } else { worst + &repairs }
        };
        let places = self.separation.as_ref().map_or(String::new(), place);
        format!(
            "no structure keeps the tolerance (error ≤ {} × floor + {:e}, spectral radius ≤ 1 + 1e-12, map error ≤ {:e}):{diagonal}{block}{canonical}{places}",
            c.floor_ratio, c.absolute, c.map
        )
    }
}

/// The certificate of a file as a report shows it.
pub(crate) fn certificate_report(
    problem: &Problem,
    certificate: &Certificate,
    diagonal: bool,
) -> CertificateReport {
    CertificateReport {
        diagonal: diagonal.then(|| StructureReport::new(&certificate.diagonal)),
        block: Some(StructureReport::new(&certificate.block)),
        canonical: None,
        floor_ratio: problem.tolerance.floor_ratio,
        absolute: problem.tolerance.absolute,
        map: problem.tolerance.map,
    }
}

/// The certificate of a canonical file as a report shows it.
pub(crate) fn canonical_report(problem: &Problem, certificate: &CanonicalCertificate) -> CertificateReport {
    CertificateReport {
        diagonal: None,
        block: None,
        canonical: Some(CanonicalReport::new(certificate)),
        floor_ratio: problem.tolerance.floor_ratio,
        absolute: problem.tolerance.absolute,
        map: problem.tolerance.map,
    }
}

pub(crate) fn mode_table(basis: &Basis, scheme: &SchemeTable, rayleigh: &Rayleigh, dt: f64) -> Vec<ModeRow> {
    let row = |k: usize| {
        let quotient = basis.stiffness[(k, k)];
        let frequency_hz = quotient.sqrt() / std::f64::consts::TAU;
        let physical_damping = rayleigh.ratio(frequency_hz);
        let numerical = numerical_damping(scheme, quotient.sqrt() * dt, physical_damping);
        ModeRow {
            frequency_hz,
            rayleigh_quotient: quotient,
            energy: basis.energy.get(k).copied().unwrap_or(f64::NAN),
            physical_damping,
            numerical_damping: numerical.ratio.map_or(f64::NAN, |ratio| ratio - physical_damping),
            period_elongation: numerical.period_elongation.unwrap_or(f64::NAN),
        }
    };
    (0..basis.n_modes()).map(row).collect()
}

pub(crate) fn table_matrix(rows: &[ModeRow]) -> Mat<f64> {
    Mat::from_fn(rows.len(), 6, |i, j| {
        let row = &rows[i];
        [
            row.frequency_hz,
            row.rayleigh_quotient,
            row.energy,
            row.physical_damping,
            row.numerical_damping,
            row.period_elongation,
        ][j]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn structure(map_error: f64) -> StructureReport {
        StructureReport::new(&StructureCertificate {
            trajectory_error: 1.0e-3,
            projection_floor: 1.0e-3,
            spectral_radius: 1.0,
            energy_ratio: 1.0,
            map_error_rms: map_error,
            map_error_max: map_error,
            steps: 100.0,
        })
    }

    fn holds(diagonal: Option<StructureReport>, block: Option<StructureReport>) -> bool {
        CertificateReport { diagonal, block, canonical: None, floor_ratio: 1.1, absolute: 1e-6, map: 1e-6 }
            .holds()
    }

    #[test]
    fn a_block_structure_without_a_sound_map_error_does_not_hold() {
        assert!(holds(None, Some(structure(1e-7))));
        assert!(!holds(None, Some(structure(1e-5))));
        assert!(!holds(None, Some(structure(f64::NAN))));
        assert!(holds(Some(structure(f64::NAN)), None), "closed form: no separated map to measure");
    }

    #[test]
    fn an_unstable_or_unmeasured_march_does_not_hold() {
        let unstable = StructureReport { spectral_radius: 1.0 + 1e-9, ..structure(1e-7) };
        let unmeasured = StructureReport { trajectory_error: f64::NAN, ..structure(1e-7) };
        let growing = StructureReport { energy_ratio: 1.06, ..structure(1e-7) };
        for bad in [unstable, unmeasured, growing] {
            assert!(!holds(Some(bad), None));
        }
    }
}
