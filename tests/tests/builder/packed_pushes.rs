//! A packed file under a finger: fields, the displacement under a contact, stress and reactions keep the
//! tolerance for pushes anywhere on the surface, beside a support too.

use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_build::linalg::Random;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::{Field, Place, SceneOptions, Simulation};
use vademecum_format::{File, SectionKind};
use vademecum_rewrite::{DECODED_LIMIT, pack_within, unpack};

const BEAM: &str = r#"
[mesh]
block = { lengths = [0.2, 0.02, 0.03], divisions = [20, 2, 3] }
[[material]]
young = 2e8
poisson = 0.3
density = 1000.0
[damping]
ratio = 0.05
[[support]]
name = "wall"
on = { group = "x_min" }
[time]
step = 5e-4
[basis]
modes = 16
[output]
stress = "surface"
stress_residual = false
reactions = true
[tolerance]
error = 1.0
"#;

/// Series of a push: displacement of the body and of the pushed point, stress at all points, reactions.
fn pushed(bytes: &[u8], place: &Place, force: [f64; 3]) -> [Vec<f64>; 4] {
    let mut body = Simulation::<f64>::new(bytes.to_vec(), &SceneOptions::default()).expect("opened");
    let (nodes, points) = (body.file().metadata().n_nodes as usize, body.scene().n_stress_points());
    let mut out: [Vec<f64>; 4] = Default::default();
    let mut field = vec![0.0; 3 * nodes];
    for step in 1..=60 {
        body.clear();
        body.push(place, force.map(|f| f * (f64::from(step) / 40.0).min(1.0))).expect("pushed");
        body.step(1).expect("a step");
        if step % 4 == 0 {
            body.body_into(Field::Displacement, &mut field).expect("the body");
            out[0].extend(&field);
            out[1].extend(body.point(place, Field::Displacement).expect("the point"));
            (0..points).for_each(|point| out[2].extend(body.stress(point).expect("a stress").0));
            let reaction = body.reaction(0).expect("a reaction");
            out[3].extend(&reaction.total()[..3]);
        }
    }
    out
}

fn root(x: impl Iterator<Item = f64>) -> f64 {
    x.map(|x| x * x).sum::<f64>().sqrt()
}

#[test]
fn random_pushes_keep_the_tolerance_of_a_packed_file() {
    let problem = Problem::parse(BEAM, "beam.toml", PathBuf::new()).expect("a problem");
    let bytes = build(&problem, &BuildOptions::default(), &Silent).expect("built").either().bytes;
    let file = File::parse(&bytes).expect("a file");
    let corners = file.section(SectionKind::Triangles).expect("triangles");
    let corners: Vec<u32> = corners.u32s().expect("numbers").iter().map(|b| u32::from_le_bytes(*b)).collect();
    let triangles = file.metadata().n_load_triangles as usize;
    let mut random = Random::new(5);
    let mut pushes: Vec<(Place, [f64; 3])> = (0..20)
        .map(|_| {
            let t = ((random.uniform() * triangles as f64) as usize).min(triangles - 1);
            let force = [(); 3].map(|()| random.uniform() - 0.5);
            (
                Place::triangle([corners[3 * t], corners[3 * t + 1], corners[3 * t + 2]], [0.2, 0.3, 0.5]),
                force,
            )
        })
        .collect();
    // Beside the support, where rows of the basis are small beside those of the tip.
    let near = Simulation::<f64>::new(bytes.clone(), &SceneOptions::default()).expect("opened");
    pushes.push((near.locate([0.02, 0.01, 0.03]).expect("a place").place, [0.0, 0.0, -1.0]));
    for tolerance in [1e-2, 1e-3, 1e-4] {
        let packed =
            unpack(&pack_within(&bytes, 3, tolerance).expect("packed"), DECODED_LIMIT).expect("unpacked");
        for (place, force) in &pushes {
            let (exact, rounded) = (pushed(&bytes, place, *force), pushed(&packed, place, *force));
            let off = |k: usize| exact[k].iter().zip(&rounded[k]).map(|(a, b)| a - b);
            for (k, name) in [(0, "field"), (1, "under the contact"), (3, "reaction")] {
                let error = root(off(k)) / root(exact[k].iter().copied());
                assert!(error <= tolerance, "{name} {place:?} {force:?}: {error:e} for {tolerance:e}");
            }
            let largest = |x: &mut dyn Iterator<Item = f64>| x.fold(0.0, |m: f64, x| m.max(x.abs()));
            let stress = largest(&mut off(2)) / largest(&mut exact[2].iter().copied());
            assert!(stress <= tolerance, "stress {place:?}: {stress:e} for {tolerance:e}");
        }
    }
}
