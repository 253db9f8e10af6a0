//! Many builds: `plan`, lines that are run, killed and run again, and `collect`.

use std::path::Path;
use std::process::Command;

use serde_json::Value;
use vademecum_tests::program::{repository, vademecum};

/// Blocks of TOML of the page of the sweep file.
fn examples() -> Vec<String> {
    let page = std::fs::read_to_string(repository().join("formats/sweep-1.md")).expect("the page");
    let blocks = page.split("```toml").skip(1);
    blocks.map(|block| block.split("```").next().unwrap_or_default().to_string()).collect()
}

/// A problem whose mesh is a file beside it.
const CUBE: &str = "[mesh]\nfile = \"cube.msh\"\n[[material]]\nyoung = 1e9\npoisson = 0.3\ndensity = 1000.0\n\
                    [[support]]\non = { fraction = { axis = \"z\", side = \"min\", fraction = 0.01 } }\n[load]\n";

/// A folder with the example's problem and a sweep.
fn folder(sweep: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let beam = repository().join("examples/sweep/beam.toml");
    std::fs::copy(beam, folder.path().join("beam.toml")).expect("copied");
    std::fs::write(folder.path().join("sweep.toml"), sweep).expect("written");
    folder
}

fn at(folder: &Path, name: &str) -> String {
    folder.join(name).display().to_string()
}

/// Plans the sweep of a folder into its folder `jobs`; exit code and what was said of errors.
fn plan(folder: &Path) -> (Option<i32>, String) {
    let ran = vademecum(&["plan", &at(folder, "sweep.toml"), "-o", &at(folder, "a folder's jobs")]);
    (ran.code, ran.stderr)
}

/// What `collect` prints as JSON, and its exit code.
fn collect(folder: &Path) -> (Option<i32>, Value) {
    let ran = vademecum(&["collect", &at(folder, "a folder's jobs"), "--json"]);
    (ran.code, serde_json::from_str(&ran.stdout).expect("JSON"))
}

fn states(collected: &Value) -> Vec<&str> {
    let jobs = collected["jobs"].as_array().expect("jobs");
    jobs.iter().map(|job| job["state"].as_str().expect("a state")).collect()
}

/// Runs a line in a shell that finds the program, in another folder.
fn run(line: &str) -> std::process::Output {
    let program = vademecum_tests::program::program();
    let path = std::env::var("PATH").unwrap_or_default();
    let path = format!("{}:{path}", program.parent().expect("a folder").display());
    Command::new("sh").args(["-c", line]).current_dir("/").env("PATH", path).output().expect("a shell")
}

fn lines(folder: &Path) -> Vec<String> {
    let list = std::fs::read_to_string(folder.join("a folder's jobs/jobs.txt")).expect("a list");
    list.lines().map(str::to_string).collect()
}

