//! Symmetric sparse matrices as Matrix Market files, which SciPy, MATLAB, Julia and Eigen read and write.
//!
//! The reader takes `coordinate` matrices of `real` or `integer` values, `symmetric` or `general`; a general
//! one must be symmetric within rounding. Files are untrusted: no text makes the reader panic, or allocate
//! beyond a small multiple of the file's own size.

use std::io::Write;
use std::path::Path;

use super::{DenseMatrix, FieldError, io_error};
use crate::fem::SymmetricMatrix;
use crate::mesh::text::{ParsedNumber, Text, tokens};
use crate::mesh::{Location, shown};
use crate::store::read_regular;

/// Mirrored entries of a general matrix may differ by this, relative to `√(a_ii a_jj)`, the largest that an
/// entry of a positive definite matrix can be. Programs add some thousand contributions to an entry at most,
/// each rounded to 1.1e-16 of that, and not always in the same order for both.
const ROUNDING: f64 = 1e-12;

/// The shortest line of an entry, `1 1 1` and its end.
const SHORTEST_ENTRY: usize = 6;

/// A symmetric matrix as a file has it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MarketMatrix {
    /// Number of rows and columns.
    pub(crate) n: usize,
    /// `(row, column, value)` from 0, `row ≥ column`, every place once, sorted by column and row.
    pub(crate) lower: Vec<(u32, u32, f64)>,
}

impl MarketMatrix {
    /// Entries of both triangles, each with its rows and columns renamed: `name[i]` is the new number of row
    /// `i`.
    ///
    /// # Panics
    /// If `name` is shorter than `n`.
    pub(crate) fn both_triangles(&self, name: &[u32]) -> Vec<(u32, u32, f64)> {
        let mut both = Vec::with_capacity(2 * self.lower.len());
        for &(row, column, value) in &self.lower {
            let (row, column) = (name[row as usize], name[column as usize]);
            both.push((row, column, value));
            if row != column {
                both.push((column, row, value));
            }
        }
        both
    }
}

/// An entry with its line, for messages. `upper`: it is above the diagonal of a general matrix; row and
/// column are swapped then, so that mirrored entries lie side by side when sorted.
#[derive(Clone, Copy)]
struct Entry {
    column: u32,
    row: u32,
    upper: bool,
    line: u32,
    value: f64,
}

/// Content of the first line.
#[derive(Clone, Copy)]
struct MarketHeader {
    integer: bool,
    symmetric: bool,
}

/// Reads a symmetric matrix: `coordinate real` or `integer`, `symmetric` or `general`. Comments and blank
/// lines may stand anywhere after the first line. Mirrored entries of a general matrix that differ by
/// rounding are replaced by their mean.
///
/// # Errors
/// [`FieldError::Io`], or [`FieldError::Faulty`] with the line of the first fault: another kind of matrix,
/// one that is not square or not symmetric, a count beyond the file, an entry that is malformed, outside the
/// matrix or given twice.
pub(crate) fn read_matrix_market(path: &Path) -> Result<MarketMatrix, FieldError> {
    let bytes = read_regular(path).map_err(io_error(path))?;
    let mut text = Text::new(path, &bytes);
    text.section = "the header".into();
    let header = header(&mut text)?;
    let (n, count) = sizes(&mut text)?;
    text.section = "the entries".into();
    let mut entries = Vec::with_capacity(count);
    for read in 0..count {
        let expected = || format!("{count} entries, of which {read} were found");
        let line = next(&mut text).ok_or_else(|| refused(&text, "the end of the file", expected()))?;
        entries.push(entry(&text, line, header, n)?);
    }
    if let Some(line) = next(&mut text) {
        return Err(refused(&text, shown(line), format!("no more than the {count} entries of the header")));
    }
    entries.sort_unstable_by_key(|e| (e.column, e.row, e.upper));
    refuse_repeated(&text, &entries)?;
    let lower = if header.symmetric {
        entries.iter().map(|e| (e.row, e.column, e.value)).collect()
    } else {
        symmetrised(&text, n, &entries)?
    };
    Ok(MarketMatrix { n, lower })
}

/// The next line that is neither blank nor a comment.
fn next<'a>(text: &mut Text<'a>) -> Option<&'a [u8]> {
    loop {
        let line = text.next_line()?;
        if line.first() != Some(&b'%') {
            return Some(line);
        }
    }
}

