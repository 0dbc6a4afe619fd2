//! Building the tree: top down, binned surface area heuristic.
//!
//! Wald 2007, "On fast construction of SAH-based bounding volume hierarchies". For a closest-point
//! query the heuristic is the same as for rays: the chance that the search sphere meets a box grows
//! with the box's surface. Large parts are built in parallel and joined in order, so the tree doesn't
//! depend on the number of threads.

use glam::DVec3;
use rayon::prelude::*;
use wide::f32x4;

use crate::sdf::bvh::{Bvh, Frame, LEAF, MAX_DEPTH, Node};
use crate::sdf::closest_point::TriangleBlock;
use crate::sdf::coarse_block::CoarseBlock;

const BINS: usize = 16;
const LEAF_SIZE: usize = 4;
/// Parts with more triangles than this are built in parallel.
const PARALLEL_SIZE: usize = 1 << 14;
/// From this level on parts are halved, which bounds the depth: 20 + log4(2^32) < MAX_DEPTH.
const HALVING_DEPTH: usize = 20;

#[derive(Clone, Copy, Debug)]
struct Bounds {
    lower: [f32; 3],
    upper: [f32; 3],
}

const EMPTY: Bounds = Bounds { lower: [f32::INFINITY; 3], upper: [f32::NEG_INFINITY; 3] };

/// A triangle's box and its index.
#[derive(Clone, Copy, Debug)]
struct Item {
    bounds: Bounds,
    triangle: u32,
}

/// Nodes, and the sizes of the leaves below them; leaves lie in the order of the items.
#[derive(Default)]
struct Subtree {
    nodes: Vec<Node>,
    leaf_sizes: Vec<u8>,
}

pub(crate) fn build(triangles: &[[DVec3; 3]]) -> Bvh {
    assert!(!triangles.is_empty(), "a tree needs a triangle");
    let frame = frame_of(triangles);
    let mut items: Vec<Item> = triangles
        .iter()
        .enumerate()
        .map(|(i, triangle)| Item { bounds: local_bounds(triangle, &frame), triangle: i as u32 })
        .collect();
    let tree = build_node(&mut items, 0);
    let mut rest = items.as_mut_slice();
    let leaves: Vec<&mut [Item]> = tree
        .leaf_sizes
        .iter()
        .map(|&size| rest.split_off_mut(..size.into()).expect("leaves hold all items"))
        .collect();
    let (blocks, ids): (Vec<TriangleBlock>, _) =
        leaves.into_par_iter().map(|leaf| block(leaf, triangles)).unzip();
    let coarse = blocks.par_iter().map(|block| CoarseBlock::new(block, &frame)).collect();
    Bvh { nodes: tree.nodes, blocks, coarse, ids, frame }
}

/// A leaf's triangles, in the order of the mesh.
fn block(leaf: &mut [Item], triangles: &[[DVec3; 3]]) -> (TriangleBlock, [u32; 4]) {
    leaf.sort_unstable_by_key(|item| item.triangle);
    let id = |i: usize| leaf[i.min(leaf.len() - 1)].triangle;
    let ids = [id(0), id(1), id(2), id(3)];
    let mut corners = [[DVec3::ZERO; 3]; LEAF_SIZE];
    for (corners, id) in corners.iter_mut().zip(ids) {
        *corners = triangles[id as usize];
    }
    (TriangleBlock::new(&corners[..leaf.len()]), ids)
}

fn frame_of(triangles: &[[DVec3; 3]]) -> Frame {
    let mut lower = triangles[0][0];
    let mut upper = lower;
    for corner in triangles.iter().flatten() {
        lower = lower.min(*corner);
        upper = upper.max(*corner);
    }
    let size = (upper * 0.5 - lower * 0.5).max_element();
    let exponent = size.log2().ceil().clamp(-1000.0, 1000.0);
    Frame { centre: lower * 0.5 + upper * 0.5, scale: (-exponent).exp2() }
}

