//! Distances to four triangles in single precision, with a bound on their error.
//!
//! Most leaves that a search reaches hold nothing closer. Single precision tells so in a fraction of
//! the time, and only what it can't rule out in the end is looked at in double precision.
//!
//! Each triangle has a frame of its own: corner A at the origin, B on the first axis, C in the plane of the first two
//! (Jones 1995, "3D distance from a point to a triangle"). So what remains is a problem in the plane, and all
//! divisions are done in advance.

use glam::DVec3;
use wide::f32x4;

use crate::sdf::bvh::Frame;
use crate::sdf::closest_point::TriangleBlock;

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

/// Four triangles in the frame of the tree.
#[derive(Clone, Debug)]
pub(crate) struct CoarseBlock {
    origin: [f32x4; 3],
    axes: [[f32x4; 3]; 3],
    /// B on the first axis.
    b: f32x4,
    /// C in the plane.
    c: [f32x4; 2],
    /// One over the squared lengths of BC and AC, 0 for none.
    inverse_bc: f32x4,
    inverse_ac: f32x4,
    /// A face is where the second coordinate is at least this: 0, or infinity for a sliver.
    face_from: f32x4,
    /// Bound on the error, other than relative.
    margin: f32,
}

impl CoarseBlock {
    pub fn new(block: &TriangleBlock, frame: &Frame) -> CoarseBlock {
        let zero = f32x4::ZERO;
        let mut out = CoarseBlock {
            origin: [zero; 3],
            axes: [[zero; 3]; 3],
            b: zero,
            c: [zero; 2],
            inverse_bc: zero,
            inverse_ac: zero,
            face_from: zero,
            margin: 0.0,
        };
        for lane in 0..4 {
            let corners = block.corners().map(|corner| (corner.lane(lane) - frame.centre) * frame.scale);
            out.set_lane(lane, corners);
        }
        out
    }

    fn set_lane(&mut self, lane: usize, [a, b, c]: [DVec3; 3]) {
        let (ab, ac, bc) = (b - a, c - a, c - b);
        let first = ab.try_normalize().or(ac.try_normalize()).unwrap_or(DVec3::X);
        let across = ac - first * ac.dot(first);
        // What remains of three corners in a row is rounding, and may point anywhere.
        let second = match across.length() > 1e-6 * ac.length() {
            true => (across - first * across.dot(first)).normalize(),
            false => first.any_orthonormal_vector(),
        };
        let axes = [first, second, first.cross(second)];
        let longest = ab.length().max(ac.length()).max(bc.length());
        let height = ab.cross(ac).length() / longest.max(f64::MIN_POSITIVE);
        let is_sliver = height <= SLIVER * longest;
        let set = |to: &mut f32x4, value: f64| to.as_mut_array()[lane] = value as f32;
        for i in 0..3 {
            set(&mut self.origin[i], a[i]);
            for (axis, direction) in self.axes.iter_mut().zip(axes) {
                set(&mut axis[i], direction[i]);
            }
        }
        let inverse = |length_squared: f64| if length_squared > 1e-30 { 1.0 / length_squared } else { 0.0 };
        set(&mut self.b, ab.dot(first));
        set(&mut self.c[0], ac.dot(first));
        set(&mut self.c[1], ac.dot(second));
        set(&mut self.inverse_bc, inverse(bc.length_squared()));
        set(&mut self.inverse_ac, inverse(ac.length_squared()));
        set(&mut self.face_from, if is_sliver { f64::INFINITY } else { 0.0 });
        let margin = EDGE_ERROR * longest + CORNER_ERROR + if is_sliver { height } else { 0.0 };
        self.margin = self.margin.max(margin as f32);
    }

    /// Bounds on the distance of the closest triangle, lower and upper.
    #[inline(always)]
    pub fn distance(&self, p: &[f32x4; 3]) -> (f32, f32) {
        let [a, b, c, d] = self.distances_squared(p).to_array();
        let distance = min(min(a, b), min(c, d)).sqrt();
        let error = distance * DISTANCE_ERROR + self.margin;
        (distance - error, distance + error)
    }

    /// Bits of the triangles that may be within `radius`.
    #[inline(always)]
    pub fn within(&self, p: &[f32x4; 3], radius: f32) -> u32 {
        let reach = radius * (1.0 + 2.0 * DISTANCE_ERROR) + self.margin;
        self.distances_squared(p).simd_le(f32x4::splat(reach * reach)).to_bitmask()
    }

    #[inline(always)]
    fn distances_squared(&self, p: &[f32x4; 3]) -> f32x4 {
        let offset: [f32x4; 3] = [p[0] - self.origin[0], p[1] - self.origin[1], p[2] - self.origin[2]];
        let along = |axis: &[f32x4; 3]| offset[0] * axis[0] + offset[1] * axis[1] + offset[2] * axis[2];
        let [x, y, z] = [along(&self.axes[0]), along(&self.axes[1]), along(&self.axes[2])];
        let [cx, cy] = self.c;
        // From A, B and A again to the edges AB, BC and AC.
        let ab = x - x.fast_max(f32x4::ZERO).fast_min(self.b);
        let (qx, ex) = (x - self.b, cx - self.b);
        let t = clamp_unit((qx * ex + y * cy) * self.inverse_bc);
        let bc = [qx - ex * t, y - cy * t];
        let t = clamp_unit((x * cx + y * cy) * self.inverse_ac);
        let ac = [x - cx * t, y - cy * t];
        let edges =
            (ab * ab + y * y).fast_min(bc[0] * bc[0] + bc[1] * bc[1]).fast_min(ac[0] * ac[0] + ac[1] * ac[1]);
        let left_of_bc = (ex * y - cy * qx).simd_ge(f32x4::ZERO);
        let right_of_ac = (cx * y - cy * x).simd_le(f32x4::ZERO);
        let face = y.simd_ge(self.face_from) & left_of_bc & right_of_ac;
        face.select(f32x4::ZERO, edges) + z * z
    }
}

#[inline(always)]
fn clamp_unit(t: f32x4) -> f32x4 {
    t.fast_max(f32x4::ZERO).fast_min(f32x4::ONE)
}

#[inline(always)]
fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sdf::closest_point::closest_point_on_triangle;
    use proptest::prelude::*;

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
            let p = if near == 0 { p } else { t[0][0] + (t[0][1] - t[0][0]) * p.x * 1.2 + p * 10f64.powi(-(3 * near as i32)) };
            let frame = Frame { centre: DVec3::ZERO, scale: 1.0 };
            let block = CoarseBlock::new(&TriangleBlock::new(&t), &frame);
            let (lower, upper) = block.distance(&frame.local(p).map(f32x4::splat));
            let exact = t.iter().map(|t| closest_point_on_triangle(p, t).distance_squared.sqrt());
            let exact = exact.fold(f64::INFINITY, f64::min);
            // The point itself is rounded too.
            prop_assert!(f64::from(lower) <= exact + 2e-7, "{} {}", lower, exact);
            prop_assert!(f64::from(upper) >= exact - 2e-7, "{} {}", upper, exact);
            prop_assert!(f64::from(upper - lower) < 0.12, "{} {}", lower, upper);
        }
    }
}
