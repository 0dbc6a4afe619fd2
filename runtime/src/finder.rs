//! What sets uniform and adaptive maps apart in a query: how a cell is found, and how the element's values become the
//! map's. The code of a query is compiled for each, so that the one doesn't pay for the other.

use crate::lanes::{LANES, Lanes};
use crate::layout::{CellIndex, Found, Hint, Place, Starts};
use glam::{DVec3, UVec3};

/// Finds the stored cells of a map.
pub(crate) trait Finder {
    /// What was found last: the next point's, often.
    type Hint;
    type Frame<V: Lanes>: Frame<V>;

    /// A hint that fits no cell.
    fn hint(&self) -> Self::Hint;
    /// What is known of a place in a cell of the map's grid. `f` is the place in the cell, 0 to 1 along each axis, and
    /// becomes that in the stored cell.
    fn place(&self, cell: UVec3, f: &mut DVec3, hint: &mut Self::Hint) -> Found;
    fn starts(&self, place: Place) -> Starts;
    /// For four points at `f` in their cells. `per_cell` is that of the map's grid.
    fn frame<V: Lanes>(&self, per_cell: DVec3, places: &[Place; LANES], f: &[V; 3]) -> Self::Frame<V>;
}

/// From the element's values in the cells of four points to the map's.
pub(crate) trait Frame<V: Lanes> {
    /// What a flat wall adds.
    type Wall: Copy;

    /// Derivatives with respect to the place in the cell become those with respect to the point by these factors.
    fn per_cell(&self) -> [V; 3];
    fn wall(&self, distance: V) -> Self::Wall;
    /// The volume, from what is stored for it.
    fn volume(&self, wall: Self::Wall, stored: V) -> V;
    /// The volume's derivatives, from those of what is stored for it and of the distance.
    fn volume_slope(&self, wall: Self::Wall, stored: [V; 3], distance: [V; 3]) -> [V; 3];
}

impl Finder for CellIndex {
    type Hint = Hint;
    type Frame<V: Lanes> = Plainly<V>;

    #[inline(always)]
    fn hint(&self) -> Hint {
        CellIndex::hint(self)
    }

    #[inline(always)]
    fn place(&self, cell: UVec3, _: &mut DVec3, hint: &mut Hint) -> Found {
        CellIndex::place(self, cell, hint)
    }

    #[inline(always)]
    fn starts(&self, place: Place) -> Starts {
        CellIndex::starts(self, place)
    }

    #[inline(always)]
    fn frame<V: Lanes>(&self, per_cell: DVec3, _: &[Place; LANES], _: &[V; 3]) -> Plainly<V> {
        Plainly([V::splat(per_cell.x), V::splat(per_cell.y), V::splat(per_cell.z)])
    }
}

/// The volume is stored as it is, in cells of one size.
pub(crate) struct Plainly<V>([V; 3]);

impl<V: Lanes> Frame<V> for Plainly<V> {
    type Wall = ();

    #[inline(always)]
    fn per_cell(&self) -> [V; 3] {
        self.0
    }

    #[inline(always)]
    fn wall(&self, _: V) {}

    #[inline(always)]
    fn volume(&self, (): (), stored: V) -> V {
        stored
    }

    #[inline(always)]
    fn volume_slope(&self, (): (), stored: [V; 3], _: [V; 3]) -> [V; 3] {
        stored
    }
}
