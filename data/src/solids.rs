//! Analytic solids as implicit functions: negative inside, about a distance near the surface.
//!
//! Inigo Quilez, *Distance functions* and *Smooth minimum*, <https://iquilezles.org/articles/>.

use glam::{DVec2, DVec3};

/// Ball, exact.
pub fn ball(p: DVec3, centre: DVec3, radius: f64) -> f64 {
    p.distance(centre) - radius
}

/// Ellipsoid along the axes: exact zero set, first-order distance (k0 (k0 - 1) / k1 in the source).
pub fn ellipsoid(p: DVec3, centre: DVec3, radii: DVec3) -> f64 {
    let q = (p - centre) / radii;
    let gradient = (q / radii).length();
    let k = q.length();
    if gradient == 0.0 { -radii.min_element() } else { k * (k - 1.0) / gradient }
}

/// Segment a-b thickened by a radius that runs linearly from `radius_a` to `radius_b`, with round ends.
pub fn tapered(p: DVec3, [a, b]: [DVec3; 2], [radius_a, radius_b]: [f64; 2]) -> f64 {
    let axis = b - a;
    let t = ((p - a).dot(axis) / axis.length_squared()).clamp(0.0, 1.0);
    p.distance(a + axis * t) - (radius_a + (radius_b - radius_a) * t)
}

/// Rotates p about the x axis through `centre`, so that the direction (0, `slope`, 1) becomes +z. Describes a
/// solid that is tilted upwards by that slope, without an angle.
pub fn untilt(p: DVec3, centre: DVec3, slope: f64) -> DVec3 {
    let forward = DVec2::new(slope, 1.0).normalize();
    let (sine, cosine) = (forward.x, forward.y);
    let q = p - centre;
    centre + DVec3::new(q.x, q.y * cosine - q.z * sine, q.y * sine + q.z * cosine)
}

/// Union of two solids with a fillet of width about `k` (quadratic polynomial smooth minimum).
pub fn smooth_union(a: f64, b: f64, k: f64) -> f64 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * k / 4.0
}

/// Intersection of two solids with a rounded edge.
pub fn smooth_intersection(a: f64, b: f64, k: f64) -> f64 {
    -smooth_union(-a, -b, k)
}
