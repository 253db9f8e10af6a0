//! The header and the list of symbols are those of the sources, and a program in C gets the evaluator's bits.

use std::path::{Path, PathBuf};
use std::process::Command;

use vademecum_eval::format::File;
use vademecum_eval::{
    Body, BodyOptions, Field, Member, Nodes, Pose, Touching, World, WorldBuffers, WorldOptions,
};
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

/// Whether a tool is there; without it a check is skipped, except in CI.
fn there(tool: &str) -> bool {
    if Command::new(tool).arg("--version").output().is_ok_and(|ran| ran.status.success()) {
        return true;
    }
    assert!(std::env::var_os("CI").is_none(), "{tool} is missing; .ci/install installs it");
    eprintln!("skipped: no {tool}");
    false
}

/// Runs a program that must succeed, and returns what it says.
fn run(command: &mut Command) -> String {
    let ran = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let said = String::from_utf8_lossy(&ran.stdout).into_owned();
    assert!(ran.status.success(), "{command:?}\n{said}{}", String::from_utf8_lossy(&ran.stderr));
    said
}

/// Compiles a program against the static library.
fn compiled(compiler: &str, arguments: &[&str], source: &Path, folder: &Path) -> PathBuf {
    let program = folder.join("program");
    let mut command = Command::new(compiler);
    command.args(arguments).args(["-Wall", "-Wextra", "-pedantic", "-Werror", "-O2", "-g", "-I"]);
    command.arg(own("include")).arg(source).arg(libraries().join("libvademecum.a"));
    run(command.args(["-lm", "-lpthread", "-ldl", "-o"]).arg(&program));
    program
}

