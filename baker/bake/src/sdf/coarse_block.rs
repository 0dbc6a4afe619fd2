//! Distances to triangles in single precision, with a bound on their error.
//!
//! Most leaves that a search reaches hold nothing closer. Single precision tells so in a fraction of
//! the time, and only what it can't rule out in the end is looked at in double precision.
//!
//! Each triangle has a frame of its own: corner A at the origin, B on the first axis, C in the plane of the first two
//! (Jones 1995, "3D distance from a point to a triangle"). So what remains is a problem in the plane, and all
//! divisions are done in advance.

use glam::DVec3;

use crate::sdf::closest_point::TriangleBlock;
use crate::sdf::frame::Frame;
use crate::sdf::lanes::Lanes;

/// Triangles whose height is less than this part of their longest edge are taken as their edges.
const SLIVER: f64 = 0.03;
/// Errors of the distance, over the longest edge and over the distance, for unit roundoff u = 6e-8. A point's place in
/// the plane is wrong by some 6 u (D + L), with D its distance and L the longest edge. Where edges meet at an angle of
/// at least [`SLIVER`], a point beyond the corner is taken to be inside no further than 2 / SLIVER times that off it:
/// 3e-5 L where D is small, and where it is large, that much across makes no difference.
const EDGE_ERROR: f64 = 3e-5;
const DISTANCE_ERROR: f32 = 2e-6;
/// Corners are rounded by half a unit in the last place of 1.
const CORNER_ERROR: f64 = 2e-7;

/// A triangle in the frame of the tree.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct CoarseTriangle {
    origin: [f32; 3],
    axes: [[f32; 3]; 3],
    /// B on the first axis.
    b: f32,
    /// C in the plane.
    c: [f32; 2],
    /// One over the squared lengths of BC and AC, 0 for none.
    inverse_bc: f32,
    inverse_ac: f32,
    /// A face is where the second coordinate is at least this: 0, or infinity for a sliver.
    face_from: f32,
}

/// Up to four triangles.
#[derive(Clone, Debug)]
pub(crate) struct CoarseBlock {
    triangles: [CoarseTriangle; 4],
    count: u32,
    /// Bound on the error, other than relative.
    margin: f32,
}

impl CoarseBlock {
    /// The first `count` triangles of a block.
    pub fn new(block: &TriangleBlock, count: usize, frame: &Frame) -> CoarseBlock {
        let mut out = CoarseBlock { triangles: Default::default(), count: count as u32, margin: 0.0 };
        for lane in 0..count {
            let corners = block.triangle(lane).map(|corner| (corner - frame.centre) * frame.scale);
            let (triangle, margin) = coarse_triangle(corners);
            out.triangles[lane] = triangle;
            out.margin = out.margin.max(margin);
        }
        out
    }

    #[inline(always)]
    pub fn triangles(&self) -> &[CoarseTriangle] {
        &self.triangles[..self.count as usize]
    }

    /// Bounds, lower and upper, on distances that were computed of its triangles.
    #[inline(always)]
    pub fn bounds<V: Lanes>(&self, distance: V) -> [V; 2] {
        let error = distance.mul_add(V::splat(DISTANCE_ERROR), V::splat(self.margin));
        [distance - error, distance + error]
    }

    /// Squares of the largest distances that may be computed of a triangle within `radius`.
    #[inline(always)]
    pub fn reach_squared<V: Lanes>(&self, radius: V) -> V {
        let reach = radius.mul_add(V::splat(1.0 + 2.0 * DISTANCE_ERROR), V::splat(self.margin));
        reach * reach
    }
}

/// The triangle in its own frame, and a bound on the error of its distances, other than relative.
fn coarse_triangle([a, b, c]: [DVec3; 3]) -> (CoarseTriangle, f32) {
    let (ab, ac, bc) = (b - a, c - a, c - b);
    let first = ab.try_normalize().or(ac.try_normalize()).unwrap_or(DVec3::X);
    let across = ac - first * ac.dot(first);
    // What remains of three corners in a row is rounding, and may point anywhere.
    let second = match across.length() > 1e-6 * ac.length() {
        true => (across - first * across.dot(first)).normalize(),
        false => first.any_orthonormal_vector(),
    };
    let longest = ab.length().max(ac.length()).max(bc.length());
    let height = ab.cross(ac).length() / longest.max(f64::MIN_POSITIVE);
    let is_sliver = height <= SLIVER * longest;
    let inverse = |squared: f64| if squared > 1e-30 { (1.0 / squared) as f32 } else { 0.0 };
    let triangle = CoarseTriangle {
        origin: a.as_vec3().to_array(),
        axes: [first, second, first.cross(second)].map(|axis| axis.as_vec3().to_array()),
        b: ab.dot(first) as f32,
        c: [ac.dot(first) as f32, ac.dot(second) as f32],
        inverse_bc: inverse(bc.length_squared()),
        inverse_ac: inverse(ac.length_squared()),
        face_from: if is_sliver { f32::INFINITY } else { 0.0 },
    };
    let margin = EDGE_ERROR * longest + CORNER_ERROR + if is_sliver { height } else { 0.0 };
    (triangle, margin as f32)
}

