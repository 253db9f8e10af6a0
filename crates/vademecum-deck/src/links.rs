//! Couplings and ties as linear equations between dofs.

use std::collections::{BTreeMap, BTreeSet};

use vademecum_build::fem::{Constraints, LoadError, anchors, surface_facets};
use vademecum_build::linalg::symmetric_eigen;
use vademecum_build::linalg::vec3::{norm, sub};

use crate::deck::{Attachment, Deck, Link, Load, NodeNumber, Spring};

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

/// Adds all links of a deck, and the axes of its nodes.
pub(crate) fn link(deck: &Deck, dofs: &Dofs, constraints: &mut Constraints) -> Result<(), LoadError> {
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
                    let Some(anchor) = anchor else { continue };
                    let size = || {
                        let at = anchor.weights.iter().map(|(node, _)| deck.place(*node));
                        let corners: Vec<[f64; 3]> = at.collect();
                        0.05 * norm(sub(corners[0], corners[1]))
                    };
                    let own = anchor.weights.iter().any(|(other, _)| *other == node);
                    if own || anchor.distance > tolerance.unwrap_or_else(size) {
                        continue;
                    }
                    for c in 0..3 {
                        let master = anchor.weights.iter().map(|&(other, w)| (3 * other + c, -w));
                        let terms = std::iter::once((3 * node + c, 1.0)).chain(master);
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
    let (from, to) = (deck.place(reference), deck.place(node));
    let d: [f64; 3] = std::array::from_fn(|c| to[c] - from[c]);
    for c in (0..6_u8).filter(|c| components[usize::from(*c)]) {
        let mut terms = vec![(dofs.global(node, c), 1.0), (dofs.global(reference, c), -1.0)];
        if c < 3 {
            let (next, last) = ((c + 1) % 3, (c + 2) % 3);
            terms.push((dofs.global(reference, 3 + next), -d[usize::from(last)]));
            terms.push((dofs.global(reference, 3 + last), d[usize::from(next)]));
        } else if terms[0].0.is_none() {
            continue;
        }
        let terms = terms.into_iter().filter_map(|(dof, a)| Some((dof?, a))).filter(|term| term.1 != 0.0);
        constraints.equate(terms.collect(), origin);
    }
}

/// `θ = J⁻¹ Σ w r × u` about the centre of the cloud, `u_r = Σ w u + θ × (x_r − c)` with weights that sum to
/// one. A cloud on a line has no rotation about it: that of the reference is then left alone.
fn mean(
    deck: &Deck,
    dofs: &Dofs,
    reference: NodeNumber,
    cloud: &[(NodeNumber, f64)],
    components: &[bool; 6],
    (origin, constraints): (&str, &mut Constraints),
) {
    let whole: f64 = cloud.iter().map(|(_, w)| w).sum();
    let weights: Vec<(NodeNumber, f64)> = cloud.iter().map(|&(node, w)| (node, w / whole)).collect();
    let centre: [f64; 3] =
        std::array::from_fn(|c| weights.iter().map(|&(node, w)| w * deck.place(node)[c]).sum());
    let arm = |at: [f64; 3]| -> [f64; 3] { std::array::from_fn(|c| at[c] - centre[c]) };
    let mut inertia = [[0.0; 3]; 3];
    for &(node, w) in &weights {
        let r = arm(deck.place(node));
        let square: f64 = r.iter().map(|x| x * x).sum();
        for i in 0..3 {
            for j in 0..3 {
                inertia[i][j] += w * (if i == j { square } else { 0.0 } - r[i] * r[j]);
            }
        }
    }
    let inverse = inverted(inertia);
    // Row `i` of the rotation: coefficients of the components of each node.
    let rotation = |i: usize, node: NodeNumber, w: f64| -> [f64; 3] {
        let r = arm(deck.place(node));
        // (r × u)_a = Σ_c cross[a][c] u_c.
        let cross = [[0.0, -r[2], r[1]], [r[2], 0.0, -r[0]], [-r[1], r[0], 0.0]];
        std::array::from_fn(|c| w * (0..3).map(|a| inverse[i][a] * cross[a][c]).sum::<f64>())
    };
    let d = arm(deck.place(reference));
    for c in (0..6_u8).filter(|c| components[usize::from(*c)]) {
        let Some(dof) = dofs.global(reference, c) else { continue };
        let mut terms = vec![(dof, 1.0)];
        for &(node, w) in &weights {
            let mut row = [0.0; 3];
            if c < 3 {
                row[usize::from(c)] = w;
                // (θ × d)_c = θ_next d_last − θ_last d_next.
                let (next, last) = ((usize::from(c) + 1) % 3, (usize::from(c) + 2) % 3);
                let (of_next, of_last) = (rotation(next, node, w), rotation(last, node, w));
                for (k, sum) in row.iter_mut().enumerate() {
                    *sum += of_next[k] * d[last] - of_last[k] * d[next];
                }
            } else {
                row = rotation(usize::from(c - 3), node, w);
            }
            let of_node = (0..3).map(|k| (3 * node + k as u32, -row[k]));
            terms.extend(of_node.filter(|term| term.1 != 0.0));
        }
        constraints.equate(terms, origin);
    }
}

/// The inverse of a symmetric matrix in the directions in which it is not singular.
fn inverted(a: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let matrix = faer::Mat::from_fn(3, 3, |i, j| a[i][j]);
    let Ok((values, vectors)) = symmetric_eigen(matrix.as_ref()) else { return [[0.0; 3]; 3] };
    let largest = (0..3).map(|k| values[k]).fold(0.0, f64::max);
    let share = |k: usize| if values[k] > 1e-10 * largest { 1.0 / values[k] } else { 0.0 };
    std::array::from_fn(|i| {
        std::array::from_fn(|j| (0..3).map(|k| vectors[(i, k)] * share(k) * vectors[(j, k)]).sum())
    })
}
