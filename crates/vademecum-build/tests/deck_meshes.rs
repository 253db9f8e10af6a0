//! Nastran and Ansys files: fields, coordinate systems, groups, middles that are left out, bricks with
//! repeated corners, and damage.

mod common;

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::PathBuf;

use vademecum_build::mesh::ansys::{commands, rotations};
use vademecum_build::mesh::nastran::{cards, ranges, systems};
use vademecum_build::mesh::{self, ElementKind, Hexahedra, Mesh, MeshError, Order, RawMesh, inspect};

fn parse(name: &str, text: &str) -> Result<RawMesh, MeshError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    mesh::parse(&path)
}

fn read(name: &str, text: &str) -> Mesh {
    let raw = parse(name, text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    mesh::repaired(raw, 0.0).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn said(name: &str, text: &str) -> String {
    match parse(name, text) {
        Ok(raw) => panic!("{:?} of {text}", raw.notes),
        Err(error) => error.to_string(),
    }
}

fn has_note(mesh: &Mesh, part: &str) {
    assert!(mesh.notes.iter().any(|note| note.contains(part)), "`{part}` is not in {:?}", mesh.notes);
}

const CUBE: [[f64; 3]; 8] = [
    [0., 0., 0.],
    [1., 0., 0.],
    [1., 1., 0.],
    [0., 1., 0.],
    [0., 0., 1.],
    [1., 0., 1.],
    [1., 1., 1.],
    [0., 1., 1.],
];

fn grids(points: &[[f64; 3]]) -> String {
    points.iter().zip(1..).map(|(p, i)| format!("GRID,{i},,{:?},{:?},{:?}\n", p[0], p[1], p[2])).collect()
}

/// A file of Ansys: points, element types with commands about them, and rows of type, material and nodes.
fn cdb(points: &[[f64; 3]], types: &str, elements: &[(usize, usize, &[usize])]) -> String {
    let n = points.len();
    let mut text = format!("/PREP7\n{types}NBLOCK,6,SOLID,{n},{n}\n(3i8,6e20.13)\n");
    for (i, p) in points.iter().enumerate() {
        writeln!(text, "{:8}{:8}{:8}{:20.13e}{:20.13e}{:20.13e}", i + 1, 0, 0, p[0], p[1], p[2]).unwrap();
    }
    writeln!(text, "N,R5.3,LOC,       -1,\nEBLOCK,19,SOLID,{0},{0}\n(19i8)", elements.len()).unwrap();
    for (number, (kind, material, nodes)) in elements.iter().enumerate() {
        for value in [*material, *kind, 1, 1, 0, 0, 0, 0, nodes.len(), 0, number + 1] {
            write!(text, "{value:8}").unwrap();
        }
        for (i, node) in nodes.iter().enumerate() {
            write!(text, "{}{node:8}", if i == 8 { "\n" } else { "" }).unwrap();
        }
        text.push('\n');
    }
    text + "      -1\n"
}

#[test]
fn grid_points_lie_in_their_coordinate_systems() {
    // A quarter of a ring, in a cylinder about the basic x axis that is moved by 2.
    let mut text = String::from(
        "CORD2C  5       0       2.      0.      0.      3.      0.      0.\n        2.      1.      0.\n\
         GRDSET          5                               5       456\n",
    );
    let corners = [
        [1., 0., 0.],
        [2., 0., 0.],
        [2., 90., 0.],
        [1., 90., 0.],
        [1., 0., 1.],
        [2., 0., 1.],
        [2., 90., 1.],
        [1., 90., 1.],
    ];
    for (i, [r, angle, z]) in corners.into_iter().enumerate() {
        writeln!(text, "GRID    {:<8}        {r:<8?}{angle:<8?}{z:<8?}", i + 1).unwrap();
    }
    text += "GRID,9,0,7.,8.,9.,0\nCHEXA,1,4,1,2,3,4,5,6,+\n+,7,8\nPSOLID,4,1,,TWO,,FULL\n";
    let raw = parse("a.bdf", &text).unwrap();
    let near = |found: [f64; 3], expected: [f64; 3]| {
        assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-12), "{found:?} is not {expected:?}");
    };
    near(raw.nodes[1], [2.0, 2.0, 0.0]);
    near(raw.nodes[2], [2.0, 0.0, 2.0]);
    near(raw.nodes[7], [3.0, 0.0, 1.0]);
    near(raw.nodes[8], [7.0, 8.0, 9.0]);
    let mesh = mesh::repaired(raw, 0.0).unwrap();
    assert_eq!((mesh.regions[0].tag, mesh.regions[0].name.as_str()), (4, "PSOLID 4"));
    assert_eq!(mesh.regions[0].hexahedra, Some(Hexahedra::Full));
    let path = PathBuf::from("a.bdf");
    let systems = systems(&cards(&path, text.as_bytes()).unwrap()).unwrap();
    near(systems.axes(5, [2.0, 0.0, 3.0]).unwrap()[0], [0.0, 0.0, 1.0]);
    assert!(said("a.bdf", &text.replace("CORD2C  5", "CORD2C  6")).contains("coordinate system 5"));
}

