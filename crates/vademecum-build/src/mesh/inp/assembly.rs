//! Decks of several instances, or of moved ones, as decks without parts: each instance is a copy of its part,
//! with its name before the names of its sets, and numbers of its own.

use std::collections::BTreeMap;

use super::deck::{DataLine, InpCard};
use crate::linalg::vec3::{cross, dot, norm, sub};
use crate::mesh::error::{MeshError, shown};

/// Parameters that name a set, a surface, a node or axes of a part, without blanks.
const NAMED: [&str; 10] =
    ["NSET", "ELSET", "NAME", "ORIENTATION", "SURFACE", "REFNODE", "ROTNODE", "TIENSET", "PINNSET", "NODE"];

/// Numbers that a deck may reach once its instances are apart.
const LARGEST: u64 = 1 << 53;

/// Bytes that all copies of parts may take: so many times those of the deck, and some for small ones.
const MOST_COPIES: (usize, usize) = (64, 1 << 26);

/// Instances of one deck.
const MOST_INSTANCES: usize = 10_000;

/// A rigid motion: a rotation about a point, row by row, after a translation.
struct Motion {
    shift: [f64; 3],
    about: [f64; 3],
    turn: [[f64; 3]; 3],
}

impl Motion {
    fn turned(&self, v: [f64; 3]) -> [f64; 3] {
        self.turn.map(|row| dot(row, v))
    }

    fn moved(&self, at: [f64; 3]) -> [f64; 3] {
        let arm: [f64; 3] = std::array::from_fn(|c| at[c] + self.shift[c] - self.about[c]);
        let arm = self.turned(arm);
        std::array::from_fn(|c| arm[c] + self.about[c])
    }
}

/// An instance: its name, what its numbers have in front, and its motion.
struct Instance {
    name: String,
    offset: u64,
    motion: Motion,
}

/// True of a deck whose only instance stands where its part is, or that has none.
fn is_plain(cards: &[InpCard]) -> bool {
    let mut instances = cards.iter().filter(|card| card.keyword == "INSTANCE");
    let zero = |line: &DataLine| line.fields().iter().all(|field| field.parse() == Ok(0.0));
    instances.next().is_none_or(|first| first.data.iter().all(zero)) && instances.next().is_none()
}

/// The cards of a deck without parts and instances, and a note for each instance whose numbers change.
pub(super) fn flatten(cards: Vec<InpCard>) -> Result<(Vec<InpCard>, Vec<String>), MeshError> {
    if is_plain(&cards) {
        return Ok((cards, vec![]));
    }
    let stride = 10_u64.checked_pow(largest(&cards).to_string().len() as u32);
    let many = cards.iter().filter(|card| card.keyword == "INSTANCE").count() as u64;
    let stride = stride.filter(|stride| stride.checked_mul(many + 1).is_some_and(|most| most < LARGEST));
    let Some(stride) = stride else {
        let at = &cards[0].place;
        return Err(at.at("*NODE").malformed("numbers of nodes or elements beyond 1e15", "smaller numbers"));
    };
    let text: usize =
        cards.iter().map(|card| 16 + card.data.iter().map(|line| line.text.len()).sum::<usize>()).sum();
    let mut left = MOST_COPIES.0 * text + MOST_COPIES.1;
    let mut parts: BTreeMap<String, Vec<InpCard>> = BTreeMap::new();
    let (mut instances, mut flat, mut notes): (Vec<Instance>, Vec<InpCard>, Vec<String>) =
        (vec![], vec![], vec![]);
    let (mut part, mut inside): (Option<String>, bool) = (None, false);
    for card in cards {
        match card.keyword.as_str() {
            "PART" => part = Some(name_of(&card, "NAME")),
            "END PART" => part = None,
            "ASSEMBLY" | "END ASSEMBLY" => {}
            "END INSTANCE" => inside = false,
            "INSTANCE" => {
                let (name, of) = (name_of(&card, "NAME"), name_of(&card, "PART"));
                let Some(own) = parts.get(&of) else {
                    let found = format!("the part `{of}`");
                    return Err(card.place.at("*INSTANCE").malformed(found, "a *PART before it"));
                };
                let rest = left.checked_sub(bytes(own)).filter(|_| instances.len() < MOST_INSTANCES);
                let Some(rest) = rest else {
                    let found = format!("{} instances in one deck", instances.len() + 1);
                    let expected = "at most 10000, whose copies take 64 times the size of the deck";
                    return Err(card.place.at("*INSTANCE").malformed(found, expected));
                };
                left = rest;
                let offset = stride * (instances.len() as u64 + 1);
                let instance = Instance { motion: motion(&card)?, offset, name };
                for card in own {
                    flat.push(copied(card, &instance)?);
                }
                notes.push(format!("nodes and elements of `{}`: their numbers plus {offset}", instance.name));
                instances.push(instance);
                inside = true;
            }
            _ => match (&part, instances.last()) {
                (Some(part), _) => parts.entry(part.clone()).or_default().push(card),
                (None, Some(instance)) if inside => flat.push(copied(&card, instance)?),
                _ => flat.push(of_assembly(card, &instances)),
            },
        }
    }
    Ok((flat, notes))
}

