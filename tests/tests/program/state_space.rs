//! State-space models of files: a march of their matrices is a run of the file, their transfer function is
//! its frequency response, and files without such matrices are refused by name.

use std::path::PathBuf;

use faer::{Mat, c64};
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::{SceneOptions, StructureChoice};
use vademecum_format::File;
use vademecum_study::StudyError;
use vademecum_study::frf::{Channel, Quantity, ResponseRequest, frequency_response};
use vademecum_study::live::at_values;
use vademecum_study::parameters::ParameterValue;
use vademecum_study::player::PlayOptions;
use vademecum_study::run::Run;
use vademecum_study::scenario::Scenario;
use vademecum_study::state_space::{StateSpace, StateSpaceError, StateSpaceRequest};
use vademecum_tests::program::{repository, vademecum};

/// Reactions, a base that moves, stress, a gauge and a pattern. The step is a power of two, so that the
/// instants of a run are those of the march.
const TOWER: &str = r#"
[mesh]
block = { lengths = [0.2, 0.1, 0.6], divisions = [2, 1, 6] }
[[material]]
young = 1e7
poisson = 0.3
density = 1200.0
[[support]]
name = "foot"
on = { group = "z_min" }
[load]
surface = { group = "x_max" }
[[load.pattern]]
name = "gravity"
acceleration = [0.0, 0.0, -9.81]
[base]
moves = true
[time]
step = 0.0009765625
[basis]
modes = 12
[tolerance]
error = 10.0
[output]
reactions = true
static_fields = true
stress = { box = { min = [-1.0, -1.0, 0.0], max = [1.0, 1.0, 0.1] } }
[[output.probe]]
name = "top"
point = [0.2, 0.1, 0.6]
direction = [1.0, 0.0, 0.0]
[[output.gauge]]
name = "root"
point = [0.2, 0.05, 0.1]
direction = [0.0, 0.0, 1.0]
length = 0.05
"#;

/// A ramp that is held and dropped, a table that jumps, a base that shakes.
const SCENARIO: &str = r#"
duration = 0.25
[[contact]]
point = [0.2, 0.05, 0.45]
force = [0.0, 0.0, -3.0]
ramp = 0.03125
end = 0.125
[[contact]]
point = [0.2, 0.05, 0.45]
force = [-2.0, 0.0, 0.0]
start = 0.0625
[[pattern]]
name = "gravity"
table = [[0.0, 0.5], [0.0625, 1.0], [0.0625, -0.25], [0.125, 0.0]]
[base]
record = [[0.0, 0.0, 0.0, 0.0], [0.03125, 1.0, 0.0, 0.0], [0.09375, -2.0, 0.0, 0.0], [0.25, 0.0, 0.0, 0.0]]
[output]
[[output.probe]]
name = "pushed"
point = [0.2, 0.05, 0.45]
direction = [1.0, 0.0, 0.0]
at = "surface"
[[output.probe]]
name = "away"
point = [0.2, 0.02, 0.3]
direction = [1.0, 0.0, 0.0]
at = "surface"
[[output.probe]]
name = "rate"
point = [0.2, 0.05, 0.45]
direction = [1.0, 0.0, 0.0]
quantity = "velocity"
at = "surface"
[[output.probe]]
name = "mean acceleration"
point = [0.2, 0.05, 0.45]
direction = [1.0, 0.0, 0.0]
quantity = "acceleration"
at = "surface"
[[output.stress]]
name = "bending"
point = [0.2, 0.05, 0.1]
quantity = "zz"
"#;

const INPUTS: [&str; 4] = ["0.2,0.05,0.45,-z", "0.2,0.05,0.45,-x", "gravity", "base.ax"];
/// In the order of the columns of the run but for the accelerations.
const OUTPUTS: [&str; 8] = [
    "top",
    "root",
    "0.2,0.05,0.45,x",
    "0.2,0.02,0.3,x",
    "velocity:0.2,0.05,0.45,x",
    "stress:0.2,0.05,0.1,zz",
    "reaction:foot",
    "acceleration:0.2,0.05,0.45,x",
];

