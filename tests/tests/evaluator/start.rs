//! A new state starts with the acceleration that its first loads demand: a program that binds, loads and
//! steps, as the README shows it, gets what `vademecum run` gets.

use vademecum_build::progress::Silent;
use vademecum_eval::{
    Batch, Contact, Loads, Place, Scalar, SceneOptions, State, Status, StepError, StructureChoice, Surface,
};
use vademecum_format::File;
use vademecum_study::player::{Track, play_in};
use vademecum_study::scenario::Scenario;
use vademecum_tests::program::{fixtures, vademecum};
use vademecum_tests::stage::{with_chapter, with_scene};

const STEPS: usize = 500;
const FINGER: [f64; 3] = [0.1, 0.05, 0.0];
const FORCE: [f64; 3] = [3.0, -8.0, -20.0];

/// A body of 3 modes in both structures, with a surface.
fn body() -> Vec<u8> {
    golden("fixed-f64.vdm")
}

fn golden(name: &str) -> Vec<u8> {
    fixtures("golden").into_iter().find(|(found, _)| found == name).expect("a golden file").1
}

fn options(structure: StructureChoice) -> SceneOptions {
    SceneOptions { structure, ..SceneOptions::default() }
}

/// The contact of the README's program.
fn contact(bytes: &[u8]) -> Contact {
    let file = File::parse(bytes).expect("a file");
    let touched = Surface::new(&file).expect("a surface").locate(FINGER).expect("a point");
    Contact::new(touched.place, FORCE)
}

/// The same as a scenario of [`STEPS`] steps.
fn scenario(bytes: &[u8]) -> Scenario {
    let duration = STEPS as f64 * File::parse(bytes).expect("a file").metadata().time_step;
    let text = format!("duration = {duration:e}\n[[contact]]\npoint = {FINGER:?}\nforce = {FORCE:?}\n");
    Scenario::parse(&text, "scenario.toml").expect("a scenario")
}

/// `ζ` after each step of a run.
fn run<T: Scalar>(bytes: &[u8], options: &SceneOptions) -> Vec<Vec<f64>> {
    let file = File::parse(bytes).expect("a file");
    let track = Track::bind(&file, &scenario(bytes)).expect("bound");
    let mut zetas = vec![];
    play_in::<T>(&file, options, &track, STEPS, &Silent, |_, body| {
        zetas.push(numbers(body.zeta()));
        Ok(())
    })
    .expect("played");
    zetas.split_off(1)
}

fn numbers<T: Scalar>(values: &[T]) -> Vec<f64> {
    values.iter().map(|x| x.to_f64()).collect()
}

fn saved<T: Scalar>(state: &State<'_, T>) -> Vec<u64> {
    let mut out = [state.zeta(), state.scaled_velocity(), state.scaled_acceleration()].concat();
    state.save_into(&mut out).expect("saved");
    out.iter().map(|x| x.to_f64().to_bits()).collect()
}

/// Largest difference relative to the largest number.
fn apart(found: &[Vec<f64>], expected: &[Vec<f64>]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let largest = expected.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    let both = found.iter().flatten().zip(expected.iter().flatten());
    both.fold(0.0f64, |m, (a, b)| m.max((a - b).abs())) / largest
}

fn the_readme_gives_what_run_gives<T: Scalar>(structure: StructureChoice) {
    let (bytes, options) = (body(), options(structure));
    let expected = run::<T>(&bytes, &options);
    // The amplitudes of a held contact are weighted sums of 1, which rounds once.
    let rounding = STEPS as f64 * T::EPSILON;
    with_scene::<T, _>(&bytes, &options, |scene, state, loads| {
        loads.add_contact(scene, &contact(&bytes)).expect("a contact");
        let step = |_| {
            assert_eq!(scene.step(state, loads), Ok(Status::Moving));
            numbers(state.zeta())
        };
        let found: Vec<_> = (0..STEPS).map(step).collect();
        assert!(apart(&found[..1], &expected[..1]) < rounding, "{structure:?}: the first step");
        assert!(apart(&found, &expected) < rounding, "{structure:?}: {}", apart(&found, &expected));

        let mut memory = vec![T::ZERO; Batch::len_for(scene, 20)];
        let mut batch = Batch::new(scene, 20, &mut memory).expect("a batch");
        batch.load(scene, 17, loads).expect("loaded");
        for found in &found {
            batch.step(scene).expect("a step");
            batch.get(17, state).expect("a state");
            assert_eq!(numbers(state.zeta()), *found, "{structure:?}: an instance of a batch");
        }
    });
}