fn refused(text: &Text<'_>, found: impl Into<String>, expected: impl Into<String>) -> FieldError {
    const REMEDY: &str = "correct the file, or write it again with the program it comes from";
    FieldError::Faulty(Box::new(text.at().fault(found.into(), expected.into(), REMEDY.into())))
}

/// The same for an entry that was read before.
fn refused_at(text: &Text<'_>, line: u32, found: String, expected: &str) -> FieldError {
    let mut at = text.at();
    at.place = Location::Line(line as usize);
    let remedy = "add up repeated entries and write one symmetric matrix".into();
    FieldError::Faulty(Box::new(at.fault(found, expected.into(), remedy)))
}

fn header(text: &mut Text<'_>) -> Result<MarketHeader, FieldError> {
    const EXPECTED: &str =
        "`%%MatrixMarket matrix coordinate`, `real` or `integer`, `symmetric` or `general`";
    let line = text.raw_line().unwrap_or_default();
    let words: Vec<Vec<u8>> = tokens(line).take(6).map(<[u8]>::to_ascii_lowercase).collect();
    let words: Vec<&[u8]> = words.iter().map(Vec::as_slice).collect();
    let [b"%%matrixmarket", b"matrix", b"coordinate", field, symmetry] = words[..] else {
        return Err(refused(text, shown(line), EXPECTED));
    };
    let integer = match field {
        b"real" => false,
        b"integer" => true,
        _ => return Err(refused(text, shown(line), EXPECTED)),
    };
    let symmetric = match symmetry {
        b"symmetric" => true,
        b"general" => false,
        _ => return Err(refused(text, shown(line), EXPECTED)),
    };
    Ok(MarketHeader { integer, symmetric })
}

/// Size and number of entries, both believed only as far as the file can hold them.
fn sizes(text: &mut Text<'_>) -> Result<(usize, usize), FieldError> {
    const EXPECTED: &str = "three numbers: rows, columns, entries";
    let line = next(text).ok_or_else(|| refused(text, "the end of the file", EXPECTED))?;
    let [rows, columns, entries] =
        text.exactly::<u64, 3>(line, EXPECTED).map_err(|_| refused(text, shown(line), EXPECTED))?;
    if rows != columns || rows == 0 {
        return Err(refused(text, format!("{rows} rows and {columns} columns"), "a square matrix"));
    }
    let most = (text.left() / SHORTEST_ENTRY + 1).min(u32::MAX as usize);
    let count = usize::try_from(entries).ok().filter(|&count| count <= most).ok_or_else(|| {
        let left = text.left();
        refused(
            text,
            format!("{entries} entries"),
            format!("no more than the remaining {left} bytes can hold"),
        )
    })?;
    let n = usize::try_from(rows).ok().filter(|&n| n <= count).ok_or_else(|| {
        let expected =
            "at least one entry per row, that on the diagonal: the matrix must be positive definite";
        refused(text, format!("{rows} rows and {entries} entries"), expected)
    })?;
    Ok((n, count))
}

fn entry(text: &Text<'_>, line: &[u8], header: MarketHeader, n: usize) -> Result<Entry, FieldError> {
    let expected =
        if header.integer { "a row, a column and an integer" } else { "a row, a column and a finite number" };
    let malformed = || refused(text, shown(line), expected);
    let mut words = tokens(line);
    let mut word = || words.next().ok_or_else(malformed);
    let index = |word: &[u8]| {
        let number = u64::parse(word).ok_or_else(malformed)?;
        let place = usize::try_from(number).ok().and_then(|i| i.checked_sub(1)).filter(|&i| i < n);
        place
            .map(|i| i as u32)
            .ok_or_else(|| refused(text, shown(line), format!("rows and columns from 1 to {n}")))
    };
    let (row, column) = (index(word()?)?, index(word()?)?);
    let value = word()?;
    let value = if header.integer { i64::parse(value).map(|v| v as f64) } else { f64::parse(value) };
    let value = value.ok_or_else(malformed)?;
    if words.next().is_some() {
        return Err(malformed());
    }
    let line = u32::try_from(text.line_number()).unwrap_or(u32::MAX);
    let upper = !header.symmetric && row < column;
    Ok(Entry { column: row.min(column), row: row.max(column), upper, line, value })
}

