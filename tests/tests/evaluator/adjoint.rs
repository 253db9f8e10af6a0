//! Gradients of a march by its adjoint: against differences of marches, which a linear march has exactly, and
//! against complex steps of a march by its definition.

use vademecum_eval::{
    Adjoint, AdjointError, Assembly, AssemblyOptions, BaseMotion, Batch, BatchAdjoint, Body, BodyOptions,
    Contact, Cotangents, End, Field, Joint, Loads, Part, Place, Pose, Scene, SceneOptions, State, Structure,
    StructureChoice, gradient_on_triangle,
};
use vademecum_format::File;
use vademecum_format::scheme::StepParameters;
use vademecum_tests::complex_step::{Complex, March, Matrix};
use vademecum_tests::golden::{named, with_dashpots};
use vademecum_tests::stage::with_scene;
use vademecum_tests::synthetic::{Body as Synthetic, Layout, Random, bathe};

// With the kinds and elements of a file.
include!("../../../crates/vademecum-eval/doc/masses.rs");

const STEPS: usize = 25;

fn exact() -> SceneOptions {
    SceneOptions { structure: StructureChoice::Exact, ..SceneOptions::default() }
}

fn place() -> Place {
    Place::triangle([1, 4, 3], [0.2, 0.5, 0.3])
}

/// Everything that a march depends on.
#[derive(Clone)]
struct Inputs {
    /// A force at its start and at its end, for each step.
    forces: Vec<[[f64; 3]; 2]>,
    /// Amplitudes of a pattern alike.
    amplitudes: Vec<[f64; 2]>,
    place: Place,
    zeta: Vec<f64>,
    rates: Vec<f64>,
}

impl Inputs {
    fn random(r: usize, steps: usize, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let mut triple = || [random.number(), random.number(), random.number()];
        let forces = (0..steps).map(|_| [triple(), triple()]).collect();
        let amplitudes = (0..steps).map(|_| [triple()[0], triple()[0]]).collect();
        let zeta = (0..r).map(|_| 1e-3 * triple()[0]).collect();
        let rates = (0..r).map(|_| triple()[0]).collect();
        Self { forces, amplitudes, place: place(), zeta, rates }
    }
}

/// Weights of the outputs after each step in the scalar.
struct Weights {
    probe: [f64; 2],
    point: [[f64; 3]; 2],
    stress: Option<[f64; 6]>,
    reaction: Option<[f64; 6]>,
}

/// Outputs beside those that every file has.
#[derive(Clone, Copy, Default)]
struct More {
    stress: bool,
    reaction: bool,
}

const PLAIN: More = More { stress: false, reaction: false };
const STRESS: More = More { stress: true, reaction: false };
const REACTION: More = More { stress: false, reaction: true };

impl Weights {
    fn random(more: More, steps: usize) -> Vec<Self> {
        let mut random = Random::new(77);
        let mut triple = || [random.number(), random.number(), random.number()];
        let mut one = || Self {
            probe: [triple()[0], 1e-2 * triple()[0]],
            point: [triple(), triple().map(|x| 1e-2 * x)],
            stress: more.stress.then(|| six(&mut triple, 1e-4)),
            reaction: more.reaction.then(|| six(&mut triple, 1e-3)),
        };
        (0..steps).map(|_| one()).collect()
    }
}

/// Six numbers of a size.
fn six(triple: &mut impl FnMut() -> [f64; 3], size: f64) -> [f64; 6] {
    let ([a, b, c], [d, e, f]) = (triple(), triple());
    [a, b, c, d, e, f].map(|x| size * x)
}

/// Place at which outputs are read: it shares nodes with the place of the force, or neighbours it.
fn read_at() -> Place {
    Place::triangle([0, 1, 3], [0.1, 0.3, 0.6])
}

const FIELDS: [Field; 2] = [Field::Displacement, Field::Velocity];

