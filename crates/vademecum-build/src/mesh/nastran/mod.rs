//! Nastran bulk data: the solids, their properties, and the points that are held.
//!
//! The cards themselves, coordinate systems and lists are public, for those who read loads and materials.

mod cards;
mod lists;
mod points;
mod systems;

use std::collections::{BTreeMap, HashSet};
use std::path::Path;

use super::degenerate::MISSING;
use super::error::{FaultSite, MeshError, shown};
use super::groups::Groups;
use super::place::Location;
use super::ranges::IdRanges;
use super::raw::{NodeIndex, RawMesh};
use super::solids::{Solids, passed_over};
use super::{ElementKind, Hexahedra};

pub(crate) use cards::inclusions;
pub use cards::{Card, Cards, cards, number};
pub use lists::ranges;
pub use points::{GridPoint, grid_points};
pub use systems::{Systems, systems};

/// Elements, connectors and masses beside the solids.
const OTHERS: [&str; 70] = [
    "CAABSF", "CACINF3", "CACINF4", "CBAR", "CBEAM", "CBEAM3", "CBEND", "CBUSH", "CBUSH1D", "CBUSH2D",
    "CDAMP1", "CDAMP2", "CDAMP3", "CDAMP4", "CDAMP5", "CELAS1", "CELAS2", "CELAS3", "CELAS4", "CFAST",
    "CGAP", "CHACAB", "CHACBR", "CHBDYE", "CHBDYG", "CHBDYP", "CIFHEX", "CIFPENT", "CIFQUAD", "CMASS1",
    "CMASS2", "CMASS3", "CMASS4", "CONM1", "CONM2", "CONROD", "CONV", "CPLSTN3", "CPLSTN4", "CPLSTS3",
    "CPLSTS4", "CQUAD", "CQUAD4", "CQUAD8", "CQUADR", "CQUADX", "CRAC2D", "CRAC3D", "CROD", "CSEAM",
    "CSHEAR", "CTRAX3", "CTRAX6", "CTRIA3", "CTRIA6", "CTRIAR", "CTRIAX", "CTRIAX6", "CTUBE", "CVISC",
    "CWELD", "GENEL", "MPC", "PLOTEL", "RBAR", "RBE1", "RBE2", "RBE3", "RROD", "RTRPLT",
];

/// Reads the solids of a Nastran file.
pub(crate) fn parse(file: &Path, bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let found = cards(file, bytes)?;
    let mut raw = RawMesh::new(file, "Nastran bulk data");
    let index = read_points(&found, &mut raw)?;
    if raw.nodes.is_empty() {
        let at = FaultSite { file, place: Location::Whole, section: "the bulk data" };
        return Err(at.malformed("no GRID card", "grid points"));
    }
    held_points(&found, &mut raw)?;
    let mut solids = Solids::default();
    let mut numbers = HashSet::new();
    let mut others: BTreeMap<String, usize> = BTreeMap::new();
    let formulations = properties(&found, &mut raw)?;
    for card in &found.bulk {
        let Some(kind) = solid(&card.name) else {
            if OTHERS.contains(&card.name.as_str()) {
                *others.entry(card.name.clone()).or_default() += 1;
            }
            continue;
        };
        let (number, region, nodes) = element(card, kind, &index)?;
        if !numbers.insert(number) {
            return Err(card.malformed(format!("element {number} a second time"), "every number once"));
        }
        let tag = region as i64;
        let kind = solids.push(&mut raw, kind, &nodes, tag, card.place());
        raw.region_names.entry(tag).or_insert_with(|| format!("PSOLID {region}"));
        if let (Some(ElementKind::Hex8 | ElementKind::Hex20), Some(named)) = (kind, formulations.get(&region))
        {
            raw.hexahedra.insert(tag, *named);
        }
    }
    raw.notes.extend(passed_over(&others));
    solids.finish(&mut raw);
    Ok(raw)
}

/// Takes over the grid points, in basic coordinates.
fn read_points(found: &Cards, raw: &mut RawMesh) -> Result<NodeIndex, MeshError> {
    let points = grid_points(found)?;
    let systems = systems::systems_of(found, &points)?;
    let mut index = NodeIndex::default();
    for point in &points {
        let Some(card) = found.bulk.get(point.card) else { continue };
        let place = systems.point(point.system, point.position);
        let Some(place) = place.filter(|place| place.iter().all(|x| x.is_finite())) else {
            return Err(card.malformed(format!("coordinate system {}", point.system), systems::DEFINED));
        };
        // A point may be repeated as it is, for instance by files that share an interface.
        if let Some(known) = index.get(point.id).and_then(|known| raw.nodes.get(known as usize))
            && *known == place
        {
            continue;
        }
        index.insert(point.id, raw.nodes.len(), &card.at())?;
        raw.nodes.push(place);
        raw.node_ids.push(point.id);
    }
    Ok(index)
}

