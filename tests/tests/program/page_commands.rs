//! Commands of README and of the how-to pages, run as a reader runs them: in a folder of their own, one after
//! the other, with the files that the page shows. Commands of the tutorial run in `tutorial`; those of all
//! other pages are parsed in the crate of the program.

use std::path::Path;
use std::process::Command;

use vademecum_tests::program::{program, repository};

/// A page, the commands of it that are left out by their first words, each with its reason, and what must be
/// in the folder beside the files that the page shows: name and source in the repository.
struct Page {
    path: &'static str,
    left_out: &'static [(&'static str, &'static str)],
    given: &'static [(&'static str, &'static str)],
}

/// In this order: later pages use the beam of the first.
const PAGES: [Page; 12] = [
    Page {
        path: "README.md",
        left_out: &[
            ("cargo", "installs or tests; steps of the gate"),
            ("vademecum init YOUR.msh --view", "serves until it is stopped; a test of `init` runs it"),
            ("vademecum view beam.vdm  ", "serves until it is stopped"),
            ("vademecum view demo/touch.vdm", "serves until it is stopped"),
        ],
        given: &[("YOUR.msh", "fixtures/meshes/bar/gmsh41.msh")],
    },
    Page {
        path: "docs/how-to/frequency-response.md",
        left_out: &[("vademecum frf damped.vdm", "fifty solves at full order; a test of `frf` runs fewer")],
        given: &[],
    },
    Page {
        path: "docs/how-to/state-space.md",
        left_out: &[("cargo", "a test of the workspace"), ("crates/", "the check of the Python package")],
        given: &[],
    },
    // Of the arm of the page before.
    Page { path: "docs/how-to/modal-test.md", left_out: &[("cargo", "a test of the workspace")], given: &[] },
    Page { path: "docs/how-to/calibrate.md", left_out: &[], given: &[] },
    Page { path: "docs/how-to/craig-bampton.md", left_out: &[], given: &[] },
    Page { path: "docs/how-to/mesh-error.md", left_out: &[], given: &[] },
    Page {
        path: "docs/how-to/moving-base.md",
        left_out: &[("cargo", "an example and a test of the workspace")],
        given: &[],
    },
    Page {
        path: "docs/how-to/own-matrices.md",
        left_out: &[("cargo", "an example of the workspace")],
        given: &[],
    },
    Page { path: "docs/how-to/reactions.md", left_out: &[("cargo", "a test of the workspace")], given: &[] },
    Page {
        path: "docs/how-to/stress.md",
        left_out: &[
            ("cargo", "a test of the workspace"),
            ("vademecum verify BODY.vdm", "of bodies of one's own"),
        ],
        given: &[],
    },
    // The body of this page is any, that of the page before among them.
    Page { path: "docs/how-to/fmu.md", left_out: &[], given: &[] },
];

/// The texts of the blocks of a kind on a page.
fn blocks<'a>(page: &'a str, kind: &str) -> Vec<&'a str> {
    let mark = format!("```{kind}\n");
    page.match_indices(&mark)
        .map(|(at, _)| page[at + mark.len()..].split("```").next().unwrap_or_default())
        .collect()
}

#[test]
fn commands_of_the_pages_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    copy(&repository().join("fixtures/problems"), &at("fixtures/problems"));
    copy(&repository().join("fixtures/scenarios"), &at("fixtures/scenarios"));
    copy(&repository().join("fixtures/decks"), &at("fixtures/decks"));
    // A record of one's own.
    std::fs::write(at("quake.csv"), "time,ax,ay,az\n0,0,0,0\n0.4,0.1,0,0\n9,0.1,0,0\n").expect("written");
    let program = program().canonicalize().expect("the program");
    let path = std::env::var("PATH").expect("a path");
    let path = format!("{}:{path}", program.parent().expect("a folder").display());
    for Page { path: page, left_out, given } in PAGES {
        let text = std::fs::read_to_string(repository().join(page)).expect("a page");
        for (name, source) in given {
            std::fs::copy(repository().join(source), at(name)).expect("a copy");
        }
        // A block that begins with the name of a file is that file.
        for block in blocks(&text, "toml") {
            if let Some((name, _)) = block.strip_prefix("# ").and_then(|rest| rest.split_once('\n'))
                && name.ends_with(".toml")
            {
                std::fs::write(at(name), block).expect("written");
            }
        }
        if page.ends_with("fmu.md") {
            std::fs::copy(at("beam.vdm"), at("body.vdm")).expect("a copy");
        }
        let lines = blocks(&text, "sh").join("\n").replace("\\\n", " ");
        let mut unused: Vec<&str> = left_out.iter().map(|(start, _)| *start).collect();
        let mut ran = 0;
        for line in lines.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#')) {
            if let Some((start, _)) = left_out.iter().find(|(start, _)| line.starts_with(start)) {
                unused.retain(|other| other != start);
                continue;
            }
            let mut shell = Command::new("sh");
            let shell = shell.args(["-euc", line]).current_dir(folder.path()).env("PATH", &path);
            let output = shell.output().expect("a shell");
            let error = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{page}: {line}\n{error}");
            ran += 1;
        }
        assert!(ran > 0, "nothing of {page} was run");
        assert!(unused.is_empty(), "{page} has no line that starts with {unused:?}");
    }
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_file() {
            std::fs::copy(&path, to.join(path.file_name().expect("a name"))).expect("a copy");
        }
    }
}
