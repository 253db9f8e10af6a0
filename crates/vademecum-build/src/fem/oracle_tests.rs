//! The stage against hand results: patch test, constant strain, rigid motion, known displacement fields,
//! convergence in h.

use faer::{Mat, MatRef};

use super::assembly::{assemble, element_nodes};
use super::dofs::DofMap;
use super::test_mesh::{block, hold, moved, quadratic};
use super::*;
use crate::linalg::vec3::cross;
use crate::mesh::{Mesh, Region};

const STEEL: Material = Material::isotropic(210e9, 0.3, 7800.0);

/// A unit box of irregular tetrahedra, in linear and in quadratic elements.
pub(super) fn irregular(cells: usize) -> [Mesh; 2] {
    let bump = |x: f64| x * (1.0 - x);
    let linear = moved(block([cells; 3], [1.0; 3]), |[x, y, z]| {
        let b = bump(x) * bump(y) * bump(z);
        [x + 2.1 * b, y - 1.7 * b, z + 1.3 * b * (1.0 + x)]
    });
    let quadratic = quadratic(&linear);
    [linear, quadratic]
}

/// A box whose inner and outer edges are curved; its volume stays 1 (a shear that varies along its own
/// normal).
fn curved(cells: usize) -> Mesh {
    moved(quadratic(&block([cells; 3], [1.0; 3])), |[x, y, z]| [x + 0.2 * y * y, y, z + 0.1 * x * x])
}

/// Matrices of a body nobody holds.
pub(super) fn unheld(mesh: &Mesh, materials: &[Material]) -> Pencil {
    assemble(mesh, materials, &DofMap::new(&vec![false; 3 * mesh.nodes.len()])).unwrap()
}

/// Nodal values of a displacement field.
pub(super) fn field(mesh: &Mesh, u: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<f64> {
    mesh.nodes.iter().flat_map(|&x| u(x)).collect()
}

pub(super) fn product(matrix: &SymmetricMatrix, x: &[f64]) -> Vec<f64> {
    let mut y = Mat::zeros(x.len(), 1);
    matrix.mul_into(MatRef::from_column_major_slice(x, x.len(), 1), y.as_mut());
    y.col_as_slice(0).to_vec()
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |l, v| v.abs().max(l))
}

pub(super) fn solve(pencil: &Pencil, rhs: &[f64]) -> Vec<f64> {
    let symbolic = Symbolic::analyze(pencil).unwrap();
    let factor = symbolic.factorize(pencil.stiffness().clone()).unwrap();
    let mut x = Mat::from_fn(rhs.len(), 1, |i, _| rhs[i]);
    Solve::new(&symbolic, 1, true).solve_in_place(&factor, x.as_mut());
    x.col_as_slice(0).to_vec()
}

/// Solves with given displacements on the box's surface.
fn solve_with_boundary(mesh: &Mesh, held: &[bool], boundary: &[f64], body: &[f64]) -> Vec<f64> {
    let model = Model::assemble(mesh.clone(), &[STEEL], held).unwrap();
    let whole = unheld(mesh, &[STEEL]);
    let known: Vec<f64> = boundary.iter().zip(held).map(|(&u, &h)| if h { u } else { 0.0 }).collect();
    let inner = product(whole.stiffness(), &known);
    let full: Vec<f64> = body.iter().zip(inner).map(|(f, k)| f - k).collect();
    let mut rhs = vec![0.0; model.dofs().n_free()];
    model.dofs().restrict_into(&full, &mut rhs);
    let mut u = vec![0.0; full.len()];
    model.dofs().expand_into(&solve(model.pencil(), &rhs), &mut u);
    u.iter().zip(known).map(|(a, b)| a + b).collect()
}

/// The dofs of nodes on the surface, found by the topology of the box before it was deformed.
pub(super) fn surface_of(reference: &Mesh) -> Vec<bool> {
    hold(reference, |p| p.iter().any(|&x| x == 0.0 || x == 1.0))
}

