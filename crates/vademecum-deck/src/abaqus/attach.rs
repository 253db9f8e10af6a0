//! Couplings, ties, equations, masses, springs and nodal axes of a deck of Abaqus or CalculiX.

use vademecum_build::fem::Cylinder;
use vademecum_build::linalg::vec3::{cross, norm, sub};
use vademecum_build::mesh::inp::{DataLine, Dialect, InpCard, InpElement};

use crate::abaqus::reader::Reader;
use crate::deck::{Attachment, Link, NodeNumber, Spring};
use crate::error::DeckError;

/// Position of a card, as the origin of what it adds.
fn origin(card: &InpCard) -> String {
    format!("{} at line {}", card.section(), card.place.line())
}

/// Rigid bodies: nodes or the nodes of elements follow a reference node.
pub(crate) fn rigid_body(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    let Some(reference) = reader.node(card, "REF NODE")? else {
        return Err(reader.fault(card, None, "no REF NODE", "REF NODE=node"));
    };
    let rotation = reader.node(card, "ROT NODE")?;
    let set = ["NSET", "TIE NSET", "PIN NSET"].iter().find_map(|key| Some((*key, card.parameter(key)?)));
    let no_line = DataLine { text: String::new(), place: card.place.clone() };
    let nodes = match set {
        Some((_, name)) => reader.nodes(card, &no_line, name)?,
        None => {
            let mut nodes: Vec<NodeNumber> =
                reader.elements_of(card)?.into_iter().flat_map(|element| reader.ends(element)).collect();
            nodes.sort_unstable();
            nodes.dedup();
            nodes
        }
    };
    let turning = !matches!(set, Some(("PIN NSET", _)));
    let components = [true, true, true, turning, turning, turning];
    reader.deck.links.push(Link::Rigid { reference, rotation, nodes, components, origin: origin(card) });
    Ok(())
}

/// A coupling of a surface to a reference node; the card after it says of which kind.
pub(crate) fn coupling(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    let Some(reference) = reader.node(card, "REF NODE")? else {
        return Err(reader.fault(card, None, "no REF NODE", "REF NODE=node"));
    };
    let Some(surface) = card.parameter("SURFACE") else {
        return Err(reader.fault(card, None, "no SURFACE", "SURFACE=surface"));
    };
    reader.coupling = Some((reference, surface.to_string()));
    Ok(())
}

/// The kind of the coupling before it.
pub(crate) fn coupled(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    let Some((reference, surface)) = reader.coupling.take() else {
        return Err(reader.fault(card, None, &card.section(), "a *COUPLING before it"));
    };
    let mut components = [card.data.is_empty(); 6];
    for line in &card.data {
        let fields = line.fields();
        let bound = |k: usize| match fields.get(k).filter(|field| !field.is_empty()) {
            Some(field) => reader.component(card, line, field),
            None => Ok(None),
        };
        if let Some(from) = bound(0)? {
            let to = bound(1)?.unwrap_or(from).max(from);
            components[usize::from(from)..=usize::from(to)].fill(true);
        }
    }
    let nodes = reader.surface_nodes(card, None, &surface)?;
    let origin = origin(card);
    reader.deck.links.push(match card.keyword.as_str() {
        "KINEMATIC" => Link::Rigid { reference, rotation: None, nodes, components, origin },
        _ => {
            let cloud = nodes.into_iter().map(|node| (node, 1.0)).collect();
            Link::Mean { reference, cloud, components: [true; 6], origin }
        }
    });
    Ok(())
}

/// The older form: an element holds the reference node, lines give nodes and weights.
pub(crate) fn distributing(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    let elements = reader.elements_of(card)?;
    let Some(reference) = elements.first().and_then(|element| reader.ends(element).first().copied()) else {
        return Err(reader.fault(card, None, "an empty set", "an element of type DCOUP3D"));
    };
    let mut cloud = Vec::new();
    for line in &card.data {
        let fields = line.fields();
        let weight = match fields.get(1).filter(|field| !field.is_empty()) {
            Some(field) => reader.real(card, line, field)?,
            None => 1.0,
        };
        let nodes = reader.nodes(card, line, fields.first().unwrap_or(&""))?;
        cloud.extend(nodes.into_iter().map(|node| (node, weight)));
    }
    let whole: f64 = cloud.iter().map(|(_, weight)| weight).sum();
    if whole <= 0.0 {
        return Err(reader.fault(card, None, "no weights", "nodes with weights above zero"));
    }
    let origin = origin(card);
    if reader.contents.dialect == Dialect::Abaqus {
        reader.deck.links.push(Link::Mean { reference, cloud, components: [true; 6], origin });
        return Ok(());
    }
    // CalculiX: the mean displacement, wherever the reference node is.
    for component in 0..3 {
        let others = cloud.iter().map(|&(node, weight)| (node, component, -weight / whole));
        let terms = std::iter::once((reference, component, 1.0)).chain(others).collect();
        reader.deck.links.push(Link::Equation { terms, origin: origin.clone() });
    }
    Ok(())
}

