//! A file of large displacements beside the same scenario at large displacements and full order.
//!
//! The reference is marched by Bathe's method with a quarter of the file's step, and beside it a second one
//! with twice that step: how far the two are apart says how well the reference is known. Where that is not
//! well enough to see the error of the file, both are marched again with half of their steps. Nothing of any
//! march is kept but sums.
//!
//! A scaled stiffness `s` or density `d` is a matter of units: with the time `τ = c t`, `c² = s/d`, a body
//! under `F/s` moves as the one that was built, with the damping `α/c` and `β c`.

use std::time::Instant;

use faer::{Mat, MatRef};
use serde::Serialize;
use vademecum_build::dynamics::large::{
    LargeDamping, LargeError, LargeMarch, LargeScheme, LargeState, LargeWork, Newton,
};
use vademecum_build::dynamics::{ErrorMeter, History, TimedLoad, TrajectoryError, Work};
use vademecum_build::fem::GreenStrain;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::BuildError;
use vademecum_build::prepared::{Body, Prepared, Setting};
use vademecum_build::progress::Listener;
use vademecum_eval::StructureChoice;
use vademecum_format::{File, SectionKind};

use super::asked::{Asked, Shown, Verified, show};
use super::model::{free_basis, full_order_loads};
use crate::compare::{coordinate_matrix, orthonormal};
use crate::contents::lines;
use crate::error::{FileError, StudyError};
use crate::parameters::{ParameterValue, values};
use crate::player::{PlayOptions, long_run, play_metered};
use crate::scenario::Scenario;
use crate::truth::force_row;

/// Steps of the reference in a step of the file, at first and at most.
const PARTS: [usize; 2] = [4, 16];

/// How far the reference may be from the march beside it, as a part of the error of the file: the error of
/// the reference itself is then about a tenth of that of the file.
const KNOWN: f64 = 0.3;

/// Steps of the free run that times a step of the file.
const TIMED_STEPS: usize = 20_000;

