//! The closest point of a triangle, and the feature (face, edge, vertex) on which it lies.
//!
//! Ericson, *Real-Time Collision Detection* (2005), section 5.1.5, splits space into the Voronoi
//! regions of the features. On slivers the tests for these regions cancel, so we take the nearest of
//! four candidates instead: the point of each edge, and the projection onto the face where its
//! barycentric coordinates are all positive. Each candidate is a point of the triangle whatever the
//! rounding, and the edges of a sliver are never further than its height from the true point.

use glam::DVec3;
use wide::f64x4;

/// The part of a triangle on which a closest point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// The inside of the face.
    Face,
    /// The inside of edge i, from corner i to corner (i + 1) mod 3.
    Edge(u8),
    /// Corner i.
    Vertex(u8),
}

/// The closest point of a triangle mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// Squared distance from the query point.
    pub distance_squared: f64,
    /// The point of the mesh.
    pub point: DVec3,
    /// Index of its triangle; of several at the same distance, the lowest.
    pub triangle: u32,
    /// The feature of that triangle.
    pub feature: Feature,
}

/// The closest point of one triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrianglePoint {
    /// Squared distance from the query point.
    pub distance_squared: f64,
    /// The point of the triangle.
    pub point: DVec3,
    /// The feature on which it lies.
    pub feature: Feature,
}

/// Closest point of the triangle `corners`, which may have no area.
///
/// The three edges side by side, without branches: which of them is the closest can't be guessed.
pub fn closest_point_on_triangle(p: DVec3, corners: &[DVec3; 3]) -> TrianglePoint {
    let [a, b, c] = corners.map(|corner| corner - p);
    let (starts, ends) = (Vec4::from_lanes([a, b, c, c]), Vec4::from_lanes([b, c, a, a]));
    let along = ends - starts;
    let length_squared = along.dot(along).fast_max(f64x4::splat(f64::MIN_POSITIVE));
    let t = -starts.dot(along) / length_squared;
    // The ends are taken as they are, so that all triangles at a vertex give one and the same distance.
    let (begun, passed) = (t.simd_gt(f64x4::ZERO), t.simd_ge(f64x4::ONE));
    let offsets = Vec4::select(passed, ends, Vec4::select(begun, starts + along.scale(t), starts));
    let [first, second, third, _] = offsets.dot(offsets).to_array();
    let (edge, squared) = if second < first { (1, second) } else { (0, first) };
    let (edge, squared) = if third < squared { (2, third) } else { (edge, squared) };
    if let Some(offset) = projection_on_face([a, b, c], ends)
        && offset.length_squared() < squared
    {
        let distance_squared = offset.length_squared();
        return TrianglePoint { distance_squared, point: p + offset, feature: Feature::Face };
    }
    let t = t.as_array()[edge];
    let (point, feature) = if t >= 1.0 {
        (corners[(edge + 1) % 3], Feature::Vertex((edge as u8 + 1) % 3))
    } else if t > 0.0 {
        (p + offsets.lane(edge), Feature::Edge(edge as u8))
    } else {
        (corners[edge], Feature::Vertex(edge as u8))
    };
    TrianglePoint { distance_squared: squared, point, feature }
}

/// The origin's projection onto the face, where it falls inside; `next` are b, c, a.
#[inline(always)]
fn projection_on_face([a, b, c]: [DVec3; 3], next: Vec4) -> Option<DVec3> {
    let normal = (b - a).cross(c - a);
    let after_next = Vec4::from_lanes([c, a, b, b]);
    let weights = Vec4::splat(normal).dot(next.cross(after_next));
    let is_outside = weights.simd_lt(f64x4::ZERO).to_bitmask() & 0b111 != 0;
    let [u, v, w, _] = weights.to_array();
    let sum = u + v + w;
    if is_outside || sum <= 0.0 {
        return None;
    }
    Some((a * u + b * v + c * w) / sum)
}

/// Four triangles side by side, a component of the four in one SIMD register.
#[derive(Clone, Debug)]
pub struct TriangleBlock {
    corners: [Vec4; 3],
}