#[test]
fn a_linear_displacement_passes_the_patch_test() {
    let linear = |[x, y, z]: [f64; 3]| {
        [1e-3 * x + 2e-3 * y - 1e-3 * z, 5e-4 * x - 3e-3 * y, 2e-3 * z + 1e-3 * x + 4e-4 * y]
    };
    let [p1, p2] = irregular(3);
    let reference = block([3; 3], [1.0; 3]);
    for (mesh, reference) in
        [(p1, reference.clone()), (p2, quadratic(&reference)), (curved(3), quadratic(&reference))]
    {
        let exact = field(&mesh, linear);
        let none = vec![0.0; exact.len()];
        let found = solve_with_boundary(&mesh, &surface_of(&reference), &exact, &none);
        let off: Vec<f64> = found.iter().zip(&exact).map(|(a, b)| a - b).collect();
        // A refined solve of a well-conditioned patch: rounding times some tens.
        assert!(largest(&off) < 1e-13 * largest(&exact), "{:e}", largest(&off));
    }
}

#[test]
fn constant_strain_stores_the_energy_of_its_volume() {
    let (a, b, c, g) = (1e-3, -2e-3, 5e-4, 3e-3);
    let (lambda, mu) = STEEL.lame().expect("an isotropic material");
    let density = 0.5 * lambda * (a + b + c) * (a + b + c) + mu * (a * a + b * b + c * c) + 0.5 * mu * g * g;
    let [p1, p2] = irregular(3);
    for mesh in [p1, p2, curved(3)] {
        let u = field(&mesh, |[x, y, z]| [a * x + g * y, b * y, c * z]);
        let energy = 0.5 * unheld(&mesh, &[STEEL]).stiffness().inner(&u, &u);
        // Volume 1; sums over a thousand elements of like size.
        assert!((energy / density - 1.0).abs() < 1e-12, "{energy} against {density}");
    }
}

