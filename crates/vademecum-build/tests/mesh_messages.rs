//! What a reader says about a file that is sound and yet cannot be used names what it is and what to do.

use std::path::{Path, PathBuf};

use vademecum_build::mesh::{self, MeshError, RawMesh, inspect};

fn parse(name: &str, content: &[u8]) -> Result<RawMesh, MeshError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    mesh::parse(&path)
}

/// A tetrahedron as MFEM writes it: curved meshes give no coordinates in `vertices`.
fn mfem(end: &str) -> String {
    format!("MFEM mesh v1.0\n\ndimension\n3\n\nelements\n1\n1 4 0 1 2 3\n\nboundary\n0\n\nvertices\n4\n{end}")
}

#[test]
fn a_curved_mfem_mesh_is_not_supported_by_name() {
    let space =
        "nodes\nFiniteElementSpace\nFiniteElementCollection: H1_3D_P2\nVDim: 3\nOrdering: 1\n\n0 0 0\n";
    let straight = "3\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n\n";
    for end in [space.to_string(), format!("\n{space}"), format!("{straight}{space}")] {
        let error = parse("curved.mesh", mfem(&end).as_bytes()).unwrap_err();
        let said = error.to_string();
        assert!(matches!(error, MeshError::Unsupported(_)), "{said}");
        for part in ["not supported", "curved elements (`nodes`)", "straight elements", "in nodes"] {
            assert!(said.contains(part), "`{part}` is not in: {said}");
        }
        assert!(!said.contains("correct the file"), "{said}");
    }
    assert_eq!(parse("straight.mesh", mfem(straight).as_bytes()).unwrap().nodes.len(), 4);
    let cut = parse("cut.mesh", mfem("").as_bytes()).unwrap_err();
    assert!(matches!(cut, MeshError::Malformed(_)), "{cut}");
}

const TETRAHEDRON: &str = "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n\
                           *ELEMENT, TYPE=C3D4, ELSET=E\n1, 1, 2, 3, 4\n";

#[test]
fn a_surface_without_faces_is_left_out_with_a_note() {
    // No line at all, an empty set, a set of a shell whose face a tetrahedron does not have.
    let surfaces = [
        "*SURFACE, NAME=S, TYPE=ELEMENT\n",
        "*ELSET, ELSET=EMPTY\n*SURFACE, NAME=S\nEMPTY, S1\n",
        "*ELEMENT, TYPE=S3, ELSET=SHELL\n2, 1, 2, 3\n*SURFACE, NAME=S\nSHELL, S1\n",
    ];
    for surface in surfaces {
        let raw = parse("deck.inp", format!("{TETRAHEDRON}{surface}*STEP\n*STATIC\n").as_bytes()).unwrap();
        let note = "surface `S` names no face of an element and is left out";
        assert!(raw.notes.iter().any(|n| n == note), "{surface}: {:?}", raw.notes);
        assert!(!raw.facet_groups.contains_key("S") && !raw.node_groups.contains_key("S"));
        assert_eq!(inspect(&raw).problems.len(), 0, "{surface}");
    }
    let whole = format!("{TETRAHEDRON}*SURFACE, NAME=EMPTY\n*SURFACE, NAME=S\nE, S2\n");
    assert_eq!(parse("deck.inp", whole.as_bytes()).unwrap().facet_groups["S"].len(), 1);
}

#[test]
fn a_face_that_no_tetrahedron_has_and_a_line_without_values_are_refused_by_line() {
    for (line, found) in [("E, S6", "face `S6` of a 4-node tetrahedron"), (",", "a line without values")] {
        let error = parse("deck.inp", format!("{TETRAHEDRON}*SURFACE, NAME=S\n{line}\n").as_bytes());
        let said = error.unwrap_err().to_string();
        assert!(said.contains("line 9, in *SURFACE") && said.contains(found), "{said}");
    }
}

#[test]
fn folded_hexahedra_of_a_deck_are_refused_with_their_corners_and_not_by_their_faces() {
    for (kind, nodes, faces) in [("C3D20", 20, 6), ("C3D20R", 20, 6), ("C3D8", 8, 6), ("C3D15", 15, 5)] {
        let mut deck = String::from("*NODE\n");
        (1..=nodes).for_each(|i| deck += &format!("{i}, {}, {}, {}\n", i, i * i % 7, i * i % 5));
        let numbers: Vec<String> = (1..=nodes).map(|i| i.to_string()).collect();
        let (first, rest) = numbers.split_at(nodes.min(10));
        let rest = if rest.is_empty() { String::new() } else { format!("{}\n", rest.join(", ")) };
        deck += &format!("*ELEMENT, TYPE={kind}, ELSET=E\n1, {},\n{rest}", first.join(", "));
        (1..=faces).for_each(|f| deck += &format!("*SURFACE, NAME=F{f}, TYPE=ELEMENT\nE, S{f}\n"));
        let said = inspect(&parse("deck.inp", deck.as_bytes()).unwrap()).problems.join("; ");
        assert!(said.contains("folded by their shape") && !said.contains("no face"), "{kind}: {said}");
    }
}

