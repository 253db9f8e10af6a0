//! The folder of a run: it belongs to one run at a time, a refused run leaves it as it was, and what the
//! tables in it are called is clear.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use vademecum_tests::program::{Ran, repository, vademecum};

const BASE: &str = "duration = 0.02\n[[pattern]]\nname = \"pull\"\n";

/// A folder with a file and a scenario.
struct Place(tempfile::TempDir);

impl Place {
    fn new(file: &str) -> Self {
        let place = Self(tempfile::tempdir().expect("a folder"));
        std::fs::copy(repository().join("fixtures/golden").join(file), place.at("a.vdm")).expect("copied");
        place
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        std::fs::write(self.at(name), text).expect("written");
    }

    fn run(&self, scenario: &str, more: &[&str]) -> Ran {
        self.write("s.toml", scenario);
        let [file, scenario, out] =
            ["a.vdm", "s.toml", "out"].map(|name| self.at(name).display().to_string());
        vademecum(&[&["run", &file, "--scenario", &scenario, "-o", &out], more].concat())
    }

    /// Every file of the results.
    fn results(&self) -> BTreeMap<String, Vec<u8>> {
        let entries = std::fs::read_dir(self.at("out")).into_iter().flatten().flatten();
        let file = |path: &Path| {
            (path.file_name().expect("a name").to_string_lossy().into_owned(), path.to_path_buf())
        };
        let named = entries.map(|entry| file(&entry.path()));
        named.map(|(name, path)| (name, std::fs::read(path).expect("readable"))).collect()
    }

    fn names(&self) -> Vec<String> {
        self.results().into_keys().collect()
    }
}

fn ends(ran: &Ran) {
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
}

#[test]
fn a_refused_run_leaves_the_results_of_the_run_before() {
    let place = Place::new("fixed-f64.vdm");
    let with_fields = format!("{BASE}[output]\nfields_every = 5\n");
    ends(&place.run(&with_fields, &[]));
    let before = place.results();
    assert!(before.len() > 4, "{:?}", before.keys());
    for (scenario, more, code) in [
        (BASE, &["--structure", "chapter"][..], 7),
        (BASE, &["--set", "nothing=1"], 2),
        (BASE, &["--time-step", "1e-200"], 3),
        ("duration = 0.02\n[[pattern]]\nname = \"none\"\n", &[], 3),
        ("duration = 0.02\n[[pattern]]\nname = \"pull\"\namplitude = 1e76\n", &[], 3),
        (
            "duration = 0.02\n[[output.probe]]\nname = \"energy_J\"\npoint = [0, 0, 0]\ndirection = [0, 0, 1]\n",
            &[],
            3,
        ),
    ] {
        let ran = place.run(scenario, more);
        assert_eq!(ran.code, Some(code), "{more:?}: {}", ran.stderr);
        assert_eq!(place.results(), before, "{more:?}: {}", ran.stderr);
    }
}

#[test]
fn a_run_removes_what_the_run_before_has_listed_and_nothing_else() {
    let place = Place::new("stress.vdm");
    let pull = BASE.replace("pull", &first_pattern(&place));
    let all = format!("{pull}[output]\nfields_every = 4\nstress_every = 10\n");
    ends(&place.run(&all, &[]));
    let names = place.names();
    assert!(
        ["run.json", "stress.csv", "fields.pvd", "field-000001.vtu"]
            .iter()
            .all(|name| names.contains(&(*name).into())),
        "{names:?}"
    );
    // Files of somebody else, some of them of names that a run may write.
    place.write("out/notes.txt", "mine");
    place.write("out/field-000900.vtu", "<VTKFile type=\"UnstructuredGrid\">");
    ends(&place.run(&format!("{pull}[output]\nfields_every = 10\n"), &[]));
    let list: serde_json::Value = serde_json::from_slice(&place.results()["run.json"]).expect("JSON");
    let fields = list["field_files"].as_u64().expect("a count") as usize;
    assert_eq!(list["files_of_vademecum_run"], serde_json::json!(["probes.csv", "fields.pvd"]));
    let mut expected: Vec<String> = (0..fields).map(|n| format!("field-{n:06}.vtu")).collect();
    expected
        .extend(["field-000900.vtu", "fields.pvd", "notes.txt", "probes.csv", "run.json"].map(String::from));
    assert_eq!(place.names(), expected);
    ends(&place.run(&pull, &[]));
    assert_eq!(place.names(), ["field-000900.vtu", "notes.txt", "probes.csv", "run.json"]);
    // A list that names what no run writes, and an input of this run.
    place.write(
        "out/run.json",
        "{\"files_of_vademecum_run\": [\"notes.txt\", \"../s.toml\", \"probes.csv\"], \"field_files\": 0}",
    );
    ends(&place.run(&pull, &[]));
    assert_eq!(place.names(), ["field-000900.vtu", "notes.txt", "probes.csv", "run.json"]);
    assert!(place.at("s.toml").exists());
}

