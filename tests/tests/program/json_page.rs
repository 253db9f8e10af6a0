//! `formats/json-1.md`: every key that a command prints with `--json` is on the page, under its command, and
//! the page names no key that is never printed.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::Value;
use vademecum_tests::bending::BENT;
use vademecum_tests::program::{repository, vademecum};

/// Names between backticks in the first cells of the tables of the page's section.
fn keys_of(section: &str) -> BTreeSet<String> {
    let path = repository().join("formats/json-1.md");
    let page = std::fs::read_to_string(path).expect("the page");
    let part = page.split("\n## ").find(|part| part.lines().next() == Some(section));
    let part = part.unwrap_or_else(|| panic!("no section `{section}`"));
    let rows = part.lines().filter_map(|line| line.strip_prefix("| `"));
    let names = rows.flat_map(|row| {
        let first = format!("`{}", row.split('|').next().unwrap_or_default());
        let quoted: Vec<String> = first.split('`').skip(1).step_by(2).map(str::to_string).collect();
        quoted
    });
    names.map(|name| name.trim_end_matches('.').to_string()).collect()
}

/// Every key of a value and of what is below.
fn printed(value: &Value, keys: &mut BTreeSet<String>) {
    match value {
        Value::Object(object) => object.iter().for_each(|(key, value)| {
            keys.insert(key.clone());
            printed(value, keys);
        }),
        Value::Array(items) => items.iter().for_each(|item| printed(item, keys)),
        _ => {}
    }
}

/// Runs lines of the program in a folder and compares their keys with the sections of the page.
fn compare(folder: &Path, sections: &[&str], lines: &[&str]) {
    let mut found = BTreeSet::new();
    for line in lines {
        let arguments = line.split_whitespace().map(|word| {
            let path = folder.join(word);
            let is_number = word.parse::<f64>().is_ok();
            let is_file = (word.contains('.') && !is_number) || ["out", "bent"].contains(&word);
            if is_file && !word.starts_with("--") { path.display().to_string() } else { word.to_string() }
        });
        let ran = vademecum(&arguments.collect::<Vec<_>>());
        assert_eq!(ran.code, Some(0), "{line}: {}", ran.stderr);
        let value: Value = serde_json::from_str(&ran.stdout).unwrap_or_else(|e| panic!("{line}: {e}"));
        assert!(value.is_object(), "{line}");
        printed(&value, &mut found);
    }
    let own: BTreeSet<String> = sections.iter().flat_map(|section| keys_of(section)).collect();
    let known = &own | &keys_of("Shared");
    let missing: Vec<_> = found.difference(&known).collect();
    assert!(missing.is_empty(), "{missing:?} of {lines:?} are not on the page");
    let idle: Vec<_> = keys_of(sections[0]).into_iter().filter(|key| !found.contains(key)).collect();
    assert!(idle.is_empty(), "{idle:?} are on the page, and {lines:?} do not print them");
}

const LIVE: &str = r#"
representation = "separated"
[mesh]
block = { lengths = [1.0, 0.1, 0.1], divisions = [4, 1, 1], order = "linear" }
[[mesh.region]]
name = "tip"
on = { fraction = { axis = "x", side = "max", fraction = 0.5 } }
[[material]]
young = 2e9
poisson = 0.3
density = 1200.0
[[support]]
on = { group = "x_min" }
[time]
step = 1e-3
[snapshots]
positions = 2
[basis]
modes = 3
[tolerance]
error = 1.0
floor_ratio = 100.0
map = 1e-3
[[parameter]]
name = "stiffness"
kind = "stiffness"
region = "tip"
range = [0.5, 2.0]
"#;

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (from, to) in [
        ("problems/short-beam.toml", "beam.toml"),
        ("scenarios/short-push.toml", "push.toml"),
        ("meshes/cube.msh", "cube.msh"),
        ("golden/canonical.vdm", "canonical.vdm"),
        ("golden/parameters.vdm", "parameters.vdm"),
        ("golden/free.vdm", "free.vdm"),
        ("golden/parametric.vdm", "parametric.vdm"),
        ("golden/damped.vdm", "damped.vdm"),
        ("golden/patch.vdm", "patch.vdm"),
        ("golden/ports.vdm", "ports.vdm"),
        ("golden/reactions.vdm", "reactions.vdm"),
        ("golden/separation.vdm", "separation.vdm"),
    ] {
        let from = repository().join("fixtures").join(from);
        std::fs::copy(&from, folder.path().join(to)).unwrap_or_else(|e| panic!("{}: {e}", from.display()));
    }
    std::fs::write(folder.path().join("live.toml"), LIVE).expect("written");
    std::fs::write(folder.path().join("bent.toml"), BENT).expect("written");
    let beam = folder.path().join("beam.toml");
    let text = std::fs::read_to_string(&beam).expect("a problem");
    let output = "[output]\nstress = { group = \"x_min\" }\n[[output.probe]]";
    std::fs::write(&beam, text.replacen("[[output.probe]]", output, 1)).expect("written");
    folder
}

