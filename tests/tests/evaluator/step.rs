//! The fused step against the printed schemes, its long run, its precision and its promises about states and
//! loads.

use vademecum_eval::{
    BindError, Contact, Field, LoadError, Place, Scene, SceneOptions, Status, StepError, Structure,
    StructureChoice,
};
use vademecum_format::scheme::{MAX_STAGES, SchemeTable, StepParameters};
use vademecum_format::{Element, File};
use vademecum_tests::stage::with_scene;
use vademecum_tests::synthetic::{Body, Layout, bathe, newmark};
use vademecum_tests::textbook::Textbook;

const LAYOUT: Layout = Layout { rows: 3, load_rows: 2, columns: 3, n_interior: 3, r: 6 };

fn parameters() -> StepParameters {
    StepParameters { time_step: 5e-3, alpha: 0.3, beta: 2e-5, density: 1.0, stiffness: 1.0 }
}

fn contact() -> Contact {
    Contact::new(Place::triangle([1, 4, 3], [0.2, 0.5, 0.3]), [1.0, -2.0, 0.7])
}

/// The contact as forces on dofs.
fn on_dofs(contact: &Contact, amplitude: f64) -> Vec<(usize, f64)> {
    let nodes = contact.place.entries();
    nodes
        .flat_map(|(node, w)| (0..3).map(move |c| (3 * node as usize + c, w * amplitude * contact.force[c])))
        .collect()
}

/// The synthetic load pattern as forces on dofs.
fn pattern(amplitude: f64) -> Vec<(usize, f64)> {
    let last = 3 * LAYOUT.n_nodes() - 3;
    (0..3).flat_map(|c| [(c, amplitude), (last + c, 2.0 * amplitude)]).collect()
}

fn options(structure: StructureChoice) -> SceneOptions {
    SceneOptions { structure, ..SceneOptions::default() }
}

/// Largest difference of ζ over 300 steps, relative to the largest ζ; the load is a ramp of contact and
/// pattern, then nothing.
fn distance(
    bytes: &[u8],
    options: &SceneOptions,
    scheme: &SchemeTable,
    mut book: Textbook,
    march: impl Fn(&mut Textbook, &[Vec<f64>; 3]),
) -> f64 {
    with_scene::<f64, f64>(bytes, options, |scene, state, loads| {
        let (mut worst, mut largest) = (0.0f64, 0.0f64);
        for n in 0..300 {
            let amplitude = |instant: f64| {
                if n < 40 { 0.1 * (f64::from(n) + instant) } else { 0.0 }
            };
            let at = scheme.instants().map(amplitude);
            loads.clear();
            loads.add_contact_staged(scene, &contact(), &at).expect("contact");
            loads.add_pattern_staged(scene, 0, &at.map(|a| 0.3 * a)).expect("pattern");
            scene.step(state, loads).expect("step");
            let forces = [0, 1, 2].map(|stage: usize| {
                let mut dofs = on_dofs(&contact(), at[stage]);
                dofs.extend(pattern(0.3 * at[stage]));
                book.force(&dofs)
            });
            march(&mut book, &forces);
            for (a, b) in state.zeta().iter().zip(&book.state[0]) {
                worst = worst.max((a - b).abs());
                largest = largest.max(b.abs());
            }
        }
        worst / largest
    })
}

/// The printed formulas subtract displacements and divide by Δt²: each step of the *reference* loses about
/// ε/(ωΔt)², 1e-14 at ω Δt = 0.15, over 300 steps and with the second-order growth of such errors 300²/2 of
/// them at most: 5e-10.
const REFERENCE_LOSS: f64 = 5e-10;

#[test]
fn fused_step_is_the_printed_bathe_step() {
    let body = Body::open(LAYOUT, 1);
    let (scheme, step) = (bathe(), parameters());
    let bytes = body.file(&scheme, &step, Element::F64);
    for (structure, book) in [
        (StructureChoice::Diagonal, Textbook::galerkin(&body, step)),
        (StructureChoice::Block, Textbook::projected(&body, step)),
    ] {
        let march = |book: &mut Textbook, forces: &[Vec<f64>; 3]| book.bathe(&forces[1], &forces[2]);
        let error = distance(&bytes, &options(structure), &scheme, book, march);
        assert!(error < REFERENCE_LOSS, "{structure:?}: {error:e}");
    }
}

