//! Places in mesh files.

use std::fmt;

/// Where in a file a fault lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Line of a text file, counted from 1.
    Line(usize),
    /// Offset in a binary file, counted from 0.
    Byte(usize),
    /// Cell of a file that stores its cells as arrays, counted from 0.
    Cell(usize),
    /// The file as a whole.
    Whole,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Line(line) => write!(f, "line {line}"),
            Place::Byte(byte) => write!(f, "byte {byte}"),
            Place::Cell(cell) => write!(f, "cell {cell}"),
            Place::Whole => write!(f, "the whole file"),
        }
    }
}
