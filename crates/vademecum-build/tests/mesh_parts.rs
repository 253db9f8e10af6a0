//! Blocks, surfaces, selections, fields and small hand-made files of every format.

use std::path::Path;

use vademecum_build::field::{self, Cells, FieldError};
use vademecum_build::mesh::select::{SelectError, Selection};
use vademecum_build::mesh::surface::Surface;
use vademecum_build::mesh::{self, Flaw, Mesh, MeshError, Order, block};

fn area_sum(mesh: &Mesh, surface: &Surface) -> ([f64; 3], f64) {
    let (mut sum, mut area) = ([0.0; 3], 0.0);
    for triangle in &surface.triangles {
        let [a, b, c] = triangle.map(|n| mesh.nodes[n as usize]);
        let p: [f64; 3] = std::array::from_fn(|k| b[k] - a[k]);
        let q: [f64; 3] = std::array::from_fn(|k| c[k] - a[k]);
        let v = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
        area += 0.5 * v.iter().map(|x| x * x).sum::<f64>().sqrt();
        (0..3).for_each(|k| sum[k] += 0.5 * v[k]);
    }
    (sum, area)
}

#[test]
fn a_block_has_its_volume_its_surface_and_its_sides() {
    for order in [Order::Linear, Order::Quadratic] {
        // Halves and quarters only: every sum is exact.
        let mesh = block([2.0, 1.0, 0.5], [4, 2, 2], order);
        assert_eq!(mesh.element_count(), 6 * 16);
        let refined = |n: usize| match order {
            Order::Linear => n + 1,
            Order::Quadratic => 2 * n + 1,
        };
        assert_eq!(mesh.nodes.len(), refined(4) * refined(2) * refined(2));
        // The rule for quadratic elements has weights with no exact binary form.
        assert!((mesh.volume() - 1.0).abs() <= 96.0 * f64::EPSILON);
        let surface = Surface::of(&mesh);
        let (sum, area) = area_sum(&mesh, &surface);
        assert_eq!(sum, [0.0; 3]);
        assert!((area - 7.0).abs() < 1e-13, "{area}: a sum of some hundred square roots");
        assert_eq!(surface.facet_count(), 2 * 2 * (4 * 2 + 4 * 2 + 2 * 2));
        for name in ["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"] {
            let facets = surface.facets_within(&mesh.node_groups[name]);
            assert_eq!(facets.len(), mesh.facet_groups[name].len(), "{name}");
        }
        let side = surface.position(mesh.node_groups["x_max"][0]).unwrap();
        assert!(surface.normals[side][0] > 0.0);
        let again = block([2.0, 1.0, 0.5], [4, 2, 2], order);
        assert_eq!(mesh::hash(&mesh), mesh::hash(&again));
        assert_ne!(mesh::hash(&mesh), mesh::hash(&block([2.0, 1.0, 0.5000001], [4, 2, 2], order)));
    }
}

fn select(text: &str, mesh: &Mesh) -> Result<Vec<u32>, SelectError> {
    #[derive(serde::Deserialize)]
    struct Holder {
        on: Selection,
    }
    toml::from_str::<Holder>(text).unwrap_or_else(|e| panic!("{e}")).on.nodes(mesh)
}

#[test]
fn selections_choose_the_nodes_they_describe() {
    let mesh = block([2.0, 1.0, 1.0], [4, 2, 2], Order::Linear);
    let counts = [
        ("on = { group = 'x_min' }", 9),
        ("on = { nodes = [1, 2, 2] }", 2),
        ("on = { plane = { axis = 'x', at = 2.0 } }", 9),
        ("on = { plane = { normal = [0, 0, 3.0], point = [0, 0, 0.5], tolerance = 0 } }", 15),
        ("on = { box = { min = [0, 0, 0], max = [0.5, 1, 1] } }", 18),
        ("on = { sphere = { center = [0, 0, 0], radius = 0.5 } }", 4),
        ("on = { fraction = { axis = 'x', side = 'max', fraction = 0.25 } }", 18),
        ("on = { quantile = { axis = 'x', side = 'min', fraction = 0.2 } }", 9),
        ("on = { any = [{ group = 'x_min' }, { group = 'x_max' }] }", 18),
        ("on = { all = [{ group = 'x_min' }, { group = 'y_min' }] }", 3),
    ];
    for (text, count) in counts {
        assert_eq!(select(text, &mesh).unwrap().len(), count, "{text}");
    }
}

