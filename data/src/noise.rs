//! Gradient noise in the plane, and its sum over octaves.
//!
//! Perlin, *Improving Noise*, SIGGRAPH 2002: the quintic fade and a fixed set of gradients, but an integer
//! hash in place of its permutation table. Fractal sum: Musgrave, Kolb and Mace, *The Synthesis and Rendering
//! of Eroded Fractal Terrains*, SIGGRAPH 1989.

use glam::DVec2;

/// Smooth noise of about -1 to 1, 0 at integer points; `layer` chooses between independent patterns.
pub fn noise(p: DVec2, layer: u32) -> f64 {
    let corner = p.floor();
    let t = p - corner;
    let (i, k) = (corner.x as i32, corner.y as i32);
    let fade = |s: f64| s * s * s * (s * (s * 6.0 - 15.0) + 10.0);
    let mix = |a: f64, b: f64, s: f64| a + (b - a) * s;
    let at = |di: i32, dk: i32| {
        slope(hash(i + di, k + dk, layer)).dot(t - DVec2::new(f64::from(di), f64::from(dk)))
    };
    let near = mix(at(0, 0), at(1, 0), fade(t.x));
    let far = mix(at(0, 1), at(1, 1), fade(t.x));
    1.5 * mix(near, far, fade(t.y))
}

/// Noise summed over octaves: each has twice the frequency and half the height of the one before.
pub fn fractal(p: DVec2, layer: u32, octaves: u32) -> f64 {
    let (mut sum, mut scale) = (0.0, 1.0);
    for octave in 0..octaves {
        sum += noise(p / scale, layer + octave) * scale;
        scale *= 0.5;
    }
    sum
}

/// One of 8 directions.
fn slope(hash: u32) -> DVec2 {
    const D: f64 = std::f64::consts::FRAC_1_SQRT_2;
    [(1.0, 0.0), (D, D), (0.0, 1.0), (-D, D), (-1.0, 0.0), (-D, -D), (0.0, -1.0), (D, -D)].map(DVec2::from)
        [(hash >> 29) as usize]
}

/// Mixes the bits of a lattice point (finalizer of MurmurHash3, Appleby 2011).
fn hash(i: i32, k: i32, layer: u32) -> u32 {
    let mut h = (i as u32).wrapping_mul(0x9e37_79b1) ^ (k as u32).wrapping_mul(0x85eb_ca77);
    h ^= layer.wrapping_mul(0xc2b2_ae3d);
    h = (h ^ h >> 16).wrapping_mul(0x85eb_ca6b);
    h = (h ^ h >> 13).wrapping_mul(0xc2b2_ae35);
    h ^ h >> 16
}