#[test]
fn mass_is_density_times_volume_in_every_direction() {
    let [p1, p2] = irregular(3);
    for mesh in [p1, p2, curved(3)] {
        let pencil = unheld(&mesh, &[STEEL]);
        for c in 0..3 {
            let one = field(&mesh, |_| std::array::from_fn(|i| f64::from(i == c)));
            assert!((pencil.mass().inner(&one, &one) / 7800.0 - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn rigid_motions_meet_no_force() {
    let [p1, p2] = irregular(2);
    for mesh in [p1, p2, curved(2)] {
        let pencil = unheld(&mesh, &[STEEL]);
        let stiffness = pencil.stiffness();
        // What rounding may leave: some tens of terms of the size of the entries.
        let bound = 1e-13 * largest(stiffness.values());
        for axis in 0..3 {
            let unit: [f64; 3] = std::array::from_fn(|i| f64::from(i == axis));
            for u in [field(&mesh, |_| unit), field(&mesh, |x| cross(unit, x))] {
                assert!(largest(&product(stiffness, &u)) < bound);
            }
        }
    }
}

/// Rollers on three faces: held in their own direction only.
fn rollers(reference: &Mesh) -> Vec<bool> {
    reference.nodes.iter().flat_map(|p| p.map(|x| x == 0.0)).collect()
}

/// Surface triangles of a mesh: faces of one element only, by their corners.
fn skin(mesh: &Mesh) -> Vec<[u32; 3]> {
    let mut count = std::collections::BTreeMap::new();
    for e in mesh.elements.chunks_exact(mesh.order().nodes_per_element()) {
        for face in [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]] {
            let mut key = face.map(|i| e[i]);
            key.sort_unstable();
            *count.entry(key).or_insert(0) += 1;
        }
    }
    count.into_iter().filter(|&(_, n)| n == 1).map(|(key, _)| key).collect()
}

#[test]
fn a_bar_in_tension_is_exact_by_traction_and_by_pressure() {
    let reference = block([3; 3], [1.0; 3]);
    let stress = 1e6;
    for (mesh, reference) in irregular(3).into_iter().zip([reference.clone(), quadratic(&reference)]) {
        let model = Model::assemble(mesh.clone(), &[STEEL], &rollers(&reference)).unwrap();
        let end: Vec<_> = skin(&mesh)
            .into_iter()
            .filter(|t| t.iter().all(|&n| reference.nodes[n as usize][0] == 1.0))
            .collect();
        let facets = surface_facets(&mesh, &end).unwrap();
        let strain = stress / STEEL.elasticity.modulus();
        let exact = field(&mesh, |[x, y, z]| [strain * x, -0.3 * strain * y, -0.3 * strain * z]);
        for load in [
            model.free_part(&model.traction_load(&facets, [stress, 0.0, 0.0])),
            model.free_part(&model.pressure_load(&facets, -stress)),
        ] {
            let mut u = vec![0.0; exact.len()];
            model.dofs().expand_into(&solve(model.pencil(), &load), &mut u);
            let off: Vec<f64> = u.iter().zip(&exact).map(|(a, b)| a - b).collect();
            // A refined solve: rounding times the condition of a stout body, about 1e3.
            assert!(largest(&off) < 1e-12 * largest(&exact), "{:e}", largest(&off) / largest(&exact));
        }
    }
}

#[test]
fn a_hanging_column_is_exact_in_quadratic_elements() {
    let soft = Material::isotropic(1e6, 0.0, 1000.0);
    let mesh = quadratic(&block([3, 2, 2], [1.0; 3]));
    let model = Model::assemble(mesh.clone(), &[soft], &rollers(&mesh)).unwrap();
    let load = model.free_part(&model.body_load([9.81, 0.0, 0.0]));
    let mut u = vec![0.0; 3 * mesh.nodes.len()];
    model.dofs().expand_into(&solve(model.pencil(), &load), &mut u);
    // E u'' = −ρ g, u(0) = 0, u'(1) = 0.
    let exact = field(&mesh, |[x, _, _]| [9810.0 / 1e6 * (x - 0.5 * x * x), 0.0, 0.0]);
    let off: Vec<f64> = u.iter().zip(&exact).map(|(a, b)| a - b).collect();
    assert!(largest(&off) < 1e-12 * largest(&exact));
}

#[test]
fn uniform_pressure_on_a_closed_curved_surface_has_no_resultant() {
    let reference = quadratic(&block([4; 3], [1.0; 3]));
    let mesh = curved(4);
    // Held inside only, so that no surface load falls on a support.
    let held = hold(&reference, |p| p.iter().all(|x| (x - 0.5).abs() < 0.3));
    let model = Model::assemble(mesh.clone(), &[STEEL], &held).unwrap();
    let facets = surface_facets(&mesh, &skin(&mesh)).unwrap();
    let mut load = vec![0.0; held.len()];
    model.dofs().expand_into(&model.free_part(&model.pressure_load(&facets, 1.0)), &mut load);
    for c in 0..3 {
        let force: f64 = load.iter().skip(c).step_by(3).sum();
        let moment: f64 = (0..mesh.nodes.len())
            .map(|n| cross(mesh.nodes[n], [load[3 * n], load[3 * n + 1], load[3 * n + 2]])[c])
            .sum();
        // Integrands of degree 4 under a rule of degree 5; forces of order 1 cancel to their rounding.
        assert!(force.abs() < 1e-13, "{force:e}");
        assert!(moment.abs() < 1e-13, "{moment:e}");
    }
    let area_scale: f64 = load.iter().map(|f| f.abs()).sum();
    assert!(area_scale > 1.0);
}

#[test]
fn a_point_force_goes_to_its_nodes_by_weight() {
    let mesh = block([2; 3], [1.0; 3]);
    let held = hold(&mesh, |p| p[0] == 0.0);
    let model = Model::assemble(mesh, &[STEEL], &held).unwrap();
    let nodes = [0, 2, 5];
    let mut load = vec![0.0; model.dofs().n_free()];
    model.add_point_force(&nodes, &[0.2, 0.3, 0.5], [1.0, -2.0, 4.0], &mut load);
    let mut full = vec![0.0; held.len()];
    model.dofs().expand_into(&load, &mut full);
    // Node 0 is held: its share goes into the support.
    assert_eq!(full[..3], [0.0; 3]);
    assert_eq!(full[6..9], [0.3, -0.6, 1.2]);
    assert_eq!(full[15..18], [0.5, -1.0, 2.0]);
}

#[test]
fn inner_and_foreign_facets_are_named() {
    let mesh = block([2; 3], [1.0; 3]);
    let inner = [mesh.elements[0], mesh.elements[2], mesh.elements[3]];
    assert_eq!(surface_facets(&mesh, &[inner]), Err(LoadError::InnerFacet { corners: inner }));
    let foreign = [0, 13, 26];
    assert_eq!(surface_facets(&mesh, &[foreign]), Err(LoadError::NoSuchFacet { corners: foreign }));
}

#[test]
fn what_can_still_move_is_refused_by_name() {
    let mesh = block([2; 3], [1.0; 3]);
    let modes_left = |held: Vec<bool>| match Model::assemble(mesh.clone(), &[STEEL], &held) {
        Err(ModelError::Unsupported { n_modes, n_nodes: 27, .. }) => n_modes,
        other => panic!("{other:?}"),
    };
    assert_eq!(modes_left(hold(&mesh, |p| p == [0.0; 3])), 3);
    assert_eq!(modes_left(hold(&mesh, |p| p[0] == 0.0 && p[1] == 0.0)), 1);
    let plane = mesh.nodes.iter().flat_map(|p| [p[0] == 0.0, false, false]).collect();
    assert_eq!(modes_left(plane), 3);
    assert!(Model::assemble(mesh.clone(), &[STEEL], &rollers(&mesh)).is_ok());
    assert_eq!(Model::assemble(mesh.clone(), &[STEEL], &[true; 81]).unwrap_err(), ModelError::NothingFree);
}

#[test]
fn materials_no_solid_has_are_refused_by_name() {
    let mesh = block([1; 3], [1.0; 3]);
    let held = hold(&mesh, |p| p[0] == 0.0);
    for wrong in [
        Material::isotropic(-1.0, 0.3, 7800.0),
        Material::isotropic(f64::NAN, 0.3, 7800.0),
        Material::isotropic(210e9, 0.5, 7800.0),
        Material { density: 0.0, ..STEEL },
    ] {
        let refused = Model::assemble(mesh.clone(), &[wrong], &held);
        assert!(matches!(refused, Err(ModelError::UnsoundMaterial { region, .. }) if region == "body"));
    }
    let few = Model::assemble(mesh.clone(), &[], &held);
    assert_eq!(few.unwrap_err(), ModelError::MaterialCount { found: 0, expected: 1 });
    let flags = Model::assemble(mesh, &[STEEL], &held[1..]);
    assert_eq!(flags.unwrap_err(), ModelError::SupportCount { found: 23, expected: 24 });
}

/// Two regions, split at the middle.
fn two_regions(cells: usize) -> Mesh {
    let mut mesh = quadratic(&block([cells; 3], [1.0; 3]));
    mesh.regions.push(Region::new(2, "right"));
    for e in 0..mesh.element_region.len() {
        let nodes: [[f64; 3]; 10] = element_nodes(&mesh, e as u32);
        mesh.element_region[e] = u32::from(nodes[..4].iter().map(|p| p[0]).sum::<f64>() > 2.0);
    }
    mesh
}

#[test]
fn regions_scale_apart_as_their_materials_do() {
    let mesh = two_regions(2);
    let held = hold(&mesh, |p| p[0] == 0.0);
    let rubber = Material::isotropic(1e7, 0.45, 1100.0);
    let nominal = Model::assemble(mesh.clone(), &[STEEL, rubber], &held).unwrap();
    let other = [Material::isotropic(420e9, 0.3, 7800.0), Material { density: 550.0, ..rubber }];
    let assembled = Model::assemble(mesh, &other, &held).unwrap();
    assert_eq!(nominal.pencil().n_regions(), 2);
    // Powers of two scale without rounding, so the bits agree.
    let scaled = nominal.pencil().scaled(&[1.0, 0.5], &[2.0, 1.0]);
    assert_eq!(scaled.mass().values(), assembled.pencil().mass().values());
    assert_eq!(scaled.stiffness().values(), assembled.pencil().stiffness().values());
}

#[test]
fn every_bit_is_the_same_for_one_and_two_threads() {
    let mesh = two_regions(7); // 10 125 dofs, 2 058 elements: several tasks everywhere
    let held = hold(&mesh, |p| p[0] == 0.0);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let model = Model::assemble(mesh.clone(), &[STEEL, STEEL], &held).unwrap();
            let pencil = model.pencil();
            let symbolic = Symbolic::analyze(pencil).unwrap();
            let factor = symbolic.factorize(pencil.combine(1e9, 1.0)).unwrap();
            let mut x = Mat::from_fn(pencil.n_dof(), 20, |i, j| ((i + 7 * j) as f64).sin());
            Solve::new(&symbolic, 20, true).solve_in_place(&factor, x.as_mut());
            (pencil.mass().values().to_vec(), pencil.stiffness().values().to_vec(), x)
        })
    };
    assert!(run(1) == run(2));
}

#[test]
fn matrices_are_symmetric_to_the_bit_and_products_add_up() {
    let mesh = curved(2);
    let pencil = unheld(&mesh, &[STEEL]);
    let n = pencil.n_dof();
    let dense = |m: &SymmetricMatrix| {
        let mut full = Mat::zeros(n, n);
        for j in 0..n {
            for (place, &i) in m.pattern().range(j).zip(m.pattern().rows_of(j)) {
                full[(i as usize, j)] = m.values()[place];
            }
        }
        full
    };
    let (mass, stiffness) = (dense(pencil.mass()), dense(pencil.stiffness()));
    assert!(mass == mass.transpose() && stiffness == stiffness.transpose());
    let x = Mat::from_fn(n, 11, |i, j| ((3 * i + j) as f64).cos());
    let mut pair = Mat::zeros(n, 11);
    pencil.mass().mul_pair_into(x.as_ref(), pencil.stiffness(), x.as_ref(), pair.as_mut());
    let expected = &mass * &x + &stiffness * &x;
    // Rows of some 200 terms of the size of the largest entry.
    assert!((pair - expected).norm_max() < 200.0 * f64::EPSILON * stiffness.norm_max());
}

#[test]
fn the_dissection_solves_and_refinement_sharpens() {
    let mesh = block([40, 3, 3], [4.0, 0.1, 0.1]);
    let held = hold(&mesh, |p| p[0] == 0.0);
    let model = Model::assemble(mesh, &[STEEL], &held).unwrap();
    let symbolic = Symbolic::analyze(model.pencil()).unwrap();
    let factor = symbolic.factorize(model.pencil().stiffness().clone()).unwrap();
    let n = symbolic.n();
    // A force at the tip: the hard case, a large displacement whose elastic forces nearly cancel.
    let rhs = Mat::from_fn(n, 1, |i, _| f64::from(i == n - 1));
    let solve = |refine: bool| {
        let mut x = rhs.clone();
        Solve::new(&symbolic, 1, refine).solve_in_place(&factor, x.as_mut());
        let mut product = Mat::zeros(n, 1);
        factor.matrix().mul_into(x.as_ref(), product.as_mut());
        ((&product - &rhs).norm_l2(), x)
    };
    let ((plain, _), (refined, x)) = (solve(false), solve(true));
    println!("slender beam, tip force 1 N: residual {plain:.1e} N, after one refinement {refined:.1e} N");
    // No product is known better than the rounding of its rows of at most 45 terms: (45 + 1) ε |A| |x|.
    let pattern = factor.matrix().pattern();
    let size = |i: usize| -> f64 {
        let row = pattern.range(i).zip(pattern.rows_of(i));
        row.map(|(place, &j)| (factor.matrix().values()[place] * x[(j as usize, 0)]).abs()).sum()
    };
    let rounding = (0..n).map(|i| size(i).powi(2)).sum::<f64>().sqrt() * 46.0 * f64::EPSILON;
    assert!(refined < rounding && refined <= plain, "{refined:e} against {rounding:e}");
    let negative = symbolic.factorize(model.pencil().combine(0.0, -1.0)).unwrap_err();
    assert!(matches!(negative, FactorError::NotPositiveDefinite { .. }));
}
