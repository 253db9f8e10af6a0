//! Names of public types, and the first words of doc comments.

use std::collections::BTreeMap;

use crate::code::words;
use crate::sources::product;

/// The crate of a path below `crates/`, without `vademecum-`.
fn crate_of(path: &str) -> &str {
    let name = path.trim_start_matches("crates/").split('/').next().unwrap_or_default();
    name.trim_start_matches("vademecum-")
}

/// Public type names that stand more than once in their crate, with the files.
pub fn double_types() -> Vec<(String, String, Vec<String>)> {
    let mut places: BTreeMap<(String, String), Vec<String>> = BTreeMap::new();
    for source in product() {
        let text = source.text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
        for window in words(&source.path, text).windows(3) {
            let [visible, kind, name] = [0, 1, 2].map(|i| window[i].text.as_str());
            if visible == "pub" && ["struct", "enum", "union", "trait", "type"].contains(&kind) {
                let key = (crate_of(&source.path).to_string(), name.to_string());
                places.entry(key).or_default().push(source.path.clone());
            }
        }
    }
    let twice = places.into_iter().filter(|(_, files)| files.len() > 1);
    twice.map(|((of, name), files)| (of, name, files)).collect()
}

/// First words that make a doc comment a riddle: a noun or a verb says it shorter.
const OPENERS: [&str; 5] = ["What", "How", "Whether", "Where", "That"];

/// Share of the doc comments of each crate that open with one of these words \[%\].
pub fn shares_of_openers() -> BTreeMap<String, f64> {
    let mut counts: BTreeMap<String, [usize; 2]> = BTreeMap::new();
    for source in product() {
        let [all, open] = counts.entry(crate_of(&source.path).to_string()).or_default();
        let mut before = None;
        for line in source.text.lines() {
            let line = line.trim_start();
            let mark = ["///", "//!"].into_iter().find(|mark| line.starts_with(mark));
            if let Some(mark) = mark
                && before != Some(mark)
            {
                let first = line.trim_start_matches(mark).split_whitespace().next().unwrap_or_default();
                *all += 1;
                *open += usize::from(OPENERS.contains(&first.trim_end_matches([',', ';', ':'])));
            }
            before = mark;
        }
    }
    counts.into_iter().map(|(name, [all, open])| (name, 100.0 * open as f64 / all as f64)).collect()
}
