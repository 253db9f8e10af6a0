//! Sensitivities of parametric models: frequencies, shapes and histories against differences of models that
//! are solved again, with equal eigenvalues, densities and damping.

use vademecum_eval::{Body, BodyOptions, Field, Parametric, ParametricError, Tangents};
use vademecum_format::{File, SectionKind};
use vademecum_tests::golden;
use vademecum_tests::live_beam::LiveBeam;

const STEPS: usize = 60;
/// Relative change of a parameter for a difference.
const CHANGE: f64 = 4e-3;

/// Richardson's extrapolation of central differences: `f` at value plus and minus a change.
fn derivative(change: f64, f: impl Fn(f64) -> Vec<f64>) -> Vec<f64> {
    let central = |h: f64| -> Vec<f64> {
        f(h).into_iter().zip(f(-h)).map(|(plus, minus)| (plus - minus) / (2.0 * h)).collect()
    };
    central(0.5 * change)
        .into_iter()
        .zip(central(change))
        .map(|(near, far)| (4.0 * near - far) / 3.0)
        .collect()
}

/// Eigenvalues and shapes of all modes.
fn modes(model: &Parametric<'_>, values: &[f64]) -> [Vec<f64>; 2] {
    let r = model.n_basis();
    let sizes = model.sizes(r).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work]);
    let tuned = model.solve(values, r, &mut memory, &mut work).expect("solved");
    [tuned.eigenvalues().to_vec(), tuned.shapes().to_vec()]
}

/// A load that rises, falls and turns, over the basis.
fn load(row: &[f64], step: usize) -> Vec<f64> {
    let t = step as f64 / STEPS as f64;
    row.iter().map(|x| x * (9.0 * t).sin() * (1.0 - t)).collect()
}

/// Values of the rows after each step, and the derivatives with respect to each parameter.
fn march(
    model: &Parametric<'_>,
    values: &[f64],
    rows: &[Vec<f64>],
    force: &[f64],
) -> (Vec<f64>, Vec<Vec<f64>>) {
    let r = model.n_basis();
    let sizes = model.sizes(r).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work]);
    let tuned = model.solve(values, r, &mut memory, &mut work).expect("solved");
    let sizes = model.tangent_sizes(r);
    let (mut memory, mut work) = (vec![f64::NAN; sizes.memory], vec![f64::NAN; sizes.work]);
    let mut march = Tangents::new(model, tuned, &mut memory, &mut work).expect("a march");
    let (mut found, mut slopes) = (vec![], vec![vec![]; model.n_parameters()]);
    for step in 0..STEPS {
        march.step(&load(force, step), &load(force, step + 1));
        for row in rows {
            for field in [Field::Displacement, Field::Velocity] {
                found.push(march.value(row, field));
                for (parameter, slopes) in slopes.iter_mut().enumerate() {
                    slopes.push(march.slope(row, field, parameter));
                }
            }
        }
    }
    (found, slopes)
}

/// Largest difference of displacements (or velocities) over the largest of them.
fn distance(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let part = |first: usize| {
        let of = |all: &[f64]| all.iter().skip(first).step_by(2).copied().collect::<Vec<_>>();
        let (found, expected) = (of(found), of(expected));
        let size = expected.iter().fold(f64::MIN_POSITIVE, |m, x| m.max(x.abs()));
        found.iter().zip(&expected).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) / size
    };
    part(0).max(part(1))
}

