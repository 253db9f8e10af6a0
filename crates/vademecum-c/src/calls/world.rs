//! Worlds: bodies that touch with friction, rigid members, and joints that turn far.

use core::ffi::c_char;

use vademecum_eval::{Pose, RigidMotion, WorldOptions};

use crate::handle::Lent;
use crate::message::Message;
use crate::refusal::{Answer, Refusal, needed};
use crate::slices::{given, lent, lent_mut, room};
use crate::types::{VdmMotion, VdmPlace, VdmStatus};
use crate::world::{Listed, WorldHandle, on_world};
use crate::world_types::{
    VdmJoint, VdmJointState, VdmMember, VdmTouch, VdmTouching, VdmWorld, VdmWorldOptions, VdmWorldReport,
};

/// A world without gravity, with room for 256 contacts.
///
/// # Safety
/// `options` is null or points to a `VdmWorldOptions`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_default_world_options(options: *mut VdmWorldOptions) {
    // SAFETY: as the caller promises.
    if let Some(options) = unsafe { options.as_mut() } {
        let WorldOptions { gravity, sweeps, contacts, near, recover, .. } = WorldOptions::default();
        *options = VdmWorldOptions {
            gravity,
            reach: 0.0,
            tolerance: 0.0,
            recover,
            sweeps: sweeps as u32,
            contacts: contacts as u32,
            near: near as u32,
        };
    }
}

/// The lists of a world; null is one of nothing.
///
/// # Safety
/// Each pointer is null or points to as many values as are said.
unsafe fn listed<'a>(
    (members, member_count): (*const VdmMember, usize),
    (pairs, pair_count): (*const VdmTouching, usize),
    (joints, joint_count): (*const VdmJoint, usize),
    options: *const VdmWorldOptions,
) -> Result<Listed<'a>, Refusal> {
    // SAFETY: as the caller promises.
    unsafe {
        Ok(Listed {
            members: needed(lent(members, member_count), "members")?,
            pairs: needed(lent(pairs, pair_count), "pairs")?,
            joints: needed(lent(joints, joint_count), "joints")?,
            options: options.as_ref(),
        })
    }
}

/// Bytes of memory, aligned to 16, to lend to a world of these members, pairs and joints. The bodies are in
/// one precision and of one time step. `options` null: the default ones.
///
/// `text`, of `capacity` bytes, receives what is wrong in words if it is not null.
///
/// # Safety
/// Each list points to as many values as are said, and what a member points to is as
/// [`vdm_world_bind`] asks for; `options` is null or points to a `VdmWorldOptions`, `bytes` to a number, and
/// `text` is null or points to `capacity` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_world_measure(
    members: *const VdmMember,
    member_count: usize,
    pairs: *const VdmTouching,
    pair_count: usize,
    joints: *const VdmJoint,
    joint_count: usize,
    options: *const VdmWorldOptions,
    bytes: *mut usize,
    text: *mut c_char,
    capacity: usize,
) -> VdmStatus {
    let run = || -> Answer {
        // SAFETY: as the caller promises; nothing outlives the call.
        unsafe {
            let lists = ((members, member_count), (pairs, pair_count), (joints, joint_count));
            let listed = listed(lists.0, lists.1, lists.2, options)?;
            *needed(bytes.as_mut(), "bytes")? = listed.bytes()?;
        }
        Ok(VdmStatus::VDM_OK)
    };
    // SAFETY: as the caller promises.
    run().unwrap_or_else(|refusal| Message::tell(&refusal, unsafe { lent_mut(text, capacity) }))
}

