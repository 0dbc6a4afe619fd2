//! Eq. 12 of Bender et al. 2020 as it is written, one point at a time: slow, and the measure of the fast ones.

use super::extension::extension;
use super::quadrature::Point;
use crate::sdf::field::{DistanceField, Phi};
use crate::sdf::{Neighbours, SignedDistance};
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

/// The same on the distance itself, which is not discretised. What is known `near` the point makes it faster.
pub fn volume_on_exact_distance(
    phi: &impl SignedDistance,
    points: &[Point],
    radius: f64,
    x: DVec3,
    near: &mut Neighbours,
) -> f64 {
    let mut sum = 0.0;
    // Points of a rule that follow each other lie close together.
    for points in points.chunks(Neighbours::MAX) {
        let mut places = [x; Neighbours::MAX];
        places.iter_mut().zip(points).for_each(|(place, point)| *place += radius * point.position);
        let places = &places[..points.len()];
        phi.prepare(places, near, true);
        for ((point, place), known) in points.iter().zip(places).zip(&mut near.known) {
            sum += point.weight * extension(phi.near(*place, known), 1.0 / radius);
        }
    }
    radius.powi(3) * sum
}
