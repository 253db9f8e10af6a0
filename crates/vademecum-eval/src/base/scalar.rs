//! The two precisions a scene can step in.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Mul, Sub};

mod sealed {
    use crate::sections::short_rows::{QUAD, short_rows, short_rows_f32};

    /// Closed to others, with the kernel that differs.
    pub trait Sealed: Sized {
        /// `scale B x` for rows of `4 Q` binary32 numbers.
        fn short_rows_f32<const Q: usize>(
            rows: &[[u8; 4]],
            x: &[[Self; QUAD]; Q],
            scale: Self,
            out: &mut [Self],
        );

        /// The numbers that fit into lent words.
        fn of_words(words: &mut [f64]) -> &mut [Self];
    }

    impl Sealed for f32 {
        fn of_words(words: &mut [f64]) -> &mut [Self] {
            bytemuck::cast_slice_mut(words)
        }

        fn short_rows_f32<const Q: usize>(
            rows: &[[u8; 4]],
            x: &[[Self; QUAD]; Q],
            scale: Self,
            out: &mut [Self],
        ) {
            short_rows_f32(rows, x, scale, out);
        }
    }

    impl Sealed for f64 {
        fn of_words(words: &mut [f64]) -> &mut [Self] {
            words
        }

        fn short_rows_f32<const Q: usize>(
            rows: &[[u8; 4]],
            x: &[[Self; QUAD]; Q],
            scale: Self,
            out: &mut [Self],
        ) {
            short_rows(rows, x, scale, out, |bytes| Self::from(f32::from_le_bytes(bytes)));
        }
    }
}

/// `f32` or `f64`.
///
/// The methods are inlined by force: scenes are instantiated in the caller's crate, and one call left in a
/// kernel costs four times the kernel.
pub trait Scalar:
    sealed::Sealed
    + Copy
    + Debug
    + Default
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + AddAssign
{
    /// Zero.
    const ZERO: Self;
    /// Relative error of one rounding.
    const EPSILON: f64;
    /// State numbers \[m kg^½\] smaller than this are set to zero after each step. Products with coefficients
    /// down to 1e-13 (`f32`) stay normal numbers, so a body that comes to rest never pays for denormals.
    const FLOOR: Self;
    /// Smallest threshold \[m kg^½\] at which an unloaded body is put at rest: a million times the floor.
    const REST: Self;
    /// Largest size of a force \[N\], of an amplitude, of a step parameter and of the sum of a state's
    /// numbers \[m kg^½\]: what a scene computes of them is finite. A step parameter that is not zero is at
    /// least its inverse.
    const LARGEST: Self;
    /// Rounds to this precision.
    fn from_f64(value: f64) -> Self;
    /// Rounds (or keeps) a binary32 number.
    fn from_f32(value: f32) -> Self;
    /// Exact.
    fn from_i16(value: i16) -> Self;
    /// Exact.
    fn to_f64(self) -> f64;
    /// Absolute value.
    #[must_use]
    fn magnitude(self) -> Self;
    /// `true` of a number that is at most [`Scalar::LARGEST`] in size; `false` of one that is not a number.
    #[must_use]
    #[inline(always)]
    fn in_range(self) -> bool {
        self.magnitude() <= Self::LARGEST
    }
}

impl Scalar for f32 {
    const ZERO: Self = 0.0;
    const EPSILON: f64 = f32::EPSILON as f64 / 2.0;
    const FLOOR: Self = 1e-24;
    const REST: Self = 1e-18;
    const LARGEST: Self = 1e18;

    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        value as f32
    }

    #[inline(always)]
    fn from_f32(value: f32) -> Self {
        value
    }

    #[inline(always)]
    fn from_i16(value: i16) -> Self {
        Self::from(value)
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }

    #[inline(always)]
    fn magnitude(self) -> Self {
        self.abs()
    }
}

impl Scalar for f64 {
    const ZERO: Self = 0.0;
    const EPSILON: f64 = f64::EPSILON / 2.0;
    const FLOOR: Self = 1e-250;
    const REST: Self = 1e-244;
    const LARGEST: Self = 1e75;

    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn from_f32(value: f32) -> Self {
        f64::from(value)
    }

    #[inline(always)]
    fn from_i16(value: i16) -> Self {
        Self::from(value)
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }

    #[inline(always)]
    fn magnitude(self) -> Self {
        self.abs()
    }
}
