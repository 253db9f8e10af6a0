//! Couplings and ties as linear equations between dofs.

use std::collections::{BTreeMap, BTreeSet};

use vademecum_build::fem::{Constraints, LoadError, anchors, mean_rows, over_gap, rigid_row, surface_facets};
use vademecum_build::linalg::vec3::{norm, sub};

use crate::deck::{Attachment, Deck, Link, Load, NodeNumber, Spring};

/// Value of the shape function of a corner from which on a tie of CalculiX is at the corner.
const AT_CORNER: f64 = 0.998;

/// Dofs of a model: three displacements of every node along the axes of space, then the rotations of
/// reference nodes, then displacements along own axes.
pub(crate) struct Dofs {
    rotations: BTreeMap<NodeNumber, u32>,
    own: BTreeMap<NodeNumber, u32>,
    /// Nodes whose displacement is the rotation of a reference node.
    turns: BTreeMap<NodeNumber, NodeNumber>,
    /// Dofs of nodes.
    of_nodes: u32,
    /// Those of nodes and, behind them, of elements.
    count: u32,
}

impl Dofs {
    /// Numbers them.
    pub(crate) fn new(deck: &Deck) -> Dofs {
        let mut turning: BTreeSet<NodeNumber> = BTreeSet::new();
        let mut turns = BTreeMap::new();
        for link in &deck.links {
            match link {
                Link::Rigid { reference, rotation: Some(rotation), .. } => {
                    turns.insert(*reference, *rotation);
                }
                Link::Rigid { reference, .. } | Link::Mean { reference, .. } => {
                    turning.insert(*reference);
                }
                Link::Equation { terms, .. } => {
                    turning.extend(terms.iter().filter(|term| term.1 >= 3).map(|term| term.0));
                }
                Link::Tie { .. } => {}
            }
        }
        for attachment in &deck.attachments {
            match attachment {
                Attachment::Beam { ends, .. } => turning.extend(ends),
                Attachment::Mass { node, inertia, .. } if *inertia != [0.0; 6] => {
                    turning.insert(*node);
                }
                Attachment::Spring(Spring::Components { ends, .. })
                | Attachment::Dashpot(Spring::Components { ends, .. }) => {
                    turning.extend(ends.iter().filter(|end| end.1 >= 3).map(|end| end.0));
                }
                _ => {}
            }
        }
        let mut count = 3 * deck.node_count() as u32;
        let mut three = |nodes: &mut dyn Iterator<Item = NodeNumber>| -> BTreeMap<NodeNumber, u32> {
            let numbered = nodes.map(|node| {
                count += 3;
                (node, count - 3)
            });
            numbered.collect()
        };
        let rotations = three(&mut turning.iter().copied().filter(|node| !turns.contains_key(node)));
        // Axes matter where something is given along them.
        let named = named_components(deck);
        let own = three(&mut deck.axes.keys().copied().filter(|node| named.contains(node)));
        Dofs { rotations, own, turns, of_nodes: count, count }
    }

    /// Number of dofs.
    pub(crate) fn count(&self) -> usize {
        self.count as usize
    }

    /// True of a node whose displacements along own axes are dofs.
    pub(crate) fn has_axes(&self, node: NodeNumber) -> bool {
        self.own.contains_key(&node)
    }

    /// Number of dofs of nodes.
    pub(crate) fn of_nodes(&self) -> usize {
        self.of_nodes as usize
    }

    /// Adds dofs of elements, up to this number.
    pub(crate) fn end_at(&mut self, count: u32) {
        self.count = count;
    }

    /// A displacement (0 to 2) along an axis of space or a rotation (3 to 5) about one; none where the node
    /// has no rotation.
    pub(crate) fn global(&self, node: NodeNumber, component: u8) -> Option<u32> {
        match component {
            0..3 => Some(3 * node + u32::from(component)),
            _ => match self.turns.get(&node) {
                Some(&turn) => Some(3 * turn + u32::from(component - 3)),
                None => self.rotations.get(&node).map(|first| first + u32::from(component - 3)),
            },
        }
    }

