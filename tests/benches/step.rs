//! Steps, reconstruction and binding, each beside its baseline.
//! `cargo bench -p vademecum-tests --bench step`.
//!
//! Times are per call; the step benches run [`STEPS`] steps a call, so divide by it (or read the items per
//! second).

use divan::counter::{BytesCount, ItemsCount};
use divan::{Bencher, black_box};
use vademecum_eval::{Contact, Field, Place, Scalar, Scene, SceneOptions, State, StructureChoice};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{Element, File};
use vademecum_tests::random_terms::random_terms;
use vademecum_tests::stage::with_scene;
use vademecum_tests::synthetic::{Body, Layout, bathe};

const STEPS: usize = 1000;

fn main() {
    divan::main();
}

fn parameters() -> StepParameters {
    StepParameters { time_step: 1e-3, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 }
}

fn body(side: usize, n_interior: usize, r: usize, element: Element) -> Vec<u8> {
    let layout = Layout { rows: side, load_rows: 2, columns: side, n_interior, r };
    Body::closed(layout, 1).file(&bathe(), &parameters(), element)
}

fn options(structure: StructureChoice) -> SceneOptions {
    SceneOptions { structure, ..SceneOptions::default() }
}

/// A scene under a held contact, so that it never comes to rest.
fn step<T: Scalar>(bencher: Bencher<'_, '_>, structure: StructureChoice, r: usize) {
    let bytes = body(4, 4, r, Element::F32);
    with_scene::<T, ()>(&bytes, &options(structure), |scene, state, loads| {
        let contact = Contact::new(Place::triangle([0, 1, 5], [0.2, 0.3, 0.5]), [1.0, 0.0, 0.0]);
        loads.add_contact(scene, &contact).expect("contact");
        bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
            for _ in 0..STEPS {
                let _ = black_box(scene.step(state, loads));
            }
        });
    });
}

#[divan::bench(types = [f32, f64], args = [8, 32, 64])]
fn diagonal<T: Scalar>(bencher: Bencher<'_, '_>, r: usize) {
    step::<T>(bencher, StructureChoice::Diagonal, r);
}

#[divan::bench(types = [f32, f64], args = [8, 16, 32, 64])]
fn exact<T: Scalar>(bencher: Bencher<'_, '_>, r: usize) {
    step::<T>(bencher, StructureChoice::Exact, r);
}

#[divan::bench(types = [f32, f64], args = [8, 24, 64])]
fn dense<T: Scalar>(bencher: Bencher<'_, '_>, r: usize) {
    step::<T>(bencher, StructureChoice::Block, r);
}

#[divan::bench(types = [f32, f64], args = [8, 64])]
fn contact_dense<T: Scalar>(bencher: Bencher<'_, '_>, r: usize) {
    let bytes = body(4, 4, r, Element::F32);
    with_scene::<T, ()>(&bytes, &options(StructureChoice::Block), |scene, _, loads| {
        let contact = Contact::new(Place::triangle([0, 1, 5], [0.2, 0.3, 0.5]), [1.0, 0.0, 0.0]);
        bencher.bench_local(|| {
            loads.clear();
            black_box(loads.add_contact(scene, &contact))
        });
    });
}

/// Whole body of side³ nodes and its surface, f32 rows; `copy` moves the same bytes.
fn field(bencher: Bencher<'_, '_>, side: usize, r: usize, whole: bool) {
    let bytes = body(2 * side, side * side * side - 4 * side * side, r, Element::F32);
    with_scene::<f32, ()>(&bytes, &options(StructureChoice::Diagonal), |scene, state, loads| {
        loads.add_pattern(scene, 0, 1.0).expect("pattern");
        scene.step(state, loads).expect("step");
        let nodes = if whole { side * side * side } else { 4 * side * side };
        let mut out = vec![0.0f32; 3 * nodes];
        bencher.counter(BytesCount::new(3 * nodes * r * 4)).bench_local(|| {
            let done = match whole {
                true => scene.body_into(state, Field::Displacement, &mut out),
                false => scene.surface_into(state, Field::Displacement, &mut out),
            };
            black_box(done)
        });
    });
}

const FIELDS: [(usize, usize); 6] = [(10, 8), (21, 8), (46, 8), (21, 32), (46, 32), (46, 64)];

