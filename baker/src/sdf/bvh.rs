//! Bounding volume hierarchy over triangles, for the closest triangle.
//!
//! Four children a node, their boxes side by side in single precision, so that one node is four cache
//! lines and one SIMD test (Dammertz, Hanika and Keller 2008, "Shallow bounding volume hierarchies for
//! fast SIMD ray tracing of incoherent rays"); the boxes are turned along the surface (`oriented_box`); four triangles a
//! leaf, side by side in double precision. Boxes are enlarged and the search radius is rounded up by more than they
//! can err, so that single precision costs a few visits, never a wrong answer.

use glam::DVec3;
use wide::f32x4;

use crate::sdf::bvh_build;
use crate::sdf::closest_point::{Closest, Feature, TriangleBlock, TrianglePoint, closest_point_on_triangle};
use crate::sdf::coarse_block::CoarseBlock;
use crate::sdf::oriented_box::Boxes;

/// Marks a child that is a leaf; the other bits are the index of its block.
pub(crate) const LEAF: u32 = 1 << 31;
/// Levels of nodes at most, which `bvh_build` guarantees.
pub(crate) const MAX_DEPTH: usize = 40;
/// Beyond this distance, in sizes of the mesh, boxes in single precision tell nothing any more.
const FAR: f32 = 1e12;

/// Four children: their boxes, and where they are.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct Node {
    pub boxes: Boxes,
    /// Index of a node, or of a block with `LEAF`, or `NO_CHILD`.
    pub child: [u32; 4],
}

/// The tree. Its frame is centred on the mesh and scaled to about unit size.
#[derive(Clone, Debug)]
pub struct Bvh {
    pub(crate) nodes: Vec<Node>,
    pub(crate) blocks: Vec<TriangleBlock>,
    /// The same in single precision.
    pub(crate) coarse: Vec<CoarseBlock>,
    /// Index in the mesh of each block's triangles.
    pub(crate) ids: Vec<[u32; 4]>,
    /// For each node and child, the blocks below it, first and past the last; both 0 where there is no child.
    pub(crate) ranges: Vec<[(u32, u32); 4]>,
    pub(crate) frame: Frame,
}

const NOTHING: u32 = u32::MAX;
const NOTHING_FOUND: Closest =
    Closest { distance_squared: f64::INFINITY, point: DVec3::NAN, triangle: NOTHING, feature: Feature::Face };
/// Leaves that are kept open at a time.
const MAX_OPEN: usize = 16;

/// Leaves that may hold the closest triangle: lower bounds of their distances, and their blocks.
struct OpenLeaves {
    leaves: [(f32, u32); MAX_OPEN],
    count: usize,
}

impl Bvh {
    /// Builds the tree over triangles of finite coordinates, of which there must be at least one.
    pub fn new(triangles: &[[DVec3; 3]]) -> Bvh {
        bvh_build::build(triangles)
    }

    /// Point closest to `p`. `upper_bound` is a distance that is known not to be exceeded, such as
    /// a neighbour's distance plus the way from it, or infinity; one that is too small costs time only.
    pub fn closest(&self, p: DVec3, upper_bound: f64) -> Closest {
        let local = self.frame.local(p);
        let far = local.iter().any(|x| x.is_nan() || x.abs() > FAR);
        if far {
            return self.closest_of_all(p);
        }
        let found = self.search(p, local, upper_bound * upper_bound * (1.0 + 1e-9));
        if found.triangle != NOTHING {
            return found;
        }
        let found = self.search(p, local, f64::INFINITY);
        match found.triangle {
            NOTHING => self.closest_of_all(p),
            _ => found,
        }
    }

