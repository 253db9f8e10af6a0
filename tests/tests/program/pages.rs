//! The normative pages of the three text formats: every example parses, every numbered refusal happens.

use std::path::PathBuf;

use vademecum_assembly::AssemblyFile;
use vademecum_build::input::toml_file::TomlError;
use vademecum_build::input::{Problem, ProblemError};
use vademecum_study::scenario::{Scenario, ScenarioError};
use vademecum_tests::program::repository;

fn page(name: &str) -> String {
    std::fs::read_to_string(repository().join("formats").join(name)).expect("a page")
}

/// The TOML blocks of a page.
fn examples(page: &str) -> Vec<&str> {
    let blocks = page.split("```toml\n").skip(1);
    blocks.map(|rest| rest.split("```").next().expect("a closed block")).collect()
}

/// Number and key of each row of a page's table of refusals.
fn refusals(page: &str) -> Vec<(usize, String)> {
    let table = page.split("## Refusals").nth(1).expect("refusals");
    let row = |line: &str| {
        let mut cells = line.split('|').skip(1).map(|cell| cell.trim().trim_matches('`').to_string());
        let number = cells.next()?.parse().ok()?;
        Some((number, cells.next()?))
    };
    table.lines().filter_map(row).collect()
}

/// Tables a problem must have.
const REQUIRED: [(&str, &str); 2] = [
    ("[mesh", "[mesh]\nblock = { lengths = [1.0, 0.1, 0.1], divisions = [10, 1, 1] }\n"),
    ("[[material", "[[material]]\nyoung = 2.1e9\npoisson = 0.3\ndensity = 1200.0\n"),
];

/// A fragment with the required tables it lacks.
fn whole(fragment: &str) -> String {
    let missing = REQUIRED.iter().filter(|(mark, _)| !fragment.contains(mark));
    std::iter::once(fragment).chain(missing.map(|(_, table)| *table)).collect::<Vec<_>>().join("\n")
}

fn problem(text: &str) -> Result<Problem, ProblemError> {
    Problem::parse(text, "page.toml", PathBuf::new())
}

#[test]
fn every_example_of_a_problem_is_one() {
    let page = page("problem-1.md");
    let examples = examples(&page);
    assert!(examples.len() > 10);
    problem(examples[0]).expect("the first example is whole");
    for example in examples {
        if let Err(error) = problem(&whole(example)) {
            panic!("{error}\n{example}");
        }
    }
}

#[test]
fn every_example_of_a_scenario_is_one() {
    for example in examples(&page("scenario-1.md")) {
        if let Err(error) = Scenario::parse(example, "page.toml") {
            panic!("{error}\n{example}");
        }
    }
}

#[test]
fn every_fixture_is_what_it_says() {
    for entry in std::fs::read_dir(repository().join("fixtures/problems")).expect("fixtures") {
        Problem::read(&entry.expect("an entry").path()).expect("a problem");
    }
    for entry in std::fs::read_dir(repository().join("fixtures/scenarios")).expect("fixtures") {
        let path = entry.expect("an entry").path();
        // Tables lie beside the scenarios that name them.
        if path.extension().is_some_and(|extension| extension == "toml") {
            Scenario::read(&path).expect("a scenario");
        }
    }
}

const STEEL: &str = "young = 2e11\npoisson = 0.3\ndensity = 7800.0\n";

