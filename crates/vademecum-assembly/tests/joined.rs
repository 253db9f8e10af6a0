//! Joined bodies against the full order of the joined mesh: two halves of a beam, and a post on a plate.
//!
//! The bodies, their numbers and the bounds are those of Rubin's synthesis with all nodes of the patches.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use vademecum_assembly::{Assembled, AssemblyError, AssemblyFile, assemble};
use vademecum_build::dynamics::lowest_modes;
use vademecum_build::input::Problem;
use vademecum_build::mesh::{Mesh, Order, block};
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::prepared::prepare;
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_eval::{Contact, Field, Loads, Scene, SceneOptions, State, Surface};
use vademecum_format::{File, SectionKind};

const MATERIAL: &str = "[[material]]\nyoung = 2e9\npoisson = 0.3\ndensity = 1000.0\n";

/// Keys of a part of `modes` modes after its mesh, its support and its ports.
fn keys(modes: usize) -> String {
    format!("{MATERIAL}[time]\nstep = 1e-4\n[basis]\nmodes = {modes}\n[output]\nprecision = \"f64\"\n")
}

fn beam(modes: usize) -> [String; 2] {
    let mesh = "[mesh]\nblock = { lengths = [0.5, 0.05, 0.05], divisions = [10, 2, 2] }\n";
    let port = |side: &str| format!("[[port]]\nname = \"end\"\non = {{ group = \"{side}\" }}\n");
    let support = "[[support]]\non = { group = \"x_min\" }\n";
    let keys = keys(modes);
    [format!("{mesh}{keys}{support}{}", port("x_max")), format!("{mesh}{keys}{}", port("x_min"))]
}

fn tee(modes: usize, divisions: &str) -> [String; 2] {
    let plate = "[mesh]\nblock = { lengths = [0.4, 0.4, 0.04], divisions = [8, 8, 1] }\n";
    let post = format!("[mesh]\nblock = {{ lengths = [0.1, 0.1, 0.3], divisions = {divisions} }}\n");
    let support = "[[support]]\non = { group = \"x_min\" }\n";
    let top = "[[port]]\nname = \"top\"\non = { box = { min = [0.149, 0.149, 0.039], max = [0.251, 0.251, 0.041] } }\n";
    let foot = "[[port]]\nname = \"foot\"\non = { group = \"z_min\" }\n";
    let keys = keys(modes);
    [format!("{plate}{keys}{support}{top}"), format!("{post}{keys}{foot}")]
}

const BEAM: &str = "position = [0.5, 0.0, 0.0]";
const TEE: &str = "position = [0.15, 0.15, 0.04]";

/// Builds both parts, `a` and `b` at a place, and joins them.
fn joined(parts: [String; 2], place: &str, joints: &str) -> Result<Assembled, AssemblyError> {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in ["a", "b"].into_iter().zip(parts) {
        std::fs::write(folder.path().join(format!("{name}.vdm")), built(&text, folder.path()))
            .expect("written");
    }
    let text = format!(
        "format = 1\n[[part]]\nname = \"a\"\nfile = \"a.vdm\"\n[[part]]\nname = \"b\"\nfile = \"b.vdm\"\n\
         {place}\n{joints}"
    );
    assemble(&AssemblyFile::parse(&text, "assembly.toml", folder.path().to_path_buf())?)
}

fn built(text: &str, folder: &Path) -> Vec<u8> {
    let problem = Problem::parse(text, "part.toml", folder.to_path_buf()).expect("a problem");
    build(&problem, &BuildOptions::default(), &Silent).expect("a build").either().bytes
}

/// The ten lowest frequencies of a problem at full order \[Hz\].
fn whole(text: &str, folder: &Path) -> Vec<f64> {
    let problem = Problem::parse(text, "whole.toml", folder.to_path_buf()).expect("a problem");
    let prepared = prepare(&problem, &mut Stopwatch::new(&Silent), &Silent).expect("a model");
    let modes = lowest_modes(prepared.body.model.pencil(), &prepared.symbolic, 10).expect("modes");
    modes.frequencies_hz()
}

