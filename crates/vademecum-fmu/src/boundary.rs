//! The boundary to C of both versions of the interface: pointers become references, a state becomes a
//! pointer, and nothing unwinds into the host.
#![allow(unsafe_code)]

use core::ffi::{CStr, c_char, c_int, c_void};
use core::ptr::NonNull;

use crate::instance::Instance;
use crate::logger::status;
use crate::memory::Chain;
use crate::mode::Modes;
use crate::refusal::{Refusal, Trouble};

/// Runs a call of the host. The bare library cannot panic, which its linking proves; in every other one a
/// panic would be a bug, and is answered as an error instead of unwinding into the host.
pub fn guard<T>(otherwise: T, call: impl FnOnce() -> T) -> T {
    #[cfg(feature = "bare")]
    {
        let _ = otherwise;
        call()
    }
    #[cfg(not(feature = "bare"))]
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(call)).unwrap_or(otherwise)
}

/// Runs a call on an instance.
///
/// # Safety
/// `instance` is null or from [`Instance::make`], was not freed, and is used by no other thread.
pub unsafe fn with(
    instance: *mut c_void,
    call: &'static str,
    allowed: Modes,
    action: impl FnOnce(&mut Instance) -> Result<(), Trouble>,
) -> c_int {
    // SAFETY: as the caller promises.
    let instance = unsafe { instance.cast::<Instance>().as_mut() };
    let Some(instance) = instance else { return status::ERROR };
    guard(status::ERROR, || instance.call(call, allowed, action))
}

/// Refuses a call for something that this unit does not do.
///
/// # Safety
/// As for [`with`].
pub unsafe fn refuse(instance: *mut c_void, call: &'static str, why: &'static str) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { with(instance, call, Modes::ALL, |_| Err(Refusal::Unsupported(why).into())) }
}

/// Values to read; none for null and no length.
///
/// # Safety
/// `data` is null or points to `length` values that stay unchanged for `'a`.
pub unsafe fn lent<'a, T>(data: *const T, length: usize) -> Result<&'a [T], Refusal> {
    if length == 0 {
        return Ok(&[]);
    }
    if data.is_null() || !data.is_aligned() || length > isize::MAX as usize / size_of::<T>() {
        return Err(Refusal::Null);
    }
    // SAFETY: not null, aligned, and as long as the caller promises.
    Ok(unsafe { core::slice::from_raw_parts(data, length) })
}

/// Values to write; none for null and no length.
///
/// # Safety
/// `data` is null or points to `length` values that nobody else uses for `'a`.
pub unsafe fn lent_mut<'a, T>(data: *mut T, length: usize) -> Result<&'a mut [T], Refusal> {
    if length == 0 {
        return Ok(&mut []);
    }
    if data.is_null() || !data.is_aligned() || length > isize::MAX as usize / size_of::<T>() {
        return Err(Refusal::Null);
    }
    // SAFETY: not null, aligned, and as long as the caller promises.
    Ok(unsafe { core::slice::from_raw_parts_mut(data, length) })
}

/// A text.
///
/// # Safety
/// `text` is null or points to a text with a zero at its end that stays unchanged for `'a`.
pub unsafe fn text<'a>(text: *const c_char) -> Option<&'a CStr> {
    // SAFETY: not null, and as the caller promises.
    (!text.is_null()).then(|| unsafe { CStr::from_ptr(text) })
}

/// Writes to where a host wants it.
///
/// # Safety
/// `place` is null or points to a `T`.
pub unsafe fn give<T>(place: *mut T, value: T) -> Result<(), Refusal> {
    // SAFETY: as the caller promises.
    let place = unsafe { place.as_mut() }.ok_or(Refusal::Null)?;
    *place = value;
    Ok(())
}

/// Content of a state behind a pointer.
///
/// # Safety
/// `state` is null or from [`get_state`] or [`deserialize`], and neither it nor its instance was freed.
unsafe fn content<'a>(state: *mut c_void) -> Result<&'a mut [u8], Refusal> {
    // SAFETY: as the caller promises.
    Ok(unsafe { Chain::content(NonNull::new(state).ok_or(Refusal::Null)?) })
}

/// A state of an instance, which frees it at its own end at the latest.
fn state_of(instance: &mut Instance, content: &[u8]) -> Result<*mut c_void, Refusal> {
    Ok(instance.states().add(content).ok_or(Refusal::Memory)?.as_ptr())
}

/// Saves an instance; a state that is there already is written over.
///
/// # Safety
/// `place` is null or points to null or to a state of this library that was not freed.
pub unsafe fn get_state(instance: &mut Instance, place: *mut *mut c_void) -> Result<(), Trouble> {
    // SAFETY: as the caller promises.
    let place = unsafe { place.as_mut() }.ok_or(Refusal::Null)?;
    let saved = instance.save()?;
    if place.is_null() {
        *place = state_of(instance, saved.bytes())?;
        return Ok(());
    }
    // SAFETY: as the caller promises.
    let there = unsafe { content(*place) }?;
    if there.len() != saved.bytes().len() {
        return Err(Refusal::Saved("the state that is to be written over has another length").into());
    }
    there.copy_from_slice(saved.bytes());
    Ok(())
}

/// Takes a state back.
///
/// # Safety
/// `state` is null or a state of this library that was not freed.
pub unsafe fn set_state(instance: &mut Instance, state: *mut c_void) -> Result<(), Trouble> {
    // SAFETY: as the caller promises.
    instance.restore(unsafe { content(state) }?)
}

/// Frees a state, and leaves null in its place; null is freed already.
///
/// # Safety
/// `place` is null or points to null or to a state of this library that was not freed.
pub unsafe fn free_state(place: *mut *mut c_void) -> Result<(), Trouble> {
    // SAFETY: as the caller promises.
    let place = unsafe { place.as_mut() }.ok_or(Refusal::Null)?;
    let Some(state) = NonNull::new(*place) else { return Ok(()) };
    // SAFETY: the state is what `state_of` has made.
    unsafe { Chain::free(state) };
    *place = core::ptr::null_mut();
    Ok(())
}

/// Copies a state to bytes.
///
/// # Safety
/// `state` is null or a state of this library that was not freed; `out` points to `length` bytes.
pub unsafe fn serialize(state: *mut c_void, out: *mut u8, length: usize) -> Result<(), Trouble> {
    // SAFETY: as the caller promises.
    let (saved, out) = unsafe { (content(state)?, lent_mut(out, length)?) };
    let Some(out) = out.get_mut(..saved.len()) else {
        return Err(Refusal::Saved("there is no room for it; ask for its size first").into());
    };
    out.iter_mut().zip(saved).for_each(|(out, &mut byte)| *out = byte);
    Ok(())
}

/// Makes a state of bytes, which are checked first.
///
/// # Safety
/// `bytes` points to `length` bytes; `place` is null or points to where the state is wanted.
pub unsafe fn deserialize(
    instance: &mut Instance,
    bytes: *const u8,
    length: usize,
    place: *mut *mut c_void,
) -> Result<(), Trouble> {
    // SAFETY: as the caller promises.
    let bytes = unsafe { lent(bytes, length) }?;
    instance.check_saved(bytes)?;
    // SAFETY: as the caller promises.
    unsafe { give(place, state_of(instance, bytes)?) }?;
    Ok(())
}
