//! Case control of a Nastran deck: a step for each subcase, with its supports and loads.

use std::collections::{BTreeMap, BTreeSet};

use crate::deck::{Link, Step, StepKind, Support};
use crate::error::DeckError;
use crate::nastran::heat;
use crate::nastran::loads::{ALL, Loads, numbers};
use crate::nastran::model::{Model, components};

/// Selections of a subcase, or of all.
#[derive(Clone, Debug, Default)]
struct Selection {
    line: usize,
    name: String,
    sets: BTreeMap<&'static str, u64>,
}

/// Selections that matter.
const KEYS: [&str; 4] = ["SPC", "LOAD", "MPC", "METHOD"];

/// Takes the steps of a deck.
pub(crate) fn take(model: &mut Model<'_>) -> Result<(), DeckError> {
    let (solution, mut cases) = cases(&model.cards.executive);
    let supports = Supports::read(model)?;
    let loads = Loads::read(model)?;
    if cases.is_empty() {
        cases.push(whole(&supports, &loads));
        if !loads.is_empty() || !supports.is_empty() {
            model.deck.notes.push("the deck has no case control: all supports and loads act".into());
        }
    }
    let roots: BTreeMap<u64, usize> = roots(model)?;
    let mpc: BTreeSet<u64> = cases.iter().filter_map(|case| case.sets.get("MPC").copied()).collect();
    if mpc.len() > 1 {
        let second =
            cases.iter().find(|case| case.sets.get("MPC").is_some_and(|set| Some(set) != mpc.first()));
        let card = model.cards.bulk.iter().find(|card| card.name.starts_with("MPC"));
        if let (Some(_), Some(card)) = (second, card) {
            return Err(model.fault(card, "two MPC sets in subcases", "one set for all subcases"));
        }
    }
    equations(model, mpc.first().copied())?;
    let of_heat = |key: &str| cases.iter().filter_map(|case| case.sets.get(key).copied()).collect::<Vec<_>>();
    let (loaded, initial) = (of_heat(heat::LOADED), of_heat(heat::INITIAL));
    let temperatures = heat::Sets::read(model, &[&loaded[..], &initial[..]].concat())?;
    if !loaded.is_empty() {
        let initial = temperatures.of(model, initial.first());
        model.deck.heat = Some(heat::laws(model, initial)?);
    }
    for case in cases {
        let set = |key: &str| case.sets.get(key).copied();
        let kind = match (solution, set("METHOD")) {
            (Some(101), _) | (None, None) => StepKind::Static,
            (Some(103) | None, method) => {
                StepKind::Frequency(method.and_then(|method| roots.get(&method).copied()).filter(|n| *n > 0))
            }
            (Some(other), _) => StepKind::Other(format!("SOL {other}")),
        };
        let step = Step {
            name: case.name.clone(),
            kind,
            loads: set("LOAD").map_or_else(Vec::new, |id| loads.of(id, 1.0, 0)),
            supports: set("SPC").map_or_else(Vec::new, |id| supports.of(id, 0)),
            temperatures: temperatures.of(model, case.sets.get(heat::LOADED)),
            about: None,
            line: case.line,
        };
        model.deck.steps.push(step);
    }
    Ok(())
}

/// The solution sequence, and the subcases with what stands above them.
fn cases(lines: &[(usize, String)]) -> (Option<u32>, Vec<Selection>) {
    let (mut solution, mut above, mut found) = (None, Selection::default(), Vec::<Selection>::new());
    for (line, text) in lines {
        let text = text.split('$').next().unwrap_or("").trim().to_ascii_uppercase();
        if let Some(rest) = text.strip_prefix("SOL ") {
            let word = rest.split([' ', ',']).find(|word| !word.is_empty()).unwrap_or("");
            solution = match word {
                "SESTATIC" | "SESTATICS" => Some(101),
                "SEMODES" => Some(103),
                _ => word.parse().ok().or(Some(0)),
            };
            continue;
        }
        if let Some(name) = text.strip_prefix("SUBCASE") {
            let sets = above.sets.clone();
            found.push(Selection { line: *line, name: name.trim().to_string(), sets });
            continue;
        }
        let Some((key, value)) = text.split_once('=') else { continue };
        let plain = key.split('(').next().unwrap_or("").trim();
        let known = KEYS.into_iter().find(|known| *known == plain);
        let Some(key) = heat::key(key).or(known) else { continue };
        if let Ok(value) = value.trim().parse::<u64>() {
            let into = found.last_mut().unwrap_or(&mut above);
            into.sets.insert(key, value);
        }
    }
    if found.is_empty() && (!above.sets.is_empty() || solution.is_some()) {
        above.name = "1".into();
        found.push(above);
    }
    (solution, found)
}

