//! The description of a superelement: `superelement.json`.

use serde::Serialize;
use vademecum_build::prepared::Interface;

use super::body::ReducedBody;

/// Words of motions.
pub(super) const MOTIONS: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// The rows of the matrices, and what they belong to.
#[derive(Clone, Debug, Serialize)]
pub struct Description {
    /// Version of this list.
    version: u32,
    /// Title of the problem.
    title: String,
    /// Units of the problem.
    units: String,
    /// Method of the reduction.
    method: &'static str,
    /// Coordinates r of the superelement.
    pub size: usize,
    /// Coordinates m of the interfaces, the first ones.
    pub interface_size: usize,
    /// Free dofs of the full order; absent of a vademecum file.
    pub dofs: Option<usize>,
    /// Nodes of the mesh, or of the surface of a vademecum file.
    pub nodes: usize,
    /// True of a body without supports.
    pub free: bool,
    /// Rayleigh damping \[1/s\].
    alpha: f64,
    /// Rayleigh damping \[s\].
    beta: f64,
    /// The interfaces.
    pub interfaces: Vec<InterfaceDescription>,
    /// Coordinates of the interfaces, in order.
    coordinates: Vec<CoordinateDescription>,
    /// Frequencies of the normal modes \[Hz\].
    pub frequencies_hz: Vec<f64>,
}

/// An interface.
#[derive(Clone, Debug, Serialize)]
pub struct InterfaceDescription {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: &'static str,
    /// Its first coordinate, and how many.
    pub first: usize,
    /// Number of its coordinates.
    pub count: usize,
    /// Origin of a frame, or the mean of the nodes \[m\].
    pub origin: [f64; 3],
    /// Axes of its motions.
    axes: [[f64; 3]; 3],
    /// Numbers of its nodes in the mesh file.
    nodes: Vec<u64>,
}

/// A coordinate of an interface.
#[derive(Clone, Copy, Debug, Serialize)]
struct CoordinateDescription {
    /// Place of the interface in the list.
    interface: usize,
    /// Number of the node in the mesh file; none of a frame.
    node: Option<u64>,
    /// `x`, `y`, `z`, and of frames `rx`, `ry`, `rz`: along and about the axes of the interface.
    motion: &'static str,
}

impl Description {
    /// The description of a body: the contents of `superelement.json`.
    pub fn new(body: &ReducedBody) -> Self {
        let found = &body.superelement;
        let mut first = 0;
        let described = |interface: &Interface| {
            let own = first;
            first += interface.coordinates.len();
            InterfaceDescription {
                name: interface.name.clone(),
                kind: interface.kind,
                first: own,
                count: interface.coordinates.len(),
                origin: interface.origin,
                axes: interface.axes,
                nodes: interface.nodes.iter().map(|&node| body.node_id(node)).collect(),
            }
        };
        let interfaces = found.interfaces.iter().map(described).collect();
        let coordinates = found.interfaces.iter().enumerate().flat_map(|(place, interface)| {
            interface.coordinates.iter().map(move |coordinate| CoordinateDescription {
                interface: place,
                node: coordinate.node.map(|node| body.node_id(node)),
                motion: MOTIONS[coordinate.motion],
            })
        });
        Self {
            version: 1,
            title: body.title.clone(),
            units: body.units.clone(),
            method: found.method.word(),
            size: found.mass.nrows(),
            interface_size: found.coordinates,
            dofs: body.dofs,
            nodes: body.nodes.len(),
            free: found.rigid_motions.is_some(),
            alpha: body.rayleigh[0],
            beta: body.rayleigh[1],
            interfaces,
            coordinates: coordinates.collect(),
            frequencies_hz: found.frequencies_hz.clone(),
        }
    }
}
