//! The tree over the moving surface finds what a search of every triangle finds.

use vademecum_eval::format::{File, SectionKind};
use vademecum_eval::{
    Contact, Field, OutputError, Place, Scalar, SceneOptions, Surface, SurfacePoint, SurfaceTree, TreeSizes,
};
use vademecum_tests::exact_beam::exact_beam;
use vademecum_tests::stage::with_scene;
use vademecum_tests::synthetic::Random;

type Point = [f64; 3];

/// What was pressed and pulled: displacements of the surface, three numbers a node.
fn moved<T: Scalar>(bytes: &[u8]) -> Vec<T> {
    with_scene::<T, _>(bytes, &SceneOptions::default(), |scene, state, loads| {
        let contact = Contact::new(Place::triangle([2; 3], [1.0, 0.0, 0.0]), [300.0, -2e3, -4e3]);
        loads.add_contact(scene, &contact).expect("a contact");
        for _ in 0..50 {
            scene.step(state, loads).expect("a step");
        }
        let mut out = vec![T::ZERO; 3 * scene.metadata().n_surface_nodes as usize];
        scene.surface_into(state, Field::Displacement, &mut out).expect("a surface");
        out
    })
}

/// Corners of every triangle as it has moved, in single precision as the tree has them.
fn triangles(file: &File<'_>, moved: &[f32], scale: f64) -> Vec<([u32; 3], [Point; 3])> {
    let numbers = file.section(SectionKind::NodeCoordinates).expect("nodes").numbers().expect("numbers");
    let coordinates: Vec<f64> = numbers.iter().collect();
    let nodes = file.section(SectionKind::Triangles).expect("triangles").u32s().expect("numbers");
    let nodes: Vec<u32> = nodes.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect();
    let at = |node: u32| {
        [0, 1, 2].map(|k| {
            let i = 3 * node as usize + k;
            f64::from((coordinates[i] + scale * f64::from(moved[i])) as f32)
        })
    };
    nodes.as_chunks::<3>().0.iter().map(|nodes| (*nodes, nodes.map(at))).collect()
}