#[test]
fn nastran_elements_without_some_middles_get_them() {
    // Two tetrahedra of the second order on one face; the first one lacks the middle of 1-2 and of 2-3, the
    // second one lacks that of 2-3 and has that of 1-2.
    let points = [[0., 0., 0.], [2., 0., 0.], [0., 2., 0.], [0., 0., 2.], [0., 0., -2.], [1., 0.1, 0.]];
    let text = format!(
        "{}GRID,20,,0.,1.,0.\nCTETRA,1,3,1,2,3,4,,,+\n+,20,0\nCTETRA,2,3,2,1,3,5,6,20,+\n+,,,,\n\
         SPC1,4,123,2,3,4\nSPC,4,5,3\n",
        grids(&points)
    );
    let mesh = read("a.bdf", &text);
    assert_eq!((mesh.kinds.uniform(), mesh.nodes.len()), (Some(ElementKind::Tet10), 14));
    has_note(&mesh, "7 nodes that the file leaves out were added");
    // The curved middle of the neighbour, the given one, a new one that both share.
    let middles = |element: usize| mesh.element(element)[4..7].to_vec();
    assert_eq!(mesh.nodes[middles(0)[0] as usize], [1., 0.1, 0.]);
    assert_eq!(mesh.nodes[middles(0)[2] as usize], [0., 1., 0.]);
    assert_eq!(mesh.nodes[middles(0)[1] as usize], [1., 1., 0.]);
    assert_eq!(mesh.node_ids[middles(0)[1] as usize], 21);
    assert_eq!(middles(0).iter().filter(|middle| middles(1).contains(middle)).count(), 3);
    // Corners 2, 3, 4, 5 and the straight edges between them.
    assert_eq!(mesh.node_groups["SPC 4"].len(), 4 + 5);
    // Without any middle an element is linear.
    let linear = text.replace("+,20,0", "+,,").replace(",6,20,+", ",,,+");
    assert_eq!(read("a.bdf", &linear).kinds.uniform(), Some(ElementKind::Tet4));
}

#[test]
fn single_point_constraints_become_groups() {
    let text = format!(
        "{}CHEXA,1,1,1,2,3,4,5,6,+\n+,7,8\n\
         SPC1,1,123456,1,THRU,4\nSPC1,3,456,1,THRU,8\nSPC,3,8,2,0.,6,5\nSPCADD,9,1,3,7\n\
         SPC1,5,1,2,THRU,99999999,EXCEPT,3,4\n\
         CQUAD4,7,1,1,2,3,4\nCBAR,8,1,1,2\nCBAR,9,1,2,3\nRBE2,10,1,123,2,3\n",
        grids(&CUBE)
    );
    let mesh = read("a.bdf", &text);
    let group = |name: &str| -> Vec<u64> {
        mesh.node_groups[name].iter().map(|&node| mesh.node_ids[node as usize]).collect()
    };
    assert_eq!(group("SPC 1"), [1, 2, 3, 4]);
    // Rotations hold nothing of a solid.
    assert_eq!(group("SPC 3"), [8]);
    assert_eq!(group("SPC 9"), [1, 2, 3, 4, 8]);
    assert_eq!(group("SPC 5"), [2, 5, 6, 7, 8]);
    has_note(&mesh, "2 CBAR, 1 CQUAD4, 1 RBE2 are no part of the mesh");
    assert_eq!(mesh.regions[0].name, "PSOLID 1");
    assert!((mesh.volume() - 1.0).abs() < 1e-14, "{}", mesh.volume());
    let fields = ["3".to_string(), "THRU".into(), "5".into()];
    assert_eq!(ranges(&fields), Some(vec![[3, 5]]));
}

