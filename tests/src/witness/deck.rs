//! A mesh as an Abaqus deck: nodes, elements and sets of nodes.

use std::fmt::Write as _;
use std::path::Path;

use vademecum_build::mesh::{Mesh, Order};

/// The mesh as text. Coordinates have 13 digits, since CalculiX reads 20 characters of a number.
pub(super) fn text(mesh: &Mesh) -> String {
    let mut out = String::from("*NODE, NSET=all\n");
    for (id, [x, y, z]) in mesh.node_ids.iter().zip(&mesh.nodes) {
        let _ = writeln!(out, "{id}, {x:.12e}, {y:.12e}, {z:.12e}");
    }
    let kind = match mesh.order() {
        Order::Linear => "C3D4",
        Order::Quadratic => "C3D10",
    };
    let _ = writeln!(out, "*ELEMENT, TYPE={kind}, ELSET=body");
    for element in 0..mesh.element_count() {
        let _ = write!(out, "{}", element + 1);
        for node in mesh.element(element) {
            let _ = write!(out, ", {}", mesh.node_ids[*node as usize]);
        }
        out.push('\n');
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

/// Writes a mesh.
///
/// # Panics
/// If it cannot be written.
pub fn write(path: &Path, mesh: &Mesh) {
    std::fs::write(path, text(mesh)).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
}
