//! `run --sets`: a body for each row of a table of live parameters.

use std::path::{Path, PathBuf};

use vademecum_tests::program::{Ran, repository, vademecum};

const PUSH: &str =
    "duration = 0.02\n[[contact]]\npoint = [0.3, 0.4, 0.0]\nforce = [1.0, -2.0, 3.0]\nend = 0.01\n";

struct Place(tempfile::TempDir);

impl Place {
    fn new(file: &str) -> Self {
        let place = Self(tempfile::tempdir().expect("a folder"));
        std::fs::copy(repository().join("fixtures/golden").join(file), place.at("a.vdm")).expect("copied");
        std::fs::write(place.at("s.toml"), PUSH).expect("written");
        place
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn run(&self, folder: &str, more: &[&str]) -> Ran {
        let [file, scenario, out] =
            ["a.vdm", "s.toml", folder].map(|name| self.at(name).display().to_string());
        vademecum(&[&["run", &file, "--scenario", &scenario, "-o", &out], more].concat())
    }

    fn run_sets(&self, table: &str, more: &[&str]) -> Ran {
        std::fs::write(self.at("sets.csv"), table).expect("written");
        let sets = self.at("sets.csv").display().to_string();
        self.run("many", &[&["--sets", &sets], more].concat())
    }
}

/// Names of a table, and its rows.
fn table(path: &Path) -> (Vec<String>, Vec<Vec<f64>>) {
    let text = std::fs::read_to_string(path).expect("a table");
    let mut lines = text.lines();
    let names = lines.next().expect("names").split(',').map(String::from).collect();
    let row = |line: &str| line.split(',').map(|cell| cell.parse().expect("a number")).collect();
    (names, lines.map(row).collect())
}

/// Smallest, largest and last value of each column of a run behind the time.
fn summary(path: &Path) -> Vec<f64> {
    let (names, rows) = table(path);
    let column = |k: usize| {
        let values: Vec<f64> = rows.iter().map(|row| row[k]).collect();
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        [least, largest, values[values.len() - 1]]
    };
    (1..names.len()).flat_map(column).collect()
}

/// Rows of a table of many bodies are the summaries of single runs.
fn rows_are_runs(file: &str, names: &[&str], rows: [&[f64]; 2]) {
    let place = Place::new(file);
    let text = |row: &&[f64]| row.iter().map(f64::to_string).collect::<Vec<_>>().join(",") + "\n";
    let lines: String = rows.iter().map(text).collect();
    let ran = place.run_sets(&format!("{}\n{lines}", names.join(",")), &["--json"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let (columns, found) = table(&place.at("many/bodies.csv"));
    let first = [&["body"], names, &["energy_J.min", "energy_J.max", "energy_J.last"]].concat();
    assert_eq!(columns[..first.len()], first);
    let shown: serde_json::Value = serde_json::from_str(&ran.stdout).expect("JSON");
    assert_eq!(shown["columns"], serde_json::json!(columns));
    assert_eq!(found.len(), 2);
    for (row, found) in rows.iter().zip(&found) {
        let set: Vec<String> =
            names.iter().zip(*row).map(|(name, value)| format!("{name}={value}")).collect();
        let set: Vec<&str> = set.iter().flat_map(|set| ["--set", set]).collect();
        let ran = place.run("one", &set);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        assert_eq!(found[1..=names.len()], **row);
        assert_eq!(found[1 + names.len()..], summary(&place.at("one/probes.csv")));
    }
    assert_ne!(found[0][1 + names.len()..], found[1][1 + names.len()..]);
}

#[test]
fn a_row_is_the_summary_of_a_run_at_its_values() {
    let names = ["stiffness of the tip", "density of the tip"];
    rows_are_runs("parametric.vdm", &names, [&[0.3, 1.25], &[3.5, 0.625]]);
    // Live parameters of the whole body.
    let bytes = std::fs::read(repository().join("fixtures/golden/exact-f64.vdm")).expect("readable");
    let file = vademecum_format::File::parse(&bytes).expect("a file");
    let own = file.parameters().next().expect("a parameter");
    rows_are_runs("exact-f64.vdm", &[own.name], [&[own.lower], &[own.upper]]);
}

#[test]
fn a_row_out_of_the_box_is_refused_with_its_line_and_the_others_run() {
    let place = Place::new("parametric.vdm");
    let ran = place.run_sets("# drawn\nstiffness of the tip\n1\n9\n2\n", &["--json"]);
    assert_eq!(ran.code, Some(2), "{}", ran.stderr);
    let line = "sets.csv:4: `stiffness of the tip` is 9; expected a value from 0.25 to 4";
    assert!(ran.stderr.contains(line), "{}", ran.stderr);
    let shown: serde_json::Value = serde_json::from_str(&ran.stdout).expect("JSON");
    assert_eq!((&shown["bodies"], &shown["rows"]), (&serde_json::json!(3), &serde_json::json!(2)));
    let (_, rows) = table(&place.at("many/bodies.csv"));
    assert_eq!(rows.iter().map(|row| [row[0], row[1]]).collect::<Vec<_>>(), [[1.0, 1.0], [3.0, 2.0]]);
}

#[test]
fn tables_that_set_nothing_of_the_file_are_refused_before_anything_is_written() {
    let place = Place::new("parametric.vdm");
    let given = ["--set", "beta=1e-5"];
    for (table, more, part) in [
        ("stifness of the tip\n1\n", &[][..], "sets.csv:1: column `stifness of the tip`"),
        ("beta\n1e-5\n", &given, "sets.csv:1: column `beta`, which `--set` gives to all bodies"),
        ("beta,beta\n1e-5,1e-5\n", &[], "sets.csv:1: column 2 has the name `beta`"),
        ("beta\n1e-5\nx\n", &[], "sets.csv:3: `x` in column `beta`; expected a finite number"),
        ("beta\n", &[], "sets.csv:1: names without a row"),
    ] {
        let ran = place.run_sets(table, more);
        assert_eq!(ran.code, Some(3), "{table}: {}", ran.stderr);
        assert!(ran.stderr.contains(part), "{table}: {}", ran.stderr);
        assert!(!place.at("many").exists());
    }
    let ran = place.run_sets("beta\n1e-5\n", &["--plot", "p.svg"]);
    assert_eq!(ran.code, Some(2), "{}", ran.stderr);
}
