//! Gradients with respect to parameters, from checkpoints: against complex steps of a march by its
//! definition, and against marches of other parameters.

use vademecum_eval::{
    AdjointError, BodyOptions, CheckpointedMarch, Field, MarchRows, Parametric, Place, Scene, SceneOptions,
    Simulation, StructureChoice, Tangents,
};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{File, ParameterRole, SectionKind};
use vademecum_tests::complex_step::{Complex, March, Matrix};
use vademecum_tests::golden::named;
use vademecum_tests::live_beam::LiveBeam;

/// A march: its loads, and what its outputs should be.
#[derive(Clone, Copy)]
struct Course {
    steps: usize,
    /// Size of the outputs.
    size: f64,
}

impl Course {
    fn load(&self, step: usize, load: usize) -> f64 {
        let t = step as f64;
        (0.07 * t + load as f64).sin() * (1.0 - 0.5 * t / self.steps as f64) + 0.2 * (0.9 * t).cos()
    }

    /// Amplitudes at the start and at the end of each step; the loads jump between two steps.
    fn loads(&self, count: usize) -> Vec<f64> {
        let ends = |step: usize| [self.load(step, 0), self.load(step + 1, 0) + 0.1];
        let of_load = |step: usize, at: usize, load: usize| {
            if load == 0 { ends(step)[at] } else { self.load(step + at, load) }
        };
        let mut all = vec![];
        for step in 0..self.steps {
            for at in 0..2 {
                all.extend((0..count).map(|load| of_load(step, at, load)));
            }
        }
        all
    }

    fn target(&self, step: usize, output: usize) -> f64 {
        self.size * (0.05 * step as f64 + output as f64).cos()
    }
}

/// Variables of a gradient: the parameters, all amplitudes, the start.
#[derive(Clone, Debug, PartialEq)]
struct Gradient {
    scalar: f64,
    parameters: Vec<f64>,
    loads: Vec<f64>,
    start: Vec<f64>,
}

/// `½ Σ (o − target)²` and its gradient.
fn gradient(
    march: &mut CheckpointedMarch<'_, '_>,
    (course, outputs, loads): (&Course, usize, usize),
    start: &[f64],
    parameters: usize,
    work: &mut [f64],
) -> Gradient {
    let m = march.n_modes();
    let amplitudes = course.loads(loads);
    let mut found = vec![f64::NAN; course.steps * outputs];
    let mut gradient = Gradient {
        scalar: 0.0,
        parameters: vec![f64::NAN; parameters],
        loads: vec![f64::NAN; amplitudes.len()],
        start: vec![f64::NAN; 2 * m],
    };
    let halves = if start.is_empty() { [&[][..]; 2] } else { [&start[..m], &start[m..]] };
    march.march(halves, &amplitudes, &mut found).expect("a march");
    for (place, value) in found.iter_mut().enumerate() {
        *value -= course.target(place / outputs, place % outputs);
        gradient.scalar += 0.5 * *value * *value;
    }
    march.back(&amplitudes, &found, &mut gradient.loads).expect("a march back");
    march.parameters_into(&mut gradient.parameters, work).expect("parameters");
    let (zeta, rates) = gradient.start.split_at_mut(m);
    march.initial_into(zeta, rates).expect("a start");
    gradient
}

/// The same scalar over complex numbers, of a body with these matrices.
struct Definition<'a> {
    course: &'a Course,
    mass: Matrix,
    damping: Matrix,
    stiffness: Matrix,
    time_step: Complex,
    start: [Vec<Complex>; 2],
    /// Of a load, an imaginary step in one number.
    stepped: Option<usize>,
}

fn scalar(body: &Definition<'_>, outputs: &[(Vec<f64>, Field)], loads: &[Vec<f64>]) -> Complex {
    let mut march = March::new(&body.mass, &body.damping, &body.stiffness, body.time_step);
    march.set(&body.start[0], &body.start[1]);
    let amplitudes = body.course.loads(loads.len());
    let mut sum = Complex::default();
    for step in 0..body.course.steps {
        let force = |at: usize| {
            let mut force = vec![Complex::default(); loads[0].len()];
            for (l, row) in loads.iter().enumerate() {
                let place = (2 * step + at) * loads.len() + l;
                let amplitude = Complex::stepped(amplitudes[place], body.stepped == Some(place));
                force.iter_mut().zip(row).for_each(|(sum, &b)| *sum = *sum + amplitude * Complex::real(b));
            }
            force
        };
        march.step(&force(0), &force(1));
        for (o, (row, field)) in outputs.iter().enumerate() {
            let value = match field {
                Field::Displacement => march.displacement(row),
                Field::Velocity => march.velocity(row),
            };
            let apart = value - Complex::real(body.course.target(step, o));
            sum = sum + Complex::real(0.5) * apart * apart;
        }
    }
    sum
}

