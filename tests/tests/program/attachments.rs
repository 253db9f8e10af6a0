//! Couplings, ties, masses and springs through every command, against the full-order model of a deck, which
//! `decks` compares with other programs.

use std::fmt::Write;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;
use vademecum_format::{Codec, Element, File, SectionInput, SectionKind};
use vademecum_tests::program::{Ran, program, vademecum};
use vademecum_tests::shared::shared;
use vademecum_tests::synthetic::rewritten;

/// Bricks along the bar, and across.
const CELLS: [usize; 3] = [6, 2, 2];

/// Size of the bar \[m\].
const SIZE: [f64; 3] = [1.0, 0.1, 0.1];

/// A bar of bricks, held at one end, with a head: cards of nodes, elements and sets.
struct Bar {
    text: String,
    ends: [Vec<usize>; 2],
    nodes: usize,
}

/// Adds a bar that begins at `from` to a deck.
fn bar(from: f64, first: usize, set: &str) -> Bar {
    let [nx, ny, nz] = CELLS;
    let id = |i: usize, j: usize, k: usize| first + i + (nx + 1) * (j + (ny + 1) * k);
    let mut text = "*NODE\n".to_string();
    let mut ends = [vec![], vec![]];
    for k in 0..=nz {
        for j in 0..=ny {
            for i in 0..=nx {
                let at = [i, j, k].map(|x| x as f64);
                let x: [f64; 3] = std::array::from_fn(|c| at[c] * SIZE[c] / CELLS[c] as f64);
                writeln!(text, "{},{:.9},{:.9},{:.9}", id(i, j, k), from + x[0], x[1], x[2]).unwrap();
                if i == 0 || i == nx {
                    ends[usize::from(i == nx)].push(id(i, j, k));
                }
            }
        }
    }
    let mut last = vec![];
    writeln!(text, "*ELEMENT,TYPE=C3D8,ELSET={set}").unwrap();
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let square = |k: usize| [id(i, j, k), id(i + 1, j, k), id(i + 1, j + 1, k), id(i, j + 1, k)];
                let corners = [square(k), square(k + 1)].concat();
                let corners: Vec<String> = corners.iter().map(usize::to_string).collect();
                writeln!(text, "{},{}", id(i, j, k), corners.join(",")).unwrap();
                if i + 1 == nx {
                    last.push(id(i, j, k).to_string());
                }
            }
        }
    }
    writeln!(text, "*ELSET,ELSET={set}-last\n{}", last.join(",")).unwrap();
    let nodes = (nx + 1) * (ny + 1) * (nz + 1);
    Bar { text, ends, nodes }
}

fn set(name: &str, nodes: &[usize]) -> String {
    let nodes: Vec<String> = nodes.iter().map(usize::to_string).collect();
    let lines: Vec<String> = nodes.chunks(12).map(|line| line.join(",")).collect();
    format!("*NSET,NSET={name}\n{}\n", lines.join(",\n"))
}

const MATERIAL: &str = "*MATERIAL,NAME=steel\n*ELASTIC\n2.1e11,0.3\n*DENSITY\n7850\n";

fn write(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().into()
}

/// JSON that a command prints.
fn json(arguments: &[&str]) -> Value {
    let arguments = [arguments, &["--json"]].concat();
    let ran = vademecum(&arguments);
    assert_eq!(ran.code, Some(0), "{arguments:?}: {}", ran.stderr);
    ran.json()
}

fn frequencies(of: &str) -> Vec<f64> {
    let found = json(&["modes", of, "--count", "6"]);
    found["frequencies_hz"].as_array().unwrap().iter().map(|f| f.as_f64().unwrap()).collect()
}

