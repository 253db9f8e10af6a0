//! The C interface of the evaluator: opaque handles over lent memory.
//!
//! A caller asks how many bytes a body needs ([`vdm_measure`]), lends them ([`vdm_bind`]), and from then on
//! drives the body through its handle. Every call checks its pointers for null and its lengths; it answers
//! with a [`VdmStatus`], and [`vdm_message`] says in words what was wrong with the last call of a body.
//! Numbers cross the boundary as `double`, whatever the precision of the march.
//!
//! The odd thing: a body holds references into memory that C owns. Their lifetime is written as `'static`
//! here, and the caller keeps the promise: file and memory stay where they are, unchanged, for as long as the
//! handle is used.
#![allow(unsafe_code)]
// Names are those of the header.
#![allow(non_camel_case_types)]
#![cfg_attr(not(feature = "std"), no_std)]

mod batch;
mod body;
mod calls;
mod flight;
mod loads;
mod message;
mod names;
mod outputs;
mod slices;
mod solved;
mod states;
mod types;

use core::ffi::c_char;

use vademecum_eval::format::File;

use body::{Asked, Body, Lent};
pub use calls::*;
use message::Message;
use outputs::{Part, Source};
use slices::{borrowed, given, lent, lent_mut};
pub use types::*;

/// No panic is reachable from the calls. Without an operating system there must be a handler nevertheless,
/// and it stops.
#[cfg(not(any(feature = "std", test)))]
#[panic_handler]
fn stop(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}

/// What is wrong with options that are none.
const BAD_OPTION: &str = "an option is none: precision, structure, or more than 64 places; start from \
                          vdm_default_options";

/// The version of the interface that this library has.
#[unsafe(no_mangle)]
pub extern "C" fn vdm_abi() -> u32 {
    VDM_ABI
}

/// What a status means, in words; never null.
#[unsafe(no_mangle)]
pub extern "C" fn vdm_status_text(status: i32) -> *const c_char {
    message::status(status).as_ptr()
}

/// The file as it was built: single precision, room for 16 contacts, with residual.
///
/// # Safety
/// `options` is null or points to a `VdmOptions`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_default_options(options: *mut VdmOptions) {
    // SAFETY: as the caller promises.
    if let Some(options) = unsafe { options.as_mut() } {
        *options = VdmOptions {
            precision: VdmPrecision::VDM_SINGLE as i32,
            structure: VdmStructure::VDM_AUTO as i32,
            contacts: 16,
            residual: 1,
            places: 64,
            keep_loads: 0,
            terms: 0,
            substeps: 0,
            tolerance: 0.0,
            time_step: 0.0,
            stiffness: 1.0,
            density: 1.0,
            alpha: -1.0,
            beta: -1.0,
            rest_below: 0.0,
            viscosity: vademecum_eval::SceneOptions::default().viscosity,
        };
    }
}

/// How much memory a body of this file needs under these options (null: the default ones).
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
    let mut message = Message::default();
    let (Some(bytes), Some(needs)) = (file, needs) else {
        return message.tell(VdmStatus::VDM_ARGUMENT, &"a null pointer", text);
    };
    let Some(asked) = Asked::of(options) else {
        return message.tell(VdmStatus::VDM_ARGUMENT, &BAD_OPTION, text);
    };
    match File::parse(bytes).map_err(|error| message.note(VdmStatus::VDM_FILE, &error)).and_then(|file| {
        body::measure(&file, &asked).map_err(|error| message.note(VdmStatus::VDM_BIND, &error))
    }) {
        Ok(found) => {
            *needs = found;
            VdmStatus::VDM_OK
        }
        Err(status) => message.hand_out(status, text),
    }
}

