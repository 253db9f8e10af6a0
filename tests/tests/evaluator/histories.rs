//! Loads that follow a table, a sinusoid or a chirp, and contacts that move, against closed forms and against
//! each other; damping ratios of the natural modes.

use std::f64::consts::TAU;
use std::path::Path;
use std::sync::OnceLock;

use vademecum_build::progress::Silent;
use vademecum_eval::SceneOptions;
use vademecum_format::{File, SectionKind as S};
use vademecum_study::player::{PlayOptions, Track, play};
use vademecum_study::scenario::Scenario;
use vademecum_tests::program::{Ran, repository, vademecum};

/// A block of four by two by two cells that is held at one end; its modes have frequencies of their own.
fn problem(damping: &str, modes: usize, more: &str) -> String {
    format!(
        "[mesh]\nblock = {{ lengths = [0.4, 0.11, 0.08], divisions = [4, 2, 2], order = \"linear\" }}\n\
         [[material]]\nyoung = 2e7\npoisson = 0.3\ndensity = 1100.0\n[[support]]\non = {{ group = \"x_min\" }}\n\
         [damping]\n{damping}\n[load]\n[[load.pattern]]\nname = \"gravity\"\nacceleration = [0.0, 0.0, -9.81]\n\
         [time]\nstep = 5e-4\n[basis]\nmodes = {modes}\n{more}\n\
         [[output.probe]]\nname = \"tip\"\npoint = [0.4, 0.11, 0.08]\ndirection = [0.3, 0.5, 1.0]\n"
    )
}

fn build(text: &str, folder: &Path) -> Ran {
    let [problem, file] = ["p.toml", "f.vdm"].map(|name| folder.join(name).display().to_string());
    std::fs::write(&problem, text).expect("written");
    vademecum(&["build", &problem, "-o", &file, "--keep-missed"])
}

/// A folder with a problem, `p.toml`, and the file built from it, `f.vdm`.
fn built(text: &str) -> (tempfile::TempDir, Vec<u8>) {
    let folder = tempfile::tempdir().expect("a folder");
    let ran = build(text, folder.path());
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let bytes = std::fs::read(folder.path().join("f.vdm")).expect("a file");
    (folder, bytes)
}

/// Eight modes with two percent of damping each.
fn body() -> &'static (tempfile::TempDir, Vec<u8>) {
    static BODY: OnceLock<(tempfile::TempDir, Vec<u8>)> = OnceLock::new();
    BODY.get_or_init(|| built(&problem("ratio = 0.02", 8, "")))
}

/// Reduced coordinates at all instants, one instant after the other.
fn coordinates(bytes: &[u8], scenario: &str, time_step: f64) -> Vec<Vec<f64>> {
    let scenario = Scenario::parse(scenario, "scenario.toml").expect("a scenario");
    let file = File::parse(bytes).expect("a file");
    let track = Track::bind(&file, &scenario).expect("bound");
    let scene = SceneOptions { time_step: Some(time_step), ..SceneOptions::default() };
    let options = PlayOptions { scene, ..PlayOptions::default() };
    let steps = scenario.steps(time_step).expect("countable");
    let mut shown = vec![];
    play(&file, &options, &track, steps, &Silent, |_, body| {
        shown.push(body.zeta().to_vec());
        Ok(())
    })
    .expect("played");
    shown
}

const DT: f64 = 5e-4;
const CONTACT: &str = "[[contact]]\npoint = [0.4, 0.05, 0.08]\nforce = [0.3, -1.0, -2.0]\n";

/// Largest distance over the largest size.
fn apart(found: &[Vec<f64>], expected: &[Vec<f64>]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let pairs = || found.iter().flatten().zip(expected.iter().flatten());
    let size = pairs().fold(0.0, |m: f64, (_, e)| m.max(e.abs()));
    assert!(size > 0.0, "nothing moved");
    pairs().fold(0.0, |m: f64, (f, e)| m.max((f - e).abs())) / size
}

fn eigenvalues(bytes: &[u8]) -> Vec<f64> {
    let file = File::parse(bytes).expect("a file");
    file.section(S::Eigenvalues).expect("modes").numbers().expect("numbers").iter().collect()
}

