//! The bits of everything the evaluator computes from the golden files, as checksums.
//!
//! The evaluator uses `+ − × ÷ √` and its own logarithms and powers in a fixed order, so these checksums are
//! the same on every machine with IEEE arithmetic. A change that only moves code must leave them alone. A
//! change that means to alter a result prints the new table when it fails; put it here and say in the commit
//! what changed and why.

use vademecum_eval::{
    Batch, Contact, Field, Loads, Place, Scalar, Scene, SceneOptions, State, StructureChoice, SurfacePoint,
};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{File, SectionKind};
use vademecum_tests::canonical::{Terms, file as chapter_file};
use vademecum_tests::program::fixtures;
use vademecum_tests::stage::with_chapter;
use vademecum_tests::synthetic::{Body, Layout, bathe};

/// Checksums of `name, structure`: in f32, in f64.
const KNOWN: &[(&str, [u32; 2])] = &[
    ("anisotropic.vdm, Exact", [0xdc21195d, 0x541ecfbc]),
    ("base.vdm, Exact", [0xdc21195d, 0x541ecfbc]),
    ("bent.vdm, Strain", [0x72402b2f, 0xf9c2abbb]),
    ("damped.vdm, Exact", [0x625010fc, 0xc1153249]),
    ("dashpots.vdm, Exact", [0x4727853e, 0x6864184a]),
    ("embedded.vdm, Diagonal", [0x9e0d3e3c, 0xe22eb3ee]),
    ("embedded.vdm, Block", [0x5a522db1, 0x35760690]),
    ("exact-f64.vdm, Exact", [0xdc21195d, 0x541ecfbc]),
    ("fixed-f32.vdm, Diagonal", [0x7605947e, 0xd107ad49]),
    ("fixed-f32.vdm, Block", [0xf1eed633, 0x21683f0c]),
    ("fixed-f64.vdm, Diagonal", [0x9e0d3e3c, 0xe22eb3ee]),
    ("fixed-f64.vdm, Block", [0x5a522db1, 0x35760690]),
    ("free.vdm, Exact", [0xe80c91b6, 0x31aa7c22]),
    ("parameters.vdm, Block", [0xd0fa08b1, 0xb2a9164b]),
    ("parametric.vdm, Exact", [0xf04f1b3f, 0xfed2c470]),
    ("patch.vdm, Exact", [0xdf26442d, 0xcbcb1bda]),
    ("ports.vdm, Exact", [0xdc21195d, 0x541ecfbc]),
    ("probes.vdm, Diagonal", [0xad659dd5, 0xabaa89b0]),
    ("probes.vdm, Block", [0xe3201153, 0xb2684806]),
    ("quadrangles.vdm, Exact", [0xd4cf94f6, 0xfea202fd]),
    ("quadratic.vdm, Diagonal", [0x6a3cb981, 0x59ce8912]),
    ("quadratic.vdm, Block", [0x1efe845f, 0x5f138d53]),
    ("quantised.vdm, Diagonal", [0x09b98b97, 0x8a8e8a7b]),
    ("quantised.vdm, Block", [0x87db5458, 0xecd744a3]),
    ("reactions.vdm, Exact", [0xdc21195d, 0x541ecfbc]),
    ("repairs.vdm, Diagonal", [0xad659dd5, 0xabaa89b0]),
    ("repairs.vdm, Block", [0xe3201153, 0xb2684806]),
    ("separation.vdm, Block", [0xd0fa08b1, 0xb2a9164b]),
    ("stress.vdm, Exact", [0xdc21195d, 0x541ecfbc]),
    ("swinging.vdm, Strain", [0xe5802d5c, 0x37a26d8a]),
];

/// Checksums of the chapter's structure, which steps in f64 only.
const KNOWN_CHAPTER: [(&str, u32); 2] = [("canonical.vdm", 0xc4f64533), ("joint terms", 0x23b8c7be)];

/// Numbers, gathered bit by bit.
#[derive(Default)]
struct Bits(crc32fast::Hasher);

impl Bits {
    fn add<T: Scalar>(&mut self, numbers: &[T]) {
        // Exact for both precisions.
        numbers.iter().for_each(|x| self.0.update(&x.to_f64().to_le_bytes()));
    }
}

