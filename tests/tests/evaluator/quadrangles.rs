//! Contacts on quadrangular facets: found by a triangle, shared over the facet's own four, eight or nine
//! nodes, with a residual between all of them.

use std::fmt::Write;
use std::sync::OnceLock;

use vademecum_build::Matrix;
use vademecum_build::fem::Solve;
use vademecum_build::input::Problem;
use vademecum_build::mesh::{ElementKind, Order};
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::prepared::prepare;
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_eval::{
    Contact, Field, LoadError, Place, SceneOptions, Surface, SurfacePoint, SurfaceTree, TreeSizes,
};
use vademecum_format::{File, SectionKind};
use vademecum_rewrite::{Keep, check, pack, strip, unpack};
use vademecum_tests::golden;
use vademecum_tests::stage::with_scene;
use vademecum_tests::synthetic::Random;

const KINDS: [ElementKind; 3] = [ElementKind::Hex8, ElementKind::Hex20, ElementKind::Hex27];
/// Edges of a cell \[m\], and cells along each axis: one stands in the middle of the upper side.
const CELL: [f64; 3] = [0.25, 0.25, 0.125];
const CELLS: [usize; 3] = [3, 3, 2];
const TOP: f64 = 0.25;

const PROBLEM: &str = r#"
[mesh]
file = "block.vtk"
[[material]]
young = 1e6
poisson = 0.3
density = 1000.0
[damping]
alpha = 10.0
[[support]]
on = { plane = { axis = "z", at = 0.0 } }
[time]
step = 1e-2
scheme = { name = "exact" }
[basis]
kind = "modes"
modes = 4
[tolerance]
error = 1.0
"#;

/// Corners of a cell, counter-clockwise below and above.
const CORNERS: [[f64; 3]; 8] = [
    [0., 0., 0.],
    [1., 0., 0.],
    [1., 1., 0.],
    [0., 1., 0.],
    [0., 0., 1.],
    [1., 0., 1.],
    [1., 1., 1.],
    [0., 1., 1.],
];

/// The block as a VTK file.
fn block(kind: ElementKind) -> String {
    let mut places: Vec<[f64; 3]> = CORNERS.to_vec();
    let mean = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|i| 0.5 * (a[i] + b[i]));
    if kind.order() == Order::Quadratic {
        places.extend(kind.edges().iter().map(|&[a, b]| mean(CORNERS[a], CORNERS[b])));
    }
    if kind == ElementKind::Hex27 {
        let sides = [[0, 7], [1, 6], [0, 5], [3, 6], [0, 2], [4, 6], [0, 6]];
        places.extend(sides.map(|[a, b]| mean(CORNERS[a], CORNERS[b])));
    }
    let mut known: Vec<[f64; 3]> = vec![];
    let (mut cells, mut count) = (String::new(), 0);
    for z in 0..CELLS[2] {
        for (y, x) in (0..CELLS[1]).flat_map(|y| (0..CELLS[0]).map(move |x| (y, x))) {
            let start = [x, y, z].map(|n| n as f64);
            write!(cells, "{}", places.len()).unwrap();
            for place in &places {
                // Eighths: sums of them are exact.
                let at = std::array::from_fn(|i| CELL[i] * (start[i] + place[i]));
                let node = known.iter().position(|other| *other == at).unwrap_or(known.len());
                if node == known.len() {
                    known.push(at);
                }
                write!(cells, " {node}").unwrap();
            }
            cells.push('\n');
            count += 1;
        }
    }
    let points: String = known.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
    let types = format!("{}\n", kind.vtk()).repeat(count);
    let size = count * (1 + places.len());
    format!(
        "# vtk DataFile Version 2.0\nblock\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {} double\n{points}\
         CELLS {count} {size}\n{cells}CELL_TYPES {count}\n{types}",
        known.len()
    )
}

fn with_problem<R>(kind: ElementKind, more: &str, ask: impl FnOnce(&Problem) -> R) -> R {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("block.vtk"), block(kind)).expect("written");
    ask(&Problem::parse(&format!("{PROBLEM}{more}"), "p.toml", folder.path().to_path_buf())
        .expect("a problem"))
}

