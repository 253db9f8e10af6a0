//! Surfaces that are filled with tetrahedra: STL, OBJ, PLY, OFF and glTF files.
//!
//! Such surfaces are seldom clean. Inside is where the generalised [winding number](winding), which
//! needs neither closed nor simple surfaces; the tetrahedra are those of a [lattice] that the surface cuts;
//! then nodes move onto its sharp [edges].

mod edges;
mod embedded;
mod glb;
mod lattice;
mod ply;
mod shell;
mod triangles;
mod winding;

use std::collections::{HashMap, HashSet};
use std::path::Path;

use self::edges::{Edges, sharpen};
pub(crate) use self::embedded::Embedded;
use self::lattice::{Lattice, fill};
pub use self::shell::{SurfaceMesh, read_surface};
use self::triangles::Triangles;
use self::winding::{Point, Winding};
use super::error::MeshError;
use super::raw::{CellKind, RawMesh};
use super::{ElementKind, Location, bounding_box};
use crate::linalg::vec3::{cross, norm, sub};

/// Cubes in the volume of a body where nobody asks for a number of cells. Quadratic tetrahedra then have some
/// 70 000 dofs.
const CUBES: f64 = 1200.0;
/// Cells along the longest side that are chosen for a body.
const CHOSEN: (f64, f64) = (8.0, 120.0);
/// Cells along the longest side of the first look at a surface.
const FIRST: f64 = 24.0;
/// Cells along the longest side that may be asked for.
pub const CELLS: std::ops::RangeInclusive<u32> = 4..=400;
/// Lattice points that fit into the memory of a workstation.
const MAX_POINTS: usize = 20_000_000;
/// Distance below which corners are one, in longest sides: a hundred roundings of single precision.
const WELDED: f64 = 1e-5;
/// Most tetrahedra: six for each lattice point inside.
const MAX_TETRAHEDRA: usize = 20_000_000;
/// Share of the surface that may be thinner than a cell without a note.
const THIN: f64 = 0.02;

/// A format of surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    StlBinary,
    StlText,
    Obj,
    Ply,
    Off,
    Glb,
}

/// Reads a surface and fills it, with `cells` along its longest side.
pub(super) fn parse(
    file: &Path,
    bytes: &[u8],
    format: Format,
    cells: Option<u32>,
) -> Result<RawMesh, MeshError> {
    filled(file, read(file, bytes, format)?, cells)
}

/// Reads a surface.
fn read(file: &Path, bytes: &[u8], format: Format) -> Result<Triangles, MeshError> {
    match format {
        Format::StlBinary => triangles::stl_binary(file, bytes),
        Format::StlText => triangles::stl_text(file, bytes),
        Format::Obj => triangles::obj(file, bytes),
        Format::Ply => ply::parse(file, bytes),
        Format::Off => triangles::off(file, bytes),
        Format::Glb => glb::parse(file, bytes),
    }
}

fn filled(file: &Path, surface: Triangles, cells: Option<u32>) -> Result<RawMesh, MeshError> {
    let mut raw = RawMesh::new(file, &format!("{} surface, filled with tetrahedra", surface.format));
    let empty = |reason: String| MeshError::Unfilled { file: file.to_path_buf(), reason };
    let mut corners = surface.corners;
    let numbers = cleaned(&mut corners, &mut raw.notes);
    let sharp = Edges::of(&corners, &numbers);
    let (low, high) = bounding_box(corners.as_flattened());
    let sides: [f64; 3] = std::array::from_fn(|k| high[k] - low[k]);
    let longest = sides.into_iter().fold(0.0, f64::max);
    if sides.iter().any(|side| *side <= 1e-9 * longest) {
        return Err(empty(format!("its {} triangles of an area span no volume", corners.len())));
    }
    let mut winding = Winding::new(corners);
    // A first look: how large is the body, and is the surface turned inside out?
    let first = Lattice::around(low, high, FIRST);
    let numbers = first.numbers(&winding);
    let [inside, outside_in] =
        [1.0, -1.0].map(|sign| numbers.iter().filter(|number| sign * **number > 0.5).count());
    if outside_in > inside {
        winding.turn_inside_out();
        raw.notes.push("the triangles are inside out: taken the other way round".into());
    }
    if inside.max(outside_in) == 0 && cells.is_none() {
        let thin = format!("no point of {} cells along its longest side lies inside", FIRST);
        return Err(empty(format!(
            "{thin}: it is open, or thinner than that; more `cells` may find its inside"
        )));
    }
    let volume = 0.5 * inside.max(outside_in) as f64 * first.side.powi(3);
    let chosen = (longest / (volume / CUBES).cbrt()).ceil().clamp(CHOSEN.0, CHOSEN.1);
    let cells = cells.map_or(chosen, f64::from);
    let lattice = Lattice::around(low, high, cells);
    if lattice.count() > MAX_POINTS {
        return Err(empty(format!(
            "{cells} cells along its longest side are more than memory holds: use fewer"
        )));
    }
    let inside: Vec<bool> = lattice.numbers(&winding).iter().map(|number| *number > 0.5).collect();
    if 6 * inside.iter().filter(|inside| **inside).count() > MAX_TETRAHEDRA {
        let most = MAX_TETRAHEDRA / 1_000_000;
        return Err(empty(format!(
            "{cells} cells along its longest side give more than {most} million tetrahedra: use fewer"
        )));
    }
    let mut found = fill(&lattice, &winding, &inside);
    if found.tetrahedra.is_empty() {
        return Err(empty(format!(
            "no point of {cells} cells along its longest side lies inside: use more `cells`"
        )));
    }
    sharpen(&mut found, &sharp, lattice.side);
    raw.cells = Some(cells as u32);
    raw.notes.push(format!("filled with {cells} cells along the longest side"));
    raw.notes.extend(thin(&winding, &lattice, cells));
    raw.node_ids = (1..=found.nodes.len() as u64).collect();
    raw.nodes = found.nodes;
    for tetrahedron in &found.tetrahedra {
        raw.push(CellKind::Solid(ElementKind::Tet4), tetrahedron, &[1], Location::Line(1));
    }
    raw.region_names.insert(1, "body".into());
    Ok(raw)
}