/// The triangle's box in the frame, rounded outwards.
fn local_bounds(triangle: &[DVec3; 3], frame: &Frame) -> Bounds {
    let mut bounds = EMPTY;
    for corner in triangle {
        let local = frame.local(*corner);
        for (axis, x) in local.into_iter().enumerate() {
            bounds.lower[axis] = bounds.lower[axis].min(x.next_down());
            bounds.upper[axis] = bounds.upper[axis].max(x.next_up());
        }
    }
    bounds
}

/// A node over the items and all below it, the node first.
fn build_node(items: &mut [Item], depth: usize) -> Subtree {
    assert!(depth < MAX_DEPTH, "the tree is deeper than its bound");
    let count = items.len();
    let parts = split_in_four(items, depth);
    let mut tree = Subtree::default();
    let mut node = Node {
        lower: [f32x4::splat(f32::INFINITY); 3],
        upper: [f32x4::splat(f32::NEG_INFINITY); 3],
        child: [LEAF; 4],
    };
    for (i, part) in parts.iter().enumerate() {
        let bounds = bounds_of(part);
        for axis in 0..3 {
            node.lower[axis].as_mut_array()[i] = bounds.lower[axis];
            node.upper[axis].as_mut_array()[i] = bounds.upper[axis];
        }
    }
    tree.nodes.push(node);
    let build_part = |part: &mut &mut [Item]| (part.len() > LEAF_SIZE).then(|| build_node(part, depth + 1));
    let mut parts = parts;
    let children: Vec<Option<Subtree>> = if count > PARALLEL_SIZE {
        parts.par_iter_mut().map(build_part).collect()
    } else {
        parts.iter_mut().map(build_part).collect()
    };
    for (i, (part, child)) in parts.iter().zip(children).enumerate() {
        tree.nodes[0].child[i] = match child {
            Some(child) => tree.append(child),
            None => tree.append_leaf(part.len()),
        };
    }
    tree
}

impl Subtree {
    /// Appends a subtree behind this one and returns where its root is now.
    fn append(&mut self, mut other: Subtree) -> u32 {
        let (node_offset, block_offset) = (self.nodes.len() as u32, self.leaf_sizes.len() as u32);
        for child in other.nodes.iter_mut().flat_map(|node| &mut node.child) {
            *child += if *child & LEAF != 0 { block_offset } else { node_offset };
        }
        self.nodes.append(&mut other.nodes);
        self.leaf_sizes.append(&mut other.leaf_sizes);
        node_offset
    }

    fn append_leaf(&mut self, size: usize) -> u32 {
        self.leaf_sizes.push(size as u8);
        LEAF | (self.leaf_sizes.len() - 1) as u32
    }
}

/// Up to four parts: the part of the largest surface is split until there are four.
fn split_in_four(items: &mut [Item], depth: usize) -> Vec<&mut [Item]> {
    let mut parts = vec![items];
    while parts.len() < 4 {
        let splittable = (0..parts.len()).filter(|&i| parts[i].len() > LEAF_SIZE);
        let surface = |i: usize| bounds_of(parts[i]).surface();
        let Some(widest) = splittable.max_by(|&i, &j| {
            let by_count = parts[i].len().cmp(&parts[j].len());
            match depth < HALVING_DEPTH {
                true => surface(i).total_cmp(&surface(j)).then(by_count),
                false => by_count,
            }
        }) else {
            break;
        };
        let part = parts.remove(widest);
        let middle = split(part, depth);
        let (left, right) = part.split_at_mut(middle);
        parts.insert(widest, right);
        parts.insert(widest, left);
    }
    parts
}

/// Reorders the items and returns where the second half starts.
fn split(items: &mut [Item], depth: usize) -> usize {
    let mut centres = EMPTY;
    for item in items.iter() {
        centres.grow_by_point(item.bounds.centre());
    }
    if depth < HALVING_DEPTH
        && let Some((axis, bin)) = best_bin(items, &centres)
    {
        let binning = Binning::new(&centres, axis);
        let middle = partition(items, |item| binning.bin(item) < bin);
        if middle > 0 && middle < items.len() {
            return middle;
        }
    }
    let axis = centres.widest_axis();
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| {
        let by_place = a.bounds.centre()[axis].total_cmp(&b.bounds.centre()[axis]);
        by_place.then(a.triangle.cmp(&b.triangle))
    });
    middle
}

