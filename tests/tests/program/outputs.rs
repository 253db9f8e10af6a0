//! Where the program writes: devices, pipes and links stay what they are, inputs and files of another kind
//! stay as they are, modes are kept, and what was computed before a stop is there.

use std::io::Read;
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use vademecum_build::field::read_pvd;
use vademecum_tests::program::{Ran, command, program, repository, vademecum};

const PROBLEM: &str = "problems/short-beam.toml";
const SCENARIO: &str = "scenarios/short-push.toml";

fn fixture(name: &str) -> PathBuf {
    repository().join("fixtures").join(name)
}

/// A built file, built once.
fn built() -> &'static [u8] {
    static BUILT: OnceLock<Vec<u8>> = OnceLock::new();
    BUILT.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.vdm");
        let ran =
            vademecum(&["build".as_ref(), fixture(PROBLEM).as_os_str(), "-o".as_ref(), path.as_os_str()]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        std::fs::read(path).expect("a file")
    })
}

/// A folder with a problem, a scenario and a file, in which the program runs.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        let place = Self(tempfile::tempdir().expect("a folder"));
        std::fs::copy(fixture(PROBLEM), place.at("p.toml")).expect("copied");
        std::fs::copy(fixture(SCENARIO), place.at("s.toml")).expect("copied");
        place.write("a.vdm", built());
        place
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.at(name), bytes).expect("written");
    }

    fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.at(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Runs the program with a line of arguments, `@` standing for the output.
    fn run(&self, line: &str, output: &str) -> Ran {
        let words = line.split(' ').map(|word| if word == "@" { output } else { word });
        let ran = command(&words.collect::<Vec<_>>()).current_dir(self.0.path()).output();
        Ran::new(&ran.expect("the program starts"))
    }

    fn succeeds(&self, line: &str, output: &str) -> Ran {
        let ran = self.run(line, output);
        assert_eq!(ran.code, Some(0), "{line} -> {output}: {}", ran.stderr);
        ran
    }

    /// Runs a line of the shell in the folder, with the program as `$0`.
    fn shell(&self, line: &str) -> Ran {
        let mut shell = Command::new("sh");
        shell.args(["-c", line]).arg(program()).current_dir(self.0.path());
        Ran::new(&shell.output().expect("a shell"))
    }

    fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).expect("a folder");
        let mut names: Vec<String> =
            entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

/// Every command that writes one file.
const FILES: [&str; 7] = [
    "build p.toml -o @",
    "pack a.vdm -o @",
    "unpack a.vdm -o @",
    "strip a.vdm --keep probes -o @",
    "report a.vdm -o @",
    "view a.vdm --export @",
    "export fmu a.vdm -o @",
];

/// Every command that writes into a folder, with a file that it writes there.
const FOLDERS: [(&str, &str); 7] = [
    ("run a.vdm --scenario s.toml -o @", "probes.csv"),
    ("run a.vdm --scenario s.toml -o @", "fields.pvd"),
    ("run a.vdm --scenario s.toml -o @", "field-000000.vtu"),
    ("bench p.toml --scenario s.toml --quick --modes 4 --steps 20 -o @", "bench.json"),
    ("bench p.toml --scenario s.toml --quick --modes 4 --steps 20 -o @", "pareto.svg"),
    ("export matrices p.toml --scenario s.toml --modes 4 -o @", "mass.mtx"),
    ("export matrices p.toml --scenario s.toml --modes 4 -o @", "model.json"),
];

/// A device that takes everything: of its own where the system lets us make one, else the system's.
fn null(place: &Place, name: &str) -> bool {
    let made = Command::new("mknod").arg(place.at(name)).args(["c", "1", "3"]).output();
    let made = made.is_ok_and(|ran| ran.status.success());
    if !made {
        symlink("/dev/null", place.at(name)).expect("a link");
    }
    std::fs::metadata(place.at(name)).expect("a device").file_type().is_char_device()
}

