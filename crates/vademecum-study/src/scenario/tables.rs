//! Numbers over time: in the scenario itself, or in a file beside it.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vademecum_build::dynamics::LoadTable;
use vademecum_build::input::toml_file::{TomlError, read};
use vademecum_build::mesh::cells::{Separators, names, table_rows};
use vademecum_build::printable::printable;

/// Most rows of all tables of a scenario, each file counted once: at most 128 MB of numbers.
const MAX_ROWS: usize = 4_000_000;

/// Largest size of a coordinate, a force or an amplitude: that of the evaluator
/// ([`LARGEST`](vademecum_eval::Scalar::LARGEST)), whose outputs stay within the range of a double.
pub(super) const LARGEST: f64 = <f64 as vademecum_eval::Scalar>::LARGEST;

/// Rows of numbers.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(untagged, expecting = "the name of a file, or a list of rows of numbers")]
pub enum Rows {
    /// In a file, from the folder of the scenario.
    File(PathBuf),
    /// Here.
    Here(Vec<Vec<f64>>),
}

/// Kind of a table: the names of its columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Columns {
    /// `time,amplitude`.
    Amplitude,
    /// `time,amplitude` or `time,fx,fy,fz`.
    Force,
    /// `time,x,y,z`.
    Place,
    /// `time,ax,ay,az`, or with angular velocities and accelerations behind.
    Base,
}

impl Columns {
    fn headers(self) -> &'static [&'static str] {
        match self {
            Self::Amplitude => &["time,amplitude"],
            Self::Force => &["time,amplitude", "time,fx,fy,fz"],
            Self::Place => &["time,x,y,z"],
            Self::Base => &["time,ax,ay,az", "time,ax,ay,az,wx,wy,wz,dwx,dwy,dwz"],
        }
    }

    fn fit(self, count: usize) -> bool {
        self.headers().iter().any(|names| names.split(',').count() == count)
    }

    fn expected(self) -> &'static str {
        match self {
            Self::Amplitude => "rows of two finite numbers of at most 1e75 in size: `time,amplitude`",
            Self::Force => {
                "rows of two or of four finite numbers of at most 1e75 in size, as many in each: \
                 `time,amplitude` or `time,fx,fy,fz`"
            }
            Self::Base => {
                "rows of four or of ten finite numbers of at most 1e75 in size, as many in each: \
                 `time,ax,ay,az` or `time,ax,ay,az,wx,wy,wz,dwx,dwy,dwz`"
            }
            Self::Place => "rows of four finite numbers of at most 1e75 in size: `time,x,y,z`",
        }
    }

    /// Times of a path are different; those of a load may be the same twice, where it jumps.
    fn order(self) -> &'static str {
        match self {
            Self::Place => "two rows or more whose times rise",
            _ => "two rows or more whose times never fall, at most two of them the same",
        }
    }

    fn is_sound(self, table: &LoadTable) -> bool {
        let times: Vec<f64> = table.rows(0).map(|[t, _]| t).collect();
        self != Self::Place || times.windows(2).all(|w| w[0] < w[1])
    }
}

/// Tables of a scenario, each file read once.
pub(super) struct Tables<'a> {
    folder: &'a Path,
    read: HashMap<(PathBuf, Columns), Arc<LoadTable>>,
    rows: usize,
}

impl<'a> Tables<'a> {
    pub(crate) fn of(folder: &'a Path) -> Self {
        Self { folder, read: HashMap::new(), rows: 0 }
    }

    /// The rows as a table; what is wrong with rows in the scenario itself is found at `key`, which stands at
    /// `place`.
    pub(crate) fn table(
        &mut self,
        rows: &Rows,
        columns: Columns,
        key: &str,
        place: impl Fn() -> String,
    ) -> Result<Arc<LoadTable>, TomlError> {
        let fault = |found: String, expected: &str| TomlError::Impossible {
            path: place(),
            key: key.into(),
            found,
            expected: expected.into(),
        };
        let table = match rows {
            Rows::File(file) => {
                let named = (self.folder.join(file), columns);
                if let Some(table) = self.read.get(&named) {
                    return Ok(Arc::clone(table));
                }
                let path = named.0.display().to_string();
                let table = Arc::new(parse(&read(&named.0)?, columns, &path)?);
                self.read.insert(named, Arc::clone(&table));
                table
            }
            Rows::Here(rows) => {
                let width = rows.first().map_or(0, Vec::len);
                let sound = |row: &Vec<f64>| row.len() == width && row.iter().all(|&x| usable(x));
                if let Some(bad) = rows.iter().position(|row| !columns.fit(width) || !sound(row)) {
                    return Err(fault(
                        format!("a table whose row {bad} is {}", words(&rows[bad])),
                        columns.expected(),
                    ));
                }
                let given = rows.len();
                let table = made(rows.iter().flatten().copied(), width, columns);
                Arc::new(table.ok_or_else(|| {
                    fault(format!("a table of {given} rows in another order"), columns.order())
                })?)
            }
        };
        self.rows += table.rows(0).count();
        if self.rows > MAX_ROWS {
            let found = format!("the table with which the scenario has {} rows", self.rows);
            return Err(fault(found, "at most 4 000 000 rows in all tables"));
        }
        Ok(table)
    }
}

fn usable(x: f64) -> bool {
    x.abs() <= LARGEST
}

