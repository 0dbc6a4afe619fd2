//! Random numbers from a seed, the same everywhere: the one generator of the workspace.

use glam::DVec3;

/// A generator. Whoever needs numbers that are safe from guessing needs another.
#[derive(Clone, Debug)]
pub struct Random {
    state: u64,
    kind: Kind,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// xorshift64* (Marsaglia 2003, Vigna 2016).
    Xorshift,
    /// The linear congruential generator of Knuth's MMIX.
    Knuth,
}

impl Random {
    /// xorshift64* from any seed.
    pub fn new(seed: u64) -> Random {
        // Zero would stay zero.
        Random::from_state(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// xorshift64* from a state, which must not be 0.
    pub fn from_state(state: u64) -> Random {
        Random { state, kind: Kind::Xorshift }
    }

    /// Knuth's MMIX from any seed: for what was once made with it and must stay the same.
    pub fn knuth(seed: u64) -> Random {
        Random { state: seed, kind: Kind::Knuth }
    }

    /// The next 64 bits, of which the upper ones are the better.
    pub fn bits(&mut self) -> u64 {
        match self.kind {
            Kind::Xorshift => {
                self.state ^= self.state >> 12;
                self.state ^= self.state << 25;
                self.state ^= self.state >> 27;
                self.state.wrapping_mul(0x2545_F491_4F6C_DD1D)
            }
            Kind::Knuth => {
                self.state = self
                    .state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                self.state
            }
        }
    }

    /// A number in [0, 1), of 53 bits.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A number in [-1, 1), of 31 bits.
    pub fn signed(&mut self) -> f64 {
        (self.bits() >> 33) as f64 / (1u64 << 30) as f64 - 1.0
    }

    /// A number in 0 .. n, where n is far below 2^53.
    pub fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }

    /// A point in a box.
    pub fn point(&mut self, low: DVec3, high: DVec3) -> DVec3 {
        low + (high - low) * DVec3::new(self.unit(), self.unit(), self.unit())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Assets and tables of measurements depend on these numbers.
    #[test]
    fn numbers_stay_the_same() {
        let first = |mut random: Random| (0..3).map(|_| random.bits()).collect::<Vec<_>>();
        assert_eq!(first(Random::from_state(1))[0], 0x47E4_CE4B_896C_DD1D);
        assert_eq!(first(Random::knuth(1))[0], 6_364_136_223_846_793_005 + 1_442_695_040_888_963_407);
        assert_eq!(
            first(Random::new(7)),
            first(Random::from_state(7u64.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1))
        );
    }

    #[test]
    fn numbers_fill_their_ranges_evenly() {
        for mut random in [Random::new(0), Random::new(1), Random::knuth(0)] {
            let units: Vec<f64> = (0..10_000).map(|_| random.unit()).collect();
            assert!(units.iter().all(|x| (0.0..1.0).contains(x)));
            assert!((units.iter().sum::<f64>() / 1e4 - 0.5).abs() < 0.01);
            let signed: Vec<f64> = (0..10_000).map(|_| random.signed()).collect();
            assert!(signed.iter().all(|x| (-1.0..1.0).contains(x)));
            assert!((signed.iter().sum::<f64>() / 1e4).abs() < 0.02);
            let mut counts = [0; 5];
            (0..10_000).for_each(|_| counts[random.below(5)] += 1);
            assert!(counts.iter().all(|count| (1_850..2_150).contains(count)), "{counts:?}");
        }
    }
}
