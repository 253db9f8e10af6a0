//! A body under the loads of a scenario at large displacements and full order, and how well its motion is
//! known: what `verify` and the laboratory measure against.
//!
//! A reference is marched by Bathe's method with a part of the file's step, and beside it a second one with
//! twice that step: how far the two are apart says how well the reference is known. Where that is not well
//! enough to see an error, both are marched again with half of their steps.
//!
//! A scaled stiffness `s` or density `d` is a matter of units: with the time `τ = c t`, `c² = s/d`, a body
//! under `F/s` moves as the one that was built, with the damping `α/c` and `β c`.

use std::time::Instant;

use vademecum_build::dynamics::large::{
    LargeDamping, LargeError, LargeMarch, LargeScheme, LargeState, LargeWork, Newton,
};
use vademecum_build::dynamics::{History, TimedLoad, Work};
use vademecum_build::fem::{GreenStrain, Symbolic, SymmetricMatrix};
use vademecum_build::pipeline::BuildError;
use vademecum_build::prepared::{Prepared, Setting};
use vademecum_build::progress::Listener;

use crate::error::StudyError;
use crate::truth::force_row;

/// Most steps of a reference in a step of the file.
const MAX_PARTS: usize = 16;

/// Largest distance of a reference from the march beside it, as a part of the error that it shows: its own
/// error is then about a tenth of that.
const KNOWN: f64 = 0.3;

/// A body and its loads.
pub struct LargeMotion<'a> {
    strain: &'a GreenStrain<'a>,
    symbolic: &'a Symbolic,
    loads: Vec<SparseLoad>,
    damping: LargeDamping,
    /// Step of the file \[s\].
    time_step: f64,
    /// `c`.
    pace: f64,
    /// `s`.
    stiffness: f64,
}

/// A force over the free dofs, where it is not zero, and how it follows time.
pub struct SparseLoad {
    /// Free dofs and their forces \[N\].
    pub row: Vec<(u32, f64)>,
    /// Course in time.
    pub when: History,
}

/// Extent of the marches.
#[derive(Clone, Copy)]
pub struct Extent {
    /// Steps of the file.
    pub steps: usize,
    /// Steps of Bathe's method in a step of the file that are marched beside a reference.
    pub beside: usize,
    /// Allow more than four hours.
    pub long: bool,
    /// Description for messages.
    pub what: &'static str,
}

/// The reference, and the march with twice its step.
pub struct Reference<'m> {
    /// Steps of the reference in a step of the file.
    pub parts: usize,
    motion: &'m LargeMotion<'m>,
    marches: [LargeMarch<'m>; 2],
}

/// A march on its way.
struct RunningMarch<'m> {
    march: &'m LargeMarch<'m>,
    /// Steps of it in a step of the file.
    parts: usize,
    state: LargeState,
    work: LargeWork,
}

/// A force that marches ask for.
type Force<'f> = dyn Fn(f64, &mut [f64]) + Sync + 'f;

impl<'a> LargeMotion<'a> {
    /// The body of a problem under loads, with the step, the damping and the scales of a setting.
    pub fn new(
        strain: &'a GreenStrain<'a>,
        prepared: &'a Prepared,
        setting: &Setting,
        loads: &[TimedLoad],
    ) -> Self {
        let step = &setting.step;
        let pace = (step.stiffness / step.density).sqrt();
        let sparse = |load: &TimedLoad| SparseLoad { row: force_row(load), when: load.when.clone() };
        Self {
            strain,
            symbolic: &prepared.symbolic,
            loads: loads.iter().map(sparse).collect(),
            damping: LargeDamping { mass: step.alpha / pace, stiffness: 0.0, strain_rate: step.beta * pace },
            time_step: step.time_step,
            pace,
            stiffness: step.stiffness,
        }
    }

    /// The loads, in the order in which they were given.
    pub fn loads(&self) -> &[SparseLoad] {
        &self.loads
    }

