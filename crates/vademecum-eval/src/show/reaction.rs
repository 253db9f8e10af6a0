//! Reactions: the force and the moment that each support exerts on the body, where the file keeps them.
//!
//! `r = r_static + s_ρ Lᵀ ζ̈ + s_ρ α Lᵀ ζ̇`, under the forces of the last step, which a state remembers.

use crate::base::error::OutputError;
use crate::base::options::Structure;
use crate::base::scalar::Scalar;
use crate::scene::equation::Stiffness;
use crate::scene::scene::Scene;
use crate::scene::state::State;
use crate::sections::residual::Statics;
use crate::sections::supports::row;
use vademecum_format::SectionKind;

/// Reaction of a support on the body: force \[N\], then moment \[N m\] about the point of the support.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reaction {
    /// Part that holds the loads, as if they stayed.
    pub at_rest: [f64; 6],
    /// Part that moves the mass of the body.
    pub inertia: [f64; 6],
    /// Part of Rayleigh's `α`, which brakes mass.
    pub damping: [f64; 6],
}

impl Reaction {
    /// All of it.
    #[must_use]
    pub fn total(&self) -> [f64; 6] {
        let mut total = self.at_rest;
        for (sum, (inertia, damping)) in total.iter_mut().zip(self.inertia.iter().zip(self.damping)) {
            *sum += inertia + damping;
        }
        total
    }
}

