//! Four numbers at a time: what the evaluation asks of them, and the plain way to do it.
//!
//! Every operation is that of IEEE 754 on each number, nothing is fused or reordered: so whatever does it
//! ([`Plain`], `avx2.rs`), the bits are the same.

use std::ops::{Add, Div, Mul, Sub};

/// Points that are evaluated together.
pub(crate) const LANES: usize = 4;

/// One number for each of four points.
pub(crate) trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    fn new(numbers: [f64; LANES]) -> Self;
    fn widen(numbers: [f32; LANES]) -> Self;
    fn splat(number: f64) -> Self;
    fn array(self) -> [f64; LANES];
    fn sqrt(self) -> Self;
    /// The greatest integer not above the number, if that is in 0 .. 2^51.
    fn floor(self) -> Self;
    /// The smaller one; `limit` for NaN.
    fn min(self, limit: Self) -> Self;
    /// The larger one; `limit` for NaN.
    fn max(self, limit: Self) -> Self;
    /// Zero where the number is not below `limit`, or NaN.
    fn zero_unless_below(self, limit: Self) -> Self;
    /// Bit by bit, whether the number is in 0 ..= `limit`.
    fn within(self, limit: Self) -> u32;
    /// Rows for columns.
    fn transpose(rows: [Self; LANES]) -> [Self; LANES];
}

/// What can be done with any [`Lanes`].
pub(crate) trait Vectorized {
    /// Must be inlined, to be compiled for the processor that has the lanes.
    fn run<V: Lanes>(self);
}

/// An array, of which the compiler makes the vectors that the target's baseline has.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct Plain([f64; LANES]);

impl Plain {
    #[inline(always)]
    fn zip(self, other: Plain, f: impl Fn(f64, f64) -> f64) -> Plain {
        let [a, b] = [self.0, other.0];
        Plain([f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2]), f(a[3], b[3])])
    }
}

impl Add for Plain {
    type Output = Plain;
    #[inline(always)]
    fn add(self, other: Plain) -> Plain {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for Plain {
    type Output = Plain;
    #[inline(always)]
    fn sub(self, other: Plain) -> Plain {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for Plain {
    type Output = Plain;
    #[inline(always)]
    fn mul(self, other: Plain) -> Plain {
        self.zip(other, |a, b| a * b)
    }
}

impl Div for Plain {
    type Output = Plain;
    #[inline(always)]
    fn div(self, other: Plain) -> Plain {
        self.zip(other, |a, b| a / b)
    }
}

impl Lanes for Plain {
    #[inline(always)]
    fn new(numbers: [f64; LANES]) -> Plain {
        Plain(numbers)
    }

    #[inline(always)]
    fn widen([a, b, c, d]: [f32; LANES]) -> Plain {
        Plain([f64::from(a), f64::from(b), f64::from(c), f64::from(d)])
    }

    #[inline(always)]
    fn splat(number: f64) -> Plain {
        Plain([number; LANES])
    }

    #[inline(always)]
    fn array(self) -> [f64; LANES] {
        self.0
    }

    #[inline(always)]
    fn sqrt(self) -> Plain {
        Plain([self.0[0].sqrt(), self.0[1].sqrt(), self.0[2].sqrt(), self.0[3].sqrt()])
    }

    #[inline(always)]
    fn floor(self) -> Plain {
        // x86-64's baseline has no such instruction; the sum with 2^52 rounds to the nearest integer.
        const INTEGERS: f64 = (1u64 << 52) as f64;
        self.zip(self, |x, _| {
            let nearest = (x + INTEGERS) - INTEGERS;
            if nearest > x { nearest - 1.0 } else { nearest }
        })
    }

    #[inline(always)]
    fn min(self, limit: Plain) -> Plain {
        self.zip(limit, |x, limit| if x < limit { x } else { limit })
    }

    #[inline(always)]
    fn max(self, limit: Plain) -> Plain {
        self.zip(limit, |x, limit| if x > limit { x } else { limit })
    }

    #[inline(always)]
    fn zero_unless_below(self, limit: Plain) -> Plain {
        self.zip(limit, |x, limit| if x < limit { x } else { 0.0 })
    }

    #[inline(always)]
    fn within(self, limit: Plain) -> u32 {
        let mut bits = 0;
        for lane in 0..LANES {
            bits |= u32::from((self.0[lane] >= 0.0) & (self.0[lane] <= limit.0[lane])) << lane;
        }
        bits
    }

    #[inline(always)]
    fn transpose([a, b, c, d]: [Plain; LANES]) -> [Plain; LANES] {
        let [a, b, c, d] = [a.0, b.0, c.0, d.0];
        [
            Plain([a[0], b[0], c[0], d[0]]),
            Plain([a[1], b[1], c[1], d[1]]),
            Plain([a[2], b[2], c[2], d[2]]),
            Plain([a[3], b[3], c[3], d[3]]),
        ]
    }
}