/// Largest distance over the largest number.
fn distance(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let size = expected.iter().fold(f64::MIN_POSITIVE, |m, x| m.max(x.abs()));
    found.iter().zip(expected).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) / size
}

/// The file without damping ratios of its modes: a march by matrices has none.
fn without_ratios(mut bytes: Vec<u8>) -> Vec<u8> {
    overwrite(&mut bytes, SectionKind::DampingRatios, |_, _| 0.0);
    bytes
}

/// Writes numbers of a section anew, from their places and values.
fn overwrite(bytes: &mut [u8], kind: SectionKind, number: impl Fn(usize, &[f64]) -> f64) {
    let file = File::parse(bytes).expect("a file");
    let Some(section) = file.section(kind) else { return };
    let values: Vec<f64> = section.numbers().expect("numbers").iter().collect();
    let raw = section.raw().expect("raw");
    let start = raw.as_ptr() as usize - bytes.as_ptr() as usize;
    for (place, out) in bytes[start..start + 8 * values.len()].chunks_exact_mut(8).enumerate() {
        out.copy_from_slice(&number(place, &values).to_le_bytes());
    }
}

/// The golden model with its second eigenvalue the same as its first at the values as built.
fn equal_pair() -> Vec<u8> {
    let mut bytes = without_ratios(named("parametric.vdm"));
    let triangle = 6;
    overwrite(&mut bytes, SectionKind::LiveStiffness, |place, values| {
        if place % triangle == 2 { values[place - 2] } else { values[place] }
    });
    bytes
}

/// `Σ scale a` of the packed triangles of a model; `scale` is that of a region and may have an imaginary
/// part.
fn combined(packed: &[[u8; 8]], r: usize, scale: impl Fn(usize) -> Complex) -> Matrix {
    let mut out = Matrix::zeros(r, r);
    for (region, own) in packed.chunks_exact(r * (r + 1) / 2).enumerate() {
        let mut own = own.iter().map(|&x| Complex::real(f64::from_le_bytes(x)));
        for i in 0..r {
            for j in 0..=i {
                let value = scale(region) * own.next().expect("a number");
                out.set(i, j, out.at(i, j) + value);
                if i != j {
                    out.set(j, i, out.at(i, j));
                }
            }
        }
    }
    out
}

fn sum_of(a: Complex, x: &Matrix, b: Complex, y: &Matrix) -> Matrix {
    let numbers = x.numbers.iter().zip(&y.numbers).map(|(&x, &y)| a * x + b * y).collect();
    Matrix { numbers, columns: x.columns }
}

