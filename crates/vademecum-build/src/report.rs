//! What a build says about itself: figures for people and for JSON, and whether they keep the tolerance.

use vademecum_format::policy::STABLE_RADIUS;

use crate::certificate::{BOUNDED, LargeReport, StructureReport, TestLoad};
use crate::dynamics::{ModeRow, Work};
use crate::input::Tolerances;
use crate::measured::{NotMeasured, measured};
use crate::mesh_error::MeshEstimate;
use crate::parametric::SeparationRecord;
use crate::progress::StageTiming;
use crate::separated::StopReason;

/// What a build did and measured.
#[derive(Clone, Debug, serde::Serialize)]
pub struct BuildReport {
    /// Title of the problem.
    pub(crate) title: String,
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
    pub(crate) singular_values: Vec<f64>,
    /// Snapshots taken.
    pub snapshots: usize,
    /// What was measured, per structure.
    pub certificate: CertificateReport,
    /// Pushes of the test runs that it was measured in; empty of large displacements.
    pub test_loads: Vec<TestLoad>,
    /// What the separation over the parameters did; absent without parameters.
    pub separation: Option<SeparationRecord>,
    /// Wall time and memory per stage.
    pub timings: Vec<StageTiming>,
    /// Length of the file \[bytes\].
    pub file_bytes: usize,
    /// What was announced before: full-order steps, estimated seconds, memory.
    pub plan: BuildPlan,
    /// Of large displacements; absent otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub large: Option<LargeReport>,
    /// Discretisation error of the lowest frequencies, or why it is not known.
    pub mesh_error: Option<MeshEstimate>,
}

/// What a build is about to take.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct BuildPlan {
    /// Full-order steps and their time.
    #[serde(flatten)]
    pub work: Work,
    /// Memory of matrices, factors, snapshots and basis, counted from below \[bytes\].
    pub memory_bytes: f64,
}

/// The certificate as a report shows it.
#[derive(Clone, Debug, serde::Serialize)]
pub struct CertificateReport {
    /// Of the diagonal structure, if the file has it.
    pub diagonal: Option<StructureReport>,
    /// Of the block structure, if the file has it.
    pub block: Option<StructureReport>,
    /// Of the chapter's structure, if the file has it.
    #[serde(rename = "canonical")]
    pub chapter: Option<ChapterReport>,
    /// Whether the diagonal structure's figures are those of the strain structure.
    #[serde(skip)]
    pub large: bool,
    /// True if they are those of a parametric model over its box, whose floor is that of the basis alone.
    #[serde(skip)]
    pub parametric: bool,
    /// Allowed: floor_ratio × floor + absolute.
    pub floor_ratio: f64,
    /// See `floor_ratio`.
    pub absolute: f64,
    /// Largest trajectory error allowed, however close to its floor it is.
    pub error: f64,
    /// Allowed error of the stage maps over live parameters, root mean square; ten times that at the worst
    /// point.
    pub map: f64,
}

/// The certificate of a structure that another crate builds, the chapter's, as a report shows it.
#[derive(Clone, Debug, serde::Serialize)]
pub struct ChapterReport {
    /// As of the other structures, over the steps before `left_at`.
    #[serde(flatten)]
    pub structure: StructureReport,
    /// The step at which a trajectory left an axis.
    pub left_at: Option<usize>,
    /// Per stage: terms, and the relative error of its map over random points.
    pub stages: Vec<StageReport>,
}

/// One stage of that structure.
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

impl CertificateReport {
    /// A report of no structure yet, beside what the problem allows.
    pub fn within(tolerance: &Tolerances) -> Self {
        Self {
            diagonal: None,
            block: None,
            chapter: None,
            large: false,
            parametric: false,
            floor_ratio: tolerance.floor_ratio,
            absolute: tolerance.absolute,
            error: tolerance.error,
            map: tolerance.map,
        }
    }

    /// Checks that the errors of all structures were measured. A map error that is no number is that of a
    /// structure without separated maps.
    ///
    /// # Errors
    /// [`NotMeasured`].
    pub fn measured(&self) -> Result<(), NotMeasured> {
        self.structures().try_for_each(|s| {
            let errors = [
                ("trajectory_error", s.trajectory_error),
                ("projection_floor", s.projection_floor),
                ("spectral_radius", s.spectral_radius),
                ("energy_ratio", s.energy_ratio),
            ];
            let chapter = self.chapter.as_ref().filter(|chapter| std::ptr::eq(&chapter.structure, s));
            measured(match chapter {
                // A run that leaves the ranges of the maps has no error, and the report says where it left.
                Some(chapter) if chapter.left_at.is_some() => &[],
                // A free run that leaves them has no ratio of energies.
                Some(_) => &errors[..3],
                // A structure of large displacements has no spectral radius and no ratio of energies.
                None if self.large => &errors[..2],
                None => &errors,
            })
        })
    }

