//! Building the tree: top down by the binned surface area heuristic, then boxes turned along the surface.
//!
//! Wald 2007, "On fast construction of SAH-based bounding volume hierarchies". For a closest-point
//! query the heuristic is the same as for rays: the chance that the search sphere meets a box grows
//! with the box's surface. One axis is binned, the widest of the centres; the boxes that it compares are aligned with
//! the axes, and serve for this only (`oriented_box` makes those of the search). Large parts are built in parallel and
//! joined in order, so the tree doesn't depend on the number of threads.

use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;
use wide::f32x4;

use crate::sdf::bvh::{Bvh, Child, LEAF, Leaves, MAX_DEPTH, NO_CHILD, Node};
use crate::sdf::closest_point::TriangleBlock;
use crate::sdf::coarse_block::CoarseBlock;
use crate::sdf::frame::Frame;
use crate::sdf::oriented_box::OrientedBox;

const BINS: usize = 16;
pub(crate) const LEAF_SIZE: usize = 4;
/// Parts with more triangles than this are built in parallel.
const PARALLEL_SIZE: usize = 1 << 14;
/// From this level on parts are halved, which bounds the depth: 20 + log4(2^32) < MAX_DEPTH.
const HALVING_DEPTH: usize = 20;

/// Lowest and highest coordinates; the fourth lane means nothing.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    lower: f32x4,
    upper: f32x4,
}

/// A triangle's box and its index.
#[derive(Clone, Copy, Debug)]
struct Item {
    bounds: Bounds,
    triangle: u32,
}

/// Triangles with their box and that of the boxes' centres.
struct Part<'a> {
    items: &'a mut [Item],
    bounds: Bounds,
    centres: Bounds,
}

/// Children of the nodes, and the sizes of the leaves below them; leaves lie in the order of the items.
#[derive(Default)]
struct Subtree {
    children: Vec<[u32; 4]>,
    leaf_sizes: Vec<u8>,
}

impl Bvh {
    /// Builds the tree over triangles of finite coordinates, of which there must be at least one.
    pub fn new(triangles: &[[DVec3; 3]]) -> Bvh {
        build(triangles)
    }
}

fn build(triangles: &[[DVec3; 3]]) -> Bvh {
    assert!(!triangles.is_empty(), "a tree needs a triangle");
    let frame = frame_of(triangles);
    let item = |(i, triangle)| Item { bounds: local_bounds(triangle, &frame), triangle: i as u32 };
    let mut items: Vec<Item> = triangles.par_iter().enumerate().map(item).collect();
    let tree = build_node(Part::of(&mut items), 0);
    let mut rest = items.as_mut_slice();
    let leaves: Vec<&mut [Item]> = tree
        .leaf_sizes
        .iter()
        .map(|&size| rest.split_off_mut(..size.into()).expect("leaves hold all items"))
        .collect();
    let (blocks, ids): (Vec<TriangleBlock>, _) =
        leaves.into_par_iter().map(|leaf| block(leaf, triangles)).unzip();
    let counted = blocks.par_iter().zip(&tree.leaf_sizes);
    let coarse = counted.map(|(block, &size)| CoarseBlock::new(block, size.into(), &frame)).collect();
    let ranges = block_ranges(&tree.children);
    let child = |child: u32, (first, end): (u32, u32)| Child {
        bounds: match child {
            NO_CHILD => OrientedBox::NONE,
            _ => OrientedBox::around(&blocks[first as usize..end as usize], &frame),
        },
        child,
    };
    let node = |(children, ranges): (&[u32; 4], &[(u32, u32); 4])| Node {
        children: [0, 1, 2, 3].map(|slot| child(children[slot], ranges[slot])),
    };
    let nodes = tree.children.par_iter().zip(&ranges).map(node).collect();
    let built = blocks.len();
    Bvh { nodes, leaves: Arc::new(Leaves { blocks, coarse, ids }), built, ranges, frame }
}

