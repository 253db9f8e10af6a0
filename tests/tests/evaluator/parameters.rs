//! Live parameters end to end: a small body of two materials is built, certified, written, and stepped at
//! parameters that no build saw, beside a full-order march of a problem that has them fixed.

use serde_json::Value;
use vademecum_eval::{Contact, Place, SceneOptions};
use vademecum_format::File;
use vademecum_tests::program::vademecum;
use vademecum_tests::stage::with_scene;

/// A short beam of two materials; `PARAMETERS` is replaced by live parameters or left out.
const PROBLEM: &str = r#"
[mesh]
block = { lengths = [1.0, 0.1, 0.1], divisions = [6, 1, 1] }
[[mesh.region]]
name = "tip"
on = { fraction = { axis = "x", side = "max", fraction = 0.5 } }
[[material]]
region = "body"
young = 2e9
poisson = 0.3
density = 1200.0
[[material]]
region = "tip"
young = 2e9
poisson = 0.3
density = 1200.0
[[support]]
on = { group = "x_min" }
[load]
[time]
scheme.name = "bathe"
step = 1e-3
[snapshots]
positions = 2
duration = 0.1
[basis]
modes = 6
[tolerance]
floor_ratio = 3.0
steps = 100
map = 1e-6
max_terms = 80
"#;

const PARAMETERS: &str = r#"
[[parameter]]
name = "root"
kind = "stiffness"
region = "body"
range = [0.5, 2.0]
scale = "log"
[[parameter]]
name = "tip"
kind = "stiffness"
region = "tip"
range = [0.5, 2.0]
scale = "log"
[[parameter]]
name = "dt"
kind = "time-step"
range = [0.5e-3, 2e-3]
scale = "log"
"#;

/// The separation judges itself at points of its own; fresh ones may find an error above the tolerance. Then
/// terms are added until they do not, or run out. At this tolerance the first attempt, of 23 terms, is at
/// 9.51e-5.
#[test]
fn terms_are_added_until_the_certified_error_keeps_the_tolerance() {
    let folder = tempfile::tempdir().expect("a folder");
    let (problem, file) = (folder.path().join("p.toml"), folder.path().join("f.vdm"));
    let path = |p: &std::path::Path| p.display().to_string();
    let build = |max_terms: &str| {
        let text = format!("{PROBLEM}{PARAMETERS}").replace("map = 1e-6", "map = 9.48e-5");
        // The basis is small here; only the maps are judged.
        let text = text.replace("floor_ratio = 3.0", "floor_ratio = 30.0\nabsolute = 1e-2");
        let text = text.replace("max_terms = 80", &format!("max_terms = {max_terms}"));
        std::fs::write(&problem, text).expect("written");
        vademecum(&["build", &*path(&problem), "-o", &path(&file), "--json", "--fresh"])
    };
    let built = build("80");
    assert_eq!(built.code, Some(0), "{}", built.stderr);
    let report: Value = serde_json::from_str(&built.stdout).expect("JSON");
    assert!(report["certificate"]["block"]["map_error_rms"].as_f64() <= Some(9.48e-5), "{report}");
    // The hint of a build whose terms run out says so.
    let missed = build("20");
    assert_eq!(missed.code, Some(6), "{}", missed.stderr);
    assert!(missed.stderr.contains("a larger `tolerance.max_terms`"), "{}", missed.stderr);
}

