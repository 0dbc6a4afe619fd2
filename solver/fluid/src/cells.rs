//! Particles sorted by cells of the support radius, so that those near in space are near in memory.
//!
//! Cells stand in tiles of 8 x 8 x 8 along a z-order curve (Ihmsen et al. 2011, *A Parallel SPH Implementation on
//! Multi-Core CPUs*); tiles row by row, x fastest. The sort counts, is stable, and so the same on any number of
//! threads.

use glam::IVec3;
use rayon::prelude::*;
use volmap_runtime::DVec3;

/// Cells along an edge of a tile.
const TILE: i32 = 8;
pub(crate) const CELLS_OF_TILE: usize = (TILE * TILE * TILE) as usize;
/// Cells at most for each particle, and at most and at least of all: 4 bytes and a visit in every step each. Where a
/// wide domain would need more, they become larger.
const CELLS_PER_PARTICLE: usize = 64;
const MOST_CELLS: usize = 1 << 27;
const FEW_CELLS: usize = 1 << 16;

/// The lattice of cells around all particles, and which particles each has.
#[derive(Clone, Debug, Default)]
pub struct Cells {
    /// Lower corner, metres.
    origin: DVec3,
    /// Cells per metre.
    per_metre: f64,
    tiles: IVec3,
    /// First particle of each cell, and the number of particles.
    starts: Vec<u32>,
    keys: Vec<u32>,
}

impl Cells {
    /// Lays the lattice around the positions (metres; finite) and writes into `order` which particle comes first,
    /// second...: old indices in the order of the cells.
    pub fn sort(&mut self, positions: &[DVec3], support_radius: f64, order: &mut Vec<u32>) {
        self.enclose(positions, support_radius);
        let mut keys = std::mem::take(&mut self.keys);
        positions.par_iter().map(|&x| self.number(self.cell(x)) as u32).collect_into_vec(&mut keys);
        // Counted two cells on, so that what is added up are the beginnings one cell on, and after the sort those of
        // each cell.
        let cells = self.tiles.element_product() as usize * CELLS_OF_TILE;
        self.starts.clear();
        self.starts.resize(cells + 2, 0);
        for &key in &keys {
            self.starts[key as usize + 2] += 1;
        }
        let mut end = 0;
        for start in &mut self.starts {
            end += *start;
            *start = end;
        }
        order.resize(positions.len(), 0);
        for (particle, &key) in keys.iter().enumerate() {
            let place = &mut self.starts[key as usize + 1];
            order[*place as usize] = particle as u32;
            *place += 1;
        }
        self.starts.truncate(cells + 1);
        self.keys = keys;
    }

    fn enclose(&mut self, positions: &[DVec3], support_radius: f64) {
        let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (min, max) = positions
            .par_iter()
            .fold(|| nothing, |(min, max), &x| (min.min(x), max.max(x)))
            .reduce(|| nothing, |a, b| (a.0.min(b.0), a.1.max(b.1)));
        let (min, max) = if positions.is_empty() { (DVec3::ZERO, DVec3::ZERO) } else { (min, max) };
        let most = (CELLS_PER_PARTICLE * positions.len()).clamp(FEW_CELLS, MOST_CELLS) as f64;
        let mut size = support_radius;
        let tiles = |size: f64| ((max - min) / (size * f64::from(TILE))).floor() + 1.0;
        while tiles(size).element_product() * CELLS_OF_TILE as f64 > most {
            size *= 2.0;
        }
        self.per_metre = 1.0 / size;
        self.tiles = tiles(size).as_ivec3();
        // In the middle, so that the outer tiles are filled alike.
        let cells = ((max - min) / size).floor() + 1.0;
        let spare = f64::from(TILE) * tiles(size) - cells;
        self.origin = min - size * (0.5 * spare).floor();
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
        let number = self.number(cell);
        self.starts[number] as usize..self.starts[number + 1] as usize
    }

    /// How many tiles there are.
    pub(crate) fn tiles(&self) -> usize {
        self.tiles.element_product() as usize
    }

    /// The particles of cells that follow each other.
    #[inline]
    pub(crate) fn particles_of(&self, numbers: std::ops::Range<usize>) -> std::ops::Range<usize> {
        self.starts[numbers.start] as usize..self.starts[numbers.end] as usize
    }

    /// The cell of a number.
    #[inline]
    pub(crate) fn cell_of(&self, number: usize) -> IVec3 {
        let (tile, within) = ((number / CELLS_OF_TILE) as i32, number % CELLS_OF_TILE);
        let bits = |shift: usize| {
            let bit = |n: usize| (within >> (3 * n + shift) & 1) << n;
            (bit(0) | bit(1) | bit(2)) as i32
        };
        let tile = IVec3::new(
            tile % self.tiles.x,
            tile / self.tiles.x % self.tiles.y,
            tile / (self.tiles.x * self.tiles.y),
        );
        TILE * tile + IVec3::new(bits(0), bits(1), bits(2))
    }

    #[inline]
    fn number(&self, cell: IVec3) -> usize {
        let tile: IVec3 = cell >> 3;
        let within = cell - tile * TILE;
        let tile = (tile.z * self.tiles.y + tile.y) * self.tiles.x + tile.x;
        tile as usize * CELLS_OF_TILE + z_order(within)
    }
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
            order.iter().map(|&i| cells.number(cells.cell(positions[i as usize]))).collect();
        let in_order = |n: usize| (numbers[n - 1], order[n - 1]) < (numbers[n], order[n]);
        assert!((1..order.len()).all(in_order), "sorted by cells, then as before");
        for (place, &i) in order.iter().enumerate() {
            let cell = cells.cell(positions[i as usize]);
            assert!(cells.particles(cell).contains(&place));
            assert_eq!(cells.cell_of(cells.number(cell)), cell);
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
    fn wide_domains_get_larger_cells() {
        let mut positions = random_points(300, 1.0, 6);
        for width in [1e2, 1e5, 1e12] {
            positions.push(DVec3::splat(width));
            let cells = check(&positions, 0.1);
            assert!(cells.starts.len() <= FEW_CELLS + 1 && 1.0 / cells.per_metre >= 0.1);
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