/// Bytes that cards take, with what a line costs beside its text.
fn bytes(cards: &[InpCard]) -> usize {
    let of = |card: &InpCard| 200 + card.data.iter().map(|line| 64 + line.text.len()).sum::<usize>();
    cards.iter().map(of).sum()
}

fn name_of(card: &InpCard, key: &str) -> String {
    card.parameter(key).unwrap_or("").to_ascii_uppercase()
}

/// The largest number of a node or an element.
fn largest(cards: &[InpCard]) -> u64 {
    let meshed = cards.iter().filter(|card| matches!(card.keyword.as_str(), "NODE" | "ELEMENT"));
    let first = |line: &DataLine| line.text.split(',').next().and_then(|field| field.trim().parse().ok());
    meshed.flat_map(|card| &card.data).filter_map(first).max().unwrap_or(1)
}

/// The motion of an instance: a translation, then a rotation about a line through two points.
fn motion(card: &InpCard) -> Result<Motion, MeshError> {
    let mut numbers = Vec::new();
    for line in card.data.iter().take(2) {
        for field in line.fields() {
            let number = if field.is_empty() { Some(0.0) } else { field.parse::<f64>().ok() };
            let number = number.filter(|x| x.is_finite());
            numbers.push(number.ok_or_else(|| {
                line.place.at("*INSTANCE").malformed(shown(line.text.as_bytes()), "coordinates and an angle")
            })?);
        }
        numbers.resize(if numbers.len() <= 3 { 3 } else { 10 }, 0.0);
    }
    numbers.resize(10, 0.0);
    let at = |k: usize| [numbers[k], numbers[k + 1], numbers[k + 2]];
    let (shift, about, line, angle) = (at(0), at(3), sub(at(6), at(3)), numbers[9].to_radians());
    let length = norm(line);
    let mut turn = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    if angle != 0.0 {
        if length == 0.0 {
            let expected = "two points of a line to turn about";
            return Err(card.place.at("*INSTANCE").malformed("points that are alike", expected));
        }
        let axis = line.map(|x| x / length);
        let (sine, cosine) = angle.sin_cos();
        // Columns are the turned directions of space.
        for k in 0..3 {
            let e: [f64; 3] = std::array::from_fn(|c| f64::from(u8::from(c == k)));
            let (along, side) = (dot(axis, e), cross(axis, e));
            for c in 0..3 {
                turn[c][k] = cosine * e[c] + sine * side[c] + (1.0 - cosine) * along * axis[c];
            }
        }
    }
    Ok(Motion { shift, about, turn })
}

/// A field of a part: a number is moved up, a name has that of the instance before it.
fn local(field: &str, instance: &Instance) -> String {
    match field.trim().parse::<u64>() {
        Ok(number) => (number.saturating_add(instance.offset)).to_string(),
        Err(_) if field.trim().is_empty() => String::new(),
        Err(_) => format!("{}.{}", instance.name, field.trim()),
    }
}

