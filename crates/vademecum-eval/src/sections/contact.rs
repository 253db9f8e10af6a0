//! A force at a point of the surface.

use crate::base::error::LoadError;
use crate::base::scalar::Scalar;
use crate::kernels::kernel::add_row;
use crate::sections::rows::Rows;
use vademecum_format::SectionKind;

/// A point load on the surface: `force` \[N\], shared by three nodes with barycentric `weights` (which sum
/// to 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Loadable nodes, in file order.
    pub nodes: [u32; 3],
    /// Their shares.
    pub weights: [f64; 3],
    /// Force \[N\].
    pub force: [f64; 3],
}

impl Contact {
    /// Refuses what is not finite, and nodes that are not loadable.
    pub(crate) fn check(&self, limit: u32) -> Result<(), LoadError> {
        if !self.weights.iter().chain(&self.force).all(|x| x.is_finite()) {
            return Err(LoadError::NotFinite);
        }
        match self.nodes.iter().find(|&&node| node >= limit) {
            Some(&node) => Err(LoadError::NotLoadable { node, limit }),
            None => Ok(()),
        }
    }

    /// `BᵀF` of this contact into `g`, length `r`.
    pub(crate) fn project<T: Scalar>(&self, rows: &Rows<'_>, g: &mut [T]) -> Result<(), LoadError> {
        let (kind, r) = (SectionKind::SurfaceBasis, g.len());
        let basis = rows.surface.ok_or(LoadError::Missing { kind })?;
        g.fill(T::ZERO);
        for (&node, weight) in self.nodes.iter().zip(self.weights) {
            for (component, force) in self.force.iter().enumerate() {
                let row = basis.row((3 * node as usize + component) * r, r);
                add_row(row.ok_or(LoadError::Missing { kind })?, T::from_f64(weight * force), g);
            }
        }
        Ok(())
    }
}
