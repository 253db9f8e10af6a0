//! The chapter's representation end to end: what it reaches with all repairs and without any, in builder and
//! evaluator alike, and that nothing is clamped or extrapolated.

use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, Outcome};
use vademecum_build::progress::Silent;
use vademecum_chapter::{ChapterBindError, ChapterLoadError, ChapterScene, ChapterStepError, build};
use vademecum_eval::{
    BindError, Contact, LoadError, OutputError, Place, Scene, SceneOptions, Status, StepError,
    StructureChoice,
};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{Chapter, ChapterRole, Element, File, FormatError, SectionKind};
use vademecum_tests::canonical::{LOAD, REACH, Terms, file};
use vademecum_tests::program::{repository, vademecum};
use vademecum_tests::stage::{with_chapter, with_scene};
use vademecum_tests::synthetic::{Body, Layout, bathe};

const LAYOUT: Layout = Layout { rows: 3, load_rows: 2, columns: 3, n_interior: 2, r: 3 };
const STEP: StepParameters =
    StepParameters { time_step: 1e-3, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 };
const POSITIONS: [u32; 3] = [0, 2, 5];
const REPAIRS: &str = r#"repairs = ["scaled-coordinates", "separate-blocks", "one-axis-start", "updates"]"#;

fn body() -> Body {
    Body::closed(LAYOUT, 5)
}

fn push(node: u32, z: f64) -> Contact {
    Contact::new(Place::triangle([node; 3], [1.0, 0.0, 0.0]), [0.0, 0.0, z])
}

/// Loads a scene of either kind with a push, marches it 300 steps, clears the loads on the way, and gives `ζ`
/// after each step.
macro_rules! march {
    ($scene:ident, $state:ident, $loads:ident) => {{
        $loads.add_contact($scene, &push(2, 3.0)).expect("a contact");
        $scene.set($state, &[0.0; 3], &[0.0; 3], $loads).expect("a start");
        let mut zeta = vec![];
        for step in 0..300 {
            if step == 40 {
                $loads.clear();
            }
            $scene.step($state, $loads).expect("a step");
            zeta.extend_from_slice($state.zeta());
        }
        zeta
    }};
}

fn march_chapter(bytes: &[u8]) -> Vec<f64> {
    with_chapter(bytes, |scene, state, loads| march!(scene, state, loads))
}

fn march_diagonal(bytes: &[u8]) -> Vec<f64> {
    let options = SceneOptions { structure: StructureChoice::Diagonal, ..SceneOptions::default() };
    with_scene::<f64, _>(bytes, &options, |scene, state, loads| march!(scene, state, loads))
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let gap: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    (gap / b.iter().map(|b| b * b).sum::<f64>()).sqrt()
}

#[test]
fn exact_terms_step_as_the_diagonal_structure_does() {
    let reference = march_diagonal(&body().file(&bathe(), &STEP, Element::F64));
    for terms in [Terms::Apart, Terms::Together] {
        let bytes = file(&body(), &bathe(), &STEP, &POSITIONS, terms);
        let double = distance(&march_chapter(&bytes), &reference);
        // An interpolation rounds to ε times the axis' reach, 2e-17; the acceleration amplifies a stage's
        // error by 1/(ωΔt)², 1e3 for the lowest mode; over 300 steps, against a ζ of 1e-3.
        assert!(double < 1e-8, "{terms:?}: {double:e}");
    }
}

#[test]
fn a_coordinate_off_its_axis_is_named_and_the_state_is_kept() {
    let bytes = file(&body(), &bathe(), &STEP, &POSITIONS, Terms::Apart);
    with_chapter(&bytes, |scene, state, loads| {
        let mut saved = vec![0.0; 9];
        saved[3 + 1] = 1.5 * REACH;
        state.restore(&saved).expect("nine numbers");
        let outside = scene.step(state, loads).expect_err("off the axis");
        let expected = ChapterStepError::OutsideAxis {
            stage: 0,
            role: ChapterRole::State { family: 1, mode: 1 },
            value: 1.5 * REACH,
            lower: -REACH,
            upper: REACH,
        };
        assert_eq!(outside, expected);
        assert!(outside.to_string().contains("zeta_dot of mode 2"), "{outside}");
        let mut after = vec![0.0; 9];
        state.save_into(&mut after).expect("nine numbers");
        assert_eq!(after, saved);
    });
}

