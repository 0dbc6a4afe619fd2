//! From a cell to the numbers of its nodes, in a sparse grid.

use super::nodes::{Nodes, row_table};
use super::serendipity::NODES;
use glam::UVec3;
use std::ops::Range;
use volmap_formats::asset::CellRun;

/// What is known of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    /// Stored: these are its nodes.
    Band(NodeNumbers),
    /// Not stored: deeper in the solid than the band.
    Solid,
    /// Not stored: farther from the solid than the band.
    Fluid,
}

/// The numbers of a cell's 32 nodes, in the order of [`serendipity`](super::serendipity).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeNumbers {
    bases: [u32; 12],
    steps: u32,
    cell: u32,
}

impl NodeNumbers {
    /// Number of the cell among the stored ones, by (k, j, i).
    pub fn cell(&self) -> usize {
        self.cell as usize
    }

    /// The numbers of the cell `steps` cells further in the same run.
    pub fn along(self, steps: u32) -> NodeNumbers {
        NodeNumbers { steps: self.steps + steps, cell: self.cell + steps, ..self }
    }

    /// The 32 numbers, each with what it grows by from a cell of the run to the next.
    pub fn places(&self) -> [(u32, u32); NODES] {
        let numbers = self.all();
        std::array::from_fn(|a| (numbers[a], if a < 8 { 1 } else { 2 }))
    }

    /// All 32 numbers.
    pub fn all(&self) -> [u32; NODES] {
        Starts::advanced(self.bases, self.steps).all()
    }
}

/// A stored cell: its run and the cells before it there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    pub(super) run: u32,
    pub(super) steps: u32,
}

impl Place {
    /// No cell's.
    pub const NONE: Place = Place { run: SOLID, steps: 0 };
}

/// [`Cell`] as the queries want it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Found {
    Band(Place),
    Solid,
    Fluid,
}

/// The run of the last answer: the next point's, often.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hint {
    row: usize,
    run: Run,
}

/// Where the nodes of a cell are, 12 places: two corners (lower and upper x) at each of the rows (dy, dz) = (0, 0),
/// (1, 0), (0, 1), (1, 1); the x-edges of the same rows; four numbers of y-edges (lower x, then upper x) for each dz;
/// the same of z-edges for each dy.
pub(crate) struct Starts(pub [u32; 12]);

impl Starts {
    /// Those of the cell `steps` cells further in the same run.
    #[inline(always)]
    pub fn advanced(mut bases: [u32; 12], steps: u32) -> Starts {
        const ADVANCE: [u32; 12] = [1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 2, 2];
        for (start, advance) in bases.iter_mut().zip(ADVANCE) {
            *start += advance * steps;
        }
        Starts(bases)
    }

    /// The numbers of all nodes of the cell.
    pub fn all(&self) -> [u32; NODES] {
        let mut out = [0; NODES];
        for row in 0..4 {
            for t in 0..2 {
                out[2 * row + t] = self.0[row] + t as u32;
                out[8 + 2 * row + t] = self.0[4 + row] + t as u32;
            }
            // y-edges at dz = 0, 1, then z-edges at dy = 0, 1: four consecutive numbers each.
            for n in 0..4 {
                out[16 + 4 * row + n] = self.0[8 + row] + n as u32;
            }
        }
        out
    }
}

/// Consecutive cells of one kind.
#[derive(Clone, Copy, Debug)]
struct Run {
    first: u32,
    end: u32,
    /// Entry in `bases`, or [`SOLID`].
    bases: u32,
}

const SOLID: u32 = u32::MAX;

impl RunBases {
    fn numbers(&self, steps: u32) -> NodeNumbers {
        NodeNumbers { bases: self.nodes, steps, cell: self.cell + steps }
    }
}

/// Finds cells; memory in proportion to the rows of the grid and the runs of the band.
#[derive(Clone, Debug)]
pub struct CellIndex {
    resolution: UVec3,
    row_start: Vec<u32>,
    runs: Vec<Run>,
    bases: Vec<RunBases>,
    /// Stored cells.
    count: u32,
}

/// Where the numbers of a run's first cell start.
#[derive(Clone, Copy, Debug)]
struct RunBases {
    nodes: [u32; 12],
    cell: u32,
}

