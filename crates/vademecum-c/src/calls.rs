//! The calls beyond the shortest loop: loads that change within a step, live parameters, whole fields, the
//! static answer, the modes of a dense step, and many instances.

use core::ffi::c_char;

use vademecum_eval::BaseMotion;
use vademecum_eval::format::File;
use vademecum_eval::format::scheme::MAX_STAGES;

use crate::batch::{Instances, bytes};
use crate::body::{Body, Lent};
use crate::message::Message;
use crate::outputs::{Part, Source};
use crate::slices::{borrowed, given, lent, lent_mut};
use crate::types::{
    VdmBatch, VdmBatchStatus, VdmBody, VdmCost, VdmParameter, VdmPlace, VdmStatus, VdmStructure,
};

/// Runs lines with a body, or refuses a null handle.
macro_rules! with {
    ($body:ident => $lines:expr) => {
        // SAFETY: as the caller of the function promises.
        match unsafe { Body::of_mut($body) } {
            Some($body) => $lines,
            None => VdmStatus::VDM_ARGUMENT,
        }
    };
}

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

/// Adds the inertia of a base that moves so, in its own axes: acceleration in m/s², angular velocity in rad/s
/// and angular acceleration in rad/s², three numbers each. It acts in every step until `vdm_clear_loads`.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), each pointer points to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_add_base(
    body: *mut VdmBody,
    acceleration: *const f64,
    angular_velocity: *const f64,
    angular_acceleration: *const f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    let motion = unsafe { (given(acceleration), given(angular_velocity), given(angular_acceleration)) };
    let (Some(acceleration), Some(angular_velocity), Some(angular_acceleration)) = motion else {
        return VdmStatus::VDM_ARGUMENT;
    };
    let motion = BaseMotion { acceleration, angular_velocity, angular_acceleration };
    with!(body => body.add_base(&motion))
}

/// Force in N and moment in N m that a support exerts on the body, six numbers into `out`.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to six numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_reaction(body: *mut VdmBody, support: u32, out: *mut f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), out.cast::<[f64; 6]>().as_mut()) } {
        (Some(body), Some(out)) => body.reaction(support, out),
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

/// Displacement or velocity of all nodes, three `float`s a node. For a body in single precision.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_body_f32(
    body: *mut VdmBody,
    field: i32,
    out: *mut f32,
    numbers: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    let out = unsafe { lent_mut(out, numbers) };
    with!(body => body.field_single(Part::Body, Source::Modes, field, out))
}

/// The same for a body in double precision.
///
/// # Safety
/// As for [`vdm_body_f32`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_body_f64(
    body: *mut VdmBody,
    field: i32,
    out: *mut f64,
    numbers: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    let out = unsafe { lent_mut(out, numbers) };
    with!(body => body.field_double(Part::Body, Source::Modes, field, out))
}

/// Where the nodes of the surface are at rest, in m; three numbers a node.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_positions(body: *mut VdmBody, out: *mut f64, numbers: usize) -> VdmStatus {
    // SAFETY: as the caller promises.
    let out = unsafe { lent_mut(out, numbers) };
    with!(body => body.positions(out))
}

/// The triangles of the surface, three nodes each, counter-clockwise from outside.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_triangles(body: *mut VdmBody, out: *mut u32, numbers: usize) -> VdmStatus {
    // SAFETY: as the caller promises.
    let out = unsafe { lent_mut(out, numbers) };
    with!(body => body.triangles(out))
}

/// The largest energy, in J, that an unloaded body has when it is put at rest.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `value` points to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_energy_at_rest(body: *mut VdmBody, value: *mut f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), value.as_mut()) } {
        (Some(body), Some(value)) => {
            *value = body.energy_at_rest();
            VdmStatus::VDM_OK
        }
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

/// Bytes of memory, aligned to 16, to lend for the static answer of the whole body; 0 where the file does not
/// have it (`static_fields` of the problem file).
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_static_bytes(body: *mut VdmBody) -> usize {
    // SAFETY: as the caller promises.
    unsafe { Body::of_mut(body) }.map_or(0, Body::static_bytes)
}