/// Compares the gradient of a model of all its modes with complex steps.
fn compare_model(bytes: &[u8], values: &[f64], steps: usize) {
    let file = File::parse(bytes).expect("a file");
    let model = Parametric::new(&file).expect("a model");
    let live = file.live_parameters().expect("live").expect("live");
    let (r, course) = (model.n_basis(), Course { steps, size: 1e-6 });
    let (alpha, h) = (file.metadata().alpha, file.metadata().time_step);
    let row = |fill: &dyn Fn(&mut [f64])| {
        let mut row = vec![0.0; r];
        fill(&mut row);
        row
    };
    let probe = |k: usize| move |out: &mut [f64]| Parametric::new(&file).unwrap().probe_row(k, out).unwrap();
    let node = |k: usize, f: [f64; 3]| {
        move |out: &mut [f64]| Parametric::new(&file).unwrap().node_row(k, f, out).unwrap()
    };
    let outputs = [
        (row(&probe(0)), Field::Displacement),
        (row(&probe(1)).iter().map(|x| 0.01 * x).collect(), Field::Velocity),
        (row(&probe(1)), Field::Displacement),
    ];
    let loads = [row(&node(4, [0.5, -0.25, 1.0])), row(&node(1, [0.1, 0.7, -0.4]))];

    let sizes = model.sizes(r).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work]);
    let tuned = model.solve(values, r, &mut memory, &mut work).expect("solved");
    let flat: Vec<f64> = outputs.iter().flat_map(|own| own.0.clone()).collect();
    let (fields, flat_loads) = (outputs.each_ref().map(|own| own.1), loads.concat());
    let rows = MarchRows { outputs: &flat, fields: &fields, loads: &flat_loads, steps };
    let lent = model.adjoint_sizes(r, &rows).expect("sizes");
    let (mut memory, mut work) = (vec![f64::NAN; lent.memory], vec![f64::NAN; lent.work]);
    // A start along the basis, and the same along the modes: ζ = Xᵀ M u.
    let start: [Vec<f64>; 2] = [
        (0..r).map(|k| 1e-6 * (k as f64 + 1.0).sin()).collect(),
        (0..r).map(|k| 1e-3 * (k as f64).cos()).collect(),
    ];
    let scale = |stepped: Option<usize>, density: bool| {
        let value = move |index: usize| Complex::stepped(values[index], stepped == Some(index));
        move |region: usize| {
            let mut scale = Complex::real(1.0);
            for (index, own) in model.parameters().enumerate() {
                let fits = match own.role {
                    ParameterRole::RegionStiffness { region: own } => !density && own as usize + 1 == region,
                    ParameterRole::RegionDensity { region: own } => density && own as usize + 1 == region,
                    ParameterRole::Stiffness => !density,
                    ParameterRole::Density => density,
                    _ => false,
                };
                if fits {
                    scale = scale * value(index);
                }
            }
            scale
        }
    };
    let mass_at = |stepped| combined(live.mass.expect("a live density"), r, scale(stepped, true));
    let along = |u: &[f64]| -> Vec<f64> {
        let u: Vec<Complex> = u.iter().map(|&x| Complex::real(x)).collect();
        let weighted = mass_at(None).times(&u);
        let shapes = tuned.shapes().chunks_exact(r);
        shapes.map(|shape| shape.iter().zip(&weighted).map(|(x, w)| x * w.re).sum()).collect()
    };
    let modal: Vec<f64> = start.iter().flat_map(|u| along(u)).collect();
    let mut march = CheckpointedMarch::new(&model, tuned, &rows, &mut memory).expect("a march");
    let n = model.n_parameters();
    let found = gradient(&mut march, (&course, 3, 2), &modal, n, &mut work);

    let defined = |parameter: Option<usize>, stepped: Option<usize>, of_start: Option<usize>| {
        let mass = mass_at(parameter);
        let stiffness = combined(live.stiffness, r, scale(parameter, false));
        let beta = model.parameters().position(|own| own.role == ParameterRole::Beta).expect("beta");
        let beta = Complex::stepped(values[beta], parameter == Some(beta));
        let damping = sum_of(Complex::real(alpha), &mass, beta, &stiffness);
        let complex = |part: usize| {
            let own = start[part].iter().enumerate();
            own.map(|(k, &x)| Complex::stepped(x, of_start == Some(part * r + k))).collect()
        };
        let start = [complex(0), complex(1)];
        let time_step = Complex::real(h);
        let body = Definition { course: &course, mass, damping, stiffness, time_step, start, stepped };
        scalar(&body, &outputs, &loads)
    };
    let expected: Vec<f64> = (0..n).map(|k| defined(Some(k), None, None).derivative()).collect();
    let value = defined(None, None, None).re;
    let mut worst = [(found.scalar / value - 1.0).abs(), 0.0, 0.0, 0.0];
    for (k, (found, expected)) in found.parameters.iter().zip(&expected).enumerate() {
        // Each in its own size: a stiffness and a β have nothing to do with each other.
        let apart = (found - expected).abs() / expected.abs();
        println!("{}: {found:e} beside {expected:e}", model.parameters().nth(k).unwrap().name);
        worst[1] = worst[1].max(apart);
    }
    let places = [0, 1, 2, 3, 4 * (steps / 2) + 1, 4 * steps - 1];
    let of_loads: Vec<f64> =
        places.iter().map(|&place| defined(None, Some(place), None).derivative()).collect();
    worst[2] = distance(&places.map(|place| found.loads[place]), &of_loads);
    // Along the basis the gradient of the start is M X times that of the modes.
    for part in 0..2 {
        let of_basis: Vec<f64> =
            (0..r).map(|k| defined(None, None, Some(part * r + k)).derivative()).collect();
        let own = &found.start[part * r..(part + 1) * r];
        let along: Vec<Complex> = (0..r)
            .map(|i| {
                Complex::real(
                    own.iter().zip(tuned.shapes().chunks_exact(r)).map(|(g, shape)| g * shape[i]).sum(),
                )
            })
            .collect();
        let back: Vec<f64> = mass_at(None).times(&along).iter().map(|x| x.re).collect();
        worst[3] = worst[3].max(distance(&back, &of_basis));
    }
    println!("{steps} steps: scalar, parameters, loads, start within {worst:?}");
    assert!(worst.iter().all(|&apart| apart < 1e-9), "{worst:?}");
}

