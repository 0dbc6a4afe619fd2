//! Bounding volume hierarchy over triangles, for the closest triangle.
//!
//! Four children a node, each a cache line with a box in single precision that is turned along the surface
//! (`oriented_box`); up to four triangles a leaf, in single and double precision. Points that lie close together search
//! together (`packet`). `bvh_build` builds the tree, `bvh_query` searches it. Boxes are enlarged and search radii are
//! rounded up by more than they can err, so that single precision costs a few visits, never a wrong answer.

use std::sync::Arc;

use crate::sdf::closest_point::TriangleBlock;
use crate::sdf::coarse_block::CoarseBlock;
use crate::sdf::frame::Frame;
use crate::sdf::oriented_box::OrientedBox;

/// Marks a child that is a leaf; the other bits are the index of its block.
pub(crate) const LEAF: u32 = 1 << 31;
/// Levels of nodes at most, which `bvh_build` guarantees.
pub(crate) const MAX_DEPTH: usize = 40;
/// Instead of a child.
pub(crate) const NO_CHILD: u32 = u32::MAX;

/// A part of the tree.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Child {
    pub bounds: OrientedBox,
    /// Index of a node, or of a block with `LEAF`, or `NO_CHILD`.
    pub child: u32,
}

/// Four parts.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub children: [Child; 4],
}

/// Up to four triangles each.
#[derive(Clone, Debug)]
pub(crate) struct Leaves {
    pub blocks: Vec<TriangleBlock>,
    /// The same in single precision.
    pub coarse: Vec<CoarseBlock>,
    /// Index in the mesh of each block's triangles.
    pub ids: Vec<[u32; 4]>,
}

/// The tree. Its frame is centred on the mesh and scaled to about unit size.
#[derive(Clone, Debug)]
pub struct Bvh {
    pub(crate) nodes: Vec<Node>,
    /// Those of the tree as it was built come first, in the order of the nodes. The tree of a union has the same, and
    /// some of its own after them.
    pub(crate) leaves: Arc<Leaves>,
    /// How many of them come first.
    pub(crate) built: usize,
    /// For each node and child, the blocks below it, first and past the last; both 0 where there is no child. Empty in
    /// the tree of a union, whose blocks lie in no order.
    pub(crate) ranges: Vec<[(u32, u32); 4]>,
    pub(crate) frame: Frame,
}

impl Bvh {
    /// Numbers of the tree's blocks.
    pub(crate) fn block_numbers(&self) -> impl Iterator<Item = usize> + '_ {
        let children = self.nodes.iter().flat_map(|node| &node.children).map(|child| child.child);
        children.filter(|&child| child != NO_CHILD && child & LEAF != 0).map(|leaf| (leaf & !LEAF) as usize)
    }
}
