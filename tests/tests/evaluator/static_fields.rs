//! Whole fields with the whole static answer: a file with the factor of the stiffness shows under a held load
//! what sparse statics says at every node, says so in its certificate, and cannot be made to panic.

use std::sync::OnceLock;

use vademecum_build::Matrix;
use vademecum_build::fem::Solve;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::prepared::{Prepared, prepare};
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_eval::{
    Contact, Field, Loads, OutputError, Scalar, Scene, SceneOptions, State, StaticField, Surface,
    SurfacePoint,
};
use vademecum_format::{Element, File, FormatError, SectionKind as S};
use vademecum_rewrite::{Keep, RewriteError, check, pack, pack_within, strip, unpack};
use vademecum_tests::needed_minor;
use vademecum_tests::program::{repository, vademecum};
use vademecum_tests::stage::with_scene;
use vademecum_tests::synthetic::rewritten;

/// All kinds of the factor.
const ALL: [S; 5] = [S::FactorOrder, S::FactorGroups, S::FactorRows, S::FactorValues, S::PatternAnswer];

/// A cube of four modes, damped: point forces move it where four modes cannot follow.
fn cube(output: &str) -> String {
    format!(
        r#"
[mesh]
block = {{ lengths = [0.1, 0.1, 0.1], divisions = [3, 3, 3] }}
[[material]]
young = 2e6
poisson = 0.3
density = 1000.0
[[support]]
on = {{ group = "x_min" }}
[load]
[[load.pattern]]
name = "gravity"
acceleration = [0.0, 0.0, -9.81]
[time]
step = 1e-3
[damping]
alpha = 5.0
beta = 2e-4
[basis]
modes = 4
[output]
{output}
[[output.probe]]
name = "corner"
point = [0.1, 0.1, 0.1]
direction = [0.0, 0.0, 1.0]
"#
    )
}

fn problem(text: &str) -> Problem {
    Problem::parse(text, "p.toml", repository()).expect("a problem")
}

fn built(output: &str) -> Vec<u8> {
    build(&problem(&cube(output)), &BuildOptions::default(), &Silent).expect("built").either().bytes
}

/// In double precision.
fn double() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| built("static_fields = true\nprecision = \"f64\""))
}

/// In single precision.
fn single() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| built("static_fields = true\nprecision = \"f32\""))
}

#[test]
fn a_rounded_basis_is_not_held_against_the_factor() {
    for (bytes, tolerance) in [(double(), 5e-2), (single(), 5e-2), (double(), 1e-6)] {
        let packed = pack_within(bytes, 3, tolerance).expect("packed");
        let whole = unpack(&packed, 1 << 30).expect("unpacked");
        check(&whole).expect("a sound file");
    }
}

fn present(bytes: &[u8]) -> Vec<S> {
    let file = File::parse(bytes).expect("a file");
    ALL.into_iter().filter(|&kind| file.section(kind).is_some()).collect()
}

const FORCE: [f64; 3] = [3.0, 10.0, -20.0];

fn place(bytes: &[u8]) -> SurfacePoint {
    let file = File::parse(bytes).expect("a file");
    Surface::new(&file).expect("a surface").locate([0.08, 0.03, 0.1]).expect("a place")
}

