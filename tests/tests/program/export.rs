//! `vademecum export matrices` end to end: what is written is the model, digit for digit, and enough to march
//! it.

use std::path::Path;

use serde_json::Value;
use vademecum_build::Matrix;
use vademecum_build::fem::{Pencil, SymmetricMatrix};
use vademecum_build::field::read_npy;
use vademecum_build::input::Problem;
use vademecum_build::prepared::{Prepared, prepare};
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_tests::program::{repository, vademecum};

fn export(folder: &Path) {
    let root = repository();
    let (problem, scenario) =
        (root.join("fixtures/problems/short-beam.toml"), root.join("fixtures/scenarios/short-push.toml"));
    let [problem, scenario, output] = [&*problem, &*scenario, folder].map(|p| p.to_str().expect("UTF-8"));
    let arguments = ["export", "matrices", problem, "--scenario", scenario, "--modes", "6", "-o", output];
    let ran = vademecum(&arguments);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
}

fn model() -> Prepared {
    let problem = Problem::read(&repository().join("fixtures/problems/short-beam.toml")).expect("a problem");
    prepare(&problem, &mut Stopwatch::new(&Silent), &Silent).expect("a model")
}

/// Entries of both triangles of a Matrix Market file, from 0.
fn read_market(path: &Path) -> (usize, Vec<(u32, u32, f64)>) {
    let text = std::fs::read_to_string(path).expect("a file");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("%%MatrixMarket matrix coordinate real symmetric"));
    let sizes: Vec<usize> = words(lines.next().expect("sizes"));
    assert!(sizes[0] == sizes[1], "a square matrix");
    let mut entries = vec![];
    for line in lines {
        let [row, column, value] = line.split(' ').collect::<Vec<_>>()[..] else { panic!("{line}") };
        let index = |word: &str| word.parse::<u32>().expect("an index") - 1;
        let (row, column, value) = (index(row), index(column), value.parse().expect("a number"));
        assert!(row >= column, "the lower triangle only");
        entries.push((row, column, value));
    }
    assert_eq!(entries.len(), sizes[2]);
    let mirrored = entries.iter().filter(|e| e.0 != e.1).map(|&(i, j, v)| (j, i, v)).collect::<Vec<_>>();
    entries.extend(mirrored);
    (sizes[0], entries)
}

fn words(line: &str) -> Vec<usize> {
    line.split(' ').map(|word| word.parse().expect("a number")).collect()
}

fn same(a: &SymmetricMatrix, b: &SymmetricMatrix) -> bool {
    a.pattern() == b.pattern() && a.values() == b.values()
}

#[test]
fn exported_matrices_read_back_are_the_model() {
    let folder = tempfile::tempdir().expect("a folder");
    export(folder.path());
    let at = |name: &str| folder.path().join(name);
    let prepared = model();
    let pencil = prepared.body.model.pencil();

    let ((n, mass), (_, stiffness)) = (read_market(&at("mass.mtx")), read_market(&at("stiffness.mtx")));
    let read = Pencil::from_triplets(n, &mass, &stiffness).expect("a pencil");
    assert!(same(read.mass(), pencil.mass()) && same(read.stiffness(), pencil.stiffness()));

    let basis = read_npy(&at("basis.npy")).expect("a basis");
    assert_eq!((basis.rows, basis.columns), (n, 6));
    let basis = Matrix::from_fn(n, 6, |i, k| basis.column(k)[i]);
    let mut image = Matrix::zeros(n, 6);
    read.mass().mul_into(basis.as_ref(), image.as_mut());
    let identity = basis.transpose() * image;
    // A basis is orthonormal to the rounding of sums over n = 324 entries.
    assert!((&identity - Matrix::identity(6, 6)).norm_max() <= 1e-12);

    let loads = read_npy(&at("loads.npy")).expect("loads");
    let text = std::fs::read_to_string(at("model.json")).expect("a model");
    let model: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!((loads.rows, loads.columns), (n, model["loads"].as_array().expect("a list").len()));
    assert!(loads.columns > 0);
    for (key, value) in [("dofs", n), ("modes", 6), ("version", 1)] {
        assert_eq!(model[key], value, "{key}");
    }
    assert_eq!(model["time_step"], 1e-3);
    assert_eq!((&model["scheme"]["name"], &model["basis"]), (&"bathe".into(), &"pod".into()));
    check_dofs(&std::fs::read_to_string(at("dofs.csv")).expect("dofs"), &prepared);
}

/// One line per free dof, at the place of its node.
fn check_dofs(text: &str, prepared: &Prepared) {
    let (mesh, map) = (prepared.body.model.mesh(), prepared.body.model.dofs());
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("row,node,component,x,y,z"));
    for (row, &dof) in map.dof_of_free().iter().enumerate() {
        let words: Vec<&str> = lines.next().expect("a line per dof").split(',').collect();
        assert_eq!(words[0], row.to_string());
        assert_eq!(words[2], ["x", "y", "z"][dof as usize % 3]);
        let place = [3, 4, 5].map(|c| words[c].parse::<f64>().expect("a number"));
        assert_eq!(place, mesh.nodes[dof as usize / 3]);
    }
    assert_eq!(lines.next(), None);
}
