//! Bodies without supports to which masses, couplings and springs are attached.

use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Mat, Par, Side};

use super::coupling::{mean_rows, rigid_row};
use super::test_mesh::hold;
use super::{
    Attachments, Block, DampingBlock, Material, Model, ModelError, RigidBody, Solve, Symbolic,
    SymmetricMatrix,
};
use crate::dynamics::lowest_modes;
use crate::linalg::vec3::sub;
use crate::mesh::{self, Mesh, Order};

const RUBBER: Material = Material::isotropic(1e7, 0.3, 1000.0);

/// Edges of the block \[m\]; it weighs 8 kg.
const EDGES: [f64; 3] = [0.4, 0.2, 0.1];

/// A mass at a corner, and one with moments of inertia outside of the body on a point that an end follows.
const CORNER: [f64; 3] = [0.0, 0.2, 0.1];
const MOTOR: [f64; 3] = [0.55, 0.12, -0.03];
/// On a point that follows the mean of the other end.
const HUNG: [f64; 3] = [-0.1, 0.05, 0.2];
const MASSES: [f64; 3] = [0.5, 1.5, 0.25];
const INERTIA: [[f64; 3]; 3] = [[0.010, 0.002, -0.001], [0.002, 0.020, 0.003], [-0.001, 0.003, 0.015]];

fn brick() -> Mesh {
    mesh::block(EDGES, [4, 2, 1], Order::Linear)
}

fn nodes_at(mesh: &Mesh, x: f64) -> Vec<u32> {
    (0..).zip(&mesh.nodes).filter(|(_, at)| (at[0] - x).abs() < 1e-12).map(|(node, _)| node).collect()
}

fn dof(mesh: &Mesh, point: usize, motion: usize) -> u32 {
    (3 * mesh.nodes.len() + 6 * point + motion) as u32
}

fn follow(mesh: &Mesh, node: u32, c: usize, (point, at): (usize, [f64; 3])) -> Vec<(u32, f64)> {
    let row = rigid_row(sub(mesh.nodes[node as usize], at), c);
    let of_point = (0..6).map(|k| (dof(mesh, point, k), -row[k])).filter(|term| term.1 != 0.0);
    std::iter::once((3 * node + c as u32, 1.0)).chain(of_point).collect()
}

fn mass(mesh: &Mesh, point: usize, mass: f64, inertia: [[f64; 3]; 3]) -> Block {
    let of = |i: usize, j: usize| match (i < 3, j < 3) {
        (true, true) if i == j => mass,
        (false, false) => inertia[i - 3][j - 3],
        _ => 0.0,
    };
    let dofs = (0..6).map(|motion| dof(mesh, point, motion)).collect();
    Block { dofs, stiffness: Mat::zeros(6, 6), mass: Mat::from_fn(6, 6, of) }
}

fn attached(mesh: &Mesh) -> Attachments {
    let mut found = Attachments { points: vec![CORNER, MOTOR, HUNG], ..Attachments::default() };
    let corner = mesh.nodes.iter().position(|x| sub(*x, CORNER).iter().all(|d| d.abs() < 1e-12)).unwrap();
    (0..3).for_each(|c| found.constraints.equate(follow(mesh, corner as u32, c, (0, CORNER)), "corner"));
    (3..6).for_each(|motion| found.constraints.hold(dof(mesh, 0, motion), 0.0));
    for node in nodes_at(mesh, EDGES[0]) {
        (0..3).for_each(|c| found.constraints.equate(follow(mesh, node, c, (1, MOTOR)), "motor"));
    }
    let end = nodes_at(mesh, 0.0);
    let cloud: Vec<_> = end.iter().map(|&node| (mesh.nodes[node as usize], 1.0)).collect();
    let rows = mean_rows(HUNG, &cloud);
    for motion in 0..6 {
        let of_nodes = end
            .iter()
            .zip(&rows)
            .flat_map(|(&node, row)| (0..3_u32).map(move |k| (3 * node + k, -row[motion][k as usize])));
        let terms = std::iter::once((dof(mesh, 2, motion), 1.0)).chain(of_nodes);
        found.constraints.equate(terms.filter(|term| term.1 != 0.0).collect(), "hung");
    }
    let none = [[0.0; 3]; 3];
    let [corner, motor, hung] = MASSES;
    let mut at_corner = mass(mesh, 0, corner, none);
    at_corner.dofs.truncate(3);
    at_corner.stiffness = Mat::zeros(3, 3);
    at_corner.mass = at_corner.mass.submatrix(0, 0, 3, 3).to_owned();
    found.blocks = vec![at_corner, mass(mesh, 1, motor, INERTIA), mass(mesh, 2, hung, none)];
    found
}

fn model(attachments: Attachments) -> Result<Model, ModelError> {
    let mesh = brick();
    let free = vec![false; 3 * mesh.nodes.len()];
    Model::assemble_attached(mesh, &[RUBBER], &free, attachments)
}

fn rigid(model: &Model) -> &RigidBody {
    model.pencil().rigid().expect("a free body")
}