#[divan::bench(args = FIELDS)]
fn surface(bencher: Bencher<'_, '_>, (side, r): (usize, usize)) {
    field(bencher, side, r, false);
}

#[divan::bench(args = FIELDS)]
fn whole_body(bencher: Bencher<'_, '_>, (side, r): (usize, usize)) {
    field(bencher, side, r, true);
}

#[divan::bench(args = FIELDS)]
fn whole_body_copy(bencher: Bencher<'_, '_>, (side, r): (usize, usize)) {
    let from = vec![1.0f32; 3 * side * side * side * r];
    let mut to = from.clone();
    bencher
        .counter(BytesCount::new(4 * from.len()))
        .bench_local(|| black_box(&mut to).copy_from_slice(black_box(&from)));
}

#[divan::bench(args = [
    (StructureChoice::Diagonal, 64),
    (StructureChoice::Block, 8),
    (StructureChoice::Block, 64),
])]
fn parse_and_bind(bencher: Bencher<'_, '_>, (structure, r): (StructureChoice, usize)) {
    let bytes = body(10, 900, r, Element::F32);
    let options = options(structure);
    let sizes = Scene::<f32>::sizes(&File::parse(&bytes).expect("file"), &options).expect("sizes");
    let (mut memory, mut work) = (vec![0.0f32; sizes.scene], vec![0.0; sizes.work]);
    bencher.bench_local(|| {
        let file = File::parse(black_box(&bytes)).expect("file");
        Scene::bind(&file, &options, &mut memory, &mut work).map(|scene| scene.n_modes())
    });
}

const TERMS: [(usize, usize); 4] = [(8, 30), (8, 60), (24, 30), (64, 30)];

/// A parameter set while the scene lives, the state carried over.
#[divan::bench(types = [f32, f64], args = TERMS)]
fn set_parameter<T: Scalar>(bencher: Bencher<'_, '_>, (r, n_terms): (usize, usize)) {
    let bytes = random_terms(r, n_terms, &parameters());
    let (file, options) = (File::parse(&bytes).expect("file"), options(StructureChoice::Block));
    let sizes = Scene::<T>::sizes(&file, &options).expect("sizes");
    let (mut memory, mut work) = (vec![T::ZERO; sizes.scene], vec![0.0; sizes.work]);
    let mut state = vec![T::ZERO; sizes.state];
    let mut scene = Scene::bind(&file, &options, &mut memory, &mut work).expect("bound");
    let mut state = State::new(&scene, &mut state).expect("state");
    let mut value = 1.0;
    bencher.bench_local(|| {
        value = if value > 1.9 { 0.6 } else { value + 0.01 };
        scene.set_parameters(&[(0, black_box(value))], &mut state, &mut work).expect("set");
    });
}

/// The same where modes are independent: any uniform parameter of the diagonal structure.
#[divan::bench(types = [f32, f64], args = [8, 64])]
fn rebind_diagonal<T: Scalar>(bencher: Bencher<'_, '_>, r: usize) {
    let bytes = body(4, 4, r, Element::F32);
    let (file, mut options) = (File::parse(&bytes).expect("file"), options(StructureChoice::Diagonal));
    let sizes = Scene::<T>::sizes(&file, &options).expect("sizes");
    let (mut memory, mut work) = (vec![T::ZERO; sizes.scene], vec![0.0; sizes.work]);
    let mut scene = Scene::bind(&file, &options, &mut memory, &mut work).expect("bound");
    bencher.bench_local(|| {
        options.stiffness = if options.stiffness > 1.9 { 0.6 } else { options.stiffness + 0.01 };
        scene.rebind(black_box(&options), &mut work).expect("rebound");
    });
}

/// A contact on a file with parameters: nine rows a term.
#[divan::bench(types = [f32, f64], args = TERMS)]
fn contact_separated<T: Scalar>(bencher: Bencher<'_, '_>, (r, n_terms): (usize, usize)) {
    let bytes = random_terms(r, n_terms, &parameters());
    with_scene::<T, ()>(&bytes, &options(StructureChoice::Block), |scene, _, loads| {
        let contact = Contact::new(Place::triangle([0, 1, 5], [0.2, 0.3, 0.5]), [1.0, 0.5, -2.0]);
        bencher.bench_local(|| {
            loads.clear();
            black_box(loads.add_contact(scene, &contact))
        });
    });
}
