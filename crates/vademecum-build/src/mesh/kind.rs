//! Kinds of elements: nodes, edges, faces, and their numbers in files. A new kind is a row of [`ROWS`] and
//! its shape functions (`mesh::shapes`).
//!
//! Nodes are in VTK's order, which is that of Abaqus and CalculiX too: corners, then the middles of edges,
//! then those of faces, then that of the element. Wedges have their first triangle counter-clockwise seen
//! from inside, as those programs do.

use serde::{Deserialize, Serialize};

use super::order::Order;

/// A shape of element with a number of nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum ElementKind {
    /// 4-node tetrahedron.
    Tet4,
    /// 10-node tetrahedron.
    Tet10,
    /// 5-node pyramid.
    Pyramid5,
    /// 13-node pyramid.
    Pyramid13,
    /// 6-node wedge.
    Wedge6,
    /// 15-node wedge.
    Wedge15,
    /// 8-node hexahedron.
    Hex8,
    /// 20-node hexahedron.
    Hex20,
    /// 27-node hexahedron.
    Hex27,
}

/// A shape of surface facet with a number of nodes: corners counter-clockwise seen from outside, then the
/// middles of their edges in turn, then that of the facet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FacetKind {
    /// 3-node triangle.
    Tri3,
    /// 6-node triangle.
    Tri6,
    /// 4-node quadrangle.
    Quad4,
    /// 8-node quadrangle.
    Quad8,
    /// 9-node quadrangle.
    Quad9,
}

/// Most nodes of a facet.
pub(crate) const MAX_FACET_NODES: usize = 9;

impl FacetKind {
    /// Number of nodes.
    pub const fn nodes(self) -> usize {
        match self {
            Self::Tri3 => 3,
            Self::Quad4 => 4,
            Self::Tri6 => 6,
            Self::Quad8 => 8,
            Self::Quad9 => 9,
        }
    }

    /// Number of corners.
    pub const fn corners(self) -> usize {
        match self {
            Self::Tri3 | Self::Tri6 => 3,
            Self::Quad4 | Self::Quad8 | Self::Quad9 => 4,
        }
    }

    /// Linear triangles that a facet is touched and drawn by, outward.
    pub(crate) const fn triangles(self) -> &'static [[usize; 3]] {
        match self {
            Self::Tri3 => &[[0, 1, 2]],
            Self::Tri6 => &[[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
            Self::Quad4 => &[[0, 1, 2], [0, 2, 3]],
            Self::Quad8 => &[[0, 4, 7], [4, 1, 5], [5, 2, 6], [6, 3, 7], [4, 5, 6], [4, 6, 7]],
            Self::Quad9 => {
                &[[0, 4, 8], [0, 8, 7], [4, 1, 5], [4, 5, 8], [8, 5, 2], [8, 2, 6], [7, 8, 6], [7, 6, 3]]
            }
        }
    }
}

/// One kind.
struct Row {
    kind: ElementKind,
    name: &'static str,
    corners: usize,
    order: Order,
    /// Ends of the edges whose middles follow the corners, in a quadratic kind; of all edges in a linear one.
    edges: &'static [[usize; 2]],
    /// Nodes of the faces, as [`FacetKind`] orders them.
    faces: &'static [(FacetKind, &'static [usize])],
    /// Nodes of the mirrored element: the first corners exchanged that turn it round.
    mirror: &'static [usize],
    /// `vtkCellType.h`.
    vtk: u8,
}

/// Edges of a tetrahedron, in the order of its mid-side nodes.
pub(crate) const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// Corners of the faces of a tetrahedron, seen from outside.
pub(crate) const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