/// A stiffness over displacements of two points \[N/m\].
fn between(mesh: &Mesh, ends: &[usize], stiffness: f64) -> Block {
    let dofs: Vec<u32> = ends.iter().map(|&point| dof(mesh, point, 0)).collect();
    let n = dofs.len();
    let of = |i: usize, j: usize| if i == j { stiffness } else { -stiffness };
    Block { dofs, stiffness: Mat::from_fn(n, n, of), mass: Mat::zeros(n, n) }
}

#[test]
fn mass_centre_and_moments_are_those_of_the_block_with_its_masses() {
    let model = model(attached(&brick())).unwrap();
    let rigid = rigid(&model);
    let block = 1000.0 * EDGES.iter().product::<f64>();
    let bodies =
        [(block, EDGES.map(|l| 0.5 * l)), (MASSES[0], CORNER), (MASSES[1], MOTOR), (MASSES[2], HUNG)];
    let total: f64 = bodies.iter().map(|body| body.0).sum();
    assert!((rigid.mass / total - 1.0).abs() < 1e-12, "{} {total}", rigid.mass);
    let centre: [f64; 3] =
        std::array::from_fn(|c| bodies.iter().map(|(m, at)| m * at[c]).sum::<f64>() / total);
    for c in 0..3 {
        assert!((rigid.centre[c] - centre[c]).abs() < 1e-12, "{:?} {centre:?}", rigid.centre);
    }
    // Huygens and Steiner.
    let square = EDGES.map(|l| l * l);
    let moment = |i: usize, j: usize| {
        let own = if i == j { block / 12.0 * (square.iter().sum::<f64>() - square[i]) } else { 0.0 };
        let arms = bodies.iter().map(|&(m, at)| {
            let r = sub(at, centre);
            let whole: f64 = r.iter().map(|x| x * x).sum();
            m * (if i == j { whole } else { 0.0 } - r[i] * r[j])
        });
        own + INERTIA[i][j] + arms.sum::<f64>()
    };
    let places = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
    for (found, (i, j)) in rigid.inertia.iter().zip(places) {
        assert!((found - moment(i, j)).abs() < 1e-12, "{i} {j}: {found} {}", moment(i, j));
    }
}

#[test]
fn rigid_motions_with_attachments_cost_no_energy_and_turn_reference_points() {
    let mesh = brick();
    let model = model(attached(&mesh)).unwrap();
    let (pencil, rigid) = (model.pencil(), rigid(&model));
    let mut forces = Mat::zeros(pencil.n_dof(), 6);
    pencil.stiffness().mul_into(rigid.motions(), forces.as_mut());
    let largest = (0..pencil.n_dof()).map(|i| pencil.stiffness().diagonal(i)).fold(0.0, f64::max);
    let share = forces.norm_max() / (largest * rigid.motions().norm_max());
    assert!(share < 1e-13, "{share:e}");
    let product = rigid.motions().transpose() * rigid.momenta();
    assert!((product - Mat::<f64>::identity(6, 6)).norm_max() < 1e-12);
    // The point that an end follows is free itself, and turns with the body.
    let place = model.dofs().free(dof(&mesh, 1, 5) as usize).expect("a free rotation") as usize;
    let turned: f64 = (0..6).map(|k| rigid.motions()[(place, k)].powi(2)).sum();
    assert!(turned > 1.0, "{turned}");
}

fn dense(a: &SymmetricMatrix) -> Mat<f64> {
    let mut image = Mat::zeros(a.n(), a.n());
    a.mul_into(Mat::<f64>::identity(a.n(), a.n()).as_ref(), image.as_mut());
    image
}

#[test]
fn modes_and_static_answers_are_those_of_the_whole_pencil() {
    let mesh = brick();
    let model = model(attached(&mesh)).unwrap();
    let (pencil, rigid) = (model.pencil(), rigid(&model));
    let n = pencil.n_dof();
    let lower = dense(pencil.mass()).llt(Side::Lower).expect("every free dof has mass");
    let mut reduced = dense(pencil.stiffness());
    solve_lower_triangular_in_place(lower.L(), reduced.as_mut(), Par::Seq);
    solve_lower_triangular_in_place(lower.L(), reduced.as_mut().transpose_mut(), Par::Seq);
    let whole = reduced.self_adjoint_eigen(Side::Lower).unwrap();
    let mut vectors = whole.U().to_owned();
    solve_upper_triangular_in_place(lower.L().transpose(), vectors.as_mut(), Par::Seq);
    assert!(whole.S()[5].abs() < 1e-8 * whole.S()[6], "{} {}", whole.S()[5], whole.S()[6]);

    let symbolic = Symbolic::analyze(pencil).unwrap();
    for count in [8, n - 6] {
        let modes = lowest_modes(pencil, &symbolic, count).unwrap();
        for (k, found) in modes.eigenvalues.iter().enumerate() {
            let expected = whole.S()[6 + k];
            assert!((found / expected - 1.0).abs() < 1e-8, "{count} {k}: {found} {expected}");
        }
        let drift = rigid.momenta().transpose() * &modes.vectors;
        assert!(drift.norm_max() < 1e-9, "{:e}", drift.norm_max());
    }

    // Two forces along the line between two nodes: in equilibrium.
    let ends = [[0.1, 0.0, 0.1], [0.3, 0.2, 0.0]];
    let line = sub(ends[1], ends[0]);
    let mut force = Mat::zeros(n, 1);
    for (end, sign) in ends.into_iter().zip([-1.0, 1.0]) {
        let node = mesh.nodes.iter().position(|x| sub(*x, end).iter().all(|d| d.abs() < 1e-12)).unwrap();
        (0..3).for_each(|c| model.add_force(3 * node + c, sign * line[c], force.col_as_slice_mut(0)));
    }
    let resultant = rigid.resultant(&mesh.nodes, force.col_as_slice(0));
    assert!(resultant.iter().all(|x| x.abs() < 1e-14), "{resultant:?}");
    let share = vectors.transpose() * &force;
    let of_mode = Mat::from_fn(n, 1, |k, _| if k < 6 { 0.0 } else { share[(k, 0)] / whole.S()[k] });
    let expected = &vectors * of_mode;
    let factor = symbolic.factor_of(pencil.stiffness()).unwrap();
    Solve::new(&symbolic, 1, false).solve_in_place(&factor, force.as_mut());
    let off = (&force - &expected).norm_max() / expected.norm_max();
    assert!(off < 1e-9, "{off:e}");
}