#[test]
fn a_build_over_three_parameters_keeps_what_it_promises() {
    let folder = tempfile::tempdir().expect("a folder");
    let (problem, file) = (folder.path().join("p.toml"), folder.path().join("f.vdm"));
    std::fs::write(&problem, format!("{PROBLEM}{PARAMETERS}")).expect("written");
    let path = |p: &std::path::Path| p.display().to_string();
    let built = vademecum(&["build", &*path(&problem), "-o", &path(&file), "--json"]);
    assert_eq!(built.code, Some(0), "{}", built.stderr);
    let info = vademecum(&["info", &*path(&file), "--json"]);
    let info: Value = serde_json::from_str(&info.stdout).expect("JSON");
    let certificate = &info["certificate"];
    let number = |key: &str| certificate[key].as_f64().unwrap_or_else(|| panic!("{key} in {certificate}"));
    // What the problem asked for, not what happened to come out.
    assert!(number("terms") <= 80.0);
    assert!(number("map_error_rms") <= 1e-6 && number("map_error_max") <= 1e-5);
    assert!(number("spectral_radius_max") <= 1.0 + 1e-12);
    assert!(number("trajectory_error_max") <= 3.0 * number("trajectory_floor_max") + 1e-6);
    let parameters = info["parameters"].as_array().expect("a list");
    let roles: Vec<&str> = parameters.iter().filter_map(|parameter| parameter["role"].as_str()).collect();
    assert_eq!(roles, ["RegionStiffness 0", "RegionStiffness 1", "TimeStep"]);
    assert_eq!([&info["axes"][0]["role"], &info["axes"][0]["kind"]], ["Monomial", "Chebyshev"]);
    // The history ends where the solution met its tolerance; the worst sample of the radius is the one
    // certified.
    let history = info["enrichment_history"].as_array().expect("a history");
    let error = |entry: &Value| entry["error"].as_f64().expect("an error");
    assert_eq!(history.last().expect("entries")["terms"], certificate["terms"]);
    assert!(error(&history[0]) > 1e-3 && error(history.last().expect("entries")) <= 1e-6);
    let radii = info["radius_samples"].as_array().expect("samples");
    assert_eq!(radii.len(), 8 + 1 + 100, "corners, the problem's own values, random points");
    let radius = |sample: &Value| sample["spectral_radius"].as_f64().expect("a radius");
    assert_eq!(radii.iter().map(radius).fold(0.0, f64::max), number("spectral_radius_max"));
    let ranges = [(0.5, 2.0), (0.5, 2.0), (0.5e-3, 2e-3)];
    for sample in radii {
        let values =
            sample["values"].as_array().expect("values").iter().map(|v| v.as_f64().expect("a value"));
        assert!(values.zip(ranges).all(|(v, (low, high))| low <= v && v <= high), "{sample}");
    }
    assert_eq!(info["axes"].as_array().map(Vec::len), Some(2), "Δt and both stages share θ");
    fewer_terms_keep_a_coarser_tolerance(&path(&file));
}

/// The error that a scene of fewer terms has, measured against the scene of all, at values of the parameters
/// in the middle of nowhere.
fn fewer_terms_keep_a_coarser_tolerance(path: &str) {
    let bytes = std::fs::read(path).expect("a file");
    let file = File::parse(&bytes).expect("a file");
    let n = file.metadata().n_load_nodes;
    let contact = Contact::new(Place::triangle([n / 3, n / 2, n - 1], [0.2, 0.5, 0.3]), [1.0, -2.0, 0.5]);
    let march = |n_terms: Option<usize>, values: [f64; 3]| {
        let mut options = SceneOptions { terms: n_terms, ..SceneOptions::default() };
        for (place, value) in values.into_iter().enumerate() {
            options.set(file.metadata(), &[(place, value)]).expect("in range");
        }
        with_scene::<f64, _>(&bytes, &options, |scene, state, loads| {
            loads.add_contact(scene, &contact).expect("a contact");
            let mut all = vec![];
            for _ in 0..STEPS {
                scene.step(state, loads).expect("a step");
                all.extend_from_slice(state.zeta());
            }
            all
        })
    };
    const STEPS: usize = 100;
    let mut fewest = file.metadata().n_terms as usize;
    for tolerance in [1e-4, 1e-3, 1e-2] {
        let info = vademecum(&["info", path, "--terms-for", &tolerance.to_string(), "--json"]).json();
        let terms = info["fewest_terms"]["left"].as_u64().expect("a number") as usize;
        assert!(terms < fewest, "{terms} terms for {tolerance:e}");
        fewest = terms;
        for values in [[0.6, 1.7, 1.3e-3], [1.9, 0.7, 0.6e-3], [1.1, 1.2, 1e-3]] {
            let (some, all) = (march(Some(terms), values), march(None, values));
            let norm = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>().sqrt();
            let off = norm(&mut some.iter().zip(&all).map(|(a, b)| a - b)) / norm(&mut all.iter().copied());
            println!("{terms} terms for {tolerance:e}, at {values:?}: {off:.1e}");
            // Each step adds no more than the maps' error, relative to what it changes: at most its number
            // times as much.
            assert!(0.0 < off && off <= tolerance * STEPS as f64, "{terms} terms: {off:e}");
        }
    }
}

#[test]
fn a_range_without_the_problems_own_value_and_an_unknown_region_are_named_with_their_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let problem = folder.path().join("p.toml");
    for (from, to, expected) in [
        ("range = [0.5e-3, 2e-3]", "range = [2e-3, 4e-3]", "0.001"),
        ("region = \"tip\"\nrange", "region = \"top\"\nrange", "`top` is no region"),
    ] {
        std::fs::write(&problem, format!("{PROBLEM}{}", PARAMETERS.replace(from, to))).expect("written");
        let path = problem.display().to_string();
        let ran = vademecum(&["build", &*path, "-o", &format!("{path}.vdm")]);
        assert_eq!(ran.code, Some(3), "{}", ran.stderr);
        let located = ran.stderr.contains("p.toml:") && ran.stderr.contains(expected);
        assert!(located, "{}", ran.stderr);
    }
}