/// A fragment for each refusal of the page from number 3 on.
fn bad_problems() -> Vec<(usize, String)> {
    let material = |young: &str, poisson: &str, density: &str| {
        format!("[[material]]\nyoung = {young}\npoisson = {poisson}\ndensity = {density}\n")
    };
    let block = |lengths: &str, divisions: &str| {
        format!("[mesh]\nblock = {{ lengths = {lengths}, divisions = {divisions} }}\n")
    };
    let pattern = |rest: &str| format!("[load]\n[[load.pattern]]\n{rest}\n");
    let probe = |name: &str, point: &str, direction: &str| {
        format!("[[output.probe]]\nname = {name}\npoint = {point}\ndirection = {direction}\n")
    };
    let parameter = |rest: &str| format!("[[parameter]]\nname = \"a\"\n{rest}\n");
    let twice = "kind = \"alpha\"\nrange = [0.0, 1.0]\n[[parameter]]\nname = \"b\"\nkind = \"alpha\"\nrange \
        = [0.0, 1.0]";
    let canonical = |rest: &str| format!("representation = \"canonical\"\n[canonical]\n{rest}\n");
    let matrices = |rest: &str| {
        let mesh = "[mesh]\nmatrices = { mass = \"m\", stiffness = \"k\", dofs = \"d\" } # no [[material]]";
        format!("{mesh}\n{rest}\n")
    };
    let text = |text: &str| text.to_string();
    let reactions = |before: &str, after: &str| {
        format!("{before}\n[output]\nreactions = true\n[[support]]\non = {{ group = \"a\" }}\n{after}")
    };
    // Keys that are left out stand at the end, so that every gauge is whole.
    let gauge = |keys: &str| {
        let rest = [("point", "[0, 0, 0]"), ("direction", "[1, 0, 0]"), ("length", "0.1")];
        let last = keys.rsplit("[[").next().unwrap_or(keys);
        let more = rest.iter().filter(|(key, _)| !last.contains(key));
        let more: Vec<String> = more.map(|(key, value)| format!("{key} = {value}")).collect();
        format!("[[output.gauge]]\n{keys}\n{}\n", more.join("\n"))
    };
    let large = |before: &str, after: &str| {
        format!("model = \"large-displacement\"\n{before}\n[[support]]\non = {{ group = \"a\" }}\n{after}\n")
    };
    let based = |before: &str, after: &str| {
        format!("{before}\n[base]\nmoves = true\n[[support]]\non = {{ group = \"a\" }}\n{after}")
    };
    vec![
        (3, text("[mesh]\nscale = 1.0")),
        (3, matrices("").replace("[mesh]", "[mesh]\nfile = \"a.msh\"")),
        (3, block("[1, 1, 1]", "[1, 1, 1]") + "file = \"a.msh\""),
        (4, block("[1, 1, 1]", "[1, 1, 1]") + "scale = 0.0"),
        (5, block("[1, inf, 1]", "[1, 1, 1]")),
        (6, block("[1, 1, 1]", "[1, 0, 1]")),
        (7, text("material = [] # [[material\n")),
        (8, material("0.0", "0.3", "1.0")),
        (9, material("1.0", "0.5", "1.0")),
        (9, material("1.0", "nan", "1.0")),
        (10, material("1.0", "0.3", "-1.0")),
        (11, format!("[[material]]\n{STEEL}[[material]]\n{STEEL}")),
        (12, text("[[support]]\non = { group = \"a\" }\ncomponents = []")),
        (13, text("[damping]\nalpha = 1.0\nratios = [[0.1, 1.0], [0.1, 2.0]]")),
        (14, text("[damping]\nalpha = -1.0")),
        (15, text("[damping]\nbeta = inf")),
        (16, text("[damping]\nratios = [[0.1, 1.0], [0.1, 1.0]]")),
        (17, text("[damping]\nratios = [[0.5, 5.0], [0.001, 80.0]]")),
        (66, text("[damping]\nmodal = []")),
        (66, text("[damping]\nmodal = [0.1, 1e4]")),
        (67, text("[damping]\nmodal = [0.1]\nratio = 0.1")),
        (68, text("[output]\nstatic_fields = true\nresidual = false")),
        (68, text("[output]\nstatic_fields = true\nfields = \"surface\"")),
        (68, text("[output]\nstatic_fields = true\n[time]\nstep = 1.0\nscheme = { name = \"bathe\" }")),
        (69, text("[[support]]\nname = \"a,b\"\non = { group = \"a\" }")),
        (69, format!("[[support]]\nname = \"{}\"\non = {{ group = \"a\" }}", "a".repeat(1001))),
        (70, text("[output]\nreactions = true")),
        (74, gauge("name = \"\"")),
        (
            74,
            format!(
                "{}[[output.probe]]\nname = \"twice\"\npoint = [0, 0, 0]\ndirection = [1, 0, 0]\n",
                gauge("name = \"twice\"")
            ),
        ),
        (74, gauge(&format!("name = \"{}\"", "a".repeat(1001)))),
        (75, gauge("name = \"g\"\npoint = [0, nan, 0]")),
        (76, gauge("name = \"g\"\npoint = [0, 0, 0]\ndirection = [0, 0, 0]")),
        (77, gauge("name = \"g\"\npoint = [0, 0, 0]\ndirection = [0, 1, 0]\nlength = -0.1")),
        (77, gauge("name = \"g\"\npoint = [0, 0, 0]\ndirection = [0, 1, 0]\nlength = 1e31")),
        (78, matrices("[output]\nstress = \"body\"")),
        (79, text("[output]\nstress_residual = true")),
        (79, text("[output]\nstress = \"body\"\nresidual = false\nstress_residual = true")),
        (80, text("model = \"large-displacement\"")),
        (80, large("", "[time]\nscheme = { name = \"bathe\" }")),
        (80, large("", "[basis]\nkind = \"modes\"")),
        (80, large("", "[damping]\nratio = 0.02")),
        (80, large("", "[output]\nreactions = true")),
        (80, large("", "[output]\nresidual = true")),
        (81, text("[large]\nstates = 4")),
        (82, large("", "[large]\ndisplacement = -1.0")),
        (82, large("", "[large]\ndisplacement = 1e31")),
        (83, large("", "[large]\nrows = 5000")),
        (84, large("", "[large]\nstates = 0")),
        (85, large("", "[basis]\nmodes = 65")),
        (86, large("", "[large]\npushes = 0")),
        (71, text("[base]\nmoves = true")),
        (71, matrices("[base]\nmoves = true")),
        (71, based("", "[[parameter]]\nname = \"a\"\nkind = \"density\"\nrange = [0.5, 2.0]")),
        (71, based("representation = \"canonical\"", "")),
        (72, text("[base]\nmoves = false\npoint = [0, inf, 0]")),
        (72, based("", "").replace("true", "true\npoint = [0, 1e40, 0]")),
        (73, based("", &pattern("name = \"base.ax\"\nacceleration = [0, 0, 1]"))),
        (70, matrices("[output]\nreactions = true")),
        (70, reactions("representation = \"canonical\"", "")),
        (70, reactions("", "[basis]\nkind = \"pod\"")),
        (
            70,
            reactions(
                "representation = \"separated\"",
                "[[parameter]]\nname = \"a\"\nkind = \"density\"\nregion = \"b\"\nrange = [0.5, 2.0]",
            ),
        ),
        (18, pattern("name = \"a\"")),
        (18, pattern("name = \"a\"\nacceleration = [0, 0, 1]\npressure = 1.0")),
        (19, pattern("name = \"a\"\npressure = 1.0")),
        (19, pattern("name = \"a\"\nacceleration = [0, 0, 1]\non = { group = \"a\" }")),
        (20, pattern("name = \"\"\nacceleration = [0, 0, 1]")),
        (21, pattern("name = \"a\"\nacceleration = [0, 0, nan]")),
        (22, probe("\"a,b\"", "[0, 0, 0]", "[0, 0, 1]")),
        (23, probe("\"a\"", "[0, 0, inf]", "[0, 0, 1]")),
        (24, probe("\"a\"", "[0, 0, 0]", "[0, 0, 0]")),
        (25, text("[time]\nstep = 0.0")),
        (26, text("[time]\nstep = 1.0\nscheme = { name = \"rho-bathe\", rho_infinity = 1.5 }")),
        (26, text("[time]\nstep = 1.0\nscheme = { name = \"hht-alpha\", alpha = 0.1 }")),
        (
            26,
            text("[time]\nscheme = { name = \"exact\" }\n[basis]\nenergy = 0.5\n")
                + &parameter("kind = \"stiffness\"\nregion = \"b\"\nrange = [0.5, 2.0]"),
        ),
        (27, text("[snapshots]\npositions = 0")),
        (28, text("[snapshots]\ndirections = [[0, 0, 0]]")),
        (28, text("[snapshots]\ndirections = []")),
        (29, text("[snapshots]\nhold = 0.0")),
        (30, text("[snapshots]\nduration = -1.0")),
        (31, text("[snapshots]\nstride = 0")),
        (32, text("[snapshots]\nnpy = \"a.npy\"\nvtu = []")),
        (33, text("[basis]\nmodes = 0")),
        (34, text("[basis]\nmodes = 1\nenergy = 0.5")),
        (35, text("[basis]\nenergy = 1.0")),
        (36, text("[basis]\noversampling = 0")),
        (37, text("[tolerance]\nfloor_ratio = 0.9")),
        (38, text("[tolerance]\nabsolute = 1e-14")),
        (39, text("[tolerance]\nsteps = 9")),
        (40, text("[tolerance]\nmap = 1e-12")),
        (41, text("[tolerance]\nmax_terms = 0")),
        (42, text("[[parameter]]\nname = \"\"\nkind = \"alpha\"\nrange = [0.0, 1.0]")),
        (43, parameter(twice)),
        (44, parameter("kind = \"beta\"\nregion = \"a\"\nrange = [0.0, 1.0]")),
        (45, parameter("kind = \"stiffness\"\nrange = [2.0, 1.0]")),
        (46, parameter("kind = \"stiffness\"\nrange = [0.0, 1.0]")),
        (47, text("representation = \"canonical\"\n") + &parameter("kind = \"alpha\"\nrange = [0.0, 1.0]")),
        (47, text("representation = \"parametric\"\n[basis]\nkind = \"pod\"")),
        (47, text("representation = \"parametric\"\n[basis]\nenergy = 0.5")),
        (47, text("representation = \"parametric\"\n[snapshots]\nnpy = \"a.npy\"")),
        (47, text("representation = \"parametric\"\n[time]\nscheme = { name = \"bathe\" }")),
        (48, text("[canonical]\npoints = 3")),
        (49, canonical("tolerance = 1.0")),
        (50, canonical("max_terms = 1")),
        (51, canonical("points = 1")),
        (52, canonical("margin = -0.1")),
        (53, canonical("positions = 0")),
        (54, canonical("load = [1.0, 2.0]")),
        (54, canonical("load = [0.0, 0.0]")),
        (55, canonical("direction = [0, 0, 0]")),
        (56, canonical("direction = [0, 0, 1]\ncomponents = true")),
        (57, matrices("[[mesh.region]]\nname = \"a\"\non = { group = \"a\" }")),
        (58, matrices(&format!("[[material]]\n{STEEL}"))),
        (87, matrices("").replace("[mesh]", "[mesh]\norder = \"quadratic\"")),
        (118, block("[1, 1, 1]", "[1, 1, 1]") + "cells = 401"),
        (118, matrices("").replace("[mesh]", "[mesh]\ncells = 20")),
        (88, block("[1, 1, 1]", "[1, 1, 1]") + "smallest_part = 1.5"),
        (88, matrices("").replace("[mesh]", "[mesh]\nsmallest_part = 0.1")),
        (59, matrices("[[support]]\non = { group = \"a\" }")),
        (60, matrices("[load]\n[[load.pattern]]\nname = \"a\"\npressure = 1.0\non = { group = \"a\" }")),
        // The same numbers, for what is too large or too small.
        (4, block("[1, 1, 1]", "[1, 1, 1]") + "scale = 1e40"),
        (5, block("[1e9, 0.1, 0.1]", "[1, 1, 1]")),
        (6, block("[1, 1, 1]", "[400000, 400000, 400000]")),
        (6, block("[1, 1, 1]", "[9223372036854775807, 9223372036854775807, 2]")),
        (8, material("1e-200", "0.3", "1.0")),
        (10, material("1.0", "0.3", "1e31")),
        (14, text("[damping]\nalpha = 1e40")),
        (15, text("[damping]\nbeta = 1e-40")),
        (20, pattern(&format!("name = \"{}\"\nacceleration = [0, 0, 1]", "a".repeat(1001)))),
        (21, pattern("name = \"a\"\nacceleration = [0, 0, 1e40]")),
        (22, probe(&format!("\"{}\"", "a".repeat(1001)), "[0, 0, 0]", "[0, 0, 1]")),
        (23, probe("\"a\"", "[0, 0, 1e40]", "[0, 0, 1]")),
        (24, probe("\"a\"", "[0, 0, 0]", "[0, 0, 1e100]")),
        (25, text("[time]\nstep = 1e300")),
        (27, text("[snapshots]\npositions = 1000000000000")),
        (28, text("[snapshots]\ndirections = [[0, 0, 1e100]]")),
        (29, text("[snapshots]\nhold = 1e40")),
        (30, text("[snapshots]\nduration = 1e40")),
        (33, text("[basis]\nmodes = 1000000")),
        (36, text("[basis]\noversampling = 1000000")),
        (41, text("[tolerance]\nmax_terms = 1000000")),
        (
            42,
            parameter("kind = \"alpha\"\nrange = [0.0, 1.0]")
                .replace("\"a\"", &format!("\"{}\"", "a".repeat(1001))),
        ),
        (46, parameter("kind = \"stiffness\"\nrange = [1e-300, 1e300]\nscale = \"log\"")),
        (46, parameter("kind = \"stiffness\"\nrange = [1e-4, 1e4]")),
        (50, canonical("max_terms = 1000000")),
        (52, canonical("margin = 1e9")),
        (53, canonical("positions = 1000000")),
        (89, POINT.replace("hub", "")),
        (90, POINT.replace("0.05, 0.05", "nan, 0.05")),
        (91, POINT.replace("[[reference_point]]", "[[coupling]]\nreference = \"hib\"\non = { group = \"x_max\" }\nkind = \"rigid\"\n[[reference_point]]")),
        (92, coupled("kind = \"rigid\"\ncomponents = []")),
        (92, coupled("kind = \"average\"\ncomponents = [\"x\"]")),
        (93, attached("[[tie]]\non = { group = \"x_max\" }\nto = { group = \"x_min\" }\ndistance = -1.0")),
        (94, attached("[[point_mass]]\nreference = \"hib\"\nmass = 1.0")),
        (95, attached("[[point_mass]]\nreference = \"hub\"\nmass = -1.0")),
        (96, attached("[[point_mass]]\nreference = \"hub\"\nmass = 1.0\ninertia = [1, 1, 1, 2, 0, 0]")),
        (97, attached("[[spring]]\nfrom = \"hib\"\nstiffness = [1, 1, 1, 0, 0, 0]")),
        (98, attached("[[spring]]\nfrom = \"hub\"\nto = \"hub\"\nstiffness = [1, 1, 1, 0, 0, 0]")),
        (99, attached("[[spring]]\nfrom = \"hub\"\nstiffness = [0, 0, 0, 0, 0, 0]")),
        (99, attached("[[spring]]\nfrom = \"hub\"\nstiffness = [-1, 0, 0, 0, 0, 0]")),
        (100, attached("[[spring]]\nfrom = \"hub\"\nstiffness = [1, 0, 0, 0, 0, 0]\naxes = [[1, 0, 0], [1, 1, 0]]")),
        (101, attached("[[load.pattern]]\nname = \"a\"\nreference = \"hub\"")),
        (101, attached("[[load.pattern]]\nname = \"a\"\nacceleration = [0, 0, 1]\nforce = [0, 0, 1]")),
        (102, attached("[[load.pattern]]\nname = \"a\"\nreference = \"hib\"\nforce = [0, 0, 1]")),
        (104, attached("[[equation]]\nterms = [[1, 1, 1.0]]")),
        (104, attached("[[equation]]\nterms = [[1, 4, 1.0], [2, 1, 1.0]]")),
        (104, attached("[[equation]]\nterms = [[1, 1, 0.0], [\"hub\", 1, 1.0]]")),
        (109, attached("[[dashpot]]\nfrom = \"hib\"\ndamping = [1, 0, 0, 0, 0, 0]")),
        (109, attached("[[dashpot]]\nfrom = \"hub\"\ndamping = [1, 0, 0, 0, 0, 0]")),
        (110, coupled(&format!("kind = \"rigid\"\n{DASHPOT}\nto = \"hub\""))),
        (111, coupled(&format!("kind = \"rigid\"\n{}", DASHPOT.replace("[1, ", "[-1, ")))),
        (112, coupled(&format!("kind = \"rigid\"\n{DASHPOT}\naxes = [[1, 0, 0], [1, 1, 0]]"))),
        (113, coupled(&format!("kind = \"rigid\"\n{DASHPOT}\n[time]\nstep = 1e-3\nscheme = {{ name = \"bathe\" }}"))),
        (
            113,
            coupled(&format!(
                "kind = \"rigid\"\n{DASHPOT}\n[[parameter]]\nname = \"k\"\nkind = \"stiffness\"\nrange = [0.5, 2.0]"
            )),
        ),
        (114, attached("[[coupling]]\nreference = \"hub\"\nkind = \"average\"")),
        (114, coupled("kind = \"average\"\nweights = [[1, 1.0]]")),
        (115, attached("[[coupling]]\nreference = \"hub\"\nkind = \"rigid\"\nweights = [[1, 1.0]]")),
        (115, attached("[[coupling]]\nreference = \"hub\"\nkind = \"average\"\nweights = [[1, 0.0]]")),
        (116, attached("[[spring]]\nfrom = \"hub\"")),
        (117, attached("[[spring]]\nfrom = \"hub\"\nmatrix = [1, 2, 3]")),
        (117, attached(&format!("[[spring]]\nfrom = \"hub\"\nmatrix = {}", UNIT.replacen("[1, 0", "[1, 2", 1)))),
        (100, attached(&format!("[[spring]]\nfrom = \"hub\"\nmatrix = {UNIT}\naxes = [[1, 0, 0], [0, 1, 0]]"))),
        (119, ground("")),
        (119, ground("damping_normal = 1.0\n[basis]\nkind = \"ritz\"")),
        (120, ground("normal = -1.0")),
        (120, ground("normal = 1e31")),
        (121, matrices("[output]\nembedded = \"skin.stl\"")),
        (105, "[[material]]\ndensity = 1.0".into()),
        (105, "[[material]]\nyoung = 1.0\ndensity = 1.0".into()),
        (105, format!("[[material]]\n{STEEL}\nstiffness = {UNIT}")),
        (106, "[[material]]\northotropic = { young = [1, 1, 1], poisson = [1.1, 0, 0], shear = [1, 1, 1] }\ndensity = 1.0".into()),
        (107, format!("[[material]]\nstiffness = {}\ndensity = 1.0", UNIT.replacen("[1, 0", "[1, 2", 1))),
        (108, format!("[[material]]\n{STEEL}\naxes = [[1, 0, 0], [0, 1, 0]]")),
        (108, format!("[[material]]\nstiffness = {UNIT}\naxes = [[1, 0, 0], [1, 1, 0]]\ndensity = 1.0")),
        (80, format!("model = \"large-displacement\"\n{HELD}[[material]]\nstiffness = {UNIT}\ndensity = 1.0")),
        (103, coupled("kind = \"rigid\"\n[base]\nmoves = true")),
        (54, canonical("load = [0.0, 1e40]")),
        (122, prestressed("")),
        (122, prestressed("loads = { a = 1.0 }").replace(HELD, "")),
        (122, prestressed("loads = { a = 1.0 }\n[base]\nmoves = true")),
        (122, format!("model = \"large-displacement\"\n{}", prestressed("loads = { a = 1.0 }"))),
        (122, prestressed("speed = 1.0\naxis = [1, 0, 0]\n[[parameter]]\nname = \"k\"\nkind = \"density\"\nrange = [0.5, 2.0]")),
        (122, live("kind = \"stiffness\"\nattachment = \"mount\"") + "[prestress]\nacceleration = [0, 0, 1]\n"),
        (122, matrices("[prestress]\nacceleration = [0, 0, 1]")),
        (122, format!("representation = \"chapter\"\n{}", prestressed("acceleration = [0, 0, 1]"))),
        (123, prestressed("loads = { b = 1.0 }")),
        (123, prestressed("loads = { a = inf }")),
        (124, prestressed("acceleration = [0, 0, 1]\naxis = [1, 0, 0]")),
        (124, prestressed("acceleration = [0, 0, 1]\npoint = [1, 0, 0]")),
        (124, prestressed("speed = 1.0")),
        (124, prestressed("speed = 1.0\naxis = [0, 0, 0]")),
        (125, prestressed("speed = 0.0\naxis = [1, 0, 0]")),
        (
            125,
            attached(
                "[[coupling]]\nreference = \"hub\"\non = { group = \"x_max\" }\nkind = \"rigid\"\n[[point_mass]]\nreference \
                 = \"hub\"\nmass = 1.0\ninertia = [1, 1, 1, 0, 0, 0]\n[prestress]\nspeed = 1.0\naxis = [1, 0, 0]",
            ),
        ),
        (126, prestressed("acceleration = [0, 0, inf]")),
        (127, prestressed("speed = 1.0\naxis = [1, 0, 0]\npoint = [nan, 0, 0]")),
        (128, heated("", "").replace("expansion = 1e-5\n", "")),
        (128, heated("", "[output]\nstress = \"surface\"\nresidual = false")),
        (128, heated("", "[[parameter]]\nname = \"k\"\nkind = \"stiffness\"\nrange = [0.5, 2.0]")),
        (128, heated("representation = \"chapter\"", "")),
        (128, heated("model = \"large-displacement\"", "")),
        (129, heated("", "").replace("1e-5", "[1e-5, 1e-5, inf]")),
        (130, port("name = \"a,b\"\non = { group = \"x_max\" }")),
        (130, port("name = \"\"\non = { group = \"x_max\" }")),
        (131, port("name = \"a\"\nreference = \"hub\"")),
        (131, port("name = \"a\"\nkind = \"frame\"\nreference = \"hib\"")),
        (131, attached("[[port]]\nname = \"a\"\nkind = \"frame\"\nreference = \"hub\"")),
        (132, port("name = \"a\"")),
        (133, port("name = \"a\"\non = { group = \"x_max\" }\nat = [0, 0, 0]")),
        (134, port("name = \"a\"\non = { group = \"x_max\" }\naxes = [[1, 0, 0], [0, 1, 0]]")),
        (134, port("name = \"a\"\nkind = \"frame\"\non = { group = \"x_max\" }\naxes = [[1, 0, 0], [1, 1, 0]]")),
        (135, port("name = \"a\"\non = { group = \"x_max\" }\n[basis]\nkind = \"ritz\"")),
        (135, format!("model = \"large-displacement\"\n{}", port("name = \"a\"\non = { group = \"x_max\" }"))),
        (136, patch("contact_patch = 0.0")),
        (136, patch("contact_patch = 1e40")),
        (136, patch("contact_patch = 0.1\nresidual = false")),
        (136, patch("contact_patch = 0.1\n[basis]\nkind = \"ritz\"")),
        (136, patch("contact_patch = 0.1\n[time]\nscheme = { name = \"bathe\" }")),
        (136, format!("model = \"large-displacement\"\n{}", patch("contact_patch = 0.1"))),
        (136, matrices("[output]\ncontact_patch = 0.1")),
        (137, patch("contact_patch = 0.1\ncontact_modes = 513")),
        (137, patch("contact_modes = 8")),
        (137, many_parameters(1) + &patch("contact_patch = 0.1\ncontact_modes = 8")),
        (138, live("kind = \"stiffness\"\nattachment = \"mont\"")),
        (138, live("kind = \"density\"\nattachment = \"mount\"")),
        (138, live("kind = \"stiffness\"\nattachment = \"mount\"\nregion = \"body\"")),
        (138, live("kind = \"mass\"")),
        (139, format!("{HELD}[[material]]\n{STEEL}loss_factor = 0.1\n[time]\nscheme = {{ name = \"bathe\" }}")),
        (139, format!("model = \"large-displacement\"\n{HELD}[[material]]\n{STEEL}loss_factor = 0.1")),
        (61, format!("title = \"{}\"", "a".repeat(1001))),
        (62, format!("units = \"{}\"", "a".repeat(1001))),
        (63, text("representation = \"separated\"\n") + &many_parameters(17)),
        (63, many_parameters(1025)),
        (64, text("[basis]\nkind = \"ritz\"\nerror = 0.1")),
        (65, text("[basis]\nkind = \"modes\"\nmodes = 4\nerror = 0.1")),
    ]
}

