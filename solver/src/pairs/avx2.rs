//! Eight numbers in one AVX register, and the entry to the sums over neighbours compiled for AVX2.
//!
//! An [`Avx`] exists in functions that [`run`] calls and nowhere else, and `run` makes them only after the test for
//! AVX2: so each instruction below is one that the processor has. Loads from tables are checked first.
#![allow(unsafe_code)]

use super::lanes::{Group, LANES, Lanes, Quad, Work};
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Sub};

/// One AVX register of f32.
#[derive(Clone, Copy)]
pub(crate) struct Avx(__m256);

/// Does the work with [`Avx`], if this processor has AVX2; else gives it back.
#[inline]
pub(crate) fn run<W: Work>(work: W) -> Option<W> {
    if !is_x86_feature_detected!("avx2") {
        return Some(work);
    }
    // SAFETY: this processor has it.
    unsafe { with_avx2(work) };
    None
}

#[target_feature(enable = "avx2")]
fn with_avx2<W: Work>(work: W) {
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
    fn gather<const N: usize>(tables: [&[Quad]; N], group: &Group) -> [[Avx; 4]; N] {
        let count = tables[0].len();
        assert!(count > 0 && tables.iter().all(|table| table.len() == count));
        // SAFETY: each quad begins at 4 times an index below the tables' length, or the assertion fails.
        unsafe {
            let last = _mm256_set1_epi32((4 * (count as u32 - 1)) as i32);
            let all = _mm256_loadu_si256(group.as_ptr().cast());
            let below = _mm256_cmpeq_epi32(_mm256_max_epu32(all, last), last);
            assert!(_mm256_movemask_epi8(below) == -1);
            // Volatile: the compiler would take the indices out of the vector, which is slower.
            let [a, b, c, d, e, f, g, h]: [usize; LANES] =
                std::array::from_fn(|lane| group.as_ptr().add(lane).read_volatile() as usize);
            let mut out = [[Avx(_mm256_setzero_ps()); 4]; N];
            for (out, table) in out.iter_mut().zip(tables) {
                let numbers = table.as_ptr().cast::<f32>();
                let two = |low: usize, high: usize| {
                    let low = _mm256_castps128_ps256(_mm_loadu_ps(numbers.add(low)));
                    _mm256_insertf128_ps::<1>(low, _mm_loadu_ps(numbers.add(high)))
                };
                *out = transpose(two(a, e), two(b, f), two(c, g), two(d, h));
            }
            out
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

    #[inline(always)]
    fn sum(self) -> f32 {
        // The order of the default: halves, then quarters, then both.
        unsafe {
            let four = _mm_add_ps(_mm256_castps256_ps128(self.0), _mm256_extractf128_ps::<1>(self.0));
            let two = _mm_add_ps(four, _mm_movehl_ps(four, four));
            _mm_cvtss_f32(_mm_add_ss(two, _mm_shuffle_ps::<0x55>(two, two)))
        }
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