#[test]
fn loads_the_axes_do_not_know_are_refused_by_name() {
    let apart = file(&body(), &bathe(), &STEP, &POSITIONS, Terms::Apart);
    with_chapter(&apart, |scene, _, loads| {
        let sideways = Contact { force: [1.0, 0.0, 1.0], ..push(0, 1.0) };
        assert_eq!(loads.add_contact(scene, &sideways), Err(ChapterLoadError::OtherDirection));
        assert_eq!(loads.add_contact(scene, &push(1, 1.0)), Err(ChapterLoadError::NotAPosition { node: 1 }));
        for force in [2.0 * LOAD, -1.0] {
            let error = loads.add_contact(scene, &push(0, force)).expect_err("off the axis");
            assert!(
                matches!(error, ChapterLoadError::OutsideAxis { role: ChapterRole::Magnitude, .. }),
                "{error}"
            );
        }
        assert!(loads.is_empty());
        // Apart, contacts add up, and a contact between nodes is shared.
        let shared = Contact::new(Place::triangle([0, 2, 5], [0.2, 0.3, 0.5]), [0.0, 0.0, 2.0]);
        loads.add_contact(scene, &shared).expect("all nodes are positions");
        loads.add_contact(scene, &push(0, 1.0)).expect("another one");
    });
    let together = file(&body(), &bathe(), &STEP, &POSITIONS, Terms::Together);
    with_chapter(&together, |scene, _, loads| {
        let shared = Contact::new(Place::triangle([0, 2, 5], [0.2, 0.3, 0.5]), [0.0, 0.0, 2.0]);
        assert_eq!(loads.add_contact(scene, &shared), Err(ChapterLoadError::OneContact));
        loads.add_contact(scene, &push(0, 1.0)).expect("the one");
        assert_eq!(loads.add_contact(scene, &push(2, 1.0)), Err(ChapterLoadError::OneContact));
    });
}

#[test]
fn contacts_apart_add_up() {
    let bytes = file(&body(), &bathe(), &STEP, &POSITIONS, Terms::Apart);
    let ran = |contacts: &[Contact]| {
        with_chapter(&bytes, |scene, state, loads| {
            contacts.iter().for_each(|c| loads.add_contact(scene, c).expect("a contact"));
            assert_eq!(scene.step(state, loads), Ok(Status::Moving));
            state.zeta().to_vec()
        })
    };
    let (one, other) = (ran(&[push(0, 1.0)]), ran(&[push(5, 2.0)]));
    let both = ran(&[push(0, 1.0), push(5, 2.0)]);
    for ((both, one), other) in both.iter().zip(one).zip(other) {
        // Every interpolation rounds to ε times the axis' reach; there are nine and three in each stage.
        assert!((both - (one + other)).abs() < 24.0 * f64::EPSILON * REACH);
    }
}

#[test]
fn other_options_than_the_files_are_refused() {
    let bytes = file(&body(), &bathe(), &STEP, &POSITIONS, Terms::Apart);
    let opened = File::parse(&bytes).expect("a file");
    assert_eq!(opened.minor(), 1);
    let mut regions = vademecum_eval::RegionScales::ONE;
    regions.set_density(0, 0.5).expect("a region");
    for options in [
        SceneOptions { time_step: Some(2e-3), ..SceneOptions::default() },
        SceneOptions { stiffness: 2.0, ..SceneOptions::default() },
        SceneOptions { regions, ..SceneOptions::default() },
        SceneOptions { terms: Some(1), ..SceneOptions::default() },
        SceneOptions { structure: StructureChoice::Block, ..SceneOptions::default() },
    ] {
        let bound = ChapterScene::bind(&opened, &options);
        assert_eq!(bound.err(), Some(ChapterBindError::Fixed), "{options:?}");
    }
    let same = SceneOptions { time_step: Some(1e-3), rest_below: 1e-9, ..SceneOptions::default() };
    assert!(ChapterScene::bind(&opened, &same).is_ok());
}