#[test]
fn every_command_prints_the_keys_of_its_page() {
    let folder = folder();
    let at = folder.path();
    compare(
        at,
        &["build"],
        &[
            "build beam.toml -o beam.vdm --json",
            "build live.toml -o live.vdm --json --keep-missed",
            "build bent.toml -o bent.vdm --json --keep-missed",
        ],
    );
    let path = |name: &str| at.join(name).display().to_string();
    let rounded = ["pack", &path("beam.vdm"), "-o", &path("rounded.vdm"), "--tolerance", "1e-4"];
    assert_eq!(vademecum(&rounded).code, Some(0));
    compare(
        at,
        &["info"],
        &[
            "info beam.vdm --json",
            "info canonical.vdm --json",
            "info free.vdm --json",
            "info patch.vdm --json",
            "info parametric.vdm --json",
            "info damped.vdm --json",
            "info ports.vdm --json",
            "info reactions.vdm --json",
            "info live.vdm --json --terms-for 1e-2",
            "info parameters.vdm --json",
            "info separation.vdm --json",
            "info rounded.vdm --json",
        ],
    );
    compare(at, &["mesh"], &["mesh cube.msh --json"]);
    std::fs::write(at.join("sweep.toml"), "problems = [\"beam.toml\"]\n").expect("written");
    compare(at, &["plan"], &["plan sweep.toml -o out --json"]);
    let planned = |name: &str| at.join("out").join(name).display().to_string();
    assert_eq!(vademecum(&["build", &planned("1.toml"), "-o", &planned("1.vdm")]).code, Some(0));
    compare(at, &["collect"], &["collect out --json"]);
    std::fs::remove_dir_all(at.join("out")).expect("removed");
    compare(at, &["modes"], &["modes beam.toml --count 2 --mesh-error --json"]);
    std::fs::copy(repository().join("fixtures/decks/bar.inp"), at.join("bar.inp")).expect("copied");
    compare(at, &["modes of a deck"], &["modes bar.inp --count 2 --json"]);
    compare(at, &["static"], &["static bar.inp --json"]);
    compare(at, &["init"], &["init cube.msh -o cube.toml --json"]);
    let frf =
        "frf beam.vdm --in gravity --out tip --range 1,10 --points 3 --json --problem beam.toml --compare 2";
    compare(at, &["frf"], &[frf]);
    std::fs::write(at.join("f.csv"), "frequency_hz\n20\n60\n90\n").expect("written");
    compare(at, &["calibrate"], &["calibrate parametric.vdm --data f.csv --fit beta -o fitted.vdm --json"]);
    compare(at, &["run"], &["run beam.vdm --scenario push.toml -o out --plot probes.svg --json"]);
    std::fs::write(at.join("none.toml"), "duration = 0.01\n").expect("written");
    std::fs::write(at.join("sets.csv"), "beta\n1e-5\n").expect("written");
    compare(
        at,
        &["run of many bodies"],
        &["run parametric.vdm --scenario none.toml --sets sets.csv -o out --json"],
    );
    let still = "duration = 0.05\n[[contact]]\npoint = [1.0, 0.05, 0.1]\nforce = [0.0, 0.0, -1.0]\n";
    std::fs::write(at.join("still.toml"), still).expect("written");
    compare(
        at,
        &["verify"],
        &[
            "verify beam.vdm --problem beam.toml --scenario push.toml --mesh --json",
            "verify live.vdm --problem live.toml --scenario still.toml --json",
        ],
    );
    compare(
        at,
        &["verify of large displacements"],
        &["verify bent.vdm --problem bent.toml --scenario still.toml --json"],
    );
}

