//! Choosing nodes of a mesh: by group, by number, by where they are.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Mesh, bounding_box};
use crate::linalg::vec3::{dot, norm, sub};
use crate::suggest::did_you_mean;

/// A choice of nodes, written in a problem file as a table with one key, for instance `{ group = "fixed" }`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum Selection {
    /// The nodes of a named group (of nodes, facets or a region).
    Group(String),
    /// Nodes by their numbers in the mesh file.
    Nodes(Vec<u64>),
    /// Nodes on a plane.
    Plane(Plane),
    /// Nodes in an axis-parallel box, its sides included.
    Box(Cuboid),
    /// Nodes in a ball, its surface included.
    Sphere(Ball),
    /// Nodes in the outermost part of the bounding box along an axis.
    Fraction(Share),
    /// The given share of all nodes: those that lie furthest along an axis (rounded to the nearest count, at
    /// least one; nodes at equal distance in file order).
    Quantile(Share),
    /// Nodes in any of these.
    Any(Vec<Selection>),
    /// Nodes in all of these.
    All(Vec<Selection>),
}

/// A coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum AxisName {
    /// First coordinate.
    X,
    /// Second coordinate.
    Y,
    /// Third coordinate.
    Z,
}

/// The low or the high end of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// Smallest coordinates.
    Min,
    /// Largest coordinates.
    Max,
}

/// A plane: `axis` and `at`, or `normal` (of any length) and `point`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Plane {
    /// Axis the plane is normal to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) axis: Option<AxisName>,
    /// Coordinate on that axis, in the mesh's unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<f64>,
    /// Normal direction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) normal: Option<[f64; 3]>,
    /// A point of the plane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point: Option<[f64; 3]>,
    /// Largest distance from the plane; 1e-6 of the bounding box diagonal if absent, since many meshers write
    /// single precision.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
}

/// An axis-parallel box.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cuboid {
    /// Smallest coordinates.
    pub min: [f64; 3],
    /// Largest coordinates.
    pub max: [f64; 3],
}

/// A ball.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ball {
    /// Centre.
    pub(crate) center: [f64; 3],
    /// Radius.
    pub radius: f64,
}

/// A share of a body along an axis.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Share {
    /// The axis.
    pub(crate) axis: AxisName,
    /// Which end.
    pub side: Side,
    /// Between 0 and 1: of the extent (`fraction`) or of the node count (`quantile`).
    pub(crate) fraction: f64,
}

/// Why a selection cannot be made. The caller's input is at fault in all of them.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SelectError {
    /// The mesh has no group of this name.
    #[error("the mesh has no group `{name}`; it has {known}")]
    UnknownGroup {
        /// The name asked for.
        name: String,
        /// The names there are, or `none`, and the nearest.
        known: String,
    },
    /// The mesh has no node of this number, or dropped it because no element uses it.
    #[error(
        "the mesh has no node {id}: its nodes in use are numbered {least} to {largest}, perhaps with gaps"
    )]
    UnknownNode {
        /// The number asked for.
        id: u64,
        /// Smallest number in use.
        least: u64,
        /// Largest number in use.
        largest: u64,
    },
    /// The predicate itself makes no sense.
    #[error("{0}")]
    BadPredicate(String),
    /// No node fulfils the selection.
    #[error(
        "no node lies in {selection}; the mesh reaches from {low:?} to {high:?} and its groups are {known}"
    )]
    Empty {
        /// The selection, printed.
        selection: String,
        /// Lower corner of the bounding box.
        low: [f64; 3],
        /// Upper corner.
        high: [f64; 3],
        /// The names of the groups, or `none`.
        known: String,
    },
}

impl Selection {
    /// Indices of the chosen nodes, ascending and unique, never empty.
    ///
    /// # Errors
    /// [`SelectError`] for an unknown group or node, a predicate without sense, or an empty result (also of a
    /// part of `any`; parts of `all` are judged together).
    pub fn nodes(&self, mesh: &Mesh) -> Result<Vec<u32>, SelectError> {
        let nodes = self.matching(mesh)?;
        if nodes.is_empty() {
            let (low, high) = bounding_box(&mesh.nodes);
            // In the words of the problem file.
            let written = toml::Value::try_from(self).map(|value| value.to_string());
            let selection = written.unwrap_or_else(|_| "the selection".into());
            return Err(SelectError::Empty { selection, low, high, known: known_groups(mesh) });
        }
        Ok(nodes)
    }

    fn matching(&self, mesh: &Mesh) -> Result<Vec<u32>, SelectError> {
        match self {
            Selection::Group(name) => match mesh.node_groups.get(name) {
                Some(nodes) => Ok(nodes.clone()),
                None => {
                    let nearest = did_you_mean(name, mesh.node_groups.keys().map(String::as_str));
                    let known = known_groups(mesh) + &nearest;
                    Err(SelectError::UnknownGroup { name: name.clone(), known })
                }
            },
            Selection::Nodes(ids) => by_id(ids, mesh),
            Selection::Plane(plane) => on_plane(plane, mesh),
            Selection::Box(cuboid) => Ok(in_box(cuboid, mesh)),
            Selection::Sphere(ball) => in_ball(ball, mesh),
            Selection::Fraction(share) => in_fraction(share, mesh),
            Selection::Quantile(share) => in_quantile(share, mesh),
            Selection::Any(parts) => any(parts, mesh),
            Selection::All(parts) => all(parts, mesh),
        }
    }
}

