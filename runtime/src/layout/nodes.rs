//! Numbers of the nodes of a sparse set of cells.
//!
//! The nodes belong to four families, each a lattice whose rows run along x: corners (i, j, k), and the pairs of
//! nodes on the edges that start at (i, j, k) along x, y or z. A node exists if a stored cell touches it. Nodes are
//! numbered family by family, in each by (k, j, i); the two of a pair are neighbours, the lower third first. So the
//! numbers follow from the cells alone and no connectivity is stored, and along a run of cells all 32 nodes of a
//! cell come from 12 places that advance evenly:
//!
//! ```text
//! corners  4 rows (dy, dz)  2 numbers each     y-edges  2 rows (dz)  4 numbers each
//! x-edges  4 rows (dy, dz)  2 numbers each     z-edges  2 rows (dy)  4 numbers each
//! ```

use crate::grid::Grid;
use glam::{DVec3, UVec3};
use volmap_formats::asset::CellRun;

/// Which lattice a node belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// One node at the corner (i, j, k).
    Corner,
    /// Two nodes on the edge from (i, j, k) along x.
    EdgeX,
    /// Two nodes on the edge from (i, j, k) along y.
    EdgeY,
    /// Two nodes on the edge from (i, j, k) along z.
    EdgeZ,
}

impl Family {
    /// All four, in the order of their numbers.
    pub const ALL: [Family; 4] = [Family::Corner, Family::EdgeX, Family::EdgeY, Family::EdgeZ];

    /// Nodes per lattice point.
    pub fn nodes_per_point(self) -> u32 {
        if self == Family::Corner { 1 } else { 2 }
    }

    /// Place of node `t` of a lattice point in units of cells, from the corner (i, j, k).
    pub fn offset(self, t: u32) -> DVec3 {
        let third = f64::from(t + 1) / 3.0;
        match self {
            Family::Corner => DVec3::ZERO,
            Family::EdgeX => DVec3::new(third, 0.0, 0.0),
            Family::EdgeY => DVec3::new(0.0, third, 0.0),
            Family::EdgeZ => DVec3::new(0.0, 0.0, third),
        }
    }

    /// Rows of the lattice that a row of cells touches, each with its entry in the bases of a run ([`Nodes::bases`]) and
    /// the steps on along y and z; and by how many points along x the lattice is longer than the cells.
    pub(super) fn rows_of_cell(self) -> (&'static [(usize, u32, u32)], u32) {
        match self {
            Family::Corner => (&[(0, 0, 0), (1, 1, 0), (2, 0, 1), (3, 1, 1)], 1),
            Family::EdgeX => (&[(4, 0, 0), (5, 1, 0), (6, 0, 1), (7, 1, 1)], 0),
            Family::EdgeY => (&[(8, 0, 0), (9, 0, 1)], 1),
            Family::EdgeZ => (&[(10, 0, 0), (11, 1, 0)], 1),
        }
    }

    /// Rows of cells (steps back along y and z) that touch a row of the lattice, and by how many points along x
    /// the lattice is longer than the cells.
    fn neighbours(self) -> (&'static [(u32, u32)], u32) {
        match self {
            Family::Corner => (&[(1, 1), (0, 1), (1, 0), (0, 0)], 1),
            Family::EdgeX => (&[(1, 1), (0, 1), (1, 0), (0, 0)], 0),
            Family::EdgeY => (&[(0, 1), (0, 0)], 1),
            Family::EdgeZ => (&[(1, 0), (0, 0)], 1),
        }
    }
}

/// Consecutive lattice points `first .. end` along x, and the number of the first node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeInterval {
    /// First lattice point.
    pub first: u32,
    /// One past the last.
    pub end: u32,
    /// Number of the first node.
    pub start: u32,
}

/// The nodes of one family, row by row.
#[derive(Clone, Debug)]
struct FamilyRows {
    rows_y: u32,
    /// Per row, first entry in `intervals`; one more at the end.
    row_start: Vec<u32>,
    intervals: Vec<NodeInterval>,
}

/// The numbering of all nodes of a set of cells.
#[derive(Clone, Debug)]
pub struct Nodes {
    families: [FamilyRows; 4],
    count: u32,
}

impl Nodes {
    /// Numbers the nodes of `runs`, which are sorted by (k, j, i), don't overlap and lie in the grid.
    /// `None` if there are 2^32 nodes or more.
    pub fn new(resolution: UVec3, runs: &[CellRun]) -> Option<Nodes> {
        let cell_rows = row_table(resolution, runs);
        let mut count = 0u32;
        let mut families = Vec::with_capacity(4);
        for family in Family::ALL {
            families.push(number_family(family, resolution, runs, &cell_rows, &mut count)?);
        }
        Some(Nodes { families: families.try_into().ok()?, count })
    }

    /// Number of nodes.
    pub fn count(&self) -> usize {
        self.count as usize
    }

    /// Number of nodes of a family.
    pub fn count_of(&self, family: Family) -> usize {
        let points = |it: &NodeInterval| (it.end - it.first) as usize;
        let per_point = family.nodes_per_point() as usize;
        per_point * self.families[family as usize].intervals.iter().map(points).sum::<usize>()
    }

