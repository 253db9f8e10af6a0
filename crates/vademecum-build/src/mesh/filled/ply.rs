//! PLY files, in text and in bytes: a head that says what follows, then the elements one after the other.

use std::path::Path;

use super::triangles::Triangles;
use super::winding::Point;
use crate::mesh::error::MeshError;
use crate::mesh::text::{Endian, Text, tokens};

/// A type of numbers.
#[derive(Clone, Copy)]
enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Number {
    fn named(word: &[u8]) -> Option<Self> {
        Some(match word {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// The next number; in text where there is no order of bytes.
    fn next(self, text: &mut Text<'_>, order: Option<Endian>) -> Result<f64, MeshError> {
        const WHAT: &str = "a number of this element";
        let Some(order) = order else { return text.number::<f64>(WHAT) };
        let value = match self {
            Self::I8 => text.value::<i8>(order, WHAT)?.into(),
            Self::U8 => text.value::<u8>(order, WHAT)?.into(),
            Self::I16 => text.value::<i16>(order, WHAT)?.into(),
            Self::U16 => text.value::<u16>(order, WHAT)?.into(),
            Self::I32 => text.value::<i32>(order, WHAT)?.into(),
            Self::U32 => text.value::<u32>(order, WHAT)?.into(),
            Self::F32 => text.value::<f32>(order, WHAT)?.into(),
            Self::F64 => text.value::<f64>(order, WHAT)?,
        };
        match value.is_finite() {
            true => Ok(value),
            false => Err(text.at().malformed(value.to_string(), "a finite number")),
        }
    }
}

/// A property of an element: its name, the type of its numbers, and that of their count in a list.
struct Property {
    name: Vec<u8>,
    number: Number,
    count: Option<Number>,
}

struct Element {
    name: Vec<u8>,
    count: u64,
    properties: Vec<Property>,
}

/// Reads the triangles of a PLY file.
pub(super) fn parse(file: &Path, bytes: &[u8]) -> Result<Triangles, MeshError> {
    let mut text = Text::new(file, bytes);
    let (order, elements) = head(&mut text)?;
    text.binary = order.is_some();
    let mut found = Triangles { format: "PLY", corners: vec![] };
    let mut points: Vec<Point> = vec![];
    let mut values = vec![];
    for element in &elements {
        text.section = String::from_utf8_lossy(&element.name).into_owned();
        let at = |name: &[u8]| element.properties.iter().position(|property| property.name == name);
        let place = [at(b"x"), at(b"y"), at(b"z")];
        let list = at(b"vertex_indices").or_else(|| at(b"vertex_index"));
        if element.properties.is_empty() {
            continue;
        }
        for _ in 0..text.bounded(element.count, element.properties.len(), "elements")? {
            let mut point = [0.0; 3];
            for (k, property) in element.properties.iter().enumerate() {
                let count = match property.count {
                    None => 1,
                    Some(count) => {
                        let count = count.next(&mut text, order)?;
                        let whole = (count >= 0.0 && count.fract() == 0.0).then_some(count as u64);
                        let wrong = || text.at().malformed(count.to_string(), "the length of a list");
                        text.bounded(whole.ok_or_else(wrong)?, 1, "numbers")?
                    }
                };
                values.clear();
                for _ in 0..count {
                    values.push(property.number.next(&mut text, order)?);
                }
                if let (Some(axis), [value]) = (place.iter().position(|at| *at == Some(k)), &values[..]) {
                    point[axis] = *value;
                }
                if element.name == b"face" && list == Some(k) {
                    let whole = |&x: &f64| {
                        (x >= 0.0 && x.fract() == 0.0 && x < points.len() as f64).then_some(x as usize)
                    };
                    let polygon: Option<Vec<usize>> = values.iter().map(whole).collect();
                    let polygon = polygon.filter(|polygon| polygon.len() >= 3).ok_or_else(|| {
                        text.at().malformed(
                            format!("a face of the vertices {values:?}"),
                            "three vertices of the file or more",
                        )
                    })?;
                    found.push(&points, &polygon);
                }
            }
            if element.name == b"vertex" && place.iter().all(Option::is_some) {
                points.push(point);
            }
        }
    }
    Ok(found)
}

/// The head: the order of the bytes, none of text, and the elements.
fn head(text: &mut Text<'_>) -> Result<(Option<Endian>, Vec<Element>), MeshError> {
    text.section = "the head".into();
    text.literal("ply")?;
    let mut order = None;
    let mut elements: Vec<Element> = vec![];
    loop {
        let line = text.line("end_header")?;
        let words: Vec<&[u8]> = tokens(line).collect();
        match words[..] {
            [b"format", kind, _] => {
                order = match kind {
                    b"ascii" => None,
                    b"binary_little_endian" => Some(Endian::Little),
                    b"binary_big_endian" => Some(Endian::Big),
                    _ => return Err(text.malformed(line, "ascii, binary_little_endian or binary_big_endian")),
                }
            }
            [b"element", name, count] => {
                let count = std::str::from_utf8(count).ok().and_then(|count| count.parse().ok());
                let count = count.ok_or_else(|| text.malformed(line, "element NAME COUNT"))?;
                elements.push(Element { name: name.to_vec(), count, properties: vec![] });
            }
            [b"property", ref types @ .., name] => {
                let types = match *types {
                    [number] => Number::named(number).map(|number| (number, None)),
                    [b"list", count, number] => Number::named(number)
                        .zip(Number::named(count))
                        .map(|(number, count)| (number, Some(count))),
                    _ => None,
                };
                let known = types.zip(elements.last_mut());
                let ((number, count), element) = known.ok_or_else(|| {
                    text.malformed(line, "property TYPE NAME, or property list TYPE TYPE NAME")
                })?;
                element.properties.push(Property { name: name.to_vec(), number, count });
            }
            [b"end_header"] => return Ok((order, elements)),
            [b"comment" | b"obj_info", ..] => {}
            _ => return Err(text.malformed(line, "a line of the head")),
        }
    }
}
