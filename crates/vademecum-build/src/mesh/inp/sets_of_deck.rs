//! The keywords *NSET and *ELSET, and the regions and groups made of sets.

use super::deck::{DataLine, InpCard};
use super::model::{Deck, Element, is_volume};
use super::sets::{Family, Sets};
use crate::mesh::error::{MeshError, shown};
use crate::mesh::raw::CellKind;
use crate::mesh::text::ParsedNumber;

impl Deck {
    pub(crate) fn node_set(&mut self, card: &InpCard) -> Result<(), MeshError> {
        let name = set_name(card, "NSET")?;
        let mut members = match card.parameter("GENERATE") {
            Some(_) => {
                let known: Vec<(u64, usize)> = self.raw.node_ids.iter().copied().zip(0..).collect();
                generated(card, "*NSET", &known, |id| self.index.get(id).map(|i| i as usize))?
            }
            None => self.node_members(&card.data, "*NSET")?,
        };
        if let Some(from) = card.parameter("ELSET") {
            let Some(set) = self.element_sets.get(self.strip_instance(from)) else {
                let found = format!("element set `{from}`");
                return Err(card.place.at("*NSET").malformed(found, "an element set defined before"));
            };
            members.extend(set.members.iter().flat_map(|&e| &self.elements[e].nodes).map(|&n| n as usize));
        }
        self.node_sets.add(&name, members, family(card), self.in_assembly);
        Ok(())
    }

    pub(crate) fn element_set(&mut self, card: &InpCard) -> Result<(), MeshError> {
        let name = set_name(card, "ELSET")?;
        let members = match card.parameter("GENERATE") {
            Some(_) => {
                let mut known: Vec<(u64, usize)> =
                    self.element_index.iter().map(|(&id, &i)| (id, i)).collect();
                known.sort_unstable();
                generated(card, "*ELSET", &known, |id| self.element_index.get(&id).copied())?
            }
            None => {
                let find = |id| self.element_index.get(&id).copied();
                self.members(&card.data, "*ELSET", &self.element_sets, find)?
            }
        };
        self.element_sets.add(&name, members, family(card), self.in_assembly);
        Ok(())
    }

    pub(crate) fn node_members(&self, data: &[DataLine], section: &str) -> Result<Vec<usize>, MeshError> {
        self.members(data, section, &self.node_sets, |id| self.index.get(id).map(|i| i as usize))
    }

    /// Numbers and names of sets defined before.
    pub(crate) fn members(
        &self,
        data: &[DataLine],
        section: &str,
        sets: &Sets,
        find: impl Fn(u64) -> Option<usize>,
    ) -> Result<Vec<usize>, MeshError> {
        let mut members = Vec::new();
        for line in data {
            for field in line.fields().iter().filter(|f| !f.is_empty()) {
                let field = self.strip_instance(field.trim_matches('"'));
                let number = u64::parse(field.as_bytes()).map(&find);
                match (number, sets.get(field)) {
                    (Some(Some(index)), _) => members.push(index),
                    (_, Some(set)) => members.extend_from_slice(&set.members),
                    _ => {
                        let expected = "a number or a set defined before";
                        return Err(line.place.at(section).malformed(shown(field.as_bytes()), expected));
                    }
                }
                // Sets that name each other can double at every line; no honest deck has more than this.
                if members.len() > 64 * (self.raw.nodes.len() + self.elements.len() + 64) {
                    return Err(line
                        .place
                        .at(section)
                        .malformed("the same members over and over", "each member once"));
                }
            }
        }
        members.sort_unstable();
        members.dedup();
        Ok(members)
    }

    /// The name of the region of each element: its solid section; without sections, the *ELSETs if they part
    /// the body, else the set it was defined in.
    pub(crate) fn regions(&mut self) -> Result<Vec<Option<String>>, MeshError> {
        let mut regions = vec![None; self.elements.len()];
        let sections = std::mem::take(&mut self.sections);
        for (name, place) in &sections {
            let Some(set) = self.element_sets.get(self.strip_instance(name)) else {
                let found = format!("element set `{name}`");
                return Err(place.at("*SOLID SECTION").malformed(found, "an element set of this deck"));
            };
            for &e in &set.members {
                regions[e] = Some(set.name.clone());
            }
        }
        if sections.is_empty() && !self.regions_from(Family::Explicit, &mut regions) {
            self.regions_from(Family::Creation, &mut regions);
        }
        let missing = self.elements.iter().zip(&regions).filter(|(e, r)| is_volume(e) && r.is_none()).count();
        if !sections.is_empty() && missing > 0 {
            self.raw.notes.push(format!("{missing} elements have no *SOLID SECTION, their region is `body`"));
        }
        Ok(regions)
    }

