//! Hexahedra, wedges, pyramids and mixed meshes through every command, and decks of other programs whose
//! answers are known.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use vademecum_build::mesh::{ElementKind, Order};
use vademecum_tests::program::vademecum;

/// Corners of a cell, then its middle.
const PLACES: [[f64; 3]; 9] = [
    [0., 0., 0.],
    [1., 0., 0.],
    [1., 1., 0.],
    [0., 1., 0.],
    [0., 0., 1.],
    [1., 0., 1.],
    [1., 1., 1.],
    [0., 1., 1.],
    [0.5, 0.5, 0.5],
];

/// Edges whose middles follow the corners.
fn edges(kind: ElementKind) -> &'static [[usize; 2]] {
    if kind.order() == Order::Quadratic { kind.edges() } else { &[] }
}

type Cell = Vec<(ElementKind, Vec<usize>)>;

fn pyramids(kind: ElementKind) -> Cell {
    let all = [[0, 1, 2, 3], [4, 7, 6, 5], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]];
    all.iter().map(|base| (kind, base.iter().copied().chain([8]).collect())).collect()
}

/// A beam of `n` cells, 1 long and 0.1 thick, as a VTK file.
fn beam(n: usize, cut: impl Fn(usize) -> Cell) -> String {
    let (mut points, mut known) = (String::new(), HashMap::new());
    let (mut cells, mut types, mut numbers) = (String::new(), String::new(), [0; 2]);
    let mut node = |place: [f64; 3]| -> usize {
        let key = place.map(|x| (1e6 * x).round() as i64);
        let next = known.len();
        *known.entry(key).or_insert_with(|| {
            writeln!(points, "{} {} {}", place[0] / n as f64, 0.1 * place[1], 0.1 * place[2]).unwrap();
            next
        })
    };
    for x in 0..n {
        for (kind, corners) in cut(x) {
            let mut places: Vec<[f64; 3]> =
                corners.iter().map(|&c| [x as f64 + PLACES[c][0], PLACES[c][1], PLACES[c][2]]).collect();
            let mean = |of: &[usize], places: &[[f64; 3]]| -> [f64; 3] {
                std::array::from_fn(|i| of.iter().map(|&a| places[a][i]).sum::<f64>() / of.len() as f64)
            };
            let middles: Vec<[f64; 3]> = edges(kind).iter().map(|edge| mean(edge, &places)).collect();
            places.extend(middles);
            if kind == ElementKind::Hex27 {
                let groups: [&[usize]; 7] = [
                    &[0, 3, 4, 7],
                    &[1, 2, 5, 6],
                    &[0, 1, 4, 5],
                    &[2, 3, 6, 7],
                    &[0, 1, 2, 3],
                    &[4, 5, 6, 7],
                    &[0, 1, 2, 3, 4, 5, 6, 7],
                ];
                let more: Vec<[f64; 3]> = groups.iter().map(|group| mean(group, &places)).collect();
                places.extend(more);
            }
            write!(cells, "{}", places.len()).unwrap();
            numbers = [numbers[0] + 1, numbers[1] + 1 + places.len()];
            for place in places {
                write!(cells, " {}", node(place)).unwrap();
            }
            cells.push('\n');
            writeln!(types, "{}", kind.vtk()).unwrap();
        }
    }
    let [count, size] = numbers;
    format!(
        "# vtk DataFile Version 2.0\nbeam\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {} double\n{points}\
         CELLS {count} {size}\n{cells}CELL_TYPES {count}\n{types}",
        known.len()
    )
}

const PROBLEM: &str = r#"
[mesh]
file = "beam.vtk"
[[material]]
young = 1e9
poisson = 0.3
density = 1000.0
[damping]
ratio = 0.01
[[support]]
name = "wall"
on = { plane = { axis = "x", at = 0.0 } }
[[load.pattern]]
name = "end"
on = { plane = { axis = "x", at = 1.0 } }
traction = [0.0, 0.0, 100.0]
[time]
step = 1e-3
[basis]
modes = 8
[tolerance]
error = 1.0
[output]
stress = "surface"
[[output.probe]]
name = "tip"
point = [1.0, 0.1, 0.1]
direction = [0.0, 0.0, 1.0]
"#;

