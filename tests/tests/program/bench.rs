//! `vademecum-lab bench` end to end: its record, and the orderings that no machine and no load may break.

use std::path::Path;

use serde_json::Value;
use vademecum_lab::{COLUMNS, LARGE_COLUMNS};
use vademecum_tests::bending::BENT;
use vademecum_tests::program::{repository, vademecum};

/// Headings of the table's columns, in their order: the keys of the JSON.
fn columns() -> [&'static str; COLUMNS.len()] {
    COLUMNS.map(|column| column.name)
}

/// What the JSON says of a row besides.
const MORE: [&str; 2] = ["marches", "note"];

/// Reduced methods on each number of modes.
const METHODS: [&str; 20] = [
    "pod-galerkin, dense solves f64",
    "pod block two-stage f64",
    "pod block f64",
    "pod block f32",
    "ritz diagonal f64",
    "ritz diagonal f32",
    "ritz quantised f64",
    "ritz block two-stage f64",
    "ritz block f64",
    "ritz block f32",
    "ritz separated f64",
    "ritz separated f32",
    "natural modes, exact f64",
    "natural modes, exact steps f64",
    "natural modes, exact steps f32",
    "natural modes, diagonal f64",
    "natural modes, diagonal f32",
    "natural modes, block two-stage f64",
    "natural modes, block f64",
    "natural modes, block f32",
];

/// The chapter's representation, with 8 modes only: three numbers of terms, and repaired.
const CHAPTER: &str = "pod canonical chapter f64";
const REPAIRED: &str = "ritz canonical repaired f64";
const CANONICAL_ROWS: usize = 4;

fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("`{key}` is no number in {row}"))
}

/// The row of a method with a number of modes at the problem's own time step.
fn row<'a>(methods: &'a [Value], name: &str, modes: u64) -> &'a Value {
    let found =
        methods.iter().find(|row| row["name"] == name && row["modes"] == modes && row["time_step"] == 1e-3);
    found.unwrap_or_else(|| panic!("no row `{name}` with {modes} modes"))
}

/// Runs the bench on the short beam.
fn bench(folder: &Path) -> Value {
    let problem = repository().join("fixtures/problems/short-beam.toml");
    let arguments = [
        "bench".as_ref(),
        problem.as_os_str(),
        "-o".as_ref(),
        folder.as_os_str(),
        "--quick".as_ref(),
        "--json".as_ref(),
        "--tolerance".as_ref(),
        "1e-5".as_ref(),
    ];
    vademecum(&arguments).json()
}

#[test]
fn the_record_is_whole_and_its_orderings_hold() {
    let folder = tempfile::tempdir().expect("a folder");
    let report = bench(folder.path());
    let methods = report["methods"].as_array().expect("a list");
    // The full-order march and the reduced methods with 8 and with 16 modes; at 2 Δt full order and the
    // diagonal files and those of exact steps.
    assert_eq!(methods.len(), 1 + 2 * METHODS.len() + CANONICAL_ROWS + 1 + 2 * (2 + 2));
    // What all is measured from knows its own error. One above what is measured would measure nothing.
    let least = methods.iter().filter_map(|row| row["error_total"].as_f64()).fold(f64::INFINITY, f64::min);
    assert!(number(&report, "truth_error") < least, "{least}");
    assert!(report["truth_vectors"].as_u64().is_some_and(|vectors| vectors > 16));
    for name in METHODS {
        row(methods, name, 8);
        row(methods, name, 16);
    }
    for row in methods {
        check_row(row);
        if row["note"].is_null() {
            check_parts(row);
        }
    }
    check_canonical(methods, report["equal_time"].as_array().expect("a list"));
    check_quantised(methods);
    check_accuracy(methods);
    check_time_scheme(methods);
    check_costs(methods);
    assert!(number(&report["time_scheme_error"][0], "error") > 0.0);
    check_files(folder.path(), &report, methods.len());
}

fn check_row(row: &Value) {
    let mut found: Vec<&str> = row.as_object().expect("a table").keys().map(String::as_str).collect();
    let mut expected = [&columns()[..], &MORE[..]].concat();
    found.sort_unstable();
    expected.sort_unstable();
    assert_eq!(found, expected);
    // error² = floor² + (distance of the coordinates)², summed apart: no rounding turns the order round. A
    // basis of 16 bits is not the one of the floor, and a march that left its ranges has no error.
    let no_floor = row["name"] == "ritz quantised f64" || !row["note"].is_null();
    assert!(no_floor || number(row, "trajectory_error") >= number(row, "projection_floor"), "{row}");
    assert_eq!(row["trajectory_error"].is_null(), !row["note"].is_null(), "{row}");
    assert!(number(row, "step_ns_p50") <= number(row, "step_ns_p99"), "{row}");
    assert!(number(row, "step_ns_p99") <= number(row, "step_ns_max"), "{row}");
    assert!(number(row, "offline_seconds") > 0.0, "{row}");
    let through_file = !row["file_bytes"].is_null();
    assert_eq!(through_file, !row["bind_us"].is_null(), "{row}");
    assert_eq!(row["modes"].is_null(), row["reconstruct_ms"].is_null(), "{row}");
}

