//! Hexahedra, wedges and pyramids: node orders of every format, faces of decks, what cannot be computed with,
//! and a stiffness of another program.

mod common;

use std::fmt::Write;

use faer::Mat;
use vademecum_build::fem::{Material, Model};
use vademecum_build::mesh::surface::Surface;
use vademecum_build::mesh::{self, ElementKind, Flaw, Hexahedra, Mesh, MeshError};

fn read_text(name: &str, text: &str) -> Result<Mesh, MeshError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    mesh::read(&path)
}

/// A map without any symmetry, which bends edges and faces.
fn bent([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        x + 0.11 * y * z + 0.05 * y * y,
        1.3 * y - 0.07 * x * x + 0.04 * z,
        0.8 * z + 0.09 * x * y + 0.06 * x * x,
    ]
}

const CORNERS: [[f64; 3]; 8] = [
    [-1., -1., -1.],
    [1., -1., -1.],
    [1., 1., -1.],
    [-1., 1., -1.],
    [-1., -1., 1.],
    [1., -1., 1.],
    [1., 1., 1.],
    [-1., 1., 1.],
];

fn wedge_corners() -> Vec<[f64; 3]> {
    [-1., 1.].into_iter().flat_map(|z| [[0., 0., z], [1., 0., z], [0., 1., z]]).collect()
}

fn pyramid_corners() -> Vec<[f64; 3]> {
    [[-1., -1., 0.], [1., -1., 0.], [1., 1., 0.], [-1., 1., 0.], [0., 0., 1.]].to_vec()
}

/// Corners, and middles of the given groups of corners.
fn places(corners: &[[f64; 3]], groups: &[&[usize]]) -> Vec<[f64; 3]> {
    let middle = |group: &&[usize]| -> [f64; 3] {
        std::array::from_fn(|i| group.iter().map(|&c| corners[c][i]).sum::<f64>() / group.len() as f64)
    };
    corners.iter().copied().chain(groups.iter().map(middle)).collect()
}

/// VTK's order, from the pictures of its manual, which is that of Abaqus for all but the 27-node hexahedron.
fn vtk_groups(kind: ElementKind) -> Vec<&'static [usize]> {
    let hex: Vec<&[usize]> = vec![
        &[0, 1],
        &[1, 2],
        &[2, 3],
        &[3, 0],
        &[4, 5],
        &[5, 6],
        &[6, 7],
        &[7, 4],
        &[0, 4],
        &[1, 5],
        &[2, 6],
        &[3, 7],
    ];
    match kind {
        ElementKind::Hex20 => hex,
        ElementKind::Hex27 => {
            let mut all = hex;
            let faces: [&[usize]; 7] = [
                &[0, 3, 4, 7],
                &[1, 2, 5, 6],
                &[0, 1, 4, 5],
                &[2, 3, 6, 7],
                &[0, 1, 2, 3],
                &[4, 5, 6, 7],
                &[0, 1, 2, 3, 4, 5, 6, 7],
            ];
            all.extend(faces);
            all
        }
        ElementKind::Wedge15 => {
            vec![&[0, 1], &[1, 2], &[2, 0], &[3, 4], &[4, 5], &[5, 3], &[0, 3], &[1, 4], &[2, 5]]
        }
        ElementKind::Pyramid13 => {
            vec![&[0, 1], &[1, 2], &[2, 3], &[3, 0], &[0, 4], &[1, 4], &[2, 4], &[3, 4]]
        }
        _ => vec![],
    }
}

