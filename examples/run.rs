//! Runs every example as a reader does, and checks what it prints. Times are printed and not checked.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// What an example prints.
fn output(name: &str) -> String {
    // With the libraries that the tests of the workspace have: by itself, it would have them compiled anew.
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["build", "--quiet", "--workspace", "--example", name]);
    if !cfg!(debug_assertions) {
        cargo.arg("--release");
    }
    assert!(cargo.status().expect("cargo").success(), "{name} does not build");
    let running = std::env::current_exe().expect("the test's own path");
    let folder = running.ancestors().nth(2).expect("a profile folder").join("examples");
    let ran = Command::new(folder.join(name)).output().expect("the example");
    assert!(ran.status.success(), "{name}: {}", String::from_utf8_lossy(&ran.stderr));
    String::from_utf8(ran.stdout).expect("UTF-8")
}

/// The line that starts so.
fn line<'a>(output: &'a str, start: &str) -> &'a str {
    let found = output.lines().find(|line| line.starts_with(start));
    found.unwrap_or_else(|| panic!("no line starts with `{start}`:\n{output}"))
}

/// All numbers in a line.
fn numbers(line: &str) -> Vec<f64> {
    let words = line.split([' ', ',', ';', ':']);
    words.filter_map(|word| word.parse().ok()).collect()
}

/// `found` lies within `share` of `expected`.
fn near(found: f64, expected: f64, share: f64) {
    assert!((found / expected - 1.0).abs() <= share, "{found}, expected {expected}");
}

#[test]
fn haptic_loop_pushes_what_pushes_back() {
    let output = output("haptic_loop");
    let [ticks, _, push, deepest] = numbers(line(&output, "1000 ticks"))[..] else { panic!("{output}") };
    assert_eq!(ticks, 1000.0);
    // The finger dips 4 mm at most and pushes with 5 N per mm of what the body does not give way: below 20 N.
    // The beam is two orders stiffer than the finger and gives way by less than a tenth of the dip.
    assert!((18.0..20.0).contains(&push), "{push}");
    assert!((0.0..0.4).contains(&deepest) && deepest > 0.0, "{deepest}");
    assert!(line(&output, "woke up late by").contains("worst"));
}

#[test]
fn press_a_sphere_never_goes_in() {
    let output = output("press_a_sphere");
    let [_, push, inside] = numbers(line(&output, "600 steps"))[..] else { panic!("{output}") };
    // As a static push of 2 mm on a cantilever at half its length: 3 E I / L³ of 112 N/mm, and ringing.
    assert!((224.0..2000.0).contains(&push), "{push}");
    assert!(inside <= 1e-6, "{inside}");
    assert!(output.contains("sticks") && output.contains("slips") && output.contains("open"));
}

#[test]
fn grip_a_cube_lifts_it() {
    let output = output("grip_a_cube");
    let rows: Vec<Vec<f64>> = output
        .lines()
        .skip(1)
        .map(|row| row.split_whitespace().filter_map(|word| word.parse().ok()).collect())
        .collect();
    assert_eq!(rows.len(), 10, "{output}");
    // Time, height, force of a finger, contacts: on the floor at first, lifted by 0.1 m at the end.
    let (first, last) = (&rows[0], &rows[9]);
    assert!(first[1].abs() < 1.0 && (95.0..101.0).contains(&last[1]), "{output}");
    assert!(last[2] > 0.5 && last[3] >= 8.0, "{output}");
}

#[test]
fn throw_a_fork_tumbles_and_rings() {
    let output = output("throw_a_fork");
    let [pitch, first, amplitude] = numbers(&line(&output, "rings at").replace("Hz", ""))[..] else {
        panic!("{output}")
    };
    // Some crossings are early or late by a step of 20 µs in 0.6 s.
    near(pitch, first, 2e-3);
    assert!((0.05..1.0).contains(&amplitude), "{amplitude} mm");
    let [times] = numbers(line(&output, "turned over"))[..] else { panic!("{output}") };
    assert!(times >= 2.0, "{times}");
    let [momentum, turning] = numbers(&line(&output, "momentum kept").replace("to ", ""))[..] else {
        panic!("{output}")
    };
    assert!(momentum < 1e-10 && turning < 1e-10, "{output}");
}

#[test]
fn mattress_gives_way_under_whoever_lies_on_it() {
    let output = output("mattress");
    let found = line(&output, "1000 springs");
    let [count, moving, rest, deepest] = numbers(found)[..] else { panic!("{output}") };
    assert_eq!([count, moving + rest], [1000.0; 2]);
    let pressed = output.lines().take(10).flat_map(str::chars).filter(char::is_ascii_digit).count();
    assert!(pressed > 100 && rest > 500.0, "{pressed} of the picture, {rest} at rest");
    // F L / (E A) of 4 N is 10 mm; eight modes show most of it.
    assert!((7.0..12.0).contains(&deepest), "{deepest} mm");
}

#[test]
fn many_props_move_each_on_its_own() {
    let output = output("many_props");
    assert_eq!(line(&output, "512 props"), "512 props: 384 move, 128 rest, 0 refused");
    let [_, ratio, _, _, still] = numbers(line(&output, "prop 301"))[..] else { panic!("{output}") };
    // Single precision: 250 steps, each rounded to 6e-8.
    near(ratio, 301.0, 1e-4);
    assert_eq!(still, 0.0);
}

