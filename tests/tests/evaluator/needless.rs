//! A scene reads what its needs ask for and nothing else: with every other number of the file poisoned, the
//! bits stay the same, and what is read is as much as [`Scene::cost`] says.

use vademecum_eval::{
    BindError, Contact, Cost, Field, Loads, Place, Scene, SceneOptions, State, StepError, StructureChoice,
};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{Element, File, Section, SectionKind, SectionKind as S};
use vademecum_tests::regions::{LAYOUT, R, TwoRegions, chebyshev};
use vademecum_tests::stage::with_scene;
use vademecum_tests::synthetic::{Body, bathe, encode};

const STEP: StepParameters =
    StepParameters { time_step: 2e-3, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 };
const NODES: [u32; 3] = [1, 4, 3];
/// Sections that only what is asked for may touch: the fields, the loads, the probes.
const LARGE: [S; 6] =
    [S::SurfaceBasis, S::InteriorBasis, S::BlockLoad, S::PatternBasis, S::PatternBlock, S::ProbeRows];

/// The file with a NaN for every number of the large sections that `needed(kind, index)` does not want; with
/// how many bytes it wants.
fn poisoned(bytes: &[u8], needed: impl Fn(S, usize) -> bool) -> (Vec<u8>, usize) {
    let file = File::parse(bytes).expect("a file");
    let mut kept = 0;
    let mut contents = vec![];
    for section in file.sections() {
        let (kind, element) = (section.kind(), section.element());
        let mut stored = section.stored().to_vec();
        if LARGE.contains(&kind) {
            let width = element.size() as usize;
            for (index, number) in stored.chunks_exact_mut(width).enumerate() {
                if needed(kind, index) {
                    kept += width;
                } else {
                    number.fill(0xff);
                }
            }
        }
        contents.push((kind, element, stored));
    }
    (encode(file.metadata(), &contents), kept)
}

/// The file with a NaN for the numbers of one section that are not wanted.
fn poisoned_section(bytes: &[u8], poisoned: SectionKind, unwanted: impl Fn(usize) -> bool) -> Vec<u8> {
    let file = File::parse(bytes).expect("a file");
    let content = |section: Section<'_>| {
        let mut stored = section.stored().to_vec();
        let numbers = stored.chunks_exact_mut(section.element().size() as usize).enumerate();
        numbers
            .filter(|(index, _)| section.kind() == poisoned && unwanted(*index))
            .for_each(|(_, x)| x.fill(0xff));
        (section.kind(), section.element(), stored)
    };
    let contents: Vec<_> = file.sections().map(content).collect();
    encode(file.metadata(), &contents)
}

/// The node of a number of a basis or of the load rows.
fn node(kind: S, index: usize, n_terms: usize, r: usize) -> usize {
    match kind {
        S::BlockLoad => index / (3 * n_terms * r),
        _ => index / (3 * r),
    }
}

/// What a scene is used for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Need {
    Nothing,
    Contact,
    Pattern,
    Probe,
    Node,
    Surface,
    Body,
}

/// Three steps from a moving start and the output asked for.
fn life(
    scene: &Scene<'_, f64>,
    state: &mut State<'_, f64>,
    loads: &mut Loads<'_, f64>,
    need: Need,
) -> Vec<f64> {
    let r = scene.n_modes();
    let start: Vec<f64> = (0..3 * r).map(|k| 0.01 * (k as f64 - 3.0)).collect();
    state.restore(&start).expect("start");
    match need {
        Need::Contact => {
            let contact = Contact::new(Place::triangle(NODES, [0.2, 0.5, 0.3]), [1.0, -2.0, 0.7]);
            loads.add_contact(scene, &contact).expect("contact");
        }
        Need::Pattern => loads.add_pattern(scene, 0, 0.3).expect("pattern"),
        _ => {}
    }
    let mut out = vec![];
    for _ in 0..3 {
        match scene.step(state, loads) {
            Ok(_) => out.extend_from_slice(state.zeta()),
            Err(StepError::NotFinite) => out.push(f64::NAN),
            Err(error) => panic!("{error}"),
        }
    }
    let m = scene.metadata();
    let mut field = vec![0.0; 3 * if need == Need::Body { m.n_nodes } else { m.n_surface_nodes } as usize];
    match need {
        Need::Probe => out.push(scene.probe(state, 1, Field::Velocity).expect("probe")),
        Need::Node => out.extend(scene.node(state, 5, Field::Displacement).expect("node")),
        Need::Surface => scene.surface_into(state, Field::Displacement, &mut field).expect("surface"),
        Need::Body => scene.body_into(state, Field::Displacement, &mut field).expect("body"),
        _ => {}
    }
    out.extend(field);
    out
}

