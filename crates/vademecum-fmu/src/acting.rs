//! Loads of a step that was taken.

use vademecum_eval::{BodyParts, Contact, LoadError, Loads, Scene, StepError};

use crate::flight::Flight;
use crate::points::Points;
use crate::refusal::Refusal;

/// Loads of a step that was taken, made again from its inputs.
pub struct Acting<'a> {
    /// Places of the forces.
    pub points: &'a Points<'static>,
    /// Number of load patterns.
    pub patterns: u32,
    /// Of a free body, whose forces are those of space, as it was turned in that step.
    pub flight: Option<&'a Flight>,
}

impl Acting<'_> {
    /// Makes loads of forces and amplitudes in the order of the inputs. A point without force stays out.
    pub fn load(
        &self,
        scene: &Scene<'_, f64>,
        loads: &mut Loads<'_, f64>,
        mut inputs: impl Iterator<Item = f64>,
    ) -> Result<(), LoadError> {
        loads.clear();
        for index in 0..self.points.len() {
            let force = next_force(&mut inputs);
            let Some(point) = self.points.get(index).filter(|_| force != [0.0; 3]) else { continue };
            let force = self.flight.map_or(force, |flight| flight.turned.to_body(force));
            loads.add_contact(scene, &Contact::new(point.place, force))?;
        }
        for (pattern, amplitude) in inputs.take(self.patterns as usize).enumerate() {
            if amplitude != 0.0 {
                loads.add_pattern(scene, pattern, amplitude)?;
            }
        }
        Ok(())
    }

    /// Takes a state back under these inputs.
    pub fn restore(
        &self,
        parts: BodyParts<'_, 'static, f64>,
        inputs: impl Iterator<Item = f64>,
        state: &[f64],
    ) -> Result<(), Refusal> {
        let (scene, loads) = (&*parts.scene, parts.loads);
        self.load(scene, loads, inputs)?;
        if let Some(Flight { spins: [before, after], .. }) = self.flight {
            loads.add_spin(scene, *before, *after)?;
        }
        let (state, rest) = state.split_at_checked(scene.state_numbers()).ok_or(StepError::Mismatch)?;
        let filter = rest.get(..parts.state.filter_numbers()).ok_or(StepError::Mismatch)?;
        parts.state.restore_under(state, loads)?;
        parts.state.restore_filter(filter)?;
        Ok(())
    }
}

/// Three numbers of the inputs.
pub fn next_force(inputs: &mut impl Iterator<Item = f64>) -> [f64; 3] {
    let mut force = [0.0; 3];
    for component in &mut force {
        *component = inputs.next().unwrap_or_default();
    }
    force
}
