//! `vademecum init`: a mesh that somebody has found becomes a problem that builds as it is.

use std::path::Path;

use vademecum_build::input::Problem;
use vademecum_build::mesh::{self, Order};
use vademecum_tests::program::{command, repository, vademecum};
use vademecum_tests::shared::shared;

fn init(mesh: &Path, problem: &Path, more: &[&str]) -> vademecum_tests::program::Ran {
    let [mesh, problem] = [mesh, problem].map(|path| path.display().to_string());
    vademecum(&[&["init", &mesh, "-o", &problem], more].concat())
}

/// A linear mesh of tetrahedra in Gmsh's format 2.2; `groups` are names with their facets.
fn gmsh(nodes: &[[f64; 3]], elements: &[[u32; 4]], groups: &[(&str, Vec<[u32; 3]>)]) -> String {
    use std::fmt::Write as _;
    let mut text = format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{}\n", groups.len() + 1);
    for (tag, (name, _)) in (2..).zip(groups) {
        let _ = writeln!(text, "2 {tag} \"{name}\"");
    }
    let _ = writeln!(text, "3 1 \"solid\"\n$EndPhysicalNames\n$Nodes\n{}", nodes.len());
    for (number, [x, y, z]) in (1..).zip(nodes) {
        let _ = writeln!(text, "{number} {x} {y} {z}");
    }
    let facets: usize = groups.iter().map(|(_, facets)| facets.len()).sum();
    let _ = writeln!(text, "$EndNodes\n$Elements\n{}", elements.len() + facets);
    let mut number = 0;
    for (tag, (_, facets)) in (2..).zip(groups) {
        for [a, b, c] in facets.iter().map(|facet| facet.map(|node| node + 1)) {
            number += 1;
            let _ = writeln!(text, "{number} 2 2 {tag} {tag} {a} {b} {c}");
        }
    }
    for [a, b, c, d] in elements.iter().map(|element| element.map(|node| node + 1)) {
        number += 1;
        let _ = writeln!(text, "{number} 4 2 1 1 {a} {b} {c} {d}");
    }
    text + "$EndElements\n"
}

