//! Temperatures of a deck, and their place in a problem file: one coefficient for each axis of space, and one
//! rise for all nodes.

use vademecum_build::fem::HeatLaw;

use crate::deck::{Deck, Step, Temperatures};

/// Takes temperatures of Abaqus and CalculiX. Where they are given, constants that depend on them are those
/// of the initial ones.
pub(crate) fn take(deck: &mut Deck, initial: Option<Vec<f64>>, laws: Vec<HeatLaw>) {
    let by_temperature = laws.iter().any(|law| law.elasticity.len() > 1);
    let Some(initial) = initial else {
        if by_temperature {
            let note = "no temperatures are given: of constants by temperature the first ones are taken";
            deck.notes.push(note.into());
        }
        return;
    };
    let mut first = vec![None; laws.len()];
    for e in 0..deck.mesh.element_count() {
        let region = deck.mesh.element_region[e] as usize;
        first[region].get_or_insert(initial[deck.mesh.element(e)[0] as usize]);
    }
    for ((material, law), temperature) in deck.materials.iter_mut().zip(&laws).zip(first) {
        if let Some(elasticity) = temperature.and_then(|temperature| law.elasticity_at(temperature)) {
            material.elasticity = elasticity;
        }
    }
    deck.heat = Some(Temperatures { laws, initial, lowered: true });
}

/// Rise of the temperature in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Rise {
    /// None, or nothing expands.
    None,
    /// The same everywhere.
    Uniform(f64),
    /// Others.
    Other,
}

/// The rise that a step has from the state without stress.
pub(crate) fn rise(deck: &Deck, step: &Step) -> Rise {
    let Some(heat) = deck.heat.as_ref().filter(|_| !step.temperatures.is_empty()) else { return Rise::None };
    let expanding = heat.laws.iter().filter(|law| law.expansion.iter().any(|row| row.1 != [[0.0; 3]; 3]));
    let zeros: Vec<f64> = expanding.map(|law| law.zero).collect();
    let Some(&zero) = zeros.first() else { return Rise::None };
    if heat.initial.is_empty() && zeros.iter().any(|other| *other != zero) {
        return Rise::Other;
    }
    let before = |node: usize| heat.initial.get(node).copied().unwrap_or(zero);
    let mut rises = step.temperatures.iter().enumerate().map(|(node, now)| now - before(node));
    let Some(first) = rises.next() else { return Rise::None };
    match (rises.all(|other| other == first), first) {
        (true, 0.0) => Rise::None,
        (true, _) => Rise::Uniform(first),
        _ => Rise::Other,
    }
}

/// The coefficients of a region as a line of its material; empty where it has none.
pub(crate) fn expansion(deck: &Deck, region: usize) -> String {
    let coefficients = deck.heat.as_ref().and_then(|heat| heat.laws.get(region)?.expansion.first());
    let Some((_, own)) = coefficients.filter(|(_, own)| *own != [[0.0; 3]; 3]) else { return String::new() };
    let [x, y, z] = [0, 1, 2].map(|c| own[c][c]);
    match x == y && y == z {
        true => format!("expansion = {x:e} # 1/K\n"),
        false => format!("expansion = [{x:e}, {y:e}, {z:e}] # 1/K\n"),
    }
}

/// Thermal constants that a problem file does not hold.
pub(crate) fn missing(deck: &Deck) -> Vec<String> {
    let laws = || deck.heat.iter().flat_map(|heat| &heat.laws);
    let mut missing = vec![];
    if laws().any(|law| law.elasticity.len() > 1) {
        missing.push("elastic constants by temperature: bodies have those of the initial one".into());
    }
    if laws().any(|law| law.expansion.len() > 1) {
        missing.push("coefficients of expansion by temperature: bodies have the first one".into());
    }
    // A turned solid has the same coefficients but for rounding.
    let skew = |own: &[[f64; 3]; 3]| {
        let size = own.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
        (0..9).any(|at| at / 3 != at % 3 && own[at / 3][at % 3].abs() > 1e-12 * size)
    };
    if laws().any(|law| law.expansion.first().is_some_and(|row| skew(&row.1))) {
        missing.push("shear of an expansion along other axes than those of space".into());
    }
    missing
}
