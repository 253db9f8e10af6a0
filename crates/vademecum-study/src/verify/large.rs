//! A file of large displacements beside the same scenario at large displacements and full order.
//!
//! Nothing of any march is kept but sums.

use faer::{Mat, MatRef};
use serde::Serialize;
use vademecum_build::dynamics::{ErrorMeter, TrajectoryError};
use vademecum_build::fem::GreenStrain;
use vademecum_build::input::Problem;
use vademecum_build::measured::{measured, reference_measured};
use vademecum_build::prepared::{Body, Prepared};
use vademecum_build::progress::Listener;
use vademecum_eval::StructureChoice;
use vademecum_format::{File, SectionKind};

use super::bound_scenario::{BoundScenario, PlayedSeries, VerificationRecord, show};
use crate::compare::{coordinate_matrix, orthonormal};
use crate::contents::lines;
use crate::error::{FileError, StudyError};
use crate::large_motion::{Extent, LargeMotion, MarchDistance, Reference};
use crate::parameters::{ParameterValue, values};
use crate::player::{PlayOptions, long_run, play_metered};
use crate::scenario::Scenario;
use crate::truth::{largest_error, relative_errors};

/// Steps of the reference in a step of the file, at first.
const PARTS: usize = 4;

/// Steps of the free run that times a step of the file.
const TIMED_STEPS: usize = 20_000;

/// Comparison with the motion at large displacements. Errors are relative L2 over all steps and,
/// where nothing else is said, over all dofs in the mass norm.
#[derive(Clone, Debug, Serialize)]
pub struct LargeVerification {
    /// Steps marched.
    pub steps: usize,
    /// Free dofs.
    pub dofs: usize,
    /// Coordinates.
    pub modes: usize,
    /// Structure of the step.
    pub structure: &'static str,
    /// Step \[s\].
    pub time_step: f64,
    /// Values of the file's live parameters; none if it has none.
    pub parameters: Vec<ParameterValue>,
    /// Largest displacement of the loadable surface at full order \[m\].
    pub displacement: f64,
    /// Error of the file.
    pub trajectory_error: f64,
    /// Of the projection of the reference on the basis: the projection error.
    pub projection_floor: f64,
    /// Of the linear motion of the same modes and shapes, stepped exactly.
    pub linear_error: f64,
    /// Distance of the reference from a march with twice its step. Of a smooth motion the error of the
    /// reference is about a third of it.
    pub truth_error: f64,
    /// Steps of the reference in a step of the file.
    pub truth_parts: usize,
    /// Of the displacement under a contact, along its force, while the force acts; the largest of all
    /// contacts. None if the scenario has no contact that moves its point.
    pub contact_error: Option<f64>,
    /// The same of each contact, in the order of the scenario.
    pub contact_errors: Vec<Option<f64>>,
    /// Largest violation of the energy's identity in any step of the file, over the largest energy.
    pub energy_identity: f64,
    /// Energy at the end over energy at release, less 1, through the file.
    /// `None` where a load acts to the end.
    pub energy_drift: Option<f64>,
    /// The same at full order.
    pub energy_drift_full_order: Option<f64>,
    /// Wall time of a step of the file at full order, `truth_parts` steps of Bathe's method \[s\].
    pub full_order_seconds_per_step: f64,
    /// Wall time of one step through the file \[s\].
    pub vademecum_seconds_per_step: f64,
}