fn built(text: &str) -> Vec<u8> {
    let problem = Problem::parse(text, "problem.toml", PathBuf::new()).expect("a problem");
    build(&problem, &BuildOptions::default(), &Silent).expect("built").either().bytes
}

fn request(inputs: &[&str], outputs: &[&str]) -> StateSpaceRequest {
    StateSpaceRequest {
        inputs: inputs.iter().map(|text| text.parse().expect("a channel")).collect(),
        outputs: outputs.iter().map(|text| text.parse().expect("an output")).collect(),
    }
}

/// Amplitudes of the inputs at an instant of [`SCENARIO`], right after it or right before it.
fn amplitudes(step: usize, after: bool) -> [f64; 4] {
    let t = step as f64 / 1024.0;
    let before = |end: f64| if after { t < end } else { t <= end };
    let push = if before(0.125) { 3.0 * (t / 0.03125).min(1.0) } else { 0.0 };
    let held = if before(0.0625) { 0.0 } else { 2.0 };
    let gravity = if before(0.0625) {
        0.5 + 0.5 * t / 0.0625
    } else if before(0.125) {
        -0.25 + 0.25 * (t - 0.0625) / 0.0625
    } else {
        0.0
    };
    let base = match t {
        t if t < 0.03125 => t / 0.03125,
        t if t < 0.09375 => 1.0 - 3.0 * (t - 0.03125) / 0.0625,
        t => -2.0 + 2.0 * (t - 0.09375) / 0.15625,
    };
    [push, held, gravity, base]
}

fn column(values: &[f64]) -> Mat<f64> {
    Mat::from_fn(values.len(), 1, |i, _| values[i])
}

/// Rows of the run: probes, then reactions.
fn run_of(file: &File<'_>, options: &SceneOptions) -> Vec<Vec<f64>> {
    let scenario = Scenario::parse(SCENARIO, "scenario.toml").expect("a scenario");
    let options = PlayOptions { scene: *options, ..PlayOptions::default() };
    let run = Run::bind(file, options, &scenario, &Silent).expect("bound");
    let mut rows = vec![];
    run.play(&Silent, |moment| {
        let row = moment.probes.expect("probes in each step");
        rows.push([row.values, row.reactions.as_flattened()].concat());
        Ok::<(), StudyError>(())
    })
    .expect("played");
    rows
}

