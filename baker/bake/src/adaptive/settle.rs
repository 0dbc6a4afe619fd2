//! From the tree of cells to a map: nodes numbered, corners weighted, errors measured once more with all constraints in
//! place, and cells split until none is left that can be.

use super::cells::{CellFields, CellTree, Judge, REST, State, Wish, part_of, trilinear};
use super::fit::{AGAIN, FIRST, Fit, Targets};
use super::known::Known;
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

/// Part of the cells that are few.
const FEW: f64 = 0.001;

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

/// Cells whose nodes are numbered, and what is known at them all.
struct Numbered {
    levels: Vec<LevelCells>,
    layout: Levels,
    /// The band's, each with its place in the tree.
    cells: Vec<(LevelCell, LayoutCell)>,
    /// w at the free corners, and at those of each cell.
    weights: Vec<u32>,
    corners: CornerWeights,
    /// All nodes.
    keys: Vec<Key>,
    /// Phi there, metres.
    distance: Vec<f64>,
    /// The stored volume there, exactly, m^3.
    difference: Vec<f64>,
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
            let numbered = self.numbered(tree, known, plan)?;
            let volume = self.fitted(&numbered, known);
            let failing = self.failing(&numbered, &volume, known);
            let few = failing.len() as f64 <= FEW * numbered.cells.len() as f64;
            let split = self.causes(&failing, few, tree);
            if split.is_empty() || round == ROUNDS {
                let left = failing.iter().filter(|(_, error)| *error > 1.0).map(|(cell, _)| *cell).collect();
                return Ok(numbered.settled(volume, left));
            }
            self.split(split, tree, known)?;
        }
        unreachable!("the last round returns")
    }

    /// What to split: a cell that is good by itself fails by the traces of the larger ones that it touches. Where `few` are
    /// left, both: another round would cost more than their cells.
    fn causes(&self, failing: &[(LevelCell, f64)], few: bool, tree: &CellTree) -> Vec<LevelCell> {
        let mut causes = Vec::new();
        for &(cell, _) in failing {
            let before = causes.len();
            causes.extend(tree.larger_neighbours(cell, self.lattice.grid().resolution));
            if (few || causes.len() == before) && cell.level < self.lattice.finest() {
                causes.push(cell);
            }
        }
        LevelCell::sort(&mut causes);
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
        LevelCell::sort(&mut cells);
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
            known.at_probes.remove(&cell);
        }
        let children = cells.into_iter().flat_map(LevelCell::children).collect();
        self.decide(children, tree, known)
    }

    /// Numbers the nodes, and takes their values.
    fn numbered(&self, tree: &CellTree, known: &Known, plan: &Plan) -> Result<Numbered, Error> {
        let levels = tree.levels(self.lattice.finest(), plan.margin);
        let layout = Levels::new(plan.grid, &levels)
            .map_err(|error| Error::setting("tolerance", error.to_string()))?;
        let in_tree = |cell: LayoutCell| {
            (LevelCell { level: cell.level, at: cell.index + (plan.margin << cell.level) }, cell)
        };
        let cells: Vec<(LevelCell, LayoutCell)> = layout.cells().map(in_tree).collect();
        let weights = weights(tree, &layout, &cells);
        let corners = layout.complete_weights(&weights);
        let keys: Vec<Key> = layout.positions().into_iter().map(|place| self.lattice.key_at(place)).collect();
        let free: Vec<f64> = layout.free().map(|node| known.distance.at(keys[node as usize])).collect();
        let distance = layout.complete(&free);
        let at_nodes = weights_at_nodes(layout.count(), &cells, &corners);
        let of_node = |(node, key): (usize, &Key)| {
            known.volume.at(*key) - at_nodes[node] * self.wall.volume(distance[node])
        };
        let difference = keys.par_iter().enumerate().map(of_node).collect();
        Ok(Numbered { levels, layout, cells, weights, corners, keys, distance, difference })
    }

    /// The stored volume at the free nodes that fits best.
    fn fitted(&self, of: &Numbered, known: &mut Known) -> Vec<f64> {
        let targets = |(own, cell): &(LevelCell, LayoutCell)| {
            let distance = cell.nodes.map(|node| of.distance[node as usize]);
            self.targets(*own, &distance, &of.corners.of(cell.number), known)
        };
        let targets: Vec<Targets> = of.cells.par_iter().map(targets).collect();
        let cells: Vec<[u32; NODES]> = of.cells.iter().map(|(_, cell)| cell.nodes).collect();
        let node_weights: Vec<f64> =
            of.distance.iter().map(|&phi| if self.counts(phi) { 1.0 } else { REST }).collect();
        let fit = Fit {
            layout: &of.layout,
            cells: &cells,
            targets: &targets,
            at_nodes: &of.difference,
            node_weights: &node_weights,
        };
        let nodes: Vec<(Key, f64)> =
            of.layout.free().map(|node| (of.keys[node as usize], of.difference[node as usize])).collect();
        let before = &known.fitted;
        let start =
            nodes.iter().map(|(key, exact)| exact + before.get(key).copied().unwrap_or(0.0)).collect();
        let volume = fit.solve(start, if before.is_empty() { FIRST } else { AGAIN });
        let added = nodes.iter().zip(&volume).map(|((key, exact), value)| (*key, value - exact));
        known.fitted = added.collect();
        volume
    }

    /// Cells whose errors are too large, with all constraints in place, and the largest as a part of its tolerance.
    fn failing(&self, of: &Numbered, volume: &[f64], known: &Known) -> Vec<(LevelCell, f64)> {
        let volume = of.layout.complete(volume);
        let failing = |(own, cell): &(LevelCell, LayoutCell)| {
            let at_nodes = |values: &[f64]| cell.nodes.map(|node| values[node as usize]);
            let weights = of.corners.of(cell.number);
            let fields = CellFields { distance: at_nodes(&of.distance), volume: at_nodes(&volume), weights };
            let error = self.error(*own, &fields, known);
            (error > self.in_place).then_some((*own, error))
        };
        of.cells.par_iter().filter_map(failing).collect()
    }
}

impl Numbered {
    fn settled(self, volume: Vec<f64>, left: Vec<LevelCell>) -> Settled {
        let Numbered { levels, layout, weights, distance, .. } = self;
        let distance = layout.free().map(|node| distance[node as usize]).collect();
        Settled { levels, layout, distance, volume, weights, left }
    }
}

/// A free corner has the plain form, 0, if a cell needs that there, and the other elsewhere.
fn weights(tree: &CellTree, layout: &Levels, cells: &[(LevelCell, LayoutCell)]) -> Vec<u32> {
    let mut is_plain = vec![false; layout.count()];
    for (own, cell) in cells {
        if tree.cells[own] == State::Band(Wish::Plain) {
            cell.nodes[..8].iter().for_each(|&corner| is_plain[corner as usize] = true);
        }
    }
    layout.free_corners().map(|corner| u32::from(!is_plain[corner as usize])).collect()
}

/// w at all nodes. Neighbours agree on their common nodes.
fn weights_at_nodes(nodes: usize, cells: &[(LevelCell, LayoutCell)], corners: &CornerWeights) -> Vec<f64> {
    let mut out = vec![0.0; nodes];
    let parts: [[f64; 8]; NODES] = std::array::from_fn(|a| trilinear(node(a)));
    for (_, cell) in cells {
        let own = corners.of(cell.number);
        for (parts, &node) in parts.iter().zip(&cell.nodes) {
            out[node as usize] = part_of(parts, &own);
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
