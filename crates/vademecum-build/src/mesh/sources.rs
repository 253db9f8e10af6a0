//! Which files a mesh is read from.

use std::path::{Path, PathBuf};

use super::nastran;

/// Most files that are followed, as when a deck is read.
const MAX_FILES: usize = 1000;

/// The files that reading a mesh file reads: itself, the other one of a TetGen pair, and what a deck of
/// Abaqus, CalculiX or Nastran includes, whether they are there or not. Only the lines that include are
/// looked at.
pub(crate) fn sources(path: &Path) -> Vec<PathBuf> {
    let mut found = vec![path.to_path_buf()];
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    if ["node", "ele"].contains(&extension.as_str()) {
        found.extend(["node", "ele"].map(|other| path.with_extension(other)));
    }
    let is_of_nastran = ["bdf", "nas", "fem"].contains(&extension.as_str());
    let mut next = 0;
    while next < found.len().min(MAX_FILES) {
        let file = found[next].clone();
        next += 1;
        for included in included_by(&file, is_of_nastran) {
            let included = file.parent().unwrap_or(Path::new("")).join(included);
            if !found.contains(&included) {
                found.push(included);
            }
        }
    }
    found
}

/// The files that a Nastran deck includes, or the values of `INPUT` on the keyword lines of another one;
/// nothing of a file that is none. What a Nastran deck includes is one too, whatever its name.
fn included_by(path: &Path, is_of_nastran: bool) -> Vec<String> {
    if !std::fs::metadata(path).is_ok_and(|found| found.is_file()) {
        return vec![];
    }
    let text = std::fs::read(path).unwrap_or_default();
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&text);
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    if ["bdf", "nas", "fem", "dat"].contains(&extension.as_str()) || is_of_nastran {
        let included = nastran::inclusions(text);
        if !included.is_empty() {
            return included;
        }
    }
    if text.trim_ascii_start().first() != Some(&b'*') {
        return vec![];
    }
    let text = String::from_utf8_lossy(text);
    let mut lines = text.lines();
    let mut found = vec![];
    while let Some(line) = lines.next() {
        if !line.starts_with('*') || line.starts_with("**") {
            continue;
        }
        // A keyword goes on after a comma at the end of its line.
        let mut line = line.trim_end().to_string();
        while line.ends_with(',') {
            let Some(more) = lines.next() else { break };
            line.push_str(more.trim_end());
        }
        let values = line.split(',').filter_map(|part| part.split_once('='));
        let inputs = values.filter(|(key, _)| key.trim().eq_ignore_ascii_case("input"));
        found.extend(inputs.map(|(_, value)| value.trim().trim_matches('"').to_string()));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deck_names_what_it_includes_and_a_pair_its_other_half() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("a.inp"), "*Heading\n*Include, Input=b.inp\n*NODE,\n input=\"c.txt\"\n1,0,0,0\n")
            .unwrap();
        std::fs::write(at("b.inp"), "** INPUT=no.inp\n*INCLUDE, INPUT=a.inp\n").unwrap();
        assert_eq!(sources(&at("a.inp")), [at("a.inp"), at("b.inp"), at("c.txt")]);
        std::fs::write(at("a.bdf"), "CEND\nINCLUDE 'b.txt'\nBEGIN BULK\ninclude \"c d.bdf\" $ x\n").unwrap();
        std::fs::write(at("b.txt"), "$\nINCLUDE 'deep/\n  e.bdf'\n").unwrap();
        assert_eq!(sources(&at("a.bdf")), [at("a.bdf"), at("b.txt"), at("c d.bdf"), at("deep/e.bdf")]);
        assert!(sources(&at("x.ele")).contains(&at("x.node")));
        assert_eq!(sources(&at("none.msh")), [at("none.msh")]);
    }
}
