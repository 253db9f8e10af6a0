//! Rigid elements, masses, springs and bars of a Nastran model.

use std::collections::BTreeMap;

use vademecum_build::fem::Elasticity;
use vademecum_build::linalg::vec3::{cross, norm};
use vademecum_build::mesh::nastran::Card;

use crate::deck::{Attachment, Link, NodeNumber, Point, Spring};
use crate::error::DeckError;
use crate::nastran::model::{Model, components};

/// Takes all of them.
pub(crate) fn take(model: &mut Model<'_>) -> Result<(), DeckError> {
    for card in model.named("RBE2") {
        rbe2(model, card)?;
    }
    for card in model.named("RBE3") {
        rbe3(model, card)?;
    }
    for card in model.named("RBAR") {
        rbar(model, card)?;
    }
    for card in model.named("CONM2") {
        conm2(model, card)?;
    }
    for card in model.named("CBAR") {
        cbar(model, card)?;
    }
    let mut stiffness = BTreeMap::new();
    for card in model.named("PELAS") {
        // Two properties may share a card.
        for first in [0, 4] {
            if let (Some(id), Some(k)) = (card.id(first)?, card.real(first + 1)?) {
                stiffness.insert(id, k);
            }
        }
    }
    for card in model.named("CELAS1") {
        let property = card.id(1)?.or(card.id(0)?).unwrap_or(0);
        let Some(&k) = stiffness.get(&property) else {
            return Err(model.fault(card, &format!("property {property}"), "a PELAS of the deck"));
        };
        spring(model, card, k)?;
    }
    for card in model.named("CELAS2") {
        let k = card.real(1)?.unwrap_or(0.0);
        spring(model, card, k)?;
    }
    let mut bushes: BTreeMap<u64, [f64; 6]> = BTreeMap::new();
    for card in model.named("PBUSH") {
        let Some(start) = card.fields.iter().position(|field| field.eq_ignore_ascii_case("K")) else {
            continue;
        };
        let mut k = [0.0; 6];
        for (c, k) in k.iter_mut().enumerate() {
            *k = card.real(start + 1 + c)?.unwrap_or(0.0);
        }
        bushes.insert(model.needed(card, 0)?, k);
    }
    for card in model.named("CBUSH") {
        bush(model, card, &bushes)?;
    }
    Ok(())
}

fn origin(card: &Card) -> String {
    format!("{} at line {}", card.name, card.line)
}

/// Components that digits name, as flags.
fn flags(digits: &str) -> [bool; 6] {
    let mut flags = [false; 6];
    components(digits).for_each(|c| flags[usize::from(c)] = true);
    flags
}

/// Nodes of a list of fields, `THRU` among them.
fn nodes(model: &Model<'_>, card: &Card, fields: &[String]) -> Result<Vec<NodeNumber>, DeckError> {
    let Some(ranges) = vademecum_build::mesh::nastran::ranges(fields) else {
        return Err(model.fault(card, &fields.join(" "), "numbers of grid points, or ranges with THRU"));
    };
    let mut found = Vec::new();
    for [first, last] in ranges {
        if first == last {
            let Some(node) = model.numbered(first) else {
                return Err(model.fault(card, &format!("grid point {first}"), "a grid point of the deck"));
            };
            found.push(node);
        } else {
            // A range names the points that there are.
            let count = model.deck.node_count() as u32;
            let inside = (0..count).filter(|&node| (first..=last).contains(&model.deck.id(node)));
            found.extend(inside);
        }
    }
    Ok(found)
}

/// Dependent points follow an independent one.
fn rbe2(model: &mut Model<'_>, card: &Card) -> Result<(), DeckError> {
    let Some(reference) = model.node(card, 1)? else {
        return Err(model.fault(card, "no GN", "the number of the independent grid point"));
    };
    // A thermal expansion coefficient may stand at the end.
    let list: Vec<String> =
        card.fields.iter().skip(3).filter(|field| !field.contains('.')).cloned().collect();
    let link = Link::Rigid {
        reference,
        rotation: None,
        nodes: nodes(model, card, &list)?,
        components: flags(card.field(2)),
        origin: origin(card),
    };
    model.deck.links.push(link);
    Ok(())
}

