//! Every public mesh of `../shared/meshes` gives what its list says, or the error it deserves.
//!
//! Skipped with a message where the folder is absent, and a failure in CI. `own_meshes.rs` reads a small body
//! in every format without it.

mod common;

use common::real_meshes as folder;
use vademecum_build::mesh::surface::Surface;
use vademecum_build::mesh::{self, ElementKind, Flaw, Location, Mesh, MeshError, Order};

/// File, nodes in use, elements, order, regions, least quality as listed (two digits).
const SOUND: &[(&str, usize, usize, Order, usize, f64)] = &[
    ("gmsh1/liver.msh", 181, 596, Order::Linear, 1, 0.0),
    ("gmsh22_ascii/beams.msh", 289, 851, Order::Linear, 1, 0.058),
    ("gmsh22_ascii/box.msh", 358, 1105, Order::Linear, 1, 0.13),
    ("gmsh22_ascii/nested_cubes.msh", 138, 520, Order::Linear, 2, 0.17),
    ("gmsh22_ascii/cubes_v22.msh", 7714, 32981, Order::Linear, 3, 0.08),
    ("gmsh22_ascii/22_ascii.msh", 8, 5, Order::Linear, 3, 0.42),
    ("gmsh22_ascii/cube_22_ascii_vol_gmshApp.msh", 14, 24, Order::Linear, 1, 0.35),
    ("gmsh22_ascii/cube.msh", 152, 373, Order::Linear, 1, 0.051),
    ("gmsh22_binary/22_binary.msh", 8, 5, Order::Linear, 3, 0.42),
    ("gmsh22_binary/cube_22_binary_vol_gmshApp.msh", 14, 24, Order::Linear, 1, 0.35),
    ("gmsh22_binary/cube.msh", 2169, 9799, Order::Linear, 1, 0.12),
    ("gmsh22_binary/table.msh", 4641, 17004, Order::Linear, 1, 0.064),
    ("gmsh41_ascii/cubes_v41.msh", 7714, 32981, Order::Linear, 3, 0.08),
    ("gmsh41_ascii/41_ascii.msh", 8, 5, Order::Linear, 3, 0.42),
    ("gmsh41_ascii/gmsh_physical_sides_3d_v41.msh", 5, 2, Order::Linear, 2, 0.5),
    ("gmsh41_ascii/bar-6.msh", 8, 6, Order::Linear, 1, 0.0069),
    ("gmsh41_ascii/bar-186.msh", 86, 186, Order::Linear, 1, 0.007),
    ("gmsh41_ascii/bar-2523.msh", 886, 2523, Order::Linear, 1, 0.007),
    ("gmsh41_ascii/bar-14114.msh", 3842, 14114, Order::Linear, 1, 0.007),
    ("gmsh41_ascii/screw.msh", 1732, 6059, Order::Linear, 1, 1.3e-5),
    ("gmsh41_ascii/P1.msh", 1585, 6414, Order::Linear, 1, 0.0),
    ("gmsh41_ascii/demo.msh", 10257, 40144, Order::Linear, 1, 0.11),
    ("gmsh41_ascii/tet.msh", 14, 24, Order::Linear, 1, 0.35),
    ("gmsh41_ascii/tet_half_twisted.msh", 14, 24, Order::Linear, 1, 0.0),
    ("gmsh41_ascii/block.msh", 46, 13, Order::Quadratic, 1, 0.054),
    ("gmsh41_ascii/quadratic_sphere_tet.msh", 1310, 722, Order::Quadratic, 1, 0.13),
    ("gmsh41_ascii/cube_tet10_24.msh", 63, 24, Order::Quadratic, 1, 0.35),
    ("gmsh41_ascii/sphere_tet4_593.msh", 183, 593, Order::Linear, 1, 0.14),
    ("gmsh41_ascii/cube_41_ascii_vol_gmshApp.msh", 14, 24, Order::Linear, 1, 0.35),
    ("gmsh41_binary/41_binary.msh", 8, 5, Order::Linear, 3, 0.42),
    ("gmsh41_binary/bar.msh", 1088, 3646, Order::Linear, 1, 0.13),
    ("gmsh41_binary/bimetal.msh", 3881, 16275, Order::Linear, 2, 0.13),
    ("gmsh41_binary/sphere_p2.msh", 1256, 683, Order::Quadratic, 1, 0.14),
    ("gmsh41_binary/cube_41_binary_vol_gmshApp.msh", 14, 24, Order::Linear, 1, 0.35),
    ("inp/blockC3D4.inp", 214, 767, Order::Linear, 1, 0.2),
    ("inp/blockC3D10.inp", 257, 122, Order::Quadratic, 1, 0.13),
    ("inp/abaqus_tet.inp", 13, 14, Order::Linear, 2, 0.19),
    ("vtk/beam-tet.vtk", 36, 48, Order::Linear, 2, 0.27),
    ("vtk/multi_material_cylinder_plate.vtk", 2101, 10440, Order::Linear, 4, 0.041),
    ("vtk/a_grid.vtk", 1317, 4802, Order::Linear, 1, 0.081),
    ("vtk/tetraMesh.vtk", 55, 160, Order::Linear, 1, 0.0),
    ("vtk/one_negative_tetrahedron.vtk", 4, 1, Order::Linear, 1, 0.5),
    ("vtk/cube.vtk", 152, 373, Order::Linear, 1, 0.051),
    ("vtu/liverFine.vtu", 4293, 22019, Order::Linear, 1, 0.005),
    ("vtu/raptorTetra_8418.vtu", 2993, 8418, Order::Linear, 1, 0.017),
    ("vtu/Tetrahedron.vtu", 35, 96, Order::Linear, 1, 0.25),
    ("vtu/QuadraticTetra.vtu", 189, 96, Order::Quadratic, 1, 0.25),
    ("vtu/cube.vtu", 152, 373, Order::Linear, 1, 0.051),
    ("tetgen/octahedron.node", 330, 1224, Order::Linear, 1, 0.057),
    ("mfem/beam-tet.mesh", 36, 48, Order::Linear, 2, 0.27),
    ("medit/unit_ball.mesh", 362, 1110, Order::Linear, 1, 0.075),
    ("medit/cube.mesh", 152, 373, Order::Linear, 1, 0.051),
    ("medit/square_beam.mesh", 739, 2886, Order::Linear, 1, 0.11),
];