fn built(kind: ElementKind, more: &str) -> Vec<u8> {
    let built = |problem: &Problem| build(problem, &BuildOptions::default(), &Silent);
    with_problem(kind, more, built).expect("built").either().bytes
}

fn file_of(kind: ElementKind) -> &'static [u8] {
    static FILES: [OnceLock<Vec<u8>>; 3] = [const { OnceLock::new() }; 3];
    let index = KINDS.iter().position(|&other| other == kind).expect("a kind");
    FILES[index].get_or_init(|| built(kind, ""))
}

fn coordinates(file: &File<'_>) -> Vec<[f64; 3]> {
    let section = file.section(SectionKind::NodeCoordinates).expect("coordinates");
    let numbers: Vec<f64> = section.numbers().expect("raw").iter().collect();
    numbers.as_chunks::<3>().0.to_vec()
}

fn locate(bytes: &[u8], point: [f64; 3]) -> SurfacePoint {
    let file = File::parse(bytes).expect("a file");
    Surface::new(&file).expect("a surface").locate(point).expect("a place")
}

const MIDDLE: [f64; 3] = [0.375, 0.375, TOP];

#[test]
fn a_force_in_the_middle_of_a_facet_falls_to_all_of_its_nodes() {
    for kind in KINDS {
        let bytes = file_of(kind);
        let nodes = coordinates(&File::parse(bytes).expect("a file"));
        let place = locate(bytes, MIDDLE).place;
        for (node, weight) in place.entries() {
            let away = [0, 1].map(|c| ((nodes[node as usize][c] - MIDDLE[c]) / 0.125).abs().round() as u8);
            assert!(nodes[node as usize][2] == TOP && away.iter().all(|&a| a <= 1), "{kind:?}");
            let expected = match (kind, away) {
                (ElementKind::Hex8, [1, 1]) => 0.25,
                (ElementKind::Hex20, [1, 1]) => -0.25,
                (ElementKind::Hex20, _) => 0.5,
                (_, [0, 0]) => 1.0,
                _ => 0.0,
            };
            assert!((weight - expected).abs() < 1e-12, "{kind:?}: {weight} at {away:?}");
        }
        let count = [4, 8, 9][KINDS.iter().position(|&other| other == kind).expect("a kind")];
        assert_eq!(place.nodes().len(), count);
    }
}

#[test]
fn shape_functions_are_those_of_the_element() {
    for kind in KINDS {
        let bytes = file_of(kind);
        let file = File::parse(bytes).expect("a file");
        let (nodes, mut random) = (coordinates(&file), Random::new(5));
        for _ in 0..300 {
            let [x, y] = [0, 1].map(|_| 0.375 * (1.0 + random.number()));
            let found = locate(bytes, [x, y, TOP + 0.1]);
            assert!((found.distance - 0.1).abs() < 1e-12);
            assert!((found.place.weights().iter().sum::<f64>() - 1.0).abs() < 1e-14);
            let first = found.place.nodes()[0] as usize;
            // In the facet's own coordinates, so that digits are not lost.
            let local = |at: [f64; 3]| [0, 1].map(|c| (at[c] - nodes[first][c]) / 0.25);
            let at = local([x, y, TOP]);
            // Each of these the functions of a kind reproduce, and there are as many as nodes: no other
            // functions do.
            let powers: &[[i32; 2]] = match kind {
                ElementKind::Hex8 => &[[0, 0], [1, 0], [0, 1], [1, 1]],
                ElementKind::Hex20 => &[[0, 0], [1, 0], [0, 1], [1, 1], [2, 0], [0, 2], [2, 1], [1, 2]],
                _ => &[[0, 0], [1, 0], [0, 1], [1, 1], [2, 0], [0, 2], [2, 1], [1, 2], [2, 2]],
            };
            assert_eq!(powers.len(), found.place.nodes().len());
            for [a, b] in powers {
                let power = |[x, y]: [f64; 2]| x.powi(*a) * y.powi(*b);
                let sum: f64 =
                    found.place.entries().map(|(node, w)| w * power(local(nodes[node as usize]))).sum();
                assert!((sum - power(at)).abs() < 1e-12, "{kind:?} {a} {b}: {sum} {}", power(at));
            }
            let position: [f64; 3] = std::array::from_fn(|c| {
                found.place.entries().map(|(node, w)| w * nodes[node as usize][c]).sum()
            });
            for c in 0..3 {
                assert!((position[c] - found.position[c]).abs() < 1e-14);
                assert!((found.position[c] - [x, y, TOP][c]).abs() < 1e-14);
            }
        }
    }
}

