//! Steps, supports and loads of a deck of Abaqus or CalculiX.

use vademecum_build::mesh::inp::{DataLine, Dialect, InpCard};

use crate::abaqus::reader::Reader;
use crate::deck::{Dynamic, Harmonic, Load, Step, StepKind, Support};
use crate::error::DeckError;

/// Begins a step. Loads and supports of the one before go on.
pub(crate) fn begin_step(reader: &mut Reader<'_>, card: &InpCard) {
    reader.end_step();
    let nonlinear = card.parameter("NLGEOM").is_some_and(|value| !value.eq_ignore_ascii_case("NO"));
    if nonlinear {
        reader.leave(card, "large displacements are not computed here: the answer is that of small ones");
    }
    let abaqus = reader.contents.dialect == Dialect::Abaqus;
    let steps = &mut reader.deck.steps;
    let name = card.parameter("NAME").map_or_else(|| (steps.len() + 1).to_string(), str::to_string);
    let perturbation = card.parameter("PERTURBATION").is_some();
    let supports = steps.last().map_or_else(Vec::new, |last| last.supports.clone());
    let carried = steps.last().filter(|_| !perturbation).map_or_else(Vec::new, |last| last.loads.clone());
    let temperatures = steps.last().map_or_else(Vec::new, |last| last.temperatures.clone());
    let kind = StepKind::Other("a step without a procedure".into());
    // CalculiX takes up the last static step where the deck asks for it, Abaqus wherever that step has large
    // displacements.
    let last = steps.iter().rposition(|step| step.kind == StepKind::Static);
    let about = last.filter(|_| if abaqus { reader.nonlinear } else { perturbation });
    let (loads, line) = (vec![], card.place.line());
    steps.push(Step { name, kind, loads, supports, temperatures, about, line });
    reader.nonlinear |= nonlinear;
    reader.carried = carried;
    reader.in_step = true;
    reader.period = 1.0;
}

/// The procedure of the step.
pub(crate) fn procedure(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    let numbers = match card.data.first() {
        Some(line) => {
            let fields = line.fields();
            fields.iter().map(|f| f.trim().parse::<f64>().unwrap_or(0.0)).collect()
        }
        None => vec![],
    };
    let kind = match card.keyword.as_str() {
        "STATIC" => {
            reader.period = numbers.get(1).copied().filter(|period| *period > 0.0).unwrap_or(1.0);
            StepKind::Static
        }
        "FREQUENCY" => {
            StepKind::Frequency(numbers.first().map(|count| *count as usize).filter(|count| *count > 0))
        }
        "MODAL DYNAMIC" | "DYNAMIC" if numbers.iter().take(2).filter(|x| **x > 0.0).count() == 2 => {
            if card.parameter("STEADY STATE").is_some() {
                reader.leave(card, "the motion begins at rest: it is not the periodic one");
            }
            reader.period = numbers[1];
            StepKind::Dynamic(Dynamic {
                modal: card.keyword == "MODAL DYNAMIC",
                increment: numbers[0],
                duration: numbers[1],
                courses: vec![],
                follows: vec![],
                printed: vec![],
            })
        }
        "STEADY STATE DYNAMICS" if numbers.iter().take(2).all(|x| *x > 0.0) && numbers.len() > 1 => {
            if card.parameter("HARMONIC").is_some_and(|value| value.eq_ignore_ascii_case("NO")) {
                reader
                    .leave(card, "periodic loads are taken as harmonic ones of the frequencies of the step");
            }
            StepKind::Harmonic(Harmonic { range: [numbers[0], numbers[1]], printed: vec![] })
        }
        other => StepKind::Other(other.to_ascii_lowercase()),
    };
    match reader.step() {
        Some(step) => {
            // Other procedures start from the body without load.
            step.about = step.about.filter(|_| matches!(kind, StepKind::Frequency(_)));
            step.kind = kind;
            Ok(())
        }
        None => Err(reader.fault(card, None, &card.section(), "a *STEP before it")),
    }
}

/// Supports, by set, component and value, or by a name for several components.
pub(crate) fn boundary(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    if card.parameter("OP").is_some_and(|op| op.eq_ignore_ascii_case("NEW")) {
        reader.supports().clear();
    }
    if card.parameter("FIXED").is_some() {
        reader
            .leave(card, "displacements of the step before are not kept: these components are held at zero");
    }
    if card.parameter("SUBMODEL").is_some() {
        return Err(reader.fault(card, None, "SUBMODEL", "displacements that stand in this deck"));
    }
    let factor = last_value(reader, card);
    for line in &card.data {
        let fields = line.fields();
        let (Some(name), Some(first)) = (fields.first(), fields.get(1)) else {
            return Err(reader.fault(card, Some(line), &line.text, "a node or a set, and a component"));
        };
        let nodes = reader.nodes(card, line, name)?;
        let (components, value) = match named(first) {
            Some(components) => (components, 0.0),
            None => {
                let Some(from) = reader.component(card, line, first)? else {
                    reader.leave(card, "components other than displacements and rotations are not computed");
                    continue;
                };
                let to = match fields.get(2).filter(|field| !field.is_empty()) {
                    Some(field) => reader.component(card, line, field)?.unwrap_or(5),
                    None => from,
                };
                let value = match fields.get(3).filter(|field| !field.is_empty()) {
                    Some(field) => reader.real(card, line, field)?,
                    None => 0.0,
                };
                ((from..=to).collect(), value)
            }
        };
        for &node in &nodes {
            for &component in &components {
                // Of two values of one component the last one counts.
                reader.supports().push(Support { node, component, value: factor * value });
            }
        }
    }
    Ok(())
}

