//! From a deck to the parts of a problem file: materials and supports in SI units.

use std::collections::BTreeMap;
use std::fmt::Write;

use vademecum_build::fem::{Elasticity, Material, Stiffness};
use vademecum_build::mesh::{ElementKind, Hexahedra};

use crate::deck::{Damping, Deck, Dynamic, Harmonic, Load, NodeNumber, Step, StepKind};
use crate::error::DeckError;
use crate::heat;
use crate::tables::Tables;
use crate::units::System;

/// Nodes that get probes.
const PROBED: usize = 20;

/// Directions of probes.
const AXES: [(&str, [f64; 3]); 3] = [("x", [1.0, 0.0, 0.0]), ("y", [0.0, 1.0, 0.0]), ("z", [0.0, 0.0, 1.0])];

/// Parts of a problem file that a deck gives.
#[derive(Clone, Debug)]
pub struct ProblemParts {
    /// Metres in a unit of the deck.
    pub scale: f64,
    /// True if the numbers stay in units of the deck.
    pub own_units: bool,
    /// Tables of materials.
    pub materials: String,
    /// Tables of reference points, couplings, ties, masses and springs.
    pub attachments: String,
    /// Tables of load patterns.
    pub patterns: String,
    /// Lines of the damping.
    pub damping: Option<String>,
    /// Frequency range \[Hz\], load pattern and probes of the first answer to harmonic loads.
    pub frequency_response: Option<FrequencyResponse>,
    /// Scenario of the first motion over time.
    pub scenario: Option<String>,
    /// Time step of that motion \[s\].
    pub time_step: Option<f64>,
    /// Number of modes that the deck asks for before a sum of modes.
    pub modes: Option<usize>,
    /// Tables of probes at nodes whose displacements the deck prints.
    pub probes: String,
    /// Names of the materials' origin, for a person.
    pub material_words: String,
    /// Selections and components of each support, as lines of a problem file.
    pub supports: Vec<String>,
    /// The same for a person.
    pub support_words: String,
    /// Parts of the deck that a problem file does not hold.
    pub missing: Vec<String>,
}

/// A frequency response that a deck asks for.
#[derive(Clone, Debug)]
pub struct FrequencyResponse {
    /// First and last frequency \[Hz\].
    pub range: [f64; 2],
    /// The load pattern.
    pub pattern: String,
    /// Probes.
    pub probes: Vec<String>,
}

/// Tables without the units at the ends of their lines. What is quoted ends in a quotation mark.
fn without_units(text: &str) -> String {
    let bare = |line: &str| match line.rsplit_once(" # ") {
        Some((bare, unit)) if !unit.contains('"') => format!("{bare}\n"),
        _ => format!("{line}\n"),
    };
    text.lines().map(bare).collect()
}