/// `K⁻¹F` of the force at the place, and half of gravity's; three components at each node of the file.
fn static_answers(bytes: &[u8]) -> [Vec<f64>; 2] {
    let text = cube("");
    let prepared: Prepared =
        prepare(&problem(&text), &mut Stopwatch::new(&Silent), &Silent).expect("a model");
    let model = &prepared.body.model;
    let file = File::parse(bytes).expect("a file");
    let ids = file.section(S::NodeIds).expect("ids").u64s().expect("raw");
    let node = |id: &[u8; 8]| {
        let id = u64::from_le_bytes(*id);
        model.mesh().node_ids.iter().position(|&other| other == id).expect("a mesh node")
    };
    let nodes: Vec<usize> = ids.iter().map(node).collect();
    let point = place(bytes);
    let mut force = vec![0.0; prepared.body.n_dof()];
    let touched = point.place.corners().expect("a triangle").0.map(|n| nodes[n as usize] as u32);
    model.add_point_force(&touched, point.place.weights(), FORCE, &mut force);
    let gravity: Vec<f64> = prepared.body.patterns[0].1.iter().map(|f| 0.5 * f).collect();
    let factor = prepared.symbolic.factorize(model.pencil().combine(0.0, 1.0)).expect("definite");
    [force, gravity].map(|load| {
        let mut answer = Matrix::from_fn(load.len(), 1, |i, _| load[i]);
        Solve::new(&prepared.symbolic, 1, true).solve_in_place(&factor, answer.as_mut());
        let free: Vec<f64> = (0..load.len()).map(|i| answer[(i, 0)]).collect();
        let mut full = vec![0.0; model.dofs().n_dof()];
        model.dofs().expand_into(&free, &mut full);
        nodes.iter().flat_map(|&node| [0, 1, 2].map(|c| full[3 * node + c])).collect()
    })
}

/// What a file shows of its whole body after two seconds under loads that stay: with the static answer,
/// without, and the surface with it.
fn settled<T: Scalar>(
    bytes: &[u8],
    options: &SceneOptions,
    load: impl FnOnce(&Scene<'_, T>, &mut Loads<'_, T>),
) -> [Vec<f64>; 3] {
    with_scene::<T, _>(bytes, options, |scene, state, loads| {
        load(scene, loads);
        for _ in 0..2000 {
            scene.step(state, loads).expect("a step");
        }
        let metadata = *File::parse(bytes).expect("a file").metadata();
        let mut whole = vec![T::ZERO; 3 * metadata.n_nodes as usize];
        let mut surface = vec![T::ZERO; 3 * metadata.n_surface_nodes as usize];
        let mut modes = whole.clone();
        with_statics(scene, state, |statics| {
            scene.body_with(state, Field::Displacement, statics, &mut whole).expect("a body");
            scene.surface_with(state, Field::Displacement, statics, &mut surface).expect("a surface");
            scene.body_into(state, Field::Velocity, &mut modes).expect("a body");
            let mut moving = modes.clone();
            scene.body_with(state, Field::Velocity, statics, &mut moving).expect("a body");
            assert!(moving == modes, "what is static does not move");
        });
        scene.body_into(state, Field::Displacement, &mut modes).expect("a body");
        [whole, modes, surface].map(|field| field.into_iter().map(T::to_f64).collect())
    })
}

