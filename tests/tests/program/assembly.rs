//! Bodies that are joined: the example of the page through the consumers of a file, and what is refused.

use std::path::Path;

use serde_json::Value;
use vademecum_tests::program::{repository, vademecum};

/// Tables of both parts.
const BOTH: &str = r#"
[[material]]
young = 2e9
poisson = 0.3
density = 1000.0
[[load.pattern]]
name = "weight"
acceleration = [0.0, 0.0, -9.81]
[damping]
ratio = 0.02
[basis]
modes = 8
"#;

const PLATE: &str = r#"
[mesh]
block = { lengths = [0.4, 0.4, 0.04], divisions = [8, 8, 1] }
[[support]]
on = { group = "x_min" }
[[port]]
name = "top"
on = { box = { min = [0.149, 0.149, 0.039], max = [0.251, 0.251, 0.041] } }
"#;

const POST: &str = r#"
[mesh]
block = { lengths = [0.1, 0.1, 0.3], divisions = [2, 2, 6] }
[[port]]
name = "foot"
on = { group = "z_min" }
[[port]]
name = "pin"
kind = "frame"
on = { group = "z_min" }
[[output.probe]]
name = "tip"
point = [0.05, 0.05, 0.3]
direction = [1.0, 0.0, 0.0]
"#;

/// The example of the page.
fn example() -> String {
    let page = std::fs::read_to_string(repository().join("formats/assembly-1.md")).expect("the page");
    let block = page.split("```toml").nth(1).and_then(|rest| rest.split("```").next());
    block.expect("an example").to_string()
}

/// A folder with both parts.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in [("plate", PLATE), ("post", POST)] {
        let at = |end: &str| path(folder.path(), &format!("{name}.{end}"));
        std::fs::write(at("toml"), format!("{text}{BOTH}")).expect("written");
        let ran = vademecum(&["build", &at("toml"), "-o", &at("vdm"), "--keep-missed"]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    }
    folder
}

fn path(folder: &Path, name: &str) -> String {
    folder.join(name).display().to_string()
}

/// Runs a line in which names of files stand for those of the folder.
fn run(folder: &Path, line: &str) -> (Option<i32>, String, String) {
    let is_file = |word: &&str| [".toml", ".vdm", ".fmu", ".html"].iter().any(|end| word.ends_with(end));
    let word = |word: &str| if is_file(&word) || word == "out" { path(folder, word) } else { word.into() };
    let ran = vademecum(&line.split_whitespace().map(word).collect::<Vec<_>>());
    (ran.code, ran.stdout, ran.stderr)
}

fn assembled(folder: &Path, text: &str) -> (Option<i32>, String, String) {
    std::fs::write(folder.join("tower.toml"), text).expect("written");
    run(folder, "assemble tower.toml -o tower.vdm --json --force")
}

#[test]
fn the_example_of_the_page_goes_through_the_consumers_of_a_file() {
    let folder = folder();
    let at = folder.path();
    let (code, text, errors) = assembled(at, &example());
    assert_eq!(code, Some(0), "{errors}");
    let report: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!((&report["modes"], &report["synthesis"]), (&22.into(), &"Rubin".into()));
    // The page of the library's test has all ten; a body of the whole mesh has 44.2304 Hz.
    let first = report["frequencies_hz"][0].as_f64().expect("a number");
    assert!((first / 44.2304 - 1.0).abs() < 1e-4, "{first}");

    let done = |line: &str| {
        let (code, text, errors) = run(at, line);
        assert_eq!(code, Some(0), "{line}: {errors}");
        text
    };
    done("verify tower.vdm --file-only");
    let info: Value = serde_json::from_str(&done("info tower.vdm --json")).expect("JSON");
    assert_eq!(info["load_patterns"], serde_json::json!(["plate.weight", "post.weight"]));
    assert_eq!(info["probes"], serde_json::json!(["post.tip"]));
    let ports: Value = serde_json::from_str(&done("info post.vdm --json")).expect("JSON");
    assert_eq!((&ports["ports"][0]["rows"], &ports["ports"][1]["kind"]), (&75.into(), &"frame".into()));
    // Both weights, until it rests.
    std::fs::write(
        at.join("weights.toml"),
        "duration = 3.0\n[[pattern]]\nname = \"plate.weight\"\n[[pattern]]\nname = \"post.weight\"\n",
    )
    .expect("written");
    done("run tower.vdm --scenario weights.toml -o out");
    let rows = std::fs::read_to_string(at.join("out/probes.csv")).expect("a table");
    let moved: f64 =
        rows.lines().last().and_then(|row| row.split(',').nth(1)).expect("a row").parse().expect("a number");
    // The plate bends down from its support, and the post leans forward with it.
    assert!(moved > 1e-5 && moved < 1e-2, "{moved:e}");
    done("frf tower.vdm --in 0.15,0.15,0.34,x --out post.tip --range 1,100");
    done("view tower.vdm --export page.html");
    done("export fmu tower.vdm -o tower.fmu");
    done("report tower.vdm -o report.html");
    done("pack tower.vdm -o packed.vdm --tolerance 1e-4");

    // The assembly file is taken where a file is taken, with the same results.
    let probes = std::fs::read(at.join("out/probes.csv")).expect("a table");
    done("run tower.toml --scenario weights.toml -o out");
    assert_eq!(std::fs::read(at.join("out/probes.csv")).expect("a table"), probes);
    let response = "--in 0.15,0.15,0.34,x --out post.tip --range 1,100 --json";
    assert_eq!(done(&format!("frf tower.toml {response}")), done(&format!("frf tower.vdm {response}")));
    done("view tower.toml --export joined.html");
    let page = |name: &str| std::fs::read_to_string(at.join(name)).expect("a page").len();
    // Titles differ by the ends of the names.
    assert!(page("joined.html").abs_diff(page("page.html")) < 16);
    done("export fmu tower.toml -o joined.fmu");
    done("report tower.toml -o joined-report.html");
    // Not as a part: a problem, or a file of its own.
    for (line, words) in [
        ("info tower.toml", "assemble"),
        ("modes tower.toml", "it is an assembly"),
        ("view tower.toml --export post.vdm --force", "post.vdm"),
    ] {
        let (code, _, errors) = run(at, line);
        assert!(code != Some(0) && errors.contains(words), "{line}: {errors}");
    }
    // What cannot be joined names the assembly and its part.
    std::fs::write(at.join("lost.toml"), example().replace("post.vdm", "none.vdm")).expect("written");
    for line in ["run lost.toml --scenario weights.toml -o out", &format!("frf lost.toml {response}")] {
        let (code, _, errors) = run(at, line);
        let named = errors.contains("lost.toml") && errors.contains("part `post`");
        assert!(code == Some(1) && named, "{line}: {errors}");
    }
}

