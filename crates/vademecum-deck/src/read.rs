//! Readers by format.

use std::path::Path;

use vademecum_build::mesh::inp::Dialect;
use vademecum_build::mesh::{self, LS_DYNA_EXTENSIONS};

use crate::deck::Deck;
use crate::error::DeckError;
use crate::units::{System, Units};
use crate::{abaqus, ansys, nastran};

/// Choices of a user that a deck does not tell.
#[derive(Clone, Copy, Debug, Default)]
pub struct ReadOptions {
    /// Program whose meaning element names have; none: found from the cards.
    pub dialect: Option<Dialect>,
    /// Units of the deck; none: guessed from modulus and density.
    pub units: Option<System>,
}

/// True of the name of a deck: one that ends in `.inp`, `.bdf`, `.nas`, `.dat` or `.cdb`, or of a deck that
/// is refused by name.
pub fn is_deck(file: &Path) -> bool {
    ["inp", "bdf", "nas", "dat", "cdb"]
        .iter()
        .chain(&LS_DYNA_EXTENSIONS)
        .any(|known| *known == extension(file))
}

fn extension(file: &Path) -> String {
    file.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase()
}

/// Reads a deck.
///
/// # Errors
/// [`DeckError`]: a file that cannot be read, cards that cannot be used, elements that are no solids.
pub fn read(file: &Path, options: &ReadOptions) -> Result<Deck, DeckError> {
    let extension = extension(file);
    if LS_DYNA_EXTENSIONS.contains(&extension.as_str()) {
        // The mesh reader names the format.
        mesh::parse(file)?;
    }
    let mut deck = match extension.as_str() {
        "bdf" | "nas" | "dat" => nastran::read(file)?,
        "cdb" => ansys::read(file)?,
        _ => abaqus::read(file, options.dialect)?,
    };
    deck.check_rotations()?;
    deck.units = match options.units {
        Some(system) => Units { system: Some(system), guessed: false },
        None => {
            let heaviest = deck.materials.iter().max_by(|a, b| a.density.total_cmp(&b.density));
            heaviest.map_or(Units::guessed(None), |material| {
                Units::guess(material.elasticity.modulus(), material.density)
            })
        }
    };
    Ok(deck)
}
