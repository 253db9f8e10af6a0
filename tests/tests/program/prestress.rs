//! Motion about a loaded state: decks beside CalculiX, problems beside closed forms.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;
use vademecum_tests::program::{Ran, vademecum};
use vademecum_tests::witness::calculix;

/// Cells of the beam.
const CELLS: [usize; 3] = [5, 2, 1];

/// Place on the lattice of half cells.
pub(crate) type Place = [usize; 3];

/// Corners of a cell in the order of a hexahedron.
const CORNERS: [Place; 8] =
    [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [0, 0, 2], [2, 0, 2], [2, 2, 2], [0, 2, 2]];

/// Corners of the elements of one cell, as places among its own, and edges with a node in their middle.
fn split(element: &str) -> (Vec<Vec<usize>>, Vec<[usize; 2]>) {
    let hexahedron = vec![(0..8).collect()];
    let wedges = vec![vec![0, 1, 2, 4, 5, 6], vec![0, 2, 3, 4, 6, 7]];
    let paths = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]];
    let tetrahedra: Vec<Vec<usize>> = paths.map(|path| path.to_vec()).to_vec();
    match element {
        "C3D4" => (tetrahedra, vec![]),
        "C3D10" => (tetrahedra, vec![[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]]),
        "C3D6" => (wedges, vec![]),
        "C3D15" => {
            (wedges, [[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3], [0, 3], [1, 4], [2, 5]].to_vec())
        }
        "C3D20" | "C3D20R" => {
            let edges =
                [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6]];
            (hexahedron, edges.into_iter().chain([[3, 7]]).collect())
        }
        _ => (hexahedron, vec![]),
    }
}

/// Nodes, elements and the sets of the ends of a bent beam of elements of one type, and its nodes.
pub(crate) fn bent(element: &str) -> (String, Vec<(Place, usize)>) {
    let (elements, edges) = split(element);
    let mut ids: BTreeMap<Place, usize> = BTreeMap::new();
    let mut lines = String::new();
    for cell in 0..CELLS.iter().product::<usize>() {
        let at = [cell % CELLS[0], cell / CELLS[0] % CELLS[1], cell / CELLS[0] / CELLS[1]];
        for (part, corners) in elements.iter().enumerate() {
            let place = |k: usize| -> Place { std::array::from_fn(|c| 2 * at[c] + CORNERS[corners[k]][c]) };
            let middle = |[a, b]: &[usize; 2]| std::array::from_fn(|c| (place(*a)[c] + place(*b)[c]) / 2);
            let places: Vec<Place> = (0..corners.len()).map(place).chain(edges.iter().map(middle)).collect();
            let _ = write!(lines, "{}", 1 + cell * elements.len() + part);
            for (k, place) in places.into_iter().enumerate() {
                let next = ids.len() + 1;
                let id = *ids.entry(place).or_insert(next);
                let _ = write!(lines, "{}{id}", if k == 14 { ",\n" } else { "," });
            }
            lines.push('\n');
        }
    }
    let mut by_id: Vec<(Place, usize)> = ids.into_iter().collect();
    by_id.sort_by_key(|&(_, id)| id);
    let mut text = String::from("*NODE,NSET=all\n");
    for (place, id) in &by_id {
        let [x, y, z] = place.map(|p| 0.05 * p as f64);
        let _ = writeln!(text, "{id},{x:.6},{:.6},{:.6}", y + 0.1 * x * x, z + 0.1 * x * y);
    }
    for (name, of) in [("held", 0), ("tip", 2 * CELLS[0])] {
        let own = by_id.iter().filter(|(place, _)| place[0] == of).map(|(_, id)| format!("{id},\n"));
        let _ = write!(text, "*NSET,NSET={name}\n{}", own.collect::<String>());
    }
    // Those at the end, whose fourth face is the end of the beam.
    let last = (1..=CELLS.iter().product())
        .filter(|cell| cell % CELLS[0] == 0)
        .map(|cell: usize| format!("{cell},\n"));
    let last = if elements.len() == 1 {
        format!("*ELSET,ELSET=last\n{}", last.collect::<String>())
    } else {
        String::new()
    };
    (text + &format!("*ELEMENT,TYPE={element},ELSET=beam\n{lines}{last}"), by_id)
}