#[test]
fn selections_without_sense_say_what_there_is() {
    let mesh = block([1.0; 3], [1; 3], Order::Linear);
    let message = select("on = { group = 'top' }", &mesh).unwrap_err().to_string();
    assert!(message.contains("`top`") && message.contains("`z_max`"), "{message}");
    let empty = select("on = { box = { min = [5, 5, 5], max = [6, 6, 6] } }", &mesh);
    assert!(matches!(empty, Err(SelectError::Empty { .. })));
    let unknown = select("on = { nodes = [99] }", &mesh);
    assert_eq!(unknown, Err(SelectError::UnknownNode { id: 99, least: 1, largest: 8 }));
    for text in [
        "on = { plane = { axis = 'x' } }",
        "on = { plane = { normal = [0, 0, 0], point = [0, 0, 0] } }",
        "on = { fraction = { axis = 'x', side = 'max', fraction = 25 } }",
    ] {
        assert!(matches!(select(text, &mesh), Err(SelectError::BadPredicate(_))), "{text}");
    }
    for text in ["box = { min = [0,0,0], max = [1,1,1], middle = 1 }", "group = 'a'\nnodes = [1]"] {
        assert!(toml::from_str::<Selection>(text).is_err(), "{text}");
    }
}

#[test]
fn a_written_vtu_reads_back_as_the_same_mesh_and_fields() {
    let folder = tempfile::tempdir().unwrap();
    for order in [Order::Linear, Order::Quadratic] {
        let mesh = block([1.0, 2.0, 3.0], [1, 2, 1], order);
        let path = folder.path().join("u.vtu");
        let u: Vec<f64> = (0..3 * mesh.nodes.len()).map(|i| (i as f64).sqrt()).collect();
        let cells = Cells::Elements(&mesh.kinds, &mesh.elements);
        field::write_vtu(&path, &mesh.nodes, cells, &[("displacement", &u, 3)]).unwrap();
        assert_eq!(mesh::hash(&mesh::read(&path).unwrap()), mesh::hash(&mesh));
        let files = [path.clone(), path.clone()];
        let matrix = field::read_displacements(&files, "displacement", &mesh).unwrap();
        assert_eq!((matrix.rows, matrix.columns), (u.len(), 2));
        assert_eq!(matrix.column(1), u);
        let error = field::read_displacements(&files, "velocity", &mesh).unwrap_err();
        assert!(matches!(error, FieldError::NoSuchField { .. }), "{error}");
        let foreign = block([1.0, 2.0, 3.1], [1, 2, 1], order);
        let error = field::read_displacements(&files, "displacement", &foreign).unwrap_err();
        assert!(matches!(error, FieldError::ForeignMesh { .. }), "{error}");
        let error = field::write_vtu(&path, &mesh.nodes, cells, &[("u", &u[1..], 3)]).unwrap_err();
        assert!(matches!(error, FieldError::WrongLength { .. }), "{error}");
    }
}

#[test]
fn a_surface_and_a_collection_are_written_and_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = block([1.0; 3], [2; 3], Order::Quadratic);
    let surface = Surface::of(&mesh);
    let path = folder.path().join("s & t.vtu");
    field::write_vtu(&path, &mesh.nodes, Cells::Triangles(&surface.triangles), &[]).unwrap();
    assert_eq!(field::read_vtu(&path).unwrap().points, mesh.nodes);
    // A surface is no solid, and is refused as such.
    let error = mesh::read(&path).unwrap_err();
    assert_eq!(error.problems(), [Flaw::NoElements]);
    let pvd = folder.path().join("all.pvd");
    field::write_pvd(&pvd, &[(0.5, "s & t.vtu".into())]).unwrap();
    assert_eq!(field::read_pvd(&pvd).unwrap(), [(0.5, path)]);
}

