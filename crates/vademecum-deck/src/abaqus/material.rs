//! Materials of a deck of Abaqus or CalculiX.

use vademecum_build::mesh::inp::InpCard;

use crate::abaqus::reader::Reader;
use crate::abaqus::solid::Solid;
use crate::error::DeckError;

/// Begins a material.
pub(crate) fn begin(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    let Some(name) = card.parameter("NAME") else {
        return Err(reader.fault(card, None, "no NAME", "NAME=material"));
    };
    let name = name.to_ascii_uppercase();
    reader.materials.insert(name.clone(), Solid::default());
    reader.material = Some(name);
    Ok(())
}

/// The modulus and Poisson's ratio.
pub(crate) fn elastic(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    let kind = card.parameter("TYPE").unwrap_or("ISO").to_ascii_uppercase();
    if !kind.starts_with("ISO") {
        let expected = "TYPE=ISO: other elasticity is not computed with";
        return Err(reader.fault(card, None, &format!("TYPE={kind}"), expected));
    }
    let Some(line) = card.data.first() else {
        return Err(reader.fault(card, None, "no data", "modulus, Poisson's ratio"));
    };
    let [young, poisson] = match reader.reals(card, line)?[..] {
        [young] => [young, 0.0],
        [young, poisson, ..] => [young, poisson],
        [] => return Err(reader.fault(card, Some(line), &line.text, "modulus, Poisson's ratio")),
    };
    if !(young > 0.0 && poisson > -1.0 && poisson < 0.5) {
        let expected = "a modulus above 0 and a Poisson's ratio between -1 and 0.5";
        return Err(reader.fault(card, Some(line), &line.text, expected));
    }
    if card.data.len() > 1 {
        reader.leave(card, "temperature is not computed: the first line of the table is taken");
    }
    if let Some(solid) = current(reader, card)? {
        (solid.young, solid.poisson) = (Some(young), poisson);
    }
    Ok(())
}

/// The density.
pub(crate) fn density(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    let Some(line) = card.data.first() else {
        return Err(reader.fault(card, None, "no data", "a density"));
    };
    let density = reader.reals(card, line)?.first().copied().unwrap_or(0.0);
    if density <= 0.0 {
        return Err(reader.fault(card, Some(line), &line.text, "a density above 0"));
    }
    if let Some(solid) = current(reader, card)? {
        solid.density = density;
    }
    Ok(())
}

fn current<'r>(reader: &'r mut Reader<'_>, card: &InpCard) -> Result<Option<&'r mut Solid>, DeckError> {
    match reader.material.clone() {
        Some(name) => Ok(reader.materials.get_mut(&name)),
        None => Err(reader.fault(card, None, &card.section(), "a *MATERIAL before it")),
    }
}
