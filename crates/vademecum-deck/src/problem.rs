//! From a deck to the parts of a problem file: materials and supports in SI units.

use std::collections::BTreeMap;
use std::fmt::Write;

use vademecum_build::fem::Material;
use vademecum_build::mesh::{ElementKind, Hexahedra};

use crate::deck::{Deck, NodeNumber, Step};
use crate::error::DeckError;

/// Parts of a problem file that a deck gives.
#[derive(Clone, Debug)]
pub struct ProblemParts {
    /// Metres in a unit of the deck.
    pub scale: f64,
    /// Tables of materials.
    pub materials: String,
    /// Names of the materials' origin, for a person.
    pub material_words: String,
    /// Selections and components of each support, as lines of a problem file.
    pub supports: Vec<String>,
    /// The same for a person.
    pub support_words: String,
    /// Parts of the deck that a problem file does not hold.
    pub missing: Vec<String>,
}

impl Deck {
    /// Materials and supports in SI units; a density where the deck has none, in kg/m³.
    ///
    /// # Errors
    /// [`DeckError::UnknownUnits`], [`DeckError::Incomplete`] without a density.
    pub fn problem_parts(&self, density: Option<f64>) -> Result<ProblemParts, DeckError> {
        let system = self.units.0.ok_or_else(|| DeckError::UnknownUnits { file: self.file.clone() })?;
        let [metre, pascal, kilogram] = system.factors();
        let mut materials = String::new();
        let single = self.materials.len() == 1;
        let is_hexahedron =
            |kind: &ElementKind| matches!(kind, ElementKind::Hex8 | ElementKind::Hex20 | ElementKind::Hex27);
        let hexahedra = self.mesh.each().any(|(kind, _)| is_hexahedron(&kind));
        for (region, material) in self.mesh.regions.iter().zip(&self.materials) {
            let Material { young, poisson, density: own } = *material;
            let density = if own > 0.0 { Some(own * kilogram) } else { density };
            let density = density.ok_or_else(|| DeckError::Incomplete {
                material: region.name.clone(),
                quantity: "density",
                card: "*DENSITY (RHO of MAT1, DENS), or `--material NAME`, whose density is then taken,",
            })?;
            materials += "[[material]]\n";
            if !single {
                let _ = writeln!(materials, "region = {:?}", region.name);
            }
            let young = young * pascal;
            let _ = writeln!(
                materials,
                "young = {young:e} # Pa\npoisson = {poisson:?}\ndensity = {density:?} # kg/m³"
            );
            if let Some(formulation) = region.hexahedra.filter(|_| hexahedra) {
                let name = match formulation {
                    Hexahedra::Incompatible => "incompatible",
                    Hexahedra::MeanDilatation => "mean-dilatation",
                    Hexahedra::Full => "full",
                    Hexahedra::Reduced => "reduced",
                };
                let _ = writeln!(materials, "hexahedra = \"{name}\"");
            }
            materials.push('\n');
        }
        let (supports, support_words, given) = self.support_lines();
        let mut missing = given;
        let mut count = |number: usize, words: &str| {
            if number > 0 {
                missing.push(format!("{number} {words}"));
            }
        };
        count(self.links.len(), "couplings, ties or equations");
        count(self.attachments.len(), "masses, springs, dashpots or bars");
        count(self.axes.len(), "nodes with own axes");
        count(self.steps.iter().map(|step| step.loads.len()).sum(), "loads of its steps");
        if self.lumped.contains(&true) {
            missing.push("the lumped mass of linear elements: bodies have a consistent one".into());
        }
        if self.inner_functions && self.has_kind(Hexahedra::Incompatible) {
            missing.push("the mass of incompatible modes: bodies eliminate them".into());
        }
        let names: Vec<&str> = self.mesh.regions.iter().map(|region| region.name.as_str()).collect();
        Ok(ProblemParts {
            scale: metre,
            materials,
            material_words: format!("the materials of {}", names.join(", ")),
            supports,
            support_words,
            missing,
        })
    }

    /// True if some region has hexahedra of a formulation.
    fn has_kind(&self, formulation: Hexahedra) -> bool {
        self.mesh.regions.iter().any(|region| region.hexahedra == Some(formulation))
    }

    /// Lines of supports, their description, and what they leave out.
    fn support_lines(&self) -> (Vec<String>, String, Vec<String>) {
        let of_step = self.steps.first().map_or(&[][..], |step: &Step| &step.supports);
        let mut held: BTreeMap<NodeNumber, u8> = BTreeMap::new();
        let mut moved = 0;
        let solid = self.mesh.nodes.len() as NodeNumber;
        for support in self.supports.iter().chain(of_step) {
            if support.value != 0.0 {
                moved += 1;
            }
            if support.component < 3 && support.node < solid {
                *held.entry(support.node).or_default() |= 1 << support.component;
            }
        }
        let mut by_components: BTreeMap<u8, Vec<u32>> = BTreeMap::new();
        for (node, components) in held {
            by_components.entry(components).or_default().push(node);
        }
        let (mut lines, mut words) = (Vec::new(), Vec::new());
        for (components, nodes) in by_components.into_iter().rev() {
            let group = self.mesh.node_groups.iter().find(|(_, members)| **members == nodes);
            let on = match group {
                Some((name, _)) => format!("{{ group = {name:?} }}"),
                None => {
                    let ids: Vec<String> = nodes.iter().map(|&node| self.id(node).to_string()).collect();
                    format!("{{ nodes = [{}] }}", ids.join(", "))
                }
            };
            let axes: Vec<&str> = ["x", "y", "z"]
                .into_iter()
                .enumerate()
                .filter(|(c, _)| components >> c & 1 == 1)
                .map(|x| x.1)
                .collect();
            let along = axes.join(", ");
            let quoted: Vec<String> = axes.iter().map(|axis| format!("\"{axis}\"")).collect();
            lines.push(match axes.len() {
                3 => on,
                _ => format!("{on}\ncomponents = [{}]", quoted.join(", ")),
            });
            let place =
                group.map_or_else(|| format!("{} nodes", nodes.len()), |(name, _)| format!("`{name}`"));
            words.push(format!("{place} along {along}"));
        }
        let words = if words.is_empty() { "nothing: a free body".into() } else { words.join("; ") };
        let missing =
            if moved > 0 { vec![format!("{moved} given displacements, held at zero")] } else { vec![] };
        (lines, words, missing)
    }
}