/// Compares all sensitivities with differences at these values, and prints the largest distances.
fn compare(model: &Parametric<'_>, values: &[f64], rows: &[Vec<f64>], force: &[f64], simple: bool) {
    let r = model.n_basis();
    let sizes = model.sizes(r).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work]);
    let tuned = model.solve(values, r, &mut memory, &mut work).expect("solved");
    let mut work = vec![0.0; model.slope_work()];
    let (_, tangents) = march(model, values, rows, force);
    let mut worst = [0.0_f64; 3];
    for (index, parameter) in model.parameters().enumerate() {
        let at = |change: f64| {
            let mut values = values.to_vec();
            values[index] += change;
            values
        };
        let change = CHANGE * values[index];
        let size = 1.0 / values[index];
        let expected = derivative(change, |h| modes(model, &at(h))[0].clone());
        let mut found = vec![0.0; r];
        tuned.eigenvalue_slopes(model, index, &mut found, &mut work).expect("slopes");
        if simple {
            for ((found, expected), value) in found.iter().zip(&expected).zip(tuned.eigenvalues()) {
                worst[0] = worst[0].max((found - expected).abs() / (value * size));
            }
            let expected = derivative(change, |h| modes(model, &at(h))[1].clone());
            for mode in 0..r {
                let expected = &expected[mode * r..(mode + 1) * r];
                tuned.shape_slope(model, index, mode, &mut found, &mut work).expect("a slope");
                let length =
                    tuned.shapes()[mode * r..(mode + 1) * r].iter().map(|x| x * x).sum::<f64>().sqrt();
                let apart = found.iter().zip(expected).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
                worst[1] = worst[1].max(apart / (length * size));
            }
        }
        let expected = derivative(change, |h| march(model, &at(h), rows, force).0);
        let apart = distance(&tangents[index], &expected);
        println!("{}: tangents of histories within {apart:.1e}", parameter.name);
        worst[2] = worst[2].max(apart);
    }
    let [eigenvalues, shapes, histories] = worst;
    println!("eigenvalues {eigenvalues:.1e}, shapes {shapes:.1e}, histories {histories:.1e}");
    // An eigenvalue is known to ε times the largest, and a difference of them to that over the change; beside
    // it is the fourth power of the change. Histories turn by as many radians as they last, and of a region
    // that hardly strains they are compared with little.
    let (lambda, all) = (tuned.eigenvalues()[0], tuned.eigenvalues()[r - 1]);
    let known = CHANGE.powi(4) + f64::EPSILON * all / (lambda * CHANGE);
    println!("differences are known to {known:.1e}");
    assert!(eigenvalues < 10.0 * known && shapes < 100.0 * known && histories < 100.0 * known, "{worst:?}");
}

fn rows(model: &Parametric<'_>, probes: &[usize]) -> Vec<Vec<f64>> {
    let row = |&probe: &usize| {
        let mut row = vec![0.0; model.n_basis()];
        model.probe_row(probe, &mut row).expect("a probe");
        row
    };
    probes.iter().map(row).collect()
}

#[test]
fn sensitivities_with_live_density_are_differences_of_models() {
    let bytes = golden::named("parametric.vdm");
    let file = File::parse(&bytes).expect("a file");
    let model = Parametric::new(&file).expect("a model");
    let mut force = vec![0.0; model.n_basis()];
    model.node_row(4, [0.5, -0.25, 1.0], &mut force).expect("a node");
    let rows = rows(&model, &[0, 1]);
    compare(&model, &[0.8, 1.7, 1.1, 4e-5], &rows, &force, true);
}

/// The golden model with its second eigenvalue the same as its first at the values as built: the regions
/// share both alike, and couple them.
fn equal_pair() -> Vec<u8> {
    let mut bytes = golden::named("parametric.vdm");
    let file = File::parse(&bytes).expect("a file");
    let raw = file.section(SectionKind::LiveStiffness).expect("a section").raw().expect("raw");
    let (start, length, r) = (raw.as_ptr() as usize - bytes.as_ptr() as usize, raw.len(), 3);
    for triangle in bytes[start..start + length].chunks_exact_mut(8 * r * (r + 1) / 2) {
        let first: [u8; 8] = triangle[..8].try_into().expect("a number");
        triangle[16..24].copy_from_slice(&first);
    }
    // Modes of one frequency and different ratios would have no derivative.
    let file = File::parse(&bytes).expect("a file");
    if let Some(section) = file.section(SectionKind::DampingRatios) {
        let raw = section.raw().expect("raw");
        let start = raw.as_ptr() as usize - bytes.as_ptr() as usize;
        bytes[start..start + 8 * r]
            .chunks_exact_mut(8)
            .for_each(|ratio| ratio.copy_from_slice(&0.03f64.to_le_bytes()));
    }
    bytes
}

