//! Modes that dashpots couple: the step of all of them together against matrix exponentials, and what a
//! scene, a batch and a body make of it.

use vademecum_eval::{
    Batch, BindError, Contact, Field, Loads, Place, Scalar, Scene, SceneOptions, State, StructureChoice,
    SurfacePoint,
};
use vademecum_format::exact::Propagator;
use vademecum_format::scheme::StepParameters;
use vademecum_format::{Element, File, SectionKind};
use vademecum_tests::golden::{named, with_dashpots};
use vademecum_tests::stage::with_work;
use vademecum_tests::synthetic::{Body, Layout, Random, bathe};

const STEP: StepParameters =
    StepParameters { time_step: 1e-3, alpha: 0.5, beta: 1e-6, density: 1.0, stiffness: 1.0 };

/// A body of so many modes from 30 rad/s to 30 000 rad/s, with these rows of dashpots.
fn body(r: usize, rows: &[f64]) -> Vec<u8> {
    let layout = Layout { rows: 3, load_rows: 2, columns: 4, n_interior: 0, r };
    with_dashpots(&Body::closed(layout, 11).file(&bathe(), &STEP, Element::F64), rows)
}

fn exact() -> SceneOptions {
    SceneOptions { structure: StructureChoice::Exact, ..SceneOptions::default() }
}

fn numbers(bytes: &[u8], kind: SectionKind) -> Vec<f64> {
    File::parse(bytes).unwrap().section(kind).unwrap().numbers().unwrap().iter().collect()
}