/// The problem file of a deck.
fn problem(folder: &Path, deck: &str) -> String {
    let problem = folder.join("body.toml");
    let ran = vademecum(&["init", deck, "-o", problem.to_str().unwrap(), "--force"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(!ran.stderr.contains("not in this file"), "{}", ran.stderr);
    problem.to_str().unwrap().into()
}

/// The frequencies of a deck and of the problem that `init` writes of it.
fn check(name: &str, deck: &str) -> (TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let deck = write(folder.path(), "body.inp", deck);
    let problem = problem(folder.path(), &deck);
    let (expected, found) = (frequencies(&deck), frequencies(&problem));
    for (found, expected) in found.iter().zip(&expected) {
        assert!((found / expected - 1.0).abs() < 1e-9, "{name}: {found}, in the deck {expected} Hz");
    }
    (folder, problem)
}

/// A bar with a mass on a reference point that its end follows or that follows its end.
fn headed(coupling: &str) -> String {
    let Bar { text, ends, .. } = bar(0.0, 1, "bar");
    let [left, right] = ends;
    format!(
        "{text}*NODE\n9000,1.2,0.07,0.04\n{}{}{MATERIAL}*SOLID SECTION,ELSET=bar,MATERIAL=steel\n\
         *BOUNDARY\nleft,1,3\n{coupling}\
         *ELEMENT,TYPE=MASS,ELSET=head\n9900,9000\n*MASS,ELSET=head\n40\n\
         *ELEMENT,TYPE=SPRING1,ELSET=mount\n9901,9000\n*SPRING,ELSET=mount\n3\n2e6\n\
         *STEP\n*STATIC\n*CLOAD\n9000,3,-1000\n*END STEP\n*STEP\n*FREQUENCY\n6\n*END STEP\n",
        set("left", &left),
        set("right", &right)
    )
}

#[test]
fn a_mass_on_a_rigid_head_is_that_of_the_deck_and_steps_as_the_full_order() {
    let (folder, problem) = check("rigid", &headed("*RIGID BODY,NSET=right,REF NODE=9000\n"));
    let text = std::fs::read_to_string(&problem).unwrap();
    for key in
        ["[[reference_point]]", "kind = \"rigid\"", "mass = 40", "[[spring]]", "force = [0.0, 0.0, -1000.0]"]
    {
        assert!(text.contains(key), "no {key} in\n{text}");
    }
    steps_as_the_full_order(folder.path(), &problem, &text);
}

#[test]
fn a_mass_that_follows_a_face_in_the_mean_is_that_of_the_deck() {
    let coupling = "*SURFACE,NAME=end,TYPE=NODE\nright\n\
                    *COUPLING,CONSTRAINT NAME=c,REF NODE=9000,SURFACE=end\n*DISTRIBUTING\n1,6\n";
    let deck = headed(coupling);
    let (folder, problem) = check("average", &deck);
    let text = std::fs::read_to_string(&problem).unwrap();
    assert!(text.contains("kind = \"average\""), "{text}");
    steps_as_the_full_order(folder.path(), &problem, &text);
}

#[test]
fn supports_along_own_axes_and_unequal_weights_are_those_of_the_deck() {
    let weights: String =
        bar(0.0, 1, "bar").ends[1].iter().map(|&node| format!("{node},{}\n", 1 + node % 3)).collect();
    let coupling =
        format!("*ELEMENT,TYPE=DCOUP3D,ELSET=hub\n9950,9000\n*DISTRIBUTING COUPLING,ELSET=hub\n{weights}");
    // Held along (1, 1, 0) and z; what is left is held by the spring along y.
    let deck = headed(&coupling)
        .replace(
            "*BOUNDARY\nleft,1,3\n",
            "*TRANSFORM,NSET=left,TYPE=R\n1,1,0,-1,1,0\n*BOUNDARY\nleft,1,1\nleft,3,3\n",
        )
        .replace("*SPRING,ELSET=mount\n3\n", "*SPRING,ELSET=mount\n2\n");
    let (folder, problem) = check("own axes", &deck);
    let text = std::fs::read_to_string(&problem).unwrap();
    // CalculiX: the reference node has the weighted mean of the displacements, wherever it is.
    assert!(text.contains("[[equation]]") && !text.contains("kind = \"average\""), "{text}");
    steps_as_the_full_order(folder.path(), &problem, &text);
}

#[test]
fn springs_along_lines_between_nodes_are_those_of_the_deck() {
    let Bar { text, ends, .. } = bar(0.0, 1, "bar");
    let [left, right] = ends;
    // From nodes of the middle of the bar to nodes of its end, in no direction of space.
    let lines = [(3, right[0]), (25, right[4]), (18, right[8])];
    let springs: String =
        lines.iter().enumerate().map(|(i, (a, b))| format!("{},{a},{b}\n", 9800 + i)).collect();
    let deck = format!(
        "{text}{}{MATERIAL}*SOLID SECTION,ELSET=bar,MATERIAL=steel\n*BOUNDARY\nleft,1,3\n\
         *ELEMENT,TYPE=SPRINGA,ELSET=ties\n{springs}*SPRING,ELSET=ties\n\n3e7\n\
         *STEP\n*FREQUENCY\n6\n*END STEP\n",
        set("left", &left),
    );
    let (folder, problem) = check("springs", &deck);
    let text = std::fs::read_to_string(&problem).unwrap();
    steps_as_the_full_order(folder.path(), &problem, &text);
}

#[test]
fn a_bar_between_reference_points_is_that_of_the_deck() {
    let Some(deck) = shared("decks/nastran/rigid_rbe2.bdf") else { return };
    let folder = tempfile::tempdir().unwrap();
    let deck = deck.to_str().unwrap();
    let problem = problem(folder.path(), deck);
    let text = std::fs::read_to_string(&problem).unwrap();
    assert!(text.contains("matrix = ["), "{text}");
    for (found, expected) in frequencies(&problem).iter().zip(frequencies(deck)) {
        assert!((found / expected - 1.0).abs() < 1e-9, "{found}, in the deck {expected} Hz");
    }
}

#[test]
fn bars_that_are_tied_are_those_of_the_deck() {
    let first = bar(0.0, 1, "first");
    let second = bar(1.0, first.nodes + 1, "second");
    let deck = format!(
        "{}{}{}{}{}{MATERIAL}*SOLID SECTION,ELSET=first,MATERIAL=steel\n\
         *SOLID SECTION,ELSET=second,MATERIAL=steel\n*BOUNDARY\nleft,1,3\n\
         *SURFACE,NAME=slave,TYPE=NODE\nbegin\n*SURFACE,NAME=master\nfirst-last,S4\n\
         *TIE,NAME=t,POSITION TOLERANCE=0.001\nslave,master\n*STEP\n*FREQUENCY\n6\n*END STEP\n",
        first.text,
        second.text,
        set("left", &first.ends[0]),
        set("right", &first.ends[1]),
        set("begin", &second.ends[0])
    );
    let (folder, problem) = check("tie", &deck);
    let text = std::fs::read_to_string(&problem).unwrap();
    assert!(text.contains("[[tie]]"), "{text}");
    steps_as_the_full_order(folder.path(), &problem, &text);
}

#[test]
fn a_reference_with_a_node_of_rotations_holds_and_turns_as_in_the_deck() {
    // A rotation about z is held, and a moment about y acts.
    let coupling = "*NODE\n9001,1.2,0.07,0.04\n*RIGID BODY,NSET=right,REF NODE=9000,ROT NODE=9001\n\
                    *BOUNDARY\n9001,3,3\n";
    let deck = headed(coupling).replace("9000,3,-1000\n", "9000,3,-1000\n9001,2,50\n");
    let (_folder, problem) = check("rotation", &deck);
    let text = std::fs::read_to_string(&problem).unwrap();
    assert!(text.contains("held = [\"rz\"]") && text.contains("moment = [0.0, 50.0, 0.0]"), "{text}");
}

/// Builds the body and compares runs of it with the full order: a push on the coupled end, patterns, stress
/// and reactions.
fn steps_as_the_full_order(folder: &Path, problem: &str, text: &str) {
    // The full order has a matrix for the damping of the material alone.
    let ratio = text.lines().find(|line| line.starts_with("ratio = ")).expect("a damping ratio");
    let text = text
        .replace(ratio, "beta = 1e-6")
        .replace("modes = 32", "modes = 16")
        .replace("[output]", "[output]\nreactions = true\nstress = \"surface\"");
    std::fs::write(problem, text).unwrap();
    let file = folder.join("body.vdm");
    let file = file.to_str().unwrap();
    let built = vademecum(&["build", problem, "-o", file, "--force"]);
    assert_eq!(built.code, Some(0), "{}", built.stderr);
    let scenario =
        "duration = 0.05\n[[contact]]\npoint = [1.0, 0.05, 0.1]\nforce = [0.0, 0.0, -500.0]\nend = 0.02\n";
    let scenario = write(folder, "push.toml", scenario);
    let verified = json(&["verify", file, "--problem", problem, "--scenario", &scenario]);
    let error = verified["total_error"].as_f64().expect("an error");
    assert!(error < 1e-3, "{verified}");
    let csv = folder.join("frf.csv").display().to_string();
    let response = ["frf", file, "--in", "1.0,0.05,0.1,z", "--out", "1.0,0.05,0.1,z", "--range", "1,100"];
    let compared = ["--problem", problem, "--compare", "20", "-o", &csv];
    let found = json(&[&response[..], &compared[..]].concat());
    let rms = found["compared"]["rms"].as_f64().expect("an error");
    assert!(rms < 1e-3, "{}", found["compared"]);
}

/// A free bar with a head, and a second bar that is tied to it.
fn flying() -> String {
    let Bar { text, ends, nodes } = bar(0.0, 1, "bar");
    let second = bar(1.0, 1 + nodes, "second");
    format!(
        "{text}{}*NODE\n9000,-0.2,0.07,0.04\n{}{MATERIAL}*SOLID SECTION,ELSET=bar,MATERIAL=steel\n\
         *SOLID SECTION,ELSET=second,MATERIAL=steel\n\
         *SURFACE,NAME=end\nbar-last,S4\n*NSET,NSET=begin\n{}\n*SURFACE,NAME=begin,TYPE=NODE\nbegin\n\
         *TIE,NAME=weld,POSITION TOLERANCE=1e-3\nbegin,end\n\
         *RIGID BODY,NSET=left,REF NODE=9000\n*ELEMENT,TYPE=MASS,ELSET=head\n9900,9000\n*MASS,ELSET=head\n40\n\
         *STEP\n*FREQUENCY\n6\n*END STEP\n",
        second.text,
        set("left", &ends[0]),
        second.ends[0].iter().map(usize::to_string).collect::<Vec<_>>().join(",\n"),
    )
}

#[test]
fn a_free_deck_with_a_head_and_a_tie_flies_with_their_mass() {
    let (folder, problem) = check("flying", &flying());
    let text = std::fs::read_to_string(&problem).unwrap();
    assert!(
        !text.contains("[[support]]") && text.contains("mass = 40") && text.contains("[[tie]]"),
        "{text}"
    );
    let modes = json(&["modes", &problem, "--count", "6"]);
    assert_eq!(modes["rigid_motions"], 6);
    let file = folder.path().join("flying.vdm").display().to_string();
    let ratio = text.lines().find(|line| line.starts_with("ratio = ")).expect("a damping ratio");
    std::fs::write(&problem, text.replace(ratio, "beta = 1e-6")).unwrap();
    let built = vademecum(&["build", &problem, "-o", &file, "--force"]);
    assert_eq!(built.code, Some(0), "{}", built.stderr);
    let info = json(&["info", &file]);
    let mass = info["free_body"]["mass"].as_f64().expect("a mass");
    let expected = 40.0 + 2.0 * 7850.0 * SIZE.iter().product::<f64>();
    assert!((mass / expected - 1.0).abs() < 1e-12, "{mass} for {expected}");
    let bytes = std::fs::read(&file).unwrap();
    let values = File::parse(&bytes).unwrap().section(SectionKind::Eigenvalues).unwrap().numbers().unwrap();
    let found: Vec<f64> = values.iter().map(|value: f64| value.sqrt() / std::f64::consts::TAU).collect();
    for (found, expected) in found.iter().zip(frequencies(&problem)) {
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    }
    // The elastic motion under a push, and the flight: thrown up, it comes back.
    let scenario =
        "duration = 0.02\n[[contact]]\npoint = [2.0, 0.05, 0.1]\nforce = [0.0, 0.0, -500.0]\nend = 0.005\n";
    let push = write(folder.path(), "push.toml", scenario);
    let verified = json(&["verify", &file, "--problem", &problem, "--scenario", &push]);
    let error = verified["total_error"].as_f64().expect("an error");
    assert!(error < 1e-3, "{verified}");
    let thrown = write(
        folder.path(),
        "throw.toml",
        &format!("{scenario}[free]\nvelocity = [0.0, 0.0, 2.0]\nspin = [1.0, 0.0, 0.0]\n"),
    );
    let csv = folder.path().join("out.csv").display().to_string();
    let ran = vademecum(&["run", &file, "--scenario", &thrown, "-o", &csv]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let csv = folder.path().join("frf.csv").display().to_string();
    let response = ["frf", &file, "--in", "2.0,0.05,0.1,z", "--out", "2.0,0.05,0.1,z", "--range", "20,200"];
    let compared = ["--problem", &problem, "--compare", "20", "-o", &csv];
    let found = json(&[&response[..], &compared[..]].concat());
    let rms = found["compared"]["rms"].as_f64().expect("an error");
    assert!(rms < 1e-3, "{}", found["compared"]);
}

#[test]
fn a_free_plate_of_nastran_has_a_motor_off_its_rigid_point() {
    let (cells, size): ([usize; 3], [f64; 3]) = ([6, 2, 1], [1.0, 0.2, 0.05]);
    let [nx, ny, nz] = cells;
    let id = |i: usize, j: usize, k: usize| 1 + i + (nx + 1) * (j + (ny + 1) * k);
    let mut text = "SOL 103\nCEND\nMETHOD=1\nBEGIN BULK\nEIGRL,1,,,6\nMAT1,1,2.1+11,,0.3,7850.\nPSOLID,1,1\n"
        .to_string();
    for k in 0..=nz {
        for j in 0..=ny {
            for i in 0..=nx {
                let x: [f64; 3] = std::array::from_fn(|c| [i, j, k][c] as f64 * size[c] / cells[c] as f64);
                writeln!(text, "GRID,{},,{:.6},{:.6},{:.6}", id(i, j, k), x[0], x[1], x[2]).unwrap();
            }
        }
    }
    for j in 0..ny {
        for i in 0..nx {
            let square = |k: usize| [id(i, j, k), id(i + 1, j, k), id(i + 1, j + 1, k), id(i, j + 1, k)];
            let n = [square(0), square(1)].concat();
            let first: Vec<String> = n[..6].iter().map(usize::to_string).collect();
            writeln!(text, "CHEXA,{},1,{}\n,{},{}", 1 + i + nx * j, first.join(","), n[6], n[7]).unwrap();
        }
    }
    let list = |nodes: &[usize]| nodes.iter().map(usize::to_string).collect::<Vec<_>>().join(",");
    let top: Vec<usize> = (2..=3).flat_map(|i| (0..=ny).map(move |j| id(i, j, nz))).collect();
    let end: Vec<usize> = (0..=ny).flat_map(|j| (0..=nz).map(move |k| id(nx, j, k))).collect();
    let deck = format!(
        "{text}GRID,900,,0.45,0.1,0.2\nGRID,901,,1.2,0.1,0.0\n\
         RBE2,500,900,123456,{}\n,{}\nRBE3,501,,901,123456,1.0,123,{}\n,{}\n\
         CONM2,600,900,,12.0,0.05,0.0,0.1\n,0.1,0.,0.2,0.,0.,0.3\nCONM2,601,901,,3.0\nENDDATA\n",
        list(&top[..5]),
        list(&top[5..]),
        list(&end[..2]),
        list(&end[2..])
    );
    let folder = tempfile::tempdir().unwrap();
    let deck = write(folder.path(), "plate.bdf", &deck);
    let problem = problem(folder.path(), &deck);
    let found = json(&["modes", &problem, "--count", "6"]);
    assert_eq!(found["rigid_motions"], 6);
    for (found, expected) in frequencies(&problem).iter().zip(frequencies(&deck)) {
        assert!((found / expected - 1.0).abs() < 1e-9, "{found}, in the deck {expected} Hz");
    }
    let file = folder.path().join("plate.vdm").display().to_string();
    let built = vademecum(&["build", &problem, "-o", &file, "--force"]);
    assert_eq!(built.code, Some(0), "{}", built.stderr);
    let body = &json(&["info", &file])["free_body"];
    let plate = 7850.0 * size.iter().product::<f64>();
    let mass = plate + 15.0;
    assert!((body["mass"].as_f64().unwrap() / mass - 1.0).abs() < 1e-12, "{body}");
    // The motor is off its point.
    let moments = |c: usize| plate * 0.5 * size[c] + 12.0 * [0.5, 0.1, 0.3][c] + 3.0 * [1.2, 0.1, 0.0][c];
    for c in 0..3 {
        let expected = moments(c) / mass;
        assert!((body["centre"][c].as_f64().unwrap() - expected).abs() < 1e-9, "{body} {expected}");
    }
}

#[test]
fn a_spring_to_the_ground_that_holds_a_free_body_in_part_is_refused_with_what_is_left() {
    let deck = flying() + "*ELEMENT,TYPE=SPRING1,ELSET=mount\n9901,9000\n*SPRING,ELSET=mount\n3\n2e6\n";
    let (before, step) = deck.split_once("*STEP").unwrap();
    let (step, mount) = step.split_once("*ELEMENT").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let deck = write(folder.path(), "body.inp", &format!("{before}*ELEMENT{mount}*STEP{step}"));
    let problem = folder.path().join("body.toml").display().to_string();
    let words = [
        "a spring or a foundation resists",
        "nothing resists 5 of the 6 (shift along x, shift along y, turn",
    ];
    vademecum(&["init", &deck, "-o", &problem]).fails(5, &words);
}

/// A square beam of bricks with a rigid end, and what is attached to that.
fn square(folder: &Path, name: &str, attached: &str) -> String {
    let Bar { text, ends, .. } = bar(0.0, 1, "bar");
    write(folder, "square.inp", &format!("{text}{}{}", set("left", &ends[0]), set("right", &ends[1])));
    let text = format!(
        "[mesh]\nfile = \"square.inp\"\n\
         [[material]]\nyoung = 2e9\npoisson = 0.3\ndensity = 1200.0\n[[support]]\non = {{ group = \"left\" }}\n\
         [[reference_point]]\nname = \"hub\"\nat = [1.0, 0.05, 0.05]\n\
         [[coupling]]\nreference = \"hub\"\non = {{ group = \"right\" }}\nkind = \"rigid\"\n\
         [[load.pattern]]\nname = \"push\"\nreference = \"hub\"\nforce = [0.0, 1.0, 1.0]\n\
         [time]\nstep = 1e-3\n[basis]\nmodes = 4\n[tolerance]\nerror = 1.0\n{attached}\n"
    );
    write(folder, name, &text)
}

#[test]
fn a_dashpot_gives_each_mode_its_ratio() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (c, k) = (2.0, 1.0);
    let dashpot = format!("[[dashpot]]\nfrom = \"hub\"\ndamping = [0.0, {c}, 0.0, 0.0, 0.0, 0.0]");
    let problem = square(folder.path(), "dashpot.toml", &dashpot);
    let build = |problem: &str, file: &str| {
        let built = std::process::Command::new(program()).args(["build", problem, "-o", file]).output();
        let built = Ran::new(&built.expect("the program starts"));
        assert_eq!(built.code, Some(0), "{}", built.stderr);
        built.stderr.contains("dashpots couple the modes")
    };
    assert!(!build(&problem, &at("beam.vdm")));
    let strong = square(folder.path(), "strong.toml", &dashpot.replace("0.0, 2,", "0.0, 400,"));
    assert!(build(&strong, &at("strong.vdm")));
    let info = json(&["info", &at("beam.vdm")]);
    let ratios: Vec<f64> =
        info["damping_ratios"].as_array().unwrap().iter().map(|ratio| ratio.as_f64().unwrap()).collect();
    // Of the two modes of one frequency, one moves along the dashpot.
    let (least, most) = (ratios[0].min(ratios[1]), ratios[0].max(ratios[1]));
    assert!(least < 1e-9 && most > 1e-3, "{ratios:?}");
    // A soft spring in its place adds k φ² to the square of the frequency, the dashpot c φ² / (2 ω) to the
    // ratio.
    let spring = format!("[[spring]]\nfrom = \"hub\"\nstiffness = [0.0, {k}, 0.0, 0.0, 0.0, 0.0]");
    let omega = |of: &str, mode: usize| std::f64::consts::TAU * frequencies(of)[mode];
    let stiffer = square(folder.path(), "spring.toml", &spring);
    let (bare, held) = (omega(&problem, 1), omega(&stiffer, 1));
    let expected = c * (held * held - bare * bare) / (2.0 * k * bare);
    assert!((most / expected - 1.0).abs() < 1e-3, "{most} for {expected}");
    // Against a reference whose modes are damped by the dashpot itself.
    let scenario = write(
        folder.path(),
        "push.toml",
        "duration = 0.3\n[[pattern]]\nname = \"push\"\namplitude = 20.0\nend = 0.1\n",
    );
    let verify = ["verify", &at("beam.vdm"), "--problem", &problem, "--scenario", &scenario];
    let error = json(&verify)["total_error"].as_f64().expect("an error");
    assert!(error < 0.02, "{error}");
    // The full order of `frf` has their matrix.
    let response = ["frf", &at("beam.vdm"), "--in", "push", "--out", "1.0,0.05,0.1,y", "--range", "1,100"];
    let compared = ["--problem", &problem, "--compare", "20", "-o", &at("frf.csv")];
    let found = json(&[&response[..], &compared[..]].concat());
    let rms = found["compared"]["rms"].as_f64().expect("an error");
    assert!(rms < 1e-2, "{}", found["compared"]);
}

/// The file with the same dashpots as ratios of its modes: their coupling left out.
fn uncoupled(bytes: &[u8]) -> Vec<u8> {
    let file = File::parse(bytes).unwrap();
    let numbers = |kind| file.section(kind).unwrap().numbers().unwrap().iter().collect::<Vec<f64>>();
    let (values, rows) = (numbers(SectionKind::Eigenvalues), numbers(SectionKind::DampingRows));
    let own = |k: usize| rows.chunks(values.len()).map(|row| row[k] * row[k]).sum::<f64>();
    let ratios: Vec<u8> =
        (0..values.len()).flat_map(|k| (0.5 * own(k) / values[k].sqrt()).to_le_bytes()).collect();
    let none = vec![0; 8 * rows.len()];
    let section = SectionInput {
        kind: SectionKind::DampingRatios,
        element: Element::F64,
        codec: Codec::Raw,
        required: true,
        shape: [values.len() as u64, 1, 1],
        decoded_length: ratios.len() as u64,
        stored: &ratios,
    };
    rewritten(
        bytes,
        |_| (),
        |section| {
            if section.kind == SectionKind::DampingRows {
                section.stored = &none;
            }
        },
        &[section],
    )
}

/// A dashpot of the impedance of the bar at its end: no wave along the bar comes back from there.
#[test]
fn a_dashpot_of_the_impedance_of_the_bar_takes_its_waves() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (young, density, area) = (2e9_f64, 1200.0, 0.01);
    let (impedance, speed) = (area * (young * density).sqrt(), (young / density).sqrt());
    let probe = "[[output.probe]]\nname = \"tip\"\npoint = [1.0, 0.05, 0.05]\ndirection = [1.0, 0.0, 0.0]";
    // The damping of the material keeps peaks across the bar finite.
    let dashpot = format!(
        "[[dashpot]]\nfrom = \"hub\"\ndamping = [{impedance}, 0.0, 0.0, 0.0, 0.0, 0.0]\n\
         [damping]\nalpha = 0.5\n{probe}"
    );
    let problem = square(folder.path(), "matched.toml", &dashpot);
    let text = std::fs::read_to_string(&problem).unwrap();
    let text = text.replace("force = [0.0, 1.0, 1.0]", "force = [1.0, 0.0, 0.0]");
    let text = text.replace("poisson = 0.3", "poisson = 0.0").replace("step = 1e-3", "step = 5e-5");
    std::fs::write(&problem, text.replace("modes = 4", "modes = 60").replace("error = 1.0", "error = 0.05"))
        .unwrap();
    let file = at("matched.vdm");
    let built = std::process::Command::new(program()).args(["build", &problem, "-o", &file]).output();
    let built = Ran::new(&built.expect("the program starts"));
    assert_eq!(built.code, Some(0), "{}", built.stderr);
    assert!(built.stderr.contains("dashpots couple the modes"), "{}", built.stderr);
    assert_eq!(json(&["info", &file])["damping_rows"], 1);
    let checked = vademecum(&["verify", &file, "--file-only"]);
    assert_eq!(checked.code, Some(0), "{}", checked.stderr);

    let scenario = write(
        folder.path(),
        "pull.toml",
        "duration = 0.01\n[[pattern]]\nname = \"push\"\namplitude = 100.0\nend = 0.004\n",
    );
    let error = |file: &str| {
        let verified = json(&["verify", file, "--problem", &problem, "--scenario", &scenario]);
        verified["total_error"].as_f64().expect("an error")
    };
    // The same ratios without the coupling: what a file was before it had section 79.
    let apart = at("apart.vdm");
    std::fs::write(&apart, uncoupled(&std::fs::read(&file).unwrap())).unwrap();
    let (together, apart_error) = (error(&file), error(&apart));
    println!("error {together:.2e}, without the coupling {apart_error:.2e}");
    // The modes hold all motions along the bar, so what is left is rounding; the tolerance is 5 %.
    assert!(together < 1e-10 && apart_error > 0.05, "{together:e} {apart_error:e}");

    // A force F moves the end with F sin(kL)/Z: half of it goes into either side, and what goes into the bar
    // comes back once.
    let csv = at("frf.csv");
    let response =
        ["--in", "push", "--out", "tip", "--range", "20,600", "--quantity", "velocity", "-o", &csv];
    let compared = ["--problem", &problem, "--compare", "30"];
    let of = |file: &str| json(&[&["frf", file][..], &response[..], &compared[..], &["--force"]].concat());
    let found = of(&file);
    let rms = found["compared"]["rms"].as_f64().expect("an error");
    let peak = &found["peaks"][0];
    let (amplitude, hertz) = (peak["amplitude"].as_f64().unwrap(), peak["frequency_hz"].as_f64().unwrap());
    println!("frf rms {rms:.2e}, peak {} of 1/Z at {hertz} Hz", amplitude * impedance);
    assert!(rms < 1e-9, "{}", found["compared"]);
    assert!((amplitude * impedance - 1.0).abs() < 0.01, "{amplitude} {}", 1.0 / impedance);
    // The top is flat: sin(kL) is within 1 % of it over 14 % of the frequency.
    assert!((hertz / (speed / 4.0) - 1.0).abs() < 0.1, "{hertz} {}", speed / 4.0);
    let alone = of(&apart)["peaks"][0]["amplitude"].as_f64().unwrap();
    println!("without the coupling {} of 1/Z", alone * impedance);
    assert!((alone * impedance - 1.0).abs() > 0.05, "{}", alone * impedance);
}

#[test]
fn a_spring_that_is_far_stiffer_than_the_body_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let numbers: Vec<String> =
        (0..6).flat_map(|i| (i..6).map(move |j| if i == j { "1e25" } else { "0" }.to_string())).collect();
    let matrix = format!("matrix = [{}]", numbers.join(", "));
    for key in [matrix.as_str(), "stiffness = [1e20, 0, 0, 0, 0, 0]"] {
        let problem = square(folder.path(), "stiff.toml", &format!("[[spring]]\nfrom = \"hub\"\n{key}\n"));
        let refused = vademecum(&["modes", &problem]);
        assert_eq!(refused.code, Some(3), "{}", refused.stderr);
        let name = format!("`spring[0].{}`", key.split(' ').next().unwrap());
        for part in [name.as_str(), "times as stiff as the body", "`held`"] {
            assert!(refused.stderr.contains(part), "{}", refused.stderr);
        }
    }
}

