//! Particles sorted by cells of the support radius, so that those near in space are near in memory.
//!
//! Cells stand in tiles of 8 x 8 x 8 along a z-order curve (Ihmsen et al. 2011, *A Parallel SPH Implementation on
//! Multi-Core CPUs*); tiles row by row, x fastest. The sort counts, is stable, and so the same on any number of threads.

use glam::IVec3;
use rayon::prelude::*;
use volmap_runtime::DVec3;

/// Cells along an edge of a tile.
const TILE: i32 = 8;
const CELLS_OF_TILE: usize = (TILE * TILE * TILE) as usize;
/// Cells at most: memory of 4 bytes each. Where a wide domain would need more, they become larger.
const MOST_CELLS: f64 = (1u64 << 27) as f64;

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
        self.starts.clear();
        self.starts.resize(self.tiles.element_product() as usize * CELLS_OF_TILE + 1, 0);
        for &key in &keys {
            self.starts[key as usize] += 1;
        }
        let mut first = 0;
        for start in &mut self.starts {
            first += std::mem::replace(start, first);
        }
        order.resize(positions.len(), 0);
        for (particle, &key) in keys.iter().enumerate() {
            let place = &mut self.starts[key as usize];
            order[*place as usize] = particle as u32;
            *place += 1;
        }
        // Each start has moved to the next one's place.
        self.starts.rotate_right(1);
        self.starts[0] = 0;
        self.keys = keys;
    }

    fn enclose(&mut self, positions: &[DVec3], support_radius: f64) {
        let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (min, max) = positions
            .par_iter()
            .fold(|| nothing, |(min, max), &x| (min.min(x), max.max(x)))
            .reduce(|| nothing, |a, b| (a.0.min(b.0), a.1.max(b.1)));
        let (min, max) = if positions.is_empty() { (DVec3::ZERO, DVec3::ZERO) } else { (min, max) };
        let mut size = support_radius;
        let tiles = |size: f64| ((max - min) / (size * f64::from(TILE))).floor() + 1.0;
        while tiles(size).element_product() * CELLS_OF_TILE as f64 > MOST_CELLS {
            size *= 2.0;
        }
        self.origin = min;
        self.per_metre = 1.0 / size;
        self.tiles = tiles(size).as_ivec3();
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
