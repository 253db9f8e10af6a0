//! Interfaces of a superelement on the body of a problem: nodes, patches, and frames that are rigid or move
//! with the mean of their nodes.

use faer::Mat;

use super::body::Body;
use super::body_error::BodyError;
use super::places::{facets, select};
use super::ports::{MOTIONS, Port, SPACE, along, cloud, mean, mean_motion, three_axes};
use crate::fem::{Facet, rigid_row};
use crate::input::{InterfaceEntry, InterfaceKind, PortEntry, PortKind, Problem, perpendicular};
use crate::linalg::symmetric_eigen;
use crate::linalg::vec3::sub;
use crate::mesh::select::Selection;
use crate::mesh::surface::Surface;

/// Share of the spread of a frame's nodes below which they lie on a line.
const THIN: f64 = 1e-10;

/// An interface of a superelement.
#[derive(Clone, Debug)]
pub struct Interface {
    /// Its name.
    pub name: String,
    /// `nodes`, `patch`, `rigid`, `average`, or `reference` of a reference point.
    pub kind: &'static str,
    /// Its mesh nodes, ascending; none of a reference point.
    pub nodes: Vec<u32>,
    /// Share of each node in the mean, summing to one: by area of an averaging frame, alike otherwise.
    pub weights: Vec<f64>,
    /// Origin of a frame, or the mean of the nodes.
    pub origin: [f64; 3],
    /// Axes along which and about which the motions of a frame are; otherwise those of space.
    pub axes: [[f64; 3]; 3],
    /// Its coordinates.
    pub coordinates: Vec<Coordinate>,
    /// Relation of the coordinates to the free dofs.
    pub rows: InterfaceRows,
}

/// A coordinate of an interface: a motion of a node or of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coordinate {
    /// The node in the mesh; none of a frame.
    pub node: Option<u32>,
    /// Displacement along the axes, 0 to 2, or rotation about them, 3 to 5.
    pub motion: usize,
}

/// Relation of the coordinates of an interface to the free dofs.
#[derive(Clone, Debug)]
pub enum InterfaceRows {
    /// Each coordinate as free dofs and weights.
    Means(Vec<Vec<(u32, f64)>>),
    /// Free dofs that follow the six motions of a frame, with their weights.
    Followers(Vec<(u32, [f64; MOTIONS])>),
}

/// Why an interface does not fit the body.
#[derive(Debug, thiserror::Error)]
pub enum InterfaceError {
    /// A selection that fits nothing.
    #[error(transparent)]
    Body(#[from] BodyError),
    /// Nothing of this name.
    #[error(
        "--interface {name}: no port of the problem and no group of the mesh has this name; there are {known}; or give its \
         nodes: --interface '{name}={{ on = … }}'"
    )]
    Unknown {
        /// The name.
        name: String,
        /// Names of ports and groups, or `none`.
        known: String,
    },
    /// No interface is given, and the problem has no ports.
    #[error("no interface: name one with --interface, or give the problem a `[[port]]`")]
    None,
    /// Two interfaces of one name.
    #[error("--interface {name} is given twice; expected one name for each interface")]
    Twice {
        /// The name.
        name: String,
    },
    /// A key that the kind does not take.
    #[error("--interface {name}: `{key}` is given for an interface of kind {kind}; expected {expected}")]
    Key {
        /// The interface.
        name: String,
        /// The key.
        key: &'static str,
        /// Its kind.
        kind: &'static str,
        /// Usable values.
        expected: &'static str,
    },
    /// Nodes of a frame on a line.
    #[error(
        "--interface {name}: the {count} nodes of the frame lie on a line, about which they have no rotation; select nodes \
         of a surface, or take kind nodes"
    )]
    OnLine {
        /// The interface.
        name: String,
        /// Number of nodes.
        count: usize,
    },
    /// A node of a frame that is held or follows other nodes.
    #[error(
        "--interface {name}: node {node} of the frame is held by a support or follows an attachment; select nodes that are \
         free, or remove the support"
    )]
    NotFree {
        /// The interface.
        name: String,
        /// Number of the node in the mesh file.
        node: u64,
    },
    /// All coordinates are held.
    #[error("--interface {name}: supports hold all of its displacements; select nodes that can move")]
    Held {
        /// The interface.
        name: String,
    },
}