#[test]
fn fused_step_is_the_printed_newmark_step() {
    let body = Body::open(LAYOUT, 2);
    for (b, g) in [(0.25, 0.5), (0.3025, 0.6)] {
        let (scheme, step) = (newmark(b, g), parameters());
        let bytes = body.file(&scheme, &step, Element::F64);
        for (structure, book) in [
            (StructureChoice::Diagonal, Textbook::galerkin(&body, step)),
            (StructureChoice::Block, Textbook::projected(&body, step)),
        ] {
            let march = |book: &mut Textbook, forces: &[Vec<f64>; 3]| book.newmark(b, g, &forces[1]);
            let error = distance(&bytes, &options(structure), &scheme, book, march);
            assert!(error < REFERENCE_LOSS, "{structure:?} {b} {g}: {error:e}");
        }
    }
}

#[test]
fn the_two_structures_differ_on_an_open_basis() {
    // Otherwise the tests above would not tell one from the other.
    let body = Body::open(LAYOUT, 1);
    let (scheme, step) = (bathe(), parameters());
    let bytes = body.file(&scheme, &step, Element::F64);
    let march = |book: &mut Textbook, forces: &[Vec<f64>; 3]| book.bathe(&forces[1], &forces[2]);
    let book = Textbook::projected(&body, step);
    let error = distance(&bytes, &options(StructureChoice::Diagonal), &scheme, book, march);
    assert!(error > 1e-6, "{error:e}");
}

#[test]
fn diagonal_scene_takes_any_parameters() {
    let body = Body::open(LAYOUT, 3);
    let scheme = bathe();
    let bytes = body.file(&scheme, &parameters(), Element::F64);
    let other = StepParameters { time_step: 2e-3, alpha: 1.5, beta: 1e-4, density: 0.7, stiffness: 2.5 };
    let options = SceneOptions {
        time_step: Some(2e-3),
        alpha: Some(1.5),
        beta: Some(1e-4),
        density: 0.7,
        stiffness: 2.5,
        ..options(StructureChoice::Diagonal)
    };
    let march = |book: &mut Textbook, forces: &[Vec<f64>; 3]| book.bathe(&forces[1], &forces[2]);
    let error = distance(&bytes, &options, &scheme, Textbook::galerkin(&body, other), march);
    assert!(error < REFERENCE_LOSS, "{error:e}");
}

#[test]
fn block_scene_names_what_it_was_not_built_for() {
    let bytes = Body::open(LAYOUT, 3).file(&bathe(), &parameters(), Element::F64);
    let file = File::parse(&bytes).expect("a file");
    let changed = SceneOptions { stiffness: 1.1, ..options(StructureChoice::Block) };
    let sizes = Scene::<f64>::sizes(&file, &changed).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let refused = Scene::bind(&file, &changed, &mut memory, &mut work);
    assert!(matches!(refused, Err(BindError::Fixed { stage: 0, .. })), "{refused:?}");
    // The same scale on both leaves θ alone.
    let both = SceneOptions { density: 1.1, ..changed };
    let scene = Scene::bind(&file, &both, &mut memory, &mut work).expect("same theta");
    assert_eq!(scene.structure(), Structure::Block);
}

#[test]
fn single_precision_stays_near_double() {
    // The bound is the project's: 2e-3 after 2e5 steps (an f32 march with printed formulas reaches 35 to 150
    // %).
    let layout = Layout { r: 8, ..LAYOUT };
    let step = StepParameters { time_step: 1e-3, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 };
    let bytes = Body::open(layout, 4).file(&newmark(0.25, 0.5), &step, Element::F64);
    for structure in [StructureChoice::Diagonal, StructureChoice::Block] {
        let single = with_scene::<f32, Vec<f64>>(&bytes, &options(structure), |scene, state, loads| {
            loads.add_contact(scene, &contact()).expect("contact");
            for _ in 0..200_000 {
                scene.step(state, loads).expect("step");
            }
            state.zeta().iter().map(|&z| f64::from(z)).collect()
        });
        let double = with_scene::<f64, Vec<f64>>(&bytes, &options(structure), |scene, state, loads| {
            loads.add_contact(scene, &contact()).expect("contact");
            for _ in 0..200_000 {
                scene.step(state, loads).expect("step");
            }
            state.zeta().to_vec()
        });
        let norm = double.iter().map(|z| z * z).sum::<f64>().sqrt();
        let apart = single.iter().zip(&double).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        println!("{structure:?}: f32 - f64 = {:.2e}", apart / norm);
        assert!(apart <= 2e-3 * norm, "{structure:?}: {:e}", apart / norm);
    }
}

