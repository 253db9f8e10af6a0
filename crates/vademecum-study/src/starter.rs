//! A problem file for a mesh that somebody has just found: everything that can be seen of the mesh is
//! proposed, said in a comment, and left to be changed.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use vademecum_build::dynamics::lowest_modes;
use vademecum_build::input::Problem;
use vademecum_build::mesh::{self, Mesh, MeshError, surface::Surface};
use vademecum_build::prepared::{STEPS_PER_PERIOD, prepare, proposed_time_step};
use vademecum_build::progress::{Listener, Stopwatch};
use vademecum_build::suggest::did_you_mean;

use crate::error::StudyError;

/// Modes proposed for a long body, and for a compact one, which rings in more of them; a small body has
/// fewer.
const MODES: [usize; 2] = [32, 64];

/// A body is long if its longest side is so many times the next.
const LONG: f64 = 2.5;

/// A body with a longest side above this is not in metres.
const LARGEST_IN_METRES: f64 = 20.0;

/// Error that is accepted of a compact body: a sudden push at one node of its surface rings in more modes
/// than a file should hold, and beside the support it moves little else.
const COMPACT_ERROR: f64 = 0.5;

/// Words that name a support in the groups of a mesh.
const SUPPORTS: [&str; 10] =
    ["fix", "clamp", "support", "encastre", "held", "base", "ground", "dirichlet", "anchor", "root"];

/// An isotropic material by its name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NamedMaterial {
    /// Name.
    pub name: &'static str,
    /// Young's modulus \[Pa\].
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Density \[kg/m³\].
    pub density: f64,
    /// Damping ratio that is usual for parts made of it.
    pub damping: f64,
    /// Source of the numbers.
    pub source: &'static str,
}

const fn material(
    name: &'static str,
    [young, poisson, density, damping]: [f64; 4],
    source: &'static str,
) -> NamedMaterial {
    NamedMaterial { name, young, poisson, density, damping, source }
}

const ASHBY: &str = "middle of the range in Ashby, Materials Selection in Mechanical Design";
const TISSUE: &str = "order of magnitude of Fung, Biomechanics; measure yours";

/// The materials that go by a name.
pub const MATERIALS: [NamedMaterial; 16] = [
    material("steel", [210e9, 0.30, 7850.0, 0.01], "EN 1993-1-1, 3.2.6"),
    material("stainless", [200e9, 0.30, 7900.0, 0.01], "EN 1993-1-4, 2.1.3"),
    material("aluminium", [70e9, 0.30, 2700.0, 0.01], "EN 1999-1-1, 3.2.5"),
    material("titanium", [115e9, 0.34, 4430.0, 0.01], ASHBY),
    material("brass", [100e9, 0.34, 8500.0, 0.005], ASHBY),
    material("concrete", [31e9, 0.20, 2500.0, 0.02], "EN 1992-1-1, class C25/30"),
    material("glass", [70e9, 0.23, 2500.0, 0.002], "EN 572-1"),
    material("wood", [11e9, 0.35, 420.0, 0.02], "EN 338, class C24 along the grain, taken as isotropic"),
    material("pla", [3.5e9, 0.36, 1240.0, 0.03], ASHBY),
    material("abs", [2.2e9, 0.37, 1050.0, 0.03], ASHBY),
    material("nylon", [2.7e9, 0.39, 1140.0, 0.03], ASHBY),
    material("rubber", [5e6, 0.48, 1100.0, 0.05], ASHBY),
    material("silicone", [1e6, 0.48, 1100.0, 0.05], ASHBY),
    material("foam", [1e5, 0.30, 50.0, 0.10], ASHBY),
    material("bone", [17e9, 0.30, 1900.0, 0.03], TISSUE),
    material("liver", [5e3, 0.45, 1050.0, 0.10], TISSUE),
];

impl NamedMaterial {
    /// A material by its name.
    ///
    /// # Errors
    /// The words of a refusal, with the names that there are.
    pub fn find(name: &str) -> Result<Self, String> {
        let known = || MATERIALS.map(|material| material.name).join(", ");
        let nearest = || did_you_mean(name, MATERIALS.iter().map(|material| material.name));
        let found = MATERIALS.into_iter().find(|material| material.name == name);
        found.ok_or_else(|| format!("unknown material `{name}`; known: {}{}", known(), nearest()))
    }
}