const TET_EDGES: &[[usize; 2]] = &EDGES;
const PYRAMID_EDGES: &[[usize; 2]] = &[[0, 1], [1, 2], [2, 3], [3, 0], [0, 4], [1, 4], [2, 4], [3, 4]];
const WEDGE_EDGES: &[[usize; 2]] = &[[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3], [0, 3], [1, 4], [2, 5]];
const HEX_EDGES: &[[usize; 2]] =
    &[[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];

/// All kinds, in the order of [`ElementKind`].
const ROWS: [Row; 9] = [
    Row {
        kind: ElementKind::Tet4,
        name: "4-node tetrahedron",
        corners: 4,
        order: Order::Linear,
        edges: TET_EDGES,
        faces: &[
            (FacetKind::Tri3, &[0, 2, 1]),
            (FacetKind::Tri3, &[0, 1, 3]),
            (FacetKind::Tri3, &[1, 2, 3]),
            (FacetKind::Tri3, &[0, 3, 2]),
        ],
        mirror: &[1, 0, 2, 3],
        vtk: 10,
    },
    Row {
        kind: ElementKind::Tet10,
        name: "10-node tetrahedron",
        corners: 4,
        order: Order::Quadratic,
        edges: TET_EDGES,
        faces: &[
            (FacetKind::Tri6, &[0, 2, 1, 6, 5, 4]),
            (FacetKind::Tri6, &[0, 1, 3, 4, 8, 7]),
            (FacetKind::Tri6, &[1, 2, 3, 5, 9, 8]),
            (FacetKind::Tri6, &[0, 3, 2, 7, 9, 6]),
        ],
        mirror: &[1, 0, 2, 3, 4, 6, 5, 8, 7, 9],
        vtk: 24,
    },
    Row {
        kind: ElementKind::Pyramid5,
        name: "5-node pyramid",
        corners: 5,
        order: Order::Linear,
        edges: PYRAMID_EDGES,
        faces: &[
            (FacetKind::Quad4, &[0, 3, 2, 1]),
            (FacetKind::Tri3, &[0, 1, 4]),
            (FacetKind::Tri3, &[1, 2, 4]),
            (FacetKind::Tri3, &[2, 3, 4]),
            (FacetKind::Tri3, &[3, 0, 4]),
        ],
        mirror: &[0, 3, 2, 1, 4],
        vtk: 14,
    },
    Row {
        kind: ElementKind::Pyramid13,
        name: "13-node pyramid",
        corners: 5,
        order: Order::Quadratic,
        edges: PYRAMID_EDGES,
        faces: &[
            (FacetKind::Quad8, &[0, 3, 2, 1, 8, 7, 6, 5]),
            (FacetKind::Tri6, &[0, 1, 4, 5, 10, 9]),
            (FacetKind::Tri6, &[1, 2, 4, 6, 11, 10]),
            (FacetKind::Tri6, &[2, 3, 4, 7, 12, 11]),
            (FacetKind::Tri6, &[3, 0, 4, 8, 9, 12]),
        ],
        mirror: &[0, 3, 2, 1, 4, 8, 7, 6, 5, 9, 12, 11, 10],
        vtk: 27,
    },
    Row {
        kind: ElementKind::Wedge6,
        name: "6-node wedge",
        corners: 6,
        order: Order::Linear,
        edges: WEDGE_EDGES,
        faces: &[
            (FacetKind::Tri3, &[0, 2, 1]),
            (FacetKind::Tri3, &[3, 4, 5]),
            (FacetKind::Quad4, &[0, 1, 4, 3]),
            (FacetKind::Quad4, &[1, 2, 5, 4]),
            (FacetKind::Quad4, &[2, 0, 3, 5]),
        ],
        mirror: &[3, 4, 5, 0, 1, 2],
        vtk: 13,
    },
    Row {
        kind: ElementKind::Wedge15,
        name: "15-node wedge",
        corners: 6,
        order: Order::Quadratic,
        edges: WEDGE_EDGES,
        faces: &[
            (FacetKind::Tri6, &[0, 2, 1, 8, 7, 6]),
            (FacetKind::Tri6, &[3, 4, 5, 9, 10, 11]),
            (FacetKind::Quad8, &[0, 1, 4, 3, 6, 13, 9, 12]),
            (FacetKind::Quad8, &[1, 2, 5, 4, 7, 14, 10, 13]),
            (FacetKind::Quad8, &[2, 0, 3, 5, 8, 12, 11, 14]),
        ],
        mirror: &[3, 4, 5, 0, 1, 2, 9, 10, 11, 6, 7, 8, 12, 13, 14],
        vtk: 26,
    },
    Row {
        kind: ElementKind::Hex8,
        name: "8-node hexahedron",
        corners: 8,
        order: Order::Linear,
        edges: HEX_EDGES,
        faces: &[
            (FacetKind::Quad4, &[0, 3, 2, 1]),
            (FacetKind::Quad4, &[4, 5, 6, 7]),
            (FacetKind::Quad4, &[0, 1, 5, 4]),
            (FacetKind::Quad4, &[1, 2, 6, 5]),
            (FacetKind::Quad4, &[2, 3, 7, 6]),
            (FacetKind::Quad4, &[3, 0, 4, 7]),
        ],
        mirror: &[4, 5, 6, 7, 0, 1, 2, 3],
        vtk: 12,
    },
    Row {
        kind: ElementKind::Hex20,
        name: "20-node hexahedron",
        corners: 8,
        order: Order::Quadratic,
        edges: HEX_EDGES,
        faces: &[
            (FacetKind::Quad8, &[0, 3, 2, 1, 11, 10, 9, 8]),
            (FacetKind::Quad8, &[4, 5, 6, 7, 12, 13, 14, 15]),
            (FacetKind::Quad8, &[0, 1, 5, 4, 8, 17, 12, 16]),
            (FacetKind::Quad8, &[1, 2, 6, 5, 9, 18, 13, 17]),
            (FacetKind::Quad8, &[2, 3, 7, 6, 10, 19, 14, 18]),
            (FacetKind::Quad8, &[3, 0, 4, 7, 11, 16, 15, 19]),
        ],
        mirror: &[4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11, 16, 17, 18, 19],
        vtk: 25,
    },
    Row {
        kind: ElementKind::Hex27,
        name: "27-node hexahedron",
        corners: 8,
        order: Order::Quadratic,
        edges: HEX_EDGES,
        faces: &[
            (FacetKind::Quad9, &[0, 3, 2, 1, 11, 10, 9, 8, 24]),
            (FacetKind::Quad9, &[4, 5, 6, 7, 12, 13, 14, 15, 25]),
            (FacetKind::Quad9, &[0, 1, 5, 4, 8, 17, 12, 16, 22]),
            (FacetKind::Quad9, &[1, 2, 6, 5, 9, 18, 13, 17, 21]),
            (FacetKind::Quad9, &[2, 3, 7, 6, 10, 19, 14, 18, 23]),
            (FacetKind::Quad9, &[3, 0, 4, 7, 11, 16, 15, 19, 20]),
        ],
        mirror: &[
            4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11, 16, 17, 18, 19, 20, 21, 22, 23, 25, 24, 26,
        ],
        vtk: 29,
    },
];

impl ElementKind {
    /// All kinds.
    pub fn all() -> impl Iterator<Item = ElementKind> {
        ROWS.iter().map(|row| row.kind)
    }

    fn row(self) -> &'static Row {
        &ROWS[self as usize]
    }

    /// Its name for people.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Nodes of one element.
    pub fn nodes(self) -> usize {
        self.row().mirror.len()
    }

    /// Corners of one element.
    pub fn corners(self) -> usize {
        self.row().corners
    }

    /// Polynomial order of the displacement along an edge.
    pub fn order(self) -> Order {
        self.row().order
    }

    /// Ends of the edges, by place in the element; in a quadratic kind their middles follow the corners.
    pub fn edges(self) -> &'static [[usize; 2]] {
        self.row().edges
    }

    /// Faces, seen from outside.
    pub fn faces(self) -> &'static [(FacetKind, &'static [usize])] {
        self.row().faces
    }

    /// Places of the nodes of the element turned inside out.
    pub(crate) fn mirror(self) -> &'static [usize] {
        self.row().mirror
    }

    /// The first kind with this number of corners and this order.
    pub(crate) fn with_corners(corners: usize, order: Order) -> Option<Self> {
        ROWS.iter().find(|row| row.corners == corners && row.order == order).map(|row| row.kind)
    }

    /// The kind of the same shape that has corners only.
    pub(crate) fn linear(self) -> Self {
        Self::with_corners(self.corners(), Order::Linear).unwrap_or(self)
    }

    /// VTK's number of the cell.
    pub fn vtk(self) -> u8 {
        self.row().vtk
    }

    /// True for tetrahedra.
    pub fn is_tetrahedron(self) -> bool {
        matches!(self, ElementKind::Tet4 | ElementKind::Tet10)
    }
}

