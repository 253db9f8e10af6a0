//! Bodies of a parametric batch beside a simulation of each, by coordinates over the basis.

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::{BodyOptions, Parametric, ParametricBatch, ParametricError, Simulation};
use vademecum_format::File;
use vademecum_tests::golden;

/// A beam of two regions with loss factors; stiffness, density, one loss factor, β and the step are live.
const BEAM: &str = r#"
[mesh]
block = { lengths = [1.0, 0.1, 0.12], divisions = [8, 1, 1], order = "quadratic" }
[[mesh.region]]
name = "tip"
on = { fraction = { axis = "x", side = "max", fraction = 0.5 } }
[[material]]
young = 2.1e9
poisson = 0.3
density = 1200.0
loss_factor = 0.02
[[support]]
on = { group = "x_min" }
[load]
surface = { group = "z_max" }
[[load.pattern]]
name = "press"
on = { group = "z_max" }
pressure = 200.0
[time]
step = 1e-3
[basis]
modes = 24
[tolerance]
steps = 200
[[parameter]]
name = "root"
kind = "stiffness"
region = "body"
range = [0.25, 4.0]
scale = "log"
[[parameter]]
name = "tip"
kind = "density"
region = "tip"
range = [0.5, 2.0]
[[parameter]]
name = "loss"
kind = "loss-factor"
region = "tip"
range = [0.0, 0.2]
[[parameter]]
name = "beta"
kind = "beta"
range = [0.0, 1e-4]
[[parameter]]
name = "step"
kind = "time-step"
range = [0.5e-3, 2e-3]
"#;

/// Displacement and velocity of a simulation over the basis.
fn motion(model: &Parametric<'_>, one: &Simulation<f64>, values: &[f64], modes: usize) -> [Vec<f64>; 2] {
    let sizes = model.sizes(modes).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work]);
    let tuned = model.solve(values, modes, &mut memory, &mut work).expect("modes");
    let (mut zeta, mut rate) = (vec![0.0; modes], vec![0.0; modes]);
    one.body().coordinates_into(&mut zeta, &mut rate).expect("coordinates");
    [zeta, rate].map(|along| {
        let mut sum = vec![0.0; model.n_basis()];
        for (shape, x) in tuned.shapes().chunks_exact(model.n_basis()).zip(&along) {
            sum.iter_mut().zip(shape).for_each(|(sum, own)| *sum += x * own);
        }
        sum
    })
}

fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |most, x| most.max(x.abs()))
}

/// Three bodies, each set to values of its own before and in the middle of a march under a pattern.
fn compare(bytes: &[u8], modes: usize, sets: [[Vec<f64>; 3]; 2]) {
    let file = File::parse(bytes).expect("a file");
    let model = Parametric::new(&file).expect("parametric");
    let options = BodyOptions { modes: Some(modes), ..BodyOptions::default() };
    let mut memory = vec![f64::NAN; ParametricBatch::len_for(&model, modes, 3).expect("a length")];
    let mut batch = ParametricBatch::new(&model, modes, 3, &mut memory).expect("a batch");
    let open = |_| Simulation::<f64>::with_options(bytes.to_vec(), &options).expect("bound");
    let mut alone: Vec<Simulation<f64>> = (0..3).map(open).collect();
    let mut push = vec![0.0; model.n_basis()];
    model.pattern_row(0, &mut push).expect("a row");
    for sets in &sets {
        for (body, (one, values)) in alone.iter_mut().zip(sets).enumerate() {
            let carried = batch.set_parameters(&model, body, values).expect("set");
            let settings: Vec<(usize, f64)> = values.iter().copied().enumerate().collect();
            one.set_parameters(&settings).expect("set");
            let expected = one.carried().expect("a parametric file");
            let scale = expected.work.abs() + expected.lost_elastic.abs() + f64::MIN_POSITIVE;
            for (found, of_one) in [
                (carried.work, expected.work),
                (carried.lost_kinetic, expected.lost_kinetic),
                (carried.lost_elastic, expected.lost_elastic),
            ] {
                assert!((found - of_one).abs() <= 1e-9 * scale, "{found} {of_one}");
            }
            assert_eq!(batch.values(body), &values[..]);
            let scale = 1.0 + body as f64;
            let start: Vec<f64> = push.iter().map(|x| scale * x).collect();
            batch.load(body, &start, &start).expect("loaded");
            one.clear();
            one.push_pattern(0, scale).expect("loaded");
        }
        for _ in 0..40 {
            assert_eq!(batch.step(), 0);
            alone.iter_mut().for_each(|one| {
                one.step(1).expect("a step");
            });
        }
        for (body, (one, values)) in alone.iter().zip(sets).enumerate() {
            let mut found = [vec![0.0; model.n_basis()], vec![0.0; model.n_basis()]];
            let [displacement, velocity] = &mut found;
            batch.motion_into(body, displacement, velocity).expect("a motion");
            for (found, expected) in found.iter().zip(motion(&model, one, values, modes)) {
                let apart: Vec<f64> = found.iter().zip(&expected).map(|(a, b)| a - b).collect();
                assert!(largest(&expected) > 0.0);
                assert!(largest(&apart) < 1e-11 * largest(&expected), "body {body}: {}", largest(&apart));
            }
            let mut row = vec![0.0; model.n_basis()];
            model.probe_row(0, &mut row).unwrap_or_else(|_| row.copy_from_slice(&push));
            let dot = |x: &[f64]| row.iter().zip(x).map(|(a, b)| a * b).sum::<f64>();
            let [shown, rate] = batch.value(body, &row).expect("a value");
            assert!((shown - dot(&found[0])).abs() <= 1e-12 * shown.abs(), "{shown}");
            assert!((rate - dot(&found[1])).abs() <= 1e-12 * rate.abs(), "{rate}");
        }
    }
}