/// Two tetrahedra on five nodes, as a deck with everything a deck can have.
const DECK: &str = "*HEADING\nanything, at all\n*NODE, NSET=Nall\n1, 0, 0, 0\n2, 1.0, 0., 0\n3, 0, 1.D0, 0\n\
4, 0, 0, 1\n\
5, 1, 1, 1\n*ELEMENT, TYPE=C3D4,\n ELSET=Eall\n1, 1, 2,\n3, 4\n2, 2, 3, 4, 5\n*NSET, NSET=base, GENERATE\n\
1, 3, 1\n\
*NSET, NSET=more\nBASE, 5\n*ELSET, ELSET=lower\n1\n*SURFACE, NAME=down, TYPE=ELEMENT\nlower, S1\n\
*SURFACE, NAME=skin, TYPE=ELEMENT\nEall,\n*SOLID SECTION, ELSET=Eall, MATERIAL=steel\n*STEP\n*STATIC\n\
*END STEP\n";

fn read_text(name: &str, text: &str) -> Result<Mesh, MeshError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    mesh::read(&path)
}

#[test]
fn a_deck_keeps_its_sets_and_surfaces() {
    let mesh = read_text("deck.inp", DECK).unwrap();
    assert_eq!((mesh.nodes.len(), mesh.element_count()), (5, 2));
    assert_eq!(mesh.node_groups["base"], [0, 1, 2]);
    assert_eq!(mesh.node_groups["more"], [0, 1, 2, 4]);
    assert_eq!(mesh.node_groups["Nall"].len(), 5);
    assert_eq!(mesh.facet_groups["down"], [[0, 2, 1]]);
    assert_eq!(mesh.facet_groups["skin"].len(), 6);
    assert_eq!(mesh.regions[0].name, "Eall");
}

#[test]
fn decks_that_would_be_misread_are_refused_by_name() {
    let cases = [
        ("*NGEN\n1, 5\n", "*NGEN"),
        ("*ELEMENT, TYPE=C3D27X\n9, 1\n", "*ELEMENT"),
        ("*ELEMENT, TYPE=XYZ\n9, 1\n", "*ELEMENT"),
        ("*INSTANCE, NAME=a, PART=b\n1., 0., 0.\n", "*INSTANCE"),
        ("*INSTANCE, NAME=a, PART=b\n*END INSTANCE\n*INSTANCE, NAME=c, PART=b\n", "*INSTANCE"),
        ("*NSET, NSET=x\nnowhere\n", "*NSET"),
        ("*NODE, SYSTEM=C\n9, 0, 0, 0\n", "*NODE"),
        ("*NODE\n1, 0, 0, 0\n", "*NODE"),
        ("*INCLUDE, INPUT=deck.inp\n", "*INCLUDE"),
        ("*SURFACE, NAME=x\nEall, S5\n", "*SURFACE"),
        ("*SOLID SECTION, ELSET=none\n", "*SOLID SECTION"),
    ];
    for (more, section) in cases {
        let error = read_text("deck.inp", &format!("{DECK}{more}")).expect_err(more);
        if let Some(fault) = error.fault() {
            assert_eq!(fault.section, section, "{error}");
            assert!(matches!(fault.place, mesh::Location::Line(line) if line > 26), "{error}");
        } else {
            assert!(matches!(error.problems()[0], Flaw::UnsupportedElements(_)), "{more}: {error}");
        }
    }
}

#[test]
fn an_included_file_is_read_relative_to_its_deck() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    std::fs::write(folder.path().join("sub/mesh.inp"), DECK).unwrap();
    let path = folder.path().join("main.inp");
    std::fs::write(&path, "*INCLUDE, INPUT=sub/mesh.inp\n*NSET, NSET=late\n5\n").unwrap();
    assert_eq!(mesh::read(&path).unwrap().node_groups["late"], [4]);
}

#[test]
fn tables_count_from_zero_or_one() {
    let folder = tempfile::tempdir().unwrap();
    let (points, cells) = (folder.path().join("x.csv"), folder.path().join("t.txt"));
    std::fs::write(&points, "# x, y, z\n0, 0, 0\n1;0;0\n0 1 0\n0\t0\t1\n").unwrap();
    for (text, base) in [("1 2 3 4\n", 1), ("0, 1, 2, 3\n", 0)] {
        std::fs::write(&cells, text).unwrap();
        let mesh = mesh::read_tables(&points, &cells).unwrap();
        assert_eq!(mesh.node_ids[0], base);
        assert!(mesh.notes[0].ends_with(&format!("count from {base}")));
        assert!((mesh.volume() - 1.0 / 6.0).abs() < f64::EPSILON);
    }
    std::fs::write(&cells, "1 2 3 5\n").unwrap();
    let error = mesh::read_tables(&points, &cells).unwrap_err();
    assert_eq!(error.fault().unwrap().found, "node 5");
}

