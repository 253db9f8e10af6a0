//! Superelements against the full order: rigid motions, static answers, modes, bodies that are joined.

use std::path::PathBuf;

use faer::Mat;

use super::{Method, Request, Superelement, SuperelementError, reduce};
use crate::dynamics::lowest_modes;
use crate::fem::Symbolic;
use crate::input::{InterfaceEntry, Problem};
use crate::limits::Memory;
use crate::linalg::{solve_dense, symmetric_eigen};
use crate::prepared::{Prepared, interfaces, prepare};
use crate::progress::{Silent, Stopwatch};

const METHODS: [Method; 4] = Method::ALL;

fn request(method: Method, modes: usize) -> Request {
    Request { method, modes, memory: Memory::asked_or_available(None) }
}

/// A beam of steel of so many cells, with more keys.
fn beam(length: f64, cells: usize, keys: &str) -> Problem {
    let text = format!(
        "[mesh]\nblock = {{ lengths = [{length}, 0.1, 0.08], divisions = [{cells}, 2, 1], order = \"linear\" }}\n\
         [[material]]\nyoung = 2e11\npoisson = 0.3\ndensity = 7800.0\n[time]\nstep = 1e-4\n{keys}"
    );
    Problem::parse(&text, "beam.toml", PathBuf::new()).unwrap()
}

fn prepared(problem: &Problem) -> Prepared {
    prepare(problem, &mut Stopwatch::new(&Silent), &Silent).unwrap()
}

fn reduced(
    problem: &Problem,
    names: &[&str],
    method: Method,
    modes: usize,
) -> Result<Superelement, SuperelementError> {
    let body = prepared(problem);
    let entries: Vec<_> = names.iter().map(|name| InterfaceEntry::parse(name).unwrap()).collect();
    let found = interfaces(problem, &body.body, &entries).unwrap();
    reduce(problem, &body, found, request(method, modes), &Silent)
}

const LEFT: &str = "left={ kind = \"rigid\", on = { group = \"x_min\" } }";
const RIGHT: &str = "right={ kind = \"average\", on = { group = \"x_max\" }, at = [1.1, 0.0, 0.0], \
    axes = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] }";
const POINTS: &str =
    "points={ kind = \"nodes\", on = { box = { min = [0.49, -1.0, -1.0], max = [0.51, 1.0, 1.0] } } }";

/// Sides of each kind.
const SIDES: [[&str; 2]; 3] = [[LEFT, RIGHT], ["x_min", "x_max=average"], [POINTS, "x_max"]];

fn size(matrix: &Mat<f64>) -> f64 {
    matrix.norm_max()
}

/// Eigenvalues of `K φ = λ M φ`, ascending.
fn eigenvalues(mass: &Mat<f64>, stiffness: &Mat<f64>) -> Vec<f64> {
    let (values, axes) = symmetric_eigen(mass.as_ref()).unwrap();
    let unit = Mat::from_fn(values.len(), values.len(), |i, k| axes[(i, k)] / values[k].sqrt());
    symmetric_eigen((unit.transpose() * stiffness * &unit).as_ref()).unwrap().0
}

fn dense(matrix: &crate::fem::SymmetricMatrix) -> Mat<f64> {
    Mat::from_fn(matrix.n(), matrix.n(), |i, j| matrix.get(i, j).unwrap_or(0.0))
}

#[test]
fn rigid_motions_cost_nothing_and_have_the_mass_of_the_body() {
    let problem = beam(1.0, 8, "");
    let body = prepared(&problem);
    let rigid = body.body.model.pencil().rigid().unwrap().clone();
    for sides in SIDES {
        for method in METHODS {
            let found = reduced(&problem, &sides, method, 5).unwrap();
            let motions = found.rigid_motions.as_ref().unwrap();
            let work = &found.stiffness * motions;
            // Entries of K are rounded to ε of the largest, and sums have fewer than a hundred terms.
            let share = size(&work) / (size(&found.stiffness) * size(motions));
            assert!(share < 1e-11, "{method:?} {sides:?}: {share:e}");
            // T moves every node as the rigid motion does.
            let moved = &found.transformation * motions;
            let nodes = &body.body.model.mesh().nodes;
            for (node, at) in nodes.iter().enumerate() {
                for c in 0..3 {
                    let expected = crate::fem::rigid_row(*at, c);
                    for k in 0..6 {
                        let off = (moved[(3 * node + c, k)] - expected[k]).abs();
                        assert!(off < 1e-9, "{method:?} {sides:?}: {off:e}");
                    }
                }
            }
            if method == Method::Macneal {
                continue;
            }
            let inertia = motions.transpose() * &found.mass * motions;
            let [x, y, _] = rigid.centre;
            for (i, k, expected) in
                [(0, 0, rigid.mass), (2, 2, rigid.mass), (2, 4, -rigid.mass * x), (2, 3, rigid.mass * y)]
            {
                let off = (inertia[(i, k)] - expected).abs() / rigid.mass;
                assert!(off < 1e-10, "{method:?} {sides:?} {i} {k}: {off:e}");
            }
        }
    }
}

