//! From a raw mesh to one that can be computed with: harmless flaws are repaired with a note, the rest is a
//! problem.
//!
//! Repaired: unused nodes (dropped) and inverted elements (reoriented). Not repaired, because only the author
//! of the mesh knows what was meant: flat elements, coincident nodes, several bodies, folded quadratic
//! elements, foreign cells.

use std::collections::{BTreeMap, HashMap};

use super::flaw::{Flaw, listed};
use super::parts::parts_of;
use super::quality::{FACES, corners, degree_2_points, degree_4_rule, flatness, jacobian_10, quality, ten};
use super::raw::{RawMesh, Tetrahedra};
use super::{Mesh, Order, Region};
use crate::linalg::vec3::{norm, sub};

/// The repaired mesh and its remaining flaws.
pub(crate) struct CheckedMesh {
    pub(crate) mesh: Mesh,
    pub(crate) problems: Vec<Flaw>,
    pub(crate) unused_nodes: usize,
    pub(crate) reoriented: usize,
}

/// Repairs what is harmless and lists the problems.
pub(crate) fn check(raw: &RawMesh) -> CheckedMesh {
    let mut problems = Vec::new();
    if !raw.unsupported.is_empty() {
        problems.push(Flaw::UnsupportedElements(raw.unsupported.clone()));
    }
    let (linear, quadratic) = (raw.linear.region.len(), raw.quadratic.region.len());
    if linear > 0 && quadratic > 0 {
        problems.push(Flaw::MixedOrders { linear, quadratic });
    }
    if linear + quadratic == 0 && raw.unsupported.is_empty() {
        problems.push(Flaw::NoTetrahedra);
    }
    let (order, elements) = match linear >= quadratic {
        true => (Order::Linear, &raw.linear),
        false => (Order::Quadratic, &raw.quadratic),
    };
    let mut mesh = used_part(raw, order, elements);
    let unused_nodes = raw.nodes.len() - mesh.nodes.len();
    let reoriented = reorient(&mut mesh);
    sliver_note(&mut mesh);
    group_notes(raw, &mut mesh);
    if !mesh.elements.is_empty() {
        problems.extend(degenerate(&mesh));
        problems.extend(folded(&mesh));
        problems.extend(duplicates(&mesh));
        match disconnected(&mesh) {
            Some(flaw) => problems.push(flaw),
            None => hinges(&mut mesh),
        }
        faces(&mut mesh, &mut problems);
    }
    CheckedMesh { mesh, problems, unused_nodes, reoriented }
}

/// Keeps the nodes that elements use, in file order.
fn used_part(raw: &RawMesh, order: Order, tetrahedra: &Tetrahedra) -> Mesh {
    let mut new_index = vec![u32::MAX; raw.nodes.len()];
    for &node in &tetrahedra.connectivity {
        new_index[node as usize] = 0;
    }
    let (mut nodes, mut node_ids) = (Vec::new(), Vec::new());
    for (i, index) in new_index.iter_mut().enumerate().filter(|(_, index)| **index == 0) {
        *index = nodes.len() as u32;
        nodes.push(raw.nodes[i]);
        node_ids.push(raw.node_ids[i]);
    }
    let tags: BTreeMap<i64, usize> = tetrahedra.region.iter().map(|&tag| (tag, 0)).collect();
    let position: BTreeMap<i64, u32> = tags.keys().zip(0..).map(|(&tag, i)| (tag, i)).collect();
    let name = |tag| raw.region_names.get(&tag).cloned().unwrap_or_else(|| format!("region {tag}"));
    let mut mesh = Mesh {
        nodes,
        node_ids,
        order,
        elements: tetrahedra.connectivity.iter().map(|&node| new_index[node as usize]).collect(),
        element_region: tetrahedra.region.iter().map(|tag| position[tag]).collect(),
        regions: position.keys().map(|&tag| Region { tag, name: name(tag) }).collect(),
        node_groups: BTreeMap::new(),
        facet_groups: BTreeMap::new(),
        notes: raw.notes.clone(),
    };
    let unused = raw.nodes.len() - mesh.nodes.len();
    if unused > 0 {
        mesh.notes.push(format!("{unused} nodes that no tetrahedron uses were dropped"));
    }
    keep_groups(raw, &new_index, &mut mesh);
    mesh
}