#[test]
fn a_ray_and_the_moving_surface_find_the_same_place() {
    for kind in KINDS {
        let file = File::parse(file_of(kind)).expect("a file");
        let surface = Surface::whole(&file).expect("a surface");
        let TreeSizes { order, boxes } = surface.tree_sizes();
        let (mut order, mut boxes) = (vec![0; order], vec![0.0; boxes]);
        let tree = SurfaceTree::new(&surface, &mut order, &mut boxes).expect("a tree");
        for [x, y] in [[0.3, 0.31], [0.61, 0.2], [0.72, 0.74]] {
            let expected = surface.locate([x, y, TOP]).expect("a place").place;
            let picked = tree.pick([x, y, 3.0], [0.0, 0.0, -1.0]).expect("a place").place;
            let near = tree.locate([x, y, TOP]).expect("a place").place;
            for found in [picked, near] {
                assert_eq!(found.nodes(), expected.nodes());
                let pairs = found.weights().iter().zip(expected.weights());
                assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-6));
            }
        }
        // Held facets below, which no force may act on, are found by their triangles.
        let below = tree.pick([0.3, 0.31, -3.0], [0.0, 0.0, 1.0]).expect("a place").place;
        assert_eq!(below.nodes().len(), 3);
    }
}

#[test]
fn a_body_pushed_in_the_middle_answers_symmetrically() {
    for kind in KINDS {
        let bytes = file_of(kind);
        let nodes = coordinates(&File::parse(bytes).expect("a file"));
        let point = locate(bytes, MIDDLE);
        with_scene::<f64, _>(bytes, &SceneOptions::default(), |scene, state, loads| {
            let push = Contact::new(point.place, [0.0, 0.0, -10.0]);
            loads.add_contact(scene, &push).expect("a contact");
            for _ in 0..7 {
                scene.step(state, loads).expect("a step");
            }
            let n = scene.metadata().n_surface_nodes as usize;
            let mut moved = vec![0.0; 3 * n];
            scene.surface_into(state, Field::Displacement, &mut moved).expect("a field");
            let largest = moved.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
            for (node, at) in nodes.iter().take(n).enumerate() {
                for c in [0, 1] {
                    let mut across = *at;
                    across[c] = 0.75 - at[c];
                    let other = nodes.iter().position(|x| *x == across).expect("a node across");
                    for i in 0..3 {
                        let sign = if i == c { -1.0 } else { 1.0 };
                        let off = moved[3 * node + i] - sign * moved[3 * other + i];
                        assert!(off.abs() < 1e-9 * largest, "{kind:?}: {off:e} of {largest:e}");
                    }
                }
            }
        });
    }
}