#[test]
fn the_program_of_the_readme_gives_what_run_gives() {
    for structure in [StructureChoice::Diagonal, StructureChoice::Block] {
        the_readme_gives_what_run_gives::<f32>(structure);
        the_readme_gives_what_run_gives::<f64>(structure);
    }
}

#[test]
fn the_table_of_run_is_that_of_the_program_of_the_readme() {
    let (bytes, folder) = (body(), tempfile::tempdir().expect("a folder"));
    let [file, input, output] = ["body.vdm", "scenario.toml", "out"].map(|name| folder.path().join(name));
    std::fs::write(&file, &bytes).expect("written");
    let duration = STEPS as f64 * File::parse(&bytes).expect("a file").metadata().time_step;
    let text = format!("duration = {duration:e}\n[[contact]]\npoint = {FINGER:?}\nforce = {FORCE:?}\n");
    std::fs::write(&input, text).expect("written");
    let arguments = [
        "run".as_ref(),
        file.as_os_str(),
        "--scenario".as_ref(),
        input.as_ref(),
        "-o".as_ref(),
        output.as_ref(),
    ];
    let ran = vademecum(&arguments);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let table = std::fs::read_to_string(output.join("probes.csv")).expect("a table");
    let row = |line: &str| line.split(',').skip(1).map(|x| x.parse().expect("a number")).collect();
    let table: Vec<Vec<f64>> = table.lines().skip(2).map(row).collect();
    let probes = File::parse(&bytes).expect("a file").metadata().n_probes as usize;
    let found: Vec<Vec<f64>> =
        with_scene::<f64, _>(&bytes, &SceneOptions::default(), |scene, state, loads| {
            loads.add_contact(scene, &contact(&bytes)).expect("a contact");
            let mut step = |_| {
                scene.step(state, loads).expect("a step");
                let probe = |i| scene.probe(state, i, vademecum_eval::Field::Displacement).expect("a probe");
                let energy = scene.energy(state).expect("an energy");
                std::iter::once(energy).chain((0..probes).map(probe)).collect()
            };
            (0..STEPS).map(&mut step).collect()
        });
    let column = |rows: &[Vec<f64>], c: usize| rows.iter().map(|row| vec![row[c]]).collect::<Vec<_>>();
    for c in 0..=probes {
        // The table has ten digits.
        let apart = apart(&column(&found, c), &column(&table, c));
        assert!(apart < 1e-9, "column {c}: {apart}");
    }
}

/// Bits of 60 steps under a pattern, from a new state and from one that `set` put at rest under the load.
fn both_starts<T: Scalar>(bytes: &[u8], options: &SceneOptions) -> [Vec<u64>; 3] {
    with_scene::<T, _>(bytes, options, |scene, state, loads| {
        let r = scene.n_modes();
        loads.add_pattern(scene, 0, 0.75).expect("a pattern");
        let march = |state: &mut State<'_, T>| -> Vec<u64> {
            let mut bits = vec![];
            for _ in 0..60 {
                scene.step(state, loads).expect("a step");
                bits.extend(saved(state));
            }
            bits
        };
        let new = march(state);
        scene.set(state, &vec![0.0; r], &vec![0.0; r], loads).expect("set");
        let set = march(state);
        let mut memory = vec![T::ZERO; Batch::len_for(scene, 3)];
        let mut batch = Batch::new(scene, 3, &mut memory).expect("a batch");
        batch.load(scene, 2, loads).expect("loaded");
        let mut in_batch = vec![];
        for _ in 0..60 {
            batch.step(scene).expect("a step");
            batch.get(2, state).expect("a state");
            in_batch.extend(saved(state));
        }
        [new, set, in_batch]
    })
}

#[test]
fn a_new_state_has_the_bits_of_one_set_at_rest_under_the_same_load() {
    let mut densities = 0;
    for (name, bytes) in fixtures("golden") {
        let file = File::parse(&bytes).expect("a file");
        let metadata = *file.metadata();
        for (structure, there) in [
            (StructureChoice::Diagonal, metadata.diagonal && !metadata.scheme.is_exact()),
            (StructureChoice::Block, metadata.block),
            (StructureChoice::Exact, metadata.diagonal),
        ] {
            if !there {
                continue;
            }
            let mut options = options(structure);
            for (i, parameter) in metadata.active_parameters().iter().enumerate() {
                let value = parameter.nominal + 0.0625 * (parameter.upper - parameter.nominal);
                options.set(&metadata, &[(i, value)]).expect("in its range");
            }
            densities += usize::from(options.regions.density().iter().any(|&scale| scale != 1.0));
            for [new, set, in_batch] in
                [both_starts::<f32>(&bytes, &options), both_starts::<f64>(&bytes, &options)]
            {
                assert!(new.iter().any(|&bits| bits != 0));
                assert_eq!(new, set, "{name}, {structure:?}");
                assert_eq!(new, in_batch, "{name}, {structure:?}, in a batch");
            }
        }
    }
    assert!(densities > 0, "no golden file has a live density, whose mass is solved for");
}

