//! Eight pairs at a time: what the sums over neighbours ask of a vector, and the plain way to do it.
//!
//! Every operation is that of IEEE 754 on each number, nothing is fused, estimated or reordered: so whatever does it
//! ([`Plain`], `avx2.rs`), the bits are the same.

use std::ops::{Add, Div, Mul, Sub};

/// Pairs that are evaluated together.
pub const LANES: usize = 8;

/// Four numbers of a particle, which are read together: a place and one more, or a vector.
pub type Quad = [f32; 4];

/// Eight neighbours: four times their indices, which is where their quads begin in a table of numbers.
pub type Group = [u32; LANES];

/// One number for each of eight pairs.
pub(crate) trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    fn splat(number: f32) -> Self;
    fn load(numbers: &[f32; LANES]) -> Self;
    fn array(self) -> [f32; LANES];
    fn sqrt(self) -> Self;
    /// The greater one; `other` for NaN.
    fn max(self, other: Self) -> Self;
    /// Bit by bit, whether the number is below the other one.
    fn below(self, other: Self) -> u32;
    /// The quads of these neighbours in each table, turned: first numbers, second numbers... Tables of one length.
    fn gather<const N: usize>(tables: [&[Quad]; N], group: &Group) -> [[Self; 4]; N];

    /// Puts those whose bits are set to the front, in order; what comes behind them is of no use.
    #[inline(always)]
    fn compress(numbers: &[u32; LANES], bits: u32) -> [u32; LANES] {
        let (mut out, mut count, mut rest) = ([0; LANES], 0, bits);
        while rest != 0 {
            out[count] = numbers[rest.trailing_zeros() as usize];
            count += 1;
            rest &= rest - 1;
        }
        out
    }

    /// The sum of all eight, halves first.
    #[inline(always)]
    fn sum(self) -> f32 {
        let [a, b, c, d, e, f, g, h] = self.array();
        ((a + e) + (c + g)) + ((b + f) + (d + h))
    }
}

/// What can be done with any [`Lanes`].
pub(crate) trait Work {
    /// Must be inlined, to be compiled for the processor that has the lanes.
    fn run<V: Lanes>(self);
}

/// Does the work with the widest vectors that this processor has.
#[inline]
pub(crate) fn dispatch(work: impl Work) {
    #[cfg(target_arch = "x86_64")]
    let Some(work) = super::avx2::run(work) else { return };
    work.run::<Plain>();
}

/// An array, of which the compiler makes the vectors that the target's baseline has.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct Plain([f32; LANES]);

impl Plain {
    #[inline(always)]
    fn zip(self, other: Plain, f: impl Fn(f32, f32) -> f32) -> Plain {
        let mut out = self;
        for (out, other) in out.0.iter_mut().zip(other.0) {
            *out = f(*out, other);
        }
        out
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
    fn splat(number: f32) -> Plain {
        Plain([number; LANES])
    }

    #[inline(always)]
    fn load(numbers: &[f32; LANES]) -> Plain {
        Plain(*numbers)
    }

    #[inline(always)]
    fn array(self) -> [f32; LANES] {
        self.0
    }

    #[inline(always)]
    fn sqrt(self) -> Plain {
        self.zip(self, |a, _| a.sqrt())
    }

    #[inline(always)]
    fn max(self, other: Plain) -> Plain {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn below(self, other: Plain) -> u32 {
        (0..LANES).fold(0, |bits, lane| bits | u32::from(self.0[lane] < other.0[lane]) << lane)
    }

    #[inline(always)]
    fn gather<const N: usize>(tables: [&[Quad]; N], group: &Group) -> [[Plain; 4]; N] {
        tables.map(|table| {
            let mut out = [[0.0; LANES]; 4];
            for (lane, &begin) in group.iter().enumerate() {
                let quad = table[begin as usize / 4];
                for (out, number) in out.iter_mut().zip(quad) {
                    out[lane] = number;
                }
            }
            out.map(Plain)
        })
    }
}