/// Gmsh's order, from its manual ("Node ordering").
fn gmsh_groups(kind: ElementKind) -> Vec<&'static [usize]> {
    let hex: Vec<&[usize]> = vec![
        &[0, 1],
        &[0, 3],
        &[0, 4],
        &[1, 2],
        &[1, 5],
        &[2, 3],
        &[2, 6],
        &[3, 7],
        &[4, 5],
        &[4, 7],
        &[5, 6],
        &[6, 7],
    ];
    match kind {
        ElementKind::Hex20 => hex,
        ElementKind::Hex27 => {
            let mut all = hex;
            let faces: [&[usize]; 7] = [
                &[0, 1, 2, 3],
                &[0, 1, 4, 5],
                &[0, 3, 4, 7],
                &[1, 2, 5, 6],
                &[2, 3, 6, 7],
                &[4, 5, 6, 7],
                &[0, 1, 2, 3, 4, 5, 6, 7],
            ];
            all.extend(faces);
            all
        }
        ElementKind::Wedge15 => {
            vec![&[0, 1], &[0, 2], &[0, 3], &[1, 2], &[1, 4], &[2, 5], &[3, 4], &[3, 5], &[4, 5]]
        }
        ElementKind::Pyramid13 => {
            vec![&[0, 1], &[0, 3], &[0, 4], &[1, 2], &[1, 4], &[2, 3], &[2, 4], &[3, 4]]
        }
        _ => vec![],
    }
}

fn corners(kind: ElementKind) -> Vec<[f64; 3]> {
    match kind {
        ElementKind::Wedge6 | ElementKind::Wedge15 => wedge_corners(),
        ElementKind::Pyramid5 | ElementKind::Pyramid13 => pyramid_corners(),
        _ => CORNERS.to_vec(),
    }
}

const KINDS: [(ElementKind, u32, u32, &str); 7] = [
    (ElementKind::Hex8, 5, 12, "C3D8I"),
    (ElementKind::Hex20, 17, 25, "C3D20"),
    (ElementKind::Hex27, 12, 29, "C3D27"),
    (ElementKind::Wedge6, 6, 13, "C3D6"),
    (ElementKind::Wedge15, 18, 26, "C3D15"),
    (ElementKind::Pyramid5, 7, 14, "C3D5"),
    (ElementKind::Pyramid13, 19, 27, ""),
];

/// One element as each format writes it.
fn files(kind: ElementKind) -> Vec<(&'static str, String)> {
    let &(_, gmsh, vtk, deck) = KINDS.iter().find(|row| row.0 == kind).unwrap();
    let of = |groups: &[&[usize]]| -> Vec<[f64; 3]> {
        places(&corners(kind), groups).into_iter().map(bent).collect()
    };
    let lines = |nodes: &[[f64; 3]], separator: &str, numbered: bool| {
        let mut text = String::new();
        for (i, p) in nodes.iter().enumerate() {
            let number = if numbered { format!("{}{separator}", i + 1) } else { String::new() };
            writeln!(text, "{number}{}{separator}{}{separator}{}", p[0], p[1], p[2]).unwrap();
        }
        text
    };
    let numbers = |from: usize, separator: &str| {
        (from..from + kind.nodes()).map(|i| i.to_string()).collect::<Vec<_>>().join(separator)
    };
    let n = kind.nodes();
    let in_gmsh = of(&gmsh_groups(kind));
    let in_vtk = of(&vtk_groups(kind));
    let mut all = vec![
        (
            "one.msh",
            format!(
                "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{n}\n{}$EndNodes\n$Elements\n1\n1 {gmsh} 2 1 1 {}\n$EndElements\n",
                lines(&in_gmsh, " ", true),
                numbers(1, " ")
            ),
        ),
        (
            "one4.msh",
            format!(
                "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 {n} 1 {n}\n3 1 0 {n}\n{}\n{}$EndNodes\n\
                 $Elements\n1 1 1 1\n3 1 {gmsh} 1\n1 {}\n$EndElements\n",
                numbers(1, "\n"),
                lines(&in_gmsh, " ", false),
                numbers(1, " ")
            ),
        ),
        (
            "one.vtk",
            format!(
                "# vtk DataFile Version 2.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {n} double\n{}CELLS 1 {}\n{n} {}\n\
                 CELL_TYPES 1\n{vtk}\n",
                lines(&in_vtk, " ", false),
                n + 1,
                numbers(0, " ")
            ),
        ),
    ];
    if kind == ElementKind::Hex27 {
        // Abaqus: the middle of the element before those of its faces S1 to S6.
        let mut groups = vtk_groups(ElementKind::Hex20);
        let rest: [&[usize]; 7] = [
            &[0, 1, 2, 3, 4, 5, 6, 7],
            &[0, 1, 2, 3],
            &[4, 5, 6, 7],
            &[0, 1, 4, 5],
            &[1, 2, 5, 6],
            &[2, 3, 6, 7],
            &[0, 3, 4, 7],
        ];
        groups.extend(rest);
        all.push(("one.inp", deck_text(deck, &lines(&of(&groups), ", ", true), &numbers(1, ", "))));
    } else if !deck.is_empty() {
        all.push(("one.inp", deck_text(deck, &lines(&in_vtk, ", ", true), &numbers(1, ", "))));
    }
    all.extend(nastran_text(kind, &of(&nastran_groups(kind))).map(|text| ("one.bdf", text)));
    all.extend(universal_text(kind, &in_vtk).map(|text| ("one.unv", text)));
    all.extend(ansys_text(kind, &in_vtk).map(|text| ("one.cdb", text)));
    all
}

