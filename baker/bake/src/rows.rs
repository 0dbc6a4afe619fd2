//! Work on the nodes of a grid, row by row: the one outer level of parallelism.

use glam::DVec3;
use rayon::prelude::*;
use volmap_runtime::Grid;
use volmap_runtime::layout::{Family, NodeInterval, Nodes};

/// Consecutive nodes of one family along x: lattice points `(first .. end, j, k)`.
#[derive(Clone, Copy, Debug)]
pub struct NodeRow {
    /// Family of the nodes; edge families have two nodes a lattice point.
    pub family: Family,
    /// First lattice point.
    pub first: u32,
    /// One past the last.
    pub end: u32,
    /// Row along y.
    pub j: u32,
    /// Row along z.
    pub k: u32,
}

impl NodeRow {
    /// Positions of the row's nodes, in the order of their numbers.
    pub fn positions(self, grid: &Grid) -> impl Iterator<Item = DVec3> + '_ {
        let thirds = 0..self.family.nodes_per_point();
        (self.first..self.end).flat_map(move |i| thirds.clone().map(move |t| self.position(grid, i, t)))
    }

    /// Position of node `t` of lattice point i.
    pub fn position(&self, grid: &Grid, i: u32, t: u32) -> DVec3 {
        let corner = DVec3::new(i.into(), self.j.into(), self.k.into());
        grid.origin + grid.cell_size * (corner + self.family.offset(t))
    }

    /// Whether lattice point i is in the row.
    pub fn holds(&self, i: u32) -> bool {
        (self.first..self.end).contains(&i)
    }

    /// The values of lattice point i, which is in the row, of the row's.
    pub fn nodes_mut<'a>(&self, i: u32, values: &'a mut [f64]) -> &'a mut [f64] {
        let per_point = self.family.nodes_per_point() as usize;
        &mut values[(i - self.first) as usize * per_point..][..per_point]
    }
}

/// Calls `fill` for every row with the slice of values of its nodes, on all threads. Neighbouring rows often share
/// what `init` makes, which must change no value.
pub fn fill_rows<S>(
    nodes: &Nodes,
    init: impl Fn() -> S + Sync + Send,
    fill: impl Fn(&mut S, NodeRow, &mut [f64]) + Sync + Send,
) -> Vec<f64> {
    let mut values = vec![0.0; nodes.count()];
    let rows = rows_of(nodes, u32::MAX, &mut values).into_par_iter();
    rows.for_each_init(init, |state, (row, own)| fill(state, row, own));
    values
}

/// All rows of nodes, with their part of the values; cut at multiples of `longest` lattice points.
fn rows_of<'a>(nodes: &Nodes, longest: u32, values: &'a mut [f64]) -> Vec<(NodeRow, &'a mut [f64])> {
    let mut rest = values;
    let mut rows = Vec::new();
    for family in Family::ALL {
        for (j, k, interval) in nodes.intervals(family) {
            let mut first = interval.first;
            while first < interval.end {
                let end = interval.end.min((first / longest + 1).saturating_mul(longest));
                let length = (end - first) * family.nodes_per_point();
                let own = rest.split_off_mut(..length as usize).expect("the intervals hold all nodes");
                rows.push((NodeRow { family, first, end, j, k }, own));
                first = end;
            }
        }
    }
    rows
}

/// Rows of nodes of all families on the same lattice row that touch each other, with their values.
pub struct RowCluster<'a> {
    /// First lattice point of any.
    pub first: u32,
    /// One past the last.
    pub end: u32,
    /// Row along y.
    pub j: u32,
    /// Row along z.
    pub k: u32,
    /// The rows.
    pub rows: Vec<(NodeRow, &'a mut [f64])>,
}

/// Calls `fill` for every cluster of rows of up to `longest` lattice points, on all threads, with what `init` makes
/// once per thread or more often.
pub fn fill_clusters<S>(
    nodes: &Nodes,
    longest: u32,
    init: impl Fn() -> S + Sync + Send,
    fill: impl Fn(&mut S, &mut RowCluster) + Sync + Send,
) -> Vec<f64> {
    let mut values = vec![0.0; nodes.count()];
    let mut rows = rows_of(nodes, longest, &mut values);
    rows.sort_unstable_by_key(|(row, _)| (row.k, row.j, row.first, row.family as u32));
    let mut clusters: Vec<RowCluster> = Vec::new();
    for (row, own) in rows {
        match clusters.last_mut().filter(|c| {
            (c.k, c.j) == (row.k, row.j) && row.first <= c.end && row.first / longest == c.first / longest
        }) {
            Some(cluster) => {
                cluster.end = cluster.end.max(row.end);
                cluster.rows.push((row, own));
            }
            None => {
                let NodeRow { first, end, j, k, .. } = row;
                clusters.push(RowCluster { first, end, j, k, rows: vec![(row, own)] });
            }
        }
    }
    clusters.into_par_iter().for_each_init(init, |state, mut cluster| fill(state, &mut cluster));
    values
}

/// Positions of all nodes, in the order of their numbers; metres.
pub fn positions<'a>(nodes: &'a Nodes, grid: &'a Grid) -> impl Iterator<Item = DVec3> + 'a {
    let rows = |family: Family| {
        let row = move |(j, k, it): (u32, u32, NodeInterval)| NodeRow {
            family,
            first: it.first,
            end: it.end,
            j,
            k,
        };
        nodes.intervals(family).map(row)
    };
    Family::ALL.into_iter().flat_map(rows).flat_map(|row| row.positions(grid))
}
