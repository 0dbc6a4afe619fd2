//! The fine lattice on which all nodes and test points of all levels lie, as integers: their keys are exact.

use super::probes::{self, PROBES};
use glam::{DVec3, IVec3, UVec3};
use std::hash::{Hash, Hasher};
use volmap_runtime::Grid;
use volmap_runtime::layout::serendipity::{NODES, THIRDS};

/// Bits of a coordinate in a key.
const BITS: u32 = 21;

/// A point of the lattice, by its coordinates' bits in turn (Morton 1966): points with near keys lie close together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key(u64);

impl Hash for Key {
    /// Points of coarse levels differ in their high bits only; a hash that multiplies would put them all in few places.
    fn hash<H: Hasher>(&self, state: &mut H) {
        let folded = (self.0 ^ self.0 >> 32).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        state.write_u64(folded ^ folded >> 29);
    }
}

/// A cell of a level: (i, j, k) on the lattice of cells of cell_size / 2^level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LevelCell {
    /// 0 for the cells of the grid.
    pub level: u32,
    /// Indices along x, y and z.
    pub at: UVec3,
}

/// Thirds of a quarter of a cell of the finest level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FineLattice {
    grid: Grid,
    finest: u32,
    /// Points of the lattice along an edge of a cell of level 0, as a number.
    per_cell: f64,
}

/// The cells of a grid, x fastest.
pub fn indices(resolution: UVec3) -> impl Iterator<Item = UVec3> {
    let [x, y, z] = resolution.to_array();
    (0..z).flat_map(move |k| (0..y).flat_map(move |j| (0..x).map(move |i| UVec3::new(i, j, k))))
}

impl FineLattice {
    /// For levels 0 ..= `finest` of cells over a grid; none where the keys' bits don't suffice.
    pub fn new(grid: Grid, finest: u32) -> Option<FineLattice> {
        let per_cell = 12u64 << finest;
        let fits = u64::from(grid.resolution.max_element()) * per_cell < 1 << BITS;
        fits.then_some(FineLattice { grid, finest, per_cell: per_cell as f64 })
    }

    /// The finest level.
    pub fn finest(&self) -> u32 {
        self.finest
    }

    /// The grid of level 0.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Edges of the cells of a level, metres.
    pub fn cell_size(&self, level: u32) -> DVec3 {
        self.grid.cell_size / f64::from(1 << level)
    }

    /// From a cell's centre to its corners, metres, and a little more for rounding: Phi, which is 1-Lipschitz, changes by
    /// no more in the cell.
    pub fn reach(&self, level: u32) -> f64 {
        0.5 * self.cell_size(level).length() * (1.0 + 1e-9)
    }

    /// A cell's midpoint.
    pub fn center_key(&self, cell: LevelCell) -> Key {
        Key::new((3 << (self.finest - cell.level)) * (4 * cell.at + 2))
    }

    /// A cell's centre, metres.
    pub fn center(&self, cell: LevelCell) -> DVec3 {
        self.grid.origin + self.cell_size(cell.level) * (cell.at.as_dvec3() + 0.5)
    }

    /// Place of a point, metres.
    pub fn position(&self, key: Key) -> DVec3 {
        self.grid.origin + self.grid.cell_size * (key.coordinates().as_dvec3() / self.per_cell)
    }

    /// The point at a place that is one, but for rounding.
    pub fn key_at(&self, place: DVec3) -> Key {
        Key::new(((place - self.grid.origin) / self.grid.cell_size * self.per_cell).round().as_uvec3())
    }

    /// A cell's 32 nodes, in the order of the element.
    pub fn nodes(&self, cell: LevelCell) -> [Key; NODES] {
        let step = 4 << (self.finest - cell.level);
        THIRDS.map(|third| Key::new(step * (3 * cell.at + UVec3::from(third.map(u32::from)))))
    }

    /// Where it is judged, in the order of [`PROBES`].
    pub fn probes(&self, cell: LevelCell) -> [Key; probes::COUNT] {
        let step = 3 << (self.finest - cell.level);
        PROBES.map(|quarter| Key::new(step * (4 * cell.at + UVec3::from(quarter.map(u32::from)))))
    }
}