/// A reference point follows the mean of others.
fn rbe3(model: &mut Model<'_>, card: &Card) -> Result<(), DeckError> {
    let Some(reference) = model.node(card, 2)? else {
        return Err(model.fault(card, "no REFGRID", "the number of the reference grid point"));
    };
    let fields: Vec<&str> = card.fields.iter().skip(4).map(String::as_str).collect();
    let end = fields
        .iter()
        .position(|field| field.eq_ignore_ascii_case("UM") || field.eq_ignore_ascii_case("ALPHA"));
    if end.is_some_and(|end| fields[end].eq_ignore_ascii_case("UM")) {
        model.leave(card, "UM is not taken: the reference point is the dependent one");
    }
    let fields = &fields[..end.unwrap_or(fields.len())];
    let (mut cloud, mut weight, mut place) = (Vec::new(), 1.0, 0);
    while place < fields.len() {
        let field = fields[place];
        if field.is_empty() {
            place += 1;
        } else if field.contains('.') {
            // A weight, and the components of the points behind it.
            weight = vademecum_build::mesh::nastran::number(field)
                .ok_or_else(|| model.fault(card, field, "a weight"))?;
            let digits = fields.get(place + 1).copied().unwrap_or("");
            if !["123", "123456"].contains(&digits) {
                return Err(model.fault(card, digits, "components 123 of the points"));
            }
            place += 2;
        } else {
            let end = fields[place..].iter().position(|field| field.contains('.') || field.is_empty());
            let end = place + end.unwrap_or(fields.len() - place);
            let list: Vec<String> = fields[place..end].iter().map(|field| field.to_string()).collect();
            cloud.extend(nodes(model, card, &list)?.into_iter().map(|node| (node, weight)));
            place = end;
        }
    }
    if cloud.iter().map(|(_, weight)| weight).sum::<f64>() <= 0.0 {
        return Err(model.fault(card, "no weights", "points with weights above zero"));
    }
    let components = flags(card.field(3));
    model.deck.links.push(Link::Mean { reference, cloud, components, origin: origin(card) });
    Ok(())
}

/// A rigid bar: one end has all independent components.
fn rbar(model: &mut Model<'_>, card: &Card) -> Result<(), DeckError> {
    let (Some(a), Some(b)) = (model.node(card, 1)?, model.node(card, 2)?) else {
        return Err(model.fault(card, "fewer points", "two grid points"));
    };
    let all = |digits: &str| flags(digits) == [true; 6];
    let (reference, node, digits) = match (all(card.field(3)), all(card.field(4))) {
        (true, _) => (a, b, card.field(6)),
        (_, true) => (b, a, card.field(5)),
        _ => return Err(model.fault(card, card.field(3), "123456 at one end")),
    };
    let components = if digits.is_empty() { [true; 6] } else { flags(digits) };
    let link = Link::Rigid { reference, rotation: None, nodes: vec![node], components, origin: origin(card) };
    model.deck.links.push(link);
    Ok(())
}

/// A mass, with moments of inertia and an offset.
fn conm2(model: &mut Model<'_>, card: &Card) -> Result<(), DeckError> {
    let Some(node) = model.node(card, 1)? else {
        return Err(model.fault(card, "no grid point", "a grid point"));
    };
    let system = card.id(2)?.unwrap_or(0);
    if system != 0 {
        model.leave(
            card,
            "its coordinate system is not taken: offset and moments are along the axes of space",
        );
    }
    let mass = model.wtmass * card.real(3)?.unwrap_or(0.0);
    let mut offset = [0.0; 3];
    for (c, offset) in offset.iter_mut().enumerate() {
        *offset = card.real(4 + c)?.unwrap_or(0.0);
    }
    // I11, I21, I22, I31, I32, I33; here xx, yy, zz, xy, xz, yz.
    let mut inertia = [0.0; 6];
    for (place, field) in [(0, 8), (3, 9), (1, 10), (4, 11), (5, 12), (2, 13)] {
        inertia[place] = model.wtmass * card.real(field)?.unwrap_or(0.0);
    }
    let holder = if offset == [0.0; 3] {
        node
    } else {
        let (at, id) = (model.deck.place(node), model.deck.id(node));
        let holder = model.deck.node_count() as NodeNumber;
        model.deck.points.push(Point { id, at: std::array::from_fn(|c| at[c] + offset[c]) });
        let nodes = vec![holder];
        let (components, origin) = ([true; 6], origin(card));
        model.deck.links.push(Link::Rigid { reference: node, rotation: None, nodes, components, origin });
        holder
    };
    model.deck.attachments.push(Attachment::Mass { node: holder, mass, inertia });
    Ok(())
}

