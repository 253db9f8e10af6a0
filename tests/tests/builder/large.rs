//! Files of large displacements, from the problem to the bytes.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildError, BuildOptions, Built, build};
use vademecum_build::prepared::prepare;
use vademecum_build::progress::{Listener, Silent, Stopwatch, is_cancelled};
use vademecum_build::store::Store;
use vademecum_eval::{Field, SceneOptions, Simulation};
use vademecum_format::File;
use vademecum_lab::{LargeBenchOptions, LargeMethod, LargeRow, Precision, compare_large_methods};
use vademecum_study::player::PlayOptions;
use vademecum_study::scenario::Scenario;
use vademecum_study::verify::verify_large;
use vademecum_study::{FileError, StudyError};
use vademecum_tests::program::repository;

/// The block of the page that asks for large displacements.
fn asked() -> String {
    let page =
        std::fs::read_to_string(repository().join("docs/how-to/large-displacements.md")).expect("the page");
    let block = page.split("```toml").nth(1).and_then(|rest| rest.split("```").next());
    block.expect("a block of TOML").to_string()
}

fn beam() -> Problem {
    let asked = asked();
    let (model, large) = asked.split_once("[large]").expect("a table of options");
    let text = format!(
        "{model}\n[mesh]\nblock = {{ lengths = [1.0, 0.08, 0.1], divisions = [12, 2, 2], order = \"linear\" }}\n\
         [[material]]\nyoung = 1e7\npoisson = 0.3\ndensity = 1000.0\n[[support]]\non = {{ group = \"x_min\" }}\n\
         [load]\n[[load.pattern]]\nname = \"gravity\"\nacceleration = [0.0, 0.0, -9.81]\n\
         [damping]\nalpha = 0.2\nbeta = 1e-4\n[basis]\nmodes = 24\n[tolerance]\nerror = 0.2\n\
         [[output.probe]]\nname = \"tip\"\npoint = [1.0, 0.04, 0.1]\ndirection = [0, 0, 1]\n[large]{large}"
    );
    Problem::parse(&text, "beam.toml", repository()).expect("a problem")
}

#[test]
fn a_beam_that_bends_far_is_followed_where_a_linear_one_is_lost() {
    let problem = beam();
    let built = build(&problem, &BuildOptions::default(), &Silent).expect("a build").either();
    let large = built.report.large.as_ref().expect("measured pushes");
    assert_eq!((large.runs.len(), large.rows), (2, 48));
    // Two relaxed maps for each of three numbers of modes, and three regressions on at least one of them.
    assert!([9, 12, 15].contains(&large.candidates.len()), "{:?}", large.candidates);
    assert!(large.strain_map.contains("fitted"), "{:?}", large.candidates);
    assert!(large.runs[0].pulse && !large.runs[1].pulse);
    for run in &large.runs {
        assert!(run.floor <= run.error && run.floor < 0.02, "{run:?}");
        assert!(run.error < 0.33 * run.linear_error, "{run:?}");
        assert!(run.linear_error > 0.05 && run.displacement > 0.1, "{run:?}");
        assert!(run.energy_identity < 1e-10, "{run:?}");
        // The parts make up the error beside the floor: at most their sum, at least their difference.
        let [beside, closure, time] =
            [(run.error.powi(2) - run.floor.powi(2)).sqrt(), run.closure_error, run.time_error];
        assert!(closure > 0.0 && time > 0.0, "{run:?}");
        assert!(beside <= 1.0001 * (closure + time) && beside >= 0.9999 * (closure - time).abs(), "{run:?}");
    }
    let certificate = built.report.certificate.diagonal.as_ref().expect("figures");
    let worst = large.runs.iter().map(|run| run.error).fold(0.0, f64::max);
    assert_eq!(certificate.trajectory_error, worst);

    // Under three times its weight the tip hangs, and its way down is shorter than a linear body's.
    let mut way = [0.0; 2];
    let file: &'static [u8] = Box::leak(built.bytes.clone().into_boxed_slice());
    let linear =
        SceneOptions { structure: vademecum_eval::StructureChoice::Exact, ..SceneOptions::default() };
    for (way, options) in way.iter_mut().zip([SceneOptions::default(), linear]) {
        let mut body = Simulation::<f64>::new(file, &options).expect("a body");
        let (mut largest, mut time) = (0.0_f64, 0.0);
        while time < 2.0 {
            body.push_pattern(0, 3.0).expect("gravity");
            body.step(1).expect("a step");
            largest = largest.min(body.probe(0, Field::Displacement).expect("the tip"));
            time += File::parse(file).expect("a file").metadata().time_step;
        }
        *way = largest;
    }
    assert!(way[1] < -0.8 && way[0] > -0.95 * way[1].abs() && way[0] < -0.4, "{way:?}");

    let file = File::parse(&built.bytes).expect("a file");
    verified(&problem, &file);
}

