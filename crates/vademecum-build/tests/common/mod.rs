//! Meshes of other projects. Their licences vary, so they lie beside the repository, in `../shared/meshes`,
//! and not in it.

use std::path::PathBuf;

/// The folder. Where it is absent, the test that asks is skipped with a message, except in CI, where that is
/// a failure.
///
/// # Panics
/// If the folder is absent and the variable `CI` is set.
pub fn real_meshes() -> Option<PathBuf> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/meshes"));
    if folder.is_dir() {
        return Some(folder);
    }
    let why =
        "there is no folder shared/meshes beside the repository (fixtures/README.md tells what it holds)";
    assert!(std::env::var_os("CI").is_none(), "{why}; CI must have it");
    eprintln!("skipped: {why}");
    None
}
