//! The files of the repository.

use std::path::{Path, PathBuf};

use vademecum_tests::program::repository;

/// A file: its path from the root of the repository, with `/`, and what it holds.
pub struct Source {
    pub path: String,
    pub text: String,
}

/// All files with this extension, by path. Hidden folders, what git ignores at the root, and folders of build
/// results are left out, and so are links to files.
pub fn files(extension: &str) -> Vec<Source> {
    let root = repository();
    let ignored = std::fs::read_to_string(root.join(".gitignore")).expect("a list");
    let ignored: Vec<&str> = ignored.lines().map(|line| line.trim_matches('/')).collect();
    let mut found = vec![];
    walk(&root, &mut |path| {
        // What a link leads to is read where it is.
        if path.is_symlink() {
            return false;
        }
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let below = path.strip_prefix(&root).expect("below the root").to_string_lossy().replace('\\', "/");
        if path.is_dir() {
            return !name.starts_with('.') && name != "target" && !ignored.contains(&below.as_str());
        }
        if path.extension().is_some_and(|e| e == extension) {
            found.push(Source { path: below, text: std::fs::read_to_string(path).expect("UTF-8") });
        }
        false
    });
    found.sort_by(|a, b| a.path.cmp(&b.path));
    assert!(!found.is_empty(), "no *.{extension} at all");
    found
}

/// Shows every file and folder to `enter`, which tells whether to go into it.
fn walk(folder: &Path, enter: &mut impl FnMut(&Path) -> bool) {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    paths.sort();
    for path in paths {
        if enter(&path) {
            walk(&path, enter);
        }
    }
}

/// The text of one file of the repository.
pub fn read(path: &str) -> String {
    std::fs::read_to_string(repository().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// Sources of the product: below `crates/*/src`, without files of tests.
pub fn product() -> Vec<Source> {
    let mut sources = files("rs");
    sources.retain(|s| s.path.starts_with("crates/") && s.path.contains("/src/") && !is_test_file(&s.path));
    sources
}

/// A file that holds tests only, by its name.
pub fn is_test_file(path: &str) -> bool {
    let name = path.rsplit('/').next().unwrap_or_default();
    name == "tests.rs" || name.ends_with("_tests.rs") || path.contains("/tests/")
}

/// Fails with a list.
pub fn none(what: &str, found: &[String]) {
    assert!(found.is_empty(), "{what}: {}\n{}", found.len(), found.join("\n"));
}