#[test]
fn malformed_cards_are_named_with_line_and_remedy() {
    let head = grids(&CUBE);
    for (card, parts) in [
        ("CHEXA,1,1,1,2,3,4,5,6,+\n+,7,9", ["line 9, in CHEXA", "GRID 9"]),
        ("CHEXA,1,1,1,2,3,4,5,6", ["line 9, in CHEXA", "no corner 7"]),
        ("CTETRA,1,1,1,2,3,x", ["`x` in its field 7", "a whole number"]),
        ("CPENTA,1,1,1,2,3,4,5,6,+\n+,,,,,,,,,+\n+,7,8", ["16 nodes", "6 corners, up to 9 middles"]),
        ("GRID,9,,1.,y", ["`y` in its field 5", "a number"]),
        ("GRID,8,,1.", ["node 8 a second time", "every node number once"]),
        ("GRID,9,7,1.", ["coordinate system 7", "CORD2R"]),
        ("SPC1,1,1,2,THRU", ["in SPC1", "THRU"]),
        ("CTETRA,1,1,1,2,3,5\nCTETRA,1,1,1,2,3,6", ["line 10", "element 1 a second time"]),
    ] {
        let said = said("a.bdf", &format!("{head}{card}\n"));
        assert!(parts.iter().all(|part| said.contains(part)), "{card}: {said}");
    }
    assert!(said("a.bdf", "CEND\nBEGIN BULK\n").contains("no GRID card"));
    // A point may stand twice as it is.
    assert_eq!(parse("a.bdf", &format!("{head}{head}")).unwrap().nodes.len(), 8);
}

