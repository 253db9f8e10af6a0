//! Probes, places, whole fields, stress, reactions, energy; the table of quantities; the surface at rest.

use core::ffi::c_char;

use vademecum_eval::format::SectionKind;
use vademecum_eval::{AnyBody, EmbeddedSurface, Field, OutputError, Quantity};

use crate::handle::{Body, ask, on};
use crate::message::copy;
use crate::refusal::{Answer, Refusal, needed};
use crate::slices::{lent, lent_mut, room, text};
use crate::types::{VdmBody, VdmField, VdmPlace, VdmQuantity, VdmStatus};

/// The field of a number.
pub fn field(number: i32) -> Result<Field, Refusal> {
    match number {
        f if f == VdmField::VDM_DISPLACEMENT as i32 => Ok(Field::Displacement),
        f if f == VdmField::VDM_VELOCITY as i32 => Ok(Field::Velocity),
        _ => {
            let said = "no such field: VDM_DISPLACEMENT or VDM_VELOCITY";
            Err(Refusal::Words(VdmStatus::VDM_ARGUMENT, said))
        }
    }
}

/// The status of a written field.
fn wrote(done: Result<(), OutputError>) -> Answer {
    done.map(|()| VdmStatus::VDM_OK).map_err(Refusal::from)
}

/// The quantity of a number.
fn quantity(number: u32) -> Result<Quantity, Refusal> {
    let said = "there is no quantity of this number; vdm_find_quantity gives it for a name";
    Quantity::from_number(number).ok_or(Refusal::Words(VdmStatus::VDM_ARGUMENT, said))
}

/// A row of the table of what can be read of a body. Numbers count from 0 without a gap and stay from version
/// to version; new ones come last. `VDM_ARGUMENT` past the last one.
///
/// # Safety
/// `out` is null or points to a `VdmQuantity`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_quantity(quantity: u32, out: *mut VdmQuantity) -> VdmStatus {
    // SAFETY: as the caller promises.
    let (Some(found), Some(out)) = (Quantity::from_number(quantity), unsafe { out.as_mut() }) else {
        return VdmStatus::VDM_ARGUMENT;
    };
    *out = VdmQuantity { scalar: u32::from(found.is_scalar()), ..VdmQuantity::default() };
    copy(found.name().as_bytes(), &mut out.name);
    copy(found.unit(Field::Displacement).unwrap_or("").as_bytes(), &mut out.unit);
    copy(found.unit(Field::Velocity).unwrap_or("").as_bytes(), &mut out.rate_unit);
    VdmStatus::VDM_OK
}

/// The number of the quantity that has this name; -1 if none has.
///
/// # Safety
/// `name` is null or points to a text with a zero at its end.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_find_quantity(name: *const c_char) -> i32 {
    // SAFETY: as the caller promises.
    let name = unsafe { text(name) };
    name.and_then(Quantity::find).map_or(-1, |found| found.number() as i32)
}

/// Number of instances of a quantity in the body, counted from 0; 0 where it does not have it, and for null.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_count(body: *const VdmBody, quantity: u32) -> usize {
    let count = |body: &Body| Quantity::from_number(quantity).map_or(0, |found| body.count(found));
    // SAFETY: as the caller promises.
    unsafe { ask(body, 0, count) }
}

/// Numbers of each of a quantity; 0 for null.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_length(body: *const VdmBody, quantity: u32) -> usize {
    let length = |body: &Body| Quantity::from_number(quantity).map_or(0, |found| body.length(found));
    // SAFETY: as the caller promises.
    unsafe { ask(body, 0, length) }
}