/// A scalar spring.
fn spring(model: &mut Model<'_>, card: &Card, stiffness: f64) -> Result<(), DeckError> {
    let mut ends = Vec::new();
    for field in [2, 4] {
        if let Some(node) = model.node(card, field)? {
            let Some(component) = components(card.field(field + 1)).next() else {
                return Err(model.fault(card, card.field(field + 1), "a component, 1 to 6"));
            };
            ends.push((node, component));
        }
    }
    if ends.is_empty() {
        return Err(model.fault(card, "no grid point", "one or two grid points"));
    }
    model.deck.attachments.push(Attachment::Spring(Spring::Components { ends, stiffness }));
    Ok(())
}

/// Springs along and about the axes of space.
fn bush(model: &mut Model<'_>, card: &Card, properties: &BTreeMap<u64, [f64; 6]>) -> Result<(), DeckError> {
    let property = card.id(1)?.or(card.id(0)?).unwrap_or(0);
    let Some(k) = properties.get(&property) else {
        return Err(model.fault(card, &format!("property {property}"), "a PBUSH of the deck"));
    };
    let Some(a) = model.node(card, 2)? else { return Err(model.fault(card, "no GA", "a grid point")) };
    let b = model.node(card, 3)?;
    let apart = b.is_some_and(|b| model.deck.place(a) != model.deck.place(b));
    let system = card.id(7)?;
    if system.is_some_and(|system| system != 0) || (apart && system.is_none()) {
        let expected = "coordinate system 0 (CID), or two points at one place";
        return Err(model.fault(card, "own axes", expected));
    }
    for (c, &stiffness) in k.iter().enumerate().filter(|(_, k)| **k != 0.0) {
        let ends = std::iter::once(a).chain(b).map(|node| (node, c as u8)).collect();
        model.deck.attachments.push(Attachment::Spring(Spring::Components { ends, stiffness }));
    }
    Ok(())
}

/// Cross-section of a bar: area, moments of area in plane 1 and 2, torsion constant, mass per length.
type Section = ([f64; 4], u64, f64);

/// A bar between two reference points, as a stiffness over its twelve dofs.
fn cbar(model: &mut Model<'_>, card: &Card) -> Result<(), DeckError> {
    let property = card.id(1)?.or(card.id(0)?).unwrap_or(0);
    let ([area, i1, i2, torsion], material, extra) = section(model, card, property)?;
    let Some(&constants) = model.constants.get(&material) else {
        return Err(model.fault(card, &format!("material {material}"), "a MAT1 of the deck"));
    };
    let (Some(a), Some(b)) = (model.node(card, 2)?, model.node(card, 3)?) else {
        return Err(model.fault(card, "fewer points", "two grid points"));
    };
    let solid = |node: NodeNumber| (node as usize) < model.deck.mesh.nodes.len();
    if solid(a) || solid(b) {
        let expected = "a bar between two reference points: a solid has no rotation that it could hold";
        return Err(model.fault(card, "an end at a node of a solid", expected));
    }
    if (8..16).any(|field| !card.field(field).is_empty()) {
        return Err(model.fault(card, "released components or offsets", "none of them"));
    }
    let (from, to) = (model.deck.place(a), model.deck.place(b));
    let along: [f64; 3] = std::array::from_fn(|c| to[c] - from[c]);
    // A grid point or a vector says where plane 1 is.
    let aside = match model.node(card, 4).ok().flatten().filter(|_| card.field(5).is_empty()) {
        Some(third) => {
            let at = model.deck.place(third);
            std::array::from_fn(|c| at[c] - from[c])
        }
        None => {
            let mut v = [0.0; 3];
            for (c, v) in v.iter_mut().enumerate() {
                *v = card.real(4 + c)?.unwrap_or(0.0);
            }
            v
        }
    };
    let Some((axes, length)) = bar_axes(along, aside) else {
        return Err(model.fault(
            card,
            "a bar without a length or a plane",
            "two points and a vector beside them",
        ));
    };
    let Elasticity::Isotropic { young, poisson } = constants.elasticity else {
        return Err(model.fault(card, "a material with axes", "an isotropic one"));
    };
    let shear = young / (2.0 * (1.0 + poisson));
    let stiffness = bar_stiffness(young, shear, length, [area, i1, i2, torsion], axes);
    let mass = 0.5 * length * (constants.density * area + model.wtmass * extra);
    model.deck.attachments.push(Attachment::Beam { ends: [a, b], stiffness, mass });
    Ok(())
}