#[test]
fn each_body_moves_as_a_simulation_at_its_values() {
    let bytes = golden::named("parametric.vdm");
    let of = |values: [f64; 4]| values.to_vec();
    let sets = [
        [of([0.8, 1.7, 1.1, 4e-5]), of([2.0, 0.25, 1.0, 1e-6]), of([0.5, 4.0, 0.5, 1e-4])],
        [of([1.2, 0.7, 1.4, 2e-5]), of([0.6, 1.25, 0.7, 1e-5]), of([1.5, 2.0, 0.9, 1e-6])],
    ];
    compare(&bytes, 3, sets.clone());
    compare(&bytes, 2, sets);
}

#[test]
fn loss_factors_densities_and_steps_are_those_of_each_body() {
    let problem = Problem::parse(BEAM, "beam.toml", std::path::PathBuf::new()).expect("a problem");
    let bytes = build(&problem, &BuildOptions::default(), &Silent).expect("built").either().bytes;
    let of = |values: [f64; 5]| values.to_vec();
    let sets = [
        [of([1.0, 1.0, 0.02, 0.0, 1e-3]), of([0.25, 2.0, 0.2, 1e-5, 5e-4]), of([4.0, 0.5, 0.0, 1e-4, 2e-3])],
        [of([2.0, 0.7, 0.1, 2e-5, 2e-3]), of([0.5, 1.5, 0.0, 0.0, 1e-3]), of([1.5, 0.9, 0.05, 5e-5, 7e-4])],
    ];
    compare(&bytes, 12, sets);
}

#[test]
fn mistakes_are_refused_and_change_nothing() {
    let bytes = golden::named("parametric.vdm");
    let file = File::parse(&bytes).expect("a file");
    let model = Parametric::new(&file).expect("parametric");
    let needed = ParametricBatch::len_for(&model, 3, 2).expect("a length");
    let mut memory = vec![0.0; needed];
    let short = ParametricBatch::new(&model, 3, 2, &mut memory[1..]).expect_err("one number too few");
    assert_eq!(short, ParametricError::LentMemory { what: "numbers of a batch", found: needed - 1, needed });
    assert!(matches!(
        ParametricBatch::len_for(&model, 4, 2),
        Err(ParametricError::Modes { found: 4, most: 3 })
    ));
    let mut batch = ParametricBatch::new(&model, 3, 2, &mut memory).expect("a batch");
    let before = [batch.values(1).to_vec(), batch.eigenvalues(1).to_vec()];
    let set = batch.set_parameters(&model, 1, &[0.8, 1.7, 9.0, 4e-5]);
    assert!(matches!(set, Err(ParametricError::Parameter(_))), "{set:?}");
    let set = batch.set_parameters(&model, 2, &[0.8, 1.7, 1.1, 4e-5]);
    assert_eq!(set, Err(ParametricError::NoBody { body: 2, bodies: 2 }));
    let set = batch.set_parameters(&model, 1, &[0.8]);
    assert!(matches!(set, Err(ParametricError::Values { found: 1, needed: 4 })), "{set:?}");
    let load = batch.load(1, &[f64::NAN, 0.0, 0.0], &[0.0; 3]);
    assert!(matches!(load, Err(ParametricError::Forces { .. })), "{load:?}");
    assert_eq!([batch.values(1).to_vec(), batch.eigenvalues(1).to_vec()], before);
    batch.load(0, &[1.0; 3], &[1.0; 3]).expect("loaded");
    let load = batch.load(1, &[f64::MAX; 3], &[0.0; 3]);
    assert!(matches!(load, Err(ParametricError::Forces { .. })), "{load:?}");
    assert_eq!(batch.step(), 0);
    assert_eq!(batch.value(1, &[1.0; 3]).expect("a value"), [0.0; 2]);
    assert!(batch.value(0, &[1.0; 3]).expect("a value")[0] != 0.0);

    let bytes = golden::named("damped.vdm");
    let file = File::parse(&bytes).expect("a file");
    let model = Parametric::new(&file).expect("parametric");
    let mut memory = vec![0.0; ParametricBatch::len_for(&model, 2, 2).expect("a length")];
    assert_eq!(ParametricBatch::new(&model, 2, 2, &mut memory).err(), Some(ParametricError::Dashpots));
}
