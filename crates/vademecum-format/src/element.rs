//! Element types of sections, and codecs of their bytes.

use crate::quantised;

/// Type of a section's numbers, all little-endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
#[non_exhaustive]
pub enum Element {
    /// Bytes.
    U8 = 0,
    /// 32-bit unsigned.
    U32 = 1,
    /// 64-bit unsigned.
    U64 = 2,
    /// IEEE binary32.
    F32 = 3,
    /// IEEE binary64.
    F64 = 4,
    /// 16-bit signed times a binary32 scale per block ([`Quantised`](crate::Quantised)). Since version 1.1.
    I16 = 5,
}

impl Element {
    /// The element with this code.
    #[must_use]
    pub fn from_code(code: u8) -> Option<Self> {
        let all = [Self::U8, Self::U32, Self::U64, Self::F32, Self::F64, Self::I16];
        all.into_iter().find(|element| *element as u8 == code)
    }

    /// Bytes of one number.
    #[must_use]
    pub const fn size(self) -> u64 {
        match self {
            Self::U8 => 1,
            Self::I16 => 2,
            Self::U32 | Self::F32 => 4,
            Self::U64 | Self::F64 => 8,
        }
    }

    /// Bytes of a section of this shape once decoded; `None` past 2⁶⁴. Quantised numbers bring their scales.
    #[must_use]
    pub fn decoded_length(self, shape: [u64; 3]) -> Option<u64> {
        let numbers = shape.iter().try_fold(self.size(), |bytes, &n| bytes.checked_mul(n))?;
        match self {
            Self::I16 => numbers.checked_add(quantised::scales_length(shape)?),
            _ => Some(numbers),
        }
    }
}

/// Storage of a section's bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
#[non_exhaustive]
pub enum Codec {
    /// As they are.
    Raw = 0,
    /// One zstd frame of them.
    Zstd = 1,
    /// By block: bytes grouped by their place in a number, then one zstd frame. Since version 1.1.
    Shuffled = 2,
    /// By block, 16-bit numbers only: differences to the node before, then as [`Codec::Shuffled`]. Since
    /// version 1.1.
    Delta = 3,
}

impl Codec {
    /// The codec with this code.
    #[must_use]
    pub fn from_code(code: u8) -> Option<Self> {
        let all = [Self::Raw, Self::Zstd, Self::Shuffled, Self::Delta];
        all.into_iter().find(|codec| *codec as u8 == code)
    }

    /// True if numbers of this type may be stored so.
    #[must_use]
    pub fn codes(self, element: Element) -> bool {
        self != Self::Delta || element == Element::I16
    }
}
