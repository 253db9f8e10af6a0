//! What `run` and `verify` do with scenarios that are too long, too large, or act on nothing, with live
//! parameters, and with files that change while they are in use.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::{Mutex, OnceLock};

use vademecum_build::progress::Listener;
use vademecum_format::scheme::StepParameters;
use vademecum_format::{Element, File};
use vademecum_study::StudyError;
use vademecum_study::player::PlayOptions;
use vademecum_study::run::{Moment, Run};
use vademecum_study::scenario::Scenario;
use vademecum_tests::program::{Ran, command, program, repository, vademecum};
use vademecum_tests::synthetic::{Body, Layout, bathe};

fn run<const N: usize>(arguments: [&dyn AsRef<std::ffi::OsStr>; N]) -> Ran {
    vademecum(&arguments.map(|a| a.as_ref().to_os_string()))
}

/// Writes a text to a file of its own.
fn text(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).expect("written");
    path
}

/// A folder with the short beam's file, built once for all tests.
fn short_beam() -> &'static (tempfile::TempDir, PathBuf) {
    static FILE: OnceLock<(tempfile::TempDir, PathBuf)> = OnceLock::new();
    FILE.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("beam.vdm");
        let problem = repository().join("fixtures/problems/short-beam.toml");
        let built = run([&"build", &problem, &"-o", &path]);
        assert_eq!(built.code, Some(0), "{}", built.stderr);
        (folder, path)
    })
}

#[derive(Default)]
struct Notes(Mutex<Vec<String>>);

impl Listener for Notes {
    fn stage(&self, _: &str) {}
    fn advance(&self, _: usize, _: usize) {}
    fn note(&self, text: &str) {
        self.0.lock().expect("one thread").push(text.into());
    }
}

/// The notes of binding a scenario to the short beam.
fn notes(scenario: &str) -> Vec<String> {
    let bytes = std::fs::read(&short_beam().1).expect("a file");
    let file = File::parse(&bytes).expect("a file");
    let scenario = Scenario::parse(scenario, "scenario.toml").expect("a scenario");
    let notes = Notes::default();
    Run::bind(&file, PlayOptions::default(), &scenario, &notes).expect("bound");
    notes.0.into_inner().expect("one thread")
}

#[test]
fn scenarios_that_are_too_long_are_refused_by_name_before_the_first_step() {
    let (_, file) = short_beam();
    let problem = repository().join("fixtures/problems/short-beam.toml");
    let folder = tempfile::tempdir().expect("a folder");
    for (duration, limit, parts) in [
        ("1e300", "--long", ["`duration`", "1e300 s", "2^53"]),
        ("1e12", "--quiet", ["`duration`", "1000000000000000 steps", "--long"]),
        ("2e6", "--quiet", ["`duration`", "2000000000 steps", "--long"]),
    ] {
        let scenario = text(folder.path(), "long.toml", &format!("duration = {duration}\n"));
        let out = folder.path().join("out");
        let parts = [&parts[..], &["long.toml"]].concat();
        run([&"run", &file, &"--scenario", &scenario, &"-o", &out, &limit]).fails(3, &parts);
        assert!(!out.exists(), "a folder for a run that is refused");
        let verify = [&"verify" as &dyn AsRef<std::ffi::OsStr>, &file, &"--problem", &problem];
        let [a, b, c, d] = verify;
        run([a, b, c, d, &"--scenario", &scenario, &limit]).fails(3, &parts);
    }
    let scenario = text(folder.path(), "fair.toml", "duration = 2e3\n");
    run([&"verify", &file, &"--problem", &problem, &"--scenario", &scenario])
        .fails(3, &["2000000 steps", "1000000", "--long"]);
}

