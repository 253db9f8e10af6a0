//! Slices over what C points to.

use core::ffi::{CStr, c_char};

/// Bytes of a file, which live as long as the caller says; `None` for null.
///
/// # Safety
/// `data` is null or points to `length` bytes that stay unchanged for `'a`.
pub unsafe fn borrowed<'a>(data: *const u8, length: usize) -> Option<&'a [u8]> {
    // SAFETY: as the caller promises.
    unsafe { lent(data, length) }.filter(|_| !data.is_null())
}

/// Values to read; `None` for null, unless there are none of them.
///
/// # Safety
/// `data` is null or points to `length` values that stay unchanged for `'a`.
pub unsafe fn lent<'a, T>(data: *const T, length: usize) -> Option<&'a [T]> {
    if length == 0 {
        return Some(&[]);
    }
    if data.is_null() || !data.is_aligned() || length > isize::MAX as usize / size_of::<T>() {
        return None;
    }
    // SAFETY: not null, aligned, and as long as the caller promises.
    Some(unsafe { core::slice::from_raw_parts(data, length) })
}

/// Values to write; `None` for null, unless there are none of them.
///
/// # Safety
/// `data` is null or points to `length` values that nobody else uses during `'a`.
pub unsafe fn lent_mut<'a, T>(data: *mut T, length: usize) -> Option<&'a mut [T]> {
    if length == 0 {
        return Some(&mut []);
    }
    if data.is_null() || !data.is_aligned() || length > isize::MAX as usize / size_of::<T>() {
        return None;
    }
    // SAFETY: not null, aligned, and as long as the caller promises.
    Some(unsafe { core::slice::from_raw_parts_mut(data, length) })
}

/// So many numbers.
///
/// # Safety
/// `data` is null or points to `N` numbers.
pub unsafe fn given<const N: usize>(data: *const f64) -> Option<[f64; N]> {
    // SAFETY: as the caller promises.
    unsafe { lent(data, N) }?.try_into().ok()
}

/// Room for so many values.
///
/// # Safety
/// `data` is null or points to `N` values that nobody else uses during `'a`.
pub unsafe fn room<'a, T, const N: usize>(data: *mut T) -> Option<&'a mut [T; N]> {
    // SAFETY: as the caller promises.
    unsafe { lent_mut(data, N) }?.try_into().ok()
}

/// A text of C.
///
/// # Safety
/// `text` is null or points to a text with a zero at its end.
pub unsafe fn text<'a>(text: *const c_char) -> Option<&'a str> {
    if text.is_null() {
        return None;
    }
    // SAFETY: as the caller promises.
    unsafe { CStr::from_ptr(text) }.to_str().ok()
}