/// Named constraints between nodes.
pub(crate) fn mpc(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    for line in &card.data {
        let fields = line.fields();
        let kind = fields.first().unwrap_or(&"").to_ascii_uppercase();
        let components = match kind.as_str() {
            "PIN" => [true, true, true, false, false, false],
            "TIE" | "BEAM" => [true; 6],
            _ => {
                reader.leave(card, "only PIN, TIE and BEAM are joined: what it couples is loose");
                continue;
            }
        };
        let (Some(first), Some(second)) = (fields.get(1), fields.get(2)) else {
            return Err(reader.fault(card, Some(line), &line.text, "a kind and two nodes or sets"));
        };
        let (followers, references) = (reader.nodes(card, line, first)?, reader.nodes(card, line, second)?);
        for (k, &node) in followers.iter().enumerate() {
            let Some(&reference) = references.get(k).or(references.first()) else { continue };
            let link = match kind.as_str() {
                "BEAM" => vec![rigid(reference, node, components, card)],
                _ => equal(reference, node, components, card),
            };
            reader.deck.links.extend(link);
        }
    }
    Ok(())
}

fn rigid(reference: NodeNumber, node: NodeNumber, components: [bool; 6], card: &InpCard) -> Link {
    Link::Rigid { reference, rotation: None, nodes: vec![node], components, origin: origin(card) }
}

/// Equal displacements.
fn equal(reference: NodeNumber, node: NodeNumber, components: [bool; 6], card: &InpCard) -> Vec<Link> {
    let joined = (0..3_u8).filter(|c| components[usize::from(*c)]);
    let terms = |c: u8| vec![(node, c, 1.0), (reference, c, -1.0)];
    joined.map(|c| Link::Equation { terms: terms(c), origin: origin(card) }).collect()
}

/// Linear equations: the number of terms, then node, component and coefficient of each.
pub(crate) fn equation(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    let mut lines = card.data.iter();
    while let Some(head) = lines.next() {
        let count = head.fields().first().and_then(|field| field.parse::<usize>().ok());
        let Some(count) = count.filter(|count| *count > 0) else {
            return Err(reader.fault(card, Some(head), &head.text, "the number of terms"));
        };
        let mut fields: Vec<(&DataLine, &str)> = Vec::new();
        while fields.len() < 3 * count {
            let Some(line) = lines.next() else {
                return Err(reader.fault(
                    card,
                    Some(head),
                    &head.text,
                    "node, component, coefficient of each term",
                ));
            };
            fields.extend(line.fields().into_iter().map(|field| (line, field)));
        }
        let mut terms: Vec<(Vec<NodeNumber>, u8, f64)> = Vec::new();
        for term in fields[..3 * count].chunks_exact(3) {
            let [(line, node), (_, component), (_, factor)] = [term[0], term[1], term[2]];
            let Some(component) = reader.component(card, line, component)? else {
                return Err(reader.fault(card, Some(line), component, "a degree of freedom, 1 to 6"));
            };
            terms.push((reader.nodes(card, line, node)?, component, reader.real(card, line, factor)?));
        }
        // Sets are taken node by node; a set of one node stands in each equation.
        let rows = terms.iter().map(|term| term.0.len()).max().unwrap_or(0);
        for row in 0..rows {
            let of_row = |(nodes, component, factor): &(Vec<NodeNumber>, u8, f64)| {
                let node = nodes.get(row).or(nodes.first().filter(|_| nodes.len() == 1))?;
                Some((*node, *component, *factor))
            };
            let Some(terms) = terms.iter().map(of_row).collect::<Option<Vec<_>>>() else {
                return Err(reader.fault(card, Some(head), &head.text, "sets of one size"));
            };
            reader.deck.links.push(Link::Equation { terms, origin: origin(card) });
        }
    }
    Ok(())
}

/// Ties: the nodes of the first surface follow the faces of the second.
pub(crate) fn tie(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    if card.parameter("CYCLIC SYMMETRY").is_some() {
        let expected = "a tie of two surfaces: cyclic symmetry is not computed with";
        return Err(reader.fault(card, None, "CYCLIC SYMMETRY", expected));
    }
    let tolerance = match card.parameter("POSITION TOLERANCE") {
        Some(value) => {
            let line = DataLine { text: value.to_string(), place: card.place.clone() };
            Some(reader.real(card, &line, value)?)
        }
        None => None,
    };
    for line in &card.data {
        let fields = line.fields();
        let [slave, master, ..] = fields[..] else {
            return Err(reader.fault(card, Some(line), &line.text, "two surfaces"));
        };
        let slaves = reader.surface_nodes(card, Some(line), slave)?;
        let faces = reader.surface(card, Some(line), master)?;
        reader.deck.links.push(Link::Tie { slaves, faces, tolerance, origin: origin(card) });
    }
    Ok(())
}

