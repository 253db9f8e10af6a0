//! Universal files and places of sensors: what a program of modal testing is given, and what it gives back.

use std::fmt::Write as _;

use vademecum_tests::program::{Ran, vademecum};

const ARM: &str = r#"
[mesh]
block = { lengths = [0.5, 0.05, 0.02], divisions = [10, 2, 1] }
[[material]]
young = 2.1e9
poisson = 0.3
density = 1200.0
[damping]
ratio = 0.01
[[support]]
on = { group = "x_min" }
[load]
surface = { group = "z_max" }
[[load.pattern]]
name = "gravity"
acceleration = [0.0, 0.0, -9.81]
[time]
step = 5e-4
[basis]
modes = 6
[tolerance]
error = 10.0
[[output.probe]]
name = "tip"
point = [0.5, 0.025, 0.02]
direction = [0.0, 0.0, 1.0]
"#;

struct Arm(tempfile::TempDir);

impl Arm {
    fn built() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("arm.toml"), ARM).expect("written");
        let own = Self(folder);
        assert_eq!(own.run(&["build", "arm.toml", "-o", "arm.vdm"]).code, Some(0));
        own
    }

    /// Words with a point and a letter behind it are files of the folder.
    fn run(&self, words: &[&str]) -> Ran {
        let path = |word: &&str| {
            let is_file = [".toml", ".vdm", ".uff"].iter().any(|end| word.ends_with(end));
            if is_file { self.0.path().join(word).display().to_string() } else { (*word).to_string() }
        };
        let words: Vec<String> = words.iter().map(path).collect();
        vademecum(&words.iter().map(String::as_str).collect::<Vec<_>>())
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.0.path().join(name)).expect("a text")
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.0.path().join(name), text).expect("written");
    }

    /// The modal assurance of six modes against a file.
    fn assurance(&self, name: &str) -> Vec<Vec<f64>> {
        let ran = self.run(&["modes", "arm.toml", "--count", "6", "--assurance", name, "--json"]);
        serde_json::from_value(ran.json()["assurance"].clone()).expect("a table")
    }
}

/// Numbers of the datasets of a text, and the lines of each.
fn datasets(text: &str) -> Vec<(u32, Vec<&str>)> {
    let mut lines = text.lines();
    let mut found = vec![];
    while let Some(mark) = lines.next() {
        assert_eq!(mark, "    -1");
        let number = lines.next().expect("a number").trim().parse().expect("a number");
        found.push((number, lines.by_ref().take_while(|line| *line != "    -1").collect()));
    }
    found
}

