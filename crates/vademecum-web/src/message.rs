//! Sentences for the page, in a fixed buffer.

use core::fmt::{self, Write};

/// Most bytes of a message; what is longer is cut.
const CAPACITY: usize = 512;

/// The last refusal in words.
#[derive(Debug)]
pub struct Message {
    bytes: [u8; CAPACITY],
    length: usize,
}

impl Message {
    /// No message.
    #[must_use]
    pub const fn new() -> Self {
        Self { bytes: [0; CAPACITY], length: 0 }
    }

    /// Replaces the message by what `error` and its causes say.
    pub fn say(&mut self, error: &dyn core::error::Error) {
        self.length = 0;
        // A full buffer is the only way to fail, and a cut sentence is better than none.
        let _ = write!(self, "{error}");
        let mut source = error.source();
        while let Some(cause) = source {
            let _ = write!(self, ": {cause}");
            source = cause.source();
        }
    }

    /// UTF-8 up to a cut at the end of the buffer.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }
}

impl Default for Message {
    fn default() -> Self {
        Self::new()
    }
}

impl Write for Message {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let free = self.bytes.get_mut(self.length..).unwrap_or_default();
        let taken = text.len().min(free.len());
        free.iter_mut().zip(text.bytes()).for_each(|(place, byte)| *place = byte);
        self.length += taken;
        if taken == text.len() { Ok(()) } else { Err(fmt::Error) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_message_is_cut_not_refused() {
        #[derive(Debug)]
        struct Long;
        impl fmt::Display for Long {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(&"0123456789".repeat(100))
            }
        }
        impl core::error::Error for Long {}
        let mut message = Message::new();
        message.say(&Long);
        assert_eq!(message.bytes().len(), CAPACITY);
        assert!(message.bytes().starts_with(b"0123456789012"));
    }
}
