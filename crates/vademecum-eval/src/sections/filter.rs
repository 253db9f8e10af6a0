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
use crate::sections::residual::{Residual, Statics};
use vademecum_format::exact::ForceFilter;
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
    if !options.residual || !(live || damped) || Residual::of(file).is_empty() {
        return [0; 2];
    }
    let all = metadata.n_load_nodes as usize;
    let [nodes, patterns] = statics;
    [if nodes > 0 { options.filtered_nodes.unwrap_or(all).max(1).min(all) } else { 0 }, patterns]
}

/// The filter of a step: none where it was left out of the program.
pub(crate) fn filter_of(parameters: &StepParameters) -> ForceFilter {
    if cfg!(feature = "filter") { ForceFilter::of(parameters) } else { ForceFilter::NONE }
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
    pub fn step(&mut self, filter: &ForceFilter, drive: &Statics<'_, T>) {
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

    /// Numbers that [`Filtered::save_into`] writes.
    pub const fn numbers(&self) -> usize {
        if self.forces.forces.is_empty() && self.forces.patterns.is_empty() {
            return 0;
        }
        3 + 4 * self.forces.forces.len() + self.forces.patterns.len()
    }

    /// Writes the count of forces, the largest ones, all forces with their nodes, and all amplitudes.
    pub fn save_into(&self, out: &mut [T]) -> Result<(), Short> {
        let (found, needed) = (out.len(), self.numbers());
        if found != needed {
            return Err(Short { found, needed });
        }
        let forces = &self.forces;
        let used = forces.forces.as_flattened().iter().take(4 * forces.used);
        let none = 4 * (forces.forces.len() - forces.used);
        let zero = T::ZERO;
        let head = [T::from_f64(forces.used as f64), self.largest[0], self.largest[1]];
        let all = head.iter().chain(used).chain(core::iter::repeat_n(&zero, none)).chain(&*forces.patterns);
        out.iter_mut().zip(all).for_each(|(out, &number)| *out = number);
        Ok(())
    }

    /// Takes back what [`Filtered::save_into`] wrote; `None`, and nothing changes, for other numbers.
    pub fn restore(&mut self, saved: &[T]) -> Option<()> {
        if saved.len() != self.numbers() || saved.iter().any(|x| !x.to_f64().is_finite()) {
            return None;
        }
        let Some((&[used, of_forces, of_patterns], saved)) = saved.split_first_chunk() else {
            return Some(());
        };
        let (forces, count) = (&mut self.forces, used.to_f64());
        if !(count >= 0.0 && count <= forces.forces.len() as f64 && libm::floor(count) == count) {
            return None;
        }
        let (nodes, amplitudes) = saved.split_at_checked(4 * forces.forces.len())?;
        if nodes.iter().step_by(4).any(|node| node.to_f64() < 0.0) {
            return None;
        }
        let places = forces.forces.as_flattened_mut().iter_mut();
        places.zip(nodes).for_each(|(place, &number)| *place = number);
        forces.patterns.iter_mut().zip(amplitudes).for_each(|(place, &number)| *place = number);
        forces.used = count as usize;
        forces.some_pattern = forces.patterns.iter().any(|&amplitude| amplitude != T::ZERO);
        self.largest = [of_forces, of_patterns];
        Some(())
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