/// A scenario beside the march at large displacements; and beside itself, in other units of time.
fn verified(problem: &Problem, file: &File<'_>) {
    let prepared = prepare(problem, &mut Stopwatch::new(&Silent), &Silent).expect("a model");
    let verify = |text: &str, options: &PlayOptions| {
        let scenario = Scenario::parse(text, "push.toml").expect("a scenario");
        verify_large(file, options, problem, &prepared, &scenario, &Silent)
    };
    let push = |start: f64, end: f64, duration: f64, force: f64| {
        format!(
            "duration = {duration:?}\n[[contact]]\npoint = [0.9, 0.04, 0.1]\nforce = [0.0, 0.0, {force:?}]\n\
             start = {start:?}\nend = {end:?}\n"
        )
    };
    let options = PlayOptions::default();
    let found = verify(&push(0.1, 0.4, 0.6, 60.0), &options).expect("figures");
    let figures = &found.figures;
    assert!(figures.displacement > 0.1, "{figures:?}");
    assert!(figures.projection_floor < figures.trajectory_error, "{figures:?}");
    // What the reference is known to is seen by this, and a push that comes half a step early is not.
    assert!(figures.trajectory_error < 0.02 && figures.truth_error < 0.01, "{figures:?}");
    assert!(figures.linear_error > 3.0 * figures.trajectory_error, "{figures:?}");
    assert!(figures.contact_error.is_some_and(|error| error < 0.02), "{figures:?}");
    assert!(figures.energy_identity < 1e-10, "{figures:?}");
    let drifts = figures.energy_drift.zip(figures.energy_drift_full_order);
    assert!(drifts.is_some_and(|(own, full)| (own - full).abs() < 0.02), "{figures:?}");

    // Four times as stiff and as strong, twice as fast.
    let mut fast = options;
    let metadata = file.metadata();
    (fast.scene.stiffness, fast.scene.time_step) = (4.0, Some(0.5 * metadata.time_step));
    (fast.scene.alpha, fast.scene.beta) = (Some(2.0 * metadata.alpha), Some(0.5 * metadata.beta));
    let again = verify(&push(0.05, 0.2, 0.3, 240.0), &fast).expect("figures");
    for (one, other, factor) in [
        (&found.probe_series[0], &again.probe_series[0], 1.0),
        (&found.energy_series[0], &again.energy_series[0], 4.0),
    ] {
        let largest = one.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        assert_eq!(one.len(), other.len());
        let close = one.iter().zip(other).all(|(a, b)| (factor * a - b).abs() < 1e-6 * factor * largest);
        assert!(close, "a motion in other units of time");
    }

    let thrown = push(0.1, 0.4, 0.6, 60.0) + "[free]\nvelocity = [1.0, 0.0, 0.0]\n";
    assert!(matches!(verify(&thrown, &options), Err(StudyError::File(FileError::NotFree))));
    let many = push(0.1, 0.4, 1e7, 60.0);
    assert!(matches!(verify(&many, &options), Err(StudyError::Long { .. })));
}

