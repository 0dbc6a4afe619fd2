//! Boxes and planes of triangles in single precision, in the tree's frame, with bounds on their errors: what they rule
//! out doesn't meet.

use wide::f32x4;

use crate::sdf::bvh::{Bvh, LEAF};
use crate::sdf::closest_point::{TriangleBlock, Vec4};

/// Error of a plane's distance in single precision, where the mesh has about unit size: three products of numbers up
/// to 1, each rounded, and rounded corners.
const PLANE_ERROR: f32 = 2e-6;

/// A box.
pub struct Bounds {
    lower: [f32; 3],
    upper: [f32; 3],
}

/// Boxes of the four parts below a node.
#[derive(Clone, Copy)]
pub struct Boxes {
    lower: [f32x4; 3],
    upper: [f32x4; 3],
}

/// Up to four triangles.
pub struct CoarseLeaf {
    /// Their number.
    pub count: usize,
    /// The box of all.
    pub bounds: Bounds,
    /// The box of each, side by side.
    boxes: Boxes,
    corners: [[f32x4; 3]; 3],
    /// Unit normals, 0 for triangles without area, and the planes' distances from the origin.
    normals: [f32x4; 3],
    offsets: f32x4,
    /// Points no farther than this may be on the plane.
    margin: f32,
}

impl CoarseLeaf {
    /// Of a block of the tree.
    pub fn new(block: &TriangleBlock, index: usize, bvh: &Bvh, tolerance: f64) -> CoarseLeaf {
        let count = bvh.leaves.coarse[index].triangles().len();
        let local = |v: Vec4| {
            let (centre, scale) = (Vec4::splat(bvh.frame.centre), wide::f64x4::splat(bvh.frame.scale));
            (v - centre).scale(scale)
        };
        let [a, b, c] = block.corners().map(local);
        let area = (b - a).cross(c - a);
        let length = area.dot(area).sqrt();
        let inverse = length.simd_gt(wide::f64x4::ZERO).select(wide::f64x4::ONE / length, wide::f64x4::ZERO);
        let normal = area.scale(inverse);
        let corners = [a, b, c].map(single);
        let boxes = Boxes::around(&corners);
        let (normals, offsets) = (single(normal), lanes(normal.dot(a)));
        let margin = PLANE_ERROR + (tolerance * bvh.frame.scale) as f32;
        CoarseLeaf { count, bounds: boxes.joined(), boxes, corners, normals, offsets, margin }
    }

    /// Which triangles' boxes meet that of another leaf.
    #[inline]
    pub fn meeting(&self, other: &CoarseLeaf) -> u32 {
        self.boxes.meeting(&other.bounds) & ((1 << self.count) - 1)
    }

    /// Which triangles of another leaf may meet a triangle of this one, whose box meets that leaf's: boxes overlap, and
    /// neither lies strictly on one side of the other's plane, but for an edge that lies in it.
    #[inline]
    pub fn near(&self, lane: usize, other: &CoarseLeaf) -> u32 {
        let near = other.boxes.meeting(&self.boxes.at(lane)) & ((1 << other.count) - 1);
        if near == 0 {
            return 0;
        }
        let margin = f32x4::splat(self.margin);
        let of_this = |v: &f32x4| f32x4::splat(v.as_array()[lane]);
        let (normal, offset) = (self.normals.each_ref().map(of_this), of_this(&self.offsets));
        let distances = other.corners.map(|corner| dot(normal, corner) - offset);
        let near = near & across(distances, margin).to_bitmask();
        if near == 0 {
            return 0;
        }
        let corners = self.corners.each_ref().map(|corner| corner.each_ref().map(of_this));
        near & across(corners.map(|corner| dot(other.normals, corner) - other.offsets), margin).to_bitmask()
    }
}

/// Not strictly on one side; two corners on the plane may make an edge that lies in it.
#[inline]
fn across([a, b, c]: [f32x4; 3], margin: f32x4) -> f32x4 {
    let (low, high) = (a.fast_min(b).fast_min(c), a.fast_max(b).fast_max(c));
    let middle = a + b + c - low - high;
    let both_sides = low.simd_le(margin) & high.simd_ge(-margin);
    // All but one corner strictly on one side: only a corner touches.
    let touches = (low.simd_ge(-margin) & middle.simd_gt(margin + margin))
        | (high.simd_le(margin) & middle.simd_lt(-margin - margin));
    both_sides & !touches
}

fn dot(a: [f32x4; 3], b: [f32x4; 3]) -> f32x4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn lanes(x: wide::f64x4) -> f32x4 {
    f32x4::new(x.to_array().map(|x| x as f32))
}

fn single(v: Vec4) -> [f32x4; 3] {
    [lanes(v.x), lanes(v.y), lanes(v.z)]
}

impl Boxes {
    const NONE: Boxes =
        Boxes { lower: [f32x4::splat(f32::INFINITY); 3], upper: [f32x4::splat(f32::NEG_INFINITY); 3] };

    /// Rounded outwards by more than the corners' rounding.
    fn around([a, b, c]: &[[f32x4; 3]; 3]) -> Boxes {
        let margin = f32x4::splat(f32::EPSILON);
        Boxes {
            lower: [0, 1, 2].map(|axis| a[axis].fast_min(b[axis]).fast_min(c[axis]) - margin),
            upper: [0, 1, 2].map(|axis| a[axis].fast_max(b[axis]).fast_max(c[axis]) + margin),
        }
    }

    /// One of them.
    #[inline]
    fn at(&self, slot: usize) -> Bounds {
        let at = |v: f32x4| v.as_array()[slot];
        Bounds { lower: self.lower.map(at), upper: self.upper.map(at) }
    }

    /// Which of the boxes meet another.
    #[inline]
    pub fn meeting(&self, other: &Bounds) -> u32 {
        let on = |axis: usize| {
            let below = self.lower[axis].simd_le(f32x4::splat(other.upper[axis]));
            below & self.upper[axis].simd_ge(f32x4::splat(other.lower[axis]))
        };
        (on(0) & on(1) & on(2)).to_bitmask()
    }

    fn set(&mut self, slot: usize, bounds: &Bounds) {
        for axis in 0..3 {
            self.lower[axis].as_mut_array()[slot] = bounds.lower[axis];
            self.upper[axis].as_mut_array()[slot] = bounds.upper[axis];
        }
    }

    fn joined(&self) -> Bounds {
        Bounds {
            lower: self.lower.map(|x| x.to_array().into_iter().fold(f32::INFINITY, f32::min)),
            upper: self.upper.map(|x| x.to_array().into_iter().fold(f32::NEG_INFINITY, f32::max)),
        }
    }
}

/// Boxes of all nodes, from the leaves up; children come after their nodes.
pub fn boxes_of_nodes(bvh: &Bvh, leaves: &[CoarseLeaf]) -> Vec<Boxes> {
    let mut boxes = vec![Boxes::NONE; bvh.nodes.len()];
    for node in (0..bvh.nodes.len()).rev() {
        for slot in (0..4).filter(|&slot| bvh.ranges[node][slot].1 > 0) {
            let child = bvh.nodes[node].children[slot].child;
            match child & LEAF != 0 {
                true => boxes[node].set(slot, &leaves[(child & !LEAF) as usize].bounds),
                false => {
                    let joined = boxes[child as usize].joined();
                    boxes[node].set(slot, &joined);
                }
            }
        }
    }
    boxes
}
