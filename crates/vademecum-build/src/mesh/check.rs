//! From a raw mesh to one that can be computed with: harmless flaws are repaired with a note, the rest is a
//! problem.
//!
//! Repaired: unused nodes (dropped) and inverted elements (reoriented). Not repaired, because only the author
//! of the mesh knows what was meant: flat elements, coincident nodes, several bodies, folded quadratic
//! elements, foreign cells.

use std::collections::{BTreeMap, HashMap};

use super::flaw::{Flaw, listed};
use super::parts::parts_of;
use super::quality::{
    corners, degree_2_points, degree_4_rule, element_volume, flatness, is_flat, jacobian_10, quality,
    shape_quality, ten, volume_forms,
};
use super::raw::RawMesh;
use super::{ElementKind, ElementKinds, FaceKey, FacetKind, Mesh, Order, Region, corner_triples, face_key};
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
    let quadratic = raw.elements.kinds.iter().filter(|kind| kind.order() == Order::Quadratic).count();
    let linear = raw.elements.kinds.len() - quadratic;
    if linear > 0 && quadratic > 0 {
        problems.push(Flaw::MixedOrders { linear, quadratic });
    }
    if linear + quadratic == 0 && raw.unsupported.is_empty() {
        problems.push(Flaw::NoElements);
    }
    let order = if linear >= quadratic { Order::Linear } else { Order::Quadratic };
    let mut mesh = used_part(raw, order);
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

/// Keeps the elements of one order and the nodes that they use, in file order.
fn used_part(raw: &RawMesh, order: Order) -> Mesh {
    let chosen: Vec<_> = raw.elements.each().filter(|(kind, ..)| kind.order() == order).collect();
    let mut new_index = vec![u32::MAX; raw.nodes.len()];
    for &node in chosen.iter().flat_map(|(_, nodes, _)| *nodes) {
        new_index[node as usize] = 0;
    }
    let (mut nodes, mut node_ids) = (Vec::new(), Vec::new());
    for (i, index) in new_index.iter_mut().enumerate().filter(|(_, index)| **index == 0) {
        *index = nodes.len() as u32;
        nodes.push(raw.nodes[i]);
        node_ids.push(raw.node_ids[i]);
    }
    let tags: BTreeMap<i64, usize> = chosen.iter().map(|&(_, _, tag)| (tag, 0)).collect();
    let position: BTreeMap<i64, u32> = tags.keys().zip(0..).map(|(&tag, i)| (tag, i)).collect();
    let name = |tag| raw.region_names.get(&tag).cloned().unwrap_or_else(|| format!("region {tag}"));
    let region = |tag| Region { tag, name: name(tag), hexahedra: raw.hexahedra.get(&tag).copied() };
    let mut mesh = Mesh {
        nodes,
        node_ids,
        kinds: kinds_of(order, chosen.iter().map(|&(kind, ..)| kind)),
        elements: chosen
            .iter()
            .flat_map(|(_, nodes, _)| *nodes)
            .map(|&node| new_index[node as usize])
            .collect(),
        element_region: chosen.iter().map(|(_, _, tag)| position[tag]).collect(),
        regions: position.keys().map(|&tag| region(tag)).collect(),
        node_groups: BTreeMap::new(),
        facet_groups: BTreeMap::new(),
        notes: raw.notes.clone(),
    };
    let unused = raw.nodes.len() - mesh.nodes.len();
    if unused > 0 {
        mesh.notes.push(format!("{unused} nodes that no element uses were dropped"));
    }
    keep_groups(raw, &new_index, &mut mesh);
    mesh
}

/// Kinds of elements of one order; tetrahedra where there is none.
fn kinds_of(order: Order, kinds: impl ExactSizeIterator<Item = ElementKind>) -> ElementKinds {
    if kinds.len() == 0 { order.into() } else { kinds.collect() }
}

