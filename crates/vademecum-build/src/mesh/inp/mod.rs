//! Abaqus and CalculiX decks: what their keywords mean for a mesh.
//!
//! Keywords that say nothing about nodes, elements or sets are passed over. Keywords that would change the
//! mesh and are not supported are refused by name. Names are compared without regard to case, as both
//! programs do.

mod assembly;
mod contents;
mod deck;
mod dialect;
mod model;
mod sets;
mod sets_of_deck;
mod surfaces;

use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::rc::Rc;

pub use self::contents::{InpContents, InpElement};
use self::deck::cards;
pub use self::deck::{DataLine, InpCard, LineLocation};
pub use self::dialect::Dialect;
use self::model::{Deck, Element};
use self::sets::{Family, Sets};
use crate::mesh::degenerate::{collapsed, note, repeated_name, repeats_corner};
use crate::mesh::error::{MeshError, shown};
use crate::mesh::load::load;
use crate::mesh::raw::{CellKind, NodeIndex, RawMesh};
use crate::mesh::text::ParsedNumber;
use crate::mesh::{ElementKind, FacetKind, Hexahedra};

/// Keywords that make or move nodes or elements in ways that are not supported.
const REFUSED: [&str; 9] =
    ["NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM", "IMPORT", "SYMMETRIC MODEL GENERATION"];

/// Reads the mesh of a deck.
pub(crate) fn parse(file: &Path, bytes: &[u8]) -> Result<RawMesh, MeshError> {
    Ok(parse_contents(file, bytes, None)?.0)
}

/// Reads the mesh of a deck, and what else the deck says; in the dialect of this program, or of the one that
/// its cards tell.
///
/// # Errors
/// [`MeshError`] if the file cannot be read or breaks the rules of its format.
pub fn read_contents(file: &Path, dialect: Option<Dialect>) -> Result<(RawMesh, InpContents), MeshError> {
    parse_contents(file, &load(file)?, dialect)
}

fn parse_contents(
    file: &Path,
    bytes: &[u8],
    dialect: Option<Dialect>,
) -> Result<(RawMesh, InpContents), MeshError> {
    let mut deck = Deck {
        raw: RawMesh::new(file, "Abaqus/CalculiX .inp"),
        index: NodeIndex::default(),
        elements: Vec::new(),
        element_index: HashMap::new(),
        collapsed: 0,
        node_sets: Sets::default(),
        element_sets: Sets::default(),
        sections: Vec::new(),
        surfaces: Vec::new(),
        instances: Vec::new(),
        in_assembly: false,
        part: String::new(),
        part_with_nodes: None,
        dialect: Dialect::CalculiX,
    };
    let cards = cards(file, bytes)?;
    let of_abaqus = ["PART", "INSTANCE", "ASSEMBLY"];
    let abaqus = cards.iter().any(|card| of_abaqus.contains(&card.keyword.as_str()));
    let (mut cards, notes) = assembly::flatten(cards)?;
    deck.raw.notes.extend(notes);
    deck.dialect = dialect.unwrap_or(if abaqus { Dialect::Abaqus } else { Dialect::CalculiX });
    // Elements may name nodes that follow them.
    let first_element = cards.iter().position(|card| card.keyword == "ELEMENT").unwrap_or(cards.len());
    if !abaqus && cards[first_element..].iter().any(|card| card.keyword == "NODE") {
        for card in cards.iter_mut().filter(|card| card.keyword == "NODE") {
            deck.card(card)?;
            (card.data, card.parameters) = (vec![], vec![]);
        }
    }
    let mut waiting = Vec::new();
    for (index, card) in cards.iter_mut().enumerate() {
        match deck.card(card) {
            // A set may name one that is defined further down.
            Err(error) if matches!(card.keyword.as_str(), "NSET" | "ELSET") => {
                waiting.push((index, deck.in_assembly, error));
            }
            other => other?,
        }
        if matches!(card.keyword.as_str(), "NODE" | "ELEMENT") {
            card.data = Vec::new();
        }
    }
    while !waiting.is_empty() {
        let before = waiting.len();
        let mut left = Vec::new();
        for (index, in_assembly, _) in waiting {
            deck.in_assembly = in_assembly;
            if let Err(error) = deck.card(&cards[index]) {
                left.push((index, in_assembly, error));
            }
        }
        if left.len() == before {
            return Err(left.swap_remove(0).2);
        }
        waiting = left;
    }
    let contents = InpContents::of(&deck, cards);
    Ok((deck.finish()?, contents))
}