/// Carries groups over to the new numbering and adds the nodes of each named region.
fn keep_groups(raw: &RawMesh, new_index: &[u32], mesh: &mut Mesh) {
    let renumber = |node: u32| Some(new_index[node as usize]).filter(|&n| n != u32::MAX);
    for (name, nodes) in &raw.node_groups {
        let mut kept: Vec<u32> = nodes.iter().filter_map(|&n| renumber(n)).collect();
        kept.sort_unstable();
        kept.dedup();
        if kept.is_empty() {
            mesh.notes.push(format!("group `{name}` holds no node of a tetrahedron and was left out"));
        } else {
            mesh.node_groups.insert(name.clone(), kept);
        }
    }
    for (name, facets) in &raw.facet_groups {
        let corners = |f: &[u32; 3]| Some([renumber(f[0])?, renumber(f[1])?, renumber(f[2])?]);
        let kept: Vec<[u32; 3]> = facets.iter().filter_map(corners).collect();
        if kept.len() < facets.len() {
            let lost = facets.len() - kept.len();
            mesh.notes
                .push(format!("{lost} facets of group `{name}` lie on no tetrahedron and were left out"));
        }
        if !kept.is_empty() {
            mesh.facet_groups.insert(name.clone(), kept);
        }
    }
    region_groups(raw, mesh);
}