/// Writes a problem, runs `build` on it with further arguments, and gives what came back and the path of the
/// file.
fn build(
    folder: &std::path::Path,
    problem: &str,
    arguments: &[&str],
) -> (vademecum_tests::program::Ran, String) {
    let path = folder.join("p.toml");
    std::fs::write(&path, problem).expect("written");
    let (path, file) = (path.display().to_string(), folder.join("f.vdm").display().to_string());
    let mut all = vec!["build", &*path, "-o", &*file, "--json"];
    all.extend(arguments);
    (vademecum(&all), file)
}

#[test]
fn a_step_unstable_over_the_box_is_named_with_its_place_and_mended_on_request() {
    // A sum of two terms misses the step by more than a nearly undamped scheme takes off.
    let loose = PROBLEM
        .replace("map = 1e-6\nmax_terms = 80", "map = 0.03\nmax_terms = 2")
        .replace("modes = 6", "modes = 3");
    let problem = format!("{loose}{PARAMETERS}");
    let folder = tempfile::tempdir().expect("a folder");
    let (refused, _) = build(folder.path(), &problem, &[]);
    assert_eq!(refused.code, Some(6), "{}", refused.stderr);
    let place =
        refused.stderr.lines().find(|line| line.contains("the step is unstable at")).expect("a place");
    assert!(["root = ", "tip = ", "dt = "].iter().all(|name| place.contains(name)), "{place}");
    assert!(refused.stderr.contains("spectral radius 1+"), "by how much: {}", refused.stderr);

    let (repaired, file) = build(folder.path(), &problem, &["--repair", "--keep-missed"]);
    let report = repaired.json();
    let repairs = report["separation"]["repairs"].as_array().expect("a list");
    assert!(
        !repairs.is_empty() && repairs.iter().all(|r| r.as_str().expect("text").contains("terms")),
        "{repairs:?}"
    );
    let info = vademecum(&["info", &*file, "--json"]).json();
    assert_eq!(
        info["certificate"]["repairs"], report["separation"]["repairs"],
        "the file says what was done"
    );
    let page = folder.path().join("r.html").display().to_string();
    let drawn = vademecum(&["report", &*file, "-o", &*page]);
    assert_eq!(drawn.code, Some(0), "{}", drawn.stderr);
    let page = std::fs::read_to_string(&page).expect("a page");
    assert!(page.contains("Repaired by the build: spectral radius 1+"), "the report shows it");
    let radius = info["certificate"]["spectral_radius_max"].as_f64().expect("a number");
    assert!(radius <= 1.0 + 1e-12, "{radius}");
}

