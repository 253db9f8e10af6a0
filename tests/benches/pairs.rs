//! Paired timings in one process, run in turns: batch and loop, fields and a plain copy, one need and
//! another. `cargo bench -p vademecum-tests --bench pairs [-- batch fields needs terms]` prints the tables of
//! `docs/measurements/step.md`.

use std::hint::black_box;
use std::time::Instant;
use vademecum_eval::{
    Batch, Contact, Field, Loads, Place, Scalar, Scene, SceneOptions, State, StructureChoice,
};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{Element, File};
use vademecum_tests::random_terms::random_terms;
use vademecum_tests::stage::with_scene;
use vademecum_tests::synthetic::{Body, Layout, bathe};

const STEP: StepParameters =
    StepParameters { time_step: 2e-3, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 };
const CONTACT: Contact = Contact::new(Place::triangle([0, 1, 5], [0.2, 0.3, 0.5]), [1.0, 0.5, -2.0]);
const ROUNDS: usize = 101;

/// Keeps the compiler from leaving out what is timed.
fn keep<X>(done: X) {
    black_box(done);
}

/// Seconds of one call of each, in turns: the fastest and the median of [`ROUNDS`] rounds of `repeats` calls.
/// Rounds are kept short, so that on a busy machine some run undisturbed.
fn in_turns(repeats: usize, runs: &mut [&mut dyn FnMut()]) -> Vec<(f64, f64)> {
    let mut times = vec![vec![]; runs.len()];
    for _ in 0..ROUNDS {
        for (run, times) in runs.iter_mut().zip(&mut times) {
            let clock = Instant::now();
            (0..repeats).for_each(|_| run());
            times.push(clock.elapsed().as_secs_f64() / repeats as f64);
        }
    }
    times
        .iter_mut()
        .map(|times| {
            times.sort_by(f64::total_cmp);
            (times[0], times[ROUNDS / 2])
        })
        .collect()
}

fn body(r: usize, n_interior: usize, element: Element) -> Vec<u8> {
    let layout = Layout { rows: 4, load_rows: 2, columns: 4, n_interior, r };
    Body::closed(layout, 1).file(&bathe(), &STEP, element)
}

fn options(structure: StructureChoice) -> SceneOptions {
    SceneOptions { structure, ..SceneOptions::default() }
}

fn name<T: Scalar>() -> &'static str {
    if size_of::<T>() == 4 { "f32" } else { "f64" }
}

/// A thousand bodies under a held contact: a loop of single steps, a batch, and two batches on two threads
/// (10 steps a start).
fn batch<T: Scalar + Send + Sync>(structure: StructureChoice, r: usize) {
    const N: usize = 1024;
    /// Steps a start of threads.
    const STARTS: usize = 10;
    with_scene::<T, ()>(&body(r, 4, Element::F32), &options(structure), |scene, state, loads| {
        loads.add_contact(scene, &CONTACT).expect("contact");
        let mut memory = vec![T::ZERO; 2 * N * (3 * r).next_multiple_of(48)];
        let mut states: Vec<_> = memory
            .chunks_mut(2 * (3 * r).next_multiple_of(48))
            .map(|m| State::new(scene, m).expect("state"))
            .collect();
        let mut lent = vec![T::ZERO; 2 * Batch::len_for(scene, N)];
        let half = lent.len() / 2;
        let (whole, halves) = lent.split_at_mut(half);
        let mut whole = Batch::new(scene, N, whole).expect("memory");
        let middle = halves.len() / 2;
        let (first, second) = halves.split_at_mut(middle);
        let mut parts = [first, second].map(|memory| Batch::new(scene, N / 2, memory).expect("memory"));
        for instance in 0..N {
            whole.load(scene, instance, loads).expect("load");
            parts[instance / (N / 2)].load(scene, instance % (N / 2), loads).expect("load");
        }
        let many = |batch: &mut Batch<'_, T>| (0..STARTS).for_each(|_| keep(batch.step(scene)));
        let times = in_turns(
            1,
            &mut [
                &mut || {
                    for _ in 0..STARTS {
                        states.iter_mut().for_each(|state| keep(scene.step(state, loads)));
                    }
                },
                &mut || many(&mut whole),
                &mut || {
                    std::thread::scope(|threads| {
                        parts.iter_mut().for_each(|part| drop(threads.spawn(|| many(part))));
                    });
                },
            ],
        );
        whole.get(N - 1, state).expect("state");
        assert_eq!(state.zeta(), states[N - 1].zeta(), "the same bits");
        let ns = |(fastest, median): (f64, f64)| (1e8 * fastest / N as f64, 1e8 * median / N as f64);
        let [one, all, two] = [ns(times[0]), ns(times[1]), ns(times[2])];
        println!(
            "| {structure:?} | {} | {r} | {:.1} ({:.1}) | {:.1} ({:.1}) | {:.2} | {:.1} ({:.1}) | {:.1} |",
            name::<T>(),
            one.0,
            one.1,
            all.0,
            all.1,
            one.0 / all.0,
            two.0,
            two.1,
            1e3 / two.0
        );
    });
}

