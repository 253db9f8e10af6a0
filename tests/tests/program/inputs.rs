//! What is no regular file is refused by name at every input of the program, and nobody waits for it.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use vademecum_tests::program::{command, program, repository};
use vademecum_tests::soak::invariant::refused_by_name;
use vademecum_tests::soak::launch::Launch;

const ODD: [(&str, &str); 5] = [
    ("fifo", "a FIFO (named pipe)"),
    ("socket", "a socket"),
    ("folder", "a folder"),
    ("/dev/zero", "a character device"),
    ("/dev/random", "a character device"),
];

/// A folder with a FIFO, a socket and a folder; the socket lives as long as what is returned.
fn odd_folder() -> (tempfile::TempDir, std::os::unix::net::UnixListener) {
    let folder = tempfile::tempdir().expect("a folder");
    assert!(Command::new("mkfifo").arg(folder.path().join("fifo")).status().expect("mkfifo").success());
    std::fs::create_dir(folder.path().join("folder")).expect("a folder");
    let socket = std::os::unix::net::UnixListener::bind(folder.path().join("socket")).expect("a socket");
    (folder, socket)
}

/// Refused with this code, naming the input and what it is, in ten seconds and four gigabytes.
fn refused(folder: &Path, line: &str, code: i32, (name, kind): (&str, &str)) {
    let mut launch = Launch::new(&line.split(' ').collect::<Vec<_>>(), Duration::from_secs(10));
    launch.memory_kib = Some(4 << 20);
    let ended = launch.run(&program(), folder);
    let held = refused_by_name(&ended, &[code], name);
    assert!(held.is_ok(), "{line}: {held:?}");
    assert!(ended.stderr.contains(&format!("it is {kind}; expected a regular file")), "{}", ended.stderr);
}

#[test]
fn arguments_that_are_no_regular_files_are_refused_by_what_they_are() {
    let (folder, _socket) = odd_folder();
    std::fs::copy(repository().join("fixtures/golden/fixed-f64.vdm"), folder.path().join("a.vdm"))
        .expect("a");
    std::fs::write(folder.path().join("s.toml"), "duration = 0.01\n").expect("written");
    let lines = [
        ("build ODD -o o.vdm", 3),
        ("modes ODD", 3),
        ("run a.vdm --scenario ODD -o o", 3),
        ("strip a.vdm --keep probes --for ODD -o o.vdm", 3),
        ("mesh ODD", 4),
        ("info ODD", 7),
        ("run ODD --scenario s.toml -o o", 7),
        ("run ODD --scenario s.toml -o o --copy", 7),
        ("verify ODD --file-only", 7),
        ("report ODD -o o.html", 7),
        ("view ODD --export o.html", 7),
        ("export fmu ODD -o o.fmu", 7),
        ("pack ODD -o o.vdm", 7),
        ("unpack ODD -o o.vdm", 7),
        ("strip ODD -o o.vdm --keep probes", 7),
    ];
    for odd in ODD {
        for (line, code) in lines {
            refused(folder.path(), &line.replace("ODD", odd.0), code, odd);
        }
    }
}

#[test]
fn files_that_a_problem_names_are_refused_by_what_they_are() {
    let (folder, _socket) = odd_folder();
    let end = "[load]\n[time]\nscheme.name = \"bathe\"\nstep = 1e-3\n";
    let material = "[[material]]\nyoung = 1e9\npoisson = 0.3\ndensity = 1e3\n";
    let block = "[mesh]\nblock = { lengths = [1.0, 1.0, 1.0], divisions = [1, 1, 1] }\n\
                 [[support]]\non = { group = \"x_min\" }\n";
    let deck = "*INCLUDE, INPUT=ODD\n";
    let problems = [
        (format!("[mesh]\nfile = \"ODD\"\n{material}{end}"), 4),
        (format!("[mesh]\nfile = \"deck.inp\"\n{material}{end}"), 4),
        (format!("[mesh]\ntables = {{ coordinates = \"ODD\", connectivity = \"s\" }}\n{material}{end}"), 4),
        (format!("[mesh.matrices]\nmass = \"ODD\"\nstiffness = \"ODD\"\ndofs = \"ODD\"\n{end}"), 3),
        (format!("{block}{material}{end}[snapshots]\nnpy = \"ODD\"\n"), 3),
        (format!("{block}{material}{end}[snapshots]\nvtu = [\"ODD\"]\n"), 3),
    ];
    for odd in ODD {
        std::fs::write(folder.path().join("deck.inp"), deck.replace("ODD", odd.0)).expect("written");
        for (text, code) in &problems {
            std::fs::write(folder.path().join("p.toml"), text.replace("ODD", odd.0)).expect("written");
            refused(folder.path(), "build p.toml -o o.vdm", *code, odd);
        }
    }
}

/// Standard input is good for a text, and ends at the limit even if it does not end.
#[test]
fn a_text_may_come_from_standard_input_and_is_bounded() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("o.vdm");
    let problem = repository().join("fixtures/problems/short-beam.toml");
    let build = |input: std::fs::File| {
        let mut build = command(&["build", "/dev/stdin", "-o"]);
        build.arg(&output).stdin(Stdio::from(input)).output().expect("the program")
    };
    let built = build(std::fs::File::open(&problem).expect("the fixture"));
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    let endless = build(std::fs::File::open("/dev/zero").expect("zeros"));
    let said = String::from_utf8_lossy(&endless.stderr).into_owned();
    assert_eq!(endless.status.code(), Some(3), "{said}");
    assert!(said.contains("/dev/stdin") && said.contains("longer than 917504 bytes"), "{said}");
}

#[test]
fn a_text_that_is_too_long_is_refused_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let long = folder.path().join("long.toml");
    std::fs::write(&long, "# filler\n".repeat((64 << 20) / 9 + 1)).expect("written");
    let path = long.display().to_string();
    let ran = vademecum_tests::program::vademecum(&["build", &path, "-o", "/nowhere/o.vdm"]);
    ran.fails(3, &["long.toml", "longer than 917504 bytes"]);
}

#[test]
fn a_mesh_that_is_refused_is_not_sent_to_the_same_command_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let write =
        |name: &str, content: &str| std::fs::write(folder.path().join(name), content).expect("written");
    write("garbage.msh", "garbage");
    write("cut.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n9\n1 0 0 0\n");
    write("part.stl", "solid part\nendsolid part\n");
    write(
        "flat.msh",
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0 0\n$EndNodes\n$Elements\n0\n$EndElements\n",
    );
    for name in ["garbage.msh", "cut.msh", "part.stl", "flat.msh", "missing.msh"] {
        let path = folder.path().join(name).display().to_string();
        let ran = vademecum_tests::program::vademecum(&["mesh", &path]);
        ran.fails(4, &[name]);
        assert!(!ran.stderr.contains("vademecum mesh"), "{}", ran.stderr);
        // A build, which does not show what the file holds, may say who does, if that says more.
        write(
            "p.toml",
            &format!(
                "[mesh]\nfile = \"{name}\"\n[[material]]\nyoung = 1e9\npoisson = 0.3\ndensity = 1e3\n[load]\n[time]\nscheme.name = \"bathe\"\nstep = 1e-3\n"
            ),
        );
        let problem = folder.path().join("p.toml").display().to_string();
        let ran = vademecum_tests::program::vademecum(&["build", &problem, "-o", &format!("{path}.vdm")]);
        ran.fails(4, &[name]);
        assert_eq!(ran.stderr.contains("vademecum mesh"), name == "flat.msh", "{}", ran.stderr);
    }
}
