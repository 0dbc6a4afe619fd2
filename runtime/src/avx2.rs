//! Four numbers in one AVX register, and the entry to the batch compiled for AVX2.
//!
//! The only unsafe code of the crate. An [`Avx`] exists in functions that [`run`] calls and nowhere else, and `run`
//! is called only after the test for AVX2: so each instruction below is one that the processor has.
#![allow(unsafe_code)]

use crate::lanes::{LANES, Lanes, Vectorized};
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Sub};

/// One AVX register of f64.
#[derive(Clone, Copy)]
pub(crate) struct Avx(__m256d);

/// Does the work with [`Avx`], if this processor has AVX2; else gives it back.
pub(crate) fn run<W: Vectorized>(work: W) -> Option<W> {
    if !is_x86_feature_detected!("avx2") {
        return Some(work);
    }
    // SAFETY: this processor has AVX2.
    unsafe { with_avx2(work) };
    None
}

#[target_feature(enable = "avx2")]
fn with_avx2<W: Vectorized>(work: W) {
    work.run::<Avx>();
}

impl Add for Avx {
    type Output = Avx;
    #[inline(always)]
    fn add(self, other: Avx) -> Avx {
        // SAFETY: see the top of the file; so in all of them.
        Avx(unsafe { _mm256_add_pd(self.0, other.0) })
    }
}

impl Sub for Avx {
    type Output = Avx;
    #[inline(always)]
    fn sub(self, other: Avx) -> Avx {
        Avx(unsafe { _mm256_sub_pd(self.0, other.0) })
    }
}

impl Mul for Avx {
    type Output = Avx;
    #[inline(always)]
    fn mul(self, other: Avx) -> Avx {
        Avx(unsafe { _mm256_mul_pd(self.0, other.0) })
    }
}

impl Div for Avx {
    type Output = Avx;
    #[inline(always)]
    fn div(self, other: Avx) -> Avx {
        Avx(unsafe { _mm256_div_pd(self.0, other.0) })
    }
}

impl Lanes for Avx {
    #[inline(always)]
    fn new([a, b, c, d]: [f64; LANES]) -> Avx {
        Avx(unsafe { _mm256_setr_pd(a, b, c, d) })
    }

    #[inline(always)]
    fn widen([a, b, c, d]: [f32; LANES]) -> Avx {
        Avx(unsafe { _mm256_cvtps_pd(_mm_setr_ps(a, b, c, d)) })
    }

    #[inline(always)]
    fn splat(number: f64) -> Avx {
        Avx(unsafe { _mm256_set1_pd(number) })
    }

    #[inline(always)]
    fn array(self) -> [f64; LANES] {
        let mut numbers = [0.0; LANES];
        unsafe { _mm256_storeu_pd(numbers.as_mut_ptr(), self.0) };
        numbers
    }

    #[inline(always)]
    fn sqrt(self) -> Avx {
        Avx(unsafe { _mm256_sqrt_pd(self.0) })
    }

    #[inline(always)]
    fn floor(self) -> Avx {
        Avx(unsafe { _mm256_floor_pd(self.0) })
    }

    #[inline(always)]
    fn min(self, limit: Avx) -> Avx {
        Avx(unsafe { _mm256_min_pd(self.0, limit.0) })
    }

    #[inline(always)]
    fn max(self, limit: Avx) -> Avx {
        Avx(unsafe { _mm256_max_pd(self.0, limit.0) })
    }

    #[inline(always)]
    fn zero_unless_below(self, limit: Avx) -> Avx {
        Avx(unsafe { _mm256_and_pd(self.0, _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, limit.0)) })
    }

    #[inline(always)]
    fn within(self, limit: Avx) -> u32 {
        unsafe {
            let above = _mm256_cmp_pd::<_CMP_GE_OQ>(self.0, _mm256_setzero_pd());
            let below = _mm256_cmp_pd::<_CMP_LE_OQ>(self.0, limit.0);
            _mm256_movemask_pd(_mm256_and_pd(above, below)) as u32
        }
    }

    #[inline(always)]
    fn transpose([a, b, c, d]: [Avx; LANES]) -> [Avx; LANES] {
        unsafe {
            let (ab_even, ab_odd) = (_mm256_unpacklo_pd(a.0, b.0), _mm256_unpackhi_pd(a.0, b.0));
            let (cd_even, cd_odd) = (_mm256_unpacklo_pd(c.0, d.0), _mm256_unpackhi_pd(c.0, d.0));
            [
                Avx(_mm256_permute2f128_pd::<0x20>(ab_even, cd_even)),
                Avx(_mm256_permute2f128_pd::<0x20>(ab_odd, cd_odd)),
                Avx(_mm256_permute2f128_pd::<0x31>(ab_even, cd_even)),
                Avx(_mm256_permute2f128_pd::<0x31>(ab_odd, cd_odd)),
            ]
        }
    }
}
