//! Pairs of triangles that cross or cover each other: each leaf of the tree against the leaves after it.
//!
//! Boxes and planes in single precision (`coarse`), four triangles at a time, rule nearly all pairs out; `cuts` looks
//! at the rest.

use glam::DVec3;
use rayon::prelude::*;

use super::coarse::{Boxes, CoarseLeaf, boxes_of_nodes};
use super::cuts::{Cut, Meetings, Triangle, contact};
use crate::sdf::bvh::{Bvh, LEAF, MAX_DEPTH};

/// The pairs of a mesh, and where its triangles are cut by others.
#[derive(Clone, Debug)]
pub struct Contacts {
    /// Number of pairs.
    pub pairs: usize,
    /// Where the first pair meets.
    pub place: Option<DVec3>,
    /// Lengths up to this are rounding.
    pub tolerance: f64,
    /// Triangles of the pairs, each once, in increasing order.
    pub met: Vec<u32>,
    /// By triangle.
    meetings: Meetings,
}

impl Contacts {
    /// Finds all pairs.
    pub fn find(bvh: &Bvh, tolerance: f64) -> Contacts {
        let leaves: Vec<CoarseLeaf> = bvh
            .leaves
            .blocks
            .par_iter()
            .enumerate()
            .map(|(index, block)| CoarseLeaf::new(block, index, bvh, tolerance))
            .collect();
        let search = Search { bvh, leaves: &leaves, boxes: &boxes_of_nodes(bvh, &leaves), tolerance };
        let found: Vec<Found> = (0..bvh.leaves.blocks.len() as u32)
            .into_par_iter()
            .with_min_len(64)
            .map(|block| search.around_block(block))
            .filter(|found| !found.met.is_empty())
            .collect();
        let mut contacts =
            Contacts { pairs: 0, place: None, tolerance, met: Vec::new(), meetings: Meetings::default() };
        for one in found {
            contacts.pairs += one.met.len();
            contacts.met.extend(one.met.iter().flatten());
            contacts.place = contacts.place.or(one.place);
            contacts.meetings.cuts.extend(one.meetings.cuts);
            contacts.meetings.covered.extend(one.meetings.covered);
        }
        // Stable: cuts of a triangle stay in the order of the tree, whatever the number of threads.
        contacts.meetings.cuts.sort_by_key(|cut| cut.triangle);
        contacts.meetings.covered.sort_unstable();
        contacts.met.sort_unstable();
        contacts.met.dedup();
        contacts
    }

    /// The cuts of a triangle.
    pub fn cuts_of(&self, triangle: u32) -> &[Cut] {
        range(&self.meetings.cuts, |cut| cut.triangle, triangle)
    }

    /// The triangles that it lies on, as pairs with its own number.
    pub fn covers_of(&self, triangle: u32) -> &[(u32, u32)] {
        range(&self.meetings.covered, |pair| pair.0, triangle)
    }
}

fn range<T>(sorted: &[T], key: impl Fn(&T) -> u32, of: u32) -> &[T] {
    let start = sorted.partition_point(|item| key(item) < of);
    let end = start + sorted[start..].partition_point(|item| key(item) == of);
    &sorted[start..end]
}

/// What one leaf meets.
#[derive(Default)]
struct Found {
    met: Vec<[u32; 2]>,
    place: Option<DVec3>,
    meetings: Meetings,
}

struct Search<'a> {
    bvh: &'a Bvh,
    leaves: &'a [CoarseLeaf],
    boxes: &'a [Boxes],
    tolerance: f64,
}

impl Search<'_> {
    fn around_block(&self, block: u32) -> Found {
        let mut found = Found::default();
        let leaf = &self.leaves[block as usize];
        self.between(block, block, &mut found);
        let mut stack = [0u32; 3 * MAX_DEPTH + 4];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let index = stack[top] as usize;
            let mut near = self.boxes[index].meeting(&leaf.bounds);
            while near != 0 {
                let slot = near.trailing_zeros() as usize;
                near &= near - 1;
                // Each pair once: only leaves that come after this one.
                if self.bvh.ranges[index][slot].1 <= block + 1 {
                    continue;
                }
                let child = self.bvh.nodes[index].children[slot].child;
                if child & LEAF != 0 {
                    self.between(block, child & !LEAF, &mut found);
                } else {
                    stack[top] = child;
                    top += 1;
                }
            }
        }
        found
    }

    /// The triangles of one leaf and those of another, or its own.
    fn between(&self, block: u32, other: u32, found: &mut Found) {
        let (leaf, others) = (&self.leaves[block as usize], &self.leaves[other as usize]);
        let mut lanes = leaf.meeting(others);
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let mut near = leaf.near(lane, others);
            if block == other {
                near &= !((2 << lane) - 1);
            }
            if near == 0 {
                continue;
            }
            let one = self.triangle(block, lane);
            while near != 0 {
                let second = self.triangle(other, near.trailing_zeros() as usize);
                near &= near - 1;
                if let Some(place) = contact(&one, &second, self.tolerance, &mut found.meetings) {
                    found.met.push([one.number, second.number]);
                    found.place = found.place.or(Some(place));
                }
            }
        }
    }

    fn triangle(&self, block: u32, lane: usize) -> Triangle {
        let block = block as usize;
        Triangle {
            corners: self.bvh.leaves.blocks[block].triangle(lane),
            number: self.bvh.leaves.ids[block][lane],
        }
    }
}
