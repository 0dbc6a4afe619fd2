//! Nodes that lie on a cell of the next coarser level: they have its values, so that the map is continuous.
//!
//! The element's space is closed under scaling along the axes, and so is that of its face (12 nodes) and edge (4). So
//! where all nodes of a finer cell's face have the values of the coarser cell's polynomial, the whole face has.
//! Lengths here are sixths of the coarser cell, thirds of the finer one: all nodes have whole coordinates.

use super::number::{LevelNodes, NodeRow};
use super::rows::Rows;
use crate::layout::nodes::{Family, NodeInterval};
use crate::layout::serendipity;
use glam::DVec3;
use std::sync::LazyLock;

/// A node whose values are those of a cell of the next coarser level.
#[derive(Clone, Copy, Debug)]
pub(super) struct Constrained {
    /// Number of the node.
    pub node: u32,
    /// The cell: its run among those of its level, and the cells before it there.
    pub run: u32,
    pub steps: u32,
    /// Where in the cell, along x, y and z, 0 to 6.
    pub sixths: [u8; 3],
}

/// The constrained nodes of a level, ascending; `coarse` are the band's cells of the level before.
pub(super) fn constrained(nodes: &LevelNodes, coarse: &Rows) -> Vec<Constrained> {
    let mut out = Vec::new();
    let mut owners = Vec::new();
    for (family, rows) in Family::ALL.into_iter().zip(&nodes.families) {
        for row in rows {
            let near = coarse_rows(family, row, coarse);
            if near.is_empty() {
                continue;
            }
            for interval in &row.intervals {
                owners.clear();
                owners.resize((interval.end - interval.first) as usize, None);
                near.iter().for_each(|row| claim(family, coarse, row, interval, &mut owners));
                let owned = |(at, owner): (usize, &Option<Owner>)| owner.map(|owner| (at as u32, owner));
                for (at, owner) in owners.iter().enumerate().filter_map(owned) {
                    let node = interval.start + at * family.nodes_per_point();
                    push(family, [interval.first + at, row.j, row.k], node, &owner, &mut out);
                }
            }
        }
    }
    out
}

/// A row of coarse cells whose box holds a row of nodes: the numbers of its runs.
struct CoarseRow {
    j: u32,
    k: u32,
    runs: std::ops::Range<usize>,
}

/// In the order in which their cells count, by (k, j).
fn coarse_rows(family: Family, row: &NodeRow, coarse: &Rows) -> Vec<CoarseRow> {
    let mut out = Vec::new();
    for k in holders(row.k, family != Family::EdgeZ) {
        for j in holders(row.j, family != Family::EdgeY) {
            let runs = coarse.find(j, k);
            if !runs.is_empty() {
                out.push(CoarseRow { j, k, runs });
            }
        }
    }
    out
}

/// The coarse cells along an axis whose closed range holds a point of the finer lattice, or, of families whose nodes
/// are not `at_corner` but within the edge from there to the next point, those nodes.
fn holders(point: u32, at_corner: bool) -> impl Iterator<Item = u32> {
    let upper = point / 2;
    let lower = if at_corner && point.is_multiple_of(2) { upper.saturating_sub(1) } else { upper };
    lower..=upper
}

#[derive(Clone, Copy)]
struct Owner {
    run: u32,
    steps: u32,
    cell: [u32; 3],
}

/// Gives the row's cells those points of the interval that no other cell has.
fn claim(
    family: Family,
    coarse: &Rows,
    row: &CoarseRow,
    interval: &NodeInterval,
    owners: &mut [Option<Owner>],
) {
    let at_corner = family != Family::EdgeX;
    let runs = &coarse.runs[row.runs.clone()];
    let from = runs.partition_point(|run| 2 * (run.i + run.len) < interval.first);
    for (number, run) in runs.iter().enumerate().skip(from) {
        if 2 * run.i >= interval.end {
            break;
        }
        let end = 2 * (run.i + run.len) + u32::from(at_corner);
        for point in (2 * run.i).max(interval.first)..end.min(interval.end) {
            let owner = &mut owners[(point - interval.first) as usize];
            if owner.is_none() {
                let i = holders(point, at_corner).next().map_or(run.i, |lower| lower.max(run.i));
                let run_number = (row.runs.start + number) as u32;
                *owner = Some(Owner { run: run_number, steps: i - run.i, cell: [i, row.j, row.k] });
            }
        }
    }
}

/// The one or two nodes of a lattice point.
fn push(family: Family, point: [u32; 3], node: u32, owner: &Owner, out: &mut Vec<Constrained>) {
    for t in 0..family.nodes_per_point() {
        let thirds = |axis: usize| 3 * point[axis] + if family as usize == axis + 1 { t + 1 } else { 0 };
        let sixths = [0, 1, 2].map(|axis| (thirds(axis) - 6 * owner.cell[axis]) as u8);
        out.push(Constrained { node: node + t, run: owner.run, steps: owner.steps, sixths });
    }
}

/// Shape functions at all places that a constrained node can have.
pub(super) struct Shapes(Vec<Vec<(usize, f64)>>);

pub(super) static SHAPES: LazyLock<Shapes> = LazyLock::new(Shapes::new);

impl Shapes {
    fn new() -> Shapes {
        let place = |n: usize| [n % 7, n / 7 % 7, n / 49];
        let parts = |n: usize| {
            let xi = DVec3::from(place(n).map(|sixths| (sixths as f64 - 3.0) / 3.0));
            let shape = serendipity::shape(xi).into_iter().map(exact).enumerate();
            shape.filter(|&(_, part)| part != 0.0).collect()
        };
        let on_surface = |n: usize| place(n).iter().any(|sixths| sixths % 6 == 0);
        Shapes((0..343).map(|n| if on_surface(n) { parts(n) } else { Vec::new() }).collect())
    }

    /// The nodes of the cell that a value there depends on, and their parts.
    pub fn parts(&self, sixths: [u8; 3]) -> impl Iterator<Item = (usize, f64)> + '_ {
        let [x, y, z] = sixths.map(usize::from);
        self.0[x + 7 * y + 49 * z].iter().copied()
    }
}

/// At a node all functions but its own are 0, which is 1, but for the rounding of thirds.
fn exact(part: f64) -> f64 {
    if (part - part.round()).abs() < 1e-14 { part.round() } else { part }
}

/// The trilinear function of a cell's corner values.
pub(super) fn trilinear(sixths: [u8; 3], corners: &[f64; 8]) -> f64 {
    let [x, y, z] = sixths.map(|sixths| f64::from(sixths) / 6.0);
    let along = |a: f64, b: f64, f: f64| a * (1.0 - f) + b * f;
    let edge = |n: usize| along(corners[n], corners[n + 1], x);
    along(along(edge(0), edge(2), y), along(edge(4), edge(6), y), z)
}
