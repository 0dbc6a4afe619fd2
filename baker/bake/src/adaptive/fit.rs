//! The stored volume as the least-squares fit to all that is known of it: at nodes, constrained ones too, and probes.
//!
//! A cubic through the nodes misses by most in the middle of a cell, and always to one side; the best cubic misses by half
//! of that. And the traces of coarse cells, which finer neighbours take over, are those that suit both.
//!
//! Conjugate gradients (Hestenes and Stiefel 1952) on the normal equations, from the values at the nodes on, or the fit of
//! the round before: few steps suffice, for every number has its say near by only. Cell by cell, the equations' matrix is
//! the polynomial's values at the probes, weighted, shared out to the nodes again.

use super::probes;
use rayon::prelude::*;
use volmap_runtime::layout::Levels;
use volmap_runtime::layout::serendipity::NODES;

/// Steps of conjugate gradients, from the values at the nodes and from a fit.
pub const FIRST: usize = 8;
pub const AGAIN: usize = 4;
/// Cells whose shares are computed before they are added.
const CHUNK: usize = 1 << 13;

/// How much a place counts where no fluid is, squared.
const REST: f64 = 0.05 * 0.05;

/// A fit to be found.
pub struct Fit<'a, T> {
    /// The nodes.
    pub layout: &'a Levels,
    /// The nodes of each cell.
    pub cells: &'a [[u32; NODES]],
    /// What the fit should have at a cell's probes, by its place among the cells.
    pub targets: T,
    /// Which of each cell's probes can have fluid, bit by bit.
    pub in_fluid: &'a [u32],
    /// At all nodes, constrained ones too.
    pub at_nodes: &'a [f64],
    /// Which of them can have fluid.
    pub nodes_in_fluid: &'a [bool],
    /// Free nodes that hold their values.
    pub fixed: &'a [bool],
}

impl<T: Fn(usize) -> [f64; probes::COUNT] + Sync> Fit<'_, T> {
    /// The values at the free nodes, in steps from others there.
    pub fn solve(&self, mut x: Vec<f64>, steps: usize) -> Vec<f64> {
        let mut room = Room::default();
        let mut rest = self.missing(&x, &mut room);
        let mut direction = rest.clone();
        let mut size = product(&rest, &rest);
        for _ in 0..steps {
            let change = self.applied(&direction, &mut room);
            let length = product(&direction, &change);
            if !(length > 0.0 && size > 0.0) {
                break;
            }
            let step = size / length;
            x.iter_mut().zip(&direction).for_each(|(x, d)| *x += step * d);
            rest.iter_mut().zip(&change).for_each(|(rest, change)| *rest -= step * change);
            let (before, now) = (size, product(&rest, &rest));
            size = now;
            direction.iter_mut().zip(&rest).for_each(|(d, rest)| *d = rest + now / before * *d);
        }
        x
    }

    /// A^T W^2 (b - A x).
    fn missing(&self, x: &[f64], room: &mut Room) -> Vec<f64> {
        let at_probes = |cell: usize, values: [f64; probes::COUNT]| {
            let targets = (self.targets)(cell);
            std::array::from_fn(|n| self.weight(cell, n) * (targets[n] - values[n]))
        };
        self.pass(x, room, |node, x| self.node_weight(node) * (self.at_nodes[node] - x), at_probes)
    }

    /// A^T W^2 A x.
    fn applied(&self, x: &[f64], room: &mut Room) -> Vec<f64> {
        let at_probes = |cell: usize, values: [f64; probes::COUNT]| {
            std::array::from_fn(|n| self.weight(cell, n) * values[n])
        };
        self.pass(x, room, |node, x| self.node_weight(node) * x, at_probes)
    }

    fn weight(&self, cell: usize, probe: usize) -> f64 {
        if self.in_fluid[cell] >> probe & 1 == 1 { 1.0 } else { REST }
    }

    fn node_weight(&self, node: usize) -> f64 {
        if self.nodes_in_fluid[node] { 1.0 } else { REST }
    }

    /// A^T of what is made of A x: `at_node` of a node and its value, `at_probes` of a cell and its values.
    fn pass(
        &self,
        x: &[f64],
        room: &mut Room,
        at_node: impl Fn(usize, f64) -> f64,
        at_probes: impl Fn(usize, [f64; probes::COUNT]) -> [f64; probes::COUNT] + Sync,
    ) -> Vec<f64> {
        let Room { all, sums, shares } = room;
        self.layout.complete_into(x, all);
        sums.clear();
        sums.extend(all.iter().enumerate().map(|(own, x)| at_node(own, *x)));
        for (chunk, cells) in self.cells.chunks(CHUNK).enumerate() {
            let share = |(n, nodes): (usize, &[u32; NODES])| {
                let values = probes::values(&nodes.map(|node| all[node as usize]));
                probes::shared_out(&at_probes(CHUNK * chunk + n, values))
            };
            cells.par_iter().enumerate().map(share).collect_into_vec(shares);
            for (nodes, shares) in cells.iter().zip(&*shares) {
                nodes.iter().zip(shares).for_each(|(node, share)| sums[*node as usize] += share);
            }
        }
        let mut free = self.layout.share_out(sums);
        free.iter_mut().zip(self.fixed).filter(|(_, fixed)| **fixed).for_each(|(slope, _)| *slope = 0.0);
        free
    }
}

/// Memory that passes use again.
#[derive(Default)]
struct Room {
    /// Values at all nodes.
    all: Vec<f64>,
    /// Shares of all nodes.
    sums: Vec<f64>,
    /// Those of the cells of a chunk.
    shares: Vec<[f64; NODES]>,
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
