//! Places in mesh files.

use std::fmt;

/// Position of a fault in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Location {
    /// Line of a text file, counted from 1.
    Line(usize),
    /// Offset in a binary file, counted from 0.
    Byte(usize),
    /// Cell of a file that stores its cells as arrays, counted from 0.
    Cell(usize),
    /// The file as a whole.
    Whole,
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Location::Line(line) => write!(f, "line {line}"),
            Location::Byte(byte) => write!(f, "byte {byte}"),
            Location::Cell(cell) => write!(f, "cell {cell}"),
            Location::Whole => write!(f, "the whole file"),
        }
    }
}
