//! Sentences without `core::fmt`, whose numbers could panic for all that the linker knows.

use core::ffi::{CStr, c_char};

/// Bytes of a message, the zero at its end included.
const LENGTH: usize = 512;

/// A sentence with a zero at its end; a longer one is cut.
#[derive(Debug)]
pub struct Words {
    bytes: [u8; LENGTH],
    used: usize,
}

impl Default for Words {
    fn default() -> Self {
        Self { bytes: [0; LENGTH], used: 0 }
    }
}

impl Words {
    /// Where it is, with its zero.
    #[must_use]
    pub const fn as_ptr(&self) -> *const c_char {
        self.bytes.as_ptr().cast()
    }

    /// Adds these words, as far as there is room for whole characters.
    pub fn add(&mut self, text: &str) {
        // The last byte stays zero.
        let free = self.bytes.get_mut(self.used..LENGTH - 1).unwrap_or_default();
        let mut fits = text.len().min(free.len());
        while !text.is_char_boundary(fits) {
            fits = fits.saturating_sub(1);
        }
        free.iter_mut().zip(text.bytes().take(fits)).for_each(|(place, byte)| {
            // A zero inside of a name would end the message.
            *place = if byte == 0 { b'?' } else { byte };
        });
        // What is cut stays the end: nothing follows it.
        self.used = if fits == text.len() { self.used + fits } else { LENGTH };
    }
}

/// What can be part of a sentence.
pub trait Say {
    /// Adds it.
    fn say(&self, words: &mut Words);
}

impl Say for &str {
    fn say(&self, words: &mut Words) {
        words.add(self);
    }
}

impl Say for CStr {
    fn say(&self, words: &mut Words) {
        words.add(self.to_str().unwrap_or("?"));
    }
}

/// The shortest digits that are read back as the same number.
impl Say for f64 {
    fn say(&self, words: &mut Words) {
        let text = if self.is_nan() {
            "NaN"
        } else if self.is_infinite() {
            if *self < 0.0 { "-infinity" } else { "infinity" }
        } else {
            return words.add(zmij::Buffer::new().format_finite(*self));
        };
        words.add(text);
    }
}

impl Say for u64 {
    fn say(&self, words: &mut Words) {
        let mut digits = [0; 20];
        let (mut rest, mut used) = (*self, 0);
        for place in digits.iter_mut().rev() {
            *place = b'0' + (rest % 10) as u8;
            (rest, used) = (rest / 10, used + 1);
            if rest == 0 {
                break;
            }
        }
        let written = digits.get(digits.len() - used..).unwrap_or_default();
        words.add(core::str::from_utf8(written).unwrap_or_default());
    }
}

/// Adds all parts of a sentence.
macro_rules! sentence {
    ($words:expr, $($part:expr),+ $(,)?) => {{ $( $crate::words::Say::say(&$part, $words); )+ }};
}
pub(crate) use sentence;

#[cfg(test)]
mod tests {
    use super::{LENGTH, Say, Words};

    fn said(words: &Words) -> &str {
        core::str::from_utf8(&words.bytes[..words.used]).expect("UTF-8")
    }

    #[test]
    fn numbers_become_digits() {
        let mut words = Words::default();
        sentence!(&mut words, 0_u64, " ", 10_u64, " ", u64::MAX, " ", 1.5e-3, " ", f64::NAN, " ", -1.0 / 0.0);
        assert_eq!(said(&words), "0 10 18446744073709551615 0.0015 NaN -infinity");
    }

    #[test]
    fn a_long_sentence_is_cut_between_characters() {
        let mut words = Words::default();
        "ü".repeat(LENGTH).as_str().say(&mut words);
        "a".say(&mut words);
        assert_eq!(words.bytes[LENGTH - 4..], [0xc3, 0xbc, 0, 0]);
    }
}
