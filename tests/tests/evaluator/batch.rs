//! Many instances at once: the bits of single steps, faults of one instance kept to itself.

use vademecum_eval::{
    Batch, BatchStatus, Contact, LoadError, Loads, Place, Scalar, Scene, SceneOptions, State, Status,
    StepError, StructureChoice,
};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{Element, File};
use vademecum_tests::stage::with_scene;
use vademecum_tests::synthetic::{Body, Layout, Random, bathe};

const R: usize = 11;
const LAYOUT: Layout = Layout { rows: 3, load_rows: 2, columns: 3, n_interior: 3, r: R };
/// Two full groups and a part of one.
const N: usize = 37;
const STRUCTURES: [StructureChoice; 2] = [StructureChoice::Diagonal, StructureChoice::Block];

fn file(alpha: f64) -> Vec<u8> {
    let step = StepParameters { time_step: 5e-3, alpha, beta: 2e-5, density: 1.0, stiffness: 1.0 };
    Body::open(LAYOUT, 1).file(&bathe(), &step, Element::F32)
}

fn options(structure: StructureChoice) -> SceneOptions {
    SceneOptions { structure, ..SceneOptions::default() }
}

fn contact(force: [f64; 3]) -> Contact {
    Contact::new(Place::triangle([1, 4, 3], [0.2, 0.5, 0.3]), force)
}

fn saved<T: Scalar>(state: &State<'_, T>) -> Vec<T> {
    let mut out = vec![T::ZERO; 3 * R];
    state.save_into(&mut out).expect("length");
    out
}

/// Runs `use_it` with a batch of [`N`], a state and loads.
fn with_batch<T: Scalar>(
    bytes: &[u8],
    options: &SceneOptions,
    use_it: impl FnOnce(&Scene<'_, T>, &mut Batch<'_, T>, &mut State<'_, T>, &mut Loads<'_, T>),
) {
    with_scene::<T, ()>(bytes, options, |scene, state, loads| {
        let mut memory = vec![T::from_f64(f64::NAN); Batch::len_for(scene, N)];
        let mut batch = Batch::new(scene, N, &mut memory).expect("memory");
        use_it(scene, &mut batch, state, loads);
    });
}

/// Loads of instances come and go at random: after every step each instance is, bit for bit, a body stepped
/// alone.
fn bits_are_those_of_single_steps<T: Scalar>(structure: StructureChoice) {
    with_batch::<T>(&file(40.0), &options(structure), |scene, batch, state, loads| {
        let mut random = Random::new(3);
        let mut alone = vec![(saved(state), [0.0; 3]); N];
        for n in 0..200 {
            for (instance, (_, force)) in alone.iter_mut().enumerate() {
                if random.number() < -0.9 {
                    *force = if n > 100 { [0.0; 3] } else { [0; 3].map(|_| random.number()) };
                }
                loads.clear();
                if *force != [0.0; 3] {
                    loads.add_contact(scene, &contact(*force)).expect("contact");
                }
                batch.load(scene, instance, loads).expect("load");
            }
            batch.step(scene).expect("step");
            for (instance, (numbers, force)) in alone.iter_mut().enumerate() {
                loads.clear();
                if *force != [0.0; 3] {
                    loads.add_contact(scene, &contact(*force)).expect("contact");
                }
                state.restore(numbers).expect("state");
                let status = scene.step(state, loads).expect("step");
                *numbers = saved(state);
                assert_eq!(batch.status(instance), Ok(status), "step {n}, instance {instance}");
                batch.get(instance, state).expect("state");
                assert_eq!(&saved(state), numbers, "{structure:?}, step {n}, instance {instance}");
            }
        }
        assert!(alone.iter().any(|(numbers, _)| numbers.iter().any(|&x| x != T::ZERO)));
    });
}

#[test]
fn an_instance_has_the_bits_of_a_body_stepped_alone() {
    for structure in STRUCTURES {
        bits_are_those_of_single_steps::<f32>(structure);
        bits_are_those_of_single_steps::<f64>(structure);
    }
}

#[test]
fn what_is_not_finite_stays_with_its_instance() {
    for structure in STRUCTURES {
        with_batch::<f32>(&file(0.3), &options(structure), |scene, batch, state, loads| {
            loads.add_contact(scene, &contact([1.0, -2.0, 0.7])).expect("contact");
            (0..N).for_each(|instance| batch.load(scene, instance, loads).expect("load"));
            batch.step(scene).expect("step");
            // A force beyond f32 is refused where it is given …
            loads.clear();
            let beyond = loads.add_contact(scene, &contact([1e300, 0.0, 0.0]));
            assert_eq!(beyond, Err(LoadError::NotFinite));
            // … and a state whose numbers sum to too much, where it is stepped.
            let huge = vec![9e17; 3 * R];
            state.restore(&huge).expect("finite");
            batch.set(5, state).expect("state");
            batch.get(4, state).expect("state");
            let neighbour = saved(state);
            let status = batch.step(scene).expect("step");
            assert_eq!(status, BatchStatus { moving: N - 1, at_rest: 0, refused: 1 });
            assert_eq!(batch.status(5), Err(StepError::NotFinite));
            batch.get(5, state).expect("state");
            assert_eq!(saved(state), huge, "the refused state stays");
            batch.get(4, state).expect("state");
            assert_ne!(saved(state), neighbour, "the neighbour goes on");
            // Put right, it moves again.
            state.restore(&neighbour).expect("finite");
            batch.set(5, state).expect("state");
            assert_eq!(batch.step(scene).expect("step").refused, 0);
        });
    }
}

