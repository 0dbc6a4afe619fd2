//! From the tree of cells to a map: nodes numbered, corners weighted, errors measured once more with all constraints in
//! place, and cells split until none is left that can be.

use super::cells::{CellTree, Judge, State};
use super::in_place::{Numbered, Settled};
use super::known::Known;
use super::lattice::LevelCell;
use crate::error::Error;
use crate::plan::Plan;
use crate::sdf::SignedDistance;
use glam::{DVec3, UVec3};

/// How often cells are split for what they are in place, at most. Few are left then, and errors a little above.
const ROUNDS: usize = 16;

impl<D: SignedDistance> Judge<'_, D> {
    /// Balances the cells, and splits those whose errors in place are too large, until all are good or of the finest
    /// level. Where few cells are new, only those around them are fitted anew.
    ///
    /// # Errors
    /// Cells that can't be numbered; cancelled.
    pub fn settle(&self, tree: &mut CellTree, known: &mut Known, plan: &Plan) -> Result<Settled, Error> {
        for round in 1.. {
            self.balance(tree, known)?;
            let region = tree.around_new(self.lattice.grid().resolution);
            let numbered = self.numbered(tree, region.as_ref(), known, plan)?;
            let volume = self.fitted(&numbered, known);
            let mut found = self.in_place(numbered, volume, known);
            let mut split = self.causes(&found.failing, tree);
            let last = round == ROUNDS;
            if region.is_some() && (split.is_empty() || last) {
                // The whole map, of fits that were found part by part.
                let numbered = self.numbered(tree, None, known, plan)?;
                let volume = numbered.fitted_before(known);
                found = self.in_place(numbered, volume, known);
                split = self.causes(&found.failing, tree);
            }
            if split.is_empty() || last {
                return Ok(found.settled());
            }
            self.split(split, tree, known)?;
        }
        unreachable!("the last round returns")
    }

    fn in_place(&self, numbered: Numbered, volume: Vec<f64>, known: &Known) -> InPlace {
        let failing = self.failing(&numbered, &volume, known);
        InPlace { numbered, volume, failing }
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

    pub fn balance(&self, tree: &mut CellTree, known: &mut Known) -> Result<(), Error> {
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
}

/// Cells in place, with their fit.
struct InPlace {
    numbered: Numbered,
    volume: Vec<f64>,
    failing: Vec<LevelCell>,
}

impl InPlace {
    /// What there is to store; cells that are above the tolerance and can't be split are told.
    fn settled(self) -> Settled {
        self.numbered.settled(self.volume, self.failing)
    }
}

impl CellTree {
    /// The cell of the band that holds a place, in cells of level 0, of one of those.
    fn holder(&self, root: UVec3, place: DVec3) -> Option<LevelCell> {
        let mut cell = LevelCell { level: 0, at: root };
        loop {
            match self.cells.get(&cell)? {
                State::Band => return Some(cell),
                State::Split => {}
                State::Solid | State::Fluid => return None,
            }
            let next = f64::from(2u32 << cell.level);
            let at = (place * next).floor().as_uvec3().clamp(2 * cell.at, 2 * cell.at + 1);
            cell = LevelCell { level: cell.level + 1, at };
        }
    }
}
