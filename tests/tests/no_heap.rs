//! Opening, binding, stepping, loading and reading allocate nothing: a counting allocator stands in for the
//! system's. It counts what the thread of the test allocates; the harness has threads of its own.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout as Memory, System};
use std::cell::Cell;
use vademecum_eval::{
    Anchor, Assembly, AssemblyOptions, Body as Bound, BodyOptions, CheckpointedMarch, Contact, Cotangents,
    End, Field, Joint, JointKind, LiveMemory, Loads, LoadsAfter, MarchRows, Member, Parametric, Part,
    PartState, Place, Pose, RigidMotion, RigidShape, Scene, SceneOptions, State, StructureChoice, Surface,
    Touching, World, WorldBuffers, WorldJoint, WorldOptions,
};
use vademecum_format::File;
use vademecum_format::scheme::StepParameters;
use vademecum_tests::golden;
use vademecum_tests::regions::{R, TwoRegions, chebyshev};
use vademecum_tests::synthetic::{Body, Layout, bathe};

include!("../../crates/vademecum-eval/doc/masses.rs");

struct Counting;

thread_local! {
    // Without a destructor and known beforehand, so that it allocates nothing itself.
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call goes to the system allocator unchanged; counting does not touch the memory.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, memory: Memory) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller keeps the contract of `GlobalAlloc::alloc`.
        unsafe { System.alloc(memory) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, memory: Memory) {
        // SAFETY: the caller keeps the contract of `GlobalAlloc::dealloc`.
        unsafe { System.dealloc(pointer, memory) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn nothing_is_allocated_from_opening_to_reading() {
    a_life_at_fixed_parameters();
    a_life_with_changing_parameters();
    a_life_in_a_world();
    bodies_joined_and_taken_apart();
    live_regions_while_the_body_moves();
    gradients_of_a_march();
}

fn gradients_of_a_march() {
    let bytes = golden::named("parametric.vdm");
    let file = File::parse(&bytes).expect("a file");
    let model = Parametric::new(&file).expect("a model");
    let (r, row, fields) = (model.n_basis(), [1.0; 3], [Field::Displacement]);
    let rows = MarchRows { outputs: &row, fields: &fields, loads: &row, steps: 40 };
    let (sizes, lent) = (model.sizes(r).expect("sizes"), model.adjoint_sizes(r, &rows).expect("sizes"));
    let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work.max(lent.work)]);
    let (mut kept, loads) = (vec![0.0; lent.memory], [1.0; 80]);
    let (mut outputs, mut of_loads, mut slopes) = ([0.0; 40], [0.0; 80], [0.0; 4]);
    let options = BodyOptions::default();
    let mut of_body = vec![0.0; Bound::<f64>::len_for(&file, &options).expect("a length")];
    let mut lent = vec![0.0; 4096];
    let before = ALLOCATIONS.get();
    let tuned = model.solve(&[1.0, 1.0, 1.0, 1e-5], r, &mut memory, &mut work).expect("solved");
    let mut march = CheckpointedMarch::new(&model, tuned, &rows, &mut kept).expect("a march");
    march.march([&[]; 2], &loads, &mut outputs).expect("a march");
    march.back(&loads, &outputs, &mut of_loads).expect("a march back");
    march.parameters_into(&mut slopes, &mut work).expect("parameters");
    let body = Bound::<f64>::bind(&file, &options, &mut of_body).expect("bound");
    let sizes = body.adjoint_sizes().expect("sizes");
    let (of_adjoint, of_outputs) = lent.split_at_mut(sizes.adjoint);
    let mut adjoint = body.adjoint(of_adjoint).expect("an adjoint");
    let mut cotangents = Cotangents::new(body.scene(), of_outputs).expect("cotangents");
    cotangents.add_probe(body.scene(), 0, Field::Displacement, 1.0).expect("a probe");
    let mut gradient = [[0.0; 3]; 2];
    for _ in 0..40 {
        adjoint.back(body.scene(), &cotangents).expect("a step back");
        gradient = adjoint.force(body.scene(), &Place::node(0)).expect("a force");
    }
    let after = ALLOCATIONS.get();
    assert_eq!(after - before, 0);
    assert!(slopes.iter().chain(gradient.as_flattened()).all(|x| x.is_finite() && *x != 0.0));
}