impl Deck {
    fn card(&mut self, card: &InpCard) -> Result<(), MeshError> {
        let section = card.section();
        let name = |key: &str| card.parameter(key).unwrap_or("").to_string();
        match card.keyword.as_str() {
            "NODE" => self.nodes(card),
            "ELEMENT" => self.read_elements(card),
            "NSET" => self.node_set(card),
            "ELSET" => self.element_set(card),
            "SOLID SECTION" => {
                self.sections.push((name("ELSET"), card.place.clone()));
                Ok(())
            }
            "SURFACE" => self.surface(card),
            "PART" => {
                self.part = name("NAME");
                Ok(())
            }
            "END PART" | "END INSTANCE" | "END ASSEMBLY" => {
                self.part.clear();
                self.in_assembly = card.keyword == "END INSTANCE";
                Ok(())
            }
            "ASSEMBLY" => {
                self.in_assembly = true;
                Ok(())
            }
            "INSTANCE" => self.instance(card),
            keyword if REFUSED.contains(&keyword) => {
                let remedy = "write the deck with every node and element spelled out";
                Err(card.place.at(&section).unsupported(
                    section.clone(),
                    "explicit *NODE and *ELEMENT data",
                    remedy,
                ))
            }
            _ => Ok(()),
        }
    }

    fn instance(&mut self, card: &InpCard) -> Result<(), MeshError> {
        self.in_assembly = false;
        self.instances.push(card.parameter("NAME").unwrap_or("").to_string());
        self.part = card.parameter("PART").unwrap_or("").to_string();
        let remedy = "export one part, with its coordinates where they belong";
        if self.instances.len() > 1 {
            let found = format!("a second instance `{}`", self.instances[1]);
            return Err(card.place.at("*INSTANCE").unsupported(found, "one instance", remedy));
        }
        for line in &card.data {
            if line.fields().iter().any(|f| f64::parse(f.as_bytes()) != Some(0.0)) {
                let found = format!("a translation or rotation ({})", line.text);
                return Err(line.place.at("*INSTANCE").unsupported(
                    found,
                    "an instance at the origin",
                    remedy,
                ));
            }
        }
        Ok(())
    }

    fn nodes(&mut self, card: &InpCard) -> Result<(), MeshError> {
        const EXPECTED: &str = "a node: number, x, y, z";
        if card.parameter("SYSTEM").is_some_and(|s| !s.eq_ignore_ascii_case("R")) {
            let remedy = "write rectangular coordinates";
            return Err(card.place.at("*NODE").unsupported(
                "SYSTEM other than R",
                "rectangular coordinates",
                remedy,
            ));
        }
        let owner = self.part_with_nodes.get_or_insert_with(|| self.part.clone());
        if !owner.eq_ignore_ascii_case(&self.part) {
            let found = format!("nodes of a second part `{}` beside `{owner}`", self.part);
            return Err(card.place.at("*NODE").unsupported(found, "one part with a mesh", "export one part"));
        }
        let mut members = Vec::with_capacity(card.data.len());
        for line in &card.data {
            let at = line.place.at("*NODE");
            let fault = || at.malformed(shown(line.text.as_bytes()), EXPECTED);
            let fields = line.fields();
            // Coordinates left out are zero; up to three direction cosines may follow.
            if !(1..=7).contains(&fields.len()) {
                return Err(fault());
            }
            let id = u64::parse(fields[0].as_bytes()).ok_or_else(fault)?;
            let mut point = [0.0; 3];
            for (x, field) in point.iter_mut().zip(&fields[1..]).filter(|(_, f)| !f.is_empty()) {
                *x = f64::parse(field.as_bytes()).ok_or_else(fault)?;
            }
            self.index.insert(id, self.raw.nodes.len(), &at)?;
            members.push(self.raw.nodes.len());
            self.raw.nodes.push(point);
            self.raw.node_ids.push(id);
        }
        if let Some(name) = card.parameter("NSET") {
            self.node_sets.add(name, members, Family::Creation, self.in_assembly);
        }
        Ok(())
    }

