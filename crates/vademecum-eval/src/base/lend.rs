//! Cutting lent memory into pieces whose lengths are known before.
//!
//! Every length was checked against what was lent before the first cut, so a cut that does not fit is a
//! mistake inside this crate. It is returned as an error nevertheless: a piece that came out empty would
//! otherwise pass for a body that never moves.

use crate::base::error::{BindError, LoadError, OutputError, StepError};

/// A slice, shared or not, that can be cut in two.
pub(crate) trait Cut: Default {
    /// The first `n` numbers and the rest; `None` if there are fewer.
    fn cut(self, n: usize) -> Option<(Self, Self)>;
    /// Length.
    fn count(&self) -> usize;
}

impl<T> Cut for &[T] {
    fn cut(self, n: usize) -> Option<(Self, Self)> {
        self.split_at_checked(n)
    }

    fn count(&self) -> usize {
        self.len()
    }
}

impl<T> Cut for &mut [T] {
    fn cut(self, n: usize) -> Option<(Self, Self)> {
        self.split_at_mut_checked(n)
    }

    fn count(&self) -> usize {
        self.len()
    }
}

/// Hands out one piece of a slice after the other.
#[derive(Debug)]
pub(crate) struct Lender<S> {
    rest: S,
    taken: usize,
}

impl<S: Cut> Lender<S> {
    /// Lends from `slice`, from its start.
    pub fn new(slice: S) -> Self {
        Self { rest: slice, taken: 0 }
    }

    /// The next `n` numbers.
    pub fn take(&mut self, n: usize) -> Result<S, Short> {
        let (found, needed) = (self.taken.saturating_add(self.rest.count()), self.taken.saturating_add(n));
        let (piece, rest) = core::mem::take(&mut self.rest).cut(n).ok_or(Short { found, needed })?;
        self.rest = rest;
        self.taken = needed;
        Ok(piece)
    }

    /// Whatever is left.
    pub fn rest(self) -> S {
        self.rest
    }
}

/// Writes `value` at a place of `all`.
pub(crate) fn put<T>(all: &mut [T], at: usize, value: T) -> Result<(), Short> {
    let short = Short { found: all.len(), needed: at.saturating_add(1) };
    *all.get_mut(at).ok_or(short)? = value;
    Ok(())
}

/// A slice that is shorter than the pieces asked of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Short {
    /// Its length.
    pub found: usize,
    /// The length of all pieces so far.
    pub needed: usize,
}

impl From<Short> for BindError {
    fn from(Short { found, needed }: Short) -> Self {
        Self::LentMemory { found, needed }
    }
}

impl From<Short> for OutputError {
    fn from(Short { found, needed }: Short) -> Self {
        Self::Length { found, needed }
    }
}

impl From<Short> for StepError {
    fn from(_: Short) -> Self {
        Self::Mismatch
    }
}

impl From<Short> for LoadError {
    fn from(_: Short) -> Self {
        Self::Mismatch
    }
}

#[cfg(test)]
mod tests {
    use super::{Lender, Short};
    use crate::base::error::BindError;

    #[test]
    fn pieces_follow_each_other_and_one_too_many_is_an_error() {
        let mut memory = [1, 2, 3, 4, 5];
        let mut lender = Lender::new(&mut memory[..]);
        assert_eq!(lender.take(2), Ok(&mut [1, 2][..]));
        assert_eq!(lender.take(0), Ok(&mut [][..]));
        assert_eq!(lender.take(2), Ok(&mut [3, 4][..]));
        let short = lender.take(2);
        assert_eq!(short, Err(Short { found: 5, needed: 6 }));
        assert_eq!(
            short.map(|_| ()).map_err(BindError::from),
            Err(BindError::LentMemory { found: 5, needed: 6 })
        );
    }

    #[test]
    fn what_is_left_comes_last() {
        let numbers = [1, 2, 3];
        let mut lender = Lender::new(&numbers[..]);
        assert_eq!(lender.take(1), Ok(&numbers[..1]));
        assert_eq!(lender.rest(), &numbers[1..]);
        assert_eq!(Lender::new(&numbers[..]).take(usize::MAX), Err(Short { found: 3, needed: usize::MAX }));
    }
}
