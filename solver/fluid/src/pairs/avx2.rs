//! Eight numbers in one AVX register, and the entry to the sums over neighbours compiled for AVX2.
//!
//! An [`Avx`] exists in functions that [`run`] calls and nowhere else, and `run` makes them only after the test for
//! AVX2 and POPCNT: so each instruction below is one that the processor has. Loads from a table are at places of 16
//! bits, which are all in it.
#![allow(unsafe_code)]

use super::lanes::{Group, LANES, Lanes, Vectorized};
use super::table::{Numbers, Quads, ROOM};
use super::{Pair, Quad, Row, SLICE};
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Sub};

/// One AVX register of f32.
#[derive(Clone, Copy)]
pub(crate) struct Avx(__m256);

/// Does the work with [`Avx`], if this processor has AVX2 and POPCNT; else gives it back.
#[inline]
pub(crate) fn run<W: Vectorized>(work: W) -> Option<W> {
    if !(is_x86_feature_detected!("avx2") && is_x86_feature_detected!("popcnt")) {
        return Some(work);
    }
    // SAFETY: this processor has both.
    unsafe { with_avx2(work) };
    None
}

#[target_feature(enable = "avx2,popcnt")]
fn with_avx2<W: Vectorized>(work: W) {
    work.run::<Avx>();
}

impl Add for Avx {
    type Output = Avx;
    #[inline(always)]
    fn add(self, other: Avx) -> Avx {
        // SAFETY: see the top of the file; so in all of them.
        Avx(unsafe { _mm256_add_ps(self.0, other.0) })
    }
}

impl Sub for Avx {
    type Output = Avx;
    #[inline(always)]
    fn sub(self, other: Avx) -> Avx {
        Avx(unsafe { _mm256_sub_ps(self.0, other.0) })
    }
}

impl Mul for Avx {
    type Output = Avx;
    #[inline(always)]
    fn mul(self, other: Avx) -> Avx {
        Avx(unsafe { _mm256_mul_ps(self.0, other.0) })
    }
}

impl Div for Avx {
    type Output = Avx;
    #[inline(always)]
    fn div(self, other: Avx) -> Avx {
        Avx(unsafe { _mm256_div_ps(self.0, other.0) })
    }
}

impl Lanes for Avx {
    #[inline(always)]
    fn splat(number: f32) -> Avx {
        Avx(unsafe { _mm256_set1_ps(number) })
    }

    #[inline(always)]
    fn load(numbers: &[f32; LANES]) -> Avx {
        Avx(unsafe { _mm256_loadu_ps(numbers.as_ptr()) })
    }

    #[inline(always)]
    fn array(self) -> [f32; LANES] {
        let mut out = [0.0; LANES];
        unsafe { _mm256_storeu_ps(out.as_mut_ptr(), self.0) };
        out
    }

    #[inline(always)]
    fn sqrt(self) -> Avx {
        Avx(unsafe { _mm256_sqrt_ps(self.0) })
    }

    #[inline(always)]
    fn max(self, other: Avx) -> Avx {
        Avx(unsafe { _mm256_max_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn below(self, other: Avx) -> u32 {
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0)) as u32 }
    }

    #[inline(always)]
    fn round(self) -> Avx {
        Avx(unsafe { _mm256_round_ps::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(self.0) })
    }

    #[inline(always)]
    fn gather(table: &Quads, places: &Group) -> [Avx; 3] {
        columns(table, places.each_ref())
    }

    #[inline(always)]
    fn gather_row(table: &Quads, row: &Row) -> [Avx; 3] {
        let [a, b, c, d, e, f, g, h] = &row.0;
        columns(table, [&a[3], &b[3], &c[3], &d[3], &e[3], &f[3], &g[3], &h[3]])
    }

    #[inline(always)]
    fn pack([x, y, z]: [Avx; 3], fourth: &[u32; LANES]) -> [Pair; LANES] {
        let mut out = [[0; 4]; LANES];
        // SAFETY: both arrays are as long as what is read and written.
        unsafe {
            let low = |n: __m256i| _mm256_and_si256(n, _mm256_set1_epi32(0xffff));
            let fourth = _mm256_loadu_si256(fourth.as_ptr().cast());
            let [x, y, z] = [x, y, z].map(|n| _mm256_cvtps_epi32(n.0));
            let first = _mm256_or_si256(low(x), _mm256_slli_epi32::<16>(y));
            let second = _mm256_or_si256(low(z), _mm256_slli_epi32::<16>(fourth));
            let (even, odd) = (_mm256_unpacklo_epi32(first, second), _mm256_unpackhi_epi32(first, second));
            let to = out.as_mut_ptr().cast::<__m256i>();
            _mm256_storeu_si256(to, _mm256_permute2x128_si256::<0x20>(even, odd));
            _mm256_storeu_si256(to.add(1), _mm256_permute2x128_si256::<0x31>(even, odd));
        }
        out
    }

