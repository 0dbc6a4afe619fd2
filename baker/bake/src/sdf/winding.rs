//! Generalised winding number: how often the surface winds around a point.
//!
//! Jacobson, Kavan and Sorkine-Hornung 2013, "Robust inside-outside segmentation using generalized
//! winding numbers": the sum of the triangles' signed solid angles over 4 pi. It is 1 inside and 0
//! outside a closed surface, and degrades gently where there are holes, overlaps and flipped faces.
//! One triangle's angle is Eq. 8 of Van Oosterom and Strackee 1983, "The solid angle of a plane
//! triangle". The fast sum is Barill et al. 2018, "Fast winding numbers for soups and clouds": far
//! parts of the tree are replaced by their Taylor expansion, here of order two, with exact moments.

use glam::DVec3;
use rayon::prelude::*;
use wide::f64x4;

use crate::sdf::bvh::{Bvh, LEAF, MAX_DEPTH};
use crate::sdf::closest_point::{TriangleBlock, Vec4};
use crate::sdf::frame::Frame;

const FOUR_PI: f64 = 4.0 * std::f64::consts::PI;

/// Accuracy of the fast sum: a part is expanded where it is further away than this many of its radii.
pub const BETA: f64 = 2.3;

/// Accuracies and errors of ever finer tries to tell inside from outside. The largest errors measured
/// are a tenth of these: 1.4e-2, 2.8e-3 and 1.1e-5 on a scanned dragon, and less in the tests. The
/// first is for balanced meshes, whose winding numbers are integers and so far from one half.
const TRIES: [(f64, f64); 3] = [(1.6, 0.15), (BETA, 0.03), (8.0, 1e-4)];

/// Signed solid angle of a triangle seen from `p`, positive where `p` is behind it; -2 pi to 2 pi.
pub fn solid_angle(p: DVec3, corners: &[DVec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|corner| corner - p);
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let numerator = a.dot(b.cross(c));
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * numerator.atan2(denominator)
}

/// `solid_angle` of four triangles.
fn solid_angles(p: Vec4, block: &TriangleBlock) -> f64x4 {
    let [a, b, c] = block.corners().each_ref().map(|corner| *corner - p);
    let (la, lb, lc) = (a.dot(a).sqrt(), b.dot(b).sqrt(), c.dot(c).sqrt());
    let numerator = a.dot(b.cross(c));
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    let angle = numerator.atan2(denominator);
    angle + angle
}

/// Moments of the four parts below a node, in the frame of the tree.
#[derive(Clone, Debug)]
struct Expansion {
    centre: Vec4,
    radius_squared: f64x4,
    /// Which of the four are there, one bit each.
    used: u32,
    /// Sum of area vectors N.
    normal: Vec4,
    /// Coefficients of r.M.r with M the sum of N (x) d, d from the centre: xx, yy, zz, xy, yz, zx.
    linear: [f64x4; 6],
    /// Coefficients of the sum of (N.r)(d.r)^2: xxx, yyy, zzz, xxy, xxz, yyx, yyz, zzx, zzy, xyz.
    quadratic: [f64x4; 10],
}

/// The expansions that belong to a tree.
#[derive(Clone, Debug)]
pub struct WindingNumbers {
    expansions: Vec<Expansion>,
}

impl WindingNumbers {
    /// Moments of all parts of the tree.
    pub fn new(bvh: &Bvh) -> WindingNumbers {
        let moments = part_moments(bvh);
        let node = |(node, moments): (usize, &[Moments; 4])| expansion(bvh, node, moments);
        let expansions = moments.par_iter().enumerate().map(node).collect();
        WindingNumbers { expansions }
    }

