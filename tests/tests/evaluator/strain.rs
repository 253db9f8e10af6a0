//! The strain structure beside its formulas written out densely, and what is proved of it: an energy that is
//! kept to rounding, a bound that no load passes, and never a number that is not finite.

use vademecum_eval::{
    Batch, BindError, Contact, Field, LoadError, Loads, OutputError, Place, Scalar, Scene, SceneOptions,
    State, Status, StepError, Structure, StructureChoice,
};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{File, FormatError, SectionKind};
use vademecum_rewrite::check;
use vademecum_tests::stage::with_scene;
use vademecum_tests::strained::Strained;
use vademecum_tests::synthetic::Random;

/// Sizes `[n, n₁, r, m]`: without and with coupled coordinates, tail and extra rows, and paddings of all
/// widths.
const SIZES: [[usize; 4]; 8] = [
    [1, 0, 1, 1],
    [3, 2, 7, 12],
    [8, 0, 8, 24],
    [16, 0, 16, 48],
    [8, 8, 20, 32],
    [5, 20, 30, 40],
    [24, 0, 32, 64],
    [20, 12, 32, 70],
];

/// A quarter of the period of the slowest frequency, over ten.
const STEP: StepParameters =
    StepParameters { time_step: 5e-3, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 };

const CONSERVED: SceneOptions = SceneOptions { viscosity: 0.0, ..DEFAULT };

const DEFAULT: SceneOptions = SceneOptions {
    structure: StructureChoice::Auto,
    tolerance: 0.0,
    time_step: None,
    stiffness: 1.0,
    density: 1.0,
    regions: vademecum_eval::RegionScales::ONE,
    alpha: None,
    beta: None,
    rest_below: 0.0,
    terms: None,
    residual: true,
    contacts: 16,
    filtered_nodes: None,
    substeps: None,
    viscosity: 1.0 / 18.0,
};

/// The reduced force of the file's pattern.
fn pattern(bytes: &[u8]) -> Vec<f64> {
    let file = File::parse(bytes).expect("a file");
    file.section(SectionKind::PatternBasis).expect("a pattern").numbers().expect("raw").iter().collect()
}

/// Random displacement of size about `size`, and velocity.
fn placed(r: usize, size: f64, seed: u64) -> (Vec<f64>, Vec<f64>) {
    let mut random = Random::new(seed);
    let zeta = random.numbers(r).iter().map(|x| size * x).collect();
    (zeta, random.numbers(r).iter().map(|x| 30.0 * size * x).collect())
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |largest, x| f64::max(largest, x.abs()))
}

#[test]
fn defaults_are_those_of_the_options() {
    assert_eq!(SceneOptions::default(), DEFAULT);
}

#[test]
fn a_step_is_the_dense_solve_with_every_kind_of_damping_and_scale() {
    for (seed, sizes) in SIZES.into_iter().enumerate() {
        let map = Strained::random(sizes, seed as u64);
        for (viscosity, by) in [
            (0.0, STEP),
            (1.0 / 18.0, STEP),
            (0.5, StepParameters { alpha: 3.0, beta: 2e-4, density: 1.7, stiffness: 0.6, time_step: 3e-3 }),
        ] {
            let bytes = map.file(&STEP);
            let force = pattern(&bytes);
            let options = SceneOptions {
                viscosity,
                time_step: Some(by.time_step),
                alpha: Some(by.alpha),
                beta: Some(by.beta),
                density: by.density,
                stiffness: by.stiffness,
                ..DEFAULT
            };
            with_scene::<f64, _>(&bytes, &options, |scene, state, loads| {
                assert_eq!(scene.structure(), Structure::Strain);
                let (mut zeta, mut rate) = placed(sizes[2], 0.3, 7 + seed as u64);
                scene.set(state, &zeta, &rate, loads).expect("placed");
                loads.add_pattern_staged(scene, 0, &[200.0, 400.0, 0.0, 0.0]).expect("a pattern");
                let force: Vec<f64> = force.iter().map(|f| 300.0 * f).collect();
                for _ in 0..5 {
                    scene.step(state, loads).expect("a step");
                    (zeta, rate) = map.dense_step((&zeta, &rate), &force, &by, viscosity);
                    let off = largest(state.zeta().iter().zip(&zeta).map(|(a, b)| a - b));
                    assert!(off <= 1e-12 * largest(zeta.iter().copied()), "{sizes:?}: {off:e}");
                    let velocities = state.scaled_velocity().iter().map(|v| v / by.time_step);
                    let off = largest(velocities.zip(&rate).map(|(a, b)| a - b));
                    assert!(off <= 1e-12 * largest(rate.iter().copied()), "{sizes:?}: {off:e}");
                    let energy = scene.energy(state).expect("an energy");
                    let dense = map.energy((&zeta, &rate), &by);
                    assert!((energy - dense).abs() <= 1e-12 * dense, "{sizes:?}: {energy:e} {dense:e}");
                }
            });
        }
    }
}

