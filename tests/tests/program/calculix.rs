//! Attachments, axes of materials and masses of elements against CalculiX: the same deck by both programs.
//!
//! Frequencies agree to the seven digits that CalculiX prints. Without CalculiX the tests are skipped, except
//! in CI. With `--nocapture` they print the table of `docs/measurements/engineering.md`.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;

use vademecum_tests::program::vademecum;
use vademecum_tests::witness::calculix::{self, Tables, is_there};

/// Corners of a brick, and its edges in the order of the middles.
const CORNERS: [[usize; 3]; 8] =
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
const EDGES: [[usize; 2]; 12] =
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];

/// A bar of bricks of 20 nodes from `from` on: cards, and the number of each place.
struct Bar {
    cards: String,
    numbers: HashMap<[usize; 3], usize>,
}

impl Bar {
    fn new(cells: [usize; 3], from: f64, first: usize, set: &str) -> Bar {
        let size = [1.0, 0.1, 0.06];
        let (mut numbers, mut nodes, mut elements) = (HashMap::new(), String::new(), String::new());
        let mut number = |at: [usize; 3]| {
            let next = first + numbers.len();
            *numbers.entry(at).or_insert_with(|| {
                let x: [f64; 3] = std::array::from_fn(|c| size[c] * at[c] as f64 / (2 * cells[c]) as f64);
                writeln!(nodes, "{next},{:.12e},{:.12e},{:.12e}", from + x[0], x[1], x[2]).unwrap();
                next
            })
        };
        let mut count = first;
        for i in 0..cells[0] {
            for j in 0..cells[1] {
                for k in 0..cells[2] {
                    let corners = CORNERS.map(|c| [2 * (i + c[0]), 2 * (j + c[1]), 2 * (k + c[2])]);
                    let middles =
                        EDGES.map(|[a, b]| std::array::from_fn(|c| (corners[a][c] + corners[b][c]) / 2));
                    let all: Vec<String> =
                        corners.into_iter().chain(middles).map(|at| number(at).to_string()).collect();
                    writeln!(elements, "{count},{},\n{}", all[..10].join(","), all[10..].join(",")).unwrap();
                    count += 1;
                }
            }
        }
        let cards = format!("*NODE,NSET=N{set}\n{nodes}*ELEMENT,TYPE=C3D20,ELSET={set}\n{elements}");
        Bar { cards, numbers }
    }

    /// Nodes of a cross-section.
    fn section(&self, i: usize) -> Vec<usize> {
        let mut nodes: Vec<usize> =
            self.numbers.iter().filter(|(at, _)| at[0] == i).map(|(_, &node)| node).collect();
        nodes.sort_unstable();
        nodes
    }
}

fn set(name: &str, nodes: &[usize]) -> String {
    nodes.iter().fold(format!("*NSET,NSET={name}\n"), |text, node| text + &format!("{node}\n"))
}

/// Cards that a case adds to the bar.
#[derive(Default)]
struct Case {
    name: &'static str,
    /// A second bar, and sets and nodes.
    more: String,
    attached: String,
    /// Forces of the static step; those of the plain bar if absent.
    forces: Option<String>,
    /// Sets whose displacements are printed, beside the bar.
    printed: &'static str,
}

const STEEL: &str = "*MATERIAL,NAME=M\n*ELASTIC\n2.1e11,.3\n*DENSITY\n7850\n";

impl Case {
    fn deck(&self, bar: &Bar) -> String {
        let tip = bar.numbers[&[8, 4, 2]];
        let usual = format!("{tip},2,100.\n{tip},3,-300.\n");
        let second =
            if self.more.contains("ELSET=BAR2") { "*SOLID SECTION,ELSET=BAR2,MATERIAL=M\n" } else { "" };
        format!(
            "{}{}{}{}*NSET,NSET=PRINTED\nNBAR\n{}{}{STEEL}*SOLID SECTION,ELSET=BAR,MATERIAL=M\n{second}\
             *BOUNDARY\nLEFT,1,3\n*STEP\n*FREQUENCY\n6\n*END STEP\n*STEP\n*STATIC\n*CLOAD\n{}\
             *NODE PRINT,NSET=PRINTED,GLOBAL=YES\nU\n*END STEP\n",
            bar.cards,
            set("LEFT", &bar.section(0)),
            set("RIGHT", &bar.section(8)),
            self.more,
            self.printed,
            self.attached,
            self.forces.as_deref().unwrap_or(&usual)
        )
    }
}