/// What the rows of a comparison say of each other, whatever the machine.
#[test]
fn a_comparison_tells_the_error_of_each_method_by_its_parts() {
    let mut problem = beam();
    problem.basis.modes = Some(12);
    // Two first periods, the push and its release among them.
    let options = LargeBenchOptions { steps: Some(132), ..LargeBenchOptions::default() };
    let table = compare_large_methods(&problem, None, &options, &Silent).expect("a table");
    let rows = |name: LargeMethod| table.methods.iter().filter(move |row| row.name == name);
    let [double, single] = [Precision::Double, Precision::Single].map(LargeMethod::File);
    let count = |name| rows(name).map(|row| row.substeps).collect::<Vec<_>>();
    assert_eq!([count(double), count(single)], [[1, 2, 4, 8], [1, 2, 4, 8]]);
    assert_eq!(count(LargeMethod::FullOrder), [1, 2, 4]);
    assert_eq!(count(LargeMethod::Galerkin), [1, 2]);
    assert_eq!(count(LargeMethod::Linear), [1]);
    assert_eq!(table.methods.len(), 14);

    // The push moves the body about as far as was asked for, and the law bears it.
    assert!((0.3..0.9).contains(&table.displacement) && table.least_stretch > 0.6, "{}", table.displacement);
    let total = |row: &LargeRow| row.errors.error_total;
    let [of_linear] = rows(LargeMethod::Linear).map(total).collect::<Vec<_>>()[..] else { panic!() };
    for row in &table.methods {
        let errors = &row.errors;
        let parts = [errors.error_basis, errors.error_closure, errors.error_time, errors.error_rounding];
        let sum: f64 = parts.iter().flatten().sum();
        let told = errors.error_closure.is_some() || errors.error_time.is_some();
        assert!(!told || errors.error_total <= sum * (1.0 + 1e-9), "the triangle inequality: {errors:?}");
        // Of everything that moves in the basis; the projection is the best of it.
        assert!(errors.error_basis.is_none_or(|floor| floor <= errors.error_total), "{errors:?}");
        assert_eq!(errors.error_basis.is_some(), row.modes.is_some());
        assert_eq!(errors.error_rounding.is_some(), row.name == single);
        assert!(row.step_ns_p50 > 0.0 && row.step_ns_p50 <= row.step_ns_p99, "{}", row.name);
        assert!(row.offline_seconds > 0.0);
    }

    // Of second order in the sub-steps, down to what basis and strain map leave.
    let file: Vec<_> = rows(double).map(|row| row.errors).collect();
    for pair in file.windows(2) {
        let [long, short] = [0, 1].map(|k| pair[k].error_time.expect("a part"));
        assert!((2.5..6.0).contains(&(long / short)), "{long} {short}");
    }
    let finest = file[3];
    let limit = finest.error_basis.expect("a part").hypot(finest.error_closure.expect("a part"));
    assert!((finest.error_total - limit).abs() <= finest.error_time.expect("a part"), "{finest:?}");
    for (single, double) in rows(single).zip(rows(double)) {
        let rounding = single.errors.error_rounding.expect("a part");
        assert!(rounding > 0.0 && rounding < 1e-3, "{rounding}");
        assert!((total(single) - total(double)).abs() <= rounding);
    }
    assert!(of_linear > 2.0 * finest.error_total && of_linear > 0.05, "{of_linear} {finest:?}");

    // Bathe's method is of second order, too; the row of four steps is the march beside a reference of eight.
    let full: Vec<f64> = rows(LargeMethod::FullOrder).map(total).collect();
    assert!(full.windows(2).all(|pair| pair[0] > 2.0 * pair[1]), "{full:?}");
    if table.truth_parts == 8 {
        assert!((full[2] / table.truth_error - 1.0).abs() < 1e-9, "{full:?} {}", table.truth_error);
    } else {
        assert!(full[2] > table.truth_error);
    }
    // All elements have the strain map of the basis without its rows: in time as good as the full order.
    for (galerkin, full) in rows(LargeMethod::Galerkin).map(total).zip(&full) {
        assert!(galerkin.is_finite() && galerkin < of_linear && galerkin > 0.1 * full, "{galerkin} {full}");
    }
    let compared = rows(LargeMethod::FullOrder).next_back().expect("a row");
    assert_eq!(compared.times_full_order, 1.0);
    assert!(rows(single).all(|row| row.times_full_order > 10.0));

    let thrown = Scenario::parse("duration = 1.0\n[free]\nvelocity = [1.0, 0.0, 0.0]\n", "thrown.toml");
    let thrown = thrown.expect("a scenario");
    let refused = compare_large_methods(&problem, Some(&thrown), &options, &Silent);
    assert!(matches!(refused.err(), Some(StudyError::File(FileError::NotFree))));
}

