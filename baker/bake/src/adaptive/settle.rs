//! From the tree of cells to a map: nodes numbered, corners weighted, errors measured once more with all constraints in
//! place, and cells split until none is left that can be.

use super::cells::{CellFields, CellTree, Judge, Known, REST, SHAPES, State, Wish, trilinear};
use super::fit::{Fit, Targets};
use super::lattice::{Key, LevelCell};
use crate::error::Error;
use crate::plan::Plan;
use crate::sdf::SignedDistance;
use crate::sdf::band::joined;
use glam::{DVec3, UVec3};
use rayon::prelude::*;
use volmap_formats::asset::{CellRun, LevelCells};
use volmap_runtime::layout::serendipity::{NODES, node};
use volmap_runtime::layout::{CornerWeights, LevelCell as LayoutCell, Levels};

/// How often cells are split for what they are in place, at most. Few are left then, and errors a little above.
const ROUNDS: usize = 8;

/// Fields at the free nodes of an adaptive set of cells.
pub struct Settled {
    /// Cells of level 0, 1, ..
    pub levels: Vec<LevelCells>,
    /// Their nodes.
    pub layout: Levels,
    /// Signed distance, metres.
    pub distance: Vec<f64>,
    /// V - w V_plane(Phi), m^3.
    pub volume: Vec<f64>,
    /// w at the free corners, 0 or 1.
    pub weights: Vec<u32>,
    /// Cells of the finest level whose errors are above the tolerance.
    pub left: Vec<LevelCell>,
}

impl Settled {
    /// Where the free nodes are, metres.
    pub fn free_positions(&self) -> impl Iterator<Item = DVec3> + '_ {
        let all = self.layout.positions();
        self.layout.free().map(move |node| all[node as usize])
    }
}

impl<D: SignedDistance> Judge<'_, D> {
    /// Balances the cells, and splits those whose errors in place are too large, until all are good or of the finest
    /// level.
    ///
    /// # Errors
    /// Cells that can't be numbered; cancelled.
    pub fn settle(&self, tree: &mut CellTree, known: &mut Known, plan: &Plan) -> Result<Settled, Error> {
        for round in 1.. {
            self.balance(tree, known)?;
            let mut settled = self.numbered(tree, known, plan)?;
            let failing = self.failing(self.in_place, &settled, known, plan.margin);
            let split = self.causes(&failing, tree);
            if split.is_empty() || round == ROUNDS {
                settled.left = self.failing(1.0, &settled, known, plan.margin);
                return Ok(settled);
            }
            self.split(split, tree, known)?;
        }
        unreachable!("the last round returns")
    }

    /// What to split: a cell that is good by itself fails by the traces of the larger ones that it touches.
    fn causes(&self, failing: &[LevelCell], tree: &CellTree) -> Vec<LevelCell> {
        let mut causes = Vec::new();
        for &cell in failing {
            let before = causes.len();
            causes.extend(tree.larger_neighbours(cell, self.lattice.grid().resolution));
            if causes.len() == before && cell.level < self.lattice.finest() {
                causes.push(cell);
            }
        }
        sort(&mut causes);
        causes
    }

    /// Splits the cells that hold these points, and settles again.
    ///
    /// # Errors
    /// As [`Judge::settle`].
    pub fn repair(
        &self,
        points: &[DVec3],
        tree: &mut CellTree,
        known: &mut Known,
        plan: &Plan,
    ) -> Result<Settled, Error> {
        let grid = self.lattice.grid();
        let mut cells: Vec<LevelCell> = points
            .iter()
            .filter_map(|x| tree.holder(grid.locate(*x)?.cell, (*x - grid.origin) / grid.cell_size))
            .filter(|cell| cell.level < self.lattice.finest())
            .collect();
        sort(&mut cells);
        self.split(cells, tree, known)?;
        self.settle(tree, known, plan)
    }

    fn balance(&self, tree: &mut CellTree, known: &mut Known) -> Result<(), Error> {
        loop {
            let cells = tree.unbalanced(self.lattice.finest(), self.lattice.grid().resolution);
            if cells.is_empty() {
                return Ok(());
            }
            self.split(cells, tree, known)?;
        }
    }

    fn split(&self, cells: Vec<LevelCell>, tree: &mut CellTree, known: &mut Known) -> Result<(), Error> {
        for &cell in &cells {
            tree.cells.insert(cell, State::Split);
        }
        let children = cells.into_iter().flat_map(LevelCell::children).collect();
        self.decide(children, tree, known)
    }

    /// Numbers the nodes, and takes their values.
    fn numbered(&self, tree: &CellTree, known: &Known, plan: &Plan) -> Result<Settled, Error> {
        let levels = tree.levels(self.lattice.finest(), plan.margin);
        let layout = Levels::new(plan.grid, &levels)
            .map_err(|error| Error::setting("tolerance", error.to_string()))?;
        let keys: Vec<Key> = layout.positions().into_iter().map(|place| self.lattice.key_at(place)).collect();
        let weights = self.weights(tree, &layout, plan.margin);
        let at_nodes = weights_at_nodes(&layout, &weights);
        let distance: Vec<f64> = layout.free().map(|node| known.distance.at(keys[node as usize])).collect();
        let all = layout.complete(&distance);
        let difference = |(node, key): (usize, &Key)| {
            let plane =
                if at_nodes[node] == 0.0 { 0.0 } else { at_nodes[node] * self.wall.volume(all[node]) };
            known.volume.at(*key) - plane
        };
        let differences: Vec<f64> = keys.par_iter().enumerate().map(difference).collect();
        let volume = self.fitted(&layout, &all, &differences, &weights, known, plan.margin);
        Ok(Settled { levels, layout, distance, volume, weights, left: Vec::new() })
    }

    /// The stored volume that fits best: `differences` are its exact values at all nodes, where Phi is `distance`.
    fn fitted(
        &self,
        layout: &Levels,
        distance: &[f64],
        differences: &[f64],
        weights: &[u32],
        known: &Known,
        margin: UVec3,
    ) -> Vec<f64> {
        let corners = layout.complete_weights(weights);
        let cells: Vec<LayoutCell> = layout.cells().collect();
        let targets = |cell: &LayoutCell| {
            let own = LevelCell { level: cell.level, at: cell.index + (margin << cell.level) };
            self.targets(
                own,
                &cell.nodes.map(|node| distance[node as usize]),
                &of_cell(&corners, cell.number),
                known,
            )
        };
        let targets: Vec<Targets> = cells.par_iter().map(targets).collect();
        let nodes: Vec<[u32; NODES]> = cells.iter().map(|cell| cell.nodes).collect();
        let node_weights: Vec<f64> =
            distance.iter().map(|&phi| if self.counts(phi) { 1.0 } else { REST }).collect();
        let fit = Fit {
            layout,
            cells: &nodes,
            targets: &targets,
            at_nodes: differences,
            node_weights: &node_weights,
            shapes: &SHAPES,
        };
        fit.solve()
    }

    /// A corner has the plain form if a cell needs that there, and the other elsewhere.
    fn weights(&self, tree: &CellTree, layout: &Levels, margin: UVec3) -> Vec<u32> {
        let mut is_plain = vec![false; layout.count()];
        for cell in layout.cells() {
            let own = LevelCell { level: cell.level, at: cell.index + (margin << cell.level) };
            if tree.cells[&own] == State::Band(Wish::Plain) {
                cell.nodes[..8].iter().for_each(|&corner| is_plain[corner as usize] = true);
            }
        }
        layout.free_corners().map(|corner| u32::from(!is_plain[corner as usize])).collect()
    }

    /// Cells whose errors are too large, with all constraints in place.
    fn failing(&self, part: f64, settled: &Settled, known: &Known, margin: UVec3) -> Vec<LevelCell> {
        let layout = &settled.layout;
        let (distance, volume) = (layout.complete(&settled.distance), layout.complete(&settled.volume));
        let weights = layout.complete_weights(&settled.weights);
        let cells: Vec<_> = layout.cells().collect();
        let is_failing = |cell: &LayoutCell| {
            let of = |values: &[f64]| cell.nodes.map(|node| values[node as usize]);
            let weights = of_cell(&weights, cell.number);
            let fields = CellFields { distance: of(&distance), volume: of(&volume), weights };
            let own = LevelCell { level: cell.level, at: cell.index + (margin << cell.level) };
            (!self.errors(own, &fields, known).are_below(part)).then_some(own)
        };
        cells.par_iter().filter_map(is_failing).collect()
    }
}