    #[inline(always)]
    fn sum_of_rows(rows: &[Row], table: &Quads) -> [Quad; SLICE] {
        sum_of(rows, table)
    }

    #[inline(always)]
    fn sum_of_scaled_rows(rows: &[Row], table: &Numbers) -> [Quad; SLICE] {
        sum_of(rows, table)
    }

    #[inline(always)]
    fn across(quads: [Quad; SLICE]) -> [f32; SLICE] {
        // SAFETY: eight quads are 32 numbers.
        unsafe {
            let from = quads.as_ptr().cast::<f32>();
            let (a, b) = (_mm256_loadu_ps(from), _mm256_loadu_ps(from.add(8)));
            let (c, d) = (_mm256_loadu_ps(from.add(16)), _mm256_loadu_ps(from.add(24)));
            // Lower halves are of quads 0, 2, 4 and 6, upper ones of 1, 3, 5 and 7.
            let [x, y, z, _] = transpose(a, b, c, d);
            let sums = ((x + y) + z).0;
            let (even, odd) = (_mm256_castps256_ps128(sums), _mm256_extractf128_ps::<1>(sums));
            let mut out = [0.0; SLICE];
            _mm_storeu_ps(out.as_mut_ptr(), _mm_unpacklo_ps(even, odd));
            _mm_storeu_ps(out.as_mut_ptr().add(4), _mm_unpackhi_ps(even, odd));
            out
        }
    }

    #[inline(always)]
    fn sum_of_bends(rows: &[Row], bends: &[Row], table: &Quads, own: [Quad; SLICE]) -> [Quad; SLICE] {
        // SAFETY: see the top of the file.
        unsafe {
            let (mut sums, mut of_own) = ([_mm256_setzero_ps(); SLICE / 2], [_mm256_setzero_ps(); SLICE / 2]);
            for (to, own) in of_own.iter_mut().zip(own.as_chunks::<2>().0) {
                *to = _mm256_loadu_ps(own.as_ptr().cast());
            }
            for (row, bend) in rows.iter().zip(bends) {
                for n in 0..SLICE / 2 {
                    let of = two(table, place(&row.0[2 * n][3]), place(&row.0[2 * n + 1][3]));
                    let h = numbers(bend, n);
                    let products = _mm256_mul_ps(h, _mm256_sub_ps(of, of_own[n]));
                    let pairs = _mm256_add_ps(products, _mm256_permute_ps::<0b10_11_00_01>(products));
                    let product = _mm256_add_ps(pairs, _mm256_permute_ps::<0b01_00_11_10>(pairs));
                    sums[n] = _mm256_add_ps(sums[n], _mm256_mul_ps(h, product));
                }
            }
            quads(sums)
        }
    }

    #[inline(always)]
    fn compress(numbers: &[u32; LANES], bits: u32) -> [u32; LANES] {
        let (mut out, order) = ([0; LANES], &FRONT[(bits & 255) as usize]);
        // SAFETY: all three have eight numbers.
        unsafe {
            let order = _mm256_loadu_si256(order.as_ptr().cast());
            let numbers = _mm256_loadu_si256(numbers.as_ptr().cast());
            _mm256_storeu_si256(out.as_mut_ptr().cast(), _mm256_permutevar8x32_epi32(numbers, order));
        }
        out
    }
}

/// For each set of bits, the places of those that are set.
static FRONT: [[u32; LANES]; 256] = {
    let mut table = [[0; LANES]; 256];
    let mut bits = 0;
    while bits < 256 {
        let (mut lane, mut count) = (0, 0);
        while lane < LANES {
            if bits >> lane & 1 == 1 {
                table[bits][count] = lane as u32;
                count += 1;
            }
            lane += 1;
        }
        bits += 1;
    }
    table
};

/// Integers of 16 bits and more.
trait Wide {}
impl Wide for i16 {}
impl Wide for u32 {}

/// The lower 16 bits. Volatile: the compiler would take them out of the vector of all numbers there, which is slower
/// than to load them once more.
#[inline(always)]
fn place<T: Wide>(number: &T) -> u16 {
    const { assert!(size_of::<T>() >= size_of::<u16>() && align_of::<T>() >= align_of::<u16>()) };
    // SAFETY: a reference to an integer as wide or wider, which is little-endian on this processor.
    unsafe { (&raw const *number).cast::<u16>().read_volatile() }
}