/// The scalar of a march.
fn scalar(
    scene: &Scene<'_, f64>,
    state: &mut State<'_, f64>,
    loads: &mut Loads<'_, f64>,
    inputs: &Inputs,
    weights: &[Weights],
) -> f64 {
    let mut sum = 0.0;
    loads.clear();
    state.rest();
    scene.set(state, &inputs.zeta, &inputs.rates, loads).expect("set");
    for ((forces, amplitudes), weights) in inputs.forces.iter().zip(&inputs.amplitudes).zip(weights) {
        loads.clear();
        for (force, at) in forces.iter().zip([[1.0, 0.0], [0.0, 1.0]]) {
            let mut course = [0.0; 4];
            course[..2].copy_from_slice(&at);
            loads.add_contact_staged(scene, &Contact::new(inputs.place, *force), &course).expect("a contact");
        }
        let mut course = [0.0; 4];
        course[..2].copy_from_slice(amplitudes);
        loads.add_pattern_staged(scene, 0, &course).expect("a pattern");
        scene.step(state, loads).expect("a step");
        for (k, field) in FIELDS.into_iter().enumerate() {
            sum += weights.probe[k] * scene.probe(state, 0, field).expect("a probe");
            let moved = scene.point(state, &read_at(), field).expect("a point");
            sum += moved.iter().zip(weights.point[k]).map(|(a, b)| a * b).sum::<f64>();
        }
        if let Some(own) = weights.stress {
            let stress = scene.stress(state, 1).expect("a stress").0;
            sum += stress.iter().zip(own).map(|(a, b)| a * b).sum::<f64>();
        }
        if let Some(own) = weights.reaction {
            let reaction = scene.reaction(state, 0).expect("a reaction").total();
            sum += reaction.iter().zip(own).map(|(a, b)| a * b).sum::<f64>();
        }
    }
    sum
}

/// The gradient of the scalar, in the layout of the inputs.
struct Found {
    forces: Vec<[[f64; 3]; 2]>,
    amplitudes: Vec<[f64; 2]>,
    /// With respect to the weights of the place, summed over the march.
    place: [f64; 3],
    zeta: Vec<f64>,
    rates: Vec<f64>,
}

fn gradient(scene: &Scene<'_, f64>, inputs: &Inputs, weights: &[Weights]) -> Found {
    let (r, steps) = (scene.n_modes(), weights.len());
    let sizes = scene.adjoint_sizes().expect("sizes");
    let (mut memory, mut lent) = (vec![f64::NAN; sizes.adjoint], vec![f64::NAN; sizes.cotangents]);
    let mut adjoint = Adjoint::new(scene, &mut memory).expect("an adjoint");
    let mut cotangents = Cotangents::new(scene, &mut lent).expect("cotangents");
    let mut found = Found {
        forces: vec![[[0.0; 3]; 2]; steps],
        amplitudes: vec![[0.0; 2]; steps],
        place: [0.0; 3],
        zeta: vec![0.0; r],
        rates: vec![0.0; r],
    };
    for step in (0..steps).rev() {
        cotangents.clear();
        let weights = &weights[step];
        for (k, field) in FIELDS.into_iter().enumerate() {
            cotangents.add_probe(scene, 0, field, weights.probe[k]).expect("a probe");
            cotangents.add_point(scene, &read_at(), field, weights.point[k]).expect("a point");
        }
        if let Some(own) = weights.stress {
            cotangents.add_stress(scene, 1, own).expect("a stress");
        }
        if let Some(own) = weights.reaction {
            cotangents.add_reaction(scene, 0, own).expect("a reaction");
        }
        adjoint.back(scene, &cotangents).expect("a step back");
        found.forces[step] = adjoint.force(scene, &inputs.place).expect("a force");
        found.amplitudes[step] = adjoint.pattern(scene, 0).expect("a pattern");
        let mut own = [0.0; 3];
        adjoint.place(scene, &inputs.place, inputs.forces[step], &mut own).expect("a place");
        found.place.iter_mut().zip(own).for_each(|(sum, x)| *sum += x);
    }
    adjoint.initial_into(scene, &mut found.zeta, &mut found.rates).expect("the start");
    found
}

