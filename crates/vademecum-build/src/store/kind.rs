//! Kinds of files, guessed from their first bytes: whether an existing file is one of the kind that is to be
//! written.

use std::fmt;

/// Inspected head of a file \[bytes\].
pub(super) const HEAD: usize = 4096;

/// Kind of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A vademecum file.
    Vademecum,
    /// A page.
    Html,
    /// A picture.
    Svg,
    /// A picture on a page.
    Pdf,
    /// Fields on a mesh.
    Vtu,
    /// A collection of VTU files.
    Pvd,
    /// A JSON object.
    Json,
    /// A table with its names in the first line.
    Csv,
    /// A text for people.
    Text,
    /// A NumPy matrix.
    Npy,
    /// A NumPy archive of arrays.
    Npz,
    /// A MATLAB file of level 5.
    Mat,
    /// A Matrix Market file.
    Market,
    /// A co-simulation unit: an archive whose first entry is a model description.
    Fmu,
    /// A file of the program's own, the only one of its name: no other may be replaced.
    Own,
    /// Whatever the caller likes: existing files are not inspected.
    Any,
}

impl Kind {
    /// True if a file that begins so may be replaced by one of this kind without being asked.
    pub(super) fn replaces(self, head: &[u8]) -> bool {
        match self {
            Self::Any => true,
            Self::Own => head.is_empty(),
            kind => head.is_empty() || Signature::like(head) == Signature::Of(kind),
        }
    }

    /// True if a file of this kind is flushed to the disk before it counts as written. Fields and tables are
    /// many and soon made again.
    pub(super) fn is_flushed(self) -> bool {
        matches!(self, Self::Vademecum | Self::Html | Self::Fmu | Self::Any)
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Vademecum => "a vademecum file",
            Self::Html => "an HTML page",
            Self::Svg => "an SVG picture",
            Self::Pdf => "a PDF document",
            Self::Vtu => "a VTU file",
            Self::Pvd => "a PVD file",
            Self::Json => "a JSON object",
            Self::Csv => "a CSV table",
            Self::Text => "a text for people",
            Self::Npy => "a NumPy matrix",
            Self::Npz => "a NumPy archive",
            Self::Mat => "a MATLAB file",
            Self::Market => "a Matrix Market file",
            Self::Fmu => "an FMU",
            Self::Own | Self::Any => "what is to be written",
        })
    }
}

/// Classification of a file by its first bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Signature {
    /// One of the kinds that are written here.
    Of(Kind),
    /// Something else.
    Other(&'static str),
}

impl fmt::Display for Signature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Of(Kind::Text) => f.write_str("a text"),
            Self::Of(kind) => kind.fmt(f),
            Self::Other(name) => f.write_str(name),
        }
    }
}

/// First bytes of a ZIP archive, and positions of the length and of the name of its first entry.
const ZIP: &[u8] = b"PK\x03\x04";
const NAME_LENGTH: usize = 26;
const FIRST_NAME: usize = 30;
/// The first entry of an FMU.
const DESCRIPTION: &[u8] = b"modelDescription.xml";

/// First bytes that tell what a file is.
const MARKS: [(&[u8], Signature); 15] = [
    (&vademecum_format::MAGIC, Signature::Of(Kind::Vademecum)),
    (b"\x93NUMPY", Signature::Of(Kind::Npy)),
    (b"MATLAB 5.0 MAT-file", Signature::Of(Kind::Mat)),
    (b"%%MatrixMarket", Signature::Of(Kind::Market)),
    (b"\x7fELF", Signature::Other("a program")),
    (b"MZ", Signature::Other("a program")),
    (b"#!", Signature::Other("a script")),
    (b"\x89PNG", Signature::Other("a PNG picture")),
    (b"%PDF", Signature::Of(Kind::Pdf)),
    (ZIP, Signature::Other("a ZIP archive")),
    (b"\x1f\x8b", Signature::Other("a gzip archive")),
    (b"$", Signature::Other("a Gmsh mesh")),
    (b"# vtk DataFile", Signature::Other("a VTK mesh")),
    (b"MFEM ", Signature::Other("an MFEM mesh")),
    (b"MeshVersionFormatted", Signature::Other("a Medit mesh")),
];

impl Signature {
    /// Judges the first bytes of a file.
    pub(super) fn like(head: &[u8]) -> Self {
        let first = first_name(head);
        if first.is_some_and(|name| name.starts_with(DESCRIPTION)) {
            return Self::Of(Kind::Fmu);
        }
        if first.is_some_and(|name| name.ends_with(b".npy")) {
            return Self::Of(Kind::Npz);
        }
        if let Some((_, looks)) = MARKS.iter().find(|(mark, _)| head.starts_with(mark)) {
            return *looks;
        }
        match text(head) {
            Some(text) => Self::like_text(text),
            // Fields follow the text of a VTU file as they are.
            None if head.trim_ascii_start().starts_with(b"<") => {
                Self::like_text(&String::from_utf8_lossy(head))
            }
            None => Self::Other("binary data"),
        }
    }

    fn like_text(text: &str) -> Self {
        let text = text.trim_start_matches('\u{feff}').trim_start();
        let lower = text.to_ascii_lowercase();
        if lower.starts_with("<!doctype html") || lower.starts_with("<html") {
            Self::Of(Kind::Html)
        } else if lower.starts_with('<') {
            Self::like_xml(&lower)
        } else if text.strip_prefix('{').is_some_and(|rest| rest.trim_start().starts_with(['"', '}'])) {
            Self::Of(Kind::Json)
        } else if text.starts_with('*') {
            Self::Other("an Abaqus or CalculiX deck")
        } else if is_toml(text) {
            Self::Other("a TOML file")
        } else if text.starts_with('[') {
            Self::Other("a JSON array")
        } else if is_table(text) {
            Self::Of(Kind::Csv)
        } else {
            Self::Of(Kind::Text)
        }
    }