    fn read_elements(&mut self, card: &InpCard) -> Result<(), MeshError> {
        let name = card.parameter("TYPE").unwrap_or("").to_ascii_uppercase();
        let kind = element_kind(&name).ok_or_else(|| {
            let remedy = "mesh with solid elements, and leave others out of the deck";
            let found = format!("{} lines of element type `{name}`", card.data.len());
            card.place.at("*ELEMENT").unsupported(
                found,
                "C3D4, C3D10, C3D5, C3D6, C3D15, C3D8, C3D20 or C3D27 (surface elements may name groups)",
                remedy,
            )
        })?;
        if let CellKind::Solid(solid) = kind
            && !PLAIN.contains(&name.as_str())
        {
            let note = format!("elements of type {name} are taken as plain elements ({})", solid.name());
            if !self.raw.notes.contains(&note) {
                self.raw.notes.push(note);
            }
        }
        if attachment(&name).is_some() {
            let note = format!("{} elements of type {name} are no part of the mesh", card.data.len());
            self.raw.notes.push(note);
        }
        let hexahedra = formulation(&name, self.dialect);
        let type_name: Rc<str> = name.as_str().into();
        let mut members = Vec::new();
        let mut numbers: Vec<u64> = Vec::new();
        for line in &card.data {
            let at = line.place.at("*ELEMENT");
            let expected = format!("an element of type {name}: number and {} nodes", kind.node_count());
            for field in line.fields() {
                let number = u64::parse(field.as_bytes());
                numbers
                    .push(number.ok_or_else(|| at.malformed(shown(line.text.as_bytes()), expected.clone()))?);
            }
            // CalculiX passes over what follows the nodes, such as those that it adds to C3D8I itself.
            if numbers.len() > 1 + kind.node_count() && self.dialect == Dialect::CalculiX {
                numbers.truncate(1 + kind.node_count());
                let note = format!("numbers behind the nodes of elements of type {name} are passed over");
                if name != "C3D8I" && !self.raw.notes.contains(&note) {
                    self.raw.notes.push(note);
                }
            }
            if numbers.len() > 1 + kind.node_count() {
                return Err(at.malformed(format!("{} numbers", numbers.len()), expected));
            }
            // An element may go on over several lines.
            if numbers.len() == 1 + kind.node_count() {
                members.push(self.element((kind, &type_name, hexahedra), &numbers, &line.place)?);
                numbers.clear();
            }
        }
        if let (false, Some(line)) = (numbers.is_empty(), card.data.last()) {
            let expected = format!("number and {} nodes", kind.node_count());
            return Err(line.place.at("*ELEMENT").malformed(format!("{} numbers", numbers.len()), expected));
        }
        if let Some(name) = card.parameter("ELSET") {
            self.element_sets.add(name, members, Family::Creation, self.in_assembly);
        }
        Ok(())
    }