/// Compares every number of the gradient with a central difference of marches. They are linear in each input
/// but for the product of force and place, so a difference has no error but rounding.
fn compare(bytes: &[u8], options: &SceneOptions, more: More) {
    with_scene::<f64, ()>(bytes, options, |scene, state, loads| {
        let (r, weights) = (scene.n_modes(), Weights::random(more, STEPS));
        let inputs = Inputs::random(r, STEPS, 5);
        let found = gradient(scene, &inputs, &weights);
        let mut difference = |change: &dyn Fn(&mut Inputs, f64)| {
            let mut at = |h: f64| {
                let mut inputs = inputs.clone();
                change(&mut inputs, h);
                scalar(scene, state, loads, &inputs, &weights)
            };
            0.5 * (at(1.0) - at(-1.0))
        };
        let close = |what: &str, found: &[f64], expected: &[f64]| {
            let size = expected.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            assert!(size > 0.0, "{what} has no effect");
            for (k, (a, b)) in found.iter().zip(expected).enumerate() {
                assert!((a - b).abs() < 1e-9 * size, "{what} {k}: {a:e} beside {b:e} of {size:e}");
            }
        };
        let mut expected = vec![];
        for step in 0..STEPS {
            for end in 0..2 {
                for c in 0..3 {
                    expected.push(difference(&|inputs, h| inputs.forces[step][end][c] += h));
                }
            }
        }
        close("force", found.forces.as_flattened().as_flattened(), &expected);
        let mut expected = vec![];
        for step in 0..STEPS {
            for end in 0..2 {
                expected.push(difference(&|inputs, h| inputs.amplitudes[step][end] += h));
            }
        }
        close("pattern", found.amplitudes.as_flattened(), &expected);
        let mut expected: Vec<f64> = vec![];
        for k in 0..r {
            expected.push(difference(&|inputs, h| inputs.zeta[k] += h));
        }
        close("zeta", &found.zeta, &expected);
        expected.clear();
        for k in 0..r {
            expected.push(difference(&|inputs, h| inputs.rates[k] += h));
        }
        close("rates", &found.rates, &expected);
        // Weights keep their sum.
        let moved = |by: [f64; 3]| {
            move |inputs: &mut Inputs, h: f64| {
                let weights: [f64; 3] = std::array::from_fn(|k| [0.2, 0.5, 0.3][k] + 0.5 * h * by[k]);
                inputs.place = Place::triangle([1, 4, 3], weights);
            }
        };
        let [a, b, c] = found.place;
        let expected =
            [difference(&moved([1.0, -1.0, 0.0])) * 2.0, difference(&moved([0.0, 1.0, -1.0])) * 2.0];
        close("place", &[a - b, b - c], &expected);
    });
}

/// Files whose steps are exact, with residual flexibility, stresses, reactions, a moving base.
#[test]
fn gradients_of_loads_places_and_starts_are_those_of_marches() {
    for (name, more) in [
        ("exact-f64.vdm", PLAIN),
        ("stress.vdm", STRESS),
        ("anisotropic.vdm", STRESS),
        ("reactions.vdm", REACTION),
    ] {
        compare(&named(name), &exact(), more);
    }
}

#[test]
fn residual_flexibility_under_damping_has_its_gradient() {
    for beta in [0.0, 1e-4, 3e-3] {
        let options = SceneOptions { beta: Some(beta), ..exact() };
        compare(&named("stress.vdm"), &options, STRESS);
        compare(&named("reactions.vdm"), &SceneOptions { density: 1.5, ..options }, REACTION);
    }
    compare(&named("stress.vdm"), &SceneOptions { residual: false, ..exact() }, STRESS);
    compare(&named("stress.vdm"), &SceneOptions { stiffness: 2.5, density: 0.7, ..exact() }, STRESS);
}

fn synthetic(r: usize, alpha: f64) -> Vec<u8> {
    let step = StepParameters { time_step: 1e-3, alpha, beta: 1e-6, density: 1.0, stiffness: 1.0 };
    let layout = Layout { rows: 3, load_rows: 2, columns: 4, n_interior: 0, r };
    Synthetic::closed(layout, 11).file(&bathe(), &step, Element::F64)
}

#[test]
fn dashpots_that_couple_the_modes_have_their_gradient() {
    let rows: Vec<f64> = Random::new(2).numbers(2 * 15).iter().map(|x| 3.0 * x).collect();
    compare(&with_dashpots(&synthetic(15, 0.5), &rows), &exact(), PLAIN);
    let rows: Vec<f64> = Random::new(4).numbers(2 * 3).iter().map(|x| 3.0 * x).collect();
    compare(&with_dashpots(&named("reactions.vdm"), &rows), &exact(), REACTION);
    // Without dashpots, more modes than a block of the kernel.
    compare(&synthetic(19, 0.5), &exact(), PLAIN);
}

