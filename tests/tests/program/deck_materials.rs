//! Materials with axes in decks: answers beside those of CalculiX, and the problem that a deck becomes.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use serde_json::Value;
use vademecum_tests::program::vademecum;
use vademecum_tests::witness::calculix;

/// Cells of the beam.
const CELLS: [usize; 3] = [6, 2, 1];

/// Corners of a cell, then the middles of its edges, on a lattice of half cells, in the order of Abaqus.
const PLACES: [[usize; 3]; 20] = [
    [0, 0, 0],
    [2, 0, 0],
    [2, 2, 0],
    [0, 2, 0],
    [0, 0, 2],
    [2, 0, 2],
    [2, 2, 2],
    [0, 2, 2],
    [1, 0, 0],
    [2, 1, 0],
    [1, 2, 0],
    [0, 1, 0],
    [1, 0, 2],
    [2, 1, 2],
    [1, 2, 2],
    [0, 1, 2],
    [0, 0, 1],
    [2, 0, 1],
    [2, 2, 1],
    [0, 2, 1],
];

/// Spruce along its axes, and axes beside those of space.
const ELASTIC: &str =
    "*ELASTIC,TYPE=ENGINEERING CONSTANTS\n11.6e9,0.9e9,0.5e9,0.37,0.42,0.47,0.75e9,0.72e9,\n39e6,293.\n";
const ORIENTATION: &str = "*ORIENTATION,NAME=grain,SYSTEM=RECTANGULAR\n1.,1.,0.3,-1.,1.,0.\n";

/// A bent beam of elements of one type, held at one end and pulled at the other, with these cards of its
/// material.
fn beam(element: &str, material: &str) -> String {
    let n = if element.starts_with("C3D20") { 20 } else { 8 };
    let mut ids: BTreeMap<[usize; 3], usize> = BTreeMap::new();
    let mut elements = String::new();
    for cell in 0..CELLS.iter().product::<usize>() {
        let at = [cell % CELLS[0], cell / CELLS[0] % CELLS[1], cell / CELLS[0] / CELLS[1]];
        let mut line = format!("{}", cell + 1);
        for (k, place) in PLACES[..n].iter().enumerate() {
            let next = ids.len() + 1;
            let id = *ids.entry(std::array::from_fn(|c| 2 * at[c] + place[c])).or_insert(next);
            line += if k == 14 { ",\n" } else { "," };
            let _ = write!(line, "{id}");
        }
        elements += &line;
        elements.push('\n');
    }
    let mut text = String::from("*NODE,NSET=all\n");
    let mut by_id: Vec<([usize; 3], usize)> = ids.into_iter().collect();
    by_id.sort_by_key(|&(_, id)| id);
    for (place, id) in &by_id {
        let [x, y, z] = place.map(|p| 0.05 * p as f64);
        let _ = writeln!(text, "{id},{x:.6},{:.6},{:.6}", y + 0.2 * x * x, z + 0.1 * x * y);
    }
    let set = |name: &str, of: usize| {
        let own: Vec<String> =
            by_id.iter().filter(|(place, _)| place[0] == of).map(|(_, id)| format!("{id},\n")).collect();
        format!("*NSET,NSET={name}\n{}", own.concat())
    };
    let ends = [set("held", 0), set("tip", 2 * CELLS[0])].concat();
    text + &format!(
        "*ELEMENT,TYPE={element},ELSET=beam\n{elements}{ends}*MATERIAL,NAME=wood\n{material}*DENSITY\n450.\n\
         {ORIENTATION}*SOLID SECTION,ELSET=beam,MATERIAL=wood,ORIENTATION=grain\n*BOUNDARY\nheld,1,3\n\
         *STEP\n*FREQUENCY\n6\n*END STEP\n\
         *STEP\n*STATIC\n*CLOAD\ntip,2,-3.\ntip,3,5.\n*NODE PRINT,NSET=all\nU\n*END STEP\n"
    )
}

/// Frequencies \[Hz\] and the largest displacement \[m\] of CalculiX.
fn calculix_of(folder: &Path, job: &str) -> (Vec<f64>, f64) {
    Command::new("ccx").args(["-i", job]).current_dir(folder).output().expect("ccx starts");
    let printed = std::fs::read_to_string(folder.join(format!("{job}.dat"))).expect("ccx has answered");
    let (mut frequencies, mut largest) = (vec![], 0.0_f64);
    let mut table = "";
    for line in printed.lines() {
        let columns: Vec<f64> = line.split_whitespace().map_while(|word| word.parse().ok()).collect();
        match &columns[..] {
            [] if line.contains("E I G E N V A L U E") => table = "frequencies",
            [] if line.contains("P A R T I C I P A T I O N") => table = "",
            [] if line.contains("displacements") => table = "displacements",
            &[_, _, _, hz, _] if table == "frequencies" => frequencies.push(hz),
            &[_, x, y, z] if table == "displacements" => largest = largest.max(x.hypot(y).hypot(z)),
            _ => {}
        }
    }
    (frequencies, largest)
}

fn json(arguments: &[&str]) -> Value {
    let ran = vademecum(arguments);
    assert_eq!(ran.code, Some(0), "{arguments:?}: {}", ran.stderr);
    ran.json()
}

fn frequencies(found: &Value) -> Vec<f64> {
    let list = found["frequencies_hz"].as_array().expect("frequencies");
    list.iter().map(|hz| hz.as_f64().expect("a number")).collect()
}