/// The total is the distance between the ends of a chain and no more than the sum of its links.
fn check_parts(row: &Value) {
    let parts = ["error_time", "error_space", "error_separation", "error_rounding"];
    let sum: f64 = parts.iter().filter_map(|part| row[part].as_f64()).sum();
    let total = number(row, "error_total");
    // A sum of a million squares, each rounded.
    assert!(total <= sum * (1.0 + 1e-9), "{row}");
    let name = row["name"].as_str().expect("a name");
    assert_eq!(
        row["error_rounding"].is_null(),
        !name.ends_with("f32") && !name.contains("quantised"),
        "{row}"
    );
    let from_terms = name.contains("separated") || name.contains("canonical");
    assert_eq!(row["error_separation"].is_null(), !from_terms, "{row}");
    assert_eq!(row["terms"].is_null(), !from_terms, "{row}");
    // No link that a method does not have: fused or not, the step in f64 is the same one.
    if name == "ritz separated f64" {
        assert!(number(row, "error_separation") <= 1e-4, "ten times the tolerance of the maps: {row}");
    }
}

/// What a shorter step and no time scheme at all are worth: both come closer to the exact motion.
fn check_time_scheme(methods: &[Value]) {
    let coarse = methods.iter().find(|row| row["time_step"] == 2e-3).expect("a row at 2 Δt");
    assert!(number(coarse, "error_time") > number(&methods[0], "error_time"));
    for modes in [8, 16] {
        let exact = row(methods, "natural modes, exact f64", modes);
        assert_eq!(number(exact, "error_time"), 0.0);
        assert!(number(exact, "error_total") < number(&methods[0], "error_time"), "{exact}");
        // A file of exact steps is that motion, at twice the time step too (every second instant counts, so
        // not to the digit); Bathe's step is not.
        let file = row(methods, "natural modes, exact steps f64", modes);
        let apart = number(file, "error_total") - number(exact, "error_total");
        assert!(apart.abs() <= 1e-9 && number(file, "error_time") == 0.0, "{file}");
        let stages = row(methods, "natural modes, diagonal f64", modes);
        assert!(number(stages, "error_total") > 2.0 * number(file, "error_total"), "{stages} {file}");
        let longer = methods
            .iter()
            .find(|row| row["name"] == file["name"] && row["modes"] == modes && row["time_step"] == 2e-3);
        let longer = number(longer.expect("a row at 2 Δt"), "error_total");
        assert!((longer / number(file, "error_total") - 1.0).abs() < 0.1, "{longer}");
        // Stage by stage or fused: the same map, rounded differently over 400 steps.
        for basis in ["pod", "ritz"] {
            let error = |name: &str| {
                number(row(methods, &format!("{basis} block{name} f64"), modes), "trajectory_error")
            };
            assert!((error(" two-stage") - error("")).abs() <= 1e-9, "{basis}, {modes}");
        }
    }
}

/// The repaired maps are the exact ones, in as many terms as right-hand sides, so that their march is the
/// block one, contacts between nodes and all; the chapter's are no closer than the maps they approximate, and
/// ours at equal time no further than the block row.
fn check_canonical(methods: &[Value], equal_time: &[Value]) {
    let repaired = row(methods, REPAIRED, 8);
    // The push stands in one triangle: three nodes of three components, beside three families of eight
    // coordinates.
    assert_eq!((repaired["terms"].as_u64(), repaired["marches"].as_u64()), (Some(3 * 8 + 3 * 3), Some(1)));
    assert!(repaired["note"].is_null(), "{repaired}");
    // Maps right to 1e-15 and amplified by the square of 3/(ωΔt) of the slowest mode, some thousands, over
    // 400 steps.
    assert!(number(repaired, "error_separation") <= 1e-8, "{repaired}");
    let chapter: Vec<&Value> = methods.iter().filter(|row| row["name"] == CHAPTER).collect();
    assert_eq!(chapter.len(), CANONICAL_ROWS - 1);
    for row in &chapter {
        assert_eq!((row["modes"].as_u64(), row["marches"].as_u64()), (Some(8), Some(3)), "{row}");
        assert!(row["terms"].as_u64().is_some_and(|terms| terms <= 40), "{row}");
        // What greedy enrichment leaves is above rounding, else nothing would be compared.
        assert!(row["error_separation"].as_f64().is_none_or(|error| error > 1e-8), "{row}");
    }
    assert_eq!(equal_time.len(), CANONICAL_ROWS);
    for pair in equal_time {
        let [canonical, block] = [&pair["canonical"], &pair["block"]];
        assert!(number(block, "step_ns") <= number(canonical, "step_ns"), "{pair}");
        if let Some(ratio) = pair["ratio"].as_f64() {
            let errors = number(canonical, "trajectory_error") / number(block, "trajectory_error");
            // Numbers that went through decimals.
            assert!((ratio / errors - 1.0).abs() <= 1e-12, "{pair}");
        }
    }
}

