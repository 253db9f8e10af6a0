//! Every problem file of the repository is built by the gate, here or in another step of it; those that take
//! more than a minute, or whose meshes are not in the repository, are read. Examples on pages are read, too.

use std::path::{Path, PathBuf};
use std::process::Command;

use vademecum_assembly::AssemblyFile;
use vademecum_build::input::Problem;
use vademecum_study::scenario::Scenario;
use vademecum_study::sweep::Sweep;
use vademecum_tests::program::{repository, vademecum};

/// Built by [`problems_build`].
const HERE: [&str; 7] = [
    "docs/gallery/bracket.toml",
    "docs/gallery/bolted.toml",
    "docs/gallery/glass.toml",
    "examples/beam.toml",
    "fixtures/problems/canonical-beam.toml",
    "fixtures/problems/free-plate.toml",
    "fixtures/problems/two-materials.toml",
];

/// Files, or all of a folder, and the step of the gate that builds them.
const ELSEWHERE: [(&str, &str); 27] = [
    ("bodies/", "bodies/make"),
    ("crates/vademecum-cli/assets/", "links to fixtures"),
    ("crates/vademecum-fmu/tests/", "crates/vademecum-fmu/check"),
    ("docs/gallery/bar.toml", "the test `tutorial`"),
    ("docs/gallery/brick.toml", "the test `tutorial`"),
    ("docs/gallery/bridge.toml", "the test `tutorial`"),
    ("docs/gallery/finger.toml", "the test `tutorial`"),
    ("docs/gallery/hammer.toml", "the test `tutorial`"),
    ("docs/gallery/jelly.toml", "the test `tutorial`"),
    ("docs/gallery/link.toml", "the test `tutorial`"),
    ("docs/gallery/mallet.toml", "the test `tutorial`"),
    ("docs/gallery/organ.toml", "the test `tutorial`"),
    ("docs/gallery/storey", "the test `tutorial`"),
    ("docs/tutorials/tuning-fork/", "the test `tutorial`"),
    ("examples/firmware/", "examples/firmware/check"),
    ("examples/mujoco/", "examples/mujoco/check"),
    ("examples/rapier/", "examples/rapier/check"),
    ("examples/sweep/", "examples/sweep/check"),
    ("packages/vademecum-eval/test/", "packages/vademecum-eval/check"),
    ("fixtures/problems/cantilever.toml", "the test `page_commands`"),
    ("fixtures/problems/cube.toml", "the test `sweep`"),
    ("fixtures/problems/short-beam.toml", "the test `commands`"),
    ("tests/browser/", "tests/browser/check"),
    ("tests/fuzz/corpus/", "tests/fuzz/run: some are no problems"),
    ("tests/reader/bodies/", "tests/reader/check"),
    ("tests/reader/joined/", "tests/reader/check"),
    ("tests/multibody/", "tests/multibody/check"),
];

/// Files that are read only, and the reason.
const READ: [(&str, &str); 9] = [
    ("fixtures/problems/beam-30k.toml", "more than a minute"),
    ("fixtures/problems/bending-beam.toml", "more than a minute"),
    ("fixtures/problems/block-210k.toml", "more than a minute"),
    ("fixtures/problems/four-materials.toml", "more than a minute; `parameters` builds a coarse one"),
    ("fixtures/problems/liver", "the mesh is not in the repository"),
    ("fixtures/problems/sixteen-regions.toml", "more than a minute"),
    ("fixtures/problems/two-materials-separated.toml", "more than a minute"),
    ("tests/witnesses/beam", "the mesh is made by `witness`"),
    ("tests/witnesses/", "the mesh is made by `witness`; `engineering` builds them"),
];

/// All files with an extension below a folder, relative to the repository, without what is not part of it.
fn files(folder: &Path, extension: &str, found: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        if path.is_dir() && !name.starts_with('.') && !["target", "node_modules"].contains(&name.as_str()) {
            files(&path, extension, found);
        } else if path.extension().is_some_and(|other| other == extension) {
            let path = path.strip_prefix(repository()).expect("a file of the repository");
            found.push(path.to_string_lossy().into_owned());
        }
    }
}

#[test]
fn every_problem_file_is_built_somewhere_or_read() {
    let mut found = vec![];
    files(&repository(), "toml", &mut found);
    found.sort();
    let mut idle: Vec<&str> = HERE.to_vec();
    idle.extend(ELSEWHERE.iter().chain(&READ).map(|(path, _)| *path));
    for file in found {
        let path = repository().join(&file);
        let text = std::fs::read_to_string(&path).expect("a text");
        if !text.parse::<toml::Table>().is_ok_and(|table| table.contains_key("mesh")) {
            continue;
        }
        let places: Vec<&str> = HERE
            .into_iter()
            .chain(ELSEWHERE.iter().chain(&READ).map(|(path, _)| *path))
            .filter(|place| file.starts_with(place))
            .collect();
        assert!(
            !places.is_empty(),
            "{file} is built by nobody: add it to `HERE` if it takes less than a minute"
        );
        idle.retain(|place| !places.contains(place));
        if !file.starts_with("tests/fuzz/corpus/") {
            Problem::read(&path).unwrap_or_else(|error| panic!("{file}: {error}"));
        }
    }
    assert!(idle.is_empty(), "no problem file is at {idle:?}");
}