/// The body held at its left patch, over its free dofs, and the place of each dof of the mesh there.
fn held_left(problem: &Problem) -> Prepared {
    let text = format!("{}[[support]]\non = {{ group = \"x_min\" }}\n", problem.text);
    prepared(&Problem::parse(&text, "beam.toml", PathBuf::new()).unwrap())
}

#[test]
fn static_answers_to_forces_at_the_interface_are_exact() {
    let problem = beam(1.0, 6, "");
    let held = held_left(&problem);
    let (model, pencil) = (&held.body.model, held.body.model.pencil());
    for method in METHODS {
        let found = reduced(&problem, &["x_min", "x_max"], method, 4).unwrap();
        let m = found.coordinates;
        let left = found.interfaces[0].coordinates.len();
        let r = found.stiffness.nrows();
        // A force at the first coordinates of the right side, with the left one at rest.
        let open: Vec<usize> = (left..r).collect();
        let stiffness = Mat::from_fn(open.len(), open.len(), |i, k| found.stiffness[(open[i], open[k])]);
        let loads = Mat::from_fn(open.len(), 4, |i, k| f64::from(u8::from(i == k)));
        let answer = solve_dense(stiffness.as_ref(), loads.as_ref());
        let mut full = Mat::zeros(pencil.n_dof(), 4);
        let right = &found.interfaces[1].coordinates;
        for k in 0..4 {
            let dof = 3 * right[k].node.unwrap() as usize + right[k].motion;
            full[(model.dofs().free(dof).unwrap() as usize, k)] = 1.0;
        }
        let symbolic = Symbolic::analyze(pencil).unwrap();
        let factor = symbolic.factor_of(pencil.stiffness()).unwrap();
        crate::fem::Solve::new(&symbolic, 4, true).solve_in_place(&factor, full.as_mut());
        for (place, coordinate) in right.iter().enumerate() {
            let dof = 3 * coordinate.node.unwrap() as usize + coordinate.motion;
            let free = model.dofs().free(dof).unwrap() as usize;
            for k in 0..4 {
                let off = (answer[(place, k)] - full[(free, k)]).abs() / size(&full);
                assert!(off < 1e-10, "{method:?}, coordinate {place} of {m}: {off:e}");
            }
        }
    }
}

#[test]
fn fixed_interface_modes_are_those_of_the_held_body() {
    let problem = beam(1.0, 8, "");
    let held = held_left(&problem);
    let pencil = held.body.model.pencil();
    let modes = lowest_modes(pencil, &Symbolic::analyze(pencil).unwrap(), 6).unwrap();
    for side in ["x_min", LEFT] {
        let found = reduced(&problem, &[side], Method::CraigBampton, 6).unwrap();
        for (a, b) in found.frequencies_hz.iter().zip(modes.frequencies_hz()) {
            // Both are off by the square of a residual of 5e-9 at most, and by the rounding of K.
            assert!((a / b - 1.0).abs() < 1e-10, "{side}: {a} for {b}");
        }
    }
}

#[test]
fn all_modes_are_the_full_order() {
    let problem = beam(0.3, 2, "");
    let body = prepared(&problem);
    let pencil = body.body.model.pencil();
    let full = eigenvalues(&dense(pencil.mass()), &dense(pencil.stiffness()));
    for sides in [["x_min"], [RIGHT]] {
        let entries = sides.map(|name| InterfaceEntry::parse(name).unwrap());
        let found = interfaces(&problem, &body.body, &entries).unwrap();
        let inside = pencil.n_dof() - found[0].coordinates.len();
        let all = reduce(&problem, &body, found, request(Method::CraigBampton, inside), &Silent).unwrap();
        assert_eq!(all.mass.nrows(), pencil.n_dof());
        let reduced = eigenvalues(&all.mass, &all.stiffness);
        for (a, b) in reduced.iter().zip(&full).skip(6) {
            assert!((a / b - 1.0).abs() < 1e-8, "{sides:?}: {a} for {b}");
        }
    }
}