/// Sixteen bits cost what was allowed and save most of the file.
fn check_quantised(methods: &[Value]) {
    for modes in [8, 16] {
        let [quantised, built] =
            ["ritz quantised f64", "ritz diagonal f64"].map(|name| row(methods, name, modes));
        let rounding = number(quantised, "error_rounding");
        // Packed to 1e-4 of fields at the nodes; the mass norm of quadratic elements weighs nodes up to ten
        // times differently.
        assert!(rounding > 0.0 && rounding <= 1e-3, "{quantised}");
        let apart = number(quantised, "trajectory_error") - number(built, "trajectory_error");
        assert!(apart.abs() <= 2.0 * rounding, "the triangle inequality: {quantised}");
        assert!(2.0 * number(quantised, "file_bytes") <= number(built, "file_bytes"), "{quantised}");
    }
}

fn check_accuracy(methods: &[Value]) {
    assert_eq!(number(&methods[0], "trajectory_error"), 0.0, "the reference is not its own reference");
    for modes in [8, 16] {
        let of = |name: &str, key: &str| number(row(methods, name, modes), key);
        // One basis, one floor, whatever steps on it.
        let galerkin_floor = of("pod-galerkin, dense solves f64", "projection_floor");
        assert_eq!(galerkin_floor, of("pod block f64", "projection_floor"));
        for structure in ["ritz diagonal", "ritz block"] {
            let [double, single] =
                ["f64", "f32"].map(|p| of(&format!("{structure} {p}"), "trajectory_error"));
            // What the project promises for f32 against f64 over 2e5 steps; by the triangle inequality no
            // more here.
            assert!((double - single).abs() <= 2e-3, "{structure}: {double} {single}");
            // The promise of the default basis.
            let floor = of(&format!("{structure} f64"), "projection_floor");
            assert!(double <= 1.1 * floor + 1e-6, "{structure}: {double} against {floor}");
        }
    }
    // Bases that are nested by construction lose nothing with more modes.
    for name in ["pod block f64", "natural modes, diagonal f64"] {
        let [few, many] = [8, 16].map(|r| number(row(methods, name, r), "projection_floor"));
        assert!(many <= few, "{name}: {many} above {few}");
    }
}

fn check_costs(methods: &[Value]) {
    let full_order = number(&methods[0], "step_ns_p50");
    for modes in [8, 16] {
        let of = |name: &str, key: &str| number(row(methods, name, modes), key);
        // Two sparse solves with 324 dofs against at most 48² multiply-adds; measured 65 µs against 0.25 µs.
        let mut reduced = methods.iter().filter(|row| !row["modes"].is_null());
        assert!(reduced.all(|row| number(row, "step_ns_p50") < full_order));
        // 18r² multiply-adds and two solves in sequence against 9r: measured 15 times and more.
        assert!(of("ritz diagonal f64", "step_ns_p50") < of("pod-galerkin, dense solves f64", "step_ns_p50"));
        // The block file holds what the diagonal one holds and the load columns.
        assert!(of("ritz diagonal f64", "file_bytes") < of("ritz block f64", "file_bytes"));
        assert_eq!(of("ritz diagonal f64", "file_bytes"), of("ritz diagonal f32", "file_bytes"));
    }
}

fn check_files(folder: &Path, report: &Value, rows: usize) {
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).expect(name);
    assert_eq!(&serde_json::from_str::<Value>(&read("bench.json")).expect("JSON"), report);
    let table = read("bench.csv");
    assert_eq!(table.lines().count(), 1 + rows);
    assert_eq!(table.lines().next(), Some(columns().join(",").as_str()));
    assert_eq!(read("bench.md").lines().filter(|line| line.starts_with('|')).count(), 2 + rows);
    for name in ["pareto.svg", "pareto-total.svg"] {
        let picture = read(name);
        assert!(picture.starts_with("<svg") && picture.contains("ritz diagonal f32"), "no picture in {name}");
    }
}