/// What was measured beside the motion at large displacements. Errors are relative L2 over all steps and,
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
    /// How far the loadable surface moves at most, at full order \[m\].
    pub displacement: f64,
    /// Error of the file.
    pub trajectory_error: f64,
    /// Of the projection of the reference on the basis: what no coordinates could mend.
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
    /// Largest violation of the energy's identity in any step of the file, over the largest energy.
    pub energy_identity: f64,
    /// Energy at the end over energy at release, less 1, through the file.
    pub energy_drift: f64,
    /// The same at full order.
    pub energy_drift_full_order: f64,
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
) -> Result<Verified<LargeVerification>, StudyError> {
    if scenario.free.is_some() {
        return Err(FileError::NotFree.into());
    }
    let asked = Asked::new(file, options, problem, prepared, scenario, listener)?;
    let Asked { ref file_nodes, ref setting, time_step, steps, ref track, body } = asked;
    let loads = full_order_loads(file, track, body, file_nodes)?;
    let strain = GreenStrain::new(&body.model)?;
    let reference = |parts: usize| -> Result<Reference<'_>, StudyError> {
        let reference = Reference::new(&strain, prepared, setting, &loads, parts)?;
        let work = reference.work(steps)?;
        work.check(options.long, || WHAT.into())?;
        listener.note(&format!("{WHAT}: {}", work.in_words()));
        Ok(reference)
    };
    let mut marched = reference(PARTS[0])?;

    listener.stage("step the file");
    let mut shown = Shown::default();
    let watch = shown.watch(lines(file, SectionKind::ProbeNames)?, track, None, time_step);
    let energy_identity = play_metered(file, &options.scene, track, steps, listener, watch)?;
    let mut straight = *options;
    straight.scene.structure = StructureChoice::Exact;
    let linear = show(file, &straight, track, None, (steps, time_step), listener)?;
    let timing = long_run(file, options, track, TIMED_STEPS, listener)?;

    let basis = free_basis(file, body, file_nodes)?;
    let modes = file.metadata().n_modes as usize;
    // Through the strain structure and through the linear one, side by side for each instant.
    let coordinates = [&shown, &linear].map(|shown| coordinate_matrix(modes, &shown.coordinates));
    let pairs = Mat::from_fn(modes, 2 * (1 + steps), |k, i| coordinates[i % 2][(k, i / 2)]);
    let (basis, pairs) = orthonormal(body.model.pencil().mass(), basis.as_ref(), pairs.as_ref())?;
    let entries: Vec<usize> = track.contacts.iter().map(|placed| placed.entry).collect();
    let beside = Beside {
        body,
        basis: basis.as_ref(),
        pairs: pairs.as_ref(),
        entries: &entries,
        under: &shown.under_contacts,
        time_step,
    };
    let found = loop {
        listener.stage("march full order");
        let found = beside.measure(&marched, steps, listener)?;
        let enough = found.apart <= KNOWN * found.errors[0].error || marched.parts == PARTS[1];
        if enough {
            break found;
        }
        listener.note(&format!(
            "the reference is {:.1e} from a march with twice its step, and the file {:.1e} from the reference: both \
             are marched again with half of their steps",
            found.apart, found.errors[0].error
        ));
        match reference(2 * marched.parts) {
            Ok(finer) => marched = finer,
            Err(StudyError::Build(BuildError::Work(refused))) => {
                listener.note(&format!("they are not: {refused}"));
                break found;
            }
            Err(error) => return Err(error),
        }
    };
    let drift = |series: &[f64]| series[steps] / series[asked.release()] - 1.0;
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
        truth_parts: marched.parts,
        contact_error: found.contact,
        energy_identity,
        energy_drift: drift(&shown.energy),
        energy_drift_full_order: drift(&found.energy),
        full_order_seconds_per_step: found.seconds / steps as f64,
        vademecum_seconds_per_step: timing.seconds_per_step,
    };
    Ok(Verified {
        figures,
        time_step,
        acting: scenario.acting(),
        probes: lines(file, SectionKind::ProbeNames)?,
        probe_series: [found.probes, shown.probes],
        energy_series: [found.energy, shown.energy],
    })
}

/// What is marched, for people.
const WHAT: &str = "the march at full order and large displacements, and one with twice its step";

/// What the reference is compared with.
struct Beside<'a> {
    body: &'a Body,
    /// The basis, orthonormal in the mass.
    basis: MatRef<'a, f64>,
    /// Coordinates through the strain structure and through the linear one, side by side for each instant.
    pairs: MatRef<'a, f64>,
    /// The contact of the scenario that each load belongs to.
    entries: &'a [usize],
    /// What the file shows under each, along its force and times its size; one instant after the other.
    under: &'a [f64],
    time_step: f64,
}

/// What one march of the reference gave.
struct Found {
    /// Of the strain structure and of the linear one.
    errors: [TrajectoryError; 2],
    /// Distance from the march with twice the step.
    apart: f64,
    contact: Option<f64>,
    displacement: f64,
    energy: Vec<f64>,
    /// Shape (instants, probes), row-major.
    probes: Vec<f64>,
    /// Wall time \[s\].
    seconds: f64,
}