/// A region can be selected by its name like any group of nodes.
fn region_groups(raw: &RawMesh, mesh: &mut Mesh) {
    let per = mesh.order.nodes_per_element();
    for (index, region) in mesh.regions.iter().enumerate() {
        if raw.node_groups.contains_key(&region.name) {
            let note = format!("`{}` names a region and a group: selecting it takes the group", region.name);
            mesh.notes.push(note);
            continue;
        }
        let inside = mesh.elements.chunks_exact(per).zip(&mesh.element_region);
        let mut nodes: Vec<u32> =
            inside.filter(|(_, r)| **r == index as u32).flat_map(|(e, _)| e.iter().copied()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        mesh.node_groups.insert(region.name.clone(), nodes);
    }
}

fn group_notes(raw: &RawMesh, mesh: &mut Mesh) {
    for (kind, count) in &raw.skipped {
        mesh.notes
            .push(format!("{count} surface cells of kind {kind} were left out, their nodes kept in groups"));
    }
}

/// Turns inverted elements round by exchanging their first two corners, mid-side nodes with them.
fn reorient(mesh: &mut Mesh) -> usize {
    let per = mesh.order.nodes_per_element();
    let mut count = 0;
    for element in mesh.elements.chunks_exact_mut(per) {
        let p = corners(&mesh.nodes, element);
        if quality(p) < -flatness(p) {
            count += 1;
            element.swap(0, 1);
            if mesh.order == Order::Quadratic {
                element.swap(5, 6);
                element.swap(7, 8);
            }
        }
    }
    if count > 0 {
        mesh.notes.push(format!("{count} inverted elements were reoriented"));
    }
    count
}

fn ids<const N: usize>(mesh: &Mesh, nodes: &[u32]) -> [u64; N] {
    std::array::from_fn(|i| mesh.node_ids[nodes[i] as usize])
}

/// Shape quality below which a note is worth it: an element's stiffness has a condition number that grows
/// like 1/q², so six of sixteen digits are gone there.
const SLIVER: f64 = 1e-3;

fn sliver_note(mesh: &mut Mesh) {
    let elements = mesh.elements.chunks_exact(mesh.order.nodes_per_element());
    let qualities = elements.map(|e| quality(corners(&mesh.nodes, e)).abs());
    let (count, least) = qualities
        .filter(|q| *q < SLIVER)
        .fold((0, f64::INFINITY), |(count, least), q| (count + 1, q.min(least)));
    if count > 0 {
        mesh.notes.push(format!(
            "{count} slivers (quality below {SLIVER}, the worst {least:.1e}) make the equations ill-conditioned"
        ));
    }
}

fn degenerate(mesh: &Mesh) -> Option<Flaw> {
    let flat = |e: &&[u32]| {
        let p = corners(&mesh.nodes, e);
        // A NaN, from coordinates beyond 1e100, counts as flat too.
        let q = quality(p).abs();
        q.is_nan() || q <= flatness(p)
    };
    let flat: Vec<&[u32]> = mesh.elements.chunks_exact(mesh.order.nodes_per_element()).filter(flat).collect();
    let first = flat.first()?;
    let p = corners(&mesh.nodes, first);
    let position = std::array::from_fn(|k| p.iter().map(|x| x[k]).sum::<f64>() / 4.0);
    Some(Flaw::DegenerateElements { count: flat.len(), first: ids(mesh, first), position })
}

fn folded(mesh: &Mesh) -> Option<Flaw> {
    if mesh.order == Order::Linear {
        return None;
    }
    let points: Vec<[f64; 3]> = degree_4_rule().iter().map(|&(x, _)| x).chain(degree_2_points()).collect();
    let (mut count, mut first, mut worst) = (0, None, f64::INFINITY);
    for element in mesh.elements.chunks_exact(10) {
        let p = ten(&mesh.nodes, element);
        let straight = 6.0 * super::quality::corner_volume(corners(&mesh.nodes, element));
        let least = points.iter().map(|&x| jacobian_10(&p, x) / straight).fold(f64::INFINITY, f64::min);
        // A flat element is a problem of its own.
        if straight > 0.0 && least <= 0.0 {
            count += 1;
            worst = worst.min(least);
            first = first.or(Some(ids(mesh, element)));
        }
    }
    first.map(|first| Flaw::FoldedElements { count, first, worst })
}

/// Nodes closer than 1e-12 of the bounding box diagonal, which is what writing 16 digits leaves of one
/// position.
fn duplicates(mesh: &Mesh) -> Option<Flaw> {
    let (low, high) = super::bounding_box(&mesh.nodes);
    let tolerance = 1e-12 * norm(sub(high, low));
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return None;
    }
    // Cells four tolerances wide: a node is compared with its own cell and those it nearly touches.
    let cell = |x: f64, k: usize| ((x - low[k]) / (4.0 * tolerance)).floor() as i64;
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::with_capacity(mesh.nodes.len());
    let (mut count, mut first) = (0, None);
    for (i, p) in mesh.nodes.iter().enumerate() {
        let near = |q: &&u32| (0..3).all(|k| (p[k] - mesh.nodes[**q as usize][k]).abs() <= tolerance);
        let from: [i64; 3] = std::array::from_fn(|k| cell(p[k] - tolerance, k));
        let to: [i64; 3] = std::array::from_fn(|k| cell(p[k] + tolerance, k));
        let neighbours = (from[0]..=to[0])
            .flat_map(|a| (from[1]..=to[1]).flat_map(move |b| (from[2]..=to[2]).map(move |c| [a, b, c])));
        let twin = neighbours.filter_map(|key| cells.get(&key)).flatten().find(near).copied();
        match twin {
            Some(twin) => {
                count += 1;
                first = first.or(Some((twin, i)));
            }
            None => cells.entry(std::array::from_fn(|k| cell(p[k], k))).or_default().push(i as u32),
        }
    }
    let (a, b) = first?;
    let first = [mesh.node_ids[a as usize], mesh.node_ids[b]];
    Some(Flaw::DuplicateNodes { count, first, position: mesh.nodes[b] })
}

/// Bodies by shared nodes: the label of each node's body, labels from 0 in node order.
fn bodies(mesh: &Mesh) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..mesh.nodes.len() as u32).collect();
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    for element in mesh.elements.chunks_exact(mesh.order.nodes_per_element()) {
        let first = root(&mut parent, element[0]);
        for &node in &element[1..] {
            let other = root(&mut parent, node);
            let (low, high) = (first.min(other), first.max(other));
            let low = root(&mut parent, low);
            parent[high as usize] = low;
        }
    }
    (0..parent.len() as u32).map(|i| root(&mut parent, i)).collect()
}

