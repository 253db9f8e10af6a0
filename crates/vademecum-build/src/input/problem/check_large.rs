//! What goes with large displacements, and what belongs to linear motion alone.

use super::check::{Words, positive};
use super::{ModelKind, Problem, ProblemError, Representation};
use crate::limits::MAGNITUDE;

/// Most coordinates: all interact, so their products grow with the square, the work of a step with the cube.
const MOST_COORDINATES: usize = 64;

impl Problem {
    /// Whether large displacements are asked for.
    pub fn is_large(&self) -> bool {
        self.model == ModelKind::LargeDisplacement
    }

    pub(super) fn check_large(&self) -> Result<(), ProblemError> {
        let found = if !self.is_large() {
            let expected = "`model = \"large-displacement\"` beside it";
            return self.require(self.large.is_none(), "large", Words("a table"), expected);
        } else if self.mesh.matrices.is_some() {
            "large-displacement beside `mesh.matrices`, which are linear"
        } else if self.representation == Representation::Canonical {
            "large-displacement beside `representation = \"canonical\"`"
        } else if self.time.scheme.is_some() {
            "large-displacement beside `time.scheme`: such a file has a scheme of its own"
        } else if self.basis.kind.is_some() || self.basis.energy.is_some() || self.basis.error.is_some() {
            "large-displacement beside `basis.kind`, `basis.energy` or `basis.error`: the basis is chosen by held-out loads"
        } else if self.snapshots.npy.is_some() || self.snapshots.vtu.is_some() {
            "large-displacement beside snapshots of another program"
        } else if self.parameters.iter().any(|parameter| parameter.region != "*") {
            "large-displacement beside a live parameter of a region"
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
        self.require(modes <= MOST_COORDINATES, "basis.modes", modes, expected)?;
        let Some(large) = &self.large else { return Ok(()) };
        let length = large.displacement;
        let usable = length.is_none_or(|x| positive(x) && (MAGNITUDE.0..=MAGNITUDE.1).contains(&x));
        let expected = "a positive length in metres between 1e-30 and 1e30";
        self.require(usable, "large.displacement", length.unwrap_or(0.0), expected)?;
        let rows = large.rows.unwrap_or(0);
        self.require(rows <= 4096, "large.rows", rows, "0 to 4096 rows")?;
        let states = large.states.unwrap_or(1);
        self.require((1..=100_000).contains(&states), "large.states", states, "1 to 100 000 states")?;
        let pushes = large.pushes.unwrap_or(1);
        self.require((1..=1000).contains(&pushes), "large.pushes", pushes, "1 to 1000 pushes")
    }
}