#[test]
fn gradients_of_live_regions_are_complex_steps() {
    let bytes = without_ratios(named("parametric.vdm"));
    for values in [[0.8, 1.7, 1.1, 4e-5], [1.0, 1.0, 1.0, 0.0], [2.0, 0.25, 0.5, 1e-4]] {
        for steps in [1, 2, 60] {
            compare_model(&bytes, &values, steps);
        }
    }
}

#[test]
fn two_thousand_damped_steps_have_the_gradient_of_complex_steps() {
    compare_model(&without_ratios(named("parametric.vdm")), &[0.8, 1.7, 1.1, 4e-5], 2000);
}

#[test]
fn gradients_hold_for_equal_eigenvalues() {
    let bytes = equal_pair();
    compare_model(&bytes, &[1.0, 1.0, 1.0, 4e-5], 60);
    // Eigenvalues that differ by less than the share that counts as near, and by little more.
    for apart in [1e-12, 1e-8, 1e-4, 3e-3] {
        compare_model(&bytes, &[1.0, 1.0 + apart, 1.0, 4e-5], 60);
    }
}

/// The gradient of a scene's march with respect to stiffness, density, `α`, `β` and `Δt`.
fn compare_scene(bytes: &[u8], options: &SceneOptions, steps: usize) {
    let file = File::parse(bytes).expect("a file");
    let sizes = Scene::<f64>::sizes(&file, options).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let scene = Scene::<f64>::bind(&file, options, &mut memory, &mut work).expect("bound");
    let r = scene.n_modes();
    let numbers = |kind| -> Vec<f64> {
        file.section(kind).map_or(vec![0.0; r], |own| own.numbers().unwrap().iter().collect())
    };
    let (eigenvalues, ratios) = (numbers(SectionKind::Eigenvalues), numbers(SectionKind::DampingRatios));
    let mut rows = [vec![0.0; r], vec![0.0; r], vec![0.0; r]];
    scene.probe_row_into(0, &mut rows[0]).expect("a row");
    scene.node_row_into(4, [0.5, -0.25, 1.0], &mut rows[1]).expect("a row");
    scene.pattern_row_into(0, &mut rows[2]).expect("a row");
    let [probe, node, pattern] = rows;
    let course = Course { steps, size: 1e-6 };
    let slow: Vec<f64> = node.iter().map(|x| 0.01 * x).collect();
    let outputs = [(probe.clone(), Field::Displacement), (slow.clone(), Field::Velocity)];
    let loads = [pattern.clone(), node.clone()];
    let (flat, flat_loads) = ([probe, slow].concat(), [pattern, node].concat());
    let fields = [Field::Displacement, Field::Velocity];
    let rows = MarchRows { outputs: &flat, fields: &fields, loads: &flat_loads, steps };
    let lent = scene.march_sizes(&rows).expect("sizes");
    let mut memory = vec![f64::NAN; lent.memory];
    let mut march = CheckpointedMarch::of_scene(&scene, &rows, &mut memory).expect("a march");
    let start: Vec<f64> = (0..2 * r).map(|k| if k < r { 1e-6 } else { 1e-3 } * (k as f64).sin()).collect();
    let found = gradient(&mut march, (&course, 2, 2), &start, 5, &mut []);

    let StepParameters { time_step, alpha, beta, density, stiffness } = *scene.parameters();
    let defined = |stepped: usize| {
        let all = [stiffness, density, alpha, beta, time_step];
        let [stiffness, density, alpha, beta, time_step] =
            std::array::from_fn(|k| Complex::stepped(all[k], k == stepped));
        let mass = Matrix::diagonal(&vec![density; r]);
        let own: Vec<Complex> = eigenvalues.iter().map(|&x| Complex::real(x) * stiffness).collect();
        let damping: Vec<Complex> = own
            .iter()
            .zip(&ratios)
            .map(|(&k, &ratio)| {
                let modal = if ratio == 0.0 {
                    Complex::default()
                } else {
                    Complex::real(2.0 * ratio) * (k / density).root() * density
                };
                alpha * density + beta * k + modal
            })
            .collect();
        let complex = |part: usize| (0..r).map(|k| Complex::real(start[part * r + k])).collect();
        let (damping, stiffness) = (Matrix::diagonal(&damping), Matrix::diagonal(&own));
        let start = [complex(0), complex(1)];
        let body = Definition { course: &course, mass, damping, stiffness, time_step, start, stepped: None };
        scalar(&body, &outputs, &loads)
    };
    let mut worst = (found.scalar / defined(9).re - 1.0).abs();
    for (k, found) in found.parameters.iter().enumerate() {
        let expected = defined(k).derivative();
        let name = ["stiffness", "density", "alpha", "beta", "step"][k];
        println!("{name}: {found:e} beside {expected:e}");
        worst = worst.max((found - expected).abs() / expected.abs());
    }
    assert!(worst < 1e-9, "{worst:e}");
}

