use faer::Mat;

use super::RaisedSpace;
use crate::fem::test_mesh::hold;
use crate::fem::{Material, Model};
use crate::linalg::dot;
use crate::mesh::{Mesh, Order, block};

const MATERIAL: Material = Material::isotropic(3.0, 0.3, 2.0);

fn brick(order: Order) -> Model {
    let mesh: Mesh = block([2.0, 1.0, 1.5], [3, 2, 2], order);
    let held = hold(&mesh, |_| false);
    Model::assemble(mesh, &[MATERIAL], &held).unwrap()
}

/// The coefficients of a field in the raised space: values at the nodes, then what the functions of the
/// increment have to add on edges and faces.
fn coefficients(model: &Model, space: &RaisedSpace<'_>, field: impl Fn([f64; 3]) -> [f64; 3]) -> Mat<f64> {
    let mesh = model.mesh();
    let mut x = vec![0.0; space.n()];
    for (node, &at) in mesh.nodes.iter().enumerate() {
        x[3 * node..3 * node + 3].copy_from_slice(&field(at));
    }
    let at = |node: u32| mesh.nodes[node as usize];
    let between = |shares: &[(u32, f64)]| -> [f64; 3] {
        std::array::from_fn(|i| shares.iter().map(|&(node, share)| share * at(node)[i]).sum())
    };
    let difference = |point: [f64; 3], shown: [f64; 3], scale: f64| -> [f64; 3] {
        let value = field(point);
        std::array::from_fn(|c| (value[c] - shown[c]) / scale)
    };
    let sum = |shares: &[([f64; 3], f64)]| -> [f64; 3] {
        std::array::from_fn(|c| shares.iter().map(|(value, share)| share * value[c]).sum())
    };
    let mut edge_parts = std::collections::HashMap::new();
    for &[a, b] in &space.edges {
        let (function, _) = space.edge([a, b]);
        let value = match mesh.order() {
            Order::Linear => {
                let shown = sum(&[(field(at(a)), 0.5), (field(at(b)), 0.5)]);
                difference(between(&[(a, 0.5), (b, 0.5)]), shown, 1.0)
            }
            Order::Quadratic => {
                // At L = (2/3, 1/3) the quadratic functions have the values 2/9, −1/9 and 8/9, the cubic
                // 2/27.
                let middle = field(between(&[(a, 0.5), (b, 0.5)]));
                let shown =
                    sum(&[(field(at(a)), 2.0 / 9.0), (field(at(b)), -1.0 / 9.0), (middle, 8.0 / 9.0)]);
                difference(between(&[(a, 2.0 / 3.0), (b, 1.0 / 3.0)]), shown, 2.0 / 27.0)
            }
        };
        edge_parts.insert([a, b], value);
        space.add_at(function, value, &mut x);
    }
    for &[a, b, c] in &space.faces {
        // In the middle of a face edges' cubic functions vanish, corners have −1/9 and mid-sides 4/9.
        let middle = |p: u32, q: u32| field(between(&[(p, 0.5), (q, 0.5)]));
        let corners = [a, b, c].map(|node| (field(at(node)), -1.0 / 9.0));
        let mids = [middle(a, b), middle(b, c), middle(a, c)].map(|value| (value, 4.0 / 9.0));
        let third = 1.0 / 3.0;
        let value = difference(
            between(&[(a, third), (b, third), (c, third)]),
            sum(&[&corners[..], &mids[..]].concat()),
            1.0,
        );
        space.add_at(space.face([a, b, c]), value, &mut x);
    }
    let n = x.len();
    Mat::from_fn(n, 1, |i, _| x[i])
}

fn energies(space: &RaisedSpace<'_>, x: &Mat<f64>) -> [f64; 2] {
    space.products(x.as_ref()).map(|product| dot(x.col_as_slice(0), product.col_as_slice(0)))
}

#[test]
fn a_linear_mesh_raised_is_the_quadratic_one() {
    let field = |p: [f64; 3]| [p[0] * p[0] - p[1], p[0] * p[2] + 1.0, p[1] * p[1] - p[2] * p[0]];
    let (linear, quadratic) = (brick(Order::Linear), brick(Order::Quadratic));
    let space = RaisedSpace::new(&linear);
    assert_eq!(space.n(), quadratic.pencil().n_dof());
    let x: Vec<f64> = quadratic.mesh().nodes.iter().flat_map(|&p| field(p)).collect();
    let pencil = quadratic.pencil();
    let expected = [pencil.stiffness().inner(&x, &x), pencil.mass().inner(&x, &x)];
    let found = energies(&space, &coefficients(&linear, &space, field));
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} for {expected}");
    }
}

#[test]
fn a_quadratic_mesh_raised_holds_cubic_fields() {
    let model = brick(Order::Quadratic);
    let space = RaisedSpace::new(&model);
    // u = (x³, 0, 0) and (0, 0, xyz): energies by hand over 2 × 1 × 1.5.
    let (lambda, mu) = MATERIAL.lame().expect("an isotropic material");
    let cube = energies(&space, &coefficients(&model, &space, |p| [p[0].powi(3), 0.0, 0.0]));
    let expected = [(lambda + 2.0 * mu) * 9.0 * 32.0 / 5.0 * 1.5, 2.0 * 128.0 / 7.0 * 1.5];
    let mixed = energies(&space, &coefficients(&model, &space, |p| [0.0, 0.0, p[0] * p[1] * p[2]]));
    // ∫x² = 8/3, ∫y² = 1/3, ∫z² = 1.125; lengths 2, 1, 1.5.
    let (x2, y2, z2) = (8.0 / 3.0, 1.0 / 3.0, 1.125);
    let of_mixed = (lambda + 2.0 * mu) * x2 * y2 * 1.5 + mu * (2.0 * y2 * z2 + x2 * z2);
    for (found, expected) in
        cube.into_iter().chain(mixed).zip([expected[0], expected[1], of_mixed, 2.0 * x2 * y2 * z2])
    {
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} for {expected}");
    }
}

#[test]
fn the_preconditioner_is_symmetric_and_positive() {
    let mesh = block([1.0, 1.0, 1.0], [2, 2, 2], Order::Quadratic);
    let held = hold(&mesh, |p| p[0] == 0.0);
    let model = Model::assemble(mesh, &[MATERIAL], &held).unwrap();
    let space = RaisedSpace::new(&model);
    let symbolic = crate::fem::Symbolic::analyze(model.pencil()).unwrap();
    let factor = symbolic.factor_of(model.pencil().stiffness()).unwrap();
    let mut solve = crate::fem::Solve::new(&symbolic, 2, false);
    let mut random = crate::linalg::Random::new(7);
    let r = Mat::from_fn(space.n(), 2, |_, _| random.uniform() - 0.5);
    let mut z = r.clone();
    space.precondition(&factor, &mut solve, z.as_mut());
    let [ab, ba] = [(0, 1), (1, 0)].map(|(i, j)| dot(r.col_as_slice(i), z.col_as_slice(j)));
    assert!((ab - ba).abs() < 1e-10 * ab.abs().max(1.0), "{ab} {ba}");
    assert!((0..2).all(|k| dot(r.col_as_slice(k), z.col_as_slice(k)) > 0.0));
}