    fn like_xml(lower: &str) -> Self {
        if lower.contains("<svg") {
            Self::Of(Kind::Svg)
        } else if lower.contains("<vtkfile") && lower.contains("unstructuredgrid") {
            Self::Of(Kind::Vtu)
        } else if lower.contains("<vtkfile") && lower.contains("collection") {
            Self::Of(Kind::Pvd)
        } else {
            Self::Other("an XML file")
        }
    }
}

/// Name of the first entry of a ZIP archive.
fn first_name(head: &[u8]) -> Option<&[u8]> {
    let length = head.get(NAME_LENGTH..)?.first_chunk().filter(|_| head.starts_with(ZIP))?;
    head.get(FIRST_NAME..)?.get(..u16::from_le_bytes(*length).into())
}

/// The head as text, whose last character may be cut.
fn text(head: &[u8]) -> Option<&str> {
    let text = match std::str::from_utf8(head) {
        Ok(text) => text,
        Err(error) if error.error_len().is_none() => {
            std::str::from_utf8(&head[..error.valid_up_to()]).ok()?
        }
        Err(_) => return None,
    };
    (!text.contains('\0')).then_some(text)
}

/// True if the first line that says something is a table's name or a key with its value.
fn is_toml(text: &str) -> bool {
    let mut lines = text.lines().map(str::trim);
    let line = lines.find(|line| !line.is_empty() && !line.starts_with('#')).unwrap_or_default();
    let is_key = |key: &str| {
        let inside = |c: char| c.is_ascii_alphanumeric() || "_-.\"' []".contains(c);
        key.contains(|c: char| c.is_ascii_alphanumeric()) && key.chars().all(inside)
    };
    match line.split_once('=') {
        Some((key, _)) => is_key(key),
        None => line.starts_with('[') && line.split('#').next().is_some_and(|name| is_key(name.trim())),
    }
}

/// True if every whole line has as many commas as the first, and at least one.
fn is_table(text: &str) -> bool {
    let whole = text.rfind('\n').map_or(text, |end| &text[..end]);
    let commas = |line: &str| {
        let outside_quotes = line.split('"').step_by(2);
        outside_quotes.map(|part| part.matches(',').count()).sum::<usize>()
    };
    let mut counts = whole.lines().map(commas);
    let first = counts.next().unwrap_or(0);
    first > 0 && counts.all(|count| count == first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_bytes_tell_what_a_file_is() {
        let kinds: [(&[u8], &str); 28] = [
            (&vademecum_format::MAGIC, "a vademecum file"),
            (b"<!DOCTYPE html>\n<html>", "an HTML page"),
            (b"\xef\xbb\xbf <HTML lang=\"en\">", "an HTML page"),
            (b"<svg width=\"900\">", "an SVG picture"),
            (b"<?xml version=\"1.0\"?>\n<!-- made by hand -->\n<svg>", "an SVG picture"),
            (b"<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\">", "a VTU file"),
            (b"<VTKFile type=\"UnstructuredGrid\">\n_\x00\xff", "a VTU file"),
            (b"<VTKFile type=\"Collection\" version=\"0.1\">", "a PVD file"),
            (b"<note>", "an XML file"),
            (b"{\n  \"title\": 1", "a JSON object"),
            (b"{}", "a JSON object"),
            (b"time_s,energy_J\n0.0,0.0\n1.0,", "a CSV table"),
            (b"method,steps\n\"ritz, block\",8\n", "a CSV table"),
            (b"# beam\n[mesh]\nfile = \"a.msh\"", "a TOML file"),
            (b"[[material]]\nyoung = 1.0", "a TOML file"),
            (b"title = \"a, b\"\n", "a TOML file"),
            (b"[1, 2]\n", "a JSON array"),
            (b"[\n  {\"a\": 1},\n", "a JSON array"),
            (b"$MeshFormat\n4.1 0 8", "a Gmsh mesh"),
            (b"*NODE\n1, 0., 0., 0.\n", "an Abaqus or CalculiX deck"),
            (b"\x7fELF\x02", "a program"),
            (b"\x93NUMPY\x01\x00", "a NumPy matrix"),
            (b"MATLAB 5.0 MAT-file, by vademecum", "a MATLAB file"),
            (b"PK\x03\x04......................\x05\0\0\0A.npy\x93NUMPY", "a NumPy archive"),
            (b"PK\x03\x04......................\x05\0\0\0a.txtA.npy", "a ZIP archive"),
            (b"Dear reader, hello.\nGood bye.\n", "a text"),
            (b"\x00\x01\x02\xff", "binary data"),
            ("a text that is cut in the middle of an é".as_bytes().split_last().unwrap().1, "a text"),
        ];
        for (head, expected) in kinds {
            assert_eq!(Signature::like(head).to_string(), expected, "{}", String::from_utf8_lossy(head));
        }
    }

    #[test]
    fn an_empty_file_is_in_nobodys_way_and_an_own_one_replaces_nothing_else() {
        assert!(Kind::Vademecum.replaces(b"") && Kind::Own.replaces(b""));
        assert!(Kind::Csv.replaces(b"a,b\n1,2\n") && !Kind::Csv.replaces(b"{\"a\":1}"));
        assert!(!Kind::Own.replaces(b"[mesh]") && Kind::Any.replaces(b"[mesh]"));
        assert!(Kind::Text.replaces(b"A text.\n") && !Kind::Text.replaces(b"<html>"));
    }
}