/// What a held unit force does to a mode from rest.
fn held(lambda: f64, sigma: f64, t: f64) -> f64 {
    let swing = (lambda - sigma * sigma).sqrt();
    let (sin, cos) = (swing * t).sin_cos();
    (1.0 - (-sigma * t).exp() * (cos + sigma / swing * sin)) / lambda
}

/// What `mean + sin(Ω t + φ)` does to a mode from rest.
fn shaken(lambda: f64, sigma: f64, [omega, phase, mean]: [f64; 3], t: f64) -> f64 {
    // The steady answer is the imaginary part of Q e^{i(Ωt+φ)} with Q = (a − ib)/(a² + b²).
    let (a, b) = (lambda - omega * omega, 2.0 * sigma * omega);
    // The frequency of the file is a number with sixteen digits.
    if a.abs() < 1e-12 * lambda && b == 0.0 {
        let angle = omega * t;
        assert_eq!([phase, mean], [0.0, 0.0]);
        return 0.5 * (angle.sin() - angle * angle.cos()) / lambda;
    }
    let steady = |angle: f64| (a * angle.sin() - b * angle.cos()) / (a * a + b * b);
    let rate = |angle: f64| omega * (a * angle.cos() + b * angle.sin()) / (a * a + b * b);
    let swing = (lambda - sigma * sigma).sqrt();
    let (sin, cos) = (swing * t).sin_cos();
    let start = -steady(phase);
    let free = start * cos + (sigma * start - rate(phase)) / swing * sin;
    steady(omega * t + phase) + (-sigma * t).exp() * free + mean * held(lambda, sigma, t)
}

#[test]
fn a_table_of_a_ramped_interval_moves_the_body_as_the_interval_does() {
    let (_, bytes) = body();
    let interval = format!("duration = 0.05\n{CONTACT}start = 0.0102\nramp = 0.01\nend = 0.0301\n");
    let rows = "table = [[0.0102, 0.0], [0.0202, 1.0], [0.0301, 1.0]]\n";
    let table = format!("duration = 0.05\n{CONTACT}{rows}");
    let [interval, table] = [interval, table].map(|text| coordinates(bytes, &text, DT));
    // The kink of one is a sum, that of the other a number of its own.
    assert!(apart(&table, &interval) < 1e-13, "{:e}", apart(&table, &interval));
    // A load of three components is the sum of its components.
    let text = "duration = 0.05\n[[contact]]\npoint = [0.4, 0.05, 0.08]\nstart = 0.001\n\
                table = [[0.0, 0.0, 0.0, 0.0], [0.01, 1.5, -5.0, -10.0], [0.02, 0.0, 0.0, 0.0]]\n";
    let one = format!("duration = 0.05\n{CONTACT}start = 0.001\ntable = [[0, 0], [0.01, 5], [0.02, 0]]\n");
    let [three, one] = [text, &one].map(|text| coordinates(bytes, text, DT));
    assert!(apart(&three, &one) < 1e-13, "{:e}", apart(&three, &one));
}