impl LevelCell {
    /// Puts cells in an order that doesn't depend on threads, each once.
    pub fn sort(cells: &mut Vec<LevelCell>) {
        cells.sort_unstable_by_key(|cell| (cell.level, cell.at.z, cell.at.y, cell.at.x));
        cells.dedup();
    }

    /// The eight cells that it is split into, x fastest.
    pub fn children(self) -> [LevelCell; 8] {
        std::array::from_fn(|n| LevelCell {
            level: self.level + 1,
            at: 2 * self.at + UVec3::new(n as u32 & 1, n as u32 >> 1 & 1, n as u32 >> 2),
        })
    }

    /// The places around it on its level, in a grid with so many cells of level 0, each with the step from here.
    pub fn around(self, resolution: UVec3) -> impl Iterator<Item = (IVec3, LevelCell)> {
        let size = (resolution << self.level).as_ivec3();
        let steps = (0..27).map(|n| IVec3::new(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1));
        steps.filter(|step| *step != IVec3::ZERO).filter_map(move |step| {
            let at = self.at.as_ivec3() + step;
            let inside = at.cmpge(IVec3::ZERO).all() && at.cmplt(size).all();
            inside.then(|| (step, LevelCell { level: self.level, at: at.as_uvec3() }))
        })
    }

    /// The cell that it is a part of.
    pub fn parent(self) -> LevelCell {
        LevelCell { level: self.level - 1, at: self.at / 2 }
    }
}

impl Key {
    fn new(at: UVec3) -> Key {
        Key(spread(at.x) | spread(at.y) << 1 | spread(at.z) << 2)
    }

    fn coordinates(self) -> UVec3 {
        UVec3::new(gather(self.0), gather(self.0 >> 1), gather(self.0 >> 2))
    }
}

/// The low 21 bits, two zeros behind each.
fn spread(n: u32) -> u64 {
    let mut x = u64::from(n) & 0x1f_ffff;
    x = (x | x << 32) & 0x1f_0000_0000_ffff;
    x = (x | x << 16) & 0x1f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

/// Every third bit.
fn gather(bits: u64) -> u32 {
    let mut x = bits & 0x1249_2492_4924_9249;
    x = (x | x >> 2) & 0x10c3_0c30_c30c_30c3;
    x = (x | x >> 4) & 0x100f_00f0_0f00_f00f;
    x = (x | x >> 8) & 0x1f_0000_ff00_00ff;
    x = (x | x >> 16) & 0x1f_0000_0000_ffff;
    (x | x >> 32) as u32 & 0x1f_ffff
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_give_their_coordinates_back() {
        for at in
            [UVec3::ZERO, UVec3::new(1, 2, 3), UVec3::new(2_097_151, 77, 1 << 20), UVec3::splat(2_097_151)]
        {
            assert_eq!(Key::new(at).coordinates(), at);
        }
    }

    #[test]
    fn nodes_of_a_child_that_are_its_parents_have_the_parents_keys() {
        let grid = Grid { origin: DVec3::ZERO, cell_size: DVec3::ONE, resolution: UVec3::splat(3) };
        let lattice = FineLattice::new(grid, 4).unwrap();
        let cell = LevelCell { level: 1, at: UVec3::new(3, 1, 4) };
        let child = cell.children()[0];
        assert_eq!(child.parent(), cell);
        assert_eq!(lattice.nodes(child)[0], lattice.nodes(cell)[0]);
        // The upper corner of the first child is the cell's midpoint; the last child's midpoint is the last probe.
        assert_eq!(lattice.nodes(child)[7], lattice.center_key(cell));
        assert_eq!(lattice.center_key(cell.children()[7]), lattice.probes(cell)[26]);
        assert_eq!(lattice.position(lattice.nodes(child)[7]), lattice.center(cell));
        assert_eq!(lattice.key_at(lattice.center(cell)), lattice.nodes(child)[7]);
    }
}