fn cases(bar: &Bar) -> Vec<Case> {
    let at = |i: usize, j: usize, k: usize| bar.numbers[&[i, j, k]];
    let (tip, middle, other) = (at(8, 4, 2), at(4, 4, 0), at(2, 0, 2));
    let point = "*NODE\n9000,1.2,.07,.04\n";
    let end = "*ELSET,ELSET=LAST\n7\n8\n*SURFACE,NAME=END\nLAST,S4\n";
    let mass = "*ELEMENT,TYPE=MASS,ELSET=EM\n9900,9000\n*MASS,ELSET=EM\n15.\n";
    let pulled = || Some("9000,2,100.\n9000,3,-300.\n".to_string());
    let element = |kind: &str, nodes: &[usize], card: &str| {
        let nodes: Vec<String> = nodes.iter().map(usize::to_string).collect();
        format!("*ELEMENT,TYPE={kind},ELSET=EA\n9900,{}\n*{card}", nodes.join(","))
    };
    let second = Bar::new([3, 3, 2], 1.0, 2001, "BAR2");
    let faces: String = (2001..2007).map(|element| format!("{element},S6\n")).collect();
    let weights: String = bar.section(8).iter().map(|node| format!("{node},{}.\n", 1 + node % 3)).collect();
    let alone = |name, attached| Case { name, attached, ..Case::default() };
    vec![
        alone("none", String::new()),
        alone("*MASS", element("MASS", &[tip], "MASS,ELSET=EA\n15.\n")),
        alone("*SPRING, SPRINGA", element("SPRINGA", &[tip, other], "SPRING,ELSET=EA\n\n3.e7\n")),
        alone("*SPRING, SPRING1", element("SPRING1", &[tip], "SPRING,ELSET=EA\n3\n2.e6\n")),
        alone("*SPRING, SPRING2", element("SPRING2", &[tip, middle], "SPRING,ELSET=EA\n2,3\n2.e7\n")),
        Case {
            name: "*RIGID BODY, mass",
            more: point.into(),
            attached: format!("*RIGID BODY,NSET=RIGHT,REF NODE=9000\n{mass}"),
            forces: pulled(),
            printed: "9000\n",
        },
        Case {
            name: "*KINEMATIC, mass",
            more: format!("{point}{end}"),
            attached: format!(
                "*COUPLING,REF NODE=9000,SURFACE=END,CONSTRAINT NAME=C\n*KINEMATIC\n1,3\n{mass}"
            ),
            forces: pulled(),
            printed: "9000\n",
        },
        Case {
            name: "*DISTRIBUTING COUPLING",
            more: format!("{point}*ELEMENT,TYPE=DCOUP3D,ELSET=DC\n9950,9000\n"),
            attached: format!("*DISTRIBUTING COUPLING,ELSET=DC\n{weights}"),
            forces: pulled(),
            printed: "9000\n",
        },
        Case {
            name: "*EQUATION",
            attached: format!(
                "*EQUATION\n2\n{tip},3,1.,{middle},3,-.5\n3\n{},2,1.,{},2,1.,{other},1,.7\n",
                at(8, 0, 0),
                at(8, 0, 2)
            ),
            ..Case::default()
        },
        Case {
            name: "*TRANSFORM, *BOUNDARY",
            more: set("TURNED", &[at(8, 0, 0), at(8, 0, 2)]),
            attached: "*TRANSFORM,NSET=TURNED,TYPE=R\n1.,1.,0.,-1.,1.,0.\n*BOUNDARY\nTURNED,1,1\n".into(),
            ..Case::default()
        },
        Case {
            name: "*TIE, other mesh",
            more: format!("{}{end}*SURFACE,NAME=BEGIN\n{faces}", second.cards),
            attached: "*TIE,NAME=T,POSITION TOLERANCE=.001\nBEGIN,END\n".into(),
            forces: Some(format!("{},3,-200.\n", second.numbers[&[6, 0, 4]])),
            printed: "NBAR2\n",
        },
    ]
}