/// Coordinates and tetrahedra as the two tables of the chapter.
fn tables(points: &str, cells: &str) -> Result<Mesh, MeshError> {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (folder.path().join("x"), folder.path().join("t"));
    std::fs::write(&a, points).unwrap();
    std::fs::write(&b, cells).unwrap();
    mesh::read_tables(Path::new(&a), Path::new(&b))
}

#[test]
fn unsound_meshes_are_refused_by_name() {
    const UNIT: &str = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
    let problem = |points: &str, cells: &str| tables(points, cells).unwrap_err().problems()[0].clone();
    let flat = problem("0 0 0\n1 0 0\n0 1 0\n0.3 0.3 0\n", "1 2 3 4\n");
    assert!(
        matches!(flat, Flaw::DegenerateElements { count: 1, ref first, .. } if *first == [1, 2, 3, 4]),
        "{flat}"
    );
    let twin = problem(&format!("{UNIT}0 0 1.0\n1 1 1\n"), "1 2 3 4\n2 3 5 6\n");
    assert!(matches!(twin, Flaw::DuplicateNodes { count: 1, first: [4, 5], .. }), "{twin}");
    let apart = problem(&format!("{UNIT}5 0 0\n6 0 0\n5 1 0\n5 0 1\n"), "1 2 3 4\n5 6 7 8\n");
    assert!(matches!(&apart, Flaw::Disconnected { elements, .. } if elements == &[1, 1]), "{apart}");
    let twice = problem(&format!("{UNIT}1 1 1\n"), "1 2 3 4\n1 2 3 4\n2 3 4 5\n");
    assert!(
        matches!(twice, Flaw::OverlappingElements { count: 1, ref first } if *first == [2, 3, 4]),
        "{twice}"
    );
    let mids = "0.5 0 0\n0.5 0.5 0\n0 0.5 0\n0 0 0.5\n0.5 0 0.5\n0 0.5 0.5\n";
    assert!(tables(&format!("{UNIT}{mids}"), "1 2 3 4 5 6 7 8 9 10\n").is_ok());
    let bent = mids.replacen("0.5 0 0", "0.5 0.9 0.9", 1);
    let folded = problem(&format!("{UNIT}{bent}"), "1 2 3 4 5 6 7 8 9 10\n");
    assert!(matches!(folded, Flaw::FoldedElements { count: 1, .. }), "{folded}");
    let mixed = problem(&format!("{UNIT}{mids}1 1 1\n"), "1 2 3 4 5 6 7 8 9 10\n2 3 4 11\n");
    assert_eq!(mixed, Flaw::MixedOrders { linear: 1, quadratic: 1 });
}

/// The corners of each edge in the order of a connectivity table, as `formats/problem-1.md` prints it.
fn edges_of_the_text() -> Vec<[usize; 2]> {
    let text = include_str!("../../../formats/problem-1.md");
    let row =
        text.lines().find(|line| line.starts_with("| node | corner 0 |")).expect("the row of the order");
    let cells: Vec<&str> = row.split('|').map(str::trim).filter(|cell| !cell.is_empty()).collect();
    assert_eq!(cells[..5], ["node", "corner 0", "corner 1", "corner 2", "corner 3"]);
    let corners = |cell: &str| {
        let digits: Vec<usize> = cell.chars().filter_map(|c| c.to_digit(10)).map(|d| d as usize).collect();
        [digits[0], digits[1]]
    };
    cells[5..].iter().map(|cell| corners(cell.strip_prefix("edge ").expect("an edge"))).collect()
}

