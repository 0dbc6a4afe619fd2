//! Solids with exact distances, and what closures should give there, by brute force. The support radius is 1, the
//! particle radius 1/4.

#![allow(dead_code, reason = "the tests and the bench each use a part")]

use std::f64::consts::FRAC_1_SQRT_2;
use volmap_formats::asset::{Array, Asset, Attributes, CellRun, GridSpec};
use volmap_runtime::{
    Closure, ClosureKind, DVec3, Dimension, Exterior, Kernel, QuadratureSpec, Surface, VolumeMap,
};

pub const PARTICLE: f64 = 0.25;

/// Distances of the tables, in particle radii.
pub const DISTANCES: [f64; 6] = [0.25, 0.5, 1.0, 1.5, 2.0, 2.5];

/// A map of one cell, for closures: only its support radius (metres) matters.
pub fn map_of(support_radius: f64) -> VolumeMap {
    let asset = Asset {
        dimension: Dimension::Three,
        grid: GridSpec { origin: [0.0; 3], cell_size: [1.0; 3], resolution: [1; 3] },
        support_radius,
        exterior: Exterior::Fluid,
        quadrature: QuadratureSpec { name: "none".into(), degree: 1, points: 1, ball_volume: 1.0 },
        band_cells: vec![CellRun { i: 0, j: 0, k: 0, len: 1 }],
        solid_cells: Vec::new(),
        finer: Vec::new(),
        signed_distance: Array::F64(vec![0.0; 32]),
        volume: Array::F64(vec![0.0; 32]),
        density: None,
        plane_weight: None,
        bake: Attributes::new(),
        source: Attributes::new(),
        diagnosis: Attributes::new(),
    };
    VolumeMap::from_asset(&asset).expect("a map")
}

/// A closure of the map that goes with it.
pub fn closure_of(kind: ClosureKind, kernel: Kernel, particle_radius: f64) -> Closure {
    let map = map_of(kind.map_radius(kernel.support_radius()));
    map.closure(kind, kernel, particle_radius).expect("a map of the right radius")
}

/// A solid and where particles at a distance d are.
pub struct Shape {
    pub name: &'static str,
    pub phi: Box<dyn Fn(DVec3) -> f64>,
    pub places: Box<dyn Fn(f64) -> Vec<DVec3>>,
}

fn shape(
    name: &'static str,
    phi: impl Fn(DVec3) -> f64 + 'static,
    places: impl Fn(f64) -> Vec<DVec3> + 'static,
) -> Shape {
    Shape { name, phi: Box::new(phi), places: Box::new(places) }
}

fn above(shift: f64) -> impl Fn(f64) -> Vec<DVec3> {
    move |d| vec![DVec3::new(0.0, 0.0, d + shift)]
}

pub fn plane() -> Shape {
    shape("plane", |x| x.z, above(0.0))
}

pub fn ball(name: &'static str, radius: f64) -> Shape {
    shape(name, move |x| x.length() - radius, above(radius))
}

pub fn bowl(name: &'static str, radius: f64) -> Shape {
    shape(name, move |x| radius - x.length(), above(-radius))
}

pub fn cylinder(name: &'static str, radius: f64) -> Shape {
    shape(name, move |x| x.x.hypot(x.z) - radius, above(radius))
}

pub fn plate(name: &'static str, thickness: f64) -> Shape {
    shape(name, move |x| (x.z + 0.5 * thickness).abs() - 0.5 * thickness, above(0.0))
}

/// Fluid in the octant of positive x, y and z.
fn corner_phi(x: DVec3) -> f64 {
    if x.min_element() > 0.0 { x.min_element() } else { -x.min(DVec3::ZERO).length() }
}

/// Fluid where x and z are positive.
fn edge_phi(x: DVec3) -> f64 {
    corner_phi(DVec3::new(x.x, f64::INFINITY, x.z))
}

pub fn concave_corner() -> Shape {
    shape("concave corner", corner_phi, |d| vec![DVec3::splat(d)])
}

pub fn concave_edge() -> Shape {
    shape("concave edge", edge_phi, |d| vec![DVec3::new(d, 0.0, d)])
}

/// At several distances from the second wall.
pub fn along_concave_edge() -> Shape {
    let places = |d| [0.02, 0.1, 0.25, 0.5, 0.8].map(|s| DVec3::new(d + s, 0.0, d)).to_vec();
    shape("concave edge, along it", edge_phi, places)
}

pub fn convex_corner() -> Shape {
    shape("convex corner", |x| -corner_phi(-x), |d| vec![DVec3::splat(d / 3.0_f64.sqrt())])
}

