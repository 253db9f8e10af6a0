//! Supports for a mesh: groups that are called supports, a flat face, or the foot of a body.

use std::collections::BTreeMap;

use vademecum_build::mesh::{Mesh, surface::Surface};
use vademecum_build::suggest::did_you_mean;

use super::toml::{one_line, quoted};

/// A body is long if its longest side is so many times the next.
const LONG: f64 = 2.5;

/// Share of the surface above which a group of facets is no support: a body is held at a part of it.
const LARGEST_GROUP: f64 = 0.3;

/// Share of a body's height, from its foot, that is held where no group and no flat face serves.
const FOOT: f64 = 0.1;

/// Parts of words that name a support in the groups of a mesh.
const SUPPORTS: [&str; 7] = ["fix", "clamp", "bolt", "support", "encastre", "dirichlet", "anchor"];
/// Words that do, which are parts of others.
const SUPPORT_WORDS: [&str; 9] = ["held", "base", "ground", "root", "end", "ends", "foot", "feet", "mount"];
/// Parts of words that name a load or a place to look at.
const LOADS: [&str; 10] =
    ["load", "force", "pressure", "push", "contact", "touch", "traction", "neumann", "free", "probe"];

/// A coordinate axis by its letter.
pub(super) const AXES: [&str; 3] = ["x", "y", "z"];

/// The mesh has no such group or end.
#[derive(Debug, thiserror::Error)]
#[error(
    "`--hold {hold}`: the mesh has no such group (it has {known}); expected one, or bottom, x_min, x_max, y_min, y_max, \
     z_min, z_max, none"
)]
pub struct HoldError {
    /// Place as the user gave it.
    hold: String,
    /// The groups of the mesh.
    known: String,
}

/// Supports of a proposal.
pub(super) struct Supports {
    /// Selections as the problem file writes them, one for each support; none for a free body.
    pub(super) on: Vec<String>,
    /// Description.
    pub(super) words: String,
    /// Groups of facets that could be held instead.
    pub(super) others: Vec<String>,
}

/// Shape of a body, in units of its mesh.
pub(super) struct Shape<'a> {
    mesh: &'a Mesh,
    surface: Surface,
    low: [f64; 3],
    sides: [f64; 3],
    /// Area, unit normal and corners of each triangle of the surface.
    triangles: Vec<Triangle>,
    /// Area of the surface.
    area: f64,
}

struct Triangle {
    area: f64,
    normal: [f64; 3],
    corners: [[f64; 3]; 3],
}

/// A flat face: its area, normal and a point of it.
type Face = (f64, [f64; 3], [f64; 3]);

impl<'a> Shape<'a> {
    pub(super) fn of(mesh: &'a Mesh) -> Self {
        let (low, high) = mesh.bounding_box();
        let of_corners = |corners: [[f64; 3]; 3]| {
            let [a, b, c] = corners;
            let [u, v]: [[f64; 3]; 2] = [b, c].map(|p| std::array::from_fn(|i| p[i] - a[i]));
            let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            let twice = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
            Triangle { area: 0.5 * twice, normal: normal.map(|x| x / twice), corners }
        };
        let surface = Surface::of(mesh);
        let triangles = surface.triangles.iter();
        let triangles = triangles.map(|triangle| of_corners(triangle.map(|node| mesh.nodes[node as usize])));
        let triangles: Vec<Triangle> = triangles.filter(|triangle| triangle.area > 0.0).collect();
        let area = triangles.iter().map(|triangle| triangle.area).sum();
        Self { mesh, surface, low, sides: std::array::from_fn(|c| high[c] - low[c]), triangles, area }
    }

    pub(super) fn longest_side(&self) -> f64 {
        self.sides.iter().copied().fold(0.0, f64::max)
    }

    /// The axis along which a body is long, if it is.
    pub(super) fn long_axis(&self) -> Option<usize> {
        let sides = self.sides;
        (0..3).find(|&axis| (0..3).all(|other| other == axis || sides[axis] > LONG * sides[other]))
    }

    /// True if a face is flat and large enough to be held.
    pub(super) fn has_flat_face(&self) -> bool {
        self.flat_end().or_else(|| self.flat_face()).is_some()
    }

    /// The flat face that ends a long body.
    fn flat_end(&self) -> Option<Face> {
        let axis = self.long_axis()?;
        self.largest_flat(|(area, normal, _)| normal[axis].abs() > 0.99 && *area >= 1e-3 * self.area)
    }

    /// The largest flat face, if it is a fiftieth of the surface or more.
    fn flat_face(&self) -> Option<Face> {
        self.largest_flat(|(area, ..)| *area >= 0.02 * self.area)
    }

