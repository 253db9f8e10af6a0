//! Load sets of a Nastran deck.

use std::collections::BTreeMap;

use vademecum_build::mesh::nastran::Card;

use crate::deck::{Extent, Load, NodeNumber};
use crate::error::DeckError;
use crate::nastran::model::Model;

/// Stands for every set.
pub(crate) const ALL: u64 = u64::MAX;

/// Sets that a set joins, with their factors.
type Joined = Vec<(u64, f64)>;

/// Loads by set.
pub(crate) struct Loads {
    sets: BTreeMap<u64, Vec<Load>>,
    joined: BTreeMap<u64, Joined>,
}

impl Loads {
    /// Reads all of them.
    pub(crate) fn read(model: &mut Model<'_>) -> Result<Loads, DeckError> {
        let mut sets: BTreeMap<u64, Vec<Load>> = BTreeMap::new();
        for (name, first) in [("FORCE", 0), ("MOMENT", 3)] {
            for card in model.named(name) {
                let Some(node) = model.node(card, 1)? else {
                    return Err(model.fault(card, "no grid point", "a grid point"));
                };
                let size = card.real(3)?.unwrap_or(0.0);
                let vector = model.vector(card, 4, card.id(2)?.unwrap_or(0), model.deck.place(node))?;
                let loads = at_node(model, node, first, vector.map(|v| size * v));
                sets.entry(model.needed(card, 0)?).or_default().extend(loads);
            }
        }
        for card in model.named("GRAV") {
            let size = card.real(2)?.unwrap_or(0.0);
            let vector = model.vector(card, 3, card.id(1)?.unwrap_or(0), [0.0; 3])?;
            let load = Load::Acceleration { on: Extent::All, value: vector.map(|v| size * v) };
            sets.entry(model.needed(card, 0)?).or_default().push(load);
        }
        for card in model.named("RFORCE") {
            let point = model.node(card, 1)?.map_or([0.0; 3], |node| model.deck.place(node));
            let vector = model.vector(card, 4, card.id(2)?.unwrap_or(0), point)?;
            let length = vector.iter().map(|v| v * v).sum::<f64>().sqrt();
            if length == 0.0 {
                return Err(model.fault(card, "no axis", "an axis of rotation that is not zero"));
            }
            // Revolutions per unit of time.
            let speed = std::f64::consts::TAU * card.real(3)?.unwrap_or(0.0) * length;
            let axis = vector.map(|v| v / length);
            let load = Load::Rotation { on: Extent::All, speed_squared: speed * speed, point, axis };
            sets.entry(model.needed(card, 0)?).or_default().push(load);
        }
        for card in model.named("PLOAD4") {
            if let Some(load) = pressure(model, card)? {
                sets.entry(model.needed(card, 0)?).or_default().push(load);
            }
        }
        let mut joined = BTreeMap::new();
        for card in model.named("LOAD") {
            let whole = card.real(1)?.unwrap_or(1.0);
            let mut parts = Joined::new();
            for first in (2..card.fields.len()).step_by(2) {
                if let (Some(factor), Some(set)) = (card.real(first)?, card.id(first + 1)?) {
                    parts.push((set, whole * factor));
                }
            }
            joined.insert(model.needed(card, 0)?, parts);
        }
        Ok(Loads { sets, joined })
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.sets.is_empty()
    }

    /// Loads of a set; sets that join each other in a circle end.
    pub(crate) fn of(&self, id: u64, factor: f64, depth: usize) -> Vec<Load> {
        if id == ALL {
            return self.sets.values().flatten().cloned().collect();
        }
        let mut loads = scaled(self.sets.get(&id).map_or(&[][..], Vec::as_slice), factor);
        if depth < 8 {
            for &(other, share) in self.joined.get(&id).into_iter().flatten() {
                loads.extend(self.of(other, factor * share, depth + 1));
            }
        }
        loads
    }
}

/// A vector at a node along its axes; `first` is 0 of a force, 3 of a moment.
fn at_node(model: &Model<'_>, node: NodeNumber, first: u8, vector: [f64; 3]) -> Vec<Load> {
    let along = match model.deck.axes.get(&node) {
        Some(axes) if first == 0 => axes.map(|axis| axis.iter().zip(&vector).map(|(a, v)| a * v).sum()),
        _ => vector,
    };
    let one = |c: u8| Load::Force { node, component: first + c, value: along[usize::from(c)] };
    (0..3).map(one).collect()
}

