//! A temperature as a load, which problem files do not have: the force of the strain that it wants, and the
//! stress that this strain does not make.

use vademecum_build::fem::{Elasticity, Model};
use vademecum_build::mesh::{Mesh, jacobian_10};

use super::mass::{points, quadratic};

/// A temperature over a body of quadratic elements of one material that is without stress at zero.
#[derive(Clone, Copy)]
pub struct Thermal {
    /// Thermal expansion \[1/K\].
    pub expansion: f64,
    /// Temperature \[K\] by place \[m\].
    pub temperature: fn([f64; 3]) -> f64,
}

impl Thermal {
    /// Stress in each direction where no strain is possible \[Pa\]: `E α T / (1 − 2ν)`.
    pub(super) fn held(&self, model: &Model, place: [f64; 3]) -> f64 {
        let Elasticity::Isotropic { young, poisson } = model.materials()[0].elasticity else {
            panic!("an isotropic material");
        };
        young / (1.0 - 2.0 * poisson) * self.expansion * (self.temperature)(place)
    }

    /// `∫ E α T / (1 − 2ν) ∇Nᵢ dV` over the free dofs, with the four points of degree 2.
    pub(super) fn force(&self, model: &Model) -> Vec<f64> {
        let (mesh, dofs) = (model.mesh(), model.dofs());
        let mut force = vec![0.0; model.pencil().n_dof()];
        for index in 0..mesh.element_count() {
            let element = mesh.element(index);
            let nodes: [[f64; 3]; 10] = std::array::from_fn(|i| mesh.nodes[element[i] as usize]);
            let held = nodes.map(|node| self.held(model, node));
            for (place, weight) in points(mesh.order()) {
                let volume = weight * jacobian_10(&nodes, [place[1], place[2], place[3]]);
                let stress: f64 = quadratic(place).iter().zip(held).map(|(n, held)| n * held).sum();
                for (node, gradient) in element.iter().zip(gradients(&nodes, place)) {
                    for (c, slope) in gradient.iter().enumerate() {
                        if let Some(dof) = dofs.free(3 * *node as usize + c) {
                            force[dof as usize] += volume * stress * slope;
                        }
                    }
                }
            }
        }
        force
    }
}

/// Gradients of the functions of a quadratic tetrahedron, by the chain rule.
fn gradients(nodes: &[[f64; 3]; 10], place: [f64; 4]) -> [[f64; 3]; 10] {
    // By the coordinates of the reference element; central differences of quadratic functions are exact.
    let slope = |direction: usize| -> [f64; 10] {
        let moved = |by: f64| {
            let mut place = place;
            place[direction + 1] += by;
            place[0] -= by;
            quadratic(place)
        };
        let (high, low) = (moved(0.5), moved(-0.5));
        std::array::from_fn(|i| high[i] - low[i])
    };
    let slopes = [slope(0), slope(1), slope(2)];
    // Rows of the Jacobian matrix, and its inverse by cross products.
    let row = |d: usize| -> [f64; 3] {
        std::array::from_fn(|c| slopes[d].iter().zip(nodes).map(|(slope, node)| slope * node[c]).sum())
    };
    let [a, b, c] = [row(0), row(1), row(2)];
    let cross = |u: [f64; 3], v: [f64; 3]| {
        [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    };
    let columns = [cross(b, c), cross(c, a), cross(a, b)];
    let determinant: f64 = a.iter().zip(columns[0]).map(|(a, b)| a * b).sum();
    std::array::from_fn(|i| {
        std::array::from_fn(|c| (0..3).map(|d| slopes[d][i] * columns[d][c]).sum::<f64>() / determinant)
    })
}

/// Temperatures of the nodes as a deck has them.
pub(super) fn lines(thermal: &Thermal, mesh: &Mesh) -> String {
    let line = |(id, place): (&u64, &[f64; 3])| format!("{id}, {:.12e}\n", (thermal.temperature)(*place));
    mesh.node_ids.iter().zip(&mesh.nodes).map(line).collect()
}
