//! Parts of a mesh: elements that are joined by common facets.
//!
//! Two parts that share an edge or a node only hinge about it, whatever holds one of them.

use std::collections::BTreeMap;

use super::raw::{RawElements, RawMesh};
use super::{ElementKind, Mesh, face_key};

/// Label of the part of each element: its first element.
fn labels<'a>(elements: impl ExactSizeIterator<Item = (ElementKind, &'a [u32])>) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..elements.len() as u32).collect();
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    let mut faces: Vec<([u32; 4], u32)> = Vec::with_capacity(4 * parent.len());
    for ((kind, element), index) in elements.zip(0..) {
        faces.extend(kind.faces().iter().map(|face| (face_key(face, element).0, index)));
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
pub(super) fn parts_of(mesh: &Mesh) -> Vec<(u32, usize)> {
    let all: Vec<_> = mesh.each().collect();
    sizes(&labels(all.into_iter()))
}

/// Labels of the elements of a file.
fn raw_labels(raw: &RawMesh) -> Vec<u32> {
    let all: Vec<_> = raw.elements.each().map(|(kind, nodes, _)| (kind, nodes)).collect();
    labels(all.into_iter())
}

impl RawMesh {
    /// Leaves out the parts that have less than `smallest` of the elements and share no facet with a larger
    /// one, with a note. 0 leaves out nothing.
    pub(crate) fn drop_small_parts(&mut self, smallest: f64) {
        if smallest <= 0.0 {
            return;
        }
        let labels = raw_labels(self);
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
        let mut elements = RawElements::default();
        for ((kind, nodes, region), _) in
            self.elements.each().zip(&labels).filter(|(_, label)| !small.contains_key(label))
        {
            elements.push(kind, nodes, region);
        }
        self.elements = elements;
        let (count, dropped) = (small.len(), all - self.elements.kinds.len());
        self.notes.push(format!(
            "{count} loose parts with {dropped} of {all} elements were left out (`mesh.smallest_part` = {smallest})"
        ));
    }
}

/// Element counts of the parts of a mesh, the largest first: one entry for a sound body.
pub fn part_sizes(raw: &RawMesh) -> Vec<usize> {
    sizes(&raw_labels(raw)).into_iter().map(|(_, size)| size).collect()
}
