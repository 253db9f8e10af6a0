//! Stress at nodes, as rows over the displacements.
//!
//! The stress of an element, by the law of its material from `ε`, the symmetric part of `∇u`, is taken at its
//! own nodes; a linear tetrahedron has one stress, and that of a straight quadratic one is linear, so that
//! this is what its four points of integration say, extrapolated. At a node the mean over the elements of one
//! region is taken (Hinton and Campbell 1974): across an interface of two materials stress jumps, so a node
//! there has a stress for each region.

use super::assembly::element_nodes;
use super::element::{ElementError, gradients, jacobian};
use super::material::StressBlock;
use super::model::Model;
use crate::mesh::shapes::{MAX_NODES, Point, reference_nodes, tabulate};
use crate::mesh::{ElementKind, Mesh};
use crate::parallel;

/// Components of a stress: xx, yy, zz, xy, yz, zx.
pub const COMPONENTS: usize = 6;

/// A node and a region to which some of its elements belong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
pub struct StressPoint {
    /// The mesh node.
    pub node: u32,
    /// The region, by its place in the mesh.
    pub region: u32,
}

/// Stress at points as rows over the displacements of nodes.
#[derive(Clone, Debug)]
pub struct StressRows {
    /// The points.
    pub points: Vec<StressPoint>,
    /// For each point the nodes that move its stress, ascending, and the derivative of the stress by their
    /// displacement, row by component of stress \[Pa/m\].
    pub rows: Vec<Vec<(u32, StressBlock)>>,
}

/// Each of the nodes with each region it belongs to, in the order of the nodes.
pub fn stress_points(mesh: &Mesh, nodes: &[u32]) -> Vec<StressPoint> {
    let mut regions = vec![vec![]; mesh.nodes.len()];
    for (e, &region) in mesh.element_region.iter().enumerate() {
        for &node in mesh.element(e) {
            if !regions[node as usize].contains(&region) {
                regions[node as usize].push(region);
            }
        }
    }
    regions.iter_mut().for_each(|regions| regions.sort_unstable());
    let of = |&node: &u32| regions[node as usize].iter().map(move |&region| StressPoint { node, region });
    nodes.iter().flat_map(of).collect()
}

impl StressRows {
    /// The rows at points, each one a node of an element of its region.
    ///
    /// # Errors
    /// [`ElementError`]: an element folds over at one of its nodes.
    pub fn new(model: &Model, points: Vec<StressPoint>) -> Result<StressRows, ElementError> {
        let mesh = model.mesh();
        let mut elements = vec![vec![]; mesh.nodes.len()];
        for e in 0..mesh.element_count() {
            mesh.element(e).iter().for_each(|&node| elements[node as usize].push(e));
        }
        let tables: Vec<(ElementKind, Vec<Point>)> = mesh
            .kinds
            .distinct()
            .into_iter()
            .map(|kind| (kind, reference_nodes(kind).into_iter().map(|at| tabulate(kind, at, 1.0)).collect()))
            .collect();
        let table = |kind: ElementKind| {
            &tables.iter().find(|(known, _)| *known == kind).expect("a table for each kind").1
        };
        let of_point = |at: usize| {
            let point: &StressPoint = &points[at];
            let own = |e: &&usize| mesh.element_region[**e] == point.region;
            let around: Vec<usize> = elements[point.node as usize].iter().filter(own).copied().collect();
            let share = 1.0 / around.len().max(1) as f64;
            let law = model.materials()[point.region as usize].law();
            let mut row: Vec<(u32, StressBlock)> = vec![];
            for e in around {
                let nodes = mesh.element(e);
                let place = nodes.iter().position(|&node| node == point.node).expect("a node of the element");
                let point = &table(mesh.kinds.kind(e))[place];
                let places = element_nodes::<MAX_NODES>(mesh, e as u32);
                let (inverse, _) = jacobian(nodes.len(), point, &places)?;
                let gradients = gradients(nodes.len(), point, &inverse);
                for (&node, g) in nodes.iter().zip(gradients) {
                    let block = law.stress_block(g, share);
                    match row.binary_search_by_key(&node, |entry| entry.0) {
                        Ok(known) => add(&mut row[known].1, &block),
                        Err(place) => row.insert(place, (node, block)),
                    }
                }
            }
            Ok(row)
        };
        let rows = parallel::try_map(points.len(), &of_point)?;
        Ok(StressRows { points, rows })
    }

