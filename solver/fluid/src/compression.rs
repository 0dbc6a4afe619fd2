//! How much denser than at rest a fluid is: what the solves left of it, and what they can't help.

use crate::particles::CHUNK;
use rayon::prelude::*;
use volmap_runtime::DVec3;

/// A fluid that is denser than at rest by more than this part, for more than a moment, has no room, or began too dense.
pub const COMPRESSED: f64 = 0.05;

/// The density's excess over that at rest, in parts of the latter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Compression {
    /// Mean over all particles; those at a surface, which are less dense, count as 0.
    pub mean: f64,
    /// Of the densest particle.
    pub largest: f64,
    /// Where that one is, metres.
    pub place: DVec3,
}

impl Compression {
    /// Of particles with these relative densities D = rho / rho_0, at these places (metres).
    pub fn of(densities: &[f32], positions: &[DVec3]) -> Compression {
        let chunk = |chunk: &[f32]| {
            let mut out = (0.0, 0.0, 0);
            for (i, density) in chunk.iter().enumerate() {
                let excess = f64::from((density - 1.0).max(0.0));
                out.0 += excess;
                if excess > out.1 {
                    (out.1, out.2) = (excess, i);
                }
            }
            out
        };
        let chunks: Vec<(f64, f64, usize)> = densities.par_chunks(CHUNK).map(chunk).collect();
        let mut out = Compression::default();
        // In the order of the chunks: the same bits on any number of threads.
        for (n, (sum, largest, i)) in chunks.into_iter().enumerate() {
            out.mean += sum / densities.len() as f64;
            if largest > out.largest {
                (out.largest, out.place) = (largest, positions[n * CHUNK + i]);
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_denser_than_at_rest_counts() {
        let mut densities = vec![1.0; 10_000];
        let positions: Vec<DVec3> = (0..10_000).map(|n| DVec3::X * f64::from(n)).collect();
        assert_eq!(Compression::of(&densities, &positions), Compression::default());
        (densities[77], densities[9_000], densities[5]) = (1.25, 1.5, 0.5);
        let found = Compression::of(&densities, &positions);
        assert_eq!((found.largest, found.place.x), (0.5, 9_000.0));
        assert!((found.mean - 0.75e-4).abs() < 1e-12, "{}", found.mean);
        assert_eq!(Compression::of(&[], &[]), Compression::default());
    }
}
