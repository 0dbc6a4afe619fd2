//! Boxes turned along the surface.
//!
//! Gottschalk, Lin and Manocha 1996, "OBBTree: a hierarchical structure for rapid interference detection". A patch of
//! a surface is thin across and wide along it. A box along its mean normal is as thin as the patch is curved, so a
//! search sphere that just touches the surface meets few boxes besides the ones it touches; a box along the axes would
//! be as thick as the patch is wide.

use glam::DVec3;
use wide::f64x4;

use crate::sdf::closest_point::{TriangleBlock, Vec4};
use crate::sdf::coarse_block::in_frame;
use crate::sdf::frame::Frame;
use crate::sdf::lanes::Lanes;

/// A part is turned along its normal if that much of its area faces it.
const FLAT: f64 = 0.5;
/// What rounding can add to a coordinate, over the coordinates' size and the box's.
const ROUNDING: f64 = 1e-6;

/// A box in the frame of the tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OrientedBox {
    centre: [f32; 3],
    /// Unit vectors along the edges.
    axes: [[f32; 3]; 3],
    /// Half the edges' lengths.
    half: [f32; 3],
}

impl OrientedBox {
    /// No box: infinitely far from everything.
    pub const NONE: OrientedBox =
        OrientedBox { centre: [0.0; 3], axes: [[0.0; 3]; 3], half: [f32::NEG_INFINITY; 3] };

    /// Around the triangles of blocks, of which there is at least one.
    pub fn around(blocks: &[TriangleBlock], frame: &Frame) -> OrientedBox {
        let axes = axes(blocks);
        let (lower, upper) = extent(blocks, &axes, frame);
        let centre: DVec3 = (0..3).map(|i| axes[i] * (0.5 * (lower[i] + upper[i]))).sum();
        let half = [0, 1, 2].map(|i| {
            let size = (upper[i] - lower[i]).max(centre.abs().max_element());
            (0.5 * (upper[i] - lower[i]) + ROUNDING * size) as f32
        });
        OrientedBox {
            centre: centre.as_vec3().to_array(),
            axes: axes.map(|axis| axis.as_vec3().to_array()),
            half,
        }
    }

    /// Squared distances of points, or less by rounding.
    #[inline(always)]
    pub fn distances_squared<V: Lanes>(&self, p: &[V; 3]) -> V {
        let outside = |along: V, half: f32| (along.abs() - V::splat(half)).max(V::splat(0.0));
        let [x, y, z] = in_frame(p, &self.centre, &self.axes);
        let [x, y, z] = [outside(x, self.half[0]), outside(y, self.half[1]), outside(z, self.half[2])];
        z.mul_add(z, y.mul_add(y, x * x))
    }
}

/// Mean normal and two directions across, the first along the axis that is most across; the axes of space where the
/// part faces all ways.
fn axes(blocks: &[TriangleBlock]) -> [DVec3; 3] {
    let mut sum = Vec4::splat(DVec3::ZERO);
    let mut area = f64x4::ZERO;
    for block in blocks {
        let [a, b, c] = *block.corners();
        let normal = (b - a).cross(c - a);
        sum = sum + normal;
        area += normal.dot(normal).sqrt();
    }
    let (sum, area) = (sum.sum_lanes(), area.reduce_add());
    let faces_one_way = sum.length() > FLAT * area;
    if !faces_one_way {
        return DVec3::AXES;
    }
    let normal = sum.normalize();
    let across = DVec3::AXES[normal.abs().min_position()];
    let first = (across - normal * normal.dot(across)).normalize();
    [normal, first, normal.cross(first)]
}

/// Lowest and highest coordinates along the axes, in the frame of the tree.
fn extent(blocks: &[TriangleBlock], axes: &[DVec3; 3], frame: &Frame) -> ([f64; 3], [f64; 3]) {
    let mut lower = [f64x4::splat(f64::INFINITY); 3];
    let mut upper = [f64x4::splat(f64::NEG_INFINITY); 3];
    let centre = Vec4::splat(frame.centre);
    let axes = axes.map(|axis| Vec4::splat(axis * frame.scale));
    for corner in blocks.iter().flat_map(TriangleBlock::corners) {
        let local = *corner - centre;
        for (i, axis) in axes.iter().enumerate() {
            let along = local.dot(*axis);
            lower[i] = lower[i].fast_min(along);
            upper[i] = upper[i].fast_max(along);
        }
    }
    let lowest = |x: f64x4| x.to_array().into_iter().fold(f64::INFINITY, f64::min);
    let highest = |x: f64x4| x.to_array().into_iter().fold(f64::NEG_INFINITY, f64::max);
    (lower.map(lowest), upper.map(highest))
}
