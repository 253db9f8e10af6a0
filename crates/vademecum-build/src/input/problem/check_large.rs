//! Keys that large displacements exclude, since they belong to linear motion alone.

use super::check::Words;
use super::{ModelKind, Problem, ProblemError, Representation};

/// Most coordinates: all interact, so their products grow with the square, the work of a step with the cube.
const MAX_COORDINATES: usize = 64;

impl Problem {
    /// True for a problem of large displacements.
    pub fn is_large(&self) -> bool {
        self.model == ModelKind::LargeDisplacement
    }

    pub(super) fn check_large(&self) -> Result<(), ProblemError> {
        let found = if !self.is_large() {
            let expected = "`model = \"large-displacement\"` beside it";
            return self.require(self.large.is_none(), "large", Words("a table"), expected);
        } else if self.mesh.matrices.is_some() {
            "large-displacement beside `mesh.matrices`, which are linear"
        } else if self.representation == Some(Representation::Canonical) {
            "large-displacement beside `representation = \"chapter\"`"
        } else if self.time.scheme.is_some() {
            "large-displacement beside `time.scheme`: such a file has a scheme of its own"
        } else if self.basis.kind.is_some() || self.basis.energy.is_some() || self.basis.error.is_some() {
            "large-displacement beside `basis.kind`, `basis.energy` or `basis.error`: the basis is chosen by held-out loads"
        } else if self.snapshots.npy.is_some() || self.snapshots.vtu.is_some() {
            "large-displacement beside snapshots of another program"
        } else if self.has_local_parameters() {
            "large-displacement beside a live parameter of a region"
        } else if self.materials.iter().any(|m| m.orthotropic.is_some() || m.stiffness.is_some()) {
            "large-displacement beside a material that is not isotropic"
        } else if self.damping.modal.is_some() || self.damping.ratio.is_some() {
            "large-displacement beside `damping.modal` or `damping.ratio`: modes do not move apart"
        } else if self.base.moves {
            "large-displacement beside `base.moves`"
        } else if self.is_free() {
            "large-displacement without any `[[support]]`"
        } else if self.output.stress.is_some() || !self.output.gauges.is_empty() || self.output.reactions {
            "large-displacement beside `output.stress`, `output.gauge` or `output.reactions`, which are linear"
        } else if self.output.residual == Some(true) || self.output.static_fields == Some(true) {
            "large-displacement beside `output.residual` or `output.static_fields`, which are linear"
        } else {
            ""
        };
        let expected = "\"linear\", or a body of elements on supports without what belongs to linear motion";
        self.require(found.is_empty(), "model", Words(found), expected)?;
        let modes = self.basis.modes.unwrap_or(1);
        let expected = "at most 64 coordinates beside `model = \"large-displacement\"`: all of them interact";
        self.require(modes <= MAX_COORDINATES, "basis.modes", modes, expected)
    }
}