const PUSH: &str = "duration = 0.05\n[[contact]]\npoint = [1.0, 0.05, 0.1]\nforce = [0.0, 0.0, 1.0]\n\
    [[pattern]]\nname = \"end\"\n";

fn meshes() -> Vec<(&'static str, f64, String)> {
    let whole = |kind| move |_: usize| vec![(kind, (0..8).collect::<Vec<usize>>())];
    let wedges = |kind| move |_: usize| vec![(kind, vec![0, 1, 2, 4, 5, 6]), (kind, vec![0, 2, 3, 4, 6, 7])];
    let mixed = |hex, pyramid, wedge| {
        move |x: usize| match x % 4 {
            0 => vec![(wedge, vec![0, 4, 1, 3, 7, 2]), (wedge, vec![1, 4, 5, 2, 7, 6])],
            1 | 3 => vec![(hex, (0..8).collect::<Vec<usize>>())],
            _ => pyramids(pyramid),
        }
    };
    // The first frequency lies within this share of that of a beam, 16.10 Hz: one element is the thickness.
    vec![
        ("hex8", 0.01, beam(12, whole(ElementKind::Hex8))),
        ("hex20", 0.02, beam(8, whole(ElementKind::Hex20))),
        ("hex27", 0.02, beam(8, whole(ElementKind::Hex27))),
        ("wedge15", 0.03, beam(8, wedges(ElementKind::Wedge15))),
        ("pyramid13", 0.03, beam(10, |_| pyramids(ElementKind::Pyramid13))),
        ("mixed, quadratic", 0.03, {
            beam(9, mixed(ElementKind::Hex20, ElementKind::Pyramid13, ElementKind::Wedge15))
        }),
        // Linear triangles and pyramids lock as linear tetrahedra do.
        ("mixed, linear", 1.0, beam(9, mixed(ElementKind::Hex8, ElementKind::Pyramid5, ElementKind::Wedge6))),
    ]
}

#[test]
fn every_kind_is_built_run_verified_and_shown() {
    for (name, off, mesh) in meshes() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name).display().to_string();
        std::fs::write(at("beam.vtk"), mesh).unwrap();
        std::fs::write(at("beam.toml"), PROBLEM).unwrap();
        std::fs::write(at("push.toml"), PUSH).unwrap();
        let (problem, file, scenario) = (at("beam.toml"), at("beam.vdm"), at("push.toml"));
        let modes = vademecum(&["modes", &problem, "--json", "--shapes", &at("shapes")]).json();
        let first = modes["frequencies_hz"][0].as_f64().unwrap();
        assert!((first / 16.10 - 1.0).abs() < off && first > 15.9, "{name}: {first} Hz");
        assert_eq!(vademecum(&["build", &problem, "-o", &file]).code, Some(0), "{name}");
        // All of it can be pushed, but for a node in the middle of the wall.
        let info = vademecum(&["info", &file, "--json"]).json();
        let count = |key: &str| info[key].as_u64().expect("a count");
        let inside = u64::from(name == "hex27");
        assert_eq!(count("loadable_nodes") + inside, count("surface_nodes"), "{name}");
        let ran = vademecum(&["run", &file, "--scenario", &scenario, "-o", &at("out")]);
        assert_eq!(ran.code, Some(0), "{name}: {}", ran.stderr);
        let verified =
            vademecum(&["verify", &file, "--problem", &problem, "--scenario", &scenario, "--json"]).json();
        let error = verified["total_error"].as_f64().unwrap_or(1.0);
        assert!(error < 0.02, "{name}: {verified}");
        let response = vademecum(&[
            "frf",
            &file,
            "--in",
            "end",
            "--out",
            "tip",
            "--range",
            "1,100",
            "-o",
            &at("frf.csv"),
        ]);
        assert_eq!(response.code, Some(0), "{name}: {}", response.stderr);
        assert_eq!(vademecum(&["view", &file, "--export", &at("page.html")]).code, Some(0), "{name}");
        assert_eq!(vademecum(&["report", &file, "-o", &at("report.html")]).code, Some(0), "{name}");
    }
}