/// For each node and child, the blocks below it, first and past the last; both 0 where there is no child. Nodes come
/// before their children and blocks in the order of the children.
fn block_ranges(children: &[[u32; 4]]) -> Vec<[(u32, u32); 4]> {
    let mut ranges = vec![[(0, 0); 4]; children.len()];
    for (index, children) in children.iter().enumerate().rev() {
        for (slot, &child) in children.iter().enumerate().filter(|(_, child)| **child != NO_CHILD) {
            ranges[index][slot] = if child & LEAF != 0 {
                (child & !LEAF, (child & !LEAF) + 1)
            } else {
                let used = ranges[child as usize].iter().filter(|range| range.1 > 0);
                used.fold((u32::MAX, 0), |all, range| (all.0.min(range.0), all.1.max(range.1)))
            };
        }
    }
    ranges
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

fn local_bounds(triangle: &[DVec3; 3], frame: &Frame) -> Bounds {
    let [a, b, c] = triangle.map(|corner| {
        let [x, y, z] = frame.local(corner);
        f32x4::from([x, y, z, 0.0])
    });
    Bounds { lower: a.fast_min(b).fast_min(c), upper: a.fast_max(b).fast_max(c) }
}

/// A node over the items and all below it, the node first.
fn build_node(part: Part, depth: usize) -> Subtree {
    assert!(depth < MAX_DEPTH, "the tree is deeper than its bound");
    let count = part.items.len();
    let mut parts: Vec<Option<Part>> = split_in_four(part, depth).into_iter().map(Some).collect();
    let mut tree = Subtree { children: vec![[NO_CHILD; 4]], leaf_sizes: Vec::new() };
    let is_leaf = |part: &Option<Part>| part.as_ref().is_some_and(|part| part.items.len() <= LEAF_SIZE);
    let leaf_sizes: Vec<Option<usize>> = parts
        .iter()
        .map(|part| is_leaf(part).then(|| part.as_ref().map_or(0, |part| part.items.len())))
        .collect();
    let build_part = |part: &mut Option<Part>| {
        part.take_if(|part| part.items.len() > LEAF_SIZE).map(|part| build_node(part, depth + 1))
    };
    let below: Vec<Option<Subtree>> = if count > PARALLEL_SIZE {
        parts.par_iter_mut().map(build_part).collect()
    } else {
        parts.iter_mut().map(build_part).collect()
    };
    for (slot, (subtree, leaf_size)) in below.into_iter().zip(leaf_sizes).enumerate() {
        tree.children[0][slot] = match subtree {
            Some(subtree) => tree.append(subtree),
            None => tree.append_leaf(leaf_size.unwrap_or(0)),
        };
    }
    tree
}

impl Subtree {
    /// Appends a subtree behind this one and returns where its root is now.
    fn append(&mut self, mut other: Subtree) -> u32 {
        let (node_offset, block_offset) = (self.children.len() as u32, self.leaf_sizes.len() as u32);
        for child in other.children.iter_mut().flatten().filter(|child| **child != NO_CHILD) {
            *child += if *child & LEAF != 0 { block_offset } else { node_offset };
        }
        self.children.append(&mut other.children);
        self.leaf_sizes.append(&mut other.leaf_sizes);
        node_offset
    }

    fn append_leaf(&mut self, size: usize) -> u32 {
        self.leaf_sizes.push(size as u8);
        LEAF | (self.leaf_sizes.len() - 1) as u32
    }
}

/// Up to four parts: the part of the largest surface is split until there are four.
fn split_in_four(part: Part, depth: usize) -> Vec<Part> {
    let mut parts = vec![part];
    while parts.len() < 4 {
        let splittable = (0..parts.len()).filter(|&i| parts[i].items.len() > LEAF_SIZE);
        let Some(widest) = splittable.max_by(|&i, &j| {
            let by_count = parts[i].items.len().cmp(&parts[j].items.len());
            match depth < HALVING_DEPTH {
                true => parts[i].bounds.surface().total_cmp(&parts[j].bounds.surface()).then(by_count),
                false => by_count,
            }
        }) else {
            break;
        };
        let (left, right) = split(parts.remove(widest), depth);
        parts.insert(widest, right);
        parts.insert(widest, left);
    }
    parts
}

/// Reorders the items and cuts them in two.
fn split(part: Part, depth: usize) -> (Part, Part) {
    let axis = part.centres.widest_axis();
    if depth < HALVING_DEPTH
        && let Some(binning) = Binning::new(&part.centres, axis)
        && let Some(cut) = best_cut(part.items, &binning)
    {
        return part.cut(cut);
    }
    let middle = part.items.len() / 2;
    part.items.select_nth_unstable_by(middle, |a, b| {
        let centre = |item: &Item| item.bounds.centre().as_array()[axis];
        centre(a).total_cmp(&centre(b)).then(a.triangle.cmp(&b.triangle))
    });
    let (left, right) = part.items.split_at_mut(middle);
    (Part::of(left), Part::of(right))
}

/// A way to cut a part: how many items are on the left once they are sorted, and the boxes of both sides.
struct Cut {
    left: usize,
    /// Boxes of the items and of their centres, of the left and the right side.
    bounds: [[Bounds; 2]; 2],
}

/// Sorts the items to the two sides of the bin boundary of least surface times blocks of four.
fn best_cut(items: &mut [Item], binning: &Binning) -> Option<Cut> {
    let mut bins = [(Bounds::EMPTY, Bounds::EMPTY, 0usize); BINS];
    for item in items.iter() {
        let bin = &mut bins[binning.bin(item)];
        bin.0.grow(&item.bounds);
        bin.1.grow_by_point(item.bounds.centre());
        bin.2 += 1;
    }
    let from_left = sweep(bins.iter());
    let from_right = sweep(bins.iter().rev());
    let costs = (1..BINS).map(|cut| (from_left[cut - 1] + from_right[BINS - 1 - cut], cut));
    let (cost, cut) = costs.min_by(|a, b| a.0.total_cmp(&b.0))?;
    if !cost.is_finite() {
        return None;
    }
    let side = |bins: &[(Bounds, Bounds, usize)]| {
        let mut both = [Bounds::EMPTY; 2];
        bins.iter().for_each(|bin| {
            both[0].grow(&bin.0);
            both[1].grow(&bin.1);
        });
        both
    };
    let bounds = [side(&bins[..cut]), side(&bins[cut..])];
    Some(Cut { left: partition(items, |item| binning.bin(item) < cut), bounds })
}

/// Surface times blocks of four of the first 1, 2, ... bins.
fn sweep<'a>(bins: impl Iterator<Item = &'a (Bounds, Bounds, usize)>) -> [f32; BINS] {
    let mut costs = [0.0; BINS];
    let mut bounds = Bounds::EMPTY;
    let mut count = 0;
    for (cost, bin) in costs.iter_mut().zip(bins) {
        bounds.grow(&bin.0);
        count += bin.2;
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
    /// None where all centres are in one place.
    fn new(centres: &Bounds, axis: usize) -> Option<Binning> {
        let width = centres.width().as_array()[axis];
        let factor = BINS as f32 / width;
        factor.is_finite().then_some(Binning { axis, lower: centres.lower.as_array()[axis], factor })
    }

    #[inline]
    fn bin(&self, item: &Item) -> usize {
        let centre = item.bounds.centre().as_array()[self.axis];
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

impl<'a> Part<'a> {
    fn of(items: &'a mut [Item]) -> Part<'a> {
        let (mut bounds, mut centres) = (Bounds::EMPTY, Bounds::EMPTY);
        for item in items.iter() {
            bounds.grow(&item.bounds);
            centres.grow_by_point(item.bounds.centre());
        }
        Part { items, bounds, centres }
    }

    fn cut(self, cut: Cut) -> (Part<'a>, Part<'a>) {
        let (left, right) = self.items.split_at_mut(cut.left);
        let part = |items, [bounds, centres]: [Bounds; 2]| Part { items, bounds, centres };
        (part(left, cut.bounds[0]), part(right, cut.bounds[1]))
    }
}

impl Bounds {
    const EMPTY: Bounds =
        Bounds { lower: f32x4::new([f32::INFINITY; 4]), upper: f32x4::new([f32::NEG_INFINITY; 4]) };

    #[inline]
    fn grow(&mut self, other: &Bounds) {
        self.lower = self.lower.fast_min(other.lower);
        self.upper = self.upper.fast_max(other.upper);
    }

    #[inline]
    fn grow_by_point(&mut self, point: f32x4) {
        self.grow(&Bounds { lower: point, upper: point });
    }

    #[inline]
    fn centre(&self) -> f32x4 {
        (self.lower + self.upper) * f32x4::splat(0.5)
    }

    #[inline]
    fn width(&self) -> f32x4 {
        (self.upper - self.lower).fast_max(f32x4::ZERO)
    }

    /// Half the surface; 0 where empty.
    #[inline]
    fn surface(&self) -> f32 {
        let [x, y, z, _] = self.width().to_array();
        x * y + y * z + z * x
    }

    fn widest_axis(&self) -> usize {
        let width = self.width().to_array();
        (0..3).fold(0, |best, axis| if width[axis] > width[best] { axis } else { best })
    }
}