fn disconnected(mesh: &Mesh) -> Option<Flaw> {
    let body = bodies(mesh);
    let mut sizes: BTreeMap<u32, usize> = BTreeMap::new();
    for element in mesh.elements.chunks_exact(mesh.order.nodes_per_element()) {
        *sizes.entry(body[element[0] as usize]).or_default() += 1;
    }
    if sizes.len() < 2 {
        return None;
    }
    let mut sizes: Vec<(u32, usize)> = sizes.into_iter().collect();
    sizes.sort_by_key(|&(root, size)| (std::cmp::Reverse(size), root));
    let nodes = sizes.iter().map(|&(root, _)| mesh.node_ids[root as usize]).collect();
    Some(Flaw::Disconnected { elements: sizes.iter().map(|s| s.1).collect(), nodes })
}

/// Parts of one body that share less than a facet can hinge: worth a note, since supports may hold them all.
fn hinges(mesh: &mut Mesh) {
    let parts = parts_of(&mesh.elements, mesh.order.nodes_per_element());
    if parts.len() > 1 {
        let counts: Vec<usize> = parts.iter().map(|part| part.1).collect();
        let nodes: Vec<u64> =
            parts.iter().map(|part| ids::<1>(mesh, mesh.element(part.0 as usize))[0]).collect();
        mesh.notes.push(format!(
            "{} parts that are joined by edges or nodes only (elements {}; one node of each: {}): they hinge there; \
             `mesh.smallest_part` leaves out small ones",
            parts.len(),
            listed(&counts),
            listed(&nodes)
        ));
    }
}

/// Looks at faces: more than two elements on one is a problem, two on the same side of it a fold worth a
/// note.
fn faces(mesh: &mut Mesh, problems: &mut Vec<Flaw>) {
    let mut sides: Vec<([u32; 3], bool)> = Vec::with_capacity(mesh.element_region.len() * 4);
    for element in mesh.elements.chunks_exact(mesh.order.nodes_per_element()) {
        sides.extend(FACES.iter().map(|face| sorted_with_parity(face.map(|i| element[i]))));
    }
    sides.sort_unstable();
    let (mut crowded, mut first, mut folds) = (0, None, 0);
    for run in sides.chunk_by(|a, b| a.0 == b.0) {
        if run.len() > 2 {
            crowded += 1;
            first = first.or(Some(ids::<3>(mesh, &run[0].0)));
        } else if run.len() == 2 && run[0].1 == run[1].1 {
            folds += 1;
        }
    }
    if let Some(first) = first {
        problems.push(Flaw::OverlappingElements { count: crowded, first });
    }
    if folds > 0 {
        mesh.notes.push(format!(
            "the mesh folds over itself at {folds} faces (both of their elements lie on one side)"
        ));
    }
    stray_facets(mesh, &sides);
}

/// Group facets that are no face of any element cannot carry a pressure.
fn stray_facets(mesh: &mut Mesh, sides: &[([u32; 3], bool)]) {
    for (name, facets) in &mesh.facet_groups {
        let is_face = |f: &[u32; 3]| {
            let key = sorted_with_parity(*f).0;
            sides.binary_search_by(|side| side.0.cmp(&key)).is_ok()
        };
        let stray = facets.iter().filter(|f| !is_face(f)).count();
        if stray > 0 {
            mesh.notes.push(format!("{stray} facets of group `{name}` are no face of any element"));
        }
    }
}

/// The corners in ascending order, and whether sorting them took an odd number of exchanges.
pub(crate) fn sorted_with_parity(mut face: [u32; 3]) -> ([u32; 3], bool) {
    let mut odd = false;
    for (a, b) in [(0, 1), (1, 2), (0, 1)] {
        if face[a] > face[b] {
            face.swap(a, b);
            odd = !odd;
        }
    }
    (face, odd)
}