fn with_statics<T: Scalar, R>(
    scene: &Scene<'_, T>,
    state: &State<'_, T>,
    show: impl FnOnce(&mut StaticField<'_, T>) -> R,
) -> R {
    let [answer, rest] = scene.static_field_sizes();
    let (mut answer, mut rest) = (vec![f64::NAN; answer], vec![T::ZERO; rest]);
    let mut statics = StaticField::new(scene, &mut answer, &mut rest).expect("room");
    scene.solve_static_field(state, &mut statics).expect("an answer");
    show(&mut statics)
}

fn push<T: Scalar>(point: SurfacePoint) -> impl Fn(&Scene<'_, T>, &mut Loads<'_, T>) {
    move |scene, loads| {
        let contact = Contact::new(point.place, FORCE);
        loads.add_contact(scene, &contact).expect("a contact");
    }
}

fn off(found: &[f64], expected: &[f64]) -> f64 {
    let norm = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>().sqrt();
    norm(&mut found.iter().zip(expected).map(|(a, b)| a - b)) / norm(&mut expected.iter().copied())
}

#[test]
fn every_node_ends_where_statics_says() {
    let [pushed, pulled] = static_answers(double());
    let options = SceneOptions::default();
    let [whole, modes, surface] = settled::<f64>(double(), &options, push(place(double())));
    println!("push {:.1e}, modes alone {:.1e}", off(&whole, &pushed), off(&modes, &pushed));
    assert!(off(&whole, &pushed) < 1e-9 && off(&modes, &pushed) > 0.05);
    assert!(surface == whole[..surface.len()]);

    let [whole, modes, _] = settled::<f64>(double(), &options, |scene, loads| {
        loads.add_pattern(scene, 0, 0.5).expect("a pattern");
    });
    assert!(off(&whole, &pulled) < 1e-9 && off(&modes, &pulled) > 1e-3);

    // Both at once, in a body twice as stiff.
    let stiff = SceneOptions { stiffness: 2.0, ..options };
    let [whole, ..] = settled::<f64>(double(), &stiff, |scene, loads| {
        push(place(double()))(scene, loads);
        loads.add_pattern(scene, 0, 0.5).expect("a pattern");
    });
    let half: Vec<f64> = pushed.iter().zip(&pulled).map(|(a, b)| 0.5 * (a + b)).collect();
    assert!(off(&whole, &half) < 1e-9);
}

#[test]
fn single_precision_costs_its_rounding() {
    let file = File::parse(single()).expect("a file");
    assert_eq!(file.section(S::FactorValues).expect("present").element(), Element::F32);
    let [pushed, _] = static_answers(single());
    let [in_double, ..] = settled::<f64>(single(), &SceneOptions::default(), push(place(single())));
    let [in_single, ..] = settled::<f32>(single(), &SceneOptions::default(), push(place(single())));
    println!("{:.1e}, stepped in f32 {:.1e}", off(&in_double, &pushed), off(&in_single, &pushed));
    assert!(off(&in_double, &pushed) < 1e-5 && off(&in_single, &pushed) < 1e-4);
}

#[test]
fn where_a_contact_knows_its_residual_both_agree() {
    let bytes = double();
    let point = place(bytes);
    with_scene::<f64, _>(bytes, &SceneOptions::default(), |scene, state, loads| {
        push(point)(scene, loads);
        for _ in 0..20 {
            scene.step(state, loads).expect("a step");
        }
        let mut whole = vec![0.0; 3 * File::parse(bytes).expect("a file").metadata().n_nodes as usize];
        with_statics(scene, state, |statics| {
            scene.body_with(state, Field::Displacement, statics, &mut whole).expect("a body");
        });
        for &node in point.place.nodes() {
            let there = scene.node(state, node as usize, Field::Displacement).expect("a node");
            assert!(off(&whole[3 * node as usize..][..3], &there) < 1e-10);
        }
        // Nothing acts, and what has acted is forgotten after 28 β: nothing is added.
        loads.clear();
        for _ in 0..8 {
            scene.step(state, loads).expect("a step");
        }
        let mut modes = whole.clone();
        scene.body_into(state, Field::Displacement, &mut modes).expect("a body");
        with_statics(scene, state, |statics| {
            scene.body_with(state, Field::Displacement, statics, &mut whole).expect("a body");
        });
        assert!(modes == whole);
    });
}

#[test]
fn a_file_without_the_factor_says_so() {
    let bytes = built("static_fields = false");
    assert_eq!(present(&bytes), []);
    let bare = SceneOptions { residual: false, ..SceneOptions::default() };
    for (bytes, options) in [(&bytes[..], SceneOptions::default()), (double(), bare)] {
        with_scene::<f64, _>(bytes, &options, |scene, state, _| {
            assert_eq!(scene.static_field_sizes(), [0; 2]);
            let mut statics = StaticField::new(scene, &mut [], &mut []).expect("no room is wanted");
            let solved = scene.solve_static_field(state, &mut statics);
            assert!(matches!(solved, Err(OutputError::Missing { kind: S::FactorValues })));
        });
    }
}

/// The build takes the factor where its loads would miss the tolerance without, and says what it reaches.
#[test]
fn the_factor_is_there_where_the_tolerance_needs_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |name: &str, text: &str| {
        let [problem, file] =
            ["toml", "vdm"].map(|end| folder.path().join(format!("{name}.{end}")).display().to_string());
        std::fs::write(&problem, text).expect("written");
        let ran = vademecum(&["build", &problem, "-o", &file, "--json", "--quiet", "--keep-missed"]);
        (
            ran.code,
            ran.json()["certificate"]["diagonal"]["trajectory_error"].as_f64().expect("an error"),
            file,
        )
    };
    let (_, without, _) = run("without", &cube("static_fields = false"));
    let (_, with, _) = run("with", &cube("static_fields = true"));
    assert!(with < 0.5 * without, "{with:e} {without:e}");
    let between = (with * without).sqrt();
    let asked = |line: &str| format!("{}\n[tolerance]\nerror = {between:e}\n", cube(line));
    let (code, error, file) = run("open", &asked(""));
    assert_eq!((code, error), (Some(0), with));
    assert_eq!(present(&std::fs::read(&file).expect("a file")), ALL);
    let (_, refused, _) = run("refused", &asked("static_fields = false"));
    assert_eq!(refused, without);
    let [problem, file] =
        ["refused.toml", "none.vdm"].map(|name| folder.path().join(name).display().to_string());
    vademecum(&["build", &problem, "-o", &file]).fails(6, &["tolerance"]);
    let (_, _, loose) = run("loose", &format!("{}\n[tolerance]\nerror = {:e}\n", cube(""), 2.0 * without));
    assert_eq!(present(&std::fs::read(&loose).expect("a file")), []);

    // A verification sees it.
    let scenario = folder.path().join("s.toml");
    let text =
        "duration = 0.2\n[[contact]]\npoint = [0.08, 0.03, 0.1]\nforce = [3.0, 10.0, -20.0]\nramp = 0.01\n";
    std::fs::write(&scenario, text).expect("written");
    let total = |name: &str| {
        let at = |end: &str| folder.path().join(format!("{name}.{end}")).display().to_string();
        let scenario = scenario.display().to_string();
        let ran =
            vademecum(&["verify", &at("vdm"), "--problem", &at("toml"), "--scenario", &scenario, "--json"]);
        ran.json()["total_error"].as_f64().expect("an error")
    };
    let [with, without] = ["with", "without"].map(total);
    println!("total error {with:.1e}, without the factor {without:.1e}");
    assert!(with < 0.25 * without);
}