/// The section of a property.
fn section(model: &mut Model<'_>, card: &Card, property: u64) -> Result<Section, DeckError> {
    for found in model.named("PBAR") {
        if found.id(0)? == Some(property) {
            let mut values = [0.0; 5];
            for (k, value) in values.iter_mut().enumerate() {
                *value = found.real(2 + k)?.unwrap_or(0.0);
            }
            let [area, i1, i2, torsion, extra] = values;
            return Ok(([area, i1, i2, torsion], model.needed(found, 1)?, extra));
        }
    }
    for found in model.named("PBARL") {
        if found.id(0)? == Some(property) {
            let size = |k: usize| found.real(8 + k).map(|value| value.unwrap_or(0.0));
            let pi = std::f64::consts::PI;
            let (values, count) = match found.field(3).to_ascii_uppercase().as_str() {
                "ROD" => {
                    let square = size(0)?.powi(2);
                    let i = pi * square * square / 4.0;
                    ([pi * square, i, i, 2.0 * i], 1)
                }
                "TUBE" => {
                    let (outer, inner) = (size(0)?, size(1)?);
                    let i = pi * (outer.powi(4) - inner.powi(4)) / 4.0;
                    ([pi * (outer.powi(2) - inner.powi(2)), i, i, 2.0 * i], 2)
                }
                "BAR" => {
                    let (width, height) = (size(0)?, size(1)?);
                    let (long, short) = (width.max(height), width.min(height));
                    let ratio = short / long;
                    let torsion =
                        long * short.powi(3) * (1.0 / 3.0 - 0.21 * ratio * (1.0 - ratio.powi(4) / 12.0));
                    let area = width * height;
                    ([area, width * height.powi(3) / 12.0, height * width.powi(3) / 12.0, torsion], 2)
                }
                other => {
                    let expected = "a PBAR, or a PBARL with ROD, TUBE or BAR";
                    return Err(model.fault(found, &format!("section {other}"), expected));
                }
            };
            return Ok((values, model.needed(found, 1)?, size(count)?));
        }
    }
    Err(model.fault(card, &format!("property {property}"), "a PBAR or PBARL of the deck"))
}

/// Axes of a bar as rows, and its length: along it, in plane 1, and normal to both.
fn bar_axes(along: [f64; 3], aside: [f64; 3]) -> Option<([[f64; 3]; 3], f64)> {
    let length = norm(along);
    let x = along.map(|c| c / length);
    let z = cross(x, aside);
    let size = norm(z);
    let z = z.map(|c| c / size);
    (length > 0.0 && size > 0.0 && size.is_finite()).then(|| ([x, cross(z, x), z], length))
}

/// The matrix (12, 12) of a bar without shear deformation, row by row, along the axes of space.
fn bar_stiffness(
    young: f64,
    shear: f64,
    length: f64,
    [area, i1, i2, torsion]: [f64; 4],
    axes: [[f64; 3]; 3],
) -> Vec<f64> {
    let mut local = [[0.0; 12]; 12];
    let mut add = |dofs: &[usize], values: &[&[f64]]| {
        for (i, row) in dofs.iter().zip(values) {
            for (j, value) in dofs.iter().zip(*row) {
                local[*i][*j] += value;
            }
        }
    };
    let (k, t) = (young * area / length, shear * torsion / length);
    add(&[0, 6], &[&[k, -k], &[-k, k]]);
    add(&[3, 9], &[&[t, -t], &[-t, t]]);
    // Bending in plane 1 turns about the third axis, in plane 2 about the second one the other way.
    for (dofs, i, sign) in [([1, 5, 7, 11], i1, 1.0), ([2, 4, 8, 10], i2, -1.0)] {
        let f = young * i / length.powi(3);
        let (a, b, c, d) =
            (12.0 * f, sign * 6.0 * f * length, 4.0 * f * length.powi(2), 2.0 * f * length.powi(2));
        add(&dofs, &[&[a, b, -a, b], &[b, c, -b, d], &[-a, -b, a, -b], &[b, d, -b, c]]);
    }
    let turn = |i: usize, j: usize| if i / 3 == j / 3 { axes[i % 3][j % 3] } else { 0.0 };
    let mut global = vec![0.0; 144];
    for i in 0..12 {
        for j in 0..12 {
            let mut sum = 0.0;
            for p in 0..12 {
                for q in 0..12 {
                    sum += turn(p, i) * local[p][q] * turn(q, j);
                }
            }
            global[12 * i + j] = sum;
        }
    }
    global
}
