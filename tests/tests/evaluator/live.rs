//! Parameters set while a scene lives: against dense solves, freshly built files and the printed scheme.

use vademecum_eval::{
    BindError, Contact, LoadError, Loads, ParameterError, Place, Scalar, Scene, SceneOptions, State,
    StepError, Structure, StructureChoice,
};
use vademecum_format::scheme::{StageCoefficients, StepParameters, theta};
use vademecum_format::{Element, File};
use vademecum_tests::regions::{NOMINAL, R, Scales, TwoRegions, chebyshev, solve};
use vademecum_tests::stage::with_scene;
use vademecum_tests::synthetic::{Body, Layout, bathe, newmark};
use vademecum_tests::textbook::Textbook;

const STEP: StepParameters =
    StepParameters { time_step: 2e-3, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 };

fn contact() -> Contact {
    Contact::new(Place::triangle([1, 4, 3], [0.2, 0.5, 0.3]), [1.0, -2.0, 0.7])
}

/// Everything a scene wants, on the heap.
struct Lent<T> {
    scene: Vec<T>,
    work: Vec<f64>,
    state: Vec<T>,
    loads: Vec<T>,
}

fn lend<T: Scalar>(file: &File<'_>, options: &SceneOptions) -> Lent<T> {
    let sizes = Scene::<T>::sizes(file, options).expect("options");
    Lent {
        scene: vec![T::ZERO; sizes.scene],
        work: vec![0.0; sizes.work],
        state: vec![T::ZERO; sizes.state],
        loads: vec![T::ZERO; sizes.loads],
    }
}

/// Options for scales and `Δt`, by the file's own parameters.
fn asked(file: &File<'_>, values: &[(&str, f64)]) -> SceneOptions {
    let mut options = SceneOptions { structure: StructureChoice::Block, ..SceneOptions::default() };
    for &(name, value) in values {
        let index = SceneOptions::find(file.metadata(), name).expect("a parameter of this name");
        options.set(file.metadata(), &[(index, value)]).expect("in range");
    }
    options
}

/// `ζ` after each of 50 steps: 20 under contact and pattern from a moving start, then free.
fn march<T: Scalar>(scene: &Scene<'_, T>, state: &mut State<'_, T>, loads: &mut Loads<'_, T>) -> Vec<T> {
    let start: Vec<T> = (0..3 * R).map(|k| T::from_f64(0.01 * (k as f64 - 3.0))).collect();
    state.restore(&start).expect("start");
    loads.clear();
    loads.add_contact(scene, &contact()).expect("contact");
    loads.add_pattern(scene, 0, 0.3).expect("pattern");
    let mut all = vec![];
    for n in 0..50 {
        if n == 20 {
            loads.clear();
        }
        scene.step(state, loads).expect("step");
        all.extend_from_slice(state.zeta());
    }
    all
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let largest = b.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    a.iter().zip(b).fold(0.0f64, |m, (a, b)| m.max((a - b).abs())) / largest
}

#[test]
fn at_the_nodes_the_separated_file_is_the_file_built_there() {
    let body = TwoRegions::new(1);
    let scheme = bathe();
    // Both stages of two time steps are nodes: θ = Δt²/16 and Δt²/9.
    let mut common: Vec<f64> =
        [2e-3f64, 3e-3].iter().flat_map(|dt| [dt * dt / 16.0, dt * dt / 9.0]).collect();
    common.sort_by(f64::total_cmp);
    let (contrast, density) = ([0.5, 1.0, 2.0], [0.5, 1.0, 2.0]);
    let bytes = body.separated(&scheme, &STEP, &common, &contrast, &density);
    let file = File::parse(&bytes).expect("a file");
    for (dt, s, rho) in [(2e-3, 1.0, 1.0), (3e-3, 2.0, 0.5), (2e-3, 0.5, 2.0), (3e-3, 0.5, 0.5)] {
        let scales = Scales { stiffness: [s, 1.0 / s], density: [1.0, rho] };
        let options = asked(&file, &[("step", dt), ("soft", s), ("hard", 1.0 / s), ("dense", rho)]);
        let live = with_scene::<f64, _>(&bytes, &options, march);
        let step = StepParameters { time_step: dt, ..STEP };
        let built =
            with_scene::<f64, _>(&body.fixed(&scheme, &step, &scales), &SceneOptions::default(), march);
        let error = distance(&live, &built);
        println!("Δt {dt}, scales {scales:?}: {error:.1e}");
        // The coordinates carry a few roundings (ε each), the cardinal functions of nodes 1.8 apart or less
        // turn them into a few times as much in E, and a fault of E grows at most with the square of the
        // steps, 50²/2.
        assert!(error < 10.0 * f64::EPSILON * 1250.0, "{error:e}");
    }
    let nominal =
        with_scene::<f64, _>(&body.fixed(&scheme, &STEP, &NOMINAL), &SceneOptions::default(), march);
    let options = asked(&file, &[("soft", 2.0), ("hard", 0.5)]);
    let moved = with_scene::<f64, _>(&bytes, &options, march);
    assert!(distance(&moved, &nominal) > 1e-3, "the scales matter");
}