/// Marches a body that is free after a random start; the largest change of its energy, relative.
fn drift<T: Scalar>(map: &Strained, (zeta, rate): &(Vec<f64>, Vec<f64>), longer: f64, steps: usize) -> f64 {
    let bytes = map.file(&STEP);
    let options = SceneOptions { time_step: Some(longer * STEP.time_step), ..CONSERVED };
    with_scene::<T, _>(&bytes, &options, |scene, state, loads| {
        scene.set(state, zeta, rate, loads).expect("placed");
        let start = scene.energy(state).expect("an energy");
        let mut off = 0.0f64;
        for step in 0..steps {
            assert_eq!(scene.step(state, loads), Ok(Status::Moving));
            if step % 16 == 15 || step + 1 == steps {
                off = off.max((scene.energy(state).expect("an energy") / start - 1.0).abs());
            }
        }
        off
    })
}

#[test]
fn a_free_body_keeps_its_energy() {
    for (seed, sizes) in [[8, 0, 8, 24], [16, 0, 16, 48], [12, 4, 24, 50], [24, 8, 32, 96]].iter().enumerate()
    {
        let map = &Strained::random(*sizes, seed as u64);
        for size in [0.1, 1.0, 16.0] {
            let start = &placed(sizes[2], size, seed as u64);
            for longer in [1.0, 4.0, 10.0] {
                let off = drift::<f64>(map, start, longer, 400);
                // Rounding: a random walk of 400 steps, each of a few hundred operations.
                assert!(off <= 1e-10, "{sizes:?}, {size}, {longer}: {off:e}");
                let off = drift::<f32>(map, start, longer, 400);
                assert!(off <= 1e-10 * (f32::EPSILON as f64 / f64::EPSILON), "f32 {sizes:?}: {off:e}");
                assert!(off <= 0.05, "f32 {sizes:?}, {size}, {longer}: {off:e}");
            }
        }
    }
}

/// Maps of which every second row resists `factor²` times as much.
fn with_stiff_parts(factor: f64) -> impl Iterator<Item = (Strained, (Vec<f64>, Vec<f64>))> {
    [[8, 0, 8, 24], [16, 0, 16, 48], [12, 4, 24, 50]].into_iter().enumerate().map(move |(seed, sizes)| {
        let mut map = Strained::random(sizes, seed as u64);
        let leading = map.sizes.leading();
        for row in map.linear.chunks_exact_mut(leading).step_by(2) {
            row.iter_mut().for_each(|x| *x *= factor);
        }
        // From its place at rest, so that most of the energy is not in the stiff parts.
        let (mut zeta, rate) = placed(sizes[2], 1.0, seed as u64);
        zeta.fill(0.0);
        (map, (zeta, rate))
    })
}

#[test]
fn a_body_with_stiff_parts_keeps_its_energy() {
    // The matrix of a step has a condition of some 1e10.
    for (map, start) in with_stiff_parts(1e4) {
        for longer in [1.0, 4.0, 10.0] {
            let off = drift::<f64>(&map, &start, longer, 400);
            assert!(off <= 1e-10, "{:?}, {longer}: {off:e}", map.sizes);
        }
    }
}

