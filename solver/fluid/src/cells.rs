//! Particles sorted by cells of the support radius, so that those near in space are near in memory.
//!
//! Cells stand in tiles of 8 x 8 x 8 along a z-order curve (Ihmsen et al. 2011, *A Parallel SPH Implementation on
//! Multi-Core CPUs*); tiles row by row, x fastest. The sort counts, is stable, and so the same on any number of
//! threads.
//!
//! A lattice of moderate size keeps all of its cells, and finds each by its number. In a wide one only those bricks of
//! 4 x 4 x 4 cells are kept that have particles, in the same order: memory and time follow the particles, not the box.

use glam::IVec3;
use rayon::prelude::*;
use volmap_runtime::DVec3;

/// Cells along an edge of a tile.
const TILE: i32 = 8;
pub(crate) const CELLS_OF_TILE: usize = (TILE * TILE * TILE) as usize;
/// Cells of a brick, an eighth of a tile. They follow each other along the curve.
pub(crate) const CELLS_OF_BRICK: usize = CELLS_OF_TILE / 8;
/// Cells at most for each particle, and at most and at least of all: 4 bytes and a visit in every step each. Where a
/// wide domain has more, only the bricks with particles are kept, which are no more than that.
const CELLS_PER_PARTICLE: usize = CELLS_OF_BRICK;
const MOST_CELLS: usize = 1 << 27;
const FEW_CELLS: usize = 1 << 16;
/// Tiles at most along an axis, so that numbers of cells have 63 bits. Places of 32 bits can hardly tell neighbours
/// apart where there are more; cells become larger then.
const MOST_TILES: f64 = (1 << 18) as f64;

/// The lattice of cells around all particles, and which particles each has.
#[derive(Clone, Debug, Default)]
pub struct Cells {
    /// Lower corner, metres.
    origin: DVec3,
    /// Cells per metre.
    per_metre: f64,
    tiles: IVec3,
    /// Of a wide lattice the bricks that have particles, in order: numbers among all bricks, 8 a tile.
    bricks: Option<Vec<u64>>,
    /// First particle of each cell that is kept, and the number of particles.
    starts: Vec<u32>,
    keys: Vec<u32>,
}

impl Cells {
    /// Lays the lattice around the positions (metres; finite) and writes into `order` which particle comes first,
    /// second...: old indices in the order of the cells.
    pub fn sort(&mut self, positions: &[DVec3], support_radius: f64, order: &mut Vec<u32>) {
        if self.enclose(positions, support_radius) {
            self.keep_bricks(positions);
        } else {
            self.bricks = None;
        }
        let mut keys = std::mem::take(&mut self.keys);
        let key = |&x| self.number(self.cell(x)).expect("the lattice is around all particles") as u32;
        positions.par_iter().map(key).collect_into_vec(&mut keys);
        self.keys = keys;
        self.count(order);
    }

    /// Sorts by the keys.
    fn count(&mut self, order: &mut Vec<u32>) {
        // Counted two cells on, so that what is added up are the beginnings one cell on, and after the sort those of
        // each cell.
        let cells = self.numbers();
        self.starts.clear();
        self.starts.resize(cells + 2, 0);
        for &key in &self.keys {
            self.starts[key as usize + 2] += 1;
        }
        let mut end = 0;
        for start in &mut self.starts {
            end += *start;
            *start = end;
        }
        order.resize(self.keys.len(), 0);
        for (particle, &key) in self.keys.iter().enumerate() {
            let place = &mut self.starts[key as usize + 1];
            order[*place as usize] = particle as u32;
            *place += 1;
        }
        self.starts.truncate(cells + 1);
    }

    /// Lays the lattice around the positions. Whether it is wide: all of its cells would be too many.
    fn enclose(&mut self, positions: &[DVec3], support_radius: f64) -> bool {
        let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (min, max) = positions
            .par_iter()
            .fold(|| nothing, |(min, max), &x| (min.min(x), max.max(x)))
            .reduce(|| nothing, |a, b| (a.0.min(b.0), a.1.max(b.1)));
        let (min, max) = if positions.is_empty() { (DVec3::ZERO, DVec3::ZERO) } else { (min, max) };
        let mut size = support_radius;
        let tiles = |size: f64| ((max - min) / (size * f64::from(TILE))).floor() + 1.0;
        while tiles(size).max_element() > MOST_TILES {
            size *= 2.0;
        }
        self.per_metre = 1.0 / size;
        self.tiles = tiles(size).as_ivec3();
        // In the middle, so that the outer tiles are filled alike.
        let cells = ((max - min) / size).floor() + 1.0;
        let spare = f64::from(TILE) * tiles(size) - cells;
        self.origin = min - size * (0.5 * spare).floor();
        let most = (CELLS_PER_PARTICLE * positions.len()).clamp(FEW_CELLS, MOST_CELLS) as f64;
        tiles(size).element_product() * CELLS_OF_TILE as f64 > most
    }