/// In an order that doesn't depend on threads, each once.
fn sort(cells: &mut Vec<LevelCell>) {
    cells.sort_unstable_by_key(|cell| (cell.level, cell.at.z, cell.at.y, cell.at.x));
    cells.dedup();
}

/// w at a cell's corners.
fn of_cell(weights: &CornerWeights, cell: usize) -> [f64; 8] {
    weights.palette[weights.of_cell[cell] as usize]
}

/// w at all nodes. Neighbours agree on their common nodes.
fn weights_at_nodes(layout: &Levels, free: &[u32]) -> Vec<f64> {
    let (weights, mut out) = (layout.complete_weights(free), vec![0.0; layout.count()]);
    let parts: [[f64; 8]; NODES] = std::array::from_fn(|a| trilinear(node(a)));
    for cell in layout.cells() {
        let own = of_cell(&weights, cell.number);
        for (parts, &node) in parts.iter().zip(&cell.nodes) {
            out[node as usize] = parts.iter().zip(&own).map(|(n, w)| n * w).sum();
        }
    }
    out
}

impl CellTree {
    /// The cell of the band that holds a place, in cells of level 0, of one of those.
    fn holder(&self, root: UVec3, place: DVec3) -> Option<LevelCell> {
        let mut cell = LevelCell { level: 0, at: root };
        loop {
            match self.cells.get(&cell)? {
                State::Band(_) => return Some(cell),
                State::Split => {}
                State::Solid | State::Fluid => return None,
            }
            let next = f64::from(2u32 << cell.level);
            let at = (place * next).floor().as_uvec3().clamp(2 * cell.at, 2 * cell.at + 1);
            cell = LevelCell { level: cell.level + 1, at };
        }
    }

    /// The cells of each level as runs, up to the last that has any.
    fn levels(&self, finest: u32, margin: UVec3) -> Vec<LevelCells> {
        let mut levels = vec![LevelCells::default(); finest as usize + 1];
        for (cell, state) in &self.cells {
            let at = cell.at.wrapping_sub(margin << cell.level);
            let run = CellRun { i: at.x, j: at.y, k: at.z, len: 1 };
            let own = &mut levels[cell.level as usize];
            match state {
                State::Band(_) => own.band.push(run),
                State::Solid => own.solid.push(run),
                State::Split | State::Fluid => {}
            }
        }
        for level in &mut levels {
            level.band = joined(std::mem::take(&mut level.band));
            level.solid = joined(std::mem::take(&mut level.solid));
        }
        while levels.len() > 1
            && levels.last().is_some_and(|level| level.band.is_empty() && level.solid.is_empty())
        {
            levels.pop();
        }
        levels
    }
}