#[test]
fn bricks_with_repeated_corners_are_wedges_pyramids_and_tetrahedra() {
    let six = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [1., 0., 1.], [0., 1., 1.]];
    let five = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [0., 0., 1.]];
    type Case<'a> = (&'a [[f64; 3]], [usize; 8], ElementKind, f64);
    let cases: [Case<'_>; 4] = [
        (&six, [1, 2, 3, 3, 4, 5, 6, 6], ElementKind::Wedge6, 0.5),
        (&five, [1, 2, 3, 4, 5, 5, 5, 5], ElementKind::Pyramid5, 1.0 / 3.0),
        (&six[..4], [1, 2, 3, 3, 4, 4, 4, 4], ElementKind::Tet4, 1.0 / 6.0),
        (&six[..4], [1, 2, 3, 3, 1, 2, 4, 4], ElementKind::Tet4, 1.0 / 6.0),
    ];
    for (points, nodes, kind, volume) in cases {
        let list = |separator: &str| nodes.map(|node| node.to_string()).join(separator);
        let nodes_of_deck: String =
            points.iter().zip(1..).map(|(p, i)| format!("{i},{},{},{}\n", p[0], p[1], p[2])).collect();
        let (six, two) = (nodes[..6].to_vec(), &nodes[6..]);
        let six = six.iter().map(|node| node.to_string()).collect::<Vec<_>>().join(",");
        for (name, text) in [
            ("a.inp", format!("*NODE\n{nodes_of_deck}*ELEMENT, TYPE=C3D8, ELSET=E\n1,{}\n", list(","))),
            ("a.bdf", format!("{}CHEXA,1,1,{six},+\n+,{},{}\n", grids(points), two[0], two[1])),
            ("a.cdb", cdb(points, "ET,1,SOLID185\n", &[(1, 1, &nodes)])),
        ] {
            let mesh = read(name, &text);
            assert_eq!(mesh.kinds.uniform(), Some(kind), "{name} {nodes:?}");
            assert!((mesh.volume() - volume).abs() < 1e-14, "{name} {nodes:?}: {}", mesh.volume());
            has_note(&mesh, "1 elements with repeated corners are read as");
        }
    }
    // Seven corners are none of them.
    let deck = |corners: &str| {
        let nodes: String =
            CUBE.iter().zip(1..).map(|(p, i)| format!("{i},{},{},{}\n", p[0], p[1], p[2])).collect();
        format!("*NODE\n{nodes}*ELEMENT, TYPE=C3D8, ELSET=E\n1,{corners}\n")
    };
    let problems = |name: &str, text: &str| inspect(&parse(name, text).unwrap()).problems.join("; ");
    let seven = "hexahedron with repeated corners that is no wedge, pyramid or tetrahedron";
    assert!(problems("a.inp", &deck("1,2,3,4,5,6,7,7")).contains(seven));
    let text = cdb(&CUBE, "ET,1,185\n", &[(1, 1, &[1, 2, 3, 4, 5, 6, 7, 7])]);
    assert!(problems("a.cdb", &text).contains(seven));
    // Faces of a deck keep the names that they have on its brick.
    let wedge = deck("1,2,3,3,5,6,7,7");
    let surfaces: String = (1..=6).map(|face| format!("*SURFACE, NAME=F{face}\nE, S{face}\n")).collect();
    let mesh = read("a.inp", &format!("{wedge}{surfaces}"));
    let at = |face: &str| -> Vec<u64> {
        mesh.node_groups[face].iter().map(|&node| mesh.node_ids[node as usize]).collect()
    };
    assert_eq!(at("F1"), [1, 2, 3]);
    assert_eq!(at("F2"), [5, 6, 7]);
    assert_eq!(at("F3"), [1, 2, 5, 6]);
    assert_eq!(at("F4"), [2, 3, 6, 7]);
    assert_eq!(at("F6"), [1, 3, 5, 7]);
    assert!(!mesh.facet_groups.contains_key("F5"));
    assert!(["F1", "F2", "F3", "F4", "F6"].iter().all(|face| mesh.facet_groups[*face].len() == 1));
    assert!(!mesh.notes.iter().any(|note| note.contains("no face of any element")), "{:?}", mesh.notes);
}

#[test]
fn quadratic_bricks_become_tetrahedra_with_the_middles_of_their_edges() {
    let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
    let middles = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];
    // Off the middle, each by another amount.
    let bent = |i: usize, [a, b]: [usize; 2]| -> [f64; 3] {
        std::array::from_fn(|k| 0.5 * (corners[a][k] + corners[b][k]) + 0.01 * (i + k + 1) as f64)
    };
    let points: Vec<[f64; 3]> =
        corners.into_iter().chain(middles.into_iter().enumerate().map(|(i, ends)| bent(i, ends))).collect();
    let nodes = [1, 2, 3, 3, 4, 4, 4, 4, 5, 6, 3, 7, 4, 4, 4, 4, 8, 9, 10, 10];
    let text = cdb(&points, "ET,1,186\n", &[(1, 1, &nodes)]);
    let plain = cdb(&points, "ET,1,187\n", &[(1, 1, &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10])]);
    for text in [text.clone(), plain] {
        let mesh = read("a.cdb", &text);
        assert_eq!(mesh.kinds.uniform(), Some(ElementKind::Tet10));
        for (i, ends) in middles.into_iter().enumerate() {
            let found = mesh.nodes[mesh.element(0)[4 + i] as usize];
            let expected = bent(i, ends);
            assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-12), "{i}: {found:?}");
        }
    }
    // One of its middles left out.
    let some = read("a.cdb", &cdb(&points, "ET,1,187\n", &[(1, 1, &[1, 2, 3, 4, 0, 6, 7, 8, 9, 10])]));
    has_note(&some, "1 nodes that the file leaves out");
    let first = some.element(0)[4] as usize;
    assert_eq!((some.nodes[first], some.node_ids[first]), ([0.5, 0., 0.], 11));
    assert_eq!(read("a.cdb", &text.replace("ET,1,186", "ET,1,95")).order(), Order::Quadratic);
}