/// A dashpot to the ground.
const DASHPOT: &str = "[[dashpot]]\nfrom = \"hub\"\ndamping = [1, 0, 0, 0, 0, 0]";

/// Upper triangle of a unit matrix.
const UNIT: &str = "[1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 1]";

/// A support.
const HELD: &str = "[[support]]\non = { group = \"x_min\" }\n";

/// A reference point.
const POINT: &str = "[[reference_point]]\nname = \"hub\"\nat = [1.0, 0.05, 0.05]\n";

/// A body on a named spring, with a live parameter of these keys.
fn live(keys: &str) -> String {
    let spring = "[[coupling]]\nreference = \"hub\"\non = { group = \"x_max\" }\nkind = \"rigid\"\n[[spring]]\nname = \
                  \"mount\"\nfrom = \"hub\"\nstiffness = [1, 0, 0, 0, 0, 0]\n";
    attached(&format!("{spring}[[parameter]]\nname = \"p\"\nrange = [0.5, 2.0]\n{keys}\n"))
}

/// A held body with a reference point and these tables.
fn attached(tables: &str) -> String {
    format!("{HELD}{POINT}{tables}")
}

/// The same with a coupling that has these keys.
fn coupled(keys: &str) -> String {
    attached(&format!("[[coupling]]\nreference = \"hub\"\non = {{ group = \"x_max\" }}\n{keys}"))
}

