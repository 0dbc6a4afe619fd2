//! Which closed parts of a mesh lie inside which.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use volmap_formats::mesh::TriangleMesh;

use crate::mesh::crossings::winding_numbers;
use crate::mesh::parts::{Parts, corners};

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
    /// False where it would have taken too long to look at all pairs.
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
    // Grouped by the outer part, so that each part's triangles are gone through once.
    let groups: Vec<&[(u32, u32)]> = pairs.chunk_by(|a, b| a.0 == b.0).collect();
    let found: Vec<Option<Vec<bool>>> = groups.par_iter().map(|group| nested(mesh, parts, group)).collect();
    for (group, inside) in groups.iter().zip(found) {
        nesting.complete &= inside.is_some();
        for (k, &(outer, inner)) in group.iter().enumerate() {
            match inside.as_ref().is_some_and(|inside| inside[k]) {
                true => nesting.containers[inner as usize].push(outer),
                // Each pair comes both ways round; it may still be the other way that nests.
                false => nesting.overlapping.push((outer.min(inner), outer.max(inner))),
            }
        }
    }
    nesting.overlapping.sort_unstable();
    nesting.overlapping.dedup();
    let containers = &nesting.containers;
    let nested = |a: u32, b: u32| containers[a as usize].binary_search(&b).is_ok();
    nesting.overlapping.retain(|&(a, b)| !nested(a, b) && !nested(b, a));
    nesting
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

/// Of pairs that share their outer part, whether the inner part lies inside it: with none of its samples
/// outside, and not all of them on the outer part's surface. `None` if it would take too long.
fn nested(mesh: &TriangleMesh, parts: &Parts, pairs: &[(u32, u32)]) -> Option<Vec<bool>> {
    let outer = pairs[0].0 as usize;
    let outer_bounds = &parts.list[outer].bounds;
    let mut points = Vec::new();
    let ranges: Vec<Range<usize>> = pairs
        .iter()
        .map(|&(_, inner)| {
            let start = points.len();
            if outer_bounds.contains(&parts.list[inner as usize].bounds) {
                points.extend(samples(mesh, parts, inner as usize));
            }
            start..points.len()
        })
        .collect();
    if points.is_empty() {
        return Some(vec![false; pairs.len()]);
    }
    let turns = winding_numbers(mesh, parts.triangles(outer), &points)?;
    let is_inside = |range: Range<usize>| {
        let mut off_surface = turns[range].iter().flatten().peekable();
        off_surface.peek().is_some() && off_surface.all(|&turns| turns != 0)
    };
    Some(ranges.into_iter().map(is_inside).collect())
}

/// A few corners, spread over the part's triangles.
fn samples<'a>(mesh: &'a TriangleMesh, parts: &'a Parts, i: usize) -> impl Iterator<Item = DVec3> + 'a {
    let triangles = parts.triangles(i);
    let count = SAMPLES.min(triangles.len());
    (0..count).map(move |k| corners(mesh, triangles[k * triangles.len() / count] as usize)[k % 3])
}