/// Largest deviation of six frequencies, and that of the largest displacement.
fn compare(folder: &Path, job: &str, deck: &str) -> [f64; 2] {
    let path = folder.join(format!("{job}.inp"));
    std::fs::write(&path, deck).unwrap();
    let Tables { frequencies, displacements, said } = calculix::answer(folder, job);
    assert!(frequencies.len() >= 6, "{job}: {said}");
    let displacements: HashMap<u64, [f64; 3]> = displacements.into_iter().collect();
    let answer = |command: &[&str]| {
        let ran = vademecum(&[command, &["--dialect", "calculix", "--json"]].concat());
        assert_eq!(ran.code, Some(0), "{job}: {}", ran.stderr);
        ran.json()
    };
    let path = path.to_str().unwrap();
    let modes = answer(&["modes", path, "--count", "6"]);
    let found = modes["frequencies_hz"].as_array().unwrap().iter().map(|hz| hz.as_f64().unwrap());
    let off = found.zip(&frequencies).map(|(found, hz)| (found / hz - 1.0).abs()).fold(0.0, f64::max);
    let step = &answer(&["static", path])["steps"][0];
    let theirs = displacements[&step["node"].as_u64().unwrap()];
    let largest = step["largest_displacement"].as_f64().unwrap();
    let apart = (0..3).map(|c| (step["displacement"][c].as_f64().unwrap() - theirs[c]).abs());
    [off, apart.fold(0.0, f64::max) / largest]
}

#[test]
fn attachments_are_those_of_calculix() {
    if !is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let bar = Bar::new([4, 2, 1], 0.0, 1, "BAR");
    println!("| attached | frequencies | displacement |\n|---|---|---|");
    for case in cases(&bar) {
        let [frequencies, displacement] = compare(folder.path(), "bar", &case.deck(&bar));
        println!("| {} | {frequencies:.0e} | {displacement:.0e} |", case.name);
        // Seven digits are printed, the first of which may be a one.
        assert!(frequencies < 1e-6 && displacement < 1e-6, "{}: {frequencies:e} {displacement:e}", case.name);
    }
}

#[test]
fn free_bodies_with_attachments_are_those_of_calculix() {
    if !is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let bar = Bar::new([4, 2, 1], 0.0, 1, "BAR");
    let free = |case: &Case| {
        let deck = case.deck(&bar).replace("*BOUNDARY\nLEFT,1,3\n", "");
        let (deck, _) = deck.split_once("*STEP\n*STATIC").expect("a static step");
        deck.replace("*FREQUENCY\n6\n", "*FREQUENCY\n12\n")
    };
    let held = ["*SPRING, SPRING1", "*SPRING, SPRING2", "*EQUATION", "*TRANSFORM, *BOUNDARY"];
    let cases = cases(&bar).into_iter().filter(|case| !held.contains(&case.name));
    let mut compared = 0;
    for case in cases {
        let (job, name) = ("free", case.name);
        let path = folder.path().join("free.inp");
        std::fs::write(&path, free(&case)).unwrap();
        let Tables { frequencies, said, .. } = calculix::answer(folder.path(), job);
        assert!(frequencies.len() >= 12, "{name}: {said}");
        let path = path.to_str().unwrap();
        let ran = vademecum(&["modes", path, "--count", "6", "--dialect", "calculix", "--json"]);
        assert_eq!(ran.code, Some(0), "{name}: {}", ran.stderr);
        let modes = ran.json();
        assert_eq!(modes["rigid_motions"], 6, "{name}");
        let found = modes["frequencies_hz"].as_array().unwrap().iter().map(|hz| hz.as_f64().unwrap());
        let off = found.zip(&frequencies[6..]).map(|(found, hz)| (found / hz - 1.0).abs());
        let off = off.fold(0.0, f64::max);
        println!("| {name}, free | {off:.0e} | |");
        assert!(off < 1e-6, "{name}: {off:e}, {frequencies:?}");
        compared += 1;
    }
    assert_eq!(compared, 7);
}

