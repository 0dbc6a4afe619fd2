//! Work on the nodes of a grid, row by row: the one outer level of parallelism.

use glam::DVec3;
use rayon::prelude::*;
use volmap_runtime::{Family, Grid, NodeInterval, Nodes};

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
        (self.first..self.end).flat_map(move |i| {
            let corner = DVec3::new(i.into(), self.j.into(), self.k.into());
            (0..self.family.nodes_per_point())
                .map(move |t| grid.origin + grid.cell_size * (corner + self.family.offset(t)))
        })
    }
}

/// Calls `fill` for every row with the slice of values of its nodes, on all threads.
pub fn fill_rows(nodes: &Nodes, fill: impl Fn(NodeRow, &mut [f64]) + Sync) -> Vec<f64> {
    let mut values = vec![0.0; nodes.count()];
    let mut rest = values.as_mut_slice();
    let mut tasks = Vec::new();
    for family in Family::ALL {
        for (j, k, interval) in nodes.intervals(family) {
            let row = NodeRow { family, first: interval.first, end: interval.end, j, k };
            let length = (row.end - row.first) * family.nodes_per_point();
            let (own, others) = rest.split_at_mut(length as usize);
            rest = others;
            tasks.push((row, own));
        }
    }
    tasks.into_par_iter().for_each(|(row, own)| fill(row, own));
    values
}

/// Positions of all nodes, in the order of their numbers; metres.
pub fn positions(nodes: &Nodes, grid: &Grid) -> Vec<DVec3> {
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
    Family::ALL.into_iter().flat_map(rows).flat_map(|row| row.positions(grid)).collect()
}
