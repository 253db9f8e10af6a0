//! Surfaces of a deck: faces of tetrahedra by number, free faces of sets, surface triangles.

use std::collections::HashMap;

use super::deck::DataLine;
use super::model::{Deck, Element, is_volume};
use crate::mesh::check::sorted_with_parity;
use crate::mesh::error::MeshError;
use crate::mesh::quality::EDGES;
use crate::mesh::raw::CellKind;

/// Corner places of the faces S1 to S4 of a tetrahedron.
const ABAQUS_FACES: [[usize; 3]; 4] = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];

impl Deck {
    /// Surfaces become facet groups.
    pub(crate) fn surface_groups(&mut self) -> Result<(), MeshError> {
        let surfaces = std::mem::take(&mut self.surfaces);
        if surfaces.is_empty() {
            return Ok(());
        }
        let free = self.free_faces();
        for (name, data) in &surfaces {
            let (mut facets, mut nodes) = (Vec::new(), Vec::new());
            for line in data {
                self.surface_line(line, &free, &mut facets, &mut nodes)?;
            }
            // A program may write a surface that it does not use, or one of elements that are refused anyway.
            if facets.is_empty() {
                self.raw
                    .notes
                    .push(format!("surface `{name}` names no face of a tetrahedron and is left out"));
                continue;
            }
            self.raw.facet_groups.insert(name.clone(), facets);
            self.raw.node_groups.insert(name.clone(), nodes);
        }
        Ok(())
    }

    fn surface_line(
        &self,
        line: &DataLine,
        free: &HashMap<[u32; 3], u32>,
        facets: &mut Vec<[u32; 3]>,
        nodes: &mut Vec<u32>,
    ) -> Result<(), MeshError> {
        let at = line.place.at("*SURFACE");
        let fields = line.fields();
        let label = fields.get(1).map_or(String::new(), |l| l.to_ascii_uppercase());
        let face = ["S1", "S2", "S3", "S4"].iter().position(|l| *l == label);
        let whole_surface = matches!(label.as_str(), "" | "SPOS" | "SNEG");
        let Some(first) = fields.first() else {
            return Err(at.malformed("a line without values", "an element or an element set, and a face"));
        };
        for e in self.members_of_field(line, first)? {
            let element = &self.elements[e];
            if matches!(element.kind, CellKind::Triangle3 | CellKind::Triangle6) && whole_surface {
                facets.push([element.nodes[0], element.nodes[1], element.nodes[2]]);
                nodes.extend_from_slice(&element.nodes);
                continue;
            }
            if !matches!(element.kind, CellKind::Tetrahedron4 | CellKind::Tetrahedron10) {
                continue;
            }
            // Other elements have other faces; they are refused by their type.
            if face.is_none() && !whole_surface {
                return Err(at.unsupported(
                    format!("face `{label}` of a tetrahedron"),
                    "S1 to S4 or no label",
                    "name faces that a tetrahedron has",
                ));
            }
            for (f, corners) in ABAQUS_FACES.iter().enumerate() {
                let key = sorted_with_parity(corners.map(|i| element.nodes[i])).0;
                if face == Some(f) || (face.is_none() && free.get(&key) == Some(&1)) {
                    facets.push(corners.map(|i| element.nodes[i]));
                    nodes.extend(face_nodes(element, *corners));
                }
            }
        }
        Ok(())
    }

    fn members_of_field(&self, line: &DataLine, field: &str) -> Result<Vec<usize>, MeshError> {
        let field = DataLine { text: field.to_string(), place: line.place.clone() };
        let find = |id| self.element_index.get(&id).copied();
        self.members(std::slice::from_ref(&field), "*SURFACE", &self.element_sets, find)
    }

    /// Number of tetrahedra of each face.
    fn free_faces(&self) -> HashMap<[u32; 3], u32> {
        let mut count = HashMap::new();
        for element in self.elements.iter().filter(|e| is_volume(e) && matches!(e.nodes.len(), 4 | 10)) {
            for face in ABAQUS_FACES {
                *count.entry(sorted_with_parity(face.map(|i| element.nodes[i])).0).or_default() += 1;
            }
        }
        count
    }
}

/// Corners and mid-side nodes of a face.
fn face_nodes(element: &Element, corners: [usize; 3]) -> Vec<u32> {
    let mut nodes = corners.map(|i| element.nodes[i]).to_vec();
    if element.nodes.len() == 10 {
        let on_face = |edge: &[usize; 2]| edge.iter().all(|i| corners.contains(i));
        nodes
            .extend(EDGES.iter().zip(&element.nodes[4..]).filter(|(edge, _)| on_face(edge)).map(|(_, &n)| n));
    }
    nodes
}
