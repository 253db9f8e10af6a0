//! Damaged mesh files are refused or read, but never panic, hang or eat memory.

mod common;

use std::path::Path;

use proptest::prelude::*;
use vademecum_build::field;
use vademecum_build::mesh::{self, Order, block};

/// A small file of each text format: one tetrahedron or two, groups, regions.
const FILES: [(&str, &str); 13] = [
    ("a.msh", "$NOD\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$ENDNOD\n$ELM\n1\n1 4 1 1 4 1 2 3 4\n$ENDELM\n"),
    (
        "b.msh",
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 7 \
         \"side\"\n$EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n\
         2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n$Elements\n2\n1 2 2 7 1 1 2 3\n2 4 2 1 1 1 2 3 \
         4\n$EndElements\n",
    ),
    (
        "c.msh",
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 7 \
         \"side\"\n$EndPhysicalNames\n$Entities\n0 0 1 1\n\
         1 0 0 0 1 1 0 1 7 0\n1 0 0 0 1 1 1 0 1 1\n$EndEntities\n$Nodes\n2 4 1 9\n2 1 1 3\n1\n2\n3\n0 0 0 0 \
         0\n1 0 0 1 0\n\
         0 1 0 0 1\n3 1 0 1\n9\n0 0 1\n$EndNodes\n$Elements\n2 2 1 2\n2 1 2 1\n1 1 2 3\n3 1 4 1\n2 1 2 3 \
         9\n$EndElements\n",
    ),
    (
        "d.inp",
        "*NODE, NSET=N\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n*ELEMENT, TYPE=C3D4, ELSET=E\n1, 1, \
         2, 3, 4\n\
         *NSET, NSET=G, GENERATE\n1, 4, 2\n*SURFACE, NAME=S\nE, S2\n",
    ),
    (
        "e.vtk",
        "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n0 0 0 1 0 0 \
         0 1 0 0 0 1\n\
         CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\nCELL_DATA 1\nSCALARS material int\nLOOKUP_TABLE \
         default\n3\n",
    ),
    (
        "f.vtu",
        "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\"><UnstructuredGrid><Piece \
         NumberOfPoints=\"4\" \
         NumberOfCells=\"1\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" \
         format=\"ascii\">0 0 0 1 0 0 0 1 \
         0 0 0 1</DataArray></Points><Cells><DataArray type=\"Int64\" Name=\"connectivity\" \
         format=\"ascii\">0 1 2 3\
         </DataArray><DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">4</DataArray><DataArray \
         type=\"UInt8\" \
         Name=\"types\" format=\"binary\">AQAAAAo=</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>",
    ),
    (
        "g.mesh",
        "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 \
         1\nTriangles\n1\n1 2 3 5\n\
         Corners\n1\n2\nTetrahedra\n1\n1 2 3 4 2\nEnd\n",
    ),
    (
        "h.mesh",
        "MFEM mesh v1.0\n\ndimension\n3\n\nelements\n1\n1 4 0 1 2 3\n\nboundary\n1\n2 2 0 1 \
         2\n\nvertices\n4\n3\n0 0 0\n\
         1 0 0\n0 1 0\n0 0 1\n",
    ),
    (
        "j.bdf",
        "SOL 101\nCEND\nBEGIN BULK\nCORD2R,1,,0.,0.,0.,0.,0.,1.,+\n+,1.,0.,0.\nGRID    1\n\
         GRID*   2               1               1.\n*\nGRID,3,,,1.+0\nGRID,4,1,,,1.0D0\n\
         CTETRA,1,7,1,2,3,4\nPSOLID,7,1\nSPC1,1,123,1,THRU,3\nENDDATA\n",
    ),
    (
        "k.cdb",
        "/PREP7\nET,1,185\nKEYOPT,1,2,3\nNBLOCK,6,SOLID,4,4\n(3i3,6e4.1)\n  1  0  0\n  2  0  0 1.0\n\
         \x20 3  0  0     1.0\n  4  0  0         1.0\nN,R5.3,LOC,-1,\nEBLOCK,19,SOLID,1,1\n(19i2)\n\
         \x201 1 1 1 0 0 0 0 8 0 1 1 2 3 3 4 4 4 4\n-1\nCMBLOCK,G,NODE,2\n(8i10)\n         1        -3\n",
    ),
    (
        "l.unv",
        "    -1\n   164\n 1SI 2\n 1.0D+03 1.0D+00 1.0D+00 1.0D+00\n 0.0D+00\n    -1\n    -1\n  2411\n\
         1 1 1 11\n 0.0D+00 0.0 0.0\n2 1 1 11\n 1.0D+00 0 0\n3 1 1 11\n 0 1 0\n4 1 1 11\n 0 0 1\n    -1\n\
         \x20   -1\n  2412\n1 111 1 2 7 4\n1 2 3 4\n2 91 1 2 7 3\n1 2 3\n3 21 1 2 7 2\n0 1 1\n1 2\n    -1\n\
         \x20   -1\n  2467\n1 0 0 0 0 0 0 2\nside\n8 2 0 0 7 4 0 0\n    -1\n",
    ),
    ("i.node", "4 3 0 1\n1 0 0 0 0\n2 1 0 0 0\n3 0 1 0 0\n4 0 0 1 6\n"),
    ("i.ele", "1 4 1\n1 1 2 3 4 7\n"),
];