/// A block, its corners moved by `place`, with named sides.
fn moved_block(
    lengths: [f64; 3],
    divisions: [usize; 3],
    place: impl Fn([f64; 3]) -> [f64; 3],
    groups: &[(&str, &str)],
) -> (Vec<[f64; 3]>, Vec<[u32; 4]>, String) {
    let block = mesh::block(lengths, divisions, Order::Linear);
    let nodes: Vec<[f64; 3]> = block.nodes.iter().map(|&node| place(node)).collect();
    let elements = block.elements.as_chunks::<4>().0.to_vec();
    let groups: Vec<_> =
        groups.iter().map(|(name, side)| (*name, block.facet_groups[*side].clone())).collect();
    let text = gmsh(&nodes, &elements, &groups);
    (nodes, elements, text)
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
    // A step is 1, 2 or 5 times a power of ten, at least 40 make the first period, and none is longer than 1
    // ms.
    let step = parsed.time.step.expect("a step");
    let steps = 1.0 / (number("frequency") * step);
    assert!(step <= 1e-3 && steps >= 40.0 && (steps <= 101.0 || step == 1e-3), "{steps} steps of {step}");
    let file = folder.path().join("bar.vdm").display().to_string();
    let built = vademecum(&["build", &problem.display().to_string(), "-o", &file]);
    assert_eq!(built.code, Some(0), "{}", built.stderr);

    // A file that exists may have been edited, and stays; what the mesh lacks is said first.
    init(&bar, &problem, &[]).fails(2, &["bar.toml: exists; kept, since you may have edited it", "--force"]);
    init(&folder.path().join("none.msh"), &problem, &[]).fails(4, &["none.msh"]);
    let surface = folder.path().join("a.stl");
    std::fs::write(&surface, "solid a\nfacet normal 0 0 1\n").expect("written");
    init(&surface, &problem, &[]).fails(4, &["a.stl: the surface cannot be filled"]);
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

/// A mesh in a folder of its own, and what `init` proposes for it.
fn proposed(text: &str, more: &[&str]) -> (String, serde_json::Value) {
    let folder = tempfile::tempdir().expect("a folder");
    let (mesh, problem) = (folder.path().join("body.msh"), folder.path().join("body.toml"));
    std::fs::write(&mesh, text).expect("written");
    let ran = init(&mesh, &problem, &[&["--json"], more].concat());
    let found = ran.json();
    (std::fs::read_to_string(&problem).expect("a problem"), found)
}

#[test]
fn named_groups_are_held_before_the_geometry_is_asked() {
    let own = |groups: &[(&str, &str)]| moved_block([0.1, 0.03, 0.2], [2, 1, 4], |x| x, groups).2;
    // One that is named as a support, beside others.
    let (text, found) = proposed(&own(&[("stem end", "z_max"), ("tip", "z_min"), ("front", "y_min")]), &[]);
    assert_eq!(found["support"], "the group `stem end`");
    assert!(text.contains("[[support]]\non = { group = \"stem end\" }\n"), "{text}");
    for other in ["tip", "front"] {
        assert!(text.contains(&format!("\n# on = {{ group = \"{other}\" }}\n")), "{text}");
    }
    // Several.
    let (_, found) = proposed(&own(&[("bolt 1", "z_max"), ("bolt 2", "z_min"), ("load", "x_min")]), &[]);
    assert_eq!(found["support"], "the groups `bolt 1`, `bolt 2`");
    // A name that says nothing, of a small part of the surface; a load is none.
    let (_, found) = proposed(&own(&[("a", "z_max"), ("pressure", "z_min")]), &[]);
    assert_eq!(found["support"], "the group `a`");
    // Sides of a cube are a sixth of its surface each; two of them together are no support.
    let sides = [("a", "x_min"), ("b", "x_max")];
    let (_, found) = proposed(&moved_block([0.1; 3], [2; 3], |x| x, &sides).2, &[]);
    assert!(found["support"].as_str().expect("words").contains("flat face"), "{found}");
    // What is asked for.
    let hold = |place: &str| proposed(&own(&[("a", "z_max")]), &["--hold", place]).1["support"].to_string();
    assert!(hold("a").contains("the group `a`"));
    assert!(hold("x_max").contains("the flat end along x"));
    assert!(hold("none").contains("a free body"));
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = folder.path().join("body.msh");
    std::fs::write(&mesh, own(&[("left side", "x_min")])).expect("written");
    let refused = init(&mesh, &folder.path().join("p.toml"), &["--hold", "left sid"]);
    refused.fails(2, &["--hold left sid", "`left side`", "x_min"]);
}

/// A creature without a flat face but its one foot: a body that narrows to the bottom.
#[test]
fn a_body_without_a_flat_face_is_held_at_its_foot_and_is_of_rubber() {
    // Sides bulge, so that no face is flat; the y axis points up, and the foot is round but level.
    let bulge = |[x, y, z]: [f64; 3]| {
        let (u, v, w) = (x - 0.5, y / 2.0 - 0.5, z - 0.5);
        let width = 0.6 + 0.8 * (v + 0.5);
        let side = |a: f64, b: f64, c: f64| a * (1.0 - 0.5 * (b * b + c * c)) * width;
        [side(u, v, w) + 0.02 * (9.0 * v).sin(), v * (1.0 - 0.1 * (u * u + w * w)), side(w, v, u)]
    };
    let text = moved_block([1.0, 2.0, 1.0], [5, 10, 5], bulge, &[]).2;
    let (problem, found) = proposed(&text, &[]);
    assert_eq!((&found["up"], &found["material"]), (&"y".into(), &"rubber".into()), "{found}");
    assert!(found["support"].as_str().expect("words").contains("lowest tenth with y up"), "{found}");
    assert!(problem.contains("{ axis = \"y\", side = \"min\", fraction = 0.1 }"), "{problem}");
    // What is touched may be touched a thousand times a second.
    assert!(found["time_step"].as_f64().expect("a number") <= 1e-3, "{found}");
    let (_, found) = proposed(&text, &["--up", "z", "--hold", "bottom", "--material", "steel"]);
    assert_eq!((&found["up"], &found["material"]), (&"z".into(), &"steel".into()));
    assert!(found["support"].as_str().expect("words").contains("first tenth along z"), "{found}");
}

/// Linear tetrahedra get mid-side nodes; a deck that names its elements stays as it is.
#[test]
fn linear_meshes_are_raised() {
    let text = moved_block([0.4, 0.1, 0.1], [4, 1, 1], |x| x, &[]).2;
    let (problem, found) = proposed(&text, &["--hold", "x_min"]);
    assert!(problem.contains("order = \"quadratic\""), "{problem}");
    // 81 edges more than corners: 9 × 3 × 3 nodes of a quadratic block, 9 of them held.
    assert_eq!((&found["raised"], &found["dofs"]), (&true.into(), &(3 * (81 - 9)).into()));
    let folder = tempfile::tempdir().expect("a folder");
    let deck = repository().join("fixtures/meshes/bar/deck.inp");
    let ran = init(&deck, &folder.path().join("p.toml"), &["--json"]);
    assert_eq!(ran.json()["raised"], false);
}

/// The number that `order = "quadratic"` gains, in words and in JSON, beside what the quadratic mesh has.
#[test]
fn linear_meshes_come_with_the_error_of_their_first_frequency() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mesh, problem) = (folder.path().join("body.msh"), folder.path().join("body.toml"));
    let text = moved_block([0.4, 0.1, 0.1], [4, 1, 1], |x| x, &[]).2;
    std::fs::write(&mesh, &text).expect("written");
    let (_, found) = proposed(&text, &["--hold", "x_min"]);
    let first = &found["linear_mesh_error"]["frequencies"][0];
    let [linear, refined, error] =
        ["mesh", "refined", "error"].map(|key| first[key].as_f64().expect("a number"));
    // One cube through the thickness is far too stiff, and the quadratic mesh lies near the refined value.
    assert!(error > 0.3 && (linear / refined - 1.0 - error).abs() < 1e-12, "{first}");
    let quadratic = found["frequency"].as_f64().expect("a number");
    assert!((quadratic / refined - 1.0).abs() < 0.1 && linear > 1.2 * quadratic, "{quadratic} Hz, {first}");
    let words = init(&mesh, &problem, &["--hold", "x_min"]).stdout;
    let percent = format!("{:.1e}", 100.0 * (linear / quadratic - 1.0)).parse::<f64>().expect("a number");
    let gain = format!("on linear elements, {percent} % above that: `order = \"quadratic\"` was written");
    assert!(words.contains(&gain), "{gain}: {words}");
    // A deck keeps its elements, whose error is reported; a quadratic mesh has nothing to gain.
    let deck = repository().join("fixtures/meshes/bar/deck.inp");
    let words = init(&deck, &folder.path().join("deck.toml"), &[]).stdout;
    assert!(words.contains("too high: `order = \"quadratic\"` in `[mesh]` takes most"), "{words}");
    let vtu = repository().join("fixtures/meshes/bar/quadratic-vtu.vtu");
    let ran = init(&vtu, &folder.path().join("vtu.toml"), &["--json"]);
    assert!(ran.json()["linear_mesh_error"].is_null(), "{}", ran.stdout);
}

