//! Models from the matrices of another program: what `export matrices` writes is read back as the same model,
//! and a chain of masses, whose frequencies are known, runs the same road as a mesh.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use vademecum_build::dynamics::lowest_modes;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::prepared::{Prepared, prepare};
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_eval::{Contact, Field, Loads, Place, Scene, SceneOptions, State, Surface};
use vademecum_format::{File, SectionKind};
use vademecum_tests::program::{Ran, program, repository, vademecum};

/// The end of every problem here: a small basis of few runs, and a probe at the tip of the short beam.
const REST: &str = "[load]\n[time]\nscheme.name = \"bathe\"\nstep = 1e-3\n[snapshots]\npositions = 2\nduration = 0.1\n\
                    [basis]\nmodes = 4\n\
                    [[output.probe]]\nname = \"tip\"\npoint = [1.0, 0.1, 0.1]\ndirection = [0.0, 0.0, 1.0]\n";

/// The tables that `export matrices` writes.
const ALL: &str = "nodes = \"nodes.csv\"\ntriangles = \"triangles.csv\"\n";

/// A problem whose matrices lie in `folder`; `tables` are the optional ones.
fn of_matrices(folder: &Path, tables: &str, rest: &str) -> Problem {
    let head = "[mesh.matrices]\nmass = \"mass.mtx\"\nstiffness = \"stiffness.mtx\"\ndofs = \"dofs.csv\"\n";
    let text = format!("{head}{tables}{rest}");
    std::fs::write(folder.join("problem.toml"), &text).expect("written");
    Problem::read(&folder.join("problem.toml")).expect("a problem")
}

/// The short beam without its gravity.
fn of_mesh() -> Problem {
    let text =
        std::fs::read_to_string(repository().join("fixtures/problems/short-beam.toml")).expect("a fixture");
    let (head, tail) = text.split_once("[[load.pattern]]").expect("gravity");
    let (_, tail) = tail.split_once("[time]").expect("a time");
    Problem::parse(&format!("{head}[time]{tail}"), "short beam", repository()).expect("a problem")
}

fn prepared(problem: &Problem) -> Prepared {
    prepare(problem, &mut Stopwatch::new(&Silent), &Silent)
        .unwrap_or_else(|error| panic!("{}", chain(&error)))
}

/// An error with its causes.
fn chain(error: &dyn std::error::Error) -> String {
    let source = error.source().map_or(String::new(), |source| format!("; {}", chain(source)));
    format!("{error}{source}")
}

fn refused(problem: &Problem) -> String {
    match prepare(problem, &mut Stopwatch::new(&Silent), &Silent) {
        Ok(_) => panic!("these matrices are a model"),
        Err(error) => chain(&error),
    }
}

fn frequencies(problem: &Problem, count: usize) -> Vec<f64> {
    let prepared = prepared(problem);
    let modes = lowest_modes(prepared.body.model.pencil(), &prepared.symbolic, count).expect("modes");
    modes.frequencies_hz()
}

fn built(problem: &Problem) -> Vec<u8> {
    let outcome =
        build(problem, &BuildOptions::default(), &Silent).unwrap_or_else(|error| panic!("{}", chain(&error)));
    outcome.kept().expect("the tolerance is kept").bytes
}