#[test]
fn formulations_of_ansys_come_from_its_options() {
    let eight: &[usize] = &[1, 2, 3, 4, 5, 6, 7, 8];
    for (types, formulation) in [
        ("ET,1,185\n", Hexahedra::MeanDilatation),
        ("ET,1,185\nKEYOPT,1,2,1\n", Hexahedra::Reduced),
        ("ET,1,185,,2\n", Hexahedra::Incompatible),
        ("ET,1,SOLID185\nKEYOP,1,2,3\n", Hexahedra::Incompatible),
        ("ET,1,45\n", Hexahedra::Incompatible),
        ("ET,1,45\nkeyopt,1,1,1\n", Hexahedra::Full),
        ("ET,1,186\n", Hexahedra::Full),
        ("ETBLOCK,1,1\n(2i9,19a9)\n        1      185        0        1\n       -1\n", Hexahedra::Reduced),
    ] {
        let mesh = read("a.cdb", &cdb(&CUBE, types, &[(1, 3, eight)]));
        assert_eq!(mesh.regions[0].hexahedra, Some(formulation), "{types}");
        assert_eq!((mesh.regions[0].tag, mesh.regions[0].name.as_str()), (3, "material 3"));
    }
}

#[test]
fn components_types_and_commands_of_ansys() {
    let types = "ET,1,185\nET,2,154\nET,3,21\nET,4,226\nMP,EX,1,2.1e11 ! steel\n/COM, a, b ! c\nFOO,,2,,\n";
    let elements: [(usize, usize, &[usize]); 3] =
        [(1, 1, &[1, 2, 3, 4, 5, 6, 7, 8]), (2, 1, &[1, 2, 3, 4]), (3, 1, &[5])];
    let rest = "CMBLOCK,SIDE,NODE,3  ! a set\n(8i10)\n         1        -4         8\n\
                CMBLOCK,'WHOLE',ELEM,2\n(8i10)\n         1       -99\nEBLOCK,10,,,2\n(15i8)\n\
                       8       1       1       1       0       1       2\n       9\n      -1\nFINISH\n";
    let text = format!("{}{rest}", cdb(&CUBE, types, &elements));
    let mesh = read("a.cdb", &text);
    let group = |name: &str| -> Vec<u64> {
        mesh.node_groups[name].iter().map(|&node| mesh.node_ids[node as usize]).collect()
    };
    assert_eq!(group("SIDE"), [1, 2, 3, 4, 8]);
    assert_eq!(group("WHOLE").len(), 8);
    has_note(&mesh, "1 MASS21, 1 SURF154, 2 elements of type 0 are no part of the mesh");
    let path = PathBuf::from("a.cdb");
    let found = commands(&path, text.as_bytes()).unwrap();
    let shown: Vec<(&str, Vec<&str>)> = found
        .iter()
        .map(|command| (command.name.as_str(), command.fields.iter().map(String::as_str).collect()))
        .collect();
    assert!(shown.contains(&("MP", vec!["EX", "1", "2.1e11"])), "{shown:?}");
    assert!(shown.contains(&("FOO", vec!["", "2"])), "{shown:?}");
    assert_eq!((shown[0].0, found[5].line), ("/PREP7", 6));
    assert_eq!(shown.last().map(|command| command.0), Some("FINISH"));
    assert!(rotations(&path, text.as_bytes()).unwrap().is_empty());
    let turned = text.replacen("0.0000000000000e0\n", "0.0000000000000e0       3.0000000E+01\n", 1);
    assert_eq!(rotations(&path, turned.as_bytes()).unwrap().into_iter().next(), Some((1, [30.0, 0.0, 0.0])));
    // A solid that is not read must not be missing.
    let other = cdb(&CUBE, types, &[elements[0], (4, 1, elements[0].2)]);
    assert!(inspect(&parse("a.cdb", &other).unwrap()).problems.join("; ").contains("SOLID226"));
}