impl From<Order> for ElementKind {
    fn from(order: Order) -> Self {
        match order {
            Order::Linear => ElementKind::Tet4,
            Order::Quadratic => ElementKind::Tet10,
        }
    }
}

/// The kinds of a mesh's elements, and where the nodes of each begin in its list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ElementKinds {
    /// All elements are alike.
    Uniform(ElementKind),
    /// The kind of each element, and the place of its first node; one more place at the end.
    Mixed {
        /// Kind of each.
        kinds: Vec<ElementKind>,
        /// Places, ascending.
        starts: Vec<u32>,
    },
}

impl From<Order> for ElementKinds {
    fn from(order: Order) -> Self {
        Self::Uniform(order.into())
    }
}

impl FromIterator<ElementKind> for ElementKinds {
    /// Uniform where all are alike; 4-node tetrahedra where there is none.
    fn from_iter<I: IntoIterator<Item = ElementKind>>(kinds: I) -> Self {
        let kinds: Vec<ElementKind> = kinds.into_iter().collect();
        let first = kinds.first().copied().unwrap_or(ElementKind::Tet4);
        if kinds.iter().all(|&kind| kind == first) {
            return Self::Uniform(first);
        }
        let mut starts = vec![0];
        for kind in &kinds {
            starts.push(starts[starts.len() - 1] + kind.nodes() as u32);
        }
        Self::Mixed { kinds, starts }
    }
}