#[test]
fn a_base_has_the_gradient_of_its_acceleration() {
    with_scene::<f64, ()>(&named("base.vdm"), &exact(), |scene, state, loads| {
        let sizes = scene.adjoint_sizes().expect("sizes");
        let (mut memory, mut lent) = (vec![0.0; sizes.adjoint], vec![0.0; sizes.cotangents]);
        let mut adjoint = Adjoint::new(scene, &mut memory).expect("an adjoint");
        let mut cotangents = Cotangents::new(scene, &mut lent).expect("cotangents");
        cotangents.add_probe(scene, 0, Field::Displacement, 1.0).expect("a probe");
        let mut gradients = vec![];
        for _ in 0..3 {
            adjoint.back(scene, &cotangents).expect("a step back");
            cotangents.clear();
            gradients.push(adjoint.base_acceleration(scene).expect("a base"));
        }
        gradients.reverse();
        for step in 0..3 {
            for axis in 0..3 {
                state.rest();
                for n in 0..3 {
                    loads.clear();
                    let mut motion = BaseMotion::default();
                    motion.acceleration[axis] = if n == step { 1.0 } else { 0.0 };
                    loads.add_base(scene, &motion).expect("a base");
                    scene.step(state, loads).expect("a step");
                }
                let moved = scene.probe(state, 0, Field::Displacement).expect("a probe");
                let found = gradients[step][axis];
                assert!((found - moved).abs() <= 1e-12 * moved.abs(), "{step} {axis}: {found} {moved}");
            }
        }
    });
}

fn numbers(bytes: &[u8], kind: SectionKind) -> Vec<f64> {
    File::parse(bytes).unwrap().section(kind).unwrap().numbers().unwrap().iter().collect()
}

/// Two thousand damped steps, a scalar that is a sum of squares, gradients against complex steps.
#[test]
fn two_thousand_damped_steps_have_the_gradient_of_complex_steps() {
    const LONG: usize = 2000;
    let bytes = synthetic(6, 8.0);
    let options = SceneOptions { residual: false, ..exact() };
    let eigenvalues = numbers(&bytes, SectionKind::Eigenvalues);
    let (probes, patterns) =
        (numbers(&bytes, SectionKind::ProbeRows), numbers(&bytes, SectionKind::PatternBasis));
    with_scene::<f64, ()>(&bytes, &options, |scene, state, loads| {
        let (r, parameters) = (scene.n_modes(), *scene.parameters());
        let load = |n: usize| (0.02 * n as f64).sin() + 0.3 * (0.4 * n as f64).cos();
        let target = |n: usize| 1e-5 * (0.03 * n as f64).cos();
        let (probe, pattern) = (&probes[..r], &patterns[..r]);

        // The scalar ½Σ(o − target)², over complex numbers, with a step in one input.
        let complex = |stepped_load: Option<usize>, start: Option<usize>| {
            let real = |x: f64| Complex::real(x);
            let unit = Matrix::diagonal(&vec![real(1.0); r]);
            let stiffness = Matrix::diagonal(&eigenvalues.iter().map(|&x| real(x)).collect::<Vec<_>>());
            let damping: Vec<_> =
                eigenvalues.iter().map(|x| real(parameters.alpha + parameters.beta * x)).collect();
            let mut march =
                March::new(&unit, &Matrix::diagonal(&damping), &stiffness, real(parameters.time_step));
            let zeta: Vec<_> = (0..r).map(|k| Complex::stepped(1e-4, start == Some(k))).collect();
            let rates: Vec<_> = (0..r).map(|k| Complex::stepped(0.0, start == Some(r + k))).collect();
            march.set(&zeta, &rates);
            let mut sum = Complex::default();
            for n in 0..LONG {
                let held = Complex::stepped(load(n), stepped_load == Some(n));
                let force: Vec<_> = pattern.iter().map(|&b| real(b) * held).collect();
                march.step(&force, &force);
                let apart = march.displacement(probe) - real(target(n));
                sum = sum + real(0.5) * apart * apart;
            }
            sum.derivative()
        };

        // The adjoint, whose cotangents are the outputs less the target.
        scene.set(state, &vec![1e-4; r], &vec![0.0; r], loads).expect("set");
        let mut apart = vec![];
        for n in 0..LONG {
            loads.clear();
            loads.add_pattern(scene, 0, load(n)).expect("a pattern");
            scene.step(state, loads).expect("a step");
            apart.push(scene.probe(state, 0, Field::Displacement).expect("a probe") - target(n));
        }
        let sizes = scene.adjoint_sizes().expect("sizes");
        let (mut memory, mut lent) = (vec![0.0; sizes.adjoint], vec![0.0; sizes.cotangents]);
        let mut adjoint = Adjoint::new(scene, &mut memory).expect("an adjoint");
        let mut cotangents = Cotangents::new(scene, &mut lent).expect("cotangents");
        let mut found = vec![0.0; LONG];
        for n in (0..LONG).rev() {
            cotangents.clear();
            cotangents.add_probe(scene, 0, Field::Displacement, apart[n]).expect("a probe");
            adjoint.back(scene, &cotangents).expect("a step back");
            found[n] = adjoint.pattern(scene, 0).expect("a pattern").iter().sum();
        }
        let (mut zeta, mut rates) = (vec![0.0; r], vec![0.0; r]);
        adjoint.initial_into(scene, &mut zeta, &mut rates).expect("the start");
        let size = found.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let mut worst = 0.0_f64;
        for n in [0, 1, 17, 500, 1000, 1600, 1999] {
            worst = worst.max((found[n] - complex(Some(n), None)).abs() / size);
        }
        for k in 0..r {
            for (found, all, place) in [(zeta[k], &zeta, k), (rates[k], &rates, r + k)] {
                let size = all.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
                worst = worst.max((found - complex(None, Some(place))).abs() / size);
            }
        }
        println!("gradients of 2000 damped steps within {worst:.1e} of complex steps");
        assert!(worst < 1e-9, "{worst:e}");
    });
}