/// Reads a quantity: [`vdm_length`] numbers. `field` is `VDM_DISPLACEMENT` of all that has no velocity. A
/// point is read at a place, by [`vdm_point`].
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_read(
    body: *mut VdmBody,
    quantity: u32,
    index: usize,
    field: i32,
    out: *mut f64,
    numbers: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (asked, out) = (self::quantity(quantity)?, needed(lent_mut(out, numbers), "out")?);
            body.read(asked, index, self::field(field)?, out)?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// The value of a probe.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `value` points to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_probe(body: *mut VdmBody, probe: u32, field: i32, value: *mut f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (value, field) = (needed(value.as_mut(), "value")?, self::field(field)?);
            *value = either!(body, body => body.probe(probe as usize, field))?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Displacement or velocity of a place; three numbers.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`, `out` to
/// three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_point(
    body: *mut VdmBody,
    place: *const VdmPlace,
    field: i32,
    out: *mut f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (place, out) = (needed(place.as_ref(), "place")?, needed(room(out), "out")?);
            *out = body.point(place, self::field(field)?)?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Displacement or velocity of a node; three numbers.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_node(body: *mut VdmBody, node: u32, field: i32, out: *mut f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (out, field) = (needed(room(out), "out")?, self::field(field)?);
            *out = either!(body, body => body.node(node as usize, field))?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Displacement or velocity of all nodes of the surface, three `float`s a node: as a vertex array wants them.
/// For a body in single precision.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers, three a
/// node.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_surface_f32(
    body: *mut VdmBody,
    field: i32,
    out: *mut f32,
    numbers: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (out, field) = (needed(lent_mut(out, numbers), "out")?, self::field(field)?);
            single!(body, surface_into(field, out))
        })
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
    unsafe {
        on(body, |body| {
            let (out, field) = (needed(lent_mut(out, numbers), "out")?, self::field(field)?);
            double!(body, surface_into(field, out))
        })
    }
}

/// Displacement or velocity of all nodes, three `float`s a node: as a vertex array wants them. For a body in
/// single precision.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers, three a
/// node.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_whole_f32(
    body: *mut VdmBody,
    field: i32,
    out: *mut f32,
    numbers: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (out, field) = (needed(lent_mut(out, numbers), "out")?, self::field(field)?);
            single!(body, body_into(field, out))
        })
    }
}

/// The same for a body in double precision.
///
/// # Safety
/// As for [`vdm_whole_f32`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_whole_f64(
    body: *mut VdmBody,
    field: i32,
    out: *mut f64,
    numbers: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (out, field) = (needed(lent_mut(out, numbers), "out")?, self::field(field)?);
            double!(body, body_into(field, out))
        })
    }
}

/// Displacement or velocity of all nodes of the surface, with the static answer of [`vdm_solve_statics`],
/// three `float`s a node: as a vertex array wants them. For a body in single precision.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers, three a
/// node.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_surface_with_statics_f32(
    body: *mut VdmBody,
    field: i32,
    out: *mut f32,
    numbers: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (out, field) = (needed(lent_mut(out, numbers), "out")?, self::field(field)?);
            single!(body, surface_with_statics(field, out))
        })
    }
}

/// The same for a body in double precision.
///
/// # Safety
/// As for [`vdm_surface_with_statics_f32`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_surface_with_statics_f64(
    body: *mut VdmBody,
    field: i32,
    out: *mut f64,
    numbers: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (out, field) = (needed(lent_mut(out, numbers), "out")?, self::field(field)?);
            double!(body, surface_with_statics(field, out))
        })
    }
}

/// Displacement or velocity of all nodes, with the static answer of [`vdm_solve_statics`], three `float`s a
/// node: as a vertex array wants them. For a body in single precision.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers, three a
/// node.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_whole_with_statics_f32(
    body: *mut VdmBody,
    field: i32,
    out: *mut f32,
    numbers: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (out, field) = (needed(lent_mut(out, numbers), "out")?, self::field(field)?);
            single!(body, body_with_statics(field, out))
        })
    }
}

/// The same for a body in double precision.
///
/// # Safety
/// As for [`vdm_whole_with_statics_f32`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_whole_with_statics_f64(
    body: *mut VdmBody,
    field: i32,
    out: *mut f64,
    numbers: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (out, field) = (needed(lent_mut(out, numbers), "out")?, self::field(field)?);
            double!(body, body_with_statics(field, out))
        })
    }
}

/// Solves for the static answer of the whole body to the forces of the last step, of a body bound with
/// `VdmOptions.static_field`; worth it only when they have changed.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_solve_statics(body: *mut VdmBody) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            if !body.has_static_field() {
                return Err(Refusal::Words(VdmStatus::VDM_OUTPUT, NO_STATICS));
            }
            body.solve_static_field()?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Words for a body without the static answer of the whole body.
const NO_STATICS: &str = "there is no static answer of the whole body: bind with VdmOptions.static_field = 1 a file \
                          built with `static_fields`";

/// Kinetic plus elastic energy, in J.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `value` points to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_energy(body: *mut VdmBody, value: *mut f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            *needed(value.as_mut(), "value")? = either!(body, body => body.energy())?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Force in N and moment in N m that a support exerts on the body, six numbers into `out`.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to six numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_reaction(body: *mut VdmBody, support: u32, out: *mut f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let out: &mut [f64; 6] = needed(room(out), "out")?;
            *out = either!(body, body => body.scene().reaction(body.state(), support as usize))?.total();
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Number of points that the file knows the stress of; 0 for null.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_stress_points(body: *const VdmBody) -> u32 {
    // SAFETY: as the caller promises.
    unsafe { ask(body, 0, |body| either!(body, body => body.scene().n_stress_points()) as u32) }
}

/// Node and region of such a point, two numbers into `out`.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to two numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_stress_point(body: *mut VdmBody, point: u32, out: *mut u32) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (out, index) = (needed(room(out), "out")?, point as usize);
            let count = either!(body, body => body.scene().n_stress_points());
            let found = body.stress_point(index).ok_or(OutputError::OutOfRange { index, count })?;
            *out = [found.node, found.region];
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Stress in Pa at such a point, six numbers into `out`: xx, yy, zz, xy, yz, zx.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to six numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_stress(body: *mut VdmBody, point: u32, out: *mut f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let out: &mut [f64; 6] = needed(room(out), "out")?;
            *out = either!(body, body => body.scene().stress(body.state(), point as usize))?.0;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Strain at such a point, in the same order, with the shear strains of the tensor.
///
/// # Safety
/// As for [`vdm_stress`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_strain(body: *mut VdmBody, point: u32, out: *mut f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let out: &mut [f64; 6] = needed(room(out), "out")?;
            *out = either!(body, body => body.scene().strain(body.state(), point as usize))?.0;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Von Mises' equivalent stress in Pa at such a point.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `value` points to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_von_mises(body: *mut VdmBody, point: u32, value: *mut f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let value = needed(value.as_mut(), "value")?;
            *value = either!(body, body => body.scene().stress(body.state(), point as usize))?.von_mises();
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// The largest energy, in J, that an unloaded body has when it is put at rest.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `value` points to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_energy_at_rest(body: *mut VdmBody, value: *mut f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            *needed(value.as_mut(), "value")? = either!(body, body => body.scene().energy_at_rest());
            Ok(VdmStatus::VDM_OK)
        })
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
    unsafe {
        on(body, |body| {
            let out = needed(lent_mut(out, numbers), "out")?;
            either!(body, body => body.scene().increment_into(out))?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Positions of the nodes of the surface at rest, in m; three numbers a node.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_positions(body: *mut VdmBody, out: *mut f64, numbers: usize) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let out = needed(lent_mut(out, numbers), "out")?;
            let (kind, needed) =
                (SectionKind::NodeCoordinates, 3 * body.file().metadata().n_surface_nodes as usize);
            let known = body.file().section(kind).and_then(|section| section.numbers().ok());
            let all = known.ok_or(OutputError::Missing { kind })?;
            length(out.len(), needed)?;
            out.iter_mut().enumerate().for_each(|(k, out)| *out = all.get(k).unwrap_or(0.0));
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// The triangles of the surface, three nodes each, counter-clockwise from outside.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_triangles(body: *mut VdmBody, out: *mut u32, numbers: usize) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (out, kind) = (needed(lent_mut(out, numbers), "out")?, SectionKind::Triangles);
            let all = body.file().indices(kind).ok().flatten().ok_or(OutputError::Missing { kind })?;
            length(out.len(), all.len())?;
            out.iter_mut().zip(all).for_each(|(out, &node)| *out = u32::from_le_bytes(node));
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Vertices and triangles of the embedded surface, which is drawn in place of that of the mesh; zeros where a
/// file has none.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `vertices` and `triangles` point to a number
/// each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_embedded_sizes(
    body: *mut VdmBody,
    vertices: *mut u32,
    triangles: *mut u32,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let vertices = needed(vertices.as_mut(), "vertices")?;
            let triangles = needed(triangles.as_mut(), "triangles")?;
            let found = EmbeddedSurface::new(body.file())?;
            let sizes = found.map(|surface| [surface.n_vertices(), surface.n_triangles()]);
            [*vertices, *triangles] = sizes.unwrap_or_default().map(|count| count as u32);
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// The triangles of the embedded surface, three vertices each, counter-clockwise from outside.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `numbers` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_embedded_triangles(
    body: *mut VdmBody,
    out: *mut u32,
    numbers: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (out, surface) = (needed(lent_mut(out, numbers), "out")?, embedded(body)?);
            length(out.len(), 3 * surface.n_triangles())?;
            out.iter_mut().zip(surface.triangles().flatten()).for_each(|(out, vertex)| *out = vertex);
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Positions or displacements at the vertices of the embedded surface, three numbers each, from those at the
/// nodes of the surface of the mesh.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `at_nodes` points to `node_numbers` numbers,
/// `out` to `numbers` numbers; they do not overlap.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_embedded_interpolate(
    body: *mut VdmBody,
    at_nodes: *const f64,
    node_numbers: usize,
    out: *mut f64,
    numbers: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let at_nodes = needed(lent(at_nodes, node_numbers), "at_nodes")?;
            let out = needed(lent_mut(out, numbers), "out")?;
            embedded(body)?.interpolate_into(at_nodes, out)?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// The embedded surface of a file that has one.
fn embedded(body: &Body) -> Result<EmbeddedSurface<'_>, OutputError> {
    EmbeddedSurface::new(body.file())?.ok_or(OutputError::Missing { kind: SectionKind::EmbeddedTriangles })
}

/// Refuses numbers that are too few or too many.
const fn length(found: usize, needed: usize) -> Result<(), OutputError> {
    if found == needed { Ok(()) } else { Err(OutputError::Length { found, needed }) }
}
