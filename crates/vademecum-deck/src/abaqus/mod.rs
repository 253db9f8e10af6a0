//! Decks of Abaqus and CalculiX.

mod attach;
mod cards;
mod damping;
mod heat;
mod loads;
mod material;
mod reader;
mod solid;

use std::path::Path;

use vademecum_build::mesh::inp::{Dialect, read_contents};
use vademecum_build::mesh::repaired_deck;

use crate::abaqus::reader::{Reader, refuse_structural};
use crate::deck::Deck;
use crate::error::DeckError;

/// Reads a deck.
pub(crate) fn read(file: &Path, dialect: Option<Dialect>) -> Result<Deck, DeckError> {
    let (raw, contents) = read_contents(file, dialect)?;
    refuse_structural(&contents)?;
    let mesh = repaired_deck(&raw)?;
    let mut reader = Reader::new(file, &raw, &contents, mesh)?;
    for card in &contents.cards {
        cards::take(&mut reader, card)?;
    }
    damping::of_materials(&mut reader);
    reader.finish(dialect.is_some())
}