/// Largest difference of a march of the matrices from the run, over the largest value of each output.
fn compare(file: &File<'_>, options: &SceneOptions) -> f64 {
    let model = StateSpace::new(file, options, &request(&INPUTS, &OUTPUTS)).expect("a model");
    assert!(model.by_modes_alone.is_empty());
    let rows = run_of(file, options);
    let steps = rows.len() - 1;
    // Right after the start a body that is moved exactly has seen no load yet.
    let mut x = Mat::zeros(model.states.len(), 1);
    let mut shown = vec![vec![]];
    for step in 0..steps {
        let (start, end) = (column(&amplitudes(step, true)), column(&amplitudes(step + 1, false)));
        x = &model.ad * &x + &model.start * start + &model.end * &end;
        let y = &model.c * &x + &model.d * end;
        shown.push(y.col(0).iter().copied().collect::<Vec<f64>>());
    }
    // Columns of the run for each output: the mean acceleration stands between velocity and stress.
    let places = [0, 1, 2, 3, 4, 6, 7, 8, 9, 10, 11, 12];
    assert_eq!(rows[0].len(), 13);
    let mut worst = 0.0_f64;
    for (output, &place) in places.iter().enumerate() {
        let largest = rows.iter().fold(0.0_f64, |most, row| most.max(row[place].abs()));
        assert!(largest > 0.0, "{}", model.outputs[output].name);
        for step in 1..=steps {
            let difference = (shown[step][output] - rows[step][place]).abs() / largest;
            assert!(difference < 1e-12, "{} at {step}: {difference:e}", model.outputs[output].name);
            worst = worst.max(difference);
        }
    }
    // The mean acceleration of a step is what the velocity gains over it.
    let largest = rows.iter().fold(0.0_f64, |most, row| most.max(row[5].abs()));
    for step in 2..=steps {
        let gained = (shown[step][4] - shown[step - 1][4]) / model.time_step;
        assert!((gained - rows[step][5]).abs() < 1e-11 * largest, "{step}");
    }
    // The other two maps are the same under inputs that are held, and under those that never jump.
    let (held, [linear, through]) = (model.held(), model.linear());
    let unit = column(&[1.0, -2.0, 0.5, 3.0]);
    assert!((&held * &unit - (&model.start + &model.end) * &unit).norm_max() == 0.0);
    let (mut x, mut w) = (Mat::zeros(model.states.len(), 1), Mat::zeros(model.states.len(), 1));
    for step in 0..50 {
        let at = |step: usize| &unit * faer::Scale(f64::from(u8::try_from(step).expect("small")));
        assert!(
            (&model.c * &x + &model.d * at(step) - (&model.c * &w + &through * at(step))).norm_max() < 1e-9
        );
        x = &model.ad * &x + &model.start * at(step) + &model.end * at(step + 1);
        w = &model.ad * &w + &linear * at(step);
    }
    println!("march of the matrices: {worst:.1e} of the largest");
    worst
}

#[test]
fn a_march_of_the_matrices_is_the_run() {
    // 256 steps, each of which rounds once or twice.
    for damping in ["", "[damping]\nalpha = 3.0\nbeta = 2e-4\n", "[damping]\nratio = 0.02\n"] {
        let bytes = built(&format!("{TOWER}{damping}"));
        let file = File::parse(&bytes).expect("a file");
        let worst = compare(&file, &SceneOptions::default());
        assert!(worst < 1e-12, "{damping}: {worst:e}");
    }
    // Live parameters of the whole body.
    let live = "[[parameter]]\nname = \"stiffness\"\nkind = \"stiffness\"\nrange = [0.5, 2.0]\n\
                [[parameter]]\nname = \"beta\"\nkind = \"beta\"\nrange = [0.0, 1e-2]\n";
    let bytes = built(&format!("{TOWER}{live}"));
    let file = File::parse(&bytes).expect("a file");
    for beta in [None, Some(0.0), Some(1e-3)] {
        let options = SceneOptions { stiffness: 1.7, beta, ..SceneOptions::default() };
        compare(&file, &options);
    }
}

/// `C (iω − A)⁻¹ B + D`.
fn transfer(model: &StateSpace, frequency: f64) -> Mat<c64> {
    let n = model.states.len();
    let omega = c64::new(0.0, std::f64::consts::TAU * frequency);
    let complex = |matrix: &Mat<f64>| {
        Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| c64::new(matrix[(i, j)], 0.0))
    };
    let a = complex(&model.a);
    let pencil = Mat::from_fn(n, n, |i, j| if i == j { omega - a[(i, j)] } else { -a[(i, j)] });
    let inverse = faer::linalg::solvers::Solve::solve(&pencil.partial_piv_lu(), &complex(&model.b));
    complex(&model.c) * inverse + complex(&model.d)
}

