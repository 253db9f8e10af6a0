//! A small block generator for the tests of this stage.

use std::collections::{BTreeMap, HashMap};

use crate::mesh::EDGES;
use crate::mesh::{Mesh, Order, Region};

/// A box of `cells` bricks, six tetrahedra each; linear elements.
pub(crate) fn block(cells: [usize; 3], size: [f64; 3]) -> Mesh {
    let [nx, ny, nz] = cells;
    let id = |i: usize, j: usize, k: usize| (i + (nx + 1) * (j + (ny + 1) * k)) as u32;
    let mut nodes = Vec::new();
    for k in 0..=nz {
        for j in 0..=ny {
            for i in 0..=nx {
                nodes.push([
                    size[0] * i as f64 / nx as f64,
                    size[1] * j as f64 / ny as f64,
                    size[2] * k as f64 / nz as f64,
                ]);
            }
        }
    }
    // The six paths from (0,0,0) to (1,1,1) along the axes; odd permutations are turned.
    let paths = [
        ([0, 1, 2], true),
        ([1, 2, 0], true),
        ([2, 0, 1], true),
        ([0, 2, 1], false),
        ([2, 1, 0], false),
        ([1, 0, 2], false),
    ];
    let mut elements = Vec::new();
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                for (path, even) in paths {
                    let mut at = [i, j, k];
                    let mut corners = [id(i, j, k); 4];
                    for (step, axis) in path.into_iter().enumerate() {
                        at[axis] += 1;
                        corners[step + 1] = id(at[0], at[1], at[2]);
                    }
                    if !even {
                        corners.swap(1, 2);
                    }
                    elements.extend(corners);
                }
            }
        }
    }
    let n = elements.len() / 4;
    Mesh {
        node_ids: (1..=nodes.len() as u64).collect(),
        nodes,
        kinds: Order::Linear.into(),
        elements,
        element_region: vec![0; n],
        regions: vec![Region::new(1, "body")],
        node_groups: BTreeMap::new(),
        facet_groups: BTreeMap::new(),
        notes: Vec::new(),
    }
}

/// The same mesh with straight quadratic elements.
pub(crate) fn quadratic(mesh: &Mesh) -> Mesh {
    let mut nodes = mesh.nodes.clone();
    let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
    let mut elements = Vec::new();
    for element in mesh.elements.chunks_exact(4) {
        elements.extend_from_slice(element);
        for [a, b] in EDGES {
            let ends = [element[a].min(element[b]), element[a].max(element[b])];
            let middle = *middles.entry(ends).or_insert_with(|| {
                let [p, q] = ends.map(|n| mesh.nodes[n as usize]);
                nodes.push(std::array::from_fn(|i| 0.5 * (p[i] + q[i])));
                nodes.len() as u32 - 1
            });
            elements.push(middle);
        }
    }
    Mesh {
        node_ids: (1..=nodes.len() as u64).collect(),
        nodes,
        kinds: Order::Quadratic.into(),
        elements,
        ..mesh.clone()
    }
}

/// The same topology with nodes moved by a smooth map.
pub(crate) fn moved(mut mesh: Mesh, map: impl Fn([f64; 3]) -> [f64; 3]) -> Mesh {
    for node in &mut mesh.nodes {
        *node = map(*node);
    }
    mesh
}

/// Holds all components of the nodes that satisfy a predicate.
pub(crate) fn hold(mesh: &Mesh, held: impl Fn([f64; 3]) -> bool) -> Vec<bool> {
    mesh.nodes.iter().flat_map(|&p| [held(p); 3]).collect()
}