#[test]
fn what_acts_on_nothing_is_said_in_words() {
    let contact = |rest: &str| format!("[[contact]]\nforce = [0.0, 0.0, -1.0]\n{rest}\n");
    let held = notes(&format!("duration = 0.1\n{}", contact("point = [0.0, 0.1, 0.05]")));
    assert_eq!(held.len(), 1, "{held:?}");
    assert!(held[0].contains("contact[0] moves nothing") && held[0].contains("is held"), "{held:?}");
    assert!(held[0].contains("(0.000000, 0.100000, 0.050000)"), "{held:?}");
    let late = notes(&format!("duration = 0.1\n{}", contact("point = [1.0, 0.1, 0.1]\nstart = 0.2")));
    assert!(
        late.len() == 1 && late[0].contains("starts at 0.2 s, and the scenario ends at 0.1 s"),
        "{late:?}"
    );
    let short = notes(&format!(
        "duration = 0.1\n{}",
        contact("point = [1.0, 0.1, 0.1]\nstart = 0.0101\nend = 0.0102")
    ));
    assert!(short.len() == 1 && short[0].contains("no instant"), "{short:?}");
    let pattern = |rest: &str| format!("duration = 0.1\n[[pattern]]\nname = \"gravity\"\n{rest}\n");
    let zero = notes(&pattern("amplitude = 0.0"));
    assert!(zero.len() == 1 && zero[0].contains("pattern[0] (`gravity`) moves nothing"), "{zero:?}");
    let late = notes(&pattern("start = 1.0"));
    assert!(late.len() == 1 && late[0].contains("starts at 1 s"), "{late:?}");
    let far = notes(&format!("duration = 0.1\n{}", contact("point = [1.0, 0.1, 0.6]")));
    assert!(far.len() == 1 && far[0].contains("acts 5.000e-1 away from the point given"), "{far:?}");
    let force = "duration = 0.1\n[[contact]]\npoint = [1.0, 0.1, 0.1]\nforce = [0.0, 0.0, 0.0]\n";
    let none = notes(force);
    assert!(none.len() == 1 && none[0].contains("its force is zero"), "{none:?}");
    let sound = format!("duration = 0.1\n{}", contact("point = [1.0, 0.1, 0.1]\nend = 0.05"));
    assert_eq!(notes(&sound), Vec::<String>::new());
    for note in held.iter().chain(&late).chain(&short).chain(&zero).chain(&far).chain(&none) {
        assert!(!note.contains('{') && !note.contains("Entry"), "no Rust in {note}");
    }
    let many = contact("point = [1.0, 0.1, 0.1]\nstart = 0.2").repeat(1000);
    let many = notes(&format!("duration = 0.1\n{many}"));
    assert!(many.len() == 21 && many[20].contains("980 more"), "{} notes", many.len());
}

