//! Which closed parts of a mesh lie inside which.

use glam::DVec3;
use rayon::prelude::*;
use volmap_formats::mesh::TriangleMesh;

use crate::mesh::parts::{Parts, corners};
use crate::sdf::bvh::Bvh;
use crate::sdf::winding::{BETA, WindingNumbers};

/// Pairs of parts that are looked at, at most.
const MAX_PAIRS: usize = 1 << 20;
/// Points of a part that are asked whether they lie inside another.
const SAMPLES: usize = 8;

/// How the balanced parts of a mesh lie in each other.
#[derive(Clone, Debug, Default)]
pub struct Nesting {
    /// For each part, the parts that contain it, in increasing order.
    pub containers: Vec<Vec<u32>>,
    /// Pairs whose boxes overlap although neither lies inside the other: they may intersect.
    pub overlapping: Vec<(u32, u32)>,
    /// False where there were too many pairs to look at all of them.
    pub complete: bool,
}

impl Nesting {
    /// Winding number around part `i` due to the other parts.
    pub fn winding_around(&self, parts: &Parts, i: usize) -> i64 {
        let turns = |&outer: &u32| parts.list[outer as usize].volume.signum() as i64;
        self.containers[i].iter().map(turns).sum()
    }
}

/// Looks at all pairs of balanced parts with overlapping boxes.
pub fn find_nesting(mesh: &TriangleMesh, parts: &Parts) -> Nesting {
    let (pairs, complete) = overlapping_boxes(parts);
    let mut nesting =
        Nesting { containers: vec![Vec::new(); parts.list.len()], overlapping: Vec::new(), complete };
    // Grouped by the outer part, so that each part's tree is built once.
    let groups: Vec<&[(u32, u32)]> = pairs.chunk_by(|a, b| a.0 == b.0).collect();
    let found: Vec<Vec<Position>> = groups.par_iter().map(|group| positions(mesh, parts, group)).collect();
    for (&(outer, inner), position) in pairs.iter().zip(found.iter().flatten()) {
        match position {
            Position::Inside => nesting.containers[inner as usize].push(outer),
            // Each pair comes both ways round; it may still be the other way that nests.
            Position::Apart => nesting.overlapping.push((outer.min(inner), outer.max(inner))),
        }
    }
    nesting.overlapping.sort_unstable();
    nesting.overlapping.dedup();
    let containers = &nesting.containers;
    let nested = |a: u32, b: u32| containers[a as usize].binary_search(&b).is_ok();
    nesting.overlapping.retain(|&(a, b)| !nested(a, b) && !nested(b, a));
    nesting
}

#[derive(Clone, Copy, PartialEq)]
enum Position {
    Inside,
    Apart,
}

/// Ordered pairs (outer, inner) of balanced parts with overlapping boxes, by a sweep along x.
fn overlapping_boxes(parts: &Parts) -> (Vec<(u32, u32)>, bool) {
    let mut order: Vec<u32> =
        (0..parts.list.len() as u32).filter(|&i| parts.list[i as usize].balanced).collect();
    let bounds = |i: u32| &parts.list[i as usize].bounds;
    order.sort_by(|&i, &j| bounds(i).lower[0].total_cmp(&bounds(j).lower[0]));
    let mut pairs = Vec::new();
    let mut looked_at = 0;
    for (k, &i) in order.iter().enumerate() {
        for &j in &order[k + 1..] {
            if bounds(j).lower[0] > bounds(i).upper[0] {
                break;
            }
            looked_at += 1;
            if looked_at > 64 * MAX_PAIRS || pairs.len() > MAX_PAIRS {
                pairs.sort_unstable();
                return (pairs, false);
            }
            if bounds(i).overlaps(bounds(j)) {
                pairs.extend([(i, j), (j, i)]);
            }
        }
    }
    pairs.sort_unstable();
    (pairs, true)
}

/// Positions of the inner parts of pairs that share their outer part.
fn positions(mesh: &TriangleMesh, parts: &Parts, pairs: &[(u32, u32)]) -> Vec<Position> {
    let outer = pairs[0].0 as usize;
    let outer_bounds = &parts.list[outer].bounds;
    let fits = |inner: u32| outer_bounds.contains(&parts.list[inner as usize].bounds);
    if !pairs.iter().any(|&(_, inner)| fits(inner)) {
        return vec![Position::Apart; pairs.len()];
    }
    let triangles: Vec<[DVec3; 3]> =
        parts.triangles(outer).iter().map(|&triangle| corners(mesh, triangle as usize)).collect();
    let bvh = Bvh::new(&triangles);
    let winding = WindingNumbers::new(&bvh);
    // Three quarters: a point on the outer surface, with about one half, is not inside.
    let is_inside = |p: DVec3| winding.fast(&bvh, p, BETA).abs() > 0.75;
    pairs
        .iter()
        .map(|&(_, inner)| {
            let inside = fits(inner) && samples(mesh, parts, inner as usize).all(is_inside);
            if inside { Position::Inside } else { Position::Apart }
        })
        .collect()
}

/// A few corners, spread over the part's triangles.
fn samples<'a>(mesh: &'a TriangleMesh, parts: &'a Parts, i: usize) -> impl Iterator<Item = DVec3> + 'a {
    let triangles = parts.triangles(i);
    let count = SAMPLES.min(triangles.len());
    (0..count).map(move |k| corners(mesh, triangles[k * triangles.len() / count] as usize)[k % 3])
}