fn exact() -> SceneOptions {
    SceneOptions { structure: StructureChoice::Exact, ..SceneOptions::default() }
}

#[test]
fn gradients_of_a_body_with_fixed_regions_are_complex_steps() {
    for (name, beta) in [("exact-f64.vdm", 2e-5), ("stress.vdm", 1e-4), ("reactions.vdm", 0.0)] {
        let bytes = named(name);
        compare_scene(&bytes, &SceneOptions { beta: Some(beta), ..exact() }, 50);
        let changed = SceneOptions { stiffness: 1.7, density: 0.6, beta: Some(beta), ..exact() };
        compare_scene(&bytes, &SceneOptions { time_step: Some(2e-3), ..changed }, 50);
    }
    compare_scene(&named("exact-f64.vdm"), &SceneOptions { beta: Some(2e-5), ..exact() }, 2000);
}

#[test]
fn critical_damping_and_modes_without_stiffness_are_no_special_cases() {
    let mut bytes = without_ratios(named("exact-f64.vdm"));
    let file = File::parse(&bytes).expect("a file");
    let eigenvalues: Vec<f64> =
        file.section(SectionKind::Eigenvalues).unwrap().numbers().unwrap().iter().collect();
    for omega in eigenvalues.iter().map(|value| value.sqrt()) {
        for share in [1.0, 1.0 + 1e-9, 3.0] {
            let alpha = Some(2.0 * omega * share);
            compare_scene(&bytes, &SceneOptions { alpha, beta: Some(0.0), ..exact() }, 50);
        }
    }
    // A mode without stiffness: a body that its host moves.
    overwrite(
        &mut bytes,
        SectionKind::Eigenvalues,
        |place, values| {
            if place == 0 { 0.0 } else { values[place] }
        },
    );
    compare_scene(&bytes, &SceneOptions { beta: Some(2e-5), ..exact() }, 50);
}