    /// Whether one of the structures keeps the tolerance.
    pub fn holds(&self) -> bool {
        self.structures().any(|s| self.parts_missed_by(s, None).is_empty())
    }

    fn structures(&self) -> impl Iterator<Item = &StructureReport> {
        let chapter = self.chapter.as_ref().map(|c| &c.structure);
        [self.diagonal.as_ref(), self.block.as_ref(), chapter].into_iter().flatten()
    }

    /// What one of the structures misses of the tolerance; `stop` is why its separation ended, if it has one.
    fn parts_missed_by(&self, s: &StructureReport, stop: Option<StopReason>) -> Vec<MissedPart> {
        // The diagonal structure is closed form in its parameters: it has no separated maps to measure.
        let block = self.block.as_ref().is_some_and(|b| std::ptr::eq(b, s));
        let left =
            self.chapter.as_ref().is_some_and(|c| std::ptr::eq(&c.structure, s) && c.left_at.is_some());
        if self.large || self.parametric {
            // The step of large displacements has no spectral radius, and its energy is kept by construction.
            // The floor is that of the basis alone: neither a strain map nor modes of a box come near it.
            let known = s.trajectory_error.is_finite() && s.projection_floor.is_finite();
            let found =
                [(!known, MissedPart::NotANumber), (s.trajectory_error > self.error, MissedPart::Ceiling)];
            return found.into_iter().filter_map(|(missed, part)| missed.then_some(part)).collect();
        }
        let numbers = [s.trajectory_error, s.projection_floor, s.spectral_radius, s.energy_ratio];
        let [unstable, maps] = match stop.filter(|_| block) {
            Some(StopReason::MaxTerms) => [MissedPart::StabilityOverParameters, MissedPart::MapsTerms],
            Some(_) => [MissedPart::StabilityOverParameters, MissedPart::MapsStagnated],
            None => [MissedPart::Stability, MissedPart::MapsStagnated],
        };
        let found = [
            (!numbers.iter().all(|x| x.is_finite()), MissedPart::NotANumber),
            (s.spectral_radius > STABLE_RADIUS, unstable),
            (block && !s.maps_keep(self.map), maps),
            (s.energy_ratio > BOUNDED, MissedPart::Energy),
            (left || !s.near_floor(self.floor_ratio, self.absolute), MissedPart::Trajectory),
            (s.trajectory_error > self.error, MissedPart::Ceiling),
        ];
        found.into_iter().filter_map(|(missed, part)| missed.then_some(part)).collect()
    }

    /// True if a larger basis could correct the block structure: its maps and its stability are sound.
    pub(crate) fn misses_trajectories_only(&self) -> bool {
        self.block.as_ref().is_some_and(|s| s.spectral_radius <= STABLE_RADIUS && s.maps_keep(self.map))
    }
}

impl BuildReport {
    pub(crate) fn missed(&self) -> String {
        let line = |name: &str, s: &StructureReport| {
            let shown = |value: f64, text: String| if value.is_finite() { text } else { "unknown".into() };
            let number = |value: f64| shown(value, format!("{value:.3e}"));
            let map = format!(", map error {:.1e} rms, {:.1e} worst", s.map_error_rms, s.map_error_max);
            let map = if s.map_error_rms.is_finite() { map } else { String::new() };
            format!(
                "\n  {name}: error {}, projection error {} (ratio {}), spectral radius {}, energy ratio {}{map}",
                number(s.trajectory_error),
                number(s.projection_floor),
                shown(s.floor_ratio, format!("{:.2}", s.floor_ratio)),
                shown(s.spectral_radius, format!("1{:+.1e}", s.spectral_radius - 1.0)),
                shown(s.energy_ratio, format!("{:.6}", s.energy_ratio))
            )
        };
        let c = &self.certificate;
        let diagonal = c.diagonal.as_ref().map_or(String::new(), |s| line("diagonal", s));
        let block = c.block.as_ref().map_or(String::new(), |s| line("block", s));
        let chapter = c.chapter.as_ref().map_or(String::new(), |c| {
            let left = c.left_at.map_or(String::new(), |step| format!(", left its axes at step {step}"));
            line("chapter", &c.structure) + &left
        });
        let place = |s: &SeparationRecord| {
            let unstable = c.block.as_ref().is_some_and(|b| b.spectral_radius > STABLE_RADIUS);
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
            "no structure keeps the tolerance (error ≤ {:e}, and ≤ {} × projection error + {:e} in each run; spectral radius ≤ 1 + \
             1e-12; map error ≤ {:e}):{diagonal}{block}{chapter}{places}",
            c.error, c.floor_ratio, c.absolute, c.map
        )
    }
}

/// The part of a tolerance that a build missed, the one to improve first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MissedPart {
    /// Something measured is not a number.
    NotANumber,
    /// The step is unstable at the values of the problem file.
    Stability,
    /// The step is unstable somewhere over the live parameters.
    StabilityOverParameters,
    /// The separated maps over the live parameters; they stopped at the most terms.
    MapsTerms,
    /// The same; more terms did not lower their error.
    MapsStagnated,
    /// The energy of a free run grows.
    Energy,
    /// The trajectories are too far above their floor.
    Trajectory,
    /// They are near their floor, and the floor is too large: the basis cannot show the motion.
    Ceiling,
}