/// Options; everything else is proposed.
#[derive(Clone, Debug)]
pub struct StarterOptions {
    /// Material of the body.
    pub material: NamedMaterial,
    /// Metres in a unit of the mesh; guessed from the size of the body if `None`.
    pub scale: Option<f64>,
    /// The mesh file as the problem file shall name it.
    pub mesh_name: String,
}

/// A proposed problem.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Starter {
    /// The text of the problem file.
    pub text: String,
    /// Metres in a unit of the mesh.
    pub scale: f64,
    /// Longest side \[m\].
    pub longest_side: f64,
    /// Description of the support.
    pub support: String,
    /// First natural frequency \[Hz\].
    pub frequency: f64,
    /// Proposed step \[s\].
    pub time_step: f64,
    /// Proposed number of modes.
    pub modes: usize,
    /// Free dofs.
    pub dofs: usize,
}

/// Proposes a problem for a mesh. Reads and assembles it, and finds its first natural mode: one
/// factorisation.
///
/// # Errors
/// [`StarterError`]: a mesh that cannot be used, or that the proposed support does not hold.
pub fn starter(
    path: &Path,
    options: &StarterOptions,
    listener: &dyn Listener,
) -> Result<Starter, StarterError> {
    listener.stage("read mesh");
    let mesh = mesh::read(path)?;
    let (low, _) = mesh.bounding_box();
    let sides = sides_of(&mesh);
    let longest = sides.iter().copied().fold(0.0, f64::max);
    let guess = if longest > LARGEST_IN_METRES { 1e-3 } else { 1.0 };
    let scale = options.scale.unwrap_or(guess);
    let support = propose_support(&mesh, low, sides, scale);
    let draft = Draft { options, mesh: &mesh, scale, longest, support: &support };

    // Any step will do until the first period is known.
    let text = draft.text(1e-3, 1, &[]);
    let name = path.display().to_string();
    let mut problem = Problem::parse(&text, &name, PathBuf::new()).map_err(StarterError::Draft)?;
    problem.mesh.file = Some(path.to_path_buf());
    let prepared = prepare(&problem, &mut Stopwatch::new(listener), listener).map_err(StudyError::from)?;
    let pencil = prepared.body.model.pencil();
    let dofs = pencil.n_dof();
    let modes = MODES[usize::from(long_axis(sides).is_none())].min(dofs);
    listener.stage("first natural mode");
    let first = lowest_modes(pencil, &prepared.symbolic, 1).map_err(StudyError::from)?;
    let frequency = first.frequencies_hz()[0];
    let time_step = proposed_time_step(1.0 / frequency);

    // Where the first mode moves most, a probe looks.
    let shape = first.vectors.col_as_slice(0);
    let dof_of_free = prepared.body.model.dofs().dof_of_free();
    let mut moved = vec![[0.0; 3]; mesh.nodes.len()];
    for (&dof, &value) in dof_of_free.iter().zip(shape) {
        moved[dof as usize / 3][dof as usize % 3] = value;
    }
    let length = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let most = (0..moved.len()).max_by(|&a, &b| length(&moved[a]).total_cmp(&length(&moved[b])));
    let probe = most.filter(|&node| length(&moved[node]) > 0.0).map(|node| {
        let size = length(&moved[node]);
        // To a billionth of the body: what is left of a zero after rounding is not a coordinate.
        let grain = 1e-9 * longest;
        let point = mesh.nodes[node].map(|x| scale * ((x / grain).round() * grain));
        (point, moved[node].map(|x| (1000.0 * x / size).round() / 1000.0))
    });
    let text = draft.text(time_step, modes, &probe.into_iter().collect::<Vec<_>>());
    Ok(Starter {
        text,
        scale,
        longest_side: longest * scale,
        support: support.words,
        frequency,
        time_step,
        modes,
        dofs,
    })
}

