//! Triangles of binary glTF files, version 2.0: those of all nodes of the scene, placed as the nodes say.
//! Skins and morph targets are not applied.

use std::path::Path;

use serde_json::Value;

use super::triangles::Triangles;
use super::winding::Point;
use crate::mesh::error::MeshError;
use crate::mesh::text::{Endian, Text};

/// Nodes deep a scene may be nested: a file that refers to itself ends here.
const MAX_DEPTH: usize = 64;
/// Triangles of a scene that shows one mesh many times.
const MAX_TRIANGLES: usize = 50_000_000;
/// Remedy for what is not read.
const REMEDY: &str = "write the mesh as STL, OBJ or PLY";

/// Columns of the map of a node: `x ↦ a x₀ + b x₁ + c x₂ + d`.
type Map = [Point; 4];

const IDENTITY: Map = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];

/// A file: its description, and its numbers.
struct Scene<'a> {
    text: Text<'a>,
    root: Value,
    data: &'a [u8],
    found: Triangles,
}

/// Reads the triangles of a `.glb` file.
pub(super) fn parse(file: &Path, bytes: &[u8]) -> Result<Triangles, MeshError> {
    let mut text = Text::new(file, bytes);
    text.binary = true;
    text.section = "the head".into();
    if text.take(4, "the name of the format")? != b"glTF" {
        return Err(text.at().unsupported("glTF with its numbers in other files", "one .glb file", REMEDY));
    }
    let version: u32 = text.value(Endian::Little, "the version")?;
    if version != 2 {
        return Err(text.at().unsupported(format!("version {version} of glTF"), "version 2", REMEDY));
    }
    text.take(4, "the length")?;
    text.section = "the description".into();
    let description = chunk(&mut text, b"JSON")?;
    let root: Value = serde_json::from_slice(description)
        .map_err(|error| text.at().malformed(error.to_string(), "a description in JSON"))?;
    text.section = "the numbers".into();
    let data = chunk(&mut text, b"BIN\0")?;
    let found = Triangles { format: "glTF", corners: vec![] };
    let mut scene = Scene { text, root, data, found };
    let start = index(&scene.root["scene"]).unwrap_or(0);
    for node in list(&scene.root["scenes"][start]["nodes"]) {
        scene.node(node, &IDENTITY, 0)?;
    }
    Ok(scene.found)
}

/// The next piece of the file, which is of this kind.
fn chunk<'a>(text: &mut Text<'a>, kind: &[u8; 4]) -> Result<&'a [u8], MeshError> {
    let length: u32 = text.value(Endian::Little, "the length of a piece")?;
    let found = text.take(4, "the kind of a piece")?;
    if found != kind {
        return Err(text.malformed(
            found,
            format!("a piece `{}`", String::from_utf8_lossy(kind).trim_end_matches('\0')),
        ));
    }
    text.take(length as usize, "this piece")
}

fn index(value: &Value) -> Option<usize> {
    value.as_u64().and_then(|at| usize::try_from(at).ok())
}

/// The numbers of a list of indices.
fn list(value: &Value) -> Vec<usize> {
    value.as_array().map_or(vec![], |items| items.iter().filter_map(index).collect())
}

/// `N` numbers of a list.
fn numbers<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let items: Option<Vec<f64>> = value.as_array()?.iter().map(Value::as_f64).collect();
    items?.try_into().ok()
}