#[test]
fn no_stiffness_makes_a_damped_body_gain_energy() {
    for factor in [1e2, 1e4, 1e6] {
        for (map, (zeta, rate)) in with_stiff_parts(factor) {
            for longer in [1.0, 10.0] {
                let options = SceneOptions { time_step: Some(longer * STEP.time_step), ..DEFAULT };
                with_scene::<f32, _>(&map.file(&STEP), &options, |scene, state, loads| {
                    scene.set(state, &zeta, &rate, loads).expect("placed");
                    let start = scene.energy(state).expect("an energy");
                    for step in 0..400 {
                        scene.step(state, loads).expect("a step");
                        let now = scene.energy(state).expect("an energy") / start;
                        assert!(now <= 1.0 + 1e-4, "{:?}, {factor}, {longer}, {step}: {now}", map.sizes);
                    }
                });
            }
        }
    }
}

/// Under any load, `√E⁺ − √E⁻ ≤ k |f/√m|/√2`, and damping only takes.
fn never_past_the_bound<T: Scalar>(rounding: f64) {
    let maps = [[8, 0, 8, 24], [16, 0, 24, 48], [20, 12, 32, 70]].into_iter().enumerate();
    let maps = maps.map(|(seed, sizes)| Strained::random(sizes, seed as u64));
    for map in maps.chain(with_stiff_parts(100.0).map(|(map, _)| map)) {
        let sizes = map.sizes;
        for times in [1.0, 4.0, 16.0, 256.0] {
            for longer in [1.0, 4.0, 10.0] {
                for (viscosity, alpha, beta) in
                    [(0.0, 0.0, 0.0), (1.0 / 18.0, 0.0, 0.0), (1.0 / 18.0, 2.0, 1e-4)]
                {
                    let step = longer * STEP.time_step;
                    let by = StepParameters { time_step: step, alpha, beta, ..STEP };
                    let bytes = map.file(&by);
                    let force = pattern(&bytes);
                    let square = force.iter().zip(map.inertia(&by)).map(|(f, m)| f * f / m);
                    let length = square.sum::<f64>().sqrt();
                    let options = SceneOptions { viscosity, ..DEFAULT };
                    with_scene::<T, _>(&bytes, &options, |scene, state, loads| {
                        let mut random = Random::new(99);
                        let mut before = 0.0f64;
                        for step_number in 0..60 {
                            let amplitude =
                                if step_number < 40 { 100.0 * times * random.number() } else { 0.0 };
                            loads.clear();
                            loads.add_pattern(scene, 0, amplitude).expect("a pattern");
                            let (_, account) = scene.step_metered(state, loads).expect("a step");
                            let allowed = step * amplitude.abs() * length / 2f64.sqrt();
                            let slack = rounding * (account.after.sqrt() + before);
                            let gain = account.after.sqrt() - before;
                            assert!(gain <= allowed + slack, "{sizes:?} x{times}: {gain:e} > {allowed:e}");
                            before = account.after.sqrt();
                            assert!(before.is_finite());
                            assert!(account.dissipated >= 0.0);
                            let size = account.after.max(account.before).max(account.work.abs());
                            let off = account.violation().abs();
                            assert!(off <= rounding * size.max(account.dissipated), "{off:e} of {size:e}");
                        }
                    });
                }
            }
        }
    }
}

#[test]
fn no_load_passes_the_bound() {
    never_past_the_bound::<f64>(1e-11);
    never_past_the_bound::<f32>(1e-11 * f64::from(f32::EPSILON) / f64::EPSILON);
}

/// Displacement and velocity after a time, in steps of `step`.
fn after(map: &Strained, time: f64, steps: usize, viscosity: f64) -> Vec<f64> {
    let bytes = map.file(&StepParameters { time_step: time / steps as f64, ..STEP });
    let options = SceneOptions { viscosity, ..DEFAULT };
    with_scene::<f64, _>(&bytes, &options, |scene, state, loads| {
        let (zeta, rate) = placed(map.sizes.coordinates, 0.2, 5);
        scene.set(state, &zeta, &rate, loads).expect("placed");
        loads.add_pattern(scene, 0, 50.0).expect("a pattern");
        for _ in 0..steps {
            scene.step(state, loads).expect("a step");
        }
        let velocity = state.scaled_velocity().iter().map(|v| v * steps as f64 / time);
        state.zeta().iter().copied().chain(velocity.map(|v| v / 100.0)).collect()
    })
}