#[test]
fn ten_million_steps_stay_bounded() {
    let layout = Layout { r: 8, ..LAYOUT };
    let step = StepParameters { time_step: 1e-3, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 };
    let bytes = Body::open(layout, 5).file(&newmark(0.25, 0.5), &step, Element::F64);
    with_scene::<f64, ()>(&bytes, &options(StructureChoice::Diagonal), |scene, state, loads| {
        loads.add_contact(scene, &contact()).expect("contact");
        for _ in 0..100 {
            scene.step(state, loads).expect("step");
        }
        loads.clear();
        scene.step(state, loads).expect("step");
        let released = scene.energy(state).expect("energy");
        let mut largest = 0.0f64;
        for n in 0..10_000_000 {
            scene.step(state, loads).expect("step");
            if n % 1000 == 0 {
                largest = largest.max(scene.energy(state).expect("energy") / released);
            }
        }
        println!("largest energy over energy at release: {largest}");
        // The project's bound; the trapezoidal rule conserves this energy, so what is seen is rounding.
        assert!(largest < 1.05 && largest > 0.95, "{largest}");
    });
}

#[test]
fn a_saved_state_comes_back_bit_for_bit() {
    let bytes = Body::open(LAYOUT, 6).file(&bathe(), &parameters(), Element::F32);
    for structure in [StructureChoice::Diagonal, StructureChoice::Block] {
        with_scene::<f32, ()>(&bytes, &options(structure), |scene, state, loads| {
            let run = |state: &mut vademecum_eval::State<'_, f32>, loads: &vademecum_eval::Loads<'_, f32>| {
                (0..100).for_each(|_| {
                    scene.step(state, loads).expect("step");
                });
                let mut end = [0.0f32; 18];
                state.save_into(&mut end).expect("length");
                end.map(f32::to_bits)
            };
            loads.add_contact(scene, &contact()).expect("contact");
            run(state, loads);
            let mut saved = [0.0f32; 18];
            state.save_into(&mut saved).expect("length");
            let first = run(state, loads);
            state.restore(&saved).expect("restore");
            assert_eq!(first, run(state, loads));
            assert_eq!(state.restore(&saved[..17]), Err(StepError::Mismatch));
        });
    }
}

#[test]
fn what_is_not_finite_is_refused_and_changes_nothing() {
    let bytes = Body::open(LAYOUT, 7).file(&bathe(), &parameters(), Element::F32);
    for structure in [StructureChoice::Diagonal, StructureChoice::Block] {
        with_scene::<f32, ()>(&bytes, &options(structure), |scene, state, loads| {
            loads.add_contact(scene, &contact()).expect("contact");
            scene.step(state, loads).expect("step");
            let (mut before, mut after) = ([0.0f32; 18], [0.0f32; 18]);
            state.save_into(&mut before).expect("length");
            for bad in [f64::NAN, f64::INFINITY] {
                let force = Contact { force: [0.0, bad, 0.0], ..contact() };
                assert_eq!(loads.add_contact(scene, &force), Err(LoadError::NotFinite));
                assert_eq!(loads.add_pattern(scene, 0, bad), Err(LoadError::NotFinite));
            }
            let far = Contact { place: Place::triangle([1, 4, 6], [0.2, 0.5, 0.3]), ..contact() };
            assert_eq!(loads.add_contact(scene, &far), Err(LoadError::NotLoadable { node: 6, limit: 6 }));
            assert_eq!(loads.add_pattern(scene, 1, 1.0), Err(LoadError::NoPattern { index: 1, count: 1 }));
            // Finite in f64, not in the scene's f32.
            let huge = Contact { force: [1e300, 0.0, 0.0], ..contact() };
            assert_eq!(loads.add_contact(scene, &huge), Err(LoadError::NotFinite));
            assert_eq!(state.restore(&[3e38; 18]), Err(StepError::NotFinite));
            state.save_into(&mut after).expect("length");
            assert_eq!(before, after);
            // Each number may be that large, and their sum may not: the step finds out.
            let far = [9e17; 18];
            state.restore(&far).expect("in range");
            assert_eq!(scene.step(state, loads), Err(StepError::NotFinite));
            state.save_into(&mut after).expect("length");
            assert_eq!(far, after);
            state.restore(&before).expect("as it was");
            loads.clear();
            assert_eq!(scene.step(state, loads), Ok(Status::Moving));
        });
    }
}

#[test]
fn a_damped_body_comes_to_rest_and_stays() {
    let step = StepParameters { alpha: 300.0, ..parameters() };
    let bytes = Body::open(LAYOUT, 8).file(&bathe(), &step, Element::F32);
    for structure in [StructureChoice::Diagonal, StructureChoice::Block] {
        with_scene::<f32, ()>(&bytes, &options(structure), |scene, state, loads| {
            assert_eq!(scene.step(state, loads), Ok(Status::AtRest));
            loads.add_contact(scene, &contact()).expect("contact");
            (0..10).for_each(|_| assert_eq!(scene.step(state, loads), Ok(Status::Moving)));
            loads.clear();
            let steps = (0..1_000_000).find(|_| scene.step(state, loads) == Ok(Status::AtRest));
            assert!(steps.is_some(), "{structure:?} never rests");
            assert!(state.zeta().iter().all(|&z| z == 0.0));
        });
    }
}

