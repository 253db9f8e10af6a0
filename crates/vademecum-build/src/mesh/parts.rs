//! Parts of a mesh: elements that are joined by common facets.
//!
//! Two parts that share an edge or a node only hinge about it, whatever holds one of them.

use std::collections::BTreeMap;

use super::quality::FACES;
use super::raw::{RawMesh, Tetrahedra};

/// Label of the part of each element: its first element. `nodes` has `per` node indices an element.
fn labels(nodes: &[u32], per: usize) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..(nodes.len() / per) as u32).collect();
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    let mut faces: Vec<([u32; 3], u32)> = Vec::with_capacity(4 * parent.len());
    for (element, index) in nodes.chunks_exact(per).zip(0..) {
        faces.extend(FACES.iter().map(|face| {
            let mut face = face.map(|i| element[i]);
            face.sort_unstable();
            (face, index)
        }));
    }
    faces.sort_unstable();
    for pair in faces.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let [a, b] = [pair[0].1, pair[1].1].map(|element| root(&mut parent, element));
        parent[a.max(b) as usize] = a.min(b);
    }
    (0..parent.len() as u32).map(|element| root(&mut parent, element)).collect()
}

/// First element and number of elements of each part, the largest first.
fn sizes(labels: &[u32]) -> Vec<(u32, usize)> {
    let mut counts: BTreeMap<u32, usize> = BTreeMap::new();
    labels.iter().for_each(|&label| *counts.entry(label).or_default() += 1);
    let mut sizes: Vec<(u32, usize)> = counts.into_iter().collect();
    sizes.sort_by_key(|&(label, size)| (std::cmp::Reverse(size), label));
    sizes
}

/// The same of the elements of a checked mesh.
pub(super) fn parts_of(nodes: &[u32], per: usize) -> Vec<(u32, usize)> {
    sizes(&labels(nodes, per))
}

impl RawMesh {
    /// Tetrahedra of the order that the mesh is taken to have, and their nodes.
    fn main_tetrahedra(&mut self) -> (&mut Tetrahedra, usize) {
        match self.linear.region.len() >= self.quadratic.region.len() {
            true => (&mut self.linear, 4),
            false => (&mut self.quadratic, 10),
        }
    }

    /// Leaves out the parts that have less than `smallest` of the elements and share no facet with a larger
    /// one, with a note. 0 leaves out nothing.
    pub(super) fn drop_small_parts(&mut self, smallest: f64) {
        if smallest <= 0.0 {
            return;
        }
        let (tetrahedra, per) = self.main_tetrahedra();
        let labels = labels(&tetrahedra.connectivity, per);
        let all = labels.len();
        // The largest stays, however many there are.
        let small: BTreeMap<u32, usize> = sizes(&labels)
            .into_iter()
            .skip(1)
            .filter(|&(_, size)| (size as f64) < smallest * all as f64)
            .collect();
        if small.is_empty() {
            return;
        }
        let kept = |element: &usize| !small.contains_key(&labels[*element]);
        let elements: Vec<usize> = (0..all).filter(kept).collect();
        let connectivity = elements.iter().flat_map(|e| &tetrahedra.connectivity[per * e..per * (e + 1)]);
        let connectivity = connectivity.copied().collect();
        let region = elements.iter().map(|&e| tetrahedra.region[e]).collect();
        *tetrahedra = Tetrahedra { connectivity, region };
        let (count, dropped) = (small.len(), all - elements.len());
        self.notes.push(format!(
            "{count} loose parts with {dropped} of {all} elements were left out (`mesh.smallest_part` = {smallest})"
        ));
    }
}

/// Element counts of the parts of a mesh, the largest first: one entry for a sound body.
pub fn part_sizes(raw: &RawMesh) -> Vec<usize> {
    let (linear, quadratic) = (&raw.linear, &raw.quadratic);
    let (tetrahedra, per) =
        if linear.region.len() >= quadratic.region.len() { (linear, 4) } else { (quadratic, 10) };
    parts_of(&tetrahedra.connectivity, per).into_iter().map(|(_, size)| size).collect()
}
