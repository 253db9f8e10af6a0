//! Natural frequencies of real meshes against another program.
//!
//! `../shared/reference/modal.json` holds what scikit-fem found with a consistent mass matrix, as ours is (its other columns
//! integrate the mass at one point or lump it, and lie up to 5 % away). Same mesh, element, material and held nodes: the matrices
//! agree to rounding, and so must the frequencies.

use serde_json::Value;
use vademecum_build::dynamics::lowest_modes;
use vademecum_build::fem::{Material, Model, Symbolic};
use vademecum_build::mesh;
use vademecum_tests::largest::largest_eigenvalue;
use vademecum_tests::shared::shared;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
}

/// Compares every frequency of one entry.
///
/// The tolerance is what rounding alone may do: an assembled matrix is off by ε of its largest eigenvalue, λ_max, whoever
/// assembles it, so an eigenvalue λ moves by ε λ_max, a frequency by half of ε λ_max/λ of itself, and there are two programs. The
/// reference's own iteration stops at its solves' precision, which is of that order and inside the bound.
fn agrees(name: &str) {
    let Some(reference) = shared("reference/modal.json") else { return };
    let text = std::fs::read_to_string(reference).expect("readable");
    let entry = serde_json::from_str::<Value>(&text).expect("JSON")[name].take();
    let Some(file) = shared(entry["mesh"].as_str().expect("a path")) else { return };
    let mesh = mesh::read(&file).expect("a usable mesh");
    assert_eq!(mesh.nodes.len() as u64, entry["nodes"].as_u64().expect("a count"));
    assert_eq!(mesh.element_count() as u64, entry["tets"].as_u64().expect("a count"));
    let mut held = vec![false; 3 * mesh.nodes.len()];
    for place in numbers(&entry["fixed_nodes_0based_in_original_file"]) {
        // No node of these files is dropped, so places in the file are places in the mesh.
        held[3 * place as usize..][..3].fill(true);
    }
    let [young, poisson, density] = ["E", "nu", "rho"].map(|key| entry[key].as_f64().expect("a number"));
    let materials = vec![Material { young, poisson, density }; mesh.regions.len()];
    let model = Model::assemble(mesh, &materials, &held).expect("a supported body");
    let pencil = model.pencil();
    let symbolic = Symbolic::analyze(pencil).expect("a pattern");
    let expected = numbers(&entry["skfem_consistent_Hz"]);
    let modes = lowest_modes(pencil, &symbolic, expected.len()).expect("modes");
    let largest = largest_eigenvalue(pencil, &symbolic);
    for ((found, expected), lambda) in modes.frequencies_hz().iter().zip(expected).zip(&modes.eigenvalues) {
        let (difference, tolerance) = ((found / expected - 1.0).abs(), f64::EPSILON * largest / lambda);
        println!("{name}: {found:.12} Hz, off by {difference:.1e}, rounding may do {tolerance:.1e}");
        assert!(
            difference <= tolerance,
            "{name}: {found} against {expected}: {difference:e} > {tolerance:e}"
        );
    }
}

#[test]
fn the_two_beams_have_the_reference_frequencies() {
    agrees("skfem_beams");
}

#[test]
fn the_liver_has_the_reference_frequencies() {
    agrees("sofa_liver");
}

#[test]
fn the_slender_bar_has_the_reference_frequencies() {
    agrees("polyfem_bar_14114");
}
