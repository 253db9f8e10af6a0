//! Ways to the same answer: factors of both precisions, columns apart and together, indices of both widths.

use faer::Mat;
use faer::prelude::ReborrowMut;

use super::material::Material;
use super::multifrontal::factorise;
use super::substitution::{gather, scatter, substitute, substitute_by_groups};
use super::test_mesh::{block, quadratic};
use super::{FactorError, Model, Pencil, Solve, Symbolic, SymmetricMatrix};
use crate::linalg::Random;
use crate::mesh::Mesh;

const STEEL: Material = Material::isotropic(2.1e11, 0.3, 7800.0);
const FOOT: Material = Material::isotropic(2.1e9, 0.1, 1000.0);

/// A bar that is held at one end, or nowhere.
fn bar(cells: [usize; 3], materials: &[Material], held: bool) -> Model {
    let mut mesh: Mesh = quadratic(&block(cells, [1.0, 0.1, 0.1]));
    let middle = |element: &[u32]| mesh.nodes[element[0] as usize][0] < 0.5;
    if materials.len() > 1 {
        let regions = mesh.elements.chunks(10).map(|element| u32::from(middle(element))).collect();
        mesh.element_region = regions;
        let second = crate::mesh::Region::new(2, "foot");
        mesh.regions.push(second);
    }
    let held: Vec<bool> = mesh.nodes.iter().flat_map(|node| [held && node[0] == 0.0; 3]).collect();
    Model::assemble(mesh, materials, &held).expect("a model")
}

fn forces(n: usize, columns: usize) -> Mat<f64> {
    let mut random = Random::new(3);
    Mat::from_fn(n, columns, |_, _| random.uniform() - 0.5)
}

/// `‖a − b‖ / ‖b‖` in the energy norm of the stiffness, the largest of all columns.
fn off(pencil: &Pencil, a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    let energies = |x: &Mat<f64>| -> Vec<f64> {
        let mut image = Mat::zeros(x.nrows(), x.ncols());
        pencil.stiffness().mul_into(x.as_ref(), image.as_mut());
        (0..x.ncols()).map(|c| (x.col(c).transpose() * image.col(c)).max(0.0)).collect()
    };
    let shares = energies(&(a - b)).into_iter().zip(energies(b));
    shares.map(|(off, whole)| (off / whole).sqrt()).fold(0.0, f64::max)
}

#[test]
fn columns_together_give_what_they_give_apart_with_any_number_of_threads() {
    let model = bar([20, 3, 3], &[STEEL], true);
    let pencil = model.pencil();
    let symbolic = Symbolic::analyze(pencil).expect("a structure");
    let supernodes = &**symbolic.supernodes();
    let values: Vec<f64> = factorise(supernodes, pencil.stiffness(), None).expect("a factor");
    for k in [1, 4, 5, 8, 24] {
        let given = forces(pencil.n_dof(), k);
        let mut spare = vec![0.0; supernodes.tallest() * k];
        let mut x = vec![0.0; given.nrows() * k];
        gather(supernodes, k, &mut x, |row, column| given[(row, column)]);
        substitute(supernodes, &values, &mut x, k, &mut spare);
        let mut apart = Mat::zeros(given.nrows(), k);
        scatter(supernodes, &x, k, apart.rb_mut(), |x, _, _| x);
        let together = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let mut x = vec![0.0; given.nrows() * k];
            let mut answer = Mat::zeros(given.nrows(), k);
            pool.install(|| {
                gather(supernodes, k, &mut x, |row, column| given[(row, column)]);
                substitute_by_groups(supernodes, &values, &mut x, k);
                scatter(supernodes, &x, k, answer.rb_mut(), |x, _, _| x);
            });
            answer
        };
        let [one, three] = [1, 3].map(together);
        assert!((0..k).all(|c| one.col_as_slice(c) == three.col_as_slice(c)), "the bits of {k} columns");
        let off = off(pencil, &one, &apart);
        assert!(off < 1e-11, "{off:e} for {k} columns");
    }
}

#[test]
fn a_factor_in_single_precision_solves_in_double_precision() {
    // Held and free, of one material and of two whose stiffness differs by 100, the soft one below.
    for (materials, held) in [(&[STEEL][..], true), (&[STEEL], false), (&[STEEL, FOOT], true)] {
        let model = bar([12, 2, 2], materials, held);
        let pencil = model.pencil();
        let double = Symbolic::analyze(pencil).expect("a structure");
        let single = double.clone().in_single_precision();
        assert!(single.stiffness_bytes() < double.stiffness_bytes() + 24 * (28 + 16) * pencil.n_dof());
        assert!(single.solver().is_some() && !single.has_entries() && single.here().has_entries());
        // A third of the stiffness has every entry rounded anew: what that moves is the floor.
        let third = pencil.combine(0.0, 1.0 / 3.0);
        let answer = |symbolic: &Symbolic, stiffness: &SymmetricMatrix| {
            let factor = symbolic.factor_of(stiffness).expect("a factor");
            let mut x = forces(symbolic.n(), 30);
            Solve::new(symbolic, 30, true).solve_in_place(&factor, x.as_mut());
            x
        };
        let exact = answer(&double, pencil.stiffness());
        let floor = off(pencil, &(answer(&double, &third) * faer::Scale(1.0 / 3.0)), &exact);
        let off = off(pencil, &answer(&single, pencil.stiffness()), &exact);
        single.check_solves().expect("solved to the tolerance");
        assert!(off < 10.0 * floor.max(1e-12), "{off:e}, floor {floor:e}, {} materials", materials.len());
        assert!(floor < 1e-8, "{floor:e}");
    }
}

#[test]
fn nothing_comes_of_nothing_and_an_indefinite_matrix_is_refused() {
    let model = bar([4, 1, 1], &[STEEL], true);
    let pencil = model.pencil();
    let symbolic = Symbolic::analyze(pencil).expect("a structure").in_single_precision();
    let factor = symbolic.factor_of(pencil.stiffness()).expect("a factor");
    let mut x = Mat::zeros(pencil.n_dof(), 2);
    x[(3, 1)] = 1e-60;
    Solve::new(&symbolic, 2, false).solve_in_place(&factor, x.as_mut());
    assert!(x.col_as_slice(0).iter().all(|&x| x == 0.0) && x[(3, 1)] > 0.0);
    symbolic.check_solves().expect("solved to the tolerance");
    let double = Symbolic::analyze(pencil).expect("a structure");
    for symbolic in [&symbolic, &double] {
        let factor = symbolic.factor_of(pencil.stiffness()).expect("a factor");
        Solve::new(symbolic, 0, true).solve_in_place(&factor, Mat::zeros(pencil.n_dof(), 0).as_mut());
    }
    let indefinite = pencil.combine(-1e12, 1.0);
    let refused = symbolic.factor_of(&indefinite).expect_err("no factor");
    assert!(matches!(refused, FactorError::NotConverged { .. }), "{refused}");
}