/// A pressure on a face of a solid; none of what is not taken.
fn pressure(model: &mut Model<'_>, card: &Card) -> Result<Option<Load>, DeckError> {
    let element = model.needed(card, 1)?;
    let Some(owner) = model.solid(element) else {
        model.leave(card, "it acts on no solid element");
        return Ok(None);
    };
    let first_size = card.real(2)?.unwrap_or(0.0);
    let mut sizes = [first_size; 4];
    for (k, size) in sizes.iter_mut().enumerate() {
        *size = card.real(2 + k)?.unwrap_or(first_size);
    }
    if sizes.iter().any(|size| *size != sizes[0]) {
        return Err(model.fault(card, "a pressure that differs between corners", "one pressure"));
    }
    let corners: usize = match owner.name.as_str() {
        "CTETRA" => 4,
        "CHEXA" => 8,
        "CPENTA" => 6,
        _ => 5,
    };
    let mut nodes = Vec::new();
    for field in 2..2 + corners {
        nodes.extend(model.node(owner, field)?);
    }
    let Some(first) = model.node(card, 6)? else {
        return Err(model.fault(card, "no G1", "a corner of the face"));
    };
    let second = model.node(card, 7)?;
    let kind = match nodes.len() {
        4 => vademecum_build::mesh::ElementKind::Tet4,
        5 => vademecum_build::mesh::ElementKind::Pyramid5,
        6 => vademecum_build::mesh::ElementKind::Wedge6,
        _ => vademecum_build::mesh::ElementKind::Hex8,
    };
    // The second point is the corner opposite of the first one, and of a tetrahedron the corner off the face.
    let mut faces = kind.faces().iter().filter_map(|(_, places)| {
        places.iter().map(|&place| nodes.get(place).copied()).collect::<Option<Vec<NodeNumber>>>()
    });
    let found = faces.find(|face| {
        let has = |node: NodeNumber| face.contains(&node);
        let second = match (corners, second) {
            (4, Some(second)) => !has(second),
            (_, Some(second)) => has(second) && opposite(face, first, second),
            (_, None) => face.len() == 3,
        };
        has(first) && second
    });
    let Some(face) = found else {
        return Err(model.fault(card, "points of no face", "G1 and G3, or G1 and G4, of the element"));
    };
    let direction = (9..12).map(|field| card.real(field)).collect::<Result<Vec<_>, _>>()?;
    let faces = vec![[face[0], face[1], face[2]]];
    if direction.iter().all(Option::is_none) {
        return Ok(Some(Load::Pressure { faces, value: sizes[0] }));
    }
    let system = card.id(8)?.unwrap_or(0);
    let vector = model.vector(card, 9, system, model.deck.place(face[0]))?;
    let length = vector.iter().map(|v| v * v).sum::<f64>().sqrt();
    if length == 0.0 {
        return Err(model.fault(card, "no direction", "a direction that is not zero"));
    }
    Ok(Some(Load::Traction { faces, value: vector.map(|v| sizes[0] * v / length) }))
}

/// True if two corners of a face are not next to each other; of a triangle, always.
fn opposite(face: &[NodeNumber], first: NodeNumber, second: NodeNumber) -> bool {
    let place = |node| face.iter().position(|other| *other == node);
    match (place(first), place(second)) {
        (Some(a), Some(b)) => face.len() < 4 || (a + 2) % 4 == b,
        _ => false,
    }
}

/// Whole numbers from a field on.
pub(crate) fn numbers(card: &Card, first: usize) -> Result<Vec<u64>, DeckError> {
    let mut found = Vec::new();
    for field in first..card.fields.len() {
        found.extend(card.id(field)?);
    }
    Ok(found)
}

/// Loads that are scaled.
fn scaled(loads: &[Load], factor: f64) -> Vec<Load> {
    let one = |load: &Load| match load.clone() {
        Load::Force { node, component, value } => Load::Force { node, component, value: factor * value },
        Load::Acceleration { on, value } => Load::Acceleration { on, value: value.map(|a| factor * a) },
        Load::Rotation { on, speed_squared, point, axis } => {
            Load::Rotation { on, speed_squared: factor * speed_squared, point, axis }
        }
        Load::Pressure { faces, value } => Load::Pressure { faces, value: factor * value },
        Load::Traction { faces, value } => Load::Traction { faces, value: value.map(|t| factor * t) },
    };
    loads.iter().map(one).collect()
}
