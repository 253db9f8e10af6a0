//! Gradients of a march of a thousand steps. `cargo bench -p vademecum-tests --bench gradient` prints the
//! time of a march, of its adjoint with respect to loads and the start, of a march that is kept by
//! checkpoints, of all gradients of it, parameters included, and of the tangents of three parameters.

use std::path::PathBuf;
use std::sync::OnceLock;

use divan::Bencher;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::{
    Adjoint, CheckpointedMarch, Contact, Cotangents, Field, Loads, MarchRows, Parametric, Place, Scene,
    SceneOptions, State, Tangents,
};
use vademecum_format::File;
use vademecum_tests::live_beam::LiveBeam;

fn main() {
    divan::main();
}

const STEPS: usize = 1000;
const SIZES: [usize; 2] = [32, 64];
/// Of a beam, so that its frequencies lie as those of bodies do: no two are equal.
const HEIGHT: f64 = 0.13;

fn beam() -> LiveBeam {
    LiveBeam { regions: 2, height: HEIGHT, modes: 64, both_ends: false, fine: 3, step: 1e-3 }
}

/// The beam with live regions.
fn live() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| beam().build(None))
}

/// The beam at fixed values, without residual flexibility, of so many modes.
fn fixed(modes: usize) -> Vec<u8> {
    let text = LiveBeam { modes, ..beam() }.text(Some((&[1.0, 1.0], 1e-4)));
    let problem = Problem::parse(&text, "beam.toml", PathBuf::new()).expect("a problem");
    build(&problem, &BuildOptions::default(), &Silent).expect("built").either().bytes
}

/// A node of the upper side, away from the support.
fn node(file: &File<'_>) -> usize {
    file.metadata().n_load_nodes as usize - 1
}

fn load(step: usize) -> f64 {
    (0.01 * step as f64).sin()
}