impl CellIndex {
    /// An index of the band's cells and the solid's; both sorted by (k, j, i), disjoint and in the grid.
    pub fn new(resolution: UVec3, band: &[CellRun], solid: &[CellRun], nodes: &Nodes) -> CellIndex {
        let band_rows = row_table(resolution, band);
        let solid_rows = row_table(resolution, solid);
        let mut runs = Vec::with_capacity(band.len() + solid.len());
        let mut row_start = Vec::with_capacity(band_rows.len());
        row_start.push(0);
        for row in 0..band_rows.len() - 1 {
            let begin = runs.len();
            let range = |table: &[u32]| table[row] as usize..table[row + 1] as usize;
            for number in range(&band_rows) {
                let run = band[number];
                runs.push(Run { first: run.i, end: run.i + run.len, bases: number as u32 });
            }
            for run in &solid[range(&solid_rows)] {
                runs.push(Run { first: run.i, end: run.i + run.len, bases: SOLID });
            }
            runs[begin..].sort_unstable_by_key(|run| run.first);
            row_start.push(runs.len() as u32);
        }
        let mut cell = 0;
        let numbered = |run: &CellRun| {
            let bases = RunBases { nodes: nodes.bases(*run), cell };
            cell += run.len;
            bases
        };
        let bases = band.iter().map(numbered).collect();
        CellIndex { resolution, row_start, runs, bases, count: cell }
    }

    /// Every stored cell, by its number.
    pub fn stored(&self) -> impl Iterator<Item = NodeNumbers> + '_ {
        let end = |at: usize| self.bases.get(at + 1).map_or(self.count, |next| next.cell);
        let cells = move |(at, bases): (usize, &RunBases)| {
            let bases = *bases;
            (0..end(at) - bases.cell).map(move |steps| bases.numbers(steps))
        };
        self.bases.iter().enumerate().flat_map(cells)
    }

    /// Bytes held in memory.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(self.row_start.as_slice())
            + size_of_val(self.runs.as_slice())
            + size_of_val(self.bases.as_slice())
    }

    /// The runs of cells in row (y, z) that end behind `first`: their range along x, and what their first cell is.
    pub fn runs_from(&self, first: u32, y: u32, z: u32) -> impl Iterator<Item = (Range<u32>, Cell)> + '_ {
        let row = (y + self.resolution.y * z) as usize;
        let runs = &self.runs[self.row_start[row] as usize..self.row_start[row + 1] as usize];
        let from = runs.partition_point(|run| run.end <= first);
        runs[from..].iter().map(|run| {
            let cell = match run.bases {
                SOLID => Cell::Solid,
                at => Cell::Band(self.bases[at as usize].numbers(0)),
            };
            (run.first..run.end, cell)
        })
    }

    /// A hint that fits no cell.
    pub(crate) fn hint(&self) -> Hint {
        Hint { row: usize::MAX, run: Run { first: 0, end: 0, bases: SOLID } }
    }

    /// What is known of a cell of the grid.
    #[inline(always)]
    pub(crate) fn place(&self, cell: UVec3, hint: &mut Hint) -> Found {
        let row = (cell.y + self.resolution.y * cell.z) as usize;
        if hint.row != row || cell.x < hint.run.first || cell.x >= hint.run.end {
            let runs = &self.runs[self.row_start[row] as usize..self.row_start[row + 1] as usize];
            match runs.get(runs.partition_point(|run| run.end <= cell.x)) {
                Some(run) if run.first <= cell.x => *hint = Hint { row, run: *run },
                _ => return Found::Fluid,
            }
        }
        match hint.run.bases {
            SOLID => Found::Solid,
            run => Found::Band(Place { run, steps: cell.x - hint.run.first }),
        }
    }

    #[inline(always)]
    pub(crate) fn starts(&self, place: Place) -> Starts {
        Starts::advanced(self.bases[place.run as usize].nodes, place.steps)
    }

    /// What is known of a cell of the grid.
    pub fn find(&self, cell: UVec3) -> Cell {
        let row = (cell.y + self.resolution.y * cell.z) as usize;
        let runs = &self.runs[self.row_start[row] as usize..self.row_start[row + 1] as usize];
        match runs.get(runs.partition_point(|run| run.end <= cell.x)) {
            Some(run) if run.first <= cell.x => match run.bases {
                SOLID => Cell::Solid,
                at => Cell::Band(self.bases[at as usize].numbers(cell.x - run.first)),
            },
            _ => Cell::Fluid,
        }
    }
}