/// Axis and bin before which a split costs least; none where all centres coincide.
fn best_bin(items: &[Item], centres: &Bounds) -> Option<(usize, usize)> {
    let mut best = (f32::INFINITY, None);
    for axis in 0..3 {
        if centres.upper[axis] <= centres.lower[axis] {
            continue;
        }
        let binning = Binning::new(centres, axis);
        let mut bins = [(EMPTY, 0usize); BINS];
        for item in items {
            let bin = &mut bins[binning.bin(item)];
            bin.0.grow(&item.bounds);
            bin.1 += 1;
        }
        let from_left = sweep(bins.iter());
        let from_right = sweep(bins.iter().rev());
        for split in 1..BINS {
            let cost = from_left[split - 1] + from_right[BINS - 1 - split];
            if cost < best.0 {
                best = (cost, Some((axis, split)));
            }
        }
    }
    best.1
}

/// Surface times blocks of four of the first 1, 2, ... bins.
fn sweep<'a>(bins: impl Iterator<Item = &'a (Bounds, usize)>) -> [f32; BINS] {
    let mut costs = [0.0; BINS];
    let mut bounds = EMPTY;
    let mut count = 0;
    for (cost, bin) in costs.iter_mut().zip(bins) {
        bounds.grow(&bin.0);
        count += bin.1;
        // A side without triangles is no split.
        *cost = match count {
            0 => f32::INFINITY,
            _ => bounds.surface() * count.div_ceil(LEAF_SIZE) as f32,
        };
    }
    costs
}

struct Binning {
    axis: usize,
    lower: f32,
    factor: f32,
}

impl Binning {
    fn new(centres: &Bounds, axis: usize) -> Binning {
        let width = centres.upper[axis] - centres.lower[axis];
        Binning { axis, lower: centres.lower[axis], factor: BINS as f32 / width }
    }

    #[inline]
    fn bin(&self, item: &Item) -> usize {
        let centre = item.bounds.lower[self.axis] * 0.5 + item.bounds.upper[self.axis] * 0.5;
        (((centre - self.lower) * self.factor) as usize).min(BINS - 1)
    }
}

/// Moves the items that `belongs_left` to the front and returns their number.
fn partition(items: &mut [Item], belongs_left: impl Fn(&Item) -> bool) -> usize {
    let mut left = 0;
    for i in 0..items.len() {
        if belongs_left(&items[i]) {
            items.swap(left, i);
            left += 1;
        }
    }
    left
}

fn bounds_of(items: &[Item]) -> Bounds {
    let mut bounds = EMPTY;
    for item in items {
        bounds.grow(&item.bounds);
    }
    bounds
}

impl Bounds {
    #[inline]
    fn grow(&mut self, other: &Bounds) {
        for axis in 0..3 {
            self.lower[axis] = self.lower[axis].min(other.lower[axis]);
            self.upper[axis] = self.upper[axis].max(other.upper[axis]);
        }
    }

    #[inline]
    fn grow_by_point(&mut self, point: [f32; 3]) {
        self.grow(&Bounds { lower: point, upper: point });
    }

    #[inline]
    fn centre(&self) -> [f32; 3] {
        std::array::from_fn(|axis| self.lower[axis] * 0.5 + self.upper[axis] * 0.5)
    }

    /// Half the surface; 0 where empty.
    #[inline]
    fn surface(&self) -> f32 {
        let [x, y, z] = std::array::from_fn(|axis| (self.upper[axis] - self.lower[axis]).max(0.0));
        x * y + y * z + z * x
    }

    fn widest_axis(&self) -> usize {
        let width = |axis: usize| self.upper[axis] - self.lower[axis];
        (0..3).fold(0, |best, axis| if width(axis) > width(best) { axis } else { best })
    }
}
