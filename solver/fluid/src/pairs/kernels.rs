//! The kernels at eight distances, in units of the support radius: q = |x| / r.
//!
//! W(x) = [`KernelLanes::NORM`] / r^3 `value`; grad W(x) = SLOPE_NORM SLOPE / r^4 `slope` x / r. Monaghan 2005 (cubic
//! spline), Wendland 1995, Desbrun and Gascuel 1996 (spiky), Müller et al. 2003 (poly6, with the gradient of spiky).

use super::lanes::Lanes;
use std::f32::consts::PI;

/// Distances below this count as this one, so that slopes stay finite.
const SMALLEST_SQUARE: f32 = 1e-12;

/// What is added to the square of a distance in support radii, 0.01 h^2 of Eq. 16 of Bender et al. 2020.
pub(crate) const SMALL: f32 = 0.01;

/// A kernel of support radius 1. Both are 0 where q >= 1.
pub(crate) trait KernelLanes {
    /// 1 / the integral of `value`.
    const NORM: f32;
    /// w(q), from q^2.
    fn value<V: Lanes>(square: V) -> V;
    /// The norm of the kernel that `slope` is of.
    const SLOPE_NORM: f32 = Self::NORM;
    /// What `slope` must be multiplied by.
    const SLOPE: f32;
    /// No |slope| q is greater.
    const STEEPEST: f32;
    /// Nor is the root of |slope| q^2 / (q^2 + [`SMALL`]).
    const BENDIEST: f32;
    /// w'(q) / q / SLOPE, from q^2.
    fn slope<V: Lanes>(square: V) -> V;
    /// Both.
    #[inline(always)]
    fn both<V: Lanes>(square: V) -> (V, V) {
        (Self::value(square), Self::slope(square))
    }
}

pub(crate) struct CubicSpline;
pub(crate) struct WendlandC2;
pub(crate) struct Spiky;
pub(crate) struct Poly6;

#[inline(always)]
fn length<V: Lanes>(square: V) -> V {
    square.max(V::splat(SMALLEST_SQUARE)).sqrt()
}

/// max(limit - x, 0).
#[inline(always)]
fn short_of<V: Lanes>(limit: f32, x: V) -> V {
    (V::splat(limit) - x).max(V::splat(0.0))
}

// The spline is 2 (1 - q)^3 - (1 - 2 q)^3, each cube where it is positive; its slope -6 ((1 - q)^2 - (1 - 2 q)^2).
impl KernelLanes for CubicSpline {
    const NORM: f32 = 8.0 / PI;
    const SLOPE: f32 = 6.0;
    const STEEPEST: f32 = 0.33334;
    const BENDIEST: f32 = 1.059;

    #[inline(always)]
    fn value<V: Lanes>(square: V) -> V {
        Self::both(square).0
    }

    #[inline(always)]
    fn slope<V: Lanes>(square: V) -> V {
        let q = length(square);
        let [a, b] = [short_of(1.0, q), short_of(1.0, q + q)];
        (b * b - a * a) / q
    }

    #[inline(always)]
    fn both<V: Lanes>(square: V) -> (V, V) {
        let q = length(square);
        let [a, b] = [short_of(1.0, q), short_of(1.0, q + q)];
        let (a2, b2) = (a * a, b * b);
        ((a2 * (a + a)) - b2 * b, (b2 - a2) / q)
    }
}

impl KernelLanes for WendlandC2 {
    const NORM: f32 = 10.5 / PI;
    const SLOPE: f32 = -20.0;
    const STEEPEST: f32 = 0.10548;
    const BENDIEST: f32 = 0.654;

    #[inline(always)]
    fn value<V: Lanes>(square: V) -> V {
        let q = length(square);
        let a = short_of(1.0, q);
        (a * a) * (a * a) * (V::splat(4.0) * q + V::splat(1.0))
    }

    #[inline(always)]
    fn slope<V: Lanes>(square: V) -> V {
        let a = short_of(1.0, length(square));
        a * a * a
    }
}

impl KernelLanes for Spiky {
    const NORM: f32 = 15.0 / PI;
    const SLOPE: f32 = -3.0;
    const STEEPEST: f32 = 1.0;
    const BENDIEST: f32 = 2.04;

    #[inline(always)]
    fn value<V: Lanes>(square: V) -> V {
        let a = short_of(1.0, length(square));
        a * a * a
    }

    #[inline(always)]
    fn slope<V: Lanes>(square: V) -> V {
        let q = length(square);
        let a = short_of(1.0, q);
        a * a / q
    }
}

// Its own slope vanishes around the centre, and particles would end up in pairs.
impl KernelLanes for Poly6 {
    const NORM: f32 = 315.0 / 64.0 / PI;
    const SLOPE_NORM: f32 = Spiky::NORM;
    const SLOPE: f32 = Spiky::SLOPE;
    const STEEPEST: f32 = Spiky::STEEPEST;
    const BENDIEST: f32 = Spiky::BENDIEST;

    #[inline(always)]
    fn value<V: Lanes>(square: V) -> V {
        let a = short_of(1.0, square);
        a * a * a
    }

    #[inline(always)]
    fn slope<V: Lanes>(square: V) -> V {
        Spiky::slope(square)
    }
}
