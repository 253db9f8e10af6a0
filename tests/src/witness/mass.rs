//! Natural frequencies with the mass matrix of CalculiX.
//!
//! CalculiX integrates `∫ ρ Nᵢ Nⱼ` with fewer points than the product needs: one for linear tetrahedra, four
//! for quadratic ones. Here the integral is exact where sides are straight. With the points of CalculiX both
//! programs have the same matrices, so what is left shows that nothing else differs.

use vademecum_build::dynamics::lowest_modes;
use vademecum_build::fem::{Model, Pencil, Symbolic};
use vademecum_build::mesh::{Order, jacobian_10};

/// The lowest frequencies \[Hz\] of a model with one material, its mass integrated with one point or four.
///
/// # Panics
/// If the modes do not converge.
#[must_use]
pub fn frequencies(model: &Model, count: usize) -> Vec<f64> {
    let pencil = Pencil::from_triplets(model.pencil().n_dof(), &mass(model), &stiffness(model));
    let pencil = pencil.expect("a pencil");
    let symbolic = Symbolic::analyze(&pencil).expect("an order");
    lowest_modes(&pencil, &symbolic, count).expect("modes").frequencies_hz()
}

fn stiffness(model: &Model) -> Vec<(u32, u32, f64)> {
    let matrix = model.pencil().stiffness();
    let column = |j: usize| {
        let range = matrix.pattern().range(j);
        let rows = matrix.pattern().rows_of(j).iter();
        rows.zip(&matrix.values()[range]).map(move |(&i, &value)| (i, j as u32, value))
    };
    (0..matrix.n()).flat_map(column).collect()
}

fn mass(model: &Model) -> Vec<(u32, u32, f64)> {
    let (mesh, dofs, density) = (model.mesh(), model.dofs(), model.materials()[0].density);
    let mut entries = vec![];
    for index in 0..mesh.element_count() {
        let element = mesh.element(index);
        let corners: Vec<[f64; 3]> = element.iter().map(|node| mesh.nodes[*node as usize]).collect();
        for (place, weight) in points(mesh.order()) {
            let (values, volume) = match mesh.order() {
                Order::Linear => (place.to_vec(), linear_jacobian(&corners)),
                Order::Quadratic => {
                    let corners: &[[f64; 3]; 10] = corners[..].try_into().expect("ten nodes");
                    (quadratic(place).to_vec(), jacobian_10(corners, [place[1], place[2], place[3]]))
                }
            };
            for (i, a) in element.iter().zip(&values) {
                for (j, b) in element.iter().zip(&values) {
                    let value = density * weight * volume * (a * b);
                    for c in 0..3 {
                        let free = |node: u32| dofs.free(3 * node as usize + c);
                        entries.extend(free(*i).zip(free(*j)).map(|(i, j)| (i, j, value)));
                    }
                }
            }
        }
    }
    entries
}

/// Barycentric coordinates and weights; the weights sum to the volume 1/6.
pub(super) fn points(order: Order) -> Vec<([f64; 4], f64)> {
    match order {
        Order::Linear => vec![([0.25; 4], 1.0 / 6.0)],
        Order::Quadratic => {
            let root = 5.0_f64.sqrt();
            let (a, b) = ((5.0 + 3.0 * root) / 20.0, (5.0 - root) / 20.0);
            let at = |i: usize| std::array::from_fn(|k| if k == i { a } else { b });
            (0..4).map(|i| (at(i), 1.0 / 24.0)).collect()
        }
    }
}

/// The functions of a quadratic tetrahedron.
pub(super) fn quadratic(l: [f64; 4]) -> [f64; 10] {
    let corner = |i: usize| l[i] * (2.0 * l[i] - 1.0);
    let mid = |i: usize, j: usize| 4.0 * l[i] * l[j];
    let corners = [corner(0), corner(1), corner(2), corner(3)];
    let mids = [mid(0, 1), mid(1, 2), mid(2, 0), mid(0, 3), mid(1, 3), mid(2, 3)];
    std::array::from_fn(|i| if i < 4 { corners[i] } else { mids[i - 4] })
}

fn linear_jacobian(corners: &[[f64; 3]]) -> f64 {
    let edge = |i: usize| -> [f64; 3] { std::array::from_fn(|k| corners[i][k] - corners[0][k]) };
    let [a, b, c] = [edge(1), edge(2), edge(3)];
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
}
