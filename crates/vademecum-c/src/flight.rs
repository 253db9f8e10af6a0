//! The rigid motion of a free body beside its elastic one.

use vademecum_eval::{RigidBody, RigidMotion};

use crate::body::{Body, moved};
use crate::types::{VdmMotion, VdmPlace, VdmRigidBody, VdmStatus};

impl From<RigidBody> for VdmRigidBody {
    fn from(body: RigidBody) -> Self {
        let RigidBody { mass, centre, moments, axes, .. } = body;
        Self { mass, centre, moments, axes }
    }
}

impl From<RigidMotion> for VdmMotion {
    fn from(motion: RigidMotion) -> Self {
        let RigidMotion { position, attitude, momentum, angular_momentum } = motion;
        Self { position, attitude, momentum, angular_momentum }
    }
}

impl Body {
    fn held(&mut self) -> VdmStatus {
        let said = "the body has supports, so it has no rigid motion; build it without them";
        self.message.note(VdmStatus::VDM_OUTPUT, &said)
    }

    /// Mass and momenta after a change of the density.
    pub fn follow(&mut self) {
        if let Some(free) = &mut self.free {
            moved!(self.march, m => free.follow(&m.scene));
        }
    }

    /// Mass, centre and moments of inertia at the density of the body.
    pub fn rigid_body(&mut self, out: &mut VdmRigidBody) -> VdmStatus {
        match moved!(self.march, m => m.scene.rigid_body()) {
            Some(found) => {
                *out = found.into();
                VdmStatus::VDM_OK
            }
            None => self.held(),
        }
    }

    /// The body where the file has it, thrown.
    pub fn throw(&mut self, velocity: [f64; 3], spin: [f64; 3]) -> VdmStatus {
        let Some(body) = moved!(self.march, m => m.scene.rigid_body()) else { return self.held() };
        self.put(RigidMotion::thrown(&body, velocity, spin))
    }

    pub fn motion(&mut self, out: &mut VdmMotion) -> VdmStatus {
        match &self.free {
            Some(free) => {
                *out = (*free.motion()).into();
                VdmStatus::VDM_OK
            }
            None => self.held(),
        }
    }

    pub fn set_motion(&mut self, motion: &VdmMotion) -> VdmStatus {
        let VdmMotion { position, attitude, momentum, angular_momentum } = *motion;
        self.put(RigidMotion { position, attitude, momentum, angular_momentum })
    }

    fn put(&mut self, motion: RigidMotion) -> VdmStatus {
        let Some(free) = &mut self.free else { return self.held() };
        let Some(motion) = motion.normalised() else {
            let said = "a number of the motion is not finite, or its attitude is zero";
            return self.message.note(VdmStatus::VDM_ARGUMENT, &said);
        };
        free.set_motion(motion);
        VdmStatus::VDM_OK
    }

    /// The rigid motion at the end of the coming step, under what pushes it so far.
    pub fn ahead(&mut self, out: &mut VdmMotion) -> VdmStatus {
        let Some(free) = self.free else { return self.held() };
        *out = moved!(self.march, m => free.ahead(&m.scene)).into();
        VdmStatus::VDM_OK
    }

    pub fn free_contact(&mut self, place: &VdmPlace, force: [f64; 3]) -> VdmStatus {
        let Some(free) = &mut self.free else { return self.held() };
        let at = place.point();
        let done = moved!(self.march, m => free.push(&m.scene, &mut m.loads, &at, force));
        self.answer(done, VdmStatus::VDM_LOAD)
    }

    pub fn free_pattern(&mut self, pattern: u32, amplitude: f64) -> VdmStatus {
        let Some(free) = &mut self.free else { return self.held() };
        let index = pattern as usize;
        let done = moved!(self.march, m => free.push_pattern(&m.scene, &mut m.loads, index, amplitude));
        self.answer(done, VdmStatus::VDM_LOAD)
    }

    pub fn pull(&mut self, force: [f64; 3]) -> VdmStatus {
        let Some(free) = &mut self.free else { return self.held() };
        free.pull(force);
        VdmStatus::VDM_OK
    }

    /// One step of both motions.
    pub fn fly(&mut self) -> VdmStatus {
        let Some(free) = &mut self.free else { return self.held() };
        let found = moved!(self.march, m => free.step(&m.scene, &mut m.state, &mut m.loads));
        self.stepped(found)
    }

    /// Where a place is in space, and how fast it moves there.
    pub fn in_space(&mut self, place: &VdmPlace, velocity: bool, out: &mut [f64; 3]) -> VdmStatus {
        let Some(free) = self.free else { return self.held() };
        let at = place.point();
        let found = moved!(self.march, m => if velocity {
            free.velocity(&m.scene, &m.state, &at)
        } else {
            free.point(&m.scene, &m.state, &at)
        });
        self.answer(found.map(|found| *out = found), VdmStatus::VDM_OUTPUT)
    }
}
