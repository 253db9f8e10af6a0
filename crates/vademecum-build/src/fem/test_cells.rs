//! Blocks of cells that are cut into elements of any kind, for tests.

use std::collections::{BTreeMap, HashMap};

use crate::mesh::shapes::CORNERS;
use crate::mesh::{ElementKind, Hexahedra, Mesh, Order, Region};

/// The formulations of a kind that differ.
pub(crate) fn formulations(kind: ElementKind) -> Vec<Option<Hexahedra>> {
    match kind {
        ElementKind::Hex8 => Hexahedra::ALL.map(Some).to_vec(),
        ElementKind::Hex20 => {
            vec![Some(Hexahedra::Full), Some(Hexahedra::Reduced), Some(Hexahedra::ReducedMass)]
        }
        _ => vec![None],
    }
}

/// Elements of a cell, with their corners by places in the cell: its eight corners, then its middle.
pub(crate) type Elements = Vec<(ElementKind, Vec<usize>)>;

/// A way to cut each cell of a block into elements.
pub(crate) struct Cut {
    pub(crate) name: &'static str,
    pub(crate) elements: Elements,
}

/// Corners of the six pyramids of a cell.
const PYRAMIDS: [[usize; 5]; 6] =
    [[0, 1, 2, 3, 8], [4, 7, 6, 5, 8], [0, 4, 5, 1, 8], [1, 5, 6, 2, 8], [2, 6, 7, 3, 8], [3, 7, 4, 0, 8]];

/// Each kind of element alone.
pub(crate) fn cuts() -> Vec<Cut> {
    let six = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]];
    let wedges = [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]];
    let mut all = vec![];
    for order in [Order::Linear, Order::Quadratic] {
        let of = |linear, quadratic| if order == Order::Linear { linear } else { quadratic };
        let tet = of(ElementKind::Tet4, ElementKind::Tet10);
        let wedge = of(ElementKind::Wedge6, ElementKind::Wedge15);
        let pyramid = of(ElementKind::Pyramid5, ElementKind::Pyramid13);
        let hex = of(ElementKind::Hex8, ElementKind::Hex20);
        let whole: Vec<usize> = (0..8).collect();
        all.push(Cut { name: "tetrahedra", elements: six.iter().map(|e| (tet, e.to_vec())).collect() });
        all.push(Cut { name: "wedges", elements: wedges.iter().map(|e| (wedge, e.to_vec())).collect() });
        all.push(Cut {
            name: "pyramids",
            elements: PYRAMIDS.iter().map(|e| (pyramid, e.to_vec())).collect(),
        });
        all.push(Cut { name: "hexahedra", elements: vec![(hex, whole.clone())] });
    }
    all.push(Cut { name: "27 nodes", elements: vec![(ElementKind::Hex27, (0..8).collect())] });
    all
}

/// A cube of `n³` cells, distorted inside; `cut` chooses the elements of each cell by its number.
pub(crate) fn cube(n: usize, cut: impl Fn(usize) -> Elements) -> Mesh {
    cells([n; 3], |x| distorted(x, n as f64), cut)
}

