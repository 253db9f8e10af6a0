//! The geometric stiffness of every kind of element and formulation.

use faer::Mat;

use super::blocks::{Block, ElementMatrices};
use super::material::Material;
use super::prestress::{Prestress, Rotation};
use crate::mesh::shapes::reference_nodes;
use crate::mesh::{ElementKind, Hexahedra, Mesh, Region};

const SOLID: Material = Material::isotropic(7.0, 0.3, 2.0);

/// A place that no symmetry keeps: a map that bends faces.
fn bent([x, y, z]: [f64; 3]) -> [f64; 3] {
    [1.1 * x + 0.2 * y + 0.05 * y * z, 0.9 * y - 0.1 * z + 0.06 * x * x, 1.2 * z + 0.15 * x + 0.04 * x * y]
}

/// Every kind and formulation as a mesh of one bent element.
fn meshes() -> Vec<Mesh> {
    let mut meshes = vec![];
    for kind in ElementKind::all() {
        let formulations = match kind {
            ElementKind::Hex8 | ElementKind::Hex20 => Hexahedra::ALL.map(Some).to_vec(),
            _ => vec![None],
        };
        for hexahedra in formulations {
            let nodes: Vec<[f64; 3]> = reference_nodes(kind).into_iter().map(bent).collect();
            meshes.push(Mesh {
                node_ids: (1..=nodes.len() as u64).collect(),
                elements: (0..nodes.len() as u32).collect(),
                nodes,
                kinds: [kind].into_iter().collect(),
                element_region: vec![0],
                regions: vec![Region { hexahedra, ..Region::new(1, "body") }],
                node_groups: Default::default(),
                facet_groups: Default::default(),
                notes: vec![],
            });
        }
    }
    meshes
}

/// The matrices of the element about a displacement, and its name for messages.
fn about(mesh: &Mesh, state: &Prestress) -> (Block, Block, String) {
    let materials = [SOLID];
    let elements = ElementMatrices::new(mesh, &materials, &[false]);
    let (elastic, loaded) = (elements.block(0).unwrap(), elements.about(state).block(0).unwrap());
    (elastic, loaded, format!("{} {:?}", mesh.kinds.kind(0).vtk(), mesh.regions[0].hexahedra))
}

fn linear(mesh: &Mesh, gradient: [[f64; 3]; 3]) -> Vec<f64> {
    let of = |x: &[f64; 3]| gradient.map(|row| row[0] * x[0] + row[1] * x[1] + row[2] * x[2]);
    mesh.nodes.iter().flat_map(of).collect()
}

fn form(matrix: &Mat<f64>, v: &[f64]) -> f64 {
    let column = Mat::from_fn(v.len(), 1, |i, _| v[i]);
    (column.transpose() * (matrix * &column))[(0, 0)]
}

/// A uniform stress does the work `V Σ_c ∇v_c · σ ∇v_c` on a motion of uniform gradient, in an element of any
/// shape that passes the patch test.
#[test]
fn uniform_stress_does_the_work_of_the_second_order() {
    let (h, g) = (
        [[0.3, -0.2, 0.5], [0.1, 0.4, -0.7], [0.2, 0.6, -0.1]],
        [[0.5, 0.1, -0.4], [0.7, -0.3, 0.2], [-0.6, 0.8, 0.9]],
    );
    let stress = SOLID.law().stress(&h);
    let pull = |g: [f64; 3], k: &dyn Fn(usize, usize) -> f64| -> f64 {
        (0..3).map(|i| (0..3).map(|j| g[i] * k(i, j) * g[j]).sum::<f64>()).sum()
    };
    let whole: f64 = g.iter().map(|row| pull(*row, &|i, j| stress[i][j])).sum();
    for mesh in meshes() {
        let state = Prestress { displacement: linear(&mesh, h), ..Prestress::default() };
        let (elastic, loaded, name) = about(&mesh, &state);
        let added = &loaded.stiffness - &elastic.stiffness;
        let v = linear(&mesh, g);
        // The volume as the stiffness integrates it: by the energy of the motion itself.
        let own = SOLID.law().stress(&g);
        let density: f64 = (0..3).map(|c| (0..3).map(|i| own[c][i] * g[c][i]).sum::<f64>()).sum();
        let volume = form(&elastic.stiffness, &v) / density;
        let found = form(&added, &v);
        assert!((found / (volume * whole) - 1.0).abs() < 1e-10, "{name}: {found}, not {}", volume * whole);
        // Symmetric, and without an effect on a shift.
        for i in 0..added.nrows() {
            let shifted: f64 = (0..added.ncols()).filter(|j| j % 3 == 0).map(|j| added[(i, j)]).sum();
            assert!(shifted.abs() < 1e-11 * added.norm_max(), "{name} {shifted}");
            (0..i).for_each(|j| assert_eq!(loaded.stiffness[(i, j)], loaded.stiffness[(j, i)], "{name}"));
        }
    }
}