#[test]
fn modes_and_responses_are_written_in_the_columns_of_the_datasets() {
    let arm = Arm::built();
    let place = "0.35,0.025,0.02,-z";
    let ran = arm.run(&[
        "export",
        "uff",
        "arm.vdm",
        "--in",
        place,
        "--in",
        "gravity",
        "--out",
        "tip",
        "--out",
        place,
        "--range",
        "1,300",
        "--points",
        "20",
        "--quantity",
        "acceleration",
        "-o",
        "arm.uff",
    ]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let text = arm.read("arm.uff");
    assert!(text.is_ascii() && text.lines().all(|line| line.len() <= 80));
    let sets = datasets(&text);
    let numbers: Vec<u32> = sets.iter().map(|(number, _)| *number).collect();
    assert_eq!(numbers, [164, 15, 82, 55, 55, 55, 55, 55, 55, 58, 58, 58, 58]);
    let nodes = sets[1].1.len();
    assert!(ran.stdout.contains(&format!("{nodes} nodes, 6 modes, 4 frequency responses")), "{}", ran.stdout);
    // Five lines of identification, three of parameters, two for each node.
    assert_eq!(sets[3].1.len(), 8 + 2 * nodes);
    assert_eq!(sets[3].1[5], "         1         2         2         8         2         3");
    let [first, last] = [&sets[9].1, &sets[12].1];
    // The tip is a node, and so is the place; a pattern is none.
    let dofs = |lines: &[&str]| -> Vec<String> {
        let words = lines[5].split_whitespace().map(str::to_string).collect::<Vec<_>>();
        vec![words[5].clone(), words[6].clone(), words[8].clone(), words[9].clone()]
    };
    let (own, of_pattern) = (dofs(first), dofs(last));
    assert!(own[0] != "0" && own[1] == "3" && own[3] == "-3", "{own:?}");
    assert_eq!((own[2].as_str(), of_pattern[0].as_str()), (of_pattern[0].as_str(), own[2].as_str()));
    assert_eq!((of_pattern[2].as_str(), of_pattern[3].as_str()), ("0", "0"));
    // The numbers are those of `frf`.
    let asked = ["--points", "20", "--quantity", "acceleration", "--json"];
    let channels = ["frf", "arm.vdm", "--in", place, "--out", "tip", "--range", "1,300"];
    let theirs = arm.run(&[&channels[..], &asked].concat()).json();
    let values = theirs["values"][0].as_array().expect("values");
    let rows = &first[11..];
    assert_eq!(rows.len(), values.len());
    for (row, value) in rows.iter().zip(values) {
        let found: Vec<f64> =
            [&row[13..33], &row[33..53]].iter().map(|word| word.trim().parse().expect("a number")).collect();
        for (found, own) in found.iter().zip([value[0].as_f64(), value[1].as_f64()]) {
            let own = own.expect("a number");
            assert!((found - own).abs() <= 1e-12 * own.abs(), "{found} {own}");
        }
    }
    arm.run(&[
        "export",
        "uff",
        "arm.vdm",
        "--in",
        place,
        "--out",
        "0.5,0.02,0.02,1,0,1",
        "--range",
        "1,2",
        "-o",
        "b.uff",
    ])
    .fails(2, &["dataset 58 has directions along x, y and z"]);
    arm.run(&["export", "uff", "arm.vdm", "--in", place, "-o", "b.uff"]).fails(2, &["--out"]);
}

#[test]
fn measured_modes_are_compared_at_the_nodes_that_were_measured() {
    let arm = Arm::built();
    assert_eq!(arm.run(&["export", "uff", "arm.vdm", "-o", "arm.uff"]).code, Some(0));
    let same = arm.assurance("arm.uff");
    for (i, row) in same.iter().enumerate() {
        // Five digits of each number.
        assert!(row[i] > 1.0 - 1e-8 && row.iter().enumerate().all(|(j, x)| i == j || *x < 0.1), "{row:?}");
    }
    // A test in millimetres, along z alone, at every third node, with complex modes turned by a phase.
    let text = arm.read("arm.uff");
    let sets = datasets(&text);
    let mut test = String::from(
        "    -1\n   164\n         4Millimeter (milli-newton)  2\n  1.0000000000000000D+03  1.0000000000000000D+03  \
         1.0000000000000000D+00\n  2.7315000000000000D+02\n    -1\n    -1\n    15\n",
    );
    for line in sets[1].1.iter().step_by(3) {
        let at = [40, 53, 66].map(|start| line[start..start + 13].trim().parse::<f64>().expect("a number"));
        let [x, y, z] = at.map(|x| format!("{:>13}", format!("{:.4}", 1e3 * x)));
        let _ = writeln!(test, "{}{x}{y}{z}", &line[..40]);
    }
    test.push_str("    -1\n");
    for (_, lines) in sets.iter().filter(|(number, _)| *number == 55) {
        let _ = writeln!(test, "    -1\n    55\nNONE\nNONE\nNONE\nNONE\nNONE");
        let _ = writeln!(test, "         1         3         2         8         5         3");
        let _ = writeln!(test, "         2         6         1         1\n{}", "  1.00000E+00".repeat(6));
        for pair in lines[8..].chunks(2).step_by(3) {
            let z: f64 = pair[1][26..39].trim().parse().expect("a number");
            let part = |share: f64| format!("{:>13}", format!("{:.4}", share * z));
            let _ = writeln!(test, "{}\n{}{}{}", pair[0], "  0.00000E+00".repeat(4), part(0.6), part(-0.8));
        }
        test.push_str("    -1\n");
    }
    arm.write("test.uff", &test);
    let measured = arm.assurance("test.uff");
    // Modes that bend along z and twist; the others hardly move along z.
    for (i, row) in measured.iter().enumerate().filter(|(i, _)| [0, 2, 4].contains(i)) {
        assert!(row[i] > 0.999, "{i}: {row:?}");
    }
    let ran = arm.run(&["modes", "arm.toml", "--count", "6", "--assurance", "test.uff"]);
    assert!(ran.stdout.contains("nodes with measured motion, at most"), "{}", ran.stdout);
    // Faults are named.
    for (from, to, words) in [
        ("    15\n", "    16\n", "it has no nodes; expected dataset 15 or 2411"),
        ("  1.0000000000000000D+03  1.0", "  1.0000000000000000D-03  1.0", "unit of the mesh"),
    ] {
        arm.write("bad.uff", &test.replacen(from, to, 1));
        arm.run(&["modes", "arm.toml", "--assurance", "bad.uff"]).fails(3, &["bad.uff", words]);
    }
    let local = sets[1].1[0];
    let turned = format!("{}{:>10}{}", &local[..20], 7, &local[30..40]);
    arm.write("bad.uff", &test.replacen(&local[..40], &turned, 1));
    arm.run(&["modes", "arm.toml", "--assurance", "bad.uff"]).fails(3, &["the coordinate system 7"]);
}

#[test]
fn sensors_tell_modes_apart_that_fewer_places_do_not() {
    let arm = Arm::built();
    let plan = |more: &[&str]| arm.run(&[&["sensors", "arm.vdm", "--json"], more].concat());
    let found = plan(&["--count", "6", "--modes", "4"]).json();
    let sensors = found["sensors"].as_array().expect("sensors");
    assert_eq!(sensors.len(), 6);
    let independence: Vec<f64> = sensors.iter().map(|s| s["independence"].as_f64().expect("one")).collect();
    // They sum to the number of modes.
    assert!((independence.iter().sum::<f64>() - 4.0).abs() < 1e-9, "{independence:?}");
    assert!(independence.windows(2).all(|pair| pair[0] >= pair[1]) && independence[0] <= 1.0 + 1e-9);
    assert!(
        found["largest_assurance"].as_f64().expect("one") < 0.9 && found["condition"].as_f64() < Some(10.0)
    );
    // As many as modes: none can be spared.
    let found = plan(&["--count", "4", "--modes", "4"]).json();
    assert!(
        found["sensors"]
            .as_array()
            .expect("sensors")
            .iter()
            .all(|s| s["independence"].as_f64() > Some(0.999_999))
    );
    plan(&["--count", "3", "--modes", "4"]).fails(2, &["3 sensors for 4 modes"]);
    plan(&["--count", "8", "--modes", "7"]).fails(2, &["expected 1 to 6"]);
    let text = arm.run(&["sensors", "arm.vdm", "--count", "2", "--modes", "2", "--axis", "z", "--axis", "y"]);
    assert!(text.stdout.contains("independence") && text.stdout.contains("candidates"), "{}", text.stdout);
}