impl ElementKinds {
    /// The one kind of all elements, if they are alike.
    pub fn uniform(&self) -> Option<ElementKind> {
        match self {
            Self::Uniform(kind) => Some(*kind),
            Self::Mixed { .. } => None,
        }
    }

    /// Kind of one element.
    ///
    /// # Panics
    /// If there is no such element in a mixed mesh.
    pub fn kind(&self, element: usize) -> ElementKind {
        match self {
            Self::Uniform(kind) => *kind,
            Self::Mixed { kinds, .. } => kinds[element],
        }
    }

    /// Places of the nodes of one element in the list.
    ///
    /// # Panics
    /// If there is no such element in a mixed mesh.
    pub fn range(&self, element: usize) -> std::ops::Range<usize> {
        match self {
            Self::Uniform(kind) => kind.nodes() * element..kind.nodes() * (element + 1),
            Self::Mixed { starts, .. } => starts[element] as usize..starts[element + 1] as usize,
        }
    }

    /// Number of elements on a list of nodes.
    pub(crate) fn count(&self, nodes: usize) -> usize {
        match self {
            Self::Uniform(kind) => nodes / kind.nodes(),
            Self::Mixed { kinds, .. } => kinds.len(),
        }
    }

    /// Kind and nodes of each element.
    pub fn each<'a>(&'a self, nodes: &'a [u32]) -> impl Iterator<Item = (ElementKind, &'a [u32])> + 'a {
        (0..self.count(nodes.len())).map(|element| (self.kind(element), &nodes[self.range(element)]))
    }

    /// The kinds that occur.
    pub(crate) fn distinct(&self) -> Vec<ElementKind> {
        match self {
            Self::Uniform(kind) => vec![*kind],
            Self::Mixed { kinds, .. } => ElementKind::all().filter(|kind| kinds.contains(kind)).collect(),
        }
    }
}