impl Beside<'_> {
    fn measure(
        &self,
        reference: &Reference<'_>,
        steps: usize,
        listener: &dyn Listener,
    ) -> Result<Found, StudyError> {
        let Self { body, basis, pairs, entries, under, time_step } = *self;
        let mass = body.model.pencil().mass();
        let mut meter = ErrorMeter::new(mass, basis, 2);
        // Squares of a distance and of what it is a share of.
        let mut apart = [0.0; 2];
        let mut contacts = vec![[0.0; 2]; entries.last().map_or(0, |last| last + 1)];
        let mut displacement = 0.0_f64;
        let rows: Vec<_> = body.probes.iter().map(|probe| body.probe_row(probe)).collect();
        let (mut energy, mut probes) = (vec![], vec![]);
        let seconds = reference.march(steps, listener, |step, [fine, coarse], joules| {
            let both = Mat::from_fn(fine.len(), 2, |i, _| fine[i]);
            meter.add(both.as_ref(), pairs.subcols(2 * step, 2));
            let difference: Vec<f64> = fine.iter().zip(coarse).map(|(a, b)| a - b).collect();
            apart[0] += mass.inner(&difference, &difference);
            apart[1] += mass.inner(fine, fine);
            displacement = displacement.max(largest_displacement(body, fine));
            energy.push(joules);
            probes.extend(rows.iter().map(|row| along(row, fine)));
            let under = &under[step * entries.len()..];
            for ((load, &entry), shown) in reference.loads.iter().zip(entries).zip(under) {
                if load.when.factor(step as f64 * time_step) != 0.0 {
                    let exact = along(&load.row, fine);
                    contacts[entry][0] += (exact - shown).powi(2);
                    contacts[entry][1] += exact.powi(2);
                }
            }
        })?;
        let moved = contacts.iter().filter(|[_, whole]| *whole > 0.0);
        Ok(Found {
            errors: [0, 1].map(|column| meter.errors()[column]),
            apart: (apart[0] / apart[1]).sqrt(),
            contact: moved.map(|[error, whole]| (error / whole).sqrt()).reduce(f64::max),
            displacement,
            energy,
            probes,
            seconds,
        })
    }
}

/// A force over the free dofs, where it is not zero, and how it follows time.
struct SparseLoad {
    row: Vec<(u32, f64)>,
    when: History,
}

/// The reference, and the march with twice its step.
struct Reference<'a> {
    /// Steps of the reference in a step of the file.
    parts: usize,
    marches: [LargeMarch<'a>; 2],
    loads: Vec<SparseLoad>,
    n: usize,
    /// Step of the file \[s\].
    time_step: f64,
    /// `c`.
    pace: f64,
    /// `s`.
    stiffness: f64,
}

/// Where both are.
struct Moving {
    states: [LargeState; 2],
    works: [LargeWork; 2],
}

impl<'a> Reference<'a> {
    fn new(
        strain: &'a GreenStrain<'a>,
        prepared: &'a Prepared,
        setting: &Setting,
        loads: &[TimedLoad],
        parts: usize,
    ) -> Result<Self, StudyError> {
        let step = &setting.step;
        let pace = (step.stiffness / step.density).sqrt();
        let damping = LargeDamping { mass: step.alpha / pace, stiffness: 0.0, strain_rate: step.beta * pace };
        let march = |parts: usize| {
            let length = pace * step.time_step / parts as f64;
            let scheme = LargeScheme::bathe();
            LargeMarch::new(strain, &prepared.symbolic, scheme, length, damping, Newton::default())
        };
        let [fine, coarse] = [parts, parts / 2].map(march);
        let sparse = |load: &TimedLoad| SparseLoad { row: force_row(load), when: load.when.clone() };
        Ok(Self {
            parts,
            marches: [fine?, coarse?],
            loads: loads.iter().map(sparse).collect(),
            n: strain.n_dof(),
            time_step: step.time_step,
            pace,
            stiffness: step.stiffness,
        })
    }

    /// Adds the loads at a time of the march; where one jumps, the mean of both sides.
    fn force(&self, time: f64, out: &mut [f64]) {
        let time = time / self.pace;
        for load in &self.loads {
            let factor = 0.5 * (load.when.just_before(time) + load.when.just_after(time));
            load.add(factor / self.stiffness, out);
        }
    }

    fn start(&self, force: &Force<'_>) -> Result<Moving, LargeError> {
        let rest = vec![0.0; self.n];
        let start = |march: &LargeMarch<'_>| march.start(&rest, &rest, &mut |t, out| force(t, out));
        let [fine, coarse] = &self.marches;
        Ok(Moving { states: [start(fine)?, start(coarse)?], works: Default::default() })
    }