/// A deck of two blocks of linear tetrahedra, merged where nodes coincide if they match.
fn deck(plate: &Mesh, post: &Mesh, at: [f64; 3], merged: bool) -> String {
    let mut text = String::from("*NODE\n");
    let key = |x: [f64; 3]| x.map(|x| (x * 1e7).round() as i64);
    let mut known: BTreeMap<[i64; 3], usize> = BTreeMap::new();
    for (node, &x) in plate.nodes.iter().enumerate() {
        known.insert(key(x), node + 1);
        writeln!(text, "{}, {}, {}, {}", node + 1, x[0], x[1], x[2]).expect("text");
    }
    let mut next = plate.nodes.len();
    let mut number = vec![];
    for &x in &post.nodes {
        let x: [f64; 3] = std::array::from_fn(|c| x[c] + at[c]);
        match known.get(&key(x)).filter(|_| merged) {
            Some(&node) => number.push(node),
            None => {
                next += 1;
                number.push(next);
                writeln!(text, "{next}, {}, {}, {}", x[0], x[1], x[2]).expect("text");
            }
        }
    }
    text.push_str("*ELEMENT, TYPE=C3D4, ELSET=body\n");
    let cells = plate.elements.chunks(4).map(|cell| cell.iter().map(|&node| node as usize + 1).collect());
    let others = post.elements.chunks(4).map(|cell| cell.iter().map(|&node| number[node as usize]).collect());
    for (index, cell) in cells.chain(others).enumerate() {
        let cell: Vec<usize> = cell;
        writeln!(text, "{}, {}, {}, {}, {}", index + 1, cell[0], cell[1], cell[2], cell[3]).expect("text");
    }
    let mut set = |name: &str, nodes: Vec<usize>| {
        writeln!(text, "*NSET, NSET={name}").expect("text");
        nodes.iter().for_each(|node| writeln!(text, "{node},").expect("text"));
    };
    let on = |mesh: &Mesh, z: f64| -> Vec<usize> {
        (0..mesh.nodes.len()).filter(|&node| (mesh.nodes[node][2] - z).abs() < 1e-9).collect()
    };
    set("top", on(plate, 0.04).into_iter().map(|node| node + 1).collect());
    set("foot", on(post, 0.0).into_iter().map(|node| number[node]).collect());
    text
}

/// The post on the plate as one mesh at full order.
fn whole_tee(divisions: [usize; 3], merged: bool) -> Vec<f64> {
    let folder = tempfile::tempdir().expect("a folder");
    let plate = block([0.4, 0.4, 0.04], [8, 8, 1], Order::Linear);
    let post = block([0.1, 0.1, 0.3], divisions, Order::Linear);
    std::fs::write(folder.path().join("tee.inp"), deck(&plate, &post, [0.15, 0.15, 0.04], merged))
        .expect("written");
    let tie = "[[tie]]\non = { group = \"foot\" }\nto = { group = \"top\" }\ndistance = 1e-6\n";
    let text = format!(
        "[mesh]\nfile = \"tee.inp\"\norder = \"quadratic\"\n{MATERIAL}[[support]]\n\
         on = {{ plane = {{ axis = \"x\", at = 0.0 }} }}\n{}",
        if merged { "" } else { tie }
    );
    whole(&text, folder.path())
}

fn whole_beam() -> Vec<f64> {
    let text = format!(
        "[mesh]\nblock = {{ lengths = [1.0, 0.05, 0.05], divisions = [20, 2, 2] }}\n{MATERIAL}[[support]]\n\
         on = {{ group = \"x_min\" }}\n"
    );
    whole(&text, &PathBuf::new())
}

/// The worst relative difference of ten frequencies.
fn worst(found: &[f64], expected: &[f64]) -> f64 {
    assert!(found.len() == 10 && expected.len() == 10);
    found.iter().zip(expected).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max)
}

fn weld(first: &str, second: &str) -> String {
    format!("[[joint]]\nkind = \"weld\"\nbetween = [\"{first}\", \"{second}\"]\n")
}