#[test]
fn exact_steps_meet_a_touch_inside_of_a_step_and_begin_a_ramp_at_zero() {
    let file = repository().join("fixtures/golden/exact-f64.vdm");
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let probes = |contact: &str| -> Vec<Vec<f64>> {
        let place = "[[contact]]\npoint = [0.5, 0.25, 0.0]\nforce = [0.0, 0.0, 1.0]\n";
        let scenario = text(folder.path(), "s.toml", &format!("duration = 0.004\n{place}{contact}"));
        let ran = run([&"run", &file, &"--scenario", &scenario, &"-o", &out]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        assert!(!ran.stderr.contains("moves nothing"), "{}", ran.stderr);
        let table = std::fs::read_to_string(out.join("probes.csv")).expect("rows");
        let row = |line: &str| line.split(',').map(|x| x.parse().expect("a number")).collect();
        table.lines().skip(1).map(row).collect()
    };
    // The file's step is a millisecond. A touch of a tenth of one is a push of a tenth.
    let [touch, held] = [probes("start = 0.0012\nend = 0.0013\n"), probes("")];
    assert!(touch[..2].iter().all(|row| row[1..] == [0.0; 4]), "{touch:?}");
    assert!(touch[2..].iter().all(|row| row[1] > 0.0), "{touch:?}");
    // A force that is there from the start has moved nothing yet; a ramp is still zero when it begins.
    assert!(held[0][1..] == [0.0; 4] && held[1][1] > 0.0, "{held:?}");
    let ramp = probes("ramp = 0.002\n");
    assert!(ramp[0][1..] == [0.0; 4] && ramp[1][1] > 0.0, "{ramp:?}");
}

#[test]
fn a_run_prints_its_notes_and_a_build_says_where_a_probe_looks() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = "duration = 0.01\n[[contact]]\npoint = [0, 0.05, 0.05]\nforce = [0, 0, 1]\n";
    let scenario = text(folder.path(), "held.toml", scenario);
    let out = folder.path().join("out");
    let ran = std::process::Command::new(program())
        .args(["run".as_ref(), short_beam().1.as_os_str(), "--scenario".as_ref(), scenario.as_os_str()])
        .args(["-o".as_ref(), out.as_os_str()])
        .output()
        .expect("the program starts");
    let said = String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success() && said.contains("note: contact[0] moves nothing"), "{said}");

    let problem = repository().join("fixtures/problems/short-beam.toml");
    let problem = std::fs::read_to_string(problem).expect("the fixture");
    let probe = "point = [1.0, 0.1, 0.1]";
    assert!(problem.contains(probe));
    let problem = text(folder.path(), "off.toml", &problem.replace(probe, "point = [1.5, 0.1, 0.1]"));
    let built = std::process::Command::new(program())
        .args([
            "build".as_ref(),
            problem.as_os_str(),
            "-o".as_ref(),
            folder.path().join("off.vdm").as_os_str(),
        ])
        .output()
        .expect("the program starts");
    let said = String::from_utf8_lossy(&built.stderr);
    let expected = "probe `tip` looks at the nearest node, (1.000000, 0.100000, 0.100000), 5.000e-1 away";
    assert!(built.status.success() && said.contains(expected), "{said}");
}

/// A file whose motion grows without bound: one of its modes is pushed away from where it is, not back.
fn unstable() -> Vec<u8> {
    let layout = Layout { rows: 3, load_rows: 2, columns: 3, n_interior: 2, r: 3 };
    let step = StepParameters { time_step: 1e-3, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 };
    let body = Body { lambda: vec![900.0, 40_000.0, -1e5], ..Body::closed(layout, 5) };
    body.file(&bathe(), &step, Element::F64)
}

#[test]
fn a_run_ends_with_an_error_at_the_first_number_that_is_not_finite_and_keeps_the_rows_before() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("unstable.vdm");
    std::fs::write(&file, unstable()).expect("written");
    let push = "[[contact]]\npoint = [0, 0, 0]\nforce = [1, 1, 1]\n";
    let scenario = text(folder.path(), "s.toml", &format!("duration = 20.0\n{push}"));
    let out = folder.path().join("out");
    let ran = run([&"run", &file, &"--scenario", &scenario, &"-o", &out]);
    ran.fails(5, &["at t = ", "the motion is inf", "lower the forces"]);
    let table = std::fs::read_to_string(out.join("probes.csv")).expect("the rows before");
    let rows: Vec<&str> = table.lines().skip(1).collect();
    assert!(rows.len() > 10, "{} rows", rows.len());
    for row in rows {
        assert!(row.split(',').all(|x| x.parse::<f64>().expect("a number").is_finite()), "{row}");
    }
}