/// Drops triangles without area and copies of others, with notes; the numbers of the corners of the rest.
fn cleaned(corners: &mut Vec<[Point; 3]>, notes: &mut Vec<String>) -> Vec<[u32; 3]> {
    let count = corners.len();
    let area = |t: &[Point; 3]| norm(cross(sub(t[1], t[0]), sub(t[2], t[0])));
    corners.retain(|t| area(t) > 0.0);
    let flat = count - corners.len();
    // The number of each corner, by its place: corners that only rounding tells apart are one.
    let (low, high) = bounding_box(corners.as_flattened());
    let grain = WELDED * (0..3).map(|k| high[k] - low[k]).fold(f64::MIN_POSITIVE, f64::max);
    let mut numbers: HashMap<[i64; 3], u32> = HashMap::new();
    let mut number = |point: &Point| {
        let next = numbers.len() as u32;
        let place = std::array::from_fn(|k| ((point[k] - low[k]) / grain).round() as i64);
        *numbers.entry(place).or_insert(next)
    };
    let mut triangles: Vec<[u32; 3]> =
        corners.iter().map(|t| [number(&t[0]), number(&t[1]), number(&t[2])]).collect();
    let mut seen = HashSet::new();
    let mut kept = vec![true; triangles.len()];
    for (keep, t) in kept.iter_mut().zip(&triangles) {
        // From the smallest number on: the orientation stays.
        let first = (0..3).min_by_key(|&k| t[k]).unwrap_or(0);
        *keep = seen.insert([t[first], t[(first + 1) % 3], t[(first + 2) % 3]]);
    }
    let copies = kept.iter().filter(|keep| !**keep).count();
    let mut keep = kept.iter();
    corners.retain(|_| keep.next() == Some(&true));
    let mut keep = kept.iter();
    triangles.retain(|_| keep.next() == Some(&true));
    let mut balance: HashMap<(u32, u32), i32> = HashMap::new();
    for t in &triangles {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])].into_iter().filter(|(a, b)| a != b) {
            *balance.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
        }
    }
    let open = balance.values().filter(|sum| **sum != 0).count();
    let count = |n: usize, what: &str| if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") };
    if flat > 0 {
        notes.push(format!("{} without area left out", count(flat, "triangle")));
    }
    if copies > 0 {
        notes.push(format!("{} that repeat others left out", count(copies, "triangle")));
    }
    if open > 0 {
        notes.push(format!(
            "the surface is open at {}: closed there as smoothly as it can be",
            count(open, "edge")
        ));
    }
    triangles
}

/// A note on the share of the surface that has less than a cell of material below it, unless it is small.
fn thin(winding: &Winding, lattice: &Lattice, cells: f64) -> Option<String> {
    let share = winding.share_of_area(|point, normal| {
        winding.number(std::array::from_fn(|k| point[k] - lattice.side * normal[k])) <= 0.5
    });
    let more = (2.0 * cells).min((*CELLS.end()).into());
    (share > THIN).then(|| {
        format!(
            "{:.0} % of the surface has less than a cell ({:.3e}) of material below it and may be lost; \
             `cells = {more}` in `[mesh]` shows more",
            100.0 * share,
            lattice.side
        )
    })
}
