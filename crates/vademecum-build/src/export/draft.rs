//! A section before it is laid out.

use vademecum_format::{Codec, Element, SectionInput, SectionKind};

use crate::input::Precision;

/// Sizes that binary32 holds with all its digits, with room for sums.
const SINGLE: std::ops::Range<f64> = 1e-30..1e30;

/// A section before it is laid out.
#[derive(Clone)]
pub struct Draft {
    /// Its kind.
    pub kind: SectionKind,
    /// Type of its numbers.
    pub element: Element,
    /// Its shape.
    pub shape: [u64; 3],
    /// Its bytes, little-endian.
    pub bytes: Vec<u8>,
}

impl Draft {
    /// As the format takes it.
    pub fn input(&self) -> SectionInput<'_> {
        SectionInput {
            kind: self.kind,
            element: self.element,
            codec: Codec::Raw,
            // Without the ratios a reader would step with less damping.
            required: self.kind.is_chapter()
                || self.kind.is_strain()
                || self.kind.is_live()
                || matches!(self.kind, SectionKind::DampingRatios | SectionKind::DampingRows),
            shape: self.shape,
            decoded_length: self.bytes.len() as u64,
            stored: &self.bytes,
        }
    }

    /// Numbers in double precision.
    pub fn f64s(kind: SectionKind, shape: [usize; 3], values: impl IntoIterator<Item = f64>) -> Self {
        let bytes = joined(values.into_iter().map(f64::to_le_bytes));
        Self { kind, element: Element::F64, shape: shape.map(|s| s as u64), bytes }
    }

    /// Numbers in the precision of the file.
    pub(crate) fn reals(
        kind: SectionKind,
        precision: Precision,
        shape: [usize; 3],
        values: impl IntoIterator<Item = f64>,
    ) -> Self {
        match precision {
            Precision::F64 => Self::f64s(kind, shape, values),
            Precision::F32 => {
                let bytes = joined(values.into_iter().map(|v| (v as f32).to_le_bytes()));
                Self { kind, element: Element::F32, shape: shape.map(|s| s as u64), bytes }
            }
        }
    }

    /// Numbers in the precision of the file, unless binary32 cannot hold their size.
    pub(crate) fn fitting(
        kind: SectionKind,
        precision: Precision,
        shape: [usize; 3],
        values: &[f64],
    ) -> Self {
        let largest = values.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let fits = largest == 0.0 || SINGLE.contains(&largest);
        let precision = if fits { precision } else { Precision::F64 };
        Self::reals(kind, precision, shape, values.iter().copied())
    }

    /// Indices.
    pub fn u32s(kind: SectionKind, shape: [usize; 3], values: impl IntoIterator<Item = u32>) -> Self {
        let bytes = joined(values.into_iter().map(u32::to_le_bytes));
        Self { kind, element: Element::U32, shape: shape.map(|s| s as u64), bytes }
    }

    /// Names, one per line.
    pub fn names<'a>(kind: SectionKind, names: impl Iterator<Item = &'a str>) -> Self {
        let bytes = names.collect::<Vec<_>>().join("\n").into_bytes();
        Self { kind, element: Element::U8, shape: [bytes.len() as u64, 1, 1], bytes }
    }
}

/// The bytes of numbers. Number by number: byte by byte takes five times as long.
fn joined<const N: usize>(numbers: impl Iterator<Item = [u8; N]>) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(N * numbers.size_hint().0);
    numbers.for_each(|number| bytes.extend_from_slice(&number));
    bytes
}
