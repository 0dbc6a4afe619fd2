//! Distances to four triangles in single precision, with a bound on their error.
//!
//! Most leaves that a search reaches hold nothing closer. Single precision tells so in less than half
//! the time, and only what it can't rule out is looked at in double precision.

use wide::f32x4;

use crate::sdf::bvh::Frame;
use crate::sdf::closest_point::TriangleBlock;

/// Error of the distance over the longest edge, and over the distance. As in `closest_point`, every
/// candidate is a point of the triangle, so an error e along the triangle lengthens a distance d to
/// sqrt(d^2 + e^2). With unit roundoff u, longest edge L, height h and distance D the projection's
/// weights give e = u (D + L)^2 / h; but the edges are never further off than h, so
/// e < sqrt(u) (D + L) = 2.5e-4 (D + L), which is u D / 2 on the distance where D is larger than L.
const EDGE_ERROR: f32 = 1e-3;
const DISTANCE_ERROR: f32 = 2e-6;

/// Four triangles in the frame of the tree.
#[derive(Clone, Debug)]
pub(crate) struct CoarseBlock {
    corners: [[f32x4; 3]; 3],
    /// What the longest edge adds to the error.
    margin: f32,
}

impl CoarseBlock {
    pub fn new(block: &TriangleBlock, frame: &Frame) -> CoarseBlock {
        let mut corners = [[f32x4::ZERO; 3]; 3];
        let mut longest: f64 = 0.0;
        for lane in 0..4 {
            let triangle = block.corners().map(|corner| corner.lane(lane));
            for (k, &corner) in triangle.iter().enumerate() {
                for (axis, x) in frame.local(corner).into_iter().enumerate() {
                    corners[k][axis].as_mut_array()[lane] = x;
                }
                longest = longest.max(corner.distance(triangle[(k + 1) % 3]) * frame.scale);
            }
        }
        // Corners are rounded by half a unit in the last place of 1.
        let margin = (longest as f32) * EDGE_ERROR + 2e-7;
        CoarseBlock { corners, margin }
    }

    /// True where one of the triangles may be within `radius` of `p`.
    #[inline]
    pub fn may_reach(&self, p: &[f32x4; 3], radius: f32) -> bool {
        let reach = radius * (1.0 + DISTANCE_ERROR) + self.margin;
        let distances = self.distances_squared(p);
        distances.simd_le(f32x4::splat(reach * reach)).any()
    }

    /// `TriangleBlock::distances_squared` in single precision.
    #[inline(always)]
    fn distances_squared(&self, p: &[f32x4; 3]) -> f32x4 {
        let [a, b, c] = [0, 1, 2].map(|k| subtract(self.corners[k], *p));
        let (ab, bc, ca) = (subtract(b, a), subtract(c, b), subtract(a, c));
        let edges = edge_distance_squared(a, b, ab)
            .fast_min(edge_distance_squared(b, c, bc))
            .fast_min(edge_distance_squared(c, a, ca));
        let normal = cross(ca, ab);
        let weights = [dot(normal, cross(b, c)), dot(normal, cross(c, a)), dot(normal, cross(a, b))];
        let sum = weights[0] + weights[1] + weights[2];
        let inside = weights[0].fast_min(weights[1]).fast_min(weights[2]);
        let factor = f32x4::ONE / sum.fast_max(f32x4::splat(f32::MIN_POSITIVE));
        let offset: [f32x4; 3] =
            std::array::from_fn(|i| (a[i] * weights[0] + b[i] * weights[1] + c[i] * weights[2]) * factor);
        let is_face = inside.simd_ge(f32x4::ZERO) & sum.simd_gt(f32x4::ZERO);
        is_face.select(dot(offset, offset), edges).fast_min(edges)
    }
}

#[inline(always)]
fn edge_distance_squared(a: [f32x4; 3], b: [f32x4; 3], along: [f32x4; 3]) -> f32x4 {
    let length_squared = dot(along, along).fast_max(f32x4::splat(f32::MIN_POSITIVE));
    let t = (-dot(a, along) / length_squared).fast_max(f32x4::ZERO);
    let offset: [f32x4; 3] = std::array::from_fn(|i| a[i] + along[i] * t);
    t.simd_ge(f32x4::ONE).select(dot(b, b), dot(offset, offset))
}

#[inline(always)]
fn subtract(a: [f32x4; 3], b: [f32x4; 3]) -> [f32x4; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot(a: [f32x4; 3], b: [f32x4; 3]) -> f32x4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: [f32x4; 3], b: [f32x4; 3]) -> [f32x4; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