/// Errors of a proposal.
#[derive(Debug, thiserror::Error)]
pub enum StarterError {
    /// The mesh cannot be used.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The proposal is no problem.
    #[error(transparent)]
    Draft(vademecum_build::input::ProblemError),
    /// The proposal cannot be computed with.
    #[error(transparent)]
    Study(#[from] StudyError),
}

/// Support.
struct Support {
    /// As the problem file writes it.
    toml: String,
    words: String,
}

struct Draft<'a> {
    options: &'a StarterOptions,
    mesh: &'a Mesh,
    scale: f64,
    longest: f64,
    support: &'a Support,
}

impl Draft<'_> {
    fn text(&self, time_step: f64, modes: usize, probes: &[([f64; 3], [f64; 3])]) -> String {
        let Self { options, mesh, scale, longest, support } = self;
        let m = &options.material;
        let name = quoted(&options.mesh_name);
        let title = Path::new(&options.mesh_name).file_stem().map_or("body".into(), |s| s.to_string_lossy());
        let unit = match *scale {
            1.0 => "the longest side is taken to be in metres".to_string(),
            scale => {
                format!("metres in a unit of the mesh: {longest:.4} units become {:.4} m", longest * scale)
            }
        };
        let mut text = format!(
            "# Proposed by `vademecum init`: everything here can be changed. Keys: `vademecum help problem`\n\
             title = {}\n\n[mesh]\nfile = {name}\nscale = {scale:?} # {unit}\n\n",
            quoted(&title)
        );
        let _ = write!(
            text,
            "# {}: {}\n[[material]]\nyoung = {:e} # Pa\npoisson = {:?}\ndensity = {:?} # kg/m³\n\n",
            m.name, m.source, m.young, m.poisson, m.density
        );
        let groups: Vec<&str> = mesh.node_groups.keys().map(String::as_str).take(12).collect();
        if !groups.is_empty() {
            let _ = writeln!(text, "# Groups of the mesh: {}", groups.join(", ").replace(['\n', '\r'], " "));
        }
        let _ = write!(
            text,
            "# Held: {}\n[[support]]\non = {}\n\n\
             # The whole surface can be loaded; `surface = {{ group = \"…\" }}` narrows it.\n[load]\n\n",
            support.words, support.toml
        );
        let _ = write!(
            text,
            "[damping]\nratio = {:?} # of each mode; usual for parts of {}\n\n\
             [time]\nstep = {time_step:?} # s; at least {} steps in the first period\n\n\
             [basis]\nkind = \"modes\"\nmodes = {modes}\n\n[output]\nprecision = \"f32\"\n",
            m.damping, m.name, STEPS_PER_PERIOD
        );
        if long_axis(sides_of(mesh)).is_none() {
            let _ = write!(
                text,
                "\n# A sudden push at one node of a compact body excites more modes than these. `vademecum info` says\n\
                 # what was reached; without this key more than 5e-2 is refused.\n\
                 [tolerance]\nerror = {COMPACT_ERROR:?}\n"
            );
        }
        for (point, direction) in probes {
            let _ = write!(
                text,
                "\n# Where the first mode moves most, along its motion.\n\
                 [[output.probe]]\nname = \"most\"\npoint = {point:?}\ndirection = {direction:?}\n"
            );
        }
        text
    }
}

/// A basic string of TOML.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            c if c.is_control() => {
                let _ = write!(out, "\\u{:04X}", u32::from(c));
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// A group that is called a support; or else a flat face: the end of a long body, the largest of another; or
/// else the outermost tenth.
fn propose_support(mesh: &Mesh, low: [f64; 3], sides: [f64; 3], scale: f64) -> Support {
    let usable = |nodes: &[u32]| nodes.len() >= 3 && 2 * nodes.len() < mesh.nodes.len();
    let called = mesh.node_groups.iter().find(|(name, nodes)| {
        let name = name.to_lowercase();
        usable(nodes) && SUPPORTS.iter().any(|word| name.contains(word))
    });
    if let Some((name, _)) = called {
        let toml = format!("{{ group = {} }}", quoted(name));
        return Support { toml, words: format!("the group `{}`", name.replace(['\n', '\r'], " ")) };
    }
    let at_an_end = long_axis(sides).and_then(|axis| flat_face(mesh, low, sides, scale, Some(axis)));
    if let Some(face) = at_an_end.or_else(|| flat_face(mesh, low, sides, scale, None)) {
        return face;
    }
    let longest = (0..3).max_by(|&a, &b| sides[a].total_cmp(&sides[b])).unwrap_or(0);
    let axis = ["x", "y", "z"][longest];
    Support {
        toml: format!("{{ fraction = {{ axis = \"{axis}\", side = \"min\", fraction = 0.1 }} }}"),
        words: format!("the first tenth along {axis}, because no large face is flat"),
    }
}

