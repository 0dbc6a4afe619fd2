//! Numbers of the nodes of one level, as in a uniform map (`nodes.rs`), without a table of the lattice's rows.

use super::rows::{Rows, key};
use crate::layout::nodes::{Family, NodeInterval, merge_row};

/// The nodes of a level's cells.
pub(super) struct LevelNodes {
    /// Of the families in their order.
    pub families: [Vec<NodeRow>; 4],
    /// Where the numbers of each run's first cell start: [`crate::layout::Starts`].
    pub bases: Vec<[u32; 12]>,
    /// One past the number of the last corner.
    pub corners_end: u32,
    /// One past the last number.
    pub end: u32,
}

/// The nodes of a row of a family's lattice.
pub(super) struct NodeRow {
    pub j: u32,
    pub k: u32,
    pub intervals: Vec<NodeInterval>,
}

impl LevelNodes {
    /// Numbers from `start` on; `None` if they don't fit into 32 bits.
    pub fn new(rows: &Rows, start: u32) -> Option<LevelNodes> {
        let mut end = start;
        let mut bases = vec![[0; 12]; rows.runs.len()];
        let mut number =
            |family: Family| number_family(family, rows, &mut bases, &mut end).map(|it| (it, end));
        let (corners, corners_end) = number(Family::Corner)?;
        let [x, y, z] = [number(Family::EdgeX)?.0, number(Family::EdgeY)?.0, number(Family::EdgeZ)?.0];
        Some(LevelNodes { families: [corners, x, y, z], bases, corners_end, end })
    }
}

/// A row of cells that touches a row of a family's lattice.
struct Touch {
    lattice_row: u64,
    /// Entry of the bases of its runs.
    base: usize,
    /// Place of the cells' row among the rows.
    cells: usize,
}

fn number_family(
    family: Family,
    rows: &Rows,
    bases: &mut [[u32; 12]],
    count: &mut u32,
) -> Option<Vec<NodeRow>> {
    let (steps, longer) = family.rows_of_cell();
    let mut touches = Vec::with_capacity(rows.keys().len() * steps.len());
    for &(base, dy, dz) in steps {
        let touch = |(cells, &row): (usize, &u64)| Touch { lattice_row: row + key(dy, dz), base, cells };
        touches.extend(rows.keys().iter().enumerate().map(touch));
    }
    // Stable: it is fast where much is in order already.
    touches.sort_by_key(|touch| touch.lattice_row);
    let mut ranges = Vec::new();
    let mut out = Vec::new();
    for touches in touches.chunk_by(|a, b| a.lattice_row == b.lattice_row) {
        let row = touches[0].lattice_row;
        ranges.clear();
        for touch in touches {
            let runs = &rows.runs[rows.at(touch.cells)];
            ranges.extend(runs.iter().map(|run| (run.i, run.i + run.len + longer)));
        }
        let mut intervals = Vec::new();
        merge_row(&mut ranges, family.nodes_per_point(), &mut intervals, count)?;
        for touch in touches {
            let runs = rows.at(touch.cells);
            set_bases(family, &intervals, &rows.runs[runs.clone()], touch.base, &mut bases[runs]);
        }
        out.push(NodeRow { j: row as u32, k: (row >> 32) as u32, intervals });
    }
    Some(out)
}

fn set_bases(
    family: Family,
    intervals: &[NodeInterval],
    runs: &[volmap_formats::asset::CellRun],
    base: usize,
    bases: &mut [[u32; 12]],
) {
    let mut at = 0;
    for (run, bases) in runs.iter().zip(bases) {
        while intervals[at].end <= run.i {
            at += 1;
        }
        bases[base] = intervals[at].start + (run.i - intervals[at].first) * family.nodes_per_point();
    }
}