#[test]
fn free_methods_have_the_natural_modes_of_the_body() {
    let problem = beam(1.0, 8, "");
    let body = prepared(&problem);
    let pencil = body.body.model.pencil();
    let modes = lowest_modes(pencil, &Symbolic::analyze(pencil).unwrap(), 6).unwrap();
    for (method, sides) in [
        (Method::Rubin, ["x_min", "x_max=average"]),
        (Method::Herting, ["x_min", "x_max=average"]),
        (Method::Rubin, ["x_min", "x_max"]),
    ] {
        let found = reduced(&problem, &sides, method, 6).unwrap();
        let reduced = eigenvalues(&found.mass, &found.stiffness);
        for (k, expected) in modes.eigenvalues.iter().enumerate() {
            let off = (reduced[6 + k] / expected - 1.0).abs();
            assert!(off < 1e-8, "{method:?} {sides:?}, mode {k}: {off:e}");
        }
    }
}

#[test]
fn an_averaging_frame_is_the_mean_motion_of_its_facets() {
    let problem = beam(0.5, 3, "");
    let body = prepared(&problem);
    let entries = [InterfaceEntry::parse(RIGHT).unwrap(), InterfaceEntry::parse("x_min=average").unwrap()];
    let found = interfaces(&problem, &body.body, &entries).unwrap();
    let rows: Vec<Vec<(u32, f64)>> = found
        .iter()
        .flat_map(|interface| match &interface.rows {
            crate::prepared::InterfaceRows::Means(rows) => rows.clone(),
            crate::prepared::InterfaceRows::Followers(_) => panic!("a mean"),
        })
        .collect();
    let all = reduce(&problem, &body, found, request(Method::CraigBampton, 3), &Silent).unwrap();
    let pencil = body.body.model.pencil();
    let (n, m) = (pencil.n_dof(), rows.len());
    // G T = [I 0]; all dofs of a free body are free.
    for (i, row) in rows.iter().enumerate() {
        for k in 0..all.transformation.ncols() {
            let value: f64 = row.iter().map(|&(free, w)| w * all.transformation[(free as usize, k)]).sum();
            assert!((value - f64::from(u8::from(i == k))).abs() < 1e-10, "row {i}, column {k}: {value}");
        }
    }
    // Constraint modes: least energy under G u = e_k, by Lagrange's multipliers.
    let scale = pencil.stiffness().diagonal(0);
    let mut system = Mat::zeros(n + m, n + m);
    for i in 0..n {
        for k in 0..n {
            system[(i, k)] = pencil.stiffness().get(i, k).unwrap_or(0.0) / scale;
        }
    }
    for (i, row) in rows.iter().enumerate() {
        for &(free, weight) in row {
            system[(n + i, free as usize)] = weight;
            system[(free as usize, n + i)] = weight;
        }
    }
    let right = Mat::from_fn(n + m, m, |i, k| f64::from(u8::from(i == n + k)));
    let expected = solve_dense(system.as_ref(), right.as_ref());
    for k in 0..m {
        for i in 0..n {
            let off = (all.transformation[(i, k)] - expected[(i, k)]).abs();
            assert!(off < 1e-9, "column {k}, dof {i}: {off:e}");
        }
    }
}

/// Matrices of two superelements whose coordinates at one side are the same.
fn coupled([first, second]: [&Superelement; 2], sides: [std::ops::Range<usize>; 2]) -> (Mat<f64>, Mat<f64>) {
    let (a, b) = (first.mass.nrows(), second.mass.nrows());
    let joint = sides[0].len();
    let place = |k: usize| match sides[1].contains(&k) {
        true => sides[0].start + k - sides[1].start,
        false if k < sides[1].start => a + k,
        false => a + k - joint,
    };
    let sum = |own: &Mat<f64>, other: &Mat<f64>| {
        let mut sum = Mat::zeros(a + b - joint, a + b - joint);
        (0..a).for_each(|i| (0..a).for_each(|k| sum[(i, k)] += own[(i, k)]));
        (0..b).for_each(|i| (0..b).for_each(|k| sum[(place(i), place(k))] += other[(i, k)]));
        sum
    };
    (sum(&first.mass, &second.mass), sum(&first.stiffness, &second.stiffness))
}

