//! Rows of numbers that are a line in a text file and a run of bytes in a binary one.

use super::error::MeshError;
use super::text::{Binary, Endian, ParsedNumber, Text, tokens};

/// Reads rows from text or binary alike.
pub(crate) struct RowReader<'a> {
    pub(crate) text: Text<'a>,
    endian: Option<Endian>,
    line: &'a [u8],
    rest: &'a [u8],
}

impl<'a> RowReader<'a> {
    pub(crate) fn new(text: Text<'a>, endian: Option<Endian>) -> Self {
        RowReader { text, endian, line: b"", rest: b"" }
    }

    pub(crate) fn is_binary(&self) -> bool {
        self.endian.is_some()
    }

    /// Starts a row; in text that is the next line.
    pub(crate) fn begin(&mut self, expected: &str) -> Result<(), MeshError> {
        if self.endian.is_none() {
            self.line = self.text.line(expected)?;
            self.rest = self.line;
        }
        Ok(())
    }

    /// Goes to the next line of a text file where a row may be broken over lines.
    pub(crate) fn begin_if_line_ended(&mut self, expected: &str) -> Result<(), MeshError> {
        if self.line_is_empty() { self.begin(expected) } else { Ok(()) }
    }

    /// Ends a row; in text nothing may be left on the line.
    pub(crate) fn end(&mut self, expected: &str) -> Result<(), MeshError> {
        if self.endian.is_none() && tokens(self.rest).next().is_some() {
            return Err(self.text.malformed(self.line, expected));
        }
        Ok(())
    }

    fn next<T: ParsedNumber + Binary>(&mut self, expected: &str) -> Result<T, MeshError> {
        if let Some(endian) = self.endian {
            return self.text.value(endian, expected);
        }
        let rest = self.rest.trim_ascii_start();
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.rest = &rest[length..];
        T::parse(&rest[..length]).ok_or_else(|| self.text.malformed(self.line, expected))
    }

    /// A 32-bit integer of a binary file.
    pub(crate) fn int(&mut self, expected: &str) -> Result<i64, MeshError> {
        match self.endian {
            Some(endian) => Ok(i64::from(self.text.value::<i32>(endian, expected)?)),
            None => self.next::<i64>(expected),
        }
    }

    /// A 64-bit count or tag of a binary file.
    pub(crate) fn size(&mut self, expected: &str) -> Result<u64, MeshError> {
        self.next::<u64>(expected)
    }

    /// A finite real.
    pub(crate) fn real(&mut self, expected: &str) -> Result<f64, MeshError> {
        let value: f64 = self.next(expected)?;
        if value.is_finite() {
            return Ok(value);
        }
        Err(self.text.at().malformed(format!("{value}"), format!("{expected}, finite")))
    }

    /// Three finite reals.
    pub(crate) fn point(&mut self, expected: &str) -> Result<[f64; 3], MeshError> {
        Ok([self.real(expected)?, self.real(expected)?, self.real(expected)?])
    }

    /// A node or element number: a positive 32-bit integer of a binary file.
    pub(crate) fn id(&mut self, expected: &str) -> Result<u64, MeshError> {
        let value = self.int(expected)?;
        u64::try_from(value).map_err(|_| self.text.at().malformed(format!("{value}"), expected))
    }

    /// The rest of the line of a text row; none in a binary row.
    pub(crate) fn line_is_empty(&self) -> bool {
        self.endian.is_none() && tokens(self.rest).next().is_none()
    }
}