#[test]
fn welded_halves_of_a_beam_have_the_frequencies_of_the_whole() {
    let expected = whole_beam();
    for (modes, bound) in [(8, 1e-4), (16, 5e-6)] {
        let found = joined(beam(modes), BEAM, &weld("b.end", "a.end")).expect("joined").report;
        let error = worst(&found.frequencies_hz, &expected);
        println!("beam, {modes} modes a half: {error:.1e}");
        assert!(error < bound, "{modes} modes: {error:.2e}");
        assert_eq!((found.joints[0].rows, found.synthesis), (75, "Rubin"));
        assert_eq!(found.modes, 2 * modes + 6);
    }
}

#[test]
fn a_post_welded_on_a_plate_has_the_frequencies_of_the_whole() {
    let expected = whole_tee([2, 2, 6], true);
    for (modes, bound) in [(8, 2e-3), (16, 5e-5)] {
        let found = joined(tee(modes, "[2, 2, 6]"), TEE, &weld("b.foot", "a.top")).expect("joined").report;
        let error = worst(&found.frequencies_hz, &expected);
        println!("tee, {modes} modes a part: {error:.1e}");
        assert!(error < bound, "{modes} modes: {error:.2e}");
    }
}

#[test]
fn meshes_that_do_not_match_are_welded_as_a_tie_welds_them() {
    let expected = whole_tee([3, 3, 7], false);
    let found = joined(tee(16, "[3, 3, 7]"), TEE, &weld("b.foot", "a.top")).expect("joined").report;
    let error = worst(&found.frequencies_hz, &expected);
    println!("tee, nonmatching: {error:.1e}");
    assert_eq!(found.joints[0].rows, 147);
    assert!(error < 1e-4, "{error:.2e}");
}

#[test]
fn the_joined_file_is_sound_and_its_static_answers_are_those_of_the_whole() {
    // A weight on each half, and a probe at the end of the second one.
    const WEIGHT: &str = "[[load.pattern]]\nname = \"weight\"\nacceleration = [1.0, 2.0, -9.81]\n";
    let probe = |x: f64| {
        format!("[[output.probe]]\nname = \"end\"\npoint = [{x}, 0.05, 0.05]\ndirection = [0.0, 0.6, 0.8]\n")
    };
    let [a, b] = beam(8);
    let parts = [format!("{a}{WEIGHT}"), format!("{b}{WEIGHT}{}", probe(0.5))];
    let joined = joined(parts, BEAM, &weld("b.end", "a.end")).expect("joined");
    vademecum_rewrite::check(&joined.bytes).expect("a sound file");
    let mesh = "[mesh]\nblock = { lengths = [1.0, 0.05, 0.05], divisions = [20, 2, 2] }\n";
    let support = "[[support]]\non = { group = \"x_min\" }\n";
    let whole = built(&format!("{mesh}{}{}{WEIGHT}{support}", keys(12), probe(1.0)), &PathBuf::new());
    let [answers, expected] = [&joined.bytes, &whole].map(|bytes| probe_at_rest(bytes));
    assert!((answers / expected - 1.0).abs() < 1e-9, "{answers:e} beside {expected:e}");
    let (found, expected) = (own_flexibility(&joined.bytes), own_flexibility(&whole));
    let mut compared = 0;
    for (place, blocks) in &found {
        // Nodes inside the weld are loadable in the parts alone.
        let Some(expected) = expected.get(place) else { continue };
        // Nodes of the weld stand twice in the joined file, each with the answer of the joint.
        for block in blocks {
            compared += 1;
            let size = expected[0].iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            for (a, b) in block.iter().zip(&expected[0]) {
                assert!((a - b).abs() <= 1e-9 * size, "{place:?}: {a:e} beside {b:e}");
            }
        }
    }
    assert!(compared > 300, "{compared} nodes");
}