impl CoarseTriangle {
    /// Squared distances of points.
    #[inline(always)]
    pub fn distances_squared<V: Lanes>(&self, p: &[V; 3]) -> V {
        let (zero, one) = (V::splat(0.0), V::splat(1.0));
        let [x, y, z] = in_frame(p, &self.origin, &self.axes);
        let (b, cx, cy) = (V::splat(self.b), V::splat(self.c[0]), V::splat(self.c[1]));
        // From A, B and A again to the edges AB, BC and AC.
        let ab = x - x.max(zero).min(b);
        let (qx, ex) = (x - b, cx - b);
        let t = (y.mul_add(cy, qx * ex) * V::splat(self.inverse_bc)).max(zero).min(one);
        let bc = [qx - ex * t, y - cy * t];
        let t = (y.mul_add(cy, x * cx) * V::splat(self.inverse_ac)).max(zero).min(one);
        let ac = [x - cx * t, y - cy * t];
        let squared = |x: V, y: V| x.mul_add(x, y * y);
        let edges = squared(ab, y).min(squared(bc[0], bc[1])).min(squared(ac[0], ac[1]));
        // Beyond AB, BC or AC where positive.
        let beyond = (V::splat(self.face_from) - y).max(cy * qx - ex * y).max(cx * y - cy * x);
        z.mul_add(z, edges.where_positive(beyond))
    }
}

/// Coordinates from an origin along axes.
#[inline(always)]
pub(crate) fn in_frame<V: Lanes>(p: &[V; 3], origin: &[f32; 3], axes: &[[f32; 3]; 3]) -> [V; 3] {
    let [x, y, z] = [p[0] - V::splat(origin[0]), p[1] - V::splat(origin[1]), p[2] - V::splat(origin[2])];
    let along =
        |axis: &[f32; 3]| z.mul_add(V::splat(axis[2]), y.mul_add(V::splat(axis[1]), x * V::splat(axis[0])));
    [along(&axes[0]), along(&axes[1]), along(&axes[2])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sdf::closest_point::closest_point_on_triangle;
    use proptest::prelude::*;
    use wide::f32x8;

    fn point(size: f64) -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-size..size).prop_map(DVec3::from)
    }

    /// Triangles of all shapes: any, and needles of four kinds, three corners in a row and points among them.
    fn triangle() -> impl Strategy<Value = [DVec3; 3]> {
        (prop::array::uniform3(point(0.5)), 0usize..6, -7.0..0.0f64, 0usize..3).prop_map(
            |(t, kind, power, turn)| {
                let [a, b, c] = t;
                let small = (c - a) * 10f64.powf(power);
                let mut shape = match kind {
                    0 => [a, b, c],
                    1 => [a, a + small, b],
                    2 => [a, b, a * 0.4 + b * 0.6 + small],
                    3 => [a, a + small, a + (b - a) * 10f64.powf(power)],
                    4 => [a, b, a + (b - a) * 2.0],
                    _ => [a, a, a],
                };
                shape.rotate_left(turn);
                shape
            },
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2_000))]

        #[test]
        fn distance_is_within_its_bounds(t in prop::array::uniform4(triangle()), p in point(1.0), near in 0u32..3) {
            // Half of the points lie beside a triangle, where a wrong feature shows most.
            let beside = t[0][0] + (t[0][1] - t[0][0]) * p.x * 1.2 + p * 10f64.powi(-(3 * near as i32));
            let p = if near == 0 { p } else { beside };
            let frame = Frame { centre: DVec3::ZERO, scale: 1.0 };
            let block = CoarseBlock::new(&TriangleBlock::new(&t), 4, &frame);
            let local = frame.local(p).map(f32x8::splat);
            let squared = block.triangles().iter().map(|triangle| triangle.distances_squared(&local));
            let nearest = squared.fold(f32x8::splat(f32::INFINITY), f32x8::fast_min);
            let [lower, upper] = block.bounds(Lanes::sqrt(nearest)).map(|bound| bound.to_array()[0]);
            let exact = t.iter().map(|t| closest_point_on_triangle(p, t).distance_squared.sqrt());
            let exact = exact.fold(f64::INFINITY, f64::min);
            // The point itself is rounded too.
            prop_assert!(f64::from(lower) <= exact + 2e-7, "{} {}", lower, exact);
            prop_assert!(f64::from(upper) >= exact - 2e-7, "{} {}", upper, exact);
            prop_assert!(f64::from(upper - lower) < 0.12, "{} {}", lower, upper);
        }
    }
}