/// Nastran's order, from its manual: upright edges before those of the top.
fn nastran_groups(kind: ElementKind) -> Vec<&'static [usize]> {
    match kind {
        ElementKind::Hex20 => vec![
            &[0, 1],
            &[1, 2],
            &[2, 3],
            &[3, 0],
            &[0, 4],
            &[1, 5],
            &[2, 6],
            &[3, 7],
            &[4, 5],
            &[5, 6],
            &[6, 7],
            &[7, 4],
        ],
        ElementKind::Wedge15 => {
            vec![&[0, 1], &[1, 2], &[2, 0], &[0, 3], &[1, 4], &[2, 5], &[3, 4], &[4, 5], &[5, 3]]
        }
        _ => vtk_groups(kind),
    }
}

/// Bulk data in free fields; none of kinds that Nastran does not have.
fn nastran_text(kind: ElementKind, nodes: &[[f64; 3]]) -> Option<String> {
    let card = match kind {
        ElementKind::Hex8 | ElementKind::Hex20 => "CHEXA",
        ElementKind::Wedge6 | ElementKind::Wedge15 => "CPENTA",
        ElementKind::Pyramid5 | ElementKind::Pyramid13 => "CPYRAM",
        _ => return None,
    };
    let mut text = String::from("CEND\nBEGIN BULK\n");
    for (i, p) in nodes.iter().enumerate() {
        writeln!(text, "GRID,{},,{},{},{}", i + 1, p[0], p[1], p[2]).unwrap();
    }
    let fields: Vec<String> = [1, 7].into_iter().chain(1..=nodes.len()).map(|i| i.to_string()).collect();
    let rows: Vec<String> = fields.chunks(8).map(|row| row.join(",")).collect();
    writeln!(text, "{card},{}\nENDDATA", rows.join(",+\n+,")).unwrap();
    Some(text)
}

/// A universal file; none of kinds that it does not have. From the manual of I-DEAS (dataset 2412): corners
/// and middles of the lower face in turn, the middles of upright edges, the upper face in turn; of a
/// tetrahedron the middles of the edges to the apex, and the apex.
fn universal_text(kind: ElementKind, nodes: &[[f64; 3]]) -> Option<String> {
    // Numbers of the nodes in VTK's order, as the file lists them.
    let (code, order): (usize, Vec<usize>) = match kind {
        ElementKind::Hex8 => (115, (1..=8).collect()),
        ElementKind::Wedge6 => (112, (1..=6).collect()),
        ElementKind::Hex20 => {
            (116, vec![1, 9, 2, 10, 3, 11, 4, 12, 17, 18, 19, 20, 5, 13, 6, 14, 7, 15, 8, 16])
        }
        ElementKind::Wedge15 => (113, vec![1, 7, 2, 8, 3, 9, 13, 14, 15, 4, 10, 5, 11, 6, 12]),
        ElementKind::Tet10 => (118, vec![1, 5, 2, 6, 3, 7, 8, 9, 10, 4]),
        _ => return None,
    };
    let mut text = "    -1\n  2411\n".to_string();
    for (i, p) in nodes.iter().enumerate() {
        let [x, y, z] = p.map(|x| format!("{x:.17E}").replace('E', "D"));
        writeln!(text, "{:10}{:10}{:10}{:10}\n {x} {y} {z}", i + 1, 1, 1, 11).unwrap();
    }
    let head = [1, code, 1, 2, 7, order.len()].map(|number| format!("{number:10}")).concat();
    let rows: Vec<String> =
        order.chunks(8).map(|row| row.iter().map(|n| format!("{n:10}")).collect()).collect();
    Some(format!("{text}    -1\n    -1\n  2412\n{head}\n{}\n    -1\n", rows.join("\n")))
}