#[test]
fn a_sinusoid_moves_every_mode_as_its_closed_form_says_in_resonance_too() {
    for (damping, ratio) in [("ratio = 0.0", 0.0), ("ratio = 0.02", 0.02)] {
        let (_, bytes) = built(&problem(damping, 4, ""));
        let values = eigenvalues(&bytes);
        let steady = coordinates(&bytes, &format!("duration = 0.3\n{CONTACT}"), DT);
        // What the force is to each mode, from what it does held.
        let share = |k: usize| {
            let sigma = ratio * values[k].sqrt();
            let answer = |n: usize| held(values[k], sigma, n as f64 * DT);
            let [mut over, mut norm] = [0.0; 2];
            for (n, row) in steady.iter().enumerate() {
                over += row[k] * answer(n);
                norm += answer(n) * answer(n);
            }
            over / norm
        };
        let first = values[0].sqrt() / TAU;
        for (frequency, phase, mean) in [(first, 0.0, 0.0), (37.0, 0.6, 0.0), (0.6 * first, -1.0, 0.5)] {
            // Undamped resonance is written for a sinusoid from zero.
            let wave =
                format!("sinusoid = {{ frequency = {frequency:?}, phase = {phase:?}, mean = {mean:?} }}");
            let found = coordinates(&bytes, &format!("duration = 0.3\n{CONTACT}{wave}\n"), DT);
            let omega = if frequency == first { values[0].sqrt() } else { TAU * frequency };
            for (k, &value) in values.iter().enumerate() {
                let (share, sigma) = (share(k), ratio * value.sqrt());
                let exact = |n: usize| share * shaken(value, sigma, [omega, phase, mean], n as f64 * DT);
                let size = (0..found.len()).map(|n| exact(n).abs()).fold(0.0, f64::max);
                let worst = (0..found.len()).map(|n| (found[n][k] - exact(n)).abs()).fold(0.0, f64::max);
                // Chords take (Ωh)²/12, two thirds of a millionth, off the sinusoid.
                assert!(worst < 1e-6 * size, "{frequency} Hz, mode {k}: {:e}", worst / size);
            }
        }
    }
}

#[test]
fn a_chirp_moves_the_body_as_a_fine_table_of_it_does() {
    let (_, bytes) = body();
    let (from, to, start, end) = (3.0, 60.0, 0.01, 0.31);
    let folder = tempfile::tempdir().expect("a folder");
    let rows = 20_000;
    let mut csv = "# a sweep\ntime,amplitude\n".to_string();
    for row in 0..=rows {
        let t = (end - start) * f64::from(row) / f64::from(rows);
        let value = (0.4 + TAU * (from * t + 0.5 * (to - from) * t * t / (end - start))).sin();
        csv += &format!("{t:e},{value:e}\n");
    }
    std::fs::write(folder.path().join("sweep.csv"), csv).expect("written");
    let text = format!("duration = 0.35\n{CONTACT}start = {start}\nend = {end}\ntable = \"sweep.csv\"\n");
    std::fs::write(folder.path().join("s.toml"), &text).expect("written");
    // Relative to the scenario, not to where the program stands.
    let scenario = Scenario::read(&folder.path().join("s.toml")).expect("a scenario");
    let file = File::parse(bytes).expect("a file");
    let track = Track::bind(&file, &scenario).expect("bound");
    let mut table = vec![];
    play(&file, &PlayOptions::default(), &track, 700, &Silent, |_, body| {
        table.push(body.zeta().to_vec());
        Ok(())
    })
    .expect("played");
    let wave =
        format!("start = {start}\nend = {end}\nchirp = {{ from = {from:?}, to = {to:?}, phase = 0.4 }}\n");
    let chirp = coordinates(bytes, &format!("duration = 0.35\n{CONTACT}{wave}"), DT);
    assert!(apart(&chirp, &table) < 2e-6, "{:e}", apart(&chirp, &table));
    // Without an end of its own it sweeps to the end of the scenario.
    let [open, closed] = ["", "end = 0.35\n"].map(|end| {
        let text = format!("duration = 0.35\n{CONTACT}{end}chirp = {{ from = 1.0, to = 50.0 }}\n");
        coordinates(bytes, &text, DT)
    });
    assert!(apart(&open, &closed) < 1e-12);
}

/// Loads of every kind.
const LOADS: [(&str, &str); 6] = [
    ("plain", "force = [0.3, -1.0, -2.0]\npoint = [0.4, 0.05, 0.08]\nend = 0.0513\nramp = 0.01"),
    ("table", "point = [0.4, 0.05, 0.08]\ntable = [[0.0, 0, 0, 0], [0.0203, 1, 2, -1], [0.05, -1, 0, 1]]"),
    (
        "sinusoid",
        "force = [0.3, -1.0, -2.0]\npoint = [0.4, 0.05, 0.08]\nend = 0.0513\nramp = 0.01\n\
         sinusoid = { frequency = 40.0 }",
    ),
    (
        "chirp",
        "force = [0.3, -1.0, -2.0]\npoint = [0.4, 0.05, 0.08]\nend = 0.0513\nchirp = { from = 1.0, to = 100.0 }",
    ),
    (
        "path",
        "force = [0.3, -1.0, -2.0]\nend = 0.0513\nramp = 0.0\npath = [[0, 0.2, 0.05, 0.08], [0.06, 0.4, 0.05, 0.08]]",
    ),
    (
        "path with a table",
        "force = [0.3, -1.0, -2.0]\npath = [[0, 0.2, 0.05, 0.08], [0.06, 0.4, 0.05, 0.08]]\n\
         table = [[0.0, 0.0], [0.02, 1.0], [0.05, 0.0]]",
    ),
];