/// The bent beam with these cards of a static step, and the frequencies about its state.
fn beam(element: &str, loads: &str) -> String {
    bent(element).0
        + &format!(
            "*MATERIAL,NAME=solid\n*ELASTIC\n2e9,0.3\n*DENSITY\n1200.\n\
         *SOLID SECTION,ELSET=beam,MATERIAL=solid\n*BOUNDARY\nheld,1,3\n\
         *STEP\n*STATIC\n{loads}*END STEP\n\
         *STEP,PERTURBATION\n*FREQUENCY\n8\n*END STEP\n"
        )
}

fn frequencies(found: &Value) -> Vec<f64> {
    let list = found["frequencies_hz"].as_array().expect("frequencies");
    list.iter().map(|hz| hz.as_f64().expect("a number")).collect()
}

/// The largest relative difference of frequencies from those of CalculiX, and of their changes by the load.
fn differences(folder: &Path, element: &str, loads: &str) -> [f64; 2] {
    let run = |name: &str, loads: &str| {
        let (job, path) = (format!("{element}-{name}"), folder.join(format!("{element}-{name}.inp")));
        std::fs::write(&path, beam(element, loads)).expect("written");
        let expected = calculix::answer(folder, &job).frequencies;
        let path = path.to_str().expect("a path in UTF-8");
        let found = frequencies(&vademecum(&["modes", path, "--dialect", "calculix", "--json"]).json());
        assert!(expected.len() >= 8 && found.len() >= 8, "{element}: {expected:?} {found:?}");
        [expected, found]
    };
    let ([theirs, ours], [their_own, our_own]) = (run("loaded", loads), run("own", ""));
    let largest = |of: &dyn Fn(usize) -> f64| (0..8).map(|k| of(k).abs()).fold(0.0, f64::max);
    let change = |k: usize| (ours[k] / our_own[k]) / (theirs[k] / their_own[k]) - 1.0;
    [largest(&|k| ours[k] / theirs[k] - 1.0), largest(&change)]
}

/// A pull, a push below the buckling load, a rotation about a skew axis, a pressure that turns with its
/// faces.
const LOADS: [&str; 4] = [
    "*CLOAD\ntip,1,4e3\ntip,2,30.\n",
    "*CLOAD\ntip,1,-200.\n",
    "*DLOAD\nbeam,CENTRIF,2500.,-0.2,0.05,0.01,0.,0.6,0.8\n",
    "*DLOAD\nlast,P4,-20000.\n",
];

#[test]
fn prestressed_frequencies_of_decks_are_those_of_calculix() {
    if !calculix::is_there() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    for element in ["C3D8", "C3D8I", "C3D20", "C3D20R", "C3D4", "C3D10"] {
        // The fourth presses a face of a brick.
        let count = if matches!(element, "C3D4" | "C3D10") { 3 } else { 4 };
        for loads in &LOADS[..count] {
            // CalculiX leaves parts of the rotation out for incompatible modes; seven digits are printed.
            let rotates = element == "C3D8I" && loads.contains("CENTRIF");
            let [found, _] = differences(folder.path(), element, loads);
            println!("{element} {loads:?}: {found:e}");
            assert!(found < if rotates { 1e-4 } else { 1e-6 }, "{element} {loads}: {found:e}");
        }
    }
}

/// CalculiX integrates the mass of wedges at the few points of their stiffness, so that frequencies are
/// others without a load too: the change by the load is compared.
#[test]
fn prestress_changes_frequencies_of_wedges_as_in_calculix() {
    if !calculix::is_there() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    for element in ["C3D6", "C3D15"] {
        for loads in &LOADS[..3] {
            let [own, change] = differences(folder.path(), element, loads);
            println!("{element} {loads:?}: {own:e}, of the change {change:e}");
            assert!(change < 0.05 * own, "{element} {loads}: {change:e}");
        }
    }
}