/// The first probe at rest under all load patterns: modes and residual flexibility.
fn probe_at_rest(bytes: &[u8]) -> f64 {
    let file = File::parse(bytes).expect("a file");
    let numbers = |kind: SectionKind| -> Vec<f64> {
        file.section(kind).expect("a section").numbers().expect("numbers").iter().collect()
    };
    let (values, probe) = (numbers(SectionKind::Eigenvalues), numbers(SectionKind::ProbeRows));
    let r = values.len();
    let modal = numbers(SectionKind::PatternBasis);
    let modal = modal.chunks(r).map(|pattern| (0..r).map(|k| pattern[k] * probe[k] / values[k]).sum::<f64>());
    modal.sum::<f64>() + numbers(SectionKind::PatternProbeResidual).iter().sum::<f64>()
}

/// `K⁻¹` of each loadable node with itself, by its place: modes and residual flexibility.
fn own_flexibility(bytes: &[u8]) -> BTreeMap<[i64; 3], Vec<[f64; 6]>> {
    let file = File::parse(bytes).expect("a file");
    let numbers = |kind: SectionKind| -> Vec<f64> {
        file.section(kind).expect("a section").numbers().expect("numbers").iter().collect()
    };
    let (basis, values) = (numbers(SectionKind::SurfaceBasis), numbers(SectionKind::Eigenvalues));
    let (residual, places) = (numbers(SectionKind::ContactResidual), numbers(SectionKind::NodeCoordinates));
    let r = values.len();
    let mut found: BTreeMap<_, Vec<[f64; 6]>> = BTreeMap::new();
    for (node, residual) in residual.as_chunks::<6>().0.iter().enumerate() {
        let row = |c: usize| &basis[(3 * node + c) * r..(3 * node + c + 1) * r];
        let entries = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
        let block = std::array::from_fn(|k| {
            let (i, j) = entries[k];
            let modal: f64 = (0..r).map(|k| row(i)[k] * row(j)[k] / values[k]).sum();
            modal + residual[k]
        });
        let place = std::array::from_fn(|c| (places[3 * node + c] * 1e7).round() as i64);
        found.entry(place).or_default().push(block);
    }
    found
}

#[test]
fn bushings_have_their_stiffness() {
    const STIFFNESS: f64 = 2e6;
    // Nodes at one place are refused in a mesh.
    const GAP: f64 = 1e-6;
    let bushing = format!(
        "[[joint]]\nkind = \"bushing\"\nbetween = [\"b.end\", \"a.end\"]\n\
         stiffness = [{STIFFNESS:e}, {STIFFNESS:e}, {STIFFNESS:e}]\n"
    );
    let found = joined(beam(16), BEAM, &bushing).expect("joined").report;
    let rigid = whole_beam();
    // A spring at each of 25 nodes between the halves at full order: 50 points that nodes follow.
    let folder = tempfile::tempdir().expect("a folder");
    let half = block([0.5, 0.05, 0.05], [10, 2, 2], Order::Linear);
    std::fs::write(folder.path().join("two.inp"), deck(&half, &half, [0.5 + GAP, 0.0, 0.0], false))
        .expect("written");
    let mut text = format!(
        "[mesh]\nfile = \"two.inp\"\norder = \"quadratic\"\n{MATERIAL}[[support]]\n\
         on = {{ plane = {{ axis = \"x\", at = 0.0 }} }}\n"
    );
    let tied =
        format!("{text}[[tie]]\non = {{ group = \"body\" }}\nto = {{ group = \"body\" }}\ndistance = 0.0\n");
    let problem = Problem::parse(&tied, "two.toml", folder.path().to_path_buf()).expect("a problem");
    let mesh = vademecum_build::prepared::read_mesh(&problem).expect("a mesh");
    let at: Vec<usize> =
        (0..mesh.nodes.len()).filter(|&n| (mesh.nodes[n][0] - 0.5).abs() < 2.0 * GAP).collect();
    assert_eq!(at.len(), 50);
    let mut pairs: BTreeMap<[i64; 2], Vec<usize>> = BTreeMap::new();
    for node in at {
        let [_, y, z] = mesh.nodes[node].map(|x| (x * 1e7).round() as i64);
        pairs.entry([y, z]).or_default().push(node);
    }
    for (index, pair) in pairs.values().enumerate() {
        for (side, &node) in ["a", "b"].into_iter().zip(pair) {
            let [x, y, z] = mesh.nodes[node];
            write!(
                text,
                "[[reference_point]]\nname = \"{side}{index}\"\nat = [{x}, {y}, {z}]\nheld = [\"rx\", \"ry\", \
                 \"rz\"]\n[[coupling]]\nreference = \"{side}{index}\"\nkind = \"rigid\"\non = {{ nodes = [{}] }}\n",
                mesh.node_ids[node]
            )
            .expect("text");
        }
        write!(
            text,
            "[[spring]]\nfrom = \"a{index}\"\nto = \"b{index}\"\n\
             stiffness = [{STIFFNESS:e}, {STIFFNESS:e}, {STIFFNESS:e}, 0.0, 0.0, 0.0]\n"
        )
        .expect("text");
    }
    let expected = whole(&text, folder.path());
    let error = worst(&found.frequencies_hz, &expected);
    println!("bushings: {error:.1e}; welded {:.1e}", worst(&expected, &rigid));
    assert!(error < 2e-4, "{error:.2e}");
    assert!(worst(&expected, &rigid) > 1e-2);
}