/// A held body with a port that has these keys.
fn port(keys: &str) -> String {
    format!("{HELD}[[port]]\n{keys}")
}

/// A held body whose output has these keys.
fn patch(keys: &str) -> String {
    format!("{HELD}[output]\n{keys}")
}

/// A held body on a foundation that has these keys.
fn ground(keys: &str) -> String {
    format!("{HELD}[[foundation]]\non = {{ group = \"z_min\" }}\n{keys}")
}

/// A held body with a load pattern `a` and these keys of a prestress.
fn prestressed(keys: &str) -> String {
    format!("{HELD}[[load.pattern]]\nname = \"a\"\nacceleration = [0, 0, 1]\n[prestress]\n{keys}\n")
}

/// A held body of a material that expands, under a temperature, with these tables around.
fn heated(before: &str, after: &str) -> String {
    let pattern = "[[load.pattern]]\nname = \"a\"\ntemperature = 10.0\n";
    format!("{before}\n{HELD}[[material]]\n{STEEL}expansion = 1e-5\n{pattern}{after}\n")
}

/// So many live parameters.
fn many_parameters(count: usize) -> String {
    let one = |i: usize| {
        format!("[[parameter]]\nname = \"{i}\"\nkind = \"density\"\nregion = \"{i}\"\nrange = [0.5, 2.0]\n")
    };
    (0..count).map(one).collect()
}

