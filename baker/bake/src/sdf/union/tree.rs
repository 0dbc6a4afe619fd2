//! The tree of the union's surface: that of all triangles, changed where few are replaced. What is left of a triangle
//! lies inside of it, and so inside all boxes around it.

use glam::DVec3;
use std::sync::Arc;

use super::UnionSurface;
use crate::sdf::bvh::{Bvh, Child, LEAF, Leaves, NO_CHILD, Node};
use crate::sdf::bvh_build::LEAF_SIZE;
use crate::sdf::closest_point::TriangleBlock;
use crate::sdf::coarse_block::CoarseBlock;
use crate::sdf::frame::Frame;
use crate::sdf::oriented_box::OrientedBox;

/// Above this part of the leaves, or with more in one place than a node of leaves holds, a new tree is better.
const MOST_CHANGED: f64 = 0.125;
const MOST_IN_A_LEAF: usize = 4 * LEAF_SIZE;

/// A triangle or a piece of one, and its number in the mesh.
type Numbered = ([DVec3; 3], u32);

/// The tree of what is left, whose numbers are those of the mesh's triangles. It shares the leaves of `bvh`, to which
/// its own are added.
pub fn tree_of_union(bvh: &mut Bvh, corners: &[[DVec3; 3]], surface: &UnionSurface) -> Bvh {
    let changed = changed_leaves(bvh, corners, surface);
    let is_small = |(_, left): &(usize, Vec<Numbered>)| left.len() <= MOST_IN_A_LEAF;
    if changed.len() as f64 > MOST_CHANGED * bvh.built as f64 || !changed.iter().all(is_small) {
        return new_tree(corners, surface);
    }
    let mut parents = vec![(0, 0); bvh.built];
    for (index, node) in bvh.nodes.iter().enumerate() {
        for (slot, child) in node.children.iter().enumerate() {
            if child.child != NO_CHILD && child.child & LEAF != 0 {
                parents[(child.child & !LEAF) as usize] = (index, slot);
            }
        }
    }
    let spare = surface.triangles(corners).next().expect("most triangles are kept");
    let (frame, leaves, mut nodes) = (bvh.frame, Arc::make_mut(&mut bvh.leaves), bvh.nodes.clone());
    for (block, left) in changed {
        let (node, slot) = parents[block];
        match left.len() {
            // Children of a node leave no gaps: a triangle that is kept elsewhere, once more.
            0 => nodes[node].children[slot] = leaf(leaves, &[spare], &frame),
            1..=LEAF_SIZE => nodes[node].children[slot].child = leaf(leaves, &left, &frame).child,
            _ => {
                let added = node_of(leaves, &left, &frame);
                nodes[node].children[slot].child = nodes.len() as u32;
                nodes.push(added);
            }
        }
    }
    Bvh { nodes, leaves: bvh.leaves.clone(), built: bvh.built, ranges: Vec::new(), frame }
}

/// Leaves with replaced triangles, and all that is left in each.
fn changed_leaves(bvh: &Bvh, corners: &[[DVec3; 3]], surface: &UnionSurface) -> Vec<(usize, Vec<Numbered>)> {
    let mut is_replaced = vec![false; corners.len()];
    surface.replaced.iter().for_each(|(triangle, _)| is_replaced[*triangle as usize] = true);
    let is_changed = |(_, ids): &(usize, &[u32; 4])| ids.iter().any(|&id| is_replaced[id as usize]);
    let left = |ids: &[u32; 4]| {
        let mut ids = ids.to_vec();
        ids.dedup();
        ids.iter().flat_map(|&id| left_of(id, corners, surface)).collect()
    };
    bvh.leaves.ids.iter().enumerate().filter(is_changed).map(|(block, ids)| (block, left(ids))).collect()
}

fn left_of(id: u32, corners: &[[DVec3; 3]], surface: &UnionSurface) -> Vec<Numbered> {
    match surface.replaced.binary_search_by_key(&id, |(triangle, _)| *triangle) {
        Ok(at) => surface.replaced[at].1.iter().map(|piece| (*piece, id)).collect(),
        Err(_) => vec![(corners[id as usize], id)],
    }
}

fn new_tree(corners: &[[DVec3; 3]], surface: &UnionSurface) -> Bvh {
    let (triangles, ids): (Vec<[DVec3; 3]>, Vec<u32>) = surface.triangles(corners).unzip();
    let mut tree = Bvh::new(&triangles);
    let numbers = &mut Arc::make_mut(&mut tree.leaves).ids;
    numbers.iter_mut().flatten().for_each(|id| *id = ids[*id as usize]);
    tree
}

/// A new leaf of one to four triangles.
fn leaf(leaves: &mut Leaves, left: &[Numbered], frame: &Frame) -> Child {
    let corners: Vec<[DVec3; 3]> = left.iter().map(|(corners, _)| *corners).collect();
    let block = TriangleBlock::new(&corners);
    let id = |lane: usize| left[lane.min(left.len() - 1)].1;
    let number = leaves.blocks.len() as u32;
    leaves.coarse.push(CoarseBlock::new(&block, left.len(), frame));
    leaves.ids.push([id(0), id(1), id(2), id(3)]);
    leaves.blocks.push(block);
    let bounds = OrientedBox::around(&leaves.blocks[number as usize..], frame);
    Child { bounds, child: number | LEAF }
}

/// A node of new leaves.
fn node_of(leaves: &mut Leaves, left: &[Numbered], frame: &Frame) -> Node {
    let mut children = [Child { bounds: OrientedBox::NONE, child: NO_CHILD }; 4];
    for (child, left) in children.iter_mut().zip(left.chunks(LEAF_SIZE)) {
        *child = leaf(leaves, left, frame);
    }
    Node { children }
}
