//! Facts about a file and a body, and live parameters.

use core::ffi::c_char;

use vademecum_eval::Structure;
use vademecum_eval::format::{File, MAX_LIVE, MAX_PARAMETERS, Parameter, SectionKind};

use crate::handle::{ask, on, on_handle};
use crate::message::{Message, copy};
use crate::refusal::{Refusal, needed};
use crate::slices::{borrowed, lent, lent_mut, text};
use crate::types::{VdmBody, VdmCarried, VdmCost, VdmNamed, VdmParameter, VdmStatus, VdmStructure};

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
    let verified = needed(file, "file").and_then(|bytes| Ok(File::parse(bytes)?.verify_all()?));
    verified.map_or_else(|refusal| Message::tell(&refusal, text), |()| VdmStatus::VDM_OK)
}

/// The `VdmStructure` that the body took; `VDM_AUTO` for null.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_structure(body: *const VdmBody) -> i32 {
    // SAFETY: as the caller promises.
    let structure = unsafe {
        ask(body, VdmStructure::VDM_AUTO, |body| match body.structure() {
            Structure::Diagonal => VdmStructure::VDM_DIAGONAL,
            Structure::Block => VdmStructure::VDM_BLOCK,
            Structure::Exact => VdmStructure::VDM_EXACT,
            Structure::Strain => VdmStructure::VDM_STRAIN,
        })
    };
    structure as i32
}

/// Cost of a step of the body.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `cost` points to a `VdmCost`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_cost(body: *mut VdmBody, cost: *mut VdmCost) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (out, cost) = (needed(cost.as_mut(), "cost")?, either!(body, body => body.scene().cost()));
            *out = VdmCost {
                terms: cost.terms,
                bind_bytes: cost.bind_bytes,
                step_operations: cost.step_operations,
                step_bytes: cost.step_bytes,
                contact_rows: cost.contact_rows,
                contact_bytes: cost.contact_bytes,
                pattern_bytes: cost.pattern_bytes,
                probe_bytes: cost.probe_bytes,
                node_bytes: cost.node_bytes,
                surface_bytes: cost.surface_bytes,
                body_bytes: cost.body_bytes,
            };
            Ok(VdmStatus::VDM_OK)
        })
    }
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
    unsafe {
        on_handle(body, |handle| {
            let (out, index) = (needed(out.as_mut(), "out")?, parameter as usize);
            let valued = handle.file.parameters().nth(index).zip(handle.value(index));
            let said = "the file has no such live parameter";
            let (known, value) = valued.ok_or(Refusal::Words(VdmStatus::VDM_ARGUMENT, said))?;
            let (lower, upper, nominal, logarithmic) =
                (known.lower, known.upper, known.nominal, u32::from(known.log));
            *out = VdmParameter { lower, upper, nominal, value, logarithmic };
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Most parameters that a call sets.
const MOST: usize = if cfg!(feature = "parametric") { MAX_LIVE } else { MAX_PARAMETERS };

/// Sets live parameters, `count` of them, by their numbers in `ids`; the others stay. Velocities stay what
/// they are, as far as the modes at the new values hold them. Loads become stale: clear them and add them
/// again.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `ids` and `values` point to `count` numbers
/// each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_set_parameters(
    body: *mut VdmBody,
    ids: *const u32,
    values: *const f64,
    count: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on_handle(body, |handle| {
            let (ids, values) = (needed(lent(ids, count), "ids")?, needed(lent(values, count), "values")?);
            let mut settings = [(0, 0.0); MOST];
            let said = "more values than a file can have live parameters";
            let settings = settings.get_mut(..count).ok_or(Refusal::Words(VdmStatus::VDM_BIND, said))?;
            for (setting, (&id, &value)) in settings.iter_mut().zip(ids.iter().zip(values)) {
                *setting = (id as usize, value);
            }
            handle.set_parameters(settings)?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Energies of the last change of live parameters of a file with live regions; others do not have them.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `out` points to a `VdmCarried`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_carried(body: *mut VdmBody, out: *mut VdmCarried) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on_handle(body, |handle| {
            let said = "the file has no live regions whose change would be accounted for";
            let out = needed(out.as_mut(), "out")?;
            *out = handle.carried().ok_or(Refusal::Words(VdmStatus::VDM_OUTPUT, said))?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Copies a name of the file into `out`, which has `capacity` bytes, with a zero at its end; a longer name is
/// cut.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `out` points to `capacity` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_name(
    body: *mut VdmBody,
    kind: i32,
    index: u32,
    out: *mut c_char,
    capacity: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on_handle(body, |handle| {
            let out = needed(lent_mut(out, capacity), "out")?;
            let found = names(&handle.file, kind)?.nth(index as usize);
            copy(found.ok_or(NO_NAME)?.as_bytes(), out);
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// The number of what has this name, counted from 0; -1 if nothing has.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind); `name` is null or points to a text with a
/// zero at its end.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_find(body: *mut VdmBody, kind: i32, name: *const c_char) -> i32 {
    let mut place = -1;
    // SAFETY: as the caller promises.
    unsafe {
        on_handle(body, |handle| {
            let name = needed(text(name), "name")?;
            let found = names(&handle.file, kind)?.position(|found| found == name);
            place = found.and_then(|place| i32::try_from(place).ok()).ok_or(NO_NAME)?;
            Ok(VdmStatus::VDM_OK)
        });
    }
    place
}

/// The refusal of a name, or of its number.
const NO_NAME: Refusal = Refusal::Words(VdmStatus::VDM_ARGUMENT, "the file has no such name");

/// Names of a kind, in order.
fn names(
    file: &File<'static>,
    kind: i32,
) -> Result<Names<impl Iterator<Item = Parameter<'static>> + use<>>, Refusal> {
    let section = |kind| {
        let text = file.section(kind).and_then(|section| section.text().ok()).unwrap_or("");
        Ok(Names::Lines(text.lines()))
    };
    match kind {
        k if k == VdmNamed::VDM_PROBES as i32 => section(SectionKind::ProbeNames),
        k if k == VdmNamed::VDM_PATTERNS as i32 => section(SectionKind::PatternNames),
        k if k == VdmNamed::VDM_SUPPORTS as i32 => section(SectionKind::SupportNames),
        k if k == VdmNamed::VDM_PORTS as i32 => section(SectionKind::PortNames),
        k if k == VdmNamed::VDM_PARAMETERS as i32 => Ok(Names::Parameters(file.parameters())),
        _ => Err(Refusal::Words(VdmStatus::VDM_ARGUMENT, "no such kind of name: see VdmNamed")),
    }
}

/// Names as the file has them.
enum Names<P> {
    Lines(core::str::Lines<'static>),
    Parameters(P),
}

impl<P: Iterator<Item = Parameter<'static>>> Iterator for Names<P> {
    type Item = &'static str;

    fn next(&mut self) -> Option<&'static str> {
        match self {
            Self::Lines(lines) => lines.next(),
            Self::Parameters(parameters) => parameters.next().map(|parameter| parameter.name),
        }
    }
}
