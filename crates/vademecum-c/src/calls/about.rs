//! What a file and a body say of themselves, and live parameters.

use core::ffi::c_char;

use vademecum_eval::format::File;

use crate::body::Body;
use crate::message::Message;
use crate::slices::{borrowed, lent, lent_mut};
use crate::types::{VdmBody, VdmCost, VdmParameter, VdmStatus, VdmStructure};

/// Compares every section of a file with its checksum, which `vdm_bind` does not: it reads all bytes.
///
/// # Safety
/// `file` points to `length` bytes, and `text` is null or points to `capacity` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_verify(
    file: *const u8,
    length: usize,
    text: *mut c_char,
    capacity: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises; nothing outlives the call.
    let (file, text) = unsafe { (borrowed(file, length), lent_mut(text, capacity)) };
    let mut message = Message::default();
    let Some(bytes) = file else {
        return message.tell(VdmStatus::VDM_ARGUMENT, &"a null pointer", text);
    };
    match File::parse(bytes).and_then(|file| file.verify_all()) {
        Ok(()) => VdmStatus::VDM_OK,
        Err(error) => message.tell(VdmStatus::VDM_FILE, &error, text),
    }
}

/// The `VdmStructure` that the body took; `VDM_AUTO` for null.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_structure(body: *mut VdmBody) -> i32 {
    // SAFETY: as the caller promises.
    unsafe { Body::of_mut(body) }.map_or(VdmStructure::VDM_AUTO as i32, Body::structure)
}

/// Range and present value of a live parameter.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to a `VdmParameter`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_parameter(
    body: *mut VdmBody,
    parameter: u32,
    out: *mut VdmParameter,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), out.as_mut()) } {
        (Some(body), Some(out)) => body.parameter(parameter, out),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Sets all live parameters at once. Loads become stale: clear them and add them again.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `values` points to `count` numbers, `work` to
/// `work_numbers`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_set_parameters(
    body: *mut VdmBody,
    values: *const f64,
    count: usize,
    work: *mut f64,
    work_numbers: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), lent(values, count), lent_mut(work, work_numbers)) } {
        (Some(body), Some(values), work) => body.set_parameters(values, work),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// What the moves of the body cost.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `cost` points to a `VdmCost`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_cost(body: *mut VdmBody, cost: *mut VdmCost) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), cost.as_mut()) } {
        (Some(body), Some(cost)) => {
            *cost = body.cost();
            VdmStatus::VDM_OK
        }
        _ => VdmStatus::VDM_ARGUMENT,
    }
}
