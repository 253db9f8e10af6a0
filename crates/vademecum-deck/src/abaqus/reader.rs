//! A deck while its cards are taken: names, numbers, and the model that grows.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::path::Path;

use vademecum_build::mesh::inp::{DataLine, Dialect, InpCard, InpContents, InpElement};
use vademecum_build::mesh::{Hexahedra, Mesh, RawMesh};

use crate::abaqus::solid::{OfRegion, Orientation, Solid};
use crate::deck::{Deck, Extent, Load, NodeNumber, Numbers, Step, StepKind, Support};
use crate::error::{CardFault, DeckError};
use crate::heat;
use crate::left_out::{LeftOut, UNDAMPED, leave_out};

/// Material of an element set.
pub(crate) struct Section {
    pub(crate) set: String,
    pub(crate) material: String,
    /// Name of its axes; empty: those of space.
    pub(crate) orientation: String,
}

/// State of the reading.
pub(crate) struct Reader<'a> {
    pub(crate) contents: &'a InpContents,
    pub(crate) deck: Deck,
    numbers: Numbers,
    /// Index in the mesh of each solid element, by its number.
    solids: HashMap<u64, u32>,
    pub(crate) materials: BTreeMap<String, Solid>,
    /// Material that cards of properties belong to.
    pub(crate) material: Option<String>,
    /// Sections in the order of the deck; the last one of a set holds.
    pub(crate) sections: Vec<Section>,
    /// Axes of materials by name.
    pub(crate) orientations: BTreeMap<String, Orientation>,
    /// Damping proportional to mass and to stiffness, by material.
    pub(crate) dampings: BTreeMap<String, [f64; 2]>,
    /// Points of amplitudes.
    pub(crate) amplitudes: BTreeMap<String, Vec<[f64; 2]>>,
    /// Coupling that the next *KINEMATIC or *DISTRIBUTING completes: reference, surface.
    pub(crate) coupling: Option<(NodeNumber, String)>,
    /// Index of the course that loads follow in a motion over time.
    pub(crate) course: usize,
    /// True between *STEP and *END STEP.
    pub(crate) in_step: bool,
    /// Period of the step.
    pub(crate) period: f64,
    /// True once a step had large displacements.
    pub(crate) nonlinear: bool,
    /// Initial temperatures of the nodes of the mesh, if the deck has temperatures.
    pub(crate) initial: Option<Vec<f64>>,
    /// Loads of the step before, which go on.
    pub(crate) carried: Vec<Load>,
    /// Components of nodes whose force the step gives anew.
    replaced: HashSet<(NodeNumber, u8)>,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(
        file: &Path,
        raw: &RawMesh,
        contents: &'a InpContents,
        mesh: Mesh,
    ) -> Result<Self, DeckError> {
        let all = raw.node_ids.iter().copied().zip(raw.nodes.iter().copied());
        let (numbers, points) = Numbers::new(&mesh, all);
        let mut by_nodes: HashMap<Vec<u32>, u32> = HashMap::new();
        for (index, (_, nodes)) in mesh.each().enumerate() {
            by_nodes.insert(sorted(nodes.to_vec()), index as u32);
        }
        let mut solids = HashMap::new();
        for (&id, element) in contents.elements.iter().filter(|(_, element)| element.kind.is_some()) {
            let nodes: Option<Vec<u32>> = element.nodes.iter().map(|&node| numbers.get(node)).collect();
            if let Some(&index) = nodes.and_then(|nodes| by_nodes.get(&sorted(nodes))) {
                solids.insert(id, index);
            }
        }
        let deck = Deck::new(file, "", mesh, points);
        Ok(Self {
            contents,
            deck,
            numbers,
            solids,
            materials: BTreeMap::new(),
            material: None,
            sections: vec![],
            orientations: BTreeMap::new(),
            dampings: BTreeMap::new(),
            amplitudes: BTreeMap::new(),
            coupling: None,
            course: 0,
            in_step: false,
            period: 1.0,
            nonlinear: false,
            initial: None,
            carried: vec![],
            replaced: HashSet::new(),
        })
    }

    /// A fault at a line of a card.
    pub(crate) fn fault(
        &self,
        card: &InpCard,
        line: Option<&DataLine>,
        found: &str,
        expected: &str,
    ) -> DeckError {
        let place = line.map_or(&card.place, |line| &line.place);
        DeckError::Card(Box::new(CardFault {
            file: place.file().to_path_buf(),
            line: place.line(),
            card: card.section(),
            found: format!("`{}`", found.chars().take(60).collect::<String>().escape_debug()),
            expected: expected.into(),
            remedy: "correct the deck, or take the card out of it".into(),
        }))
    }

    /// Puts a card on the list of what was not taken.
    pub(crate) fn leave(&mut self, card: &InpCard, meaning: &str) {
        let place = (card.place.file().to_path_buf(), card.place.line());
        leave_out(&mut self.deck.left_out, place, &card.section(), meaning);
    }

    /// Puts a card of damping on the list, for answers at full order; a problem file has it.
    pub(crate) fn leave_damping(&mut self, card: &InpCard) {
        self.leave(card, UNDAMPED);
        let own = |left: &&mut LeftOut| left.card == card.section() && left.meaning == UNDAMPED;
        if let Some(left) = self.deck.left_out.iter_mut().find(own) {
            left.in_problem = true;
        }
    }

    /// Number in a field.
    pub(crate) fn real(&self, card: &InpCard, line: &DataLine, field: &str) -> Result<f64, DeckError> {
        let text = field.trim().to_ascii_uppercase().replace('D', "E");
        let number = text.parse::<f64>().ok().filter(|x| x.is_finite());
        number.ok_or_else(|| self.fault(card, Some(line), field, "a number"))
    }

    /// Numbers of all fields of a line; empty ones are zero.
    pub(crate) fn reals(&self, card: &InpCard, line: &DataLine) -> Result<Vec<f64>, DeckError> {
        let field = |f: &&str| if f.is_empty() { Ok(0.0) } else { self.real(card, line, f) };
        line.fields().iter().map(field).collect()
    }

    /// Component of a displacement or a rotation, from 0; none of other degrees of freedom.
    pub(crate) fn component(
        &self,
        card: &InpCard,
        line: &DataLine,
        field: &str,
    ) -> Result<Option<u8>, DeckError> {
        match field.trim().parse::<u32>() {
            Ok(number @ 1..=6) => Ok(Some(number as u8 - 1)),
            Ok(_) => Ok(None),
            Err(_) => Err(self.fault(card, Some(line), field, "a degree of freedom, 1 to 6")),
        }
    }

    /// Nodes of a number or a set.
    pub(crate) fn nodes(
        &self,
        card: &InpCard,
        line: &DataLine,
        field: &str,
    ) -> Result<Vec<NodeNumber>, DeckError> {
        let name = self.contents.plain_name(field);
        if let Some(node) = name.parse().ok().and_then(|id| self.numbers.get(id)) {
            return Ok(vec![node]);
        }
        match self.contents.node_sets.get(&name) {
            Some(ids) => Ok(ids.iter().filter_map(|&id| self.numbers.get(id)).collect()),
            None => Err(self.fault(card, Some(line), field, "a node of the deck, or a node set")),
        }
    }

    /// The node that a parameter names.
    pub(crate) fn node(&self, card: &InpCard, key: &str) -> Result<Option<NodeNumber>, DeckError> {
        let Some(value) = card.parameter(key) else { return Ok(None) };
        let name = self.contents.plain_name(value);
        let of_set = || {
            let ids = self.contents.node_sets.get(&name)?;
            (ids.len() == 1).then(|| self.numbers.get(ids[0])).flatten()
        };
        let node = name.parse().ok().and_then(|id| self.numbers.get(id)).or_else(of_set);
        node.map(Some).ok_or_else(|| self.fault(card, None, value, "a node of the deck, or a set of one"))
    }

    /// Numbers of the elements of a number or a set.
    pub(crate) fn element_ids(
        &self,
        card: &InpCard,
        line: Option<&DataLine>,
        name: &str,
    ) -> Result<Vec<u64>, DeckError> {
        let plain = self.contents.plain_name(name);
        if let Some(id) = plain.parse().ok().filter(|id| self.contents.elements.contains_key(id)) {
            return Ok(vec![id]);
        }
        match self.contents.element_sets.get(&plain) {
            Some(ids) => Ok(ids.clone()),
            None => Err(self.fault(card, line, name, "an element of the deck, or an element set")),
        }
    }

    /// Elements of the set that a parameter names, with their nodes.
    pub(crate) fn elements_of(&self, card: &InpCard) -> Result<Vec<&'a InpElement>, DeckError> {
        let Some(set) = card.parameter("ELSET") else {
            return Err(self.fault(card, None, "no ELSET", "ELSET=set"));
        };
        let ids = self.element_ids(card, None, set)?;
        Ok(ids.iter().filter_map(|id| self.contents.elements.get(id)).collect())
    }

    /// Nodes of an element that is no solid.
    pub(crate) fn ends(&self, element: &InpElement) -> Vec<NodeNumber> {
        element.nodes.iter().filter_map(|&node| self.numbers.get(node)).collect()
    }

    /// Solid elements of a number or a set as a load names them.
    pub(crate) fn extent(&self, card: &InpCard, line: &DataLine, name: &str) -> Result<Extent, DeckError> {
        if name.is_empty() {
            return Ok(Extent::All);
        }
        let ids = self.element_ids(card, Some(line), name)?;
        let solids: BTreeSet<u32> = ids.iter().filter_map(|id| self.solids.get(id)).copied().collect();
        let everything = solids.len() == self.deck.mesh.element_count();
        Ok(if everything { Extent::All } else { Extent::Elements(solids.into_iter().collect()) })
    }

    /// Corners of a face of each element, as decks number faces.
    pub(crate) fn faces(&self, ids: &[u64], face: usize) -> Option<Vec<[u32; 3]>> {
        let corners = |id: &u64| {
            let element = self.contents.elements.get(id)?;
            let (kind, nodes) = match &element.written {
                Some((kind, nodes)) => (*kind, nodes),
                None => (element.kind?, &element.nodes),
            };
            let (facet, places) = kind.faces().get(face)?;
            let mut found: Vec<NodeNumber> = Vec::new();
            for &place in &places[..facet.corners()] {
                let node = self.numbers.get(*nodes.get(place)?)?;
                if !found.contains(&node) {
                    found.push(node);
                }
            }
            found.get(..3)?.try_into().ok()
        };
        ids.iter().map(corners).collect()
    }

    /// Faces of a named surface.
    pub(crate) fn surface(
        &self,
        card: &InpCard,
        line: Option<&DataLine>,
        name: &str,
    ) -> Result<Vec<[u32; 3]>, DeckError> {
        let plain = self.contents.plain_name(name);
        let groups = &self.deck.mesh.facet_groups;
        let found = groups.iter().find(|(known, _)| known.eq_ignore_ascii_case(&plain));
        found
            .map(|(_, faces)| faces.clone())
            .ok_or_else(|| self.fault(card, line, name, "a surface of faces of solid elements"))
    }

    /// Nodes of a named surface, of faces or of nodes.
    pub(crate) fn surface_nodes(
        &self,
        card: &InpCard,
        line: Option<&DataLine>,
        name: &str,
    ) -> Result<Vec<NodeNumber>, DeckError> {
        let plain = self.contents.plain_name(name);
        let groups = &self.deck.mesh.node_groups;
        let found = groups.iter().find(|(known, _)| known.eq_ignore_ascii_case(&plain));
        found
            .map(|(_, nodes)| nodes.clone())
            .ok_or_else(|| self.fault(card, line, name, "a surface, or a node set"))
    }

    /// Supports of the step, or of the model.
    pub(crate) fn supports(&mut self) -> &mut Vec<Support> {
        match self.deck.steps.last_mut().filter(|_| self.in_step) {
            Some(step) => &mut step.supports,
            None => &mut self.deck.supports,
        }
    }

    /// The step that is being read.
    pub(crate) fn step(&mut self) -> Option<&mut Step> {
        self.deck.steps.last_mut().filter(|_| self.in_step)
    }

    /// Nodes of a set.
    pub(crate) fn node_set(&self, name: &str) -> Option<Vec<NodeNumber>> {
        let ids = self.contents.node_sets.get(&self.contents.plain_name(name))?;
        Some(ids.iter().filter_map(|&id| self.numbers.get(id)).collect())
    }

    /// Adds a force to the step. Forces on one component add up; those of the step before are replaced.
    pub(crate) fn force(&mut self, node: NodeNumber, component: u8, value: f64) {
        self.replaced.insert((node, component));
        self.act(Load::Force { node, component, value });
    }

    /// Adds a load to the step; in a motion over time it follows the course of its card.
    pub(crate) fn act(&mut self, load: Load) {
        let course = self.course;
        if let Some(step) = self.step() {
            step.loads.push(load);
            if let StepKind::Dynamic(dynamic) = &mut step.kind {
                dynamic.follows.push(course);
            }
        }
    }

    /// Ends a step: what it carries on from the one before comes first.
    pub(crate) fn end_step(&mut self) {
        let replaced = std::mem::take(&mut self.replaced);
        let stays = |load: &Load| match load {
            Load::Force { node, component, .. } => !replaced.contains(&(*node, *component)),
            _ => true,
        };
        let mut loads: Vec<Load> = std::mem::take(&mut self.carried).into_iter().filter(stays).collect();
        if let Some(step) = self.step() {
            loads.append(&mut step.loads);
            step.loads = loads;
        }
        self.in_step = false;
    }

    /// Materials of the regions, and the dialect in words.
    pub(crate) fn finish(mut self, asked: bool) -> Result<Deck, DeckError> {
        self.end_step();
        if let Some((reference, surface)) = self.coupling.take() {
            let id = self.deck.id(reference);
            let note = format!(
                "the coupling of `{surface}` to node {id} has no *KINEMATIC or *DISTRIBUTING: left out"
            );
            self.deck.notes.push(note);
        }
        let materials = self.region_materials()?;
        let elements = self.contents.elements.values();
        let abaqus = self.contents.dialect == Dialect::Abaqus;
        let linear = elements.filter_map(|element| element.kind).all(|kind| kind.nodes() == kind.corners());
        self.deck.lumped = vec![abaqus && linear; materials.len()];
        self.deck.of_calculix = !abaqus;
        // Regions without hexahedra: both programs give the stiffness of quadratic tetrahedra four points,
        // curved ones too; CalculiX gives their mass the same points, and that of linear ones one.
        let tetrahedra = if abaqus { Hexahedra::Reduced } else { Hexahedra::ReducedMass };
        for region in &mut self.deck.mesh.regions {
            region.hexahedra.get_or_insert(tetrahedra);
        }
        let cylinders: Vec<_> = materials.iter().map(|of| of.cylinder).collect();
        self.deck.cylinders = if cylinders.iter().any(Option::is_some) { cylinders } else { vec![] };
        self.deck.materials = materials.iter().map(|of| of.material).collect();
        let laws = materials.into_iter().map(|of| of.heat).collect();
        heat::take(&mut self.deck, self.initial.take(), laws);
        let reason = if asked { "as asked for" } else { "found from the cards" };
        self.deck.program = format!("{:?} ({reason})", self.contents.dialect);
        Ok(self.deck)
    }

    /// The material of each region.
    fn region_materials(&self) -> Result<Vec<OfRegion>, DeckError> {
        let heated = self.initial.is_some();
        let find = |region: &str| {
            let of_section = |section: &&Section| {
                let plain = self.contents.plain_name(&section.set);
                // The region of a second formulation has the name of its element type behind that of the set.
                let set = region.rsplit_once(" C3D").map_or(region, |(set, _)| set);
                plain.eq_ignore_ascii_case(region)
                    || plain.eq_ignore_ascii_case(set)
                    || region.eq_ignore_ascii_case(&format!("assembly.{plain}"))
            };
            let section = self.sections.iter().rev().find(of_section)?;
            Some((section, self.materials.get(&section.material.to_ascii_uppercase())?))
        };
        let each = self.deck.mesh.regions.iter().map(|region| {
            let (section, solid) =
                find(&region.name).ok_or_else(|| DeckError::NoMaterial { region: region.name.clone() })?;
            let name = section.orientation.as_str();
            let axes = self.orientations.get(&name.to_ascii_uppercase()).copied();
            if axes.is_none() && !name.is_empty() && solid.has_axes(heated) {
                return Err(DeckError::Incomplete {
                    material: section.material.clone(),
                    quantity: "orientation",
                    card: "*ORIENTATION of the name in *SOLID SECTION",
                });
            }
            solid.material(&section.material, axes, heated)
        });
        each.collect()
    }
}

