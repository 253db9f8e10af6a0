//! The embedded surface: drawn in place of the surface of the mesh, and moved by it.
//!
//! Each vertex lies in a tetrahedron, or just outside of one, and moves as its four corners do: it lies at
//! `Σ w x` and moves by `Σ w u`, with barycentric weights `w`, so that rigid motions are kept exactly.

use crate::base::error::OutputError;
use vademecum_format::{File, FormatError, Numbers, SectionKind};

/// Nodes that a vertex follows.
const CORNERS: usize = 4;

/// The surface that a file draws.
///
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use vademecum_eval::EmbeddedSurface;
///
/// let file = File::parse(BODY)?;
/// // This file has none: its surface is that of its mesh.
/// assert!(EmbeddedSurface::new(&file)?.is_none());
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug)]
pub struct EmbeddedSurface<'m> {
    nodes: &'m [[u8; 4]],
    weights: Numbers<'m>,
    triangles: &'m [[u8; 4]],
}

impl<'m> EmbeddedSurface<'m> {
    /// The embedded surface of a file; `None` if it has none.
    ///
    /// # Errors
    /// [`OutputError::Missing`] if one of its three sections is not in the file or is compressed;
    /// [`OutputError::OutOfRange`] for a node or a vertex that there is not.
    pub fn new(file: &File<'m>) -> Result<Option<Self>, OutputError> {
        use SectionKind as S;
        if file.section(S::EmbeddedTriangles).is_none() {
            return Ok(None);
        }
        let indices = |kind| match file.indices(kind) {
            Ok(Some(all)) => Ok(all),
            Err(FormatError::Index { found, count, .. }) => {
                Err(OutputError::OutOfRange { index: found as usize, count: count as usize })
            }
            _ => Err(OutputError::Missing { kind }),
        };
        let kind = S::EmbeddedWeights;
        let weights = file.section(kind).and_then(|section| section.numbers().ok());
        let weights = weights.ok_or(OutputError::Missing { kind })?;
        let nodes = indices(S::EmbeddedNodes)?;
        if weights.len() != nodes.len() {
            return Err(OutputError::Length { found: weights.len(), needed: nodes.len() });
        }
        Ok(Some(Self { nodes, weights, triangles: indices(S::EmbeddedTriangles)? }))
    }

    /// Number of vertices.
    #[must_use]
    pub const fn n_vertices(&self) -> usize {
        self.nodes.len() / CORNERS
    }

    /// Number of triangles.
    #[must_use]
    pub const fn n_triangles(&self) -> usize {
        self.triangles.len() / 3
    }

    /// Vertices of each triangle, counter-clockwise from outside.
    pub fn triangles(&self) -> impl ExactSizeIterator<Item = [u32; 3]> + 'm {
        self.triangles.as_chunks::<3>().0.iter().map(|triangle| triangle.map(u32::from_le_bytes))
    }

    /// The four nodes that a vertex follows, among those of the surface, and their weights, which sum to 1.
    #[must_use]
    pub fn vertex(&self, vertex: usize) -> Option<([u32; CORNERS], [f64; CORNERS])> {
        let nodes = self.nodes.as_chunks::<CORNERS>().0.get(vertex)?;
        let weight = |k| self.weights.get(CORNERS * vertex + k);
        let [a, b, c, d] = [weight(0)?, weight(1)?, weight(2)?, weight(3)?];
        Some((nodes.map(u32::from_le_bytes), [a, b, c, d]))
    }

    /// Values at the vertices from those at the nodes of the surface, three numbers each: positions at rest
    /// or moved, displacements, velocities. Twelve products a vertex.
    ///
    /// # Errors
    /// [`OutputError::Length`] if `out` has not three numbers a vertex; [`OutputError::OutOfRange`] if
    /// `at_nodes` are not those of all nodes of the surface.
    pub fn interpolate_into(&self, at_nodes: &[f64], out: &mut [f64]) -> Result<(), OutputError> {
        let needed = 3 * self.n_vertices();
        if out.len() != needed {
            return Err(OutputError::Length { found: out.len(), needed });
        }
        for (vertex, value) in out.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            let Some((nodes, weights)) = self.vertex(vertex) else { continue };
            *value = [0.0; 3];
            for (node, weight) in nodes.into_iter().zip(weights) {
                let index = node as usize;
                let at = at_nodes.as_chunks::<3>().0.get(index);
                let at = at.ok_or(OutputError::OutOfRange { index, count: at_nodes.len() / 3 })?;
                value.iter_mut().zip(at).for_each(|(sum, x)| *sum += weight * x);
            }
        }
        Ok(())
    }
}
