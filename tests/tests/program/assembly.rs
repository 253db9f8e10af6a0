//! Bodies that are joined, and bodies that touch: the examples of the pages through the program, and what is
//! refused.

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
    let is_file =
        |word: &&str| [".toml", ".vdm", ".fmu", ".html", ".csv"].iter().any(|end| word.ends_with(end));
    let word = |word: &str| {
        if is_file(&word) || ["out", "chain"].contains(&word) { path(folder, word) } else { word.into() }
    };
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

/// A folder with the examples of the page about bodies that touch, and its commands run there.
fn worlds() -> tempfile::TempDir {
    let page = std::fs::read_to_string(repository().join("docs/how-to/join-bodies.md")).expect("the page");
    let section = page.split("## Bodies that touch").nth(1).expect("the section");
    let section = section.split("\n## ").next().expect("a section");
    let folder = tempfile::tempdir().expect("a folder");
    for block in section.split("```toml\n# ").skip(1) {
        let (name, text) =
            block.split("```").next().and_then(|block| block.split_once('\n')).expect("a file");
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    let commands =
        section.split("```sh\n").nth(1).and_then(|rest| rest.split("```").next()).expect("commands");
    for line in commands.lines() {
        let line = line.strip_prefix("vademecum ").expect("a command of the program");
        let (code, _, errors) = run(folder.path(), line);
        assert_eq!(code, Some(0), "{line}: {errors}");
        assert!(!errors.contains("did not converge") && !errors.contains("no room"), "{line}: {errors}");
    }
    folder
}

/// Columns of a table by their names.
fn table(path: &Path) -> (Vec<String>, Vec<Vec<f64>>) {
    let text = std::fs::read_to_string(path).expect("a table");
    let mut lines = text.lines();
    let names: Vec<String> = lines.next().expect("names").split(',').map(str::to_string).collect();
    let number = |word: &str| word.parse::<f64>().expect("a number");
    let rows: Vec<Vec<f64>> = lines.map(|line| line.split(',').map(number).collect()).collect();
    assert!(rows.iter().all(|row| row.len() == names.len()));
    (names, rows)
}

fn column(table: &(Vec<String>, Vec<Vec<f64>>), name: &str) -> Vec<f64> {
    let at =
        table.0.iter().position(|other| other == name).unwrap_or_else(|| panic!("{name}: {:?}", table.0));
    table.1.iter().map(|row| row[at]).collect()
}

#[test]
fn a_dropped_cube_rests_with_its_weight_and_a_chain_swings() {
    let folder = worlds();
    let at = folder.path();
    let drop = table(&at.join("drop.csv"));
    assert_eq!(drop.1.len(), 1501);
    let force = column(&drop, "force of base on cube z [N]");
    let weight = 9.81 * 1000.0 * 0.08_f64.powi(3);
    // It falls freely first, and lies at the end.
    assert_eq!(force[1], 0.0);
    let height = column(&drop, "cube z [m]");
    assert!((height[20] - (0.125 - 0.5 * 9.81 * 0.02_f64.powi(2))).abs() < 1e-9, "{}", height[20]);
    let last = &force[force.len() - 100..];
    for found in last {
        assert!((found / weight - 1.0).abs() < 0.01, "{found} N of {weight}");
    }
    // A cube that is pressed by its weight sinks into the base by less than its strain times its height.
    let lowest = height[height.len() - 1];
    let most = weight / (0.08 * 0.08) / 1e6 * 0.16;
    assert!(lowest < 0.12 && lowest > 0.12 - 2.0 * most, "{lowest}");
    let contacts = column(&drop, "contacts of cube and base");
    assert!(contacts[1] == 0.0 && contacts[contacts.len() - 1] >= 3.0);
    let energy = column(&drop, "energy_J");
    assert!(energy[energy.len() - 1] < energy[0]);

    // The chain swings without loss, and further than any small angle.
    let chain = table(&at.join("chain.csv"));
    assert_eq!(chain.1.len(), 101);
    let energy = column(&chain, "energy_J");
    // The links fall from their height: energies are compared with what moves between its forms.
    let whole = 3.0 * 1200.0 * 0.2 * 0.02 * 0.02 * 9.81 * 0.3;
    let off = energy.iter().map(|e| (e - energy[0]).abs()).fold(0.0, f64::max);
    assert!(off < 0.01 * whole, "{off} of {whole}");
    let (x, z) = (column(&chain, "tip x [m]"), column(&chain, "tip z [m]"));
    let lowest = z.iter().copied().fold(0.0, f64::min);
    assert!(lowest < -0.5, "{lowest}");
    for (x, z) in x.iter().zip(&z) {
        // It hangs on the ground by 0.6 m.
        assert!(x.hypot(z - 0.01) < 0.6 * 1.001, "{x} {z}");
    }
    let surfaces = std::fs::read_to_string(at.join("chain/world.pvd")).expect("a collection");
    assert_eq!(surfaces.matches("world-").count(), 101);

    // Two runs give the same bytes.
    let first = std::fs::read(at.join("drop.csv")).expect("a table");
    let (code, text, errors) = run(at, "run drop.toml -o again.csv --json");
    assert_eq!(code, Some(0), "{errors}");
    assert!(std::fs::read(at.join("again.csv")).expect("a table") == first);
    let report: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!((&report["steps"], &report["steps_not_converged"]), (&1500.into(), &0.into()));
    assert!(report["contacts_at_most"].as_u64().is_some_and(|count| count >= 9));
}

/// A link alone from the horizontal: the time to the vertical is `K(1/√2) √(I/(m g l))`.
#[test]
fn a_link_swings_down_in_the_time_of_a_pendulum() {
    let folder = worlds();
    let at = folder.path();
    let chain = std::fs::read_to_string(at.join("chain.toml")).expect("the chain");
    let start = chain.find("[[part]]\nname = \"second\"").expect("a second part");
    let text = format!(
        "{}[[joint]]\nkind = \"hinge\"\nturns = true\nbetween = [\"first.start\", \"ground\"]\n[[output]]\n\
         part = \"first\"\n",
        &chain[..start]
    );
    std::fs::write(at.join("pendulum.toml"), text).expect("written");
    let (code, _, errors) = run(at, "run pendulum.toml -o pendulum.csv");
    assert_eq!(code, Some(0), "{errors}");
    let found = table(&at.join("pendulum.csv"));
    let (time, x) = (column(&found, "time_s"), column(&found, "first x [m]"));
    let below = x.iter().position(|x| *x < 0.0).expect("it passes the vertical");
    let share = x[below - 1] / (x[below - 1] - x[below]);
    let crossed = time[below - 1] + share * (time[below] - time[below - 1]);
    // Moment about the axis in the middle of the end face, over mass.
    let moment = (0.2 * 0.2 + 0.02 * 0.02) / 12.0 + 0.1 * 0.1;
    let expected = 1.854_074_677_301_372 * (moment / (9.81 * 0.1_f64)).sqrt();
    assert!((crossed / expected - 1.0).abs() < 2e-3, "{crossed} {expected}");
}

#[test]
fn worlds_are_refused_where_they_cannot_be() {
    let folder = worlds();
    let at = folder.path();
    let read = |name: &str| std::fs::read_to_string(at.join(name)).expect("a file");
    let (drop, chain) = (read("drop.toml"), read("chain.toml"));
    let cable = "[[joint]]\nkind = \"cable\"\nlength = 0.1\nbetween = [\"third.end\", \"ground\"]\n";
    let refused = [
        (drop.replace("0.085]", "0.075]"), 3, "which overlap by 5.000e-3 m"),
        (
            drop.replace("file = \"base.vdm\"", "file = \"base.vdm\"\nspin = [0.0, 0.0, 1.0]"),
            3,
            "`part[1].spin`",
        ),
        (drop.replace("file = \"base.vdm\"", "file = \"none.vdm\""), 1, "part `base`"),
        (drop.replace("part = \"cube\"", "part = \"base\""), 3, "`output[0].part`"),
        (drop.replace("file = \"base.vdm\"", "file = \"cube.toml\""), 7, "part `base`"),
        (chain.replace("third.start", "third.middle"), 3, "third.start, third.end"),
        (chain.replace("[0.4, 0.0, 0.0]", "[0.41, 0.0, 0.0]"), 3, "apart"),
        (format!("{chain}{cable}"), 3, "`at`"),
        (format!("{chain}{cable}at = [0.6, 0.01, 0.5]\n"), 3, "`joint[3].length`"),
        (format!("{chain}{}", cable.replace("third.end", "third.lost")), 3, "`joint[3].between`"),
    ];
    for (text, code, words) in refused {
        std::fs::write(at.join("bad.toml"), &text).expect("written");
        let (found, _, errors) = run(at, "run bad.toml -o bad.csv");
        assert!(found == Some(code) && errors.contains(words), "{words}: {found:?}: {errors}");
        assert!(errors.contains("bad.toml") && !at.join("bad.csv").exists(), "{words}: {errors}");
    }
    // No one body.
    for line in [
        "assemble drop.toml -o drop.vdm",
        "frf chain.toml --in 0.2,0.01,0.01,z --out 0.2,0.01,0.01,z --range 1,100",
        "report drop.toml -o page.html",
        "run cube.vdm --every 2",
        "run drop.toml --scenario drop.toml",
        "run cube.vdm",
        "verify drop.toml --file-only",
    ] {
        let (code, _, errors) = run(at, line);
        assert!(code != Some(0) && !errors.contains("panicked"), "{line}: {errors}");
        let named = ["`world` is given", "`--every`", "`--scenario", "assembly file"];
        assert!(named.iter().any(|words| errors.contains(words)), "{line}: {errors}");
    }
    // Bodies with a separated step, and of large displacements.
    for (golden, words) in [("parameters.vdm", "part `cube`"), ("bent.vdm", "large displacements")] {
        let source = repository().join("fixtures/golden").join(golden);
        std::fs::copy(&source, at.join("other.vdm")).unwrap_or_else(|e| panic!("{}: {e}", source.display()));
        std::fs::write(at.join("bad.toml"), drop.replace("cube.vdm", "other.vdm")).expect("written");
        let (code, _, errors) = run(at, "run bad.toml -o bad.csv");
        assert!(code == Some(7) && errors.contains(words), "{golden}: {code:?}: {errors}");
    }
}

/// A rigid box, a moving and a standing one, in place of the base and the cube.
#[test]
fn rigid_bodies_carry_and_are_carried() {
    let folder = worlds();
    let at = folder.path();
    let drop = std::fs::read_to_string(at.join("drop.toml")).expect("a file");
    let weight = 9.81 * 1000.0 * 0.08_f64.powi(3);
    let block = |lengths: &str, more: &str| format!("rigid = {{ box = {{ lengths = {lengths} }}{more} }}");
    for text in [
        drop.replace("file = \"base.vdm\"", &block("[0.16, 0.16, 0.08]", "")),
        drop.replace("file = \"cube.vdm\"", &block("[0.08, 0.08, 0.08]", ", density = 1000.0")),
    ] {
        std::fs::write(at.join("rigid.toml"), &text).expect("written");
        let (code, _, errors) = run(at, "run rigid.toml -o rigid.csv");
        assert_eq!(code, Some(0), "{errors}");
        let found = table(&at.join("rigid.csv"));
        let force = column(&found, "force of base on cube z [N]");
        let mean = force[force.len() - 100..].iter().sum::<f64>() / 100.0;
        assert!((mean / weight - 1.0).abs() < 0.01, "{mean} {weight}");
    }
}

/// A floor that is led upwards carries the cubes that lie on it, copies of one part; a joint that bears less
/// than what hangs on it breaks, and the page of the world has each file once.
#[test]
fn parts_are_led_and_copied_and_joints_break() {
    let folder = worlds();
    let at = folder.path();
    let text = "format = 1\n[world]\ntime = 1.2\nstep = 1e-3\ngravity = [0.0, 0.0, -9.81]\n\
                [[part]]\nname = \"cube\"\nfile = \"cube.vdm\"\ncopies = [2, 1, 1]\nspacing = [0.2, 0.0, 0.0]\n\
                position = [0.0, 0.0, 0.001]\n\
                [[part]]\nname = \"floor\"\nrigid = { box = { lengths = [0.5, 0.3, 0.1] } }\n\
                position = [-0.1, -0.1, -0.1]\npath = [[0.3, 0.0, 0.0, 0.0], [0.8, 0.0, 0.0, 0.05]]\n\
                [[part]]\nname = \"link\"\nfile = \"link.vdm\"\nposition = [0.0, 1.0, 0.0]\n\
                [[contact]]\nbetween = [\"cube*\", \"floor\"]\nfriction = 0.5\nrestitution = 0.0\nnodes = \"first\"\n\
                [[joint]]\nkind = \"ball\"\nturns = true\nbetween = [\"link.start\", \"ground\"]\nbreaks_at = 0.1\n\
                [[output]]\npart = \"cube1\"\n[[output]]\npart = \"cube2\"\n[[output]]\npart = \"link\"\n";
    std::fs::write(at.join("led.toml"), text).expect("written");
    let (code, said, errors) = run(at, "run led.toml -o led.csv --json");
    assert_eq!(code, Some(0), "{errors}");
    let report: serde_json::Value = serde_json::from_str(&said).expect("JSON");
    assert_eq!(report["joints_broken"], 1);
    let found = table(&at.join("led.csv"));
    for cube in ["cube1", "cube2"] {
        let z = column(&found, &format!("{cube} z [m]"));
        assert!((z.last().expect("a row") - 0.09).abs() < 1e-3, "{z:?}");
    }
    let apart = column(&found, "cube2 x [m]").last().expect("a row")
        - column(&found, "cube1 x [m]").last().expect("a row");
    assert!((apart - 0.2).abs() < 1e-3, "{apart}");
    // The link weighs 0.94 N, so its joint broke and it fell freely.
    let fallen = column(&found, "link z [m]");
    assert!(fallen.last().expect("a row") + 0.5 * 9.81 * 1.2 * 1.2 < 0.1, "{:?}", fallen.last());
    assert!(!std::fs::read_to_string(at.join("led.csv")).expect("a table").contains("contacts of"));
    let (code, _, errors) = run(at, "view led.toml --export led.html");
    assert_eq!(code, Some(0), "{errors}");
    let page = std::fs::read_to_string(at.join("led.html")).expect("a page");
    assert_eq!(page.matches("data-file=").count(), 2, "two files of three parts");
    assert!(page.contains("cube2") && !page.contains("{{"));
    std::fs::write(
        at.join("bad.toml"),
        text.replace("position = [0.0, 0.0, 0.001]", "path = [[0, 0, 0, 0]]"),
    )
    .expect("written");
    let (code, _, errors) = run(at, "view bad.toml --export bad.html");
    assert!(code == Some(3) && errors.contains("`part[0].path`"), "{code:?}: {errors}");
}

/// A plate whose free half is live in stiffness and density, or is built at values of it.
fn live_plate(values: Option<[f64; 2]>) -> String {
    let [stiffness, density] = values.unwrap_or([1.0, 1.0]);
    let tip = "[[mesh.region]]\nname = \"tip\"\non = { fraction = { axis = \"x\", side = \"max\", fraction = 0.5 } }\n";
    let material = |region: &str, stiffness: f64, density: f64| {
        let (young, density) = (2e9 * stiffness, 1000.0 * density);
        format!("[[material]]\nregion = \"{region}\"\nyoung = {young}\npoisson = 0.3\ndensity = {density}\n")
    };
    let (_, rest) = BOTH.split_once("density = 1000.0\n").expect("a density");
    let live = |kind: &str| {
        format!(
            "[[parameter]]\nname = \"{kind}\"\nkind = \"{kind}\"\nregion = \"tip\"\nrange = [0.25, 4.0]\n"
        )
    };
    let live = if values.is_none() { live("stiffness") + &live("density") } else { String::new() };
    let materials = material("body", 1.0, 1.0) + &material("tip", stiffness, density);
    let modes = if values.is_none() { "modes = 96" } else { "modes = 64" };
    format!("{PLATE}{tip}{materials}{}{live}", rest.replace("modes = 8", modes))
}

#[test]
fn parts_with_live_regions_are_joined_and_move_at_their_values() {
    let folder = folder();
    let at = folder.path();
    let values = [0.4, 2.5];
    for (name, text) in [("live", live_plate(None)), ("fixed", live_plate(Some(values)))] {
        std::fs::write(at.join(format!("{name}.toml")), text).expect("written");
        let (code, _, errors) = run(at, &format!("build {name}.toml -o {name}.vdm --keep-missed"));
        assert_eq!(code, Some(0), "{errors}");
    }
    let set = format!("parameters = {{ stiffness = {}, density = {} }}", values[0], values[1]);
    let of = |file: &str, more: &str| {
        let example = example();
        assert!(example.contains("file = \"plate.vdm\"\n"));
        example.replace("file = \"plate.vdm\"\n", &format!("file = \"{file}.vdm\"\n{more}\n"))
    };
    let frequencies = |text: &str| -> Vec<f64> {
        let (code, _, errors) = assembled(at, text);
        assert_eq!(code, Some(0), "{errors}");
        let bytes = std::fs::read(at.join("tower.vdm")).expect("a file");
        let file = vademecum_format::File::parse(&bytes).expect("a file");
        let section = file.section(vademecum_format::SectionKind::Eigenvalues).expect("eigenvalues");
        section.f64s().expect("numbers").iter().map(|x| f64::from_le_bytes(*x).sqrt()).collect()
    };
    let [set_to, fixed, built] =
        [of("live", &set), of("fixed", ""), of("live", "")].map(|text| frequencies(&text));
    for (k, (found, expected)) in set_to.iter().zip(&fixed).enumerate().take(6) {
        assert!((found / expected - 1.0).abs() < 1e-3, "mode {k}: {found} beside {expected}");
    }
    assert!((built[0] / fixed[0] - 1.0).abs() > 0.02, "{} beside {}", built[0], fixed[0]);

    // A cube that lies on the plate, in a world.
    let world = |text: String| {
        let part = text.split("[[part]]").find(|part| part.contains("\"plate\"")).expect("the plate");
        let part = part.split("[[").next().expect("a table");
        format!(
            "format = 1\n[world]\ntime = 0.1\nstep = 1e-3\ngravity = [0, 0, -9.81]\n[[part]]{part}[[part]]\nname = \
             \"box\"\nrigid = {{ box = {{ lengths = [0.1, 0.1, 0.1] }}, density = 2e3 }}\nposition = [0.3, 0.15, \
             0.041]\n[[contact]]\nbetween = [\"box\", \"plate\"]\n[[output]]\npart = \"box\"\n"
        )
    };
    let fallen = |text: String| {
        std::fs::write(at.join("world.toml"), world(text)).expect("written");
        let (code, _, errors) = run(at, "run world.toml -o world.csv");
        assert_eq!(code, Some(0), "{errors}");
        let table = table(&at.join("world.csv"));
        *column(&table, "box z [m]").last().expect("a row")
    };
    let [set_to, fixed, built] = [of("live", &set), of("fixed", ""), of("live", "")].map(fallen);
    assert!((set_to - fixed).abs() < 0.02 * (built - fixed).abs(), "{set_to} {fixed} {built}");

    for (text, words) in [
        (of("live", "parameters = { stifness = 1.0 }"), "did you mean `stiffness`?"),
        (of("live", "parameters = { stiffness = 9.0 }"), "`part[0].parameters`"),
        (of("fixed", "parameters = { stiffness = 1.0 }"), "a file with live regions"),
        (
            world(of("live", &set)).replace("position = [0.3", "parameters = { a = 1.0 }\nposition = [0.3"),
            "a rigid body",
        ),
    ] {
        let (code, _, errors) = assembled(at, &text);
        assert!(code == Some(3) && errors.contains(words), "{words}: {code:?}: {errors}");
    }
}
