//! Residual flexibility under stiffness-proportional damping.
//!
//! The modes that a basis leaves out are quasi-static. Under `C = βK` each of them still follows its load
//! with the time constant `β`, since its inertia counts for nothing: `β q̇ + q = q_static`. The constant is
//! the same for all of them, so what the modes leave out is `R y`, with the filtered force `y`:
//!
//! ```text
//! β ẏ + y = F
//! y(t + Δt) = e y(t) + (g − e) F(t) + (1 − g) F(t + Δt)      e = exp(−Δt/β), g = (1 − e) β/Δt
//! ```
//!
//! The second line is exact for forces that are linear over the step. A state keeps `y` for each loaded node
//! and for each pattern, so a contact that is cleared and added again in each step is the contact that stays.
//! Filtered forces below 1e-12 of the largest that the state has had are dropped. Without `β` the filtered
//! force is the force, and nothing of this is kept or computed.

use crate::base::error::StepError;
use crate::base::lend::{Lender, Short};
use crate::base::options::SceneOptions;
use crate::base::scalar::Scalar;
use crate::sections::residual::Statics;
use vademecum_format::scheme::StepParameters;
use vademecum_format::{File, ParameterRole};

/// Filtered forces below this share of the largest are dropped.
const DROPPED: f64 = 1e-12;

/// Numbers of nodes and patterns whose filtered forces a state keeps, of those whose forces are remembered;
/// zeros where no filter is wanted: no residual, or neither a `β` nor a live one.
pub(crate) fn filtered_room(file: &File<'_>, options: &SceneOptions, statics: [usize; 2]) -> [usize; 2] {
    let metadata = file.metadata();
    let live = metadata.active_parameters().iter().any(|parameter| parameter.role == ParameterRole::Beta);
    let damped = options.beta.unwrap_or(metadata.beta) != 0.0;
    if !options.residual || !(live || damped) {
        return [0; 2];
    }
    let all = metadata.n_load_nodes as usize;
    let [nodes, patterns] = statics;
    [if nodes > 0 { options.filtered_nodes.unwrap_or(all).min(all) } else { 0 }, patterns]
}

/// The coefficients of a step of the filter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Filter {
    /// `e`, of the filtered force before the step.
    pub keep: f64,
    /// `g − e`, of the force at the start.
    pub start: f64,
    /// `1 − g`, of the force at the end.
    pub end: f64,
}

impl Filter {
    /// The filter of a step; that of no damping shows forces at once.
    pub fn of(parameters: &StepParameters) -> Self {
        if parameters.beta <= 0.0 {
            return Self { keep: 0.0, start: 0.0, end: 1.0 };
        }
        let x = parameters.time_step / parameters.beta;
        let keep = libm::exp(-x);
        let gone = -libm::expm1(-x);
        // 1 − (1 − e)/x loses its digits for small x; the next term of the series is x⁵/720.
        let end = if x < 1e-2 {
            x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x / 120.0)))
        } else {
            1.0 - gone / x
        };
        Self { keep, start: gone - end, end }
    }

    /// Share of a force held over the step that the step shows, `1 − e`.
    pub fn held(&self) -> f64 {
        self.start + self.end
    }

    /// Contribution of an amplitude that is linear over the step.
    pub fn drive(&self, start: f64, end: f64) -> f64 {
        self.start * start + self.end * end
    }
}

/// Filtered forces of a state, in lent memory.
#[derive(Debug)]
pub(crate) struct Filtered<'m, T> {
    pub forces: Statics<'m, T>,
    /// Largest component of a force, and largest amplitude, since all was dropped.
    pub largest: [T; 2],
}

impl<'m, T: Scalar> Filtered<'m, T> {
    /// No forces.
    pub fn new(room: [usize; 2], memory: &mut Lender<&'m mut [T]>) -> Result<Self, Short> {
        Ok(Self { forces: Statics::new(room, memory)?, largest: [T::ZERO; 2] })
    }

    /// Drops everything.
    pub fn clear(&mut self) {
        self.forces.clear();
        self.largest = [T::ZERO; 2];
    }

    /// Refuses loads on more nodes than there is room for.
    pub fn check(&self, drive: &Statics<'_, T>) -> Result<(), StepError> {
        let nodes = self.forces.forces.len();
        if self.forces.used + drive.used <= nodes {
            return Ok(());
        }
        let new =
            drive.forces.iter().take(drive.used).filter(|[node, ..]| self.forces.place(*node).is_none());
        if self.forces.used + new.count() <= nodes { Ok(()) } else { Err(StepError::TooManyNodes { nodes }) }
    }

    /// A step under a drive that was checked.
    #[inline(never)]
    pub fn step(&mut self, filter: &Filter, drive: &Statics<'_, T>) {
        let keep = T::from_f64(filter.keep);
        let forces = &mut self.forces;
        for [_, force @ ..] in forces.forces.iter_mut().take(forces.used) {
            force.iter_mut().for_each(|force| *force = keep * *force);
        }
        forces.patterns.iter_mut().for_each(|amplitude| *amplitude = keep * *amplitude);
        for &[node, ref added @ ..] in drive.forces.iter().take(drive.used) {
            let place = forces.place(node).unwrap_or(forces.used);
            let Some([at, sum @ ..]) = forces.forces.get_mut(place) else { continue };
            if place == forces.used {
                (*at, *sum) = (node, [T::ZERO; 3]);
                forces.used += 1;
            }
            sum.iter_mut().zip(added).for_each(|(sum, &added)| *sum += added);
        }
        forces.patterns.iter_mut().zip(&*drive.patterns).for_each(|(sum, &added)| *sum += added);
        self.drop_small();
    }

    /// Takes the forces themselves: those of a body whose residual is in equilibrium with them.
    pub fn settle(&mut self, forces: &Statics<'_, T>) {
        self.clear();
        self.forces.copy(forces);
        self.drop_small();
    }

    /// Drops what is small beside the largest that there has been.
    fn drop_small(&mut self) {
        let (forces, [of_forces, of_patterns]) = (&mut self.forces, &mut self.largest);
        let larger = |a: T, b: T| if b > a { b } else { a };
        let size = |numbers: &[T]| numbers.iter().fold(T::ZERO, |most, x| larger(most, x.magnitude()));
        let share = T::from_f64(DROPPED);
        let mut place = 0;
        while let Some([_, force @ ..]) = forces.forces.get(place).filter(|_| place < forces.used) {
            let force = size(force);
            *of_forces = larger(*of_forces, force);
            if force > share * *of_forces {
                place += 1;
            } else {
                forces.used -= 1;
                let last = forces.forces.get(forces.used).copied();
                if let (Some(at), Some(last)) = (forces.forces.get_mut(place), last) {
                    *at = last;
                }
            }
        }
        *of_patterns = larger(*of_patterns, size(forces.patterns));
        let mut some = false;
        for amplitude in &mut *forces.patterns {
            if amplitude.magnitude() > share * *of_patterns {
                some = true;
            } else {
                *amplitude = T::ZERO;
            }
        }
        forces.some_pattern = some;
        if forces.is_empty() {
            self.largest = [T::ZERO; 2];
        }
    }
}