#[test]
fn jobs_are_planned_run_lost_and_run_again() {
    let sweep = std::fs::read_to_string(repository().join("examples/sweep/sweep.toml")).expect("the example");
    let folder = folder(&(sweep + "\n[[vary]]\nkey = \"output.precision\"\nvalues = [\"f64\"]\n"));
    let folder = folder.path();
    assert_eq!(plan(folder), (Some(0), String::new()));
    let lines = lines(folder);
    assert_eq!(lines.len(), 6);
    let (code, collected) = collect(folder);
    assert_eq!((code, states(&collected)), (Some(7), vec!["missing"; 6]));

    for line in &lines[1..] {
        let ran = run(line);
        assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    }
    let (code, collected) = collect(folder);
    assert_eq!(code, Some(7));
    assert_eq!(states(&collected), ["missing", "done", "done", "done", "done", "done"]);
    let figure = |job: usize, key: &str| collected["jobs"][job][key].as_f64().expect(key);
    // Four times as stiff, twice the frequency; modes are those of the job.
    let ratio = figure(5, "first_frequency_hz") / figure(1, "first_frequency_hz");
    assert!((ratio - 2.0).abs() < 1e-9, "{ratio}");
    assert_eq!([figure(2, "modes"), figure(3, "modes")], [4.0, 8.0]);
    assert_eq!(collected["jobs"][4]["values"]["material[0].young"], 4e9);

    // A line that is run once more changes nothing; a damaged file and one of another job are built anew.
    let file = |job: usize| folder.join(format!("a folder's jobs/{job}.vdm"));
    let before = [2, 3, 4].map(|job| std::fs::read(file(job)).expect("a file"));
    let written = std::fs::metadata(file(2)).and_then(|found| found.modified()).expect("a time");
    assert!(run(&lines[1]).status.success());
    assert_eq!(std::fs::metadata(file(2)).and_then(|found| found.modified()).expect("a time"), written);
    let mut damaged = before[1].clone();
    *damaged.last_mut().expect("bytes") ^= 1;
    std::fs::write(file(3), damaged).expect("written");
    std::fs::copy(file(5), file(4)).expect("copied");
    let (_, collected) = collect(folder);
    assert_eq!(states(&collected), ["missing", "done", "damaged", "foreign", "done", "done"]);
    assert!(collected["jobs"][2]["reason"].as_str().is_some_and(|reason| reason.contains("checksum")));

    let left = at(folder, "left.txt");
    let table = at(folder, "table.csv");
    let ran = vademecum(&["collect", &at(folder, "a folder's jobs"), "--left", &left, "-o", &table]);
    assert_eq!(ran.code, Some(7), "{}", ran.stderr);
    let left = std::fs::read_to_string(left).expect("a list");
    assert_eq!(left.lines().collect::<Vec<_>>(), [&lines[0], &lines[2], &lines[3]]);
    assert!(run(&left).status.success());
    for (job, bytes) in [2, 3, 4].into_iter().zip(before) {
        assert!(std::fs::read(file(job)).expect("a file") == bytes, "job {job}");
    }
    let (code, collected) = collect(folder);
    assert_eq!((code, states(&collected)), (Some(0), vec!["done"; 6]));
    let rows = std::fs::read_to_string(table).expect("a table");
    assert_eq!(rows.lines().count(), 7);
    assert!(
        rows.starts_with("job,state,problem,basis.modes,material[0].young,output.precision,first"),
        "{rows}"
    );

    // The same again changes nothing; another sweep does not get into the folder.
    assert_eq!(plan(folder), (Some(0), String::new()));
    let other = "problems = [\"beam.toml\"]\n[[vary]]\nkey = \"basis.modes\"\nvalues = [2, 3]\n";
    std::fs::write(folder.join("sweep.toml"), other).expect("written");
    let (code, said) = plan(folder);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("1.toml"), "{said}");
    assert_eq!(collect(folder).0, Some(0));
}

