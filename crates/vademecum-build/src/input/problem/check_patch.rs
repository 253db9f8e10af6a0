//! Checks of the residual flexibility between contacts, and of the keys that it excludes.

use super::check::Words;
use super::{Problem, ProblemError};

/// Further natural modes unless the problem has another number.
const CONTACT_MODES: usize = 64;

impl Problem {
    /// Number of further natural modes by which contacts of a patch answer statically.
    pub(crate) fn contact_modes(&self) -> usize {
        // Of live regions the modes of the basis that are not stepped answer in their place.
        let usual = if self.is_parametric() { 0 } else { CONTACT_MODES };
        let asked = self.output.contact_modes.unwrap_or(usual);
        if self.output.contact_patch.is_some() { asked } else { 0 }
    }

    /// The patch of contacts, and what it excludes.
    pub(super) fn check_patch(&self) -> Result<(), ProblemError> {
        let output = &self.output;
        let patch = output.contact_patch.is_some();
        let alone = output.contact_modes.is_some() && !patch;
        let expected = "`output.contact_patch`, the distance of contacts that are answered together";
        self.require(!alone, "output.contact_modes", Words("without `output.contact_patch`"), expected)?;
        if !patch {
            return Ok(());
        }
        let further = self.is_parametric() && self.contact_modes() > 0;
        let found = Words("beside live regions, of which the modes that are not stepped answer");
        self.require(!further, "output.contact_modes", found, "none")?;
        let found = if self.mesh.matrices.is_some() {
            Some("beside `mesh.matrices`, which have no facets")
        } else if self.is_large() {
            Some("beside `model = \"large-displacement\"`")
        } else if output.residual == Some(false) {
            Some("beside `output.residual = false`")
        } else {
            self.without_exact_modes()
        };
        let expected = "natural modes of a linear body that are moved exactly, with the residual flexibility; \
                        elsewhere leave the key out";
        self.require(found.is_none(), "output.contact_patch", Words(found.unwrap_or_default()), expected)
    }
}
