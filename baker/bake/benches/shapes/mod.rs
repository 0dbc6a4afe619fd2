//! Shapes with a closed form of their distance, and points near them, for r = 1.

use glam::DVec3;

pub type Shape = (&'static str, fn(DVec3) -> f64);

/// Half width of a plate of r / 4.
const PLATE: f64 = 0.125;

/// Distances for r = 1; the directions of planes and edges are none of the rules' own.
pub const SHAPES: [Shape; 8] = [
    ("plane", |x| turned(x).z),
    ("sphere, r", |x| x.length() - 1.0),
    ("sphere, r/2", |x| x.length() - 0.5),
    ("bowl, 2 r", |x| 2.0 - x.length()),
    ("convex edge", |x| convex(turned(x).with_x(-9.0))),
    ("convex corner", |x| convex(turned(x))),
    ("concave edge", |x| turned(x).y.min(turned(x).z)),
    ("plate, r/4", |x| turned(x).z.abs() - PLATE),
];

fn turned(x: DVec3) -> DVec3 {
    glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.4, 0.7, 1.1) * x
}

/// Outside of the octant of negative coordinates; a bound inside.
fn convex(q: DVec3) -> f64 {
    q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
}

fn halton(index: u32, base: u32) -> f64 {
    let (mut i, mut scale, mut sum) = (index, 1.0, 0.0);
    while i > 0 {
        scale /= f64::from(base);
        sum += scale * f64::from(i % base);
        i /= base;
    }
    sum
}

/// Points with 0 < Phi < 2 r.
pub fn points(phi: fn(DVec3) -> f64) -> Vec<DVec3> {
    let point = |i: u32| DVec3::new(halton(i, 2), halton(i, 3), halton(i, 5)) * 6.0 - 3.0;
    (1..).map(point).filter(|x| (0.0..2.0).contains(&phi(*x))).take(400).collect()
}
