//! Boxes turned along the surface, four side by side.
//!
//! Gottschalk, Lin and Manocha 1996, "OBBTree: a hierarchical structure for rapid interference detection". A patch of
//! a surface is thin across and wide along it. A box along its mean normal is as thin as the patch is curved, so a
//! search sphere that just touches the surface meets few boxes besides the ones it touches; a box along the axes would
//! be as thick as the patch is wide.

use glam::DVec3;
use wide::{f32x4, f64x4};

use crate::sdf::bvh::Frame;
use crate::sdf::closest_point::{TriangleBlock, Vec4};

/// A part is turned along its normal if that much of its area faces it.
const FLAT: f64 = 0.5;
/// What rounding can add to a coordinate, over the coordinates' size and the box's.
const ROUNDING: f64 = 1e-6;

/// Four boxes in the frame of the tree.
#[derive(Clone, Debug)]
pub(crate) struct Boxes {
    centre: [f32x4; 3],
    /// Unit vectors along the edges.
    axes: [[f32x4; 3]; 3],
    /// Half the edges' lengths; minus infinity where there is no box.
    half: [f32x4; 3],
}

impl Boxes {
    /// Squared distances of a point from the boxes, or less by rounding; infinite where there is none.
    #[inline(always)]
    pub fn distances_squared(&self, p: &[f32x4; 3]) -> f32x4 {
        let [x, y, z] = [p[0] - self.centre[0], p[1] - self.centre[1], p[2] - self.centre[2]];
        let mut sum = f32x4::ZERO;
        for (axis, half) in self.axes.iter().zip(self.half) {
            let along = x * axis[0] + y * axis[1] + z * axis[2];
            let outside = (along.abs() - half).fast_max(f32x4::ZERO);
            sum += outside * outside;
        }
        sum
    }
}

/// Boxes around the triangles of up to four ranges of blocks; a range that ends at 0 is none.
pub(crate) fn around(blocks: &[TriangleBlock], ranges: &[(u32, u32); 4], frame: &Frame) -> Boxes {
    let mut boxes = Boxes {
        centre: [f32x4::ZERO; 3],
        axes: [[f32x4::ZERO; 3]; 3],
        half: [f32x4::splat(f32::NEG_INFINITY); 3],
    };
    for (lane, &(first, end)) in ranges.iter().enumerate().filter(|(_, range)| range.1 > 0) {
        let part = &blocks[first as usize..end as usize];
        let axes = axes(part);
        let (lower, upper) = extent(part, &axes, frame);
        let centre: DVec3 = (0..3).map(|i| axes[i] * (0.5 * (lower[i] + upper[i]))).sum();
        for i in 0..3 {
            let size = (upper[i] - lower[i]).max(centre.abs().max_element());
            boxes.centre[i].as_mut_array()[lane] = centre[i] as f32;
            boxes.half[i].as_mut_array()[lane] = (0.5 * (upper[i] - lower[i]) + ROUNDING * size) as f32;
            for (k, axis) in axes.iter().enumerate() {
                boxes.axes[k][i].as_mut_array()[lane] = axis[i] as f32;
            }
        }
    }
    boxes
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