#[test]
fn every_refusal_of_a_problem_happens_and_names_its_key() {
    let rows = refusals(&page("problem-1.md"));
    assert!(matches!(
        Problem::read(&PathBuf::from("no such file")),
        Err(ProblemError::Toml(TomlError::Unreadable { .. }))
    ));
    for text in ["no TOML", "colour = 1", "[time]\nstep = \"1\"", "[[support]]\non = {}"] {
        assert!(
            matches!(problem(&whole(text)), Err(ProblemError::Toml(TomlError::Malformed { .. }))),
            "{text}"
        );
    }
    let bad = bad_problems();
    for (number, fragment) in &bad {
        let (_, key) = rows.iter().find(|(n, _)| n == number).expect("a row of the page");
        let error = problem(&whole(fragment)).map(|_| ()).expect_err(fragment).to_string();
        let key = key.split_once("`, `").map_or(key.as_str(), |(first, _)| first);
        assert!(error.contains(&format!("`{key}`")) && error.contains("page.toml"), "{number}: {error}");
    }
    for (number, _) in rows.iter().filter(|(n, _)| *n > 2) {
        assert!(bad.iter().any(|(n, _)| n == number), "refusal {number} has no example here");
    }
}

#[test]
fn every_refusal_of_a_scenario_happens_and_names_its_key() {
    let contact = "[[contact]]\npoint = [0, 0, 0]\nforce = [0, 0, 1]\n";
    let probe = |name: &str, point: &str, direction: &str| {
        format!("duration = 1.0\n[[output.probe]]\nname = {name}\npoint = {point}\ndirection = {direction}\n")
    };
    let many = "[[output.probe]]\nname = \"a\"\npoint = [0, 0, 0]\ndirection = [0, 0, 1]\n";
    let bad = [
        (3, "duration = 0.0".to_string()),
        (4, "duration = 1.0\n[output]\nprobes_every = 0".into()),
        (5, "duration = 1.0\n[[contact]]\npoint = [0, 0, nan]\nforce = [0, 0, 1]".into()),
        (6, format!("duration = 1.0\n{contact}start = 1.0\nend = 0.5")),
        (6, format!("duration = 1.0\n{contact}ramp = -1.0")),
        (7, "duration = 1.0\n[[pattern]]\nname = \"a\"\namplitude = inf".into()),
        (8, "duration = 1.0\n[[pattern]]\nname = \"a\"\nramp = -1.0".into()),
        (9, format!("duration = 1.0\n{}", contact.repeat(100_001))),
        (10, "duration = 1.0\n[[contact]]\nforce = [0, 0, 1]".into()),
        (10, format!("duration = 1.0\n{contact}path = [[0, 0, 0, 0], [1, 1, 0, 0]]")),
        (10, "duration = 1.0\n[[contact]]\npoint = [0, 0, 0]".into()),
        (10, format!("duration = 1.0\n{contact}table = [[0, 0], [1, 1]]\nchirp = {{ from = 1, to = 2 }}")),
        (11, format!("duration = 1.0\n{contact}ramp = 0.1\ntable = [[0, 0], [1, 1]]")),
        (12, format!("duration = 1.0\n{contact}table = [[0, 0], [1, inf]]")),
        (12, format!("duration = 1.0\n{contact}table = [[1, 0], [0, 1]]")),
        (12, format!("duration = 1.0\n{contact}table = [[0, 0, 0, 0], [1, 1, 1, 1]]")),
        (
            12,
            format!("duration = 1.0\n{contact}table = [[0, 0], [1, 1e75], [2, 2e74]]")
                .replace("1]\nt", "9]\nt"),
        ),
        (13, "duration = 1.0\n[[contact]]\nforce = [0, 0, 1]\npath = [[0, 0, 0, 0], [0, 1, 0, 0]]".into()),
        (14, format!("duration = 1.0\n{contact}sinusoid = {{ frequency = -1.0 }}")),
        (15, format!("duration = 1.0\n{contact}chirp = {{ from = 1.0, to = inf }}")),
        (16, "duration = 1.0\n[[pattern]]\nname = \"a\"\ntable = [[0, 0, 0, 0], [1, 1, 1, 1]]".into()),
        (17, probe("\"a,b\"", "[0, 0, 0]", "[0, 0, 1]")),
        (18, probe("\"a\"", "[0, 0, inf]", "[0, 0, 1]")),
        (19, probe("\"a\"", "[0, 0, 0]", "[0, 0, 0]")),
        (20, format!("duration = 1.0\n{}", many.repeat(10_001))),
        (21, "duration = 1.0\n[base]\nrecord = [[0, 1, 2], [1, 2, 3]]".into()),
        (21, "duration = 1.0\n[base]\nrecord = [[0, 1, 2, 3]]".into()),
        (21, "duration = 1.0\n[base]\nrecord = [[0,0,0,0,1e80,0,0,0,0,0], [1,0,0,0,0,0,0,0,0,0]]".into()),
        (
            25,
            format!(
                "duration = 1.0\n{}",
                many.replace("output.probe", "output.stress")
                    .replace("direction = [0, 0, 1]", "")
                    .repeat(10_001)
            ),
        ),
        (23, "duration = 1.0\n[[output.stress]]\nname = \"a,b\"\npoint = [0, 0, 0]".into()),
        (24, "duration = 1.0\n[[output.stress]]\nname = \"a\"\npoint = [0, inf, 0]".into()),
        (22, "duration = 1.0\n[base]\namplitude = inf\nrecord = [[0, 0, 0, 0], [1, 1, 1, 1]]".into()),
        (26, "duration = 1.0\n[free]\nvelocity = [0, inf, 0]".into()),
        (26, "duration = 1.0\n[free]\nvelocity = [0, 2e9, 0]".into()),
    ];
    let rows = refusals(&page("scenario-1.md"));
    assert!(matches!(
        Scenario::read(&PathBuf::from("no such file")),
        Err(ScenarioError(TomlError::Unreadable { .. }))
    ));
    for text in ["duration", "", "duration = 1.0\ncolour = 1"] {
        assert!(
            matches!(Scenario::parse(text, "page.toml"), Err(ScenarioError(TomlError::Malformed { .. }))),
            "{text}"
        );
    }
    for (number, text) in &bad {
        let (_, key) = rows.iter().find(|(n, _)| n == number).expect("a row of the page");
        let error = Scenario::parse(text, "page.toml").map(|_| ()).expect_err(text).to_string();
        let key = key.split_once("`, `").map_or(key.as_str(), |(first, _)| first);
        assert!(error.contains(&format!("`{key}`")) && error.contains("page.toml"), "{number}: {error}");
    }
    for (number, _) in rows.iter().filter(|(n, _)| *n > 2) {
        assert!(bad.iter().any(|(n, _)| n == number), "refusal {number} has no example here");
    }
}

