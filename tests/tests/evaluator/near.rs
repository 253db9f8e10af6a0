//! Contacts near each other on one body whose file has a contact patch: the operator is the step and
//! semidefinite, and one contact alone is what it is without a patch.

use std::path::PathBuf;
use std::sync::OnceLock;

use faer::Mat;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::{Body, BodyOptions, Field, Place, Scalar, Surface, SurfacePoint};
use vademecum_format::{File, SectionInput, SectionKind as S, encode_into, encoded_len};

/// A cube on its foot; `rest` has its damping and the numbers of its file.
fn built(rest: &str) -> Vec<u8> {
    let text = format!(
        "[mesh]\nblock = {{ lengths = [0.08, 0.08, 0.08], divisions = [5, 5, 5], order = \"linear\" }}\n\
         [[material]]\nyoung = 1e6\npoisson = 0.3\ndensity = 1000.0\n\
         [[support]]\non = {{ group = \"z_min\" }}\n[basis]\nmodes = 16\n[tolerance]\nerror = 10.0\n{rest}"
    );
    let problem = Problem::parse(&text, "cube.toml", PathBuf::new()).expect("a problem");
    build(&problem, &BuildOptions::default(), &Silent).expect("a build").either().bytes
}

const PATCH: &str = "contact_patch = 0.05\ncontact_modes = 20\nprecision = \"f64\"\n";

/// The cube with a patch.
fn patched() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| built(&format!("[output]\n{PATCH}")))
}

/// The same with stiffness-proportional damping.
fn filtered() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| built(&format!("[damping]\nbeta = 1e-3\n[output]\n{PATCH}")))
}

/// A file without the sections of its patch.
fn alone(bytes: &[u8]) -> Vec<u8> {
    let patch = [S::ContactModes, S::PatchPairs, S::PatchResidual, S::ContactPatch];
    let file = File::parse(bytes).expect("a file");
    let kept: Vec<SectionInput<'_>> =
        file.sections().map(SectionInput::from).filter(|section| !patch.contains(&section.kind)).collect();
    let mut out = vec![0; encoded_len(file.metadata(), &kept).expect("a length")];
    encode_into(file.metadata(), &kept, &mut out).expect("written");
    out
}

/// Some numbers from 0 to 1.
fn numbers() -> impl FnMut() -> f64 {
    let mut seed = 1_u64;
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as f64 / f64::from(1_u32 << 31)
    }
}

/// Places on the upper face, many of which share a triangle.
fn places(bytes: &[u8], count: usize) -> Vec<SurfacePoint> {
    let file = File::parse(bytes).expect("a file");
    let surface = Surface::new(&file).expect("a surface");
    let mut number = numbers();
    let mut at = || surface.locate([0.08 * number(), 0.08 * number(), 0.08]).expect("a place");
    (0..count).map(|_| at()).collect()
}

fn with_body<T: Scalar, R>(bytes: &[u8], run: impl FnOnce(&mut Body<'_, T>) -> R) -> R {
    let file = File::parse(bytes).expect("a file");
    let mut options = BodyOptions { places: 40, ..BodyOptions::default() };
    (options.scene.time_step, options.scene.contacts) = (Some(2e-3), 40);
    let mut memory = vec![0.0; Body::<T>::len_for(&file, &options).expect("a length")];
    run(&mut Body::bind(&file, &options, &mut memory).expect("a body"))
}

/// The operator and the free motion of contacts of a body under way, and the displacements that a step under
/// `forces` shows.
fn said_and_shown<T: Scalar>(bytes: &[u8], count: usize) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let points = places(bytes, count);
    with_body::<T, _>(bytes, |body| {
        for k in [3, 7, 3] {
            body.push(&points[k % count], [1.0, 2.0, -3.0]).expect("a push");
            body.step().expect("a step");
            body.clear();
        }
        let n = 3 * count;
        let (mut w, mut free) = (vec![f64::NAN; n * n], vec![[f64::NAN; 3]; count]);
        body.compliance(&points, &mut w).expect("an operator");
        body.free_motion(&points, &mut free).expect("a motion");
        let mut number = numbers();
        let forces: Vec<f64> = (0..n).map(|_| number() - 0.5).collect();
        for (point, force) in points.iter().zip(forces.as_chunks::<3>().0) {
            body.push(point, *force).expect("a push");
        }
        body.step().expect("a step");
        let shown = |point| body.point(point, Field::Displacement).expect("a point");
        let shown: Vec<f64> = points.iter().flat_map(shown).collect();
        let yields = |i: usize| (0..n).map(|k| w[n * i + k] * forces[k]).sum::<f64>();
        let said = (0..n).map(|i| free.as_flattened()[i] + yields(i)).collect();
        (w, said, shown)
    })
}

