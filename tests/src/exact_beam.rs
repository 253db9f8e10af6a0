//! A small body with exact steps, built when it is asked for.

use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;

/// The short beam, four natural modes moved exactly, with what they leave out of static answers.
///
/// # Panics
/// If the builder refuses it.
#[must_use]
pub fn exact_beam() -> Vec<u8> {
    let text = include_str!("../../fixtures/problems/short-beam.toml")
        .replace("scheme = { name = \"bathe\" }", "scheme = { name = \"exact\" }")
        .replace("modes = 4", "kind = \"modes\"\nmodes = 4");
    let problem = Problem::parse(&text, "short-beam.toml", PathBuf::new()).expect("a problem");
    build(&problem, &BuildOptions::default(), &Silent).expect("built").either().bytes
}