#[test]
fn held_and_staged_loads_agree() {
    let bytes = Body::open(LAYOUT, 9).file(&bathe(), &parameters(), Element::F64);
    let held =
        with_scene::<f64, Vec<f64>>(&bytes, &options(StructureChoice::Block), |scene, state, loads| {
            loads.add_contact(scene, &contact()).expect("contact");
            scene.step(state, loads).expect("step");
            state.zeta().to_vec()
        });
    with_scene::<f64, ()>(&bytes, &options(StructureChoice::Block), |scene, state, loads| {
        loads.add_contact_staged(scene, &contact(), &[1.0; 1 + MAX_STAGES]).expect("contact");
        scene.step(state, loads).expect("step");
        // Bathe's load weights are 0 and 1: the same bits.
        assert_eq!(state.zeta(), held);
    });
}

#[test]
fn setting_a_state_gives_the_acceleration_of_the_equation_of_motion() {
    let body = Body::open(LAYOUT, 10);
    let step = parameters();
    let bytes = body.file(&bathe(), &step, Element::F64);
    let (zeta, rate): (Vec<f64>, Vec<f64>) =
        (0..6).map(|k| (0.01 * f64::from(k), 1.0 - f64::from(k))).unzip();
    for structure in [StructureChoice::Diagonal, StructureChoice::Block] {
        with_scene::<f64, ()>(&bytes, &options(structure), |scene, state, loads| {
            loads.add_contact(scene, &contact()).expect("contact");
            scene.set(state, &zeta, &rate, loads).expect("set");
            let book = Textbook::galerkin(&body, step);
            let force = book.force(&on_dofs(&contact(), 1.0));
            for k in 0..6 {
                let lambda = body.lambda[k];
                let damping = step.alpha + step.beta * lambda;
                let terms = [force[k], lambda * zeta[k], damping * rate[k]];
                let expected = step.time_step.powi(2) * (terms[0] - terms[1] - terms[2]);
                let found = state.scaled_acceleration()[k];
                // A dozen roundings of the terms, and of the sums behind them.
                let allowed = 1e-13 * step.time_step.powi(2) * terms.iter().map(|t| t.abs()).sum::<f64>();
                assert!((found - expected).abs() <= allowed, "{found} {expected}");
                assert_eq!(state.zeta()[k], zeta[k]);
            }
        });
    }
}

#[test]
fn outputs_are_rows_of_the_basis_times_the_state() {
    let body = Body::open(LAYOUT, 11);
    let bytes = body.file(&bathe(), &parameters(), Element::F64);
    with_scene::<f64, ()>(&bytes, &options(StructureChoice::Auto), |scene, state, loads| {
        assert_eq!(scene.structure(), Structure::Diagonal);
        loads.add_contact(scene, &contact()).expect("contact");
        (0..20).for_each(|_| assert_eq!(scene.step(state, loads), Ok(Status::Moving)));
        let n = LAYOUT.n_nodes();
        let (mut whole, mut surface) = (vec![0.0; 3 * n], vec![0.0; 3 * LAYOUT.n_surface()]);
        for field in [Field::Displacement, Field::Velocity] {
            scene.body_into(state, field, &mut whole).expect("body");
            scene.surface_into(state, field, &mut surface).expect("surface");
            assert_eq!(surface, whole[..surface.len()]);
            let (x, scale) = match field {
                Field::Displacement => (state.zeta(), 1.0),
                Field::Velocity => (state.scaled_velocity(), 1.0 / 5e-3),
            };
            for (dof, row) in body.basis.chunks_exact(6).enumerate() {
                let expected = scale * row.iter().zip(x).map(|(b, x)| b * x).sum::<f64>();
                // Six products and their sum in another order.
                let allowed = 1e-14 * scale * row.iter().zip(x).map(|(b, x)| (b * x).abs()).sum::<f64>();
                assert!((whole[dof] - expected).abs() <= allowed);
                let at_node = scene.node(state, dof / 3, field).expect("node")[dof % 3];
                assert!((at_node - expected).abs() <= allowed);
                if dof < 3 {
                    assert!((scene.probe(state, dof, field).expect("probe") - expected).abs() <= allowed);
                }
            }
        }
        assert!(scene.probe(state, 3, Field::Displacement).is_err());
        assert!(scene.node(state, n, Field::Displacement).is_err());
        assert!(scene.body_into(state, Field::Velocity, &mut surface).is_err());
    });
}
