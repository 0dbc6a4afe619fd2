//! The slow twins: every triangle for every query. Tests compare the fast paths with them.

use glam::DVec3;

use crate::sdf::closest_point::{Closest, closest_point_on_triangle};
use crate::sdf::winding::solid_angle;

/// Closest point of all triangles, of which there must be at least one; O(n).
pub fn closest(triangles: &[[DVec3; 3]], p: DVec3) -> Closest {
    let mut best: Option<Closest> = None;
    for (i, corners) in triangles.iter().enumerate() {
        let found = closest_point_on_triangle(p, corners);
        if best.is_none_or(|best| found.distance_squared < best.distance_squared) {
            best = Some(Closest {
                distance_squared: found.distance_squared,
                point: found.point,
                triangle: i as u32,
                feature: found.feature,
            });
        }
    }
    best.expect("at least one triangle")
}

/// Winding number of all triangles around `p`; O(n).
pub fn winding_number(triangles: &[[DVec3; 3]], p: DVec3) -> f64 {
    let sum: f64 = triangles.iter().map(|corners| solid_angle(p, corners)).sum();
    sum / (4.0 * std::f64::consts::PI)
}