/// Hands over a scene in double precision with a state and loads.
fn with_scene(modes: usize, work: impl FnOnce(&Scene<'_, f64>, &mut State<'_, f64>, &mut Loads<'_, f64>)) {
    let bytes = fixed(modes);
    let file = File::parse(&bytes).expect("a file");
    let options = SceneOptions { residual: false, ..SceneOptions::default() };
    let sizes = Scene::<f64>::sizes(&file, &options).expect("sizes");
    let (mut memory, mut lent) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let (mut state, mut loads) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let scene = Scene::bind(&file, &options, &mut memory, &mut lent).expect("bound");
    let mut state = State::new(&scene, &mut state).expect("a state");
    let mut loads = Loads::new(&scene, &mut loads).expect("loads");
    work(&scene, &mut state, &mut loads);
}

/// A march of a body: in each step a force at a node, and a probe.
#[divan::bench(args = SIZES)]
fn march(bencher: Bencher<'_, '_>, modes: usize) {
    with_scene(modes, |scene, state, loads| {
        let place = Place::node(scene.metadata().n_load_nodes - 1);
        bencher.bench_local(|| {
            let mut sum = 0.0;
            state.rest();
            for step in 0..STEPS {
                loads.clear();
                let contact = Contact::new(place, [0.0, 0.0, load(step)]);
                loads.add_contact(scene, &contact).expect("a contact");
                scene.step(state, loads).expect("a step");
                sum += scene.probe(state, 1, Field::Displacement).expect("a probe");
            }
            sum
        });
    });
}

/// Its adjoint: the cotangent of the probe in each step, and the gradient with respect to the force.
#[divan::bench(args = SIZES)]
fn adjoint(bencher: Bencher<'_, '_>, modes: usize) {
    with_scene(modes, |scene, _, _| {
        let sizes = scene.adjoint_sizes().expect("sizes");
        let (mut memory, mut lent) = (vec![0.0; sizes.adjoint], vec![0.0; sizes.cotangents]);
        let mut adjoint = Adjoint::new(scene, &mut memory).expect("an adjoint");
        let mut cotangents = Cotangents::new(scene, &mut lent).expect("cotangents");
        bencher.bench_local(|| {
            let mut sum = 0.0;
            adjoint.restart();
            for step in (0..STEPS).rev() {
                cotangents.clear();
                cotangents.add_probe(scene, 1, Field::Displacement, load(step)).expect("a probe");
                adjoint.back(scene, &cotangents).expect("a step back");
                let [start, end] = adjoint.node(scene, scene.metadata().n_load_nodes - 1).expect("a node");
                sum += start[2] + end[2];
            }
            sum
        });
    });
}

/// Calls `work` with a march of the live beam that is kept by checkpoints, and its loads.
fn with_checkpoints(modes: usize, work: impl FnOnce(&mut CheckpointedMarch<'_, '_>, &[f64], &mut [f64])) {
    let file = File::parse(live()).expect("a file");
    let model = Parametric::new(&file).expect("a model");
    let (mut probe, mut force) = (vec![0.0; model.n_basis()], vec![0.0; model.n_basis()]);
    model.probe_row(1, &mut probe).expect("a probe");
    model.node_row(node(&file), [0.0, 0.0, 1.0], &mut force).expect("a node");
    let sizes = model.sizes(modes).expect("sizes");
    let (mut memory, mut lent) = (vec![0.0; sizes.memory], vec![0.0; sizes.work]);
    let tuned = model.solve(&[0.8, 1.3, 1e-4], modes, &mut memory, &mut lent).expect("solved");
    let fields = [Field::Displacement];
    let rows = MarchRows { outputs: &probe, fields: &fields, loads: &force, steps: STEPS };
    let sizes = model.adjoint_sizes(modes, &rows).expect("sizes");
    let (mut memory, mut lent) = (vec![0.0; sizes.memory], vec![0.0; sizes.work]);
    let mut march = CheckpointedMarch::new(&model, tuned, &rows, &mut memory).expect("a march");
    let loads: Vec<f64> = (0..STEPS).flat_map(|step| [load(step), load(step + 1)]).collect();
    work(&mut march, &loads, &mut lent);
}

/// A march of the live beam: a load and a probe.
#[divan::bench(args = SIZES)]
fn kept_march(bencher: Bencher<'_, '_>, modes: usize) {
    with_checkpoints(modes, |march, loads, _| {
        let mut outputs = vec![0.0; STEPS];
        bencher.bench_local(|| march.march([&[]; 2], loads, &mut outputs).expect("a march"));
    });
}

/// The march back, with the gradient with respect to the load in each step, and to all parameters.
#[divan::bench(args = SIZES)]
fn kept_march_back(bencher: Bencher<'_, '_>, modes: usize) {
    with_checkpoints(modes, |march, loads, work| {
        let (mut outputs, mut of_loads) = (vec![0.0; STEPS], vec![0.0; 2 * STEPS]);
        let mut parameters = [0.0; 3];
        march.march([&[]; 2], loads, &mut outputs).expect("a march");
        bencher.bench_local(|| {
            march.back(loads, &outputs, &mut of_loads).expect("a march back");
            march.parameters_into(&mut parameters, work).expect("parameters");
        });
    });
}

/// The derivatives of the same march with respect to its three parameters, forwards.
#[divan::bench(args = SIZES)]
fn tangents(bencher: Bencher<'_, '_>, modes: usize) {
    let file = File::parse(live()).expect("a file");
    let model = Parametric::new(&file).expect("a model");
    let (mut probe, mut force) = (vec![0.0; model.n_basis()], vec![0.0; model.n_basis()]);
    model.probe_row(1, &mut probe).expect("a probe");
    model.node_row(node(&file), [0.0, 0.0, 1.0], &mut force).expect("a node");
    let sizes = model.sizes(modes).expect("sizes");
    let (mut memory, mut lent) = (vec![0.0; sizes.memory], vec![0.0; sizes.work]);
    let tuned = model.solve(&[0.8, 1.3, 1e-4], modes, &mut memory, &mut lent).expect("solved");
    let sizes = model.tangent_sizes(modes);
    let (mut memory, mut lent) = (vec![0.0; sizes.memory], vec![0.0; sizes.work]);
    let mut march = Tangents::new(&model, tuned, &mut memory, &mut lent).expect("tangents");
    let at = |step: usize| force.iter().map(|x| load(step) * x).collect::<Vec<f64>>();
    let loads: Vec<Vec<f64>> = (0..=STEPS).map(at).collect();
    bencher.bench_local(|| {
        let mut sum = 0.0;
        for step in 0..STEPS {
            march.step(&loads[step], &loads[step + 1]);
            sum += (0..3).map(|k| march.slope(&probe, Field::Displacement, k)).sum::<f64>();
        }
        sum
    });
}
