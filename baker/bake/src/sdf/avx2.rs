//! Eight numbers in one AVX register, and the entry to the search compiled for AVX2 and fused multiply-add.
//!
//! An [`Avx`] exists in functions that [`run`] calls and nowhere else, and `run` makes them only after the test for
//! both: so each instruction below is one that the processor has.
#![allow(unsafe_code)]

use crate::sdf::lanes::{Lanes, Row, Vectorized};
use std::arch::x86_64::*;
use std::ops::{Add, Mul, Sub};

/// One AVX register of f32.
#[derive(Clone, Copy)]
pub(crate) struct Avx(__m256);

/// Does the work with [`Avx`], if this processor has AVX2 and FMA; else gives it back.
#[inline]
pub(crate) fn run<W: Vectorized>(work: W) -> Result<W::Output, W> {
    if !(is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")) {
        return Err(work);
    }
    // SAFETY: this processor has both.
    Ok(unsafe { with_avx2(work) })
}

#[target_feature(enable = "avx2,fma")]
fn with_avx2<W: Vectorized>(work: W) -> W::Output {
    work.run::<Avx>()
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

impl Lanes for Avx {
    #[inline(always)]
    fn splat(number: f32) -> Avx {
        Avx(unsafe { _mm256_set1_ps(number) })
    }

    #[inline(always)]
    fn load(row: &Row) -> Avx {
        Avx(unsafe { _mm256_loadu_ps(row.0.as_ptr()) })
    }

    #[inline(always)]
    fn store(self) -> Row {
        let mut row = Row::default();
        unsafe { _mm256_storeu_ps(row.0.as_mut_ptr(), self.0) };
        row
    }

    #[inline(always)]
    fn mul_add(self, factor: Avx, addend: Avx) -> Avx {
        Avx(unsafe { _mm256_fmadd_ps(self.0, factor.0, addend.0) })
    }

    #[inline(always)]
    fn min(self, other: Avx) -> Avx {
        Avx(unsafe { _mm256_min_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn max(self, other: Avx) -> Avx {
        Avx(unsafe { _mm256_max_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn abs(self) -> Avx {
        Avx(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
    }

    #[inline(always)]
    fn sqrt(self) -> Avx {
        Avx(unsafe { _mm256_sqrt_ps(self.0) })
    }

    #[inline(always)]
    fn within(self, limit: Avx) -> u32 {
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, limit.0)) as u32 }
    }

    #[inline(always)]
    fn where_positive(self, condition: Avx) -> Avx {
        Avx(unsafe { _mm256_and_ps(self.0, _mm256_cmp_ps::<_CMP_GT_OQ>(condition.0, _mm256_setzero_ps())) })
    }
}