/// The exponential of a square matrix, row by row, by its series at a short time and squaring.
fn exponential(a: &[f64], n: usize) -> Vec<f64> {
    let product = |a: &[f64], b: &[f64]| -> Vec<f64> {
        let mut out = vec![0.0; n * n];
        for i in 0..n {
            for k in 0..n {
                (0..n).for_each(|j| out[i * n + j] += a[i * n + k] * b[k * n + j]);
            }
        }
        out
    };
    let norm = a.chunks(n).map(|row| row.iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
    let squarings = norm.log2().ceil().max(0.0) as i32 + 2;
    let short: Vec<f64> = a.iter().map(|x| x * 0.5_f64.powi(squarings)).collect();
    let mut term: Vec<f64> = (0..n * n).map(|i| f64::from(u8::from(i % (n + 1) == 0))).collect();
    let mut sum = term.clone();
    for k in 1..25 {
        term = product(&term, &short);
        term.iter_mut().for_each(|x| *x /= f64::from(k));
        sum.iter_mut().zip(&term).for_each(|(sum, x)| *sum += x);
    }
    for _ in 0..squarings {
        sum = product(&sum, &sum);
    }
    sum
}

/// `(ω ζ, ζ̇)` after a step under a force that goes from `f_0` to `f_1`, by the exponential of the augmented
/// matrix of Van Loan (1978) in coordinates of which the squares are the energy.
fn stepped(bytes: &[u8], start: &[f64], [f_0, f_1]: [&[f64]; 2]) -> Vec<f64> {
    let (lambda, rows) = (numbers(bytes, SectionKind::Eigenvalues), numbers(bytes, SectionKind::DampingRows));
    let (r, dt) = (lambda.len(), STEP.time_step);
    let n = 2 * r + 2;
    let mut a = vec![0.0; n * n];
    for i in 0..r {
        let omega = lambda[i].sqrt();
        a[i * n + r + i] = dt * omega;
        a[(r + i) * n + i] = -dt * omega;
        a[(r + i) * n + r + i] = -dt * (STEP.alpha + STEP.beta * lambda[i]);
        for j in 0..r {
            let coupled: f64 = rows.chunks(r).map(|d| d[i] * d[j]).sum();
            a[(r + i) * n + r + j] -= dt * coupled;
        }
        a[(r + i) * n + 2 * r] = dt * f_0[i];
        a[(r + i) * n + 2 * r + 1] = dt * (f_1[i] - f_0[i]);
    }
    // The last two coordinates are 1 and a time that rises from 0 to 1.
    a[(2 * r + 1) * n + 2 * r] = 1.0;
    let moved = exponential(&a, n);
    let start: Vec<f64> = start.iter().copied().chain([1.0, 0.0]).collect();
    (0..2 * r).map(|i| (0..n).map(|j| moved[i * n + j] * start[j]).sum()).collect()
}

/// `(ω ζ, ζ̇)` of a state.
fn energetic<T: Scalar>(state: &State<'_, T>, lambda: &[f64]) -> Vec<f64> {
    let displaced = state.zeta().iter().zip(lambda).map(|(zeta, lambda)| lambda.sqrt() * zeta.to_f64());
    let rates = state.scaled_velocity().iter().map(|rate| rate.to_f64() / state.time_step());
    displaced.chain(rates).collect()
}

fn apart(found: &[f64], expected: &[f64]) -> f64 {
    let norm = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>().sqrt();
    let off = norm(&mut found.iter().zip(expected).map(|(a, b)| a - b));
    off / norm(&mut expected.iter().copied())
}

#[test]
fn a_step_is_that_of_the_augmented_matrix() {
    let r = 9;
    // From dampers that hardly brake to ones that hold.
    for strength in [1e-3, 1.0, 10.0, 100.0] {
        let rows: Vec<f64> = Random::new(3).numbers(3 * r).iter().map(|x| strength * x).collect();
        let bytes = body(r, &rows);
        let lambda = numbers(&bytes, SectionKind::Eigenvalues);
        let pattern = numbers(&bytes, SectionKind::PatternBasis)[..r].to_vec();
        let mut random = Random::new(5);
        let (zeta, rate) = (random.numbers(r), random.numbers(r));
        let zeta: Vec<f64> = zeta.iter().zip(&lambda).map(|(x, lambda)| x / lambda.sqrt()).collect();
        for amplitudes in [[0.0, 0.0], [1.5, 1.5], [-0.5, 2.0]] {
            let found = with_work::<f64, _>(&bytes, &exact(), |scene, state, loads, _| {
                assert!(scene.is_coupled());
                let [f_0, f_1] = amplitudes;
                loads.add_pattern_staged(scene, 0, &[f_0, f_1, 0.0, 0.0]).unwrap();
                scene.set(state, &zeta, &rate, loads).unwrap();
                scene.step(state, loads).unwrap();
                energetic(state, &lambda)
            });
            let start: Vec<f64> = zeta.iter().zip(&lambda).map(|(x, lambda)| x * lambda.sqrt()).collect();
            let start: Vec<f64> = start.into_iter().chain(rate.iter().copied()).collect();
            let forces = amplitudes.map(|a| pattern.iter().map(|f| a * f).collect::<Vec<f64>>());
            let expected = stepped(&bytes, &start, [&forces[0], &forces[1]]);
            let error = apart(&found, &expected);
            assert!(error < 1e-12, "dampers of {strength}: {error:e}");
        }
    }
}

/// Two oscillators of one frequency, joined by a damper: their sum swings for ever, their difference decays.
#[test]
fn a_damper_between_two_oscillators_brakes_their_difference_alone() {
    let (c, omega) = (40.0_f64, 100.0_f64);
    let d = c.sqrt();
    let layout = Layout { rows: 3, load_rows: 2, columns: 4, n_interior: 0, r: 2 };
    let free = StepParameters { alpha: 0.0, beta: 0.0, ..STEP };
    let two = Body { lambda: vec![omega * omega; 2], ..Body::closed(layout, 1) };
    let bytes = with_dashpots(&two.file(&bathe(), &free, Element::F64), &[d, -d]);
    with_work::<f64, _>(&bytes, &exact(), |scene, state, loads, _| {
        scene.set(state, &[1.0, 0.0], &[0.0; 2], loads).unwrap();
        for _ in 0..500 {
            scene.step(state, loads).unwrap();
        }
        // The difference has the whole damper twice: ẍ + 2c ẋ + ω² x = 0.
        let t = 0.5_f64;
        let damped = (omega * omega - c * c).sqrt();
        let difference = (-c * t).exp() * ((damped * t).cos() + c / damped * (damped * t).sin());
        let sum = (omega * t).cos();
        let expected = [0.5 * (sum + difference), 0.5 * (sum - difference)];
        for (found, expected) in state.zeta().iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
        // What the sum has is what is left.
        let energy = scene.energy(state).unwrap();
        assert!((energy / (0.25 * omega * omega) - 1.0).abs() < 1e-9, "{energy}");
    });
}

#[test]
fn energy_never_grows_without_load() {
    fn largest_growth<T: Scalar>(bytes: &[u8], options: SceneOptions) -> f64 {
        with_work::<T, _>(bytes, &options, |scene, state, loads, _| {
            let r = scene.n_modes();
            let mut random = Random::new(8);
            scene.set(state, &vec![0.0; r], &random.numbers(r), loads).unwrap();
            let (mut before, mut most) = (scene.energy(state).unwrap(), 0.0);
            let start = before;
            for _ in 0..20_000 {
                for _ in 0..10 {
                    scene.step(state, loads).unwrap();
                }
                let now = scene.energy(state).unwrap();
                most = f64::max(most, (now - before) / start);
                before = now;
            }
            assert!(before <= start);
            most
        })
    }
    let r = 12;
    // The damper leaves every third mode alone.
    let rows = Random::new(4).numbers(r);
    let rows: Vec<f64> = (0..r).map(|k| if k % 3 == 0 { 0.0 } else { 3.0 * rows[k] }).collect();
    let bytes = body(r, &rows);
    let free = SceneOptions { alpha: Some(0.0), beta: Some(0.0), ..exact() };
    // The rounding of the state itself, in ten steps of up to thirty turns.
    let [single, double] = [largest_growth::<f32>(&bytes, free), largest_growth::<f64>(&bytes, free)];
    assert!(single < 1e-5 && double < 1e-13, "{single:e} {double:e}");
}

#[test]
fn a_damper_that_couples_nothing_leaves_the_closed_form() {
    let r = 5;
    let rows = [0.0, 0.0, 7.0, 0.0, 0.0];
    let bytes = body(r, &rows);
    let mut map = vec![0.0; 4 * r * r];
    with_work::<f64, _>(&bytes, &exact(), |scene, _, _, _| scene.increment_into(&mut map).unwrap());
    for (k, lambda) in numbers(&bytes, SectionKind::Eigenvalues).into_iter().enumerate() {
        let sigma = 0.5 * (STEP.alpha + STEP.beta * lambda + rows[k] * rows[k]);
        let mode = Propagator::new(lambda, sigma, STEP.time_step);
        for (place, expected) in [(k, k), (k, r + k), (r + k, k), (r + k, r + k)].into_iter().zip(mode.d) {
            let found = map[place.1 * 2 * r + place.0];
            assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{k}: {found:e} {expected:e}");
        }
    }
    let apart = (0..4 * r * r).filter(|i| i % (2 * r) % r != i / (2 * r) % r);
    assert!(apart.into_iter().all(|i| map[i] == 0.0));
}

#[test]
fn live_numbers_and_other_time_steps_are_those_of_a_fresh_scene() {
    let r = 6;
    let rows: Vec<f64> = Random::new(6).numbers(2 * r).iter().map(|x| 5.0 * x).collect();
    let bytes = body(r, &rows);
    let map_of = |options: SceneOptions| {
        with_work::<f64, _>(&bytes, &options, |scene, _, _, _| {
            let mut map = vec![0.0; 4 * r * r];
            scene.increment_into(&mut map).unwrap();
            map
        })
    };
    let moved = SceneOptions { time_step: Some(3e-3), alpha: Some(2.0), density: 1.5, ..exact() };
    let rebound = with_work::<f64, _>(&bytes, &exact(), |scene, state, loads, work| {
        let mut map = vec![0.0; 4 * r * r];
        scene.rebind(&moved, work).unwrap();
        scene.increment_into(&mut map).unwrap();
        // Three short steps are a long one.
        scene.rebind(&exact(), work).unwrap();
        state.carry(scene).unwrap();
        loads.add_pattern(scene, 0, 1.0).unwrap();
        for _ in 0..3 {
            scene.step(state, loads).unwrap();
        }
        let three = state.zeta().to_vec();
        let mut memory = vec![0.0; scene.own_sizes().scene];
        let mut lent = vec![0.0; scene.own_sizes().work];
        let long = scene.with_time_step(3e-3, &mut memory, &mut lent).unwrap();
        let mut state_memory = vec![0.0; long.own_sizes().state];
        let mut load_memory = vec![0.0; long.own_sizes().loads];
        let mut once = State::new(&long, &mut state_memory).unwrap();
        let mut held = Loads::new(&long, &mut load_memory).unwrap();
        held.add_pattern(&long, 0, 1.0).unwrap();
        long.step(&mut once, &held).unwrap();
        assert!(apart(once.zeta(), &three) < 1e-13);
        map
    });
    assert_eq!(rebound, map_of(moved));
}

#[test]
fn numbers_that_no_step_can_follow_are_refused() {
    let long = SceneOptions { time_step: Some(1e30), ..exact() };
    for (rows, options) in [
        (vec![1.0, 2.0], long),
        (vec![f64::INFINITY, 1.0], exact()),
        (vec![1e200, 1.0], exact()),
        (vec![f64::NAN, 1.0], exact()),
    ] {
        let bytes = body(2, &rows);
        let file = File::parse(&bytes).unwrap();
        let sizes = Scene::<f64>::sizes(&file, &options).unwrap();
        let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
        let refused = Scene::bind(&file, &options, &mut memory, &mut work);
        assert_eq!(refused.err(), Some(BindError::NotFinite), "{rows:?}");
    }
}

#[test]
fn other_structures_are_refused_by_name() {
    let bytes = body(4, &[1.0, 2.0, 0.0, -1.0]);
    let file = File::parse(&bytes).unwrap();
    for structure in [StructureChoice::Diagonal, StructureChoice::Block, StructureChoice::Auto] {
        let options = SceneOptions { structure, ..SceneOptions::default() };
        let refused = Scene::<f64>::sizes(&file, &options);
        assert_eq!(refused.err(), Some(BindError::OnlyExact { kind: SectionKind::DampingRows }));
    }
    // Without a row there is nothing to leave out.
    let none = File::parse(&bytes).unwrap();
    assert!(Scene::<f64>::sizes(&none, &exact()).is_ok());
    let empty = body(4, &[]);
    let plain = with_work::<f64, _>(&empty, &exact(), |scene, _, _, _| scene.is_coupled());
    assert!(!plain);
}

#[test]
fn contacts_batches_and_saved_states_follow_the_coupled_step() {
    let bytes = named("dashpots.vdm");
    let contacts = [
        Contact::new(Place::triangle([0, 1, 3], [0.2, 0.5, 0.3]), [1.0, -2.0, 0.5]),
        Contact::new(Place::node(2), [0.25, 0.5, -1.0]),
    ];
    with_work::<f64, _>(&bytes, &SceneOptions::default(), |scene, state, loads, _| {
        assert!(scene.is_coupled());
        loads.add_pattern(scene, 0, 0.75).unwrap();
        scene.set(state, &[1e-3, -2e-3, 5e-4], &[0.1, 0.2, -0.3], loads).unwrap();
        scene.step(state, loads).unwrap();
        let (mut w, mut work) = ([0.0; 36], vec![0.0; scene.compliance_work(2)]);
        let mut free = [[0.0; 3]; 2];
        scene.compliance(&contacts, &mut w, &mut work).unwrap();
        scene.free_motion(state, loads, &contacts, &mut free, &mut work).unwrap();
        let mut batch_memory = vec![0.0; Batch::len_for(scene, 20)];
        let mut batch = Batch::new(scene, 20, &mut batch_memory).unwrap();
        let mut saved = vec![0.0; scene.state_numbers()];
        state.save_into(&mut saved).unwrap();
        batch.set(17, state).unwrap();
        contacts.iter().for_each(|contact| loads.add_contact(scene, contact).unwrap());
        batch.load(scene, 17, loads).unwrap();
        scene.step(state, loads).unwrap();
        let forces: Vec<f64> = contacts.iter().flat_map(|contact| contact.force).collect();
        for (c, contact) in contacts.iter().enumerate() {
            let point = SurfacePoint { place: contact.place, position: [0.0; 3], distance: 0.0 };
            let moved = scene.point(state, &point, Field::Displacement).unwrap();
            for i in 0..3 {
                let row = &w[(3 * c + i) * 6..(3 * c + i + 1) * 6];
                let said = free[c][i] + row.iter().zip(&forces).map(|(w, f)| w * f).sum::<f64>();
                // Nodes 0, 1 and 3 share triangles with node 2: the residual between the contacts is no part
                // of the operator.
                let between = 3e-3;
                assert!((said - moved[i]).abs() < between, "{c} {i}: {said} {}", moved[i]);
            }
        }
        let after = state.zeta().to_vec();
        batch.step(scene).unwrap();
        batch.get(17, state).unwrap();
        assert_eq!(state.zeta(), after); // every bit
        state.restore(&saved).unwrap();
        scene.step(state, loads).unwrap();
        assert_eq!(state.zeta(), after);
        for i in 0..6 {
            for j in 0..6 {
                assert_eq!(w[6 * i + j], w[6 * j + i]);
            }
        }
    });
}

/// The operator of contacts is exactly what a step does, where the residual does not come in.
#[test]
fn the_operator_of_contacts_is_what_a_step_does() {
    let r = 7;
    let rows: Vec<f64> = Random::new(9).numbers(2 * r).iter().map(|x| 10.0 * x).collect();
    let bytes = body(r, &rows);
    let contacts = [
        Contact::new(Place::node(0), [1.0, -2.0, 0.5]),
        Contact::new(Place::triangle([1, 5, 2], [0.2, 0.5, 0.3]), [0.25, 0.5, -1.0]),
    ];
    with_work::<f64, _>(&bytes, &exact(), |scene, state, loads, _| {
        loads.add_pattern(scene, 0, 0.75).unwrap();
        scene.step(state, loads).unwrap();
        let (mut w, mut work) = ([0.0; 36], vec![0.0; scene.compliance_work(2)]);
        let mut free = [[0.0; 3]; 2];
        scene.compliance(&contacts, &mut w, &mut work).unwrap();
        scene.free_motion(state, loads, &contacts, &mut free, &mut work).unwrap();
        contacts.iter().for_each(|contact| loads.add_contact(scene, contact).unwrap());
        scene.step(state, loads).unwrap();
        let forces: Vec<f64> = contacts.iter().flat_map(|contact| contact.force).collect();
        let (mut said, mut moved) = (vec![], vec![]);
        for (c, contact) in contacts.iter().enumerate() {
            let point = SurfacePoint { place: contact.place, position: [0.0; 3], distance: 0.0 };
            moved.extend(scene.point(state, &point, Field::Displacement).unwrap());
            for i in 0..3 {
                let row = &w[(3 * c + i) * 6..(3 * c + i + 1) * 6];
                said.push(free[c][i] + row.iter().zip(&forces).map(|(w, f)| w * f).sum::<f64>());
            }
        }
        assert!(apart(&said, &moved) < 1e-12, "{said:?} {moved:?}");
    });
}
