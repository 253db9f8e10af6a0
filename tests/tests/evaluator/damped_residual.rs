//! Residual flexibility under stiffness-proportional damping: a file of few modes against one of all modes.

use std::sync::OnceLock;

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::{
    BindError, BodyOptions, Contact, Field, Place, Restored, Scene, SceneOptions, Simulation, Status,
    StepError, Surface, SurfacePoint,
};
use vademecum_format::File;
use vademecum_tests::program::repository;
use vademecum_tests::stage::with_scene;

const DT: f64 = 1e-3;
const STEPS: usize = 60;

/// A cube with so many modes and this `β`; it has 144 degrees of freedom.
fn cube(modes: usize, beta: f64) -> Vec<u8> {
    let text = format!(
        r#"
[mesh]
block = {{ lengths = [0.1, 0.1, 0.1], divisions = [3, 3, 3] }}
[[material]]
young = 1e5
poisson = 0.3
density = 1000.0
[[support]]
on = {{ group = "x_min" }}
[[load.pattern]]
name = "gravity"
acceleration = [0.0, 0.0, -9.81]
[time]
step = {DT}
[damping]
beta = {beta:e}
[basis]
kind = "modes"
modes = {modes}
[output]
precision = "f64"
stress = {{ box = {{ min = [0.0, 0.0, 0.0], max = [0.04, 0.1, 0.1] }} }}
[[output.probe]]
name = "corner"
point = [0.1, 0.1, 0.1]
direction = [0.0, 0.0, 1.0]
"#
    );
    let problem = Problem::parse(&text, "p.toml", repository()).expect("a problem");
    build(&problem, &BuildOptions::default(), &Silent).expect("built").either().bytes
}

/// `β` of a first mode with a few per cent of critical damping, and of one that hardly swings.
const BETAS: [f64; 2] = [2e-3, 2e-2];

fn few() -> &'static [Vec<u8>; 2] {
    static FILES: OnceLock<[Vec<u8>; 2]> = OnceLock::new();
    FILES.get_or_init(|| BETAS.map(|beta| cube(30, beta)))
}

fn all() -> &'static [Vec<u8>; 2] {
    static FILES: OnceLock<[Vec<u8>; 2]> = OnceLock::new();
    FILES.get_or_init(|| BETAS.map(|beta| cube(144, beta)))
}

fn finger(bytes: &[u8]) -> SurfacePoint {
    let file = File::parse(bytes).expect("a file");
    Surface::new(&file).expect("a surface").locate([0.08, 0.03, 0.1]).expect("a place")
}

const FORCE: [f64; 3] = [0.3, 1.0, -2.0];

/// Histories of the finger's force: held from the start, in and out of two ramps, a tap.
fn factor(history: usize, t: f64) -> f64 {
    let seconds = STEPS as f64 * DT;
    match history {
        0 => 1.0,
        1 => (5.0 * t / seconds).min(1.0) - (5.0 * t / seconds - 3.0).clamp(0.0, 1.0),
        _ => f64::from(u8::from(t < 10.5 * DT)),
    }
}

/// Displacement under the finger, of the probe, and stress at a point after each step.
fn shown(bytes: &[u8], options: &SceneOptions, history: usize, add_again: bool) -> [Vec<f64>; 3] {
    let at = finger(bytes);
    with_scene::<f64, _>(bytes, options, |scene, state, loads| {
        let mut shown = [vec![], vec![], vec![]];
        for n in 0..STEPS {
            let ends = [n as f64 * DT, (n + 1) as f64 * DT];
            // A tap ends between two steps.
            let [a, b] =
                if history == 2 { [factor(2, ends[0]); 2] } else { ends.map(|t| factor(history, t)) };
            if n == 0 || history > 0 || add_again {
                loads.clear();
                loads
                    .add_contact_staged(scene, &Contact::new(at.place, FORCE), &[a, b, 0.0, 0.0])
                    .expect("added");
                loads.add_pattern_staged(scene, 0, &[0.1 * a, 0.1 * b, 0.0, 0.0]).expect("added");
            }
            scene.step(state, loads).expect("a step");
            let [under, probe, stress] = &mut shown;
            under.extend(scene.point(state, &at, Field::Displacement).expect("a place"));
            probe.push(scene.probe(state, 0, Field::Displacement).expect("a probe"));
            stress.extend(scene.stress(state, 3).expect("a point").0);
        }
        shown
    })
}

fn error(found: &[f64], right: &[f64]) -> f64 {
    let norm = |all: &mut dyn Iterator<Item = f64>| all.map(|x| x * x).sum::<f64>().sqrt();
    norm(&mut found.iter().zip(right).map(|(a, b)| a - b)) / norm(&mut right.iter().copied())
}

