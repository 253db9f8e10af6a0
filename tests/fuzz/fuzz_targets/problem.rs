//! The text of a problem file: read, checked, and taken as far as the plan of its build; nothing is marched.
//! Small blocks are meshed and assembled within 200 MB; everything else must be refused before it is
//! allocated. Paths are refused here, so that no file of the machine is read.
#![no_main]

use std::path::PathBuf;

use libfuzzer_sys::fuzz_target;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildError, BuildOptions, with_context};
use vademecum_build::progress::Silent;

/// Most cells of a block that is meshed: a few milliseconds each way.
const MAX_CELLS: usize = 64;
/// Memory that a plan may use \[bytes\].
const MEMORY: u64 = 200_000_000;

fuzz_target!(|text: &[u8]| {
    let Ok(text) = std::str::from_utf8(text) else { return };
    let folder = PathBuf::from("nowhere");
    let Ok(problem) = Problem::parse(text, "fuzzed.toml", folder) else { return };
    let mesh = &problem.mesh;
    let Some(block) = &mesh.block else { return };
    // Checked before: the product does not overflow. What is large must be refused for its memory.
    let cells: usize = block.divisions.iter().product();
    let options = BuildOptions { memory: Some(MEMORY), ..BuildOptions::default() };
    let files = problem.snapshots.npy.is_some() || problem.snapshots.vtu.is_some();
    if files || (MAX_CELLS..20_000).contains(&cells) {
        return;
    }
    let planned = with_context(&problem, &options, &Silent, |context, _| context.plan(&problem));
    let planned: Result<_, BuildError> = planned;
    assert!(cells < MAX_CELLS || planned.is_err(), "{cells} cells in {MEMORY} bytes");
    // Every refusal says something, its causes too.
    if let Err(error) = planned {
        let mut next: Option<&dyn std::error::Error> = Some(&error);
        while let Some(error) = next {
            assert!(!error.to_string().is_empty());
            next = error.source();
        }
    }
});
