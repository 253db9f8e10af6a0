//! Decks of Nastran: case control and bulk data.

mod case;
mod heat;
mod links;
mod loads;
mod model;

use std::path::Path;

use vademecum_build::mesh::nastran::cards;
use vademecum_build::mesh::{MeshError, parse, repaired_deck};

use crate::deck::Deck;
use crate::error::DeckError;
use crate::nastran::model::{Model, refuse_structural};

/// Reads a deck.
pub(crate) fn read(file: &Path) -> Result<Deck, DeckError> {
    let raw = parse(file)?;
    let bytes = std::fs::read(file).map_err(|source| MeshError::Io { file: file.to_path_buf(), source })?;
    let cards = cards(file, &bytes)?;
    refuse_structural(&cards)?;
    let mesh = repaired_deck(&raw)?;
    let mut model = Model::new(file, &raw, &cards, mesh)?;
    model.materials()?;
    links::take(&mut model)?;
    case::take(&mut model)?;
    model.leave_rest();
    Ok(model.deck)
}