#[test]
fn a_file_with_numbers_that_are_not_finite_is_named_as_the_cause() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = repository().join("fixtures/hostile/NotFinite-probe-infinite.vdm");
    let scenario = text(folder.path(), "s.toml", "duration = 0.1\n");
    let out = folder.path().join("out");
    let ran = run([&"run", &file, &"--scenario", &scenario, &"-o", &out]);
    ran.fails(5, &["at t = 0e0 s (step 0)", "the value of probe `", "verify FILE --file-only"]);
    let bytes = std::fs::read(&file).expect("a file");
    let file = File::parse(&bytes).expect("a file");
    let scenario = Scenario::read(&scenario).expect("a scenario");
    let run = Run::bind(&file, PlayOptions::default(), &scenario, &Notes::default()).expect("bound");
    let mut shown = 0;
    let ended = run.play(&Notes::default(), |_: &Moment<'_>| -> Result<(), StudyError> {
        shown += 1;
        Ok(())
    });
    assert!(matches!(ended, Err(StudyError::NotFinite { step: 0, .. })) && shown == 0, "{shown} instants");
}

/// Columns of a table, by their names.
fn columns(path: &Path) -> std::collections::BTreeMap<String, Vec<f64>> {
    let table = std::fs::read_to_string(path).expect("a table");
    let mut lines = table.lines().map(|line| line.split(','));
    let head: Vec<&str> = lines.next().expect("names").collect();
    let rows: Vec<Vec<f64>> = lines.map(|row| row.map(|x| x.parse().expect("a number")).collect()).collect();
    let column = |c: usize| rows.iter().map(|row| row[c]).collect();
    head.iter().enumerate().map(|(c, name)| (name.to_string(), column(c))).collect()
}

#[test]
fn probes_show_velocity_and_acceleration_anywhere_on_the_surface_and_the_displacement_under_contacts() {
    let folder = tempfile::tempdir().expect("a folder");
    let probe = |name: &str, quantity: &str| {
        format!(
            "[[output.probe]]\nname = \"{name}\"\npoint = [0.93, 0.031, 0.1]\ndirection = [0, 0, 2]\n\
             quantity = \"{quantity}\"\nat = \"surface\"\n"
        )
    };
    let scenario = "duration = 0.1\n[[contact]]\npoint = [0.93, 0.031, 0.1]\nforce = [0, 0, -20]\n[output]\n\
                    contacts = true\n";
    let scenario =
        [scenario, &probe("u", "displacement"), &probe("v", "velocity"), &probe("a", "acceleration")];
    let scenario = text(folder.path(), "s.toml", &scenario.concat());
    let (out, plot) = (folder.path().join("out"), folder.path().join("curves.pdf"));
    let ran = run([&"run", &short_beam().1, &"--scenario", &scenario, &"-o", &out, &"--plot", &plot]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let table = columns(&out.join("probes.csv"));
    let of = |name: &str| table.get(name).unwrap_or_else(|| panic!("no {name} in {:?}", table.keys()));
    let (time, u, v, a) = (of("time_s"), of("u [m]"), of("v [m/s]"), of("a [m/s²]"));
    // The place is that of the contact.
    assert_eq!(u, of("contact.0.z [m]"));
    assert!(u.iter().all(|u| *u <= 0.0) || u.iter().any(|u| *u < -1e-6), "{u:?}");
    let step = time[1] - time[0];
    let scale = |values: &[f64]| values.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    for n in 1..time.len() {
        // Mean acceleration of the step that ends there, to the ten digits of the table.
        let mean = (v[n] - v[n - 1]) / step;
        assert!((a[n] - mean).abs() < 1e-8 * scale(v) / step, "{n}: {} {mean}", a[n]);
    }
    assert_eq!(a[0], 0.0);
    // The displacement is the integral of the velocity, by the rule of Simpson over pairs of steps.
    let moved: f64 =
        (1..time.len() / 2).map(|k| step / 3.0 * (v[2 * k - 2] + 4.0 * v[2 * k - 1] + v[2 * k])).sum();
    let end = 2 * (time.len() / 2 - 1);
    assert!((u[end] - u[0] - moved).abs() < 0.05 * scale(u), "{} {moved}", u[end] - u[0]);
    assert!(std::fs::read(&plot).expect("a picture").starts_with(b"%PDF-1.4"));
}

#[test]
fn a_run_is_drawn_with_an_area_for_each_unit() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = "duration = 0.05\n[[contact]]\npoint = [0.93, 0.031, 0.1]\nforce = [0, 0, -20]\nend = 0.02\n\
                    [[output.probe]]\nname = \"speed\"\npoint = [1, 0.04, 0.1]\ndirection = [0, 0, 1]\n\
                    quantity = \"velocity\"\n";
    let scenario = text(folder.path(), "s.toml", scenario);
    let (out, plot) = (folder.path().join("out"), folder.path().join("curves.svg"));
    let ran = run([&"run", &short_beam().1, &"--scenario", &scenario, &"-o", &out, &"--plot", &plot]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(ran.stdout.contains(&format!("wrote {}", plot.display())), "{}", ran.stdout);
    let svg = std::fs::read_to_string(&plot).expect("a picture");
    assert!(svg.starts_with("<svg") && svg.contains("m/s]") && svg.contains("displacement ["), "{svg:.500}");
    // What another program has written there stays.
    let other = text(folder.path(), "notes.svg", "Dear reader.\n");
    let ran = run([&"run", &short_beam().1, &"--scenario", &scenario, &"-o", &out, &"--plot", &other]);
    assert_eq!(ran.code, Some(2), "{}", ran.stderr);
}

#[test]
fn forces_whose_squares_overflow_are_refused_with_their_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = "duration = 0.1\n[[contact]]\npoint = [1, 0, 0]\nforce = [0, 0, 1e200]\n";
    let scenario = text(folder.path(), "s.toml", scenario);
    let out = folder.path().join("out");
    run([&"run", &short_beam().1, &"--scenario", &scenario, &"-o", &out])
        .fails(3, &["s.toml:4: `contact[0].force` is [0, 0, 1e200]"]);
}

