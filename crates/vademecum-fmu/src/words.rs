//! Sentences without `core::fmt`, whose numbers could panic for all that the linker knows.

use core::ffi::{CStr, c_char};

/// Bytes of a message, the zero at its end included.
const LENGTH: usize = 512;

/// A sentence with a zero at its end; a longer one is cut.
#[derive(Debug)]
pub struct Words {
    bytes: [u8; LENGTH],
    used: usize,
    /// Nothing follows what was cut.
    is_cut: bool,
}

impl Default for Words {
    fn default() -> Self {
        Self { bytes: [0; LENGTH], used: 0, is_cut: false }
    }
}

impl Words {
    /// The bytes of the text, with its zero.
    #[must_use]
    pub const fn as_ptr(&self) -> *const c_char {
        self.bytes.as_ptr().cast()
    }

    /// The same sentence as a format of C: every percent sign is doubled.
    #[must_use]
    pub fn as_format(&self) -> Self {
        let mut format = Self::default();
        let text = self.bytes.get(..self.used).unwrap_or_default();
        let mut rest = core::str::from_utf8(text).unwrap_or_default();
        while let Some((before, behind)) = rest.split_once('%') {
            format.add(before);
            // Both or none: half of the pair would be a format of its own.
            if format.used + 2 >= LENGTH {
                return format;
            }
            format.add("%%");
            rest = behind;
        }
        format.add(rest);
        format
    }

    /// Adds these words, as far as there is room for whole characters.
    pub fn add(&mut self, text: &str) {
        if self.is_cut {
            return;
        }
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
        self.used += fits;
        self.is_cut |= fits < text.len();
    }
}

/// A part of a sentence.
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

    #[test]
    fn percent_signs_are_doubled_and_never_halved() {
        let mut words = Words::default();
        "100 % of %s".say(&mut words);
        assert_eq!(said(&words.as_format()), "100 %% of %%s");
        for length in 0..LENGTH {
            let mut words = Words::default();
            "%".repeat(length).as_str().say(&mut words);
            let format = words.as_format();
            let signs = format.bytes.iter().take_while(|&&byte| byte == b'%').count();
            assert_eq!(signs, (2 * length).min(LENGTH - 2), "{length}");
        }
    }
}
