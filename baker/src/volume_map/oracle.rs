//! Eq. 12 of Bender et al. 2020 as it is written, one point at a time: slow, and the measure of the fast one.

use super::extension::extension;
use super::quadrature::Point;
use crate::sdf::field::{DistanceField, Phi};
use glam::DVec3;

/// Boundary volume at a point, m^3: the integral of gamma*(Phi(x + xi)) over |xi| <= r by the rule's points.
pub fn volume(field: &DistanceField, points: &[Point], radius: f64, x: DVec3) -> f64 {
    let sample = |point: &Point| match field.at(x + radius * point.position) {
        Phi::Value(phi) => extension(phi, 1.0 / radius),
        Phi::Solid => 1.0,
        Phi::Fluid => 0.0,
    };
    radius.powi(3) * points.iter().map(|point| point.weight * sample(point)).sum::<f64>()
}
