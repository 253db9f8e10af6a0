//! PVD files: which VTU file shows which time.

use std::path::{Path, PathBuf};

use super::{FieldError, io_error, write_whole};
use crate::store::{Kind, read_text};

/// Head of a collection.
pub const PVD_HEAD: &str =
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n";
/// Tail of a collection.
pub const PVD_TAIL: &str = "</Collection>\n</VTKFile>\n";

/// A line of a collection: the time in seconds, and the file, relative to the folder of the collection.
pub fn pvd_line(time: f64, file: &str) -> String {
    format!("<DataSet timestep=\"{time}\" part=\"0\" file=\"{}\"/>\n", escaped(file))
}

/// Writes a collection: times in seconds and files, relative to the folder of the collection.
///
/// # Errors
/// [`FieldError::Io`].
pub fn write_pvd(path: &Path, entries: &[(f64, String)]) -> Result<(), FieldError> {
    write_whole(path, Kind::Pvd, |out| {
        out.write_all(PVD_HEAD.as_bytes())?;
        entries.iter().try_for_each(|(time, file)| out.write_all(pvd_line(*time, file).as_bytes()))?;
        out.write_all(PVD_TAIL.as_bytes())
    })
}

/// Text as it may stand in an XML attribute.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

/// Reads a collection in file order: times and paths (relative ones against the folder of the collection).
///
/// # Errors
/// [`FieldError::Io`], [`FieldError::Malformed`].
pub fn read_pvd(path: &Path) -> Result<Vec<(f64, PathBuf)>, FieldError> {
    let text = read_text(path).map_err(io_error(path))?;
    let fault = |found: String, expected: &str| FieldError::Malformed {
        file: path.to_path_buf(),
        found,
        expected: expected.into(),
    };
    let document = roxmltree::Document::parse(&text).map_err(|e| fault(e.to_string(), "XML"))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let sets = document.descendants().filter(|n| n.has_tag_name("DataSet"));
    sets.map(|set| {
        let line = document.text_pos_at(set.range().start).row;
        let time =
            set.attribute("timestep").unwrap_or("0").trim().parse::<f64>().ok().filter(|t| t.is_finite());
        let time = time.ok_or_else(|| fault(format!("a timestep on line {line}"), "a finite number"))?;
        let file =
            set.attribute("file").ok_or_else(|| fault(format!("no file on line {line}"), "file=\"…\""))?;
        Ok((time, folder.join(file)))
    })
    .collect()
}