#[test]
fn each_scene_refuses_the_files_of_the_other_by_name() {
    let bytes = file(&body(), &bathe(), &STEP, &POSITIONS, Terms::Apart);
    let opened = File::parse(&bytes).expect("a file");
    for structure in [StructureChoice::Auto, StructureChoice::Diagonal, StructureChoice::Block] {
        let options = SceneOptions { structure, ..SceneOptions::default() };
        let error = Scene::<f64>::sizes(&opened, &options).expect_err("no structure of its own");
        assert_eq!(error, BindError::OnlyChapter);
        for way in ["vademecum run", "vademecum-chapter"] {
            assert!(error.to_string().contains(way), "{error}");
        }
        let bound = Scene::<f64>::bind(&opened, &options, &mut [], &mut []);
        assert_eq!(bound.err(), Some(BindError::OnlyChapter));
    }
    let ordinary = body().file(&bathe(), &STEP, Element::F64);
    let opened = File::parse(&ordinary).expect("a file");
    let bound = ChapterScene::bind(&opened, &SceneOptions::default());
    assert_eq!(bound.err(), Some(ChapterBindError::NoChapter));
}

#[test]
fn states_and_loads_of_another_scene_are_refused() {
    let apart = file(&body(), &bathe(), &STEP, &POSITIONS, Terms::Apart);
    let slower = StepParameters { time_step: 2e-3, ..STEP };
    let slower = file(&body(), &bathe(), &slower, &POSITIONS, Terms::Apart);
    with_chapter(&apart, |scene, state, loads| {
        with_chapter(&slower, |other, other_state, other_loads| {
            let mismatch = StepError::Mismatch;
            assert_eq!(scene.step(other_state, loads), Err(mismatch.into()));
            assert_eq!(scene.step(state, other_loads), Err(mismatch.into()));
            assert_eq!(other.set(state, &[0.0; 3], &[0.0; 3], other_loads), Err(mismatch));
            assert_eq!(loads.add_contact(other, &push(0, 1.0)), Err(LoadError::Mismatch.into()));
            assert_eq!(other.energy(state), Err(OutputError::Mismatch));
        });
    });
}

#[test]
fn the_older_word_is_taken_for_the_same() {
    let [older, newer] = ["canonical", "chapter"].map(|word| {
        let text = short_beam("").text.replace("= \"canonical\"", &format!("= \"{word}\""));
        assert!(text.starts_with(&format!("representation = \"{word}\"\n")));
        Problem::parse(&text, "short-beam.toml", PathBuf::new()).expect("a problem")
    });
    assert!(newer.chapter().is_some());
    assert!(older.chapter().is_some());
}

/// The refusal of the canonical file after numbers of a section are changed (its own checksum is not looked
/// at on opening).
fn refusal(kind: SectionKind, edit: impl FnOnce(&mut [u8])) -> FormatError {
    let mut bytes = file(&body(), &bathe(), &STEP, &POSITIONS, Terms::Apart);
    let place = {
        let opened = File::parse(&bytes).expect("a file");
        let stored = opened.section(kind).expect("present").stored();
        let start = stored.as_ptr() as usize - bytes.as_ptr() as usize;
        start..start + stored.len()
    };
    edit(&mut bytes[place]);
    File::parse(&bytes).map(|_| ()).expect_err("refused")
}

#[test]
fn refusals_32_to_35_hostile_tables() {
    use FormatError as E;
    use SectionKind as S;
    let u32_at = |place: usize, value: u32| {
        move |bytes: &mut [u8]| bytes[4 * place..][..4].copy_from_slice(&value.to_le_bytes())
    };
    let f64_at = |place: usize, value: f64| {
        move |bytes: &mut [u8]| bytes[8 * place..][..8].copy_from_slice(&value.to_le_bytes())
    };
    // 32: a stage that is none, out of order, no axes, more axes than there are, no terms, a stage without
    // load.
    for (place, value) in [(0, 7), (0, 1), (1, 0), (1, u32::MAX), (2, 0), (2, u32::MAX), (3, 1)] {
        let error = refusal(S::CanonicalParts, u32_at(place, value));
        assert!(
            matches!(error, E::CanonicalPart { .. } | E::CanonicalAxis { .. }),
            "{place} {value}: {error}"
        );
    }
    // 33: role, mode, range, points, factor.
    for (place, value) in [
        (0, 99.0),
        (0, f64::NAN),
        (0, 4.0), // a later stage
        (1, 3.0),
        (1, 1.0), // the second axis' mode
        (1, 0.5),
        (2, 2.0 * REACH),
        (2, f64::NAN),
        (3, f64::INFINITY),
        (4, 1.0),
        (4, 1e300),
        (5, 0.0),
        (5, f64::NAN),
    ] {
        let error = refusal(S::CanonicalAxes, f64_at(place, value));
        assert!(matches!(error, E::CanonicalAxis { axis: 0 | 1 }), "{place} {value}: {error}");
    }
    // 34: more points or terms than there are numbers.
    assert!(matches!(refusal(S::CanonicalAxes, f64_at(4, 1000.0)), E::CanonicalLength { kind: 25, .. }));
    assert!(matches!(refusal(S::CanonicalParts, u32_at(2, 60_000)), E::CanonicalLength { kind: 25, .. }));
    // 35: no loadable node; a direction that is not finite.
    assert_eq!(refusal(S::CanonicalPositions, u32_at(1, 6)), E::CanonicalLoad { place: 1 });
    assert_eq!(refusal(S::CanonicalDirection, f64_at(2, f64::NAN)), E::CanonicalLoad { place: 3 });
}

