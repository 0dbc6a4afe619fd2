//! From a point to the cell that holds it, one look-up a level: cells of level 0 by their rows, and for each cell that
//! holds finer ones a block of its eight children.

use super::rows::{Rows, parents};
use crate::layout::cells::{Found, Place, Starts};
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
    /// Rows of level 0 along y.
    rows_y: u32,
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

/// The cell that held the last point: the next one's, often.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TreeHint {
    /// That of level 0.
    cell: UVec3,
    /// Its part that the cell is.
    low: DVec3,
    high: DVec3,
    scale: f64,
    place: Place,
}

impl TreeHint {
    /// Fits no cell.
    pub const NONE: TreeHint =
        TreeHint { cell: UVec3::ZERO, low: DVec3::ZERO, high: DVec3::ZERO, scale: 1.0, place: Place::NONE };
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
    pub fn new(
        resolution: UVec3,
        levels: &[LevelCells],
        refined: &[Vec<CellRun>],
        runs: Vec<LeafRun>,
    ) -> Tree {
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
        let (row_start, roots) = root_rows(resolution, roots);
        Tree { rows_y: resolution.y, row_start, roots, blocks, runs }
    }

    /// Levels up to the finest one that has cells of the band, at least 1.
    pub fn levels(&self) -> u32 {
        self.runs.last().map_or(1, |run| run.level + 1)
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

    /// What holds a point of the domain: `cell` is that of level 0, `f` the place in it, which becomes that in the cell
    /// of the band.
    #[inline(always)]
    pub fn place(&self, cell: UVec3, f: &mut DVec3, hint: &mut TreeHint) -> Found {
        if cell == hint.cell && f.cmpge(hint.low).all() && f.cmplt(hint.high).all() {
            // Exact, as every step below is.
            *f = (*f - hint.low) * hint.scale;
            return Found::Band(hint.place);
        }
        let whole = *f;
        let found = self.descend(self.root(cell), cell.x, f);
        if let Found::Band(place) = found {
            let scale = self.scale(place);
            let low = whole - *f / scale;
            *hint = TreeHint { cell, low, high: low + 1.0 / scale, scale, place };
        }
        found
    }

    /// Entry of a cell of level 0.
    #[inline(always)]
    fn root(&self, cell: UVec3) -> u32 {
        let row = (cell.y + self.rows_y * cell.z) as usize;
        let roots = &self.roots[self.row_start[row] as usize..self.row_start[row + 1] as usize];
        match roots.get(roots.partition_point(|root| root.end <= cell.x)) {
            Some(root) if root.first > cell.x => FLUID,
            Some(root) if root.entry & BLOCK != 0 && root.entry < SOLID => root.entry + (cell.x - root.first),
            Some(root) => root.entry,
            None => FLUID,
        }
    }

    #[inline(always)]
    fn descend(&self, mut entry: u32, mut x: u32, f: &mut DVec3) -> Found {
        while entry & BLOCK != 0 {
            if entry >= SOLID {
                return if entry == SOLID { Found::Solid } else { Found::Fluid };
            }
            // Exact: doubling, and subtracting 1 from numbers of 1 to 2.
            *f *= 2.0;
            let upper = f.cmpge(DVec3::ONE);
            *f -= DVec3::select(upper, DVec3::ONE, DVec3::ZERO);
            x = 2 * x + (upper.bitmask() & 1);
            entry = self.blocks[(entry ^ BLOCK) as usize][upper.bitmask() as usize];
        }
        Found::Band(Place { run: entry, steps: x - self.runs[entry as usize].first })
    }

    #[inline(always)]
    pub fn starts(&self, place: Place) -> Starts {
        Starts::advanced(self.runs[place.run as usize].bases, place.steps)
    }

    /// Number of a cell of the band.
    #[inline(always)]
    pub fn cell(&self, place: Place) -> usize {
        (self.runs[place.run as usize].cell + place.steps) as usize
    }

    /// Cells of its level along the edge of one of level 0.
    #[inline(always)]
    pub fn scale(&self, place: Place) -> f64 {
        f64::from(1u32 << self.level(place))
    }

    /// Level of a cell of the band.
    #[inline(always)]
    pub fn level(&self, place: Place) -> u32 {
        self.runs[place.run as usize].level
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
