//! Rows over the basis as rows over the modes, and numbers written one after the other.

use crate::kernels::dense::dot;
use crate::parametric::error::ParametricError;
use crate::parametric::model::Parametric;
use vademecum_format::{Element, Numbers, SectionKind};

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
    // Beside the product that gives a number, a call is nothing; copies of it are kilobytes.
    #[inline(never)]
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
#[inline(never)]
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

impl Parametric<'_> {
    /// Row of a probe of the file over the basis, `r` numbers: its value is that of the row along the motion.
    ///
    /// # Errors
    /// [`ParametricError::Row`]: none of this number; [`ParametricError::Format`].
    pub fn probe_row(&self, probe: usize, out: &mut [f64]) -> Result<(), ParametricError> {
        self.row_of(SectionKind::ProbeRows, probe, out)
    }

    /// Row of a load pattern over the basis, `r` numbers: the load of amplitude 1.
    ///
    /// # Errors
    /// As [`Parametric::probe_row`].
    pub fn pattern_row(&self, pattern: usize, out: &mut [f64]) -> Result<(), ParametricError> {
        self.row_of(SectionKind::PatternBasis, pattern, out)
    }

    /// Row of a direction at a node of the surface over the basis, `r` numbers: the displacement along it,
    /// and the load of a force of this direction and size.
    ///
    /// # Errors
    /// As [`Parametric::probe_row`].
    pub fn node_row(&self, node: usize, direction: [f64; 3], out: &mut [f64]) -> Result<(), ParametricError> {
        let section = self.section_of(SectionKind::SurfaceBasis, node, 3)?;
        out.fill(0.0);
        for (component, scale) in direction.into_iter().enumerate() {
            let place = node.saturating_mul(3).saturating_add(component).saturating_mul(out.len());
            if let Some(row) = section.row(place, out.len()) {
                out.iter_mut().zip(row.iter()).for_each(|(out, value)| *out += scale * value);
            }
        }
        Ok(())
    }

    fn row_of(&self, kind: SectionKind, index: usize, out: &mut [f64]) -> Result<(), ParametricError> {
        let numbers = self.section_of(kind, index, 1)?;
        if out.len() != self.n_basis() {
            let (found, needed) = (out.len(), self.n_basis());
            return Err(ParametricError::LentMemory { what: "numbers of a row", found, needed });
        }
        read_row(&numbers, index, out);
        Ok(())
    }

    /// Numbers of a section that has so many rows for each index.
    fn section_of(
        &self,
        kind: SectionKind,
        index: usize,
        each: usize,
    ) -> Result<Numbers<'_>, ParametricError> {
        let none = ParametricError::Row { section: kind, index, count: 0 };
        let numbers = self.file.section(kind).ok_or(none)?.numbers()?;
        let count = numbers.len() / (each * self.n_basis()).max(1);
        if index >= count {
            return Err(ParametricError::Row { section: kind, index, count });
        }
        Ok(numbers)
    }
}
