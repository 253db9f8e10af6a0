//! Decoding of one VTK XML data array: text, base64 or raw, plain or zlib-compressed, any number type.

use std::io::Read;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use roxmltree::Node;

use super::xml::{AppendedData, ArrayStorage, Shell};
use crate::mesh::error::{FaultSite, MeshError};
use crate::mesh::text::{Binary, Endian, ParsedNumber};

/// Values of an array: integers of any width, or reals.
pub(crate) enum Values {
    Int(Vec<i64>),
    Real(Vec<f64>),
}

impl Values {
    /// As reals.
    pub(crate) fn reals(self) -> Vec<f64> {
        match self {
            Values::Int(v) => v.into_iter().map(|i| i as f64).collect(),
            Values::Real(v) => v,
        }
    }

    /// As integers; none if a real is no whole number.
    pub(crate) fn integers(self) -> Option<Vec<i64>> {
        match self {
            Values::Int(v) => Some(v),
            Values::Real(v) => {
                v.into_iter().map(|x| (x.fract() == 0.0 && x.abs() < 1e15).then_some(x as i64)).collect()
            }
        }
    }

    fn len(&self) -> usize {
        match self {
            Values::Int(v) => v.len(),
            Values::Real(v) => v.len(),
        }
    }
}

/// Decodes an array; if `expected` is given, it must hold that many values.
pub(crate) fn decode(
    shell: &Shell<'_>,
    storage: ArrayStorage<'_>,
    node: Node<'_, '_>,
    expected: Option<usize>,
) -> Result<Values, MeshError> {
    let section = format!("DataArray {}", node.attribute("Name").unwrap_or("without name"));
    let at = shell.at(node, &section);
    let kind = node.attribute("type").unwrap_or("Float32");
    let text = node.text().unwrap_or("").as_bytes();
    let values = match node.attribute("format").unwrap_or("ascii") {
        "ascii" => from_text(kind, text, &at)?,
        "binary" => from_bytes(kind, &block(ByteSource::base64(text), storage, &at)?, storage.endian, &at)?,
        "appended" => {
            let source = appended(storage, node.attribute("offset"), &at)?;
            from_bytes(kind, &block(source, storage, &at)?, storage.endian, &at)?
        }
        other => return Err(at.malformed(format!("format {other}"), "ascii, binary or appended")),
    };
    match expected {
        Some(n) if n != values.len() => {
            Err(at.malformed(format!("{} values", values.len()), format!("{n} values")))
        }
        _ => Ok(values),
    }
}

fn appended<'a>(
    storage: ArrayStorage<'a>,
    offset: Option<&str>,
    at: &FaultSite<'_>,
) -> Result<ByteSource<'a>, MeshError> {
    let offset: usize = offset
        .and_then(|o| o.trim().parse().ok())
        .ok_or_else(|| at.malformed("no offset", "an offset into the appended data"))?;
    let tail = |data: &'a [u8]| {
        let found = format!("offset {offset}");
        data.get(offset..).ok_or_else(|| at.malformed(found, format!("at most {} bytes", data.len())))
    };
    match storage.appended {
        AppendedData::None => Err(at.malformed("appended format", "an AppendedData element")),
        AppendedData::Raw(data) => Ok(ByteSource::Raw(tail(data)?)),
        AppendedData::Base64(data) => Ok(ByteSource::base64(tail(data)?)),
    }
}

fn from_text(kind: &str, text: &[u8], at: &FaultSite<'_>) -> Result<Values, MeshError> {
    let words = || crate::mesh::text::tokens(text);
    if kind.starts_with("Float") {
        let values = words()
            .map(|w| f64::parse(w).ok_or_else(|| at.malformed(crate::mesh::shown(w), "a finite number")));
        return Ok(Values::Real(values.collect::<Result<_, _>>()?));
    }
    let values =
        words().map(|w| i64::parse(w).ok_or_else(|| at.malformed(crate::mesh::shown(w), "an integer")));
    Ok(Values::Int(values.collect::<Result<_, _>>()?))
}

fn from_bytes(kind: &str, bytes: &[u8], endian: Endian, at: &FaultSite<'_>) -> Result<Values, MeshError> {
    Ok(match kind {
        "Int8" => Values::Int(all::<i8>(bytes, endian).map(i64::from).collect()),
        "UInt8" => Values::Int(all::<u8>(bytes, endian).map(i64::from).collect()),
        "Int16" => Values::Int(all::<i16>(bytes, endian).map(i64::from).collect()),
        "UInt16" => Values::Int(all::<u16>(bytes, endian).map(i64::from).collect()),
        "Int32" => Values::Int(all::<i32>(bytes, endian).map(i64::from).collect()),
        "UInt32" => Values::Int(all::<u32>(bytes, endian).map(i64::from).collect()),
        "Int64" | "UInt64" => Values::Int(all::<i64>(bytes, endian).collect()),
        "Float32" => finite(all::<f32>(bytes, endian).map(f64::from).collect(), at)?,
        "Float64" => finite(all::<f64>(bytes, endian).collect(), at)?,
        other => {
            let remedy = "write the array as Float64 or Int64";
            return Err(at.unsupported(format!("type {other}"), "an Int, UInt or Float type", remedy));
        }
    })
}

