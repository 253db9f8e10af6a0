//! Steps, reconstruction and binding, each beside its baseline. `cargo bench -p vademecum-tests --bench step`.
//!
//! Times are per call; the step benches run [`STEPS`] steps a call, so divide by it (or read the items per second).

use divan::counter::{BytesCount, ItemsCount};
use divan::{Bencher, black_box};
use vademecum_eval::{Contact, Field, Scalar, Scene, SceneOptions, State, StructureChoice};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{
    Axis, AxisKind, AxisRole, Element, File, MAX_REGIONS, Parameter, ParameterRole, SectionKind,
};
use vademecum_tests::regions::chebyshev;
use vademecum_tests::stage::with_scene;
use vademecum_tests::synthetic::{Body, Layout, Random, bathe, encode};

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
        let contact = Contact { nodes: [0, 1, 5], weights: [0.2, 0.3, 0.5], force: [1.0, 0.0, 0.0] };
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

#[divan::bench(types = [f32, f64], args = [8, 24, 64])]
fn dense<T: Scalar>(bencher: Bencher<'_, '_>, r: usize) {
    step::<T>(bencher, StructureChoice::Block, r);
}

#[divan::bench(types = [f32, f64], args = [8, 64])]
fn contact_dense<T: Scalar>(bencher: Bencher<'_, '_>, r: usize) {
    let bytes = body(4, 4, r, Element::F32);
    with_scene::<T, ()>(&bytes, &options(StructureChoice::Block), |scene, _, loads| {
        let contact = Contact { nodes: [0, 1, 5], weights: [0.2, 0.3, 0.5], force: [1.0, 0.0, 0.0] };
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

#[divan::bench(args = [(StructureChoice::Diagonal, 64), (StructureChoice::Block, 8), (StructureChoice::Block, 64)])]
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

/// A file of two regions with `n_terms` terms of random numbers over a common axis of 17 points and a contrast of 11: what a
/// bind costs does not depend on what the numbers mean.
fn separated(r: usize, n_terms: usize) -> Vec<u8> {
    let bytes = body(4, 4, r, Element::F32);
    let file = File::parse(&bytes).expect("file");
    let mut m = *file.metadata();
    let exponents = |a: f64, b: f64| [a, b, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let (common, contrast) = (chebyshev(17, 1e-8, 1e-6, true), chebyshev(11, 0.5, 2.0, true));
    let axis = |name, theta, stiffness, points: &[f64]| Axis {
        name,
        unit: "",
        role: AxisRole::Monomial { theta, stiffness, density: [0.0; MAX_REGIONS] },
        kind: AxisKind::Chebyshev,
        log: true,
        lower: points[0],
        upper: points[points.len() - 1],
        n_points: points.len() as u32,
    };
    m.axes[0] = axis("common", 1.0, exponents(0.5, 0.5), &common);
    m.axes[1] = axis("contrast", 0.0, exponents(0.5, -0.5), &contrast);
    (m.n_axes, m.n_terms, m.n_regions) = (2, n_terms as u32, 2);
    let parameter = |name, region| Parameter {
        name,
        unit: "",
        role: ParameterRole::RegionStiffness { region },
        log: true,
        lower: 0.5,
        upper: 2.0,
        nominal: 1.0,
    };
    (m.parameters[0], m.parameters[1]) = (parameter("soft", 0), parameter("hard", 1));
    m.n_parameters = 2;
    let mut random = Random::new(3);
    let mut numbers = |n: usize, single: bool| -> Vec<u8> {
        let numbers = random.numbers(n).into_iter().map(|x| 1e-3 * x);
        match single {
            true => numbers.flat_map(|x| (x as f32).to_le_bytes()).collect(),
            false => numbers.flat_map(|x| x.to_le_bytes()).collect(),
        }
    };
    let n_load = m.n_load_nodes as usize;
    let points: Vec<u8> = common.iter().chain(&contrast).flat_map(|x| x.to_le_bytes()).collect();
    let replaced = [
        (SectionKind::BlockState, Element::F64, numbers(n_terms * r * r, false)),
        (SectionKind::BlockLoad, Element::F32, numbers(n_load * n_terms * 3 * r, true)),
        (SectionKind::PatternBlock, Element::F64, numbers(n_terms * r, false)),
        (SectionKind::AxisPoints, Element::F64, points),
        (SectionKind::Factors, Element::F64, numbers(n_terms * 28, false)),
        (SectionKind::RegionStiffness, Element::F64, numbers(2 * r * r, false)),
    ];
    let kept = file.sections().filter(|s| replaced.iter().all(|r| r.0 != s.kind()));
    let mut contents: Vec<_> = kept.map(|s| (s.kind(), s.element(), s.stored().to_vec())).collect();
    contents.extend(replaced);
    encode(&m, &contents)
}

const TERMS: [(usize, usize); 4] = [(8, 30), (8, 60), (24, 30), (64, 30)];

/// A parameter set while the scene lives, the state carried over.
#[divan::bench(types = [f32, f64], args = TERMS)]
fn set_parameter<T: Scalar>(bencher: Bencher<'_, '_>, (r, n_terms): (usize, usize)) {
    let bytes = separated(r, n_terms);
    let (file, options) = (File::parse(&bytes).expect("file"), options(StructureChoice::Block));
    let sizes = Scene::<T>::sizes(&file, &options).expect("sizes");
    let (mut memory, mut work) = (vec![T::ZERO; sizes.scene], vec![0.0; sizes.work]);
    let mut state = vec![T::ZERO; sizes.state];
    let mut scene = Scene::bind(&file, &options, &mut memory, &mut work).expect("bound");
    let mut state = State::new(&scene, &mut state).expect("state");
    let mut value = 1.0;
    bencher.bench_local(|| {
        value = if value > 1.9 { 0.6 } else { value + 0.01 };
        scene.set_parameter(0, black_box(value), &mut state, &mut work).expect("set");
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
    let bytes = separated(r, n_terms);
    with_scene::<T, ()>(&bytes, &options(StructureChoice::Block), |scene, _, loads| {
        let contact = Contact { nodes: [0, 1, 5], weights: [0.2, 0.3, 0.5], force: [1.0, 0.5, -2.0] };
        bencher.bench_local(|| {
            loads.clear();
            black_box(loads.add_contact(scene, &contact))
        });
    });
}
