//! The statements of a certificate in the order in which a user needs them: the bound for loads that a user
//! may apply, the errors of the test runs of the build, and a warning where contacts have neither bound nor
//! residual flexibility.

use vademecum_format::{File, ParameterRole, SectionKind};
use vademecum_study::FileError;
use vademecum_study::contents::{Bound, bound};
use vademecum_study::live_errors::{CloserErrors, LiveErrors};

use crate::words::percent;

/// Statements of a file about the error of its motion.
pub(crate) struct Accuracy {
    bound: Option<Bound>,
    /// Trajectory error and projection error, the worst of the test runs.
    measured: Option<[f64; 2]>,
    /// True if point loads can act.
    loadable: bool,
    /// True if what the modes leave out under a contact is kept beside them.
    residual: bool,
    /// The reason why there is no bound; empty of a file with one.
    obstacle: &'static str,
    /// Errors over the box of a parametric model.
    live: LiveErrors,
}

impl Accuracy {
    /// The statements of a file.
    ///
    /// # Errors
    /// As [`bound`].
    pub(crate) fn of(file: &File<'_>) -> Result<Self, FileError> {
        let m = file.metadata();
        let has = |kind| file.section(kind).is_some();
        let live = m.active_parameters();
        let obstacle = if has(SectionKind::StrainSizes) {
            " (large displacements)"
        } else if live.iter().any(|p| is_region(p.role)) {
            " (live regions)"
        } else if !live.is_empty() {
            " (live parameters)"
        } else {
            ""
        };
        let certificate = if m.block { &m.certificate.block } else { &m.certificate.diagonal };
        let measured = [certificate.trajectory_error, certificate.projection_floor];
        let large = has(SectionKind::StrainSizes);
        Ok(Self {
            bound: bound(file)?,
            measured: (m.block || m.diagonal || large).then_some(measured),
            loadable: m.n_load_nodes > 0 && has(SectionKind::SurfaceBasis),
            residual: has(SectionKind::ContactResidual),
            obstacle,
            live: LiveErrors::of(file)?,
        })
    }

    /// The bound, or that there is none; empty of a file without point loads. That of a parametric model
    /// is at two points of its box.
    pub(crate) fn bound(&self) -> Option<String> {
        let with_bound = |at: &CloserErrors| at.bound.map(|bound| bound_shares(&bound));
        let shares: Vec<String> = self.live.closer.iter().filter_map(with_bound).collect();
        if let [centre, worst] = &shares[..] {
            return Some(format!(
                "error estimate for any point load at the centre of the parameters' box: {centre}; at the worst of the \
                 measured points: {worst}"
            ));
        }
        match &self.bound {
            Some(bound) => Some(bound_words(bound)),
            None if self.loadable => Some(format!("no error bound for point loads{}", self.obstacle)),
            None => None,
        }
    }

    /// Errors of the test runs.
    pub(crate) fn measured(&self) -> Option<String> {
        if let Some(errors) = self.live.quantiles() {
            let [median, p95, worst] = errors.map(percent);
            let points = self.live.points.iter().filter(|point| !point.trained).count();
            let far = self.live.closer.iter().map(|at| at.reference_distance).fold(0.0, f64::max);
            let at_full_order = if self.live.closer.is_empty() {
                String::new()
            } else {
                format!("; their reference is within {} of a march at full order", percent(far))
            };
            return Some(format!(
                "test runs of the build at {points} points of the parameters' box that trained nothing: error {median} in \
                 the median, {p95} in 95 %, {worst} at worst (measured, no bound){at_full_order}"
            ));
        }
        let [error, floor] = self.measured?;
        let known = error.is_finite() && floor.is_finite();
        known.then(|| {
            format!(
                "test runs of the build: error up to {} of the motion, projection error up to {} (measured, no bound)",
                percent(error),
                percent(floor)
            )
        })
    }

    /// The warning of a file whose contacts have no residual flexibility.
    pub(crate) fn warning(&self) -> Option<String> {
        (self.loadable && !self.residual).then(|| {
            format!(
                "warning: contacts have no residual flexibility and no error bound{}: the displacement under a contact is \
                 that of the modes alone, and its error can be as large as itself",
                self.obstacle
            )
        })
    }

    /// All of that, a line each.
    pub(crate) fn lines(&self) -> Vec<String> {
        let unless_warned = |bound: &String| self.warning().is_none() || !bound.starts_with("no ");
        [self.bound().filter(unless_warned), self.measured(), self.warning()].into_iter().flatten().collect()
    }
}

/// True of the stiffness or the density of regions.
fn is_region(role: ParameterRole) -> bool {
    matches!(role, ParameterRole::RegionStiffness { .. } | ParameterRole::RegionDensity { .. })
}

/// The bound of the error of point loads.
pub(crate) fn bound_words(bound: &Bound) -> String {
    format!("error {} for any point load: {}", bound.kind, bound_shares(bound))
}

fn bound_shares(Bound { worst, median, p95, .. }: &Bound) -> String {
    let [median, p95, worst] = [median, p95, worst].map(|&share| percent(share));
    format!("median {median}, 95th percentile {p95}, worst {worst}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use vademecum_study::live_errors::PointErrors;

    fn of(bound: Option<Bound>, residual: bool) -> Accuracy {
        let measured = Some([3.3e-3, 3.2e-3]);
        let live = LiveErrors::default();
        Accuracy { bound, measured, loadable: true, residual, obstacle: " (live regions)", live }
    }

    #[test]
    fn the_bound_stands_first_and_the_runs_are_no_bound() {
        let bound = Bound { worst: 0.52, median: 4.6e-4, p95: 1.1e-2, kind: "bound" };
        let lines = of(Some(bound), true).lines();
        assert_eq!(
            lines[0],
            "error bound for any point load: median 0.046 %, 95th percentile 1.1 %, worst 52 %"
        );
        assert!(
            lines[1].contains("error up to 0.33 %") && lines[1].ends_with("(measured, no bound)"),
            "{lines:?}"
        );
        assert_eq!(lines.len(), 2);
    }

    #[test]
    fn contacts_without_residual_flexibility_are_warned_of() {
        let lines = of(None, false).lines();
        assert_eq!(lines.len(), 2);
        assert!(
            lines[1].starts_with(
                "warning: contacts have no residual flexibility and no error bound (live regions)"
            )
        );
    }

    #[test]
    fn errors_over_a_box_count_fresh_points_and_a_file_without_bound_says_so() {
        let point = |trained, trajectory_error| PointErrors { values: vec![], trained, trajectory_error };
        let closer =
            |bound| CloserErrors { values: vec![], trajectory_error: 0.02, reference_distance: 1e-5, bound };
        let points = vec![point(true, 0.9), point(false, 0.01), point(false, 0.02)];
        let said = |bound| {
            let live = LiveErrors { points: points.clone(), closer: vec![closer(bound), closer(bound)] };
            Accuracy { live, ..of(None, true) }.lines()
        };
        let lines = said(None);
        assert!(lines[0].starts_with("no error bound for point loads"), "{lines:?}");
        assert!(lines[1].contains("at 2 points") && lines[1].contains("2 % at worst"), "{lines:?}");
        assert!(lines[1].ends_with("within 0.001 % of a march at full order"), "{lines:?}");
        let lines = said(Some(Bound { worst: 0.5, median: 1e-3, p95: 1e-2, kind: "estimate" }));
        assert!(
            lines[0].contains("median 0.1 %, 95th percentile 1 %, worst 50 %; at the worst"),
            "{lines:?}"
        );
    }
}