fn minus(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn dot(a: Point, b: Point) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

/// Distance along a ray, by the volumes that it spans with the edges.
fn met(origin: Point, along: Point, [a, b, c]: [Point; 3]) -> Option<f64> {
    let volume = |p: Point, q: Point, r: Point| {
        p[0] * (q[1] * r[2] - q[2] * r[1])
            + p[1] * (q[2] * r[0] - q[0] * r[2])
            + p[2] * (q[0] * r[1] - q[1] * r[0])
    };
    let [a, b, c] = [a, b, c].map(|corner| minus(corner, origin));
    let [u, v, w] = [volume(along, c, b), volume(along, a, c), volume(along, b, a)];
    let all = u + v + w;
    let inside = [u, v, w].iter().all(|x| *x >= 0.0) || [u, v, w].iter().all(|x| *x <= 0.0);
    let distance = (u * dot(a, along) + v * dot(b, along) + w * dot(c, along)) / all;
    (inside && distance >= 0.0).then_some(distance)
}

/// Distance from a point, by the nearest of very many points of the triangle's plane, edges and corners: the
/// projections on them.
fn away(point: Point, corners: [Point; 3]) -> f64 {
    let edge = |a: Point, b: Point| {
        let along = minus(b, a);
        let share = (dot(minus(point, a), along) / dot(along, along)).clamp(0.0, 1.0);
        let gap = minus(point, [0, 1, 2].map(|k| a[k] + share * along[k]));
        dot(gap, gap).sqrt()
    };
    let [a, b, c] = corners;
    let edges = edge(a, b).min(edge(b, c)).min(edge(c, a));
    let (ab, ac) = (minus(b, a), minus(c, a));
    let normal =
        [ab[1] * ac[2] - ab[2] * ac[1], ab[2] * ac[0] - ab[0] * ac[2], ab[0] * ac[1] - ab[1] * ac[0]];
    let length = dot(normal, normal).sqrt();
    let [along, against] = [1.0, -1.0].map(|sign| met(point, normal.map(|x| sign * x / length), corners));
    [along, against].into_iter().flatten().fold(edges, f64::min)
}

fn with_tree(bytes: &[u8], use_it: impl FnOnce(&File<'_>, &mut SurfaceTree<'_>)) {
    let file = File::parse(bytes).expect("a file");
    let surface = Surface::whole(&file).expect("a surface");
    let TreeSizes { order, boxes } = surface.tree_sizes();
    let (mut order, mut boxes) = (vec![7; order], vec![f32::NAN; boxes]);
    let mut tree = SurfaceTree::new(&surface, &mut order, &mut boxes).expect("memory");
    use_it(&file, &mut tree);
}

/// A point around the beam, which is 1 m long and 0.1 m thick.
fn somewhere(random: &mut Random) -> Point {
    [0.5 + 0.8 * random.number(), 0.05 + 0.3 * random.number(), 0.05 + 0.3 * random.number()]
}

fn is_there(found: &SurfacePoint, corners: [Point; 3]) {
    let at = [0, 1, 2].map(|k| (0..3).map(|i| found.place.weights()[i] * corners[i][k]).sum::<f64>());
    let gap = minus(at, found.position);
    assert!(dot(gap, gap).sqrt() < 1e-12, "{found:?}");
    assert!(found.place.weights().iter().all(|w| (0.0..=1.0).contains(w)));
    assert!((found.place.weights().iter().sum::<f64>() - 1.0).abs() < 1e-12);
}

#[test]
fn rays_and_points_find_what_a_search_of_all_triangles_finds() {
    let bytes = exact_beam();
    let moved = moved::<f32>(&bytes);
    with_tree(&bytes, |file, tree| {
        let mut random = Random::new(11);
        for scale in [0.0, 1.0, 30.0] {
            tree.refit(&moved, scale).expect("a surface");
            let all = triangles(file, &moved, scale);
            let (mut hits, mut misses) = (0, 0);
            for _ in 0..2000 {
                let (origin, target) = (somewhere(&mut random), somewhere(&mut random));
                let direction = minus(target, origin);
                let length = dot(direction, direction).sqrt();
                let along = direction.map(|x| x / length);
                let expected =
                    all.iter().filter_map(|(_, corners)| met(origin, along, *corners)).reduce(f64::min);
                let found = tree.pick(origin, direction);
                match (expected, found) {
                    (Some(expected), Some(found)) => {
                        hits += 1;
                        assert!((found.distance - expected).abs() < 1e-9, "{found:?}, {expected}");
                        let own =
                            all.iter().find(|(nodes, _)| *nodes == found.place.nodes()).expect("a triangle");
                        is_there(&found, own.1);
                    }
                    (None, None) => misses += 1,
                    other => panic!("{other:?} from {origin:?} along {along:?}"),
                }
                let nearest =
                    all.iter().map(|(_, corners)| away(origin, *corners)).fold(f64::INFINITY, f64::min);
                let found = tree.locate(origin).expect("a point");
                assert!((found.distance - nearest).abs() < 1e-9, "{found:?}, {nearest}");
                let own = all.iter().find(|(nodes, _)| *nodes == found.place.nodes()).expect("a triangle");
                is_there(&found, own.1);
            }
            assert!(hits > 200 && misses > 200, "{hits} hits, {misses} misses");
        }
    });
}

#[test]
fn rays_along_the_axes_pass_no_seam() {
    let bytes = exact_beam();
    with_tree(&bytes, |file, tree| {
        let all = triangles(file, &vec![0.0; 3 * file.metadata().n_surface_nodes as usize], 0.0);
        // Through every corner and the middle of every edge, at right angles: there two triangles or more
        // meet.
        for (_, corners) in &all {
            let flat = |axis: &usize| (0..3).all(|i| corners[i][*axis] == corners[0][*axis]);
            let axis = (0..3).find(flat).expect("the sides of a block");
            for i in 0..3 {
                let (a, b) = (corners[i], corners[(i + 1) % 3]);
                for target in [a, [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]))] {
                    for side in [-1.0, 1.0] {
                        let mut origin = target;
                        origin[axis] = 2.0 * side;
                        let mut along = [0.0; 3];
                        along[axis] = -3.0 * side;
                        let found = tree.pick(origin, along).expect("the body is there");
                        assert!(found.distance <= (target[axis] - origin[axis]).abs() + 1e-9);
                    }
                }
            }
        }
    });
}

#[test]
fn what_makes_no_sense_finds_nothing_and_short_memory_is_refused() {
    let bytes = exact_beam();
    with_tree(&bytes, |file, tree| {
        assert_eq!(tree.pick([0.0; 3], [0.0; 3]), None);
        assert_eq!(tree.pick([f64::NAN; 3], [1.0, 0.0, 0.0]), None);
        assert_eq!(tree.locate([f64::INFINITY, 0.0, 0.0]), None);
        let needed = 3 * file.metadata().n_surface_nodes as usize;
        let short = tree.refit(&[0.0_f32; 2], 1.0);
        assert_eq!(short, Err(OutputError::Length { found: 2, needed }));
        // A body that is torn to pieces is not there, and is there again afterwards.
        tree.refit(&vec![f32::NAN; needed], 1.0).expect("a surface");
        assert_eq!(tree.locate([0.0; 3]), None);
        assert_eq!(tree.pick([0.5, 0.04, 1.0], [0.0, 0.0, -1.0]), None);
        tree.refit::<f32>(&[], 0.0).expect("a surface");
        assert!(tree.locate([0.0; 3]).is_some());
        let surface = Surface::whole(file).expect("a surface");
        let TreeSizes { order, boxes } = surface.tree_sizes();
        let (mut order, mut boxes) = (vec![0; order - 1], vec![0.0; boxes]);
        assert!(SurfaceTree::new(&surface, &mut order, &mut boxes).is_err());
    });
}