#[test]
fn one_axis_over_a_factor_of_100_takes_at_most_20_terms_for_1e_8() {
    let parameter = r#"
[[parameter]]
name = "stiffness"
kind = "stiffness"
range = [0.1, 10.0]
scale = "log"
"#;
    // Newmark has one stage, so θ moves by the factor of the stiffness alone.
    let problem = PROBLEM
        .replace("map = 1e-6", "map = 1e-8")
        .replace("scheme.name = \"bathe\"", "scheme = { name = \"newmark\", beta = 0.25, gamma = 0.5 }");
    let folder = tempfile::tempdir().expect("a folder");
    let (ran, file) = build(folder.path(), &format!("{problem}{parameter}"), &[]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let info = vademecum(&["info", &*file, "--json"]).json();
    let axis = &info["axes"][0];
    let end = |key: &str| axis[key].as_f64().expect("a number");
    assert!((end("upper") / end("lower") / 100.0 - 1.0).abs() < 1e-9, "{axis}");
    let certificate = &info["certificate"];
    assert!(certificate["terms"].as_u64().expect("a number") <= 20, "{certificate}");
    assert!(certificate["map_error_rms"].as_f64().expect("a number") <= 1e-8, "{certificate}");
    let steps = certificate["good_for_steps"].as_f64();
    assert!(
        steps.is_none_or(|steps| steps >= 100.0),
        "the tolerance holds over the steps marched: {certificate}"
    );
}

#[test]
fn a_march_as_long_as_the_certificate_promises_keeps_the_tolerance_and_a_much_longer_one_does_not() {
    // A coarse map whose drift is seen early; the scheme damps the high modes, so the floor falls while the
    // error grows.
    let parameter =
        "[[parameter]]\nname = \"stiffness\"\nkind = \"stiffness\"\nrange = [0.5, 2.0]\nscale = \"log\"\n";
    let certificate = |steps: usize| {
        let problem = format!("{PROBLEM}{parameter}")
            .replace("map = 1e-6", "map = 1e-4")
            .replace("steps = 100", &format!("steps = {steps}"));
        let folder = tempfile::tempdir().expect("a folder");
        let (ran, file) = build(folder.path(), &problem, &["--keep-missed"]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        vademecum(&["info", &*file, "--json"]).json()["certificate"].clone()
    };
    let number = |certificate: &Value, key: &str| certificate[key].as_f64().expect("a number");
    let keeps = |certificate: &Value| {
        // Of the run farthest above its floor.
        number(&certificate["block"], "floor_ratio") <= 3.0
    };
    let promised = number(&certificate(200), "good_for_steps");
    assert!(promised > 2.0 * 200.0, "no promise beyond the march, nothing to check: {promised}");
    assert!(keeps(&certificate(promised as usize)), "{promised} steps were promised");
    let beyond = certificate(3 * promised as usize);
    assert!(!keeps(&beyond), "three times {promised} steps were kept: the promise says little");
    assert_eq!(number(&beyond, "good_for_steps"), 0.0, "missed is missed");
}

#[test]
fn every_bad_parameter_and_basis_is_named_with_file_and_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = format!("{PROBLEM}{PARAMETERS}");
    let range = "range = [0.5, 2.0]";
    for (problem, good, bad, key) in [
        (&*whole, range, "range = [0.0, 2.0]", "parameter[0].range"),
        (&whole, range, "range = [-1.0, 2.0]", "parameter[0].range"),
        (&whole, range, "range = [2.0, 0.5]", "parameter[0].range"),
        (&whole, range, "range = [2.0, 2.0]", "parameter[0].range"),
        (&whole, "region = \"tip\"\nyoung", "region = \"top\"\nyoung", "no region"),
        (&whole, "region = \"tip\"\nrange", "region = \"top\"\nrange", "no region"),
        (&whole, "name = \"tip\"\nkind", "name = \"root\"\nkind", "parameter[1].name"),
        (&whole, "modes = 6", "modes = 0", "basis.modes"),
        (&whole, "modes = 6", "modes = 400", "basis.modes"),
        (PROBLEM, "modes = 6", "modes = 400", "basis.modes"),
        (&whole, "map = 1e-6", "map = 1e-17", "tolerance.map"),
    ] {
        assert!(problem.contains(good), "{good}");
        let text = problem.replacen(good, bad, 1);
        let number = 1 + text.lines().zip(problem.lines()).position(|(a, b)| a != b).expect("a changed line");
        let (ran, _) = build(folder.path(), &text, &[]);
        assert_eq!(ran.code, Some(3), "{bad}: {}", ran.stderr);
        let wanted = format!("p.toml:{number}:");
        assert!(ran.stderr.contains(&wanted) && ran.stderr.contains(key), "{bad}, {wanted}: {}", ran.stderr);
    }
}

#[test]
fn four_regions_and_a_time_step_run_through_the_program() {
    let path = vademecum_tests::program::repository().join("fixtures/problems/four-materials.toml");
    let fixture = std::fs::read_to_string(path).expect("the fixture");
    let mut problem = fixture;
    // The fixture coarsened: a coarse mesh, three modes, a map good to 1e-3, marches of 20 steps; the axes
    // are the same.
    for (from, to) in [
        ("divisions = [24, 2, 2]", "divisions = [8, 1, 1]"),
        ("modes = 8", "modes = 3"),
        ("map = 1e-5", "map = 1e-3\nsteps = 20"),
        ("floor_ratio = 1.2", "floor_ratio = 10.0"),
        ("positions = 4", "positions = 1"),
    ] {
        assert!(problem.contains(from), "{from}");
        problem = problem.replace(from, to);
    }
    let folder = tempfile::tempdir().expect("a folder");
    // A map good to 1e-3 does not keep an undamped step stable (the program says where); only the maps are
    // asked here.
    let (ran, file) = build(folder.path(), &problem, &["--keep-missed"]);
    let report = ran.json();
    assert_eq!(report["separation"]["stop"], "Tolerance");
    let info = vademecum(&["info", &*file, "--json"]).json();
    assert_eq!(info["axes"].as_array().map(Vec::len), Some(5));
    let certificate = &info["certificate"];
    let number = |key: &str| certificate[key].as_f64().expect("a number");
    assert!(number("map_error_rms") <= 1e-3 && number("map_error_max") <= 1e-2, "{certificate}");
}