#[test]
fn the_chapters_scene_starts_alike() {
    let bytes = golden("canonical.vdm");
    let file = File::parse(&bytes).expect("a file");
    let node = vademecum_format::Chapter::read(&file).expect("sound").expect("there");
    let node = node.positions().nth(1).expect("a position");
    let contact = Contact::new(Place::triangle([node; 3], [1.0, 0.0, 0.0]), [0.0, 0.0, 1.0]);
    with_chapter(&bytes, |scene, state, loads| {
        loads.add_contact(scene, &contact).expect("a contact");
        let zero = vec![0.0; scene.n_modes()];
        let mut starts = vec![];
        for set in [false, true] {
            state.rest();
            if set {
                scene.set(state, &zero, &zero, loads).expect("set");
            }
            scene.step(state, loads).expect("a step");
            starts.push(state.zeta().to_vec());
        }
        assert!(starts[0].iter().any(|&x| x != 0.0));
        assert_eq!(starts[0], starts[1]);
    });
}

#[test]
fn a_state_that_was_stepped_or_set_meets_a_new_load_as_it_is() {
    with_scene::<f64, _>(&body(), &SceneOptions::default(), |scene, state, loads| {
        let r = scene.n_modes();
        let zero = vec![0.0; r];
        let first = |state: &mut State<'_, f64>, loads: &mut Loads<'_, f64>| {
            loads.clear();
            loads.add_pattern(scene, 0, 1.0).expect("a pattern");
            scene.step(state, loads).expect("a step");
            state.zeta().to_vec()
        };
        let new = first(state, loads);
        loads.clear();
        state.rest();
        assert_eq!(scene.step(state, loads), Ok(Status::AtRest));
        let after_a_step = first(state, loads);
        loads.clear();
        scene.set(state, &zero, &zero, loads).expect("set at rest");
        assert_eq!(first(state, loads), after_a_step);
        assert!(new.iter().zip(&after_a_step).any(|(a, b)| (a - b).abs() > 0.1 * a.abs()));
    });
}

#[test]
fn a_state_that_has_not_started_is_saved_and_restored_as_one() {
    with_scene::<f32, _>(&body(), &SceneOptions::default(), |scene, state, loads| {
        let r = scene.n_modes();
        let mut new = vec![1.0; 3 * r];
        state.save_into(&mut new).expect("saved");
        assert!(new.iter().all(|&x| x == 0.0));
        loads.add_pattern(scene, 0, 1.0).expect("a pattern");
        scene.step(state, loads).expect("a step");
        let once = saved(state);
        state.restore(&new).expect("restored");
        scene.step(state, loads).expect("a step");
        assert_eq!(saved(state), once);
        state.restore(&vec![0.0; 3 * r]).expect("restored");
        scene.step(state, loads).expect("a step");
        assert_ne!(saved(state), once, "zeros that were not saved from a new state");
    });
}

#[test]
fn a_first_step_that_is_refused_leaves_the_state_new() {
    let bytes = body();
    // Steps so long that a force which may be given moves the body too far.
    let options = SceneOptions { time_step: Some(1e8), ..options(StructureChoice::Diagonal) };
    with_scene::<f32, _>(&bytes, &options, |scene, state, loads| {
        loads.add_pattern(scene, 0, 1e-6).expect("a pattern");
        scene.step(state, loads).expect("a step");
        let sound = saved(state);
        loads.clear();
        loads.add_pattern(scene, 0, 1e17).expect("a pattern");
        state.rest();
        assert_eq!(scene.step(state, loads), Err(StepError::NotFinite));
        assert!(state.scaled_acceleration().iter().all(|&x| x == 0.0));
        loads.clear();
        loads.add_pattern(scene, 0, 1e-6).expect("a pattern");
        scene.step(state, loads).expect("a step");
        assert_eq!(saved(state), sound);
    });
}
