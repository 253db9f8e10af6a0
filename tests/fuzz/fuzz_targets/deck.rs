//! Mesh files and decks: the first byte chooses the format. Small decks are answered too: their static steps,
//! two modes, the parts of a problem file. *INCLUDE is refused here, so that no file of the machine is read.
#![no_main]

use std::path::PathBuf;

use libfuzzer_sys::fuzz_target;
use vademecum_build::mesh;
use vademecum_deck::{FullOrder, ReadOptions, read};

/// Formats, by the end of the name of their files.
const FORMATS: [&str; 14] =
    ["inp", "bdf", "cdb", "msh", "vtk", "vtu", "mesh", "node", "stl", "obj", "ply", "off", "glb", "unv"];

/// Nodes of a deck that is answered: a factor in microseconds.
const MOST_NODES: usize = 60;

fuzz_target!(|bytes: &[u8]| {
    let Some((&first, text)) = bytes.split_first() else { return };
    let includes = text.windows(7).any(|word| word.eq_ignore_ascii_case(b"include"));
    if includes {
        return;
    }
    let format = FORMATS[usize::from(first) % FORMATS.len()];
    let path: PathBuf = std::env::temp_dir().join(format!("vademecum-fuzz-{}.{format}", std::process::id()));
    std::fs::write(&path, text).expect("a file of a few kilobytes");
    let meshed = mesh::parse_with_cells(&path, Some(6)).map(|raw| mesh::repaired(raw, 0.0));
    if let Err(error) = &meshed {
        assert!(!error.to_string().is_empty());
    }
    if !["inp", "bdf", "cdb"].contains(&format) {
        return;
    }
    let deck = match read(&path, &ReadOptions::default()) {
        Ok(deck) => deck,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return;
        }
    };
    if deck.node_count() > MOST_NODES {
        return;
    }
    let _ = deck.problem_parts(Some(1000.0));
    let model = FullOrder::new(&deck);
    if let Ok(answers) = model.static_answers() {
        assert!(answers.iter().all(|answer| !answer.displacement.is_empty()));
    }
    let _ = model.modes(2);
});