/// Text of a problem: a beam of this length and thickness, with more tables.
fn problem([length, thickness]: [f64; 2], cells: usize, tables: &str) -> String {
    format!(
        "[mesh]\nblock = {{ lengths = [{length:?}, {thickness:?}, {thickness:?}], divisions = [{cells}, 1, 1] }}\n\
         [[material]]\nyoung = 2e9\npoisson = 0.0\ndensity = 1200.0\n{tables}"
    )
}

fn run(text: &str, arguments: &[&str]) -> Ran {
    let folder: TempDir = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("problem.toml");
    std::fs::write(&path, text).expect("written");
    let mut all = vec![arguments[0], path.to_str().expect("a path in UTF-8")];
    all.extend(&arguments[1..]);
    vademecum(&all)
}

fn modes(text: &str, count: &str) -> Vec<f64> {
    frequencies(&run(text, &["modes", "--count", count, "--json"]).json())
}

/// Supports that let a beam turn at its ends, and pulls along it.
const HINGES: &str = "[[support]]\non = { any = [{ group = \"x_min\" }, { group = \"x_max\" }] }\n\
    components = [\"y\", \"z\"]\n\
    [[support]]\non = { plane = { axis = \"x\", at = 0.5 } }\ncomponents = [\"x\"]\n\
    [[load.pattern]]\nname = \"left\"\non = { group = \"x_min\" }\ntraction = [-1.0, 0.0, 0.0]\n\
    [[load.pattern]]\nname = \"right\"\non = { group = \"x_max\" }\ntraction = [1.0, 0.0, 0.0]\n";

/// A beam on two hinges under a pull `N`: `ω² = (π / L)² (E I (π / L)² + N) / (ρ A)`, so that the pull adds
/// `(π / L)² N / (ρ A)` whatever the mesh makes of the bending: at last the taut string,
/// `f = √(N / (ρ A)) / 2 L`.
#[test]
fn a_taut_string_has_the_pitch_of_its_pull() {
    let (thickness, density) = (0.01_f64, 1200.0_f64);
    let beam = |more: &str| modes(&(problem([1.0, thickness], 40, HINGES) + more), "2");
    let square = |hz: f64| (hz * 2.0 * std::f64::consts::PI).powi(2);
    let bending = beam("");
    for stress in [2e6, 2e7] {
        let found = beam(&format!("[prestress]\nloads = {{ left = {stress:e}, right = {stress:e} }}\n"));
        let added = std::f64::consts::PI.powi(2) * stress / density;
        let share = (square(found[0]) - square(bending[0])) / added - 1.0;
        println!("{stress:e} Pa: {found:?} Hz, {share:e}");
        // The shape of the mode, and turning inertia, of the order of the fourth power of the slenderness.
        assert!(share.abs() < 1e-6, "{stress:e}: {found:?} {share:e}");
        let string = (stress / density).sqrt() / 2.0;
        let stiffer = (square(bending[0]) / added).sqrt();
        assert!(found[0] > string && found[0] < string * (1.0 + stiffer), "{found:?}, not {string}");
    }
}

/// `ω² = ω₀² (1 − N / N_cr)` but for the shape of the mode, and at `N_cr` of Euler's column no motion.
#[test]
fn buckling_is_refused_with_its_factor() {
    let push = "[[support]]\non = { group = \"x_min\" }\n\
                [[load.pattern]]\nname = \"push\"\non = { group = \"x_max\" }\ntraction = [-1.0, 0.0, 0.0]\n";
    let (length, thickness) = (1.0_f64, 0.02_f64);
    // Euler: N = π² E I / (4 L²).
    let critical = std::f64::consts::PI.powi(2) * 2e9 * thickness.powi(2) / 12.0 / (4.0 * length.powi(2));
    let text = |stress: f64| {
        problem([length, thickness], 20, push) + &format!("[prestress]\nloads = {{ push = {stress:e} }}\n")
    };
    let free = modes(&problem([length, thickness], 20, push), "1")[0];
    let near = modes(&text(0.75 * critical), "1")[0];
    // The shape of buckling gives a lower bound, that of the free mode an upper one: ∫φ'² = 4.6478 / L and
    // ∫φ''² = 12.362 / L³ where ∫φ² = L.
    let (share, upper) =
        ((near / free).powi(2), 1.0 - 0.75 * 4.6478 / 12.362 * std::f64::consts::PI.powi(2) / 4.0);
    assert!((0.25..upper).contains(&share), "{share} {upper}");
    let ran = run(&text(4.0 * critical), &["modes"]);
    ran.fails(5, &["prestress", "buckles under 0.25", "more supports"]);
}

