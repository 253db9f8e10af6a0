//! Steps, states, and the answer of a step at places.

use vademecum_eval::{LoadError, Restored, Status, StepError};

use crate::handle::{ask, on};
use crate::refusal::{Refusal, needed};
use crate::slices::{lent, lent_mut};
use crate::types::{VdmBody, VdmPlace, VdmStatus};

/// Steps `steps` times under the loads at hand; stops at the first step that is refused. A body that flies
/// moves in space, too; its loads act in the first of the steps.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_step(body: *mut VdmBody, steps: u64) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            Ok(match body.march(usize::try_from(steps).unwrap_or(usize::MAX))? {
                Status::AtRest => VdmStatus::VDM_AT_REST,
                _ => VdmStatus::VDM_OK,
            })
        })
    }
}

/// Puts the body at rest where the file has it. Loads stay.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_rest(body: *mut VdmBody) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            body.rest();
            Ok(VdmStatus::VDM_OK)
        })
    }
}

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
    unsafe {
        on(body, |body| {
            body.set(needed(lent(zeta, count), "zeta")?, needed(lent(zeta_dot, count), "zeta_dot")?)?;
            Ok(VdmStatus::VDM_OK)
        })
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
    unsafe {
        on(body, |body| {
            let (zeta, zeta_dot) =
                (needed(lent_mut(zeta, count), "zeta")?, needed(lent_mut(zeta_dot, count), "zeta_dot")?);
            body.coordinates_into(zeta, zeta_dot)?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Bytes that [`vdm_save`] writes at most; 0 for null.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_saved_length(body: *const VdmBody) -> usize {
    // SAFETY: as the caller promises.
    unsafe { ask(body, 0, |body| body.saved_len()) }
}

/// Writes everything that a step changes as bytes: a tag of 16, which says what they belong to, then
/// little-endian numbers. `*written` is how many bytes there are. Loads are not part of it.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `bytes` points to `capacity` bytes, `written`
/// to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_save(
    body: *mut VdmBody,
    bytes: *mut u8,
    capacity: usize,
    written: *mut usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (bytes, written) =
                (needed(lent_mut(bytes, capacity), "bytes")?, needed(written.as_mut(), "written")?);
            *written = body.save_into(bytes)?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Takes back what [`vdm_save`] of a body of the same file and structure has written: `VDM_OK` if every bit
/// is as it was saved, `VDM_CARRIED` if the state was saved at other parameters or in the other precision and
/// has been carried over. Other bytes are refused, and change nothing.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `bytes` points to `length` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_restore(body: *mut VdmBody, bytes: *const u8, length: usize) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            Ok(match body.restore(needed(lent(bytes, length), "bytes")?)? {
                Restored::AsSaved => VdmStatus::VDM_OK,
                Restored::Carried => VdmStatus::VDM_CARRIED,
            })
        })
    }
}

/// The displacement of each of `count` places, at most `VdmOptions.places`, at the end of the coming step for
/// a force of 1 N at each of them: `w` of `3 count` rows and columns, row by row, in m/N. Not for the block
/// structure.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `places` points to `count` places, `w` to `9
/// count²` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_compliance(
    body: *mut VdmBody,
    places: *const VdmPlace,
    count: usize,
    w: *mut f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let numbers = count.checked_mul(count).and_then(|pairs| pairs.checked_mul(9)).ok_or(TOO_MANY)?;
            let (places, w) = (needed(lent(places, count), "places")?, needed(lent_mut(w, numbers), "w")?);
            match body.compliance(places, w) {
                Ok(()) => Ok(VdmStatus::VDM_OK),
                Err(LoadError::Mismatch) => Err(TOO_MANY),
                Err(error) => Err(error.into()),
            }
        })
    }
}

/// Predicts `count` places, at most `VdmOptions.places`, at the end of the coming step if nothing acts
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
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let numbers = count.checked_mul(3).ok_or(TOO_MANY)?;
            let (places, out) =
                (needed(lent(places, count), "places")?, needed(lent_mut(out, numbers), "out")?);
            match body.free_motion(places, out.as_chunks_mut().0) {
                Ok(()) => Ok(VdmStatus::VDM_OK),
                Err(StepError::Mismatch) => Err(TOO_MANY),
                Err(error) => Err(error.into()),
            }
        })
    }
}

/// The evaluator's refusal of loads of another shape.
const TOO_MANY: Refusal = Refusal::Words(
    VdmStatus::VDM_LOAD,
    "more places than VdmOptions.places, or a body with the block structure, which has no operator",
);
