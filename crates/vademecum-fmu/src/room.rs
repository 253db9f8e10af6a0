//! Memory and options that a body is bound with.

use vademecum_eval::format::File;
use vademecum_eval::{BindError, BodyOptions, LiveMemory, SceneOptions, StructureChoice};

use crate::parameters::{has_live, parameters};
use crate::points::Points;
use crate::variables::has_live_regions;

/// Numbers that a body wants.
pub struct Lengths {
    pub body: usize,
    pub parameters: usize,
    pub inputs: usize,
    pub saved: usize,
}

impl Lengths {
    /// Those of a file with these points.
    pub fn of(file: &File<'_>, options: &BodyOptions, points: &Points<'_>) -> Result<Self, BindError> {
        let metadata = file.metadata();
        let inputs =
            points.len().saturating_mul(3).saturating_add(metadata.n_patterns as usize).saturating_add(3);
        // With the filtered forces of all points and patterns.
        let nodes = filtered_nodes(file, points.named(), points.surface());
        let filtered = nodes.saturating_mul(4).saturating_add(metadata.n_patterns as usize);
        let saved = filtered.saturating_add(3 + 3 * metadata.n_modes as usize);
        let length =
            if has_live(file) { LiveMemory::len_for::<f64> } else { vademecum_eval::Body::<f64>::len_for };
        Ok(Self { body: length(file, options)?, parameters: parameters(file), inputs, saved })
    }

    /// All of them.
    pub fn sum(&self) -> usize {
        let Self { body, parameters, inputs, saved } = *self;
        let twice = [body, parameters, parameters, inputs, inputs, saved, saved];
        twice.into_iter().fold(0, usize::saturating_add)
    }
}

/// Options of the evaluator's body: no compliance is asked for.
pub fn body_options(file: &File<'_>, points: &Points<'_>) -> BodyOptions {
    let scene = options(file, points.named(), points.surface());
    BodyOptions { scene, places: 0, ..BodyOptions::default() }
}

/// Nodes whose filtered forces a state keeps: those of the facets of named points, and the surface nodes.
fn filtered_nodes(file: &File<'_>, named: usize, surface: usize) -> usize {
    file.contact_nodes().saturating_mul(named.max(1)).saturating_add(surface)
}

/// Structure that a body of a file is bound with: that of `vademecum run`, except that a file with live
/// regions takes the one that knows them from the start.
#[must_use]
pub fn options(file: &File<'_>, named: usize, surface: usize) -> SceneOptions {
    let metadata = file.metadata();
    let structure = if has_live_regions(metadata) && metadata.block {
        StructureChoice::Block
    } else {
        StructureChoice::Auto
    };
    // Room for every point, whether it is loaded or not; without any, reactions would not remember patterns.
    let contacts = named.saturating_add(surface).max(1);
    let filtered_nodes = Some(filtered_nodes(file, named, surface));
    SceneOptions { structure, contacts, filtered_nodes, ..SceneOptions::default() }
}