/// Components that a name stands for.
fn named(name: &str) -> Option<Vec<u8>> {
    Some(match name.to_ascii_uppercase().as_str() {
        "ENCASTRE" => vec![0, 1, 2, 3, 4, 5],
        "PINNED" => vec![0, 1, 2],
        "XSYMM" => vec![0, 4, 5],
        "YSYMM" => vec![1, 3, 5],
        "ZSYMM" => vec![2, 3, 4],
        "XASYMM" => vec![1, 2, 3],
        "YASYMM" => vec![0, 2, 4],
        "ZASYMM" => vec![0, 1, 5],
        _ => return None,
    })
}

/// Forces and moments at nodes.
pub(crate) fn cload(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    if is_imaginary(reader, card) {
        return Ok(());
    }
    let factor = amplitude(reader, card);
    if new_loads(card) {
        clear(reader, |load| matches!(load, Load::Force { .. }));
    }
    for line in &card.data {
        let fields = line.fields();
        let [name, component, value, ..] = fields[..] else {
            return Err(reader.fault(card, Some(line), &line.text, "a node or a set, a component, a value"));
        };
        let nodes = reader.nodes(card, line, name)?;
        let value = factor * reader.real(card, line, value)?;
        let Some(component) = reader.component(card, line, component)? else {
            reader.leave(card, "loads other than forces and moments are not computed");
            continue;
        };
        if !reader.in_step {
            return outside(reader, card);
        }
        for node in nodes {
            reader.force(node, component, value);
        }
    }
    Ok(())
}

/// Loads on elements: gravity, rotation, pressure on faces.
pub(crate) fn dload(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    if is_imaginary(reader, card) {
        return Ok(());
    }
    let factor = amplitude(reader, card);
    if new_loads(card) {
        clear(reader, |load| !matches!(load, Load::Force { .. }));
    }
    for line in &card.data {
        let fields = line.fields();
        let [name, label, ..] = fields[..] else {
            return Err(reader.fault(card, Some(line), &line.text, "an element or a set, a label, a value"));
        };
        let label = label.to_ascii_uppercase();
        let numbers: Vec<f64> = fields[2..]
            .iter()
            .map(|field| if field.is_empty() { Ok(0.0) } else { reader.real(card, line, field) })
            .collect::<Result<_, _>>()?;
        let face =
            label.strip_prefix('P').and_then(|n| n.parse::<usize>().ok()).filter(|n| (1..=6).contains(n));
        let load = match (label.as_str(), &numbers[..]) {
            ("GRAV", &[size, x, y, z, ..]) => {
                let direction = unit(reader, card, line, [x, y, z])?;
                let value = direction.map(|c| factor * size * c);
                Load::Acceleration { on: reader.extent(card, line, name)?, value }
            }
            ("CENTRIF", &[speed_squared, px, py, pz, x, y, z, ..]) => {
                let axis = unit(reader, card, line, [x, y, z])?;
                let (on, point) = (reader.extent(card, line, name)?, [px, py, pz]);
                Load::Rotation { on, speed_squared: factor * speed_squared, point, axis }
            }
            (_, &[value, ..]) if face.is_some() => {
                let ids = reader.element_ids(card, Some(line), name)?;
                let faces = reader.faces(&ids, face.unwrap_or(1) - 1);
                let faces = faces.ok_or_else(|| {
                    reader.fault(card, Some(line), &line.text, "solid elements that have this face")
                })?;
                Load::Pressure { faces, value: factor * value }
            }
            _ => {
                reader.leave(card, "loads other than GRAV, CENTRIF and P1 to P6 are not applied");
                continue;
            }
        };
        push(reader, card, load)?;
    }
    Ok(())
}

