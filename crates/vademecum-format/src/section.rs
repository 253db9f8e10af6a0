//! Sections of an opened file, and the reading of their numbers.
//!
//! Numbers are read with `from_le_bytes` from byte arrays (`as_chunks`), which vectorises like a slice and
//! needs neither alignment nor a cast. Note: a section's checksum is not looked at when a file is
//! opened, so that opening does not touch every page of a mapped file; call [`Section::verify`] for that.

use crate::checksum::checksum;
use crate::element::{Codec, Element};
use crate::error::FormatError;
use crate::kind::SectionKind;
use crate::quantised::Quantised;

/// A section of an opened file; its place and shape have been checked, its bytes have not (see
/// [`Section::verify`]).
#[derive(Clone, Copy, Debug)]
pub struct Section<'a> {
    pub(crate) kind: SectionKind,
    pub(crate) element: Element,
    pub(crate) codec: Codec,
    pub(crate) required: bool,
    pub(crate) shape: [u64; 3],
    pub(crate) decoded_length: u64,
    pub(crate) crc32: u32,
    pub(crate) stored: &'a [u8],
}

/// Real numbers of a section, as bytes.
#[derive(Clone, Copy, Debug)]
pub enum Numbers<'a> {
    /// binary32, little-endian.
    F32(&'a [[u8; 4]]),
    /// binary64, little-endian.
    F64(&'a [[u8; 8]]),
    /// 16-bit numbers with a scale per block.
    I16(Quantised<'a>),
}

impl<'a> Numbers<'a> {
    /// Count of numbers.
    #[must_use]
    pub const fn len(&self) -> usize {
        match self {
            Self::F32(numbers) => numbers.len(),
            Self::F64(numbers) => numbers.len(),
            Self::I16(numbers) => numbers.len(),
        }
    }

    /// True without any number.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Quantised numbers of a section of this shape from its decoded bytes; `None` if they are not as many as
    /// the shape asks for.
    #[must_use]
    pub fn quantised(decoded: &'a [u8], shape: [u64; 3]) -> Option<Self> {
        Quantised::new(decoded, shape).map(Self::I16)
    }

    /// The number at `index`.
    #[must_use]
    pub fn get(&self, index: usize) -> Option<f64> {
        match self {
            Self::F32(numbers) => numbers.get(index).map(|&bytes| f64::from(f32::from_le_bytes(bytes))),
            Self::F64(numbers) => numbers.get(index).map(|&bytes| f64::from_le_bytes(bytes)),
            Self::I16(numbers) => numbers.get(index),
        }
    }

    /// `length` numbers from `start`; of quantised ones within one node.
    #[must_use]
    pub fn row(&self, start: usize, length: usize) -> Option<Self> {
        let end = start.checked_add(length)?;
        match self {
            Self::F32(numbers) => numbers.get(start..end).map(Self::F32),
            Self::F64(numbers) => numbers.get(start..end).map(Self::F64),
            Self::I16(numbers) => numbers.row(start, length).map(Self::I16),
        }
    }

    /// All of them in order.
    pub fn iter(&self) -> impl Iterator<Item = f64> + 'a {
        let none = Quantised::default();
        let (single, double, quantised): (&'a [[u8; 4]], &'a [[u8; 8]], Quantised<'a>) = match *self {
            Self::F32(numbers) => (numbers, &[], none),
            Self::F64(numbers) => (&[], numbers, none),
            Self::I16(numbers) => (&[], &[], numbers),
        };
        let single = single.iter().map(|&bytes| f64::from(f32::from_le_bytes(bytes)));
        let double = double.iter().map(|&bytes| f64::from_le_bytes(bytes));
        single.chain(double).chain(quantised.iter())
    }
}

impl<'a> Section<'a> {
    /// Its kind.
    #[must_use]
    pub const fn kind(&self) -> SectionKind {
        self.kind
    }

    /// Its element type.
    #[must_use]
    pub const fn element(&self) -> Element {
        self.element
    }

    /// Its codec.
    #[must_use]
    pub const fn codec(&self) -> Codec {
        self.codec
    }

    /// True if a reader that does not know it must refuse the file.
    #[must_use]
    pub const fn is_required(&self) -> bool {
        self.required
    }

    /// Its shape, last number fastest; places past its rank are 1.
    #[must_use]
    pub const fn shape(&self) -> [u64; 3] {
        self.shape
    }

    /// Its bytes as they are stored.
    #[must_use]
    pub const fn stored(&self) -> &'a [u8] {
        self.stored
    }

    /// Bytes once decoded.
    #[must_use]
    pub const fn decoded_length(&self) -> u64 {
        self.decoded_length
    }

    /// Compares the stored bytes with their checksum. Reads all of them.
    ///
    /// # Errors
    /// Refusal 27.
    pub fn verify(&self) -> Result<(), FormatError> {
        let found = checksum(self.stored);
        if found == self.crc32 {
            return Ok(());
        }
        Err(FormatError::SectionChecksum { kind: self.kind.number(), found, expected: self.crc32 })
    }

    /// Its bytes, if they are stored raw.
    ///
    /// # Errors
    /// Refusal 28.
    pub fn raw(&self) -> Result<&'a [u8], FormatError> {
        match self.codec {
            Codec::Raw => Ok(self.stored),
            codec => Err(FormatError::Compressed { kind: self.kind.number(), codec: codec as u8 }),
        }
    }

    /// Its real numbers.
    ///
    /// # Errors
    /// Refusals 28 (compressed), 19 (not real numbers) and 24 (not as many as its shape says, which opening
    /// has ruled out).
    pub fn numbers(&self) -> Result<Numbers<'a>, FormatError> {
        match self.element {
            Element::F32 => Ok(Numbers::F32(self.raw()?.as_chunks().0)),
            Element::F64 => Ok(Numbers::F64(self.raw()?.as_chunks().0)),
            Element::I16 => {
                let raw = self.raw()?;
                let (kind, found) = (self.kind.number(), raw.len() as u64);
                let wrong = FormatError::Length { kind, found, expected: self.decoded_length };
                Numbers::quantised(raw, self.shape).ok_or(wrong)
            }
            _ => Err(self.wrong_element()),
        }
    }

    /// Its numbers as binary64.
    ///
    /// # Errors
    /// Refusals 28 and 19.
    pub fn f64s(&self) -> Result<&'a [[u8; 8]], FormatError> {
        self.chunks(Element::F64)
    }

    /// Its numbers as 64-bit integers.
    ///
    /// # Errors
    /// Refusals 28 and 19.
    pub fn u64s(&self) -> Result<&'a [[u8; 8]], FormatError> {
        self.chunks(Element::U64)
    }

    /// Its numbers as 32-bit integers.
    ///
    /// # Errors
    /// Refusals 28 and 19.
    pub fn u32s(&self) -> Result<&'a [[u8; 4]], FormatError> {
        self.chunks(Element::U32)
    }

    /// Its text.
    ///
    /// # Errors
    /// Refusals 28, 19 and 29.
    pub fn text(&self) -> Result<&'a str, FormatError> {
        let bytes = self.chunks::<1>(Element::U8)?.as_flattened();
        core::str::from_utf8(bytes).map_err(|_| FormatError::Text { kind: self.kind.number() })
    }

    fn chunks<const N: usize>(&self, element: Element) -> Result<&'a [[u8; N]], FormatError> {
        if self.element == element { Ok(self.raw()?.as_chunks().0) } else { Err(self.wrong_element()) }
    }

    fn wrong_element(&self) -> FormatError {
        FormatError::Element { kind: self.kind.number(), found: self.element as u8 }
    }
}
