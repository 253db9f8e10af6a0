//! What the basis promises, reduced to seconds: the record at full size is `docs/measurements/basis.md`, made
//! by `records/basis.rs` from the same code.

use vademecum_build::input::Problem;
use vademecum_build::progress::Silent;
use vademecum_eval::StructureChoice;
use vademecum_study::parts::Study;
use vademecum_tests::bases::{Row, Variant, compare, file};
use vademecum_tests::long_march::{energy_ratio, precision};
use vademecum_tests::program::repository;

const STRUCTURES: [StructureChoice; 2] = [StructureChoice::Diagonal, StructureChoice::Block];

/// The short beam, 324 dofs.
fn study(max_modes: usize) -> Study {
    let path = repository().join("fixtures/problems/short-beam.toml");
    Study::new(&Problem::read(&path).expect("the fixture"), max_modes, &Silent).expect("a study")
}

fn rows(rows: &[Row], variant: Variant) -> impl Iterator<Item = &Row> {
    rows.iter().filter(move |row| row.variant == variant)
}

#[test]
fn both_structures_reach_the_floor_of_the_ritz_basis_and_galerkin_on_a_pod_does_not() {
    let variants = [Variant::RitzDiagonal, Variant::RitzBlock, Variant::PodGalerkin];
    let found = compare(&study(32), &variants, &[8, 16, 32], 2000, &Silent);
    found.iter().for_each(|row| println!("{row:?}"));
    for row in &found {
        assert!(row.spectral_radius <= 1.0 + 1e-12, "{row:?}");
    }
    // The project's promise: error ≤ 1.1 × floor + 1e-6 at positions and in directions no snapshot had.
    for row in rows(&found, Variant::RitzDiagonal).chain(rows(&found, Variant::RitzBlock)) {
        assert!(row.excess <= 1.1, "{row:?}");
    }
    // What it is compared with must be able to lose: eight POD vectors are not closed under the dynamics.
    let galerkin = rows(&found, Variant::PodGalerkin).next().expect("eight modes");
    assert!(galerkin.modes == 8 && galerkin.ratio > 2.0, "{galerkin:?}");
}

#[test]
fn a_file_stays_bounded_for_a_million_steps() {
    let bytes = file(&study(16), 16);
    for structure in STRUCTURES {
        let ratio = energy_ratio::<f64>(&bytes, structure, 1_000_000);
        println!("{structure:?}: largest energy over that at release {ratio:.9}");
        // Bathe only takes energy away; the project's bound is 1.05.
        assert!(ratio <= 1.05 && ratio > 0.5, "{structure:?}: {ratio}");
    }
}

#[test]
fn single_precision_stays_within_two_parts_in_a_thousand() {
    let bytes = file(&study(16), 16);
    for structure in STRUCTURES {
        let apart = precision(&bytes, structure, 200_000);
        println!("{structure:?}: {apart:?}");
        // The project's bound after 2e5 steps.
        assert!(apart.held <= 2e-3 && apart.released <= 2e-3, "{structure:?}: {apart:?}");
        assert!(apart.held > 0.0, "single precision is not double");
    }
}