/// On the bisector.
pub fn convex_edge() -> Shape {
    let c = |d| d * FRAC_1_SQRT_2;
    shape("convex edge", |x| -edge_phi(-x), move |d| vec![DVec3::new(c(d), 0.0, c(d))])
}

/// From the face to the bisector.
pub fn around_convex_edge() -> Shape {
    let places = |d: f64| {
        let face = [0.8, 0.5, 0.25, 0.1, 0.0].map(|s| DVec3::new(-s, 0.0, d));
        let around = [0.2, 0.4, 0.6].map(|angle: f64| d * DVec3::new(angle.sin(), 0.0, angle.cos()));
        [face.as_slice(), &around].concat()
    };
    shape("convex edge, around it", |x| -edge_phi(-x), places)
}

/// The end of a plate: its edges have 90 degrees, and are near to each other.
pub fn plate_end(name: &'static str, thickness: f64) -> Shape {
    let phi = move |x: DVec3| {
        let (x, z) = (x.x, (x.z + 0.5 * thickness).abs() - 0.5 * thickness);
        x.max(0.0).hypot(z.max(0.0)) + x.max(z).min(0.0)
    };
    let places = move |d| {
        let mut places = [0.5, 0.25, 0.0].map(|s| DVec3::new(-s, 0.0, d)).to_vec();
        places.push(DVec3::new(d, 0.0, -0.5 * thickness));
        places
    };
    shape(name, phi, places)
}

/// Exact density over rest density and volume at a point: midpoint sums over a lattice of 2 / `steps`, the surface's
/// cells in part.
pub fn integrate(phi: &dyn Fn(DVec3) -> f64, kernel: &Kernel, x: DVec3, steps: i32) -> (f64, f64) {
    let h = 2.0 / f64::from(steps);
    let at = |n: i32| (f64::from(n) + 0.5) * h - 1.0;
    let (mut solid, mut weight, mut volume, mut count) = (0.0, 0.0, 0.0, 0.0);
    for k in 0..steps {
        for j in 0..steps {
            for i in 0..steps {
                let xi = DVec3::new(at(i), at(j), at(k));
                if xi.length_squared() < 1.0 {
                    let (phi, w) = (phi(x + xi), kernel.value(xi.length()));
                    solid += w * (0.5 - phi / h).clamp(0.0, 1.0);
                    weight += w;
                    volume += extension(phi);
                    count += 1.0;
                }
            }
        }
    }
    (solid / weight, volume / count * 4.0 / 3.0 * std::f64::consts::PI)
}

/// Eq. 13 of Bender et al. 2020.
fn extension(phi: f64) -> f64 {
    match phi {
        _ if phi <= 0.0 => 1.0,
        _ if phi <= 0.5 => 6.0 * (phi.powi(3) - phi.powi(2)) + 1.0,
        _ => 2.0 * (1.0 - phi).max(0.0).powi(3),
    }
}

/// What a perfect map would say at a point.
pub fn surface(phi: &dyn Fn(DVec3) -> f64, x: DVec3, volume: f64) -> Surface {
    let distance = phi(x);
    let slope = |axis: DVec3| phi(x + 1e-6 * axis) - phi(x - 1e-6 * axis);
    let normal = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)).normalize();
    Surface { distance, normal, closest_point: x - distance * normal, volume }
}

/// A particle near a solid: what the map says, what is true.
pub struct Case {
    pub position: DVec3,
    pub surface: Surface,
    pub density: f64,
}

/// All places of a shape at all distances.
pub fn cases(shape: &Shape, kernel: &Kernel, steps: i32) -> Vec<Case> {
    let places = DISTANCES.iter().flat_map(|d| (shape.places)(PARTICLE * d));
    let case = |position| {
        let (density, volume) = integrate(&shape.phi, kernel, position, steps);
        Case { position, surface: surface(&shape.phi, position, volume), density }
    };
    places.map(case).collect()
}

/// Exact gradients of density and volume, from differences.
pub fn gradients(shape: &Shape, kernel: &Kernel, x: DVec3, steps: i32) -> (DVec3, DVec3) {
    const STEP: f64 = 0.02;
    let difference = |axis: DVec3| {
        let [above, below] = [STEP, -STEP].map(|s| integrate(&shape.phi, kernel, x + s * axis, steps));
        ((above.0 - below.0) / (2.0 * STEP), (above.1 - below.1) / (2.0 * STEP))
    };
    let [x, y, z] = DVec3::AXES.map(difference);
    (DVec3::new(x.0, y.0, z.0), DVec3::new(x.1, y.1, z.1))
}
