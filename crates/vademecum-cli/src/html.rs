//! Common parts of the pages of `view` and `report`.

use std::path::Path;

use vademecum_format::File;

/// Text that may stand in a page.
pub(crate) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '{' => out.push_str("&#123;"),
            c => out.push(c),
        }
    }
    out
}

/// The problem's title, or the file's name.
pub(crate) fn title(path: &Path, file: &File<'_>) -> String {
    let problem: Option<toml::Table> = file.metadata().problem.parse().ok();
    let title = problem.as_ref().and_then(|table| table.get("title")).and_then(|title| title.as_str());
    title.map_or_else(|| path.file_stem().unwrap_or_default().to_string_lossy().into_owned(), str::to_string)
}