/// A blade on a wheel: the frequency across the wheel's plane and in it differ by the softening alone,
/// `ω_out² − ω_in² = Ω²`, and Southwell's line with the coefficient of a thin blade on a hub of no radius,
/// 1.193, gives the first (Bisplinghoff, Ashley and Halfman, *Aeroelasticity*).
#[test]
fn a_rotating_blade_follows_southwell() {
    let held = "[[support]]\non = { group = \"x_min\" }\n";
    let text = |speed: f64| {
        let table =
            format!("[prestress]\nspeed = {speed:?}\naxis = [0.0, 0.0, 1.0]\npoint = [0.0, 0.005, 0.005]\n");
        problem([1.0, 0.01], 20, held) + if speed > 0.0 { &table } else { "" }
    };
    let square = |hz: f64| (hz * 2.0 * std::f64::consts::PI).powi(2);
    let rest = square(modes(&text(0.0), "1")[0]);
    for speed in [3.0_f64, 6.0] {
        let found = modes(&text(speed), "2");
        let [inside, out] = [0, 1].map(|k| square(found[k]));
        let difference = (out - inside) / speed.powi(2) - 1.0;
        let line = (out - rest) / speed.powi(2);
        println!("{speed} rad/s: {found:?} Hz, difference {difference:e}, coefficient {line}");
        // The section turns with the blade: of the order of the square of its slenderness.
        assert!(difference.abs() < 1e-3, "{difference:e}");
        // The line touches the curve at rest from above.
        assert!((1.19..1.1935).contains(&line), "{line}");
    }
}

/// The file, its certificate and `verify` at full order take the same stiffness.
#[test]
fn a_prestressed_file_agrees_with_its_reference() {
    let folder: TempDir = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let [problem_file, file, scenario] = ["string.toml", "string.vdm", "push.toml"].map(at);
    let text = problem([1.0, 0.01], 10, HINGES)
        + "[prestress]\nloads = { left = 2e7, right = 2e7 }\n[damping]\nbeta = 1e-5\n[basis]\nmodes = 48\n\
           [output]\nreactions = true\nstress = \"surface\"\n";
    std::fs::write(&problem_file, text).expect("written");
    let push =
        "duration = 0.05\n[[contact]]\npoint = [0.5, 0.005, 0.01]\nforce = [0.0, 0.0, -1.0]\nend = 0.02\n";
    std::fs::write(&scenario, push).expect("written");
    let built = vademecum(&["build", &problem_file, "-o", &file]);
    assert_eq!(built.code, Some(0), "{}", built.stderr);
    let verified =
        vademecum(&["verify", &file, "--problem", &problem_file, "--scenario", &scenario, "--json"]).json();
    let error = verified["total_error"].as_f64().expect("an error");
    assert!(error < 1e-3, "{verified}");
    let csv = at("response.csv");
    let place = "0.5,0.005,0.01,z";
    let response =
        ["frf", &file, "--in", place, "--out", place, "--range", "1,300", "--problem", &problem_file];
    let found = vademecum(&[&response[..], &["--compare", "20", "--json", "-o", &csv]].concat()).json();
    let rms = found["compared"]["rms"].as_f64().expect("an error");
    assert!(rms < 1e-6, "{}", found["compared"]);
}