    /// A march of it by Bathe's method with `parts` steps in a step of the file.
    ///
    /// # Errors
    /// [`LargeError`]: a step or damping that makes no sense.
    pub fn march(&self, parts: usize) -> Result<LargeMarch<'a>, LargeError> {
        let length = self.pace * self.time_step / parts as f64;
        let scheme = LargeScheme::bathe();
        LargeMarch::new(self.strain, self.symbolic, scheme, length, self.damping, Newton::default())
    }

    /// Marches from rest over `steps` steps of the file and shows the displacement after each, the start
    /// first. The wall time of each \[s\].
    ///
    /// # Errors
    /// [`StudyError::LargeMarch`], or the listener stops it.
    pub fn follow(
        &self,
        march: &LargeMarch<'_>,
        parts: usize,
        steps: usize,
        listener: &dyn Listener,
        mut observe: impl FnMut(usize, &[f64]),
    ) -> Result<Vec<f64>, StudyError> {
        let force = |time: f64, out: &mut [f64]| self.force(time, out);
        let mut moving = RunningMarch::new(march, parts, self.strain.n_dof(), &force)?;
        observe(0, &moving.state.displacement);
        let mut seconds = Vec::with_capacity(steps);
        for step in 1..=steps {
            seconds.push(moving.advance(&force)?);
            observe(step, &moving.state.displacement);
            listener.checkpoint(step, steps)?;
        }
        Ok(seconds)
    }

    /// A reference with `parts` steps in a step of the file, once its work is reported or refused.
    ///
    /// # Errors
    /// [`StudyError::LargeMarch`], [`StudyError::Build`]: more work than was asked for.
    pub fn reference<'m>(
        &'m self,
        parts: usize,
        extent: &Extent,
        listener: &dyn Listener,
    ) -> Result<Reference<'m>, StudyError> {
        let marches = [self.march(parts)?, self.march(parts / 2)?];
        let reference = Reference { parts, motion: self, marches };
        let own = reference.work(extent.steps)?;
        let work = own.times(1.0 + extent.beside as f64 / (parts + parts / 2) as f64);
        work.check(extent.long, || extent.what.into())?;
        listener.note(&format!("{}: {}", extent.what, work.in_words()));
        Ok(reference)
    }

    /// Result of `measure` beside a reference. It also gives how far the reference was from the march beside
    /// it, and the error that it should show: where the one is too much for the other, both are marched again
    /// with half of their steps. With the steps of the last reference in a step of the file.
    ///
    /// # Errors
    /// [`StudyError::LargeMarch`], [`StudyError::Build`]: more work than was asked for; those of `measure`.
    pub fn known<'m, R>(
        &'m self,
        mut reference: Reference<'m>,
        extent: &Extent,
        listener: &dyn Listener,
        mut measure: impl FnMut(&Reference<'_>) -> Result<(R, [f64; 2]), StudyError>,
    ) -> Result<(R, usize), StudyError> {
        loop {
            listener.stage("march full order");
            let (found, [apart, error]) = measure(&reference)?;
            if apart <= KNOWN * error || 2 * reference.parts > MAX_PARTS {
                return Ok((found, reference.parts));
            }
            listener.note(&format!(
                "the reference is {apart:.1e} from a march with twice its step, and the file {error:.1e} from the \
                 reference: both are marched again with half of their steps"
            ));
            match self.reference(2 * reference.parts, extent, listener) {
                Ok(finer) => reference = finer,
                Err(StudyError::Build(BuildError::Work(refused))) => {
                    listener.note(&format!("they are not: {refused}"));
                    return Ok((found, reference.parts));
                }
                Err(error) => return Err(error),
            }
        }
    }

    /// Adds the loads at a time of the march; where one jumps, the mean of both sides.
    fn force(&self, time: f64, out: &mut [f64]) {
        let time = time / self.pace;
        for load in &self.loads {
            let factor = 0.5 * (load.when.just_before(time) + load.when.just_after(time));
            load.add(factor / self.stiffness, out);
        }
    }
}

impl<'m> Reference<'m> {
    fn start(&self, force: &Force<'_>) -> Result<[RunningMarch<'_>; 2], LargeError> {
        let ([fine, coarse], n) = (&self.marches, self.motion.strain.n_dof());
        Ok([
            RunningMarch::new(fine, self.parts, n, force)?,
            RunningMarch::new(coarse, self.parts / 2, n, force)?,
        ])
    }

