//! The cells around those that are new: a fit changes little farther away.

use super::cells::{CellTree, State};
use super::lattice::LevelCell;
use glam::{IVec3, UVec3};
use rustc_hash::FxHashMap;

/// Cells of the band around new ones, and how many steps from neighbour to neighbour away.
pub type Region = FxHashMap<LevelCell, u8>;

/// Steps of the cells that are fitted; those one step farther hold their values.
pub const FITTED: u8 = 2;
/// Regions of more than this part of all cells gain nothing.
const LARGEST: f64 = 0.4;
/// Regions that stand for the whole map.
const SAMPLES: usize = 100;

impl CellTree {
    /// Takes the list of new cells; none if all are to be fitted.
    pub fn around_new(&mut self, resolution: UVec3) -> Option<Region> {
        let new = std::mem::take(&mut self.new);
        self.around(new.into_iter().filter(|cell| self.cells[cell] == State::Band), resolution)
    }

    /// Some regions spread over the map; none if they would be much of it.
    pub fn samples(&self, resolution: UVec3) -> Option<Region> {
        let mut band: Vec<LevelCell> = self.band().collect();
        LevelCell::sort(&mut band);
        let step = (band.len() / SAMPLES).max(1);
        self.around(band.into_iter().step_by(step), resolution)
    }

    /// Every cell of the band.
    fn band(&self) -> impl Iterator<Item = LevelCell> {
        self.cells.iter().filter(|(_, state)| **state == State::Band).map(|(cell, _)| *cell)
    }

    /// The cells around some of the band; none if they are too large a part of all.
    fn around(&self, some: impl Iterator<Item = LevelCell>, resolution: UVec3) -> Option<Region> {
        let most = LARGEST * self.band().count() as f64;
        let mut region: Region = some.map(|cell| (cell, 0)).collect();
        let mut last: Vec<LevelCell> = region.keys().copied().collect();
        for step in 1..=FITTED + 1 {
            let mut next = Vec::new();
            for cell in last {
                self.each_touching(cell, resolution, |other| {
                    region.entry(other).or_insert_with(|| {
                        next.push(other);
                        step
                    });
                });
                if region.len() as f64 > most {
                    return None;
                }
            }
            last = next;
        }
        Some(region)
    }

    /// Every cell of the band that a balanced cell touches.
    fn each_touching(&self, cell: LevelCell, resolution: UVec3, mut each: impl FnMut(LevelCell)) {
        for (step, place) in cell.around(resolution) {
            match self.cells.get(&place) {
                Some(State::Band) => each(place),
                Some(State::Split) => {
                    let children = place.children().into_iter().filter(|child| is_beside(*child, step));
                    let band = |child: &LevelCell| matches!(self.cells.get(child), Some(State::Band));
                    children.filter(band).for_each(&mut each);
                }
                Some(State::Solid | State::Fluid) => {}
                None => self.coarser_at(place).into_iter().for_each(&mut each),
            }
        }
    }
}

/// Whether a child of the cell in this direction is on the near side.
fn is_beside(child: LevelCell, step: IVec3) -> bool {
    let side = (child.at & 1).as_ivec3();
    let far = IVec3::select(step.cmpgt(IVec3::ZERO), IVec3::ONE, IVec3::ZERO);
    step.cmpeq(IVec3::ZERO).bitmask() | side.cmpne(far).bitmask() == 7
}
