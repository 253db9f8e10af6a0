//! NumPy's `.npy` files of one matrix: magic, version, a Python dictionary as header, raw values.

use std::io::Write;
use std::path::Path;

use super::{DenseMatrix, FieldError, io_error, write_whole};
use crate::store::{Kind, read_regular};

const MAGIC: &[u8] = b"\x93NUMPY";

/// Reads a matrix of `float32` or `float64`, either byte order, row- or column-major; format versions 1 to 3.
/// A vector becomes a matrix of one column.
///
/// # Errors
/// [`FieldError::Io`], or [`FieldError::Malformed`] if it is no such file, too short, or holds values that
/// are not finite.
pub fn read_npy(path: &Path) -> Result<DenseMatrix, FieldError> {
    let bytes = read_regular(path).map_err(io_error(path))?;
    parse(&bytes).map_err(|(found, expected)| FieldError::Malformed {
        file: path.to_path_buf(),
        found,
        expected,
    })
}

type HeaderFault = (String, String);

fn fault<T>(found: impl Into<String>, expected: &str) -> Result<T, HeaderFault> {
    Err((found.into(), expected.into()))
}

fn parse(bytes: &[u8]) -> Result<DenseMatrix, HeaderFault> {
    let (header, data) = split(bytes)?;
    let descr = text_value(header, "descr")?;
    let (swap, width) = match descr {
        "<f8" => (false, 8),
        "<f4" => (false, 4),
        ">f8" => (true, 8),
        ">f4" => (true, 4),
        other => return fault(format!("values of type `{other}`"), "float32 or float64"),
    };
    let fortran = match value(header, "fortran_order")?.trim_start() {
        v if v.starts_with("True") => true,
        v if v.starts_with("False") => false,
        _ => return fault("another fortran_order", "True or False"),
    };
    let (rows, columns) = shape(header)?;
    let count = rows.checked_mul(columns).and_then(|n| n.checked_mul(width));
    if count != Some(data.len()) {
        let found = format!("{} bytes of data for {rows} × {columns} values of {width} bytes", data.len());
        return fault(found, "exactly as many bytes as the shape asks for");
    }
    let values: Vec<f64> = data.chunks_exact(width).map(|chunk| number(chunk, swap)).collect();
    if let Some(i) = values.iter().position(|x| !x.is_finite()) {
        return fault(format!("value {i} is {}", values[i]), "finite values");
    }
    let data = if fortran { values } else { column_major(&values, rows, columns) };
    Ok(DenseMatrix { rows, columns, data })
}

/// Header text and data.
fn split(bytes: &[u8]) -> Result<(&str, &[u8]), HeaderFault> {
    const EXPECTED: &str = "a .npy file of version 1, 2 or 3";
    let Some(rest) = bytes.strip_prefix(MAGIC) else {
        return fault("another kind of file", EXPECTED);
    };
    let (length, start) = match rest {
        [1, _, a, b, ..] => (usize::from(u16::from_le_bytes([*a, *b])), 4),
        [2 | 3, _, a, b, c, d, ..] => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, 6),
        _ => return fault("another version", EXPECTED),
    };
    let Some((header, data)) = rest[start..].split_at_checked(length) else {
        return fault(format!("a header of {length} bytes"), "a header inside the file");
    };
    match std::str::from_utf8(header) {
        Ok(header) => Ok((header, data)),
        Err(_) => fault("a header that is no text", EXPECTED),
    }
}

/// Text after `'key':` in the header.
fn value<'a>(header: &'a str, key: &str) -> Result<&'a str, HeaderFault> {
    let quoted = [format!("'{key}'"), format!("\"{key}\"")];
    let tail = quoted.iter().find_map(|q| header.split_once(q.as_str()).map(|(_, tail)| tail));
    match tail.and_then(|t| t.trim_start().strip_prefix(':')) {
        Some(tail) => Ok(tail.trim_start()),
        None => fault("a header", &format!("the key {key} in it")),
    }
}