impl Deck {
    /// Materials and supports in SI units; a density where the deck has none, in kg/m³.
    ///
    /// # Errors
    /// [`DeckError::UnknownUnits`], [`DeckError::Incomplete`] without a density.
    pub fn problem_parts(&self, density: Option<f64>) -> Result<ProblemParts, DeckError> {
        let system = self.units.system.ok_or_else(|| DeckError::UnknownUnits { file: self.file.clone() })?;
        let [metre, pascal, kilogram] = system.factors();
        if let Some(turning) = self.cylinders.iter().position(Option::is_some) {
            return Err(DeckError::TurningAxes { region: self.mesh.regions[turning].name.clone() });
        }
        let mut materials = String::new();
        let single = self.materials.len() == 1;
        let is_hexahedron =
            |kind: &ElementKind| matches!(kind, ElementKind::Hex8 | ElementKind::Hex20 | ElementKind::Hex27);
        let hexahedra = self.mesh.each().any(|(kind, _)| is_hexahedron(&kind));
        for (index, (region, material)) in self.mesh.regions.iter().zip(&self.materials).enumerate() {
            let Material { elasticity, density: own } = *material;
            // A density in kg/m³ is none in unknown units.
            let other = density.filter(|_| system != System::Own);
            let density = if own > 0.0 { Some(own * kilogram) } else { other };
            let density = density.ok_or_else(|| DeckError::Incomplete {
                material: region.name.clone(),
                quantity: "density",
                card: "*DENSITY (RHO of MAT1, DENS), or `--material NAME`, whose density is then taken,",
            })?;
            materials += "[[material]]\n";
            if !single {
                let _ = writeln!(materials, "region = {:?}", region.name);
            }
            match elasticity {
                Elasticity::Isotropic { young, poisson } => {
                    let young = young * pascal;
                    let _ = writeln!(materials, "young = {young:e} # Pa\npoisson = {poisson:?}");
                }
                Elasticity::Anisotropic(Stiffness(c)) => {
                    let rows = (0..6).map(|i| {
                        let row: Vec<String> = (i..6).map(|j| format!("{:e}", pascal * c[i][j])).collect();
                        format!("    {},\n", row.join(", "))
                    });
                    let rows: String = rows.collect();
                    let _ = writeln!(materials, "stiffness = [ # Pa, upper triangle\n{rows}]");
                }
            }
            let _ = writeln!(materials, "density = {density:?} # kg/m³");
            materials += &heat::expansion(self, index);
            if let Some(formulation) = region.hexahedra.filter(|_| hexahedra) {
                let name = match formulation {
                    Hexahedra::Incompatible => "incompatible",
                    Hexahedra::MeanDilatation => "mean-dilatation",
                    Hexahedra::Full => "full",
                    Hexahedra::Reduced => "reduced",
                    Hexahedra::ReducedMass => "reduced-mass",
                };
                let _ = writeln!(materials, "hexahedra = \"{name}\"");
            }
            materials.push('\n');
        }
        let (supports, support_words, given) = self.support_lines();
        let mut missing = given;
        let tables = Tables::of(self, system);
        missing.extend(tables.missing());
        missing.extend(heat::missing(self));
        if self.lumped.contains(&true) {
            missing.push("the lumped mass of linear elements: bodies have a consistent one".into());
        }
        if !hexahedra && self.has_kind(Hexahedra::ReducedMass) {
            missing.push("the mass of tetrahedra by one point or four: bodies integrate it exactly".into());
        }
        if self.of_calculix && self.has_kind(Hexahedra::Incompatible) {
            missing.push("the mass of incompatible modes: bodies eliminate them".into());
        }
        let in_units = |text: &str| if system == System::Own { without_units(text) } else { text.into() };
        let names: Vec<&str> = self.mesh.regions.iter().map(|region| region.name.as_str()).collect();
        Ok(ProblemParts {
            scale: metre,
            own_units: system == System::Own,
            attachments: in_units(tables.text()),
            patterns: in_units(tables.patterns()),
            damping: self.damping_lines().map(|lines| in_units(&lines)),
            frequency_response: self.frequency_response(&tables),
            scenario: tables.scenario().map(str::to_string),
            time_step: self.dynamic().map(|dynamic| dynamic.increment),
            modes: self.modes_of_sum(),
            probes: self.probe_tables(metre, &tables),
            materials: in_units(&materials),
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

    /// The first motion over time.
    pub(crate) fn dynamic(&self) -> Option<&Dynamic> {
        self.steps.iter().find_map(|step| match &step.kind {
            StepKind::Dynamic(dynamic) => Some(dynamic),
            _ => None,
        })
    }

    /// The first answer to harmonic loads.
    pub(crate) fn harmonic(&self) -> Option<&Harmonic> {
        self.steps.iter().find_map(|step| match &step.kind {
            StepKind::Harmonic(harmonic) => Some(harmonic),
            _ => None,
        })
    }

    /// Number of modes of the frequency step before a sum of modes.
    fn modes_of_sum(&self) -> Option<usize> {
        let count = self.steps.iter().find_map(|step| match step.kind {
            StepKind::Frequency(count) => count,
            _ => None,
        });
        let of_modes = self.dynamic().map_or(self.harmonic().is_some(), |dynamic| dynamic.modal);
        count.filter(|_| of_modes)
    }

    /// Lines of the damping; none where the deck has none.
    fn damping_lines(&self) -> Option<String> {
        let Damping { alpha, beta, ratios } = &self.damping;
        // The last ratio of a problem file holds for all further modes.
        let mut ratios = ratios.clone();
        if !ratios.is_empty() {
            let modes = self.modes_of_sum().unwrap_or(ratios.len() + 1);
            ratios.push(0.0);
            ratios.truncate(modes);
        }
        let mut text = String::new();
        if *alpha > 0.0 {
            let _ = writeln!(text, "alpha = {alpha:?} # 1/s");
        }
        if *beta > 0.0 {
            let _ = writeln!(text, "beta = {beta:?} # s");
        }
        match ratios[..] {
            [] => {}
            [ratio] => {
                let _ = writeln!(text, "ratio = {ratio:?}");
            }
            _ => {
                let _ = writeln!(text, "modal = {ratios:?}");
            }
        }
        (!text.is_empty()).then_some(text)
    }

    /// The first answer to harmonic loads, as a request.
    fn frequency_response(&self, tables: &Tables<'_>) -> Option<FrequencyResponse> {
        let (range, pattern) = (self.harmonic()?.range, tables.harmonic()?.to_string());
        let nodes = self.probed(tables).into_iter();
        let probes = nodes.flat_map(|node| AXES.map(|(axis, _)| self.probe(node, axis))).collect();
        Some(FrequencyResponse { range, pattern, probes })
    }

    /// Nodes whose displacements are printed, each once.
    fn probed(&self, tables: &Tables<'_>) -> Vec<NodeNumber> {
        let of_harmonic = || self.harmonic().map(|harmonic| &harmonic.printed);
        let printed = self.dynamic().map(|dynamic| &dynamic.printed).or_else(of_harmonic);
        let mut nodes: Vec<NodeNumber> = Vec::new();
        for &node in printed.into_iter().flatten() {
            let moves = (node as usize) < self.mesh.nodes.len() || tables.has_point(node);
            if moves && nodes.len() < PROBED && !nodes.contains(&node) {
                nodes.push(node);
            }
        }
        nodes
    }

    /// Name of a probe.
    fn probe(&self, node: NodeNumber, axis: &str) -> String {
        format!("N{}.{axis}", self.id(node))
    }

    /// Probes along the three axes at nodes whose displacements are printed.
    fn probe_tables(&self, metre: f64, tables: &Tables<'_>) -> String {
        let mut text = String::new();
        for node in self.probed(tables) {
            let at = self.place(node).map(|x| metre * x);
            for (axis, direction) in AXES {
                let name = self.probe(node, axis);
                let _ = write!(
                    text,
                    "\n[[output.probe]]\nname = {name:?}\npoint = {at:?}\ndirection = {direction:?}\n"
                );
            }
        }
        text
    }

    /// The group that has these nodes of the mesh, ascending, and no others.
    fn group_of(&self, nodes: &[NodeNumber]) -> Option<&str> {
        self.mesh.node_groups.iter().find(|(_, members)| **members == nodes).map(|(name, _)| name.as_str())
    }

    /// A selection of these nodes of the mesh, ascending: their group, else their numbers.
    pub(crate) fn selection(&self, nodes: &[NodeNumber]) -> String {
        if let Some(name) = self.group_of(nodes) {
            return format!("{{ group = {name:?} }}");
        }
        let ids: Vec<String> = nodes.iter().map(|&node| self.id(node).to_string()).collect();
        format!("{{ nodes = [{}] }}", ids.join(", "))
    }

    /// Components along the axes of space of a component of a node: its own, or those of its own axes.
    pub(crate) fn along(&self, node: NodeNumber, component: u8) -> Vec<(u8, f64)> {
        match self.axes.get(&node).filter(|_| component < 3) {
            Some(axes) => {
                let axis = axes[usize::from(component)];
                // A direction of space, but for rounding.
                let share =
                    |c: u8| if axis[usize::from(c)].abs() < 1e-12 { 0.0 } else { axis[usize::from(c)] };
                (0..3).map(|c| (c, share(c))).filter(|term| term.1 != 0.0).collect()
            }
            None => vec![(component, 1.0)],
        }
    }

    /// Rotations of reference nodes are along the axes of space.
    ///
    /// # Errors
    /// [`DeckError::OwnRotations`]: some of the rotations are held, or a moment acts, along own axes.
    pub(crate) fn check_rotations(&self) -> Result<(), DeckError> {
        let solid = self.mesh.nodes.len() as NodeNumber;
        let own = |node: NodeNumber| node >= solid && (0..3).any(|c| self.along(node, c) != [(c, 1.0)]);
        let mut held: BTreeMap<NodeNumber, u8> = BTreeMap::new();
        let of_steps = self.steps.iter().flat_map(|step| &step.supports);
        for support in self.supports.iter().chain(of_steps) {
            if support.component >= 3 && own(support.node) {
                *held.entry(support.node).or_default() |= 1 << support.component;
            }
        }
        // All three are held whatever the axes are.
        let some = held.into_iter().find(|(_, components)| *components != 0b111_000);
        let moments = self.steps.iter().flat_map(|step| &step.loads).find_map(|load| match load {
            Load::Force { node, component: 3.., value } if *value != 0.0 && own(*node) => Some(*node),
            _ => None,
        });
        match some.map(|(node, _)| node).or(moments) {
            Some(node) => Err(DeckError::OwnRotations { node: self.id(node) }),
            None => Ok(()),
        }
    }

    /// Nodes of the mesh, with directions that are held and are none of space.
    pub(crate) fn skew_supports(&self) -> BTreeMap<NodeNumber, Vec<[f64; 3]>> {
        self.held()
            .into_iter()
            .filter(|(_, held)| !held.1.is_empty())
            .map(|(node, held)| (node, held.1))
            .collect()
    }

    /// Components of space that are held, as bits, and other directions, of each node of the mesh.
    fn held(&self) -> BTreeMap<NodeNumber, (u8, Vec<[f64; 3]>)> {
        let of_step = self.steps.first().map_or(&[][..], |step: &Step| &step.supports);
        let solid = self.mesh.nodes.len() as NodeNumber;
        let mut own: BTreeMap<NodeNumber, u8> = BTreeMap::new();
        for support in self.supports.iter().chain(of_step) {
            if support.component < 3 && support.node < solid {
                *own.entry(support.node).or_default() |= 1 << support.component;
            }
        }
        let mut held: BTreeMap<NodeNumber, (u8, Vec<[f64; 3]>)> = BTreeMap::new();
        for (node, components) in own {
            let (plain, skew) = held.entry(node).or_default();
            // All three directions are those of space, whatever the axes.
            if components == 0b111 || !self.axes.contains_key(&node) {
                *plain |= components;
                continue;
            }
            for component in (0..3).filter(|c| components >> c & 1 == 1) {
                match self.along(node, component)[..] {
                    [(c, _)] => *plain |= 1 << c,
                    _ => skew.push(self.axes[&node][usize::from(component)]),
                }
            }
        }
        held
    }

    /// Lines of supports, their description, and what they leave out.
    fn support_lines(&self) -> (Vec<String>, String, Vec<String>) {
        let of_step = self.steps.first().map_or(&[][..], |step: &Step| &step.supports);
        let moved = self.supports.iter().chain(of_step).filter(|support| support.value != 0.0).count();
        let held = self.held();
        let skew = held.values().filter(|held| !held.1.is_empty()).count();
        let mut by_components: BTreeMap<u8, Vec<u32>> = BTreeMap::new();
        for (node, (components, _)) in held {
            if components != 0 {
                by_components.entry(components).or_default().push(node);
            }
        }
        let (mut lines, mut words) = (Vec::new(), Vec::new());
        for (components, nodes) in by_components.into_iter().rev() {
            let (group, on) = (self.group_of(&nodes), self.selection(&nodes));
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
            let place = group.map_or_else(|| format!("{} nodes", nodes.len()), |name| format!("`{name}`"));
            words.push(format!("{place} along {along}"));
        }
        if skew > 0 {
            words.push(format!("{skew} nodes along own axes"));
        }
        let words = if words.is_empty() { "nothing: a free body".into() } else { words.join("; ") };
        let missing =
            if moved > 0 { vec![format!("{moved} given displacements, held at zero")] } else { vec![] };
        (lines, words, missing)
    }
}
