//! Bodies of `docs/measurements/large-displacements.md`, the mesh of one of them, and a body that is small.

use std::fmt::Write as _;
use std::path::Path;

use vademecum_build::dynamics::FirstMode;
use vademecum_build::input::Problem;
use vademecum_build::prepared::prepare;
use vademecum_build::progress::{Silent, Stopwatch};

use crate::total_error::real_bodies;

/// The problem of a small soft beam that bends far.
pub const BENT: &str = r#"
model = "large-displacement"
[mesh]
block = { lengths = [1.0, 0.1, 0.1], divisions = [4, 1, 1], order = "linear" }
[[material]]
young = 1e6
poisson = 0.3
density = 1000.0
[[support]]
on = { group = "x_min" }
[basis]
modes = 6
[[parameter]]
name = "stiffness"
kind = "stiffness"
region = "*"
range = [0.5, 2.0]
[large]
states = 12
"#;

/// A body whose step is a fortieth of its first period.
#[derive(Clone, Debug)]
pub struct BendingBody {
    /// As `--body` names it.
    pub name: &'static str,
    /// What it is, in a few words.
    pub what: &'static str,
    /// Whether one of its lengths is several times the others.
    pub slender: bool,
    /// Largest displacement that is asked for \[m\].
    pub displacement: f64,
    /// Tables of the problem file: mesh, material, support, load.
    pub text: String,
}

/// Gives a problem a fortieth of its first period as its step: the problem, that period \[s\], and the dofs.
/// `parse` makes the problem of what is appended to its text.
///
/// # Panics
/// If it is no problem, or has no first mode.
pub fn in_forty_steps(parse: impl Fn(&str) -> Problem) -> (Problem, f64, usize) {
    let prepared = prepare(&parse(""), &mut Stopwatch::new(&Silent), &Silent);
    let prepared = prepared.unwrap_or_else(|error| panic!("{error}"));
    let pencil = prepared.body.model.pencil();
    let period = FirstMode::find(pencil, &prepared.symbolic).expect("a first mode").period();
    (parse(&format!("[time]\nstep = {:e}\n", period / 40.0)), period, pencil.n_dof())
}

/// Those of the bodies whose meshes are there. The mesh of the diamond is written to `folder`.
///
/// # Panics
/// If the folder cannot be written to.
#[must_use]
pub fn bending_bodies(folder: &Path) -> Vec<BendingBody> {
    let soft = "[[material]]\nyoung = 1e6\npoisson = 0.3\ndensity = 1000.0\n";
    let beam = |name, what, lengths: &str, divisions: &str, slender, displacement| BendingBody {
        name,
        what,
        slender,
        displacement,
        text: format!(
            "[mesh]\nblock = {{ lengths = {lengths}, divisions = {divisions}, order = \"quadratic\" }}\n{soft}\
             [[support]]\non = {{ group = \"x_min\" }}\n[load]\n"
        ),
    };
    let mesh = folder.join("diamond.msh");
    std::fs::write(&mesh, diamond()).expect("a folder to write to");
    let diamond = BendingBody {
        name: "diamond",
        what: "four bent legs of silicone that meet at the top, 18 cm wide, clamped at their feet",
        slender: false,
        displacement: 0.04,
        text: format!(
            "[mesh]\nfile = {mesh:?}\n[[material]]\nyoung = 2e5\npoisson = 0.3\ndensity = 1100.0\n\
             [[support]]\non = {{ fraction = {{ axis = \"z\", side = \"min\", fraction = 0.03 }} }}\n[load]\n"
        ),
    };
    let real = |name: &str, displacement| {
        let body = real_bodies().into_iter().find(|body| body.name == name)?;
        let (name, what, text) = (body.name, body.what, body.text);
        Some(BendingBody { name, what, slender: false, displacement, text })
    };
    let mut bodies = vec![
        beam("slender", "a cantilever, 1 × 0.08 × 0.06 m", "[1.0, 0.08, 0.06]", "[16, 2, 1]", true, 0.6),
        beam("fine", "a finer cantilever, 1 × 0.1 × 0.08 m", "[1.0, 0.1, 0.08]", "[36, 3, 3]", true, 0.6),
        beam("block", "a block, 1 × 0.5 × 0.4 m", "[1.0, 0.5, 0.4]", "[6, 3, 3]", false, 0.25),
        diamond,
    ];
    bodies.extend(real("liver", 0.03));
    bodies.extend(real("raptor", 1.0));
    bodies
}

