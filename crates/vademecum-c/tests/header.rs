//! The header and the list of symbols are those of the sources, and a program in C gets the evaluator's bits.

use std::path::{Path, PathBuf};
use std::process::Command;

use vademecum_eval::format::File;
use vademecum_eval::{Contact, Field, Loads, Scene, SceneOptions, State, Surface};
use vademecum_tests::program::{repository, vademecum};

fn own(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The header as the sources have it.
fn header() -> String {
    let config = cbindgen::Config::from_file(own("cbindgen.toml")).expect("a configuration");
    let made =
        cbindgen::Builder::new().with_crate(own(".")).with_config(config).generate().expect("a header");
    let mut bytes = vec![];
    made.write(&mut bytes);
    String::from_utf8(bytes).expect("UTF-8")
}

#[test]
fn the_header_is_the_one_of_the_sources() {
    let path = own("include/vademecum.h");
    let made = header();
    if std::env::var_os("VADEMECUM_WRITE_HEADER").is_some() {
        std::fs::write(&path, &made).expect("written");
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        found == made,
        "include/vademecum.h is not that of the sources; make it with \
         VADEMECUM_WRITE_HEADER=1 cargo test -p vademecum-c --test header"
    );
    // What a library exports for this version of the interface; a change of it is a new version.
    let mut names: Vec<&str> =
        made.split(['(', ' ', '*', '\n']).filter(|word| word.starts_with("vdm_")).collect();
    names.retain(|name| name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_'));
    names.sort_unstable();
    names.dedup();
    let listed = std::fs::read_to_string(own("symbols.txt")).expect("a list");
    let listed: Vec<&str> = listed.lines().filter(|line| !line.starts_with('#')).collect();
    let exported: Vec<&&str> = names.iter().filter(|name| made.contains(&format!("{name}("))).collect();
    assert_eq!(exported.iter().map(|name| **name).collect::<Vec<_>>(), listed);
}

/// Where cargo put the libraries of this crate.
fn libraries() -> PathBuf {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["build", "--quiet", "--package", "vademecum-c", "--lib"]).current_dir(repository());
    if !cfg!(debug_assertions) {
        cargo.arg("--release");
    }
    assert!(cargo.status().expect("cargo").success(), "the library does not build");
    let running = std::env::current_exe().expect("the test's own path");
    running.ancestors().nth(2).expect("a profile folder").to_path_buf()
}

/// Compiles a program against the static library.
fn compiled(compiler: &str, arguments: &[&str], source: &Path, folder: &Path) -> PathBuf {
    let program = folder.join("program");
    let mut command = Command::new(compiler);
    command.args(arguments).args(["-Wall", "-Wextra", "-pedantic", "-Werror", "-O2", "-g", "-I"]);
    command.arg(own("include")).arg(source).arg(libraries().join("libvademecum.a"));
    command.args(["-lm", "-lpthread", "-ldl", "-o"]).arg(&program);
    let ran = command.output().expect("a compiler");
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    program
}

#[test]
fn a_haptic_loop_in_c_gets_the_bits_of_the_evaluator() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("beam.vdm");
    let problem = repository().join("examples/beam.toml").display().to_string();
    let built = vademecum(&["build", &problem, "-o", &file.display().to_string()]);
    assert_eq!(built.code, Some(0), "{}", built.stderr);
    let program = compiled("cc", &["-std=c99"], &own("examples/haptic_loop.c"), folder.path());
    let ran = Command::new(&program).arg(&file).output().expect("the program");
    let said = String::from_utf8_lossy(&ran.stdout);
    assert!(ran.status.success(), "{said}{}", String::from_utf8_lossy(&ran.stderr));

    // The same loop in Rust.
    let bytes = std::fs::read(&file).expect("a file");
    let file_read = File::parse(&bytes).expect("a vademecum");
    let options = SceneOptions::default();
    let sizes = Scene::<f32>::sizes(&file_read, &options).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let (mut a, mut b) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let scene = Scene::<f32>::bind(&file_read, &options, &mut memory, &mut work).expect("a scene");
    let mut state = State::new(&scene, &mut a).expect("a state");
    let mut loads = Loads::new(&scene, &mut b).expect("loads");
    let place = Surface::new(&file_read).expect("a surface").locate([0.9, 0.05, 0.1]).expect("a place");
    for tick in 0..1000 {
        loads.clear();
        let depth = 2e-3 * f64::from(tick) / 1000.0;
        let under = scene.point(&state, &place, Field::Displacement).expect("a point");
        let force = [0.0, 0.0, -2e3 * (depth + under[2])];
        let contact = Contact { nodes: place.nodes, weights: place.weights, force };
        loads.add_contact(&scene, &contact).expect("a contact");
        scene.step(&mut state, &loads).expect("a step");
    }
    let under = scene.point(&state, &place, Field::Displacement).expect("a point");
    let tip = scene.probe(&state, 0, Field::Velocity).expect("a probe");
    let expected = format!("{:.17e} {tip:.17e}", under[2]);
    let numbers =
        |text: &str| text.split_whitespace().map(|x| x.parse().expect("a number")).collect::<Vec<f64>>();
    let line = said.lines().last().expect("a line");
    let bits = |text: &str| numbers(text).into_iter().map(f64::to_bits).collect::<Vec<_>>();
    assert_eq!(bits(line), bits(&expected), "{line} in C, {expected} in Rust");

    // No byte beyond what was lent, and none before it was written.
    if Command::new("valgrind").arg("--version").output().is_ok_and(|ran| ran.status.success()) {
        let mut valgrind = Command::new("valgrind");
        valgrind.args(["--quiet", "--error-exitcode=9", "--leak-check=full"]).arg(&program).arg(&file);
        let ran = valgrind.output().expect("valgrind");
        assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    } else {
        eprintln!("skipped: no valgrind");
    }
}

#[test]
fn refusals_are_codes_with_words_and_the_header_is_cplusplus_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let golden = repository().join("fixtures/golden/fixed-f64.vdm");
    for (compiler, standard, name) in
        [("cc", "-std=c99", "refusals.c"), ("c++", "-std=c++17", "refusals.cpp")]
    {
        let source = folder.path().join(name);
        std::fs::copy(own("tests/refusals.c"), &source).expect("a copy");
        let program = compiled(compiler, &[standard], &source, folder.path());
        let ran = Command::new(&program).arg(&golden).output().expect("the program");
        assert!(ran.status.success(), "{name}: {}", String::from_utf8_lossy(&ran.stderr));
    }
}