    /// Winding number around `p`, by expansions of parts further away than `beta` of their radii.
    pub fn fast(&self, bvh: &Bvh, p: DVec3, beta: f64) -> f64 {
        let local = Vec4::splat((p - bvh.frame.centre) * bvh.frame.scale);
        let at = Vec4::splat(p);
        let beta_squared = f64x4::splat(beta * beta);
        let mut sum = f64x4::ZERO;
        let mut stack = [0u32; 3 * MAX_DEPTH + 4];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let index = stack[top] as usize;
            let part = &self.expansions[index];
            let r = part.centre - local;
            let distance_squared = r.dot(r);
            let far = distance_squared.simd_gt(beta_squared * part.radius_squared);
            sum += far.select(part.evaluate(r, distance_squared), f64x4::ZERO);
            let mut near = !far.to_bitmask() & part.used;
            while near != 0 {
                let child = bvh.nodes[index].children[near.trailing_zeros() as usize].child;
                near &= near - 1;
                if child & LEAF != 0 {
                    sum += solid_angles(at, &bvh.leaves.blocks[(child & !LEAF) as usize]);
                } else {
                    stack[top] = child;
                    top += 1;
                }
            }
        }
        sum.reduce_add() / FOUR_PI
    }

    /// Winding number around `p` by all triangles.
    pub fn exact(bvh: &Bvh, p: DVec3) -> f64 {
        let at = Vec4::splat(p);
        let mut sum = f64x4::ZERO;
        for block in &bvh.leaves.blocks[..bvh.built] {
            sum += solid_angles(at, block);
        }
        sum.reduce_add() / FOUR_PI
    }

    /// True where the winding number is above one half; as exact as it takes to tell. `balanced` says
    /// that it is an integer everywhere.
    pub fn inside(&self, bvh: &Bvh, p: DVec3, balanced: bool) -> bool {
        let tries = if balanced { &TRIES[..] } else { &TRIES[1..] };
        for &(beta, error) in tries {
            let number = self.fast(bvh, p, beta);
            if (number - 0.5).abs() > error {
                return number > 0.5;
            }
        }
        WindingNumbers::exact(bvh, p) > 0.5
    }
}

impl Expansion {
    /// Solid angles of the four parts with their centres at `r` from the point: the terms N.g, M:grad g
    /// and (1/2) T:grad grad g of g(r) = r / |r|^3 (Barill et al. 2018, Eq. 13 and supplement).
    #[inline]
    fn evaluate(&self, r: Vec4, distance_squared: f64x4) -> f64x4 {
        let inverse_squared = f64x4::ONE / distance_squared;
        let inverse_cubed = inverse_squared * inverse_squared.sqrt();
        let (x, y, z) = (r.x, r.y, r.z);
        let [xx, yy, zz, xy, yz, zx] = self.linear;
        let trace = xx + yy + zz;
        let form = x * (x * xx + y * xy) + y * (y * yy + z * yz) + z * (z * zz + x * zx);
        let [xxx, yyy, zzz, xxy, xxz, yyx, yyz, zzx, zzy, xyz] = self.quadratic;
        let three = f64x4::splat(3.0);
        let contracted =
            x * (three * xxx + yyx + zzx) + y * (three * yyy + xxy + zzy) + z * (three * zzz + xxz + yyz);
        let cubic = x * x * (x * xxx + y * xxy + z * xxz)
            + y * y * (y * yyy + x * yyx + z * yyz)
            + z * z * (z * zzz + x * zzx + y * zzy)
            + x * y * z * xyz;
        let order_0 = self.normal.dot(r) + trace;
        let order_1 = three * form + f64x4::splat(1.5) * contracted;
        let order_2 = f64x4::splat(7.5) * cubic;
        inverse_cubed * (order_0 - inverse_squared * (order_1 - inverse_squared * order_2))
    }
}

/// Moments of the four parts below each node, from the leaves up: those of a part are those of its parts, moved to its
/// own centre.
fn part_moments(bvh: &Bvh) -> Vec<[Moments; 4]> {
    let mut all = vec![[Moments::default(); 4]; bvh.nodes.len()];
    for node in (0..bvh.nodes.len()).rev() {
        for slot in (0..4).filter(|&slot| bvh.ranges[node][slot].1 > 0) {
            let child = bvh.nodes[node].children[slot].child;
            all[node][slot] = match child & LEAF != 0 {
                true => Moments::of_block(&bvh.leaves.blocks[(child & !LEAF) as usize], &bvh.frame),
                false => Moments::of_parts(&all[child as usize]),
            };
        }
    }
    all
}