fn known_groups(mesh: &Mesh) -> String {
    match mesh.node_groups.is_empty() {
        true => "none".into(),
        false => mesh.node_groups.keys().map(|k| format!("`{k}`")).collect::<Vec<_>>().join(", "),
    }
}

fn filtered(mesh: &Mesh, keep: impl Fn([f64; 3]) -> bool) -> Vec<u32> {
    mesh.nodes.iter().zip(0..).filter(|(p, _)| keep(**p)).map(|(_, i)| i).collect()
}

/// Nodes by their numbers in the mesh file, in the order given.
///
/// # Errors
/// [`SelectError::UnknownNode`].
pub(crate) fn numbered(ids: &[u64], mesh: &Mesh) -> Result<Vec<u32>, SelectError> {
    let mut order: Vec<(u64, u32)> = mesh.node_ids.iter().copied().zip(0..).collect();
    order.sort_unstable();
    let find = |&id: &u64| match order.binary_search_by_key(&id, |entry| entry.0) {
        Ok(place) => Ok(order[place].1),
        Err(_) => {
            let least = order.first().map_or(0, |e| e.0);
            let largest = order.last().map_or(0, |e| e.0);
            Err(SelectError::UnknownNode { id, least, largest })
        }
    };
    ids.iter().map(find).collect()
}

fn by_id(ids: &[u64], mesh: &Mesh) -> Result<Vec<u32>, SelectError> {
    let mut nodes = numbered(ids, mesh)?;
    nodes.sort_unstable();
    nodes.dedup();
    Ok(nodes)
}

fn on_plane(plane: &Plane, mesh: &Mesh) -> Result<Vec<u32>, SelectError> {
    let (normal, point) = match (plane.axis, plane.at, plane.normal, plane.point) {
        (Some(axis), Some(at), None, None) => {
            let unit = std::array::from_fn(|k| if k == axis as usize { 1.0 } else { 0.0 });
            (unit, unit.map(|x: f64| x * at))
        }
        (None, None, Some(normal), Some(point)) => (normal, point),
        _ => {
            let message = "a plane is given by `axis` and `at`, or by `normal` and `point`";
            return Err(SelectError::BadPredicate(message.into()));
        }
    };
    let length = norm(normal);
    if !(length > 0.0 && length.is_finite()) {
        return Err(SelectError::BadPredicate(format!("a plane cannot have the normal {normal:?}")));
    }
    let (low, high) = bounding_box(&mesh.nodes);
    let tolerance = plane.tolerance.unwrap_or(1e-6 * norm(sub(high, low)));
    if tolerance.is_nan() || tolerance < 0.0 {
        return Err(SelectError::BadPredicate(format!("a plane cannot have the tolerance {tolerance}")));
    }
    Ok(filtered(mesh, |p| (dot(sub(p, point), normal) / length).abs() <= tolerance))
}

fn in_box(cuboid: &Cuboid, mesh: &Mesh) -> Vec<u32> {
    filtered(mesh, |p| (0..3).all(|k| cuboid.min[k] <= p[k] && p[k] <= cuboid.max[k]))
}

fn in_ball(ball: &Ball, mesh: &Mesh) -> Result<Vec<u32>, SelectError> {
    if ball.radius.is_nan() || ball.radius < 0.0 {
        return Err(SelectError::BadPredicate(format!("a sphere cannot have the radius {}", ball.radius)));
    }
    Ok(filtered(mesh, |p| norm(sub(p, ball.center)) <= ball.radius))
}

fn check_share(share: &Share) -> Result<(), SelectError> {
    if (0.0..=1.0).contains(&share.fraction) {
        return Ok(());
    }
    Err(SelectError::BadPredicate(format!("a fraction lies between 0 and 1, not at {}", share.fraction)))
}

fn in_fraction(share: &Share, mesh: &Mesh) -> Result<Vec<u32>, SelectError> {
    check_share(share)?;
    let (low, high) = bounding_box(&mesh.nodes);
    let k = share.axis as usize;
    let reach = share.fraction * (high[k] - low[k]);
    Ok(match share.side {
        Side::Max => filtered(mesh, |p| high[k] - p[k] <= reach),
        Side::Min => filtered(mesh, |p| p[k] - low[k] <= reach),
    })
}

fn in_quantile(share: &Share, mesh: &Mesh) -> Result<Vec<u32>, SelectError> {
    check_share(share)?;
    let k = share.axis as usize;
    let sign = if share.side == Side::Max { -1.0 } else { 1.0 };
    let mut order: Vec<u32> = (0..mesh.nodes.len() as u32).collect();
    let height = |n: u32| sign * mesh.nodes[n as usize][k];
    // Stable, so that equal heights keep the order of the file.
    order.sort_by(|&a, &b| height(a).total_cmp(&height(b)));
    let count = (share.fraction * order.len() as f64).round() as usize;
    order.truncate(count.max(1));
    order.sort_unstable();
    Ok(order)
}

fn any(parts: &[Selection], mesh: &Mesh) -> Result<Vec<u32>, SelectError> {
    let mut nodes = Vec::new();
    for part in parts {
        nodes.extend(part.nodes(mesh)?);
    }
    nodes.sort_unstable();
    nodes.dedup();
    Ok(nodes)
}

fn all(parts: &[Selection], mesh: &Mesh) -> Result<Vec<u32>, SelectError> {
    let Some((first, rest)) = parts.split_first() else {
        return Ok(Vec::new());
    };
    let mut nodes = first.matching(mesh)?;
    for part in rest {
        let other = part.matching(mesh)?;
        nodes.retain(|n| other.binary_search(n).is_ok());
    }
    Ok(nodes)
}