#[test]
fn a_device_stays_a_device() {
    let place = Place::new();
    assert!(null(&place, "null"));
    let before = std::fs::metadata(place.at("null")).expect("a device").ino();
    let all = place.names();
    for line in FILES {
        place.succeeds(line, "null");
        let found = std::fs::metadata(place.at("null")).expect("a device");
        assert!(found.file_type().is_char_device() && found.ino() == before, "{line}");
        assert_eq!(place.names(), all, "{line}: something is beside the device");
    }
    for (line, name) in FOLDERS {
        let folder = place.at("folder");
        std::fs::create_dir(&folder).expect("made");
        symlink(place.at("null"), folder.join(name)).expect("a link");
        place.succeeds(line, "folder");
        assert!(
            std::fs::metadata(place.at("null")).expect("a device").file_type().is_char_device(),
            "{line}"
        );
        assert!(std::fs::symlink_metadata(folder.join(name)).expect("the link").is_symlink(), "{line}");
        std::fs::remove_dir_all(folder).expect("removed");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_device_is_an_error_with_its_path_and_the_reason() {
    let place = Place::new();
    symlink("/dev/full", place.at("full")).expect("a link");
    let check = |ran: &Ran, line: &str, path: &str| {
        ran.fails(1, &[path, "No space left on device"]);
        assert!(!ran.stderr.contains("backend") && !ran.stderr.contains(".part"), "{line}: {}", ran.stderr);
    };
    for line in FILES {
        check(&place.run(line, "full"), line, "full: ");
        check(&place.run(line, "/dev/full"), line, "/dev/full: ");
    }
    for (line, name) in FOLDERS {
        let folder = place.at("folder");
        std::fs::create_dir(&folder).expect("made");
        symlink("/dev/full", folder.join(name)).expect("a link");
        check(&place.run(line, "folder"), line, &format!("folder/{name}: "));
        std::fs::remove_dir_all(folder).expect("removed");
    }
    std::fs::create_dir(place.at("r-figures")).expect("made");
    symlink("/dev/full", place.at("r-figures/shape-1.svg")).expect("a link");
    check(&place.run("report a.vdm -o @", "r.html"), "report", "r-figures/shape-1.svg: ");
    std::fs::create_dir(place.at("demo")).expect("made");
    symlink("/dev/full", place.at("demo/scenario.toml")).expect("a link");
    check(&place.run("demo -o @", "demo"), "demo", "demo/scenario.toml: ");
}

#[test]
fn a_pipe_gets_the_bytes_and_stays() {
    let place = Place::new();
    let made = Command::new("mkfifo").arg(place.at("pipe")).status().expect("mkfifo");
    assert!(made.success());
    place.succeeds("pack a.vdm -o @", "packed.vdm");
    let path = place.at("pipe");
    let reader = std::thread::spawn(move || std::fs::read(path).expect("a pipe"));
    place.succeeds("pack a.vdm -o @", "pipe");
    assert!(reader.join().expect("read") == place.read("packed.vdm"));
    assert!(std::fs::metadata(place.at("pipe")).expect("a pipe").file_type().is_fifo());
    // The table and the collection too, though neither can be gone back in.
    place.succeeds("run a.vdm --scenario s.toml -o @", "file");
    std::fs::create_dir(place.at("folder")).expect("made");
    for name in ["probes.csv", "fields.pvd"] {
        std::fs::rename(place.at("pipe"), place.at("folder").join(name)).expect("moved");
        let path = place.at("folder").join(name);
        let reader = std::thread::spawn(move || std::fs::read(path).expect("a pipe"));
        place.succeeds("run a.vdm --scenario s.toml -o @", "folder");
        assert!(reader.join().expect("read") == place.read(&format!("file/{name}")), "{name}");
        std::fs::rename(place.at("folder").join(name), place.at("pipe")).expect("moved");
    }
}

#[test]
fn standard_output_gets_the_bytes_and_no_words() {
    let place = Place::new();
    place.succeeds("pack a.vdm -o @", "packed.vdm");
    let packed = place.read("packed.vdm");
    for (line, name) in [
        ("pack a.vdm -o /dev/stdout | cat > piped.vdm", "piped.vdm"),
        ("pack a.vdm -o /dev/stdout > file.vdm", "file.vdm"),
    ] {
        let ran = place.shell(&format!("\"$0\" --quiet {line}"));
        assert!(place.read(name) == packed, "{line}");
        assert!(ran.stderr.contains("bytes"), "{line}: {}", ran.stderr);
    }
}

#[test]
fn a_link_stays_and_its_target_is_replaced() {
    let place = Place::new();
    std::fs::create_dir(place.at("far")).expect("made");
    symlink("far/target", place.at("near")).expect("a link");
    symlink("near", place.at("link")).expect("a link");
    for line in FILES {
        // The target is not there, then it is.
        for _ in 0..2 {
            place.succeeds(line, "link");
            for name in ["near", "link"] {
                assert!(std::fs::symlink_metadata(place.at(name)).expect("a link").is_symlink(), "{line}");
            }
            assert!(place.read("far/target").len() > 1000, "{line}");
        }
        let far: Vec<_> = std::fs::read_dir(place.at("far")).expect("a folder").collect();
        assert_eq!(far.len(), 1, "{line}");
        std::fs::remove_file(place.at("far/target")).expect("removed");
    }
}

#[test]
fn what_is_no_file_is_refused_by_name() {
    let place = Place::new();
    std::fs::create_dir(place.at("folder")).expect("made");
    let _socket = std::os::unix::net::UnixListener::bind(place.at("socket")).expect("a socket");
    let mut cases = vec![("folder", "a folder"), ("socket", "a socket"), ("folder/", "a folder")];
    let made = Command::new("mknod").arg(place.at("block")).args(["b", "7", "250"]).output();
    if made.is_ok_and(|ran| ran.status.success()) {
        cases.push(("block", "a block device"));
    }
    for line in FILES {
        for (output, what) in &cases {
            place.run(line, output).fails(2, &[output, what]);
        }
        place.run(line, "none/x").fails(1, &["none/x", "no folder none"]);
    }
    for (line, _) in FOLDERS {
        place.run(line, "a.vdm").fails(2, &["a.vdm", "no folder"]);
    }
    assert!(place.read("a.vdm") == built());
}

/// An input given as the output, by each name that it can have.
fn refuses_input(place: &Place, line: &str, input: &str) {
    let before = place.read(input);
    std::fs::hard_link(place.at(input), place.at("hard")).expect("a link");
    symlink(input, place.at("soft")).expect("a link");
    let names = [input.to_string(), format!("./{input}"), place.at(input).display().to_string()];
    for output in names.iter().map(String::as_str).chain(["hard", "soft"]) {
        for force in ["", " --force"] {
            place.run(&format!("{line}{force}"), output).fails(2, &[output, "the command reads this file"]);
            assert!(place.read(input) == before, "{line} -> {output}");
        }
    }
    std::fs::remove_file(place.at("hard")).expect("removed");
    std::fs::remove_file(place.at("soft")).expect("removed");
}

#[test]
fn no_command_writes_what_it_reads() {
    let place = Place::new();
    for line in FILES {
        refuses_input(&place, line, line.split(' ').find(|word| word.contains('.')).expect("an input"));
    }
    refuses_input(&place, "strip a.vdm --keep surface --for s.toml -o @", "s.toml");
    let report = "report a.vdm --problem p.toml --scenario s.toml -o @";
    ["p.toml", "s.toml"].iter().for_each(|input| refuses_input(&place, report, input));
    place.write("b.json", place.succeeds("build p.toml --json -o @", "b.vdm").stdout);
    refuses_input(&place, "report a.vdm --build b.json -o @", "b.json");
    place.run("build p.toml --work b.vdm -o @", "b.vdm").fails(2, &["b.vdm", "too"]);
}

#[test]
fn no_command_writes_what_its_problem_reads() {
    let place = Place::new();
    let problem = |mesh: &str| {
        let text = std::fs::read_to_string(place.at("p.toml")).expect("the fixture");
        let (from, to) =
            (text.find("[mesh]").expect("a mesh"), text.find("[[material]]").expect("a material"));
        place.write("q.toml", format!("{}[mesh]\n{mesh}\n{}", &text[..from], &text[to..]));
    };
    place.succeeds("export matrices p.toml --modes 4 -o @", "m");
    let matrices = "matrices = { mass = \"m/mass.mtx\", stiffness = \"m/stiffness.mtx\", dofs = \"m/dofs.csv\", \
                    nodes = \"m/nodes.csv\", triangles = \"m/triangles.csv\" }";
    place.write(
        "q.toml",
        format!("[mesh]\n{matrices}\n[load]\n[time]\nscheme.name = \"bathe\"\nstep = 1e-3\n"),
    );
    for input in ["mass.mtx", "stiffness.mtx", "dofs.csv", "nodes.csv", "triangles.csv"] {
        refuses_input(&place, "build q.toml -o @", &format!("m/{input}"));
    }
    place.run("export matrices q.toml -o @", "m").fails(2, &["m/mass.mtx", "the command reads this file"]);
    place.write("t.node", "0 3 0 0\n");
    place.write("t.ele", "0 4 0\n");
    problem("file = \"t.ele\"");
    ["t.node", "t.ele"].iter().for_each(|input| refuses_input(&place, "build q.toml -o @", input));
    place.write("deck.inp", "*NODE, INPUT=nodes.txt\n");
    place.write("nodes.txt", "1, 0., 0., 0.\n");
    problem("file = \"deck.inp\"");
    ["deck.inp", "nodes.txt"].iter().for_each(|input| refuses_input(&place, "build q.toml -o @", input));
    problem("tables = { coordinates = \"nodes.txt\", connectivity = \"deck.inp\" }");
    ["deck.inp", "nodes.txt"].iter().for_each(|input| refuses_input(&place, "build q.toml -o @", input));
    place.write("n.npy", "x");
    let text = std::fs::read_to_string(place.at("p.toml")).expect("the fixture");
    place.write("q.toml", text.replace("[snapshots]", "[snapshots]\nnpy = \"n.npy\""));
    refuses_input(&place, "build q.toml -o @", "n.npy");
}

#[test]
fn no_file_of_a_folder_is_an_input() {
    for (line, name) in FOLDERS {
        let place = Place::new();
        std::fs::create_dir(place.at("folder")).expect("made");
        std::fs::hard_link(place.at("s.toml"), place.at("folder").join(name)).expect("a link");
        let before = place.read("s.toml");
        for force in ["", " --force"] {
            let ran = place.run(&format!("{line}{force}"), "folder");
            ran.fails(2, &[name, "the command reads this file (s.toml)"]);
        }
        assert!(place.read("s.toml") == before, "{line}");
        let left = std::fs::read_dir(place.at("folder")).expect("a folder").count();
        assert_eq!(left, 1, "{line}: work was begun");
    }
}

#[test]
fn a_file_of_another_kind_is_replaced_only_by_force() {
    let place = Place::new();
    let kinds: [(&[u8], &str); 5] = [
        (b"# mine\n[mesh]\nfile = \"x\"\n", "a TOML file"),
        (b"Dear reader,\nthis is a letter.\n", "a text"),
        (b"\x7fELF\x02\x01", "a program"),
        (b"<?xml version=\"1.0\"?><note/>", "an XML file"),
        (b"\x00\x01\x02", "binary data"),
    ];
    for (bytes, seems) in kinds {
        for line in FILES {
            place.write("other", bytes);
            place.run(line, "other").fails(2, &["other", seems, "--force"]);
            assert_eq!(place.read("other"), bytes, "{line}");
        }
        for (line, name) in FOLDERS {
            std::fs::create_dir_all(place.at("folder")).expect("made");
            place.write(&format!("folder/{name}"), bytes);
            place.run(line, "folder").fails(2, &[name, seems, "--force"]);
            assert_eq!(place.read(&format!("folder/{name}")), bytes, "{line}");
            std::fs::remove_dir_all(place.at("folder")).expect("removed");
        }
    }
    for line in FILES {
        place.write("other", "Dear reader.\n");
        place.succeeds(&format!("{line} --force"), "other");
        // Its own kind, and an empty file, need no force.
        place.succeeds(line, "other");
        place.write("other", "");
        place.succeeds(line, "other");
    }
    for (line, name) in FOLDERS {
        std::fs::create_dir_all(place.at("folder")).expect("made");
        place.write(&format!("folder/{name}"), "Dear reader.\n");
        place.succeeds(&format!("{line} --force"), "folder");
        place.succeeds(line, "folder");
        std::fs::remove_dir_all(place.at("folder")).expect("removed");
    }
    place.write("problem.toml", "title = \"mine\"\n");
    place.run("demo -o @", ".").fails(2, &["problem.toml", "a TOML file"]);
    assert_eq!(place.read("problem.toml"), b"title = \"mine\"\n");
}

#[test]
fn modes_are_those_of_the_umask_or_of_the_file_that_was_there() {
    let place = Place::new();
    let mode = |name: &str| std::fs::metadata(place.at(name)).expect("a file").permissions().mode() & 0o7777;
    for (umask, expected) in [("077", 0o600), ("022", 0o644), ("002", 0o664)] {
        for line in FILES {
            let line = line.replace('@', "new");
            let ran = place.shell(&format!("umask {umask}; \"$0\" --quiet {line}"));
            assert_eq!(ran.code, Some(0), "{}", ran.stderr);
            assert_eq!(mode("new"), expected, "{line} with umask {umask}");
            for kept in [0o600, 0o640, 0o666] {
                std::fs::set_permissions(place.at("new"), std::fs::Permissions::from_mode(kept))
                    .expect("set");
                let ran = place.shell(&format!("umask {umask}; \"$0\" --quiet {line}"));
                assert_eq!(ran.code, Some(0), "{}", ran.stderr);
                assert_eq!(mode("new"), kept, "{line} with umask {umask}");
            }
            std::fs::remove_file(place.at("new")).expect("removed");
        }
        let ran =
            place.shell(&format!("umask {umask}; \"$0\" --quiet run a.vdm --scenario s.toml -o out{umask}"));
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        for name in ["probes.csv", "fields.pvd", "field-000003.vtu"] {
            assert_eq!(mode(&format!("out{umask}/{name}")), expected);
        }
    }
}

#[test]
fn what_a_killed_program_left_is_removed_by_the_next_run() {
    let place = Place::new();
    let all = |line: &str, output: &str, folder: &str| {
        let left = format!("{folder}.vademecum-1-2-3.part");
        std::fs::create_dir_all(place.at(folder)).expect("made");
        place.write(&left, "half");
        place.succeeds(line, output);
        assert!(!place.at(&left).exists(), "{line}");
    };
    for line in FILES {
        all(line, "new", "");
        std::fs::remove_file(place.at("new")).expect("removed");
    }
    for (line, _) in FOLDERS {
        all(line, "folder", "folder/");
        std::fs::remove_dir_all(place.at("folder")).expect("removed");
    }
}

/// A run that does not end by itself, and that has begun to write.
fn endless(place: &Place, every: &str) -> Child {
    let text = std::fs::read_to_string(place.at("s.toml")).expect("the fixture");
    let text = text.replace("duration = 0.2", "duration = 2e4").replace("fields_every = 20", every);
    place.write("long.toml", text);
    let mut child = command(&["run", "a.vdm", "--scenario", "long.toml", "-o", "out"])
        .current_dir(place.0.path())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let start = Instant::now();
    while rows(place).len() < 1000 {
        assert!(start.elapsed() < Duration::from_secs(60), "no rows after a minute");
        assert!(child.try_wait().expect("its state").is_none(), "it ended by itself");
        std::thread::sleep(Duration::from_millis(20));
    }
    child
}

/// The whole rows of the table, without its header.
fn rows(place: &Place) -> Vec<String> {
    let text = std::fs::read_to_string(place.at("out/probes.csv")).unwrap_or_default();
    let whole = text.rfind('\n').map_or("", |end| &text[..end]);
    whole.lines().skip(1).map(String::from).collect()
}

/// Asserts that the table ends with a whole row, and that its rows are those of every step in order.
fn table_is_whole(place: &Place) -> usize {
    let text = std::fs::read_to_string(place.at("out/probes.csv")).expect("a table");
    assert!(text.ends_with('\n'), "half a row: {}", &text[text.len() - 60..]);
    let width = text.lines().next().expect("a header").split(',').count();
    for (step, row) in rows(place).iter().enumerate() {
        let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().expect("a number")).collect();
        assert_eq!(cells.len(), width, "{row}");
        // The table has ten digits.
        assert!((cells[0] - step as f64 * 1e-3).abs() <= 1e-9 * cells[0].max(1e-3), "row {step}: {row}");
    }
    rows(place).len()
}

/// Asserts that the collection is one, and that each field it lists is there and whole.
fn collection_is_whole(place: &Place) -> usize {
    let listed = read_pvd(&place.at("out/fields.pvd")).expect("a collection");
    for (_, field) in &listed {
        let field = std::fs::read(field).expect("a listed field");
        assert!(field.ends_with(b"</VTKFile>\n"));
    }
    listed.len()
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args([name, &child.id().to_string()]).status().expect("kill");
    assert!(sent.success());
}

#[test]
fn a_run_that_is_asked_to_stop_says_what_it_kept() {
    for name in ["-INT", "-TERM"] {
        let place = Place::new();
        let mut child = endless(&place, "fields_every = 20");
        signal(&child, name);
        let mut said = String::new();
        child.stderr.take().expect("a pipe").read_to_string(&mut said).expect("text");
        assert_eq!(child.wait().expect("it ends").code(), Some(130), "{said}");
        let (rows, fields) = (table_is_whole(&place), collection_is_whole(&place));
        let kept = format!("kept: {rows} rows in out/probes.csv; {fields} fields in out/fields.pvd");
        assert!(said.contains("stopped on request") && said.contains(&kept), "{said}, not `{kept}`");
        assert_eq!(fields, rows.div_ceil(20));
    }
}

#[test]
fn a_run_that_is_killed_leaves_whole_rows_and_fields() {
    for pause in [0, 130, 370, 610] {
        let place = Place::new();
        let mut child = endless(&place, "fields_every = 20");
        std::thread::sleep(Duration::from_millis(pause));
        child.kill().expect("killed");
        child.wait().expect("it ends");
        assert!(table_is_whole(&place) >= 1000);
        assert!(collection_is_whole(&place) > 1);
    }
}

#[test]
fn rows_are_on_the_disk_within_about_a_second() {
    let place = Place::new();
    // A row is slow to come: no buffer is filled by it.
    let mut child = endless(&place, "probes_every = 1");
    let mut seen = rows(&place).len();
    for _ in 0..3 {
        std::thread::sleep(Duration::from_millis(1500));
        let now = rows(&place).len();
        assert!(now > seen, "no row in more than a second");
        seen = now;
    }
    child.kill().expect("killed");
    child.wait().expect("it ends");
}

#[cfg(target_os = "linux")]
#[test]
fn the_memory_of_a_run_does_not_grow_with_its_length() {
    let place = Place::new();
    let mut child = endless(&place, "");
    let memory = || -> f64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).expect("its state");
        let line = status.lines().find(|line| line.starts_with("VmRSS:")).expect("its memory");
        1024.0 * line.split_whitespace().nth(1).expect("a number").parse::<f64>().expect("a number")
    };
    let length = || std::fs::metadata(place.at("out/probes.csv")).expect("a table").len() as f64;
    let (memory_before, length_before) = (memory(), length());
    let start = Instant::now();
    // Enough that keeping a tenth of the text would show beside the pages that a program touches anyway.
    while length() - length_before < 2e7 {
        assert!(start.elapsed() < Duration::from_secs(120), "it is slow");
        std::thread::sleep(Duration::from_millis(50));
    }
    let (grown, written) = (memory() - memory_before, length() - length_before);
    child.kill().expect("killed");
    child.wait().expect("it ends");
    assert!(grown < 0.1 * written, "{grown} bytes of memory for {written} bytes of rows");
}