/// Axes of nodes: rectangular, or cylindrical about a line.
pub(crate) fn transform(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    let no_line = DataLine { text: String::new(), place: card.place.clone() };
    let nodes = reader.nodes(card, &no_line, card.parameter("NSET").unwrap_or(""))?;
    let kind = card.parameter("TYPE").unwrap_or("R").to_ascii_uppercase();
    let numbers = match card.data.first() {
        Some(line) => reader.reals(card, line)?,
        None => vec![],
    };
    let &[ax, ay, az, bx, by, bz, ..] = &numbers[..] else {
        return Err(reader.fault(card, card.data.first(), "fewer numbers", "six coordinates"));
    };
    let (a, b) = ([ax, ay, az], [bx, by, bz]);
    for node in nodes {
        let axes = match kind.as_str() {
            "R" => rectangular(a, b),
            "C" => {
                let axis = sub(b, a);
                (norm(axis) > 0.0).then(|| Cylinder { point: a, axis }.axes(reader.deck.place(node)))
            }
            _ => return Err(reader.fault(card, None, &format!("TYPE={kind}"), "TYPE=R or TYPE=C")),
        };
        let Some(axes) = axes else {
            let found = format!("axes of node {}", reader.deck.id(node));
            return Err(reader.fault(card, card.data.first(), &found, "points that are not on one line"));
        };
        reader.deck.axes.insert(node, axes);
    }
    Ok(())
}

/// First axis through `a`, third one normal to `a` and `b`.
fn rectangular(a: [f64; 3], b: [f64; 3]) -> Option<[[f64; 3]; 3]> {
    let x = unit(a)?;
    let z = unit(cross(x, b))?;
    Some([x, cross(z, x), z])
}

fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = norm(v);
    (length > 0.0 && length.is_finite()).then(|| v.map(|x| x / length))
}

/// Masses, and moments of inertia, at nodes.
pub(crate) fn mass(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    let Some(line) = card.data.first() else {
        return Err(reader.fault(card, None, "no data", "a mass, or moments of inertia"));
    };
    let numbers = reader.reals(card, line)?;
    let (mass, inertia) = match card.keyword.as_str() {
        "MASS" => (numbers.first().copied().unwrap_or(0.0), [0.0; 6]),
        // Abaqus: I11, I22, I33, I12, I13, I23.
        _ => (0.0, std::array::from_fn(|k| numbers.get(k).copied().unwrap_or(0.0))),
    };
    for element in reader.elements_of(card)? {
        for node in reader.ends(element) {
            reader.deck.attachments.push(Attachment::Mass { node, mass, inertia });
        }
    }
    Ok(())
}

/// Springs and dashpots, by the type of their elements.
pub(crate) fn spring(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    if card.parameter("NONLINEAR").is_some() {
        return Err(reader.fault(card, None, "NONLINEAR", "a linear spring or dashpot"));
    }
    for element in reader.elements_of(card)? {
        let spring = one_spring(reader, card, element)?;
        let dashpot = card.keyword == "DASHPOT";
        reader.deck.attachments.push(if dashpot {
            Attachment::Dashpot(spring)
        } else {
            Attachment::Spring(spring)
        });
    }
    if card.keyword == "DASHPOT" {
        reader.leave_damping(card);
    }
    Ok(())
}

fn one_spring(reader: &Reader<'_>, card: &InpCard, element: &InpElement) -> Result<Spring, DeckError> {
    let ends = reader.ends(element);
    let along = element.name.ends_with('A');
    // Along a line there is no component: its line may be blank or absent.
    let value = if along { card.data.last() } else { card.data.get(1) };
    let Some(value) = value else {
        return Err(reader.fault(card, None, "fewer lines", "components, then a stiffness or a damping"));
    };
    let stiffness = reader.reals(card, value)?.first().copied().unwrap_or(0.0);
    if along {
        let &[a, b] = &ends[..] else {
            return Err(reader.fault(card, Some(value), &element.name, "two nodes"));
        };
        return Ok(Spring::Line { ends: [a, b], stiffness });
    }
    let line = &card.data[0];
    let fields = line.fields();
    let mut components = Vec::new();
    for (&end, field) in ends.iter().zip(&fields) {
        match reader.component(card, line, field)? {
            Some(component) => components.push((end, component)),
            None => return Err(reader.fault(card, Some(line), field, "a degree of freedom, 1 to 6")),
        }
    }
    if components.len() != ends.len() {
        return Err(reader.fault(card, Some(line), &line.text, "a component for each end"));
    }
    Ok(Spring::Components { ends: components, stiffness })
}
