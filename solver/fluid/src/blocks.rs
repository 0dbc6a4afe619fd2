//! Blocks of cells: the particles of a small cube, which are worked on together, and those around it, which they may
//! have as neighbours. The unit of parallel work.
//!
//! What a sum over neighbours reads of the particles of a block and around it is first laid side by side in a table,
//! so that neighbours have numbers of 16 bits there and stay in the fastest cache.

use crate::cells::{CELLS_OF_BRICK, CELLS_OF_TILE, Cells};
use crate::pairs::table::MOST;
use glam::IVec3;
use rayon::prelude::*;
use std::ops::Range;

/// Cells of a block, a cube of 4^3; with many particles a whole tile where there is one, whose surroundings are the
/// smaller part of its table.
const FEW_CELLS: usize = CELLS_OF_BRICK;
const MANY_CELLS: usize = CELLS_OF_TILE;
/// From how many particles on; there are then blocks enough for many threads.
const MANY_PARTICLES: usize = 200_000;

/// An aligned cube of cells with particles in it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellBlock {
    /// Its particles, which follow each other.
    pub particles: Range<usize>,
    /// Cells that have particles: lowest and highest corner.
    pub(crate) occupied: [IVec3; 2],
    /// Numbers of all of its cells, along the z-order curve.
    pub(crate) cells: Range<usize>,
}

/// A place where more particles are near each other than a table has room for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TooDense {
    /// One of the particles there.
    pub particle: usize,
}

/// All blocks, in the order of their particles.
///
/// # Errors
/// [`TooDense`]
pub fn divide(cells: &Cells, particles: usize) -> Result<Vec<CellBlock>, TooDense> {
    let size = if particles < MANY_PARTICLES { FEW_CELLS } else { MANY_CELLS.min(cells.largest_cube()) };
    let all = cells.numbers();
    let tiles: Vec<Result<Vec<CellBlock>, TooDense>> = (0..all.div_ceil(CELLS_OF_TILE))
        .into_par_iter()
        .map(|tile| {
            let numbers = tile * CELLS_OF_TILE..all.min((tile + 1) * CELLS_OF_TILE);
            let mut out = Vec::new();
            for first in numbers.step_by(size) {
                add(cells, first, size, &mut out)?;
            }
            Ok(out)
        })
        .collect();
    // The first of the errors, whichever came first.
    let tiles: Result<Vec<Vec<CellBlock>>, TooDense> = tiles.into_iter().collect();
    Ok(tiles?.into_iter().flatten().collect())
}

/// Adds the block of `size` cells from number `first` on, or its parts if it has too much around it.
fn add(cells: &Cells, first: usize, size: usize, out: &mut Vec<CellBlock>) -> Result<(), TooDense> {
    let particles = cells.particles_of(first..first + size);
    if particles.is_empty() {
        return Ok(());
    }
    let mut occupied = [IVec3::MAX, IVec3::MIN];
    for number in first..first + size {
        if !cells.particles_of(number..number + 1).is_empty() {
            let cell = cells.cell_of(number);
            occupied = [occupied[0].min(cell), occupied[1].max(cell)];
        }
    }
    let around: usize = surroundings(occupied).map(|cell| cells.particles(cell).len()).sum();
    if around <= MOST {
        out.push(CellBlock { particles, occupied, cells: first..first + size });
        return Ok(());
    }
    if size == 1 {
        return Err(TooDense { particle: particles.start });
    }
    (0..8).try_for_each(|part| add(cells, first + part * size / 8, size / 8, out))
}

/// The cells of a box and one more on each side, x fastest.
pub(crate) fn surroundings([min, max]: [IVec3; 2]) -> impl Iterator<Item = IVec3> {
    let along = move |axis: usize| min[axis] - 1..=max[axis] + 1;
    along(2).flat_map(move |z| along(1).flat_map(move |y| along(0).map(move |x| IVec3::new(x, y, z))))
}

/// The values of each block's particles.
pub fn split<T>(blocks: impl Iterator<Item = usize>, mut values: &mut [T]) -> Vec<&mut [T]> {
    blocks
        .map(|count| {
            let (head, rest) = std::mem::take(&mut values).split_at_mut(count);
            values = rest;
            head
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::neighbours::tests::random_points;
    use volmap_runtime::DVec3;

    fn blocks(positions: &[DVec3]) -> Result<Vec<CellBlock>, TooDense> {
        let (mut cells, mut order) = (Cells::default(), Vec::new());
        cells.sort(positions, 0.1, &mut order);
        divide(&cells, positions.len())
    }

    #[test]
    fn each_particle_is_in_one_block() {
        let mut positions = random_points(5000, 1.7, 3);
        positions.push(DVec3::splat(40.0));
        let blocks = blocks(&positions).unwrap();
        let all: Vec<usize> = blocks.iter().flat_map(|block| block.particles.clone()).collect();
        assert!(all.iter().copied().eq(0..positions.len()));
        assert_eq!(blocks.last().unwrap().occupied[0], blocks.last().unwrap().occupied[1]);
    }

    #[test]
    fn dense_places_are_divided_or_refused() {
        // 900 in each of 8 x 8 x 2 cells, so that no block of 64 cells has room in a table, and those of 8 cells have.
        let slab: Vec<DVec3> =
            random_points(115_200, 0.8, 1).iter().map(|x| *x * DVec3::new(1.0, 1.0, 0.25)).collect();
        let dense = blocks(&slab).unwrap();
        assert!(dense.iter().all(|block| block.cells.len() == 8));
        let all = dense.iter().flat_map(|block| block.particles.clone());
        assert!(all.eq(0..slab.len()));
        let clump = random_points(MOST + 1, 0.01, 1);
        assert!(blocks(&clump[1..]).is_ok());
        assert!(blocks(&clump).is_err());
    }
}
