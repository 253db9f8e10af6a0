use super::disc::raised_load;
use super::iterate::compliance_change;
use super::*;
use crate::input::Problem;
use crate::mesh::surface::Surface;
use crate::prepared::prepare;
use crate::progress::{Silent, Stopwatch};

fn prepared(lengths: [f64; 3], divisions: [usize; 3], order: &str, rest: &str) -> Prepared {
    let text = format!(
        "[mesh]\nblock = {{ lengths = {lengths:?}, divisions = {divisions:?}, order = \"{order}\" }}\n\
         [[material]]\nyoung = 1e7\npoisson = 0.3\ndensity = 1000.0\n[time]\nstep = 1e-4\n{rest}"
    );
    let problem = Problem::parse(&text, "block.toml", std::path::PathBuf::new()).expect("a problem");
    prepare(&problem, &mut Stopwatch::new(&Silent), &Silent).expect("a model")
}

fn known(prepared: &Prepared, disc: DiscRequest) -> DiscretisationError {
    match estimate(prepared, None, disc, &Silent).expect("an estimate") {
        MeshEstimate::Known(error) => error,
        MeshEstimate::Unknown { reason } => panic!("{reason}"),
    }
}

const CLAMPED: &str = "[[support]]\non = { group = \"x_min\" }\n";

/// Against meshes that are refined twice and quadratic: their own error is a tenth of the coarse one.
#[test]
fn frequencies_are_estimated_within_a_factor_of_two() {
    for (lengths, divisions, rest) in [
        ([1.0, 0.1, 0.12], [6, 1, 1], CLAMPED),
        ([0.4, 0.3, 0.3], [2, 2, 2], CLAMPED),
        ([0.5, 0.4, 0.05], [4, 3, 1], ""),
    ] {
        let fine = prepared(lengths, divisions.map(|n| 4 * n), "quadratic", rest);
        let pencil = fine.body.model.pencil();
        let truth = lowest_modes(pencil, &fine.symbolic, FREQUENCIES).unwrap().frequencies_hz();
        for order in ["linear", "quadratic"] {
            let found = known(&prepared(lengths, divisions, order, rest), DiscRequest::None);
            assert!(!found.smooth_rim && found.nodes_without_area == 0);
            for (value, truth) in found.frequencies.iter().zip(&truth) {
                let ratio = value.error / (value.mesh / truth - 1.0);
                assert!((0.5..2.0).contains(&ratio), "{lengths:?} {order}: {value:?} for {truth}");
                assert!((value.refined / truth - 1.0).abs() < 0.6 * (value.mesh / truth - 1.0));
                assert!(value.bound > value.error);
            }
        }
    }
}

fn compliance(prepared: &Prepared, disc: &DiscLoad) -> (f64, f64) {
    let (body, pencil) = (&prepared.body, prepared.body.model.pencil());
    let space = RaisedSpace::new(&body.model);
    let factor = prepared.symbolic.factor_of(pencil.stiffness()).unwrap();
    let load = raised_load(&space, body, disc, &Surface::of(body.model.mesh())).expect("a traction");
    // One newton along the normal.
    let (mesh, change) = compliance_change(&space, &factor, &load, &Silent).unwrap();
    (mesh, change.values[0])
}

#[test]
fn a_displacement_under_a_traction_is_estimated_within_a_factor_of_two() {
    let (lengths, divisions) = ([1.0, 0.2, 0.2], [6, 1, 1]);
    let disc = DiscLoad { point: [0.9, 0.1, 0.2], normal: [0.0, 0.0, 1.0], radius: 0.15 };
    let (fine, g) = compliance(&prepared(lengths, divisions.map(|n| 4 * n), "quadratic", CLAMPED), &disc);
    let truth = fine + 1.45 * g;
    for (order, scale) in [("linear", 1.1), ("quadratic", 1.45)] {
        let (mesh, g) = compliance(&prepared(lengths, divisions, order, CLAMPED), &disc);
        let ratio = scale * g / (truth - mesh);
        assert!((0.5..2.0).contains(&ratio), "{order}: {mesh} + {} for {truth}", scale * g);
    }
    let found = known(&prepared(lengths, divisions, "quadratic", CLAMPED), DiscRequest::Radius(Some(0.15)));
    let small = known(&prepared(lengths, divisions, "quadratic", CLAMPED), DiscRequest::Radius(Some(1e-3)));
    assert!(
        small.displacement.expect("a small disc").value.error < 0.0 && small.frequencies.len() == FREQUENCIES
    );
    let displacement = found.displacement.expect("a traction");
    assert_eq!(displacement.disc.radius, 0.15);
    assert!(displacement.value.error < 0.0 && displacement.value.refined > displacement.value.mesh);
}

#[test]
fn supports_without_area_have_no_estimate() {
    let edges = "[[support]]\non = { box = { min = [-1.0, -1.0, -0.001], max = [0.001, 1.0, 0.001] } }\n\
                 [[support]]\non = { box = { min = [0.999, -1.0, -0.001], max = [1.001, 1.0, 0.001] } }\n";
    let body = prepared([1.0, 0.3, 0.3], [4, 2, 2], "linear", edges);
    let found = estimate(&body, None, DiscRequest::None, &Silent).unwrap();
    let MeshEstimate::Unknown { reason } = found else { panic!("{found:?}") };
    assert!(reason.contains("6 held nodes and no held face"), "{reason}");
    // Beside a clamped face they are counted.
    let both = format!(
        "{CLAMPED}[[support]]\non = {{ box = {{ min = [0.999, -1.0, -0.001], max = [1.001, 1.0, 0.001] }} }}\n"
    );
    let body = prepared([1.0, 0.3, 0.3], [4, 2, 2], "linear", &both);
    assert_eq!(known(&body, DiscRequest::None).nodes_without_area, 3);
}

#[test]
fn a_support_that_ends_inside_a_face_is_seen() {
    let part = "[[support]]\non = { box = { min = [-1.0, -1.0, -0.001], max = [0.501, 1.0, 0.001] } }\n";
    let body = prepared([1.0, 0.5, 0.2], [4, 2, 1], "quadratic", part);
    assert!(known(&body, DiscRequest::None).smooth_rim);
    assert_eq!(support_shape(&body.body.model).rim, Rim::PartlySmooth);
    let patch = part
        .replace("[-1.0, -1.0, -0.001]", "[0.249, 0.124, -0.001]")
        .replace("1.0, 0.001]", "0.376, 0.001]");
    let body = prepared([1.0, 0.5, 0.2], [4, 4, 1], "linear", &patch);
    assert_eq!(support_shape(&body.body.model).rim, Rim::Smooth);
    // A support of whole elements ends at the face behind it, which meets the surface at an angle.
    let deep = "[[support]]\non = { box = { min = [-1.0, -1.0, -1.0], max = [0.251, 1.0, 1.0] } }\n";
    let body = prepared([1.0, 0.5, 0.2], [4, 2, 1], "quadratic", deep);
    assert!(!known(&body, DiscRequest::None).smooth_rim);
}