/// A beam of two regions whose stiffness, density, Δt and damping stay free; small. `fixed` gives the values
/// of a problem without them.
fn two_regions(fixed: Option<[f64; 5]>) -> String {
    let [stiffness, density, whole, step, beta] = fixed.unwrap_or([1.0, 1.0, 1.0, 1e-3, 2e-5]);
    let material = |region: &str, young: f64, density: f64| {
        format!(
            "[[material]]\nregion = \"{region}\"\nyoung = {young:e}\npoisson = 0.3\ndensity = {density:e}\n"
        )
    };
    let parameter = |name: &str, kind: &str, range: [f64; 2]| {
        format!("[[parameter]]\nname = \"{name}\"\n{kind}\nrange = {range:?}\nscale = \"log\"\n")
    };
    let mut problem = format!(
        "[mesh]\nblock = {{ lengths = [1.0, 0.16, 0.1], divisions = [4, 1, 1], order = \"quadratic\" }}\n\
         [[mesh.region]]\nname = \"tip\"\non = {{ fraction = {{ axis = \"x\", side = \"max\", fraction = 0.5 }} }}\n\
         [[support]]\non = {{ group = \"x_min\" }}\n\
         [load]\nsurface = {{ group = \"z_max\" }}\n\
         [time]\nscheme.name = \"bathe\"\nstep = {step:e}\n[damping]\nbeta = {beta:e}\n\
         [snapshots]\npositions = 4\ndirections = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]\n\
         [basis]\nmodes = 10\n"
    );
    problem += &material("body", 2.1e9 * whole, 1200.0);
    problem += &material("tip", 2.1e9 * whole * stiffness, 1200.0 * density);
    if fixed.is_none() {
        problem +=
            "[tolerance]\nfloor_ratio = 1.2\nabsolute = 1e-5\nsteps = 200\nmap = 1e-6\nmax_terms = 80\n";
        problem += &parameter("tip stiffness", "kind = \"stiffness\"\nregion = \"tip\"", [0.5, 2.0]);
        problem += &parameter("tip density", "kind = \"density\"\nregion = \"tip\"", [0.8, 1.25]);
        problem += &parameter("stiffness", "kind = \"stiffness\"", [0.5, 2.0]);
        problem += &parameter("time step", "kind = \"time-step\"", [0.5e-3, 2e-3]);
        problem += &parameter("beta", "kind = \"beta\"", [1e-5, 1e-4]);
    }
    problem
}

