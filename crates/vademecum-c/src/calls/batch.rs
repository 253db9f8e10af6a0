//! Many instances of a body.

use crate::batch::{Instances, bytes, on_batch};
use crate::handle::{Lent, ask, on_handle};
use crate::refusal::needed;
use crate::types::{VdmBatch, VdmBatchStatus, VdmBody, VdmStatus};

/// Bytes of memory, aligned to 16, to lend for so many instances of a body; 0 for null.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_batch_bytes(body: *const VdmBody, instances: usize) -> usize {
    // SAFETY: as the caller promises.
    unsafe { ask(body, 0, |body| bytes(body, instances)) }
}

/// Makes instances of the elastic motion of a body, all at rest and without loads, in lent memory. `*batch`
/// is the handle, or null.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `memory` points to `memory_bytes` bytes that
/// nobody else uses for as long as the handle is used, and `batch` to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_batch_bind(
    body: *mut VdmBody,
    instances: usize,
    memory: *mut u8,
    memory_bytes: usize,
    batch: *mut *mut VdmBatch,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on_handle(body, |handle| {
            let batch = needed(batch.as_mut(), "batch")?;
            *batch = core::ptr::null_mut();
            *batch = Instances::bind(handle, instances, Lent::new(memory, memory_bytes)?)?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Loads an instance with the loads of the body, in place of what it had; they stay until the next call.
///
/// # Safety
/// `batch` is null or a handle of [`vdm_batch_bind`], `body` null or a handle of
/// [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_batch_load(
    batch: *mut VdmBatch,
    body: *mut VdmBody,
    instance: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe { on_batch(batch, body, |batch, body| batch.load(body, instance)) }
}

/// Takes the loads of all instances away.
///
/// # Safety
/// `batch` is null or a handle of [`vdm_batch_bind`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_batch_clear(batch: *mut VdmBatch) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe { Instances::of_mut(batch) }.map_or(VdmStatus::VDM_ARGUMENT, Instances::clear)
}

/// Gives an instance the state of the body.
///
/// # Safety
/// As for [`vdm_batch_load`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_batch_set(
    batch: *mut VdmBatch,
    body: *mut VdmBody,
    instance: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe { on_batch(batch, body, |batch, body| batch.set(body, instance)) }
}

/// Gives the body the state of an instance, from which everything can be read but reactions.
///
/// # Safety
/// As for [`vdm_batch_load`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_batch_get(
    batch: *mut VdmBatch,
    body: *mut VdmBody,
    instance: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe { on_batch(batch, body, |batch, body| batch.get(body, instance)) }
}

/// [`vdm_batch_get`] for an instance whose last step was one under the loads that the body has now: stress
/// and displacement show what the modes leave out of the answer to them, and reactions can be read, which are
/// refused after [`vdm_batch_get`].
///
/// # Safety
/// As for [`vdm_batch_load`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_batch_get_under(
    batch: *mut VdmBatch,
    body: *mut VdmBody,
    instance: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe { on_batch(batch, body, |batch, body| batch.get_under(body, instance)) }
}

/// Steps all instances `steps` times; `found` tells how many move, rest and were refused in the last step. An
/// instance that was refused keeps its state; the answer is then `VDM_STEP`, and the others have moved.
///
/// # Safety
/// As for [`vdm_batch_load`]; `found` points to a `VdmBatchStatus`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_batch_step(
    batch: *mut VdmBatch,
    body: *mut VdmBody,
    steps: u64,
    found: *mut VdmBatchStatus,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe { on_batch(batch, body, |batch, body| batch.step(body, steps, needed(found.as_mut(), "found")?)) }
}

/// The result of the last step for an instance: `VDM_OK`, `VDM_AT_REST`, or `VDM_STEP` if it was refused.
///
/// # Safety
/// As for [`vdm_batch_load`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_batch_status(
    batch: *mut VdmBatch,
    body: *mut VdmBody,
    instance: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe { on_batch(batch, body, |batch, body| batch.status(body, instance)) }
}

/// Carries the states of all instances over to the parameters that the body has now. Their loads are stale:
/// clear them. Instances of a body with live regions keep the parameters at which they were made, and every
/// call is refused while the body has others (`VDM_BIND`).
///
/// # Safety
/// As for [`vdm_batch_load`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_batch_carry(batch: *mut VdmBatch, body: *mut VdmBody) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe { on_batch(batch, body, |batch, body| batch.carry(body)) }
}
