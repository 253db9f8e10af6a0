//! Thermal expansion and temperatures of a deck of Abaqus or CalculiX.

use vademecum_build::mesh::inp::InpCard;

use crate::abaqus::loads::last_value;
use crate::abaqus::material::{ascending, current};
use crate::abaqus::reader::Reader;
use crate::abaqus::solid::Expansion;
use crate::deck::StepKind;
use crate::error::DeckError;

/// Mean coefficients of expansion.
pub(crate) fn expansion(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    let kind = card.parameter("TYPE").unwrap_or("ISO").to_ascii_uppercase();
    let count = match &kind {
        kind if kind.starts_with("ISO") => 1,
        kind if kind.starts_with("ORTHO") => 3,
        _ => {
            reader.leave(card, "expansion other than TYPE=ISO and ORTHO is not computed: there is none");
            return Ok(());
        }
    };
    if card.data.is_empty() {
        return Err(reader.fault(card, None, "no data", "a coefficient of expansion"));
    }
    let zero = card.parameter("ZERO").map_or(Ok(0.0), |zero| {
        zero.trim().parse().map_err(|_| reader.fault(card, None, zero, "ZERO=temperature"))
    })?;
    let mut rows = Vec::new();
    for line in &card.data {
        let numbers = reader.reals(card, line)?;
        let at = |k: usize| numbers.get(k).copied().unwrap_or(0.0);
        rows.push((at(count), if count == 1 { [at(0); 3] } else { [0, 1, 2].map(at) }));
    }
    let rows = ascending(reader, card, rows);
    if let Some(solid) = current(reader, card)? {
        solid.expansion = Expansion { zero, rows, along_axes: count == 3 };
    }
    Ok(())
}

/// Initial temperatures; other initial states are left out.
pub(crate) fn initial(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    let of_temperature = card.parameter("TYPE").is_some_and(|kind| kind.eq_ignore_ascii_case("TEMPERATURE"));
    if !of_temperature || !is_listed(card) {
        reader.leave(card, "initial states other than temperatures of nodes are not computed");
        return Ok(());
    }
    let mut all = take_initial(reader);
    set(reader, card, &mut all, 1.0)?;
    reader.initial = Some(all);
    Ok(())
}

/// Temperatures in a step, at its end.
pub(crate) fn temperature(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    if !is_listed(card) {
        reader.leave(card, "temperatures that are not listed in the deck do not act");
        return Ok(());
    }
    let static_step = reader.step().is_some_and(|step| step.kind == StepKind::Static);
    if !static_step {
        reader.leave(card, "temperatures act in static steps alone");
        return Ok(());
    }
    let initial = take_initial(reader);
    let anew = card.parameter("OP").is_some_and(|op| op.eq_ignore_ascii_case("NEW"));
    let before = reader.step().map(|step| std::mem::take(&mut step.temperatures));
    let mut all = before.filter(|before| !anew && !before.is_empty()).unwrap_or_else(|| initial.clone());
    reader.initial = Some(initial);
    let factor = last_value(reader, card);
    set(reader, card, &mut all, factor)?;
    if let Some(step) = reader.step() {
        step.temperatures = all;
    }
    Ok(())
}

/// False of a card whose temperatures are those of another file.
fn is_listed(card: &InpCard) -> bool {
    ["FILE", "USER", "SUBMODEL", "BSTEP"].iter().all(|key| card.parameter(key).is_none())
}

/// Initial temperatures of the nodes of the mesh, zero where the deck has none.
fn take_initial(reader: &mut Reader<'_>) -> Vec<f64> {
    let count = reader.deck.mesh.nodes.len();
    reader.initial.take().unwrap_or_else(|| vec![0.0; count])
}

/// Sets the temperatures that the lines of a card list, times a factor.
fn set(reader: &Reader<'_>, card: &InpCard, all: &mut [f64], factor: f64) -> Result<(), DeckError> {
    for line in &card.data {
        let [name, value, ..] = line.fields()[..] else {
            return Err(reader.fault(card, Some(line), &line.text, "a node or a set, and a temperature"));
        };
        let value = factor * reader.real(card, line, value)?;
        for node in reader.nodes(card, line, name)? {
            if let Some(slot) = all.get_mut(node as usize) {
                *slot = value;
            }
        }
    }
    Ok(())
}