#[test]
fn pack_and_strip_keep_it_and_check_knows_it() {
    for bytes in [double(), single()] {
        check(bytes).expect("sound");
        assert_eq!(present(bytes), ALL);
        assert_eq!(needed_minor(&File::parse(bytes).expect("a file")), 4);
        let packed = pack(bytes, 3).expect("packed");
        check(&packed).expect("sound");
        assert!(unpack(&packed, 1 << 30).expect("unpacked") == bytes);
        let surface = strip(bytes, Keep::Surface).expect("stripped");
        check(&surface).expect("sound");
        assert_eq!(present(&surface), ALL);
        let probes = strip(bytes, Keep::Probes).expect("stripped");
        check(&probes).expect("sound");
        assert_eq!(present(&probes), []);
    }
}

/// The file with one section replaced, its shape too.
fn changed(kind: S, edit: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let section = File::parse(double()).expect("a file").section(kind).expect("present");
    let mut stored = section.stored().to_vec();
    edit(&mut stored);
    let width = section.shape()[1] * section.element().size();
    rewritten(
        double(),
        |_| (),
        |section| {
            if section.kind == kind {
                section.shape[0] = stored.len() as u64 / width;
                section.decoded_length = stored.len() as u64;
                section.stored = &stored;
            }
        },
        &[],
    )
}

fn integer(at: usize, value: u32) -> impl FnOnce(&mut Vec<u8>) {
    move |bytes| bytes[4 * at..][..4].copy_from_slice(&value.to_le_bytes())
}

fn real(at: usize, change: impl Fn(f64) -> f64) -> impl FnOnce(&mut Vec<u8>) {
    move |bytes| {
        let number: &mut [u8; 8] = (&mut bytes[8 * at..][..8]).try_into().expect("eight bytes");
        *number = change(f64::from_le_bytes(*number)).to_le_bytes();
    }
}