#[test]
fn few_modes_with_the_filter_show_what_all_modes_do() {
    for history in 0..3 {
        for ((few, all), share) in few().iter().zip(all()).zip([0.5, 0.03]) {
            let options = SceneOptions::default();
            let right = shown(all, &options, history, false);
            let found = shown(few, &options, history, false);
            let modes = shown(few, &SceneOptions { residual: false, ..options }, history, false);
            // Left is the inertia of the modes that the file does not have, which strong damping hides.
            for kind in 0..3 {
                let [with, without] = [&found, &modes].map(|of| error(&of[kind], &right[kind]));
                println!("history {history} output {kind}: {with:.1e}, modes alone {without:.1e}");
                assert!(with < share * without, "{history} {kind}: {with:e}, modes alone {without:e}");
            }
        }
    }
}

#[test]
fn a_contact_that_is_added_again_in_each_step_is_the_one_that_stays() {
    for bytes in few() {
        let [held, again] = [false, true].map(|again| shown(bytes, &SceneOptions::default(), 0, again));
        assert_eq!(held, again);
    }
}

#[test]
fn saved_states_hold_the_filter() {
    for bytes in few() {
        let bytes: &'static [u8] = Vec::leak(bytes.clone());
        let at = finger(bytes);
        let options = BodyOptions { scene: SceneOptions::default(), ..BodyOptions::default() };
        let mut body = Simulation::<f64>::with_options(bytes, &options).expect("bound");
        body.push(&at, FORCE).expect("pushed");
        body.step(7).expect("stepped");
        body.clear();
        body.step(2).expect("stepped");
        let saved = body.with_body(|body| {
            let mut bytes = vec![0; body.saved_len()];
            let written = body.save_into(&mut bytes).expect("saved");
            bytes.truncate(written);
            bytes
        });
        body.step(5).expect("stepped");
        let once = body.point(&at, Field::Displacement).expect("a place");
        body.rest();
        assert_eq!(body.with_body(|body| body.restore(&saved)), Ok(Restored::AsSaved));
        body.step(5).expect("stepped");
        assert_eq!(body.point(&at, Field::Displacement).expect("a place"), once);
        // Without damping the filter is read over.
        let plain = BodyOptions { scene: SceneOptions { beta: Some(0.0), ..options.scene }, ..options };
        let mut plain = Simulation::<f64>::with_options(bytes, &plain).expect("bound");
        assert_eq!(plain.with_body(|body| body.restore(&saved)), Ok(Restored::Carried));
    }
}

#[test]
fn a_body_rests_once_its_residual_has_followed() {
    let bytes = &few()[1];
    let at = finger(bytes);
    let options = SceneOptions { rest_below: 1e300, ..SceneOptions::default() };
    with_scene::<f64, _>(bytes, &options, |scene, state, loads| {
        loads.add_contact(scene, &Contact::new(at.place, FORCE)).expect("added");
        for _ in 0..100 {
            scene.step(state, loads).expect("a step");
        }
        loads.clear();
        let mut steps = 0;
        while scene.step(state, loads) == Ok(Status::Moving) {
            steps += 1;
            assert!(steps < 1000, "never at rest");
        }
        // exp(−t/β) = 1e-12 after 27.6 β.
        assert!((steps as f64 * DT / BETAS[1] - 27.6).abs() < 0.5, "{steps} steps");
        assert_eq!(scene.point(state, &at, Field::Displacement), Ok([0.0; 3]));
    });
}

#[test]
fn the_operator_of_contacts_is_the_step() {
    for bytes in few() {
        let at = finger(bytes);
        with_scene::<f64, _>(bytes, &SceneOptions::default(), |scene, state, loads| {
            let contact = Contact::new(at.place, FORCE);
            loads.add_contact(scene, &contact).expect("added");
            for _ in 0..5 {
                scene.step(state, loads).expect("a step");
            }
            loads.clear();
            let (mut w, mut free) = ([0.0; 9], [[0.0; 3]]);
            let mut work = vec![0.0; scene.compliance_work(1)];
            scene.compliance(&[contact], &mut w, &mut work).expect("an operator");
            scene.free_motion(state, loads, &[contact], &mut free, &mut work).expect("a motion");
            loads.add_contact(scene, &contact).expect("added");
            scene.step(state, loads).expect("a step");
            let moved = scene.point(state, &at, Field::Displacement).expect("a place");
            for (i, moved) in moved.into_iter().enumerate() {
                let said = free[0][i] + (0..3).map(|j| w[3 * i + j] * FORCE[j]).sum::<f64>();
                assert!((said - moved).abs() < 1e-12 * at.distance.max(moved.abs()), "{said:e} {moved:e}");
            }
        });
    }
}