impl TriangleBlock {
    /// One to four triangles; the places left over hold the first corner of the last triangle as a
    /// triangle without area, which changes neither distances nor solid angles.
    pub fn new(triangles: &[[DVec3; 3]]) -> TriangleBlock {
        let last = triangles[triangles.len() - 1][0];
        let corner = |k: usize| {
            let lane = |i: usize| triangles.get(i).map_or(last, |triangle| triangle[k]);
            Vec4::from_lanes([lane(0), lane(1), lane(2), lane(3)])
        };
        TriangleBlock { corners: [corner(0), corner(1), corner(2)] }
    }

    /// The corners of the four triangles.
    #[inline]
    pub fn corners(&self) -> &[Vec4; 3] {
        &self.corners
    }

    /// The corners of one, read where they are: copies of all four would take longer than what is done with one.
    #[inline]
    pub fn triangle(&self, place: usize) -> [DVec3; 3] {
        let [a, b, c] = &self.corners;
        [a.lane(place), b.lane(place), c.lane(place)]
    }
}

/// Four points or vectors of space.
#[derive(Clone, Copy, Debug)]
pub struct Vec4 {
    /// Their x coordinates.
    pub x: f64x4,
    /// Their y coordinates.
    pub y: f64x4,
    /// Their z coordinates.
    pub z: f64x4,
}

impl Vec4 {
    /// Four times the same vector.
    #[inline(always)]
    pub fn splat(v: DVec3) -> Vec4 {
        Vec4 { x: f64x4::splat(v.x), y: f64x4::splat(v.y), z: f64x4::splat(v.z) }
    }

    /// Four vectors.
    pub fn from_lanes(v: [DVec3; 4]) -> Vec4 {
        Vec4 { x: f64x4::new(v.map(|v| v.x)), y: f64x4::new(v.map(|v| v.y)), z: f64x4::new(v.map(|v| v.z)) }
    }

    /// Vector i.
    #[inline]
    pub fn lane(&self, i: usize) -> DVec3 {
        DVec3::new(self.x.as_array()[i], self.y.as_array()[i], self.z.as_array()[i])
    }

    /// Sets vector i.
    pub fn set_lane(&mut self, i: usize, v: DVec3) {
        self.x.as_mut_array()[i] = v.x;
        self.y.as_mut_array()[i] = v.y;
        self.z.as_mut_array()[i] = v.z;
    }

    /// Each vector of `yes` where the mask is set, of `no` elsewhere.
    #[inline(always)]
    pub fn select(mask: f64x4, yes: Vec4, no: Vec4) -> Vec4 {
        Vec4 { x: mask.select(yes.x, no.x), y: mask.select(yes.y, no.y), z: mask.select(yes.z, no.z) }
    }

    /// The sum of the four.
    pub fn sum_lanes(self) -> DVec3 {
        DVec3::new(self.x.reduce_add(), self.y.reduce_add(), self.z.reduce_add())
    }

    /// Dot products.
    #[inline(always)]
    pub fn dot(self, o: Vec4) -> f64x4 {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    /// Cross products.
    #[inline(always)]
    pub fn cross(self, o: Vec4) -> Vec4 {
        Vec4 {
            x: self.y * o.z - self.z * o.y,
            y: self.z * o.x - self.x * o.z,
            z: self.x * o.y - self.y * o.x,
        }
    }

    /// Each vector times its own factor.
    #[inline(always)]
    pub fn scale(self, s: f64x4) -> Vec4 {
        Vec4 { x: self.x * s, y: self.y * s, z: self.z * s }
    }
}

impl std::ops::Add for Vec4 {
    type Output = Vec4;
    #[inline(always)]
    fn add(self, o: Vec4) -> Vec4 {
        Vec4 { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl std::ops::Sub for Vec4 {
    type Output = Vec4;
    #[inline(always)]
    fn sub(self, o: Vec4) -> Vec4 {
        Vec4 { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}