    /// Keeps the bricks that have particles.
    fn keep_bricks(&mut self, positions: &[DVec3]) {
        let mut bricks = self.bricks.take().unwrap_or_default();
        let brick = |&x: &DVec3| self.number_of_all(self.cell(x)) / CELLS_OF_BRICK as u64;
        positions.par_iter().map(brick).collect_into_vec(&mut bricks);
        // Few are left before the sort: the particles have the order of the last step.
        bricks.dedup();
        bricks.par_sort_unstable();
        bricks.dedup();
        self.bricks = Some(bricks);
    }

    /// The cell of a point of the lattice.
    #[inline]
    pub fn cell(&self, point: DVec3) -> IVec3 {
        ((point - self.origin) * self.per_metre).as_ivec3().clamp(IVec3::ZERO, self.tiles * TILE - 1)
    }

    /// The particles of a cell; none outside the lattice.
    #[inline]
    pub fn particles(&self, cell: IVec3) -> std::ops::Range<usize> {
        if cell.cmplt(IVec3::ZERO).any() || cell.cmpge(self.tiles * TILE).any() {
            return 0..0;
        }
        match self.number(cell) {
            Some(number) => self.starts[number] as usize..self.starts[number + 1] as usize,
            None => 0..0,
        }
    }

    /// How many cells are kept; their numbers go up to that.
    pub(crate) fn numbers(&self) -> usize {
        match &self.bricks {
            Some(bricks) => bricks.len() * CELLS_OF_BRICK,
            None => self.tiles.element_product() as usize * CELLS_OF_TILE,
        }
    }

    /// How many cells from a multiple of that number on are surely a cube.
    pub(crate) fn largest_cube(&self) -> usize {
        if self.bricks.is_some() { CELLS_OF_BRICK } else { CELLS_OF_TILE }
    }

    /// The particles of cells that follow each other.
    #[inline]
    pub(crate) fn particles_of(&self, numbers: std::ops::Range<usize>) -> std::ops::Range<usize> {
        self.starts[numbers.start] as usize..self.starts[numbers.end] as usize
    }

    /// The cell of a number.
    #[inline]
    pub(crate) fn cell_of(&self, number: usize) -> IVec3 {
        let number = match &self.bricks {
            Some(bricks) => {
                bricks[number / CELLS_OF_BRICK] * CELLS_OF_BRICK as u64 + (number % CELLS_OF_BRICK) as u64
            }
            None => number as u64,
        };
        let (tile, within) = (number / CELLS_OF_TILE as u64, number % CELLS_OF_TILE as u64);
        let bits = |shift: usize| {
            let bit = |n: usize| (within >> (3 * n + shift) & 1) << n;
            (bit(0) | bit(1) | bit(2)) as i32
        };
        let [x, y] = [self.tiles.x as u64, self.tiles.y as u64];
        let tile = IVec3::new((tile % x) as i32, (tile / x % y) as i32, (tile / (x * y)) as i32);
        TILE * tile + IVec3::new(bits(0), bits(1), bits(2))
    }

    /// The number of a cell of the lattice, if it is kept.
    #[inline]
    fn number(&self, cell: IVec3) -> Option<usize> {
        match &self.bricks {
            None => Some(self.number_of_all(cell) as usize),
            Some(bricks) => number_of_kept(bricks, self.number_of_all(cell)),
        }
    }

    /// The number that a cell of the lattice has if all are kept.
    #[inline]
    fn number_of_all(&self, cell: IVec3) -> u64 {
        let tile: IVec3 = cell >> 3;
        let within = cell - tile * TILE;
        let [x, y] = [self.tiles.x as u64, self.tiles.y as u64];
        let tile = (tile.z as u64 * y + tile.y as u64) * x + tile.x as u64;
        tile * CELLS_OF_TILE as u64 + z_order(within) as u64
    }
}

