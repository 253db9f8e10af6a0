//! Ansys files that `CDWRITE` makes (`.cdb`), and input files with the same blocks: solids by their element
//! types, materials as regions, components as groups.

mod format;
mod scan;
mod types;

use std::collections::{BTreeMap, HashSet};
use std::path::Path;

use self::scan::{ElementRow, Scan, scan};
use self::types::{ElementType, types};
use super::ElementKind;
use super::degenerate::MISSING;
use super::error::{FaultSite, MeshError};
use super::groups::Groups;
use super::place::Location;
use super::raw::{NodeIndex, RawMesh};
use super::solids::{Solids, passed_over};

pub use self::scan::Command;

/// Commands of one line that stand outside of blocks, in order.
///
/// # Errors
/// [`MeshError`] with file and line if a block is malformed.
pub fn commands(file: &Path, bytes: &[u8]) -> Result<Vec<Command>, MeshError> {
    Ok(scan(file, bytes)?.commands)
}

/// Nodes whose coordinate system is rotated: angles about z, x and y in degrees, by number of the node.
///
/// # Errors
/// As [`commands`].
pub fn rotations(file: &Path, bytes: &[u8]) -> Result<BTreeMap<u64, [f64; 3]>, MeshError> {
    let rotated = scan(file, bytes)?.nodes.into_iter().filter(|node| node.angles != [0.0; 3]);
    Ok(rotated.map(|node| (node.id, node.angles)).collect())
}

/// Reads the solids of an Ansys file.
pub(crate) fn parse(file: &Path, bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let scan = scan(file, bytes)?;
    let at = |line: usize, section| FaultSite { file, place: Location::Line(line), section };
    for (section, is_there) in [("NBLOCK", !scan.nodes.is_empty()), ("EBLOCK", !scan.elements.is_empty())] {
        if !is_there {
            let at = FaultSite { file, place: Location::Whole, section };
            let expected = format!("a block {section} (with SOLID, for elements), as CDWRITE,DB writes it");
            return Err(at.malformed(format!("no {section}"), expected));
        }
    }
    let mut raw = RawMesh::new(file, "Ansys .cdb");
    let mut index = NodeIndex::default();
    for node in &scan.nodes {
        index.insert(node.id, raw.nodes.len(), &at(node.line, "NBLOCK"))?;
        raw.nodes.push(node.point);
        raw.node_ids.push(node.id);
    }
    let mut groups = Groups::of(&raw);
    for component in scan.components.iter().filter(|component| component.of_nodes) {
        groups.add(&mut raw, component.name.clone(), &component.ids)?;
    }
    let numbers = read_elements(file, &scan, &index, &mut raw)?;
    element_components(&scan, numbers, &mut groups, &mut raw)?;
    Ok(raw)
}

/// Takes over the solids. Their numbers, in order.
fn read_elements(
    file: &Path,
    scan: &Scan,
    index: &NodeIndex,
    raw: &mut RawMesh,
) -> Result<Vec<u64>, MeshError> {
    let types = types(scan);
    let mut others: BTreeMap<String, usize> = BTreeMap::new();
    let (mut solids, mut numbers, mut seen) = (Solids::default(), Vec::new(), HashSet::new());
    let mut rest = &scan.element_nodes[..];
    for row in &scan.elements {
        let (given, following) = rest.split_at(row.nodes.min(rest.len()));
        rest = following;
        let at = FaultSite { file, place: Location::Line(row.line), section: "EBLOCK" };
        let Some(kind) = types.get(&row.kind) else {
            return Err(at.malformed(format!("element type {}", row.kind), "a type that ET defines"));
        };
        let Some(shape) = kind.solid() else {
            if kind.is_other_solid() {
                raw.refuse(&kind.name(), at.place);
            } else {
                *others.entry(kind.name()).or_default() += 1;
            }
            continue;
        };
        if !seen.insert(row.number) {
            return Err(at.malformed(format!("element {} a second time", row.number), "every number once"));
        }
        let expected = || format!("{} to {} nodes of {}", shape.1, shape.0.nodes(), kind.name());
        let (tag, nodes) = solid(row, shape, given, index, &at, &expected)?;
        let Some(shape) = solids.push(raw, shape.0, &nodes, tag, at.place) else { continue };
        numbers.push(row.number);
        raw.region_names.entry(tag).or_insert_with(|| format!("material {tag}"));
        if let Some(named) = kind.formulation(shape).filter(|_| shape.corners() == 8) {
            let known = *raw.hexahedra.entry(tag).or_insert(named);
            if known != named {
                let found =
                    format!("material {tag} with two formulations of hexahedra ({known:?}, {named:?})");
                let remedy = "give the elements of each type a material of their own";
                return Err(at.unsupported(found, "one formulation for a material", remedy));
            }
        }
    }
    for (kind, count) in &scan.loose {
        let name = types.get(kind).map_or_else(|| format!("elements of type {kind}"), ElementType::name);
        *others.entry(name).or_default() += count;
    }
    raw.notes.extend(passed_over(&others));
    solids.finish(raw);
    Ok(numbers)
}

/// Material and nodes of a solid; of its kind the file gives at least `least` nodes.
fn solid(
    row: &ElementRow,
    (kind, least): (ElementKind, usize),
    given: &[u64],
    index: &NodeIndex,
    at: &FaultSite<'_>,
    expected: &dyn Fn() -> String,
) -> Result<(i64, Vec<u32>), MeshError> {
    let filled = given.iter().rposition(|node| *node != 0).map_or(0, |last| last + 1);
    if filled < least || filled > kind.nodes() {
        return Err(at.malformed(format!("{filled} nodes of element {}", row.number), expected()));
    }
    let mut nodes = vec![MISSING; kind.nodes()];
    for (place, (slot, id)) in nodes.iter_mut().zip(given).enumerate() {
        match id {
            0 if place < kind.corners() => {
                return Err(at.malformed(format!("no corner {} of {}", place + 1, row.number), expected()));
            }
            0 => {}
            id => *slot = index.find(*id, at)?,
        }
    }
    let tag = i64::try_from(row.material);
    let tag = tag.map_err(|_| at.malformed(format!("material {}", row.material), "a smaller number"))?;
    Ok((tag, nodes))
}

/// Components of elements become groups of their nodes.
fn element_components(
    scan: &Scan,
    numbers: Vec<u64>,
    groups: &mut Groups,
    raw: &mut RawMesh,
) -> Result<(), MeshError> {
    let mut known: Vec<(u64, u32)> = numbers.into_iter().zip(0..).collect();
    known.sort_unstable();
    let mut starts: Vec<usize> = Vec::new();
    let mut end = 0;
    for (_, nodes, _) in raw.elements.each() {
        starts.push(end);
        end += nodes.len();
    }
    starts.push(end);
    for component in scan.components.iter().filter(|component| !component.of_nodes) {
        let mut nodes: Vec<u32> = Vec::new();
        for element in component.ids.members(&known) {
            let range = starts.get(element as usize).zip(starts.get(element as usize + 1));
            let of_element = range.and_then(|(from, to)| raw.elements.connectivity.get(*from..*to));
            nodes.extend_from_slice(of_element.unwrap_or_default());
        }
        nodes.sort_unstable();
        nodes.dedup();
        groups.add_nodes(raw, component.name.clone(), nodes)?;
    }
    Ok(())
}
