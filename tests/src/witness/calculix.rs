//! CalculiX: a deck of a problem, and what it prints.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use vademecum_build::input::{PatternEntry, Problem};
use vademecum_build::mesh::Mesh;
use vademecum_build::mesh::select::Selection;
use vademecum_build::mesh::surface::Surface;

use super::bodies::Witness;
use super::thermal::lines;

/// Faces of a tetrahedron by its corners, in CalculiX's order.
const FACES: [[usize; 3]; 4] = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];

/// What CalculiX answers.
#[derive(Clone, Debug, Default)]
pub struct Answer {
    /// Natural frequencies \[Hz\].
    pub frequencies: Vec<f64>,
    /// Displacement of every node under the load pattern, by the mesh's order; empty without one.
    pub displacement: Vec<[f64; 3]>,
    /// Stress at every node under it: xx, yy, zz, xy, yz, zx \[Pa\].
    pub stress: Vec<[f64; 6]>,
}

/// Whether CalculiX is installed. Where it is not, a test that asks is skipped with a message, except in CI,
/// where that is a failure.
///
/// # Panics
/// If it is not there and the variable `CI` is set.
#[must_use]
pub fn is_there() -> bool {
    // It prints its version and ends with an exit code of its own.
    if Command::new("ccx").arg("-v").output().is_ok() {
        return true;
    }
    assert!(std::env::var_os("CI").is_none(), "ccx is missing; .ci/install installs it");
    eprintln!("skipped: there is no CalculiX (ccx); .ci/install installs it");
    false
}

/// Runs CalculiX on `NAME.inp` of a folder, the mesh of a problem: its lowest modes, and its static answer to
/// the first load pattern if there is one.
///
/// # Panics
/// If CalculiX fails, or the problem has what this deck does not say: several materials, supports that are
/// no groups.
#[must_use]
pub fn run(folder: &Path, witness: &Witness, problem: &Problem, mesh: &Mesh) -> Answer {
    let (name, count) = (witness.name, witness.count);
    let loaded = witness.thermal.is_some() || !problem.load.patterns.is_empty();
    let job = format!("{name}-calculix");
    let text = deck(witness, problem, mesh);
    std::fs::write(folder.join(format!("{job}.inp")), text).expect("the deck is written");
    let found = self::answer(folder, &job);
    let mut answer =
        Answer { displacement: found.of_mesh(mesh), frequencies: found.frequencies, ..Answer::default() };
    if loaded {
        let fields = std::fs::read_to_string(folder.join(format!("{job}.frd"))).unwrap_or_default();
        answer.stress = stress(&fields, mesh);
    }
    let whole = answer.displacement.len() == if loaded { mesh.nodes.len() } else { 0 };
    assert!(
        answer.frequencies.len() >= count && whole,
        "{name}: CalculiX gave {} frequencies and {} displacements\n{}",
        answer.frequencies.len(),
        answer.displacement.len(),
        found.said
    );
    answer
}

fn deck(witness: &Witness, problem: &Problem, mesh: &Mesh) -> String {
    let (name, count) = (witness.name, witness.count);
    let [material] = &problem.materials[..] else { panic!("{name}: expected one material") };
    let mut out = format!("*INCLUDE, INPUT={name}.inp\n*MATERIAL, NAME=material\n");
    let (Some(young), Some(poisson)) = (material.young, material.poisson) else {
        panic!("{name}: expected an isotropic material");
    };
    let _ = writeln!(out, "*ELASTIC\n{young:e}, {poisson:e}");
    let _ = writeln!(out, "*DENSITY\n{:e}", material.density);
    if let Some(thermal) = &witness.thermal {
        let _ = writeln!(out, "*EXPANSION, ZERO=0\n{:e}", thermal.expansion);
        out.push_str("*INITIAL CONDITIONS, TYPE=TEMPERATURE\nall, 0\n");
    }
    out.push_str("*SOLID SECTION, ELSET=body, MATERIAL=material\n*BOUNDARY\n");
    for support in &problem.supports {
        let group = group(&support.on);
        for component in &support.components {
            let number = *component as usize + 1;
            let _ = writeln!(out, "{group}, {number}, {number}");
        }
    }
    let _ = writeln!(out, "*STEP\n*FREQUENCY\n{count}\n*END STEP");
    if let Some(thermal) = &witness.thermal {
        out.push_str("*STEP\n*STATIC\n*TEMPERATURE\n");
        out.push_str(&lines(thermal, mesh));
    } else if let Some(pattern) = problem.load.patterns.first() {
        out.push_str("*STEP\n*STATIC\n*DLOAD\n");
        load(&mut out, pattern, mesh);
    }
    if witness.thermal.is_some() || !problem.load.patterns.is_empty() {
        out.push_str("*NODE PRINT, NSET=all\nU\n*EL FILE\nS\n*END STEP\n");
    }
    out
}