#[test]
fn any_byte_of_the_tables_may_be_wrong_without_a_panic() {
    let whole = file(&body(), &bathe(), &STEP, &POSITIONS, Terms::Apart);
    let tables = {
        let opened = File::parse(&whole).expect("a file");
        let origin = whole.as_ptr() as usize;
        let range = |kind| {
            let stored = opened.section(kind).expect("present").stored();
            let start = stored.as_ptr() as usize - origin;
            start..start + stored.len()
        };
        [SectionKind::CanonicalParts, SectionKind::CanonicalAxes, SectionKind::CanonicalPositions].map(range)
    };
    for at in tables.into_iter().flatten() {
        for flip in [1u8, 0x80] {
            let mut bytes = whole.clone();
            bytes[at] ^= flip;
            if let Ok(opened) = File::parse(&bytes) {
                let canonical = Chapter::read(&opened).expect("what opens reads").expect("present");
                assert!(canonical.parts().count() == 4);
                with_chapter(&bytes, |scene, state, loads| {
                    let _ = loads.add_contact(scene, &push(0, 1.0));
                    let _ = scene.step(state, loads);
                });
            }
        }
    }
}

/// The short beam with the canonical representation and these options.
fn short_beam(options: &str) -> Problem {
    let path = repository().join("fixtures/problems/short-beam.toml");
    let text = std::fs::read_to_string(path).expect("a fixture");
    let text = format!(
        "representation = \"canonical\"\n{text}\n[tolerance]\nsteps = 500\n[canonical]\npositions = \
         20\n{options}\n"
    );
    Problem::parse(&text, "short-beam.toml", PathBuf::new()).expect("a problem")
}

fn outcome(options: &str) -> Outcome {
    build(&short_beam(options), &BuildOptions::default(), &Silent).expect("a build")
}

#[test]
fn all_repairs_reach_the_floor_within_the_rank_of_the_exact_map() {
    for components in [false, true] {
        let options = format!("{REPAIRS}\ncomponents = {components}");
        let built = outcome(&options).kept().expect("it keeps its tolerance");
        let c = built.report.certificate.chapter.as_ref().expect("canonical");
        let rank = 3 * 4 + 20 * if components { 3 } else { 1 };
        for stage in &c.stages {
            assert!(stage.terms <= rank, "{stage:?}");
            assert!(
                stage.error <= 1e-6 && stage.state_error <= 1e-6 && stage.load_error <= 1e-6,
                "{stage:?}"
            );
        }
        assert!(c.left_at.is_none() && c.structure.floor_ratio <= 1.1, "{c:?}");
        assert!(c.structure.spectral_radius <= 1.0 + 1e-12 && c.structure.steps == 500.0);
    }
}

#[test]
fn the_chapters_own_misses_its_tolerance_and_says_so() {
    let Outcome::Missed(missed) = outcome("") else { panic!("greedy terms are not good enough") };
    let c = missed.report.certificate.chapter.as_ref().expect("canonical");
    assert!(c.stages.iter().all(|stage| stage.error > 1e-6 && stage.load_error > 1e-3), "{c:?}");
    assert!(c.left_at.is_some() || c.structure.floor_ratio > 2.0, "{c:?}");
    let opened = File::parse(&missed.bytes).expect("a file");
    assert!(Chapter::read(&opened).expect("sound").is_some());
}

