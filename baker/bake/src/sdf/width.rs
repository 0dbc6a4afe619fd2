//! How wide a wall or a gap is at a point of the surface: the largest ball that touches the surface there and holds no
//! other part of it. It is found by shrinking (Ma, Bae and Choi 2012, "3D medial axis point approximation using nearest
//! neighbors and the normal field"), which needs closest points and nothing else.

use glam::DVec3;

use super::mesh_distance::MeshDistance;

/// Balls stop shrinking when the radius changes by less than this part.
const ENOUGH: f64 = 1e-3;
const STEPS: usize = 30;
/// Cosine of the largest angle between the normal and the way to the other side, and between the two normals: beyond
/// it, it is no other side but the surface itself going on around an edge.
const FACING: f64 = 0.8;
/// Balls that shrink to less than this part of the reach lie in an edge.
const NOTHING: f64 = 1e-6;

/// Diameter, metres, of the largest ball that touches the surface at `p` from the side of `n`, a normal there, and
/// holds nothing of it, if it is below `reach`.
pub fn touching_ball(mesh: &MeshDistance, p: DVec3, n: DVec3, reach: f64) -> Option<f64> {
    let mut radius = 0.5 * reach;
    for step in 0..STEPS {
        let closest = mesh.closest_within(p + radius * n, radius);
        let free = closest.distance_squared.sqrt() >= radius * (1.0 - ENOUGH);
        if free && step == 0 {
            return None;
        }
        if free {
            break;
        }
        let q = closest.point - p;
        // The ball through p and q whose centre lies on the normal at p.
        let smaller = q.length_squared() / (2.0 * q.dot(n));
        // The other side faces this one, or it is this surface going on.
        let faces = mesh.normal(closest.triangle).dot(n).abs() > FACING && q.dot(n) > FACING * q.length();
        if !faces || smaller.is_nan() || smaller >= radius {
            return None;
        }
        radius = smaller;
    }
    (2.0 * radius > NOTHING * reach).then_some(2.0 * radius)
}
