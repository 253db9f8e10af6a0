//! Cards that are not taken, and the consequence of each.

use std::path::PathBuf;

use serde::Serialize;

/// A card that was not taken.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// The card as the deck spells it.
    pub card: String,
    /// The file.
    pub file: PathBuf,
    /// The line of the first one, counted from 1.
    pub line: usize,
    /// Number of such cards.
    pub count: usize,
    /// Consequence for the result.
    pub meaning: String,
    /// True if it is a table of a problem file all the same.
    #[serde(skip)]
    pub in_problem: bool,
}

/// Consequence of damping for answers at full order.
pub(crate) const UNDAMPED: &str =
    "damping does not act in static answers and in undamped natural frequencies";

/// Adds a card to the list; equal cards with one meaning are counted.
pub(crate) fn leave_out(list: &mut Vec<LeftOut>, (file, line): (PathBuf, usize), card: &str, meaning: &str) {
    match list.iter_mut().find(|known| known.card == card && known.meaning == meaning) {
        Some(known) => known.count += 1,
        None => list.push(LeftOut {
            card: card.into(),
            file,
            line,
            count: 1,
            meaning: meaning.into(),
            in_problem: false,
        }),
    }
}