/// `E` and the rows of `H` at node 1 as one step shows them: Newmark without damping gives
/// `ζ_1 = ζ_0 + E ζ_0 + Δt²/m̃ HᵀF`.
fn response_by_stepping(bytes: &[u8], options: &SceneOptions, load_weight: f64) -> Vec<f64> {
    with_scene::<f64, _>(bytes, options, |scene, state, loads| {
        let mut found = vec![0.0; R * R];
        for column in 0..R {
            let mut start = [0.0; 3 * R];
            start[column] = 1.0;
            state.restore(&start).expect("start");
            scene.step(state, loads).expect("step");
            (0..R).for_each(|row| found[row * R + column] = state.zeta()[row] - start[row]);
        }
        for component in 0..3 {
            let mut force = [0.0; 3];
            force[component] = 1.0;
            // Set, and not new: the step shows the map alone, without an acceleration at its start.
            state.restore(&[0.0; 3 * R]).expect("at rest");
            loads.clear();
            loads
                .add_contact(scene, &Contact::new(Place::triangle([1; 3], [1.0, 0.0, 0.0]), force))
                .expect("load");
            scene.step(state, loads).expect("step");
            found.extend(state.zeta().iter().map(|z| z / load_weight));
        }
        found
    })
}

/// The same by dense solves.
fn response_by_solving(body: &TwoRegions, theta: f64, scales: &Scales) -> Vec<f64> {
    let response = body.response(theta, scales);
    let mut all = response.state;
    all.extend((3 * R..6 * R).map(|i| response.load[i] + body.basis[i]));
    all
}

#[test]
fn between_the_nodes_the_error_is_that_of_interpolation() {
    let body = TwoRegions::new(2);
    let scheme = newmark(0.25, 0.5);
    // Δt in [1, 4] ms and both κ in [½, 2]: θ √(κ_0 κ_1) over a factor 64, the contrast over 4.
    let center = 1e-6;
    let mut errors = vec![];
    for n in [5, 9, 13] {
        let common = chebyshev(n, center / 8.0, center * 8.0, true);
        let bytes = body.separated(&scheme, &STEP, &common, &chebyshev(n, 0.5, 2.0, true), &[]);
        let file = File::parse(&bytes).expect("a file");
        let mut worst = 0.0f64;
        for (dt, a, b) in
            [(1.3e-3, 0.6, 1.9), (3.7e-3, 1.1, 0.7), (2.2e-3, 1.7, 1.8), (4e-3, 2.0, 2.0), (1e-3, 0.5, 0.5)]
        {
            let options = asked(&file, &[("step", dt), ("soft", a), ("hard", b)]);
            let step = StepParameters { time_step: dt, ..STEP };
            let stage = StageCoefficients::new(&scheme, &step, 0).expect("stage");
            let found = response_by_stepping(&bytes, &options, stage.load);
            let scales = Scales { stiffness: [a, b], density: [1.0; 2] };
            let expected = response_by_solving(&body, stage.theta, &scales);
            worst = found.iter().zip(&expected).fold(worst, |m, (a, b)| m.max((a - b).abs()));
        }
        errors.push(worst);
    }
    println!("errors of E and H with 5, 9 and 13 points: {errors:?}");
    // In x = ln c the resolvent 1/(1 + θλ) is analytic for |Im x| < π, the contrast's for |Im x| < π/2. The
    // ellipses through half-heights 2.9 and 1.4 around half-ranges ln 8 and ln 2 have ρ = 3.1 and 4.3; on
    // them it is at most 1/sin 2.9 = 4.2 and 1/cos 1.4 = 5.9 large. Interpolation of degree n − 1 errs by 4 M
    // ρ^(1−n)/(ρ − 1) at most, the first axis' error is seen through the second's Lebesgue constant (below 3
    // for n ≤ 13), and the rows of H are √3 of B and thus below 1.
    for (n, error) in [5, 9, 13].into_iter().zip(&errors) {
        let bound = |m: f64, rho: f64| 4.0 * m * rho.powi(1 - n) / (rho - 1.0);
        assert!(*error <= 3.0 * bound(4.2, 3.1) + bound(5.9, 4.3), "{n} points: {error:e}");
    }
    assert!(errors[0] > 1e-6, "five points are not enough to see no interpolation at all: {errors:?}");
}