/// The whole body of 300 000 dofs beside a copy of its basis: bytes read and written by time, of both.
fn field<T: Scalar>(element: Element, r: usize) {
    let width = element.size() as usize;
    let bytes = body(r, 100_000 - 16, element);
    with_scene::<T, ()>(&bytes, &options(StructureChoice::Diagonal), |scene, state, loads| {
        loads.add_pattern(scene, 0, 1.0).expect("pattern");
        scene.step(state, loads).expect("step");
        let n = 300_000;
        let mut out = vec![T::ZERO; n];
        // The basis is the end of the file but for some bytes; the same memory is read by both.
        let from = &bytes[bytes.len() - n * r * width..];
        let mut to = from.to_vec();
        let times = in_turns(
            3,
            &mut [
                &mut || scene.body_into(state, Field::Displacement, black_box(&mut out)).expect("body"),
                &mut || black_box(&mut to).copy_from_slice(black_box(from)),
            ],
        );
        let moved = [n * (r * width + size_of::<T>()), 2 * from.len()];
        let rate = |bytes: usize, seconds: f64| bytes as f64 / seconds / 1e9;
        let share = |a: f64, b: f64| rate(moved[0], a) / rate(moved[1], b);
        println!(
            "| {element:?} | {} | {r} | {:.3} | {:.1} | {:.1} | {:.2} | {:.2} |",
            name::<T>(),
            1e3 * times[0].0,
            rate(moved[0], times[0].0),
            rate(moved[1], times[1].0),
            share(times[0].0, times[1].0),
            share(times[0].1, times[1].1)
        );
    });
}

/// One scene, one need at a time, with what the scene says it costs.
fn needs(structure: StructureChoice) {
    with_scene::<f32, ()>(&body(8, 10_000 - 16, Element::F32), &options(structure), |scene, state, loads| {
        let cost = scene.cost();
        let (mut at_rest, mut moving) = (vec![0.0f32; 200], vec![0.0f32; 200]);
        let mut at_rest = State::new(scene, &mut at_rest).expect("memory");
        let mut moving = State::new(scene, &mut moving).expect("memory");
        let [mut none, mut held, mut pattern] = [const { [0.0f32; 200] }; 3];
        let (none, mut held) =
            (Loads::new(scene, &mut none).expect("memory"), Loads::new(scene, &mut held).expect("memory"));
        let mut pattern = Loads::new(scene, &mut pattern).expect("memory");
        held.add_contact(scene, &CONTACT).expect("contact");
        scene.step(state, &held).expect("step");
        let (state, mut body, mut surface) = (&*state, vec![0.0f32; 30_000], vec![0.0f32; 48]);
        let times = in_turns(
            20,
            &mut [
                &mut || keep(scene.step(&mut at_rest, &none)),
                &mut || keep(scene.step(&mut moving, &held)),
                &mut || {
                    loads.clear();
                    keep(loads.add_contact(scene, &CONTACT));
                },
                &mut || {
                    pattern.clear();
                    keep(pattern.add_pattern(scene, 0, 1.0));
                },
                &mut || keep(scene.probe(state, 1, Field::Displacement)),
                &mut || keep(scene.node(state, 5, Field::Displacement)),
                &mut || keep(scene.surface_into(state, Field::Displacement, &mut surface)),
                &mut || keep(scene.body_into(state, Field::Displacement, &mut body)),
            ],
        );
        let names = [
            "step at rest",
            "step",
            "add a contact",
            "add a pattern",
            "probe",
            "node",
            "surface, 16 nodes",
            "body, 10 000 nodes",
        ];
        let bytes = [
            0,
            cost.step_bytes,
            cost.contact_bytes,
            cost.pattern_bytes,
            cost.probe_bytes,
            cost.node_bytes,
            cost.surface_bytes,
            cost.body_bytes,
        ];
        for ((name, bytes), (fastest, median)) in names.iter().zip(bytes).zip(times) {
            println!("| {structure:?} | {name} | {bytes} | {:.0} | {:.0} |", 1e9 * fastest, 1e9 * median);
        }
    });
}