/// The folder of decks; skipped where it is absent, except in CI.
fn decks() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/decks");
    if folder.is_dir() {
        return Some(folder);
    }
    assert!(std::env::var_os("CI").is_none(), "CI must have the folder shared/decks beside the repository");
    eprintln!("skipped: there is no folder shared/decks beside the repository");
    None
}

/// Frequencies of a deck with the materials and supports of its cards.
fn frequencies(deck: &Path, rest: &str) -> Vec<f64> {
    let folder = tempfile::tempdir().unwrap();
    let problem = folder.path().join("deck.toml");
    std::fs::write(
        &problem,
        format!("[mesh]\nfile = {:?}\n{rest}[basis]\nmodes = 6\n", deck.display().to_string()),
    )
    .unwrap();
    let modes = vademecum(&["modes", problem.to_str().unwrap(), "--json"]).json();
    let list = |key: &str| modes[key].as_array().unwrap_or_else(|| panic!("no `{key}` in {modes}")).clone();
    list("frequencies_hz").iter().map(|value| value.as_f64().expect("a number")).collect()
}

#[test]
fn decks_have_the_frequencies_of_their_programs() {
    let Some(folder) = decks() else { return };
    let check = |name: &str, rest: &str, expected: &[f64]| {
        let found = frequencies(&folder.join(name), rest);
        assert!(found.len() >= expected.len(), "{name}: {found:?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 2e-6, "{name}: {found} Hz, not {expected} Hz");
        }
    };
    let steel = "[[material]]\nyoung = 2e11\npoisson = 0.3\ndensity = 2900.0\n";
    check("exudyn/blockC3D20.inp", steel, &[449.764, 449.764, 595.757, 1011.616, 1011.616, 1033.232]);
    // Its numbers are millimetres, tonnes and newtons: a thousand times the frequencies in metres.
    let fixed = "[[material]]\nyoung = 2.1e11\npoisson = 0.3\ndensity = 7800.0\n[[support]]\non = { group = \"FIX\" }\n";
    check("calculix/beam8f.inp", fixed, &[13.79813, 19.85205, 81.35676, 88.78712, 109.4461, 163.4036]);
}

#[test]
fn three_corners_of_a_quadrangle_are_no_facet_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(at("beam.vtk"), beam(1, |_| vec![(ElementKind::Hex8, (0..8).collect())])).unwrap();
    for (nodes, code) in [("[1, 2, 5]", 3), ("[1, 2, 5, 6]", 0)] {
        let load = format!("[load]\nsurface = {{ nodes = {nodes} }}\n[[load.pattern]]");
        std::fs::write(at("beam.toml"), PROBLEM.replace("[[load.pattern]]", &load)).unwrap();
        let ran = vademecum(&["build", &at("beam.toml"), "-o", &at("beam.vdm"), "--force"]);
        assert_eq!(ran.code, Some(code), "{}", ran.stderr);
    }
}

/// Components that are held everywhere have no mass to share, and a share that is no number is null in JSON.
#[test]
fn a_direction_in_which_all_is_held_has_an_effective_mass_of_zero() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(at("beam.vtk"), beam(4, |_| vec![(ElementKind::Hex8, (0..8).collect())])).unwrap();
    let plane = "[[support]]\non = { box = { min = [-1.0, -1.0, -1.0], max = [2.0, 1.0, 1.0] } }\ncomponents = [\"y\"]\n";
    std::fs::write(at("beam.toml"), format!("{PROBLEM}{plane}")).unwrap();
    let modes = vademecum(&["modes", &at("beam.toml"), "--json"]).json();
    let masses = modes["effective_mass"].as_array().expect("a list");
    assert!(!masses.is_empty() && masses.iter().all(|mass| mass[1].as_f64() == Some(0.0)), "{modes}");
}