    /// One step of the file, both marches side by side; the wall time of the reference \[s\].
    fn advance(&self, moving: &mut Moving, force: &Force<'_>) -> Result<f64, LargeError> {
        let ([fine, coarse], [of_fine, of_coarse]) = (&mut moving.states, &mut moving.works);
        let go = |parts: usize, state: &mut LargeState, work: &mut LargeWork| {
            let march = &self.marches[usize::from(parts < self.parts)];
            let start = Instant::now();
            for _ in 0..parts {
                march.step(state, &mut |time, out| force(time, out), work)?;
            }
            Ok(start.elapsed().as_secs_f64())
        };
        std::thread::scope(|scope| {
            let beside = scope.spawn(|| go(self.parts / 2, coarse, of_coarse));
            let seconds = go(self.parts, fine, of_fine);
            beside.join().expect("a march does not panic")?;
            seconds
        })
    }

    /// What the marches over `steps` steps of the file are about to take, measured on a few from rest under
    /// the loads of the instant at which they are largest.
    fn work(&self, steps: usize) -> Result<Work, LargeError> {
        const FEW: usize = 3;
        const LOOKED_AT: usize = 1000;
        let size = |step: &usize| -> f64 {
            let time = *step as f64 * self.time_step;
            let of = |load: &SparseLoad| {
                load.when.factor(time).abs() * load.row.iter().map(|(_, f)| f.abs()).sum::<f64>()
            };
            self.loads.iter().map(of).sum()
        };
        let instants = (0..=steps).step_by(1 + steps / LOOKED_AT);
        let loudest = instants.max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(0);
        let mut held = vec![0.0; self.n];
        self.force(self.pace * loudest as f64 * self.time_step, &mut held);
        let force = |_: f64, out: &mut [f64]| out.copy_from_slice(&held);
        let mut moving = self.start(&force)?;
        let start = Instant::now();
        for _ in 0..FEW.min(steps) {
            self.advance(&mut moving, &force)?;
        }
        let seconds = start.elapsed().as_secs_f64() / FEW as f64 * steps as f64;
        Ok(Work { steps: ((self.parts + self.parts / 2) * steps) as f64, seconds })
    }

    /// Marches from rest and shows the displacements of both after each step, the start too, with the energy
    /// of the reference \[J\]. Its wall time \[s\].
    fn march(
        &self,
        steps: usize,
        listener: &dyn Listener,
        mut observe: impl FnMut(usize, [&[f64]; 2], f64),
    ) -> Result<f64, StudyError> {
        let force = |time: f64, out: &mut [f64]| self.force(time, out);
        let mut moving = self.start(&force)?;
        let mut seconds = 0.0;
        for step in 0..=steps {
            if step > 0 {
                seconds += self.advance(&mut moving, &force)?;
            }
            let [fine, coarse] = &moving.states;
            let energy = self.stiffness * self.marches[0].energy(fine);
            observe(step, [&fine.displacement, &coarse.displacement], energy);
            listener.checkpoint(step, steps)?;
        }
        Ok(seconds)
    }
}

/// A force that both marches ask for.
type Force<'f> = dyn Fn(f64, &mut [f64]) + Sync + 'f;

impl SparseLoad {
    fn add(&self, factor: f64, out: &mut [f64]) {
        if factor != 0.0 {
            self.row.iter().for_each(|&(dof, force)| out[dof as usize] += factor * force);
        }
    }
}

/// A row over the free dofs times a displacement.
fn along(row: &[(u32, f64)], displacement: &[f64]) -> f64 {
    row.iter().map(|&(dof, weight)| weight * displacement[dof as usize]).sum()
}

/// How far the loadable surface moves \[m\].
fn largest_displacement(body: &Body, displacement: &[f64]) -> f64 {
    let dofs = body.model.dofs();
    let moved = |dof: u32| dofs.free(dof as usize).map_or(0.0, |free| displacement[free as usize]);
    let square = |&node: &u32| (0..3).map(|c| moved(3 * node + c).powi(2)).sum::<f64>();
    body.load_nodes.iter().map(square).fold(0.0, f64::max).sqrt()
}