/// Sides of the bounding box, in units of the mesh.
fn sides_of(mesh: &Mesh) -> [f64; 3] {
    let (low, high) = mesh.bounding_box();
    std::array::from_fn(|c| high[c] - low[c])
}

/// The axis along which a body is long, if it is.
fn long_axis(sides: [f64; 3]) -> Option<usize> {
    (0..3).find(|&axis| (0..3).all(|other| other == axis || sides[axis] > LONG * sides[other]))
}

/// The largest flat face, if it is a fiftieth of the surface or more; of a body that is long along an axis,
/// one that ends it.
fn flat_face(
    mesh: &Mesh,
    low: [f64; 3],
    sides: [f64; 3],
    scale: f64,
    long: Option<usize>,
) -> Option<Support> {
    use std::collections::BTreeMap;
    let surface = Surface::of(mesh);
    let diagonal = sides.iter().map(|s| s * s).sum::<f64>().sqrt();
    let mut faces: BTreeMap<[i64; 4], (f64, [f64; 3], [f64; 3])> = BTreeMap::new();
    let mut whole = 0.0;
    for triangle in &surface.triangles {
        let [a, b, c] = triangle.map(|node| mesh.nodes[node as usize]);
        let [u, v]: [[f64; 3]; 2] = [b, c].map(|p| std::array::from_fn(|i| p[i] - a[i]));
        let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let twice = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        if twice <= 0.0 {
            continue;
        }
        let normal = normal.map(|x| x / twice);
        let offset: f64 = (0..3).map(|i| normal[i] * (a[i] - low[i])).sum();
        let [x, y, z] = normal.map(|x| (1e3 * x).round() as i64);
        let face =
            faces.entry([x, y, z, (1e4 * offset / diagonal).round() as i64]).or_insert((0.0, normal, a));
        face.0 += 0.5 * twice;
        whole += 0.5 * twice;
    }
    let ends = |normal: &[f64; 3]| long.is_none_or(|axis| normal[axis].abs() > 0.99);
    let fits = faces.values().filter(|(area, normal, _)| {
        ends(normal) && *area >= if long.is_some() { 1e-3 } else { 0.02 } * whole
    });
    // Of faces of one size the one that looks down, or to the low end, is held.
    let down = |normal: &[f64; 3]| normal.iter().zip([1.0, 1.1, 1.2]).map(|(n, w)| n * w).sum::<f64>();
    let (area, normal, point) = fits.max_by(|a, b| {
        let apart = a.0 - b.0;
        if apart.abs() > 1e-3 * a.0.max(b.0) {
            apart.total_cmp(&0.0)
        } else {
            down(&b.1).total_cmp(&down(&a.1))
        }
    })?;
    let axis = normal.iter().position(|x| x.abs() > 1.0 - 1e-9);
    // A problem file counts lengths as they are once the mesh is scaled.
    let point = point.map(|x| scale * x);
    let tolerance = 1e-4 * diagonal * scale;
    let toml = match axis {
        Some(axis) => {
            let name = ["x", "y", "z"][axis];
            format!(
                "{{ plane = {{ axis = \"{name}\", at = {:?}, tolerance = {tolerance:?} }} }}",
                point[axis]
            )
        }
        None => {
            format!("{{ plane = {{ normal = {normal:?}, point = {point:?}, tolerance = {tolerance:?} }} }}")
        }
    };
    let share = 100.0 * area / whole;
    let words = match (axis, long) {
        (Some(axis), Some(_)) => {
            format!("the flat end along {} ({share:.0} % of the surface)", ["x", "y", "z"][axis])
        }
        (Some(axis), None) => {
            format!("the largest flat face, across {} ({share:.0} % of the surface)", ["x", "y", "z"][axis])
        }
        _ => format!("the largest flat face ({share:.0} % of the surface)"),
    };
    Some(Support { toml, words })
}