#[test]
fn malformed_blocks_are_named_with_their_lines() {
    let whole = cdb(&CUBE, "ET,1,185\n", &[(1, 1, &[1, 2, 3, 4, 5, 6, 7, 8])]);
    for (from, to, parts) in [
        ("(3i8,6e20.13)", "(3x8)", ["line 4, in NBLOCK", "a format"]),
        ("       2       0       0", "       2       0      ab", ["", "EBLOCK"]),
        ("       1       0       0 ", "      1x       0       0 ", ["line 5, in NBLOCK", "whole numbers"]),
        ("ET,1,185", "ET,7,185", ["element type 1", "ET defines"]),
        ("       7       8\n", "       7       9\n", ["in EBLOCK", "node 9"]),
        ("       7       8\n", "       7       0\n", ["7 nodes of element 1", "8 to 8 nodes of SOLID185"]),
        ("      -1\n", "", ["the end of the file", "-1 at the end of the block"]),
        ("EBLOCK,19,SOLID,1,1\n(19i8)", "(19i8)", ["no EBLOCK", "CDWRITE"]),
        ("NBLOCK,6,SOLID,8,8", "NBLOC", ["no NBLOCK", "CDWRITE"]),
    ] {
        assert!(whole.contains(from), "{from} is not in\n{whole}");
        // Columns that are not read may hold anything.
        let text = whole.replacen(from, to, 1);
        if parts[0].is_empty() {
            assert!(parse("a.cdb", &text).is_ok());
            continue;
        }
        let said = said("a.cdb", &text);
        assert!(parts.iter().all(|part| said.contains(part)), "{from}: {said}");
    }
    let set = |rest: &str| said("a.cdb", &format!("{whole}CMBLOCK,A,NODE,{rest}"));
    assert!(set("3\n(8i10)\n         1        -4\n").contains("3 numbers of A"));
    assert!(set("1\n(8i10)\n        -4\n").contains("a range after its first number"));
}

#[test]
fn a_truncated_file_never_panics() {
    let twenty: Vec<usize> = (1..=20).map(|i| 1 + (i - 1) % 8).collect();
    let rest =
        "CMBLOCK,SIDE,NODE,3\n(8i10)\n         1        -4         8\nMPDATA,R5.0, 1,EX, 1, 1, 7.0E+10,\n";
    let ansys = format!(
        "{}{rest}",
        cdb(
            &CUBE,
            "ET,1,186\nETBLOCK,1,1\n(2i9,19a9)\n        2      185\n       -1\n",
            &[(1, 1, &twenty), (2, 1, &[1, 2, 3, 4, 5, 6, 7, 8]),]
        )
    );
    let nastran = format!(
        "SOL 101\nCEND\nSPC = 1\nBEGIN BULK\nCORD2C  5       0       2.      0.      0.      3.      0.\n        2.\
         \x20     1.      0.\n{}GRID*   9               5               1.0D0           90.\n*       1.5-3\n\
         CHEXA,1,1,1,2,3,4,5,6,+A\n+A,7,8,9,,9\nCHEXA   2       1       1       2       3       3       5       6\n\
         +       7       7\nSPC1,1,123,1,THRU,4,EXCEPT,3\nSPCADD,2,1\nRBE2,10,1,123,2,3\nENDDATA\n",
        grids(&CUBE)
    );
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("a.bdf", &nastran), ("a.cdb", &ansys)] {
        let path = folder.path().join(name);
        for end in 0..=text.len() {
            std::fs::write(&path, &text.as_bytes()[..end]).unwrap();
            if let Ok(raw) = mesh::parse(&path) {
                assert!(inspect(&raw).nodes <= text.len(), "{name} {end}");
            }
            std::fs::write(&path, &text.as_bytes()[end..]).unwrap();
            if let Ok(raw) = mesh::parse(&path) {
                assert!(inspect(&raw).nodes <= text.len(), "{name} {end}");
            }
        }
    }
}

