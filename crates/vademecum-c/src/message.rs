//! Messages of refusals, without heap.

use core::ffi::{CStr, c_char};
use core::fmt::{self, Write};

use crate::refusal::Refusal;
use crate::types::VdmStatus;

/// Bytes of a message, its zero included.
const LENGTH: usize = 240;

/// The words of one refusal, with a zero at their end; longer ones are cut.
#[derive(Clone, Copy, Debug)]
pub struct Message {
    bytes: [u8; LENGTH],
    used: usize,
}

impl Default for Message {
    fn default() -> Self {
        Self { bytes: [0; LENGTH], used: 0 }
    }
}

impl Write for Message {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for &byte in text.as_bytes() {
            // The last byte stays zero.
            if self.used + 1 == LENGTH {
                return Err(fmt::Error);
            }
            self.bytes[self.used] = byte;
            self.used += 1;
        }
        Ok(())
    }
}

impl Message {
    /// Keeps what was wrong.
    pub fn note(&mut self, what: &Refusal) -> VdmStatus {
        *self = Self::default();
        // A message that is too long is cut.
        #[cfg(feature = "words")]
        let _ = write!(self, "{what}");
        #[cfg(not(feature = "words"))]
        let _ = self.write_str(status(what.status() as i32).to_str().unwrap_or(""));
        what.status()
    }

    /// The words of a refusal, handed out at once.
    pub fn tell(what: &Refusal, text: Option<&mut [c_char]>) -> VdmStatus {
        let mut message = Self::default();
        let status = message.note(what);
        copy(message.bytes.get(..message.used).unwrap_or_default(), text.unwrap_or_default());
        status
    }

    /// The words, with a zero at their end.
    pub fn as_ptr(&self) -> *const c_char {
        self.bytes.as_ptr().cast()
    }
}

/// Copies a text, as far as there is room, and ends it with a zero.
pub fn copy(text: &[u8], out: &mut [c_char]) {
    let Some(room) = out.len().checked_sub(1) else { return };
    let used = text.len().min(room);
    for (out, &byte) in out.iter_mut().zip(&text[..used]) {
        *out = byte as c_char;
    }
    out[used] = 0;
}

/// The meaning of a status.
pub const fn status(status: i32) -> &'static CStr {
    match status {
        0 => c"done",
        1 => c"done; the body is at rest",
        2 => c"done; the state was carried over to other parameters or another precision",
        -1 => c"a null pointer, or an index or a name that the file does not have",
        -2 => c"lent memory is too short or not aligned to 16 bytes",
        -3 => c"no vademecum file that can be stepped",
        -4 => c"the file does not allow these options or this value",
        -5 => c"the load is refused",
        -6 => c"the step is refused; the state is unchanged",
        -7 => c"the file does not hold what is asked for",
        -8 => c"the bytes are no saved state of this body",
        -9 => c"the world cannot have this member, pair or joint",
        _ => c"no status of this library",
    }
}
