//! A surface becomes a body in one command, with the frequencies of the body.

use vademecum_eval::EmbeddedSurface;
use vademecum_format::{File, SectionKind};
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

/// The given surface is in the file: its corners where they were, its long edges divided, and affine motions
/// of the nodes are those of its vertices.
#[test]
fn the_given_surface_is_embedded() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let sides = [1.0, 0.1, 0.08];
    std::fs::write(at("beam.stl"), stl(sides)).expect("written");
    let ran =
        vademecum(&["init", &at("beam.stl"), "--hold", "x_min", "--cells", "20", "-o", &at("beam.toml")]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let text = std::fs::read_to_string(at("beam.toml")).expect("a problem");
    assert!(text.contains("\nembedded = \"beam.stl\""), "{text}");
    let built = vademecum(&["build", &at("beam.toml"), "-o", &at("beam.vdm")]);
    assert_eq!(built.code, Some(0), "{}", built.stderr);
    let bytes = std::fs::read(at("beam.vdm")).expect("a file");
    let file = File::parse(&bytes).expect("a sound file");
    let surface = EmbeddedSurface::new(&file).expect("sound").expect("an embedded surface");
    let numbers = |kind| -> Vec<f64> {
        file.section(kind).and_then(|s| s.numbers().ok()).expect("numbers").iter().collect()
    };
    let count = 3 * file.metadata().n_surface_nodes as usize;
    let nodes = numbers(SectionKind::NodeCoordinates)[..count].to_vec();
    let mut places = vec![0.0; 3 * surface.n_vertices()];
    surface.interpolate_into(&nodes, &mut places).expect("positions");
    let places = places.as_chunks::<3>().0;
    let near = |p: [f64; 3]| places.iter().any(|q| (0..3).all(|k| (p[k] - q[k]).abs() < 1e-6));
    assert!((0..8).all(|i| near(std::array::from_fn(|k| if i >> k & 1 == 1 { sides[k] } else { 0.0 }))));
    let longest = surface.triangles().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]).map(|ends| {
        let [p, q] = ends.map(|vertex| places[vertex as usize]);
        (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt()
    });
    let longest = longest.fold(0.0, f64::max);
    assert!(longest < 0.15, "{longest}");
    // A shear and a turn.
    let map = |[x, y, z]: [f64; 3]| [0.3 * y - 0.2 * z, 0.1 * z - 0.3 * x, 0.2 * x + 0.5 * y];
    let at_nodes: Vec<f64> = nodes.as_chunks::<3>().0.iter().flat_map(|p| map(*p)).collect();
    let mut moved = vec![0.0; 3 * surface.n_vertices()];
    surface.interpolate_into(&at_nodes, &mut moved).expect("displacements");
    for (place, moved) in places.iter().zip(moved.as_chunks::<3>().0) {
        let expected = map(*place);
        assert!((0..3).all(|k| (moved[k] - expected[k]).abs() < 1e-6), "{place:?}: {moved:?}, {expected:?}");
    }
    assert!(surface.interpolate_into(&at_nodes[3..], &mut moved.clone()).is_err());
    // A stripped file keeps it, one of probes does not.
    for (keep, kept) in [("surface", true), ("probes", false)] {
        let to = at(&format!("{keep}.vdm"));
        let ran = vademecum(&["strip", &at("beam.vdm"), "-o", &to, "--keep", keep]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        let bytes = std::fs::read(&to).expect("a file");
        assert_eq!(File::parse(&bytes).expect("sound").section(SectionKind::EmbeddedNodes).is_some(), kept);
    }
    // A flag without volume, which the tetrahedra do not reach, is left out.
    let flag = "facet normal 0 0 0\nouter loop\nvertex 0.5 0.05 0.08\nvertex 0.5 0.06 0.6\nvertex 0.5 0.04 0.6\nendloop\n\
                endfacet\nendsolid";
    std::fs::write(at("flag.stl"), stl(sides).replace("endsolid", flag)).expect("written");
    std::fs::write(at("flag.toml"), text.replace("embedded = \"beam.stl\"", "embedded = \"flag.stl\""))
        .expect("written");
    let built = vademecum(&["build", &at("flag.toml"), "-o", &at("flag.vdm")]);
    assert_eq!(built.code, Some(0), "{}", built.stderr);
    let bytes = std::fs::read(at("flag.vdm")).expect("a file");
    let flagged = File::parse(&bytes).expect("a sound file");
    let flagged = EmbeddedSurface::new(&flagged).expect("sound").expect("an embedded surface");
    // Its foot is near enough to be kept.
    let more = flagged.n_triangles() - surface.n_triangles();
    assert!(more < 20, "{more}");
    // Something else than the surface of this body.
    let problem =
        |embedded: &str| text.replace("embedded = \"beam.stl\"", &format!("embedded = \"{embedded}\""));
    std::fs::write(at("far.stl"), stl([9.0, 0.1, 0.08])).expect("written");
    std::fs::write(at("note.txt"), "no surface\n").expect("written");
    for (name, said) in
        [("far.stl", "off the mesh"), ("note.txt", "expected an STL"), ("none.stl", "none.stl")]
    {
        std::fs::write(at("wrong.toml"), problem(name)).expect("written");
        let ran = vademecum(&["build", &at("wrong.toml"), "-o", &at("wrong.vdm")]);
        assert!(ran.code == Some(4) && ran.stderr.contains(said), "{:?} {}", ran.code, ran.stderr);
    }
}
