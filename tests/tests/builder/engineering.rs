//! Published benchmarks, and CalculiX on the same meshes: the record of `docs/measurements/engineering.md`.

use vademecum_build::input::Problem;
use vademecum_build::mesh::{ElementKind, Hexahedra};
use vademecum_build::progress::Silent;
use vademecum_study::modes::natural_modes;
use vademecum_tests::program::repository;
use vademecum_tests::witness::{
    Apart, Found, Witness, bend, calculix, compare, measure, whole_cylinder, witness, witnesses, write_deck,
};

fn found(witness: &Witness, ask: bool) -> Found {
    let folder = tempfile::tempdir().expect("a folder");
    measure(witness, folder.path(), ask)
}

/// What the literature says of a witness, within the share that the record gives and explains.
fn agrees(name: &str) {
    let (witness, asked) = (witness(name), calculix::is_there());
    let found = found(&witness, asked);
    assert!(!witness.references.is_empty() || witness.stress.is_some(), "{name} has nothing to compare");
    for mode in witness.references {
        let ratio = found.frequencies[mode.number] / mode.hz;
        assert!((ratio - 1.0).abs() < witness.within, "{name}, mode {}: {ratio}", mode.number + 1);
    }
    if let Some(at) = &witness.stress {
        let ratio = found.stress_at(at) / at.stress;
        assert!((ratio - 1.0).abs() < witness.within, "{name}: {ratio}");
    }
    if name == "fv41" {
        around_the_axis(&witness, &found);
    }
    if let Some(answer) = &found.calculix {
        holds(name, compare(&found, answer));
    }
}

/// Sides of these are straight, so that both programs have the same elements. Those of the others are curved
/// (of the membrane too, along the diagonals of its trapezoids), and CalculiX integrates them with fewer
/// points and takes their stress at these points, not at the nodes.
const STRAIGHT: [&str; 5] = ["fv22", "fv52-plate", "fv52-quarter", "beam", "beam-linear"];

/// CalculiX prints seven digits of a frequency or a displacement and six of a stress.
fn holds(name: &str, apart: Apart) {
    let below = |value: Option<f64>, most: f64| value.is_some_and(|value| value < most);
    if STRAIGHT.contains(&name) {
        assert!(apart.with_its_mass < 2e-6, "{name}: {apart:?}");
        assert!(below(apart.displacement, 2e-6) && below(apart.stress, 1e-4), "{name}: {apart:?}");
    } else if name != "fv41" {
        assert!(below(apart.displacement, 1e-3) && below(apart.stress, 3e-2), "{name}: {apart:?}");
    }
    // Linear elements feel the mass matrix of one point.
    assert!(apart.frequencies < if name == "beam-linear" { 3e-2 } else { 1e-3 }, "{name}: {apart:?}");
}

/// The modes with reference values move no node along the circle, and all others do.
fn around_the_axis(witness: &Witness, found: &Found) {
    for (number, shape) in found.shapes.iter().enumerate() {
        let nodes = found.mesh.nodes.iter().zip(shape.as_chunks::<3>().0);
        let along = nodes.map(|([x, y, _], u)| (x * u[1] - y * u[0]).abs() / x.hypot(*y)).fold(0.0, f64::max);
        let round = witness.references.iter().any(|mode| mode.number == number);
        // The largest displacement of a shape is 1.
        assert!(if round { along < 0.02 } else { along > 0.2 }, "mode {}: {along}", number + 1);
    }
}

#[test]
fn a_clamped_rhombic_plate() {
    agrees("fv22");
}

#[test]
fn a_tapered_membrane() {
    agrees("fv32");
}

#[test]
fn a_thick_square_plate() {
    agrees("fv52-plate");
    agrees("fv52-quarter");
}

#[test]
fn a_free_cylinder() {
    agrees("fv41");
}