fn export(folder: &Path) {
    let problem = repository().join("fixtures/problems/short-beam.toml");
    let scenario = repository().join("fixtures/scenarios/short-push.toml");
    let [problem, scenario, output] = [&*problem, &*scenario, folder].map(|p| p.to_str().expect("UTF-8"));
    let ran =
        vademecum(&["export", "matrices", problem, "--scenario", scenario, "--modes", "4", "-o", output]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
}

/// The probe `tip` over 200 steps, pushed for the first 50 where `contact` says.
fn trajectory(bytes: &[u8], contact: impl Fn(&File<'_>) -> Contact) -> Vec<f64> {
    let file = File::parse(bytes).expect("a file");
    let options = SceneOptions::default();
    let sizes = Scene::<f64>::sizes(&file, &options).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let (mut state_memory, mut load_memory) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let scene = Scene::bind(&file, &options, &mut memory, &mut work).expect("a scene");
    let mut state = State::new(&scene, &mut state_memory).expect("a state");
    let mut loads = Loads::new(&scene, &mut load_memory).expect("loads");
    loads.add_contact(&scene, &contact(&file)).expect("a contact");
    let mut step = |n: usize| {
        if n == 50 {
            loads.clear();
        }
        scene.step(&mut state, &loads).expect("a step");
        scene.probe(&state, 0, Field::Displacement).expect("a probe")
    };
    (0..200).map(&mut step).collect()
}

/// A push at a point of the surface.
fn push(file: &File<'_>) -> Contact {
    let point = Surface::new(file).expect("a surface").locate([0.93, 0.031, 0.1]).expect("loadable");
    Contact::new(point.place, [3.0, -8.0, -20.0])
}

/// Largest difference over the largest value.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    largest(&mut a.iter().zip(b).map(|(a, b)| (a - b).abs())) / largest(&mut b.iter().map(|b| b.abs()))
}

#[test]
fn exported_matrices_build_the_file_of_the_mesh() {
    let folder = tempfile::tempdir().expect("a folder");
    export(folder.path());
    let (from_matrices, from_mesh) = (of_matrices(folder.path(), ALL, REST), of_mesh());
    for (a, b) in frequencies(&from_matrices, 6).iter().zip(frequencies(&from_mesh, 6)) {
        assert!((a - b).abs() <= 1e-12 * b, "{a} and {b}");
    }
    let (a, b) = (built(&from_matrices), built(&from_mesh));
    let difference = distance(&trajectory(&a, push), &trajectory(&b, push));
    assert!(difference <= 1e-9, "{difference:e}");
    // The numbers are the same and are taken in the same order: so are their bits. Matrices have no mesh
    // whose error could be estimated.
    let (a, b) = (File::parse(&a).expect("a file"), File::parse(&b).expect("a file"));
    for section in b.sections().filter(|section| section.kind() != SectionKind::MeshError) {
        let kind = section.kind();
        assert_eq!(a.section(kind).map(|s| s.stored()), Some(section.stored()), "{kind:?}");
    }
}

/// Renames the rows of the exported matrices: all x dofs last to first, then y, then z; and writes both
/// triangles.
fn shuffle(folder: &Path) {
    let table = std::fs::read_to_string(folder.join("dofs.csv")).expect("dofs");
    let mut lines: Vec<&str> = table.lines().skip(1).collect();
    lines.reverse();
    lines.sort_by_key(|line| line.split(',').nth(2));
    let mut name = vec![0; lines.len()];
    let mut shuffled = String::from("row,node,component,x,y,z\n");
    for (new, line) in lines.iter().enumerate() {
        let (old, rest) = line.split_once(',').expect("cells");
        name[old.parse::<usize>().expect("a row")] = new;
        writeln!(shuffled, "{new},{rest}").expect("a string");
    }
    std::fs::write(folder.join("dofs.csv"), shuffled).expect("written");
    for file in ["mass.mtx", "stiffness.mtx"] {
        let text = std::fs::read_to_string(folder.join(file)).expect("a matrix");
        let mut entries = String::new();
        let mut count = 0;
        for line in text.lines().skip(2) {
            let [row, column, value] = line.split(' ').collect::<Vec<_>>()[..] else { panic!("{line}") };
            let [i, j] = [row, column].map(|word| 1 + name[word.parse::<usize>().expect("an index") - 1]);
            writeln!(entries, "{i} {j} {value}").expect("a string");
            count += 1;
            if i != j {
                writeln!(entries, "{j} {i} {value}").expect("a string");
                count += 1;
            }
        }
        let n = name.len();
        let head = format!("%%MatrixMarket matrix coordinate real general\n% shuffled\n{n} {n} {count}\n");
        std::fs::write(folder.join(file), head + &entries).expect("written");
    }
}

#[test]
fn the_order_of_the_rows_does_not_matter() {
    let folder = tempfile::tempdir().expect("a folder");
    export(folder.path());
    let straight = built(&of_matrices(folder.path(), ALL, REST));
    shuffle(folder.path());
    let shuffled = built(&of_matrices(folder.path(), ALL, REST));
    assert!(trajectory(&straight, push) == trajectory(&shuffled, push), "the same model, to the bit");
}

#[test]
fn verify_marches_the_matrices_full_order() {
    let folder = tempfile::tempdir().expect("a folder");
    export(folder.path());
    let path = |name: &str| folder.path().join(name).display().to_string();
    let scenario = |text: &str| std::fs::write(path("s.toml"), text).expect("written");
    let verified = || {
        let file = path("beam.vdm");
        let ran = vademecum(&["build", &path("problem.toml"), "-o", &file]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        vademecum(&[
            "verify",
            &file,
            "--problem",
            &path("problem.toml"),
            "--scenario",
            &path("s.toml"),
            "--json",
        ])
    };
    let gravity = "[[load.pattern]]\nname = \"gravity\"\nacceleration = [0.0, 0.0, -9.81]\n";
    let rest = REST.replace("[load]\n", &format!("[load]\n{gravity}"));
    // The tolerance of the problem: 1.1 times what the basis allows.
    let keeps = |ran: vademecum_tests::program::Ran| {
        let report = ran.json();
        assert_eq!(report["dofs"], 324);
        let ratio = report["floor_ratio"].as_f64().expect("a number");
        assert!(ratio <= 1.1, "{report}");
    };
    of_matrices(folder.path(), ALL, &rest);
    scenario(
        "duration = 0.2\n[[contact]]\npoint = [0.93, 0.031, 0.1]\nforce = [3.0, -8.0, -20.0]\nend = 0.05\n",
    );
    keeps(verified());
    // Without triangles, patterns act and contacts are refused.
    of_matrices(folder.path(), "", &rest);
    verified().fails(7, &["no loadable surface"]);
    scenario("duration = 0.2\n[[pattern]]\nname = \"gravity\"\namplitude = 1.0\nend = 0.05\n");
    keeps(verified());
}

/// `count` masses of `mass` in a row along x, each held to the next (and the ends to walls) by a spring; only
/// x is free.
struct Chain {
    count: usize,
    mass: f64,
    spring: f64,
}

impl Chain {
    fn write(&self, folder: &Path) {
        let n = self.count;
        let head = "%%MatrixMarket matrix coordinate real symmetric\n";
        let mut mass = format!("{head}{n} {n} {n}\n");
        let mut stiffness = format!("{head}{n} {n} {}\n", 2 * n - 1);
        let mut dofs = String::from("row,node,component,x,y,z\n");
        for i in 1..=n {
            writeln!(mass, "{i} {i} {}", self.mass).expect("a string");
            writeln!(stiffness, "{i} {i} {}", 2.0 * self.spring).expect("a string");
            if i < n {
                writeln!(stiffness, "{} {i} {}", i + 1, -self.spring).expect("a string");
            }
            writeln!(dofs, "{},{i},x,{i},0,0", i - 1).expect("a string");
        }
        for (name, text) in [("mass.mtx", mass), ("stiffness.mtx", stiffness), ("dofs.csv", dofs)] {
            std::fs::write(folder.join(name), text).expect("written");
        }
    }

    /// `ω_j = 2 √(k/m) sin(j π / 2(n + 1))`, Hz.
    fn frequency(&self, j: usize) -> f64 {
        let angle = j as f64 * std::f64::consts::PI / (2.0 * (self.count as f64 + 1.0));
        2.0 * (self.spring / self.mass).sqrt() * angle.sin() / std::f64::consts::TAU
    }

    /// Displacement of mass `i` (from 1) under an equal force on every mass: `F i (n + 1 − i) / 2k`.
    fn sag(&self, i: usize, force: f64) -> f64 {
        force * (i * (self.count + 1 - i)) as f64 / (2.0 * self.spring)
    }
}

const CHAIN: Chain = Chain { count: 300, mass: 0.5, spring: 2e6 };

/// What a problem of the chain needs beside its matrices.
const CHAIN_REST: &str = "[load]\n[time]\nscheme.name = \"bathe\"\nstep = 2e-3\n[snapshots]\npositions = 3\n\
                          directions = [[1.0, 0.0, 0.0]]\n[basis]\nmodes = 6\n[tolerance]\nsteps = 100\nerror = 0.9\n";

#[test]
fn a_chain_has_the_frequencies_of_the_textbook() {
    let folder = tempfile::tempdir().expect("a folder");
    CHAIN.write(folder.path());
    for (j, found) in (1..).zip(frequencies(&of_matrices(folder.path(), "", CHAIN_REST), 5)) {
        // The solver's residual bounds the relative error by 5e-9; its square is what is reached.
        assert!((found / CHAIN.frequency(j) - 1.0).abs() <= 1e-10, "mode {j}: {found}");
    }
    // A build says the lowest six, so that a wrong unit or format is seen.
    let path = |name: &str| folder.path().join(name).display().to_string();
    let build = ["build", &path("problem.toml"), "-o", &path("chain.vdm")];
    let ran = Ran::new(&Command::new(program()).args(build).output().expect("the program starts"));
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let hertz: Vec<String> = (1..=6).map(|j| format!("{:.6e}", CHAIN.frequency(j))).collect();
    let note = format!("the lowest natural frequencies of these matrices: {} Hz", hertz.join(", "));
    let words = ran.stderr.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains(&note), "{note}: {words}");
}

#[test]
fn an_acceleration_of_lumped_masses_is_exact() {
    let folder = tempfile::tempdir().expect("a folder");
    CHAIN.write(folder.path());
    let pattern = "[load]\n[[load.pattern]]\nname = \"pull\"\nacceleration = [9.81, 1.0, 2.0]\n";
    let problem = of_matrices(folder.path(), "", &CHAIN_REST.replace("[load]\n", pattern));
    let prepared = prepared(&problem);
    let body = &prepared.body;
    let (name, force) = &body.patterns[0];
    assert_eq!((name.as_str(), force), ("pull", &vec![9.81 * CHAIN.mass; CHAIN.count]));
    // K times the sag of the textbook is that force.
    let sag = vademecum_build::Matrix::from_fn(CHAIN.count, 1, |i, _| CHAIN.sag(i + 1, 9.81 * CHAIN.mass));
    let mut image = vademecum_build::Matrix::zeros(CHAIN.count, 1);
    body.model.pencil().stiffness().mul_into(sag.as_ref(), image.as_mut());
    let worst = (0..CHAIN.count).map(|i| (image[(i, 0)] - force[i]).abs()).fold(0.0, f64::max);
    // Each row subtracts numbers of the size of 2 k times the largest sag.
    assert!(worst <= 8.0 * f64::EPSILON * CHAIN.spring * CHAIN.sag(150, force[0]), "{worst:e}");
}

#[test]
fn without_triangles_forces_act_on_chosen_nodes() {
    let folder = tempfile::tempdir().expect("a folder");
    CHAIN.write(folder.path());
    let chosen = CHAIN_REST.replace("[load]\n", "[load]\nsurface = { nodes = [150, 299] }\n")
        + "[[output.probe]]\nname = \"middle\"\npoint = [150.0, 0.0, 0.0]\ndirection = [1.0, 0.0, 0.0]\n";
    let bytes = built(&of_matrices(folder.path(), "", &chosen));
    let file = File::parse(&bytes).expect("a file");
    let metadata = file.metadata();
    assert_eq!((metadata.n_nodes, metadata.n_load_nodes, metadata.n_triangles), (300, 2, 0));
    let ids = file.section(SectionKind::NodeIds).expect("ids").u64s().expect("ids");
    let mut loadable = [0, 1].map(|place: usize| u64::from_le_bytes(ids[place]));
    loadable.sort_unstable();
    assert_eq!(loadable, [150, 299]);
    assert!(Surface::new(&file).expect("a surface").locate([150.0, 0.0, 0.0]).is_none());
    let at = (0..2).find(|&place| u64::from_le_bytes(ids[place as usize]) == 150).expect("node 150");
    let pull = |_: &File<'_>| Contact::new(Place::triangle([at; 3], [1.0, 0.0, 0.0]), [10.0, 0.0, 0.0]);
    let moved = trajectory(&bytes, pull).into_iter().fold(0.0, f64::max);
    assert!(moved > 0.0);
}

#[test]
fn every_uniform_parameter_is_live() {
    let folder = tempfile::tempdir().expect("a folder");
    CHAIN.write(folder.path());
    let live = "[damping]\nalpha = 0.1\nbeta = 1e-4\n\
                [[parameter]]\nname = \"stiffness\"\nkind = \"stiffness\"\nregion = \"body\"\n\
                range = [0.5, 2.0]\n\
                [[parameter]]\nname = \"density\"\nkind = \"density\"\nrange = [0.5, 2.0]\n\
                [[parameter]]\nname = \"alpha\"\nkind = \"alpha\"\nrange = [0.0, 1.0]\n\
                [[parameter]]\nname = \"beta\"\nkind = \"beta\"\nrange = [0.0, 1e-3]\n\
                [[parameter]]\nname = \"step\"\nkind = \"time-step\"\nrange = [1e-3, 4e-3]\n";
    let bytes = built(&of_matrices(folder.path(), "", &format!("{CHAIN_REST}{live}")));
    let metadata = *File::parse(&bytes).expect("a file").metadata();
    assert_eq!((metadata.n_parameters, metadata.n_regions), (5, 1));
}

#[test]
fn matrices_that_are_not_positive_definite_are_refused_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let problem = || of_matrices(folder.path(), "", CHAIN_REST);
    let change = |file: &str, from: &str, to: &str| {
        CHAIN.write(folder.path());
        let text = std::fs::read_to_string(folder.path().join(file)).expect("a file");
        assert!(text.contains(from));
        std::fs::write(folder.path().join(file), text.replacen(from, to, 1)).expect("written");
    };
    // Lumped and consistent masses are judged apart.
    change("mass.mtx", "300 300 300\n", "300 300 301\n2 1 0.5\n");
    assert!(refused(&problem()).contains("`mesh.matrices.mass`"));
    change("mass.mtx", "\n7 7 0.5\n", "\n7 7 0\n");
    assert!(refused(&problem()).contains("`mesh.matrices.mass`"));
    let ran = vademecum(&["modes".into(), folder.path().join("problem.toml")]);
    ran.fails(5, &["`mesh.matrices.mass`", "not positive definite"]);
    change("stiffness.mtx", "\n7 7 4000000\n", "\n7 7 -4000000\n");
    assert!(refused(&problem()).contains("`mesh.matrices.stiffness`"));
}