/// Name of the first load pattern of the file.
fn first_pattern(place: &Place) -> String {
    let ran = vademecum(&["info", &place.at("a.vdm").display().to_string(), "--json"]);
    ran.json()["load_patterns"][0].as_str().expect("a pattern").to_string()
}

#[test]
fn a_list_of_somebody_else_and_read_only_results_are_not_replaced() {
    let place = Place::new("fixed-f64.vdm");
    std::fs::create_dir(place.at("out")).expect("made");
    place.write("out/run.json", "{\"mine\": 1}");
    place.run(BASE, &[]).fails(2, &["run.json", "not overwritten", "--force"]);
    assert_eq!(place.names(), ["run.json"]);
    std::fs::remove_file(place.at("out/run.json")).expect("removed");
    ends(&place.run(BASE, &[]));
    let table = place.at("out/probes.csv");
    let old = std::fs::read(&table).expect("a table");
    let mut permissions = std::fs::metadata(&table).expect("there").permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(&table, permissions).expect("set");
    let longer = BASE.replace("0.02", "0.03");
    place.run(&longer, &[]).fails(2, &["probes.csv", "read-only", "--force"]);
    assert_eq!(std::fs::read(&table).expect("a table"), old);
    ends(&place.run(&longer, &["--force"]));
    assert_ne!(std::fs::read(&table).expect("a table"), old);
}

#[test]
fn no_two_columns_have_one_name() {
    let place = Place::new("fixed-f64.vdm");
    let probe = |name: &str| {
        format!("{BASE}[[output.probe]]\nname = \"{name}\"\npoint = [0, 0, 0]\ndirection = [0, 0, 1]\n")
    };
    for name in ["time_s", "energy_J"] {
        place.run(&probe(name), &[]).fails(3, &["s.toml", "two columns", name]);
    }
    let quantity = format!("{}[output]\nquantities = [\"kinetic_energy\"]\n", probe("kinetic_energy_J"));
    place.run(&quantity, &[]).fails(3, &["two columns", "kinetic_energy_J"]);
    let reactions = Place::new("reactions.vdm");
    let ran = vademecum(&["info", &reactions.at("a.vdm").display().to_string(), "--json"]);
    let support = ran.json()["supports"][0]["name"].as_str().expect("a support").to_string();
    let pattern = first_pattern(&reactions);
    let scenario = probe(&format!("reaction.{support}.fx")).replace("pull", &pattern);
    reactions.run(&scenario, &[]).fails(3, &["two columns", "reaction."]);
    ends(&place.run(&probe("mine"), &[]));
    let head = String::from_utf8(place.results()["probes.csv"].clone()).expect("text");
    assert!(head.starts_with("time_s,energy_J,"), "{head}");
    let problem =
        std::fs::read_to_string(repository().join("fixtures/problems/short-beam.toml")).expect("a problem");
    let [name, renamed] = ["name = \"tip\"", "name = \"time_s\""];
    assert!(problem.contains(name), "{problem}");
    place.write("p.toml", problem.replacen(name, renamed, 1));
    let arguments =
        ["build", &place.at("p.toml").display().to_string(), "-o", &place.at("b.vdm").display().to_string()];
    vademecum(&arguments).fails(3, &["time_s", "name"]);
}
