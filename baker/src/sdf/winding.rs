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

use crate::sdf::bvh::{Bvh, Frame, LEAF, MAX_DEPTH};
use crate::sdf::closest_point::{TriangleBlock, Vec4};

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
    let [a, b, c] = block.corners().map(|corner| corner - p);
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
        let expansions = (0..bvh.nodes.len()).into_par_iter().map(|node| expansion(bvh, node)).collect();
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
                let child = bvh.nodes[index].child[near.trailing_zeros() as usize];
                near &= near - 1;
                if child & LEAF != 0 {
                    sum += solid_angles(at, &bvh.blocks[(child & !LEAF) as usize]);
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
        for block in &bvh.blocks {
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

fn expansion(bvh: &Bvh, node: usize) -> Expansion {
    let mut result = Expansion {
        centre: Vec4::splat(DVec3::ZERO),
        radius_squared: f64x4::ZERO,
        used: 0,
        normal: Vec4::splat(DVec3::ZERO),
        linear: [f64x4::ZERO; 6],
        quadratic: [f64x4::ZERO; 10],
    };
    for (slot, &(first, end)) in bvh.ranges[node].iter().enumerate().filter(|(_, range)| range.1 > 0) {
        let blocks = &bvh.blocks[first as usize..end as usize];
        let moments = Moments::new(blocks, &bvh.frame);
        result.used |= 1 << slot;
        result.centre.set_lane(slot, moments.centre);
        result.radius_squared.as_mut_array()[slot] = moments.radius_squared;
        result.normal.set_lane(slot, moments.normal);
        for (to, from) in result.linear.iter_mut().zip(moments.linear) {
            to.as_mut_array()[slot] = from;
        }
        for (to, from) in result.quadratic.iter_mut().zip(moments.quadratic) {
            to.as_mut_array()[slot] = from;
        }
    }
    result
}

/// Moments of one part.
struct Moments {
    centre: DVec3,
    radius_squared: f64,
    normal: DVec3,
    linear: [f64; 6],
    quadratic: [f64; 10],
}

impl Moments {
    fn new(blocks: &[TriangleBlock], frame: &Frame) -> Moments {
        let centre = centre_of_area(blocks, frame);
        let at = Vec4::splat(centre);
        let mut radius_squared = f64x4::ZERO;
        let mut normal = Vec4::splat(DVec3::ZERO);
        let mut linear = [f64x4::ZERO; 6];
        let mut quadratic = [f64x4::ZERO; 10];
        for block in blocks {
            let corners = local_corners(block, frame).map(|corner| corner - at);
            for d in corners {
                radius_squared = radius_squared.fast_max(d.dot(d));
            }
            let n = area_vector(&corners);
            normal = normal + n;
            let sum = corners[0] + corners[1] + corners[2];
            add(&mut linear, linear_form(n, sum.scale(f64x4::splat(1.0 / 3.0))));
            add(&mut quadratic, quadratic_form(n, &corners, sum));
        }
        Moments {
            centre,
            radius_squared: radius_squared.to_array().into_iter().fold(0.0, f64::max),
            normal: normal.sum_lanes(),
            linear: linear.map(f64x4::reduce_add),
            quadratic: quadratic.map(f64x4::reduce_add),
        }
    }
}

fn add<const N: usize>(sums: &mut [f64x4; N], terms: [f64x4; N]) {
    for (sum, term) in sums.iter_mut().zip(terms) {
        *sum += term;
    }
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
    block.corners().map(|corner| (corner - centre).scale(scale))
}

fn area_vector(corners: &[Vec4; 3]) -> Vec4 {
    let [a, b, c] = *corners;
    (b - a).cross(c - a).scale(f64x4::splat(0.5))
}

/// Mean of the triangles' centroids, weighted by area; of a part without area, a corner.
fn centre_of_area(blocks: &[TriangleBlock], frame: &Frame) -> DVec3 {
    let mut weighted = Vec4::splat(DVec3::ZERO);
    let mut area = f64x4::ZERO;
    for block in blocks {
        let corners = local_corners(block, frame);
        let n = area_vector(&corners);
        let weight = n.dot(n).sqrt();
        weighted = weighted + (corners[0] + corners[1] + corners[2]).scale(weight);
        area += weight;
    }
    let area = area.reduce_add();
    if area > 0.0 { weighted.sum_lanes() / (3.0 * area) } else { local_corners(&blocks[0], frame)[0].lane(0) }
}