#[test]
fn with_region_densities_the_block_is_a_general_matrix() {
    let body = TwoRegions::new(3);
    let scheme = newmark(0.25, 0.5);
    let theta = theta(&scheme, &STEP, 0).expect("theta");
    let density = [0.5, 1.0, 2.0];
    let bytes = body.separated(&scheme, &STEP, &[theta, 4.0 * theta], &[0.5, 1.0], &density);
    let file = File::parse(&bytes).expect("a file");
    let load = StageCoefficients::new(&scheme, &STEP, 0).expect("stage").load;
    for rho in density {
        let scales = Scales { stiffness: [1.0; 2], density: [1.0, rho] };
        let found = response_by_stepping(&bytes, &asked(&file, &[("dense", rho)]), load);
        let expected = response_by_solving(&body, theta, &scales);
        // One cardinal function is one, the others vanish up to the rounding of the coordinate; then a few
        // roundings of numbers ≤ 1.
        assert!(
            found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-13),
            "{rho}: {found:?} {expected:?}"
        );
        let turned =
            (0..R * R).fold(0.0f64, |m, ij| m.max((expected[ij] - expected[ij % R * R + ij / R]).abs()));
        assert_eq!(
            turned > 1e-4,
            rho != 1.0,
            "unsymmetric exactly when a density is not nominal: {turned:e}"
        );
    }
}

#[test]
fn setting_a_parameter_is_a_fresh_bind_bit_for_bit() {
    let two = TwoRegions::new(4);
    let common = chebyshev(5, 1e-8, 1e-5, true);
    let regions = two.separated(&bathe(), &STEP, &common, &chebyshev(4, 0.5, 2.0, true), &[0.5, 1.0, 2.0]);
    let values = [("soft", 1.7), ("dense", 0.8), ("step", 1.3e-3), ("hard", 0.6), ("soft", 0.9)];
    fn check<T: Scalar>(bytes: &[u8], values: &[(&str, f64)]) {
        let file = File::parse(bytes).expect("a file");
        let options = asked(&file, &[]);
        let mut lent = lend::<T>(&file, &options);
        let mut scene = Scene::bind(&file, &options, &mut lent.scene, &mut lent.work).expect("bound");
        let mut state = State::new(&scene, &mut lent.state).expect("state");
        let mut loads = Loads::new(&scene, &mut lent.loads).expect("loads");
        for place in 0..values.len() {
            let (name, value) = values[place];
            let index = SceneOptions::find(file.metadata(), name).expect("known");
            scene.set_parameters(&[(index, value)], &mut state, &mut lent.work).expect("set");
            let fresh = asked(&file, &values[..=place]);
            assert_eq!(scene.options(), &fresh);
            let expected = with_scene::<T, _>(bytes, &fresh, march);
            assert_eq!(march(&scene, &mut state, &mut loads), expected, "{name}");
        }
        // Several at once, then back to where it began.
        scene.rebind(&options, &mut lent.work).expect("rebound");
        assert_eq!(scene.step(&mut state, &loads), Err(StepError::NotCarried));
        state.carry(&scene).expect("carried");
        assert_eq!(march(&scene, &mut state, &mut loads), with_scene::<T, _>(bytes, &options, march));
    }
    check::<f64>(&regions, &values);
    check::<f32>(&regions, &values);
}