    /// Estimated work of the marches over `steps` steps of the file, measured on a few from rest under
    /// the loads of the instant at which they are largest.
    fn work(&self, steps: usize) -> Result<Work, LargeError> {
        const FEW: usize = 3;
        const LOOKED_AT: usize = 1000;
        let motion = self.motion;
        let size = |step: &usize| -> f64 {
            let time = *step as f64 * motion.time_step;
            let of = |load: &SparseLoad| {
                load.when.factor(time).abs() * load.row.iter().map(|(_, f)| f.abs()).sum::<f64>()
            };
            motion.loads.iter().map(of).sum()
        };
        let instants = (0..=steps).step_by(1 + steps / LOOKED_AT);
        let loudest = instants.max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(0);
        let mut held = vec![0.0; motion.strain.n_dof()];
        motion.force(motion.pace * loudest as f64 * motion.time_step, &mut held);
        let force = |_: f64, out: &mut [f64]| out.copy_from_slice(&held);
        let mut both = self.start(&force)?;
        let start = Instant::now();
        for _ in 0..FEW.min(steps) {
            side_by_side(&mut both, &force)?;
        }
        let seconds = start.elapsed().as_secs_f64() / FEW as f64 * steps as f64;
        Ok(Work { steps: ((self.parts + self.parts / 2) * steps) as f64, seconds })
    }

    /// Marches from rest and shows the displacements of both after each step, the start too, with the energy
    /// of the reference \[J\]. Its wall time \[s\].
    ///
    /// # Errors
    /// [`StudyError::LargeMarch`], or the listener stops it.
    pub fn march(
        &self,
        steps: usize,
        listener: &dyn Listener,
        mut observe: impl FnMut(usize, [&[f64]; 2], f64),
    ) -> Result<f64, StudyError> {
        let force = |time: f64, out: &mut [f64]| self.motion.force(time, out);
        let mut both = self.start(&force)?;
        let mut seconds = 0.0;
        for step in 0..=steps {
            if step > 0 {
                seconds += side_by_side(&mut both, &force)?;
            }
            let [fine, coarse] = &both;
            let energy = self.motion.stiffness * self.marches[0].energy(&fine.state);
            observe(step, [&fine.state.displacement, &coarse.state.displacement], energy);
            listener.checkpoint(step, steps)?;
        }
        Ok(seconds)
    }
}

impl<'m> RunningMarch<'m> {
    /// At rest.
    fn new(march: &'m LargeMarch<'m>, parts: usize, n: usize, force: &Force<'_>) -> Result<Self, LargeError> {
        let rest = vec![0.0; n];
        let state = march.start(&rest, &rest, &mut |time, out| force(time, out))?;
        Ok(Self { march, parts, state, work: LargeWork::default() })
    }

    /// One step of the file; its wall time \[s\].
    fn advance(&mut self, force: &Force<'_>) -> Result<f64, LargeError> {
        let start = Instant::now();
        for _ in 0..self.parts {
            self.march.step(&mut self.state, &mut |time, out| force(time, out), &mut self.work)?;
        }
        Ok(start.elapsed().as_secs_f64())
    }
}

/// One step of the file, both marches at once; the wall time of the first \[s\].
fn side_by_side([fine, coarse]: &mut [RunningMarch<'_>; 2], force: &Force<'_>) -> Result<f64, LargeError> {
    std::thread::scope(|scope| {
        let beside = scope.spawn(|| coarse.advance(force));
        let seconds = fine.advance(force);
        beside.join().expect("a march does not panic")?;
        seconds
    })
}

impl SparseLoad {
    fn add(&self, factor: f64, out: &mut [f64]) {
        if factor != 0.0 {
            self.row.iter().for_each(|&(dof, force)| out[dof as usize] += factor * force);
        }
    }
}

/// Distance of two motions: squares of a distance and of what it is a share of.
#[derive(Default)]
pub struct MarchDistance([f64; 2]);

impl MarchDistance {
    /// Adds an instant.
    pub fn add(&mut self, mass: &SymmetricMatrix, [fine, coarse]: [&[f64]; 2]) {
        let difference: Vec<f64> = fine.iter().zip(coarse).map(|(a, b)| a - b).collect();
        self.0[0] += mass.inner(&difference, &difference);
        self.0[1] += mass.inner(fine, fine);
    }

    /// Relative, over all dofs and instants, in the mass norm.
    pub fn share(&self) -> f64 {
        (self.0[0] / self.0[1]).sqrt()
    }
}