/// Binds a body at rest, without loads, in lent memory. `*body` is the handle, or null.
///
/// # Safety
/// `file` points to `length` bytes and `memory` to `memory_bytes` bytes that nobody else uses; both stay
/// where they are, and the file unchanged, for as long as the handle is used. `work` points to `work_numbers`
/// numbers for the time of the call. `options` is null or points to a `VdmOptions`, `body` points to a
/// pointer, and `text` is null or points to `capacity` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_bind(
    file: *const u8,
    length: usize,
    options: *const VdmOptions,
    memory: *mut u8,
    memory_bytes: usize,
    work: *mut f64,
    work_numbers: usize,
    body: *mut *mut VdmBody,
    text: *mut c_char,
    capacity: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises; file and memory outlive the handle.
    let (file, options, memory, work, body, text) = unsafe {
        (
            borrowed(file, length),
            options.as_ref(),
            Lent::new(memory, memory_bytes),
            lent_mut(work, work_numbers),
            body.as_mut(),
            lent_mut(text, capacity),
        )
    };
    let mut message = Message::default();
    let Some(body) = body else {
        return message.tell(VdmStatus::VDM_ARGUMENT, &"a null pointer", text);
    };
    *body = core::ptr::null_mut();
    let Some(bytes) = file else {
        return message.tell(VdmStatus::VDM_ARGUMENT, &"a null pointer", text);
    };
    let Some(memory) = memory else {
        let said = "the lent memory is null, or not aligned to 16 bytes";
        return message.tell(VdmStatus::VDM_MEMORY, &said, text);
    };
    let Some(asked) = Asked::of(options) else {
        return message.tell(VdmStatus::VDM_ARGUMENT, &BAD_OPTION, text);
    };
    let bound = match File::parse(bytes) {
        Ok(file) => Body::bind(file, &asked, memory, work, &mut message),
        Err(error) => Err(message.note(VdmStatus::VDM_FILE, &error)),
    };
    match bound {
        Ok(handle) => {
            *body = handle;
            VdmStatus::VDM_OK
        }
        Err(status) => message.hand_out(status, text),
    }
}

/// What was wrong with the last call of this body that was refused; never null.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`]. The text lives until the next call of the body.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_message(body: *const VdmBody) -> *const c_char {
    // SAFETY: as the caller promises.
    unsafe { Body::of(body) }.map_or(c"the handle is null".as_ptr(), |body| body.message().as_ptr())
}

/// Steps `steps` times under the loads at hand; stops at the first step that is refused.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_step(body: *mut VdmBody, steps: u64) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe { Body::of_mut(body) }.map_or(VdmStatus::VDM_ARGUMENT, |body| body.step(steps))
}

/// Puts the body at rest, as it was bound. Loads stay.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_rest(body: *mut VdmBody) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe { Body::of_mut(body) }.map_or(VdmStatus::VDM_ARGUMENT, Body::rest)
}

/// The place of the loadable surface at rest that is nearest to a point. A search over all triangles: `O(n)`.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`], `point` points to three numbers, `place` to a `VdmPlace`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_locate(
    body: *mut VdmBody,
    point: *const f64,
    place: *mut VdmPlace,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), given::<3>(point), place.as_mut()) } {
        (Some(body), Some(point), Some(place)) => body.locate(point, place),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Takes all loads away.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_clear_loads(body: *mut VdmBody) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe { Body::of_mut(body) }.map_or(VdmStatus::VDM_ARGUMENT, Body::clear_loads)
}