/// The key `mesh.order` on a linear file is the mesh written quadratic: the same frequencies, with groups of
/// facets and nodes, a region cut out of it, and a pressure on six-node facets.
#[test]
fn a_raised_mesh_is_the_mesh_written_quadratic() {
    let (lengths, divisions) = ([0.4, 0.1, 0.1], [5, 1, 2]);
    let folder = tempfile::tempdir().expect("a folder");
    let linear = moved_block(lengths, divisions, |x| x, &[("root", "x_min"), ("top", "z_max")]).2;
    std::fs::write(folder.path().join("linear.msh"), linear).expect("written");
    let block = mesh::block(lengths, divisions, Order::Quadratic);
    let rows = |name: &str, rows: Vec<String>| {
        std::fs::write(folder.path().join(name), rows.join("\n")).expect("written");
    };
    rows("nodes.txt", block.nodes.iter().map(|[x, y, z]| format!("{x} {y} {z}")).collect());
    let element = |e: &[u32]| e.iter().map(|node| (node + 1).to_string()).collect::<Vec<_>>().join(" ");
    rows("elements.txt", block.elements.chunks_exact(10).map(element).collect());

    let common = "scale = 2.0\n[[mesh.region]]\nname = \"far\"\n\
        on = { fraction = { axis = \"x\", side = \"max\", fraction = 0.4 } }\n\
        [[material]]\nyoung = 2e9\npoisson = 0.3\ndensity = 1000.0\n\
        [[material]]\nregion = \"far\"\nyoung = 1e9\npoisson = 0.3\ndensity = 1500.0\n";
    let tail = |root: &str, top: &str| {
        format!(
            "{common}[[support]]\non = {root}\n[load]\nsurface = {top}\n\
             [[load.pattern]]\nname = \"p\"\npressure = 10.0\non = {top}\n[time]\nstep = 1e-4\n[basis]\nmodes = 8\n\
             [tolerance]\nerror = 0.5\n\
             [[output.probe]]\nname = \"end\"\npoint = [0.8, 0.1, 0.2]\ndirection = [0.0, 0.0, 1.0]\n"
        )
    };
    let plane = |axis: &str, at: f64| format!("{{ plane = {{ axis = \"{axis}\", at = {at:?} }} }}");
    let cases = [
        (
            "raised",
            "file = \"linear.msh\"\norder = \"quadratic\"",
            "{ group = \"root\" }",
            "{ group = \"top\" }",
        ),
        (
            "written",
            "tables = { coordinates = \"nodes.txt\", connectivity = \"elements.txt\" }",
            &plane("x", 0.0),
            &plane("z", 0.2),
        ),
    ];
    std::fs::write(folder.path().join("push.toml"), "duration = 0.02\n[[pattern]]\nname = \"p\"\n")
        .expect("written");
    let [raised, written] = cases.map(|(name, mesh, root, top)| {
        let at = |extension: &str| folder.path().join(format!("{name}{extension}")).display().to_string();
        std::fs::write(at(".toml"), format!("[mesh]\n{mesh}\n{}", tail(root, top))).expect("written");
        let modes = vademecum(&["modes", &at(".toml"), "--count", "8", "--json"]).json();
        let built = vademecum(&["build", &at(".toml"), "-o", &at(".vdm")]);
        assert_eq!(built.code, Some(0), "{}", built.stderr);
        let push = folder.path().join("push.toml").display().to_string();
        let ran = vademecum(&["run", &at(".vdm"), "--scenario", &push, "-o", &at("")]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        let probes = std::fs::read_to_string(Path::new(&at("")).join("probes.csv")).expect("a table");
        let last = probes.lines().last().expect("a row").rsplit(',').next().expect("a value").to_string();
        (modes, last.parse::<f64>().expect("a number"))
    });
    assert_eq!(raised.0["dofs"], written.0["dofs"]);
    let frequencies = |found: &serde_json::Value| -> Vec<f64> {
        found["frequencies_hz"]
            .as_array()
            .expect("a list")
            .iter()
            .map(|f| f.as_f64().expect("a number"))
            .collect()
    };
    for (a, b) in frequencies(&raised.0).iter().zip(frequencies(&written.0)) {
        // To the eight digits that the search for modes keeps.
        assert!((a / b - 1.0).abs() < 1e-8, "{a} Hz, {b} Hz");
    }
    // The pressure acts on all of the six nodes of each facet of `top`.
    assert!(raised.1 != 0.0 && (raised.1 / written.1 - 1.0).abs() < 1e-5, "{} m, {} m", raised.1, written.1);
}

/// A mesh with a crumb that shares no facet with the rest, and with one that is too large for a crumb.
#[test]
fn loose_crumbs_are_left_out_and_larger_parts_refused_by_name() {
    let (mut nodes, mut elements, _) = moved_block([1.0, 0.2, 0.2], [10, 2, 2], |x| x, &[]);
    let body = elements.len();
    // Joined to an edge of the body, so that it hinges there.
    let first = nodes.len() as u32;
    nodes.extend([[0.0, -0.1, -0.1], [0.1, -0.1, 0.0]]);
    elements.push([0, 1, first + 1, first]);
    let folder = tempfile::tempdir().expect("a folder");
    let (mesh, problem) = (folder.path().join("body.msh"), folder.path().join("body.toml"));
    std::fs::write(&mesh, gmsh(&nodes, &elements, &[])).expect("written");
    let report = vademecum(&["mesh", &mesh.display().to_string()]);
    assert_eq!(report.code, Some(0), "{}", report.stderr);
    let parts = format!("2 parts that are joined by edges or nodes only (elements {body}, 1;");
    assert!(report.stdout.contains(&parts), "{}", report.stdout);
    let ran = init(&mesh, &problem, &["--hold", "x_max"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let left_out = format!("1 loose parts with 1 of {} elements were left out", body + 1);
    let read = mesh::read_without(&mesh, 0.01).expect("a mesh");
    assert!(
        read.element_count() == body && read.notes.iter().any(|n| n.starts_with(&left_out)),
        "{:?}",
        read.notes
    );
    assert!(std::fs::read_to_string(&problem).expect("a problem").contains("smallest_part = 0.01"));
    let refused = init(&mesh, &problem, &["--smallest-part", "0.001", "--force"]);
    refused.fails(4, &[&format!("2 parts that share no facet, with {body}, 1 of"), "--smallest-part"]);
}

/// A body of eight units may be an ear's bones in millimetres or a boat in metres.
#[test]
fn a_doubtful_size_is_asked_about_at_the_end() {
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = folder.path().join("body.msh");
    std::fs::write(&mesh, moved_block([8.5, 2.0, 2.0], [4, 1, 1], |x| x, &[]).2).expect("written");
    let said = |name: &str, more: &[&str]| {
        let ran = init(&mesh, &folder.path().join(name), more);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        ran.stdout.lines().last().expect("a line").to_string()
    };
    assert_eq!(said("a.toml", &[]), "8.5 m long? If the mesh is in millimetres, add --scale 0.001");
    assert!(said("b.toml", &["--scale", "1"]).starts_with("next: "));
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
