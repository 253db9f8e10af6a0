//! Every kind of element and formulation: rigid motions, rank, patches of one kind and of several.

use faer::{Mat, Side};

use super::element::ElementKernel;
use super::material::{Elasticity, Material, Stiffness};
use super::model::Model;
use super::test_cells::{Cut, cube, cuts, formulations, layered, mixed};
use crate::mesh::shapes::{CORNERS, reference_nodes};
use crate::mesh::{ElementKind, Hexahedra, Mesh, Order};

const SOLID: Material = Material::isotropic(7.0, 0.3, 2.0);

/// The isotropic one, and one with axes that are not those of space.
fn solids() -> [Material; 2] {
    let wood = Stiffness::orthotropic([12.0, 2.0, 1.0], [0.3, 0.4, 0.35], [0.9, 1.1, 0.4]);
    let wood = wood.expect("a solid").along([[1.0, 2.0, -0.5], [2.0, -1.0, 0.7]]);
    [SOLID, Material { elasticity: Elasticity::Anisotropic(wood), density: 2.0 }]
}

/// A place that no symmetry keeps: a map that bends faces.
fn bent([x, y, z]: [f64; 3]) -> [f64; 3] {
    [1.1 * x + 0.2 * y + 0.05 * y * z, 0.9 * y - 0.1 * z + 0.06 * x * x, 1.2 * z + 0.15 * x + 0.04 * x * y]
}

/// The dense stiffness of one element.
fn stiffness(
    kind: ElementKind,
    hexahedra: Option<Hexahedra>,
    nodes: &[[f64; 3]],
    solid: &Material,
) -> Mat<f64> {
    let n = kind.nodes();
    let mut blocks = vec![0.0; 9 * n * n];
    ElementKernel::new(kind, hexahedra).stiffness_into(nodes, solid, &mut blocks).unwrap();
    Mat::from_fn(3 * n, 3 * n, |i, j| blocks[((i / 3) * n + j / 3) * 9 + 3 * (i % 3) + j % 3])
}

#[test]
fn rigid_motions_strain_nothing_and_nothing_else_does() {
    for kind in ElementKind::all() {
        let nodes: Vec<[f64; 3]> = reference_nodes(kind).into_iter().map(bent).collect();
        let each = formulations(kind).into_iter().flat_map(|named| solids().map(|solid| (named, solid)));
        for (hexahedra, solid) in each {
            let k = stiffness(kind, hexahedra, &nodes, &solid);
            let largest = k.norm_max();
            for motion in 0..6 {
                let at = |[x, y, z]: [f64; 3]| match motion {
                    0..3 => std::array::from_fn(|i| f64::from(u8::from(i == motion))),
                    3 => [0.0, -z, y],
                    4 => [z, 0.0, -x],
                    _ => [-y, x, 0.0],
                };
                let u = Mat::from_fn(k.nrows(), 1, |i, _| at(nodes[i / 3])[i % 3]);
                assert!((&k * &u).norm_max() < 1e-12 * largest, "{kind:?} {hexahedra:?} {motion}");
            }
            let values = k.self_adjoint_eigenvalues(Side::Lower).unwrap();
            let free = values.iter().filter(|&&value| value < 1e-9 * values[values.len() - 1]).count();
            let expected = match (kind, hexahedra) {
                (ElementKind::Hex20, Some(Hexahedra::Reduced | Hexahedra::ReducedMass)) => 12,
                // Its two points lie on the axis about which its triangles may turn against each other.
                (ElementKind::Wedge6, _) => 7,
                _ => 6,
            };
            assert_eq!(free, expected, "{kind:?} {hexahedra:?}");
        }
    }
}

#[test]
fn the_mass_is_that_of_the_volume_and_positive() {
    for kind in ElementKind::all() {
        let nodes: Vec<[f64; 3]> = reference_nodes(kind).into_iter().map(|x| x.map(|x| 2.0 * x)).collect();
        let n = kind.nodes();
        let mut mass = vec![0.0; n * n];
        ElementKernel::new(kind, None).mass_into(&nodes, SOLID.density, &mut mass).unwrap();
        let volume = match kind {
            ElementKind::Tet4 | ElementKind::Tet10 => 1.0 / 6.0,
            ElementKind::Pyramid5 | ElementKind::Pyramid13 => 4.0 / 3.0,
            ElementKind::Wedge6 | ElementKind::Wedge15 => 1.0,
            _ => 8.0,
        };
        let expected = SOLID.density * 8.0 * volume;
        assert!((mass.iter().sum::<f64>() - expected).abs() < 1e-13 * expected, "{kind:?}");
        let matrix = Mat::from_fn(n, n, |i, j| mass[i * n + j]);
        let least = matrix.self_adjoint_eigenvalues(Side::Lower).unwrap()[0];
        assert!(least > 1e-4 * expected / n as f64, "{kind:?} {least}");
    }
}