#[test]
fn a_hinge_leaves_one_motion_and_a_part_without_a_joint_six() {
    let frame =
        |side: &str| format!("[[port]]\nname = \"pin\"\nkind = \"frame\"\non = {{ group = \"{side}\" }}\n");
    let [a, b] = beam(8);
    let parts = [format!("{a}{}", frame("x_max")), format!("{b}{}", frame("x_min"))];
    let hinge = |kind: &str| format!("[[joint]]\nkind = \"{kind}\"\nbetween = [\"b.pin\", \"a.pin\"]\n");
    let motions = |joints: &str| match joined(parts.clone(), BEAM, joints) {
        Err(AssemblyError::Free { motions, parts }) => {
            assert_eq!(parts, "`b`");
            motions
        }
        other => panic!("{other:?}"),
    };
    assert_eq!([hinge("hinge"), hinge("ball"), hinge("slider")].map(|joint| motions(&joint)), [1, 3, 1]);
    assert_eq!(motions(""), 6);
    let twice = hinge("weld") + "name = \"first\"\n" + &hinge("hinge");
    match joined(parts.clone(), BEAM, &twice) {
        Err(AssemblyError::Redundant { joint }) => assert_eq!(joint, "hinge2"),
        other => panic!("{other:?}"),
    }
    // Six mean motions hold a slender beam to a thousandth.
    let found = joined(parts, BEAM, &hinge("weld")).expect("joined").report;
    let error = worst(&found.frequencies_hz, &whole_beam());
    println!("beam, six mean motions: {error:.1e}");
    assert!(error < 2e-3, "{error:.1e}");
}

#[test]
fn a_part_may_be_turned() {
    let [a, b] = beam(8);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    // Both halves turned about z by a right angle, the second one behind the first along y.
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in [("a", a), ("b", b)] {
        std::fs::write(folder.path().join(format!("{name}.vdm")), built(&text, folder.path()))
            .expect("written");
    }
    let part = |name: &str, y: f64| {
        format!(
            "[[part]]\nname = \"{name}\"\nfile = \"{name}.vdm\"\nposition = [0.0, {y}, 0.0]\n\
             rotation = [{half}, 0.0, 0.0, {half}]\n"
        )
    };
    let text = format!("format = 1\n{}{}{}", part("a", 0.0), part("b", 0.5), weld("b.end", "a.end"));
    let file = AssemblyFile::parse(&text, "turned.toml", folder.path().to_path_buf()).expect("an assembly");
    let turned = assemble(&file).expect("joined");
    let error = worst(&turned.report.frequencies_hz, &whole_beam());
    assert!(error < 1e-4, "{error:.2e}");
    let file = File::parse(&turned.bytes).expect("a file");
    let places: Vec<f64> = file
        .section(SectionKind::NodeCoordinates)
        .expect("places")
        .numbers()
        .expect("numbers")
        .iter()
        .collect();
    let extent = |c: usize| places.iter().skip(c).step_by(3).fold(0.0, |m: f64, x| m.max(x.abs()));
    assert!((extent(1) - 1.0).abs() < 1e-12 && (extent(0) - 0.05).abs() < 1e-12);
}

