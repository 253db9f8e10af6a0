//! The modes of a dense step.

use crate::body::{Body, Lent};
use crate::slices::lent_mut;
use crate::types::{VdmBody, VdmStatus};

/// Bytes of memory, aligned to 16, and numbers of work that the modes of a dense step want; zeros for a body
/// without the block structure.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `memory_bytes` and `work_numbers` each point
/// to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_modal_needs(
    body: *mut VdmBody,
    memory_bytes: *mut usize,
    work_numbers: *mut usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), memory_bytes.as_mut(), work_numbers.as_mut()) } {
        (Some(body), Some(memory), Some(work)) => {
            (*memory, *work) = body.modal_needs();
            VdmStatus::VDM_OK
        }
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Takes the dense step of a body with the block structure apart into independent modes, at the parameters it
/// has now. What the modes do not share is left out, and refused above `tolerance` (1e-5 is usual).
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `memory` points to `memory_bytes` bytes that
/// nobody else uses for as long as the body is used, `work` to `work_numbers` numbers for the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_modal_bind(
    body: *mut VdmBody,
    tolerance: f64,
    memory: *mut u8,
    memory_bytes: usize,
    work: *mut f64,
    work_numbers: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), Lent::new(memory, memory_bytes), lent_mut(work, work_numbers)) } {
        (Some(body), Some(memory), work) => body.modal_bind(tolerance, memory, work),
        (Some(_), None, _) => VdmStatus::VDM_MEMORY,
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Steps `steps` times, all under the loads at hand, in the modes of [`vdm_modal_bind`]. Ten steps in a call
/// are cheaper than ten of `vdm_step`, one is not.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_modal_march(body: *mut VdmBody, steps: usize) -> VdmStatus {
    with!(body => body.modal_march(steps))
}