#[test]
fn two_bodies_that_are_joined_have_the_frequencies_of_the_joined_mesh() {
    let whole = prepared(&beam(1.5, 12, ""));
    let pencil = whole.body.model.pencil();
    let expected = lowest_modes(pencil, &Symbolic::analyze(pencil).unwrap(), 6).unwrap().eigenvalues;
    let half = beam(0.75, 6, "");
    let error = |method: Method, modes: usize| -> f64 {
        let [left, right] = [["x_max"], ["x_min"]].map(|side| reduced(&half, &side, method, modes).unwrap());
        let joint = 0..left.coordinates;
        let (mass, stiffness) = coupled([&left, &right], [joint.clone(), joint]);
        let found = eigenvalues(&mass, &stiffness);
        let off = |k: usize| found[6 + k] / expected[k] - 1.0;
        // Ritz values lie above, but for rounding and the residual of modes.
        assert!((0..6).all(|k| off(k) > -1e-9), "{method:?}");
        (0..6).map(off).fold(0.0, f64::max)
    };
    // Errors of component modes fall with the square of the first frequency left out, and faster. Free modes
    // less their static part have no moment at a lone interface, so those of Herting fall with its inverse.
    for (method, most) in [(Method::CraigBampton, 1e-4), (Method::Rubin, 1e-6), (Method::Herting, 0.5)] {
        let [few, more, many] = [2, 8, 24].map(|modes| error(method, modes));
        println!("{method:?}: {few:.1e} {more:.1e} {many:.1e}");
        assert!(many < more && more < few && many < most, "{method:?}: {few:e}, {more:e}, {many:e}");
    }
}

#[test]
fn damping_is_that_of_the_body() {
    let keys = "[damping]\nalpha = 3.0\nbeta = 1e-5\n";
    let problem = beam(1.0, 6, keys);
    for method in METHODS {
        let found = reduced(&problem, &[LEFT, RIGHT], method, 4).unwrap();
        let off = &found.damping - (&found.mass * faer::Scale(3.0) + &found.stiffness * faer::Scale(1e-5));
        assert!(size(&off) <= 1e-12 * size(&found.damping), "{method:?}");
    }
    // Ratios of natural modes: the damping of the reduced body along them.
    let problem = beam(1.0, 6, "[damping]\nmodal = [0.01, 0.02, 0.03]\n");
    let pencil = prepared(&problem).body.model.pencil().clone();
    let modes = lowest_modes(&pencil, &Symbolic::analyze(&pencil).unwrap(), 3).unwrap();
    for method in [Method::Herting, Method::Rubin] {
        let found = reduced(&problem, &["x_max=average"], method, 3).unwrap();
        let (values, axes) = symmetric_eigen(found.mass.as_ref()).unwrap();
        let unit = Mat::from_fn(values.len(), values.len(), |i, k| axes[(i, k)] / values[k].sqrt());
        let (values, axes) = symmetric_eigen((unit.transpose() * &found.stiffness * &unit).as_ref()).unwrap();
        let shapes = &unit * &axes;
        let damped = shapes.transpose() * &found.damping * &shapes;
        for (mode, ratio) in [0.01, 0.02, 0.03].into_iter().enumerate() {
            let own = 6 + mode;
            assert!((values[own] / modes.eigenvalues[mode] - 1.0).abs() < 1e-8);
            let found = damped[(own, own)] / (2.0 * values[own].sqrt());
            assert!((found / ratio - 1.0).abs() < 1e-6, "{method:?}, mode {mode}: {found}");
        }
    }
}

