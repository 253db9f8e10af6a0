//! Files beside the repository that are not part of it: real meshes and reference values.

use std::path::PathBuf;

/// A path below `../shared`, relative to the repository. Where there is no such file, the test that asks is
/// skipped with a message, except in CI, where that is a failure.
///
/// # Panics
/// If there is no such file and the variable `CI` is set.
#[must_use]
pub fn shared(path: &str) -> Option<PathBuf> {
    let place = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared")).join(path);
    if place.exists() {
        return Some(place);
    }
    let why =
        format!("there is no shared/{path} beside the repository (fixtures/README.md tells what it holds)");
    assert!(std::env::var_os("CI").is_none(), "{why}; CI must have it");
    eprintln!("skipped: {why}");
    None
}
