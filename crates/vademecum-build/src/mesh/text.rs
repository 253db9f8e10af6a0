//! Strict reading of text and binary files, position by position, so that every fault has a place.
//!
//! Nothing here allocates from a number the file declares: counts are bounded by the bytes that are left.

use std::path::Path;

use super::error::{FaultSite, MeshError, shown};
use super::place::Location;

/// A cursor over a file that is read by lines, by tokens or by bytes.
pub(crate) struct Text<'a> {
    pub(crate) file: &'a Path,
    bytes: &'a [u8],
    pos: usize,
    line: usize,
    /// Faults are placed by byte from here on (a binary section has no lines).
    pub(crate) binary: bool,
    /// The section being read, for messages.
    pub(crate) section: String,
}

/// Byte order of a binary section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Endian {
    Little,
    Big,
}

impl<'a> Text<'a> {
    pub(crate) fn new(file: &'a Path, bytes: &'a [u8]) -> Self {
        Text { file, bytes, pos: 0, line: 0, binary: false, section: "the file".into() }
    }

    /// Bytes not read yet.
    pub(crate) fn left(&self) -> usize {
        self.bytes.len() - self.pos
    }

    pub(crate) fn pos(&self) -> usize {
        self.pos
    }

    /// The place of what was read last.
    pub(crate) fn place(&self) -> Location {
        if self.binary { Location::Byte(self.pos) } else { Location::Line(self.line.max(1)) }
    }

    /// Number of the line that was read last, from 1.
    pub(crate) fn line_number(&self) -> usize {
        self.line
    }

    pub(crate) fn at(&self) -> FaultSite<'_> {
        FaultSite { file: self.file, place: self.place(), section: &self.section }
    }

    pub(crate) fn malformed(&self, found: &[u8], expected: impl Into<String>) -> MeshError {
        self.at().malformed(shown(found), expected)
    }

    /// The next line without its end, trimmed, blank ones included; none at the end of the file.
    pub(crate) fn raw_line(&mut self) -> Option<&'a [u8]> {
        if self.pos >= self.bytes.len() {
            return None;
        }
        let rest = &self.bytes[self.pos..];
        let end = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.pos = (self.pos + end + 1).min(self.bytes.len());
        self.line += 1;
        Some(rest[..end].trim_ascii())
    }

    /// The next line that is not blank.
    pub(crate) fn next_line(&mut self) -> Option<&'a [u8]> {
        loop {
            let line = self.raw_line()?;
            if !line.is_empty() {
                return Some(line);
            }
        }
    }

    /// The next line that is not blank; the end of the file is a fault.
    pub(crate) fn line(&mut self, expected: &str) -> Result<&'a [u8], MeshError> {
        match self.next_line() {
            Some(line) => Ok(line),
            None => Err(self.at().malformed("the end of the file", expected)),
        }
    }

    /// The next line must be `word`.
    pub(crate) fn literal(&mut self, word: &str) -> Result<(), MeshError> {
        let line = self.line(word)?;
        if line == word.as_bytes() { Ok(()) } else { Err(self.malformed(line, format!("`{word}`"))) }
    }

    /// The next token separated by white space, over line ends; none at the end of the file.
    pub(crate) fn next_token(&mut self) -> Option<&'a [u8]> {
        self.skip_white();
        let rest = &self.bytes[self.pos..];
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.pos += end;
        if end == 0 { None } else { Some(&rest[..end]) }
    }

    fn skip_white(&mut self) {
        self.line = self.line.max(1);
        while let Some(&b) = self.bytes.get(self.pos).filter(|b| b.is_ascii_whitespace()) {
            self.line += usize::from(b == b'\n');
            self.pos += 1;
        }
    }

    /// The next token without taking it.
    pub(crate) fn peek_token(&mut self) -> Option<&'a [u8]> {
        let (pos, line) = (self.pos, self.line);
        let token = self.next_token();
        (self.pos, self.line) = (pos, line);
        token
    }

    pub(crate) fn token(&mut self, expected: &str) -> Result<&'a [u8], MeshError> {
        match self.next_token() {
            Some(token) => Ok(token),
            None => Err(self.at().malformed("the end of the file", expected)),
        }
    }

    /// The next token as a number.
    pub(crate) fn number<T: ParsedNumber>(&mut self, expected: &str) -> Result<T, MeshError> {
        let token = self.token(expected)?;
        T::parse(token).ok_or_else(|| self.malformed(token, expected))
    }

    /// `N` numbers that stand alone on `line`.
    pub(crate) fn exactly<T: ParsedNumber, const N: usize>(
        &self,
        line: &[u8],
        expected: &str,
    ) -> Result<[T; N], MeshError> {
        let mut out = [T::default(); N];
        let mut tokens = tokens(line);
        for value in &mut out {
            *value = tokens.next().and_then(T::parse).ok_or_else(|| self.malformed(line, expected))?;
        }
        if tokens.next().is_some() { Err(self.malformed(line, expected)) } else { Ok(out) }
    }

    /// A declared count, believed only if the rest of the file can hold that many items of `least` bytes.
    pub(crate) fn bounded(&self, count: u64, least: usize, what: &str) -> Result<usize, MeshError> {
        let most = self.left() / least + 1;
        match usize::try_from(count) {
            Ok(n) if n <= most && count < u64::from(u32::MAX) => Ok(n),
            _ => {
                let found = format!("a count of {count} {what}");
                let left = self.left();
                Err(self.at().malformed(found, format!("no more than the remaining {left} bytes can hold")))
            }
        }
    }

    /// The next `n` bytes; too few left is a fault.
    pub(crate) fn take(&mut self, n: usize, what: &str) -> Result<&'a [u8], MeshError> {
        if n > self.left() {
            let found = format!("{} bytes to the end of the file", self.left());
            return Err(self.at().malformed(found, format!("{n} bytes of {what}")));
        }
        let out = &self.bytes[self.pos..self.pos + n];
        self.pos += n;
        Ok(out)
    }

    /// One binary value.
    pub(crate) fn value<T: Binary>(&mut self, endian: Endian, what: &str) -> Result<T, MeshError> {
        Ok(T::from_bytes(self.take(T::SIZE, what)?, endian))
    }

    /// The rest of the file.
    pub(crate) fn rest(&self) -> &'a [u8] {
        &self.bytes[self.pos..]
    }
}