#[test]
fn what_the_page_refuses_is_refused_by_its_key() {
    let folder = folder();
    let at = folder.path();
    let example = example();
    let joint = |kind: &str, between: &str, more: &str| {
        let start = example.find("[[joint]]").expect("a joint");
        format!("{}[[joint]]\nkind = \"{kind}\"\nbetween = {between}\n{more}\n", &example[..start])
    };
    let welded = "[\"post.foot\", \"plate.top\"]";
    let refused = [
        (example.replace("format = 1", "format = 2"), 3, "`format` is 2"),
        (example.replace("name = \"post\"", "name = \"plate\""), 3, "`part[1].name`"),
        (example.replace("name = \"post\"", "name = \"ground\""), 3, "`part[1].name`"),
        (example.replace("position", "colour = 1\nposition"), 3, "colour"),
        (example.replace("position = [0.15,", "position = [inf,"), 3, "`part[1].position`"),
        (example.replace("position", "rotation = [1.0, 1.0, 0.0, 0.0]\nposition"), 3, "`part[1].rotation`"),
        (example.replace("position", "hash = \"00\"\nposition"), 3, "`part[1].hash`"),
        (example.replace("\"post.vdm\"", "\"none.vdm\""), 1, "cannot read"),
        (example.replace("\"post.vdm\"", "\"post.toml\""), 7, "part `post`"),
        (example.replace("0.15, 0.04]", "0.15, 0.05]"), 3, "apart"),
        (example.replace("plate.top", "plate.bottom"), 3, "plate.top, post.foot"),
        (joint("weld", "[\"post.pin\", \"plate.top\"]", ""), 3, "a patch and a frame"),
        (joint("hinge", welded, ""), 3, "`weld` or `bushing`"),
        (joint("weld", welded, "stiffness = [1.0, 1.0, 1.0]"), 3, "`joint[0].stiffness`"),
        (joint("bushing", welded, ""), 3, "`joint[0].stiffness`"),
        (joint("bushing", welded, "stiffness = [1.0, 1.0]"), 3, "three numbers"),
        (joint("bushing", welded, "stiffness = [0.0, 0.0, 0.0]"), 3, "above 0"),
        (joint("spring", "[\"post.pin\", \"ground\"]", "stiffness = [1.0]"), 3, "frames at one place"),
        (joint("ball", "[\"post.pin\", \"ground\"]", ""), 3, "moves freely in 3 ways: part `post`"),
        (format!("{example}[[joint]]\nkind = \"weld\"\nbetween = {welded}\n"), 3, "joint `weld2`"),
        (example[..example.find("[[part]]").expect("a part")].to_string(), 3, "part"),
    ];
    for (text, code, words) in refused {
        let (found, _, errors) = assembled(at, &text);
        assert!(found == Some(code) && errors.contains(words), "{words}: {found:?}: {errors}");
        assert!(!at.join("tower.vdm").exists(), "{words}");
    }
    // A path that is no file is not waited for.
    #[cfg(unix)]
    {
        let (found, _, errors) = assembled(at, &example.replace("\"post.vdm\"", "\"/dev/zero\""));
        assert!(found == Some(1) && errors.contains("part `post`"), "{found:?}: {errors}");
    }
    assembled(at, &example);
    // No input is written over.
    let (code, _, errors) = run(at, "assemble tower.toml -o post.vdm --force");
    assert!(code != Some(0), "{errors}");
    assert!(vademecum(&["info", &path(at, "post.vdm")]).code == Some(0));
}
