//! A scenario bound to a file and its problem, what the file shows of it, and what a verification returns.

use vademecum_build::Matrix;
use vademecum_build::dynamics::TimedLoad;
use vademecum_build::input::Problem;
use vademecum_build::prepared::{Body, Prepared, Setting};
use vademecum_build::progress::Listener;
use vademecum_eval::{Field, Tensor};
use vademecum_format::{File, SectionKind};

use super::model::{file_nodes, free_basis, full_order_loads};
use crate::contents::lines;
use crate::error::{FileError, StudyError};
use crate::notes::notes;
use crate::parameters::setting;
use crate::player::{PlayOptions, Playable, Track, play};
use crate::run::finite;
use crate::scenario::{STEPS_AT_FULL_ORDER, Scenario};
use crate::stress_error::StressCheck;

/// Most memory that the loads take at full order \[bytes\].
const MAX_LOAD_BYTES: u64 = 4_000_000_000;

/// A verification and the series behind it.
pub struct VerificationRecord<F> {
    /// The figures.
    pub figures: F,
    /// Step \[s\].
    pub time_step: f64,
    /// Start and end of each load \[s\], within the scenario.
    pub acting: Vec<[f64; 2]>,
    /// Names of the probes.
    pub probes: Vec<String>,
    /// Probe values, full order then file: shape (instants, probes), row-major.
    pub probe_series: [Vec<f64>; 2],
    /// Energies, full order then file.
    pub energy_series: [Vec<f64>; 2],
}

impl<F> VerificationRecord<F> {
    /// The same series with other figures.
    pub(super) fn with<G>(self, figures: impl FnOnce(F) -> G) -> VerificationRecord<G> {
        let Self { time_step, acting, probes, probe_series, energy_series, .. } = self;
        VerificationRecord {
            figures: figures(self.figures),
            time_step,
            acting,
            probes,
            probe_series,
            energy_series,
        }
    }

    /// The part of the scenario that a picture shows \[s\]: while loads come and go, and half as long again.
    #[must_use]
    pub fn shown_seconds(&self) -> f64 {
        let steps = self.energy_series[0].len().saturating_sub(1);
        let duration = steps as f64 * self.time_step;
        let ends = self.acting.iter().map(|[_, end]| *end).filter(|end| *end < duration);
        let last = ends.fold(0.0, f64::max);
        if last > 0.0 { duration.min(1.5 * last) } else { duration }
    }
}

/// A scenario bound to a file and the model of its problem: what verification starts from, linear or not.
pub struct BoundScenario<'a> {
    /// Mesh node of each node of the file.
    pub(crate) file_nodes: Vec<u32>,
    /// Step, scales and damping of the file.
    pub setting: Setting,
    /// Step of the file \[s\].
    pub time_step: f64,
    /// Steps that are marched.
    pub steps: usize,
    /// Loads of the scenario.
    pub track: Track,
    /// The same as forces over the free dofs.
    pub loads: Vec<TimedLoad>,
    /// Basis of the file over the free dofs, shape (n, r).
    pub basis: Matrix,
    /// Body of the problem.
    pub body: &'a Body,
}

impl<'a> BoundScenario<'a> {
    /// Binds the scenario to the file.
    ///
    /// # Errors
    /// [`StudyError`]: a file of another mesh or without its basis, a scenario that does not fit, more loads
    /// than memory.
    pub fn new(
        file: &File<'_>,
        options: &PlayOptions,
        problem: &Problem,
        prepared: &'a Prepared,
        scenario: &Scenario,
        listener: &dyn Listener,
    ) -> Result<Self, StudyError> {
        let body = &prepared.body;
        let metadata = file.metadata();
        if metadata.mesh_hash != body.mesh_hash {
            return Err(FileError::ForeignMesh { problem: problem.path.clone() }.into());
        }
        let file_nodes = file_nodes(file, body)?;
        let setting = setting(&options.scene, metadata, &prepared.space);
        let time_step = setting.step.time_step;
        let steps = scenario.steps_within(time_step, STEPS_AT_FULL_ORDER, options.long)?;
        let track = Track::bind(file, scenario)?;
        let (loads, dofs) = (track.contacts.len() + track.patterns.len(), body.n_dof());
        let bytes = 8 * loads as u64 * dofs as u64;
        if bytes > MAX_LOAD_BYTES {
            return Err(StudyError::TooManyLoads { loads, dofs, bytes, limit: MAX_LOAD_BYTES });
        }
        notes(file, scenario, &track, time_step, steps)?.iter().for_each(|note| listener.note(note));
        let loads = full_order_loads(file, &track, body, &file_nodes)?;
        let basis = free_basis(file, body, &file_nodes)?;
        Ok(Self { file_nodes, setting, time_step, steps, track, loads, basis, body })
    }

