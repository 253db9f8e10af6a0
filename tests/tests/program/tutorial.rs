//! The tutorial and the gallery, as a reader goes through them.

use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;

use vademecum_build::input::Problem;
use vademecum_tests::program::{program, repository, vademecum};

/// Gmsh, installed once for both tests. Outside CI a machine without Python or without a registry skips; in
/// CI that is a failure.
fn gmsh() -> Option<String> {
    static GMSH: OnceLock<Option<String>> = OnceLock::new();
    GMSH.get_or_init(installed).clone()
}

fn installed() -> Option<String> {
    let output = Command::new("sh").arg(repository().join("tests/scripts/gmsh")).output().expect("a shell");
    if output.status.success() {
        return Some(String::from_utf8(output.stdout).expect("a path").trim().to_string());
    }
    let why = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(std::env::var_os("CI").is_none(), "no Gmsh: {why}");
    eprintln!("skipped: no Gmsh: {why}");
    None
}

fn copy_all(from: &Path, to: &Path) {
    for entry in std::fs::read_dir(from).expect("a folder") {
        let path = entry.expect("an entry").path();
        std::fs::copy(&path, to.join(path.file_name().expect("a name"))).expect("a copy");
    }
}

/// The blocks of shell commands on a page, in order.
fn commands(page: &str) -> Vec<String> {
    let blocks = page.split("```sh\n").skip(1);
    blocks.map(|block| block.split("```").next().expect("the end of a block").to_string()).collect()
}

#[test]
fn every_command_of_the_tutorial_runs_and_the_fork_has_its_pitch() {
    let Some(gmsh) = gmsh() else { return };
    let source = repository().join("docs/tutorials/tuning-fork");
    let folder = tempfile::tempdir().expect("a folder");
    copy_all(&source, folder.path());
    let page = std::fs::read_to_string(source.join("README.md")).expect("the page");
    let found = commands(&page);
    assert!(found.len() >= 8, "{} blocks of commands", found.len());

    let program = program().canonicalize().expect("the program");
    let folders = [program.parent(), Path::new(&gmsh).parent()].map(|folder| folder.expect("a folder"));
    let path = std::env::var("PATH").expect("a path");
    let path = format!("{}:{}:{path}", folders[0].display(), folders[1].display());
    let mut said = String::new();
    for block in &found {
        let mut shell = Command::new("sh");
        let ran =
            shell.args(["-euc", block]).current_dir(&folder).env("PATH", &path).output().expect("a shell");
        let error = String::from_utf8_lossy(&ran.stderr);
        assert!(ran.status.success(), "{block}\n{error}");
        said += &String::from_utf8_lossy(&ran.stdout);
    }

    let number = |fits: &dyn Fn(&str) -> bool, column: usize| -> f64 {
        let line =
            said.lines().find(|line| fits(line)).unwrap_or_else(|| panic!("a line is missing:\n{said}"));
        line.split_whitespace().nth(column).expect("a column").parse().expect("a number")
    };
    // The prongs pass through zero as often as the third mode of `modes` has them: the page says 440.0.
    let pitch = number(&|line| line.ends_with(" Hz") && line.split_whitespace().count() == 2, 0);
    let third = number(&|line| line.starts_with("   3 "), 1);
    assert!((pitch - third).abs() < 0.05 && (third - 440.0).abs() < 1.0, "{pitch} Hz, {third} Hz");
    let ratio = number(&|line| line.starts_with("ratio "), 1);
    assert!((ratio / 2.03e-4 - 1.0).abs() < 0.01, "{ratio}");
}

