//! The strain field against differences, rotations, hand results and the linear stiffness.

use super::element::{ElementKernel, jacobian};
use super::green::{GreenError, GreenStrain};
use super::material::Material;
use super::model::Model;
use super::pencil::Pencil;
use super::sparse::SymmetricMatrix;
use super::test_cells::{cells, cube, cuts, formulations, layered, mixed};
use super::test_mesh::{block, hold, moved, quadratic};
use crate::linalg::Random;
use crate::mesh::rules::rule_degree_6;
use crate::mesh::shapes::{TET_NODES, tabulate_point};
use crate::mesh::{ElementKind, Hexahedra, Mesh, Order, Region};

const SOFT: Material = Material::isotropic(3.0, 0.3, 1.0);
const STIFF: Material = Material::isotropic(50.0, 0.2, 2.0);

/// Linear, straight quadratic and curved quadratic bodies of two regions.
fn meshes() -> [Mesh; 3] {
    let mut mesh = block([2, 2, 1], [2.0, 1.0, 0.5]);
    mesh.regions.push(Region::new(2, "stiff"));
    mesh.element_region = (0..mesh.element_count()).map(|e| u32::from(e % 4 == 1)).collect();
    let straight = quadratic(&mesh);
    let curved = moved(straight.clone(), |[x, y, z]| [x, y + 0.03 * x * x, z + 0.05 * (3.0 * x).sin()]);
    [mesh, straight, curved]
}

/// Cubes of 2 × 2 × 2, distorted inside, of every kind and formulation that is taken, and mixed ones.
fn cubes() -> Vec<(String, Mesh)> {
    let mut all = vec![];
    for cut in cuts() {
        let kind = cut.elements[0].0;
        let each = formulations(kind).into_iter();
        for named in each.filter(|named| kind != ElementKind::Hex8 || named.is_some_and(is_taken)) {
            let mut mesh = cube(2, |_| cut.elements.clone());
            mesh.regions[0].hexahedra = named;
            all.push((format!("{} {kind:?} {named:?}", cut.name), mesh));
        }
    }
    for order in [Order::Linear, Order::Quadratic] {
        for (name, mut mesh) in [("mixed", cube(2, mixed(order))), ("layers", cube(2, layered(order)))] {
            mesh.regions[0].hexahedra = Some(Hexahedra::Full);
            all.push((format!("{name} {order:?}"), mesh));
        }
    }
    all
}

/// Of 8-node hexahedra.
fn is_taken(hexahedra: Hexahedra) -> bool {
    matches!(hexahedra, Hexahedra::Full | Hexahedra::MeanDilatation)
}

/// Bodies of two regions: of tetrahedra, the cubes, those of second order with curved edges too, and
/// tetrahedra of both orders in one mesh.
fn bodies() -> Vec<(String, Mesh)> {
    let mut all: Vec<(String, Mesh)> = cubes();
    for (name, mesh) in cubes() {
        if mesh.order() == Order::Quadratic {
            let map = |[x, y, z]: [f64; 3]| [x + 0.02 * x * y, y + 0.03 * x * x, z + 0.05 * (2.0 * x).sin()];
            all.push((format!("curved {name}"), moved(mesh, map)));
        }
    }
    let [linear, quadratic] = [0, 4].map(|place| cuts().remove(place).elements);
    let both = |cell: usize| if cell.is_multiple_of(2) { linear.clone() } else { quadratic.clone() };
    all.push(("tetrahedra of both orders".into(), cube(2, both)));
    for (_, mesh) in &mut all {
        let stiff = Region { name: "stiff".into(), ..mesh.regions[0].clone() };
        mesh.regions.push(stiff);
        mesh.element_region = (0..mesh.element_count()).map(|e| u32::from(e % 4 == 1)).collect();
    }
    all.extend(meshes().map(|mesh| ("tetrahedra".into(), mesh)));
    all
}

fn held_model(mesh: Mesh) -> Model {
    let held = hold(&mesh, |[x, _, _]| x == 0.0);
    model(mesh, &held)
}