/// The unit tetrahedron with the middle of the edge `bent` moved by `bend`, as tables whose
/// line names the edges in the order given.
fn curved(order: &[[usize; 2]], bent: [usize; 2], bend: [f64; 3]) -> Result<Mesh, MeshError> {
    const CORNERS: [[f64; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let same = |a: [usize; 2], b: [usize; 2]| a == b || a == [b[1], b[0]];
    let middle = |edge: [usize; 2]| -> [f64; 3] {
        let moved = if same(edge, bent) { 1.0 } else { 0.0 };
        std::array::from_fn(|k| 0.5 * (CORNERS[edge[0]][k] + CORNERS[edge[1]][k]) + moved * bend[k])
    };
    let nodes = CORNERS.into_iter().chain(order.iter().map(|&edge| middle(edge)));
    let points: String = nodes.map(|p| format!("{} {} {}\n", p[0], p[1], p[2])).collect();
    tables(&points, "1 2 3 4 5 6 7 8 9 10\n")
}

#[test]
fn ten_nodes_follow_the_order_of_the_text() {
    const SLOPES: [[f64; 3]; 4] = [[-1.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let bend = [0.09, -0.05, 0.02];
    let order = edges_of_the_text();
    assert_eq!(order.len(), 6);
    // One node moved by d changes the volume form to 1 + d·∇N, linear in d; N = 4 L_a L_b on the edge ab, and
    // the mean of ∇N is ∇L_a + ∇L_b. So six bent edges have six volumes.
    let volume = |[a, b]: [usize; 2]| {
        let slope = |k: usize| SLOPES[a][k] + SLOPES[b][k];
        (1.0 + (0..3).map(|k| bend[k] * slope(k)).sum::<f64>()) / 6.0
    };
    for &edge in &order {
        let mesh = curved(&order, edge, bend).expect("a sound element");
        let expected = volume(edge);
        assert!((mesh.volume() - expected).abs() <= 16.0 * f64::EPSILON, "{edge:?}: {}", mesh.volume());
        assert!(order.iter().all(|&other| other == edge || (volume(other) - expected).abs() > 1e-3));
    }
    // Any two edges exchanged, as other programs have them: refused, or another body.
    for (i, j) in (0..6).flat_map(|i| (0..i).map(move |j| (i, j))) {
        let mut other = order.clone();
        other.swap(i, j);
        for &edge in &order {
            if let Ok(mesh) = curved(&other, edge, bend) {
                assert!((mesh.volume() - volume(edge)).abs() > 1e-3, "{i} and {j} exchanged, {edge:?} bent");
            }
        }
    }
}

#[test]
fn a_turned_quadratic_element_keeps_its_edges() {
    let mesh = block([1.0; 3], [1; 3], Order::Quadratic);
    let points: String = mesh.nodes.iter().map(|p| format!("{} {} {}\n", p[0], p[1], p[2])).collect();
    // Exchanging corners 0 and 2 exchanges edges (0,1)-(1,2) and (0,3)-(2,3).
    let turned: String = mesh
        .elements
        .chunks_exact(10)
        .map(|e| {
            let f = [e[2], e[1], e[0], e[3], e[5], e[4], e[6], e[9], e[8], e[7]];
            f.map(|n| (n + 1).to_string()).join(" ") + "\n"
        })
        .collect();
    let read = tables(&points, &turned).unwrap();
    assert!(read.notes.iter().any(|n| n == "6 inverted elements were reoriented"), "{:?}", read.notes);
    assert!((read.volume() - 1.0).abs() < 1e-14);
}

#[test]
fn a_group_without_elements_takes_the_nodes_of_its_geometry() {
    // Surface 1 is named; its curve 5 bounds it; no triangle is saved.
    let text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 7 \"side\"\n2 8 \"lost\"\n\
        $EndPhysicalNames\n\
        $Entities\n0 1 1 1\n5 0 0 0 1 0 0 0 0\n1 0 0 0 1 1 0 1 7 1 -5\n1 0 0 0 1 1 1 0 1 1\n$EndEntities\n\
        $Nodes\n\
        3 4 1 9\n1 5 0 2\n1\n2\n0 0 0\n1 0 0\n2 1 0 1\n3\n0 1 0\n3 1 0 1\n9\n0 0 1\n$EndNodes\n$Elements\n\
        1 1 2 2\n\
        3 1 4 1\n2 1 2 3 9\n$EndElements\n";
    let mesh = read_text("named.msh", text).unwrap();
    assert_eq!(mesh.node_groups["side"], [0, 1, 2]);
    assert!(!mesh.node_groups.contains_key("lost"));
    assert!(mesh.notes.iter().any(|n| n.contains("`lost` is named, but")), "{:?}", mesh.notes);
}

/// A partitioned copy: entities with parents and partitions, ghosts, physical groups on the partitions.
#[test]
fn partitioned_entities_keep_their_groups() {
    let text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 1\n1 0 0 0 1 1 1 1 4 0\n$EndEntities\n\
        $PartitionedEntities\n2\n1\n1 1\n0 0 0 1\n2 3 1 1 1 0 0 0 1 1 1 1 4 0\n$EndPartitionedEntities\n\
        $Nodes\n\
        1 4 1 4\n3 2 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n$Elements\n1 1 1 1\n3 2 4 1\n\
        1 1 2 3 4\n\
        $EndElements\n$GhostElements\n0\n$EndGhostElements\n";
    assert_eq!(read_text("parts.msh", text).unwrap().regions[0].tag, 4);
}

/// One VTU file per encoding: the arrays of two tetrahedra, inline or appended, plain or compressed, both
/// header widths and byte orders.
fn encoded_vtu(wide: bool, big: bool, compressed: bool, appended: Option<&str>) -> Vec<u8> {
    use base64::{Engine as _, engine::general_purpose::STANDARD};
    use std::io::Write as _;
    let order = |bytes: [u8; 8]| {
        if big { bytes.into_iter().rev().collect() } else { bytes.to_vec() }
    };
    let points = [0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 1., 1., 1.];
    let reals: Vec<u8> = points.iter().flat_map(|x: &f64| order(x.to_le_bytes())).collect();
    let integers = |v: &[i64]| -> Vec<u8> { v.iter().flat_map(|i| order(i.to_le_bytes())).collect() };
    let arrays = [reals, integers(&[0, 1, 2, 3, 1, 2, 3, 4]), integers(&[4, 8]), vec![10, 10]];
    let size = |n: usize| -> Vec<u8> {
        let bytes = order((n as u64).to_le_bytes());
        match (wide, big) {
            (true, _) => bytes,
            (false, true) => bytes[4..].to_vec(),
            (false, false) => bytes[..4].to_vec(),
        }
    };
    // Header and data; two blocks per compressed array.
    let parts = arrays.map(|bytes| {
        if !compressed {
            return (size(bytes.len()), bytes, true);
        }
        let half = bytes.len() / 2 + 1;
        let packed: Vec<Vec<u8>> = bytes
            .chunks(half)
            .map(|block| {
                let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
                encoder.write_all(block).unwrap();
                encoder.finish().unwrap()
            })
            .collect();
        let last = bytes.len() % half;
        let header = [packed.len(), half, last].into_iter().chain(packed.iter().map(Vec::len)).flat_map(size);
        (header.collect(), packed.concat(), false)
    });
    let stored = parts.map(|(header, data, together)| match appended {
        Some("raw") => [header, data].concat(),
        _ if together => STANDARD.encode([header, data].concat()).into_bytes(),
        _ => (STANDARD.encode(header) + &STANDARD.encode(data)).into_bytes(),
    });
    let byte_order = if big { "BigEndian" } else { "LittleEndian" };
    let header = if wide { "UInt64" } else { "UInt32" };
    let compressor = if compressed { " compressor=\"vtkZLibDataCompressor\"" } else { "" };
    let mut offset = 0;
    let mut array = |i: usize, attributes: &str| {
        let start = offset;
        offset += stored[i].len();
        match appended {
            Some(_) => format!("<DataArray {attributes} format=\"appended\" offset=\"{start}\"/>"),
            None => {
                let text = String::from_utf8(stored[i].clone()).unwrap();
                format!("<DataArray {attributes} format=\"binary\">\n {text}\n</DataArray>")
            }
        }
    };
    let mut text = format!(
        "<?xml version=\"1.0\"?><VTKFile type=\"UnstructuredGrid\" byte_order=\"{byte_order}\" \
         header_type=\"{header}\"{compressor}><UnstructuredGrid>\
         <Piece NumberOfPoints=\"5\" NumberOfCells=\"2\"><Points>{}</Points><Cells>{}{}{}\
         </Cells></Piece></UnstructuredGrid>",
        array(0, "type=\"Float64\" NumberOfComponents=\"3\""),
        array(1, "type=\"Int64\" Name=\"connectivity\""),
        array(2, "type=\"Int64\" Name=\"offsets\""),
        array(3, "type=\"UInt8\" Name=\"types\"")
    )
    .into_bytes();
    if let Some(encoding) = appended {
        text.extend(format!("<AppendedData encoding=\"{encoding}\">_").bytes());
        text.extend(stored.concat());
        text.extend(b"</AppendedData>");
    }
    text.extend(b"</VTKFile>");
    text
}

#[test]
fn every_encoding_of_vtu_gives_the_same_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.vtu");
    let mut hashes = Vec::new();
    for code in 0..8 {
        let [wide, big, compressed] = [code & 1 > 0, code & 2 > 0, code & 4 > 0];
        for appended in [None, Some("raw"), Some("base64")] {
            std::fs::write(&path, encoded_vtu(wide, big, compressed, appended)).unwrap();
            let case = format!("wide {wide}, big {big}, compressed {compressed}, appended {appended:?}");
            let mesh = mesh::read(&path).unwrap_or_else(|e| panic!("{case}: {e}"));
            hashes.push(mesh::hash(&mesh));
        }
    }
    assert!(hashes.iter().all(|h| *h == hashes[0]));
}

#[test]
fn binary_gmsh_files_of_the_other_byte_order_are_read() {
    // MSH 2.2, big-endian, one tetrahedron of physical group 3.
    let mut bytes = b"$MeshFormat\n2.2 1 8\n".to_vec();
    bytes.extend(1_i32.to_be_bytes());
    bytes.extend(b"\n$EndMeshFormat\n$Nodes\n4\n");
    for (id, p) in [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]].iter().enumerate() {
        bytes.extend((id as i32 + 1).to_be_bytes());
        p.iter().for_each(|x: &f64| bytes.extend(x.to_be_bytes()));
    }
    bytes.extend(b"\n$EndNodes\n$Elements\n1\n");
    [4, 1, 2, 1, 3, 1, 1, 2, 3, 4].iter().for_each(|i: &i32| bytes.extend(i.to_be_bytes()));
    bytes.extend(b"\n$EndElements\n");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("big.msh");
    std::fs::write(&path, bytes).unwrap();
    let mesh = mesh::read(&path).unwrap();
    assert_eq!((mesh.regions[0].tag, mesh.volume()), (3, 1.0 / 6.0));
}

#[test]
fn a_polyhedron_is_refused_with_its_kind_its_count_and_its_place() {
    let text = "# vtk DataFile Version 5.1\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 9 float\n\
        0 0 0 1 0 0 1 1 0 0 1 0\n\
        0 0 1 1 0 1 1 1 1 0 1 1 0 0 2\nCELLS 3 12\nOFFSETS vtktypeint64\n0 4 12\nCONNECTIVITY vtktypeint64\n\
        4 5 7 8\n\
        0 1 2 3 4 5 6 7\nCELL_TYPES 2\n10 42\n";
    let error = read_text("poly.vtk", text).unwrap_err();
    let message = error.to_string();
    assert!(message.contains("1 × polyhedron (first at cell 1)"), "{message}");
}

#[test]
fn ten_node_orders_of_other_programs_become_ours() {
    // Mid-side nodes 5 to 10 in Gmsh's order: the last two are on (2,3) and (1,3).
    let points = [
        [0., 0., 0.],
        [1., 0., 0.],
        [0., 1., 0.],
        [0., 0., 1.],
        [0.5, 0., 0.],
        [0.5, 0.5, 0.],
        [0., 0.5, 0.],
        [0., 0., 0.5],
        [0., 0.5, 0.5],
        [0.5, 0., 0.5],
    ];
    let lines = |from: usize| -> String {
        points.iter().enumerate().map(|(i, p)| format!("{} {} {} {}\n", i + from, p[0], p[1], p[2])).collect()
    };
    let gmsh = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n{}$EndNodes\n$Elements\n1\n\
         1 11 2 1 1 1 2 3 4 5 6 7 8 9 10\n\
         $EndElements\n",
        lines(1)
    );
    let wanted = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8];
    assert_eq!(read_text("ten.msh", &gmsh).unwrap().elements, wanted);
    // TetGen's mid-side nodes are placed by position, in whatever order they come.
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("t.node"), format!("10 3 0 0\n{}", lines(0))).unwrap();
    std::fs::write(folder.path().join("t.ele"), "1 10 0\n0 0 1 2 3 9 8 7 6 5 4\n").unwrap();
    assert_eq!(mesh::read(&folder.path().join("t.ele")).unwrap().elements, wanted);
}
