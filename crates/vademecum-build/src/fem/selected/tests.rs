//! Selected entries against dense inverses and against solves.

use faer::Side;
use faer::linalg::solvers::DenseSolveCore;

use super::*;
use crate::fem::material::Material;
use crate::fem::test_mesh::{block, quadratic};
use crate::fem::{Model, Pencil, Solve};
use crate::linalg::Random;
use crate::mesh::Mesh;
use crate::progress::{Silent, is_cancelled};

const RUBBER: Material = Material::isotropic(2e6, 0.3, 1100.0);

/// A block that is held at one end.
fn held(mesh: Mesh) -> Model {
    let held: Vec<bool> = mesh.nodes.iter().flat_map(|node| [node[0] == 0.0; 3]).collect();
    Model::assemble(mesh, &[RUBBER], &held).expect("a model")
}

fn selected(pencil: &Pencil) -> (Symbolic, SelectedInverse) {
    let symbolic = Symbolic::analyze(pencil).expect("a structure");
    let factor = symbolic.factorize(pencil.stiffness().clone()).expect("a factor");
    let selected = factor.select(pencil.mass(), 0..symbolic.n(), &Silent).expect("no end");
    (symbolic, selected)
}

/// The largest difference of two lists over the largest of the second.
fn off(pairs: &[[f64; 2]]) -> f64 {
    let largest = |of: &dyn Fn(&[f64; 2]) -> f64| pairs.iter().map(of).fold(0.0_f64, |a, b| a.max(b.abs()));
    largest(&|[found, exact]| found - exact) / largest(&|[_, exact]| *exact)
}

#[test]
fn entries_are_those_of_dense_inverses() {
    // A chain (simplicial), linear and quadratic elements (groups of several columns), with a dissection.
    let chain: Vec<(u32, u32, f64)> = (0..40)
        .flat_map(|i| [(i, i, 3.0 + f64::from(i) / 40.0), (i, (i + 7) % 40, -1.0), ((i + 7) % 40, i, -1.0)])
        .collect();
    let weight: Vec<(u32, u32, f64)> = (0..40).map(|i| (i, i, 1.0 + f64::from(i % 3))).collect();
    let chain = Pencil::from_triplets(40, &weight, &chain).expect("a pencil");
    let bodies = [
        block([4, 2, 2], [0.5, 0.2, 0.3]),
        block([9, 4, 4], [1.0, 0.4, 0.5]),
        quadratic(&block([3, 2, 2], [0.5, 0.2, 0.3])),
        quadratic(&block([6, 2, 2], [0.5, 0.2, 0.3])),
    ]
    .map(|mesh| held(mesh).pencil().clone());
    let mut simplicial = 0;
    for pencil in [chain].iter().chain(&bodies) {
        let n = pencil.n_dof();
        let dense = |matrix: &SymmetricMatrix| {
            let mut image = Mat::zeros(n, n);
            matrix.mul_into(Mat::<f64>::identity(n, n).as_ref(), image.as_mut());
            image
        };
        let inverse = dense(pencil.stiffness()).llt(Side::Lower).expect("definite").inverse();
        let weighted = &inverse * dense(pencil.mass()) * &inverse;
        let (symbolic, found) = selected(pencil);
        simplicial += usize::from(symbolic.supernodes().groups.iter().all(|group| group.columns == 1));
        let pattern = symbolic.pattern();
        let places = || (0..n).flat_map(|j| pattern.rows_of(j).iter().map(move |&i| (i as usize, j)));
        let at = |(i, j)| [found.inverse(i, j).expect("on the pattern"), inverse[(i, j)]];
        assert!(off(&places().map(at).collect::<Vec<_>>()) < 1e-12);
        let at = |(i, j)| [found.weighted(i, j).expect("on the pattern"), weighted[(i, j)]];
        assert!(off(&places().map(at).collect::<Vec<_>>()) < 1e-12);
        // Wherever there is an entry it is right, and it is the same both ways round.
        let all = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
        let filled: Vec<[f64; 2]> =
            all.clone().filter_map(|(i, j)| Some([found.inverse(i, j)?, inverse[(i, j)]])).collect();
        assert!(filled.len() >= pattern.n_stored() && off(&filled) < 1e-12);
        assert!(all.into_iter().all(|(i, j)| found.weighted(i, j) == found.weighted(j, i)));
    }
    assert!(simplicial > 0 && simplicial < 5, "{simplicial} of 5");
}