    /// All intervals of a family: row (j, k) and interval, in the order of their numbers.
    pub fn intervals(&self, family: Family) -> impl Iterator<Item = (u32, u32, NodeInterval)> + '_ {
        let rows = &self.families[family as usize];
        rows.row_start.windows(2).enumerate().flat_map(move |(row, range)| {
            let (j, k) = (row as u32 % rows.rows_y, row as u32 / rows.rows_y);
            rows.intervals[range[0] as usize..range[1] as usize].iter().map(move |&it| (j, k, it))
        })
    }

    /// Where the nodes are, metres, in the order of their numbers.
    pub fn positions<'a>(&'a self, grid: &'a Grid) -> impl Iterator<Item = DVec3> + 'a {
        let of_family = move |family: Family| {
            self.intervals(family).flat_map(move |(j, k, interval)| {
                let points =
                    (interval.first..interval.end).map(move |i| DVec3::new(i.into(), j.into(), k.into()));
                points.flat_map(move |corner| {
                    let each = move |t| grid.origin + grid.cell_size * (corner + family.offset(t));
                    (0..family.nodes_per_point()).map(each)
                })
            })
        };
        Family::ALL.into_iter().flat_map(of_family)
    }

    /// Number of the first node of a lattice point, which must have one (panics otherwise).
    pub fn number(&self, family: Family, i: u32, j: u32, k: u32) -> u32 {
        self.families[family as usize].number(i, j, k, family.nodes_per_point())
    }

    /// The 12 places from which the nodes of the run's first cell are numbered.
    pub(super) fn bases(&self, run: CellRun) -> [u32; 12] {
        let at = |family: Family, dy: u32, dz: u32| {
            self.families[family as usize].number(run.i, run.j + dy, run.k + dz, family.nodes_per_point())
        };
        let quad = |family| [at(family, 0, 0), at(family, 1, 0), at(family, 0, 1), at(family, 1, 1)];
        let [c0, c1, c2, c3] = quad(Family::Corner);
        let [x0, x1, x2, x3] = quad(Family::EdgeX);
        let [y0, y1] = [at(Family::EdgeY, 0, 0), at(Family::EdgeY, 0, 1)];
        let [z0, z1] = [at(Family::EdgeZ, 0, 0), at(Family::EdgeZ, 1, 0)];
        [c0, c1, c2, c3, x0, x1, x2, x3, y0, y1, z0, z1]
    }
}

impl FamilyRows {
    fn number(&self, i: u32, j: u32, k: u32, per_point: u32) -> u32 {
        let row = (j + self.rows_y * k) as usize;
        let intervals = &self.intervals[self.row_start[row] as usize..self.row_start[row + 1] as usize];
        let interval = intervals[intervals.partition_point(|it| it.end <= i)];
        interval.start + (i - interval.first) * per_point
    }
}

/// Per row of cells, where its runs begin in `runs`; one more entry at the end.
pub(super) fn row_table(resolution: UVec3, runs: &[CellRun]) -> Vec<u32> {
    let rows = resolution.y as usize * resolution.z as usize;
    let mut table = vec![0; rows + 1];
    for run in runs {
        table[(run.j + resolution.y * run.k) as usize + 1] += 1;
    }
    for row in 0..rows {
        table[row + 1] += table[row];
    }
    table
}

fn number_family(
    family: Family,
    resolution: UVec3,
    runs: &[CellRun],
    cell_rows: &[u32],
    count: &mut u32,
) -> Option<FamilyRows> {
    let (neighbours, longer) = family.neighbours();
    let rows_y = resolution.y + u32::from(family != Family::EdgeY);
    let rows_z = resolution.z + u32::from(family != Family::EdgeZ);
    // To size: grown by doubling, the largest grid would take twice as much.
    let mut row_start = Vec::with_capacity(rows_y as usize * rows_z as usize + 1);
    row_start.push(0);
    let mut intervals = Vec::new();
    let mut touched: Vec<(u32, u32)> = Vec::new();
    for k in 0..rows_z {
        for j in 0..rows_y {
            touched.clear();
            for &(dy, dz) in neighbours {
                let (y, z) = (j.wrapping_sub(dy), k.wrapping_sub(dz));
                if y < resolution.y && z < resolution.z {
                    let row = (y + resolution.y * z) as usize;
                    let row_runs = &runs[cell_rows[row] as usize..cell_rows[row + 1] as usize];
                    touched.extend(row_runs.iter().map(|run| (run.i, run.i + run.len + longer)));
                }
            }
            merge_row(&mut touched, family.nodes_per_point(), &mut intervals, count)?;
            row_start.push(intervals.len() as u32);
        }
    }
    Some(FamilyRows { rows_y, row_start, intervals })
}

/// Appends the union of the ranges, numbered.
pub(super) fn merge_row(
    ranges: &mut [(u32, u32)],
    per_point: u32,
    intervals: &mut Vec<NodeInterval>,
    count: &mut u32,
) -> Option<()> {
    ranges.sort_unstable();
    let mut i = 0;
    while i < ranges.len() {
        let (first, mut end) = ranges[i];
        while i < ranges.len() && ranges[i].0 <= end {
            end = end.max(ranges[i].1);
            i += 1;
        }
        intervals.push(NodeInterval { first, end, start: *count });
        *count = count.checked_add((end - first).checked_mul(per_point)?)?;
    }
    Some(())
}