fn all<T: Binary>(bytes: &[u8], endian: Endian) -> impl Iterator<Item = T> {
    bytes.chunks_exact(T::SIZE).map(move |chunk| T::from_bytes(chunk, endian))
}

fn finite(values: Vec<f64>, at: &FaultSite<'_>) -> Result<Values, MeshError> {
    match values.iter().position(|x| !x.is_finite()) {
        None => Ok(Values::Real(values)),
        Some(i) => Err(at.malformed(format!("value {i} is {}", values[i]), "finite numbers")),
    }
}

/// Bytes that come plain or through base64.
enum ByteSource<'a> {
    Raw(&'a [u8]),
    /// Groups of four characters; bytes already decoded but not yet taken.
    Base64 {
        text: &'a [u8],
        pending: Vec<u8>,
    },
}

impl<'a> ByteSource<'a> {
    fn base64(text: &'a [u8]) -> Self {
        ByteSource::Base64 { text, pending: Vec::new() }
    }

    /// The next `n` bytes, or none if there are fewer.
    fn take(&mut self, n: usize) -> Option<Vec<u8>> {
        match self {
            ByteSource::Raw(bytes) => {
                let (head, tail) = bytes.split_at_checked(n)?;
                *bytes = tail;
                Some(head.to_vec())
            }
            ByteSource::Base64 { text, pending } => {
                if n / 3 > text.len() / 4 + 1 {
                    return None;
                }
                while pending.len() < n {
                    // Header and data may be encoded apart, so padding can stand in the middle: decode by
                    // groups.
                    decode_group(text, pending)?;
                }
                let tail = pending.split_off(n);
                Some(std::mem::replace(pending, tail))
            }
        }
    }
}

/// Decodes the next four characters, white space apart.
fn decode_group(text: &mut &[u8], out: &mut Vec<u8>) -> Option<()> {
    let mut group = [0; 4];
    let mut filled = 0;
    while filled < 4 {
        let (&byte, tail) = text.split_first()?;
        *text = tail;
        if !byte.is_ascii_whitespace() {
            group[filled] = byte;
            filled += 1;
        }
    }
    let mut bytes = [0; 3];
    let count = STANDARD.decode_slice(group, &mut bytes).ok()?;
    out.extend_from_slice(&bytes[..count]);
    Some(())
}

/// The bytes of one array: a size and the data, or a table of block sizes and compressed blocks.
fn block(
    mut source: ByteSource<'_>,
    storage: ArrayStorage<'_>,
    at: &FaultSite<'_>,
) -> Result<Vec<u8>, MeshError> {
    let short = || at.malformed("the end of the data", "the bytes that its header announces");
    let first = size(&mut source, storage).ok_or_else(short)?;
    if !storage.compressed {
        return source.take(first).ok_or_else(short);
    }
    let block_size = size(&mut source, storage).ok_or_else(short)?;
    let last_size = size(&mut source, storage).ok_or_else(short)?;
    let mut sizes = Vec::new();
    for _ in 0..first {
        sizes.push(size(&mut source, storage).ok_or_else(short)?);
    }
    if let ByteSource::Base64 { pending, .. } = &mut source {
        // The header is padded to a whole group; what its last group holds beyond it is nothing.
        pending.clear();
    }
    let mut out = Vec::new();
    for (i, packed) in sizes.iter().enumerate() {
        let length = if i + 1 == first && last_size > 0 { last_size } else { block_size };
        let bytes = source.take(*packed).ok_or_else(short)?;
        let before = out.len();
        // One byte more than announced is enough to notice a block that is too long.
        let limit = (length as u64).saturating_add(1);
        let inflated = flate2::read::ZlibDecoder::new(bytes.as_slice()).take(limit).read_to_end(&mut out);
        if inflated.is_err() || out.len() - before != length {
            return Err(at.malformed(format!("compressed block {i}"), format!("zlib data of {length} bytes")));
        }
    }
    Ok(out)
}

fn size(source: &mut ByteSource<'_>, storage: ArrayStorage<'_>) -> Option<usize> {
    if storage.wide {
        usize::try_from(u64::from_bytes(&source.take(8)?, storage.endian)).ok()
    } else {
        Some(u32::from_bytes(&source.take(4)?, storage.endian) as usize)
    }
}