#[test]
fn the_gallery_builds_and_its_numbers_are_those_of_the_page() {
    let source = repository().join("docs/gallery");
    for entry in std::fs::read_dir(&source).expect("a folder") {
        let path = entry.expect("an entry").path();
        let scenario = ["touch.toml", "crossing.toml", "shelf.toml"].iter().any(|name| path.ends_with(name));
        let world = WORLDS.iter().any(|name| path.ends_with(format!("{name}.toml")));
        if path.extension().is_some_and(|kind| kind == "toml") && !scenario && !world {
            Problem::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    copy_all(&source, folder.path());
    let at = |name: &str| folder.path().join(name).display().to_string();
    let lowest = |body: &str, scenario: &str, probes: usize| -> Vec<f64> {
        let (problem, file, out) = (at(&format!("{body}.toml")), at(&format!("{body}.vdm")), at(body));
        let built = vademecum(&["build", &problem, "-o", &file]);
        assert_eq!(built.code, Some(0), "{}", built.stderr);
        let ran = vademecum(&["run", &file, "--scenario", &at(scenario), "-o", &out]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        let table = std::fs::read_to_string(Path::new(&out).join("probes.csv")).expect("a table");
        let rows = table.lines().skip(1).map(|row| row.split(',').map(|x| x.parse().expect("a number")));
        let rows: Vec<Vec<f64>> = rows.map(Iterator::collect).collect();
        (0..probes).map(|probe| rows.iter().map(|row| row[2 + probe]).fold(0.0, f64::min)).collect()
    };
    let [sunk] = lowest("bridge", "crossing.toml", 1)[..] else { panic!("one probe") };
    assert!((sunk + 3.7e-3).abs() < 0.1e-3, "{sunk} m");
    let Some(gmsh) = gmsh() else { return };
    let meshed =
        Command::new(gmsh).args(["-v", "2", "-3", &at("organ.geo"), "-o", &at("organ.msh")]).status();
    assert!(meshed.expect("Gmsh").success());
    let [over, beside] = lowest("organ", "touch.toml", 2)[..] else { panic!("two probes") };
    assert!((over + 3.0e-4).abs() < 0.2e-4 && (beside + 7.8e-4).abs() < 0.4e-4, "{over} m, {beside} m");
}

/// Worlds of the gallery.
const WORLDS: [&str; 5] = ["tower", "chain", "gripper", "xylophone", "pile"];

/// Bars of the xylophone as `docs/gallery/make` writes them.
fn bars(folder: &Path) {
    let make = std::fs::read_to_string(repository().join("docs/gallery/make")).expect("the script");
    let lengths =
        make.split("for length in ").nth(1).and_then(|rest| rest.split(';').next()).expect("lengths");
    let text = std::fs::read_to_string(folder.join("bar.toml")).expect("a bar");
    for (i, length) in lengths.split_whitespace().enumerate() {
        let number: f64 = length.parse().expect("a length");
        let places = [("0.069451", 0.199), ("0.087599", 0.251), ("0.261401", 0.749), ("0.279549", 0.801)];
        let place =
            |text: String, (from, share): (&str, f64)| text.replace(from, &(share * number).to_string());
        let own = places.into_iter().fold(text.replace("0.349,", &format!("{length},")), place);
        std::fs::write(folder.join(format!("bar{}.toml", i + 1)), own).expect("written");
    }
}

#[test]
fn the_worlds_of_the_gallery_do_what_the_page_says() {
    let folder = tempfile::tempdir().expect("a folder");
    copy_all(&repository().join("docs/gallery"), folder.path());
    bars(folder.path());
    let at = |name: &str| folder.path().join(name).display().to_string();
    let build = |part: &str| {
        let built = vademecum(&["build", &at(&format!("{part}.toml")), "-o", &at(&format!("{part}.vdm"))]);
        assert_eq!(built.code, Some(0), "{part}: {}", built.stderr);
    };
    let bars = (1..=10).map(|i| format!("bar{i}"));
    let others = ["link", "jelly", "finger", "mallet", "hammer", "brick"].map(String::from);
    others.into_iter().chain(bars).for_each(|part| build(&part));
    // Report, and the last row of the table; of a shorter march.
    let run = |world: &str, time: &str| -> (serde_json::Value, Vec<(String, f64)>) {
        let path = at(&format!("{world}.toml"));
        let text = std::fs::read_to_string(&path).expect("a world");
        let given = text.lines().find(|line| line.starts_with("time = ")).expect("a time");
        std::fs::write(&path, text.replacen(given, time, 1)).expect("written");
        let table = at(&format!("{world}.csv"));
        let ran = vademecum(&["run", &path, "-o", &table, "--json"]);
        assert_eq!(ran.code, Some(0), "{world}: {}", ran.stderr);
        let table = std::fs::read_to_string(table).expect("a table");
        let names = table.lines().next().expect("names").split(',').map(String::from);
        let numbers = table.lines().last().expect("a row").split(',').map(|x| x.parse().expect("a number"));
        (serde_json::from_str(&ran.stdout).expect("JSON"), names.zip(numbers).collect())
    };
    let of =
        |row: &[(String, f64)], name: &str| row.iter().find(|(other, _)| other == name).expect("a column").1;
    let (_, lifted) = run("gripper", "time = 1.7");
    assert!((of(&lifted, "cube z [m]") - 0.1).abs() < 3e-3, "{lifted:?}");
    let (report, _) = run("xylophone", "time = 0.9");
    assert!(report["contacts_at_most"].as_u64().expect("a count") > 9, "{report}");
    let (_, tip) = run("chain", "time = 0.4");
    assert!(of(&tip, "tip z [m]") < -0.3, "{tip:?}");
    let (report, pile) = run("pile", "time = 0.4");
    assert!(
        report["contacts_at_most"].as_u64().expect("a count") > 300 && pile.len() == 5,
        "{report} {pile:?}"
    );
    let Some(gmsh) = gmsh() else { return };
    for (count, part) in [("1", "storey"), ("3", "storeys")] {
        let mesh = at(&format!("{part}.msh"));
        let geo = at("storey.geo");
        let arguments = ["-v", "2", "-3", &geo, "-setnumber", "storeys", count, "-o", &mesh];
        assert!(Command::new(&gmsh).args(arguments).status().expect("Gmsh").success());
        build(part);
    }
    let (report, fallen) = run("tower", "time = 4.4");
    assert_eq!(report["joints_broken"], 4);
    assert!(of(&fallen, "top z [m]") < 0.4, "{fallen:?}");
}