#[test]
fn without_a_margin_the_certificate_reports_where_it_left() {
    // Ranges of weak snapshots, and a load ten times as strong as they are made for cannot be asked for; a
    // held load can.
    let problem = short_beam(&format!("{REPAIRS}\nmargin = 0.0"));
    let mut text = problem.text.replace("duration = 0.1", "duration = 0.1\nhold = 0.002");
    text = text.replace("positions = 2\n", "positions = 1\ndirections = [[0.0, 1.0, 0.0]]\n");
    let problem = Problem::parse(&text, "short-beam.toml", PathBuf::new()).expect("a problem");
    let built = build(&problem, &BuildOptions::default(), &Silent).expect("a file").either();
    let c = built.report.certificate.chapter.as_ref().expect("canonical");
    assert!(c.left_at.is_some(), "a push along z on ranges of pushes along y: {c:?}");
    assert_eq!(c.structure.steps as usize + 1, c.left_at.unwrap_or(0));
    assert!(!built.report.certificate.holds());
}

#[test]
fn the_program_builds_runs_verifies_and_describes_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("p.toml"), &short_beam(&format!("{REPAIRS}\nload = [-30.0, 30.0]")).text)
        .expect("written");
    let scenario =
        "duration = 0.2\n[[contact]]\npoint = [1.0, 0.05, 0.1]\nforce = [0.0, 0.0, -20.0]\nend = 0.02\n";
    std::fs::write(path("s.toml"), scenario).expect("written");
    let run = |arguments: &[&str]| {
        let whole: Vec<std::ffi::OsString> = arguments
            .iter()
            .map(|a| {
                if a.contains(".toml") || a.contains(".vdm") || *a == "out" || *a == "r.html" {
                    path(a).into()
                } else {
                    a.into()
                }
            })
            .collect();
        vademecum(&whole.iter().map(|a| a.as_os_str()).collect::<Vec<_>>())
    };
    let built = run(&["build", "p.toml", "-o", "c.vdm", "--json"]).json();
    assert!(built["certificate"]["canonical"]["floor_ratio"].as_f64().is_some_and(|ratio| ratio <= 1.1));
    let info = run(&["info", "c.vdm", "--json"]).json();
    assert_eq!(info["format"], "1.2");
    assert_eq!(info["structures"], serde_json::json!(["canonical"]));
    assert_eq!(info["canonical"]["axes"], serde_json::json!([14, 14]));
    let verified = run(&["verify", "c.vdm", "--problem", "p.toml", "--scenario", "s.toml", "--json"]).json();
    assert_eq!(verified["structure"], "canonical");
    assert!(verified["floor_ratio"].as_f64().is_some_and(|ratio| ratio < 1.01), "{verified}");
    assert_eq!(run(&["run", "c.vdm", "--scenario", "s.toml", "-o", "out"]).code, Some(0));
    std::fs::write(path("hard.toml"), scenario.replace("-20.0", "-40.0")).expect("written");
    run(&["run", "c.vdm", "--scenario", "hard.toml", "-o", "out"]).fails(7, &["magnitude of the load"]);
    run(&["report", "c.vdm", "-o", "r.html"]).fails(7, &["chapter's representation"]);
    // Its structure by name, another one, another step, a load pattern; and a file that has other structures
    // only.
    let played = |file: &str, more: &[&str]| run(&[&["run", file, "-o", "out"], more].concat());
    let push = ["--scenario", "s.toml"];
    let with = |more: [&'static str; 2]| [push, more].concat();
    for word in ["chapter", "canonical"] {
        assert_eq!(played("c.vdm", &with(["--structure", word])).code, Some(0), "{word}");
    }
    played("c.vdm", &with(["--structure", "block"])).fails(7, &["only the chapter's structure"]);
    played("c.vdm", &with(["--time-step", "0.002"])).fails(7, &["holds one time step"]);
    std::fs::write(path("gravity.toml"), "duration = 0.1\n[[pattern]]\nname = \"gravity\"\n")
        .expect("written");
    played("c.vdm", &["--scenario", "gravity.toml"]).fails(7, &["takes no load patterns"]);
    let golden = std::fs::read(repository().join("fixtures/golden/fixed-f64.vdm")).expect("a fixture");
    std::fs::write(path("other.vdm"), golden).expect("written");
    played("other.vdm", &with(["--structure", "canonical"]))
        .fails(7, &["does not have the chapter's structure"]);
}