#[test]
fn files_that_contradict_each_other_are_refused_by_file_and_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let chain = Chain { count: 3, mass: 1.0, spring: 1.0 };
    let cases = [
        ("dofs.csv", "2,3,x,3,0,0", "3,3,x,3,0,0", "dofs.csv, line 4, in the table: found row 3"),
        ("dofs.csv", "2,3,x,3,0,0", "1,3,x,3,0,0", "dofs.csv, line 4, in the table: found row 1"),
        (
            "dofs.csv",
            "2,3,x,3,0,0",
            "2,2,x,2,0,0",
            "dofs.csv, line 4, in the table: found component x of node 2",
        ),
        (
            "dofs.csv",
            "2,3,x,3,0,0",
            "2,2,y,3,0,0",
            "dofs.csv, line 4, in the table: found node 2 at [3.0, 0.0, 0.0]",
        ),
        (
            "dofs.csv",
            "2,3,x,3,0,0",
            "2,8,x,3,0,0",
            "dofs.csv, line 4, in the table: found node 8, expected a node of",
        ),
        ("dofs.csv", "2,3,x,3,0,0\n", "", "mass.mtx: 3 rows; expected 2, as"),
        (
            "stiffness.mtx",
            "3 3 5",
            "3 3 6",
            "stiffness.mtx, line 7, in the entries: found the end of the file",
        ),
        ("nodes.csv", "3,3,0,0", "2,3,0,0", "nodes.csv, line 4, in the table: found node 2 a second time"),
        (
            "nodes.csv",
            "3,3,0,0",
            "3,3,1,0",
            "dofs.csv, line 4, in the table: found node 3 at [3.0, 0.0, 0.0]",
        ),
        ("triangles.csv", "1 2 3", "1 2 9", "triangles.csv, line 1, in the table: found node 9"),
        ("triangles.csv", "1 2 3", "1 1 3", "triangles.csv, line 1, in the table: found `1 1 3`"),
    ];
    let whole = || {
        chain.write(folder.path());
        std::fs::write(folder.path().join("nodes.csv"), "node,x,y,z\n1,1,0,0\n2,2,0,0\n3,3,0,0\n4,4,0,0\n")
            .expect("written");
        std::fs::write(folder.path().join("triangles.csv"), "1 2 3\n").expect("written");
    };
    let problem = of_matrices(folder.path(), ALL, CHAIN_REST);
    whole();
    assert_eq!(prepared(&problem).body.loadable, [[0, 1, 2]]);
    for (file, from, to, said) in cases {
        whole();
        let path = folder.path().join(file);
        let text = std::fs::read_to_string(&path).expect("a file");
        assert!(text.contains(from), "{text}");
        std::fs::write(&path, text.replacen(from, to, 1)).expect("written");
        let error = refused(&problem);
        assert!(error.contains(said), "{error}");
    }
    whole();
    std::fs::remove_file(folder.path().join("mass.mtx")).expect("removed");
    assert!(refused(&problem).contains("mass.mtx: cannot be read"));
    let held = CHAIN_REST.replace("[load]\n", "[load]\nsurface = { nodes = [4] }\n");
    whole();
    assert!(
        refused(&of_matrices(folder.path(), "nodes = \"nodes.csv\"\n", &held))
            .contains("no node with a free")
    );
    assert!(refused(&of_matrices(folder.path(), ALL, &held)).contains("no whole facet"));
}
