//! A world: members, the pairs of them that may touch, and a step of all together.
//!
//! ```text
//! free motion of each member            (exact, to the end of the step)
//! contacts: nodes near triangles        (where the surfaces will be)
//! forces: gap and slip at the end       (held over the step, Coulomb's friction)
//! step of each member under them
//! ```
//!
//! With the residual flexibility of each contact the law is at the level of displacements, at the end of the
//! step. A step then never adds energy, whatever `Δt`, stiffness and number of contacts: under forces that
//! are held the exact modes take `f' · Δ(Γq)`, and with `γ = g₀ + Γq + Sf` and `E = E_modes + ½ fᵀSf`
//!
//! ```text
//! E' − E = f'·(γ' − γ) − ½ (f' − f)ᵀ S (f' − f) + f_t'·slip ≤ 0
//! ```
//!
//! since `f' ≥ 0` acts where `γ' = min(0, γ)` at most. Rigid motions take the forces at the instant
//! `(1 − η)/2` of the step, which takes `½ η Δt² fᵀ W f` more and makes an impact shorter than the step as
//! inelastic as it is asked to be.

use core::cell::Cell;

use crate::base::error::StepError;
use crate::base::scalar::Scalar;
use crate::base::vec3::dot;
use crate::world::error::WorldError;
use crate::world::find::{Before, Found, Surfaces, find};
use crate::world::joint::{JointState, ROWS};
use crate::world::joints::{Joints, gather};
use crate::world::member::Member;
use crate::world::options::{WorldOptions, WorldReport};
use crate::world::patch::Near;
use crate::world::room::Room;
use crate::world::slot::{Slot, Touching};
use crate::world::solve::{show, start, sweep};
use crate::world::touch::Touch;

/// Members that touch and are joined, in lent memory. The members themselves are lent for each step.
#[derive(Debug)]
pub struct World<'m, T> {
    pub(crate) options: WorldOptions,
    pub(crate) pairs: &'m [Touching],
    pub(crate) joints: Joints<'m>,
    pub(crate) slots: &'m mut [Slot],
    pub(crate) now: &'m mut [Touch],
    pub(crate) before: &'m mut [Touch],
    pub(crate) n_now: usize,
    /// `true` if the contacts are in the order in which they were found.
    pub(crate) ordered: bool,
    pub(crate) near: &'m mut [Near],
    pub(crate) room: Room<'m, T>,
    pub(crate) step: u32,
    pub(crate) visit: u32,
    pub(crate) time_step: f64,
    pub(crate) reach: f64,
    pub(crate) tolerance: f64,
    /// Diagonal of the box of the smallest member \[m\].
    pub(crate) smallest: f64,
    /// Energy of the contacts in the residual flexibility.
    pub(crate) stored: f64,
}