#[test]
fn tangents_hold_for_equal_eigenvalues() {
    let bytes = equal_pair();
    let file = File::parse(&bytes).expect("a file");
    let model = Parametric::new(&file).expect("a model");
    let at = [1.0, 1.0, 1.0, 4e-5];
    let [values, _] = modes(&model, &at);
    assert!((values[1] / values[0] - 1.0).abs() < 1e-14, "{values:?}");
    let mut force = vec![0.0; model.n_basis()];
    model.node_row(4, [0.5, -0.25, 1.0], &mut force).expect("a node");
    compare(&model, &at, &rows(&model, &[0, 1]), &force, false);

    let sizes = model.sizes(3).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work]);
    let tuned = model.solve(&at, 3, &mut memory, &mut work).expect("solved");
    let (mut slope, mut work) = (vec![0.0; 3], vec![0.0; model.slope_work()]);
    let equal = tuned.shape_slope(&model, 1, 0, &mut slope, &mut work);
    assert_eq!(equal, Err(ParametricError::EqualModes { first: 0, second: 1 }));
    assert_eq!(tuned.shape_slope(&model, 1, 2, &mut slope, &mut work), Ok(()));
}

#[test]
fn tangents_of_a_beam_are_differences_and_the_march_is_that_of_the_file() {
    let beam = LiveBeam { regions: 4, height: 0.12, modes: 32, both_ends: false, fine: 2, step: 1e-3 };
    let bytes = beam.build(None);
    let file = File::parse(&bytes).expect("a file");
    let model = Parametric::new(&file).expect("a model");
    let mut force = vec![0.0; model.n_basis()];
    model.node_row(file.metadata().n_load_nodes as usize - 1, [0.2, -0.7, 1.0], &mut force).expect("a node");
    let rows = rows(&model, &[1, 5, 8]);
    let at = [0.7, 1.6, 0.9, 1.2, 2e-4];
    compare(&model, &at, &rows, &force, true);

    let sizes = model.sizes(32).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work.max(sizes.write_work)]);
    let tuned = model.solve(&at, 32, &mut memory, &mut work).expect("solved");
    // The same loads through the ordinary file at these values, without residual flexibility.
    let mut written = vec![0; sizes.bytes];
    let set = tuned.write(&model, &mut written, &mut work).expect("written");
    let options = BodyOptions::default();
    let mut options = options;
    options.scene.residual = false;
    let mut memory = vec![0.0; Body::<f64>::len_for(&set, &options).expect("a length")];
    let mut body = Body::<f64>::bind(&set, &options, &mut memory).expect("bound");
    let node = file.metadata().n_load_nodes - 1;
    let place = vademecum_eval::Place::new(&[node], &[1.0]).expect("a place");
    let (found, _) = march(&model, &at, &rows, &force);
    let mut played = vec![];
    let amplitude = |step: usize| {
        let t = step as f64 / STEPS as f64;
        (9.0 * t).sin() * (1.0 - t)
    };
    for step in 0..STEPS {
        let contact = vademecum_eval::Contact::new(place, [0.2, -0.7, 1.0]);
        body.clear();
        let (start, end) = (amplitude(step), amplitude(step + 1));
        body.push_staged(&contact, contact.force, &[start, end, 0.0, 0.0]).expect("pushed");
        body.step().expect("a step");
        for probe in [1, 5, 8] {
            for field in [Field::Displacement, Field::Velocity] {
                played.push(body.probe(probe, field).expect("a probe"));
            }
        }
    }
    let apart = distance(&found, &played);
    println!("march beside the evaluator's body: {apart:.1e}");
    assert!(apart < 1e-9, "{apart:e}");
}