    /// The same along the axes of the node.
    pub(crate) fn nodal(&self, node: NodeNumber, component: u8) -> Option<u32> {
        match self.own.get(&node).filter(|_| component < 3) {
            Some(first) => Some(first + u32::from(component)),
            None => self.global(node, component),
        }
    }
}

impl Dofs {
    /// Every dof under three shifts along the axes of space and three turns about a point; zeros of dofs of
    /// elements.
    pub(crate) fn rigid_rows(&self, deck: &Deck, about: [f64; 3]) -> Vec<[f64; 6]> {
        let mut rows = vec![[0.0; 6]; self.count()];
        let of_node = |node: NodeNumber, c: usize| rigid_row(sub(deck.place(node), about), c);
        for node in 0..deck.node_count() as u32 {
            (0..3).for_each(|c| rows[3 * node as usize + c] = of_node(node, c));
        }
        let turns = self.turns.values().map(|node| 3 * node);
        for first in turns.chain(self.rotations.values().copied()) {
            (0..3).for_each(|c| rows[first as usize + usize::from(c)] = unit(3 + c));
        }
        for (&node, &first) in &self.own {
            for (k, axis) in deck.axes[&node].iter().enumerate() {
                let along = |motion: usize| (0..3).map(|c| axis[c] * of_node(node, c)[motion]).sum();
                rows[first as usize + k] = std::array::from_fn(along);
            }
        }
        rows
    }
}

/// Nodes of which a support, a force, an equation or a spring names a component.
fn named_components(deck: &Deck) -> BTreeSet<NodeNumber> {
    let steps = || deck.steps.iter();
    let supports = deck.supports.iter().chain(steps().flat_map(|step| &step.supports));
    let mut named: BTreeSet<NodeNumber> = supports.map(|support| support.node).collect();
    named.extend(steps().flat_map(|step| &step.loads).filter_map(|load| match load {
        Load::Force { node, .. } => Some(*node),
        _ => None,
    }));
    for link in &deck.links {
        if let Link::Equation { terms, .. } = link {
            named.extend(terms.iter().map(|term| term.0));
        }
    }
    for attachment in &deck.attachments {
        if let Attachment::Spring(Spring::Components { ends, .. }) = attachment {
            named.extend(ends.iter().map(|end| end.0));
        }
    }
    named
}

