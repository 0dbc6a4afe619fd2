//! The volume that a flat wall has, in closed form: what maps store the difference from.
//!
//! In radii, the solid being the half space beyond a plane at the distance q, V is the integral of
//! pi (1 - z^2) g(q + z) over -1 < z < 1. With (x)+ = max(x, 0), g of Eq. 13 of Bender et al. 2020 is
//! ```text
//! g(t) = 2 (1 - t)+^3 - 8 (1/2 - t)+^3 + 6 (-t)+^2 + 6 (-t)+^3
//! ```
//! and by parts
//! ```text
//! V / pi = 2 F(2 - q) - 8 F(3/2 - q) + H(1 - q) + 2 G(-q) - 8 G(-1/2 - q)      for q >= -1
//! F(t) = t+^5 (1/10 - t/60),   G(t) = t+^5 (1/10 + t/60),   H(t) = t+^4 (1 + 2t/5 - t^2/10)
//! ```
//! 0 from q = 2 on, 4/3 at q = -1 and, by definition, below. Sums, products and a maximum: every processor has the same
//! bits.

use crate::lanes::{Lanes, Plain};

/// The volume within the ball of the solid beyond a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatWall {
    per_radius: f64,
    /// Of the ball over that of the formula.
    scale: f64,
}

impl FlatWall {
    /// For a map's support radius and the volume that its rule gives the full ball
    /// ([`QuadratureSpec::ball_volume`](crate::QuadratureSpec::ball_volume)), which is that deep inside.
    pub fn new(support_radius: f64, ball_volume: f64) -> FlatWall {
        let [full, _] = over_pi(Plain::splat(-1.0)).map(|numbers| numbers.array()[0]);
        FlatWall { per_radius: 1.0 / support_radius, scale: ball_volume / full }
    }

    /// The volume at a signed distance from the plane, m^3.
    pub fn volume(&self, distance: f64) -> f64 {
        self.at(Plain::splat(distance))[0].array()[0]
    }

    /// Its derivative, m^2.
    pub fn slope(&self, distance: f64) -> f64 {
        self.at(Plain::splat(distance))[1].array()[0]
    }

    /// Both, for four distances.
    #[inline(always)]
    pub(crate) fn at<V: Lanes>(&self, distance: V) -> [V; 2] {
        let [value, slope] = over_pi(distance * V::splat(self.per_radius));
        [value * V::splat(self.scale), slope * V::splat(self.scale * self.per_radius)]
    }
}

/// V / pi of the formula and its derivative, in radii.
#[inline(always)]
fn over_pi<V: Lanes>(q: V) -> [V; 2] {
    let c = V::splat;
    let q = q.min(c(2.0)).max(c(-1.0));
    let [f2, df2] = fifth(above(2.0, q), -1.0);
    let [f3, df3] = fifth(above(1.5, q), -1.0);
    let [g2, dg2] = fifth(above(0.0, q), 1.0);
    let [g3, dg3] = fifth(above(-0.5, q), 1.0);
    let t = above(1.0, q);
    let square = t * t;
    let h = (square * square) * (c(1.0) + t * (c(0.4) - c(0.1) * t));
    let dh = (square * t) * (c(4.0) + t * (c(2.0) - c(0.6) * t));
    let value = (c(2.0) * f2 - c(8.0) * f3) + h + (c(2.0) * g2 - c(8.0) * g3);
    let slope = (c(2.0) * df2 - c(8.0) * df3) + dh + (c(2.0) * dg2 - c(8.0) * dg3);
    [value, c(0.0) - slope]
}

/// (from - q)+
#[inline(always)]
fn above<V: Lanes>(from: f64, q: V) -> V {
    (V::splat(from) - q).max(V::splat(0.0))
}

/// t^5 (1/10 + s t/60) and its derivative.
#[inline(always)]
fn fifth<V: Lanes>(t: V, s: f64) -> [V; 2] {
    let c = V::splat;
    let square = t * t;
    let fourth = square * square;
    [fourth * (t * (c(0.1) + c(s / 60.0) * t)), fourth * (c(0.5) + c(s / 10.0) * t)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn volume_of_a_flat_wall_is_nothing_far_away_and_the_ball_deep_inside() {
        let wall = FlatWall::new(0.1, 0.0042);
        for distance in [0.2, 0.3, f64::INFINITY] {
            assert_eq!((wall.volume(distance), wall.slope(distance)), (0.0, 0.0));
        }
        for distance in [-0.1, -0.15, f64::NEG_INFINITY] {
            assert!((wall.volume(distance) - 0.0042).abs() < 1e-17);
            assert!(wall.slope(distance).abs() < 1e-15);
        }
    }
}
