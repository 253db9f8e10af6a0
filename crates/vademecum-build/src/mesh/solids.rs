//! Elements on their way from a file into a mesh: bricks may have repeated corners, and the file may leave
//! out nodes in the middle of edges.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::ElementKind;
use super::degenerate::{MISSING, collapsed, edge, note, repeated_name, repeats_corner};
use super::place::Location;
use super::raw::{RawElements, RawMesh};

/// Elements of a file.
#[derive(Default)]
pub(crate) struct Solids {
    elements: RawElements,
    /// Elements with repeated corners.
    collapsed: usize,
}

impl Solids {
    /// Adds an element; [`MISSING`] stands for a middle of an edge that is left out, and an element without
    /// any is linear. The kind that it became; none if it is refused.
    pub(crate) fn push(
        &mut self,
        raw: &mut RawMesh,
        kind: ElementKind,
        nodes: &[u32],
        region: i64,
        place: Location,
    ) -> Option<ElementKind> {
        let mut simpler = None;
        if repeats_corner(kind, nodes) {
            simpler = collapsed(kind, nodes);
            if simpler.is_none() {
                raw.refuse(repeated_name(kind), place);
                return None;
            }
            self.collapsed += 1;
        }
        let (kind, nodes) = simpler.as_ref().map_or((kind, nodes), |(kind, nodes)| (*kind, nodes.as_slice()));
        let (corners, middles) = nodes.split_at(kind.corners());
        if middles.iter().all(|&middle| middle == MISSING) {
            let kind = kind.linear();
            self.elements.push(kind, corners, region);
            return Some(kind);
        }
        self.elements.push(kind, nodes, region);
        Some(kind)
    }

    /// Moves the elements into the mesh, with nodes in the middle of edges where some are left out. A group
    /// that holds both ends of such an edge gets its middle.
    pub(crate) fn finish(mut self, raw: &mut RawMesh) {
        if self.collapsed > 0 {
            raw.notes.push(note(self.collapsed));
        }
        if self.elements.connectivity.contains(&MISSING) {
            let added = self.fill(raw);
            join_groups(raw, &added);
            raw.notes.push(format!(
                "{} nodes that the file leaves out were added in the middle of straight edges",
                added.len()
            ));
        }
        raw.elements = self.elements;
    }

    /// Gives every edge of quadratic elements its middle: that of a neighbour, else a new node. The new
    /// nodes, by the ends of their edges.
    fn fill(&mut self, raw: &mut RawMesh) -> Vec<([u32; 2], u32)> {
        let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
        for (kind, nodes, _) in self.elements.each() {
            for (ends, &middle) in kind.edges().iter().zip(&nodes[kind.corners()..]) {
                if middle != MISSING {
                    middles.insert(edge(ends.map(|end| nodes[end])), middle);
                }
            }
        }
        let last = raw.node_ids.iter().copied().max().unwrap_or(0);
        let mut added = Vec::new();
        let mut rest = &mut self.elements.connectivity[..];
        for kind in &self.elements.kinds {
            let (nodes, others) = std::mem::take(&mut rest).split_at_mut(kind.nodes());
            rest = others;
            let (corners, given) = nodes.split_at_mut(kind.corners());
            for (ends, middle) in kind.edges().iter().zip(given).filter(|(_, middle)| **middle == MISSING) {
                let ends = edge(ends.map(|end| corners[end]));
                *middle = *middles.entry(ends).or_insert_with(|| {
                    let [p, q] = ends.map(|end| raw.nodes[end as usize]);
                    let node = raw.nodes.len() as u32;
                    raw.nodes.push(std::array::from_fn(|k| 0.5 * (p[k] + q[k])));
                    added.push((ends, node));
                    raw.node_ids.push(last.saturating_add(added.len() as u64));
                    node
                });
            }
        }
        added
    }
}

/// Adds the middle of an edge to the groups that hold both its ends.
fn join_groups(raw: &mut RawMesh, added: &[([u32; 2], u32)]) {
    let mut at: HashMap<u32, Vec<(u32, u32)>> = HashMap::new();
    for &([first, second], middle) in added {
        at.entry(first).or_default().push((second, middle));
    }
    for nodes in raw.node_groups.values_mut() {
        let held: HashSet<u32> = nodes.iter().copied().collect();
        let edges = nodes.iter().filter_map(|node| at.get(node)).flatten();
        let inside: Vec<u32> = edges.filter(|(end, _)| held.contains(end)).map(|edge| edge.1).collect();
        nodes.extend(inside);
    }
}

/// Note on cells that are no solids, by their name in the file; none without them.
pub(crate) fn passed_over(counts: &BTreeMap<String, usize>) -> Option<String> {
    let each: Vec<String> = counts.iter().map(|(name, count)| format!("{count} {name}")).collect();
    let verb = if counts.values().sum::<usize>() == 1 { "is" } else { "are" };
    if each.is_empty() { None } else { Some(format!("{} {verb} no part of the mesh", each.join(", "))) }
}
