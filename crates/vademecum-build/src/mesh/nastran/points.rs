//! Grid points as their cards have them.

use super::cards::{Card, Cards};
use crate::mesh::error::MeshError;

/// A `GRID` card with the defaults of `GRDSET`.
#[derive(Clone, Debug, PartialEq)]
pub struct GridPoint {
    /// Number.
    pub id: u64,
    /// Coordinate system of the position (CP).
    pub system: u64,
    /// Position in that system; angles in degrees.
    pub position: [f64; 3],
    /// Coordinate system of displacements (CD); none for a point of a fluid.
    pub displacements: Option<u64>,
    /// Digits of the directions that are held permanently (PS).
    pub held: String,
    /// Index of the card in the bulk data.
    pub card: usize,
}

/// The grid points of a model, in order.
///
/// # Errors
/// [`MeshError`] with file and line if a card is malformed.
pub fn grid_points(cards: &Cards) -> Result<Vec<GridPoint>, MeshError> {
    let defaults = cards.bulk.iter().find(|card| card.name == "GRDSET");
    let grids = cards.bulk.iter().enumerate().filter(|(_, card)| card.name == "GRID");
    grids.map(|(index, card)| grid_point(index, card, defaults)).collect()
}

fn grid_point(index: usize, card: &Card, defaults: Option<&Card>) -> Result<GridPoint, MeshError> {
    let id = card.id(0)?.ok_or_else(|| card.malformed("no number", "GRID: number, system, x, y, z"))?;
    // A field, from GRDSET where it is blank.
    let source = |field: usize| defaults.filter(|_| card.field(field).is_empty()).unwrap_or(card);
    let mut position = [0.0; 3];
    for (k, x) in position.iter_mut().enumerate() {
        *x = card.real(2 + k)?.unwrap_or(0.0);
    }
    let displacements = match source(5).field(5) {
        "-1" => None,
        _ => Some(source(5).id(5)?.unwrap_or(0)),
    };
    let held = source(6).field(6).to_string();
    Ok(GridPoint { id, system: source(1).id(1)?.unwrap_or(0), position, displacements, held, card: index })
}