#[test]
fn a_curved_tetrahedron_of_a_universal_file_has_its_nodes_in_place() {
    let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
    let edges: [&[usize]; 6] = [&[0, 1], &[1, 2], &[2, 0], &[0, 3], &[1, 3], &[2, 3]];
    let nodes: Vec<[f64; 3]> = places(&corners, &edges).into_iter().map(bent).collect();
    let text = universal_text(ElementKind::Tet10, &nodes).unwrap();
    let mesh = read_text("one.unv", &text).unwrap();
    let found: Vec<[f64; 3]> = mesh.element(0).iter().map(|&node| mesh.nodes[node as usize]).collect();
    assert_eq!(found, nodes);
}

#[test]
fn a_universal_file_has_groups_units_and_elements_that_are_named() {
    let nodes = CORNERS.map(|p| p.to_vec());
    let node = |(i, p): (usize, &Vec<f64>)| format!("{} 1 1 11 {} {} {}\n", i + 1, p[0], p[1], p[2]);
    let nodes: String = nodes.iter().enumerate().map(node).collect();
    // The older datasets 15 and 780, a face of four nodes, a beam, a mass.
    let text = format!(
        "    -1\n   164\n         1SI: mm          2\n 1.0D+03 1.0D+00 1.0D+00 1.0D+00\n 2.7315D+02\n    -1\n\
         \x20   -1\n    15\n{nodes}    -1\n    -1\n   780\n1 115 1 1 1 5 7 8\n1 2 3 4 5 6 7 8\n\
         2 94 1 1 1 5 7 4\n5 6 7 8\n3 21 1 1 1 5 7 2\n0 1 1\n1 2\n4 161 1 1 1 5 7 1\n1\n    -1\n\
         \x20   -1\n   151\nanything\n    -1\n\
         \x20   -1\n  2467\n1 0 0 0 0 0 0 1\ntop side\n8 2 0 0\n2 0 0 0 0 0 0 3\nends\n7 1 0 0 7 7 0 0\n7 3 0 0\n    -1\n\
         \x20   -1\n  2432\n3 0 0 0 0 0 0 1\nolder\n7 8\n    -1\n"
    );
    let mesh = read_text("one.unv", &text).unwrap();
    assert!((mesh.volume() - 8.0).abs() < 1e-14 && mesh.regions[0].tag == 5);
    assert_eq!(mesh.node_groups["top side"], [4, 5, 6, 7]);
    assert_eq!(mesh.node_groups["ends"], [0, 2, 6]);
    assert_eq!(mesh.node_groups["older"], [7]);
    let surface = Surface::of(&mesh);
    assert_eq!(surface.area_of(&mesh, &mesh.facet_groups["top side"]), 4.0);
    let notes = mesh.notes.join("\n");
    for part in ["1 beams of type 21", "1 lumped masses of type 161", "scale = 0.001"] {
        assert!(notes.contains(part), "{notes}");
    }
    for (from, to, expected) in [
        ("    -1\n   164", "   164", "a line of -1 before a dataset"),
        ("1 115 1", "1 116 1", "20"),
        ("5 6 7 8\n", "5 6 7 9\n", "a node number that the file defines"),
        ("0 1\ntop", "0 999999\ntop", "can hold"),
    ] {
        let wrong = text.replacen(from, to, 1);
        let said = read_text("one.unv", &wrong).unwrap_err().to_string();
        assert!(said.contains("one.unv") && said.contains(expected), "{from}: {said}");
    }
}

