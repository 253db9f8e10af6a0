//! Frequency response from the modes of a file against complex solves of the full order.

use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::SceneOptions;
use vademecum_format::File;
use vademecum_study::StudyError;
use vademecum_study::frf::{
    Channel, Quantity, ResponseRequest, compare_response, frequencies, frequency_response, polar, with_poles,
};
use vademecum_study::parameters::{self, ParameterValue};
use vademecum_tests::program::vademecum;

const BEAM: &str = r#"
[mesh]
block = { lengths = [1.0, 0.08, 0.1], divisions = [8, 1, 1], order = "quadratic" }
[[mesh.region]]
name = "tip"
on = { fraction = { axis = "x", side = "max", fraction = 0.5 } }
[[material]]
young = 2.1e9
poisson = 0.3
density = 1200.0
[[support]]
on = { group = "x_min" }
[load]
[[load.pattern]]
name = "gravity"
acceleration = [0.0, 0.0, -9.81]
[damping]
alpha = 3.0
beta = 1e-5
[time]
step = 1e-3
[basis]
modes = 16
[tolerance]
error = 1.0
[[output.probe]]
name = "tip"
point = [1.0, 0.08, 0.1]
direction = [0.0, 0.0, 1.0]
"#;

fn problem(more: &str) -> Problem {
    Problem::parse(&format!("{BEAM}{more}"), "beam.toml", PathBuf::new()).expect("a problem")
}

fn built(problem: &Problem) -> Vec<u8> {
    build(problem, &BuildOptions::default(), &Silent).expect("built").either().bytes
}

fn question(quantity: Quantity, last: f64) -> ResponseRequest {
    ResponseRequest {
        input: Channel::Point([0.7, 0.03, 0.1], [0.2, 0.3, -1.0]),
        outputs: vec![
            Channel::Named("tip".into()),
            Channel::Point([0.7, 0.03, 0.1], [0.2, 0.3, -1.0]),
            Channel::Point([0.4, 0.06, 0.1], [0.0, 0.0, 2.0]),
        ],
        frequencies: frequencies([2.0, last], 50, true),
        quantity,
    }
}

#[test]
fn modes_and_what_they_leave_out_answer_as_the_full_order_does() {
    let problem = problem("");
    let bytes = built(&problem);
    let file = File::parse(&bytes).expect("a file");
    let options = SceneOptions::default();
    let highest = frequency_response(&file, &options, &question(Quantity::Displacement, 10.0));
    let half = 0.5 * highest.expect("a response").highest_mode_hz;
    for quantity in [Quantity::Displacement, Quantity::Velocity] {
        let asked = question(quantity, half);
        let error = compare_response(&file, &options, &asked, (&problem, &[]), &Silent).expect("compared");
        assert!(error.frequencies == 50 && error.rms < 1e-3, "{quantity:?}: {error:?}");
        assert!(error.rms_by_modes > error.rms, "{error:?}");
    }
    // A pattern that swings.
    let asked =
        ResponseRequest { input: Channel::Named("gravity".into()), ..question(Quantity::Displacement, half) };
    let error = compare_response(&file, &options, &asked, (&problem, &[]), &Silent).expect("compared");
    assert!(error.rms < 1e-3, "{error:?}");
}

#[test]
fn live_parameters_move_the_response() {
    let live = r#"
[[parameter]]
name = "all"
kind = "stiffness"
range = [0.5, 2.0]
[[parameter]]
name = "damping"
kind = "beta"
range = [1e-6, 1e-4]
"#;
    let problem = problem(live);
    let bytes = built(&problem);
    let file = File::parse(&bytes).expect("a file");
    let set = |name: &str, value: f64| ParameterValue { name: name.into(), value };
    for values in [[set("all", 0.5), set("damping", 1e-4)], [set("all", 2.0), set("damping", 2e-6)]] {
        let mut options = SceneOptions::default();
        parameters::set(&mut options, file.metadata(), &values).expect("known");
        let asked = question(Quantity::Displacement, 300.0);
        let error = compare_response(&file, &options, &asked, (&problem, &[]), &Silent).expect("compared");
        assert!(error.rms < 1e-3, "{values:?}: {error:?}");
    }
}