#[test]
fn sound_files_have_the_counts_of_their_list() {
    let Some(folder) = folder() else { return };
    let mut wrong = Vec::new();
    for &(name, nodes, elements, order, regions, least) in SOUND {
        let raw = match mesh::parse(&folder.join(name)) {
            Ok(raw) => raw,
            Err(e) => {
                wrong.push(format!("{name}: {e}"));
                continue;
            }
        };
        let report = mesh::inspect(&raw);
        let found = (report.nodes, report.elements, report.nodes_per_element, report.regions.len());
        let wanted = (nodes, elements, order.nodes_per_element(), regions);
        if found != wanted || !report.problems.is_empty() {
            wrong.push(format!("{name}: {found:?} instead of {wanted:?}, {:?}", report.problems));
        }
        // The list has two digits: half a unit of the second one is 5 %.
        if least > 0.0 && (report.quality.min - least).abs() > 0.05 * least {
            wrong.push(format!("{name}: least quality {}, not {least}", report.quality.min));
        }
        if report.volume <= 0.0 {
            wrong.push(format!("{name}: volume {}", report.volume));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn read(name: &str) -> Option<Mesh> {
    let path = folder()?.join(name);
    Some(mesh::read(&path).unwrap_or_else(|e| panic!("{e}")))
}

fn same_solid(a: &Mesh, b: &Mesh, tolerance: f64) {
    assert_eq!(a.nodes.len(), b.nodes.len());
    assert_eq!(a.element_count(), b.element_count());
    assert!((a.volume() - b.volume()).abs() <= tolerance * a.volume());
}

#[test]
fn one_mesh_in_several_formats_is_one_mesh() {
    let Some(first) = read("gmsh22_ascii/22_ascii.msh") else {
        return;
    };
    for name in ["gmsh22_binary/22_binary.msh", "gmsh41_ascii/41_ascii.msh", "gmsh41_binary/41_binary.msh"] {
        let other = read(name).unwrap();
        same_solid(&first, &other, 1e-14);
        assert_eq!(first.regions, other.regions, "{name}");
    }
    // Binary and text of one version keep the order too: bit for bit the same mesh.
    for [a, b] in [
        ["gmsh22_ascii/22_ascii.msh", "gmsh22_binary/22_binary.msh"],
        ["gmsh41_ascii/41_ascii.msh", "gmsh41_binary/41_binary.msh"],
        ["gmsh22_ascii/cube_22_ascii_vol_gmshApp.msh", "gmsh41_ascii/cube_41_ascii_vol_gmshApp.msh"],
        ["gmsh22_binary/cube_22_binary_vol_gmshApp.msh", "gmsh41_binary/cube_41_binary_vol_gmshApp.msh"],
        ["gmsh22_ascii/cube_22_ascii_vol_gmshApp.msh", "gmsh22_binary/cube_22_binary_vol_gmshApp.msh"],
        ["vtk/cube.vtk", "vtu/cube.vtu"],
    ] {
        assert_eq!(mesh::hash(&read(a).unwrap()), mesh::hash(&read(b).unwrap()), "{a} and {b}");
    }
    // MFEM starts each element at another corner.
    same_solid(&read("mfem/beam-tet.mesh").unwrap(), &read("vtk/beam-tet.vtk").unwrap(), 1e-14);
    // The cube is written with 15 digits, the VTK files in single precision.
    let cube = read("medit/cube.mesh").unwrap();
    same_solid(&cube, &read("gmsh22_ascii/cube.msh").unwrap(), 1e-12);
    same_solid(&cube, &read("vtk/cube.vtk").unwrap(), f64::from(f32::EPSILON) * 8.0);
    same_solid(
        &read("gmsh22_ascii/cubes_v22.msh").unwrap(),
        &read("gmsh41_ascii/cubes_v41.msh").unwrap(),
        1e-12,
    );
}

#[test]
fn inverted_elements_are_turned_and_unused_nodes_dropped() {
    let Some(reference) = read("gmsh41_ascii/tet.msh") else {
        return;
    };
    let twisted = read("gmsh41_ascii/tet_half_twisted.msh").unwrap();
    same_solid(&reference, &twisted, 1e-14);
    let notes = |name: &str| read(name).unwrap().notes.join("; ");
    for (name, note) in [
        ("gmsh41_ascii/tet_half_twisted.msh", "13 inverted elements were reoriented"),
        ("gmsh41_ascii/P1.msh", "8 inverted elements were reoriented"),
        ("vtk/tetraMesh.vtk", "80 inverted elements were reoriented"),
        ("gmsh41_ascii/P1.msh", "folds over itself at 32 faces"),
        ("gmsh41_ascii/screw.msh", "slivers (quality below 0.001, the worst 1.3e-5)"),
        ("vtk/one_negative_tetrahedron.vtk", "1 inverted elements were reoriented"),
        ("vtu/raptorTetra_8418.vtu", "3 nodes that no element uses were dropped"),
        ("medit/unit_ball.mesh", "1 nodes that no element uses were dropped"),
    ] {
        assert!(notes(name).contains(note), "{name}: {}", notes(name));
    }
    // Turned round, the twisted mesh is as good as its reference: nothing overlaps.
    assert!(!notes("gmsh41_ascii/tet_half_twisted.msh").contains("folds"));
}

#[test]
fn groups_keep_their_names() {
    let Some(beams) = read("gmsh22_ascii/beams.msh") else {
        return;
    };
    assert_eq!(beams.facet_groups["fixed"].len(), 8);
    assert_eq!(beams.regions[0].name, "all");
    let keys = |name: &str| read(name).unwrap().facet_groups.keys().cloned().collect::<Vec<_>>();
    assert_eq!(keys("gmsh41_ascii/gmsh_physical_sides_3d_v41.msh"), ["interface", "side_a", "side_b"]);
    // This file names two surfaces, but saves no triangle of them.
    let bimetal = read("gmsh41_binary/bimetal.msh").unwrap();
    assert!(bimetal.facet_groups.is_empty());
    let named = "group `left_clamp` is named, but the file has no element of it";
    assert!(bimetal.notes.iter().any(|n| n == named), "{:?}", bimetal.notes);
    let regions: Vec<&str> = bimetal.regions.iter().map(|r| r.name.as_str()).collect();
    assert_eq!(regions, ["bottom_material", "top_material"]);
    let tet = read("inp/abaqus_tet.inp").unwrap();
    assert_eq!(tet.regions.iter().map(|r| r.name.as_str()).collect::<Vec<_>>(), ["MAT1", "MAT2"]);
    assert!(tet.node_groups.contains_key("NS1") && tet.node_groups.contains_key("NS2"));
    let block = read("inp/blockC3D10.inp").unwrap();
    assert_eq!(block.node_groups["Set-1"].len(), block.nodes.len());
    assert!(read("gmsh41_ascii/block.msh").unwrap().node_groups.contains_key("PointA"));
}

#[test]
fn every_surface_is_closed() {
    let Some(folder) = folder() else { return };
    for &(name, ..) in SOUND {
        let mesh = mesh::read(&folder.join(name)).unwrap_or_else(|e| panic!("{e}"));
        let surface = Surface::of(&mesh);
        let (mut sum, mut area) = ([0.0; 3], 0.0);
        for triangle in &surface.triangles {
            let [a, b, c] = triangle.map(|n| mesh.nodes[n as usize]);
            let (p, q): ([f64; 3], [f64; 3]) =
                (std::array::from_fn(|k| b[k] - a[k]), std::array::from_fn(|k| c[k] - a[k]));
            let v = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
            area += v.iter().map(|x| x * x).sum::<f64>().sqrt();
            (0..3).for_each(|k| sum[k] += v[k]);
        }
        // A sum of that many vectors, each rounded relative to the coordinates it comes from.
        let size = mesh.nodes.iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
        let terms = surface.triangles.len() as f64;
        let tolerance = f64::EPSILON * terms * (area + size * size);
        assert!(sum.iter().all(|x| x.abs() < tolerance), "{name}: {sum:?} of {area}");
    }
}

fn refusal(name: &str) -> Option<MeshError> {
    let path = folder()?.join(name);
    Some(mesh::read(&path).err().unwrap_or_else(|| panic!("{name} was not refused")))
}

#[test]
fn malformed_files_are_refused_where_they_are_wrong() {
    for (name, line, section, found) in [
        ("malformed_cube_22_ascii_missing_element.msh", 46, "$Elements", "`$EndElements`"),
        ("malformed_cube_22_ascii_missing_num_nodes.msh", 5, "$Nodes", "`1 -0.5 -0.5 0`"),
        (
            "malformed_cube_41_ascii_mismatch_between_max_nodes_and_nodes_in_block.msh",
            9,
            "$Nodes",
            "node tags 1 to 100",
        ),
        ("malformed_cube_41_ascii_missing_element_header.msh", 41, "$Elements", "`1 10 9 12 11`"),
        ("malformed_cube_41_ascii_missing_node.msh", 38, "$Nodes", "`$EndNodes`"),
    ] {
        let Some(error) = refusal(&format!("malformed/{name}")) else {
            return;
        };
        assert!(matches!(error, MeshError::Malformed(_)), "{error}");
        let fault = error.fault().unwrap();
        assert_eq!((fault.place, fault.section.as_str()), (Location::Line(line), section), "{error}");
        assert_eq!(fault.found, found, "{error}");
    }
    let Some(error) = refusal("malformed/cube.msh") else {
        return;
    };
    assert!(matches!(error, MeshError::UnknownFormat { .. }), "{error}");
}

#[test]
fn a_hybrid_mesh_has_all_its_kinds() {
    let Some(mesh) = read("gmsh41_ascii/hybrid_lshape_L1.msh") else { return };
    let count = |wanted: ElementKind| mesh.each().filter(|(kind, _)| *kind == wanted).count();
    let found = [ElementKind::Tet4, ElementKind::Pyramid5, ElementKind::Wedge6].map(count);
    assert_eq!((found, mesh.element_count()), ([48, 48, 24], 120));
    assert!((mesh.volume() - 0.75).abs() < 1e-14);
}

#[test]
fn meshes_that_cannot_be_computed_with_are_refused_by_name() {
    let Some(error) = refusal("gmsh41_binary/sphere_p3.msh") else { return };
    let [Flaw::UnsupportedElements(cells)] = error.problems() else { panic!("{error}") };
    assert_eq!(cells[0].kind, "20-node (cubic) tetrahedron");
    assert!(matches!(cells[0].first, Location::Byte(_)));
    let error = refusal("gmsh41_ascii/ANSYS1e-3Corner_coarse.msh").unwrap();
    let [Flaw::Disconnected { elements, .. }] = error.problems() else { panic!("{error}") };
    assert_eq!(elements.len(), 2);
    assert_eq!(elements.iter().sum::<usize>(), 812);
}
