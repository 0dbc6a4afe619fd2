//! What a thread works with: tables, and room for the sums of a block.

use super::Quad;
use super::lists::Lists;
use super::table::{Numbers, Quads};
use std::cell::RefCell;

/// Tables and room, used again for every block.
#[derive(Default)]
pub(crate) struct Workspace {
    /// What is summed, if it is vectors.
    pub vectors: Quads,
    /// Where it is, if that is asked for.
    pub places: Quads,
    /// What is summed, if it is numbers.
    pub numbers: Numbers,
    /// Sums of a block, with room for one particle that isn't there.
    pub sums: Vec<Quad>,
    /// Sums that are numbers.
    pub fluxes: Vec<f32>,
    /// Sums over differences of velocities.
    pub differences: Vec<[f32; 3]>,
}

thread_local! {
    static WORKSPACE: RefCell<Workspace> = RefCell::default();
}

/// Does what can be done with a block's pairs, in this thread's room.
#[inline]
pub(crate) fn work<T>(lists: &Lists, f: impl FnOnce(&mut Workspace) -> T) -> T {
    with(|workspace| {
        workspace.sums.resize(workspace.sums.len().max(lists.len() + 1), [0.0; 4]);
        workspace.fluxes.resize(workspace.sums.len(), 0.0);
        workspace.differences.resize(workspace.sums.len(), [0.0; 3]);
        f(workspace)
    })
}

/// The same before a block has pairs.
#[inline]
pub(crate) fn with<T>(f: impl FnOnce(&mut Workspace) -> T) -> T {
    WORKSPACE.with_borrow_mut(f)
}
