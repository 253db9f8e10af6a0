//! Options of a world, and the report of a step.

use crate::base::scalar::Scalar;
use crate::world::error::WorldError;

/// Options of a [`World`](crate::World).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldOptions {
    /// Acceleration of gravity in space \[m/s²\]; it acts on free and on rigid members. A held body has a
    /// load pattern for it.
    pub gravity: [f64; 3],
    /// Distance up to which nodes and triangles are paired \[m\]; a fiftieth of the smallest member if
    /// `None`.
    pub reach: Option<f64>,
    /// Largest change of a displacement in the last sweep of the solution \[m\]; 1e-9 of the smallest member
    /// if `None`.
    pub tolerance: Option<f64>,
    /// Most sweeps of a step.
    pub sweeps: usize,
    /// Contacts for which there is room. Of more the deepest are kept.
    pub contacts: usize,
    /// Contacts near each contact for which there is room, of bodies whose files have a contact patch.
    pub near: usize,
    /// Share of an overlap that a step takes back, of what is above 1e-4 of the size of the smallest member:
    /// taking it back adds energy.
    pub recover: f64,
}

impl Default for WorldOptions {
    fn default() -> Self {
        Self {
            gravity: [0.0; 3],
            reach: None,
            tolerance: None,
            sweeps: 200,
            contacts: 256,
            near: 64,
            recover: 0.1,
        }
    }
}

impl WorldOptions {
    /// Refuses numbers that are not finite or negative.
    pub(crate) fn check(&self) -> Result<(), WorldError> {
        let lengths = self.reach.into_iter().chain(self.tolerance);
        let sound = lengths.chain([self.recover]).all(|x| x.in_range() && x >= 0.0);
        let gravity = self.gravity.iter().all(|x| x.in_range());
        if sound && gravity && self.recover <= 1.0 { Ok(()) } else { Err(WorldError::Option) }
    }
}

/// Report of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[must_use]
pub struct WorldReport {
    /// Pairs of nodes and surfaces that were near each other.
    pub contacts: usize,
    /// Those that carry a force.
    pub pressed: usize,
    /// Pairs for which there was no room.
    pub left_out: usize,
    /// Sweeps of the solution.
    pub sweeps: usize,
    /// `true` if the solution is within its tolerance. If not, the forces are those of the last sweep.
    pub converged: bool,
    /// Deepest overlap at the end of the step \[m\]; 0 if there is none.
    pub worst_gap: f64,
    /// Joints that broke at the end of the step.
    pub broken: usize,
    /// Energy that contacts took from the members \[J\]: friction, impact, and what the residual flexibility
    /// gives away. Below 0 where overlaps were taken back.
    pub energy_given_away: f64,
}