fn sorted(mut nodes: Vec<u32>) -> Vec<u32> {
    nodes.sort_unstable();
    nodes
}

/// Shells, beams and the like carry loads: a model without them is another one. Elements without a section
/// only name surfaces and lines.
pub(crate) fn refuse_structural(contents: &InpContents) -> Result<(), DeckError> {
    let sections = contents.cards.iter().filter(|card| card.keyword.ends_with("SECTION"));
    let sets =
        sections.filter_map(|card| contents.element_sets.get(&contents.plain_name(card.parameter("ELSET")?)));
    let numbers: BTreeSet<u64> = sets.flatten().copied().collect();
    let of_sections = numbers.iter().filter_map(|number| contents.elements.get(number));
    let others = of_sections.filter(|element| {
        let attached = ["MASS", "ROTARYI", "DCOUP3D", "SPRING", "DASHPOT", "CONN3D2"];
        element.kind.is_none() && !attached.iter().any(|name| element.name.starts_with(name))
    });
    let others: Vec<&InpElement> = others.collect();
    let Some(first) = others.iter().min_by_key(|element| element.place.line()) else { return Ok(()) };
    let names: BTreeSet<&str> = others.iter().map(|element| element.name.as_str()).collect();
    let share = 100.0 * others.len() as f64 / contents.elements.len() as f64;
    let names: Vec<&str> = names.into_iter().collect();
    let remedy = "shells, beams, trusses and membranes are not computed with: mesh these parts with solids, or take \
                  them out of the deck";
    Err(DeckError::Structural(Box::new(CardFault {
        file: first.place.file().to_path_buf(),
        line: first.place.line(),
        card: "*ELEMENT".into(),
        found: format!("{} elements of type {} ({share:.1} % of all)", others.len(), names.join(", ")),
        expected: "solid elements, masses, springs and dashpots".into(),
        remedy: remedy.into(),
    })))
}