impl<T: Scalar> World<'_, T> {
    /// Joints as they are after the last step.
    #[must_use]
    pub fn joints(&self) -> &[JointState] {
        self.joints.states
    }

    /// Breaks a joint: it holds nothing any more. The energy of the residual flexibility under its force is
    /// given up, and nothing else changes. `None` if there is no such joint.
    pub fn break_joint(&mut self, joint: usize) -> Option<()> {
        let state = self.joints.states.get_mut(joint)?;
        (state.broken, state.force) = (true, [0.0; ROWS]);
        Some(())
    }

    /// Breaks the joints whose force is above what they bear; how many.
    fn break_overloaded(&mut self) -> usize {
        let mut broken = 0;
        for (joint, state) in self.joints.all.iter().zip(&mut *self.joints.states) {
            let force = state.force();
            if !state.broken && libm::sqrt(dot(force, force)) > joint.breaks_at {
                (state.broken, state.force) = (true, [0.0; ROWS]);
                broken += 1;
            }
        }
        broken
    }

    /// Sets the acceleration of gravity in space \[m/s²\]. `None`, and nothing changes, if a number is not
    /// finite.
    pub fn set_gravity(&mut self, gravity: [f64; 3]) -> Option<()> {
        gravity.iter().all(|x| x.in_range()).then(|| self.options.gravity = gravity)
    }

    /// Contacts of the last step.
    #[must_use]
    pub fn touches(&self) -> &[Touch] {
        self.now.get(..self.n_now).unwrap_or_default()
    }

    /// Forgets the contacts of the last step: after a member was put elsewhere.
    pub fn forget(&mut self) {
        self.room.statics.fill(0.0);
        (self.n_now, self.stored, self.step) = (0, 0.0, 0);
        self.room.stamps.fill(0);
        self.room.fresh.fill(0);
    }

    /// One step of all members, under the loads on them, gravity, and the forces of the contacts. What was
    /// pushed acts for this step: the loads of all members are empty after it.
    ///
    /// # Errors
    /// [`WorldError`]; the loads of the members are empty then, and what a member did before another one
    /// was refused is done.
    pub fn step(&mut self, members: &mut [Member<'_, '_, T>]) -> Result<WorldReport, WorldError> {
        let report = self.advance(members);
        if report.is_err() {
            for member in members {
                match member {
                    Member::Held(body, _) | Member::Free(body) => body.clear(),
                    Member::Rigid(shape) => shape.accept(*shape.motion()),
                }
            }
        }
        report
    }

    fn advance(&mut self, members: &mut [Member<'_, '_, T>]) -> Result<WorldReport, WorldError> {
        if members.len() != self.slots.len() {
            return Err(WorldError::Mismatch);
        }
        self.predict(members)?;
        core::mem::swap(&mut self.now, &mut self.before);
        let old = self.n_now;
        self.step = self.step.wrapping_add(1).max(1);
        let surfaces = Surfaces {
            slots: self.slots,
            order: self.room.order,
            boxes: self.room.boxes,
            moved: Cell::from_mut(&mut *self.room.moved).as_slice_of_cells(),
            fresh: Cell::from_mut(&mut *self.room.fresh).as_slice_of_cells(),
            around: self.room.around,
            extents: self.room.extents,
            normals: self.room.normals,
            ahead: &*self.room.ahead,
            statics: &*self.room.statics,
            positions: self.room.positions,
            stamps: self.room.stamps,
            visits: self.room.visits,
            step: self.step,
            visit: &mut self.visit,
            reach: self.reach,
        };
        let mut found = Found { touches: self.now, count: 0, left_out: 0 };
        let touches = self.before.get(..old).unwrap_or_default();
        find(surfaces, members, self.pairs, Before { touches, ordered: self.ordered }, &mut found);
        let left_out = found.left_out;
        // Without room the deepest take the places of others.
        self.ordered = left_out == 0;
        self.n_now = found.count;
        self.set_up(members)?;
        let stored = self.stored;
        self.set_up_joints(members)?;
        self.system(|system, touches, spans| start(system, touches, spans));
        let (most, tolerance) = (self.options.sweeps, self.tolerance);
        let alone = self.joints.all.is_empty();
        let (sweeps, change) = self.close(members, |world| {
            // With joints, one sweep between two evaluations of them.
            let (mut sweeps, mut change) = (0, 0.0);
            while sweeps < if alone { most } else { 1 } && world.n_now > 0 {
                sweeps += 1;
                change = world.system(|system, touches, spans| sweep(system, touches, spans));
                if change <= tolerance {
                    // Contacts that the sweep passed before it moved others are looked at again.
                    change = world.system(|system, touches, spans| show(system, touches, spans));
                }
                if change <= tolerance || !alone {
                    break;
                }
            }
            (sweeps, change)
        })?;
        if !alone || change > tolerance {
            self.system(|system, touches, spans| show(system, touches, spans));
        }
        let mut report = WorldReport {
            contacts: self.n_now,
            left_out,
            sweeps,
            converged: change <= self.tolerance,
            ..WorldReport::default()
        };
        self.show_residual();
        for touch in self.now.get(..self.n_now).unwrap_or_default() {
            if !touch.force.iter().chain(&touch.end).all(|x| x.in_range()) {
                self.n_now = 0;
                return Err(StepError::NotFinite.into());
            }
            report.pressed += usize::from(touch.force[0] > 0.0);
            report.worst_gap = report.worst_gap.max(-touch.end[0]);
            report.energy_given_away += touch.taken();
        }
        gather(
            self.slots,
            self.now.get(..self.n_now).unwrap_or_default(),
            self.joints.all,
            self.joints.states,
        );
        for slot in &*self.slots {
            let axes = slot.axes.map(|axis| dot(slot.middle.to_space(axis), slot.pushed[1]));
            let rigid = slot.pushed[0].into_iter().chain(axes);
            let p = self.room.p.get(slot.first + slot.r + slot.m..slot.first + slot.n).unwrap_or_default();
            let kick: f64 = rigid.zip(p).map(|(force, p)| force * force * p).sum();
            report.energy_given_away += kick * slot.eta / (1.0 + slot.eta);
        }
        self.commit(members)?;
        report.energy_given_away += stored - self.stored;
        report.broken = self.break_overloaded();
        Ok(report)
    }

    /// Kinetic and elastic energy of all members and of the residual flexibility under the contacts \[J\].
    ///
    /// # Errors
    /// [`WorldError::Mismatch`].
    pub fn energy(&self, members: &[Member<'_, '_, T>]) -> Result<f64, WorldError> {
        let mut sum = 0.0;
        for member in members {
            if let Some(body) = member.elastic() {
                let modes = body.scene.energy_of_modes(&body.state);
                sum += modes.map_err(|_| WorldError::Mismatch)?.total();
            }
            sum += match member {
                Member::Free(body) => body.flight.map_or(0.0, |flight| flight.motion().energy(flight.body())),
                Member::Rigid(shape) => shape.body().map_or(0.0, |body| shape.motion().energy(body)),
                Member::Held(..) => 0.0,
            };
        }
        Ok(sum + self.stored + self.stored_in_joints(members))
    }
}