#[test]
fn the_transfer_function_is_the_frequency_response() {
    let frequencies = vec![0.5, 7.0, 31.0, 140.0, 600.0];
    let outputs = ["top", "0.2,0.05,0.45,x", "0.2,0.02,0.3,x"];
    for damping in ["[damping]\nalpha = 3.0\nbeta = 2e-4\n", "[damping]\nratio = 0.02\n"] {
        let bytes = built(&format!("{TOWER}{damping}"));
        let file = File::parse(&bytes).expect("a file");
        let options = SceneOptions::default();
        for quantity in [Quantity::Displacement, Quantity::Velocity, Quantity::Acceleration] {
            let word = match quantity {
                Quantity::Displacement => "displacement",
                Quantity::Velocity => "velocity",
                Quantity::Acceleration => "acceleration",
            };
            let named: Vec<String> = outputs.iter().map(|output| format!("{word}:{output}")).collect();
            let named: Vec<&str> = named.iter().map(String::as_str).collect();
            let model = StateSpace::new(&file, &options, &request(&INPUTS, &named)).expect("a model");
            for (j, input) in INPUTS.iter().enumerate() {
                let asked = ResponseRequest {
                    input: input.parse().expect("a channel"),
                    outputs: outputs.iter().map(|output| output.parse::<Channel>().expect("one")).collect(),
                    frequencies: frequencies.clone(),
                    quantity,
                };
                let found = frequency_response(&file, &options, &asked).expect("a response");
                // What the modes leave out has no velocity in a run.
                let expected =
                    if quantity == Quantity::Displacement { &found.values } else { &found.by_modes };
                for (k, &frequency) in frequencies.iter().enumerate() {
                    let own = transfer(&model, frequency);
                    for (i, row) in expected.iter().enumerate() {
                        let largest = row.iter().fold(0.0_f64, |most, value| most.max(value.norm()));
                        let difference = (own[(i, j)] - row[k]).norm() / largest;
                        assert!(difference < 1e-10, "{word} {input} {i} {frequency}: {difference:e}");
                    }
                }
            }
        }
    }
}

#[test]
fn files_of_all_kinds_give_a_model_or_are_refused_by_name() {
    let read = |name: &str| {
        std::fs::read(repository().join("fixtures/golden").join(name)).expect("a file of the format")
    };
    let model = |bytes: &[u8], options: SceneOptions, inputs: &[&str], outputs: &[&str]| {
        let file = File::parse(bytes).expect("a file");
        StateSpace::new(&file, &options, &request(inputs, outputs))
    };
    let default = SceneOptions::default();
    let exact = SceneOptions { structure: StructureChoice::Exact, ..default };
    // Dashpots couple the modes; the continuous and the discrete model belong together.
    let coupled = model(&read("dashpots.vdm"), default, &[], &[]).expect("a model");
    let damping = |i: usize, j: usize| coupled.a[(coupled.modes.len() + i, coupled.modes.len() + j)];
    assert!((0..2).any(|i| damping(i, 1 - i) != 0.0), "the modes are coupled");
    let power = exponential(&(&coupled.a * faer::Scale(coupled.time_step)));
    assert!((power - &coupled.ad).norm_max() < 1e-9 * coupled.ad.norm_max());
    // A time scheme: the exact steps of the same modes, where they are asked for.
    let bytes = read("fixed-f64.vdm");
    let refused = model(&bytes, default, &[], &[]);
    assert!(matches!(refused, Err(StateSpaceError::NotExact { structure: "diagonal", .. })), "{refused:?}");
    let found = model(&bytes, exact, &[], &[]).expect("a model");
    assert!(found.notes.iter().any(|note| note.contains("`run --structure exact`")), "{:?}", found.notes);
    // A parametric model at values of its parameters.
    let bytes = read("parametric.vdm");
    let file = File::parse(&bytes).expect("a file");
    let live = file.parameters().next().expect("a parameter");
    let first = |value: f64| {
        let set = ParameterValue { name: live.name.to_string(), value };
        let body = at_values(&file, &[set], None).expect("a body").expect("parametric");
        model(&body.bytes, default, &[], &[]).expect("a model").modes[0][0]
    };
    assert!(first(live.lower) < first(live.upper), "`{}` stiffens the body", live.name);
    // The elastic motion of a free body.
    let found = model(&read("free.vdm"), default, &[], &[]).expect("a model");
    assert!(found.notes[0].contains("elastic motion alone"), "{:?}", found.notes);
    for (name, options, words) in [
        ("canonical.vdm", default, "the chapter's representation"),
        ("bent.vdm", default, "large displacements"),
        ("parameters.vdm", default, "without `representation = \"separated\"`"),
        ("separation.vdm", exact, "without `representation = \"separated\"`"),
    ] {
        let refused = model(&read(name), options, &[], &[]).expect_err(name).to_string();
        assert!(refused.contains(words), "{name}: {refused}");
    }
}

