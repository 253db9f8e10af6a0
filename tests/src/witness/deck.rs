//! A mesh as an Abaqus deck: nodes, elements and sets of nodes.

use std::fmt::Write as _;
use std::path::Path;

use vademecum_build::mesh::{ElementKind, Hexahedra, Mesh};

/// The mesh as text. Coordinates have 13 digits, since CalculiX reads 20 characters of a number.
pub(super) fn text(mesh: &Mesh) -> String {
    let mut out = String::from("*NODE, NSET=all\n");
    for (id, [x, y, z]) in mesh.node_ids.iter().zip(&mesh.nodes) {
        let _ = writeln!(out, "{id}, {x:.12e}, {y:.12e}, {z:.12e}");
    }
    let _ = writeln!(out, "*ELEMENT, TYPE={}, ELSET=body", element_type(mesh));
    for element in 0..mesh.element_count() {
        let nodes = mesh.element(element).iter().map(|&node| mesh.node_ids[node as usize].to_string());
        let entries: Vec<String> = std::iter::once((element + 1).to_string()).chain(nodes).collect();
        // A line has sixteen entries at most.
        let lines: Vec<String> = entries.chunks(16).map(|line| line.join(", ")).collect();
        let _ = writeln!(out, "{}", lines.join(",\n"));
    }
    for (name, nodes) in mesh.node_groups.iter().filter(|(name, _)| *name != "body") {
        let _ = writeln!(out, "*NSET, NSET={name}");
        for line in nodes.chunks(10) {
            let ids: Vec<String> =
                line.iter().map(|node| mesh.node_ids[*node as usize].to_string()).collect();
            let _ = writeln!(out, "{}", ids.join(", "));
        }
    }
    out
}

/// The name of the elements of a mesh that has one kind and one formulation.
fn element_type(mesh: &Mesh) -> &'static str {
    let reduced = matches!(mesh.regions[0].hexahedra, Some(Hexahedra::Reduced));
    match mesh.kinds.uniform() {
        Some(ElementKind::Tet4) => "C3D4",
        Some(ElementKind::Tet10) => "C3D10",
        Some(ElementKind::Wedge6) => "C3D6",
        Some(ElementKind::Wedge15) => "C3D15",
        Some(ElementKind::Hex8) => "C3D8",
        Some(ElementKind::Hex20) if reduced => "C3D20R",
        Some(ElementKind::Hex20) => "C3D20",
        other => panic!("a deck of {other:?} is not written here"),
    }
}

/// Writes a mesh.
///
/// # Panics
/// If it cannot be written, or has elements of several kinds.
pub fn write(path: &Path, mesh: &Mesh) {
    std::fs::write(path, text(mesh)).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
}