fn live_regions_while_the_body_moves() {
    let bytes = golden::named("parametric.vdm");
    let file = File::parse(&bytes).expect("a file");
    let options = BodyOptions { modes: Some(2), ..BodyOptions::default() };
    let mut memory = vec![0.0; LiveMemory::len_for::<f32>(&file, &options).expect("a length")];
    let before = ALLOCATIONS.get();
    let (mut live, mut body) = LiveMemory::bind::<f32>(&file, &options, &mut memory).expect("bound");
    let find = |name| live.model().find(name).expect("known");
    let [root, heavy, beta] = ["stiffness of the root", "density of the tip", "beta"].map(find);
    for n in 0..50 {
        let share = 0.02 * f64::from(n);
        let settings = [(root, 0.5 + share), (heavy, 1.5 - share), (beta, 1e-4 * share)];
        // SAFETY: the body is that of this memory, and nothing else borrows from it.
        let loads = unsafe { live.set(&settings, &mut body) }.expect("set");
        assert_eq!(loads, if n == 0 { LoadsAfter::Empty } else { LoadsAfter::Stale });
        // SAFETY: as above.
        assert!(unsafe { live.set(&[(root, 9.0)], &mut body) }.is_err());
        body.clear();
        body.push(&Place::node(0), [0.0, 0.1, -1.0]).expect("pushed");
        body.march(2).expect("stepped");
    }
    let energy = body.energy().expect("energy");
    let after = ALLOCATIONS.get();
    assert_eq!(after - before, 0);
    assert!(energy > 0.0 && energy.is_finite() && live.carried().lost_kinetic >= 0.0);
}