#[test]
fn instances_rest_alone_and_wake_on_a_load() {
    for structure in STRUCTURES {
        with_batch::<f32>(&file(300.0), &options(structure), |scene, batch, _, loads| {
            assert_eq!(batch.step(scene).expect("step"), BatchStatus { moving: 0, at_rest: N, refused: 0 });
            loads.add_contact(scene, &contact([1.0, -2.0, 0.7])).expect("contact");
            batch.load(scene, 20, loads).expect("load");
            assert_eq!(
                batch.step(scene).expect("step"),
                BatchStatus { moving: 1, at_rest: N - 1, refused: 0 }
            );
            assert_eq!(batch.status(20), Ok(Status::Moving));
            assert_eq!(batch.status(21), Ok(Status::AtRest));
            batch.clear();
            let rests = (0..1_000_000).any(|_| batch.step(scene).expect("step").at_rest == N);
            assert!(rests, "{structure:?} never rests");
            batch.load(scene, 3, loads).expect("load");
            assert_eq!(batch.step(scene).expect("step").moving, 1);
        });
    }
}

#[test]
fn a_change_of_parameters_is_carried_or_refused() {
    let bytes = file(0.3);
    let parsed = File::parse(&bytes).expect("a file");
    let bound = options(StructureChoice::Diagonal);
    let sizes = Scene::<f64>::sizes(&parsed, &bound).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let (mut state, mut loads) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let mut scene = Scene::bind(&parsed, &bound, &mut memory, &mut work).expect("bound");
    let mut lent = vec![0.0; Batch::len_for(&scene, N)];
    let mut batch = Batch::new(&scene, N, &mut lent).expect("memory");
    let mut state = State::new(&scene, &mut state).expect("memory");
    let mut loads = Loads::new(&scene, &mut loads).expect("memory");
    loads.add_contact(&scene, &contact([1.0, -2.0, 0.7])).expect("contact");
    batch.load(&scene, 7, &loads).expect("load");
    batch.step(&scene).expect("step");
    batch.get(7, &mut state).expect("state");

    let other = SceneOptions { time_step: Some(2e-3), stiffness: 1.5, ..bound };
    for bad in [f64::NAN, f64::INFINITY, -1.0] {
        assert!(scene.rebind(&SceneOptions { stiffness: bad, ..bound }, &mut work).is_err());
    }
    batch.step(&scene).expect("nothing changed");
    batch.get(7, &mut state).expect("state");
    scene.rebind(&other, &mut work).expect("rebound");
    assert_eq!(batch.step(&scene), Err(StepError::NotCarried));
    batch.carry(&scene).expect("carried");
    assert_eq!(
        batch.get(7, &mut state),
        Err(StepError::NotCarried),
        "the single state is of another time step"
    );
    state.carry(&scene).expect("carried");
    assert_eq!(batch.step(&scene), Err(StepError::StaleLoads));
    assert_eq!(batch.load(&scene, 8, &loads), Err(LoadError::Stale));
    batch.clear();
    loads.clear();
    batch.step(&scene).expect("step");
    scene.step(&mut state, &loads).expect("step");
    let alone = saved(&state);
    batch.get(7, &mut state).expect("state");
    assert_eq!(saved(&state), alone);
}

#[test]
fn instances_and_memory_are_counted() {
    let bytes = file(0.3);
    with_batch::<f32>(&bytes, &options(StructureChoice::Block), |scene, batch, state, loads| {
        assert_eq!(batch.n_instances(), N);
        assert_eq!(batch.load(scene, N, loads), Err(LoadError::NoInstance { index: N, count: N }));
        assert_eq!(batch.set(N, state), Err(StepError::NoInstance));
        assert_eq!(batch.get(N, state), Err(StepError::NoInstance));
        assert_eq!(batch.status(N), Err(StepError::NoInstance));
        let needed = Batch::len_for(scene, N);
        assert!(Batch::new(scene, N, &mut vec![0.0f32; needed - 1]).is_err());
        assert_eq!(Batch::len_for(scene, usize::MAX), usize::MAX, "no wrap");
        let none = Batch::new(scene, 0, &mut []).expect("none").step(scene);
        assert_eq!(none, Ok(BatchStatus::default()));
        with_scene::<f32, ()>(&bytes, &options(StructureChoice::Diagonal), |other, state, loads| {
            assert_eq!(batch.step(other), Err(StepError::Mismatch));
            assert_eq!(batch.set(0, state), Err(StepError::Mismatch));
            assert_eq!(batch.load(scene, 0, loads), Err(LoadError::Mismatch));
        });
    });
}

/// Two cores: a batch each over one scene.
#[test]
fn the_caller_splits_the_instances_among_threads() {
    let bytes = file(0.3);
    with_batch::<f32>(&bytes, &options(StructureChoice::Diagonal), |scene, whole, state, loads| {
        loads.add_contact(scene, &contact([1.0, -2.0, 0.7])).expect("contact");
        let mut memory = vec![0.0f32; 2 * Batch::len_for(scene, 16)];
        let half = memory.len() / 2;
        let mut parts: Vec<Batch<'_, f32>> =
            memory.chunks_mut(half).map(|memory| Batch::new(scene, 16, memory).expect("memory")).collect();
        for instance in 0..32 {
            whole.load(scene, instance, loads).expect("load");
            parts[instance / 16].load(scene, instance % 16, loads).expect("load");
        }
        std::thread::scope(|threads| {
            for part in &mut parts {
                threads.spawn(move || {
                    for _ in 0..100 {
                        part.step(scene).expect("step");
                    }
                });
            }
        });
        for _ in 0..100 {
            whole.step(scene).expect("step");
        }
        for instance in 0..32 {
            whole.get(instance, state).expect("state");
            let expected = saved(state);
            parts[instance / 16].get(instance % 16, state).expect("state");
            assert_eq!(saved(state), expected);
        }
    });
}
