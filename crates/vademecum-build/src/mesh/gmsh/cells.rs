//! Cells by Gmsh's numbers, and the order of their nodes.

use crate::mesh::raw::CellKind;
use crate::mesh::{ElementKind, FacetKind};

/// Meaning of Gmsh's element type numbers.
pub(crate) fn cell_kind(code: i64) -> Option<CellKind> {
    use CellKind::{Line, OtherSurface, OtherVolume};
    Some(match code {
        1 => Line(2),
        2 => CellKind::Facet(FacetKind::Tri3),
        3 => CellKind::Facet(FacetKind::Quad4),
        4 => CellKind::Solid(ElementKind::Tet4),
        5 => CellKind::Solid(ElementKind::Hex8),
        6 => CellKind::Solid(ElementKind::Wedge6),
        7 => CellKind::Solid(ElementKind::Pyramid5),
        8 => Line(3),
        9 => CellKind::Facet(FacetKind::Tri6),
        10 => CellKind::Facet(FacetKind::Quad9),
        11 => CellKind::Solid(ElementKind::Tet10),
        12 => CellKind::Solid(ElementKind::Hex27),
        13 => OtherVolume("18-node wedge", 18),
        14 => OtherVolume("14-node pyramid", 14),
        15 => CellKind::Point,
        16 => CellKind::Facet(FacetKind::Quad8),
        17 => CellKind::Solid(ElementKind::Hex20),
        18 => CellKind::Solid(ElementKind::Wedge15),
        19 => CellKind::Solid(ElementKind::Pyramid13),
        20 => OtherSurface("9-node triangle", 9),
        21 => OtherSurface("10-node triangle", 10),
        22 => OtherSurface("12-node triangle", 12),
        23 => OtherSurface("15-node triangle", 15),
        24 => OtherSurface("15-node incomplete triangle", 15),
        25 => OtherSurface("21-node triangle", 21),
        26 => Line(4),
        27 => Line(5),
        28 => Line(6),
        29 => OtherVolume("20-node (cubic) tetrahedron", 20),
        30 => OtherVolume("35-node (quartic) tetrahedron", 35),
        31 => OtherVolume("56-node (quintic) tetrahedron", 56),
        92 => OtherVolume("64-node hexahedron", 64),
        93 => OtherVolume("125-node hexahedron", 125),
        _ => return None,
    })
}

/// Edges of Gmsh's wedges, pyramids and hexahedra, in the order of its mid-side nodes; ours have another one.
const WEDGE: &[[usize; 2]] = &[[0, 1], [0, 2], [0, 3], [1, 2], [1, 4], [2, 5], [3, 4], [3, 5], [4, 5]];
const PYRAMID: &[[usize; 2]] = &[[0, 1], [0, 3], [0, 4], [1, 2], [1, 4], [2, 3], [2, 4], [3, 4]];
const HEXAHEDRON: &[[usize; 2]] =
    &[[0, 1], [0, 3], [0, 4], [1, 2], [1, 5], [2, 3], [2, 6], [3, 7], [4, 5], [4, 7], [5, 6], [6, 7]];

/// Places in Gmsh's 27-node hexahedron of the middles of our faces, of which its own run bottom, front, left,
/// right, back, top.
const FACE_MIDDLES: [usize; 6] = [22, 23, 21, 24, 20, 25];

/// Puts the nodes of a cell into our order.
pub(crate) fn reorder(kind: CellKind, nodes: &mut [u32]) {
    let CellKind::Solid(kind) = kind else { return };
    let edges = match kind {
        // Its last two mid-side nodes are on (2,3) and (1,3), ours on (1,3) and (2,3).
        ElementKind::Tet10 => return nodes.swap(8, 9),
        ElementKind::Wedge15 => WEDGE,
        ElementKind::Pyramid13 => PYRAMID,
        ElementKind::Hex20 | ElementKind::Hex27 => HEXAHEDRON,
        _ => return,
    };
    let given = nodes.to_vec();
    let corners = kind.corners();
    for (place, &[a, b]) in kind.edges().iter().enumerate() {
        let found = edges.iter().position(|edge| *edge == [a, b] || *edge == [b, a]);
        nodes[corners + place] = given[corners + found.unwrap_or(place)];
    }
    if kind == ElementKind::Hex27 {
        FACE_MIDDLES.iter().enumerate().for_each(|(face, &at)| nodes[20 + face] = given[at]);
    }
}