#[test]
fn what_is_seen_does_not_depend_on_the_step() {
    let (_, bytes) = body();
    for (kind, load) in LOADS {
        let text = format!("duration = 0.07\n[[contact]]\n{load}\n");
        let coarse = coordinates(bytes, &text, DT);
        let fine: Vec<_> = coordinates(bytes, &text, DT / 7.0).into_iter().step_by(7).collect();
        let difference = apart(&coarse, &fine);
        // Chords of a load that bends all the time begin where a step does.
        let bends = ["sinusoid", "chirp", "path with a table"].contains(&kind);
        let allowed = if bends { 2e-6 } else { 1e-12 };
        assert!(difference < allowed, "{kind}: {difference:e}");
    }
}

#[test]
fn verify_gives_the_truth_the_very_same_loads() {
    let (folder, _) = body();
    let [file, problem, scenario] =
        ["f.vdm", "p.toml", "s.toml"].map(|name| folder.path().join(name).display().to_string());
    let measure = |load: &str| {
        std::fs::write(&scenario, format!("duration = 0.07\n[[contact]]\n{load}\n")).expect("written");
        vademecum(&["verify", &file, "--problem", &problem, "--scenario", &scenario, "--json"]).json()
    };
    let number = |of: &serde_json::Value, key: &str| of[key].as_f64().expect("a number");
    let plain = number(&measure(LOADS[0].1), "total_error");
    for (kind, load) in LOADS {
        let found = measure(load);
        let [total, rest, contact] =
            ["total_error", "rest_error", "contact_error"].map(|key| number(&found, key));
        // Beside the modes that are left out nothing is wrong: the load is the same to its last digits.
        assert!(rest < 1e-5, "{kind}: {rest:e}");
        assert!(total < 2.0 * plain, "{kind}: {total:e} beside {plain:e}");
        assert!(contact < 0.5, "{kind}: {contact:e}");
    }
}

#[test]
fn a_contact_that_moves_inside_of_a_triangle_pushes_as_its_three_nodes_say() {
    let (_, bytes) = body();
    let force = "force = [0.0, 0.0, -1.0]\n";
    let moving = "path = [[0.0, 0.31, 0.02, 0.08], [0.02, 0.33, 0.03, 0.08]]";
    let moving = format!("duration = 0.03\n[[contact]]\n{force}{moving}\n");
    // Inside of a triangle the force on each node is linear in the place: half of both ends at half time.
    let hat = |point: &str, rows: &str| format!("[[contact]]\n{force}point = {point}\ntable = {rows}\n");
    let ends = format!(
        "duration = 0.03\n{}{}",
        hat("[0.31, 0.02, 0.08]", "[[0.0, 1.0], [0.02, 0.0]]"),
        hat("[0.33, 0.03, 0.08]", "[[0.0, 0.0], [0.02, 1.0], [1.0, 1.0]]")
    );
    let [moving, ends] = [moving, ends].map(|text| coordinates(bytes, &text, DT));
    assert!(apart(&moving, &ends) < 1e-12, "{:e}", apart(&moving, &ends));
}

