//! Natural frequencies against another program, of our own small bar and of real meshes.
//!
//! `fixtures/reference/modal.json` and `../shared/reference/modal.json` hold what scikit-fem found with a
//! consistent mass matrix, as ours is (other columns of the latter integrate the mass at one point or lump
//! it, and lie up to 5 % away). Same mesh, element, material and held nodes: the matrices agree to rounding,
//! and so must the frequencies.

use std::path::Path;

use serde_json::Value;
use vademecum_build::dynamics::lowest_modes;
use vademecum_build::fem::{Material, Model, Symbolic};
use vademecum_build::mesh::{self, Mesh};
use vademecum_tests::largest::largest_eigenvalue;
use vademecum_tests::program::repository;
use vademecum_tests::shared::shared;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
}

/// A file with a mesh, by scikit-fem's account.
struct Reference {
    name: String,
    mesh: Mesh,
    held: Vec<bool>,
    material: Material,
    frequencies: Vec<f64>,
}

/// Compares every frequency.
///
/// The tolerance is what rounding alone may do: an assembled matrix is off by ε of its largest eigenvalue,
/// λ_max, whoever assembles it, so an eigenvalue λ moves by ε λ_max, a frequency by half of ε λ_max/λ of
/// itself, and there are two programs. The reference's own iteration stops at its solves' precision, which is
/// of that order and inside the bound.
fn agrees(reference: Reference) {
    let Reference { name, mesh, held, material, frequencies } = reference;
    let materials = vec![material; mesh.regions.len()];
    let model = Model::assemble(mesh, &materials, &held).expect("a supported body");
    let pencil = model.pencil();
    let symbolic = Symbolic::analyze(pencil).expect("a pattern");
    let modes = lowest_modes(pencil, &symbolic, frequencies.len()).expect("modes");
    let largest = largest_eigenvalue(pencil, &symbolic);
    assert!(frequencies.len() >= 8);
    for ((found, expected), lambda) in modes.frequencies_hz().iter().zip(frequencies).zip(&modes.eigenvalues)
    {
        let (difference, tolerance) = ((found / expected - 1.0).abs(), f64::EPSILON * largest / lambda);
        println!("{name}: {found:.12} Hz, off by {difference:.1e}, rounding may do {tolerance:.1e}");
        assert!(
            difference <= tolerance,
            "{name}: {found} against {expected}: {difference:e} > {tolerance:e}"
        );
    }
}

fn entry(file: &Path, name: &str) -> Value {
    let text = std::fs::read_to_string(file).expect("readable");
    serde_json::from_str::<Value>(&text).expect("JSON")[name].take()
}

/// An entry of `fixtures/reference/modal.json`: our own bar, held at x = 0.
fn own(name: &str) -> Reference {
    let fixtures = repository().join("fixtures");
    let entry = entry(&fixtures.join("reference/modal.json"), name);
    let mesh = mesh::read(&fixtures.join(entry["mesh"].as_str().expect("a path"))).expect("a usable mesh");
    let held = mesh.nodes.iter().flat_map(|p| [p[0] == 0.0; 3]).collect();
    let [young, poisson, density] =
        ["young", "poisson", "density"].map(|key| entry[key].as_f64().expect("a number"));
    let frequencies = numbers(&entry["frequencies_hz"]);
    Reference {
        name: name.to_string(),
        mesh,
        held,
        material: Material::isotropic(young, poisson, density),
        frequencies,
    }
}

/// An entry of `../shared/reference/modal.json`.
fn real(name: &str) -> Option<Reference> {
    let entry = entry(&shared("reference/modal.json")?, name);
    let mesh = mesh::read(&shared(entry["mesh"].as_str().expect("a path"))?).expect("a usable mesh");
    assert_eq!(mesh.nodes.len() as u64, entry["nodes"].as_u64().expect("a count"));
    assert_eq!(mesh.element_count() as u64, entry["tets"].as_u64().expect("a count"));
    let mut held = vec![false; 3 * mesh.nodes.len()];
    for place in numbers(&entry["fixed_nodes_0based_in_original_file"]) {
        // No node of these files is dropped, so places in the file are places in the mesh.
        held[3 * place as usize..][..3].fill(true);
    }
    let [young, poisson, density] = ["E", "nu", "rho"].map(|key| entry[key].as_f64().expect("a number"));
    let frequencies = numbers(&entry["skfem_consistent_Hz"]);
    Some(Reference {
        name: name.to_string(),
        mesh,
        held,
        material: Material::isotropic(young, poisson, density),
        frequencies,
    })
}

#[test]
fn our_own_bar_has_the_reference_frequencies_in_both_orders() {
    ["linear", "quadratic"].map(own).into_iter().for_each(agrees);
}

#[test]
fn the_two_beams_have_the_reference_frequencies() {
    real("skfem_beams").into_iter().for_each(agrees);
}

#[test]
fn the_liver_has_the_reference_frequencies() {
    real("sofa_liver").into_iter().for_each(agrees);
}

#[test]
fn the_slender_bar_has_the_reference_frequencies() {
    real("polyfem_bar_14114").into_iter().for_each(agrees);
}