/// From the number among all cells to that among those of some bricks.
fn number_of_kept(bricks: &[u64], number: u64) -> Option<usize> {
    let brick = bricks.binary_search(&(number / CELLS_OF_BRICK as u64)).ok()?;
    Some(brick * CELLS_OF_BRICK + number as usize % CELLS_OF_BRICK)
}

/// The bits of three numbers below 8, interleaved.
#[inline]
fn z_order(within: IVec3) -> usize {
    const SPREAD: [usize; 8] = [0, 1, 8, 9, 64, 65, 72, 73];
    SPREAD[within.x as usize] | SPREAD[within.y as usize] << 1 | SPREAD[within.z as usize] << 2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::neighbours::tests::random_points;

    /// Every particle is in one cell's range, the ranges are in order, and of equal cells the first comes first.
    fn check(positions: &[DVec3], radius: f64) -> Cells {
        let (mut cells, mut order) = (Cells::default(), Vec::new());
        cells.sort(positions, radius, &mut order);
        let mut all = order.clone();
        all.sort_unstable();
        assert!(all.iter().copied().eq(0..positions.len() as u32), "an order of all");
        let numbers: Vec<usize> =
            order.iter().map(|&i| cells.number(cells.cell(positions[i as usize])).unwrap()).collect();
        let in_order = |n: usize| (numbers[n - 1], order[n - 1]) < (numbers[n], order[n]);
        assert!((1..order.len()).all(in_order), "sorted by cells, then as before");
        for (place, &i) in order.iter().enumerate() {
            let cell = cells.cell(positions[i as usize]);
            assert!(cells.particles(cell).contains(&place));
            assert_eq!(cells.cell_of(cells.number(cell).unwrap()), cell);
        }
        assert_eq!(*cells.starts.last().unwrap() as usize, positions.len());
        cells
    }

    #[test]
    fn sort_is_complete_and_stable() {
        for count in [0, 1, 2, 255, 3000] {
            let near = check(&random_points(count, 1.7, 5), 0.1);
            assert!(count == 0 || near.per_metre == 10.0);
            let shift = DVec3::new(1e5, -1e5, 1e5);
            let far: Vec<DVec3> = random_points(count, 1.7, 5).iter().map(|x| *x + shift).collect();
            assert_eq!(check(&far, 0.1).tiles, near.tiles);
        }
        check(&[DVec3::splat(0.3); 700], 0.1);
    }

    #[test]
    fn wide_lattices_keep_what_has_particles() {
        for width in [1e2, 1e4, 1e5] {
            let mut positions = random_points(3000, 1.0, 6);
            positions.push(DVec3::splat(width));
            let cells = check(&positions, 0.1);
            assert_eq!(cells.per_metre, 10.0, "cells are as large as the radius");
            // A cube of 1 m meets at most 4 bricks of 0.4 m along an axis.
            assert!(cells.starts.len() <= (64 + 1) * CELLS_OF_BRICK + 1, "{}", cells.starts.len());
        }
    }

    #[test]
    fn the_order_is_that_of_all_cells() {
        let positions = random_points(2000, 2.9, 9);
        let (mut cells, mut order) = (check(&positions, 0.1), Vec::new());
        assert!(cells.bricks.is_none());
        let mut all = Vec::new();
        cells.sort(&positions, 0.1, &mut all);
        cells.keep_bricks(&positions);
        let key = |x: &DVec3| cells.number(cells.cell(*x)).unwrap() as u32;
        cells.keys = positions.iter().map(key).collect();
        cells.count(&mut order);
        assert!(order == all && cells.starts.len() < 100 * CELLS_OF_TILE);
    }

    #[test]
    fn lattices_without_an_end_get_larger_cells() {
        let mut positions = random_points(300, 1.0, 6);
        for width in [1e9, 1e12] {
            positions.push(DVec3::splat(width));
            let cells = check(&positions, 0.1);
            assert!(cells.starts.len() <= positions.len() * CELLS_OF_BRICK + 1 && cells.per_metre < 10.0);
            assert!(cells.tiles.max_element() as f64 <= MOST_TILES);
        }
    }

    #[test]
    fn nothing_is_outside() {
        let cells = check(&random_points(100, 1.0, 7), 0.1);
        for outside in [IVec3::new(-1, 0, 0), cells.tiles * TILE, IVec3::new(0, i32::MAX, 0)] {
            assert!(cells.particles(outside).is_empty());
        }
    }
}