/// Displacements of the loadable nodes by their place, in turn over some steps, under a pulse `sin²` at a
/// place.
fn pulse(
    bytes: &[u8],
    step: f64,
    steps: usize,
    length: f64,
    at: [f64; 3],
) -> Vec<BTreeMap<[i64; 3], [f64; 3]>> {
    let file = File::parse(bytes).expect("a file");
    let options = SceneOptions { time_step: Some(step), ..SceneOptions::default() };
    let sizes = Scene::<f64>::sizes(&file, &options).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let (mut of_state, mut of_loads) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let scene = Scene::bind(&file, &options, &mut memory, &mut work).expect("a scene");
    let mut state = State::new(&scene, &mut of_state).expect("a state");
    let mut loads = Loads::new(&scene, &mut of_loads).expect("loads");
    let place = Surface::new(&file).expect("a surface").locate(at).expect("a place").place;
    let contact = Contact::new(place, [0.0, 10.0, 0.0]);
    let places = file.section(SectionKind::NodeCoordinates).expect("places").numbers().expect("numbers");
    let key = |node: usize| {
        std::array::from_fn(|c| (places.get(3 * node + c).expect("a number") * 1e7).round() as i64)
    };
    let surface = file.metadata().n_surface_nodes as usize;
    let mut field = vec![0.0; 3 * surface];
    let amplitude =
        |time: f64| if time < length { (std::f64::consts::PI * time / length).sin().powi(2) } else { 0.0 };
    let mut shown = vec![];
    for n in 0..steps {
        loads.clear();
        let mut amplitudes = [0.0; 1 + vademecum_format::scheme::MAX_STAGES];
        (amplitudes[0], amplitudes[1]) = (amplitude(n as f64 * step), amplitude((n + 1) as f64 * step));
        loads.add_contact_staged(&scene, &contact, &amplitudes).expect("a load");
        scene.step(&mut state, &loads).expect("a step");
        if (n + 1) % 40 == 0 {
            scene.surface_into(&state, Field::Displacement, &mut field).expect("a field");
            let rows = field.as_chunks::<3>().0;
            shown.push((0..surface).map(|node| (key(node), rows[node])).collect());
        }
    }
    shown
}

#[test]
fn a_pulse_moves_the_joined_body_as_it_moves_the_whole() {
    let folder = tempfile::tempdir().expect("a folder");
    let plate = block([0.4, 0.4, 0.04], [8, 8, 1], Order::Linear);
    let post = block([0.1, 0.1, 0.3], [2, 2, 6], Order::Linear);
    std::fs::write(folder.path().join("tee.inp"), deck(&plate, &post, [0.15, 0.15, 0.04], true))
        .expect("written");
    let support = "[[support]]\non = { plane = { axis = \"x\", at = 0.0 } }\n";
    // A corner of the free end of the post; a period of the first mode in 400 steps.
    let (at, period) = ([0.15, 0.15, 0.34], 1.0 / 44.2304);
    let march = |bytes: &[u8]| pulse(bytes, period / 400.0, 4000, period / 4.0, at);
    for (damping, bound) in [("", 3e-4), ("[damping]\nratio = 0.02\n", 6e-4)] {
        let whole = |modes: usize| {
            let mesh = "[mesh]\nfile = \"tee.inp\"\norder = \"quadratic\"\n";
            march(&built(&format!("{mesh}{}{damping}{support}", keys(modes)), folder.path()))
        };
        let parts = tee(16, "[2, 2, 6]").map(|text| text + damping);
        let joined = joined(parts, TEE, &weld("b.foot", "a.top")).expect("joined");
        assert_eq!(joined.report.damping_coupling, 0.0);
        let reference = whole(160);
        let [error, of_whole] =
            [march(&joined.bytes), whole(joined.report.modes)].map(|found| distance(&found, &reference));
        println!("pulse on the tee, {damping:?}: {error:.1e}; the whole with as many modes: {of_whole:.1e}");
        assert!(error < bound && error < of_whole, "{error:.1e}");
    }
}

