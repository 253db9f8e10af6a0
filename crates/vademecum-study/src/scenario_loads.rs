//! The loads of a scenario, as files and as full-order marches take them.

use vademecum_build::dynamics::TimedLoad;
use vademecum_build::prepared::Body;
use vademecum_format::File;

use crate::error::StudyError;
use crate::player::Track;
use crate::scenario::Scenario;
use crate::verify::{file_nodes, full_order_loads};

/// A scenario on a body: the nodes of every file of a body stand in one order, so that one track serves all.
pub struct ScenarioLoads {
    /// As files take it.
    pub track: Track,
    /// As solvers without a file take it.
    pub loads: Vec<TimedLoad>,
    /// Mesh node of each node of a file.
    pub file_nodes: Vec<u32>,
}

impl ScenarioLoads {
    /// Binds the scenario through any file of the body.
    ///
    /// # Errors
    /// A file that does not bind, and loads that the body does not have.
    pub fn new(bytes: &[u8], scenario: &Scenario, body: &Body) -> Result<Self, StudyError> {
        let file = File::parse(bytes)?;
        let track = Track::bind(&file, scenario)?;
        let file_nodes = file_nodes(&file, body)?;
        let loads = full_order_loads(&file, &track, body, &file_nodes)?;
        Ok(Self { track, loads, file_nodes })
    }
}
