//! Runs of cells by rows, of which only those are kept that have some: the lattices of fine levels are huge.

use std::ops::Range;
use volmap_formats::asset::CellRun;

/// The rows of a sorted list of runs.
pub(super) struct Rows<'a> {
    pub runs: &'a [CellRun],
    /// Of the rows that have runs, ascending.
    keys: Vec<u64>,
    /// Where each row begins in `runs`; one more at the end.
    starts: Vec<u32>,
}

/// Rows in their order: by k, then j.
pub(super) fn key(j: u32, k: u32) -> u64 {
    u64::from(k) << 32 | u64::from(j)
}

impl<'a> Rows<'a> {
    pub fn new(runs: &'a [CellRun]) -> Rows<'a> {
        let (mut keys, mut starts) = (Vec::new(), Vec::new());
        for (number, run) in runs.iter().enumerate() {
            let key = key(run.j, run.k);
            if keys.last() != Some(&key) {
                keys.push(key);
                starts.push(number as u32);
            }
        }
        starts.push(runs.len() as u32);
        Rows { runs, keys, starts }
    }

    pub fn keys(&self) -> &[u64] {
        &self.keys
    }

    /// The runs of the row at a place of [`Rows::keys`], by their numbers.
    pub fn at(&self, place: usize) -> Range<usize> {
        self.starts[place] as usize..self.starts[place + 1] as usize
    }

    /// The runs of a row, by their numbers; none if the row has none.
    pub fn find(&self, j: u32, k: u32) -> Range<usize> {
        self.keys.binary_search(&key(j, k)).map_or(0..0, |place| self.at(place))
    }

    /// The first run of a row that holds a cell of `range`.
    pub fn overlap(&self, j: u32, k: u32, range: Range<u32>) -> Option<&'a CellRun> {
        let row = &self.runs[self.find(j, k)];
        let next = row.get(row.partition_point(|run| run.i + run.len <= range.start))?;
        (next.i < range.end).then_some(next)
    }
}

/// Sorts runs and joins those that meet or overlap.
pub(super) fn union(mut runs: Vec<CellRun>) -> Vec<CellRun> {
    // Stable: it is fast where much is in order already.
    runs.sort_by_key(|run| (key(run.j, run.k), run.i));
    runs.dedup_by(|next, run| {
        let same = (run.j, run.k) == (next.j, next.k) && next.i <= run.i + run.len;
        if same {
            run.len = run.len.max(next.i + next.len - run.i);
        }
        same
    });
    runs
}

/// The cells of the next coarser level that hold those of the runs.
pub(super) fn parents<'a>(runs: impl IntoIterator<Item = &'a CellRun>) -> Vec<CellRun> {
    let parent = |run: &CellRun| {
        let i = run.i / 2;
        CellRun { i, j: run.j / 2, k: run.k / 2, len: (run.i + run.len).div_ceil(2) - i }
    };
    let mut out: Vec<CellRun> = Vec::new();
    for run in runs {
        let parent = parent(run);
        if out.last() != Some(&parent) {
            out.push(parent);
        }
    }
    union(out)
}
