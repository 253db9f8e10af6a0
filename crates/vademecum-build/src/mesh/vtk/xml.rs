//! The XML shell of VTK files: attributes of data arrays and where their bytes are.
//!
//! Raw appended data is not XML, so it is cut out before the document is parsed. An array is then decoded by
//! [`super::array`], whatever its encoding.

use std::path::{Path, PathBuf};

use roxmltree::{Document, Node};

use crate::mesh::error::{FaultSite, MeshError, shown};
use crate::mesh::place::Location;
use crate::mesh::text::Endian;

/// Appended data of a file.
#[derive(Clone, Copy)]
pub(crate) enum AppendedData<'a> {
    None,
    Raw(&'a [u8]),
    Base64(&'a [u8]),
}

/// The parts of a VTK XML file that stay the same for all its arrays.
pub(crate) struct Shell<'a> {
    pub(crate) file: PathBuf,
    /// The document without appended data, closed properly.
    pub(crate) text: String,
    pub(crate) appended: AppendedData<'a>,
}

/// Storage of the arrays of a file.
#[derive(Clone, Copy)]
pub(crate) struct ArrayStorage<'a> {
    pub(crate) endian: Endian,
    /// Sizes in headers are 64 bits wide, else 32.
    pub(crate) wide: bool,
    pub(crate) compressed: bool,
    pub(crate) appended: AppendedData<'a>,
}

impl<'a> Shell<'a> {
    /// Splits a file into document and appended data.
    pub(crate) fn new(file: &Path, bytes: &'a [u8]) -> Result<Self, MeshError> {
        let at = FaultSite { file, place: Location::Whole, section: "the XML document" };
        const TAG: &[u8] = b"<AppendedData";
        let (document, appended) = match find(bytes, TAG) {
            None => (bytes.to_vec(), AppendedData::None),
            Some(start) => {
                let end = find(&bytes[start..], b">").map(|n| start + n + 1);
                let end = end.ok_or_else(|| at.malformed("an unclosed <AppendedData", "a `>`"))?;
                let tag = &bytes[start..end];
                let body = &bytes[end..];
                let mark = body.iter().position(|&b| b == b'_');
                let mark = mark.ok_or_else(|| at.malformed("no `_`", "`_` before the appended data"))?;
                let data = &body[mark + 1..];
                let appended = if find(tag, b"raw").is_some() {
                    AppendedData::Raw(data)
                } else {
                    AppendedData::Base64(data)
                };
                let closing = if tag.ends_with(b"/>") { "" } else { "</AppendedData>" };
                let mut document = bytes[..end].to_vec();
                document.extend_from_slice(closing.as_bytes());
                document.extend_from_slice(b"</VTKFile>");
                (document, appended)
            }
        };
        let text = String::from_utf8(document)
            .map_err(|e| at.malformed(shown(e.as_bytes()), "UTF-8 text outside appended data"))?;
        Ok(Shell { file: file.to_path_buf(), text, appended })
    }

    /// Parses the document.
    pub(crate) fn document(&self) -> Result<Document<'_>, MeshError> {
        Document::parse(&self.text).map_err(|e| {
            let place = Location::Line(e.pos().row as usize);
            let at = FaultSite { file: &self.file, place, section: "the XML document" };
            at.malformed(e.to_string(), "well-formed XML")
        })
    }

    /// The storage its root element declares; `kind` is the dataset wanted, for instance `UnstructuredGrid`.
    pub(crate) fn storage(&self, document: &Document<'_>, kind: &str) -> Result<ArrayStorage<'a>, MeshError> {
        let root = document.root_element();
        let at = self.at(root, "VTKFile");
        if root.tag_name().name() != "VTKFile" {
            return Err(at.malformed(format!("<{}>", root.tag_name().name()), "<VTKFile>"));
        }
        let found = root.attribute("type").unwrap_or("no type");
        if found != kind {
            return Err(at.unsupported(format!("a VTK file of {found}"), kind, "save the volume mesh"));
        }
        let endian = match root.attribute("byte_order") {
            Some("BigEndian") => Endian::Big,
            _ => Endian::Little,
        };
        let compressed = match root.attribute("compressor") {
            None | Some("") => false,
            Some("vtkZLibDataCompressor") => true,
            Some(other) => {
                let remedy = "save with zlib or without compression";
                return Err(at.unsupported(format!("compressor {other}"), "vtkZLibDataCompressor", remedy));
            }
        };
        let wide = root.attribute("header_type") == Some("UInt64");
        Ok(ArrayStorage { endian, wide, compressed, appended: self.appended })
    }

    /// A place in the document, for messages.
    pub(crate) fn at<'s>(&'s self, node: Node<'_, '_>, section: &'s str) -> FaultSite<'s> {
        let row = node.document().text_pos_at(node.range().start).row;
        FaultSite { file: &self.file, place: Location::Line(row as usize), section }
    }

    /// The only piece of the grid.
    pub(crate) fn piece<'d, 'i>(&self, document: &'d Document<'i>) -> Result<Node<'d, 'i>, MeshError> {
        let is_piece = |n: &Node<'_, '_>| n.has_tag_name("Piece");
        let mut pieces = document.descendants().filter(is_piece);
        let root = document.root_element();
        let Some(piece) = pieces.next() else {
            return Err(self.at(root, "UnstructuredGrid").malformed("no Piece", "one Piece"));
        };
        match pieces.next() {
            None => Ok(piece),
            Some(second) => {
                let remedy = "merge the pieces into one before saving";
                Err(self.at(second, "UnstructuredGrid").unsupported("a second Piece", "one Piece", remedy))
            }
        }
    }

    /// An attribute that is a count.
    pub(crate) fn count(&self, node: Node<'_, '_>, name: &str) -> Result<usize, MeshError> {
        let value = node.attribute(name).unwrap_or("");
        value.trim().parse().map_err(|_| {
            self.at(node, "Piece").malformed(format!("{name}={}", shown(value.as_bytes())), "a count")
        })
    }
}

/// Position of `needle`.
pub(crate) fn find(haystack: &[u8], needle: &[u8]) -> Option<usize> {
    haystack.windows(needle.len()).position(|w| w == needle)
}

/// Data arrays directly inside the child `name` of a piece.
pub(crate) fn arrays<'d, 'i>(piece: Node<'d, 'i>, name: &str) -> Vec<Node<'d, 'i>> {
    let section = piece.children().find(|n| n.has_tag_name(name));
    let is_array = |n: &Node<'_, '_>| n.has_tag_name("DataArray");
    section.map_or_else(Vec::new, |s| s.children().filter(is_array).collect())
}