/// Blocks of nodes and elements; wedges and pyramids are bricks with repeated nodes, as the program has them.
fn ansys_text(kind: ElementKind, nodes: &[[f64; 3]]) -> Option<String> {
    let (element, numbers): (usize, Vec<usize>) = match kind {
        ElementKind::Hex8 => (185, (1..=8).collect()),
        ElementKind::Hex20 => (186, (1..=20).collect()),
        ElementKind::Wedge6 => (185, vec![1, 2, 3, 3, 4, 5, 6, 6]),
        ElementKind::Wedge15 => {
            (186, vec![1, 2, 3, 3, 4, 5, 6, 6, 7, 8, 3, 9, 10, 11, 6, 12, 13, 14, 15, 15])
        }
        ElementKind::Pyramid5 => (185, vec![1, 2, 3, 4, 5, 5, 5, 5]),
        ElementKind::Pyramid13 => (186, vec![1, 2, 3, 4, 5, 5, 5, 5, 6, 7, 8, 9, 5, 5, 5, 5, 10, 11, 12, 13]),
        _ => return None,
    };
    let mut text =
        format!("/PREP7\nET,1,{element}\nNBLOCK,6,SOLID,{n},{n}\n(3i9,6e26.16e3)\n", n = nodes.len());
    for (i, p) in nodes.iter().enumerate() {
        writeln!(text, "{:9}{:9}{:9}{:26.16e}{:26.16e}{:26.16e}", i + 1, 0, 0, p[0], p[1], p[2]).unwrap();
    }
    text += "N,R5.3,LOC,       -1,\nEBLOCK,19,SOLID,1,1\n(19i9)\n";
    for value in [1, 1, 1, 1, 0, 0, 0, 0, numbers.len(), 0, 1] {
        write!(text, "{value:9}").unwrap();
    }
    for (i, number) in numbers.iter().enumerate() {
        let end = if i == 8 { "\n" } else { "" };
        write!(text, "{end}{number:9}").unwrap();
    }
    Some(text + "\n       -1\n")
}

fn deck_text(kind: &str, nodes: &str, numbers: &str) -> String {
    // Sixteen numbers in a line at most, as the programs write.
    let all: Vec<&str> = numbers.split(", ").collect();
    let rows: Vec<String> = all.chunks(12).map(|row| row.join(", ")).collect();
    format!("*NODE\n{nodes}*ELEMENT, TYPE={kind}, ELSET=all\n1, {}\n", rows.join(",\n"))
}

#[test]
fn node_orders_of_all_formats_become_ours() {
    for (kind, ..) in KINDS {
        let expected: Vec<[f64; 3]> =
            places(&corners(kind), &vtk_groups(kind)).into_iter().map(bent).collect();
        let mut volumes = vec![];
        for (name, text) in files(kind) {
            let mesh = read_text(name, &text).unwrap_or_else(|error| panic!("{kind:?} {name}: {error}"));
            assert_eq!(mesh.kinds.uniform(), Some(kind), "{name}");
            for (place, &node) in mesh.element(0).iter().enumerate() {
                let (found, wanted) = (mesh.nodes[node as usize], expected[place]);
                assert_eq!(found, wanted, "{kind:?} {name}: node {place}");
            }
            volumes.push(mesh.volume());
        }
        assert!(volumes.windows(2).all(|pair| pair[0] == pair[1]), "{kind:?} {volumes:?}");
    }
}