/// A quarter of a ring of `kind`, its wood turning about the axis, as a deck with one static step.
fn ring(kind: &str) -> String {
    let cells = [2, 6, 2];
    let quadratic = kind.starts_with("C3D20");
    let step = if quadratic { 1 } else { 2 };
    let (mut numbers, mut nodes, mut elements): (HashMap<[usize; 3], usize>, _, _) =
        (HashMap::new(), String::new(), String::new());
    let mut number = |at: [usize; 3]| {
        let next = 1 + numbers.len();
        *numbers.entry(at).or_insert_with(|| {
            let [i, j, k] = [0, 1, 2].map(|c| at[c] as f64 / (2 * cells[c]) as f64);
            let (r, t, z) = (1.0 + 0.4 * i, 1.4 * j, 0.1 + 0.6 * k);
            writeln!(nodes, "{next},{:.12e},{:.12e},{z:.12e}", 0.3 + r * t.cos(), r * t.sin() - 0.2).unwrap();
            next
        })
    };
    let mut ends = [vec![], vec![]];
    let mut count = 0;
    for i in 0..cells[0] {
        for j in 0..cells[1] {
            for k in 0..cells[2] {
                let corners = CORNERS.map(|c| [2 * (i + c[0]), 2 * (j + c[1]), 2 * (k + c[2])]);
                let middles =
                    EDGES.map(|[a, b]| std::array::from_fn(|c| (corners[a][c] + corners[b][c]) / 2));
                let places: Vec<[usize; 3]> =
                    corners.into_iter().chain(middles.into_iter().filter(|_| step == 1)).collect();
                let all: Vec<String> = places.iter().map(|&at| number(at).to_string()).collect();
                count += 1;
                let rows: Vec<String> = all.chunks(10).map(|row| row.join(",")).collect();
                writeln!(elements, "{count},{}", rows.join(",\n")).unwrap();
                for (place, node) in places.iter().zip(all) {
                    if place[1] == 0 || place[1] == 2 * cells[1] {
                        ends[usize::from(place[1] > 0)].push(node.parse().unwrap());
                    }
                }
            }
        }
    }
    ends.iter_mut().for_each(|end: &mut Vec<usize>| {
        end.sort_unstable();
        end.dedup();
    });
    format!(
        "*NODE,NSET=ALL\n{nodes}*ELEMENT,TYPE={kind},ELSET=RING\n{elements}{}{}*MATERIAL,NAME=WOOD\n\
         *ELASTIC,TYPE=ENGINEERING CONSTANTS\n11.6e9,.9e9,.5e9,.37,.42,.47,.75e9,.72e9,\n.039e9,0\n\
         *DENSITY\n450\n*ORIENTATION,NAME=TURN,SYSTEM=CYLINDRICAL\n.3,-.2,0.,.3,-.2,1.\n\
         *SOLID SECTION,ELSET=RING,MATERIAL=WOOD,ORIENTATION=TURN\n*BOUNDARY\nHELD,1,3\n\
         *STEP\n*FREQUENCY\n6\n*END STEP\n*STEP\n*STATIC\n*CLOAD\nEND,3,10.\nEND,1,5.\n\
         *NODE PRINT,NSET=ALL\nU\n*END STEP\n",
        set("HELD", &ends[0]),
        set("END", &ends[1])
    )
}

#[test]
fn materials_that_turn_about_an_axis_are_those_of_calculix() {
    if !is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for kind in ["C3D8", "C3D8I", "C3D20", "C3D20R"] {
        let [frequencies, displacement] = compare(folder.path(), "ring", &ring(kind));
        println!("| {kind} with *ORIENTATION, SYSTEM=CYLINDRICAL | {frequencies:.0e} | {displacement:.0e} |");
        assert!(frequencies < 1e-6 && displacement < 1e-6, "{kind}: {frequencies:e} {displacement:e}");
    }
    // A problem file has one stiffness for a region.
    let deck = folder.path().join("ring.inp").display().to_string();
    let refused = vademecum(&["init", &deck, "--units", "m-kg-N"]);
    assert_eq!(refused.code, Some(3), "{}", refused.stderr);
    for part in ["region `RING`", "turn about a line", "RECTANGULAR"] {
        assert!(refused.stderr.contains(part), "{}", refused.stderr);
    }
}

