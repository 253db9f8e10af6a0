//! A free body: its rigid motion in space beside its elastic one.

use crate::body::Body;
use crate::slices::given;
use crate::types::{VdmBody, VdmMotion, VdmPlace, VdmRigidBody, VdmStatus};

/// Mass, centre and moments of inertia of a free body, at the density it has now; `VDM_OUTPUT` for a body
/// with supports, as from all calls that begin with `vdm_flight`.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to a `VdmRigidBody`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_flight_mass(body: *mut VdmBody, out: *mut VdmRigidBody) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), out.as_mut()) } {
        (Some(body), Some(out)) => body.rigid_body(out),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Puts a free body where the file has it, with a velocity of its centre in m/s and an angular velocity in
/// rad/s. Its elastic motion stays.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `velocity` and `spin` point to three
/// numbers each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_flight_throw(
    body: *mut VdmBody,
    velocity: *const f64,
    spin: *const f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), given::<3>(velocity), given::<3>(spin)) } {
        (Some(body), Some(velocity), Some(spin)) => body.throw(velocity, spin),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// The rigid motion.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to a `VdmMotion`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_flight_motion(body: *mut VdmBody, out: *mut VdmMotion) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), out.as_mut()) } {
        (Some(body), Some(out)) => body.motion(out),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Puts the body elsewhere, or lets it move otherwise. The attitude is brought to length one. What pushes the
/// body stays, and so does its elastic motion.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `motion` points to a `VdmMotion`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_flight_set_motion(body: *mut VdmBody, motion: *const VdmMotion) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), motion.as_ref()) } {
        (Some(body), Some(motion)) => body.set_motion(motion),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Where the rigid motion will be at the end of the coming step under what pushes it so far.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to a `VdmMotion`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_flight_ahead(body: *mut VdmBody, out: *mut VdmMotion) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), out.as_mut()) } {
        (Some(body), Some(out)) => body.ahead(out),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Pushes at a place with a force in N, in the directions of space, for the coming [`vdm_flight_step`].
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`, `force`
/// to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_flight_add_contact(
    body: *mut VdmBody,
    place: *const VdmPlace,
    force: *const f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), place.as_ref(), given::<3>(force)) } {
        (Some(body), Some(place), Some(force)) => body.free_contact(place, force),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Adds a load pattern, which turns with the body, times an amplitude, for the coming [`vdm_flight_step`].
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_flight_add_pattern(
    body: *mut VdmBody,
    pattern: u32,
    amplitude: f64,
) -> VdmStatus {
    with!(body => body.free_pattern(pattern, amplitude))
}

/// Pulls at the centre with a force in N, in the directions of space, for the coming [`vdm_flight_step`]:
/// gravity is the mass times its acceleration.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `force` points to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_flight_pull(body: *mut VdmBody, force: *const f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), given::<3>(force)) } {
        (Some(body), Some(force)) => body.pull(force),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// One step of both motions, under what was added since the last one, and takes that away.
/// [`vdm_step`](crate::vdm_step), in contrast, leaves the rigid motion to whoever moves the body.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_flight_step(body: *mut VdmBody) -> VdmStatus {
    with!(body => body.fly())
}

/// Where a place is in space, deformed as it is, in m; three numbers.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`, `out`
/// to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_flight_point(
    body: *mut VdmBody,
    place: *const VdmPlace,
    out: *mut f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), place.as_ref(), out.cast::<[f64; 3]>().as_mut()) } {
        (Some(body), Some(place), Some(out)) => body.in_space(place, false, out),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Velocity of a place in space, in m/s; three numbers.
///
/// # Safety
/// As for [`vdm_flight_point`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_flight_velocity(
    body: *mut VdmBody,
    place: *const VdmPlace,
    out: *mut f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), place.as_ref(), out.cast::<[f64; 3]>().as_mut()) } {
        (Some(body), Some(place), Some(out)) => body.in_space(place, true, out),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}