    /// Entry of the scenario of each contact.
    pub(super) fn entries(&self) -> Vec<usize> {
        self.track.contacts.iter().map(|placed| placed.entry).collect()
    }

    /// A verification of these figures and series, full order first.
    pub(super) fn verified<F>(
        &self,
        figures: F,
        (file, scenario): (&File<'_>, &Scenario),
        probe_series: [Vec<f64>; 2],
        energy_series: [Vec<f64>; 2],
    ) -> Result<VerificationRecord<F>, FileError> {
        let probes = lines(file, SectionKind::ProbeNames)?;
        let acting = scenario.acting();
        Ok(VerificationRecord {
            figures,
            time_step: self.time_step,
            acting,
            probes,
            probe_series,
            energy_series,
        })
    }

    /// The first instant at which no load acts any more, in steps.
    pub fn release(&self) -> usize {
        ((self.track.release() / self.time_step).ceil() as usize).min(self.steps)
    }
}

/// Series of the file at every instant of the scenario, the start included.
#[derive(Default)]
pub(super) struct PlayedSeries {
    pub(crate) structure: &'static str,
    /// Reduced coordinates, one instant after the other.
    pub(crate) coordinates: Vec<f64>,
    pub(crate) energy: Vec<f64>,
    pub(crate) probes: Vec<f64>,
    /// Under each contact along its force, times its size \[N m\]; one instant after the other.
    pub(crate) under_contacts: Vec<f64>,
    /// At the points of the check, one instant after the other \[Pa\].
    pub(crate) stresses: Vec<Tensor>,
}

/// Plays a track and takes what the file shows.
pub(super) fn show(
    file: &File<'_>,
    options: &PlayOptions,
    track: &Track,
    stress: Option<&StressCheck>,
    (steps, time_step): (usize, f64),
    listener: &dyn Listener,
) -> Result<PlayedSeries, StudyError> {
    let mut shown = PlayedSeries::default();
    let names = lines(file, SectionKind::ProbeNames)?;
    play(file, options, track, steps, listener, shown.watch(names, track, stress, time_step))?;
    Ok(shown)
}

impl PlayedSeries {
    /// Closure that records a body after each step.
    pub(crate) fn watch<'a>(
        &'a mut self,
        names: Vec<String>,
        track: &'a Track,
        stress: Option<&'a StressCheck>,
        time_step: f64,
    ) -> impl FnMut(usize, &mut dyn Playable<Number = f64>) -> Result<(), StudyError> + 'a {
        let mut values = vec![0.0; names.len()];
        move |step, body: &mut dyn Playable<Number = f64>| {
            self.structure = body.structure();
            self.coordinates.extend_from_slice(body.zeta());
            let energy = body.energy()?;
            for (probe, value) in values.iter_mut().enumerate() {
                *value = body.probe(probe)?;
            }
            finite(step, time_step, body.zeta(), energy, &values, &names)?;
            for placed in &track.contacts {
                let moved = body.point(&placed.point, Field::Displacement)?;
                let along = moved.iter().zip(placed.contact.force).map(|(u, f)| u * f).sum();
                self.under_contacts.push(along);
            }
            if let Some(stress) = stress {
                stress.take(body, &mut self.stresses)?;
            }
            self.energy.push(energy);
            self.probes.extend_from_slice(&values);
            Ok(())
        }
    }
}