fn group(selection: &Selection) -> &str {
    match selection {
        Selection::Group(name) => name,
        other => panic!("expected a group, found {other:?}"),
    }
}

fn load(out: &mut String, pattern: &PatternEntry, mesh: &Mesh) {
    match (pattern.acceleration, pattern.pressure, &pattern.on) {
        (Some([x, y, z]), None, None) => {
            let size = (x * x + y * y + z * z).sqrt();
            let _ = writeln!(out, "body, GRAV, {size:e}, {:e}, {:e}, {:e}", x / size, y / size, z / size);
        }
        (None, Some(pressure), Some(on)) => {
            let surface = Surface::of(mesh);
            let within = surface.facets_within(&mesh.node_groups[group(on)]);
            let mut corners: Vec<[u32; 3]> = within
                .iter()
                .map(|facet| {
                    let facet = surface.facet(*facet as usize);
                    sorted([facet[0], facet[1], facet[2]])
                })
                .collect();
            corners.sort_unstable();
            for index in 0..mesh.element_count() {
                let element = mesh.element(index);
                for (face, nodes) in FACES.iter().enumerate() {
                    if corners.binary_search(&sorted(nodes.map(|k| element[k]))).is_ok() {
                        let _ = writeln!(out, "{}, P{}, {pressure:e}", index + 1, face + 1);
                    }
                }
            }
        }
        _ => panic!("expected gravity or a pressure, found {pattern:?}"),
    }
}

fn sorted(mut corners: [u32; 3]) -> [u32; 3] {
    corners.sort_unstable();
    corners
}

/// Reads the last stresses of a `.frd` file: lines of a node and six numbers in columns of twelve.
fn stress(fields: &str, mesh: &Mesh) -> Vec<[f64; 6]> {
    let mut stress = vec![];
    let mut inside = false;
    for line in fields.lines() {
        if line.starts_with(" -4") {
            inside = line.contains("STRESS");
            if inside {
                stress.clear();
            }
        } else if inside && line.starts_with(" -1") {
            let node = mesh.node_ids[stress.len()].to_string();
            assert_eq!(line[3..13].trim(), node, "CalculiX writes the nodes in another order");
            stress.push(std::array::from_fn(|c| {
                line[13 + 12 * c..25 + 12 * c].trim().parse().expect("a number")
            }));
        }
    }
    assert_eq!(stress.len(), mesh.nodes.len(), "stresses of CalculiX");
    stress
}

/// Tables of a `.dat` file.
#[derive(Clone, Debug, Default)]
pub struct Tables {
    /// Natural frequencies \[Hz\].
    pub frequencies: Vec<f64>,
    /// Displacements, by the numbers of their nodes, in order.
    pub displacements: Vec<(u64, [f64; 3])>,
    /// What CalculiX said while it ran.
    pub said: String,
}

/// Runs CalculiX on `JOB.inp` of a folder.
///
/// # Panics
/// If it does not start.
#[must_use]
pub fn answer(folder: &Path, job: &str) -> Tables {
    let ran = Command::new("ccx").arg("-i").arg(job).current_dir(folder).env("OMP_NUM_THREADS", "2").output();
    let said = String::from_utf8_lossy(&ran.expect("ccx starts").stdout).into_owned();
    let printed = std::fs::read_to_string(folder.join(format!("{job}.dat"))).unwrap_or_default();
    let mut found = Tables { said, ..Tables::default() };
    let mut table = "";
    for line in printed.lines() {
        let columns: Vec<f64> = line.split_whitespace().map_while(|word| word.parse().ok()).collect();
        match (table, &columns[..]) {
            (_, []) if line.contains("E I G E N V A L U E") => table = "frequencies",
            (_, []) if line.contains("P A R T I C I P A T I O N") => table = "",
            (_, []) if line.contains("displacements") => table = "displacements",
            // Number, eigenvalue, rad/s, Hz, imaginary part.
            ("frequencies", &[_, _, _, hz, _]) => found.frequencies.push(hz),
            ("displacements", &[node, x, y, z]) => found.displacements.push((node as u64, [x, y, z])),
            _ => {}
        }
    }
    found
}

impl Tables {
    /// The displacements of a mesh whose nodes are all printed.
    pub(super) fn of_mesh(&self, mesh: &Mesh) -> Vec<[f64; 3]> {
        let in_order = self.displacements.iter().zip(&mesh.node_ids).all(|((node, _), id)| node == id);
        assert!(in_order, "CalculiX prints the nodes in another order");
        self.displacements.iter().map(|row| row.1).collect()
    }
}