/// Tokens of a line.
pub(crate) fn tokens(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(|b| b.is_ascii_whitespace()).filter(|t| !t.is_empty())
}

/// A number written in text: finite if real.
pub(crate) trait ParsedNumber: Sized + Copy + Default {
    fn parse(token: &[u8]) -> Option<Self>;
}

impl ParsedNumber for u64 {
    fn parse(token: &[u8]) -> Option<u64> {
        std::str::from_utf8(token).ok()?.parse().ok()
    }
}

impl ParsedNumber for i64 {
    fn parse(token: &[u8]) -> Option<i64> {
        std::str::from_utf8(token).ok()?.parse().ok()
    }
}

impl ParsedNumber for f64 {
    fn parse(token: &[u8]) -> Option<f64> {
        let text = std::str::from_utf8(token).ok()?;
        // Fortran programs write the exponent of a double with a D.
        let value: f64 = match text.parse() {
            Ok(value) => value,
            Err(_) => text.replace(['d', 'D'], "e").parse().ok()?,
        };
        value.is_finite().then_some(value)
    }
}

/// A number stored in bytes.
pub(crate) trait Binary: Sized + Copy {
    const SIZE: usize;
    /// `bytes` holds exactly `SIZE` bytes.
    fn from_bytes(bytes: &[u8], endian: Endian) -> Self;
}

macro_rules! binary {
    ($($t:ty),*) => {$(
        impl Binary for $t {
            const SIZE: usize = size_of::<$t>();
            fn from_bytes(bytes: &[u8], endian: Endian) -> $t {
                let mut word = [0; size_of::<$t>()];
                word.copy_from_slice(bytes);
                match endian {
                    Endian::Little => <$t>::from_le_bytes(word),
                    Endian::Big => <$t>::from_be_bytes(word),
                }
            }
        }
    )*};
}
binary!(i8, u8, i16, u16, i32, u32, i64, u64, f32, f64);