/// Adds all links of a deck, and the axes of its nodes. On a free body ties over a gap turn with it.
pub(crate) fn link(
    deck: &Deck,
    dofs: &Dofs,
    free: bool,
    constraints: &mut Constraints,
) -> Result<(), LoadError> {
    for (&node, axes) in deck.axes.iter().filter(|(node, _)| dofs.has_axes(**node)) {
        for c in 0..3_u8 {
            let own = (0..3_u8).map(|k| (dofs.nodal(node, k), -axes[usize::from(k)][usize::from(c)]));
            let terms = std::iter::once((dofs.global(node, c), 1.0)).chain(own);
            let terms = terms.filter_map(|(dof, a)| Some((dof?, a))).filter(|term| term.1 != 0.0).collect();
            constraints.equate(terms, format!("the axes of node {}", deck.id(node)));
        }
    }
    for one in &deck.links {
        match one {
            Link::Equation { terms, origin } => {
                let terms = terms.iter().filter_map(|&(node, c, a)| Some((dofs.nodal(node, c)?, a)));
                constraints.equate(terms.collect(), origin.clone());
            }
            Link::Rigid { reference, nodes, components, origin, .. } => {
                for &node in nodes.iter().filter(|node| *node != reference) {
                    rigid(deck, dofs, (*reference, node), components, (origin, &mut *constraints));
                }
            }
            Link::Mean { reference, cloud, components, origin } => {
                mean(deck, dofs, *reference, cloud, components, (origin, &mut *constraints));
            }
            Link::Tie { slaves, faces, tolerance, origin } => {
                let facets = surface_facets(&deck.mesh, faces)?;
                let points: Vec<[f64; 3]> = slaves.iter().map(|&node| deck.place(node)).collect();
                for (&node, anchor) in slaves.iter().zip(anchors(&deck.mesh, &facets, &points)) {
                    let Some(mut anchor) = anchor else { continue };
                    // CalculiX takes the corner itself where the nearest place of the rim is next to one.
                    let corners = if anchor.weights.len() % 3 == 0 { 3 } else { 4 };
                    let mut nearest = anchor.weights.iter().take(corners);
                    let corner = nearest.find(|term| term.1 > AT_CORNER).map(|term| term.0);
                    if let Some(corner) = corner.filter(|_| deck.of_calculix && anchor.on_rim) {
                        anchor
                            .weights
                            .iter_mut()
                            .for_each(|(node, w)| *w = f64::from(u8::from(*node == corner)));
                    }
                    let size = || {
                        let at = anchor.weights.iter().map(|(node, _)| deck.place(*node));
                        let corners: Vec<[f64; 3]> = at.collect();
                        0.05 * norm(sub(corners[0], corners[1]))
                    };
                    let own = anchor.weights.iter().any(|(other, _)| *other == node);
                    if own || anchor.distance > tolerance.unwrap_or_else(size) {
                        continue;
                    }
                    let at = |node| deck.place(node);
                    let gap = if free { over_gap(at, at(node), &anchor) } else { vec![] };
                    for c in 0..3 {
                        let master = anchor.weights.iter().map(|&(other, w)| (3 * other + c, -w));
                        let turned = gap.iter().map(|&(dof, weights)| (dof, -weights[c as usize]));
                        let terms = std::iter::once((3 * node + c, 1.0)).chain(master).chain(turned);
                        constraints.equate(terms.filter(|term| term.1 != 0.0).collect(), origin.clone());
                    }
                }
            }
        }
    }
    Ok(())
}

/// `u = u_r + θ × d`, and `θ` of the follower where it has one.
fn rigid(
    deck: &Deck,
    dofs: &Dofs,
    (reference, node): (NodeNumber, NodeNumber),
    components: &[bool; 6],
    (origin, constraints): (&str, &mut Constraints),
) {
    let d = sub(deck.place(node), deck.place(reference));
    for c in (0..6_u8).filter(|c| components[usize::from(*c)]) {
        let Some(own) = dofs.global(node, c) else { continue };
        let row = if c < 3 { rigid_row(d, usize::from(c)) } else { unit(c) };
        let of_reference = (0..6_u8).zip(row).map(|(k, a)| (dofs.global(reference, k), -a));
        let terms = of_reference.filter_map(|(dof, a)| Some((dof?, a))).filter(|term| term.1 != 0.0);
        constraints.equate(std::iter::once((own, 1.0)).chain(terms).collect(), origin);
    }
}

/// Row that is one at a component.
fn unit(component: u8) -> [f64; 6] {
    std::array::from_fn(|k| if k == usize::from(component) { 1.0 } else { 0.0 })
}

/// A reference that follows the mean of a cloud. A cloud on a line has no rotation about it: that of the
/// reference is then zero.
fn mean(
    deck: &Deck,
    dofs: &Dofs,
    reference: NodeNumber,
    cloud: &[(NodeNumber, f64)],
    components: &[bool; 6],
    (origin, constraints): (&str, &mut Constraints),
) {
    let places: Vec<([f64; 3], f64)> = cloud.iter().map(|&(node, w)| (deck.place(node), w)).collect();
    let rows = mean_rows(deck.place(reference), &places);
    for c in (0..6_u8).filter(|c| components[usize::from(*c)]) {
        let Some(dof) = dofs.global(reference, c) else { continue };
        let of_nodes = cloud.iter().zip(&rows).flat_map(|(&(node, _), row)| {
            (0..3).map(move |k| (3 * node + k, -row[usize::from(c)][k as usize]))
        });
        let terms = std::iter::once((dof, 1.0)).chain(of_nodes.filter(|term| term.1 != 0.0));
        constraints.equate(terms.collect(), origin);
    }
}