    /// The largest flat face of those that fit.
    fn largest_flat(&self, fits: impl Fn(&Face) -> bool) -> Option<Face> {
        let diagonal = self.diagonal();
        let mut faces: BTreeMap<[i64; 4], Face> = BTreeMap::new();
        for Triangle { area, normal, corners: [a, ..] } in &self.triangles {
            let offset: f64 = (0..3).map(|i| normal[i] * (a[i] - self.low[i])).sum();
            let [x, y, z] = normal.map(|x| (1e3 * x).round() as i64);
            let key = [x, y, z, (1e4 * offset / diagonal).round() as i64];
            faces.entry(key).or_insert((0.0, *normal, *a)).0 += area;
        }
        // Of faces of one size the one that looks down, or to the low end, is held.
        let down = |normal: &[f64; 3]| normal.iter().zip([1.0, 1.1, 1.2]).map(|(n, w)| n * w).sum::<f64>();
        faces.into_values().filter(fits).max_by(|a, b| {
            let apart = a.0 - b.0;
            if apart.abs() > 1e-3 * a.0.max(b.0) {
                apart.total_cmp(&0.0)
            } else {
                down(&b.1).total_cmp(&down(&a.1))
            }
        })
    }

    fn diagonal(&self) -> f64 {
        self.sides.iter().map(|side| side * side).sum::<f64>().sqrt()
    }

    /// The axis that points up: the one whose lower end is a foot, which is flat: most of what faces down in
    /// the lowest tenth lies at the very bottom. Characters mostly have y up: another axis has to be clearly
    /// flatter.
    pub(super) fn up(&self) -> usize {
        let facing_down = |axis: usize, share: f64| -> f64 {
            let top = self.low[axis] + share * self.sides[axis];
            let height = |t: &Triangle| t.corners.iter().map(|p| p[axis]).sum::<f64>() / 3.0;
            let below = self.triangles.iter().filter(|t| height(t) <= top);
            below.map(|t| t.area * (-t.normal[axis]).max(0.0)).sum()
        };
        let flatness = |axis: usize| {
            let all = facing_down(axis, 0.1);
            if all > 0.0 { facing_down(axis, 0.03) / all } else { 0.0 }
        };
        let clearly = |axis: usize| flatness(axis) - if axis == 1 { 0.0 } else { CLEARLY_FLATTER };
        [1, 2, 0].into_iter().fold(1, |best, axis| if clearly(axis) > clearly(best) { axis } else { best })
    }

    /// Share of the surface on the facets of a group.
    fn share(&self, group: &str) -> f64 {
        let facets = self.mesh.facet_groups.get(group).map_or(&[][..], Vec::as_slice);
        self.surface.area_of(self.mesh, facets) / self.area
    }
}

/// Flatness that a foot along another axis must have in addition to that along y.
const CLEARLY_FLATTER: f64 = 0.25;

/// True of the name of a support.
fn names_a_support(name: &str) -> bool {
    let name = name.to_lowercase();
    let words = || name.split(|c: char| !c.is_alphabetic());
    SUPPORTS.iter().any(|part| name.contains(part)) || words().any(|word| SUPPORT_WORDS.contains(&word))
}

/// True of a name that Gmsh, or this reader for a tag without a name, has given.
fn is_a_number(name: &str) -> bool {
    ["surface ", "curve ", "point ", "region "]
        .iter()
        .any(|kind| name.strip_prefix(kind).is_some_and(|tag| tag.parse::<i64>().is_ok()))
}

/// Proposes supports: what was asked for, or groups that are called supports, or the named groups of facets,
/// or a flat face (the end of a long body, the largest of another), or the foot of the body.
pub(super) fn propose(
    shape: &Shape<'_>,
    scale: f64,
    hold: Option<&str>,
    up: usize,
) -> Result<Supports, HoldError> {
    if let Some(hold) = hold {
        return asked(shape, scale, hold, up);
    }
    let mesh = shape.mesh;
    let partial = |name: &&String| match mesh.facet_groups.contains_key(*name) {
        true => shape.share(name) < LARGEST_GROUP,
        false => {
            let nodes = mesh.node_groups[*name].len();
            nodes >= 3 && 2 * nodes < mesh.nodes.len()
        }
    };
    let called: Vec<&String> =
        mesh.node_groups.keys().filter(|name| names_a_support(name)).filter(partial).collect();
    let is_load = |name: &str| LOADS.iter().any(|part| name.to_lowercase().contains(part));
    let named = mesh.facet_groups.keys().filter(|name| !is_a_number(name) && !is_load(name));
    let named: Vec<&String> = named.filter(partial).collect();
    // The sides of a box are no supports, all of them together.
    let together = named.iter().map(|name| shape.share(name)).sum::<f64>() < LARGEST_GROUP;
    let groups = if !called.is_empty() {
        called
    } else if together {
        named
    } else {
        vec![]
    };
    let mut supports = match groups.is_empty() {
        false => of_groups(&groups),
        true => match shape.flat_end() {
            Some(face) => of_face(shape, face, scale, true),
            None => match shape.flat_face() {
                Some(face) => of_face(shape, face, scale, false),
                None => of_foot(up),
            },
        },
    };
    let others = mesh.facet_groups.keys().filter(|name| !groups.contains(name));
    supports.others = others.cloned().collect();
    Ok(supports)
}

