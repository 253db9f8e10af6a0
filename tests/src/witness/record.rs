//! What is found of a witness, and the tables of the record.

use std::fmt::Write as _;
use std::path::Path;

use faer::Mat;
use vademecum_build::fem::Solve;
use vademecum_build::input::Problem;
use vademecum_build::mesh::Mesh;
use vademecum_build::prepared::{Prepared, prepare};
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_study::modes::natural_modes;

use super::bodies::Witness;
use super::calculix::{self, Answer};
use super::deck;
use crate::program::repository;

/// What this program finds, and CalculiX if it is asked.
pub struct Found {
    /// Free dofs.
    pub dofs: usize,
    /// Natural frequencies \[Hz\].
    pub frequencies: Vec<f64>,
    /// The displacement of every node in each mode.
    pub shapes: Vec<Vec<f64>>,
    /// Displacement of every node under the first load pattern \[m\], three numbers a node; empty without.
    pub displacement: Vec<f64>,
    /// The mesh as it was read.
    pub mesh: Mesh,
    /// The same by CalculiX.
    pub calculix: Option<Answer>,
}

/// Writes mesh and problem into a folder, reads them back, and computes.
///
/// # Panics
/// If anything fails.
pub fn measure(witness: &Witness, folder: &Path, ask_calculix: bool) -> Found {
    let name = witness.name;
    deck::write(&folder.join(format!("{name}.inp")), &(witness.mesh)());
    let path = folder.join(format!("{name}.toml"));
    let source = repository().join(format!("tests/witnesses/{name}.toml"));
    std::fs::copy(&source, &path).unwrap_or_else(|error| panic!("{}: {error}", source.display()));
    let problem = Problem::read(&path).unwrap_or_else(|error| panic!("{error}"));
    let (modes, shapes) = natural_modes(&problem, witness.count, &Silent).expect("modes");
    let mut displacement = vec![];
    if !problem.load.patterns.is_empty() {
        let prepared = prepare(&problem, &mut Stopwatch::new(&Silent), &Silent).expect("a model");
        displacement = static_answer(&prepared);
    }
    let mesh = shapes.mesh().clone();
    let calculix = ask_calculix.then(|| calculix::run(folder, name, &problem, &mesh, witness.count));
    let (dofs, frequencies, shapes) = (modes.dofs, modes.frequencies_hz, shapes.fields());
    Found { dofs, frequencies, shapes, displacement, mesh, calculix }
}

/// `K⁻¹ f` of the first load pattern, over all nodes.
fn static_answer(prepared: &Prepared) -> Vec<f64> {
    let body = &prepared.body;
    let factor = prepared.symbolic.factor_of(body.model.pencil().stiffness()).expect("a factor");
    let (_, force) = &body.patterns[0];
    let mut answer = Mat::from_fn(force.len(), 1, |i, _| force[i]);
    Solve::new(&prepared.symbolic, 1, true).solve_in_place(&factor, answer.as_mut());
    let mut whole = vec![0.0; body.model.dofs().n_dof()];
    body.model.dofs().expand_into(answer.col_as_slice(0), &mut whole);
    whole
}

/// Largest relative difference of the frequencies, and of the displacements relative to the largest one.
#[must_use]
pub fn compare(found: &Found, answer: &Answer) -> (f64, Option<f64>) {
    let apart = found.frequencies.iter().zip(&answer.frequencies).map(|(a, b)| (a / b - 1.0).abs());
    let length = |u: [f64; 3]| u.iter().map(|x| x * x).sum::<f64>().sqrt();
    let largest = answer.displacement.iter().copied().map(length).fold(0.0, f64::max);
    let pairs = found.displacement.as_chunks::<3>().0.iter().zip(&answer.displacement);
    let differences = pairs.map(|(a, b)| length(std::array::from_fn(|c| a[c] - b[c])) / largest);
    let statics = differences.reduce(f64::max);
    (apart.fold(0.0, f64::max), statics)
}

/// The frequencies beside the reference values and those of CalculiX, as rows of Markdown.
#[must_use]
pub fn frequencies_table(witness: &Witness, found: &Found) -> String {
    let mut out =
        String::from("| mode | here | CalculiX | reference | here ÷ reference |\n|---|---|---|---|---|\n");
    for (number, hz) in found.frequencies.iter().enumerate() {
        let other = found
            .calculix
            .as_ref()
            .map_or("not asked".into(), |answer| format!("{:.3}", answer.frequencies[number]));
        let reference = witness.references.iter().find(|mode| mode.number == number);
        let (reference, ratio) = reference.map_or((String::new(), String::new()), |mode| {
            (format!("{}", mode.hz), format!("{:.4}", hz / mode.hz))
        });
        let _ = writeln!(out, "| {} | {hz:.3} Hz | {other} | {reference} | {ratio} |", number + 1);
    }
    out
}