    /// Takes the sets of a family as regions; explicit ones only if they hold every volume element exactly
    /// once.
    fn regions_from(&self, family: Family, regions: &mut [Option<String>]) -> bool {
        let mut found: Vec<Option<String>> = vec![None; regions.len()];
        for set in self.element_sets.all.iter().filter(|s| s.family == family) {
            for &e in set.members.iter().filter(|&&e| is_volume(&self.elements[e])) {
                if family == Family::Explicit && found[e].is_some() {
                    return false;
                }
                found[e] = Some(set.name.clone());
            }
        }
        let covers = self.elements.iter().zip(&found).all(|(e, r)| !is_volume(e) || r.is_some());
        if family == Family::Explicit && !covers {
            return false;
        }
        regions.clone_from_slice(&found);
        true
    }

    /// Node sets and element sets become groups of their names; the nodes of a node set win over those of an
    /// element set of the same name.
    pub(crate) fn groups(&mut self) {
        for set in &self.node_sets.all {
            let nodes = set.members.iter().map(|&n| n as u32).collect();
            self.raw.node_groups.insert(set.name.clone(), nodes);
        }
        let regions: Vec<String> = self.raw.region_names.values().cloned().collect();
        for set in self.element_sets.all.iter().filter(|s| s.family != Family::Internal) {
            let members = || set.members.iter().map(|&e| &self.elements[e]);
            let triangle = |e: &&Element| matches!(e.kind, CellKind::Facet(_));
            let facets: Vec<[u32; 3]> =
                members().filter(triangle).map(|e| [e.nodes[0], e.nodes[1], e.nodes[2]]).collect();
            if !facets.is_empty() {
                self.raw.facet_groups.insert(set.name.clone(), facets);
            }
            // Regions bring their nodes themselves.
            if self.node_sets.get(&set.name).is_none() && !regions.contains(&set.name) {
                let nodes = members().flat_map(|e| e.nodes.iter().copied()).collect();
                self.raw.node_groups.insert(set.name.clone(), nodes);
            }
        }
    }
}

fn set_name(card: &InpCard, key: &str) -> Result<String, MeshError> {
    match card.parameter(key) {
        Some(name) if !name.is_empty() => Ok(name.to_string()),
        _ => Err(card.place.at(&card.section()).malformed("no name", format!("{key}=name"))),
    }
}

fn family(card: &InpCard) -> Family {
    if card.parameter("INTERNAL").is_some() { Family::Internal } else { Family::Explicit }
}

/// Members of `first, last, step` lines; numbers that do not exist are skipped, as both programs do.
///
/// `known` holds all numbers in use, `find` looks one up: a range longer than the deck is cut down to what
/// exists.
fn generated(
    card: &InpCard,
    section: &str,
    known: &[(u64, usize)],
    find: impl Fn(u64) -> Option<usize>,
) -> Result<Vec<usize>, MeshError> {
    const EXPECTED: &str = "first, last, step";
    let mut members = Vec::new();
    for line in &card.data {
        let fault = || line.place.at(section).malformed(shown(line.text.as_bytes()), EXPECTED);
        let numbers: Option<Vec<u64>> = line.fields().iter().map(|f| u64::parse(f.as_bytes())).collect();
        let (first, last, step) = match numbers.ok_or_else(fault)?[..] {
            [first, last] => (first, last, 1),
            [first, last, step] if step > 0 => (first, last, step),
            _ => return Err(fault()),
        };
        if last.saturating_sub(first) / step > known.len() as u64 {
            let inside = |id: u64| (first..=last).contains(&id) && (id - first).is_multiple_of(step);
            members.extend(known.iter().filter(|(id, _)| inside(*id)).map(|(_, index)| index));
        } else {
            let mut id = first;
            while id <= last {
                members.extend(find(id));
                let Some(next) = id.checked_add(step) else {
                    break;
                };
                id = next;
            }
        }
    }
    Ok(members)
}
