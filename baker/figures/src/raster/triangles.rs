//! Triangles on the picture, by edge functions. Pineda 1988, *A Parallel Algorithm for Polygon Rasterization*.

use super::bands::{BAND, Bands};
use super::view::View;
use glam::{Quat, Vec3};
use rayon::prelude::*;

/// A triangle on the picture.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    corners: [Corner; 3],
    /// Number of what it belongs to.
    material: u32,
}

#[derive(Clone, Copy, Debug)]
struct Corner {
    at: [f32; 2],
    /// 1 / depth, or depth in a parallel view: linear on the picture.
    q: f32,
    /// In the world, towards the eye.
    normal: Vec3,
}

/// Which sides of the triangles are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// All.
    Both,
    /// Those that are turned away from the eye: of a container, into which one sees.
    Back,
}

/// A point of the view, and a normal of the world.
type Vertex = (Vec3, Vec3);

/// Triangles in the world.
#[derive(Clone, Copy, Debug)]
pub struct Faces<'a> {
    /// Places of the vertices, metres.
    pub places: &'a [Vec3],
    /// Their corners.
    pub triangles: &'a [[u32; 3]],
    /// A normal at each corner, which `rotation` turns into the world.
    pub normals: &'a [[Vec3; 3]],
    /// See `normals`.
    pub rotation: Quat,
}

/// The triangles that may be seen. `material` gives each its number.
pub fn project(
    view: &View,
    faces: &Faces,
    sides: Sides,
    material: impl Fn(usize) -> u32 + Sync,
) -> Vec<Triangle> {
    let local: Vec<Vec3> = faces.places.iter().map(|&place| view.local(place)).collect();
    let one = |(number, (corners, normals)): (usize, (&[u32; 3], &[Vec3; 3]))| {
        let [a, b, c] = corners.map(|corner| local[corner as usize]);
        // In local coordinates, whose z goes into the picture.
        let facing = (b - a).cross(c - a).dot(if view.parallel { -Vec3::Z } else { -a });
        // Local coordinates are right, up, forward: a left-handed system.
        let front = facing < 0.0;
        let sign = if front { 1.0 } else { -1.0 };
        let drawn = !(sides == Sides::Back && front) && facing != 0.0;
        let vertex = |n: usize| (local[corners[n] as usize], sign * (faces.rotation * normals[n]));
        let material = material(number);
        drawn.then(|| clipped(view, [vertex(0), vertex(1), vertex(2)], material)).into_iter().flatten()
    };
    let pairs = (faces.triangles, faces.normals).into_par_iter().enumerate();
    pairs.with_min_len(1 << 10).flat_map_iter(one).collect()
}

/// The parts of a triangle behind the near plane: none, one or two triangles.
fn clipped(view: &View, vertices: [Vertex; 3], material: u32) -> impl Iterator<Item = Triangle> + use<> {
    let near = if view.parallel { f32::NEG_INFINITY } else { view.near };
    let mut polygon: Vec<Vertex> = Vec::with_capacity(4);
    for n in 0..3 {
        let (from, to) = (vertices[n], vertices[(n + 1) % 3]);
        if from.0.z > near {
            polygon.push(from);
        }
        if (from.0.z > near) != (to.0.z > near) {
            let t = (near - from.0.z) / (to.0.z - from.0.z);
            polygon.push((from.0.lerp(to.0, t), from.1.lerp(to.1, t)));
        }
    }
    let corner = |(place, normal): Vertex| Corner {
        at: view.pixel(place),
        q: if view.parallel { place.z } else { 1.0 / place.z },
        normal,
    };
    let corners: Vec<Corner> = polygon.into_iter().map(corner).collect();
    (2..corners.len()).map(move |n| Triangle { corners: [corners[0], corners[n - 1], corners[n]], material })
}

/// Triangles by the bands that they touch, of a picture of so many rows.
pub fn sorted(triangles: &[Triangle], height: usize) -> Bands {
    Bands::new(triangles, height, |t| {
        let [a, b, c] = t.corners.map(|corner| corner.at[1]);
        a.min(b).min(c)..a.max(b).max(c)
    })
}

/// The surface at a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fragment {
    /// Metres; infinite where there is none.
    pub depth: f32,
    /// In the world, towards the eye; not of length 1.
    pub normal: Vec3,
    /// Number of what it belongs to.
    pub material: u32,
}

impl Fragment {
    /// Nothing.
    pub const NONE: Fragment = Fragment { depth: f32::INFINITY, normal: Vec3::ZERO, material: u32::MAX };
}

impl Triangle {
    /// Draws it into the pixels of a band, where it is nearer than what they hold.
    pub fn draw(&self, band: usize, view: &View, pixels: &mut [Fragment]) {
        let at = self.corners.map(|corner| corner.at.map(f64::from));
        let area = cross(at[0], at[1], at[2]);
        let range = |axis: usize, low: usize, high: usize| {
            let all = self.corners.map(|corner| corner.at[axis]);
            let (min, max) = (all[0].min(all[1]).min(all[2]), all[0].max(all[1]).max(all[2]));
            let first = (min - 0.5).ceil().max(low as f32) as usize;
            first..((max + 0.5).floor().max(0.0) as usize).min(high)
        };
        let first = band * BAND;
        let columns = range(0, 0, view.size[0]);
        if area == 0.0 || !area.is_finite() || columns.is_empty() {
            return;
        }
        for row in range(1, first, (first + BAND).min(view.size[1])) {
            // Weights of the corners at the row's first pixel, and their change from pixel to pixel.
            let start = [columns.start as f64 + 0.5, row as f64 + 0.5];
            let weight = |n: usize| cross(at[(n + 1) % 3], at[(n + 2) % 3], start) / area;
            let slope = |n: usize| -(at[(n + 2) % 3][1] - at[(n + 1) % 3][1]) / area;
            let (weights, slopes) = ([weight(0), weight(1), weight(2)], [slope(0), slope(1), slope(2)]);
            for column in columns.clone() {
                let step = (column - columns.start) as f64;
                let b = [0, 1, 2].map(|n| (weights[n] + step * slopes[n]) as f32);
                if b.iter().all(|&b| b >= 0.0) {
                    self.set(b, view, &mut pixels[(row - first) * view.size[0] + column]);
                }
            }
        }
    }

    fn set(&self, b: [f32; 3], view: &View, pixel: &mut Fragment) {
        let sum = |of: fn(&Corner) -> f32| (0..3).map(|n| b[n] * of(&self.corners[n])).sum::<f32>();
        let q = sum(|corner| corner.q);
        let depth = if view.parallel { q } else { 1.0 / q };
        if depth < pixel.depth {
            let part = |n: usize| b[n] * if view.parallel { 1.0 } else { self.corners[n].q };
            let normal = (0..3).map(|n| part(n) * self.corners[n].normal).sum();
            *pixel = Fragment { depth, normal, material: self.material };
        }
    }
}

/// Twice the signed area.
fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}