#[test]
fn entries_of_ten_thousand_dofs_are_those_of_solves() {
    let model = held(quadratic(&block([15, 5, 5], [1.5, 0.5, 0.5])));
    let pencil = model.pencil();
    let n = pencil.n_dof();
    assert!(n > 10_000, "{n}");
    let (symbolic, found) = selected(pencil);
    let factor = symbolic.factorize(pencil.stiffness().clone()).expect("a factor");
    let mut random = Random::new(5);
    let columns: Vec<usize> = (0..24).map(|_| random.below(n)).collect();
    let mut answers = Mat::from_fn(n, 24, |i, j| f64::from(i == columns[j]));
    let mut solve = Solve::new(&symbolic, 24, true);
    solve.solve_in_place(&factor, answers.as_mut());
    let mut weighted = Mat::zeros(n, 24);
    pencil.mass().mul_into(answers.as_ref(), weighted.as_mut());
    solve.solve_in_place(&factor, weighted.as_mut());
    for (place, &column) in columns.iter().enumerate() {
        let rows = symbolic.pattern().rows_of(column).iter().map(|&row| row as usize);
        let at = |row| [found.inverse(row, column).expect("an entry"), answers[(row, place)]];
        assert!(off(&rows.clone().map(at).collect::<Vec<_>>()) < 1e-10);
        let at = |row| [found.weighted(row, column).expect("an entry"), weighted[(row, place)]];
        assert!(off(&rows.map(at).collect::<Vec<_>>()) < 1e-10);
    }
}

#[test]
fn entries_of_some_rows_have_the_bits_of_all() {
    let model = held(quadratic(&block([8, 4, 4], [1.0, 0.5, 0.5])));
    let pencil = model.pencil();
    let (symbolic, all) = selected(pencil);
    let rows = [0, 1, 2, symbolic.n() / 2, symbolic.n() - 1];
    let factor = symbolic.factorize(pencil.stiffness().clone()).expect("a factor");
    let some = factor.select(pencil.mass(), rows, &Silent).expect("no end");
    for (i, j) in rows.into_iter().flat_map(|i| rows.map(|j| (i, j))) {
        assert_eq!(some.inverse(i, j), all.inverse(i, j));
        assert_eq!(some.weighted(i, j), all.weighted(i, j));
    }
    let numbers = |of: &SelectedInverse| of.weighted.iter().map(Vec::len).sum::<usize>();
    assert!(numbers(&some) < numbers(&all));
}

#[test]
fn the_bits_do_not_depend_on_the_number_of_threads() {
    let model = held(quadratic(&block([8, 4, 4], [1.0, 0.5, 0.5])));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let (_, found) = pool.install(|| selected(model.pencil()));
        (found.inverse, found.weighted)
    };
    let one = with(1);
    assert!([2, 3].into_iter().all(|threads| with(threads) == one));
}

/// Wants to stop after some pieces.
struct Stop(usize);

impl Listener for Stop {
    fn stage(&self, _: &str) {}
    fn advance(&self, done: usize, total: usize) {
        assert!(done <= total);
    }
    fn note(&self, _: &str) {}
    fn cancelled(&self) -> bool {
        self.0 == 0
    }
}

#[test]
fn it_stops_on_request() {
    let model = held(block([4, 2, 2], [0.5, 0.2, 0.3]));
    let symbolic = Symbolic::analyze(model.pencil()).expect("a structure");
    for (pieces, stops) in [(0, true), (1, false)] {
        let factor = symbolic.factorize(model.pencil().stiffness().clone()).expect("a factor");
        let found = factor.select(model.pencil().mass(), 0..symbolic.n(), &Stop(pieces));
        assert_eq!(found.as_ref().err().is_some_and(|error| is_cancelled(error)), stops);
    }
}
