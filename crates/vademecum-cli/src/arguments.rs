//! Arguments that several commands take, and what they mean without them.

use std::path::{Path, PathBuf};

use vademecum_build::input::Problem;
use vademecum_eval::{SceneOptions, StructureChoice};
use vademecum_study::player::PlayOptions;
use vademecum_study::scenario::Scenario;

use crate::failure::Failure;

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
        PlayOptions { chapter: self == Self::Canonical, scene }
    }
}

/// A size of memory: a number with K, M, G or T behind it (powers of 1000), or bytes.
pub fn size(text: &str) -> Result<u64, String> {
    let text = text.trim().trim_end_matches(['B', 'b']);
    let units = [("K", 1e3), ("M", 1e6), ("G", 1e9), ("T", 1e12)];
    let upper = text.to_uppercase();
    let (number, unit) = units
        .iter()
        .find_map(|(name, unit)| Some((upper.strip_suffix(name)?, *unit)))
        .unwrap_or((&upper, 1.0));
    match number.trim().parse::<f64>() {
        Ok(value) if value > 0.0 && value * unit < 1e18 => Ok((value * unit) as u64),
        _ => Err("expected a size of memory such as 8G, 500M or a number of bytes".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::size;

    #[test]
    fn sizes_of_memory_are_read() {
        assert_eq!(size("8G"), Ok(8_000_000_000));
        assert_eq!(size("1.5 gb"), Ok(1_500_000_000));
        assert_eq!(size("4096"), Ok(4096));
        for bad in ["", "G", "-1G", "nan", "inf", "1e30", "0", "8X"] {
            assert!(size(bad).is_err(), "{bad}");
        }
    }
}
