//! Motion about a loaded state: decks beside CalculiX, problems beside closed forms.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use serde_json::Value;
use tempfile::TempDir;
use vademecum_tests::program::{Ran, vademecum};
use vademecum_tests::witness::calculix;

/// Cells of the beam.
const CELLS: [usize; 3] = [5, 2, 1];

/// Place on the lattice of half cells.
type Place = [usize; 3];

/// Corners of a cell in the order of a hexahedron.
const CORNERS: [Place; 8] =
    [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [0, 0, 2], [2, 0, 2], [2, 2, 2], [0, 2, 2]];

/// Corners of the elements of one cell, as places among its own, and edges with a node in their middle.
fn split(element: &str) -> (Vec<Vec<usize>>, Vec<[usize; 2]>) {
    let hexahedron = vec![(0..8).collect()];
    let wedges = vec![vec![0, 1, 2, 4, 5, 6], vec![0, 2, 3, 4, 6, 7]];
    let paths = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]];
    let tetrahedra: Vec<Vec<usize>> = paths.map(|path| path.to_vec()).to_vec();
    match element {
        "C3D4" => (tetrahedra, vec![]),
        "C3D10" => (tetrahedra, vec![[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]]),
        "C3D6" => (wedges, vec![]),
        "C3D15" => {
            (wedges, [[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3], [0, 3], [1, 4], [2, 5]].to_vec())
        }
        "C3D20" | "C3D20R" => {
            let edges =
                [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6]];
            (hexahedron, edges.into_iter().chain([[3, 7]]).collect())
        }
        _ => (hexahedron, vec![]),
    }
}

/// A bent beam of elements of one type with these cards of a static step, and the frequencies about its
/// state.
fn beam(element: &str, step: &str, loads: &str) -> String {
    let (elements, edges) = split(element);
    let mut ids: BTreeMap<Place, usize> = BTreeMap::new();
    let mut lines = String::new();
    for cell in 0..CELLS.iter().product::<usize>() {
        let at = [cell % CELLS[0], cell / CELLS[0] % CELLS[1], cell / CELLS[0] / CELLS[1]];
        for (part, corners) in elements.iter().enumerate() {
            let place = |k: usize| -> Place { std::array::from_fn(|c| 2 * at[c] + CORNERS[corners[k]][c]) };
            let middle = |[a, b]: &[usize; 2]| std::array::from_fn(|c| (place(*a)[c] + place(*b)[c]) / 2);
            let places: Vec<Place> = (0..corners.len()).map(place).chain(edges.iter().map(middle)).collect();
            let _ = write!(lines, "{}", 1 + cell * elements.len() + part);
            for (k, place) in places.into_iter().enumerate() {
                let next = ids.len() + 1;
                let id = *ids.entry(place).or_insert(next);
                let _ = write!(lines, "{}{id}", if k == 14 { ",\n" } else { "," });
            }
            lines.push('\n');
        }
    }
    let mut by_id: Vec<(Place, usize)> = ids.into_iter().collect();
    by_id.sort_by_key(|&(_, id)| id);
    let mut text = String::from("*NODE,NSET=all\n");
    for (place, id) in &by_id {
        let [x, y, z] = place.map(|p| 0.05 * p as f64);
        let _ = writeln!(text, "{id},{x:.6},{:.6},{:.6}", y + 0.1 * x * x, z + 0.1 * x * y);
    }
    for (name, of) in [("held", 0), ("tip", 2 * CELLS[0])] {
        let own = by_id.iter().filter(|(place, _)| place[0] == of).map(|(_, id)| format!("{id},\n"));
        let _ = write!(text, "*NSET,NSET={name}\n{}", own.collect::<String>());
    }
    text + &format!(
        "*ELEMENT,TYPE={element},ELSET=beam\n{lines}*MATERIAL,NAME=solid\n*ELASTIC\n2e9,0.3\n*DENSITY\n1200.\n\
         *SOLID SECTION,ELSET=beam,MATERIAL=solid\n*BOUNDARY\nheld,1,3\n\
         *STEP{step}\n*STATIC\n{loads}*END STEP\n\
         *STEP,PERTURBATION\n*FREQUENCY\n8\n*END STEP\n"
    )
}

/// Frequencies \[Hz\] of CalculiX.
fn calculix_of(folder: &Path, job: &str) -> Vec<f64> {
    Command::new("ccx").args(["-i", job]).current_dir(folder).output().expect("ccx starts");
    let printed = std::fs::read_to_string(folder.join(format!("{job}.dat"))).expect("ccx has answered");
    let table = printed.split("E I G E N V A L U E").nth(1).unwrap_or_default();
    let table = table.split("P A R T I C I P A T I O N").next().unwrap_or_default();
    let row = |line: &str| {
        let columns: Vec<f64> = line.split_whitespace().map_while(|word| word.parse().ok()).collect();
        if let [_, _, _, hz, _] = columns[..] { Some(hz) } else { None }
    };
    table.lines().filter_map(row).collect()
}

fn frequencies(found: &Value) -> Vec<f64> {
    let list = found["frequencies_hz"].as_array().expect("frequencies");
    list.iter().map(|hz| hz.as_f64().expect("a number")).collect()
}

/// The largest relative difference of frequencies from those of CalculiX.
fn difference(folder: &Path, element: &str, step: &str, loads: &str) -> f64 {
    let path = folder.join(format!("{element}.inp"));
    std::fs::write(&path, beam(element, step, loads)).expect("written");
    let expected = calculix_of(folder, element);
    assert!(expected.len() >= 8, "{element}: {expected:?}");
    let path = path.to_str().expect("a path in UTF-8");
    let ran = vademecum(&["modes", path, "--dialect", "calculix", "--json"]);
    let found = frequencies(&ran.json());
    let pairs = found.iter().zip(&expected);
    pairs.map(|(found, expected)| (found / expected - 1.0).abs()).fold(0.0, f64::max)
}

const ELEMENTS: [&str; 8] = ["C3D4", "C3D10", "C3D6", "C3D15", "C3D8", "C3D8I", "C3D20", "C3D20R"];

#[test]
fn prestressed_frequencies_of_decks_are_those_of_calculix() {
    if !calculix::is_there() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    for element in ELEMENTS {
        // A pull that doubles the lowest frequency, a push below the buckling load, a rotation about a skew
        // axis.
        for loads in [
            "*CLOAD\ntip,1,4e3\ntip,2,30.\n",
            "*CLOAD\ntip,1,-200.\n",
            "*DLOAD\nbeam,CENTRIF,2500.,-0.2,0.05,0.01,0.,0.6,0.8\n",
            "*DLOAD\nbeam,P1,20000.\n",
        ] {
            let found = difference(folder.path(), element, "", loads);
            println!("{element} {loads:?}: {found:e}");
            // Seven digits are printed.
            assert!(found < 1e-6, "{element} {loads}: {found:e}");
        }
    }
}