fn words(row: &[f64]) -> String {
    let mut shown: Vec<String> = row.iter().take(5).map(f64::to_string).collect();
    if row.len() > 5 {
        shown.push(format!("… of {} numbers", row.len()));
    }
    format!("[{}]", shown.join(", "))
}

/// Numbers row by row, `width` in each, the time first.
fn made(numbers: impl Iterator<Item = f64>, width: usize, columns: Columns) -> Option<LoadTable> {
    let (mut times, mut values) = (vec![], vec![]);
    for (at, number) in numbers.enumerate() {
        if at % width == 0 { times.push(number) } else { values.push(number) }
    }
    LoadTable::new(times, values).filter(|table| columns.is_sound(table))
}

/// A table from its text; messages name `path`.
fn parse(text: &str, columns: Columns, path: &str) -> Result<LoadTable, TomlError> {
    let fault = |line: usize, found: &str, expected: &str| {
        let short: String = printable(found).chars().take(60).collect();
        let message = format!("the table has `{short}`; expected {expected}");
        TomlError::Malformed { path: format!("{path}:{line}"), message }
    };
    let (mut numbers, mut width, mut rows, mut last) = (vec![], 0, 0, 0);
    let mut previous: Vec<f64> = vec![];
    for row in table_rows(text.as_bytes(), Separators::Any) {
        let (at, line) = (row.line, &*String::from_utf8_lossy(row.text));
        let cells = &row.cells;
        if last == 0 {
            last = at;
            width = cells.len();
            if columns.headers().contains(&&*names(&row).to_ascii_lowercase()) {
                continue;
            }
        }
        last = at;
        let before = numbers.len();
        let number = |cell: &&[u8]| std::str::from_utf8(cell).ok()?.parse().ok();
        numbers.extend(cells.iter().map_while(number).filter(|&x| usable(x)));
        if numbers.len() - before != cells.len() || cells.len() != width || !columns.fit(width) {
            return Err(fault(at, line, columns.expected()));
        }
        let time: f64 = numbers[before];
        let twice = previous.len() == 2 && previous[0] == time;
        if previous.last().is_some_and(|&t| time < t || (time == t && columns == Columns::Place)) || twice {
            return Err(fault(at, line, columns.order()));
        }
        if previous.len() == 2 {
            previous.remove(0);
        }
        previous.push(time);
        rows += 1;
        if rows > MAX_ROWS {
            return Err(fault(at, line, "at most 4 000 000 rows in all tables"));
        }
    }
    made(numbers.into_iter(), width, columns)
        .ok_or_else(|| fault(last.max(1), "the end of the file", columns.order()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(text: &str, columns: Columns) -> String {
        parse(text, columns, "f.csv").expect_err(text).to_string()
    }

    #[test]
    fn tables_have_a_header_or_none_comments_and_any_separator() {
        let rows = |text: &str| parse(text, Columns::Force, "f.csv").expect(text).rows(0).collect::<Vec<_>>();
        let expected = [[0.0, 1.0], [0.5, -2e-3]];
        assert_eq!(rows("time,amplitude\n0,1\n0.5,-2e-3\n"), expected);
        assert_eq!(rows("# recorded\n\n0 1\r\n0.5\t-0.002"), expected);
        assert_eq!(rows("Time; Amplitude\n0; 1\n0.5 ;-2e-3\n"), expected);
        // As spreadsheets write it.
        assert_eq!(rows("\u{feff}\"time\",\"amplitude\"\r\n\"0\",\"1\"\r\n0.5,-0.002\r\n"), expected);
        let forces = parse("time,fx,fy,fz\n0,1,2,3\n1,4,5,6\n", Columns::Force, "f.csv").expect("forces");
        assert_eq!(forces.columns(), 3);
        assert_eq!(forces.rows(2).collect::<Vec<_>>(), [[0.0, 3.0], [1.0, 6.0]]);
    }

    #[test]
    fn faults_of_a_table_name_the_line_what_was_found_and_what_was_expected() {
        for (text, columns, line, found) in [
            ("0,1\n1,x\n", Columns::Force, "f.csv:2:", "`1,x`"),
            ("0,1\n1,nan\n", Columns::Force, "f.csv:2:", "`1,nan`"),
            ("0,1\n1,2,3,4\n", Columns::Force, "f.csv:2:", "`1,2,3,4`"),
            ("0,1,2,3\n1,2,3,4\n", Columns::Amplitude, "f.csv:1:", "`time,amplitude`"),
            ("t,f\n0,1\n", Columns::Force, "f.csv:1:", "`t,f`"),
            ("# x\n0,1\n2,1\n1,1\n", Columns::Force, "f.csv:4:", "never fall"),
            ("0,1\n0,1\n0,1\n", Columns::Force, "f.csv:3:", "at most two of them the same"),
            ("0,1,1,1\n0,1,1,2\n", Columns::Place, "f.csv:2:", "times rise"),
            ("0,1\n", Columns::Force, "f.csv:1:", "two rows or more"),
            ("", Columns::Force, "f.csv:1:", "the end of the file"),
            ("0,1e200\n1,1\n", Columns::Force, "f.csv:1:", "at most 1e75"),
        ] {
            let error = said(text, columns);
            assert!(error.contains(line) && error.contains(found), "{text:?}: {error}");
        }
    }
}
