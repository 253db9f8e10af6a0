//! What a comparison is of: a problem, a scenario, and the scenario's loads as files and as full-order marches take them.

use std::path::{Path, PathBuf};

use vademecum_build::dynamics::TimedLoad;
use vademecum_build::input::Problem;
use vademecum_format::File;
use vademecum_study::bench::Study;
use vademecum_study::scenario::Scenario;

use crate::cmd::demo::{PROBLEM, SCENARIO};
use crate::cmd::verify::{file_nodes, full_order_loads};
use crate::failure::{Cause, Failure};
use crate::player::Track;

/// The problem of a file, or the demo's.
pub fn problem_or_demo(path: Option<&Path>) -> Result<Problem, Failure> {
    Ok(match path {
        Some(path) => Problem::read(path)?,
        None => Problem::parse(PROBLEM, "the demo's problem", PathBuf::new())?,
    })
}

/// The scenario of a file; without one the demo's for its problem, a push for another.
pub fn scenario_or_push(
    path: Option<&Path>,
    problem: Option<&Path>,
    study: &Study,
) -> Result<Scenario, Failure> {
    Ok(match (path, problem) {
        (Some(path), _) => Scenario::read(path)?,
        (None, None) => Scenario::parse(SCENARIO, "the demo's scenario")?,
        (None, Some(_)) => Scenario::parse(&push(study)?, "the bench's own scenario")?,
    })
}

/// An oblique push on the middle one of the loadable triangles, 200 steps long, and 1 800 steps free.
fn push(study: &Study) -> Result<String, Failure> {
    let body = &study.prepared().body;
    let Some(triangle) = body.loadable.get(body.loadable.len() / 2) else {
        let text = "the body has no surface that a push could act on";
        return Err(
            Failure::new(Cause::Input, text).remedy("name a scenario of load patterns: `--scenario FILE`")
        );
    };
    let corners = triangle.map(|node| body.model.mesh().nodes[node as usize]);
    let center: [f64; 3] = std::array::from_fn(|c| corners.iter().map(|p| p[c]).sum::<f64>() / 3.0);
    let dt = study.time_step();
    Ok(format!(
        "duration = {:e}\n[[contact]]\npoint = {center:?}\nforce = [0.3, -0.5, -0.8]\nend = {:e}\n",
        2000.0 * dt,
        200.0 * dt
    ))
}

/// A scenario on a body: the nodes of every file of a body stand in one order, so that one track serves all.
pub struct Bound {
    /// As files take it.
    pub track: Track,
    /// As solvers without a file take it.
    pub loads: Vec<TimedLoad>,
    /// Mesh node of each node of a file.
    pub file_nodes: Vec<u32>,
}

impl Bound {
    /// Binds the scenario through any file of the body, which errors call `name`.
    pub fn new(name: &Path, bytes: &[u8], scenario: &Scenario, study: &Study) -> Result<Self, Failure> {
        let file = File::parse(bytes).map_err(|error| Failure::file(name, error))?;
        let track = Track::bind(name, &file, scenario)?;
        let body = &study.prepared().body;
        let file_nodes = file_nodes(name, &file, body)?;
        let loads = full_order_loads(&track, body, &file_nodes, name, &file)?;
        Ok(Self { track, loads, file_nodes })
    }
}