fn bodies_joined_and_taken_apart() {
    let (first, second) = (mass_on_spring(1.0), mass_on_spring(3.0));
    let [first, second] = [&first, &second].map(|bytes| File::parse(bytes).expect("a file"));
    let parts = [("a", first), ("b", second)];
    let parts = parts.map(|(name, file)| Part::new(name, file, Pose::IDENTITY).expect("a part"));
    let [a, b] = ["a.end", "b.end"].map(|name| End::find(&parts, name).expect("a port"));
    let stiffness = [2.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let joints = [Joint::bushing(a, b, &stiffness).as_it_stands()];
    let moved = PartState { displacement: &[1.0], velocity: &[0.5], port_motion: &[] };
    let states = [moved, PartState { displacement: &[-1.0], ..moved }];
    let options = AssemblyOptions::default().as_it_stands(&states);
    let sizes = Assembly::sizes(&parts, &joints, &options).expect("sizes");
    let (mut memory, mut work, mut bytes) =
        (vec![0.0; sizes.memory], vec![0.0; sizes.work], vec![0; sizes.bytes]);
    let before = ALLOCATIONS.get();
    let part = Part::new("a", first, Pose::IDENTITY).expect("a part");
    assert_eq!(Assembly::sizes(&parts, &joints, &options), Ok(sizes));
    let assembly =
        Assembly::bind(&parts, &joints, &options, &mut bytes, &mut memory, &mut work).expect("joined");
    let (mut eta, mut rates, mut q, mut speeds) = ([0.0; 2], [0.0; 2], [0.0; 2], [0.0; 2]);
    assembly.join(&states, &mut eta, &mut rates, &mut work).expect("joined");
    assembly.part_states(&eta, &rates, &mut q, &mut speeds, &mut work).expect("apart");
    let mut forces = [0.0];
    assembly.forces_into(&[2.0, -1.0], &[], &mut forces).expect("forces");
    let reaction = assembly.reaction(0, &forces).expect("a reaction");
    let after = ALLOCATIONS.get();
    assert_eq!(after - before, 0);
    // The first mass 1 m from where the spring was put.
    assert!(part.n_coordinates() == 1 && (reaction.force[0] + 2.0).abs() < 1e-14);
    assert!(
        q.iter().zip([1.0, -1.0]).chain(speeds.iter().zip([0.5, 0.5])).all(|(a, b)| (a - b).abs() < 1e-14)
    );
}

fn a_life_with_changing_parameters() {
    let step = StepParameters { time_step: 2e-3, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 };
    let (common, contrast) = (chebyshev(5, 1e-8, 1e-5, true), chebyshev(4, 0.5, 2.0, true));
    let bytes = TwoRegions::new(1).separated(&bathe(), &step, &common, &contrast, &[0.5, 2.0]);
    let file = File::parse(&bytes).expect("file");
    let options = SceneOptions { structure: StructureChoice::Block, ..SceneOptions::default() };
    let sizes = Scene::<f32>::sizes(&file, &options).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let (mut state, mut loads) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let before = ALLOCATIONS.get();
    let mut scene = Scene::bind(&file, &options, &mut memory, &mut work).expect("bound");
    let mut state = State::new(&scene, &mut state).expect("memory");
    let mut loads = Loads::new(&scene, &mut loads).expect("memory");
    let names =
        ["soft", "dense", "step"].map(|name| SceneOptions::find(file.metadata(), name).expect("known"));
    scene.set_parameters(&[(names[1], 0.7)], &mut state, &mut work).expect("dense");
    scene.set(&mut state, &[0.1; R], &[0.0; R], &loads).expect("set");
    for n in 0..200 {
        let value = 0.5 + 0.007 * f64::from(n);
        scene.set_parameters(&[(names[0], value)], &mut state, &mut work).expect("soft");
        scene.set_parameters(&[(names[2], 2e-3 * value)], &mut state, &mut work).expect("step");
        assert!(scene.set_parameters(&[(names[1], 5.0)], &mut state, &mut work).is_err());
        loads.clear();
        loads.add_pattern(&scene, 0, 0.1).expect("pattern");
        scene.step(&mut state, &loads).expect("step");
    }
    let energy = scene.energy(&state).expect("energy");
    let after = ALLOCATIONS.get();
    assert_eq!(after - before, 0);
    assert!(energy > 0.0 && energy.is_finite());
}

fn a_life_at_fixed_parameters() {
    let layout = Layout { rows: 3, load_rows: 2, columns: 3, n_interior: 3, r: 6 };
    let step = StepParameters { time_step: 1e-3, alpha: 0.1, beta: 1e-6, density: 1.0, stiffness: 1.0 };
    let bytes = Body::closed(layout, 1).file(&bathe(), &step, Element::F32);
    for structure in [StructureChoice::Diagonal, StructureChoice::Block, StructureChoice::Exact] {
        let options = SceneOptions { structure, ..SceneOptions::default() };
        let sizes = Scene::<f32>::sizes(&File::parse(&bytes).expect("file"), &options).expect("sizes");
        let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
        let (mut state, mut loads) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
        let mut body = vec![0.0; 3 * layout.n_nodes()];
        let before = ALLOCATIONS.get();
        let file = File::parse(&bytes).expect("file");
        file.verify_all().expect("sound");
        let scene = Scene::bind(&file, &options, &mut memory, &mut work).expect("bound");
        let mut state = State::new(&scene, &mut state).expect("memory");
        let mut loads = Loads::new(&scene, &mut loads).expect("memory");
        let point = Surface::new(&file).expect("surface").locate([0.3, 0.4, 2.0]).expect("somewhere");
        let contact = Contact::new(point.place, [0.0, 0.0, -1.0]);
        scene.set(&mut state, &[0.1; 6], &[0.0; 6], &loads).expect("set");
        for _ in 0..1000 {
            loads.clear();
            loads.add_contact(&scene, &contact).expect("contact");
            loads.add_pattern(&scene, 0, 0.1).expect("pattern");
            scene.step(&mut state, &loads).expect("step");
        }
        scene.body_into(&state, Field::Displacement, &mut body).expect("body");
        let energy = scene.energy(&state).expect("energy");
        let probe = scene.probe(&state, 0, Field::Velocity).expect("probe");
        let at_point = scene.point(&state, &point, Field::Displacement).expect("point");
        let after = ALLOCATIONS.get();
        assert_eq!(after - before, 0, "{structure:?}");
        assert!(energy > 0.0 && probe.is_finite() && at_point[2] != 0.0);
    }
}

/// A free body on a cable that flies against a ceiling.
fn a_life_in_a_world() {
    let bytes = include_bytes!("../../fixtures/golden/free.vdm");
    let file = File::parse(bytes).expect("file");
    let options = BodyOptions::default();
    let length = Bound::<f64>::len_for(&file, &options).expect("length");
    let mut memory = vec![0.0; length];
    let (nodes, triangles) = ([[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [0.0, 9.0, 0.0]], [[0, 2, 1]]);
    let pairs = [Touching::new(0, 1).with_friction(0.5)];
    let world = WorldOptions { gravity: [0.1, 0.0, 9.81], contacts: 64, ..WorldOptions::default() };
    let mut ceiling = RigidShape::led(&[], &[], Pose::IDENTITY).expect("a ceiling");
    let joints = [WorldJoint::new(
        JointKind::Cable { length: 0.02 },
        [0, 2],
        [Anchor::Place(Place::node(0)), Anchor::point([0.0; 3])],
    )];
    let mut body = Bound::<f64>::bind(&file, &options, &mut memory).expect("bound");
    let rigid = body.rigid_body().expect("free");
    // Over its loadable nodes, which look up.
    let over = Pose::at([0.0, 0.0, 1e-3]);
    let mut floor = RigidShape::led(&nodes, &triangles, over).expect("a floor");
    let motion = RigidMotion::thrown(&rigid, [0.0, 0.0, 0.1], [0.0; 3]);
    body.set_motion(motion).expect("a motion");
    let mut members = [Member::Free(&mut body), Member::Rigid(&mut floor), Member::Rigid(&mut ceiling)];
    let sizes = World::sizes(&members, &joints, &world).expect("sizes");
    let mut buffers = WorldBuffers::new(&sizes);
    let before = ALLOCATIONS.get();
    let mut world = World::new(&members, &pairs, &joints, &world, buffers.lend()).expect("a world");
    let mut pressed = 0;
    for _ in 0..100 {
        pressed += world.step(&mut members).expect("a step").pressed;
    }
    let allocated = ALLOCATIONS.get() - before;
    assert!(pressed > 0);
    assert_eq!(allocated, 0);
}
