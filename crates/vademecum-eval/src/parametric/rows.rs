//! Rows over the basis as rows over the modes, and numbers written one after the other.

use crate::kernels::dense::dot;
use vademecum_format::{Element, Numbers};

/// Writes real numbers of an element type one after the other.
pub(crate) enum Reals<'b> {
    Single(core::slice::IterMut<'b, [u8; 4]>),
    Double(core::slice::IterMut<'b, [u8; 8]>),
}

impl<'b> Reals<'b> {
    /// Numbers over these bytes.
    pub fn new(element: Element, bytes: &'b mut [u8]) -> Self {
        match element {
            Element::F32 => Self::Single(bytes.as_chunks_mut().0.iter_mut()),
            _ => Self::Double(bytes.as_chunks_mut().0.iter_mut()),
        }
    }

    /// Writes the next; nothing at the end.
    pub fn push(&mut self, value: f64) {
        match self {
            Self::Single(places) => {
                if let Some(place) = places.next() {
                    *place = (value as f32).to_le_bytes();
                }
            }
            Self::Double(places) => {
                if let Some(place) = places.next() {
                    *place = value.to_le_bytes();
                }
            }
        }
    }
}

/// Row `index` of `r` numbers, as binary64; zeros outside.
pub(crate) fn read_row(numbers: &Numbers<'_>, index: usize, out: &mut [f64]) {
    out.fill(0.0);
    let r = out.len();
    if let Some(row) = numbers.row(index.saturating_mul(r), r) {
        out.iter_mut().zip(row.iter()).for_each(|(out, value)| *out = value);
    }
}

/// A row over the basis along each of the shapes, which are rows themselves.
pub(crate) fn along<'s>(shapes: &'s [f64], row: &'s [f64]) -> impl Iterator<Item = f64> + 's {
    shapes.chunks_exact(row.len().max(1)).map(move |shape| dot(shape, row))
}
