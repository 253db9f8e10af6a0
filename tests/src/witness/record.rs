//! What is found of a witness, and the tables of the record.

use std::fmt::Write as _;
use std::path::Path;

use faer::Mat;
use vademecum_build::fem::{Solve, StressRows, stress_points};
use vademecum_build::input::Problem;
use vademecum_build::mesh::Mesh;
use vademecum_build::prepared::{Prepared, prepare};
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_study::modes::natural_modes;

use super::bodies::{StressAt, Witness};
use super::calculix::{self, Answer};
use super::thermal::Thermal;
use super::{deck, mass};
use crate::program::repository;

/// What this program finds, and CalculiX if it is asked.
pub struct Found {
    /// Free dofs.
    pub dofs: usize,
    /// Natural frequencies \[Hz\].
    pub frequencies: Vec<f64>,
    /// The same with the mass integrated as CalculiX does.
    pub with_its_mass: Vec<f64>,
    /// The displacement of every node in each mode.
    pub shapes: Vec<Vec<f64>>,
    /// Displacement of every node under the first load pattern \[m\]; empty without.
    pub displacement: Vec<[f64; 3]>,
    /// Stress at every node under it \[Pa\]: xx, yy, zz, xy, yz, zx.
    pub stress: Vec<[f64; 6]>,
    /// The mesh as it was read.
    pub mesh: Mesh,
    /// The same by CalculiX.
    pub calculix: Option<Answer>,
}

/// How far two programs are apart.
#[derive(Clone, Copy, Debug)]
pub struct Apart {
    /// Largest relative difference of the frequencies.
    pub frequencies: f64,
    /// The same with one mass.
    pub with_its_mass: f64,
    /// Largest difference of the displacements, relative to the largest displacement.
    pub displacement: Option<f64>,
    /// Largest difference of a component of stress, relative to the largest von Mises stress.
    pub stress: Option<f64>,
}

/// Writes mesh and problem into a folder, reads them back, and computes.
///
/// # Panics
/// If anything fails.
#[must_use]
pub fn measure(witness: &Witness, folder: &Path, ask_calculix: bool) -> Found {
    let name = witness.name;
    deck::write(&folder.join(format!("{name}.inp")), &(witness.mesh)());
    let path = folder.join(format!("{name}.toml"));
    let source = repository().join(format!("tests/witnesses/{name}.toml"));
    std::fs::copy(&source, &path).unwrap_or_else(|error| panic!("{}: {error}", source.display()));
    let problem = Problem::read(&path).unwrap_or_else(|error| panic!("{error}"));
    let (modes, shapes) = natural_modes(&problem, Some(witness.count), None, &[], &Silent).expect("modes");
    let prepared = prepare(&problem, &mut Stopwatch::new(&Silent), &Silent).expect("a model");
    let (displacement, stress) = static_answer(&prepared, witness.thermal.as_ref()).unwrap_or_default();
    let mesh = shapes.mesh().clone();
    let calculix = ask_calculix.then(|| calculix::run(folder, witness, &problem, &mesh));
    Found {
        dofs: modes.dofs,
        with_its_mass: mass::frequencies(&prepared.body.model, witness.count),
        frequencies: modes.frequencies_hz,
        shapes: shapes.fields(),
        displacement,
        stress,
        mesh,
        calculix,
    }
}

/// Displacement and stress of every node.
type Static = (Vec<[f64; 3]>, Vec<[f64; 6]>);

/// `K⁻¹ f` of a temperature or of the first load pattern, and its stress, at all nodes.
fn static_answer(prepared: &Prepared, thermal: Option<&Thermal>) -> Option<Static> {
    let body = &prepared.body;
    let force = match thermal {
        Some(thermal) => thermal.force(&body.model),
        None => body.patterns.first()?.1.clone(),
    };
    let factor = prepared.symbolic.factor_of(body.model.pencil().stiffness()).expect("a factor");
    let mut answer = Mat::from_fn(force.len(), 1, |i, _| force[i]);
    Solve::new(&prepared.symbolic, 1, true).solve_in_place(&factor, answer.as_mut());
    let mut whole = vec![0.0; body.model.dofs().n_dof()];
    body.model.dofs().expand_into(answer.col_as_slice(0), &mut whole);
    let displacement = whole.as_chunks::<3>().0.to_vec();
    let mesh = body.model.mesh();
    let nodes: Vec<u32> = (0..mesh.nodes.len() as u32).collect();
    let rows = StressRows::new(&body.model, stress_points(mesh, &nodes)).expect("stress");
    let stress = |place: usize| {
        let mut stress = rows.stress(place, |node| displacement[node as usize]);
        if let Some(thermal) = thermal {
            let held = thermal.held(&body.model, mesh.nodes[place]);
            stress[..3].iter_mut().for_each(|direct| *direct -= held);
        }
        stress
    };
    let stress = (0..nodes.len()).map(stress).collect();
    Some((displacement, stress))
}