/// The displacement of a place under a force there that stays, of the full model.
fn static_answer(kind: ElementKind, point: &SurfacePoint, force: [f64; 3]) -> [f64; 3] {
    let nodes = coordinates(&File::parse(file_of(kind)).expect("a file"));
    with_problem(kind, "", |problem| {
        let prepared = prepare(problem, &mut Stopwatch::new(&Silent), &Silent).expect("a model");
        let model = &prepared.body.model;
        let own = |&node: &u32| {
            let at = nodes[node as usize];
            model.mesh().nodes.iter().position(|other| *other == at).expect("a mesh node") as u32
        };
        let own: Vec<u32> = point.place.nodes().iter().map(own).collect();
        let mut load = vec![0.0; prepared.body.n_dof()];
        model.add_point_force(&own, point.place.weights(), force, &mut load);
        let factor = prepared.symbolic.factorize(model.pencil().combine(0.0, 1.0)).expect("definite");
        let mut answer = Matrix::from_fn(load.len(), 1, |i, _| load[i]);
        Solve::new(&prepared.symbolic, 1, true).solve_in_place(&factor, answer.as_mut());
        let mut full = vec![0.0; model.dofs().n_dof()];
        let free: Vec<f64> = (0..load.len()).map(|i| answer[(i, 0)]).collect();
        model.dofs().expand_into(&free, &mut full);
        let shares = || own.iter().zip(point.place.weights());
        std::array::from_fn(|c| shares().map(|(&node, w)| w * full[3 * node as usize + c]).sum())
    })
}

#[test]
fn the_place_under_a_force_ends_where_statics_says() {
    const FORCE: [f64; 3] = [3.0, 10.0, -20.0];
    let options = SceneOptions { alpha: Some(120.0), ..SceneOptions::default() };
    for kind in KINDS {
        let bytes = file_of(kind);
        let point = locate(bytes, [0.31, 0.44, TOP]);
        let expected = static_answer(kind, &point, FORCE);
        let found = with_scene::<f64, _>(bytes, &options, |scene, state, loads| {
            loads.add_contact(scene, &Contact::new(point.place, FORCE)).expect("a contact");
            for _ in 0..3000 {
                scene.step(state, loads).expect("a step");
            }
            scene.point(state, &point, Field::Displacement).expect("a point")
        });
        let largest = expected.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
        for (found, expected) in found.iter().zip(expected) {
            let off = (found - expected).abs() / largest;
            assert!(off < 1e-9, "{kind:?}: {found} for {expected}");
        }
    }
}

#[test]
fn the_operator_of_contacts_says_what_a_step_does() {
    let forces = [[1.0, 2.0, -30.0], [-5.0, 1.0, 8.0]];
    for kind in KINDS {
        let bytes = file_of(kind);
        // No facet has nodes of both.
        let points = [[0.1, 0.07, TOP], [0.75, 0.7, 0.05]].map(|at| locate(bytes, at));
        with_scene::<f64, _>(bytes, &SceneOptions::default(), |scene, state, loads| {
            let contacts = [0, 1].map(|i| Contact::new(points[i].place, forces[i]));
            let (mut w, mut free) = ([0.0; 36], [[0.0; 3]; 2]);
            let mut work = vec![0.0; scene.compliance_work(2)];
            scene.compliance(&contacts, &mut w, &mut work).expect("an operator");
            scene.free_motion(state, loads, &contacts, &mut free, &mut work).expect("a motion");
            for contact in &contacts {
                loads.add_contact(scene, contact).expect("a contact");
            }
            scene.step(state, loads).expect("a step");
            let moved = points.map(|p| scene.point(state, &p, Field::Displacement).expect("a point"));
            let largest = moved.as_flattened().iter().fold(0.0, |most: f64, u| most.max(u.abs()));
            for (c, moved) in moved.iter().enumerate() {
                for i in 0..3 {
                    let yields: f64 = (0..6).map(|k| w[6 * (3 * c + i) + k] * forces.as_flattened()[k]).sum();
                    let off = (free[c][i] + yields - moved[i]).abs();
                    assert!(off < 1e-13 * largest, "{kind:?}: {off:e} of {largest:e}");
                }
            }
        });
    }
}