#[test]
fn a_checkpointed_march_is_refused_by_name() {
    let bytes = named("parametric.vdm");
    let file = File::parse(&bytes).expect("a file");
    let model = Parametric::new(&file).expect("a model");
    let r = model.n_basis();
    let (row, fields) = (vec![1.0; r], [Field::Displacement]);
    let rows = MarchRows { outputs: &row, fields: &fields, loads: &row, steps: 9 };
    let short = MarchRows { outputs: &row[1..], ..rows };
    let refused = Err(AdjointError::Length { found: r - 1, needed: r });
    assert_eq!(model.adjoint_sizes(r, &short).map(drop), refused);
    let sizes = model.sizes(r).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work]);
    let tuned = model.solve(&[1.0, 1.0, 1.0, 0.0], r, &mut memory, &mut work).expect("solved");
    let lent = model.adjoint_sizes(r, &rows).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; lent.memory], vec![0.0; lent.work]);
    assert!(matches!(
        CheckpointedMarch::new(&model, tuned, &rows, &mut memory[1..]),
        Err(AdjointError::Bind(_))
    ));
    let mut march = CheckpointedMarch::new(&model, tuned, &rows, &mut memory).expect("a march");
    let (loads, mut outputs) = (vec![1.0; 18], vec![0.0; 9]);
    assert_eq!(march.back(&loads, &outputs, &mut []), Err(AdjointError::NoMarch));
    let wrong = march.march([&[]; 2], &loads[1..], &mut outputs);
    assert_eq!(wrong, Err(AdjointError::Length { found: 17, needed: 18 }));
    let infinite = vec![f64::INFINITY; 18];
    assert_eq!(march.march([&[]; 2], &infinite, &mut outputs), Err(AdjointError::NotFinite));
    assert_eq!(march.back(&loads, &outputs, &mut []), Err(AdjointError::NoMarch));
    march.march([&[]; 2], &loads, &mut outputs).expect("a march");
    let mut out = [0.0; 4];
    assert_eq!(march.parameters_into(&mut out, &mut work), Err(AdjointError::NoMarch));
    assert_eq!(march.of_load_row(0, &row), Err(AdjointError::NoMarch));
    let [mut zeta, mut rate] = [(); 2].map(|()| vec![0.0; r]);
    assert_eq!(march.initial_into(&mut zeta, &mut rate), Err(AdjointError::NoMarch));
    march.back(&loads, &outputs, &mut []).expect("a march back");
    assert!(march.parameters_into(&mut out, &mut work[1..]).is_err());
    assert_eq!(march.parameters_into(&mut out, &mut work), Ok(()));
    assert!(out[..3].iter().all(|x| x.is_finite() && *x != 0.0), "{out:?}");
    assert!(march.of_load_row(0, &row).is_ok_and(|x| x.is_finite() && x != 0.0));
    assert_eq!(march.of_load_row(1, &row), Err(AdjointError::NoLoad { index: 1, count: 1 }));
}

const FORCE: [f64; 3] = [0.2, -0.7, 1.0];

/// The last node that a force moves.
fn loaded_node(model: &Parametric<'_>) -> usize {
    let mut row = vec![0.0; model.n_basis()];
    let mut moves = |node: &usize| {
        model.node_row(*node, FORCE, &mut row).expect("a node");
        row.iter().any(|&x| x != 0.0)
    };
    (0..model.file().metadata().n_load_nodes as usize).rev().find(|node| moves(node)).expect("a node")
}

/// Gradient of the sum of an output over the march, by going back and by the derivatives of all steps.
fn beside_tangents(bytes: &[u8], values: &[f64], modes: usize, steps: usize) -> Vec<f64> {
    let file = File::parse(bytes).expect("a file");
    let model = Parametric::new(&file).expect("a model");
    let (r, n) = (model.n_basis(), model.n_parameters());
    let (mut probe, mut load) = (vec![0.0; r], vec![0.0; r]);
    model.probe_row(1, &mut probe).expect("a probe");
    model.node_row(loaded_node(&model), FORCE, &mut load).expect("a node");
    let course = Course { steps, size: 1e-6 };
    let amplitudes = course.loads(1);
    let sizes = model.sizes(modes).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work]);
    let tuned = model.solve(values, modes, &mut memory, &mut work).expect("solved");

    let sizes = model.tangent_sizes(modes);
    let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work]);
    let mut tangents = Tangents::new(&model, tuned, &mut memory, &mut work).expect("tangents");
    let (mut expected, mut values) = (vec![0.0; n], vec![]);
    for step in 0..steps {
        let force = |at: usize| load.iter().map(|x| amplitudes[2 * step + at] * x).collect::<Vec<_>>();
        tangents.step(&force(0), &force(1));
        for field in [Field::Displacement, Field::Velocity] {
            values.push(tangents.value(&probe, field));
            for (k, sum) in expected.iter_mut().enumerate() {
                *sum += tangents.slope(&probe, field, k);
            }
        }
    }
    let outputs = [&probe[..], &probe[..]].concat();
    let fields = [Field::Displacement, Field::Velocity];
    let rows = MarchRows { outputs: &outputs, fields: &fields, loads: &load, steps };
    let sizes = model.adjoint_sizes(modes, &rows).expect("sizes");
    let (mut memory, mut work) = (vec![f64::NAN; sizes.memory], vec![f64::NAN; sizes.work]);
    let mut march = CheckpointedMarch::new(&model, tuned, &rows, &mut memory).expect("a march");
    let (mut found, mut slopes) = (vec![0.0; 2 * steps], vec![0.0; n]);
    march.march([&[]; 2], &amplitudes, &mut found).expect("a march");
    assert!(distance(&found, &values) < 1e-12);
    march.back(&amplitudes, &vec![1.0; 2 * steps], &mut []).expect("a march back");
    march.parameters_into(&mut slopes, &mut work).expect("parameters");
    for (k, (found, expected)) in slopes.iter().zip(&expected).enumerate() {
        let name = model.parameters().nth(k).unwrap().name;
        println!("{name}: {found:e} beside {expected:e}");
        assert!((found - expected).abs() < 1e-9 * expected.abs(), "{name}: {found:e} {expected:e}");
    }
    slopes
}