/// A soft beam that moves by three tenths of its length.
const LARGE: &str = r#"
model = "large-displacement"
[mesh]
file = "beam.vtk"
[large]
displacement = 0.3
pushes = 1
[[material]]
young = 1e7
poisson = 0.3
density = 1000.0
hexahedra = "mean-dilatation"
[damping]
alpha = 0.2
[[support]]
on = { plane = { axis = "x", at = 0.0 } }
[time]
step = 0.03
[basis]
modes = 6
[tolerance]
error = 0.1
[[output.probe]]
name = "tip"
point = [1.0, 0.1, 0.1]
direction = [0.0, 0.0, 1.0]
"#;

#[test]
fn large_displacements_of_other_kinds_are_followed_as_those_of_tetrahedra() {
    let whole = |kind| move |_: usize| vec![(kind, (0..8).collect::<Vec<usize>>())];
    let six = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]];
    let tetrahedra = |_| six.iter().map(|e| (ElementKind::Tet10, e.to_vec())).collect();
    let mixed = |x: usize| match x {
        0 => [[0, 4, 1, 3, 7, 2], [1, 4, 5, 2, 7, 6]].map(|e| (ElementKind::Wedge15, e.to_vec())).to_vec(),
        1 => whole(ElementKind::Hex20)(x),
        _ => pyramids(ElementKind::Pyramid13),
    };
    let push = "duration = 1.0\n[[contact]]\npoint = [1.0, 0.05, 0.1]\nforce = [0.0, 0.0, 35.0]\n\
                start = 0.05\nend = 0.5\n";
    let mut of_tetrahedra = None;
    for (name, mesh) in [
        ("tetrahedra", beam(3, tetrahedra)),
        ("hex20", beam(3, whole(ElementKind::Hex20))),
        ("mixed", beam(3, mixed)),
        ("hex8", beam(6, whole(ElementKind::Hex8))),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name).display().to_string();
        std::fs::write(at("beam.vtk"), mesh).unwrap();
        std::fs::write(at("beam.toml"), LARGE).unwrap();
        std::fs::write(at("push.toml"), push).unwrap();
        let (problem, file, scenario) = (at("beam.toml"), at("beam.vdm"), at("push.toml"));
        let built = vademecum(&["build", &problem, "-o", &file]);
        assert_eq!(built.code, Some(0), "{name}: {}", built.stderr);
        let ran = vademecum(&["run", &file, "--scenario", &scenario, "-o", &at("out")]);
        assert_eq!(ran.code, Some(0), "{name}: {}", ran.stderr);
        let verified =
            vademecum(&["verify", &file, "--problem", &problem, "--scenario", &scenario, "--json"]).json();
        let figure = |key: &str| verified[key].as_f64().unwrap_or_else(|| panic!("no `{key}` in {verified}"));
        // Within the tolerance of the file, as far off as tetrahedra, and nearer than a linear model.
        let error = figure("trajectory_error");
        assert!(error < 0.1 && error < 2.0 * *of_tetrahedra.get_or_insert(error), "{name}: {verified}");
        assert!(figure("displacement") > 0.15, "{name}: {verified}");
        assert!(figure("linear_error") > 1.5 * error, "{name}: {verified}");
    }
}

#[test]
fn large_displacements_and_the_error_of_the_mesh_name_what_they_do_not_take() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(at("beam.vtk"), beam(4, |_| vec![(ElementKind::Hex8, (0..8).collect())])).unwrap();
    let large =
        PROBLEM.replace("[output]\nstress = \"surface\"\n", "").replace("ratio = 0.01", "alpha = 0.1");
    std::fs::write(at("large.toml"), format!("model = \"large-displacement\"\n{large}")).unwrap();
    let ran = vademecum(&["build", &at("large.toml"), "-o", &at("large.vdm")]);
    assert_ne!(ran.code, Some(0));
    for part in ["incompatible modes", "hexahedra = \"full\"", "quadratic elements"] {
        assert!(ran.stderr.contains(part), "{}", ran.stderr);
    }
    std::fs::write(at("beam.toml"), PROBLEM).unwrap();
    let modes = vademecum(&["modes", &at("beam.toml"), "--mesh-error", "--json"]).json();
    let reason = modes["mesh_error"]["reason"].as_str().unwrap_or_default().to_string();
    assert!(reason.contains("tetrahedra"), "{modes}");
}