/// Supports that `--hold` asks for.
fn asked(shape: &Shape<'_>, scale: f64, hold: &str, up: usize) -> Result<Supports, HoldError> {
    if let Some((name, _)) = shape.mesh.node_groups.get_key_value(hold) {
        return Ok(of_groups(&[name]));
    }
    if hold == "none" {
        let words = "nothing: a free body".to_string();
        return Ok(Supports { on: vec![], words, others: vec![] });
    }
    let end = match hold {
        "bottom" => Some((up, true)),
        _ => hold.split_once('_').and_then(|(axis, side)| {
            let axis = AXES.iter().position(|name| *name == axis)?;
            ["min", "max"].contains(&side).then_some((axis, side == "min"))
        }),
    };
    let Some((axis, low)) = end else {
        let groups = shape.mesh.node_groups.keys();
        let nearest = did_you_mean(hold, groups.clone().map(String::as_str));
        let known = groups.map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        let known = if known.is_empty() { "none".into() } else { known };
        return Err(HoldError { hold: hold.into(), known: known + &nearest });
    };
    // A flat face there is held as it is.
    let looks_out = |(area, normal, point): &Face| {
        let side = if low { -1.0 } else { 1.0 };
        let end = shape.low[axis] + if low { 0.0 } else { shape.sides[axis] };
        let at_end = (point[axis] - end).abs() < 1e-3 * shape.sides[axis];
        side * normal[axis] > 0.99 && at_end && *area >= 1e-3 * shape.area
    };
    if let Some(face) = shape.largest_flat(looks_out) {
        return Ok(of_face(shape, face, scale, true));
    }
    Ok(of_end(axis, low, &format!("the {} tenth along {}", if low { "first" } else { "last" }, AXES[axis])))
}

fn of_groups(groups: &[&String]) -> Supports {
    let on = groups.iter().map(|name| format!("{{ group = {} }}", quoted(name))).collect();
    let names: Vec<String> = groups.iter().map(|name| format!("`{}`", one_line(name))).collect();
    let kind = if groups.len() == 1 { "the group" } else { "the groups" };
    Supports { on, words: format!("{kind} {}", names.join(", ")), others: vec![] }
}

fn of_foot(up: usize) -> Supports {
    let axis = AXES[up];
    of_end(up, true, &format!("the lowest tenth with {axis} up, because no large face is flat"))
}

fn of_end(axis: usize, low: bool, words: &str) -> Supports {
    let (axis, side) = (AXES[axis], if low { "min" } else { "max" });
    let on = format!("{{ fraction = {{ axis = \"{axis}\", side = \"{side}\", fraction = {FOOT:?} }} }}");
    Supports { on: vec![on], words: words.into(), others: vec![] }
}

fn of_face(shape: &Shape<'_>, (area, normal, point): Face, scale: f64, end: bool) -> Supports {
    let axis = normal.iter().position(|x| x.abs() > 1.0 - 1e-9);
    // A problem file counts lengths as they are once the mesh is scaled.
    let point = point.map(|x| scale * x);
    let tolerance = 1e-4 * shape.diagonal() * scale;
    let on = match axis {
        Some(axis) => {
            let (name, at) = (AXES[axis], point[axis]);
            format!("{{ plane = {{ axis = \"{name}\", at = {at:?}, tolerance = {tolerance:?} }} }}")
        }
        None => {
            format!("{{ plane = {{ normal = {normal:?}, point = {point:?}, tolerance = {tolerance:?} }} }}")
        }
    };
    let share = 100.0 * area / shape.area;
    let words = match (axis, end) {
        (Some(axis), true) => format!("the flat end along {} ({share:.0} % of the surface)", AXES[axis]),
        (Some(axis), false) => {
            format!("the largest flat face, across {} ({share:.0} % of the surface)", AXES[axis])
        }
        _ => format!("the largest flat face ({share:.0} % of the surface)"),
    };
    Supports { on: vec![on], words, others: vec![] }
}

#[cfg(test)]
mod tests {
    use super::names_a_support;

    #[test]
    fn a_support_is_known_by_whole_words() {
        for name in ["stem end", "Fixed_Face", "bolts", "NFIX", "base", "clamped-left", "END_1"] {
            assert!(names_a_support(name), "{name}");
        }
        for name in ["bend", "tendon", "shield", "background", "baseline", "render", "tip"] {
            assert!(!names_a_support(name), "{name}");
        }
    }
}
