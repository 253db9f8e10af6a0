//! One small body in every format that is read, as another program writes it: `fixtures/meshes/bar`.
//!
//! Two cubes of a quarter metre, six tetrahedra each, regions `near` and `far`, the side x = 0 named `held`.

use std::collections::BTreeSet;
use std::path::PathBuf;

use vademecum_build::mesh::surface::Surface;
use vademecum_build::mesh::{self, Mesh, Order, block};

const SIDE: f64 = 0.25;

/// What a format can say about the body beside nodes and elements.
#[derive(Clone, Copy, PartialEq)]
enum Says {
    /// Names of the regions and the triangles of `held`.
    Names,
    /// Names of the regions and the nodes of `held`.
    Nodes,
    /// Numbers of the regions and the triangles of the side, number 7.
    Numbers,
    /// Numbers of the regions.
    Regions,
}

const FILES: [(&str, Says); 19] = [
    ("deck.inp", Says::Nodes),
    ("gmsh1.msh", Says::Numbers),
    ("gmsh22-binary.msh", Says::Names),
    ("gmsh22.msh", Says::Names),
    ("gmsh41-binary.msh", Says::Names),
    ("gmsh41.msh", Says::Names),
    ("medit.mesh", Says::Numbers),
    ("mfem.mesh", Says::Numbers),
    ("quadratic-deck.inp", Says::Nodes),
    ("quadratic-gmsh41-binary.msh", Says::Names),
    ("quadratic-vtu.vtu", Says::Regions),
    ("tetgen.ele", Says::Regions),
    ("tetgen.node", Says::Regions),
    ("vtk42-binary.vtk", Says::Regions),
    ("vtk42.vtk", Says::Regions),
    ("vtk51-binary.vtk", Says::Regions),
    ("vtk51.vtk", Says::Regions),
    ("vtu-binary.vtu", Says::Regions),
    ("vtu.vtu", Says::Regions),
];

fn folder() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/meshes/bar"))
}

fn read(name: &str) -> Mesh {
    mesh::read(&folder().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn order(name: &str) -> Order {
    if name.starts_with("quadratic") { Order::Quadratic } else { Order::Linear }
}

/// A place as bits: every coordinate of the body is exact in single precision and in decimals.
type Position = [u64; 3];

fn bits(mesh: &Mesh, node: u32) -> Position {
    mesh.nodes[node as usize].map(f64::to_bits)
}

/// Corners of every element with its region, and the nodes on its edges each with the two corners it lies
/// between.
fn solid(mesh: &Mesh, region: impl Fn(usize) -> u32) -> BTreeSet<(BTreeSet<Position>, u32, Vec<Position>)> {
    const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];
    let element = |index: usize| {
        let nodes = mesh.element(index);
        let corners = nodes[..4].iter().map(|&n| bits(mesh, n)).collect();
        for (middle, edge) in nodes[4..].iter().zip(EDGES) {
            let [a, b] = edge.map(|corner| mesh.nodes[nodes[corner] as usize]);
            let half: [f64; 3] = std::array::from_fn(|k| 0.5 * (a[k] + b[k]));
            assert_eq!(mesh.nodes[*middle as usize], half, "element {index}, edge {edge:?}");
        }
        let mut middles: Vec<Position> = nodes[4..].iter().map(|&n| bits(mesh, n)).collect();
        middles.sort_unstable();
        (corners, region(index), middles)
    };
    (0..mesh.element_count()).map(element).collect()
}

#[test]
fn every_file_of_the_folder_is_in_the_list() {
    let entries = std::fs::read_dir(folder()).unwrap();
    let mut found: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    found.sort();
    assert_eq!(found, FILES.map(|(name, _)| name));
}

#[test]
fn the_body_is_the_same_in_every_format() {
    for (name, says) in FILES {
        let found = read(name);
        let expected = block([2.0 * SIDE, SIDE, SIDE], [2, 1, 1], order(name));
        // The middle of an element tells on which side of x = SIDE it lies.
        let middle =
            |e: usize| expected.element(e)[..4].iter().map(|&n| expected.nodes[n as usize][0]).sum::<f64>();
        let expected = solid(&expected, |e| u32::from(middle(e) > 4.0 * SIDE));
        assert_eq!(expected.len(), 12);
        assert!(solid(&found, |e| found.element_region[e]) == expected, "{name} is another body");
        let regions: Vec<(i64, &str)> = found.regions.iter().map(|r| (r.tag, r.name.as_str())).collect();
        let names = match says {
            Says::Names | Says::Nodes => ["near", "far"],
            Says::Numbers | Says::Regions => ["region 1", "region 2"],
        };
        assert_eq!(regions, [(1, names[0]), (2, names[1])], "{name}");
    }
}

#[test]
fn the_side_has_its_name_or_its_number() {
    for (name, says) in FILES {
        let mesh = read(name);
        let group = match says {
            Says::Names | Says::Nodes => "held",
            Says::Numbers => "surface 7",
            Says::Regions => {
                assert!(mesh.facet_groups.is_empty(), "{name}");
                continue;
            }
        };
        let nodes = mesh.node_groups[group].iter().map(|&n| mesh.nodes[n as usize]);
        assert!(nodes.clone().all(|[x, ..]| x == 0.0), "{name}");
        let corners = nodes.filter(|p| p.iter().all(|x| [0.0, SIDE].contains(x))).count();
        assert_eq!(corners, 4, "{name}");
        assert_eq!(mesh.facet_groups.get(group).map_or(0, Vec::len), if says == Says::Nodes { 0 } else { 2 });
    }
}

#[test]
fn the_surface_is_closed() {
    for (name, _) in FILES {
        let mesh = read(name);
        let surface = Surface::of(&mesh);
        let (mut sum, mut area) = ([0.0; 3], 0.0);
        for triangle in &surface.triangles {
            let [a, b, c] = triangle.map(|n| mesh.nodes[n as usize]);
            let (p, q): ([f64; 3], [f64; 3]) =
                (std::array::from_fn(|k| b[k] - a[k]), std::array::from_fn(|k| c[k] - a[k]));
            let v = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
            // Each triangle lies in a side, so its area is one component; all numbers are powers of two.
            area += 0.5 * v.iter().map(|x| x.abs()).sum::<f64>();
            (0..3).for_each(|k| sum[k] += v[k]);
        }
        assert_eq!(sum, [0.0; 3], "{name}");
        assert_eq!(area, 10.0 * SIDE * SIDE, "{name}");
    }
}