fn text_value<'a>(header: &'a str, key: &str) -> Result<&'a str, HeaderFault> {
    let tail = value(header, key)?;
    let quote = tail.chars().next().filter(|c| matches!(c, '\'' | '"'));
    match quote.and_then(|q| tail[1..].split_once(q)) {
        Some((text, _)) => Ok(text),
        None => fault(format!("another {key}"), "text in quotes (structured types are not supported)"),
    }
}

fn shape(header: &str) -> Result<(usize, usize), HeaderFault> {
    const EXPECTED: &str = "a shape of one or two sizes";
    let tail = value(header, "shape")?;
    let Some((inside, _)) = tail.strip_prefix('(').and_then(|t| t.split_once(')')) else {
        return fault("another shape", EXPECTED);
    };
    let sizes = inside.split(',').map(str::trim).filter(|s| !s.is_empty());
    let sizes: Result<Vec<usize>, _> = sizes.map(str::parse).collect();
    match sizes.as_deref() {
        Ok([rows]) => Ok((*rows, 1)),
        Ok([rows, columns]) => Ok((*rows, *columns)),
        _ => fault(format!("shape ({inside})"), EXPECTED),
    }
}

fn number(chunk: &[u8], swap: bool) -> f64 {
    let mut bytes = [0; 8];
    let word = &mut bytes[..chunk.len()];
    word.copy_from_slice(chunk);
    if swap {
        word.reverse();
    }
    match *chunk {
        [_, _, _, _] => f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        _ => f64::from_le_bytes(bytes),
    }
}

fn column_major(values: &[f64], rows: usize, columns: usize) -> Vec<f64> {
    (0..columns).flat_map(|j| (0..rows).map(move |i| values[i * columns + j])).collect()
}

/// Writes a matrix as `float64`, column-major, format version 1.
///
/// # Errors
/// [`FieldError::WrongLength`] if the data are not `rows × columns`, [`FieldError::Io`].
pub fn write_npy(path: &Path, matrix: &DenseMatrix) -> Result<(), FieldError> {
    check(matrix)?;
    write_whole(path, Kind::Npy, |out| npy_into(out, matrix))
}

fn check(matrix: &DenseMatrix) -> Result<(), FieldError> {
    let DenseMatrix { rows, columns, data } = matrix;
    if rows.checked_mul(*columns) != Some(data.len()) {
        let expected = rows.saturating_mul(*columns);
        return Err(FieldError::WrongLength { what: "the matrix".into(), found: data.len(), expected });
    }
    Ok(())
}

/// [`write_npy`] to an open output.
///
/// # Errors
/// Of the output; [`FieldError::WrongLength`] inside.
pub fn npy_into(out: &mut dyn Write, matrix: &DenseMatrix) -> std::io::Result<()> {
    check(matrix).map_err(std::io::Error::other)?;
    let DenseMatrix { rows, columns, data } = matrix;
    npy_array_into(out, &NpyArray { shape: &[*rows, *columns], values: NpyValues::Columns(data) })
}

/// An array that is written.
#[derive(Clone, Copy, Debug)]
pub struct NpyArray<'a> {
    /// Its shape.
    pub shape: &'a [usize],
    /// Its values.
    pub values: NpyValues<'a>,
}

/// Values of an array.
#[derive(Clone, Copy, Debug)]
pub enum NpyValues<'a> {
    /// `float64`, column by column.
    Columns(&'a [f64]),
    /// `float64`, row by row.
    Rows(&'a [f64]),
    /// `int64`, row by row.
    Integers(&'a [i64]),
}

/// Writes an array, format version 1.
///
/// # Errors
/// Of the output.
///
/// # Panics
/// If the shape has another number of values.
pub fn npy_array_into(out: &mut dyn Write, array: &NpyArray<'_>) -> std::io::Result<()> {
    let (count, descr, order) = match array.values {
        NpyValues::Columns(values) => (values.len(), "<f8", "True"),
        NpyValues::Rows(values) => (values.len(), "<f8", "False"),
        NpyValues::Integers(values) => (values.len(), "<i8", "False"),
    };
    assert_eq!(array.shape.iter().product::<usize>(), count, "one value for each place of the shape");
    let mut shape: Vec<String> = array.shape.iter().map(usize::to_string).collect();
    if shape.len() == 1 {
        shape.push(String::new());
    }
    let shape = shape.join(", ");
    header_into(out, descr, order, &format!("({})", shape.trim_end()))?;
    match array.values {
        NpyValues::Columns(values) | NpyValues::Rows(values) => {
            values.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))
        }
        NpyValues::Integers(values) => values.iter().try_for_each(|x| out.write_all(&x.to_le_bytes())),
    }
}