impl BuildReport {
    /// The first part that the structure misses which misses fewest.
    pub fn missed_part(&self) -> MissedPart {
        let stop = self.separation.as_ref().map(|s| s.stop);
        let parts = self.certificate.structures().map(|s| self.certificate.parts_missed_by(s, stop));
        let fewest = parts.min_by_key(Vec::len);
        fewest.and_then(|parts| parts.first().copied()).unwrap_or(MissedPart::Trajectory)
    }
}

/// No structure of a file keeps the tolerance of its problem.
#[derive(Debug, thiserror::Error)]
#[error("{}", .0.missed())]
pub struct ToleranceMissed(pub Box<BuildReport>);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::certificate::Figures;
    use vademecum_format::StructureCertificate;

    fn structure(map_error: f64) -> StructureReport {
        let certificate = StructureCertificate {
            trajectory_error: 1.0e-3,
            projection_floor: 1.0e-3,
            spectral_radius: 1.0,
            energy_ratio: 1.0,
            map_error_rms: map_error,
            map_error_max: map_error,
            steps: 100.0,
        };
        StructureReport::new(&certificate, &Figures::default())
    }

    fn holds(diagonal: Option<StructureReport>, block: Option<StructureReport>) -> bool {
        let (floor_ratio, absolute, error, map) = (1.1, 1e-6, 5e-2, 1e-6);
        CertificateReport {
            diagonal,
            block,
            chapter: None,
            large: false,
            parametric: false,
            floor_ratio,
            absolute,
            error,
            map,
        }
        .holds()
    }

    #[test]
    fn an_error_at_its_floor_is_refused_all_the_same_where_it_is_large() {
        let at_its_floor =
            |error| StructureReport { trajectory_error: error, projection_floor: error, ..structure(1e-7) };
        assert!(holds(Some(at_its_floor(4.9e-2)), None));
        assert!(!holds(Some(at_its_floor(0.93)), None));
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

    fn report(block: StructureReport, stop: Option<StopReason>) -> BuildReport {
        let separation = stop.map(|stop| SeparationRecord {
            terms: 42,
            axis_points: vec![],
            history: vec![],
            history_terms: vec![],
            stop,
            reduced_size: 0,
            samples: 0,
            parameters: vec![],
            worst_trajectory_at: vec![],
            worst_radius_at: vec![],
            radius_samples: vec![],
            repairs: vec![],
        });
        BuildReport {
            title: String::new(),
            nodes: 0,
            elements: 0,
            dofs: 0,
            modes: 8,
            steps_per_first_period: 40.0,
            mode_table: vec![],
            singular_values: vec![],
            snapshots: 0,
            certificate: CertificateReport {
                diagonal: None,
                block: Some(block),
                chapter: None,
                large: false,
                parametric: false,
                floor_ratio: 1.1,
                absolute: 1e-6,
                error: 5e-2,
                map: 1e-6,
            },
            test_loads: vec![],
            separation,
            timings: vec![],
            file_bytes: 0,
            plan: BuildPlan::default(),
            large: None,
            mesh_error: None,
        }
    }

    #[test]
    fn what_to_mend_depends_on_what_was_missed() {
        let sound = || structure(1e-7);
        let missed = |block: StructureReport, stop| report(block, stop).missed_part();
        let maps = || structure(1.2e-6);
        assert_eq!(missed(maps(), Some(StopReason::Stagnation)), MissedPart::MapsStagnated);
        assert_eq!(missed(maps(), Some(StopReason::MaxTerms)), MissedPart::MapsTerms);
        let inaccurate = StructureReport { trajectory_error: 1.0, ..sound() };
        assert_eq!(missed(inaccurate, None), MissedPart::Trajectory);
        let at_its_floor = StructureReport { trajectory_error: 0.93, projection_floor: 0.93, ..sound() };
        assert_eq!(missed(at_its_floor, None), MissedPart::Ceiling);
        let unstable = StructureReport { spectral_radius: 1.0 + 1e-9, ..sound() };
        assert_eq!(missed(unstable.clone(), None), MissedPart::Stability);
        let over = missed(unstable, Some(StopReason::Tolerance));
        assert_eq!(over, MissedPart::StabilityOverParameters);
        assert_eq!(missed(StructureReport { energy_ratio: 1.2, ..sound() }, None), MissedPart::Energy);
        let overflown = StructureReport { trajectory_error: f64::NAN, floor_ratio: f64::NAN, ..sound() };
        assert_eq!(missed(overflown.clone(), None), MissedPart::NotANumber);
        let said = report(overflown, None).missed();
        assert!(!said.contains("NaN") && said.contains("ratio unknown"), "{said}");
    }
}