#[test]
fn a_live_region_turns_the_modes() {
    let live = r#"
[[parameter]]
name = "tip stiffness"
kind = "stiffness"
region = "tip"
range = [0.5, 2.0]
scale = "log"
"#;
    let separated = format!("representation = \"separated\"\n{BEAM}{live}");
    let problem = Problem::parse(&separated, "beam.toml", PathBuf::new()).expect("a problem");
    let bytes = built(&problem);
    let file = File::parse(&bytes).expect("a file");
    for value in [0.5, 1.0, 2.0] {
        let mut options = SceneOptions::default();
        let set = ParameterValue { name: "tip stiffness".into(), value };
        parameters::set(&mut options, file.metadata(), &[set]).expect("known");
        let asked = question(Quantity::Displacement, 100.0);
        let error = compare_response(&file, &options, &asked, (&problem, &[]), &Silent).expect("compared");
        assert!(error.rms < 1e-2, "{value}: {error:?}");
    }
}

#[test]
fn quantities_differ_by_powers_of_the_frequency() {
    let bytes = built(&problem(""));
    let file = File::parse(&bytes).expect("a file");
    let of = |quantity| {
        let asked = ResponseRequest { frequencies: vec![13.0], ..question(quantity, 100.0) };
        frequency_response(&file, &SceneOptions::default(), &asked).expect("a response").values[0][0]
    };
    let [u, v, a] = [Quantity::Displacement, Quantity::Velocity, Quantity::Acceleration].map(of);
    let omega = std::f64::consts::TAU * 13.0;
    assert!((v.re + omega * u.im).abs() + (v.im - omega * u.re).abs() < 1e-12 * v.norm());
    assert!((a.re + omega * v.im).abs() + (a.im - omega * v.re).abs() < 1e-12 * a.norm());
    let (amplitude, phase) = polar(&[u]).next().expect("one");
    assert!((amplitude - u.norm()).abs() < 1e-15 && (-180.0..=180.0).contains(&phase));
    let ratios = frequencies([1.0, 100.0], 3, true);
    assert!((ratios[1] - 10.0).abs() < 1e-12 && ratios[2] == 100.0);
    assert_eq!(frequencies([1.0, 3.0], 3, false), [1.0, 2.0, 3.0]);
}

#[test]
fn the_command_writes_a_table_and_a_picture_and_names_what_it_does_not_know() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(path("beam.toml"), BEAM).expect("written");
    assert_eq!(vademecum(&["build", &path("beam.toml"), "-o", &path("beam.vdm")]).code, Some(0));
    let (file, table, plot) = (path("beam.vdm"), path("t.csv"), path("t.svg"));
    let asked = |more: &[&str]| {
        let line = ["frf", &file, "--in", "1,0.04,0.1,-z", "--out", "tip", "--range", "1,500"];
        vademecum(&[&line[..], more].concat())
    };
    let ran = asked(&[
        "--points",
        "11",
        "-o",
        &table,
        "--plot",
        &plot,
        "--problem",
        &path("beam.toml"),
        "--compare",
        "3",
    ]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(
        ran.stdout.contains("against complex solves of the full order at 3 frequencies"),
        "{}",
        ran.stdout
    );
    let rows = std::fs::read_to_string(&table).expect("a table");
    // Eleven, and three for the pole and the half-power points of each mode below 500 Hz.
    let count = rows.lines().count() - 1;
    assert!(count > 11 && count % 3 == 11 % 3, "{count}");
    let json = asked(&["--points", "11", "--no-poles", "--json"]).json();
    assert_eq!(json["frequencies_hz"].as_array().map(Vec::len), Some(11));
    assert_eq!(rows.lines().next(), Some("frequency_hz,re tip [m/N],im tip [m/N]"));
    let numbers: Vec<f64> =
        rows.lines().nth(3).expect("a row").split(',').map(|x| x.parse().expect("a number")).collect();
    let json = asked(&["--points", "11", "--json"]).json();
    assert_eq!(json["frequencies_hz"][2].as_f64(), Some(numbers[0]));
    assert_eq!(json["values"][0][2][0].as_f64(), Some(numbers[1]));
    assert!(std::fs::read_to_string(&plot).expect("a picture").starts_with("<svg"));
    asked(&["--out", "tap"]).fails(2, &["no probe `tap`", "`tip`"]);
    // Millimetres where the file has metres.
    let far = ["the point (1000.000000, 40.000000, 100.000000)", "unit of the file"];
    asked(&["--out", "1000,40,100,z"]).fails(2, &far);
    // A negative number is no option.
    asked(&["--out", "-1000,40,100,z"]).fails(2, &["the point (-1000.000000, 40.000000, 100.000000)"]);
    let wrong = vademecum(&["frf", &file, "--in", "1000,40,100,z", "--out", "tip", "--range", "1,500"]);
    wrong.fails(2, &far);
    asked(&["--out", "1,2"]).fails(2, &["`1,2` is no channel"]);
    asked(&["--out", "1,2,3,0,0,0"]).fails(2, &["is no channel"]);
    // A force along a probe is a force at its node.
    let by = |input: &str| {
        vademecum(&[
            "frf", &file, "--in", input, "--out", "tip", "--range", "1,500", "--points", "11", "--json",
        ])
        .json()
    };
    assert_eq!(by("tip")["values"], by("1,0.08,0.1,z")["values"]);
    let drawn = asked(&["--points", "11", "--plot", &path("t.pdf")]);
    assert_eq!(drawn.code, Some(0), "{}", drawn.stderr);
    assert!(std::fs::read(path("t.pdf")).expect("a picture").starts_with(b"%PDF"));
    let wrong = vademecum(&["frf", &file, "--in", "none", "--out", "tip", "--range", "1,500"]);
    wrong.fails(2, &["no load pattern or probe at a loadable node `none`", "`gravity`", "X,Y,Z,DIRECTION"]);
    let wrong = vademecum(&["frf", &file, "--in", "gravity", "--out", "tip", "--range", "5,1"]);
    wrong.fails(2, &["`5,1` is no range"]);
}