/// Carries groups over to the new numbering and adds the nodes of each named region.
fn keep_groups(raw: &RawMesh, new_index: &[u32], mesh: &mut Mesh) {
    let renumber = |node: u32| Some(new_index[node as usize]).filter(|&n| n != u32::MAX);
    for (name, nodes) in &raw.node_groups {
        let mut kept: Vec<u32> = nodes.iter().filter_map(|&n| renumber(n)).collect();
        kept.sort_unstable();
        kept.dedup();
        if kept.is_empty() {
            mesh.notes.push(format!("group `{name}` holds no node of an element and was left out"));
        } else {
            mesh.node_groups.insert(name.clone(), kept);
        }
    }
    for (name, facets) in &raw.facet_groups {
        let corners = |f: &[u32; 3]| Some([renumber(f[0])?, renumber(f[1])?, renumber(f[2])?]);
        let kept: Vec<[u32; 3]> = facets.iter().filter_map(corners).collect();
        if kept.len() < facets.len() {
            let lost = facets.len() - kept.len();
            mesh.notes.push(format!("{lost} facets of group `{name}` lie on no element and were left out"));
        }
        if !kept.is_empty() {
            mesh.facet_groups.insert(name.clone(), kept);
        }
    }
    region_groups(raw, mesh);
}