#[test]
fn the_step_is_of_order_two_in_displacement_and_velocity() {
    // Frequencies to 170 rad/s: the coarsest step resolves them.
    let mut map = Strained::random([4, 2, 8, 14], 3);
    map.tail = vec![140.0, 170.0];
    for viscosity in [0.0, 1.0 / 18.0] {
        let time = 0.08;
        let fine = after(&map, time, 16_384, viscosity);
        let errors = [256, 512, 1024].map(|steps| {
            let coarse = after(&map, time, steps, viscosity);
            largest(coarse.iter().zip(&fine).map(|(a, b)| a - b))
        });
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!((1.9..2.1).contains(&order), "order {order}: {errors:?}");
        }
    }
}

#[test]
fn without_quadratic_part_and_natural_modes_it_is_the_trapezoidal_rule() {
    let mut map = Strained::random([6, 3, 14, 20], 4);
    map.quadratic.fill(0.0);
    map.modes.clear();
    let (r, k) = (14, STEP.time_step);
    let bytes = map.file(&STEP);
    let (force, g) = (pattern(&bytes), map.gradient(&[0.0; 14]));
    // K = LᵀL
    let mut stiffness = vec![0.0; r * r];
    for row in g.chunks_exact(r) {
        (0..r * r).for_each(|i| stiffness[i] += row[i / r] * row[i % r]);
    }
    let times = |x: &[f64]| -> Vec<f64> {
        stiffness.chunks_exact(r).map(|row| row.iter().zip(x).map(|(a, b)| a * b).sum()).collect()
    };
    with_scene::<f64, _>(&bytes, &CONSERVED, |scene, state, loads| {
        let (mut zeta, mut rate) = placed(r, 0.3, 8);
        scene.set(state, &zeta, &rate, loads).expect("placed");
        let (mut start, size) = (0.0, largest(zeta.iter().copied()));
        for step in 0..50 {
            let end = f64::from(step % 7) - 2.0;
            loads.clear();
            loads.add_pattern_staged(scene, 0, &[start, end, 0.0, 0.0]).expect("a pattern");
            scene.step(state, loads).expect("a step");
            // What the scene has is the new state of the rule: v⁺ − v = k/2 (a + a⁺), u⁺ − u = k/2 (v + v⁺).
            let new: Vec<f64> = state.zeta().to_vec();
            let new_rate: Vec<f64> = state.scaled_velocity().iter().map(|v| v / k).collect();
            let (pull, new_pull) = (times(&zeta), times(&new));
            for i in 0..r {
                let a = start * force[i] - pull[i];
                let after = end * force[i] - new_pull[i];
                let kick = new_rate[i] - rate[i] - 0.5 * k * (a + after);
                assert!(kick.abs() <= 1e-12 * k * largest(pull.iter().copied()), "{kick:e}");
                let way = new[i] - zeta[i] - 0.5 * k * (rate[i] + new_rate[i]);
                assert!(way.abs() <= 1e-13 * size, "{way:e}");
            }
            (zeta, rate, start) = (new, new_rate, end);
        }
    });
}

#[test]
fn without_quadratic_part_a_natural_mode_swings_exactly() {
    // Three leading coordinates and two of the tail, each a natural mode; the last of each is too fast.
    let omega = [3.0, 310.0, 320.0, 200.0, 900.0];
    let mut map = Strained::random([2, 1, 5, 9], 4);
    map.quadratic.fill(0.0);
    map.linear = (0..15).map(|i| if i / 3 == i % 3 { omega[i % 3] } else { 0.0 }).collect();
    (map.tail, map.modes) = (omega[3..].to_vec(), omega.to_vec());
    let k = STEP.time_step;
    let resolved = omega.map(|omega| 0.5 * k * omega <= std::f64::consts::FRAC_PI_4);
    assert_eq!(resolved, [true, true, false, true, false]);
    let bytes = map.file(&STEP);
    let force = pattern(&bytes);
    with_scene::<f64, _>(&bytes, &CONSERVED, |scene, state, loads| {
        let (mut zeta, mut rate) = placed(5, 0.3, 8);
        scene.set(state, &zeta, &rate, loads).expect("placed");
        for step in 0..50 {
            let amplitude = 1000.0 * (f64::from(step % 7) - 2.0);
            loads.clear();
            loads.add_pattern(scene, 0, amplitude).expect("a pattern");
            scene.step(state, loads).expect("a step");
            for (j, omega) in omega.into_iter().enumerate() {
                // q̈ + ω² q = f, with a force that is held.
                let (rest, (sin, cos)) = (amplitude * force[j] / (omega * omega), (omega * k).sin_cos());
                let away = zeta[j] - rest;
                let exact = [rest + away * cos + rate[j] / omega * sin, rate[j] * cos - omega * away * sin];
                let found = [state.zeta()[j], state.scaled_velocity()[j] / k];
                let size = [0.3 + rest.abs(), omega * (0.3 + rest.abs()) + rate[j].abs()];
                for i in 0..2 {
                    let off = (found[i] - exact[i]).abs() / size[i];
                    if resolved[j] {
                        assert!(off <= 1e-13, "{omega} rad/s, step {step}: {off:e}");
                    } else if step == 0 {
                        assert!(off >= 1e-3, "{omega} rad/s: {off:e}");
                    }
                }
                [zeta[j], rate[j]] = found;
            }
        }
    });
}