#[test]
fn damping_ratios_are_not_compared_with_a_matrix() {
    let text = BEAM.replace("alpha = 3.0\nbeta = 1e-5", "ratio = 0.02");
    let problem = Problem::parse(&text, "beam.toml", PathBuf::new()).expect("a problem");
    let bytes = built(&problem);
    let file = File::parse(&bytes).expect("a file");
    let options = SceneOptions::default();
    let asked = question(Quantity::Displacement, 100.0);
    let error = compare_response(&file, &options, &asked, (&problem, &[]), &Silent);
    assert!(matches!(error, Err(StudyError::ModalDamping)), "{error:?}");
    // At the first peak a mode of damping ratio ζ answers 1/(2ζ) times as much as at rest.
    let of = |frequency: f64| {
        let asked = ResponseRequest { frequencies: vec![frequency], ..asked.clone() };
        frequency_response(&file, &options, &asked).expect("a response").by_modes[0][0].norm()
    };
    let peak = (0..4000).map(|i| of(15.0 + 0.005 * f64::from(i))).fold(0.0, f64::max);
    assert!((peak / of(1e-3) / 25.0 - 1.0).abs() < 0.05, "{peak} {}", of(1e-3));
}

/// A stocky block whose modes above the sixteenth matter.
const BLOCK: &str = r#"
[mesh]
block = { lengths = [0.2, 0.1, 0.1], divisions = [6, 3, 3] }
[[material]]
young = 1e5
poisson = 0.4
density = 1000.0
[[support]]
on = { group = "x_min" }
[damping]
beta = BETA
[time]
step = 1e-3
[basis]
modes = 16
[tolerance]
error = 1.0
[[parameter]]
name = "beta"
kind = "beta"
range = [0.0, 2e-2]
"#;

#[test]
fn the_truncated_modes_follow_a_force_with_the_time_constant_of_the_damping() {
    let text = |beta: &str| BLOCK.replace("BETA", beta);
    let built = |text: &str| {
        let problem = Problem::parse(text, "block.toml", PathBuf::new()).expect("a problem");
        (built(&problem), problem)
    };
    let compared = |(bytes, problem): &(Vec<u8>, Problem), beta: Option<f64>| {
        let file = File::parse(bytes).expect("a file");
        let options = SceneOptions { beta, ..SceneOptions::default() };
        let at = Channel::Point([0.2, 0.05, 0.05], [0.3, 0.4, -1.0]);
        let mut asked = ResponseRequest {
            input: at.clone(),
            outputs: vec![at],
            frequencies: vec![1.0],
            quantity: Quantity::Displacement,
        };
        let found = frequency_response(&file, &options, &asked).expect("a response");
        assert!(found.by_modes_alone.is_empty());
        asked.frequencies = frequencies([1.0, 0.5 * found.highest_mode_hz], 25, false);
        compare_response(&file, &options, &asked, (problem, &[]), &Silent).expect("compared")
    };
    let none = built(&text("0.0"));
    let undamped = compared(&none, None);
    // What a static `R` leaves out is of second order in the frequency over that of the truncated modes.
    assert!(undamped.rms < 0.1 * undamped.rms_by_modes, "{undamped:?}");
    for beta in ["3e-3", "1e-2"] {
        let own = compared(&built(&text(beta)), None);
        // Damping lowers the response to which the differences are relative, at most by the amplification of
        // the peaks; a constant `R` is off by 1.7e-2 and 1.1e-1 here.
        assert!(own.rms < 4.0 * undamped.rms, "beta {beta}: {own:?} beside {undamped:?}");
        let live = compared(&none, Some(beta.parse().expect("a number")));
        assert!((live.rms / own.rms - 1.0).abs() < 1e-3, "live beta {beta}: {live:?} beside {own:?}");
    }
}

