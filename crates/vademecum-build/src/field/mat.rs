//! MATLAB files of level 5, as MATLAB, Octave and SciPy read them: named matrices and lists of texts.
//!
//! A file is a header of 128 bytes and elements, each a tag (type and number of bytes) and data that are
//! filled up to a multiple of 8 bytes. A matrix is an element of elements: flags, dimensions, name, numbers.

use std::io::{self, Write};

use super::DenseMatrix;

/// Types of data.
const INT8: u32 = 1;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;
/// Octave reads no UTF-16, and SciPy takes 16-bit characters for ASCII.
const UTF8: u32 = 16;

/// Classes of arrays.
const CELLS: u32 = 1;
const CHARACTERS: u32 = 4;
const DOUBLES: u32 = 6;

/// A variable of a file.
#[derive(Clone, Copy, Debug)]
pub enum MatValue<'a> {
    /// A matrix.
    Matrix(&'a DenseMatrix),
    /// A column of cells, each a text.
    Texts(&'a [&'a str]),
}

/// Writes variables by name. The header bears no time: the same input gives the same bytes.
///
/// # Errors
/// Of the output; [`io::ErrorKind::InvalidInput`]: a variable of 4 GB or more, beyond what the format has.
pub fn mat_into(out: &mut dyn Write, variables: &[(&str, MatValue<'_>)]) -> io::Result<()> {
    let mut header = b"MATLAB 5.0 MAT-file, by vademecum".to_vec();
    header.resize(124, b' ');
    // Version 1.0, and the mark of little-endian numbers.
    header.extend([0, 1, b'I', b'M']);
    out.write_all(&header)?;
    variables.iter().try_for_each(|(name, value)| out.write_all(&variable(name, *value)?))
}

fn variable(name: &str, value: MatValue<'_>) -> io::Result<Vec<u8>> {
    match value {
        MatValue::Matrix(DenseMatrix { rows, columns, data }) => {
            let numbers: Vec<u8> = data.iter().flat_map(|x| x.to_le_bytes()).collect();
            array(DOUBLES, [*rows, *columns], name, &element(DOUBLE, &numbers)?)
        }
        MatValue::Texts(texts) => {
            let mut cells = vec![];
            for text in texts {
                let count = text.chars().count();
                let bytes = element(UTF8, text.as_bytes())?;
                cells.extend(array(CHARACTERS, [count.min(1), count], "", &bytes)?);
            }
            array(CELLS, [texts.len(), 1], name, &cells)
        }
    }
}

/// An array of a class: flags, dimensions, name, contents.
fn array(class: u32, dimensions: [usize; 2], name: &str, contents: &[u8]) -> io::Result<Vec<u8>> {
    let flags: Vec<u8> = [class, 0].into_iter().flat_map(u32::to_le_bytes).collect();
    let mut sizes = vec![];
    for size in dimensions {
        sizes.extend(i32::try_from(size).map_err(too_large)?.to_le_bytes());
    }
    let head = [element(UINT32, &flags)?, element(INT32, &sizes)?, element(INT8, name.as_bytes())?];
    element(MATRIX, &[&head.concat(), contents].concat())
}

/// Tag, data, and zeros up to a multiple of 8 bytes, which only those of arrays count.
fn element(kind: u32, data: &[u8]) -> io::Result<Vec<u8>> {
    let length = u32::try_from(data.len()).map_err(too_large)?;
    let mut bytes: Vec<u8> = [kind, length].into_iter().flat_map(u32::to_le_bytes).collect();
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    Ok(bytes)
}

fn too_large(error: std::num::TryFromIntError) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, error)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Annotated by hand from the description of the format.
    #[test]
    fn a_small_matrix_has_these_bytes() {
        let matrix = DenseMatrix { rows: 1, columns: 2, data: vec![1.0, -2.0] };
        let mut bytes = vec![];
        mat_into(&mut bytes, &[("A", MatValue::Matrix(&matrix))]).unwrap();
        assert_eq!(&bytes[124..128], b"\x00\x01IM");
        let words: Vec<u32> =
            bytes[128..].as_chunks().0.iter().map(|&word| u32::from_le_bytes(word)).collect();
        let name = u32::from(b'A');
        // Tags, flags, dimensions, name; 1.0 and −2.0 as doubles.
        let expected = [14, 72, 6, 8, 6, 0, 5, 8, 1, 2, 1, 1, name, 0, 9, 16, 0, 0x3ff0_0000, 0, 0xc000_0000];
        assert_eq!(words, expected);
    }

    #[test]
    fn texts_are_cells_of_characters() {
        let mut bytes = vec![];
        mat_into(&mut bytes, &[("names", MatValue::Texts(&["m/s²", ""]))]).unwrap();
        assert_eq!(bytes.len() % 8, 0);
        // Type and number of bytes; four characters.
        let text = [&[16, 0, 0, 0, 5, 0, 0, 0], "m/s²".as_bytes()].concat();
        assert!(bytes.windows(text.len()).any(|window| window == text));
        assert!(bytes.windows(8).any(|window| window == [1, 0, 0, 0, 4, 0, 0, 0]));
    }
}