#[test]
fn masses_of_tetrahedra_are_those_of_calculix() {
    if !is_there() {
        return;
    }
    // The paths along the edges of a brick from one corner to the opposite one.
    const PATHS: [[usize; 4]; 6] =
        [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]];
    const TET_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];
    let folder = tempfile::tempdir().unwrap();
    let cells = [4, 2, 2];
    for kind in ["C3D4", "C3D10"] {
        let (mut numbers, mut nodes, mut elements): (HashMap<[usize; 3], usize>, _, _) =
            (HashMap::new(), String::new(), String::new());
        let mut number = |at: [usize; 3]| {
            let next = 1 + numbers.len();
            *numbers.entry(at).or_insert_with(|| {
                let [x, y, z] = [0, 1, 2].map(|c| [1.0, 0.2, 0.3][c] * at[c] as f64 / (2 * cells[c]) as f64);
                // A bend, so that sides are curved.
                let (y, z) = (y + 0.1 * x * x, z + 0.05 * x * x * x + 0.05 * x * y);
                writeln!(nodes, "{next},{x:.12e},{y:.12e},{z:.12e}").unwrap();
                next
            })
        };
        let mut count = 0;
        for i in 0..cells[0] {
            for j in 0..cells[1] {
                for k in 0..cells[2] {
                    for path in PATHS {
                        let corners = path.map(|c| {
                            let c = CORNERS[c];
                            [2 * (i + c[0]), 2 * (j + c[1]), 2 * (k + c[2])]
                        });
                        let middles = TET_EDGES
                            .map(|[a, b]| std::array::from_fn(|c| (corners[a][c] + corners[b][c]) / 2));
                        let middles = middles.into_iter().filter(|_| kind == "C3D10");
                        let all: Vec<String> =
                            corners.into_iter().chain(middles).map(|at| number(at).to_string()).collect();
                        count += 1;
                        writeln!(elements, "{count},{}", all.join(",")).unwrap();
                    }
                }
            }
        }
        let end = |i: usize| -> Vec<usize> {
            let mut nodes: Vec<usize> =
                numbers.iter().filter(|(at, _)| at[0] == i).map(|(_, &node)| node).collect();
            nodes.sort_unstable();
            nodes
        };
        let deck = format!(
            "*NODE,NSET=ALL\n{nodes}*ELEMENT,TYPE={kind},ELSET=BAR\n{elements}{}{}{STEEL}\
             *SOLID SECTION,ELSET=BAR,MATERIAL=M\n*BOUNDARY\nLEFT,1,3\n*STEP\n*FREQUENCY\n6\n*END STEP\n\
             *STEP\n*STATIC\n*CLOAD\nRIGHT,3,10.\n*NODE PRINT,NSET=ALL\nU\n*END STEP\n",
            set("LEFT", &end(0)),
            set("RIGHT", &end(2 * cells[0]))
        );
        let [frequencies, displacement] = compare(folder.path(), "bent", &deck);
        println!("| {kind} with curved sides | {frequencies:.0e} | {displacement:.0e} |");
        assert!(frequencies < 1e-6 && displacement < 1e-6, "{kind}: {frequencies:e} {displacement:e}");
    }
}

/// A bar with eight modes and a step that prints the motion of its tip.
fn moved(bar: &Bar, tip: usize, step: &str) -> String {
    format!(
        "{}{}*NSET,NSET=OUT\n{tip}\n{STEEL}*SOLID SECTION,ELSET=BAR,MATERIAL=M\n*BOUNDARY\nLEFT,1,3\n\
         *AMPLITUDE,NAME=A\n0.,0.,1.e-3,1.,2.e-3,-1.,4.e-3,.5\n*AMPLITUDE,NAME=B\n0.,1.,1.,1.\n\
         *STEP\n*FREQUENCY,STORAGE=YES\n8\n*END STEP\n*STEP\n{step}*NODE PRINT,NSET=OUT\nU\n*END STEP\n",
        bar.cards,
        set("LEFT", &bar.section(0)),
    )
}

/// The body of a deck: `init`, then `build`; the place of the file, and what `init` printed.
fn body(folder: &Path, job: &str) -> (String, String) {
    let at = |ending: &str| folder.join(format!("{job}.{ending}")).display().to_string();
    let run = |arguments: &[&str]| {
        let ran = vademecum(arguments);
        assert_eq!(ran.code, Some(0), "{arguments:?}: {}", ran.stderr);
        ran.stdout
    };
    let proposed = run(&["init", &at("inp"), "-o", &at("toml"), "--force"]);
    run(&["build", &at("toml"), "-o", &at("vdm"), "--force"]);
    (at("vdm"), proposed)
}