/// A build that a signal ended, with its first stages behind it, goes on and ends with the same bytes.
#[test]
#[cfg(unix)]
fn a_line_that_is_killed_goes_on() {
    let folder = folder(
        "problems = [\"beam.toml\"]\n[[vary]]\nkey = \"mesh.block.divisions\"\nvalues = [[24, 4, 3]]\n",
    );
    let folder = folder.path();
    assert_eq!(plan(folder), (Some(0), String::new()));
    let line = lines(folder).remove(0);
    let work = folder.join("a folder's jobs/1.vdm.work");
    let program = vademecum_tests::program::program();
    let mut words: Vec<String> = vec!["build".into(), at(folder, "a folder's jobs/1.toml"), "-o".into()];
    words.extend([at(folder, "a folder's jobs/1.vdm"), "--once".into(), "--quiet".into()]);
    let mut child = Command::new(program).args(words).spawn().expect("the program");
    let begun = std::time::Instant::now();
    let is_kept = || std::fs::read_dir(&work).is_ok_and(|mut entries| entries.next().is_some());
    while !is_kept() && child.try_wait().expect("a child").is_none() {
        assert!(begun.elapsed().as_secs() < 120, "no stage was kept");
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    child.kill().expect("killed");
    assert!(!child.wait().expect("a child").success(), "the build was over before it could be killed");
    assert_eq!(states(&collect(folder).1), ["missing"]);
    assert!(is_kept());
    assert!(run(&line).status.success());
    assert_eq!(states(&collect(folder).1), ["done"]);
    assert!(!work.exists());
    let bytes = std::fs::read(folder.join("a folder's jobs/1.vdm")).expect("a file");
    std::fs::remove_file(folder.join("a folder's jobs/1.vdm")).expect("removed");
    assert!(run(&line).status.success());
    assert!(std::fs::read(folder.join("a folder's jobs/1.vdm")).expect("a file") == bytes);
}

/// The text of a problem says which mesh it means, and not what is in it.
#[test]
fn a_mesh_that_changes_makes_its_jobs_stale() {
    let folder = folder(
        "problems = [\"cube.toml\"]\narguments = [\"--keep-missed\"]\n[[vary]]\nkey = \"basis.modes\"\nvalues = [2, 3]\n\
         [[vary]]\nkey = \"mesh.scale\"\nvalues = [1.0, 0.5]\n",
    );
    let path = folder.path();
    let mesh = std::fs::read_to_string(repository().join("fixtures/meshes/cube.msh")).expect("a mesh");
    std::fs::write(path.join("cube.msh"), &mesh).expect("written");
    std::fs::write(path.join("cube.toml"), CUBE).expect("written");
    assert_eq!(plan(path), (Some(0), String::new()));
    let lines = lines(path);
    let runs = |line: &String| run(line).status.success();
    assert!(lines.iter().all(runs));
    let (code, collected) = collect(path);
    assert_eq!((code, states(&collected)), (Some(0), vec!["done"; 4]));
    let first = |collected: &Value| collected["jobs"][0]["first_frequency_hz"].as_f64().expect("a frequency");
    let before = first(&collected);

    // One corner is moved: the same text, the same topology, another body.
    let other = mesh.replace("\n7 1 1 1\n", "\n7 1 1 1.5\n");
    assert_ne!(other, mesh);
    std::fs::write(path.join("cube.msh"), &other).expect("written");
    let (code, collected) = collect(path);
    assert_eq!((code, states(&collected)), (Some(7), vec!["stale"; 4]));
    let reason = |collected: &Value| collected["jobs"][0]["reason"].as_str().expect("a reason").to_string();
    assert_eq!(reason(&collected), "it was built from another mesh");
    let ran = vademecum(&["collect", &at(path, "a folder's jobs")]);
    assert_eq!(ran.stdout.matches("it was built from another mesh").count(), 4, "{}", ran.stdout);
    assert!(runs(&lines[0]));
    let (_, collected) = collect(path);
    assert_eq!(states(&collected), ["done", "stale", "stale", "stale"]);
    assert!((first(&collected) / before - 1.0).abs() > 1e-3, "{collected}");
    assert!(lines.iter().all(runs));
    assert_eq!(collect(path).0, Some(0));

    // What cannot be compared is not called done.
    std::fs::remove_file(path.join("cube.msh")).expect("removed");
    let (code, collected) = collect(path);
    assert_eq!((code, states(&collected)), (Some(7), vec!["stale"; 4]));
    assert!(reason(&collected).contains("cube.msh"), "{collected}");
    let kept = std::fs::read(path.join("a folder's jobs/1.vdm")).expect("a file");
    assert!(!runs(&lines[0]));
    assert!(std::fs::read(path.join("a folder's jobs/1.vdm")).expect("a file") == kept);
}

#[test]
fn what_cannot_be_planned_is_refused_by_name_and_nothing_is_written() {
    let vary = |key: &str, values: &str| {
        format!("problems = [\"beam.toml\"]\n[[vary]]\nkey = {key:?}\nvalues = {values}\n")
    };
    for (sweep, named) in [
        ("problems = []\n".to_string(), "`problems` is empty"),
        (vary("basis.modes", "[]"), "`vary[0].values` is empty"),
        (vary("basis.modes", "[2, 0]"), "job 2 of"),
        (vary("basis.mode", "[2]"), "did you mean `modes`"),
        (vary("material.young", "[1e9]"), "say which entry, as in `material[0]`"),
        (vary("material[1].young", "[1e9]"), "`material` has 1 entries, the first is [0]"),
        (vary("material[x].young", "[1e9]"), "is no name, and no `name[number]`"),
        (vary("title.text", "[1]"), "is a value and has no keys"),
        (vary("regions[0].name", "[1]"), "there is no list `regions`"),
        (vary("a..b", "[1]"), "a part of it is empty"),
        (vary("basis.modes", "[1]") + "[[vary]]\nkey = \"basis.modes\"\nvalues = [2]\n", "a second time"),
        (
            "together = true\n".to_string()
                + &vary("basis.modes", "[1, 2]")
                + "[[vary]]\nkey = \"material[0].young\"\nvalues = [1e9]\n",
            "as many values for each key",
        ),
        ("problems = [\"none.toml\"]\n".to_string(), "none.toml: cannot be read"),
        ("problem = \"beam.toml\"\n".to_string(), "did you mean `problems`"),
    ] {
        let folder = folder(&sweep);
        let (code, said) = plan(folder.path());
        assert_eq!(code, Some(3), "{sweep}: {said}");
        assert!(said.contains(named), "{sweep}: {said}");
        assert!(!folder.path().join("a folder's jobs").exists(), "{sweep}");
    }
    let many: Vec<String> = (1..=400).map(|i| i.to_string()).collect();
    let many = format!("[{}]", many.join(", "));
    let sweep = vary("basis.modes", &many) + "[[vary]]\nkey = \"x\"\nvalues = " + &many;
    let (code, said) = plan(folder(&sweep).path());
    assert!(code == Some(3) && said.contains("at most 100 000"), "{said}");
}

#[test]
fn a_gallery_and_values_that_belong_together() {
    let folder = folder(
        "problems = [\"beam.toml\", \"sub/cube.toml\"]\ntogether = true\narguments = [\"--keep-missed\"]\n\
         [[vary]]\nkey = \"basis.modes\"\nvalues = [2, 3]\n[[vary]]\nkey = \"time.step\"\nvalues = [1e-4, 2e-4]\n",
    );
    let path = folder.path();
    std::fs::create_dir(path.join("sub")).expect("a folder");
    let mesh = repository().join("fixtures/meshes/cube.msh");
    std::fs::copy(mesh, path.join("sub/cube.msh")).expect("copied");
    std::fs::write(path.join("sub/cube.toml"), CUBE).expect("written");
    assert_eq!(plan(path), (Some(0), String::new()));
    for line in lines(path) {
        assert!(line.ends_with(" --once --quiet --keep-missed"), "{line}");
        let ran = run(&line);
        assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    }
    let (code, collected) = collect(path);
    assert_eq!((code, states(&collected)), (Some(0), vec!["done"; 4]));
    let of = |job: usize| (&collected["jobs"][job]["modes"], &collected["jobs"][job]["time_step"]);
    assert_eq!([of(0), of(1)], [(&2.into(), &1e-4.into()), (&3.into(), &2e-4.into())]);
    assert!(collected["jobs"][3]["problem"].as_str().is_some_and(|name| name.ends_with("sub/cube.toml")));
}

#[test]
fn examples_of_the_page_are_plans() {
    let examples = examples();
    assert!(!examples.is_empty());
    for example in examples {
        let folder = folder(&example);
        assert_eq!(plan(folder.path()), (Some(0), String::new()));
        assert_eq!(lines(folder.path()).len(), 6);
    }
}

/// The script of the examples, which runs two lines at a time.
#[test]
#[cfg(unix)]
fn a_list_runs_in_parallel() {
    let folder = folder("problems = [\"beam.toml\"]\n[[vary]]\nkey = \"basis.modes\"\nvalues = [4, 6, 8]\n");
    assert_eq!(plan(folder.path()), (Some(0), String::new()));
    let script = repository().join("examples/sweep/parallel.sh");
    let list = at(folder.path(), "a folder's jobs/jobs.txt");
    let ran = run(&format!("{} \"{list}\"", script.display()));
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    assert_eq!(states(&collect(folder.path()).1), ["done"; 3]);
}
