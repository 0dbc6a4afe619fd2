//! The kernel compiled for wider vectors than the baseline's, chosen at run time.
//!
//! The only unsafe code of the crate: calling a function that was compiled for a processor feature. Each call stands
//! behind the test for that feature.
#![allow(unsafe_code)]

use super::kernel::{self, Block};
use volmap_runtime::serendipity::NODES;

/// The signature of [`kernel::integral`].
pub type Integral = fn(&[Block], &[f64; NODES], f64) -> f64;

/// The kernel for the widest vectors that this processor has.
pub fn integral() -> Integral {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") {
            return |blocks, nodes, inverse_radius| {
                // SAFETY: this processor has AVX-512F.
                unsafe { integral_avx512(blocks, nodes, inverse_radius) }
            };
        }
        if is_x86_feature_detected!("avx2") {
            return |blocks, nodes, inverse_radius| {
                // SAFETY: this processor has AVX2.
                unsafe { integral_avx2(blocks, nodes, inverse_radius) }
            };
        }
    }
    kernel::integral
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn integral_avx512(blocks: &[Block], nodes: &[f64; NODES], inverse_radius: f64) -> f64 {
    kernel::integral(blocks, nodes, inverse_radius)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn integral_avx2(blocks: &[Block], nodes: &[f64; NODES], inverse_radius: f64) -> f64 {
    kernel::integral(blocks, nodes, inverse_radius)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume_map::kernel::LANES;

    #[test]
    fn wide_kernel_has_the_bits_of_the_scalar_one() {
        let value = |i: usize| ((i * 2654435761) % 1000) as f64 / 700.0 - 0.3;
        let block = |b: usize| Block {
            shape: std::array::from_fn(|a| std::array::from_fn(|lane| value(b * 999 + a * LANES + lane))),
            weights: std::array::from_fn(|lane| value(b + 31 * lane)),
        };
        for count in 0..5 {
            let blocks: Vec<Block> = (0..count).map(block).collect();
            let nodes = std::array::from_fn(|a| 0.1 * value(7 * a + count));
            let wide = integral()(&blocks, &nodes, 1.7);
            assert_eq!(wide.to_bits(), kernel::integral(&blocks, &nodes, 1.7).to_bits());
        }
    }
}
