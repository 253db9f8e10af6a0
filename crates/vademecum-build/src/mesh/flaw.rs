//! The reasons for which a mesh that was read is still refused, in words.

use std::fmt;

use super::place::Location;

/// Volume cells of one kind that cannot be computed with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnsupportedCells {
    /// Their kind in words, for instance `8-node hexahedron`.
    pub kind: String,
    /// Their number.
    pub count: usize,
    /// Position of the first one.
    pub first: Location,
}

/// Why a mesh cannot be computed with.
#[derive(Clone, Debug, PartialEq)]
pub enum Flaw {
    /// Volume cells of kinds that are not computed with.
    UnsupportedElements(Vec<UnsupportedCells>),
    /// There is no solid element.
    NoElements,
    /// Linear and quadratic elements in one mesh.
    MixedOrders {
        /// Number of linear ones.
        linear: usize,
        /// Number of quadratic ones.
        quadratic: usize,
    },
    /// Elements whose volume is zero to rounding.
    DegenerateElements {
        /// Their number.
        count: usize,
        /// File numbers of the corner nodes of the first one.
        first: Vec<u64>,
        /// Centre of the first one.
        position: [f64; 3],
    },
    /// Quadratic elements whose Jacobian is not positive at every quadrature point.
    FoldedElements {
        /// Their number.
        count: usize,
        /// File numbers of the corner nodes of the first one.
        first: Vec<u64>,
        /// Smallest Jacobian relative to that of the straight element, over all elements.
        worst: f64,
        /// True if all of them are positive at the points of the stiffness.
        stiffness_is_sound: bool,
    },
    /// Different nodes at one position.
    DuplicateNodes {
        /// Number of nodes that lie on an earlier one.
        count: usize,
        /// File numbers of the first pair.
        first: [u64; 2],
        /// Position of the first pair.
        position: [f64; 3],
    },
    /// Bodies that share no node.
    Disconnected {
        /// Element count of each body, the largest first.
        elements: Vec<usize>,
        /// File number of one node of each body, in the same order.
        nodes: Vec<u64>,
    },
    /// Faces whose two elements have other nodes between the same corners.
    DifferentFaces {
        /// Number of faces.
        count: usize,
        /// File numbers of the corner nodes of the first one.
        first: Vec<u64>,
    },
    /// Quadrangles that meet two triangles.
    SplitFaces {
        /// Number of quadrangles.
        count: usize,
        /// File numbers of the corner nodes of the first one.
        first: Vec<u64>,
    },
    /// Faces with more than two elements.
    OverlappingElements {
        /// Number of faces.
        count: usize,
        /// File numbers of the corner nodes of the first one.
        first: Vec<u64>,
    },
}

impl fmt::Display for Flaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Flaw::UnsupportedElements(cells) => {
                for cell in cells {
                    write!(f, "{} × {} (first at {}), ", cell.count, cell.kind, cell.first)?;
                }
                write!(
                    f,
                    "but only tetrahedra, hexahedra, wedges and pyramids of first or second order are supported: \
                     mesh the volume with those"
                )
            }
            Flaw::NoElements => {
                write!(f, "no solid elements: mesh the volume, not only its surface, and save all elements")
            }
            Flaw::MixedOrders { linear, quadratic } => write!(
                f,
                "{linear} linear and {quadratic} quadratic elements in one mesh: mesh all of it with one order"
            ),
            Flaw::DifferentFaces { count, first } => write!(
                f,
                "{count} faces have other mid-side nodes on one side than on the other, the first between corner nodes \
                 {first:?}: mesh both sides with elements of one family"
            ),
            Flaw::SplitFaces { count, first } => write!(
                f,
                "{count} quadrangles meet two triangles of their neighbours, the first on nodes {first:?}: put pyramids \
                 between hexahedra and tetrahedra"
            ),
            Flaw::DegenerateElements { count, first, position } => write!(
                f,
                "{count} elements without volume, the first on nodes {first:?} near {position:?}: remesh there"
            ),
            Flaw::FoldedElements { count, first, worst, .. } => write!(
                f,
                "{count} elements folded by their shape or their mid-side nodes (Jacobian down to {worst:.2e} of the straight \
                 element), the first on corner nodes {first:?}: optimise the high-order mesh or refine the curved surface"
            ),
            Flaw::DuplicateNodes { count, first, position } => write!(
                f,
                "{count} nodes lie on top of another one, the first pair is {} and {} at {position:?}: merge coincident \
                 nodes before saving",
                first[0], first[1]
            ),
            Flaw::Disconnected { elements, nodes } => write!(
                f,
                "{} bodies that share no node (elements {}; one node of each: {}): keep one body or merge their \
                 interfaces; `mesh.smallest_part` leaves out small ones",
                elements.len(),
                listed(elements),
                listed(nodes)
            ),
            Flaw::OverlappingElements { count, first } => write!(
                f,
                "{count} faces belong to more than two elements, the first on nodes {first:?}: elements overlap or are \
                 there twice, remesh"
            ),
        }
    }
}

/// A list that stays readable.
pub(super) fn listed<T: fmt::Display>(items: &[T]) -> String {
    let shown: Vec<String> = items.iter().take(8).map(|i| i.to_string()).collect();
    let more = if items.len() > 8 { format!(" and {} more", items.len() - 8) } else { String::new() };
    shown.join(", ") + &more
}