    /// The closest triangle within the bound, if there is one: nearest boxes first, in single precision; then the
    /// leaves that it leaves open, in double precision.
    #[inline(always)]
    fn search(&self, p: DVec3, local: [f32; 3], bound_squared: f64) -> Closest {
        let mut best = Closest { distance_squared: bound_squared, ..NOTHING_FOUND };
        let mut open = OpenLeaves { leaves: [(0.0, 0); MAX_OPEN], count: 0 };
        let mut radius = self.frame.radius(bound_squared, Frame::slack(local));
        let slack = Frame::slack(local) as f32;
        let local = local.map(f32x4::splat);
        // Squared distance to the box in the upper half (floats of one sign order like integers), the
        // child in the lower: one comparison sorts both, the same way on every machine.
        let mut stack = [0u64; 3 * MAX_DEPTH + 4];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let entry = stack[top];
            if f32::from_bits((entry >> 32) as u32) > radius * radius {
                continue;
            }
            let child = entry as u32;
            if child & LEAF != 0 {
                let block = child & !LEAF;
                let (lower, upper) = self.coarse[block as usize].distance(&local);
                if lower <= radius {
                    radius = if upper + slack < radius { upper + slack } else { radius };
                    if open.count == MAX_OPEN {
                        self.close(&mut open, (p, &local), radius, &mut best);
                    }
                    open.leaves[open.count] = (lower, block);
                    open.count += 1;
                }
                continue;
            }
            let node = &self.nodes[child as usize];
            let distance = node.boxes.distances_squared(&local);
            let keys = sorted_keys(distance.to_array(), node.child);
            let near = distance.simd_le(f32x4::splat(radius * radius)).to_bitmask().count_ones() as usize;
            for key in keys[..near].iter().rev() {
                stack[top] = *key;
                top += 1;
            }
        }
        self.close(&mut open, (p, &local), radius, &mut best);
        best
    }

    /// Looks at the triangles of the open leaves that may be within the radius, in double precision.
    fn close(&self, open: &mut OpenLeaves, p: (DVec3, &[f32x4; 3]), radius: f32, best: &mut Closest) {
        for &(_, block) in open.leaves[..open.count].iter().filter(|leaf| leaf.0 <= radius) {
            let mut lanes = self.coarse[block as usize].within(p.1, radius);
            while lanes != 0 {
                self.visit(block as usize, lanes.trailing_zeros() as usize, p.0, best);
                lanes &= lanes - 1;
            }
        }
        open.count = 0;
    }

    /// Takes the point of a triangle if none before was closer.
    #[inline]
    fn visit(&self, block: usize, lane: usize, p: DVec3, best: &mut Closest) {
        let corners = self.blocks[block].corners().map(|corner| corner.lane(lane));
        let triangle = self.ids[block][lane];
        let TrianglePoint { distance_squared, point, feature } = closest_point_on_triangle(p, &corners);
        let closer = distance_squared < best.distance_squared;
        if closer || distance_squared == best.distance_squared && triangle < best.triangle {
            *best = Closest { distance_squared, point, triangle, feature };
        }
    }

    /// For points so far away that the tree cannot help, or that are not numbers.
    fn closest_of_all(&self, p: DVec3) -> Closest {
        let mut best = NOTHING_FOUND;
        for block in 0..self.blocks.len() {
            (0..4).for_each(|lane| self.visit(block, lane, p, &mut best));
        }
        if best.triangle == NOTHING {
            // Nothing is closer than infinity.
            let corners = self.blocks[0].corners().map(|corner| corner.lane(0));
            let TrianglePoint { distance_squared, point, feature } = closest_point_on_triangle(p, &corners);
            best = Closest { distance_squared, point, triangle: self.ids[0][0], feature };
        }
        best
    }
}

/// Keys of the four children, nearest first, by a sorting network.
#[inline(always)]
fn sorted_keys(distance: [f32; 4], child: [u32; 4]) -> [u64; 4] {
    let key = |i: usize| u64::from(distance[i].to_bits()) << 32 | u64::from(child[i]);
    let [a, b, c, d] = [key(0), key(1), key(2), key(3)];
    let (a, b) = (a.min(b), a.max(b));
    let (c, d) = (c.min(d), c.max(d));
    let (a, c) = (a.min(c), a.max(c));
    let (b, d) = (b.min(d), b.max(d));
    [a, b.min(c), b.max(c), d]
}

/// The tree's frame: a point x of the mesh is at (x - centre) * scale.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub centre: DVec3,
    /// A power of two, so that scaling is exact.
    pub scale: f64,
}

impl Frame {
    pub fn local(&self, p: DVec3) -> [f32; 3] {
        ((p - self.centre) * self.scale).to_array().map(|x| x as f32)
    }

    /// By how much a distance in the frame can be too long in single precision, other than relatively:
    /// the query point is rounded by half a unit in its last place.
    fn slack(local: [f32; 3]) -> f64 {
        let size = local[0].abs().max(local[1].abs()).max(local[2].abs());
        2e-7 * f64::from(size) + 1e-15
    }

    /// Search radius in the frame, rounded up by more than a box test can err. Its square is finite, so
    /// that an empty box, at infinity, is beyond it.
    #[inline]
    fn radius(&self, distance_squared: f64, slack: f64) -> f32 {
        let radius = (distance_squared.sqrt() * self.scale + slack) * (1.0 + 1e-6);
        (radius as f32).min(1.8e19)
    }
}
