//! Cells by Gmsh's numbers, and the order of their nodes.

use crate::mesh::raw::CellKind;

/// Meaning of Gmsh's element type numbers.
pub(crate) fn cell_kind(code: i64) -> Option<CellKind> {
    use CellKind::{Line, OtherSurface, OtherVolume};
    Some(match code {
        1 => Line(2),
        2 => CellKind::Triangle3,
        3 => OtherSurface("4-node quadrangle", 4),
        4 => CellKind::Tetrahedron4,
        5 => OtherVolume("8-node hexahedron", 8),
        6 => OtherVolume("6-node wedge", 6),
        7 => OtherVolume("5-node pyramid", 5),
        8 => Line(3),
        9 => CellKind::Triangle6,
        10 => OtherSurface("9-node quadrangle", 9),
        11 => CellKind::Tetrahedron10,
        12 => OtherVolume("27-node hexahedron", 27),
        13 => OtherVolume("18-node wedge", 18),
        14 => OtherVolume("14-node pyramid", 14),
        15 => CellKind::Point,
        16 => OtherSurface("8-node quadrangle", 8),
        17 => OtherVolume("20-node hexahedron", 20),
        18 => OtherVolume("15-node wedge", 15),
        19 => OtherVolume("13-node pyramid", 13),
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

/// Gmsh's 10-node tetrahedron has its last two mid-side nodes on (2,3) and (1,3), ours on (1,3) and (2,3).
pub(crate) fn reorder(kind: CellKind, nodes: &mut [u32]) {
    if kind == CellKind::Tetrahedron10 {
        nodes.swap(8, 9);
    }
}
