//! Cells in place: their nodes numbered with all constraints, their volumes fitted, their errors measured.

use super::cells::{CellFields, CellTree, Judge, State};
use super::fit::{AGAIN, FIRST, Fit};
use super::form::Form;
use super::known::{Fitted, Known};
use super::lattice::{Key, LevelCell};
use super::region::{FITTED, Region};
use crate::error::Error;
use crate::plan::Plan;
use crate::sdf::SignedDistance;
use crate::sdf::band::joined;
use glam::{DVec3, UVec3};
use rayon::prelude::*;
use volmap_formats::asset::{CellRun, LevelCells};
use volmap_runtime::layout::serendipity::NODES;
use volmap_runtime::layout::{LevelCell as LayoutCell, Levels};

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
    /// How it is stored.
    pub form: Form,
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
pub struct Numbered {
    levels: Vec<LevelCells>,
    layout: Levels,
    /// The band's, each with its place in the tree. In a region, those that are fitted.
    cells: Vec<(LevelCell, LayoutCell)>,
    /// How the volume is stored.
    form: Form,
    /// All nodes.
    keys: Vec<Key>,
    /// Those that hold their values: where a region ends.
    fixed: Vec<bool>,
    /// Phi there, metres.
    distance: Vec<f64>,
    /// The stored volume there, exactly, or as it was fitted where it is fixed, m^3.
    difference: Vec<f64>,
}

impl<D: SignedDistance> Judge<'_, D> {
    /// Numbers the nodes of all cells, or of those of a region, and takes their values.
    pub fn numbered(
        &self,
        tree: &CellTree,
        region: Option<&Region>,
        known: &Known,
        plan: &Plan,
    ) -> Result<Numbered, Error> {
        let levels = match region {
            None => levels(tree.cells.iter().map(|(cell, state)| (*cell, *state)), plan.margin),
            Some(region) => levels(region.keys().map(|cell| (*cell, tree.cells[cell])), plan.margin),
        };
        let layout = Levels::new(plan.grid, &levels)
            .map_err(|error| Error::setting("tolerance", error.to_string()))?;
        let in_tree = |cell: LayoutCell| {
            (LevelCell { level: cell.level, at: cell.index + (plan.margin << cell.level) }, cell)
        };
        let mut cells: Vec<(LevelCell, LayoutCell)> = layout.cells().map(in_tree).collect();
        let keys: Vec<Key> = layout.positions().into_iter().map(|place| self.lattice.key_at(place)).collect();
        let mut fixed = vec![false; keys.len()];
        if let Some(region) = region {
            let (fitted, held) = cells.into_iter().partition(|(own, _)| region[own] <= FITTED);
            cells = fitted;
            let held: Vec<(LevelCell, LayoutCell)> = held;
            held.iter().flat_map(|(_, cell)| cell.nodes).for_each(|node| fixed[node as usize] = true);
        }
        let before = |node: usize| known.fitted.get(&keys[node]).filter(|_| fixed[node]);
        let of_free = |node: u32| match before(node as usize) {
            Some(fitted) => fitted.distance,
            None => known.distance.at(keys[node as usize]),
        };
        let free: Vec<u32> = layout.free().collect();
        let free: Vec<f64> = free.into_par_iter().map(of_free).collect();
        let distance = layout.complete(&free);
        let of_node = |node: usize| match before(node) {
            Some(fitted) => fitted.volume,
            None => known.volume.at(keys[node]) - self.form().of_wall(&self.wall, distance[node]),
        };
        let difference = (0..keys.len()).into_par_iter().map(of_node).collect();
        Ok(Numbered { levels, layout, cells, form: self.form(), keys, fixed, distance, difference })
    }

    /// The stored volume at the free nodes that fits best.
    pub fn fitted(&self, of: &Numbered, known: &mut Known) -> Vec<f64> {
        let targets = |n: usize| {
            let (own, cell) = &of.cells[n];
            let distance = cell.nodes.map(|node| of.distance[node as usize]);
            self.targets(*own, &distance, known)
        };
        let cells: Vec<[u32; NODES]> = of.cells.iter().map(|(_, cell)| cell.nodes).collect();
        let in_fluid: Vec<u32> = of.cells.par_iter().map(|(own, _)| self.in_fluid(*own, known)).collect();
        let nodes_in_fluid: Vec<bool> = of.distance.iter().map(|&phi| self.counts(phi)).collect();
        let fit = Fit {
            layout: &of.layout,
            cells: &cells,
            targets,
            in_fluid: &in_fluid,
            at_nodes: &of.difference,
            nodes_in_fluid: &nodes_in_fluid,
            fixed: &of.layout.free().map(|node| of.fixed[node as usize]).collect::<Vec<_>>(),
        };
        let steps = if known.fitted.is_empty() { FIRST } else { AGAIN };
        let volume = fit.solve(of.fitted_before(known), steps);
        of.keep(&volume, known);
        volume
    }

    /// Cells whose errors are too large, with all constraints in place.
    pub fn failing(&self, of: &Numbered, volume: &[f64], known: &Known) -> Vec<LevelCell> {
        let volume = of.layout.complete(volume);
        let failing = |(own, cell): &(LevelCell, LayoutCell)| {
            let at_nodes = |values: &[f64]| cell.nodes.map(|node| values[node as usize]);
            let (distance, volume) = (at_nodes(&of.distance), at_nodes(&volume));
            let error = self.error(*own, &CellFields { distance, volume, form: of.form }, known);
            (error > 1.0).then_some(*own)
        };
        of.cells.par_iter().filter_map(failing).collect()
    }
}

