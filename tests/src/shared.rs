//! Files beside the repository that are not part of it: real meshes and reference values.

use std::path::PathBuf;

/// A path below `../shared`, relative to the repository; `None`, said aloud, where there is no such file.
#[must_use]
pub fn shared(path: &str) -> Option<PathBuf> {
    let place = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared")).join(path);
    if place.exists() {
        return Some(place);
    }
    eprintln!("skipped: no ../shared/{path}");
    None
}
