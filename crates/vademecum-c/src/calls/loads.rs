//! Places and loads.

use vademecum_eval::format::scheme::MAX_STAGES;
use vademecum_eval::{BaseMotion, LoadError, Place};

use crate::handle::on;
use crate::refusal::needed;
use crate::slices::{given, room};
use crate::types::{VdmBody, VdmPlace, VdmStatus};

/// The place of the loadable surface at rest that is nearest to a point. A search over all triangles: `O(n)`.
/// A point further away than the body is large (`VDM_LOAD`) is most likely in another unit.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `point` points to three numbers, `place` to a
/// `VdmPlace`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_locate(
    body: *mut VdmBody,
    point: *const f64,
    place: *mut VdmPlace,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (point, place) = (needed(given(point), "point")?, needed(place.as_mut(), "place")?);
            let found = body.locate(point)?;
            *place = VdmPlace::new(&found.place, found.position, found.distance);
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// The place that is a loadable node; no search.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_at_node(body: *mut VdmBody, node: u32, place: *mut VdmPlace) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (at, limit) = (needed(place.as_mut(), "place")?, body.file().metadata().n_load_nodes);
            if node >= limit {
                return Err(LoadError::NotLoadable { node, limit }.into());
            }
            let place = Place::node(node);
            *at = VdmPlace::new(&place, body.position(&place).unwrap_or_default(), 0.0);
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Takes all loads away.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_clear(body: *mut VdmBody) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            body.clear();
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Adds a force in N at a place. It acts in every step until [`vdm_clear`]; on a body that flies it is a
/// force of space, for one step.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`, `force` to
/// three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_push(
    body: *mut VdmBody,
    place: *const VdmPlace,
    force: *const f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            body.push(needed(place.as_ref(), "place")?, needed(given(force), "force")?)?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Adds a force in N that changes within a step: `force` times the four `amplitudes` at [`vdm_instants`]. A
/// body that flies takes the mean of start and end.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`, `force` to
/// three numbers, and `amplitudes` to four.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_push_staged(
    body: *mut VdmBody,
    place: *const VdmPlace,
    force: *const f64,
    amplitudes: *const f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (force, amplitudes) =
                (needed(given(force), "force")?, needed(given(amplitudes), "amplitudes")?);
            body.push_staged(needed(place.as_ref(), "place")?, force, &amplitudes)?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Adds a force in N that goes linearly from `start` to `end` over one step.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `place` points to a `VdmPlace`, `start` and
/// `end` to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_push_ramp(
    body: *mut VdmBody,
    place: *const VdmPlace,
    start: *const f64,
    end: *const f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let (start, end) = (needed(given(start), "start")?, needed(given(end), "end")?);
            body.push_ramp(needed(place.as_ref(), "place")?, start, end)?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Adds a load pattern, times an amplitude. It acts in every step until [`vdm_clear`]; on a body that flies
/// it turns with the body and acts for one step.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_push_pattern(body: *mut VdmBody, pattern: u32, amplitude: f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            body.push_pattern(pattern as usize, amplitude)?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Adds a load pattern that changes within a step: times the four `amplitudes` at [`vdm_instants`].
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `amplitudes` points to four numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_push_pattern_staged(
    body: *mut VdmBody,
    pattern: u32,
    amplitudes: *const f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            body.push_pattern_staged(pattern as usize, &needed(given(amplitudes), "amplitudes")?)?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Adds a load pattern whose amplitude goes linearly from `start` to `end` over one step.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_push_pattern_ramp(
    body: *mut VdmBody,
    pattern: u32,
    start: f64,
    end: f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let amplitudes = body.instants().map(|t| (1.0 - t) * start + t * end);
            body.push_pattern_staged(pattern as usize, &amplitudes)?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Adds the inertia of a base that moves so, in its own axes: acceleration in m/s², angular velocity in rad/s
/// and angular acceleration in rad/s², three numbers each. It acts in every step until [`vdm_clear`].
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), each pointer points to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_push_base(
    body: *mut VdmBody,
    acceleration: *const f64,
    angular_velocity: *const f64,
    angular_acceleration: *const f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let motion = BaseMotion {
                acceleration: needed(given(acceleration), "acceleration")?,
                angular_velocity: needed(given(angular_velocity), "angular_velocity")?,
                angular_acceleration: needed(given(angular_acceleration), "angular_acceleration")?,
            };
            body.push_base(&motion)?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Adds the centrifugal forces of a body without supports that its host moves (`VdmOptions.flight` = 0), for
/// a step in which its angular velocity in rad/s, in its own axes, goes from `before` to `after`.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `before` and `after` point to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_push_spin(
    body: *mut VdmBody,
    before: *const f64,
    after: *const f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            body.push_spin(needed(given(before), "before")?, needed(given(after), "after")?)?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Pulls a body that flies at its centre with a force in N, in the directions of space, for one step: gravity
/// is the mass times its acceleration.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind), `force` points to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_pull(body: *mut VdmBody, force: *const f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            let force = needed(given(force), "force")?;
            super::flight::flies(body)?;
            body.pull(force)?;
            Ok(VdmStatus::VDM_OK)
        })
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
    unsafe {
        on(body, |body| {
            let out: &mut [f64; 1 + MAX_STAGES] = needed(room(instants), "instants")?;
            *out = body.instants();
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Keeps the loads as they are, for a body bound with `VdmOptions.keep_loads`: those that stay, in a loop
/// that adds others to them in each step.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_keep_loads(body: *mut VdmBody) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            body.keep_loads()?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// The loads become those that were kept.
///
/// # Safety
/// `body` is null or a handle of [`vdm_bind`](crate::vdm_bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_recall_loads(body: *mut VdmBody) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on(body, |body| {
            body.recall_loads()?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}
