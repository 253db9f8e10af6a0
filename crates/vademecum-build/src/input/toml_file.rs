//! Reading the files people write (problems, scenarios), and messages that say where in them something is
//! wrong.

use std::io::ErrorKind;
use std::path::Path;

use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use toml::Table;
use toml::de::{DeTable, DeValue};

use super::lengths::too_long;
use crate::store::{read_text, read_text_within};
use crate::suggest::did_you_mean;

/// A file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TomlError {
    /// The file cannot be read.
    #[error("{path}: cannot be read")]
    Unreadable {
        /// The file.
        path: String,
        /// Why.
        source: std::io::Error,
    },
    /// The text is not what the file should hold: syntax, an unknown or missing key, a value of the wrong
    /// type.
    #[error("{path}: {message}")]
    Malformed {
        /// The file.
        path: String,
        /// Line, key, what was found and what was expected.
        message: String,
    },
    /// More text than the file of its kind may have.
    #[error("{path}: longer than {most} bytes, the most such a file may have; shorten its texts and lists")]
    TooLong {
        /// The file.
        path: String,
        /// Most bytes.
        most: usize,
    },
    /// A value that cannot be.
    #[error("{path}: `{key}` is {found}; expected {expected}")]
    Impossible {
        /// The file and line.
        path: String,
        /// Path of the key, such as `material[1].young`.
        key: String,
        /// The value found.
        found: String,
        /// The usable values.
        expected: String,
    },
}

/// The text of a file.
pub fn read(path: &Path) -> Result<String, TomlError> {
    read_text(path).map_err(|source| TomlError::Unreadable { path: path.display().to_string(), source })
}

/// The text of a file of at most so many bytes; no more than that is read, whatever the file is.
pub(super) fn read_at_most(path: &Path, most: usize) -> Result<String, TomlError> {
    let path_name = path.display().to_string();
    read_text_within(path, most as u64).map_err(|source| match source.kind() {
        ErrorKind::FileTooLarge => TomlError::TooLong { path: path_name, most },
        _ => TomlError::Unreadable { path: path_name, source },
    })
}

/// Refuses a text of more than `most` bytes.
pub(super) fn check_length(length: usize, most: usize, path: &str) -> Result<(), TomlError> {
    if length <= most { Ok(()) } else { Err(TomlError::TooLong { path: path.into(), most }) }
}

/// Parses a text; messages name `path`.
pub fn parse<T: DeserializeOwned + JsonSchema>(text: &str, path: &str) -> Result<T, TomlError> {
    let value = parsed(text, path)?;
    check_lists::<T>(&table(text, path)?, |key| place(path, text, key))?;
    Ok(value)
}

/// The table that a text is.
pub fn table(text: &str, path: &str) -> Result<Table, TomlError> {
    parsed(text, path)
}

/// Refuses lists that are longer than their keys take.
fn check_lists<T: JsonSchema>(table: &Table, place: impl Fn(&str) -> String) -> Result<(), TomlError> {
    match too_long(table, schemars::schema_for!(T).as_value()) {
        None => Ok(()),
        Some((key, found, most)) => Err(TomlError::Impossible {
            path: place(&key),
            key,
            found: format!("a list of {found}"),
            expected: format!("a list of {most}"),
        }),
    }
}

fn parsed<T: DeserializeOwned>(text: &str, path: &str) -> Result<T, TomlError> {
    toml::from_str(text).map_err(|error| {
        let mut message = excerpt(error.to_string().trim_end());
        let (said, span) = (error.message(), error.span().unwrap_or_default());
        // The top level has no line of its own, which a table has: that of its name.
        let shown = text.get(span.clone()).unwrap_or_default();
        let is_table = shown.starts_with(['[', '{']) && !shown.contains('\n');
        if said.starts_with("missing field") && !is_table {
            message = format!("{said}: the file has no such key at its top level");
        }
        message.push_str(&hint(said, text, span.start));
        TomlError::Malformed { path: path.into(), message }
    })
}

/// A message with the lines that it quotes from the file cut.
fn excerpt(message: &str) -> String {
    const COLUMNS: usize = 120;
    let cut = |line: &str| match line.char_indices().nth(COLUMNS) {
        Some((end, _)) if line.contains(" | ") => format!("{}…", &line[..end]),
        _ => line.to_string(),
    };
    message.lines().map(cut).collect::<Vec<_>>().join("\n")
}

/// A value of a table that another program has made, whose keys stand in no line; messages name `path`.
pub fn of_table<T: DeserializeOwned + JsonSchema>(table: Table, path: &str) -> Result<T, TomlError> {
    check_lists::<T>(&table, |_| path.into())?;
    table.try_into().map_err(|error: toml::de::Error| {
        let words: Vec<String> = error.to_string().lines().map(|line| line.trim().to_string()).collect();
        let message = words.join(" ") + &hint(error.message(), "", 0);
        TomlError::Malformed { path: path.into(), message }
    })
}

/// Suggestion for a refused text; may be empty.
fn hint(said: &str, text: &str, at: usize) -> String {
    let mut quoted = said.split('`').skip(1).step_by(2);
    if said.starts_with("unknown field") || said.starts_with("unknown variant") {
        let found = quoted.next().unwrap_or_default();
        return did_you_mean(found, quoted);
    }
    let behind = text.get(at..).unwrap_or_default();
    let before = text.get(..at).unwrap_or_default();
    let line = before.rsplit('\n').next().unwrap_or_default();
    if behind.starts_with(',') && before.ends_with(|c: char| c.is_ascii_digit()) && !line.contains(['[', '{'])
    {
        return "; a number has a decimal point: write 2.1 for 2,1".into();
    }
    if line.contains('\\') {
        return "; in a path write `/` for `\\`, or put the text between single quotes".into();
    }
    String::new()
}

/// Line (from 1) of a key such as `parameter[1].range`; of its nearest parent that is there if the key itself
/// is not.
fn line_of(text: &str, key: &str) -> Option<usize> {
    let root = DeTable::parse(text).ok()?;
    let mut table: &DeTable<'_> = root.get_ref();
    let mut found = None;
    for part in key.split('.') {
        let (name, index) = match part.split_once('[') {
            Some((name, rest)) => (name, rest.strip_suffix(']').and_then(|i| i.parse::<usize>().ok())),
            None => (part, None),
        };
        let Some((key, value)) = table.iter().find(|(k, _)| k.get_ref() == name) else { break };
        found = Some(key.span().start);
        let value = match (value.get_ref(), index) {
            (DeValue::Array(items), Some(i)) => {
                let item = items.get(i)?;
                found = Some(item.span().start);
                item.get_ref()
            }
            (other, _) => other,
        };
        match value {
            DeValue::Table(inner) => table = inner,
            _ => break,
        }
    }
    Some(1 + text.get(..found?)?.matches('\n').count())
}

/// `path:line` of a key, `path` alone if it cannot be found.
pub fn place(path: &str, text: &str, key: &str) -> String {
    match line_of(text, key) {
        Some(line) => format!("{path}:{line}"),
        None => path.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_found_where_they_stand() {
        let text = "a = 1\n[b]\nc = 2\n[[d]]\ne = 3\n[[d]]\ne = 4\nf = [1,\n2]\n";
        assert_eq!(line_of(text, "b.c"), Some(3));
        assert_eq!(line_of(text, "d[1].e"), Some(7));
        assert_eq!(line_of(text, "d[1].f"), Some(8));
        assert_eq!(line_of(text, "d[0].missing"), Some(4));
        assert_eq!(line_of(text, "nowhere"), None);
    }
}