/// A block of cells whose corners and middles lie where `place` maps the lattice of unit cells; edges are
/// straight.
pub(crate) fn cells(
    counts: [usize; 3],
    place: impl Fn([f64; 3]) -> [f64; 3],
    cut: impl Fn(usize) -> Elements,
) -> Mesh {
    let mut nodes: Vec<[f64; 3]> = vec![];
    let mut known: HashMap<[i64; 3], u32> = HashMap::new();
    let mut node = |nodes: &mut Vec<[f64; 3]>, at: [f64; 3]| -> u32 {
        let key = at.map(|x| (1e6 * x).round() as i64);
        *known.entry(key).or_insert_with(|| {
            nodes.push(at);
            nodes.len() as u32 - 1
        })
    };
    let (mut kinds, mut elements) = (vec![], vec![]);
    for cell in 0..counts.iter().product() {
        let corner = [cell % counts[0], cell / counts[0] % counts[1], cell / counts[0] / counts[1]];
        let at = |c: usize| -> [f64; 3] {
            let local = if c == 8 { [0.0; 3] } else { CORNERS[c] };
            place(std::array::from_fn(|i| corner[i] as f64 + 0.5 * (1.0 + local[i])))
        };
        for (kind, corners) in cut(cell) {
            kinds.push(kind);
            let places: Vec<[f64; 3]> = corners.iter().map(|&c| at(c)).collect();
            let mean = |ends: &[usize]| -> [f64; 3] {
                std::array::from_fn(|i| ends.iter().map(|&e| places[e][i]).sum::<f64>() / ends.len() as f64)
            };
            let mut all = places.clone();
            if kind.order() == Order::Quadratic {
                all.extend(kind.edges().iter().map(|ends| mean(ends)));
            }
            if kind == ElementKind::Hex27 {
                for side in
                    [[0, 3, 4, 7], [1, 2, 5, 6], [0, 1, 4, 5], [2, 3, 6, 7], [0, 1, 2, 3], [4, 5, 6, 7]]
                {
                    all.push(mean(&side));
                }
                all.push(mean(&[0, 1, 2, 3, 4, 5, 6, 7]));
            }
            elements.extend(all.into_iter().map(|at| node(&mut nodes, at)));
        }
    }
    let count = kinds.len();
    Mesh {
        node_ids: (0..nodes.len() as u64).collect(),
        nodes,
        kinds: kinds.into_iter().collect(),
        elements,
        element_region: vec![0; count],
        regions: vec![Region::new(1, "body")],
        node_groups: BTreeMap::new(),
        facet_groups: BTreeMap::new(),
        notes: vec![],
    }
}

/// Moves what lies inside the block, and nothing on its faces.
fn distorted(x: [f64; 3], n: f64) -> [f64; 3] {
    let inside = x.iter().map(|x| x * (n - x)).product::<f64>();
    [x[0] + 0.11 * inside, x[1] - 0.08 * inside, x[2] + 0.06 * inside]
}

/// Of a cube of two cells a side: whole cells, pyramids, and pyramids of which one is two tetrahedra at the
/// outside; all of one order.
pub(crate) fn mixed(order: Order) -> impl Fn(usize) -> Elements {
    let of = move |linear, quadratic| if order == Order::Linear { linear } else { quadratic };
    let hex = of(ElementKind::Hex8, ElementKind::Hex20);
    let pyramid = of(ElementKind::Pyramid5, ElementKind::Pyramid13);
    let tet = of(ElementKind::Tet4, ElementKind::Tet10);
    move |cell: usize| match cell % 3 {
        0 => vec![(hex, (0..8).collect())],
        1 => PYRAMIDS.iter().map(|e| (pyramid, e.to_vec())).collect(),
        _ => {
            let first = (cell / 4) % 2;
            let of_side = |(i, &[a, b, c, d, top]): (usize, &[usize; 5])| {
                // The bottom of cells below, the top of those above lies at the outside.
                if i == first {
                    vec![(tet, vec![a, b, c, top]), (tet, vec![a, c, d, top])]
                } else {
                    vec![(pyramid, vec![a, b, c, d, top])]
                }
            };
            PYRAMIDS.iter().enumerate().flat_map(of_side).collect()
        }
    }
}

/// Columns of hexahedra beside wedges: the wedges' quadrangles fit, their triangles are cut alike.
pub(crate) fn layered(order: Order) -> impl Fn(usize) -> Elements {
    let of = move |linear, quadratic| if order == Order::Linear { linear } else { quadratic };
    let hex = of(ElementKind::Hex8, ElementKind::Hex20);
    let wedge = of(ElementKind::Wedge6, ElementKind::Wedge15);
    move |cell: usize| match cell % 4 {
        0 => vec![(wedge, vec![0, 1, 2, 4, 5, 6]), (wedge, vec![0, 2, 3, 4, 6, 7])],
        _ => vec![(hex, (0..8).collect())],
    }
}