/// Writes texts as a vector of Unicode texts.
///
/// # Errors
/// Of the output.
pub fn npy_texts_into(out: &mut dyn Write, texts: &[&str]) -> std::io::Result<()> {
    let width = texts.iter().map(|text| text.chars().count()).max().unwrap_or(0).max(1);
    header_into(out, &format!("<U{width}"), "False", &format!("({},)", texts.len()))?;
    for text in texts {
        let padded = text.chars().map(u32::from).chain(std::iter::repeat(0)).take(width);
        padded.map(u32::to_le_bytes).try_for_each(|character| out.write_all(&character))?;
    }
    Ok(())
}

/// Writes the magic, the version and the header.
fn header_into(out: &mut dyn Write, descr: &str, order: &str, shape: &str) -> std::io::Result<()> {
    let mut header = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}");
    // Data start at a multiple of 64 bytes; the header ends with a line break.
    let start = (MAGIC.len() + 4 + header.len() + 1).next_multiple_of(64);
    let padding = start - (MAGIC.len() + 4 + header.len() + 1);
    header.push_str(&" ".repeat(padding));
    header.push('\n');
    out.write_all(MAGIC)?;
    out.write_all(&[1, 0])?;
    out.write_all(&(header.len() as u16).to_le_bytes())?;
    out.write_all(header.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(descr: &str, fortran: &str, shape: &str, data: &[u8]) -> Vec<u8> {
        let header = format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}\n");
        let mut bytes = MAGIC.to_vec();
        bytes.extend([1, 0]);
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(data);
        bytes
    }

    #[test]
    fn row_major_single_precision_and_byte_orders_are_read() {
        let little: Vec<u8> = (1..=6).flat_map(|i| (i as f32).to_le_bytes()).collect();
        let big: Vec<u8> = (1..=6).flat_map(|i| f64::from(i).to_be_bytes()).collect();
        let matrix = parse(&file("<f4", "False", "(2, 3)", &little)).unwrap();
        assert_eq!((matrix.rows, matrix.columns), (2, 3));
        assert_eq!(matrix.data, [1.0, 4.0, 2.0, 5.0, 3.0, 6.0]);
        let matrix = parse(&file(">f8", "True", "(2, 3)", &big)).unwrap();
        assert_eq!(matrix.data, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(parse(&file(">f8", "True", "(6,)", &big)).unwrap().columns, 1);
    }

    #[test]
    fn wrong_files_are_refused_by_name() {
        let cases = [
            (file("<i8", "True", "(1, 1)", &[0; 8]), "values of type `<i8`"),
            (file("<f8", "True", "(9, 9)", &[0; 8]), "8 bytes of data for 9 × 9 values of 8 bytes"),
            (file("<f8", "True", "(1, 1, 1)", &[0; 8]), "shape (1, 1, 1)"),
            (file("<f8", "True", "(1, 1)", &f64::NAN.to_le_bytes()), "value 0 is NaN"),
            (b"PK".to_vec(), "another kind of file"),
        ];
        for (bytes, found) in cases {
            assert_eq!(parse(&bytes).unwrap_err().0, found);
        }
    }

    #[test]
    fn a_written_matrix_reads_back_equal() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.npy");
        let matrix = DenseMatrix { rows: 3, columns: 2, data: vec![1.0, -2.5, 1e-300, 4.0, 5.0, 6.0] };
        write_npy(&path, &matrix).unwrap();
        assert_eq!(read_npy(&path).unwrap(), matrix);
        // The layout NumPy asks for.
        assert_eq!(std::fs::metadata(&path).unwrap().len(), 128 + 48);
    }
}
