//! The kernel compiled for vectors with fused multiply-add, chosen at run time.
//!
//! Calling a function that was compiled for a processor feature is unsafe. Each call stands behind the test for that
//! feature. Without it (x86-64 before 2013) the multiply-adds are library calls: slow,
//! and with the same bits. Other processors have them in their baseline, as aarch64 does.
#![allow(unsafe_code)]

use super::kernel::{self, Group, Lanes, Window, linear};
use super::pixel_line::{self, LineOnRows};

/// The kernel for a processor, for windows of up to `S` cells.
#[derive(Clone, Copy, Debug)]
pub struct Kernel<const S: usize> {
    /// [`kernel::accumulate`].
    pub accumulate: fn(&[Group], &Window<S>, i32, &mut [f64]),
    /// [`kernel::to_monomials`].
    pub to_monomials: fn(&mut Window<S>),
    /// [`kernel::classify`].
    pub classify: fn(&mut Window<S>),
}

/// The kernel for the baseline: the scalar twin.
pub fn portable<const S: usize>() -> Kernel<S> {
    Kernel { accumulate: kernel::accumulate, to_monomials: kernel::to_monomials, classify: kernel::classify }
}

/// The fastest kernel that this processor can run.
pub fn kernel<const S: usize>() -> Kernel<S> {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        // SAFETY: this processor has AVX2 and FMA.
        return Kernel {
            accumulate: |groups, window, first, sums| unsafe { accumulate(groups, window, first, sums) },
            to_monomials: |window| unsafe { to_monomials(window) },
            classify: |window| unsafe { classify(window) },
        };
    }
    portable()
}

/// The same for the linear extension function of density maps.
pub fn linear_kernel<const S: usize>() -> Kernel<S> {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        // SAFETY: this processor has AVX2 and FMA.
        let accumulate: fn(&[Group], &Window<S>, i32, &mut [f64]) =
            |groups, window, first, sums| unsafe { accumulate_linear(groups, window, first, sums) };
        return Kernel { accumulate, ..kernel() };
    }
    Kernel { accumulate: linear::accumulate, ..portable() }
}

/// [`pixel_line::accumulate`] for this processor.
pub fn pixel_rows_kernel() -> fn(&LineOnRows, &mut [[Lanes; 2]]) {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        // SAFETY: this processor has AVX2 and FMA.
        return |line, sums| unsafe { accumulate_on_rows(line, sums) };
    }
    pixel_line::accumulate
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn accumulate_on_rows(line: &LineOnRows, sums: &mut [[Lanes; 2]]) {
    pixel_line::accumulate(line, sums)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn accumulate_linear<const S: usize>(groups: &[Group], window: &Window<S>, first: i32, sums: &mut [f64]) {
    linear::accumulate(groups, window, first, sums)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn accumulate<const S: usize>(groups: &[Group], window: &Window<S>, first: i32, sums: &mut [f64]) {
    kernel::accumulate(groups, window, first, sums)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn to_monomials<const S: usize>(window: &mut Window<S>) {
    kernel::to_monomials(window)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn classify<const S: usize>(window: &mut Window<S>) {
    kernel::classify(window)
}
