//! Contents of a deck beside its mesh, for those who compute what the deck asks for.

use std::collections::BTreeMap;

use super::deck::{InpCard, LineLocation};
use super::dialect::Dialect;
use super::model::Deck;
use super::sets::Sets;
use crate::mesh::ElementKind;
use crate::mesh::raw::CellKind;

/// Cards, sets and elements of an Abaqus or CalculiX deck.
#[derive(Clone, Debug)]
pub struct InpContents {
    /// Program whose meaning its names have.
    pub dialect: Dialect,
    /// All cards in order; those of nodes and elements without their data.
    pub cards: Vec<InpCard>,
    /// Numbers of the nodes of each set, by its name in capitals.
    pub node_sets: BTreeMap<String, Vec<u64>>,
    /// Numbers of the elements of each set, by its name in capitals.
    pub element_sets: BTreeMap<String, Vec<u64>>,
    /// Elements by number.
    pub elements: BTreeMap<u64, InpElement>,
    /// Names of instances, in capitals.
    instances: Vec<String>,
}

/// An element of a deck.
#[derive(Clone, Debug)]
pub struct InpElement {
    /// Its type, in capitals.
    pub name: String,
    /// Numbers of its nodes.
    pub nodes: Vec<u64>,
    /// Its kind if it is solid.
    pub kind: Option<ElementKind>,
    /// Kind and nodes by which its faces are numbered, if its corners repeat.
    pub written: Option<(ElementKind, Vec<u64>)>,
    /// Its last line.
    pub place: LineLocation,
}

impl InpContents {
    pub(crate) fn of(deck: &Deck, cards: Vec<InpCard>) -> Self {
        let ids = &deck.raw.node_ids;
        let sets = |sets: &Sets, id: &dyn Fn(usize) -> u64| {
            let named = sets.all.iter();
            named
                .map(|set| (set.name.to_ascii_uppercase(), set.members.iter().map(|&m| id(m)).collect()))
                .collect()
        };
        let element = |element: &super::model::Element| InpElement {
            name: element.name.to_string(),
            nodes: element.nodes.iter().map(|&node| ids[node as usize]).collect(),
            kind: match element.kind {
                CellKind::Solid(kind) => Some(kind),
                _ => None,
            },
            written: element
                .written
                .as_ref()
                .map(|written| (written.0, written.1.iter().map(|&node| ids[node as usize]).collect())),
            place: element.place.clone(),
        };
        Self {
            dialect: deck.dialect,
            cards,
            node_sets: sets(&deck.node_sets, &|node| ids[node]),
            element_sets: sets(&deck.element_sets, &|index| deck.elements[index].id),
            elements: deck.elements.iter().map(|e| (e.id, element(e))).collect(),
            instances: deck.instances.iter().map(|name| name.to_ascii_uppercase()).collect(),
        }
    }

    /// A name in capitals, without the instance before it.
    pub fn plain_name(&self, name: &str) -> String {
        let name = name.trim_matches('"').to_ascii_uppercase();
        match name.split_once('.') {
            Some((instance, rest)) if self.instances.iter().any(|known| known == instance) => {
                rest.to_string()
            }
            _ => name,
        }
    }
}