/// Lends memory for the static answer of the whole body, for as long as the body is used.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `memory` points to `memory_bytes` bytes that
/// nobody else uses.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_static_lend(
    body: *mut VdmBody,
    memory: *mut u8,
    memory_bytes: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), Lent::new(memory, memory_bytes)) } {
        (Some(body), Some(memory)) => body.static_lend(memory),
        (Some(_), None) => VdmStatus::VDM_MEMORY,
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Solves for the static answer to the forces of the last step; worth it only when they have changed.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_static_solve(body: *mut VdmBody) -> VdmStatus {
    with!(body => body.static_solve())
}

/// [`vdm_surface_f32`](crate::vdm_surface_f32) with the static answer that was solved for.
///
/// # Safety
/// As for [`vdm_body_f32`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_static_surface_f32(
    body: *mut VdmBody,
    field: i32,
    out: *mut f32,
    numbers: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    let out = unsafe { lent_mut(out, numbers) };
    with!(body => body.field_single(Part::Surface, Source::Whole, field, out))
}

/// The same for a body in double precision.
///
/// # Safety
/// As for [`vdm_body_f32`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_static_surface_f64(
    body: *mut VdmBody,
    field: i32,
    out: *mut f64,
    numbers: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    let out = unsafe { lent_mut(out, numbers) };
    with!(body => body.field_double(Part::Surface, Source::Whole, field, out))
}

/// [`vdm_body_f32`] with the static answer that was solved for.
///
/// # Safety
/// As for [`vdm_body_f32`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_static_body_f32(
    body: *mut VdmBody,
    field: i32,
    out: *mut f32,
    numbers: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    let out = unsafe { lent_mut(out, numbers) };
    with!(body => body.field_single(Part::Body, Source::Whole, field, out))
}

/// The same for a body in double precision.
///
/// # Safety
/// As for [`vdm_body_f32`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_static_body_f64(
    body: *mut VdmBody,
    field: i32,
    out: *mut f64,
    numbers: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    let out = unsafe { lent_mut(out, numbers) };
    with!(body => body.field_double(Part::Body, Source::Whole, field, out))
}

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

/// Bytes of memory, aligned to 16, to lend for so many instances of a body; 0 for null.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_batch_bytes(body: *const VdmBody, instances: usize) -> usize {
    // SAFETY: as the caller promises.
    unsafe { Body::of(body) }.map_or(0, |body| bytes(body, instances))
}

/// Makes instances of a body, all at rest and without loads, in lent memory. `*batch` is the handle, or null.
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
    let (body, memory, batch) =
        unsafe { (Body::of_mut(body), Lent::new(memory, memory_bytes), batch.as_mut()) };
    let (Some(body), Some(batch)) = (body, batch) else { return VdmStatus::VDM_ARGUMENT };
    *batch = core::ptr::null_mut();
    let Some(memory) = memory else { return VdmStatus::VDM_MEMORY };
    match Instances::bind(body, instances, memory) {
        Ok(handle) => {
            *batch = handle;
            VdmStatus::VDM_OK
        }
        Err(status) => status,
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
    match unsafe { (Instances::of_mut(batch), Body::of_mut(body)) } {
        (Some(batch), Some(body)) => batch.load(body, instance),
        _ => VdmStatus::VDM_ARGUMENT,
    }
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
    match unsafe { (Instances::of_mut(batch), Body::of_mut(body)) } {
        (Some(batch), Some(body)) => batch.set(body, instance),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Gives the body the state of an instance, from which everything can be read.
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
    match unsafe { (Instances::of_mut(batch), Body::of_mut(body)) } {
        (Some(batch), Some(body)) => batch.get(body, instance),
        _ => VdmStatus::VDM_ARGUMENT,
    }
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
    match unsafe { (Instances::of_mut(batch), Body::of_mut(body), found.as_mut()) } {
        (Some(batch), Some(body), Some(found)) => batch.step(body, steps, found),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// What the last step found of an instance.
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
    match unsafe { (Instances::of_mut(batch), Body::of_mut(body)) } {
        (Some(batch), Some(body)) => batch.status(body, instance),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Carries the states of all instances over to the parameters that the body has now. Their loads are stale:
/// clear them.
///
/// # Safety
/// As for [`vdm_batch_load`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_batch_carry(batch: *mut VdmBatch, body: *mut VdmBody) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Instances::of_mut(batch), Body::of_mut(body)) } {
        (Some(batch), Some(body)) => batch.carry(body),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}