/// Each place once. In a `symmetric` file an entry and its mirror image are one place.
fn refuse_repeated(text: &Text<'_>, entries: &[Entry]) -> Result<(), FieldError> {
    let place = |e: &Entry| (e.column, e.row, e.upper);
    match entries.windows(2).find(|pair| place(&pair[0]) == place(&pair[1])) {
        None => Ok(()),
        Some(pair) => {
            let (first, second) = (pair[0].line.min(pair[1].line), pair[0].line.max(pair[1].line));
            let (row, column) = (pair[0].row + 1, pair[0].column + 1);
            let found = format!("the entry of rows {row} and {column} a second time, first on line {first}");
            Err(refused_at(
                text,
                second,
                found,
                "every entry once, of a symmetric matrix one of each mirrored pair",
            ))
        }
    }
}

/// Means of mirrored entries, which must agree within rounding; an absent one is zero.
fn symmetrised(text: &Text<'_>, n: usize, entries: &[Entry]) -> Result<Vec<(u32, u32, f64)>, FieldError> {
    let mut diagonal = vec![0.0; n];
    entries.iter().filter(|e| e.row == e.column).for_each(|e| diagonal[e.row as usize] = e.value);
    let mut lower = Vec::with_capacity(entries.len() / 2 + n);
    for pair in entries.chunk_by(|a, b| (a.column, a.row) == (b.column, b.row)) {
        let Entry { row, column, line, value, .. } = pair[0];
        if row == column {
            lower.push((row, column, value));
            continue;
        }
        let mirrored = pair.get(1).map_or(0.0, |other| other.value);
        // Two roots: a product of large entries would overflow.
        let scale = diagonal[row as usize].abs().sqrt() * diagonal[column as usize].abs().sqrt();
        // Written so that an infinite difference is refused too.
        let alike = (value - mirrored).abs() <= ROUNDING * scale;
        if !alike {
            let (row, column) = (row + 1, column + 1);
            let found = match pair.get(1) {
                Some(other) => format!(
                    "{value:e} for the entry of rows {row} and {column}, and {mirrored:e} for its mirror \
                     image on line {}",
                    other.line
                ),
                None => format!(
                    "{value:e} for the entry of rows {row} and {column}, and none for its mirror image"
                ),
            };
            return Err(refused_at(
                text,
                line,
                found,
                "a symmetric matrix: mirrored entries equal within rounding",
            ));
        }
        lower.push((row, column, 0.5 * value + 0.5 * mirrored));
    }
    Ok(lower)
}

/// Writes a matrix as `coordinate real symmetric`: the lower triangle, column by column, indices from 1,
/// every stored place (zeros included) with as many digits as give the same number back.
///
/// # Errors
/// Of the output.
pub fn matrix_market_into(out: &mut dyn Write, matrix: &SymmetricMatrix) -> std::io::Result<()> {
    let (n, pattern) = (matrix.n(), matrix.pattern());
    let lower = |j: usize| {
        let entries = pattern.rows_of(j).iter().zip(&matrix.values()[pattern.range(j)]);
        entries.filter(move |(i, _)| **i as usize >= j)
    };
    let count: usize = (0..n).map(|j| lower(j).count()).sum();
    writeln!(out, "%%MatrixMarket matrix coordinate real symmetric\n{n} {n} {count}")?;
    for j in 0..n {
        for (i, value) in lower(j) {
            writeln!(out, "{} {} {value:e}", i + 1, j + 1)?;
        }
    }
    Ok(())
}

