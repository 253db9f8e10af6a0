//! A Nastran model while its cards are taken.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::path::Path;

use vademecum_build::fem::{Cylinder, Elasticity, Material, Stiffness};
use vademecum_build::mesh::nastran::{Card, Cards, Systems, grid_points, systems};
use vademecum_build::mesh::{Mesh, RawMesh};

use crate::deck::{Deck, NodeNumber, Numbers};
use crate::error::{CardFault, DeckError};
use crate::left_out::{UNDAMPED, leave_out};

/// Cards without a meaning for the result, or taken elsewhere.
const SILENT: [&str; 34] = [
    "GRID", "GRDSET", "CORD1R", "CORD1C", "CORD1S", "CORD2R", "CORD2C", "CORD2S", "CTETRA", "CHEXA",
    "CPENTA", "CPYRAM", "CPYRA", "PSOLID", "MAT1", "PARAM", "ENDDATA", "EIGRL", "EIGR", "SPC", "SPC1",
    "SPCADD", "MPC", "MPCADD", "SET1", "MDLPRM", "PBAR", "PBARL", "PELAS", "PBUSH", "LOAD", "SPOINT",
    "INCLUDE", "PCOMP",
];

/// Solid elements.
const SOLIDS: [&str; 5] = ["CTETRA", "CHEXA", "CPENTA", "CPYRAM", "CPYRA"];

/// Elements that carry loads and are no solids.
const STRUCTURAL: [&str; 22] = [
    "CQUAD4", "CQUAD8", "CQUADR", "CTRIA3", "CTRIA6", "CTRIAR", "CSHEAR", "CROD", "CONROD", "CTUBE", "CBEAM",
    "CBEND", "CBEAM3", "CTRIAX", "CTRIAX6", "CQUADX", "CGAP", "CWELD", "CFAST", "CSEAM", "GENEL", "RROD",
];

/// State of the reading.
pub(crate) struct Model<'a> {
    pub(crate) cards: &'a Cards,
    pub(crate) deck: Deck,
    pub(crate) systems: Systems,
    numbers: Numbers,
    /// Materials by number, those with axes along their own.
    pub(crate) constants: BTreeMap<u64, Material>,
    /// Factor from the density of the deck to mass.
    pub(crate) wtmass: f64,
    /// Names of cards that were taken, beside the silent ones.
    taken: HashSet<&'static str>,
    /// Cards of solid elements by number.
    solids: HashMap<u64, &'a Card>,
}

impl<'a> Model<'a> {
    pub(crate) fn new(file: &Path, raw: &RawMesh, cards: &'a Cards, mesh: Mesh) -> Result<Self, DeckError> {
        let all = raw.node_ids.iter().copied().zip(raw.nodes.iter().copied());
        let (numbers, points) = Numbers::new(&mesh, all);
        let systems = systems(cards)?;
        let mut deck = Deck::new(file, "Nastran", mesh, points);
        for grid in grid_points(cards)? {
            let Some(node) = numbers.get(grid.id) else { continue };
            if let Some(system) = grid.displacements.filter(|system| *system != 0)
                && let Some(axes) = systems.axes(system, deck.place(node))
            {
                deck.axes.insert(node, axes);
            }
            for component in components(&grid.held) {
                deck.supports.push(crate::deck::Support { node, component, value: 0.0 });
            }
        }
        let is_wtmass = |card: &&Card| card.name == "PARAM" && card.field(0).eq_ignore_ascii_case("WTMASS");
        let wtmass = cards.bulk.iter().rfind(is_wtmass);
        let wtmass = wtmass.map(|card| card.real(1)).transpose()?.flatten().unwrap_or(1.0);
        let (constants, taken) = (BTreeMap::new(), HashSet::new());
        let solid = cards.bulk.iter().filter(|card| SOLIDS.contains(&card.name.as_str()));
        let solids = solid.filter_map(|card| Some((card.id(0).ok().flatten()?, card))).collect();
        Ok(Self { cards, deck, systems, numbers, constants, wtmass, taken, solids })
    }

