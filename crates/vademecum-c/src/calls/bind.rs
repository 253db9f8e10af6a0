//! Memory, binding, and the words of refusals.

use core::ffi::c_char;

use vademecum_eval::format::File;
use vademecum_eval::{BodyOptions, SceneOptions};

use crate::handle::{Asked, Handle, Lent};
use crate::message::{Message, status};
use crate::refusal::needed;
use crate::slices::{borrowed, lent_mut};
use crate::types::{VDM_ABI, VdmBody, VdmNeeds, VdmOptions, VdmPrecision, VdmStatus, VdmStructure};

/// The version of the interface that this library has.
#[unsafe(no_mangle)]
pub extern "C" fn vdm_abi() -> u32 {
    VDM_ABI
}

/// The meaning of a status, in words; never null.
#[unsafe(no_mangle)]
pub extern "C" fn vdm_status_text(status: i32) -> *const c_char {
    self::status(status).as_ptr()
}

/// The file as it was built: single precision, room for 16 contacts, with residual flexibility, flying if it
/// has no supports.
///
/// # Safety
/// `options` is null or points to a `VdmOptions`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_default_options(options: *mut VdmOptions) {
    // SAFETY: as the caller promises.
    if let Some(options) = unsafe { options.as_mut() } {
        let body = BodyOptions::default();
        let SceneOptions { contacts, residual, tolerance, stiffness, density, rest_below, viscosity, .. } =
            body.scene;
        *options = VdmOptions {
            precision: VdmPrecision::VDM_SINGLE as i32,
            structure: VdmStructure::VDM_AUTO as i32,
            contacts: contacts as u32,
            filtered_nodes: 0,
            residual: u32::from(residual),
            places: body.places as u32,
            keep_loads: u32::from(body.keep_loads),
            static_field: u32::from(body.static_field),
            flight: u32::from(body.flight),
            terms: 0,
            substeps: 0,
            modes: 0,
            tolerance,
            time_step: 0.0,
            stiffness,
            density,
            alpha: -1.0,
            beta: -1.0,
            rest_below,
            viscosity,
        };
    }
}

/// The memory that a body of this file needs under these options (null: the default ones).
///
/// `text`, of `capacity` bytes, receives what is wrong in words if it is not null.
///
/// # Safety
/// `file` points to `length` bytes, `options` is null or points to a `VdmOptions`, `needs` points to a
/// `VdmNeeds`, and `text` is null or points to `capacity` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_measure(
    file: *const u8,
    length: usize,
    options: *const VdmOptions,
    needs: *mut VdmNeeds,
    text: *mut c_char,
    capacity: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises; nothing outlives the call.
    let (file, options, needs, text) =
        unsafe { (borrowed(file, length), options.as_ref(), needs.as_mut(), lent_mut(text, capacity)) };
    let run = || {
        let (bytes, needs) = (needed(file, "file")?, needed(needs, "needs")?);
        let asked = Asked::of(options)?;
        *needs = asked.needs(&File::parse(bytes)?)?;
        Ok(VdmStatus::VDM_OK)
    };
    run().unwrap_or_else(|refusal| Message::tell(&refusal, text))
}

/// Binds a body at rest, without loads, in lent memory. `*body` is the handle, or null.
///
/// # Safety
/// `file` points to `length` bytes and `memory` to `memory_bytes` bytes that nobody else uses; both stay
/// where they are, and the file unchanged, for as long as the handle is used. `options` is null or points to
/// a `VdmOptions`, `body` points to a pointer, and `text` is null or points to `capacity` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_bind(
    file: *const u8,
    length: usize,
    options: *const VdmOptions,
    memory: *mut u8,
    memory_bytes: usize,
    body: *mut *mut VdmBody,
    text: *mut c_char,
    capacity: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises; the file outlives the handle.
    let (file, options, body, text) =
        unsafe { (borrowed(file, length), options.as_ref(), body.as_mut(), lent_mut(text, capacity)) };
    let run = || {
        let body = needed(body, "body")?;
        *body = core::ptr::null_mut();
        let bytes = needed(file, "file")?;
        // SAFETY: as the caller promises; the memory outlives the handle.
        let memory = unsafe { Lent::new(memory, memory_bytes)? };
        let asked = Asked::of(options)?;
        *body = Handle::bind(&File::parse(bytes)?, &asked, &memory)?;
        Ok(VdmStatus::VDM_OK)
    };
    run().unwrap_or_else(|refusal| Message::tell(&refusal, text))
}

/// The words of the last call of this body that was refused; never null.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`]. The text lives until the next call of the body.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_message(body: *const VdmBody) -> *const c_char {
    // SAFETY: as the caller promises.
    unsafe { Handle::of(body) }.map_or(c"the handle is null".as_ptr(), |handle| handle.message.as_ptr())
}