/// One file of 60 terms, bound to fewer and fewer of them.
fn terms() {
    let bytes = random_terms(8, 60, &STEP);
    let file = File::parse(&bytes).expect("a file");
    for terms in [60, 30, 10] {
        let options = SceneOptions { terms: Some(terms), ..options(StructureChoice::Block) };
        let sizes = Scene::<f32>::sizes(&file, &options).expect("sizes");
        let (mut memory, mut lent) = (vec![0.0f32; sizes.scene], vec![0.0f32; sizes.scene]);
        let (mut work, mut state) = (vec![0.0; sizes.work], vec![0.0f32; sizes.state]);
        let mut scene = Scene::bind(&file, &options, &mut memory, &mut work).expect("bound");
        let held = Scene::bind(&file, &options, &mut lent, &mut work).expect("bound");
        let mut state = State::new(&scene, &mut state).expect("memory");
        let mut loads = vec![0.0f32; sizes.loads];
        let mut loads = Loads::new(&held, &mut loads).expect("memory");
        let mut value = 1.0;
        let times = in_turns(
            20,
            &mut [
                &mut || {
                    value = if value > 1.9 { 0.6 } else { value + 0.01 };
                    keep(scene.set_parameters(&[(0, black_box(value))], &mut state, &mut work));
                },
                &mut || {
                    loads.clear();
                    keep(loads.add_contact(&held, &CONTACT));
                },
            ],
        );
        let cost = held.cost();
        assert_eq!(cost.terms, terms);
        for (name, bytes, (fastest, median)) in
            [("set a parameter", cost.bind_bytes, times[0]), ("add a contact", cost.contact_bytes, times[1])]
        {
            println!("| {terms} | {name} | {bytes} | {:.0} | {:.0} |", 1e9 * fastest, 1e9 * median);
        }
    }
}

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    let table = |name: &str, head: &str, rows: &dyn Fn()| {
        if asked.is_empty() || asked.iter().any(|word| word == name) {
            println!("\n{head}\n{}|", "|---".repeat(head.matches('|').count() - 1));
            rows();
        }
    };
    table(
        "batch",
        "| structure | precision | modes | loop, ns | batch, ns | loop ÷ batch | two threads, ns | 10⁶ \
         steps/s |",
        &|| {
            for r in [8, 64] {
                batch::<f32>(StructureChoice::Diagonal, r);
                batch::<f64>(StructureChoice::Diagonal, r);
                batch::<f32>(StructureChoice::Exact, r);
                batch::<f64>(StructureChoice::Exact, r);
            }
            batch::<f32>(StructureChoice::Block, 8);
            batch::<f64>(StructureChoice::Block, 8);
        },
    );
    table("fields", "| file | field | modes | ms | GB/s | copy, GB/s | ratio | of the medians |", &|| {
        for (element, r) in [
            (Element::F32, 8),
            (Element::F64, 8),
            (Element::F32, 12),
            (Element::F32, 16),
            (Element::F32, 20),
            (Element::F32, 30),
            (Element::F32, 32),
        ] {
            field::<f32>(element, r);
            field::<f64>(element, r);
        }
    });
    table("needs", "| structure | need | bytes | fastest, ns | median, ns |", &|| {
        needs(StructureChoice::Diagonal);
        needs(StructureChoice::Block);
    });
    table("terms", "| terms | need | bytes | fastest, ns | median, ns |", &terms);
}