#[test]
fn shapes_are_told_to_be_meshed_first() {
    let cases: [(&str, &[u8], &str); 4] = [
        ("a.step", b"ISO-10303-21;\nHEADER;\n", "a STEP file"),
        ("a.STP", b"ISO-10303-21;\nHEADER;\n", "a STEP file"),
        ("a.igs", b"      S      1\n", "an IGES file"),
        ("a.geo", b"SetFactory(\"OpenCASCADE\");\n", "a geometry script of Gmsh"),
    ];
    // Gmsh folds the curved elements of CAD geometry without its last option.
    for (name, content, found) in cases {
        let error = parse(name, content).unwrap_err();
        let said = error.to_string();
        assert!(matches!(error, MeshError::Geometry { .. }), "{said}");
        for part in [name, found, "mesh its volume first", "gmsh -3 -order 2 -optimize_ho"] {
            assert!(said.contains(part), "`{part}` is not in: {said}");
        }
    }
    let error = parse("a.txt", b"hello\n").unwrap_err();
    assert!(matches!(error, MeshError::UnknownFormat { .. }), "{error}");
}

#[test]
fn formats_that_are_not_read_are_named_with_what_to_do() {
    let cases: [(&str, &[u8], &str, &str); 12] = [
        ("a.3mf", b"PK\x03\x04", "a 3MF file", "STL"),
        ("a.k", b"*KEYWORD\n*NODE\n", "an LS-DYNA keyword file", "Nastran .bdf"),
        ("a.inp", b"$# made by hand\n*KEYWORD\n*NODE\n", "an LS-DYNA keyword file", "Nastran .bdf"),
        ("a.key", b"$\n*NODE\n", "an LS-DYNA keyword file", "Abaqus .inp"),
        ("a.med", b"\x89HDF\r\n\x1a\n\0\0", "a MED file", "meshio"),
        ("a.e", b"\x89HDF\r\n\x1a\n\0\0", "an Exodus file", "meshio"),
        ("a.g", b"CDF\x01\0", "an Exodus file", "meshio"),
        ("a.exo", b"", "an Exodus file", "meshio"),
        ("a.h5", b"\x89HDF\r\n\x1a\n\0\0", "an HDF5 file", "meshio"),
        ("a.cgns", b"\x89HDF\r\n\x1a\n\0\0", "a CGNS file", "meshio"),
        ("a.xdmf", b"<?xml version=\"1.0\" ?>\n<Xdmf Version=\"3.0\">", "an XDMF file", "VTU"),
        ("a.xml", b"<Xdmf Version=\"2.0\">", "an XDMF file", "VTU"),
    ];
    for (name, content, found, remedy) in cases {
        let error = parse(name, content).unwrap_err();
        let said = error.to_string();
        assert!(matches!(error, MeshError::Foreign { .. }), "{name}: {said}");
        for part in [name, found, "which is not read", remedy] {
            assert!(said.contains(part), "`{part}` is not in: {said}");
        }
    }
}

#[test]
fn decks_are_known_by_their_lines_whatever_their_names() {
    let nastran = "$NODES of a block\nGRID,1\nGRID,2,,1.\nGRID,3,,,1.\nGRID,4,,,,1.\nCTETRA,1,1,1,2,3,4\n";
    let ansys = "! made by hand\n/prep7\net,1,285\nnblock,3,,4\n(1i9,3e8.1)\n        1\n        2     1.0\n\
                 \x20       3             1.0\n        4                     1.0\n-1\neblock,19,solid,,1\n(19i4)\n\
                 \x20  1   1   1   1   0   0   0   0   4   0   1   1   2   3   4\n-1\n";
    for (names, text, format) in [
        (["a.bdf", "a.NAS", "a.dat", "deck"], nastran, "Nastran bulk data"),
        (["a.cdb", "a.dat", "a.inp", "deck"], ansys, "Ansys .cdb"),
    ] {
        for name in names {
            let raw = parse(name, text.as_bytes()).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!((raw.format.as_str(), raw.nodes.len()), (format, 4), "{name}");
            assert_eq!(inspect(&raw).elements, 1, "{name}");
        }
    }
    for text in ["grid = 3\n", "GRIDS 1 2\n", "a list of a NBLOCK, 3\n"] {
        let error = parse("a.dat", text.as_bytes()).unwrap_err();
        assert!(matches!(error, MeshError::UnknownFormat { .. }), "{text}: {error}");
    }
}

/// The valid curved mesh that a user brought, where the folder of real meshes lies beside the repository.
#[test]
fn the_curved_mesh_of_mfem_is_not_supported_by_name() {
    let path: PathBuf =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/meshes/mfem/escher-p2.mesh");
    if !path.exists() {
        eprintln!("skipped: {} is not there", path.display());
        return;
    }
    let said = mesh::parse(&path).unwrap_err().to_string();
    assert!(said.starts_with("not supported") && said.contains("curved elements"), "{said}");
}

#[test]
fn a_selection_that_chooses_nothing_is_shown_in_the_words_of_the_problem_file() {
    #[derive(serde::Deserialize)]
    struct Holder {
        on: mesh::select::Selection,
    }
    let body = mesh::block([1.0; 3], [1, 1, 1], mesh::Order::Linear);
    let cases = [
        ("{ plane = { at = 7.0, axis = \"x\" } }", "plane"),
        ("{ sphere = { center = [9.0, 9.0, 9.0], radius = 0.5 } }", "sphere"),
        ("{ all = [{ group = \"x_min\" }, { group = \"x_max\" }] }", "all"),
    ];
    for (text, kind) in cases {
        let holder: Holder = toml::from_str(&format!("on = {text}")).unwrap();
        let said = holder.on.nodes(&body).unwrap_err().to_string();
        assert!(said.contains(&format!("no node lies in {text}")), "{kind}: {said}");
    }
}
