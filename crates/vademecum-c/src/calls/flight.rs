//! A body that flies: its motion in space beside its elastic one.

use vademecum_eval::{AnyBody, RigidBody, RigidMotion};

use crate::handle::{Body, on};
use crate::refusal::{Refusal, needed};
use crate::slices::{given, room};
use crate::types::{VdmBody, VdmMotion, VdmPlace, VdmRigidBody, VdmStatus};

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

/// The refusal of a body with supports.
const HELD: Refusal =
    Refusal::Words(VdmStatus::VDM_OUTPUT, "the body has supports, so it does not fly; build it without them");

/// Refuses a body that does not fly.
pub fn flies(body: &Body) -> Result<(), Refusal> {
    let said = "the host moves the body; bind it with VdmOptions.flight = 1";
    match (body.flight(), body.rigid_body()) {
        (Some(_), _) => Ok(()),
        (None, Some(_)) => Err(Refusal::Words(VdmStatus::VDM_OUTPUT, said)),
        (None, None) => Err(HELD),
    }
}

/// The refusal of a motion.
const NO_MOTION: Refusal =
    Refusal::Words(VdmStatus::VDM_ARGUMENT, "a number of the motion is not finite, or its attitude is zero");

/// Mass, centre and moments of inertia of a body without supports, at the density it has now.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to a `VdmRigidBody`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_rigid_body(body: *mut VdmBody, out: *mut VdmRigidBody) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            *needed(out.as_mut(), "out")? = body.rigid_body().ok_or(HELD)?.into();
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Puts a body that flies where the file has it, with a velocity of its centre in m/s and an angular velocity
/// in rad/s. Its elastic motion stays.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `velocity` and `spin` point to three numbers
/// each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_throw(body: *mut VdmBody, velocity: *const f64, spin: *const f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (velocity, spin) = (needed(given(velocity), "velocity")?, needed(given(spin), "spin")?);
            flies(body)?;
            body.throw(velocity, spin).ok_or(NO_MOTION)?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// The motion in space of a body that flies.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to a `VdmMotion`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_motion(body: *mut VdmBody, out: *mut VdmMotion) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let out = needed(out.as_mut(), "out")?;
            flies(body)?;
            *out = (*body.motion().ok_or(HELD)?).into();
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Puts a body that flies elsewhere, or lets it move otherwise. The attitude is brought to length one. Loads
/// stay, and so does the elastic motion.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `motion` points to a `VdmMotion`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_set_motion(body: *mut VdmBody, motion: *const VdmMotion) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let VdmMotion { position, attitude, momentum, angular_momentum } =
                *needed(motion.as_ref(), "motion")?;
            flies(body)?;
            let motion = RigidMotion { position, attitude, momentum, angular_momentum };
            body.set_motion(motion).ok_or(NO_MOTION)?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// The motion in space at the end of the coming step under the loads at hand.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to a `VdmMotion`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_ahead(body: *mut VdmBody, out: *mut VdmMotion) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let out = needed(out.as_mut(), "out")?;
            flies(body)?;
            let free = body.flight().ok_or(HELD)?;
            *out = match &*body {
                AnyBody::Single(body) => free.ahead(body.scene()),
                #[cfg(feature = "double")]
                AnyBody::Double(body) => free.ahead(body.scene()),
            }
            .into();
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Position in m, or velocity in m/s, in space of a place of a body that flies, deformed as it is; three
/// numbers.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`, `out` to
/// three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_in_space(
    body: *mut VdmBody,
    place: *const VdmPlace,
    field: i32,
    out: *mut f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (place, out) = (needed(place.as_ref(), "place")?, needed(room(out), "out")?);
            flies(body)?;
            *out = body.in_space(place, super::read::field(field)?)?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}