fn bits(bytes: &[u8], options: &SceneOptions, need: Need) -> (Vec<u64>, Cost) {
    with_scene::<f64, _>(bytes, options, |scene, state, loads| {
        let numbers = life(scene, state, loads, need);
        (numbers.iter().map(|x| x.to_bits()).collect(), scene.cost())
    })
}

/// Whether a need reads a number, and what the scene says about how much.
fn reads(need: Need, kind: S, index: usize, n_terms: usize, r: usize, diagonal: bool) -> bool {
    match (need, kind) {
        (Need::Contact, S::SurfaceBasis) => NODES.contains(&(node(kind, index, n_terms, r) as u32)),
        (Need::Contact, S::BlockLoad) => !diagonal && NODES.contains(&(node(kind, index, n_terms, r) as u32)),
        (Need::Pattern, S::PatternBasis) => true,
        (Need::Pattern, S::PatternBlock) => !diagonal,
        (Need::Probe, S::ProbeRows) => index / r == 1,
        (Need::Node, S::SurfaceBasis) => node(kind, index, n_terms, r) == 5,
        (Need::Surface | Need::Body, S::SurfaceBasis) | (Need::Body, S::InteriorBasis) => true,
        _ => false,
    }
}

fn stated(need: Need, cost: &Cost) -> usize {
    match need {
        Need::Nothing => 0,
        Need::Contact => cost.contact_bytes,
        Need::Pattern => cost.pattern_bytes,
        Need::Probe => cost.probe_bytes,
        Need::Node => cost.node_bytes,
        Need::Surface => cost.surface_bytes,
        Need::Body => cost.body_bytes,
    }
}

fn each_need_reads_its_own(bytes: &[u8], options: &SceneOptions, needs: &[Need]) {
    let metadata = *File::parse(bytes).expect("a file").metadata();
    let (n_terms, r) = (metadata.n_terms as usize, metadata.n_modes as usize);
    let diagonal = options.structure == StructureChoice::Diagonal;
    for &need in needs {
        let reads = |kind, index| reads(need, kind, index, n_terms, r, diagonal);
        let (clean, cost) = bits(bytes, options, need);
        let (rest_poisoned, kept) = poisoned(bytes, reads);
        assert_eq!(bits(&rest_poisoned, options, need).0, clean, "{need:?} reads more than it needs");
        assert_eq!(stated(need, &cost), kept, "{need:?}");
        // The other way round: what it is said to read, it does read.
        if need != Need::Nothing {
            let (all_poisoned, _) = poisoned(bytes, |_, _| false);
            assert_ne!(bits(&all_poisoned, options, need).0, clean, "{need:?} reads nothing");
        }
    }
}

#[test]
fn a_scene_reads_what_it_needs() {
    let bytes = Body::open(LAYOUT, 1).file(&bathe(), &STEP, Element::F32);
    let all =
        [Need::Nothing, Need::Contact, Need::Pattern, Need::Probe, Need::Node, Need::Surface, Need::Body];
    for structure in [StructureChoice::Diagonal, StructureChoice::Block] {
        each_need_reads_its_own(&bytes, &SceneOptions { structure, ..SceneOptions::default() }, &all);
    }
}

#[test]
fn terms_that_vanish_at_the_parameters_are_not_read() {
    let (common, contrast) = (chebyshev(3, 1e-8, 1e-5, true), [0.5, 1.0, 2.0]);
    let bytes = TwoRegions::new(1).separated(&bathe(), &STEP, &common, &contrast, &[]);
    let block = SceneOptions { structure: StructureChoice::Block, ..SceneOptions::default() };
    let file = File::parse(&bytes).expect("a file");
    let all = (file.metadata().n_terms as usize, file.metadata().n_modes as usize);
    assert_eq!(all, (9, R));
    // At the middle of the contrast only its three terms of nine are left; elsewhere all nine.
    let mut moved = block;
    moved.set(file.metadata(), &[(0, 1.5)]).expect("in range");
    for (options, n_terms) in [(block, 3), (moved, 9)] {
        let cost = bits(&bytes, &options, Need::Nothing).1;
        assert_eq!(cost.terms, n_terms);
        assert_eq!(cost.contact_rows, 9 * (1 + n_terms));
        assert_eq!(cost.contact_bytes, 8 * R * cost.contact_rows);
        assert_eq!(cost.bind_bytes, 8 * (n_terms * R * R + 6 + 9 * 6));
        let n_terms = all.0;
        // Terms are in the order of the grid, the contrast fastest.
        let unread = |kind, index| {
            let term = index / (3 * R) % n_terms;
            kind != S::BlockLoad || cost.terms == n_terms || term % 3 == 1
        };
        let (clean, _) = bits(&bytes, &options, Need::Contact);
        assert_eq!(bits(&poisoned(&bytes, unread).0, &options, Need::Contact).0, clean);
    }
}

