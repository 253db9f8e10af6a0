//! Data of a sub-step of the strain structure: the lengths of its parts, the map, and lent memory.

use crate::base::lend::{Lender, Short};
use crate::base::scalar::Scalar;

/// Numbers of a row handled at once; rows are padded to multiples of it.
pub(crate) const PANEL: usize = 8;
/// Numbers of a tail coordinate in a map: `x √w`, `2 x/√w`, `W x/(a √w)` and `1/a`.
pub(crate) const TAIL: usize = 4;

/// The lengths of a strain structure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct StrainShape {
    /// `n`: coordinates that interact.
    pub interacting: usize,
    /// `n + n₁`: leading coordinates, all but the tail; and leading rows.
    pub leading: usize,
    /// Coordinates of the tail, and their rows.
    pub tail: usize,
    /// Rows in all.
    pub rows: usize,
}

impl StrainShape {
    /// Length of a padded row.
    pub const fn padded(&self) -> usize {
        self.leading.next_multiple_of(PANEL)
    }

    /// Numbers of a row whose products are formed together.
    pub const fn width(&self) -> usize {
        match self.padded() {
            n if n.is_multiple_of(24) => 24,
            n if n.is_multiple_of(16) => 16,
            _ => PANEL,
        }
    }

    /// Numbers of the quadratic part of a row.
    pub const fn row_len(&self) -> usize {
        let (mut sum, mut start) = (0, 0);
        while start < self.padded() {
            sum += self.columns(start) * self.width();
            start += self.width();
        }
        sum
    }

    /// Numbers of a row for all coordinates: as many as there are, or as a padded row has.
    pub const fn coordinates(&self) -> usize {
        let (all, padded) = (self.leading + self.tail, self.padded());
        if all > padded { all } else { padded }
    }

    /// Length of the map: linear part, quadratic part, numbers of rows, of tail coordinates, and of all
    /// coordinates.
    pub const fn map_len(&self) -> usize {
        let row = self.padded() + self.row_len() + ROW;
        self.rows.saturating_mul(row).saturating_add(self.tail * TAIL + 2 * self.coordinates())
    }

    /// Length of the memory a step works in.
    pub const fn scratch_len(&self) -> usize {
        let n = self.padded();
        self.rows.saturating_mul(n).saturating_add(2 * n * n + 7 * n + 2 * self.tail)
    }
}

/// Numbers of a row beside its map: of the force, and of the dissipation.
pub(crate) const ROW: usize = 2;

/// The map of a bound scene. With `w` the weight of a row, all of a row is multiplied by `√w`.
#[derive(Clone, Copy)]
pub(crate) struct StrainMap<'s, T> {
    pub shape: StrainShape,
    /// `L̂`, `(rows, padded)`.
    pub linear: &'s [T],
    /// `Q̂`, row by row in blocks of [`StrainShape::width`] numbers, each block column by column.
    pub quadratic: &'s [T],
    /// `2/w` and `(W − 1)/w` of each row.
    pub rows: &'s [[T; ROW]],
    /// [`TAIL`] numbers of each tail coordinate.
    pub tail: &'s [[T; TAIL]],
    /// Inertia `m` of each coordinate, 1 but for natural modes. Padding has some positive number.
    pub inertia: &'s [T],
    /// `√m`.
    pub roots: &'s [T],
    /// Factor of the inertia on the diagonal, `1 + k α/2`.
    pub mass: T,
    /// `true` if anything takes energy.
    pub damped: bool,
}

impl<'s, T> StrainMap<'s, T> {
    /// Cuts the memory of a scene.
    pub fn new(shape: StrainShape, mass: T, damped: bool, memory: &'s [T]) -> Result<Self, Short> {
        let mut memory = Lender::new(memory);
        Ok(Self {
            shape,
            linear: memory.take(shape.rows * shape.padded())?,
            quadratic: memory.take(shape.rows * shape.row_len())?,
            rows: memory.take(shape.rows * ROW)?.as_chunks().0,
            tail: memory.take(shape.tail * TAIL)?.as_chunks().0,
            inertia: memory.take(shape.coordinates())?,
            roots: memory.take(shape.coordinates())?,
            mass,
            damped,
        })
    }

    /// `p = k ζ̇/√m` of a coordinate, from `k ζ̇`.
    ///
    /// It is divided, not multiplied by an inverse: there and back again a march of many steps would grow.
    pub fn p_of(&self, coordinate: usize, rate: f64) -> f64
    where
        T: Scalar,
    {
        self.roots.get(coordinate).map_or(rate, |root| rate / root.to_f64())
    }
}

/// The memory a step works in.
pub(crate) struct Scratch<'s, T> {
    /// `ĝ` in panels: the first [`PANEL`] numbers of every row, then the next.
    pub rows: &'s mut [[T; PANEL]],
    /// The matrix, `(padded, padded)`, of which the upper half is used, and its factor.
    pub matrix: &'s mut [T],
    /// Remainders of its numbers below their rounding, and of those of `solution`, where the factor is
    /// [`crate::strain_wide`].
    pub low: [&'s mut [T]; 2],
    /// Quality of the factor.
    pub digits: Digits,
    /// `1/pivot`.
    pub inverse: &'s mut [T],
    /// `q`, `(q − p)/2` and the mean displacement of the leading coordinates.
    pub place: [&'s mut [T]; 3],
    /// Right-hand side of the leading coordinates.
    pub leading: &'s mut [T],
    /// `d` of the leading coordinates.
    pub solution: &'s mut [T],
    /// Right-hand side of the tail coordinates, then `d`.
    pub tail: &'s mut [T],
    /// `ĝ·d` of the leading coordinates in each tail row.
    pub along: &'s mut [T],
}

impl<'s, T: Scalar> Scratch<'s, T> {
    /// Cuts lent memory.
    pub fn new(shape: StrainShape, memory: &'s mut [T]) -> Result<Self, Short> {
        let (n, mut memory) = (shape.padded(), Lender::new(memory));
        let rows = memory.take(shape.rows * n)?.as_chunks_mut().0;
        let matrix = memory.take(n * n)?;
        let inverse = memory.take(n)?;
        let place = [memory.take(n)?, memory.take(n)?, memory.take(n)?];
        let (leading, solution) = (memory.take(n)?, memory.take(n)?);
        let (tail, along) = (memory.take(shape.tail)?, memory.take(shape.tail)?);
        let low = [memory.take(n * n)?, memory.take(n)?];
        Ok(Self { rows, matrix, low, digits: Digits::Enough, inverse, place, leading, solution, tail, along })
    }
}

/// Quality of a factor after rounding, in which the mass is beside the largest pivot.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Digits {
    /// Rounding of the matrix does not show.
    Enough,
    /// It would show in the energy.
    Worn,
    /// It hides the mass: softer directions are noise.
    Lost,
}