/// Makes a world in lent memory. Joints hold the members as they stand. `*world` is the handle, or null. The
/// lists are copied; bodies, and nodes and triangles of rigid members, are not.
///
/// # Safety
/// Each list points to as many values as are said. Each `body` of a member is null or a handle of
/// [`vdm_bind`](crate::vdm_bind); its memory, and the nodes and triangles of rigid members, stay where they
/// are for as long as the handle of the world is used, and so do `memory_bytes` bytes at `memory`, which
/// nobody else uses. Bodies of the world may be used between its calls, in the same thread. `options` is null
/// or points to a `VdmWorldOptions`, `world` points to a pointer, and `text` is null or points to `capacity`
/// bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_world_bind(
    members: *const VdmMember,
    member_count: usize,
    pairs: *const VdmTouching,
    pair_count: usize,
    joints: *const VdmJoint,
    joint_count: usize,
    options: *const VdmWorldOptions,
    memory: *mut u8,
    memory_bytes: usize,
    world: *mut *mut VdmWorld,
    text: *mut c_char,
    capacity: usize,
) -> VdmStatus {
    let run = || -> Answer {
        // SAFETY: as the caller promises; the memory outlives the handle.
        unsafe {
            let world = needed(world.as_mut(), "world")?;
            *world = core::ptr::null_mut();
            let lists = ((members, member_count), (pairs, pair_count), (joints, joint_count));
            let listed = listed(lists.0, lists.1, lists.2, options)?;
            *world = listed.bind(Lent::new(memory, memory_bytes)?)?;
        }
        Ok(VdmStatus::VDM_OK)
    };
    // SAFETY: as the caller promises.
    run().unwrap_or_else(|refusal| Message::tell(&refusal, unsafe { lent_mut(text, capacity) }))
}

/// The words of the last call of this world that was refused; never null.
///
/// # Safety
/// `world` is null or a handle of [`vdm_world_bind`]. The text lives until the next call of the world.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_world_message(world: *mut VdmWorld) -> *const c_char {
    // SAFETY: as the caller promises.
    unsafe { WorldHandle::of_mut(world) }.map_or(c"the handle is null".as_ptr(), |handle| handle.words())
}

/// Steps all members `steps` times, under the loads on them (`vdm_push` and its kin on bodies,
/// [`vdm_world_push`] on rigid members), gravity, contacts and joints. Loads act in the first step. A step
/// that is refused ends it.
///
/// # Safety
/// `world` is null or a handle of [`vdm_world_bind`], `report` points to a `VdmWorldReport`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_world_step(
    world: *mut VdmWorld,
    steps: u64,
    report: *mut VdmWorldReport,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe { on_world(world, |world| world.step(steps, needed(report.as_mut(), "report")?)) }
}

/// Kinetic and elastic energy of members, contacts and joints, in J.
///
/// # Safety
/// `world` is null or a handle of [`vdm_world_bind`], `energy` points to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_world_energy(world: *mut VdmWorld, energy: *mut f64) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on_world(world, |world| {
            *needed(energy.as_mut(), "energy")? = world.energy()?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// The place of the origin of the coordinates of a member in m, three numbers, and its rotation, a quaternion
/// of four, the real part first.
///
/// # Safety
/// `world` is null or a handle of [`vdm_world_bind`], `position` points to three numbers and `attitude` to
/// four.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_world_pose(
    world: *mut VdmWorld,
    member: u32,
    position: *mut f64,
    attitude: *mut f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on_world(world, |world| {
            let position = needed(room(position), "position")?;
            let attitude = needed(room(attitude), "attitude")?;
            let pose = world.pose(member as usize)?;
            (*position, *attitude) = (pose.position(), pose.attitude());
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Puts a body with supports elsewhere, or leads a rigid member without a mass there to the end of the coming
/// step.
///
/// # Safety
/// As for [`vdm_world_pose`]; the numbers are read.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_world_lead(
    world: *mut VdmWorld,
    member: u32,
    position: *const f64,
    attitude: *const f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on_world(world, |world| {
            let position = needed(given(position), "position")?;
            let attitude = needed(given(attitude), "attitude")?;
            world.lead(member as usize, Pose::new(position, attitude))
        })
    }
}