/// A body of `examples/beam.toml`, with some of its text replaced.
fn beam(folder: &Path, replaced: &[(&str, &str)]) -> PathBuf {
    let mut text = std::fs::read_to_string(repository().join("examples/beam.toml")).expect("a problem");
    for (from, to) in replaced {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    let (problem, file) = (folder.join("beam.toml"), folder.join("beam.vdm"));
    std::fs::write(&problem, text).expect("written");
    let [problem, path] = [&problem, &file].map(|path| path.display().to_string());
    let built = vademecum(&["build", &problem, "-o", &path]);
    assert_eq!(built.code, Some(0), "{}", built.stderr);
    file
}

/// A cube that falls, the block that it falls on, and a link with two ports, as
/// `docs/how-to/join-bodies.md` has them.
fn members_of_a_world(folder: &Path) -> [PathBuf; 3] {
    let page = std::fs::read_to_string(repository().join("docs/how-to/join-bodies.md")).expect("a page");
    ["cube", "base", "link"].map(|name| {
        let (_, text) = page.split_once(&format!("# {name}.toml\n")).expect("a problem");
        let (text, _) = text.split_once("```").expect("the end of it");
        let [problem, file] = ["toml", "vdm"].map(|kind| folder.join(format!("{name}.{kind}")));
        std::fs::write(&problem, text).expect("written");
        let [problem, path] = [&problem, &file].map(|path| path.display().to_string());
        let built = vademecum(&["build", &problem, "-o", &path]);
        assert_eq!(built.code, Some(0), "{}", built.stderr);
        file
    })
}

/// The names in the output of `nm`, sorted.
fn names(command: &mut Command) -> Vec<String> {
    let said = run(command.args(["--defined-only", "--extern-only"]));
    let names = said.lines().filter_map(|line| line.split_whitespace().nth(2));
    let mut names: Vec<String> = names.filter(|name| !name.starts_with("anon.")).map(String::from).collect();
    names.sort_unstable();
    names
}

#[test]
fn the_libraries_export_the_names_of_the_list_and_no_others() {
    if !there("nm") {
        return;
    }
    let listed = std::fs::read_to_string(own("symbols.txt")).expect("a list");
    assert!(
        listed.contains(&format!("VDM_ABI {}.", vademecum::VDM_ABI)),
        "symbols.txt is of another VDM_ABI"
    );
    let listed: Vec<&str> = listed.lines().filter(|line| !line.starts_with('#')).collect();
    assert!(listed.len() > 60);
    let shared = names(Command::new("nm").arg("-D").arg(libraries().join("libvademecum.so")));
    assert_eq!(shared, listed, "the dynamic library and symbols.txt");
    let mut kept = names(Command::new("nm").arg(libraries().join("libvademecum.a")));
    kept.retain(|name| name.starts_with("vdm_"));
    assert_eq!(kept, listed, "the static library and symbols.txt");
}

#[test]
fn every_call_does_what_the_header_says_under_sanitizers_and_valgrind() {
    let folder = tempfile::tempdir().expect("a folder");
    let exact = [("name = \"bathe\"", "name = \"exact\""), ("[snapshots]\npositions = 4\n", "")];
    let whole = ("[[output.probe]]", "[output]\nstatic_fields = true\n\n[[output.probe]]");
    let whole = beam(folder.path(), &[exact[0], exact[1], whole]);
    let golden = [
        "fixed-f64",
        "exact-f64",
        "parameters",
        "parametric",
        "reactions",
        "base",
        "stress",
        "free",
        "bent",
        "embedded",
    ];
    let mut files = golden.map(|name| repository().join(format!("fixtures/golden/{name}.vdm"))).to_vec();
    files.push(whole);
    let source = own("tests/everything.c");
    let sanitizers =
        ["-std=c99", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer"];
    let program = compiled("cc", &sanitizers, &source, folder.path());
    let mut covered = std::collections::BTreeSet::new();
    for file in &files {
        covered.extend(run(Command::new(&program).arg(file)).lines().map(String::from));
    }
    let parts = [
        "base",
        "batch",
        "body",
        "embedded",
        "fields",
        "flight",
        "held",
        "loads",
        "operator",
        "parameter",
        "pattern in flight",
        "patterns",
        "quantities",
        "reactions",
        "shape",
        "states",
        "statics",
        "stepped modes",
        "stress",
    ];
    assert_eq!(covered.iter().map(String::as_str).collect::<Vec<_>>(), parts, "what the files cover");

    let in_cpp = folder.path().join("everything.cpp");
    std::fs::copy(&source, &in_cpp).expect("a copy");
    let program = compiled("c++", &["-std=c++17"], &in_cpp, folder.path());
    if there("valgrind") {
        for file in &files[1..] {
            let mut valgrind = Command::new("valgrind");
            valgrind.args(["--quiet", "--error-exitcode=9", "--leak-check=full"]);
            run(valgrind.arg(&program).arg(file));
        }
    }
}

#[test]
fn every_function_of_the_header_of_cplusplus_runs_under_sanitizers_moved_bodies_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let header = std::fs::read_to_string(own("include/vademecum.hpp")).expect("a header");
    let source = std::fs::read_to_string(own("tests/capabilities.cpp")).expect("a program");
    let members = public_functions(&header);
    assert!(members.len() > 60, "{members:?}");
    let called = |name: &&String| source.contains(&format!("{name}("));
    assert_eq!(members.iter().filter(|name| !called(name)).collect::<Vec<_>>(), Vec::<&String>::new());

    let options = ["-std=c++17", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
    let program = compiled("c++", &options, &own("tests/capabilities.cpp"), folder.path());
    let golden = |name| repository().join(format!("fixtures/golden/{name}.vdm"));
    let exact = [("name = \"bathe\"", "name = \"exact\""), ("[snapshots]\npositions = 4\n", "")];
    let whole = ("[[output.probe]]", "[output]\nstatic_fields = true\n\n[[output.probe]]");
    let whole = beam(folder.path(), &[exact[0], exact[1], whole]);
    let files = ["stress", "reactions", "free", "parameters"].map(golden);
    let world = members_of_a_world(folder.path());
    run(Command::new(&program)
        .args(files)
        .arg(whole)
        .arg(golden("base"))
        .args(world)
        .arg(golden("parametric")));

    // Without exceptions it says so.
    let mut refused = Command::new("c++");
    refused.args(["-std=c++17", "-fno-exceptions", "-fsyntax-only", "-I"]).arg(own("include"));
    let ran = refused.arg(own("tests/capabilities.cpp")).output().expect("a compiler");
    assert!(String::from_utf8_lossy(&ran.stderr).contains("needs exceptions"), "{ran:?}");
}

/// Names of the public functions of the classes in a header of C++.
fn public_functions(header: &str) -> std::collections::BTreeSet<String> {
    let mut is_public = false;
    let mut names = std::collections::BTreeSet::new();
    for line in header.lines() {
        match line {
            "public:" => is_public = true,
            "private:" | "};" => is_public = false,
            _ => {}
        }
        let Some(line) = line.strip_prefix("    ").filter(|line| is_public && !line.starts_with([' ', '/']))
        else {
            continue;
        };
        let Some((before, _)) = line.split_once('(') else { continue };
        let name = before.rsplit(|c: char| !c.is_ascii_alphanumeric() && c != '_').next().unwrap_or_default();
        // Constructors and assignments have no names of their own.
        let is_plain = name.starts_with(|c: char| c.is_ascii_lowercase()) && !line.contains("operator");
        if is_plain {
            names.insert(name.to_string());
        }
    }
    names
}

#[test]
fn what_is_installed_serves_pkg_config_cmake_and_cplusplus() {
    let folder = tempfile::tempdir().expect("a folder");
    let [prefix, build] = ["prefix", "build"].map(|name| folder.path().join(name));
    let target = libraries().parent().expect("a target folder").to_path_buf();
    run(Command::new(own("install")).arg(&prefix).env("CARGO_TARGET_DIR", &target));
    let file = beam(folder.path(), &[]);
    let [c, cpp] = ["examples/haptic_loop.c", "examples/many_props.cpp"].map(own);
    let strict = ["-Wall", "-Wextra", "-pedantic", "-Werror", "-O2"];

    // The header of C++, with sanitizers, and the line of the page for C.
    let program = folder.path().join("program");
    let mut compiler = Command::new("c++");
    compiler.args(strict).args([
        "-std=c++17",
        "-fsanitize=address,undefined",
        "-fno-sanitize-recover=all",
        "-I",
    ]);
    compiler.arg(prefix.join("include")).arg(&cpp).arg(prefix.join("lib/libvademecum.a"));
    run(compiler.args(["-lm", "-lpthread", "-ldl", "-o"]).arg(&program));
    let props = run(Command::new(&program).arg(&file));
    assert!(props.contains("100 props move") && props.contains("refused: "), "{props}");

    let mut said = vec![];
    if there("pkg-config") {
        let mut asked = Command::new("pkg-config");
        asked.args(["--cflags", "--libs", "--static", "vademecum"]);
        let flags = run(asked.env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig")));
        let mut compiler = Command::new("cc");
        compiler.args(strict).arg("-std=c99").arg(&c).args(flags.split_whitespace()).arg("-o").arg(&program);
        run(&mut compiler);
        said.push(run(Command::new(&program).arg(&file).env("LD_LIBRARY_PATH", prefix.join("lib"))));
    }
    if there("cmake") {
        let project = format!(
            "cmake_minimum_required(VERSION 3.18)\nproject(use LANGUAGES C CXX)\nset(CMAKE_CXX_STANDARD 17)\n\
             find_package(vademecum 0.2 REQUIRED)\n\
             add_executable(installed {c})\ntarget_link_libraries(installed PRIVATE vademecum::vademecum)\n\
             add_executable(props {cpp})\ntarget_link_libraries(props PRIVATE vademecum::shared)\n\
             add_subdirectory({own} own)\n\
             add_executable(sources {c})\ntarget_link_libraries(sources PRIVATE vademecum)\n",
            c = c.display(),
            cpp = cpp.display(),
            own = own("").display(),
        );
        std::fs::write(folder.path().join("CMakeLists.txt"), project).expect("written");
        let mut configure = Command::new("cmake");
        configure.arg("-S").arg(folder.path()).arg("-B").arg(&build);
        configure.arg(format!("-DCMAKE_PREFIX_PATH={}", prefix.display()));
        run(configure.arg(format!("-DVADEMECUM_TARGET_DIR={}", target.display())));
        run(Command::new("cmake").arg("--build").arg(&build));
        said.extend(["installed", "sources"].map(|name| run(Command::new(build.join(name)).arg(&file))));
        assert_eq!(run(Command::new(build.join("props")).arg(&file)), props);
    }
    said.dedup();
    assert!(said.len() <= 1, "different numbers: {said:?}");
}

#[test]
fn a_haptic_loop_in_c_gets_the_bits_of_the_evaluator() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = beam(folder.path(), &[]);
    let program = compiled("cc", &["-std=c99"], &own("examples/haptic_loop.c"), folder.path());
    let said = run(Command::new(&program).arg(&file));

    // The same loop in Rust.
    let bytes = std::fs::read(&file).expect("a file");
    let file_read = File::parse(&bytes).expect("a vademecum");
    let options = BodyOptions::default();
    let mut memory = vec![0.0; Body::<f32>::len_for(&file_read, &options).expect("a length")];
    let mut body = Body::<f32>::bind(&file_read, &options, &mut memory).expect("a body");
    let place = body.locate([0.9, 0.05, 0.1]).expect("a place");
    for tick in 0..1000 {
        body.clear();
        let depth = 2e-3 * f64::from(tick) / 1000.0;
        let under = body.point(&place, Field::Displacement).expect("a point");
        body.push(&place, [0.0, 0.0, -2e3 * (depth + under[2])]).expect("a force");
        body.step().expect("a step");
    }
    let under = body.point(&place, Field::Displacement).expect("a point");
    let tip = body.probe(0, Field::Velocity).expect("a probe");
    let expected = format!("{:.17e} {tip:.17e}", under[2]);
    let numbers =
        |text: &str| text.split_whitespace().map(|x| x.parse().expect("a number")).collect::<Vec<f64>>();
    let line = said.lines().last().expect("a line");
    let bits = |text: &str| numbers(text).into_iter().map(f64::to_bits).collect::<Vec<_>>();
    assert_eq!(bits(line), bits(&expected), "{line} in C, {expected} in Rust");

    // No byte beyond what was lent, and none before it was written.
    if there("valgrind") {
        let mut valgrind = Command::new("valgrind");
        run(valgrind.args(["--quiet", "--error-exitcode=9", "--leak-check=full"]).arg(&program).arg(&file));
    }
}

#[test]
fn every_call_of_a_world_does_what_the_header_says_under_sanitizers_and_valgrind() {
    let folder = tempfile::tempdir().expect("a folder");
    let files = members_of_a_world(folder.path());
    let source = own("tests/world.c");
    let sanitizers =
        ["-std=c99", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer"];
    let program = compiled("cc", &sanitizers, &source, folder.path());
    run(Command::new(&program).args(&files));

    let in_cpp = folder.path().join("world.cpp");
    std::fs::copy(&source, &in_cpp).expect("a copy");
    let program = compiled("c++", &["-std=c++17"], &in_cpp, folder.path());
    run(Command::new(&program).args(&files));
    if there("valgrind") {
        let mut valgrind = Command::new("valgrind");
        valgrind.args(["--quiet", "--error-exitcode=9", "--leak-check=full"]);
        run(valgrind.arg(&program).args(&files));
    }
}

#[test]
fn two_bodies_that_touch_in_c_get_the_bits_of_the_evaluator() {
    let folder = tempfile::tempdir().expect("a folder");
    let [cube, base, _] = members_of_a_world(folder.path());
    let program = compiled("cc", &["-std=c99"], &own("examples/two_bodies.c"), folder.path());
    let said = run(Command::new(&program).args([&cube, &base]));

    // The same march in Rust.
    let bytes = [cube, base].map(|path| std::fs::read(path).expect("a file"));
    let files = bytes.each_ref().map(|bytes| File::parse(bytes).expect("a vademecum"));
    let mut options = BodyOptions::default();
    (options.scene.contacts, options.scene.time_step) = (128, Some(1e-3));
    let mut memory =
        files.each_ref().map(|file| vec![0.0; Body::<f32>::len_for(file, &options).expect("a length")]);
    let [of_cube, of_base] = &mut memory;
    let mut cube = Body::<f32>::bind(&files[0], &options, of_cube).expect("a body");
    let mut base = Body::<f32>::bind(&files[1], &options, of_base).expect("a body");
    let mut motion = *cube.motion().expect("a free body");
    motion.position = std::array::from_fn(|k| motion.position[k] + [0.04, 0.04, 0.085][k]);
    cube.set_motion(motion).expect("a motion");
    let pairs = [Touching { nodes: Nodes::First, ..Touching::new(0, 1) }];
    let pairs = pairs.map(|pair| pair.with_friction(0.5).with_restitution(0.5));
    let options = WorldOptions { gravity: [0.0, 0.0, -9.81], contacts: 128, ..WorldOptions::default() };
    let mut members = [Member::Free(&mut cube), Member::Held(&mut base, Pose::IDENTITY)];
    let sizes = World::sizes(&members, &[], &options).expect("sizes");
    let mut buffers = WorldBuffers::new(&sizes);
    let mut world = World::new(&members, &pairs, &[], &options, buffers.lend()).expect("a world");
    for _ in 0..500 {
        let report = world.step(&mut members).expect("a step");
        assert!(report.converged, "{report:?}");
    }
    let energy = world.energy(&members).expect("an energy");
    let Member::Free(cube) = &members[0] else { unreachable!("the cube") };
    let height = cube.motion().expect("a motion").position[2];
    let line = said.lines().last().expect("a line");
    let found: Vec<u64> =
        line.split_whitespace().map(|x| x.parse::<f64>().expect("a number").to_bits()).collect();
    assert_eq!(found, [height.to_bits(), energy.to_bits()], "{line} in C, {height:e} {energy:e} in Rust");
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
