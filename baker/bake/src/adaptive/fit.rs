//! The stored volume as the least-squares fit to all that is known of it: at nodes, constrained ones too, and probes.
//!
//! A cubic through the nodes misses by most in the middle of a cell, and always to one side; the best cubic misses by half
//! of that. And the traces of coarse cells, which finer neighbours take over, are those that suit both.
//!
//! Conjugate gradients on the normal equations (Bjorck and Elfving 1979, CGLS), from the values at the nodes on, or the fit
//! of the round before: few steps suffice, for every number has its say near by only.

use super::probes;
use rayon::prelude::*;
use volmap_runtime::layout::Levels;
use volmap_runtime::layout::serendipity::NODES;

/// Steps of conjugate gradients, from the values at the nodes and from a fit.
pub const FIRST: usize = 8;
pub const AGAIN: usize = 4;

/// What is known at a cell's probes.
#[derive(Clone, Copy, Debug)]
pub struct Targets {
    /// The number that the fit should have there.
    pub values: [f64; probes::COUNT],
    /// How much that counts.
    pub weights: [f64; probes::COUNT],
}

/// A fit to be found.
pub struct Fit<'a> {
    /// The nodes.
    pub layout: &'a Levels,
    /// The nodes of each cell.
    pub cells: &'a [[u32; NODES]],
    /// By cell.
    pub targets: &'a [Targets],
    /// At all nodes, constrained ones too.
    pub at_nodes: &'a [f64],
    /// How much they count.
    pub node_weights: &'a [f64],
}

/// Weighted differences at probes and nodes.
struct Differences {
    probes: Vec<[f64; probes::COUNT]>,
    nodes: Vec<f64>,
}

impl Fit<'_> {
    /// The values at the free nodes, in steps from others there.
    pub fn solve(&self, mut x: Vec<f64>, steps: usize) -> Vec<f64> {
        let mut rest = self.missing(&x);
        let mut slope = self.shared_out(&rest);
        let mut direction = slope.clone();
        let mut size = square(&slope);
        for _ in 0..steps {
            let change = self.applied(&direction);
            let length = change.square();
            if !(length > 0.0 && size > 0.0) {
                break;
            }
            let step = size / length;
            x.iter_mut().zip(&direction).for_each(|(x, d)| *x += step * d);
            rest.subtract(step, &change);
            slope = self.shared_out(&rest);
            let (before, now) = (size, square(&slope));
            size = now;
            direction.iter_mut().zip(&slope).for_each(|(d, s)| *d = s + now / before * *d);
        }
        x
    }

    /// W (b - A x).
    fn missing(&self, x: &[f64]) -> Differences {
        let mut out = self.applied(x);
        let targets = out.probes.par_iter_mut().zip(self.targets);
        targets.for_each(|(own, targets)| {
            for (own, (value, weight)) in own.iter_mut().zip(targets.values.iter().zip(&targets.weights)) {
                *own = weight * value - *own;
            }
        });
        let nodes = self.at_nodes.iter().zip(self.node_weights);
        out.nodes.iter_mut().zip(nodes).for_each(|(own, (value, weight))| *own = weight * value - *own);
        out
    }

    /// W A x.
    fn applied(&self, x: &[f64]) -> Differences {
        let all = self.layout.complete(x);
        let of_cell = |(nodes, targets): (&[u32; NODES], &Targets)| {
            let mut values = probes::values(&nodes.map(|node| all[node as usize]));
            values.iter_mut().zip(&targets.weights).for_each(|(value, weight)| *value *= weight);
            values
        };
        let probes = self.cells.par_iter().zip(self.targets).map(of_cell).collect();
        let nodes = all.iter().zip(self.node_weights).map(|(value, weight)| weight * value).collect();
        Differences { probes, nodes }
    }

    /// (W A)^T times differences.
    fn shared_out(&self, of: &Differences) -> Vec<f64> {
        let mut all: Vec<f64> =
            of.nodes.iter().zip(self.node_weights).map(|(d, weight)| weight * d).collect();
        let of_cell = |(targets, own): (&Targets, &[f64; probes::COUNT])| {
            let mut weighted = *own;
            weighted.iter_mut().zip(&targets.weights).for_each(|(own, weight)| *own *= weight);
            probes::shared_out(&weighted)
        };
        let sums: Vec<[f64; NODES]> = self.targets.par_iter().zip(&of.probes).map(of_cell).collect();
        for (nodes, sums) in self.cells.iter().zip(&sums) {
            nodes.iter().zip(sums).for_each(|(node, sum)| all[*node as usize] += sum);
        }
        self.layout.share_out(&all)
    }
}

impl Differences {
    fn square(&self) -> f64 {
        let probes: f64 = self.probes.iter().flatten().map(|x| x * x).sum();
        probes + square(&self.nodes)
    }

    fn subtract(&mut self, factor: f64, other: &Differences) {
        let probes = self.probes.iter_mut().flatten().zip(other.probes.iter().flatten());
        probes.for_each(|(own, other)| *own -= factor * other);
        self.nodes.iter_mut().zip(&other.nodes).for_each(|(own, other)| *own -= factor * other);
    }
}

fn square(numbers: &[f64]) -> f64 {
    numbers.iter().map(|x| x * x).sum()
}