/// One case with every set, of a file without case control.
fn whole(supports: &Supports, loads: &Loads) -> Selection {
    let mut case = Selection { line: 1, name: "1".into(), ..Selection::default() };
    if !supports.is_empty() {
        case.sets.insert("SPC", ALL);
    }
    if !loads.is_empty() {
        case.sets.insert("LOAD", ALL);
    }
    case
}

/// Numbers of roots that methods ask for.
fn roots(model: &mut Model<'_>) -> Result<BTreeMap<u64, usize>, DeckError> {
    let mut roots = BTreeMap::new();
    for card in model.named("EIGRL") {
        roots.insert(model.needed(card, 0)?, card.id(3)?.unwrap_or(0) as usize);
    }
    for card in model.named("EIGR") {
        roots.insert(model.needed(card, 0)?, card.id(5)?.unwrap_or(0) as usize);
    }
    Ok(roots)
}

/// Supports by set.
struct Supports {
    sets: BTreeMap<u64, Vec<Support>>,
    /// Sets that join others.
    joined: BTreeMap<u64, Vec<u64>>,
}

impl Supports {
    fn read(model: &mut Model<'_>) -> Result<Supports, DeckError> {
        let mut found = Supports { sets: BTreeMap::new(), joined: BTreeMap::new() };
        for card in model.named("SPC") {
            let set = found.sets.entry(model.needed(card, 0)?).or_default();
            for first in [1, 4] {
                let Some(node) = model.node(card, first)? else { continue };
                let value = card.real(first + 2)?.unwrap_or(0.0);
                set.extend(components(card.field(first + 1)).map(|component| Support {
                    node,
                    component,
                    value,
                }));
            }
        }
        for card in model.named("SPC1") {
            let list = &card.fields[card.fields.len().min(2)..];
            let Some(ranges) = vademecum_build::mesh::nastran::ranges(list) else {
                return Err(model.fault(
                    card,
                    &list.join(" "),
                    "numbers of grid points, or ranges with THRU",
                ));
            };
            let inside = |id: u64| ranges.iter().any(|[first, last]| (*first..=*last).contains(&id));
            let held: Vec<Support> = (0..model.deck.node_count() as u32)
                .filter(|&node| inside(model.deck.id(node)))
                .flat_map(|node| {
                    components(card.field(1)).map(move |c| Support { node, component: c, value: 0.0 })
                })
                .collect();
            found.sets.entry(model.needed(card, 0)?).or_default().extend(held);
        }
        for card in model.named("SPCADD") {
            found.joined.insert(model.needed(card, 0)?, numbers(card, 1)?);
        }
        Ok(found)
    }

    fn is_empty(&self) -> bool {
        self.sets.is_empty()
    }

    /// Supports of a set; sets that join each other in a circle end.
    fn of(&self, id: u64, depth: usize) -> Vec<Support> {
        if id == ALL {
            return self.sets.values().flatten().copied().collect();
        }
        let mut supports = self.sets.get(&id).cloned().unwrap_or_default();
        if depth < 8 {
            for &other in self.joined.get(&id).into_iter().flatten() {
                supports.extend(self.of(other, depth + 1));
            }
        }
        supports
    }
}

/// Linear equations of a set, or of all if no case selects one and there is one only.
fn equations(model: &mut Model<'_>, selected: Option<u64>) -> Result<(), DeckError> {
    let mut sets: BTreeSet<u64> = selected.into_iter().collect();
    for card in model.named("MPCADD") {
        if card.id(0)? == selected {
            sets.extend(numbers(card, 1)?);
        }
    }
    for card in model.named("MPC") {
        let id = model.needed(card, 0)?;
        if !sets.contains(&id) {
            let has_case = model.deck.steps.len() + model.cards.executive.len() > 0;
            if has_case {
                model.leave(card, "no subcase selects its set");
                continue;
            }
        }
        // Two terms a line; the first field of a continuation is blank.
        let mut terms = Vec::new();
        let mut field = 1;
        while field < card.fields.len() {
            if field % 8 == 0 {
                field += 1;
                continue;
            }
            if field % 8 == 7 {
                field += 1;
                continue;
            }
            if let Some(node) = model.node(card, field)? {
                let component = components(card.field(field + 1)).next().unwrap_or(0);
                terms.push((node, component, card.real(field + 2)?.unwrap_or(0.0)));
            }
            field += 3;
        }
        let origin = format!("MPC at line {}", card.line);
        model.deck.links.push(Link::Equation { terms, origin });
    }
    Ok(())
}