impl Found {
    /// The stress at a point, which must be a node.
    ///
    /// # Panics
    /// If it is none.
    #[must_use]
    pub fn stress_at(&self, at: &StressAt) -> f64 {
        self.stress[self.node_at(at.point)][at.component]
    }

    fn node_at(&self, point: [f64; 3]) -> usize {
        let near = |node: &[f64; 3]| (0..3).all(|c| (node[c] - point[c]).abs() < 1e-9);
        self.mesh.nodes.iter().position(near).expect("a node there")
    }
}

/// How far the two programs are apart.
#[must_use]
pub fn compare(found: &Found, answer: &Answer) -> Apart {
    let apart = |own: &[f64]| {
        own.iter().zip(&answer.frequencies).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max)
    };
    let length = |u: [f64; 3]| u.iter().map(|x| x * x).sum::<f64>().sqrt();
    let largest = answer.displacement.iter().copied().map(length).fold(0.0, f64::max);
    let pairs = found.displacement.iter().zip(&answer.displacement);
    let displacement = pairs.map(|(a, b)| length(std::array::from_fn(|c| a[c] - b[c])) / largest);
    let largest = answer.stress.iter().map(von_mises).fold(0.0, f64::max);
    let pairs = found.stress.iter().flatten().zip(answer.stress.iter().flatten());
    let stress = pairs.map(|(a, b)| (a - b).abs() / largest);
    Apart {
        frequencies: apart(&found.frequencies),
        with_its_mass: apart(&found.with_its_mass),
        displacement: displacement.reduce(f64::max),
        stress: stress.reduce(f64::max),
    }
}

fn von_mises([xx, yy, zz, xy, yz, zx]: &[f64; 6]) -> f64 {
    let direct = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
    (0.5 * direct + 3.0 * (xy * xy + yz * yz + zx * zx)).sqrt()
}

/// The tables of a witness.
#[must_use]
pub fn markdown(witness: &Witness, found: &Found) -> String {
    let mut out = format!("## {}\n\n{}; {} dofs.\n\n", witness.name, witness.what, found.dofs);
    out.push_str("| mode | here | CalculiX | reference | here ÷ reference |\n|---|---|---|---|---|\n");
    for (number, hz) in found.frequencies.iter().enumerate() {
        let other = found.calculix.as_ref();
        let other = other.map_or(String::new(), |answer| format!("{:.3} Hz", answer.frequencies[number]));
        let reference = witness.references.iter().find(|mode| mode.number == number);
        let (reference, ratio) = reference.map_or((String::new(), String::new()), |mode| {
            (format!("{} Hz", mode.hz), format!("{:.4}", hz / mode.hz))
        });
        let _ = writeln!(out, "| {} | {hz:.3} Hz | {other} | {reference} | {ratio} |", number + 1);
    }
    if let Some(at) = &witness.stress {
        let own = found.stress_at(at);
        let ratio = own / at.stress;
        let _ = write!(
            out,
            "\nThe stress is {:.4} MPa; reference {:.4} MPa, ratio {ratio:.4}",
            own / 1e6,
            at.stress / 1e6
        );
        if let Some(answer) = &found.calculix {
            let other = answer.stress[found.node_at(at.point)][at.component] / 1e6;
            let _ = write!(out, "; CalculiX {other:.4} MPa");
        }
        out.push_str(".\n");
    }
    if let Some(answer) = &found.calculix {
        let apart = compare(found, answer);
        let _ = write!(
            out,
            "\nLargest differences from CalculiX: frequencies {:.1e}, with its mass matrix {:.1e}",
            apart.frequencies, apart.with_its_mass
        );
        if let (Some(displacement), Some(stress)) = (apart.displacement, apart.stress) {
            let _ = write!(out, "; displacement {displacement:.1e}, stress {stress:.1e}");
        }
        out.push_str(".\n");
    }
    out
}
