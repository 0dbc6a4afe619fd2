//! A closed drum with baffles, to be baked inverted and turned about its axis, as a mixer or a washing
//! machine.
//!
//! Its section is a regular polygon, whose corners come from half angles: sin and cos of pi/16 by square
//! roots alone. A few of its sides are wedges that point to the axis and carry the water up.

use glam::{DVec2, DVec3};

use crate::mesh::Mesh;

/// Radius of the polygon's corners, m.
pub const RADIUS: f64 = 1.0;
/// Length along z, m.
pub const LENGTH: f64 = 0.8;
/// Sides of the polygon.
pub const SIDES: usize = 32;
/// Sides from one baffle to the next.
const BAFFLE_EVERY: usize = 8;
/// Distance of a baffle's edge from the axis, m.
const BAFFLE_RADIUS: f64 = 0.75;

/// The space in the drum, as a solid: axis z, middle at the origin, triangles outwards.
pub fn drum() -> Mesh {
    let outline = outline();
    let n = outline.len() as u32;
    let mut mesh = Mesh::default();
    for z in [-0.5 * LENGTH, 0.5 * LENGTH] {
        for point in &outline {
            mesh.push(point.extend(z));
        }
    }
    let [back, front] = [-0.5, 0.5].map(|side| mesh.push(DVec3::Z * (side * LENGTH)));
    for i in 0..n {
        let j = (i + 1) % n;
        mesh.push_quad([i, j, n + j, n + i]);
        mesh.triangles.extend([[back, j, i], [front, n + i, n + j]]);
    }
    mesh
}

/// The section, counter-clockwise. Seen from the axis, no part of it hides another.
fn outline() -> Vec<DVec2> {
    let half = |cosine: f64| ((1.0 + cosine) / 2.0).sqrt();
    // cos of pi/2, then pi/4, pi/8, pi/16.
    let eighth = half(half(0.0));
    let step = DVec2::new(half(eighth), ((1.0 - eighth) / 2.0).sqrt());
    let mut corner = DVec2::X * RADIUS;
    let mut out = Vec::new();
    for side in 0..SIDES {
        out.push(corner);
        let next = step.rotate(corner);
        if side % BAFFLE_EVERY == 0 {
            out.push((corner + next).normalize() * BAFFLE_RADIUS);
        }
        corner = next;
    }
    out
}