/// Binding, a change of parameters, a contact, a pattern and steps, of a scene that keeps its number of terms
/// throughout.
fn life_with_terms(bytes: &[u8], options: &SceneOptions) -> (Vec<u64>, Cost) {
    let file = File::parse(bytes).expect("a file");
    let sizes = Scene::<f64>::sizes(&file, options).expect("sizes");
    let [mut memory, mut work, mut state_memory, mut load_memory] =
        [sizes.scene, sizes.work, sizes.state, sizes.loads].map(|length| vec![0.0; length]);
    let mut scene = Scene::bind(&file, options, &mut memory, &mut work).expect("bound");
    let mut state = State::new(&scene, &mut state_memory).expect("memory");
    scene.set_parameters(&[(0, 1.5)], &mut state, &mut work).expect("in range");
    let mut loads = Loads::new(&scene, &mut load_memory).expect("memory");
    loads.add_pattern(&scene, 0, 0.3).expect("pattern");
    let numbers = life(&scene, &mut state, &mut loads, Need::Contact);
    (numbers.iter().map(|x| x.to_bits()).collect(), scene.cost())
}

#[test]
fn terms_a_scene_leaves_out_are_not_touched() {
    let (common, contrast) = (chebyshev(5, 1e-8, 1e-5, true), [0.5, 1.0, 2.0]);
    let bytes = TwoRegions::new(1).separated(&bathe(), &STEP, &common, &contrast, &[]);
    let file = File::parse(&bytes).expect("a file");
    let n_terms = file.metadata().n_terms as usize;
    let block = SceneOptions { structure: StructureChoice::Block, ..SceneOptions::default() };
    let mut before = None;
    for terms in [n_terms, 11, 6] {
        let options = SceneOptions { terms: Some(terms), ..block };
        let (clean, cost) = life_with_terms(&bytes, &options);
        assert_eq!(cost.terms, terms);
        assert_eq!(cost.bind_bytes, 8 * (terms * R * R + 8 + terms * 8));
        assert_eq!(cost.contact_bytes, 8 * R * 9 * (1 + terms));
        assert_eq!(cost.pattern_bytes, 8 * R * (1 + terms));
        assert_ne!(before.replace(clean.clone()), Some(clean.clone()), "the terms left out count");
        // Only terms in use are left numbers; of the factors, those of 5 points come first.
        let term = |kind: S, index: usize| match kind {
            S::BlockState => index / (R * R),
            S::BlockLoad => index / (3 * R) % n_terms,
            S::PatternBlock => index / R % n_terms,
            _ => index.checked_sub(5 * n_terms).map_or(index / 5, |index| index / 3),
        };
        for kind in [S::BlockState, S::BlockLoad, S::PatternBlock, S::Factors] {
            let poisoned = poisoned_section(&bytes, kind, |index| term(kind, index) >= terms);
            assert_eq!(life_with_terms(&poisoned, &options).0, clean, "{kind:?} past term {terms}");
        }
    }
    for asked in [0, n_terms + 1] {
        let found = Scene::<f64>::sizes(&file, &SceneOptions { terms: Some(asked), ..block });
        assert_eq!(found, Err(BindError::Terms { asked, found: n_terms }));
    }
    // A term of a stage axis is a stage.
    let bytes = Body::open(LAYOUT, 1).file(&bathe(), &STEP, Element::F32);
    let found =
        Scene::<f64>::sizes(&File::parse(&bytes).expect("a file"), &SceneOptions { terms: Some(1), ..block });
    assert_eq!(found, Err(BindError::Terms { asked: 1, found: 2 }));
}

#[test]
fn a_step_costs_what_its_structure_says() {
    let bytes = Body::open(LAYOUT, 1).file(&bathe(), &STEP, Element::F32);
    let options = |structure| SceneOptions { structure, ..SceneOptions::default() };
    let r = LAYOUT.r;
    let diagonal = bits(&bytes, &options(StructureChoice::Diagonal), Need::Nothing).1;
    assert_eq!((diagonal.terms, diagonal.step_operations, diagonal.bind_bytes), (0, 9 * r, 8 * r));
    assert_eq!(diagonal.contact_rows, 9);
    let block = bits(&bytes, &options(StructureChoice::Block), Need::Nothing).1;
    assert_eq!((block.terms, block.step_operations), (2, 9 * r * r));
}
