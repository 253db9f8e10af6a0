//! Decks of Abaqus and CalculiX.

mod attach;
mod cards;
mod heat;
mod loads;
mod material;
mod reader;
mod solid;

use std::path::Path;

use vademecum_build::mesh::inp::{Dialect, read_contents};
use vademecum_build::mesh::repaired_apart;

use crate::abaqus::reader::Reader;
use crate::deck::Deck;
use crate::error::DeckError;

/// Reads a deck.
pub(crate) fn read(file: &Path, dialect: Option<Dialect>) -> Result<Deck, DeckError> {
    let (raw, contents) = read_contents(file, dialect)?;
    let mesh = repaired_apart(&raw)?;
    let mut reader = Reader::new(file, &raw, &contents, mesh)?;
    for card in &contents.cards {
        cards::take(&mut reader, card)?;
    }
    reader.finish(dialect.is_some())
}
