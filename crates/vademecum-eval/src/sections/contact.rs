//! A force at a place.

use crate::base::error::LoadError;
use crate::base::scalar::Scalar;
use crate::kernels::kernel::add_row;
use crate::sections::place::{Place, PlaceError};
use crate::sections::rows::Rows;
use vademecum_format::SectionKind;

/// A load at a place of the surface: `force` \[N\], shared by loadable nodes by their weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Loadable nodes and their shares.
    pub place: Place,
    /// Force \[N\].
    pub force: [f64; 3],
    /// Moment \[N m\], of a frame only.
    pub moment: [f64; 3],
}

impl Contact {
    /// A force \[N\] at a place.
    #[must_use]
    pub const fn new(place: Place, force: [f64; 3]) -> Self {
        Self { place, force, moment: [0.0; 3] }
    }

    /// Refuses what is not finite, a place that is wrong, and nodes that are not among the first `limit`, the
    /// loadable ones ([`Metadata::n_load_nodes`](vademecum_format::Metadata::n_load_nodes)).
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn check(&self, limit: u32) -> Result<(), LoadError> {
        if !self.force.iter().all(|x| x.is_finite()) {
            return Err(LoadError::NotFinite);
        }
        check_loadable(&self.place, limit)?;
        if self.moment == [0.0; 3] { Ok(()) } else { Err(PlaceError::Moment.into()) }
    }

    /// `BᵀF` of this contact into `g`, length `r`.
    pub(crate) fn project<T: Scalar>(&self, rows: &Rows<'_>, g: &mut [T]) -> Result<(), LoadError> {
        let (kind, r) = (SectionKind::SurfaceBasis, g.len());
        let basis = rows.surface.ok_or(LoadError::Missing { kind })?;
        g.fill(T::ZERO);
        for (node, weight) in self.place.entries() {
            for (component, force) in self.force.iter().enumerate() {
                let row = basis.row((3 * node as usize + component) * r, r);
                add_row(row.ok_or(LoadError::Missing { kind })?, T::from_f64(weight * force), g);
            }
        }
        Ok(())
    }
}

impl AsRef<Place> for Contact {
    fn as_ref(&self) -> &Place {
        &self.place
    }
}

/// Refuses a place that is wrong, and nodes that are not loadable.
pub(crate) fn check_loadable(place: &Place, limit: u32) -> Result<(), LoadError> {
    place.check()?;
    match place.nodes().iter().find(|&&node| node >= limit) {
        Some(&node) => Err(LoadError::NotLoadable { node, limit }),
        None => Ok(()),
    }
}