/// Writes a matrix as `array real general`: all entries, column by column, with as many digits as give the
/// same number back.
///
/// # Errors
/// Of the output.
pub fn market_array_into(out: &mut dyn Write, matrix: &DenseMatrix) -> std::io::Result<()> {
    let DenseMatrix { rows, columns, data } = matrix;
    writeln!(out, "%%MatrixMarket matrix array real general\n{rows} {columns}")?;
    data.iter().try_for_each(|value| writeln!(out, "{value:e}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<MarketMatrix, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.mtx");
        std::fs::write(&path, text).unwrap();
        read_matrix_market(&path).map_err(|error| error.to_string())
    }

    #[test]
    fn both_kinds_of_symmetry_and_of_numbers_are_read() {
        let expected = vec![(0, 0, 2.0), (1, 0, -1.0), (1, 1, 2.0)];
        let texts = [
            "%%MatrixMarket matrix coordinate real symmetric\n2 2 3\n1 1 2\n2 1 -1.0\n2 2 2e0\n",
            // Which one of a mirrored pair is given does not matter, nor does the order.
            "%%matrixmarket MATRIX Coordinate Real Symmetric\n%\n\n2 2 3\n% two\n2 2 2.0\n\n1 2 -1\n1 1 2D0",
            "%%MatrixMarket matrix coordinate integer symmetric\n2 2 3\r\n1 1 2\r\n2 1 -1\r\n2 2 2\r\n",
            "%%MatrixMarket matrix coordinate real general\n2 2 4\n1 1 2\n1 2 -1\n2 1 -1\n2 2 2\n% the end\n",
        ];
        for text in texts {
            assert_eq!(read(text), Ok(MarketMatrix { n: 2, lower: expected.clone() }), "{text}");
        }
    }

    #[test]
    fn a_general_matrix_is_symmetrised_within_rounding_and_no_further() {
        let text = |mirrored: f64| {
            let head = "%%MatrixMarket matrix coordinate real general\n2 2 4\n1 1 4\n2 2 9\n";
            read(&format!("{head}2 1 1\n1 2 {mirrored}\n"))
        };
        // √(4 · 9) = 6 is the scale.
        assert_eq!(text(1.0 + 5e-12).unwrap().lower[1].2, 0.5 + 0.5 * (1.0 + 5e-12));
        let refused = text(1.0 + 7e-12).unwrap_err();
        assert!(refused.contains("line 5") && refused.contains("on line 6"), "{refused}");
        let lonely = "%%MatrixMarket matrix coordinate real general\n2 2 3\n1 1 4\n2 2 9\n1 2 1\n";
        assert!(read(lonely).unwrap_err().contains("none for its mirror image"));
    }

    #[test]
    fn faults_are_refused_by_line() {
        let head = "%%MatrixMarket matrix coordinate real symmetric\n";
        let with = |rest: &str| format!("{head}{rest}");
        let cases = [
            ("".into(), "line 1, in the header: found nothing"),
            ("1 1 1\n1 1 1\n".into(), "line 1, in the header: found `1 1 1`"),
            (head.replace("real", "complex"), "line 1"),
            (head.replace("real", "pattern"), "line 1"),
            (head.replace("symmetric", "skew-symmetric"), "line 1"),
            (head.replace("coordinate", "array"), "line 1"),
            (with(""), "found the end of the file, expected three numbers"),
            (with("2 2\n"), "line 2, in the header: found `2 2`"),
            (with("2 -2 1\n"), "line 2, in the header: found `2 -2 1`"),
            (with("2 3 1\n1 1 1\n"), "2 rows and 3 columns, expected a square matrix"),
            (with("0 0 0\n"), "0 rows and 0 columns"),
            (
                with("1 1 1000000\n1 1 1\n"),
                "found 1000000 entries, expected no more than the remaining 6 bytes",
            ),
            (with("1 1 18446744073709551615\n"), "no more than the remaining 0 bytes"),
            (with("3 3 2\n1 1 1\n2 2 1\n"), "3 rows and 2 entries, expected at least one entry per row"),
            (
                with("1 1 1\n"),
                "line 2, in the entries: found the end of the file, expected 1 entries, of which 0",
            ),
            (with("1 1 1\n\n1 1\n"), "line 4, in the entries: found `1 1`"),
            (with("1 1 1\n1 1 nan\n"), "line 3, in the entries: found `1 1 nan`"),
            (with("1 1 1\n1 1 1 1\n"), "line 3"),
            (with("1 1 1\n0 1 1\n"), "expected rows and columns from 1 to 1"),
            (with("1 1 1\n1 2 1\n"), "expected rows and columns from 1 to 1"),
            (
                with("1 1 1\n1 1 1\n1 1 1\n"),
                "line 4, in the entries: found `1 1 1`, expected no more than the 1",
            ),
            (
                with("2 2 4\n1 1 1\n1 2 0\n2 1 0\n2 2 1\n"),
                "line 5, in the entries: found the entry of rows 2 and 1",
            ),
            (
                head.replace("real", "integer") + "1 1 1\n1 1 1.5\n",
                "line 3, in the entries: found `1 1 1.5`, expected a row, a column and an integer",
            ),
        ];
        for (text, said) in cases {
            let error = read(&text).expect_err(&text);
            assert!(error.contains("m.mtx") && error.contains(said), "{error}\n{text}");
        }
    }
}