    /// The card of a solid element.
    pub(crate) fn solid(&self, id: u64) -> Option<&'a Card> {
        self.solids.get(&id).copied()
    }

    /// Cards of a name, which are then taken.
    pub(crate) fn named(&mut self, name: &'static str) -> impl Iterator<Item = &'a Card> + use<'a> {
        self.taken.insert(name);
        self.cards.bulk.iter().filter(move |card| card.name == name)
    }

    /// A fault of a card.
    pub(crate) fn fault(&self, card: &Card, found: &str, expected: &str) -> DeckError {
        card.malformed(found, expected).into()
    }

    /// Puts a card on the list of what was not taken.
    pub(crate) fn leave(&mut self, card: &Card, meaning: &str) {
        let place = (card.file.to_path_buf(), card.line);
        leave_out(&mut self.deck.left_out, place, &card.name, meaning);
    }

    /// The node in a field; none for a blank or 0.
    pub(crate) fn node(&self, card: &Card, field: usize) -> Result<Option<NodeNumber>, DeckError> {
        let Some(id) = card.id(field)?.filter(|id| *id != 0) else { return Ok(None) };
        match self.numbers.get(id) {
            Some(node) => Ok(Some(node)),
            None => Err(self.fault(card, &format!("grid point {id}"), "a grid point of the deck")),
        }
    }

    /// The node of a number.
    pub(crate) fn numbered(&self, id: u64) -> Option<NodeNumber> {
        self.numbers.get(id)
    }

    /// A number that a card needs.
    pub(crate) fn needed(&self, card: &Card, field: usize) -> Result<u64, DeckError> {
        card.id(field)?.ok_or_else(|| self.fault(card, &format!("a blank field {}", field + 2), "a number"))
    }

    /// A vector in three fields, along the axes of a system at a place, in space.
    pub(crate) fn vector(
        &self,
        card: &Card,
        first: usize,
        system: u64,
        at: [f64; 3],
    ) -> Result<[f64; 3], DeckError> {
        let Some(axes) = self.systems.axes(system, at) else {
            return Err(self.fault(card, &format!("coordinate system {system}"), "a system of the deck"));
        };
        let mut sum = [0.0; 3];
        for (k, axis) in axes.iter().enumerate() {
            let value = card.real(first + k)?.unwrap_or(0.0);
            (0..3).for_each(|c| sum[c] += value * axis[c]);
        }
        Ok(sum)
    }

    /// Materials of all regions.
    pub(crate) fn materials(&mut self) -> Result<(), DeckError> {
        for card in self.named("MAT1") {
            let number = self.needed(card, 0)?;
            let [young, shear, poisson, density] = [1, 2, 3, 4].map(|field| card.real(field));
            let (young, shear, poisson) = (young?, shear?, poisson?);
            let (young, poisson) = match (young, shear, poisson) {
                (Some(e), _, Some(nu)) => (e, nu),
                (Some(e), Some(g), None) => (e, e / (2.0 * g) - 1.0),
                (None, Some(g), Some(nu)) => (2.0 * g * (1.0 + nu), nu),
                (Some(e), None, None) => (e, 0.0),
                _ => return Err(self.fault(card, "no modulus", "E and NU, E and G, or G and NU")),
            };
            if !(young > 0.0 && poisson > -1.0 && poisson < 0.5) {
                let found = format!("E {young:e}, Poisson's ratio {poisson}");
                return Err(self.fault(card, &found, "E > 0 and a Poisson's ratio between -1 and 0.5"));
            }
            let density = self.wtmass * density?.unwrap_or(0.0);
            self.constants.insert(number, Material::isotropic(young, poisson, density));
        }
        self.anisotropic()?;
        let mut of_property = BTreeMap::new();
        for card in self.named("PSOLID") {
            of_property.insert(self.needed(card, 0)?, (card, self.needed(card, 1)?));
        }
        let (mut materials, mut cylinders) = (vec![], vec![]);
        for region in &self.deck.mesh.regions {
            let found = of_property.get(&(region.tag as u64));
            let found = found.and_then(|&(card, id)| Some((card, *self.constants.get(&id)?)));
            let (card, material) =
                found.ok_or_else(|| DeckError::NoMaterial { region: region.name.clone() })?;
            let (material, cylinder) = self.along_axes(card, material)?;
            materials.push(material);
            cylinders.push(cylinder);
        }
        self.deck.materials = materials;
        self.deck.cylinders = if cylinders.iter().any(Option::is_some) { cylinders } else { vec![] };
        self.deck.lumped = vec![false; self.deck.materials.len()];
        Ok(())
    }

    /// Materials by 21 constants, or by moduli along three axes.
    fn anisotropic(&mut self) -> Result<(), DeckError> {
        for card in self.named("MAT9") {
            let mut constants = [0.0; 21];
            for (k, constant) in constants.iter_mut().enumerate() {
                *constant = card.real(1 + k)?.unwrap_or(0.0);
            }
            self.add_anisotropic(card, Some(Stiffness::from_upper(&constants)), 22)?;
        }
        for card in self.named("MAT11") {
            let three = |from: usize| -> Result<[f64; 3], DeckError> {
                let mut values = [0.0; 3];
                for (k, value) in values.iter_mut().enumerate() {
                    *value = card.real(from + k)?.unwrap_or(0.0);
                }
                Ok(values)
            };
            self.add_anisotropic(card, Stiffness::orthotropic(three(1)?, three(4)?, three(7)?), 10)?;
        }
        Ok(())
    }

    /// Takes a stiffness along the axes of a material; its density is in a field.
    fn add_anisotropic(
        &mut self,
        card: &Card,
        stiffness: Option<Stiffness>,
        density: usize,
    ) -> Result<(), DeckError> {
        let Some(stiffness) = stiffness.filter(Stiffness::is_definite) else {
            return Err(self.fault(card, "a stiffness that is not positive definite", "that of a solid"));
        };
        let density = self.wtmass * card.real(density)?.unwrap_or(0.0);
        let material = Material { elasticity: Elasticity::Anisotropic(stiffness), density };
        self.constants.insert(self.needed(card, 0)?, material);
        Ok(())
    }

    /// The material of a property in space, and the line about which its axes turn.
    fn along_axes(&self, card: &Card, material: Material) -> Result<(Material, Option<Cylinder>), DeckError> {
        let Elasticity::Anisotropic(own) = material.elasticity else { return Ok((material, None)) };
        let text = card.field(2).trim();
        if text.is_empty() || text == "0" {
            return Ok((material, None));
        }
        if let Some((point, axis)) = text.parse().ok().and_then(|system| self.systems.cylinder(system)) {
            return Ok((material, Some(Cylinder { point, axis })));
        }
        let system = text.parse().ok().filter(|&system| self.systems.is_rectangular(system));
        let Some([first, second, _]) = system.and_then(|system| self.systems.axes(system, [0.0; 3])) else {
            let expected = "CORDM of a rectangular or cylindrical system of the deck, or 0";
            return Err(self.fault(card, &format!("CORDM {text}"), expected));
        };
        let elasticity = Elasticity::Anisotropic(own.along([first, second]));
        Ok((Material { elasticity, density: material.density }, None))
    }

    /// Lists the cards that nobody took.
    pub(crate) fn leave_rest(&mut self) {
        let cards = self.cards;
        for card in &cards.bulk {
            let name = card.name.as_str();
            if SILENT.contains(&name) || self.taken.contains(name) {
                continue;
            }
            let meaning = match name {
                _ if name.starts_with("CDAMP") || name == "CVISC" => UNDAMPED,
                _ if name.starts_with("TEMP") => "temperatures other than TEMP and TEMPD are not computed",
                "PLOTEL" => "it is drawn by other programs and carries nothing",
                _ => "it is not known, and has no effect",
            };
            self.leave(card, meaning);
        }
    }
}