#[test]
fn a_probe_on_a_long_arm_is_sound() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let probe = "[[point_mass]]\nreference = \"hub\"\nmass = 1.0\n\
                 [[output.probe]]\nname = \"hub\"\npoint = [4.0, 0.05, 0.05]\ndirection = [0.0, 0.0, 1.0]";
    let problem = square(folder.path(), "arm.toml", probe);
    let text = std::fs::read_to_string(&problem).unwrap();
    std::fs::write(&problem, text.replace("at = [1.0, 0.05", "at = [4.0, 0.05")).unwrap();
    assert_eq!(vademecum(&["build", &problem, "-o", &at("arm.vdm")]).code, Some(0));
    let checked = vademecum(&["verify", &at("arm.vdm"), "--file-only"]);
    assert_eq!(checked.code, Some(0), "{}", checked.stderr);
}

#[test]
fn a_column_on_a_foundation_swings_and_is_damped_as_its_formula_says() {
    let folder = tempfile::tempdir().unwrap();
    let (young, density, length) = (2e9_f64, 1200.0, 1.0);
    // cot of the column against its ground: β L tan(β L) = k L / E, here 1.3.
    let (ground, damping) = (1.3 * young / length, 3e4);
    let mut beta = 1.0_f64;
    for _ in 0..50 {
        beta -= (beta * beta.tan() - 1.3) / (beta.tan() + beta / beta.cos().powi(2));
    }
    let omega = beta / length * (young / density).sqrt();
    let text = format!(
        "[mesh]\nblock = {{ lengths = [0.1, 0.1, {length:?}], divisions = [1, 1, 8] }}\n\
         [[material]]\nyoung = {young:?}\npoisson = 0.0\ndensity = {density:?}\n\
         [[foundation]]\non = {{ group = \"z_min\" }}\nnormal = {ground:?}\ntangential = 1e9\n\
         damping_normal = {damping:?}\n[basis]\nmodes = 6\n[tolerance]\nerror = 1.0\n[time]\nstep = 1e-3\n"
    );
    let problem = write(folder.path(), "column.toml", &text);
    let found = frequencies(&problem);
    let off = |hz: &f64| (hz * std::f64::consts::TAU / omega - 1.0).abs();
    let mode = (0..found.len()).min_by(|&a, &b| off(&found[a]).total_cmp(&off(&found[b]))).unwrap();
    // Eight quadratic elements along a quarter of a wave.
    assert!(off(&found[mode]) < 1e-6, "{found:?} for {} Hz", omega / std::f64::consts::TAU);
    let file = folder.path().join("column.vdm").display().to_string();
    let built = vademecum(&["build", &problem, "-o", &file]);
    assert_eq!(built.code, Some(0), "{}", built.stderr);
    let ratio = json(&["info", &file])["damping_ratios"][mode].as_f64().unwrap();
    // φ = cos(β (1 − z/L)), of unit mass: ζ = c A φ² / (2 ω) at the ground.
    let mass = density * length * (0.5 + (2.0 * beta).sin() / (4.0 * beta));
    let expected = damping * beta.cos().powi(2) / mass / (2.0 * omega);
    assert!((ratio / expected - 1.0).abs() < 1e-5, "{ratio} for {expected}");
    // Along the normal alone it does not hold the column.
    let sliding = write(folder.path(), "sliding.toml", &text.replace("tangential = 1e9\n", ""));
    let refused = vademecum(&["build", &sliding, "-o", &file, "--force"]);
    assert_eq!(refused.code, Some(5), "{}", refused.stderr);
}
