//! `vademecum init`: a mesh that somebody has found becomes a problem that builds as it is.

use std::path::Path;

use vademecum_build::input::Problem;
use vademecum_tests::program::{command, repository, vademecum};
use vademecum_tests::shared::shared;

fn init(mesh: &Path, problem: &Path, more: &[&str]) -> vademecum_tests::program::Ran {
    let [mesh, problem] = [mesh, problem].map(|path| path.display().to_string());
    vademecum(&[&["init", &mesh, "-o", &problem], more].concat())
}

#[test]
fn what_is_proposed_for_a_bar_builds_and_says_why() {
    let folder = tempfile::tempdir().expect("a folder");
    let problem = folder.path().join("bar.toml");
    let bar = repository().join("fixtures/meshes/bar/gmsh41.msh");
    let ran = init(&bar, &problem, &["--material", "aluminium", "--json"]);
    let proposed = ran.json();
    let text = std::fs::read_to_string(&problem).expect("a problem");
    assert_eq!(proposed["text"].as_str(), Some(text.as_str()));
    for part in ["young = 7e10", "EN 1999-1-1", "ratio = 0.01", "[[output.probe]]", "# Held: "] {
        assert!(text.contains(part), "{part} in {text}");
    }
    let parsed = Problem::read(&problem).expect("a problem");
    let number = |key: &str| proposed[key].as_f64().expect("a number");
    // A step is 1, 2 or 5 times a power of ten, and at least 40 make the first period.
    let steps = 1.0 / (number("frequency") * parsed.time.step.expect("a step"));
    assert!((40.0..=101.0).contains(&steps), "{steps} steps");
    let file = folder.path().join("bar.vdm").display().to_string();
    let built = vademecum(&["build", &problem.display().to_string(), "-o", &file]);
    assert_eq!(built.code, Some(0), "{}", built.stderr);

    // What stands there stays, unless it may go.
    init(&bar, &problem, &[]).fails(2, &["bar.toml", "--force"]);
    assert_eq!(std::fs::read_to_string(&problem).expect("a problem"), text);
    assert_eq!(init(&bar, &problem, &["--force"]).code, Some(0));
    init(&bar, &bar, &["--force"]).fails(2, &["gmsh41.msh"]);
}

#[test]
fn the_unit_is_guessed_from_the_size_and_can_be_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let bar = repository().join("fixtures/meshes/bar/medit.mesh");
    let longest = |name: &str, more: &[&str]| {
        let ran = init(&bar, &folder.path().join(name), &[&["--json"], more].concat());
        ran.json()["longest_side"].as_f64().expect("a length")
    };
    let [own, small] = [longest("own.toml", &[]), longest("small.toml", &["--scale", "0.001"])];
    assert!((1e3 * small / own - 1.0).abs() < 1e-12);
    init(&bar, &folder.path().join("a.toml"), &["--scale=-1"]).fails(2, &["--scale"]);
    let said = init(&bar, &folder.path().join("b.toml"), &["--material", "cheese"]);
    said.fails(2, &["cheese", "steel", "liver"]);
    init(&folder.path().join("none.msh"), &folder.path().join("c.toml"), &[]).fails(4, &["none.msh"]);
}

/// Real meshes: every one becomes a problem whose support holds it, in millimetres (the square beam) as well
/// as without a flat end (five tetrahedra in a row).
#[test]
fn real_meshes_become_problems() {
    let meshes = [
        "gmsh41_binary/sphere_p2.msh",
        "vtu/raptorTetra_8418.vtu",
        "gmsh1/liver.msh",
        "medit/square_beam.mesh",
        "gmsh22_ascii/22_ascii.msh",
    ];
    for mesh in meshes {
        let Some(path) = shared(&format!("meshes/{mesh}")) else { return };
        let folder = tempfile::tempdir().expect("a folder");
        let problem = folder.path().join("p.toml");
        let ran = init(&path, &problem, &["--json"]);
        assert_eq!(ran.code, Some(0), "{mesh}: {}", ran.stderr);
        assert!(ran.json()["frequency"].as_f64() > Some(0.0), "{mesh}");
        Problem::read(&problem).expect("a problem");
    }
}

/// One command takes a stranger's mesh to the moving body.
#[test]
fn one_command_goes_from_a_mesh_to_the_page() {
    use std::io::{BufRead, BufReader, Read, Write};
    let folder = tempfile::tempdir().expect("a folder");
    let problem = folder.path().join("bar.toml").display().to_string();
    let mesh = repository().join("fixtures/meshes/bar/gmsh41.msh").display().to_string();
    let mut program = command(&["init", &mesh, "-o", &problem, "--view"]);
    // Nothing on the path: no browser starts.
    program.env("PATH", folder.path()).stdout(std::process::Stdio::piped());
    let mut server = program.spawn().expect("the program starts");
    let said = BufReader::new(server.stdout.take().expect("a pipe"));
    let address = said.lines().map(|line| line.expect("a line")).find(|line| line.starts_with("http://"));
    let address = address.expect("an address");
    let address = address.trim_start_matches("http://").split('/').next().expect("an address").to_string();
    let fetched = |what: &str| {
        let mut stream = std::net::TcpStream::connect(&address).expect("a connection");
        write!(stream, "GET {what} HTTP/1.1\r\nHost: {address}\r\n\r\n").expect("asked");
        let mut answer = vec![];
        stream.read_to_end(&mut answer).expect("an answer");
        let end = answer.windows(4).position(|w| w == b"\r\n\r\n").expect("a head");
        answer.split_off(end + 4)
    };
    let (page, file) = (fetched("/"), fetched("/body.vdm"));
    server.kill().expect("it runs");
    server.wait().expect("it ends");
    assert!(String::from_utf8_lossy(&page).contains("<canvas"), "no page");
    let file = vademecum_format::File::parse(&file).expect("a vademecum");
    assert!(file.metadata().n_load_nodes > 0 && file.metadata().scheme.is_exact());
}