/// The copy of a card of a part.
fn copied(card: &InpCard, instance: &Instance) -> Result<InpCard, MeshError> {
    let mut copy = card.clone();
    let material = card.keyword == "MATERIAL" || card.keyword == "AMPLITUDE";
    for (key, value) in &mut copy.parameters {
        if NAMED.contains(&key.replace(' ', "").as_str()) && !value.is_empty() && !material {
            *value = local(value, instance);
        }
    }
    let generated = card.parameter("GENERATE").is_some();
    // Fields of a line that are nodes, elements or sets.
    let names = |fields: &mut [String], which: &dyn Fn(usize) -> bool| {
        for (_, field) in fields.iter_mut().enumerate().filter(|(k, _)| which(*k)) {
            *field = local(field, instance);
        }
    };
    let section = card.section();
    for (index, line) in copy.data.iter_mut().enumerate() {
        let mut fields: Vec<String> = line.text.split(',').map(|field| field.trim().to_string()).collect();
        let point = |fields: &[String], first: usize| -> Result<[f64; 3], MeshError> {
            let mut at = [0.0; 3];
            for (x, field) in at.iter_mut().zip(fields.iter().skip(first)).filter(|(_, f)| !f.is_empty()) {
                let fault = || line.place.at(&section).malformed(shown(line.text.as_bytes()), "coordinates");
                *x = field.parse().map_err(|_| fault())?;
            }
            Ok(at)
        };
        let moved = |at: [f64; 3]| instance.motion.moved(at).map(|x| format!("{x:e}"));
        match card.keyword.as_str() {
            "NODE" => {
                let at = moved(point(&fields, 1)?);
                fields.resize(1, String::new());
                names(&mut fields, &|_| true);
                fields.extend(at);
            }
            "ELEMENT" => names(&mut fields, &|_| true),
            "NSET" | "ELSET" => names(&mut fields, &|k| !generated || k < 2),
            "SURFACE" | "BOUNDARY" | "CLOAD" | "DLOAD" | "DISTRIBUTING COUPLING" => {
                names(&mut fields, &|k| k == 0);
            }
            "TIE" => names(&mut fields, &|k| k < 2),
            "MPC" => names(&mut fields, &|k| k > 0),
            "EQUATION" if fields.iter().filter(|field| !field.is_empty()).count() > 1 => {
                names(&mut fields, &|k| k % 3 == 0);
            }
            "ORIENTATION" | "TRANSFORM" if index == 0 => {
                let rectangular = card.parameter("SYSTEM").or(card.parameter("TYPE"));
                let along = card.keyword == "TRANSFORM"
                    && rectangular.is_none_or(|kind| kind.eq_ignore_ascii_case("R"));
                let mut all = Vec::new();
                for first in (0..fields.len()).step_by(3) {
                    let at = point(&fields, first)?;
                    // Points of axes without an origin are directions.
                    let directed = along || (card.keyword == "ORIENTATION" && fields.len() <= 6);
                    let direction = instance.motion.turned(at).map(|x| format!("{x:e}"));
                    let cylinder = rectangular.is_some_and(|kind| kind.to_ascii_uppercase().starts_with('C'));
                    all.extend(if directed && !cylinder { direction } else { moved(at) });
                }
                fields = all;
            }
            _ => {}
        }
        line.text = fields.join(", ");
    }
    Ok(copy)
}

/// A card of the assembly or of the model: `instance.number` is a number, sets of an instance are its own.
fn of_assembly(mut card: InpCard, instances: &[Instance]) -> InpCard {
    let find = |name: &str| instances.iter().find(|known| known.name.eq_ignore_ascii_case(name));
    let named = |field: &str| {
        let (name, number) = field.trim().trim_matches('"').rsplit_once('.')?;
        // A name begins with a letter: 1.5 is a number.
        let number: u64 = number.parse().ok().filter(|_| name.starts_with(char::is_alphabetic))?;
        Some((number.saturating_add(find(name)?.offset)).to_string())
    };
    let of = card
        .parameter("INSTANCE")
        .and_then(find)
        .filter(|_| matches!(card.keyword.as_str(), "NSET" | "ELSET" | "SURFACE"));
    let generated = card.parameter("GENERATE").is_some();
    for line in &mut card.data {
        let each = line.text.split(',').enumerate().map(|(k, field)| match of {
            Some(instance) if !generated || k < 2 => local(field, instance),
            _ => named(field).unwrap_or_else(|| field.trim().to_string()),
        });
        line.text = each.collect::<Vec<_>>().join(", ");
    }
    for (_, value) in &mut card.parameters {
        if let Some(number) = named(value) {
            *value = number;
        }
    }
    card
}