/// Everything that can be read of a state, of a scene of either kind.
macro_rules! read {
    ($file:expr, $scene:expr, $state:expr, $bits:expr) => {{
        let (file, scene, state, bits): (&File<'_>, _, _, &mut Bits) = ($file, $scene, $state, $bits);
        bits.add(state.zeta());
        bits.add(state.scaled_velocity());
        bits.add(state.scaled_acceleration());
        bits.add(&[scene.energy(state).expect("an energy"), scene.energy_at_rest()]);
        let point = SurfacePoint {
            place: Place::triangle([0, 1, 3], [0.2, 0.5, 0.3]),
            position: [0.0; 3],
            distance: 0.0,
        };
        let metadata = file.metadata();
        for field in [Field::Displacement, Field::Velocity] {
            for probe in 0..metadata.n_probes as usize {
                bits.add(&[scene.probe(state, probe, field).expect("a probe")]);
            }
            if file.section(SectionKind::SurfaceBasis).is_none() {
                continue;
            }
            bits.add(&scene.point(state, &point, field).expect("a point"));
            let mut surface = vec![Default::default(); 3 * metadata.n_surface_nodes as usize];
            scene.surface_into(state, field, &mut surface).expect("the surface");
            bits.add(&surface);
            if scene.node(state, metadata.n_nodes as usize - 1, field).is_ok() {
                let mut body = vec![Default::default(); 3 * metadata.n_nodes as usize];
                scene.body_into(state, field, &mut body).expect("the body");
                bits.add(&body);
            }
        }
    }};
}

fn read<T: Scalar>(file: &File<'_>, scene: &Scene<'_, T>, state: &State<'_, T>, bits: &mut Bits) {
    read!(file, scene, state, bits);
}

/// A march under a contact and a pattern, at rest and placed, with every parameter moved on the way, in a
/// batch and in modes.
fn ordinary<T: Scalar>(bytes: &[u8], structure: StructureChoice) -> u32 {
    let file = File::parse(bytes).expect("a file");
    let options = SceneOptions { structure, ..SceneOptions::default() };
    let sizes = Scene::<T>::sizes(&file, &options).expect("sizes");
    let (mut memory, mut work) = (vec![T::ZERO; sizes.scene], vec![0.0; sizes.work]);
    let (mut state, mut loads) = (vec![T::ZERO; sizes.state], vec![T::ZERO; sizes.loads]);
    let mut scene = Scene::bind(&file, &options, &mut memory, &mut work).expect("bound");
    let mut state = State::new(&scene, &mut state).expect("a state");
    let mut loads = Loads::new(&scene, &mut loads).expect("loads");
    let mut bits = Bits::default();
    let contact = Contact::new(Place::triangle([0, 1, 3], [0.2, 0.5, 0.3]), [1.0, -2.0, 0.5]);
    let ramp = [0.0, 0.25, 0.5, 1.0];
    let load = |scene: &Scene<'_, T>, loads: &mut Loads<'_, T>| {
        loads.clear();
        loads.add_pattern(scene, 0, 0.75).expect("a pattern");
        loads.add_pattern_staged(scene, 0, &ramp).expect("a pattern");
        if file.section(SectionKind::SurfaceBasis).is_some() {
            loads.add_contact(scene, &contact).expect("a contact");
            loads.add_contact_staged(scene, &contact, &ramp).expect("a contact");
        }
    };
    load(&scene, &mut loads);
    let r = scene.n_modes();
    let start: Vec<f64> = (0..r).map(|k| 1e-3 / (1.0 + k as f64)).collect();
    scene.set(&mut state, &start, &vec![0.25; r], &loads).expect("placed");
    march(&file, &scene, &mut state, &mut loads, &mut bits);
    for (index, parameter) in file.metadata().active_parameters().iter().enumerate() {
        let value = parameter.nominal + 0.0625 * (parameter.upper - parameter.nominal);
        scene.set_parameters(&[(index, value)], &mut state, &mut work).expect("set");
        load(&scene, &mut loads);
        march(&file, &scene, &mut state, &mut loads, &mut bits);
    }
    load(&scene, &mut loads);
    scene.set(&mut state, &start, &vec![0.25; r], &loads).expect("placed");
    in_a_batch(&file, &scene, &mut state, &loads, &mut bits);
    bits.0.finalize()
}

fn march<T: Scalar>(
    file: &File<'_>,
    scene: &Scene<'_, T>,
    state: &mut State<'_, T>,
    loads: &mut Loads<'_, T>,
    bits: &mut Bits,
) {
    for step in 0..20 {
        if step == 10 {
            loads.clear();
        }
        scene.step(state, loads).expect("a step");
        read(file, scene, state, bits);
    }
}

fn in_a_batch<T: Scalar>(
    file: &File<'_>,
    scene: &Scene<'_, T>,
    state: &mut State<'_, T>,
    loads: &Loads<'_, T>,
    bits: &mut Bits,
) {
    let mut memory = vec![T::ZERO; Batch::len_for(scene, 20)];
    let mut batch = Batch::new(scene, 20, &mut memory).expect("a batch");
    // Set at rest, instance 3 starts without the acceleration that a new one gets.
    let zeros = vec![T::ZERO; scene.state_numbers()];
    let mut placed = zeros.clone();
    state.save_into(&mut placed).expect("saved");
    state.restore(&zeros).expect("at rest");
    batch.set(3, state).expect("at rest");
    state.restore(&placed).expect("placed");
    batch.load(scene, 3, loads).expect("loaded");
    batch.set(18, state).expect("placed");
    for _ in 0..10 {
        batch.step(scene).expect("a step");
    }
    for instance in [3, 18, 19] {
        batch.get(instance, state).expect("a state");
        read(file, scene, state, bits);
    }
}

/// A march of the chapter's structure under a load that ramps, holds and ends.
fn chapter(bytes: &[u8], force: [f64; 3]) -> u32 {
    let file = File::parse(bytes).expect("a file");
    let node = vademecum_format::Chapter::read(&file).expect("sound").expect("there");
    let node = node.positions().nth(1).expect("a position");
    let contact = Contact::new(Place::triangle([node; 3], [1.0, 0.0, 0.0]), force);
    with_chapter(bytes, |scene, state, loads| {
        let mut bits = Bits::default();
        loads.add_contact_staged(scene, &contact, &[0.0, 0.25, 0.5, 1.0]).expect("a contact");
        let r = scene.n_modes();
        let start: Vec<f64> = (0..r).map(|k| 1e-5 / (1.0 + k as f64)).collect();
        scene.set(state, &start, &vec![1e-4; r], loads).expect("placed");
        for step in 0..60 {
            match step {
                1 => {
                    loads.clear();
                    loads.add_contact(scene, &contact).expect("a contact");
                }
                30 => loads.clear(),
                _ => {}
            }
            scene.step(state, loads).expect("a step");
            read!(&file, scene, &*state, &mut bits);
        }
        bits.0.finalize()
    })
}

#[test]
fn the_bits_of_every_result_stay() {
    let mut found = vec![];
    for (name, bytes) in fixtures("golden") {
        let metadata = *File::parse(&bytes).expect("a file").metadata();
        let exact = metadata.scheme.is_exact();
        for (structure, present) in [
            (StructureChoice::Diagonal, metadata.diagonal && !exact),
            (StructureChoice::Block, metadata.block),
            (StructureChoice::Exact, exact && metadata.diagonal),
            (StructureChoice::Strain, exact && !metadata.diagonal),
        ] {
            if present {
                let both = [ordinary::<f32>(&bytes, structure), ordinary::<f64>(&bytes, structure)];
                found.push((format!("{name}, {structure:?}"), both));
            }
        }
    }
    let known: Vec<_> = KNOWN.iter().map(|(name, bits)| (name.to_string(), *bits)).collect();
    let table = || {
        let row = |(name, [single, double]): &(String, [u32; 2])| {
            format!("    ({name:?}, [{single:#010x}, {double:#010x}]),\n")
        };
        found.iter().map(row).collect::<String>()
    };
    assert!(known == found, "other bits than before:\n{}", table());
}

#[test]
fn the_bits_of_the_chapters_structure_stay() {
    let (_, golden) =
        fixtures("golden").into_iter().find(|(name, _)| name == "canonical.vdm").expect("a golden file");
    let layout = Layout { rows: 3, load_rows: 2, columns: 3, n_interior: 2, r: 3 };
    let step = StepParameters { time_step: 1e-3, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 };
    // Eigenvalues that are written here, as those of the golden files are: powers round differently from
    // machine to machine.
    let body = Body { lambda: vec![900.0, 40_000.0, 2_500_000.0], ..Body::closed(layout, 5) };
    let joint = chapter_file(&body, &bathe(), &step, &[0, 2, 5], Terms::Together);
    let found = [
        ("canonical.vdm", chapter(&golden, [0.0, 0.0, 1.0])),
        ("joint terms", chapter(&joint, [0.0, 0.0, 3.0])),
    ];
    assert!(found == KNOWN_CHAPTER, "other bits than before: {found:#010x?}");
}