#[test]
fn what_is_refused_changes_nothing_and_is_named() {
    let body = TwoRegions::new(5);
    // The common axis ends where Δt = 2.4 ms has its later stage: the parameter's own range goes on to 4 ms.
    let common = chebyshev(4, 1e-8, 2.4e-3f64.powi(2) / 9.0, true);
    let bytes = body.separated(&bathe(), &STEP, &common, &chebyshev(4, 0.5, 2.0, true), &[]);
    let file = File::parse(&bytes).expect("a file");
    let options = asked(&file, &[("soft", 1.1)]);
    let mut lent = lend::<f64>(&file, &options);
    let mut scene = Scene::bind(&file, &options, &mut lent.scene, &mut lent.work).expect("bound");
    let mut state = State::new(&scene, &mut lent.state).expect("state");
    let mut loads = Loads::new(&scene, &mut lent.loads).expect("loads");
    let before = march(&scene, &mut state, &mut loads);
    let mut saved = [0.0; 3 * R];
    state.save_into(&mut saved).expect("saved");
    let [soft, step] = ["soft", "step"].map(|name| SceneOptions::find(file.metadata(), name).expect("known"));
    assert_eq!(SceneOptions::find(file.metadata(), "stiff"), None);
    let mut set = |index, value| {
        scene.set_parameters(&[(index, value)], &mut state, &mut lent.work).expect_err("refused")
    };
    for value in [0.49, 2.01, -1.0, f64::INFINITY] {
        let expected = ParameterError::OutsideRange { parameter: soft, value, lower: 0.5, upper: 2.0 };
        assert_eq!(set(soft, value), BindError::Parameter(expected));
    }
    assert!(matches!(set(soft, f64::NAN), BindError::Parameter(ParameterError::OutsideRange { .. })));
    assert_eq!(set(3, 1.0), BindError::Parameter(ParameterError::Unknown { index: 3 }));
    assert!(matches!(set(step, 3e-3), BindError::OutsideAxis { axis: 0, .. }));
    let needed = lent.work.len();
    let short = scene.set_parameters(&[(soft, 1.0)], &mut state, &mut lent.work[1..]);
    assert_eq!(short, Err(BindError::LentMemory { found: needed - 1, needed }));
    let diagonal = SceneOptions { structure: StructureChoice::Diagonal, ..options };
    assert_eq!(scene.rebind(&diagonal, &mut lent.work), Err(BindError::OtherStructure));
    let mut bad = options;
    bad.regions.set_stiffness(1, f64::NAN).expect("a region");
    assert!(matches!(scene.rebind(&bad, &mut lent.work), Err(BindError::BadScale { .. })));
    bad.regions.set_stiffness(1, 1.0).expect("a region");
    bad.regions.set_density(0, 1.1).expect("a region");
    assert!(matches!(scene.rebind(&bad, &mut lent.work), Err(BindError::FixedRegion { .. })));
    bad.regions.set_density(0, 1.0).expect("a region");
    bad.regions.set_stiffness(2, 1.1).expect("a region");
    assert!(matches!(scene.rebind(&bad, &mut lent.work), Err(BindError::FixedRegion { .. })));
    let mut after = [0.0; 3 * R];
    state.save_into(&mut after).expect("saved");
    assert_eq!((saved, scene.options()), (after, &options));
    assert_eq!(march(&scene, &mut state, &mut loads), before);
    // The ends of the ranges are in them, also where products round: both κ at their ends put the contrast at
    // its own.
    for (a, b) in [(0.5, 2.0), (2.0, 0.5)] {
        let ends = asked(&file, &[("soft", a), ("hard", b)]);
        scene.rebind(&ends, &mut lent.work).expect("the ends belong to the range");
    }
    let longest = asked(&file, &[("step", 2.4e-3)]);
    scene.rebind(&longest, &mut lent.work).expect("the end of the common axis");
}

#[test]
fn loads_from_before_a_change_are_refused_until_cleared() {
    let body = TwoRegions::new(6);
    let bytes =
        body.separated(&bathe(), &STEP, &chebyshev(4, 1e-8, 1e-5, true), &chebyshev(4, 0.5, 2.0, true), &[]);
    let file = File::parse(&bytes).expect("a file");
    let options = asked(&file, &[]);
    let mut lent = lend::<f64>(&file, &options);
    let mut scene = Scene::bind(&file, &options, &mut lent.scene, &mut lent.work).expect("bound");
    let mut state = State::new(&scene, &mut lent.state).expect("state");
    let mut loads = Loads::new(&scene, &mut lent.loads).expect("loads");
    loads.add_contact(&scene, &contact()).expect("contact");
    scene.step(&mut state, &loads).expect("step");
    let before = state.zeta().to_vec();
    scene.set_parameters(&[(0, 1.5)], &mut state, &mut lent.work).expect("set");
    assert_eq!(scene.step(&mut state, &loads), Err(StepError::StaleLoads));
    assert_eq!(scene.set(&mut state, &[0.0; R], &[0.0; R], &loads), Err(StepError::StaleLoads));
    assert_eq!(loads.add_contact(&scene, &contact()), Err(LoadError::Stale));
    assert_eq!(loads.add_pattern(&scene, 0, 1.0), Err(LoadError::Stale));
    assert_eq!(state.zeta(), before);
    loads.clear();
    loads.add_contact(&scene, &contact()).expect("fresh");
    scene.step(&mut state, &loads).expect("step");
}

