//! Measured order of convergence in the element size, against a known smooth field.

use super::assembly::element_nodes;
use super::element::jacobian;
use super::oracle_tests::{field, irregular, product, solve, surface_of, unheld};
use super::test_mesh::{block, quadratic};
use super::{Material, Model};
use crate::mesh::rules::rule_degree_6;
use crate::mesh::shapes::{TET_NODES, tabulate_point};
use crate::mesh::{Mesh, Order};

/// Errors in L2 and in the seminorm of the gradient against a smooth field with zero boundary values.
fn errors_in_h(mesh: &Mesh, reference: &Mesh) -> [f64; 2] {
    let unit = Material::isotropic(1.0, 0.25, 1.0);
    let (lambda, mu) = unit.lame().expect("an isotropic material");
    let pi = std::f64::consts::PI;
    let s = |x: [f64; 3]| x.map(|t| (pi * t).sin());
    let c = |x: [f64; 3]| x.map(|t| (pi * t).cos());
    // u = (w, 0, 0) with w = sin πx sin πy sin πz; −div σ = −μ Δu − (λ+μ) ∇ div u.
    let force = |x: [f64; 3]| {
        let (s, c, p) = (s(x), c(x), pi * pi * (lambda + mu));
        let w = s[0] * s[1] * s[2];
        [3.0 * pi * pi * mu * w + p * w, -p * c[0] * c[1] * s[2], -p * c[0] * s[1] * c[2]]
    };
    let gradient = |x: [f64; 3]| {
        let (s, c) = (s(x), c(x));
        [pi * c[0] * s[1] * s[2], pi * s[0] * c[1] * s[2], pi * s[0] * s[1] * c[2]]
    };
    let model = Model::assemble(mesh.clone(), &[unit], &surface_of(reference)).unwrap();
    // ∫ N f with f interpolated: its error is one order below the error measured in energy, equal order in
    // L2.
    let load = product(unheld(mesh, &[unit]).mass(), &field(mesh, force));
    let mut rhs = vec![0.0; model.dofs().n_free()];
    model.dofs().restrict_into(&load, &mut rhs);
    let mut u = vec![0.0; load.len()];
    model.dofs().expand_into(&solve(model.pencil(), &rhs), &mut u);
    let n = mesh.order().nodes_per_element();
    let mut squares = [0.0; 2];
    for (e, element) in mesh.elements.chunks_exact(n).enumerate() {
        let nodes: [[f64; 3]; TET_NODES] = element_nodes(mesh, e as u32);
        for (l, weight) in rule_degree_6() {
            let point = tabulate_point(mesh.order(), l, weight);
            let (inverse, determinant) = jacobian(n, &point, &nodes[..n]).unwrap();
            let at = |c: usize| (0..n).map(|a| point.values[a] * nodes[a][c]).sum::<f64>();
            let x = [at(0), at(1), at(2)];
            let exact = s(x);
            let value =
                |c: usize| (0..n).map(|a| point.values[a] * u[3 * element[a] as usize + c]).sum::<f64>();
            let mut off = [value(0) - exact[0] * exact[1] * exact[2], value(1), value(2)];
            squares[0] += weight * determinant * off.iter().map(|d| d * d).sum::<f64>();
            for c in 0..3 {
                let slopes: [f64; 3] = std::array::from_fn(|r| {
                    (0..n).map(|a| point.gradients[a][r] * u[3 * element[a] as usize + c]).sum()
                });
                let exact = if c == 0 { gradient(x) } else { [0.0; 3] };
                off = std::array::from_fn(|i| {
                    (0..3).map(|r| slopes[r] * inverse[r][i]).sum::<f64>() - exact[i]
                });
                squares[1] += weight * determinant * off.iter().map(|d| d * d).sum::<f64>();
            }
        }
    }
    squares.map(f64::sqrt)
}

#[test]
fn errors_fall_with_the_order_of_the_element() {
    for (order, cells, expected) in
        [(Order::Linear, [8, 16], [2.0, 1.0]), (Order::Quadratic, [4, 8], [3.0, 2.0])]
    {
        let errors = cells.map(|n| {
            let linear = irregular(n);
            let reference = block([n; 3], [1.0; 3]);
            match order {
                Order::Linear => errors_in_h(&linear[0], &reference),
                Order::Quadratic => errors_in_h(&linear[1], &quadratic(&reference)),
            }
        });
        for (norm, name) in ["L2", "energy"].into_iter().enumerate() {
            let slope = (errors[0][norm] / errors[1][norm]).log2();
            println!("{order:?} {name}: {:.3e} → {:.3e}, order {slope:.2}", errors[0][norm], errors[1][norm]);
            // The next term of the error is some (π h)² = 15 % of the first at h = 1/8: log2 1.15 = 0.2.
            assert!((slope - expected[norm]).abs() < 0.2, "{order:?} {name} {slope}");
        }
    }
}
