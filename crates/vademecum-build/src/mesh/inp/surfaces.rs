//! Surfaces of a deck: faces of elements by number, free faces of sets, surface elements.

use std::collections::HashMap;

use super::deck::DataLine;
use super::model::Deck;
use crate::mesh::error::MeshError;
use crate::mesh::face_key;
use crate::mesh::raw::CellKind;

/// Corners of each face of an element, ascending.
type FaceCorners = [u32; 4];

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
                self.raw.notes.push(format!("surface `{name}` names no face of an element and is left out"));
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
        free: &HashMap<FaceCorners, u32>,
        facets: &mut Vec<[u32; 3]>,
        nodes: &mut Vec<u32>,
    ) -> Result<(), MeshError> {
        let at = line.place.at("*SURFACE");
        let fields = line.fields();
        let label = fields.get(1).map_or(String::new(), |l| l.to_ascii_uppercase());
        let face = ["S1", "S2", "S3", "S4", "S5", "S6"].iter().position(|l| *l == label);
        let whole_surface = matches!(label.as_str(), "" | "SPOS" | "SNEG");
        let Some(first) = fields.first() else {
            return Err(at.malformed("a line without values", "an element or an element set, and a face"));
        };
        for e in self.members_of_field(line, first)? {
            let element = &self.elements[e];
            if matches!(element.kind, CellKind::Facet(_)) && whole_surface {
                facets.push([element.nodes[0], element.nodes[1], element.nodes[2]]);
                nodes.extend_from_slice(&element.nodes);
                continue;
            }
            // Other cells have other faces; they are refused by their type.
            let CellKind::Solid(kind) = element.kind else { continue };
            if let (Some(written), Some(face)) = (&element.written, face) {
                let (kind, all) = &**written;
                if let Some((facet, places)) = kind.faces().get(face) {
                    facets.extend(distinct(&places[..facet.corners()], all));
                    nodes.extend(places.iter().filter_map(|&place| all.get(place)));
                    continue;
                }
            }
            // Both programs number faces as the table of kinds does.
            let faces = kind.faces();
            if !whole_surface && face.is_none_or(|face| face >= faces.len()) {
                return Err(at.unsupported(
                    format!("face `{label}` of a {}", kind.name()),
                    format!("S1 to S{} or no label", faces.len()),
                    "name faces that the element has",
                ));
            }
            for (f, found) in faces.iter().enumerate() {
                let key = face_key(found, &element.nodes).0;
                if face == Some(f) || (face.is_none() && free.get(&key) == Some(&1)) {
                    facets.push([0, 1, 2].map(|i| element.nodes[found.1[i]]));
                    nodes.extend(found.1.iter().map(|&i| element.nodes[i]));
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

    /// Number of elements of each face.
    fn free_faces(&self) -> HashMap<FaceCorners, u32> {
        let mut count = HashMap::new();
        for element in &self.elements {
            let CellKind::Solid(kind) = element.kind else { continue };
            for face in kind.faces() {
                *count.entry(face_key(face, &element.nodes).0).or_default() += 1;
            }
        }
        count
    }
}

/// Three corners of a face of an element with repeated ones; none of a face that is a line or a point.
fn distinct(corners: &[usize], nodes: &[u32]) -> Option<[u32; 3]> {
    let mut found: Vec<u32> = Vec::with_capacity(4);
    for node in corners.iter().filter_map(|&place| nodes.get(place)) {
        if !found.contains(node) {
            found.push(*node);
        }
    }
    found.first_chunk().copied()
}