    fn element(
        &mut self,
        (kind, name, hexahedra): (CellKind, &Rc<str>, Option<Hexahedra>),
        numbers: &[u64],
        place: &LineLocation,
    ) -> Result<usize, MeshError> {
        let at = place.at("*ELEMENT");
        let nodes: Result<Vec<u32>, MeshError> =
            numbers[1..].iter().map(|&id| self.index.find(id, &at)).collect();
        let index = self.elements.len();
        if self.element_index.insert(numbers[0], index).is_some() {
            return Err(at.malformed(format!("element {} a second time", numbers[0]), "every number once"));
        }
        let mut nodes = nodes?;
        if kind == CellKind::Solid(ElementKind::Hex27) {
            order_hex27(&mut nodes);
        }
        let (id, name, place) = (numbers[0], name.clone(), place.clone());
        let mut element = Element { id, name, kind, hexahedra, nodes, written: None, place };
        if let CellKind::Solid(solid) = kind
            && repeats_corner(solid, &element.nodes)
        {
            match collapsed(solid, &element.nodes) {
                Some((simpler, left)) => {
                    let written = std::mem::replace(&mut element.nodes, left);
                    element.kind = CellKind::Solid(simpler);
                    element.written = Some(Box::new((solid, written)));
                    self.collapsed += 1;
                }
                None => element.kind = CellKind::OtherVolume(repeated_name(solid), element.nodes.len()),
            }
        }
        self.elements.push(element);
        Ok(index)
    }

    fn surface(&mut self, card: &InpCard) -> Result<(), MeshError> {
        let kind = card.parameter("TYPE").unwrap_or("ELEMENT").to_ascii_uppercase();
        let name = card.parameter("NAME").unwrap_or("").to_string();
        match kind.as_str() {
            "ELEMENT" => self.surfaces.push((name, card.data.clone())),
            "NODE" => {
                let members = self.node_members(&card.data, "*SURFACE")?;
                self.node_sets.add(&name, members, Family::Explicit, self.in_assembly);
            }
            // Analytical surfaces and the like have no nodes.
            _ => self.raw.notes.push(format!("surface `{name}` of type {kind} is ignored")),
        }
        Ok(())
    }

    /// Removes the name of the instance in front of a set or number.
    pub(crate) fn strip_instance<'t>(&self, text: &'t str) -> &'t str {
        match text.split_once('.') {
            Some((instance, rest)) if self.instances.iter().any(|i| i.eq_ignore_ascii_case(instance)) => rest,
            _ => text,
        }
    }

    /// Element sets, surfaces and sections become regions and groups.
    fn finish(mut self) -> Result<RawMesh, MeshError> {
        let regions = self.regions()?;
        let mut names: BTreeMap<String, i64> = BTreeMap::new();
        let tag_of = |names: &mut BTreeMap<String, i64>, name: String| {
            let next = names.len() as i64 + 1;
            *names.entry(name).or_insert(next)
        };
        for (element, region) in self.elements.iter().zip(&regions) {
            let mut tag = region.as_ref().map_or(0, |name| tag_of(&mut names, name.clone()));
            if let Some(named) = element.hexahedra
                && *self.raw.hexahedra.entry(tag).or_insert(named) != named
            {
                // Hexahedra of another formulation than the first ones are a region of their own.
                let whole = region.as_deref().unwrap_or("body");
                tag = tag_of(&mut names, format!("{whole} {}", element.name));
                self.raw.hexahedra.insert(tag, named);
            }
            let tags = if element.kind.dimension() == 3 { &[tag][..] } else { &[][..] };
            self.raw.push(element.kind, &element.nodes, tags, element.place.place());
        }
        for (name, tag) in names {
            self.raw.region_names.insert(tag, name);
        }
        if self.elements.iter().any(|element| element.kind == CellKind::Solid(ElementKind::Hex8)) {
            let meaning = match self.dialect {
                Dialect::Abaqus => "mean dilatation",
                Dialect::CalculiX => "full integration",
            };
            let note = format!("dialect of {:?}: C3D8 means {meaning}", self.dialect);
            self.raw.notes.push(note);
        }
        if self.collapsed > 0 {
            self.raw.notes.push(note(self.collapsed));
        }
        self.raw.names.insert((3, 0), "body".into());
        self.groups();
        self.surface_groups()?;
        self.raw.name_regions();
        Ok(self.raw)
    }
}