#[test]
fn sub_steps_are_steps() {
    let map = Strained::random([8, 4, 20, 30], 6);
    let (whole, half) =
        (map.file(&STEP), map.file(&StepParameters { time_step: STEP.time_step / 3.0, ..STEP }));
    let start = placed(20, 0.4, 2);
    let thirds = with_scene::<f64, _>(&half, &DEFAULT, |scene, state, loads| {
        scene.set(state, &start.0, &start.1, loads).expect("placed");
        for third in 0..9 {
            // A load that grows over the step is met in the middle of each.
            let at = |end: usize| (third % 3 + end) as f64 / 3.0;
            loads.clear();
            loads.add_pattern_staged(scene, 0, &[30.0 * at(0), 30.0 * at(1), 0.0, 0.0]).expect("a pattern");
            scene.step(state, loads).expect("a step");
        }
        state.zeta().to_vec()
    });
    let options = SceneOptions { substeps: Some(3), ..DEFAULT };
    with_scene::<f64, _>(&whole, &options, |scene, state, loads| {
        scene.set(state, &start.0, &start.1, loads).expect("placed");
        loads.add_pattern_staged(scene, 0, &[0.0, 30.0, 0.0, 0.0]).expect("a pattern");
        (0..3).for_each(|_| assert_eq!(scene.step(state, loads), Ok(Status::Moving)));
        let off = largest(state.zeta().iter().zip(&thirds).map(|(a, b)| a - b));
        assert!(off <= 1e-12 * largest(thirds.iter().copied()), "{off:e}");
        let (_, account) = scene.step_metered(state, loads).expect("a step");
        assert!(account.violation().abs() <= 1e-12 * account.after);
    });
}

#[test]
fn states_are_saved_carried_and_batched_bit_for_bit() {
    let bytes = Strained::random([8, 4, 20, 30], 6).file(&STEP);
    with_scene::<f32, _>(&bytes, &DEFAULT, |scene, state, loads| {
        assert_eq!(scene.state_numbers(), 40);
        loads.add_pattern(scene, 0, 20.0).expect("a pattern");
        let mut memory = vec![0.0; Batch::len_for(scene, 18)];
        let mut batch = Batch::new(scene, 18, &mut memory).expect("a batch");
        batch.load(scene, 17, loads).expect("loaded");
        let mut saved = vec![0.0; 40];
        for step in 0..30 {
            scene.step(state, loads).expect("a step");
            let status = batch.step(scene).expect("a step");
            assert_eq!((status.moving, status.at_rest, status.refused), (1, 17, 0));
            if step == 20 {
                state.save_into(&mut saved).expect("saved");
            }
        }
        let alone = state.zeta().to_vec();
        batch.get(17, state).expect("a state");
        assert_eq!(state.zeta(), alone);
        state.restore(&saved).expect("restored");
        (0..9).for_each(|_| assert_eq!(scene.step(state, loads), Ok(Status::Moving)));
        assert_eq!(state.zeta(), alone);
    });
}