/// The interfaces that entries name; without any, the ports of the problem.
///
/// # Errors
/// [`InterfaceError`].
pub fn interfaces(
    problem: &Problem,
    body: &Body,
    entries: &[InterfaceEntry],
) -> Result<Vec<Interface>, InterfaceError> {
    let surface = Surface::of(body.model.mesh());
    let found: Vec<Interface> = if entries.is_empty() {
        let ports = problem.ports.iter().zip(&body.ports);
        ports.map(|port| of_port(problem, body, &surface, port)).collect::<Result<_, _>>()?
    } else {
        let one = |entry| interface(problem, body, &surface, entry);
        entries.iter().map(one).collect::<Result<_, _>>()?
    };
    if found.is_empty() {
        return Err(InterfaceError::None);
    }
    for (i, interface) in found.iter().enumerate() {
        if found[..i].iter().any(|other| other.name == interface.name) {
            return Err(InterfaceError::Twice { name: interface.name.clone() });
        }
    }
    let free = |interface: Interface| match interface.coordinates.is_empty() {
        true => Err(InterfaceError::Held { name: interface.name }),
        false => Ok(interface),
    };
    found.into_iter().map(|interface| free(interface.without_held())).collect()
}

impl Interface {
    /// The same without displacements that supports hold.
    fn without_held(self) -> Self {
        let InterfaceRows::Means(rows) = self.rows else { return self };
        let (mut coordinates, mut kept) = (vec![], vec![]);
        for (coordinate, row) in self.coordinates.iter().zip(rows) {
            if !row.is_empty() {
                coordinates.push(*coordinate);
                kept.push(row);
            }
        }
        Self { coordinates, rows: InterfaceRows::Means(kept), ..self }
    }
}

/// A port as an interface: its nodes, or the motions of its reference point.
fn of_port(
    problem: &Problem,
    body: &Body,
    surface: &Surface,
    (entry, port): (&PortEntry, &Port),
) -> Result<Interface, InterfaceError> {
    let Some(on) = &entry.on else {
        return Ok(Interface {
            name: port.name.clone(),
            kind: "reference",
            nodes: vec![],
            weights: vec![],
            origin: port.origin,
            axes: port.axes,
            coordinates: of_frame(),
            rows: InterfaceRows::Means(port.rows.clone()),
        });
    };
    let kind = if entry.kind == PortKind::Patch { InterfaceKind::Patch } else { InterfaceKind::Average };
    let own = InterfaceEntry {
        name: entry.name.clone(),
        kind: Some(kind),
        on: Some(on.clone()),
        at: entry.at,
        axes: entry.axes,
    };
    interface(problem, body, surface, &own)
}

fn of_nodes(nodes: &[u32]) -> Vec<Coordinate> {
    let of_node = |&node: &u32| (0..3).map(move |motion| Coordinate { node: Some(node), motion });
    nodes.iter().flat_map(of_node).collect()
}

fn of_frame() -> Vec<Coordinate> {
    (0..MOTIONS).map(|motion| Coordinate { node: None, motion }).collect()
}