#[test]
fn the_gradient_of_a_batch_is_that_of_each_instance_bit_for_bit() {
    const N: usize = 19;
    for (bytes, seed) in [(named("stress.vdm"), 1), (synthetic(19, 0.5), 2)] {
        with_scene::<f64, ()>(&bytes, &SceneOptions { beta: Some(0.0), ..exact() }, |scene, _, _| {
            let sizes = scene.adjoint_sizes().expect("sizes");
            let mut memory = vec![f64::NAN; BatchAdjoint::len_for(scene, N).expect("a length")];
            let mut batch = BatchAdjoint::new(scene, N, &mut memory).expect("a batch");
            let mut lent = vec![vec![0.0; sizes.adjoint]; N];
            let mut alone: Vec<_> =
                lent.iter_mut().map(|memory| Adjoint::new(scene, memory).expect("an adjoint")).collect();
            let mut of_one = vec![0.0; sizes.adjoint];
            let mut one = Adjoint::new(scene, &mut of_one).expect("an adjoint");
            let mut of_outputs = vec![0.0; sizes.cotangents];
            let mut cotangents = Cotangents::new(scene, &mut of_outputs).expect("cotangents");
            let r = scene.n_modes();
            for step in 0..12 {
                let fill = |cotangents: &mut Cotangents<'_, f64>, instance: usize| {
                    let mut random = Random::new(seed + 100 * step + instance as u64);
                    cotangents.clear();
                    cotangents.add_probe(scene, 0, Field::Velocity, random.number()).expect("a probe");
                    let own = [random.number(), random.number(), random.number()];
                    cotangents.add_point(scene, &read_at(), Field::Displacement, own).expect("a point");
                };
                for (instance, alone) in alone.iter_mut().enumerate() {
                    fill(&mut cotangents, instance);
                    batch.set(scene, instance, &cotangents).expect("set");
                    alone.back(scene, &cotangents).expect("a step back");
                }
                batch.back(scene).expect("a step back");
                for (instance, alone) in alone.iter_mut().enumerate() {
                    fill(&mut cotangents, instance);
                    batch.get(scene, instance, &cotangents, &mut one).expect("an instance");
                    assert_eq!(one.force(scene, &place()), alone.force(scene, &place()));
                    assert_eq!(one.pattern(scene, 0), alone.pattern(scene, 0));
                    let mut starts = [const { Vec::new() }; 4];
                    starts.iter_mut().for_each(|own| own.resize(r, 0.0));
                    let [a, b, c, d] = &mut starts;
                    one.initial_into(scene, a, b).expect("a start");
                    alone.initial_into(scene, c, d).expect("a start");
                    assert_eq!((a, b), (c, d));
                }
            }
            // A batch steps what its scene steps.
            let mut short = [0.0; 3];
            assert!(Batch::new(scene, N, &mut short).is_err());
            assert!(matches!(BatchAdjoint::new(scene, N, &mut short), Err(AdjointError::Bind(_))));
        });
    }
}