impl Scene<'_> {
    fn refused(&self, found: impl Into<String>, expected: &str) -> MeshError {
        self.text.at().unsupported(found, expected, REMEDY)
    }

    fn node(&mut self, at: usize, outer: &Map, depth: usize) -> Result<(), MeshError> {
        if depth > MAX_DEPTH {
            return Err(self.text.at().malformed("nodes that hold each other", "a tree of nodes"));
        }
        let node = self.root["nodes"][at].clone();
        let map = combined(outer, &own_map(&node));
        if let Some(mesh) = index(&node["mesh"]) {
            for primitive in self.root["meshes"][mesh]["primitives"].as_array().cloned().unwrap_or_default() {
                self.primitive(&primitive, &map)?;
            }
        }
        list(&node["children"]).into_iter().try_for_each(|child| self.node(child, &map, depth + 1))
    }

    fn primitive(&mut self, primitive: &Value, map: &Map) -> Result<(), MeshError> {
        if primitive["extensions"].get("KHR_draco_mesh_compression").is_some() {
            return Err(self.refused("triangles that Draco compressed", "plain numbers"));
        }
        match index(&primitive["mode"]).unwrap_or(4) {
            // Points and lines.
            0..=3 => return Ok(()),
            4 => {}
            other => {
                return Err(self.refused(format!("triangles of mode {other}"), "separate triangles, mode 4"));
            }
        }
        let Some(positions) = index(&primitive["attributes"]["POSITION"]) else { return Ok(()) };
        let values = self.accessor(positions, "VEC3")?;
        let points: Vec<Point> = values.as_chunks::<3>().0.iter().map(|point| moved(map, *point)).collect();
        let order = match index(&primitive["indices"]) {
            Some(indices) => self.accessor(indices, "SCALAR")?.into_iter().map(|at| at as usize).collect(),
            None => (0..points.len()).collect::<Vec<usize>>(),
        };
        if self.found.corners.len() + order.len() / 3 > MAX_TRIANGLES {
            return Err(self.refused("more than 50 million triangles", "fewer"));
        }
        for corners in order.as_chunks::<3>().0 {
            let wrong = || {
                self.text
                    .at()
                    .malformed(format!("a triangle of the vertices {corners:?}"), "vertices of the file")
            };
            let [a, b, c] = corners.map(|at| points.get(at).copied());
            self.found.corners.push([a.ok_or_else(wrong)?, b.ok_or_else(wrong)?, c.ok_or_else(wrong)?]);
        }
        Ok(())
    }

    /// The numbers of an accessor, which is of this type.
    fn accessor(&self, at: usize, kind: &str) -> Result<Vec<f64>, MeshError> {
        let accessor = &self.root["accessors"][at];
        if accessor["type"].as_str() != Some(kind) || !accessor["sparse"].is_null() {
            return Err(
                self.refused(format!("accessor {at}"), &format!("one of type {kind} that is not sparse"))
            );
        }
        let width = if kind == "VEC3" { 3 } else { 1 };
        let (size, read): (usize, fn(&[u8]) -> f64) = match index(&accessor["componentType"]) {
            Some(5121) => (1, |b| f64::from(b[0])),
            Some(5123) => (2, |b| f64::from(u16::from_le_bytes([b[0], b[1]]))),
            Some(5125) => (4, |b| f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]]))),
            Some(5126) => (4, |b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))),
            _ => {
                return Err(
                    self.refused(format!("accessor {at}"), "numbers of type 5121, 5123, 5125 or 5126")
                );
            }
        };
        let view = &self.root["bufferViews"][index(&accessor["bufferView"]).unwrap_or(usize::MAX)];
        let offset = |value: &Value| index(&value["byteOffset"]).unwrap_or(0);
        let stride = index(&view["byteStride"]).unwrap_or(width * size).max(1);
        let count = index(&accessor["count"]).unwrap_or(0);
        let start = offset(view).checked_add(offset(accessor));
        let end = count.checked_sub(1).and_then(|last| last.checked_mul(stride)?.checked_add(width * size));
        let end = end.map_or(start, |length| start?.checked_add(length));
        let found = start.zip(end).and_then(|(start, end)| self.data.get(start..end));
        let outside = || self.text.at().malformed(format!("accessor {at}"), "numbers that lie in the file");
        let found = found.filter(|_| index(&view["buffer"]) == Some(0)).ok_or_else(outside)?;
        let mut values = Vec::with_capacity(width * count);
        for row in 0..count {
            for k in 0..width {
                let value = read(&found[row * stride + k * size..][..size]);
                if !value.is_finite() {
                    return Err(self.text.at().malformed(value.to_string(), "finite numbers"));
                }
                values.push(value);
            }
        }
        Ok(values)
    }
}

/// The map of a node: its matrix, else its translation, rotation and scale.
fn own_map(node: &Value) -> Map {
    if let Some(m) = numbers::<16>(&node["matrix"]) {
        return std::array::from_fn(|k| [m[4 * k], m[4 * k + 1], m[4 * k + 2]]);
    }
    let [x, y, z, w] = numbers(&node["rotation"]).unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let scale = numbers::<3>(&node["scale"]).unwrap_or([1.0; 3]);
    let turned = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)],
        [2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)],
        [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)],
    ];
    let column = |k: usize| turned[k].map(|value| value * scale[k]);
    [column(0), column(1), column(2), numbers(&node["translation"]).unwrap_or([0.0; 3])]
}

fn moved(map: &Map, point: Point) -> Point {
    std::array::from_fn(|i| map[3][i] + (0..3).map(|k| map[k][i] * point[k]).sum::<f64>())
}

/// `outer` after `inner`.
fn combined(outer: &Map, inner: &Map) -> Map {
    let turned = |v: Point| std::array::from_fn(|i| (0..3).map(|k| outer[k][i] * v[k]).sum());
    [turned(inner[0]), turned(inner[1]), turned(inner[2]), moved(outer, inner[3])]
}