#[test]
fn commands_that_rewrite_and_write_print_the_keys_of_their_page() {
    let folder = folder();
    let at = folder.path();
    for (problem, file) in [("beam.toml", "beam.vdm"), ("live.toml", "live.vdm")] {
        let path = |name: &str| at.join(name).display().to_string();
        let ran = vademecum(&["build", &path(problem), "-o", &path(file), "--keep-missed"]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    }
    let patch = repository().join("fixtures/golden/patch.vdm");
    std::fs::copy(patch, at.join("patch.vdm")).expect("copied");
    let commands = ["verify beam.vdm --file-only --json", "verify patch.vdm --file-only --json"];
    compare(at, &["verify --file-only"], &commands);
    compare(
        at,
        &["pack, unpack, strip"],
        &[
            "pack beam.vdm -o packed.vdm --json",
            "unpack packed.vdm -o raw.vdm --json",
            "strip beam.vdm --keep probes -o probes.vdm --json",
            "strip live.vdm --terms-for 0.1 -o fewer.vdm --json",
        ],
    );
    compare(at, &["export matrices"], &["export matrices beam.toml --modes 4 --steps 20 -o out --json"]);
    for name in ["foot.toml", "arm.toml", "assembly.toml"] {
        std::fs::copy(repository().join("tests/reader/joined").join(name), at.join(name)).expect("copied");
    }
    for (problem, file) in [("foot.toml", "foot.vdm"), ("arm.toml", "arm.vdm")] {
        let path = |name: &str| at.join(name).display().to_string();
        assert_eq!(vademecum(&["build", &path(problem), "-o", &path(file), "--keep-missed"]).code, Some(0));
    }
    compare(at, &["assemble"], &["assemble assembly.toml -o whole.vdm --json"]);
    let world = "format = 1\n[world]\ntime = 1e-2\n[[part]]\nname = \"beam\"\nfile = \"foot.vdm\"\n[[part]]\n\
                 name = \"box\"\nrigid = { box = { lengths = [0.1, 0.1, 0.1] }, density = 1e3 }\nposition = [0, 0, \
                 1]\n[[contact]]\nbetween = [\"box\", \"beam\"]\n";
    std::fs::write(at.join("world.toml"), world).expect("written");
    compare(at, &["run of a world"], &["run world.toml -o world.csv --vtu out --json"]);
    compare(
        at,
        &["export craig-bampton"],
        &["export craig-bampton beam.toml --interface x_max --modes 4 -o out --json"],
    );
    compare(at, &["export fmu"], &["export fmu beam.vdm -o beam.fmu --json"]);
    compare(at, &["export uff"], &["export uff beam.vdm -o beam.uff --json"]);
    compare(at, &["sensors"], &["sensors beam.vdm --count 4 --modes 2 --json"]);
    compare(at, &["export state-space"], &["export state-space beam.vdm --structure exact -o out --json"]);
    compare(
        at,
        &["report, view --export"],
        &["report beam.vdm -o page.html --json", "view beam.vdm --export view.html --json"],
    );
}

#[test]
fn a_demo_and_a_comparison_print_the_keys_of_their_page() {
    let folder = folder();
    let at = folder.path();
    compare(at, &["demo", "verify", "build"], &["demo -o out --json"]);
    compare(at, &["demo --large", "build"], &["demo --large -o bent --json"]);
    let bench = "bench beam.toml -o out --quick --modes 8 --json --force";
    compare(at, &["bench"], &[bench]);
    let large = "bench bent.toml -o out --quick --steps 20 --json --force";
    compare(at, &["bench of large displacements"], &[large]);
}