/// Digits of directions as components from 0.
pub(crate) fn components(digits: &str) -> impl Iterator<Item = u8> {
    let known = digits.bytes().filter(|b| (b'1'..=b'6').contains(b));
    known.map(|b| b - b'1').collect::<BTreeSet<_>>().into_iter()
}

/// Shells, beams and the like carry loads: a model without them is another one.
pub(crate) fn refuse_structural(cards: &Cards) -> Result<(), DeckError> {
    let solids = cards.bulk.iter().filter(|card| SOLIDS.contains(&card.name.as_str())).count();
    // Bars join reference points of solids.
    let other = |name: &str| STRUCTURAL.contains(&name) || (name == "CBAR" && solids == 0);
    let others = || cards.bulk.iter().filter(|card| other(card.name.as_str()));
    let Some(first) = others().next() else { return Ok(()) };
    let names: BTreeSet<&str> = others().map(|card| card.name.as_str()).collect();
    let names: Vec<&str> = names.into_iter().collect();
    let count = others().count();
    let share = 100.0 * count as f64 / (count + solids) as f64;
    Err(DeckError::Structural(Box::new(CardFault {
        file: first.file.to_path_buf(),
        line: first.line,
        card: first.name.clone(),
        found: format!("{count} elements of type {} ({share:.1} % of all)", names.join(", ")),
        expected: "solid elements, rigid elements, masses, springs, and bars between reference points".into(),
        remedy: "shells, beams and rods are not computed with: mesh these parts with solids, or take them out of the deck"
            .into(),
    })))
}