#[test]
fn between_two_points_the_static_remainder_comes_from_the_factor_or_is_said_to_be_missing() {
    let at = |x: f64| Channel::Point([x, 0.03, 0.1], [0.2, 0.3, -1.0]);
    let compared = |more: &str| {
        let problem = problem(more);
        let bytes = built(&problem);
        let file = File::parse(&bytes).expect("a file");
        let options = SceneOptions::default();
        let outputs = vec![at(0.3), at(0.7)];
        let asked = ResponseRequest {
            input: at(0.7),
            outputs,
            frequencies: frequencies([2.0, 200.0], 20, true),
            quantity: Quantity::Displacement,
        };
        let alone = frequency_response(&file, &options, &asked).expect("a response").by_modes_alone;
        let asked = ResponseRequest { outputs: vec![at(0.3)], ..asked };
        (compare_response(&file, &options, &asked, (&problem, &[]), &Silent).expect("compared"), alone)
    };
    let (error, alone) = compared("");
    assert!(alone == [0] && error.rms == error.rms_by_modes, "{error:?} {alone:?}");
    let (error, alone) = compared("[output]\nstatic_fields = true\n");
    assert!(alone.is_empty() && error.rms < 0.2 * error.rms_by_modes, "{error:?} {alone:?}");
}

#[test]
fn the_largest_amplitude_is_that_of_the_peak_whatever_the_frequencies_are() {
    let text = BEAM.replace("alpha = 3.0\nbeta = 1e-5", "ratio = 5e-4");
    let bytes = built(&Problem::parse(&text, "beam.toml", PathBuf::new()).expect("a problem"));
    let file = File::parse(&bytes).expect("a file");
    let options = SceneOptions::default();
    let of = |frequencies: Vec<f64>| {
        let asked = ResponseRequest { frequencies, ..question(Quantity::Displacement, 100.0) };
        frequency_response(&file, &options, &asked).expect("a response")
    };
    let even = frequencies([1.0, 500.0], 100, false);
    let found = of(with_poles(&file, &options, even.clone()).expect("poles"));
    let coarse = of(even);
    for (output, peak) in found.peaks.iter().enumerate() {
        let peak = peak.expect("a damped body");
        // Around the peak, a ten-thousandth of its width apart.
        let width = 1e-3 * peak.frequency_hz;
        let near = [peak.frequency_hz - width, peak.frequency_hz + width];
        let sampled = of(frequencies(near, 20_001, false));
        let largest = polar(&sampled.values[output]).map(|(a, _)| a).fold(0.0, f64::max);
        assert!((peak.amplitude / largest - 1.0).abs() < 1e-6, "{peak:?} {largest}");
        let seen = polar(&coarse.values[output]).map(|(a, _)| a).fold(0.0, f64::max);
        assert!(seen < 0.5 * peak.amplitude, "{seen} {peak:?}");
    }
}

/// A mode without damping answers without bound at its frequency: no sampled amplitude is the largest.
#[test]
fn a_body_without_damping_has_no_largest_amplitude_in_a_range_with_a_mode() {
    let undamped = BEAM.replace("alpha = 3.0\nbeta = 1e-5", "alpha = 0.0");
    assert_ne!(undamped, BEAM);
    let problem = Problem::parse(&undamped, "beam.toml", PathBuf::new()).expect("a problem");
    let bytes = built(&problem);
    let file = File::parse(&bytes).expect("a file");
    let of = |range: [f64; 2], count: usize| {
        let frequencies = frequencies(range, count, false);
        let asked = ResponseRequest { frequencies, ..question(Quantity::Displacement, 100.0) };
        frequency_response(&file, &SceneOptions::default(), &asked).expect("a response").peaks
    };
    assert!(of([1.0, 500.0], 100).iter().all(Option::is_none));
    // Below the first mode the amplitude rises to the end of the range, whatever the frequencies are.
    let [few, many] = [5, 5000].map(|count| of([1.0, 2.0], count)[0].expect("a largest amplitude"));
    assert!(
        (few.amplitude / many.amplitude - 1.0).abs() < 1e-12 && few.frequency_hz == 2.0,
        "{few:?} {many:?}"
    );
}