#[test]
fn loads_that_are_none_are_refused_before_anything_is_stepped() {
    let (folder, bytes) = body();
    let file = File::parse(bytes).expect("a file");
    let bind = |load: &str, step: f64| {
        let scenario = Scenario::parse(&format!("duration = 1.0\n{load}\n"), "s.toml").expect("read");
        let track = Track::bind(&file, &scenario).map(|_| ());
        track.and(scenario.steps_within(step, 1 << 40, false).map(|_| ())).expect_err("refused").to_string()
    };
    let fast = bind(&format!("{CONTACT}sinusoid = {{ frequency = 1e6 }}"), DT);
    assert!(fast.contains("`contact[0]` has up to 1e6 Hz, which is 500.0 periods in a step"), "{fast}");
    let far = "[[contact]]\nforce = [0, 0, 1]\npath = [[0, 0, 0, 0], [1, 1e9, 0, 0]]";
    assert!(bind(far, DT).contains("`contact[0].path` takes more than 100000 places"), "{}", bind(far, DT));
    // What is no regular file is not read, and what is not there is named.
    for (table, said) in [(".", "a folder"), ("/dev/zero", "a character device"), ("none.csv", "none.csv")] {
        let text = format!("duration = 1.0\n{CONTACT}table = \"{table}\"\n");
        let path = folder.path().join("refused.toml");
        std::fs::write(&path, text).expect("written");
        let target = folder.path().join("f.vdm").display().to_string();
        let out = folder.path().join("out").display().to_string();
        vademecum(&["run", &target, "--scenario", &path.display().to_string(), "-o", &out]).fails(3, &[said]);
    }
}

#[test]
fn every_mode_decays_by_its_own_ratio() {
    let list = "modal = [0.05, 0.0, 1.5, 0.01]\nbeta = 1e-5";
    let (folder, bytes) = built(&problem(list, 6, ""));
    let values = eigenvalues(&bytes);
    let steps = coordinates(&bytes, &format!("duration = 0.1\n{CONTACT}"), DT);
    for (k, ratio) in [0.05, 0.0, 1.5, 0.01, 0.01, 0.01].into_iter().enumerate() {
        let (omega, sigma) = (values[k].sqrt(), ratio * values[k].sqrt() + 0.5e-5 * values[k]);
        let answer = |n: usize| {
            let t = n as f64 * DT;
            if sigma < omega {
                return held(values[k], sigma, t);
            }
            let root = (sigma * sigma - values[k]).sqrt();
            let [slow, fast] = [sigma - root, sigma + root];
            (1.0 - (fast * (-slow * t).exp() - slow * (-fast * t).exp()) / (fast - slow)) / values[k]
        };
        let last = steps.len() - 1;
        let share = steps[last][k] / answer(last);
        let size = (0..=last).map(|n| (share * answer(n)).abs()).fold(0.0, f64::max);
        let worst = (0..=last).map(|n| (steps[n][k] - share * answer(n)).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-10 * size, "mode {k}: {:e}", worst / size);
    }
    let file = folder.path().join("f.vdm").display().to_string();
    assert_eq!(vademecum(&["verify", &file, "--file-only"]).code, Some(0));
    let [problem, scenario] = ["p.toml", "s.toml"].map(|name| folder.path().join(name).display().to_string());
    std::fs::write(&scenario, format!("duration = 0.07\n{CONTACT}")).expect("written");
    let found =
        vademecum(&["verify", &file, "--problem", &problem, "--scenario", &scenario, "--json"]).json();
    // The reference damps the same modes by the same ratios, wherever they are among those it finds.
    assert!(found["rest_error"].as_f64().expect("a number") < 1e-4, "{found}");
    let info = vademecum(&["info", &file, "--json"]).json();
    assert_eq!(info["damping_ratios"], serde_json::json!([0.05, 0.0, 1.5, 0.01, 0.01, 0.01]));
    let modes = vademecum(&["modes", &problem, "--count", "3", "--json"]).json();
    let damping = modes["material_damping"][2].as_f64().expect("a number");
    assert!((damping - 1.5 - 0.5e-5 * values[2].sqrt()).abs() < 1e-6, "{damping}");
}

