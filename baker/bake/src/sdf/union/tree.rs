//! The tree of the union's surface: that of all triangles, changed where few are replaced. What is left of a triangle
//! lies inside of it, and so inside all boxes around it.

use glam::DVec3;

use super::UnionSurface;
use crate::sdf::bvh::{Bvh, Child, LEAF, NO_CHILD, Node};
use crate::sdf::bvh_build::LEAF_SIZE;
use crate::sdf::closest_point::TriangleBlock;
use crate::sdf::coarse_block::CoarseBlock;
use crate::sdf::oriented_box::OrientedBox;

/// Above this part of the leaves, or with more in one place than a node of leaves holds, a new tree is better.
const MOST_CHANGED: f64 = 0.125;
const MOST_IN_A_LEAF: usize = 4 * LEAF_SIZE;

/// A triangle or a piece of one, and its number in the mesh.
type Numbered = ([DVec3; 3], u32);

/// The tree of what is left, whose numbers are those of the mesh's triangles.
pub fn tree_of_union(bvh: &Bvh, corners: &[[DVec3; 3]], surface: &UnionSurface) -> Bvh {
    let changed = changed_leaves(bvh, corners, surface);
    let is_small = |(_, left): &(usize, Vec<Numbered>)| left.len() <= MOST_IN_A_LEAF;
    if changed.len() as f64 > MOST_CHANGED * bvh.blocks.len() as f64 || !changed.iter().all(is_small) {
        return new_tree(corners, surface);
    }
    let mut tree = bvh.clone();
    let mut parents = vec![(0, 0); bvh.blocks.len()];
    for (index, node) in bvh.nodes.iter().enumerate() {
        for (slot, child) in node.children.iter().enumerate() {
            if child.child != NO_CHILD && child.child & LEAF != 0 {
                parents[(child.child & !LEAF) as usize] = (index, slot);
            }
        }
    }
    let spare = surface.triangles(corners).next().expect("most triangles are kept");
    for (block, left) in changed {
        let (node, slot) = parents[block];
        match left.len() {
            0 => {
                // Children of a node leave no gaps: a triangle that is kept elsewhere, once more.
                set_block(&mut tree, block, &[spare]);
                let bounds = OrientedBox::around(&tree.blocks[block..=block], &tree.frame);
                tree.nodes[node].children[slot].bounds = bounds;
            }
            1..=LEAF_SIZE => set_block(&mut tree, block, &left),
            _ => tree.nodes[node].children[slot].child = add_node(&mut tree, block, &left),
        }
    }
    tree
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
    bvh.ids.iter().enumerate().filter(is_changed).map(|(block, ids)| (block, left(ids))).collect()
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
    tree.ids.iter_mut().flatten().for_each(|id| *id = ids[*id as usize]);
    tree
}

fn set_block(tree: &mut Bvh, block: usize, left: &[Numbered]) {
    let corners: Vec<[DVec3; 3]> = left.iter().map(|(corners, _)| *corners).collect();
    let made = TriangleBlock::new(&corners);
    let coarse = CoarseBlock::new(&made, left.len(), &tree.frame);
    let id = |lane: usize| left[lane.min(left.len() - 1)].1;
    let ids = [id(0), id(1), id(2), id(3)];
    if block == tree.blocks.len() {
        tree.blocks.push(made);
        tree.coarse.push(coarse);
        tree.ids.push(ids);
    } else {
        (tree.blocks[block], tree.coarse[block], tree.ids[block]) = (made, coarse, ids);
    }
}

/// A node of leaves in the place of a leaf: what a child says of it.
fn add_node(tree: &mut Bvh, block: usize, left: &[Numbered]) -> u32 {
    let none = Child { bounds: OrientedBox::NONE, child: NO_CHILD };
    let mut children = [none; 4];
    let mut ranges = [(0, 0); 4];
    for (slot, left) in left.chunks(LEAF_SIZE).enumerate() {
        let at = if slot == 0 { block } else { tree.blocks.len() };
        set_block(tree, at, left);
        let bounds = OrientedBox::around(&tree.blocks[at..=at], &tree.frame);
        children[slot] = Child { bounds, child: at as u32 | LEAF };
        ranges[slot] = (at as u32, at as u32 + 1);
    }
    tree.nodes.push(Node { children });
    tree.ranges.push(ranges);
    tree.nodes.len() as u32 - 1
}