#[test]
fn signals_that_a_file_does_not_have_are_refused() {
    let bytes = std::fs::read(repository().join("fixtures/golden/stress.vdm")).expect("a file");
    let file = File::parse(&bytes).expect("a file");
    let refused = |inputs: &[&str], outputs: &[&str]| {
        let model = StateSpace::new(&file, &SceneOptions::default(), &request(inputs, outputs));
        model.expect_err("refused").to_string()
    };
    for (inputs, outputs, words) in [
        (vec!["pull", "pull"], vec!["x"], "the input `pull` is given twice"),
        (vec!["pull"], vec!["x", "displacement:x"], "the output `x` is given twice"),
        (vec!["push"], vec!["x"], "no load pattern or probe at a loadable node `push`"),
        (vec!["pull"], vec!["velocity:tip"], "no probe `tip`"),
        (vec!["pull"], vec!["reaction:foot"], "no reaction of support `foot`; known: none"),
    ] {
        let found = refused(&inputs, &outputs);
        assert!(found.contains(words), "{found}");
    }
    let bytes = std::fs::read(repository().join("fixtures/golden/reactions.vdm")).expect("a file");
    let file = File::parse(&bytes).expect("a file");
    let of = |outputs: &[&str]| StateSpace::new(&file, &SceneOptions::default(), &request(&[], outputs));
    assert!(matches!(of(&["stress:0,0,0,xx"]), Err(StateSpaceError::NoStress)));
    let refused = of(&["reaction:left.fq"]).expect_err("refused").to_string();
    assert!(refused.contains("`left.fq`; known: `left`"), "{refused}");
    assert_eq!(of(&["reaction:left.mz"]).expect("a model").outputs[0].name, "reaction.left.mz");
    assert_eq!(of(&["reaction:left"]).expect("a model").outputs.len(), 6);
}

#[test]
fn a_node_of_two_regions_has_no_stress_of_its_own() {
    let upper = "[[mesh.region]]\nname = \"upper\"\non = { box = { min = [-1.0, -1.0, 0.09], max = [1.0, 1.0, 1.0] } }\n";
    let stiff = "[[material]]\nregion = \"upper\"\nyoung = 2e7\npoisson = 0.3\ndensity = 1200.0\n";
    let bytes = built(&TOWER.replacen("[[material]]\n", &format!("{upper}{stiff}[[material]]\n"), 1));
    let file = File::parse(&bytes).expect("a file");
    let of =
        |output: &str| StateSpace::new(&file, &SceneOptions::default(), &request(&["gravity"], &[output]));
    let refused = of("stress:0.2,0.1,0.1,zz").expect_err("refused");
    assert!(matches!(refused, StateSpaceError::BetweenRegions { .. }), "{refused}");
    assert_eq!(of("stress:0.2,0.1,0,zz").expect("a model").outputs[0].unit, "Pa");
}