/// [`verify`](super::verify()) beside the motion at large displacements.
///
/// # Errors
/// As [`verify`](super::verify()); [`FileError::NotFree`]: a scenario that throws the body;
/// [`StudyError::LargeMarch`]: Newton's method finds no next step.
pub fn verify_large(
    file: &File<'_>,
    options: &PlayOptions,
    problem: &Problem,
    prepared: &Prepared,
    scenario: &Scenario,
    listener: &dyn Listener,
) -> Result<VerificationRecord<LargeVerification>, StudyError> {
    if scenario.free.is_some() {
        return Err(FileError::NotFree.into());
    }
    let bound = BoundScenario::new(file, options, problem, prepared, scenario, listener)?;
    let BoundScenario { ref setting, time_step, steps, ref track, ref loads, body, .. } = bound;
    let strain = GreenStrain::new(&body.model)?;
    let motion = LargeMotion::new(&strain, prepared, setting, loads);
    let extent = Extent { steps, beside: 0, long: options.long, what: WHAT };
    let reference = motion.reference(PARTS, &extent, listener)?;
    listener.stage("step the file");
    let mut shown = PlayedSeries::default();
    let watch = shown.watch(lines(file, SectionKind::ProbeNames)?, track, None, time_step);
    let energy_identity = play_metered(file, &options.scene, track, steps, listener, watch)?;
    let mut straight = *options;
    straight.scene.structure = StructureChoice::Exact;
    let linear = show(file, &straight, track, None, (steps, time_step), listener)?;
    let timing = long_run(file, options, track, TIMED_STEPS, listener)?;

    let modes = file.metadata().n_modes as usize;
    // Through the strain structure and through the linear one, side by side for each instant.
    let coordinates = [&shown, &linear].map(|shown| coordinate_matrix(modes, &shown.coordinates));
    let pairs = Mat::from_fn(modes, 2 * (1 + steps), |k, i| coordinates[i % 2][(k, i / 2)]);
    let (basis, pairs) = orthonormal(body.model.pencil().mass(), bound.basis.as_ref(), pairs.as_ref())?;
    let entries = bound.entries();
    let beside = LargeComparison {
        body,
        basis: basis.as_ref(),
        pairs: pairs.as_ref(),
        entries: &entries,
        under: &shown.under_contacts,
        time_step,
    };
    let (found, truth_parts) = motion.known(reference, &extent, listener, |reference| {
        let found = beside.measure(reference, &motion, steps, listener)?;
        let shown = [found.apart, found.errors[0].error];
        Ok((found, shown))
    })?;
    let release = bound.release();
    let drift = |series: &[f64]| (release < steps).then(|| series[steps] / series[release] - 1.0);
    let [own, linear] = found.errors;
    let figures = LargeVerification {
        steps,
        dofs: body.n_dof(),
        modes,
        structure: shown.structure,
        time_step,
        parameters: values(&options.scene, file.metadata()),
        displacement: found.displacement,
        trajectory_error: own.error,
        projection_floor: own.floor,
        linear_error: linear.error,
        truth_error: found.apart,
        truth_parts,
        contact_error: largest_error(&found.contacts),
        contact_errors: found.contacts,
        energy_identity,
        energy_drift: drift(&shown.energy),
        energy_drift_full_order: drift(&found.energy),
        full_order_seconds_per_step: found.seconds / steps as f64,
        vademecum_seconds_per_step: timing.seconds_per_step,
    };
    reference_measured("truth_error", figures.truth_error)?;
    measured(&[
        ("displacement", figures.displacement),
        ("trajectory_error", figures.trajectory_error),
        ("projection_floor", figures.projection_floor),
        ("linear_error", figures.linear_error),
        ("contact_error", figures.contact_error.unwrap_or(0.0)),
        ("energy_identity", figures.energy_identity),
        ("energy_drift", figures.energy_drift.unwrap_or(0.0)),
        ("energy_drift_full_order", figures.energy_drift_full_order.unwrap_or(0.0)),
    ])?;
    let (probes, energies) = ([found.probes, shown.probes], [found.energy, shown.energy]);
    Ok(bound.verified(figures, (file, scenario), probes, energies)?)
}

/// Description for messages.
const WHAT: &str = "the march at full order and large displacements, and one with twice its step";

/// Reduced motions that are compared with the reference.
struct LargeComparison<'a> {
    body: &'a Body,
    /// The basis, orthonormal in the mass.
    basis: MatRef<'a, f64>,
    /// Coordinates through the strain structure and through the linear one, side by side for each instant.
    pairs: MatRef<'a, f64>,
    /// The contact of the scenario that each load belongs to.
    entries: &'a [usize],
    /// Displacement of the file under each, along its force and times its size; one instant after the other.
    under: &'a [f64],
    time_step: f64,
}

/// Result of one march of the reference.
struct LargeFigures {
    /// Of the strain structure and of the linear one.
    errors: [TrajectoryError; 2],
    /// Distance from the march with twice the step.
    apart: f64,
    contacts: Vec<Option<f64>>,
    displacement: f64,
    energy: Vec<f64>,
    /// Shape (instants, probes), row-major.
    probes: Vec<f64>,
    /// Wall time \[s\].
    seconds: f64,
}

impl LargeComparison<'_> {
    fn measure(
        &self,
        reference: &Reference<'_>,
        motion: &LargeMotion<'_>,
        steps: usize,
        listener: &dyn Listener,
    ) -> Result<LargeFigures, StudyError> {
        let Self { body, basis, pairs, entries, under, time_step } = *self;
        let mass = body.model.pencil().mass();
        let mut meter = ErrorMeter::new(mass, basis, 2);
        let mut apart = MarchDistance::default();
        // Squares of a distance and of what it is a share of.
        let mut contacts = vec![[0.0; 2]; entries.last().map_or(0, |last| last + 1)];
        let mut displacement = 0.0_f64;
        let rows: Vec<_> = body.probes.iter().map(|probe| body.probe_row(probe)).collect();
        let (mut energy, mut probes) = (vec![], vec![]);
        let seconds = reference.march(steps, listener, |step, [fine, coarse], joules| {
            let both = Mat::from_fn(fine.len(), 2, |i, _| fine[i]);
            meter.add(both.as_ref(), pairs.subcols(2 * step, 2));
            apart.add(mass, [fine, coarse]);
            displacement = displacement.max(body.largest_displacement(fine));
            energy.push(joules);
            probes.extend(rows.iter().map(|row| along(row, fine)));
            let under = &under[step * entries.len()..];
            for ((load, &entry), shown) in motion.loads().iter().zip(entries).zip(under) {
                if load.when.factor(step as f64 * time_step) != 0.0 {
                    let exact = along(&load.row, fine);
                    contacts[entry][0] += (exact - shown).powi(2);
                    contacts[entry][1] += exact.powi(2);
                }
            }
        })?;
        Ok(LargeFigures {
            errors: [0, 1].map(|column| meter.errors()[column]),
            apart: apart.share(),
            contacts: relative_errors(&contacts),
            displacement,
            energy,
            probes,
            seconds,
        })
    }
}

/// A row over the free dofs times a displacement.
fn along(row: &[(u32, f64)], displacement: &[f64]) -> f64 {
    row.iter().map(|&(dof, weight)| weight * displacement[dof as usize]).sum()
}