/// Outputs of a batch show forces at once, also where a filter would delay them.
#[test]
fn a_batch_under_damping_has_the_gradient_of_what_it_shows() {
    let options = SceneOptions { beta: Some(3e-3), ..exact() };
    with_scene::<f64, ()>(&named("stress.vdm"), &options, |scene, state, loads| {
        let sizes = scene.adjoint_sizes().expect("sizes");
        let (mut lent, mut of_outputs) = (vec![0.0; sizes.adjoint], vec![0.0; sizes.cotangents]);
        let mut adjoint = Adjoint::new(scene, &mut lent).expect("an adjoint");
        let mut cotangents = Cotangents::new(scene, &mut of_outputs).expect("cotangents");
        let own = [0.3, -1.0, 0.7];
        cotangents.add_point(scene, &read_at(), Field::Displacement, own).expect("a point");
        let mut memory = vec![0.0; BatchAdjoint::len_for(scene, 2).expect("a length")];
        let mut backwards = BatchAdjoint::new(scene, 2, &mut memory).expect("a batch");
        backwards.set(scene, 1, &cotangents).expect("set");
        backwards.back(scene).expect("a step back");
        backwards.get(scene, 1, &cotangents, &mut adjoint).expect("an instance");
        let [start, end] = adjoint.force(scene, &place()).expect("a force");

        let mut memory = vec![0.0; Batch::len_for(scene, 2)];
        let mut batch = Batch::new(scene, 2, &mut memory).expect("a batch");
        for component in 0..3 {
            let mut force = [0.0; 3];
            force[component] = 1.0;
            loads.clear();
            loads.add_contact(scene, &Contact::new(place(), force)).expect("a contact");
            state.rest();
            batch.set(1, state).expect("at rest");
            batch.load(scene, 1, loads).expect("loaded");
            batch.step(scene).expect("a step");
            batch.get_under(1, state, loads).expect("an instance");
            let moved = scene.point(state, &read_at(), Field::Displacement).expect("a point");
            let expected: f64 = moved.iter().zip(own).map(|(a, b)| a * b).sum();
            let found = start[component] + end[component];
            assert!((found - expected).abs() < 1e-12 * expected.abs(), "{component}: {found} {expected}");
        }
    });
}

/// Two masses on springs, joined by a bushing: a body like any other.
#[test]
fn a_body_joined_of_two_has_its_gradient() {
    let (first, second) = (mass_on_spring(1.0), mass_on_spring(3.0));
    let [first, second] = [&first, &second].map(|bytes| File::parse(bytes).expect("a file"));
    let parts = [("a", first), ("b", second)];
    let parts = parts.map(|(name, file)| Part::new(name, file, Pose::IDENTITY).expect("a part"));
    let [a, b] = ["a.end", "b.end"].map(|name| End::find(&parts, name).expect("a port"));
    let joints = [Joint::bushing(a, b, &[2.0, 0.0, 0.0, 0.0, 0.0, 0.0])];
    let options = AssemblyOptions::default();
    let sizes = Assembly::sizes(&parts, &joints, &options).expect("sizes");
    let (mut bytes, mut memory, mut work) =
        (vec![0; sizes.bytes], vec![0.0; sizes.memory], vec![0.0; sizes.work]);
    let joined =
        Assembly::bind(&parts, &joints, &options, &mut bytes, &mut memory, &mut work).expect("joined");
    with_scene::<f64, ()>(joined.bytes(), &SceneOptions::default(), |scene, state, loads| {
        let sizes = scene.adjoint_sizes().expect("sizes");
        let (mut lent, mut of_outputs) = (vec![0.0; sizes.adjoint], vec![0.0; sizes.cotangents]);
        let mut adjoint = Adjoint::new(scene, &mut lent).expect("an adjoint");
        let mut cotangents = Cotangents::new(scene, &mut of_outputs).expect("cotangents");
        cotangents.add_coordinates(scene, &[1.0, 0.5], &[-2.0, 0.25]).expect("coordinates");
        let start = ([0.3, -0.7], [1.1, 0.4]);
        for _ in 0..20 {
            adjoint.back(scene, &cotangents).expect("a step back");
            cotangents.clear();
        }
        let (mut zeta, mut rates) = ([0.0; 2], [0.0; 2]);
        adjoint.initial_into(scene, &mut zeta, &mut rates).expect("the start");
        let along = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        scene.set(state, &start.0, &start.1, loads).expect("set");
        for _ in 0..20 {
            scene.step(state, loads).expect("a step");
        }
        let speed: Vec<f64> = state.scaled_velocity().iter().map(|v| v / state.time_step()).collect();
        let expected = along(state.zeta(), &[1.0, 0.5]) + along(&speed, &[-2.0, 0.25]);
        let found = along(&zeta, &start.0) + along(&rates, &start.1);
        assert!((found - expected).abs() < 1e-12 * expected.abs(), "{found} beside {expected}");
    });
}