#[test]
fn the_state_is_carried_over_when_the_time_step_changes() {
    let layout = Layout { rows: 3, load_rows: 2, columns: 3, n_interior: 3, r: 6 };
    let body = Body::open(layout, 7);
    let step = StepParameters { time_step: 4e-3, alpha: 0.3, beta: 2e-5, density: 1.0, stiffness: 1.0 };
    let bytes = body.file(&bathe(), &step, Element::F64);
    let file = File::parse(&bytes).expect("a file");
    let options = SceneOptions { structure: StructureChoice::Diagonal, ..SceneOptions::default() };
    let mut lent = lend::<f64>(&file, &options);
    let mut scene = Scene::bind(&file, &options, &mut lent.scene, &mut lent.work).expect("bound");
    assert_eq!(scene.structure(), Structure::Diagonal);
    let mut state = State::new(&scene, &mut lent.state).expect("state");
    let mut loads = Loads::new(&scene, &mut lent.loads).expect("loads");
    // As the formulas do, it starts without an acceleration.
    state.restore(&vec![0.0; 3 * layout.r]).expect("at rest");
    let dofs: Vec<(usize, f64)> = (0..3)
        .flat_map(|n| {
            (0..3).map(move |c| {
                (
                    3 * contact().place.nodes()[n] as usize + c,
                    contact().place.weights()[n] * contact().force[c],
                )
            })
        })
        .collect();
    let (mut worst, mut largest) = (0.0f64, 0.0f64);
    let mut book = Textbook::galerkin(&body, step);
    // Δt, then a quarter of it and a stiffer, lighter body, then twice the first.
    for (dt, stiffness, density) in [(4e-3, 1.0, 1.0), (1e-3, 2.5, 0.7), (8e-3, 2.5, 1.0)] {
        let changed = SceneOptions { time_step: Some(dt), stiffness, density, ..options };
        scene.rebind(&changed, &mut lent.work).expect("rebound");
        state.carry(&scene).expect("carried");
        let mut next =
            Textbook::galerkin(&body, StepParameters { time_step: dt, stiffness, density, ..step });
        next.state = book.state;
        book = next;
        loads.clear();
        loads.add_contact(&scene, &contact()).expect("contact");
        let force = book.force(&dofs);
        for n in 0..60 {
            if n == 30 {
                loads.clear();
            }
            let force = if n < 30 { force.clone() } else { vec![0.0; force.len()] };
            scene.step(&mut state, &loads).expect("step");
            book.bathe(&force, &force);
            for (a, b) in state.zeta().iter().zip(&book.state[0]) {
                worst = worst.max((a - b).abs());
                largest = largest.max(b.abs());
            }
        }
    }
    println!("carried over two changes of the time step: {:.1e}", worst / largest);
    // The printed formulas lose about ε/(ωΔt)² a step, 2.5e-13 at ωΔt = 0.03, over 180 steps and growing with
    // their square: 4e-9.
    assert!(worst < 4e-9 * largest, "{:e}", worst / largest);
}

