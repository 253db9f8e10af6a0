//! Thermal strain of decks beside CalculiX.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::Value;
use vademecum_tests::program::vademecum;
use vademecum_tests::witness::calculix;

use crate::prestress::bent;

/// Constants by temperature, from a temperature of reference beside the initial one.
const BY_TEMPERATURE: &str = "*ELASTIC\n2.1e9,0.3,300.\n1.9e9,0.31,400.\n1.2e9,0.28,600.\n\
     *EXPANSION,ZERO=280.\n1.1e-5,300.\n1.6e-5,500.\n";

/// One coefficient for each axis of a solid without axes of its own.
const ALONG_AXES: &str = "*ELASTIC\n2e9,0.3\n*EXPANSION,TYPE=ORTHO,ZERO=300.\n1e-5,3e-5,-5e-6\n";

/// Wood, by temperature.
const WOOD: &str = "*ELASTIC,TYPE=ENGINEERING CONSTANTS\n11.6e9,0.9e9,0.5e9,0.37,0.42,0.47,0.75e9,0.72e9,\n39e6,300.\n\
     9e9,0.8e9,0.4e9,0.37,0.42,0.47,0.7e9,0.6e9,\n30e6,450.\n\
     *EXPANSION,TYPE=ORTHO,ZERO=300.\n4e-6,2e-5,3e-5,300.\n5e-6,3e-5,4e-5,450.\n";

const STEEL: &str = "*ELASTIC\n2e9,0.3\n*EXPANSION,ZERO=293.\n1.2e-5\n";

/// A temperature by the place on the lattice.
type Field = fn([f64; 3]) -> f64;

/// The bent beam of a material at temperatures of its nodes, which lie on a lattice, from 300 on.
fn beam(element: &str, material: &str, temperature: Field, held: &str) -> String {
    let (mut text, nodes) = bent(element);
    let (system, points) = if held == "held" {
        ("RECTANGULAR", "1.,1.,0.3,-1.,1.,0.")
    } else {
        ("CYLINDRICAL", "-.1,-.2,0.,-.1,-.2,1.")
    };
    let _ = write!(
        text,
        "*MATERIAL,NAME=solid\n{material}*DENSITY\n1200.\n*ORIENTATION,NAME=axes,SYSTEM={system}\n{points}\n\
         *SOLID SECTION,ELSET=beam,MATERIAL=solid,ORIENTATION=axes\n*BOUNDARY\n{held},1,3\n\
         *INITIAL CONDITIONS,TYPE=TEMPERATURE\nall,300.\n*STEP\n*STATIC\n*CLOAD\ntip,2,5.\n*TEMPERATURE\n"
    );
    for (place, id) in nodes {
        let _ = writeln!(text, "{id},{:.6}", temperature(place.map(|p| p as f64)));
    }
    text + "*NODE PRINT,NSET=all\nU\n*END STEP\n*STEP,PERTURBATION\n*FREQUENCY\n8\n*END STEP\n"
}