#[test]
fn problems_build() {
    let gmsh = Command::new(repository().join("tests/scripts/gmsh")).output().expect("a script");
    let gmsh = gmsh.status.success().then(|| String::from_utf8_lossy(&gmsh.stdout).trim().to_string());
    let folder = tempfile::tempdir().expect("a folder");
    let readme = std::fs::read_to_string(repository().join("README.md")).expect("a page");
    let example = readme.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next());
    std::fs::write(folder.path().join("readme.toml"), example.expect("an example")).expect("written");
    let mut problems = vec![folder.path().join("readme.toml")];
    for file in HERE {
        let source = repository().join(file);
        let problem = folder.path().join(source.file_name().expect("a name"));
        std::fs::copy(&source, &problem).expect("a copy");
        let geometry = source.with_extension("geo");
        if geometry.is_file() {
            let Some(gmsh) = &gmsh else { continue };
            let mut command = Command::new(gmsh);
            command.args(["-v", "2", "-3"]).arg(&geometry).arg("-o").arg(problem.with_extension("msh"));
            let meshed = command.status();
            assert!(meshed.expect("Gmsh").success(), "{file}");
        }
        // The mesh of another problem here, which needs Gmsh too.
        let text = std::fs::read_to_string(&problem).expect("a problem");
        let mesh = text.lines().find_map(|line| line.strip_prefix("file = \"")?.strip_suffix('"'));
        if gmsh.is_none() && mesh.is_some_and(|mesh| mesh.ends_with(".msh")) {
            continue;
        }
        problems.push(problem);
    }
    for problem in problems {
        let built = |path: PathBuf| path.with_extension("vdm").display().to_string();
        let ran = vademecum(&["build", &problem.display().to_string(), "-o", &built(problem.clone())]);
        assert_eq!(ran.code, Some(0), "{}: {}", problem.display(), ran.stderr);
    }
}

/// Tables that a problem of elements on supports must have.
const REQUIRED: [(&str, &str); 3] = [
    ("[mesh", "[mesh]\nblock = { lengths = [1.0, 0.1, 0.1], divisions = [10, 1, 1] }\n"),
    ("[[material", "[[material]]\nyoung = 2.1e9\npoisson = 0.3\ndensity = 1200.0\n"),
    ("[[support]]", "[[support]]\non = { group = \"x_min\" }\n"),
];

/// Keys on a page, such as those of a manifest, that belong to another program.
const FOREIGN: [&str; 2] = ["[dependencies]", "vademecum-eval ="];

#[test]
fn examples_on_pages_are_problems_scenarios_or_sweeps() {
    let folder = tempfile::tempdir().expect("a folder");
    let sweep = folder.path().join("sweep.toml");
    let mut pages = vec!["README.md".to_string()];
    files(&repository().join("docs"), "md", &mut pages);
    let mut read = 0;
    for page in pages {
        let text = std::fs::read_to_string(repository().join(&page)).expect("a page");
        for block in text.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next()) {
            // A table beside the page: `page_commands` runs that scenario.
            if FOREIGN.iter().any(|key| block.starts_with(key)) || block.contains("\nrecord = ") {
                continue;
            }
            let table: toml::Table = block.parse().unwrap_or_else(|error| panic!("{page}: {error}\n{block}"));
            let fault = if table.contains_key("problems") {
                std::fs::write(&sweep, block).expect("written");
                Sweep::read(&sweep).err().map(|error| error.to_string())
            } else if table.contains_key("part") {
                AssemblyFile::parse(block, &page, PathBuf::new()).err().map(|error| error.to_string())
            } else if table.contains_key("duration") || table.contains_key("contact") {
                Scenario::parse(block, &page).err().map(|error| error.to_string())
            } else {
                // A part of a problem has what it needs behind it: keys before the first table stay first.
                // Matrices of another program have materials and supports in them.
                let has = |mark: &str| block.contains(mark) || block.contains("[mesh.matrices]");
                let missing = REQUIRED.iter().filter(|(mark, _)| !has(mark));
                let whole: String = std::iter::once(block).chain(missing.map(|(_, table)| *table)).collect();
                Problem::parse(&whole, &page, PathBuf::new()).err().map(|error| error.to_string())
            };
            assert_eq!(fault, None, "{page}\n{block}");
            read += 1;
        }
    }
    assert!(read > 12, "{read} examples");
}