#[test]
fn a_scene_set_to_parameters_is_one_bound_to_them() {
    let bytes = Strained::random([8, 4, 20, 30], 6).file(&STEP);
    let file = File::parse(&bytes).expect("a file");
    let sizes = Scene::<f64>::sizes(&file, &DEFAULT).expect("sizes");
    let other = SceneOptions {
        time_step: Some(2e-3),
        stiffness: 2.0,
        density: 0.5,
        alpha: Some(1.0),
        beta: Some(1e-5),
        substeps: Some(2),
        viscosity: 0.1,
        ..DEFAULT
    };
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let mut scene = Scene::<f64>::bind(&file, &DEFAULT, &mut memory, &mut work).expect("bound");
    scene.rebind(&other, &mut work).expect("rebound");
    let start = placed(20, 0.3, 3);
    let march = |scene: &Scene<'_, f64>| {
        let (mut state, mut loads) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
        let mut state = State::new(scene, &mut state).expect("a state");
        let mut loads = Loads::new(scene, &mut loads).expect("loads");
        scene.set(&mut state, &start.0, &start.1, &loads).expect("placed");
        loads.add_pattern(scene, 0, 5.0).expect("a pattern");
        (0..9).for_each(|_| assert_eq!(scene.step(&mut state, &loads), Ok(Status::Moving)));
        (state.zeta().to_vec(), scene.energy(&state).expect("an energy").to_bits())
    };
    let rebound = march(&scene);
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    assert_eq!(march(&Scene::bind(&file, &other, &mut memory, &mut work).expect("bound")), rebound);
}

#[test]
fn the_compliance_is_that_of_the_coming_step() {
    let map = Strained::random([8, 4, 20, 30], 6);
    let bytes = map.file(&StepParameters { alpha: 1.0, beta: 1e-4, ..STEP });
    with_scene::<f64, _>(&bytes, &DEFAULT, |scene, state, loads| {
        let (zeta, rate) = placed(20, 0.5, 4);
        scene.set(state, &zeta, &rate, loads).expect("placed");
        let contact = |nodes, force| Contact::new(Place::triangle(nodes, [0.2, 0.3, 0.5]), force);
        let contacts = [contact([0, 1, 2], [10.0, -20.0, 5.0]), contact([1, 3, 2], [-3.0, 9.0, 30.0])];
        let (mut w, mut work) = ([0.0; 36], vec![0.0; scene.compliance_work(2)]);
        assert_eq!(scene.compliance(&contacts, &mut w, &mut work), Err(LoadError::NeedsState));
        scene.compliance_at(state, &contacts, &mut w, &mut work).expect("a compliance");
        let mut free = [[0.0; 3]; 2];
        loads.add_pattern(scene, 0, 5.0).expect("a pattern");
        scene.free_motion(state, loads, &contacts, &mut free, &mut work).expect("a motion");
        contacts.iter().for_each(|contact| loads.add_contact(scene, contact).expect("a contact"));
        scene.step(state, loads).expect("a step");
        for (c, contact) in contacts.iter().enumerate() {
            for i in 0..3 {
                let forces = contacts.iter().flat_map(|contact| contact.force);
                let row = w[6 * (3 * c + i)..].iter();
                let said = free[c][i] + row.zip(forces).map(|(w, f)| w * f).sum::<f64>();
                let nodes = contact.place.entries();
                let moved: f64 = nodes
                    .map(|(node, weight)| {
                        weight * scene.node(state, node as usize, Field::Displacement).expect("a node")[i]
                    })
                    .sum();
                assert!((said - moved).abs() <= 1e-12, "{said:e} {moved:e}");
            }
        }
    });
    let options = SceneOptions { substeps: Some(2), ..DEFAULT };
    with_scene::<f64, _>(&bytes, &options, |scene, state, _| {
        let contact = Contact::new(Place::triangle([0; 3], [1.0, 0.0, 0.0]), [0.0; 3]);
        let mut work = vec![0.0; scene.compliance_work(1)];
        let refused = scene.compliance_at(state, &[contact], &mut [0.0; 9], &mut work);
        assert_eq!(refused, Err(LoadError::Substeps { substeps: 2 }));
    });
}