fn answer(command: &str, path: &Path) -> Value {
    let path = path.to_str().expect("a path in UTF-8");
    let ran = vademecum(&[command, path, "--dialect", "calculix", "--json"]);
    assert_eq!(ran.code, Some(0), "{path}: {}", ran.stderr);
    ran.json()
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// The differences of the displacement of each static step from that of CalculiX, to the largest one.
fn displacements(theirs: &calculix::Tables, ours: &Value) -> Vec<f64> {
    let steps = ours["steps"].as_array().expect("steps");
    let count = theirs.displacements.len() / steps.len();
    let of_step = |(step, theirs): (&Value, &[(u64, [f64; 3])])| {
        let node = step["node"].as_u64().expect("a node");
        let found = theirs.iter().find(|row| row.0 == node).expect("the node").1;
        let apart = (0..3).map(|c| (number(&step["displacement"][c]) - found[c]).abs());
        apart.fold(0.0, f64::max) / number(&step["largest_displacement"])
    };
    assert!(count > 0, "{}", theirs.said);
    steps.iter().zip(theirs.displacements.chunks_exact(count)).map(of_step).collect()
}

/// The largest difference of the displacement, and of frequencies about the heated state.
fn differences(folder: &Path, job: &str, deck: &str) -> [f64; 2] {
    let path = folder.join(format!("{job}.inp"));
    std::fs::write(&path, deck).expect("written");
    let theirs = calculix::answer(folder, job);
    let displacement = displacements(&theirs, &answer("static", &path))[0];
    let modes = answer("modes", &path);
    let ours = modes["frequencies_hz"].as_array().expect("frequencies");
    assert!(theirs.frequencies.len() >= 8 && ours.len() >= 8, "{job}: {}", theirs.said);
    let apart = ours.iter().zip(&theirs.frequencies).map(|(hz, other)| (number(hz) / other - 1.0).abs());
    [displacement, apart.fold(0.0, f64::max)]
}

#[test]
fn heated_decks_are_those_of_calculix() {
    if !calculix::is_there() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    // Neither field is linear in an element: programs differ in what they take it for.
    let uniform = |_| 350.0;
    let field = |[x, y, z]: [f64; 3]| 330.0 + 3.0 * x + 0.9 * x * x - 4.0 * y * z - 6.0 * z * x + 2.0 * y * y;
    let cases: [(&str, &str, Field, &str); 4] = [
        ("steel", STEEL, uniform, "held"),
        ("tables", BY_TEMPERATURE, field, "held"),
        ("axes", ALONG_AXES, field, "held"),
        ("wood", WOOD, field, "held\ntip"),
    ];
    println!("| element | material | displacement | frequencies about it |\n|---|---|---|---|");
    for element in ["C3D8", "C3D8I", "C3D20", "C3D20R", "C3D4", "C3D10", "C3D6", "C3D15"] {
        for (name, material, temperature, held) in &cases {
            let deck = beam(element, material, *temperature, &held.replace('\n', ",1,3\n"));
            let [displacement, frequencies] = differences(folder.path(), &format!("{element}-{name}"), &deck);
            println!("| {element} | {name} | {displacement:.0e} | {frequencies:.0e} |");
            // The mass of wedges has other points in CalculiX.
            let frequencies = if matches!(element, "C3D6" | "C3D15") { 0.0 } else { frequencies };
            // Seven digits are printed, the first of which may be a one.
            assert!(
                displacement < 1e-6 && frequencies < 1e-6,
                "{element} {name}: {displacement:e} {frequencies:e}"
            );
        }
    }
}

#[test]
fn temperatures_go_on_from_step_to_step() {
    if !calculix::is_there() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("steps.inp");
    let printed = "*NODE PRINT,NSET=all\nU\n*END STEP\n";
    let deck = bent("C3D20R").0
        + &format!(
            "*MATERIAL,NAME=solid\n{STEEL}*SOLID SECTION,ELSET=beam,MATERIAL=solid\n*BOUNDARY\nheld,1,3\n\
             *INITIAL CONDITIONS,TYPE=TEMPERATURE\nall,300.\n*AMPLITUDE,NAME=half\n0.,0.,1.,.5\n\
             *STEP\n*STATIC\n*TEMPERATURE\nall,400.\ntip,500.\n{printed}\
             *STEP\n*STATIC\n*CLOAD\ntip,3,10.\n{printed}\
             *STEP\n*STATIC\n*TEMPERATURE,OP=NEW,AMPLITUDE=half\ntip,800.\n{printed}"
        );
    std::fs::write(&path, deck).expect("written");
    let theirs = calculix::answer(folder.path(), "steps");
    let found = displacements(&theirs, &answer("static", &path));
    assert_eq!(found.len(), 3);
    assert!(found.iter().all(|off| *off < 1e-6), "{found:?}");
}

#[test]
fn a_problem_of_a_heated_deck_has_its_motion() {
    let folder = tempfile::tempdir().expect("a folder");
    let [deck, problem] = ["deck.inp", "problem.toml"].map(|name| folder.path().join(name));
    std::fs::write(&deck, beam("C3D20R", STEEL, |_| 350.0, "held,1,3\ntip")).expect("written");
    let [deck, problem] = [&deck, &problem].map(|path| path.to_str().expect("a path in UTF-8"));
    let ran = vademecum(&["init", deck, "-o", problem, "--units", "m-kg-N", "--dialect", "calculix"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let text = std::fs::read_to_string(problem).expect("a problem");
    for part in ["expansion = 1.2e-5", "temperature = 50.0", "[prestress]"] {
        assert!(text.contains(part), "{text}");
    }
    let frequencies = |path: &str| -> Vec<f64> {
        let ran = vademecum(&["modes", path, "--count", "3", "--json"]);
        assert_eq!(ran.code, Some(0), "{path}: {}", ran.stderr);
        ran.json()["frequencies_hz"].as_array().expect("frequencies").iter().map(number).collect()
    };
    let (ours, theirs) = (frequencies(problem), frequencies(deck));
    let cold = text.replace("temperature = 50.0", "temperature = 1e-9");
    let other = folder.path().join("cold.toml");
    std::fs::write(&other, cold).expect("written");
    let cold = frequencies(other.to_str().expect("a path in UTF-8"));
    for k in 0..3 {
        println!("{} and {} Hz heated, {} Hz cold", ours[k], theirs[k], cold[k]);
        // Decks take the strains of the motion about the displaced body.
        assert!((ours[k] / theirs[k] - 1.0).abs() < 1e-3, "{} and {}", ours[k], theirs[k]);
    }
    assert!(ours[0] < 0.998 * cold[0], "{} heated, {} cold", ours[0], cold[0]);
}