impl<T: Scalar> Scene<'_, T> {
    /// Number of supports whose reactions the file has; 0 if it was built without `[output] reactions`.
    #[must_use]
    pub const fn n_supports(&self) -> usize {
        self.sections.supports.count
    }

    /// The point \[m\] about which the moment of a support is taken.
    ///
    /// # Errors
    /// [`OutputError::OutOfRange`], [`OutputError::Missing`].
    pub fn support_point(&self, support: usize) -> Result<[f64; 3], OutputError> {
        self.check_support(support)?;
        let kind = SectionKind::SupportPoints;
        let place = row(self.sections.supports.points, support.saturating_mul(3), 3);
        let place = place.ok_or(OutputError::Missing { kind })?;
        let mut point = [0.0; 3];
        point.iter_mut().zip(place).for_each(|(out, &x)| *out = f64::from_le_bytes(x));
        Ok(point)
    }

    /// Reaction of support `index` on the body, in the order of the names in the file, under the forces of
    /// the last step. `O(r)` for each node that is loaded, and for each pattern.
    ///
    /// ```
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// use vademecum_eval::{SceneOptions, Simulation};
    /// # let bytes: &'static [u8] =
    /// #     include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/golden/reactions.vdm"));
    /// let mut body = Simulation::<f64>::new(bytes, &SceneOptions::default())?;
    /// body.push_pattern(0, 1.0)?;
    /// body.step(1)?;
    /// let reaction = body.reaction(0)?;
    /// assert!(reaction.at_rest.iter().any(|&part| part != 0.0));
    /// let whole = reaction.at_rest[2] + (reaction.inertia[2] + reaction.damping[2]);
    /// assert_eq!(reaction.total()[2], whole);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`OutputError::OutOfRange`]; [`OutputError::Missing`]: a file without reactions;
    /// [`OutputError::ForcesForgotten`]: a scene without room for contacts, or a state that was restored, or
    /// taken from a batch, without the loads of its last step.
    pub fn reaction(&self, state: &State<'_, T>, index: usize) -> Result<Reaction, OutputError> {
        self.check(state)?;
        if self.shape.is_strain() {
            return Err(OutputError::NotWithStrain);
        }
        self.check_support(index)?;
        let no_room = self.shape.statics[0] == 0 && self.sections.supports.n_load_nodes > 0;
        if no_room || state.statics.forgotten {
            return Err(OutputError::ForcesForgotten);
        }
        let mut reaction = Reaction::default();
        self.sections.supports.hold(index, &state.statics, &mut reaction.at_rest)?;
        let kind = SectionKind::ReactionBasis;
        let basis = self.sections.supports.basis.ok_or(OutputError::Missing { kind })?;
        let r = self.shape.r;
        for (mode, velocity) in state.y.part(1).iter().enumerate() {
            let acceleration = self.acceleration(state, mode)?;
            let drag = self.parameters.alpha * velocity.to_f64() / state.y.time_step;
            for component in 0..6 {
                let share = basis.get((6 * index + component) * r + mode);
                let share = share.map_or(0.0, |&share| self.parameters.density * f64::from_le_bytes(share));
                if let Some(out) = reaction.inertia.get_mut(component) {
                    *out += share * acceleration;
                }
                if let Some(out) = reaction.damping.get_mut(component) {
                    *out += share * drag;
                }
            }
        }
        Ok(reaction)
    }

    /// The acceleration of a mode: that of the state, or, where exact steps have none, the one that the
    /// equation of motion demands under the forces of the last step.
    fn acceleration(&self, state: &State<'_, T>, mode: usize) -> Result<f64, OutputError> {
        let dt = state.y.time_step;
        let at = |part: usize| state.y.part(part).get(mode).map_or(0.0, |x| x.to_f64());
        if self.shape.structure() != Structure::Exact {
            return Ok(at(2) / (dt * dt));
        }
        let [lambda, decay] = self.mode_equation(mode);
        let rows = self.sections.damping_rows.unwrap_or(&[]).chunks_exact(self.shape.r.max(1));
        let coupled: f64 = rows.map(|row| along(row, state.y.part(1)) * entry(row, mode)).sum();
        let force = self.modal_force(&state.statics, mode)?;
        let damped = decay * at(1) + coupled / self.parameters.density;
        Ok(force / self.parameters.density - damped / dt - lambda * at(0))
    }

    /// Stiffness and damping rate of a mode, without what couples modes.
    pub(crate) fn mode_equation(&self, mode: usize) -> [f64; 2] {
        let parameters = &self.parameters;
        let Stiffness::Diagonal(lambdas) = self.sections.matrices.stiffness else { return [0.0; 2] };
        let lambda = lambdas.get(mode).map_or(0.0, |&lambda| f64::from_le_bytes(lambda));
        let lambda = lambda * parameters.stiffness / parameters.density;
        let ratio = self.sections.damping_ratios.and_then(|ratios| ratios.get(mode));
        let ratio = ratio.map_or(0.0, |&ratio| f64::from_le_bytes(ratio));
        [lambda, parameters.alpha + parameters.beta * lambda + 2.0 * ratio * libm::sqrt(lambda)]
    }

    /// A weighted sum of the shares of a mode in a reaction.
    #[cfg(feature = "full")]
    pub(crate) fn reaction_share(&self, support: usize, mode: usize, weights: &[f64; 6]) -> f64 {
        let basis = self.sections.supports.basis.unwrap_or(&[]);
        let share = |component: usize| basis.get((6 * support + component) * self.shape.r + mode);
        let shares = weights.iter().enumerate().map(|(component, weight)| {
            weight * share(component).map_or(0.0, |&share| f64::from_le_bytes(share))
        });
        shares.sum()
    }

    /// Refuses a reaction that there is not.
    #[cfg(feature = "full")]
    pub(crate) fn check_reaction(&self, support: usize) -> Result<(), OutputError> {
        let no_room = self.shape.statics[0] == 0 && self.sections.supports.n_load_nodes > 0;
        if no_room {
            return Err(OutputError::ForcesForgotten);
        }
        self.check_support(support)
    }

    /// `BᵀF` of the forces of the last step, in one mode.
    fn modal_force(&self, acting: &Statics<'_, T>, mode: usize) -> Result<f64, OutputError> {
        let (rows, r) = (self.sections.rows.surface, self.shape.r);
        let mut sum = 0.0;
        for (node, force) in acting.forces() {
            let rows = rows.ok_or(OutputError::Missing { kind: SectionKind::SurfaceBasis })?;
            for (component, force) in force.iter().enumerate() {
                // A row at a time: numbers of 16 bits have a scale by node.
                let row = rows.row((3 * node + component) * r, r);
                sum += row.and_then(|row| row.get(mode)).unwrap_or(0.0) * force;
            }
        }
        for (pattern, amplitude) in acting.amplitudes() {
            let kind = SectionKind::PatternBasis;
            let basis = self.sections.pattern_basis.ok_or(OutputError::Missing { kind })?;
            sum += basis.get(pattern * r + mode).unwrap_or(0.0) * amplitude;
        }
        Ok(sum)
    }

    fn check_support(&self, index: usize) -> Result<(), OutputError> {
        let supports = &self.sections.supports;
        if supports.basis.is_none() {
            return Err(OutputError::Missing { kind: SectionKind::ReactionBasis });
        }
        let count = supports.count;
        if index < count { Ok(()) } else { Err(OutputError::OutOfRange { index, count }) }
    }
}

/// `d · y` of a row of dashpots.
fn along<T: Scalar>(row: &[[u8; 8]], y: &[T]) -> f64 {
    row.iter().zip(y).map(|(&d, y)| f64::from_le_bytes(d) * y.to_f64()).sum()
}

/// Its number for a mode.
fn entry(row: &[[u8; 8]], mode: usize) -> f64 {
    row.get(mode).map_or(0.0, |&d| f64::from_le_bytes(d))
}