/// Relative distance of fields over time, over the nodes that both have.
fn distance(found: &[BTreeMap<[i64; 3], [f64; 3]>], reference: &[BTreeMap<[i64; 3], [f64; 3]>]) -> f64 {
    let (mut apart, mut size, mut compared) = (0.0, 0.0, 0);
    for (found, reference) in found.iter().zip(reference) {
        for (place, u) in found {
            let Some(expected) = reference.get(place) else { continue };
            compared += 1;
            apart += (0..3).map(|c| (u[c] - expected[c]).powi(2)).sum::<f64>();
            size += expected.iter().map(|x| x * x).sum::<f64>();
        }
    }
    assert!(compared > 30_000, "{compared} displacements");
    (apart / size).sqrt()
}

/// A deck of a bar of bricks along x.
fn bricks() -> String {
    let mut text = String::from("*NODE\n");
    let number = |i: usize, j: usize, k: usize| 1 + i + 5 * j + 10 * k;
    for (i, j, k) in (0..5).flat_map(|i| (0..2).flat_map(move |j| (0..2).map(move |k| (i, j, k)))) {
        let [x, y, z] = [i as f64 * 0.1, j as f64 * 0.1, k as f64 * 0.1];
        writeln!(text, "{}, {x}, {y}, {z}", number(i, j, k)).expect("text");
    }
    text.push_str("*ELEMENT, TYPE=C3D8I, ELSET=body\n");
    for i in 0..4 {
        let face =
            |k: usize| [(i, 0), (i + 1, 0), (i + 1, 1), (i, 1)].map(|(i, j)| number(i, j, k).to_string());
        writeln!(text, "{}, {}, {}", i + 1, face(0).join(", "), face(1).join(", ")).expect("text");
    }
    text
}

#[test]
fn facets_of_bricks_stay_facets() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("bar.inp"), bricks()).expect("written");
    let port =
        |x: f64| format!("[[port]]\nname = \"end\"\non = {{ plane = {{ axis = \"x\", at = {x} }} }}\n");
    let mesh = "[mesh]\nfile = \"bar.inp\"\n";
    let support = "[[support]]\non = { plane = { axis = \"x\", at = 0.0 } }\n";
    let keys = keys(6);
    for (name, text) in
        [("a", format!("{mesh}{keys}{support}{}", port(0.4))), ("b", format!("{mesh}{keys}{}", port(0.0)))]
    {
        std::fs::write(folder.path().join(format!("{name}.vdm")), built(&text, folder.path()))
            .expect("written");
    }
    let text = format!(
        "format = 1\n[[part]]\nname = \"a\"\nfile = \"a.vdm\"\n[[part]]\nname = \"b\"\nfile = \"b.vdm\"\n\
         position = [0.4, 0.0, 0.0]\n{}",
        weld("b.end", "a.end")
    );
    let file = AssemblyFile::parse(&text, "bars.toml", folder.path().to_path_buf()).expect("an assembly");
    let joined = assemble(&file).expect("joined");
    vademecum_rewrite::check(&joined.bytes).expect("a sound file");
    // A force in the middle of a facet of either part acts on its four nodes.
    let file = File::parse(&joined.bytes).expect("a file");
    let surface = Surface::new(&file).expect("a surface");
    for x in [0.15, 0.65] {
        let place = surface.locate([x, 0.05, 0.1]).expect("a place").place;
        assert!(
            place.weights().len() == 4 && place.weights().iter().all(|w| (w - 0.25).abs() < 1e-12),
            "{x}"
        );
    }
}