/// The largest force at free dofs under a linear displacement, beside the largest at held ones.
fn patch(mesh: Mesh, n: f64, solid: Material) -> f64 {
    let gradient = [[0.3, -0.2, 0.5], [0.1, 0.4, -0.7], [0.2, 0.6, -0.1]];
    let on = |x: &[f64; 3]| x.iter().any(|&x| x.abs() < 1e-12 || (x - n).abs() < 1e-12);
    let held: Vec<bool> = mesh.nodes.iter().flat_map(|x| [on(x); 3]).collect();
    let u: Vec<f64> = mesh
        .nodes
        .iter()
        .flat_map(|x| gradient.map(|row| (0..3).map(|i| row[i] * x[i]).sum::<f64>()))
        .collect();
    let model = Model::assemble(mesh, &[solid], &held).unwrap();
    let of = |held_part: bool| Mat::from_fn(u.len(), 1, |i, _| if held[i] == held_part { u[i] } else { 0.0 });
    let free: Vec<f64> = model.free_part(of(false).col_as_slice(0));
    let free = Mat::from_fn(free.len(), 1, |i, _| free[i]);
    let mut inside = Mat::<f64>::zeros(free.nrows(), 1);
    model.pencil().stiffness().mul_into(free.as_ref(), inside.as_mut());
    let [outside, _] = model.couple(of(true).as_ref());
    let largest = (0..inside.nrows()).map(|i| outside[(i, 0)].abs()).fold(0.0, f64::max);
    let rest = (0..inside.nrows()).map(|i| (inside[(i, 0)] + outside[(i, 0)]).abs()).fold(0.0, f64::max);
    rest / largest
}

#[test]
fn distorted_patches_of_each_kind_keep_a_constant_strain() {
    for Cut { name, elements } in cuts() {
        let kind = elements[0].0;
        let each = formulations(kind).into_iter().flat_map(|named| solids().map(|solid| (named, solid)));
        for (hexahedra, solid) in each {
            let mut mesh = cube(2, |_| elements.clone());
            mesh.regions[0].hexahedra = hexahedra;
            let rest = patch(mesh, 2.0, solid);
            assert!(rest < 1e-12, "{name} {kind:?} {hexahedra:?}: {rest:e}");
        }
    }
}

#[test]
fn mixed_patches_keep_a_constant_strain() {
    for order in [Order::Linear, Order::Quadratic] {
        let rest = patch(cube(2, mixed(order)), 2.0, SOLID);
        assert!(rest < 1e-12, "{order:?}: {rest:e}");
        let rest = patch(cube(2, layered(order)), 2.0, solids()[1]);
        assert!(rest < 1e-12, "{order:?}: {rest:e}");
    }
}

/// A slender beam bends as far as its theory says with incompatible modes, and far less without.
#[test]
fn incompatible_modes_do_not_lock_in_bending() {
    let tip = |hexahedra| {
        let mut beam = cube(1, |_| vec![]);
        let (cells, mut kinds) = (10, vec![]);
        for cell in 0..cells {
            let x = cell as f64;
            for [a, b, c] in CORNERS {
                let place = [x + 0.5 * (1.0 + a), 0.5 * (1.0 + b), 0.5 * (1.0 + c)];
                let known = beam.nodes.iter().position(|p| *p == place);
                let node = known.unwrap_or_else(|| {
                    beam.nodes.push(place);
                    beam.nodes.len() - 1
                });
                beam.elements.push(node as u32);
            }
            kinds.push(ElementKind::Hex8);
        }
        beam.kinds = kinds.into_iter().collect();
        beam.element_region = vec![0; cells];
        beam.node_ids = (0..beam.nodes.len() as u64).collect();
        beam.regions[0].hexahedra = Some(hexahedra);
        let held: Vec<bool> = beam.nodes.iter().flat_map(|p| [p[0] == 0.0; 3]).collect();
        let material = Material::isotropic(1000.0, 0.0, 1.0);
        let end: Vec<usize> = (0..beam.nodes.len()).filter(|&i| beam.nodes[i][0] == 10.0).collect();
        let model = Model::assemble(beam, &[material], &held).unwrap();
        let mut load = vec![0.0; held.len()];
        end.iter().for_each(|&node| load[3 * node + 2] = 0.25);
        let free = model.free_part(&load);
        let dense =
            Mat::from_fn(free.len(), free.len(), |i, j| model.pencil().stiffness().get(i, j).unwrap_or(0.0));
        let force = Mat::from_fn(free.len(), 1, |i, _| free[i]);
        let factor = dense.llt(Side::Lower).unwrap();
        let u = faer::linalg::solvers::Solve::solve(&factor, &force);
        let mut all = vec![0.0; held.len()];
        model.dofs().expand_into(u.col_as_slice(0), &mut all);
        all[3 * end[0] + 2]
    };
    // Timoshenko: F L³/(3 E I) + F L/(κ G A), κ = 5/6.
    let theory = 1000.0 / (3.0 * 1000.0 / 12.0) + 10.0 / (5.0 / 6.0 * 500.0);
    let (soft, stiff) = (tip(Hexahedra::Incompatible), tip(Hexahedra::Full));
    assert!((soft / theory - 1.0).abs() < 0.01, "{soft} {theory}");
    assert!(stiff < 0.75 * theory, "{stiff} {theory}");
}

#[test]
fn the_bits_do_not_depend_on_the_number_of_threads() {
    let matrices = |threads: usize| -> Vec<f64> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let beam = cube(2, |_| vec![(ElementKind::Hex8, (0..8).collect())]);
            let held: Vec<bool> = beam.nodes.iter().flat_map(|p| [p[0] == 0.0; 3]).collect();
            Model::assemble(beam, &[SOLID], &held).unwrap().pencil().stiffness().values().to_vec()
        })
    };
    assert_eq!(matrices(1), matrices(2));
}