#[test]
fn more_modes_than_the_snapshots_span_is_an_error() {
    let folder = tempfile::tempdir().expect("a folder");
    let problem = repository().join("fixtures/problems/short-beam.toml");
    let arguments = [
        "bench".as_ref(),
        problem.as_os_str(),
        "-o".as_ref(),
        folder.path().as_os_str(),
        "--quick".as_ref(),
        "--modes".as_ref(),
        "256".as_ref(),
    ];
    let ran = vademecum(&arguments);
    assert_eq!(ran.code, Some(3), "{}", ran.stderr);
    assert!(ran.stderr.contains("the snapshots span"), "{}", ran.stderr);
}

#[test]
fn a_problem_without_a_scheme_is_compared_by_the_stages_of_bathe() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = std::fs::read_to_string(repository().join("fixtures/problems/short-beam.toml")).expect("text");
    let (problem, out) = (folder.path().join("beam.toml"), folder.path().join("out"));
    let exact = text.replace("scheme = { name = \"bathe\" }\n", "");
    assert_ne!(exact, text);
    std::fs::write(&problem, exact).expect("written");
    let more = ["--quick", "--json", "--modes", "4", "--steps", "40"].map(AsRef::as_ref);
    let run = ["bench".as_ref(), problem.as_os_str(), "-o".as_ref(), out.as_os_str()];
    let report = vademecum(&[&run[..], &more].concat()).json();
    let methods = report["methods"].as_array().expect("a list");
    for name in ["full order, bathe", "natural modes, exact steps f32"] {
        assert!(methods.iter().any(|row| row["name"] == name), "no row `{name}`");
    }
}

#[test]
fn a_body_of_large_displacements_has_a_record_of_its_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(at("bent.toml"), BENT).expect("written");
    let run = |more: &[&str]| {
        let (problem, out) = (at("bent.toml"), at("out"));
        vademecum(&[&["bench", &problem, "-o", &out, "--quick"], more].concat())
    };
    // Refused by name before anything is built or written.
    for option in [["--modes", "4"], ["--tolerance", "1e-5"]] {
        let refused = run(&option);
        assert_eq!(refused.code, Some(2), "{}", refused.stderr);
        assert!(
            refused.stderr.contains(option[0]) && refused.stderr.contains("leave it out"),
            "{}",
            refused.stderr
        );
        assert!(!folder.path().join("out").exists());
    }
    let report = run(&["--json", "--steps", "160"]).json();
    let methods = report["methods"].as_array().expect("a list");
    // Two at full order, Galerkin, the linear model, and the file in two precisions with 1 and 4 sub-steps.
    assert_eq!((methods.len(), &report["steps"]), (8, &Value::from(160)));
    let row = |name: &str, substeps: u64| {
        let found = methods.iter().find(|row| row["name"] == name && row["substeps"] == substeps);
        found.unwrap_or_else(|| panic!("no row `{name}`, {substeps}"))
    };
    let file = row("file f64", 4);
    // Basis and strain map of so few coordinates may cancel what sub-steps are off by: the part tells.
    assert!(number(file, "error_time") < 0.3 * number(row("file f64", 1), "error_time"), "{file}");
    assert!(number(file, "error_total") < number(row("linear model f64", 1), "error_total"), "{file}");
    assert!(
        number(file, "file_bytes") > 0.0 && row("full order, bathe and newton", 4)["file_bytes"].is_null()
    );
    let mut found: Vec<&str> = file.as_object().expect("a table").keys().map(String::as_str).collect();
    let mut expected = LARGE_COLUMNS.map(|column| column.name);
    found.sort_unstable();
    expected.sort_unstable();
    assert_eq!(found, expected);

    let read = |name: &str| std::fs::read_to_string(folder.path().join("out").join(name)).expect(name);
    assert_eq!(serde_json::from_str::<Value>(&read("bench.json")).expect("JSON"), report);
    assert_eq!(read("bench.csv").lines().count(), 1 + methods.len());
    assert_eq!(read("bench.md").lines().filter(|line| line.starts_with('|')).count(), 2 + methods.len());
    let picture = read("pareto.svg");
    assert!(picture.starts_with("<svg") && picture.contains("file f32"));
    assert!(!folder.path().join("out/pareto-total.svg").exists());
}