fn write_all(folder: &Path) {
    for (name, text) in FILES {
        std::fs::write(folder.join(name), text).unwrap();
    }
}

#[test]
fn the_undamaged_files_are_one_tetrahedron() {
    let folder = tempfile::tempdir().unwrap();
    write_all(folder.path());
    for (name, _) in FILES {
        let mesh = mesh::read(&folder.path().join(name)).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((mesh.nodes.len(), mesh.element_count()), (4, 1), "{name}");
        assert_eq!(mesh.volume(), 1.0 / 6.0, "{name}");
    }
}

/// Changes bytes and cuts the end off.
fn damaged(bytes: &[u8], flips: &[(usize, u8)], keep: usize) -> Vec<u8> {
    let mut out = bytes.to_vec();
    for &(place, value) in flips {
        let place = place % out.len();
        out[place] = value;
    }
    out.truncate(keep % (bytes.len() + 1));
    out
}

/// Bytes that make the most of a text format: digits, signs, separators, line ends.
fn byte() -> impl Strategy<Value = u8> {
    prop_oneof![
        4 => prop::sample::select(b"0123456789-+.eE, \n*$#\"<>=/".to_vec()),
        1 => any::<u8>(),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_text_never_panics(
        flips in prop::collection::vec((any::<usize>(), byte()), 0..6),
        keep in any::<usize>(),
    ) {
        let folder = tempfile::tempdir().unwrap();
        write_all(folder.path());
        for (name, text) in FILES {
            let path = folder.path().join(name);
            for keep in [keep, text.len()] {
                std::fs::write(&path, damaged(text.as_bytes(), &flips, keep)).unwrap();
                if let Ok(raw) = mesh::parse(&path) {
                    prop_assert!(!mesh::inspect(&raw).to_string().is_empty());
                }
            }
            std::fs::write(&path, text).unwrap();
        }
    }

    #[test]
    fn damaged_binary_vtu_never_panics(
        flips in prop::collection::vec((any::<usize>(), any::<u8>()), 0..6),
        keep in any::<usize>(),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("u.vtu");
        let mesh = block([1.0; 3], [1; 3], Order::Linear);
        let u = vec![0.5; 3 * mesh.nodes.len()];
        let cells = field::Cells::Elements(&mesh.kinds, &mesh.elements);
        field::write_vtu(&path, &mesh.nodes, cells, &[("u", &u, 3)]).unwrap();
        let whole = std::fs::read(&path).unwrap();
        for keep in [keep, whole.len()] {
            std::fs::write(&path, damaged(&whole, &flips, keep)).unwrap();
            // Either answer will do; arriving at one is the test, and what is read must be whole.
            if let Ok(read) = field::read_vtu(&path) {
                prop_assert!(read.data.iter().all(|a| a.values.len() == a.components * read.points.len()));
            }
            if let Ok(raw) = mesh::parse(&path) {
                prop_assert!(mesh::inspect(&raw).nodes <= mesh.nodes.len());
            }
        }
    }
}

/// Damages a binary file at many places.
fn damage(file: &Path) {
    let folder = tempfile::tempdir().unwrap();
    let bytes = std::fs::read(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let path = folder.path().join(file.file_name().unwrap());
    for step in 0..200 {
        // A fixed walk over the file, with the values that break counts.
        let place = step * 7919 + 13;
        let flips = [(place, [0xff, 0x00, 0x7f, 0x80][step % 4])];
        let keep = if step % 5 == 0 { place } else { bytes.len() };
        std::fs::write(&path, damaged(&bytes, &flips, keep)).unwrap();
        if let Ok(raw) = mesh::parse(&path) {
            assert!(mesh::inspect(&raw).nodes <= bytes.len());
        }
    }
}

#[test]
fn damaged_binary_files_never_panic() {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/meshes/bar");
    for name in [
        "gmsh22-binary.msh",
        "gmsh41-binary.msh",
        "quadratic-gmsh41-binary.msh",
        "vtk42-binary.vtk",
        "vtk51-binary.vtk",
        "vtu-binary.vtu",
    ] {
        damage(&own.join(name));
    }
}

#[test]
fn damaged_real_binary_files_never_panic() {
    let Some(real) = common::real_meshes() else { return };
    for name in [
        "gmsh22_binary/22_binary.msh",
        "gmsh41_binary/41_binary.msh",
        "gmsh41_binary/cube_41_binary_vol_gmshApp.msh",
        "vtk/cube.vtk",
        "vtu/Tetrahedron.vtu",
    ] {
        damage(&real.join(name));
    }
}