#[test]
fn medit_and_mfem_have_their_linear_kinds() {
    let points: Vec<[f64; 3]> = CORNERS.to_vec();
    let rows: String = points.iter().map(|p| format!("{} {} {} 0\n", p[0], p[1], p[2])).collect();
    let medit = format!(
        "MeshVersionFormatted 2\nDimension 3\nVertices\n8\n{rows}Hexahedra\n1\n1 2 3 4 5 6 7 8 3\nEnd\n"
    );
    let mesh = read_text("one.mesh", &medit).unwrap();
    assert_eq!(mesh.kinds.uniform(), Some(ElementKind::Hex8));
    assert!((mesh.volume() - 8.0).abs() < 1e-14);
    let rows: String = points.iter().map(|p| format!("{} {} {}\n", p[0], p[1], p[2])).collect();
    let mfem = format!(
        "MFEM mesh v1.0\n\ndimension\n3\n\nelements\n2\n1 6 0 1 2 4 5 6\n1 6 0 2 3 4 6 7\n\nboundary\n0\n\nvertices\n8\n3\n{rows}"
    );
    let mesh = read_text("one.mesh", &mfem).unwrap();
    assert_eq!((mesh.kinds.uniform(), mesh.element_count()), (Some(ElementKind::Wedge6), 2));
    assert!((mesh.volume() - 8.0).abs() < 1e-14);
    assert_eq!(Surface::of(&mesh).triangles.len(), 12);
}

#[test]
fn elements_inside_out_are_turned_round() {
    for (kind, ..) in KINDS {
        let (name, text) = files(kind).remove(2);
        let right = read_text(name, &text).unwrap();
        // Mirrored space turns the element inside out.
        let mirrored: Vec<String> = text
            .lines()
            .enumerate()
            .map(|(line, row)| match (5..5 + kind.nodes()).contains(&line) {
                true => row.strip_prefix('-').map_or_else(|| format!("-{row}"), str::to_string),
                false => row.to_string(),
            })
            .collect();
        let turned = read_text(name, &mirrored.join("\n")).unwrap();
        assert!(turned.notes.iter().any(|note| note.contains("1 inverted elements")), "{kind:?}");
        assert!((turned.volume() / right.volume() - 1.0).abs() < 1e-12, "{kind:?}");
    }
}

/// Two cells side by side, the right one cut.
fn two_cells(right: &str, count: usize, types: &str, width: usize) -> String {
    let mut points = String::new();
    for x in [0, 1, 2] {
        for [y, z] in [[0, 0], [1, 0], [1, 1], [0, 1]] {
            writeln!(points, "{x} {y} {z}").unwrap();
        }
    }
    format!(
        "# vtk DataFile Version 2.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 12 double\n{points}CELLS {} {}\n\
         8 0 1 2 3 4 5 6 7\n{right}CELL_TYPES {}\n12\n{types}",
        1 + count,
        9 + count * (width + 1),
        1 + count
    )
}

#[test]
fn quadrangles_that_meet_triangles_are_refused_by_name() {
    let fits = two_cells("8 4 5 6 7 8 9 10 11\n", 1, "12\n", 8);
    let mesh = read_text("fits.vtk", &fits).unwrap();
    assert_eq!(Surface::of(&mesh).facet_count(), 10);
    assert!((mesh.volume() - 2.0).abs() < 1e-14);
    let tets = "4 4 5 6 10\n4 4 6 7 10\n4 4 7 11 10\n4 4 11 8 10\n4 4 8 9 10\n4 4 9 5 10\n";
    let split = two_cells(tets, 6, &"10\n".repeat(6), 4);
    let error = read_text("split.vtk", &split).unwrap_err();
    assert!(matches!(&error.problems()[0], Flaw::SplitFaces { count: 1, .. }), "{error}");
    assert!(error.to_string().contains("put pyramids between"), "{error}");
}

