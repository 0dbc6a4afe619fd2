//! From a point to the cell that holds it, one look-up a level: cells of level 0 by their rows, and for each cell that
//! holds finer ones a block of its eight children.

use super::rows::{Rows, parents};
use crate::grid::Grid;
use crate::layout::cells::Starts;
use crate::layout::nodes::row_table;
use glam::{DVec3, UVec3};
use volmap_formats::asset::{CellRun, LevelCells};

/// Neither listed nor with finer cells.
const FLUID: u32 = u32::MAX;
const SOLID: u32 = u32::MAX - 1;
/// Of the number of a block of children; without it, that of a run of the band.
const BLOCK: u32 = 1 << 31;
/// Fewer runs and blocks than that.
pub(super) const MOST: usize = 1 << 30;

/// Finds cells.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    grid: Grid,
    /// Per row of level 0, first entry in `roots`; one more at the end.
    row_start: Vec<u32>,
    roots: Vec<Root>,
    /// What is in the children, dx + 2 dy + 4 dz.
    blocks: Vec<[u32; 8]>,
    runs: Vec<LeafRun>,
}

/// Consecutive cells of level 0 of one kind.
#[derive(Clone, Copy, Debug)]
struct Root {
    first: u32,
    end: u32,
    /// Of the first cell; the blocks of the next ones follow.
    entry: u32,
}

/// A run of the band's cells on the lattice of its level.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeafRun {
    pub first: u32,
    pub level: u32,
    /// Number of the first cell among all of the band.
    pub cell: u32,
    /// Where the numbers of its nodes start.
    pub bases: [u32; 12],
}

/// A cell of the band: its run and the cells before it there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Leaf {
    pub run: u32,
    pub steps: u32,
}

/// What holds a point.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Holder {
    /// The place in the cell, 0 to 1 along each axis.
    Band(Leaf, DVec3),
    Solid,
    Fluid,
}

/// The cells of each level that hold listed ones of finer levels.
pub(super) fn refined(levels: &[LevelCells]) -> Vec<Vec<CellRun>> {
    let mut all = vec![Vec::new(); levels.len()];
    for level in (0..levels.len().saturating_sub(1)).rev() {
        let finer = &levels[level + 1];
        all[level] = parents(finer.band.iter().chain(&finer.solid).chain(&all[level + 1]));
    }
    all
}

impl Tree {
    /// `refined` is that of the levels, which are checked; there are fewer than [`MOST`] of all.
    pub fn new(grid: Grid, levels: &[LevelCells], refined: &[Vec<CellRun>], runs: Vec<LeafRun>) -> Tree {
        let count = refined.iter().flatten().map(|run| run.len as usize).sum();
        let mut blocks = vec![[FLUID; 8]; count];
        let (mut run, mut block) = (0, 0);
        let mut roots = Vec::new();
        // Blocks of the level before: its refined cells, and the first block of each of their runs.
        let mut before: Option<(Rows, Vec<u32>)> = None;
        for (cells, refined) in levels.iter().zip(refined) {
            let mut own = Vec::with_capacity(refined.len());
            let mut put = |cells: &CellRun, entry: u32, growth: u32| match &before {
                Some((rows, first)) => put_children(&mut blocks, rows, first, cells, entry, growth),
                None => roots.push((*cells, entry)),
            };
            for cells in &cells.band {
                put(cells, run, 0);
                run += 1;
            }
            cells.solid.iter().for_each(|cells| put(cells, SOLID, 0));
            for cells in refined {
                own.push(block);
                put(cells, BLOCK | block, 1);
                block += cells.len;
            }
            before = Some((Rows::new(refined), own));
        }
        let (row_start, roots) = root_rows(grid.resolution, roots);
        Tree { grid, row_start, roots, blocks, runs }
    }

    pub fn runs(&self) -> &[LeafRun] {
        &self.runs
    }

    /// Bytes held in memory.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(self.row_start.as_slice())
            + size_of_val(self.roots.as_slice())
            + size_of_val(self.blocks.as_slice())
            + size_of_val(self.runs.as_slice())
    }

    /// What holds a point of the domain: `cell` is that of level 0, `f` the place in it.
    #[inline(always)]
    pub fn find(&self, cell: UVec3, f: DVec3) -> Holder {
        let row = (cell.y + self.grid.resolution.y * cell.z) as usize;
        let roots = &self.roots[self.row_start[row] as usize..self.row_start[row + 1] as usize];
        let root = match roots.get(roots.partition_point(|root| root.end <= cell.x)) {
            Some(root) if root.first <= cell.x => root,
            _ => return Holder::Fluid,
        };
        let entry = if root.entry & BLOCK == 0 || root.entry >= SOLID {
            root.entry
        } else {
            root.entry + (cell.x - root.first)
        };
        self.descend(entry, cell.x, f)
    }

    #[inline(always)]
    fn descend(&self, mut entry: u32, mut x: u32, mut f: DVec3) -> Holder {
        while entry & BLOCK != 0 {
            if entry >= SOLID {
                return if entry == SOLID { Holder::Solid } else { Holder::Fluid };
            }
            // Exact: doubling, and subtracting 1 from numbers of 1 to 2.
            f *= 2.0;
            let upper = f.cmpge(DVec3::ONE);
            f -= DVec3::select(upper, DVec3::ONE, DVec3::ZERO);
            x = 2 * x + (upper.bitmask() & 1);
            entry = self.blocks[(entry ^ BLOCK) as usize][upper.bitmask() as usize];
        }
        Holder::Band(Leaf { run: entry, steps: x - self.runs[entry as usize].first }, f)
    }

    #[inline(always)]
    pub fn starts(&self, leaf: Leaf) -> Starts {
        Starts::advanced(self.runs[leaf.run as usize].bases, leaf.steps)
    }
}

/// Enters a run of cells with its parents, whose rows and first blocks are given.
fn put_children(
    blocks: &mut [[u32; 8]],
    parents: &Rows,
    first: &[u32],
    cells: &CellRun,
    mut entry: u32,
    growth: u32,
) {
    let numbers = parents.find(cells.j / 2, cells.k / 2);
    let row = &parents.runs[numbers.clone()];
    let mut at = row.partition_point(|run| run.i + run.len <= cells.i / 2);
    for i in cells.i..cells.i + cells.len {
        if i / 2 >= row[at].i + row[at].len {
            at += 1;
        }
        let block = first[numbers.start + at] + (i / 2 - row[at].i);
        let child = i % 2 + 2 * (cells.j % 2) + 4 * (cells.k % 2);
        blocks[block as usize][child as usize] = entry;
        entry += growth;
    }
}

/// The runs of level 0 by rows.
fn root_rows(resolution: UVec3, mut cells: Vec<(CellRun, u32)>) -> (Vec<u32>, Vec<Root>) {
    cells.sort_by_key(|(run, _)| (run.k, run.j, run.i));
    let runs: Vec<CellRun> = cells.iter().map(|&(run, _)| run).collect();
    let root = |&(run, entry): &(CellRun, u32)| Root { first: run.i, end: run.i + run.len, entry };
    (row_table(resolution, &runs), cells.iter().map(root).collect())
}
