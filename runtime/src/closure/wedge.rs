//! Closure `wedge`: as `calibrated`, and close to exact at convex edges.
//!
//! What a particle sees of a convex edge of 90 degrees, straight in front of it (on its bisector), against a flat wall
//! at the same distance: the second point, beside the flat wall, through which the closure `wedge` leads the exponent.
//!
//! The extension g of Eq. 13 of Bender et al. 2020 reaches r beyond the surface and rounds the edge off, so V falls
//! less there than the density does: with V the exponent must grow from beta, at V = V_plane, to
//! ```text
//! e(d) = ln(R_edge(d) / R(d)) / ln(V_edge(d) / V_plane(d))
//! ```
//! The edge runs along y; the particle is at (c, c), c = d / sqrt 2, from it, the solid where x < 0 and z < 0. All
//! lengths in support radii.

use super::model::{Model, Setup};
use super::plane;
use super::table::{Table, with_slopes};
use super::wall::{LAST_EDGE, Walls};
use crate::kernel::KernelKind;
use crate::quadrature::integrate;
use std::f64::consts::{FRAC_1_SQRT_2, PI};
use std::sync::Arc;

/// Intervals of the table of edges, whose values are needed less exactly.
const INTERVALS: usize = 32;

pub(super) fn new(setup: &Setup) -> Arc<dyn Model> {
    let kernel = setup.kernel.kind();
    let edge = |d: f64| edge(kernel, d);
    let edges = Table::new(0.0, LAST_EDGE, INTERVALS, |d| with_slopes(edge, d, 0.0, LAST_EDGE));
    Arc::new(Walls::new(setup.kernel, |d| plane::density(kernel, d), Some(edges)))
}

/// V_edge / V_plane, and e, for 0 <= d <= [`LAST_EDGE`].
fn edge(kernel: KernelKind, d: f64) -> [f64; 2] {
    let fall = volume(d) / plane::volume(d)[0];
    [fall, (density(kernel, d) / plane::density(kernel, d)[0]).ln() / fall.ln()]
}

/// R_edge: over the directions in the plane across the edge, M of the distance at which the ray enters the solid. Half
/// of it, those below the diagonal, enter through z = 0.
fn density(kernel: KernelKind, d: f64) -> f64 {
    let c = d * FRAC_1_SQRT_2;
    2.0 * in_parts(c.asin(), 0.25 * PI, 4, |angle| beyond_cylinder(kernel, c / angle.sin()))
}

/// M(a): the integral of W outside a cylinder of radius a around the particle, for each radian.
fn beyond_cylinder(kernel: KernelKind, radius: f64) -> f64 {
    let radius = radius.min(1.0);
    let height = |s: f64| (s * s - radius * radius).max(0.0).sqrt();
    let term = |t: f64| 2.0 * t * t * kernel.unit_value((radius * radius + t * t).sqrt());
    let middle = height(0.5);
    in_parts(0.0, middle, 2, term) + in_parts(middle, height(1.0), 2, term)
}

/// V_edge: the chords of the ball along y, 2 s with s^2 = 1 - rho^2, so that rho drho = -s ds.
fn volume(d: f64) -> f64 {
    const DIRECTIONS: usize = 48;
    let c = d * FRAC_1_SQRT_2;
    let mut sum = 0.0;
    for n in 0..DIRECTIONS {
        // Symmetric about the diagonal: half of the circle, which begins on it.
        let angle = 0.25 * PI + PI * (n as f64 + 0.5) / DIRECTIONS as f64;
        let (sin, cos) = angle.sin_cos();
        sum += in_parts(0.0, 1.0, 3, |s| {
            let rho = (1.0 - s * s).sqrt();
            2.0 * s * s * plane::extension(distance(c + rho * cos, c + rho * sin))
        });
    }
    2.0 * PI / DIRECTIONS as f64 * sum
}

/// Where it is negative only its sign is right, which is all that the extension needs.
fn distance(x: f64, z: f64) -> f64 {
    if x.max(z) < 0.0 { x.max(z) } else { x.max(0.0).hypot(z.max(0.0)) }
}

fn in_parts(low: f64, high: f64, parts: usize, f: impl Fn(f64) -> f64) -> f64 {
    let step = (high - low) / parts as f64;
    (0..parts).map(|n| low + step * n as f64).map(|from| integrate(from, from + step, &f)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edge_at_the_surface_is_a_quarter() {
        for kernel in KernelKind::ALL {
            assert!((density(kernel, 0.0) - 0.25).abs() < 1e-6, "{kernel}: {}", density(kernel, 0.0));
        }
    }

    /// Both integrals on a fine lattice of points.
    #[test]
    fn integrals_are_those_of_a_lattice() {
        const STEPS: i32 = 120;
        let h = 2.0 / f64::from(STEPS);
        let at = |n: i32| (f64::from(n) + 0.5) * h - 1.0;
        for d in [0.1, 0.4, 0.8] {
            let c = d * FRAC_1_SQRT_2;
            let (mut density_sum, mut volume_sum) = (0.0, 0.0);
            for (x, z) in (0..STEPS).flat_map(|i| (0..STEPS).map(move |k| (at(i), at(k)))) {
                let phi = distance(c + x, c + z);
                for y in (0..STEPS).map(at) {
                    let radius = (x * x + y * y + z * z).sqrt();
                    if radius < 1.0 {
                        volume_sum += plane::extension(phi);
                        density_sum += (0.5 - phi / h).clamp(0.0, 1.0) * KernelKind::Poly6.unit_value(radius);
                    }
                }
            }
            let cell = h.powi(3);
            assert!((volume_sum * cell - volume(d)).abs() < 2e-3, "{d}: {} {}", volume_sum * cell, volume(d));
            let exact = density(KernelKind::Poly6, d);
            assert!(
                (density_sum * cell - exact).abs() < 1e-3 * exact.max(0.02),
                "{d}: {density_sum} {exact}"
            );
        }
    }
}