#[test]
fn energy_and_initial_acceleration_use_the_regions_own_matrices() {
    let body = TwoRegions::new(8);
    let (scales, step) = (Scales { stiffness: [1.7, 0.6], density: [1.0, 1.8] }, STEP);
    let bytes = body.separated(
        &bathe(),
        &step,
        &chebyshev(4, 1e-8, 1e-5, true),
        &chebyshev(4, 0.5, 2.0, true),
        &[0.5, 2.0],
    );
    let file = File::parse(&bytes).expect("a file");
    let mut options = asked(&file, &[("soft", 1.7), ("hard", 0.6), ("dense", 1.8)]);
    (options.density, options.stiffness, options.alpha, options.beta) = (0.9, 1.1, Some(0.2), Some(1e-5));
    let sum = |parts: &[f64], scales: [f64; 2], by: f64| -> Vec<f64> {
        (0..R * R).map(|i| by * (scales[0] * parts[i] + scales[1] * parts[R * R + i])).collect()
    };
    let stiffness = sum(&body.reduced_stiffness(), scales.stiffness, 1.1);
    let mass = sum(&body.reduced_mass(), scales.density, 0.9);
    let times = |a: &[f64], x: &[f64]| -> Vec<f64> {
        (0..R).map(|i| (0..R).map(|j| a[i * R + j] * x[j]).sum()).collect()
    };
    let (zeta, rate) = ([0.01, -0.02, 0.03, 0.005], [1.0, 0.5, -0.3, 2.0]);
    let mut force = [0.0; R];
    for (node, weight) in contact().place.entries() {
        for component in 0..3 {
            let row = (3 * node as usize + component) * R;
            (0..R).for_each(|k| force[k] += weight * contact().force[component] * body.basis[row + k]);
        }
    }
    // M a = f − K (ζ + β ζ̇) − α M ζ̇.
    let damped: Vec<f64> = (0..R).map(|k| zeta[k] + 1e-5 * rate[k]).collect();
    let (elastic, drag) = (times(&stiffness, &damped), times(&mass, &rate));
    let right: Vec<f64> = (0..R).map(|k| force[k] - elastic[k] - 0.2 * drag[k]).collect();
    let acceleration = solve(mass.clone(), right, R);
    let size = acceleration.iter().fold(0.0f64, |m, a| m.max(a.abs()));
    let energy = 0.5 * (0..R).map(|k| zeta[k] * times(&stiffness, &zeta)[k] + rate[k] * drag[k]).sum::<f64>();
    fn check<T: Scalar>(
        bytes: &[u8],
        options: &SceneOptions,
        zeta: &[f64],
        rate: &[f64],
        found: &mut (Vec<f64>, f64),
    ) {
        *found = with_scene::<T, _>(bytes, options, |scene, state, loads| {
            loads.add_contact(scene, &contact()).expect("contact");
            scene.set(state, zeta, rate, loads).expect("set");
            let scaled = state.scaled_acceleration().iter().map(|a| a.to_f64() / STEP.time_step.powi(2));
            (scaled.collect(), scene.energy(state).expect("energy"))
        });
    }
    let mut found = (vec![], 0.0);
    // Rounding in either precision, a dozen of them, through a mass matrix whose condition is at most 1.8.
    check::<f64>(&bytes, &options, &zeta, &rate, &mut found);
    let apart =
        |found: &[f64]| found.iter().zip(&acceleration).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
    assert!(apart(&found.0) < 30.0 * f64::EPSILON * size, "{:?} {acceleration:?}", found.0);
    assert!((found.1 - energy).abs() < 30.0 * f64::EPSILON * energy, "{} {energy}", found.1);
    check::<f32>(&bytes, &options, &zeta, &rate, &mut found);
    assert!(apart(&found.0) < 30.0 * f64::from(f32::EPSILON) * size, "{:?} {acceleration:?}", found.0);
    assert!((found.1 - energy).abs() < 30.0 * f64::from(f32::EPSILON) * energy, "{} {energy}", found.1);
}

#[test]
fn the_diagonal_structure_refuses_a_region_of_its_own() {
    let layout = Layout { rows: 3, load_rows: 2, columns: 3, n_interior: 3, r: 4 };
    let bytes = Body::closed(layout, 9).file(&bathe(), &STEP, Element::F64);
    let file = File::parse(&bytes).expect("a file");
    let mut options = SceneOptions { structure: StructureChoice::Diagonal, ..SceneOptions::default() };
    let mut lent = lend::<f64>(&file, &options);
    let mut scene = Scene::bind(&file, &options, &mut lent.scene, &mut lent.work).expect("bound");
    options.regions.set_stiffness(0, 1.2).expect("a region");
    assert_eq!(scene.rebind(&options, &mut lent.work), Err(BindError::NotDiagonal));
    assert_eq!(Scene::<f64>::sizes(&file, &options), Err(BindError::NotDiagonal));
    // Auto turns to the block structure, which here was not built for it and says so.
    options.structure = StructureChoice::Auto;
    assert_eq!(scene.rebind(&options, &mut lent.work), Err(BindError::NotDiagonal));
    let mut lent = lend::<f64>(&file, &options);
    let refused = Scene::bind(&file, &options, &mut lent.scene, &mut lent.work).map(|_| ());
    assert!(matches!(refused, Err(BindError::FixedRegion { .. })), "{refused:?}");
}