#[test]
fn a_build_that_will_miss_its_tolerance_says_so_before_its_certificate_and_that_contacts_have_no_bound() {
    let folder = tempfile::tempdir().expect("a folder");
    let problem = two_regions(None).replace("max_terms = 80", "max_terms = 12");
    let problem = text(folder.path(), "p.toml", &problem);
    let file = folder.path().join("p.vdm");
    let told = [Path::new("build"), &problem, Path::new("-o"), &file, Path::new("--keep-missed")];
    let ran = Ran::new(&std::process::Command::new(program()).args(told).output().expect("run"));
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let at = |words: &str| ran.stderr.find(words).unwrap_or_else(|| panic!("no `{words}` in {}", ran.stderr));
    let (early, late) =
        (at("the build is about to miss its tolerance"), at("the separated maps of 12 terms miss"));
    let certificate = ran.stderr.rfind("certificate").expect("the stage");
    assert!(early < late && late < certificate, "{}", ran.stderr);
    let warning = "warning: contacts have no residual flexibility and no error bound (live regions)";
    assert!(ran.stdout.contains(warning), "{}", ran.stdout);
    assert!(run([&"info", &file]).stdout.contains(warning));
}

const NAMES: [&str; 5] = ["tip stiffness", "tip density", "stiffness", "time step", "beta"];