#[test]
fn the_command_writes_the_same_numbers_in_every_format() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(path("tower.toml"), format!("{TOWER}[damping]\nbeta = 1e-4\n")).expect("written");
    assert_eq!(vademecum(&["build", &path("tower.toml"), "-o", &path("tower.vdm")]).code, Some(0));
    let (file, out) = (path("tower.vdm"), path("model"));
    let asked = |more: &[&str]| vademecum(&[&["export", "state-space", &file, "-o", &out], more].concat());
    let signals =
        ["--in", "0.2,0.05,0.45,-x", "--in", "base.ax", "--out", "top", "--out", "acceleration:top"];
    let ran = asked(&signals);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(ran.stdout.contains("26 states, step 0.0009765625 s"), "{}", ran.stdout);
    assert!(ran.stdout.contains("input 2: base.ax [m/s²]\noutput 1: top [m]\n"), "{}", ran.stdout);
    let bytes = std::fs::read(&file).expect("a file");
    let opened = File::parse(&bytes).expect("a file");
    let own = request(&[signals[1], signals[3]], &[signals[5], signals[7]]);
    let model = StateSpace::new(&opened, &SceneOptions::default(), &own).expect("a model");
    let read = |name: &str| std::fs::read(folder.path().join("model").join(name)).expect("a file");
    let (npz, mat) = (read("state-space.npz"), read("state-space.mat"));
    for (name, matrix) in model.dense() {
        let numbers: Vec<u8> = matrix.data.iter().flat_map(|x| x.to_le_bytes()).collect();
        let holds = |file: &[u8]| file.windows(numbers.len()).any(|window| window == numbers);
        assert!(holds(&npz) && holds(&mat), "{name}");
        if name == "time_step" {
            continue;
        }
        let text = String::from_utf8(read(&format!("{name}.mtx"))).expect("a text");
        let (head, rest) = text.split_once('\n').expect("lines");
        assert_eq!(head, "%%MatrixMarket matrix array real general");
        let (size, rest) = rest.split_once('\n').expect("a size");
        assert_eq!(size, format!("{} {}", matrix.rows, matrix.columns));
        let parsed: Vec<f64> = rest.lines().map(|line| line.parse().expect("a number")).collect();
        assert_eq!(parsed, matrix.data, "{name}");
    }
    let text = String::from_utf8(read("state-space.json")).expect("a text");
    let described: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(described["states"][24]["name"], "filtered (0.2 0.05 0.45) along (-1 0 0)");
    assert_eq!(described["outputs"][1], serde_json::json!({ "name": "acceleration:top", "unit": "m/s²" }));
    assert_eq!(described["matrices"][0], serde_json::json!({ "name": "A", "rows": 26, "columns": 26 }));
    // Two runs give the same bytes, and another step its own map.
    let again = asked(&signals);
    assert_eq!(again.code, Some(0), "{}", again.stderr);
    assert!(read("state-space.npz") == npz && read("state-space.mat") == mat);
    let ran = asked(&[&signals[..], &["--time-step", "5e-4", "--json"]].concat()).json();
    assert_eq!((&ran["time_step"], &ran["states"]), (&5e-4.into(), &26.into()));
    assert!(read("state-space.npz") != npz);
    asked(&["--out", "tip"]).fails(2, &["no probe `tip`", "a channel is X,Y,Z,DIRECTION"]);
    asked(&["--out", "stress:0,0,xx"]).fails(2, &["`stress:0,0,xx` is no output"]);
    asked(&["--structure", "block"]).fails(7, &["tower.vdm", "`run --structure exact`"]);
    asked(&["--in", "0.2,0.05,0.45,-x", "--in", "0.2,0.05,0.45,-x"]).fails(2, &["is given twice"]);
}

/// `e^M` by its series on a fraction of the matrix, squared.
fn exponential(matrix: &Mat<f64>) -> Mat<f64> {
    let n = matrix.nrows();
    let halvings = 12;
    let small = matrix * faer::Scale(0.5_f64.powi(halvings));
    let (mut sum, mut term) = (Mat::<f64>::identity(n, n), Mat::<f64>::identity(n, n));
    for k in 1..20 {
        term = &term * &small * faer::Scale(1.0 / f64::from(k));
        sum += &term;
    }
    (0..halvings).fold(sum, |power, _| &power * &power)
}
