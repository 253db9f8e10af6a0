//! Directional and adjoint derivatives: how the outputs at the present communication point change with the
//! inputs that the last communication step held.
//!
//! A step is linear in the state and in the loads, so the change of its end with its inputs is the answer of
//! a second state, at rest, to the seeds as loads, over the same internal steps. No difference is taken.
//! Displacements, velocities, strains and reactions are linear in the state: their change is their value at
//! the second state. Energies and equivalent stresses are not, and are differentiated at the present state.

use vademecum_eval::{Loads, Quantity, State, StepError};

use crate::acting::Acting;
use crate::body::Body;
use crate::outputs::Seen;
use crate::refusal::{Refusal, Trouble};
use crate::variables::Variable;

/// The second state and its loads, in lent memory.
struct Tangent<'m> {
    state: State<'m, f64>,
    loads: Loads<'m, f64>,
    /// Seeds, in the order of the inputs.
    seeds: &'m mut [f64],
    /// Numbers of a state at rest.
    start: &'m mut [f64],
}

impl Body {
    /// Numbers to lend for [`Body::directional`] and [`Body::adjoint`].
    #[must_use]
    pub const fn tangent_len(&self) -> usize {
        let scene = self.body.scene();
        let sizes = scene.own_sizes();
        sizes.state + sizes.loads + scene.state_numbers() + self.inputs.len()
    }

    /// Derivatives of unknowns along seeds of knowns, in the order of the unknowns. Costs the internal steps
    /// of the last communication step.
    ///
    /// # Errors
    /// [`Refusal::Unsupported`]: a nonlinear body, or parameters that have changed since the step; a known
    /// that is no input, an unknown that is no output, a seed that is not finite.
    pub fn directional(
        &self,
        memory: &mut [f64],
        seeds: impl Iterator<Item = (Variable, f64)>,
        unknowns: impl Iterator<Item = Variable>,
        sensitivity: &mut [f64],
    ) -> Result<(), Trouble> {
        let mut tangent = self.tangent(memory)?;
        for (known, seed) in seeds {
            if !seed.is_finite() {
                return Err((known, Refusal::NotFinite { value: seed }).into());
            }
            *tangent.seed(self, known)? += seed;
        }
        tangent.answer(self)?;
        let mut seen = Seen::default();
        for (unknown, out) in unknowns.zip(sensitivity) {
            *out = self.change(&tangent.state, unknown, &mut seen).map_err(|refusal| (unknown, refusal))?;
        }
        Ok(())
    }

    /// Derivatives of the sum of seeded unknowns with respect to knowns, in the order of the knowns. Costs
    /// [`Body::directional`] for each known.
    ///
    /// # Errors
    /// As [`Body::directional`].
    pub fn adjoint<I: Iterator<Item = (Variable, f64)>>(
        &self,
        memory: &mut [f64],
        seeds: impl Fn() -> I,
        knowns: impl Iterator<Item = Variable>,
        sensitivity: &mut [f64],
    ) -> Result<(), Trouble> {
        let mut tangent = self.tangent(memory)?;
        for (known, out) in knowns.zip(sensitivity) {
            tangent.seeds.fill(0.0);
            *tangent.seed(self, known)? = 1.0;
            tangent.answer(self)?;
            let (mut seen, mut sum) = (Seen::default(), 0.0);
            for (unknown, seed) in seeds() {
                if !seed.is_finite() {
                    return Err((unknown, Refusal::NotFinite { value: seed }).into());
                }
                let change = self.change(&tangent.state, unknown, &mut seen);
                sum += seed * change.map_err(|refusal| (unknown, refusal))?;
            }
            *out = sum;
        }
        Ok(())
    }

    fn tangent<'m>(&self, memory: &'m mut [f64]) -> Result<Tangent<'m>, Refusal> {
        const NONLINEAR: &str = "this body has no derivatives (providesDirectionalDerivatives = false): it \
                                 flies or is bent far, so that its step is not linear";
        if !self.counts.linear {
            return Err(Refusal::Unsupported(NONLINEAR));
        }
        if self.last.is_stale {
            return Err(Refusal::Unsupported(
                "a parameter has changed since the last step, whose derivatives these are: take a step",
            ));
        }
        let scene = self.body.scene();
        let (sizes, short) = (scene.own_sizes(), StepError::Mismatch);
        let (state, rest) = memory.split_at_mut_checked(sizes.state).ok_or(short)?;
        let (loads, rest) = rest.split_at_mut_checked(sizes.loads).ok_or(short)?;
        let (start, rest) = rest.split_at_mut_checked(scene.state_numbers()).ok_or(short)?;
        let seeds = rest.get_mut(..self.inputs.len()).ok_or(short)?;
        seeds.fill(0.0);
        start.fill(0.0);
        if let Some(last) = start.last_mut().filter(|_| self.last.is_first) {
            // The mark of a state that starts with the acceleration of its loads.
            *last = -0.0;
        }
        Ok(Tangent { state: State::new(scene, state)?, loads: Loads::new(scene, loads)?, seeds, start })
    }

    /// Change of an output with the state.
    fn change(&self, tangent: &State<'_, f64>, unknown: Variable, seen: &mut Seen) -> Result<f64, Refusal> {
        use Variable as V;
        let no_output = Refusal::Unsupported("it is no output; the unknowns are the outputs");
        // At the start nothing has acted.
        if self.last.steps == 0 {
            return if unknown.is_output() { Ok(0.0) } else { Err(no_output) };
        }
        let (scene, state) = (self.body.scene(), self.body.state());
        let total = match unknown {
            V::Energy => Some(Quantity::Energy),
            V::Total(index) => V::total(index),
            _ => None,
        };
        if let Some(total) = total {
            let [kinetic, strain] = scene.energies_along(state, tangent)?;
            return match total {
                Quantity::Energy => Ok(kinetic + strain),
                Quantity::KineticEnergy => Ok(kinetic),
                Quantity::StrainEnergy => Ok(strain),
                _ => Err(Refusal::NoVariable),
            };
        }
        if let V::VonMises(index) = unknown {
            let Some((point, stress)) = self.governing_stress(index)? else { return Ok(0.0) };
            return Ok(stress.von_mises_along(&scene.stress(tangent, point)?));
        }
        self.linear(tangent, unknown, seen)?.ok_or(no_output)
    }
}

impl Tangent<'_> {
    /// Place of the seed of an input.
    fn seed(&mut self, body: &Body, known: Variable) -> Result<&mut f64, (Variable, Refusal)> {
        let no_input = Refusal::Unsupported("it is no input; the knowns are the inputs");
        let place = body.input(known).and_then(|at| self.seeds.get_mut(at));
        place.ok_or((known, no_input))
    }

    /// Answers the seeds over the internal steps of the last communication step.
    fn answer(&mut self, body: &Body) -> Result<(), Refusal> {
        let Self { state, loads, seeds, start } = self;
        let scene = body.body.scene();
        let acting = Acting { points: &body.points, patterns: body.counts.patterns, flight: None };
        acting.load(scene, loads, seeds.iter().copied())?;
        state.rest();
        state.restore(start)?;
        for _ in 0..body.last.steps {
            let _ = scene.step(state, loads)?;
        }
        Ok(())
    }
}