/// Each contradiction is found by `check`, and the evaluator gives an error or numbers, never a panic.
#[test]
fn a_factor_that_contradicts_itself_is_found_and_harmless() {
    let count =
        |kind: S| File::parse(double()).expect("a file").section(kind).expect("present").shape()[0] as usize;
    let scaled = |bytes: &mut Vec<u8>| {
        for number in bytes.as_chunks_mut::<8>().0 {
            *number = (1.1 * f64::from_le_bytes(*number)).to_le_bytes();
        }
    };
    let unsound = [
        ("a column for no displacement", S::FactorOrder, changed(S::FactorOrder, integer(3, u32::MAX))),
        ("two columns for one", S::FactorOrder, changed(S::FactorOrder, |x| x.copy_within(0..4, 8))),
        ("a column less", S::FactorRows, changed(S::FactorOrder, |x| x.truncate(x.len() - 4))),
        ("an empty group", S::FactorGroups, changed(S::FactorGroups, integer(0, 0))),
        ("a huge group", S::FactorGroups, changed(S::FactorGroups, integer(0, u32::MAX))),
        ("rows without end", S::FactorGroups, changed(S::FactorGroups, integer(1, u32::MAX))),
        ("a row above its group", S::FactorRows, changed(S::FactorRows, integer(0, 0))),
        ("a row beyond", S::FactorRows, changed(S::FactorRows, integer(count(S::FactorRows) - 1, 1 << 31))),
        ("a number less", S::FactorGroups, changed(S::FactorValues, |x| x.truncate(x.len() - 8))),
        ("no diagonal", S::FactorValues, changed(S::FactorValues, real(0, |_| 0.0))),
        ("a negative diagonal", S::FactorValues, changed(S::FactorValues, real(0, |x| -x))),
        ("another stiffness", S::FactorValues, changed(S::FactorValues, scaled)),
    ];
    for (what, kind, bytes) in &unsound {
        match check(bytes) {
            Err(RewriteError::Unsound { kind: found, .. }) => assert_eq!(found, *kind, "{what}"),
            Err(RewriteError::Format(FormatError::Index { kind: found, .. })) => {
                assert_eq!(found, kind.number(), "{what}");
            }
            other => panic!("{what}: {other:?}"),
        }
        let point = place(bytes);
        with_scene::<f64, _>(bytes, &SceneOptions::default(), |scene, state, loads| {
            push(point)(scene, loads);
            loads.add_pattern(scene, 0, 1.0).expect("a pattern");
            scene.step(state, loads).expect("a step");
            let [answer, rest] = scene.static_field_sizes();
            let (mut answer, mut rest) = (vec![0.0; answer], vec![0.0; rest]);
            let mut statics = StaticField::new(scene, &mut answer, &mut rest).expect("room");
            let solved = scene.solve_static_field(state, &mut statics);
            let mut whole = vec![0.0; 3 * File::parse(bytes).expect("a file").metadata().n_nodes as usize];
            scene.body_with(state, Field::Displacement, &mut statics, &mut whole).expect("a body");
            if solved.is_err() {
                let mut modes = whole.clone();
                scene.body_into(state, Field::Displacement, &mut modes).expect("a body");
                // What could not be solved for is left out; contacts know theirs at loadable nodes alone.
                let inside = 3 * File::parse(bytes).expect("a file").metadata().n_load_nodes as usize;
                assert!(inside < whole.len() && whole[inside..] == modes[inside..], "{what}");
            }
        });
    }
    // Sections alone.
    for kind in ALL {
        let without = rewritten(
            double(),
            |_| (),
            |section| {
                if section.kind == kind {
                    section.kind = S::Losses;
                    section.element = Element::F64;
                    section.shape = [0, 4, 1];
                    section.decoded_length = 0;
                    section.stored = &[];
                }
            },
            &[],
        );
        assert_eq!(check(&without).is_err(), kind != S::PatternAnswer, "{kind}");
    }
}