/// Loads on surfaces: pressure and traction.
pub(crate) fn dsload(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    if is_imaginary(reader, card) {
        return Ok(());
    }
    let factor = amplitude(reader, card);
    for line in &card.data {
        let fields = line.fields();
        let [name, label, size, ref rest @ ..] = fields[..] else {
            return Err(reader.fault(card, Some(line), &line.text, "a surface, a label, a value"));
        };
        let value = factor * reader.real(card, line, size)?;
        let faces = reader.surface(card, Some(line), name)?;
        let load = match label.to_ascii_uppercase().as_str() {
            "P" => Load::Pressure { faces, value },
            "TRVEC" if rest.len() >= 3 => {
                let c = [0, 1, 2].map(|k| reader.real(card, line, rest[k]));
                let [x, y, z] = c;
                let direction = unit(reader, card, line, [x?, y?, z?])?;
                Load::Traction { faces, value: direction.map(|c| value * c) }
            }
            _ => {
                reader.leave(card, "loads other than P and TRVEC are not applied");
                continue;
            }
        };
        push(reader, card, load)?;
    }
    Ok(())
}

/// Points of an amplitude.
pub(crate) fn read_amplitude(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    let Some(name) = card.parameter("NAME") else {
        return Err(reader.fault(card, None, "no NAME", "NAME=amplitude"));
    };
    if card.parameter("DEFINITION").is_some_and(|kind| !kind.eq_ignore_ascii_case("TABULAR")) {
        reader.leave(card, "only tables are read: loads with this amplitude take their full value");
        return Ok(());
    }
    let mut numbers = Vec::new();
    for line in &card.data {
        numbers.extend(reader.reals(card, line)?);
    }
    let points = numbers.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect();
    reader.amplitudes.insert(name.to_ascii_uppercase(), points);
    Ok(())
}

/// Nodes whose displacements are printed.
pub(crate) fn node_print(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    let Some(name) = card.parameter("NSET") else { return Ok(()) };
    let wanted = card.data.iter().flat_map(|line| line.fields()).any(|field| field.trim() == "U");
    if !wanted {
        return Ok(());
    }
    let Some(nodes) = reader.node_set(name) else { return Ok(()) };
    if let Some(printed) = reader.step().and_then(|step| step.kind.printed()) {
        printed.extend(nodes);
    }
    Ok(())
}

/// The factor of a load: that of its amplitude at the end of the step. In a motion over time the amplitude is
/// the course of the loads of the card.
fn amplitude(reader: &mut Reader<'_>, card: &InpCard) -> f64 {
    let name = card.parameter("AMPLITUDE").map(str::to_ascii_uppercase).unwrap_or_default();
    let course = reader.amplitudes.get(&name).cloned().unwrap_or_default();
    let Some(StepKind::Dynamic(dynamic)) = reader.step().map(|step| &mut step.kind) else {
        return last_value(reader, card);
    };
    let known = dynamic.courses.iter().position(|known| known.0 == name);
    reader.course = known.unwrap_or_else(|| {
        dynamic.courses.push((name, course));
        dynamic.courses.len() - 1
    });
    1.0
}

/// The factor of an amplitude at the end of the step; 1 without one.
pub(crate) fn last_value(reader: &Reader<'_>, card: &InpCard) -> f64 {
    let name = card.parameter("AMPLITUDE").map(str::to_ascii_uppercase);
    let Some(points) = name.and_then(|name| reader.amplitudes.get(&name)) else { return 1.0 };
    let time = reader.period;
    let after = points.partition_point(|point| point[0] < time);
    match (after.checked_sub(1).and_then(|k| points.get(k)), points.get(after)) {
        (Some(a), Some(b)) => a[1] + (b[1] - a[1]) * (time - a[0]) / (b[0] - a[0]),
        (Some(end), None) | (None, Some(end)) => end[1],
        (None, None) => 1.0,
    }
}

/// True of a load that is a quarter of a period behind the others of a harmonic step; it is left out.
fn is_imaginary(reader: &mut Reader<'_>, card: &InpCard) -> bool {
    let imaginary = card.parameter("LOAD CASE") == Some("2") || card.parameter("IMAGINARY").is_some();
    if imaginary {
        reader.leave(card, "loads out of phase do not act: those in phase are taken");
    }
    imaginary
}

fn new_loads(card: &InpCard) -> bool {
    card.parameter("OP").is_some_and(|op| op.eq_ignore_ascii_case("NEW"))
}

fn clear(reader: &mut Reader<'_>, which: impl Fn(&Load) -> bool) {
    reader.carried.retain(|load| !which(load));
}

fn push(reader: &mut Reader<'_>, card: &InpCard, load: Load) -> Result<(), DeckError> {
    if reader.in_step {
        reader.act(load);
        return Ok(());
    }
    outside(reader, card)
}

/// Programs write loads outside of steps and pass them over.
fn outside(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    reader.leave(card, "it stands outside of a step and acts in none");
    Ok(())
}

fn unit(reader: &Reader<'_>, card: &InpCard, line: &DataLine, v: [f64; 3]) -> Result<[f64; 3], DeckError> {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 {
        Ok(v.map(|x| x / length))
    } else {
        Err(reader.fault(card, Some(line), &line.text, "a direction that is not zero"))
    }
}
