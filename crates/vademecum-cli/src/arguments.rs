//! Arguments that several commands take, and what they mean without them.

use std::path::{Path, PathBuf};

use vademecum_build::input::Problem;
use vademecum_eval::{SceneOptions, StructureChoice};
use vademecum_study::parameters::ParameterValue;
use vademecum_study::player::PlayOptions;
use vademecum_study::scenario::Scenario;

use crate::failure::Failure;

/// What every command takes that writes files.
#[derive(clap::Args)]
pub struct OutputArguments {
    /// Replace files of another kind too; without it, a file is replaced only by one of its own kind.
    #[arg(long)]
    pub force: bool,
}

/// The problem and scenario of the demo, inside the program.
pub const PROBLEM: &str = include_str!("../../../fixtures/problems/cantilever.toml");
/// See [`PROBLEM`].
pub const SCENARIO: &str = include_str!("../../../fixtures/scenarios/push.toml");

/// The demo's problem.
pub fn demo_problem() -> Result<Problem, Failure> {
    Ok(Problem::parse(PROBLEM, "the demo's problem", PathBuf::new())?)
}

/// The demo's scenario.
pub fn demo_scenario() -> Result<Scenario, Failure> {
    Ok(Scenario::parse(SCENARIO, "the demo's scenario")?)
}

/// The problem of a file, or the demo's.
pub fn problem_or_demo(path: Option<&Path>) -> Result<Problem, Failure> {
    path.map_or_else(demo_problem, |path| Ok(Problem::read(path)?))
}

/// The scenario of a file; without one the demo's for its problem, and none for another.
pub fn scenario_or_demo(path: Option<&Path>, problem: Option<&Path>) -> Result<Option<Scenario>, Failure> {
    match (path, problem) {
        (Some(path), _) => Ok(Some(Scenario::read(path)?)),
        (None, None) => demo_scenario().map(Some),
        (None, Some(_)) => Ok(None),
    }
}

/// A live parameter and its value, from `NAME=VALUE`. A name may hold the sign itself.
pub fn setting(text: &str) -> Result<ParameterValue, String> {
    let (name, value) = text.rsplit_once('=').ok_or("expected NAME=VALUE")?;
    let number = value.trim().parse().map_err(|_| format!("`{value}` is not a number"))?;
    Ok(ParameterValue { name: name.trim().to_string(), value: number })
}

/// Structure of the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum StructureArgument {
    /// The cheapest whose certificate keeps the tolerance.
    Auto,
    /// One 3 × 3 map per mode.
    Diagonal,
    /// One dense map.
    Block,
    /// The chapter's separated stage maps.
    Canonical,
}

impl StructureArgument {
    /// What a scenario is played through.
    pub fn options(self) -> PlayOptions {
        let structure = match self {
            Self::Diagonal => StructureChoice::Diagonal,
            Self::Block => StructureChoice::Block,
            Self::Auto | Self::Canonical => StructureChoice::Auto,
        };
        let scene = SceneOptions { structure, ..SceneOptions::default() };
        PlayOptions { chapter: self == Self::Canonical, scene, ..PlayOptions::default() }
    }
}
