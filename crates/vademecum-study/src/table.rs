//! Tables of numbers in text: names with units, then rows.

use std::path::{Path, PathBuf};

use vademecum_build::store::read_regular;

/// Most numbers of a table.
const MOST: usize = 20_000_000;

/// A table that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TableFileError {
    /// A file that cannot be read.
    #[error("{}: {source}", .path.display())]
    Unreadable {
        /// The table.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// A line that cannot be used.
    #[error("{}:{line}: {found}; expected {expected}", .path.display())]
    Line {
        /// The table.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// The text or number there.
        found: String,
        /// A text or number that would do.
        expected: String,
    },
    /// A table that is no text or empty, or does not go with the other arguments.
    #[error("{}: {reason}", .path.display())]
    Whole {
        /// The table.
        path: PathBuf,
        /// The fault, and the remedy.
        reason: String,
    },
}

/// A table that was read: comma-separated, a line of names, `name [unit]` where there is a unit, then rows of
/// finite numbers. Empty lines and those that begin with `#` or `%` are left out.
#[derive(Clone, Debug)]
pub struct Table {
    /// The file.
    pub path: PathBuf,
    /// Name and unit of each column; empty of a column without.
    pub columns: Vec<(String, String)>,
    /// Line of the names.
    pub head: usize,
    /// Line and numbers of each row.
    pub rows: Vec<(usize, Vec<f64>)>,
}

impl Table {
    /// Reads a table.
    ///
    /// # Errors
    /// [`TableFileError`].
    pub fn read(path: &Path) -> Result<Self, TableFileError> {
        let unreadable = |source| TableFileError::Unreadable { path: path.into(), source };
        let bytes = read_regular(path).map_err(unreadable)?;
        let text = String::from_utf8(bytes).map_err(|error| TableFileError::Whole {
            path: path.into(),
            reason: format!("it is no text in UTF-8: {}", error.utf8_error()),
        })?;
        Self::parse(path, text.trim_start_matches('\u{feff}'))
    }

    fn parse(path: &Path, text: &str) -> Result<Self, TableFileError> {
        let lines = text.lines().enumerate().map(|(place, line)| (place + 1, line.trim()));
        let mut lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with(['#', '%']));
        let refused = |line, found: String, expected: &str| TableFileError::Line {
            path: path.into(),
            line,
            found,
            expected: expected.into(),
        };
        let (head, names) = lines.next().ok_or_else(|| TableFileError::Whole {
            path: path.into(),
            reason: "it is empty; expected a line of names, then rows of numbers".into(),
        })?;
        let columns: Vec<(String, String)> = names.split(',').map(name_and_unit).collect();
        for (place, (name, _)) in columns.iter().enumerate() {
            if name.is_empty() || columns[..place].iter().any(|(other, _)| other == name) {
                let found = format!("column {} has the name `{name}`", place + 1);
                return Err(refused(head, found, "a name of its own for each column"));
            }
        }
        let mut rows = vec![];
        for (line, text) in lines {
            let cells: Vec<&str> = text.split(',').map(str::trim).collect();
            if cells.len() != columns.len() {
                let found = format!("{} cells", cells.len());
                return Err(refused(line, found, &format!("{}, one for each name", columns.len())));
            }
            let mut numbers = Vec::with_capacity(cells.len());
            for (cell, (name, _)) in cells.iter().zip(&columns) {
                let number = cell.parse::<f64>().ok().filter(|number| number.is_finite());
                let found = || format!("`{cell}` in column `{name}`");
                numbers.push(number.ok_or_else(|| refused(line, found(), "a finite number"))?);
            }
            rows.push((line, numbers));
            if rows.len().saturating_mul(columns.len()) > MOST {
                return Err(refused(line, "a longer table".into(), &format!("at most {MOST} numbers")));
            }
        }
        if rows.is_empty() {
            return Err(refused(head, "names without a row below".into(), "rows of numbers"));
        }
        Ok(Self { path: path.into(), columns, head, rows })
    }

    /// A fault in a line.
    pub fn fault<E: From<TableFileError>>(
        &self,
        line: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> E {
        let (path, found, expected) = (self.path.clone(), found.into(), expected.into());
        TableFileError::Line { path, line, found, expected }.into()
    }
}

/// `name [unit]`.
fn name_and_unit(cell: &str) -> (String, String) {
    let cell = cell.trim();
    match cell.strip_suffix(']').and_then(|cell| cell.rsplit_once('[')) {
        Some((name, unit)) => (name.trim().into(), unit.trim().into()),
        None => (cell.into(), String::new()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(text: &str) -> String {
        Table::parse(Path::new("m.csv"), text).expect_err("a fault").to_string()
    }

    #[test]
    fn names_units_and_rows_are_read_and_faults_are_named_by_their_line() {
        let text = "# bench 3\ntime_s, tip [m]\n0,1e-3\n\n1e-3,2e-3\n";
        let table = Table::parse(Path::new("m.csv"), text).expect("a table");
        assert_eq!(table.columns[1], ("tip".into(), "m".into()));
        assert_eq!((table.head, table.rows[1].0), (2, 5));
        assert_eq!(table.rows[1].1, [1e-3, 2e-3]);
        assert!(said("a,b\n1,2\n3\n").starts_with("m.csv:3: 1 cells; expected 2"));
        assert!(said("a,b\n1,nan\n").contains("m.csv:2: `nan` in column `b`; expected a finite number"));
        assert!(said("a,a [m]\n1,2\n").contains("m.csv:1: column 2 has the name `a`"));
        assert!(said("a\n").contains("m.csv:1: names without a row"));
        assert!(said("").contains("it is empty"));
    }
}