#[test]
fn a_body_with_supports_loses_what_they_hold() {
    let problem = beam(1.0, 6, "[[support]]\non = { group = \"x_min\" }\n");
    let found = reduced(&problem, &["x_max"], Method::CraigBampton, 4).unwrap();
    assert!(found.rigid_motions.is_none());
    // A face that shares an edge with the support.
    let edge = reduced(&problem, &["z_max"], Method::CraigBampton, 4).unwrap();
    let (nodes, coordinates) = (edge.interfaces[0].nodes.len(), edge.coordinates);
    assert_eq!((nodes, coordinates), (21, 3 * 18));
    let body = prepared(&problem);
    let held = InterfaceEntry::parse("x_min").unwrap();
    let refused = interfaces(&problem, &body.body, &[held]).unwrap_err().to_string();
    assert!(refused.contains("supports hold all of its displacements"), "{refused}");
    let rigid = InterfaceEntry::parse("z_max=rigid").unwrap();
    let refused = interfaces(&problem, &body.body, &[rigid]).unwrap_err().to_string();
    assert!(refused.contains("is held by a support"), "{refused}");
}

#[test]
fn interfaces_that_cannot_be_are_refused_by_name() {
    let problem = beam(1.0, 6, "");
    let fails =
        |names: &[&str], method, modes| reduced(&problem, names, method, modes).unwrap_err().to_string();
    let one = "pin={ kind = \"nodes\", on = { nodes = [1] } }";
    for (names, method, modes, words) in [
        (
            vec!["x_min", "z_max"],
            Method::CraigBampton,
            2,
            "--interface x_min and z_max have node 22 in common",
        ),
        (vec![one], Method::CraigBampton, 2, "leave 3 of the 6 rigid motions"),
        (vec![one], Method::Herting, 2, "leave 3 of the 6 rigid motions"),
        (vec!["x_min"], Method::Rubin, 0, "needs at least one"),
        (vec!["x_min"], Method::CraigBampton, 100_000, "normal modes of the superelement"),
    ] {
        let refused = fails(&names, method, modes);
        assert!(refused.contains(words), "{names:?}: {refused}");
    }
    // Free interfaces need no such points.
    assert!(reduced(&problem, &[one], Method::Rubin, 2).is_ok());
    let body = prepared(&problem);
    for (name, words) in [
        ("x_mid", "there are `body`, `x_max`, `x_min`"),
        ("a={ kind = \"rigid\", on = { nodes = [1, 2] } }", "the 2 nodes of the frame lie on a line"),
        ("x_min={ at = [0.0, 0.0, 0.0] }", "`at` is given for an interface of kind patch"),
        ("x_min={ kind = \"rigid\", axes = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0]] }", "two perpendicular"),
        ("a={ on = { nodes = [1] } }", "no whole facet"),
    ] {
        let entry = InterfaceEntry::parse(name).unwrap();
        let refused = interfaces(&problem, &body.body, &[entry]).unwrap_err().to_string();
        assert!(refused.contains(words), "{name}: {refused}");
    }
    let twice = ["x_min", "x_min"].map(|name| InterfaceEntry::parse(name).unwrap());
    assert!(interfaces(&problem, &body.body, &twice).is_err_and(|e| e.to_string().contains("twice")));
    assert!(interfaces(&problem, &body.body, &[]).is_err_and(|e| e.to_string().contains("no interface")));
}

#[test]
fn ports_of_a_problem_are_interfaces() {
    let port =
        "[[port]]\nname = \"tip\"\non = { group = \"x_max\" }\n[[port]]\nname = \"hub\"\nkind = \"frame\"\n";
    let text = format!(
        "{port}reference = \"axle\"\n[[reference_point]]\nname = \"axle\"\nat = [0.0, 0.05, 0.04]\n\
         [[coupling]]\nreference = \"axle\"\non = {{ group = \"x_min\" }}\nkind = \"rigid\"\n"
    );
    let problem = beam(1.0, 6, &text);
    let found = reduced(&problem, &[], Method::CraigBampton, 4).unwrap();
    let kinds: Vec<_> = found.interfaces.iter().map(|interface| interface.kind).collect();
    assert_eq!(kinds, ["patch", "reference"]);
    // The same as a rigid frame of the interface.
    let own = beam(1.0, 6, "");
    let rigid = "hub={ kind = \"rigid\", on = { group = \"x_min\" }, at = [0.0, 0.05, 0.04] }";
    let expected = reduced(&own, &["x_max", rigid], Method::CraigBampton, 4).unwrap();
    for (a, b) in [(&found.mass, &expected.mass), (&found.stiffness, &expected.stiffness)] {
        // Signs of modes are those of their largest entry, which is the same node.
        assert!(size(&(a - b)) < 1e-8 * size(b));
    }
}