#[test]
fn the_operator_is_the_step_whatever_facets_contacts_share() {
    let off = |(_, said, shown): (Vec<f64>, Vec<f64>, Vec<f64>)| {
        let largest = shown.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        said.iter().zip(&shown).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs())) / largest
    };
    for bytes in [patched(), filtered()] {
        // Rounding of sums over 120 forces.
        let [double, single] = [off(said_and_shown::<f64>(bytes, 40)), off(said_and_shown::<f32>(bytes, 40))];
        assert!(double < 1e-13 && single < 5e-6, "{double} {single}");
    }
    // Without the patch contacts that share a facet are not shown as the operator has them.
    assert!(off(said_and_shown::<f64>(&alone(patched()), 40)) > 1e-2);
}

#[test]
fn the_operator_is_semidefinite() {
    for bytes in [patched(), filtered()] {
        let (w, ..) = said_and_shown::<f64>(bytes, 40);
        let matrix = Mat::from_fn(120, 120, |i, j| w[120 * i + j]);
        assert!((0..120).all(|i| (0..i).all(|j| w[120 * i + j].to_bits() == w[120 * j + i].to_bits())));
        let values = matrix.self_adjoint_eigenvalues(faer::Side::Lower).expect("converged");
        let (least, most) = (values[0], values[119]);
        println!("eigenvalues from {least:.2e} to {most:.2e} m/N");
        assert!(least > -1e-12 * most, "{least} {most}");
    }
}

#[test]
fn one_contact_has_the_bits_that_it_has_without_a_patch() {
    let lone = alone(patched());
    for point in places(patched(), 12) {
        let bits = |bytes: &[u8]| {
            with_body::<f64, _>(bytes, |body| {
                let mut w = [0.0; 9];
                body.compliance(&[point], &mut w).expect("an operator");
                body.push(&point, [1.0, 2.0, -3.0]).expect("a push");
                let mut shown = vec![];
                for _ in 0..5 {
                    body.step().expect("a step");
                    shown.extend(body.point(&point, Field::Displacement).expect("a point"));
                    shown.push(body.energy().expect("an energy"));
                }
                w.into_iter().chain(shown).collect::<Vec<_>>()
            })
        };
        let (with, without) = (bits(patched()), bits(&lone));
        for (a, b) in with.iter().zip(&without) {
            // Sums in another order; nothing of the physics differs.
            assert!((a - b).abs() <= 1e-14 * a.abs().max(1e-9), "{a} {b}");
        }
        assert_eq!(with[..9], without[..9]);
    }
}

#[test]
fn nodes_surface_and_saved_bodies_agree() {
    let points = places(patched(), 9);
    for bytes in [patched(), filtered()] {
        with_body::<f64, _>(bytes, |body| {
            let file = *body.file();
            for point in &points {
                body.push(point, [0.3, -0.2, -1.0]).expect("a push");
            }
            for _ in 0..4 {
                body.step().expect("a step");
            }
            let mut surface = vec![0.0; 3 * file.metadata().n_surface_nodes as usize];
            body.surface_into(Field::Displacement, &mut surface).expect("a surface");
            let largest = surface.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            for node in 0..file.metadata().n_load_nodes {
                let one = body.node(node as usize, Field::Displacement).expect("a node");
                let place = body.point(&Place::node(node), Field::Displacement).expect("a node");
                for (c, value) in one.into_iter().enumerate() {
                    assert!((value - surface[3 * node as usize + c]).abs() < 1e-14 * largest);
                    assert!((value - place[c]).abs() < 1e-15 * largest);
                }
            }
            let mut saved = vec![0; body.saved_len()];
            let used = body.save_into(&mut saved).expect("saved");
            let (energy, shown) = (body.energy(), body.point(&points[2], Field::Displacement));
            body.rest();
            body.restore(&saved[..used]).expect("restored");
            assert_eq!((body.energy(), body.point(&points[2], Field::Displacement)), (energy, shown));
        });
    }
}