fn interface(
    problem: &Problem,
    body: &Body,
    surface: &Surface,
    entry: &InterfaceEntry,
) -> Result<Interface, InterfaceError> {
    let mesh = body.model.mesh();
    let name = entry.name.clone();
    let group = || {
        if mesh.node_groups.contains_key(&name) {
            return Ok(Selection::Group(name.clone()));
        }
        let ports = problem.ports.iter().map(|port| &port.name);
        let names: Vec<String> = ports.chain(mesh.node_groups.keys()).map(|n| format!("`{n}`")).collect();
        let known = if names.is_empty() { "none".into() } else { names.join(", ") };
        Err(InterfaceError::Unknown { name: name.clone(), known })
    };
    let port = problem.ports.iter().zip(&body.ports).find(|(port, _)| port.name == name);
    if let (None, None, Some((entry, port))) = (entry.kind, &entry.on, port) {
        return of_port(problem, body, surface, (entry, port));
    }
    let on = entry.on.clone().map_or_else(group, Ok)?;
    let kind = entry.kind.unwrap_or(InterfaceKind::Patch);
    let is_frame = matches!(kind, InterfaceKind::Rigid | InterfaceKind::Average);
    let refused =
        |key, expected| Err(InterfaceError::Key { name: name.clone(), key, kind: kind.word(), expected });
    if entry.at.is_some() && !is_frame {
        return refused("at", "the origin of a frame, kind rigid or average");
    }
    if entry.axes.is_some_and(|axes| !is_frame || !perpendicular(axes)) {
        return refused("axes", "two perpendicular directions, of a frame of kind rigid or average");
    }
    let key = || format!("--interface {name}");
    let mut cloud_of = vec![];
    let nodes = match kind {
        InterfaceKind::Nodes | InterfaceKind::Rigid => select(problem, &on, mesh, key)?,
        InterfaceKind::Patch => {
            let facets = facets(problem, &on, mesh, surface, key)?;
            let mut nodes: Vec<u32> = facets.iter().flat_map(Facet::nodes).copied().collect();
            nodes.sort_unstable();
            nodes.dedup();
            nodes
        }
        InterfaceKind::Average => {
            cloud_of = cloud(mesh, &facets(problem, &on, mesh, surface, key)?);
            cloud_of.iter().map(|(node, _)| *node).collect()
        }
    };
    if is_frame && on_line(mesh.nodes.as_slice(), &nodes) {
        return Err(InterfaceError::OnLine { name, count: nodes.len() });
    }
    let whole: f64 = cloud_of.iter().map(|(_, weight)| weight).sum();
    let weighted =
        |c: usize| cloud_of.iter().map(|&(node, w)| w / whole * mesh.nodes[node as usize][c]).sum();
    let centre = if cloud_of.is_empty() { mean(mesh, &nodes) } else { std::array::from_fn(weighted) };
    let origin = entry.at.unwrap_or(centre);
    let axes = three_axes(entry.axes);
    let dofs = body.model.dofs();
    let rows = match kind {
        InterfaceKind::Nodes | InterfaceKind::Patch => {
            let of_node = |&node: &u32| (0..3).map(move |c| dofs.terms(3 * node as usize + c).collect());
            InterfaceRows::Means(nodes.iter().flat_map(of_node).collect())
        }
        InterfaceKind::Average => {
            InterfaceRows::Means(along(axes, &mean_motion(mesh, origin, &cloud_of), dofs))
        }
        InterfaceKind::Rigid => {
            let follower = |node: u32, c: usize| {
                let free = dofs.free(3 * node as usize + c).ok_or_else(|| InterfaceError::NotFree {
                    name: name.clone(),
                    node: mesh.node_ids.get(node as usize).copied().unwrap_or(u64::from(node)),
                })?;
                Ok((free, along_axes(axes, rigid_row(sub(mesh.nodes[node as usize], origin), c))))
            };
            let all = nodes.iter().flat_map(|&node| (0..3).map(move |c| (node, c)));
            let rows = all.map(|(node, c)| follower(node, c)).collect::<Result<_, InterfaceError>>()?;
            InterfaceRows::Followers(rows)
        }
    };
    let coordinates = if is_frame { of_frame() } else { of_nodes(&nodes) };
    let axes = if is_frame { axes } else { SPACE };
    let weights = match cloud_of.as_slice() {
        [] => vec![1.0 / nodes.len() as f64; nodes.len()],
        cloud => cloud.iter().map(|(_, weight)| weight / whole).collect(),
    };
    Ok(Interface { name, kind: kind.word(), nodes, weights, origin, axes, coordinates, rows })
}

/// Weights of motions along and about the axes of space as weights of those of a frame.
fn along_axes(axes: [[f64; 3]; 3], row: [f64; MOTIONS]) -> [f64; MOTIONS] {
    std::array::from_fn(|k| (0..3).map(|s| axes[k % 3][s] * row[3 * (k / 3) + s]).sum())
}

/// True of nodes that a rotation leaves where they are.
fn on_line(places: &[[f64; 3]], nodes: &[u32]) -> bool {
    let count = nodes.len().max(1) as f64;
    let centre: [f64; 3] =
        std::array::from_fn(|c| nodes.iter().map(|&node| places[node as usize][c] / count).sum());
    let mut spread = Mat::zeros(3, 3);
    for &node in nodes {
        let arm = sub(places[node as usize], centre);
        (0..3).for_each(|i| (0..3).for_each(|j| spread[(i, j)] += arm[i] * arm[j]));
    }
    symmetric_eigen(spread.as_ref()).is_ok_and(|(values, _)| values[1] <= THIN * values[2])
}