/// Columns of a table of numbers by the beginning of their names.
fn columns(table: &str, names: &[String]) -> Vec<Vec<f64>> {
    let mut rows = table.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(','));
    let head: Vec<&str> = rows.next().expect("a head").collect();
    let place = |name: &String| head.iter().position(|found| found.starts_with(name.as_str())).expect(name);
    let places: Vec<usize> = names.iter().map(place).collect();
    let of = |row: Vec<&str>| places.iter().map(|&k| row[k].parse().expect("a number")).collect();
    rows.map(|row| of(row.collect())).collect()
}

#[test]
fn damped_motions_and_harmonic_answers_are_those_of_calculix() {
    if !is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let bar = Bar::new([4, 2, 1], 0.0, 1, "BAR");
    let tip = bar.numbers[&[8, 4, 2]];
    let axes = ["x", "y", "z"];
    let rayleigh = "*MODAL DAMPING,RAYLEIGH\n,,50.,1.e-5\n";
    let loads = format!("*CLOAD,AMPLITUDE=A\n{tip},2,100.\n*CLOAD,AMPLITUDE=B\n{tip},3,-300.\n");
    for (name, damping) in [("RAYLEIGH", rayleigh), ("ratios", "*MODAL DAMPING\n1,2,.02\n3,5,.3\n")] {
        let deck = moved(&bar, tip, &format!("*MODAL DYNAMIC\n1.e-4,4.e-3\n{damping}{loads}"));
        std::fs::write(folder.path().join("bar.inp"), deck).unwrap();
        let theirs = calculix::answer(folder.path(), "bar");
        assert_eq!(theirs.displacements.len(), 40, "{}", theirs.said);
        let (file, _) = body(folder.path(), "bar");
        let scenario = folder.path().join("bar.scenario.toml").display().to_string();
        let out = folder.path().join("out").display().to_string();
        let ran = vademecum(&["run", &file, "--scenario", &scenario, "-o", &out, "--force"]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        let table = std::fs::read_to_string(folder.path().join("out/probes.csv")).unwrap();
        let ours = columns(&table, &axes.map(|axis| format!("N{tip}.{axis}")));
        assert_eq!(ours.len(), 41);
        let largest = theirs.displacements.iter().flat_map(|row| row.1).map(f64::abs).fold(0.0, f64::max);
        let apart = ours[1..].iter().zip(&theirs.displacements).flat_map(|(ours, (_, theirs))| {
            ours.iter().zip(*theirs).map(|(a, b)| (a - b).abs()).collect::<Vec<_>>()
        });
        let off = apart.fold(0.0, f64::max) / largest;
        println!("| *MODAL DYNAMIC with *MODAL DAMPING, {name} | | {off:.0e} |");
        assert!(off < 1e-6, "{name}: {off:e}");
    }
    let step = format!("*STEADY STATE DYNAMICS\n30.,70.,4\n{rayleigh}*CLOAD\n{tip},2,100.\n{tip},3,-300.\n");
    std::fs::write(folder.path().join("bar.inp"), moved(&bar, tip, &step)).unwrap();
    let theirs = calculix::answer(folder.path(), "bar").displacements;
    let (file, proposed) = body(folder.path(), "bar");
    let outs = format!("--out N{tip}.x --out N{tip}.y --out N{tip}.z --range 30,70");
    assert!(proposed.contains(&format!("--in \"1 2\" {outs}")), "{proposed}");
    let table = folder.path().join("frf.csv").display().to_string();
    let mut arguments = vec!["frf", &file, "--in", "1 2", "--points", "2", "--no-poles", "-o", &table];
    arguments.extend(outs.split(' '));
    let ran = vademecum(&arguments);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let names = ["re", "im"].map(|part| axes.map(|axis| format!("{part} N{tip}.{axis}")));
    let ours = columns(&std::fs::read_to_string(&table).unwrap(), &names.concat());
    // The real and the imaginary part at each frequency, the ends of the range first and last.
    let [first, .., last] = &theirs.chunks_exact(2).collect::<Vec<_>>()[..] else { panic!("{theirs:?}") };
    for (ours, theirs) in ours.iter().zip([first, last]) {
        let theirs = [theirs[0].1, theirs[1].1].concat();
        let largest = theirs.iter().map(|x| x.abs()).fold(0.0, f64::max);
        let off = ours.iter().zip(&theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest;
        println!("| *STEADY STATE DYNAMICS with Rayleigh damping | | {off:.0e} |");
        assert!(off < 1e-6, "{off:e}: {ours:?} for {theirs:?}");
    }
}