fn expansion(bvh: &Bvh, node: usize, moments: &[Moments; 4]) -> Expansion {
    let mut result = Expansion {
        centre: Vec4::splat(DVec3::ZERO),
        radius_squared: f64x4::ZERO,
        used: 0,
        normal: Vec4::splat(DVec3::ZERO),
        linear: [f64x4::ZERO; 6],
        quadratic: [f64x4::ZERO; 10],
    };
    for (slot, &(first, end)) in bvh.ranges[node].iter().enumerate().filter(|(_, range)| range.1 > 0) {
        let part = &moments[slot];
        let blocks = &bvh.leaves.blocks[first as usize..end as usize];
        result.used |= 1 << slot;
        result.centre.set_lane(slot, part.centre);
        result.radius_squared.as_mut_array()[slot] = radius_squared(blocks, &bvh.frame, part.centre);
        result.normal.set_lane(slot, part.normal);
        for (to, from) in result.linear.iter_mut().zip(part.linear) {
            to.as_mut_array()[slot] = from;
        }
        for (to, from) in result.quadratic.iter_mut().zip(part.quadratic) {
            to.as_mut_array()[slot] = from;
        }
    }
    result
}

/// Squared distance of the farthest corner from a centre.
fn radius_squared(blocks: &[TriangleBlock], frame: &Frame, centre: DVec3) -> f64 {
    let mut farthest = f64x4::ZERO;
    let at = Vec4::splat(centre);
    for corner in blocks.iter().flat_map(|block| local_corners(block, frame)) {
        let d = corner - at;
        farthest = farthest.fast_max(d.dot(d));
    }
    farthest.to_array().into_iter().fold(0.0, f64::max)
}

/// Moments of one part, about its centre of area.
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    area: f64,
    centre: DVec3,
    normal: DVec3,
    linear: [f64; 6],
    quadratic: [f64; 10],
}

impl Moments {
    fn of_block(block: &TriangleBlock, frame: &Frame) -> Moments {
        let (centre, area) = centre_of_area(block, frame);
        let at = Vec4::splat(centre);
        let corners = local_corners(block, frame).map(|corner| corner - at);
        let normal = area_vector(&corners);
        let sum = corners[0] + corners[1] + corners[2];
        Moments {
            area,
            centre,
            normal: normal.sum_lanes(),
            linear: linear_form(normal, sum.scale(f64x4::splat(1.0 / 3.0))).map(f64x4::reduce_add),
            quadratic: quadratic_form(normal, &corners, sum).map(f64x4::reduce_add),
        }
    }

    fn of_parts(parts: &[Moments; 4]) -> Moments {
        let area: f64 = parts.iter().map(|part| part.area).sum();
        let weighted: DVec3 = parts.iter().map(|part| part.centre * part.area).sum();
        let centre = if area > 0.0 { weighted / area } else { parts[0].centre };
        let mut all = Moments { area, centre, ..Moments::default() };
        for part in parts {
            let moved = part.about(centre);
            all.normal += moved.normal;
            all.linear.iter_mut().zip(moved.linear).for_each(|(sum, term)| *sum += term);
            all.quadratic.iter_mut().zip(moved.quadratic).for_each(|(sum, term)| *sum += term);
        }
        all
    }