#[test]
fn there_is_room_for_as_many_contacts_as_are_asked_for() {
    for kind in KINDS {
        let bytes = file_of(kind);
        let options = SceneOptions { contacts: 2, ..SceneOptions::default() };
        let at = [[0.05, 0.05, TOP], [0.7, 0.7, TOP], [0.0, 0.4, 0.18]];
        let [a, b, c] = at.map(|at| Contact::new(locate(bytes, at).place, [0.0, 0.0, 1.0]));
        with_scene::<f64, _>(bytes, &options, |scene, _, loads| {
            loads.add_contact(scene, &a).expect("room for one");
            loads.add_contact(scene, &b).expect("room for another");
            loads.add_contact(scene, &a).expect("the same nodes");
            let refused = loads.add_contact(scene, &c).expect_err("no room");
            assert_eq!(refused, LoadError::TooManyContacts { contacts: 2 });
        });
    }
}

#[test]
fn files_with_facets_are_sound_and_keep_them_with_their_surface() {
    for kind in KINDS {
        let bytes = file_of(kind);
        check(bytes).expect("sound");
        let width = [6, 10, 11][KINDS.iter().position(|&other| other == kind).expect("a kind")];
        // 9 above and below each, 6 on each of the four sides; those below are held.
        let section = File::parse(bytes).expect("a file").section(SectionKind::Quadrangles).expect("there");
        assert_eq!(section.shape(), [9 + 4 * 6, width, 1]);
        assert_eq!(File::parse(bytes).expect("a file").minor(), 11);
        let packed = pack(bytes, 19).expect("packed");
        check(&packed).expect("sound");
        let raw = unpack(&packed, 1 << 24).expect("unpacked");
        assert_eq!(locate(&raw, MIDDLE), locate(bytes, MIDDLE));
        let surface = strip(bytes, Keep::Surface).expect("stripped");
        assert_eq!(locate(&surface, MIDDLE), locate(bytes, MIDDLE));
    }
    let triangles = golden::named("exact-f64.vdm");
    assert_eq!(File::parse(&triangles).expect("a file").contact_nodes(), 3);
}

#[test]
fn a_facet_that_is_partly_held_is_loaded_as_a_whole() {
    let corners = [[0.25, 0.25], [0.5, 0.25], [0.5, 0.5], [0.25, 0.5]];
    for free in 0..4 {
        // Three corners are held, and so is the whole of one of the two triangles, or of none.
        let balls = (0..4).filter(|&corner| corner != free).map(|corner| {
            let [x, y] = corners[corner];
            format!("{{ sphere = {{ center = [{x}, {y}, {TOP}], radius = 1e-3 }} }}")
        });
        let held = balls.collect::<Vec<_>>().join(", ");
        let bytes = built(ElementKind::Hex8, &format!("[[support]]\non = {{ any = [{held}] }}\n"));
        check(&bytes).expect("sound");
        let place = locate(&bytes, MIDDLE).place;
        assert_eq!((place.nodes().len(), place.weights()), (4, &[0.25; 4][..]));
        let facets = File::parse(&bytes).expect("a file").quadrangles().expect("facets");
        assert_eq!(facets.len(), 9 + 4 * 6);
    }
}

#[test]
fn other_facets_beside_quadrangles_are_shared_as_before() {
    let bytes = golden::named("quadrangles.vdm");
    let file = File::parse(&bytes).expect("a file");
    let kinds = [8, 9, 10].map(|triangle| {
        let facets = file.quadrangles().expect("facets");
        facets.of_triangle(triangle).map(|facet| facet.nodes().len())
    });
    assert_eq!(kinds, [Some(4), Some(4), None]);
    let places = coordinates(&file);
    let middle = |nodes: &[usize]| -> [f64; 3] {
        std::array::from_fn(|c| nodes.iter().map(|&n| places[n][c]).sum::<f64>() / nodes.len() as f64)
    };
    let nine = locate(&bytes, middle(&[0, 8])).place;
    assert_eq!(nine.nodes(), [0, 2, 8, 6, 1, 5, 7, 3, 4]);
    let four = locate(&bytes, middle(&[6, 10])).place;
    assert_eq!(four, Place::new(&[6, 7, 10, 9], &[0.25; 4]).expect("a place"));
    let three = locate(&bytes, middle(&[7, 8, 10])).place;
    assert_eq!(three.nodes(), [7, 8, 10]);
}