#[test]
fn faces_of_a_deck_are_those_of_its_elements() {
    let nodes: String = CORNERS
        .iter()
        .enumerate()
        .map(|(i, p)| format!("{}, {}, {}, {}\n", i + 1, p[0], p[1], p[2]))
        .collect();
    let faces = ["S1", "S2", "S3", "S4", "S5", "S6"];
    let surfaces: String = faces.iter().map(|face| format!("*SURFACE, NAME={face}\nall, {face}\n")).collect();
    let deck = format!("*NODE\n{nodes}*ELEMENT, TYPE=C3D8, ELSET=all\n1, 1, 2, 3, 4, 5, 6, 7, 8\n{surfaces}");
    let mesh = read_text("faces.inp", &deck).unwrap();
    assert_eq!(mesh.regions[0].hexahedra, Some(Hexahedra::Full));
    let surface = Surface::of(&mesh);
    let (axis, side) = ([2, 2, 1, 0, 1, 0], [-1.0, 1.0, -1.0, 1.0, 1.0, -1.0]);
    for (i, face) in faces.iter().enumerate() {
        assert_eq!(mesh.node_groups[*face].len(), 4, "{face}");
        for &node in &mesh.node_groups[*face] {
            assert_eq!(mesh.nodes[node as usize][axis[i]], side[i], "{face}");
        }
        assert_eq!(mesh.facet_groups[*face].len(), 1, "{face}");
        assert_eq!(surface.area_of(&mesh, &mesh.facet_groups[*face]), 4.0, "{face}");
    }
    let wrong = format!("{deck}*SURFACE, NAME=more\nall, S7\n");
    assert!(read_text("wrong.inp", &wrong).unwrap_err().to_string().contains("S1 to S6"));
    // Three numbers of CalculiX behind the nodes of C3D8I.
    let more = deck.replace("C3D8", "C3D8I").replace("7, 8\n", "7, 8, 9, 10, 11,\n");
    assert_eq!(read_text("more.inp", &more).unwrap().regions[0].hexahedra, Some(Hexahedra::Incompatible));
    let mixed = deck.replace(
        "*SURFACE, NAME=S1",
        "*NODE\n9, -1, -1, 3\n10, 1, -1, 3\n11, 1, 1, 3\n12, -1, 1, 3\n\
         *ELEMENT, TYPE=C3D8R, ELSET=all\n2, 5, 6, 7, 8, 9, 10, 11, 12\n*SURFACE, NAME=S1",
    );
    let regions = read_text("mixed.inp", &mixed).unwrap().regions;
    let named = |k: usize| (regions[k].name.as_str(), regions[k].hexahedra.unwrap());
    let expected = [("all", Hexahedra::Full), ("all C3D8R", Hexahedra::Reduced)];
    assert_eq!([named(0), named(1)], expected);
    // Nodes after the elements that name them, and a node without coordinates.
    let at = deck.find("*ELEMENT").unwrap();
    let late = format!("{}{}", &deck[at..], &deck[..at]);
    assert_eq!(read_text("late.inp", &late).unwrap().volume(), mesh.volume());
    assert!(
        read_text("bare.inp", "*NODE\n1\n2, 1.0\n3, 0, 1.0\n4,,,1.0\n*ELEMENT, TYPE=C3D4\n1,1,2,3,4\n")
            .is_ok()
    );
}

#[test]
fn mean_dilatation_is_the_stiffness_of_abaqus() {
    let Some(folder) = common::real_meshes() else { return };
    let folder = folder.join("../decks/exudyn");
    let mesh = mesh::read(&folder.join("blockC3D8.inp")).unwrap();
    assert_eq!(mesh.regions[0].hexahedra, Some(Hexahedra::MeanDilatation));
    let ids = mesh.node_ids.clone();
    let steel = Material::isotropic(2e11, 0.3, 2900.0);
    let n = 3 * mesh.nodes.len();
    let model = Model::assemble(mesh, &[steel], &vec![false; n]).unwrap();
    let mut ours = Mat::<f64>::zeros(n, n);
    model.pencil().stiffness().mul_into(Mat::identity(n, n).as_ref(), ours.as_mut());
    let text = std::fs::read_to_string(folder.join("blockC3D8_STIF1.mtx")).unwrap();
    let mut theirs = Mat::<f64>::zeros(n, n);
    // Rows are 3 (node − 1) + component, from 1.
    let row_of: Vec<usize> = (0..n).map(|dof| 3 * (ids[dof / 3] as usize - 1) + dof % 3).collect();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        let mut index = || words.next().unwrap().parse::<usize>().unwrap() - 1;
        let (row, column) = (index(), index());
        theirs[(row, column)] = words.next().unwrap().parse().unwrap();
    }
    let largest = ours.norm_max();
    let off = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let off = off.map(|(i, j)| (ours[(i, j)] - theirs[(row_of[i], row_of[j])]).abs()).fold(0.0, f64::max);
    assert!(off < 1e-9 * largest, "{:e}", off / largest);
}