/// A deck that a program wrote; skipped where the folder is absent, except in CI.
fn deck(name: &str) -> Option<PathBuf> {
    Some(common::real_meshes()?.join("../decks").join(name))
}

#[test]
fn nastran_decks_of_people_are_read() {
    let Some(path) = deck("nastran/solid_bending.bdf") else { return };
    let mesh = mesh::read(&path).unwrap();
    assert_eq!((mesh.nodes.len(), mesh.element_count()), (72, 186));
    assert_eq!(mesh.kinds.uniform(), Some(ElementKind::Tet4));
    assert_eq!((mesh.regions.len(), mesh.regions[0].name.as_str()), (1, "PSOLID 1"));
    assert_eq!(mesh.node_groups["SPC 1"], mesh.node_groups["SPC 2"]);
    let held: Vec<u64> = mesh.node_groups["SPC 1"].iter().map(|&node| mesh.node_ids[node as usize]).collect();
    assert_eq!(held, [31, 35, 39, 43, 47, 48, 53, 63, 64, 69, 70, 71, 72]);
    let Some(path) = deck("nastran/rigid_rbe2.bdf") else { return };
    let raw = mesh::parse(&path).unwrap();
    assert_eq!(raw.nodes.len(), 252);
    assert!(raw.notes.iter().any(|note| note == "1 CBAR, 2 RBE2 are no part of the mesh"), "{:?}", raw.notes);
    assert_eq!(raw.node_groups["SPC 2"].len(), 5);
    let held: BTreeSet<u32> = raw.node_groups["SPC 6"].iter().copied().collect();
    assert_eq!(held.len(), 41);
    let report = inspect(&raw);
    assert_eq!((report.elements, report.nodes), (128, 250));
    // Rigid links join two blocks.
    assert!(report.problems[0].contains("2 bodies"), "{:?}", report.problems);
}

#[test]
fn ansys_files_of_people_are_read() {
    let Some(path) = deck("ansys/HexBeam.cdb") else { return };
    let mesh = mesh::read(&path).unwrap();
    assert_eq!((mesh.nodes.len(), mesh.element_count()), (321, 40));
    assert_eq!(mesh.kinds.uniform(), Some(ElementKind::Hex20));
    assert!((mesh.volume() - 5.0).abs() < 1e-12, "{}", mesh.volume());
    assert_eq!(mesh.regions[0].name, "material 1");
    assert_eq!(mesh.regions[0].hexahedra, Some(Hexahedra::Reduced));
    let sizes = ["NCOMP2", "NODE_SELECTION"].map(|name| mesh.node_groups[name].len());
    assert_eq!(sizes, [98, 164]);
    assert!(mesh.node_groups.contains_key("ECOMP1") && mesh.node_groups.contains_key("ECOMP2"));
    let found = commands(&path, &std::fs::read(&path).unwrap()).unwrap();
    let density = found.iter().find(|c| c.name == "MPDATA" && c.field(2) == "DENS").unwrap();
    assert_eq!((density.field(5), density.line), ("2700.00000", 469));
    let Some(path) = deck("ansys/TetBeam.cdb") else { return };
    let mesh = mesh::read(&path).unwrap();
    assert_eq!((mesh.kinds.uniform(), mesh.element_count()), (Some(ElementKind::Tet4), 3913));
    assert!((mesh.volume() - 10.0).abs() < 1e-9, "{}", mesh.volume());
}

#[test]
fn a_keyword_file_of_people_is_named() {
    let Some(path) = deck("lsdyna/frf_solid.k") else { return };
    let said = mesh::parse(&path).unwrap_err().to_string();
    assert!(said.contains("an LS-DYNA keyword file") && said.contains("Nastran .bdf"), "{said}");
}
