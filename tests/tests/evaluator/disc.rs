//! Contacts with a radius: a uniform traction over a disc of the surface, whose answer converges where that of
//! a point does not.

use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::{Body, BodyOptions, Field, LoadError, Place, Surface, SurfacePoint};
use vademecum_format::File;

const RADIUS: f64 = 0.016;

/// A cube on its foot, loadable on its upper face, with residual flexibility between all nodes of the disc;
/// its modes are damped and come to rest within a step of ten seconds.
fn cube(divisions: usize) -> Vec<u8> {
    let text = format!(
        "[mesh]\nblock = {{ lengths = [0.08, 0.08, 0.08], divisions = [{divisions}, {divisions}, {divisions}], \
         order = \"linear\" }}\n\
         [[material]]\nyoung = 1e6\npoisson = 0.3\ndensity = 1000.0\n[damping]\nratio = 0.7\n\
         [[support]]\non = {{ group = \"z_min\" }}\n[load]\nsurface = {{ group = \"z_max\" }}\n\
         [basis]\nmodes = 12\n[tolerance]\nerror = 10.0\n\
         [output]\nprecision = \"f64\"\ncontact_patch = 0.05\ncontact_modes = 0\n"
    );
    let problem = Problem::parse(&text, "cube.toml", PathBuf::new()).expect("a problem");
    build(&problem, &BuildOptions::default(), &Silent).expect("a build").either().bytes
}

fn with_body<R>(bytes: &[u8], disc_nodes: usize, run: impl FnOnce(&mut Body<'_, f64>) -> R) -> R {
    let file = File::parse(bytes).expect("a file");
    let mut options = BodyOptions::default();
    (options.scene.time_step, options.scene.disc_nodes) = (Some(10.0), disc_nodes);
    let mut memory = vec![0.0; Body::<f64>::len_for(&file, &options).expect("a length")];
    run(&mut Body::bind(&file, &options, &mut memory).expect("a body"))
}

/// The place on the upper face.
fn at(bytes: &[u8], x: f64, y: f64) -> SurfacePoint {
    let file = File::parse(bytes).expect("a file");
    let surface = Surface::new(&file).expect("a surface");
    surface.locate([x, y, 0.08]).expect("a place")
}

/// Displacement under a force of 1 N at a place at rest, read at another.
fn settled(bytes: &[u8], place: &Place, read: &Place) -> f64 {
    with_body(bytes, 400, |body| {
        body.push(place, [0.0, 0.0, -1.0]).expect("a push");
        body.step().expect("a step");
        -body.point(read, Field::Displacement).expect("a point")[2]
    })
}

#[test]
fn a_disc_converges_under_refinement_and_a_point_does_not() {
    let found = [4, 8, 16].map(|divisions| {
        let bytes = cube(divisions);
        // The middle of the face is a node of every mesh.
        let place = at(&bytes, 0.04, 0.04).place;
        let disc = place.with_radius(RADIUS);
        [settled(&bytes, &disc, &disc), settled(&bytes, &place, &place)]
    });
    println!("disc and point, m/N: {found:?}");
    let change = |which: usize, k: usize| (found[k + 1][which] / found[k][which] - 1.0).abs();
    // Cells of half the size: at least the first order of linear elements.
    assert!(change(0, 1) < 0.5 * change(0, 0), "{found:?}");
    // The answer under a point grows with the inverse of the distance between nodes, and never ends.
    assert!(change(1, 1) > 0.9 * change(1, 0) && change(1, 1) > 0.9, "{found:?}");
}

#[test]
fn the_load_is_the_same_on_every_mesh() {
    // Far from the disc the answer is that of the resultant: meshes differ by their own error alone.
    let far = [8, 12].map(|divisions| {
        let bytes = cube(divisions);
        let place = at(&bytes, 0.03, 0.05).place.with_radius(RADIUS);
        settled(&bytes, &place, &at(&bytes, 0.08, 0.0).place)
    });
    assert!((far[1] / far[0] - 1.0).abs() < 0.05, "{far:?}");
}

#[test]
fn force_and_mean_displacement_are_conjugate() {
    let bytes = cube(6);
    let [a, b] = [at(&bytes, 0.033, 0.041), at(&bytes, 0.05, 0.06)].map(|point| point.place);
    let [a, b] = [a.with_radius(RADIUS), b.with_radius(0.7 * RADIUS)];
    let there = settled(&bytes, &a, &b);
    let back = settled(&bytes, &b, &a);
    assert!((there / back - 1.0).abs() < 1e-12, "{there} {back}");
    // The operator says what a step shows.
    with_body(&bytes, 100, |body| {
        let (mut w, mut free) = ([0.0; 36], [[0.0; 3]; 2]);
        body.compliance(&[a, b], &mut w).expect("an operator");
        body.free_motion(&[a, b], &mut free).expect("a motion");
        assert_eq!(free, [[0.0; 3]; 2]);
        let forces = [[0.3, -0.1, -1.0], [-0.2, 0.4, -0.5]];
        body.push(&a, forces[0]).expect("a push");
        body.push(&b, forces[1]).expect("a push");
        body.step().expect("a step");
        for (c, place) in [a, b].iter().enumerate() {
            let shown = body.point(place, Field::Displacement).expect("a point");
            for (i, shown) in shown.into_iter().enumerate() {
                let said: f64 = (0..6).map(|k| w[6 * (3 * c + i) + k] * forces.as_flattened()[k]).sum();
                assert!((said - shown).abs() < 1e-12 * w[0], "{said} {shown}");
            }
        }
    });
    // A small disc is the point.
    let point = a.with_radius(0.0);
    let small = settled(&bytes, &point.with_radius(1e-7), &point);
    assert!((small / settled(&bytes, &point, &point) - 1.0).abs() < 1e-4);
}

#[test]
fn a_disc_too_large_is_refused_with_the_largest_that_fits() {
    let bytes = cube(8);
    let place = at(&bytes, 0.041, 0.038).place;
    with_body(&bytes, 12, |body| {
        let refused = body.push(&place.with_radius(0.03), [0.0, 0.0, -1.0]);
        let Err(LoadError::Disc { radius, largest, room }) = refused else { panic!("{refused:?}") };
        assert_eq!((radius, room), (0.03, 12));
        assert!(0.0 < largest && largest < 0.03);
        assert!(body.loads().is_empty());
        body.push(&place.with_radius(largest), [0.0, 0.0, -1.0]).expect("the largest");
        let more = body.push(&place.with_radius(1.01 * largest), [0.0, 0.0, -1.0]);
        assert!(matches!(more, Err(LoadError::Disc { .. })), "{more:?}");
        for radius in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(body.push(&place.with_radius(radius), [1.0; 3]), Err(LoadError::Place(_))));
        }
    });
    // Without room for discs points alone are taken.
    with_body(&bytes, 0, |body| {
        let refused = body.push(&place.with_radius(0.01), [0.0, 0.0, -1.0]);
        assert!(matches!(refused, Err(LoadError::Place(_))), "{refused:?}");
    });
}
