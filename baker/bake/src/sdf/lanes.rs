//! Single-precision numbers of the eight points of a packet: what the search asks of them, and the way of the baseline.

use std::ops::{Add, Mul, Sub};
use wide::f32x8;

/// Points of a packet.
pub(crate) const LANES: usize = 8;

/// One number of each point, in memory.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(32))]
pub(crate) struct Row(pub [f32; LANES]);

impl Row {
    pub const INFINITE: Row = Row([f32::INFINITY; LANES]);
}

/// One number of each point, in registers. What is done with them may be rounded differently from processor to
/// processor; the search allows for it.
pub(crate) trait Lanes: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    fn splat(number: f32) -> Self;
    fn load(row: &Row) -> Self;
    fn store(self) -> Row;
    /// `self * factor + addend`.
    fn mul_add(self, factor: Self, addend: Self) -> Self;
    /// The smaller and the larger of two numbers; anything where one is none.
    fn min(self, other: Self) -> Self;
    fn max(self, other: Self) -> Self;
    fn abs(self) -> Self;
    fn sqrt(self) -> Self;
    /// Bit by bit, whether the number is at most `limit`.
    fn within(self, limit: Self) -> u32;
    /// The number where `condition` is above 0, else 0.
    fn where_positive(self, condition: Self) -> Self;
}

/// What can be done with any [`Lanes`].
pub(crate) trait Vectorized {
    type Output;
    /// Must be inlined, to be compiled for the processor that has the lanes.
    fn run<V: Lanes>(self) -> Self::Output;
}

impl Lanes for f32x8 {
    #[inline(always)]
    fn splat(number: f32) -> f32x8 {
        f32x8::splat(number)
    }

    #[inline(always)]
    fn load(row: &Row) -> f32x8 {
        f32x8::new(row.0)
    }

    #[inline(always)]
    fn store(self) -> Row {
        Row(self.to_array())
    }

    /// Rounded twice: the baseline of x86-64 has no fused operation.
    #[inline(always)]
    fn mul_add(self, factor: f32x8, addend: f32x8) -> f32x8 {
        self * factor + addend
    }

    #[inline(always)]
    fn min(self, other: f32x8) -> f32x8 {
        self.fast_min(other)
    }

    #[inline(always)]
    fn max(self, other: f32x8) -> f32x8 {
        self.fast_max(other)
    }

    #[inline(always)]
    fn abs(self) -> f32x8 {
        f32x8::abs(self)
    }

    #[inline(always)]
    fn sqrt(self) -> f32x8 {
        f32x8::sqrt(self)
    }

    #[inline(always)]
    fn within(self, limit: f32x8) -> u32 {
        self.simd_le(limit).to_bitmask()
    }

    #[inline(always)]
    fn where_positive(self, condition: f32x8) -> f32x8 {
        condition.simd_gt(f32x8::ZERO) & self
    }
}
