//! `vademecum calibrate`: what a run, a response and natural frequencies of known parameters give back, and
//! tables that are refused by their line.

use std::path::{Path, PathBuf};

use serde_json::Value;
use tempfile::TempDir;
use vademecum_tests::live_beam::LiveBeam;
use vademecum_tests::program::{Ran, vademecum};

const TAP: &str =
    "duration = 0.2\n[[contact]]\npoint = [0.6, 0.05, 0.12]\nforce = [0.0, -4.0, -9.0]\nend = 0.004\n";

struct Bench(TempDir);

impl Bench {
    fn new(beam: LiveBeam) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("beam.vdm"), beam.build(None)).expect("written");
        std::fs::write(folder.path().join("tap.toml"), TAP).expect("written");
        Self(folder)
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs a line of the program; words with a dot or a slash and no number are files of the folder.
    fn run(&self, line: &str) -> Ran {
        let is_file = |word: &str| {
            word.contains(['.', '/']) && !word.contains(['=', ',']) && word.parse::<f64>().is_err()
        };
        let word = |word: &str| {
            if is_file(word) { self.at(word).display().to_string() } else { word.to_string() }
        };
        vademecum(&line.split_whitespace().map(word).collect::<Vec<_>>())
    }

    fn done(&self, line: &str) -> Ran {
        let ran = self.run(line);
        assert_eq!(ran.code, Some(0), "{line}: {}", ran.stderr);
        ran
    }

    /// Estimates of `--json` by name.
    fn estimates(&self, line: &str) -> (Value, Vec<(String, f64)>) {
        let value: Value = serde_json::from_str(&self.done(line).stdout).expect("JSON");
        let of = |own: &Value| {
            let name = own["name"].as_str().expect("a name").to_string();
            (name, own["value"].as_f64().expect("a number"))
        };
        let estimates = value["estimates"].as_array().expect("a list").iter().map(of).collect();
        (value, estimates)
    }
}

fn beam(regions: usize, both_ends: bool) -> LiveBeam {
    LiveBeam { regions, height: 0.12, modes: 48, both_ends, fine: 2, step: 1e-3 }
}

fn close(found: &[(String, f64)], expected: &[(&str, f64)], within: f64) {
    for (name, value) in expected {
        let own =
            found.iter().find(|(own, _)| own == name).unwrap_or_else(|| panic!("no {name} in {found:?}"));
        assert!((own.1 / value - 1.0).abs() < within, "{name}: {} beside {value}", own.1);
    }
}

#[test]
fn known_parameters_come_back_from_a_run_a_response_and_frequencies() {
    let bench = Bench::new(beam(3, true));
    let known = "--set k1=0.8 --set k2=1.3 --set k3=0.9 --set beta=2e-4";
    bench.done(&format!("run beam.vdm --scenario tap.toml {known} -o measured/"));
    let line = "calibrate beam.vdm --data measured/probes.csv --scenario tap.toml -o fitted.vdm --json";
    let (value, found) = bench.estimates(line);
    let truth = [("k1", 0.8), ("k2", 1.3), ("k3", 0.9), ("beta", 2e-4)];
    // Without noise what is left is ten digits of the table.
    close(&found, &truth, 1e-5);
    assert!(value["converged"] == true && value["undetermined"] == Value::Array(vec![]), "{value}");
    assert!(value["chi_squared"].as_f64().expect("a number") < 1e-6, "{value}");
    assert!(value["meaning"].as_str().expect("words").starts_with("less than 1"), "{value}");
    // The file that is written is an ordinary one at the fitted values.
    bench.done("run fitted.vdm --scenario tap.toml -o again/");
    let rows = |folder: &str| {
        let text = std::fs::read_to_string(bench.at(folder).join("probes.csv")).expect("a table");
        let row = text.lines().nth(150).expect("a row");
        row.split(',').map(|cell| cell.parse().expect("a number")).collect::<Vec<f64>>()
    };
    let (first, second) = (rows("measured"), rows("again"));
    assert!(
        first.iter().zip(&second).all(|(a, b)| (a - b).abs() <= 1e-4 * a.abs().max(1e-9)),
        "{first:?} {second:?}"
    );

    bench.done(&format!(
        "frf beam.vdm --in 0.6,0.05,0.12,z --out s0z --out s2z --range 20,400 {known} -o frf.csv"
    ));
    let (_, found) = bench.estimates("calibrate beam.vdm --data frf.csv --in 0.6,0.05,0.12,z --json");
    close(&found, &truth, 1e-4);

    let (set, _) = bench.estimates(&format!("{line} --force"));
    assert_eq!(set["fits"][0]["numbers"], 9 * 201);
    let frequencies: Vec<String> = {
        let ran = bench.done("info fitted.vdm --json");
        let info: Value = serde_json::from_str(&ran.stdout).expect("JSON");
        let modes = info["mode_table"].as_array().expect("a table");
        modes.iter().take(8).map(|mode| mode["frequency_hz"].to_string()).collect()
    };
    std::fs::write(bench.at("f.csv"), format!("frequency_hz\n{}\n", frequencies.join("\n")))
        .expect("written");
    let (value, found) =
        bench.estimates("calibrate beam.vdm --data f.csv --fit k1 --fit k2 --fit k3 --set k3=1.0 --json");
    // A beam that is the same from either end has the frequencies of its mirror image: k1 and k3 may be
    // swapped.
    let mut ends = [found[0].1, found[2].1];
    ends.sort_by(f64::total_cmp);
    assert!((ends[0] / 0.8 - 1.0).abs() < 1e-3 && (ends[1] / 0.9 - 1.0).abs() < 1e-3, "{found:?} {value}");
    close(&found, &[("k2", 1.3)], 1e-3);
}

