//! Loads that change within a step, and loads that stay.

use vademecum_eval::format::scheme::MAX_STAGES;

use crate::body::Body;
use crate::slices::{given, lent_mut};
use crate::types::{VdmBody, VdmPlace, VdmStatus};

/// The place that is a loadable node; no search.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_at_node(body: *mut VdmBody, node: u32, place: *mut VdmPlace) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), place.as_mut()) } {
        (Some(body), Some(place)) => body.at_node(node, place),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Instants of a step at which a load that changes is asked for, as fractions of the step; four numbers, of
/// which those past the stages of the scheme are 0.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `instants` points to four numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_instants(body: *mut VdmBody, instants: *mut f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), lent_mut(instants, 1 + MAX_STAGES)) } {
        (Some(body), out) if !out.is_empty() => {
            out.iter_mut().zip(body.instants()).for_each(|(out, t)| *out = t);
            VdmStatus::VDM_OK
        }
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Adds a force in N that changes within a step: `force` times the four `amplitudes` at [`vdm_instants`].
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`, `force` to
/// three numbers, and `amplitudes` to four.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_add_contact_staged(
    body: *mut VdmBody,
    place: *const VdmPlace,
    force: *const f64,
    amplitudes: *const f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), place.as_ref(), given::<3>(force), given(amplitudes)) } {
        (Some(body), Some(place), Some(force), Some(amplitudes)) => {
            body.add_contact_staged(place, force, &amplitudes)
        }
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Adds a load pattern that changes within a step: times the four `amplitudes` at [`vdm_instants`].
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `amplitudes` points to four numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_add_pattern_staged(
    body: *mut VdmBody,
    pattern: u32,
    amplitudes: *const f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), given(amplitudes)) } {
        (Some(body), Some(amplitudes)) => body.add_pattern_staged(pattern, &amplitudes),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Adds a force in N that goes linearly from `start` to `end` over one step.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`, `start` and
/// `end` to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_add_contact_ramp(
    body: *mut VdmBody,
    place: *const VdmPlace,
    start: *const f64,
    end: *const f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), place.as_ref(), given::<3>(start), given::<3>(end)) } {
        (Some(body), Some(place), Some(start), Some(end)) => body.add_contact_ramp(place, start, end),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Adds a load pattern whose amplitude goes linearly from `start` to `end` over one step.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_add_pattern_ramp(
    body: *mut VdmBody,
    pattern: u32,
    start: f64,
    end: f64,
) -> VdmStatus {
    with!(body => body.add_pattern_ramp(pattern, start, end))
}

/// Keeps the loads as they are, for a body bound with `VdmOptions.keep_loads`: those that stay, in a loop
/// that adds others to them in each step.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_keep_loads(body: *mut VdmBody) -> VdmStatus {
    with!(body => body.keep_loads())
}

/// The loads become those that were kept.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_recall_loads(body: *mut VdmBody) -> VdmStatus {
    with!(body => body.recall_loads())
}