/// In the displaced body a motion has the strain `sym (Fᵀ ∇v)`.
#[test]
fn strains_about_the_displaced_body_are_those_of_its_gradient() {
    let (h, g) = (
        [[0.03, -0.02, 0.05], [0.01, 0.04, -0.07], [0.02, 0.06, -0.01]],
        [[0.5, 0.1, -0.4], [0.7, -0.3, 0.2], [-0.6, 0.8, 0.9]],
    );
    let turned: [[f64; 3]; 3] = std::array::from_fn(|i| {
        std::array::from_fn(|j| g[i][j] + (0..3).map(|c| h[c][i] * g[c][j]).sum::<f64>())
    });
    let energy = |g: &[[f64; 3]; 3]| {
        let own = SOLID.law().stress(g);
        (0..3).map(|c| (0..3).map(|i| own[c][i] * g[c][i]).sum::<f64>()).sum::<f64>()
    };
    for mesh in meshes() {
        let displacement = linear(&mesh, h);
        let small = Prestress { displacement, ..Prestress::default() };
        let (elastic, loaded, name) = about(&mesh, &small);
        let (_, whole, _) = about(&mesh, &Prestress { displaced: true, ..small });
        let v = linear(&mesh, g);
        let (own, change) = (form(&elastic.stiffness, &v), form(&(&whole.stiffness - &loaded.stiffness), &v));
        let expected = energy(&turned) / energy(&g) - 1.0;
        // Incompatible modes would follow a motion about the displaced body, and follow that of the body.
        let tolerance = 1e-10;
        assert!((change / own - expected).abs() < tolerance, "{name}: {} {expected}", change / own);
    }
}

#[test]
fn a_rotation_takes_the_mass_times_its_square_off_shifts_across() {
    let axis = [0.6, 0.0, 0.8];
    let v = [0.3, -0.5, 0.7];
    let along: f64 = (0..3).map(|c| axis[c] * v[c]).sum();
    let across = v.iter().map(|x| x * x).sum::<f64>() - along * along;
    for mesh in meshes() {
        let rotation = Rotation { elements: None, speed_squared: 9.0, point: [1.0, 2.0, 3.0], axis };
        let displacement = vec![0.0; 3 * mesh.nodes.len()];
        let (elastic, loaded, name) =
            about(&mesh, &Prestress { displacement, rotations: vec![rotation], ..Prestress::default() });
        let added = &loaded.stiffness - &elastic.stiffness;
        let shift: Vec<f64> = mesh.nodes.iter().flat_map(|_| v).collect();
        let mass = form(&elastic.mass, &mesh.nodes.iter().flat_map(|_| [1.0, 0.0, 0.0]).collect::<Vec<_>>());
        let found = form(&added, &shift);
        assert!((found / (-9.0 * mass * across) - 1.0).abs() < 1e-12, "{name}: {found}");
    }
}
