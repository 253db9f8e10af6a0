//! Triangles of STL, OBJ, PLY and OFF files.

use std::path::Path;

use super::winding::Point;
use crate::mesh::error::MeshError;
use crate::mesh::text::{Endian, Text, tokens};

/// A triangle surface as its file has it.
pub(super) struct Triangles {
    /// Format in words.
    pub(super) format: &'static str,
    pub(super) corners: Vec<[Point; 3]>,
}

impl Triangles {
    fn new(format: &'static str) -> Self {
        Self { format, corners: vec![] }
    }

    /// A polygon, as a fan.
    pub(super) fn push(&mut self, points: &[Point], polygon: &[usize]) {
        for pair in polygon.windows(2).skip(1) {
            self.corners.push([polygon[0], pair[0], pair[1]].map(|at| points[at]));
        }
    }
}

/// Binary STL: 80 bytes of anything, the number of triangles, 50 bytes for each.
pub(super) fn stl_binary(file: &Path, bytes: &[u8]) -> Result<Triangles, MeshError> {
    let mut found = Triangles::new("STL");
    let mut text = Text::new(file, bytes);
    text.binary = true;
    text.section = "the triangles".into();
    text.take(80, "the head")?;
    let count: u32 = text.value(Endian::Little, "the number of triangles")?;
    for _ in 0..text.bounded(count.into(), 50, "triangles")? {
        text.take(12, "a normal")?;
        let mut corners = [[0.0f64; 3]; 3];
        for value in corners.as_flattened_mut() {
            *value = text.value::<f32>(Endian::Little, "a coordinate")?.into();
            if !value.is_finite() {
                return Err(text.at().malformed(value.to_string(), "a finite coordinate"));
            }
        }
        text.take(2, "attributes")?;
        found.corners.push(corners);
    }
    Ok(found)
}

/// STL in words: `facet`, `outer loop`, three times `vertex x y z`, `endloop`, `endfacet`.
pub(super) fn stl_text(file: &Path, bytes: &[u8]) -> Result<Triangles, MeshError> {
    let mut found = Triangles::new("STL");
    let mut text = Text::new(file, bytes);
    text.section = "the facets".into();
    let mut corners = vec![];
    while let Some(line) = text.next_line() {
        let word = tokens(line).next().unwrap_or_default().to_ascii_lowercase();
        match &word[..] {
            b"vertex" => corners.push(text.exactly(&line[6..], "vertex x y z")?),
            b"endloop" => match corners[..] {
                [a, b, c] => {
                    found.corners.push([a, b, c]);
                    corners.clear();
                }
                _ => {
                    let count = format!("a facet of {} vertices", corners.len());
                    return Err(text.at().malformed(count, "three vertices"));
                }
            },
            b"solid" | b"facet" | b"outer" | b"endfacet" | b"endsolid" => {}
            _ => return Err(text.malformed(line, "a line of an STL file, such as `vertex x y z`")),
        }
    }
    Ok(found)
}

/// Wavefront OBJ: `v x y z` and `f a b c …`; everything else is passed over.
pub(super) fn obj(file: &Path, bytes: &[u8]) -> Result<Triangles, MeshError> {
    let mut found = Triangles::new("OBJ");
    let mut text = Text::new(file, bytes);
    text.section = "the faces".into();
    let mut points: Vec<Point> = vec![];
    let mut polygon = vec![];
    while let Some(first) = text.next_line() {
        // A line goes on after a backslash.
        let mut line = first.to_vec();
        while line.last() == Some(&b'\\') {
            line.pop();
            line.extend_from_slice(text.raw_line().unwrap_or_default());
        }
        let mut words = tokens(&line);
        match words.next() {
            Some(b"v") => {
                // Weights and colours may follow.
                let numbers: Vec<&[u8]> = words.take(3).collect();
                points.push(text.exactly(&numbers.join(&b' '), "v x y z")?);
            }
            Some(b"f") => {
                polygon.clear();
                for word in words {
                    let number = word.split(|b| *b == b'/').next().unwrap_or_default();
                    let at = std::str::from_utf8(number).ok().and_then(|number| number.parse::<i64>().ok());
                    // Negative numbers count from the vertex before this line.
                    let at = at.and_then(|at| match at {
                        1.. => usize::try_from(at - 1).ok(),
                        _ => usize::try_from(points.len() as i64 + at).ok().filter(|_| at < 0),
                    });
                    let at = at.filter(|at| *at < points.len());
                    let expected = || format!("a vertex before this line, of {}", points.len());
                    polygon.push(at.ok_or_else(|| text.malformed(word, expected()))?);
                }
                if polygon.len() < 3 {
                    return Err(text.malformed(first, "a face of three vertices or more"));
                }
                found.push(&points, &polygon);
            }
            _ => {}
        }
    }
    Ok(found)
}

/// OFF: numbers of vertices and faces, vertices (colours or normals may follow), faces with their lengths.
pub(super) fn off(file: &Path, bytes: &[u8]) -> Result<Triangles, MeshError> {
    let mut found = Triangles::new("OFF");
    let bytes: Vec<u8> = without_comments(bytes);
    let mut text = Text::new(file, &bytes);
    let head = text.line("OFF")?;
    text.section = "the vertices".into();
    // The numbers may stand behind the name of the format.
    let counts = match tokens(head).nth(1) {
        Some(_) => &head[tokens(head).next().map_or(0, <[u8]>::len)..],
        None => text.line("the numbers of vertices, faces and edges")?,
    };
    let expected = "the numbers of vertices, faces and edges";
    let [vertices, faces, _] = text.exactly::<u64, 3>(counts, expected)?;
    let mut points: Vec<Point> = vec![];
    for _ in 0..text.bounded(vertices, 6, "vertices")? {
        let numbers: Vec<&[u8]> = tokens(text.line("a vertex: x y z")?).take(3).collect();
        points.push(text.exactly(&numbers.join(&b' '), "a vertex: x y z")?);
    }
    text.section = "the faces".into();
    for _ in 0..text.bounded(faces, 6, "faces")? {
        let line = text.line("a face: its length and its vertices")?;
        let mut numbers = tokens(line).map(|word| std::str::from_utf8(word).ok()?.parse::<usize>().ok());
        let length = numbers.next().flatten().filter(|length| *length >= 3);
        let polygon: Option<Vec<usize>> = length.and_then(|length| numbers.take(length).collect());
        let polygon = polygon.filter(|polygon| Some(polygon.len()) == length);
        let polygon = polygon.filter(|polygon| polygon.iter().all(|at| *at < points.len()));
        let polygon = polygon.ok_or_else(|| text.malformed(line, "a face: its length and its vertices"))?;
        found.push(&points, &polygon);
    }
    Ok(found)
}

/// Lines without what follows a `#`.
fn without_comments(bytes: &[u8]) -> Vec<u8> {
    let line = |line: &[u8]| line.split(|b| *b == b'#').next().unwrap_or_default().to_vec();
    bytes.split(|b| *b == b'\n').map(line).collect::<Vec<_>>().join(&b'\n')
}