#[test]
fn a_gradient_is_that_of_the_tangents_with_damping_ratios_too() {
    beside_tangents(&named("parametric.vdm"), &[0.8, 1.7, 1.1, 4e-5], 3, 60);
    beside_tangents(&named("parametric.vdm"), &[0.8, 1.7, 1.1, 4e-5], 2, 60);
}

/// The same sum of a body that is set to these values.
fn sum_of_body(bytes: &'static [u8], settings: &[(usize, f64)], modes: usize, steps: usize) -> f64 {
    let scene = SceneOptions { residual: false, ..SceneOptions::default() };
    let options = BodyOptions { scene, modes: Some(modes), ..BodyOptions::default() };
    let mut body = Simulation::<f64>::with_options(bytes, &options).expect("a body");
    body.set_parameters(settings).expect("set");
    let node = loaded_node(&Parametric::new(&File::parse(bytes).expect("a file")).expect("a model"));
    let (amplitudes, place) = (Course { steps, size: 1e-6 }.loads(1), Place::node(node as u32));
    let mut sum = 0.0;
    for step in 0..steps {
        body.clear();
        let (start, end) = (amplitudes[2 * step], amplitudes[2 * step + 1]);
        let [start, end] = [start, end].map(|amplitude| FORCE.map(|force| amplitude * force));
        body.with_body(|body| body.push_ramp(&place, start, end)).expect("pushed");
        body.step(1).expect("a step");
        for field in [Field::Displacement, Field::Velocity] {
            sum += body.probe(1, field).expect("a probe");
        }
    }
    sum
}

/// A beam of square section, whose bending modes come in pairs of one frequency: all modes of its basis
/// against bodies of other parameters, and few of them against their tangents.
#[test]
fn a_gradient_of_a_beam_is_the_difference_of_bodies_of_other_parameters() {
    const STEPS: usize = 80;
    let beam = LiveBeam { regions: 2, height: 0.1, modes: 16, both_ends: false, fine: 2, step: 1e-3 };
    let bytes: &'static [u8] = beam.build(None).leak();
    let file = File::parse(bytes).expect("a file");
    let model = Parametric::new(&file).expect("a model");
    let r = model.n_basis();
    let values = [0.8, 1.3, 1.2e-4];
    beside_tangents(bytes, &values, 10, STEPS);
    beside_tangents(bytes, &values, r, 2000);
    let found = beside_tangents(bytes, &values, r, STEPS);
    for (index, found) in found.iter().enumerate() {
        let at = |share: f64| {
            let value = |k: usize| values[k] * if k == index { 1.0 + share } else { 1.0 };
            let settings: Vec<_> = (0..values.len()).map(|k| (k, value(k))).collect();
            sum_of_body(bytes, &settings, r, STEPS)
        };
        // Richardson's extrapolation of central differences.
        let central = |share: f64| (at(share) - at(-share)) / (2.0 * share * values[index]);
        let expected = (4.0 * central(1e-3) - central(2e-3)) / 3.0;
        println!("{index}: {found:e} beside {expected:e}");
        assert!((found - expected).abs() < 1e-7 * expected.abs(), "{index}: {found:e} beside {expected:e}");
    }
}