fn assembly(text: &str) -> Result<AssemblyFile, TomlError> {
    AssemblyFile::parse(text, "page.toml", PathBuf::new())
}

#[test]
fn every_example_of_an_assembly_is_one() {
    let page = page("assembly-1.md");
    let examples = examples(&page);
    assert!(examples.len() >= 2);
    for example in examples {
        assembly(example).unwrap_or_else(|error| panic!("{error}\n{example}"));
    }
}

/// An assembly for each refusal of the page from number 3 on.
fn bad_assemblies() -> Vec<(usize, String)> {
    let part = |name: &str, rest: &str| format!("[[part]]\nname = \"{name}\"\n{rest}\n");
    let file = "file = \"a.vdm\"";
    let of = |parts: &str, rest: &str| format!("format = 1\n{parts}{rest}\n");
    let one = |keys: &str| of(&part("a", &format!("{file}\n{keys}")), "");
    let world = "[world]\ntime = 1.0\n";
    let rigid = |keys: &str| {
        of(&format!("{}{}", part("a", &format!("rigid = {{ {keys} }}")), part("b", file)), world)
    };
    let block = "box = { lengths = [1, 1, 1] }";
    let two = format!("{}{}", part("a", file), part("b", file));
    let between = "between = [\"a.x\", \"b.x\"]";
    let joint = |keys: &str| of(&two, &format!("[[joint]]\n{between}\n{keys}"));
    let in_world = |rest: &str| of(&two, &format!("{world}{rest}"));
    let contact = |keys: &str| in_world(&format!("[[contact]]\nbetween = [\"a\", \"b\"]\n{keys}"));
    let output = |keys: &str| in_world(&format!("[[output]]\n{keys}"));
    let of_world = |keys: &str| of(&two, &format!("[world]\n{keys}"));
    vec![
        (3, one("").replace("format = 1", "format = 2")),
        (4, "format = 1\npart = []".into()),
        (5, one("").replace("format = 1", "format = 1\nstep = 0.0")),
        (6, of(&part("ground", file), "")),
        (6, of(&part("a.b", file), "")),
        (6, of(&part("a", ""), "")),
        (7, of(&part("a", &format!("{file}\nrigid = {{ {block} }}")), world)),
        (8, of(&part("a", &format!("hash = \"00\"\nrigid = {{ {block} }}")), world)),
        (9, one("position = [0, 0, inf]")),
        (10, one("rotation = [1.0, 1.0, 0.0, 0.0]")),
        (11, of(&part("a", &format!("velocity = [1, 0, 0]\nrigid = {{ {block} }}")), world)),
        (12, of(&part("a", &format!("rigid = {{ {block} }}")), "")),
        (12, rigid("density = 1.0")),
        (12, rigid(&format!("{block}, surface = \"a.stl\""))),
        (13, rigid("box = { lengths = [1, 0, 1] }")),
        (14, rigid(&format!("{block}, density = 0.0"))),
        (15, of(&two, &format!("[[joint]]\nkind = \"weld\"\n{between}\nname = \"j\"\n").repeat(2))),
        (16, joint("kind = \"bushing\"")),
        (16, joint("kind = \"weld\"\nstiffness = [1.0]")),
        (16, joint("kind = \"spring\"\nstiffness = [0.0]")),
        (17, joint("kind = \"weld\"\ndistance = -1.0")),
        (18, joint("kind = \"weld\"\nturns = true")),
        (18, joint("kind = \"ball\"\nturns = true")),
        (19, joint("kind = \"weld\"\nlength = 1.0")),
        (20, joint("kind = \"weld\"\nat = [0, 0, 0]")),
        (21, joint("kind = \"cable\"")),
        (21, in_world(&format!("[[joint]]\nkind = \"ball\"\n{between}"))),
        (22, of(&two, "[[contact]]\nbetween = [\"a\", \"b\"]")),
        (22, in_world("[[contact]]\nbetween = [\"a\", \"c\"]")),
        (22, in_world("[[contact]]\nbetween = [\"a\", \"a\"]")),
        (23, contact("friction = -0.1")),
        (24, contact("restitution = 1.1")),
        (25, output("part = \"c\"")),
        (25, of(&two, "[[output]]\npart = \"a\"")),
        (26, output("part = \"a\"\nname = \"a,b\"")),
        (27, output("part = \"a\"\npoint = [0, 0, inf]")),
        (28, of_world("time = 0.0")),
        (29, of_world("time = 1.0\nstep = -1.0")),
        (29, of_world("time = 1.0\nstep = 1.0").replace("format = 1", "format = 1\nstep = 1.0")),
        (30, of_world("time = 1.0\ngravity = [0, 0, nan]")),
        (31, of_world("time = 1.0\nreach = -1.0")),
        (32, of_world("time = 1.0\nsweeps = 0")),
        (33, of_world("time = 1.0\ncontacts = 0")),
        (34, of(&part("a", &format!("{file}\ncopies = [1, 0, 1]")), world)),
        (34, of(&part("a", &format!("{file}\ncopies = [100, 100, 2]")), world)),
        (34, one("copies = [2, 1, 1]")),
        (35, of(&part("a", &format!("{file}\ncopies = [2, 1, 1]\nspacing = [inf, 0, 0]")), world)),
        (35, one("spacing = [1, 0, 0]")),
        (36, of(&part("a", &format!("{file}\npath = [[0, 0, 0, 0], [0, 1, 0, 0]]")), world)),
        (36, of(&part("a", &format!("{file}\npath = []")), world)),
        (36, one("path = [[0, 0, 0, 0]]")),
        (
            36,
            rigid(&format!(
                "{block}, density = 1.0 }}\npath = [[0, 0, 0, 0]]\nshake = {{ amplitude = [0, 0, 0], frequency = 1.0"
            )),
        ),
        (37, one("shake = { amplitude = [0, 0, 1], frequency = 1.0 }")),
        (38, of(&part("a", &format!("{file}\nshake = {{ amplitude = [0, 0, inf], frequency = 1 }}")), world)),
        (39, of(&part("a", &format!("{file}\nshake = {{ amplitude = [0, 0, 1], frequency = -1 }}")), world)),
        (
            40,
            of(
                &part("a", &format!("{file}\nshake = {{ amplitude = [0, 0, 1], frequency = 1, ramp = -1 }}")),
                world,
            ),
        ),
        (41, joint("kind = \"weld\"\nbreaks_at = 1.0")),
        (41, in_world(&format!("[[joint]]\nkind = \"ball\"\nturns = true\nbreaks_at = 0.0\n{between}"))),
    ]
}

#[test]
fn every_refusal_of_an_assembly_happens_and_names_its_key() {
    let rows = refusals(&page("assembly-1.md"));
    let missing = AssemblyFile::read(&PathBuf::from("no such file"));
    assert!(matches!(missing, Err(TomlError::Unreadable { .. })));
    for text in ["format", "", "format = 1\npart = []\ncolour = 1"] {
        assert!(matches!(assembly(text), Err(TomlError::Malformed { .. })), "{text}");
    }
    let bad = bad_assemblies();
    for (number, text) in &bad {
        let (_, key) = rows.iter().find(|(n, _)| n == number).expect("a row of the page");
        let error = assembly(text).map(|_| ()).expect_err(text).to_string();
        // An entry may be any of its list.
        let plain = |text: &str| text.replace("[1]", "[0]");
        let named = plain(&error).contains(&format!("`{key}`"));
        assert!(named && error.contains("page.toml"), "{number}: {error}");
    }
    for (number, _) in rows.iter().filter(|(n, _)| *n > 2) {
        assert!(bad.iter().any(|(n, _)| n == number), "refusal {number} has no example here");
    }
}
