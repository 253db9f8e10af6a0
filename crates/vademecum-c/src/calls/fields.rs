//! Whole fields, with the static answer that the modes leave a part of out; the surface; the energy at rest.

use crate::body::{Body, Lent};
use crate::outputs::{Part, Source};
use crate::slices::lent_mut;
use crate::types::{VdmBody, VdmStatus};

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

/// How many points the file knows the stress of; 0 for null.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_stress_points(body: *mut VdmBody) -> u32 {
    // SAFETY: as the caller promises.
    unsafe { Body::of_mut(body) }.map_or(0, Body::stress_points)
}

/// Node and region of such a point, two numbers into `out`.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to two numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_stress_point(body: *mut VdmBody, point: u32, out: *mut u32) -> VdmStatus {
    // SAFETY: as the caller promises.
    let (body, out) = unsafe { (Body::of_mut(body), out.cast::<[u32; 2]>().as_mut()) };
    match (body.and_then(|body| body.stress_point(point)), out) {
        (Some(found), Some(out)) => {
            *out = found;
            VdmStatus::VDM_OK
        }
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Stress in Pa at such a point, six numbers into `out`: xx, yy, zz, xy, yz, zx.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to six numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_stress(body: *mut VdmBody, point: u32, out: *mut f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), out.cast::<[f64; 6]>().as_mut()) } {
        (Some(body), Some(out)) => body.stress(point, out),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Strain at such a point, in the same order, with the shear strains of the tensor.
///
/// # Safety
/// As for [`vdm_stress`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_strain(body: *mut VdmBody, point: u32, out: *mut f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    match unsafe { (Body::of_mut(body), out.cast::<[f64; 6]>().as_mut()) } {
        (Some(body), Some(out)) => body.strain(point, out),
        _ => VdmStatus::VDM_ARGUMENT,
    }
}

/// Von Mises' equivalent stress in Pa of six numbers of [`vdm_stress`]; not a number for null.
///
/// # Safety
/// `stress` is null or points to six numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_von_mises(stress: *const f64) -> f64 {
    // SAFETY: as the caller promises.
    let stress = unsafe { stress.cast::<[f64; 6]>().as_ref() };
    stress.map_or(f64::NAN, |stress| vademecum_eval::Tensor(*stress).von_mises())
}