#[test]
fn a_stopped_build_goes_on_and_gives_the_same_bytes() {
    let mut problem = beam();
    problem.basis.modes = Some(6);
    let folder = tempfile::tempdir().expect("a folder");
    let store = Store::new(folder.path(), false);
    let options = BuildOptions { store: Some(&store), ..BuildOptions::default() };
    let plain = build(&problem, &BuildOptions::default(), &Silent).expect("a build").either();
    refused_for_its_memory(&plain);
    // Stopped in the choice of the strain map, when states and the pushes that choose are kept.
    let stopped = StopsAt::new("choice of the strain map");
    assert!(build(&problem, &options, &stopped).is_err_and(|error| is_cancelled(&error)));
    let heard = StopsAt::new("never");
    let built = build(&problem, &options, &heard).expect("a build").either();
    assert!((1..=3).all(|modes| heard.reused(&format!("states-{modes}-1"))));
    assert!((0..4).all(|push| heard.reused(&format!("push-c4005e01-{push}"))));
    assert!(!heard.reused("push-ce471f02-0"));
    assert!(built.bytes == plain.bytes);
    let heard = StopsAt::new("never");
    let again = build(&problem, &options, &heard).expect("a build").either();
    assert!(heard.reused("push-ce471f02-0") && heard.reused("push-ce471f02-1-refined"));
    assert!(again.bytes == plain.bytes);
    let seconds = |built: &Built| built.report.large.as_ref().expect("figures").full_order_seconds_per_step;
    assert_eq!(seconds(&again), seconds(&built));
}

/// Stops a build at a stage, and hears its notes.
struct StopsAt {
    stage: &'static str,
    stopped: AtomicBool,
    notes: Mutex<Vec<String>>,
}

impl StopsAt {
    fn new(stage: &'static str) -> Self {
        Self { stage, stopped: AtomicBool::new(false), notes: Mutex::default() }
    }

    fn reused(&self, stage: &str) -> bool {
        self.notes.lock().expect("no panic").contains(&format!("{stage}: reused"))
    }
}

impl Listener for StopsAt {
    fn stage(&self, name: &str) {
        if name == self.stage {
            self.stopped.store(true, Ordering::Relaxed);
        }
    }

    fn advance(&self, _: usize, _: usize) {}

    fn note(&self, text: &str) {
        self.notes.lock().expect("no panic").push(text.into());
    }

    fn cancelled(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }
}

/// A build of more coordinates wants more memory than this one, and is refused before it takes it.
fn refused_for_its_memory(small: &Built) {
    let told = small.report.plan.memory_bytes;
    let options = BuildOptions { memory: Some((1.2 * told) as u64), ..BuildOptions::default() };
    let Err(BuildError::Memory(refused)) = build(&beam(), &options, &Silent) else { panic!("not refused") };
    assert!(refused.to_string().contains("`large.states`"), "{refused}");
}
