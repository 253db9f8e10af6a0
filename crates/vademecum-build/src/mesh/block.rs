//! A structured block of tetrahedra, for examples and convergence studies.

use std::collections::BTreeMap;

use super::raise::with_mid_nodes;
use super::surface::Surface;
use super::{Mesh, Order, Region};

/// A box `[0, lengths]` cut into `divisions` cells per axis, each into six tetrahedra round its main
/// diagonal.
///
/// All cells are cut alike, so neighbours conform. Node groups and facet groups `x_min`, `x_max`, `y_min`,
/// `y_max`, `z_min`, `z_max`; one region `body`, tag 1; nodes are numbered from 1, corners first (x fastest),
/// mid-side nodes in order of first use after them.
///
/// # Panics
/// If a division is zero, a length is not positive, or there are more than `u32::MAX` nodes.
pub fn block(lengths: [f64; 3], divisions: [usize; 3], order: Order) -> Mesh {
    assert!(divisions.iter().all(|&n| n > 0), "a block needs at least one cell per axis");
    assert!(lengths.iter().all(|&l| l > 0.0), "a block needs positive lengths");
    let mut nodes = corner_nodes(lengths, divisions);
    let linear = cell_tetrahedra(divisions);
    let elements = match order {
        Order::Linear => linear,
        Order::Quadratic => with_mid_nodes(&mut nodes, &linear).0,
    };
    let count = u32::try_from(nodes.len()).expect("node indices fit 32 bits");
    let element_count = elements.len() / order.nodes_per_element();
    let mut mesh = Mesh {
        nodes,
        node_ids: (1..=u64::from(count)).collect(),
        kinds: order.into(),
        elements,
        element_region: vec![0; element_count],
        regions: vec![Region::new(1, "body")],
        node_groups: BTreeMap::from([("body".into(), (0..count).collect())]),
        facet_groups: BTreeMap::new(),
        notes: Vec::new(),
    };
    name_sides(&mut mesh, lengths);
    mesh
}

fn corner_nodes(lengths: [f64; 3], n: [usize; 3]) -> Vec<[f64; 3]> {
    // The far sides lie exactly at `lengths`; 0.1 · 3 / 3 does not.
    let at = |k: usize, i: usize| if i == n[k] { lengths[k] } else { lengths[k] * i as f64 / n[k] as f64 };
    let mut nodes = Vec::with_capacity((n[0] + 1) * (n[1] + 1) * (n[2] + 1));
    for k in 0..=n[2] {
        for j in 0..=n[1] {
            nodes.extend((0..=n[0]).map(|i| [at(0, i), at(1, j), at(2, k)]));
        }
    }
    nodes
}

/// Six tetrahedra per cell: one for each order in which a path from the low to the high corner takes the
/// axes.
fn cell_tetrahedra(n: [usize; 3]) -> Vec<u32> {
    const PATHS: [([usize; 3], bool); 6] = [
        ([0, 1, 2], true),
        ([1, 2, 0], true),
        ([2, 0, 1], true),
        ([0, 2, 1], false),
        ([1, 0, 2], false),
        ([2, 1, 0], false),
    ];
    let stride = [1, n[0] + 1, (n[0] + 1) * (n[1] + 1)];
    let mut elements = Vec::with_capacity(24 * n[0] * n[1] * n[2]);
    for k in 0..n[2] {
        for j in 0..n[1] {
            for i in 0..n[0] {
                let low = i + j * stride[1] + k * stride[2];
                for (path, even) in PATHS {
                    let a = low + stride[path[0]];
                    let b = a + stride[path[1]];
                    let high = b + stride[path[2]];
                    // An odd permutation of the axes is a left-handed path.
                    let tetrahedron = if even { [low, a, b, high] } else { [low, b, a, high] };
                    elements.extend(tetrahedron.map(|node| node as u32));
                }
            }
        }
    }
    elements
}

fn name_sides(mesh: &mut Mesh, lengths: [f64; 3]) {
    let surface = Surface::of(mesh);
    for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
        for (side, at) in [("min", 0.0), ("max", lengths[axis])] {
            let name = format!("{letter}_{side}");
            let on = |n: &u32| mesh.nodes[*n as usize][axis] == at;
            let nodes = (0..mesh.nodes.len() as u32).filter(on).collect();
            let facets =
                surface.each_facet().filter(|f| f.iter().all(on)).map(|f| [f[0], f[1], f[2]]).collect();
            mesh.node_groups.insert(name.clone(), nodes);
            mesh.facet_groups.insert(name, facets);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_far_sides_are_where_the_lengths_say() {
        for order in [Order::Linear, Order::Quadratic] {
            let mesh = block([0.3, 0.1, 0.7], [7, 3, 11], order);
            for side in ["x_max", "y_max", "z_max"] {
                assert!(!mesh.node_groups[side].is_empty() && !mesh.facet_groups[side].is_empty(), "{side}");
            }
        }
    }
}