#[test]
fn wood_is_answered_as_by_calculix() {
    if !calculix::is_there() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    for element in ["C3D8", "C3D8I", "C3D20", "C3D20R"] {
        let path = folder.path().join(format!("{element}.inp"));
        std::fs::write(&path, beam(element, ELASTIC)).expect("written");
        let (expected, displacement) = calculix_of(folder.path(), element);
        assert!(expected.len() >= 6 && displacement > 0.0, "{element}: {expected:?} {displacement}");
        let path = path.to_str().expect("a path in UTF-8");
        let found = frequencies(&json(&["modes", path, "--dialect", "calculix", "--json"]));
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found / expected - 1.0).abs() < 1e-6, "{element}: {found} for {expected} Hz");
        }
        let found = json(&["static", path, "--dialect", "calculix", "--json"]);
        let largest = found["steps"][0]["largest_displacement"].as_f64().expect("a number");
        println!("{element}: {largest:e} m by us, {displacement:e} m by CalculiX");
        assert!((largest / displacement - 1.0).abs() < 1e-6, "{element}: {largest} for {displacement}");
    }
}

#[test]
fn laws_of_one_solid_in_several_forms_have_one_answer() {
    // The stiffness of the same spruce, by constants of ORTHO and of ANISO.
    let (e, nu, g) = ([11.6e9, 0.9e9, 0.5e9], [0.37, 0.42, 0.47], [0.75e9, 0.72e9, 39e6]);
    let wood = vademecum_build::fem::Stiffness::orthotropic(e, nu, g).expect("a solid").0;
    let block =
        [[0, 0], [0, 1], [1, 1], [0, 2], [1, 2], [2, 2]].map(|[i, j]| format!("{:e}", wood[i][j])).join(",");
    let [g12, g13, g23] = g.map(|shear| format!("{shear:e}"));
    let ortho = format!("*ELASTIC,TYPE=ORTHO\n{block},{g12},{g13}\n{g23}\n");
    let aniso =
        format!("*ELASTIC,TYPE=ANISO\n{block},0.,0.\n0.,{g12},0.,0.,0.,0.,{g13},0.\n0.,0.,0.,0.,{g23}\n");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("beam.inp");
    let path = path.to_str().expect("a path in UTF-8");
    let of = |material: &str| {
        std::fs::write(path, beam("C3D20", material)).expect("written");
        frequencies(&json(&["modes", path, "--json"]))
    };
    let expected = of(ELASTIC);
    for material in [&ortho, &aniso] {
        let found = of(material);
        let alike = found.iter().zip(&expected).all(|(a, b)| (a / b - 1.0).abs() < 1e-9);
        assert!(alike && found.len() == expected.len(), "{material}: {found:?} {expected:?}");
    }
    // An isotropic material needs no axes, and none are judged that no section names.
    let odd = beam("C3D8", "*ELASTIC\n1e9,0.3\n").replace(ORIENTATION, "*ORIENTATION,NAME=grain\nfield\n");
    std::fs::write(path, odd).expect("written");
    assert_eq!(frequencies(&json(&["modes", path, "--json"])).len(), 12);
    // Axes that are given in another way are refused by name.
    let turning = beam("C3D8", ELASTIC).replace("SYSTEM=RECTANGULAR", "SYSTEM=SPHERICAL");
    std::fs::write(path, turning).expect("written");
    vademecum(&["modes", path]).fails(3, &["wood", "SYSTEM=RECTANGULAR", "*ORIENTATION"]);
    // Constants of no solid.
    let unsound = ELASTIC.replace("0.37", "3.9");
    std::fs::write(path, beam("C3D8", &unsound)).expect("written");
    vademecum(&["modes", path]).fails(3, &["*ELASTIC", "of a solid"]);
}

#[test]
fn a_deck_of_wood_becomes_a_body_with_its_frequencies_and_its_strain() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (deck, problem, file) = (at("beam.inp"), at("beam.toml"), at("beam.vdm"));
    std::fs::write(&deck, beam("C3D20", ELASTIC)).expect("written");
    let expected = frequencies(&json(&["modes", &deck, "--json"]));
    let made = vademecum(&["init", &deck, "-o", &problem]);
    assert_eq!(made.code, Some(0), "{}", made.stderr);
    let text = std::fs::read_to_string(&problem).expect("a problem");
    assert!(text.contains("stiffness = ["), "{text}");
    let stressed = text.replace("[output]", "[output]\nstress = \"surface\"");
    let stressed =
        if stressed == text { format!("{text}\n[output]\nstress = \"surface\"\n") } else { stressed };
    std::fs::write(&problem, stressed).expect("written");
    let built = vademecum(&["build", &problem, "-o", &file]);
    assert_eq!(built.code, Some(0), "{}", built.stderr);
    let found = json(&["info", &file, "--json"]);
    let modes = found["mode_table"].as_array().expect("modes");
    for (mode, expected) in modes.iter().zip(&expected) {
        let hz = mode["frequency_hz"].as_f64().expect("a number");
        assert!((hz / expected - 1.0).abs() < 1e-6, "{hz} for {expected} Hz");
    }
    let verified = vademecum(&["verify", &file, "--file-only"]);
    assert_eq!(verified.code, Some(0), "{}", verified.stderr);
}