fn free_model(mesh: Mesh) -> Model {
    let free = vec![false; 3 * mesh.nodes.len()];
    model(mesh, &free)
}

fn model(mesh: Mesh, held: &[bool]) -> Model {
    let materials = &[SOFT, STIFF][..mesh.regions.len()];
    Model::assemble(mesh, materials, held).expect("a model")
}

fn random(n: usize, size: f64, seed: u64) -> Vec<f64> {
    let mut random = Random::new(seed);
    (0..n).map(|_| size * (2.0 * random.uniform() - 1.0)).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn largest(a: &[f64]) -> f64 {
    a.iter().map(|x| x.abs()).fold(0.0, f64::max)
}

fn off(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn along(u: &[f64], t: f64, d: &[f64]) -> Vec<f64> {
    u.iter().zip(d).map(|(u, d)| u + t * d).collect()
}

fn times(matrix: &SymmetricMatrix, x: &[f64]) -> Vec<f64> {
    let mut y = faer::Mat::zeros(x.len(), 1);
    matrix.mul_into(faer::MatRef::from_column_major_slice(x, x.len(), 1), y.as_mut());
    y.col_as_slice(0).to_vec()
}

/// `∂²V/∂u²`: the derivative of the force. It is not positive definite where the body buckles.
fn tangent(green: &GreenStrain<'_>, u: &[f64]) -> SymmetricMatrix {
    let mut z = vec![0.0; green.n_rows()];
    green.strain(u, &mut z);
    green.weighted_tangent(u, 1.0, &z, false)
}

#[test]
fn energy_force_tangent_and_strain_are_derivatives_of_each_other() {
    for (name, mesh) in bodies() {
        let model = held_model(mesh);
        let green = GreenStrain::new(&model).expect("a strain field");
        let (n, rows) = (green.n_dof(), green.n_rows());
        let (u, d) = (random(n, 0.2, 1), random(n, 1.0, 2));
        let mut z = vec![0.0; rows];
        green.strain(&u, &mut z);
        assert!((0.5 * dot(&z, &z) / green.energy(&u) - 1.0).abs() < 1e-14, "{name}");
        let mut f = vec![0.0; n];
        green.force(&u, &mut f);
        // V is a polynomial of degree 4 along d: the five-point difference is exact, up to rounding.
        let at = |t: f64| green.energy(&along(&u, t, &d));
        let t = 0.1;
        let slope = (8.0 * (at(t) - at(-t)) - (at(2.0 * t) - at(-2.0 * t))) / (12.0 * t);
        assert!((slope - dot(&f, &d)).abs() < 1e-12 * at(2.0 * t) / t, "{name} {slope} {}", dot(&f, &d));
        // The force is cubic along d.
        let force = |t: f64| {
            let mut f = vec![0.0; n];
            green.force(&along(&u, t, &d), &mut f);
            f
        };
        let turned = times(&tangent(&green, &u), &d);
        let exact: Vec<f64> = {
            let (f1, m1, f2, m2) = (force(t), force(-t), force(2.0 * t), force(-2.0 * t));
            (0..n).map(|i| (8.0 * (f1[i] - m1[i]) - (f2[i] - m2[i])) / (12.0 * t)).collect()
        };
        assert!(off(&turned, &exact) < 1e-12 * largest(&force(2.0 * t)) / t, "{name}");
        // z is quadratic: z(u + d) = z(u) + G(u) d + E₂(d, d).
        let (mut whole, mut rate, mut square) = (vec![0.0; rows], vec![0.0; rows], vec![0.0; rows]);
        green.strain(&along(&u, 1.0, &d), &mut whole);
        green.rate(&u, &d, &mut rate);
        green.bilinear(&d, &d, &mut square);
        let sum: Vec<f64> = (0..rows).map(|i| z[i] + rate[i] + square[i]).collect();
        assert!(off(&whole, &sum) < 1e-13 * largest(&whole), "{name}");
        let (mut linear, mut mixed) = (vec![0.0; rows], vec![0.0; rows]);
        green.linear(&d, &mut linear);
        green.bilinear(&u, &d, &mut mixed);
        let sum = along(&linear, 2.0, &mixed);
        assert!(off(&rate, &sum) < 1e-13 * largest(&rate), "{name}");
        // Transposes.
        let y = random(rows, 1.0, 3);
        let mut back = vec![0.0; n];
        green.transpose(&u, &y, &mut back);
        assert!((dot(&back, &d) - dot(&y, &rate)).abs() < 1e-12 * largest(&rate) * rows as f64, "{name}");
        green.linear_transpose(&y, &mut back);
        assert!((dot(&back, &d) - dot(&y, &linear)).abs() < 1e-12 * largest(&linear) * rows as f64, "{name}");
        green.transpose(&u, &z, &mut back);
        assert!(off(&back, &f) < 1e-13 * largest(&f), "{name}");
    }
}

#[test]
fn at_rest_the_tangent_is_the_stiffness_of_the_pencil() {
    for (name, mesh) in bodies() {
        let model = held_model(mesh);
        let green = GreenStrain::new(&model).expect("a strain field");
        let stiffness = model.pencil().stiffness();
        let at_rest = tangent(&green, &vec![0.0; green.n_dof()]);
        let scale = largest(stiffness.values());
        let apart = off(at_rest.values(), stiffness.values());
        assert!(apart < 1e-13 * scale, "{name} {:e}", apart / scale);
        // Without stress nothing is left out.
        let none = vec![0.0; green.n_rows()];
        let pulled = green.weighted_tangent(&vec![0.0; green.n_dof()], 1.0, &none, true);
        assert_eq!(pulled.values(), at_rest.values());
    }
}

/// A rotation by a large angle about no axis of the mesh.
fn rotation() -> [[f64; 3]; 3] {
    let (axis, angle) = ([2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0], 2.2_f64);
    let (s, c) = angle.sin_cos();
    let skew = [[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]];
    std::array::from_fn(|i| {
        std::array::from_fn(|j| (1.0 - c) * axis[i] * axis[j] + s * skew[i][j] + if i == j { c } else { 0.0 })
    })
}

/// The displacement that turns a deformed body.
fn turned(mesh: &Mesh, u: &[f64]) -> Vec<f64> {
    let r = rotation();
    let places = mesh.nodes.iter().zip(u.as_chunks::<3>().0);
    let moved = places.flat_map(|(x, u)| {
        let y: [f64; 3] = std::array::from_fn(|i| x[i] + u[i]);
        std::array::from_fn::<f64, 3, _>(|i| (0..3).map(|j| r[i][j] * y[j]).sum::<f64>() + 0.7 - x[i])
    });
    moved.collect()
}

#[test]
fn a_rotation_has_no_strain_and_changes_no_energy() {
    for (name, mesh) in bodies() {
        let model = free_model(mesh);
        let green = GreenStrain::new(&model).expect("a strain field");
        let n = green.n_dof();
        let (mut z, mut y) = (vec![0.0; green.n_rows()], vec![0.0; green.n_rows()]);
        green.strain(&turned(model.mesh(), &vec![0.0; n]), &mut z);
        green.linear(&turned(model.mesh(), &vec![0.0; n]), &mut y);
        assert!(largest(&z) < 1e-14 * largest(&y), "{name} {} {}", largest(&z), largest(&y));
        let u = random(n, 0.1, 5);
        let rotated = turned(model.mesh(), &u);
        green.strain(&u, &mut z);
        green.strain(&rotated, &mut y);
        assert!(off(&z, &y) < 1e-13 * largest(&z), "{name}");
        let [before, after] = [&u, &rotated].map(|u| green.energy(u));
        assert!((after / before - 1.0).abs() < 1e-13, "{name}");
        // The force turns with the body.
        let (mut f, mut g) = (vec![0.0; n], vec![0.0; n]);
        green.force(&u, &mut f);
        green.force(&rotated, &mut g);
        let r = rotation();
        let expected: Vec<f64> =
            f.as_chunks::<3>().0.iter().flat_map(|f| r.map(|row| dot(&row, f))).collect();
        assert!(off(&g, &expected) < 1e-12 * largest(&f), "{name}");
    }
}

#[test]
fn a_uniform_stretch_and_shear_is_what_a_hand_finds() {
    let gradient = [[0.3, -0.2, 0.5], [0.1, 0.4, -0.7], [0.2, 0.6, -0.1]];
    // The map of the curved mesh shifts columns, so its volume is 1 as well.
    let tetrahedra = meshes().map(|mesh| ("tetrahedra".into(), 1.0, mesh));
    let cubes = cubes().into_iter().map(|(name, mesh)| (name, 8.0, mesh));
    for (name, volume, mut mesh) in cubes.chain(tetrahedra) {
        mesh.element_region.fill(0);
        let model = free_model(mesh);
        let green = GreenStrain::new(&model).expect("a strain field");
        let u: Vec<f64> = model.mesh().nodes.iter().flat_map(|x| gradient.map(|row| dot(&row, x))).collect();
        let strain = |i: usize, j: usize| {
            0.5 * (gradient[i][j]
                + gradient[j][i]
                + (0..3).map(|k| gradient[k][i] * gradient[k][j]).sum::<f64>())
        };
        let (lambda, mu) = SOFT.lame().expect("an isotropic material");
        let trace = (0..3).map(|i| strain(i, i)).sum::<f64>();
        let square: f64 = (0..9).map(|k| strain(k / 3, k % 3).powi(2)).sum();
        let exact = volume * (0.5 * lambda * trace * trace + mu * square);
        assert!((green.energy(&u) / exact - 1.0).abs() < 1e-13, "{name} {} {exact}", green.energy(&u));
        // No force on a node inside; the patch test.
        let mut f = vec![0.0; green.n_dof()];
        green.force(&u, &mut f);
        let sums: [f64; 3] = std::array::from_fn(|c| f.iter().skip(c).step_by(3).sum());
        assert!(largest(&sums) < 1e-13 * largest(&f) * 100.0);
    }
}

#[test]
fn a_uniform_gradient_leaves_no_force_inside() {
    let base = block([2, 2, 2], [1.0, 1.0, 1.0]);
    // Inner nodes anywhere.
    let inside = |x: [f64; 3], size: f64| x.iter().all(|&c| c > 0.0 && c < size);
    let linear = moved(base, |x| if inside(x, 1.0) { [x[0] + 0.1, x[1] - 0.07, x[2] + 0.05] } else { x });
    let tetrahedra = [linear.clone(), quadratic(&linear)].map(|mesh| ("tetrahedra".into(), 1.0, mesh));
    let cubes = cubes().into_iter().map(|(name, mesh)| (name, 2.0, mesh));
    for (name, size, mesh) in cubes.chain(tetrahedra) {
        let held = vec![false; 3 * mesh.nodes.len()];
        let model = Model::assemble(mesh, &[SOFT], &held).expect("a model");
        let green = GreenStrain::new(&model).expect("a strain field");
        let gradient = [[0.3, -0.2, 0.5], [0.1, 0.4, -0.7], [0.2, 0.6, -0.1]];
        let u: Vec<f64> = model.mesh().nodes.iter().flat_map(|x| gradient.map(|row| dot(&row, x))).collect();
        let mut f = vec![0.0; green.n_dof()];
        green.force(&u, &mut f);
        let mut inner = 0;
        for (x, force) in model.mesh().nodes.iter().zip(f.as_chunks::<3>().0) {
            if inside(*x, size) {
                inner += 1;
                assert!(largest(force) < 1e-13 * largest(&f), "{name}");
            }
        }
        assert!(inner > 0);
    }
}

#[test]
fn straight_quadratic_elements_are_integrated_exactly() {
    // Degree 6 against the rule of degree 5, on an energy of degree 4.
    let mesh =
        quadratic(&moved(block([1, 1, 1], [1.0, 1.0, 1.0]), |[x, y, z]| [x + 0.2 * y, y, z + 0.1 * x]));
    let model = Model::assemble(mesh.clone(), &[SOFT], &vec![false; 3 * mesh.nodes.len()]).expect("a model");
    let green = GreenStrain::new(&model).expect("a strain field");
    assert_eq!(green.n_rows(), 6 * 14 * mesh.element_count());
    let u = random(green.n_dof(), 0.3, 9);
    let (lambda, mu) = SOFT.lame().expect("an isotropic material");
    let mut energy = 0.0;
    assert!(
        ElementKernel::tetrahedra(mesh.order())
            .is_straight(&super::assembly::element_nodes::<TET_NODES>(&mesh, 0))
    );
    for e in 0..mesh.element_count() {
        let nodes: [[f64; 3]; TET_NODES] = super::assembly::element_nodes(&mesh, e as u32);
        for (l, weight) in rule_degree_6() {
            let point = tabulate_point(mesh.order(), l, weight);
            let (inverse, determinant) = jacobian(10, &point, &nodes).expect("no fold");
            let mut h = [[0.0; 3]; 3];
            for (a, &node) in mesh.element(e).iter().enumerate() {
                for i in 0..3 {
                    for j in 0..3 {
                        let slope: f64 = (0..3).map(|r| point.gradients[a][r] * inverse[r][j]).sum();
                        h[i][j] += u[3 * node as usize + i] * slope;
                    }
                }
            }
            let strain = |i: usize, j: usize| {
                0.5 * (h[i][j] + h[j][i] + (0..3).map(|k| h[k][i] * h[k][j]).sum::<f64>())
            };
            let trace = (0..3).map(|i| strain(i, i)).sum::<f64>();
            let square: f64 = (0..9).map(|k| strain(k / 3, k % 3).powi(2)).sum();
            energy += weight * determinant * (0.5 * lambda * trace * trace + mu * square);
        }
    }
    assert!((green.energy(&u) / energy - 1.0).abs() < 1e-13, "{} {energy}", green.energy(&u));
}

#[test]
fn tension_alone_keeps_the_matrix_positive() {
    let [_, mesh, _] = meshes();
    let model = held_model(mesh);
    let green = GreenStrain::new(&model).expect("a strain field");
    // Compressed to half its length: far past buckling.
    let dofs = model.dofs();
    let u: Vec<f64> = dofs
        .dof_of_free()
        .iter()
        .map(|&dof| if dof % 3 == 0 { -0.5 * model.mesh().nodes[dof as usize / 3][0] } else { 0.0 })
        .collect();
    let mut z = vec![0.0; green.n_rows()];
    green.strain(&u, &mut z);
    let symbolic = super::Symbolic::analyze(model.pencil()).expect("a structure");
    assert!(symbolic.factorize(tangent(&green, &u)).is_err());
    assert!(symbolic.factorize(green.weighted_tangent(&u, 1.0, &z, true)).is_ok());
    // Drawn out instead, the body cannot buckle.
    let drawn: Vec<f64> = u.iter().map(|u| -u).collect();
    assert!(symbolic.factorize(tangent(&green, &drawn)).is_ok());
}

/// A displacement.
type Field = fn([f64; 3]) -> [f64; 3];

/// Eigenvalues of a block of 20-node hexahedra that is held at one end, ascending, in a displacement.
fn squares(named: Hexahedra, u: Field) -> Vec<f64> {
    let mut mesh = cells([3, 2, 2], |x| x, |_| vec![(ElementKind::Hex20, (0..8).collect())]);
    mesh.regions[0].hexahedra = Some(named);
    let model = held_model(mesh);
    let green = GreenStrain::new(&model).expect("a strain field");
    let of = |&dof: &u32| u(model.mesh().nodes[dof as usize / 3])[dof as usize % 3];
    let u: Vec<f64> = model.dofs().dof_of_free().iter().map(of).collect();
    let dense = |matrix: &SymmetricMatrix| {
        faer::Mat::from_fn(matrix.n(), matrix.n(), |i, j| matrix.get(i, j).unwrap_or(0.0))
    };
    let mass = dense(model.pencil().mass()).llt(faer::Side::Lower).expect("a mass");
    // L⁻¹ K L⁻ᵀ.
    let mut turned = dense(&tangent(&green, &u));
    for _ in 0..2 {
        faer::linalg::triangular_solve::solve_lower_triangular_in_place(
            mass.L(),
            turned.as_mut(),
            faer::Par::Seq,
        );
        turned = turned.transpose().to_owned();
    }
    turned.self_adjoint_eigenvalues(faer::Side::Lower).expect("eigenvalues")
}

/// One 20-node hexahedron with eight points has six motions that they do not see. Its neighbours stop them at
/// rest, and where the body is bent, pressed or drawn: no low frequency is one of them. (A row of single
/// hexahedra keeps some, and is refused with its linear stiffness. Beyond fibres pressed by a fifth, eight
/// points are softer.)
#[test]
fn reduced_integration_leaves_no_soft_motion() {
    let fields: [(&str, Field); 4] = [
        ("rest", |_| [0.0; 3]),
        ("bent", |[x, y, _]| {
            let (radius, height) = (10.0, y - 1.0);
            let (sine, cosine) = (x / radius).sin_cos();
            [(radius - height) * sine - x, radius - (radius - height) * cosine - height, 0.0]
        }),
        ("pressed", |[x, y, z]| [-0.1 * x, 0.03 * y, 0.03 * z]),
        ("drawn", |[x, y, z]| [0.2 * x, -0.05 * y, -0.05 * z]),
    ];
    for (name, field) in fields {
        let [full, few] = [Hexahedra::Full, Hexahedra::Reduced].map(|named| squares(named, field));
        for (a, b) in full.iter().zip(&few).take(8) {
            assert!((b / a - 1.0).abs() < 0.1, "{name}: {a} {b}");
        }
    }
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let mesh = quadratic(&block([6, 4, 4], [3.0, 1.0, 1.0]));
    let held = hold(&mesh, |[x, _, _]| x == 0.0);
    let model = Model::assemble(mesh, &[SOFT], &held).expect("a model");
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let green = GreenStrain::new(&model).expect("a strain field");
            let u = random(green.n_dof(), 0.1, 4);
            let (mut z, mut f) = (vec![0.0; green.n_rows()], vec![0.0; green.n_dof()]);
            green.strain(&u, &mut z);
            green.force(&u, &mut f);
            (green.energy(&u).to_bits(), z, f, tangent(&green, &u).values().to_vec())
        })
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn a_formulation_that_is_more_than_a_sum_over_points_is_refused_by_name() {
    for (named, part) in [
        (None, "incompatible modes"),
        (Some(Hexahedra::Incompatible), "incompatible modes"),
        (Some(Hexahedra::Reduced), "hourglass"),
        (Some(Hexahedra::ReducedMass), "hourglass"),
    ] {
        let mut mesh = cube(2, mixed(Order::Linear));
        mesh.regions[0].hexahedra = named;
        let model = held_model(mesh);
        let refused = GreenStrain::new(&model).err().expect("a refusal").to_string();
        let parts = [part, "region `body`", "hexahedra = \"full\"", "quadratic elements"];
        assert!(parts.iter().all(|part| refused.contains(part)), "{refused}");
    }
}

#[test]
fn two_matrices_have_no_strain() {
    let mesh = block([1, 1, 1], [1.0; 3]);
    let bare = Mesh { elements: vec![], element_region: vec![], regions: vec![], ..mesh.clone() };
    let held = hold(&mesh, |[x, _, _]| x == 0.0);
    let n = held.iter().filter(|held| !**held).count();
    let ones: Vec<(u32, u32, f64)> = (0..n as u32).map(|i| (i, i, 1.0)).collect();
    let pencil = Pencil::from_triplets(n, &ones, &ones).expect("a pencil");
    let model = Model::from_matrices(bare, &held, pencil).expect("a model");
    assert_eq!(GreenStrain::new(&model).err(), Some(GreenError::NoElements));
}