    /// The same about another centre: with d + t for d, (N.r)(d.r) gets (N.r)(t.r) more, and (N.r)(d.r)^2 gets
    /// 2 (t.r)(N.r)(d.r) + (t.r)(N.r)(t.r).
    fn about(&self, centre: DVec3) -> Moments {
        let t = self.centre - centre;
        let outer = linear_product(self.normal, t);
        let twice: [f64; 6] = std::array::from_fn(|i| 2.0 * self.linear[i] + outer[i]);
        let more = cubic_product(t, &twice);
        Moments {
            centre,
            linear: std::array::from_fn(|i| self.linear[i] + outer[i]),
            quadratic: std::array::from_fn(|i| self.quadratic[i] + more[i]),
            ..*self
        }
    }
}

/// (n.r)(m.r) as coefficients.
fn linear_product(n: DVec3, m: DVec3) -> [f64; 6] {
    [n.x * m.x, n.y * m.y, n.z * m.z, n.x * m.y + n.y * m.x, n.y * m.z + n.z * m.y, n.z * m.x + n.x * m.z]
}

/// (t.r) times a quadratic form, as coefficients.
fn cubic_product(t: DVec3, [xx, yy, zz, xy, yz, zx]: &[f64; 6]) -> [f64; 10] {
    [
        t.x * xx,
        t.y * yy,
        t.z * zz,
        t.y * xx + t.x * xy,
        t.z * xx + t.x * zx,
        t.x * yy + t.y * xy,
        t.z * yy + t.y * yz,
        t.x * zz + t.z * zx,
        t.y * zz + t.z * yz,
        t.z * xy + t.x * yz + t.y * zx,
    ]
}

/// (N.r)(m.r) with m the mean of d over the triangle, as coefficients.
fn linear_form(n: Vec4, m: Vec4) -> [f64x4; 6] {
    [n.x * m.x, n.y * m.y, n.z * m.z, n.x * m.y + n.y * m.x, n.y * m.z + n.z * m.y, n.z * m.x + n.x * m.z]
}

/// (N.r)(r.D.r) with D the mean of d (x) d over the triangle: the corners' squares and the square of
/// their sum, over 12.
fn quadratic_form(n: Vec4, corners: &[Vec4; 3], sum: Vec4) -> [f64x4; 10] {
    let [a, b, c] = *corners;
    let twelfth = f64x4::splat(1.0 / 12.0);
    let mean = |f: fn(Vec4) -> f64x4| (f(a) + f(b) + f(c) + f(sum)) * twelfth;
    let (xx, yy, zz) = (mean(|d| d.x * d.x), mean(|d| d.y * d.y), mean(|d| d.z * d.z));
    let (xy, yz, zx) = (mean(|d| d.x * d.y), mean(|d| d.y * d.z), mean(|d| d.z * d.x));
    let two = f64x4::splat(2.0);
    [
        n.x * xx,
        n.y * yy,
        n.z * zz,
        n.y * xx + two * n.x * xy,
        n.z * xx + two * n.x * zx,
        n.x * yy + two * n.y * xy,
        n.z * yy + two * n.y * yz,
        n.x * zz + two * n.z * zx,
        n.y * zz + two * n.z * yz,
        two * (n.x * yz + n.y * zx + n.z * xy),
    ]
}

fn local_corners(block: &TriangleBlock, frame: &Frame) -> [Vec4; 3] {
    let (centre, scale) = (Vec4::splat(frame.centre), f64x4::splat(frame.scale));
    block.corners().each_ref().map(|corner| (*corner - centre).scale(scale))
}

fn area_vector(corners: &[Vec4; 3]) -> Vec4 {
    let [a, b, c] = *corners;
    (b - a).cross(c - a).scale(f64x4::splat(0.5))
}

/// Mean of the triangles' centroids, weighted by area, and the area; without area, a corner.
fn centre_of_area(block: &TriangleBlock, frame: &Frame) -> (DVec3, f64) {
    let corners = local_corners(block, frame);
    let n = area_vector(&corners);
    let weight = n.dot(n).sqrt();
    let weighted = (corners[0] + corners[1] + corners[2]).scale(weight);
    let area = weight.reduce_add();
    let centre = if area > 0.0 { weighted.sum_lanes() / (3.0 * area) } else { corners[0].lane(0) };
    (centre, area)
}