#[test]
fn live_slider_rings_faster_by_the_root_of_two() {
    let output = output("live_slider");
    assert_eq!(line(&output, "slider"), "slider `stiffness`: 0.5 to 2, at first 1");
    let [soft, stiff, ratio] = numbers(line(&output, "rings"))[..] else { panic!("{output}") };
    // Bathe's scheme lengthens the period by 7e-4 at 47 steps per period and twice that at 33; higher modes
    // move the crossings.
    near(soft, 21.17, 1e-2);
    near(ratio, 2.0_f64.sqrt(), 1e-2);
    assert!(stiff > soft);
}

#[test]
fn static_buffers_hold_the_file() {
    let output = output("static_buffers");
    let [moved] = numbers(line(&output, "after 10 steps"))[1..] else { panic!("{output}") };
    assert!(moved < 0.0, "a push down moves down");
    let [needed] = numbers(line(&output, "it needs: "))[..] else { panic!("{output}") };
    assert!(needed <= 256.0, "the array of the example holds the file");
}

#[test]
fn own_matrices_have_the_frequencies_of_the_chain() {
    let output = output("own_matrices");
    for mode in 1..=3 {
        let [_, found, exact, _] = numbers(line(&output, &format!("mode {mode}")))[..] else {
            panic!("{output}")
        };
        // Ritz values err by the square of what the snapshots leave out of the lowest modes.
        near(found, exact, 1e-6);
    }
    let [end, exact, _] = numbers(line(&output, "the pulled end"))[..] else { panic!("{output}") };
    // Of a string, r modes carry 8/π² Σ 1/(2j − 1)² of the stretch: all but 2.5 % for r = 8.
    assert!(end < exact);
    near(end, exact, 0.025);
}

#[test]
fn unpack_packed_steps_what_was_packed() {
    let output = output("unpack_packed");
    let packed = line(&output, "40");
    let [raw, exact, _, rounded] = numbers(packed)[..] else { panic!("{packed}") };
    assert!(rounded < exact && exact < raw, "{packed}");
    let whole = *numbers(line(&output, "unpacked")).last().expect("a number");
    let after = *numbers(line(&output, "after rounding")).last().expect("a number");
    near(after, whole, 1e-3);
}

#[test]
fn import_snapshots_finds_the_first_frequency() {
    let output = output("import_snapshots");
    let own = numbers(line(&output, "its own 12 runs"));
    let theory = numbers(line(&output, "beam theory"));
    let [modes, frequency, error] = theory[..] else { panic!("{output}") };
    assert_eq!(modes, 6.0);
    near(frequency, own[2], 1e-3);
    // Shapes of another theory are good for the low modes; the certificate says how good.
    assert!(error < 1e-2, "{error}");
}

#[test]
fn shaken_tower_has_the_shear_that_the_spectrum_says() {
    let output = output("shaken_tower");
    let [ground, seconds] = numbers(line(&output, "ground"))[..] else { panic!("{output}") };
    assert!((0.25..0.35).contains(&ground) && seconds == 12.0, "{output}");
    let [shear, moment] = numbers(line(&output, "foot"))[..] else { panic!("{output}") };
    let [period, of_mode] = numbers(line(&output, "first mode"))[..] else { panic!("{output}") };
    // The first mode takes most of it; the mass above that moves with the ground adds at most 0.31 g of it.
    assert!(of_mode < shear && shear < of_mode + 0.31 * 9.81 * 1.6, "{output}");
    // It acts at about two thirds of the height.
    assert!((0.5..0.8).contains(&(moment / shear / 4.0)), "{output}");
    // A clamped beam with E I of 8.33 MN m² and 400 kg/m: 3.516/2π √(E I/m)/l² is 5.04 Hz.
    near(period, 1.0 / 5.04, 0.02);
    // A stiff oscillator goes with the ground.
    let [_, stiff] = numbers(line(&output, "0.05"))[..] else { panic!("{output}") };
    assert!(stiff >= ground && stiff < 3.0 * ground, "{output}");
    let page =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/how-to/moving-base.md"));
    let page = page.expect("the page");
    let (_, said) = page.split_once("```text\nground").expect("what it prints");
    let said = format!("ground{}", said.split("```").next().expect("closed"));
    assert_eq!(said, output, "docs/how-to/moving-base.md prints something else");
}

#[test]
fn every_example_is_listed_and_run() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).expect("a file");
    let (manifest, pages, tests) =
        (read("Cargo.toml"), [read("README.md"), read("../README.md")], read("run.rs"));
    let files = std::fs::read_dir(folder).expect("a folder");
    let files = files
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension() == Some("rs".as_ref()));
    let names: BTreeSet<String> =
        files.map(|path| path.file_stem().expect("a name").to_string_lossy().into_owned()).collect();
    assert!(names.len() > 7);
    for name in names.iter().filter(|name| *name != "run") {
        assert!(manifest.contains(&format!("name = \"{name}\"")), "{name} is not in Cargo.toml");
        assert!(pages.iter().all(|page| page.contains(&format!("`{name}`"))), "{name} is not on both pages");
        assert!(tests.contains(&format!("output(\"{name}\")")), "{name} is not run");
    }
}
