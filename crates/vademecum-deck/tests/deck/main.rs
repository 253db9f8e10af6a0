//! Decks of a few elements: full-order answers, and the parts of a problem file.

mod heat;
mod motions;
mod small;

use vademecum_deck::{Deck, DeckError, FullOrder, ProblemParts, ReadOptions, StaticAnswer, System, read};

/// Reads a deck from a text.
fn deck_of(name: &str, text: &str) -> Result<Deck, DeckError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    read(&path, &ReadOptions::default())
}

fn answers(name: &str, text: &str) -> Vec<StaticAnswer> {
    let deck = deck_of(name, text).unwrap_or_else(|error| panic!("{error}"));
    FullOrder::new(&deck).static_answers().unwrap_or_else(|error| panic!("{error}"))
}

/// A bar of two bricks along x, 2 × 1 × 1, modulus 100, Poisson's ratio 0, density 3.
const BAR: &str = "\
*NODE
1,0,0,0
2,1,0,0
3,2,0,0
4,0,1,0
5,1,1,0
6,2,1,0
7,0,0,1
8,1,0,1
9,2,0,1
10,0,1,1
11,1,1,1
12,2,1,1
20,3,0.5,0.5
*ELEMENT,TYPE=C3D8,ELSET=bar
1,1,2,5,4,7,8,11,10
2,2,3,6,5,8,9,12,11
*NSET,NSET=left
1,4,7,10
*NSET,NSET=right
3,6,9,12
*SURFACE,NAME=end
2,S4
*MATERIAL,NAME=soft
*ELASTIC
100,0
*DENSITY
3
*SOLID SECTION,ELSET=bar,MATERIAL=soft
*BOUNDARY
left,1,3
";

fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-9 * expected.abs().max(1.0), "{found} for {expected}");
}

/// Displacement of a node by its number in the deck.
fn at(deck: &Deck, answer: &StaticAnswer, id: u64) -> [f64; 3] {
    let node = (0..deck.node_count() as u32).find(|&node| deck.id(node) == id).unwrap();
    answer.displacement[node as usize]
}

/// The parts of a problem file of the bar with these cards.
fn parts(cards: &str) -> ProblemParts {
    let text = format!("{BAR}{cards}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bar.inp");
    std::fs::write(&path, text).unwrap();
    let options = ReadOptions { units: Some(System::MetreKilogram), ..ReadOptions::default() };
    read(&path, &options).unwrap().problem_parts(None).unwrap()
}
