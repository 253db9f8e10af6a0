//! Quadrangular facets of the loadable surface: a point of one is found by the facet's triangles, and shared
//! over the facet's own nodes.

use crate::error::FormatError;
use crate::kind::SectionKind;
use crate::read::File;

/// Most nodes of a facet.
const MAX_NODES: usize = 9;
/// Numbers of a row before its nodes.
const HEAD: usize = 2;
/// Nodes of a triangle.
const TRIANGLE: usize = 3;
/// In place of a node that a facet does not have.
pub(crate) const NO_NODE: u32 = u32::MAX;
/// Nodes that every facet has: its corners.
pub(crate) const CORNERS: usize = 4;

/// A quadrangular facet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quadrangle {
    /// The first of its triangles, among the loadable ones.
    pub first: u32,
    /// Number of its triangles, one after the other.
    pub count: u32,
    nodes: [u32; MAX_NODES],
    n_nodes: usize,
}

impl Quadrangle {
    /// Its corners in turn, then the middles of the edges from each corner to the next, then its own middle:
    /// four, eight or nine nodes in a file that is sound.
    #[must_use]
    pub fn nodes(&self) -> &[u32] {
        self.nodes.get(..self.n_nodes).unwrap_or_default()
    }
}

/// The quadrangular facets that may be loaded, in the order of their triangles.
#[derive(Clone, Copy, Debug, Default)]
pub struct Quadrangles<'a> {
    numbers: &'a [[u8; 4]],
    width: usize,
}

impl<'a> Quadrangles<'a> {
    /// Facets.
    #[must_use]
    pub const fn len(&self) -> usize {
        match self.numbers.len().checked_div(self.width) {
            Some(count) => count,
            None => 0,
        }
    }

    /// True without any.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn row(&self, index: usize) -> Option<&'a [[u8; 4]]> {
        let start = index.checked_mul(self.width)?;
        self.numbers.get(start..start.checked_add(self.width)?)
    }

    /// One of them.
    #[must_use]
    pub fn get(&self, index: usize) -> Option<Quadrangle> {
        let mut numbers = self.row(index)?.iter().map(|&bytes| u32::from_le_bytes(bytes));
        let (first, count) = (numbers.next()?, numbers.next()?);
        let mut facet = Quadrangle { first, count, nodes: [NO_NODE; MAX_NODES], n_nodes: 0 };
        for (place, node) in facet.nodes.iter_mut().zip(numbers.take_while(|&node| node != NO_NODE)) {
            *place = node;
            facet.n_nodes += 1;
        }
        Some(facet)
    }

    /// Numbers in the places of the nodes of one of them, as they are.
    pub fn numbers(&self, index: usize) -> Option<impl Iterator<Item = u32> + use<'a>> {
        Some(self.row(index)?.iter().skip(HEAD).map(|&bytes| u32::from_le_bytes(bytes)))
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = Quadrangle> + use<'a> {
        let all = *self;
        (0..all.len()).filter_map(move |index| all.get(index))
    }

    /// The facet of a triangle, found in the logarithm of their number; `None` for one that is a facet of its
    /// own.
    #[must_use]
    pub fn of_triangle(&self, triangle: u32) -> Option<Quadrangle> {
        let first = |index| self.row(index)?.first().map(|&bytes| u32::from_le_bytes(bytes));
        let (mut low, mut high) = (0, self.len());
        while low < high {
            let middle = low + (high - low) / 2;
            if first(middle)? <= triangle {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        let facet = self.get(low.checked_sub(1)?)?;
        (triangle.wrapping_sub(facet.first) < facet.count).then_some(facet)
    }
}

impl<'a> File<'a> {
    /// The quadrangular facets that may be loaded; none where the file does not have the section. Reads all
    /// of it.
    ///
    /// # Errors
    /// Refusals 28 (compressed) and 38.
    pub fn quadrangles(&self) -> Result<Quadrangles<'a>, FormatError> {
        let kind = SectionKind::Quadrangles;
        let numbers = self.indices(kind)?.unwrap_or_default();
        let width = self.section(kind).map_or(0, |section| section.shape()[1] as usize);
        Ok(Quadrangles { numbers, width })
    }

    /// Nodes that share a force at a point of the loadable surface, at most: three, or as many as the largest
    /// quadrangular facet has.
    #[must_use]
    pub fn contact_nodes(&self) -> usize {
        let table = self.section(SectionKind::Quadrangles);
        let nodes = table.map_or(0, |section| (section.shape()[1] as usize).saturating_sub(HEAD));
        nodes.clamp(TRIANGLE, MAX_NODES)
    }
}