/// Corners of a face in ascending order, the last one `u32::MAX` for a triangle, and the sense in which the
/// face runs through them: the two elements of a face see it in two senses.
pub(crate) type FaceKey = ([u32; 4], bool);

/// The key of a face of an element.
pub(crate) fn face_key(face: &(FacetKind, &[usize]), element: &[u32]) -> FaceKey {
    let corners = face.0.corners();
    let nodes: [u32; 4] = std::array::from_fn(|i| if i < corners { element[face.1[i]] } else { u32::MAX });
    let least = (0..corners).min_by_key(|&i| nodes[i]).unwrap_or(0);
    let (next, last) = (nodes[(least + 1) % corners], nodes[(least + corners - 1) % corners]);
    let mut sorted = nodes;
    sorted.sort_unstable();
    (sorted, next > last)
}

/// Three corners, ascending, by which a face is named: of a quadrangle any three.
pub(crate) fn corner_triples([a, b, c, d]: [u32; 4]) -> Vec<[u32; 3]> {
    if d == u32::MAX { vec![[a, b, c]] } else { vec![[a, b, c], [a, b, d], [a, c, d], [b, c, d]] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_in_order_and_every_node_of_a_face_belongs_to_it() {
        for (place, row) in ROWS.iter().enumerate() {
            assert_eq!(row.kind as usize, place);
            if row.kind.is_tetrahedron() {
                assert!(row.faces.iter().zip(FACES).all(|(face, corners)| face.1[..3] == corners));
            }
            let middles = if row.order == Order::Quadratic { row.edges.len() } else { 0 };
            assert!(row.mirror.len() >= row.corners + middles, "{}", row.name);
            for (facet, nodes) in row.faces {
                let corners = facet.corners();
                // Middles of the face's edges are those of the element.
                for i in 0..corners.min(nodes.len() - corners) {
                    let mut ends = [nodes[i], nodes[(i + 1) % corners]];
                    ends.sort_unstable();
                    let mut edge = row.edges[nodes[corners + i] - row.corners];
                    edge.sort_unstable();
                    assert_eq!(ends, edge, "{} {nodes:?}", row.name);
                }
            }
            // Each edge is in two faces, once in each sense.
            let runs = |a: usize, b: usize| {
                let of_face = |(facet, nodes): &&(FacetKind, &[usize])| {
                    let corners = facet.corners();
                    (0..corners).any(|i| nodes[i] == a && nodes[(i + 1) % corners] == b)
                };
                row.faces.iter().filter(of_face).count()
            };
            for &[a, b] in row.edges {
                assert_eq!((runs(a, b), runs(b, a)), (1, 1), "{} {a} {b}", row.name);
            }
            // Mirroring twice changes nothing, and middles stay in the middle.
            for (i, &j) in row.mirror.iter().enumerate() {
                assert_eq!(row.mirror[j], i, "{}", row.name);
            }
            for (e, ends) in row.edges.iter().enumerate().take(middles) {
                let mut mirrored = ends.map(|end| row.mirror[end]);
                let mut there = row.edges[row.mirror[row.corners + e] - row.corners];
                mirrored.sort_unstable();
                there.sort_unstable();
                assert_eq!(mirrored, there, "{} {e}", row.name);
            }
        }
    }

    #[test]
    fn kinds_of_a_mixed_mesh_know_their_nodes() {
        let kinds: ElementKinds = [ElementKind::Hex8, ElementKind::Tet4].into_iter().collect();
        let nodes: Vec<u32> = (0..12).collect();
        let found: Vec<_> = kinds.each(&nodes).collect();
        assert_eq!(found, [(ElementKind::Hex8, &nodes[..8]), (ElementKind::Tet4, &nodes[8..])]);
        assert_eq!(kinds.uniform(), None);
        assert_eq!(kinds.distinct(), [ElementKind::Tet4, ElementKind::Hex8]);
    }
}