#[test]
fn what_resists_some_rigid_motions_is_refused_with_those_that_are_left() {
    let mesh = brick();
    let with = |change: &dyn Fn(&mut Attachments)| {
        let mut attachments = attached(&mesh);
        change(&mut attachments);
        model(attachments)
    };
    // A spring to the ground along x, at a point whose turns move it.
    let grounded = with(&|all| all.blocks.push(between(&mesh, &[1], 1e4))).unwrap_err();
    let ModelError::PartlyHeld { n_modes, named, holder } = &grounded else { panic!("{grounded}") };
    assert_eq!((*n_modes, named.as_str()), (5, "shift along y, shift along z, turn about x"), "{holder}");
    assert!(grounded.to_string().starts_with("a spring or a foundation resists"), "{grounded}");
    // One along x across an arm in y and z.
    let across = with(&|all| all.blocks.push(between(&mesh, &[0, 2], 1e4))).unwrap_err();
    assert!(matches!(across, ModelError::PartlyHeld { n_modes: 5, .. }), "{across}");
    // An equation that no turn about z fulfils, in the words of its origin.
    let pair = vec![(0, 1.0), (3 * (mesh.nodes.len() as u32 - 1), -1.0)];
    let bent = with(&|all| all.constraints.equate(pair.clone(), "the equation 7")).unwrap_err();
    let ModelError::PartlyHeld { n_modes: 5, holder, .. } = &bent else { panic!("{bent}") };
    assert_eq!(holder, "the equation 7");
    // A point that nothing joins, and one on a ball joint of one node.
    let loose = with(&|all| {
        all.points.push([1.0; 3]);
        all.blocks.push(mass(&mesh, 3, 1.0, INERTIA));
    });
    assert_eq!(loose.unwrap_err(), ModelError::Mechanism { more: 6 });
    let ball = with(&|all| {
        all.points.push(mesh.nodes[0]);
        (0..3).for_each(|c| all.constraints.equate(follow(&mesh, 0, c, (3, mesh.nodes[0])), "ball"));
        all.blocks.push(mass(&mesh, 3, 1.0, INERTIA));
    });
    assert_eq!(ball.unwrap_err(), ModelError::Mechanism { more: 3 });
    // A dashpot to the ground.
    let Block { dofs, stiffness: damping, .. } = between(&mesh, &[1], 3.0);
    let damped = with(&|all| {
        all.dashpots.push(DampingBlock { dofs: dofs.clone(), damping: damping.clone(), group: 0 });
    });
    assert_eq!(damped.unwrap_err(), ModelError::DampedFlight);
    // Six springs to the ground hold it as supports do.
    let held = with(&|all| {
        let dofs: Vec<u32> = (0..6).map(|motion| dof(&mesh, 1, motion)).collect();
        let stiffness = Mat::from_fn(6, 6, |i, j| if i == j { 1e3 } else { 0.0 });
        all.blocks.push(Block { dofs, stiffness, mass: Mat::zeros(6, 6) });
    });
    assert!(held.unwrap().pencil().rigid().is_none());
}

#[test]
fn supports_beside_attachments_that_leave_a_hinge_are_refused_by_name() {
    let mesh = brick();
    let hinge = hold(&mesh, |p| p[0] == 0.0 && p[1] == 0.0);
    let attachments = Attachments { points: vec![], ..attached(&mesh) };
    let bare = Attachments { blocks: vec![], constraints: super::Constraints::default(), ..attachments };
    let refused = Model::assemble_attached(mesh, &[RUBBER], &hinge, bare).unwrap_err();
    let ModelError::PartlyHeld { n_modes: 1, holder, .. } = &refused else { panic!("{refused}") };
    assert_eq!(holder, "a support or a held reference point");
}