#[test]
fn a_place_on_a_triangle_moves_in_its_plane() {
    let corners = [[0.1, 0.2, 0.0], [1.3, 0.1, 0.4], [0.2, 0.9, -0.3]];
    let of_weights = [3.0, -1.0, 0.5];
    let gradient = gradient_on_triangle(&corners, &of_weights);
    // Along an edge, a weight goes from one corner to the other.
    for (from, to) in [(0, 1), (1, 2), (2, 0)] {
        let edge: [f64; 3] = std::array::from_fn(|c| corners[to][c] - corners[from][c]);
        let along: f64 = gradient.iter().zip(edge).map(|(g, d)| g * d).sum();
        assert!((along - (of_weights[to] - of_weights[from])).abs() < 1e-13, "{from} {to}");
    }
    assert_eq!(gradient_on_triangle(&[corners[0]; 3], &of_weights), [0.0; 3]);
}

#[test]
fn what_has_no_adjoint_is_refused_by_name() {
    let structure = |name: &str, structure| {
        let options = SceneOptions { structure, ..SceneOptions::default() };
        with_scene::<f64, _>(&named(name), &options, |scene, _, _| scene.adjoint_sizes())
    };
    let refused = |found| Err(AdjointError::Structure { found });
    assert_eq!(structure("bent.vdm", StructureChoice::Auto), refused(Structure::Strain));
    assert_eq!(structure("parameters.vdm", StructureChoice::Auto), refused(Structure::Block));
    assert_eq!(structure("fixed-f64.vdm", StructureChoice::Diagonal), refused(Structure::Diagonal));
    let words = structure("bent.vdm", StructureChoice::Auto).unwrap_err().to_string();
    assert!(words.contains("large displacements have no adjoint"), "{words}");

    let bytes = named("free.vdm");
    let file = File::parse(&bytes).expect("a file");
    for (flight, expected) in [(true, Err(AdjointError::Flies)), (false, Ok(()))] {
        let options = BodyOptions { scene: exact(), flight, ..BodyOptions::default() };
        let mut memory = vec![0.0; Body::<f64>::len_for(&file, &options).expect("a length")];
        let body = Body::<f64>::bind(&file, &options, &mut memory).expect("a body");
        assert_eq!(body.adjoint_sizes().map(drop), expected);
    }

    // Parameters that have changed since.
    vademecum_tests::stage::with_work::<f64, ()>(&named("exact-f64.vdm"), &exact(), |scene, _, _, work| {
        let sizes = scene.adjoint_sizes().expect("sizes");
        let (mut memory, mut lent) = (vec![0.0; sizes.adjoint], vec![0.0; sizes.cotangents]);
        let mut adjoint = Adjoint::new(scene, &mut memory).expect("an adjoint");
        let mut cotangents = Cotangents::new(scene, &mut lent).expect("cotangents");
        assert!(matches!(adjoint.pattern(scene, 99), Err(AdjointError::Load(_))));
        assert!(matches!(adjoint.node(scene, 8), Err(AdjointError::Load(_))));
        let too_large = cotangents.add_probe(scene, 0, Field::Velocity, f64::NAN);
        assert_eq!(too_large, Err(AdjointError::NotFinite));
        assert!(matches!(
            cotangents.add_probe(scene, 99, Field::Velocity, 1.0),
            Err(AdjointError::Output(_))
        ));
        scene.rebind(&SceneOptions { stiffness: 2.0, ..exact() }, work).expect("bound");
        assert_eq!(adjoint.back(scene, &cotangents), Err(AdjointError::Stale));
    });
}
