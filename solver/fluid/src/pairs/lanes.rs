//! Eight numbers at a time: what the search for neighbours and the sums over them ask of a vector, and the plain way
//! to do it.
//!
//! Every operation is that of IEEE 754 on each number, nothing is fused, estimated or reordered: so whatever does it
//! ([`Plain`], `avx2.rs`), the bits are the same.

use super::table::{Numbers, Quads};
use super::{Pair, Quad, Row, SLICE};
use std::ops::{Add, Div, Mul, Sub};

/// Pairs that are evaluated together.
pub const LANES: usize = 8;

/// Places of eight particles in a [table](super::table), twice their numbers there, in the lower 16 bits of each.
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
    /// The nearest whole number, the even one of two.
    fn round(self) -> Self;
    /// The first three numbers of the quads at these places, turned.
    fn gather(table: &Quads, places: &Group) -> [Self; 3];
    /// The same at the places of a row's pairs.
    fn gather_row(table: &Quads, row: &Row) -> [Self; 3];
    /// Pairs of whole numbers of 16 bits, and places.
    fn pack(vector: [Self; 3], fourth: &[u32; LANES]) -> [Pair; LANES];

    /// For each particle of a slice, the sum of its pairs' numbers times those of the table; of the fourth number
    /// nothing.
    #[inline(always)]
    fn sum_of_rows(rows: &[Row], table: &Quads) -> [Quad; SLICE] {
        let mut sums = [[0.0; 4]; SLICE];
        for row in rows {
            for (sum, pair) in sums.iter_mut().zip(&row.0) {
                let quad = table.values()[number(pair[3] as u16)];
                for (axis, sum) in sum.iter_mut().enumerate() {
                    *sum += f32::from(pair[axis]) * quad[axis];
                }
            }
        }
        sums
    }

    /// The same with one number of the table for all of a pair.
    #[inline(always)]
    fn sum_of_scaled_rows(rows: &[Row], table: &Numbers) -> [Quad; SLICE] {
        let mut sums = [[0.0; 4]; SLICE];
        for row in rows {
            for (sum, pair) in sums.iter_mut().zip(&row.0) {
                let factor = table.values()[number(pair[3] as u16)];
                for (axis, sum) in sum.iter_mut().enumerate() {
                    *sum += f32::from(pair[axis]) * factor;
                }
            }
        }
        sums
    }

    /// First, second and third numbers of eight quads added up.
    #[inline(always)]
    fn across(quads: [Quad; SLICE]) -> [f32; SLICE] {
        quads.map(|[x, y, z, _]| (x + y) + z)
    }

    /// For each particle of a slice, the sum of h (h . (u_j - u_i)) of its bends h, the vectors u_j of the table and
    /// its own u_i; of the fourth number nothing.
    #[inline(always)]
    fn sum_of_bends(rows: &[Row], bends: &[Row], table: &Quads, own: [Quad; SLICE]) -> [Quad; SLICE] {
        let mut sums = [[0.0; 4]; SLICE];
        for (row, bend) in rows.iter().zip(bends) {
            for lane in 0..SLICE {
                let (of, h) = (table.values()[number(row.0[lane][3] as u16)], bend.0[lane].map(f32::from));
                let p: Quad = std::array::from_fn(|axis| h[axis] * (of[axis] - own[lane][axis]));
                let product = (p[0] + p[1]) + (p[2] + p[3]);
                for axis in 0..4 {
                    sums[lane][axis] += h[axis] * product;
                }
            }
        }
        sums
    }

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
}

/// The places of particles by their numbers in a table.
#[inline(always)]
pub(crate) fn places_of(particles: &[u16; LANES]) -> Group {
    let mut places = [0; LANES];
    for (place, &particle) in places.iter_mut().zip(particles) {
        *place = 2 * u32::from(particle);
    }
    places
}

/// The number of the particle at a place.
#[inline(always)]
fn number(place: u16) -> usize {
    usize::from(place) / 2
}

/// What can be done with any [`Lanes`].
pub(crate) trait Vectorized {
    /// Must be inlined, to be compiled for the processor that has the lanes.
    fn run<V: Lanes>(self);
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
    fn round(self) -> Plain {
        self.zip(self, |a, _| a.round_ties_even())
    }

    #[inline(always)]
    fn gather(table: &Quads, places: &Group) -> [Plain; 3] {
        let mut out = [[0.0; LANES]; 3];
        for (lane, &place) in places.iter().enumerate() {
            for (axis, out) in out.iter_mut().enumerate() {
                out[lane] = table.values()[number(place as u16)][axis];
            }
        }
        out.map(Plain)
    }

    #[inline(always)]
    fn gather_row(table: &Quads, row: &Row) -> [Plain; 3] {
        Plain::gather(table, &row.0.map(|pair| u32::from(pair[3] as u16)))
    }

    #[inline(always)]
    fn pack([x, y, z]: [Plain; 3], fourth: &[u32; LANES]) -> [Pair; LANES] {
        std::array::from_fn(|n| [x.0[n] as i16, y.0[n] as i16, z.0[n] as i16, fourth[n] as u16 as i16])
    }
}
