//! What a particle sees of a flat wall, and how both change with curvature to first order: one-dimensional
//! integrals, exact up to rounding. All lengths in support radii.
//!
//! The solid is the half space beyond a plane at distance d. Of the sphere of radius s around the particle the part
//! 2 pi s (s - d) lies in it, so
//! ```text
//! R(d)  = 2 pi integral from d to 1 of W(s) s (s - d) ds,   R(-d) = 1 - R(d)
//! R'(d) = -2 pi integral from |d| to 1 of W(s) s ds
//! V(d)  = pi integral from -1 to 1 of (1 - z^2) g(d + z) dz        (Eq. 12 of Bender et al. 2020, g its Eq. 13)
//! ```
//! On a sphere of large radius 1/k the distance at offset z along the normal and s across is d + z + k s^2 / 2. The
//! terms linear in k are
//! ```text
//! R1(d) = -pi integral from |d| to 1 of W(t) t (t^2 - d^2) dt
//! V1(d) = pi / 4 integral from -1 to 1 of (1 - z^2)^2 g'(d + z) dz
//! beta  = (R1 / R) / (V1 / V),
//! ```
//! the exponent with which a density that is R (V / V_plane)^beta is right to first order, in bowls (k < 0) as well.

use crate::kernel::KernelKind;
use crate::quadrature::{integrate, integrate_pieces};
use std::f64::consts::PI;

/// R and R' (rho_B / rho_0 of the half space).
pub(crate) fn density(kernel: KernelKind, d: f64) -> [f64; 2] {
    let depth = d.abs().min(1.0);
    let moment = |f: &dyn Fn(f64) -> f64| {
        2.0 * PI * integrate_pieces(&[0.5], depth, 1.0, |s| kernel.unit_value(s) * s * f(s))
    };
    let outside = moment(&|s| s - depth);
    [if d < 0.0 { 1.0 - outside } else { outside }, -moment(&|_| 1.0)]
}

/// V and V' of the half space.
pub(crate) fn volume(d: f64) -> [f64; 2] {
    let over_ball = |f: fn(f64) -> f64| PI * over_extension(d, |z| (1.0 - z * z) * f(d + z));
    let solid = (-d).clamp(-1.0, 1.0);
    let solid = PI * integrate(-1.0, solid, |z| 1.0 - z * z);
    [solid + over_ball(extension), over_ball(extension_slope)]
}

/// The same of the half plane in two dimensions: V(d) = 2 integral from -1 to 1 of (1 - z^2)^(1/2) g(d + z) dz, in the
/// angle whose sine is z.
pub(crate) fn area(d: f64) -> [f64; 2] {
    let angle = |z: f64| z.clamp(-1.0, 1.0).asin();
    let breaks = [-d, 0.5 - d, 1.0 - d].map(angle);
    let over = |f: fn(f64) -> f64| {
        let term = |t: f64| 2.0 * t.cos().powi(2) * f(d + t.sin());
        breaks.windows(2).map(|ends| integrate_finely(ends[0], ends[1], term)).sum::<f64>()
    };
    // Of the segment that is all solid.
    let solid = breaks[0];
    let full = solid + 0.5 * PI + solid.sin() * solid.cos();
    [full + over(extension), over(extension_slope)]
}

/// The integral of what is smooth but no polynomial.
fn integrate_finely(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    const PARTS: usize = 4;
    let at = |n: usize| low + (high - low) * n as f64 / PARTS as f64;
    (0..PARTS).map(|n| integrate(at(n), at(n + 1), &f)).sum()
}

/// beta; 0 where curvature no longer matters, deep inside.
pub(crate) fn exponent(kernel: KernelKind, d: f64) -> f64 {
    let depth = d.abs();
    let term = |t: f64| kernel.unit_value(t) * t * (t * t - d * d);
    let change = -PI * integrate_pieces(&[0.5], depth, 1.0, term);
    let across = |z: f64| (1.0 - z * z).powi(2);
    let volume_change = 0.25 * PI * over_extension(d, |z| across(z) * extension_slope(d + z));
    if d >= 1.0 {
        // The limit at d = 1, where both R and R1 vanish: R1 / R = -1.
        return -volume(1.0)[0] / (0.25 * PI * over_extension(1.0, |z| across(z) * extension_slope(1.0 + z)));
    }
    if d <= -1.0 + 1e-6 {
        return 0.0;
    }
    change / density(kernel, d)[0] * (volume(d)[0] / volume_change)
}

/// g, Eq. 13 of Bender et al. 2020.
pub(crate) fn extension(phi: f64) -> f64 {
    match phi {
        _ if phi <= 0.0 => 1.0,
        _ if phi <= 0.5 => 6.0 * (phi - 1.0) * phi * phi + 1.0,
        _ => 2.0 * (1.0 - phi).max(0.0).powi(3),
    }
}

fn extension_slope(phi: f64) -> f64 {
    match phi {
        _ if phi <= 0.0 => 0.0,
        _ if phi <= 0.5 => 6.0 * phi * (3.0 * phi - 2.0),
        _ => -6.0 * (1.0 - phi).max(0.0).powi(2),
    }
}

/// The integral along the normal, within the ball, where the extension is neither 0 nor 1: 0 < d + z < 1.
fn over_extension(d: f64, f: impl Fn(f64) -> f64) -> f64 {
    integrate_pieces(&[0.5 - d], (-d).max(-1.0), (1.0 - d).min(1.0), f)
}