/// Runs until the disk is full, and checks what is left of it.
fn run_until_full(place: &Place, duration: &str, line: &str, reason: &str) {
    let text = std::fs::read_to_string(place.at("s.toml")).expect("the fixture");
    let long = text.replace("duration = 0.2", &format!("duration = {duration}"));
    let scenario = long.replace("fields_every = 20", "");
    place.write("long.toml", scenario);
    let ran = place.shell(line);
    ran.fails(1, &["out/probes.csv: ", reason]);
    let rows = table_is_whole(place);
    assert!(rows > 100, "{rows} rows");
    assert!(ran.stderr.contains(&format!("kept: {rows} rows in out/probes.csv")), "{}", ran.stderr);
}

#[test]
fn a_full_disk_cuts_the_table_back_to_its_last_whole_row() {
    let place = Place::new();
    // A limit on the length of files stands for a full disk; 101 and 64 blocks end in the midst of a row.
    for blocks in [64, 101] {
        let line = "exec \"$0\" --quiet run a.vdm --scenario long.toml -o out";
        run_until_full(&place, "1e4", &format!("trap '' XFSZ; ulimit -f {blocks}; {line}"), "File too large");
    }
    std::fs::remove_dir_all(place.at("out")).expect("removed");
    std::fs::create_dir(place.at("out")).expect("made");
    let Some(_mounted) = Mounted::small(place.at("out")) else {
        eprintln!("skipped: no small disk can be mounted");
        return;
    };
    let line = "exec \"$0\" --quiet run a.vdm --scenario long.toml -o out";
    // Refused where the disk cannot hold it, before anything is written …
    let scenario = std::fs::read_to_string(place.at("long.toml")).expect("written");
    assert!(scenario.contains("duration = 1e4"));
    place.shell(line).fails(1, &["out: the results take at least", "probes_every"]);
    assert!(!place.at("out/probes.csv").exists());
    // … and cut where the estimate, which is a lower bound, fits just so.
    run_until_full(&place, "1.5", line, "No space left on device");
    // The disk is full now: nothing else can be written there, and nothing is left half.
    let others = [
        ("pack a.vdm -o @", "out/p.vdm"),
        ("view a.vdm --export @", "out/v.html"),
        ("report a.vdm -o @", "out/r.html"),
    ];
    for (line, output) in others {
        place.run(line, output).fails(1, &["out/", "No space left on device"]);
        assert!(!place.at(output).exists());
    }
    let left = std::fs::read_dir(place.at("out")).expect("a folder");
    let mut names = left.map(|entry| entry.expect("an entry").file_name());
    assert!(names.all(|name| Path::new(&name).extension().is_none_or(|end| end != "part")));
}

/// A disk of 64 kB, for as long as it lives.
struct Mounted(PathBuf);

impl Mounted {
    /// None where the system does not let us mount one.
    fn small(at: PathBuf) -> Option<Self> {
        let mut mount = Command::new("mount");
        let ran = mount.args(["-t", "tmpfs", "-o", "size=64k", "tmpfs"]).arg(&at).output();
        ran.is_ok_and(|ran| ran.status.success()).then_some(Self(at))
    }
}

impl Drop for Mounted {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0).status();
    }
}