#[test]
fn a_region_that_hardly_strains_is_named_as_not_determined() {
    let bench = Bench::new(beam(6, false));
    bench.done("run beam.vdm --scenario tap.toml -o measured/");
    let text = bench.done("calibrate beam.vdm --data measured/probes.csv --scenario tap.toml").stdout;
    let said =
        text.lines().find(|line| line.starts_with("not determined:")).unwrap_or_else(|| panic!("{text}"));
    assert!(said.contains("k6") && said.contains("--fit"), "{said}");
}

#[test]
fn tables_and_arguments_that_cannot_be_used_are_refused_by_their_line() {
    let bench = Bench::new(beam(3, true));
    let write = |text: &str| std::fs::write(bench.at("m.csv"), text).expect("written");
    let refused = |more: &str, code: i32, words: &[&str]| {
        bench.run(&format!("calibrate beam.vdm --data m.csv {more}")).fails(code, words);
    };
    let tap = "--scenario tap.toml";
    write("time_s,s0z [m]\n0,0\n0.001,1e-6\n0.003,2e-6\n");
    refused(tap, 3, &["m.csv:4", "time 0.003 s, 0.002 s after the row before", "a gap"]);
    write("time_s,s0z [m]\n0,0\n0.0013,1e-6\n");
    refused(tap, 3, &["m.csv:3", "time 0.0013 s", "a multiple of the step", "--time-step"]);
    write("time_s,s0z [m]\n0,0\n0.001,1e-6\n0.001,1e-6\n");
    refused(tap, 3, &["m.csv:4", "a time after 0.001 s"]);
    write("time_s,s0z [m]\n0,0\n0.5,1e-6\n");
    refused(tap, 3, &["m.csv:3", "at most 0.2 s, the end of the scenario"]);
    write("time_s,s0q [m]\n0,0\n");
    refused(tap, 3, &["m.csv:1", "unknown column `s0q`", "`s0z`", "did you mean"]);
    write("time_s,s0z [mm]\n0,0\n");
    refused(tap, 3, &["m.csv:1", "column `s0z` in mm; expected m"]);
    write("time_s,s0z [m]\n0,0\n0.001,x\n");
    refused(tap, 3, &["m.csv:3", "`x` in column `s0z`", "a finite number"]);
    write("time_s,s0z [m]\n0,0\n0.001,0\n0.002,0\n");
    refused(tap, 3, &["m.csv:1", "zero throughout", "--noise-over all"]);
    write("time_s,s0z [m]\n0,0\n0.001,1e-6\n");
    refused(tap, 2, &["2 measured numbers for 4 parameters", "--fit"]);
    refused("", 3, &["m.csv", "--scenario FILE"]);
    refused(&format!("{tap} {tap}"), 2, &["`--scenario` is given 2 times for 1 tables"]);
    refused(&format!("{tap} --fit k9"), 2, &["no live parameter `k9`", "`k1`, `k2`, `k3`, `beta`"]);
    refused(&format!("{tap} --fit k1 --fit k1"), 2, &["`--fit \"k1\"` is given twice"]);
    refused(&format!("{tap} --set k1=9"), 2, &["`k1` is 9; expected a value from 0.5 to 2"]);
    write("pressure\n1\n");
    refused("", 3, &["m.csv:1", "the first column is `pressure`"]);
    write("mode,frequency_hz\n1,100\n99,200\n");
    refused("", 3, &["m.csv:3", "mode 99", "a mode from 1 to 32"]);
    write("frequency_hz,re s0z [m/N],im s0z [m/N]\n10,1,0\n5,1,0\n");
    refused("", 3, &["--in CHANNEL"]);
    refused("--in 0.6,0.05,0.12,z", 3, &["m.csv:3", "frequency 5 Hz; expected more than 10"]);
    write("frequency_hz,abs s0z [m/N]\n10,1\n");
    refused("--in 0.6,0.05,0.12,z", 3, &["m.csv:1", "unknown column `abs s0z`", "`re OUTPUT [unit]`"]);
    bench.run("calibrate beam.vdm --data none.csv").fails(1, &["none.csv"]);

    // Nothing that is read is written.
    for output in ["beam.vdm", "m.csv", "tap.toml"] {
        let line = format!("calibrate beam.vdm --data m.csv {tap} -o {output} --force");
        bench.run(&line).fails(2, &[output, "the command reads this file"]);
    }
    let fixed = vademecum_tests::golden::named("fixed-f64.vdm");
    std::fs::write(bench.at("fixed.vdm"), fixed).expect("written");
    bench.run("calibrate fixed.vdm --data m.csv").fails(7, &["fixed.vdm", "representation = \"parametric\""]);
    assert!(Path::new(&bench.at("m.csv")).exists());
}