/// A region can be selected by its name like any group of nodes.
fn region_groups(raw: &RawMesh, mesh: &mut Mesh) {
    for (index, region) in mesh.regions.iter().enumerate() {
        if raw.node_groups.contains_key(&region.name) {
            let note = format!("`{}` names a region and a group: selecting it takes the group", region.name);
            mesh.notes.push(note);
            continue;
        }
        let inside = mesh.each().zip(&mesh.element_region).filter(|(_, r)| **r == index as u32);
        let mut nodes: Vec<u32> = inside.flat_map(|((_, e), _)| e.iter().copied()).collect();
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

/// Turns inverted elements round: tetrahedra by exchanging their first two corners, others by their mirror.
fn reorient(mesh: &mut Mesh) -> usize {
    let mut count = 0;
    for index in 0..mesh.element_count() {
        let (kind, range) = (mesh.kinds.kind(index), mesh.kinds.range(index));
        let element = &mesh.elements[range.clone()];
        let inverted = if kind.is_tetrahedron() {
            let p = corners(&mesh.nodes, element);
            quality(p) < -flatness(p)
        } else {
            element_volume(kind, &mesh.nodes, element) < 0.0 && !is_flat(kind, &mesh.nodes, element)
        };
        if inverted {
            count += 1;
            let turned: Vec<u32> = kind.mirror().iter().map(|&place| element[place]).collect();
            mesh.elements[range].copy_from_slice(&turned);
        }
    }
    if count > 0 {
        mesh.notes.push(format!("{count} inverted elements were reoriented"));
    }
    count
}

/// The file numbers of nodes; `u32::MAX` is none.
fn ids(mesh: &Mesh, nodes: &[u32]) -> Vec<u64> {
    nodes.iter().filter(|&&node| node != u32::MAX).map(|&node| mesh.node_ids[node as usize]).collect()
}

/// Shape quality below which a note is worth it: an element's stiffness has a condition number that grows
/// like 1/q², so six of sixteen digits are gone there.
const SLIVER: f64 = 1e-3;

fn sliver_note(mesh: &mut Mesh) {
    let qualities = mesh.each().map(|(kind, e)| shape_quality(kind, &mesh.nodes, e).abs());
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
    let flat = mesh.each().filter(|(kind, element)| is_flat(*kind, &mesh.nodes, element));
    let (count, first) = flat.fold((0, None), |(count, first), found| (count + 1, first.or(Some(found))));
    let (kind, element) = first?;
    let corners = &element[..kind.corners()];
    let mean = |k: usize| corners.iter().map(|&node| mesh.nodes[node as usize][k]).sum::<f64>();
    let position = std::array::from_fn(|k| mean(k) / corners.len() as f64);
    Some(Flaw::DegenerateElements { count, first: ids(mesh, corners), position })
}

fn folded(mesh: &Mesh) -> Option<Flaw> {
    let points: Vec<[f64; 3]> = degree_4_rule().iter().map(|&(x, _)| x).chain(degree_2_points()).collect();
    let (mut count, mut first, mut worst, mut stiffness_is_sound) = (0, None, f64::INFINITY, true);
    for (kind, element) in mesh.each() {
        // The least volume form beside the mean one, and that at the points of the stiffness.
        let (least, at_points) = match kind {
            ElementKind::Tet4 => continue,
            ElementKind::Tet10 => {
                let p = ten(&mesh.nodes, element);
                let straight = 6.0 * super::quality::corner_volume(corners(&mesh.nodes, element));
                let forms = points.iter().map(|&x| jacobian_10(&p, x) / straight);
                // A flat element is a problem of its own.
                if straight <= 0.0 {
                    continue;
                }
                let at_points =
                    degree_2_points().into_iter().map(|x| jacobian_10(&p, x)).fold(f64::INFINITY, f64::min);
                (forms.fold(f64::INFINITY, f64::min), at_points)
            }
            _ => {
                let forms: Vec<(f64, f64)> = volume_forms(kind, &mesh.nodes, element).collect();
                let (volume, whole) =
                    forms.iter().fold((0.0, 0.0), |(v, w), (form, weight)| (v + form * weight, w + weight));
                let least = forms.iter().map(|(form, _)| form * whole / volume).fold(f64::INFINITY, f64::min);
                if volume > 0.0 { (least, least) } else { continue }
            }
        };
        if least <= 0.0 {
            count += 1;
            worst = worst.min(least);
            stiffness_is_sound &= at_points > 0.0;
            first = first.or(Some(ids(mesh, &element[..kind.corners()])));
        }
    }
    first.map(|first| Flaw::FoldedElements { count, first, worst, stiffness_is_sound })
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
    for (_, element) in mesh.each() {
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
    for (_, element) in mesh.each() {
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
    let parts = parts_of(mesh);
    if parts.len() > 1 {
        let counts: Vec<usize> = parts.iter().map(|part| part.1).collect();
        let nodes: Vec<u64> =
            parts.iter().map(|part| ids(mesh, &mesh.element(part.0 as usize)[..1])[0]).collect();
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
    let mut sides: Vec<(FaceKey, FacetKind)> = Vec::with_capacity(mesh.element_region.len() * 4);
    for (kind, element) in mesh.each() {
        sides.extend(kind.faces().iter().map(|face| (face_key(face, element), face.0)));
    }
    sides.sort_unstable_by_key(|side| side.0);
    let (mut crowded, mut first, mut folds) = (0, None, 0);
    let (mut differing, mut first_differing) = (0, None);
    for run in sides.chunk_by(|a, b| a.0.0 == b.0.0) {
        if run.len() > 2 {
            crowded += 1;
            first = first.or(Some(ids(mesh, &run[0].0.0)));
        } else if run.len() == 2 && run[0].0.1 == run[1].0.1 {
            folds += 1;
        }
        if run.iter().any(|side| side.1 != run[0].1) {
            differing += 1;
            first_differing = first_differing.or(Some(ids(mesh, &run[0].0.0)));
        }
    }
    if let Some(first) = first {
        problems.push(Flaw::OverlappingElements { count: crowded, first });
    }
    if let Some(first) = first_differing {
        problems.push(Flaw::DifferentFaces { count: differing, first });
    }
    if folds > 0 {
        mesh.notes.push(format!(
            "the mesh folds over itself at {folds} faces (both of their elements lie on one side)"
        ));
    }
    problems.extend(split_faces(mesh, &sides));
    stray_facets(mesh, &sides);
}

/// Quadrangles with two triangles of the other side on them, whose neighbours do not fit.
fn split_faces(mesh: &Mesh, sides: &[(FaceKey, FacetKind)]) -> Option<Flaw> {
    let open: Vec<[u32; 4]> =
        sides.chunk_by(|a, b| a.0.0 == b.0.0).filter(|run| run.len() == 1).map(|run| run[0].0.0).collect();
    let is_open = |corners: [u32; 3]| {
        let [a, b, c] = corners;
        open.binary_search(&[a, b, c, u32::MAX]).is_ok()
    };
    let split = |quad: &&[u32; 4]| quad[3] != u32::MAX && corner_triples(**quad).into_iter().any(is_open);
    let mut found = open.iter().filter(split);
    let first = found.next()?;
    Some(Flaw::SplitFaces { count: 1 + found.count(), first: ids(mesh, first) })
}

/// Group facets that are no face of any element cannot carry a pressure.
fn stray_facets(mesh: &mut Mesh, sides: &[(FaceKey, FacetKind)]) {
    if mesh.facet_groups.is_empty() {
        return;
    }
    let mut known: Vec<[u32; 3]> = sides.iter().flat_map(|side| corner_triples(side.0.0)).collect();
    known.sort_unstable();
    for (name, facets) in &mesh.facet_groups {
        let is_face = |f: &[u32; 3]| {
            let mut key = *f;
            key.sort_unstable();
            known.binary_search(&key).is_ok()
        };
        let stray = facets.iter().filter(|f| !is_face(f)).count();
        if stray > 0 {
            mesh.notes.push(format!("{stray} facets of group `{name}` are no face of any element"));
        }
    }
}
