//! States as such, and what a step will do to one.

use crate::body::Body;
use crate::slices::{lent, lent_mut};
use crate::types::{VdmBody, VdmPlace, VdmStatus};

/// Sets the reduced coordinates and their rates, `VdmNeeds.modes` numbers each, with the acceleration that
/// the loads at hand demand.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `zeta` and `zeta_dot` point to `count`
/// numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_set(
    body: *mut VdmBody,
    zeta: *const f64,
    zeta_dot: *const f64,
    count: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), lent(zeta, count), lent(zeta_dot, count)) } {
        (Some(body), Some(zeta), Some(zeta_dot)) => body.set(zeta, zeta_dot),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// The reduced coordinates and their rates, `VdmNeeds.modes` numbers each.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `zeta` and `zeta_dot` point to `count`
/// numbers that do not overlap.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_coordinates(
    body: *mut VdmBody,
    zeta: *mut f64,
    zeta_dot: *mut f64,
    count: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), lent_mut(zeta, count), lent_mut(zeta_dot, count)) } {
        (Some(body), zeta, zeta_dot) => body.coordinates(zeta, zeta_dot),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Gives a body the state of another one of the same file, precision and structure, whose step in time may
/// differ: displacement, velocity and acceleration stay what they are.
///
/// # Safety
/// `to` and `from` are null or handles of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_carry(to: *mut VdmBody, from: *const VdmBody) -> VdmStatus {
    if core::ptr::eq(to, from) && !to.is_null() {
        return VdmStatus::VDM_OK;
    }
    // SAFETY: as the caller promises; they are two bodies.
    match unsafe { (Body::of_mut(to), Body::of(from)) } {
        (Some(to), Some(from)) => to.carry(from),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// The map `D` of a step `y + D y + l`, column by column: `(3 modes)²` numbers, or `(2 modes)²` of the exact
/// structure.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_increment(body: *mut VdmBody, out: *mut f64, numbers: usize) -> VdmStatus {
    // SAFETY: as the caller promises.
    let out = unsafe { lent_mut(out, numbers) };
    with!(body => body.increment(out))
}

/// Where `count` places, at most `VdmOptions.places`, will be at the end of the coming step if nothing acts
/// but the loads at hand: the displacement of each, three numbers a place. The body stays as it is.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `places` points to `count` places, and `out`
/// to `3 count` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_free_motion(
    body: *mut VdmBody,
    places: *const VdmPlace,
    count: usize,
    out: *mut f64,
) -> VdmStatus {
    let Some(numbers) = count.checked_mul(3) else { return VdmStatus::VDM_ARGUMENT };
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), lent(places, count), lent_mut(out, numbers)) } {
        (Some(body), Some(places), out) => body.free_motion(places, out),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}
