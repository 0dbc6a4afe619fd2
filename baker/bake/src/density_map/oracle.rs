//! Eq. 9 of Bender et al. 2020 as it is written, one point at a time: slow, and the measure of the fast one.

use super::DensitySettings;
use glam::DVec3;

/// gamma over rho0, Eq. 11, for any length where it becomes 0 (metres).
pub fn extension(phi: f64, length: f64) -> f64 {
    if phi < length { 1.0 - phi / length } else { 0.0 }
}

/// Boundary density over rest density at a point, for a support radius in metres.
pub fn density(phi: impl Fn(DVec3) -> f64, settings: &DensitySettings, radius: f64, x: DVec3) -> f64 {
    let length = settings.extension * radius;
    let term = |xi: DVec3| extension(phi(x + radius * xi), length) * settings.kernel.unit_value(xi.length());
    settings.rule.points().iter().map(|point| point.weight * term(point.position)).sum()
}
