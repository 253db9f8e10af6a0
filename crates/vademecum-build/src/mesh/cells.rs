//! Rows of text tables, as people, measuring programs and spreadsheets write them: the one reader of all of
//! them. A byte order mark, quotes around cells, blank lines and comments (`#`, `%`) are not part of a table.

/// Separators of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separators {
    /// Commas; cells may be empty.
    Commas,
    /// Commas, semicolons and white space, of which several stand for one.
    Any,
}

/// A row of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TableRow<'a> {
    /// Line in the file, from 1.
    pub line: usize,
    /// The line, trimmed, for messages.
    pub text: &'a [u8],
    /// Its cells without white space and quotes around them.
    pub cells: Vec<&'a [u8]>,
}

/// UTF-8's byte order mark, which spreadsheets write.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// The rows of a table.
pub fn table_rows(bytes: &[u8], separators: Separators) -> impl Iterator<Item = TableRow<'_>> {
    let bytes = bytes.strip_prefix(MARK).unwrap_or(bytes);
    let lines = bytes.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii).enumerate();
    let rows = lines.filter(|(_, text)| !matches!(text.first(), None | Some(b'#' | b'%')));
    rows.map(move |(at, text)| TableRow { line: at + 1, text, cells: cells(text, separators) })
}

fn cells(text: &[u8], separators: Separators) -> Vec<&[u8]> {
    let mut quoted = false;
    let separates = |&byte: &u8| {
        quoted ^= byte == b'"';
        let is_separator =
            byte == b',' || (separators == Separators::Any && (byte == b';' || byte.is_ascii_whitespace()));
        is_separator && !quoted
    };
    let cells = text.split(separates).map(|cell| {
        let cell = cell.trim_ascii();
        let inside = cell.strip_prefix(b"\"").and_then(|cell| cell.strip_suffix(b"\""));
        inside.map_or(cell, <[u8]>::trim_ascii)
    });
    cells.filter(|cell| separators == Separators::Commas || !cell.is_empty()).collect()
}

/// The cells of a row as one text, for a comparison with the names of columns.
pub fn names(row: &TableRow<'_>) -> String {
    let cells = row.cells.iter().map(|cell| String::from_utf8_lossy(cell));
    cells.collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_quotes_comments_and_blank_lines_are_no_part_of_a_table() {
        let text = "\u{feff}\"time\",\"amplitude\"\r\n\r\n# note\r\n\"0\" , \"1.5\"\r\n1,2";
        for separators in [Separators::Commas, Separators::Any] {
            let rows: Vec<TableRow<'_>> = table_rows(text.as_bytes(), separators).collect();
            let read: Vec<(usize, String)> = rows.iter().map(|row| (row.line, names(row))).collect();
            assert_eq!(read, [(1, "time,amplitude".into()), (4, "0,1.5".into()), (5, "1,2".into())]);
        }
        let of =
            |text: &'static str, separators| names(&table_rows(text.as_bytes(), separators).next().unwrap());
        assert_eq!(of("1; 2\t3,4", Separators::Any), "1,2,3,4");
        assert_eq!(of("1,,3", Separators::Commas), "1,,3");
        assert_eq!(of("\"a, b\",c", Separators::Commas), "a, b,c");
    }
}