#[test]
fn a_live_file_is_verified_anywhere_in_its_box() {
    let folder = tempfile::tempdir().expect("a folder");
    let problem = text(folder.path(), "live.toml", &two_regions(None));
    let file = folder.path().join("live.vdm");
    let built = run([&"build", &problem, &"-o", &file, &"--keep-missed"]);
    assert!(matches!(built.code, Some(0 | 6)) && file.exists(), "{}", built.stderr);
    let scenario =
        "duration = 0.2\n[[contact]]\npoint = [1.0, 0.08, 0.1]\nforce = [3.0, -8.0, -20.0]\nend = 0.05\n";
    let scenario = text(folder.path(), "s.toml", scenario);
    let verify = |file: &Path, problem: &Path, values: &[f64]| {
        let mut arguments: Vec<_> = ["verify", "--json"].into_iter().map(std::ffi::OsString::from).collect();
        arguments.extend([file.into(), "--problem".into(), problem.into(), "--scenario".into()]);
        arguments.push(scenario.clone().into());
        for (name, value) in NAMES.iter().zip(values) {
            arguments.extend(["--set".into(), format!("{name}={value}").into()]);
        }
        vademecum(&arguments).json()
    };
    let number = |json: &serde_json::Value, key: &str| json[key].as_f64().expect("a number");
    let points = [[0.6, 1.1, 1.7, 0.7e-3, 2e-5], [1.8, 0.85, 0.6, 1.5e-3, 8e-5], [1.3, 1.2, 1.0, 1e-3, 3e-5]];
    for values in points {
        let live = verify(&file, &problem, &values);
        // The build takes 1.2 floors at the corners, for loads of its own; another setting is off by
        // hundreds.
        let (error, floor) = (number(&live, "trajectory_error"), number(&live, "projection_floor"));
        assert!(error < 2.0 * floor && floor < 1e-2, "{values:?}: error {error}, floor {floor}");
        for ((name, value), told) in
            NAMES.iter().zip(values).zip(live["parameters"].as_array().expect("a list"))
        {
            assert_eq!((told["name"].as_str(), told["value"].as_f64()), (Some(*name), Some(value)));
        }
        assert_eq!(number(&live, "time_step"), values[3]);

        // The full order beside it is that of a fresh problem with these values, matrices and all.
        let fixed = text(folder.path(), "fixed.toml", &two_regions(Some(values)));
        let fixed_file = folder.path().join("fixed.vdm");
        let built = run([&"build", &fixed, &"-o", &fixed_file, &"--keep-missed"]);
        assert!(matches!(built.code, Some(0 | 6)) && fixed_file.exists(), "{}", built.stderr);
        let fresh = verify(&fixed_file, &fixed, &[]);
        let drift = [&live, &fresh].map(|json| 1.0 + number(json, "energy_drift_full_order"));
        assert!((drift[0] / drift[1] - 1.0).abs() < 1e-7, "{values:?}: energies left {drift:?}");
        assert_eq!(live["steps"], fresh["steps"]);
    }
    // Both sides move: elsewhere the full order is another one.
    let [here, there] = [points[0], points[1]].map(|values| verify(&file, &problem, &values));
    let drift = [&here, &there].map(|json| 1.0 + number(json, "energy_drift_full_order"));
    assert!((drift[0] / drift[1] - 1.0).abs() > 1e-3, "{drift:?}");

    let out = folder.path().join("out");
    let set = |set: &str| run([&"run", &file, &"--scenario", &scenario, &"-o", &out, &"--set", &set]);
    assert_eq!(set("tip stiffness=1.5").code, Some(0));
    set("tip stiffness=5").fails(2, &["`tip stiffness` is 5", "from 0.5 to 2"]);
    set("tip stiffness=nan").fails(2, &["`tip stiffness` is NaN", "from 0.5 to 2"]);
    set("stifness=1")
        .fails(2, &["`stifness`", "`tip stiffness` from 0.5 to 2", "`time step` from 0.0005 to 0.002 s"]);
    set("stiffness").fails(2, &["NAME=VALUE"]);
    set("stiffness=x").fails(2, &["`x` is not a number"]);
    run([
        &"run",
        &file,
        &"--scenario",
        &scenario,
        &"-o",
        &out,
        &"--time-step",
        &"1e-3",
        &"--set",
        &"time step=1e-3",
    ])
    .fails(2, &["given twice"]);
}

#[test]
fn a_file_that_is_cut_while_a_run_uses_it_does_not_matter() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("beam.vdm");
    std::fs::copy(&short_beam().1, &file).expect("copied");
    let push = "[[contact]]\npoint = [1.0, 0.1, 0.1]\nforce = [0, 0, -1]\n";
    let long = format!("duration = 2e3\n{push}[output]\nprobes_every = 10000\n");
    let scenario = text(folder.path(), "s.toml", &long);
    let mut running = std::process::Command::new(program())
        .args(["run".as_ref(), file.as_os_str(), "--scenario".as_ref(), scenario.as_os_str()])
        .args(["-o".as_ref(), folder.path().join("out").as_os_str()])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let said = BufReader::new(running.stderr.take().expect("piped"));
    let mut lines = said.lines().map(|line| line.expect("text"));
    assert!(lines.any(|line| line.trim() == "step"), "the march begins");
    std::fs::write(&file, b"").expect("cut");
    let rest: Vec<String> = lines.collect();
    assert!(running.wait().expect("an end").success(), "{rest:?}");
    for option in ["--map", "--copy"] {
        let scenario = text(folder.path(), "short.toml", &format!("duration = 0.1\n{push}"));
        let arguments =
            ["run".as_ref(), short_beam().1.as_os_str(), "--scenario".as_ref(), scenario.as_os_str()];
        let ran = command(&arguments)
            .args([option.as_ref(), "-o".as_ref(), folder.path().join("out").as_os_str()])
            .output()
            .expect("the program starts");
        assert!(ran.status.success(), "{option}: {}", String::from_utf8_lossy(&ran.stderr));
    }
}