impl Numbered {
    /// The stored volume at the free nodes as far as it was fitted before, exact elsewhere.
    pub fn fitted_before(&self, known: &Known) -> Vec<f64> {
        let free: Vec<u32> = self.layout.free().collect();
        let value = |node: u32| {
            let (node, exact) = (node as usize, self.difference[node as usize]);
            match known.fitted.get(&self.keys[node]) {
                Some(fitted) if !self.fixed[node] => exact + fitted.added,
                _ => exact,
            }
        };
        free.into_par_iter().map(value).collect()
    }

    /// Remembers a fit.
    fn keep(&self, volume: &[f64], known: &mut Known) {
        let all = self.layout.complete(volume);
        known.fitted.reserve(all.len());
        for (node, volume) in all.into_iter().enumerate().filter(|(node, _)| !self.fixed[*node]) {
            let fitted =
                Fitted { distance: self.distance[node], volume, added: volume - self.difference[node] };
            known.fitted.insert(self.keys[node], fitted);
        }
    }

    /// What there is to store.
    pub fn settled(self, volume: Vec<f64>, left: Vec<LevelCell>) -> Settled {
        let Numbered { levels, layout, form, distance, .. } = self;
        let distance = layout.free().map(|node| distance[node as usize]).collect();
        Settled { levels, layout, distance, volume, form, left }
    }
}

/// The cells of each level as runs, up to the last that has any.
fn levels(cells: impl Iterator<Item = (LevelCell, State)>, margin: UVec3) -> Vec<LevelCells> {
    let mut levels = vec![LevelCells::default()];
    for (cell, state) in cells {
        let at = cell.at.wrapping_sub(margin << cell.level);
        let run = CellRun { i: at.x, j: at.y, k: at.z, len: 1 };
        let level = cell.level as usize;
        if matches!(state, State::Band | State::Solid) && level >= levels.len() {
            levels.resize(level + 1, LevelCells::default());
        }
        match state {
            State::Band => levels[level].band.push(run),
            State::Solid => levels[level].solid.push(run),
            State::Split | State::Fluid => {}
        }
    }
    for level in &mut levels {
        level.band = joined(std::mem::take(&mut level.band));
        level.solid = joined(std::mem::take(&mut level.solid));
    }
    levels
}
