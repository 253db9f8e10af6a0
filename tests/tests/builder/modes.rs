//! Natural modes as engineers read them: effective masses, shapes, and modal assurance.

use std::path::PathBuf;

use vademecum_build::field::{DenseMatrix, read_displacements, write_npy};
use vademecum_build::input::Problem;
use vademecum_build::progress::Silent;
use vademecum_study::modes::natural_modes;
use vademecum_tests::program::vademecum;

/// A slender beam, so that theory without shear is right to a percent.
const BEAM: &str = r#"
[mesh]
block = { lengths = [1.0, 0.03, 0.04], divisions = [20, 1, 1], order = "quadratic" }
[[material]]
young = 2.1e11
poisson = 0.0
density = 7800.0
[[support]]
on = { group = "x_min" }
"#;

fn beam() -> Problem {
    Problem::parse(BEAM, "beam.toml", PathBuf::new()).expect("a problem")
}

#[test]
fn effective_masses_are_those_of_a_cantilever() {
    let (modes, _) = natural_modes(&beam(), Some(12), None, &[], &Silent).expect("modes");
    // All of the beam but half of its first elements, which the clamp holds.
    let whole = 1.0 * 0.03 * 0.04 * 7800.0;
    for mass in modes.free_mass {
        assert!(mass < whole && mass > 0.95 * whole, "{mass} of {whole}");
    }
    // Bending of a clamped-free beam (Blevins): 61.3 %, 18.8 % and 6.5 % of the mass, each along one axis.
    // The clamp keeps a little of the mass, and the shares of what is left are a little larger.
    let along = |axis: usize| -> Vec<f64> {
        let other = 3 - axis;
        let shares = modes.effective_mass.iter();
        shares
            .filter(|share| share[axis] > 0.02 && share[axis] > share[other])
            .map(|share| share[axis])
            .collect()
    };
    for axis in [1, 2] {
        let found = along(axis);
        for (found, expected) in found.iter().zip([0.6131, 0.1883, 0.0647]) {
            assert!((found / expected - 1.0).abs() < 0.03, "{found}, {expected}");
        }
        assert!(found.len() >= 3, "{found:?}");
    }
    let sums: [f64; 3] = std::array::from_fn(|c| modes.effective_mass.iter().map(|share| share[c]).sum());
    assert!(sums.iter().all(|sum| *sum < 1.0 + 1e-9) && sums[1] > 0.85 && sums[2] > 0.85, "{sums:?}");
    for (factors, shares) in modes.participation.iter().zip(&modes.effective_mass) {
        for c in 0..3 {
            assert!((factors[c].powi(2) / modes.free_mass[c] - shares[c]).abs() < 1e-12);
        }
    }
}

#[test]
fn shapes_are_written_and_are_their_own_best_match() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("beam.toml"), BEAM).expect("written");
    let (modes, shapes) = natural_modes(&beam(), Some(4), None, &[], &Silent).expect("modes");
    let fields = shapes.fields();
    let longest = |field: &[f64]| {
        let lengths = field.as_chunks::<3>().0.iter().map(|u| u.iter().map(|x| x * x).sum::<f64>().sqrt());
        lengths.fold(0.0, f64::max)
    };
    assert!(fields.iter().all(|field| (longest(field) - 1.0).abs() < 1e-12));
    // Modes of "another program": the same in another order, one upside down, one doubled.
    let others: Vec<f64> = [(2, 1.0), (0, -1.0), (1, 2.0)]
        .iter()
        .flat_map(|&(mode, factor)| fields[mode].iter().map(move |x| factor * x))
        .collect();
    let matrix = DenseMatrix { rows: fields[0].len(), columns: 3, data: others };
    write_npy(&path("others.npy"), &matrix).expect("written");
    let table = shapes.assurance(&path("others.npy")).expect("a table");
    for (mode, row) in table.iter().enumerate() {
        for (other, value) in row.iter().enumerate() {
            let same = [2, 0, 1][other] == mode;
            // The mass of a uniform beam is spread evenly, so shapes are nearly orthogonal without it.
            assert!(if same { (value - 1.0).abs() < 1e-12 } else { *value < 0.1 }, "{mode} {other}: {value}");
        }
    }

    let text = |name: &str| path(name).display().to_string();
    let line = ["modes", &text("beam.toml"), "--count", "4", "--shapes", &text("m.vtu"), "--assurance"];
    let ran = vademecum(&[&line[..], &[&text("others.npy"), "--json"]].concat());
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let json = ran.json();
    assert!((json["assurance"][2][0].as_f64().expect("a number") - 1.0).abs() < 1e-12);
    assert_eq!(json["effective_mass"].as_array().map(Vec::len), Some(4));
    let name = format!("mode 2 ({:.4} Hz)", modes.frequencies_hz[1]);
    let read = read_displacements(&[path("m.vtu")], &name, shapes.mesh()).expect("a field");
    assert!(read.column(0) == fields[1].as_slice());
    let short = DenseMatrix { rows: 6, columns: 1, data: vec![1.0; 6] };
    write_npy(&path("short.npy"), &short).expect("written");
    let line = ["modes", &text("beam.toml"), "--assurance", &text("short.npy")];
    vademecum(&line).fails(3, &["short.npy: 6 rows", "three for each node"]);
}