/// Energy that the residual stores: what the outputs of a scene with it have above those of one without.
fn stored(bytes: &[u8], forces: &[[f64; 3]]) -> Vec<f64> {
    let of = |residual| {
        let options = SceneOptions { residual, ..SceneOptions::default() };
        let places = [[0.1, 0.0, 0.0], [0.1, 0.1, 0.1]].map(|corner| {
            let file = File::parse(bytes).expect("a file");
            Surface::new(&file).expect("a surface").locate(corner).expect("a place").place
        });
        with_scene::<f64, _>(bytes, &options, |scene, state, loads| {
            let mut energies = vec![];
            for force in forces {
                loads.clear();
                for (place, sign) in places.iter().zip([1.0, -0.5]) {
                    let contact = Contact::new(*place, force.map(|f| sign * f));
                    loads.add_contact(scene, &contact).expect("added");
                }
                scene.step(state, loads).expect("a step");
                energies.push(scene.strain_energy(state).expect("an energy"));
            }
            energies
        })
    };
    of(true).into_iter().zip(of(false)).map(|(with, without)| with - without).collect()
}

#[test]
fn the_residual_gives_away_what_the_proof_says() {
    // Contacts at two corners share no triangle, so `R` is their own; it is found from a force that stays.
    let bytes = &few()[0];
    let e = (-DT / BETAS[0]).exp();
    let unit = |force: [f64; 3]| *stored(bytes, &vec![force; 200]).last().expect("an energy");
    // ½ fᵀRf of any force, by the parallelogram of three and six of them.
    let (x, z, xz) = (unit([1.0, 0.0, 0.0]), unit([0.0, 0.0, 1.0]), unit([1.0, 0.0, 1.0]));
    let half = |[a, c]: [f64; 2]| a * a * x + c * c * z + a * c * (xz - x - z);
    let forces: Vec<[f64; 3]> = (0..12).map(|n| [(n % 3) as f64, 0.0, (n % 5) as f64 - 2.0]).collect();
    let energies = stored(bytes, &forces);
    let (mut y, mut before) = ([0.0; 2], 0.0);
    for (force, energy) in forces.iter().zip(energies) {
        let f = [force[0], force[2]];
        let d = [f[0] - y[0], f[1] - y[1]];
        let product = |a: [f64; 2], b: [f64; 2]| {
            half([a[0] + b[0], a[1] + b[1]]) - half(a) - half(b) // aᵀRb
        };
        let work = (1.0 - e) * product(f, d);
        let lost = work - (energy - before);
        let said = (1.0 - e) * (1.0 + e) * half(d);
        assert!((lost - said).abs() < 1e-9 * (said + energy), "{lost:e} {said:e}");
        assert!(lost > -1e-12 * energy);
        y = [0, 1].map(|i| e * y[i] + (1.0 - e) * f[i]);
        before = energy;
    }
}

#[test]
fn a_full_list_of_filtered_nodes_is_refused_and_changes_nothing() {
    let bytes = &few()[1];
    let options = SceneOptions { filtered_nodes: Some(3), ..SceneOptions::default() };
    let other = Place::new(&[0], &[1.0]).expect("a place");
    with_scene::<f64, _>(bytes, &options, |scene, state, loads| {
        let at = finger(bytes);
        loads.add_contact(scene, &Contact::new(at.place, FORCE)).expect("added");
        scene.step(state, loads).expect("a step");
        loads.clear();
        loads.add_contact(scene, &Contact::new(other, FORCE)).expect("added");
        let before = state.zeta().to_vec();
        assert_eq!(scene.step(state, loads), Err(StepError::TooManyNodes { nodes: 3 }));
        assert_eq!(state.zeta(), before);
        // 28 β later the first contact is forgotten.
        loads.clear();
        for _ in 0..600 {
            scene.step(state, loads).expect("a step");
        }
        loads.add_contact(scene, &Contact::new(other, FORCE)).expect("added");
        scene.step(state, loads).expect("a step");
    });
}

#[test]
fn a_scene_without_a_filter_takes_no_damping_later() {
    let bytes = &few()[0];
    let file = File::parse(bytes).expect("a file");
    let options = SceneOptions { beta: Some(0.0), ..SceneOptions::default() };
    let sizes = Scene::<f64>::sizes(&file, &options).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let mut scene = Scene::bind(&file, &options, &mut memory, &mut work).expect("bound");
    let damped = SceneOptions { beta: Some(1e-3), ..options };
    assert_eq!(scene.rebind(&damped, &mut work), Err(BindError::NoFilter));
    assert_eq!(scene.rebind(&options, &mut work), Ok(()));
}
