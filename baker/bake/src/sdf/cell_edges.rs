//! The edges of the band's cells by their nodes: lines along which the distance is followed.

use volmap_runtime::layout::{Family, Nodes};

/// The families of inner nodes, and the axes along which their edges run.
pub const FAMILIES: [(Family, usize); 3] = [(Family::EdgeX, 0), (Family::EdgeY, 1), (Family::EdgeZ, 2)];

/// A cell's edge.
pub struct CellEdge {
    /// Lattice point of its lower end.
    pub corner: [u32; 3],
    /// Node of its lower end.
    pub lower: u32,
    /// The first of its two inner nodes.
    pub third: u32,
    /// Node of its upper end.
    pub upper: u32,
}

/// Calls for all edges along an axis, row by row.
#[inline]
pub fn for_each_edge(nodes: &Nodes, family: Family, axis: usize, mut call: impl FnMut(CellEdge)) {
    let step = [(1, 0, 0), (0, 1, 0), (0, 0, 1)][axis];
    for (j, k, interval) in nodes.intervals(family) {
        let lower = nodes.number(Family::Corner, interval.first, j, k);
        let upper = nodes.number(Family::Corner, interval.first + step.0, j + step.1, k + step.2);
        for i in 0..interval.end - interval.first {
            let third = interval.start + 2 * i;
            call(CellEdge { corner: [interval.first + i, j, k], lower: lower + i, third, upper: upper + i });
        }
    }
}