/// Adds a force in N at a place; it acts in every step until [`vdm_clear_loads`].
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`], `place` points to a `VdmPlace`, `force` to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_add_contact(
    body: *mut VdmBody,
    place: *const VdmPlace,
    force: *const f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), place.as_ref(), given::<3>(force)) } {
        (Some(body), Some(place), Some(force)) => body.add_contact(place, force),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Adds a load pattern, times an amplitude; it acts in every step until [`vdm_clear_loads`].
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_add_pattern(body: *mut VdmBody, pattern: u32, amplitude: f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe { Body::of_mut(body) }.map_or(VdmStatus::VDM_ARGUMENT, |body| body.add_pattern(pattern, amplitude))
}

/// Sets a live parameter. Loads become stale: clear them and add them again.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`]; `work` points to `work_numbers` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_set_parameter(
    body: *mut VdmBody,
    parameter: u32,
    value: f64,
    work: *mut f64,
    work_numbers: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), lent_mut(work, work_numbers)) } {
        (Some(body), work) => body.set_parameter(parameter, value, work),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// The value of a probe.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`]; `value` points to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_probe(body: *mut VdmBody, probe: u32, field: i32, value: *mut f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), value.as_mut()) } {
        (Some(body), Some(value)) => body.probe(probe, field, value),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Displacement or velocity of a place of the surface; three numbers.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`], `place` points to a `VdmPlace`, `out` to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_point(
    body: *mut VdmBody,
    place: *const VdmPlace,
    field: i32,
    out: *mut f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), place.as_ref(), lent_mut(out, 3)) } {
        (Some(body), Some(place), [x, y, z]) => body.point(place, field, [x, y, z]),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Displacement or velocity of a node; three numbers.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`]; `out` points to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_node(body: *mut VdmBody, node: u32, field: i32, out: *mut f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), lent_mut(out, 3)) } {
        (Some(body), [x, y, z]) => body.node(node, field, [x, y, z]),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Displacement or velocity of all nodes of the surface, three `float`s a node: as a vertex array wants them.
/// For a body in single precision.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`]; `out` points to `numbers` numbers, three a node.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_surface_f32(
    body: *mut VdmBody,
    field: i32,
    out: *mut f32,
    numbers: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), lent_mut(out, numbers)) } {
        (Some(body), out) => body.field_single(Part::Surface, Source::Modes, field, out),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// The same for a body in double precision.
///
/// # Safety
/// As for [`vdm_surface_f32`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_surface_f64(
    body: *mut VdmBody,
    field: i32,
    out: *mut f64,
    numbers: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), lent_mut(out, numbers)) } {
        (Some(body), out) => body.field_double(Part::Surface, Source::Modes, field, out),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Kinetic plus elastic energy, in J.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`]; `value` points to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_energy(body: *mut VdmBody, value: *mut f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), value.as_mut()) } {
        (Some(body), Some(value)) => body.energy(value),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Copies the state out, every bit of it (in the body's precision); at least `VdmNeeds.state` numbers are
/// lent.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`]; `out` points to `numbers` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_save(body: *mut VdmBody, out: *mut f64, numbers: usize) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), lent_mut(out, numbers)) } {
        (Some(body), out) => body.save(out),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Takes back what [`vdm_save`] has written.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`]; `saved` points to `numbers` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_restore(body: *mut VdmBody, saved: *const f64, numbers: usize) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), lent(saved, numbers)) } {
        (Some(body), Some(saved)) => body.restore(saved),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// How far each of `count` places, at most `VdmOptions.places`, moves in the coming step for a force of 1 N
/// held at each: `w` receives `(3 count)²` numbers, row by row, in m/N.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`], `places` points to `count` places, and `w` to `(3 count)²`
/// numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_compliance(
    body: *mut VdmBody,
    places: *const VdmPlace,
    count: usize,
    w: *mut f64,
) -> VdmStatus {
    let Some(entries) = count.checked_mul(3).and_then(|n| n.checked_mul(n)) else {
        return VdmStatus::VDM_ARGUMENT;
    };
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), lent(places, count), lent_mut(w, entries)) } {
        (Some(body), Some(places), w) => body.compliance(places, w),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Copies a name of the file into `out`, which has `capacity` bytes, with a zero at its end; a longer name is
/// cut.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`]; `out` points to `capacity` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_name(
    body: *mut VdmBody,
    kind: i32,
    index: u32,
    out: *mut c_char,
    capacity: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), lent_mut(out, capacity)) } {
        (Some(body), out) => body.name(kind, index, out),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// The number of what has this name, counted from 0; -1 if nothing has.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`]; `name` points to a text with a zero at its end.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_find(body: *mut VdmBody, kind: i32, name: *const c_char) -> i32 {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), slices::text(name)) } {
        (Some(body), Some(name)) => body.find(kind, name),
        _ => -1,
    }
}