/// The motion of a rigid member. That of a body is read by `vdm_motion`.
///
/// # Safety
/// `world` is null or a handle of [`vdm_world_bind`], `motion` points to a `VdmMotion`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_world_motion(
    world: *mut VdmWorld,
    member: u32,
    motion: *mut VdmMotion,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on_world(world, |world| {
            *needed(motion.as_mut(), "motion")? = (*world.rigid(member as usize)?.motion()).into();
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Puts a rigid member elsewhere, or lets it move otherwise; call [`vdm_world_forget`] after it.
///
/// # Safety
/// As for [`vdm_world_motion`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_world_set_motion(
    world: *mut VdmWorld,
    member: u32,
    motion: *const VdmMotion,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on_world(world, |world| {
            let VdmMotion { position, attitude, momentum, angular_momentum } =
                *needed(motion.as_ref(), "motion")?;
            let motion = RigidMotion { position, attitude, momentum, angular_momentum };
            let said = "a number of the motion is not finite, or its attitude is zero";
            let set = world.rigid(member as usize)?.set_motion(motion);
            set.ok_or(Refusal::Words(VdmStatus::VDM_ARGUMENT, said))?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Pushes a rigid member at a point of space, in m, with a force, in N, in the coming step.
///
/// # Safety
/// `world` is null or a handle of [`vdm_world_bind`], `point` and `force` point to three numbers each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_world_push(
    world: *mut VdmWorld,
    member: u32,
    point: *const f64,
    force: *const f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on_world(world, |world| {
            let point: [f64; 3] = needed(given(point), "point")?;
            let force: [f64; 3] = needed(given(force), "force")?;
            if !point.iter().chain(&force).all(|x| x.is_finite()) {
                return Err(Refusal::Words(VdmStatus::VDM_LOAD, "a number of the force is not finite"));
            }
            world.rigid(member as usize)?.push(point, force);
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Position in m, or velocity in m/s, in space of a place of a body, deformed as it is; three numbers. The
/// velocity of a body with supports is that of its deformation.
///
/// # Safety
/// `world` is null or a handle of [`vdm_world_bind`], `place` points to a `VdmPlace`, `out` to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_world_in_space(
    world: *mut VdmWorld,
    member: u32,
    place: *const VdmPlace,
    field: i32,
    out: *mut f64,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on_world(world, |world| {
            let (place, out) = (needed(place.as_ref(), "place")?, needed(room(out), "out")?);
            *out = world.in_space(member as usize, place, super::read::field(field)?)?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Contacts of the last step: as many as there is room for are written, and `*count` is the number of all.
///
/// # Safety
/// `world` is null or a handle of [`vdm_world_bind`], `touches` is null or points to `capacity` contacts,
/// `count` points to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_world_touches(
    world: *mut VdmWorld,
    touches: *mut VdmTouch,
    capacity: usize,
    count: *mut usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on_world(world, |world| {
            let out = needed(lent_mut(touches, capacity), "touches")?;
            *needed(count.as_mut(), "count")? = world.touches(out);
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Force and moment of a joint in the last step.
///
/// # Safety
/// `world` is null or a handle of [`vdm_world_bind`], `state` points to a `VdmJointState`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_world_joint(
    world: *mut VdmWorld,
    joint: u32,
    state: *mut VdmJointState,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe {
        on_world(world, |world| {
            *needed(state.as_mut(), "state")? = world.joint(joint as usize)?;
            Ok(VdmStatus::VDM_OK)
        })
    }
}

/// Breaks a joint: it holds nothing any more.
///
/// # Safety
/// `world` is null or a handle of [`vdm_world_bind`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_world_break(world: *mut VdmWorld, joint: u32) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe { on_world(world, |world| world.break_joint(joint as usize)) }
}

/// Forgets the contacts of the last step: after a member was put elsewhere.
///
/// # Safety
/// `world` is null or a handle of [`vdm_world_bind`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_world_forget(world: *mut VdmWorld) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe { on_world(world, |world| Ok(world.forget())) }
}

/// Numbers of a saved world; 0 for null.
///
/// # Safety
/// `world` is null or a handle of [`vdm_world_bind`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_world_saved_length(world: *mut VdmWorld) -> usize {
    let mut length = 0;
    // SAFETY: as the caller promises.
    unsafe {
        on_world(world, |world| {
            length = world.saved_len();
            Ok(VdmStatus::VDM_OK)
        });
    }
    length
}

/// Writes contacts, joints, placements of bodies with supports, and motions of rigid members. With the states
/// of the bodies (`vdm_save`) the world goes on from there bit by bit.
///
/// # Safety
/// `world` is null or a handle of [`vdm_world_bind`], `saved` points to `length` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_world_save(world: *mut VdmWorld, saved: *mut f64, length: usize) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe { on_world(world, |world| world.save_into(needed(lent_mut(saved, length), "saved")?)) }
}

/// Takes back what [`vdm_world_save`] of a world of the same members, pairs, joints and options wrote.
/// Nothing has changed where it is refused.
///
/// # Safety
/// As for [`vdm_world_save`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vdm_world_restore(
    world: *mut VdmWorld,
    saved: *const f64,
    length: usize,
) -> VdmStatus {
    // SAFETY: as the caller promises.
    unsafe { on_world(world, |world| world.restore(needed(lent(saved, length), "saved")?)) }
}