#[test]
fn what_the_structure_cannot_do_is_refused_by_name() {
    let bytes = Strained::random([8, 4, 20, 30], 6).file(&STEP);
    let file = File::parse(&bytes).expect("a file");
    assert_eq!(file.minor(), 7);
    for structure in [StructureChoice::Diagonal, StructureChoice::Block, StructureChoice::Exact] {
        let options = SceneOptions { structure, ..DEFAULT };
        assert_eq!(Scene::<f64>::sizes(&file, &options).err(), Some(BindError::NoStructure));
    }
    let mut regions = DEFAULT;
    regions.regions.set_stiffness(0, 2.0).expect("a region");
    assert_eq!(Scene::<f64>::sizes(&file, &regions).err(), Some(BindError::WholeBody));
    let sizes = Scene::<f64>::sizes(&file, &DEFAULT).expect("sizes");
    for (substeps, viscosity, value) in [(0, 0.0, 0.0), (2000, 0.0, 2000.0), (1, -1.0, -1.0)] {
        let options = SceneOptions { substeps: Some(substeps), viscosity, ..DEFAULT };
        let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
        let refused = Scene::<f64>::bind(&file, &options, &mut memory, &mut work).err();
        assert_eq!(refused, Some(BindError::BadOption { value }));
    }
    with_scene::<f64, _>(&bytes, &DEFAULT, |scene, state, loads| {
        assert_eq!(scene.increment_into(&mut [0.0; 1600]), Err(OutputError::NotWithStrain));
        assert_eq!(scene.stress(state, 0), Err(OutputError::NotWithStrain));
        assert_eq!(scene.reaction(state, 0), Err(OutputError::NotWithStrain));
        // A load beyond all numbers is refused, and so is a motion too far for their squares.
        assert_eq!(loads.add_pattern(scene, 0, 1e300), Err(LoadError::NotFinite));
        let r = scene.n_modes();
        scene.set(state, &vec![9e74; r], &vec![9e74; r], loads).expect("in range");
        let far = state.zeta().to_vec();
        assert_eq!(scene.step(state, loads), Err(StepError::NotFinite));
        assert_eq!(state.zeta(), far);
    });
}

#[test]
fn malformed_sizes_and_shapes_are_refused() {
    let sound = Strained::random([3, 2, 7, 12], 1);
    let bytes = sound.file(&STEP);
    check(&bytes).expect("sound");
    // Sizes that the other sections do not have.
    let place = |kind: SectionKind| {
        let stored = File::parse(&bytes).expect("a file").section(kind).expect("there").stored();
        stored.as_ptr() as usize - bytes.as_ptr() as usize
    };
    let at = place(SectionKind::StrainSizes);
    for (number, value) in [(0, 0u32), (0, 8), (0, 2), (1, 5), (1, 1), (2, 6), (2, 13), (3, 0), (3, 2000)] {
        let mut changed = bytes.clone();
        changed[at + 4 * number..at + 4 * number + 4].copy_from_slice(&value.to_le_bytes());
        let refused = File::parse(&changed).err().unwrap_or_else(|| panic!("{number}: {value}"));
        let named = matches!(refused, FormatError::Count { .. } | FormatError::Shape { .. });
        assert!(named, "{number}, {value}: {refused}");
    }
}

#[test]
fn the_check_of_a_file_finds_maps_that_no_body_has() {
    let sound = Strained::random([3, 2, 7, 12], 1);
    let fault = |map: &Strained| check(&map.file(&STEP)).expect_err("unsound").to_string();
    let mut changed = sound.clone();
    changed.linear[5..10].fill(0.0);
    assert!(fault(&changed).contains("row 1 has no linear part"), "{}", fault(&changed));
    let mut changed = sound.clone();
    changed.tail[1] = -4.0;
    assert!(fault(&changed).contains("frequency 1 is -4"), "{}", fault(&changed));
    let mut changed = sound.clone();
    changed.limits[1] = 0.0;
    assert!(fault(&changed).contains("limit 1 is 0"), "{}", fault(&changed));
    let mut changed = sound.clone();
    changed.modes[3] = -2.0;
    assert!(fault(&changed).contains("natural frequency 3 is -2"), "{}", fault(&changed));
    let mut changed = sound;
    changed.quadratic[3] = f64::INFINITY;
    assert!(fault(&changed).contains("StrainQuadratic"), "{}", fault(&changed));
}