/// What a table has for two pairs.
trait Values {
    fn two(&self, low: u16, high: u16) -> __m256;
}

impl Values for Quads {
    #[inline(always)]
    fn two(&self, low: u16, high: u16) -> __m256 {
        two(self, low, high)
    }
}

impl Values for Numbers {
    #[inline(always)]
    fn two(&self, low: u16, high: u16) -> __m256 {
        two_numbers(self, low, high)
    }
}

/// For each particle of a slice, the sum of its pairs' numbers times those of the table.
#[inline(always)]
fn sum_of(rows: &[Row], table: &impl Values) -> [Quad; SLICE] {
    // SAFETY: see the top of the file.
    unsafe {
        let mut sums = [_mm256_setzero_ps(); SLICE / 2];
        for row in rows {
            for (n, sum) in sums.iter_mut().enumerate() {
                let of = table.two(place(&row.0[2 * n][3]), place(&row.0[2 * n + 1][3]));
                *sum = _mm256_add_ps(*sum, _mm256_mul_ps(numbers(row, n), of));
            }
        }
        quads(sums)
    }
}

/// First, second and third numbers of the quads at eight places.
#[inline(always)]
fn columns<T: Wide>(table: &Quads, [a, b, c, d, e, f, g, h]: [&T; LANES]) -> [Avx; 3] {
    let two = |low: &T, high: &T| two(table, place(low), place(high));
    let [x, y, z, _] = transpose(two(a, e), two(b, f), two(c, g), two(d, h));
    [x, y, z]
}

/// The quads at two places.
#[inline(always)]
fn two(table: &Quads, low: u16, high: u16) -> __m256 {
    const { assert!(4 * (u16::MAX as usize + 2) <= 8 * ROOM) };
    let numbers = table.values().as_ptr().cast::<f32>();
    // SAFETY: a quad that begins at half the place is in the table, see above, and at half a quad more, too.
    unsafe {
        let quad = |place: u16| _mm_loadu_ps(numbers.add(2 * usize::from(place)));
        _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(quad(low)), quad(high))
    }
}

/// The numbers at two places, four times each.
#[inline(always)]
fn two_numbers(table: &Numbers, low: u16, high: u16) -> __m256 {
    const { assert!(2 * (u16::MAX as usize + 2) <= 4 * ROOM) };
    let bytes = table.values().as_ptr().cast::<u8>();
    // SAFETY: a number that begins at twice the place, in bytes, is in the table, see above, and two bytes behind it,
    // too.
    unsafe {
        let [low, high] = [bytes.add(2 * usize::from(low)), bytes.add(2 * usize::from(high))];
        let [low, high] = [low.cast::<f32>().read_unaligned(), high.cast::<f32>().read_unaligned()];
        _mm256_blend_ps::<0xf0>(_mm256_set1_ps(low), _mm256_set1_ps(high))
    }
}

/// The numbers of a row's pairs `2 n` and `2 n + 1`.
#[inline(always)]
fn numbers(row: &Row, n: usize) -> __m256 {
    // SAFETY: two pairs are 16 bytes.
    unsafe {
        let pairs = _mm_loadu_si128((&raw const row.0[2 * n..2 * n + 2]).cast());
        _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(pairs))
    }
}

/// Two quads a register.
#[inline(always)]
fn quads(sums: [__m256; SLICE / 2]) -> [Quad; SLICE] {
    let mut out = [[0.0; 4]; SLICE];
    for (out, sum) in out.as_chunks_mut::<2>().0.iter_mut().zip(sums) {
        // SAFETY: two quads are eight numbers.
        unsafe { _mm256_storeu_ps(out.as_mut_ptr().cast(), sum) };
    }
    out
}

/// Rows of two quads each for columns.
#[inline(always)]
fn transpose(a: __m256, b: __m256, c: __m256, d: __m256) -> [Avx; 4] {
    // SAFETY: see the top of the file.
    unsafe {
        let (low, low2) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
        let (high, high2) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
        [
            Avx(_mm256_shuffle_ps::<0x44>(low, low2)),
            Avx(_mm256_shuffle_ps::<0xEE>(low, low2)),
            Avx(_mm256_shuffle_ps::<0x44>(high, high2)),
            Avx(_mm256_shuffle_ps::<0xEE>(high, high2)),
        ]
    }
}