#[test]
fn modes_of_one_frequency_have_one_ratio() {
    // Two masses that move apart from each other, on springs of 4, 4 and 9 times 1e4 N/m.
    let folder = tempfile::tempdir().expect("a folder");
    let diagonal = |values: [f64; 6]| {
        let rows: String = values.iter().enumerate().map(|(i, v)| format!("{0} {0} {v}\n", i + 1)).collect();
        format!("%%MatrixMarket matrix coordinate real symmetric\n6 6 6\n{rows}")
    };
    let place = |row: usize| format!("{row},{},{},{},0,0\n", row / 3 + 1, ["x", "y", "z"][row % 3], row / 3);
    let dofs: String = (0..6).map(place).collect();
    let texts = [
        ("mass.mtx", diagonal([1.0; 6])),
        ("stiffness.mtx", diagonal([4e4, 4e4, 9e4, 16e4, 25e4, 36e4])),
        ("dofs.csv", format!("row,node,component,x,y,z\n{dofs}")),
    ];
    for (name, text) in &texts {
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    let problem = |modal: &str| {
        format!(
            "[mesh.matrices]\nmass = \"mass.mtx\"\nstiffness = \"stiffness.mtx\"\ndofs = \"dofs.csv\"\n\
             [damping]\nmodal = {modal}\n[load]\n[time]\nstep = 1e-3\n[basis]\nmodes = 3\n"
        )
    };
    build(&problem("[0.1, 0.2]"), folder.path()).fails(
        3,
        &["p.toml:6: `damping.modal` gives the modes 1 and 2 the ratios 0.1 and 0.2", "31.830989 Hz"],
    );
    let alike = build(&problem("[0.1, 0.1, 0.2]"), folder.path());
    assert_eq!(alike.code, Some(0), "{}", alike.stderr);
}

#[test]
fn a_ratio_of_all_modes_certifies_as_well_as_rayleighs_and_ratios_that_cannot_be_kept_are_refused() {
    let (_, bytes) = body();
    let file = File::parse(bytes).expect("a file");
    let ratios: Vec<f64> =
        file.section(S::DampingRatios).expect("kept").numbers().expect("numbers").iter().collect();
    assert_eq!(ratios, [0.02; 8]);
    let (_, undamped) = built(&problem("", 8, ""));
    assert!(File::parse(&undamped).expect("a file").section(S::DampingRatios).is_none());
    let certified = |bytes: &[u8]| File::parse(bytes).expect("a file").metadata().certificate.diagonal;
    let (damped, undamped) = (certified(bytes), certified(&undamped));
    assert!(damped.trajectory_error <= 1.1 * undamped.trajectory_error, "{damped:?} beside {undamped:?}");
    assert!(damped.trajectory_error <= 1.001 * damped.projection_floor + 1e-5, "{damped:?}");
    assert!(damped.spectral_radius < 1.0);

    let folder = tempfile::tempdir().expect("a folder");
    for (text, said) in [
        (
            problem("ratio = 0.02", 4, "").replace("[time]", "[time]\nscheme.name = \"bathe\""),
            "`damping.ratio`",
        ),
        (problem("modal = [0.02]", 4, "kind = \"ritz\""), "`damping.modal`"),
        (problem("modal = [0.02]", 4, "kind = \"pod\""), "`damping.modal`"),
        (problem("modal = []", 4, ""), "a list of 0"),
        (problem("modal = [0.1, -0.1]", 4, ""), "`damping.modal` is -0.1"),
        (problem("modal = [0.1]\nratio = 0.1", 4, ""), "`modal` beside `ratio`"),
        (problem("modal = [0.1, 0.1, 0.1, 0.1, 0.1]", 4, ""), "a list of 5; the basis has 4 modes"),
    ] {
        build(&text, folder.path()).fails(3, &[said]);
    }
    let problem_file = repository().join("fixtures/problems/short-beam.toml");
    let text = std::fs::read_to_string(problem_file).expect("the fixture");
    let text = text
        .replace("scheme = { name = \"bathe\" }\n", "")
        .replace("[time]", "[damping]\nratio = 0.1\n[time]");
    let path = folder.path().join("beam.toml").display().to_string();
    std::fs::write(&path, text).expect("written");
    let out = folder.path().join("matrices").display().to_string();
    vademecum(&["export", "matrices", &path, "-o", &out]).fails(3, &["`damping.ratio`", "alpha"]);
}
