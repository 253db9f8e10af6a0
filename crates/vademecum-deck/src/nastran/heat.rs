//! Temperatures of a Nastran deck.

use vademecum_build::fem::HeatLaw;

use crate::deck::{NodeNumber, Temperatures};
use crate::error::DeckError;
use crate::nastran::model::Model;

/// Keys under which the sets of a subcase are kept.
pub(crate) const LOADED: &str = "TEMPERATURE";
pub(crate) const INITIAL: &str = "INITIAL";

/// The key of a selection, such as `TEMPERATURE(LOAD)`; none of other cards. Without an option it is that of
/// the load, and that of the materials does not matter.
pub(crate) fn key(text: &str) -> Option<&'static str> {
    let (name, option) = text.split_once('(').unwrap_or((text, "BOTH"));
    let option = option.trim_matches([' ', ')']);
    match (name.trim().starts_with("TEMP"), option) {
        (true, "LOAD" | "BOTH") => Some(LOADED),
        (true, "INITIAL" | "INIT") => Some(INITIAL),
        _ => None,
    }
}

/// Temperatures of sets: number, grid point, value; of no grid point, that of all others.
pub(crate) struct Sets(Vec<(u64, Option<NodeNumber>, f64)>);

impl Sets {
    /// Reads all of them; what `selected` does not have is listed.
    pub(crate) fn read(model: &mut Model<'_>, selected: &[u64]) -> Result<Sets, DeckError> {
        const UNUSED: &str = "no subcase selects its set";
        let mut sets = Vec::new();
        for card in model.named("TEMP") {
            let id = model.needed(card, 0)?;
            for first in [1, 3, 5] {
                if let (Some(node), Some(value)) = (model.node(card, first)?, card.real(first + 1)?) {
                    sets.push((id, Some(node), value));
                }
            }
            if !selected.contains(&id) {
                model.leave(card, UNUSED);
            }
        }
        for card in model.named("TEMPD") {
            for first in [0, 2, 4, 6] {
                let (Some(id), Some(value)) = (card.id(first)?, card.real(first + 1)?) else { continue };
                sets.push((id, None, value));
                if !selected.contains(&id) {
                    model.leave(card, UNUSED);
                }
            }
        }
        Ok(Sets(sets))
    }

    /// Temperatures of all nodes of the mesh; none of no set.
    pub(crate) fn of(&self, model: &Model<'_>, id: Option<&u64>) -> Vec<f64> {
        let own = || self.0.iter().filter(|(set, ..)| Some(set) == id);
        if own().next().is_none() {
            return vec![];
        }
        let all = own().find(|(_, node, _)| node.is_none()).map_or(0.0, |row| row.2);
        let mut found = vec![all; model.deck.mesh.nodes.len()];
        for &(_, node, value) in own() {
            if let Some(slot) = node.and_then(|node| found.get_mut(node as usize)) {
                *slot = value;
            }
        }
        found
    }
}

/// Expansion of all regions, from the initial temperatures, or else from those of reference on.
pub(crate) fn laws(model: &mut Model<'_>, initial: Vec<f64>) -> Result<Temperatures, DeckError> {
    let mut of_material = Vec::new();
    for card in model.named("MAT1") {
        let [coefficient, zero] = [5, 6].map(|field| card.real(field));
        let (coefficient, zero) = (coefficient?.unwrap_or(0.0), zero?.unwrap_or(0.0));
        let expansion = vec![(zero, HeatLaw::along([coefficient; 3], None))];
        of_material.push((model.needed(card, 0)?, HeatLaw { zero, expansion, elasticity: vec![] }));
    }
    for (name, first) in [("MAT9", 23), ("MAT11", 11)] {
        for card in model.named(name) {
            if (0..3).any(|k| card.real(first + k).is_ok_and(|value| value.is_some_and(|a| a != 0.0))) {
                model.leave(card, "its thermal expansion is not computed: there is none");
            }
        }
    }
    let mut of_property = Vec::new();
    for card in model.named("PSOLID") {
        of_property.push((model.needed(card, 0)?, model.needed(card, 1)?));
    }
    let of_region = |tag: i64| {
        let (_, material) = of_property.iter().find(|(id, _)| *id == tag as u64)?;
        Some(of_material.iter().find(|(id, _)| id == material)?.1.clone())
    };
    let laws =
        model.deck.mesh.regions.iter().map(|region| of_region(region.tag).unwrap_or_default()).collect();
    Ok(Temperatures { laws, initial, lowered: false })
}