/// The whole cylinder, with the modes that are antisymmetric in the middle of its length.
#[test]
fn a_whole_free_cylinder() {
    let folder = tempfile::tempdir().expect("a folder");
    write_deck(&folder.path().join("fv41.inp"), &whole_cylinder(36, 16));
    let text = std::fs::read_to_string(repository().join("tests/witnesses/fv41.toml")).expect("a problem");
    let (text, _) = text.split_once("[[support]]").expect("supports to leave out");
    let problem = Problem::parse(text, "fv41.toml", folder.path().into()).expect("a problem");
    let (modes, shapes) = natural_modes(&problem, Some(64), None, &[], &Silent).expect("modes");
    let mesh = shapes.mesh();
    // Those in which no point moves along the circle.
    let along = |shape: &[f64]| {
        let nodes = mesh.nodes.iter().zip(shape.as_chunks::<3>().0);
        nodes.map(|([x, y, _], u)| (x * u[1] - y * u[0]).abs() / x.hypot(*y)).fold(0.0, f64::max)
    };
    let fields = shapes.fields();
    let found = modes.frequencies_hz.iter().zip(&fields).filter(|(_, shape)| along(shape) < 0.05);
    let found: Vec<f64> = found.map(|(hertz, _)| *hertz).collect();
    let highest = modes.frequencies_hz.last();
    println!("{} dofs, {} modes up to {highest:?} Hz; {found:.3?} Hz", modes.dofs, fields.len());
    let references = [243.53, 377.41, 394.11, 397.72, 405.28];
    assert!(found.len() >= references.len(), "{found:?}");
    for (found, reference) in found.iter().zip(references) {
        assert!((found / reference - 1.0).abs() < 0.002, "{found} Hz, {reference} Hz");
    }
}

#[test]
fn an_elliptic_plate_under_pressure() {
    agrees("le10");
}

#[test]
fn a_temperature() {
    agrees("le11");
}

#[test]
fn two_beams_have_the_matrices_of_calculix() {
    if calculix::is_there() {
        for name in ["beam", "beam-linear"] {
            let found = found(&witness(name), true);
            holds(name, compare(&found, found.calculix.as_ref().expect("an answer")));
        }
    }
}

#[test]
fn a_beam_bends_far_as_calculix_bends_it() {
    if !calculix::is_there() {
        return;
    }
    // Of linear tetrahedra both integrals are exact, other kinds have the same points in both programs, and
    // CalculiX prints seven digits. Four points in a quadratic tetrahedron are not exact.
    for (kind, formulation, within) in [
        (ElementKind::Tet4, Hexahedra::Full, 1e-6),
        (ElementKind::Tet10, Hexahedra::Full, 1e-3),
        (ElementKind::Wedge15, Hexahedra::Full, 1e-6),
        (ElementKind::Hex8, Hexahedra::Full, 1e-6),
        (ElementKind::Hex20, Hexahedra::Full, 1e-6),
        (ElementKind::Hex20, Hexahedra::Reduced, 1e-6),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let bent = bend(kind, formulation, folder.path());
        println!("{kind:?} {formulation:?}: {bent:?}");
        assert!(bent.largest > 0.4 && bent.linear > 0.2, "{bent:?}");
        assert!(bent.apart < within, "{kind:?} {formulation:?} {bent:?}");
    }
}

#[test]
fn every_witness_has_a_problem_file_and_every_file_a_witness() {
    let folder = vademecum_tests::program::repository().join("tests/witnesses");
    let entries = std::fs::read_dir(folder).expect("a folder");
    let name = |entry: std::io::Result<std::fs::DirEntry>| {
        entry.expect("an entry").path().file_stem().expect("a name").to_string_lossy().into_owned()
    };
    let mut files: Vec<String> = entries.map(name).collect();
    files.sort();
    let mut known: Vec<String> = witnesses().iter().map(|witness| witness.name.to_string()).collect();
    known.sort();
    assert_eq!(files, known);
}
