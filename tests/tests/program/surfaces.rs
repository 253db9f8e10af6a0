//! A surface becomes a body in one command, with the frequencies of the body.

use vademecum_tests::program::vademecum;

/// A box of triangles, as text of an STL file.
fn stl(sides: [f64; 3]) -> String {
    let point = |i: usize| {
        let [x, y, z] = std::array::from_fn(|k| if i >> k & 1 == 1 { sides[k] } else { 0.0 });
        format!("vertex {x} {y} {z}\n")
    };
    let mut text = String::from("solid beam\n");
    for [a, b, c, d] in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
        for corners in [[a, b, c], [a, c, d]] {
            text += "facet normal 0 0 0\nouter loop\n";
            corners.iter().for_each(|at| text += &point(*at));
            text += "endloop\nendfacet\n";
        }
    }
    text + "endsolid beam\n"
}

#[test]
fn a_beam_of_triangles_has_the_frequency_of_the_block() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let sides = [1.0, 0.1, 0.08];
    std::fs::write(at("beam.stl"), stl(sides)).expect("written");
    let ran = vademecum(&["init", &at("beam.stl"), "--hold", "x_min", "--cells", "30", "--json"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let proposed = ran.json();
    let text = proposed["text"].as_str().expect("a problem");
    assert!(text.contains("cells = 30 #") && text.contains("order = \"quadratic\""), "{text}");
    let block = format!(
        "[mesh]\nblock = {{ lengths = {sides:?}, divisions = [30, 4, 3] }}\n[[material]]\nyoung = 210e9\npoisson = \
         0.3\ndensity = 7850.0\n[[support]]\non = {{ group = \"x_min\" }}\n"
    );
    std::fs::write(at("block.toml"), block).expect("written");
    let first = |problem: &str| {
        let ran = vademecum(&["modes", &at(problem), "--json"]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        ran.json()["frequencies_hz"][0].as_f64().expect("a frequency")
    };
    let (found, expected) = (first("beam.toml"), first("block.toml"));
    assert!((found / expected - 1.0).abs() < 0.01, "{found} Hz, {expected} Hz");
    let built = vademecum(&["build", &at("beam.toml"), "-o", &at("beam.vdm")]);
    assert_eq!(built.code, Some(0), "{}", built.stderr);
    // A number of cells that no other mesh has a use for, and one that is none.
    vademecum(&["init", &at("beam.stl"), "--cells", "3"]).fails(2, &["--cells"]);
    // The number that the volume asks for is written, too.
    let chosen = vademecum(&["init", &at("beam.stl"), "-o", &at("chosen.toml"), "--json"]).json();
    assert!(chosen["text"].as_str().expect("a problem").contains("\ncells = "), "{chosen}");
    let shown = vademecum(&["mesh", &at("beam.stl")]);
    for part in ["STL surface, filled with tetrahedra", "cells along the longest side"] {
        assert!(shown.stdout.contains(part), "{}", shown.stdout);
    }
}