    /// Stress \[Pa\] at point `place` of a displacement field, which is asked for by node.
    pub fn stress(&self, place: usize, displacement: impl Fn(u32) -> [f64; 3]) -> [f64; COMPONENTS] {
        let mut stress = [0.0; COMPONENTS];
        for (node, block) in &self.rows[place] {
            let u = displacement(*node);
            for (sum, row) in stress.iter_mut().zip(block) {
                *sum += row[0] * u[0] + row[1] * u[1] + row[2] * u[2];
            }
        }
        stress
    }
}

fn add(sum: &mut StressBlock, block: &StressBlock) {
    sum.as_flattened_mut().iter_mut().zip(block.as_flattened()).for_each(|(sum, x)| *sum += x);
}

#[cfg(test)]
mod tests {
    use super::super::material::Material;
    use super::super::test_mesh::{block, hold, moved, quadratic};
    use super::*;
    use crate::mesh::Region;

    const SOFT: Material = Material::isotropic(3.0, 0.3, 1.0);
    const STIFF: Material = Material::isotropic(50.0, 0.2, 1.0);

    /// Of a linear displacement, by hand: `σ = λ tr ε I + 2μ ε`.
    fn by_hand(gradient: [[f64; 3]; 3], material: &Material) -> [f64; COMPONENTS] {
        let (lambda, mu) = material.lame().expect("an isotropic material");
        let trace = (0..3).map(|i| gradient[i][i]).sum::<f64>();
        let at = |i: usize, j: usize| {
            mu * (gradient[i][j] + gradient[j][i]) + if i == j { lambda * trace } else { 0.0 }
        };
        [at(0, 0), at(1, 1), at(2, 2), at(0, 1), at(1, 2), at(2, 0)]
    }

    #[test]
    fn a_linear_displacement_has_one_stress_in_each_region() {
        let gradient = [[0.3, -0.2, 0.5], [0.1, 0.4, -0.7], [0.2, 0.6, -0.1]];
        for curved in [false, true] {
            let mut mesh = block([2, 2, 1], [2.0, 1.0, 0.5]);
            if curved {
                mesh = moved(quadratic(&mesh), |[x, y, z]| [x, y + 0.03 * x * x, z + 0.05 * (3.0 * x).sin()]);
            }
            mesh.regions.push(Region::new(2, "stiff"));
            let centre =
                |e: usize| mesh.element(e)[..4].iter().map(|&n| mesh.nodes[n as usize][0]).sum::<f64>();
            mesh.element_region = (0..mesh.element_count()).map(|e| u32::from(centre(e) > 4.0)).collect();
            let held = hold(&mesh, |[x, _, _]| x == 0.0);
            let all: Vec<u32> = (0..mesh.nodes.len() as u32).collect();
            let points = stress_points(&mesh, &all);
            let between = points.windows(2).filter(|pair| pair[0].node == pair[1].node).count();
            let expected = if curved { 5 * 3 } else { 3 * 2 };
            assert_eq!(between, expected, "nodes on the plane between the regions");
            let model = Model::assemble(mesh, &[SOFT, STIFF], &held).expect("a model");
            let rows = StressRows::new(&model, points).expect("rows");
            let nodes = &model.mesh().nodes;
            for (place, point) in rows.points.iter().enumerate() {
                let material = [SOFT, STIFF][point.region as usize];
                let found = rows.stress(place, |node| {
                    let x = nodes[node as usize];
                    gradient.map(|row| row[0] * x[0] + row[1] * x[1] + row[2] * x[2])
                });
                let exact = by_hand(gradient, &material);
                for k in 0..COMPONENTS {
                    assert!((found[k] - exact[k]).abs() < 1e-12 * 50.0, "{point:?} {k}");
                }
            }
        }
    }
}