/// Kind of a solid with all its nodes, by the name of its card.
fn solid(name: &str) -> Option<ElementKind> {
    Some(match name {
        "CTETRA" => ElementKind::Tet10,
        "CHEXA" => ElementKind::Hex20,
        "CPENTA" => ElementKind::Wedge15,
        "CPYRAM" | "CPYRA" => ElementKind::Pyramid13,
        _ => return None,
    })
}

/// Places of Nastran's nodes in our order: it has the middles of the upright edges before those of the top.
fn order(kind: ElementKind) -> &'static [usize] {
    match kind {
        ElementKind::Hex20 => &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15],
        ElementKind::Wedge15 => &[0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11],
        _ => &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12],
    }
}

/// Number, property and nodes of a solid.
fn element(card: &Card, kind: ElementKind, index: &NodeIndex) -> Result<(u64, u64, Vec<u32>), MeshError> {
    let expected = || {
        let (corners, all) = (kind.corners(), kind.nodes());
        format!("{}: number, property, {corners} corners, up to {} middles", card.name, all - corners)
    };
    let number = card.id(0)?.ok_or_else(|| card.malformed("no number", expected()))?;
    let property = card.id(1)?.unwrap_or(number);
    if i64::try_from(property).is_err() {
        return Err(card.malformed(format!("property {property}"), "a smaller number"));
    }
    if card.fields.len() > 2 + kind.nodes() {
        return Err(card.malformed(format!("{} nodes", card.fields.len() - 2), expected()));
    }
    let mut nodes = vec![MISSING; kind.nodes()];
    for (field, &place) in order(kind).iter().enumerate().take(kind.nodes()) {
        match card.id(2 + field)?.unwrap_or(0) {
            0 if field < kind.corners() => {
                return Err(card.malformed(format!("no corner {}", field + 1), expected()));
            }
            0 => {}
            id => {
                let node =
                    index.get(id).ok_or_else(|| card.malformed(format!("GRID {id}"), "a known point"))?;
                if let Some(slot) = nodes.get_mut(place) {
                    *slot = node;
                }
            }
        }
    }
    Ok((number, property, nodes))
}

/// Names regions by their property cards. Formulations of hexahedra that differ from the incompatible modes
/// which Nastran's default (bubble functions) is closest to, by property.
fn properties(found: &Cards, raw: &mut RawMesh) -> Result<BTreeMap<u64, Hexahedra>, MeshError> {
    let mut formulations = BTreeMap::new();
    for card in &found.bulk {
        if !matches!(card.name.as_str(), "PSOLID" | "PLSOLID" | "PCOMPS" | "PCOMPLS") {
            continue;
        }
        let id = card.id(0)?.ok_or_else(|| card.malformed("no number", "a property and its number"))?;
        if let Ok(tag) = i64::try_from(id) {
            raw.region_names.insert(tag, format!("{} {id}", card.name));
        }
        let points = matches!(card.field(3), "2" | "TWO" | "3" | "THREE");
        if card.name == "PSOLID" && points && matches!(card.field(5), "1" | "FULL") {
            formulations.insert(id, Hexahedra::Full);
        }
    }
    Ok(formulations)
}

/// Points whose displacement a set of single-point constraints holds become a group `SPC 1`, the sets that
/// another one joins too. Constraints of rotations alone hold nothing of a solid.
fn held_points(found: &Cards, raw: &mut RawMesh) -> Result<(), MeshError> {
    let mut sets: BTreeMap<u64, IdRanges> = BTreeMap::new();
    for card in &found.bulk {
        match card.name.as_str() {
            "SPC" => {
                let set = sets.entry(set_number(card)?).or_default();
                for first in [1, 4] {
                    if let Some(point) = card.id(first)?.filter(|_| holds(card.field(first + 1))) {
                        set.add([point, point]);
                    }
                }
            }
            "SPC1" => {
                let set = sets.entry(set_number(card)?).or_default();
                let points = card.fields.get(2..).unwrap_or_default();
                let expected = "SPC1: set, directions, points (numbers, THRU)";
                let points = ranges(points)
                    .ok_or_else(|| card.malformed(shown(points.join(", ").as_bytes()), expected))?;
                points.into_iter().filter(|_| holds(card.field(1))).for_each(|range| set.add(range));
            }
            _ => {}
        }
    }
    let mut groups = Groups::of(raw);
    for (id, points) in &sets {
        groups.add(raw, spc(*id), points)?;
    }
    for card in found.bulk.iter().filter(|card| card.name == "SPCADD") {
        let id = set_number(card)?;
        for field in 1..card.fields.len() {
            let part = card.id(field)?.filter(|part| *part != id && !sets.contains_key(&id));
            let nodes = part.and_then(|part| raw.node_groups.get(&spc(part)).cloned());
            groups.add_nodes(raw, spc(id), nodes.unwrap_or_default())?;
        }
    }
    Ok(())
}

fn spc(set: u64) -> String {
    format!("SPC {set}")
}

fn set_number(card: &Card) -> Result<u64, MeshError> {
    card.id(0)?.ok_or_else(|| card.malformed("no number of a set", "set, directions, points"))
}

/// True if a displacement is among the directions.
fn holds(directions: &str) -> bool {
    directions.contains(['1', '2', '3'])
}