/// Meaning of the element types of both programs.
fn element_kind(name: &str) -> Option<CellKind> {
    const SURFACES: [(&[&str], CellKind); 4] = [
        (
            &["S3", "S3R", "S3RS", "DS3", "STRI3", "M3D3", "SFM3D3", "R3D3", "CPS3", "CPE3", "CAX3"],
            CellKind::Facet(FacetKind::Tri3),
        ),
        (
            &["S6", "DS6", "STRI65", "M3D6", "SFM3D6", "CPS6", "CPE6", "CAX6"],
            CellKind::Facet(FacetKind::Tri6),
        ),
        (
            &[
                "S4", "S4R", "DS4", "M3D4", "M3D4R", "SFM3D4", "R3D4", "CPS4", "CPS4R", "CPE4", "CPE4R",
                "CAX4", "CAX4R",
            ],
            CellKind::Facet(FacetKind::Quad4),
        ),
        (
            &[
                "S8", "S8R", "DS8", "M3D8", "M3D8R", "SFM3D8", "CPS8", "CPS8R", "CPE8", "CPE8R", "CAX8",
                "CAX8R",
            ],
            CellKind::Facet(FacetKind::Quad8),
        ),
    ];
    const LINES: [(&[&str], CellKind); 2] = [
        (&["T3D2", "B31", "B31R", "B33", "T2D2", "B21"], CellKind::Line(2)),
        (&["T3D3", "B32", "B32R", "T2D3", "B22"], CellKind::Line(3)),
    ];
    if let Some((_, kind)) = SURFACES.iter().chain(&LINES).find(|(names, _)| names.contains(&name)) {
        return Some(*kind);
    }
    if let Some(kind) = attachment(name) {
        return Some(kind);
    }
    // Letters after the node count choose a formulation, not another shape.
    let solid = name.trim_start_matches(['D', 'A', 'Q']).strip_prefix("C3D")?;
    let digits = solid.len() - solid.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    Some(CellKind::Solid(match &solid[..digits] {
        "4" => ElementKind::Tet4,
        "10" => ElementKind::Tet10,
        "5" => ElementKind::Pyramid5,
        "6" => ElementKind::Wedge6,
        "8" => ElementKind::Hex8,
        "15" => ElementKind::Wedge15,
        "20" => ElementKind::Hex20,
        "27" => ElementKind::Hex27,
        _ => return None,
    }))
}

/// Elements that are no part of the mesh: masses, springs, dashpots, reference nodes.
fn attachment(name: &str) -> Option<CellKind> {
    const POINTS: [&str; 5] = ["MASS", "ROTARYI", "SPRING1", "DASHPOT1", "DCOUP3D"];
    const LINES: [&str; 6] = ["SPRING2", "SPRINGA", "DASHPOT2", "DASHPOTA", "GAPUNI", "CONN3D2"];
    if POINTS.contains(&name) {
        return Some(CellKind::Point);
    }
    LINES.contains(&name).then_some(CellKind::Line(2))
}

/// Types whose formulation is that of the kernels.
const PLAIN: [&str; 12] =
    ["C3D4", "C3D10", "C3D5", "C3D6", "C3D15", "C3D8", "C3D8I", "C3D8R", "C3D20", "C3D20R", "C3D27", "C3D13"];

/// Formulation of the hexahedra of a type.
fn formulation(name: &str, dialect: Dialect) -> Option<Hexahedra> {
    Some(match name {
        "C3D8I" => Hexahedra::Incompatible,
        "C3D20R" if dialect == Dialect::CalculiX => Hexahedra::ReducedMass,
        "C3D8R" | "C3D20R" => Hexahedra::Reduced,
        "C3D8" if dialect == Dialect::Abaqus => Hexahedra::MeanDilatation,
        "C3D8" | "C3D20" => Hexahedra::Full,
        _ => return None,
    })
}

/// Both programs number the middle of a 27-node hexahedron before those of its faces S1 to S6.
fn order_hex27(nodes: &mut [u32]) {
    const PLACES: [usize; 7] = [26, 24, 23, 25, 21, 22, 20];
    let given = nodes.to_vec();
    nodes[20..].iter_mut().zip(PLACES).for_each(|(node, place)| *node = given[place]);
}