/// Cells across a leg, through it, and along it.
const CELLS: [usize; 3] = [4, 2, 24];
/// Edge of a cell \[m\].
const EDGE: f64 = 0.005;

/// The mesh of a diamond in the format of Gmsh: a plate like a plus sign, each arm of which is bent down and
/// in again. Every cell is cut into six tetrahedra around the same diagonal, so that neighbours agree.
#[must_use]
pub fn diamond() -> String {
    let [across, through, along] = CELLS;
    let reach = along + across + along;
    let inside = |i: usize| (along..along + across).contains(&i);
    let cells = (0..reach)
        .flat_map(|i| (0..reach).map(move |j| (i, j)))
        .filter(|&(i, j)| inside(i) || inside(j))
        .flat_map(|(i, j)| (0..through).map(move |k| [i, j, k]));
    let mut number = std::collections::BTreeMap::new();
    let mut elements = vec![];
    for cell in cells {
        let mut corner = |bits: [usize; 3]| {
            let next = number.len() + 1;
            let at: [usize; 3] = std::array::from_fn(|c| cell[c] + bits[c]);
            *number.entry(at).or_insert(next)
        };
        for [a, b] in [[0, 1], [1, 2], [2, 0], [1, 0], [2, 1], [0, 2]] {
            let mut bits = [0; 3];
            let first = corner(bits);
            bits[a] = 1;
            let second = corner(bits);
            bits[b] = 1;
            elements.push([first, second, corner(bits), corner([1, 1, 1])]);
        }
    }
    let mut places: Vec<_> = number.into_iter().map(|(at, number)| (number, bent(at))).collect();
    places.sort_by_key(|place| place.0);
    let mut text = format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n", places.len());
    for (number, [x, y, z]) in places {
        writeln!(text, "{number} {x:e} {y:e} {z:e}").expect("a string");
    }
    write!(text, "$EndNodes\n$Elements\n{}\n", elements.len()).expect("a string");
    for (e, [a, b, c, d]) in elements.iter().enumerate() {
        writeln!(text, "{} 4 2 1 1 {a} {b} {c} {d}", e + 1).expect("a string");
    }
    text + "$EndElements\n"
}

/// Where a node of the flat plate goes.
fn bent(at: [usize; 3]) -> [f64; 3] {
    let [across, through, along] = CELLS;
    let half = 0.5 * across as f64 * EDGE;
    let place = |i: usize| (i as f64 - along as f64 - 0.5 * across as f64) * EDGE;
    let (x, y, below) = (place(at[0]), place(at[1]), (at[2] as f64 - through as f64) * EDGE);
    let (arm, beside) = if x.abs() > y.abs() { (x, y) } else { (y, x) };
    let beyond = (arm.abs() - half).max(0.0);
    // The slope of a leg: down at the top, in again from its middle on, with rounded corners.
    let length = along as f64 * EDGE;
    let round = |s: f64, from: f64, to: f64| ((s - from) / (to - from)).clamp(0.0, 1.0);
    let quarter = 0.25 * std::f64::consts::PI;
    let slope = |s: f64| {
        quarter * round(s, 0.0, 0.25 * length) + 2.0 * quarter * round(s, 0.375 * length, 0.625 * length)
    };
    const PARTS: usize = 64;
    let ds = beyond / PARTS as f64;
    let (mut out, mut down) = (0.0, 0.0);
    for part in 0..PARTS {
        let slope = slope((part as f64 + 0.5) * ds);
        out += ds * slope.cos();
        down += ds * slope.sin();
    }
    let slope = slope(beyond);
    let reach = (arm.abs().min(half) + out + below * slope.sin()).copysign(arm);
    let height = below * slope.cos() - down;
    if x.abs() > y.abs() { [reach, beside, height] } else { [beside, reach, height] }
}
