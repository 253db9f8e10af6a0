//! Numbers in bytes, in and out, in little-endian order.

/// Reads one number after the other.
#[derive(Debug)]
pub struct Cursor<'a> {
    rest: &'a [u8],
}

impl<'a> Cursor<'a> {
    /// From the start.
    #[must_use]
    pub const fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    /// The next bytes.
    pub fn take(&mut self, length: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.rest.split_at_checked(length)?;
        self.rest = rest;
        Some(taken)
    }

    fn chunk<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.rest.split_first_chunk()?;
        self.rest = rest;
        Some(*taken)
    }

    /// The next number.
    pub fn u32(&mut self) -> Option<u32> {
        self.chunk().map(u32::from_le_bytes)
    }

    /// The next number.
    pub fn f64(&mut self) -> Option<f64> {
        self.chunk().map(f64::from_le_bytes)
    }

    /// Fills all places with the next numbers.
    pub fn numbers(&mut self, out: &mut [f64]) -> Option<()> {
        for place in out {
            *place = self.f64()?;
        }
        Some(())
    }
}

/// Writes one number after the other.
#[derive(Debug)]
pub struct Pen<'a> {
    rest: &'a mut [u8],
}

impl<'a> Pen<'a> {
    /// From the start.
    #[must_use]
    pub const fn new(bytes: &'a mut [u8]) -> Self {
        Self { rest: bytes }
    }

    /// Writes these bytes; `None` if there is no room.
    pub fn put(&mut self, bytes: &[u8]) -> Option<()> {
        let (place, rest) = core::mem::take(&mut self.rest).split_at_mut_checked(bytes.len())?;
        place.iter_mut().zip(bytes).for_each(|(place, &byte)| *place = byte);
        self.rest = rest;
        Some(())
    }

    /// Writes these numbers; `None` if there is no room.
    pub fn numbers(&mut self, numbers: &[f64]) -> Option<()> {
        for number in numbers {
            self.put(&number.to_le_bytes())?;
        }
        Some(())
    }
}

/// Writes numbers over others.
pub fn copy(from: &[f64], to: &mut [f64]) {
    to.iter_mut().zip(from).for_each(|(to, &from)| *to = from);
}
