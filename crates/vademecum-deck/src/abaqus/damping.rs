//! Damping of a deck of Abaqus or CalculiX.

use vademecum_build::mesh::inp::InpCard;

use crate::abaqus::reader::Reader;
use crate::deck::{Step, StepKind};
use crate::error::DeckError;

/// Natural modes that a deck may give a damping ratio.
const MODES: usize = 100_000;

/// Damping proportional to mass and stiffness, of a material or of the whole model.
pub(crate) fn proportional(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    let number = |key: &str| match card.parameter(key) {
        Some(value) => {
            let number = value.parse::<f64>().ok().filter(|x| *x >= 0.0 && x.is_finite());
            number.ok_or_else(|| {
                reader.fault(card, None, &format!("{key}={value}"), "a number that is not below 0")
            })
        }
        None => Ok(0.0),
    };
    let (alpha, beta) = (number("ALPHA")?, number("BETA")?);
    if card.parameter("STRUCTURAL").is_some() {
        reader.leave(card, "structural damping does not act: only ALPHA and BETA are taken");
    }
    if card.keyword == "GLOBAL DAMPING" {
        reader.deck.damping.alpha += alpha;
        reader.deck.damping.beta += beta;
    } else if let Some(name) = reader.material.clone() {
        reader.dampings.insert(name, [alpha, beta]);
    }
    reader.leave_damping(card);
    Ok(())
}

/// Damping of natural modes: ratios of ranges of modes, or one pair of Rayleigh's coefficients. That of the
/// first motion, or harmonic step, is that of the model.
pub(crate) fn modal(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    let damped = |step: &Step| matches!(step.kind, StepKind::Dynamic(_) | StepKind::Harmonic(_));
    if reader.deck.steps.iter().filter(|step| damped(step)).count() > 1 {
        reader.leave(card, "damping is that of the first motion or harmonic step");
        return Ok(());
    }
    let viscous = card.parameter("VISCOUS").unwrap_or("").to_ascii_uppercase();
    let rayleigh = card.parameter("RAYLEIGH").is_some() || viscous == "RAYLEIGH";
    if card.parameter("STRUCTURAL").is_some() || card.parameter("DEFINITION").is_some() {
        reader.leave(card, "only damping ratios and Rayleigh damping by numbers of modes are taken");
        return Ok(());
    }
    let (mut ratios, mut pairs) = (vec![], vec![]);
    for line in &card.data {
        let numbers = reader.reals(card, line)?;
        let number = |k: usize| numbers.get(k).copied().unwrap_or(0.0);
        let expected = "modes from 1 on, and damping that is not below 0";
        let fault = |reader: &Reader<'_>| Err(reader.fault(card, Some(line), &line.text, expected));
        if numbers.iter().skip(2).any(|x| *x < 0.0) {
            return fault(reader);
        }
        if rayleigh {
            pairs.push([number(2), number(3)]);
            continue;
        }
        // Abaqus takes a last mode of zero as the first one, and both programs number modes from 1.
        let (from, to) = (number(0), if number(1) == 0.0 { number(0) } else { number(1) });
        if !(from >= 1.0 && to >= from && to <= MODES as f64) {
            return fault(reader);
        }
        if ratios.len() < to as usize {
            ratios.resize(to as usize, 0.0);
        }
        ratios[from as usize - 1..to as usize].fill(number(2));
    }
    if pairs.iter().any(|pair| *pair != pairs[0]) {
        reader.leave(card, "Rayleigh damping that differs between modes does not act");
        return Ok(());
    }
    if let Some([alpha, beta]) = pairs.first() {
        reader.deck.damping.alpha += alpha;
        reader.deck.damping.beta += beta;
    }
    if !ratios.is_empty() {
        reader.deck.damping.ratios = ratios;
    }
    reader.leave_damping(card);
    Ok(())
}

/// Adds the damping of materials to that of the model: it acts in motions that are no sums of modes, and is
/// one number for the whole model.
pub(crate) fn of_materials(reader: &mut Reader<'_>) {
    let of = |name: &str| reader.dampings.get(&name.to_ascii_uppercase()).copied().unwrap_or_default();
    let each: Vec<[f64; 2]> = reader.sections.iter().map(|section| of(&section.material)).collect();
    let (Some(&[alpha, beta]), true) = (each.first(), each.iter().any(|one| *one != [0.0; 2])) else {
        return;
    };
    let direct = reader.deck.dynamic().is_some_and(|dynamic| !dynamic.modal);
    let note = if !direct {
        "*DAMPING of materials acts in *DYNAMIC, and not in sums of modes"
    } else if each.iter().any(|one| *one != [alpha, beta]) {
        "*DAMPING does not act: it differs between materials, and a body has one"
    } else {
        reader.deck.damping.alpha += alpha;
        reader.deck.damping.beta += beta;
        return;
    };
    reader.deck.notes.push(note.into());
}
